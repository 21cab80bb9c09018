"""Motions whose right answer is known otherwise, where a smallest model could go wrong unseen."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
import sympy as sp

import voronec as vo

pytestmark = pytest.mark.slow

x, y, a = sp.symbols("x y a")
X, Y = vo.velocity(x), vo.velocity(y)
METHODS = ("scipy", "lsoda", "heyoka", "flint")


def plane(lagrangian: sp.Expr, **more: object) -> vo.System:
    return vo.System(
        name="plane",
        title="Plane",
        description="A test.",
        fibration=vo.Fibration(base=(x, y), fibre=()),
        lagrangian=lagrangian,
        **more,
    )


@pytest.mark.parametrize("method", METHODS)
def test_where_all_that_is_wanted_rests_every_method_says_so(method: str) -> None:
    if method == "heyoka":
        pytest.importorskip("heyoka")
    system = plane((X**2 + Y**2) / 2 + sp.cos(x))
    event = vo.Event(vo.time - sp.Rational(7, 3), name="late", stop=True)
    motion = vo.integrate(
        system, times=np.linspace(0, 5, 6), outputs=(x, Y, vo.time * Y), initial={Y: 2},
        events=(event,), dense=True, method=method,
    )  # fmt: skip
    assert motion.stopped == "late"
    assert float(motion.events["late"].t[0]) == pytest.approx(7 / 3, abs=1e-12)
    assert float(motion[x][-1]) == 0.0
    assert float(motion[Y][-1]) == 2.0
    assert float(motion.at(1.5)[vo.time * Y][0]) == pytest.approx(3.0, abs=1e-14)


def test_precise_outputs_of_something_at_rest_are_precise_numbers() -> None:
    system = plane((X**2 + Y**2) / 2 + sp.cos(x))
    motion = vo.integrate(system, times=[0, 1], outputs=(x,), initial={}, tol=1e-40)
    assert all(isinstance(number, mpmath.mpf) for number in motion[x])


@pytest.mark.parametrize("times", [[0, 1], [1]])
def test_outputs_of_states_that_are_short_numbers_have_all_digits(times: list[int]) -> None:
    third = vo.Parameter(a, sp.Rational(1, 3))
    system = plane((X**2 + Y**2) / 2, parameters=(third,))
    wanted = (sp.sin(x), a * x, sp.sqrt(2) * x)
    start = {x: 1 - (times[-1] - times[0]), X: 1}
    motion = vo.integrate(system, times=times, outputs=wanted, initial=start, tol=1e-40)
    with mpmath.workdps(60):
        right = (mpmath.sin(1), mpmath.mpf(1) / 3, mpmath.sqrt(2))
        for output, value in zip(wanted, right, strict=True):
            assert abs(motion[output][-1] - value) < mpmath.mpf("1e-40"), output


def test_invariants_that_do_not_close_leave_the_motion_as_it_is() -> None:
    lagrangian = (X**2 + Y**2 - x**2 * y**2) / 2
    bare, claimed = plane(lagrangian), plane(lagrangian, invariants={"g": x**2})
    start, times = {x: 1.0, y: 0.3, X: 0.5, Y: 0.2}, np.linspace(0, 2, 11)
    right = vo.integrate(bare, times=times, outputs=(x,), initial=start, method="scipy")[x]
    motion = vo.integrate(claimed, times=times, outputs=("g",), initial=start, method="scipy")
    assert np.abs(motion["g"] - right**2).max() < 1e-11


def test_an_integral_that_a_zero_deprives_of_its_meaning_is_left_out() -> None:
    system = plane((X**2 + Y**2) / 2, integrals={"course": sp.atan(X / Y), "pace": Y})
    motion = vo.integrate(
        system, times=np.linspace(0, 2, 5), outputs=(x, y), initial={X: 1}, method="scipy"
    )
    assert motion[x] == pytest.approx(motion.t)
    assert not motion[y].any()
    assert "course" not in motion.drift


def test_a_false_integral_that_holds_on_one_branch_of_a_root_is_never_used() -> None:
    system = plane(
        (X**2 + Y**2) / 2, forces={x: -x, y: -2 * x}, integrals={"false": Y - X - sp.sqrt(X**2)}
    )
    t = np.linspace(0, 6, 61)
    start = {x: 1.0, X: 0.5, Y: 0.2}
    motion = vo.integrate(system, times=t, outputs=(X, Y), initial=start, method="scipy")
    right = 0.5 * np.cos(t) - np.sin(t)
    assert np.abs(motion[X] - right).max() < 1e-10
    assert np.abs(motion[Y] - (0.2 + 2 * (right - 0.5))).max() < 1e-10


@pytest.mark.parametrize("turning", [3.0, -40.0])
@pytest.mark.parametrize("begin", [-20.0, -np.pi, np.pi / 2, 7.5])
@pytest.mark.parametrize("count", [11, 120])
def test_an_angle_read_off_is_on_its_branch(begin: float, turning: float, count: int) -> None:
    system = plane((X**2 + Y**2 - x**2) / 2, invariants={"h": x, "g1": sp.cos(y), "g2": sp.sin(y)})
    t = np.linspace(1, -5, count)
    start = {x: 1, y: begin, X: 0.5, Y: turning}
    motion = vo.integrate(system, times=t, outputs=(y,), initial=start, method="scipy")
    assert np.abs(motion[y] - (begin + turning * (t - 1))).max() < 1e-9


def test_a_constraint_that_is_affine_and_holds_the_time_gives_newtons_motion() -> None:
    from scipy.integrate import solve_ivp

    z, t = sp.Symbol("z"), vo.time
    Z = vo.velocity(z)
    system = vo.System(
        name="affine", title="Affine", description="A test.",
        fibration=vo.Fibration(base=(x, y), fibre=(z,)),
        lagrangian=(X**2 + Y**2 + Z**2) / 2,
        constraints=(Z - (sp.sin(t) * X + y * X + t),),
    )  # fmt: skip

    def newton(at: float, state: np.ndarray) -> list[float]:
        vx, vy, vz = state[3:]
        slope = np.sin(at) + state[1]
        row = np.array([-slope, 0.0, 1.0])
        force = row * (1 + (np.cos(at) + vy) * vx) / (row @ row)
        return [vx, vy, vz, *force]

    grid = np.linspace(1.0, 4.0, 13)
    begin = [0.3, 0.2, 0.1, 0.5, -0.4, (np.sin(1) + 0.2) * 0.5 + 1]
    run = solve_ivp(newton, (1, 4), begin, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=grid)
    start = {x: 0.3, y: 0.2, z: 0.1, Z: begin[5], Y: -0.4, X: 0.5}
    for k, wanted in enumerate((x, y, z, X, Y, Z)):
        motion = vo.integrate(system, times=grid, outputs=(wanted,), initial=start, method="scipy")
        assert np.abs(motion[wanted] - run.y[k]).max() < 1e-9, wanted
