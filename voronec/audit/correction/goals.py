"""The value that each part of a false formula ought to have, at the point where it fails."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from voronec.audit.comparisons import accelerations
from voronec.audit.correction.sampling import Sampler, close
from voronec.audit.correction.slots import Slot, plant
from voronec.audit.display import Check
from voronec.audit.hooks import call_hook
from voronec.audit.latex.nodes import Chain, Node
from voronec.audit.structure import names_constant, new_names, whole_name
from voronec.audit.study import Study

__all__ = ["Where", "along", "holds", "slots_of"]

Where = dict[str, int]


def slots_of(
    chain: Chain, check: Check, study: Study, sampler: Sampler, where: Where
) -> list[Slot] | None:
    """The parts of both sides of the first equality that fails; ``None`` where none does."""

    def value(node: Node) -> Any:
        return sampler.value(node, where)

    if check.value is not None:
        return _against_value(chain, check, sampler, where)
    for left, right in _links(chain, check, study):
        goals = _goals(left, right, check, sampler, where)
        if goals is not None:
            found = plant(left, [value(right) + goal for goal in goals], value)
            return found + plant(right, [value(left) - goal for goal in goals], value)
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


def _against_value(chain: Chain, check: Check, sampler: Sampler, where: Where) -> list[Slot] | None:
    """The parts of the first side that has not the derived value."""
    derived = call_hook(check.value, sampler.study, where) if check.value else 0
    goal = sampler.number_of(derived)
    for part in chain.parts:
        value = sampler.value(part, where)
        wanted = goal if np.ndim(goal) else 0.0 * value + goal
        if not close(value, wanted):
            return plant(part, [wanted], lambda node: sampler.value(node, where))
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
