"""Expressions as a sequence of mpmath operations, each shared subexpression computed once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath as mp
import symengine as se

from voronec.algebra.numeric_functions import (
    EXPM1,
    EXPREL,
    HYPOT,
    LOG1P,
    SINC,
    SINHC,
    SIZE,
    numeric_name,
)
from voronec.algebra.stable import stable_all
from voronec.errors import DefinitionError

__all__ = ["Sequenced"]

Operation = Callable[..., Any]

_NAMES = (
    "sin cos tan cot sec csc asin acos atan acot atan2 "
    "sinh cosh tanh coth asinh acosh atanh log sign floor"
).split()
_FUNCTIONS: dict[str, Operation] = {name: getattr(mp, name) for name in _NAMES} | {"Abs": mp.fabs}
_FUNCTIONS |= {
    SINC: mp.sinc,
    SINHC: lambda a: mp.sinh(a) / a if a else mp.mpf(1),
    EXPREL: lambda a: mp.expm1(a) / a if a else mp.mpf(1),
    EXPM1: mp.expm1,
    LOG1P: mp.log1p,
    SIZE: mp.fabs,
    HYPOT: lambda *sides: mp.sqrt(mp.fsum(a * a for a in sides)),
}
_CONDITIONS: dict[str, Operation] = {
    "LessThan": lambda a, b: a <= b,
    "StrictLessThan": lambda a, b: a < b,
    "Equality": lambda a, b: a == b,
    "Unequality": lambda a, b: a != b,
    "And": lambda *given: all(given),
    "Or": lambda *given: any(given),
    "Not": lambda given: not given,
    "BooleanTrue": lambda: True,
    "BooleanFalse": lambda: False,
}
_CONSTANTS: dict[Any, Operation] = {se.pi: lambda: +mp.pi, se.E: lambda: +mp.e}


class Sequenced:
    """Several symengine expressions, ready to be evaluated at any precision of mpmath.

    ``names`` are the symbols they need, in the order of their slots.  An unknown function raises
    ``DefinitionError``.
    """

    def __init__(self, exprs: Sequence[Any]) -> None:
        roots = stable_all(exprs)
        order = _operands_first(roots)
        symbols = [e for e in order if isinstance(e, se.Symbol)]
        composite = [e for e in order if not isinstance(e, se.Symbol)]
        slots = {e: slot for slot, e in enumerate([*symbols, *composite])}
        self.names = [str(s) for s in symbols]
        self._steps = [(op, [slots[a] for a in args]) for op, args in map(_step, composite)]
        self._outputs = [slots[root] for root in roots]

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """The values at a point ``{name: mpf}``, at the working precision.

        Raises ``DefinitionError`` where an expression is not defined or not real.
        """
        numbers = [values[name] for name in self.names]
        try:
            for operation, slots in self._steps:
                numbers.append(operation(*[numbers[s] for s in slots]))
        except (ZeroDivisionError, ValueError, OverflowError):
            raise DefinitionError(
                "the equations are not defined at this point (a division by zero or a function "
                "outside its domain); choose another point or other coordinates"
            ) from None
        return [_real(numbers[slot]) for slot in self._outputs]


def _operands_first(roots: Sequence[Any]) -> list[Any]:
    """Every subexpression once, after its operands."""
    order: dict[Any, None] = {}
    stack = [(root, False) for root in reversed(roots)]
    while stack:
        expr, ready = stack.pop()
        if expr in order:
            continue
        if ready:
            order[expr] = None
        else:
            stack.append((expr, True))
            operands = () if isinstance(expr, se.Symbol) else _step(expr)[1]
            stack.extend((a, False) for a in operands)
    return list(order)


def _step(expr: Any) -> tuple[Operation, Sequence[Any]]:
    """The operation at the root of an expression, and its operands."""
    if expr in _CONSTANTS:
        return _CONSTANTS[expr], ()
    if type(expr).__name__ in _CONDITIONS:
        return _CONDITIONS[type(expr).__name__], expr.args
    if isinstance(expr, se.Piecewise):
        return _first_case, expr.args
    if _is_level(expr):
        return (lambda: mp.mpf(0)), ()
    if isinstance(expr, se.Rational):  # an Integer is a Rational
        p, q = int(expr.p), int(expr.q)
        return (lambda: mp.mpf(p) / q), ()
    if isinstance(expr, se.Add):
        return _sum, expr.args
    if isinstance(expr, se.Mul):
        return _product, expr.args
    if isinstance(expr, se.Pow):
        return _power(*expr.args)
    function = _FUNCTIONS.get(numeric_name(expr) or type(expr).__name__)
    if function is not None:
        return function, expr.args
    if isinstance(expr, (se.FunctionSymbol, se.Derivative, se.Subs)):
        raise DefinitionError(
            f"the unknown function '{expr}' has no value; numeric evaluation needs a formula for it"
        )
    raise DefinitionError(f"'{expr}' has no real value; write it with elementary functions")


def _first_case(*pairs: Any) -> Any:
    """Of values and conditions by turns, the value whose condition is the first that holds."""
    held = (value for value, holds in zip(pairs[::2], pairs[1::2], strict=True) if holds)
    return next(held, mp.nan)


def _is_level(expr: Any) -> bool:
    """Whether an expression is a derivative of a sign or a floor, which do not slope."""
    inner = expr.expr if isinstance(expr, se.Subs) else expr
    return isinstance(inner, se.Derivative) and isinstance(inner.args[0], (se.sign, se.floor))


def _sum(*terms: Any) -> Any:
    return mp.fsum(terms)


def _product(*factors: Any) -> Any:
    result = factors[0]
    for factor in factors[1:]:
        result = result * factor
    return result


def _power(base: Any, exponent: Any) -> tuple[Operation, Sequence[Any]]:
    if base == se.E:
        return mp.exp, (exponent,)
    if isinstance(exponent, se.Rational):
        p, q = int(exponent.p), int(exponent.q)
        if q == 1:
            return (lambda a: a**p), (base,)
        if q == 2:
            return (lambda a: mp.sqrt(a) ** p), (base,)
        return (lambda a: a ** (mp.mpf(p) / q)), (base,)
    return mp.power, (base, exponent)


def _real(number: Any) -> Any:
    if isinstance(number, mp.mpc) and number.imag == 0:
        number = number.real
    if not isinstance(number, mp.mpf) or not mp.isfinite(number):
        raise DefinitionError(
            "the equations have no real value at this point (a root or logarithm of a negative "
            "number, or an infinity); choose another point"
        )
    return number
