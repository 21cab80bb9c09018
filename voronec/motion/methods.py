"""The methods of integration, one line each, and which of them ``method="auto"`` takes.

Nothing is imported before a method is used.

A tolerance finer than doubles asks for ``flint``, and a motion that is stiff for ``lsoda``.  Else
heyoka errs least; DOP853, compiled by a C compiler, is taken where it reaches the same error
sooner, which ``method_costs`` counts.  Heavy programs take heyoka seconds to compile, and steps of
DOP853 cost far less there: a C compiler is done with most of them in less than one, and numba does
very many steps, or scipy what it integrates sooner than these compile.  Where heyoka does not
install, the C compiler does all motions, or numba what would take scipy longer than to compile, and
scipy the rest.  The rule
counts operations; it neither measures times nor looks at what is on disk or loaded: the same call
always makes the same choice.  (A motion that is declared in closed form is evaluated, where the
span is long: ``voronec.motion.prepared_problem``.)
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from importlib.util import find_spec
from math import inf
from shutil import which
from typing import TYPE_CHECKING, Any

from voronec.errors import DefinitionError, EngineLimit, quote
from voronec.motion.tolerances import EXACT, FINEST

if TYPE_CHECKING:
    import numpy as np

    from voronec.motion.steppers import Integrator, Leap, Problem, Run

Loop = Callable[..., Callable[..., int]]
IMPORT_ERRORS: dict[str, str] = {}
"""Libraries that are installed and could not be imported, and what is said of them."""
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
    leap
        from a problem to what goes from one sample of a controller to the next in little time.
    follows_events
        whether its own steps are as short as the functions of events ask for.
    sound_steps
        after more steps a run is said to have added up their errors; none say so by default.
    """

    make: Callable[[Problem], Integrator] | None
    finest: float = 0.0
    best: float | None = None
    symbolic: bool = False
    exact: bool = False
    many: bool = False
    library: str = ""
    compiler: str = ""
    other: str = ""
    loop: Loop | None = None
    leap: Callable[[Problem], AbstractContextManager[Leap]] | None = None
    follows_events: bool = False
    sound_steps: float = inf

    @property
    def absence(self) -> str:
        """Why it cannot be used, as far as that is known without a look into its library; empty
        where it can."""
        if self.compiler and _look_up(which, self.compiler, os.environ.get("PATH")) is None:
            return f"there is no command '{self.compiler}'"
        find = find_spec if self.library in sys.modules else _find_spec
        with suppress(ImportError, ValueError):
            if not self.library or find(self.library) is not None:
                return IMPORT_ERRORS.get(self.library, "")
        return f"{self.library} is not installed"

    @property
    def compiles_soon(self) -> bool:
        """Whether it compiles about as fast as scipy loads: the machine's own compiler does."""
        return bool(self.compiler)


@lru_cache(maxsize=16)  # every run asks, and folders are slow to answer
def _look_up(find: Callable[[str], Any], name: str, _where: Any) -> Any:
    return find(name)


def _find_spec(library: str) -> Any:
    return _look_up(find_spec, library, tuple(sys.path))


def _steppers() -> Any:
    """The integrators, loaded when one is made."""
    from voronec.motion import steppers

    return steppers


# fmt: off
METHODS: dict[str, Method] = {
    # below EXACT a tolerance would only raise the order of heyoka's series, beyond all bounds
    "heyoka": Method(
        lambda problem: _steppers().taylor(problem), EXACT, symbolic=True, many=True,
        library="heyoka", other="scipy", leap=lambda problem: _steppers().taylor_leap(problem),
        follows_events=True,
    ),
    "scipy": Method(
        lambda problem: _steppers().dop853(problem), FINEST, many=True, other="heyoka",
    ),
    "numba": Method(
        lambda problem: _steppers().compiled_dop853(problem), FINEST, symbolic=True, many=True,
        library="numba", other="heyoka", loop=lambda *given: _steppers().compiled_loop(*given),
        leap=lambda problem: _steppers().dop853_leap(problem),
    ),
    "c": Method(
        lambda problem: _steppers().compiled_dop853(problem, _steppers().c_loop), FINEST,
        symbolic=True, many=True, compiler="cc", other="heyoka",
        loop=lambda *given: _steppers().c_loop(*given),
        leap=lambda problem: _steppers().dop853_leap(problem, _steppers().c_loop),
    ),
    # its steps are short, and err by the tolerance with the same sign: of so many by 1e-9 at 1e-13
    "lsoda": Method(
        lambda problem: _steppers().lsoda(problem), FINEST, best=1e-13, other="heyoka",
        sound_steps=10_000,
    ),
    "flint": Method(
        lambda problem: _steppers().digits(problem), best=1e-25, symbolic=True, exact=True
    ),
    CLOSED_FORM: Method(None, best=EXACT),
}
# fmt: on


