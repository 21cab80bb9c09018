"""Straight-line evaluation of expression graphs in ball arithmetic.

A tape visits every node of a shared expression graph once.  Numbers are flint's ``arb`` balls, so
what comes out encloses the exact value: a ball that excludes zero is a proof.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from operator import methodcaller
from typing import Any

import flint
import mpmath as mp
import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra import numeric_functions as numeric
from voronec.algebra.graphs import is_atom, is_flat
from voronec.algebra.text import exact_number
from voronec.errors import DefinitionError, EngineLimit, quote

_NO_VALUE = flint.arb("nan")
_ALIKE = "sin cos tan cot asin acos atan sinh cosh tanh coth asinh acosh atanh log floor".split()
_UNARY: dict[type, Callable[[Any], Any]] = {
    **{getattr(se, name): methodcaller(name) for name in _ALIKE},
    se.Abs: abs,
    se.sec: lambda a: 1 / a.cos(),
    se.csc: lambda a: 1 / a.sin(),
    se.acot: lambda a: (1 / a).atan(),
    se.sign: lambda a: a.sgn() if a.is_finite() else _NO_VALUE,  # nan.sgn() is finite
}
_NUMERIC: dict[str, Callable[..., Any]] = {
    numeric.SINC: lambda a: a.sinc() if a.is_finite() else _NO_VALUE,
    numeric.SINC_SLOPE: lambda a: (-a * a / 4).hypgeom_0f1(flint.arb(5) / 2) / 3,
    numeric.EXPM1: lambda a: a.expm1(),
    numeric.LOG1P: lambda a: a.log1p(),
    numeric.SIZE: abs,
    numeric.HYPOT: lambda *sides: sum((a * a for a in sides), flint.arb(0)).sqrt(),
}
_CONSTANTS: dict[Any, Callable[[], Any]] = {
    se.pi: flint.arb.pi,
    se.E: flint.arb.const_e,
    se.GoldenRatio: lambda: (1 + flint.arb(5).sqrt()) / 2,
}


def as_ball(number: Any) -> Any:
    """A ball around a number, exact for int, Fraction, float, SymPy's and mpmath's numbers."""
    if isinstance(number, (flint.arb, flint.fmpq, flint.fmpz, int, float)):
        return flint.arb(number)
    if isinstance(number, np.floating) and np.isfinite(number):  # whose text is rounded
        number = Fraction(*number.as_integer_ratio())
    if isinstance(number, (Fraction, sp.Rational)):
        return flint.arb(flint.fmpq(int(number.numerator), int(number.denominator)))
    # SymPy's and mpmath's binary numbers; somebody's object may pretend to have everything
    if isinstance(getattr(number, "_mpf_", None), tuple):
        if not mp.isfinite(number):
            raise DefinitionError(f"'{number}' is not a finite number")
        sign, mantissa, exponent, _ = number._mpf_
        return flint.arb(flint.fmpz(-mantissa if sign else mantissa)) * flint.arb(2) ** exponent
    if isinstance(number, se.Basic):
        return Tape([number]).arb({}, flint.ctx.prec)[0]
    if isinstance(number, sp.Expr) and number.is_number:
        return as_ball(se.sympify(number))
    try:
        text = str(number)
    except Exception:  # somebody's own class
        text = ""
    return as_ball(exact_number(text, f"'{quote(number)}' is not a number"))


def middle(ball: Any) -> Any:
    """The middle of a ball as a number of mpmath's, at the precision that is in force there."""
    mantissa, exponent = (int(part) for part in ball.mid().man_exp())
    return mp.ldexp(mp.mpf(mantissa), exponent)


