"""Units of letters, which follow from the Lagrangian of a system: a formula is balanced or not.

A unit is a scaling: a weight of every symbol, and of the time, such that the Lagrangian, the
constraints, and the forces are multiplied by powers of one number.  It takes motions of the system
to motions, so that the terms of what is true for all of them have equal weights, or vanish apart.
Units of mass, length and time are such; there may be more, as that of an angle that no sine holds.
Of what the system does not hold nothing is known, and then nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import flint
import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import time, velocity
from voronec.algebra.text import as_expression
from voronec.audit.latex.nodes import (
    Bound,
    Chain,
    Elementary,
    Integral,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Root,
    Sum,
)
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.structure import integrand, names_constant
from voronec.audit.study import Study
from voronec.audit.transcript import assignments

Weight = tuple[flint.fmpq, ...]
VARIATION = "variation"
"""The key of the small number that a variation bears."""
PURE = (sp.sin, sp.cos, sp.tan, sp.cot, sp.sinh, sp.cosh, sp.tanh, sp.exp, sp.log, sp.asin, sp.acos)
"""Functions of numbers without a unit, whose values have none."""


class _Silent(Exception):
    """Something of which no unit is known."""


class _UnitConflict(Exception):
    """Terms of different units are added, or a sine is taken of what has one."""


@dataclass(frozen=True)
class _Scale:
    """Weights of expressions from those of their symbols; ``same`` is told what must agree.

    ``None`` is the weight of zero, which has any.
    """

    weights: Mapping[Any, Weight]
    size: int
    same: Callable[[Weight, Weight], None]

    @property
    def none(self) -> Weight:
        """The weight of a number."""
        return (flint.fmpq(0),) * self.size

    def of(self, expr: Any) -> Weight | None:
        """The weight of an expression, or the one that all entries of a matrix have."""
        if isinstance(expr, sp.MatrixBase):
            return self.common_weight(self.of(entry) for entry in expr)
        if expr == 0:
            return None
        if expr in self.weights:
            return self.weights[expr]
        if not expr.args or expr.is_number:
            return self._number(expr)
        return self._whole(expr)

    def _number(self, expr: Any) -> Weight:
        if expr.is_number:
            return self.none
        raise _Silent

    def _whole(self, expr: Any) -> Weight | None:
        if expr.is_Add:
            return self.common_weight(self.of(term) for term in expr.args)
        if expr.is_Mul:
            return self.product(self.of(factor) for factor in expr.args)
        if expr.is_Pow and expr.exp.is_Rational:
            return self.power(self.of(expr.base), expr.exp)
        if isinstance(expr, AppliedUndef):
            return self._leaf(_name(expr))
        if isinstance(expr, sp.Derivative):
            return self._slope(expr)
        if isinstance(expr, PURE):
            return self.pure(self.of(expr.args[0]))
        raise _Silent

    def _leaf(self, key: Any) -> Weight:
        if key not in self.weights:
            raise _Silent
        return self.weights[key]

    def _slope(self, expr: sp.Derivative) -> Weight | None:
        below = self.product(self.power(self.of(x), n) for x, n in expr.variable_count)
        return self.product([self.of(expr.expr), self.power(below, -1)])

    def common_weight(self, several: Iterable[Weight | None]) -> Weight | None:
        """The weight of terms, which must be one and the same."""
        known = [weight for weight in several if weight is not None]
        for weight in known[1:]:
            self.same(known[0], weight)
        return known[0] if known else None

    def product(self, several: Iterable[Weight | None]) -> Weight | None:
        """The weight of a product."""
        known = list(several)
        weights: list[Weight] = [weight for weight in known if weight is not None]
        if len(weights) < len(known):
            return None
        return reduce(lambda a, b: tuple(x + y for x, y in zip(a, b, strict=True)), weights)

    def power(self, weight: Weight | None, exponent: Any) -> Weight | None:
        """The weight of a power."""
        if weight is None:
            return None
        p, q = sp.Rational(exponent).as_numer_denom()
        return tuple(x * flint.fmpq(int(p), int(q)) for x in weight)

    def pure(self, weight: Weight | None) -> Weight:
        """The weight of a sine, whose argument has none."""
        if weight is not None:
            self.same(weight, self.none)
        return self.none


def _name(function: Any) -> str:
    return f"{function.func.__name__}()"


@dataclass(frozen=True)
class Units:
    """The weights of the symbols of a system under each scaling that it allows."""

    scale: _Scale

    @classmethod
    def of(cls, study: Study) -> Units | None:
        """Those of the system from which a dictionary was made; ``None`` without one."""
        system = study.declared_system
        if system is None or not hasattr(system, "lagrangian"):
            return None
        keys = _keys(system, study)
        size = len(keys)
        units = {key: _unit(size, at) for at, key in enumerate(keys)}
        rows: list[Weight] = []
        scale = _Scale(
            {**units, **_rates(units, size)},
            size,
            lambda a, b: rows.append(tuple(x - y for x, y in zip(a, b, strict=True))),
        )
        try:
            _homogeneous(system, scale)
        except _Silent:
            return None
        for left, right in _rules(study, scale.weights[VARIATION], scale):
            scale.common_weight([left, right])
        return cls(_solve_scale(scale, rows))

    def is_unbalanced(self, chain: Chain, study: Study) -> bool:
        """Whether a formula certainly adds or equates what has different units."""
        try:
            self._dimension(chain, study)
        except _UnitConflict:
            return True
        except SENSELESS:
            return False  # what it means is told elsewhere
        return False

    def dimension(self, chain: Chain, study: Study) -> Weight | None:
        """The weight of the sides of a balanced formula; ``None`` where nothing is known of it."""
        try:
            return self._dimension(chain, study)
        except (_UnitConflict, *SENSELESS):
            return None

    def _dimension(self, chain: Chain, study: Study) -> Weight | None:
        common: Weight | None = None
        for where in assignments(chain, study):
            spoken = [p for p in chain.parts if not names_constant(p)]
            parts = [_Weights(self.scale, study, where).weight(p) for p in spoken]
            common = self.scale.common_weight([weight for weight in parts if weight != SILENT])
        return common


SILENT: Any = ()
"""The weight of a part of a formula of whose unit nothing is known."""


@dataclass(frozen=True)
class _Weights:
    """Weights of the parts of a formula as it is printed; ``SILENT`` where nothing is known."""

    scale: _Scale
    study: Study
    where: Mapping[str, int]

    def weight(self, node: Node) -> Weight | None:
        """The weight of a part; all that is added in it must agree."""
        if isinstance(node, Sum):
            terms = [self.weight(term) for _, term in node.terms]
            common = self.scale.common_weight(t for t in terms if t != SILENT)
            return SILENT if SILENT in terms and common is None else common
        if isinstance(node, Product):
            return self._join([self.weight(factor) for factor in node.factors])
        if isinstance(node, Quotient):
            top, bottom = self.weight(node.top), self.weight(node.bottom)
            return self._join([top, self._power(bottom, -1)])
        if isinstance(node, Power) and isinstance(node.exponent, Number):
            return self._power(self.weight(node.base), node.exponent.text)
        if isinstance(node, Root) and node.index is None:
            return self._power(self.weight(node.body), sp.Rational(1, 2))
        if isinstance(node, Elementary) and node.function in ("sin", "cos", "tan", "cot"):
            inside = self.weight(node.argument)
            return self.scale.pure(None if inside == SILENT else inside)
        if isinstance(node, Integral):
            return self._integral(node)
        return self._value(node)

    def _integral(self, node: Integral) -> Weight | None:
        """The integrand's times that of the variable, which both limits must have."""
        variable, body = integrand(node)
        ends = [self.weight(part) for part in (variable, node.lower, node.upper) if part]
        along = self.scale.common_weight(weight for weight in ends if weight != SILENT)
        return self._join([self.weight(body), SILENT if along is None else along])

    def _join(self, factors: list[Weight | None]) -> Weight | None:
        return SILENT if SILENT in factors else self.scale.product(factors)

    def _power(self, weight: Weight | None, exponent: Any) -> Weight | None:
        return weight if weight == SILENT else self.scale.power(weight, exponent)

    def _value(self, node: Node) -> Weight | None:
        if isinstance(node, Bound):
            return SILENT
        try:
            value = evaluate(node, self.study, self.where)
            return self.scale.of(as_expression(value)) if value is not None else SILENT
        except (*SENSELESS, _Silent, _UnitConflict):
            return SILENT  # a derived value need not be written term by term


