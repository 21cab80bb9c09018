"""From the source of a display to its formulas: labels, lines, lists, quantifiers."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from voronec.audit.latex.tokens import ELLIPSES, Token, tokenize
from voronec.errors import DefinitionError

_PLACES = {"\\in", "\\colon", "\\longmapsto", "\\mapsto"}
RELATIONS = {"=", "<", ">", "\\ne", "\\neq", "\\le", "\\leq", "\\ge", "\\geq"} | _PLACES
_OPENING = re.compile(r"\s*(?:\\begin\{([a-zA-Z]+\*?)\}|(\\\[)|(\$\$)|(\$))", re.DOTALL)
_CLOSING = {"\\[": "\\]", "$$": "$$", "$": "$"}
_LABEL = re.compile(r"\\label\s*\{([^}]*)\}")
_NUMBERED_LINES = {"eqnarray", "align", "gather"}
_KNOWN = {"equation", "displaymath", "math", "multline", "flalign", *_NUMBERED_LINES}
"""Environments of displays; another is not opened, and the reader says that it is not read."""
_OPEN, _CLOSE = {"(", "[", "{", "\\{"}, {")", "]", "}", "\\}"}


@dataclass(frozen=True)
class Piece:
    """One formula: the range of the display's source it stands in, and its quantifiers.

    ``tokens`` are its words (of two lines, where the second only goes on with the first),
    ``phrase`` the words of text before its last quantifier, as "for all".
    """

    tokens: tuple[Token, ...]
    quantifiers: tuple[tuple[Token, ...], ...] = ()
    phrase: str = ""

    @property
    def at(self) -> tuple[int, int]:
        """Where the formula starts and ends in the display's source."""
        return self.tokens[0].start, self.tokens[-1].end


@dataclass(frozen=True)
class FormulaUnit:
    """What bears one number in print: a label or none, source text, formulas.

    ``display`` is the source in which the places of the pieces are counted, ``condition`` a word
    such as "if", which says that they need not hold always.
    """

    label: str | None
    source: str
    pieces: tuple[Piece, ...]
    display: str
    condition: str = ""


def split_display(latex: str) -> tuple[FormulaUnit, ...]:
    """The numbered units of a display, given with its delimiters, each with its formulas.

    In ``eqnarray`` and its like every line without ``\\nonumber`` closes a unit; else the whole
    display is one.  A line that starts with a relation goes on with the formula before it, and so
    does a line without a relation, unless the line before ends with a comma or a stop.
    """
    environment, start, end = _body(latex)
    lines = _lines(latex, start, end)
    if environment not in _NUMBERED_LINES:
        return (_unit(latex, lines),)
    units: list[FormulaUnit] = []
    waiting: list[tuple[int, int]] = []
    for line in lines:
        waiting.append(line)
        if "\\nonumber" not in latex[slice(*line)] and "\\notag" not in latex[slice(*line)]:
            units.append(_unit(latex, waiting))
            waiting = []
    return tuple(units + ([_unit(latex, waiting)] if waiting else []))


def _body(latex: str) -> tuple[str, int, int]:
    """Name of the environment, and the range between its delimiters."""
    match = _OPENING.match(latex)
    if match is None:
        start = " ".join(latex.split())[:40]
        raise DefinitionError(f"display '{start}': it must start with \\begin{{...}}, \\[, $$ or $")
    mark = next(g for g in match.groups() if g)
    closing = _CLOSING.get(mark, f"\\end{{{mark}}}")
    end = latex.rfind(closing)
    if end < match.end():
        raise DefinitionError(f"display '{' '.join(latex.split())[:40]}': '{closing}' is missing")
    if mark not in _CLOSING and mark.rstrip("*") not in _KNOWN:
        return mark, 0, len(latex)
    return mark, match.end(), end


_INNER = re.compile(r"\\(?:begin|end)\{(?:aligned|split|gathered)\}(?:\[[tbc]\])?")
_UNREAD = re.compile(r"\\begin\{(?!(?:aligned|split|gathered)\})([^}]*)\}.*?\\end\{\1\}", re.DOTALL)
_BREAK = re.compile(r"\\\\\*?(?:\s*\[-?[\d.]+(?:\\\w+|pt|mm|cm|in|ex|em)\])?")


def _lines(latex: str, start: int, end: int) -> list[tuple[int, int]]:
    """Ranges of the lines that a double backslash separates; inner environments are opened, unless
    they are not known."""
    closed = [m.span() for m in _UNREAD.finditer(latex, start, end)]
    breaks = (m.span() for sign in (_INNER, _BREAK) for m in sign.finditer(latex, start, end))
    cuts = [cut for cut in breaks if not any(a <= cut[0] < b for a, b in closed)]
    lines, position = [], start
    for a, b in [*sorted(cuts), (end, end)]:
        if _LABEL.sub("", latex[position:a]).strip():
            lines.append((position, a))
        position = b
    return lines


_NUMBER = re.compile(r"\(\d+[a-z']?\)")
"""What a formula may be called behind it."""
_CONDITIONS = re.compile(
    r"\W*(if|when|whenever|unless|while|provided|on|at|for(?! (?:all|any|every|each|some|no)))\b",
    re.IGNORECASE,
)
"""Words behind which a condition stands."""


