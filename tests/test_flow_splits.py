"""Runs through places where the declared velocities are no frame, or the split is singular there.

The truth comes from the equations with multipliers, differentiated once and integrated in all
velocities: M q'' - A^T lambda = Q - h, A q'' = -b.  They know neither frame nor split.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from dataclasses import replace
from random import Random
from typing import Any

import mpmath
import numpy as np
import pytest
import scipy.integrate
import symengine as se
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo
from voronec import velocity
from voronec.motion import methods
from voronec.motion.divisors import around, crossing_divisors, divisors

pytestmark = pytest.mark.slow


def multiplier_motion(system: vo.System, start: Mapping[str, float], times: np.ndarray) -> Any:
    """Coordinates (N, k) at times (k,), from coordinates and all their velocities by name."""
    q, dots = system.coordinates, [velocity(x) for x in system.coordinates]
    frame = system.frame
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    meaning |= {p.symbol: sp.N(p.value) for p in system.parameters}

    def spelled(expr: Any) -> sp.Expr:
        return sp.sympify(expr).xreplace(meaning).xreplace(meaning)

    energy = spelled(system.lagrangian)
    slips = [spelled(c) for c in system.constraints]
    slips += [
        sum(sp.diff(r, x) * v for x, v in zip(q, dots, strict=True))
        for r in map(spelled, system.fibration.relations)
    ]
    momenta = [sp.diff(energy, v) for v in dots]

    def drift(expr: Any) -> sp.Expr:
        return sp.Add(*(sp.diff(expr, x) * v for x, v in zip(q, dots, strict=True)))

    parts = [
        sp.Matrix(momenta).jacobian(dots),
        sp.Matrix([drift(p) - sp.diff(energy, x) for p, x in zip(momenta, q, strict=True)]),
        sp.Matrix(slips).jacobian(dots),
        sp.Matrix([drift(c) for c in slips]),
    ]
    names = sp.symbols(f"z0:{2 * len(q)}")
    plain = dict(zip((*dots, *q), (*names[len(q) :], *names[: len(q)]), strict=True))
    function = sp.lambdify([names], [part.xreplace(plain) for part in parts], cse=True)

    def rhs(_time: float, state: np.ndarray) -> np.ndarray:
        mass, force, rows, rest = (np.array(x, dtype=float) for x in function(state))
        whole = np.block([[mass, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
        found = np.linalg.solve(whole, -np.vstack([force, rest]))[:, 0]
        return np.concatenate([state[len(q) :], found[: len(q)]])

    first = [start.get(str(x), 0.0) for x in q] + [start[f"{x}dot"] for x in q]
    found = solve_ivp(rhs, (times[0], times[-1]), first, "DOP853", times, rtol=2.3e-14, atol=1e-14)
    return found.y[: len(q)]


def all_velocities(system: vo.System, start: Mapping[str, float]) -> dict[str, float]:
    """The start with the velocities of all coordinates, by linear algebra on the declarations."""
    dots = [velocity(x) for x in system.coordinates]
    frame = system.frame
    given = {p.symbol: sp.N(p.value) for p in system.parameters}
    given |= {x: sp.Float(start.get(str(x), 0)) for x in system.coordinates}
    rows = list(system.constraints)
    rows += [
        sp.Add(*(sp.diff(r, x) * velocity(x) for x in system.coordinates))
        for r in system.fibration.relations
    ]
    if frame is not None:
        pairs = zip(frame.velocities, frame.expressions, strict=True)
        rows += [e - sp.Float(start[str(v)]) for v, e in pairs]
    else:
        rows += [velocity(x) - sp.Float(start[f"{x}dot"]) for x in system.fibration.base]
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    plain = sp.Matrix([sp.sympify(r).xreplace(meaning).xreplace(given) for r in rows])
    matrix = np.array(plain.jacobian(dots), dtype=float)
    right = -np.array(plain.xreplace(dict.fromkeys(dots, sp.Integer(0))), dtype=float)[:, 0]
    found = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return {**start, **{f"{x}dot": v for x, v in zip(system.coordinates, found, strict=True)}}


def worst(run: vo.Trajectory, truth: np.ndarray) -> float:
    """The largest error of a coordinate."""
    names = [str(x) for x in run.system.coordinates]
    found = np.array([run[name].astype(float) for name in names])
    return float(np.abs(found - truth).max())


x, y, phi, psi, theta = sp.symbols("x y phi psi theta")
m, inertia, J, R, a, b = (vo.Parameter(s, v, positive=True) for s, v in zip(
    sp.symbols("m I J R a b"), (1.0, 0.5, 0.25, 0.75, 0.625, 0.375), strict=True))  # fmt: skip


def unicycle() -> vo.System:
    """On an inclined plane; split by x', which says nothing where it heads along y."""
    slip = velocity(x) * sp.sin(phi) - velocity(y) * sp.cos(phi)
    roll = velocity(x) * sp.cos(phi) + velocity(y) * sp.sin(phi) - R.symbol * velocity(psi)
    energy = m.symbol * (velocity(x) ** 2 + velocity(y) ** 2) + inertia.symbol * velocity(phi) ** 2
    return vo.System(
        name="unicycle",
        fibration=vo.Fibration(base=(x, phi), fibre=(y, psi)),
        lagrangian=(energy + J.symbol * velocity(psi) ** 2) / 2 - m.symbol * y / 5,
        constraints=(slip, roll),
        parameters=(m, inertia, J, R),
    )


def trailer() -> vo.System:
    """A car with a trailer, split by x' as well."""
    behind = (x - a.symbol * sp.cos(psi), y - a.symbol * sp.sin(psi))
    u, v = (sp.diff(z, x) * velocity(x) + sp.diff(z, y) * velocity(y)
            + sp.diff(z, psi) * velocity(psi) for z in behind)  # fmt: skip
    energy = m.symbol * (velocity(x) ** 2 + velocity(y) ** 2) + inertia.symbol * velocity(phi) ** 2
    return vo.System(
        name="trailer",
        fibration=vo.Fibration(base=(x, phi), fibre=(y, psi)),
        lagrangian=(energy + (u**2 + v**2) / 2 + J.symbol * velocity(psi) ** 2) / 2,
        constraints=(
            velocity(x) * sp.sin(phi) - velocity(y) * sp.cos(phi),
            u * sp.sin(psi) - v * sp.cos(psi),
        ),
        parameters=(m, inertia, J, a),
    )