def _keys(system: Any, study: Study) -> list[Any]:
    """What has a unit of its own: symbols that are no rates of others, and unknown functions."""
    exprs = [system.lagrangian, *system.constraints, *system.forces.values()]
    frame = system.frame
    if frame is not None:
        exprs += [*frame.velocities, *(frame.expressions if frame.brackets is None else ())]
    moving = [*system.coordinates, *(frame.velocities if frame is not None else ())]
    dots = {velocity(x) for x in moving} | {velocity(velocity(x)) for x in moving}
    symbols = {s for e in exprs for s in as_expression(e).free_symbols} | set(system.coordinates)
    functions = {_name(f) for e in exprs for f in as_expression(e).atoms(AppliedUndef)}
    varied = {x for e in study.variations.values() for x in as_expression(e).free_symbols}
    fresh = varied - symbols - dots - {velocity(x) for x in varied}
    fresh |= {sp.Symbol(name) for name in system.invariants} | {*study.units}
    plain = sorted((symbols | fresh | {time}) - dots, key=str)
    return [VARIATION, *plain, *sorted(functions)]


def _unit(size: int, at: int) -> Weight:
    return tuple(flint.fmpq(int(i == at)) for i in range(size))


def _rates(units: Mapping[Any, Weight], size: int) -> dict[Any, Weight]:
    """The weights of velocities and accelerations: one time less, two times less."""
    rates: dict[Any, Weight] = {}
    for key, weight in units.items():
        if isinstance(key, sp.Symbol) and key != time:
            rate, symbol = weight, key
            for _ in range(2):
                rate = tuple(x - y for x, y in zip(rate, units[time], strict=True))
                symbol = velocity(symbol)
                rates[symbol] = rate
    return {key: weight for key, weight in rates.items() if key not in units}


