"""How far a Taylor series is to be trusted.

heyoka takes the length of a step from the last two Taylor coefficients.  Steps would be far too
long here and there: where these vanish at once, as x'' = 1 - x^2 from rest at 0 has those of t^2,
t^6, t^10, ... alone; and where all of them know nothing of what is to come, as x'' = -x^40 has none
at x = 0.  The first is seen in the other coefficients, the second in the defect: by how much the
slope of the series misses the right side, there where it leads.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.equations.program import Program, compile_program

if TYPE_CHECKING:
    from voronec.motion.steppers.wide_batch import LatestSteps

SPARSE = 2.0
"""A step so many times longer than the other coefficients allow is not to be trusted."""
STRIDE = 4.0
"""A step so many times the mean of the others of its chunk may have been made too long by
coefficients that vanish; then the chunk is looked at step by step.  So is each chunk of a run that
began with such a step, since a motion comes back."""
BRIEF, BRIEF_STRIDE = 8, 2.0
"""Chunks of no more than so many steps, and what stands for ``STRIDE`` in them."""
GROWTH = 1.5
"""Of these, only such are looked at as are so many times longer than the step before."""


BLIND = 0.75
"""A defect above this power of the tolerance tells of a series that does not know what is to come;
those of other steps are far below."""
FAITHFUL = 100.0
"""Such a step is halved until its defect is at most so many times the tolerance."""
SHRINKS = 0.25
"""Or until half of it has still more than this part of the defect: what is left is rounding."""
ROUNDING = 100.0
"""What a right side misses where next to no time has passed, times this, is rounding: it grows with
the units of a state that is all but zero, and steps of any length have it."""
MOMENTS = 2.0**-40 * np.arange(1, 5)
"""Next to no time, as parts of the step: the motion goes on by some units in the last place."""
HALVINGS = 40
"""After so many a step is no part of any span."""
MANY = 1_000
"""Where the defect of each step is looked at, they are taken so many at a time, at most: all are
held in memory, and some may have been taken in vain."""
PARTS = 16
"""At the ends of so many parts a step that may be far too long is looked at."""


Field = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""From times (m, k) and states (m, n, k), in units of their own, to rates (m, n, k)."""


def field_of(program: Program, values: Sequence[Any], units: np.ndarray) -> Field:
    """The right side of a program for some values of its parameters, numbers or arrays (k,), with
    states in ``units`` (n,) or (n, k)."""
    sizes = units if units.ndim > 1 else units[:, None]

    def rates(times: np.ndarray, states: np.ndarray) -> np.ndarray:
        right = compile_program(program)[0]  # few runs ask for it
        with np.errstate(all="ignore"):
            slopes = right(times, [*np.moveaxis(states * sizes, 1, 0)], values)
            rows = [np.broadcast_to(np.asarray(r, dtype=float), times.shape) for r in slopes]
            return np.asarray(np.stack(rows, axis=1) / sizes)

    return rates


def reach(integrator: Any, field: Field, taken: float, parts: int = 1) -> float:
    """The length up to which the step just ``taken``, with its Taylor coefficients, may be trusted,
    where it is too long; else infinite.

    Its defect is looked at where so many ``parts`` of it end.
    """
    coefficients, tol = integrator.tc.copy(), integrator.tol
    length = float(_lanes_reach(coefficients[:, :, None], np.array([taken]), tol)[0])
    if length < np.inf or not taken or (parts == 1 and _leads_on(integrator, coefficients, taken)):
        return length
    begin = np.array([integrator.time - taken])
    series = _Series(field, coefficients[:, :, None], np.array([taken]), begin, parts, tol)
    return float(series.reach()[0])


def _leads_on(integrator: Any, series: np.ndarray, taken: float) -> bool:
    """Whether the defect is ordinary where the step just ``taken`` ends, with the coefficients
    (n, order + 1) of its ``series``, and the integrator stands: as ``_Series`` finds it, and soon.
    """
    numbers = np.arange(series.shape[1])
    with np.errstate(all="ignore"):
        slopes = series[:, 1:] @ (numbers[1:] * taken ** numbers[:-1])
        size = np.fmax(1.0, np.abs(series[:, 0]).max())
        integrator.step(max_delta_t=0.0, write_tc=True)
        missed = np.abs(slopes - integrator.tc[:, 1]).max() * abs(taken)
        return bool(missed <= integrator.tol**BLIND * size)


