"""Chaplygin's sleigh, declared whole: a body on a plane, held by a blade."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.arguments import TEXT, require
from voronec.algebra.symbols import velocity
from voronec.algebra.text import as_expression
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.scene import Scene
from voronec.declaration.sketch import Sketch
from voronec.declaration.system import System
from voronec.kinematics.families import constants, join_declarations, read_fields
from voronec.kinematics.meanings import sleigh_meanings
from voronec.kinematics.sketches import sleigh_shapes, sleigh_sketch

PLACE = X, Y = sp.symbols("x y")
HEADING = sp.Symbol("phi")
RATES = SPEED, TURN_RATE = sp.symbols("v w")


@dataclass(frozen=True)
class Sleigh:
    """A rigid body on a plane whose blade does not slip sideways [Chaplygin1911].

    The blade touches the plane at (x, y) and points along (cos phi, sin phi); v is the speed along
    it and w the rate of turning.

    mass, inertia
        m, and J about the centre of mass.
    ahead, beside
        a, how far the centre of mass is before the blade; how far to its left, as it is named in
        the sketch, nothing where it is on the line of the blade.
    ground
        what the blade is on, a word for what the coordinates mean.

    ``system`` declares it, with what is special beside.
    """

    mass: Any
    inertia: Any
    ahead: Any
    beside: Any = ""
    ground: str = "plane"

    def __post_init__(self) -> None:
        read_fields(self, ("mass", "inertia", "ahead"), "a sleigh")
        require("the sleigh", "ground", self.ground, TEXT)

    @property
    def forward(self) -> sp.Expr:
        """The speed along the blade, x' cos phi + y' sin phi."""
        return velocity(X) * sp.cos(HEADING) + velocity(Y) * sp.sin(HEADING)

    @property
    def centre_velocity(self) -> tuple[sp.Expr, sp.Expr]:
        """The velocity of (x, y) + a (cos phi, sin phi)."""
        turning = velocity(HEADING)
        return (
            velocity(X) - self.ahead * turning * sp.sin(HEADING),
            velocity(Y) + self.ahead * turning * sp.cos(HEADING),
        )

    @property
    def kinetic(self) -> sp.Expr:
        """The kinetic energy, the centre of mass being on the line of the blade."""
        x, y = self.centre_velocity
        return self.mass * (x**2 + y**2) / 2 + self.inertia * velocity(HEADING) ** 2 / 2

    @property
    def turning_inertia(self) -> sp.Expr:
        """K = J + m a^2, about the blade."""
        return as_expression(self.inertia + self.mass * self.ahead**2)

    @property
    def heading_integral(self) -> sp.Expr:
        """a phi - sqrt(K/m) atan(v sqrt(m/K)/w): a times the heading where v = 0.

        v and w run along a half of an ellipse, and the heading turns in proportion to the angle
        there; w does not change its sign, so the angle is written without a jump where v = 0.
        """
        ratio = self.turning_inertia / self.mass
        angle = sp.atan(SPEED * sp.sqrt(1 / ratio) / TURN_RATE)
        return self.ahead * HEADING - sp.sqrt(ratio) * angle

    @property
    def sketch(self) -> Sketch:
        """The sleigh from above."""
        return sleigh_sketch(PLACE, HEADING, self.ahead, self.beside)

    def scene(
        self, caption: str, end: float, start: Mapping[Any, Any], parameters: Any = None
    ) -> Scene:
        """A motion from ``start`` up to the time ``end``: place, heading, speed and turning."""
        return Scene(start, (0.0, end), parameters or {}, (*PLACE, HEADING, *RATES), caption)

    def system(self, *, values: Mapping[Any, Any], **declared: Any) -> System:
        """The system of this sleigh, with ``values`` of its constants, and what is special to it.

        The Lagrangian is ``kinetic`` where no other one is declared.
        """
        words = {
            self.mass: ("mass", True),
            self.inertia: ("inertia about the centre of mass", True),
            self.ahead: ("centre of mass, before the blade", False),
        }
        common = {
            "sketch": self.sketch,
            "fibration": Fibration((X, HEADING), (Y,)),
            "frame": Frame.quasi({SPEED: self.forward, TURN_RATE: velocity(HEADING)}),
            "lagrangian": self.kinetic,
            "constraints": (velocity(X) * sp.sin(HEADING) - velocity(Y) * sp.cos(HEADING),),
            "meanings": sleigh_meanings(PLACE, HEADING, RATES, self.ground),
            "parameters": constants(values, words),
            "essential": RATES,
            "shapes": sleigh_shapes(PLACE, HEADING, self.ahead),
        }
        return join_declarations(common, declared)
