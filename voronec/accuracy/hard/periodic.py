"""A periodic motion over many periods: one period in many digits, the rest counted.

x(n P + t) = x(t) and Phi(n P + t, 0) = Phi(t, 0) Phi(P, 0)^n.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.accuracy.hard.closed import PreciseProblem
from voronec.accuracy.hard.conditioning import output_sizes, sizes, times
from voronec.accuracy.hard.multiprecision import Passage, Reel
from voronec.errors import IntegrationError

__all__ = ["Folded", "folded", "period"]

CLOSED = 1e-18
"""How far the state may be from its start after one period."""
ITERATIONS = 12
LOOKS = 400
"""Into how many parts a stretch of time is cut where the period is looked for."""


def period(machine: Reel, names: tuple[str, ...], vanishing: str, stretch: float) -> Any:
    """A period, when every state is back; one must be shorter than ``stretch``.

    ``vanishing`` is the state that vanishes at the start; its zeros are refined by Newton's method.
    Raises ``IntegrationError`` where there is none.
    """
    place = names.index(vanishing)
    machine.rewind(machine.number(0.0), machine.begin)
    before, last = machine.begin, 0.0
    for t in np.linspace(0.0, stretch, LOOKS + 1)[1:]:
        state, _, _ = machine.advance(machine.number(t))
        if last > 0 and float(before[place]) * float(state[place]) <= 0:
            zero, there = _zero(machine, place, machine.number(last), before)
            apart = (abs(float(a - b)) for a, b in zip(there, machine.begin, strict=True))
            if max(apart) < CLOSED:
                return zero
            machine.rewind(machine.number(t), state)
        before, last = state, t
    raise IntegrationError(f"no period was found up to t = {stretch:g}")


def _zero(machine: Reel, place: int, t: Any, state: np.ndarray) -> tuple[Any, np.ndarray]:
    """The next zero of a component after a time, and the state there."""
    ahead = machine.number(1e-9)
    for _ in range(ITERATIONS):
        machine.rewind(t, state)
        beyond, _, _ = machine.advance(t + ahead)
        change = -state[place] * ahead / (beyond[place] - state[place])
        if abs(float(change)) < 1e-29 * (1.0 + abs(float(t))):
            break
        machine.rewind(t, state)
        t = t + change
        state, _, _ = machine.advance(t)
    return t, state


@dataclass(frozen=True)
class Folded:
    """One period of a motion, and where in which period the wanted instants lie.

    ``turns[j]`` whole periods lie before the j-th instant, and the rest of it is the time
    ``places[j]`` of ``passage``, which ends with the period.
    """

    passage: Passage
    turns: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def outputs(self) -> np.ndarray:
        """The outputs at the wanted instants."""
        return self.passage.outputs[list(self.places)]

    def condition_numbers(self, problem: PreciseProblem) -> np.ndarray:
        """kappa as in ``conditioning``, errors made after 0, 1, 2, 4, ... and all periods."""
        passage, scale = self.passage, output_sizes(self.passage.outputs)
        size = sizes(problem, passage.states)
        constants = np.abs(np.array([float(x) for x in problem.values]))
        since = _since_start(passage)
        width = passage.states.shape[1]
        result = np.empty(self.outputs.shape)
        for j, (turns, place) in enumerate(zip(self.turns, self.places, strict=True)):
            whole = times(since[place], _power(since[-1], turns))
            slope = times(passage.gradients[place], whole[:width, width:])
            slope = slope + passage.by_parameters[place]
            made = np.zeros(len(scale))
            for back in {0, *(2**i for i in range(turns.bit_length()) if 2**i <= turns), turns}:
                reach = times(since[place], _power(since[-1], back))[:width, :width]
                reach = times(passage.gradients[place], reach)
                made = np.maximum(made, np.abs(reach.astype(float)) @ size)
            data = np.abs(slope.astype(float)) @ constants
            result[j] = 1.0 + (data + made) / scale
        return result


def folded(reel: Reel, length: Any, grid: np.ndarray) -> Folded:
    """One period through all that is left of the wanted times when whole periods are taken off."""
    turns = [int(float(t) // float(length)) for t in grid]
    rest = [reel.number(float(t)) - n * length for t, n in zip(grid, turns, strict=True)]
    stops: list[Any] = []  # numbers of heyoka have an order, but no hash
    for t in sorted([reel.number(0.0), *rest, length]):
        stops += [] if stops and stops[-1] == t else [t]
    passage = reel.follow(np.array(stops, dtype=object))
    return Folded(passage, tuple(turns), tuple(stops.index(t) for t in rest))


def _since_start(passage: Passage) -> list[np.ndarray]:
    """d (state, parameters) at every instant / d the same at the start."""
    n, p = passage.states.shape[1], passage.drives.shape[2]
    found = [np.eye(n + p, dtype=int).astype(object)]
    for step, drive in zip(passage.steps, passage.drives, strict=True):
        whole = np.eye(n + p, dtype=int).astype(object)
        whole[:n, :n], whole[:n, n:] = step, drive
        found.append(times(whole, found[-1]))
    return found


def _power(matrix: np.ndarray, exponent: int) -> np.ndarray:
    """A power by repeated squaring, no digit lost to doubles."""
    result = np.eye(len(matrix), dtype=int).astype(object)
    while exponent:
        if exponent & 1:
            result = times(result, matrix)
        matrix, exponent = times(matrix, matrix), exponent >> 1
    return result