def roller_racer() -> vo.System:
    """Two bodies with an axle each; (v, w) are no frame where the axles meet in one point."""
    v, w = sp.symbols("v w")
    ahead = theta + phi
    behind = [
        x - a.symbol * sp.cos(theta) - b.symbol * sp.cos(ahead),
        y - a.symbol * sp.sin(theta) - b.symbol * sp.sin(ahead),
    ]
    q = (x, y, theta, phi)
    slide = [sp.Add(*(sp.diff(z, s) * velocity(s) for s in q)) for z in behind]
    turning = (
        inertia.symbol * velocity(theta) ** 2 + J.symbol * (velocity(theta) + velocity(phi)) ** 2
    )
    return vo.System(
        name="roller-racer",
        fibration=vo.Fibration(base=(x, phi), fibre=(y, theta)),
        frame=vo.Frame.quasi(
            {v: velocity(x) * sp.cos(theta) + velocity(y) * sp.sin(theta), w: velocity(phi)}
        ),
        lagrangian=m.symbol * (velocity(x) ** 2 + velocity(y) ** 2) / 2 + turning / 2,
        constraints=(
            velocity(x) * sp.sin(theta) - velocity(y) * sp.cos(theta),
            slide[0] * sp.sin(ahead) - slide[1] * sp.cos(ahead),
        ),
        parameters=(m, inertia, J, a, b),
    )


MADE = {
    "unicycle": (unicycle, {"phi": 0.25, "xdot": 0.5, "phidot": 0.875}),
    "trailer": (trailer, {"phi": 0.25, "psi": 0.125, "xdot": 0.5, "phidot": 0.75}),
    "roller racer": (roller_racer, {"theta": 0.25, "phi": 0.5, "v": 0.5, "w": 1.125}),
}
KNOWN = {
    "rubber-ball-on-plane": {"u": 1.25, "v": 0.75, "omega1": 0.25, "omega2": 0.5},
    "gyroscopic-rubber-ball-on-plane": {"u": 1.25, "v": 0.75, "omega1": 0.25, "omega2": 0.5},
    "displaced-rubber-ball": {"u": 1.25, "v": 0.75, "omega1": 0.25, "omega2": 0.5},
    "veselova": {"theta": 1.25, "psi": 0.75, "omega1": 0.5, "omega2": 0.25},
    "veselova-in-new-time": {
        "gamma1": 0.6, "gamma2": 0.64, "gamma3": 0.48, "Omega1": 0.5, "Omega2": 0.75,
    },
}  # fmt: skip
METHODS = (("scipy", 1e-13), ("heyoka", 1e-16), ("flint", 1e-20))


@pytest.mark.parametrize("name", MADE)
def test_a_run_passes_where_its_split_is_singular(name: str) -> None:
    make, start = MADE[name]
    system = make()
    whole = all_velocities(system, start)
    for end, points in ((8.0, 2), (-8.0, 41)):
        times = np.linspace(0.0, end, points)
        truth = multiplier_motion(system, whole, times)
        for method, tol in METHODS if points == 2 else METHODS[:1]:
            run = vo.integrate(system, times=times, initial=start, method=method, tol=tol)
            assert worst(run, truth) < 1e-10, (method, tol)
            assert run.cost.switches > 0


@pytest.mark.parametrize("name", KNOWN)
def test_rolling_without_twist_passes_the_equator(name: str) -> None:
    equations, start = vo.derive(vo.load(name)), KNOWN[name]
    whole = all_velocities(equations.system, start)
    times = np.linspace(0.0, -9.0, 4)
    truth = multiplier_motion(equations.system, whole, times)
    for method, tol in METHODS[:2]:
        run = vo.integrate(equations, times=times, initial=start, method=method, tol=tol)
        assert worst(run, truth) < 2e-10, (method, tol)
        assert max(run.drift.values()) < 1e-10


def test_many_changes_of_the_split_lose_no_digits() -> None:
    # near a great circle of the sphere one of gamma1, gamma2, gamma3 is small all the time
    equations = vo.derive(vo.load("veselova-in-new-time"))
    start = {
        "gamma1": 0.9359838133388113, "gamma2": -0.04610513487315119,
        "gamma3": 0.34901091344837026, "Omega1": -1.743, "Omega2": -0.096,
    }  # fmt: skip
    times = np.linspace(0.0, 64.68, 101)
    truth = multiplier_motion(equations.system, all_velocities(equations.system, start), times)
    for tol, drift in ((1e-10, 1e-9), (1e-13, 1e-11)):
        run = vo.integrate(equations, times=times, initial=start, method="heyoka", tol=tol)
        assert run.cost.switches > 100
        assert worst(run, truth) < 5e-8, tol  # the truth drifts by 1.2e-8
        assert max(run.drift.values()) < drift, tol


@pytest.mark.parametrize("tol", [1e-30, 1e-50])
def test_changes_of_the_split_lose_no_digits_in_any_precision(tol: float) -> None:
    """A skate that turns evenly draws a circle; the instants of its changes are no doubles."""
    x, y, phi = sp.symbols("x y phi")
    skate = vo.System(
        name="skate",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=sum(velocity(q) ** 2 for q in (x, y, phi)) / 2,
        constraints=(velocity(x) * sp.sin(phi) - velocity(y) * sp.cos(phi),),
    )
    start = {velocity(x): sp.Rational(8, 5), velocity(y): sp.Rational(6, 5), velocity(phi): 1}
    start[phi] = sp.asin(sp.Rational(3, 5))
    found = vo.integrate(skate, initial=start, times=np.linspace(0, 9, 7), tol=tol)
    assert found.cost.switches > 4
    with mpmath.workdps(60):
        angles = [mpmath.asin(mpmath.mpf(3) / 5) + mpmath.mpf(float(t)) for t in found.t]
        for place, angle in zip(found["x"], angles, strict=True):
            assert abs(place - 2 * (mpmath.sin(angle) - mpmath.mpf(3) / 5)) < 1e4 * tol


