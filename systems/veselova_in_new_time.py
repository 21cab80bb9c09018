"""Veselova's system in the time in which it obeys Lagrange's equations: a particle on a sphere.

The particle is at gamma, a unit vector, and

    L = (Omega, J Omega)/(2 Q),    Omega = gamma' x gamma,    Q = (gamma, J^-1 gamma),

without constraints.  Omega1 and Omega2 are the velocities; Omega3 follows from (Omega, gamma) = 0.
Veselova's system, and the rubber ball on a plane with J = I + D, become this, omega = N Omega, with
dtau = N dt, N = Q^(-1/2) [EhlersKoillerMontgomeryRios2005].
"""

from __future__ import annotations

import sympy as sp

from voronec import Parameter, Relation, kinematics

moments, names = sp.symbols("J1:4"), sp.symbols("Omega1 Omega2")
motion = kinematics.RubberMotion(moments, velocities=names)
Q = motion.form

SYSTEM = motion.particle_system(
    name="veselova-in-new-time",
    title="Veselova's system in the new time",
    description="A particle moves freely on a sphere, in the metric that Veselova's system has "
    "after Chaplygin's change of time.",
    parameters=Parameter.each(
        moments, ("1.4", "1.5", "1.7"), positive=True, meaning="principal moment"
    ),
    end="direction",
    whose="the body",
    integrals={"momentum across the normal": motion.integrals["momentum across the normal"] / Q},
    integrable="Euler-Jacobi",
    meanings={"momentum across the normal": "square of the momentum's part across gamma"},
    references=("EhlersKoillerMontgomeryRios2005", "VeselovVeselova1988"),
)

RELATIONS = (
    Relation.into(
        SYSTEM,
        "veselova",
        {W: w * sp.sqrt(Q) for W, w in zip(names, sp.symbols("omega1:3"), strict=True)},
        clock=1 / sp.sqrt(Q),
    ),
)
