"""A motion at many times, in doubles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from voronec.elliptic.arguments import Arguments
from voronec.elliptic.batch import TURN, Stretch
from voronec.elliptic.doubles import Doubles, doubles_of
from voronec.elliptic.reduction import Reduction
from voronec.elliptic.workspace import PIECE, Rows, matrix
from voronec.errors import DefinitionError

__all__ = ["Sample", "sample_at"]

BLOCK = 8192
"""Times in a stretch."""
ROWS = 64
"""Arrays of a stretch that are made at once."""


@dataclass(frozen=True, eq=False)
class Sample:
    """The motion at given times; every result is an array of their shape.

    Nothing is computed that is not asked for, and what several results need is kept: up to about
    forty doubles per time. ``each`` keeps nothing, and is the fastest for several results.

    Attributes:
        times: in one dimension.
        shape: of the results.
        model: the motion at no times.
    """

    times: np.ndarray
    shape: tuple[int, ...]
    model: Stretch

    @classmethod
    def of(cls, solution: Any, times: Any) -> Sample:
        """The sample of a solution at times, taken as the doubles they are.

        Raises:
            DefinitionError: a time is not a finite number.
            EngineLimit: a time is more than 2^40 half periods away.
        """
        array = np.asarray(times, dtype=float)
        flat = np.ascontiguousarray(array.ravel())
        latest = max(float(flat.max()), -float(flat.min()), 0.0) if flat.size else 0.0
        if not math.isfinite(latest) or latest != latest:
            raise DefinitionError("a time of a sample is not a finite number")
        return cls(flat, array.shape, _model(doubles_of(solution), latest))

    @property
    def x(self) -> np.ndarray:
        """The variable."""
        return self._join(lambda at: at.x)

    @property
    def rate(self) -> np.ndarray:
        """dx/dt, accurate relative to its size near the turning points."""
        return self._join(lambda at: at.rate)

    def affine(self, at_base: float, at_other: float) -> np.ndarray:
        """An affine function of x from its values at the ends.

        Where those have one sign it is accurate to the last bits, however small.
        """
        return self._join(lambda at: at.affine(at_base, at_other))

    def colatitude(self, south: tuple[float, float], north: tuple[float, float]) -> np.ndarray:
        """The angle in [0, pi] whose cosine l is affine in x, accurate near both poles.

        South and north are the values of ``1 - l`` and ``1 + l`` at base and other, which must
        not be negative: the angle is ``2 atan sqrt((1 - l)/(1 + l))``.
        """
        return self._join(lambda at: at.colatitude(south, north))

    def integral(self, number: int, start: float = 0.0) -> np.ndarray:
        """An integral along the motion: ``start`` at t = 0, continuous, with all its turns."""
        return self._join(lambda at: at.integral(number, start))

    def modulo(self, number: int, start: float = 0.0) -> np.ndarray:
        """The same as an angle in (-pi, pi], as accurate late as early."""
        return self._join(lambda at: at.modulo(number, start))

    def each(self, work: Callable[[Stretch], Sequence[np.ndarray]]) -> tuple[np.ndarray, ...]:
        """Several results at once: what ``work`` makes of a stretch, for all times.

        A ``Stretch`` has the properties and methods of a sample:
        ``sample.each(lambda at: (at.x, at.integral(0), at.modulo(1)))``.
        """
        size = min(BLOCK, self.times.size)
        kept, passing = Rows(ROWS, size), Rows(ROWS, size)
        whole: np.ndarray | None = None
        for part, times in self._parts():
            values = _quietly(work, _at(self.model, times, kept, passing))
            if whole is None:
                whole = matrix(len(values), self.times.size)
            for row, value in zip(whole, values, strict=True):
                row[part] = value
            kept.free()
            passing.free()
        return () if whole is None else tuple(row.reshape(self.shape) for row in whole)

    def _join(self, work: Callable[[Stretch], np.ndarray]) -> np.ndarray:
        whole = self._results.new(self.times.size)
        passing, stretches = self._stretches
        for part, stretch in stretches:
            whole[part] = _quietly(work, stretch)
            passing.free()
        return whole.reshape(self.shape)

    @cached_property
    def _results(self) -> Rows:
        """Memory of results, a piece for several of them."""
        size = self.times.size
        return Rows(max(1, PIECE // size) if size > 4 * BLOCK else 1, size)

    @cached_property
    def _stretches(self) -> tuple[Rows, list[tuple[slice, Stretch]]]:
        size = min(BLOCK, self.times.size)
        many = max(ROWS, PIECE // BLOCK) if self.times.size > 4 * BLOCK else ROWS
        kept, passing = Rows(many, size), Rows(ROWS, size)
        return passing, [
            (part, _at(self.model, times, kept, passing)) for part, times in self._parts()
        ]

    def _parts(self) -> Iterator[tuple[slice, np.ndarray]]:
        for start in range(0, max(self.times.size, 1), BLOCK):
            part = slice(start, start + BLOCK)
            yield part, self.times[part]


def sample_at(solution: Any, times: Any) -> Sample:
    """The sample of a solution at times (see ``Sample.of``)."""
    return Sample.of(solution, times)


def _model(doubles: Doubles, latest: float) -> Stretch:
    """The motion at no times yet, with the values of the integrals at t = 0."""
    here = _bare(doubles, doubles.reduction(latest), latest)
    if len(doubles.origins) < len(here.courses):
        start = _at(
            _bare(doubles, doubles.reduction(0.0), 0.0), np.zeros(1), Rows(ROWS, 1), Rows(ROWS, 1)
        )
        found = []
        for number in range(len(here.courses)):
            radians, turned = (_quietly(work, start) for work in _starts(number))
            found.append((float(radians[0]), float(turned[0]) / TURN))
        doubles.origins[:] = found
    return replace(here, origins=tuple(doubles.origins))


def _starts(number: int) -> tuple[Callable[[Stretch], np.ndarray], ...]:
    return (lambda at: at.integral(number)), (lambda at: at.modulo(number))


def _bare(doubles: Doubles, reduction: Reduction, latest: float) -> Stretch:
    count = len(doubles.constants.rates)
    courses = tuple(doubles.course(number, reduction, latest) for number in range(count))
    arguments = Arguments(doubles, np.zeros(0), reduction, Rows(1, 0), Rows(1, 0))
    return Stretch(doubles, arguments, courses, ((0.0, 0.0),) * count)


def _at(model: Stretch, times: np.ndarray, kept: Rows, passing: Rows) -> Stretch:
    arguments = replace(model.arguments, times=times, kept=kept, passing=passing)
    return replace(model, arguments=arguments)


def _quietly(work: Callable[[Stretch], Any], stretch: Stretch) -> Any:
    """What happens at infinite ratios is meant."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        return work(stretch)
