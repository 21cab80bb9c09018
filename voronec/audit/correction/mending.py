"""The smallest change that makes a refuted formula true: one place, one name, or two places.

Words of the formula are exchanged: an index for another index, a sign, sine and cosine, a name for
its companion, a prime more or less, a font, a small number.  Numbers at a point sort out what is
hopeless; a change is accepted only if the changed formula is proved.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from itertools import pairwise

from voronec.audit.correction.changes import Change, Spare, applied
from voronec.audit.correction.edits import single_changes
from voronec.audit.correction.missing import repairs
from voronec.audit.correction.screening import Screen, unknown_places
from voronec.audit.correction.search import Search
from voronec.audit.latex.nodes import Chain, Node, Number, Sum, walk
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import Token, tokenize
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.paper import Check
from voronec.audit.structure import free_indices, free_names, holds_always, new_names, says_nothing
from voronec.audit.study import Study
from voronec.audit.transcript import Formula, assignments
from voronec.audit.verify import verify
from voronec.errors import VoronecError

__all__ = ["Correction", "Spare", "correct"]

SINGLES = 250
"""How many single changes of a formula are tried that has no numbers to go by."""
PROOFS = 60
"""How many changes that numbers allow are put to the proof."""
REPAIRS = 8
WORDS_FOR_TWO = 12
"""A formula with fewer words is not changed at two places: almost anything could be reached."""

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

    ``empty`` says that it sets something equal to itself, ``legible`` that it can be read.
    """

    printed: str
    check: Check
    study: Study
    new: frozenset[str] = frozenset()
    terms: frozenset[Node] = frozenset()
    empty: bool = False
    legible: bool = False

    def prove(self, change: Change) -> Correction | None:
        """The correction that a change makes, if the changed formula is proved."""
        latex, marks = applied(self.printed, change.pieces)
        method = self.proved(latex)
        struck = tuple((start, end) for start, end, _ in sorted(change.pieces))
        return None if method is None else Correction(latex, marks, struck, method)

    def proved(self, latex: str) -> str | None:
        """How a formula is proved that says something and leaves no new name open."""
        try:
            chain = read(latex, self.study.vocabulary)
            if says_nothing(chain) or any(holds_always(*link) for link in pairwise(chain.parts)):
                return None  # true, but it says nothing
            if not new_names(chain, self.study) <= self.new:
                return None
            finding = verify(chain, self.check, self.study)
            if not (finding.verdict.proved and finding.count):
                return None
            if any(_is_zero(term, self.study) for term in _terms(chain) - self.terms):
                return None  # a term of it is struck, in effect
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
    case = _case(printed, check, study)
    if case.empty:
        return None  # what it should have said cannot be seen
    spare = spare or Spare()
    changes = _ordered(formula, study, spare)
    search = None if senseless else Search.of(printed, check, study)
    found = _searched(case, changes, spare, search)
    return found or (None if check.proposal is None else _proposed(case, check.proposal))


def _terms(chain: Chain) -> frozenset[Node]:
    """What is added in a formula, at any depth, and its sides unless one of them is printed 0."""
    sums = [part for part in walk(chain) if isinstance(part, Sum)]
    sides = () if Number("0") in chain.parts else chain.parts
    return frozenset([*sides, *(term for node in sums for _, term in node.terms)])


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
    new, empty = frozenset(new_names(chain, study)), says_nothing(chain)
    return _Case(printed, check, study, new, _terms(chain), empty, True)


def _ordered(formula: Formula, study: Study, spare: Spare) -> list[Change]:
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
    latex, marks = applied(printed, change.pieces)
    start, end = marks[0][0], marks[-1][1]
    near = "".join(latex[max(start - NEAR, 0) : end + NEAR].split())
    return any(near in text for text in spare.formulas)


def _searched(
    case: _Case, changes: Sequence[Change], spare: Spare, search: Search | None
) -> Correction | None:
    if search is not None:
        found = case.first(search.singles(changes))
        if found is not None or len(tokenize(case.printed)) < WORDS_FOR_TWO:
            return found
        return case.first(search.pairs(changes))
    mending = [*repairs(case.printed), *changes]
    if case.check.stationary:
        mending = mending[:SINGLES]  # it has no numbers to go by
        found = case.first(mending, SINGLES)
    else:
        mending = _at_unknown(case, mending)
        fitting = Screen(case.check, case.study).fitting(case.printed, mending)
        found = case.first(fitting, SINGLES)
    if found is not None or case.legible:
        return found
    return _after_repair(case, mending[:SINGLES], spare)


def _at_unknown(case: _Case, changes: Sequence[Change]) -> list[Change]:
    """The changes that concern the first name that means nothing; all, where each has a meaning."""
    places = unknown_places(case.printed, case.study, case.new)
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
        latex, _ = applied(case.printed, repair.pieces)
        search = Search.of(latex, case.check, case.study)
        if search is None:
            continue
        changes = single_changes(latex, case.study, spare)
        found = replace(case, printed=latex).first(search.singles(changes))
        if found is not None:
            return _compared(case.printed, found.latex, found.method)
        mended += 1
        if mended == REPAIRS:
            break
    return None


def _proposed(case: _Case, proposal: str) -> Correction | None:
    method = case.proved(proposal)
    return None if method is None else _compared(case.printed, proposal, method)


def _compared(printed: str, latex: str, method: str) -> Correction:
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
