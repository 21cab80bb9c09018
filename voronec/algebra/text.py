"""Formulas written as text, read without running them.

    sum     = product (("+" | "-") product)*          power = atom (("**" | "^") signed)?
    product = signed (("*" | "/") signed)*            atom  = number | name | name "(" sum, ... ")"
    signed  = ("+" | "-")* power                              | "(" sum ")"

A decimal is the fraction that it was written as, ``pi`` is a number, and every other name is a
symbol, whatever it is called.  What has no symbols is a number: it is followed in doubles on the
way, so that what overflows, is not real or divides by zero is refused before exact algebra, which
would take such a tower of powers for an integer to be written out, begins to compute it.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, NamedTuple, NoReturn

import sympy as sp

from voronec.errors import DefinitionError, did_you_mean, quote

CHARACTERS = 20_000
"""How long a formula may be: the longest in print fill a page or two."""
DEPTH = 100
"""How many parentheses, functions and exponents stand in one another; far below Python's stack."""
BITS = 40_000
"""How long numerator and denominator of a number may become on the way, and how high a power."""
MOST_DIGITS = 4000
"""How many digits a number may have as written; Python reads no integer of more than 4300."""
EXPRESSIONS = (sp.Expr, sp.logic.boolalg.Boolean)
"""What other libraries' things may be read as; SymPy makes sets of ranges, and tables of arrays."""
ARGUMENTS = 10
"""How many arguments ``Min`` and ``Max`` take: SymPy compares each with each."""

_SINGLE: dict[str, Callable[[float], float]] = {
    **{f: getattr(math, f) for f in "sin cos tan asin acos atan sinh cosh tanh".split()},
    **{f: getattr(math, f) for f in "asinh acosh atanh exp log sqrt floor".split()},
    "cot": lambda x: 1 / math.tan(x),
    "sec": lambda x: 1 / math.cos(x),
    "csc": lambda x: 1 / math.sin(x),
    "coth": lambda x: 1 / math.tanh(x),
    "acot": lambda x: math.atan(1 / x) if x else math.pi / 2,
    "ceiling": math.ceil,
    "Abs": abs,
    "abs": abs,
    "sign": lambda x: float((x > 0) - (x < 0)),
    "Heaviside": lambda x: 0.5 + 0.5 * ((x > 0) - (x < 0)),
}
_SEVERAL: dict[str, Callable[..., float]] = {"atan2": math.atan2, "Min": min, "Max": max}
_OPERATIONS: dict[str, Callable[..., float]] = {
    **_SINGLE,
    **_SEVERAL,
    "Add": lambda *terms: sum(terms),
    "Mul": lambda *factors: math.prod(factors),
    "Pow": math.pow,
}
FUNCTION_NAMES = (*_SINGLE, *_SEVERAL)
"""The functions that text may hold."""

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)|(?P<name>[^\W\d]\w*)"
    r"|(?P<sign>\*\*|[-+*/^(),]))"
)
NOT_REAL = (sp.I, sp.nan, sp.zoo, sp.oo, -sp.oo)
"""Constants of SymPy that are no real numbers."""


class NotAFormula(DefinitionError):
    """A text that is no formula: ``why``, the sign ``near`` and its ``column``, from 1."""

    def __init__(self, message: str, why: str, near: str, column: int) -> None:
        super().__init__(message)
        self.why, self.near, self.column = why, near, column

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.why, self.near, self.column)


class _Value(NamedTuple):
    """An expression, and its value in doubles where it holds no symbols."""

    expr: Any
    size: float | None


class _Token(NamedTuple):
    """A piece of the text: its kind (``number``, ``name``, ``sign``, ``end``), and where it is."""

    kind: str
    text: str
    at: int


def formula(text: str, place: str, names: Mapping[str, Any] | None = None) -> Any:
    """The SymPy expression that a text means; nothing in it is ever run.

    ``place`` says in messages whose text it is; ``names`` are symbols or expressions that names
    stand for, every other name is a symbol.  ``DefinitionError`` names the column at fault.
    """
    return _FormulaReader(text, place, dict(names or {})).whole()


