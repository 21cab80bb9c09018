"""Systems of the benchmarks beyond the catalogue: gyroscopic balls, a chain of bodies on blades."""

from __future__ import annotations

import sympy as sp

import voronec as vo

__all__ = ["chain", "gyroscopic_ball"]

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


def chain(links: int = 7, blades: int = 3, symbolic: bool = True) -> vo.System:
    """Bodies on a plane, each hinged to the one before, springs in the hinges, blades under some.

    Link j has its heading phi_j and its hinges at the distance l_j from its centre; links 1, 3, 5,
    ... up to ``blades`` of them have a blade under the centre that does not slip sideways.  So
    there are links + 2 - blades degrees of freedom: six of 7 links with 3 blades.  Parameters are
    symbols of each link where ``symbolic``, else of all links together.
    """
    x, y, v = sp.symbols("x y v")
    phi = sp.symbols(f"phi1:{links + 1}")
    numbers = range(1, links + 1)
    shared = {letter: sp.Symbol(letter) for letter in "mJlK"}

    def letters(letter: str) -> list[sp.Symbol]:
        return [sp.Symbol(f"{letter}{j}") if symbolic else shared[letter] for j in numbers]

    mass, moment, half, stiff = (letters(letter) for letter in "mJlK")
    front = sp.Matrix([vo.velocity(x), vo.velocity(y)])  # of the centre of the first link
    kinetic, springs, constraints = sp.S.Zero, sp.S.Zero, []
    for j, (angle, length) in enumerate(zip(phi, half, strict=True)):
        across = sp.Matrix([-sp.sin(angle), sp.cos(angle)])
        turn = vo.velocity(angle) * length * across
        centre = front if j == 0 else front - turn
        kinetic += (mass[j] * centre.dot(centre) + moment[j] * vo.velocity(angle) ** 2) / 2
        if j:
            springs += stiff[j] * (angle - phi[j - 1]) ** 2 / 2
        if j % 2 == 0 and j // 2 < blades:
            slip = front[0] * across[0] + front[1] * across[1]
            constraints.append(slip - (vo.velocity(angle) * length if j else 0))
        front = centre - turn
    held = phi[2 : 2 * blades : 2]
    free = [angle for angle in phi if angle not in held]
    along = vo.velocity(x) * sp.cos(phi[0]) + vo.velocity(y) * sp.sin(phi[0])
    spins = {sp.Symbol(f"w{str(angle)[3:]}"): vo.velocity(angle) for angle in free}
    symbols = [s for group in (mass, moment, half, stiff[1:]) for s in group]
    return vo.System(
        name="chain",
        fibration=vo.Fibration(base=(x, *free), fibre=(y, *held)),
        frame=vo.Frame.quasi({v: along, **spins}),
        lagrangian=kinetic - springs,
        constraints=tuple(constraints),
        parameters=tuple(vo.Parameter(s, 1, positive=True) for s in dict.fromkeys(symbols)),
    )
