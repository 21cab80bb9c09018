"""The source of a formula with some of its characters as arguments of a command, and the places
where a line may end.

What is marked are whole factors, one after another within one group, so that braces stay in
balance.  A change in an index or an exponent of a name is one of the whole name; where no factor
lies within a range, the narrowest around it is marked.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from voronec.audit.latex.displays import RELATIONS, group_end
from voronec.audit.latex.factors import CLOSERS, EDGES, FRACTIONS, bracket_end, fraction_ends
from voronec.audit.latex.tokens import ACCENTS, GREEK, Token, tokenize

Range = tuple[int, int]

LINE_END = "\f"
"""What stands where a line may end."""
LONG = 40
"""Brackets around more words than these may be broken inside."""
_SIGNS = (
    frozenset(("+", "-", "\\pm", "\\mp", "\\oplus", "\\wedge", "\\to", "\\Rightarrow")) | RELATIONS
)
_FONTS = ACCENTS - frozenset(r"\tilde \bar \hat \vec".split())
_ACCENTS = ACCENTS | frozenset(("\\dot", "\\ddot"))
_BASES = GREEK | _ACCENTS | frozenset(("\\partial", "{"))
_STRUCTURE = frozenset(("_", "^", "'", "}", "&", "\\\\"))
_BETWEEN = re.compile(r"&|\\(?:left|right)(?![a-zA-Z])")
"""What no mark reaches over: cells, and brackets that are not printed."""
_TALL = re.compile(r"\\(?:[dt]?frac|begin|sum|prod|int)(?![a-zA-Z])")
_LINES = re.compile(r"(?<!\\)&|\\\\")
_EDGE = re.compile(r"\\(left|right)(?![a-zA-Z])")


def mark(latex: str, ranges: Sequence[Range], command: str, lines: bool = False) -> str:
    r"""A formula with what stands in ``ranges`` as arguments of ``command``; with ``lines`` there
    is a ``LINE_END`` before relations, before the signs of sums, and behind a ``\quad``.

    Raises ``DefinitionError`` where a brace behind ``\text`` is not closed.
    """
    words = tokenize(latex)
    ends = {(i, find(words, i)): None for i in range(len(words)) for find in (_end, _base_end)}
    items = [item for item in ends if _is_whole(words, latex, *item)]
    wide = [_widen(words, items, one) for one in ranges if one[0] < one[1]]
    places: list[tuple[int, int, str]] = []
    covered = [item for item in items if _covers(words, wide, *item)]
    runs = [*_runs(words, latex, dict(reversed(covered)))]
    for first, last in runs:
        # an empty group keeps the space on the left of a sign
        start = f"{{\\{command}{{" + "{}" * (words[first].text in _SIGNS)
        places += [(words[first].start, 2, start), (words[last - 1].end, 0, "}}")]
    for at in _line_ends(words, latex) if lines else ():
        if not any(words[a].start < at < words[b - 1].end for a, b in runs):
            places.append((at, 1, LINE_END))
    pieces, last = [], 0
    for at, _, text in sorted(places):
        pieces += [latex[last:at], text]
        last = at
    return "".join([*pieces, latex[last:]])


def in_environment(latex: str) -> str:
    """A formula whose lines or cells, where they are outside any environment, have one."""
    bare = "\\begin" not in latex and _LINES.search(latex)
    return f"\\begin{{aligned}}\n{latex}\n\\end{{aligned}}" if bare else latex


def _argument_end(words: Sequence[Token], start: int) -> int:
    """The position behind an argument: a group, a word, or a letter with its accents and font."""
    if start < len(words) and words[start].text in _ACCENTS:
        return _argument_end(words, start + 1)
    return group_end(words, start)


def _base_end(words: Sequence[Token], start: int) -> int:
    """The position behind what stands at ``start``, with its arguments, without its scripts."""
    word = words[start]
    if word.text in ("(", "["):
        return bracket_end(words, start)
    if word.text in FRACTIONS:
        return fraction_ends(words, start)[1]
    if word.text == "\\sqrt" and [w.text for w in words[start + 1 : start + 2]] == ["["]:
        return _argument_end(words, bracket_end(words, start + 1))
    end = _argument_end(words, start)
    while word.kind == "command" and end < len(words) and words[end].text == "{":
        end = group_end(words, end)
    return end


def _end(words: Sequence[Token], start: int) -> int:
    """The position behind a factor with its primes and scripts, or behind an argument."""
    if start and words[start - 1].text in {"_", "^", *_ACCENTS}:
        return _argument_end(words, start)
    end = _base_end(words, start)
    while end < len(words) and words[end].text in ("_", "^", "'", '"'):
        end = _argument_end(words, end + 1) if words[end].text in ("_", "^") else end + 1
    return end


def _is_whole(words: Sequence[Token], latex: str, start: int, end: int) -> bool:
    """Whether the words from ``start`` to ``end`` can be an argument."""
    word, edges = words[start], _EDGE.findall(latex, words[start].start, words[end - 1].end)
    return not (
        word.text in _STRUCTURE
        or word.text.startswith(("\\begin", "\\end"))
        or edges.count("left") != edges.count("right")
        or (word.kind == "number" and len(word.text) > 1 and words[start - 1].text in FRACTIONS)
    )


def _widen(words: Sequence[Token], items: Sequence[Range], one: Range) -> Range:
    """A range; of a script of a name the whole name, and what no factor lies in, a factor."""
    around, empty = [], True
    for first, last in items:
        start, end = words[first].start, words[last - 1].end
        empty = empty and not _covers(words, [one], first, last)
        base = _base_end(words, first)
        if start <= one[0] and one[1] <= end:
            named = words[first].kind in ("letter", "name", "number") or words[first].text in _BASES
            script = named and base < last and words[base - 1].end <= one[0]
            around.append((end - start, script, (start, end)))
    for _, script, wider in sorted(around):
        if script or empty:
            return wider
    return one


def _covers(words: Sequence[Token], ranges: Sequence[Range], first: int, last: int) -> bool:
    """Whether a factor lies within one range, whatever its font, or the size of a bracket."""
    start, end = words[first].start, words[last - 1].end
    if words[first].text in _FONTS:
        inside = [w for w in words[first + 1 : last] if w.text not in "{}"]
        start, end = (inside[0].start, inside[-1].end) if inside else (start, end)
    elif last == first + 1 and words[first].kind == "sign":
        start = end - 1
    return any(a <= start and end <= b for a, b in ranges)


def _runs(words: Sequence[Token], latex: str, ends: dict[int, int]) -> Iterator[Range]:
    """The positions of the largest runs of factors with these ends; a group is one by itself."""
    run: Range | None = None
    position = 0
    while position < len(words):
        end = ends.get(position, 0)
        word = words[position]
        if not end:
            position += 1
            continue
        gap = latex[words[position - 1].end : word.start] if position else ""
        joins = run is not None and run[1] == position and not _BETWEEN.search(gap)
        if run is not None and joins and word.text != "{" and words[run[0]].text != "{":
            run = run[0], end
        else:
            yield from (run,) if run else ()
            run = position, end
        position = end
    yield from (run,) if run else ()


def _line_ends(words: Sequence[Token], latex: str) -> Iterator[int]:
    """Where a line may end outside of groups and short brackets; nowhere in what has lines."""
    position = 0
    if "\\begin" in latex or "\\\\" in latex or "&" in latex:
        return
    while position < len(words):
        word, before = words[position], words[position - 1] if position else None
        if before is not None and (
            before.text in ("\\quad", "\\qquad")
            or (word.text in _SIGNS and before.text not in {*EDGES, *CLOSERS, *_SIGNS})
        ):
            yield word.start
        end = _end(words, position)
        long = _is_long(words, position) and not latex.startswith("\\left", word.start)
        position = position + 1 if long else end


def size_brackets(latex: str) -> str:
    r"""A formula whose brackets grow only with what is tall and short: long ones, between which
    lines may end, have ``\big`` for ``\left`` and ``\right``, those of what is low nothing.

    All characters keep their places.
    """
    words = tokenize(latex)
    for position, word in enumerate(words):
        if word.text in ("(", "[") and latex.startswith("\\left", word.start):
            last = words[bracket_end(words, position) - 1].start
            tall = _TALL.search(latex, word.start, last)
            if latex.startswith("\\right", last) and not (tall and not _is_long(words, position)):
                size = "\\big" if tall else ""
                latex = f"{latex[:last]}{size:6}{latex[last + 6 :]}"
                latex = f"{latex[: word.start]}{size:5}{latex[word.start + 5 :]}"
    return latex


def _is_long(words: Sequence[Token], start: int) -> bool:
    """Whether a long bracket begins there."""
    return words[start].text in ("(", "[") and bracket_end(words, start) - start > LONG
