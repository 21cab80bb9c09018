"""The motion on a grid of times in doubles: nothing is computed that is not asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.closed.bernstein import evaluated
from voronec.closed.reading import reading
from voronec.closed.steady import steadily

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["sampled"]

FINE = 64
"""Half of the bits of what is rounded to doubles."""
STEEP = 1e-2
"""Where the sine of a colatitude read off a turned frame is smaller, balls are asked."""
DIGITS = 20
TURN = 2 * np.pi


def sampled(
    form: ClosedForm, times: Any, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities at times; angles continuous (``whole``) or in (-pi, pi]."""
    given = np.asarray(times, dtype=float)
    grid = np.atleast_1d(given)
    found = steadily(form, grid, names, whole) if form.rests else _moving(form, grid, names, whole)
    if not whole:
        plane = form.quadratures.plane
        straight = plane.place if plane is not None else ()
        turning = {plain_name(q) for q in form.system.coordinates if q not in straight}
        found = {n: wrapped(x) if n in turning else x for n, x in found.items()}
    return {name: found[name].reshape(given.shape) for name in names}


def _moving(
    form: ClosedForm, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    seen = Seen(form, grid, whole)
    found: dict[str, np.ndarray] = {}
    turned = form.attitude is not None and not form.attitude.upright
    in_space = [plain_name(q) for q in form.attitude.coordinates] if form.attitude else []
    if turned and {*names} & {*in_space}:
        found |= _turned(form, seen, grid, whole)
    coordinates = {plain_name(q): q for q in form.system.coordinates}
    for name in names:
        if name in coordinates and name not in found:
            found[name] = seen.coordinate(coordinates[name])
    if {*names} - {*coordinates}:
        found |= seen.velocities()
    return found


@dataclass(frozen=True, eq=False)
class Seen:
    """One grid of a motion, turned upright."""

    form: ClosedForm
    grid: np.ndarray
    whole: bool
    _kept: dict[Any, Any] = field(default_factory=dict)

    @cached_property
    def sample(self) -> Any:
        """The elliptic motion on the grid."""
        return self.form.solution.sample(self.grid)

    def coordinate(self, q: Any) -> np.ndarray:
        """An angle that is an integral, or a colatitude."""
        angles = self.form.quadratures.angles
        if q in angles:
            j = angles.index(q)
            start = self.form.ready.starts[j]
            if self.whole:
                return np.asarray(self.sample.integral(j) + start[0])
            return np.asarray(self.sample.modulo(j) + start[1])
        for i, trace in enumerate(self.form.quadratures.traces):
            if trace.colatitude == q:
                side, turns = self.form.branch(i)
                plain = self.sample.colatitude(*self.form.ready.reach[i])
                return np.asarray(side * plain + turns * TURN if (side, turns) != (1, 0) else plain)
        return self.place[q]

    @cached_property
    def place(self) -> dict[Any, np.ndarray]:
        """On a plane."""
        form, plane = self.form, self.form.quadratures.plane
        assert plane is not None
        start, x = float(form.problem.place(2 * FINE)), self.sample.x
        moved = []
        for i, (a, b, c) in enumerate(form.ready.slides):
            whole = self.sample.integral(len(form.quadratures.angles) + i)
            rest = (x - start) * (a + b * (x + start) / 2 + c * (x * x + x * start + start**2) / 3)
            moved.append(whole + rest)
        first, second = map(float, form.direction(2 * FINE))
        origin = [float(form.exact(q)(2 * FINE)) for q in plane.place]
        return {
            plane.place[0]: origin[0] + first * moved[0] - second * moved[1],
            plane.place[1]: origin[1] + second * moved[0] + first * moved[1],
        }

    def velocities(self) -> dict[str, np.ndarray]:
        """The velocities of the equations, accurate relative to their size near the poles."""
        form, own, x = self.form, self.form.problem.prepared, self.sample.x
        level = [float(c) for c in form.problem.level(128)]
        rates = self._rates()
        values: list[Any] = [*level, x]
        for i in range(len(form.quadratures.traces)):
            south, north = (self.sample.affine(*ends) for ends in form.ready.reach[i])
            offset, slope = form.ready.cosines[i]
            sine = form.branch(i)[0] * np.sqrt(south * north)
            with np.errstate(all="ignore"):
                values += [sine, offset + slope * x, -slope * self.sample.rate / sine]
        values += rates[: len(form.quadratures.angles)]
        values += [self.coordinate(q) for q in reading(own).coordinates]
        values += [evaluated(p, *self._weights) for p in form.ready.polynomials]
        with np.errstate(all="ignore"):
            found = _velocities(own)(*values)
        names = map(plain_name, form.system.velocities)
        return {n: np.broadcast_to(e, self.grid.shape).astype(float)
                for n, e in zip(names, found, strict=True)}  # fmt: skip

    @cached_property
    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Of both ends in x."""
        return self.sample.affine(1.0, 0.0), self.sample.affine(0.0, 1.0)

    def _rates(self) -> list[Any]:
        apart = [self.sample.affine(*ends) for ends in self.form.ready.distances]
        found = []
        for numerator, used in self.form.ready.fractions:
            rate = evaluated(numerator, *self._weights)
            for i in used:
                rate = rate / apart[i]
            found.append(rate)
        return found


def _turned(form: ClosedForm, seen: Seen, grid: np.ndarray, whole: bool) -> dict[str, np.ndarray]:
    """Coordinates in space of a motion that is turned there."""
    own = form.attitude
    assert own is not None
    upright = Seen(form, grid, False)
    upright.__dict__["sample"] = seen.sample
    frame = _frame(own.space)(*(upright.coordinate(q) for q in own.coordinates))
    turn = np.array([float(e) for e in own.turn(128)]).reshape(3, 3)
    entries = [[sum(turn[i, k] * frame[k][j] for k in range(3)) for j in range(3)]
               for i in range(3)]  # fmt: skip
    return read_off(form, entries, grid, whole)


def read_off(
    form: ClosedForm, entries: Any, grid: np.ndarray, whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates in space, from the entries of the frame on a grid; at the few instants at which
    a colatitude is near a pole, and doubles lose digits, from balls."""
    own = form.attitude
    assert own is not None
    read = _coordinates(own.space)(*(entries[i][j] for i in range(3) for j in range(3)))
    found = {
        plain_name(q): np.array(side * e + turns * np.pi)
        for q, e, (side, turns) in zip(own.coordinates, read, own.branches, strict=True)
    }
    colatitudes = {plain_name(t.colatitude) for t in form.quadratures.traces} & {*found}
    near = np.zeros(grid.shape, dtype=bool)
    for name in colatitudes:
        near |= np.abs(np.sin(found[name])) < STEEP
    for place in zip(*np.nonzero(near), strict=True):
        exact = form.enclose(float(grid[place]), DIGITS)
        for name in found:
            found[name][place] = float(exact[name])
    if whole and grid.ndim == 1:
        found |= {n: np.unwrap(x) for n, x in found.items() if n not in colatitudes}
    return found


def wrapped(angle: np.ndarray) -> np.ndarray:
    """In (-pi, pi]."""
    return np.asarray(angle - TURN * np.ceil(angle / TURN - 0.5))


_FUNCTIONS: dict[Any, tuple[Any, Any]] = {}


def _once(owner: Any, what: str, make: Callable[[], Any]) -> Any:
    key = (id(owner), what)
    if key not in _FUNCTIONS or _FUNCTIONS[key][0] is not owner:
        _FUNCTIONS[key] = (owner, make())
    return _FUNCTIONS[key][1]


def _velocities(own: Any) -> Any:
    read = reading(own)
    return _once(
        own,
        "velocities",
        lambda: sp.lambdify(read.symbols, list(read.expressions), "numpy", cse=True),
    )


def _frame(space: Any) -> Any:
    rows = [list(space.frame.row(i)) for i in range(3)]
    return _once(
        space, "frame", lambda: sp.lambdify(tuple(space.coordinates), rows, "numpy", cse=True)
    )


def _coordinates(space: Any) -> Any:
    return _once(
        space, "coordinates",
        lambda: sp.lambdify(tuple(space.entries), list(space.coordinates.values()), "numpy"),
    )  # fmt: skip
