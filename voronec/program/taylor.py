"""A program as heyoka expressions, for its Taylor integrator.

Expressions are built directly, node by node: heyoka's own reader of SymPy refuses rationals whose
denominator is no power of two.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import factorial
from typing import Any

import symengine as se

from voronec.algebra.cardinal import EXPREL, SINC, SINHC, cardinal_name
from voronec.errors import EngineLimit
from voronec.program.printing import rational, rewritten
from voronec.program.straight import Block, Program

__all__ = ["taylor_extras", "taylor_system"]

TERMS = 27
"""Powers of w in the series of sin(w)/w: the next is 1e-18 for |w| < 2.4, further than a step from
|w| < 1 goes."""


def taylor_system(program: Program, units: Sequence[float] = ()) -> list[tuple[Any, Any]]:
    """Pairs (variable, time derivative) for ``heyoka.taylor_adaptive``.

    A variable is a state of the program divided by its unit, 1 by default.

    Parameters are ``par[0], par[1], ...`` in the program's order; the time is ``heyoka.time``.
    Raises ``EngineLimit`` for a function that heyoka does not know.
    """
    import heyoka as hy

    hy.set_logger_level_critical()  # a terminal is the user's; runs are judged by their results
    variables, known = _names(program, units, hy)
    results = _built_block(program.derivative, known, hy)
    sizes = units or [1.0] * len(variables)
    scaled = [r if u == 1 else r / u for r, u in zip(results, sizes, strict=True)]
    return list(zip(variables, scaled, strict=True))


def taylor_extras(program: Program, units: Sequence[float] = ()) -> dict[str, Any]:
    """The extra quantities by name, in the variables and parameters of ``taylor_system``.

    Events and compiled functions of heyoka take them.
    """
    import heyoka as hy

    _, known = _names(program, units, hy)
    return dict(zip(program.names, _built_block(program.extras, known, hy), strict=True))


def _names(program: Program, units: Sequence[float], hy: Any) -> tuple[list[Any], dict[Any, Any]]:
    """heyoka's variables of the state, and what every symbol of the program stands for."""
    variables = [hy.expression(f"y{i}") for i in range(len(program.state))]
    sizes = units or [1.0] * len(variables)
    states = [y if u == 1 else u * y for y, u in zip(variables, sizes, strict=True)]
    known: dict[Any, Any] = dict(zip(program.state, states, strict=True))
    known |= {p: hy.par[i] for i, p in enumerate(program.parameters)}
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
        done = known[expr] = _built(expr, known, hy)
    return done


def _built(expr: Any, known: dict[Any, Any], hy: Any) -> Any:
    if expr.is_Number:
        p, q = rational(expr)
        return hy.expression(p / q)
    if expr == se.pi:
        return hy.pi
    if expr == se.E:
        return hy.exp(hy.expression(1.0))
    other = rewritten(expr)
    if other is not None:
        return _build(other, known, hy)
    args = [_build(a, known, hy) for a in expr.args]
    cardinal = cardinal_name(expr)
    if cardinal is not None:
        return _cardinal(cardinal, args[0], hy)
    if isinstance(expr, se.Add):
        return hy.sum(args)
    if isinstance(expr, se.Mul):
        return hy.prod(args)
    if isinstance(expr, se.Pow):
        return _power(expr, args, hy)
    if isinstance(expr, se.Abs):
        return hy.select(hy.lt(args[0], 0.0), -args[0], args[0])
    if isinstance(expr, se.sign):
        negative = hy.select(hy.lt(args[0], 0.0), -1.0, 0.0)
        return hy.select(hy.gt(args[0], 0.0), 1.0, negative)
    function: Callable[..., Any] | None = getattr(hy, type(expr).__name__, None)
    if function is None:
        raise EngineLimit(f"heyoka has no function '{type(expr).__name__}'; use method='scipy'")
    return function(*args)


def _cardinal(name: str, w: Any, hy: Any) -> Any:
    """A quotient such as sin(w)/w; a power series for |w| < 1, where the division loses digits.

    A step is the expansion at its start: what the function is further off matters to the terms
    alone that the series has too.
    """
    above = {SINC: hy.sin, SINHC: hy.sinh, EXPREL: lambda x: hy.exp(x) - 1.0}[name]
    step, sign = (1, 1) if name == EXPREL else (2, -1 if name == SINC else 1)
    power = w if name == EXPREL else w**2.0
    series = hy.expression(0.0)
    for n in reversed(range(0, TERMS, step)):
        series = series * power + sign ** (n // 2) / factorial(n + 1)
    return hy.select(hy.lt(hy.select(hy.lt(w, 0.0), -w, w), 1.0), series, above(w) / w)


def _power(expr: Any, args: list[Any], hy: Any) -> Any:
    base, exponent = expr.args
    if base == se.E:
        return hy.exp(args[1])
    if exponent.is_Number:
        p, q = rational(exponent)
        if q == 2:
            root = hy.sqrt(args[0])
            return root if p == 1 else _whole(root, p)
        return _whole(args[0], p) if q == 1 else args[0] ** (p / q)
    return args[0] ** args[1]


def _whole(base: Any, exponent: int) -> Any:
    """A power with a whole exponent; by squares and products where it is above two.

    heyoka's recurrence for powers divides by the base, which may be zero, or close to it.
    """
    if exponent < 3:
        return base ** float(exponent)
    half = _whole(base, exponent // 2) if exponent > 3 else base
    return half**2.0 * base if exponent % 2 else half**2.0
