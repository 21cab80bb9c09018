"""Carrying many motions with one compiled integrator: heyoka's lanes.

A batch integrator takes one Taylor step of every lane in little more time than a step of one
lane; it is compiled once, and its lanes are loaded again and again.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from voronec.equations.program import HoistedProgram, Program, hoist, taylor_system
from voronec.errors import DefinitionError, EngineLimit, IntegrationError
from voronec.motion.methods import (
    COMPILATION,
    METHODS,
    STAGES,
    absent,
    compiled_method,
    method_names,
)
from voronec.motion.steppers.heyoka_stepper import (
    COMPACT,
    LONG,
    heyoka,
    parameter_count,
    unit_parameters,
)
from voronec.motion.steppers.run import COLLAPSE, INFINITE, WINDOW, Headway, Problem
from voronec.motion.steppers.samples import OwnedSamples, StepSamples, series_samples
from voronec.motion.steppers.scipy_stepper import estimated_steps
from voronec.motion.steppers.series_reach import (
    MANY,
    STRIDE,
    Field,
    blind_lanes,
    field_of,
    openings,
    overlong_lanes,
)
from voronec.motion.steppers.units import CHUNK, SHORT, TurnCount, units_of_many

__all__ = [
    "COLLAPSE_RATIO",
    "SINGULAR_PLACE",
    "Lanes",
    "StepSizes",
    "StopRequest",
    "along",
    "break_error",
    "choose_lanes",
    "require_method",
]

PIECE, PART = 64, 4
"""Points of the grid in the first piece, one where states grow; later ones follow the steps that it
took, so that they are done in a quarter of those that may be taken."""
SINGULAR_PLACE = "the motion passes a place where its equations are singular, or nearly,"
COLLAPSE_RATIO = 1e-3
"""Steps are about as long as the way to the next singularity of a motion in complex time, so that
this share of the longest one tells how near it passed, and how many digits were lost."""


Look = Callable[[], bool]
"""Whether somebody asked to stop."""


class StopRequest(Exception):
    """Somebody asked to stop; what a batch had begun is not finished."""


@dataclass(eq=False)
class StepSizes:
    """The shortest and the longest step of each of some motions, and which of these took one that
    was made too long, by coefficients that vanish or by a state that outgrew ordinary size;
    ``stride`` is how long one is looked at; those that are ``left`` go on alone."""

    shortest: np.ndarray
    longest: np.ndarray
    overlong: np.ndarray
    stride: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, count: int) -> StepSizes:
        """No steps yet."""
        none = np.zeros(count, dtype=bool)
        endless, stride = np.full(count, np.inf), np.full(count, STRIDE)
        return cls(endless, np.zeros(count), none, stride, none.copy())

    def begin(self, which: Any) -> None:
        """Forget the steps of some motions: others take their places."""
        self.shortest[which], self.longest[which] = np.inf, 0.0
        self.overlong[which], self.stride[which], self.left[which] = False, STRIDE, False

    def note(self, which: Any, shortest: Any, longest: Any) -> None:
        """Further steps of one motion, or of some."""
        self.shortest[which] = np.minimum(self.shortest[which], shortest)
        self.longest[which] = np.maximum(self.longest[which], longest)

    def has_collapsed(self, which: int) -> bool:
        """Whether the steps of a motion became so short that it must have passed a place where its
        equations are singular, or nearly: a pole of coordinates, a zero of a divisor."""
        return bool(self.shortest[which] < COLLAPSE_RATIO * self.longest[which])

    def is_doubtful(self, which: int) -> bool:
        """Whether a motion is to be followed once more, alone."""
        return self.has_collapsed(which) or bool(self.overlong[which])


@dataclass(eq=False)
class Lanes:
    """heyoka's batch integrator; ``width`` motions at once, ``constants`` parameters of each, those
    of the ``raised`` program.

    ``winding`` is what was taken out of the states of each motion, and their units (n, width);
    where some start is scaled these are parameters too, behind the constants.  ``size`` is how
    many steps are taken before what has grown is taken out, and each is looked at if that must be;
    ``values`` (p, width) are the parameters of the ``plain`` program; ``results``, what heyoka says
    of each lane, and ``output``, continuous, are those of the latest steps.
    """

    integrator: Any
    width: int
    constants: int
    raised: HoistedProgram
    plain: Program
    winding: TurnCount
    steps: StepSizes
    size: int = field(init=False)
    values: np.ndarray = field(init=False)
    results: list[Any] = field(default_factory=list)
    output: Any = None
    samples: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    ahead: tuple[np.ndarray, np.ndarray] = field(init=False)

    def __post_init__(self) -> None:
        self.values = np.ones((len(self.plain.parameters), self.width))
        self.reset_size()

    def reset_size(self) -> None:
        """Nothing is known of how fast the states grow, so that a motion takes the same steps
        whatever the lanes carried before."""
        brief = self.winding.is_needed or self.has_roots
        self.size = min(SHORT, CHUNK) if brief else CHUNK

    @property
    def has_roots(self) -> bool:
        """Whether roots may have corners that no series sees, so that all steps are looked at."""
        return self.plain.has_moving_roots

    @property
    def right_side(self) -> Field:
        """The right side in the integrator's units."""
        return field_of(self.plain, [*self.values], self.winding.units)

    @cached_property
    def callback(self) -> dict[str, Any]:
        """What heyoka calls after each step: nothing, unless states may leave their units, at which
        all lanes stop."""
        return {"callback": lambda ta: self.winding.fits(ta.state)} if self.winding.scaled else {}

    def take(self) -> None:
        """Take what has grown out of the states, and measure those that left their units anew."""
        if self.winding.renew(self.integrator.state):
            self.give_units()
        self.winding.take(self.integrator.state)

    def give_units(self) -> None:
        """Tell the integrator the units."""
        places = self.integrator.pars[self.constants :]
        places[:] = self.winding.units[: len(places)]

    def again(self) -> Lanes:
        """Another integrator of the same compiled code, for another thread."""
        return replace(
            self,
            integrator=copy.deepcopy(self.integrator),
            winding=self.winding.now(),
            steps=StepSizes.of(self.width),
        )

    def keep_results(self) -> None:
        """Keep what heyoka says of the latest steps: a look back goes over them again, and leaves
        results of its own."""
        self.results = self.integrator.propagate_res

    def note_steps(self) -> None:
        """Take down the latest steps; those that were cut to end at a given time are not counted by
        heyoka."""
        self.steps.overlong[self.winding.outgrown(self.integrator.state)] = True
        lengths = np.abs([result[1:3] for result in self.results])
        self.steps.note(slice(None), lengths[:, 0], lengths[:, 1])
        taken = max(result[3] for result in self.results)
        if (self.winding.is_needed or self.has_roots) and PART * taken >= self.size:
            most = MANY if self.has_roots else CHUNK
            self.size = self.winding.pace(self.size, self.integrator.state, most)

    def first_steps(self, spans: np.ndarray) -> np.ndarray:
        """How long the next steps of all lanes may be, which go no further than ``spans``."""
        found, lengths, series = openings(self.integrator, self.right_side, spans)
        self.steps.stride[found < np.inf] = 1.0
        self.ahead = np.copysign(np.minimum(np.abs(lengths), found), spans), series
        return found

    def sample_first(self) -> tuple[np.ndarray, np.ndarray]:
        """Samples of the next step of each lane, as ``first_steps`` found it."""
        lengths, series = self.ahead
        ends = self.integrator.time + lengths
        times, states = series_samples(ends, lengths, series.transpose(2, 0, 1))
        return times, self.winding.whole(states.transpose(1, 2, 0)).transpose(2, 0, 1)

    def look_back(
        self, begin: tuple[np.ndarray, ...], state: np.ndarray, limits: np.ndarray
    ) -> np.ndarray:
        """Which lanes took steps too long since they began there, in the integrator's units, though
        none went beyond ``limits``; it is noted, too."""
        ta = self.integrator
        if not self.has_roots:
            found = overlong_lanes(ta, self.right_side, begin, state, self.steps.stride, limits)
        elif self.output is not None and np.isfinite(ta.state).all():
            found = blind_lanes(ta, self.right_side, self.output)
        else:
            found = np.zeros(self.width, dtype=bool)
        self.steps.overlong[found] = True
        return found

    def states_along(self, times: np.ndarray, longest: np.ndarray) -> np.ndarray:
        """Go on to times (k,) by steps no longer than the ``longest`` of each lane, as far as a
        chunk of steps leads: states (width, k, n)."""
        ta, each = self.integrator, np.repeat(times[:, None], self.width, axis=1)
        if self.has_roots:
            self.go_to(float(times[-1]), longest)
            states = np.full((len(times), len(ta.state), self.width), np.nan)
            if self.output is not None:
                states = np.array(self.output(each))
                late = np.abs(each - times[0]) > np.abs(self.output.times[-1] - times[0])
                late &= ~np.isfinite(ta.state).all(axis=0)
                np.moveaxis(states, 1, 2)[late] = np.nan
        else:
            found = ta.propagate_grid(
                each, max_steps=self.size, max_delta_t=longest.tolist(), **self.callback
            )
            self.keep_results()
            self.note_steps()
            states = found[1] if isinstance(found, tuple) else found
        return np.moveaxis(self.winding.whole(states), -1, 0)

    def go_to(self, end: float, longest: np.ndarray) -> None:
        """A chunk of steps towards a time, none longer than the ``longest`` of each lane."""
        self.output = self.integrator.propagate_until(
            [end] * self.width, max_steps=self.size, max_delta_t=longest.tolist(),
            c_output=self.has_roots, **self.callback,
        )[0]  # fmt: skip
        self.keep_results()
        self.note_steps()

    @property
    def states(self) -> np.ndarray:
        """Where the motions stand (width, n)."""
        return self.winding.whole(self.integrator.state).T

    def load(self, lane: Any, state: np.ndarray, values: np.ndarray, time: float) -> None:
        """Put motions (k, n) with parameters (k, p) on some lanes."""
        self.steps.begin(lane)
        self.winding.reset(lane)
        self.values[:, lane] = values.T
        times = self.integrator.time.copy()
        times[lane] = time
        self.integrator.set_time(times.tolist())
        if self.winding.scaled:
            found = units_of_many(self.plain, np.atleast_2d(state), np.atleast_2d(values))
            self.winding.measure(found.T if values.ndim > 1 else found[0], lane)
            self.give_units()
        self.integrator.state[:, lane] = state.T / self.winding.units[:, lane]
        each = np.atleast_2d(values)
        if (each == each[0]).all():
            each = each[:1]
        rows = [self.raised.values(row.tolist())[: self.constants] for row in each]
        own = np.array(rows, dtype=float).reshape(len(rows), self.constants)
        self.integrator.pars[: self.constants, lane] = own.T if values.ndim > 1 else own[0]