def _homogeneous(system: Any, scale: _Scale) -> None:
    """Everything that defines a system is of one weight; forces are such that work is energy."""
    energy = scale.of(system.lagrangian)
    for constraint in (*system.constraints, *system.fibration.relations):
        scale.of(constraint)
    for place, force in system.forces.items():
        scale.common_weight([energy, scale.product([scale.of(place), scale.of(force)])])
    frame = system.frame
    if frame is not None and frame.brackets is None:
        for name, value in zip(frame.velocities, frame.expressions, strict=True):
            scale.common_weight([scale.of(name), scale.of(value)])


def _rules(
    study: Study, small: Weight, scale: _Scale
) -> Iterator[tuple[Weight | None, Weight | None]]:
    """What a dictionary sets equal, as far as units of it are known; a variation is a small number
    times what is varied."""
    invariants = [
        (sp.Symbol(name), value) for name, value in study.declared_system.invariants.items()
    ]
    pairs = [*study.given.items(), *study.units.items(), *invariants]
    pairs += [(relation, sp.Integer(0)) for relation in study.relations]
    for left, right in pairs:
        try:
            yield scale.of(left), scale.of(right)
        except _Silent:
            continue
    for symbol, change in study.variations.items():
        try:
            yield scale.product([small, scale.of(symbol)]), scale.of(change)
        except _Silent:
            continue


def _solve_scale(scale: _Scale, rows: list[Weight]) -> _Scale:
    """A scale in the weights that all equations allow."""
    table = [[int(x * _common(row)) for x in row] for row in dict.fromkeys(rows)]
    whole = flint.fmpz_mat(table or [[0] * scale.size])
    kernel, count = whole.nullspace()
    basis = [[flint.fmpq(kernel[i, j]) for i in range(scale.size)] for j in range(count)]

    def substitute(weight: Weight) -> Weight:
        return tuple(
            sum((a * b for a, b in zip(weight, one, strict=True)), flint.fmpq(0)) for one in basis
        )

    return _Scale({k: substitute(w) for k, w in scale.weights.items()}, count, _differ)


def _common(row: Weight) -> int:
    return int(reduce(lambda a, b: a * b.q, row, flint.fmpz(1)))


def _differ(left: Weight, right: Weight) -> None:
    if left != right:
        raise _UnitConflict