class Tape:
    """A compiled list of symengine expressions.

    ``atoms`` are the symbols, unknown functions and their derivatives it needs values for, by
    name: equal sums may hold their terms in another order, and what is drawn for atoms, or kept
    for equal expressions, is not to depend on that.  ``given`` are expressions taken for atoms;
    ``root`` and ``angle`` are other ways to take square roots and ``atan2(y, x)``.
    """

    def __init__(
        self,
        exprs: Sequence[Any],
        given: Iterable[Any] = (),
        root: Callable[[Any], Any] = methodcaller("sqrt"),
        angle: Callable[[Any, Any], Any] | None = None,
    ) -> None:
        self._given, self._root, self._angle = {*given}, root, angle or _angle
        self._atom_slots: dict[Any, int] = {}
        self._constants: list[tuple[int, Any]] = []
        self._code: list[tuple[int, Callable[..., Any], tuple[int, ...]]] = []
        self._slots: dict[Any, int] = {}
        self._outputs = [self._slot(se.sympify(e)) for e in exprs]
        self.atoms: list[Any] = sorted(self._atom_slots, key=str)

    @property
    def size(self) -> int:
        """How many nodes the shared graph of the expressions has."""
        return len(self._slots)

    def arb(self, point: Mapping[Any, Any], bits: int) -> list[Any]:
        """Enclosures of all expressions at a point ``{atom: number}``, computed with ``bits``.

        Atoms may be named by their symbol or string.  A missing one raises ``DefinitionError``.
        A value outside the real domain of a function comes out as a ball that is not finite.
        """
        with flint.ctx.workprec(bits):
            values = {}
            for atom in self._atom_slots:
                given = point.get(atom, point.get(str(atom)))
                if given is None:
                    raise DefinitionError(f"no value is given for '{atom}'")
                values[atom] = as_ball(given)
            return self.run(values, lambda c: c() if callable(c) else flint.arb(c))

    def run(self, point: Mapping[Any, Any], number: Callable[[Any], Any]) -> list[Any]:
        """All expressions in the arithmetic that the values of the atoms have, and of which
        ``number`` makes one of a ``flint.fmpq``, or of what computes pi or e."""
        values: list[Any] = [None] * len(self._slots)
        for slot, constant in self._constants:
            values[slot] = number(constant)
        for atom, slot in self._atom_slots.items():
            values[slot] = point[atom]
        for slot, operation, arguments in self._code:
            values[slot] = operation(*[values[a] for a in arguments])
        return [values[slot] for slot in self._outputs]

    def _new(self, expr: Any) -> int:
        slot = self._slots[expr] = len(self._slots)
        return slot

    def _slot(self, expr: Any) -> int:
        known = self._slots.get(expr)
        if known is not None:
            return known
        if is_atom(expr) or expr in self._given:
            self._atom_slots[expr] = self._new(expr)
            return self._atom_slots[expr]
        if is_flat(expr):
            return self._constant(expr, flint.fmpq(0))
        if expr.is_Number:
            return self._constant(expr, _rational(expr))
        if expr in _CONSTANTS:
            return self._constant(expr, _CONSTANTS[expr])
        operation, arguments = self._operation(expr)
        slots = tuple(self._slot(a) for a in arguments)
        slot = self._new(expr)
        self._code.append((slot, operation, slots))
        return slot

    def _constant(self, expr: Any, value: Any) -> int:
        slot = self._new(expr)
        self._constants.append((slot, value))
        return slot

    def _operation(self, expr: Any) -> tuple[Callable[..., Any], Sequence[Any]]:
        if isinstance(expr, se.Add):
            return _sum, expr.args
        if isinstance(expr, se.Mul):
            return _product, expr.args
        if isinstance(expr, se.Pow):
            base, exponent = expr.args
            return _power(base, exponent, self._root)
        if isinstance(expr, se.atan2):
            return self._angle, expr.args
        name = numeric.numeric_name(expr)
        unary = _UNARY.get(type(expr)) if name is None else _NUMERIC[name]
        if unary is None:
            raise EngineLimit(f"'{type(expr).__name__}' has no evaluation in ball arithmetic")
        return unary, expr.args


def _rational(number: Any) -> Any:
    if isinstance(number, se.Rational):  # Integer is a Rational
        return flint.fmpq(int(number.p), int(number.q))
    raise EngineLimit(f"the number '{number}' is not rational; write it as a fraction or a decimal")


def _sum(*values: Any) -> Any:
    total = values[0]
    for value in values[1:]:
        total = total + value
    return total


def _product(*values: Any) -> Any:
    total = values[0]
    for value in values[1:]:
        total = total * value
    return total


def _power(
    base: Any, exponent: Any, root: Callable[[Any], Any]
) -> tuple[Callable[..., Any], Sequence[Any]]:
    if base == se.E:
        return (lambda a: a.exp()), (exponent,)
    if isinstance(exponent, se.Rational):
        p, q = int(exponent.p), int(exponent.q)
        if q == 1:
            return (lambda a: _integer_power(a, p)), (base,)
        if q == 2:
            return (lambda a: _integer_power(root(a), p)), (base,)
        return (lambda a: _integer_power(a.root(q), p)), (base,)
    return (lambda a, b: (a.log() * b).exp()), (base, exponent)


def _angle(y: Any, x: Any) -> Any:
    """atan2(y, x); flint has a ball for what is not a number, too."""
    return flint.arb.atan2(y, x) if y.is_finite() and x.is_finite() else _NO_VALUE


def _integer_power(base: Any, n: int) -> Any:
    """base**n by squaring; flint's own power is not defined on balls that hold zero."""
    if n < 0:
        return 1 / _integer_power(base, -n)
    result = None
    while True:
        if n & 1:
            result = base if result is None else result * base
        n >>= 1
        if not n:
            return flint.arb(1) if result is None else result
        base = base * base
