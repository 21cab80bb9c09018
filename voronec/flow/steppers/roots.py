"""Where functions change sign within one step, on its dense output."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.flow.events import Event

if TYPE_CHECKING:
    from voronec.flow.steppers.marching import Stride

__all__ = ["crossings", "root"]

LOOKS = 8
"""Parts of a step at whose ends the functions are looked at."""
TOUCH = 0.1
"""Where a parabola predicts a least value below this part of what is seen, the least value between
two looks is computed: there may be two zeros there."""
TRIES = 200
NARROWINGS = 40
GOLDEN = 0.381966


def crossings(
    events: Mapping[int, Event], levels: Callable[..., np.ndarray], stride: Stride
) -> list[tuple[Any, Event]]:
    """Times at which events happen within a step, in the order of the motion.

    ``events`` are given by the columns of their ``levels``.
    """
    start, end = stride.start, stride.end
    times = np.array([start + (end - start) * i / LOOKS for i in range(LOOKS)] + [end])
    values = levels(times, stride.at(times))
    found = []
    for column, event in events.items():

        def level(time: Any, column: int = column) -> Any:
            moment = np.array([time], dtype=times.dtype)
            return levels(moment, stride.at(moment))[0, column]

        for i in range(LOOKS):
            bracket = [(times[i], values[i, column]), (times[i + 1], values[i + 1, column])]
            if _may_touch(values[:, column], i) and (turn := _turn(level, *bracket)):
                bracket.insert(1, turn)
            for (a, before), (b, after) in pairwise(bracket):
                if _crosses(before, after, event.direction if end > start else -event.direction):
                    found.append((root(level, a, before, b, after), event))
    return sorted(found, key=lambda pair: abs(pair[0] - start))


def _crosses(before: Any, after: Any, direction: int) -> bool:
    """A zero counts for the part of a step that it ends."""
    upwards = before < 0 <= after and direction >= 0
    downwards = before > 0 >= after and direction <= 0
    return bool(upwards or downwards)


def _may_touch(values: np.ndarray, i: int) -> bool:
    """Whether a function of one sign may reach zero between looks i and i + 1: the parabola through
    three looks has its least value there, close to zero or beyond."""
    left, right = values[i], values[i + 1]
    if left == 0 or right == 0 or (left > 0) != (right > 0):
        return False
    sign = 1 if left > 0 else -1
    for k in (max(i - 1, 0), min(i, len(values) - 3)):
        a, b, c = (float(sign * v) for v in values[k : k + 3])
        bend, slope = (a - 2 * b + c) / 2, (c - a) / 2
        place = k + 1 - slope / (2 * bend) if bend > 0 else np.inf
        if i - TOUCH <= place <= i + 1 + TOUCH:
            return b - slope**2 / (4 * bend) < TOUCH * max(a, b, c)
    return False


def _turn(function: Callable[[Any], Any], start: Any, end: Any) -> Any:
    """A point between two where the function has the other sign, or None where it keeps its own."""
    (a, value), (b, _) = start, end
    sign = 1 if value > 0 else -1
    c, d = a + (b - a) * GOLDEN, b - (b - a) * GOLDEN
    low, high = function(c), function(d)
    for _ in range(NARROWINGS):
        for place, level in ((c, low), (d, high)):
            if sign * level <= 0:
                return place, level
        if sign * low < sign * high:
            b, d, high = d, c, low
            c = a + (b - a) * GOLDEN
            low = function(c)
        else:
            a, c, low = c, d, high
            d = b - (b - a) * GOLDEN
            high = function(d)
    return None


def root(function: Callable[[Any], Any], a: Any, left: Any, b: Any, right: Any) -> Any:
    """A zero between a and b, where the function has values of different signs, to the last digits
    of the numbers in use: secants that give way to bisection."""
    best = b
    for count in range(TRIES):
        if right == 0 or a == b:
            return b
        middle = b - right * (b - a) / (right - left) if count % 3 < 2 else a + (b - a) / 2
        if not min(a, b) < middle < max(a, b):
            middle = a + (b - a) / 2
        if middle in (a, b) or middle == best:
            return middle
        best, value = middle, function(middle)
        if value == 0:
            return middle
        if (value > 0) == (right > 0):
            b, right, left = middle, value, left / 2
        else:
            a, left, right = middle, value, right / 2
    return best
