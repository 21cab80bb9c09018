"""A system like those of the project."""

import sympy as sp

from voronec import Fibration, Parameter, Relation, Scene, System, velocity
from voronec_plugin.systems._shared import R, m

x, phi = sp.symbols("x phi")
kinetic = m * (velocity(x) ** 2 + R**2 * velocity(phi) ** 2) / 2

SYSTEM = System(
    name="plugin-hoop",
    title="A hoop on a line",
    fibration=Fibration(base=(phi,), fibre=(x,)),
    lagrangian=kinetic,
    constraints=(velocity(x) - R * velocity(phi),),
    parameters=(Parameter(m, 1), Parameter(R, 2)),
    integrals={"energy": kinetic},
    scenes={"default": Scene(initial={velocity(phi): 1})},
    references=("Hoop2000",),
)

# Its centre moves like a free particle; and it may be seen from the other side.
RELATIONS = (
    Relation(
        "plugin-hoop",
        "free-particle",
        state={"X": x, "Y": 0, "Xdot": R * velocity(phi), "Ydot": 0},
        parameters={"m": m},
    ),
    Relation(
        "plugin-hoop",
        "plugin-hoop",
        state={phi: -phi, x: -x, velocity(phi): -velocity(phi)},
        parameters={m: m, R: R},
        name="plugin-hoop mirrored",
    ),
)