def test_a_split_is_made_where_those_that_are_ready_lose_digits() -> None:
    # two of gamma1, gamma2, gamma3 come to be small together, and large velocities with them
    start = {
        "gamma1": -0.9358224048678052, "gamma2": -0.2792373304847483,
        "gamma3": -0.21508821402203587, "Omega1": -1.175, "Omega2": -1.354,
    }  # fmt: skip
    moments = {"epsilon": 1.1621408890295972, "J1": 1.1150745407334046,
               "J2": 2.5833166080033196, "J3": 1.0629945006789887}  # fmt: skip
    run, sharp = (
        vo.integrate(
            vo.load("rubber-ball-in-new-time"), initial=start, parameters=moments,
            times=[0.0, 1.0, 3.94078], method=method, tol=tol,
        )
        for method, tol in (("scipy", 1e-13), ("flint", 1e-20))
    )  # fmt: skip
    assert max(run.drift.values()) < 5e-12
    for name in ("gamma1", "gamma2", "gamma3"):
        assert np.abs(run[name] - sharp[name].astype(float)).max() < 1e-11, name


@pytest.mark.parametrize("part", [0.9, 0.99, 1.0, 1.01, 1.1])
@pytest.mark.parametrize("method", ["scipy", "heyoka"])
def test_a_run_begins_about_the_level_of_its_watch(method: str, part: float) -> None:
    """The place where a divisor is watched is a power of two: one that starts between it and the
    level that it stands for must not be taken for one that was never small."""
    system = vo.load("rubber-ball-in-new-time")
    up = part / 32
    start = {"gamma1": 0.5, "gamma2": (0.75 - up**2) ** 0.5, "gamma3": up}
    start |= {"Omega1": 0.9, "Omega2": 0.5}
    times = np.linspace(0, 0.4, 9)
    found = vo.integrate(system, initial=start, times=times, method=method)
    truth = vo.integrate(system, initial=start, times=times, tol=1e-25)
    assert found.cost.switches and found["gamma3"].min() < 0
    for name in start:
        assert np.abs(found[name] - truth[name].astype(float)).max() < 1e-10


def test_everything_wanted_comes_out_on_the_way() -> None:
    system, start = roller_racer(), MADE["roller racer"][1]
    times = np.linspace(0.0, 6.0, 61)
    wanted = ("x", "v", "xdot", "reaction 1", "theta")
    across = vo.Event(phi - 2, name="folded")
    run = vo.integrate(
        system, times=times, initial=start, outputs=wanted, events=(across,), dense=True,
        method="scipy",
    )  # fmt: skip
    assert run.outputs == wanted and run.names == ("x", "phi", "y", "theta", "v", "w")
    assert np.abs(run["xdot"] - run["v"] * np.cos(run["theta"])).max() < 1e-12
    assert np.isfinite(run["reaction 1"]).all()
    crossings = run.events["folded"]
    assert len(crossings) and abs(float(crossings["phi"][0]) - 2) < 1e-12
    assert np.abs(run.at(crossings.t)["x"] - crossings["x"]).max() < 1e-11
    shuffled = run.at([5.5, 0.5, 3.0])
    assert np.abs(shuffled["theta"] - run["theta"][[55, 5, 30]]).max() < 1e-11


def test_a_start_where_the_velocities_are_no_frame() -> None:
    ball = vo.derive(vo.load("rubber-ball-on-plane"))
    equator = {"u": sp.pi / 2, "v": 0.5}
    start = {"udot": 0.5, "vdot": 0.25}
    times = np.linspace(0.0, 5.0, 3)
    run = vo.integrate(ball, times=times, initial={**equator, **start}, method="scipy")
    assert run.drift["energy"] < 1e-12
    exact = vo.integrate(ball, times=times, initial={**equator, **start}, tol=1e-25)
    assert np.abs(exact["u"].astype(float) - run["u"]).max() < 1e-11
    with pytest.raises(vo.DefinitionError, match="no frame at the initial point"):
        vo.integrate(ball, times=times, initial={**equator, "omega1": 0.5})


def test_one_instant_where_the_velocities_are_no_frame_is_the_start() -> None:
    start = {"u": sp.pi / 2, "v": 0.5, "udot": 0.5, "vdot": 0.25}
    for options in ({}, {"method": "scipy"}, {"tol": 1e-25}, {"dense": True}):
        ball = vo.load("rubber-ball-on-plane")
        run = vo.integrate(ball, times=[0.5], initial=start, outputs=("v", "udot"), **options)
        assert (len(run), run["v"][0]) == (1, 0.5)
        assert abs(run["udot"][0] - 0.5) < 1e-15  # all velocities are made of the independent ones


def test_a_refusal_says_that_the_constraints_are_dependent() -> None:
    """x' y - y' x = 0 is no constraint at the origin, which the motion reaches."""
    slip = velocity(x) * y - velocity(y) * x
    system = vo.System(
        name="through-the-origin",
        fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2 + x,
        constraints=(slip,),
    )
    start = {"x": -1.0, "y": -0.5, "xdot": 1.0}
    with pytest.raises(vo.IntegrationError, match="dependent"):
        vo.integrate(system, times=[0.0, 4.0], initial=start)


def test_a_divisor_may_touch_zero_and_keep_its_sign() -> None:
    """1 + cos(phi), as axles of one length come together: what stands over it loses all digits."""
    values = {m: 0.9, inertia: 0.6, J: 0.3, a: 1.45, b: 1.45}
    parameters = tuple(vo.Parameter(p.symbol, n, positive=True) for p, n in values.items())
    system = replace(roller_racer(), frame=None, parameters=parameters)
    start = {
        "x": 0.885,
        "phi": -0.018,
        "y": 0.19,
        "theta": 0.732 + np.pi,
        "xdot": 1.835,
        "phidot": 0.847,
    }
    times = np.linspace(0.0, 7.322, 2)
    truth = multiplier_motion(system, all_velocities(system, start), times)
    assert 0 < np.pi - truth[list(system.coordinates).index(phi), -1] < 1e-4
    run = vo.integrate(system, times=times, initial=start)
    assert worst(run, truth) < 1e-11 and run.cost.switches > 0


