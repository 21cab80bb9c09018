"""Numbers at a point sort out which changes of a formula are worth a proof.

The printed formula fails at that point; a changed one has to hold there.  Of a changed formula only
the term is read in which the change stands; all else keeps its tree, and with it its values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

from voronec.audit.comparisons import accelerations
from voronec.audit.correction.changes import Change
from voronec.audit.correction.sampling import Sampler, close
from voronec.audit.display import Check
from voronec.audit.hooks import call_hook
from voronec.audit.latex.nodes import Chain, Name, Node
from voronec.audit.latex.reader import read
from voronec.audit.meaning import SENSELESS
from voronec.audit.structure import free_indices, names_constant, new_names, whole_name
from voronec.audit.study import Study
from voronec.audit.transcript import assignments

Where = dict[str, int]
SEEDS = 12
"""Points at which a formula is tried: most letters are undefined at some, and a few suffice."""
FEWER = 4
"""For how many values of the free indices a changed formula is tried."""


@dataclass(frozen=True)
class _Term:
    """A term of the printed formula, its range, and what puts another one in its place."""

    node: Node
    start: int
    end: int
    put: Callable[[Node], Chain]


class Screen:
    """A point at which a printed formula fails, and values of its free indices, ``where``.

    Where there is no such point, as where the formula has no value, it is some point.
    """

    def __init__(self, printed: str, chain: Chain, check: Check, study: Study) -> None:
        self.check, self.study = check, study
        self.printed, self.chain = printed, chain
        terms = filter(self._reads_alone, _terms(chain, lambda changed: changed))
        self.terms = sorted(terms, key=lambda term: term.end - term.start)
        self.letters = {t.node: {*free_indices(t.node, study)} for t in self.terms}
        self.where: Where = {}
        self.wheres = assignments(chain, study)
        self.truths: dict[tuple[tuple[str, int], ...], tuple[float, float]] = {}
        for seed in (*range(SEEDS), 0):
            self._stand_at(seed)
            try:
                failing = next((w for w in self.wheres if not self._holds(chain, w)), None)
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

    def _reads_alone(self, term: _Term) -> bool:
        """Whether the words of a term have its tree where nothing stands around them."""
        try:
            return self._read(self.printed[term.start : term.end]) == Chain((term.node,))
        except SENSELESS:
            return False

    def _read(self, latex: str) -> Chain:
        return read(latex, self.study.vocabulary)

    def passes(self, latex: str, change: Change) -> bool:
        """Whether a formula has a value and holds at the point, as far as it has numbers."""
        if self.check.stationary:
            return True
        try:
            chain, wheres = self._with_change(latex, change)
            if "\\int" in latex:
                return True
            first = [where for where in wheres if where == self.where]
            return all(self._holds(chain, where) for where in (first + wheres)[:FEWER])
        except SENSELESS:
            return False

    def _with_change(self, latex: str, change: Change) -> tuple[Chain, list[Where]]:
        """A changed formula, the printed one with another term or one read anew, and the values
        of its free indices."""
        start, end = min(p[0] for p in change.pieces), max(p[1] for p in change.pieces)
        term = next((t for t in self.terms if t.start <= start and end <= t.end), None)
        if term is not None:
            longer = len(latex) - len(self.printed)
            part = self._read(latex[term.start : term.end + longer])
            if not part.relations:
                return self._with_term(term, part.parts[0])
        chain = self._read(latex)
        return chain, assignments(chain, self.study)

    def _with_term(self, term: _Term, node: Node) -> tuple[Chain, list[Where]]:
        """The printed formula with another term; an error where that has no value by itself."""
        if {*free_indices(node, self.study)} != self.letters[term.node]:
            chain = term.put(node)
            return chain, assignments(chain, self.study)
        if self.sampler.has_met(term.node, self.where):
            self.sampler.value(node, self.where)
        return term.put(node), self.wheres

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
        key = tuple(sorted(where.items()))
        if key not in self.truths:
            derived = call_hook(hook, self.study, where)
            value = derived.xreplace(dict(self.study.given))
            self.truths[key] = self.sampler.number(value), self.moved.number(value)
        return self.truths[key]


def _terms(value: Any, put: Callable[[Any], Chain], whole: bool = False) -> Iterator[_Term]:
    """The sides of a formula and the terms of its sums, at any depth but in indices."""
    if isinstance(value, tuple):
        for i, item in enumerate(value):
            yield from _terms(item, partial(_put_item, put, value, i), whole)
    elif hasattr(value, "at"):
        if whole:
            start, end = value.at
            yield _Term(value, start, end, put)
        for name in (part.name for part in fields(value) if not isinstance(value, Name)):
            inside = partial(_put_field, put, value, name)
            yield from _terms(getattr(value, name), inside, name in ("parts", "terms"))


def _put_item(put: Callable[[Any], Chain], items: tuple[Any, ...], i: int, new: Any) -> Chain:
    return put((*items[:i], new, *items[i + 1 :]))


def _put_field(put: Callable[[Any], Chain], node: Node, name: str, new: Any) -> Chain:
    return put(replace(node, **{name: new}))
