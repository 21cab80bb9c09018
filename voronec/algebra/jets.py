"""Taylor polynomials of functions and of vector fields about a point, with rational coefficients.

A function is the list of its homogeneous parts in h = x - x0; of a product they are the
convolution, and of f(a) they follow from Euler's identity, k f(a)_k = sum_i i a_i f'(a)_(k - i),
with the same recurrences as those of Taylor's method in one variable.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import factorial, lcm
from typing import Any

import flint
import symengine as se
import sympy as sp

from voronec.algebra.memo import remember
from voronec.algebra.numeric_functions import elementary
from voronec.algebra.ring import MANY_FOLD
from voronec.algebra.text import as_expression
from voronec.errors import EngineLimit

_T = sp.Symbol("t", real=True)
Parts = list[Any]
"""Homogeneous parts, those of order 0 first."""


class Expansion:
    """Expansions about ``point``, which gives an exact number to every symbol; symbols among
    ``variables`` move.

    ``EngineLimit`` where a value there is no rational number, or a function has no recurrence.
    """

    def __init__(self, point: Mapping[Any, Any], variables: Sequence[Any], order: int) -> None:
        places = [x for x in map(as_expression, point.values()) if x.is_Rational]
        self._unit = sp.Rational(1, lcm(*(int(x.q) for x in places)))
        names = [*(f"h{i}" for i in range(len(variables))), "t"]
        self._context = flint.fmpq_mpoly_ctx.get(names, flint.Ordering.degrevlex)
        self._order = order
        # each variable is its value and a step from there, which has a letter of its own
        letters = [se.Symbol(f"step of {x}") for x in variables]
        self._moved = {x: point[x] + step for x, step in zip(variables, letters, strict=True)}
        self._point = {**point, **dict.fromkeys(letters, se.Integer(0))}
        gens = self._context.gens()[: len(letters)]
        self._steps = dict(zip([*variables, *letters], [*gens, *gens], strict=True))
        self._zero = self._context.constant(0)
        self._known: dict[Any, Parts] = {}
        self._values: dict[Any, Any] = {}

    def field(self, components: Sequence[Any]) -> FieldJet:
        """A vector field by its components along the variables."""
        return FieldJet(tuple(tuple(self.of(se.sympify(e))) for e in components))

    @remember("_known")
    def of(self, expr: Any) -> Parts:
        """The parts of an expression, of order 0, 1, ..."""
        if expr in self._steps:
            return [self._value(expr), self._steps[expr], *self._blank(2)]
        if not expr.free_symbols & self._steps.keys():
            return [self._value(expr), *self._blank(1)]
        if isinstance(expr, se.Add):
            columns = zip(*map(self.of, expr.args), strict=True)
            return [sum(column, self._zero) for column in columns]
        if isinstance(expr, se.Mul):
            total = self.of(expr.args[0])
            for factor in expr.args[1:]:
                total = self._product(total, self.of(factor))
            return total
        return self._function(expr)

    def _blank(self, first: int) -> Parts:
        return [self._zero] * (self._order + 1 - first)

    @remember("_values")
    def _value(self, expr: Any) -> Any:
        """The exact value at the point, rational in t where it holds sines of numbers."""
        value = as_expression(expr.xreplace(self._point))
        if value.has(sp.zoo):
            raise EngineLimit(f"'{as_expression(expr)}' is singular at this point; give another")
        if value.has(sp.sin, sp.cos, sp.tan):
            value = sp.expand(sp.expand_trig(value))  # of 2*atan(3/4), say
            value = value.xreplace({f: self._rational_in_t(f) for f in value.atoms(sp.sin, sp.cos)})
        if value.is_Rational:
            return self._context.constant(flint.fmpq(int(value.p), int(value.q)))
        above, below = (e.as_poly(_T) for e in sp.fraction(sp.together(value)))
        if above is None or below is None or not (above * below).domain.is_ZZ:
            raise EngineLimit(
                f"at this point '{as_expression(expr)}' = {value} is no rational number; give a "
                "point where all is rational, such as angles that are numbers or atan(3/4)"
            )
        still = [0 for _ in self._moved]
        return _Ratio.of(
            *(
                self._context.from_dict({(*still, e): int(c) for (e,), c in poly.terms()})
                for poly in (above, below)
            )
        )

    def _rational_in_t(self, function: sp.Expr) -> sp.Expr:
        """Cosine or sine of k/d, with t = tan(1/(2 d)), which is transcendental: real and imaginary
        part of (1 + i t)^(2 k)/(1 + t^2)^k."""
        fold = function.args[0] / self._unit
        if not fold.is_Integer or abs(fold) > MANY_FOLD:
            return function
        parts = sp.expand((1 + sp.I * _T) ** (2 * abs(fold))).as_real_imag()
        part = parts[0] if isinstance(function, sp.cos) else sp.sign(fold) * parts[1]
        return part / (1 + _T**2) ** abs(fold)

    def _product(self, a: Parts, b: Parts) -> Parts:
        pairs = range(self._order + 1)
        return [
            sum((a[i] * b[k - i] for i in range(k + 1) if a[i] != 0 and b[k - i] != 0), self._zero)
            for k in pairs
        ]

    def _function(self, expr: Any) -> Parts:
        """f(a) = f(a_0) + f'(a_0) (a - a_0) + ...; of some functions in terms of others."""
        if not isinstance(expr, _SMOOTH):
            spelled = _BY_SINES.get(type(expr))
            plain = se.sympify(spelled(*expr.args)) if spelled else elementary(expr)
            if plain == expr:
                name = as_expression(expr)
                raise EngineLimit(f"'{name}' has no expansion here; use smooth functions")
            return self.of(plain)
        inner = expr.args[-1]
        if isinstance(expr, se.Pow) and inner.is_Number:
            inner = expr.args[0]
            change = self.of(inner)
        elif isinstance(expr, se.Pow) and expr.args[0] != se.E:
            return self.of(se.exp(inner * se.log(expr.args[0])))
        else:
            change = self._angle_parts(inner)
        change = [self._zero, *change[1:]]
        argument = se.Symbol("argument")
        slope = expr.func(*[argument if a == inner else a for a in expr.args])
        total, power = [*self._blank(0)], [self._zero + 1, *self._blank(1)]
        for k in range(self._order + 1):
            factor = self._value(slope.xreplace({argument: inner})) * flint.fmpq(1, factorial(k))
            total = [a + factor * b for a, b in zip(total, power, strict=True)]
            power, slope = self._product(power, change), slope.diff(argument)
        return total

    def _angle_parts(self, expr: Any) -> Parts:
        """The parts of an angle above order 0; its own value, as pi/2, need not be rational."""
        constant = expr.xreplace(self._point)
        return self.of((expr.xreplace(self._moved) - constant).expand())


