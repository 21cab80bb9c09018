"""Functions of the phase of a periodic motion, as polynomials on panels of its period.

What repeats itself with the period is computed at some thousands of phases, once.  After that
an instant costs one column of a product of small matrices, however hard the functions are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from voronec.elliptic.doubles import QuarticReduction, Rows, matrix
from voronec.elliptic.many_times import TimeStretch

COUNT = 12
"""Coefficients of a polynomial."""
NODES, CHECKS = 16, 9
"""Phases of a panel to which it is fitted, and at which it is tried."""
CELLS = 4096
"""Parts of half a period; a panel is a number of them that is a power of two."""
WIDEST, NARROWEST = 1024, 4
"""Of panels in cells: at first, and where a function that needs narrower ones is given up."""
MOST = 512
"""Panels that are worth their while."""
BOUND = 3e-15
"""Errors relative to the size of a function."""
SIZES = ("own", "turn", "largest")
"""Sizes of functions: the value at each phase; the largest on a panel, or 1 if it is less; the
largest there is."""
BESIDE = 2.0**-10
"""How much farther than half of a half period the panels reach: late times may overshoot."""
BLOCK, GROUP, LONGEST = 4096, 4096, 1 << 15
"""Times that are reduced at once, in one product, and sorted at once."""

Work = Callable[[TimeStretch], Sequence[np.ndarray]]


def _chebyshev() -> np.ndarray:
    """Values at Chebyshev's nodes to coefficients of his polynomials."""
    fit = 2 / NODES * np.cos(np.outer(np.arange(COUNT), (np.arange(NODES) + 0.5) * np.pi / NODES))
    fit[0] /= 2
    return np.asarray(fit)


def _powers() -> np.ndarray:
    """Those to coefficients of powers.  In one step with the others, digits would be lost."""
    transform = np.zeros((COUNT, COUNT))
    for k, unit in enumerate(np.eye(COUNT)):
        row = np.polynomial.chebyshev.cheb2poly(unit)
        transform[: len(row), k] = row
    return transform


FIT, POWER_FORM = _chebyshev(), _powers()
POINTS = np.concatenate(
    [np.cos((np.arange(NODES) + 0.5) * np.pi / NODES), np.cos(np.linspace(0, np.pi, CHECKS))]
)
POWERS = POINTS[NODES:] ** np.arange(COUNT)[:, None]