def test_harmless_divisors_are_not_watched() -> None:
    """A pole of coordinates is the business of charts: its runs are as before."""
    disc = vo.derive(vo.load("falling-disc"))
    assert divisors(disc.form)
    run = vo.integrate(disc, method="scipy", times=np.linspace(0, 1, 5))
    assert run.cost.switches == 0 and run.cost.evaluations <= 12 * run.cost.steps + 60


def test_whole_powers_of_zero_have_taylor_coefficients() -> None:
    """heyoka's recurrence for x^3 divides by x."""
    system = vo.System(
        name="cubic",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=velocity(x) ** 2 / 2 + x - x**4 / 4,
    )
    times = np.linspace(0.0, 2.0, 3)
    run = vo.integrate(system, times=times, initial={}, method="heyoka", outputs=("x", "xdot"))
    energy = run["xdot"] ** 2 / 2 - run["x"] + run["x"] ** 4 / 4
    assert np.abs(energy).max() < 1e-14
    truth = vo.integrate(system, times=times, initial={}, method="flint", tol=1e-25)
    assert np.abs(run["x"] - truth["x"].astype(float)).max() < 1e-13


@pytest.mark.parametrize("method", ["heyoka", "flint"])
def test_a_start_whose_last_coefficients_vanish(method: str) -> None:
    """x'' = 1 - x^k from rest at 0 has every (k + 1)-th coefficient or so, and the last two not."""
    for k in (2, 3, 4):
        system = vo.System(
            name="sparse",
            fibration=vo.Fibration(base=(x,)),
            lagrangian=velocity(x) ** 2 / 2 + x - x ** (k + 1) / (k + 1),
        )
        run = vo.integrate(
            system, times=[0.0, 2.0, 4.0], initial={}, method=method,
            tol=1e-13 if method == "heyoka" else 1e-20, outputs=("x", "xdot"),
        )  # fmt: skip
        place, speed = (run[name].astype(float) for name in ("x", "xdot"))
        assert np.abs(speed**2 / 2 - place + place ** (k + 1) / (k + 1)).max() < 1e-14


@pytest.mark.parametrize("k", [2, 3])
def test_lanes_whose_last_coefficients_vanish(k: int) -> None:
    """The same for some of the motions of an ensemble, both ways in time, and of a section."""
    sparse = vo.derive(
        vo.System(
            name="sparse",
            fibration=vo.Fibration(base=(x,)),
            lagrangian=velocity(x) ** 2 / 2 + x - x ** (k + 1) / (k + 1),
        )
    )
    starts = np.array([0.0, 0.1, 0.0, 0.2, 0.0, 0.0])

    def energy(place: np.ndarray, speed: np.ndarray) -> np.ndarray:
        return np.asarray(speed**2 / 2 - place + place ** (k + 1) / (k + 1))

    for times in ([0.0, 2.0, 4.0], [0.0, -300.0]):
        run = vo.ensemble(sparse, {"x": starts}, times=times, outputs=("x", "xdot"))
        assert not run.errors and run.finished.all()
        change = energy(run["x"], run["xdot"]) - energy(starts, np.zeros(6))[:, None]
        assert np.abs(change).max() < 1e-12
    points = vo.section(
        sparse, "xdot", ("x",), starts=[{"x": a} for a in starts], crossings=3, direction=-1
    )
    assert not points.errors and len(points.t) == 18
    change = energy(points["x"], np.zeros(18)) - energy(starts, np.zeros(6))[points.start]
    assert np.abs(change).max() < 1e-10


def test_an_ensemble_passes_too() -> None:
    ball = vo.derive(vo.load("rubber-ball-on-plane"))
    times = np.linspace(0.0, 8.0, 3)
    speeds = np.array([0.25, 0.75])
    starts = {"u": 1.25, "v": 0.75, "omega1": 0.5, "omega2": speeds}
    many = vo.ensemble(ball, starts=starts, times=times, outputs=("u", "x"), method="scipy")
    assert not many.errors and many.finished.all()
    for row, speed in enumerate(speeds):
        whole = all_velocities(ball.system, {**starts, "omega2": float(speed)})
        truth = multiplier_motion(ball.system, whole, times)
        names = [str(q) for q in ball.system.coordinates]
        assert np.abs(many["x"][row] - truth[names.index("x")]).max() < 1e-9


