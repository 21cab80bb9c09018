"""Writing symengine expressions in a programming language."""

from __future__ import annotations

import hashlib
import linecache
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import CodeType
from typing import Any

import symengine as se

from voronec.algebra import numeric_functions as numeric
from voronec.algebra.symbols import unused_name
from voronec.equations.program.straight import Block
from voronec.errors import EngineLimit, quote

FUNCTIONS = (
    "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log sqrt Abs sign "
    "floor power"
).split()
"""What every dialect has a word for; the rest is rewritten in terms of these."""

_BY_OTHERS: dict[type, Callable[[Any], Any]] = {
    se.cot: lambda x: 1 / se.tan(x),
    se.sec: lambda x: 1 / se.cos(x),
    se.csc: lambda x: 1 / se.sin(x),
    se.acot: lambda x: se.atan(1 / x),
    se.coth: lambda x: 1 / se.tanh(x),
}
QUOTIENTS = {
    numeric.SINC: ("sinc", "sin(x)"),
    numeric.SINC_SLOPE: ("sinc_slope", "sin(x) - x*cos(x)"),
}
"""Quotients that cancel near zero, where doubles take their ``series``: a word, what is divided."""
DOUBLE = 1e-18
"""Terms below this say nothing to doubles."""
_EXACT = 2**53
TERMS = 200
"""Longer sums are sums of sums: Python's compiler and others descend a level for every term."""
_SUM, _PRODUCT, _POWER, _ATOM = range(4)


@dataclass(frozen=True)
class Dialect:
    """How a language writes numbers, powers and functions.

    ``number`` takes an integer; ``quotient`` a numerator and denominator; ``words`` names the
    functions of ``FUNCTIONS``; ``power`` writes an integer power of a text that may be a sum.
    """

    number: Callable[[int], str]
    quotient: Callable[[int, int], str]
    power: Callable[[str, int], str]
    pi: str
    words: Mapping[str, str]


def code(source: str, filename: str, mode: str = "exec") -> CodeType:
    """Generated source, compiled; ``EngineLimit`` where Python's own compiler gives up."""
    try:
        return compile(source, filename, mode)
    except (RecursionError, MemoryError, SyntaxError) as error:
        raise EngineLimit(
            f"a program of {len(source)} characters is too large for Python ({error}); "
            "take shorter expressions, or fewer outputs"
        ) from None


def execute(source: str, what: str, names: Mapping[str, Any]) -> dict[str, Any]:
    """What generated source defines, beside the names that are given to it; tracebacks show its
    lines."""
    filename = f"<voronec {what} {hashlib.sha256(source.encode()).hexdigest()[:12]}>"
    linecache.cache[filename] = (len(source), None, source.splitlines(keepends=True), filename)
    namespace = dict(names)
    exec(code(source, filename), namespace)
    return namespace


def series(name: str, x: str = "x") -> str:
    """The power series of a quotient as far as doubles tell, for |x| below its reach."""
    quotient = numeric.QUOTIENTS[name]
    terms = []
    for n in range(0, TERMS, 2):
        p, q = quotient.coefficient(n)
        terms.append(repr(p / q))
        if abs(p / q) * numeric.REACH**n < DOUBLE:
            break
    polynomial = terms.pop()
    while terms:
        polynomial = f"{terms.pop()} + {x}*{x}*({polynomial})"
    return f"({polynomial})"


def rewrite(expr: Any) -> Any | None:
    """cot, sec and their like by the functions that every dialect has; None for others."""
    rule = _BY_OTHERS.get(type(expr))
    return rule(*expr.args) if rule else None


def identifiers(symbols: Iterable[Any], reserved: Iterable[str]) -> dict[Any, str]:
    """Valid, distinct identifiers for symbols; an underscore marks a name that had to give way."""
    taken = set(reserved)
    result: dict[Any, str] = {}
    for symbol in symbols:
        name = re.sub(r"[^0-9A-Za-z_]", "_", str(symbol))
        name = f"_{name}" if name[0].isdigit() else name
        name = unused_name(name, taken)
        taken.add(name)
        result[symbol] = name
    return result


def lines(block: Block, dialect: Dialect, names: Mapping[Any, str]) -> list[tuple[str, str]]:
    """The assignments of a block as pairs of texts."""
    return [(names[name], text(expr, dialect, names)) for name, expr in block.assignments]


def text(expr: Any, dialect: Dialect, names: Mapping[Any, str]) -> str:
    """One expression as source."""
    return _write(expr, dialect, names)[0]


