"""Which integrator: the rule of ``method="auto"`` in one place.

A tolerance finer than doubles asks for ``flint``.  Else heyoka is the fastest by far once it is
compiled, which takes some tenths of a second, and milliseconds where heyoka finds the code on disk.
Heavy programs take it seconds: what scipy integrates sooner than that, it does.  Where heyoka does
not install, scipy does all the rest.  The rule counts operations and
measures no time, so that the same call always makes the same choice.  (A motion that is declared in
closed form is evaluated, where the span is long: ``voronec.motion.integration``.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.util import find_spec
from typing import Any

import numpy as np

from voronec.errors import DefinitionError, EngineLimit
from voronec.motion.steppers.heyoka_stepper import taylor
from voronec.motion.steppers.integer_taylor import digits
from voronec.motion.steppers.restarts import in_pieces
from voronec.motion.steppers.run import Problem, Stepper
from voronec.motion.steppers.scipy_stepper import FINEST, dop853, estimated_steps, lsoda

__all__ = ["CLOSED", "EXACT", "METHODS", "choose", "is_exact"]

EXACT = 1e-16
"""Doubles have nothing to offer below this tolerance."""
HEAVY = 200.0
"""Above this weight heyoka compiles for more than a second where it has not seen a program yet."""
TINY = 2_000_000
"""So many operations take Python less time than to compile a heavy program."""
STAGES = 12
"""Evaluations in a step of DOP853."""

_MAKERS: dict[str, Callable[[Problem], Stepper]] = {
    "heyoka": taylor,
    "scipy": dop853,
    "lsoda": lsoda,
    "flint": digits,
}
TAYLORS = ("heyoka", "flint")
"""The methods that differentiate the equations themselves."""
CLOSED = "closed-form"
"""Evaluates a declared motion; it takes no steps, and is no integrator."""
METHODS = ("auto", *_MAKERS, CLOSED)


def is_exact(method: str, tol: float) -> bool:
    """Whether a run is in high precision."""
    return method == "flint" or (method == "auto" and tol < EXACT)


def choose(method: str, problem: Problem, grid: np.ndarray) -> tuple[Stepper, dict[str, Any]]:
    """The integrator, ready to run, and what ``Cost`` says of the choice."""
    if method not in METHODS:
        raise DefinitionError(f"there is no method '{method}'; methods are {', '.join(METHODS)}")
    if method == CLOSED:
        raise DefinitionError(f"'{CLOSED}' takes no steps; it evaluates one motion at a time")
    if not 0 < problem.tol < 1:
        raise DefinitionError(f"tol = {problem.tol} must lie between 0 and 1, such as 1e-13")
    called = problem.changing.called if problem.changing is not None else None
    if called is not None and (method in TAYLORS or problem.tol < EXACT):
        raise DefinitionError(
            f"the input '{called.name}' is a function of Python's, known in doubles and without a "
            "Taylor series; take method='scipy' and tol >= 1e-16, or give an expression or a table"
        )
    if method == "heyoka" and not problem.program.state:
        return _made("scipy", problem, "nothing moves, and heyoka wants equations")
    if method != "auto":
        return _made(method, problem, "asked for")
    method, reason = _best(problem, grid)
    if called is not None:
        method, reason = "scipy", f"the input '{called.name}' is a function of Python's"
    try:
        return _made(method, problem, f"auto: {reason}")
    except EngineLimit as limit:
        return _made("scipy", problem, f"auto: {limit}")


def _best(problem: Problem, grid: np.ndarray) -> tuple[str, str]:
    """The method to take, and why."""
    if problem.tol < EXACT:
        return "flint", "the tolerance is finer than doubles"
    if not _is_there("heyoka"):
        return "scipy", "heyoka is not installed"
    if not problem.program.state:
        return "scipy", "nothing moves"
    if problem.tol >= FINEST and problem.program.weight > HEAVY:
        steps = estimated_steps(problem, grid, TINY // (STAGES * (problem.program.operations + 1)))
        if steps is not None:
            return "scipy", f"about {steps} steps take less time than compiling for heyoka"
    return "heyoka", "heyoka is installed"


def _is_there(library: str) -> bool:
    try:
        return find_spec(library) is not None
    except (ImportError, ValueError):
        return False


def _made(method: str, problem: Problem, reason: str) -> tuple[Stepper, dict[str, Any]]:
    # a finer tolerance would only raise the order of heyoka's series, beyond all bounds
    finest = {"scipy": FINEST, "lsoda": FINEST, "heyoka": EXACT}.get(method, 0.0)
    problem = replace(problem, tol=max(problem.tol, finest))
    chosen = {"method": method, "reason": reason, "tolerance": problem.tol}
    try:
        if problem.changing is not None:
            return in_pieces(_MAKERS[method], problem, anew=method == "flint"), chosen
        return _MAKERS[method](problem), chosen
    except ImportError:
        raise DefinitionError(
            f"{method} is not installed; 'pip install {method}', or use method='scipy'"
        ) from None
