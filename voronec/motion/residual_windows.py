"""Whether the states of a run obey its equations, without anything of what found them.

    defect = x(t_8) - x(t_0) - integral of f(t, x(t)) dt

over nine neighbouring instants t_0, ..., t_8, a window.  The integral is that of the polynomial
through the nine rates; how fast the coefficients of its expansion in Legendre polynomials fall says
how far it can be trusted.  What is in doubt is integrated again by another method.

A grid that is too coarse gets windows of its own before some of its instants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from itertools import count
from typing import Any

import numpy as np

from voronec.equations.program import Program, compile_program
from voronec.motion.steppers.run import Problem, Run
from voronec.motion.steppers.units import natural_units

__all__ = [
    "WIDTH",
    "WORST",
    "LookGrid",
    "Rates",
    "Windows",
    "affordable_windows",
    "again",
    "disobedient",
    "pace_of",
    "program_rates",
    "spread",
]


WIDTH = 9
"""Instants in a window."""
RELATIVE, ROUNDING = 1e-6, 1e-7
"""A defect is looked into where it is larger than these parts of the way that a variable goes in
the window, and of the state's size: less than a tenth of the first of the size counts never."""
RESOLUTION, COARSE = 2.0, 0.5
"""A window is to be so many times in which a motion changes by as much as it is; instants
that are farther apart than the second are too coarse for nine of them to resolve it."""
FAR_APART = 2.0**16
"""A window of so many roundings of the time holds instants that are apart."""
LOOKS = 3
"""So many windows are added to a grid that is too coarse."""
DOUBT = 2.0
"""A defect counts where it is so many times larger than what the last two coefficients contribute;
the coefficients that are left out are of their size."""
ILL, SAME = 1e4, 1e-9
"""Nodes that magnify rates by more tell nothing; nodes that differ by less are the same."""
BUDGET = 3000
"""Evaluations that integrating a window again may take."""
OFTEN = 24
"""Single evaluations after which it pays to make those on floats."""
TWICE = 24
"""Evaluations of a step of DOP853, made from two starts."""
NEARBY, FINE, MARGIN = 1e-7, 1e-11, 1e3
"""How far from the first another start is, the tolerance from there, and how many tolerances the
state may be off."""
ROUNDOFF = float(np.finfo(float).eps)
ULPS, BEND, SWAY = 4, 1e-3, 10.0
"""How far from the first, in roundings, a third start is; how far in sizes of the state the motion
from nearby ends up where there is no telling, and how many times as far as it the state may be off:
through a pole of coordinates, and from it, the next double goes elsewhere."""
WORST = 3
"""Windows in doubt, of each motion, that are integrated again."""

