"""LaTeX mathematics as words and as a tree of boxes, for its layout only.

Kinds of boxes: ``letter``, ``upright``, ``number``, ``sign``, ``text``, ``function``, ``space``,
``unknown`` are leaves and show ``text``; ``row``; ``fence`` (opening sign, row, closing sign);
``scripts`` (base, below, above; ``text`` is ``limits`` where they stand under and over);
``primed``; ``fraction``; ``root`` (body, degree); ``accent`` and ``over`` with the sign in
``text``; ``table`` (rows of cells), ``text`` says how its columns are aligned, as ``rl``.

Ranges of characters of a formula's source are marked as the boxes that they cover.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from voronec.audit.page.symbols import (
    ACCENTS,
    ACCENTS_OF_WIDTH,
    BRACKETS,
    FONTS,
    FUNCTIONS,
    INVISIBLE,
    LETTERS,
    LIMITS,
    SIGNS,
    SIZES,
    SPACES,
    letter_in_font,
)
from voronec.errors import DefinitionError

_WORD = re.compile(
    r"(?P<space>\s+|%[^\n]*)|(?P<skip>\\(?:label|tag)\s*\{[^}]*\})"
    r"|(?P<begin>\\begin\s*\{(?:array\}\s*\{[^}]*|[a-zA-Z]+\*?)\})|(?P<end>\\end\s*\{[a-zA-Z]+\*?\})"
    r"|(?P<edge>\\(?:left|right)(?![a-zA-Z])\s*(?:\\[a-zA-Z]+|\\.|.))|(?P<row>\\\\(?:\[[^\]]*\])?)"
    r"|(?P<command>\\(?:[a-zA-Z]+|.))|(?P<number>\d+(?:\.\d+)?)|(?P<letter>[^\W\d_])|(?P<sign>.)",
    re.DOTALL,
)


@dataclass(frozen=True)
class Word:
    """One word: ``kind`` is begin, end, edge, row, command, number, letter or sign."""

    kind: str
    text: str
    start: int
    end: int


def split_words(latex: str, offset: int) -> list[Word]:
    """The words that show something; the size of a bracket belongs to the bracket."""
    words: list[Word] = []
    start = -1
    for match in _WORD.finditer(latex):
        text = match.group()
        if match.lastgroup in ("space", "skip") or text in INVISIBLE:
            continue
        start = match.start() if start < 0 else start
        if text not in SIZES:
            words.append(Word(str(match.lastgroup), text, offset + start, offset + match.end()))
            start = -1
    return words


def is_closed(words: Sequence[Word], opening: str) -> bool:
    """Whether a bracket before ``words`` is closed before its group, line or cell ends."""
    depth, groups = 1, 0
    for word in words:
        left = word.kind == "edge" and word.text.startswith("\\left")
        groups += word.text == "{" or word.kind == "begin" or left
        groups -= word.text == "}" or word.kind == "end" or (word.kind == "edge" and not left)
        if groups < 0 or (groups == 0 and (word.kind == "row" or word.text == "&")):
            return False
        if groups == 0:
            depth += (word.text == opening) - (word.text == BRACKETS[opening])
            if depth == 0:
                return True
    return False


_OUTER = re.compile(r"\s*(?:\$\$(.*)\$\$|\$(.*)\$|\\\[(.*)\\\]|\\\((.*)\\\))\s*", re.DOTALL)
_ALIGNMENT = {"eqnarray": "rcl", "matrix": "c", "pmatrix": "c", "bmatrix": "c", "cases": "l"}
_TEXTS = {"\\text", "\\mathrm", "\\mbox", "\\operatorname", "\\textrm", "\\mathsf", "\\mathtt"}
_FENCES = {"pmatrix": "()", "bmatrix": "[]", "vmatrix": "||"}


@dataclass(frozen=True)
class Box:
    """A part of a formula, with its range of characters of the source."""

    kind: str
    start: int
    end: int
    text: str = ""
    parts: tuple[Box, ...] = ()


def read_boxes(latex: str, offset: int = 0) -> Box:
    r"""The tree of a formula, or of a display with its delimiters; ``offset`` is where it starts.

    Raises ``DefinitionError`` where braces, environments or ``\left`` and ``\right`` do not match.
    """
    outer = _OUTER.fullmatch(latex)
    if outer is not None:
        which = outer.lastindex or 0
        return read_boxes(outer[which], offset + outer.start(which))
    parser = _Parser(split_words(latex, offset), latex, offset)
    box = parser.cells(())
    if parser.position < len(parser.words):
        raise DefinitionError(f"'{parser.peek()}' matches nothing before it, in '{latex[:40]}'")
    return box


class _Parser:
    """Recursive descent over the words."""

    def __init__(self, words: list[Word], source: str, offset: int) -> None:
        self.words, self.source, self.offset = words, source, offset
        self.position, self.font = 0, ""

    def peek(self) -> str:
        return self.words[self.position].text if self.position < len(self.words) else ""

    def kind(self) -> str:
        return self.words[self.position].kind if self.position < len(self.words) else ""

    def take(self) -> Word:
        if self.position == len(self.words):
            raise DefinitionError(f"the formula '{self.source[:40]}' ends too early")
        self.position += 1
        return self.words[self.position - 1]

    def expect(self, text: str) -> Word:
        if self.peek() != text:
            raise DefinitionError(f"the formula '{self.source[:40]}' has no '{text}' to match")
        return self.take()

    def cells(self, stops: Sequence[str], alignment: str = "rl") -> Box:
        """A row, or a table where there are line breaks or alignment marks."""
        start = self.words[self.position].start if self.kind() else self.offset
        rows: list[list[Box]] = [[]]
        while True:
            rows[-1].append(self.row(("&", *stops), ends=("end", "row")))
            if self.peek() == "&":
                self.take()
            elif self.kind() == "row":
                self.take()
                rows.append([])
            else:
                break
        if len(rows) > 1 and rows[-1] == [Box("row", rows[-1][0].start, rows[-1][0].end)]:
            rows.pop()
        if len(rows) == 1 and len(rows[0]) == 1:
            return rows[0][0]
        lines = tuple(Box("row", r[0].start, r[-1].end, "", tuple(r)) for r in rows)
        return Box("table", start, lines[-1].end, alignment, lines)

    def row(self, stops: Sequence[str], ends: Sequence[str] = ("end", "row")) -> Box:
        """Items up to a word of ``stops``, or one of a kind in ``ends``."""
        place = self.words[self.position - 1].end if self.position else self.offset
        parts: list[Box] = []
        while self.kind() and self.peek() not in stops and self.kind() not in ends:
            if self.kind() == "edge" and self.peek().startswith("\\right"):
                break
            if self.peek() in "}&":
                break
            parts.append(self.item())
        if not parts:
            return Box("row", place, place)
        return Box("row", parts[0].start, parts[-1].end, "", tuple(parts))

    def item(self) -> Box:
        """An atom with its primes and scripts."""
        start = self.peek()
        if start in ("_", "^"):  # scripts of nothing
            base = Box("row", self.words[self.position].start, self.words[self.position].start)
        else:
            base = self.atom()
        below: Box | None = None
        above: Box | None = None
        primes = 0
        while self.peek() in ("_", "^", "'"):
            sign = self.take()
            if sign.text == "'":
                primes += 1
                base = replace(base, end=sign.end) if base.kind == "primed" else base
                inner = base.parts[0] if base.kind == "primed" else base
                base = Box("primed", base.start, sign.end, "′" * primes, (inner,))
            elif sign.text == "_":
                below = self.argument()
            else:
                above = self.argument()
        if below is None and above is None:
            return base
        end = max(x.end for x in (base, below, above) if x is not None)
        end = self.words[self.position - 1].end if self.position else end
        nothing = Box("row", end, end)
        style = "limits" if start in LIMITS or self.has_limits(base) else ""
        return Box("scripts", base.start, end, style, (base, below or nothing, above or nothing))

    def has_limits(self, base: Box) -> bool:
        """Whether the word ``\\limits``, which is left out of the words, follows the base."""
        return self.source[base.end - self.offset :].lstrip().startswith("\\limits")

    def argument(self) -> Box:
        """A group in braces, or the next atom; of a number only its first digit."""
        if self.peek() == "{":
            return self.group()
        word = self.words[self.position] if self.kind() else self.take()
        if word.kind == "number" and len(word.text) > 1:
            cut = word.start + 1
            head = Word("number", word.text[0], word.start, cut)
            tail = Word("number", word.text[1:], cut, word.end)
            self.words[self.position : self.position + 1] = [head, tail]
        return self.atom()

    def group(self) -> Box:
        opening = self.expect("{")
        body = self.row(("}",))
        closing = self.expect("}")
        return Box("row", opening.start, closing.end, "group", body.parts)

    def atom(self) -> Box:
        if self.peek() == "{":
            return self.group()
        word = self.take()
        if word.kind == "edge":
            return self.stretch(word)
        if word.kind == "begin":
            return self.environment(word)
        if word.text in BRACKETS and is_closed(self.words[self.position :], word.text):
            body = self.row((BRACKETS[word.text],))
            return _fence(word, body, self.take())
        if word.text in SPACES:
            return Box("space", word.start, word.end, str(SPACES[word.text]))
        if word.kind == "command":
            return self.command(word)
        if word.kind == "letter":
            return self.letter(word, word.text)
        if word.text in ("}", "&"):
            raise DefinitionError(f"'{word.text}' matches nothing, in '{self.source[:40]}'")
        shown = {"-": "−", '"': "″"}.get(word.text, word.text)
        return Box("number" if word.kind == "number" else "sign", word.start, word.end, shown)

    def letter(self, word: Word, text: str) -> Box:
        """A letter in the font in force; capital Greek letters are upright in print."""
        upright = "Α" <= text <= "Ω" and not self.font
        kind = "upright" if upright else "letter"
        return Box(kind, word.start, word.end, letter_in_font(text, self.font))

    def stretch(self, word: Word) -> Box:
        r"""``\left`` up to the ``\right`` that matches it."""
        if not word.text.startswith("\\left"):
            raise DefinitionError(f"'{word.text}' matches no \\left, in '{self.source[:40]}'")
        body = self.cells(())
        closing = self.take()
        if not closing.text.startswith("\\right"):
            raise DefinitionError(f"'{word.text}' has no \\right, in '{self.source[:40]}'")
        return replace(_fence(word, body, closing), text="left")

    def environment(self, word: Word) -> Box:
        name = word.text[word.text.index("{") + 1 : word.text.index("}")]
        body = self.cells((), _ALIGNMENT.get(name.rstrip("*"), "c" if name == "array" else "rl"))
        closing = self.take()
        if closing.kind != "end" or closing.text.split("{")[1] != f"{name}}}":
            raise DefinitionError(f"'{word.text}' is not ended, in '{self.source[:40]}'")
        if name not in _FENCES:
            return replace(body, start=word.start, end=closing.end)
        first = Box("sign", word.start, word.end, _FENCES[name][0])
        last = Box("sign", closing.start, closing.end, _FENCES[name][1])
        return Box("fence", word.start, closing.end, "left", (first, body, last))

    def command(self, word: Word) -> Box:
        name = word.text[1:]
        if name in LETTERS:
            return self.letter(word, LETTERS[name])
        if name in SIGNS:
            return Box("sign", word.start, word.end, SIGNS[name])
        if name in FUNCTIONS:
            return Box("function", word.start, word.end, name)
        if word.text in _TEXTS:
            return self.words_of_text(word)
        if name in FONTS:
            outer, self.font = self.font, name
            body = self.argument()
            self.font = outer
            return Box("row", word.start, body.end, "font", body.parts or (body,))
        return self.construct(word, name)

    def construct(self, word: Word, name: str) -> Box:
        if name in ("frac", "dfrac", "tfrac"):
            parts = (self.argument(), self.argument())
            return Box("fraction", word.start, parts[1].end, name, parts)
        if name == "sqrt":
            degree: tuple[Box, ...] = ()
            if self.peek() == "[":
                self.take()
                degree = (self.row(("]",)),)
                self.expect("]")
            body = self.argument()
            return Box("root", word.start, body.end, "", (body, *degree))
        for kind, table in (("accent", ACCENTS), ("over", ACCENTS_OF_WIDTH)):
            if name in table:
                body = self.argument()
                return Box(kind, word.start, body.end, table[name], (body,))
        return Box("unknown", word.start, word.end, word.text)

    def words_of_text(self, word: Word) -> Box:
        """The argument as it stands, with formulas between dollar signs read."""
        if self.peek() != "{":
            body = self.argument()
            return replace(body, kind="upright", start=word.start)
        opening = self.take()
        depth = 1
        while depth:
            depth += {"{": 1, "}": -1}.get(self.take().text, 0)
        closing = self.words[self.position - 1]
        at = opening.end - self.offset
        pieces = re.split(r"(\$[^$]*\$)", self.source[at : closing.start - self.offset])
        parts, start = [], opening.end
        for piece in pieces:
            if piece.startswith("$"):
                parts.append(read_boxes(piece, start))
            elif piece:
                parts.append(Box("text", start, start + len(piece), _plain(piece)))
            start += len(piece)
        if word.text == "\\operatorname" and len(parts) == 1:
            return replace(parts[0], kind="function", start=word.start, end=closing.end)
        if len(parts) == 1 and parts[0].kind == "text":
            return replace(parts[0], start=word.start, end=closing.end)
        return Box("row", word.start, closing.end, "", tuple(parts))


def _plain(text: str) -> str:
    r"""Words of text without the commands for spaces: ``for\;all``."""
    return re.sub(r"\\[,;:! ]|~|\s+", " ", text).replace("\\", "")


def _fence(opening: Word, body: Box, closing: Word) -> Box:
    parts = (_edge(opening), body, _edge(closing))
    return Box("fence", opening.start, closing.end, "", parts)


def _edge(word: Word) -> Box:
    text = re.sub(r"\\(?:left|right)(?![a-zA-Z])\s*", "", word.text)
    if text.startswith("\\"):
        text = SIGNS.get(text[1:], text)
    return Box("sign", word.start, word.end, "" if text == "." else text)


@dataclass(frozen=True)
class Marks:
    """Ranges (start, end) that are to be highlighted."""

    ranges: Sequence[tuple[int, int]]

    @classmethod
    def of(cls, ranges: Sequence[tuple[int, int]], formula: Box) -> Marks:
        """The ranges, where a change in a name's index or exponent is one of the whole name."""
        names = sorted(_names(formula), key=lambda box: box.end - box.start)
        return cls([_whole(names, a, b) for a, b in ranges])

    def cover(self, box: Box) -> bool:
        """Whether a box lies within one range, whatever its font, or the size of a bracket."""
        start, end = box.start, box.end
        if box.kind == "sign" and start < end:
            start = end - 1
        elif box.text == "font":
            start, end = box.parts[0].start, box.parts[-1].end
        return start < end and any(a <= start and end <= b for a, b in self.ranges)

    def groups(self, parts: Sequence[Box]) -> Iterator[tuple[tuple[Box, ...], bool]]:
        """The parts of a row in runs, each marked as a whole or not."""
        run: list[Box] = []
        marked = False
        for box in parts:
            covered = self.cover(box)
            if run and covered != marked:
                yield tuple(run), marked
                run = []
            marked = covered
            run.append(box)
        if run:
            yield tuple(run), marked

    def runs(self, box: Box) -> Iterator[tuple[Box, ...]]:
        """The largest runs of boxes that are marked as a whole, in the order of print.

        A run never reaches over the arguments of a command, or over the cells of a table.
        """
        if box.kind == "table":
            for cell in (cell for row in box.parts for cell in row.parts):
                yield from self.runs(cell)
        elif box.kind == "row":
            for group, marked in self.groups(box.parts):
                if marked:
                    yield group
                else:
                    for part in group:
                        yield from self.runs(part)
        else:
            growing = box.kind == "fence" and box.text == "left"  # its two ends belong together
            for part in box.parts[1:2] if growing else box.parts:
                if self.cover(part):
                    yield (part,)
                else:
                    yield from self.runs(part)


