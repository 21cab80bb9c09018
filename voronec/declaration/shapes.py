"""Shapes of bodies and surfaces, as they are drawn: patches, where they are, what they touch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.declaration.reading import several
from voronec.errors import DefinitionError, quote

MESH = a, b = sp.symbols("mesh_a mesh_b")
"""The two coordinates of every patch."""
ROLES = "body", "ground"
PLACEMENT = "centre", "attitude", "contact", "role", "title"
"""What every shape may be given besides its form."""
HALF, WHOLE = (0, sp.pi), (0, 2 * sp.pi)
UNIT = (-1, 1)


@dataclass(frozen=True)
class Patch:
    """A piece of a surface: three functions of ``MESH`` and of parameters, and the ranges of the
    two, pairs of numbers; None for what has no end."""

    position: tuple[Any, ...]
    ranges: tuple[Any, Any] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", _three(self.position, "the position of a shape"))

    def place(self, where: Callable[..., tuple[Any, ...]]) -> Patch:
        """The piece with its three functions taken elsewhere."""
        return Patch(where(*self.position), self.ranges)


@dataclass(frozen=True)
class Shape:
    """A body, or a surface that bodies roll on, as a viewer draws it.

    patches
        what it consists of, in axes of its own.
    centre, attitude
        where the origin of these axes is in space, three expressions, and the matrix that takes
        components along them to components in space, or the angle of a turn about the vertical;
        expressions of coordinates, velocities, parameters and the time.
    contact
        the point in space at which it touches, three expressions: its trace is drawn on the body
        and in space.
    role
        ``body``, or ``ground`` for what bodies roll on.  What holds the other inside is drawn as
        glass.
    title
        what it is called.

    Lengths have the unit of those of the system.  Raises ``DefinitionError`` for places that are
    not of three expressions, and for an attitude that is no angle and not 3 x 3.
    """

    patches: tuple[Patch, ...]
    centre: tuple[Any, ...] = (0, 0, 0)
    attitude: Any = None
    contact: tuple[Any, ...] | None = None
    role: str = "body"
    title: str = ""

    def __post_init__(self) -> None:
        place = f"the shape '{quote(self.title)}'" if self.title else "a shape"
        if self.role not in ROLES:
            raise DefinitionError(
                f"{place} has the role '{quote(self.role)}'; give one of {', '.join(ROLES)}"
            )
        turned = self.attitude
        if not isinstance(turned, sp.MatrixBase | list | tuple):
            turned = turn_about(2, as_expression(turned or 0, f"the attitude of {place}"))
        turned = sp.ImmutableMatrix(turned)
        if turned.shape != (3, 3):
            raise DefinitionError(f"{place} has an attitude {turned.shape}; give a 3 x 3 matrix")
        object.__setattr__(self, "attitude", turned)
        object.__setattr__(self, "centre", _three(self.centre, f"the centre of {place}"))
        if self.contact is not None:
            object.__setattr__(self, "contact", _three(self.contact, f"the contact of {place}"))

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """All that changes with the state: centre, attitude row by row, contact."""
        return (*self.centre, *self.attitude, *(self.contact or ()))

    @classmethod
    def ball(cls, radius: Any, **placed: Any) -> Shape:
        """A ball about its centre."""
        return cls.ellipsoid((radius, radius, radius), **placed)

    @classmethod
    def ellipsoid(cls, axes: Sequence[Any], **placed: Any) -> Shape:
        """An ellipsoid with these semi-axes."""
        x, y, z = _three(axes, "the semi-axes of a shape")
        unit = (sp.sin(a) * sp.cos(b), sp.sin(a) * sp.sin(b), sp.cos(a))
        return cls((Patch((x * unit[0], y * unit[1], z * unit[2]), (HALF, WHOLE)),), **placed)

    @classmethod
    def torus(cls, ring: Any, tube: Any, **placed: Any) -> Shape:
        """A torus about its third axis: the circle of its tubes' middles, and a tube's radius."""
        reach = ring + tube * sp.sin(a)
        position = (reach * sp.cos(b), reach * sp.sin(b), tube * sp.cos(a))
        return cls((Patch(position, (WHOLE, WHOLE)),), **placed)

    @classmethod
    def disc(cls, radius: Any, width: Any = None, **placed: Any) -> Shape:
        """A disc or a wheel, its axle along the third axis; by default a tenth as wide as high."""
        half = radius / 10 if width is None else width / 2
        round_ = (radius * sp.cos(b), radius * sp.sin(b))
        caps = [Patch((a * round_[0], a * round_[1], s * half), ((0, 1), WHOLE)) for s in (1, -1)]
        return cls((Patch((*round_, a * half), (UNIT, WHOLE)), *caps), **placed)

    @classmethod
    def wheel(
        cls, radius: Any, heading: Any, turned: Any = 0, width: Any = None, **placed: Any
    ) -> Shape:
        """A wheel on a level axle: its heading is an angle from the first axis of space, and it has
        turned forwards by another."""
        along, down = (sp.cos(turned), -sp.sin(turned)), (-sp.sin(turned), -sp.cos(turned))
        upright = sp.Matrix([[along[0], down[0], 0], [0, 0, 1], [along[1], down[1], 0]])
        attitude = turn_about(2, as_expression(heading)) * upright
        return cls.disc(radius, width, **{"attitude": attitude, **placed})

    @classmethod
    def box(cls, lengths: Sequence[Any], **placed: Any) -> Shape:
        """A box with edges of these lengths, about its middle."""
        halves = [length / 2 for length in _three(lengths, "the edges of a shape")]
        faces = []
        for k in range(3):
            for side in UNIT:
                unit = [a, b]
                unit.insert(k, as_expression(side))
                parts = tuple(h * u for h, u in zip(halves, unit, strict=True))
                faces.append(Patch(parts, (UNIT, UNIT)))
        return cls(tuple(faces), **placed)

    @classmethod
    def rod(cls, length: Any, radius: Any = None, **placed: Any) -> Shape:
        """A rod along its first axis, about its middle; by default twenty times as long as wide."""
        round_ = cls.disc(length / 40 if radius is None else radius, length).patches
        return cls(tuple(p.place(lambda x, y, z: (z, x, y)) for p in round_), **placed)

    @classmethod
    def blade(cls, length: Any, **placed: Any) -> Shape:
        """A blade along its first axis, as of a skate, that stands on its centre."""
        upright = cls.box((length, length / 40, length / 4)).patches
        return cls(
            tuple(p.place(lambda x, y, z: (x, y, z + length / 8)) for p in upright), **placed
        )

    @classmethod
    def cart(cls, length: Any, **placed: Any) -> Shape:
        """A cart that drives along its first axis, its centre on the ground between four wheels; it
        is half as wide as long, and its top is half as high as it is long."""
        radius, top = length / 8, cls.box((length, length / 2, length / 4)).patches
        parts = [p.place(lambda x, y, z: (x, y, z + 3 * radius)) for p in top]
        for side in UNIT:
            for end in UNIT:
                at = (end * length / 3, side * length / 4)
                round_ = cls.disc(radius).patches
                parts += [
                    p.place(lambda x, y, z, at=at: (x + at[0], z + at[1], y + radius))
                    for p in round_
                ]
        return cls(tuple(parts), **placed)

    @classmethod
    def plane(cls, **placed: Any) -> Shape:
        """The plane z = 0, as far as the motion goes."""
        return cls((Patch((a, b, sp.Integer(0))),), **{"role": "ground", **placed})

    @classmethod
    def surface(
        cls,
        coordinates: Sequence[Any],
        position: Any,
        ranges: Sequence[Any] | None = None,
        **placed: Any,
    ) -> Shape:
        """Any surface by its ``position``, three functions of two coordinates, whose ``ranges`` are
        two pairs of numbers; without them it goes as far as the motion.  One function f of x and y
        is the surface z = f(x, y)."""
        named = dict(zip(coordinates, MESH, strict=True))
        if not isinstance(position, sp.MatrixBase | list | tuple):
            position = (*coordinates, position)
        parts = _three(position, "the position of a shape")
        pairs = None if ranges is None else (tuple(ranges[0]), tuple(ranges[1]))
        return cls((Patch(tuple(e.xreplace(named) for e in parts), pairs),), **placed)


def turn_about(axis: int, angle: sp.Expr) -> sp.Matrix:
    """The turn by an angle about one of three axes, 0 to 2."""
    ahead, aside = (axis + 1) % 3, (axis + 2) % 3
    turned = sp.eye(3)
    turned[ahead, ahead] = turned[aside, aside] = sp.cos(angle)
    turned[ahead, aside], turned[aside, ahead] = -sp.sin(angle), sp.sin(angle)
    return turned


def _three(values: Any, what: str) -> tuple[sp.Expr, ...]:
    """Three expressions, in a tuple or a matrix of SymPy's."""
    parts = several(values, what, "expression")
    if len(parts) != 3:
        raise DefinitionError(f"{what} has {len(parts)} components; give three")
    return tuple(as_expression(part, what) for part in parts)
