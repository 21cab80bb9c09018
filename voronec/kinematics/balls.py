"""A ball that rolls on a fixed sphere or plane, in C. Neumann's coordinates, seen from the ball."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.declaration.charts import Chart
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.reading import expression
from voronec.kinematics.bodies import kinetic_energy, point_velocity
from voronec.kinematics.meanings import NORMAL, contact_meanings, vector_meanings
from voronec.kinematics.neumann_charts import HALF_TURN, turned_poles
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.sketches import ball_sketch
from voronec.kinematics.surfaces import Surface
from voronec.kinematics.vectors import Vector, apply_matrix, cross, dot, three

_U, _V, _THETA = sp.symbols("u v theta")
OMEGA, GAMMA = sp.symbols("omega1:4"), sp.symbols("gamma1:4")
"""The names of omega and gamma along the axes of a body, in its equations."""
ZERO = (sp.Integer(0), sp.Integer(0), sp.Integer(0))
CYCLES = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
"""The axes in cyclic order, from each of them."""


@dataclass(frozen=True)
class RollingBall:
    """A ball on a fixed surface: contact, mass, principal moments about the centre of mass.

    ``offset`` is the centre of mass from the ball's centre.  Vectors are along the ball's principal
    axes, the polar axis of (u, v) being the third of them, or, where it is ``turned``, the first.
    Nothing is assumed about slipping: velocities are those of the coordinates; ``no_slip`` and
    ``no_twist`` are the constraints.
    """

    contact: RollingContact
    mass: Any
    inertia: tuple[Any, Any, Any]
    offset: tuple[Any, Any, Any] = (sp.Integer(0), sp.Integer(0), sp.Integer(0))
    turned: bool = False

    @classmethod
    def on_sphere(
        cls, fixed: Any, radius: Any, mass: Any, inertia: Sequence[Any], offset: Sequence[Any] = ()
    ) -> RollingBall:
        """On a sphere of signed radius ``fixed``, in the coordinates u, v, theta, u1, v1.

        Negative where the sphere is touched from inside or lies within the ball.
        """
        surface = Surface.sphere(fixed, *sp.symbols("u1 v1"))
        return cls.on(surface, radius, mass, inertia, offset)

    @classmethod
    def on_plane(
        cls, radius: Any, mass: Any, inertia: Sequence[Any], offset: Sequence[Any] = ()
    ) -> RollingBall:
        """On the plane, in the coordinates u, v, theta and x, y, the point of contact."""
        return cls.on(Surface.plane(*sp.symbols("x y")), radius, mass, inertia, offset)

    @classmethod
    def on(
        cls,
        fixed: Surface,
        radius: Any,
        mass: Any,
        inertia: Sequence[Any],
        offset: Sequence[Any] = (),
    ) -> RollingBall:
        """On any surface, in the coordinates u, v, theta and those of the surface."""
        contact = RollingContact(Surface.sphere(radius, _U, _V), fixed, _THETA)
        place = three(offset or (0, 0, 0), "the centre of mass of a ball")
        weight = expression(mass, "the mass of a ball")
        return cls(contact, weight, three(inertia, "the moments of a ball"), place)

    @property
    def base(self) -> tuple[sp.Expr, ...]:
        """(u, v, theta), the coordinates of the ball that rolls without slipping."""
        return (*self.contact.body.coordinates, self.contact.theta)

    @property
    def fibre(self) -> tuple[sp.Expr, ...]:
        """The coordinates of the contact on the fixed surface."""
        return self.contact.fixed.coordinates

    @cached_property
    def spin(self) -> Vector:
        """omega, the angular velocity."""
        return self._along_axes(self.contact.spin)

    @cached_property
    def normal(self) -> Vector:
        """gamma = R^T n1, the normal of the fixed surface, from the contact to the centre."""
        return self._along_axes((0, 0, -1))

    @property
    def no_slip(self) -> tuple[sp.Expr, sp.Expr]:
        """The two constraints of rolling without slipping: expressions that vanish."""
        return self.contact.no_slip

    @property
    def no_twist(self) -> sp.Expr:
        """The further constraint of a rubber ball, n = -(omega, gamma) = 0."""
        return self.contact.no_twist

    @cached_property
    def centre_velocity(self) -> Vector:
        """The velocity of the centre of mass."""
        middle = self._along_axes(self.contact.centre_velocity)
        return point_velocity(middle, self.spin, self.offset)

    @cached_property
    def energy(self) -> sp.Expr:
        """The kinetic energy."""
        if any(x != 0 for x in self.offset):
            return kinetic_energy(self.mass, self.centre_velocity, self.inertia, self.spin)
        # Along (u, v, n) the velocity of the ball's centre is shorter.
        return kinetic_energy(self.mass, self.contact.centre_velocity, self.inertia, self.spin)

    @cached_property
    def momentum(self) -> Vector:
        """G, the angular momentum about the point of contact: I omega + m MC x (velocity of C)."""
        arm = self._along_axes(self.contact.arm)
        lever = (self.offset[0] - arm[0], self.offset[1] - arm[1], self.offset[2] - arm[2])
        carried = cross(lever, self.centre_velocity)
        x, y, z = (
            moment * rate + self.mass * part
            for moment, rate, part in zip(self.inertia, self.spin, carried, strict=True)
        )
        return x, y, z

    def declared(
        self, *, rotor: Sequence[Any] = (0, 0, 0), potential: Any = 0, twists: bool = True
    ) -> dict[str, Any]:
        """What a ``System`` of this ball declares of its chart, in its velocities omega.

        The Lagrangian is the energy with kappa . omega of a ``rotor``, less a ``potential`` in
        gamma1, gamma2, gamma3, the invariants.  A ball that does not twist, ``twists=False``,
        has the velocities omega1 and omega2, and theta in the fibre.
        """
        momentum, height = three(rotor, "the momentum of a rotor"), as_expression(potential)
        names = OMEGA if twists else OMEGA[:2]

        def of_axes(ball: RollingBall) -> dict[str, Any]:
            normal = dict(zip(GAMMA, ball.normal, strict=True))
            kinetic = ball.energy + dot(momentum, ball.spin)
            spin = dict(zip(OMEGA, ball.spin, strict=True))
            beside = {} if twists else {OMEGA[2]: spin.pop(OMEGA[2])}
            return {
                "frame": Frame.quasi(spin, beside),
                "lagrangian": kinetic - height.xreplace(normal),
            }

        u, v, theta = self.base
        return {
            "fibration": Fibration(self.base, self.fibre)
            if twists
            else Fibration((u, v), (*self.fibre, theta)),
            **of_axes(self),
            "charts": self.charts(of_axes),
            "constraints": self.no_slip if twists else (*self.no_slip, self.no_twist),
            "invariants": dict(zip(map(str, GAMMA), self.normal, strict=True)),
            "essential": (u, v, *names),
            "meanings": {
                **contact_meanings(self.contact, "the ball"),
                **vector_meanings(names, whose="the ball"),
                **vector_meanings(map(str, GAMMA), NORMAL, "the ball"),
            },
            "shapes": self.contact.shapes,
            "sketch": ball_sketch((u, v), self.fibre, theta, momentum),
        }

    def _along_axes(self, vector: Vector) -> Vector:
        """A vector along (u, v, n) brought to the ball's axes."""
        along = apply_matrix(self.contact.body.frame, vector)
        return apply_matrix(HALF_TURN, along) if self.turned else along

    def charts(self, declared: Callable[[RollingBall], Mapping[str, Any]]) -> dict[str, Chart]:
        """Charts of a system of this ball, with the poles of the coordinates elsewhere.

        ``declared`` gives the Lagrangian, and the frame with velocities along the principal axes,
        of a ball.
        """
        return turned_poles(self.contact, declared(replace(self, turned=True)))


def contact_momentum(
    inertia: Sequence[Any], carried: Any, omega: Sequence[Any], gamma: Sequence[Any]
) -> sp.ImmutableMatrix:
    """G = I omega + D (omega - (omega, gamma) gamma): about the contact of a balanced ball.

    ``inertia`` are the principal moments about the centre, ``carried`` is D = m R2^2, the mass
    times the square of the ball's radius, and the ball does not slip [Chaplygin1903].
    """
    moments, steiner = (
        three(inertia, "the moments of a ball"),
        expression(carried, "m R2^2 of a ball"),
    )
    spin, normal = three(omega, "an angular velocity"), three(gamma, "a normal")
    twist = dot(spin, normal)
    return sp.ImmutableMatrix(
        [i * w + steiner * (w - twist * g) for i, w, g in zip(moments, spin, normal, strict=True)]
    )
