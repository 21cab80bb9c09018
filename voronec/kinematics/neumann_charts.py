"""Charts of a body that rolls: the polar axes of Neumann's coordinates, turned.

Colatitude and longitude are singular at the poles.  A half turn about the axis between x and z,

    (x, y, z) -> (z, -y, x),

puts the poles onto the axis x.  With N = (sin u cos v, sin u sin v, cos u) it takes (u, v) to

    u' = atan2(|(N_y, N_z)|, N_x),   v' = atan2(-N_y, N_z),

and turns the coordinate lines through the angle a = atan2(sin v, -cos u cos v), e_u' = e_u cos a +
e_v sin a; theta becomes theta - a - a1, with a1 of the sphere.  Done twice, nothing has happened.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.arguments import POINT, instance, require
from voronec.declaration.charts import Chart
from voronec.errors import DefinitionError
from voronec.kinematics.forms import SurfaceForms
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.surfaces import Surface

HALF_TURN = sp.ImmutableMatrix([[0, 0, 1], [0, -1, 0], [1, 0, 0]])
"""Exchanges the axes x and z."""


def turned_poles(
    contact: RollingContact, changes: Mapping[str, Any], along: Sequence[Any] = ()
) -> dict[str, Chart]:
    """The charts of a ball: its polar axis turned; on a sphere that of the sphere too, and both.

    ``changes`` are the declarations that read differently where the ball's axes are turned, as
    ``Chart`` has them; the axes of the fixed surface occur in none.  ``along`` are the two
    velocities of the equations, if there are such, that are components along (e_u, e_v).
    """
    require("turned_poles", "contact", contact, instance(RollingContact))
    require("turned_poles", "changes", changes, POINT)
    ball, theta = _PolarPair(*contact.body.coordinates), contact.theta
    flipped = {**ball.sheet, **{x: -x for x in along}, theta: theta + sp.pi}
    turned = {**ball.state, **ball.components(along)}
    if not _is_sphere(contact.fixed):
        state = {**turned, theta: theta - ball.angle}
        return {
            "pole of the ball turned": Chart(state, ball.singular, changes, double_cover=(flipped,))
        }
    fixed = _PolarPair(*contact.fixed.coordinates)
    singular = ball.singular * fixed.singular
    both = {**turned, **fixed.state, theta: theta - ball.angle - fixed.angle}
    sheets = (flipped, {**fixed.sheet, theta: theta + sp.pi})
    single = {**turned, theta: theta - ball.angle}
    return {
        "pole of the ball turned": Chart(single, singular, changes, double_cover=sheets[:1]),
        **_of_sphere(fixed, theta, singular),
        "both poles turned": Chart(both, singular, changes, double_cover=sheets),
    }


def turned_sphere(contact: RollingContact) -> dict[str, Chart]:
    """The chart of any body that rolls on a fixed sphere: the polar axis of the sphere turned.

    Nothing that a system declares reads differently in it: of the body's own coordinates, and of
    velocities in the lines on it, none changes.  Raises ``DefinitionError`` where the fixed surface
    is no sphere about the origin in colatitude and longitude.
    """
    require("turned_sphere", "contact", contact, instance(RollingContact))
    if not _is_sphere(contact.fixed):
        raise DefinitionError("turned_sphere: the fixed surface is no sphere; give another chart")
    fixed = _PolarPair(*contact.fixed.coordinates)
    return _of_sphere(fixed, contact.theta, fixed.singular)


def _of_sphere(fixed: _PolarPair, theta: sp.Symbol, singular: sp.Expr) -> dict[str, Chart]:
    state = {**fixed.state, theta: theta - fixed.angle}
    sheet = {**fixed.sheet, theta: theta + sp.pi}
    return {"pole of the sphere turned": Chart(state, singular, double_cover=(sheet,))}


@dataclass(frozen=True)
class _PolarPair:
    """Colatitude and longitude, and what the half turn makes of them."""

    u: sp.Expr
    v: sp.Expr

    @property
    def singular(self) -> sp.Expr:
        """Vanishes at the poles."""
        return sp.sin(self.u)

    @cached_property
    def reach(self) -> sp.Expr:
        """sin u', as a sum of squares: the distance from the axis x."""
        square = (sp.sin(self.u) * sp.sin(self.v)) ** 2 + sp.cos(self.u) ** 2
        return sp.Pow(square, sp.S.Half, evaluate=False)  # as `_angle`

    @cached_property
    def state(self) -> dict[sp.Expr, sp.Expr]:
        """(u', v')."""
        across = sp.sin(self.u)
        return {
            self.u: _angle(self.reach, across * sp.cos(self.v)),
            self.v: _angle(-across * sp.sin(self.v), sp.cos(self.u)),
        }

    @property
    def sheet(self) -> dict[sp.Expr, sp.Expr]:
        """Other values for the same point, in which both coordinate lines run the other way."""
        return {self.u: -self.u, self.v: self.v + sp.pi}

    @cached_property
    def angle(self) -> sp.Expr:
        """a, from e_u to e_u'."""
        return _angle(sp.sin(self.v), -sp.cos(self.u) * sp.cos(self.v))

    def components(self, along: Sequence[Any]) -> dict[sp.Expr, sp.Expr]:
        """Components along (e_u, e_v) in the turned lines."""
        if not along:
            return {}
        x, y = along
        sine = sp.sin(self.v) / self.reach
        cosine = -sp.cos(self.u) * sp.cos(self.v) / self.reach
        return {x: cosine * x + sine * y, y: cosine * y - sine * x}


def _angle(y: sp.Expr, x: sp.Expr) -> sp.Expr:
    """atan2(y, x), without SymPy's search for signs of y and x, which have none here."""
    return sp.atan2(y, x, evaluate=False)


def _is_sphere(surface: Surface | SurfaceForms) -> bool:
    """Whether a surface is a sphere about the origin in colatitude and longitude."""
    if not isinstance(surface, Surface) or surface.lengths is None:
        return False
    (u, v), (radius, reach) = surface.coordinates, surface.lengths
    place = (reach * sp.cos(v), reach * sp.sin(v), radius * sp.cos(u))
    return bool(reach == radius * sp.sin(u) and surface.position == place)
