"""A motion turned upright at many times, in doubles; its coordinates in space, off its frame."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.closed.balls import enclose_state
from voronec.closed.compiled_motion import reading_of, velocities_in_doubles
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.problem import exact_instant
from voronec.closed.ratio import evaluate_form
from voronec.closed.rounded_constants import rounded_constants
from voronec.closed.winding import winding_of

__all__ = ["BLOCK", "UprightView", "read_circles", "read_frame", "wrap_angle"]

TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class UprightView:
    """Coordinates and velocities of a motion turned upright.

    Attributes:
        form: the motion.
        at: the elliptic motion, a ``Stretch`` of a sample.
        whole: whether angles are continuous, else in (-pi, pi].
        shifted: whether continuous angles start in (-pi, pi], whole turns less than they do.
    """

    form: InvertedMotion
    at: Any
    whole: bool
    shifted: bool = False

    def rows(self, plain: Sequence[str], circles: Sequence[Any]) -> list[np.ndarray]:
        """Coordinates and velocities by name, then cosine and sine of each of ``circles``."""
        coordinates = {plain_name(q): q for q in self.form.system.coordinates}
        found = [
            self.coordinate(coordinates[n]) if n in coordinates else self.velocities[n]
            for n in plain
        ]
        # continuous angles have lost digits late; those that start small are of one period only
        near = self if self.shifted else UprightView(self.form, self.at, False)
        for q in circles:
            angle = near.coordinate(q)
            found += [np.cos(angle), np.sin(angle)]
        return found

    def coordinate(self, q: Any) -> np.ndarray:
        """An angle that is an integral, a colatitude, or a place on a plane."""
        form, angles = self.form, self.form.quadratures.angles
        if q in angles:
            j = angles.index(q)
            whole, part = rounded_constants(form).starts[j]
            if self.whole:
                return np.asarray(self.at.integral(j, part if self.shifted else whole))
            return np.asarray(self.at.modulo(j, part))
        for i, trace in enumerate(form.quadratures.traces):
            if trace.colatitude == q:
                side, turns = rounded_constants(form).branches[i]
                plain = self.at.colatitude(*rounded_constants(form).reach[i])
                if (side, turns) == (1, 0):
                    return np.asarray(plain)
                moved = side * plain + turns * TURN
                return np.asarray(moved) if self.whole else wrap_angle(moved)
        return self.place[q]

    @cached_property
    def place(self) -> dict[Any, np.ndarray]:
        """On a plane."""
        form, plane, x = self.form, self.form.quadratures.plane, self.at.x
        assert plane is not None
        start, origin, direction = rounded_constants(form).place
        moved = []
        for i, (a, b, c) in enumerate(rounded_constants(form).slides):
            whole = self.at.integral(len(form.quadratures.angles) + i)
            rest = (x - start) * (a + b * (x + start) / 2 + c * (x * x + x * start + start**2) / 3)
            moved.append(whole + rest)
        return plane.at(origin, direction, moved)

    @cached_property
    def velocities(self) -> dict[str, np.ndarray]:
        """The velocities of the equations, accurate relative to their size near the poles."""
        form, own, x = self.form, self.form.problem.prepared, self.at.x
        rates = self._rates()
        values: list[Any] = [*rounded_constants(form).level, x]
        for i in range(len(form.quadratures.traces)):
            south, north = (self.at.affine(*ends) for ends in rounded_constants(form).reach[i])
            offset, slope = rounded_constants(form).cosines[i]
            sine = rounded_constants(form).branches[i][0] * np.sqrt(south * north)
            with np.errstate(all="ignore"):
                values += [sine, offset + slope * x, -slope * self.at.rate / sine]
        values += rates[: len(form.quadratures.angles)]
        values += [self.coordinate(q) for q in reading_of(own).coordinates]
        values += [evaluate_form(p, *self._weights) for p in rounded_constants(form).polynomials]
        with np.errstate(all="ignore"):
            found = velocities_in_doubles(own)(*values)
        names = map(plain_name, form.system.velocities)
        return {n: np.broadcast_to(e, x.shape) for n, e in zip(names, found, strict=True)}

    @cached_property
    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Of both ends in x."""
        return self.at.affine(1.0, 0.0), self.at.affine(0.0, 1.0)

    def _rates(self) -> list[Any]:
        apart = [self.at.affine(*ends) for ends in rounded_constants(self.form).distances]
        found = []
        for numerator, used in rounded_constants(self.form).fractions:
            rate = evaluate_form(numerator, *self._weights)
            for i in used:
                rate = rate / apart[i]
            found.append(rate)
        return found


def wrap_angle(angle: np.ndarray) -> np.ndarray:
    """In (-pi, pi]."""
    return np.asarray(angle - TURN * np.ceil(angle / TURN - 0.5))


