"""Constraints with corners, whose slopes are written as quotients by what vanishes there."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo

pytestmark = pytest.mark.slow

x, y = sp.symbols("x y")
Dx, Dy = vo.velocity(x), vo.velocity(y)


def along(slope, offset, turn, **options):
    """The end of a motion with y' = slope x' + offset, and that by multipliers, where ``turn`` is
    the rate of the constraint's coefficients along the motion."""
    system = vo.System(
        name="corner",
        fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(Dx**2 + Dy**2) / 2 - x**2 / 2,
        constraints=(Dy - slope * Dx - offset,),
    )
    run = vo.integrate(system, initial={x: -0.5, y: 0, Dx: 1}, times=[0, 3], **options)
    a, b, rate = (sp.lambdify((x, Dx), e, "numpy") for e in (slope, offset, turn))

    def right(_t, q):
        # x'' = -x - s l, y'' = l, y'' = s x'' + turn
        s = a(q[0], q[2])
        push = (rate(q[0], q[2]) - s * q[0]) / (1 + s * s)
        return [q[2], s * q[2] + b(q[0], q[2]), -q[0] - s * push]

    corner = lambda _t, q: q[0]  # noqa: E731
    corner.terminal = True
    time, state = 0.0, np.array([-0.5, 0.0, 1.0])
    options = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}
    while time < 3:
        part = solve_ivp(right, (time, 3), state, events=corner, **options)
        time, state = part.t[-1], part.y[:, -1]
        if time < 3:
            state[0] = 1e-15 * np.sign(state[2])
            corner = lambda _t, q: q[0] if abs(q[0]) > 1e-9 else 1.0  # noqa: E731
            corner.terminal = True
    return np.array([run["x"][-1], run["y"][-1]]), state[:2]


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
@pytest.mark.parametrize(
    ("slope", "offset"),
    [
        (sp.Integer(1), sp.Abs(x) / 4),
        (sp.atan(x + 2), sp.Abs(x) / 4),
        (1 / (1 + sp.Abs(x)), sp.Integer(0)),
    ],
)
def test_a_corner_of_a_constraint_is_no_zero_of_a_divisor(slope, offset, method):
    side = {sp.Abs(x): x * sp.sign(x)}
    turn = Dx * (sp.diff(slope.xreplace(side), x) * Dx + sp.diff(offset.xreplace(side), x))
    turn = turn.replace(sp.Derivative, lambda *_: sp.Integer(0)).replace(
        sp.DiracDelta, lambda *_: 0
    )
    turn = turn.subs(sp.sign(x).diff(x), 0)
    found, expected = along(slope, offset, turn, method=method)
    assert abs(found - expected).max() < 1e-9


def test_slopes_of_corners_are_told_beside_what_has_no_normal_form():
    """Angles of many periods made the search for them give up: the motion was refused."""
    switch = sp.Rational(1, 4) - 5 * x / 6 + y / 5
    ends = []
    for corner in (sp.Abs(switch), switch * sp.sign(switch)):
        system = vo.System(
            name="corners",
            fibration=vo.Fibration(base=(x,), fibre=(y,)),
            lagrangian=Dx**2 / 4 + Dy**2 / 4 - x**2 - y**2,
            forces={y: -sp.Abs(sp.cos(Dx / 20 + 11 * Dy / 8 - sp.Rational(1, 15))) / 8},
            constraints=(Dy - Dx - sp.cos(5 * x / 2 + y - sp.Rational(2, 3)) * corner / 4,),
        )
        run = vo.integrate(system, initial={x: 1, y: 0.26, Dx: 0.18}, times=[0, 2])
        ends.append([run["x"][-1], run["y"][-1]])
    assert ends[0] == pytest.approx(ends[1], abs=1e-11)


def test_a_choice_between_conditions_is_a_condition():
    kept = sp.ITE(x > 0, Dx > 0, x < -1)
    system = vo.System(
        name="choice",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=Dx**2 / 2,
        forces={x: sp.Piecewise((-1, kept), (0, True))},
    )
    run = vo.integrate(system, initial={x: 0.5, Dx: 1}, times=[0, 1, 3])
    # it is braked until it stands, at t = 1, and then holds still where x > 0
    assert abs(run["x"][1] - 1) < 1e-12 and abs(run["x"][2] - 1) < 1e-12


@pytest.mark.parametrize("method", ["auto", "heyoka", "scipy"])
def test_the_sign_of_a_sawtooth_is_that_of_its_sine(method):
    """|asin(sin a)| has corners where its switching surface, asin(sin a), has corners of its own:
    heyoka's steps collapsed there."""
    saw, bend = sp.asin(sp.sin(3 * x + 1)), sp.sin(3 * x + 1) * sp.sign(sp.cos(3 * x + 1))
    both = sp.atan2(bend, sp.Abs(sp.cos(3 * x + 1)))
    for given, equal in ((sp.Abs(saw), sp.sign(sp.sin(3 * x + 1)) * saw), (sp.sign(both), None)):
        equal = sp.sign(bend) if equal is None else equal
        ends = [
            vo.integrate(
                vo.System(
                    name="sawtooth",
                    fibration=vo.Fibration(base=(x,)),
                    lagrangian=Dx**2 / 2 - x**2,
                    forces={x: -force / 6},
                ),
                initial={x: -1, Dx: sp.Rational(1, 2)},
                times=[0, 3],
                method=how,
            )["x"][-1]
            for force, how in ((given, method), (equal, "scipy"))
        ]
        assert ends[0] == pytest.approx(ends[1], abs=1e-11)
