r"""What students write, as the words that the reader of LaTeX knows.

LaTeX and plain text go the same way: ``m*v' = a*w^2``, ``d/dt(m v) = ...``, ``thetadot`` become the
words of ``m v' = a w^2``, ``\frac{d}{dt}(m v) = ...``, ``\dot\theta``, each with its place in what
was written.
"""

from __future__ import annotations

import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from itertools import pairwise
from typing import Any

from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.doubts import open_argument
from voronec.audit.latex.tokens import (
    ELEMENTARY,
    GREEK,
    Ambiguous,
    Misprint,
    Token,
    complain,
    tokenize,
)
from voronec.audit.latex.vocabulary import LatexVocabulary

__all__ = ["command_of", "spelling_of", "words_of"]

_SIGNS = str.maketrans(
    {
        "\N{MINUS SIGN}": "-", "\N{MIDDLE DOT}": "*", "\N{MULTIPLICATION SIGN}": "*",
        "\N{DOT OPERATOR}": "*", "\N{PRIME}": "'",
    }
)  # fmt: skip
_DOTS = {"\N{COMBINING DOT ABOVE}": 1, "\N{COMBINING DIAERESIS}": 2}
_LETTER = re.compile("([A-Za-z]|[\u0370-\u03ff])([\u0307\u0308]?)")
_NO_RATIO = ("^", "t", "L", "T", "V")
"""What does not stand behind the ``d`` of a quotient of changes."""
_SUPERSCRIPTS = re.compile("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+")
_BEGINNING = re.compile(r"[\s$]*(?:\\\[|\\\(|\\begin\{[a-z]+\*?\})?\s*")
_END = re.compile(r"(?:\\[,;: ]|[\s$.,;])*(?:\\\]|\\\)|\\end\{[a-z]+\*?\})?[\s$.,;]*$")
_COMMANDS = {
    **{command[1:]: command for command in (*ELEMENTARY, *GREEK)},
    **{f"a{name}": f"\\arc{name}" for name in ("sin", "cos", "tan")},
    "sqrt": "\\sqrt",
}
"""What plain text calls functions and Greek letters."""
_CONSTANT = ("const", "constant")
_SAME = {
    **{f"\\{name}": f"\\{other}" for name, other in (
        ("tg", "tan"), ("ctg", "cot"), ("cotg", "cot"), ("arctg", "arctan"), ("asin", "arcsin"),
        ("acos", "arccos"), ("atan", "arctan"), ("sh", "sinh"), ("ch", "cosh"), ("th", "tanh"),
    )},
    "\\times": "\\cdot", "\\ast": "\\cdot", "\\equiv": "=", "\\lvert": "|", "\\rvert": "|",
    "\\vert": "|", "\\dfrac": "\\frac", "\\tfrac": "\\frac", "\\{": "(", "\\}": ")",
}  # fmt: skip
"""Commands, and what they mean where there are no vectors."""
_FUNCTIONS = {
    "abs": "abs", "Abs": "abs", "sgn": "sgn", "sign": "sgn", "signum": "sgn", "atan2": "atan2",
    "floor": "floor", "ceiling": "ceiling", "Heaviside": "Heaviside",
}  # fmt: skip
"""Functions by name, and what the dictionary calls them."""
_KNOWN = LatexVocabulary(frozenset(_FUNCTIONS.values()))
_TAIL = re.compile(
    r"(?:\\q?quad|\\\\|\\hfill|\s)+\(\d+[a-z']?\)\s*$|(?:\\q?quad|\\\\\s|\\\\$)+\s*$"
)
_DIRECTIONS = re.compile(
    r"(?:(?P<left>\\left|\\lvert|\\[bB]igg?l)|\\right|\\rvert|\\[bB]igg?r)(?![a-zA-Z])"
)
"""Bars of which the print says whether they open."""
_AFTER_SIZE = {"+", "/", "*", "\\cdot", "^", "_", ",", "", ")", "]", "}"}
"""What does not stand behind a bar that opens."""
_OPEN, _CLOSE = ("(", "[", "{"), (")", "]", "}")
_BREAKS = {"+", "-", "=", "/", "*", "\\cdot", "^", "", *_OPEN}


