r"""What stands ahead in a formula that can be read in two ways: ``\cos\omega t``, ``x(0)``.

Each question is asked of the words and the position that the reader has reached.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from voronec.audit.latex.tokens import ACCENTS, ELEMENTARY, GREEK, Token
from voronec.audit.latex.vocabulary import LatexVocabulary

_NUMERIC = re.compile(r"(?:\{\d+\}|\d)(?:\{\d+\}|\d)")
_INSTANT = ("t", "+", "-", "/", "\\cdot", "\\pi")
"""What numbers stand beside where an instant is written."""


def _text(words: Sequence[Token], position: int) -> str:
    return words[position].text if position < len(words) else ""


def _is_letter(words: Sequence[Token], position: int) -> bool:
    lone = position < len(words) and words[position].kind == "letter"
    return lone or _text(words, position) in GREEK


def open_argument(
    name: str, words: Sequence[Token], position: int, vocabulary: LatexVocabulary
) -> str:
    r"""Why the argument of a function may reach further: ``\cos\omega t`` may be the cosine of a
    product, ``\sin u/2`` the sine of a half; else nothing.

    A factor with a dot, a function or a differential is none of the argument: ``\sin u\dot v``,
    ``\sin u(1 + \cos u)``.
    """
    after = _text(words, position)
    if after == "/":
        number = position + 1 < len(words) and words[position + 1].kind == "number"
        what = f"this may be the {name} of a quotient, or a {name} divided; write parentheses"
        return what if number or _is_letter(words, position + 1) else ""
    bracket = _bracket_without_dots(words, position, vocabulary) and not instant(words, position)
    said = "(...)" if bracket else after.lstrip("\\")
    what = f"this may be the {name} of a product with {said}, or {said} times a {name}"
    doubt = bracket or _plain_letter(words, position, vocabulary)
    return f"{what}; write parentheses" if doubt else ""


def starts_name(words: Sequence[Token], position: int) -> bool:
    """Whether a name begins here, with a dot or an accent or without."""
    return _is_letter(words, position) or _text(words, position) in ACCENTS | {"\\dot"}


def _plain_letter(words: Sequence[Token], position: int, vocabulary: LatexVocabulary) -> bool:
    """Whether a letter is ahead that is no sign of a differential or a variation."""
    text = _text(words, position)
    word = position < len(words) and words[position].kind in ("text", "name")
    letter = (word and not vocabulary.applies(text)) or text in ACCENTS
    differential = text in ("d", "\\delta") and starts_name(words, position + 1)
    return (letter or _is_letter(words, position)) and not differential


def _bracket_without_dots(
    words: Sequence[Token], position: int, vocabulary: LatexVocabulary
) -> bool:
    """Whether a parenthesis is ahead that holds neither dots nor functions."""
    if _text(words, position) != "(":
        return False
    depth = 0
    for word in words[position:]:
        depth += (word.text in ("(", "[", "{")) - (word.text in (")", "]", "}"))
        if depth == 0:
            return True
        if word.text in ELEMENTARY | {"'", "\\dot", "\\ddot"} or vocabulary.applies(word.text):
            return False
    return False


def fraction_of_numbers(words: Sequence[Token], position: int) -> bool:
    r"""Whether ``\frac12``, ``\frac{1}{2}`` is ahead."""
    texts = "".join(w.text for w in words[position + 1 : position + 7])
    return _text(words, position) == "\\frac" and _NUMERIC.match(texts) is not None


def instant(words: Sequence[Token], position: int) -> str:
    """What the parenthesis ahead holds, where that may be an instant: ``0``, ``t + 1``."""
    end = position + 1
    while end < len(words) and (words[end].kind == "number" or words[end].text in _INSTANT):
        end += 1
    inside = "".join(w.text for w in words[position + 1 : end])
    return inside if _text(words, position) == "(" and _text(words, end) == ")" else ""


def single_name(words: Sequence[Token], position: int) -> str:
    """The name that stands alone in the parenthesis ahead, as in ``v(x)``."""
    alone = _is_letter(words, position + 1) and _text(words, position + 2) == ")"
    return _text(words, position + 1) if alone and _text(words, position) == "(" else ""


def function_without_backslash(words: Sequence[Token], position: int) -> bool:
    """Whether the letters before a position spell a function, as ``cos``."""
    run = ""
    for word in reversed(words[:position]):
        if word.kind != "letter" or f"\\{run}" in ELEMENTARY:
            break
        run = word.text + run
    return f"\\{run}" in ELEMENTARY
