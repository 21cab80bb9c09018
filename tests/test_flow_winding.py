"""States that grow do not loosen the steps of the others, and come out whole."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import voronec as vo

pytestmark = pytest.mark.slow


def test_an_angle_of_ten_million_radians_costs_the_others_nothing() -> None:
    pytest.importorskip("heyoka")
    equations = vo.derive(vo.load("demchenko"))
    times, outputs = np.linspace(0, 50, 11), ("u", "s", "tau", "n", "v")
    initial = {"u": 1, "s": 0.2, "n": 1.5, "u1": 1}
    small, large = (
        vo.integrate(
            equations, times=times, outputs=outputs, initial=initial | {"v": start},
            method="heyoka",
        )
        for start in (0.0, 1e7)
    )  # fmt: skip
    for name in ("u", "s", "tau", "n"):
        assert large[name] == pytest.approx(small[name], abs=1e-11), name
    assert large["v"] - 1e7 == pytest.approx(small["v"], abs=4e-9)
    assert large.cost.steps == small.cost.steps


def test_positions_beside_velocities_cost_them_no_digits() -> None:
    """Between two times at which they are taken out, positions grow and loosen the tolerance."""
    pytest.importorskip("heyoka")
    equations = vo.derive(vo.load("rattleback"))
    spin = ("omega1", "omega2", "omega3")
    parameters = {
        "m": 1.764, "g": 1.788, "a": 3.061, "b": 0.5676, "c": 0.91,
        "I1": 0.3506, "I2": 3.414, "I3": 2.834, "I12": -0.1884,
    }  # fmt: skip
    initial = {"phi": 1.444, "theta": 0.294, "psi": -2.021, "x": 0.641, "y": -0.056}
    initial |= dict(zip(spin, (0.341, 0.652, -0.557), strict=True))

    def end(method: str, tol: float, outputs: tuple[str, ...] = ()) -> np.ndarray:
        run = vo.integrate(
            equations, initial=initial, parameters=parameters, times=(0.5, 16.8), outputs=outputs,
            method=method, tol=tol,
        )  # fmt: skip
        return np.array([float(run[name][-1]) for name in spin])

    truth = end("flint", 1e-20, spin)
    alone, beside = (
        [np.abs(end("heyoka", 10.0**-k, outputs) - truth).max() for k in range(8, 14)]
        for outputs in (spin, ())
    )
    assert np.log(np.divide(beside, alone)).mean() < 0.5


@pytest.mark.parametrize("order", [1, -1])
def test_a_grid_cuts_no_step(order: int) -> None:
    q = sp.Symbol("q")
    dq = vo.velocity(q)
    turning = vo.System(
        name="turning pendulum", fibration=vo.Fibration((q,)), lagrangian=dq**2 / 2 + sp.cos(q)
    )
    steps = {
        vo.integrate(
            turning, times=order * np.linspace(0, 200, count), initial={q: 1, dq: "2.1"},
            method="heyoka", tol=1e-9,
        ).cost.steps
        for count in (2, 11, 151, 500, 900)
    }  # fmt: skip
    assert len(steps) == 1


def test_many_motions_beside_positions_that_grow_are_as_good_as_one() -> None:
    """x = 30 t grows to 3000, and pushes z: what is taken out of x costs zdot no digits."""
    pytest.importorskip("heyoka")
    x, y, z = sp.symbols("x y z")
    dx, dy, dz = map(vo.velocity, (x, y, z))
    made = vo.System(
        name="carried", fibration=vo.Fibration((x, y, z)),
        lagrangian=(dx**2 + dy**2 + dz**2) / 2 - y**2 / 2 - y**4 / 4,
        forces={z: sp.sin(x) * (1 - dz)},
    )  # fmt: skip
    initial = {x: 0.25, dx: 30, y: 1, dy: 0, z: 0, dz: 0}
    starts = [initial] * 3
    times, upwards = np.linspace(0, 100, 11), vo.Event(y, "upwards", 1)
    truth = vo.integrate(made, times=times, initial=initial, events=(upwards,), tol=1e-20)
    for grid in (times, np.linspace(0, 100, 1001)):
        many = vo.ensemble(made, starts=starts, times=grid, method="heyoka")
        for name, off in (("y", 3e-13), ("x", 1e-12), ("zdot", 1e-12)):
            wanted = truth[name].astype(float)
            found = many[name][:, :: len(grid) // 10]
            assert found == pytest.approx(np.array([wanted] * 3), abs=off), name
    passed = truth.events["upwards"]
    found = vo.section(
        made, y, outputs=(x, "zdot"), starts=starts, method="heyoka", crossings=len(passed)
    )
    for i in range(3):
        mine = found.start == i
        assert found.t[mine] == pytest.approx(passed.t.astype(float), abs=2e-13)
        assert found["x"][mine] == pytest.approx(passed["x"].astype(float), abs=4e-12)
        assert found["zdot"][mine] == pytest.approx(passed["zdot"].astype(float), abs=2e-12)
