"""A homogeneous ball that rolls on a surface of revolution, by the surface of its centre."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.algebra.text import as_expression
from voronec.declaration.claims import Equation
from voronec.declaration.derivatives import derivative
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.reading import expression
from voronec.declaration.shapes import Shape
from voronec.declaration.sketch import Point
from voronec.declaration.system import System
from voronec.kinematics.families import (
    Words,
    constants,
    join_declarations,
    read_fields,
    shapes_of_known,
)
from voronec.kinematics.forms import two
from voronec.kinematics.meanings import euler_meanings
from voronec.kinematics.rotations import Rotation
from voronec.kinematics.sketches import bowl_sketch

PHI, ANGLES = sp.Symbol("phi"), sp.symbols("alpha beta psi")
RATES = V, W, SPIN = sp.symbols("v w s")
ATTITUDE = Rotation.euler("zxz", *ANGLES)


@dataclass(frozen=True)
class BallOnRevolution:
    """A heavy homogeneous ball that rolls on a surface of revolution with a vertical axis.

    The centre (f cos phi, f sin phi, g) moves on a surface of revolution, of meridian (f, g)(u) and
    normal n = (-g', f')/L, L = |(f', g')|; the ball touches its own surface at -R n from the
    centre.  With v = u', w = phi', s = (omega, n) and the curvatures
    k1 = (f' g'' - g' f'')/L^3 and k2 = g'/(L f),

        R s' = (k1 - k2) L f v w,    (f^2 w)' = -J/(J + m R^2) R k1 L f v s:

    two linear equations with u for the time [Routh1905].

    coordinate, profile
        u, a symbol, and (f, g), expressions in it, which may hold unknown functions.
    mass, radius, inertia, gravity
        m, R, J about the centre, g.
    length
        L, where it is shorter than a square root.
    """

    coordinate: Any
    profile: tuple[Any, Any]
    mass: Any
    radius: Any
    inertia: Any
    gravity: Any
    length: Any = None

    def __post_init__(self) -> None:
        read_fields(self, ("coordinate", "mass", "radius", "inertia", "gravity"), "a ball")
        object.__setattr__(self, "profile", two(self.profile, "a profile"))
        length = sp.sqrt(sum(x**2 for x in self.slope)) if self.length is None else self.length
        object.__setattr__(self, "length", expression(length, "the length of a profile"))

    @cached_property
    def slope(self) -> tuple[sp.Expr, sp.Expr]:
        """(f', g')."""
        f, g = self.profile
        return derivative(f, self.coordinate), derivative(g, self.coordinate)

    @cached_property
    def curvatures(self) -> tuple[sp.Expr, sp.Expr]:
        """(k1, k2), along the meridian and across it; positive in a bowl."""
        (out, up), length = self.slope, self.length
        bend = out * derivative(up, self.coordinate) - up * derivative(out, self.coordinate)
        return bend / length**3, up / (length * self.profile[0])

    @cached_property
    def centre(self) -> sp.ImmutableMatrix:
        """C, in space."""
        f, g = self.profile
        return sp.ImmutableMatrix([f * sp.cos(PHI), f * sp.sin(PHI), g])

    @cached_property
    def contact(self) -> sp.ImmutableMatrix:
        """C - R n, in space."""
        (out, up), reach = self.slope, self.radius / self.length
        normal = sp.Matrix([-up * sp.cos(PHI), -up * sp.sin(PHI), out])
        return sp.ImmutableMatrix(self.centre - reach * normal)

    @cached_property
    def spins(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """omega along the meridian, along the parallel, and along n."""
        x, y, z = ATTITUDE.space_rates
        (out, up), length = self.slope, self.length
        outwards, around = x * sp.cos(PHI) + y * sp.sin(PHI), y * sp.cos(PHI) - x * sp.sin(PHI)
        return (out * outwards + up * z) / length, around, (out * z - up * outwards) / length

    @property
    def frame(self) -> Frame:
        """v, w, s."""
        return Frame.quasi({V: velocity(self.coordinate), W: velocity(PHI), SPIN: self.spins[2]})

    @property
    def constraints(self) -> tuple[sp.Expr, sp.Expr]:
        """No slip, along the meridian and along the parallel."""
        along, around, _ = self.spins
        return (
            self.radius * around - self.length * velocity(self.coordinate),
            self.radius * along + self.profile[0] * velocity(PHI),
        )

    @cached_property
    def kinetic(self) -> sp.Expr:
        """m (L^2 u'^2 + f^2 phi'^2)/2 + J |omega|^2/2."""
        step, turn = velocity(self.coordinate), velocity(PHI)
        moved = self.length**2 * step**2 + self.profile[0] ** 2 * turn**2
        a, b, c = map(velocity, ANGLES)
        spun = a**2 + b**2 + c**2 + 2 * a * c * sp.cos(ANGLES[1])
        return (self.mass * moved + self.inertia * spun) / 2

    @property
    def potential(self) -> sp.Expr:
        """m g times the height of C."""
        return as_expression(self.mass * self.gravity * self.profile[1])

    @property
    def equation(self) -> Equation:
        """The two linear equations, of R s and f^2 w."""
        (along, across), reach = self.curvatures, self.length * self.profile[0] * V
        share = self.inertia / (self.inertia + self.mass * self.radius**2)
        rates = (along - across) * reach * W, -share * self.radius * along * reach * SPIN
        return Equation((self.radius * SPIN, self.profile[0] ** 2 * W), rates)

    def system(
        self,
        *,
        values: Mapping[Any, Any],
        ranges: tuple[Any, Any] | None = None,
        outline: Sequence[Point] | None = None,
        measured: tuple[Point, Point] | None = None,
        **declared: Any,
    ) -> System:
        """The system, with ``values`` of its constants, and what is special to it.

        ``ranges`` are two numbers between which u is drawn, in the viewer; ``outline`` and
        ``measured``, points that are joined and two between which u is shown, are of the sketch.
        """
        u, words = self.coordinate, self._words
        bounds = None if ranges is None else (ranges, (0, 2 * sp.pi))
        ground = Shape.surface((u, PHI), self.contact, bounds, role="ground")
        ball = Shape.ball(
            self.radius, centre=self.centre, contact=self.contact, attitude=ATTITUDE.matrix
        )
        common = {
            "sketch": bowl_sketch(u, PHI, ANGLES, outline, measured),
            "fibration": Fibration((u, PHI, ANGLES[2]), ANGLES[:2]),
            "frame": self.frame,
            "lagrangian": self.kinetic - self.potential,
            "constraints": self.constraints,
            "meanings": {
                PHI: "azimuth of the centre",
                **euler_meanings(ANGLES),
                V: f"rate of {u}",
                W: "rate of the azimuth",
                SPIN: "angular velocity along the normal",
            },
            "parameters": constants(values, words),
            "integrals": {"energy": self.kinetic + self.potential},
            "equations": {"spin and moment": self.equation},
            "measure": self.length**2 * self.profile[0] ** 2 * sp.sin(ANGLES[1]),
            "essential": (u, *RATES),
            "shapes": shapes_of_known((ball, ground)),
        }
        return join_declarations(common, declared)

    @property
    def _words(self) -> Words:
        """What its constants are."""
        return {
            self.mass: ("mass", True),
            self.radius: ("radius", True),
            self.inertia: ("moment of inertia about the centre", True),
            self.gravity: ("gravity", False),
        }
