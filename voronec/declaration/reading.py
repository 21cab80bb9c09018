"""What a user hands in, read: expressions, numbers, tuples and mappings."""

from __future__ import annotations

import copyreg
import re
from collections.abc import Iterable, Mapping, Set
from contextlib import suppress
from types import MappingProxyType
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from voronec.algebra.symbols import names_in, plain_name, velocity
from voronec.algebra.text import (
    NOT_REAL,
    as_expression,
    doubles_of_parts,
    exact_number,
    formula,
    in_doubles,
)
from voronec.errors import DefinitionError, quote

DIGITS = 1000
"""Digits of an exact time in a motion of many digits: its tolerance is a double, above 1e-324."""

DEEPEST = 900
"""Levels of an expression: SymPy goes down a level a call, of which Python allows 1000."""


def expression(thing: Any, place: str) -> sp.Expr:
    """A scalar, real SymPy expression; ``place`` says in messages what it is.

    Numbers are accepted, and text as ``algebra.text.formula`` reads it.
    """
    if isinstance(thing, sp.Symbol):
        return thing
    expr = _scalar(as_expression(thing, place), thing, place)
    try:
        held = doubles_of_parts(expr)
    except OverflowError:
        # printing an expression evaluates its numbers, so this one is not quoted
        raise DefinitionError(f"{place} holds a number beyond doubles; use another unit") from None
    levels: dict[Any, int] = {}
    for part in held:  # after its own parts
        levels[part] = 1 + max((levels[p] for p in part.args), default=0)
    if levels[expr] > DEEPEST:
        raise DefinitionError(
            f"{place} is nested too deeply to be read; give its parts names of their own, or write "
            "it shorter"
        )
    for number in NOT_REAL:
        if number in held:
            mend = (
                "a quantity of that name is sympy.Symbol('I')" if number == sp.I else "correct it"
            )
            raise DefinitionError(
                f"{place} contains '{number}', which is not a real number; {mend}"
            )
    return expr


def vanishing_expression(thing: Any, place: str) -> sp.Expr:
    """An expression that vanishes; ``sympy.Eq(left, right)``, and ``left = right`` in text, are
    read as left - right."""
    sides = re.split("==?", thing) if isinstance(thing, str) else ()
    if len(sides) == 2:
        left, right = (expression(side, place) for side in sides)
        return left - right
    read = as_expression(thing, place)
    if isinstance(read, sp.Equality):
        return expression(read.lhs - read.rhs, place)
    if isinstance(read, (sp.Rel, sp.logic.boolalg.Boolean)) and not isinstance(read, sp.Symbol):
        raise DefinitionError(
            f"{place} is '{quote(thing)}', not an expression that vanishes; "
            "write left - right, or sympy.Eq(left, right)"
        )
    return expression(read, place)


def real_number(value: Any, place: str) -> sp.Expr:
    """A finite real number as SymPy has it; ``DefinitionError`` where it is none."""
    if isinstance(value, str):
        return real_text(value, place)
    try:
        number = as_expression(value)
        in_doubles(number)  # what overflows them could be too long to be computed
    except DefinitionError:
        number = None
    except OverflowError:
        raise DefinitionError(
            f"{place} = {quote_number(value)} is not a real number that a double holds"
        ) from None
    fit = isinstance(number, sp.Expr) and number.is_number
    if not fit or number is sp.nan or number.is_real is False or number.is_finite is False:
        raise DefinitionError(f"{place} = {quote(value)} is not a real number; give a finite one")
    return number


def quote_number(value: Any) -> str:
    """A number beyond doubles as a message quotes it: SymPy would evaluate it to print it."""
    return "a formula" if isinstance(value, sp.Basic) and value.args else quote(value)


def real_text(text: str, place: str) -> sp.Expr:
    """The real number that a text means, exactly."""
    try:
        return exact_number(text, place)
    except DefinitionError as error:
        why = str(error).removeprefix(f"{place}: ")
        raise DefinitionError(f"{place} = {quote(text)} is not a real number: {why}") from None


def doubles(things: Any, place: str) -> np.ndarray:
    """Numbers as an array of doubles, of whatever shape; a copy."""
    try:
        given = np.array(things)
        if given.dtype.kind in "fiub":
            return given.astype(float)
        if given.dtype.kind in "OU":
            flat = [float(real_number(thing, place)) for thing in given.ravel().tolist()]
            return np.array(flat).reshape(given.shape)
    except (TypeError, ValueError, OverflowError, RuntimeError, AttributeError):
        pass
    kind = getattr(getattr(things, "dtype", None), "name", type(things).__name__)
    raise DefinitionError(
        f"{place} = {quote(things)} of kind {kind} are no numbers; give some, as [0, 0.5, 1]"
    )


