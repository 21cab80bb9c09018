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

from voronec import Parameter, Scene, kinematics

r, phi, v, w, s = sp.symbols("r phi v w s")
m, R, c, g, k = sp.symbols("m R c g k")

length = sp.sqrt(1 + c**2 * r**2)
J = m * R**2 * k**2 / (1 - k**2)
ball = kinematics.BallOnRevolution(r, (r, c * r**2 / 2), m, R, J, g, length)
regular = kinematics.cartesian_chart(
    (r, phi),
    ball.kinetic - ball.potential,
    ball.constraints,
    ball.frame,
    unit=R,
    near={"beta": 1},
)

SYSTEM = ball.system(
    name="ball-on-paraboloid",
    title="Ball whose centre moves on a paraboloid",
    description="A homogeneous ball rolls without slipping on a surface of revolution such that "
    "its centre moves on a paraboloid.",
    values={
        m: 1,
        R: "1/5",
        c: Parameter(c, 1, meaning="curvature of the paraboloid at its vertex"),
        g: 1,
        k: Parameter(
            k, sp.sqrt(sp.Rational(2, 7)), lower=0, upper=1, meaning="square root of J/(J + m R^2)"
        ),
    },
    ranges=(0, sp.Rational(3, 2)),
    meanings={
        r: "distance of the centre from the vertical axis",
        v: "rate at which the centre leaves the axis",
        "product of both": "product of the other two integrals",
        "first": "sum of k R s and c r^2 w, times q^k",
        "second": "difference of k R s and c r^2 w, divided by q^k",
    },
    integrals={
        "product of both": k**2 * R**2 * s**2 - c**2 * r**4 * w**2,
        "first": (k * R * s + c * r**2 * w) * (1 + c**2 * r**2) ** (k / 2),
        "second": (k * R * s - c * r**2 * w) * (1 + c**2 * r**2) ** (-k / 2),
    },
    charts={"at the vertex": regular},
    scenes={
        "default": Scene(
            initial={r: 1, "phi": 0, "beta": 1, "alpha": "1/2", v: "1/5", w: "1/2", s: 2},
            times=(0.0, 20.0),
            outputs=(r, "phi", v, w, s),
            caption="The centre runs between two parallels.",
        ),
    },
    references=("Routh1905", "BorisovMamaevKilin2002"),
)
