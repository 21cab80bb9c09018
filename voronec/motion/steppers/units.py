"""The natural sizes of states, and what is taken out of states that may be kept small.

A step of Taylor's method is as long as the largest state allows, and small states count as if they
were of size 1.  So in other units of length the same motion had other errors.  States far from
ordinary size are measured in units of their own, powers of two: what is of ordinary size is
computed with the same bits as ever.

States that the equations hold under sines and cosines only are angles: one of 1e5 radians loosens
the tolerance of all others by 1e5.  What has grown is taken out of angles, and of states that the
equations do not hold at all (quadratures), between steps and added to the results: the motion of
the others is the same.  What they grow by until then is made up for by a finer tolerance.

For the same reason a state that sets out near an equilibrium, in a tiny unit of its own, must not
stay in that while it grows to ordinary size: where some unit is not 1, each step is looked at, and
units are set anew where states left them.  Where all are 1 at first, and a state grows far beyond
ordinary size, the motion is begun anew in units.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite
from typing import Any

import numpy as np
import symengine as se

from voronec.equations.program import Block, Program, compile_program
from voronec.motion.steppers.run import Problem
from voronec.motion.tolerances import taylor_tolerance

SMALL, ORDINARY = 2.0**-24, 2.0**10
"""Sizes between these are ordinary: their unit is 1."""
STILL = 2.0**-40
"""A rate below this part of the largest is mostly rounding, and tells no time; so is what changes a
rate by less than this part of it."""

Slopes = Callable[[np.ndarray], np.ndarray]
"""Rates (s, n) of states (s, n)."""
NUDGE = 2.0**-48
"""The part of its size by which a state is moved to see what depends on it, and what of a rate is
rounding: little more than rounding itself, so that terms which cancel for every state show too."""


def natural_units(problem: Problem) -> np.ndarray:
    """The units of the states of a problem (n,)."""
    if problem.units is not None:
        return problem.units
    if _are_ordinary(problem.program, problem.start.tolist(), [*map(float, problem.parameters)]):
        return np.ones(len(problem.start))
    start, values = (np.array([x], dtype=float) for x in (problem.start, problem.parameters))
    return units_of_many(problem.program, start, values)[0]


def _are_ordinary(program: Program, state: list[float], values: list[float]) -> bool:
    """Whether it is plain that all units of a start are 1: the same rule as that of
    ``units_of_many`` for states none of which is small, on floats, which take a tenth of the time.
    """
    try:
        rates = compile_program(program, scalar=True)[0](0.0, state, values)
    except (ArithmeticError, ValueError):
        return False
    slopes = [abs(r) for r in rates]
    sizes = [abs(x) if s in program.derivative.symbols else 0.0
             for s, x in zip(program.state, state, strict=True)]  # fmt: skip
    if not all(map(isfinite, slopes)) or any(x and not SMALL <= x <= ORDINARY for x in sizes):
        return False
    least = STILL * max(slopes, default=0.0)
    times = sorted(x / r for x, r in zip(sizes, slopes, strict=True) if x and r > least)
    if not times:
        return True
    for x, r in zip(sizes, slopes, strict=True):
        way = r * times[(len(times) - 1) // 2] if r > least else 0.0
        size = max(x, way if way <= ORDINARY else max(r * times[0], 1.0))
        if size and not SMALL <= size <= ORDINARY:
            return False
    return True


def units_of_many(program: Program, states: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The units of starts (s, n) with parameters (s, p): 1, or the power of two next to the size.

    The size is |x|, or |x'| over the time in which states change by as much as they are, in the
    median; rates that are rounding do not count, and what is small only because terms cancel has
    the size of these.  Angles matter up to turns only: they have the
    unit 1, and tell a time, that of a radian, only where nothing else does.
    """
    if not states.shape[1]:
        return np.ones(states.shape)
    units = _units_beside(program, states, values, [])
    if (units == 1).all():
        return units
    return _units_beside(
        program, states, values, [*angles_among(program.state, (program.derivative,))]
    )


