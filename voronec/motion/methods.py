"""The methods of integration: one line each; nothing is imported before one is used."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from voronec.motion.tolerances import EXACT, FINEST

if TYPE_CHECKING:
    from voronec.motion.steppers.run import Problem, Stepper

__all__ = ["CLOSED_FORM", "METHODS", "Method", "method_names"]

CLOSED_FORM = "closed-form"
"""Evaluates a declared motion; it takes no steps, and is no integrator."""


@dataclass(frozen=True)
class Method:
    """A method of integration.

    make
        from a problem to what integrates it; none where no steps are taken.
    finest
        a finer tolerance is raised to this one, which costs no accuracy.
    best
        the tolerance at which it is shown at its best (``voronec hard``); ``finest`` unless given.
    symbolic
        whether it wants the equations as expressions, all of them: it asks Python for no inputs.
    exact
        whether it computes in many digits.
    many
        whether it integrates many motions side by side.
    library
        what has to be installed for it.
    other
        the method that may go on where this one cannot.
    """

    make: Callable[[Problem], Stepper] | None
    finest: float = 0.0
    best: float | None = None
    symbolic: bool = False
    exact: bool = False
    many: bool = False
    library: str = ""
    other: str = ""

    @property
    def is_there(self) -> bool:
        """Whether what it wants is installed."""
        try:
            return not self.library or find_spec(self.library) is not None
        except (ImportError, ValueError):
            return False


def _taylor(problem: Problem) -> Stepper:
    from voronec.motion.steppers.heyoka_stepper import taylor

    return taylor(problem)


def _dop853(problem: Problem) -> Stepper:
    from voronec.motion.steppers.scipy_stepper import dop853

    return dop853(problem)


def _compiled_stepper(problem: Problem) -> Stepper:
    from voronec.motion.steppers.numba_stepper import compiled_dop853

    return compiled_dop853(problem)


def _interpreted_stepper(problem: Problem) -> Stepper:
    from voronec.motion.steppers.python_stepper import python_dop853

    return python_dop853(problem)


def _lsoda(problem: Problem) -> Stepper:
    from voronec.motion.steppers.scipy_stepper import lsoda

    return lsoda(problem)


def _digits(problem: Problem) -> Stepper:
    from voronec.motion.steppers.integer_taylor import digits

    return digits(problem)


METHODS: dict[str, Method] = {
    # below EXACT a tolerance would only raise the order of heyoka's series, beyond all bounds
    "heyoka": Method(_taylor, EXACT, symbolic=True, many=True, library="heyoka", other="scipy"),
    "scipy": Method(_dop853, FINEST, many=True, other="heyoka"),
    "numba": Method(
        _compiled_stepper, FINEST, symbolic=True, many=True, library="numba", other="heyoka"
    ),
    "python": Method(_interpreted_stepper, FINEST, symbolic=True, other="heyoka"),
    "lsoda": Method(_lsoda, FINEST, best=1e-13),
    "flint": Method(_digits, best=1e-25, symbolic=True, exact=True),
    CLOSED_FORM: Method(None, best=EXACT),
}


def method_names(many: bool = False) -> tuple[str, ...]:
    """What ``method`` may be: the tool's own choice, and all methods, or those for many motions."""
    return ("auto", *(name for name, method in METHODS.items() if method.many or not many))
