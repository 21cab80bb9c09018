"""The shapes of the trajectories: where they turn, where they stop, and how they go on."""

from __future__ import annotations

import sympy as sp

import voronec as vo
from voronec.audit import Range, Study

from .. import A, k, u, u1, v, v1
from .kinds_of_motion import chain_of, equal
from .quadratures import C5, GAMMA, RATIO, level, x


def equal_steps(_: Study, __: Range) -> vo.Verdict:
    """The rates of v and v1 are functions of x alone, that of x is one up to its sign."""
    own = level()
    square = equal((own.rate(sp.cos(u)) * own.pace) ** 2, own.X)
    return chain_of(*_turn_steps(), ("(dx/dt)^2 = (k/b_2)^2 X(x)", square))


def turns(_: Study, __: Range) -> vo.Verdict:
    """The denominators in the rates of v and v1 do not change their signs."""
    return chain_of(*_turn_steps())


def _turn_steps() -> list[tuple[str, vo.Verdict]]:
    own = level()
    ball = own.rate(v) * sp.sin(u) ** 2 * own.pace
    sphere = (own.rate(v1) * sp.sin(u1) ** 2).xreplace(own.upright) * GAMMA**2 * own.pace
    return [
        ("dv/dt = k phi(x) / (b_2 sin^2 u)", equal(ball, own.phi)),
        ("dv_1/dt = k F(x) / (b_2 Gamma^2 sin^2 u_1)", equal(sphere, own.F)),
    ]


def rests(_: Study, __: Range) -> vo.Verdict:
    """The speed of the contact point on both spheres is that of psi.

    At a simple root x* of X, X'(x*) being the derivative, x - x* goes as t^2; so do phi and F if
    they vanish there, and v, v1 go as t^3: a cusp along the meridian.
    """
    own = level()
    names = own.names()
    ball = own.rate(u) ** 2 + (sp.sin(u) * own.rate(v)) ** 2
    sphere = own.rate(u1) ** 2 + (sp.sin(u1) * own.rate(v1)) ** 2
    outer = sphere * names["R_1"] ** 2
    slope = (1 - x**2) * sp.diff(own.psi, x) - 2 * x * own.psi - 2 * own.phi * sp.diff(own.phi, x)
    mixed = RATIO * GAMMA * k * (own.mu / (2 * A) * own.psi - own.phi)
    return chain_of(
        ("(b_2/k)^2 (udot^2 + sin^2 u vdot^2) = psi", equal(ball * own.pace**2, own.psi)),
        ("the speed on the sphere is the same", equal(outer, ball * names["R_2"] ** 2)),
        (
            "a root of X and of psi is one of phi",
            vo.prove_equal(own.phi**2, (1 - x**2) * own.psi - own.X),
        ),
        (
            "X' = (1 - x^2) psi' there, so that it is simple",
            vo.prove_equal(sp.diff(own.X, x), slope),
        ),
        ("F is a combination of psi and phi", vo.prove_equal(own.F, mixed)),
        ("u1 goes as x does, the rate of cos u1 being k mu'/Gamma that of x", height()),
        *_turn_steps(),
    )


def height() -> vo.Verdict:
    """Gamma cos u1 = k mu' x - C_5: where the contact point is on the sphere."""
    return equal(level().upright[sp.cos(u1)], -(C5 - k * RATIO * x) / GAMMA)


def regular_at_poles(_: Study, __: Range) -> vo.Verdict:
    """Where X vanishes at x = 1 or -1 so does phi; X' is there -2 psi, or 2 psi."""
    own = level()
    slope = sp.diff(own.X, x)
    steps = []
    for end in (1, -1):
        turned = -2 * end * own.psi - 2 * own.phi * sp.diff(own.phi, x)
        left, right = slope.subs(x, end), turned.subs(x, end)
        steps.append((f"X'({end}) = {-2 * end} psi({end}) where phi({end}) = 0", (left, right)))
    return chain_of(*((what, vo.prove_equal(*sides)) for what, sides in steps))
