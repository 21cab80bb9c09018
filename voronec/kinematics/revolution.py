"""A body of revolution that rolls over a surface of revolution, seen along the moving frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.algebra.text import as_expression
from voronec.declaration.claims import Equation
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.reading import fixed_mapping
from voronec.declaration.scene import Parameter, Scene
from voronec.declaration.shapes import Shape
from voronec.declaration.system import System
from voronec.kinematics.balls import OMEGA
from voronec.kinematics.bodies import kinetic_energy, momentum_rate_about_point
from voronec.kinematics.carried_contact import CARRIED_VECTORS, carried_vectors, form_values
from voronec.kinematics.families import (
    Words,
    constants,
    join_declarations,
    rotor_words,
)
from voronec.kinematics.forms import SurfaceForms, two
from voronec.kinematics.meanings import (
    contact_meanings,
    euler_meanings,
    moving_meanings,
    vector_meanings,
)
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.rotations import Rotation
from voronec.kinematics.sketches import contact_views, rolling_sketch, wheel_of
from voronec.kinematics.surfaces import Surface
from voronec.kinematics.vectors import column, cross, dot, matrix_product, three

ATTITUDE = Rotation.euler("zxz", *sp.symbols("phi chi psi"))
"""Neumann's theta is no angle of Euler's."""
SPINS, PLACE = sp.symbols("s tau n"), sp.symbols("o1:4")
SLANT = sp.Symbol("w")
"""The root in the curvature of an ellipsoid of revolution: a coordinate, so that none occurs."""


@dataclass(frozen=True)
class BodyOfRevolution:
    """A body of revolution that rolls without slipping, with a gyroscope along its axis.

    contact
        of the two surfaces; the coordinate u of the body is the colatitude of its outer normal.
    mass, equatorial, axial, rotor
        m, the moments A, A, C about the origin of the body, its mass centre, and k.

    s, tau, n are the components of omega along e_u, e_v and the normal n; e is the axis.  The frame
    turns against the body with the angular velocity Omega, M moves over it with r', r = OM:

        G = A omega + (C - A)(omega, e) e + m r x (omega x r),
        dG/dt = (G + k e) x omega - Omega x G + m r' x (omega x r)    [Voronec1911, Demchenko1924].
    """

    contact: RollingContact
    mass: Any
    equatorial: Any
    axial: Any
    rotor: Any = sp.Integer(0)

    @property
    def axis(self) -> sp.Matrix:
        """e along (e_u, e_v, n)."""
        u = self.contact.body.coordinates[0]
        return sp.Matrix([-sp.sin(u), 0, sp.cos(u)])

    @cached_property
    def rolling_velocities(self) -> dict[sp.Expr, sp.Expr]:
        """The velocities of (u, v, u1, v1, theta) by s, tau, n."""
        return self.contact.rolling_velocities(SPINS)

    def carry(self, rates: Sequence[Any]) -> sp.Matrix:
        """``rates`` that hold velocities of the coordinates, by s, tau, n."""
        known = {velocity(q): rate for q, rate in self.rolling_velocities.items()}
        return sp.Matrix([as_expression(rate).xreplace(known) for rate in rates])

    def turning_momentum(self, omega: sp.Matrix) -> sp.Matrix:
        """I omega = A omega + (C - A)(omega, e) e."""
        along = (self.axial - self.equatorial) * dot(self.axis, omega) * self.axis
        return self.equatorial * omega + along

    @property
    def arm(self) -> sp.Matrix:
        """r = OM."""
        return sp.Matrix(self.contact.arm)

    @cached_property
    def trace(self) -> sp.Matrix:
        """r', the velocity of M over the body."""
        return self.carry(self.contact.body.trace_velocity)

    @cached_property
    def momentum(self) -> sp.Matrix:
        """G, the angular momentum about the contact, without the gyroscope."""
        arm, turning = self.arm, self.turning_momentum(sp.Matrix(SPINS))
        return turning + self.mass * column(cross(arm, cross(SPINS, arm)))

    @cached_property
    def momentum_rate(self) -> sp.Matrix:
        """The rates of the components of G along the moving frame."""
        whole = self.momentum + self.rotor * self.axis
        turning = self.carry(self.contact.body.frame_rates)
        rate = momentum_rate_about_point(whole, self.mass, SPINS, self.arm, self.trace)
        return rate - column(cross(turning, self.momentum))

    @property
    def as_any_body(self) -> tuple[dict[Any, Any], dict[str, Any]]:
        """The body as one of unknown surfaces: its state, and their functions.

        Its surface is explicit, and the state that of ``system``.
        """
        surface = self.contact.body
        omega = matrix_product(surface.frame, SPINS)
        same = (*ATTITUDE.coordinates, *PLACE, *self.contact.coordinates)
        state = {q: q for q in same} | carried_vectors(surface.position, surface.frame)
        return state | dict(zip(OMEGA, omega, strict=True)), form_values(self.contact)

    def shapes(self, touched: Sequence[Any], ground: Shape) -> tuple[Shape, Shape]:
        """The body and what it rolls on, as they are drawn: ``touched`` is the place of M in space.

        Of the fixed surface u1 and v1 are the colatitude and longitude of the normal.
        """
        body, fixed = self.contact.body, self.contact.fixed
        normal = Surface.sphere(1, *fixed.coordinates)
        attitude = RollingContact(body, normal, self.contact.theta).attitude
        place = sp.Matrix(three(touched, "a place"))
        shape = Shape.surface(body.coordinates, body.position, getattr(body, "ranges", None))
        centre = place - matrix_product(attitude, body.position)
        return replace(shape, centre=centre, attitude=attitude, contact=place), ground

    def system(
        self,
        *,
        further: Mapping[str, sp.Expr],
        relations: Sequence[Any] = (),
        **declared: Any,
    ) -> System:
        """The system of a body whose surface is explicit, with what is special to it.

        The base is Euler's angles (phi, chi, psi); the fibre what the motion carries along: the
        place o = (o1, o2, o3) of O seen from the body, (u, v, u1, v1, theta), and ``further``
        coordinates, by the names of the invariants that they are, bound by ``relations``.
        The equations close in cosines and sines of u, theta, u1, and these.
        """
        entries = {
            **self._declaration(),
            **self._claims(further),
            "fibration": Fibration(
                ATTITUDE.coordinates,
                (*PLACE, *self.rolling_velocities, *further.values()),
                tuple(relations),
            ),
            "meanings": {
                **euler_meanings(ATTITUDE.coordinates),
                **vector_meanings(PLACE, CARRIED_VECTORS[0]),
                **contact_meanings(self.contact),
                **moving_meanings(SPINS),
            },
            "sketch": rolling_sketch(
                body="torus",
                attitude=ATTITUDE.coordinates,
                **contact_views(self.contact, PLACE, [q for q in further.values() if q.is_Symbol]),
                wheel=wheel_of((self.rotor,)),
            ),
        }
        return join_declarations(entries, declared)

    def _declaration(self) -> dict[str, Any]:
        """Frame, Lagrangian and constraints of the body whose place and contact are carried."""
        place, surface = sp.Matrix(PLACE), self.contact.body
        omega = matrix_product(surface.frame, SPINS)
        moved = place.applyfunc(velocity) + column(cross(omega, place))
        inertia = (self.equatorial, self.equatorial, self.axial)
        rotor = self.rotor * dot(self.axis, SPINS)
        rates = matrix_product(surface.frame.T, ATTITUDE.body_rates)
        return {
            "frame": Frame.quasi(dict(zip(SPINS, rates, strict=True))),
            "lagrangian": kinetic_energy(self.mass, moved, inertia, omega) + rotor,
            "constraints": (
                *(velocity(q) - rate for q, rate in self.rolling_velocities.items()),
                *(moved + column(cross(omega, surface.position))),
            ),
        }

    @property
    def circular_invariants(self) -> dict[str, sp.Expr]:
        """Cosines and sines of u, theta and u1."""
        body, fixed = self.contact.body, self.contact.fixed
        return {
            f"{name}_{q}": function(q)
            for q in (body.coordinates[0], self.contact.theta, fixed.coordinates[0])
            for name, function in (("cos", sp.cos), ("sin", sp.sin))
        }

    def _claims(self, further: Mapping[str, sp.Expr]) -> dict[str, Any]:
        """The invariants in which the equations close, and claims by their names."""
        body, fixed = self.contact.body, self.contact.fixed
        angles = (body.coordinates[0], self.contact.theta, fixed.coordinates[0])
        invariants = {**self.circular_invariants, **further}
        named = {function: sp.Symbol(name) for name, function in invariants.items()}
        rate = self.momentum_rate.xreplace(named)
        return {
            "invariants": invariants,
            "equations": {"momentum": Equation(self.momentum.xreplace(named), rate)},
            "integrals": {"energy": dot(self.momentum, SPINS).xreplace(named) / 2},
            "essential": (*angles, *further.values(), *SPINS),
        }


