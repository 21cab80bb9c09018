"""Floating-point values of formulas at one point: cheap, to find out what is worth a proof.

A tree is evaluated number by number; only its smallest parts, names and derivatives, are evaluated
symbolically, and each of them once.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Mapping
from functools import reduce
from operator import add
from typing import Any

import flint
import numpy as np
import sympy as sp

from voronec.algebra.points import sample_point
from voronec.algebra.precision import GENERIC
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.tape import Tape
from voronec.audit.latex.nodes import (
    Bound,
    Cross,
    Derivative,
    Listing,
    Name,
    Node,
    Number,
    Partial,
    Power,
    Product,
    Quotient,
    Root,
    Sum,
)
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.study import Study
from voronec.errors import DefinitionError, EngineLimit

Where = Mapping[str, int]
BITS = GENERIC
WORK = {Derivative: 60, Partial: 400}
"""How many derivatives are taken at a point: they cost more than all else together."""
TOLERANCE = 1e-9
"""Of doubles that went through a formula: far above rounding, far below any misprint."""


def close(a: Any, b: Any, scale: Any = 1.0) -> bool:
    """Whether two numbers, or two vectors, are equal as far as rounding shows."""
    if np.shape(a) != np.shape(b):
        return False
    return bool(_size(a - b) <= TOLERANCE * (_size(a) + _size(b) + _size(scale)))


def _size(value: Any) -> float:
    """Of a number, or of the largest entry of a vector."""
    return abs(value) if isinstance(value, float) else np.max(np.abs(value))


class Sampler:
    """Values at a random point, which lies on the relations of the study.

    ``moved`` are symbols that have other values than at the point of the same seed without them.
    Accelerations have the values of the motion if ``along`` is true, else values of their own.
    """

    def __init__(
        self,
        study: Study,
        seed: int = 0,
        moved: tuple[Any, ...] = (),
        along: bool = False,
    ) -> None:
        self.study, self.seed, self.along = study, seed, along
        self.bridge = SymPyBridge()
        relations = [r for r in self.bridge.inward_all(study.relations) if r != 0]
        self.point: dict[Any, Any] = sample_point((), relations, seed) if relations else {}
        self.moved = {self.bridge.inward(x) for x in moved}
        self.cache: dict[Any, Any] = {}
        self.spent: Counter[type] = Counter()

    def value(self, node: Node, where: Where) -> Any:
        """The number, or the array of a vector or matrix; ``SENSELESS`` errors where none is."""
        key = _key(node, where)
        known = self.cache.get(key)
        if known is None:
            known = self.cache[key] = self._value_of(node, where)
        if isinstance(known, Exception):
            raise known
        return known

    def has_met(self, node: Node, where: Where) -> bool:
        """Whether the value of a tree, by itself, was asked for before."""
        return _key(node, where) in self.cache

    def _value_of(self, node: Node, where: Where) -> Any:
        try:
            rule = _RULES.get(type(node))
            return self._symbolic(node, where) if rule is None else rule(node, where, self.value)
        except _Vectorial:
            return self._symbolic(node, where)
        except SENSELESS as error:
            return error

    def _symbolic(self, node: Node, where: Where) -> Any:
        try:
            self.spent[type(node)] += 1
            if self.spent[type(node)] > WORK.get(type(node), self.spent[type(node)]):
                raise EngineLimit("too many derivatives to take")
            return self.number_of(evaluate(node, self.study, where))
        except SENSELESS as error:
            return error

    def number_of(self, value: Any) -> Any:
        """The number of a symbolic value, under all that the verdict takes into account."""
        motion = self.study.motion
        value = motion.restrict(value).xreplace(dict(self.study.given))
        return self.number(motion.along(value) if self.along else value)

    def number(self, value: Any) -> Any:
        """The value of an expression, a vector or a matrix."""
        if isinstance(value, sp.MatrixBase):
            entries = [self.number(entry) for entry in value]
            return np.array(entries).reshape(value.shape)
        tape = Tape([self.bridge.inward(value)])
        for atom in tape.atoms:
            if atom not in self.point:
                self.point[atom] = self._draw(atom)
        result = tape.arb(self.point, BITS)[0]
        if not result.is_finite():
            raise DefinitionError("no real value at the point")
        return float(result.mid())

    def _draw(self, atom: Any) -> Any:
        """A positive number for even seeds; one of either sign for odd seeds."""
        mark = " moved" if atom in self.moved else ""
        source = random.Random(f"voronec {self.seed} {atom}{mark}")
        value = flint.fmpq(source.randint(120, 1400), 1009)
        return -value if self.seed % 2 and source.random() < 0.5 else value


def _key(node: Node, where: Where) -> tuple[Node, tuple[tuple[str, int], ...]]:
    return node, tuple(sorted(where.items()))


class _Vectorial(Exception):
    """A rule that only fits numbers met something else."""


Value = Callable[[Node, Where], Any]


def _scalar(value: Any) -> float:
    if np.ndim(value):
        raise _Vectorial
    return float(value)


def _power(node: Power, where: Where, value: Value) -> Any:
    base, exponent = _scalar(value(node.base, where)), _scalar(value(node.exponent, where))
    if base < 0 and exponent != round(exponent):
        raise DefinitionError("no real value at the point")
    return base**exponent


def _root(node: Root, where: Where, value: Value) -> Any:
    body = _scalar(value(node.body, where))
    if node.index is not None or body < 0:
        raise _Vectorial
    return body**0.5


def _sum(node: Sum, where: Where, value: Value) -> Any:
    terms = [sign * value(term, where) for sign, term in node.terms]
    if len({np.shape(t) for t in terms}) > 1:
        raise DefinitionError("a vector is added to a number")
    return reduce(add, terms)


def _product(node: Product, where: Where, value: Value) -> Any:
    return reduce(_times, [value(factor, where) for factor in node.factors])


def _times(a: Any, b: Any) -> Any:
    return np.matmul(a, b) if np.ndim(a) and np.ndim(b) else a * b


def _bound(node: Bound, where: Where, value: Value) -> Any:
    lower, upper = (_scalar(value(side, where)) for side in (node.lower, node.upper))
    if lower != round(lower) or upper != round(upper):
        raise DefinitionError("a sum runs over integers")
    indices = range(int(lower), int(upper) + 1)
    terms = [value(node.body, {**where, node.index.head: i}) for i in indices]
    return reduce(np.add, terms) if terms else 0.0


def _name(node: Name, where: Where, value: Value) -> Any:
    if not node.sub and not node.sup and node.head in where:
        return float(where[node.head])
    raise _Vectorial


def _cross(node: Cross, where: Where, value: Value) -> Any:
    left, right = (np.ravel(value(side, where)) for side in (node.left, node.right))
    return np.cross(left, right).reshape(3, 1)


def _listing(node: Listing, where: Where, value: Value) -> Any:
    left, right = (np.ravel(value(item, where)) for item in node.items)
    if node.bracket == "[":
        return np.cross(left, right).reshape(3, 1)
    return float(np.dot(left, right))


_RULES: dict[type, Callable[[Any, Where, Value], Any]] = {
    Number: lambda n, w, v: float(n.text),
    Name: _name,
    Sum: _sum,
    Product: _product,
    Quotient: lambda n, w, v: v(n.top, w) / _scalar(v(n.bottom, w)),
    Power: _power,
    Root: _root,
    Bound: _bound,
    Cross: _cross,
    Listing: _listing,
}
