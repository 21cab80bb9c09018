"""A program as heyoka expressions, for its Taylor integrator.

Expressions are built directly, node by node: heyoka's own reader of SymPy refuses rationals whose
denominator is no power of two.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, reduce
from typing import Any

import symengine as se

from voronec.algebra import numeric_functions as numeric
from voronec.equations.program.dialect import rational, rewrite
from voronec.equations.program.straight import Block, Program
from voronec.errors import EngineLimit

NUMBER = "number"
"""Under this name the kind of numbers stands beside what is built."""
LARGEST = 2**53
"""Whole numbers up to this are doubles."""
TERMS = 27
"""Powers of w in the series of sin(w)/w: the next is 1e-18 for |w| < 2.4, further than a step from
|w| < 1 goes."""


def taylor_system(
    program: Program, units: Sequence[float] = (), number: Callable[[str], Any] | None = None
) -> list[tuple[Any, Any]]:
    """Pairs (variable, time derivative) for ``heyoka.taylor_adaptive``.

    A variable is a state of the program divided by its unit, 1 by default.  ``number`` makes
    those that are no doubles, as a third, from text; without it they are rounded.

    Parameters are ``par[0], par[1], ...`` in the program's order; the time is ``heyoka.time``.
    Raises ``EngineLimit`` for a function that heyoka does not know.
    """
    import heyoka as hy

    hy.set_logger_level_critical()  # a terminal is the user's; runs are judged by their results
    variables, known = _names(program, units, hy)
    known[NUMBER] = number
    results = _built_block(program.derivative, known, hy)
    sizes = units or [1.0] * len(variables)
    scaled = [r if u == 1 else r / u for r, u in zip(results, sizes, strict=True)]
    return list(zip(variables, scaled, strict=True))


def taylor_extras(
    program: Program, units: Sequence[float] = (), number: Callable[[str], Any] | None = None
) -> dict[str, Any]:
    """The extra quantities by name, in the variables and parameters of ``taylor_system``.

    Events and compiled functions of heyoka take them.
    """
    import heyoka as hy

    _, known = _names(program, units, hy)
    known[NUMBER] = number
    return dict(zip(program.names, _built_block(program.extras, known, hy), strict=True))


def _names(program: Program, units: Sequence[float], hy: Any) -> tuple[list[Any], dict[Any, Any]]:
    """heyoka's variables of the state, and what every symbol of the program stands for."""
    variables = [hy.expression(f"y{i}") for i in range(len(program.state))]
    sizes = units or [1.0] * len(variables)
    states = [y if u == 1 else u * y for y, u in zip(variables, sizes, strict=True)]
    known: dict[Any, Any] = dict(zip(program.state, states, strict=True))
    known |= {p: hy.par[i] for i, p in enumerate(program.parameters)}
    known[numeric.HYPOT] = any(u != 1 for u in sizes)  # then squares may overflow
    known[program.time] = hy.time
    return variables, known


def _built_block(block: Block, known: dict[Any, Any], hy: Any) -> list[Any]:
    for name, expr in block.assignments:
        known[name] = _build(expr, known, hy)
    return [_build(r, known, hy) for r in block.results]


def _build(expr: Any, known: dict[Any, Any], hy: Any) -> Any:
    """The heyoka expression of a symengine expression; ``known`` remembers what is built."""
    done = known.get(expr)
    if done is None:
        done = known[expr] = _build_node(expr, known, hy)
    return done


def _build_node(expr: Any, known: dict[Any, Any], hy: Any) -> Any:
    if expr.is_Number:
        return hy.expression(_fraction(expr, known))
    if expr == se.pi:
        return hy.pi
    if expr == se.E:
        return hy.exp(hy.expression(1.0))
    other = rewrite(expr)
    if other is not None:
        return _build(other, known, hy)
    name = numeric.numeric_name(expr)
    if name == numeric.HYPOT and known.get(numeric.HYPOT):
        return _length([_build(a, known, hy) for a in expr.args], hy)
    if name is not None and name not in _NUMERIC:
        return _build(numeric.FORMULAS[name](*expr.args), known, hy)
    args = [_build(a, known, hy) for a in expr.args]
    if name is not None:
        return _NUMERIC[name](args[0], hy)
    if isinstance(expr, se.Add):
        return hy.sum(args)
    if isinstance(expr, se.Mul):
        return hy.prod(args)
    if isinstance(expr, se.Pow):
        return _power(expr, args, known, hy)
    if isinstance(expr, se.Abs):
        return _size(args[0], hy)
    if isinstance(expr, se.sign):
        negative = hy.select(hy.lt(args[0], 0.0), -1.0, 0.0)
        return hy.select(hy.gt(args[0], 0.0), 1.0, negative)
    function: Callable[..., Any] | None = getattr(hy, type(expr).__name__, None)
    if function is None:
        raise EngineLimit(f"heyoka has no function '{type(expr).__name__}'; use method='scipy'")
    return function(*args)


