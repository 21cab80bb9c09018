r"""What may stand in a slot of a sentence, and how it is read: a table of kinds.

A slot takes what the print has at its place; a kind says what that may look like and which value
it has.  What a kind cannot read makes the sentence undecided, in words.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from voronec.audit.latex.displays import split_display
from voronec.audit.latex.nodes import Chain
from voronec.audit.latex.reader import read_tokens
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.audit.formula import Formula
    from voronec.audit.study import Study

T = TypeVar("T")
Labels = Mapping[str, Sequence["Formula"]]
"""The formulas of a paper by the label of what bears a number."""


@dataclass(frozen=True)
class Quoted:
    """A formula, or several, as the sentence prints it with its delimiters."""

    latex: str

    def trees(self, study: Study) -> tuple[Chain, ...]:
        """The formulas, parsed with the names of a dictionary; ``DefinitionError``, with the place,
        for what cannot be read."""
        pieces = [(p, u.display) for u in split_display(self.latex) for p in u.pieces]
        return tuple(read_tokens(p.tokens, source, study.vocabulary) for p, source in pieces)

    def tree(self, study: Study) -> Chain:
        """The one formula; ``DefinitionError`` where there are more, or none."""
        chains = self.trees(study)
        if len(chains) != 1:
            raise DefinitionError(f"'{self.latex}' holds {len(chains)} formulas, not one")
        return chains[0]


@dataclass(frozen=True)
class Interval:
    """Between two ends, which belong to it or do not; names are LaTeX without spaces.

    ``variable`` is empty where the print names none; ``closed`` says of ``low`` and ``high``
    whether they belong to it.
    """

    variable: str
    low: str
    high: str
    closed: tuple[bool, bool]


@dataclass(frozen=True)
class Reference:
    """What a sentence refers to by its label: the formulas that bear one number."""

    label: str
    formulas: tuple[Formula, ...]

    def trees(self, study: Study) -> tuple[Chain, ...]:
        """The formulas, parsed with the names of a dictionary."""
        return tuple(formula.tree(study.vocabulary) for formula in self.formulas)


@dataclass(frozen=True)
class SlotKind:
    """One kind of slot: what it may look like (a pattern), and how its print is read."""

    looks: str
    read: Callable[[str, Labels], Any]


@dataclass(frozen=True)
class Slot:
    """A place in a sentence: a name that the decision knows, a kind, and the print there."""

    name: str
    kind: str
    printed: str

    @property
    def pattern(self) -> str:
        """The group of a regular expression that takes what stands there."""
        return f"(?P<{self.name}>{KINDS[self.kind].looks})"

    def read(self, printed: str, labels: Labels) -> Any:
        """The value of what stands there."""
        return KINDS[self.kind].read(" ".join(printed.split()), labels)


def one_of(word: str, meanings: Mapping[str, T]) -> T:
    """The meaning of a word among those that a decision knows; another one raises
    ``DefinitionError``, which leaves the sentence undecided."""
    if word not in meanings:
        hint = did_you_mean(word, list(meanings))
        raise DefinitionError(f"nothing is known of '{word}' here{hint}")
    return meanings[word]


_NUMBERS = {
    **{w: n for n, w in enumerate("no one two three four five six seven eight nine ten".split())},
    **{w: n for n, w in enumerate("zeroth first second third fourth fifth sixth".split())},
    "zero": 0,
    "single": 1,
    "linear": 1,
    "double": 2,
    "quadratic": 2,
    "cubic": 3,
    "quartic": 4,
    "once": 1,
    "twice": 2,
    "both": 2,
    "vanishing": 0,
    "threefold": 3,
}
_QUANTIFIERS = {
    **dict.fromkeys(("all", "every", "each", "any", "arbitrary", "always", "for all"), "all"),
    **dict.fromkeys(("in general", "in  general", "generically", "generic"), "generic"),
    **dict.fromkeys(
        ("some", "a", "an", "there is", "possible", "sometimes", "can", "exist"), "some"
    ),
    **dict.fromkeys(("no", "never", "none", "impossible", "not"), "none"),
    **dict.fromkeys(("only", "just", "exactly"), "only"),
}
_RELATIONS = {
    "=": "=",
    "<": "<",
    ">": ">",
    r"\ne": "!=",
    r"\neq": "!=",
    r"\le": "<=",
    r"\ge": ">=",
    **dict.fromkeys(("equal", "equals", "is equal to", "coincides with", "coincide"), "="),
    **dict.fromkeys(("bigger", "greater", "larger", "positive", "bigger than"), ">"),
    **dict.fromkeys(("smaller", "less", "negative", "smaller than"), "<"),
    **dict.fromkeys(("different", "different from", "not equal"), "!="),
}
_STABILITY = {"stable": True, **dict.fromkeys(("unstable", "instable", "not stable"), False)}
_DENIAL = re.compile(r"(?:\b(?:not|no|never|without|cannot|neither|nor|non)\b|n't\b)")


def _number(printed: str, _: Labels) -> int:
    word = printed.strip("$").lower()
    return int(word) if word.isdecimal() else one_of(word, _NUMBERS)


def _is_affirmed(printed: str, _: Labels) -> bool:
    """Whether what is said is affirmed: each denial turns it round."""
    return len(_DENIAL.findall(printed.lower())) % 2 == 0


def _names(printed: str, _: Labels) -> tuple[str, ...]:
    """The names of a list, without spaces; ``and`` or a comma stands between them."""
    inner = re.sub(r"\$\s*(?:,|and|,\s*and)\s*\$", ",", printed).strip("$")
    names = tuple(tight(name) for name in _at_commas(inner))
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise DefinitionError(f"'{printed}' names {twice[0]} twice")
    return names


def _at_commas(text: str) -> list[str]:
    """What stands between commas outside braces and parentheses."""
    pieces, depth = [""], 0
    for letter in text:
        depth += (letter in "{([") - (letter in "})]")
        if letter == "," and not depth:
            pieces.append("")
        else:
            pieces[-1] += letter
    return pieces


def tight(latex: str) -> str:
    r"""LaTeX without the spaces that nothing depends on: one stays after a command."""
    return re.sub(r"(\\[a-zA-Z]+) +(?=[a-zA-Z])|\s+", lambda m: m[1] + " " if m[1] else "", latex)


_INTERVAL = re.compile(r"\$(?:(.+?)\s*\\in\s*)?([(\[])(.+),(.+)([)\]])\$")


def _interval(printed: str, _: Labels) -> Interval:
    match = _INTERVAL.fullmatch(printed)
    if match is None:
        raise DefinitionError(f"'{printed}' is no interval; it reads '$x\\in (a,b)$'")
    name, opens, low, high, closes = match.groups()
    return Interval(tight(name or ""), tight(low), tight(high), (opens == "[", closes == "]"))


def _reference(printed: str, labels: Labels) -> Reference:
    label = printed[printed.index("{") + 1 : -1]
    if label not in labels:
        hint = did_you_mean(label, list(labels))
        raise DefinitionError(f"no formula of the paper is labelled '{label}'{hint}")
    return Reference(label, tuple(labels[label]))


_WORDS, _MATH = r"[^$]*?", r"\$[^$]*\$"

KINDS: dict[str, SlotKind] = {
    "number": SlotKind(r"[^$]*?|\$\d+\$", _number),
    "quantifier": SlotKind(_WORDS, lambda printed, _: one_of(printed.lower(), _QUANTIFIERS)),
    "affirmed": SlotKind(_WORDS, _is_affirmed),
    "stability": SlotKind(_WORDS, lambda printed, _: one_of(printed.lower(), _STABILITY)),
    "relation": SlotKind(r".*?", lambda printed, _: one_of(printed.lower(), _RELATIONS)),
    "word": SlotKind(_WORDS, lambda printed, _: printed.lower()),
    "formula": SlotKind(
        rf"{_MATH}|\$\$[^$]*\$\$|\\begin.*?\\end\{{\w+\*?\}}", lambda p, _: Quoted(p)
    ),
    "names": SlotKind(rf"{_MATH}(?:(?:,| and|, and) {_MATH})*", _names),
    "interval": SlotKind(_MATH, _interval),
    "reference": SlotKind(r"\\(?:eq)?ref\{[^}]*\}", _reference),
}
"""``affirmed``: words with or without a denial; ``names``: a list; the rest as they are called."""
