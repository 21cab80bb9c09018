"""``voronec new``: a file that defines a system, commented for a newcomer, and already runs.

The mechanisms with which a newcomer begins stand here, as Python and as TOML.
"""

from __future__ import annotations

import re
from argparse import Namespace
from pathlib import Path
from typing import NamedTuple

from voronec.cli.files import create
from voronec.cli.output import print_json
from voronec.errors import DefinitionError

__all__ = ["Mechanism", "execute"]


def execute(arguments: Namespace) -> int:
    """Write the file into the current folder; an existing one is refused."""
    name = arguments.name
    if not re.fullmatch(r"[a-z][a-z0-9]*(-[a-z0-9]+)*", name):
        raise DefinitionError(
            f"'{name}' is no name for a system; use lower-case letters, digits and single hyphens, "
            "a letter first, such as 'rolling-coin'"
        )
    mechanism = _mechanism_of(name)
    path = Path(name.replace("-", "_") + (".toml" if arguments.toml else ".py"))
    text = mechanism.toml if arguments.toml else mechanism.python
    create(path, text.replace("@NAME@", name))
    if arguments.json:
        print_json({"system": name, "file": str(path), "mechanism": mechanism.title})
    else:
        print(
            f"wrote {path}, {mechanism.title}; now try: voronec derive {path}; voronec run {path}; "
            f"voronec view {path}"
        )
    return 0


class Mechanism(NamedTuple):
    """A mechanism in words, the words of a name that mean it, and its two files; ``@NAME@`` stands
    for the name of the system."""

    title: str
    words: tuple[str, ...]
    python: str
    toml: str


def _mechanism_of(name: str) -> Mechanism:
    """The mechanism that a name such as ``rolling-coin`` means; a skate where it means none."""
    words = {*name.split("-")}
    return next((m for m in MECHANISMS if words & {*m.words}), MECHANISMS[0])


