"""Demchenko's ball: a ball with a gyroscope rolls without slipping over a sphere.

C. Neumann's coordinates: (u, v) of the contact on the ball, (u1, v1) on the sphere, theta between
the coordinate lines; s, tau, n are the components of the ball's angular velocity along e_u, e_v and
the normal.  Zhukovsky's condition C1 = A1 + A2 makes the inertia of ball and rotor, less the
rotor's axial part, spherical; A is that moment, and k the rotor's constant axial momentum.

R1 is signed: outer rolling R1 > 0; inside the sphere R1 < 0 and |R1| > R2; a shell around the
sphere R1 < 0 and |R1| < R2.  The centre is at (R1 + R2) n1 throughout.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Case,
    Fibration,
    Frame,
    Limit,
    Measure,
    Parameter,
    Quadratures,
    Relation,
    Scene,
    Space,
    Square,
    System,
    Trace,
    kinematics,
    velocity,
)
from voronec.kinematics import dot, matrix_product

u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
s, tau, n = sp.symbols("s tau n")
R1, R2, M, A, k = sp.symbols("R1 R2 M A k")

contact = kinematics.RollingContact(
    kinematics.Surface.sphere(R2, u, v), kinematics.Surface.sphere(R1, u1, v1), theta
)
kinetic = kinematics.kinetic_energy(M, contact.centre_velocity, (A, A, A), contact.spin)
axis = contact.body.frame.row(2)  # the rotor's axis z along (u, v, n)
rotor = kinematics.axial_rotor(k, axis, contact.spin)
# The same in a chart whose polar axis is another one of the ball, across the rotor's.
turned_rotor = kinematics.axial_rotor(k, contact.body.frame.row(0), contact.spin)

# On the constraints: P = M R2^2 + A, and the angular momentum about the contact point, with the
# rotor's part, along (u, v, n) and in space.
P = M * R2**2 + A
momentum = sp.Matrix([P * s, P * tau, A * n]) + k * axis.T
along_contact = matrix_product(contact.fixed.frame, contact.turn)  # (e_u, e_v, n) in space
in_space = matrix_product(along_contact, momentum)
energy = (P * (s**2 + tau**2) + A * n**2) / 2
axial = A * n + k * (1 + R2 / R1) * sp.cos(u)
# P s sin(u) is a quadratic function of cos(u) along each motion; this is its constant term.
level = (
    P * s * sp.sin(u)
    - (1 + (1 + R2 / R1) * M * R2**2 / A) * axial * sp.cos(u)
    + k * (1 + R2 / R1) * ((1 + R2 / R1) * M * R2**2 + 2 * A) / (2 * A) * sp.cos(u) ** 2
)

# Motion by quadratures in x = cos(u) [DragovicGajicJovanovic2020]: P s sin(u) = S, A n = N and
# P (s^2 + tau^2) = W on a level of the integrals, and Z is the normal part of the momentum.
# Where the momentum is along the fixed axis z, Z is -Gamma cos(u1), and v1 has a rate in x too.
x = sp.Symbol("x")
C5, S0, h2, Gamma = sp.symbols("C5 S0 h2 Gamma")
ratio = R2 / R1
mu = 1 + ratio
N = C5 - k * mu * x
W = h2 - N**2 / A
S = S0 + (mu * M * R2**2 + A) * C5 / A * x - k * mu * (mu * M * R2**2 + 2 * A) / (2 * A) * x**2
V = W - k * S / P
Z = C5 - k * ratio * x
v_rate = S / (P * mu * (1 - x**2))
v1_rate = Gamma * (ratio / mu) * V / (Gamma**2 - Z**2)
upper, lower = (C5 - Gamma) / (k * ratio), (C5 + Gamma) / (k * ratio)
E = sp.Matrix(3, 3, lambda i, j: sp.Symbol(f"E{i + 1}{j + 1}"))
MOTION = Quadratures(
    variable={x: sp.cos(u)},
    constants={C5: axial, S0: level, h2: 2 * energy, Gamma: sp.sqrt(dot(momentum, momentum))},
    quartic=((1 - x**2) * W / P - S**2 / P**2) / mu**2,
    integrals={
        v: v_rate,
        v1: v1_rate,
        theta: -N / A - x * v_rate + Z / Gamma * v1_rate,
    },
    poles={
        1: S.xreplace({x: sp.Integer(1)}) / (2 * P * mu),
        -1: S.xreplace({x: sp.Integer(-1)}) / (2 * P * mu),
        upper: V.xreplace({x: upper}) / (2 * k * mu),
        lower: -V.xreplace({x: lower}) / (2 * k * mu),
    },
    traces=(Trace(u, v, x), Trace(u1, v1, -Z / Gamma)),
    velocities={s: mu * sp.sin(u) * velocity(v), tau: -mu * velocity(u), n: N / A},
    space=Space(
        frame=along_contact,
        vector=momentum,
        coordinates={
            u1: sp.atan2(sp.sqrt(E[0, 2] ** 2 + E[1, 2] ** 2), -E[2, 2]),
            v1: sp.atan2(-E[1, 2], -E[0, 2]),
            theta: sp.atan2(E[2, 0], -E[2, 1]),
        },
        entries=E,
    ),
)


def turning_point(
    spin: object, normal: object, turn: object, inertia: object = sp.Rational(2, 5)
) -> dict[sp.Expr, object]:
    """Initial data at a turning point, u = 1, whose momentum lies along the fixed axis z."""
    values = {u: turn, s: spin, tau: 0, n: normal, R2: 1, M: 1, A: inertia, k: 3}
    exact = {q: sp.sympify(value) for q, value in values.items()}
    along_u, _, along_n = momentum.xreplace(exact)
    side = 1 if along_u > 0 else -1  # keeps u1 between 0 and pi
    return {
        **{q: values[q] for q in (u, s, n)},
        theta: side * sp.pi / 2,
        u1: sp.atan2(side * along_u, -along_n),
    }


around = (R1 < 0) & (-R1 < R2)  # a shell around the sphere
ball_condition = (
    "a ball has its mass within R2, so 3 A <= 2 M R2^2 (for a shell, R1 < 0 and |R1| < R2)"
)
shell_condition = (
    "a shell around the sphere (R1 < 0, |R1| < R2) has its mass beyond R2, so 2 A >= M R2^2 "
    "(inside the sphere rolls a ball with R2 < |R1|)"
)
possible = {
    ball_condition: around | (3 * A <= 2 * M * R2**2),
    shell_condition: sp.Not(around) | (2 * A >= M * R2**2),
}

SYSTEM = System(
    name="demchenko",
    title="Demchenko's gyroscopic ball on a sphere",
    description="A ball with a rotor along its axis of symmetry, under Zhukovsky's condition, "
    "rolls without slipping over a fixed sphere: outside, inside, or around it as a shell.",
    sketch=kinematics.ball_sketch((u, v), (u1, v1), theta, (0, 0, k)),
    fibration=Fibration(base=(u, v, theta), fibre=(u1, v1)),
    frame=Frame.quasi(dict(zip((s, tau, n), contact.spin, strict=True))),
    lagrangian=kinetic + rotor,
    constraints=contact.no_slip,
    meanings={
        **kinematics.contact_meanings(contact, "the ball"),
        **kinematics.moving_meanings((s, tau, n)),
        **{f"momentum {q}": f"momentum about the contact, along {q} in space" for q in "xyz"},
        "axial": "momentum along the rotor's axis, with what the rolling adds",
    },
    parameters=(
        Parameter(R1, 2, meaning="radius of the fixed sphere, signed"),
        Parameter(R2, 1, positive=True, meaning="radius of the ball"),
        Parameter(M, 1, positive=True, meaning="mass of ball and rotor"),
        Parameter(A, sp.Rational(2, 5), positive=True, meaning="moment of inertia, A1 + A2 = C1"),
        Parameter(k, 3, meaning="axial momentum of the rotor"),
    ),
    possible=possible,
    integrals={
        "energy": energy,
        "momentum x": in_space[0],
        "momentum y": in_space[1],
        "momentum z": in_space[2],
        "axial": axial,
    },
    invariants={"x": sp.cos(u), "y": sp.sin(u)},
    measure=sp.sin(u) * sp.sin(u1),
    essential=(u, s, tau, n),
    charts=kinematics.turned_poles(contact, {"lagrangian": kinetic + turned_rotor}, along=(s, tau)),
    cases={
        "on the ball": Case(
            parameters={},
            integrals={"level": level},
            measure=Measure(sp.sin(u), (u, s, tau, n)),
            integrable="Euler-Jacobi",
            note="colatitude of the contact and the three spins, without the other angles",
        ),
    },
    scenes={
        "default": Scene(
            initial=turning_point(sp.Rational(1, 5), sp.Rational(3, 2), 1),
            times=(0.0, 40.0),
            outputs=(u, v, u1, v1, theta),
            caption="Outer rolling, R2/R1 = 1/2: the trace runs between two parallels.",
        ),
        "inner": Scene(
            initial=turning_point(sp.Rational(1, 5), sp.Rational(3, 2), 1),
            times=(0.0, 60.0),
            parameters={R1: -3},
            outputs=(u, v, u1, v1, theta),
            caption="Inside a sphere three times as large.",
        ),
        "shell": Scene(
            initial=turning_point(sp.Rational(1, 5), sp.Rational(3, 2), 1, sp.Rational(7, 10)),
            times=(0.0, 60.0),
            parameters={R1: -sp.Rational(1, 2), A: sp.Rational(7, 10)},
            outputs=(u, v, u1, v1, theta),
            caption="A shell around a sphere of half its radius.",
        ),
    },
    shapes=contact.shapes,
    drawing={"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")},
    motion=MOTION,
    references=("Demchenko1924", "DragovicGajicJovanovic2020", "Voronec1902", "Zhukovsky1893"),
)

# Along the ball's principal axes: the angular velocity, and gamma, minus the ball's own normal.
h = sp.Symbol("h")
ball_spin = {f"omega{i + 1}": e for i, e in enumerate(contact.body.frame * sp.Matrix([s, tau, n]))}
normal = {f"gamma{i + 1}": -e for i, e in enumerate(contact.body.frame[:, 2])}
place = {q: q for q in contact.coordinates}
RELATIONS = (
    Relation(
        "demchenko",
        "symmetric-gyroscopic-ball-on-sphere",
        state={**place, **ball_spin},
        parameters={R1: R1, R2: R2, "m": M, A: A, "C": A, k: k},
        note="Zhukovsky's condition",
    ),
    Relation(
        "demchenko",
        "homogeneous-ball-on-sphere",
        state={**place, **ball_spin},
        parameters={R1: R1, R2: R2, "m": M, A: A},
        limit=Limit(h, {k: h}),
        note="the gyroscope is taken away",
    ),
    Relation(
        "demchenko",
        "zhukovsky-ball",
        state={**normal, **ball_spin},
        parameters={"R": R2, "m": M, A: A, k: k},
        limit=Limit(h, {R1: 1 / h}),
        note="the sphere becomes a plane",
    ),
)
SQUARES = (
    Square(
        first=("demchenko -> zhukovsky-ball", "zhukovsky-ball -> homogeneous-ball"),
        second=(
            "demchenko -> homogeneous-ball-on-sphere",
            "homogeneous-ball-on-sphere -> homogeneous-ball",
        ),
        name="Demchenko's gyroscope and the curvature of the sphere vanish in either order",
    ),
    Square(
        first=(
            "demchenko -> symmetric-gyroscopic-ball-on-sphere",
            "symmetric-gyroscopic-ball-on-sphere -> bobylev-ball",
        ),
        second=("demchenko -> zhukovsky-ball", "zhukovsky-ball -> bobylev-ball"),
        name="Zhukovsky's condition, and the sphere becomes a plane",
    ),
    Square(
        first=(
            "demchenko -> symmetric-gyroscopic-ball-on-sphere",
            "symmetric-gyroscopic-ball-on-sphere -> symmetric-ball-on-sphere",
        ),
        second=(
            "demchenko -> homogeneous-ball-on-sphere",
            "homogeneous-ball-on-sphere -> symmetric-ball-on-sphere",
        ),
        name="Zhukovsky's condition, and the gyroscope is taken away",
    ),
)
