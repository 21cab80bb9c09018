"""Events: instants at which a function of the motion vanishes, and what is kept of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.arguments import COUNT, FLAG, SEVERAL, TEXT, require, takes_fields
from voronec.errors import DefinitionError, quote
from voronec.motion.request import Vocabulary, held_name

__all__ = ["Crossings", "Event", "name_events"]


@takes_fields
@dataclass(frozen=True)
class Event:
    """Where ``function`` passes through zero, or jumps through it.

    ``function`` is a name, a symbol or an expression, as for outputs; ``name`` says how the
    trajectory calls it (by default as the function reads).  ``direction`` 1 asks for passages where
    the function grows with time, -1 for those where it falls, 0 for both.  ``stop`` ends the run at
    the first one.  A zero at the start of the motion is none, nor is one that the function touches
    without a change of sign.
    """

    function: Any
    name: str = ""
    direction: int = 0
    stop: bool = False

    def __post_init__(self) -> None:
        require("event", "name", self.name, TEXT)
        require("event", "stop", self.stop, FLAG)
        if not COUNT.holds(self.direction) or self.direction not in (-1, 0, 1):
            raise DefinitionError(
                f"event '{quote(self.name or self.function)}': direction = "
                f"{quote(self.direction)} must be 1 (upwards), -1 (downwards) or 0 (both)"
            )


@dataclass(frozen=True, eq=False)
class Crossings:
    """The passages of one event: ``t`` (k,), ``state`` (k, n), and outputs by name.

    ``crossings["u"]`` is an array of shape (k,), for coordinates, velocities and the outputs of the
    trajectory.
    """

    t: np.ndarray
    state: np.ndarray
    names: tuple[str, ...]
    series: Mapping[str, np.ndarray]

    def __getitem__(self, key: Any) -> np.ndarray:
        name = held_name(key, (*self.series, *self.names), "the crossings hold")
        if name in self.series:
            return self.series[name]
        return self.state[:, self.names.index(name)]

    def __len__(self) -> int:
        return len(self.t)


def name_events(vocabulary: Vocabulary, events: Any) -> tuple[tuple[Event, ...], dict[str, Any]]:
    """Events with their names filled in, and their functions in the user's symbols by name."""
    single = isinstance(events, str | sp.Basic | Event)
    if not SEVERAL.holds(events) and not isinstance(events, Event):
        raise DefinitionError(f"events = {quote(events)} are no events; give voronec.Event(...)")
    given: Sequence[Any] = (events,) if single else tuple(events)
    named, inside = [], {}
    for item in given:
        event = item if isinstance(item, Event) else Event(item)
        own, function = vocabulary.read_condition(event.function)
        name = event.name or own
        if name in inside:
            raise DefinitionError(
                f"system '{vocabulary.equations.system.name}': two events are called '{name}'; "
                "give Event(..., name=)"
            )
        named.append(Event(event.function, name, event.direction, event.stop))
        inside[name] = function
    return tuple(named), inside
