"""A motion at very many times: what repeats itself is tabulated over one period, once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed.reading import reading
from voronec.closed.turned import BLOCK

if TYPE_CHECKING:
    from voronec.closed.form import ClosedForm

__all__ = ["tabulated"]

MANY = 10_000
"""Times from which on a table is worth making."""
TURN = 2 * np.pi


def tabulated(
    form: ClosedForm, grid: np.ndarray, plain: Sequence[str], circles: Sequence[Any], whole: bool
) -> Sequence[np.ndarray] | None:
    """What ``Seen.rows`` gives, by a table; None where that is of no use."""
    if grid.size < MANY or not _repeats(form, plain):
        return None
    sample = form.solution.sample(grid)
    angles = {plain_name(q): j for j, q in enumerate(form.quadratures.angles)}
    used = [angles[n] for n in (*plain, *map(plain_name, circles)) if n in angles]
    if any(sample.model.courses[j].exact for j in used):
        return None
    panels = form.ready.panels(tuple(plain), tuple(circles), sample.model)
    if panels is None:
        return None
    counts, rows = panels.at(sample.times, sample.model.arguments.reduction)
    for name, row in zip(plain, rows, strict=False):
        if name in angles:
            first, part = form.ready.starts[angles[name]]
            if whole and first != part:
                row += first - part
            _grown(row, counts, sample.model.courses[angles[name]], whole)
    for i, q in enumerate(circles):
        if plain_name(q) in angles:
            first = len(plain) + 2 * i
            course = sample.model.courses[angles[plain_name(q)]]
            _spun(rows[first], rows[first + 1], counts, course)
    return list(rows)


def _repeats(form: ClosedForm, plain: Sequence[str]) -> bool:
    """Whether all that is asked for repeats itself, or grows by the same in each half period."""
    motion = form.quadratures
    traced = {t.colatitude for t in motion.traces}
    known = {plain_name(q) for q in (*traced, *motion.angles)}
    velocities = {plain_name(v) for v in form.system.velocities}
    asked = {*plain} - known
    if not asked <= velocities:
        return False
    return not asked or {*reading(form.problem.prepared).coordinates} <= traced


def _grown(row: np.ndarray, counts: np.ndarray, course: Any, whole: bool) -> None:
    """The angle with what it has gained in whole half periods."""
    for part in _blocks(row.size):
        value, count = row[part], counts[part]
        if whole:
            # the only rounding of the size of the value is the last
            value += count * course.second
            value += count * course.first
        else:
            value /= TURN
            value += _turned(count, course)
            value -= np.ceil(value - 0.5)
            value *= TURN


def _spun(cosine: np.ndarray, sine: np.ndarray, counts: np.ndarray, course: Any) -> None:
    """Cosine and sine of the angle with what it has gained."""
    least = counts.min()
    kinds = int(counts.max() - least) + 1
    few = 2 * kinds < counts.size
    if few:
        angles = TURN * _turned(np.arange(kinds) + least, course)
        known = np.cos(angles), np.sin(angles)
    for part in _blocks(counts.size):
        if few:
            places = (counts[part] - least).astype(np.intp)
            c, s = (table.take(places) for table in known)
        else:
            angles = TURN * _turned(counts[part], course)
            c, s = np.cos(angles), np.sin(angles)
        before = cosine[part].copy()
        cosine[part] *= c
        cosine[part] -= sine[part] * s
        sine[part] *= c
        sine[part] += before * s


def _turned(count: np.ndarray, course: Any) -> np.ndarray:
    """The gain in turns, less whole ones."""
    total = np.zeros(count.size)
    for share in course.turns:
        if share:
            more = count * share
            more -= np.rint(more)
            total += more
    return total


def _blocks(size: int) -> Iterator[slice]:
    return (slice(i, i + BLOCK) for i in range(0, size, BLOCK))
