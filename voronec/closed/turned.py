"""Coordinates in space of a motion that is turned there, read off its frame on a grid of times."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.closed.seen import once, wrapped

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["BLOCK", "read_circles", "read_frame"]

STEEP = 1e-2
"""Where the sine of a colatitude read off a frame is smaller, balls are asked: a double that is
right to 8e-16 tell longitudes no better than to 1e-13."""
DIGITS = 20
BLOCK = 8192
"""Instants that are read at once, so few that they stay in the cache."""
TURN = 2 * np.pi


def read_circles(
    form: ClosedForm, circles: Sequence[np.ndarray], grid: np.ndarray, whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates in space from cosines and sines of those of the motion turned upright."""
    own = form.attitude
    assert own is not None
    read, turn = _reader(own.space), form.ready.turn
    found = np.empty((len(own.coordinates), grid.size))
    for part in _blocks(grid.size):
        found[:, part] = read(*turn, *(c[part] for c in circles))
    return _settled(form, found, grid, whole)


def read_frame(
    form: ClosedForm, entries: Any, grid: np.ndarray, whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates in space from the entries of the frame there."""
    own = form.attitude
    assert own is not None
    read = _plain_reader(own.space)
    found = read(*(np.ravel(entries[i][j]) for i in range(3) for j in range(3)))
    found = _settled(form, np.array(found), np.ravel(grid), whole)
    return {name: x.reshape(grid.shape) for name, x in found.items()}


def _settled(
    form: ClosedForm, found: np.ndarray, grid: np.ndarray, whole: bool
) -> dict[str, np.ndarray]:
    """On their branches; at the few instants at which a colatitude is near a pole, and doubles
    lose digits, from balls."""
    own = form.attitude
    assert own is not None
    names = [plain_name(q) for q in own.coordinates]
    traces = {plain_name(t.colatitude) for t in form.quadratures.traces}
    near = np.zeros(grid.size, dtype=bool)
    for name, row, (side, turns) in zip(names, found, own.branches, strict=True):
        for part in _blocks(grid.size):
            if name in traces:
                place = row[part] / np.pi
                place -= np.rint(place)
                near[part] |= ~(np.abs(place) >= STEEP / np.pi)
            if (side, turns) != (1, 0):
                row[part] = side * row[part] + turns * np.pi
    for place in np.flatnonzero(near):
        exact = form.enclose(float(grid[place]), DIGITS)
        found[:, place] = [float(exact[name]) for name in names]
    for name, row in zip(names, found, strict=True):
        if not whole:
            row[:] = wrapped(row)
        elif name not in traces:
            _unwrap(row)
    return dict(zip(names, found, strict=True))


def _unwrap(angle: np.ndarray) -> None:
    """Made continuous in place: from instant to instant the nearest angle is taken."""
    last, turns = angle[0] if angle.size else 0.0, 0.0
    for part in _blocks(angle.size):
        piece = angle[part]
        steps = np.empty(piece.size)
        np.subtract(piece[1:], piece[:-1], out=steps[1:])
        steps[0], last = piece[0] - last, piece[-1]
        steps /= TURN
        np.rint(steps, out=steps)
        places = np.flatnonzero(steps)
        gained = turns + np.concatenate([[0.0], np.cumsum(steps[places])])
        lengths = np.diff(places, prepend=0, append=piece.size)
        if gained.any():
            piece -= np.repeat(TURN * gained, lengths)
        turns = gained[-1]


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
    return once(space, "circles", lambda: _read(space))


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
    return once(
        space, "coordinates",
        lambda: sp.lambdify(tuple(space.entries), list(space.coordinates.values()), "numpy"),
    )  # fmt: skip
