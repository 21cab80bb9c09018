"""The forms in which equations are printed: one line each."""

from __future__ import annotations

from collections.abc import Callable
from operator import methodcaller
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from voronec.equations.voronec_equations import VoronecEquations


class Printer(NamedTuple):
    """What is printed, in words, and the functions from equations to text: without the Jacobian
    and, where that can be printed, with it."""

    about: str
    text: Callable[[VoronecEquations], str]
    with_jacobian: Callable[[VoronecEquations], str] | None = None


def _program(language: str, method: str) -> Printer:
    return Printer(
        f"the right-hand side as {language}",
        methodcaller(method),
        methodcaller(method, jacobian=True),
    )


PRINTERS: dict[str, Printer] = {
    "latex": Printer("the equations as LaTeX", methodcaller("latex")),
    "python": _program("Python", "python"),
    "c": _program("C", "c"),
    "javascript": _program("JavaScript", "javascript"),
    "casadi": _program("Python on CasADi's expressions", "casadi"),
    "jax": _program("Python on JAX", "jax"),
}
"""By the option of ``voronec derive`` that asks for it."""
