"""Runs through places where the declared velocities are no frame, or the split is singular there.

The truth comes from the equations with multipliers, which know neither frame nor split.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from random import Random

import mpmath
import numpy as np
import pytest
import symengine as se
import sympy as sp
from multiplier_motion import all_velocities, multiplier_motion, worst

import voronec as vo
from voronec import velocity
from voronec.algebra.verdicts import all_vanish
from voronec.motion import ambient, constraint_geometry
from voronec.motion.constraint_geometry import implied_rows
from voronec.motion.singular_denominators import around, crossing_divisors, divisors

pytestmark = pytest.mark.slow


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
            assert run.cost.switches == 0  # one formulation leads all the way


def test_a_start_close_to_where_a_split_is_singular_may_be_fast() -> None:
    """Its velocities determine the motion, though they ask for one of 20 000 in y."""
    start = {"phi": np.pi / 2 + 1e-5, "psi": 1.6, "xdot": 0.225, "phidot": 0.5}
    times = np.linspace(0.0, 0.5, 6)
    truth = multiplier_motion(trailer(), all_velocities(trailer(), start), times)
    run = vo.integrate(trailer(), times=times, initial=start)
    assert worst(run, truth) < 1e-10 * np.abs(truth).max()


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
        assert run.names == tuple(map(str, (*equations.coordinates, *equations.velocities)))


@pytest.mark.parametrize(("method", "tol"), [("heyoka", 1e-13), ("scipy", 1e-13), ("auto", 1e-30)])
def test_velocities_beside_a_frame_are_taken_where_it_fails(method: str, tol: float) -> None:
    """A skate draws a circle; heading along y its speed along x tells nothing, and gives 0/0."""
    x, y, phi, u, v, w = sp.symbols("x y phi u v w")
    skate = vo.System(
        name="skate",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        frame=vo.Frame.quasi({u: velocity(x), w: velocity(phi)}, beside={v: velocity(y)}),
        lagrangian=sum(velocity(q) ** 2 for q in (x, y, phi)) / 2,
        constraints=(velocity(x) * sp.sin(phi) - velocity(y) * sp.cos(phi),),
        integrals={"energy": ((u / sp.cos(phi)) ** 2 + w**2) / 2},
    )
    start = {u: sp.Rational(8, 5), w: 1, phi: sp.asin(sp.Rational(3, 5))}
    times = np.linspace(0, 9, 7)
    found = vo.integrate(skate, initial=start, times=times, method=method, tol=tol)
    assert found.cost.switches == 0 and found.names == ("x", "phi", "y", "u", "w")
    assert found.drift["energy"] < 100 * tol
    with mpmath.workdps(60):
        angles = [mpmath.asin(mpmath.mpf(3) / 5) + mpmath.mpf(float(t)) for t in found.t]
        for place, angle in zip(found["x"], angles, strict=True):
            assert abs(place - 2 * (mpmath.sin(angle) - mpmath.mpf(3) / 5)) < 1e3 * tol
    upright = {phi: sp.pi / 2, velocity(y): 1, w: 1}
    half = vo.Event(x + sp.Rational(1, 2), name="half")
    found = vo.integrate(skate, initial=upright, times=times, events=(half,), dense=True)
    assert found.events["half"].t[0] == pytest.approx(np.pi / 3, abs=1e-12)
    assert found.at([1.0])["u"] == pytest.approx(-np.sin(1.0), abs=1e-12)
    assert found.integrals["energy"] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("beside", [{"u1": 1e-6}, {"u": np.pi - 1e-6}])
def test_a_ball_passes_its_equator_after_a_start_beside_a_pole(beside: dict[str, float]) -> None:
    ball = vo.load("rubber-ball-on-sphere")
    start = {"u": 1.0, "v": -0.4, "theta": 0.5, "u1": 0.9, "v1": 0.1, "omega1": 0.9, "omega2": -1.1}
    run, sharp = (
        vo.integrate(ball, initial={**start, **beside}, times=[0, 6, 12], tol=tol)
        for tol in (1e-13, 1e-20)
    )
    for name in start:
        assert np.abs(run[name] - sharp[name].astype(float)).max() < 1e-11, name


def test_all_velocities_are_derived_once_for_all_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    equations = vo.derive(vo.load("veselova-in-rn"))
    start = {"gamma1": 0.6, "gamma2": 0.48, "gamma4": 0.64, "Omega14": 1, "Omega24": -0.5}
    first = vo.integrate(equations, times=[0.0, 9.0], initial=start)
    monkeypatch.setattr(ambient, "derive", None)
    again = vo.integrate(equations, times=[0.0, 9.0], initial=start)
    assert again.cost.switches == first.cost.switches == 0
    for name in start:
        assert (again[name] == first[name]).all()


@pytest.mark.parametrize("method", ["scipy", "heyoka"])
def test_a_snakeboard_passes_with_its_wheels_straight_and_across(method: str) -> None:
    """theta' tells nothing where phi = 0, and its two conditions are one where cos(phi) = 0."""
    board = vo.load("snakeboard")
    start = {"theta": 0.1, "phi": 0.3, "thetadot": 0.2, "psidot": 1.0, "phidot": 0.1}
    times = np.linspace(0.0, 30.0, 4)
    wanted = ("theta", "psi", "phi", "x", "y", "sine")
    run = vo.integrate(board, times=times, method=method, outputs=wanted)
    assert np.abs(run["sine"] - np.sin(run["phi"])).max() < 1e-14
    assert run["phi"][-1] > np.pi and run.cost.switches == 0
    (turn, _, phi), (x, y), length = board.fibration.base, board.fibration.fibre, sp.Symbol("l")
    along = sp.cos(turn) * velocity(x) + sp.sin(turn) * velocity(y)
    regular = (  # nowhere dependent
        sp.cos(turn) * velocity(y) - sp.sin(turn) * velocity(x),
        sp.sin(phi) * along + length * sp.cos(phi) * velocity(turn),
    )
    truth = multiplier_motion(
        replace(board, constraints=regular), all_velocities(board, start), times
    )
    assert worst(run, truth) < 1e-10
    assert max(run.drift.values()) < 1e-11


