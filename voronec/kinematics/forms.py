"""Surfaces known by their fundamental forms only, in coordinates along lines of curvature."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn

import sympy as sp

from voronec.algebra.arguments import SEQUENCE, require
from voronec.algebra.symbols import velocity
from voronec.declaration.derivatives import derivative
from voronec.declaration.reading import expression
from voronec.errors import DefinitionError, quote
from voronec.kinematics.rotations import distinct_names
from voronec.kinematics.surfaces import Surface
from voronec.kinematics.vectors import Vector, cross, three


@dataclass(frozen=True)
class SurfaceForms:
    """A surface with the forms E du^2 + G dv^2 and D du^2 + D'' dv^2: F = D' = 0.

    coordinates
        (u, v), symbols; their lines are lines of curvature.
    first, second
        (E, G) and (D, D''), expressions in u and v, which may hold unknown functions.
    lengths
        the Lame lengths (L_u, L_v), whose squares are E and G; else positive square roots.
    support
        the components of the position along the moving frame (e_u, e_v, n), where they are known.
    bending
        E_v/(2 L_u L_v) and G_u/(2 L_u L_v), where they are known otherwise than by derivatives.

    Forms that belong to a surface satisfy ``relations``.  Where the forms are unknown functions,
    ``rules`` solves these, and the equations of Gauss and Weingarten, for derivatives; then what
    is proved holds for every surface.  A position in space is not known: what needs it raises
    ``DefinitionError``.
    """

    coordinates: tuple[sp.Expr, sp.Expr]
    first: tuple[sp.Expr, sp.Expr]
    second: tuple[sp.Expr, sp.Expr]
    lengths: tuple[sp.Expr, sp.Expr] | None = None
    support: Vector | None = None
    bending: tuple[sp.Expr, sp.Expr] | None = None

    def __post_init__(self) -> None:
        store = object.__setattr__
        require("the surface", "coordinates", self.coordinates, SEQUENCE)
        store(self, "coordinates", distinct_names(tuple(self.coordinates), 2, "the surface"))
        store(self, "first", two(self.first, "E and G"))
        store(self, "second", two(self.second, "D and D''"))
        if self.lengths is None:
            store(self, "lengths", (sp.sqrt(self.first[0]), sp.sqrt(self.first[1])))
        else:
            store(self, "lengths", two(self.lengths, "|r_u| and |r_v|"))
        if self.support is not None:
            store(self, "support", three(self.support, "the support of a surface"))
        if self.bending is not None:
            store(self, "bending", two(self.bending, "the bendings"))

    @classmethod
    def unknown(cls, u: sp.Expr, v: sp.Expr, mark: str = "") -> SurfaceForms:
        """An arbitrary surface: E, G, D, D'' and the support are unknown functions of u and v.

        ``mark`` is added to their names, as in ``E_1(u_1, v_1)``.
        """
        e, g, d, dd, a, b, c = (
            sp.Function(name + mark)(u, v)
            for name in ("E", "G", "D", "D''", "rho_u", "rho_v", "epsilon")
        )
        return cls((u, v), (e, g), (d, dd), support=(a, b, c))

    @classmethod
    def of(cls, surface: Surface) -> SurfaceForms:
        """The forms of an explicit surface; ``DefinitionError`` where its coordinates u, v are not
        along lines of curvature."""
        (e, f, g), (d, mixed, dd) = surface.first_form, surface.second_form
        if (f, mixed) != (0, 0):
            u, v = surface.coordinates
            raise DefinitionError(
                f"the coordinates {u}, {v} are not along lines of curvature: F = {f}, D' = {mixed}"
                "; use others"
            )
        return cls(surface.coordinates, (e, g), (d, dd), surface.lengths, surface.support)

    @classmethod
    def revolution(
        cls, u: sp.Expr, v: sp.Expr, radii: Sequence[Any], support: Sequence[Any] | None = None
    ) -> SurfaceForms:
        """A surface of revolution about z; u is the colatitude of its normal, v the longitude.

        ``radii`` (r1, r2) are the radii of curvature along u and v, the lengths (r1, r2 sin u),
        and the frame turns as a sphere's does.  The radii of a surface satisfy Codazzi's equation
        d(r2 sin u)/du = r1 cos u; it is taken for granted, so that they may hold any symbols.
        """
        first, second = two(radii, "radii")
        reach = second * sp.sin(u)
        given = None if support is None else three(support, "the support of a surface")
        return cls(
            (u, v),
            (first**2, reach**2),
            (-first, -reach * sp.sin(u)),
            (first, reach),
            given,
            (sp.Integer(0), sp.cos(u)),
        )

    @property
    def first_form(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """E, F = 0, G."""
        return self.first[0], sp.Integer(0), self.first[1]

    @property
    def second_form(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """D, D' = 0, D''."""
        return self.second[0], sp.Integer(0), self.second[1]

    @property
    def trace_velocity(self) -> Vector:
        """The velocity of a point that moves over the surface: (L_u du/dt, L_v dv/dt, 0)."""
        (lu, lv), (du, dv) = self._lengths, map(velocity, self.coordinates)
        return lu * du, lv * dv, sp.Integer(0)

    @property
    def frame_rates(self) -> Vector:
        """The angular velocity of the moving frame against the surface, along (e_u, e_v, n).

        (D''/L_v dv/dt, -D/L_u du/dt, (G_u dv/dt - E_v du/dt)/(2 L_u L_v)).
        """
        du, dv = map(velocity, self.coordinates)
        (a, b, c), (x, y, z) = self._turns
        return x * dv + a * du, b * du + y * dv, c * du + z * dv

    @cached_property
    def relations(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """Two equations of Codazzi and the equation of Gauss, as expressions that vanish.

        D_v - E_v/2 (D/E + D''/G),  D''_u - G_u/2 (D/E + D''/G), and
        ((E_v/W)_v + (G_u/W)_u)/2 + D D''/W with W = L_u L_v.
        """
        (u, v), (e, g), (d, dd) = self.coordinates, self.first, self.second
        twice_mean, width = d / e + dd / g, self._lengths[0] * self._lengths[1]
        ev, gu = derivative(e, v), derivative(g, u)
        bending = derivative(ev / width, v) + derivative(gu / width, u)
        return (
            derivative(d, v) - ev * twice_mean / 2,
            derivative(dd, u) - gu * twice_mean / 2,
            bending / 2 + d * dd / width,
        )

    def rules(
        self, vectors: Sequence[Sequence[Any]] = (), tensors: Sequence[Any] = ()
    ) -> dict[sp.Expr, sp.Expr]:
        """Derivatives of unknown functions, with the values that the geometry gives them.

        D_v, D''_u and G_uu by ``relations``; the derivatives of the support; and those of the
        components of vectors (three each) and of symmetric tensors (3 x 3) that are fixed to the
        surface, along its moving frame: x_q = -Omega_q x x and J_q = J H - H J, H the matrix of
        Omega_q x.  Only derivatives of unknown functions are in the result.
        """
        (u, v), (d_v, dd_u, gauss) = self.coordinates, self.relations
        highest = sp.diff(self.first[1], u, 2)
        slope = sp.diff(sp.expand(gauss), highest) if highest.is_Derivative else sp.Integer(1)
        pairs = [
            (derivative(self.second[0], v), derivative(self.second[0], v) - d_v),
            (derivative(self.second[1], u), derivative(self.second[1], u) - dd_u),
            (highest, highest - sp.expand(gauss) / slope),
        ]
        along = zip((u, v), self._turns, self._steps, strict=True)
        for q, turn, step in along:
            moved = [(vector, (sp.Integer(0),) * 3) for vector in vectors]
            moved += [] if self.support is None else [(self.support, step)]
            for vector, rate in moved:
                turned = cross(turn, vector)
                pairs += [
                    (derivative(x, q), a - b) for x, a, b in zip(vector, rate, turned, strict=True)
                ]
            for tensor in tensors:
                change = tensor * _hat(turn) - _hat(turn) * tensor
                pairs += [(derivative(x, q), y) for x, y in zip(tensor, change, strict=True)]
        return {name: sp.expand(value) for name, value in pairs if name.is_Derivative}

    @property
    def position(self) -> NoReturn:
        """Not known."""
        _nowhere()

    @property
    def frame(self) -> NoReturn:
        """Not known."""
        _nowhere()

    @property
    def _lengths(self) -> tuple[sp.Expr, sp.Expr]:
        assert self.lengths is not None
        return self.lengths

    @property
    def _turns(self) -> tuple[Vector, Vector]:
        """``frame_rates`` for du/dt = 1, and for dv/dt = 1."""
        (u, v), (e, g), (d, dd) = self.coordinates, self.first, self.second
        lu, lv = self._lengths
        zero, bending = sp.Integer(0), self.bending
        if bending is None:
            bending = (derivative(e, v) / (2 * lu * lv), derivative(g, u) / (2 * lu * lv))
        across, along = bending
        return (zero, -d / lu, -across), (dd / lv, zero, along)

    @property
    def _steps(self) -> tuple[Vector, Vector]:
        """``trace_velocity`` for du/dt = 1, and for dv/dt = 1."""
        (lu, lv), zero = self._lengths, sp.Integer(0)
        return (lu, zero, zero), (zero, lv, zero)


def two(things: Any, what: str) -> tuple[sp.Expr, sp.Expr]:
    """Two expressions out of a sequence; ``what`` names them in errors."""
    entries = things if isinstance(things, Iterable) else ()
    pair = tuple(expression(thing, what) for thing in entries)
    if len(pair) != 2:
        raise DefinitionError(f"{what} are two, got '{quote(things)}'")
    return pair[0], pair[1]


def curvature_lines(surface: Surface | SurfaceForms) -> tuple[tuple[sp.Expr, sp.Expr], ...]:
    """Of a surface along its lines of curvature: the lengths L_u, L_v; the curvatures -D/E and
    -D''/G, positive where it bends away from its normal; the bendings E_v/(2 L_u L_v) and
    G_u/(2 L_u L_v).  ``DefinitionError`` where its coordinates are not along these lines."""
    forms = surface if isinstance(surface, SurfaceForms) else SurfaceForms.of(surface)
    (e, g), (d, dd), turns = forms.first, forms.second, forms._turns
    return forms._lengths, (-d / e, -dd / g), (-turns[0][2], turns[1][2])


def _nowhere() -> NoReturn:
    raise DefinitionError(
        "a surface given by its fundamental forms has no position in space; use Surface"
    )


def _hat(vector: Vector) -> sp.ImmutableMatrix:
    """The matrix of vector x."""
    x, y, z = vector
    return sp.ImmutableMatrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