def _fraction(expr: Any, known: dict[Any, Any]) -> Any:
    """A rational number, in the kind of numbers that was asked for where no double is equal."""
    p, q = rational(expr)
    number = known[NUMBER]
    if number is None or (q & (q - 1) == 0 and abs(p) <= LARGEST):
        return p / q
    return number(str(p)) / number(str(q))


def _size(w: Any, hy: Any) -> Any:
    return hy.select(hy.lt(w, 0.0), -w, w)


def _length(sides: list[Any], hy: Any) -> Any:
    """The root of a sum of squares, the largest taken out: equal whichever it is."""

    def larger(a: Any, b: Any) -> Any:
        return hy.select(hy.lt(a, b), b, a)

    largest = reduce(larger, [_size(a, hy) for a in sides])
    return largest * hy.sqrt(hy.sum([(a / largest) ** 2.0 for a in sides]))


def _beside_one(x: Any, hy: Any) -> Any:
    """log(1 + x) = 2 artanh(x/(2 + x)), which loses no digits of a small x."""
    return hy.select(hy.lt(x, 1.0), 2.0 * hy.atanh(x / (2.0 + x)), hy.log(1.0 + x))


def _less_one(w: Any, hy: Any) -> Any:
    """exp(w) - 1 = 2 exp(w/2) sinh(w/2), which loses no digits of a small w."""
    half = w / 2.0
    product = 2.0 * hy.exp(half) * hy.sinh(half)
    return hy.select(hy.lt(w, -1.0), hy.exp(w) - 1.0, product)


def _cardinal(name: str, w: Any, hy: Any) -> Any:
    """A quotient such as sin(w)/w; a power series for small |w|, where the division loses digits.

    A step is the expansion at its start: what the function is further off matters to the terms
    alone that the series has too.
    """
    quotient = numeric.QUOTIENTS[name]
    square, series = w**2.0, hy.expression(0.0)
    for n in reversed(range(0, TERMS, 2)):
        p, q = quotient.coefficient(n)
        series = series * square + p / q
    far = _ABOVE[name](w, hy) / _whole(w, quotient.power)
    return hy.select(hy.lt(_size(w, hy), numeric.REACH), series, far)


_ABOVE: dict[str, Callable[[Any, Any], Any]] = {
    numeric.SINC: lambda w, hy: hy.sin(w),
    numeric.SINC_SLOPE: lambda w, hy: hy.sin(w) - w * hy.cos(w),
}


_NUMERIC: dict[str, Callable[[Any, Any], Any]] = {
    **{name: partial(_cardinal, name) for name in numeric.QUOTIENTS},
    numeric.EXPM1: _less_one,
    numeric.LOG1P: _beside_one,
    numeric.SIZE: _size,
}
"""Functions that programs alone know, where they are not written by their formulas."""


def _power(expr: Any, args: list[Any], known: dict[Any, Any], hy: Any) -> Any:
    base, exponent = expr.args
    if base == se.E:
        return hy.exp(args[1])
    if exponent.is_Number:
        p, q = rational(exponent)
        if q == 2:
            root = hy.sqrt(args[0])
            return root if p == 1 else _whole(root, p)
        return _whole(args[0], p) if q == 1 else args[0] ** _fraction(exponent, known)
    return args[0] ** args[1]


def _whole(base: Any, exponent: int) -> Any:
    """A power with a whole exponent; by squares and products where it is above two.

    heyoka's recurrence for powers divides by the base, which may be zero, or close to it.
    """
    if exponent < 3:
        return base ** float(exponent)
    half = _whole(base, exponent // 2) if exponent > 3 else base
    return half**2.0 * base if exponent % 2 else half**2.0
