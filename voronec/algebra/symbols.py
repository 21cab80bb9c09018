"""Names of things a user hands in: the time, the velocity symbol of a coordinate."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.terms import subexpressions
from voronec.errors import DefinitionError, quote

time = sp.Symbol("t")
"""The time ``t``; also the argument of ``sympy.physics.mechanics.dynamicsymbols``."""


def is_symbolic_name(thing: Any) -> bool:
    """Whether ``thing`` can name a coordinate, velocity or parameter: a symbol or ``x(t)``."""
    return isinstance(thing, sp.Symbol) or (
        isinstance(thing, AppliedUndef) and thing.args == (time,)
    )


def plain_name(thing: sp.Expr | str) -> str:
    """The bare name of a symbol, of ``x(t)``, or of ``Derivative(x(t), t)`` (``xdot``).

    A text is a name already.
    """
    if isinstance(thing, str):
        return thing
    if isinstance(thing, sp.Symbol):
        return str(thing.name)
    if isinstance(thing, AppliedUndef):
        return str(thing.func.__name__)
    if isinstance(thing, sp.Derivative):
        return plain_name(thing.expr) + "dot" * len(thing.variables)
    raise DefinitionError(f"'{quote(thing)}' is not a symbol; name coordinates by symbols")


def unused_name(name: str, taken: Container[str]) -> str:
    """A name, with as many underscores behind it as it takes to be none of those that are taken."""
    while name in taken:
        name += "_"
    return name


def velocity(coordinate: sp.Expr) -> sp.Expr:
    """The velocity symbol of a coordinate: ``x`` gives ``xdot``, ``x(t)`` gives its derivative.

    Applied to a velocity it gives the second derivative, and so on.  ``DefinitionError`` for what
    is no symbol.
    """
    if isinstance(coordinate, AppliedUndef) and coordinate.args == (time,):
        # what diff returns, without the tens of questions that it asks first
        return sp.Expr.__new__(sp.Derivative, coordinate, sp.Tuple(time, sp.S.One))
    if isinstance(coordinate, (AppliedUndef, sp.Derivative)):
        function = coordinate.args[0]
        if coordinate.args[1:] == ((time, sp.S.One),) and isinstance(function, AppliedUndef):
            return sp.Expr.__new__(sp.Derivative, function, sp.Tuple(time, sp.Integer(2)))
        return coordinate.diff(time)
    return sp.Symbol(plain_name(coordinate) + "dot")


def functions_of_time(expr: Any) -> set[sp.Expr]:
    """The undefined functions x(t) in an expression, those under derivatives among them."""
    parts = subexpressions([expr])
    return {f for f in parts if isinstance(f, AppliedUndef) and f.args == (time,)}


def names_in(expr: Any) -> set[sp.Expr]:
    """The symbols, functions of time and their derivatives that occur in an expression."""
    names: set[sp.Expr] = set()
    for node in subexpressions([expr], lambda part: _is_name(part) or isinstance(part, sp.Subs)):
        if _is_name(node):
            names.add(node)
        elif isinstance(node, sp.Subs):
            inner = (*node.point, *(node.expr.free_symbols - set(node.variables)))
            names = names.union(*map(names_in, inner))
    return names


def _is_name(node: Any) -> bool:
    """Whether a part is a name, or the derivative of one by the time."""
    return is_symbolic_name(node) or (
        isinstance(node, sp.Derivative) and set(node.variables) == {time}
    )