_SMOOTH = (se.sin, se.cos, se.log, se.Pow)
_BY_SINES: dict[type, Callable[..., Any]] = {
    se.tan: lambda a: se.sin(a) / se.cos(a),
    se.cot: lambda a: se.cos(a) / se.sin(a),
    se.sec: lambda a: 1 / se.cos(a),
    se.csc: lambda a: 1 / se.sin(a),
    se.sinh: lambda a: (se.exp(a) - se.exp(-a)) / 2,
    se.cosh: lambda a: (se.exp(a) + se.exp(-a)) / 2,
    se.tanh: lambda a: 1 - 2 / (se.exp(2 * a) + 1),
}


@dataclass(frozen=True)
class _Ratio:
    """A polynomial over one in t, the last generator, without common factors."""

    above: Any
    below: Any

    @classmethod
    def of(cls, above: Any, below: Any) -> _Ratio:
        """In lowest terms."""
        common = above.gcd(below)
        return cls(above / common, below / common)

    def __add__(self, other: Any) -> _Ratio:
        if not isinstance(other, _Ratio):
            return _Ratio(self.above + other * self.below, self.below)
        above = self.above * other.below + other.above * self.below
        return _Ratio.of(above, self.below * other.below)

    def __mul__(self, other: Any) -> _Ratio:
        if not isinstance(other, _Ratio):
            return _Ratio.of(self.above * other, self.below)
        return _Ratio.of(self.above * other.above, self.below * other.below)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> _Ratio:
        return _Ratio(-self.above, self.below)

    def __sub__(self, other: Any) -> _Ratio:
        return self + -other

    def __rsub__(self, other: Any) -> _Ratio:
        return -self + other

    def __truediv__(self, other: Any) -> _Ratio:
        return self * (flint.fmpq(1) / other)

    def __rtruediv__(self, other: Any) -> _Ratio:
        return _Ratio(self.below, self.above) * other

    def __eq__(self, other: object) -> bool:
        return bool(self.above == other * self.below)

    def derivative(self, j: int) -> _Ratio:
        """By another generator than t."""
        return _Ratio.of(self.above.derivative(j), self.below)

    def to_dict(self) -> dict[Any, Any]:
        """The coefficients, of powers of t together."""
        coefficients: dict[Any, Any] = {}
        t = self.above.context().gens()[-1]
        for monomial, c in self.above.to_dict().items():
            key = (*monomial[:-1], 0)
            coefficients[key] = coefficients.get(key, 0 * t) + c * t ** int(monomial[-1])
        return {key: _Ratio.of(above, self.below) for key, above in coefficients.items()}