def words_of(text: str, spelled: Mapping[str, str]) -> list[Token]:
    r"""The words of an equation for the reader of LaTeX.

    ``spelled`` gives the LaTeX of the names that plain text may hold.  It is plain where it holds
    no command of LaTeX; then ``*`` may stand between factors or not.  ``Misprint`` where something
    can be read in two ways, ``DefinitionError`` for a character that is not known.
    """
    source = text.translate(_SIGNS)
    plain = "\\" not in source.replace("\\cdot", "").replace("\\times", "")
    source = source if source.isascii() else _in_ascii(source, plain)
    start, end = _bounds(source)
    words = tokenize(source, start, end)
    words = _each([_letter(w) for w in words], lambda given, at: _decimal(given, at, spelled))
    words = _spell_words(
        source, words, _COMMANDS | dict(spelled) if plain else _long(spelled), plain
    )
    words = [_common(w) for w in words]
    words = _stars(_each(words, _primes))
    for change in (_third, _applied_to_time, _quotients, _rate):
        words = _each(words, change)
    words = _each(_sizes(source, words), lambda given, at: _function(source, given, at))
    words = _each(words, _exponent) if plain else words
    words = _own_d(words) if "d" in spelled else _each(words, _ratio)
    _refuse_ambiguous(source, words)
    return words


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


def _letter(word: Token) -> Token:
    r"""``\mathrm{d}`` is a letter like others, and there are several words for a constant."""
    if word.kind == "text" and word.text.rstrip(".") in _CONSTANT:
        return replace(word, text="const")
    if word.kind == "text" and len(word.text) == 1:
        return replace(word, kind="letter")
    return word


def _decimal(
    words: list[Token], position: int, spelled: Mapping[str, str]
) -> tuple[int, list[Token]] | None:
    """``1e-9``, written without spaces, as one number, unless e is a name of the system."""
    signed = [w.text for w in words[position + 2 : position + 3]] in (["+"], ["-"])
    end = position + 3 + signed
    parts = words[position:end]
    beside = all(a.end == b.start for a, b in pairwise(parts))
    kinds = [w.kind for w in parts if w.text not in "+-"]
    if not beside or kinds != ["number", "letter", "number"] or parts[1].text in spelled:
        return None
    text = "".join(w.text for w in parts)
    if (
        "," in text
        or parts[1].text not in "eE"
        or not parts[-1].text.isdecimal()
        or len(parts[-1].text) > 3
    ):
        return None
    return end, [replace(parts[0], text=f"{Decimal(text):f}", end=parts[-1].end)]


def _common(word: Token) -> Token:
    """Of several words for one thing the one that the reader knows."""
    name = word.text if word.kind == "command" else f"\\{word.text}"
    if word.kind in ("command", "text") and name in _SAME:
        text = _SAME[name]
        return replace(word, kind="command" if text.startswith("\\") else "sign", text=text)
    if name in ELEMENTARY and word.kind == "text":
        return replace(word, kind="command", text=name)
    if name.lstrip("\\") in _FUNCTIONS and word.kind in ("command", "text"):
        return replace(word, kind="text", text=_FUNCTIONS[name.lstrip("\\")])
    return word


