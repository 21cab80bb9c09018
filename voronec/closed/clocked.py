"""The motion on a grid of times in doubles where the quartic is in a time of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import precise
from voronec.closed.bernstein import evaluated
from voronec.closed.clock import pieces
from voronec.closed.reading import reading
from voronec.closed.steady import turned
from voronec.errors import EngineLimit

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["clocked"]

FINE = 192
TURN = 2 * np.pi


def clocked(
    form: ClosedForm, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities; angles continuous (``whole``) or modulo a turn."""
    if form.attitude is not None:
        raise EngineLimit(
            f"system '{form.system.name}': a motion in a time of its own is not turned in space"
        )
    seen = Timed(form, grid.ravel(), whole)
    found: dict[str, np.ndarray] = {}
    coordinates = {plain_name(q): q for q in form.system.coordinates}
    for name in names:
        if name in coordinates:
            found[name] = seen.value(coordinates[name])
    if {*names} - {*coordinates}:
        found |= seen.velocities()
    return {name: x.reshape(grid.shape) for name, x in found.items()}


@dataclass(frozen=True, eq=False)
class Timed:
    """One grid of a motion: whole periods, and the elliptic motion in the one that is left."""

    form: ClosedForm
    grid: np.ndarray
    whole: bool

    @cached_property
    def _instants(self) -> tuple[np.ndarray, np.ndarray]:
        return self.form.clock.inverted(self.grid)

    @cached_property
    def sample(self) -> Any:
        """The elliptic motion, periods taken off."""
        return self.form.solution.sample(self._instants[1])

    @cached_property
    def _ends(self) -> tuple[np.ndarray, np.ndarray]:
        """Shares of both ends in x."""
        return self.sample.affine(1.0, 0.0), self.sample.affine(0.0, 1.0)

    def _valued(self, numbers: Any) -> Any:
        return evaluated(numbers, *self._ends)

    def integral(self, j: int, whole: bool) -> np.ndarray:
        """An integral since the start, or, of an angle, less whole turns that nobody asks for."""
        advances = self.form.solution.constants(FINE).advances
        count, summed = self._instants[0], self.form.clock.summed[j]
        found = summed.at(self._instants[1]) if summed.needed else self.sample.integral(j)
        if advances is None or not count.any():
            return np.asarray(found)
        with precise(FINE):
            advance = advances[j]
            if not whole:
                return np.asarray(found + TURN * turned(advance, count))
            parts = pieces(advance)
        for part in reversed(parts):
            found = found + count * part
        return np.asarray(found)

    def value(self, q: Any) -> np.ndarray:
        """A coordinate as it is asked for."""
        found, plane = self.coordinate(q, self.whole), self.form.quadratures.plane
        if self.whole or (plane is not None and q in plane.place):
            return found
        return np.asarray(found - TURN * np.ceil(found / TURN - 0.5))

    def coordinate(self, q: Any, whole: bool) -> np.ndarray:
        """A colatitude, an angle that is an integral, or a place."""
        motion = self.form.quadratures
        for i, trace in enumerate(motion.traces):
            if trace.colatitude == q:
                side, turns = self.form.branch(i)
                south, north = (self._valued(e) for e in self.form.clock.reach[i])
                return np.asarray(2 * side * np.arctan2(np.sqrt(south), np.sqrt(north))
                                  + turns * TURN)  # fmt: skip
        if q in motion.angles:
            j = motion.angles.index(q)
            return self.integral(j, whole) + self.form.ready.starts[j][0 if whole else 1]
        return self.place[q]

    @cached_property
    def place(self) -> dict[Any, np.ndarray]:
        """On a plane."""
        plane = self.form.quadratures.plane
        assert plane is not None
        count = len(self.form.quadratures.angles)
        moved = [self.integral(count + i, True) + self._slid(i) for i in range(2)]
        first, second = map(float, self.form.direction(FINE))
        origin = [float(self.form.exact(q)(FINE)) for q in plane.place]
        return {
            plane.place[0]: origin[0] + first * moved[0] - second * moved[1],
            plane.place[1]: origin[1] + second * moved[0] + first * moved[1],
        }

    def _slid(self, i: int) -> np.ndarray:
        """What the slope of a place adds: nothing where x has come back."""
        start, x = float(self.form.problem.place(FINE)), self.sample.x
        a, b, c = self.form.ready.slides[i]
        moved = x - start
        total = moved * (a + b * (x + start) / 2 + c * (x * x + x * start + start**2) / 3)
        for place, residues in self.form.problem.others(FINE):
            residue = residues[len(self.form.problem.prepared.rates) + i]
            if residue != 0:
                share = moved / (start - complex(place))
                size = 0.5 * np.log1p(2 * share.real + np.abs(share) ** 2)
                total = total + complex(residue).real * size
                total -= complex(residue).imag * np.arctan2(share.imag, 1 + share.real)
        return np.asarray(total)

    def velocities(self) -> dict[str, np.ndarray]:
        """The velocities of the equations."""
        form, own, x = self.form, self.form.problem.prepared, self.sample.x
        clock, angles = form.clock, len(form.quadratures.angles)
        pace = clock.paces(self.sample)
        values: list[Any] = [*(float(c) for c in form.problem.level(FINE)), x]
        with np.errstate(all="ignore"):
            for i in range(len(form.quadratures.traces)):
                south, north = (self._valued(e) for e in clock.reach[i])
                above, below, bend = (self._valued(e) for e in clock.bends[i])
                sine = form.branch(i)[0] * np.sqrt(south * north) / below
                fall = -bend / below**2 * self.sample.rate / (sine * pace)
                values += [sine, above / below, fall]
            values += [rate / pace for rate in self._rates()[:angles]]
            # less whole turns: the sines of late angles lose nothing
            values += [self.coordinate(q, False) for q in reading(own).coordinates]
            values += [self._valued(p) for p in form.ready.polynomials]
            found = _velocities(own)(*values)
        names = map(plain_name, form.system.velocities)
        return {n: np.broadcast_to(e, self.grid.shape).astype(float)
                for n, e in zip(names, found, strict=True)}  # fmt: skip

    def _rates(self) -> list[Any]:
        apart = [self.sample.affine(*ends) for ends in self.form.ready.distances]
        found = []
        for numerator, used in self.form.ready.fractions:
            rate = self._valued(numerator)
            for i in used:
                rate = rate / apart[i]
            found.append(rate)
        return found


_FUNCTIONS: dict[int, tuple[Any, Any]] = {}


def _velocities(own: Any) -> Any:
    if id(own) not in _FUNCTIONS or _FUNCTIONS[id(own)][0] is not own:
        read = reading(own)
        function = sp.lambdify(read.symbols, list(read.expressions), "numpy", cse=True)
        _FUNCTIONS[id(own)] = (own, function)
    return _FUNCTIONS[id(own)][1]
