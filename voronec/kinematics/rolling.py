"""Contact of two surfaces in C. Neumann's coordinates.

The body's surface r(u, v) touches the fixed surface r1(u1, v1) with opposite normals, and theta is
the angle from e_v1 to e_u in the tangent plane [Neumann1899]:

    R = B1 Q B^T,   Q = [[-sin, cos, 0], [cos, sin, 0], [0, 0, -1]](theta),   O = r1 - R r,

with the moving frames B = [e_u e_v n] on the body and B1 on the fixed surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.arguments import instance, require
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.declaration.shapes import Shape
from voronec.errors import DefinitionError
from voronec.kinematics.forms import SurfaceForms, curvature_lines
from voronec.kinematics.rotations import distinct_names
from voronec.kinematics.surfaces import Surface
from voronec.kinematics.vectors import Vector, apply_matrix, cross, matrix_product, three


@dataclass(frozen=True)
class RollingContact:
    """A body bounded by the surface ``body`` that touches the surface ``fixed`` at a point M.

    ``body`` is given in body axes about the body's origin O, ``fixed`` in space; ``theta`` is a
    symbol.  Nothing is assumed about slipping: all expressions are in the five Neumann
    coordinates (u, v, u1, v1, theta) and linear in their velocities; ``no_slip`` and ``no_twist``
    are the constraints.  A symbol used twice raises ``DefinitionError``.

    Surfaces known by their fundamental forms only serve for all that is seen along (u, v, n):
    ``arm``, ``spin``, ``slip``, ``centre_velocity`` and the constraints.
    """

    body: Surface | SurfaceForms
    fixed: Surface | SurfaceForms
    theta: sp.Expr

    def __post_init__(self) -> None:
        for role in ("body", "fixed"):
            kind = instance(Surface, SurfaceForms)
            require("the rolling contact", role, getattr(self, role), kind)
        distinct_names(self.coordinates, 5, "the rolling contact")
        for surface, role in ((self.body, "body"), (self.fixed, "fixed")):
            for name in set(self.coordinates) - set(surface.coordinates):
                if any(component.has(name) for component in _content(surface)):
                    raise DefinitionError(
                        f"the {role} surface contains '{plain_name(name)}', which is another "
                        "coordinate of the rolling contact; rename it there"
                    )

    @property
    def coordinates(self) -> tuple[sp.Expr, ...]:
        """(u, v, u1, v1, theta)."""
        return (*self.body.coordinates, *self.fixed.coordinates, self.theta)

    @cached_property
    def turn(self) -> sp.ImmutableMatrix:
        """Q(theta), components along (u, v, n) to components along (u1, v1, n1); Q = Q^T."""
        c, s = sp.cos(self.theta), sp.sin(self.theta)
        return sp.ImmutableMatrix([[-s, c, 0], [c, s, 0], [0, 0, -1]])

    @cached_property
    def attitude(self) -> sp.ImmutableMatrix:
        """R = B1 Q B^T, body components to space components."""
        return matrix_product(self.fixed.frame, self.turn, self.body.frame.T)

    @property
    def arm(self) -> Vector:
        """The vector OM from the body's origin to the contact, along (u, v, n)."""
        return _support(self.body)

    @cached_property
    def centre(self) -> sp.ImmutableMatrix:
        """O = r1 - R r, the body's origin in space; (R1 + R2) n1 for a ball on a sphere."""
        turned = self._rotate(self.arm)
        reach = [a - b for a, b in zip(_support(self.fixed), turned, strict=True)]
        return matrix_product(self.fixed.frame, reach)

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """The body and the fixed surface, as they are drawn; none of surfaces known by forms."""
        if not (isinstance(self.body, Surface) and isinstance(self.fixed, Surface)):
            return ()
        body, fixed = (
            Shape.surface(s.coordinates, s.position, s.ranges) for s in (self.body, self.fixed)
        )
        placed = {"centre": self.centre, "attitude": self.attitude}
        moving = replace(body, contact=self.fixed.position, **placed)
        return moving, replace(fixed, role="ground")

    @cached_property
    def spin(self) -> Vector:
        """(s, tau, n) = B^T omega: the body's angular velocity along (u, v, n).

        Q^T Omega1 - (0, 0, dtheta/dt) - Omega, with the ``frame_rates`` Omega of the surfaces.
        Since R^T dR/dt = B (Q^T hat(Omega1) Q + Q^T dQ/dt - hat(Omega)) B^T, that is what
        vee(R^T dR/dt) gives.  For lines of curvature: [DragovicGajicJovanovic2020, eq. (eq:n)].
        """
        s, tau, n = self._rotate(self.fixed.frame_rates)
        a, b, c = self.body.frame_rates
        return s - a, tau - b, n - c - velocity(self.theta)

    @cached_property
    def angular_velocity(self) -> Vector:
        """The body's angular velocity in body axes, B (s, tau, n)."""
        return apply_matrix(self.body.frame, self.spin)

    @cached_property
    def slip(self) -> Vector:
        """The velocity in space of the body's material point at M, along (u, v, n).

        Q^T (trace on the fixed surface) - (trace on the body), since dO/dt + omega x OM is
        dr1/dt - R dr/dt.  Its last component vanishes: the surfaces stay in contact.
        """
        a, b, c = self._rotate(self.fixed.trace_velocity)
        x, y, z = self.body.trace_velocity
        return a - x, b - y, c - z

    @cached_property
    def centre_velocity(self) -> Vector:
        """The velocity in space of the body's origin O along (u, v, n): slip - omega x OM."""
        x, y, z = cross(self.spin, self.arm)
        a, b, c = self.slip
        return a - x, b - y, c - z

    @cached_property
    def no_slip(self) -> tuple[sp.Expr, sp.Expr]:
        """The constraints of rolling without slipping: two expressions that vanish.

        The slip along u1 and v1.  For orthogonal coordinates it is
        L_u1 du1/dt + L_u du/dt sin theta - L_v dv/dt cos theta and
        L_v1 dv1/dt - L_u du/dt cos theta - L_v dv/dt sin theta
        [DragovicGajicJovanovic2020, eq. (eq:nosliding2)].
        """
        x, y, _ = self._rotate(self.body.trace_velocity)
        a, b, _ = self.fixed.trace_velocity
        return a - x, b - y

    @property
    def no_twist(self) -> sp.Expr:
        """The constraint n = 0 of a rubber body: it does not turn about the common normal."""
        return self.spin[2]

    def rolling_velocities(self, spin: Sequence[Any]) -> dict[sp.Expr, sp.Expr]:
        """The velocities of (u, v, u1, v1, theta) where the body rolls with spin (s, tau, n).

        Along lines of curvature, with k = -D/E, h = -D''/G, and k1, h1 of the fixed surface, the
        contact has the velocity (x, y) along e_u, e_v with

            s = b x + q y,  tau = -p x - b y,  p = k + k1 sin^2 + h1 cos^2,
            q = h + k1 cos^2 + h1 sin^2,  b = (h1 - k1) sin cos,

        sin and cos of theta; p q - b^2 is the determinant of the relative curvature.
        """
        lengths, (k, h), _ = curvature_lines(self.body)
        fixed_lengths, (k1, h1), _ = curvature_lines(self.fixed)
        c, sine = sp.cos(self.theta), sp.sin(self.theta)
        p, q = k + k1 * sine**2 + h1 * c**2, h + k1 * c**2 + h1 * sine**2
        b = (h1 - k1) * sine * c
        s, tau, n = three(spin, "a spin")
        x, y = -(b * s + q * tau) / (p * q - b**2), (p * s + b * tau) / (p * q - b**2)
        steps = (x, y, y * c - x * sine, x * c + y * sine)
        known = zip(self.coordinates[:4], steps, (*lengths, *fixed_lengths), strict=True)
        rates = {a: step / length for a, step, length in known}
        dots = {velocity(a): rate for a, rate in rates.items()}
        moving, carried = self.body.frame_rates[2], self.fixed.frame_rates[2]
        rates[self.theta] = -n - as_expression(moving + carried).xreplace(dots)
        return rates

    def _rotate(self, vector: Vector) -> Vector:
        """Q vector, and Q^T vector, which is the same."""
        c, s = sp.cos(self.theta), sp.sin(self.theta)
        a, b, n = vector
        return b * c - a * s, a * c + b * s, -n


def _content(surface: Surface | SurfaceForms) -> tuple[sp.Expr, ...]:
    """The expressions that a surface is given by."""
    if isinstance(surface, Surface):
        return surface.position
    return (*surface.first, *surface.second, *(surface.support or ()))


def _support(surface: Surface | SurfaceForms) -> Vector:
    if surface.support is None:
        raise DefinitionError("the support of a surface is not known; give it to SurfaceForms")
    return surface.support
