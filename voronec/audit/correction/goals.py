"""The value that each part of a false formula ought to have, at the point where it fails.

A formula is a tree of places, each with the value that would make the formula true.  If all but one
place is right, its value is determined by the rest: the goal goes down from the whole to the parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.audit.comparisons import accelerations
from voronec.audit.correction.sampling import Sampler, close
from voronec.audit.display import Check
from voronec.audit.hooks import call_hook
from voronec.audit.latex.nodes import Chain, Node, Number, Power, Product, Quotient, Root, Sum
from voronec.audit.meaning import SENSELESS
from voronec.audit.structure import names_constant, new_names, whole_name
from voronec.audit.study import Study

__all__ = ["MendingPlace", "Where", "along", "holds", "slots_of"]


Where = dict[str, int]


def slots_of(
    chain: Chain, check: Check, study: Study, sampler: Sampler, where: Where
) -> list[MendingPlace] | None:
    """The parts of both sides of the first equality that fails; ``None`` where none does."""

    def value(node: Node) -> Any:
        return sampler.value(node, where)

    if check.value is not None:
        return _against_value(chain, check, sampler, where)
    for left, right in _links(chain, check, study):
        goals = _goals(left, right, check, sampler, where)
        if goals is not None:
            found = _plant(left, [value(right) + goal for goal in goals], value)
            return found + _plant(right, [value(left) - goal for goal in goals], value)
    return None


def holds(chain: Chain, check: Check, study: Study, sampler: Sampler, where: Where) -> bool:
    """Whether all equalities of a formula hold at a point, as far as numbers tell."""
    if check.value is not None:
        return _against_value(chain, check, sampler, where) is None
    links = _links(chain, check, study)
    return all(_goals(left, right, check, sampler, where) is None for left, right in links)


def _goals(
    left: Node, right: Node, check: Check, sampler: Sampler, where: Where
) -> list[Any] | None:
    """What left minus right should be, where it is not."""
    a, b = sampler.value(left, where), sampler.value(right, where)
    goals = [0.0 * a] if check.truth is None else _truths(left, right, check, sampler, where)
    return None if any(close(a - b, goal, a) for goal in goals) else goals


def along(check: Check) -> bool:
    """Whether the verdict compares values along the motion, or only on the constraints."""
    return check.truth is None and check.value is None


def _against_value(
    chain: Chain, check: Check, sampler: Sampler, where: Where
) -> list[MendingPlace] | None:
    """The parts of the first side that has not the derived value."""
    derived = call_hook(check.value, sampler.study, where) if check.value else 0
    goal = sampler.number_of(derived)
    for part in chain.parts:
        value = sampler.value(part, where)
        wanted = goal if np.ndim(goal) else 0.0 * value + goal
        if not close(value, wanted):
            return _plant(part, [wanted], lambda node: sampler.value(node, where))
    return None


def _links(chain: Chain, check: Check, study: Study) -> Iterator[tuple[Node, Node]]:
    """Neighbouring parts between which equality is claimed; names defined here are left out."""
    new = new_names(chain, study) if check.role == "definition" else set[str]()
    last: Node | None = None
    for relation, part in zip(("", *chain.relations), chain.parts, strict=True):
        if relation != "=":
            last = None
        if names_constant(part) or whole_name(part, study) in new:
            continue
        if last is not None:
            yield last, part
        last = part


def _truths(left: Node, right: Node, check: Check, sampler: Sampler, where: Where) -> list[float]:
    """What left minus right should be: the truth, its negative, or with the factor in print.

    The factor is seen where the accelerations move.
    """
    assert check.truth is not None
    study = sampler.study
    truth = check.truth(study, where).xreplace(dict(study.given))
    here = sampler.number(truth)
    other = Sampler(study, sampler.seed, accelerations(study))
    moved = other.number(truth)
    goals = [here, -here]
    if not close(moved, here):
        now = sampler.value(left, where) - sampler.value(right, where)
        then = other.value(left, where) - other.value(right, where)
        factor = (then - now) / (moved - here)
        if factor and not close(abs(factor), 1.0):
            goals.append(factor * here)
    return goals


Value = Callable[[Node], Any]


@dataclass(frozen=True, eq=False)
class MendingPlace:
    """A part of the formula, with its value, and the values that would mend the whole."""

    node: Node
    value: Any
    goals: tuple[Any, ...]
    parent: MendingPlace | None = None

    @property
    def at(self) -> tuple[int, int]:
        """The place in the source."""
        return tuple(self.node.at)


_Branch = tuple[Node, Callable[[Any], Sequence[Any]]]
"""A child, and what the goal of its parent asks of it."""


def _plant(
    node: Node, goals: Sequence[Any], value: Value, parent: MendingPlace | None = None
) -> list[MendingPlace]:
    """The slots of a tree, the whole first."""
    own = value(node)
    slot = MendingPlace(node, own, tuple(goals), parent)
    found = [slot]
    try:
        branches = _branches(node, own, value)
    except SENSELESS:
        return found
    for part, down in branches:
        try:
            found += _plant(part, [g for goal in goals for g in down(goal)], value, slot)
        except SENSELESS:
            continue
    return found


def _branches(node: Node, own: Any, value: Value) -> list[_Branch]:
    if isinstance(node, Sum):
        return [_term(sign, term, own, value(term)) for sign, term in node.terms]
    if isinstance(node, Product):
        return [_factor(node, i, value) for i in range(len(node.factors))]
    if isinstance(node, Quotient):
        top, bottom = value(node.top), value(node.bottom)
        above: _Branch = (node.top, lambda goal: [goal * bottom])
        return [above] if np.ndim(top) else [above, (node.bottom, lambda goal: [_over(top, goal)])]
    if isinstance(node, Power) and isinstance(node.exponent, Number) and not np.ndim(own):
        n = int(node.exponent.text)
        return [(node.base, lambda goal: _roots(goal, n))]
    if isinstance(node, Root) and node.index is None:
        return [(node.body, lambda goal: [goal**2] if goal >= 0 else [])]
    return []


def _term(sign: int, term: Node, own: Any, here: Any) -> _Branch:
    return term, lambda goal: [here + sign * (goal - own)]


def _factor(node: Product, position: int, value: Value) -> _Branch:
    """The other factors must be numbers, for a goal to be divided by them."""
    others = [value(f) for i, f in enumerate(node.factors) if i != position]
    rest = 0 if any(np.ndim(v) for v in others) else math.prod(others)
    return node.factors[position], lambda goal: [goal / rest] if rest else []


def _over(top: Any, bottom: Any) -> float:
    return float(top) / float(bottom) if bottom else math.nan


def _roots(goal: Any, n: int) -> list[float]:
    if goal < 0 and n % 2 == 0:
        return []
    root = math.copysign(abs(goal) ** (1 / n), goal)
    return [root, -root] if n % 2 == 0 else [root]