def lanes_of(program: Program, tol: float, states: np.ndarray, values: np.ndarray) -> Lanes:
    """A batch integrator for motions that start at ``states`` (s, n), with parameters (s, p).

    Raises ``ImportError`` without heyoka, ``EngineLimit`` for a function it does not know.
    """
    hy = heyoka()
    width = 1
    while width < min(hy.recommended_simd_size(), len(states)):
        width *= 2
    plain, raised = program, hoist(program)
    program = raised.program
    own = units_of_many(plain, states, values)
    # heyoka wants no more parameters than the equations contain
    used = [i for i, p in enumerate(program.parameters) if p in program.derivative.symbols]
    constants = max(used, default=-1) + 1
    ones = np.ones((len(program.state), width))
    winding = TurnCount.of(plain, None, ones, bool((own != 1).any()))
    system = taylor_system(program, unit_parameters(winding, constants, hy))
    integrator = hy.taylor_adaptive_batch(
        system,
        np.zeros(ones.shape),
        pars=np.ones((parameter_count([e for _, e in system], hy), width)),
        tol=winding.tolerance(tol),
        compact_mode=program.weight > COMPACT,
    )
    sizes = StepSizes.of(width)
    return Lanes(integrator, width, constants, raised, plain, winding, sizes)


def along(
    lanes: Lanes, states: np.ndarray, values: np.ndarray, grid: np.ndarray, stopped: Look
) -> tuple[np.ndarray, dict[int, IntegrationError], int, list[int], list[OwnedSamples]]:
    """Up to ``width`` motions along one grid: states (m, k, n), errors, how many steps, those whose
    steps collapsed, or were made too long, and samples of steps from instants of the grid.

    A motion that breaks down keeps its states up to there, the rest are not numbers; the others
    are run again without it.
    """
    rows = np.full((len(states), len(grid), states.shape[1]), np.nan)
    errors: dict[int, IntegrationError] = {}
    left, steps, alone = np.arange(len(states)), 0, list[int]()
    while len(left):
        # lanes without a motion of their own repeat the last one
        pick = left[np.minimum(np.arange(lanes.width), len(left) - 1)]
        lanes.load(slice(None), states[pick], values[pick], float(grid[0]))
        block = np.full((lanes.width, *rows.shape[1:]), np.nan)
        broken, taken = _pieces(lanes, block, grid, stopped)
        rows[left] = block[: len(left)]
        steps += taken
        if not broken:
            doubtful = [k for k in range(len(left)) if lanes.steps.is_doubtful(k)]
            few = len(left)
            samples = [(left, StepSamples(t[:few], x[:few], apart=True)) for t, x in lanes.samples]
            return rows, errors, steps, [*alone, *left[doubtful].tolist()], samples
        for lane, error in broken.items():
            if lane < len(left):
                if lanes.steps.left[lane]:
                    alone.append(int(pick[lane]))
                else:
                    errors[int(pick[lane])] = error
        left = np.array([i for i in left if i not in errors and i not in alone], dtype=int)
    return rows, errors, steps, alone, []


