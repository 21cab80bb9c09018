"""The single change that makes a refuted formula true, or the formula that is proposed.

Numbers at a point sort out what is hopeless; a change is accepted only if the changed formula is
proved, and says what the print said.  Several changes at once are proposed by the transcription,
and proved in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import cached_property
from itertools import pairwise

from voronec.audit.correction.changes import (
    Change,
    Spare,
    apply_pieces,
    repairs,
    single_changes,
)
from voronec.audit.correction.screen import Screen
from voronec.audit.display import Check
from voronec.audit.formula import Formula
from voronec.audit.latex.nodes import (
    POINT,
    Bound,
    Call,
    Chain,
    Cross,
    Differential,
    Listing,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Wedge,
    walk,
)
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import Token, tokenize
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.structure import (
    are_multiples,
    bare_letter,
    free_indices,
    free_names,
    holds_always,
    names_constant,
    new_names,
    says_nothing,
)
from voronec.audit.study import Study
from voronec.audit.transcript import assignments
from voronec.audit.verify import verify
from voronec.errors import VoronecError

PROOFS = 250
"""How many changes that numbers allow are put to the proof."""
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


def correct(
    formula: Formula, check: Check, study: Study, spare: Spare | None = None
) -> Correction | None:
    """The first change, the most believable first, that makes the formula proved.

    ``spare`` is what the rest of the section offers to take in exchange.  A proposal of the check
    is tried last.
    """
    if check.decide is not None:
        return None
    case = _Case(formula, check, study)
    if says_nothing(case.chain):
        return None  # what it should have said cannot be seen
    printed, tried = formula.printed, 0
    screen = Screen(printed, case.chain, check, study)
    for change in _order_changes(case, spare or Spare()):
        latex, marks = apply_pieces(printed, change.pieces)
        if screen.passes(latex, change) and tried < PROOFS:
            tried += 1
            method = case.proof_of(latex)
            if method is not None:
                struck = tuple((start, end) for start, end, _ in sorted(change.pieces))
                return Correction(latex, marks, struck, method)
    method = case.proof_of(check.proposal) if check.proposal else None
    return None if method is None else _by_words(printed, str(check.proposal), method)


@dataclass(frozen=True)
class _Case:
    """A formula to be mended."""

    formula: Formula
    check: Check
    study: Study

    @cached_property
    def chain(self) -> Chain:
        """Its tree; an empty one where it cannot be read."""
        try:
            return read(self.formula.printed, self.study.vocabulary)
        except VoronecError:
            return Chain(())

    @cached_property
    def beside(self) -> frozenset[str]:
        """The other formulas of the display, without spacing."""
        units = self.formula.display.units
        texts = [unit.display[slice(*piece.at)] for unit in units for piece in unit.pieces]
        return frozenset(map(_bare, texts)) - {_bare(self.formula.printed)}

    def proof_of(self, latex: str) -> str | None:
        """How a formula is proved that says what the print said, and nothing idle."""
        try:
            chain = read(latex, self.study.vocabulary)
            if _bare(latex) in self.beside or self._is_idle(chain) or self._strays(chain):
                return None
            finding = verify(chain, self.check, self.study)
            if not (finding.verdict.proved and finding.count):
                return None
            if any(self._adds_nothing(t, chain) for t in _terms(chain) - _terms(self.chain)):
                return None  # a term of it is struck, in effect
        except SENSELESS:
            return None  # the changed formula has no meaning
        return finding.verdict.method

    def _adds_nothing(self, term: Node, chain: Chain) -> bool:
        """Whether a term is zero, or constant by itself in a sum that is said to be constant."""
        if _is_zero(term, self.study):
            return True
        several = (part.terms for part in chain.parts if isinstance(part, Sum))
        inside = any((sign, term) in terms for terms in several for sign in (1, -1))
        if not inside or not any(map(names_constant, chain.parts)):
            return False
        alone = Chain((term, Name("const")), ("=",))
        return verify(alone, Check(), self.study).verdict.proved

    def _is_idle(self, chain: Chain) -> bool:
        """Whether a formula says nothing, or no more than the sign of a letter, or is odd."""
        links = list(pairwise(chain.parts))
        return (
            says_nothing(chain)
            or any(holds_always(*link) or are_multiples(*link) for link in links)
            or len({ORDER[s] for s in chain.relations if s in ORDER}) > 1  # it rises, and falls
            or _repeats_term(chain)  # x + x is no print of 2x
            or _is_misspelled(chain, self.study)  # B_ii where B_ij is meant, f f(x)
        )

    def _strays(self, chain: Chain) -> bool:
        """Whether a formula has what the print has not: new names, terms that cancel, numbers on
        both sides (2a > 2b is no print of a > b, nor a^2 = b^2 of a = b); or no letter of it."""
        letters = _letters(self.chain)
        return (
            bool(letters and letters.isdisjoint(_letters(chain)))
            or bool(_shared_numbers(chain) - _shared_numbers(self.chain))
            or bool(_cancelling_terms(chain) - _cancelling_terms(self.chain))
            or not new_names(chain, self.study) <= self._new
        )

    @cached_property
    def _new(self) -> set[str]:
        return new_names(self.chain, self.study) if self.chain.parts else set()


def _bare(latex: str) -> str:
    return "".join(latex.split())


def _terms(chain: Chain) -> frozenset[Node]:
    """What is added in a formula, at any depth, and its sides unless one of them is printed 0."""
    sums = [part for part in walk(chain) if isinstance(part, Sum)]
    sides = () if Number("0") in chain.parts else chain.parts
    return frozenset([*sides, *(term for node in sums for _, term in node.terms)])


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


def _order_changes(case: _Case, spare: Spare) -> list[Change]:
    """Those at an index that nothing binds first, then by kind, then what a neighbour prints."""
    printed, study = case.formula.printed, case.study
    suspects = _unbound_places(case)

    def order(change: Change) -> tuple[bool, int, bool]:
        start = change.pieces[0][0]
        bound_here = not any(a <= start < b for a, b in suspects)
        return bound_here, change.rank, not _like_neighbours(printed, change, spare)

    return [*repairs(printed), *sorted(single_changes(printed, study, spare), key=order)]


def _unbound_places(case: _Case) -> list[tuple[int, int]]:
    """Where an index stands that neither a sum nor a quantifier nor the left side binds."""
    chain, study = case.chain, case.study
    if not chain.parts:
        return []
    bound = {w.text for words in case.formula.piece.quantifiers for w in words}
    letters = set(free_indices(chain, study)) - bound - set(free_indices(chain.parts[0], study))
    return [name.at for name in free_names(chain, study) if name.head in letters]


def _like_neighbours(printed: str, change: Change, spare: Spare) -> bool:
    """Whether the changed words, with what stands around them, are printed elsewhere."""
    latex, marks = apply_pieces(printed, change.pieces)
    start, end = marks[0][0], marks[-1][1]
    near = "".join(latex[max(start - NEAR, 0) : end + NEAR].split())
    return any(near in text for text in spare.formulas)


def _by_words(printed: str, latex: str, method: str) -> Correction:
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