def _number(constant: Any) -> Any:
    """The value of a constant."""
    return next(iter(constant.to_dict().values()), flint.fmpq(0))


@dataclass(frozen=True)
class FieldJet:
    """A vector field by the homogeneous parts of its components; brackets lose one order."""

    components: tuple[tuple[Any, ...], ...]

    @property
    def value(self) -> dict[Any, Any]:
        """The vector at the point: {component: number}, those that are not zero."""
        vector = {i: _number(parts[0]) for i, parts in enumerate(self.components)}
        return {i: x for i, x in vector.items() if x != 0}

    @property
    def coefficients(self) -> dict[Any, Any]:
        """All coefficients that are not zero, by component and monomial."""
        return {
            (i, monomial): c
            for i, parts in enumerate(self.components)
            for part in parts
            for monomial, c in part.to_dict().items()
        }

    def shorten(self, order: int) -> FieldJet:
        """The jet up to an order."""
        return FieldJet(tuple(parts[: order + 1] for parts in self.components))

    def bracket(self, other: FieldJet) -> FieldJet:
        """[X, Y] = X_j d_j Y - Y_j d_j X, as far as both are known."""
        order = min(len(self.components[0]), len(other.components[0])) - 2
        rows = []
        for x, y in zip(self.components, other.components, strict=True):
            rows.append(tuple(_along(self, y, k) - _along(other, x, k) for k in range(order + 1)))
        return FieldJet(tuple(rows))


def _along(field: FieldJet, function: Sequence[Any], order: int) -> Any:
    """The part of an order of the derivative of a function along a field."""
    total = function[0] * 0
    for j, parts in enumerate(field.components):
        for k in range(order + 1):
            if parts[k] != 0 and function[order - k + 1] != 0:
                total += parts[k] * function[order - k + 1].derivative(j)
    return total


class Span:
    """The span of vectors {key: rational number}, by elimination."""

    def __init__(self) -> None:
        self._rows: dict[Any, dict[Any, Any]] = {}

    def __len__(self) -> int:
        return len(self._rows)

    def remainder(self, vector: Mapping[Any, Any]) -> dict[Any, Any]:
        """What is left of a vector; nothing where it lies in the span."""
        left = dict(vector)
        for pivot, row in self._rows.items():
            if pivot in left:
                factor = left[pivot] / row[pivot]
                for key, x in row.items():
                    left[key] = left.get(key, flint.fmpq(0)) - factor * x
        return {key: x for key, x in left.items() if x != 0}

    def add(self, vector: Mapping[Any, Any]) -> bool:
        """Take a vector in; whether it enlarges the span."""
        left = self.remainder(vector)
        if left:
            self._rows[next(iter(left))] = left
        return bool(left)
