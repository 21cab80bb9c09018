"""What a user hands in, read: expressions, numbers, tuples and mappings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.symbols import names_in, plain_name
from voronec.errors import DefinitionError

__all__ = ["expression", "mapping", "real_number", "require_known", "several", "shown", "vanishing"]

LONGEST = 60
"""How much of an object a message quotes."""

_NOT_REAL = (sp.I, sp.nan, sp.zoo, sp.oo, -sp.oo)


def shown(thing: Any) -> str:
    """An object as a message quotes it: on one line, and not too long."""
    text = " ".join(str(thing).split())
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def expression(thing: Any, place: str) -> sp.Expr:
    """A scalar, real SymPy expression; ``place`` says in messages what it is.

    Numbers, text and anything else that SymPy reads are accepted.
    """
    expr = _scalar(_sympified(thing, place), thing, place)
    for number in _NOT_REAL:
        if expr.has(number):
            mend = (
                "a quantity of that name is sympy.Symbol('I')" if number == sp.I else "correct it"
            )
            raise DefinitionError(
                f"{place} contains '{number}', which is not a real number; {mend}"
            )
    return expr


def vanishing(thing: Any, place: str) -> sp.Expr:
    """An expression that vanishes; ``sympy.Eq(left, right)`` is read as left - right."""
    read = _sympified(thing, place)
    if isinstance(read, sp.Equality):
        return expression(read.lhs - read.rhs, place)
    if isinstance(read, (sp.Rel, sp.logic.boolalg.Boolean)) and not isinstance(read, sp.Symbol):
        raise DefinitionError(
            f"{place} is '{shown(thing)}', not an expression that vanishes; "
            "write left - right, or sympy.Eq(left, right)"
        )
    return expression(read, place)


def real_number(value: Any, place: str) -> sp.Expr:
    """A finite real number as SymPy has it; ``DefinitionError`` where it is none."""
    try:
        number = sp.sympify(value)
    except Exception:  # SymPy evaluates text: anything may come out
        number = None
    fit = isinstance(number, sp.Expr) and number.is_number
    if not fit or number is sp.nan or number.is_real is False or number.is_finite is False:
        raise DefinitionError(f"{place} = {shown(value)} is not a real number; give a finite one")
    return number


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
        return tuple(things)
    raise DefinitionError(f"{place} = {shown(things)} is not a tuple; write {place}=({entry}, ...)")


def mapping(things: Any, place: str, entry: str) -> Mapping[Any, Any]:
    """A mapping that nobody can change; ``entry`` shows in messages what one holds."""
    if not isinstance(things, Mapping):
        raise DefinitionError(
            f"{place} = {shown(things)} is not a mapping; write {place}={{{entry}}} or leave it out"
        )
    return MappingProxyType(dict(things))


def require_known(place: str, expr: sp.Expr, known: set[sp.Expr]) -> None:
    """Refuse an expression that is not made of known symbols and of derivatives of these."""
    names = names_in(expr) - known
    unknown = sorted(str(n) for n in names if getattr(n, "expr", n) not in known)
    if unknown:
        hint = " (a different symbol of that name is declared: use one symbol object)"
        same = any(unknown[0] in (str(k), plain_name(k)) for k in known)
        raise DefinitionError(
            f"{place} contains '{unknown[0]}', which is neither coordinate, velocity nor "
            f"parameter; declare it in parameters=(...) or the fibration{hint if same else ''}"
        )


def _sympified(thing: Any, place: str) -> Any:
    try:
        return sp.sympify(thing)
    except Exception:  # SymPy evaluates text: anything may come out
        raise DefinitionError(
            f"{place} is '{shown(thing)}', which SymPy cannot read; write it with sympy symbols"
        ) from None


def _scalar(read: Any, thing: Any, place: str) -> sp.Expr:
    if isinstance(read, sp.Expr) and not isinstance(read, (sp.MatrixBase, sp.MatrixExpr)):
        return read
    raise DefinitionError(
        f"{place} is '{shown(thing)}' of kind {type(thing).__name__}; write one sympy expression"
    )