STEEP = 1e-2
"""Where the sine of a colatitude read off a frame is smaller, balls are asked: a double that is
right to 8e-16 tell longitudes no better than to 1e-13."""
DIGITS = 20
BLOCK = 8192
"""Instants that are read at once, so few that they stay in the cache."""


def read_circles(
    form: InvertedMotion,
    circles: Sequence[np.ndarray],
    grid: np.ndarray,
    names: Sequence[str],
    moved: Mapping[Any, np.ndarray] | None,
) -> dict[str, np.ndarray]:
    """Coordinates in space from cosines and sines of those of the motion turned upright.

    ``moved`` has longitude and third angle of that, with whole turns, where these are asked for.
    """
    own = form.attitude
    assert own is not None
    read, turn = _reader(own.space), rounded_constants(form).turn
    found = np.empty((len(own.coordinates), grid.size))
    for part in _blocks(grid.size):
        found[:, part] = read(*turn, *(c[part] for c in circles))
    return _on_branches(form, found, grid, names, moved)


def read_frame(
    form: InvertedMotion, entries: Any, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates in space from the entries of the frame there, which turns evenly."""
    own = form.attitude
    assert own is not None
    read = _plain_reader(own.space)
    found = read(*(np.ravel(entries[i][j]) for i in range(3) for j in range(3)))
    flat = np.array([np.broadcast_to(x, grid.size) for x in found], dtype=float)
    settled = _on_branches(form, flat, np.ravel(grid), names, {} if whole else None)
    return {name: x.reshape(grid.shape) for name, x in settled.items()}


def _on_branches(
    form: InvertedMotion,
    found: np.ndarray,
    grid: np.ndarray,
    names: Sequence[str],
    moved: Mapping[Any, np.ndarray] | None,
) -> dict[str, np.ndarray]:
    """On their branches; at the few instants at which a colatitude is near a pole, and doubles
    lose digits, from balls."""
    own = form.attitude
    assert own is not None
    traces = {t.colatitude for t in form.quadratures.traces}
    rows = dict(zip(own.coordinates, found, strict=True))
    near = np.zeros(grid.size, dtype=bool)
    for q in traces & {*rows}:
        for part in _blocks(grid.size):
            place = rows[q][part] / np.pi
            place -= np.rint(place)
            near[part] |= ~(np.abs(place) >= STEEP / np.pi)
    asked = {q: row for q, row in rows.items() if plain_name(q) in names}
    whole = moved is not None and bool({*asked} - traces)
    if moved is not None and whole:
        winding_of(form).unwind(
            grid, moved, {q: row for q, row in asked.items() if q not in traces}
        )
    for (q, row), (side, turns) in zip(rows.items(), own.branches, strict=True):
        if (q in traces or moved is None) and (side, turns) != (1, 0):
            row *= side
            row += turns * np.pi
    for place in np.flatnonzero(near):
        exact = enclose_state(form, exact_instant(float(grid[place])), DIGITS, whole)
        for q, row in asked.items():
            row[place] = float(exact[plain_name(q)])
    if moved is None:
        return {plain_name(q): wrap_angle(row) for q, row in asked.items()}
    return {plain_name(q): row for q, row in asked.items()}


def _blocks(size: int) -> Iterator[slice]:
    return (slice(i, min(i + BLOCK, size)) for i in range(0, size, BLOCK))


def _angle(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """``atan2(y, x)`` in half of the time of numpy's; NaN where both are zero."""
    with np.errstate(all="ignore"):
        found = np.divide(x, y)
    np.arctan(found, out=found)
    return np.asarray(np.subtract(np.copysign(np.pi / 2, y), found, out=found))


def _reader(space: Any) -> Any:
    """From a turn (9, row by row), then cosine and sine of each coordinate, turned upright."""
    return space.memo.once("circles", lambda: _read(space))


def _read(space: Any) -> Any:
    turn, circles = sp.symbols("turn:9", cls=sp.Dummy), []
    meaning: dict[Any, Any] = {}
    for q in space.coordinates:
        cosine, sine = sp.symbols("cosine sine", cls=sp.Dummy)
        circles += [cosine, sine]
        meaning |= {sp.cos(q): cosine, sp.sin(q): sine, q: sp.atan2(sine, cosine)}
    frame = sp.Matrix(3, 3, turn) * space.frame.xreplace(meaning)
    entries = dict(zip(space.entries, frame, strict=True))
    found = [e.xreplace(entries) for e in space.coordinates.values()]
    return sp.lambdify((*turn, *circles), found, [{"arctan2": _angle}, "numpy"], cse=True)


def _plain_reader(space: Any) -> Any:
    return space.memo.once(
        "coordinates",
        lambda: sp.lambdify(tuple(space.entries), list(space.coordinates.values()), "numpy"),
    )  # fmt: skip
