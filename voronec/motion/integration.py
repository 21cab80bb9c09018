"""Integrating a system: the steps from a definition to a trajectory.

A run that fails falls back before it refuses: on other methods and models, one after another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import ceil, isfinite, log2
from sys import float_info
from time import perf_counter, process_time
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np
from sympy.core.function import AppliedUndef

from voronec.algebra.arguments import CALLABLE, FLAG, SEVERAL, TEXT, TOLERANCE, VALUES, accepts
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_system
from voronec.equations.attitudes import angles_without_chart, euler_angles, with_attitude_charts
from voronec.equations.program import Program
from voronec.equations.program.python import precision
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion.angle_cuts import CutWatch
from voronec.motion.atlas import NEAR as CHANGE
from voronec.motion.atlas import kept_charts
from voronec.motion.chart_stepper import through_charts
from voronec.motion.divisors import Divisor, NearDivisor, guard_events, without_guards
from voronec.motion.inputs import drive
from voronec.motion.methods import CLOSED_FORM, METHODS, choose_regular, is_exact
from voronec.motion.motion_start import Outset, WideStart
from voronec.motion.numeric_model import ProgrammedModel, make_model, whole
from voronec.motion.observables import Watch, evaluate_watch
from voronec.motion.request import (
    Guard,
    StartData,
    Vocabulary,
    grid_of,
    name_events,
    outputs_of,
    scene_of,
)
from voronec.motion.residual_windows import LookGrid, pace_of
from voronec.motion.singular_coordinates import (
    LAST,
    CoordinatePole,
    NearPole,
    PoleGuard,
    PoleNotes,
)
from voronec.motion.soundness import Breach, Judge, Untold, require_branches
from voronec.motion.split_models import divisor_program
from voronec.motion.state_probe import StateProbe, quantities
from voronec.motion.steppers import Halt, Problem, Run, Stepper
from voronec.motion.steppers.run import Signals, constants_along
from voronec.motion.tolerances import EXACT
from voronec.motion.trajectory import Cost, Crossings, Trajectory, make_trajectory

if TYPE_CHECKING:
    from voronec.motion.mode_stepper import SwitchedIntegrator

__all__ = ["Way", "first_success", "integrate", "other_method"]


FEW = 100
"""On grids with fewer points angles are integrated, not read off: branches could not be told."""
MARGIN = 32
"""Bits beyond those of the tolerance with which outputs are computed from precise states."""
FAR = 500.0
"""Over so long a span a new motion costs less in closed form than by steps, whose errors add up:
both are about equal at half of it for every system that declares one."""


@accepts(
    outputs=SEVERAL,
    parameters=VALUES,
    inputs=VALUES,
    initial=VALUES,
    method=TEXT,
    tol=TOLERANCE,
    project=FLAG,
    dense=FLAG,
    progress=CALLABLE,
)
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
        the machine's C compiler), ``python`` (in Python alone), ``lsoda`` (scipy's, for stiff
        systems), ``flint`` (Taylor in any precision), or ``auto``.  ``traj.cost`` says which it
        was, and why.
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
        equations hold that, under the rate's symbol or name.

    Ctrl-C during the run ends it: the trajectory then holds what is done, ends where the run stood
    and is marked ``interrupted``.  Raises ``DefinitionError`` for input that makes no sense, and
    ``IntegrationError`` (with ``time``, ``state`` and the ``trajectory`` up to there) where the
    motion cannot be continued.
    """
    began = perf_counter()
    declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
    chosen = scene_of(declared, scene, initial is None)
    driven = drive(system, inputs, chosen)  # a system that makes no sense is refused before times
    asked, grid = outputs_of(chosen, outputs), grid_of(declared, chosen, times)
    driven = driven.over(float(grid[0]), float(grid[-1]))
    equations = driven.equations
    _refuse_unknown_functions(equations.system)
    vocabulary = Vocabulary.of(equations, driven.meaning)
    given = StartData.of(vocabulary, chosen, parameters, initial)
    given = replace(
        given, parameters={**given.parameters, **driven.parameters(float(grid[0]), float(grid[-1]))}
    )
    guards, functions = name_events(vocabulary, events)
    outset = Outset.of(vocabulary, given, float(grid[0]), project, driven.changing)
    if method == CLOSED_FORM and guards:
        raise DefinitionError(
            "the closed form looks for no events; use another method, or evaluate the motion "
            "on a fine grid"
        )
    far = equations.system.motion is not None and not guards and abs(grid[-1] - grid[0]) >= FAR
    if method == CLOSED_FORM or (method == "auto" and far):
        from voronec.motion.closed_form_run import evaluated_motion

        with suppress(*(() if method == CLOSED_FORM else (DefinitionError, EngineLimit))):
            return evaluated_motion(
                vocabulary, asked, given, outset, grid, tol, dense, progress, began, method
            )
    followed = dense or bool(guards) or not asked or len(grid) < FEW

    def go(
        outputs: tuple[Any, ...], functions: Mapping[str, Any], guards: tuple[Guard, ...],
        grid: np.ndarray,
    ) -> Trajectory:  # fmt: skip
        request = _Request(
            vocabulary, outputs, functions, guards, outset, grid, tol, dense, progress, followed,
            method, began, given, project,
        )  # fmt: skip
        ways = (request.in_smallest, request.otherwise, request.on_coordinates)
        return first_success(request.in_any_split(ways), float(grid[0]))

    try:
        found = CutWatch.of(vocabulary).motion(go, asked, functions, guards, grid)
    except IntegrationError as error:
        if error.trajectory is not None:
            error.trajectory = _with_events(error.trajectory, guards)
        raise
    notes = (*driven.notes, *found.notes, *_notes_of_cost(found.cost, tol))
    return replace(_with_events(found, guards), system=declared, notes=notes)


