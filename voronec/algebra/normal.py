"""Normal forms: expressions brought to their shortest proved form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.field import WORK_LIMIT, Fraction
from voronec.algebra.generators import TRIGONOMETRIC, distance_powers, holds_far_multiples
from voronec.algebra.graphs import nodes
from voronec.algebra.ring import Ring
from voronec.algebra.roots import ring_over
from voronec.algebra.shape import expand_element, expression
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.terms import atoms, is_exponential
from voronec.algebra.text import as_expression
from voronec.errors import EngineLimit

JUMPS = (se.sign, se.Abs, se.floor)


@dataclass(frozen=True)
class Budget:
    """What a normal form may cost: term products that are made on the way (``work``), and ``terms``
    that are left in the end.  Both are counted, so that what is given up depends on the input
    alone; ``EngineLimit`` says what it was."""

    work: int = WORK_LIMIT
    terms: float = inf

    def check(self, elements: Sequence[Fraction]) -> None:
        """Refuse elements with more terms in all."""
        count = sum(len(e.num) for e in elements)
        if count > self.terms:
            raise EngineLimit(
                f"the normal form has {count} terms, more than its budget of {self.terms}"
            )


PLENTY = Budget()
"""As many terms as come."""


def shortest(
    exprs: Sequence[Any],
    relations: Sequence[Any] = (),
    group: Sequence[Any] = (),
    budget: Budget = PLENTY,
) -> list[Any]:
    """Each symengine expression in its shortest proved form, all over one ring.

    ``relations`` vanish; ``group`` are symbols by which numerators may be collected.  Raises
    ``EngineLimit`` where the normal form is beyond the budget.
    """
    exprs = _with_short_arguments(exprs, relations, budget)
    ring, elements = _fractions(exprs, relations, budget, group=group)
    forms = [expression(ring, e, group) for e in elements]
    return [_shorter(e, f) for e, f in zip(exprs, forms, strict=True)]


def _shorter(before: Any, after: Any) -> Any:
    """An expression with exponentials as it was, where that is shorter: sums of quotients, brought
    over one denominator, lose the digits of what is small, and leave doubles."""
    parts = nodes([se.sympify(before), after])
    if not any(isinstance(n, se.sinh | se.cosh) or is_exponential(n) for n in parts):
        return after
    return before if se.count_ops(before) < se.count_ops(after) else after


def canonical(
    exprs: Sequence[Any], relations: Sequence[Any] = (), budget: Budget = PLENTY,
    split: bool = False,
) -> list[Any]:  # fmt: skip
    """Each symengine expression as an expanded fraction: what ``shortest`` starts from."""
    exprs = _with_short_arguments(exprs, relations, budget)
    ring, elements = _fractions(exprs, relations, budget, split=split)
    return [expand_element(ring, e) for e in elements]


def _fractions(
    exprs: Sequence[Any], relations: Sequence[Any], budget: Budget,
    split: bool = False, group: Sequence[Any] = (),
) -> tuple[Ring, list[Fraction]]:  # fmt: skip
    """The ring where relations vanish, and the expressions as fractions in it."""
    ring = ring_over([*exprs, *group], relations, budget.work, split)
    elements = [ring.field.absorb(ring.fraction(e)) for e in exprs]
    budget.check(elements)
    return ring, elements


def _with_short_arguments(
    exprs: Sequence[Any], relations: Sequence[Any], budget: Budget
) -> Sequence[Any]:
    """Expressions with what jumps, or has a corner, of arguments in their shortest form: the ring
    takes sign(v sin(x)^2 + v cos(x)^2) for a letter of its own, which is sign(v). So are roots of
    squares, |f|, where f loses a symbol; else they stay, lest |2 f| be another letter than |f|."""
    corners = {node: _corner(node) for node in nodes(map(se.sympify, exprs))}
    jumps = [node for node, inner in corners.items() if inner is not None and inner.args]
    if not jumps:
        return exprs
    before = [corners[node] for node in jumps]
    try:
        after = shortest(before, relations, budget=budget)
    except EngineLimit:  # they are right as they stand
        return exprs
    short = {n: _of(n, a) for n, b, a in zip(jumps, before, after, strict=True) if a != b}
    return [se.sympify(e).xreplace(short) for e in exprs]


def _corner(node: Any) -> Any | None:
    """The argument of what jumps or has a corner: f in sign(f), |f|, sqrt(f^2); None of others."""
    if isinstance(node, JUMPS):
        return node.args[0]
    if not isinstance(node, se.Pow) or isinstance(node.args[1], se.Integer):
        return None
    base = node.args[0]
    return base.args[0] if isinstance(base, se.Pow) and base.args[1] == 2 else None


def _of(node: Any, argument: Any) -> Any:
    """The function of a node at another argument."""
    if isinstance(node, JUMPS):
        return node.func(argument)
    fewer = argument.free_symbols < node.free_symbols
    return (argument**2) ** node.args[1] if fewer else node


def canonical_for_numbers(exprs: Sequence[Any], ground: Any, budget: Budget = PLENTY) -> list[Any]:
    """Canonical forms where the relations of a ``ground`` vanish, with what loses digits as it
    stands: powers of distances, and sines and cosines of many-fold angles, which are expanded in
    those of the angle."""
    far = holds_far_multiples(exprs)
    angles = sorted(atoms(exprs, *TRIGONOMETRIC), key=str) if far else []
    powers = distance_powers(exprs, (*ground.coordinates, *ground.velocities, ground.time))
    folds = {node: se.Symbol(f"fold {i}") for i, node in enumerate([*angles, *powers])}
    forms = canonical([e.xreplace(folds) for e in exprs], ground.relations, budget)
    back = {name: node for node, name in folds.items()}
    return [e.xreplace(back) for e in forms]


def quotient(expr: Any, relations: Sequence[Any] = ()) -> tuple[Any, Any]:
    """Numerator and denominator of a symengine expression, without common factors."""
    ring = ring_over([expr], relations)
    element = ring.field.absorb(ring.fraction(expr))
    return ring.polynomial(element.num), ring.polynomial(ring.field.denominator(element.den))


def without_denominators(row: Sequence[Any], relations: Sequence[Any] = ()) -> list[Any]:
    """A multiple of a row of expressions in which none has a denominator, each in its shortest
    form."""
    common = se.Integer(1)
    for e in row:
        (scaled,) = shortest([e * common], relations)
        common *= se.sympify(sp.fraction(sp.together(as_expression(scaled)))[1])
    return shortest([e * common for e in row], relations)


def shorten(exprs: Sequence[Any], relations: Sequence[Any] = ()) -> list[sp.Expr]:
    """Each SymPy expression in its shortest proved form; ``relations`` are taken as zero.

    Equal to what went in wherever both are defined, by exact algebra and nothing else.  Raises
    ``EngineLimit`` where the normal form is beyond the work limit.
    """
    bridge = SymPyBridge()
    inside = shortest(bridge.inward_all(exprs), bridge.inward_all(relations))
    return [bridge.outward(e) for e in inside]
