"""The motion on a grid of times where the variable rests: angles grow evenly, the frame turns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import ball, precise

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["steadily"]

BITS = 256
PIECE = 26
"""Bits of the pieces of a factor: products of two are exact."""
SPLIT = float(2**27 + 1)


def steadily(
    form: ClosedForm, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities; angles continuous (``whole``) or modulo a turn."""
    system, problem = form.system, form.problem
    given = dict(zip(problem.prepared.inputs, problem.given(BITS), strict=True))
    found = {}
    for q, rate in zip(system.coordinates, form.steady(BITS), strict=True):
        if whole:
            found[plain_name(q)] = float(given[q]) + float(rate) * grid
        else:
            with precise(BITS):
                turn = _part(given[q])
            found[plain_name(q)] = 2 * np.pi * turned(rate, grid) + turn
    for v in system.velocities:
        found[plain_name(v)] = np.full(grid.shape, float(given[v]))
    own = form.attitude
    in_space = {plain_name(q) for q in own.coordinates} if own is not None else set()
    if own is not None and not own.upright and in_space & {*names}:
        from voronec.closed.doubles import read_off

        start = np.array([float(e) for e in own.start(BITS)[0]]).reshape(3, 3)
        found |= read_off(form, _frames(start, own.spin(BITS), grid), grid, whole)
    return found


def _part(angle: Any) -> float:
    """An angle modulo a turn."""
    turn = 2 * ball(1).pi()
    return float(angle - turn * round(float(angle / turn)))


def turned(rate: Any, grid: np.ndarray) -> np.ndarray:
    """rate t in turns, less whole ones, however late: products of short pieces are exact."""
    with precise(BITS):
        rest, pieces = rate / (2 * ball(1).pi()), []
        for _ in range(4):
            size = float(abs(rest))
            if not size:
                break
            unit = 2.0 ** (np.frexp(size)[1] - PIECE)
            piece = round(float(rest) / unit) * unit
            pieces.append(piece)
            rest = rest - ball(piece)
    high = grid * SPLIT
    high = high - (high - grid)
    total = np.zeros(grid.shape)
    for piece in pieces:
        for part in (high, grid - high):
            product = piece * part
            total += product - np.rint(product)
    return np.asarray(total - np.rint(total))


def _frames(start: np.ndarray, spin: Any, grid: np.ndarray) -> Any:
    """E0 exp(t Omega^) on the grid, entries as arrays."""
    with precise(BITS):
        squared = sum((c * c for c in spin), ball(0))
        size = squared.sqrt() if squared > 0 else ball(0)
        axis = [float(c / size) for c in spin] if size > 0 else [0.0, 0.0, 1.0]
    angle = 2 * np.pi * turned(size, grid) if size > 0 else np.zeros(grid.shape)
    a, b, c = axis
    cross = start @ np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    double = cross @ np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    sine, rest = np.sin(angle), 2 * np.sin(angle / 2) ** 2
    return [[start[i, j] + sine * cross[i, j] + rest * double[i, j] for j in range(3)]
            for i in range(3)]  # fmt: skip