def _third(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``\dddot x`` is the rate of ``\ddot x``."""
    word = words[position]
    if word.text != "\\dddot" or position + 1 == len(words):
        return None
    end = _atom(words, position + 1)
    inner = [replace(word, text="\\ddot"), *words[position + 1 : end]]
    return end, [replace(word, text="\\dot"), _sign(word, "{"), *inner, _sign(word, "}")]


def _quotients(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``\frac d{dt}``, ``\frac{d}{dt}``: what stands without braces gets them."""
    word = words[position]
    bare = word.text in ("d", "\\partial") and position and words[position - 1].text == "\\frac"
    return (position + 1, [_sign(word, "{"), word, _sign(word, "}")]) if bare else None


Change = Callable[[list[Token], int], tuple[int, list[Token]] | None]
"""What stands at a position written otherwise, and where it ends; None where it stays."""


def _each(words: list[Token], change: Change) -> list[Token]:
    """The words, changed from left to right."""
    found: list[Token] = []
    position = 0
    while position < len(words):
        end, written = change(words, position) or (position + 1, [words[position]])
        found += written
        position = end
    return found


def _ratio(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``\frac{dy}{dx}`` is the quotient dy/dx of two changes, unless by t or of an energy."""
    above = position + 1
    below = _closing(words, above) + 1 if words[position].text == "\\frac" else above
    begins = [[w.text for w in words[at : at + 2]] for at in (above, below)]
    end = _closing(words, below) + 1 if begins == [["{", "d"]] * 2 else above
    parts = words[above + 1 : below - 1], words[below + 1 : end - 1]
    if end == above or any(len(p) < 2 or p[1].text in _NO_RATIO for p in parts):
        return None
    first, second = ([_sign(part[0], "("), *part, _sign(part[0], ")")] for part in parts)
    at = words[position]
    return end, [_sign(at, "("), *first, _sign(at, "/"), *second, _sign(at, ")")]


def _own_d(words: list[Token]) -> list[Token]:
    r"""A ``d`` that the system has is a factor, except in ``\frac{d...}{dt}`` and ``dv/dt``."""
    rates: set[int] = set()
    for position, word in enumerate(words):
        if word.text == "\\frac" and words[position + 1 : position + 2]:
            below = _closing(words, position + 1) + 2
            if [w.text for w in words[below - 1 : below + 1]] == ["{", "d"]:
                rates |= {position + 2, below}
        if word.text == "d" and words[position + 1 : position + 2]:
            slash = _atom(words, position + 1)
            if [w.text for w in words[slash : slash + 3]] == ["/", "d", "t"]:
                rates |= {position, slash + 1}
    found: list[Token] = []
    for position, word in enumerate(words):
        own = word.text == "d" and position not in rates
        further = words[position + 1].kind if own and position + 1 < len(words) else "sign"
        found += [word, _sign(word, "\\cdot")] if further in ("letter", "command") else [word]
    return found


def _sign(place: Token, text: str) -> Token:
    return replace(place, kind="sign", text=text)


def _sizes(source: str, words: list[Token]) -> list[Token]:
    """``|v|`` is the function ``abs``, applied."""
    bars = [k for k, word in enumerate(words) if word.text == "|"]
    opens = dict(zip(bars, _sides(source, words, bars), strict=True))
    found: list[Token] = []
    for position, word in enumerate(words):
        if word.text != "|":
            found.append(word)
        elif opens[position]:
            found += [_sign(word, "("), replace(word, kind="text", text="abs"), _sign(word, "(")]
        else:
            found += [_sign(word, ")"), _sign(word, ")")]
    return found


@dataclass(frozen=True)
class _Bars:
    """Which bars before a place open, the depths of those that are not closed, and whether
    ``b|-c|`` is read as a product, where the bar may close as well."""

    opens: tuple[bool, ...] = ()
    depths: tuple[int, ...] = ()
    strange: bool = False


def _sides(source: str, words: Sequence[Token], bars: Sequence[int]) -> tuple[bool, ...]:
    """Of each bar whether it opens: it closes where it can, unless that leaves one open.

    ``Misprint`` where one has no partner, ``Ambiguous`` for ``|a|b|-c|``.
    """
    readings, depth = [_Bars()], 0
    for position, word in enumerate(words):
        depth += (word.text in _OPEN) - (word.text in _CLOSE)
        if word.text == "|":
            readings = [r for old in readings for r in _next(source, words, position, depth, old)]
            readings = _first_two(readings)
        elif word.text in RELATIONS or word.text in _CLOSE:
            least = depth if word.text in RELATIONS else depth + 1
            readings = [r for r in readings if not r.depths or r.depths[-1] < least]
    whole = [r for r in readings if not r.depths]
    if not whole:
        what = "this bar has no partner; write |v|, or \\left|...\\right| where bars are nested"
        raise complain(source, words[bars[-1]].start, what, Misprint)
    if len(whole) > 1 and whole[0].strange:
        what = "these bars can be read in two ways; write \\left|...\\right|"
        raise complain(source, words[bars[0]].start, what, Ambiguous)
    return whole[0].opens


def _next(
    source: str, words: Sequence[Token], position: int, depth: int, old: _Bars
) -> list[_Bars]:
    """What a bar may be: one that closes comes first."""
    before = words[position - 1].text if position else ""
    after = words[position + 1].text if position + 1 < len(words) else ""
    begins = old.opens[-1] if before == "|" else before in _BREAKS | RELATIONS | ELEMENTARY
    printed = _DIRECTIONS.match(source, words[position].start)
    left = printed is not None and (printed["left"] or "") != ""
    right = printed is not None and not left
    found = []
    if not left and not begins and old.depths and old.depths[-1] == depth:
        found.append(replace(old, opens=(*old.opens, False), depths=old.depths[:-1]))
    if not right and after not in _AFTER_SIZE | RELATIONS:
        strange = old.strange or (not begins and not left and after == "-")
        found.append(_Bars((*old.opens, True), (*old.depths, depth), strange))
    return found


def _first_two(readings: Sequence[_Bars]) -> list[_Bars]:
    """Of those that go on alike the first two, which are as good as all."""
    kept: list[_Bars] = []
    count: Counter[Any] = Counter()
    for reading in readings:
        key = reading.depths, reading.opens[-1]
        count[key] += 1
        kept += [reading] if count[key] <= 2 else []
    return kept


def _function(source: str, words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``\operatorname{sgn} v`` is ``sgn(v)``, ``e^{v}`` the exponential."""
    word, after = words[position], words[position + 1 : position + 2]
    applied = word.kind == "text" and word.text in _FUNCTIONS.values()
    power = word.text == "e" and word.kind in ("letter", "text") and after and after[0].text == "^"
    start = position + 1 + bool(power)
    if not (applied or power) or start >= len(words) or (applied and words[start].text == "("):
        return None
    end = _atom(words, start)
    bare = applied and words[start].text not in _OPEN
    doubt = open_argument(word.text, words, end, _KNOWN) if bare else ""
    if doubt:
        raise complain(source, word.start, doubt, Ambiguous)
    name = replace(word, kind="command", text="\\exp") if power else word
    return end, [name, _sign(word, "("), *words[start:end], _sign(word, ")")]


def _atom(words: Sequence[Token], start: int) -> int:
    """Where what begins at a position ends: a bracket, a dotted letter, a letter with its index."""
    end = start
    while words[end].text in ("\\dot", "\\ddot") and end + 1 < len(words):
        end += 1
    end = _closing(words, end) if words[end].text in _OPEN else end
    end = min(end + 1, len(words))
    if end + 1 < len(words) and words[end].text == "_":
        end = _atom(words, end + 1)
    return end


def _long(spelled: Mapping[str, str]) -> dict[str, str]:
    """Names of several letters, which are told from products of letters in LaTeX, too."""
    return {name: latex for name, latex in spelled.items() if len(name) > 1 and name.isalpha()}


def _spell_words(
    source: str, words: list[Token], spelled: Mapping[str, str], plain: bool
) -> list[Token]:
    """Runs of letters, and in plain text digits, as the names that they are made of."""

    def spell(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
        run = _run(words, position, plain)
        if not run:
            return None
        text, found, at = source[run[0].start : run[-1].end], list[Token](), run[0].start
        if not plain and text not in spelled:
            return position + len(run), run
        for part in _parts(text, spelled) if plain else [text]:
            # the words of a name's LaTeX, all at the place where it was written
            latex = tokenize(spelled.get(part, part))
            found += [replace(w, start=at, end=at + len(part)) for w in latex]
            at += len(part)
        return position + len(run), found

    return _each(words, spell)


def _run(words: Sequence[Token], start: int, plain: bool) -> list[Token]:
    """Letters side by side, from a position on; in plain text with digits and lines below."""
    found: list[Token] = []
    for word in words[start:]:
        inside = plain and found and (word.kind == "number" or word.text == "_")
        if not (word.kind == "letter" or inside) or (found and word.start != found[-1].end):
            break
        found.append(word)
    return found


def _parts(text: str, spelled: Mapping[str, str]) -> list[str]:
    """A run cut into the longest names that are known, from the left; else into single signs."""
    found, longest = [], max(map(len, spelled), default=1)
    while text:
        size = next((n for n in range(min(len(text), longest), 1, -1) if text[:n] in spelled), 0)
        if not size:
            size = len(re.match(r"\d+(?:\.\d+)?|.", text).group())  # type: ignore[union-attr]
        found.append(text[:size])
        text = text[size:]
    return found


def _primes(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``x^{\prime\prime}`` is x'', ``x^\prime`` is x'."""
    if words[position].text == "\\prime":
        return position + 1, [_sign(words[position], "'")]
    braced = [w.text for w in words[position : position + 2]] == ["^", "{"]
    start, found = position + 1 + braced, list[Token]()
    while words[position].text == "^" and start < len(words) and words[start].text == "\\prime":
        found.append(_sign(words[start], "'"))
        start += 1
    return (start + braced, found) if found else None


def _stars(words: list[Token]) -> list[Token]:
    """``*`` is a product, ``**`` a power."""
    found: list[Token] = []
    for word in words:
        if word.text == "*" and found and found[-1].text == "\\cdot" and found[-1].kind == "sign":
            found[-1] = replace(found[-1], text="^", end=word.end)
        elif word.text == "*":
            found.append(replace(word, text="\\cdot"))
        else:
            found.append(word)
    return found


def _applied_to_time(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``x(t)`` is x, and so is what stands on a name: ``\dot x(t)``, ``x^2(t)``."""
    texts = [w.text for w in words[position : position + 3]]
    applied = texts == ["(", "t", ")"] and _ends_name(words, position)
    return (position + 3, []) if applied else None


def _ends_name(words: Sequence[Token], end: int) -> bool:
    """Whether a name ends at a position, with its dots, primes, index and exponent: no number, no
    function and no bracket, which ``(t)`` multiplies or gives an argument."""
    if end == 0:
        return False
    last, start = words[end - 1], end - 1
    if last.text == "}":
        start = next((k for k in range(end) if _closing(words, k) == end - 1), 0)
    before = words[start - 1].text if start else ""
    if before == "^":
        return _ends_name(words, start - 1)
    if before == "_" or last.text == "}":
        return before in ("_", "\\dot", "\\ddot", "\\dddot")
    others = ("d", *_FUNCTIONS.values())
    named = last.kind in ("letter", "text") and last.text not in others
    return named or last.text in GREEK or last.text == "'"


def _rate(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    r"""``d/dt``, ``d^2x/dt^2``, ``d(mv)/dt`` as ``\frac{d}{dt}`` before what they differentiate."""
    match = _rate_at(words, position)
    if match is None:
        return None
    order, body, end = match
    at = (words[position].start, words[end - 1].end)
    texts = ["\\frac", "{", "d", "}", "{", "d", "t", "}"] * order + ["("] * bool(body)
    found = [Token("letter" if text in ("d", "t") else "sign", text, *at) for text in texts]
    return end, found + body + [Token("sign", ")", *at)] * bool(body)


def _rate_at(words: Sequence[Token], start: int) -> tuple[int, list[Token], int] | None:
    """The order, what is differentiated, and where the quotient ends that begins with a ``d``."""
    if words[start].text != "d" or (start and words[start - 1].text == "{"):
        return None
    order, position = _order(words, start + 1)
    slash = position
    if order == 1 and slash < len(words) and words[slash].text == "(":
        slash = _closing(words, slash) + 1
    elif order > 1:
        while slash < len(words) and words[slash].text not in {*_BREAKS} - set(_OPEN):
            slash += 1
    if [w.text for w in words[slash : slash + 3]] != ["/", "d", "t"]:
        return None
    below, end = _order(words, slash + 3)
    return (order, list(words[position:slash]), end) if below == order else None


def _order(words: Sequence[Token], position: int) -> tuple[int, int]:
    """The exponent of a sign of differentiation, and where it ends."""
    texts = [w.text for w in words[position : position + 4]]
    if texts[:1] != ["^"]:
        return 1, position
    braced = texts[1:2] == ["{"]
    digit = texts[2 if braced else 1] if len(texts) > 1 + braced else ""
    return (int(digit), position + (4 if braced else 2)) if digit in ("1", "2", "3") else (0, 0)


def _closing(words: Sequence[Token], opening: int) -> int:
    """Where the bracket closes that opens at a position."""
    depth = 0
    for position in range(opening, len(words)):
        depth += (words[position].text in _OPEN) - (words[position].text in _CLOSE)
        if depth == 0:
            return position
    return len(words)


def _exponent(words: list[Token], position: int) -> tuple[int, list[Token]] | None:
    """``x^12``, ``x^-1``: the whole number, and its sign, stand above."""
    start = position + 1
    end = start + (2 if [w.text for w in words[start : start + 1]] == ["-"] else 1)
    inner = words[start:end]
    if words[position].text != "^" or not inner or inner[-1].kind != "number":
        return None
    at = (inner[0].start, inner[-1].end)
    return end, [words[position], Token("sign", "{", *at), *inner, Token("sign", "}", *at)]


def _refuse_ambiguous(source: str, words: Sequence[Token]) -> None:
    """``Misprint`` at the first word that can be read in two ways."""
    for position in range(len(words)):
        for doubt in (_quotient_in_doubt, _size_in_doubt):
            what = doubt(words, position)
            if what:
                raise complain(source, words[position].start, what, Misprint)


def _quotient_in_doubt(words: Sequence[Token], position: int) -> str:
    """``a/2b`` may be (a/2) b or a/(2 b); with a space or a sign between them it is the first."""
    below, after = position, position + 1
    if below < 2 or after >= len(words) or words[below - 1].text != "/":
        return ""
    number = words[below].kind == "number"
    if not (number or words[below].kind == "letter") or words[below].text == "d":
        return ""
    starts = words[after].kind in ("letter", "number") or words[after].text in GREEK
    whole = words[below - 2].kind == "number" and number
    beside = words[after].start == words[below].end
    doubt = "this quotient can be read in two ways; write (a/b) c or a/(b c)"
    return doubt if starts and beside and not whole else ""


def _size_in_doubt(words: Sequence[Token], position: int) -> str:
    r"""``\ln|x|^2`` may be the square of a logarithm, or the logarithm of a square."""
    argument = words[position + 1 : position + 3]
    if words[position].text not in ELEMENTARY or [w.text for w in argument] != ["(", "abs"]:
        return ""
    bars = argument[0].start == argument[1].start  # brackets that bars have become
    after = words[_closing(words, position + 1) + 1 :][:1]
    doubt = "this is the power of a function or of its argument; write one with parentheses"
    return doubt if bars and [w.text for w in after] == ["^"] else ""


def spelling_of(
    names: Sequence[str], moving: Sequence[str], latex: Callable[[str], str]
) -> dict[str, str]:
    r"""Plain names -> LaTeX; of what moves also ``xdot``, ``xddot``; names of functions."""
    found = {name: f"\\mathrm{{{other}}}" for name, other in _FUNCTIONS.items()}
    found |= {name: latex(name) for name in names}
    for name in moving:
        found |= {name + "dot" * order: f"\\{'d' * order}ot{{{latex(name)}}}" for order in (1, 2)}
        found[name + "ddot"] = found[name + "dotdot"]
    return found


def command_of(text: str) -> str:
    """The command of LaTeX for the word of plain text that something begins with; else nothing."""
    word = re.match("[A-Za-z]*", text)
    return _COMMANDS.get(word[0], "") if word is not None else ""