def _write(expr: Any, dialect: Dialect, names: Mapping[Any, str]) -> tuple[str, int]:
    """Source and its precedence."""
    if isinstance(expr, se.Symbol):
        return names[expr], _ATOM
    if expr.is_Number:
        return _number(expr, dialect)
    if expr == se.pi:
        return dialect.pi, _ATOM
    if isinstance(expr, se.Add):
        return _sum(expr, dialect, names), _SUM
    if isinstance(expr, se.Mul):
        return _product(expr, dialect, names), _PRODUCT
    if isinstance(expr, se.Pow) or expr == se.E:
        return _print_power(expr, dialect, names)
    other = rewrite(expr)
    if other is not None:
        return _write(other, dialect, names)
    name = numeric.numeric_name(expr) or type(expr).__name__
    if name not in dialect.words:
        raise EngineLimit(f"'{name}' cannot be written as source; use elementary functions")
    return _print_call(name, expr.args, dialect, names), _ATOM


def _print_call(name: str, args: Iterable[Any], dialect: Dialect, names: Mapping[Any, str]) -> str:
    word, inner = dialect.words[name], [text(a, dialect, names) for a in args]
    if name == "atan2":  # on the cut -0.0 is zero
        inner[0] += f" + {dialect.number(0)}"
    while name == numeric.HYPOT and len(inner) > 2:  # of two sides in most libraries
        inner = [f"{word}({inner[0]}, {inner[1]})", *inner[2:]]
    return f"{word}({', '.join(inner)})"


def rational(number: Any) -> tuple[int, int]:
    """Numerator and denominator of an exact number."""
    if not isinstance(number, se.Rational):
        raise EngineLimit(
            f"the number '{number}' is not rational; write it as a fraction or a decimal"
        )
    return int(number.p), int(number.q)


def _number(expr: Any, dialect: Dialect) -> tuple[str, int]:
    p, q = rational(expr)
    written = dialect.number(p) if q == 1 else dialect.quotient(p, q)
    return written, _SUM if p < 0 else _ATOM if q == 1 else _PRODUCT


def _sum(expr: Any, dialect: Dialect, names: Mapping[Any, str]) -> str:
    written = [_write(a, dialect, names)[0] for a in expr.args]
    # begin with a positive term; sums of SymEngine have no order that outlives a process
    written.sort(key=lambda term: (term.startswith("-"), term))
    while len(written) > TERMS:
        groups = [written[i : i + TERMS] for i in range(0, len(written), TERMS)]
        written = [f"({_join_terms(group)})" for group in groups]
    return _join_terms(written)


def _join_terms(terms: list[str]) -> str:
    first, *others = terms
    return first + "".join(f" - {w[1:]}" if w.startswith("-") else f" + {w}" for w in others)


def _product(expr: Any, dialect: Dialect, names: Mapping[Any, str]) -> str:
    """Factors over factors: ``-2*a*b/(3*c)``."""
    above: list[str] = []
    below: list[str] = []
    sign = ""
    for factor in expr.args:
        if factor.is_Number:
            p, q = rational(factor)
            sign = "-" if p < 0 else ""
            above += [dialect.number(abs(p))] if abs(p) != 1 else []
            below += [dialect.number(q)] if q != 1 else []
        elif isinstance(factor, se.Pow) and factor.args[1].is_Number and factor.args[1] < 0:
            below.append(_operand(1 / factor, dialect, names))
        else:
            above.append(_operand(factor, dialect, names))
    head = sign + ("*".join(above) or dialect.number(1))
    if not below:
        return head
    return f"{head}/{below[0]}" if len(below) == 1 else f"{head}/({'*'.join(below)})"


def _operand(expr: Any, dialect: Dialect, names: Mapping[Any, str]) -> str:
    written, precedence = _write(expr, dialect, names)
    return written if precedence >= _POWER else f"({written})"


def _print_power(expr: Any, dialect: Dialect, names: Mapping[Any, str]) -> tuple[str, int]:
    if expr == se.E:
        return _print_call("exp", [se.Integer(1)], dialect, names), _ATOM
    base, exponent = expr.args
    if base == se.E:
        return _print_call("exp", [exponent], dialect, names), _ATOM
    if not exponent.is_Number:
        return _print_call("power", [base, exponent], dialect, names), _ATOM
    p, q = rational(exponent)
    if p < 0:
        one = dialect.number(1)
        return f"{one}/{_operand(1 / expr, dialect, names)}", _PRODUCT
    if q > 2:
        return _print_call("power", [base, exponent], dialect, names), _ATOM
    if q == 2:
        root = _print_call("sqrt", [base], dialect, names)
        return (root, _ATOM) if p == 1 else (dialect.power(root, p), _POWER)
    return dialect.power(text(base, dialect, names), p), _POWER


def decimal(p: int, q: int = 1) -> str:
    """A number that doubles cannot hold exactly as a fraction, as the nearest double."""
    try:
        return repr(p / q)
    except OverflowError:
        raise EngineLimit(f"the number {quote(p)}/{quote(q)} is beyond doubles") from None


def fits(*numbers: int) -> bool:
    """Whether doubles hold these integers exactly."""
    return all(abs(n) <= _EXACT for n in numbers)
