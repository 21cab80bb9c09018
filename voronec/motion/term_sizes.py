"""By what terms change that vanish along a motion: a drift of rounding is measured by that.

Nothing here is a number of one's own choice of units: states have the size that they come to, or,
where that is small since large terms cancel in their rates, that of these terms over the time in
which the fastest state changes by as much as it is.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from voronec.equations.program import Program, compile_program
from voronec.motion.state_probe import at_each
from voronec.motion.steppers import balance

CANCELLATION = 1e-6
"""An integral less than this part of its terms counts as starting at zero."""
SMALL = 1e-9
"""A larger drift may be one of rounding."""
NUDGE, ROWS = 1e-6, 9
"""How far arguments are moved to see slopes, in units of their sizes, and at how many instants."""


@np.errstate(all="ignore")  # a slope may have no value
def term_slopes(
    program: Program, names: Iterable[str], t: np.ndarray, states: np.ndarray, values: np.ndarray
) -> dict[str, np.ndarray]:
    """The largest slopes (m,) of extra quantities of a program by each state and each parameter,
    times its size, summed: of motions with states (m, k, n) and parameters (m, k, p) at t (k,).

    A slope is that to the steeper side, since terms taken positive have a corner where they vanish.
    """
    rows = np.linspace(0, len(t) - 1, ROWS).astype(int)
    times, still = t[rows].astype(float), states.shape[-1]
    here = np.concatenate([states[:, rows].astype(float), values[:, rows]], axis=-1)
    units = np.abs(here).max(axis=1)
    units[:, :still] = _natural_sizes(program, times, here[..., :still], here[..., still:])
    nudges = NUDGE * units[:, None, :] * np.eye(units.shape[1])
    steps = np.concatenate([np.zeros_like(nudges[:, :1]), nudges, -nudges], axis=1)
    moved = here[:, None] + steps[:, :, None, :]
    extras = compile_program(program)[1]
    quantities = at_each(extras, program.names, times, moved[..., :still], moved[..., still:])
    result = {}
    for name in names:
        terms = quantities[name]
        changes = np.nan_to_num(np.abs(terms[:, 1:] - terms[:, :1]), posinf=0.0) / NUDGE
        steepest = changes.reshape(len(terms), 2, -1, len(rows)).max(axis=1)
        result[name] = steepest.sum(axis=1).max(axis=1)
    return result


def _natural_sizes(
    program: Program, t: np.ndarray, states: np.ndarray, values: np.ndarray
) -> np.ndarray:
    """The sizes (m, n) of states (m, k, n) with parameters (m, k, p) at t (k,)."""
    rhs, sizes = compile_program(program)[0], np.abs(states).max(axis=1)
    shape, names = states.shape, [str(i) for i in range(states.shape[-1])]

    def slopes(at: np.ndarray) -> np.ndarray:
        derivatives = at_each(rhs, names, t, at.reshape(shape), values)
        return np.stack([derivatives[name] for name in names], axis=-1).reshape(at.shape)

    flat = states.reshape(-1, shape[-1])
    each = np.repeat(sizes, shape[1], axis=0)
    rates = np.abs(slopes(flat)).reshape(shape).max(axis=1)
    time = np.where((rates > 0) & (sizes > 0), sizes / rates, np.inf).min(axis=1, initial=np.inf)
    terms = balance(slopes, flat, each).reshape(shape).max(axis=1)
    return np.fmax(sizes, np.where(np.isfinite(time), time, 0.0)[:, None] * terms)