def test_the_cost_names_all_methods_that_worked(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second split of the snakeboard is the heavier one: there the rule may take another."""
    pytest.importorskip("heyoka")
    start = {"theta": -0.04, "psi": 0.73, "phi": 1.13, "x": -0.03, "y": 0.59}
    start |= {"thetadot": -0.97, "psidot": -0.37, "phidot": -0.44}
    board, run = vo.load("snakeboard"), {"initial": start, "times": [0, 8]}
    plain = vo.integrate(board, **run)
    monkeypatch.setattr(methods, "HEAVY", 60.0)
    mixed = vo.integrate(board, **run)
    assert plain.cost.switches and mixed.cost.switches
    assert (plain.cost.method, mixed.cost.method) == ("heyoka", "heyoka, scipy")
    assert mixed.state[-1] == pytest.approx(plain.state[-1], abs=1e-10)


def test_a_snakeboard_starts_with_its_wheels_straight() -> None:
    board = vo.derive(vo.load("snakeboard"))
    steered = {"psidot": 1, "phidot": "3/10"}
    # at phi = 0 the board cannot turn, and theta' says nothing of its speed
    with pytest.raises(vo.DefinitionError, match="such as 'xdot'"):
        vo.integrate(board, initial=steered, times=[0, 1], outputs=("theta",))
    motion = vo.integrate(
        board, initial={"xdot": "1/2", **steered}, times=[0, 1], outputs=("theta",)
    )
    # theta' ((J + 2 W) sin(phi)^2 + m l^2 cos(phi)^2)^(1/2) / sin(phi) is constant

    def rate(t: float) -> float:
        s, c = np.sin(0.3 * t), np.cos(0.3 * t)
        return float(-0.5 * np.sqrt(6) * s / np.sqrt(0.12 * s**2 + 6 * 0.04 * c**2))

    assert abs(motion["theta"][-1] - scipy.integrate.quad(rate, 0, 1, epsabs=1e-14)[0]) < 1e-12


@pytest.mark.parametrize(
    ("name", "pole"),
    [
        ("demchenko", {"u": 0.0}),
        ("demchenko", {"u1": 0.0}),
        ("homogeneous-ball", {"u": np.pi}),
        ("rubber-ball-on-sphere", {"u": np.pi}),
    ],
)
def test_a_start_at_a_pole_of_a_chart_is_given_by_velocities_of_angles(
    name: str, pole: dict[str, float]
) -> None:
    system = vo.load(name)
    frame, q = system.frame, system.coordinates
    assert frame is not None
    start = dict(zip(map(str, q), (0.75, 0.5, 1.125, 0.625, 0.375), strict=True)) | pole
    point = {x: sp.Float(start[str(x)], 30) for x in q}
    point |= {p.symbol: sp.Float(p.value, 30) for p in system.parameters}
    dots = [velocity(x) for x in q]
    meaning = dict(zip(frame.velocities, frame.expressions, strict=True))

    def rows(forms: Any) -> np.ndarray:
        spelled = sp.Matrix([sp.sympify(e).xreplace(meaning).xreplace(meaning) for e in forms])
        return np.array(spelled.jacobian(dots).xreplace(point), dtype=float)

    _, sizes, basis = np.linalg.svd(rows(system.constraints))
    admissible = basis[(sizes > 1e-12).sum() :]
    rates = (0.7, -0.4, 0.9, 0.5)[: len(admissible)] @ admissible
    given = {str(velocity(x)): rate for x, rate in zip(q, rates, strict=True)}
    names, own = [str(x) for x in q], [str(v) for v in frame.velocities]
    run = vo.integrate(
        system, times=[0, 0.01, 0.25], initial={**start, **given}, outputs=(), method="scipy"
    )
    assert [run[v][0] for v in own] == pytest.approx(list(rows(frame.expressions) @ rates))
    # back from where angles are regular, by equations that know neither frame nor chart
    last = all_velocities(system, {x: run[x][-1] for x in (*names, *own)})
    truth = multiplier_motion(system, last, np.array([0.25, 0.01]))
    assert truth[:, -1] == pytest.approx([run[x][1] for x in names], abs=1e-9)


def test_what_nobody_gives_at_a_pole_is_zero() -> None:
    given = {"u": 0, "u1": 1, "udot": 1, "vdot": 0.5}
    run = vo.integrate(vo.load("demchenko"), times=[0, 1], initial=given, outputs=("tau", "n"))
    assert run["tau"][0] == pytest.approx(-1.5) and run["n"][0] == pytest.approx(0, abs=1e-14)
    with pytest.raises(vo.DefinitionError, match=r"off the constraints: 'udot' = 1"):
        # with theta = 0 it rolls along a parallel of the sphere, and at the pole there is none
        vo.integrate(vo.load("demchenko"), times=[0, 1], initial={**given, "u1": 0}, outputs=())


def test_a_velocity_that_no_velocities_of_angles_have_is_named() -> None:
    # at beta = 0 finite rates turn the ball about the line of nodes and the vertical alone
    start = {"r": 1, "alpha": 0.5, "beta": 0, "v": 0.2, "w": 0.5, "s": 2, "alphadot": 0.3}
    with pytest.raises(vo.DefinitionError, match=r"have 'v' = 0.2, since these are singular"):
        vo.integrate(vo.load("ball-on-paraboloid"), times=[0, 1], initial=start, outputs=())


def test_the_refusal_of_a_start_without_a_frame_leads_to_one() -> None:
    system, times = vo.load("snakeboard"), np.linspace(0, 2, 9)
    start = {"theta": 0.4, "phi": 0.0, "phidot": 0.3, "psidot": 0.2}
    with pytest.raises(vo.DefinitionError, match=r"give velocities of coordinates, such as 'xdot'"):
        vo.integrate(system, times=times, initial=start, outputs=())
    run = vo.integrate(system, times=times, initial={**start, "xdot": 0.5}, outputs=())
    along = {"xdot": 0.5, "ydot": 0.5 * np.tan(0.4), "thetadot": 0.0, "phidot": 0.3, "psidot": 0.2}
    assert worst(run, multiplier_motion(system, {**start, **along}, times)) < 1e-10


def test_a_spheroid_starts_at_the_poles_of_its_coordinates() -> None:
    system = vo.load("gyroscopic-spheroid-on-sphere")
    run = vo.integrate(
        system, scene="default", initial={"u": 0, "u1": 0, "v": 0.3}, times=[0, 0.01, 0.5],
        outputs=(),
    )  # fmt: skip
    # back to where angles are regular, by equations that know neither frame nor chart
    last = all_velocities(system, {name: run[name][-1] for name in run.names})
    truth = multiplier_motion(system, last, np.array([0.5, 0.01]))
    names = [str(x) for x in system.coordinates]
    assert truth[:, -1] == pytest.approx([run[x][1] for x in names], abs=1e-9)


def test_a_run_goes_back_before_it_leaves_a_split_that_broke_down() -> None:
    # on its side the bicycle's wheels pass where phi', beta_R', beta_F' do not tell the rest;
    # next to that place they told it to five digits alone
    start = {
        "phi": -1.5013434089513054, "delta": -0.5084794929358508, "beta_R": 0.32671924192890134,
        "x": 0.6983074456848546, "y": 0.18940903917460084, "z": 0.36883414348148635,
        "psi": -0.5993031277415704, "theta": 0.6539102267006229, "beta_F": 0.5285162874871474,
        "phidot": 0.023739666941659965, "deltadot": -0.1153369692227697,
        "beta_Rdot": -0.0876968176859374, "xdot": -0.01851684337530579,
        "ydot": 0.012649119706574785, "zdot": 3.3306690738754696e-16,
        "psidot": 0.17682231799793463, "thetadot": 0.1624463043387166,
        "beta_Fdot": 0.12174668326499993,
    }  # fmt: skip
    times = np.linspace(0, 1, 13)
    rough = vo.integrate(vo.load("bicycle"), initial=start, times=times)
    sharp = vo.integrate(vo.load("bicycle"), initial=start, times=times, tol=1e-18)
    for name in rough.names:
        assert np.abs(rough[name] - sharp[name].astype(float)).max() < 1e-9, name


def samples(monkeypatch: pytest.MonkeyPatch, count: int) -> Iterator[int]:
    """So many other sequences of random numbers, one after the other."""
    own = np.random.default_rng
    for seed in range(count):
        monkeypatch.setattr(np.random, "default_rng", lambda _=None, seed=seed: own(seed))
        yield seed


def test_how_large_a_divisor_is_hangs_on_no_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    u, v = se.symbols("u v")
    functions = [se.cos(u), se.RealDouble(0.375) + 0.625 * se.cos(u), u * se.sin(v) + se.cos(u) / 4]
    value = se.Lambdify([u, v], functions)
    sizes = []
    for _ in samples(monkeypatch, 20):
        found = crossing_divisors(
            functions, around(np.array([0.25, 1.5])), lambda x: value(x.T).T,
            lambda x: np.ones(x.shape[1]), lambda x: x,
        )  # fmt: skip
        assert [d.function for d in found] == functions
        sizes.append([d.scale for d in found])
    assert (np.max(sizes, axis=0) < 1.25 * np.min(sizes, axis=0)).all()


@pytest.mark.parametrize("name", MADE)
def test_whether_a_motion_is_followed_hangs_on_no_sample(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    make, start = MADE[name]
    times = np.linspace(0.0, 8.0, 2)
    truth = multiplier_motion(make(), all_velocities(make(), start), times)
    for seed in samples(monkeypatch, 4):
        run = vo.integrate(make(), times=times, initial=start, method="scipy")
        assert worst(run, truth) < 1e-10 and run.cost.switches > 0, seed


def test_a_start_where_coordinates_do_not_tell_the_motion_is_refused_in_one_line() -> None:
    flat = {"phi": 0.3, "theta": np.pi / 2, "psi": 0.2, "phidot": 0.4, "thetadot": 0.3}
    fallen = {"phi": np.pi / 2, "delta": -0.5, "psi": 0.3, "theta": 0.6, "speed": 1.0}
    for name, start, idle in (
        ("falling-disc", flat, "phidot, psidot, xdot, ydot"),
        ("bicycle", fallen, "xdot, ydot, psidot, thetadot"),
    ):
        with pytest.raises(vo.IntegrationError, match=f"{idle} may differ though nothing moves"):
            vo.integrate(vo.load(name), initial=start, times=[0, 0.1])


def test_the_refusal_of_a_start_on_a_group_names_a_velocity_that_leads_on() -> None:
    start = {"gamma1": 1, "gamma2": 0, "gamma3": 0, "gamma4": 0, "Omega14": 0.3}
    with pytest.raises(vo.DefinitionError, match=r"of the group, such as 'Omega1[23]'"):
        vo.integrate(vo.load("veselova-in-rn"), initial=start, times=[0, 0.1])
    run = vo.integrate(vo.load("veselova-in-rn"), initial={**start, "Omega12": 0.5, "Omega13": 0.1},
        times=[0, 0.1], outputs=("Omega12", "Omega23"))  # fmt: skip
    assert (run["Omega12"][0], run["Omega23"][0]) == (0.5, 0)


AXES = tuple(itertools.combinations(range(4), 2))


def hyperplane_start(gamma: np.ndarray, u: np.ndarray) -> dict[str, float]:
    """gamma and Omega = gamma u^T - u gamma^T by name."""
    turning = np.outer(gamma, u) - np.outer(u, gamma)
    own = {f"Omega{i + 1}{j + 1}": turning[i, j] for i, j in AXES}
    return {**{f"gamma{i + 1}": x for i, x in enumerate(gamma)}, **own}


@pytest.mark.parametrize("tol", [1e-13, 1e-20])
@pytest.mark.parametrize(
    ("name", "letter"),
    [("veselova-in-rn", "J"), ("rubber-ball-in-rn", "I"), ("rubber-ball-on-sphere-in-rn", "I")],
)
def test_constraints_dependent_at_the_start_are_those_beside(
    name: str, letter: str, tol: float
) -> None:
    # where gamma4 = 0; with axes 1 and 4 in each other's place it is gamma1 = 0, a regular start
    system, turn = vo.load(name), [3, 1, 2, 0]
    gamma, u = np.array([0.48, 0.6, 0.64, 0.0]), np.array([0.3, -0.5, 0.2, 0.7])
    own = {p.name: p.value for p in system.parameters}
    moments = {
        f"{letter}{i + 1}{j + 1}": own["{}{}{}".format(letter, *sorted((turn[i] + 1, turn[j] + 1)))]
        for i, j in AXES
    }
    outputs = ("gamma1", "gamma2", "gamma4", "Omega14", "Omega23", "energy")
    one, other = (
        vo.integrate(
            system, initial=hyperplane_start(gamma[axes], u[axes]), times=[0, 0.5, 1], tol=tol,
            parameters=parameters, outputs=outputs,
        )
        for axes, parameters in (([0, 1, 2, 3], {}), (turn, moments))
    )  # fmt: skip
    pairs = [("gamma1", "gamma4", 1), ("gamma4", "gamma1", 1), ("Omega14", "Omega14", -1)]
    pairs += [(x, x, 1) for x in ("gamma2", "Omega23", "energy")]
    for a, b, sign in pairs:
        assert np.abs(one[a] - sign * other[b]).max() < max(1e-13, 10 * tol), a


def test_a_start_on_a_group_may_be_given_by_any_of_its_velocities() -> None:
    system, given = vo.load("veselova-in-rn"), {"times": [0, 1], "outputs": ("gamma1", "Omega23")}
    for last in (0.0, 0.48):
        gamma = np.array([0.8 if last == 0 else 0.64, 0.6, 0.0, last])
        whole = hyperplane_start(gamma, np.array([0.3, -0.5, 0.2, 0.7]))
        point = {x: value for x, value in whole.items() if x.startswith("gamma")}
        turning = np.zeros((4, 4))
        for i, j in AXES:
            turning[i, j], turning[j, i] = (s * whole[f"Omega{i + 1}{j + 1}"] for s in (1, -1))
        rates = {f"gamma{i + 1}dot": x for i, x in enumerate(-turning @ gamma)}
        few = {x: whole[x] for x in ("Omega12", "Omega13", "Omega14")}
        runs = [
            vo.integrate(system, initial=start, **given)
            for start in (whole, {**point, **rates}, {**point, **few})
        ]
        many = vo.ensemble(system, starts=[whole, {**point, **few}], **given)
        for x in given["outputs"]:
            ends = [*(run[x][-1] for run in runs), *many[x][:, -1]]
            assert ends == pytest.approx([ends[0]] * 5, abs=1e-12), (last, x)


@pytest.mark.parametrize("pole", [0.0, np.pi])
@pytest.mark.parametrize("name", ["rubber-ball-eps-minus-one", "gyroscopic-rubber-ball-on-sphere"])
def test_a_start_needs_a_chart_and_another_split_at_once(name: str, pole: float) -> None:
    # at a pole of (u1, v1) and on the equator of u omega1 and omega2 tell nothing but rounding
    system = vo.load(name)
    q = system.coordinates
    point = dict(zip(q, (np.pi / 2, -0.424, pole, 0.157, -0.241), strict=True))
    numbers = {**point, **{p.symbol: sp.sympify(p.value) for p in system.parameters}}
    dots = [velocity(x) for x in q]
    rows = sp.Matrix(system.constraints).jacobian(dots).xreplace(numbers).xreplace(numbers)
    _, sizes, basis = np.linalg.svd(np.array(rows, dtype=float))
    ways = basis[(sizes > 1e-12).sum() :]
    rates = (0.5, 0.4, 0.3)[: len(ways)] @ ways
    start = {**point, **dict(zip(dots, rates, strict=True))}
    run = vo.integrate(system, times=[0, 0.01, 0.5], initial=start, outputs=())
    # back to where angles are regular, by equations that know neither frame nor chart
    last = all_velocities(system, {name: run[name][-1] for name in run.names})
    truth = multiplier_motion(system, last, np.array([0.5, 0.01]))
    assert truth[:, -1] == pytest.approx([run[str(x)][1] for x in q], abs=1e-9)
    assert run["u"][1] == pytest.approx(np.pi / 2 + 0.01 * rates[0], abs=1e-3)
    assert abs(run["u1"][1] - pole) == pytest.approx(0.01 * abs(rates[2]), abs=1e-3)


@pytest.mark.parametrize("pole", [0.0, np.pi])
def test_a_ball_at_the_vertex_starts_with_its_own_axis_upright(pole: float) -> None:
    # the declared chart and that of Euler's angles at once, and other pivots
    system = vo.load("ball-on-paraboloid")
    start = {"r": 0, "phi": 0.2, "beta": pole, "alpha": 0.5, "psi": 0.1, "s": 1}
    run = vo.integrate(system, times=[0, 0.5, 2], initial=start, outputs=())
    # it spins upright where it stands
    turned = run["psi"] + np.cos(pole) * run["alpha"]
    assert turned == pytest.approx(turned[0] + np.cos(pole) * run.t, abs=1e-9)
    assert run["r"] == pytest.approx([0, 0, 0], abs=1e-12) and run["s"] == pytest.approx([1, 1, 1])


INFINITE_RATES = {
    # Euler's angles of the ball at their pole: it is to turn about the axis that they lack
    "ball-on-paraboloid": {
        "r": 0.8, "phi": -0.3, "psi": 0.1, "alpha": 0.8, "beta": 0.0, "v": 0.8, "w": -0.4, "s": 0.1,
    },
    # the contact goes across the pole of the sphere, and later the ball's equator over it
    "rubber-ball-on-sphere": {
        "u": 1.4, "v": -0.6, "u1": 0.0, "v1": -0.5, "theta": -0.7, "omega1": -0.1, "omega2": -0.9,
    },
}  # fmt: skip


@pytest.mark.parametrize("name", INFINITE_RATES)
def test_a_run_begins_at_a_pole_where_rates_are_infinite_and_changes_its_split(name: str) -> None:
    system, start = vo.load(name), INFINITE_RATES[name]
    run = vo.integrate(system, times=[0, 1e-3, 0.5, 1], initial=start, outputs=())
    # back to where angles are regular, by equations that know neither frame nor chart
    last = all_velocities(system, {x: run[x][-1] for x in run.names})
    truth = multiplier_motion(system, last, np.array([1, 0.5, 1e-3]))
    for row, i in ((1, 2), (2, 1)):
        assert truth[:, row] == pytest.approx(
            [run[str(x)][i] for x in system.coordinates], abs=1e-9
        )
    # and there it is as it began
    own = [str(v) for v in system.velocities]
    assert [run[v][1] for v in own] == pytest.approx([start[v] for v in own], abs=5e-3)
    assert np.ptp(run.integrals["energy"][1:]) < 1e-12


CARRIED_POLES = {
    "torus-on-ellipsoid": {"chi": 0.34, "u": 0.72, "theta": 0.85, "w": sp.Rational(2, 3), "u1": 0},
    "spheroid-on-sphere": {"chi": 0.4, "u1": 0.7, "theta": 0.85, "v": 0.2, "u": 0},
}


def finite_rates(system: vo.System, point: Mapping[Any, Any]) -> dict[str, float]:
    """Velocities of coordinates that meet the constraints next to a point, in 50 digits."""
    dots = [velocity(x) for x in system.coordinates]
    rows = [*system.constraints]
    for r in system.fibration.relations:
        rows.append(sp.Add(*(sp.diff(r, x) * velocity(x) for x in system.coordinates)))
    frame = system.frame
    meaning = dict(zip(frame.velocities, frame.expressions, strict=True))
    numbers = {x: value + sp.Rational(1, 10**20) for x, value in point.items()}
    numbers |= {p.symbol: sp.sympify(p.value) for p in system.parameters}
    matrix = sp.Matrix(rows).xreplace(meaning).jacobian(dots).xreplace(numbers)
    with mpmath.workdps(50):
        A = mpmath.matrix(matrix.evalf(50).tolist())
        guess = mpmath.matrix([0.5 * mpmath.cos(3 * i) for i in range(len(dots))])
        found = guess - A.T * mpmath.lu_solve(A * A.T, A * guess)
    return {str(x): float(v) for x, v in zip(dots, found, strict=True)}


@pytest.mark.parametrize(
    ("name", "pole"), [("torus-on-ellipsoid", sp.Integer(0)), ("spheroid-on-sphere", sp.pi)]
)
def test_rates_are_given_where_a_coordinate_that_is_carried_along_has_a_pole(
    name: str, pole: sp.Expr
) -> None:
    system, given = vo.load(name), CARRIED_POLES[name]
    point = {x: sp.Integer(0) for x in system.coordinates}
    point |= {sp.Symbol(x): sp.Rational(str(value)) for x, value in given.items()}
    polar = next(sp.Symbol(x) for x, value in given.items() if value == 0)
    point[polar] = pole
    rates = finite_rates(system, point)
    start = {**{str(x): float(value) for x, value in point.items()}, **rates}
    run = vo.integrate(system, times=[0, 1e-3, 0.3], initial=start, outputs=())
    last = all_velocities(system, {x: run[x][-1] for x in run.names})
    truth = multiplier_motion(system, last, np.array([0.3, 1e-3]))
    found = np.array([run[str(x)] for x in system.coordinates])
    assert np.abs(truth - found[:, [2, 1]]).max() < 1e-8
    began = np.array([start[str(x)] + 1e-3 * rates[f"{x}dot"] for x in system.coordinates])
    # which way round the pole is passed is free: two angles, and the sign of the third
    free = {"u1": ("u1", "v1", "theta"), "u": ("u", "v", "theta")}[str(polar)]
    defined = [str(x) not in free for x in system.coordinates]
    assert np.abs(found[:, 1] - began)[defined].max() < 1e-4


def test_velocities_that_are_dependent_but_for_rounding_do_not_begin_a_run() -> None:
    # of the charts of that ball this one leaves no velocities as they are
    start = {
        "u": 1.5707963267948966, "v": -0.42446622478013507, "u1": 0.0, "v1": 0.1573307524324422,
        "theta": -0.2411605689276512, "udot": 0.06786466656996698, "vdot": 0.27593193823758955,
        "u1dot": -0.5683099418739945, "v1dot": -0.14191765821922753,
        "thetadot": 0.14191765821922708,
    }  # fmt: skip
    system = vo.load("rubber-ball-eps-minus-one")
    system = replace(system, charts={"both": system.charts["both poles turned"]})
    with pytest.raises(vo.IntegrationError, match="no velocities determine the motion"):
        vo.integrate(system, times=[0, 0.1], initial=start)


BLADE_START = {"y": 1.093, "phi": -1.457, "x": 0.519, "ydot": -0.149, "phidot": 1.294}


def blade() -> vo.System:
    """A blade on a plane, given by the velocity of y: along x that does not tell the other."""
    x, y, phi = sp.symbols("x y phi")
    Dx, Dy, spin = map(vo.velocity, (x, y, phi))
    return vo.System(
        name="blade", fibration=vo.Fibration(base=(y, phi), fibre=(x,)),
        lagrangian=3 * spin**2 / 8 + 17 * (Dx**2 + Dy**2) / 20,
        constraints=(Dx * sp.sin(phi) - Dy * sp.cos(phi),),
    )  # fmt: skip


def blade_circle(time: float) -> tuple[float, float]:
    """(x, y): the blade goes round at constant speed."""
    first, spin = BLADE_START["phi"], BLADE_START["phidot"]
    radius, last = BLADE_START["ydot"] / np.sin(first) / spin, first + spin * time
    x = BLADE_START["x"] + radius * (np.sin(last) - np.sin(first))
    return x, BLADE_START["y"] - radius * (np.cos(last) - np.cos(first))


@pytest.mark.parametrize("method", ["scipy", "numba", "heyoka"])
def test_an_ensemble_sees_between_its_instants_that_a_split_fails(method: str) -> None:
    grid = [0.0, 4.404]
    many = vo.ensemble(blade(), starts=[BLADE_START], times=grid, outputs=("x", "y"), method=method)
    end = [many[name][0, -1] for name in ("x", "y")]
    assert end == pytest.approx(blade_circle(grid[-1]), abs=1e-11)


@pytest.mark.parametrize("method", ["scipy", "numba", "c", "heyoka"])
def test_a_section_goes_on_in_another_split(method: str) -> None:
    """The blade goes round, and its split is singular twice in each turn; the crossings lie on its
    circle, and come when a dense run in all digits of doubles comes there."""
    level = sp.Symbol("y") - 1.12
    section = vo.section(
        blade(), starts=[BLADE_START], plane=level, crossings=3, method=method,
        outputs=("phi", "x"),
    )  # fmt: skip
    assert section.ends == ("complete",) and not section.errors
    times = (section["phi"] - BLADE_START["phi"]) / BLADE_START["phidot"]
    assert section.t == pytest.approx(times, abs=1e-11)
    assert max(abs(blade_circle(t)[1] - 1.12) for t in times) < 1e-11
    end = float(section.t[-1]) + 0.1
    dense = vo.integrate(
        blade(), times=[0, end], initial=BLADE_START, dense=True, events=(vo.Event(level, "y", 1),)
    )
    assert section.t == pytest.approx(dense.events["y"].t, abs=1e-11)
    h = 1e-5
    around = [dense.at([t - h, t + h])["y"] for t in section.t.tolist()]
    assert section.speed == pytest.approx([(b - a) / (2 * h) for a, b in around], rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_run_ends_where_no_split_leads_on(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    # both wheels of a bicycle that tumbles come to touch the ground where their conditions are one
    monkeypatch.setattr("voronec.motion.divisors.Random", lambda _: Random(seed))
    start = {
        "phi": -2.035686614234207, "delta": -33.52509248996672, "beta_R": 7.471950048917096,
        "x": 4.777030990248209, "y": 0.32111862746184155, "z": 0.442, "psi": 2.0567957646061044,
        "theta": 1.2619491738424964, "beta_F": -15.408981756587421,
        "roll_rate": -0.010065522403191501, "steer_rate": 2.5258018221942393,
        "speed": 1.2850606529703317,
    }  # fmt: skip
    with pytest.raises(vo.IntegrationError, match="constraints become dependent after") as caught:
        vo.integrate(
            replace(vo.load("bicycle")), initial=start, times=[0, -6], project=True, method="scipy"
        )
    assert float(caught.value.time) == pytest.approx(-0.1561, abs=1e-3)
    cost = caught.value.trajectory.cost
    assert cost.switches < 20 and cost.steps < 20_000
