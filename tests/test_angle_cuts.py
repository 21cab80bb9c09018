"""Motions end at the cuts of angles in what may not jump."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

import voronec as vo
from voronec.errors import IntegrationError

x, y, z = sp.symbols("x y z")
Dx, Dy, Dz = map(vo.velocity, (x, y, z))


def system(lagrangian, *base, **more):
    return vo.System("cut", vo.Fibration(base=base), lagrangian=lagrangian, **more)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_a_potential_that_jumps_ends_the_motion(method):
    step = system(Dx**2 / 2 - sp.atan(1 / (x - 2)), x)
    speed = lambda s: np.sqrt(4 - 2 * np.arctan(0.5) - 2 * np.arctan(1 / (s - 2)))  # noqa: E731
    time = quad(lambda s: 1 / speed(s), 0, 2)[0]
    options = {"method": method, "tol": 1e-30 if method == "flint" else 1e-13}
    with pytest.raises(IntegrationError, match="angle that jumps where -2 \\+ x = 0") as error:
        vo.integrate(step, initial={x: 0, Dx: 2}, times=[0, 3], **options)
    reached = error.value.trajectory
    assert float(error.value.time) == pytest.approx(time, abs=1e-9) and not reached.events
    assert abs(reached["x"][-1] - 2) < 1e-9 and reached.outputs == ("x", "xdot")
    beside = vo.integrate(step, initial={x: 3, Dx: 1}, times=[0, 3], **options)
    assert len(beside) == 2 and not beside.events


def test_a_cut_that_the_smallest_model_does_not_hold_ends_the_motion():
    saw = system(Dx**2 / 2 - sp.atan(sp.tan(x)), x)
    start = {"initial": {x: 0, Dx: 3}, "outputs": ("xdot",)}
    with pytest.raises(IntegrationError, match=r"cos\(x\) = 0") as error:
        vo.integrate(saw, times=[0, 1], **start)
    time = 3 - np.sqrt(9 - np.pi)
    assert float(error.value.time) == pytest.approx(time, abs=1e-12)
    assert vo.integrate(saw, times=[0, 0.5], **start)["xdot"][-1] == pytest.approx(2.5)


@pytest.mark.parametrize("outputs", [(), ("y",)])
def test_a_cut_is_one_on_its_side_alone(outputs):
    turn = system((Dx**2 + Dy**2) / 2 - sp.atan2(y, x), x, y)
    more = {"times": [0, 2], "outputs": outputs, "dense": True}
    with pytest.raises(IntegrationError, match="y = 0 and x < 0"):
        vo.integrate(turn, initial={x: -5, y: -1, Dy: 2}, **more)
    through = vo.integrate(turn, initial={x: 5, y: -1, Dy: 2}, **more)
    assert through.outputs == (outputs or ("x", "y", "xdot", "ydot")) == through.at([1]).outputs
    assert through["y"][-1] > 0
    even = system((Dx**2 + Dy**2) / 2 - sp.cos(2 * sp.atan2(y, x)), x, y)
    assert len(vo.integrate(even, initial={x: -5, y: -1, Dy: 2}, **more)) == 2


def test_a_rate_that_jumps_across_its_own_cut_ends_nothing():
    """The rate of a function of place and time that jumps by a constant feels no jump; along the
    cut, or squared, it does."""
    free = system(Dx**2 / 2 + 3 * Dx * sp.atan(1 / (x - 1)), x)
    assert vo.integrate(free, initial={x: 0, Dx: 3}, times=[0, 2])["x"][-1] == pytest.approx(6)
    place = x - y - vo.time
    for rate, ends in ((Dx - Dy - 1, False), (Dx - Dy, True), ((Dx - Dy - 1) ** 2 / 9, True)):
        plane = system((Dx**2 + Dy**2) / 2 + rate * sp.atan(1 / place), x, y)
        run = {"initial": {x: -1, Dx: 4}, "times": [0, 1]}
        if ends:
            with pytest.raises(IntegrationError, match="angle that jumps"):
                vo.integrate(plane, **run)
        else:
            assert vo.integrate(plane, **run)["x"][-1] == pytest.approx(3)


def test_constraints_end_motions_at_cuts_as_well():
    bound = vo.System(
        "cut", vo.Fibration(base=(x,), fibre=(z,)), lagrangian=(Dx**2 + Dz**2) / 2,
        constraints=(Dz - sp.atan(1 / x) * Dx,),
    )  # fmt: skip
    with pytest.raises(IntegrationError, match="a constraint has an angle"):
        vo.integrate(bound, initial={x: -1, Dx: 1}, times=[0, 3])


def test_many_motions_end_at_cuts_one_by_one():
    step = system(Dx**2 / 2 - x**2 - sp.atan(1 / (x - 2)), x)
    starts = [{x: 0.5, Dx: 0.1}, {x: 0.5, Dx: 5}]
    many = vo.ensemble(step, starts=starts, times=[0, 1])
    assert list(many.finished) == [True, False] and np.isnan(many["x"][1, 1])
    found = vo.section(step, "x", starts=starts, crossings=2)
    assert [*found.errors] == [1] and (found.start == 0).sum() == 2
