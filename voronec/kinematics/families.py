"""What families of systems share: constants with their usual words, declarations joined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.text import as_expression
from voronec.declaration.reading import expression, fixed_mapping
from voronec.declaration.scene import Parameter
from voronec.declaration.shapes import Shape
from voronec.declaration.system import System
from voronec.errors import DefinitionError, quote

Words = Mapping[sp.Expr, tuple[str, bool]]
"""Constant, or the number in its place -> what it is, and whether it is positive."""


FIXED_RADIUS = ("radius of the fixed sphere, signed", False)


def read_fields(owner: Any, names: Sequence[str], what: str) -> None:
    """Have fields of a frozen declaration read as expressions, or refused in one line."""
    for name in names:
        read = expression(getattr(owner, name), f"the {name} of {what}")
        object.__setattr__(owner, name, read)


def constants(values: Mapping[Any, Any], words: Words) -> tuple[Parameter, ...]:
    """The parameters of a table ``{symbol: value, (symbol, symbol): (value, value)}``, in order.

    ``words`` say what each of them is; a ``Parameter`` in the place of a value says it itself.
    """
    parameters: list[Parameter] = []
    for names, value in fixed_mapping(values, "values", "symbol: value").items():
        single = not isinstance(names, Sequence)
        symbols, numbers = ((names,), (value,)) if single else (names, tuple(value))
        if len(symbols) != len(numbers):
            raise DefinitionError(
                f"{', '.join(map(str, symbols))} have {len(numbers)} values; give one for each"
            )
        for symbol, number in zip(symbols, numbers, strict=True):
            parameters.append(_constant(symbol, number, words))
    return tuple(parameters)


def _constant(symbol: sp.Expr, value: Any, words: Words) -> Parameter:
    """One parameter, with what it is."""
    if isinstance(value, Parameter):
        return value
    if symbol not in words:
        known = ", ".join(str(s) for s in words if isinstance(s, sp.Symbol))
        raise DefinitionError(
            f"'{quote(symbol)}' is no constant of this body; it has {known}; others are given as "
            "Parameter(...)"
        )
    meaning, positive = words[symbol]
    return Parameter(symbol, value, positive=positive, meaning=meaning)


def moment_words(inertia: Sequence[Any]) -> Words:
    """What the principal moments are: of any body, of one with an axis, of a spherical one."""
    x, y, z = inertia
    if x == y == z:
        return {x: ("moment of inertia", True)}
    if x == y:
        return {x: ("equatorial moment of inertia", True), z: ("axial moment of inertia", True)}
    return dict.fromkeys(inertia, ("principal moment", True))


def rotor_words(rotor: Sequence[Any]) -> Words:
    """What the momentum of a gyroscope is, along any direction or along the third axis."""
    axial = not any(rotor[:2])
    words = "axial momentum of the gyroscope" if axial else "momentum of the gyroscope"
    return dict.fromkeys(rotor, (words, False))


def rolling_ratio(fixed: Any, radius: Any) -> sp.Expr:
    """epsilon = R1/(R1 + R2) of a ball on a sphere, and 1 on a plane, where ``fixed`` is None."""
    return sp.Integer(1) if fixed is None else as_expression(fixed / (fixed + radius))


def shapes_of_known(shapes: Sequence[Shape]) -> tuple[Shape, ...]:
    """``shapes``, or none where they hold unknown functions: those cannot be drawn."""
    exprs = [
        e for s in shapes for e in (*s.expressions, *(x for p in s.patches for x in p.position))
    ]
    return () if any(as_expression(e).has(AppliedUndef) for e in exprs) else tuple(shapes)


def join_declarations(own: Mapping[str, Any], more: Mapping[str, Any]) -> System:
    """The system of what a body declares by itself and of what is declared beside.

    Of mappings - claims, scenes, cases - entries are added, or take the place of those of the same
    name; anything else takes the place of what the body has.
    """
    both = dict(own)
    for name, value in more.items():
        old = both.get(name)
        maps = isinstance(old, Mapping) and isinstance(value, Mapping)
        both[name] = {**old, **value} if maps and isinstance(old, Mapping) else value
    integrals, meanings = both.get("integrals"), both.get("meanings", {})
    if isinstance(integrals, Mapping) and isinstance(meanings, Mapping):  # else refused below
        usual = (name for name in integrals if name in INTEGRALS and name not in meanings)
        both["meanings"] = {**{name: INTEGRALS[name] for name in usual}, **meanings}
    return System(**both)


INTEGRALS = {
    "momentum squared": "square of the angular momentum that is constant in space",
    "vertical momentum": "vertical part of the angular momentum about the contact",
    "axial": "momentum along the axis of symmetry, with what the rolling adds",
    "momentum across the normal": "square of the momentum's part across the normal",
    "momentum wedge momentum": "what the momentum's planes span together",
    "momentum wedge momentum squared": "square of what the momentum's planes span together",
    "momentum wedge momentum along the normal": "its part along the normal",
    "momentum of the normal squared": "square of G gamma",
}
"""What the integrals are that members of several families share."""
