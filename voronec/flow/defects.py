"""Whether states on a grid obey given equations: the defect of the motion, window by window.

    defect = x(t_8) - x(t_0) - integral of f(t, x(t)) dt

over nine neighbouring instants t_0, ..., t_8.  The integral is that of the polynomial through the
nine rates; how fast the coefficients of its expansion in Legendre polynomials fall says how far it
can be trusted.  Nothing of the integrator that found the states is used.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

__all__ = ["WIDTH", "Rates", "Windows", "again"]

WIDTH = 9
"""Instants in a window."""
RELATIVE, ROUNDING = 1e-6, 1e-9
"""A defect is no rounding where it is larger than these parts of the way that a variable goes in
the window, and of the variable's size."""
DOUBT = 2.0
"""A defect counts where it is so many times larger than what the last two coefficients contribute;
the coefficients that are left out are of their size."""
ILL, SAME = 1e4, 1e-9
"""Nodes that magnify rates by more tell nothing; nodes that differ by less are the same."""
BUDGET = 3000
"""Evaluations that integrating a window again may take."""
NEARBY, FINE, LEFT = 1e-7, 1e-11, 1e3
"""How far from the first another start is, the tolerance from there, and how many tolerances the
state may be off."""

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
            starts = starts[np.unique(np.linspace(0, whole - 1, most).astype(int))]
        elif starts[-1] + WIDTH < size:
            starts = np.append(starts, size - WIDTH)
        return cls(starts[:, None] + np.arange(WIDTH))

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


def _inverse_bases(nodes: np.ndarray) -> np.ndarray:
    """From values at nodes (windows, WIDTH) to shares of Legendre polynomials: matrices, one for
    all windows where all have the same nodes."""
    if np.abs(nodes - nodes[0]).max() < SAME:
        nodes = nodes[:1]
    basis = np.polynomial.legendre.legvander(nodes, WIDTH - 1)
    found = np.full_like(basis, np.inf)
    sound = np.linalg.det(basis) != 0
    found[sound] = np.linalg.inv(basis[sound])
    return found


def again(
    rates: Rates, t: np.ndarray, states: np.ndarray, tol: float, most: int = BUDGET
) -> np.ndarray | None:
    """The defect of the last state of a window, by variable, in units of what is allowed: the
    motion is integrated again from the first state by a Runge-Kutta method.

    Also from a start nearby, which tells how far what the tolerance leaves open grows.  None where
    that cannot be done in so many evaluations.
    """
    from scipy.integrate import DOP853

    size = np.maximum(1.0, np.abs(states).max(initial=0.0))
    left = [most]

    def single(time: float, state: np.ndarray) -> np.ndarray:
        left[0] -= 1
        if left[0] < 0:
            raise _Spent
        return rates(np.array([time]), state[None, :])[0]

    ends = []
    for start in (states[0], states[0] + NEARBY * size * _signs(states.shape[1])):
        solver = DOP853(single, t[0], start, t[-1], rtol=FINE, atol=FINE)
        try:
            with np.errstate(all="ignore"):
                while solver.status == "running":
                    solver.step()
        except (_Spent, ValueError):
            return None
        if solver.status != "finished" or not np.isfinite(solver.y).all():
            return None
        ends.append(solver.y)
    grown = np.abs(ends[1] - ends[0]) / NEARBY
    allowed = RELATIVE * size + LEFT * max(tol, FINE) * grown
    return np.asarray(np.abs(states[-1] - ends[0]) / allowed)


class _Spent(Exception):
    """More evaluations than there were to spend."""


def _signs(count: int) -> np.ndarray:
    return np.where(np.arange(count) % 2, -1.0, 1.0)