@dataclass(eq=False)
class _LanesHeadway:
    """Whether the steps of each lane lead to the end of a grid, and how many they are."""

    steps: np.ndarray
    grid: np.ndarray

    @cached_property
    def looks(self) -> list[Headway]:
        """One look at each lane."""
        return [Headway(self.grid[0], float(self.grid[-1]), LONG) for _ in self.steps]

    def errors(self, lanes: Lanes) -> dict[int, IntegrationError]:
        """The lanes whose last steps lead nowhere."""
        ta = lanes.integrator
        self.steps[:] += [result[3] for result in lanes.results]
        if self.steps.max() < WINDOW:
            return {}
        pairs = zip(self.looks, self.steps.tolist(), ta.time.tolist(), strict=True)
        why = {k: look.distance(steps, time) for k, (look, steps, time) in enumerate(pairs)}
        return {k: break_error(x, ta.time[k], lanes.states[k]) for k, x in why.items() if x}


def break_error(reason: str, time: float, state: np.ndarray) -> IntegrationError:
    """The error of a motion that cannot go on, with the last that was good."""
    return IntegrationError(f"{reason} after t = {time:.12g}", float(time), state)


def _pieces(
    lanes: Lanes, block: np.ndarray, grid: np.ndarray, stopped: Look
) -> tuple[dict[int, IntegrationError], int]:
    """Fill ``block`` (width, k, n) piece by piece of the grid; what broke, by lane, and steps."""
    hy = heyoka()
    lanes.reset_size()
    ta, at, piece, steps = lanes.integrator, 0, 1 if lanes.winding.is_needed else PIECE, 0
    headway, lanes.samples = _LanesHeadway(np.zeros(lanes.width, dtype=int), grid), []
    block[:, 0] = lanes.states
    while at < len(grid) - 1:
        if stopped():
            raise StopRequest
        if (ta.time != grid[at]).any():  # a piece may end an ulp beside the grid
            ta.set_time(float(grid[at]))
        lanes.take()
        limits = lanes.first_steps(np.full(lanes.width, grid[-1] - grid[at]))
        lanes.samples.append(lanes.sample_first())
        if limits.min() < np.inf:
            piece = 1  # steps of a piece are short where the first one must be
        end = min(at + piece, len(grid) - 1)
        begin, state = tuple(part.copy() for part in ta.dtime), ta.state.copy()
        new, results = lanes.states_along(grid[at : end + 1], limits), lanes.results
        taken, outcomes = max(r[3] for r in results), {r[0] for r in results}
        steps += sum(r[3] for r in results)
        if hy.taylor_outcome.err_nf_state in outcomes or not np.isfinite(ta.state).all():
            block[:, at : end + 1] = new
            return _broken_lanes(ta, block, grid), steps
        halfway = outcomes & {hy.taylor_outcome.step_limit, hy.taylor_outcome.cb_stop}
        if halfway and piece > 1:
            ta.set_dtime(*begin)
            ta.state[:] = state
            piece = max(1, piece // 8)
            continue
        lanes.look_back(begin, state, limits)
        if collapsed := headway.errors(lanes):
            return collapsed, steps
        if halfway:
            ends = grid[at : end + 1]
            collapsed, more = _one_interval(lanes, ends, limits, stopped, headway)
            taken, steps = taken + more, steps + more
            if collapsed:
                return collapsed, steps
            new = np.stack([block[:, at], lanes.states], axis=1)
        block[:, at : end + 1] = new
        at = end
        piece = max(1, min(4 * piece, int(piece * lanes.size / (PART * max(taken, 1)))))
    return {}, steps


def _broken_lanes(ta: Any, block: np.ndarray, grid: np.ndarray) -> dict[int, IntegrationError]:
    """The lanes whose state is no longer finite; the last good one is the last on the grid."""
    found = {}
    for lane in range(len(block)):
        if not np.isfinite(ta.state[:, lane]).all():
            good = np.isfinite(block[lane]).all(axis=1)
            last = int(np.argmin(good)) - 1 if not good.all() else len(grid) - 1
            block[lane, last + 1 :] = np.nan
            found[lane] = break_error(INFINITE, float(grid[last]), block[lane, last].copy())
    return found


def _one_interval(
    lanes: Lanes, ends: np.ndarray, longest: np.ndarray, stopped: Look, headway: _LanesHeadway
) -> tuple[dict[int, IntegrationError], int]:
    """From one point of the grid to the next, where that takes very many steps, none longer than
    the lane's ``longest`` there, which is looked for again on the way."""
    hy = heyoka()
    ta, steps = lanes.integrator, 0
    while True:
        if stopped():
            raise StopRequest
        lanes.take()
        if longest.min() < np.inf:  # steps were short where they began, and in other units
            longest = lanes.first_steps(ends[-1] - ta.time)
        before, begin, state = ta.time.copy(), tuple(x.copy() for x in ta.dtime), ta.state.copy()
        lanes.go_to(float(ends[-1]), longest)
        steps += sum(r[3] for r in lanes.results)
        if not np.isfinite(ta.state).all():
            bad = [i for i in range(lanes.width) if not np.isfinite(ta.state[:, i]).all()]
            return {i: break_error(INFINITE, before[i], lanes.states[i]) for i in bad}, steps
        lanes.look_back(begin, state, longest)
        if all(r[0] == hy.taylor_outcome.time_limit for r in lanes.results):
            return {}, steps
        stuck = np.flatnonzero((ta.time != ends[-1]) & (ta.time == before)).tolist()
        if stuck:
            return {i: break_error(COLLAPSE, ta.time[i], lanes.states[i]) for i in stuck}, steps
        if lost := headway.errors(lanes):
            return lost, steps
        if steps > MANY and (doubtful := _doubtful_lanes(lanes)):
            lanes.steps.left[doubtful] = True
            return {i: break_error(COLLAPSE, ta.time[i], lanes.states[i]) for i in doubtful}, steps


def _doubtful_lanes(lanes: Lanes) -> list[int]:
    """Lanes under way that are to be followed alone in any case: the others need not wait."""
    limit = heyoka().taylor_outcome.time_limit
    under_way = [i for i in range(lanes.width) if lanes.results[i][0] != limit]
    return [i for i in under_way if lanes.steps.is_doubtful(i)]


def require_method(method: str) -> None:
    """Refuse what does not integrate many motions."""
    if method not in method_names(many=True):
        known = ", ".join(method_names(many=True))
        raise DefinitionError(
            f"there is no method '{method}' for many motions; methods are {known}"
        )


def _compile_method(method: str, program: Program) -> str:
    """The method, after what it needs is compiled; ``DefinitionError`` where nothing compiles."""
    loop = METHODS[method].loop
    if loop is not None:
        try:
            loop(program)
        except ImportError as error:
            raise absent(method, error) from None
    return method


def _is_lasting(
    program: Program, tol: float, states: np.ndarray, values: np.ndarray, grid: np.ndarray | None
) -> bool:
    """Whether scipy would take longer than it takes to compile; sections are, of no known span."""
    if grid is None:
        return True
    steps = estimated_steps(Problem(program, states[0], values[0].tolist(), tol), grid)
    return (steps or 0) * len(states) * STAGES * (program.operations + 1) > COMPILATION


def choose_lanes(
    method: str,
    program: Program,
    tol: float,
    states: np.ndarray,
    values: np.ndarray,
    grid: np.ndarray | None = None,
) -> tuple[Lanes | None, str, str]:
    """heyoka's lanes, or None where motions go one by one; the method, and why.

    ``grid`` are the times of all motions, where they are known.
    """
    require_method(method)
    if method == "scipy" or (method != "auto" and METHODS[method].loop is not None):
        return None, _compile_method(method, program), "asked for"
    try:
        lanes = lanes_of(program, tol, states, values)
    except ImportError as error:
        refusal = absent("heyoka", error)
        if method == "heyoka":
            raise refusal from None
        used = compiled_method()
        soon = bool(used) and METHODS[used].compiles_soon
        if not (soon or (used and _is_lasting(program, tol, states, values, grid))):
            used = "scipy"
        try:
            return None, _compile_method(used, program), f"auto: {METHODS['heyoka'].absence}"
        except EngineLimit as limit:
            return None, "scipy", f"auto: {limit}"
    except EngineLimit as limit:
        if method == "heyoka":
            raise
        return None, "scipy", f"auto: {limit}"
    return lanes, "heyoka", "asked for" if method == "heyoka" else "auto: heyoka is installed"