def name_or_formula(text: str, place: str) -> Any:
    """A name as it is, such as u1 or 'momentum squared'; any other text as the formula it means."""
    bare = text.strip()
    return bare if re.fullmatch(r"[^\W\d]\w*(?: \w+)*", bare) else formula(bare, place)


def read_sympy_text(text: str, place: str, names: Mapping[str, Any] | None = None) -> Any:
    """The expression that SymPy printed as a text, of any length.

    Besides what a formula holds these are unknown functions and their derivatives, such as
    ``Derivative(f(x), (x, 2))``.
    """
    return _FormulaReader(text, place, dict(names or {}), open=True).whole()


def exact_number(text: str, place: str) -> Any:
    """The real number that a text means, exactly: ``-pi/2``, ``acos(-8/17)``, ``1/3``, ``1e-9``."""
    read = _FormulaReader(text, place, {}, kind="number").whole()
    if read.free_symbols:
        unknown = min(map(str, read.free_symbols))
        raise DefinitionError(
            f"{place}: '{quote(text)}' is not a number, since '{quote(unknown)}' has no value; "
            "give one such as 2.5, 1/3 or -pi/2"
        )
    return read


def as_expression(thing: Any, place: str = "an expression") -> Any:
    """What SymPy makes of a number, an expression or a text; text is read by ``formula``.

    In place of ``sympy.sympify``, which runs text as Python, also inside lists.
    ``DefinitionError`` where ``thing`` is none of these.
    """
    if isinstance(thing, sp.Basic) and not isinstance(thing, sp.Lambda):  # a Lambda has no value
        return thing
    if isinstance(thing, sp.MatrixBase):
        return thing.as_immutable()
    if isinstance(thing, str):
        return formula(thing, place)
    try:
        if not isinstance(thing, tuple | list | dict | set | frozenset | bytes | sp.Lambda):
            read = sp.sympify(thing, strict=True)
            if isinstance(read, EXPRESSIONS):
                return read
    except Exception:  # of SymPy, or of somebody's own class
        pass
    kind = type(thing).__name__
    raise DefinitionError(f"{place} is '{quote(thing)}' of kind {kind}; write a sympy expression")


