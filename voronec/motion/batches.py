"""Carrying many motions with one compiled integrator: heyoka's lanes.

A batch integrator takes one Taylor step of every lane in little more time than a step of one
lane; it is compiled once, and its lanes are loaded again and again.
"""

from __future__ import annotations

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
from voronec.motion.steppers import (
    CHUNK,
    COLLAPSE,
    COMPACT,
    INFINITE,
    LONG,
    MANY,
    PARTS,
    SHORT,
    STRIDE,
    WINDOW,
    Field,
    LongSteps,
    OwnedSamples,
    Place,
    Problem,
    StallDetector,
    StepSamples,
    TurnCount,
    WideBatch,
    blind_lanes,
    estimated_steps,
    field_of,
    heyoka,
    long_steps,
    parameter_count,
    reach_of_series,
    series_samples,
    uneven_steps,
    unit_parameters,
    units_of_many,
)

REGISTERS = 2
"""A core is busier with two registers of lanes, whose instructions need not wait for one another;
with more it is no faster, and compiling takes thrice as long."""
LOADS = 128
"""So many loads of the compiled lanes go side by side: what is looked at in Python is looked at in
all of them at once."""
PIECE, PART = 64, 2
"""Points of the grid in the first piece, one where states grow; later ones follow the steps that it
took, so that they are done in half of those that may be taken."""
SINGULAR_PLACE = "the motion passes a place where its equations are singular, or nearly,"
COLLAPSE_RATIO = 1e-3
"""Steps are about as long as the way to the next singularity of a motion in complex time, so that
this share of the longest one tells how near it passed, and how many digits were lost."""


Look = Callable[[], bool]
"""Whether somebody asked to stop."""


LookAtChunk = Callable[[Place], dict[int, IntegrationError]]
"""The motions that cannot go on, after a chunk of steps from where they stood."""


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

    @property
    def has_collapsed(self) -> np.ndarray:
        """Of which motions steps became so short that it must have passed a place where its
        equations are singular, or nearly: a pole of coordinates, a zero of a divisor."""
        return np.asarray(self.shortest < COLLAPSE_RATIO * self.longest)

    @property
    def doubtful(self) -> np.ndarray:
        """Which motions are to be followed once more, alone."""
        return self.has_collapsed | self.overlong


