r"""What a printer leaves out: a bracket, one sign of differentiation of two, the relation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from voronec.audit.correction.changes import Change, insert, replace_word
from voronec.audit.latex.displays import RELATIONS
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import Token, tokenize
from voronec.audit.latex.vocabulary import Vocabulary
from voronec.errors import DefinitionError

__all__ = ["close_brackets", "differentials", "group_end", "relations", "repairs"]

_CLOSED_BY = {"(": ")", "[": "]", "{": "}"}
_SIGNS = ("\\partial", "d")


def close_brackets(printed: str, vocabulary: Vocabulary | None = None) -> str | None:
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


def repairs(printed: str) -> list[Change]:
    """What may close the brackets that are open: all of them at the end first, then the last one
    at each place before.
    """
    words = tokenize(printed)
    opened = _open_brackets(words)
    if not opened:
        return []
    places = [w for w in reversed(words) if w.start >= opened[-1].end]
    at_end = [insert(words[-1], _closers(opened), after=True)] if len(opened) > 1 else []
    return at_end + [insert(w, _CLOSED_BY[opened[-1].text], after=True) for w in places]


def _open_brackets(words: Sequence[Token]) -> list[Token]:
    """Those that nothing closes; a bracket may close behind one inside it that does not."""
    opened: list[Token] = []
    for word in words:
        if word.text in _CLOSED_BY:
            opened.append(word)
        fitting = [w for w in opened if _CLOSED_BY[w.text] == word.text]
        if fitting:
            opened.remove(fitting[-1])
    return opened


def _closers(opened: Sequence[Token]) -> str:
    return "".join(_CLOSED_BY[word.text] for word in reversed(opened))


def differentials(words: Sequence[Token]) -> Iterator[Change]:
    r"""``\partial`` or ``d`` where only the other half of a fraction begins with it."""
    for i, word in enumerate(words):
        if word.text not in ("\\frac", "\\dfrac", "\\tfrac") or words[i + 1].text != "{":
            continue
        end = group_end(words, i + 1)
        if end + 1 >= len(words) or words[end].text != "{":
            continue
        top, bottom, last = words[i + 2], words[end + 1], group_end(words, end)
        for sign in _SIGNS:
            if (top.text == sign) != (bottom.text == sign):
                place = (bottom if top.text == sign else top).start
                text = sign + " " if sign.startswith("\\") else sign
                yield Change(((place, place, text),), (word.start, words[last - 1].end))


def relations(words: Sequence[Token]) -> Iterator[Change]:
    """In an expression without a relation: ``=`` for a sign between its terms, or ``=0`` after."""
    if any(w.text in RELATIONS for w in words):
        return
    yield insert(words[-1], "=0", after=True)
    depth = 0
    for word in words:
        depth += (word.text in _CLOSED_BY) - (word.text in _CLOSED_BY.values())
        if depth == 0 and word.text in ("+", "-") and word is not words[0]:
            yield replace_word(word, "=")


def group_end(words: Sequence[Token], position: int) -> int:
    """The position behind the group in braces that starts at ``position``."""
    depth = 0
    while position < len(words):
        depth += (words[position].text == "{") - (words[position].text == "}")
        position += 1
        if depth == 0:
            break
    return position
