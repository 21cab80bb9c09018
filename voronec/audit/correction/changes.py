"""The single changes of a printed formula, in the order in which they are believed.

A change replaces characters of the print: a letter with its font, a number, a sign, an index; or it
leaves out a word, a factor, a term, or puts in a factor, a prime, an exponent.  Each kind of change
is a function of the words, and has its line in ``single_changes``; ``repairs`` closes brackets.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from voronec.audit.latex.displays import RELATIONS, group_end, script_ranges
from voronec.audit.latex.factors import (
    CLOSERS,
    EDGES,
    FRACTIONS,
    factor_end,
    term_end,
)
from voronec.audit.latex.nodes import Elementary, Name, Number, Power, walk
from voronec.audit.latex.reader import read
from voronec.audit.latex.tables import BEGINNINGS, ENDS
from voronec.audit.latex.tokens import ACCENTS, ELEMENTARY, GREEK, Token, tokenize
from voronec.audit.latex.vocabulary import CALL, LatexVocabulary
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript
from voronec.errors import DefinitionError

Piece = tuple[int, int, str]
"""Replace the characters from, to by a text."""


@dataclass(frozen=True)
class Change:
    """Replacements that make one change; ``rank`` is the place of its kind."""

    pieces: tuple[Piece, ...]
    rank: int = 0

    @classmethod
    def at(cls, start: int, end: int, text: str) -> Change:
        """One replacement."""
        return cls(((start, end, text),))


@dataclass(frozen=True)
class Spare:
    """What a section prints elsewhere: index expressions as ``{n+\\nu}``, letters with their fonts,
    names with their indices, whole formulas.

    A formula is given as its words without spacing, to compare neighbours with.
    """

    indices: tuple[str, ...] = ()
    letters: tuple[str, ...] = ()
    factors: tuple[str, ...] = ()
    formulas: tuple[str, ...] = ()

    @classmethod
    def of(cls, transcript: Transcript, study: Study) -> Spare:
        """Collect them."""
        formulas = list(transcript.formulas())
        texts = tuple("".join(f.printed.split()) for f in formulas)
        letters = dict.fromkeys(x.text for f in formulas for x in _letters(f.piece.tokens))
        factors = dict.fromkeys(
            name for f in formulas for name in _names(f.piece.tokens, f.unit.display)
        )
        return cls(transcript.indices(study), tuple(letters), tuple(factors), texts)


def apply_pieces(printed: str, pieces: Sequence[Piece]) -> tuple[str, tuple[tuple[int, int], ...]]:
    """The changed text, and where the new words stand in it."""
    text, last, marks = "", 0, []
    for start, end, new in sorted(pieces):
        if new.endswith(" ") and not printed[end : end + 1].isalpha():
            new = new.rstrip()
        text += printed[last:start]
        if new[:1].isalpha() and re.search(r"\\[a-zA-Z]+$", text):
            new = " " + new  # a letter behind a command
        marks.append((len(text), len(text) + len(new)))
        text, last = text + new, end
    return text + printed[last:], tuple(marks)


@dataclass(frozen=True)
class _Letter:
    r"""``\mathbf G``: the command of the font or accent, or nothing, the letter, its range, and
    that of the letter alone."""

    accent: str
    letter: str
    start: int
    end: int
    bare: tuple[int, int]

    @classmethod
    def of(cls, letter: Token, font: Token | None = None, last: Token | None = None) -> _Letter:
        """A letter by itself, or with the word of its font up to the ``last`` word."""
        first, last = font or letter, last or letter
        bare = (letter.start, letter.end)
        return cls(font.text if font else "", letter.text, first.start, last.end, bare)

    @property
    def text(self) -> str:
        """One spelling, to be put in another place."""
        return (self.accent + " " if self.accent else "") + _with_spaces(self.letter)


def _is_letter(word: Token) -> bool:
    return word.kind == "letter" or word.text in GREEK


def _with_spaces(text: str) -> str:
    """A word that a letter may follow."""
    return text + " " if re.search(r"\\[a-zA-Z]+$", text) else text


def _letters(words: Sequence[Token]) -> Iterator[_Letter]:
    r"""All letters; ``\mathbf{G}`` is one, like ``\mathbf G``."""
    skip = 0
    for position, word in enumerate(words):
        inside = words[position + 1 : position + 4]
        if position < skip:
            continue
        if word.text in ACCENTS and inside and _is_letter(inside[0]):
            yield _Letter.of(inside[0], word, inside[0])
            skip = position + 2
        elif word.text in ACCENTS and len(inside) == 3 and _are_braced(inside):
            yield _Letter.of(inside[1], word, inside[2])
            skip = position + 4
        elif _is_letter(word):
            yield _Letter.of(word)


def _are_braced(words: Sequence[Token]) -> bool:
    return (words[0].text, words[2].text) == ("{", "}") and _is_letter(words[1])


def _names(words: Sequence[Token], source: str) -> Iterator[str]:
    r"""The letters as they are printed, with primes and what stands below: ``R_1``, ``\mu'``."""
    ends = {words[start - 1].start: words[end - 1].end for start, end in script_ranges(words)}
    marks = {word.start: word for word in words if word.text in ("_", "'", '"')}
    for letter in _letters(words):
        end = letter.end
        while end in marks:
            end = ends.get(end, marks[end].end)
        yield source[letter.start : end]


