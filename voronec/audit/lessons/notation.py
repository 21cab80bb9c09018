r"""What students write, as the words that the reader of LaTeX knows.

LaTeX and plain text go the same way: ``m*v' = a*w^2``, ``d/dt(m v) = ...``, ``thetadot`` become the
words of ``m v' = a w^2``, ``\frac{d}{dt}(m v) = ...``, ``\dot\theta``, each with its place in what
was written.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal

from voronec.audit.latex.tokens import ELEMENTARY, FUNCTION_NAMES, GREEK, Token, tokenize

BASE = "base of exponentials"
"""What the number e is called, which a letter e may not be."""

_SIGNS = str.maketrans(
    {
        "\N{MINUS SIGN}": "-", "\N{MIDDLE DOT}": "*", "\N{MULTIPLICATION SIGN}": "*",
        "\N{DOT OPERATOR}": "*", "\N{PRIME}": "'",
    }
)  # fmt: skip
_DOTS = {"\N{COMBINING DOT ABOVE}": 1, "\N{COMBINING DIAERESIS}": 2}
_LETTER = re.compile("([A-Za-z]|[\u0370-\u03ff])([\u0307\u0308]?)")
_SUPERSCRIPTS = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+")
_BEGINNING = re.compile(r"[\s$]*(?:\\\[|\\\(|\\begin\{[a-z]+\*?\})?\s*")
_END = re.compile(r"(?:\\[,;: ]|[\s$.,;])*(?:\\\]|\\\)|\\end\{[a-z]+\*?\})?[\s$.,;]*$")
_COMMANDS = {
    **{command[1:]: command for command in (*ELEMENTARY, *GREEK)},
    **{f"a{name}": f"\\arc{name}" for name in ("sin", "cos", "tan")},
    "sqrt": "\\sqrt",
}
"""What plain text calls functions and Greek letters."""
_TAIL = re.compile(
    r"(?:\\q?quad|\\\\|\\hfill|\s)+\(\d+[a-z']?\)\s*$|(?:\\q?quad|\\\\\s|\\\\$)+\s*$"
)

_SCIENTIFIC = re.compile(r"\d+(?:\.\d+)?[eE][-+]?\d{1,3}(?!\d)")


def words_of(text: str, spelled: Mapping[str, str]) -> tuple[str, list[Token]]:
    r"""An equation as LaTeX writes it, and its words for the reader.

    ``spelled`` gives the LaTeX of the names that plain text may hold.  It is plain where it holds
    no command of LaTeX; then ``*`` may stand between factors or not.
    """
    source = text.translate(_SIGNS).replace("**", "^ ")
    plain = "\\" not in source.replace("\\cdot", "").replace("\\times", "")
    source = source if source.isascii() else _in_ascii(source, plain)
    words = tokenize(source, *_bounds(source))
    if "e" not in spelled:
        words = _each(_each(words, lambda given, at: _decimal(given, at, source)), _base)
    names = _COMMANDS | dict(spelled) if plain else spelled
    words = _spell_words(source, words, names, plain)
    return source, _each(words, _exponent) if plain else words


def _in_ascii(source: str, plain: bool) -> str:
    """Greek letters, dots above letters and raised digits as LaTeX or plain text write them."""

    def letter(match: re.Match[str]) -> str:
        name, dots = unicodedata.normalize("NFKC", match[1]), _DOTS.get(match[2], 0)
        if not name.isascii():
            words = unicodedata.name(name, "").replace("LAMDA", "LAMBDA").split()
            if words[:1] != ["GREEK"] or words[-2:-1] != ["LETTER"]:
                return match[0]
            name = words[-1].lower() if words[1] == "SMALL" else words[-1].capitalize()
            name = name if plain else f"\\{name} "
        if not dots:
            return name
        return name + "dot" * dots if plain else f"\\{'d' * dots}ot{{{name}}}"

    def exponent(match: re.Match[str]) -> str:
        return f"^{{{unicodedata.normalize('NFKC', match[0])}}}".translate(_SIGNS)

    parted = unicodedata.normalize("NFD", source)  # letters, and what stands above them
    return unicodedata.normalize("NFC", _SUPERSCRIPTS.sub(exponent, _LETTER.sub(letter, parted)))


def _bounds(source: str) -> tuple[int, int]:
    """Without dollars, brackets of displays and a stop at the end."""
    beginning, end = _BEGINNING.match(source), _END.search(source)
    start = beginning.end() if beginning is not None else 0
    stop = end.start() if end is not None else len(source)
    tail = _TAIL.search(source, start, stop)  # the number of the equation, or empty space
    return start, max(start, stop if tail is None else tail.start())


def _base(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    """``e`` before an exponent is the base of the natural logarithm."""
    texts = [w.text for w in words[position : position + 2]]
    named = replace(words[position], kind="text", text=BASE)
    return (position + 1, [named]) if texts == ["e", "^"] else None


def _decimal(words: list[Token], position: int, source: str) -> tuple[int, list[Token]] | None:
    """``1e-9``, written without spaces, as one number."""
    word = words[position]
    match = _SCIENTIFIC.match(source, word.start) if word.kind == "number" else None
    if match is None or "," in word.text:
        return None
    end = _behind(words, position, match.end())
    return end, [replace(word, text=f"{Decimal(match[0]):f}", end=match.end())]


Change = Callable[[list[Token], int], tuple[int, list[Token]] | None]
"""What stands at a position written otherwise, and where it ends; None where it stays."""


def _each(words: list[Token], change: Change) -> list[Token]:
    """The words, changed from left to right."""
    changed: list[Token] = []
    position = 0
    while position < len(words):
        end, written = change(words, position) or (position + 1, [words[position]])
        changed += written
        position = end
    return changed


def _spell_words(
    source: str, words: list[Token], spelled: Mapping[str, str], plain: bool
) -> list[Token]:
    """Runs of letters, and in plain text digits, as the names that they are made of."""
    run = re.compile(r"[A-Za-z]\w*(?:\.\d+)?" if plain else r"(?<![A-Za-z])[A-Za-z]{2,}")

    def spell(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
        word = words[position]
        match = run.match(source, word.start) if word.kind == "letter" else None
        if match is None or not (plain or match[0] in spelled):
            return None
        tokens, at = list[Token](), word.start
        for part in _parts(match[0], spelled) if plain else [match[0]]:
            # the words of a name's LaTeX, all at the place where it was written
            latex = tokenize(spelled.get(part, part))
            tokens += [replace(w, start=at, end=at + len(part)) for w in latex]
            at += len(part)
        return _behind(words, position, at), tokens

    return _each(words, spell)


def _behind(words: Sequence[Token], position: int, end: int) -> int:
    """The position of the first word, from one on, that does not begin before a place."""
    return next((k for k in range(position, len(words)) if words[k].start >= end), len(words))


def _parts(text: str, spelled: Mapping[str, str]) -> list[str]:
    """A run cut into the longest names that are known, from the left; else into single signs."""
    parts, longest = [], max(map(len, spelled), default=1)
    while text:
        size = next((n for n in range(min(len(text), longest), 1, -1) if text[:n] in spelled), 0)
        if not size:
            size = len(re.match(r"\d+(?:\.\d+)?|.", text).group())  # type: ignore[union-attr]
        parts.append(text[:size])
        text = text[size:]
    return parts


def _exponent(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    """``x^12``, ``x^-1``: the whole number, and its sign, stand above."""
    start = position + 1
    end = start + (2 if [w.text for w in words[start : start + 1]] == ["-"] else 1)
    inner = words[start:end]
    if words[position].text != "^" or not inner or inner[-1].kind != "number":
        return None
    at = (inner[0].start, inner[-1].end)
    return end, [words[position], Token("sign", "{", *at), *inner, Token("sign", "}", *at)]


def spelling_of(
    names: Sequence[str], moving: Sequence[str], latex: Callable[[str], str]
) -> dict[str, str]:
    r"""Plain names -> LaTeX; of what moves also ``xdot``, ``xddot``; names of functions."""
    spelling = {name: f"\\mathrm{{{other}}}" for name, other in FUNCTION_NAMES.items()}
    spelling |= {name: latex(name) for name in names}
    for name in moving:
        spelling |= {
            name + "dot" * order: f"\\{'d' * order}ot{{{latex(name)}}}" for order in (1, 2)
        }
        spelling[name + "ddot"] = spelling[name + "dotdot"]
    return spelling


def command_of(text: str) -> str:
    """The command of LaTeX for the word of plain text that something begins with; else nothing."""
    word = re.match("[A-Za-z]*", text)
    return _COMMANDS.get(word[0], "") if word is not None else ""
