"""``voronec new``: a file that defines a system, commented for a newcomer, and already runs."""

from __future__ import annotations

import re
from argparse import Namespace
from pathlib import Path

from voronec.cli.files import create
from voronec.cli.output import print_json
from voronec.errors import DefinitionError

__all__ = ["execute"]


def execute(arguments: Namespace) -> int:
    """Write the file into the current folder; an existing one is refused."""
    name = arguments.name
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        raise DefinitionError(
            f"'{name}' is no name for a system; use lower-case letters, digits and single hyphens, "
            "a letter first, such as 'rolling-coin'"
        )
    path = Path(name.replace("-", "_") + ".py")
    create(path, TEMPLATE.replace("@NAME@", name))
    if arguments.json:
        print_json({"system": name, "file": str(path)})
    else:
        print(f"wrote {path}; now try: voronec derive {path}; voronec run {path}")
    return 0


TEMPLATE = '''\
"""@NAME@: a skate on an inclined plane.  Change it step by step into your own system.

    voronec derive FILE     its equations of motion
    voronec run FILE        a motion, saved and drawn
"""

import sympy as sp

from voronec import Fibration, Frame, Parameter, Scene, System, velocity

# 1. Symbols: coordinates, and constants.  velocity(x) is the symbol of dx/dt.
x, y, phi = sp.symbols("x y phi")  # the point of contact (x points downhill), the heading
m, J, g, alpha = sp.symbols("m J g alpha")
Dx, Dy, Dphi = velocity(x), velocity(y), velocity(phi)

# 2. Energies: any expression of coordinates, velocities, constants and voronec.time.
kinetic = m * (Dx**2 + Dy**2) / 2 + J * Dphi**2 / 2
potential = -m * g * sp.sin(alpha) * x

# 3. Constraints: expressions that vanish, affine in the velocities.  The blade does not slip
#    sideways.
no_slip = Dx * sp.sin(phi) - Dy * sp.cos(phi)

# 4. The velocities in which you want the equations (optional): speed along the blade, turning.
v, w = sp.symbols("v w")

SYSTEM = System(
    name="@NAME@",
    title="Skate on an inclined plane",
    # As many coordinates in the fibre as there are constraints: those whose velocities follow.
    fibration=Fibration(base=(x, phi), fibre=(y,)),
    lagrangian=kinetic - potential,
    constraints=(no_slip,),
    frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
    # Constants with values for 'run'; '--set m=2' changes one.
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(J, 1, positive=True, meaning="moment of inertia"),
        Parameter(g, sp.Rational("9.81"), meaning="gravity"),
        Parameter(alpha, sp.Rational(1, 10), meaning="slope of the plane"),
    ),
    # What you know to be constant: 'run' prints how well it holds.
    integrals={"energy": kinetic + potential, "turning": Dphi},
    # Motions to look at: what is not given starts at zero.
    scenes={
        "default": Scene(
            initial={w: 1},
            times=(0.0, 20.0),
            outputs=(x, y, phi, v),
            caption="Spun on the slope, the skate does not slide down: it drifts sideways.",
        ),
    },
)
'''
