r"""A sentence of the running text: quoted letter for letter, with slots for the words that decide.

The text marks its slots as ``@name:kind{print}``; without the marks it is the quotation.  What is
judged is the quotation: it is read by the pattern that the text makes, and the decision gets the
values of the slots, so that a word changed in the quotation changes what is decided.
"""

from __future__ import annotations

import dis
import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from types import CodeType
from typing import Any

from voronec.algebra.verdicts import Verdict
from voronec.audit.slots import KINDS, Labels, Slot
from voronec.errors import DefinitionError, did_you_mean

_MARK = re.compile(r"@(\w+):(\w+)\{")
EXCERPT = 40
"""Characters of a quotation that are shown where it reads otherwise than its pattern."""


@dataclass(frozen=True)
class Sentence:
    r"""A sentence of the running text, or a part of one, that states something.

    text
        the print, letter for letter, its slots marked as ``@name:kind{print}``; the kinds are
        those of ``voronec.audit.slots``.
    decide
        function of the study, of one of its ranges (``Range()`` where there are none), and of the
        values of the slots by their names; proved, refuted with a witness, or undecided.
    study
        which dictionary of the section; the first one by default.
    within
        names of the ranges to which the sentence itself is restricted; all where there are none.
    derived
        function of the study that returns LaTeX: what was derived instead of, or beside it.
    cited
        what of it is proved, where the rest is quoted; the verdict is then at most "cited".
    unaudited
        why nothing decides the sentence, where nothing does; it is then listed as not audited.
    quotation
        what is judged; the print by default.
    source
        what decides it, where that is not the source of the study.
    """

    text: str
    decide: Callable[..., Verdict] | None = None
    study: str = ""
    within: tuple[str, ...] = ()
    derived: Callable[..., str] | None = None
    cited: str = ""
    unaudited: str = ""
    quotation: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        if not self.quotation:
            object.__setattr__(self, "quotation", self._plain_text)
        if (self.decide is None) != bool(self.unaudited):
            raise DefinitionError(f"{self._place}: give it a decision, or say why there is none")
        if self.decide is not None:
            self._agree(self.decide)

    @cached_property
    def _parts(self) -> tuple[str | Slot, ...]:
        """The text cut at its slots."""
        return tuple(_cut(self.text))

    @property
    def _plain_text(self) -> str:
        """The text without its marks."""
        return "".join(p.printed if isinstance(p, Slot) else p for p in self._parts)

    @property
    def is_original(self) -> bool:
        """Whether what is judged is the print from which the slots were made."""
        return self.quotation == self._plain_text

    @cached_property
    def slots(self) -> tuple[Slot, ...]:
        """The slots in the order of print."""
        return tuple(part for part in self._parts if isinstance(part, Slot))

    @property
    def _place(self) -> str:
        return f"the sentence '{' '.join(self.quotation.split())[:EXCERPT]}'"

    def read(self, labels: Labels) -> dict[str, Any]:
        """The values of the slots in the quotation.

        ``DefinitionError`` where the words between them are others, or a slot cannot be read.
        """
        words = " ".join(self.quotation.split())
        pattern = "".join(
            p.pattern if isinstance(p, Slot) else re.escape(_single(p)) for p in self._parts
        )
        match = re.fullmatch(pattern, words)
        if match is None:
            start = _common(words, _single(self._plain_text))
            raise DefinitionError(
                f"it reads '{words[max(0, start - EXCERPT // 2) : start + EXCERPT]}', which is not "
                "the sentence that is decided here"
            )
        return {slot.name: slot.read(match[slot.name], labels) for slot in self.slots}

    def _agree(self, decide: Callable[..., Any]) -> None:
        """Refuse a decision that does not make use of every slot."""
        taken = set(list(inspect.signature(decide).parameters)[2:])
        names = [slot.name for slot in self.slots]
        for name in names:
            if name not in taken or not _uses(decide, name):
                hint = "" if name in taken else did_you_mean(name, list(taken))
                raise DefinitionError(
                    f"{self._place}: its decision makes no use of the slot '{name}'; give it a "
                    f"parameter of that name and let the verdict depend on it{hint}"
                )
        for name in sorted(taken - set(names)):
            raise DefinitionError(f"{self._place}: its decision asks for a slot '{name}'; mark one")


def _common(first: str, second: str) -> int:
    """How many characters two texts have in common at their beginning."""
    pairs = enumerate(zip(first, second, strict=False))
    return next((n for n, (a, b) in pairs if a != b), min(len(first), len(second)))


def _single(text: str) -> str:
    """A part of a text with single spaces, those at its ends kept."""
    return re.sub(r"\s+", " ", text)


def _cut(text: str) -> Iterator[str | Slot]:
    """Words and slots in turn; braces inside a slot are balanced."""
    position, seen = 0, set[str]()
    while mark := _MARK.search(text, position):
        name, kind = mark[1], mark[2]
        if kind not in KINDS or name in seen or not name.isidentifier():
            hint = did_you_mean(kind, list(KINDS)) if kind not in KINDS else "; use it once"
            raise DefinitionError(f"the slot '@{name}:{kind}' of a sentence is unknown{hint}")
        end = _closing(text, mark.end(), name)
        yield text[position : mark.start()]
        yield Slot(name, kind, text[mark.end() : end])
        position = end + 1
        seen.add(name)
    yield text[position:]


def _closing(text: str, start: int, name: str) -> int:
    """Where the brace closes that opens a slot."""
    depth = 1
    for mark in re.finditer(r"\\.|[{}]", text[start:], re.DOTALL):
        depth += {"{": 1, "}": -1}.get(mark.group(), 0)
        if depth == 0:
            return start + mark.start()
    raise DefinitionError(f"the braces of the slot '{name}' of a sentence do not end")


def _uses(decide: Callable[..., Any], name: str) -> bool:
    """Whether the code of a function, or of one inside it, reads its parameter."""
    code = getattr(inspect.unwrap(decide), "__code__", None)
    return code is None or _reads(code, name)


def _reads(code: CodeType, name: str) -> bool:
    loads = (i for i in dis.get_instructions(code) if i.opname.startswith("LOAD"))
    if any(name == i.argval or (isinstance(i.argval, tuple) and name in i.argval) for i in loads):
        return True
    return any(_reads(c, name) for c in code.co_consts if isinstance(c, CodeType))