def single_changes(printed: str, study: Study, spare: Spare) -> list[Change]:
    """Every change that is tried, the believable ones first."""
    words = tokenize(printed)
    printed_letters = [letter.text for letter in _letters(words)]
    known = [name for name, value in study.names.items() if not callable(value)]
    letters = [x.text for key in study.table for x in _letters(tokenize(_bare_key(key)))]
    kinds = (
        (*_differentials(words), *_missing_relations(words)),
        _exchanges(words),
        _index_edits(words, study, spare.indices),
        _mark_edits(words, [printed, *spare.formulas]),
        _letter_edits(words, printed_letters, study),
        _digit_edits(words),
        _script_edits(words),
        _omissions(words),
        _put_in(words, (*_NUMBERS, *_own_factors(printed, words, study))),
        _font_edits(words, study),
        _letter_edits(words, spare.letters, study),
        _put_in(words, _with_squares([*spare.factors, *known], study)),
        _letter_edits(words, letters, study),
        _transpositions(words),
    )
    changes: dict[tuple[Piece, ...], Change] = {}
    for rank, kind in enumerate(kinds):
        for change in kind:
            pieces = tuple(p for p in change.pieces if printed[p[0] : p[1]] != p[2])
            if pieces:
                changes.setdefault(pieces, Change(pieces, rank))
    return list(changes.values())


def _bare_key(key: str) -> str:
    return key.removesuffix(CALL).replace("#", "")


def _with_squares(names: Sequence[str], study: Study) -> list[str]:
    names = [name for name in dict.fromkeys(names) if name not in study.indices]
    return [*names, *(f"{name}^2" for name in names)]


_COMPANIONS = {"+": "-", "-": "+", "<": ">", ">": "<", "\\sin": "\\cos", "\\cos": "\\sin"}
_NUMBERS = ("\\frac12", "2")
_HEADS = {"(", "[", *RELATIONS, *BEGINNINGS, "&", "\\\\"}
"""Words behind which a first term stands."""


def _exchanges(words: Sequence[Token]) -> Iterator[Change]:
    """Signs, sine and cosine; a sign at the head of a side or a bracket."""
    for before, word in zip((None, *words), words, strict=False):
        heads = before is not None and before.text in _HEADS
        if heads and word.text not in ("+", "-"):
            yield Change.at(word.start, word.start, "-")
        if word.text in _COMPANIONS:
            yield Change.at(word.start, word.end, _COMPANIONS[word.text])


def _index_edits(words: Sequence[Token], study: Study, spare: Sequence[str]) -> Iterator[Change]:
    """Another index: a letter for a letter, then a whole index expression."""
    letters = [w for w in dict.fromkeys(t.text for t in words) if w in study.indices]
    for start, end in script_ranges(words):
        for word in words[start:end]:
            if word.text in study.indices:
                yield from (Change.at(word.start, word.end, _with_spaces(x)) for x in letters)
    for start, end in script_ranges(words):
        inside = {w.text for w in words[start:end]} & set(study.indices)
        for other in spare if inside else ():
            if inside == {t.text for t in tokenize(other)} & set(study.indices):
                yield Change.at(words[start].start, words[end - 1].end, other)


def _mark_edits(words: Sequence[Token], texts: Sequence[str]) -> Iterator[Change]:
    r"""A prime or a dot more or less; a dot only on letters that have one elsewhere."""
    dotted = {m for text in texts for m in re.findall(r"\\dot\s*\{?\s*(\\?[a-zA-Z]+)", text)}
    for word in words:
        if word.text in ("'", "\\dot"):
            yield Change.at(word.start, word.end, "")
        elif _is_letter(word):
            yield Change.at(word.end, word.end, "'")
            if word.text in dotted:
                yield Change.at(word.start, word.start, "\\dot ")


