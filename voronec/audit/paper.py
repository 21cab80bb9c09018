"""A paper as a plugin: its displays, transcribed literally, and dictionaries to derived systems."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from voronec.audit.displays import Unit, split_display
from voronec.audit.study import Study
from voronec.errors import DefinitionError

__all__ = ["Check", "Convention", "Display", "Paper", "Section"]

ROLES = ("claim", "definition", "condition", "cited")


@dataclass(frozen=True)
class Convention:
    """Names read otherwise: ``names`` replace those of the dictionary, ``statement`` says how.

    ``against`` names the formula of the paper that contradicts this reading.
    """

    statement: str
    against: str
    names: Mapping[str, Any]


@dataclass(frozen=True)
class Check:
    """How one formula is compared with what is derived; the defaults suit an identity.

    role
        ``claim``; ``definition``: it introduces a name whose meaning the dictionary derives;
        ``condition``: an assumption; ``cited``: a fact that is quoted.
    study
        which dictionary of the section; the first one by default.
    also
        further dictionaries under which a formula that is proved must hold too.
    truth
        for an equation of motion: function of the study and the values ``{letter: value}`` of its
        free indices (``{"i": ...}`` for a variation), which returns the derived expression that
        vanishes; left minus right of the formula must be that, up to a factor that is not zero.
    stationary
        the formula is an integral that is stationary; ``truth`` as above, for each variation.
    given
        labels of conditions that are in force.
    derived
        function of the same that returns derived pairs (left, right) to
        print; by default the formula's left side with its derived value.
    convention
        another reading to be tried where the formula is refuted.
    """

    role: str = "claim"
    study: str = ""
    also: tuple[str, ...] = ()
    truth: Callable[..., Any] | None = None
    stationary: bool = False
    given: tuple[str, ...] = ()
    derived: Callable[..., Any] | None = None
    convention: Convention | None = None

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

    @cached_property
    def units(self) -> tuple[Unit, ...]:
        """What bears one number in print."""
        return split_display(self.latex)

    def check(self, position: int) -> Check:
        """The check of the formula at ``position``, counted through the whole display."""
        return self.checks[min(position, len(self.checks) - 1)]


@dataclass(frozen=True)
class Section:
    """A section or subsection of the paper.

    ``studies`` takes the transcript and returns the dictionaries by name.  ``asides`` are
    formulas of the running text that define names, as LaTeX with its dollar signs.
    """

    title: str
    displays: tuple[Display, ...]
    studies: Callable[[Any], Mapping[str, Study]]
    label: str | None = None
    asides: tuple[str, ...] = ()


@dataclass(frozen=True)
class Paper:
    """A paper to be audited."""

    name: str
    title: str
    sections: tuple[Section, ...]
    references: tuple[str, ...] = ()
    authors: str = ""
