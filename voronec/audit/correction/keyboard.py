"""What slips where a formula is typed: letters transposed, words said twice, a bracket one place
off, an index that no letter fits, an argument left out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from voronec.audit.correction.changes import Change, Spare
from voronec.audit.correction.fonts import is_letter, letters_of, spaced
from voronec.audit.latex.displays import RELATIONS, script_ranges
from voronec.audit.latex.tokens import ELEMENTARY, Token
from voronec.audit.study import Study

__all__ = ["keyboard_slips"]

_CLOSING = frozenset(")]}")
_TAKING = frozenset(("\\partial", "\\dot", "\\ddot", "\\sqrt", "\\delta", *ELEMENTARY))
"""Words that something must follow."""
LONGEST = 40
"""How many words may be said twice."""


def keyboard_slips(
    words: Sequence[Token], study: Study, spare: Spare, letters: Sequence[str]
) -> Iterator[Change]:
    """Every change of this kind; they are not tried in pairs."""
    for change in (
        *_transposed(words),
        *_twice(words),
        *_brackets(words),
        *_indices(words, study, spare),
        *_arguments(words, letters),
    ):
        yield replace(change, paired=False)


def _transposed(words: Sequence[Token]) -> Iterator[Change]:
    """Two letters that follow each other exchanged, without their fonts and with them."""
    plain = [w for w in words if is_letter(w)]
    for one, two in pairwise(plain):
        if one.text != two.text:
            pieces = (
                (one.start, one.end, spaced(two.text)),
                (two.start, two.end, spaced(one.text)),
            )
            yield Change(pieces, (one.start, two.end))
    for first, second in pairwise(letters_of(words)):
        if (first.accent or second.accent) and first.text != second.text:
            whole = (
                (first.start, first.end, second.text),
                (second.start, second.end, first.text),
            )
            yield Change(whole, (first.start, second.end))


def _twice(words: Sequence[Token]) -> Iterator[Change]:
    """Words that are followed by the same words, or by a sign and the same words, said once."""
    texts = [word.text for word in words]
    for start in range(len(words)):
        for size in range(1, min(LONGEST, (len(words) - start) // 2) + 1):
            for gap in (0, 1):
                again, end = start + size + gap, start + 2 * size + gap
                signed = gap == 0 or texts[again - 1] in ("+", "-")
                if end <= len(words) and signed and texts[start : again - gap] == texts[again:end]:
                    a, b = words[again - gap].start, words[end - 1].end
                    yield Change(((a, b, ""),), (words[start].start, b))


def _brackets(words: Sequence[Token]) -> Iterator[Change]:
    """A bracket that closes one word earlier, or one later."""
    for before, word in pairwise(words):
        if word.text in (")", "]") and before.text not in _CLOSING:
            pieces = ((before.start, before.start, word.text), (word.start, word.end, ""))
            yield Change(pieces, (before.start, word.end))
        if before.text in (")", "]") and word.text not in _CLOSING:
            pieces = ((before.start, before.end, ""), (word.end, word.end, before.text))
            yield Change(pieces, (before.start, word.end))


def _indices(words: Sequence[Token], study: Study, spare: Spare) -> Iterator[Change]:
    """Another index, for one that holds a letter of which no index is made."""
    for start, end in script_ranges(words):
        inside = words[start:end]
        a, b = inside[0].start, inside[-1].end
        about = (words[max(start - 2, 0)].start, b)
        odd = [w for w in inside if is_letter(w) and w.text not in study.indices]
        if not odd or words[start - 1].text != "_":
            continue
        for other in spare.indices:
            yield Change(((a, b, other),), about)
        for word in odd:
            for letter in study.indices:
                yield Change(((word.start, word.end, spaced(letter)),), about)


def _arguments(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """A letter after a word that something must follow, where nothing does."""
    for word, after in zip(words, (*words[1:], None), strict=True):
        ends = after is None or after.text in {*_CLOSING, *RELATIONS, "+", "-", ","}
        if word.text in _TAKING and ends:
            for letter in dict.fromkeys(letters):
                place = (word.end, word.end, spaced(" " + letter))
                yield Change((place,), (word.start, word.end))