@pytest.mark.parametrize("steer", [2 * phi, phi / 2, phi + psi, 2 * phi - psi + 1], ids=str)
def test_a_snakeboard_passes_with_its_wheels_across_however_it_is_steered(steer: sp.Expr) -> None:
    board = vo.load("snakeboard")
    (turn, _, _), (x, y), length = board.fibration.base, board.fibration.fibre, sp.Symbol("l")
    steered = vo.System(
        name="board", fibration=board.fibration, lagrangian=board.lagrangian,
        parameters=board.parameters,
        constraints=tuple(c.xreplace({phi: steer}) for c in board.constraints),
    )  # fmt: skip
    rows, idle = implied_rows(vo.derive(steered).definition)
    assert (len(rows), len(idle)) == (3, 1)
    across = float((sp.pi / 2 - steer.subs({phi: 0, psi: 0})) / steer.coeff(phi))
    start = {"phi": across - 0.4, "phidot": 1.0, "psidot": 0.25, "thetadot": 0.2}
    times = np.linspace(0.0, 1.5, 4)
    run = vo.integrate(steered, times=times, initial=start)
    along = sp.cos(turn) * velocity(x) + sp.sin(turn) * velocity(y)
    regular = (
        sp.cos(turn) * velocity(y) - sp.sin(turn) * velocity(x),
        sp.sin(steer) * along + length * sp.cos(steer) * velocity(turn),
    )
    first = all_velocities(steered, start)
    truth = multiplier_motion(replace(steered, constraints=regular), first, times)
    assert worst(run, truth) < 1e-10


@pytest.mark.parametrize("name", ["snakeboard", "veselova-in-rn", "veselova-in-rn@5"])
def test_constraints_that_are_dependent_at_a_place_imply_others(name: str) -> None:
    d = vo.derive(vo.load(name)).definition
    rows, idle = implied_rows(d)
    own, place = len(d.constraints.matrix), d.coordinates[-1 if d.group else 2]
    assert len(rows) > own
    for sums in idle:
        assert all_vanish([se.Add(*(b * e for b, e in zip(sums, c, strict=True)))
                           for c in zip(*rows, strict=True)])  # fmt: skip
    dice = Random(1)
    at = {x: se.RealDouble(dice.uniform(0.3, 1)) for x in (*d.coordinates, *d.parameters)}
    at[place] = se.RealDouble(0 if d.group else np.pi / 2)
    table = np.array([[float(se.sympify(e).xreplace(at).n()) for e in row] for row in rows])
    assert np.linalg.matrix_rank(table[:own], 1e-9) < own
    assert np.linalg.matrix_rank(table, 1e-9) == own
    unique = np.vstack(
        [table.T, [[float(se.sympify(b).xreplace(at).n()) for b in s] for s in idle]]
    )
    assert np.linalg.matrix_rank(unique, 1e-9) == len(rows)  # reactions that do nothing are none