def _lanes_reach(coefficients: np.ndarray, taken: np.ndarray, tol: float) -> np.ndarray:
    """How far steps (k,) may reach by the latter half of their coefficients (n, order + 1, k): the
    radius of convergence that each suggests, times tol^(1/order)."""
    sizes = np.abs(coefficients).max(axis=0)
    sizes = sizes / np.fmax(1.0, sizes[0])
    order = len(sizes) - 1
    powers = -1.0 / np.arange(order // 2, order + 1)[:, None]
    later = sizes[order // 2 :]
    sound = np.where(later > 0, later, 0.0)  # to a negative power: infinite
    with np.errstate(divide="ignore"):
        lengths = (sound**powers).min(axis=0) * tol ** (1.0 / order)
    return np.where(np.abs(taken) > SPARSE * lengths, lengths, np.inf)


@dataclass(frozen=True)
class _Series:
    """The Taylor ``coefficients`` (n, order + 1, k) of steps ``taken`` (k,) from the times
    ``begin`` (k,), looked at where so many ``parts`` of them end."""

    field: Field
    coefficients: np.ndarray
    taken: np.ndarray
    begin: np.ndarray
    parts: int
    tol: float

    def reach(self) -> np.ndarray:
        """The lengths (k,) up to which the defect is of the size of the tolerance; infinite where
        it is ordinary."""
        tol = self.tol
        allowed, faithful = tol**BLIND, min(FAITHFUL * tol, tol**BLIND)
        lengths, noise = self.taken.copy(), np.zeros_like(self.coefficients[:, 0])
        misses = self._misses(lengths)
        worst = self._defects(lengths, misses, noise)
        if (worst > allowed).any():
            noise = ROUNDING * self._miss(MOMENTS[:, None] * lengths).max(axis=0)
            worst = self._defects(lengths, misses, noise)
        blind = worst > allowed
        left = blind.copy()
        for _ in range(HALVINGS):
            if not left.any():
                break
            half = np.where(left, lengths / 2, lengths)
            less = self._defects(half, self._misses(half), noise)
            left &= (worst > allowed) | (less <= SHRINKS * worst)
            lengths, worst = np.where(left, half, lengths), np.where(left, less, worst)
            left &= worst > faithful
        return np.where(blind & (worst <= allowed), np.abs(lengths), np.inf)

    def _lengths_of_parts(self, lengths: np.ndarray) -> np.ndarray:
        return np.asarray(np.arange(self.parts, 0, -1)[:, None] / self.parts * lengths)

    def _misses(self, lengths: np.ndarray) -> np.ndarray:
        """|p' - f(p)| (parts, n, k) where the parts of lengths (k,) end."""
        return self._miss(self._lengths_of_parts(lengths))

    def _defects(self, lengths: np.ndarray, misses: np.ndarray, noise: np.ndarray) -> np.ndarray:
        """The largest |p' - f(p)| h / max(1, |x|) of steps of some lengths (k,), without what is
        ``noise`` (n, k); infinite where the right side has no value."""
        with np.errstate(all="ignore"):
            sizes = np.fmax(1, np.abs(self.coefficients[:, 0]).max(axis=0))
            missed = np.where(misses <= noise, 0.0, misses).max(axis=1)
            ends = missed * np.abs(self._lengths_of_parts(lengths)) / sizes
            return np.asarray(np.nan_to_num(ends.max(axis=0), nan=np.inf))

    def _miss(self, lengths: np.ndarray) -> np.ndarray:
        """|p' - f(p)| (m, n, k), with p the series, where lengths (m, k) end."""
        series = self.coefficients
        numbers = np.arange(series.shape[1])[:, None]
        with np.errstate(all="ignore"):
            powers = lengths[:, None, :] ** numbers
            states = np.einsum("ijk,mjk->mik", series, powers)
            slopes = np.einsum("ijk,mjk->mik", series[:, 1:], numbers[1:] * powers[:, :-1])
            return np.asarray(np.abs(slopes - self.field(self.begin + lengths, states)))


def blind_steps(integrator: Any, output: Any) -> np.ndarray:
    """Which steps (s,), or (s, k) of a batch, of the continuous ``output`` have a defect at their
    end that tells of a series which does not know what is to come.

    The slope there is the first coefficient of the next step; the integrator stands at the end of
    the last one, and afterwards too.
    """
    times, series = np.asarray(output.times), np.asarray(output.tcs)
    lengths, lanes = np.diff(times, axis=0), times.shape[1:]
    numbers = np.arange(1, series.shape[2]).reshape(-1, *(1 for _ in lanes))
    integrator.step(max_delta_t=np.zeros(lanes).tolist(), write_tc=True)
    with np.errstate(all="ignore"):
        powers = numbers * lengths[:, None] ** (numbers - 1)
        slopes = np.einsum("sij...,sj...->si...", series[:, :, 1:], powers)
        right = np.concatenate([series[1:, :, 1], np.asarray(integrator.tc)[None, :, 1]])
        missed = np.abs(slopes - right).max(axis=1) * np.abs(lengths)
        sizes = np.fmax(1.0, np.abs(series[:, :, 0]).max(axis=1))
        return np.asarray(missed > integrator.tol**BLIND * sizes)


def blind_reach(integrator: Any, field: Field, output: Any, step: int) -> np.ndarray:
    """The lengths (1,), or (k,) of a batch, up to which a step of continuous output may be trusted;
    infinite where its defect is ordinary after all."""
    lengths, series = np.diff(output.times, axis=0)[step], np.asarray(output.tcs)[step]
    rows, begin = series.reshape(*series.shape[:2], -1), np.atleast_1d(output.times[step])
    return _Series(field, rows, np.atleast_1d(lengths), begin, 1, integrator.tol).reach()


def reach_of_series(
    field: Field, coefficients: np.ndarray, taken: np.ndarray, begin: np.ndarray, parts: int,
    tol: float,
) -> np.ndarray:  # fmt: skip
    """``reach`` of the steps ``taken`` (k,) from the times ``begin`` (k,), by their Taylor
    coefficients (n, order + 1, k) and by their defect."""
    lengths = _lanes_reach(coefficients, taken, tol)
    series = _Series(field, coefficients, taken, begin, parts, tol)
    return np.minimum(lengths, series.reach())


def blind_lanes(integrator: Any, field: Field, output: Any) -> np.ndarray:
    """Which lanes (width,) of a batch integrator took a step in ``output`` whose series did not
    know what was to come."""
    blind = blind_steps(integrator, output)
    lanes = np.zeros(blind.shape[1], dtype=bool)
    for k in np.flatnonzero(blind.any(axis=1)).tolist():
        if (blind[k] & ~lanes).any():
            lanes |= blind[k] & (blind_reach(integrator, field, output, k) < np.inf)
    return lanes


def uneven_steps(
    span: np.ndarray, latest: LatestSteps, stride: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How long steps of some motions usually are, of those that led over a ``span`` (width,); and
    of which motions one is more than ``stride`` (width,) times the others."""
    taken, longest = latest.taken, latest.longest
    # a last step that was cut is not among the longest; nor is it known where others went on
    cut = np.fmax(np.abs(latest.last), span - (taken - 1) * longest)
    longest = np.where(taken > 1, np.fmax(longest, cut), longest)
    others = (span - longest) / np.maximum(taken - 1, 1)
    with np.errstate(over="ignore"):
        usual = others * np.where(taken > BRIEF, stride, np.minimum(stride, BRIEF_STRIDE))
    return usual, (taken > 1) & (longest > usual)


@dataclass(frozen=True)
class LongSteps:
    """Steps ``taken`` (k,) from the times ``begin`` (k,) by motions ``which`` (k,), with their
    Taylor ``coefficients`` (n, order + 1, k), and how long steps ``usual`` (k,) are."""

    which: np.ndarray
    taken: np.ndarray
    begin: np.ndarray
    coefficients: np.ndarray
    usual: np.ndarray

    @classmethod
    def join(cls, parts: Sequence[LongSteps]) -> LongSteps:
        """All steps together."""
        return cls(*(
            np.concatenate([getattr(part, f.name) for part in parts], axis=-1) for f in fields(cls)
        ))  # fmt: skip

    def reach(self, field: Callable[[np.ndarray], Field], tol: float) -> np.ndarray:
        """The lengths (k,) up to which steps may be trusted that are made too long, else infinite;
        ``field`` is that of some motions.  Those longer than the usual are looked at in parts."""
        lengths, far = np.full(len(self.which), np.inf), np.abs(self.taken) > self.usual
        for parts, chosen in ((1, ~far), (PARTS, far)):
            if chosen.any():
                right, rows = field(self.which[chosen]), self.coefficients[:, :, chosen]
                taken, begin = self.taken[chosen], self.begin[chosen]
                lengths[chosen] = reach_of_series(right, rows, taken, begin, parts, tol)
        return lengths

    def overlong(self, field: Callable[[np.ndarray], Field], tol: float) -> np.ndarray:
        """The motions that took a step which is made too long."""
        return self.which[self.reach(field, tol) < np.inf]


def long_steps(
    integrator: Any, which: np.ndarray, ends: np.ndarray, limits: np.ndarray, most: int,
    usual: np.ndarray,
) -> list[LongSteps]:  # fmt: skip
    """Of the steps of motions ``which`` (width,) from where a batch integrator stands to the times
    ``ends`` (width,), ``most`` of them, none longer than ``limits`` (width,), those that are longer
    than the ``usual`` (width,), or than the step before."""
    batches, before = list[LongSteps](), np.zeros(len(ends))

    def look(at: Any) -> bool:
        nonlocal before
        length = np.abs(at.last_h)
        chosen = length > np.minimum(GROWTH * before, usual)
        if chosen.any():
            taken = at.last_h[chosen]
            batches.append(
                LongSteps(
                    which[chosen],
                    taken,
                    at.time[chosen] - taken,
                    at.tc[:, :, chosen],
                    usual[chosen],
                )
            )
        before = length
        return True

    integrator.propagate_until(
        ends.tolist(), max_steps=most, max_delta_t=limits.tolist(), write_tc=True, callback=look
    )
    return batches
