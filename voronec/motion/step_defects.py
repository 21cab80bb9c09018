"""Whether the steps of a run obey its equations, without anything of what found them.

    defect = x(t_8) - x(t_0) - integral of f(t, x(t)) dt

over the nine nodes t_0, ..., t_8 of a step (``samples``).  The integral is that of the polynomial
through the nine rates; how fast the coefficients of its expansion in Legendre polynomials fall says
how far it can be trusted.  x(t_8) is the state with which the next step begins, where that is
known.  What is in doubt is integrated again by another method.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from voronec.equations.program import Program, compile_program
from voronec.motion.steppers import NODES, WIDTH, OwnedSamples, Rates, StepSamples

RELATIVE, ROUNDING = 1e-6, 1e-7
"""A defect is looked into where it is larger than these parts of the way that a variable goes in
the step, and of the state's size: less than a tenth of the first of the size counts never."""
FAR_APART = 2.0**16
"""A step of so many roundings of the time has nodes that are apart."""
DOUBT = 2.0
"""A defect counts where it is so many times larger than what the last two coefficients contribute;
the coefficients that are left out are of their size."""
BUDGET = 1500
"""Evaluations that integrating a step again may take."""
NEARBY, FINE, MARGIN = 1e-7, 1e-11, 1e3
"""How far from the first another start is, the tolerance from there, and how many tolerances the
state may be off."""
ROUNDOFF = float(np.finfo(float).eps)
ULPS, BEND, SWAY = 4, 1e-3, 10.0
"""How far from the first, in roundings, a third start is; how far in sizes of the state the motion
from nearby ends up where there is no telling, and how many times as far as it the state may be off:
through a pole of coordinates, and from it, the next double goes elsewhere."""
BESIDE = 1e-9
"""By this part of half a step an instant may lie beyond its end."""
WORST = 3
"""Steps in doubt, of each motion, that are integrated again."""


SHARES = np.linalg.inv(np.polynomial.legendre.legvander(2 * NODES - 1, WIDTH - 1))[[0, -2, -1]]
"""From values at the nodes to shares of Legendre polynomials: the mean, and the last two."""
POWERS = np.linalg.inv(np.vander(2 * NODES - 1, increasing=True))
"""From values at the nodes to coefficients of powers: rounding leaves more than ten digits."""


def joined_ends(parts: Sequence[StepSamples]) -> list[np.ndarray]:
    """The states (s, n) with which the steps of each part end: those with which the next step
    begins, where that is sampled too."""
    states = []
    for part in parts:
        ends = part.states[:, -1].copy()
        if not part.apart:
            next_to = _meet(part.times[:-1, -1], part.times[1:, 0])
            ends[:-1][next_to] = part.states[1:, 0][next_to]
        states.append(ends)
    for (ends, one), (_, two) in pairwise(zip(states, parts, strict=True)):
        joined = len(ends) and len(two.times) and not (one.apart or two.apart)
        if joined and _meet(one.times[-1, -1], two.times[0, 0]):
            ends[-1] = two.states[0, 0]
    return states


