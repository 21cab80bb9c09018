"""The motion of rubber balls, which neither slip nor twist, so that (omega, gamma) = 0.

omega and gamma are along the principal axes, gamma the normal of the fixed surface at the contact;
omega1 and omega2 are the velocities.  Veselova's body moves so too, about a fixed point.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.declaration.claims import Equation, Measure, Poisson
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.scene import Parameter, Scene
from voronec.declaration.shapes import Shape
from voronec.declaration.system import System
from voronec.kinematics.balls import CYCLES, GAMMA, OMEGA, ZERO
from voronec.kinematics.families import join_declarations
from voronec.kinematics.meanings import vector_meanings
from voronec.kinematics.sketches import particle_sketch
from voronec.kinematics.vectors import Vector, column, cross, dot, matrix_product


@dataclass(frozen=True)
class RubberMotion:
    """The motion of a rubber ball, or of Veselova's body, reduced to omega and gamma.

        dG/dt = (G + kappa) x omega + lambda gamma,    dgamma/dt = epsilon gamma x omega,
        lambda = -(gamma, J^-1 ((G + kappa) x omega)) / Q,  Q = (gamma, J^-1 gamma),  G = J omega

    with the moments J = I + D about the contact, D = m R2^2 and epsilon = R1/(R1 + R2), which is 1
    on a plane and for Veselova's body [VeselovVeselova1988, EhlersKoillerMontgomeryRios2005,
    EhlersKoiller2007]; kappa is the momentum of a gyroscope.

    moments, rotor, epsilon
        J1, J2, J3, kappa, epsilon.
    velocities
        names of the first two components of omega, if others than omega1 and omega2.
    """

    moments: Vector
    rotor: Vector = ZERO
    epsilon: Any = sp.Integer(1)
    velocities: tuple[sp.Expr, sp.Expr] = (OMEGA[0], OMEGA[1])

    @property
    def normal(self) -> sp.Matrix:
        """gamma, as symbols."""
        return sp.Matrix(GAMMA)

    @cached_property
    def spin(self) -> sp.ImmutableMatrix:
        """omega, whose third component follows from (omega, gamma) = 0."""
        x, y = self.velocities
        return sp.ImmutableMatrix([x, y, -(x * GAMMA[0] + y * GAMMA[1]) / GAMMA[2]])

    @cached_property
    def tensor(self) -> sp.ImmutableMatrix:
        """J."""
        return sp.ImmutableMatrix(sp.diag(*self.moments))

    @cached_property
    def momentum(self) -> sp.ImmutableMatrix:
        """G = J omega, about the contact, without the gyroscope."""
        return matrix_product(self.tensor, self.spin)

    @cached_property
    def whole(self) -> sp.ImmutableMatrix:
        """G + kappa."""
        return self.momentum + sp.ImmutableMatrix(self.rotor)

    @cached_property
    def form(self) -> sp.Expr:
        """Q = (gamma, J^-1 gamma)."""
        return sp.Add(*[g * (g / j) for g, j in zip(GAMMA, self.moments, strict=True)])

    @cached_property
    def torque(self) -> sp.ImmutableMatrix:
        """(G + kappa) x omega."""
        return column(cross(self.whole, self.spin))

    def multiplier(self, along: sp.MatrixBase) -> sp.Expr:
        """-(a, J^-1 ((G + kappa) x omega)) / Q: lambda, where ``along`` = a is gamma."""
        parts = zip(along, self.torque, self.moments, strict=True)
        return -sp.Add(*[a * (t / j) for a, t, j in parts]) / self.form

    def momentum_equation(self, multiplier: sp.Expr) -> Equation:
        """The equation of G with ``multiplier`` for lambda."""
        return Equation(tuple(self.momentum), tuple(self.torque + multiplier * self.normal))

    @cached_property
    def equations(self) -> dict[str, Equation]:
        """The equations of G and of gamma."""
        turned = self.epsilon * column(cross(self.normal, self.spin))
        return {
            "momentum": self.momentum_equation(self.multiplier(self.normal)),
            "normal": Equation(GAMMA, tuple(turned)),
        }

    @cached_property
    def energy(self) -> sp.Expr:
        """(G, omega)/2."""
        return dot(self.momentum, self.spin) / 2

    @cached_property
    def integrals(self) -> dict[str, sp.Expr]:
        """The energy, and where epsilon = 1 the square of the part of G + kappa across gamma."""
        conserved = {"energy": self.energy}
        if self.epsilon == 1:
            across = dot(self.whole, self.whole) - dot(self.whole, self.normal) ** 2
            conserved["momentum across the normal"] = across
        return conserved

    @cached_property
    def quadratic_integral(self) -> sp.Expr:
        """J1 J2 J3 |omega|^2 - S/Q, where epsilon = -1 and kappa = 0 [BorisovMamaev2007].

        S = sum of (Ji - Jj)(Ji - Jk) omega_i^2 gamma_i^2, with i, j, k in cyclic order.
        """
        j, terms = self.moments, zip(self.spin, GAMMA, CYCLES, strict=True)
        spread = sp.Add(
            *[(j[a] - j[b]) * (j[a] - j[c]) * (w * g) ** 2 for w, g, (a, b, c) in terms]
        )
        return self.tensor.det() * dot(self.spin, self.spin) - spread / self.form

    @property
    def root(self) -> sp.Expr:
        """Q^(1/(2 epsilon))."""
        return self.form ** (1 / (2 * self.epsilon))

    @cached_property
    def measure(self) -> Measure:
        """Q^(1/(2 epsilon)) / gamma3 in gamma, omega1, omega2: that plane has the area / gamma3."""
        return Measure(self.root / GAMMA[2], (*GAMMA, *self.velocities))

    @property
    def reducer(self) -> sp.Expr:
        """N = Q^(1/(2 epsilon) - 1), Chaplygin's reducing multiplier."""
        return self.form ** (1 / (2 * self.epsilon) - 1)

    @cached_property
    def poisson(self) -> Poisson:
        """In the time dtau = N dt, Hamilton's equations on the cotangent bundle of the sphere.

        M = N/epsilon (G - (G, gamma) gamma) is the momentum of gamma, (M, gamma) = 0; the
        gyroscope makes a magnetic field, -N (kappa, gamma)/epsilon^2.
        """
        g1, g2, g3 = GAMMA
        m1, m2 = sp.symbols("M1 M2")
        m3 = -(m1 * g1 + m2 * g2) / g3
        level = self.momentum - dot(self.momentum, self.normal) * self.normal
        across = (self.reducer / self.epsilon) * level
        field = -self.reducer * dot(self.rotor, self.normal) / self.epsilon**2
        return Poisson(
            variables={m1: across[0], m2: across[1], **{g: g for g in GAMMA}},
            bracket={
                (m1, m2): field * g3 - m3,
                (m1, g2): -g3,
                (m1, g3): g2,
                (m2, g1): g3,
                (m2, g3): -g1,
            },
            hamiltonian=self.energy,
            clock=self.reducer,
        )

    def particle_system(
        self, *, parameters: tuple[Parameter, ...], end: str, whose: str, **declared: Any
    ) -> System:
        """The motion in the time dtau = N dt: a particle at gamma that moves freely on a sphere,

            L = Q^(1/epsilon - 2) (Omega, J Omega)/2,    Omega = gamma' x gamma / epsilon,

        without constraints [EhlersKoiller2007]; its velocities are the first two of Omega.
        ``end`` is what leaves the trace on the sphere, ``whose`` the body along whose axes all
        vectors are.
        """
        place, names, weight = self.normal, self.velocities, self.form ** (1 / self.epsilon - 2)
        spin = column(cross([velocity(g) for g in place], place)) / self.epsilon
        start = {GAMMA[0]: "12/13", GAMMA[2]: "5/13", names[0]: "1/20", names[1]: "1/5"}
        caption = f"The trace of the {end} on {whose}."
        common = {
            "sketch": particle_sketch(place),
            "fibration": Fibration(place, (), (dot(place, place) - 1,)),
            "frame": Frame.quasi(dict(zip(names, spin, strict=False))),
            "lagrangian": weight * dot(spin, matrix_product(self.tensor, spin)) / 2,
            "meanings": {
                **vector_meanings(place, "place of the particle on the unit sphere", whose),
                **vector_meanings(names, "angular velocity in the new time", whose),
            },
            "parameters": parameters,
            "equations": {"normal": self.equations["normal"]},
            "integrals": {"energy": weight * dot(self.momentum, self.spin) / 2},
            "measure": Measure(self.form ** (2 / self.epsilon - 3) / GAMMA[2], (*place, *names)),
            "scenes": {"default": Scene(start, (0.0, 10.0), {}, tuple(place), caption)},
            "shapes": (Shape.ball(0.1, centre=place, contact=place), Shape.ball(1, role="ground")),
        }
        return join_declarations(common, declared)
