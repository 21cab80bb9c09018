"""What a gyroscope adds to a ball: from a rotor with a coordinate of its own, to Demchenko's."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Verdict
from voronec.kinematics import Surface, kinetic_energy

from .ball import A1, A2, C1, C2
from .chaplygin_balls import (
    GAMMA,
    KAPPA,
    MOMENTS,
    OMEGA,
    R1,
    R2,
    SIGNED_RADIUS,
    Ball,
    M,
    rolling_ball,
    theta,
    u,
    u1,
    v,
    v1,
)
from .verdicts import all_equal

chi, C, W = sp.symbols("chi C W")
AXIS = sp.Matrix(sp.symbols("e1:4"))


def rotor_is_kappa() -> Verdict:
    """A rotor of axial moment C about the fixed axis e of the ball, as a coordinate chi.

    With W = (e, omega) + dchi/dt the equations are those of the ball with kappa = C W e, and W is
    constant.  The rotor's transverse moments belong to the ball.
    """
    rolling = rolling_ball(Surface.sphere(SIGNED_RADIUS, u1, v1))
    turn = AXIS.dot(sp.Matrix(rolling.spin)) + vo.velocity(chi)
    frame = dict(zip((*OMEGA, W), (*rolling.spin, turn), strict=True))
    system = vo.System(
        name="ball-with-rotor",
        fibration=vo.Fibration((u, v, theta, chi), (u1, v1)),
        frame=vo.Frame.quasi(frame),
        lagrangian=rolling.energy + C * turn**2 / 2,
        constraints=rolling.no_slip,
        parameters=(SIGNED_RADIUS, R2, M, C, *MOMENTS, *AXIS),
        invariants=dict(zip(map(str, GAMMA), rolling.normal, strict=True)),
    )
    full = vo.descend(system)
    ball = Ball.on_sphere(SIGNED_RADIUS, KAPPA).reduced
    carried = dict(zip(KAPPA, C * W * AXIS, strict=True))
    pairs = [(full.force[3], 0), *zip(full.mass[3, :], (0, 0, 0, C), strict=True)]
    pairs += zip(full.mass[:3, :3], ball.mass, strict=True)
    pairs += zip(full.force[:3], ball.force.xreplace(carried), strict=True)
    return all_equal(pairs, ball.relations)


def carried_inertia() -> tuple[sp.Matrix, sp.Matrix]:
    """Inertia matrix and gyroscopic momentum, along the ball's axes, of a ball with a rotor.

    Both are symmetric about the third axis.  The rotor's momentum about it, C_2 r, is constant, so
    that at constant r the energy is a quadratic form of omega: that of a ball without a rotor.
    """
    r, spin = sp.Symbol("r"), sp.Matrix(OMEGA)
    c, s = sp.cos(chi), sp.sin(chi)
    turned = sp.Matrix([c * spin[0] + s * spin[1], c * spin[1] - s * spin[0], r])
    energy = kinetic_energy(0, (0, 0, 0), (A1, A1, C1), spin)
    energy += kinetic_energy(0, (0, 0, 0), (A2, A2, C2), turned)
    return sp.hessian(energy, spin), sp.Matrix([0, 0, sp.diff(energy, r)])


def is_demchenkos(system: vo.System, condition: sp.Expr) -> Verdict:
    """Whether the ball with a rotor is that system, where its moment C_1 is as a condition says.

    The moments of the ball with kappa are those of ball and rotor together, less the rotor's about
    its axis; the condition has to make the three of them equal.
    """
    known = {p.name: p.symbol for p in system.parameters}
    inertia, kappa = carried_inertia()
    inertia = inertia.xreplace({C1: condition})
    equal = zip(inertia, known["A"] * sp.eye(3), strict=True)
    pairs = [(a.xreplace({A1: known["A"] - A2}), b) for a, b in equal]
    pairs += zip(kappa[:2], (0, 0), strict=True)
    to_theirs = {R1: known["R1"], R2: known["R2"], M: known["M"]}
    to_theirs |= {**dict.fromkeys(MOMENTS, known["A"]), KAPPA[2]: known["k"]}
    mine = Ball.on_sphere(R1, sp.ImmutableMatrix([0, 0, KAPPA[2]])).reduced.system
    pairs += [(sp.sympify(mine.lagrangian).xreplace(to_theirs), system.lagrangian)]
    rows = zip(mine.constraints, system.constraints, strict=True)
    pairs += [(sp.sympify(a).xreplace(to_theirs), b) for a, b in rows]
    return all_equal(pairs)


def on_the_plane(sphere: Ball, plane: Ball) -> Verdict:
    """Whether the equations on a sphere become those on a plane as its radius grows."""
    curvature = sp.Symbol("h")

    def flat(value: sp.Expr) -> sp.Expr:
        return sp.cancel(sp.together(value.xreplace({R1: 1 / curvature}))).xreplace(
            {curvature: sp.Integer(0)}
        )

    pairs: list[tuple[Any, Any]] = [(flat(sphere.epsilon), 1), (plane.epsilon, 1)]
    for name in ("mass", "force", "rates"):
        ours, theirs = getattr(sphere.reduced, name), getattr(plane.reduced, name)
        pairs += zip(map(flat, ours), theirs, strict=True)
    return all_equal(pairs, plane.relations)