_LETTERS = frozenset({"letter", "upright", "accent", "over", "primed", "unknown", "number"})


def _names(box: Box) -> Iterator[Box]:
    """The letters with an index or an exponent."""
    if box.kind == "scripts" and not box.text:
        base = box.parts[0]
        if base.kind in _LETTERS or base.text in ("font", "group"):
            yield box
    for part in box.parts:
        yield from _names(part)


def _whole(names: Sequence[Box], start: int, end: int) -> tuple[int, int]:
    """The narrowest name whose scripts hold the range, or the range itself."""
    for name in names:
        if start < end and name.parts[0].end <= start and end <= name.end:
            return name.start, name.end
    return start, end


RELATIONS = frozenset("= < > ≠ ≤ ≥ ⩽ ⩾ ≡ ≈ ∼ ∈ → ↦ ⟼ ⇒ ⟺".split())
BINARY = frozenset("+ − ± ∓ ⊕ ∧".split())
LONG = 40
"""Brackets around more leaves than these may be broken inside."""


def stretches(formula: Box) -> list[tuple[Box, ...]]:
    """The parts of a formula between the places where a line may end.

    A line may end before a relation, before a sum's sign, and behind a wide space.
    """
    items = list(_without_brackets(formula.parts)) if formula.kind == "row" else [formula]
    cuts = [i for i in range(1, len(items)) if _breaks(items[i - 1], items[i])]
    return [tuple(items[a:b]) for a, b in pairwise([0, *cuts, len(items)])]


def _without_brackets(parts: Sequence[Box]) -> Iterator[Box]:
    """The parts of a row; long brackets are three of them."""
    for box in parts:
        if box.kind == "fence" and box.parts[1].kind == "row" and _leaves(box) > LONG:
            yield box.parts[0]
            yield from _without_brackets(box.parts[1].parts)
            yield box.parts[2]
        else:
            yield box


def _leaves(box: Box) -> int:
    return sum(map(_leaves, box.parts)) if box.parts else 1


def _breaks(before: Box, box: Box) -> bool:
    """Whether a line may end between two boxes."""
    if before.kind == "space" and float(before.text) >= 1 and box.kind != "space":
        return True
    if box.kind != "sign" or box.text not in RELATIONS | BINARY:
        return False
    return before.kind != "sign" or before.text in (")", "]", "}", "|", "!")
