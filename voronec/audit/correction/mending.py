"""The smallest change that makes a refuted formula true: at one place, or of one name.

Words of the formula are exchanged: an index for another index, a sign, sine and cosine, a name for
its companion, a prime more or less, a font, a small number.  Numbers at a point sort out what is
hopeless; a change is accepted only if the changed formula is proved.  Several changes at once are
not searched: the transcription proposes them, and they are proved in the same way.

At a random point every part of the formula has a value, and one that would mend the whole.  A
change is tried on the smallest part that it concerns.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from voronec.audit.correction.changes import Change, Piece, Spare, apply_pieces
from voronec.audit.correction.edits import repairs, single_changes
from voronec.audit.correction.goals import MendingPlace, Where, along, holds, slots_of
from voronec.audit.correction.sampling import Sampler, close
from voronec.audit.correction.units import Units
from voronec.audit.display import Check
from voronec.audit.formula import Formula
from voronec.audit.latex.nodes import (
    POINT,
    Bound,
    Call,
    Chain,
    Cross,
    Derivative,
    Differential,
    Integral,
    Listing,
    Name,
    Node,
    Number,
    Partial,
    Power,
    Product,
    Quotient,
    Sum,
    Wedge,
    walk,
)
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import Token, tokenize
from voronec.audit.meaning import SENSELESS, UnknownName, evaluate
from voronec.audit.structure import (
    are_multiples,
    bare_letter,
    free_indices,
    free_names,
    holds_always,
    names_constant,
    new_names,
    says_nothing,
    whole_name,
)
from voronec.audit.study import Study, name_or_nothing
from voronec.audit.transcript import assignments
from voronec.audit.verify import verify
from voronec.errors import VoronecError

__all__ = ["Correction", "CorrectionSearch", "Screen", "Spare", "correct"]


SEEDS = 12
"""Points at which a formula is tried: most letters are undefined at some, and a few suffice."""


@dataclass(frozen=True)
class CorrectionSearch:
    """A false formula at a point where it fails; ``slots`` are its parts with their goals."""

    latex: str
    check: Check
    study: Study
    sampler: Sampler
    where: Where
    slots: tuple[MendingPlace, ...]

    @classmethod
    def of(cls, printed: str, check: Check, study: Study) -> CorrectionSearch | None:
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
        return filter(self._mends, changes)

    def _reaches(self, slot: MendingPlace, value: Any) -> bool:
        scale = slot.value if slot.parent is None or not np.ndim(slot.value) else 1.0
        return any(close(value, goal, scale) for goal in slot.goals)

    def _slot(self, change: Change) -> MendingPlace | None:
        """The smallest part that holds the words of a change."""
        start, end = change.about
        holding = [s for s in self.slots if s.at[0] <= start and end <= s.at[1]]
        return min(holding, key=lambda s: s.at[1] - s.at[0], default=None)

    def _mends(self, change: Change) -> bool:
        """Whether the smallest part in which the change can stand gets a value it ought to have."""
        slot = self._slot(change)
        while slot is not None:
            node, value = self._changed_part(slot, change.pieces)
            if value is not None and _fits(node, slot):
                return self._reaches(slot, value)
            if node is not None and value is None:
                return False
            slot = slot.parent
        return False

    def _changed_part(self, slot: MendingPlace, pieces: Sequence[Piece]) -> tuple[Node | None, Any]:
        """A part with replacements in it, and its value; ``None`` for what there is not."""
        start, end = slot.at
        moved = [(a - start, b - start, text) for a, b, text in pieces]
        latex, _ = apply_pieces(self.latex[start:end], moved)
        if not latex:
            return None, None
        node: Node | None = slot.node
        try:
            (node,) = read(latex, self.study.vocabulary).parts
            value = self.sampler.value(node, self.where)
        except SENSELESS:
            return node, None
        return node, value if np.shape(value) == np.shape(slot.value) else None


def _fits(node: Node, slot: MendingPlace) -> bool:
    """Whether a changed part can stand where the old one does without brackets around it."""
    bare = tuple(node.at) == (0, node.at[1])
    if isinstance(node, Sum) and len(node.terms) > 1 and bare:
        return isinstance(slot.node, Sum)
    inside_power = slot.parent is not None and isinstance(slot.parent.node, Power)
    return not (inside_power and isinstance(node, (Product, Power)) and bare)


SCREENING_SEEDS = (0, 2)
"""The points at which a changed formula must hold before it is put to the proof: roots are real."""
WORK = {Derivative: 60, Partial: 1500}
"""How many derivatives are taken at each point, for all changes together."""
FEWER = 4
"""For how many values of the free indices it is tried at each point."""


class Screen:
    """Points at which changed formulas are tried; what they share is evaluated once."""

    def __init__(self, check: Check, study: Study) -> None:
        self.check, self.study = check, study
        self.samplers = [
            Sampler(study, seed, along=along(check), work=WORK) for seed in SCREENING_SEEDS
        ]

    def filter(self, printed: str, changes: Iterable[Change]) -> Iterator[Change]:
        """The changes after which the formula has a value and holds at the points."""
        for change in changes:
            latex, _ = apply_pieces(printed, change.pieces)
            if self._fits(latex):
                yield change

    def _fits(self, latex: str) -> bool:
        try:
            chain = read(latex, self.study.vocabulary)
            if any(isinstance(part, Integral) for part in walk(chain)):
                return True  # it has no numbers to go by
            wheres = assignments(chain, self.study)[:FEWER]
            return all(
                holds(chain, self.check, self.study, sampler, where)
                for sampler in self.samplers
                for where in wheres
            )
        except SENSELESS:
            return False


def _unknown_places(printed: str, study: Study, new: Collection[str] = ()) -> list[tuple[int, int]]:
    """Where the first name stands that is unknown and none of the ``new`` ones; else nothing."""
    try:
        chain = read(printed, study.vocabulary)
        (where, *_) = assignments(chain, study)
        for part in chain.parts:
            if not names_constant(part) and whole_name(part, study) not in new:
                evaluate(part, study, where)
    except UnknownName as unknown:
        names = [part for part in walk(chain) if isinstance(part, Name)]
        return [name.at for name in names if name_or_nothing(name) == unknown.name]
    except SENSELESS:
        return []
    return []


SINGLES = 250
"""How many single changes of a formula are tried that has no numbers to go by."""
PROOFS = 60
"""How many changes that numbers allow are put to the proof."""
REPAIRS = 8
"""So many changes that give a formula a meaning are tried, each with a second one."""

ORDER = {**dict.fromkeys("< \\le \\leq".split(), -1), **dict.fromkeys("> \\ge \\geq".split(), 1)}
"""Relations that rise from left to right, and that fall."""

NEAR = 6
"""How many characters on either side of a change are compared with the neighbours."""


@dataclass(frozen=True)
class Correction:
    """A changed formula that is proved; ``changes`` marks it, ``struck`` what it replaces."""

    latex: str
    changes: tuple[tuple[int, int], ...]
    struck: tuple[tuple[int, int], ...]
    method: str


@dataclass(frozen=True)
class _Case:
    """A formula to be mended; ``new`` are the names that it defines, ``terms`` what it adds.

    ``letters`` are those that it has; ``cancelling_terms`` are the terms that it adds and takes
    away again, ``shared_numbers`` the numbers by which both sides of a relation are multiplied or
    to which both are raised, ``beside`` the other formulas of its display; ``empty`` says that it
    sets something equal to itself, ``legible`` that it can be read.
    """

    latex: str
    check: Check
    study: Study
    new: frozenset[str] = frozenset()
    terms: frozenset[Node] = frozenset()
    letters: frozenset[str] = frozenset()
    cancelling_terms: frozenset[Node] = frozenset()
    shared_numbers: frozenset[tuple[str, Node]] = frozenset()
    beside: frozenset[str] = frozenset()
    empty: bool = False
    legible: bool = False

    @cached_property
    def units(self) -> Units | None:
        """The units of the letters, as far as a system tells."""
        return Units.of(self.study)

    def prove(self, change: Change) -> Correction | None:
        """The correction that a change makes, if the changed formula is proved."""
        latex, marks = apply_pieces(self.latex, change.pieces)
        method = self.proof_of(latex)
        struck = tuple((start, end) for start, end, _ in sorted(change.pieces))
        return None if method is None else Correction(latex, marks, struck, method)

    def proof_of(self, latex: str) -> str | None:
        """How a formula is proved that says something and leaves no new name open."""
        if "".join(latex.split()) in self.beside:
            return None  # the display says it already
        try:
            chain = read(latex, self.study.vocabulary)
            if says_nothing(chain) or any(holds_always(*link) for link in pairwise(chain.parts)):
                return None  # true, but it says nothing
            if any(are_multiples(*link) for link in pairwise(chain.parts)):
                return None  # no more than the sign of a letter
            if len({ORDER[s] for s in chain.relations if s in ORDER}) > 1:
                return None  # a chain rises or falls
            if _repeats_term(chain):
                return None  # x + x is no print of 2x
            if _shared_numbers(chain) - self.shared_numbers:
                return None  # 2a > 2b is no print of a > b, nor a^2 = b^2 of a = b
            if self.letters and self.letters.isdisjoint(_letters(chain)):
                return None  # nothing of the print is left
            if _is_misspelled(chain, self.study):
                return None  # B_ii where B_ij is meant, f f(x)
            if (
                not new_names(chain, self.study) <= self.new
                or _cancelling_terms(chain) - self.cancelling_terms
            ):
                return None
            finding = verify(chain, self.check, self.study)
            if not (finding.verdict.proved and finding.count):
                return None
            if any(_is_zero(term, self.study) for term in _terms(chain) - self.terms):
                return None  # a term of it is struck, in effect
            if self.units is not None and self.units.is_unbalanced(chain, self.study):
                return None  # what it adds vanishes apart
        except SENSELESS:
            return None  # the changed formula has no meaning
        return finding.verdict.method

    def first(self, changes: Iterable[Change], most: int = PROOFS) -> Correction | None:
        """The first change that is proved."""
        for position, change in enumerate(changes):
            found = self.prove(change)
            if found is not None or position == most:
                return found
        return None


def correct(
    formula: Formula,
    check: Check,
    study: Study,
    spare: Spare | None = None,
    senseless: bool = False,
) -> Correction | None:
    """The first change, in order of size, that makes the formula proved.

    ``spare`` is what the rest of the section offers to take in exchange.  ``senseless`` says that
    the formula has no value as printed.  A proposal of the check is tried last.
    """
    if check.decide is not None:
        return None
    printed = formula.printed
    case = replace(_case(printed, check, study), beside=_formulas_beside(formula))
    if case.empty:
        return None  # what it should have said cannot be seen
    spare = spare or Spare()
    changes = _order_changes(formula, study, spare)
    search = None if senseless else CorrectionSearch.of(printed, check, study)
    found = _search_correction(case, changes, spare, search)
    return found or (None if check.proposal is None else _proposed_correction(case, check.proposal))


def _terms(chain: Chain) -> frozenset[Node]:
    """What is added in a formula, at any depth, and its sides unless one of them is printed 0."""
    sums = [part for part in walk(chain) if isinstance(part, Sum)]
    sides = () if Number("0") in chain.parts else chain.parts
    return frozenset([*sides, *(term for node in sums for _, term in node.terms)])


def _formulas_beside(formula: Formula) -> frozenset[str]:
    """The other formulas of the display, without spacing."""
    units = formula.display.units
    texts = [unit.display[slice(*piece.at)] for unit in units for piece in unit.pieces]
    return frozenset("".join(text.split()) for text in texts) - {"".join(formula.printed.split())}


def _letters(chain: Chain) -> frozenset[str]:
    """The letters of a formula without their accents, but for the word "const"."""
    names = (part for part in walk(chain) if isinstance(part, Name))
    return frozenset(bare_letter(name) for name in names if not names_constant(name))


def _cancelling_terms(chain: Chain) -> frozenset[Node]:
    """What a sum adds and takes away again."""
    sums = [part for part in walk(chain) if isinstance(part, Sum)]
    return frozenset(t for s in sums for sign, t in s.terms if (-sign, t) in s.terms)


def _repeats_term(chain: Chain) -> bool:
    """Whether a sum adds something twice."""
    return any(isinstance(s, Sum) and len({*s.terms}) < len(s.terms) for s in walk(chain))


def _shared_numbers(chain: Chain) -> frozenset[tuple[str, Node]]:
    """Numbers by which both sides of a relation are multiplied, and powers that both are."""
    sides = [_outer_numbers(part) for part in chain.parts]
    return frozenset(number for one, two in pairwise(sides) for number in one & two)


def _outer_numbers(side: Node) -> set[tuple[str, Node]]:
    if isinstance(side, Power):
        return {("exponent", side.exponent)}
    return {("factor", factor) for factor in _factors(side) if isinstance(factor, Number)}


def _factors(node: Node) -> Iterator[Node]:
    """The factors of products of all kinds, and of what a sum sign adds."""
    inner: tuple[Node, ...] = ()
    if isinstance(node, Bound):
        inner = (node.body,)
    elif isinstance(node, (Cross, Wedge)):
        inner = (node.left, node.right)
    elif isinstance(node, Product):
        inner = node.factors
    elif isinstance(node, Listing) and node.bracket != POINT:
        inner = node.items
    else:
        yield node
    for factor in inner:
        yield from _factors(factor)


def _is_misspelled(chain: Chain, study: Study) -> bool:
    """Whether a name has an index twice, or stands bare beside its value at some arguments, or
    something is divided by a differential that is none itself."""
    for part in walk(chain):
        if isinstance(part, Name):
            letters = [x.head for x in (*part.sub, *part.sup) if study.is_index(x)]
            if len(set(letters)) < len(letters):
                return True
        if isinstance(part, Product):
            called = {x.function for x in part.factors if isinstance(x, Call)}
            if not called.isdisjoint(part.factors):
                return True
        if isinstance(part, Quotient) and _is_small(part.bottom) and not _is_small(part.top):
            return True
    return False


def _is_small(node: Node) -> bool:
    return any(isinstance(part, Differential) for part in walk(node))


def _is_zero(term: Node, study: Study) -> bool:
    try:
        values = assignments(Chain((term,)), study)
        return all(evaluate(term, study, where) == 0 for where in values)
    except SENSELESS:
        return False  # it holds the index of a sum


def _case(printed: str, check: Check, study: Study) -> _Case:
    try:
        chain = read(printed, study.vocabulary)
    except VoronecError:
        return _Case(printed, check, study)
    return _Case(
        printed,
        check,
        study,
        new=frozenset(new_names(chain, study)),
        terms=_terms(chain),
        letters=_letters(chain),
        cancelling_terms=_cancelling_terms(chain),
        shared_numbers=_shared_numbers(chain),
        empty=says_nothing(chain),
        legible=True,
    )


def _order_changes(formula: Formula, study: Study, spare: Spare) -> list[Change]:
    """Those at an index that nothing binds first, then by kind, then what a neighbour prints."""
    printed = formula.printed
    bound = {w.text for words in formula.piece.quantifiers for w in words}
    changes = single_changes(printed, study, spare)
    suspects = _unbound_places(printed, study, bound)

    def order(change: Change) -> tuple[bool, int, bool]:
        start = change.pieces[0][0]
        bound_here = not any(a <= start < b for a, b in suspects)
        return bound_here, change.rank, not _like_neighbours(printed, change, spare)

    return sorted(changes, key=order)


def _unbound_places(printed: str, study: Study, bound: set[str]) -> list[tuple[int, int]]:
    """Where an index stands that neither a sum nor a quantifier nor the left side binds."""
    try:
        chain = read(printed, study.vocabulary)
    except VoronecError:
        return []
    letters = set(free_indices(chain, study)) - bound - set(free_indices(chain.parts[0], study))
    return [name.at for name in free_names(chain, study) if name.head in letters]


def _like_neighbours(printed: str, change: Change, spare: Spare) -> bool:
    """Whether the changed words, with what stands around them, are printed elsewhere."""
    latex, marks = apply_pieces(printed, change.pieces)
    start, end = marks[0][0], marks[-1][1]
    near = "".join(latex[max(start - NEAR, 0) : end + NEAR].split())
    return any(near in text for text in spare.formulas)


def _search_correction(
    case: _Case, changes: Sequence[Change], spare: Spare, search: CorrectionSearch | None
) -> Correction | None:
    if search is not None:
        return case.first(search.singles(changes))
    mending = [*repairs(case.latex), *changes]
    if case.check.stationary:
        mending = mending[:SINGLES]  # it has no numbers to go by
        found = case.first(mending, SINGLES)
    else:
        mending = _at_unknown(case, mending)
        fitting = Screen(case.check, case.study).filter(case.latex, mending)
        found = case.first(fitting, SINGLES)
    if found is not None or case.legible:
        return found
    return _after_repair(case, mending[:SINGLES], spare)


def _at_unknown(case: _Case, changes: Sequence[Change]) -> list[Change]:
    """The changes that concern the first name that means nothing; all, where each has a meaning."""
    places = _unknown_places(case.latex, case.study, case.new)
    if not places:
        return list(changes)
    return [
        change
        for change in changes
        if any(a <= end and start <= b for start, end, _ in change.pieces for a, b in places)
    ]


def _after_repair(case: _Case, mending: Sequence[Change], spare: Spare) -> Correction | None:
    """Two changes, the first of which gives the formula a meaning."""
    mended = 0
    for repair in mending:
        latex, _ = apply_pieces(case.latex, repair.pieces)
        search = CorrectionSearch.of(latex, case.check, case.study)
        if search is None:
            continue
        changes = single_changes(latex, case.study, spare)
        found = replace(case, latex=latex).first(search.singles(changes))
        if found is not None:
            return _correction_by_words(case.latex, found.latex, found.method)
        mended += 1
        if mended == REPAIRS:
            break
    return None


def _proposed_correction(case: _Case, proposal: str) -> Correction | None:
    method = case.proof_of(proposal)
    return None if method is None else _correction_by_words(case.latex, proposal, method)


def _correction_by_words(printed: str, latex: str, method: str) -> Correction:
    """A correction whose changes are found by comparing word by word."""
    old, new = tokenize(printed), tokenize(latex)
    matcher = SequenceMatcher(None, [w.text for w in old], [w.text for w in new], autojunk=False)
    changes, struck = [], []
    for kind, a, b, c, d in matcher.get_opcodes():
        if kind != "equal":
            struck.append(_range(old, a, b))
            changes.append(_range(new, c, d))
    return Correction(latex, tuple(changes), tuple(struck), method)


def _range(words: Sequence[Token], start: int, end: int) -> tuple[int, int]:
    """From the first to the last character of some words; empty where there are none."""
    if start == end:
        place = words[start - 1].end if start else 0
        return place, place
    return words[start].start, words[end - 1].end
