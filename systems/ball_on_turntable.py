"""A balanced, dynamically symmetric ball on a table that turns uniformly.

The table turns about the vertical z with the angular velocity Omega; the ball touches it at (x, y),
measured in space from the axis.  The material points in contact have one velocity, so the
constraints are affine.  With the velocity (vx, vy) of the centre, the twist n about the vertical,
and q = A/(A + m R^2), which is 2/7 for a homogeneous ball,

    vx' = -q Omega vy,    vy' = q Omega vx,    n' = 0:

the centre moves as a charge in a homogeneous magnetic field, on circles with the frequency q Omega,
wherever it is on the table [NeimarkFufaev1972].
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Body,
    Equation,
    Fibration,
    Frame,
    Limit,
    Parameter,
    Poisson,
    Relation,
    Scene,
    Shape,
    System,
    kinematics,
    time,
    velocity,
)

x, y, phi, theta, psi = sp.symbols("x y phi theta psi")
vx, vy, n = sp.symbols("vx vy n")
m, R, A, Omega = sp.symbols("m R A Omega")
X, Y = sp.symbols("X Y")
Dx, Dy = velocity(x), velocity(y)

rotation = kinematics.Rotation.euler("zxz", phi, theta, psi)
rates = rotation.space_rates
q = A / (A + m * R**2)

# The angular velocity in space, on the constraints.
spin = sp.Matrix([(Omega * x - vy) / R, (vx + Omega * y) / R, n])
kinetic = m * (vx**2 + vy**2) / 2 + A * spin.dot(spin) / 2
about_axis = m * (x * vy - y * vx) + A * n

SYSTEM = System(
    name="ball-on-turntable",
    title="Ball on a turntable",
    description="A balanced symmetric ball rolls without slipping on a table that turns uniformly.",
    sketch=kinematics.rolling_sketch(
        on="table", attitude=(phi, theta, psi), place=(x, y), spin=Omega
    ),
    fibration=Fibration(base=(phi, theta, psi), fibre=(x, y)),
    frame=Frame.quasi({vx: Dx, vy: Dy, n: rates[2]}),
    lagrangian=kinematics.kinetic_energy(m, (Dx, Dy, 0), (A, A, A), rates),
    constraints=(Dx - R * rates[1] + Omega * y, Dy + R * rates[0] - Omega * x),
    meanings={
        **kinematics.euler_meanings((phi, theta, psi)),
        **kinematics.place_meanings((x, y), "the contact in space, from the axis of the table"),
        vx: "velocity of the centre along the first axis",
        vy: "velocity of the centre along the second axis",
        n: "twist, the angular velocity about the vertical",
        "speed squared": "square of the speed of the centre",
        "twist": "angular velocity about the vertical",
        "centre of the circle, x": "place of the circle of the contact, times q Omega",
        "centre of the circle, y": "place of the circle of the contact, times q Omega",
        "moving energy": "energy less Omega times the angular momentum about the axis",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, 1, positive=True, meaning="radius"),
        Parameter(A, "2/5", positive=True, meaning="moment of inertia"),
        Parameter(Omega, 1, meaning="angular velocity of the table"),
    ),
    invariants={"X": x, "Y": y},
    integrals={
        "speed squared": vx**2 + vy**2,
        "twist": n,
        "centre of the circle, x": q * Omega * x - vy,
        "centre of the circle, y": q * Omega * y + vx,
        # The energy is not constant; less Omega times the angular momentum about the axis it is.
        "moving energy": kinetic - Omega * about_axis,
    },
    equations={
        "as in a magnetic field": Equation((vx, vy), (-q * Omega * vy, q * Omega * vx)),
    },
    measure=sp.sin(theta),
    poisson=Poisson(
        variables={z: z for z in (X, Y, vx, vy, n)},
        bracket={(X, vx): 1, (Y, vy): 1, (vx, vy): -q * Omega},
        hamiltonian=(vx**2 + vy**2) / 2,
    ),
    essential=(vx, vy),
    scenes={
        "default": Scene(
            initial={theta: 1, x: 1, vx: "1/5"},
            times=(0.0, 22.0),
            outputs=(x, y, n),
            caption="While the table turns three and a half times, the ball describes one circle.",
        ),
        "at rest": Scene(
            initial={theta: 1, x: 1},
            times=(0.0, 10.0),
            outputs=(x, y, n),
            caption="Where it is put with the right spin, the ball stays on the turning table.",
        ),
    },
    bodies=(Body(m, (Dx, Dy, 0), (A, A, A), rates, turning=(0, 0, 0), title="ball"),),
    shapes=(
        Shape.ball(R, centre=(x, y, R), attitude=rotation.matrix, contact=(x, y, 0)),
        Shape.plane(attitude=Omega * time),
    ),
    references=("NeimarkFufaev1972", "FassoSansonetto2016", "BorisovMamaevBizyaev2015"),
)

h = sp.Symbol("h")
in_the_ball = rotation.matrix.T * spin

RELATIONS = (
    Relation(
        "ball-on-turntable",
        "homogeneous-ball",
        state={
            **{f"gamma{i + 1}": g for i, g in enumerate(rotation.matrix.row(2))},
            **{f"omega{i + 1}": w for i, w in enumerate(in_the_ball)},
        },
        parameters={"m": m, "R": R, "A": A},
        limit=Limit(h, {Omega: h}),
        note="The table comes to rest.",
    ),
)