def instants(things: Any, place: str, wide: bool = False) -> np.ndarray:
    """Times as doubles; in a ``wide`` motion, of mpmath's numbers, none of their digits is lost."""
    try:
        given = np.array(things)
    except (TypeError, ValueError, OverflowError, RuntimeError, AttributeError):
        given = np.empty(0)
    if not wide or given.dtype.kind not in "OU":
        return doubles(things, place)
    times = np.empty(given.shape, dtype=object)
    for i, thing in np.ndenumerate(given):
        exact = real_number(thing, place)
        times[i] = thing if isinstance(thing, mpmath.mpf) else _with_digits(exact)
    return times


def _with_digits(number: sp.Expr) -> mpmath.mpf:
    """A number with more digits than any motion has been asked for."""
    return mpmath.mp.make_mpf(sp.Float(number.evalf(DIGITS), DIGITS)._mpf_)


def several(
    things: Any, place: str, entry: str, kind: type | tuple[type, ...] = ()
) -> tuple[Any, ...]:
    """Several things in order; a single text, expression or ``kind`` stands for a tuple of it.

    ``entry`` shows in messages what one of them looks like.
    """
    if isinstance(things, sp.MatrixBase):
        return tuple(things)
    many = isinstance(things, (sp.Tuple, sp.NDimArray))
    if (isinstance(things, (str, sp.Basic)) and not many) or isinstance(things, kind):
        return (things,)
    if isinstance(things, Iterable) and not isinstance(things, (Mapping, set, frozenset)):
        with suppress(TypeError):  # an array of no dimension
            return tuple(things)
    raise DefinitionError(f"{place} = {quote(things)} is not a tuple; write {place}=({entry}, ...)")


def fixed_mapping(things: Any, place: str, entry: str) -> Mapping[Any, Any]:
    """A mapping that nobody can change; ``entry`` shows in messages what one holds."""
    if not isinstance(things, Mapping):
        raise DefinitionError(
            f"{place} = {quote(things)} is not a mapping; write {place}={{{entry}}} or leave it out"
        )
    return MappingProxyType(dict(things))


def _freeze(things: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(things)


# read-only mappings are what declarations and results are made of, and Python pickles none
copyreg.pickle(MappingProxyType, lambda things: (_freeze, (dict(things),)))


def texts_read(things: Mapping[Any, Any], role: str) -> Mapping[Any, Any]:
    """A mapping whose values are no text any more; ``role`` says in messages what they are."""
    if not any(isinstance(value, str) for value in things.values()):
        return things
    return {
        key: formula(value, f"{role} '{quote(key)}'") if isinstance(value, str) else value
        for key, value in things.items()
    }


def require_known(
    place: str, expr: sp.Expr, known: Set[sp.Expr], inputs: Set[sp.Expr] = frozenset()
) -> None:
    """Refuse an expression that is not made of known symbols, and of derivatives of ``inputs``."""
    known = known | {velocity(velocity(u)) for u in inputs if isinstance(u, sp.Symbol)}
    names = {n for n in names_in(expr) - known if getattr(n, "expr", n) not in inputs}
    unknown = sorted(names, key=str)
    if not unknown:
        return
    first = unknown[0]
    if isinstance(first, sp.Derivative) and first.expr in known:
        raise DefinitionError(f"{place} contains {_derivative_hint(first)}")
    dots = {velocity(x) for x in known if isinstance(x, sp.Symbol)}
    accelerations = {velocity(x) for x in dots & known}
    if first in accelerations | {velocity(x) for x in accelerations}:
        raise DefinitionError(f"{place} contains '{first}', {NO_VELOCITY}")
    raise DefinitionError(
        f"{place} contains '{first}', which is neither coordinate, velocity nor parameter; declare "
        f"it in parameters=(...), inputs=(...) or the fibration{namesake_hint(first, known)}"
    )


def namesake_hint(unknown: sp.Expr, known: Iterable[sp.Expr]) -> str:
    """That a known symbol has the name of an unknown one, as q1(t) has that of q1; else empty."""
    if all(str(unknown) not in (str(k), plain_name(k)) for k in known):
        return ""
    return " (a different symbol of that name is declared: use one symbol object)"


def _derivative_hint(derivative: sp.Derivative) -> str:
    """What a derivative of something known is called, and what to do about it."""
    if isinstance(derivative.expr, sp.Symbol):
        return (
            f"'{derivative}', the derivative of a plain symbol, which vanishes; write "
            f"voronec.velocity({derivative.expr})"
        )
    return f"'{derivative}', {NO_VELOCITY}"


NO_VELOCITY = (
    "which is no velocity: only forces may hold accelerations, and no higher derivative; write it "
    "out with the equations of motion, or as part of the Lagrangian"
)


def _scalar(read: Any, thing: Any, place: str) -> sp.Expr:
    if isinstance(read, sp.Expr) and not isinstance(read, (sp.MatrixBase, sp.MatrixExpr)):
        return read
    raise DefinitionError(
        f"{place} is '{quote(thing)}' of kind {type(thing).__name__}; write one sympy expression"
    )
