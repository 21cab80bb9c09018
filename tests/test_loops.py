"""Holonomic constraints: a closed loop is a relation of redundant coordinates, and is told so."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import voronec as vo

x, y, theta, u, a, b = sp.symbols("x y theta u a b")
DX, DY = map(vo.velocity, (x, y))
GRID = np.linspace(0, 3, 7)


def pendulum(constraint: sp.Expr, **more: object) -> vo.System:
    return vo.System(
        name="pendulum", fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(DX**2 + DY**2) / 2 - y, constraints=(constraint,), **more,
    )  # fmt: skip


def test_a_pendulum_by_its_rod_is_the_pendulum_by_its_angle() -> None:
    rod = pendulum(x**2 + y**2 - 1)
    assert rod.fibration.relations == (x**2 + y**2 - 1,) and rod.constraints == ()
    assert vo.derive(rod).kind == "holonomic"
    angle = vo.System(
        name="angle", fibration=vo.Fibration(theta),
        lagrangian=vo.velocity(theta) ** 2 / 2 + sp.cos(theta),
    )  # fmt: skip
    start = sp.Rational(3, 5), sp.Rational(-4, 5)
    run = vo.integrate(rod, initial=dict(zip((x, y), start, strict=True)), times=GRID)
    swing = vo.integrate(angle, initial={theta: sp.asin(start[0])}, times=GRID)
    assert np.abs(run["x"] - np.sin(swing["theta"])).max() < 1e-11
    assert np.abs(run["y"] + np.cos(swing["theta"])).max() < 1e-11
    with pytest.raises(vo.DefinitionError, match="does not satisfy the relation"):
        vo.integrate(rod, initial={x: 0.6, y: -0.7}, times=GRID)


@pytest.mark.slow
def test_a_loop_beside_a_rolling_constraint() -> None:
    """A blade that is held on a circle and heads elsewhere can but turn; a body goes round."""
    phi = sp.Symbol("phi")
    held = vo.System(
        name="held-blade", fibration=vo.Fibration(base=(phi,), fibre=(x, y)),
        lagrangian=(DX**2 + DY**2 + vo.velocity(phi) ** 2) / 2,
        constraints=(DX * sp.sin(phi) - DY * sp.cos(phi), x**2 + y**2 - 4),
    )  # fmt: skip
    assert len(held.constraints) == len(held.fibration.relations) == 1
    assert list(vo.derive(held).rates) == [vo.velocity(phi), 0, 0]
    free = vo.System(
        name="held-body", fibration=vo.Fibration(base=(phi, x), fibre=(y,)),
        lagrangian=held.lagrangian, constraints=(x**2 + y**2 - 4,),
    )  # fmt: skip
    run = vo.integrate(free, initial={x: 1.2, y: 1.6, DX: 0.8, phi: 0}, times=GRID)
    around = np.arctan2(1.6, 1.2) - GRID * 1.0 / 2  # of speed 1 on the radius 2
    assert np.abs(run["x"] - 2 * np.cos(around)).max() < 1e-11


def test_a_loop_that_is_driven() -> None:
    """A rod whose length is an input: with r'' = 0 and no weight angular momentum stays."""
    rod = vo.System(
        name="growing-rod", fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(DX**2 + DY**2) / 2, constraints=(x**2 + y**2 - u**2,), inputs=(u,),
    )  # fmt: skip
    assert vo.derive(rod).kind == "holonomic"
    start = {x: 0, y: 1, DX: 1}
    run = vo.integrate(rod, initial=start, times=GRID[:3], inputs={u: 1 + vo.time / 4})
    length = 1 + GRID[:3] / 4
    angle = 4 * (1 - 1 / length)  # its rate is 1/r^2
    assert np.abs(run["x"] - length * np.sin(angle)).max() < 1e-10


def test_it_is_said_that_a_loop_is_differentiated() -> None:
    lines = str(vo.derive(pendulum(x**2 + y**2 - 1))).splitlines()
    assert any("relation, differentiated" in line and "x^2 + y^2 - 1 = 0" in line for line in lines)


def test_parameters_alone_make_no_loop() -> None:
    with pytest.raises(vo.DefinitionError, match="holds no velocity; drop it"):
        vo.derive(pendulum(a - b, parameters=(a, b)))