SKATE_PYTHON = '''\
"""@NAME@: a skate on an inclined plane.  Change it step by step into your own system.

    voronec derive FILE     its equations of motion
    voronec run FILE        a motion, saved and drawn
    voronec view FILE       the motion in space, a page for the browser
"""

import sympy as sp

from voronec import Fibration, Frame, Parameter, Scene, Shape, Sketch, System, velocity

# 1. Symbols: coordinates, and constants.  velocity(x) is the symbol of dx/dt.
x, y, phi = sp.symbols("x y phi")
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
    # What they are, in words: 'show' tells it.
    meanings={
        x: "distance downhill of the point of contact",
        y: "its distance across the slope",
        phi: "heading of the blade",
        v: "speed along the blade",
        w: "rate of turning",
    },
    # What is seen, for 'view', and a sketch, for 'show --out'.
    shapes=(
        Shape.box((1, sp.S(1) / 20, sp.S(1) / 5), centre=(x, y, sp.S(1) / 10), attitude=phi),
        Shape.plane(),
    ),
    sketch=Sketch("seen from above; x points downhill")
    .axes(x, y)
    .box((1.4, 0.9), 0.9, 0.05, 30)
    .line((1.4, 0.9), (2.2, 0.9), look="thin")
    .angle((1.4, 0.9), 0.65, 0, 30, phi)
    .dot((1.4, 0.9), "(x, y)", 120),
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

SKATE_TOML = """\
# @NAME@: a skate on an inclined plane.  Change it step by step into your own system.
#
#     voronec derive FILE     its equations of motion
#     voronec run FILE        a motion, saved and drawn
#     voronec view FILE       the motion in space, a page for the browser
#
# Formulas stand in quotes.  The velocity of x is xdot, the time is t; powers are x^2.

name = "@NAME@"
title = "Skate on an inclined plane"

# Energies: kinetic less potential.  What is defined below may be used here.
lagrangian = "kinetic - potential"

# What must hold, linear in the velocities: the blade does not slip sideways.
constraints = ["xdot*sin(phi) = ydot*cos(phi)"]

# As many coordinates as there are constraints: those whose velocities follow from them.
fibre = ["y"]

[coordinates]  # each with what it is, in words
x = "distance downhill of the point of contact"
y = "its distance across the slope"
phi = "heading of the blade"

[velocities]  # those in which you want the equations; may be left out
v = { is = "xdot*cos(phi) + ydot*sin(phi)", meaning = "speed along the blade" }
w = { is = "phidot", meaning = "rate of turning" }

[parameters]  # constants with values for 'run'; '--set m=2' changes one
m = { value = 1, positive = true, meaning = "mass" }
J = { value = 1, positive = true, meaning = "moment of inertia" }
g = { value = 9.81, meaning = "gravity" }
alpha = { value = "1/10", meaning = "slope of the plane" }

[definitions]
kinetic = "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2"
potential = "-m*g*sin(alpha)*x"

[integrals]  # what you know to be constant: 'run' prints how well it holds
energy = "kinetic + potential"
turning = "phidot"

[scenes.default]  # a motion to look at: what is not given starts at zero
initial = { w = 1 }
times = [0, 20]
outputs = ["x", "y", "phi", "v"]
caption = "Spun on the slope, the skate does not slide down: it drifts sideways."

[[shapes]]  # what is seen, for 'view'
kind = "box"
lengths = [1, "1/20", "1/5"]
centre = ["x", "y", "1/10"]
attitude = "phi"  # the heading; for other turns an array, [{ axis = "z", angle = "phi" }, ...]

[[shapes]]
kind = "plane"

[sketch]  # for 'show --out sketch.svg': lengths are those of the drawing, angles in degrees
view = "seen from above; x points downhill"
strokes = [
  { draw = "axes", x = "x", y = "y" },
  { draw = "box", at = [1.4, 0.9], length = 0.9, width = 0.05, angle = 30 },
  { draw = "line", points = [[1.4, 0.9], [2.2, 0.9]], look = "thin" },
  { draw = "angle", at = [1.4, 0.9], radius = 0.65, start = 0, end = 30, label = "phi" },
  { draw = "dot", at = [1.4, 0.9], label = "(x, y)", side = 120 },
]
"""

COIN_PYTHON = '''\
"""@NAME@: a coin that rolls upright on a table.  Change it step by step into your own system.

    voronec derive FILE     its equations of motion
    voronec run FILE        a motion, saved and drawn
    voronec view FILE       the motion in space, a page for the browser
"""

import sympy as sp

from voronec import Fibration, Parameter, Scene, Shape, Sketch, System, velocity

# 1. Symbols: coordinates, and constants.  velocity(x) is the symbol of dx/dt.
x, y, phi, theta = sp.symbols("x y phi theta")
m, R, J, A = sp.symbols("m R J A")
Dx, Dy, Dphi, Dtheta = map(velocity, (x, y, phi, theta))

# 2. Energy: any expression of coordinates, velocities, constants and voronec.time.
kinetic = m * (Dx**2 + Dy**2) / 2 + J * Dphi**2 / 2 + A * Dtheta**2 / 2

# 3. Constraints: expressions that vanish, affine in the velocities.  The point of contact moves
#    along the heading, as fast as the rim turns.
rolling = (Dx - R * Dtheta * sp.cos(phi), Dy - R * Dtheta * sp.sin(phi))