def test_a_frame_that_fails_all_the_time_loses_no_digits() -> None:
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
        assert run.cost.switches == 0
        assert worst(run, truth) < 5e-8, tol  # the truth drifts by 1.2e-8
        assert max(run.drift.values()) < drift, tol


@pytest.mark.parametrize("tol", [1e-30, 1e-50])
def test_a_split_that_fails_loses_no_digits_in_any_precision(tol: float) -> None:
    """A skate that turns evenly draws a circle; its start is no double."""
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
    assert found.cost.switches == 0
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
    assert found["gamma3"].min() < 0
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
    assert worst(run, truth) < 1e-11


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


def test_a_bicycle_on_its_side_passes_where_its_frame_fails() -> None:
    # on its side the bicycle's wheels pass where phi', beta_R', beta_F' do not tell the rest
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
    end = {  # at tol = 1e-18
        "phi": 1.4320466674025782, "delta": 3.2353234393864736, "beta_R": 1.7430018435864807,
        "x": -0.015409656013665379, "y": -0.6122751450455411, "psi": 0.35378935592724153,
        "theta": 3.6752731989427154, "beta_F": 2.197279866193034, "roll_rate": 0.4901918899776557,
        "steer_rate": 17.230484560146238, "speed": 10.414556410922316,
    }  # fmt: skip
    rough = vo.integrate(vo.load("bicycle"), initial=start, times=np.linspace(0, 1, 13))
    for name, value in end.items():
        assert rough[name][-1] == pytest.approx(value, abs=1e-9), name


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
        assert worst(run, truth) < 1e-10, seed


BLADE_START = {"y": 1.093, "phi": -1.457, "x": 0.519, "ydot": -0.149, "phidot": 1.294}


@cache
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


@pytest.mark.parametrize("method", ["scipy", "heyoka"])
def test_events_of_velocities_that_friction_holds_happen_once(method: str) -> None:
    """The blade's speed is 2 - t/5 up to t = 10, and it turns on: zero but for rounding, from then,
    are its speed, x' and y'."""
    free, speed = blade(), velocity(x) * sp.cos(phi) + velocity(y) * sp.sin(phi)
    push = -sp.sign(speed) / 5
    system = replace(
        free, name="braked blade", lagrangian=(sum(velocity(q) ** 2 for q in (x, y, phi))) / 2,
        forces={x: push * sp.cos(phi), y: push * sp.sin(phi)},
    )  # fmt: skip
    watched = {"speed": speed, "half": speed - 1, "xdot": velocity(x), "ydot": velocity(y)}
    run = vo.integrate(
        system, initial={"phi": 0.5, "phidot": 1.0, "ydot": 2 * np.sin(0.5)}, times=[0, 14],
        events=tuple(vo.Event(e, name) for name, e in watched.items()), method=method,
    )  # fmt: skip
    halves = np.pi * np.arange(1, 7) / 2 - 0.5
    truth = {"speed": [10], "half": [5], "xdot": [*halves[::2], 10], "ydot": [*halves[1::2], 10]}
    for name, times in truth.items():
        assert run.events[name].t == pytest.approx(times, abs=1e-11), name


@pytest.mark.parametrize("method", ["scipy", "c", "heyoka"])
def test_an_ensemble_sees_between_its_instants_that_a_split_fails(method: str) -> None:
    grid = [0.0, 4.404]
    many = vo.ensemble(blade(), starts=[BLADE_START], times=grid, outputs=("x", "y"), method=method)
    end = [many[name][0, -1] for name in ("x", "y")]
    assert end == pytest.approx(blade_circle(grid[-1]), abs=1e-11)


@pytest.mark.parametrize("method", ["scipy", "c", "heyoka"])
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