@dataclass
class _FormulaReader:
    """Recursive descent over the tokens of one text."""

    text: str
    place: str
    names: dict[str, Any]
    open: bool = False
    """Whether functions may be unknown ones, and the text of any length."""
    kind: str = "formula"
    depth: int = 0

    def __post_init__(self) -> None:
        if len(self.text) > CHARACTERS and not self.open:
            raise DefinitionError(
                f"{self.place}: '{quote(self.text)}' has {len(self.text)} characters; "
                f"{CHARACTERS} are read at most"
            )
        self.end = 0
        self.token = self._next()

    def whole(self) -> Any:
        try:
            value = self._sum()
        except RecursionError:
            self._wrong("it is nested too deeply", _Token("end", "", 0))
        if self.token.kind != "end":
            self._wrong("an operator is expected")
        return self._real(value.expr, _Token("end", "", 0))

    def _sum(self) -> _Value:
        terms = [self._product()]
        while self.token.text in ("+", "-"):
            sign = self._take()
            term = self._product()
            terms.append(_negative(term) if sign.text == "-" else term)
        return self._join(sp.Add, operator.add, terms)

    def _product(self) -> _Value:
        factors = [self._signed_term()]
        while self.token.text in ("*", "/"):
            sign = self._take()
            factor = self._signed_term()
            if sign.text == "/":
                if factor.expr == 0:
                    self._wrong("division by zero", sign)
                size = self._double(lambda x: 1 / x, sign, factor)
                factor = self._check(1 / factor.expr, size, sign)
            factors.append(factor)
        return self._join(sp.Mul, operator.mul, factors)

    def _join(self, kind: Any, operation: Callable[..., float], parts: list[_Value]) -> _Value:
        if len(parts) == 1:
            return parts[0]
        size = None if any(p.size is None for p in parts) else parts[0].size
        for part in parts[1:] if size is not None else ():
            size = operation(size, part.size)
        return self._check(kind(*(p.expr for p in parts)), size)

    def _signed_term(self) -> _Value:
        minus = False
        while self.token.text in ("+", "-"):
            minus ^= self._take().text == "-"
        value = self._power()
        return _negative(value) if minus else value

    def _power(self) -> _Value:
        base = self._atom()
        if self.token.text not in ("**", "^"):
            return base
        sign = self._take()
        self._enter(sign)
        exponent = self._signed_term()
        self.depth -= 1
        size = self._double(math.pow, sign, base, exponent)
        if exponent.expr.is_Rational:
            held = max(map(_bits, base.expr.atoms(sp.Rational)), default=1)
            if (held if held > 1 or base.size is None else 0) * abs(exponent.expr) > BITS:
                self._wrong("the power is too large", sign)
        return self._check(base.expr**exponent.expr, size, sign)

    def _atom(self) -> _Value:
        token = self._take()
        if token.kind == "number":
            return self._number(token)
        if token.kind == "name":
            return self._call(token) if self.token.text == "(" else self._name(token)
        if token.text != "(":
            self._wrong("a number, a name or '(' is expected", token)
        self._enter(token)
        value = self._sum()
        self._leave(token)
        return value

    def _name(self, token: _Token) -> _Value:
        if token.text in self.names:
            known = as_expression(self.names[token.text], self.place)
            try:
                return _Value(known, in_doubles(known))
            except OverflowError:
                self._wrong("the number is too large", token)
        if token.text == "pi":
            return _Value(sp.pi, math.pi)
        return _Value(sp.Symbol(token.text), None)

    def _call(self, name: _Token) -> _Value:
        opening = self._take()
        if self.open and name.text not in FUNCTION_NAMES:
            return self._unknown(name, opening)
        if name.text not in FUNCTION_NAMES:
            hint = did_you_mean(name.text, FUNCTION_NAMES).removeprefix("; ")
            self._wrong(f"there is no such function; {hint}", name)
        self._enter(opening)
        values = [self._sum()]
        while self.token.text == ",":
            self._take()
            values.append(self._sum())
        self._leave(opening)
        most = ARGUMENTS if name.text in ("Min", "Max") else 1 + (name.text == "atan2")
        if not 1 + (name.text in _SEVERAL) <= len(values) <= most:
            self._wrong(f"{name.text} has {len(values)} argument(s)", name)
        function = _SINGLE.get(name.text) or _SEVERAL[name.text]
        size = self._double(function, name, *values)
        exact = sp.Abs if name.text == "abs" else getattr(sp, name.text)
        return self._check(exact(*(v.expr for v in values)), size, name)

    def _unknown(self, name: _Token, opening: _Token) -> _Value:
        """An unknown function, or a derivative of one."""
        self._enter(opening)
        parts: list[Any] = [self._sum().expr]
        while self.token.text == ",":
            self._take()
            parts.append(self._variable() if name.text == "Derivative" else self._sum().expr)
        self._leave(opening)
        try:
            function = sp.Derivative if name.text == "Derivative" else sp.Function(name.text)
            return _Value(function(*parts), None)
        except (TypeError, ValueError):
            self._wrong("no derivative", name)

    def _variable(self) -> Any:
        """A variable of a derivative, or a pair of one and how often."""
        if self.token.text != "(":
            return self._sum().expr
        opening = self._take()
        self._enter(opening)
        variable, times = self._sum().expr, 1
        if self.token.text == ",":
            self._take()
            number = self._sum().expr
            times = int(number) if number.is_Integer and 0 < number <= DEPTH else 0
        if not times:
            self._wrong(f"from 1 to {DEPTH} derivatives", opening)
        self._leave(opening)
        return variable, times

    def _number(self, token: _Token) -> _Value:
        digits, _, exponent = token.text.lower().partition("e")
        if len(digits) > MOST_DIGITS or len(exponent) > 5 or abs(int(exponent or 0)) > MOST_DIGITS:
            self._wrong("the number is too long", token)
        value = Fraction(token.text)
        exact = sp.Rational(value.numerator, value.denominator)
        try:
            return _Value(exact, float(value))
        except OverflowError:
            self._wrong("the number is too large", token)

    def _check(self, expr: Any, size: float | None, at: _Token | None = None) -> _Value:
        """A number, if it is a finite real one of possible length; what holds symbols, as it is."""
        if size is not None:
            self._real(expr, at)
            if not math.isfinite(size) or (expr.is_Rational and _bits(expr) > BITS):
                self._wrong("the number is too large", at)
        return _Value(expr, size)

    def _real(self, expr: Any, at: _Token | None) -> Any:
        if expr.has(*NOT_REAL):
            self._wrong("not a finite real number", at)
        return expr

    def _double(self, function: Callable[..., float], at: _Token, *values: _Value) -> float | None:
        sizes = [v.size for v in values]
        if any(size is None for size in sizes):
            return None
        try:
            return function(*sizes)
        except OverflowError:
            self._wrong("the number is too large", at)
        except (ValueError, ZeroDivisionError):
            self._wrong("not a finite real number", at)

    def _enter(self, at: _Token) -> None:
        self.depth += 1
        if self.depth > DEPTH:
            self._wrong(f"more than {DEPTH} levels in one another", at)

    def _leave(self, opening: _Token) -> None:
        if self.token.text != ")":
            self._wrong(f"the parenthesis of column {opening.at + 1} is not closed")
        self._take()
        self.depth -= 1

    def _take(self) -> _Token:
        token = self.token
        if token.kind != "end":
            self.token = self._next()
        return token

    def _next(self) -> _Token:
        match = _TOKEN.match(self.text, self.end)
        if match is None:
            rest = self.text[self.end :].lstrip()
            at = len(self.text) - len(rest)
            if rest:
                self._wrong("no formula has this sign", _Token("", rest[0], at))
            return _Token("end", "", at)
        self.end = match.end()
        kind = str(match.lastgroup)
        return _Token(kind, match[kind], match.start(kind))

    def _wrong(self, what: str, token: _Token | None = None) -> NoReturn:
        token = token or self.token
        near = f" at column {token.at + 1} ('{quote(token.text)}')" if token.text else ""
        raise NotAFormula(
            f"{self.place}: '{quote(self.text)}' is not a {self.kind}{near}: {what}; write one "
            f"such as {'2*a*sin(x)/3' if self.kind == 'formula' else '2.5, 1/3'} or -pi/2",
            what,
            token.text,
            token.at + 1,
        )


