"""The motion on a grid of times where the variable rests: angles grow evenly, the frame turns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import ball, precise
from voronec.closed.reading import reading

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
    plane, found = form.quadratures.plane, {}
    straight = plane.place if plane is not None else ()
    for q, rate in zip(system.coordinates, form.steady(BITS), strict=True):
        if whole or q in straight:
            found[plain_name(q)] = float(given[q]) + float(rate) * grid
        else:
            with precise(BITS):
                turn = _part(given[q])
            found[plain_name(q)] = 2 * np.pi * turned(rate, grid) + turn
    if form.wheels:
        from voronec.closed.wheel import rolled

        found |= {plain_name(q): x for q, x in rolled(form, grid).items()}
    found |= _velocities(form, grid, given)
    own = form.attitude
    in_space = {plain_name(q) for q in own.coordinates} if own is not None else set()
    if own is not None and not own.upright and in_space & {*names}:
        from voronec.closed.turned import read_frame

        start = np.array([float(e) for e in own.start(BITS)[0]]).reshape(3, 3)
        found |= read_frame(form, _frames(start, own.spin(BITS), grid), grid, names, whole)
    return found


def _velocities(
    form: ClosedForm, grid: np.ndarray, given: Mapping[Any, Any]
) -> dict[str, np.ndarray]:
    """Constant, where no moving coordinate is in them."""
    names = list(map(plain_name, form.system.velocities))
    values = [given[v] for v in form.system.velocities]
    read = reading(form.problem.prepared)
    if read.coordinates:
        rates = dict(zip(form.system.coordinates, form.steady(BITS), strict=True))
        with precise(BITS):
            moved: dict[Any, Any] = dict.fromkeys(read.coordinates, ball(0))
            start = [_part(given[q]) for q in read.coordinates]
            numbers: list[Any] = [float(x) for x in form.resting(moved, BITS)]
        for q, turn in zip(read.coordinates, start, strict=True):
            numbers[read.symbols.index(q)] = 2 * np.pi * turned(rates[q], grid) + turn
        values = sp.lambdify(read.symbols, list(read.expressions), "numpy", cse=True)(*numbers)
    return {n: np.broadcast_to(x, grid.shape).astype(float) if np.ndim(x) else
            np.full(grid.shape, float(x)) for n, x in zip(names, values, strict=True)}  # fmt: skip


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
