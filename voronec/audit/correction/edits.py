"""The small changes that a formula may need, in the order in which they are believed.

A change is a few replacements in the printed text: at one place, or of one name at all its places.
Each kind of change is a function of the words that yields changes, and has its line in
``single_changes``; a change that gives a meaning to what cannot be read has one in ``repairs``.
Factors, terms and words that are too many, and factors that are missing, follow the tree of the
formula; inside derivatives, integrals and functions nothing is put in or left out.  A printer
leaves out a bracket, one sign of differentiation of two, the relation.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from voronec.audit.correction.changes import (
    Change,
    FontLetter,
    Piece,
    Spare,
    insert,
    is_letter,
    known_fonts,
    letters_of,
    replace_word,
    space_after,
    without,
)
from voronec.audit.latex.displays import RELATIONS, group_end, script_ranges
from voronec.audit.latex.nodes import (
    Bound,
    Call,
    Chain,
    Cross,
    Dot,
    Elementary,
    Listing,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Root,
    Sum,
    walk,
)
from voronec.audit.latex.reader import read
from voronec.audit.latex.tokens import ELEMENTARY, Token, tokenize
from voronec.audit.latex.vocabulary import CALL, LatexVocabulary
from voronec.audit.study import Study
from voronec.errors import DefinitionError

__all__ = ["NUMBERS", "close_brackets", "differentials", "relations", "repairs", "single_changes"]


_CLOSING = frozenset(")]}")
_PREFIXES = frozenset(("\\partial", "\\dot", "\\ddot", "\\sqrt", "\\delta", *ELEMENTARY))
"""Words that something must follow."""
LONGEST = 40
"""How many words may be said twice."""


def _keyboard_slips(
    words: Sequence[Token], study: Study, spare: Spare, letters: Sequence[str]
) -> Iterator[Change]:
    """Every change of this kind."""
    yield from _transpositions(words)
    yield from _twice(words)
    yield from _brackets(words)
    yield from _indices(words, study, spare)
    yield from _arguments(words, letters)


def _transpositions(words: Sequence[Token]) -> Iterator[Change]:
    """Two letters that follow each other exchanged, without their fonts and with them."""
    plain = [w for w in words if is_letter(w)]
    for one, two in pairwise(plain):
        if one.text != two.text:
            pieces = (
                (one.start, one.end, space_after(two.text)),
                (two.start, two.end, space_after(one.text)),
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
                yield Change(((word.start, word.end, space_after(letter)),), about)


def _arguments(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """A letter after a word that something must follow, where nothing does."""
    for word, after in zip(words, (*words[1:], None), strict=True):
        ends = after is None or after.text in {*_CLOSING, *RELATIONS, "+", "-", ","}
        if word.text in _PREFIXES and ends:
            for letter in dict.fromkeys(letters):
                place = (word.end, word.end, space_after(" " + letter))
                yield Change((place,), (word.start, word.end))


_DIGITS = "2345678910"
"""All digits, in the order in which they are tried."""


def _letter_exponents(words: Sequence[Token]) -> Iterator[Change]:
    """A number for a letter in the exponent."""
    for start, end in script_ranges(words):
        inside = words[start:end]
        if words[start - 1].text == "^" and [w.kind for w in inside] in _LETTER:
            word = next(w for w in inside if w.kind == "letter")
            about = (words[max(start - 2, 0)].start, words[end - 1].end)
            for digit in "234":
                yield Change(((word.start, word.end, digit),), about)


_LETTER = (["letter"], ["sign", "letter", "sign"])


def _number_edits(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """Another digit, none, or a letter of the formula; a factor 2 more."""
    for before, word, after in zip((None, *words), words, (*words[1:], None), strict=False):
        if word.kind == "number":
            raised = before is not None and before.text == "^"
            factor = after is not None and (is_letter(after) or after.text in ("(", "["))
            if len(word.text) == 1 and (raised or factor):
                yield replace_word(word, "")
            yield from _other_digits(word, raised or factor)
        elif is_letter(word):
            yield insert(word, "2")
    yield from _numbers_for_letters(words, letters)


def _other_digits(word: Token, strong: bool) -> Iterator[Change]:
    """One digit for another; a number that is all of an exponent or factor is not 1 or 0."""
    alone = len(word.text) == 1
    for position, old in enumerate(word.text):
        for digit in _DIGITS:
            if old.isdigit() and not (alone and strong and digit in "10"):
                place = word.start + position
                yield Change(((place, place + 1, digit),), (word.start, word.end))


def _numbers_for_letters(words: Sequence[Token], letters: Sequence[str]) -> Iterator[Change]:
    """A letter where a number is printed."""
    for word in words:
        if word.kind == "number":
            for letter in dict.fromkeys(letters):
                yield replace_word(word, space_after(letter))


def _script_edits(words: Sequence[Token]) -> Iterator[Change]:
    """An index 1, or a square, more or less; a letter left out."""
    for word in words:
        if is_letter(word):
            yield insert(word, "_1", after=True)
            yield insert(word, "^2", after=True)
            yield insert(word, "^3", after=True)
            yield without(word, words)
        elif word.text in (")", "]"):
            yield insert(word, "^2", after=True)
    for start, end in script_ranges(words):
        a, b = words[start - 1].start, words[end - 1].end
        base = words[max(start - 2, 0)].start
        if words[start].kind == "number" or words[start - 1].text == "_":
            yield Change(((a, b, ""),), (base, b))
        elif words[start - 1].text == "^":
            yield Change(((a, b, "^2"),), (base, b))
        if words[start - 1].text == "_":
            yield Change(((b, b, "^2"),), (base, b))


def single_changes(printed: str, study: Study, spare: Spare) -> list[Change]:
    """Every change that is tried by itself, the believable ones first."""
    words = tokenize(printed)
    own = [w.text for w in words if is_letter(w)]
    chain = _tree(printed, study)
    kinds = (
        (*differentials(words), *_letter_exponents(words), *relations(words)),
        _exchanges(words),
        _index_edits(printed, words, study, spare.indices),
        _mark_edits(words, [printed, *spare.formulas]),
        _name_edits(words, study, own),
        _number_edits(words, own),
        _script_edits(words),
        (*_omit_words(words), *_omit_parts(printed, chain, words)),
        _put_in(printed, chain, words, (*NUMBERS, *_own_factors(printed, chain, study))),
        _font_edits(words, study),
        _letter_edits(words, list(letters_of(words))),
        _name_edits(words, study, spare.letters),
        _letter_edits(words, spare.names),
        _numbers_for_letters(words, spare.letters),
        _put_in(printed, chain, words, _other_names(spare, study)),
        _name_edits(words, study, _known_letters(study)),
        _keyboard_slips(words, study, spare, (*own, *spare.letters)),
    )
    found: dict[tuple[Piece, ...], Change] = {}
    for rank, kind in enumerate(kinds):
        for change in kind:
            pieces = tuple(p for p in change.pieces if printed[p[0] : p[1]] != p[2])
            if pieces:
                found.setdefault(pieces, replace(change, pieces=pieces, rank=rank))
    return list(found.values())


def _tree(printed: str, study: Study) -> Chain:
    """The tree of a formula; an empty one where it cannot be read."""
    try:
        return read(printed, study.vocabulary)
    except DefinitionError:
        return Chain(())


def _other_names(spare: Spare, study: Study) -> list[str]:
    """The names that the section prints, then those of the dictionary; then their squares."""
    known = [name for name, value in study.names.items() if not callable(value)]
    names = [n for n in dict.fromkeys((*spare.factors, *known)) if n not in study.indices]
    return [*names, *(f"{name}^2" for name in names)]


def _known_letters(study: Study) -> list[str]:
    """The letters of the dictionary."""
    keys = (key.removesuffix(CALL).replace("#", "") for key in study.table)
    return [word.text for key in keys for word in tokenize(key) if is_letter(word)]


_COMPANIONS = {"+": "-", "-": "+", "<": ">", ">": "<", "\\sin": "\\cos", "\\cos": "\\sin"}


def _exchanges(words: Sequence[Token]) -> Iterator[Change]:
    """Signs, sine and cosine; a sign at the head of a side, but not of what is defined."""
    for before, word in zip((None, *words), words, strict=False):
        heads = before is not None and (before.text in RELATIONS or before.text in ("(", "["))
        if heads and word.text not in ("+", "-"):
            yield insert(word, "-")
        other = _COMPANIONS.get(word.text)
        if other is not None:
            yield replace_word(word, other)


def _index_edits(
    printed: str, words: Sequence[Token], study: Study, spare: Sequence[str]
) -> Iterator[Change]:
    """Another index: a letter for a letter, then a whole index expression."""
    letters = [w for w in dict.fromkeys(t.text for t in words) if w in study.indices]
    for start, end in script_ranges(words):
        for word in words[start:end]:
            if word.text in study.indices:
                for other in letters:
                    yield replace_word(word, other)
    for start, end in script_ranges(words):
        a, b = words[start].start, words[end - 1].end
        inside = {w.text for w in words[start:end]} & set(study.indices)
        for other in spare:
            if inside and inside == {t.text for t in tokenize(other)} & set(study.indices):
                yield Change(((a, b, other),), (words[max(start - 2, 0)].start, b))


def _mark_edits(words: Sequence[Token], texts: Sequence[str]) -> Iterator[Change]:
    r"""A prime or a dot more or less; a dot only on letters that have one elsewhere."""
    dotted = {m for text in texts for m in re.findall(r"\\dot\s*\{?\s*(\\?[a-zA-Z]+)", text)}
    for word in words:
        if word.text in ("'", "\\dot"):
            yield replace_word(word, "")
        elif is_letter(word):
            yield insert(word, "'", after=True)
            if word.text in dotted:
                yield insert(word, "\\dot ")


def _name_edits(words: Sequence[Token], study: Study, letters: Sequence[str]) -> Iterator[Change]:
    """A letter for another one of ``letters``."""
    letters = [x for x in dict.fromkeys(letters) if x not in study.indices]
    for word in words:
        if is_letter(word):
            for other in letters:
                yield replace_word(word, space_after(other))


def _font_edits(words: Sequence[Token], study: Study) -> Iterator[Change]:
    """Another font or accent of a letter, at one place, then at all its places."""
    known = known_fonts(study)
    everywhere: dict[tuple[str, str, str], list[Piece]] = {}
    for place in letters_of(words):
        for accent in ("", *known.get(place.letter, ())):
            if accent != place.accent:
                piece = (place.start, place.end, replace(place, accent=accent).text)
                yield Change((piece,), (place.start, place.end))
                everywhere.setdefault((place.accent, place.letter, accent), []).append(piece)
    for pieces in everywhere.values():
        if len(pieces) > 1:
            yield Change(tuple(pieces), (pieces[0][0], pieces[-1][1]))


def _letter_edits(words: Sequence[Token], others: Sequence[FontLetter]) -> Iterator[Change]:
    """A letter with its font for another one, where one of them has a font."""
    texts = {other.text: other for other in others}
    for place in letters_of(words):
        for text, other in texts.items():
            if place.accent or other.accent:
                yield Change(((place.start, place.end, text),), (place.start, place.end))


Place = tuple[int, int]
NUMBERS = ("\\frac12", "2")
_BRACKETS = {"(": ")", "[": "]"}
_GROUPS = {**_BRACKETS, "{": "}"}


def _own_factors(printed: str, chain: Chain, study: Study) -> tuple[str, ...]:
    """What a formula is made of: its names, then what else it multiplies, then squares of names."""
    called = {part.function for part in walk(chain) if isinstance(part, Call)}
    found: dict[int, dict[str, None]] = {0: {}, 1: {}, 2: {}}
    for part in walk(chain):
        text = printed[slice(*part.at)]
        if isinstance(part, (Name, Dot)):
            inner = part.body if isinstance(part, Dot) else part
            if isinstance(inner, Name) and not (study.is_index(inner) or inner in called):
                found[0][text] = None
                found[2][text + "^2"] = None
        elif isinstance(part, Power) and isinstance(part.exponent, Number):
            if isinstance(part.base, Name):
                found[1][text] = None
        elif isinstance(part, Elementary):
            found[1][text] = None
    return tuple(text for kind in found.values() for text in kind)


def _omit_words(words: Sequence[Token]) -> Iterator[Change]:
    """The formula without one of its words; brackets, marks of scripts and relations stay."""
    kept = {*_GROUPS, *_GROUPS.values(), "^", "_", ",", *RELATIONS}
    for word in words:
        if word.text not in kept:
            yield without(word, words)


def _omit_parts(printed: str, chain: Chain, words: Sequence[Token]) -> Iterator[Change]:
    """The formula without a factor, then without a denominator, then without a term."""
    parts = list(_parts(chain))
    for part in parts:
        if isinstance(part, Product):
            for factor in part.factors:
                start, end = _widen(factor.at, words, _GROUPS)
                if part.at[0] <= start < end <= part.at[1]:
                    yield Change(((start, end, ""),), part.at)
    for part in parts:
        if isinstance(part, Quotient) and printed.startswith("\\", part.at[0]):
            top = _widen(part.top.at, words, _BRACKETS)
            if part.at[0] < top[0] < top[1] < part.at[1]:
                pieces = ((part.at[0], top[0], ""), (top[1], part.at[1], ""))
                yield Change(pieces, part.at)
            if not isinstance(part.top, (Product, Sum)):
                yield Change(((*top, "1"),), part.at)
    for part in parts:
        if isinstance(part, Sum) and len(part.terms) > 1:
            yield from _omit_terms(part, words)


def _omit_terms(node: Sum, words: Sequence[Token]) -> Iterator[Change]:
    signs = [_sign_before(term, words) for _, term in node.terms]
    ends = [*(sign.start for sign in signs[1:] if sign is not None), node.at[1]]
    if len(ends) != len(signs):
        return
    for i, end in enumerate(ends):
        first = signs[i + 1] if i == 0 else None
        start = node.at[0] if i == 0 else ends[i - 1]
        if first is not None and first.text == "+":
            end = first.end
        yield Change(((start, end, ""),), node.at)


def _sign_before(term: Node, words: Sequence[Token]) -> Token | None:
    start = _widen(term.at, words, _GROUPS)[0]
    before = [w for w in words if w.end <= start]
    return before[-1] if before and before[-1].text in ("+", "-", "\\pm", "\\mp") else None


def _put_in(
    printed: str, chain: Chain, words: Sequence[Token], texts: Sequence[str]
) -> Iterator[Change]:
    """A factor more in a term: a power behind what it multiplies first, all else before it."""
    places = list(_terms(printed, chain, words))
    for text in texts:
        for node, (start, end) in places:
            number = text in NUMBERS
            start = start if number else _behind_number(node, start)
            about = (min(start, node.at[0]), end)
            spots = [] if number and printed[start : start + 1].isdigit() else [start]
            if not number and _ends_plainly(node, printed[:end]):
                spots = [end, *spots] if "^" in text else [*spots, end]
            for spot in spots:
                yield Change(((spot, spot, _apart(printed, spot, text)),), about)


def _ends_plainly(node: Node, printed: str) -> bool:
    """Whether a letter behind a term is not read, or mistaken, as the argument of a function."""
    last = node.factors[-1] if isinstance(node, Product) else node
    return isinstance(last, (Name, Power, Dot)) or printed[-1:] in (")", "]")


def _apart(printed: str, place: int, text: str) -> str:
    """The text, kept apart from the command that it follows and the letter that follows it."""
    before = printed[:place].rpartition("\\")
    if before[1] and before[2].isalpha() and text[:1].isalpha():
        text = " " + text
    after = text.rpartition("\\")
    return text + " " if after[1] and after[2].isalpha() else text


def _parts(node: Node) -> Iterator[Node]:
    """All parts that are not inside a derivative, an integral or a function."""
    yield node
    for part in _children(node):
        yield from _parts(part)


def _children(node: Node) -> Sequence[Node]:
    if isinstance(node, Chain):
        return node.parts
    if isinstance(node, Sum):
        return [term for _, term in node.terms]
    if isinstance(node, Product):
        return node.factors
    if isinstance(node, Quotient):
        return (node.top, node.bottom)
    if isinstance(node, (Root, Bound)):
        return (node.body,)
    if isinstance(node, Power):
        return (node.base,)
    if isinstance(node, Cross):
        return (node.left, node.right)
    return node.items if isinstance(node, Listing) else ()


def _terms(printed: str, chain: Chain, words: Sequence[Token]) -> Iterator[tuple[Node, Place]]:
    """The parts that a further factor can multiply, with what stands around them in brackets."""
    for part in _parts(chain):
        if isinstance(part, (Product, Power)):
            continue  # their factors and bases are no terms
        for node in _children(part):
            start, end = _widen(node.at, words, _BRACKETS)
            bare = (start, end) == tuple(node.at)
            unbraced = isinstance(part, Quotient) and printed[start - 1 : start] != "{"
            if not unbraced and not (isinstance(node, Sum) and bare):
                yield node, (start, end)


def _behind_number(node: Node, start: int) -> int:
    """Where letters begin: ``2xy`` becomes ``2mxy``."""
    first = node.factors[0] if isinstance(node, Product) else node
    numeral = isinstance(first, Number) or (
        isinstance(first, Quotient)
        and isinstance(first.top, Number)
        and isinstance(first.bottom, Number)
    )
    return int(first.at[1]) if numeral and node is not first else start


def _widen(at: Place, words: Sequence[Token], groups: dict[str, str]) -> Place:
    """The place with the brackets that enclose just it."""
    start, end = at
    while True:
        before = [w for w in words if w.end <= start][-1:]
        after = [w for w in words if w.start >= end][:1]
        if not (before and after and groups.get(before[0].text) == after[0].text):
            return start, end
        start, end = before[0].start, after[0].end


_CLOSERS = {"(": ")", "[": "]", "{": "}"}
_SIGNS = ("\\partial", "d")


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
    return at_end + [insert(w, _CLOSERS[opened[-1].text], after=True) for w in places]


def _open_brackets(words: Sequence[Token]) -> list[Token]:
    """Those that nothing closes; a bracket may close behind one inside it that does not."""
    opened: list[Token] = []
    for word in words:
        if word.text in _CLOSERS:
            opened.append(word)
        fitting = [w for w in opened if _CLOSERS[w.text] == word.text]
        if fitting:
            opened.remove(fitting[-1])
    return opened


def _closers(opened: Sequence[Token]) -> str:
    return "".join(_CLOSERS[word.text] for word in reversed(opened))


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
        depth += (word.text in _CLOSERS) - (word.text in _CLOSERS.values())
        if depth == 0 and word.text in ("+", "-") and word is not words[0]:
            yield replace_word(word, "=")