def _negative(value: _Value) -> _Value:
    return _Value(-value.expr, None if value.size is None else -value.size)


def in_doubles(expr: Any) -> float | None:
    """About how large a number is, ``None`` where it holds symbols or other functions.

    ``OverflowError`` where it, or a number in it, is beyond doubles: exact algebra and long
    precision would write such a number out.
    """
    return doubles_of_parts(expr)[expr]


def doubles_of_parts(expr: Any) -> dict[Any, float | None]:
    """The size of every subexpression, each visited once."""
    values: dict[Any, float | None] = {}
    stack = [expr]
    while stack:
        node = stack[-1]
        waiting = [part for part in node.args if part not in values]
        if waiting and node not in values:
            stack += waiting
        else:
            stack.pop()
            if node not in values:
                values[node] = _double_of(node, [values[part] for part in node.args])
    return values


def _double_of(node: Any, parts: list[Any]) -> float | None:
    if isinstance(node, sp.Symbol):
        return None
    if not parts:
        known = getattr(node, "is_number", False) and node.is_real
        double = float(node) if known else None
    else:
        function = _OPERATIONS.get(type(node).__name__)
        try:
            double = None if function is None or None in parts else function(*parts)
        except (ValueError, ZeroDivisionError):
            return math.nan
    if double is not None and math.isinf(double):
        raise OverflowError
    return double


def _bits(number: Any) -> int:
    return max(int(number.p).bit_length(), int(number.q).bit_length())
