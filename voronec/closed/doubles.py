"""The motion on a grid of times in doubles: nothing is computed that is not asked for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed.clocked import clocked
from voronec.closed.seen import Seen, wrapped
from voronec.closed.steady import steadily
from voronec.closed.tables import tabulated
from voronec.closed.turned import read_circles
from voronec.reading import doubles

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["sampled"]


def sampled(
    form: ClosedForm, times: Any, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    """Coordinates and velocities at times; angles continuous (``whole``) or in (-pi, pi]."""
    given = doubles(times, "times")
    grid = given.ravel()
    found = _resting(form, grid, names, whole) if form.rests else _moving(form, grid, names, whole)
    return {name: found[name].reshape(given.shape) for name in names}


def _resting(
    form: ClosedForm, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    found = steadily(form, grid, names, whole)
    if whole:
        return found
    plane = form.quadratures.plane
    straight = plane.place if plane is not None else ()
    turning = {plain_name(q) for q in form.system.coordinates if q not in straight}
    return {n: wrapped(x) if n in turning else x for n, x in found.items()}


def _moving(
    form: ClosedForm, grid: np.ndarray, names: Sequence[str], whole: bool
) -> dict[str, np.ndarray]:
    if form.quadratures.clock != 1:
        return clocked(form, grid, names, whole)
    own = form.attitude
    in_space = () if own is None or own.upright else own.coordinates
    circles = tuple(q for q in in_space if {*names} & {plain_name(q) for q in in_space})
    plain = [n for n in names if n not in {plain_name(q) for q in circles}]
    winding = _winding(form, circles, names) if whole else ()
    turning = [*plain, *map(plain_name, winding)]
    rows = tabulated(form, grid, turning, circles, whole)
    if rows is None:
        sample = form.solution.sample(grid)
        rows = sample.each(lambda at: Seen(form, at, whole).rows(turning, circles))
    found = dict(zip(plain, rows, strict=False))
    if circles:
        moved = dict(zip(winding, rows[len(plain) : len(turning)], strict=True)) if whole else None
        found |= read_circles(form, rows[len(turning) :], grid, names, moved)
    return found


def _winding(form: ClosedForm, circles: Sequence[Any], names: Sequence[str]) -> tuple[Any, ...]:
    """The coordinates whose whole turns, of the motion turned upright, tell those in space."""
    traced = {t.colatitude for t in form.quadratures.traces}
    return form.winding.names if {*names} & {plain_name(q) for q in {*circles} - traced} else ()
