"""A snakeboard: constraints with sums of angles, whose common factors only trigonometry shows."""

from __future__ import annotations

import sympy as sp
from sympy.physics.mechanics import dynamicsymbols

import voronec as vo

theta, psi, phi, x, y = dynamicsymbols("theta psi phi x y")
m, length, J, rotor, wheels = sp.symbols("m l J J_r J_w")
Dtheta, Dpsi, Dphi, Dx, Dy = (q.diff(vo.time) for q in (theta, psi, phi, x, y))
ENERGY = (
    m * (Dx**2 + Dy**2)
    + J * Dtheta**2
    + rotor * (Dtheta + Dpsi) ** 2
    + wheels * ((Dtheta + Dphi) ** 2 + (Dtheta - Dphi) ** 2)
) / 2
SNAKEBOARD = vo.System(
    name="snakeboard",
    fibration=vo.Fibration(base=(theta, psi, phi), fibre=(x, y)),
    lagrangian=ENERGY,
    constraints=(
        sp.cos(theta + phi) * Dy - sp.sin(theta + phi) * Dx - length * sp.cos(phi) * Dtheta,
        sp.cos(theta - phi) * Dy - sp.sin(theta - phi) * Dx + length * sp.cos(phi) * Dtheta,
    ),
    parameters=(
        vo.Parameter(m, 6),
        vo.Parameter(length, sp.Rational(1, 5)),
        vo.Parameter(J, sp.Rational(1, 10)),
        vo.Parameter(rotor, sp.Rational(1, 20)),
        vo.Parameter(wheels, sp.Rational(1, 100)),
    ),
    integrals={"energy": ENERGY},
    scenes={
        "default": vo.Scene(
            initial={theta: 0.1, phi: 0.3, Dpsi: 1, Dphi: 0.1, Dtheta: 0.2}, times=(0.0, 5.0)
        )
    },
)


def test_factors_that_divide_by_trigonometry_alone_cancel() -> None:
    eqs = vo.derive(SNAKEBOARD)
    assert eqs.mass[2, 2] == 2 * wheels
    assert eqs.mass[0, 1] == eqs.mass[1, 1] == rotor
    assert not any(
        e.has(sp.cos(phi + theta)) or e.count_ops() > 60 for e in [*eqs.mass, *eqs.force]
    )
    slide = -length * Dtheta * sp.cos(phi) / sp.sin(phi)
    assert list(eqs.rates[3:, 0]) == [slide * sp.cos(theta), slide * sp.sin(theta)]


def test_the_motion_passes_where_a_pivot_would_vanish() -> None:
    motion = vo.integrate(SNAKEBOARD, method="scipy", tol=1e-11)
    crossing = motion["theta"] + motion["phi"]
    assert crossing[0] < 1.5 < crossing[-1]  # cos(theta + phi) = 0 on the way
    assert motion.drift["energy"] < 1e-8


def test_both_routes_agree_on_the_way() -> None:
    point = {theta: sp.pi / 2 - sp.Rational(3, 10), phi: sp.Rational(3, 10), psi: 0, x: 0, y: 0}
    point |= {Dtheta: 1, Dpsi: 2, Dphi: sp.Rational(1, 7)}
    here = vo.derive(SNAKEBOARD).acceleration(point, 40)
    there = vo.multiplier_acceleration(SNAKEBOARD, point, 40)
    assert all(abs(here[q] - there[q]) < sp.Float("1e-38", 40) for q in here)