def _letter_edits(words: Sequence[Token], texts: Sequence[str], study: Study) -> Iterator[Change]:
    """A letter, with its font, for a letter or a number."""
    texts = [x for x in dict.fromkeys(texts) if x.strip() not in study.indices]
    for place in _letters(words):
        font = f"{place.accent} "
        for text in texts:
            same = bool(place.accent) and text.startswith(font)
            at = place.bare if same else (place.start, place.end)
            yield Change.at(*at, text.removeprefix(font) if same else text)
    for word in words:
        if word.kind == "number":
            yield from (Change.at(word.start, word.end, text) for text in texts)


def _digit_edits(words: Sequence[Token]) -> Iterator[Change]:
    """One digit for another, or none; a number that is an exponent or a factor is not 1 or 0."""
    for before, word, after in zip((None, *words), words, (*words[1:], None), strict=False):
        raised = before is not None and before.text == "^"
        factor = after is not None and (_is_letter(after) or after.text in ("(", "["))
        alone = (raised or factor) and len(word.text) == 1
        if word.kind == "number" and alone:
            yield Change.at(word.start, word.end, "")
        for place, old in enumerate(word.text, start=word.start) if word.kind == "number" else ():
            digits = "23456789" if alone else "2345678910"
            yield from (Change.at(place, place + 1, x) for x in digits if old.isdigit())


def _script_edits(words: Sequence[Token]) -> Iterator[Change]:
    """An index 1, or a power, more or less."""
    for word in words:
        if _is_letter(word) or word.text in (")", "]", *ELEMENTARY):
            more = ("_1", "^2", "^3") if _is_letter(word) else ("^2",)
            yield from (Change.at(word.end, word.end, text) for text in more)
    for start, end in script_ranges(words):
        sign, a, b = words[start - 1].text, words[start - 1].start, words[end - 1].end
        if words[start].kind == "number" or sign == "_":
            yield Change.at(a, b, "")
        yield Change.at(b, b, "^2") if sign == "_" else Change.at(words[start].start, b, "2")


def _omissions(words: Sequence[Token]) -> Iterator[Change]:
    """The formula without a word, then without a factor, a denominator, a term."""
    structure = {*CLOSERS, *CLOSERS.values(), "^", "_", ",", *RELATIONS, *ENDS, *BEGINNINGS}
    places = [i for i, word in enumerate(words) if word.text not in structure]
    yield from (_without(words, i, i + 1) for i in places)
    heads = [i for i, word in enumerate(words) if word.text in ("(", "[") or i in places]
    yield from (_without(words, i, factor_end(words, i)) for i in heads)
    for i, top, end in _braced_fractions(words):
        bottom = (words[top - 1].start, words[end - 1].end, "")
        yield Change(((words[i].start, words[i + 1].end, ""), bottom))
    for i, word in enumerate(words):
        if i == 0 or word.text in ("+", "-") or words[i - 1].text in {*CLOSERS, *RELATIONS}:
            yield _without(words, i, term_end(words, i))


def _without(words: Sequence[Token], start: int, end: int) -> Change:
    """Words left out, with the space behind a command, or the plus sign after a first term."""
    leads = start == 0 or words[start - 1].text in {*RELATIONS, *CLOSERS}
    last, after = words[end - 1].end, words[end : end + 1]
    if after and leads and after[0].text == "+":
        last = after[0].end
    elif after and leads and words[end - 1].text.startswith("\\"):
        last = after[0].start
    return Change.at(words[start].start, last, "")


def _put_in(words: Sequence[Token], texts: Sequence[str]) -> Iterator[Change]:
    """A factor more in a term: a power behind it first, all else before it, behind its number."""
    scripts = {i for start, end in script_ranges(words) for i in range(start - 1, end)}
    heads = [
        i
        for i, word in enumerate(words)
        if i not in scripts
        and word.text not in EDGES
        and (i == 0 or words[i - 1].text in {*EDGES, *CLOSERS})
    ]
    places = [(_numeral_end(words, i), term_end(words, i)) for i in heads]
    for text in texts:
        for start, end in places:
            number = text in _NUMBERS
            spots = [words[start].start if start < end else words[start - 1].end]
            if number and start and words[start - 1].kind == "number":
                continue
            if not number:
                spots.insert(0 if "^" in text else 1, words[end - 1].end)
            yield from (Change.at(spot, spot, _with_spaces(text)) for spot in spots)


def _numeral_end(words: Sequence[Token], start: int) -> int:
    """The position behind the number, or the fraction of numbers, that may stand at ``start``."""
    end = factor_end(words, start)
    inside = words[start + (words[start].text in FRACTIONS) : end]
    return end if all(w.kind == "number" or w.text in "{}" for w in inside) else start


