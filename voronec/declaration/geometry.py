"""Fibrations and frames: which coordinates lie over which, and which velocities are used.

What forces are declared along velocities acts along the coordinates.  A force Q along a velocity w
= e_a qdot_a + e does the work Q w; on a virtual displacement e does none, so along the coordinate
q_a the force is Q e_a.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.arguments import takes_fields
from voronec.algebra.symbols import is_symbolic_name, names_in, plain_name, velocity
from voronec.algebra.text import formula
from voronec.declaration.reading import (
    expression,
    fixed_mapping,
    quote,
    several,
    vanishing_expression,
)
from voronec.errors import DefinitionError


@takes_fields
@dataclass(frozen=True)
class Fibration:
    """pi : Q -> B, (r, s) -> r: base coordinates r, fibre coordinates s [Theory, eq. (1)].

    The velocities of the base are free, those of the fibre are what the constraints determine.
    ``relations`` are expressions in the coordinates that vanish, for redundant coordinates (a
    quaternion, a Poisson vector); the motion stays on their zero set.  A single coordinate or
    relation may stand without a tuple.  Raises ``DefinitionError`` for what is no symbol, and for
    one that stands twice.
    """

    base: tuple[sp.Expr, ...]
    fibre: tuple[sp.Expr, ...] = ()
    relations: tuple[sp.Expr, ...] = ()

    def __post_init__(self) -> None:
        for part in ("base", "fibre"):
            object.__setattr__(self, part, _names(getattr(self, part), part))
        given = enumerate(several(self.relations, "relations", "expression"))
        relations = tuple(
            vanishing_expression(r, f"relation {i + 1} of the fibration") for i, r in given
        )
        object.__setattr__(self, "relations", relations)
        seen: set[str] = set()
        for name in map(plain_name, self.base + self.fibre):
            if name in seen:
                raise DefinitionError(
                    f"coordinate '{name}' is listed twice in the fibration; list it once"
                )
            seen.add(name)


@takes_fields
@dataclass(frozen=True)
class Frame:
    """Quasi-velocities v_i and their definitions, affine in the velocities.

    The frame of a group, ``Frame.group``, is known by ``brackets`` and ``rates`` instead; there
    the definitions are the velocities themselves, and ``fibre`` are those that the constraints
    determine.  Velocities ``beside`` the frame, with their definitions, follow from it by the last
    constraints; a run takes them along where the frame fails.
    """

    velocities: tuple[sp.Expr, ...]
    expressions: tuple[sp.Expr, ...]
    fibre: tuple[sp.Expr, ...] = ()
    brackets: Mapping[tuple[sp.Expr, sp.Expr], Mapping[sp.Expr, sp.Expr]] | None = None
    rates: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)
    momenta: tuple[sp.Expr, ...] = ()
    determinant: sp.Expr | None = None
    beside: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        velocities = _names(self.velocities, "frame")
        expressions = several(self.expressions, "expressions", "expression")
        if len(velocities) != len(expressions) or not velocities:
            raise DefinitionError(
                f"a frame has {len(velocities)} velocities and {len(expressions)} expressions; "
                "write Frame.quasi({velocity: expression})"
            )
        pairs = zip(velocities, expressions, strict=True)
        read = tuple(expression(e, f"the definition of '{plain_name(v)}'") for v, e in pairs)
        object.__setattr__(self, "velocities", velocities)
        object.__setattr__(self, "expressions", read)
        object.__setattr__(self, "fibre", _names(self.fibre, "frame"))
        beside = fixed_mapping(self.beside, "beside", "velocity: expression")
        names = _names(tuple(beside), "frame")
        known = {v: expression(beside[v], f"the definition of '{plain_name(v)}'") for v in names}
        object.__setattr__(self, "beside", MappingProxyType(known))
        object.__setattr__(self, "momenta", _names(self.momenta, "momenta of the frame"))
        if self.momenta and len(self.momenta) != len(velocities):
            raise DefinitionError(
                f"a frame has {len(velocities)} velocities and {len(self.momenta)} momenta; name "
                "one for each velocity, or none"
            )
        if self.determinant is not None:
            several_names = _names(self.determinant, "determinant of the frame")
            if len(several_names) != 1:
                raise DefinitionError(
                    f"the determinant of the frame is '{quote(self.determinant)}'; give one symbol"
                )
            object.__setattr__(self, "determinant", several_names[0])
        if self.brackets is not None:
            self._read_group()

    def _read_group(self) -> None:
        rates = fixed_mapping(self.rates, "rates", "coordinate: expression")
        read = {q: expression(e, f"the rate of '{quote(q)}'") for q, e in rates.items()}
        object.__setattr__(self, "rates", fixed_mapping(read, "rates", "coordinate: expression"))
        entry = "(a, b): {c: coefficient}"
        given, table, names = fixed_mapping(self.brackets, "brackets", entry), {}, set(self.ambient)
        for pair, parts in given.items():
            pairs = isinstance(pair, tuple) and len(pair) == 2 and isinstance(parts, Mapping)
            if not pairs or not {*pair, *parts} <= names:
                raise DefinitionError(
                    f"the bracket of '{quote(pair)}' is '{quote(parts)}'; write {entry} with "
                    "velocities of the frame"
                )
            if pair[0] == pair[1] or (pair[1], pair[0]) in given:
                raise DefinitionError(
                    f"the bracket of '{quote(pair)}' vanishes or is given twice; give one order "
                    "of each pair of different velocities"
                )
            place = f"the bracket of {pair}"
            table[pair] = MappingProxyType({c: expression(e, place) for c, e in parts.items()})
        object.__setattr__(self, "brackets", MappingProxyType(table))

    @property
    def is_group(self) -> bool:
        """Whether the frame is known by its brackets."""
        return self.brackets is not None

    @property
    def ambient(self) -> tuple[sp.Expr, ...]:
        """All velocities that the Lagrangian and the constraints of a group are written in."""
        return self.velocities + self.fibre

    @property
    def definitions(self) -> dict[sp.Expr, sp.Expr]:
        """What its velocities are, and those beside them."""
        return {**dict(zip(self.velocities, self.expressions, strict=True)), **self.beside}

    @property
    def claim_names(self) -> tuple[sp.Expr, ...]:
        """Names that claims may use: of the momenta, and of the determinant of the mass."""
        return self.momenta if self.determinant is None else (*self.momenta, self.determinant)

    @classmethod
    def quasi(
        cls, definitions: Mapping[Any, Any], beside: Mapping[Any, Any] | None = None
    ) -> Frame:
        """The frame whose quasi-velocities are defined by ``{v: expression, ...}``.

        Expressions are affine in any velocities, those of the fibre included; together with the
        constraints they must determine all velocities, else ``derive`` raises ``DefinitionError``.
        They may fail at places, as omega1 and omega2 do where (omega, gamma) = 0 and gamma3 = 0;
        where these velocities and others ``beside`` them, defined so too, are a frame everywhere
        without the last of the constraints, as many as there are others, runs pass such places.
        """
        if not isinstance(definitions, Mapping) or not definitions:
            raise DefinitionError("Frame.quasi takes a non-empty mapping {velocity: expression}")
        return cls(tuple(definitions), tuple(definitions.values()), beside=beside or {})

    @classmethod
    def group(
        cls,
        velocities: Any,
        brackets: Mapping[Any, Any],
        rates: Mapping[Any, Any] | None = None,
        fibre: Any = (),
        momenta: Any = (),
        determinant: Any = None,
    ) -> Frame:
        """The frame of a Lie group, or of any space on which fields X_a with constant brackets are
        a frame: no coordinates are needed but those that occur.

        velocities, fibre
            the components w_a of the motion along X_a, first those that stay independent, then
            those that the constraints determine; with them the Lagrangian and the constraints
            are written.
        brackets
            ``{(a, b): {c: C_ab^c}}``, the relations [X_a, X_b] = C_ab^c X_c for one order of each
            pair, zero where nothing is given; for the entries of the angular velocity in the
            body these are those of the matrices.  Coefficients may hold parameters.
        rates
            coordinate -> its rate, linear in the velocities w; all coordinates of the fibration.
        momenta
            names of dLc/dv, by which claims may speak of them: what is claimed so, is decided
            without inverting the mass matrix.
        determinant
            the same for measures: a name of the determinant of the mass matrix d2Lc/dv2.

        Raises ``DefinitionError`` for names that are none of the frame; so does ``derive`` where
        Jacobi's identity fails, or the rates do not obey the brackets, X_a X_b - X_b X_a.
        """
        names = _names(velocities, "frame")
        given = {} if rates is None else rates
        return cls(names, names, fibre, brackets, given, momenta, determinant)


def _names(things: Any, part: str) -> tuple[sp.Expr, ...]:
    """A tuple of symbols out of one symbol or several."""
    names = several(things, part, "symbol")
    for thing in names:
        if not is_symbolic_name(thing):
            raise DefinitionError(
                f"'{quote(thing)}' in the {part} is not a symbol; use sympy.Symbol"
            )
    return names


def moving_names(coordinates: Sequence[sp.Expr], frame: Frame | None) -> list[sp.Expr]:
    """All names for what changes with the motion: coordinates, their velocities, and those of the
    frame, of its fibre, its momenta and its determinant."""
    named = () if frame is None else (*frame.ambient, *frame.claim_names)
    return [*coordinates, *map(velocity, coordinates), *named]


def along_coordinates(
    forces: Mapping[Any, sp.Expr], coordinates: tuple[sp.Expr, ...], frame: Frame | None
) -> Mapping[Any, sp.Expr]:
    """Forces with those along velocities, quasi ones and expressions affine in velocities, spread
    over the coordinates; what is no velocity stays.  A text names what it stands for."""
    spelled = dict(zip(frame.velocities, frame.expressions, strict=True)) if frame else {}
    named = {plain_name(s): s for s in moving_names(coordinates, frame)}
    components: dict[Any, sp.Expr] = {}
    for key, force in forces.items():
        text = isinstance(key, str)
        direction = formula(key, "what a force acts along", named) if text else key
        shares = _shares(direction, coordinates, spelled)
        for q, share in (shares or {direction: sp.Integer(1)}).items():
            components[q] = components.get(q, sp.Integer(0)) + share * force
    return components


def _shares(
    direction: Any, coordinates: tuple[sp.Expr, ...], spelled: Mapping[sp.Expr, sp.Expr]
) -> dict[sp.Expr, sp.Expr]:
    """The coefficients of a velocity by coordinate; none where it is no velocity."""
    if direction in coordinates or not isinstance(direction, sp.Expr):
        return {}
    written = direction.xreplace(spelled)
    dots = {q: velocity(q) for q in coordinates}
    shares = {q: written.diff(dot) for q, dot in dots.items()}
    if any(names_in(share) & {*dots.values()} for share in shares.values()):
        return {}
    return {q: share for q, share in shares.items() if share != 0}
