"""Integrating a system: the steps from a definition to a trajectory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, did_you_mean
from voronec.flow.observing import observed, watched
from voronec.flow.probe import Probe
from voronec.flow.start import initial_state, named, parameter_values
from voronec.flow.steppers import FINEST, Stepper, dop853, taylor
from voronec.flow.trajectory import Cost, Trajectory
from voronec.flow.vocabulary import Vocabulary, number
from voronec.program import Program
from voronec.scene import Scene
from voronec.system import System

__all__ = ["integrate"]

POINTS = 1001
"""How many points a scene's span is seen at."""
METHODS = ("auto", "heyoka", "scipy")


def integrate(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    times: Any = None,
    outputs: Sequence[Any] = (),
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    method: str = "auto",
    tol: float = 1e-13,
) -> Trajectory:
    """The motion of a system from given initial data, on a grid of times.

    system
        a ``System``, or its ``VoronecEquations``, which saves deriving them again.
    scene
        name of one of the system's scenes (or a ``Scene``): initial data, span, parameters and
        outputs.  Where neither scene nor ``initial`` is given, the one called ``default``.
    times
        a strictly monotonic array; it may run backwards.  By default 1001 points over the span of
        the scene (or of the scene ``default``).
    outputs
        names, symbols or expressions; by default all coordinates and velocities.
    parameters, initial
        values by symbol or name, over those of the scene.  ``initial`` takes coordinates, the
        velocities v of the equations, and velocities of any coordinates, which must agree with
        the constraints; what nobody gives starts at zero.  Values may contain parameters.
    method
        ``heyoka`` (Taylor), ``scipy`` (DOP853), or ``auto``: heyoka where it installs, else scipy.
        ``traj.cost`` says which it was, and why.
    tol
        the local error of one step that the integrator aims at, relative to the state (absolute
        where the state is small).  The two methods differ in what they make of it, so compare
        errors, not tolerances.  scipy takes 2.3e-14 for anything finer; heyoka drifts least
        with 1e-16.

    Ctrl-C during the run ends it: the trajectory then holds what is done and is marked
    ``interrupted``.  Raises ``DefinitionError`` for input that makes no sense, and
    ``IntegrationError`` (with ``time`` and ``state``) where the motion cannot be continued.
    """
    began = perf_counter()
    equations = system if isinstance(system, VoronecEquations) else derive(system)
    _refuse_unknown_functions(equations.system)
    vocabulary = Vocabulary.of(equations)
    setting = _setting(vocabulary, scene, times, outputs, parameters, initial)
    watch = watched(vocabulary, setting.outputs)
    program = Program.of(equations.form, watch.expressions)
    needed = {str(s) for b in (program.derivative, program.extras) for s in b.symbols}
    constants = parameter_values(vocabulary, setting.parameters, needed)
    values = [constants.get(str(p), np.nan) for p in program.parameters]
    probe = Probe(equations, program, values, float(setting.grid[0]))
    start = initial_state(
        vocabulary, setting.scene_initial, setting.initial, constants, probe.rates
    )
    probe.check(start)
    stepper, chosen = _choose(method, program, start, values, tol)
    ready = perf_counter()
    run = stepper(setting.grid)
    cost = Cost(
        **chosen, setup=ready - began, run=perf_counter() - ready, steps=run.steps,
        evaluations=run.evaluations,
    )  # fmt: skip
    if run.halt is not None:
        raise probe.failure(start, run.halt)
    t = setting.grid[: len(run.states)]
    return observed(vocabulary, watch, program, t, run.states, constants, cost, run.interrupted)


def _refuse_unknown_functions(system: System) -> None:
    """What holds an unknown function has no motion in numbers."""
    frame = system.frame.expressions if system.frame is not None else ()
    held = (system.lagrangian, *system.constraints, *system.forces.values(), *frame)
    unknown = {f for e in held for f in sp.sympify(e).atoms(AppliedUndef)} - {*system.coordinates}
    if unknown:
        raise DefinitionError(
            f"system '{system.name}' holds the unknown function '{min(unknown, key=str)}', so it "
            "has no motion in numbers; write a formula in its place"
        )


