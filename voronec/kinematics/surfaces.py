"""Surfaces in parametric form: their moving frames and fundamental forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import sympy as sp

from voronec.algebra.arguments import SEQUENCE, require
from voronec.algebra.normal import shortest
from voronec.algebra.symbols import time, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.verdicts import decide_equal
from voronec.declaration.derivatives import derivative
from voronec.declaration.reading import expression, several
from voronec.errors import DefinitionError, EngineLimit
from voronec.kinematics.rotations import distinct_names
from voronec.kinematics.vectors import Vector, cross, dot, three

HALF, WHOLE = (0, sp.pi), (0, 2 * sp.pi)


@dataclass(frozen=True)
class Surface:
    """A surface r(u, v) with its moving frame e_u = r_u/L_u, n = r_u x r_v / W, e_v = n x e_u.

    coordinates
        (u, v), symbols or ``dynamicsymbols``.
    position
        the three components of r, of the dimension of a length.
    lengths
        the Lame lengths (L_u, L_v) = (|r_u|, |r_v|) without square roots, where there are such:
        (R, R sin u) on a sphere.  Their squares are proved equal to E and G.  Their signs are
        yours, and turn the frame: negative lengths turn e_u and e_v by half a turn.
    area
        the element of area W = L_u L_v sin(angle), for coordinates that are not orthogonal;
        its square is proved equal to E G - F^2.  A negative one turns n around.
    ranges
        between which numbers u and v run, two pairs, where the surface is bounded: for pictures.

    What is not given is a square root, taken positive.  Wrong lengths, a repeated symbol, a
    surface that moves with the time and one that is a curve or a point raise ``DefinitionError``.
    """

    coordinates: tuple[sp.Expr, sp.Expr]
    position: tuple[sp.Expr, sp.Expr, sp.Expr]
    lengths: tuple[sp.Expr, sp.Expr] | None = None
    area: sp.Expr | None = None
    ranges: tuple[Any, Any] | None = None

    def __post_init__(self) -> None:
        store = object.__setattr__
        require("the surface", "coordinates", self.coordinates, SEQUENCE)
        store(self, "coordinates", distinct_names(tuple(self.coordinates), 2, "the surface"))
        store(self, "position", three(self.position, "the position on a surface"))
        if self.lengths is not None:
            given = several(self.lengths, "lengths", "expression")
            lengths = tuple(expression(length, "a length of a surface") for length in given)
            if len(lengths) != 2:
                raise DefinitionError("lengths of a surface: two are needed, |r_u| and |r_v|")
            store(self, "lengths", lengths)
        if self.area is not None:
            store(self, "area", expression(self.area, "the area of a surface"))
        _ = self._shape  # every error shows itself here, not at first use

    @classmethod
    def sphere(cls, radius: Any, u: sp.Expr, v: sp.Expr) -> Surface:
        """A sphere, r = radius (sin u cos v, sin u sin v, cos u): colatitude u, longitude v.

        The frame is the same for every radius: n = (sin u cos v, sin u sin v, cos u), which is
        outward; with -R for the radius it is inward, and r = -R n.
        """
        return _sphere(expression(radius, "the radius of a sphere"), *_angles(u, v))

    @classmethod
    def plane(cls, u: sp.Expr, v: sp.Expr) -> Surface:
        """The plane z = 0, r = (u, v, 0), with the normal along z."""
        return cls((u, v), (u, v, sp.Integer(0)), (sp.Integer(1), sp.Integer(1)))

    @classmethod
    def ellipsoid(cls, axes: Sequence[Any], u: sp.Expr, v: sp.Expr) -> Surface:
        """An ellipsoid, r = (a sin u cos v, b sin u sin v, c cos u), with the outward normal.

        ``axes`` are the semi-axes (a, b, c).  The coordinates are orthogonal where a = b.
        """
        a, b, c = three(axes, "the semi-axes of an ellipsoid")
        u, v = _angles(u, v)
        x, y, z = sp.sin(u) * sp.cos(v), sp.sin(u) * sp.sin(v), sp.cos(u)
        slant = sp.sqrt((b * c * x) ** 2 + (a * c * y) ** 2 + (a * b * z) ** 2)
        position = (a * x, b * y, c * z)
        return cls((u, v), position, area=slant * sp.sin(u), ranges=(HALF, WHOLE))

    @classmethod
    def torus(cls, radius: Any, tube: Any, u: sp.Expr, v: sp.Expr) -> Surface:
        """A torus about the axis z, radius > tube > 0, with the outward normal.

        r = ((radius + tube sin u) cos v, (radius + tube sin u) sin v, tube cos u): u goes around
        the tube from its top, v around the axis.  A sphere is the case of radius 0.
        """
        radius, tube = (expression(x, "the radius of a torus") for x in (radius, tube))
        u, v = _angles(u, v)
        reach = radius + tube * sp.sin(u)
        position = (reach * sp.cos(v), reach * sp.sin(v), tube * sp.cos(u))
        return cls((u, v), position, (tube, reach), ranges=(WHOLE, WHOLE))

    @classmethod
    def revolution(cls, profile: Sequence[Any], u: sp.Expr, v: sp.Expr) -> Surface:
        """A surface of revolution about z, r = (f cos v, f sin v, g) with profile (f(u), g(u)).

        f > 0; the profile may hold unknown functions.  With s = |(f', g')| the normal is
        (-g' cos v, -g' sin v, f')/s: outward where g falls.
        """
        f, g = (expression(part, "a profile") for part in profile)
        reach = sp.sqrt(derivative(f, u) ** 2 + derivative(g, u) ** 2)
        return cls((u, v), (f * sp.cos(v), f * sp.sin(v), g), (reach, f))

    @property
    def first_form(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """E = r_u . r_u, F = r_u . r_v, G = r_v . r_v."""
        shape = self._shape
        return self._out((shape.e, shape.f, shape.g))

    @cached_property
    def second_form(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """D = r_uu . n, D' = r_uv . n, D'' = r_vv . n."""
        return self._out(self._shape.second_form)

    @property
    def orthogonal(self) -> bool:
        """Whether F = 0 is proved: the coordinate lines cross at right angles."""
        return bool(self._shape.f == 0)

    @cached_property
    def gauss_curvature(self) -> sp.Expr:
        """K = (D D'' - D'^2)/(E G - F^2)."""
        shape = self._shape
        d, mixed, dd = shape.second_form
        return self._out(_short([(d * dd - mixed**2) / shape.square]))[0]

    @cached_property
    def frame(self) -> sp.ImmutableMatrix:
        """[e_u e_v n]: a proper rotation, whose columns are the moving frame."""
        columns = self._out(_short([x for axis in self._shape.axes for x in axis]))
        return sp.ImmutableMatrix(3, 3, columns).T

    @property
    def normal(self) -> sp.ImmutableMatrix:
        """n = e_u x e_v."""
        return self.frame[:, 2]

    @cached_property
    def support(self) -> Vector:
        """The components (r . e_u, r . e_v, r . n) of the position along the moving frame."""
        shape = self._shape
        return self._out(_short([dot(shape.r, axis) for axis in shape.axes]))

    @cached_property
    def trace_velocity(self) -> Vector:
        """The velocity of a point that moves over the surface, along (e_u, e_v, n).

        (L_u du/dt + F/L_u dv/dt, W/L_u dv/dt, 0).
        """
        shape, (du, dv) = self._shape, map(velocity, self.coordinates)
        along, across = self._out(_short([shape.f / shape.lu, shape.width]))
        return self._out((shape.lu,))[0] * du + along * dv, across * dv, sp.Integer(0)

    @cached_property
    def frame_rates(self) -> Vector:
        """The angular velocity of the moving frame B against the surface, vee(B^T dB/dt).

        Along (e_u, e_v, n); with h = W/L_u it is, by Weingarten's equations and the connection of
        the frame,

            ((D' - D F/E) du/dt + (D'' - D' F/E) dv/dt) / h,
            -(D du/dt + D' dv/dt) / L_u,
            ((2 F_u - E_v - E_u F/E) du/dt + (G_u - E_v F/E) dv/dt) / (2 W).
        """
        coefficients = self._out(
            _short([x for row in self._shape.frame_rate_coefficients for x in row])
        )
        du, dv = map(velocity, self.coordinates)
        x, y, z = (coefficients[i] * du + coefficients[i + 1] * dv for i in (0, 2, 4))
        return x, y, z

    def _out(self, exprs: Sequence[Any]) -> tuple[Any, ...]:
        return tuple(self._shape.bridge.outward(e) for e in exprs)

    @cached_property
    def _shape(self) -> _Shape:
        bridge = SymPyBridge(self.coordinates)
        u, v = bridge.inward_all(self.coordinates)
        r = bridge.inward_all(self.position)
        if any(str(s) == time.name for x in r for s in x.free_symbols):
            raise DefinitionError(
                "the position on a surface depends on the time; give the surface at rest"
            )
        lengths = [None, None] if self.lengths is None else bridge.inward_all(self.lengths)
        area = None if self.area is None else bridge.inward(self.area)
        return _Shape.of(bridge, (u, v), r, lengths, area)


@lru_cache(maxsize=64)
def _sphere(radius: sp.Expr, u: sp.Expr, v: sp.Expr) -> Surface:
    """A sphere, made once: a body that rolls asks for the same again and again."""
    reach = radius * sp.sin(u)
    position = (reach * sp.cos(v), reach * sp.sin(v), radius * sp.cos(u))
    return Surface((u, v), position, (radius, reach), ranges=(HALF, WHOLE))


@dataclass(frozen=True)
class _Shape:
    """A surface in the engine's symbols, in symengine expressions."""

    bridge: SymPyBridge
    coordinates: tuple[Any, Any]
    r: Sequence[Any]
    ru: Sequence[Any]
    rv: Sequence[Any]
    e: Any
    f: Any
    g: Any
    square: Any  # E G - F^2
    lu: Any
    area: Any
    width: Any  # W/L_u, which is L_v where the coordinates are orthogonal

    @classmethod
    def of(
        cls, bridge: SymPyBridge, names: tuple[Any, Any], r: Sequence[Any], lengths: Any, area: Any
    ) -> _Shape:
        """Compute the first form, and check the lengths that are given."""
        ru, rv = ([x.diff(name) for x in r] for name in names)
        e, f, g = _short([dot(ru, ru), dot(ru, rv), dot(rv, rv)])
        square = e * g if f == 0 else _short([e * g - f**2])[0]
        if square == 0:
            raise DefinitionError(
                f"r({names[0]}, {names[1]}) is not a surface: r_{names[0]} and r_{names[1]} are "
                "dependent everywhere; use two coordinates that move the point independently"
            )
        claims = {f"|r_{names[0]}|": (lengths[0], e), f"|r_{names[1]}|": (lengths[1], g)}
        for name, (length, truth) in (claims | {"the area": (area, square)}).items():
            if length is not None:
                _check(name, length, truth)
        lu, lv = (_root(x) if x2 is None else x2 for x, x2 in ((e, lengths[0]), (g, lengths[1])))
        if area is None:
            area = lu * lv if f == 0 else _root(square)
            width = lv if f == 0 else area / lu
        else:
            width = area / lu
        return cls(bridge, names, r, ru, rv, e, f, g, square, lu, area, width)

    @cached_property
    def axes(self) -> tuple[Sequence[Any], Sequence[Any], Sequence[Any]]:
        """e_u, e_v, n."""
        eu = [x / self.lu for x in self.ru]
        slope = self.f / self.e
        ev = [(b - slope * a) / self.width for a, b in zip(self.ru, self.rv, strict=True)]
        n = [x / self.area for x in cross(self.ru, self.rv)]
        return eu, ev, n

    @cached_property
    def second_form(self) -> list[Any]:
        """D, D', D''."""
        u, v = self.coordinates
        seconds = [(self.ru, u), (self.ru, v), (self.rv, v)]
        normal = cross(self.ru, self.rv)
        return _short(
            [dot([x.diff(name) for x in tangent], normal) / self.area for tangent, name in seconds]
        )

    @property
    def frame_rate_coefficients(self) -> tuple[tuple[Any, Any], ...]:
        """The coefficients of ``Surface.frame_rates`` at du/dt and dv/dt."""
        u, v = self.coordinates
        d, mixed, dd = self.second_form
        slope = self.f / self.e
        return (
            ((mixed - d * slope) / self.width, (dd - mixed * slope) / self.width),
            (-d / self.lu, -mixed / self.lu),
            (
                (2 * self.f.diff(u) - self.e.diff(v) - self.e.diff(u) * slope) / (2 * self.area),
                (self.g.diff(u) - self.e.diff(v) * slope) / (2 * self.area),
            ),
        )


def _root(square: Any) -> Any:
    """The positive square root, as a symengine expression."""
    import symengine as se

    return se.sqrt(square)


def _short(exprs: list[Any]) -> list[Any]:
    """The shortest proved forms, or the expressions as they are where that is too much work."""
    try:
        return shortest(exprs)
    except EngineLimit:
        return exprs


def _check(name: str, length: Any, square: Any) -> None:
    verdict = decide_equal(length**2, square)
    if verdict.proved:
        return
    why = f"{verdict.witness}" if verdict.refuted else verdict.method
    raise DefinitionError(
        f"{name} = {length} of the surface is wrong: its square must be {square} ({why})"
    )


def _angles(u: Any, v: Any) -> tuple[sp.Expr, sp.Expr]:
    """Coordinates of a surface, read before functions are taken of them."""
    return expression(u, "a coordinate of a surface"), expression(v, "a coordinate of a surface")
