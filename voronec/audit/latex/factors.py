"""Where the factors and the terms of a printed formula end, in its words."""

from __future__ import annotations

from collections.abc import Sequence

from voronec.audit.latex.displays import RELATIONS, group_end
from voronec.audit.latex.tables import BEGINNINGS, ENDS
from voronec.audit.latex.tokens import ACCENTS, ELEMENTARY, Token

CLOSERS = {"(": ")", "[": "]", "{": "}"}
FRACTIONS = ("\\frac", "\\dfrac", "\\tfrac")
_PREFIXES = frozenset(("\\partial", "\\dot", "\\ddot", "\\sqrt", "\\delta", *ELEMENTARY, *ACCENTS))
"""Words that belong to what follows them."""
EDGES = frozenset(("+", "-", "\\pm", "\\mp", ",", *RELATIONS, *ENDS, *BEGINNINGS))
"""Words between which terms stand."""


def factor_end(words: Sequence[Token], start: int) -> int:
    """The position behind the factor that starts at ``start``, with its primes and scripts."""
    word, end = words[start].text, start + 1
    if word in CLOSERS:
        end = bracket_end(words, start)
    elif word in FRACTIONS:
        end = fraction_ends(words, start)[1]
    elif word in _PREFIXES and end < len(words) and words[end].text not in {"^", *EDGES}:
        end = factor_end(words, end)
    while end < len(words) and words[end].text in ("_", "^", "'", '"'):
        end = group_end(words, end + 1) if words[end].text in ("_", "^") else end + 1
    return end


def fraction_ends(words: Sequence[Token], start: int) -> tuple[int, int]:
    r"""The positions behind the numerator and the denominator; ``\frac12`` has two digits."""
    top = group_end(words, start + 1)
    digits = top <= len(words) and words[top - 1].kind == "number" and top == start + 2
    return top, top if digits and len(words[top - 1].text) > 1 else group_end(words, top)


def bracket_end(words: Sequence[Token], start: int) -> int:
    """The position behind the bracket that closes the one at ``start``; the next one without it."""
    depth = 0
    for position, word in enumerate(words[start:], start=start):
        depth += (word.text in CLOSERS) - (word.text in CLOSERS.values())
        if depth == 0:
            return position + 1
    return start + 1


def term_end(words: Sequence[Token], start: int) -> int:
    """The position behind the term at ``start``, which may begin with its sign."""
    end = start + 1 if words[start].text in EDGES else start
    while end < len(words) and words[end].text not in {*EDGES, *CLOSERS.values()}:
        end = bracket_end(words, end)
    return max(end, start + 1)
