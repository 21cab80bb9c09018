"""At very many times: how often the borders of caps have been passed, and what phi gained there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb

from voronec.closed.floor_sums import certain_floor_sum, scaled
from voronec.closed.passages import Passage, Passages
from voronec.elliptic.roots import Unresolved

__all__ = ["Tally", "tally"]

BITS = 64
"""Of the fraction of a phase: whole numbers of them wrap around by themselves."""
SPARSE = 2000
"""So many periods are looked at, one after the other, in the time that one sum over them takes."""
CHUNK = 1 << 20
"""Periods that are looked at at once."""


@dataclass(frozen=True)
class Tally:
    """States of a motion with respect to the caps, and the state at each time.

    Attributes:
        state: of each time, its number.
        near, far: of each state: whether the contact is in that cap.
        first, last: of each state: whole turns that phi has gained in the near cap and in the far
            one, up to constants.
    """

    state: np.ndarray
    near: np.ndarray
    far: np.ndarray
    first: np.ndarray
    last: np.ndarray


def tally(winding: Any, level: Passages, times: np.ndarray) -> Tally:
    """The states at times.

    Raises:
        Unresolved: more bits are needed.
    """
    count = len(level.passages)
    if level.period is None:
        moments = [float(p.time.mid()) for p in level.passages]
        state = np.searchsorted(moments, times, side="right")
        numbers = [[1] * k + [0] * (count - k) for k in range(count + 1)]
        return _listed(winding, level, state, numbers)
    if not count:
        return _listed(winding, level, np.zeros(times.size, dtype=np.intp), [[]])
    period = float(level.period.mid())
    begin = level.passages[0].time
    windows = np.floor((times - float(begin.mid())) / period)
    rest = times - float(begin.mid()) - windows * period
    state = np.zeros(times.size, dtype=np.intp)
    for passage in level.passages[1:]:
        state += rest >= float((passage.time - begin).mid())
    low, high = (int(e) for e in (windows.min(initial=0), windows.max(initial=0)))
    if high - low <= max(SPARSE, times.size):
        kinds, places = np.arange(low, high + 1), windows.astype(np.intp) - low
    else:
        kinds, places = np.unique(windows.astype(np.int64), return_inverse=True)
    state += count * places.ravel()
    return _periodic(winding, level, state, kinds)


def _listed(
    winding: Any, level: Passages, state: np.ndarray, numbers: Sequence[Sequence[int]]
) -> Tally:
    """Each state by itself, from how many passages of each kind there have been."""
    inside = [level.inside(row) for row in numbers]
    gained = [winding.gained(level, row) for row in numbers]
    near, far = (np.array(column) for column in zip(*inside, strict=True))
    first, last = (np.array(column, dtype=float) for column in zip(*gained, strict=True))
    return Tally(state, near, far, first, last)


def _periodic(winding: Any, level: Passages, state: np.ndarray, kinds: np.ndarray) -> Tally:
    """A state between each passage and the next, in each of the periods ``kinds``."""
    count = len(level.passages)
    before = _before(winding, level, kinds)
    sums = [
        (total + np.cumsum(steps, axis=0)).T.ravel().astype(float)
        for total, steps in zip(before, _steps(winding, level, kinds), strict=True)
    ]
    inside = [level.inside([1] * (k + 1) + [0] * (count - k - 1)) for k in range(count)]
    near, far = (np.tile(column, len(kinds)) for column in zip(*inside, strict=True))
    return Tally(state, near, far, *sums)


def _steps(winding: Any, level: Passages, kinds: np.ndarray) -> list[np.ndarray]:
    """What is gained at each passage of these periods: in the near cap, and in the far one."""
    steps = np.array([p.way * _floors(p, level, kinds, winding) for p in level.passages])
    far = np.array([p.far for p in level.passages])[:, None]
    return [np.where(far, 0, steps), np.where(far, steps, 0)]


def _before(winding: Any, level: Passages, kinds: np.ndarray) -> np.ndarray:
    """What has been gained before each of the periods, which ascend: in both caps."""
    count, found = len(level.passages), []
    for part in np.split(kinds, np.flatnonzero(np.diff(kinds // CHUNK)) + 1):
        first, last = int(part[0]), int(part[-1])
        if last - first > SPARSE * len(part):
            sums = [winding.gained(level, [int(j)] * count) for j in part]
            found.append(np.array(sums, dtype=np.int64).T)
            continue
        start = winding.gained(level, [first] * count)
        steps = _steps(winding, level, np.arange(first, last))
        rows = [np.cumsum([s, *step.sum(axis=0)]) for s, step in zip(start, steps, strict=True)]
        found.append(np.array(rows)[:, part - first])
    return np.concatenate(found, axis=1)


def _floors(passage: Passage, level: Passages, kinds: np.ndarray, winding: Any) -> np.ndarray:
    """``floor(phase + j advance)``, exactly: in whole numbers of 2^-64, and in balls where that
    leaves it open."""
    one = 1 << BITS
    (first, start), (step, rise) = (
        divmod(scaled(value, BITS)[0], one) for value in (passage.phase, level.advance)
    )
    fraction = np.uint64(start) + kinds.astype(np.uint64) * np.uint64(rise)
    carried = (start + kinds * float(rise)) / one - fraction / one
    found = first + kinds * step + np.rint(carried).astype(np.int64)
    error = (np.abs(kinds) + 2).astype(np.uint64)
    for place in np.flatnonzero((fraction < error) | (~fraction < error)):
        j = int(kinds[place])
        sure = certain_floor_sum(1, passage.phase + j * level.advance, arb(0))
        if sure is None:
            raise Unresolved(winding.pole(level, passage, j))
        found[place] = sure
    return np.asarray(found)
