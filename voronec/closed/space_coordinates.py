"""Coordinates in space of a motion that is turned there, read off its frame on a grid of times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.closed.balls import enclose_state
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.request import exact_instant
from voronec.closed.rounded_constants import rounded_constants
from voronec.closed.upright_view import wrap_angle
from voronec.closed.winding import winding_of

__all__ = ["BLOCK", "read_circles", "read_frame"]

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