def _units_beside(
    program: Program, states: np.ndarray, values: np.ndarray, angles: list[int]
) -> np.ndarray:
    """The units of starts, where it is known which states are ``angles``."""
    rhs = compile_program(program)[0]

    def slopes(at: np.ndarray) -> np.ndarray:
        rates = [np.asarray(r, dtype=float) for r in rhs(np.float64(0.0), [*at.T], [*values.T])]
        return np.stack([np.broadcast_to(r, len(at)) for r in rates], axis=-1)

    with np.errstate(all="ignore"):
        slope = np.abs(slopes(states))
        # nothing depends on a quadrature, so that its value has no size; its rate has
        held = [s in program.derivative.symbols for s in program.state]
        x = np.where(held, np.abs(states), 0.0)
        sizes, turning = x.copy(), np.zeros(x.shape, dtype=bool)
        sizes[:, angles], turning[:, angles] = 1.0, True
        sizes = np.where(_are_felt(slopes, states, sizes, turning), sizes, 0.0)
        moving = _are_moving(sizes, slope, ~turning)
        moving |= _are_moving(sizes, slope, turning) & ~moving.any(axis=1, keepdims=True)
        times = np.sort(np.where(moving, sizes / slope, np.inf), axis=1)
        count, rows = moving.sum(axis=1), np.arange(len(x))
        # of two in the middle the shorter: a size that is too small costs steps, a large one digits
        middle = times[rows, (count - 1) // 2]
        span = np.where(count > 0, middle, 0.0)[:, None]
        expected = np.where(_sound(slope), slope, 0.0)
        # what only slow states let grow large does not where others, angles too, are quick
        quick = _are_moving(sizes, slope, np.ones(x.shape, dtype=bool))
        briefest = np.where(quick, sizes / slope, np.inf).min(axis=1, keepdims=True)
        soon = np.maximum(expected * np.minimum(span, briefest), 1.0)
        expected = expected * span
        size = np.maximum(x, np.where(expected > ORDINARY, soon, expected))
        small = (size > 0) & (size < SMALL)
        if small.any():
            terms = span * balance(slopes, states, sizes)
            size = np.where(small, np.maximum(size, np.minimum(terms, SMALL)), size)
        far = (size > 0) & ~((size >= SMALL) & (size <= ORDINARY)) & np.isfinite(size)
    far &= np.isfinite(slope).all(axis=1)[:, None]
    far[:, angles] = False
    if not far.any():
        return np.ones(far.shape)
    return np.where(far, _powers_next_to(np.where(far, size, 1.0)), 1.0)


def _powers_next_to(sizes: np.ndarray) -> np.ndarray:
    return np.asarray(np.ldexp(1.0, np.minimum(np.frexp(sizes)[1], np.finfo(float).maxexp - 1)))


def units_next_to(sizes: np.ndarray) -> np.ndarray:
    """The units of states that left theirs: 1 where they are of size 1 up to the largest ordinary,
    and below, where errors have been those of a smaller unit, the next power of two."""
    return np.where((sizes >= 1) & (sizes <= ORDINARY), 1.0, _powers_next_to(sizes))


def balance(slopes: Slopes, states: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """How much rates (s, n) depend on the states: what is small only because large terms cancel."""
    now, dependence = slopes(states), np.zeros(states.shape)
    for j in np.flatnonzero(sizes.any(axis=0)):
        beside = states.copy()
        beside[:, j] += NUDGE * sizes[:, j]
        dependence = np.fmax(dependence, np.abs(slopes(beside) - now) / NUDGE)
    return dependence


def _are_felt(
    slopes: Slopes, states: np.ndarray, own: np.ndarray, turning: np.ndarray
) -> np.ndarray:
    """Which states (s, n) are not rounding: without one that is, no rate is another."""
    small, felt = (own > 0) & (own < SMALL), np.ones(own.shape, dtype=bool)
    if not small.any():
        return felt
    now = slopes(states)
    size = np.abs(now)
    sound = np.where(
        turning, _sound(np.where(turning, size, 0.0)), _sound(np.where(turning, 0.0, size))
    )
    for j in np.flatnonzero(small.any(axis=0)):
        without = states.copy()
        without[:, j] = 0.0
        changed = (np.abs(slopes(without) - now) > STILL * size) & sound
        felt[:, j] = ~small[:, j] | changed.any(axis=1)
    return felt


def _are_moving(x: np.ndarray, slope: np.ndarray, among: np.ndarray) -> np.ndarray:
    """Which of some states tell a time: those that are not zero, and whose rates are no rounding.

    Rates of angles near a pole say nothing of the others; where these stand still, they must do.
    """
    return (x > 0) & _sound(np.where(among, slope, 0.0))


def _sound(rates: np.ndarray) -> np.ndarray:
    """Which of rates (s, n) are no rounding beside the largest."""
    return np.asarray(rates > STILL * rates.max(axis=1, initial=0.0)[:, None])


@lru_cache(maxsize=64)  # it is asked before every run
def angles_among(state: tuple[Any, ...], blocks: tuple[Block, ...]) -> tuple[int, ...]:
    """Positions of the states that blocks hold under sines and cosines only."""
    held = set().union(*(b.symbols for b in blocks))
    turned = _angles(blocks, [s for s in state if s in held])
    return tuple(i for i, s in enumerate(state) if s in turned)


def _angles(blocks: Iterable[Block], among: Iterable[Any]) -> set[Any]:
    """Those of the symbols that occur under sines and cosines only, in whole multiples."""
    angles = set(among)
    for block in blocks:
        known: dict[Any, Mapping[Any, int]] = {s: {s: 1} for s in angles}
        for name, expr in block.assignments:
            multiples = _multiples(expr, known, angles)
            if multiples:
                known[name] = multiples
        for result in block.results:
            angles -= set(_multiples(result, known, angles))
    return angles


def _multiples(
    expr: Any, known: Mapping[Any, Mapping[Any, int]], found: set[Any]
) -> dict[Any, int]:
    """The whole multiples of angles in an expression; an angle that is in it in any other way is
    struck off ``found``."""
    bare = [s for s in _bare(expr, known, found) if s in known]
    total: dict[Any, int] = {}
    for symbol in bare:
        slope = se.diff(expr, symbol)
        if slope.is_Number and slope == int(slope):
            for angle, n in known[symbol].items():
                total[angle] = total.get(angle, 0) + n * int(slope)
        else:
            found -= set(known[symbol])
    return {a: n for a, n in total.items() if n}


def _bare(expr: Any, known: Mapping[Any, Mapping[Any, int]], found: set[Any]) -> set[Any]:
    """Symbols outside of sines and cosines, whose arguments are looked at on the way."""
    result, seen, stack = set[Any](), set[Any](), [expr]
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if type(node).__name__ in ("sin", "cos"):
            _multiples(node.args[0], known, found)
        elif node.is_Symbol:
            result.add(node)
        else:
            stack.extend(node.args)
    return result


CHUNK = 20_000
"""Steps between two looks at the keyboard."""
SHORT, LEAST, LARGE = 64, 32, 8.0
"""So many steps are taken at first where states wind; fewer, down to the least, where in these they
grow to more than so many times the others, and more, up to CHUNK, where they hardly grow."""
TURN = 2 * np.pi
COARSE = float(np.ldexp(np.round(np.ldexp(TURN, 30)), -30))
"""A turn in 33 bits, whose small multiples are exact; FINE is the rest of it."""
FINE = 2 * (float(np.float64(np.pi) - COARSE / 2)) + 2.4492935982947064e-16
"""The rest of a turn: of COARSE, and of 2 pi beyond its double."""


@dataclass
class TurnCount:
    """What was taken out of the states: turns of ``angles``, all of ``quadratures`` (positions).

    The states that are kept ``small``, by their positions, and the ``others`` are in ``units``
    (n,), or (n, lanes), of their own; those of angles are 1.  Where the motion is ``scaled``, some
    unit is not 1: states beyond ``bounds`` have outgrown theirs, and ``peaks`` are the largest
    ones in so many ``looks``.
    A quadrature is kept as the sum of two doubles, so nothing is lost when small steps are added
    to a large sum.
    """

    quadratures: np.ndarray
    angles: np.ndarray
    units: np.ndarray
    scaled: bool = False
    high: np.ndarray = field(init=False)
    low: np.ndarray = field(init=False)
    small: np.ndarray = field(init=False)
    others: np.ndarray = field(init=False)
    bounds: np.ndarray = field(init=False)
    peaks: np.ndarray = field(init=False)
    looks: int = 0

    def __post_init__(self) -> None:
        self.high, self.low = np.zeros(self.units.shape), np.zeros(self.units.shape)
        small = {*self.quadratures.tolist(), *self.angles.tolist()}
        self.small = np.array(sorted(small), dtype=int)
        self.others = np.array([i for i in range(len(self.units)) if i not in small], dtype=int)
        self.bounds, self.peaks = np.ones(self.units.shape), np.ones(self.units.shape)
        self.measure(self.units)

    @classmethod
    def of(
        cls, program: Program, levels: Program | None, units: np.ndarray, scaled: bool
    ) -> TurnCount:
        """The states that may be kept small, though ``levels`` are looked at on the way."""
        blocks = (program.derivative, *([levels.extras] if levels is not None else []))
        held = set().union(*(b.symbols for b in blocks))
        angles = angles_among(program.state, blocks)
        return cls(
            np.array([i for i, s in enumerate(program.state) if s not in held], dtype=int),
            np.array(angles, dtype=int),
            units.copy(),
            scaled,
        )

    @property
    def is_needed(self) -> bool:
        """Whether there is a state that may be kept small."""
        return len(self.small) > 0

    def tolerance(self, tol: float) -> float:
        """The one of steps, for one of a run: finer by a term, and by another for what states that
        are kept small, or have units, loosen it by while they grow, LARGE at most."""
        return taylor_tolerance(tol, 2 if self.is_needed or self.scaled else 1)

    def reset(self, which: Any = slice(None)) -> None:
        """Nothing is taken out, or nothing of some lanes."""
        self.high[..., which] = self.low[..., which] = 0.0

    def measure(self, units: np.ndarray, which: Any = slice(None)) -> None:
        """Measure states, or those of some lanes, in other units; angles that only functions of
        events hold, which units of a program know nothing of, stay as they are."""
        units = units.copy()
        units[self.angles] = 1.0
        for sums in (self.high, self.low):
            sums[..., which] = sums[..., which] * self.units[..., which] / units
        self.units[..., which], self.peaks[..., which] = units, 1.0
        bounds = LARGE * np.where(units == 1, ORDINARY, 1.0)
        # quadratures are taken out now and then: they may grow until then
        bounds[self.quadratures] *= LEAST
        bounds[self.angles] = np.inf
        self.bounds[..., which] = bounds

    def outgrown(self, states: np.ndarray) -> np.ndarray:
        """Which motions, whose units are all 1, have a state (..., n), or (..., n, lanes), that is
        far beyond ordinary size."""
        leading = states.ndim - self.units.ndim + 1
        if self.scaled:
            return np.zeros(states.shape[leading:], dtype=bool)
        beyond = np.abs(states) > self.bounds
        if beyond.any():
            beyond &= np.isfinite(states)
        return np.asarray(beyond.any(axis=tuple(range(leading))))

    def fits(self, state: np.ndarray) -> bool:
        """Whether states (n,), or (n, lanes), after a step, are still those of their units."""
        size = np.abs(state)
        if (size > self.bounds).any():
            return False
        if self.looks >= SHORT:
            self.peaks[:], self.looks = 0.0, 0
        np.fmax(self.peaks, size, out=self.peaks)
        self.looks += 1
        return self.looks < SHORT or not self._slack.any()

    @property
    def _slack(self) -> np.ndarray:
        """Which states were far below units above 1 in all of the last steps."""
        slack = (self.units > 1) & (LARGE * self.peaks < 1) & (self.looks >= SHORT)
        slack[self.small] = False
        return np.asarray(slack)

    def renew(self, state: np.ndarray) -> bool:
        """Set units anew where they do not fit, and states (n,), or (n, lanes), in place; whether
        there were such."""
        size, slack = np.abs(state), self._slack
        left = (size > self.bounds) | slack
        if not self.scaled or not left.any():
            return False
        before = self.units.copy()
        units = units_next_to(np.fmax(size, self.peaks) * before)
        units = np.where(slack, np.fmax(units, 1.0), units)
        self.measure(np.where(left, units, before))
        state[:] = state * before / self.units
        return True

    def take(self, state: np.ndarray) -> None:
        """Take what has grown out of a state (n,), or of those of lanes (n, lanes), in place."""
        if len(self.angles):
            at = self.angles
            turns = np.rint(state[at] / TURN)
            state[at] = (state[at] - turns * COARSE) - turns * FINE
            self.high[at] += turns  # whole numbers: exact
        if len(self.quadratures):
            at = self.quadratures
            before, more = self.high[at], state[at] + self.low[at]
            total = before + more
            back = total - before
            self.high[at], self.low[at] = total, (before - (total - back)) + (more - back)
            state[at] = 0.0

    def whole(self, states: np.ndarray) -> np.ndarray:
        """States (..., n), or (..., n, lanes), as they are, from those kept small."""
        if not self.is_needed:
            with np.errstate(over="ignore"):  # what is no longer finite is told elsewhere
                return np.asarray(states * self.units)
        small, large, at = self.low.copy(), self.high.copy(), self.angles
        small[at], large[at] = self.high[at] * FINE, self.high[at] * COARSE
        return np.asarray(((states + small) + large) * self.units)

    def whole_series(self, series: np.ndarray) -> np.ndarray:
        """Coefficients (steps, n, order + 1, lanes) of the states as they are; the same array where
        nothing is taken out."""
        if not self.is_needed and not self.scaled:
            return series
        coefficients = series * self.units[:, None]
        coefficients[:, :, 0] = self.whole(series[:, :, 0])
        return coefficients

    def now(self) -> TurnCount:
        """What is taken out at present, for states that are looked at later."""
        snapshot = copy.copy(self)
        snapshot.high, snapshot.low = self.high.copy(), self.low.copy()
        snapshot.units = self.units.copy()
        return snapshot

    def growth(self, state: np.ndarray) -> float:
        """The largest state that may be kept small, in units of the largest other (at least 1); of
        lanes, where that is largest."""
        others = np.abs(state[self.others]).max(axis=0, initial=1.0)
        sizes = np.abs(state[self.small]).max(axis=0, initial=0.0)
        return float(np.max(sizes / others, initial=0.0))  # no lane may be left

    def pace(self, size: int, state: np.ndarray, most: int) -> int:
        """How many steps go before the next look, where states grew to these in ``size`` steps; no
        more than the ``most``."""
        grown = self.growth(state)
        if grown > LARGE:
            return max(size // 2, min(LEAST, most))
        return min(2 * size, most) if grown < LARGE / 4 else size
