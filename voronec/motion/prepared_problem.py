"""Problems made ready for many runs: what is asked is read once, and each run does the rest."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from time import perf_counter
from types import MappingProxyType
from typing import Any

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.arguments import CALLABLE, FLAG, SEVERAL, TEXT, TOLERANCE, VALUES, accepts
from voronec.algebra.memo import Memo
from voronec.algebra.text import as_expression
from voronec.declaration.reading import several
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_system
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion.angle_cuts import CutWatch
from voronec.motion.inputs import Drive, drive
from voronec.motion.integration import MotionRequest, first_success
from voronec.motion.methods import CLOSED_FORM, METHODS
from voronec.motion.motion_start import InitialState
from voronec.motion.request import (
    Event,
    Guard,
    Namespace,
    StartData,
    events_of,
    grid_of,
    name_events,
    outputs_of,
    scene_of,
)
from voronec.motion.trajectory import Cost, Trajectory

FEW = 100
"""On grids with fewer points angles are integrated, not read off: branches could not be told."""
FAR = 500.0
"""Over so long a span a new motion costs less in closed form than by steps, whose errors add up:
both are about equal at half of it for every system that declares one."""


PROBLEM_KINDS = {
    "outputs": SEVERAL, "inputs": VALUES, "method": TEXT, "tol": TOLERANCE, "project": FLAG,
    "dense": FLAG,
}  # fmt: skip
RUN_KINDS = {"initial": VALUES, "parameters": VALUES, "progress": CALLABLE}
"""Kinds of arguments: of a problem, and of one run of it."""


@dataclass(frozen=True, eq=False)
class PreparedProblem:
    """A system made ready for many runs; ``prepare`` makes it.

    ``run`` gives what ``integrate`` does with the same arguments, to the last bit, and does only
    what depends on its own: the start, the parameters and the times.  The first run of each kind of
    start - which variables are zero, which integrals may stand in for equations - writes and
    compiles the model of that kind, which later ones find.
    """

    source: System | VoronecEquations
    scene: str | Scene | None
    outputs: tuple[Any, ...]
    method: str
    tol: float
    events: tuple[Event, ...]
    project: bool
    dense: bool
    inputs: Mapping[Any, Any] | None
    memo: Memo = field(default_factory=Memo, init=False, repr=False)

    @property
    def system(self) -> System:
        """The system, as it was declared."""
        source = self.source
        return source.system if isinstance(source, VoronecEquations) else require_system(source)

    @accepts(**RUN_KINDS)
    def run(
        self,
        initial: Mapping[Any, Any] | None = None,
        parameters: Mapping[Any, Any] | None = None,
        times: Any = None,
        progress: Callable[[float], Any] | None = None,
    ) -> Trajectory:
        """The motion from one start, on a grid of times.

        ``initial``, ``parameters``, ``times`` and ``progress`` are those of ``integrate``, and so
        are what is returned and the errors that are raised.
        """
        return self._motion(initial, parameters, times, progress, perf_counter())

    def _read(self, initial_given: bool) -> _ProblemReading:
        """What is asked, with the scene of a run that is given initial values, or none."""
        alone = initial_given and self.scene is None
        return self.memo.once(
            alone, lambda: _ProblemReading.of(self, scene_of(self.system, self.scene, not alone))
        )

    def _motion(
        self, initial: Mapping[Any, Any] | None, parameters: Mapping[Any, Any] | None, times: Any,
        progress: Callable[[float], Any] | None, began: float,
    ) -> Trajectory:  # fmt: skip
        """The motion; its set-up counts from the time that it ``began``."""
        read, tol, method = self._read(initial is not None), self.tol, self.method
        grid = grid_of(self.system, read.scene, times)
        start, end = float(grid[0]), float(grid[-1])
        driven, namespace, guards = read.drive.over(start, end), read.namespace, read.guards
        given = read.start_data.with_values(namespace, parameters, initial)
        given = replace(given, parameters={**given.parameters, **driven.parameters(start, end)})
        outset = InitialState.of(namespace, given, start, self.project, driven.changing)
        far = driven.equations.system.motion is not None and abs(end - start) >= FAR
        if method == CLOSED_FORM or (method == "auto" and far and not guards):
            from voronec.motion.closed_form_run import evaluated_motion

            with suppress(*(() if method == CLOSED_FORM else (DefinitionError, EngineLimit))):
                return evaluated_motion(
                    namespace, read.outputs, given, outset, grid, tol, self.dense, progress,
                    began, method,
                )  # fmt: skip
        followed = self.dense or bool(guards) or not read.outputs or len(grid) < FEW

        def go(
            outputs: tuple[Any, ...], functions: Mapping[str, Any], guards: tuple[Guard, ...],
            grid: np.ndarray,
        ) -> Trajectory:  # fmt: skip
            request = MotionRequest(
                namespace, outputs, functions, guards, outset, grid, tol, self.dense, progress,
                followed, method, began, given, self.project,
            )  # fmt: skip
            if driven.changing is not None and driven.changing.feedbacks:
                return request.by_controllers()
            ways = (request.in_smallest, request.otherwise, request.on_coordinates)
            return first_success(request.in_any_velocities(ways), start)

        try:
            trajectory = read.cuts.motion(go, read.outputs, read.functions, guards, grid)
        except IntegrationError as error:
            if error.trajectory is not None:
                error.trajectory = _with_events(error.trajectory, guards)
            raise
        trajectory = _with_events(trajectory, guards)
        more = (*driven.notes, *_notes_of_cost(trajectory.cost, tol))
        if not more and trajectory.system is self.system:
            return trajectory
        notes = (*driven.notes, *trajectory.notes, *more[len(driven.notes) :])
        return replace(trajectory, system=self.system, notes=notes)


@dataclass(frozen=True, eq=False)
class _ProblemReading:
    """What a ``PreparedProblem`` asks for, in the names of its system, and what one scene, or none,
    says of starts."""

    scene: Scene | None
    drive: Drive
    namespace: Namespace
    outputs: tuple[Any, ...]
    guards: tuple[Guard, ...]
    functions: Mapping[str, Any]
    start_data: StartData
    cuts: CutWatch

    @classmethod
    def of(cls, asked: PreparedProblem, scene: Scene | None) -> _ProblemReading:
        """Read what is asked; ``DefinitionError`` for what the system does not know."""
        driven, outputs = drive(asked.source, asked.inputs, scene), outputs_of(scene, asked.outputs)
        _refuse_unknown_functions(driven.equations.system)
        namespace = Namespace.of(driven.equations, driven.meaning)
        namespace.read_outputs(outputs)
        guards, functions = name_events(namespace, asked.events)
        if asked.method == CLOSED_FORM and guards:
            raise DefinitionError(
                "the closed form looks for no events; use another method, or evaluate the motion "
                "on a fine grid"
            )
        data = StartData.of(namespace, scene)
        cuts = CutWatch.of(namespace)
        return cls(scene, driven, namespace, outputs, guards, functions, data, cuts)


@accepts(**PROBLEM_KINDS)
def prepare(
    system: System | VoronecEquations,
    scene: str | Scene | None = None,
    outputs: Sequence[Any] = (),
    method: str = "auto",
    tol: float = 1e-13,
    events: Any = (),
    project: bool = False,
    dense: bool = False,
    inputs: Mapping[Any, Any] | None = None,
) -> PreparedProblem:
    """A system made ready for many runs: ``prepare(system, ...).run(initial=..., times=...)``.

    The equations are derived, and names, outputs, events and inputs are read, once.  The arguments
    are those of ``integrate``; ``initial``, ``parameters``, ``times`` and ``progress`` are those of
    ``PreparedProblem.run``.  Where no ``scene`` is given, a run without ``initial`` takes the one
    called ``default``.

    Raises ``DefinitionError`` for input that makes no sense.
    """
    what = system, scene, outputs, method, tol, events, project, dense, inputs
    problem = _problem_of(*what)
    problem._read(initial_given="default" not in problem.system.scenes)
    return problem


@accepts(**PROBLEM_KINDS, **RUN_KINDS)
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
    inputs: Mapping[Any, Any] | None = None,
) -> Trajectory:
    """The motion of a system from given initial data, on a grid of times.

    system
        a ``System``, or its ``VoronecEquations``, which saves deriving them again.
    scene
        name of one of the system's scenes (or a ``Scene``): initial data, span, parameters and
        outputs.  Where neither scene nor ``initial`` is given, the one called ``default``.
    times
        a strictly monotonic array; it may run backwards.  One number T stands for 1001 points from
        where the scene begins (else from 0) to T.  By default 1001 points over the span of the
        scene (or of the scene ``default``).
    outputs
        names, symbols or expressions; by default all coordinates and velocities.
    parameters, initial
        values by symbol or name, over those of the scene.  ``initial`` takes coordinates, the
        velocities v of the equations, and velocities of any coordinates or of a group's fibre,
        which must agree with the constraints; what nobody gives starts at zero.  Values may contain
        parameters.
    method
        ``heyoka`` (Taylor), ``scipy`` (DOP853), ``numba`` (the same, compiled), ``c`` (compiled by
        the machine's C compiler), ``lsoda`` (scipy's, for stiff systems), ``flint`` (Taylor in any
        precision), or ``auto``.  ``traj.cost`` says which it was, and why.
        ``closed-form`` evaluates the motion, where the system declares one (``closed_form``): its
        cost does not depend on the time, and ``tol`` may be as fine as with ``flint``; it looks
        for no events.
    tol
        the local error of one step that the integrator aims at, relative to the state (absolute
        where the state is small).  The methods differ in what they make of it, so compare errors,
        not tolerances.  scipy takes 2.3e-14 for anything finer, and a note says so; heyoka drifts
        least with 1e-16.
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
    inputs
        the values of the system's inputs, by symbol or name, over those of the scene: a number; an
        expression of the time, and, for inputs in forces alone, of the state; a ``Table``, or a
        pair of times and values; a function of the time (by ``scipy`` only), its rate, where the
        equations hold that, under the rate's symbol or name; for inputs in forces alone a
        controller, a function of the time and of the state, which maps coordinates and velocities
        by name to floats (by ``scipy`` or ``lsoda``), or ``Sampled(controller, period)`` (by any
        method).

    What does not depend on ``times``, ``parameters`` and ``initial`` is prepared as ``prepare``
    does, and kept for the next call.

    Ctrl-C during the run ends it: the trajectory then holds what is done, ends where the run stood
    and is marked ``interrupted``.  Raises ``DefinitionError`` for input that makes no sense, and
    ``IntegrationError`` (with ``time``, ``state`` and the ``trajectory`` up to there) where the
    motion cannot be continued.
    """
    began = perf_counter()
    what = system, scene, outputs, method, tol, events, project, dense, inputs
    return _problem_of(*what)._motion(initial, parameters, times, progress, began)


MOST = 16
"""So many problems stay with a system, as they were prepared for calls of ``integrate``."""


def _problem_of(
    system: System | VoronecEquations, scene: Any, outputs: Any, method: str, tol: float,
    events: Any, project: bool, dense: bool, inputs: Any,
) -> PreparedProblem:  # fmt: skip
    """The problem, as an earlier call left it where it is told by names, symbols and expressions
    alone: other things may change meanwhile, or be equal and yet not the same."""
    asked, looked = several(outputs, "outputs", "name"), events_of(events)
    made = PreparedProblem(system, scene, asked, method, tol, looked, project, dense, inputs)
    made.system  # noqa: B018  what is none is refused before it is asked for its memo
    parts = (*asked, *(event.function for event in looked))
    if inputs or isinstance(scene, Scene) or not all(isinstance(x, str | sp.Basic) for x in parts):
        return made
    key = scene, asked, looked, tuple(map(type, parts)), method, tol, project, dense
    kept: dict[Any, PreparedProblem] = system.memo.once("prepared problems", dict)
    if len(kept) >= MOST and key not in kept:
        kept.clear()
    return kept.setdefault(key, made)


def _with_events(found: Trajectory, guards: Sequence[Guard]) -> Trajectory:
    """A trajectory with what belongs to users alone, called as they do."""
    if not (guards or found.events or found.stopped):
        return found
    names = {guard.name: guard.owner.name for guard in guards if guard.owner is not None}
    events = {title: found.events[name] for name, title in names.items() if name in found.events}
    return replace(found, events=MappingProxyType(events), stopped=names.get(found.stopped, ""))


def _refuse_unknown_functions(system: System) -> None:
    """What holds an unknown function has no motion in numbers."""
    unknown = system.memo.once("unknown functions", lambda: _unknown_functions(system))
    if unknown:
        raise DefinitionError(
            f"system '{system.name}' holds the unknown function '{min(unknown, key=str)}', so it "
            "has no motion in numbers; write a formula in its place"
        )


def _unknown_functions(system: System) -> set[Any]:
    frame = system.frame.expressions if system.frame is not None else ()
    held = (system.lagrangian, *system.constraints, *system.forces.values(), *frame)
    coordinates = {*system.coordinates, *(system.frame.ambient if system.frame is not None else ())}
    return {f for e in held for f in as_expression(e).atoms(AppliedUndef)} - coordinates


def _notes_of_cost(cost: Cost, tol: float) -> Iterator[str]:
    """Notes where the tolerance asked for is finer than the method goes, and where it took so many
    steps that their errors are no longer small."""
    if cost.tolerance > tol:
        yield f"{cost.method} goes no finer than tol = {cost.tolerance:.3g}, taken for {tol:.3g}"
    method = METHODS.get(cost.method)
    if method is not None and cost.steps > method.sound_steps:
        yield (
            f"{cost.method} took {cost.steps} steps, whose errors add up, to "
            f"{cost.steps * cost.tolerance:.0e} and by as much more as the motion magnifies them; "
            "other methods take longer steps"
        )