def test_the_patience_of_a_section_counts_from_the_last_crossing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of one that is followed alone, from where its split is singular: it was given up once all its
    steps together were more."""
    monkeypatch.setattr("voronec.motion.one_by_one.PATIENCE", 60)
    start = {"xdot": 1, "phidot": 1}
    turns = vo.section(blade(), "y - 1", initial=start, crossings=40, outputs=("phi",))
    assert turns.ends == ("complete",) and turns.cost.steps > 120
    assert turns.t == pytest.approx(np.pi / 2 + 2 * np.pi * np.arange(40), abs=1e-10)


def test_a_run_ends_where_constraints_are_dependent(monkeypatch: pytest.MonkeyPatch) -> None:
    # both wheels of a bicycle that tumbles come to touch the ground where their conditions are one
    monkeypatch.setattr("voronec.motion.singular_denominators.Random", lambda _: Random(1))
    start = {
        "phi": -2.0692258788579174, "delta": -34.55218737643772, "beta_R": 7.5591976749251755,
        "x": 4.840272422844119, "y": 0.23292571167811882, "z": 0.442, "psi": 2.1397321927844533,
        "theta": 1.5371228925686338, "beta_F": -15.711701292735551,
        "roll_rate": -0.19203597600866923, "steer_rate": 1.0123300237552504,
        "speed": -0.9127716322729438,
    }  # fmt: skip
    with pytest.raises(vo.IntegrationError, match="constraints become dependent after") as caught:
        vo.integrate(
            replace(vo.load("bicycle")), initial=start, times=[0, -6], project=True,
            method="heyoka",
        )  # fmt: skip
    assert float(caught.value.time) == pytest.approx(-0.0057, abs=5e-4)
    cost = caught.value.trajectory.cost
    assert cost.switches < 20 and cost.steps < 20_000


def needle(friction: sp.Expr | int = 0) -> vo.System:
    """A point with x y' = y z': no condition at all where x = y = 0."""
    x, y, z = sp.symbols("x y z")
    Dx, Dy, Dz = map(vo.velocity, (x, y, z))
    return vo.System(
        name="needle", fibration=vo.Fibration(base=(x, y), fibre=(z,)),
        lagrangian=(Dx**2 + Dy**2 + Dz**2) / 2, constraints=(x * Dy - y * Dz,),
        forces={x: -friction * sp.sign(Dx)},
    )  # fmt: skip


def test_a_run_that_ends_where_constraints_are_dependent_says_in_which_state() -> None:
    start = {"x": -1.0, "y": -0.3, "z": 0.0, "xdot": 1.0, "ydot": 0.3}
    with pytest.raises(vo.IntegrationError, match="constraints become dependent") as caught:
        vo.integrate(needle(), initial=start, times=np.linspace(0, 2, 9), method="scipy")
    time, state = caught.value.time, caught.value.state
    assert 0.75 < time <= 1.0 and caught.value.trajectory.t[-1] == 0.75
    assert state == pytest.approx([time - 1, 0.3 * (time - 1), time, 1.0, 0.3], abs=1e-9)


@pytest.mark.parametrize("friction", [0, sp.Rational(1, 1000)])
@pytest.mark.parametrize("aside", [0.2, 0.004, 0.002])
def test_a_run_close_to_where_constraints_are_dependent_loses_no_digits(
    aside: float, friction: sp.Expr | int
) -> None:
    start = {"x": -1.0, "y": aside, "z": 0.0, "xdot": 1.0, "ydot": aside / 10}
    run, sharp = (
        vo.integrate(needle(friction), initial=start, times=[0, 2], tol=tol)
        for tol in (1e-13, 1e-22)
    )
    assert np.abs(run.state - sharp.state.astype(float)).max() < 1e-13


def test_the_metric_is_looked_at_in_many_places_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it has no value it is not sound; what it is computed by is made once."""
    x, y = sp.symbols("x y", real=True)
    system = vo.System(
        name="wedge",
        fibration=vo.Fibration((x,), (y,)),
        lagrangian=velocity(x) ** 2 / sp.log(x) + velocity(x) * velocity(y) / 3 + velocity(y) ** 2,
        constraints=(velocity(y) - x**2 * velocity(x),),
    )
    equations, made, quantities = vo.derive(system), [], constraint_geometry.quantities
    monkeypatch.setattr(
        constraint_geometry, "quantities", lambda *form: made.append(form) or quantities(*form)
    )
    places = np.array([[0.5, 2.0, 3.0, -1.0], [0.0, 1.0, 2.0, 3.0], [7.0, 7.0, 7.0, 7.0]])
    grounds = [constraint_geometry.ConstraintGeometry(equations, {}, 0.0) for _ in range(2)]
    found, again = (ground.soundness(places) for ground in grounds)
    assert len(made) == 1 and np.array_equal(found, again)
    for place, size in zip(places.T, found, strict=True):
        metric = grounds[0].metric(0.0, np.array([*place[:2], 0.0, 0.0]))
        single = abs(np.linalg.det(metric)) if np.isfinite(metric).all() else 0.0
        assert size == pytest.approx(single, rel=1e-13)
    assert found[:3].all() and found[3] == 0