@dataclass(frozen=True)
class TorusOnEllipsoid:
    """A torus that rolls without slipping on an ellipsoid of revolution, outer half down.

    tube, axes
        (R, r), the radii of the circle inside the tube and of the tube; (a, c), the semi-axes of
        the ellipsoid, across its axis and along it.
    mass, moments, rotor
        m, (A, C) about a diameter and about the axis, and k.

    With w^2 = sin^2 u1 + (c/a)^2 cos^2 u1 the radii of curvature of the ellipsoid are c^2/(a w^3)
    and a/w; w is a coordinate, so that no root occurs.
    """

    tube: tuple[Any, Any]
    axes: tuple[Any, Any]
    mass: Any
    moments: tuple[Any, Any]
    rotor: Any = sp.Integer(0)

    def __post_init__(self) -> None:
        pairs = {
            "tube": "the radii of a torus",
            "axes": "the semi-axes of an ellipsoid",
            "moments": "the moments of a torus",
        }
        for name, what in pairs.items():
            object.__setattr__(self, name, two(getattr(self, name), what))

    @cached_property
    def body(self) -> BodyOfRevolution:
        """The torus with its contact, in the coordinates u, v, theta, u1, v1."""
        u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
        a, c = self.axes
        ellipsoid = SurfaceForms.revolution(u1, v1, (c**2 / (a * SLANT**3), a / SLANT))
        contact = RollingContact(Surface.torus(*self.tube, u, v), ellipsoid, theta)
        return BodyOfRevolution(contact, self.mass, *self.moments, self.rotor)

    @property
    def ball_state(self) -> dict[Any, Any]:
        """The state of a symmetric ball on a sphere, by (u, v, theta, u1, v1) and omega along its
        axes, in the variables of this system: R = 0 and a = c."""
        spin = matrix_product(self.body.contact.body.frame.T, OMEGA)
        spins = dict(zip(SPINS, spin, strict=True))
        return {**self.body.circular_invariants, "slant": 1, **spins}

    def system(
        self, *, caption: str, values: Mapping[Any, Any] | None = None, **declared: Any
    ) -> System:
        """The system, with ``values`` of its constants, and what is special to it.

        What ``values`` do not give is a torus of radii 1 and 1/2, of mass 1 and moments 1 and 3/2,
        on an ellipsoid of semi-axes 3 and 2.  The motion of the scene begins on the equator of the
        ellipsoid; ``caption`` is its own.
        """
        entries = {} if values is None else fixed_mapping(values, "values", "symbol: value")
        values = {**self._usual, **entries}
        a, c = self.axes
        u, v, u1, v1, theta = self.body.contact.coordinates
        around, up = a * sp.sin(u1) / SLANT, c**2 * sp.cos(u1) / (a * SLANT)
        touched = (around * sp.cos(v1), around * sp.sin(v1), up)
        start = {"chi": 1, u: 1, theta: 1, u1: sp.pi / 2, SLANT: 1}
        start |= dict(zip(SPINS, (1, "1/2", 2), strict=True))
        outputs = (u, v, u1, v1, theta)
        entries = {
            "relations": (a**2 * (SLANT**2 - sp.sin(u1) ** 2) - c**2 * sp.cos(u1) ** 2,),
            "meanings": {
                SLANT: "root of sin(u1)^2 + (c/a)^2 cos(u1)^2, which gives the curvature of the "
                "ellipsoid",
            },
            "parameters": constants(values, self._words),
            "scenes": {"default": Scene(start, (0.0, 20.0), {}, outputs, caption)},
            "drawing": {"on the ellipsoid, by its normal": ("u1", "v1")},
            "shapes": self.body.shapes(touched, Shape.ellipsoid((a, a, c), role="ground")),
        }
        return self.body.system(further={"slant": SLANT}, **{**entries, **declared})

    @property
    def _usual(self) -> dict[Any, Any]:
        """The values of its constants where nothing else is said."""
        big, *others = (*self.tube, *self.axes, self.mass, *self.moments)
        usual = dict(zip(others, ("1/2", 3, 2, 1, 1, "3/2"), strict=True))
        if isinstance(big, sp.Symbol):
            usual = {big: Parameter(big, 1, lower=0, meaning=self._words[big][0]), **usual}
        return {q: value for q, value in usual.items() if isinstance(q, sp.Symbol)}

    @property
    def _words(self) -> Words:
        """What its constants are."""
        (big, small), (a, c), (equatorial, axial) = self.tube, self.axes, self.moments
        return {
            big: ("radius of the circle inside the tube", False),
            small: ("radius of the tube", True),
            a: ("equatorial semi-axis of the ellipsoid, with its sign", False),
            c: ("polar semi-axis, of the same sign", False),
            self.mass: ("mass", True),
            equatorial: ("inertia about a diameter", True),
            axial: ("inertia about the axis", True),
            **rotor_words((0, 0, self.rotor)),
        }
