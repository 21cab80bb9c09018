"""The methods of integration: one line each; nothing is imported before one is used."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from shutil import which
from typing import TYPE_CHECKING

from voronec.motion.tolerances import EXACT, FINEST

if TYPE_CHECKING:
    from voronec.equations.program import Program
    from voronec.motion.steppers.run import Problem, Stepper

__all__ = ["CLOSED_FORM", "METHODS", "Method", "compiled_method", "method_names"]

Loop = Callable[..., Callable[..., int]]
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
    compiler
        the command that it runs.
    other
        the method that may go on where this one cannot.
    loop
        what compiles a program, and functions of events, into steps along a grid.
    """

    make: Callable[[Problem], Stepper] | None
    finest: float = 0.0
    best: float | None = None
    symbolic: bool = False
    exact: bool = False
    many: bool = False
    library: str = ""
    compiler: str = ""
    other: str = ""
    loop: Loop | None = None

    @property
    def is_there(self) -> bool:
        """Whether what it wants is installed."""
        try:
            if self.compiler and which(self.compiler) is None:
                return False
            return not self.library or find_spec(self.library) is not None
        except (ImportError, ValueError):
            return False


def _taylor(problem: Problem) -> Stepper:
    from voronec.motion.steppers.heyoka_stepper import taylor

    return taylor(problem)


def _dop853(problem: Problem) -> Stepper:
    from voronec.motion.steppers.scipy_stepper import dop853

    return dop853(problem)


def _numba_loop(program: Program, levels: Program | None = None) -> Callable[..., int]:
    from voronec.motion.steppers.numba_stepper import compiled_loop

    return compiled_loop(program, levels)


def _c_loop(program: Program, levels: Program | None = None) -> Callable[..., int]:
    from voronec.motion.steppers.c_stepper import c_loop

    return c_loop(program, levels)


def _compiled_stepper(problem: Problem, loop: Loop) -> Stepper:
    from voronec.motion.steppers.numba_stepper import compiled_dop853

    return compiled_dop853(problem, loop)


def _interpreted_stepper(problem: Problem) -> Stepper:
    from voronec.motion.steppers.python_stepper import python_dop853

    return python_dop853(problem)


def _lsoda(problem: Problem) -> Stepper:
    from voronec.motion.steppers.scipy_stepper import lsoda

    return lsoda(problem)


def _digits(problem: Problem) -> Stepper:
    from voronec.motion.steppers.integer_taylor import digits

    return digits(problem)


# fmt: off
METHODS: dict[str, Method] = {
    # below EXACT a tolerance would only raise the order of heyoka's series, beyond all bounds
    "heyoka": Method(_taylor, EXACT, symbolic=True, many=True, library="heyoka", other="scipy"),
    "scipy": Method(_dop853, FINEST, many=True, other="heyoka"),
    "numba": Method(
        partial(_compiled_stepper, loop=_numba_loop), FINEST, symbolic=True, many=True,
        library="numba", other="heyoka", loop=_numba_loop,
    ),
    "c": Method(
        partial(_compiled_stepper, loop=_c_loop), FINEST, symbolic=True, many=True, compiler="cc",
        other="heyoka", loop=_c_loop,
    ),
    "python": Method(_interpreted_stepper, FINEST, symbolic=True, other="heyoka"),
    "lsoda": Method(_lsoda, FINEST, best=1e-13),
    "flint": Method(_digits, best=1e-25, symbolic=True, exact=True),
    CLOSED_FORM: Method(None, best=EXACT),
}
# fmt: on


def compiled_method() -> str:
    """The method by which ``auto`` compiles DOP853 here; empty where there is none."""
    if METHODS["numba"].is_there:
        return "numba"
    # elsewhere what is called by this name may be no compiler, but ask to install one
    return "c" if sys.platform == "linux" and METHODS["c"].is_there else ""


def method_names(many: bool = False) -> tuple[str, ...]:
    """What ``method`` may be: the tool's own choice, and all methods, or those for many motions."""
    return ("auto", *(name for name, method in METHODS.items() if method.many or not many))
