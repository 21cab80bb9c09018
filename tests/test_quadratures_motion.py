"""Declared motions against integrated ones: numbers along trajectories, no algebra in between."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.equations.motions import Motions
from voronec.proof.quadratures import check_motion

pytestmark = pytest.mark.slow

GRID = np.linspace(0.0, 3.0, 6001)
STEP = GRID[1] - GRID[0]
MOTIONS = (
    ("demchenko", {}),
    ("demchenko", {"R1": -3}),
    ("zhukovsky-ball", {}),
    ("bobylev-ball", {}),
    ("bobylev-ball", {"C": sp.Rational(3, 10)}),
)
NAMES = [f"{name} {given}" for name, given in MOTIONS]


@cache
def run(position):
    """A motion that begins nowhere in particular, and what the declaration says along it."""
    name, given = MOTIONS[position]
    system = vo.load(name)
    start = {q: sp.Rational(1, 3) + i for i, q in enumerate(system.scenes["default"].initial)}
    start[sp.Symbol("u")] = 1
    if name == "demchenko":
        start |= upright(system, given)
    trajectory = vo.integrate(
        system, times=GRID, parameters=given, initial=start, method="scipy", tol=1e-13
    )
    values = {p.symbol: p.value for p in system.parameters}
    values |= {sp.Symbol(k): v for k, v in given.items()}
    state = {q: trajectory[str(q)] for q in (*system.coordinates, *system.velocities)}
    motion = system.motion

    def along(expr, extra):
        known = {**state, **extra}
        made = sp.lambdify([*known], sp.sympify(expr).xreplace(values), "numpy")
        return np.broadcast_to(made(*known.values()), GRID.shape)

    level = {s: along(e, {}) for s, e in motion.constants.items()}
    level[motion.x] = along(motion.meaning, {})
    return system, state, level, lambda expr: along(expr, level)


def upright(system, given):
    """Demchenko's momentum along the fixed axis: the coordinates in space that make it so."""
    u, s, tau, n, theta, u1 = sp.symbols("u s tau n theta u1")
    spin = {s: 1, tau: 2, n: sp.Rational(1, 2)}
    values = {p.symbol: p.value for p in system.parameters} | {u: 1, **spin}
    values |= {sp.Symbol(k): v for k, v in given.items()}
    a, b, c = (e.xreplace(values) for e in system.motion.space.vector)
    return {**spin, theta: sp.atan2(a, -b), u1: sp.atan2(sp.sqrt(a**2 + b**2), -c)}


def rate(series):
    """Its derivative by central differences of the fourth order, but for two points at each end."""
    return (8 * (series[3:-1] - series[1:-3]) - series[4:] + series[:-4]) / (12 * STEP)


def inner(series):
    return series[2:-2]


@pytest.mark.parametrize("position", range(len(MOTIONS)), ids=NAMES)
def test_constants_do_not_change(position):
    system, _, level, _ = run(position)
    for symbol in system.motion.constants:
        assert np.ptp(level[symbol]) < 1e-9 * (1 + abs(level[symbol][0])), symbol


@pytest.mark.parametrize("position", range(len(MOTIONS)), ids=NAMES)
def test_the_variable_and_the_angles_change_as_declared(position):
    system, state, level, of = run(position)
    motion = system.motion
    pace = inner(of(motion.clock))
    assert (pace > 0).all()
    moved = rate(level[motion.x]) * pace
    assert np.ptp(level[motion.x]) > 0.01  # it moves
    assert np.abs(moved**2 - inner(of(motion.quartic))).max() < 1e-6
    for q, declared in motion.integrals.items():
        found = rate(state[q]) * pace
        assert np.abs(found - inner(of(declared))).max() < 1e-6 * (1 + np.abs(found).max()), q


@pytest.mark.parametrize("position", range(len(MOTIONS)), ids=NAMES)
def test_cosines_and_velocities_are_as_declared(position):
    system, state, _, of = run(position)
    motion = system.motion
    for trace in motion.traces:
        assert np.abs(np.cos(state[trace.colatitude]) - of(trace.cosine)).max() < 1e-9
    dots = {vo.velocity(q): q for q in system.coordinates}
    for v, value in motion.velocities.items():
        total = inner(of(value.xreplace(dict.fromkeys(dots, sp.Integer(0)))))
        for dot, q in dots.items():  # all are linear in the velocities of coordinates
            if value.has(dot):
                total = total + inner(of(sp.diff(value, dot))) * rate(state[q])
        assert np.abs(total - inner(state[v])).max() < 1e-6, v


@pytest.mark.parametrize("position", [2, 3, 4], ids=NAMES[2:])
def test_the_contact_moves_over_the_plane_as_declared(position):
    system, state, level, of = run(position)
    motion = system.motion
    plane, pace = motion.plane, inner(of(motion.clock))
    vector = of(plane.direction[0]) + 1j * of(plane.direction[1])
    assert np.ptp(vector) < 1e-9
    slope = rate(level[motion.x]) * pace
    forward, left = (
        inner(of(r)) + inner(of(w)) * slope for r, w in zip(plane.rates, plane.slopes, strict=True)
    )
    moved = rate(state[plane.place[0]] + 1j * state[plane.place[1]]) * pace
    expected = inner(vector / of(plane.length)) * (forward + 1j * left)
    assert np.abs(moved).max() > 0.1
    assert np.abs(moved - expected).max() < 1e-6


def point_on_a_line(clock):
    """A point whose place is the variable itself; a direction turns with it, at a pole beyond."""
    x, q, z, E0 = sp.symbols("x q z E0")
    pace = clock.subs(z, x)
    return vo.System(
        name="point",
        fibration=vo.Fibration(base=(x,), fibre=(q,)),
        lagrangian=pace**2 * vo.velocity(x) ** 2 / 2 - 8 * x**2,
        constraints=(vo.velocity(q) * pace - 40 / (x - 9),),
        motion=vo.Quadratures(
            variable={z: x},
            constants={E0: pace**2 * vo.velocity(x) ** 2 + 16 * x**2},
            quartic=E0 - 16 * z**2,
            integrals={q: 40 / (z - 9)},
            others=(9,),
            clock=clock,
        ),
    )


@pytest.mark.parametrize("clock", [sp.Integer(1), 1 + sp.Symbol("z") ** 2 / 100])
@pytest.mark.parametrize("start", [{"x": 5, "q": 1, "xdot": -3}, {"x": 0, "q": 1, "xdot": 0}])
def test_the_variable_may_be_a_coordinate_itself(clock, start):
    system, names = point_on_a_line(clock), ("x", "q", "xdot")
    claims = [*check_motion(Motions.of(system))]
    assert claims and all(c.verdict.proved for c in claims)
    run = vo.integrate(system, times=[0, 2], initial=start, outputs=names, tol=1e-22)
    form = vo.closed_form(system, initial=start)
    rough, wrapped, exact = form.at([2]), form.modulo([2]), form.enclose(2, 25)
    for name in names:
        truth = float(run[name][-1])
        assert rough[name][0] == pytest.approx(truth, abs=2e-14)
        assert float(exact[name]) == pytest.approx(truth, abs=1e-15)
        turns = 2 * np.pi * round(truth / 2 / np.pi) if name == "q" else 0  # a length has none
        assert wrapped[name][0] == pytest.approx(truth - turns, abs=2e-14)
    long = vo.integrate(system, times=[0, 1000], initial=start, outputs=names)
    assert long.cost.method == "closed-form"
