"""The natural sizes of states: integrators control their steps by them, not by 1.

A step of Taylor's method is as long as the largest state allows, and small states count as if they
were of size 1.  So in other units of length the same motion had other errors.  States far from
ordinary size are measured in units of their own, powers of two: what is of ordinary size is
computed with the same bits as ever.

States that the equations hold under sines and cosines only are angles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import symengine as se

from voronec.equations.program import Block, Program, compile_program
from voronec.motion.steppers.run import Problem

__all__ = [
    "ORDINARY",
    "SMALL",
    "angles_among",
    "natural_units",
    "units_next_to",
    "units_of_many",
]


SMALL, ORDINARY = 2.0**-24, 2.0**10
"""Sizes between these are ordinary: their unit is 1."""
STILL = 2.0**-40
"""A rate below this part of the largest is mostly rounding, and tells no time."""

Slopes = Callable[[np.ndarray], np.ndarray]
"""Rates (s, n) of states (s, n)."""
NUDGE = 2.0**-48
"""The part of its size by which a state is moved to see what depends on it, and what of a rate is
rounding: little more than rounding itself, so that terms which cancel for every state show too."""


def natural_units(problem: Problem) -> np.ndarray:
    """The units of the states of a problem (n,)."""
    if problem.units is not None:
        return problem.units
    start, values = (np.array([x], dtype=float) for x in (problem.start, problem.parameters))
    return units_of_many(problem.program, start, values)[0]


def units_of_many(program: Program, states: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The units of starts (s, n) with parameters (s, p): 1, or the power of two next to the size.

    The size is |x|, or |x'| over the time in which states change by as much as they are, in the
    median; rates that are rounding do not count, and what is small only because terms cancel has
    the size of these.  Angles matter up to turns only: they have the
    unit 1, and tell a time, that of a radian, only where nothing else does.
    """
    if not states.shape[1]:
        return np.ones(states.shape)
    found = _units_beside(program, states, values, [])
    if (found == 1).all():
        return found
    return _units_beside(
        program, states, values, [*angles_among(program.state, (program.derivative,))]
    )


def _units_beside(
    program: Program, states: np.ndarray, values: np.ndarray, angles: list[int]
) -> np.ndarray:
    """The same where it is known which states are ``angles``."""
    rhs = compile_program(program)[0]

    def slopes(at: np.ndarray) -> np.ndarray:
        rates = [np.asarray(r, dtype=float) for r in rhs(np.float64(0.0), [*at.T], [*values.T])]
        return np.stack([np.broadcast_to(r, len(at)) for r in rates], axis=-1)

    with np.errstate(all="ignore"):
        slope = np.abs(slopes(states))
        # nothing depends on a quadrature, so that its value has no size; its rate has
        held = [s in program.derivative.symbols for s in program.state]
        x = np.where(held, np.abs(states), 0.0)
        own, turning = x.copy(), np.zeros(x.shape, dtype=bool)
        own[:, angles], turning[:, angles] = 1.0, True
        own = np.where(_are_felt(slopes, states, own, turning), own, 0.0)
        moving = _are_moving(own, slope, ~turning)
        moving |= _are_moving(own, slope, turning) & ~moving.any(axis=1, keepdims=True)
        times = np.sort(np.where(moving, own / slope, np.inf), axis=1)
        count, rows = moving.sum(axis=1), np.arange(len(x))
        # of two in the middle the shorter: a size that is too small costs steps, a large one digits
        middle = times[rows, (count - 1) // 2]
        span = np.where(count > 0, middle, 0.0)[:, None]
        expected = np.where(_sound(slope), slope, 0.0)
        # what only slow states let grow large does not where others, angles too, are quick
        quick = _are_moving(own, slope, np.ones(x.shape, dtype=bool))
        briefest = np.where(quick, own / slope, np.inf).min(axis=1, keepdims=True)
        soon = np.maximum(expected * np.minimum(span, briefest), 1.0)
        expected = expected * span
        size = np.maximum(x, np.where(expected > ORDINARY, soon, expected))
        small = (size > 0) & (size < SMALL)
        if small.any():
            balance = span * _balance(slopes, states, own)
            size = np.where(small, np.maximum(size, np.minimum(balance, SMALL)), size)
        far = (size > 0) & ~((size >= SMALL) & (size <= ORDINARY)) & np.isfinite(size)
    far &= np.isfinite(slope).all(axis=1)[:, None]
    far[:, angles] = False
    return np.where(far, _powers_next_to(np.where(far, size, 1.0)), 1.0)


def _powers_next_to(sizes: np.ndarray) -> np.ndarray:
    return np.asarray(np.ldexp(1.0, np.minimum(np.frexp(sizes)[1], np.finfo(float).maxexp - 1)))


def units_next_to(sizes: np.ndarray) -> np.ndarray:
    """The units of states that left theirs: 1 where they are of size 1 up to the largest ordinary,
    and below, where errors have been those of a smaller unit, the next power of two."""
    return np.where((sizes >= 1) & (sizes <= ORDINARY), 1.0, _powers_next_to(sizes))


def _balance(slopes: Slopes, states: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """How much rates (s, n) depend on the states: what is small only because large terms cancel."""
    now, found = slopes(states), np.zeros(states.shape)
    for j in np.flatnonzero(sizes.any(axis=0)):
        beside = states.copy()
        beside[:, j] += NUDGE * sizes[:, j]
        found = np.fmax(found, np.abs(slopes(beside) - now) / NUDGE)
    return found


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
        changed = (np.abs(slopes(without) - now) > NUDGE * size) & sound
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
    found = set(among)
    for block in blocks:
        known: dict[Any, Mapping[Any, int]] = {s: {s: 1} for s in found}
        for name, expr in block.assignments:
            multiples = _multiples(expr, known, found)
            if multiples:
                known[name] = multiples
        for result in block.results:
            found -= set(_multiples(result, known, found))
    return found


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
