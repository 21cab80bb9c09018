"""The forms in which equations are printed: one line each."""

from __future__ import annotations

from collections.abc import Callable
from operator import methodcaller
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from voronec.equations.voronec_equations import VoronecEquations

__all__ = ["PRINTERS", "Printer"]


class Printer(NamedTuple):
    """What is printed, in words, and the function from equations to text."""

    about: str
    text: Callable[[VoronecEquations], str]


PRINTERS: dict[str, Printer] = {
    "latex": Printer("the equations as LaTeX", methodcaller("latex")),
    "python": Printer("the right-hand side as Python", methodcaller("python")),
    "c": Printer("the right-hand side as C", methodcaller("c")),
}
"""By the option of ``voronec derive`` that asks for it."""
