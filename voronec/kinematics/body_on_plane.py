"""A heavy body of revolution with any profile that rolls on a horizontal plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.declaration.claims import Equation
from voronec.declaration.derivatives import derivative
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.shapes import HALF, WHOLE, Shape
from voronec.declaration.system import System
from voronec.kinematics.families import (
    Words,
    constants,
    join_declarations,
    moment_words,
    read_fields,
    shapes_of_known,
)
from voronec.kinematics.forms import SurfaceForms, two
from voronec.kinematics.meanings import contact_meanings, moving_meanings
from voronec.kinematics.revolution import SPINS, BodyOfRevolution
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.sketches import rolling_sketch
from voronec.kinematics.surfaces import Surface
from voronec.kinematics.vectors import dot, matrix_product

V, THETA, X, Y = sp.symbols("v theta x y")
S, TAU, N = SPINS


@dataclass(frozen=True)
class BodyOnPlane:
    """A heavy body of revolution on a horizontal plane, by its support function.

    coordinate, support
        u, a symbol, the angle between the axis of symmetry and the outer normal at the contact M,
        and P, an expression in it, which may hold unknown functions: the height of the mass centre
        O over the plane.  OM = P' e_u + P n, and the radii of curvature are r_u = P + P'' along
        the meridian, r_v = P + P' cot u across.
    mass, moments, gravity
        m, (A, C) about an axis across and about that of symmetry, through O; g.

    With the momentum G about the contact, r = OM, w the angular velocity about the axis and

        rho^2 = A C + m (A r^2 + (C - A) r_3^2),   Z = rho w,   J = (G, r)/r_v,

    r_3 along the axis, dZ/du = b J and dJ/du = c Z, linear equations [Chaplygin1897].
    """

    coordinate: Any
    support: Any
    mass: Any
    moments: tuple[Any, Any]
    gravity: Any

    def __post_init__(self) -> None:
        read_fields(self, ("coordinate", "support", "mass", "gravity"), "a body")
        object.__setattr__(self, "moments", two(self.moments, "the moments of a body"))

    @cached_property
    def slope(self) -> sp.Expr:
        """P'."""
        return derivative(self.support, self.coordinate)

    @cached_property
    def rolling(self) -> BodyOfRevolution:
        """The body with its contact, in the coordinates u, v, theta, x, y."""
        u, height, slope = self.coordinate, self.support, self.slope
        radii = height + derivative(slope, u), height + slope * sp.cos(u) / sp.sin(u)
        surface = SurfaceForms.revolution(u, V, radii, (slope, sp.Integer(0), height))
        contact = RollingContact(surface, Surface.plane(X, Y), THETA)
        return BodyOfRevolution(contact, self.mass, *self.moments)

    @cached_property
    def rho(self) -> sp.Expr:
        """The root in Z and in the measure."""
        (across, along), below = self.moments, self.reach[1]
        square = self.support**2 + self.slope**2
        inertia = across * square + (along - across) * below**2
        return sp.sqrt(across * along + self.mass * inertia)

    @cached_property
    def reach(self) -> tuple[sp.Expr, sp.Expr]:
        """Of M, from the axis and along it."""
        cos, sin = sp.cos(self.coordinate), sp.sin(self.coordinate)
        return self.support * sin + self.slope * cos, self.support * cos - self.slope * sin

    @cached_property
    def linear_equation(self) -> Equation:
        """Z' = u' b J, J' = u' c Z."""
        cos, sin = sp.cos(self.coordinate), sp.sin(self.coordinate)
        rate, (x, y, _) = self.rolling.rolling_velocities[self.coordinate], self.rolling.trace
        along, across, slowness = -x.coeff(TAU), y.coeff(S), 1 / (rate.coeff(TAU) * self.rho)
        (A, C), (wide, below) = self.moments, self.reach
        e = along * sin - wide
        b = slowness * self.mass * e * wide / sin
        c = (C - A) * e - (across - along) * ((C - A) * below * cos + A * self.support) / wide
        Z = self.rho * (N * cos - S * sin)
        J = sin / wide * dot(self.rolling.momentum, self.rolling.arm)
        return Equation((Z, J), (rate * b * J, rate * slowness * c * sin / wide * Z))

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """The body and the plane; none of a body whose surface is not known."""
        ball, arm = Surface.sphere(1, self.coordinate, V), sp.Matrix(self.rolling.arm)
        turn, place = self.rolling.contact.turn, sp.Matrix([X, Y, 0])
        body = Shape.surface(
            (self.coordinate, V),
            matrix_product(ball.frame, arm),
            (HALF, WHOLE),
            centre=place - matrix_product(turn, arm),
            attitude=matrix_product(turn, ball.frame.T),
            contact=place,
        )
        return shapes_of_known((body, Shape.plane()))

    def system(self, *, values: Mapping[Any, Any], **declared: Any) -> System:
        """The system, with ``values`` of its constants, and what is special to it."""
        contact, momentum = self.rolling.contact, self.rolling.momentum
        spin, centre = sp.Matrix(contact.spin), sp.Matrix(contact.centre_velocity)
        turning = dot(self.rolling.turning_momentum(spin), spin)
        weight, rate = self.mass * self.gravity, self.rolling.rolling_velocities[self.coordinate]
        lever = sp.Matrix([0, rate.coeff(TAU) * weight * self.slope, 0])
        arm = self.rolling.arm
        inertia = self.moments[0] + self.mass * dot(arm, arm)
        common = {
            "sketch": rolling_sketch(
                body="ellipsoid", contact=(self.coordinate, V), place=(X, Y), turned=THETA
            ),
            "fibration": Fibration((self.coordinate, V, THETA), (X, Y)),
            "frame": Frame.quasi(dict(zip(SPINS, contact.spin, strict=True))),
            "lagrangian": (self.mass * dot(centre, centre) + turning) / 2 - weight * self.support,
            "constraints": contact.no_slip,
            "meanings": {**contact_meanings(contact), **moving_meanings(SPINS)},
            "parameters": constants(values, self._words),
            "equations": {
                "nutation": Equation(self.coordinate, rate),
                "momentum": Equation(momentum, self.rolling.momentum_rate - lever),
                "linear": self.linear_equation,
            },
            "integrals": {"energy": dot(momentum, SPINS) / 2 + weight * self.support},
            "measure": inertia * self.rho * sp.sin(self.coordinate),
            "essential": (self.coordinate, *SPINS),
            "shapes": self.shapes,
        }
        return join_declarations(common, declared)

    @property
    def _words(self) -> Words:
        """What its constants are."""
        across, along = self.moments
        return {
            self.mass: ("mass", True),
            **moment_words((across, across, along)),
            self.gravity: ("gravity", False),
        }