def _unit(latex: str, lines: list[tuple[int, int]]) -> FormulaUnit:
    labels = [m.group(1) for m in _LABEL.finditer(latex)] if len(lines) else []
    inside = [m.group(1) for a, b in lines for m in _LABEL.finditer(latex, a, b)]
    label = inside[-1] if inside else (labels[0] if len(set(labels)) == 1 else None)
    pieces: list[Piece] = []
    said: tuple[Token, ...] = ()
    ended = False
    condition = ""
    for a, b in lines:
        tokens = tokenize(latex, a, b)
        for words in _split_list(tokens):
            if not condition and _is_text(words) and (m := _CONDITIONS.match(words[0].text)):
                condition = m[1]
            if not _is_text(words) and not _NUMBER.fullmatch("".join(w.text for w in words)):
                _append(pieces, words, said, ended)
            said, ended = words, True
        ended = bool(tokens) and tokens[-1].text in _SEPARATORS
    source = "\\\\ ".join(_LABEL.sub("", latex[a:b]).strip() for a, b in lines)
    return FormulaUnit(label, source, tuple(pieces), latex, condition)


def _append(
    pieces: list[Piece], words: tuple[Token, ...], said: tuple[Token, ...], ended: bool
) -> None:
    """Add a formula; join it to the last one where it goes on with that, or quantifies it.

    ``said`` is what stands before it, ``ended`` whether a comma, a stop or a wide space does.
    """
    last = pieces[-1] if pieces else None
    if last and _is_quantifier(words, said):
        inside = words[1:-1] if words[0].text == "(" else words
        phrase = " ".join(_SPACE.sub(" ", said[0].text).split()) if _is_text(said) else ""
        pieces[-1] = Piece(last.tokens, (*last.quantifiers, inside), phrase)
    elif _is_text(said) and words[0].text in RELATIONS:
        pieces.append(Piece(said + words))
    elif last and (words[0].text in RELATIONS or not (ended or _relates(words, last.tokens))):
        pieces[-1] = Piece(last.tokens + words, last.quantifiers, last.phrase)
    else:
        pieces.append(Piece(words))


_SPACE = re.compile(r"\\[,;:! ]|~")


def _is_quantifier(words: tuple[Token, ...], said: tuple[Token, ...]) -> bool:
    r"""``(i=1,\dots,n)``, or what stands after words such as "for all"."""
    if words[0].text == "(" and words[-1].text == ")":
        return not ELLIPSES.isdisjoint(w.text for w in words)
    return _is_text(said) and "\\in" in {w.text for w in words}


def _is_text(words: tuple[Token, ...]) -> bool:
    return len(words) == 1 and words[0].kind in ("text", "name") and words[0].text != "const"


def _relates(*several: tuple[Token, ...]) -> bool:
    """Whether each of some formulas has a relation."""
    return all(any(w.text in RELATIONS for w in words) for words in several)


def _split_list(tokens: list[Token]) -> list[tuple[Token, ...]]:
    r"""Split at top-level commas, wide spaces, stops and words of text.

    Text stands by itself, but for "const" and what follows a colon; dots between formulas, and
    a stop behind a formula with an open bracket, are left out.
    """
    parts: list[list[Token]] = [[]]
    depth = 0
    for position, token in enumerate(tokens):
        after = tokens[position + 1 : position + 2]
        depth += token.text in _OPEN or token.text.startswith("\\begin{")
        depth -= token.text in _CLOSE or token.text.startswith("\\end{")
        if depth == 0 and _is_word(token, parts[-1], after):
            parts += [[token], []]
        elif depth == 0 and token.text in _SEPARATORS and not _is_decimal(token, parts[-1], after):
            parts.append([])
        else:
            parts[-1].append(token)
    if depth != 0 and parts[-1] and parts[-1][-1].text in _SEPARATORS:
        parts[-1].pop()
    return [tuple(p) for p in parts if p and not (len(p) == 1 and p[0].text in ELLIPSES)]


_SEPARATORS = {",", ".", ";", "\\quad", "\\qquad"}


def _is_decimal(token: Token, before: list[Token], after: list[Token]) -> bool:
    """Whether a comma stands between digits, where it may be that of a decimal fraction."""
    near = [*before[-1:], token, *after]
    numbers = len(near) == 3 and near[0].kind == near[2].kind == "number"
    return numbers and near[0].end == token.start and token.end == near[2].start


def _is_word(token: Token, before: list[Token], after: list[Token]) -> bool:
    """Whether a word of text stands between formulas; one without spaces stands there alone."""
    if token.kind == "name":
        return not before and all(word.text in _SEPARATORS for word in after)
    told = bool(before) and before[-1].text in RELATIONS | {"+", "-"}
    return token.kind == "text" and token.text != "const" and not told


def script_ranges(words: Sequence[Token]) -> Iterator[tuple[int, int]]:
    """Positions of the words that make up each subscript and superscript, braces included."""
    for position, word in enumerate(words[:-1]):
        if word.text in ("_", "^"):
            yield position + 1, group_end(words, position + 1)


def group_end(words: Sequence[Token], position: int) -> int:
    """The position behind the word, or the group in braces, that starts at ``position``."""
    depth = 0
    while position < len(words):
        depth += (words[position].text == "{") - (words[position].text == "}")
        position += 1
        if depth == 0:
            break
    return position
