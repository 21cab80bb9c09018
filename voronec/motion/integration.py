"""Integrating one motion: the steps from a start and a grid to a trajectory.

A run that fails falls back before it refuses: on other methods and models, one after another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import ceil, isfinite, log2
from sys import float_info
from time import perf_counter, process_time
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import mpmath
import numpy as np

from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name
from voronec.equations.attitudes import angles_without_chart, euler_angles, with_attitude_charts
from voronec.equations.program import Program
from voronec.equations.program.python import precision
from voronec.errors import DefinitionError, EngineLimit, IntegrationError, VoronecError
from voronec.motion.atlas import NEAR as CHANGE
from voronec.motion.atlas import kept_charts
from voronec.motion.methods import HEAVY, METHODS, choose, is_exact
from voronec.motion.motion_start import FAST, InitialState, WideStart
from voronec.motion.numeric_model import ProgrammedModel, make_model, whole
from voronec.motion.observables import ObservedQuantities, evaluate_watch
from voronec.motion.request import (
    Guard,
    Namespace,
    StartData,
)
from voronec.motion.singular_coordinates import (
    LAST,
    CoordinatePole,
    NearPole,
    PoleGuard,
    PoleNotes,
)
from voronec.motion.singular_denominators import (
    NEAR,
    NearSingularDenominator,
    SingularDenominator,
    watch_levels,
    with_events,
)
from voronec.motion.state_probe import StateProbe, quantities
from voronec.motion.steppers import Integrator, Problem, Run, Signals, Termination, constants_along
from voronec.motion.tolerances import EXACT, FINEST
from voronec.motion.trajectory import Cost, Crossings, Trajectory, make_trajectory
from voronec.motion.transitions import through_charts
from voronec.motion.verify import Breach, SolutionCheck, Untold, require_branches

if TYPE_CHECKING:
    from voronec.motion.transitions import SwitchedIntegrator

MARGIN = 32
"""Bits beyond those of the tolerance with which outputs are computed from precise states."""


@dataclass(frozen=True)
class MotionRequest:
    """What is wanted of one motion, and the ways to it, as ``first_success`` takes them.

    ``followed`` says that angles are integrated from the first, not read off.
    """

    namespace: Namespace
    outputs: tuple[Any, ...]
    functions: Mapping[str, Any]
    events: tuple[Guard, ...]
    outset: InitialState
    grid: np.ndarray
    tol: float
    dense: bool
    progress: Callable[[float], Any] | None
    followed: bool
    method: str
    began: float
    start_data: StartData
    project: bool

    @property
    def time(self) -> float:
        """When the motion begins."""
        return float(self.grid[0])

    def in_any_velocities(self, ways: Iterable[Way]) -> list[Way]:
        """Ways that go on in all velocities where a divisor is near zero.

        Where one has gone on so from the same equations, the next would fail as it did.
        """
        tried: list[Any] = []

        def attempt(way: Way, error: IntegrationError | None) -> Trajectory | None:
            try:
                if not self.outset.framed:
                    raise NearSingularDenominator(self.namespace)
                return way(error)
            except NearSingularDenominator as near:
                if any(near.namespace.equations is equations for equations in tried):
                    return None
                tried.append(near.namespace.equations)
                return self.in_ambient()

        return [partial(attempt, way) for way in ways]

    def in_ambient(self) -> Trajectory:
        """In the ambient formulation."""
        from voronec.motion.ambient import ambient_formulation  # few motions need it

        home, time = self.namespace, self.time
        wanted = home.read_outputs(self.outputs)
        exprs = (*wanted.terms.values(), *self.functions.values())
        reactions = bool(wanted.reactions) or home.holds_reactions(exprs)
        formulation = ambient_formulation(home.equations, reactions)
        if formulation is None:
            raise self._no_velocities()
        namespace = formulation.namespace(home.inputs)
        exact = is_exact(self.method, self.tol)
        bits = ceil(-log2(self.tol)) + 2 * MARGIN if exact else 0
        try:
            given = formulation.start(home, self.start_data, self.outset, time, bits, self.project)
            outset = InitialState.of(namespace, given, time, False, self.outset.changing)
        except VoronecError as error:
            raise self._no_velocities() from error
        fastest = (np.abs(x.state).max(initial=1.0) for x in (outset, self.outset))
        if next(fastest) > FAST * next(fastest):
            self._require_velocities()  # a slip is refused with these
        there = replace(
            self, namespace=namespace, outset=replace(outset, notes=self.outset.notes),
            outputs=(*self.outputs, *namespace.home_names), start_data=given,
            functions={n: e.xreplace(namespace.inputs) for n, e in self.functions.items()},
        )  # fmt: skip
        ways = (there.in_smallest, there.otherwise, there.on_coordinates)
        try:
            return formulation.to_home(first_success(ways, time), wanted.names)
        except IntegrationError as error:
            if error.trajectory is None:
                raise self._no_velocities() from error
            raise formulation.failure(error, wanted.names) from error
        except NearSingularDenominator:
            raise self._no_velocities() from None

    def _require_velocities(self) -> None:
        """Refuse a start whose velocities do not tell the others."""
        home = self.namespace
        ground = self.outset.ground(home.equations, self.time)
        framed = self.outset.state if self.outset.framed else None
        WideStart.of(home, ground, self.start_data, self.project, framed)

    def _no_velocities(self) -> VoronecError:
        """The error where no velocities tell how a motion starts."""
        time, system = self.time, self.namespace.equations.system
        try:
            self._require_velocities()
        except VoronecError as error:
            return error
        place = zip(map(plain_name, system.coordinates), self.outset.state, strict=False)
        shown = ", ".join(f"{name} = {x:.6g}" for name, x in place)
        return IntegrationError(
            f"system '{system.name}': no velocities determine the motion at the initial point "
            f"({shown}): the constraints are dependent or the coordinates singular; start "
            "elsewhere",
            time,
            self.outset.state,
        )

    def by_controllers(self) -> Trajectory:
        """On the coordinates, of which controllers are told, once: a controller that remembers
        would be misled by a second try."""
        return self._whole()

    def in_smallest(self, _: IntegrationError | None) -> Trajectory:
        """By the method asked for, in the smallest model; near poles of angles beyond them."""
        try:
            return self._in_smallest(self.method, CHANGE)
        except NearPole:
            # in the own coordinates after all, where there is nothing better: on invariants more
            # digits are lost
            return first_success((self._beyond_poles, self._whole), self.time)
        except IntegrationError as error:
            equations, start = self.namespace.equations, error.time in (None, self.grid[0])
            if start and is_exact(self.method, self.tol) and self.outset.is_at_pole(equations):
                raise IntegrationError(
                    f"system '{equations.system.name}': the motion starts at a pole of its angles, "
                    f"beyond which charts lead in doubles alone; give tol={EXACT:g} or more, and "
                    "not method='flint', or start elsewhere", self.grid[0], self.outset.state,
                ) from error  # fmt: skip
            raise

    def _beyond_poles(self, _: IntegrationError | None) -> Trajectory | None:
        """In charts that are regular at the poles of Euler's angles, where these can be made."""
        equations = self.namespace.equations
        # what is not smooth goes on in one chart alone
        charted = None if self.smallest.is_rough else with_attitude_charts(equations)
        if charted is None:
            return None
        there = replace(self, namespace=Namespace.of(charted))
        return replace(there._whole(), system=equations.system)

    def _whole(self, _: IntegrationError | None = None) -> Trajectory:
        """By the equations as they are, on the coordinates."""
        made = whole(self.namespace, self.outputs, self.functions)
        return self._integrate(made, self.method)

    def otherwise(self, error: IntegrationError | None) -> Trajectory | None:
        """By another method, where the choice is ours."""
        other = other_method(error) if error is not None and self.method == "auto" else ""
        return self._in_smallest(other) if other else None

    def on_coordinates(self, _: IntegrationError | None) -> Trajectory | None:
        """By the equations on the coordinates, where the model is another: where that is singular
        they may not be, or may have charts."""
        charts = bool(self.namespace.equations.system.charts) and self.method != "flint"
        reduced = self.method == "auto" and self.smallest.model is not None
        return self._whole() if charts or reduced else None

    @cached_property
    def smallest(self) -> ProgrammedModel:
        """The smallest model."""
        return self._make_model(self.followed)

    def _make_model(self, followed: bool) -> ProgrammedModel:
        outset = self.outset
        return make_model(
            self.namespace, self.outputs, self.functions, outset.state, outset.steady,
            self.time, followed,
        )  # fmt: skip

    def _in_smallest(self, method: str, near: Any = LAST) -> Trajectory:
        made, begin = self.smallest, self.grid[: len(self.grid) // 50 + 2]
        # where a grid is too coarse to tell branches of angles apart, its beginning mostly says so
        parts = (begin, None) if made.watch.branches else (None,)
        try:
            for part in parts:
                trajectory = self._integrate(made, method, part, near)
                if trajectory.interrupted:
                    break
            return trajectory
        except Untold:
            return self._integrate(self._make_model(True), method, near=near)

    def _integrate(
        self, made: ProgrammedModel, method: str, times: np.ndarray | None = None, near: Any = LAST
    ) -> Trajectory:
        asked = self if times is None else replace(self, grid=times, progress=None)
        if self.namespace.home is not None:  # of what is heavy, compiled loops take none finer
            finest = FINEST if made.program.weight > HEAVY else EXACT
            asked = replace(asked, tol=min(self.tol, max(NEAR * self.tol, finest)))
        return _Job(asked, made, None if is_exact(method, self.tol) else near).trajectory(method)


@dataclass(frozen=True)
class _Job:
    """A model to be integrated, and what is ``asked``; ``near`` is how near to poles of angles, if
    that is to be watched."""

    asked: MotionRequest
    made: ProgrammedModel
    near: Any = None

    def trajectory(self, method: str) -> Trajectory:
        """Integrate, and look at what is wanted; ``IntegrationError`` where it cannot be done."""
        made, outset, time = self.made, self.asked.outset, self.asked.time
        state, values = made.place(outset.state, outset.constants, time)
        equations = self.asked.namespace.equations
        probe = made.probe(equations.system.name, values, time, outset.changing)
        plain, poles = self._problem(state, values, probe), self._poles(method)
        controlled = plain.measured is not None
        seen = poles.watch(plain, self)
        switched = self._switching_stepper(method, *seen)
        if switched is None and made.is_rough and equations.system.charts:
            poles = replace(poles, guard=None)
            seen = poles.watch(plain, self)
        if poles.guard is not None:
            poles.guard.check(state, values, time)
        watched = () if controlled else self._watch_divisors(state, values)
        levels = watch_levels(watched)
        if levels:
            functions = {**seen[1], **levels}
            seen = with_events(seen[0], made.form, seen[1], levels, stop=True), functions
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
        if self.asked.namespace.home is not None:
            warned = ()  # impulses of reactions have no inertia, or negative one
        solver, chosen = (
            self._smooth(method, *seen) if switched is None else (switched.solver, switched.chosen)
        )
        ready, busy = perf_counter(), process_time()
        run = solver(self.asked.grid)
        run = replace(run, notes=(*warned, *run.notes)) if warned else run
        run = run if poles.notes is None else poles.notes.with_notes(run)
        if run.stopped in levels:
            raise NearSingularDenominator(self.asked.namespace)
        run = run.without({*levels})
        run = run if poles.guard is None else poles.guard.without_poles(run)
        made.watch.require_reactions(run.held, equations.system.name)
        cost = Cost(
            **chosen, setup=ready - self.asked.began + run.prepared,
            run=perf_counter() - ready - run.prepared, cpu=process_time() - busy,
            steps=run.steps, evaluations=run.evaluations, switches=run.switches,
            formulation=made.formulation,
        )  # fmt: skip
        trajectory, halt = self._outcome(run, values, cost, switched is None)
        if halt is not None:
            error = probe.failure(state, halt, trajectory)
            if self.asked.namespace.home is not None:
                sight = self._sight(run, values, cost)
                last = sight.observe(np.array([halt.time]), np.array(halt.state)[None])
                error.state = np.array([last[name][0] for name in self.asked.namespace.home_names])
            raise error
        return trajectory

    def _outcome(
        self, run: Run, values: Sequence[float], cost: Cost, smooth: bool
    ) -> tuple[Trajectory, Termination | None]:
        """The motion of a run as far as it is sound, and what ended it before its end."""
        sight, told = self._sight(run, values, cost), self.asked.outset.notes + run.notes
        trajectory = sight.trajectory(run, told)
        if run.halt is None and not run.interrupted:
            require_branches(trajectory, self.made.watch.branches, run)
        breach, notes = self.check(sight, run, values, smooth)
        if breach is not None:
            run = run.until(breach.row, breach.what, breach.last)
            trajectory = sight.trajectory(run, told)
        if run.halt is not None:
            return trajectory, run.halt
        more = (*notes, *_outputs_without_value(trajectory))
        return (replace(trajectory, notes=(*told, *more)) if more else trajectory), None

    def _problem(self, state: np.ndarray, values: Sequence[float], probe: StateProbe) -> Problem:
        """What is to be integrated, as if it were smooth and nobody watched."""
        asked, made = self.asked, self.made
        return Problem(
            made.program, state, values, asked.tol, asked.events, made.event_program, asked.dense,
            probe.suspect(state), asked.progress, self._exact, asked.outset.changing,
            marked=bool(made.watch.branches), measured=self._velocities_besides(),
            conditions=self.asked.namespace.conditions,
        )  # fmt: skip

    def _velocities_besides(self) -> Program | None:
        """What controllers are told beside the states: velocities that follow from these; None
        where there are no controllers."""
        changing, namespace = self.asked.outset.changing, self.asked.namespace
        if changing is None or not changing.feedbacks:
            return None
        states = {*map(str, self.made.program.state)}
        names = [name for name in namespace.rate_names if name not in states]
        told = {name: namespace.inward(namespace.known[name]) for name in names}
        return quantities(self.made.form, told)

    def _switching_stepper(
        self, method: str, problem: Problem, functions: Mapping[str, Any]
    ) -> SwitchedIntegrator | None:
        """The integrator of a problem that is not smooth, watched; None where it is smooth."""
        if not problem.is_rough:
            return None
        changing = problem.changing
        followed = [f for f in changing.feedbacks if not f.is_sampled] if changing else ()
        if followed:
            raise EngineLimit(
                f"the input '{followed[0].name}' is a function of the state, in equations that are "
                "not smooth; give Sampled(controller, period)"
            )
        from voronec.motion.transitions import through_switching_surfaces

        return through_switching_surfaces(
            method, problem, self.asked.grid, self.made.moving_form, functions
        )

    def _sight(self, run: Run, values: Sequence[float], cost: Cost) -> _Sight:
        """How the states of a run become a trajectory."""
        made, outset, bits = self.made, self.asked.outset, float_info.mant_dig
        constants = {**outset.constants, **made.constants(values)}
        if run.states.dtype == object:  # at least as the tolerance wants: some numbers are short
            bits = max(precision(run.states), ceil(-log2(self.asked.tol)) + MARGIN)
            constants = outset.exactly.constants(bits) | made.constants(self._exact(bits)[1])
        return _Sight(
            self.asked.namespace, made.watch, made.program, constants, cost, bits, outset.changing
        )

    def check(
        self, sight: _Sight, run: Run, values: Sequence[Any], smooth: bool
    ) -> tuple[Breach | None, tuple[str, ...]]:
        """What went wrong with a run that came to its end, if anything did, and notes."""
        made, equations = self.made, self.asked.namespace.equations
        watch, form = made.watch, equations.raw.form
        check = SolutionCheck(
            equations, made.program, [np.float64(x) for x in values], sight.cost.tolerance,
            run.steps, watch.integrals_to_follow(smooth), {**watch.relations, **watch.vanishing},
            self.asked.outset.changing, watch.integrals_to_follow(smooth, jumping=True),
        )  # fmt: skip
        variables = [str(x) for x in (*form.coordinates, *form.velocities)]
        known = smooth and {*variables} <= {*watch.known, *map(str, made.program.state)}
        at_home = partial(self._at_home, variables, check) if known else None
        t, states = run.t.astype(float), run.states.astype(float)
        return check.breach(t, states, run.samples, at_home, self.asked.outset.constants)

    def _at_home(
        self, names: Sequence[str], check: SolutionCheck, t: np.ndarray, states: np.ndarray
    ) -> np.ndarray:
        """Coordinates and velocities by name (k, m) at states (k, n)."""
        series = dict(zip(map(str, self.made.program.state), states.T, strict=True))
        if not {*names} <= series.keys():
            series |= evaluate_watch(self.made.watch, self.made.program, t, states, check.at(t))
        return np.stack([series[name] for name in names], axis=-1)

    def _smooth(
        self, method: str, problem: Problem, functions: Mapping[str, Any]
    ) -> tuple[Integrator, dict[str, Any]]:
        """The integrator of a problem that is smooth, watched, and what ``Cost`` says of it."""
        equations, form = self.asked.namespace.equations, self.made.form
        if not equations.system.charts or problem.measured is not None:
            return choose(method, problem, self.asked.grid)
        return through_charts(method, problem, self.asked.grid, equations, functions, form)

    def _watch_divisors(
        self, state: np.ndarray, values: Sequence[Any]
    ) -> tuple[SingularDenominator, ...]:
        """The divisors to watch; ``NearSingularDenominator`` where one is near zero at the
        start."""
        made, outset = self.made, self.asked.outset
        form = made.form if made.model is None else made.model.form
        ground = outset.ground(self.asked.namespace.equations, self.asked.time)

        def find() -> list[SingularDenominator]:
            return ground.watch_divisors(form, made.below, outset.state, made.is_rough)

        watched = find() if outset.changing is not None else made.memo.last(
            "divisors", outset.constants_key, find
        )  # fmt: skip
        if ground.is_near_zero(form, watched, state, values):
            raise NearSingularDenominator(self.asked.namespace)
        return tuple(watched)

    def _poles(self, method: str) -> _Poles:
        """What watches the poles of coordinates; kept with the model for the constants."""
        outset, exact = self.asked.outset, is_exact(method, self.asked.tol)
        if outset.changing is not None:
            alone = bool(outset.changing.feedbacks)
            return _Poles(None, None) if alone else self._pole_watch(method)
        key = outset.constants_key, self.asked.time, exact, self.near
        return self.made.memo.last("poles", key, lambda: self._pole_watch(method))

    def _pole_watch(self, method: str) -> _Poles:
        made, equations = self.made, self.asked.namespace.equations
        charts = equations.system.charts
        if not (charts or euler_angles(equations)):
            return _Poles(None, None)
        alone = made.is_rough or is_exact(method, self.asked.tol)
        charted = not alone and bool(kept_charts(equations, made.form))
        guard = self._guard(alone, charted)
        outputs = made.watch.outputs
        return _Poles(guard, PoleNotes.of(equations, made.program.state, outputs, charted, guard))

    def _guard(self, alone: bool, charted: bool) -> PoleGuard | None:
        """What watches the poles of coordinates, where the model is singular there and no chart
        leads on."""
        asked, rough = self.asked, self.made.is_rough
        outset, equations = asked.outset, asked.namespace.equations
        if self.near is None:
            return None
        # what is not smooth goes on in one chart alone
        near = LAST if rough and equations.system.charts else self.near
        angles_of = euler_angles if rough else angles_without_chart
        poles = CoordinatePole.of_attitudes(angles_of(equations))
        if self.made.model is not None and not (alone or charted):
            # the equations on the coordinates have charts
            poles += CoordinatePole.of_charts(equations)
        if not poles:
            return None
        return PoleGuard.of(
            equations, self.made, outset.state, outset.constants, asked.time, near, poles
        )

    def _exact(self, bits: int) -> tuple[np.ndarray, list[Any]]:
        """Start and parameter values as mpmath's numbers."""
        exactly, time = self.asked.outset.exactly, self.asked.time
        with mpmath.workprec(bits):
            state, _ = exactly.problem(bits)
            return self.made.place(state, exactly.constants(bits), time)


@dataclass(frozen=True)
class _Poles:
    """What stops a run at poles of its coordinates, and what looks for those that it passes."""

    guard: PoleGuard | None
    notes: PoleNotes | None
    memo: Memo = field(default_factory=Memo, init=False, repr=False, compare=False)

    def watch(self, problem: Problem, job: _Job) -> tuple[Problem, Mapping[str, Any]]:
        """The problem, with the poles among its events, and the functions of these by name."""

        def make() -> tuple[dict[str, Any], Mapping[str, Any]]:
            guarded, functions = problem, job.made.event_functions
            if self.notes is not None:
                guarded = self.notes.watch(guarded, job.made.form, functions)
                functions = {**functions, **self.notes.levels}
            if self.guard is not None:
                guarded = self.guard.watch(guarded, functions, job.asked.grid)
                functions = {**functions, **self.guard.levels}
            return {n: getattr(guarded, n) for n in ("events", "levels", "coarse")}, functions

        if self.guard is None and self.notes is None:
            return problem, job.made.event_functions
        backwards = bool(job.asked.grid[-1] < job.asked.grid[0])
        changed, functions = self.memo.last("watched", (problem.events, backwards), make)
        return replace(problem, **changed), functions


@dataclass(frozen=True)
class _Sight:
    """How states become a trajectory."""

    namespace: Namespace
    watch: ObservedQuantities
    program: Program
    constants: Mapping[str, Any]
    cost: Cost
    bits: int
    changing: Signals | None = None

    def at(self, t: np.ndarray) -> Mapping[str, Any]:
        """The constants, and at times (k,) those that change."""
        return constants_along(self.changing, self.constants, t)

    def trajectory(self, run: Run, notes: tuple[str, ...]) -> Trajectory:
        """The motion of a run, its events, and, of a dense run, what lies between."""
        crossings = {name: self.crossings(*rows) for name, rows in run.crossings.items()}
        inside = run.inside
        return self.observe(
            run.t, run.states, notes=notes, interrupted=run.interrupted,
            events=MappingProxyType(crossings), stopped=run.stopped,
            halted=run.halt.reason if run.halt is not None else "",
            within=None if inside is None else lambda times: self.observe(times, inside(times)),
        )  # fmt: skip

    def observe(self, t: np.ndarray, states: np.ndarray, **ends: Any) -> Trajectory:
        """Everything watched at some states; ``ends`` are further fields of the trajectory."""
        with mpmath.workprec(self.bits):
            return make_trajectory(
                self.namespace, self.watch, self.program, t, states, self.at(t), self.cost, **ends
            )

    def crossings(self, t: np.ndarray, states: np.ndarray) -> Crossings:
        """What is watched at the passages of an event."""
        known = self.at(t)
        values = [known.get(str(p), np.nan) for p in self.program.parameters]
        series = dict.fromkeys(self.watch.outputs, t)
        if len(t):
            with mpmath.workprec(self.bits):
                series = evaluate_watch(self.watch, self.program, t, states, values)
        shown = {name: series[name] for name in self.watch.outputs}
        return Crossings.of(t, states, tuple(map(str, self.program.state)), shown)


Way = Callable[[IntegrationError | None], Trajectory | None]
"""From the first error, where there was one, to a trajectory, or to None where the way is of no
use after that."""


def _outputs_without_value(trajectory: Trajectory) -> Iterator[str]:
    """Notes on outputs that are no finite numbers at some instants, as log(x) where x < 0."""
    for name in trajectory.outputs:
        values = trajectory[name]
        if values.dtype != object and isfinite(values.sum()):  # then all of them are
            continue
        real = (not isinstance(x, mpmath.mpc) and bool(mpmath.isfinite(x)) for x in values)
        sound = np.fromiter(real, bool, len(values))
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
    used = METHODS.get(error.trajectory.cost.method)
    return used.other if used is not None else ""


def first_success(ways: Iterable[Way], begin: float) -> Trajectory:
    """The trajectory of the first way that goes well; its ``cost`` says what did not.

    Where none does, the error of the one that came farthest from the time ``begin`` is raised.
    """
    errors: list[IntegrationError] = []
    for way in ways:
        try:
            trajectory = way(errors[0] if errors else None)
            if trajectory is not None:
                return _with_failures(trajectory, errors)
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
    failed = [(e.trajectory.cost, float(e.time)) for e in errors if e.trajectory is not None]
    if not failed:
        return trajectory
    words = "; ".join(f"{c.method} in {c.formulation} fails after t = {t:.6g}" for c, t in failed)
    cost = trajectory.cost
    reason = cost.reason if cost.method == failed[0][0].method else "auto"
    return replace(trajectory, cost=replace(cost, reason=f"{reason}: {words}"))