def _with_events(found: Trajectory, guards: Sequence[Guard]) -> Trajectory:
    """A trajectory with what belongs to users alone, called as they do."""
    names = {guard.name: guard.owner.name for guard in guards if guard.owner is not None}
    events = {own: found.events[name] for name, own in names.items() if name in found.events}
    return replace(found, events=MappingProxyType(events), stopped=names.get(found.stopped, ""))


@dataclass(frozen=True)
class _Request:
    """What is wanted of one motion, and the ways to it, as ``first_success`` takes them.

    ``followed`` says that angles are integrated from the first, not read off.
    """

    vocabulary: Vocabulary
    outputs: tuple[Any, ...]
    functions: Mapping[str, Any]
    events: tuple[Guard, ...]
    outset: Outset
    grid: np.ndarray
    tol: float
    dense: bool
    progress: Callable[[float], Any] | None
    followed: bool
    method: str
    began: float
    start_data: StartData
    project: bool

    def in_any_split(self, ways: Iterable[Way]) -> list[Way]:
        """Ways that go on in other splits of the velocities where a divisor is near zero.

        Where one has gone through the splits of the same equations, the next would fail as it did.
        """
        tried: list[Any] = []

        def attempt(way: Way, error: IntegrationError | None) -> Trajectory | None:
            try:
                if not self.outset.framed:
                    raise NearDivisor(self.vocabulary)
                return way(error)
            except NearDivisor as near:
                if any(near.vocabulary.equations is equations for equations in tried):
                    return None
                tried.append(near.vocabulary.equations)
                return replace(self, vocabulary=near.vocabulary).through_splits()

        return [partial(attempt, way) for way in ways]

    def through_splits(self) -> Trajectory:
        """On the coordinates, in one split of the velocities after another."""
        from voronec.motion.split_stepper import SplitRun  # few motions need it, nor what is rough

        own = self.vocabulary.equations
        exact = is_exact(self.method, self.tol)
        charted = None if exact else with_attitude_charts(own)
        vocabulary = self.vocabulary if charted is None else Vocabulary.of(charted)
        made = whole(vocabulary, self.outputs, self.functions)
        ground = self.outset.ground(vocabulary.equations, float(self.grid[0]))
        framed = self.outset.state if self.outset.framed and not exact else None
        given = self.start_data
        if self.outset.notes and self.outset.framed:  # what was moved is not moved elsewhere
            system = vocabulary.equations.system
            names = map(plain_name, (*system.coordinates, *system.velocities))
            moved = dict(zip(names, self.outset.state.tolist(), strict=True))
            given = replace(given, scene_initial={}, initial=moved)
        start = WideStart.of(vocabulary, ground, given, self.project, framed)
        return SplitRun(
            vocabulary, replace(ground, framed=start.framed), made.watch, made.event_functions,
            start, self.grid,
            self.method, self.tol, self.events, self.dense, self.progress, self.outset.notes,
            ceil(-log2(self.tol)) + 2 * MARGIN, self.began,
        ).trajectory()  # fmt: skip

    def in_smallest(self, _: IntegrationError | None) -> Trajectory:
        """By the method asked for, in the smallest model; near poles of angles beyond them."""
        try:
            return self._in_smallest(self.method, CHANGE)
        except NearPole:
            return first_success((self._beyond_poles, self._past_poles), float(self.grid[0]))
        except IntegrationError as error:
            own, start = self.vocabulary.equations, error.time in (None, self.grid[0])
            if start and is_exact(self.method, self.tol) and self.outset.is_at_pole(own):
                raise self._no_digits() from error
            raise

    def _no_digits(self) -> IntegrationError:
        """The error where digits are asked for at a pole of angles."""
        own = self.vocabulary.equations
        return IntegrationError(
            f"system '{own.system.name}': the motion starts at a pole of its angles, beyond which "
            f"charts lead in doubles alone; give tol={EXACT:g} or more, and not method='flint', "
            "or start elsewhere",
            self.grid[0],
            self.outset.state,
        )

    def _beyond_poles(self, _: IntegrationError | None) -> Trajectory | None:
        """In charts that are regular at the poles of Euler's angles, where these can be made."""
        own = self.vocabulary.equations
        # what is not smooth goes on in one chart alone
        charted = None if self.smallest.is_rough else with_attitude_charts(own)
        if charted is None:
            return None
        there = replace(self, vocabulary=Vocabulary.of(charted))
        made = whole(there.vocabulary, self.outputs, self.functions)
        return replace(there._integrate(made, self.method), system=own.system)

    def _past_poles(self, _: IntegrationError | None, near: Any = LAST) -> Trajectory:
        """In the own coordinates after all, where nothing better is to be had: on invariants more
        digits are lost."""
        made = whole(self.vocabulary, self.outputs, self.functions)
        return self._integrate(made, self.method, near=near)

    def otherwise(self, error: IntegrationError | None) -> Trajectory | None:
        """By another method, where the choice is ours."""
        other = other_method(error) if error is not None and self.method == "auto" else ""
        return self._in_smallest(other) if other else None

    def on_coordinates(self, _: IntegrationError | None) -> Trajectory | None:
        """By the equations on the coordinates, where the model is another: where that is singular
        they may not be, or may have charts."""
        charts = bool(self.vocabulary.equations.system.charts) and self.method != "flint"
        reduced = self.method == "auto" and self.smallest.model is not None
        if not (charts or reduced):
            return None
        return self._integrate(whole(self.vocabulary, self.outputs, self.functions), self.method)

    @cached_property
    def smallest(self) -> ProgrammedModel:
        """The smallest model."""
        return self._make_model(self.followed)

    def _make_model(self, followed: bool) -> ProgrammedModel:
        outset = self.outset
        return make_model(
            self.vocabulary, self.outputs, self.functions, outset.state, outset.steady,
            float(self.grid[0]), followed,
        )  # fmt: skip

    def _in_smallest(self, method: str, near: Any = LAST) -> Trajectory:
        made, grid = self.smallest, self.grid
        # where a grid is too coarse to tell branches of angles apart, its beginning mostly says so
        parts = (grid[: len(grid) // 50 + 2], grid) if made.watch.branches else (grid,)
        try:
            for part in parts:
                trajectory = self._integrate(made, method, part, near)
                if trajectory.interrupted:
                    break
            return trajectory
        except Untold:
            return self._integrate(self._make_model(True), method, near=near)

    def _integrate(
        self,
        made: ProgrammedModel,
        method: str,
        times: np.ndarray | None = None,
        near: Any = LAST,
    ) -> Trajectory:
        whole_way = times is None or times is self.grid
        job = _Job(
            self.vocabulary, made, self.outset, self.grid if times is None else times, self.tol,
            self.events, self.dense, self.progress if whole_way else None,
            None if is_exact(method, self.tol) else near, not whole_way,
        )  # fmt: skip
        return job.trajectory(method, self.began)


@dataclass(frozen=True)
class _Job:
    """A model to be integrated, and how; ``near`` is how near to poles of angles, if that is to be
    watched; ``in_part`` says that the grid is only the beginning of what is wanted."""

    vocabulary: Vocabulary
    made: ProgrammedModel
    outset: Outset
    grid: np.ndarray
    tol: float
    events: tuple[Guard, ...]
    dense: bool
    progress: Callable[[float], Any] | None
    near: Any = None
    in_part: bool = False

    def trajectory(self, method: str, began: float) -> Trajectory:
        """Integrate, and look at what is wanted; ``IntegrationError`` where it cannot be done."""
        made, outset, time = self.made, self.outset, float(self.grid[0])
        state, values = made.place(outset.state, outset.constants, time)
        equations = self.vocabulary.equations
        probe = made.probe(equations.system.name, values, time, outset.changing)
        guard, notes = self._pole_watch(method)
        problem, functions = self._problem(state, values, probe), made.event_functions
        if notes is not None:
            problem = notes.watch(problem, made.form, functions)
            functions = {**functions, **notes.levels}
        seen = self._under_watch(problem, functions, guard, ())
        switched = self._switching_stepper(method, *seen)
        if switched is None and made.is_rough and equations.system.charts:
            guard = None
        if guard is not None:
            guard.check(state, values, time)
        watched = self._watch_divisors(state, values)
        if switched is None or watched:
            seen = self._under_watch(problem, functions, guard, watched)
        if switched is not None and watched:
            switched = self._switching_stepper(method, *seen)
        if switched is not None and switched.corner is not None:
            corner = switched.corner
            probe = replace(
                probe, form=corner.form, program=corner.program, values=switched.values,
                inertia=None,
            )  # fmt: skip
        begun = switched is not None or not (made.model is None and equations.system.charts)
        warned = probe.check(state) if begun else ()
        if switched is not None:
            stepper, chosen = switched.stepper, switched.chosen
        else:
            stepper, chosen = self._smooth(method, *seen)
        pace = np.nan if self.in_part else pace_of(problem, float(self.grid[0]))
        looks = LookGrid.of(self.grid, pace)
        ready, busy = perf_counter(), process_time()
        run = stepper(looks.whole)
        run = replace(run, notes=(*warned, *run.notes))
        run = run if notes is None else notes.with_notes(run)
        if watched:
            run = without_guards(run, watched, self.vocabulary)
        run = run if guard is None else guard.without_poles(run)
        made.watch.require_reactions(run.held, equations.system.name)
        cost = Cost(
            **chosen, setup=ready - began + run.prepared,
            run=perf_counter() - ready - run.prepared, cpu=process_time() - busy,
            steps=run.steps, evaluations=run.evaluations, switches=run.switches, level=made.level,
        )  # fmt: skip
        trajectory, halt = self._outcome(run, values, cost, switched is None, looks)
        if halt is not None:
            raise probe.failure(state, halt, trajectory)
        return trajectory

    def _outcome(
        self, run: Run, values: Sequence[float], cost: Cost, smooth: bool, looks: LookGrid
    ) -> tuple[Trajectory, Halt | None]:
        """The motion of a run as far as it is sound, and what ended it before its end."""
        sight, told = self._sight(run, values, cost), self.outset.notes + run.notes
        own = looks.without_looks(run)
        trajectory = replace(sight.trajectory(own), notes=told)
        if run.halt is None and not run.interrupted:
            require_branches(trajectory, self.made.watch.branches, run)
        # between the instants asked for only the first equations of what is smooth are looked at
        plain = own is run or not smooth
        seen = trajectory if plain else sight.observe(run.t, run.states)
        breach, notes = self.judge(seen, run, values, smooth, looks.ends)
        if breach is not None:
            run = run.until(breach.row, breach.what)
            trajectory = replace(sight.trajectory(looks.without_looks(run)), notes=told)
        if run.halt is not None:
            return trajectory, run.halt
        whole = (*told, *notes, *_outputs_without_value(trajectory))
        return replace(trajectory, notes=whole), None

    def _problem(self, state: np.ndarray, values: Sequence[float], probe: StateProbe) -> Problem:
        """What is to be integrated, as if it were smooth and nobody watched."""
        made = self.made
        return Problem(
            made.program, state, values, self.tol, self.events, made.event_program, self.dense,
            probe.suspect(state), self.progress, self._exact, self.outset.changing,
            marked=bool(made.watch.branches),
        )  # fmt: skip

    def _switching_stepper(
        self, method: str, problem: Problem, functions: Mapping[str, Any]
    ) -> SwitchedIntegrator | None:
        """The integrator of a problem that is not smooth, watched; None where it is smooth."""
        if not problem.is_rough:
            return None
        from voronec.motion.mode_stepper import through_walls

        return through_walls(method, problem, self.grid, self.made.moving_form, functions)

    def _under_watch(
        self,
        problem: Problem,
        functions: Mapping[str, Any],
        guard: PoleGuard | None,
        watched: Sequence[Divisor],
    ) -> tuple[Problem, Mapping[str, Any]]:
        """The problem, with the poles that stop it and divisors among its events, and the
        ``functions`` of its events with those of these."""
        if guard is not None:
            problem = guard.watch(problem, functions, self.grid)
            functions = {**functions, **guard.levels}
        if watched:
            events, levels = guard_events(watched)
            functions = {**functions, **levels}
            problem = replace(
                problem,
                events=(*problem.events, *events),
                levels=quantities(self.made.form, functions),
                coarse=problem.coarse | levels.keys(),
            )
        return problem, functions

    def _sight(self, run: Run, values: Sequence[float], cost: Cost) -> _Sight:
        """How the states of a run become a trajectory."""
        made, outset, bits = self.made, self.outset, self._bits(run.states)
        if run.states.dtype == object:
            constants = outset.exactly.constants(bits) | made.constants(self._exact(bits)[1])
        else:
            constants = {**outset.constants, **made.constants(values)}
        return _Sight(
            self.vocabulary, made.watch, made.program, constants, cost, bits, outset.changing
        )

    def judge(
        self, trajectory: Trajectory, run: Run, values: Sequence[Any], smooth: bool,
        looks: Sequence[int],
    ) -> tuple[Breach | None, tuple[str, ...]]:  # fmt: skip
        """What went wrong with a run that came to its end, if anything did, and notes."""
        made, equations = self.made, self.vocabulary.equations
        watch = made.watch
        judge = Judge(
            equations, made.program, [float(x) for x in values], trajectory.cost.tolerance,
            run.steps, watch.integrals_to_follow(smooth), watch.relations, made.relations,
            self.outset.changing, watch.integrals_to_follow(smooth, jumping=True), looks, run.spans,
        )  # fmt: skip
        t, states = run.t.astype(float), run.states.astype(float)
        breach, notes = judge.breach(t, states)
        form = equations.raw.form
        own = [str(x) for x in (*form.coordinates, *form.velocities)]
        if smooth and breach is None and {*own} <= {*trajectory.series, *trajectory.names}:
            states = np.stack([trajectory[name].astype(float) for name in own], axis=-1)
            breach = judge.original(t, states, self.outset.constants)
        return breach, notes

    def _smooth(
        self, method: str, problem: Problem, functions: Mapping[str, Any]
    ) -> tuple[Stepper, dict[str, Any]]:
        """The integrator of a problem that is smooth, watched, and what ``Cost`` says of it."""
        equations, form = self.vocabulary.equations, self.made.form
        if not equations.system.charts:
            return choose_regular(method, problem, self.grid)
        return through_charts(method, problem, self.grid, equations, functions, form)

    def _watch_divisors(self, state: np.ndarray, values: Sequence[Any]) -> tuple[Divisor, ...]:
        """The divisors to watch; ``NearDivisor`` where one is near zero at the start."""
        made, outset = self.made, self.outset
        form = made.form if made.model is None else made.model.form
        ground = outset.ground(self.vocabulary.equations, float(self.grid[0]))
        found = ground.watch_divisors(form, made.below, outset.state, made.is_rough)
        if not found:
            return ()
        sizes = ground.sizes(divisor_program(form, found), found, state, values)
        if any(g.is_near(size) for g, size in zip(found, sizes, strict=True)):
            raise NearDivisor(self.vocabulary)
        return tuple(found)

    def _pole_watch(self, method: str) -> tuple[PoleGuard | None, PoleNotes | None]:
        """What stops a run at poles of coordinates, and what looks for those that it passes."""
        made, equations = self.made, self.vocabulary.equations
        charts = equations.system.charts
        if not (charts or euler_angles(equations)):
            return None, None
        alone = made.is_rough or is_exact(method, self.tol)
        charted = not alone and bool(kept_charts(equations, made.form))
        guard = self._guard(method, charted)
        outputs = made.watch.outputs
        return guard, PoleNotes.of(equations, made.program.state, outputs, charted, guard)

    def _guard(self, method: str, charted: bool) -> PoleGuard | None:
        """What watches the poles of coordinates, where the model is singular there and no chart
        leads on."""
        outset, rough, equations = self.outset, self.made.is_rough, self.vocabulary.equations
        if self.near is None:
            return None
        # what is not smooth goes on in one chart alone
        near = LAST if rough and equations.system.charts else self.near
        angles_of = euler_angles if rough else angles_without_chart
        poles = CoordinatePole.of_attitudes(angles_of(equations))
        if self.made.model is not None and not (rough or charted or is_exact(method, self.tol)):
            # the equations on the coordinates have charts
            poles += CoordinatePole.of_charts(equations)
        if not poles:
            return None
        return PoleGuard.of(
            equations, self.made, outset.state, outset.constants, float(self.grid[0]), near, poles
        )

    def _bits(self, states: np.ndarray) -> int:
        """The precision of states, at least that of the tolerance: some numbers are short."""
        if states.dtype != object:
            return float_info.mant_dig
        return max(precision(states), ceil(-log2(self.tol)) + MARGIN)

    def _exact(self, bits: int) -> tuple[np.ndarray, list[Any]]:
        """Start and parameter values as mpmath's numbers."""
        exactly, time = self.outset.exactly, float(self.grid[0])
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
    changing: Signals | None = None

    def at(self, t: np.ndarray) -> Mapping[str, Any]:
        """The constants, and at times (k,) those that change."""
        return constants_along(self.changing, self.constants, t)

    def trajectory(self, run: Run) -> Trajectory:
        """The motion of a run, its events, and, of a dense run, what lies between."""
        seen = self.observe(run.t, run.states, run.interrupted)
        crossings = {name: self.crossings(*rows) for name, rows in run.crossings.items()}
        inside = run.inside
        return replace(
            seen,
            events=MappingProxyType(crossings),
            stopped=run.stopped,
            halted=run.halt.reason if run.halt is not None else "",
            within=None if inside is None else lambda times: self.observe(times, inside(times)),
        )

    def observe(self, t: np.ndarray, states: np.ndarray, interrupted: bool = False) -> Trajectory:
        """Everything watched at some states."""
        with mpmath.workprec(self.bits):
            return make_trajectory(
                self.vocabulary, self.watch, self.program, t, states, self.at(t), self.cost,
                interrupted,
            )  # fmt: skip

    def crossings(self, t: np.ndarray, states: np.ndarray) -> Crossings:
        """The same at the passages of an event."""
        known = self.at(t)
        values = [known.get(str(p), np.nan) for p in self.program.parameters]
        series = dict.fromkeys(self.watch.outputs, t)
        if len(t):
            with mpmath.workprec(self.bits):
                series = evaluate_watch(self.watch, self.program, t, states, values)
        shown = {name: series[name] for name in self.watch.outputs}
        return Crossings.of(t, states, tuple(map(str, self.program.state)), shown)


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
    own = {*system.coordinates, *(system.frame.ambient if system.frame is not None else ())}
    return {f for e in held for f in as_expression(e).atoms(AppliedUndef)} - own


Way = Callable[[IntegrationError | None], Trajectory | None]
"""From the first error, where there was one, to a trajectory, or to None where the way is of no
use after that."""


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


def _outputs_without_value(trajectory: Trajectory) -> Iterator[str]:
    """Notes on outputs that are no finite numbers at some instants, as log(x) where x < 0."""
    for name in trajectory.outputs:
        values = trajectory[name]
        if values.dtype == object:
            sound = np.array(
                [not isinstance(x, mpmath.mpc) and bool(mpmath.isfinite(x)) for x in values]
            )
        else:
            sound = np.isfinite(values)
        if not sound.all():
            first = float(trajectory.t[np.argmin(sound)])
            yield (
                f"the output '{name}' has no finite value at {np.sum(~sound)} of {len(sound)} "
                f"instants, first at t = {first:.6g}"
            )


def other_method(error: IntegrationError) -> str:
    """The method that may go on where the one of an error could not; empty where there is none.

    A singular mass matrix stops them all: a method that does not notice would be worse.
    """
    if error.singular or error.trajectory is None:
        return ""
    # of several methods the last one failed
    used = METHODS.get(error.trajectory.cost.method.rpartition(", ")[2])
    return used.other if used is not None else ""


def first_success(ways: Iterable[Way], begin: float) -> Trajectory:
    """The trajectory of the first way that goes well; its ``cost`` says what did not.

    Where none does, the error of the one that came farthest from the time ``begin`` is raised.
    """
    errors: list[IntegrationError] = []
    for way in ways:
        try:
            found = way(errors[0] if errors else None)
            if found is not None:
                return _with_failures(found, errors)
        except IntegrationError as error:
            errors.append(error)
        except (DefinitionError, EngineLimit):
            if not errors:
                raise
    raise max(errors, key=lambda error: _reach(error, begin)) from None


def _reach(error: IntegrationError, begin: float) -> float:
    """How far a run came."""
    reach = abs(float(error.time) - begin) if error.time is not None else 0.0
    return reach if isfinite(reach) else 0.0


def _with_failures(trajectory: Trajectory, errors: list[IntegrationError]) -> Trajectory:
    """The trajectory, with what failed before it."""
    failed = [e.trajectory.cost for e in errors if e.trajectory is not None]
    if not failed:
        return trajectory
    times = [float(e.time) for e in errors if e.trajectory is not None]
    words = "; ".join(
        f"{c.method} in {c.level} fails after t = {t:.6g}"
        for c, t in zip(failed, times, strict=True)
    )
    cost = trajectory.cost
    own = cost.reason if cost.method == failed[0].method else "auto"
    return replace(trajectory, cost=replace(cost, reason=f"{own}: {words}"))