def _own_factors(printed: str, words: Sequence[Token], study: Study) -> list[str]:
    """What a formula is made of: its names, then what else it multiplies, then squares of names."""
    names = [name for name in dict.fromkeys(_names(words, printed)) if name not in study.indices]
    try:
        parts = list(walk(read(printed, study.vocabulary)))
    except DefinitionError:
        parts = []
    raised = [p for p in parts if isinstance(p, Power) and isinstance(p.exponent, Number)]
    texts = [printed[slice(*p.at)] for p in raised if isinstance(p.base, Name)]
    texts += [printed[slice(*p.at)] for p in parts if isinstance(p, Elementary)]
    return [*dict.fromkeys((*names, *texts, *(f"{name}^2" for name in names)))]


def _font_edits(words: Sequence[Token], study: Study) -> Iterator[Change]:
    """Another font or accent of a letter, at one place, then at all its places."""
    known = _known_fonts(study)
    everywhere: dict[tuple[str, str, str], list[Piece]] = {}
    for place in _letters(words):
        for accent in ("", *known.get(place.letter, ())):
            if accent != place.accent:
                piece = (place.start, place.end, replace(place, accent=accent).text)
                yield Change((piece,))
                everywhere.setdefault((place.accent, place.letter, accent), []).append(piece)
    yield from (Change(tuple(pieces)) for pieces in everywhere.values())


def _known_fonts(study: Study) -> Mapping[str, Sequence[str]]:
    """Letter -> fonts and accents that the dictionary has it with."""
    fonts_by_letter: dict[str, dict[str, None]] = {}
    for key in study.table:
        match = re.match(r"(\\[a-z]+)\{(.+?)\}", key)
        if match and match.group(1) in ACCENTS:
            fonts_by_letter.setdefault(match.group(2), {})[match.group(1)] = None
    return {letter: tuple(fonts) for letter, fonts in fonts_by_letter.items()}


def _transpositions(words: Sequence[Token]) -> Iterator[Change]:
    """Two letters that follow each other exchanged."""
    for one, two in pairwise(_letters(words)):
        yield Change(((one.start, one.end, two.text), (two.start, two.end, one.text)))


def _differentials(words: Sequence[Token]) -> Iterator[Change]:
    r"""``\partial`` or ``d`` where only the other half of a fraction begins with it."""
    for i, top_end, _ in _braced_fractions(words):
        top, bottom = words[i + 2], words[top_end + 1]
        for sign in ("\\partial", "d"):
            if (top.text == sign) != (bottom.text == sign):
                place = (bottom if top.text == sign else top).start
                yield Change.at(place, place, _with_spaces(sign))


def _braced_fractions(words: Sequence[Token]) -> Iterator[tuple[int, int, int]]:
    """Where fractions with braces start, and the positions behind both of their halves."""
    for i, word in enumerate(words):
        if word.text in FRACTIONS and [w.text for w in words[i + 1 : i + 2]] == ["{"]:
            top = group_end(words, i + 1)
            if top + 1 < len(words) and words[top].text == "{":
                yield i, top, group_end(words, top)


def _missing_relations(words: Sequence[Token]) -> Iterator[Change]:
    """In an expression without a relation: ``=`` for a sign between its terms, or ``=0`` after."""
    if any(w.text in RELATIONS for w in words):
        return
    yield Change.at(words[-1].end, words[-1].end, "=0")
    depth = 0
    for word in words:
        depth += (word.text in CLOSERS) - (word.text in CLOSERS.values())
        if depth == 0 and word.text in ("+", "-") and word is not words[0]:
            yield Change.at(word.start, word.end, "=")


def repairs(printed: str) -> list[Change]:
    """What may close the brackets that are open: all of them at the end first, then the last one
    at each place before.
    """
    words = tokenize(printed)
    opened = _open_brackets(words)
    if not opened:
        return []
    last = words[-1].end
    ends = [w.end for w in reversed(words) if w.start >= opened[-1].end]
    at_end = [Change.at(last, last, _closers(opened))] if len(opened) > 1 else []
    return at_end + [Change.at(end, end, CLOSERS[opened[-1].text]) for end in ends]


def close_brackets(printed: str, vocabulary: LatexVocabulary | None = None) -> str | None:
    """The formula with all open brackets closed at its end, if that can be read."""
    opened = _open_brackets(tokenize(printed))
    if not opened:
        return None
    text = printed + _closers(opened)
    try:
        read(text, vocabulary)
    except DefinitionError:
        return None
    return text


def _open_brackets(words: Sequence[Token]) -> list[Token]:
    """Those that nothing closes; a bracket may close behind one inside it that does not."""
    opened: list[Token] = []
    for word in words:
        if word.text in CLOSERS:
            opened.append(word)
        fitting = [w for w in opened if CLOSERS[w.text] == word.text]
        if fitting:
            opened.remove(fitting[-1])
    return opened


def _closers(opened: Sequence[Token]) -> str:
    return "".join(CLOSERS[word.text] for word in reversed(opened))
