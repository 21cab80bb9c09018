"""The smallest change that makes a refuted formula true, found by trying single changes.

Words of the formula are exchanged one at a time: an index for another index, a sign, sine and
cosine, a name for its companion, a prime more or less, a small number.  A change is accepted only
if the changed formula is proved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voronec.audit.displays import RELATIONS, script_ranges
from voronec.audit.paper import Check
from voronec.audit.reader import read
from voronec.audit.structure import free_indices, free_names
from voronec.audit.study import Study
from voronec.audit.tokens import GREEK, Token, tokenize
from voronec.audit.transcript import Formula, Transcript
from voronec.audit.verify import verify
from voronec.errors import VoronecError

__all__ = ["Correction", "Spare", "correct"]


@dataclass(frozen=True)
class Correction:
    """A changed formula that is proved; ``changes`` marks it, ``struck`` what it replaces."""

    latex: str
    changes: tuple[tuple[int, int], ...]
    struck: tuple[tuple[int, int], ...]
    method: str


@dataclass(frozen=True)
class Spare:
    """Index expressions, as ``{n+\\nu}``, and letters that a section prints."""

    indices: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()

    @classmethod
    def of(cls, transcript: Transcript, study: Study) -> Spare:
        """Collect them."""
        words = [w for f in transcript.formulas() for w in f.piece.tokens]
        letters = dict.fromkeys(w.text for w in words if w.kind == "letter" or w.text in GREEK)
        return cls(transcript.indices(study), tuple(letters))


@dataclass(frozen=True)
class _Edit:
    start: int
    end: int
    text: str


def correct(
    formula: Formula, check: Check, study: Study, spare: Spare | None = None
) -> Correction | None:
    """The first single change, in order of size, that makes the formula proved.

    ``spare`` is what the rest of the section offers to take in exchange.
    """
    printed = formula.printed
    bound = {w.text for words in formula.piece.quantifiers for w in words}
    for edit in _edits(printed, study, spare or Spare(), bound):
        latex = printed[: edit.start] + edit.text + printed[edit.end :]
        try:
            finding = verify(read(latex, study.vocabulary), check, study)
        except (VoronecError, AttributeError, TypeError, ValueError):
            continue  # the changed formula has no meaning
        if finding.verdict.proved and finding.count:
            marks = ((edit.start, edit.start + len(edit.text)),)
            return Correction(latex, marks, ((edit.start, edit.end),), finding.verdict.method)
    return None


def _edits(printed: str, study: Study, spare: Spare, bound: set[str]) -> Iterator[_Edit]:
    """Single changes, those at an index that nothing binds first, then by size."""
    words = tokenize(printed)
    own = [w.text for w in words if w.kind == "letter" or w.text in GREEK]
    found = [
        *_exchanges(words),
        *_index_edits(printed, words, study, spare.indices),
        *_prime_edits(words),
        *_name_edits(words, study, own),
        *_number_edits(words),
        *_name_edits(words, study, spare.letters),
    ]
    suspects = _unbound_places(printed, study, bound)
    found.sort(key=lambda e: not any(a <= e.start < b for a, b in suspects))
    seen: set[_Edit] = set()
    for edit in found:
        if edit not in seen and edit.text != printed[edit.start : edit.end]:
            seen.add(edit)
            yield edit


def _unbound_places(printed: str, study: Study, bound: set[str]) -> list[tuple[int, int]]:
    """Where an index stands that neither a sum nor a quantifier nor the left side binds."""
    try:
        chain = read(printed, study.vocabulary)
    except VoronecError:
        return []
    letters = set(free_indices(chain, study)) - bound - set(free_indices(chain.parts[0], study))
    return [name.at for name in free_names(chain, study) if name.head in letters]


def _index_edits(
    printed: str, words: Sequence[Token], study: Study, spare: Sequence[str]
) -> Iterator[_Edit]:
    """Another index: a letter for a letter, then a whole index expression."""
    letters = [w for w in dict.fromkeys(t.text for t in words) if w in study.indices]
    for start, end in script_ranges(words):
        for word in words[start:end]:
            if word.text in study.indices:
                for other in letters:
                    yield _Edit(word.start, word.end, other)
    for start, end in script_ranges(words):
        a, b = words[start].start, words[end - 1].end
        inside = {w.text for w in words[start:end]} & set(study.indices)
        for other in spare:
            if inside and inside == {t.text for t in tokenize(other)} & set(study.indices):
                yield _Edit(a, b, other)


def _exchanges(words: Sequence[Token]) -> Iterator[_Edit]:
    """Signs, sine and cosine; a sign at the head of a side."""
    for before, word in zip((None, *words), words, strict=False):
        heads = before is None or before.text in RELATIONS or before.text in ("(", "[")
        if heads and word.text not in ("+", "-"):
            yield _Edit(word.start, word.start, "-")
        other = _COMPANIONS.get(word.text)
        if other is not None:
            yield _Edit(word.start, word.end, other)


_COMPANIONS = {"+": "-", "-": "+", "\\sin": "\\cos", "\\cos": "\\sin"}


def _prime_edits(words: Sequence[Token]) -> Iterator[_Edit]:
    for word in words:
        if word.text == "'":
            yield _Edit(word.start, word.end, "")
        elif word.kind == "letter" or word.text in GREEK:
            yield _Edit(word.end, word.end, "'")


def _name_edits(words: Sequence[Token], study: Study, letters: Sequence[str]) -> Iterator[_Edit]:
    """A letter for another one of ``letters``; an index 1, or a square, more or less."""
    places = [w for w in words if (w.kind == "letter" or w.text in GREEK)]
    letters = [x for x in dict.fromkeys(letters) if x not in study.indices]
    for word in places:
        for other in letters:
            space = " " if other.startswith("\\") else ""
            yield _Edit(word.start, word.end, other + space)
        yield _Edit(word.end, word.end, "_1")
        yield _Edit(word.end, word.end, "^2")
    for start, end in script_ranges(words):
        if words[start].kind == "number":
            yield _Edit(words[start - 1].start, words[end - 1].end, "")


def _number_edits(words: Sequence[Token]) -> Iterator[_Edit]:
    for word in words:
        if word.kind == "number" and len(word.text) == 1:
            for digit in "12345":
                yield _Edit(word.start, word.end, digit)
