"""The bridge: SymPy expressions in, symengine expressions inside, SymPy expressions out.

Inside, every coordinate, velocity and parameter is a plain symengine symbol that bears the
user's name; so ``dynamicsymbols`` stay outside and come back on the way out.  What SymPy knows of
a symbol, its sign above all, stands in ``hypotheses``, which go along with what is to be decided.
Decimal numbers are read as the decimals they were written as: ``9.81`` is ``981/100``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import reduce
from math import isfinite
from typing import Any

import symengine as se
import sympy as sp
from symengine.lib.symengine_wrapper import BooleanAtom
from sympy.core.function import AppliedUndef

from voronec.algebra.graphs import derivative_at, nodes
from voronec.algebra.memo import remember
from voronec.algebra.piecewise_functions import written_with_signs
from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.terms import factors_of, is_fraction
from voronec.algebra.text import as_expression, quote
from voronec.errors import DefinitionError, EngineLimit


class UnknownFunction(DefinitionError):
    """A function that has a meaning, and none in the engine."""


class NoValue(DefinitionError):
    """What is infinite or undefined wherever its symbols are."""


_FUNCTIONS = {
    name: getattr(se, name)
    for name in (
        "sin cos tan cot sec csc asin acos atan acot sinh cosh tanh coth asinh acosh atanh "
        "log floor atan2"
    ).split()
}
_RECIPROCALS = {"sech": se.cosh, "csch": se.sinh}
_OF_RECIPROCALS = {
    "asec": se.acos, "acsc": se.asin, "asech": se.acosh, "acsch": se.asinh, "acoth": se.atanh
}  # fmt: skip
"""Functions that are 1/f(x), and those that are f(1/x)."""
_NUMBERS = {
    sp.pi: se.pi,
    sp.E: se.E,
    sp.I: se.I,
    sp.GoldenRatio: (1 + se.sqrt(se.Integer(5))) / 2,
}
_PARTS = (sp.re, sp.im, sp.conjugate)
"""What ``sympy.diff`` makes of |x|, where x is any symbol; here it is real."""
RATES = 4
"""Inputs occur with derivatives below this order: the rate of one in a Lagrangian is the least that
anybody writes, and the equations differentiate twice."""


_NO_VALUES = (se.zoo, se.nan, se.oo)


class SymPyBridge:
    """Translates between a user's SymPy symbols and the plain symbols inside.

    ``known`` are the user's coordinates, velocities and parameters, each a symbol, ``x(t)`` or a
    derivative of it.  Two of one name raise ``DefinitionError``.  ``inputs`` are functions of the
    time inside, even where they are plain symbols outside.
    """

    def __init__(self, known: Iterable[sp.Expr] = (), inputs: Iterable[sp.Expr] = ()) -> None:
        self._inward: dict[sp.Basic, Any] = {}
        self._outward: dict[Any, sp.Basic] = {}
        self._names: dict[str, sp.Basic] = {}
        for thing in known:
            self.admit(thing)
        for thing in inputs:
            if isinstance(thing, sp.Symbol):
                self._drive(thing)

    def _drive(self, thing: sp.Symbol) -> None:
        """Make a symbol a function of the time, and the symbols of its rates the derivatives: what
        is derived and goes out has to come in again as the same."""
        outside, inside = thing, se.Function(thing.name)(se.Symbol(time.name))
        for order in range(RATES):
            if order > 1 and plain_name(outside) in self._names:  # somebody's own
                break
            self._names[plain_name(outside)] = outside
            self._inward[outside], self._outward[inside] = inside, outside
            outside, inside = velocity(outside), inside.diff(time.name)

    def __contains__(self, thing: sp.Expr) -> bool:
        """Whether something was made known, or has come in since."""
        return thing in self._inward

    def admit(self, thing: sp.Expr) -> Any:
        """Make ``thing`` known and return its symbol inside."""
        if thing in self._inward:
            return self._inward[thing]
        name = plain_name(thing)
        other = self._names.get(name)
        if other is not None and other != thing:
            raise DefinitionError(
                f"two different symbols are named '{name}' ({sp.srepr(other)} and "
                f"{sp.srepr(thing)}); use one symbol, or rename one of them"
            )
        symbol = se.Symbol(name)
        self._names[name] = thing
        self._inward[thing] = symbol
        self._outward[symbol] = thing
        return symbol

    def inward(self, expr: Any) -> Any:
        """The symengine expression of a SymPy expression (or number)."""
        try:
            inside = self._enter(as_expression(expr))
        except RecursionError:
            raise DefinitionError("an expression is nested too deeply to be read") from None
        except (RuntimeError, ZeroDivisionError) as error:  # symengine's word for a bad value
            raise NoValue(f"'{expr}' has no value: {quote(error)}") from None
        if any(map(inside.has, _NO_VALUES)):
            raise NoValue(f"'{quote(expr)}' has no value: it is infinite or undefined")
        return inside

    def inward_all(self, exprs: Iterable[Any]) -> list[Any]:
        """``inward`` for each of several expressions."""
        return [self.inward(expr) for expr in exprs]

    @remember("_inward")
    def _enter(self, expr: Any) -> Any:
        """One node of an expression in symengine, its arguments brought in before it."""
        if isinstance(expr, sp.Symbol):
            return self.admit(expr)
        if isinstance(expr, sp.Rational):
            return se.Integer(int(expr.p)) / se.Integer(int(expr.q))
        if isinstance(expr, sp.Float):
            double = float(expr) if expr._prec == 53 else 0.0
            fits = double != 0.0 and isfinite(double)
            exact = sp.Rational(repr(double) if fits else str(expr))  # the decimal as written
            return se.Integer(int(exact.p)) / se.Integer(int(exact.q))
        if expr in _NUMBERS:
            return _NUMBERS[expr]
        if isinstance(expr, sp.Add):
            return se.Add(*[self._enter(a) for a in expr.args])
        if isinstance(expr, sp.Mul):
            return se.Mul(*[self._enter(a) for a in expr.args])
        if isinstance(expr, sp.Pow):
            return self._enter(expr.base) ** self._enter(expr.exp)
        if isinstance(expr, sp.exp):
            return se.exp(self._enter(expr.exp))
        if isinstance(expr, AppliedUndef):
            function = se.Function(str(expr.func.__name__))
            inside = function(*[self._enter(a) for a in expr.args])
            if expr.func._kwargs:  # assumptions, with which it goes out again
                self._outward.setdefault(inside, expr)
            return inside
        if isinstance(expr, sp.Derivative):
            return self._derivative(expr)
        if isinstance(expr, sp.Subs):
            _refuse_torn(expr)
            return self._substitution(expr.expr, expr.variables, expr.point)
        if isinstance(expr, sp.Abs):  # as a root it is differentiated and reduced
            return _size(self._enter(expr.args[0]))
        if isinstance(expr, sp.sign):
            return _sign(self._enter(expr.args[0]))
        if isinstance(expr, _PARTS) and _is_real(expr.args[0]):
            return se.Integer(0) if isinstance(expr, sp.im) else self._enter(expr.args[0])
        if isinstance(expr, sp.sinc):
            return se.sin(self._enter(expr.args[0])) / self._enter(expr.args[0])
        return self._function(expr)

    def _function(self, expr: Any) -> Any:
        """A function by its name; others as they are written with signs, or refused."""
        name = type(expr).__name__
        if name in _FUNCTIONS:
            return _FUNCTIONS[name](*[self._enter(a) for a in expr.args])
        if name in _RECIPROCALS:
            return 1 / _RECIPROCALS[name](self._enter(expr.args[0]))
        if name in _OF_RECIPROCALS:
            return _OF_RECIPROCALS[name](1 / self._enter(expr.args[0]))
        pieces = written_with_signs(expr)
        if pieces is None and isinstance(expr, sp.Function) and expr.doit() != expr:
            pieces = expr.doit()  # a curve with a formula, as of muscles
        if pieces is not None:
            return self._enter(pieces)
        raise UnknownFunction(
            f"'{expr}' is of kind {name}, which the engine does not differentiate; "
            "write it with elementary functions or an unknown function"
        )

    def _derivative(self, expr: sp.Derivative) -> Any:
        """A derivative that is a symbol here, or one of an unknown function; any other is carried
        out by SymPy, or refused: symbols inside know nothing of the time."""
        operand = self._inward.get(expr.expr, expr.expr)
        if time in expr.variables and isinstance(operand, sp.Symbol | se.Symbol):
            raise DefinitionError(f"the derivative '{expr}' {_mend(expr)}")
        if (
            not isinstance(expr.expr, AppliedUndef)
            and (derivative := self._of_real(expr)) is not None
        ):
            return derivative
        meant = expr if _is_plain(expr) else expr.doit()
        if meant != expr:
            return self._enter(meant)
        if not isinstance(expr.expr, AppliedUndef):
            raise DefinitionError(
                f"the derivative '{expr}' is not carried out; write it out, or use an unknown "
                "function"
            )
        by = [v for v in expr.variables if not isinstance(self._enter(v), se.Symbol)]
        if by:  # f'(g(x)), written as the derivative by g(x)
            return self._substitution(expr, by, by)
        inner = self._enter(expr.expr)
        for variable, count in expr.variable_count:
            inner = inner.diff(self._enter(variable), int(count))
        return inner

    def _of_real(self, expr: sp.Derivative) -> Any:
        """A derivative by symbols, taken inside, where all are real: SymPy makes real and imaginary
        parts of |x|.  None by the time, and of functions that the engine does not have."""
        by = [(self._enter(v), int(n)) for v, n in expr.variable_count if v != time]
        if len(by) < len(expr.variable_count) or any(not isinstance(v, se.Symbol) for v, _ in by):
            return None
        try:
            return reduce(lambda slope, one: slope.diff(*one), by, self._enter(expr.expr))
        except UnknownFunction:
            return None

    def _substitution(self, expr: sp.Expr, variables: Sequence[Any], points: Sequence[Any]) -> Any:
        """An expression at points; its bound variables are nobody's symbols."""
        bound = [sp.Symbol(f"bound variable {i + 1}") for i in range(len(variables))]
        for symbol in bound:
            self._inward.setdefault(symbol, se.Symbol(symbol.name))
        renamed = expr.xreplace(dict(zip(variables, bound, strict=True)))
        at = {self._inward[b]: self._enter(p) for b, p in zip(bound, points, strict=True)}
        inner = self._enter(renamed)
        taken = {d: derivative_at(d, at) for d in inner.atoms(se.Derivative)}
        return inner.xreplace(taken).xreplace(at)

    def lost_conditions(self, expr: sp.Expr) -> list[Any]:
        """What an expression needs to be real, as it is written, where nothing inside tells it any
        more: sqrt(x)*sqrt(x), as SymPy may be told to keep it, is x inside."""
        parts: dict[Any, None] = {}  # each once, however often it stands in the expression
        ahead = [expr]
        while ahead:
            part = ahead.pop()
            if isinstance(part, sp.Piecewise | sp.Derivative | sp.Subs):
                return []  # a piece need not be real where it is not taken
            if part not in parts:
                parts[part] = None
                ahead += reversed(part.args)
        kept = {*nodes([self._enter(expr)])}
        lost = (n for n in parts if self._enter(n) not in kept or self._is_other(n))
        needed = (_real_where(n, self._enter) for n in lost)
        return [c for c in needed if c is not None and not isinstance(c, BooleanAtom)]

    def _is_other(self, node: sp.Expr) -> bool:
        """Whether an angle became something else: atan2(u, u) has a value where u = 0 then."""
        return isinstance(node, sp.atan2) and not isinstance(self._enter(node), se.atan2)

    @property
    def hypotheses(self) -> list[Any]:
        """What SymPy knows of the symbols and functions that have come in, on their symbols inside.

        One that is not real is an error.
        """
        known: list[Any] = []
        for thing, inside in self._inward.items():
            if isinstance(thing, sp.Symbol | AppliedUndef):
                known += _known_of(thing, inside)
        return known

    def outward(self, expr: Any) -> sp.Expr:
        """The SymPy expression, in the user's symbols, of a symengine expression."""
        return self._leave(se.sympify(expr))

    def outward_matrix(self, rows: Sequence[Sequence[Any]]) -> sp.ImmutableMatrix:
        """The SymPy matrix of nested sequences of symengine expressions."""
        entries = [self.outward(entry) for row in rows for entry in row]
        return sp.ImmutableMatrix(len(rows), len(rows[0]) if rows else 0, entries)

    @remember("_outward")
    def _leave(self, expr: Any) -> Any:
        if not expr.args:
            if isinstance(expr, se.Symbol):
                return sp.Symbol(expr.name)
            return expr._sympy_()
        if isinstance(expr, se.Subs):
            return expr._sympy_().xreplace(self._user_atoms())
        args = [self._leave(a) for a in expr.args]
        if isinstance(expr, se.Add):
            return sp.Add(*args)
        if isinstance(expr, se.Mul):
            return sp.Mul(*args)
        if isinstance(expr, se.Pow):
            return sp.Pow(*args)
        if isinstance(expr, se.Derivative):
            rates = len(args) - 1
            if isinstance(args[0], sp.Symbol):  # of an input
                return sp.Symbol(args[0].name + "dot" * rates)
            return sp.Derivative(*args)
        if isinstance(expr, se.FunctionSymbol):
            return sp.Function(expr.get_name())(*args)
        return getattr(sp, type(expr).__name__)(*args)

    def _user_atoms(self) -> dict[sp.Basic, sp.Basic]:
        return {sp.Symbol(name): thing for name, thing in self._names.items()}


