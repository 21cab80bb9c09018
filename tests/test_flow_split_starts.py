"""Starts where the declared velocities are no frame, a split is singular, or coordinates fail.

The truth comes from the equations with multipliers, or from what is known of the motion.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest
import scipy.integrate
import sympy as sp
from multiplier_motion import all_velocities, multiplier_motion, worst

import voronec as vo
from voronec import velocity

pytestmark = pytest.mark.slow


def test_a_start_where_the_velocities_are_no_frame() -> None:
    ball = vo.derive(vo.load("rubber-ball-on-plane"))
    equator = {"u": sp.pi / 2, "v": 0.5}
    start = {"udot": 0.5, "vdot": 0.25}
    times = np.linspace(0.0, 5.0, 3)
    run = vo.integrate(ball, times=times, initial={**equator, **start}, method="scipy")
    assert run.drift["energy"] < 1e-12
    # 0.18 was told for the first, where rounding is divided by rounding, and later none
    assert not run.integrals["energy"].flags.writeable
    assert run.integrals["energy"] == pytest.approx(0.23775189, abs=1e-8)
    exact = vo.integrate(ball, times=times, initial={**equator, **start}, tol=1e-25)
    assert np.abs(exact["u"].astype(float) - run["u"]).max() < 1e-11
    with pytest.raises(vo.DefinitionError, match="no frame at the initial point"):
        vo.integrate(ball, times=times, initial={**equator, "omega1": 0.5})


@pytest.mark.parametrize("away", [1e-7, 5e-9, 1e-12])
def test_velocities_beside_a_place_where_they_are_no_frame_determine_the_motion(
    away: float,
) -> None:
    """They were refused up to 1e-6 of it.  A digit of omega is one of omega3 gamma3."""
    for name in ("rubber-ball-on-plane", "gyroscopic-rubber-ball-on-plane"):
        place = {"u": np.pi / 2 + away, "v": 0.5}
        rates = {"udot": 0.5, "vdot": 0.25}
        given = {"outputs": (*rates, "omega1", "omega2"), "method": "scipy", "times": [0.0, 0.25]}
        first = vo.integrate(vo.load(name), initial={**place, **rates}, **given)
        own = {k: float(first[k][0]) for k in ("omega1", "omega2")}
        run = vo.integrate(vo.load(name), initial={**place, **own}, **given)
        assert all(np.abs(run[k] - first[k]).max() < 1e-15 / away for k in rates)
        sharp = vo.integrate(vo.load(name), initial={**place, **own}, **{**given, "tol": 1e-20,
                             "method": "auto"})  # fmt: skip
        assert all(np.abs(sharp[k].astype(float) - run[k]).max() < 1e-9 for k in rates)
        with pytest.raises(vo.DefinitionError, match=r"almost no frame .* ask for"):
            vo.integrate(vo.load(name), initial={**place, "omega1": 0.5}, **given)


def test_one_instant_where_the_velocities_are_no_frame_is_the_start() -> None:
    start = {"u": sp.pi / 2, "v": 0.5, "udot": 0.5, "vdot": 0.25}
    for options in ({}, {"method": "scipy"}, {"tol": 1e-25}, {"dense": True}):
        ball = vo.load("rubber-ball-on-plane")
        run = vo.integrate(ball, times=[0.5], initial=start, outputs=("v", "udot"), **options)
        assert (len(run), run["v"][0]) == (1, 0.5)
        assert abs(run["udot"][0] - 0.5) < 1e-15  # all velocities are made of the independent ones


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


@pytest.mark.parametrize(
    ("name", "pole"),
    [("rubber-ball-eps-minus-one", np.pi), ("gyroscopic-rubber-ball-on-sphere", 0.0)],
)
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


def test_a_ball_whose_velocities_are_dependent_at_a_pole_needs_one_chart() -> None:
    # of the charts of that ball this one leaves no velocities as they are
    start = {
        "u": 1.5707963267948966, "v": -0.42446622478013507, "u1": 0.0, "v1": 0.1573307524324422,
        "theta": -0.2411605689276512, "udot": 0.06786466656996698, "vdot": 0.27593193823758955,
        "u1dot": -0.5683099418739945, "v1dot": -0.14191765821922753,
        "thetadot": 0.14191765821922708,
    }  # fmt: skip
    system = vo.load("rubber-ball-eps-minus-one")
    alone = replace(system, charts={"both": system.charts["both poles turned"]})
    one, other = (
        vo.integrate(s, times=[0, 0.1], initial=start, outputs=()) for s in (system, alone)
    )
    assert other.state == pytest.approx(one.state, abs=1e-13)
    # back to where angles are regular, by equations that know neither frame nor chart
    last = all_velocities(alone, {name: other[name][-1] for name in other.names})
    truth = multiplier_motion(alone, last, np.array([0.1, 0.01]))
    assert truth[0, -1] == pytest.approx(np.pi / 2 + 0.01 * start["udot"], abs=1e-5)


@pytest.mark.parametrize(("method", "tol"), [("auto", 1e-13), ("scipy", 1e-13), ("flint", 1e-20)])
def test_a_start_at_which_constraints_divide_by_zero_is_refused(method: str, tol: float) -> None:
    x, y = sp.symbols("x y")
    system = vo.System(
        name="hyperbola",
        fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2,
        constraints=(velocity(y) - 1 / x,),
    )
    with pytest.raises(vo.DefinitionError, match="not defined at the initial point"):
        vo.integrate(system, initial={x: 0, "xdot": 1}, times=[0, 1], method=method, tol=tol)


def _racers() -> tuple[vo.System, vo.System]:
    """The roller racer with the frame (v, phi'), singular where a cos(phi) + b = 0, and its own."""
    racer = vo.load("roller-racer")
    x, y, theta, phi, v, f = sp.symbols("x y theta phi v f")
    along = velocity(x) * sp.cos(theta) + velocity(y) * sp.sin(theta)
    handle = vo.System(
        "handle", vo.Fibration(base=(x, phi), fibre=(y, theta)), racer.lagrangian,
        constraints=racer.constraints, parameters=racer.parameters,
        frame=vo.Frame.quasi({v: along, f: velocity(phi)}),
    )  # fmt: skip
    return handle, racer


def _rolling(phi: float, v: float, w: float) -> dict[str, float]:
    """A start of the roller racer, a = 1, b = 3/10, that meets its constraints."""
    turn = (v * np.sin(phi) - (np.cos(phi) + 0.3) * w) / 0.3
    dots = {"xdot": v * np.cos(0.4), "ydot": v * np.sin(0.4), "thetadot": w, "phidot": turn}
    return {"theta": 0.4, "phi": phi, **dots}


def test_velocities_that_fit_are_not_said_to_be_moved() -> None:
    start = _rolling(float(np.arccos(-0.3)), 0.7, 1.3)
    runs = [
        vo.integrate(system, initial=start, times=[0, 6], project=True, outputs=("x", "phi"))
        for system in _racers()
    ]
    assert runs[0].notes == runs[1].notes == ()
    assert all(abs(runs[0][name][-1] - runs[1][name][-1]) < 1e-11 for name in ("x", "phi"))


@pytest.mark.parametrize("offset", [0.0, -0.3, -1.0])
def test_the_run_starts_where_its_note_says(offset: float) -> None:
    """Also in another split: where it is singular, and where the motion comes there later."""
    start = {**_rolling(float(np.arccos(-0.3)) + offset, 0.7, 1.3), "xdot": 2.0}
    for system in _racers():
        dots = ("xdot", "ydot", "thetadot", "phidot")
        run = vo.integrate(system, initial=start, times=[0, 6], project=True, outputs=dots)
        (note,) = run.notes
        assert "velocities were moved" in note
        for name in dots:
            told = [part.split(" to ")[1].rstrip(")") for part in note.split(", ") if name in part]
            assert abs(float(told[0] if told else start[name]) - run[name][0]) < 1e-5
        first = {k: float(run[k][0]) for k in dots}
        again = vo.integrate(system, initial={**start, **first}, times=[0, 6], outputs=dots)
        assert max(abs(again[k][-1] - run[k][-1]) for k in dots) < 1e-9