Rates = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,) and states (k, n) to the rates (k, n) of the variables; nan where undefined."""


@dataclass(frozen=True)
class Windows:
    """Rows of a grid, in windows: ``rows`` has shape (windows, WIDTH)."""

    rows: np.ndarray

    @classmethod
    def spread(cls, size: int, most: int) -> Windows:
        """As many windows as cover a grid of some size, side by side, or as may be, evenly spread;
        none where the grid is too small."""
        whole = (size - 1) // (WIDTH - 1)
        if whole < 1:
            return cls(np.empty((0, WIDTH), dtype=int))
        starts = np.arange(whole) * (WIDTH - 1)
        if whole > most:
            starts = starts[spread(whole, most)]
        elif starts[-1] + WIDTH < size:
            starts = np.append(starts, size - WIDTH)
        return cls(starts[:, None] + np.arange(WIDTH))

    @classmethod
    def of(cls, size: int, most: int, looks: Sequence[int]) -> Windows:
        """Those of a grid of some size, and those that end at its instants ``looks`` and begin
        among what was added to it."""
        ends = np.array([end for end in looks if end < size], dtype=int)
        added = ends[:, None] + np.arange(1 - WIDTH, 1)
        own = np.ones(size, dtype=bool)
        own[added[:, :-1]] = False
        return cls(np.vstack([np.flatnonzero(own)[cls.spread(int(own.sum()), most).rows], added]))

    def beside(self, t: np.ndarray, spans: Iterable[tuple[float, float]]) -> Windows:
        """Those that meet none of some spans: to integrate over a jump tells nothing."""
        low, high = self._ends(t)
        meets = [(a <= high) & (b >= low) for a, b in spans]
        return Windows(self.rows[~np.any(meets, axis=0)]) if meets else self

    def within(self, t: np.ndarray, first: float, last: float) -> Windows:
        """Those that lie within a span."""
        low, high = self._ends(t)
        return Windows(self.rows[(first <= low) & (high <= last)])

    def _ends(self, t: np.ndarray) -> np.ndarray:
        """The earlier ends of the windows and the later ones, shape (2, windows)."""
        return np.sort(t[self.rows[:, [0, -1]]], axis=1).T

    def doubtful(self, t: np.ndarray, states: np.ndarray, rates: Rates) -> list[int]:
        """The windows whose states seem not to obey the equations, worst first; what the grid does
        not resolve is in no doubt here.

        ``states`` has shape (k, n), their times ``t`` (k,).
        """
        if not len(self.rows) or not states.shape[1]:
            return []
        used, where = np.unique(self.rows, return_inverse=True)
        slopes = rates(t[used], states[used])[where.reshape(self.rows.shape)]
        times, values = t[self.rows], states[self.rows]
        half = (times[:, -1:] - times[:, :1]) / 2
        inverse = _inverse_bases((times - times[:, :1]) / half - 1)
        good = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(values).all(axis=(1, 2))
        good &= np.abs(inverse).max(axis=(1, 2)) < ILL
        kept, half = np.flatnonzero(good), half[good]
        shares = np.broadcast_to(inverse, (len(times), WIDTH, WIDTH))[good] @ slopes[good]
        length = 2 * np.abs(half)
        defect = np.abs(values[good, -1] - values[good, 0] - 2 * half * shares[:, 0])
        allowed = DOUBT * length * np.abs(shares[:, -2:]).sum(axis=1)
        allowed += RELATIVE * length * np.abs(slopes[good]).max(axis=1)
        allowed += ROUNDING * np.maximum(1.0, np.abs(values[good]).max(axis=(1, 2)))[:, None]
        worst = (defect / allowed).max(axis=1)
        return [int(kept[i]) for i in np.argsort(-worst) if worst[i] > 1]


@dataclass(frozen=True)
class LookGrid:
    """A grid ``whole`` that is run on: the one that was asked for, whose instants are ``own``, with
    windows before some of them, ``ends``, where it is too coarse for windows of its own."""

    whole: np.ndarray
    own: np.ndarray
    ends: tuple[int, ...] = ()

    @classmethod
    def of(cls, grid: np.ndarray, pace: float, most: int = LOOKS) -> LookGrid:
        """With so many windows at ``most``, as long as resolves a motion that changes by as much as
        it is in a time ``pace``; none where these would be no instants apart."""
        alone, ahead = cls.plain(grid), np.diff(grid).astype(float)
        coarse = np.flatnonzero(np.abs(ahead) > (COARSE * pace if len(grid) >= WIDTH else 0.0))
        if not len(coarse):
            return alone
        before = coarse[-1:] if most == 1 else coarse[spread(len(coarse), most)]
        length = np.minimum(RESOLUTION * pace, np.abs(ahead[before]) / 2)
        last = float(np.abs(grid[[0, -1]]).max())
        if not length.min() > FAR_APART * np.spacing(last):
            return alone
        steps = np.copysign(length, ahead[before]) / (WIDTH - 1)
        back = steps[:, None] * np.arange(WIDTH - 1, 0, -1)
        parts = grid[before + 1][:, None] - back
        whole = np.insert(grid, np.repeat(before + 1, WIDTH - 1), parts.ravel())
        ends = before + 1 + (WIDTH - 1) * np.arange(1, len(before) + 1)
        own = np.ones(len(whole), dtype=bool)
        own[ends[:, None] - np.arange(1, WIDTH)] = False
        return cls(whole, own, tuple(ends.tolist()))

    @classmethod
    def plain(cls, grid: np.ndarray) -> LookGrid:
        """A grid without windows."""
        return cls(grid, np.ones(len(grid), dtype=bool))

    def without_looks(self, run: Run) -> Run:
        """The run on the grid that was asked for."""
        if not self.ends:
            return run
        on = min(len(run.t), len(self.whole))
        kept = np.ones(len(run.t), dtype=bool)
        kept[:on] = self.own[:on]
        # where a run was stopped, by an event or by hand, it stands last, and is kept
        stands = run.interrupted or bool(run.stopped)
        kept[-1] |= stands or len(run.t) > on or run.t[-1] != self.whole[on - 1]
        return replace(run, t=run.t[kept], states=run.states[kept])


def pace_of(problem: Problem, time: float) -> float:
    """The time in which a motion changes by as much as its units, at the start; nan where nothing
    is known of it."""
    if not len(problem.start):
        return np.nan
    rates = program_rates(problem.program, lambda _: list(problem.parameters))
    slopes = rates(np.array([time]), problem.start[None, :].astype(float))[0]
    with np.errstate(all="ignore"):
        return float(np.min(natural_units(problem) / np.abs(slopes)))


def spread(size: int, most: int) -> np.ndarray:
    """As many of so many indices as may be, evenly spread, each once."""
    found = np.linspace(0, size - 1, most).astype(int)
    # numpy's unique loads its masked arrays
    return found[np.diff(found, prepend=-1) > 0]


def _inverse_bases(nodes: np.ndarray) -> np.ndarray:
    """From values at nodes (windows, WIDTH) to shares of Legendre polynomials: matrices, one for
    all windows where all have the same nodes."""
    if np.abs(nodes - nodes[0]).max() < SAME:
        nodes = nodes[:1]
    basis = np.ones((*nodes.shape, WIDTH))
    basis[..., 1] = nodes
    for k in range(2, WIDTH):
        basis[..., k] = (2 - 1 / k) * nodes * basis[..., k - 1] - (1 - 1 / k) * basis[..., k - 2]
    found = np.full_like(basis, np.inf)
    sound = np.linalg.det(basis) != 0
    found[sound] = np.linalg.inv(basis[sound])
    return found


def affordable_windows(rows: np.ndarray, t: np.ndarray, steps: float, tol: float) -> np.ndarray:
    """Those of some windows of a grid that can be integrated ``again`` within the budget, where all
    of the grid took so many steps of order 8 or more: there are no fewer, unless they may be
    coarser."""
    parts = np.ptp(t[rows], axis=1) / (np.ptp(t) or 1.0)
    return rows[TWICE * steps * parts * min(1.0, (tol / FINE) ** (1 / 8)) <= BUDGET]


def again(rates: Rates, t: np.ndarray, states: np.ndarray, tol: float) -> np.ndarray | None:
    """The defect of the last state of a window, by variable, in units of what is allowed: the
    motion is integrated again from the first state by a Runge-Kutta method.

    Also from a start nearby, which tells how far what the tolerance leaves open grows, and, in
    doubt, from one that is some roundings away.  None where that cannot be done within the budget
    of evaluations.
    """
    from scipy.integrate import DOP853

    size = np.maximum(1.0, np.abs(states).max(initial=0.0))
    left = [BUDGET]

    def single(time: float, state: np.ndarray) -> np.ndarray:
        left[0] -= 1
        if left[0] < 0:
            raise _OverBudget
        return rates(np.array([time]), state[None, :])[0]

    def end(moved: float) -> np.ndarray:
        start = states[0] + moved * size * _signs(states.shape[1])
        solver = DOP853(single, t[0], start, t[-1], rtol=FINE, atol=FINE)
        with np.errstate(all="ignore"):
            while solver.status == "running":
                solver.step()
        if solver.status != "finished" or not np.isfinite(solver.y).all():
            raise _OverBudget
        return np.asarray(solver.y)

    try:
        here = end(0.0)
        gap = np.abs(end(NEARBY) - here)
        allowed = RELATIVE * size + MARGIN * max(tol, FINE) / NEARBY * gap
        allowed += np.where(gap > BEND * size, SWAY * gap, 0.0)
        off = np.abs(states[-1] - here)
        if (off > allowed).any():
            allowed += SWAY * np.abs(end(max(tol, ULPS * ROUNDOFF)) - here)
    except (_OverBudget, ValueError):
        return None
    return np.asarray(off / allowed)


class _OverBudget(Exception):
    """More evaluations than there were to spend, or no end."""


def _signs(count: int) -> np.ndarray:
    return np.where(np.arange(count) % 2, -1.0, 1.0)


def disobedient(
    t: np.ndarray, states: np.ndarray, rates: Rates, tol: float, windows: Windows, steps: float
) -> list[int]:
    """The first rows of windows whose states do not obey the equations, of a grid that took so many
    steps; what seems not to is integrated again."""
    found = []
    windows = Windows(affordable_windows(windows.rows, t, steps, tol))
    for i in windows.doubtful(t, states, rates)[:WORST]:
        rows = windows.rows[i]
        off = again(rates, t[rows], states[rows], tol)
        if off is not None and off.max() > 1:
            found.append(int(rows[0]))
    return found


def program_rates(program: Program, at: Callable[[np.ndarray], list[Any]]) -> Rates:
    """The right-hand side that was integrated, ``at`` giving its parameters at times (k,).

    Who asks often at single times gets answers from floats, which take a tenth of the time.
    """
    rhs, asked = compile_program(program)[0], count()

    @cache
    def on_floats() -> Any:
        return compile_program(program, scalar=True)[0]

    def rates(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        values = at(t)
        if len(t) == 1 and next(asked) >= OFTEN:
            # what floats refuse may yet have a value: 1/(1 + exp(1000))
            with suppress(ArithmeticError, ValueError):
                plain = [float(np.ravel(x)[0]) for x in values]
                return np.array([on_floats()(float(t[0]), states[0].tolist(), plain)], dtype=float)
        with np.errstate(all="ignore"):
            found = rhs(t, list(states.T), values)
        return np.stack([np.broadcast_to(np.asarray(r, float), t.shape) for r in found], axis=-1)

    return rates