def _size(inner: Any) -> Any:
    """The root of a square; even roots in a product, not negative, stay what they are: the square
    would be real where they are not."""
    factors = factors_of(inner)
    roots = [f for f in factors if isinstance(f, se.Pow) and _is_even_root(f.args[1])]
    rest = se.Mul(*[f for f in factors if f not in roots])
    return se.Mul(*roots, se.sqrt(rest**2))


def _sign(inner: Any) -> Any:
    """The sign of a number; of a power that of its base, since symengine recurses without end over
    sign((-x)**n)."""
    if not isinstance(inner, se.Pow) or inner.args[0] == se.E:
        return se.sign(inner)
    base, exponent = inner.args
    if is_fraction(exponent):
        return _sign(base) if exponent > 0 else 1 / _sign(base)
    return _sign(base) ** exponent


def _is_real(expr: sp.Expr) -> bool:
    """Whether an expression is real wherever its symbols are."""
    if isinstance(expr, sp.Symbol | AppliedUndef | sp.Rational):
        return True
    whole = isinstance(expr, sp.Pow) and expr.exp.is_Integer
    kinds = sp.Add | sp.Mul | sp.sin | sp.cos | sp.exp | sp.Abs | sp.sign
    return (whole or isinstance(expr, kinds)) and all(map(_is_real, expr.args))