def absent(method: str, error: ImportError) -> DefinitionError:
    """The refusal of a method whose library failed to load; one that is installed counts as absent
    from then on, with one warning."""
    entry = METHODS[method]
    if not entry.absence:
        IMPORT_ERRORS[entry.library] = (
            f"{entry.library} is installed but cannot be imported: {quote(error)}"
        )
        warnings.warn(f"{entry.absence}; it counts as absent", stacklevel=2)
    return DefinitionError(f"{entry.absence}; 'pip install {method}', or use method='scipy'")


def compiled_method() -> str:
    """The method by which ``auto`` compiles DOP853 here; empty where there is none."""
    # elsewhere what is called by this name may be no compiler, but ask to install one
    if sys.platform == "linux" and not METHODS["c"].absence:
        return "c"
    return "" if METHODS["numba"].absence else "numba"


def method_names(many: bool = False) -> tuple[str, ...]:
    """What ``method`` may be: the tool's own choice, and all methods, or those for many motions."""
    return ("auto", *(name for name, method in METHODS.items() if method.many or not many))


CONTINUOUS = "where a controller jumps or chatters, give Sampled(controller, period)"
"""What helps where steps collapse under a controller that is asked everywhere."""
HEAVY = 200.0
"""Above this weight heyoka compiles for more than a second where it has not seen a program yet."""
TINY = 2_000_000
"""So many operations take Python less time than to compile a heavy program."""
STAGES = 12
"""Evaluations in a step of DOP853."""
COMPILATION = 20_000_000
"""So many operations take Python a second or two, and numba some seconds to compile for them; the
C compiler takes about as long as it takes to load scipy."""
LONG_RUN = 100_000
"""So many steps of a heavy program take heyoka longer than numba takes to compile and to run."""


def is_exact(method: str, tol: float) -> bool:
    """Whether a run is in high precision."""
    if method == "auto":
        return tol < EXACT
    return method in METHODS and METHODS[method].exact


def choose(
    method: str, problem: Problem, grid: np.ndarray, outset: Problem | None = None
) -> tuple[Integrator, dict[str, Any]]:
    """The integrator, ready to run, and what ``Cost`` says of the choice.

    Steps are counted from the ``outset``: the problem itself, unless another is given, in variables
    that are regular where the run begins.
    """
    if method != "auto" and method not in METHODS:
        known = ", ".join(method_names())
        raise DefinitionError(f"there is no method '{method}'; methods are {known}")
    if method == CLOSED_FORM:
        raise DefinitionError(f"'{CLOSED_FORM}' takes no steps; it evaluates one motion at a time")
    called = problem.changing.python_signal if problem.changing is not None else None
    symbolic = method in METHODS and METHODS[method].symbolic
    if called is not None and (symbolic or problem.tol < EXACT):
        raise DefinitionError(
            f"the input '{called.name}' is {called.kind}, known in doubles and without a "
            "Taylor series; take method='scipy' and tol >= 1e-16, or give "
            f"{called.smoother}"
        )
    if method in ("heyoka", "numba", "c") and not problem.program.state:
        return _make_stepper("scipy", problem, f"nothing moves, and {method} wants equations")
    if method != "auto":
        used, reason, loss = method, "", 1.0
    elif called is not None:
        used, reason, loss = "scipy", f"the input '{called.name}' is {called.kind}", 1.0
    else:
        used, reason, loss = _best(outset or problem, grid)
    try:
        finer = replace(problem, tol=problem.tol / loss)
        told = f"auto: {reason}" if reason else "asked for"
        solver, chosen = _make_stepper(used, finer, told)
        return solver, chosen | {"tolerance": max(problem.tol, METHODS[used].finest)}
    except EngineLimit as limit:
        if method != "auto":
            raise
        other = METHODS[used].other
        other = other if other and not METHODS[other].absence else "scipy"
        return _make_stepper(other, problem, f"auto: {limit}")
    except ImportError as error:
        refusal = absent(used, error)
        if method != "auto" or not METHODS[used].library:
            raise refusal from None
    return choose(method, problem, grid, outset)  # among what is left


