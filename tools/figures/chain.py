"""A chain of bodies on blades: a program of thousands of operations."""

from __future__ import annotations

import numpy as np
import sympy as sp

import voronec as vo

SPAN = 20


def chain(links: int = 7, blades: int = 3) -> vo.System:
    """Bodies on a plane, each hinged to the one before, springs in the hinges, blades under some.

    Link j has its heading phi_j and its hinges at the distance l_j from its centre; links 1, 3, 5,
    ... up to ``blades`` of them have a blade under the centre that does not slip sideways.  So
    there are links + 2 - blades degrees of freedom: six of 7 links with 3 blades.  Parameters are
    symbols of each link, all of different values, and the start is lively.
    """
    x, y, v = sp.symbols("x y v")
    phi = sp.symbols(f"phi1:{links + 1}")
    mass, moment, half, stiff = (sp.symbols(f"{letter}1:{links + 1}") for letter in "mJlK")
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
    frame = {v: along} | {sp.Symbol(f"w{str(a)[3:]}"): vo.velocity(a) for a in free}
    symbols = [*mass, *moment, *half, *stiff[1:]]
    dice = np.random.default_rng(0)
    start = {str(q): 0.3 * dice.normal() for q in (x, *free, y, *held)}
    start |= {str(w): 0.4 * dice.normal() for w in frame}
    return vo.System(
        name="chain",
        fibration=vo.Fibration(base=(x, *free), fibre=(y, *held)),
        frame=vo.Frame.quasi(frame),
        lagrangian=kinetic - springs,
        constraints=tuple(constraints),
        parameters=tuple(
            vo.Parameter(s, 1 + sp.Rational(3 * i, 100), positive=True)
            for i, s in enumerate(symbols)
        ),
        scenes={"default": vo.Scene(initial=start, times=(0, SPAN))},
    )


SYSTEM = chain()