def _is_even_root(exponent: Any) -> bool:
    return isinstance(exponent, se.Rational) and int(exponent.q) % 2 == 0


def _is_plain(derivative: sp.Derivative) -> bool:
    """Whether SymPy has nothing to do: an unknown function of symbols, differentiated by some of
    them.  It takes long to find that out."""
    of = derivative.expr
    return (
        isinstance(of, AppliedUndef)
        and all(isinstance(a, sp.Symbol) for a in of.args)
        and {*derivative.variables} <= {*of.args}
        and len({*of.args}) == len(of.args)
    )


def _mend(derivative: sp.Derivative) -> str:
    """Why the derivative of a symbol is refused, and what to write."""
    if isinstance(derivative.expr, sp.Symbol):
        return f"of a plain symbol is no velocity; write voronec.velocity({derivative.expr})"
    return "stands for nothing here (accelerations stand in forces only); write it out"


def _refuse_torn(expr: sp.Subs) -> None:
    """A function of the time cannot be replaced where its derivatives stay behind."""
    replaced = [v for v in expr.variables if not isinstance(v, sp.Symbol)]
    for inner in expr.expr.atoms(sp.Derivative):
        if any(inner.expr.has(v) and v not in inner.variables for v in replaced):
            raise DefinitionError(
                f"'{expr}' replaces a function under its derivative '{inner}'; carry the "
                "substitution out"
            )