def _best(problem: Problem, grid: np.ndarray) -> tuple[str, str, float]:
    """The method to take, why, and how many times finer its tolerance has to be."""
    from voronec.motion.method_costs import FINER, dop853_is_cheaper, is_stiff

    compiled = compiled_method()
    if problem.tol >= FINEST and problem.program.state:
        if not problem.switching_surfaces and is_stiff(problem, grid):
            return "lsoda", "the motion is stiff", FINER
        light = problem.program.weight <= HEAVY and not METHODS["heyoka"].absence
        soon = light and compiled and METHODS[compiled].compiles_soon
        if soon and dop853_is_cheaper(problem.program, problem.tol / FINER):
            return compiled, "its steps cost less than those of heyoka at equal error", FINER
    return *_usual(problem, grid, compiled), 1.0


def _usual(problem: Problem, grid: np.ndarray, compiled: str) -> tuple[str, str]:
    """The method to take and why, where no other makes up for a finer tolerance; ``compiled`` is
    that by which DOP853 may be compiled."""
    if problem.tol < EXACT:
        return "flint", "the tolerance is finer than doubles"
    if not problem.program.state:
        return "scipy", "nothing moves"
    soon = bool(compiled) and METHODS[compiled].compiles_soon
    heavy = problem.tol >= FINEST and problem.program.weight > HEAVY
    absence = METHODS["heyoka"].absence
    there = not absence
    if there and not heavy:
        return "heyoka", "heyoka is installed"
    if not there and (soon or not compiled):
        return compiled or "scipy", absence
    from voronec.motion.steppers import TRIAL, estimated_steps

    cost = STAGES * (problem.program.operations + 1)
    enough = TINY if there else COMPILATION
    steps = None if soon and TRIAL * cost > enough else estimated_steps(problem, grid)
    if steps is not None and steps * cost <= enough:
        other = "heyoka" if there else compiled
        return "scipy", f"about {steps} steps take less time than compiling for {other}"
    if soon:
        return compiled, "a heavy program"
    if steps is None:
        return ("heyoka", "heyoka is installed") if there else ("scipy", absence)
    if not there:
        return compiled, f"{absence}, and there are many steps"
    if compiled and steps > LONG_RUN:
        return compiled, "many steps of a heavy program"
    return "heyoka", "heyoka is installed"


def _make_stepper(method: str, problem: Problem, reason: str) -> tuple[Integrator, dict[str, Any]]:
    from voronec.motion.input_knots import in_pieces
    from voronec.motion.steppers import held_integrator

    made = METHODS[method]
    make = made.make
    assert make is not None
    if problem.levels is not None and not made.follows_events:
        from voronec.motion.steppers import make_with_event_states

        make = partial(make_with_event_states, make)
    if problem.tol < made.finest:
        problem = replace(problem, tol=made.finest)
    chosen = {"method": method, "reason": reason, "tolerance": problem.tol}
    changing = problem.changing
    if changing is None:
        return make(problem), chosen
    feedbacks = changing.feedbacks
    alone = problem.levels is None and not problem.dense and changing.python_signal is None
    if feedbacks and alone and made.leap is not None:
        return held_integrator(made.leap, problem), chosen
    followed = [feedback for feedback in feedbacks if not feedback.is_sampled]
    pieces = in_pieces(make, replace(problem, dense=problem.dense or bool(followed)), made.exact)

    def run(grid: np.ndarray) -> Run:
        course, told = pieces(grid), problem.state_view()

        def motion(times: np.ndarray) -> list[Mapping[str, float]]:
            assert course.inside is not None
            states = course.inside(times).tolist()
            return [told(t, y, problem.parameters) for t, y in zip(times, states, strict=True)]

        for feedback in followed:
            feedback.motion = motion
        if followed and course.halt is not None and not course.halt.mend:
            course = replace(course, halt=replace(course.halt, mend=CONTINUOUS))
        return course if problem.dense else replace(course, inside=None)

    return run if followed else pieces, chosen
