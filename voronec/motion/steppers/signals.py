"""Parameters that change in time, and runs that go from one change to the next."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf
from typing import Any

import mpmath
import numpy as np

from voronec.errors import DefinitionError

__all__ = ["Signal", "Signals", "in_kind", "values_along"]


def in_kind(numbers: np.ndarray, kind: Any) -> np.ndarray:
    """Exact numbers (k,) as doubles, or, where ``kind`` says objects, as mpmath's at the precision
    in force."""
    if np.dtype(kind).kind == "O":
        return np.array([exact_mpf(x) for x in numbers], dtype=object)
    return numbers.astype(float)


def exact_mpf(number: Any) -> Any:
    """An mpmath number at the precision in force."""
    if isinstance(number, Fraction):
        return mpmath.mpf(number.numerator) / number.denominator
    return mpmath.mpf(number)


@dataclass(frozen=True)
class Signal:
    """An input as a polynomial about an instant, its coefficients the values of ``parameters``:
    those of the input and of its rates up to ``degree``, and then, above degree 0, the instant.

    Either ``instants`` begin ``pieces``, each with its coefficients, or ``functions`` of the time
    give them at every instant.  Values are known from ``first`` to ``last``; ``kind`` says in words
    what it was given as.
    """

    name: str
    degree: int
    kind: str
    parameters: tuple[str, ...] = ()
    first: float = -inf
    last: float = inf
    instants: tuple[Fraction, ...] = ()
    pieces: tuple[tuple[Fraction, ...], ...] = ()
    functions: tuple[Callable[[float], Any], ...] = ()

    @classmethod
    def of_functions(cls, name: str, functions: tuple[Callable[[float], Any], ...]) -> Signal:
        """A function of Python's, with as many of its rates as are given."""
        return cls(name, len(functions) - 1, "a function of Python's", functions=functions)

    def mend(self, rate: str) -> str:
        """What would bring a rate that is lacking."""
        if self.functions:
            return f"inputs={{'{rate}': ...}} beside it, or an expression of t"
        return "a table of a smoother kind, or an expression of t"

    def on_piece(self, start: float, end: float) -> dict[str, Any]:
        """The parameters between two instants with no other between them."""
        k = bisect_right(self.instants, Fraction(start) / 2 + Fraction(end) / 2) - 1
        k = min(max(k, 0), len(self.pieces) - 1)
        numbers = (*self.pieces[k], *([self.instants[k]] if self.degree else []))
        return dict(zip(self.parameters, numbers, strict=True))

    def at(self, instant: float) -> dict[str, Any]:
        """The parameters at an instant; at a jump, those after it."""
        if not self.functions:
            return self.on_piece(instant, instant)
        numbers = [self._number(f, instant) for f in self.functions]
        return dict(zip(self.parameters, [*numbers, instant][: len(self.parameters)], strict=True))

    def along(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """The same at instants (k,), an array (k,) for each parameter."""
        if self.functions:
            rows = [[*self.at(t).values()] for t in times.tolist()]
        else:
            last = len(self.pieces) - 1
            places = np.clip(np.searchsorted(self._starts, times, side="right") - 1, 0, last)
            since = [(t,) if self.degree else () for t in self.instants]
            rows = [[*self.pieces[k], *since[k]] for k in places]
        table = np.array(rows, dtype=object).reshape(len(times), len(self.parameters))
        return dict(zip(self.parameters, table.T, strict=True))

    @cached_property
    def _starts(self) -> np.ndarray:
        return np.array(list(map(float, self.instants)))

    def _number(self, function: Callable[[float], Any], instant: float) -> float:
        place = f"the input '{self.name}' at t = {instant:.12g}"
        try:
            value = float(function(instant))
        except Exception as error:  # whatever a user's function raises is told as his
            raise DefinitionError(f"{place}: {type(error).__name__}: {error}") from error
        if not np.isfinite(value):
            raise DefinitionError(f"{place} is {value}, which is not finite")
        return value


@dataclass(frozen=True)
class Signals:
    """The parameters that change in time."""

    signals: tuple[Signal, ...]

    @property
    def names(self) -> set[str]:
        """What they are called."""
        return {p for signal in self.signals for p in signal.parameters}

    @property
    def python_signal(self) -> Signal | None:
        """The first one that Python has to be asked for."""
        return next((s for s in self.signals if s.functions), None)

    @property
    def functional(self) -> Signals | None:
        """Those alone that Python has to be asked for; None where there are none."""
        found = tuple(s for s in self.signals if s.functions)
        return Signals(found) if found else None

    def knots(self, start: float, end: float) -> list[float]:
        """The instants of change strictly between two others, in the order of a run."""
        found = {float(t) for s in self.signals for t in s.instants}
        low, high = min(start, end), max(start, end)
        return sorted((t for t in found if low < t < high), reverse=end < start)

    def on(self, start: float, end: float) -> dict[str, Any]:
        """The values with which a run from one instant to the next change begins."""
        found: dict[str, Any] = {}
        ahead = [*self.knots(start, end), end][0]
        for signal in self.signals:
            found |= signal.at(start) if signal.functions else signal.on_piece(start, ahead)
        return found

    def values_at(self, instant: float) -> dict[str, Any]:
        """The values that Python gives at an instant."""
        signals = (s for s in self.signals if s.functions)
        return {name: x for s in signals for name, x in s.at(instant).items()}

    def without_rates(self, names: Iterable[str]) -> Signal | None:
        """The first function of Python's among parameters that is given without its rate."""
        own = {*names}
        return next(
            (s for s in self.signals if s.functions and not s.degree and own & {*s.parameters}),
            None,
        )

    def along(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """The values at instants (k,), an array (k,) for each parameter, exact where they are."""
        found: dict[str, np.ndarray] = {}
        for signal in self.signals:
            found |= signal.along(np.asarray(times, dtype=float))
        return found


def values_along(
    changing: Signals | None, names: Iterable[str], values: Iterable[Any], times: np.ndarray
) -> list[Any]:
    """Parameters by name at times (k,): those that change as arrays (k,), the others as numbers."""
    along = {} if changing is None else changing.along(times)
    pairs = zip(names, values, strict=True)
    return [in_kind(along[n], times.dtype) if n in along else np.float64(x) for n, x in pairs]
