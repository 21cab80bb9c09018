"""The rattleback: a heavy ellipsoid on a plane whose axes of inertia are turned against its own.

The axes of the ellipsoid are a, b, c, with the centre of mass in the middle; the inertia has the
product I12 in these axes, so that two of its principal axes are turned about the third.  gamma is
the vertical and G the angular momentum about the point of contact, in the axes of the ellipsoid;
with S = diag(a^2, b^2, c^2), h = (gamma, S gamma)^(1/2) the height and r = -S gamma/h the contact,

    G' = G x omega + m r' x (omega x r) + m g r x gamma,    gamma' = gamma x omega,

where G = I omega + m r x (omega x r).  Spun against its hand, the body begins to rattle and turns
back, though it is conservative and reversible: no measure keeps motions from attracting each other
[Walker1896, GarciaHubbard1988].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Case,
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Relation,
    Scene,
    Shape,
    System,
    kinematics,
    velocity,
)
from voronec.kinematics import cross, dot, matrix_product

x, y, phi, theta, psi = sp.symbols("x y phi theta psi")
gamma, omega, height = sp.symbols("gamma1:4"), sp.symbols("omega1:4"), sp.Symbol("height")
m, g = sp.symbols("m g")
axes, moments, I12 = sp.symbols("a b c"), sp.symbols("I1:4"), sp.Symbol("I12")
a, b, c = axes
I1, I2, I3 = moments

product = sp.Matrix([[0, I12, 0], [I12, 0, 0], [0, 0, 0]])
body = kinematics.ConvexBody.ellipsoid(axes, gamma, height)
spin = sp.Matrix(omega)
normal_rate = body.rolling_rate(omega)
momentum = body.momentum(m, moments, omega) + I12 * sp.Matrix([omega[1], omega[0], 0])
momentum_rate = body.momentum_rate(momentum, m, omega, normal_rate, m * g)

# The same in angles that are regular where the third axis is upright: heading, roll and pitch.
rotation = kinematics.Rotation.euler("zxy", phi, theta, psi)
vertical = tuple(rotation.matrix.row(2))
level = sp.sqrt(sum((q * n) ** 2 for q, n in zip(axes, vertical, strict=True)))
ellipsoid = kinematics.ConvexBody.ellipsoid(axes, vertical, level)
rates = rotation.body_rates
# of the centre, where the contact rests
across = matrix_product(-rotation.matrix, cross(rates, ellipsoid.arm))
climb_rate = -dot(ellipsoid.arm, ellipsoid.rolling_rate(rates))
inertia = sp.diag(*moments) + product
kinetic = kinematics.kinetic_energy(m, (velocity(x), velocity(y), climb_rate), inertia, rates)

# A ball of radius a, about its contact; D = m a^2.
normal = sp.Matrix(gamma)
response = matrix_product((inertia + m * a**2 * sp.eye(3)).inv(), normal)
share = m * a**2 * dot(normal, response)

SYSTEM = System(
    name="rattleback",
    title="Rattleback",
    description="A heavy ellipsoid on a plane whose principal axes of inertia are turned against "
    "the axes of its surface.",
    sketch=kinematics.rolling_sketch(body="ellipsoid", attitude=(phi, theta, psi), place=(x, y)),
    fibration=Fibration(base=(phi, theta, psi), fibre=(x, y)),
    frame=Frame.quasi(dict(zip(omega, rates, strict=True))),
    lagrangian=kinetic - m * g * level,
    constraints=(velocity(x) - across[0], velocity(y) - across[1]),
    meanings={
        **kinematics.place_meanings((x, y), "the centre over the plane"),
        phi: "heading, Euler's angle about the vertical",
        theta: "tilt, Euler's angle about the first axis, after the heading",
        psi: "roll, Euler's angle about the body's second axis",
        **kinematics.vector_meanings(omega),
        **kinematics.vector_meanings(map(str, gamma), "the vertical"),
        "height": "height of the centre over the plane",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(g, 1, meaning="gravity"),
        *Parameter.each(axes, (5, 1, "4/5"), positive=True, meaning="semi-axis"),
        *Parameter.each(
            moments, ("2/5", 5, 5), positive=True, meaning="moment about an axis of the surface"
        ),
        Parameter(I12, "-1/4", meaning="product of inertia: the hand"),
    ),
    invariants={**dict(zip(map(str, gamma), vertical, strict=True)), "height": level},
    integrals={"energy": dot(momentum, spin) / 2 + m * g * height},
    equations={
        "momentum": Equation(tuple(momentum), tuple(momentum_rate)),
        "normal": Equation(gamma, tuple(normal_rate)),
    },
    essential=(theta, psi, *omega),
    cases={
        "round": Case(
            parameters={b: a, c: a},
            integrals={
                "momentum squared": dot(momentum, momentum).xreplace({b: a, c: a, height: a}),
                "vertical momentum": dot(normal, inertia * spin),
            },
            measure=Measure(sp.sqrt(1 - share), (*gamma, height, *omega)),
            integrable="Euler-Jacobi",
            note="The ball of Chaplygin, whose weight does nothing: here are two more integrals, "
            "and a measure.",
        ),
    },
    scenes={
        "default": Scene(
            initial={theta: "1/100", omega[0]: "1/50", omega[2]: "-1/2"},
            times=(0.0, 100.0),
            outputs=(x, y, *omega),
            caption="Spun against its hand, the rattleback rattles, and turns back.",
        ),
    },
    shapes=(
        Shape.ellipsoid(
            axes,
            centre=(x, y, level),
            attitude=rotation.matrix,
            contact=sp.Matrix([x, y, level]) + matrix_product(rotation.matrix, ellipsoid.arm),
        ),
        Shape.plane(),
    ),
    references=("Walker1896", "GarciaHubbard1988", "BorisovMamaev2003Rattleback"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "ellipsoid-on-plane",
        {I12: 0},
        note="The axes of inertia are those of the surface: no hand.",
    ),
    Relation.into(
        SYSTEM,
        "rattleback",
        {w: -w for w in omega},
        clock=-1,
        name="rattleback reversed",
        note="Time runs back.",
    ),
    Relation.into(
        SYSTEM,
        "rattleback",
        {q: -q for q in (gamma[0], omega[1], omega[2], I12)},
        name="rattleback mirrored",
        note="The mirror image has the other hand.",
    ),
)
