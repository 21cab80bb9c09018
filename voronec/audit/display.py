"""What is printed, and how it is to be checked: displays, and the formulas in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from voronec.algebra.verdicts import Verdict
from voronec.audit.latex.displays import FormulaUnit, split_display
from voronec.audit.sentence import Sentence
from voronec.audit.study import Range, Study
from voronec.errors import DefinitionError

ROLES = ("claim", "definition", "condition", "cited", "words")


@dataclass(frozen=True)
class Convention:
    """Names read otherwise: ``names`` replace those of the dictionary, ``statement`` says how.

    ``against`` names the formula of the paper that contradicts this reading.
    """

    statement: str
    against: str
    names: Mapping[str, Any]


Decision = Callable[[Study, Range], Verdict]
"""Decides a sentence for one range of the parameters."""


@dataclass(frozen=True)
class Check:
    """How one formula is compared with what is derived; the defaults suit an identity.

    role
        ``claim``; ``definition``: it introduces a name whose meaning the dictionary derives;
        ``condition``: an assumption; ``cited``: a fact that is quoted; ``words``: a definition
        in words, which is not read.
    study
        which dictionary of the section; the first one by default.
    also
        further dictionaries under which a formula that is proved must hold too.
    truth
        for an equation of motion: function of the study and the values ``{letter: value}`` of its
        free indices (``{"i": ...}`` for a variation), which returns the derived expression that
        vanishes along the motion; the formula must hold there, and not without it.
    value
        for a formula without a relation, or to be compared as a whole: function of the same that
        returns the derived value; the first part of the formula must equal it.
    stationary
        the formula is an integral that is stationary; ``truth`` as above, for each variation.
    given
        labels of conditions that are in force.
    derived
        function of the same that returns derived pairs (left, right) to
        print; by default the formula's left side with its derived value.
    convention
        another reading to be tried where the formula is refuted.
    decide
        for a formula that is a condition in a sentence: function of the study and one of its
        ranges that decides the sentence; ``says`` is that sentence in words of our own.
    within
        names of the ranges to which the sentence itself is restricted; all where there are none.
    proposal
        the corrected formula, in LaTeX, where several changes at once are needed, which are not
        searched: tried where no single change is proved, and accepted only if it is proved.
    source
        what the derived side was made from, where that is not the source of the study.
    cited
        what of it is proved, where the rest is quoted; the verdict is then at most "cited".
    constrains
        how many conditions a constraint adds to those before it in its display; it must hold where
        the constraints hold, and be independent of these.
    sentence
        for a formula that is words in a display: its print with slots, and what decides it.
    """

    role: str = "claim"
    study: str = ""
    also: tuple[str, ...] = ()
    truth: Callable[..., Any] | None = None
    value: Callable[..., Any] | None = None
    stationary: bool = False
    given: tuple[str, ...] = ()
    derived: Callable[..., Any] | None = None
    convention: Convention | None = None
    decide: Decision | None = None
    says: str = ""
    within: tuple[str, ...] = ()
    proposal: str | None = None
    source: str = ""
    cited: str = ""
    constrains: int = 0
    sentence: Sentence | None = None

    def __post_init__(self) -> None:
        if self.role not in ROLES:
            raise DefinitionError(
                f"the role '{self.role}' of a check is none of {', '.join(ROLES)}"
            )


@dataclass(frozen=True)
class Display:
    """One display of the paper: its LaTeX with delimiters and labels, letter for letter.

    ``checks`` has an entry for each formula in it; formulas beyond the last entry take the last.
    """

    latex: str
    checks: tuple[Check, ...] = (Check(),)

    def __post_init__(self) -> None:
        if not isinstance(self.checks, tuple) or not self.checks:
            raise DefinitionError("the checks of a display are a tuple: write (Check(...),)")
        if not any(unit.pieces for unit in self.units):
            start = " ".join(self.latex.split())[:40]
            raise DefinitionError(f"the display '{start}' holds no formula")

    @cached_property
    def units(self) -> tuple[FormulaUnit, ...]:
        """What bears one number in print."""
        return split_display(self.latex)

    def check(self, position: int) -> Check:
        """The check of the formula at ``position``, counted through the whole display."""
        return self.checks[min(position, len(self.checks) - 1)]
