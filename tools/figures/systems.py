"""A system of the benchmarks beyond the catalogue: a ball with a gyroscope, without symmetry."""

from __future__ import annotations

import sympy as sp

import voronec as vo

__all__ = ["gyroscopic_ball"]

u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
R1, R2, M = sp.symbols("R1 R2 M", positive=True)


def gyroscopic_ball(
    moments: tuple[sp.Symbol, ...], rotor: tuple[sp.Expr, ...], quasi: bool = False
) -> vo.System:
    """A ball of radius R2 that carries a gyroscope and rolls on the outside of a fixed sphere R1.

    ``moments`` are the principal moments of inertia about the centre, ``rotor`` the constant
    angular momentum of the gyroscope in the ball; ``quasi`` takes the components (s, tau, n) of
    the angular velocity along (e_u, e_v, N) for velocities.
    """
    du, dv, dtheta, du1, dv1 = map(vo.velocity, (u, v, theta, u1, v1))
    cos, sin = sp.cos(theta), sp.sin(theta)
    meridian, parallel = du1, dv1 * sp.sin(u1)
    s = cos * meridian + sin * parallel + dv * sp.sin(u)
    tau = sin * meridian - cos * parallel - du
    n = -dtheta - dv * sp.cos(u) - dv1 * sp.cos(u1)
    outward = s * sp.cos(u) + n * sp.sin(u)  # along the equator's normal of the meridian plane
    omega = (
        outward * sp.cos(v) - tau * sp.sin(v),
        outward * sp.sin(v) + tau * sp.cos(v),
        n * sp.cos(u) - s * sp.sin(u),
    )
    spins = zip(moments, omega, strict=True)
    kinetic = sp.Add(*[moment * w**2 for moment, w in spins]) / 2
    kinetic += M * (R1 + R2) ** 2 * (meridian**2 + parallel**2) / 2
    gyroscope = sp.Add(*[k * w for k, w in zip(rotor, omega, strict=True)])
    symbols = {*moments, R1, R2, M} | set().union(*(sp.sympify(k).free_symbols for k in rotor))
    frame = vo.Frame.quasi(dict(zip(sp.symbols("s tau n"), (s, tau, n), strict=True)))
    return vo.System(
        name="gyroscopic-ball",
        fibration=vo.Fibration(base=(u, v, theta), fibre=(u1, v1)),
        lagrangian=kinetic + gyroscope,
        constraints=(
            (R1 + R2) * (cos * parallel - sin * meridian) + R2 * tau,
            (R1 + R2) * (cos * meridian + sin * parallel) - R2 * s,
        ),
        parameters=tuple(sorted(symbols, key=str)),
        frame=frame if quasi else None,
    )
