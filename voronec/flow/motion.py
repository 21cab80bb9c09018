"""Integrating a system: the steps from a definition to a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter, process_time
from types import MappingProxyType
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.equations import VoronecEquations, derive
from voronec.errors import DefinitionError, IntegrationError, did_you_mean
from voronec.flow.events import Crossings, Event, spelled
from voronec.flow.exactly import Exactly
from voronec.flow.modelling import Modelled, modelled, whole
from voronec.flow.observing import Watch, followed, observed
from voronec.flow.probe import Probe, quantities
from voronec.flow.start import named, parameter_values, start_of
from voronec.flow.steppers import Problem, Run
from voronec.flow.trajectory import Cost, Trajectory
from voronec.flow.traverse import through_charts
from voronec.flow.vocabulary import Vocabulary, number
from voronec.program import Program
from voronec.program.digits import precision
from voronec.scene import Scene
from voronec.system import System

__all__ = ["integrate"]

POINTS = 1001
"""How many points a scene's span is seen at."""
FEW = 100
"""On grids with fewer points angles are integrated, not read off: branches could not be told."""
PER_STEP = 4
"""So many points of the grid in a step, at least, tell the branches of angles apart."""


def integrate(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    times: Any = None,
    outputs: Sequence[Any] = (),
    parameters: Mapping[Any, Any] | None = None,
    initial: Mapping[Any, Any] | None = None,
    method: str = "auto",
    tol: float = 1e-13,
    events: Any = (),
    project: bool = False,
    dense: bool = False,
    progress: Callable[[float], Any] | None = None,
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
        ``heyoka`` (Taylor), ``scipy`` (DOP853), ``lsoda`` (scipy's, for stiff systems), ``flint``
        (Taylor in any precision), or ``auto``.  ``traj.cost`` says which it was, and why.
    tol
        the local error of one step that the integrator aims at, relative to the state (absolute
        where the state is small).  The methods differ in what they make of it, so compare errors,
        not tolerances.  scipy takes 2.3e-14 for anything finer; heyoka drifts least with 1e-16.
        With ``flint`` it may be 1e-40 and finer: values given exactly are then used exactly, those
        given as floats as the doubles they are, and the results are mpmath's numbers.
    events
        ``Event``s, or bare names and expressions: instants at which they pass through zero, kept in
        ``traj.events``.  An event may stop the run.
    project
        moves initial data that are off the constraints onto them; without it they are refused.
    dense
        keeps the whole motion, for ``traj.at(times)``.
    progress
        called now and then on long runs, with the fraction that is done.

    Ctrl-C during the run ends it: the trajectory then holds what is done and is marked
    ``interrupted``.  Raises ``DefinitionError`` for input that makes no sense, and
    ``IntegrationError`` (with ``time``, ``state`` and the ``trajectory`` up to there) where the
    motion cannot be continued.
    """
    began = perf_counter()
    equations = system if isinstance(system, VoronecEquations) else derive(system)
    _refuse_unknown_functions(equations.system)
    vocabulary = Vocabulary.of(equations)
    setting = _setting(vocabulary, scene, times, outputs, parameters, initial)
    happenings, levels = spelled(vocabulary, events)
    ground = _Ground.of(vocabulary, setting, project)
    followed = dense or bool(happenings) or not setting.outputs or len(setting.grid) < FEW

    def moved(made: Modelled) -> Trajectory:
        job = _Job(vocabulary, made, ground, setting.grid, tol, happenings, dense, progress)
        return job.trajectory(method, began)

    def smallest(followed: bool) -> Modelled:
        return modelled(
            vocabulary, setting.outputs, levels, ground.state, ground.constants,
            float(setting.grid[0]), followed,
        )  # fmt: skip

    try:
        made = smallest(followed)
        trajectory = moved(made)
        if followed or _told_apart(trajectory, made):
            return trajectory
        # the grid is too coarse to tell branches of angles apart
        return moved(smallest(True))
    except IntegrationError:
        if not equations.system.charts or method == "flint":
            raise
    # where this model is singular, the equations on the coordinates may have another chart
    return moved(whole(vocabulary, setting.outputs, levels))


def _told_apart(trajectory: Trajectory, made: Modelled) -> bool:
    """Whether angles that are read off are certain to be on the right branch."""
    if not made.watch.branches or trajectory.cost.steps == 0:
        return True
    if len(trajectory) < PER_STEP * trajectory.cost.steps:
        return False
    jumps = [np.diff(trajectory[name].astype(float)) for name in made.watch.branches]
    return all(np.abs(jump).max(initial=0.0) < np.pi / 2 for jump in jumps)


@dataclass(frozen=True)
class _Ground:
    """The start on the coordinates: state (n,), constants by name, both in any precision too."""

    state: np.ndarray
    constants: Mapping[str, float]
    notes: tuple[str, ...]
    exactly: Exactly

    @classmethod
    def of(cls, vocabulary: Vocabulary, setting: _Setting, project: bool) -> _Ground:
        """Read what is given, and look whether a motion starts there."""
        equations, time = vocabulary.equations, float(setting.grid[0])
        constants = parameter_values(vocabulary, setting.parameters, set())
        form = equations.raw.form  # made in no time
        if any(p.name not in constants for p in equations.system.parameters):
            form = equations.form
            needed = {str(s) for s in Program.of(form).derivative.symbols}
            constants = parameter_values(vocabulary, setting.parameters, needed)
        program = quantities(form, {})

        def rates(q: np.ndarray, v: np.ndarray) -> np.ndarray:
            """Those of the raw equations, or, where they have a pole, of their normal form."""
            found = looking(form).rates(q, v)
            return found if np.isfinite(found).all() else looking(equations.form).rates(q, v)

        def looking(own: Any) -> Probe:
            values = [constants.get(str(p), np.nan) for p in own.parameters]
            return Probe(equations.system.name, own, quantities(own, {}), values, time)

        start = start_of(
            vocabulary, setting.scene_initial, setting.initial, constants, rates, time, project
        )
        exactly = Exactly(
            vocabulary, program, time, setting.parameters, setting.scene_initial, setting.initial,
            start.state, bool(start.notes),
        )  # fmt: skip
        return cls(start.state, constants, start.notes, exactly)


@dataclass(frozen=True)
class _Job:
    """A model to be integrated, and how."""

    vocabulary: Vocabulary
    made: Modelled
    ground: _Ground
    grid: np.ndarray
    tol: float
    events: tuple[Event, ...]
    dense: bool
    progress: Callable[[float], Any] | None

    def trajectory(self, method: str, began: float) -> Trajectory:
        """Integrate, and look at what is wanted; ``IntegrationError`` where it cannot be done."""
        made, ground, time = self.made, self.ground, float(self.grid[0])
        state, values = made.place(ground.state, ground.constants, time)
        probe = made.probe(self.vocabulary.equations.system.name, values, time)
        if not (made.model is None and self.vocabulary.equations.system.charts):
            probe.check(state)
        problem = Problem(
            made.program, state, values, self.tol, self.events, made.levels, self.dense,
            probe.suspect(state), self.progress, self._exact,
        )  # fmt: skip
        stepper, chosen = through_charts(
            method, problem, self.grid, self.vocabulary.equations, made.functions, made.form
        )
        ready, busy = perf_counter(), process_time()
        run = stepper(self.grid)
        cost = Cost(
            **chosen, setup=ready - began + run.prepared,
            run=perf_counter() - ready - run.prepared, cpu=process_time() - busy,
            steps=run.steps, evaluations=run.evaluations, switches=run.switches, level=made.level,
        )  # fmt: skip
        bits = precision(run.states)
        if run.states.dtype == object:
            constants = ground.exactly.constants(bits) | made.constants(self._exact(bits)[1])
        else:
            constants = {**ground.constants, **made.constants(values)}
        sight = _Sight(self.vocabulary, made.watch, made.program, constants, cost, bits)
        trajectory = replace(sight.trajectory(run), notes=ground.notes)
        if run.halt is not None:
            raise probe.failure(state, run.halt, trajectory)
        return trajectory

    def _exact(self, bits: int) -> tuple[np.ndarray, list[Any]]:
        """Start and parameter values as mpmath's numbers."""
        exactly, time = self.ground.exactly, float(self.grid[0])
        with mpmath.workprec(bits):
            state, _ = exactly.problem(bits)
            return self.made.place(state, exactly.constants(bits), time)


@dataclass(frozen=True)
class _Sight:
    """How states become a trajectory."""

    vocabulary: Vocabulary
    watch: Watch
    program: Program
    constants: Mapping[str, Any]
    cost: Cost
    bits: int

    def trajectory(self, run: Run) -> Trajectory:
        """The motion of a run, its events, and, of a dense run, what lies between."""
        seen = self.seen(run.t, run.states, run.interrupted)
        crossings = {name: self.crossings(*rows) for name, rows in run.crossings.items()}
        inside = run.inside
        return replace(
            seen,
            events=MappingProxyType(crossings),
            stopped=run.stopped,
            halted=run.halt.reason if run.halt is not None else "",
            within=None if inside is None else lambda times: self.seen(times, inside(times)),
        )

    def seen(self, t: np.ndarray, states: np.ndarray, interrupted: bool = False) -> Trajectory:
        """Everything watched at some states."""
        with mpmath.workprec(self.bits):
            return observed(
                self.vocabulary, self.watch, self.program, t, states, self.constants, self.cost,
                interrupted,
            )  # fmt: skip

    def crossings(self, t: np.ndarray, states: np.ndarray) -> Crossings:
        """The same at the passages of an event."""
        values = [self.constants.get(str(p), np.nan) for p in self.program.parameters]
        series = dict.fromkeys(self.watch.outputs, t)
        if len(t):
            with mpmath.workprec(self.bits):
                series = followed(self.watch, self.program, t, states, values)
        shown = {name: series[name] for name in self.watch.outputs}
        names = tuple(map(str, self.program.state))
        for array in (t, states, *shown.values()):
            array.flags.writeable = False
        return Crossings(t, states, names, MappingProxyType(shown))


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
