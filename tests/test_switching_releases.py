"""What friction holds stands still: no step passes over its release, or over events meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad
from scipy.optimize import brentq

import voronec as vo

pytestmark = pytest.mark.slow

x = sp.Symbol("x")
SPEED, t = vo.velocity(x), vo.time
R = sp.Rational
METHODS = {"heyoka": 1e-13, "scipy": 1e-13, "c": 1e-13, "flint": 1e-20}
FRICTION = R(3, 10)
PUSHES = {
    "a short push": (1 / (1 + 100 * (t - 20) ** 2), 20.0, 40.0),
    "a bell": (sp.exp(-((t - 20) ** 2)), 20.0, 30.0),
    "a steep bell": (2 * sp.exp(-8 * (t - 4) ** 2), 4.0, 8.0),
}


@cache
def block(push: sp.Expr) -> vo.System:
    return vo.System(
        name="block", fibration=vo.Fibration(base=(x,)), lagrangian=SPEED**2 / 2,
        forces={x: push - FRICTION * sp.sign(SPEED)},
    )  # fmt: skip


def way(push: sp.Expr, top: float) -> float:
    """How far one push moves the block: from where it is greater than friction until it rests."""
    force: Callable[[float], float] = sp.lambdify(t, push - FRICTION)
    begin, end = brentq(force, top - 3, top), brentq(force, top, top + 3)

    def speed(time: float) -> float:
        knots = [p for p in (top, end) if begin < p < time]
        return float(quad(force, begin, time, points=knots or None, epsabs=1e-13, limit=200)[0])

    rest = brentq(speed, end, end + 20)
    parts = ((begin, top), (top, end), (end, rest))
    return float(sum(quad(speed, *part, epsabs=1e-12)[0] for part in parts))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", PUSHES)
def test_a_release_is_not_passed_over(name: str, method: str) -> None:
    push, top, end = PUSHES[name]
    run = vo.integrate(
        block(push), initial={x: 0, SPEED: 0}, times=[0, end], method=method, tol=METHODS[method]
    )
    assert abs(float(run["x"][-1]) - way(push, top)) < 2e-10


@pytest.mark.parametrize("method", METHODS)
def test_a_push_that_comes_more_and_more_often(method: str) -> None:
    """A chirp that is greater than friction by a fifteenth, forty switches."""
    run = vo.integrate(
        block(R(32, 100) * sp.sin(t**2)), initial={x: 0, SPEED: 0}, times=[0, 8.0], method=method,
        tol=METHODS[method],
    )  # fmt: skip
    assert run.cost.switches == 40
    # by a loop of fixed steps of 1e-6
    assert abs(float(run["x"][-1]) - 6.741692e-4) < 1e-9


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_ensembles_do_not_pass_over_a_release(method: str) -> None:
    push, top, end = PUSHES["a short push"]
    zero = np.zeros(2)
    run = vo.ensemble(block(push), {x: zero, SPEED: zero}, {}, [0, end], ("x",), method=method)
    assert not run.errors
    assert np.abs(run["x"][:, -1] - way(push, top)).max() < 2e-10


@pytest.mark.parametrize("method", METHODS)
def test_events_are_seen_while_friction_holds(method: str) -> None:
    run = vo.integrate(
        block(sp.Integer(0)), initial={x: 0, SPEED: R(3, 10)}, times=[0, 20.0], method=method,
        tol=METHODS[method], events=[vo.Event(sp.sin(5 * t), "beat")],
    )  # fmt: skip
    beats = np.array(run.events["beat"].t, dtype=float)
    assert len(beats) == 31
    assert np.abs(beats - np.pi / 5 * np.arange(1, 32)).max() < 1e-11


UNITS = {"ordinary": (1, 1), "km": (1000, 1), "ms": (1, R(1, 1000)), "Mm and ks": (10**6, 1000)}


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c", "flint"])
@pytest.mark.parametrize("name", UNITS)
def test_friction_in_other_units(name: str, method: str) -> None:
    """A spring that friction brings to rest, and a push that just reaches friction: speeds that
    friction stops have the errors of their usual size, and rounding at the top is no release."""
    length, time = UNITS[name]
    unit = length / time**2

    def end(force: sp.Expr, start: int, last: int) -> float:
        made = vo.System(
            name="block", fibration=vo.Fibration(base=(x,)), lagrangian=SPEED**2 / 2,
            forces={x: force - unit * FRICTION * sp.sign(SPEED)},
        )  # fmt: skip
        run = vo.integrate(
            made, initial={x: start * length, SPEED: 0}, times=[0, last * time], method=method
        )
        return float(run["x"][-1] / length)

    # half a turn takes 2 * 3/10 from the amplitude: 2, -1.4, 0.8, -0.2, and there it rests
    assert abs(end(-x / time**2, 2, 20) + 0.2) < 1e-11
    assert end(unit * FRICTION * sp.sin(t / time), 0, 10) == 0


y = sp.Symbol("y")


@cache
def hopper(stiffness: int) -> vo.System:
    """A body that bounces, while the ground, where it is touched, rubs; a spring holds it."""
    load = 400 * sp.Max(-y, 0)
    return vo.System(
        name="hopper", fibration=vo.Fibration(base=(x, y)),
        lagrangian=(SPEED**2 + vo.velocity(y) ** 2) / 2 - 10 * y - stiffness * x**2 / 2,
        forces={y: load, x: -FRICTION * load * sp.sign(SPEED)},
    )  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_without_a_load_friction_decides_nothing(method: str) -> None:
    """In the air at rest along the ground: the fields on both sides are one."""
    run = vo.integrate(
        hopper(0), initial={y: R(1, 2), SPEED: R(1, 8)}, times=[0, 0.2, 3], method=method
    )
    assert run["xdot"][1] == 0.125 and abs(run["xdot"][2]) < 1e-30 and run.cost.switches > 2


@pytest.mark.parametrize("method", METHODS)
def test_friction_holds_what_rests_where_its_load_sets_in(method: str) -> None:
    """Dropped without a pull along the ground: how far friction is used is 0/0 as it lands."""
    run = vo.integrate(hopper(30), initial={y: R(1, 10)}, times=[0, 0.1, 2.9], method=method)
    fall, speed = np.sqrt(0.02), np.sqrt(2)
    touch = (np.pi + 2 * np.arctan(1 / (2 * speed))) / 20  # half a swing about y = -1/40, and more
    late = (2.9 - fall) % (touch + speed / 5) - touch  # in the air since then
    assert late > 0 and run["x"][2] == 0
    assert abs(float(run["y"][2]) - (speed * late - 5 * late**2)) < 1e-11


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_friction_lets_go_just_before_its_load_is_gone(method: str) -> None:
    """Bounce after bounce x falls to 1e-9, and so near are release and the start of the flight."""
    start = {x: R(1, 20), y: R(1, 10)}
    run = vo.integrate(hopper(30), initial=start, times=[0, 3], method=method)
    # stretch after stretch by DOP853 at 3e-14
    assert abs(run["x"][1] - 1.4924e-11) < 1e-13 and run["xdot"][1] == 0


def test_two_switches_beside_which_nothing_changes_are_not_both_left_out() -> None:
    """A force where x and y are negative: from where both are positive neither alone matters."""
    force = -sp.Piecewise((1, x < 0), (0, True)) * sp.Piecewise((1, y < 0), (0, True))
    pair = vo.System(
        name="pair", fibration=vo.Fibration(base=(x, y)),
        lagrangian=(SPEED**2 + vo.velocity(y) ** 2) / 2, forces={x: force},
    )  # fmt: skip
    start = {x: R(1, 2), y: 1, SPEED: -1, vo.velocity(y): -1}
    run = vo.integrate(pair, initial=start, times=[0, 3])
    assert abs(run["x"][-1] - (0.5 - 3 - 2**2 / 2)) < 1e-12
