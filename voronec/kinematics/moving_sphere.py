"""Balanced balls with a gyroscope that roll over a sphere which turns about its centre."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.symbols import time, velocity
from voronec.declaration.claims import Equation, Measure
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.reading import expression
from voronec.declaration.shapes import Shape
from voronec.declaration.system import System
from voronec.errors import DefinitionError
from voronec.kinematics.balanced_balls import BallMotion
from voronec.kinematics.balls import GAMMA, OMEGA, ZERO, contact_momentum
from voronec.kinematics.bodies import kinetic_energy
from voronec.kinematics.families import (
    Words,
    constants,
    join_declarations,
    moment_words,
    rolling_ratio,
    rotor_words,
)
from voronec.kinematics.meanings import euler_meanings, vector_meanings
from voronec.kinematics.rotations import Rotation
from voronec.kinematics.sketches import rolling_sketch
from voronec.kinematics.vectors import column, cross, dot, matrix_product, three

ANGLES = sp.symbols("phi theta psi")
TURNS = sp.symbols("alpha beta chi")
PLACE = sp.symbols("n1:4")
ZETA = sp.symbols("zeta1:4")
WHEEL = sp.symbols("W1:4")
SCALARS = {
    "fixed": "the radius of a sphere",
    "radius": "the radius of a ball",
    "mass": "the mass of a ball",
    "rate": "the angular velocity of a sphere",
    "moment": "the moment of a sphere",
}
"""What the numbers of such a ball are, in refusals."""


@dataclass(frozen=True)
class BallOnMovingSphere:
    """A balanced ball that rolls without slipping over a sphere, which turns about its centre.

    Along the ball's principal axes omega is its angular velocity, gamma the normal of the sphere,
    zeta the vertical, W the angular velocity of the sphere and x_t the part of x across gamma.
    With D = m R2^2, epsilon = R1/(R1 + R2) and the momentum kappa of a gyroscope,

        G = I omega + D omega_t + m R1 R2 W_t,    dG/dt = (G + kappa) x omega,
        dgamma/dt = epsilon gamma x (omega - W),    dzeta/dt = zeta x omega

    [Bychkov2004].  Euler's angles phi, theta, psi are those of the ball, and n = gamma.

    fixed, radius
        R1, negative inside the sphere and for a shell around it, and R2.
    mass, inertia, rotor
        m of ball and rotor, the principal moments, kappa.
    rate
        Where it is kept turning about the vertical: the angular velocity, so that W = rate zeta.
    moment
        Where it turns freely: J, about every diameter; W are velocities, and alpha, beta, chi are
        Euler's angles of the sphere.
    """

    fixed: Any
    radius: Any
    mass: Any
    inertia: Sequence[Any]
    rotor: Sequence[Any] = ZERO
    rate: Any = 0
    moment: Any = 0

    def __post_init__(self) -> None:
        for name, what in SCALARS.items():
            object.__setattr__(self, name, expression(getattr(self, name), what))
        object.__setattr__(self, "inertia", three(self.inertia, "the moments of a ball"))
        object.__setattr__(self, "rotor", three(self.rotor, "the momentum of a rotor"))
        if (self.rate == 0) == (self.moment == 0):
            raise DefinitionError(
                "a moving sphere is kept turning at a rate, or is free and has a moment; give "
                "rate=... or moment=..."
            )

    @property
    def is_free(self) -> bool:
        """Whether the sphere turns freely."""
        return bool(self.moment != 0)

    @cached_property
    def rotation(self) -> Rotation:
        """That of the ball."""
        return Rotation.euler("zxz", *ANGLES)

    @cached_property
    def sphere(self) -> Rotation:
        """That of a free sphere."""
        return Rotation.euler("zxz", *TURNS)

    @property
    def spin(self) -> sp.Matrix:
        """omega, as symbols."""
        return sp.Matrix(OMEGA)

    @property
    def swirl(self) -> sp.Matrix:
        """W of a free sphere, zeta of one that is kept turning, as symbols."""
        return sp.Matrix(WHEEL if self.is_free else ZETA)

    @property
    def epsilon(self) -> sp.Expr:
        """R1/(R1 + R2)."""
        return rolling_ratio(self.fixed, self.radius)

    @cached_property
    def contact(self) -> sp.Matrix:
        """The direction of the contact from the centre of the sphere, in space."""
        return matrix_product(self.rotation.matrix, PLACE)

    def across(self, vector: sp.Matrix) -> sp.Matrix:
        """x_t, what is left of a vector without its part along gamma."""
        normal = sp.Matrix(GAMMA)
        return vector - dot(vector, normal) * normal

    @cached_property
    def momentum(self) -> sp.Matrix:
        """G, the momentum about the contact, without the gyroscope."""
        pace = 1 if self.is_free else self.rate
        at_rest = contact_momentum(self.inertia, self.mass * self.radius**2, OMEGA, GAMMA)
        return at_rest + self.mass * self.fixed * self.radius * pace * self.across(self.swirl)

    @cached_property
    def whole(self) -> sp.Matrix:
        """G + kappa, which is constant in space."""
        return self.momentum + sp.Matrix(self.rotor)

    @cached_property
    def sphere_momentum(self) -> sp.Matrix:
        """N = J W + m R1^2 W_t + m R1 R2 omega_t of a free sphere, which is constant in space."""
        static = self.mass * self.fixed
        turning = self.moment * self.swirl + static * self.fixed * self.across(self.swirl)
        return turning + static * self.radius * self.across(self.spin)

    def measure(self, carried: Any) -> Measure:
        """That of a ball on a sphere at rest whose D is ``carried``."""
        density = BallMotion(three(self.inertia, "moments"), carried).density
        others = (*OMEGA, *WHEEL) if self.is_free else (*ZETA, *OMEGA)
        return Measure(density, (*GAMMA, *others))

    def _normal_rate(self, normal: Sequence[Any], swirl: sp.Matrix) -> tuple[sp.Expr, ...]:
        """dgamma/dt."""
        moved = swirl if self.is_free else self.rate * swirl
        return tuple(self.epsilon * column(cross(normal, self.spin - moved)))

    @property
    def equations(self) -> dict[str, Equation]:
        """Those of G and gamma; of N where the sphere is free, of zeta where it is kept turning."""
        spin = self.spin
        laws = {"momentum": Equation(tuple(self.momentum), cross(self.whole, spin))}
        if self.is_free:
            driven = Equation(tuple(self.sphere_momentum), cross(self.sphere_momentum, spin))
            laws["momentum of the sphere"] = driven
        laws["normal"] = Equation(GAMMA, self._normal_rate(GAMMA, self.swirl))
        if not self.is_free:
            laws["vertical"] = Equation(ZETA, cross(self.swirl, spin))
        return laws

    def system(self, *, values: Mapping[Any, Any], **declared: Any) -> System:
        """The system of this ball, with ``values`` of its constants, and what is special to it.

        The entries of ``declared`` that are mappings are added to those which every such ball has.
        """
        common = {
            **self._geometry(),
            **self._drawing(),
            "meanings": self._words(),
            "parameters": constants(values, self._constants()),
            "equations": self.equations,
        }
        return join_declarations(common, declared)

    def _geometry(self) -> dict[str, Any]:
        """Coordinates, velocities, Lagrangian, constraints."""
        matrix, turns = self.rotation.matrix, ()
        frame = dict(zip(OMEGA, self.rotation.body_rates, strict=True))
        invariants = dict(zip(map(str, GAMMA), PLACE, strict=True))
        if self.is_free:
            turns, swirl = TURNS, self.swirl
            frame |= zip(WHEEL, matrix_product(matrix.T, self.sphere.space_rates), strict=True)
        else:
            swirl = sp.Matrix(matrix.row(2)).T  # the vertical, in coordinates
            invariants |= zip(map(str, ZETA), swirl, strict=True)
        rates = sp.Matrix([velocity(n) for n in PLACE])
        centre = (self.fixed + self.radius) * (rates + column(cross(self.spin, PLACE)))
        kinetic = kinetic_energy(self.mass, centre, self.inertia, OMEGA)
        turning = self.moment * dot(swirl, swirl) / 2
        return {
            "fibration": Fibration((*ANGLES, *turns), PLACE, (sum(n**2 for n in PLACE) - 1,)),
            "frame": Frame.quasi(frame),
            "lagrangian": kinetic + turning + dot(self.rotor, self.spin),
            "constraints": tuple(rates - sp.Matrix(self._normal_rate(PLACE, swirl))),
            "invariants": invariants,
        }

    def _drawing(self) -> dict[str, Any]:
        """The sketch, and what lies in space."""
        sketch = rolling_sketch(
            on="sphere",
            attitude=ANGLES,
            place=TURNS[1:] if self.is_free else (),
            gamma=PLACE,
            wheel="kappa" if any(self.rotor) else "",
        )
        label = TURNS[0] if self.is_free else self.rate if self.rate.is_Symbol else ""
        ball = Shape.ball(
            self.radius,
            centre=(self.fixed + self.radius) * self.contact,
            attitude=self.rotation.matrix,
            contact=self.fixed * self.contact,
        )
        attitude = self.sphere.matrix if self.is_free else self.rate * time
        return {
            "sketch": sketch.turn((0.0, -3.9), 90, 0.35, label),
            "shapes": (ball, Shape.ball(self.fixed, attitude=attitude, role="ground")),
        }

    def _words(self) -> dict[Any, str]:
        """What its coordinates and velocities are."""
        said = euler_meanings(ANGLES)
        if self.is_free:
            said |= {q: f"of the sphere: {word}" for q, word in euler_meanings(TURNS).items()}
        said |= vector_meanings(PLACE, "normal of the sphere at the contact", "space")
        said |= vector_meanings(OMEGA, whose="the ball")
        if self.is_free:
            said |= vector_meanings(WHEEL, "angular velocity of the sphere", "the ball")
        said |= vector_meanings(map(str, GAMMA), "normal of the sphere", "the ball")
        if not self.is_free:
            said |= vector_meanings(map(str, ZETA), "the vertical", "the ball")
        return said

    def _constants(self) -> Words:
        """What its constants are."""
        return {
            self.fixed: ("radius of the sphere, signed", False),
            self.radius: ("radius of the ball", True),
            self.mass: ("mass of ball and rotor", True),
            **moment_words(self.inertia),
            **rotor_words(self.rotor),
            self.rate: ("angular velocity of the sphere", False),
            self.moment: ("moment of the sphere", True),
        }