@dataclass(frozen=True, eq=False)
class Panels:
    """Functions of the phase, tabulated; they are computed afresh where polynomials are no good.

    Attributes:
        model: the motion at no times.
        work: the functions, of a stretch of phases.
        reach: how far phases go from the nearest turning point, in time.
        places: of each cell: its panel; beyond the last one where there is none.
        middles, radii: of the panels.
        coefficients: of the panels, of the functions, ascending.
    """

    model: TimeStretch
    work: Work
    reach: float
    places: np.ndarray
    middles: np.ndarray
    radii: np.ndarray
    coefficients: np.ndarray

    @classmethod
    def of(cls, model: TimeStretch, work: Work, sizes: Sequence[str]) -> Panels | None:
        """Panels for the functions, each with one of ``SIZES``.

        None where the motion has no period, or where most of it is too steep.
        """
        half = model.doubles.constants.half
        if half is None:
            return None
        reach = float(half.mid()) / 2 * (1 + BESIDE)
        places = np.full(2 * CELLS, -1)
        width, todo = WIDEST, np.arange(0, 2 * CELLS, WIDEST)
        panels: list[Any] = []
        largest = np.zeros(len(sizes))
        while len(todo) and width >= NARROWEST and len(todo) + len(panels) <= MOST:
            radius = reach * width / CELLS
            middles = reach * ((todo % CELLS) * 2 + width - CELLS) / CELLS
            rest, late = middles[:, None] + radius * POINTS, todo // CELLS
            values = _phases(model, work, rest.ravel(), np.repeat(late, POINTS.size))
            values = values.reshape(-1, *rest.shape)
            if width == WIDEST:
                largest = np.abs(values).max(axis=(1, 2))
            good, coefficients = _fit(values, np.array(sizes), largest)
            for i in np.flatnonzero(good):
                places[todo[i] : todo[i] + width] = len(panels)
                panels.append((middles[i], radius, coefficients[i]))
            width //= 2
            todo = np.concatenate([todo[~good], todo[~good] + width])
        if not panels or 4 * np.count_nonzero(places < 0) > len(places):
            return None
        odd = np.arange(2 * CELLS) >= CELLS
        places = np.where(places < 0, len(panels) + odd, places).astype(np.int16)
        middles, radii, coefficients = (np.array(part) for part in zip(*panels, strict=True))
        return cls(model, work, reach, places, middles, radii, coefficients)

    def at(self, times: np.ndarray, reduction: QuarticReduction) -> tuple[np.ndarray, np.ndarray]:
        """Whole half periods from the turning point, and the functions, row by row."""
        count = self.coefficients.shape[1]
        number, rows = np.empty(times.size), matrix(count, times.size)
        spare = matrix(count, min(LONGEST, times.size))
        for first in range(0, times.size, LONGEST):
            part = slice(first, first + LONGEST)
            self._fill(times[part], reduction, number[part], rows[:, part], spare)
        return number, rows

    def _fill(
        self,
        times: np.ndarray,
        reduction: QuarticReduction,
        number: np.ndarray,
        rows: np.ndarray,
        spare: np.ndarray,
    ) -> None:
        rest, places = np.empty(times.size), np.empty(times.size, np.int16)
        for first in range(0, times.size, BLOCK):
            part = slice(first, first + BLOCK)
            places[part] = self._panel_of(times[part], reduction, number[part], rest[part])
        order = np.argsort(places, kind="stable")
        rest, end = rest.take(order), 0
        for place, size in enumerate(np.bincount(places).tolist()):
            for first in range(end, end + size, GROUP):
                part = slice(first, min(first + GROUP, end + size))
                self._evaluate(place, rest[part], spare[:, part])
            end += size
        back = np.empty(times.size, np.intp)
        back[order] = np.arange(times.size)
        for source, row in zip(spare, rows, strict=True):
            np.take(source, back, out=row, mode="clip")

    def _panel_of(
        self, times: np.ndarray, reduction: QuarticReduction, number: np.ndarray, rest: np.ndarray
    ) -> np.ndarray:
        """The panel of each time, from which its phase is counted."""
        place = np.empty(times.size)
        reduction.apply(times, number, rest, place)
        cell = rest * (CELLS / (2 * self.reach))
        cell += CELLS / 2
        np.multiply(number, 0.5, out=place)
        place -= np.floor(place)
        place *= 2 * CELLS
        place += cell
        return self.places.take(place.astype(np.intp), mode="clip")

    def _evaluate(self, place: int, rest: np.ndarray, out: np.ndarray) -> None:
        if place >= len(self.middles):
            late = np.full(rest.size, place > len(self.middles))
            out[:] = _phases(self.model, self.work, rest, late)
            return
        powers = np.empty((COUNT, rest.size))
        powers[0] = 1.0
        local = np.subtract(rest, self.middles[place], out=powers[1])
        local /= self.radii[place]
        np.multiply(local, local, out=powers[2])
        np.multiply(powers[1:3], powers[2], out=powers[3:5])
        np.multiply(powers[1:5], powers[4], out=powers[5:9])
        np.multiply(powers[1:4], powers[8], out=powers[9:12])
        np.matmul(self.coefficients[place], powers, out=out)


def _fit(
    values: np.ndarray, sizes: np.ndarray, largest: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Which panels are good, and the coefficients of each, from values at ``POINTS``."""
    # what a function does on the panel, without its size, which would only be rounded
    level = values[..., NODES // 2]
    coefficients = ((values[..., :NODES] - level[..., None]) @ FIT.T) @ POWER_FORM.T
    coefficients[..., 0] += level
    tried = values[..., NODES:]
    error, size = np.abs(coefficients @ POWERS - tried), np.abs(tried)
    wide = size[sizes == "turn"].max(axis=2, keepdims=True)
    size[sizes == "turn"] = np.maximum(wide, 1.0)
    size[sizes == "largest"] = largest[sizes == "largest", None, None]
    with np.errstate(invalid="ignore"):
        good = (error <= BOUND * size).all(axis=(0, 2))
    return good, coefficients.swapaxes(0, 1)


def _phases(model: TimeStretch, work: Work, rest: np.ndarray, late: np.ndarray) -> np.ndarray:
    """The functions at phases: ``rest`` from a turning point, or ``late`` from the next one."""
    size = rest.size
    odd = np.asarray(late != model.doubles.odd, dtype=float)
    arguments = replace(
        model.arguments,
        times=rest,
        memory=Rows(BLOCK // 128, size),
        scratch=Rows(BLOCK // 128, size),
        phases=(np.zeros(size), rest, odd),
    )
    with np.errstate(all="ignore"):
        return np.array(work(replace(model, arguments=arguments)))
