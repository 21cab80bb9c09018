"""Signs, cases and floors of floors, and conditions on what is saturated.

What is expected is the same force written without floors, by the signs of sines or by plain
comparisons.
"""

import numpy as np
import pytest
import sympy as sp

import voronec as vo

pytestmark = pytest.mark.slow

x, t = sp.Symbol("x"), vo.time
Dx = vo.velocity(x)
METHODS = ("heyoka", "scipy", "flint")
HALF = sp.Rational(1, 2)
tooth = sp.Mod(x, 1)
steep = sp.Min(x, 1)


def motion(force, method, start=(0.1, 1), end=4):
    system = vo.System(
        name="mass point",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=Dx**2 / 2,
        forces={x: force},
    )
    tol = 1e-30 if method == "flint" else 1e-13
    return vo.integrate(
        system,
        initial=dict(zip((x, Dx), start, strict=True)),
        times=np.linspace(0, end, 5),
        method=method,
        tol=tol,
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("force", "plain"),
    [
        (sp.sign(HALF - tooth), sp.sign(sp.sin(2 * sp.pi * x))),
        (sp.Abs(tooth - HALF), sp.acos(sp.cos(2 * sp.pi * (x - HALF))) / (2 * sp.pi)),
        (sp.floor(3 * tooth), sp.floor(3 * x) - 3 * sp.floor(x)),
        (sp.floor(sp.floor(x) / 2) - x / 9, sp.floor(x / 2) - x / 9),
        (sp.sign(HALF - sp.Mod(t, 1)), sp.sign(sp.sin(2 * sp.pi * t))),
        (
            sp.Piecewise((-3, sp.floor(x) >= 1), (1, True)),
            sp.Piecewise((-3, x >= 1), (1, True)),
        ),
        (
            sp.Piecewise((5, sp.Eq(sp.floor(x), 1)), (-1, True)),
            sp.Piecewise((5, (x >= 1) & (x < 2)), (-1, True)),
        ),
    ],
)
def test_signs_and_floors_of_floors_are_those_of_the_place(force, plain, method):
    found, expected = motion(force, method), motion(plain, method)
    assert max(abs(found["x"] - expected["x"])) < 1e-10


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("condition", "plain"),
    [
        (steep >= 1, x >= 1),
        (sp.Eq(steep, 1), x >= 1),
        (steep > 1, sp.false),
        (x >= sp.Max(x, 1), x >= 1),
        (sp.Max(-1, steep) < -1, sp.false),
    ],
)
def test_a_condition_may_stand_at_its_bound_for_a_while(condition, plain, method):
    """min(x, 1) - 1 is zero wherever x is greater than 1: no switching surface, but a value of the
    condition."""
    found, expected = (
        motion(sp.Piecewise((-5, c), (1 - x / 3, True)), method, (3, 0)) for c in (condition, plain)
    )
    assert max(abs(found["x"] - expected["x"])) < 1e-11
    assert found["x"].min() < -1 or plain == sp.false


@pytest.mark.parametrize("force", [sp.floor(x) + HALF, sp.floor(Dx) + HALF])
def test_a_floor_that_leads_away_on_both_sides_determines_no_motion(force):
    with pytest.raises(vo.IntegrationError, match=r"may leave x(dot)? = 0 on either side"):
        motion(force, "scipy", (0, 0))


def test_a_train_of_pulses_counts_all_of_them():
    """x' grows by a quarter of each unit of time, x is a parabola in pieces."""
    pulses = sp.Piecewise((1, sp.Mod(t, 1) < sp.Rational(1, 4)), (0, True))
    run = motion(pulses, "heyoka", (0, 0), 400)
    assert abs(run["xdot"][-1] - 100) < 1e-10
    # each pulse at k gives (399 - k + 7/8)/4 of way
    assert abs(run["x"][-1] - (400 * 399 / 2 + 400 * 7 / 8) / 4) < 1e-8
    assert run.cost.switches in (799, 800)
