"""The time of a motion whose quartic is in another one: dt = clock(x) dtau, clock > 0.

t(tau) is one more integral of the elliptic motion; it grows, and is inverted by Newton's method:
in doubles for many times at once, in balls of any number of bits for one.  Whole periods are taken
off first, so that late times lose nothing.

With a pair of poles far away, as of Bobylev's ball that is nearly round, the partial fractions of a
rate are large and nearly opposite, though the rate is not.  The rate itself is smooth: sixteen
digits of its integral cost eight values on every short step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.precision import FIRST, GENERIC, SHARP
from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import ball, precise
from voronec.closed.compiled_motion import reading_of, velocities_in_doubles
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.ratio import (
    Bernstein,
    Polynomial,
    evaluate_form,
    inner,
    ratios,
    rounded_constants,
)
from voronec.elliptic.doubles import LATEST
from voronec.elliptic.many_times import Sample
from voronec.errors import EngineLimit

STEP = 0.125
"""In z, of whose sine and cosine x is a quickly converging series."""
POINTS = 8
"""Of Gauss's rule on such a step, exact to degree 15: the rest is below rounding."""
LARGE = 16.0
"""A factor of a logarithm or an angle beyond which the closed terms are not used."""


@dataclass(frozen=True, eq=False)
class MotionIntegral:
    """Integral ``j`` of one motion."""

    form: InvertedMotion
    j: int

    @cached_property
    def is_needed(self) -> bool:
        """Whether closed terms cancel: the factor of a logarithm or an angle is large."""
        constants = self.form.solution.constants(FIRST)
        sizes = [abs(complex(one.logs[self.j])) for one in constants.log_terms]
        sizes += [abs(float(one.shares[self.j])) for one in constants.phases]
        return constants.half is not None and max(sizes, default=0.0) > LARGE

    @cached_property
    def _parts(self) -> list[tuple[Bernstein, Bernstein]]:
        compiled = self.form.problem.prepared
        pairs = [sp.fraction(e) for e in sp.Add.make_args(compiled.rates[self.j])]
        return [(Polynomial.of(p, compiled).bernstein(self.form),
                 Polynomial.of(q, compiled).bernstein(self.form)) for p, q in pairs]  # fmt: skip

    def _rate(self, taus: np.ndarray) -> np.ndarray:
        sample = Sample.of(self.form.solution, taus)
        near, far = sample.affine(1.0, 0.0), sample.affine(0.0, 1.0)
        total: Any = 0 * near
        for above, below in self._parts:
            total = total + evaluate_form(above, near, far) / evaluate_form(below, near, far)
        return np.asarray(total)

    @cached_property
    def _step(self) -> float:
        return STEP / float(self.form.solution.constants(FIRST).scale)

    def _between(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        nodes, weights = np.polynomial.legendre.leggauss(POINTS)
        middle, half = (low + high) / 2, (high - low) / 2
        rates = self._rate(middle[:, None] + half[:, None] * nodes)
        return np.asarray((rates @ weights) * half)

    def at(self, taus: np.ndarray) -> np.ndarray:
        """The integral since 0."""
        place = np.rint(taus / self._step).astype(int)
        most = int(np.abs(place).max(initial=0))
        grid = np.arange(-most, most + 1) * self._step
        steps = self._between(grid[:-1], grid[1:])
        known = np.concatenate([-np.cumsum(steps[:most][::-1])[::-1], [0.0],
                                np.cumsum(steps[most:])])  # fmt: skip
        return np.asarray(known[place + most] + self._between(grid[place + most], taus))


FINE = GENERIC
"""Bits of constants of which doubles in pieces are made."""
PIECE = 26
"""Bits of the pieces of a period: whole numbers of them are exact."""
SPLIT = float(2**27 + 1)
"""Splits a double into halves of 26 bits."""
NODES = 256
"""Of a table of a period, from which Newton's method starts."""
ROUNDS = 100
"""Doublings, and steps of Newton's method: few are needed, but a loop has to end."""
SPARE = 12
"""Digits of the other time beyond those that are asked for."""


@dataclass(frozen=True, eq=False)
class Clock:
    """The time of one motion."""

    form: InvertedMotion

    @property
    def number(self) -> int:
        """Of the integral that is the time."""
        return len(self.form.problem.prepared.rates) - 1

    @cached_property
    def sums(self) -> list[MotionIntegral]:
        """The integrals by another way, for those whose closed terms cancel."""
        return [MotionIntegral(self.form, j) for j in range(self.number + 1)]

    # -- in doubles ------------------------------------------------------------------------

    @cached_property
    def period(self) -> tuple[float, Sequence[float]] | None:
        """The period in tau, and pieces whose sum is that in t; None where there is none."""
        with precise(FINE):
            constants = self.form.solution.constants(FINE)
            if constants.half is None:
                return None
            return float(2 * constants.half), pieces(constants.advances[self.number])

    def invert(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The whole periods before each time, and tau since the last of them (or to the next)."""
        if self.period is None:
            low, high = self._spread(times)
            return np.zeros(times.shape), self._newton(times, (low + high) / 2, low, high)
        whole, parts = self.period
        count, rest = _reduce_by_periods(times, parts)
        if len(self.pace[0]) == len(self.pace[1]) == 1:  # the clock does not depend on x
            return count, rest * (whole / sum(parts))
        taus, hours, paces = self._table
        at = np.clip(np.searchsorted(hours, rest) - 1, 0, NODES - 1)
        low, high = taus[at], taus[at + 1]
        return count, self._newton(rest, _hermite(rest, at, taus, hours, paces), low, high)

    @cached_property
    def _table(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """tau, t and the clock on a grid of more than one period."""
        assert self.period is not None
        taus = np.linspace(-0.5001, 0.5001, NODES + 1) * self.period[0]
        # half a period of t is not half a period of tau where the motion starts off a turning point
        sample = Sample.of(self.form.solution, taus)
        hours, half = sample.integral(self.number), sum(self.period[1]) / 2
        reach = 0.5001 + max(0.0, *(half - hours[[-1]]), *(half + hours[[0]])) / half
        taus = np.linspace(-reach, reach, NODES + 1) * self.period[0]
        sample = Sample.of(self.form.solution, taus)
        return taus, sample.integral(self.number), self.paces(sample)

    def _spread(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values of tau before and after each time."""
        low, high = np.minimum(times, 0.0), np.maximum(times, 0.0)
        for _ in range(ROUNDS):
            short = Sample.of(self.form.solution, low).integral(self.number) > times
            far = Sample.of(self.form.solution, high).integral(self.number) < times
            if not (short.any() or far.any()):
                return low, high
            low, high = np.where(short, 2 * low, low), np.where(far, 2 * high, high)
        raise EngineLimit("the time of the motion cannot be inverted")

    def _newton(
        self, times: np.ndarray, guess: np.ndarray, low: np.ndarray, high: np.ndarray
    ) -> np.ndarray:
        """tau by Newton's method, kept between bounds that close in."""
        # at a start next to a pole, where an angle turns at once, only 0 itself will do for 0
        taus, left = np.where(times == 0.0, 0.0, guess), np.flatnonzero(times)
        least = 2.0**-20 / float(self.form.solution.constants(FINE).scale)
        for _ in range(ROUNDS):
            if not left.size:
                return taus
            now = taus[left]
            sample = Sample.of(self.form.solution, now)
            gap = sample.integral(self.number) - times[left]
            low[left] = np.where(gap < 0, now, low[left])
            high[left] = np.where(gap > 0, now, high[left])
            step = gap / self.paces(sample)
            new = now - step
            # after a short step, that leaves an error of the size of its square, all is done
            more = np.abs(step) > 2.0**-26 * np.maximum(np.abs(now), least)
            out = more & ~((low[left] <= new) & (new <= high[left]))
            taus[left] = np.where(out, (low[left] + high[left]) / 2, new)
            left = left[more]
        return taus

    @cached_property
    def pace(self) -> tuple[Bernstein, Bernstein]:
        """The clock: numerator and denominator."""
        ratio = ratios(self.form.problem.prepared)[-1]
        return ratio.above.bernstein(self.form), ratio.below.bernstein(self.form)

    @cached_property
    def reach(self) -> list[tuple[Bernstein, Bernstein]]:
        """Of each trace: q - p and q + p, where its cosine is p/q."""
        return [(r.south.bernstein(self.form), r.north.bernstein(self.form))
                for r in ratios(self.form.problem.prepared)[:-1]]  # fmt: skip

    @cached_property
    def bends(self) -> list[tuple[Bernstein, Bernstein, Bernstein]]:
        """Of each trace: p, q and p' q - p q'."""
        return [(r.above.bernstein(self.form), r.below.bernstein(self.form),
                 r.bend.bernstein(self.form)) for r in ratios(self.form.problem.prepared)[:-1]
                ]  # fmt: skip

    def paces(self, sample: Any) -> np.ndarray:
        """The clock at a sample."""
        near, far = sample.affine(1.0, 0.0), sample.affine(0.0, 1.0)
        above, below = (evaluate_form(e, near, far) for e in self.pace)
        return np.asarray(above / below + 0 * near)

    # -- in balls --------------------------------------------------------------------------

    def moment(self, t: Any, digits: int) -> Any:
        """The elliptic motion at a time, ``voronec.elliptic.Enclosed``, and radii below
        10^-digits."""
        from flint import ctx

        bits, more = ctx.prec, SPARE
        while True:
            tau = self._enclose(t, digits + more, bits)
            try:
                return self.form.solution.enclose(tau, digits)
            except EngineLimit:  # the motion stretches the radius of tau
                more, bits = 2 * more, bits + int(7 * more)
                if more > 8 * (digits + SPARE):
                    raise

    def _enclose(self, t: Any, digits: int, bits: int) -> Any:
        """tau as a ball: from the middle m of a ball near it, t(tau) - t(m) = clock (tau - m) with
        a value of the clock between the two."""
        from voronec.elliptic.solution import exact_time
        from voronec.elliptic.theta_balls import nearest

        with precise(bits + 64):
            time, solution = exact_time(t), self.form.solution
            constants = solution.constants(bits + 64)
            rest, shift = time, ball(0)
            if constants.half is not None:
                whole = constants.advances[self.number]
                count = nearest(time / whole)
                rest, shift = time - count * whole, 2 * count * constants.half
            tau, known = (shift + ball(self._roughly(rest))).mid(), 10
            pace = ratios(self.form.problem.prepared)[-1]
            for _ in range(ROUNDS):
                known = min(2 * known, digits)
                at = solution.enclose(tau, known + 2)
                gap = time - at.integrals[self.number]
                near = gap.contains(0) or abs(gap) < ball(10) ** -digits
                if known == digits and near:
                    return tau + gap / self._bounds(bits)
                tau = (tau + gap / pace.value(self.form.problem, at.x, bits)).mid()
        raise EngineLimit(f"no {digits} digits of the motion at t = {t}")

    def _roughly(self, rest: Any) -> float:
        count, tau = self.invert(np.array([float(rest)]))
        return float(tau[0]) + (float(count[0]) * self.period[0] if self.period else 0.0)

    def _bounds(self, bits: int) -> Any:
        """A ball that holds all values of the clock, from the numbers b_k of both polynomials."""
        constants = self.form.solution.constants(bits)
        ratio = ratios(self.form.problem.prepared)[-1]
        bounds = []
        for part in (ratio.above, ratio.below):
            row = inner(part.row(self.form.problem, bits), constants)
            total = row[0]
            for b in row[1:]:
                total = total.union(b)
            bounds.append(total)
        value = bounds[0] / bounds[1]
        if not value > 0:
            raise EngineLimit("the clock of the motion could not be shown to be positive")
        return value


def clock_of(form: InvertedMotion) -> Clock:
    """The time of a motion, kept with it."""
    return form.memo.once("clock", lambda: Clock(form))


def pieces(value: Any) -> list[float]:
    """Doubles whose sum is the number: the first three short, so that products with whole numbers
    below 2^27, and such times a power of two, are exact."""
    doubles, rest = _short_pieces(value, 3)
    return [*doubles, float(rest)]


def _short_pieces(value: Any, count: int) -> tuple[list[float], Any]:
    """So many doubles of few bits that make up most of a number, and what is left of it."""
    doubles, rest = [], value
    for _ in range(count):
        size = float(rest)
        unit = 2.0 ** (np.frexp(size)[1] - PIECE) if size else 1.0
        doubles.append(round(size / unit) * unit)
        rest = rest - ball(doubles[-1])
    return doubles, rest


def whole_turns_off(rate: Any, grid: np.ndarray) -> np.ndarray:
    """rate t in turns, less whole ones, however late: products of short pieces are exact."""
    with precise(SHARP):
        short, _ = _short_pieces(rate / (2 * ball(1).pi()), 4)
    high = grid * SPLIT
    high = high - (high - grid)
    total = np.zeros(grid.shape)
    for piece in short:
        for part in (high, grid - high):
            product = piece * part
            total += product - np.rint(product)
    return np.asarray(total - np.rint(total))


def _reduce_by_periods(times: np.ndarray, parts: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Times less whole periods, the nearest; and how many these are.

    Raises:
        EngineLimit: a time is too many periods away.
    """
    count = np.rint(times / sum(parts))
    if not (np.abs(count) < 2.0**LATEST).all():
        raise EngineLimit(
            f"t = {np.abs(times).max():.17g} is more than 2^{LATEST} periods away; "
            "enclose that time instead"
        )
    low = np.fmod(count, 2.0 ** (LATEST / 2))  # products of either half with a piece are exact
    rest = times.copy()
    for part in parts:
        rest -= (count - low) * part
        rest -= low * part
    return count, rest


def _hermite(
    times: np.ndarray, at: np.ndarray, taus: np.ndarray, hours: np.ndarray, paces: np.ndarray
) -> np.ndarray:
    """tau between nodes, a cubic."""
    width = hours[at + 1] - hours[at]
    s = (times - hours[at]) / width
    first, last = width / paces[at], width / paces[at + 1]
    rise = taus[at + 1] - taus[at]
    return np.asarray(
        taus[at] + s * (first + s * (3 * rise - 2 * first - last + s * (first + last - 2 * rise)))
    )


TURN = 2 * np.pi


def sample_in_own_time(
    form: InvertedMotion, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities; angles continuous (``whole``) or modulo a turn."""
    if form.attitude is not None:
        raise EngineLimit(
            f"system '{form.system.name}': a motion in a time of its own is not turned in space"
        )
    seen = PeriodGrid(form, grid.ravel(), whole)
    state: dict[str, np.ndarray] = {}
    coordinates = {plain_name(q): q for q in form.system.coordinates}
    for name in names:
        if name in coordinates:
            state[name] = seen.value(coordinates[name])
    if {*names} - {*coordinates}:
        state |= seen.velocities()
    return {name: x.reshape(grid.shape) for name, x in state.items()}


@dataclass(frozen=True, eq=False)
class PeriodGrid:
    """One grid of a motion: whole periods, and the elliptic motion in the one that is left."""

    form: InvertedMotion
    grid: np.ndarray
    whole: bool

    @cached_property
    def _instants(self) -> tuple[np.ndarray, np.ndarray]:
        return clock_of(self.form).invert(self.grid)

    @cached_property
    def sample(self) -> Any:
        """The elliptic motion, periods taken off."""
        return Sample.of(self.form.solution, self._instants[1])

    @cached_property
    def _ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Shares of both ends in x."""
        return self.sample.affine(1.0, 0.0), self.sample.affine(0.0, 1.0)

    def _evaluate(self, numbers: Any) -> Any:
        return evaluate_form(numbers, *self._ends)

    def integral(self, j: int, whole: bool) -> np.ndarray:
        """An integral since the start, or, of an angle, less whole turns that nobody asks for."""
        advances = self.form.solution.constants(FINE).advances
        count, summed = self._instants[0], clock_of(self.form).sums[j]
        total = summed.at(self._instants[1]) if summed.is_needed else self.sample.integral(j)
        if advances is None or not count.any():
            return np.asarray(total)
        with precise(FINE):
            advance = advances[j]
            if not whole:
                return np.asarray(total + TURN * whole_turns_off(advance, count))
            parts = pieces(advance)
        for part in reversed(parts):
            total = total + count * part
        return np.asarray(total)

    def value(self, q: Any) -> np.ndarray:
        """A coordinate as it is asked for."""
        coordinate = self.coordinate(q, self.whole)
        if self.whole or q in self.form.quadratures.lengths:
            return coordinate
        return np.asarray(coordinate - TURN * np.ceil(coordinate / TURN - 0.5))

    def coordinate(self, q: Any, whole: bool) -> np.ndarray:
        """The variable, a colatitude, an angle that is an integral, or a place."""
        motion = self.form.quadratures
        if q == motion.meaning:
            return np.asarray(self.sample.x)
        for i, trace in enumerate(motion.traces):
            if trace.colatitude == q:
                side, turns = self.form.branch(i)
                south, north = (self._evaluate(e) for e in clock_of(self.form).reach[i])
                return np.asarray(2 * side * np.arctan2(np.sqrt(south), np.sqrt(north))
                                  + turns * TURN)  # fmt: skip
        if q in motion.angles:
            j = motion.angles.index(q)
            return (
                self.integral(j, whole) + rounded_constants(self.form).starts[j][0 if whole else 1]
            )
        return self.place[q]

    @cached_property
    def place(self) -> dict[Any, np.ndarray]:
        """On a plane."""
        plane = self.form.quadratures.plane
        assert plane is not None
        count = len(self.form.quadratures.angles)
        moved = [self.integral(count + i, True) + self._slid(i) for i in range(2)]
        origin = [float(self.form.exact(q)(FINE)) for q in plane.place]
        return plane.at(origin, [*map(float, self.form.direction(FINE))], moved)

    def _slid(self, i: int) -> np.ndarray:
        """What the slope of a place adds: nothing where x has come back."""
        start, x = float(self.form.problem.place(FINE)), self.sample.x
        a, b, c = rounded_constants(self.form).slides[i]
        moved = self.sample.affine(*rounded_constants(self.form).from_start)
        total = moved * (a + b * (x + start) / 2 + c * (x * x + x * start + start**2) / 3)
        for place, residues in self.form.problem.others(FINE):
            residue = residues[len(self.form.problem.prepared.rates) + i]
            if residue != 0:
                share = moved / (start - complex(place))
                size = 0.5 * np.log1p(2 * share.real + np.abs(share) ** 2)
                total = total + complex(residue).real * size
                total -= complex(residue).imag * np.arctan2(share.imag, 1 + share.real)
        return np.asarray(total)

    def velocities(self) -> dict[str, np.ndarray]:
        """The velocities of the equations."""
        form, compiled, x = self.form, self.form.problem.prepared, self.sample.x
        clock, angles = clock_of(form), len(form.quadratures.angles)
        pace = clock.paces(self.sample)
        values: list[Any] = [*(float(c) for c in form.problem.level(FINE)), x]
        values.append(self.sample.rate / pace)
        with np.errstate(all="ignore"):
            for i in range(len(form.quadratures.traces)):
                south, north = (self._evaluate(e) for e in clock.reach[i])
                above, below, bend = (self._evaluate(e) for e in clock.bends[i])
                sine = form.branch(i)[0] * np.sqrt(south * north) / below
                fall = -bend / below**2 * self.sample.rate / (sine * pace)
                values += [sine, above / below, fall]
            rates = rounded_constants(form).rates(self.sample, self._ends)
            values += [rate / pace for rate in rates[:angles]]
            # less whole turns: the sines of late angles lose nothing
            values += [self.coordinate(q, False) for q in reading_of(compiled).coordinates]
            values += [self._evaluate(p) for p in rounded_constants(form).polynomials]
            rows = velocities_in_doubles(compiled)(*values)
        names = map(plain_name, form.system.velocities)
        return {n: np.broadcast_to(e, self.grid.shape).astype(float)
                for n, e in zip(names, rows, strict=True)}  # fmt: skip