SYSTEM = System(
    name="@NAME@",
    title="Coin that rolls upright on a table",
    # As many coordinates in the fibre as there are constraints: those whose velocities follow.
    fibration=Fibration(base=(phi, theta), fibre=(x, y)),
    lagrangian=kinetic,
    constraints=rolling,
    # Constants with values for 'run'; '--set m=2' changes one.
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(J, sp.Rational(1, 4), positive=True, meaning="inertia about a diameter"),
        Parameter(A, sp.Rational(1, 2), positive=True, meaning="inertia about the axis"),
    ),
    # What you know to be constant: 'run' prints how well it holds.
    integrals={"energy": kinetic, "turning": Dphi, "rolling": Dtheta},
    # What they are, in words: 'show' tells it.
    meanings={
        x: "place of the point of contact on the table",
        y: "place of the point of contact on the table",
        phi: "heading, the angle from the x axis",
        theta: "angle by which the coin has rolled",
    },
    # What is seen, for 'view', and a sketch, for 'show --out'.
    sketch=Sketch("seen from above")
    .axes(x, y)
    .wheel((1.4, 0.9), 30, 0.9)
    .line((1.4, 0.9), (2.2, 0.9), look="thin")
    .angle((1.4, 0.9), 0.65, 0, 30, phi)
    .dot((1.4, 0.9), "(x, y)", 120),
    shapes=(
        Shape.wheel(R, phi, theta, centre=(x, y, R), contact=(x, y, 0)),
        Shape.plane(),
    ),
    # Motions to look at: what is not given starts at zero.
    scenes={
        "default": Scene(
            initial={Dphi: sp.Rational(1, 2), Dtheta: 1},
            times=(0.0, 20.0),
            outputs=(x, y, phi, theta),
            caption="The coin turns at an even rate, and so it rolls on a circle.",
        ),
    },
)
'''

COIN_TOML = """\
# @NAME@: a coin that rolls upright on a table.  Change it step by step into your own system.
#
#     voronec derive FILE     its equations of motion
#     voronec run FILE        a motion, saved and drawn
#     voronec view FILE       the motion in space, a page for the browser
#
# Formulas stand in quotes.  The velocity of x is xdot, the time is t; powers are x^2.

name = "@NAME@"
title = "Coin that rolls upright on a table"

# Kinetic less potential energy; what is defined below may be used here.
lagrangian = "kinetic"

# What must hold, linear in the velocities: the point of contact moves along the heading, as fast as
# the rim turns.
constraints = ["xdot = R*thetadot*cos(phi)", "ydot = R*thetadot*sin(phi)"]

# As many coordinates as there are constraints: those whose velocities follow from them.
fibre = ["x", "y"]

[coordinates]  # each with what it is, in words
phi = "heading, the angle from the x axis"
theta = "angle by which the coin has rolled"
x = "place of the point of contact on the table"
y = "place of the point of contact on the table"

[parameters]  # constants with values for 'run'; '--set m=2' changes one
m = { value = 1, positive = true, meaning = "mass" }
R = { value = 1, positive = true, meaning = "radius" }
J = { value = "1/4", positive = true, meaning = "inertia about a diameter" }
A = { value = "1/2", positive = true, meaning = "inertia about the axis" }

[definitions]
kinetic = "m*(xdot^2 + ydot^2)/2 + J*phidot^2/2 + A*thetadot^2/2"

[integrals]  # what you know to be constant: 'run' prints how well it holds
energy = "kinetic"
turning = "phidot"
rolling = "thetadot"

[scenes.default]  # a motion to look at: what is not given starts at zero
initial = { phidot = "1/2", thetadot = 1 }
times = [0, 20]
outputs = ["x", "y", "phi", "theta"]
caption = "The coin turns at an even rate, and so it rolls on a circle."

[[shapes]]  # what is seen, for 'view'
kind = "wheel"
radius = "R"
heading = "phi"
turned = "theta"
centre = ["x", "y", "R"]
contact = ["x", "y", 0]

[[shapes]]
kind = "plane"

[sketch]  # for 'show --out sketch.svg': lengths are those of the drawing, angles in degrees
view = "seen from above"
strokes = [
  { draw = "axes", x = "x", y = "y" },
  { draw = "wheel", at = [1.4, 0.9], angle = 30, size = 0.9 },
  { draw = "line", points = [[1.4, 0.9], [2.2, 0.9]], look = "thin" },
  { draw = "angle", at = [1.4, 0.9], radius = 0.65, start = 0, end = 30, label = "phi" },
  { draw = "dot", at = [1.4, 0.9], label = "(x, y)", side = 120 },
]
"""

MECHANISMS = (
    Mechanism("a skate on an inclined plane", (), SKATE_PYTHON, SKATE_TOML),
    Mechanism(
        "a coin that rolls upright on a table",
        ("coin", "disc", "disk", "penny", "wheel"),
        COIN_PYTHON,
        COIN_TOML,
    ),
)