def _real_where(node: Any, enter: Callable[[Any], Any]) -> Any:
    """The condition inside under which a root or a logarithm is real, or an angle is one of a point
    beside the origin; None for anything else."""
    if isinstance(node, sp.log):
        return enter(node.args[0]) > 0
    if isinstance(node, sp.Pow) and node.exp.is_Rational and not node.exp.is_Integer:
        base = enter(node.base)
        return base > 0 if node.exp < 0 else base >= 0
    if isinstance(node, sp.atan2):
        return enter(node.args[0]) ** 2 + enter(node.args[1]) ** 2 > 0
    return 1 - enter(node.args[0]) ** 2 >= 0 if isinstance(node, sp.asin | sp.acos) else None


def _known_of(thing: sp.Expr, inside: Any) -> Iterator[Any]:
    """What SymPy knows of a symbol or a function, as hypotheses on what it is inside."""
    assumptions = thing.assumptions0 if isinstance(thing, sp.Symbol) else thing.func._kwargs
    if not assumptions.keys() - {"commutative"}:
        return  # to ask one by one takes as long as a small derivation
    if thing.is_real is False:
        raise DefinitionError(f"'{thing}' is not real; equalities are between real numbers")
    if thing.is_prime or thing.is_composite or thing.is_integer is False:
        raise EngineLimit(f"what is declared of '{thing}' is beyond signs and whole numbers")
    if thing.is_zero:
        yield inside
    elif thing.is_positive:
        yield inside > 0
    elif thing.is_negative:
        yield inside < 0
    else:
        if thing.is_nonnegative:
            yield inside >= 0
        if thing.is_nonpositive:
            yield inside <= 0
        if thing.is_nonzero:
            yield se.Ne(inside, 0)
    if thing.is_integer:
        shift = 1 if thing.is_odd else 0
        step = 2 if thing.is_odd or thing.is_even else 1
        whole = (inside + shift) / step
        yield se.Eq(se.floor(whole), whole)
