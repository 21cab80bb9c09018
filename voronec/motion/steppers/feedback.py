"""Controllers: inputs that a function of Python's gives from the time and the state.

A controller that is sampled is asked at instants, and its values are held in between; one that is
continuous is asked wherever a method looks.  A ``Feedback`` is one of them in one run.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

MEND = "mend the controller, or end the run before that"
"""What helps where a controller gave no value."""

StateView = Callable[[float, Sequence[float], Sequence[float]], Mapping[str, float]]
"""From a time, a state (n,) and the parameters of a program to what a controller is told."""


class ControllerFailure(Exception):
    """A controller gave no value, for a reason in words."""


@dataclass(eq=False)
class Feedback:
    """The controller ``function(t, state)`` of the input ``name`` in one run.

    A sampled one is asked at the ``instants``, and ``values`` are what it gave at the first of
    them; a continuous one has none.  ``motion`` gives what it
    is told at times (k,) of a run that is over.
    """

    name: str
    function: Callable[[float, Mapping[str, float]], Any]
    instants: tuple[float, ...] = ()
    values: list[float] = field(default_factory=list)
    motion: Callable[[np.ndarray], Sequence[Mapping[str, float]]] | None = None

    @property
    def is_sampled(self) -> bool:
        """Whether its values are held between instants."""
        return bool(self.instants)

    def value(self, instant: float, state: Mapping[str, float]) -> float:
        """What it gives; ``ControllerFailure`` for what is no finite number."""
        place = f"the controller of '{self.name}' at t = {instant:.12g}"
        try:
            given = self.function(instant, state)
            number = np.asarray(given, dtype=float)
        except Exception as error:  # whatever a user's function raises is told as his
            raise ControllerFailure(f"{place} raises {type(error).__name__}: {error}") from error
        if number.ndim:
            shape = " x ".join(map(str, number.shape))
            raise ControllerFailure(f"{place} returns an array of {shape}, not one number")
        if not np.isfinite(number):
            raise ControllerFailure(f"{place} returns {given}, which is not finite")
        return float(number)

    def sample(self, instant: float, state: Callable[[], Mapping[str, float]]) -> None:
        """Ask it, where it is due at an instant."""
        done = len(self.values)
        if done < len(self.instants) and self.instants[done] <= instant:
            self.values.append(self.value(instant, state()))

    def along(self, times: np.ndarray) -> np.ndarray:
        """Its values at times (k,) of a run that is over; nan where none is known."""
        if self.is_sampled and self.values:
            places = np.searchsorted(self.instants[: len(self.values)], times, side="right") - 1
            return np.array(self.values)[np.maximum(places, 0)]
        if self.motion is None:
            return np.full(len(times), np.nan)
        values = np.full(len(times), np.nan)
        for k, state in enumerate(self.motion(times)):
            with suppress(ControllerFailure):  # the run has told of it, or did not ask there
                values[k] = self.value(float(times[k]), state)
        return values

    def at(self, instant: float) -> float:
        """The value that a sampled one holds at an instant."""
        known = bisect_right(self.instants, instant, hi=len(self.values))
        return self.values[max(known - 1, 0)] if self.values else 0.0