@dataclass(eq=False)
class Lanes:
    """heyoka's batch integrator, made wider: ``constants`` parameters of each motion, those of the
    ``raised`` program.

    ``winding`` is what was taken out of the states of each motion, and their units (n, width);
    where some start is scaled these are parameters too, behind the constants.  ``size`` is how
    many steps are taken before what has grown is taken out, and each is looked at if that must be;
    ``values`` (p, width) are the parameters of the ``plain`` program; ``output``, continuous, is
    that of the latest steps.
    """

    integrator: WideBatch
    constants: int
    raised: HoistedProgram
    plain: Program
    winding: TurnCount
    steps: StepSizes
    size: int = field(init=False)
    values: np.ndarray = field(init=False)
    output: Any = None
    samples: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)
    ahead: tuple[np.ndarray, np.ndarray] = field(init=False)

    def __post_init__(self) -> None:
        self.values = np.ones((len(self.plain.parameters), self.width))
        self.reset_size()

    @property
    def width(self) -> int:
        """How many motions there are."""
        return self.integrator.width

    @property
    def most(self) -> int:
        """So many motions may be carried: where each step is looked at, those of one load."""
        single = self.winding.scaled or self.has_roots
        return int(self.integrator.batch.batch_size) * (1 if single else LOADS)

    def reset_size(self) -> None:
        """Nothing is known of how fast the states grow, so that a motion takes the same steps
        whatever the lanes carried before."""
        brief = self.winding.is_needed or self.has_roots
        self.size = min(SHORT, CHUNK) if brief else CHUNK

    @property
    def has_roots(self) -> bool:
        """Whether roots may have corners that no series sees, so that all steps are looked at."""
        return self.plain.has_moving_roots

    def right_side(self, which: Any = slice(None)) -> Field:
        """The right side of some motions in the integrator's units."""
        return field_of(self.plain, [*self.values[:, which]], self.winding.units[:, which])

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

    def with_width(self, count: int) -> Lanes:
        """Lanes for so many motions, or a few more to fill the lanes."""
        batch = self.integrator.batch
        width = -(-count // batch.batch_size) * batch.batch_size
        units = np.ones((len(self.plain.state), width))
        return replace(
            self,
            integrator=WideBatch.of(batch, width),
            winding=replace(self.winding, units=units, looks=0),
            steps=StepSizes.of(width),
            output=None,
        )

    def note_steps(self) -> None:
        """Take down the latest steps; those that were cut to end at a given time are not counted by
        heyoka."""
        ta = self.integrator
        self.steps.overlong[self.winding.outgrown(ta.state)] = True
        self.steps.note(slice(None), ta.latest.shortest, ta.latest.longest)
        taken = ta.latest.taken.max(initial=0)
        if (self.winding.is_needed or self.has_roots) and PART * taken >= self.size:
            most = MANY if self.has_roots else CHUNK
            self.size = self.winding.pace(self.size, ta.state[:, ta.alive], most)

    def first_steps(self, spans: np.ndarray) -> np.ndarray:
        """How long the next steps of all motions may be, which go no further than ``spans``;
        infinite where they are as long as they ought to be."""
        ta, limits = self.integrator, np.full(self.width, np.inf)
        taken, series = ta.first_steps(spans)
        whole, tol = np.abs(taken) >= np.abs(spans), ta.batch.tol
        for parts, chosen in ((1, ta.alive & ~whole), (PARTS, ta.alive & whole)):
            if chosen.any():
                right, rows = self.right_side(chosen), series[:, :, chosen]
                limits[chosen] = reach_of_series(
                    right, rows, taken[chosen], ta.high[chosen], parts, tol
                )
        self.steps.stride[limits < np.inf] = 1.0
        ahead = np.copysign(np.minimum(np.abs(taken), limits), spans)
        self.ahead = ahead, series
        return limits

    def sample_first(self) -> tuple[np.ndarray, np.ndarray]:
        """Samples of the next step of each motion, as ``first_steps`` found it."""
        lengths, series = self.ahead
        ends = self.integrator.high + lengths
        times, states = series_samples(ends, lengths, series.transpose(2, 0, 1))
        return times, self.winding.whole(states.transpose(1, 2, 0)).transpose(2, 0, 1)

    def look_back(self, begin: Place, limits: np.ndarray) -> np.ndarray:
        """Which motions took steps too long since they began there, though none went beyond
        ``limits``; it is noted, too."""
        ta, overlong = self.integrator, np.zeros(self.width, dtype=bool)
        if self.has_roots:
            if self.output is not None and ta.alive.all():
                overlong = blind_lanes(ta.batch, self.right_side(), self.output)
        else:
            span, latest = np.abs(ta.high - begin[0]), ta.latest
            usual, suspect = uneven_steps(span, latest, self.steps.stride)
            suspect &= ta.alive
            if suspect.any():
                there, every = ta.place, np.arange(self.width)
                ta.return_to(begin)
                steps = list[LongSteps]()
                for load in ta.loads(suspect):
                    most = int(latest.taken[load].max())
                    steps += long_steps(
                        ta.batch, every[load], there[0][load], limits[load], most, usual[load]
                    )
                ta.return_to(there)
                if steps:
                    too_long = LongSteps.join(steps).overlong(self.right_side, ta.batch.tol)
                    overlong[too_long] = True
        self.steps.overlong[overlong] = True
        return overlong

    def states_along(self, times: np.ndarray, longest: np.ndarray) -> np.ndarray:
        """Go on to times (k,) by steps no longer than the ``longest`` of each motion, as far as a
        chunk of steps leads: states (width, k, n)."""
        ta = self.integrator
        if self.has_roots:
            self.go_to(np.full(self.width, times[-1]), longest, True)
            states = np.full((len(times), *ta.state.shape), np.nan)
            if self.output is not None:
                each = np.repeat(times[:, None], self.width, axis=1)
                states = np.array(self.output(each))
                late = np.abs(each - times[0]) > np.abs(self.output.times[-1] - times[0])
                late &= ~ta.alive
                np.moveaxis(states, 1, 2)[late] = np.nan
        elif len(times) == 2:  # no instant lies between, where states would have to be read off
            begin = ta.state.copy()
            self.go_to(np.full(self.width, times[-1]), longest)
            ends = ((ta.alive, begin), (ta.latest.end, ta.state))
            states = np.stack([np.where(there, state, np.nan) for there, state in ends])
        else:
            states = ta.along_grid(times, longest, max_steps=self.size, **self.callback)
            self.note_steps()
        return np.moveaxis(self.winding.whole(states), -1, 0)

    def go_to(
        self, ends: np.ndarray, longest: np.ndarray, output: bool = False, most: int = CHUNK
    ) -> None:
        """A chunk of steps, so many at ``most``, towards times (width,), none longer than the
        ``longest`` of each motion; with continuous ``output``, which there is of one load."""
        self.output = None  # its memory is used again
        self.output = self.integrator.go_to(
            ends, longest, output, max_steps=min(self.size, most), **self.callback
        )
        self.note_steps()

    @property
    def states(self) -> np.ndarray:
        """Where the motions stand (width, n)."""
        return self.winding.whole(self.integrator.state).T

    def load(self, which: Any, states: np.ndarray, values: np.ndarray, time: float) -> None:
        """Put motions (k, n) with parameters (k, p) in some places."""
        self.steps.begin(which)
        self.winding.reset(which)
        self.values[:, which] = values.T
        self.integrator.set_time(time, which)
        if self.winding.scaled:
            self.winding.measure(units_of_many(self.plain, states, values).T, which)
            self.give_units()
        self.integrator.state[:, which] = states.T / self.winding.units[:, which]
        self.integrator.pars[: self.constants, which] = self._constants(values).T

    def _constants(self, values: np.ndarray) -> np.ndarray:
        """The constants (k, c) of the raised program, from the parameters (k, p)."""
        each = values[:1] if (values == values[:1]).all() else values
        rows = [self.raised.values(row.tolist())[: self.constants] for row in each]
        return np.array(rows, dtype=float).reshape(len(rows), self.constants)


def lanes_of(program: Program, tol: float, states: np.ndarray, values: np.ndarray) -> Lanes:
    """A batch integrator for motions that start at ``states`` (s, n), with parameters (s, p).

    Raises ``ImportError`` without heyoka, ``EngineLimit`` for a function it does not know.
    """
    hy = heyoka()
    width = 1
    while width < min(REGISTERS * hy.recommended_simd_size(), len(states)):
        width *= 2
    plain, raised = program, hoist(program)
    program = raised.program
    scaled = any(
        (units_of_many(plain, states[i : i + MANY], values[i : i + MANY]) != 1).any()
        for i in range(0, len(states), MANY)
    )
    # heyoka wants no more parameters than the equations contain
    used = [i for i, p in enumerate(program.parameters) if p in program.derivative.symbols]
    constants = max(used, default=-1) + 1
    ones = np.ones((len(program.state), width))
    winding = TurnCount.of(plain, None, ones, scaled)
    system = taylor_system(program, unit_parameters(winding, constants, hy))
    batch = hy.taylor_adaptive_batch(
        system,
        np.zeros(ones.shape),
        pars=np.ones((parameter_count([e for _, e in system], hy), width)),
        tol=winding.tolerance(tol),
        compact_mode=program.weight > COMPACT,
    )
    wide = WideBatch.of(batch, width)
    return Lanes(wide, constants, raised, plain, winding, StepSizes.of(width))


def along(
    lanes: Lanes, states: np.ndarray, values: np.ndarray, grid: np.ndarray, stopped: Look
) -> tuple[np.ndarray, dict[int, IntegrationError], int, list[int], list[OwnedSamples]]:
    """Motions along one grid: states (m, k, n), errors, how many steps, those whose steps
    collapsed, or were made too long, and samples of steps from instants of the grid.

    A motion that breaks down keeps its states up to there, the rest are not numbers.
    """
    count, lanes = len(states), lanes.with_width(len(states))
    # places without a motion of their own repeat the last one
    pick = np.minimum(np.arange(lanes.width), count - 1)
    lanes.load(slice(None), states[pick], values[pick], float(grid[0]))
    rows = np.full((lanes.width, len(grid), states.shape[1]), np.nan)
    errors, steps = _pieces(lanes, rows, grid, stopped)
    left = {i: error for i, error in errors.items() if i < count and not lanes.steps.left[i]}
    doubtful = lanes.steps.doubtful | lanes.steps.left
    alone = [i for i in np.flatnonzero(doubtful[:count]).tolist() if i not in left]
    kept = np.array([i for i in range(count) if i not in errors], dtype=int)
    samples = [(kept, StepSamples(t[kept], x[kept], apart=True)) for t, x in lanes.samples]
    return rows[:count], left, steps, alone, samples


@dataclass(eq=False)
class _LanesStallDetector:
    """Whether the steps of each motion lead to the end of a grid, and how many they are."""

    steps: np.ndarray
    grid: np.ndarray

    @cached_property
    def looks(self) -> list[StallDetector]:
        """One look at each motion."""
        return [StallDetector(self.grid[0], float(self.grid[-1]), LONG) for _ in self.steps]

    def errors(self, lanes: Lanes) -> dict[int, IntegrationError]:
        """The motions whose last steps lead nowhere."""
        ta = lanes.integrator
        self.steps[:] += ta.latest.taken
        if self.steps.max() < WINDOW:
            return {}
        failures = {}
        for i in np.flatnonzero(ta.alive).tolist():
            why = self.looks[i].distance(int(self.steps[i]), float(ta.high[i]))
            if why:
                failures[i] = break_error(why, ta.high[i], lanes.states[i])
        return failures


def break_error(reason: str, time: float, state: np.ndarray) -> IntegrationError:
    """The error of a motion that cannot go on, with the last that was good."""
    return IntegrationError(f"{reason} after t = {time:.12g}", float(time), state)


def _pieces(
    lanes: Lanes, rows: np.ndarray, grid: np.ndarray, stopped: Look
) -> tuple[dict[int, IntegrationError], int]:
    """Fill ``rows`` (width, k, n) piece by piece of the grid; what broke, by motion, and steps."""
    lanes.reset_size()
    ta, at, piece, steps = lanes.integrator, 0, 1 if lanes.winding.is_needed else PIECE, 0
    stall, lanes.samples = _LanesStallDetector(np.zeros(lanes.width, dtype=int), grid), []
    errors, limits, unseen = dict[int, IntegrationError](), np.full(lanes.width, np.inf), SHORT
    rows[:, 0] = lanes.states
    while at < len(grid) - 1 and (alive := ta.alive).any():
        if stopped():
            raise StopRequest
        ta.set_time(float(grid[at]))  # a piece may end an ulp beside the grid
        lanes.take()
        if unseen >= SHORT or lanes.has_roots or limits.min() < np.inf:
            limits, unseen = lanes.first_steps(np.full(lanes.width, grid[-1] - grid[at])), 0
            lanes.samples.append(lanes.sample_first())
        if limits.min() < np.inf:
            piece = 1  # steps of a piece are short where the first one must be
        end = min(at + piece, len(grid) - 1)
        begin, new = ta.place, lanes.states_along(grid[at : end + 1], limits)
        taken, halfway = int(ta.latest.taken.max()), ta.alive & ~ta.latest.end
        steps += int(ta.latest.taken.sum())
        if halfway.any() and piece > 1:
            ta.return_to(begin)
            piece = max(1, piece // 8)
            continue
        chosen = slice(None) if alive.all() else alive
        rows[chosen, at : end + 1] = new[chosen]
        failures = {
            i: _last_good(rows[i], grid) for i in np.flatnonzero(alive & ~ta.alive).tolist()
        }
        lanes.look_back(begin, limits)
        failures |= stall.errors(lanes)
        ta.state[:, [*failures]] = np.nan
        if halfway.any():
            ends = grid[at : end + 1]
            there = np.full(lanes.width, ends[-1])
            late, more = carry(lanes, there, limits, stopped, lambda _: stall.errors(lanes))
            failures, taken, steps = failures | late, taken + more, steps + more
            rows[ta.alive, end] = lanes.states[ta.alive]
        errors |= failures
        at, unseen = end, unseen + taken
        piece = max(1, min(4 * piece, int(piece * lanes.size / (PART * max(taken, 1)))))
    return errors, steps


def _last_good(rows: np.ndarray, grid: np.ndarray) -> IntegrationError:
    """The error of a motion whose state is no longer finite; the last good one of its ``rows``
    (k, n) is the last on the grid."""
    good = np.isfinite(rows).all(axis=1)
    last = int(np.argmin(good)) - 1 if not good.all() else len(grid) - 1
    rows[last + 1 :] = np.nan
    return break_error(INFINITE, float(grid[last]), rows[last].copy())


def carry(
    lanes: Lanes, ends: np.ndarray, longest: np.ndarray, stopped: Look, look: LookAtChunk,
    steps_ahead: Callable[[], int] | None = None,
) -> tuple[dict[int, IntegrationError], int]:  # fmt: skip
    """From where motions stand to their ``ends`` (width,), by very many steps, none longer than the
    motion's ``longest`` there, which is looked for again on the way: what broke, and how many steps
    there were.

    Where ``steps_ahead`` says how many steps come next, there is continuous output of them, to
    ``look`` at: it may end motions, by an error or by moving their ends to where they stand.
    """
    ta, steps, errors = lanes.integrator, 0, dict[int, IntegrationError]()
    followed = lanes.has_roots or steps_ahead is not None
    while (ta.alive & (ta.high != ends)).any():
        if stopped():
            raise StopRequest
        lanes.take()
        if longest.min() < np.inf:  # steps were short where they began, and in other units
            longest = lanes.first_steps(ends - ta.high)
        begin, alive, last = ta.place, ta.alive, lanes.states
        lanes.go_to(ends, longest, followed, steps_ahead() if steps_ahead else CHUNK)
        steps += int(ta.latest.taken.sum())
        lanes.look_back(begin, longest)
        why = dict.fromkeys(np.flatnonzero(alive & ~ta.alive).tolist(), INFINITE)
        stands = ta.alive & (ta.high != ends) & (ta.high == begin[0])
        why |= dict.fromkeys(np.flatnonzero(stands).tolist(), COLLAPSE)
        failures = {i: break_error(x, begin[0][i], last[i]) for i, x in why.items()}
        failures |= look(begin)
        if steps > MANY:  # those that are followed alone in any case: the others need not wait
            lanes.steps.left |= ta.alive & (ta.high != ends) & lanes.steps.doubtful
            left = np.flatnonzero(lanes.steps.left & ta.alive).tolist()
            failures |= {i: break_error(COLLAPSE, ta.high[i], lanes.states[i]) for i in left}
        ta.state[:, [*failures]] = np.nan
        errors |= failures
    return errors, steps


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
