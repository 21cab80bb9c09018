"""One system, registered by its object."""

import sympy as sp

from voronec import Fibration, System, velocity

s, m = sp.symbols("s m")
SLED = System(
    name="plugin-sled",
    title="A sled on a straight track",
    fibration=Fibration(base=(s,)),
    lagrangian=m * velocity(s) ** 2 / 2,
    parameters=(m,),
)