@dataclass(frozen=True)
class _Setting:
    """What is asked for, scene and arguments put together."""

    grid: np.ndarray
    outputs: tuple[Any, ...]
    parameters: Mapping[str, Any]
    scene_initial: Mapping[str, Any]
    initial: Mapping[str, Any]


def _setting(
    vocabulary: Vocabulary,
    scene: str | Scene | None,
    times: Any,
    outputs: Sequence[Any],
    parameters: Mapping[Any, Any] | None,
    initial: Mapping[Any, Any] | None,
) -> _Setting:
    system = vocabulary.equations.system
    chosen = _scene(system, scene, initial is None)
    asked = (outputs,) if isinstance(outputs, str | sp.Basic) else tuple(outputs)
    return _Setting(
        grid=_grid(_span(system, chosen) if times is None else times),
        outputs=asked or (chosen.outputs if chosen else ()),
        parameters={
            **named(vocabulary, chosen.parameters if chosen else {}, "parameter"),
            **named(vocabulary, parameters or {}, "parameter"),
        },
        scene_initial=named(vocabulary, chosen.initial if chosen else {}, "initial value"),
        initial=named(vocabulary, initial or {}, "initial value"),
    )


def _scene(system: System, scene: str | Scene | None, needed: bool) -> Scene | None:
    if isinstance(scene, Scene):
        return scene
    if scene is None:
        if not needed:
            return None
        if "default" not in system.scenes:
            raise DefinitionError(
                f"system '{system.name}' has no scene 'default'; give initial={{...}}, or scene= "
                f"one of its scenes ({', '.join(system.scenes) or 'there are none'})"
            )
        return system.scenes["default"]
    if scene not in system.scenes:
        raise DefinitionError(
            f"system '{system.name}' has no scene '{scene}'{did_you_mean(scene, system.scenes)}"
        )
    return system.scenes[scene]


def _span(system: System, chosen: Scene | None) -> np.ndarray:
    scene = chosen or system.scenes.get("default")
    if scene is None:
        raise DefinitionError(
            f"system '{system.name}' has no scene to take the span from; give times"
        )
    start, end = (number(x, "the span's end") for x in scene.times)
    return np.linspace(start, end, POINTS)


def _grid(times: Any) -> np.ndarray:
    wrong = DefinitionError(
        "times must be a strictly monotonic, finite, one-dimensional array, such as "
        "numpy.linspace(0, 10, 1001)"
    )
    try:
        grid = np.atleast_1d(np.array(times, dtype=float))
    except (TypeError, ValueError):
        raise wrong from None
    if grid.ndim != 1 or grid.size == 0 or not np.isfinite(grid).all():
        raise wrong
    steps = np.diff(grid)
    if not ((steps > 0).all() or (steps < 0).all()):
        raise wrong
    return grid


def _choose(
    method: str, program: Program, start: np.ndarray, values: list[float], tol: float
) -> tuple[Stepper, dict[str, Any]]:
    """The integrator, and what ``Cost`` says of the choice."""
    if method not in METHODS:
        raise DefinitionError(f"there is no method '{method}'; methods are {', '.join(METHODS)}")
    if not 0 < tol < 1:
        raise DefinitionError(f"tol = {tol} must lie between 0 and 1, such as 1e-13")
    reason = "asked for"
    if method != "scipy":
        try:
            stepper = taylor(program, start, values, tol)
            reason = reason if method == "heyoka" else "auto: heyoka is installed"
            return stepper, {"method": "heyoka", "reason": reason, "tolerance": tol}
        except ImportError:
            reason = "auto: heyoka is not installed"
            if method == "heyoka":
                raise DefinitionError(
                    "heyoka is not installed; 'pip install heyoka', or use method='scipy'"
                ) from None
        except EngineLimit as limit:
            if method == "heyoka":
                raise
            reason = f"auto: {limit}"
    stepper = dop853(program, start, values, tol)
    return stepper, {"method": "scipy", "reason": reason, "tolerance": max(tol, FINEST)}
