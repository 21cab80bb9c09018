"""SymPy expressions as the referee reads them, on a way of its own.

Whatever has a name - a coordinate, its velocity, its acceleration, a parameter, an input and its
rates - is replaced in SymPy's tree by a plain symbol, and the rest goes through symengine's own
reader: nothing is shared with ``voronec.algebra.sympy_bridge``.  What is then left of functions of
the time, or that symengine does not know, is refused.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mpmath as mp
import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.declaration.system import System
from voronec.errors import DefinitionError

ORDERS = 4
"""Derivatives of an input that may occur: its rate in L, and what the equations make of it."""


def _inverse(x: sp.Expr) -> sp.Expr:
    return 1 / x


_RECIPROCALS = {
    sp.sech: (_inverse, sp.cosh), sp.csch: (_inverse, sp.sinh), sp.asec: (sp.acos, _inverse),
    sp.acsc: (sp.asin, _inverse), sp.asech: (sp.acosh, _inverse), sp.acsch: (sp.asinh, _inverse),
    sp.acoth: (sp.atanh, _inverse),
}  # fmt: skip
"""What is written by the functions that are evaluated: f(g(x))."""
_UNREAL = "has no real value; write it with elementary functions"
_CASES = (sp.Heaviside, sp.Max, sp.Min)
"""What SymPy writes out in cases."""


@dataclass(frozen=True)
class Names:
    """The plain symbols of a system's things, by the names under which values are given."""

    system: System

    @cached_property
    def letters(self) -> dict[sp.Basic, sp.Symbol]:
        """What stands in a user's expressions -> a symbol without assumptions."""
        return {thing: sp.Symbol(name) for thing, name in self._pairs()}

    def _pairs(self) -> Iterator[tuple[sp.Basic, str]]:
        system = self.system
        for thing in (*(p.symbol for p in system.parameters), time):
            yield thing, plain_name(thing)
        for q in system.coordinates:
            yield q, plain_name(q)
            yield velocity(q), plain_name(q) + "dot"
        for v in system.frame.ambient if system.frame is not None else ():
            yield v, plain_name(v)
        for a in system.accelerations:
            yield a, f"acceleration {plain_name(a)}"
        for u in system.inputs:
            for order, name in enumerate(rate_names(u)):
                yield (u if order == 0 else _rate(u, order)), name

    def read(self, expr: sp.Expr) -> Any:
        """The symengine expression of a user's expression."""
        exact = expr.xreplace({x: _decimal(x) for x in expr.atoms(sp.Float)})
        named = self._carry_out(exact).xreplace(self.letters)
        named = named.replace(sp.sinc, lambda a: sp.sin(a) / a)
        try:
            parsed = se.sympify(_in_cases(named))
        except se.SympifyError:
            raise DefinitionError(f"'{expr}' {_UNREAL}") from None
        for function in sorted(parsed.atoms(se.FunctionSymbol), key=str):
            if type(function) is not se.FunctionSymbol:  # SymPy's own, without a derivative here
                raise DefinitionError(f"'{function}' {_UNREAL}")
            raise DefinitionError(
                f"the unknown function '{function}' has no value; numeric evaluation needs a "
                "formula for it"
            )
        return parsed

    def symbol(self, thing: sp.Basic) -> Any:
        """The symbol of something that has a name."""
        return se.Symbol(self.letters[thing].name)

    @property
    def inputs(self) -> list[list[Any]]:
        """Of each input its symbol and those of its rates, in order."""
        return [[se.Symbol(name) for name in rate_names(u)] for u in self.system.inputs]

    def _carry_out(self, expr: sp.Expr) -> sp.Expr:
        """Partial derivatives that SymPy can take are taken; rates of things are left alone."""
        nodes = [d for d in expr.atoms(sp.Derivative) if time not in d.variables]
        return expr.xreplace({d: d.doit() for d in nodes}) if nodes else expr


def rate_names(thing: sp.Expr) -> list[str]:
    """The names of an input and of its rates."""
    return [plain_name(thing) + "dot" * order for order in range(ORDERS)]


def _in_cases(expr: sp.Expr) -> sp.Expr:
    """The expression with cases and floors for steps, limits and remainders."""
    expr = expr.replace(lambda e: isinstance(e, sp.Mod), lambda e: _remainder(*e.args))
    expr = expr.replace(lambda e: isinstance(e, (sp.frac, sp.ceiling)), _floor)
    for kind, (outer, inner) in _RECIPROCALS.items():
        expr = expr.replace(kind, lambda x, f=outer, g=inner: f(g(x)))
    expr = expr.replace(lambda e: isinstance(e, _CASES), lambda e: e.rewrite(sp.Piecewise))
    return expr.replace(lambda e: isinstance(e, sp.ITE), lambda e: e.to_nnf())


def _remainder(a: sp.Expr, b: sp.Expr) -> sp.Expr:
    return a - b * sp.floor(a / b)


def _floor(expr: sp.Expr) -> sp.Expr:
    (a,) = expr.args
    return a - sp.floor(a) if isinstance(expr, sp.frac) else -sp.floor(-a)


def _rate(thing: sp.Expr, order: int) -> sp.Basic:
    if isinstance(thing, sp.Symbol):
        return sp.Symbol(thing.name + "dot" * order)
    return sp.Derivative(thing, (time, order))


def _decimal(number: sp.Float) -> sp.Rational:
    """A decimal as it was written, in as many digits as it has."""
    double = float(number) if number._prec == 53 else mp.nan
    return sp.Rational(repr(double) if double and mp.isfinite(double) else str(number))
