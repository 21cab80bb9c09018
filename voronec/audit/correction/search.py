"""Which small changes could make a formula true, as far as numbers tell.

At a random point every part of the formula has a value, and one that would mend the whole.  A
change is tried on the smallest part that it concerns.  Of two changes in different parts, the
effects add up or multiply, so that pairs are found by sorting, not by trying all of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import Any

import numpy as np

from voronec.audit.correction.changes import Change, Piece, applied
from voronec.audit.correction.goals import Where, along, slots_of
from voronec.audit.correction.sampling import TOLERANCE, Sampler, close
from voronec.audit.correction.slots import Slot
from voronec.audit.latex.nodes import Node, Power, Product, Sum
from voronec.audit.latex.reader import read
from voronec.audit.meaning import SENSELESS
from voronec.audit.paper import Check
from voronec.audit.study import Study
from voronec.audit.transcript import assignments

__all__ = ["Search"]

SEEDS = 12
DIRECT_PAIRS = 1000
"""How many pairs of changes of one and the same part are tried."""
MOST_PAIRS = 400
"""How many pairs may come out of sorting; with more, the formula says too little."""


@dataclass(frozen=True)
class _Effect:
    """What a change does: the part it concerns, and the value that this part gets."""

    change: Change
    slot: Slot
    value: Any


@dataclass(frozen=True)
class Search:
    """A false formula at a point where it fails; ``slots`` are its parts with their goals."""

    printed: str
    check: Check
    study: Study
    sampler: Sampler
    where: Where
    slots: tuple[Slot, ...]

    @classmethod
    def of(cls, printed: str, check: Check, study: Study) -> Search | None:
        """Look for a point; ``None`` where the formula has no numbers to go by."""
        if check.stationary or check.decide is not None:
            return None
        try:
            chain = read(printed, study.vocabulary)
        except SENSELESS:
            return None
        for seed in range(SEEDS):
            try:
                sampler = Sampler(study, seed, along=along(check))
                for where in assignments(chain, study):
                    slots = slots_of(chain, check, study, sampler, where)
                    if slots is not None:
                        return cls(printed, check, study, sampler, where, tuple(slots))
            except SENSELESS:
                continue
        return None

    def singles(self, changes: Sequence[Change]) -> Iterator[Change]:
        """The changes that reach the goal, in the order given."""
        for change in changes:
            effect = self._effect(change)
            if effect is not None and self._reaches(effect.slot, effect.value):
                yield change

    def pairs(self, changes: Sequence[Change]) -> Iterator[Change]:
        """Two changes that reach the goal together, those of lowest rank first.

        Pairs in different parts come before pairs in one part, which must be tried one by one.
        """
        effects = [e for e in map(self._effect, (c for c in changes if c.paired)) if e is not None]
        effects = [e for e in effects if not close(e.value, e.slot.value)]
        reached = (*self._apart(effects), *self._with_sign(effects))
        apart = [change for change in reached if change is not None]
        if len(apart) <= MOST_PAIRS:
            yield from sorted(apart, key=lambda change: change.rank)
        yield from self._together(effects)

    def _reaches(self, slot: Slot, value: Any) -> bool:
        scale = slot.value if slot.parent is None or not np.ndim(slot.value) else 1.0
        return any(close(value, goal, scale) for goal in slot.goals)

    def _slot(self, change: Change) -> Slot | None:
        """The smallest part that holds the words of a change."""
        start, end = change.about
        holding = [s for s in self.slots if s.at[0] <= start and end <= s.at[1]]
        return min(holding, key=lambda s: s.at[1] - s.at[0], default=None)

    def _effect(self, change: Change) -> _Effect | None:
        slot = self._slot(change)
        while slot is not None:
            node, value = self._changed(slot, change.pieces)
            if value is not None and _fits(node, slot):
                return _Effect(change, slot, value)
            if node is not None and value is None:
                return None
            slot = slot.parent
        return None

    def _changed(self, slot: Slot, pieces: Sequence[Piece]) -> tuple[Node | None, Any]:
        """A part with replacements in it, and its value; ``None`` for what there is not."""
        start, end = slot.at
        moved = [(a - start, b - start, text) for a, b, text in pieces]
        latex, _ = applied(self.printed[start:end], moved)
        if not latex:
            return None, None
        node: Node | None = slot.node
        try:
            (node,) = read(latex, self.study.vocabulary).parts
            value = self.sampler.value(node, self.where)
        except SENSELESS:
            return node, None
        return node, value if np.shape(value) == np.shape(slot.value) else None

    def _apart(self, effects: Sequence[_Effect]) -> Iterator[Change | None]:
        """Pairs in different parts of a sum or a product; a sign is a part of its own."""
        groups: dict[Slot, list[_Member]] = {}
        for effect in effects:
            groups.setdefault(effect.slot, []).append(_Member(effect, effect.value, effect))
            for parent, part, value in effect.slot.ancestors(effect.value):
                groups.setdefault(parent, []).append(_Member(part, part.up(value), effect))
        for parent, members in groups.items():
            if parent.adds and not np.ndim(parent.value):
                yield from _matches(members, parent, _difference)
            elif parent.multiplies:
                yield from _matches(members, parent, _ratio)

    def _with_sign(self, effects: Sequence[_Effect]) -> Iterator[Change | None]:
        """A change in a term together with its sign."""
        signs = {}
        for effect in effects:
            ((start, _, text), *more) = effect.change.pieces
            terms = [s for s in self.slots if s.parent is effect.slot and s.at[0] > start]
            if text in ("+", "-") and terms and not more:
                signs[min(terms, key=lambda s: s.at[0])] = effect.change
        for effect in effects:
            for _, part, value in effect.slot.ancestors(effect.value):
                if part in signs and self._reaches(part, -value):
                    yield _joined(effect.change, signs[part])

    def _together(self, effects: Sequence[_Effect]) -> Iterator[Change]:
        """Pairs in one and the same smallest part."""
        groups: dict[Slot, list[Change]] = {}
        for effect in effects:
            groups.setdefault(effect.slot, []).append(effect.change)
        tried = [
            (slot, pair)
            for slot, members in groups.items()
            if slot.goals
            for pair in combinations(members, 2)
        ]
        tried.sort(key=lambda item: item[1][0].rank + item[1][1].rank)
        for slot, (first, second) in tried[:DIRECT_PAIRS]:
            both = _joined(first, second)
            value = None if both is None else self._changed(slot, both.pieces)[1]
            if both is not None and value is not None and self._reaches(slot, value):
                yield both


def _fits(node: Node, slot: Slot) -> bool:
    """Whether a changed part can stand where the old one does without brackets around it."""
    bare = tuple(node.at) == (0, node.at[1])
    if isinstance(node, Sum) and len(node.terms) > 1 and bare:
        return isinstance(slot.node, Sum)
    inside_power = slot.parent is not None and isinstance(slot.parent.node, Power)
    return not (inside_power and isinstance(node, (Product, Power)) and bare)


def _joined(first: Change, second: Change) -> Change | None:
    """Two changes as one; none where they overlap."""
    pieces = sorted((*first.pieces, *second.pieces))
    for (_, end, _), (start, stop, _) in pairwise(pieces):
        if start < end or (start == end == stop):
            return None
    about = (min(first.about[0], second.about[0]), max(first.about[1], second.about[1]))
    return replace(first, pieces=tuple(pieces), about=about, rank=first.rank + second.rank)


@dataclass(frozen=True)
class _Member:
    """A change in one ``part`` of a sum or a product, and the ``value`` that the whole then has."""

    part: Any
    value: Any
    effect: _Effect


def _difference(new: Any, old: Any) -> float:
    return float(new - old)


def _ratio(new: Any, old: Any) -> float:
    return float(np.log(abs(new / old))) if new and old else float("nan")


def _matches(members: Sequence[_Member], parent: Slot, effect: Any) -> Iterator[Change | None]:
    """Pairs of different parts whose effects together take the parent to a goal.

    ``effect`` is what adds up: a difference, or the logarithm of a ratio.
    """
    sizes = np.array([effect(member.value, parent.value) for member in members])
    order = np.argsort(sizes)
    ordered = sizes[order]
    for goal in parent.goals:
        wanted = effect(goal, parent.value)
        slack = TOLERANCE * (abs(wanted) + 1.0)
        for i, size in enumerate(sizes):
            low, high = np.searchsorted(ordered, [wanted - size - slack, wanted - size + slack])
            for j in order[low:high]:
                if i < j and members[i].part is not members[j].part:
                    yield _joined(members[i].effect.change, members[j].effect.change)