def _meet(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Which instants are the same but for rounding."""
    return np.asarray(np.abs(after - before) <= 4 * np.spacing(np.abs(before)))


def doubtful(samples: StepSamples, ends: np.ndarray, rates: Rates, tol: float) -> list[int]:
    """The steps, with their ``ends`` (s, n), that seem not to obey the equations, worst first; what
    nine nodes do not resolve is in no doubt here."""
    times, states = samples.times, samples.states
    if not states.size:
        return []
    at, span = _by_variable(states), times[:, -1] - times[:, 0]
    slopes = rates(times.T.ravel(), at.reshape(len(at), -1).T).T.reshape(at.shape)
    with np.errstate(all="ignore"):
        shares, length = SHARES @ slopes, np.abs(span)
        defect = np.abs((ends - states[:, 0]).T - span * shares[:, 0])
        allowed = DOUBT * np.abs(shares[:, 1:]).sum(axis=1)
        allowed = length * (allowed + RELATIVE * np.abs(slopes).max(axis=1))
        allowed += (ROUNDING + MARGIN * tol) * _sizes(at)
        if not (defect > allowed).any():  # most runs
            return []
        worst = (defect / allowed).max(axis=0)
        far = FAR_APART * np.spacing(np.abs(times[:, [0, -1]]).max(axis=1))
        worst[~np.isfinite(worst) | (length < far)] = 0.0
    return [int(i) for i in np.argsort(-worst) if worst[i] > 1]


def _by_variable(states: np.ndarray) -> np.ndarray:
    """Samples (s, WIDTH, n) as (n, WIDTH, s), in one piece: what is done to many numbers at once
    takes a third of the time."""
    return np.ascontiguousarray(states.transpose(2, 1, 0))


def _sizes(at: np.ndarray) -> np.ndarray:
    """The sizes (s,) of the states of steps (n, WIDTH, s), at least one."""
    return np.asarray(np.abs(at).max(axis=1).max(axis=0, initial=1.0))


def wrong_steps(
    samples: Sequence[OwnedSamples], rates_of: Callable[[np.ndarray], Rates], tol: float
) -> Iterator[tuple[int, StepSamples, int]]:
    """The steps that do not obey the equations, as a motion, samples and a place among them: those
    that seem not to are integrated again.  ``rates_of`` motions (s,) takes as many times and states
    of each, one motion after the other."""
    ends = joined_ends([part for _, part in samples])
    groups = [(*one, end) for one, end in zip(samples, ends, strict=True)]
    plain = [group for group in groups if group[1].rates is None]
    if len(plain) > 1:  # looked at together
        owner, end = (np.concatenate([group[i] for group in plain]) for i in (0, 2))
        (joined,) = StepSamples.of([(part.times, part.states) for _, part, _ in plain])
        groups = [group for group in groups if group[1].rates] + [(owner, joined, end)]
    for owner, part, end in groups:
        seen = Counter[int]()
        for i in doubtful(part, end, part.rates or rates_of(owner), tol):
            seen[owner[i]] += 1
            rates = part.rates or rates_of(owner[i : i + 1])
            if seen[owner[i]] > WORST:
                continue
            off = again(rates, part.times[i], np.vstack([part.states[i, :-1], end[i]]), tol)
            if off is not None and off.max() > 1:
                yield int(owner[i]), part, i


def strayed_rows(t: np.ndarray, states: np.ndarray, part: StepSamples, tol: float) -> Iterator[int]:
    """The rows of a grid (k,), with states (1, k, n), after which they are off the steps in which
    they lie."""
    if part.apart or not part.states.size:
        return
    begin, end = part.times[:, 0], part.times[:, -1]
    order = 1.0 if end[-1] >= begin[0] else -1.0
    step = np.searchsorted(order * begin, order * t, side="right") - 1
    with np.errstate(all="ignore"):
        places = 2 * (t - begin[step]) / (end - begin)[step] - 1
        rows = np.flatnonzero((step >= 0) & (places <= 1 + BESIDE))
        powers, step = np.ones((len(rows), WIDTH)), step[rows]
        wide = np.broadcast_to(places[rows, None], (len(rows), WIDTH - 1))
        np.cumprod(wide, axis=1, out=powers[:, 1:])
        read = ((powers @ POWERS)[:, None] @ part.states[step])[:, 0]
        off, least = np.abs(read - states[0, rows]).T, ROUNDING + MARGIN * tol
        if not (off > least).any():
            return
        at = _by_variable(part.states)
        allowed = DOUBT * np.abs(SHARES[1:] @ at).sum(axis=1)
        allowed += RELATIVE * (at.max(axis=1) - at.min(axis=1))
        allowed += least * _sizes(at)
        wrong = (allowed[:, step] < off).any(axis=0)
    yield from np.maximum(rows[wrong] - 1, 0).tolist()


def again(rates: Rates, t: np.ndarray, states: np.ndarray, tol: float) -> np.ndarray | None:
    """The defect of the last state of a step, by variable, in units of what is allowed: the
    motion is integrated again from the first state by a Runge-Kutta method.

    Beside it go one from a start nearby, which tells how far what the tolerance leaves open grows,
    and one from a start some roundings away, which counts in doubt.  None where that cannot be done
    within the budget of evaluations.
    """
    from scipy.integrate import DOP853

    size = np.maximum(1.0, np.abs(states).max(initial=0.0))
    left = [BUDGET]
    moved = np.array([[0.0], [NEARBY], [max(tol, ULPS * ROUNDOFF)]])
    starts = states[0] + moved * size * np.where(np.arange(states.shape[1]) % 2, -1.0, 1.0)

    def all_rates(time: float, state: np.ndarray) -> np.ndarray:
        left[0] -= 1
        if left[0] < 0:
            raise _OverBudget
        return rates(np.full(len(starts), time), state.reshape(starts.shape)).ravel()

    try:
        solver = DOP853(all_rates, t[0], starts.ravel(), t[-1], rtol=FINE, atol=FINE)
        with np.errstate(all="ignore"):
            while solver.status == "running":
                solver.step()
    except (_OverBudget, ValueError):
        return None
    if solver.status != "finished" or not np.isfinite(solver.y).all():
        return None
    here, nearby, beside = solver.y.reshape(starts.shape)
    gap = np.abs(nearby - here)
    allowed = RELATIVE * size + MARGIN * max(tol, FINE) / NEARBY * gap
    allowed += np.where(gap > BEND * size, SWAY * gap, 0.0)
    off = np.abs(states[-1] - here)
    if (off > allowed).any():
        allowed += SWAY * np.abs(beside - here)
    return np.asarray(off / allowed)


class _OverBudget(Exception):
    """More evaluations than there were to spend."""


def program_rates(program: Program, at: Callable[[np.ndarray], list[Any]]) -> Rates:
    """The right-hand side that was integrated, ``at`` giving its parameters at times (k,)."""
    right = compile_program(program)[0]

    def rates(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        slopes = np.empty((states.shape[1], len(t)))
        with np.errstate(all="ignore"):
            for row, slope in zip(slopes, right(t, list(states.T), at(t)), strict=True):
                row[:] = slope
        return slopes.T

    return rates
