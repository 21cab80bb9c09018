"""Numbers at a point sort out which changes of a formula are worth a proof.

The printed formula fails at that point; a changed one has to hold there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from voronec.audit.comparisons import accelerations
from voronec.audit.correction.sampling import Sampler, close
from voronec.audit.display import Check
from voronec.audit.hooks import call_hook
from voronec.audit.latex.nodes import Chain, Integral, Node, walk
from voronec.audit.latex.reader import read
from voronec.audit.meaning import SENSELESS
from voronec.audit.structure import names_constant, new_names, whole_name
from voronec.audit.study import Study
from voronec.audit.transcript import assignments

__all__ = ["Screen"]


Where = dict[str, int]
SEEDS = 12
"""Points at which a formula is tried: most letters are undefined at some, and a few suffice."""
FEWER = 4
"""For how many values of the free indices a changed formula is tried."""


class Screen:
    """A point at which a printed formula fails, and values of its free indices, ``where``.

    Where there is no such point, as where the formula has no value, it is some point.
    """

    def __init__(self, chain: Chain, check: Check, study: Study) -> None:
        self.check, self.study = check, study
        self.where: Where = {}
        self.truths: dict[tuple[int, ...], tuple[float, float]] = {}
        for seed in (*range(SEEDS), 0):
            self._stand_at(seed)
            try:
                wheres = assignments(chain, study)
                failing = next((w for w in wheres if not self._holds(chain, w)), None)
                if failing is not None:
                    self.where = failing
                    return
            except SENSELESS:
                continue

    def _stand_at(self, seed: int) -> None:
        """Take the point of a seed; ``moved`` is the same one with other accelerations."""
        along = self.check.truth is None and self.check.value is None  # else on the constraints
        self.sampler = Sampler(self.study, seed, along=along)
        self.moved = Sampler(self.study, seed, accelerations(self.study))
        self.truths.clear()

    def passes(self, latex: str) -> bool:
        """Whether a formula has a value and holds at the point, as far as it has numbers."""
        if self.check.stationary:
            return True
        try:
            chain = read(latex, self.study.vocabulary)
            if any(isinstance(part, Integral) for part in walk(chain)):
                return True
            wheres = assignments(chain, self.study)
            first = [where for where in wheres if where == self.where]
            return all(self._holds(chain, where) for where in (first + wheres)[:FEWER])
        except SENSELESS:
            return False

    def _holds(self, chain: Chain, where: Where) -> bool:
        """Whether all equalities of a formula hold."""
        if self.check.value is not None:
            return self._has_value(chain, self.check.value, where)
        return all(self._agree(left, right, where) for left, right in self._links(chain))

    def _has_value(self, chain: Chain, hook: Callable[..., Any], where: Where) -> bool:
        goal = self.sampler.number_of(call_hook(hook, self.study, where))
        values = (self.sampler.value(part, where) for part in chain.parts)
        return all(close(v, goal if getattr(goal, "ndim", 0) else 0.0 * v + goal) for v in values)

    def _agree(self, left: Node, right: Node, where: Where) -> bool:
        a, b = self.sampler.value(left, where), self.sampler.value(right, where)
        if self.check.truth is None:
            return close(a, b)
        truth = self._truth(self.check.truth, where)
        return any(close(a - b, goal, a) for goal in self._goals(left, right, truth, where))

    def _links(self, chain: Chain) -> Iterator[tuple[Node, Node]]:
        """Neighbours between which equality is claimed; names defined here are left out."""
        defines = self.check.role == "definition"
        new = new_names(chain, self.study) if defines else set[str]()
        last: Node | None = None
        for relation, part in zip(("", *chain.relations), chain.parts, strict=True):
            if relation != "=":
                last = None
            if names_constant(part) or whole_name(part, self.study) in new:
                continue
            if last is not None:
                yield last, part
            last = part

    def _goals(
        self, left: Node, right: Node, truth: tuple[float, float], where: Where
    ) -> Iterator[float]:
        """What left minus right should be: the truth, its negative, or with the factor in print.

        The factor is seen where the accelerations move.
        """
        here, there = truth
        yield from (here, -here)
        if not close(there, here):
            now = self.sampler.value(left, where) - self.sampler.value(right, where)
            then = self.moved.value(left, where) - self.moved.value(right, where)
            yield (then - now) / (there - here) * here

    def _truth(self, hook: Callable[..., Any], where: Where) -> tuple[float, float]:
        """What should vanish along the motion, here and where the accelerations have moved."""
        key = tuple(where.values())
        if key not in self.truths:
            derived = call_hook(hook, self.study, where)
            value = derived.xreplace(dict(self.study.given))
            self.truths[key] = self.sampler.number(value), self.moved.number(value)
        return self.truths[key]
