"""A homogeneous ball that rolls on a surface so that its centre moves on a paraboloid.

The centre C = (r cos phi, r sin phi, c r^2 / 2) moves on a paraboloid of revolution, and the ball
touches a surface at the distance R below it, along the normal n.  With the spin s = (omega, n),
q = sqrt(1 + c^2 r^2), D = m R^2 and K = J + D,

    s' = -c^3 r^3 r' phi' / (R q^2),    K (r^2 phi')' = -J R c r r' s / q^2,

so that s and r^2 phi' are linear functions of each other's changes along r [Routh1905].  In the
paraboloid's case they are powers of q [BorisovMamaevKilin2002]: with k = sqrt(J/K)

    (k R s + c r^2 phi') q^k  and  (k R s - c r^2 phi') q^-k

are constant.  Here J = D k^2 / (1 - k^2), and k is the parameter: k^2 = 2/7 for a solid ball.
The attitude is that of Euler's angles: alpha about the vertical, beta, psi about the ball's axis.
"""

from __future__ import annotations

import sympy as sp

from voronec import (
    Equation,
    Fibration,
    Frame,
    Parameter,
    Scene,
    Shape,
    Sketch,
    System,
    kinematics,
    velocity,
)

r, phi, alpha, beta, psi = sp.symbols("r phi alpha beta psi")
v, w, s = sp.symbols("v w s")
m, R, c, g, k = sp.symbols("m R c g k")
Dr, Dphi, Dalpha, Dbeta, Dpsi = map(velocity, (r, phi, alpha, beta, psi))

q = sp.sqrt(1 + c**2 * r**2)
J = m * R**2 * k**2 / (1 - k**2)
K = m * R**2 / (1 - k**2)

# The angular velocity in space, and along: the meridian, the parallel, the normal.
rotation = kinematics.Rotation.euler("zxz", alpha, beta, psi)
spin = rotation.space_rates
outwards = spin[0] * sp.cos(phi) + spin[1] * sp.sin(phi)
around = spin[1] * sp.cos(phi) - spin[0] * sp.sin(phi)
normal = (spin[2] - c * r * outwards) / q
meridian = (outwards + c * r * spin[2]) / q

kinetic = (
    m * ((1 + c**2 * r**2) * Dr**2 + r**2 * Dphi**2)
    + J * (Dalpha**2 + Dbeta**2 + Dpsi**2 + 2 * Dalpha * Dpsi * sp.cos(beta))
) / 2
potential = m * g * c * r**2 / 2

SKETCH = (
    Sketch("seen from the side")
    .line(*((k / 10, 0.28 * (k / 10) ** 2) for k in range(-22, 23)))
    .arrow((0.0, 0.0), (0.0, 2.3))
    .turn((0.0, 2.0), 90, 0.3, phi)
    .ellipse((1.15, 1.05), 0.545, 0.545)
    .line((0.0, 1.05), (1.15, 1.05), look="dashed")
    .distance((0.0, 1.05), (1.15, 1.05), r, 0.15)
    .line((1.15, 1.05), (1.15, 2.2), look="dashed")
    .turn((1.15, 2.05), 90, 0.22, alpha)
    .arrow((1.15, 1.05), (2.1, 1.85))
    .angle((1.15, 1.05), 0.75, 90, 40, beta)
    .turn((1.93, 1.7), 40, 0.22, psi)
    .dot((1.15, 1.05), "C", -60)
)
# Where the centre is, and the contact below it.
place = sp.Matrix([r * sp.cos(phi), r * sp.sin(phi), c * r**2 / 2])
contact_point = place - R * sp.Matrix([-c * r * sp.cos(phi), -c * r * sp.sin(phi), 1]) / q

frame = Frame.quasi({v: Dr, w: Dphi, s: normal})
constraints = (R * around - (1 + c**2 * r**2) * Dr / q, R * meridian + r * Dphi)
at_the_vertex = kinematics.cartesian_chart(
    (r, phi), kinetic - potential, constraints, frame, unit=R, near={beta: 1}
)

SYSTEM = System(
    name="ball-on-paraboloid",
    title="Ball whose centre moves on a paraboloid",
    description="A homogeneous ball rolls without slipping on a surface of revolution such that "
    "its centre moves on a paraboloid.",
    sketch=SKETCH,
    fibration=Fibration(base=(r, phi, psi), fibre=(alpha, beta)),
    frame=frame,
    lagrangian=kinetic - potential,
    constraints=constraints,
    meanings={
        r: "distance of the centre from the vertical axis",
        phi: "azimuth of the centre",
        alpha: "precession of the ball, Euler's angle about the vertical",
        beta: "nutation of the ball, from the vertical to its own axis",
        psi: "spin of the ball, Euler's angle about its own axis",
        v: "rate at which the centre leaves the axis",
        w: "rate of the azimuth",
        s: "angular velocity along the normal",
        "product of both": "product of the other two integrals",
        "first": "sum of k R s and c r^2 w, times q^k",
        "second": "difference of k R s and c r^2 w, divided by q^k",
    },
    parameters=(
        Parameter(m, 1, positive=True, meaning="mass"),
        Parameter(R, "1/5", positive=True, meaning="radius"),
        Parameter(c, 1, meaning="curvature of the paraboloid at its vertex"),
        Parameter(g, 1, meaning="gravity"),
        Parameter(
            k, sp.sqrt(sp.Rational(2, 7)), lower=0, upper=1, meaning="square root of J/(J + m R^2)"
        ),
    ),
    integrals={
        "energy": kinetic + potential,
        "product of both": k**2 * R**2 * s**2 - c**2 * r**4 * w**2,
        "first": (k * R * s + c * r**2 * w) * (1 + c**2 * r**2) ** (k / 2),
        "second": (k * R * s - c * r**2 * w) * (1 + c**2 * r**2) ** (-k / 2),
    },
    equations={
        "spin and moment": Equation(
            (R * s, r**2 * w),
            (-(c**3) * r**3 * v * w / q**2, -(k**2) * R * c * r * v * s / q**2),
        ),
    },
    essential=(r, v, w, s),
    charts={"at the vertex": at_the_vertex},
    scenes={
        "default": Scene(
            initial={r: 1, phi: 0, beta: 1, alpha: "1/2", v: "1/5", w: "1/2", s: 2},
            times=(0.0, 20.0),
            outputs=(r, phi, v, w, s),
            caption="The centre runs between two parallels.",
        ),
    },
    shapes=(
        Shape.ball(
            R,
            centre=place,
            contact=contact_point,
            attitude=rotation.matrix,
        ),
        Shape.surface(
            (r, phi), contact_point, ((0, sp.Rational(3, 2)), (0, 2 * sp.pi)), role="ground"
        ),
    ),
    references=("Routh1905", "BorisovMamaevKilin2002"),
)
