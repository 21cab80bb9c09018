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
SPARSE = 4
"""Where there are more periods than so many per instant, they are not all looked at."""
LEAST = 4096


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
    if high - low <= max(LEAST, SPARSE * times.size):
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
    caps = np.array([p.far for p in level.passages])
    steps = np.array([p.way * _floors(p, level, kinds, winding) for p in level.passages])
    sums = []
    for far in (False, True):
        mine = np.cumsum(np.where((caps == far)[:, None], steps, 0), axis=0)
        sums.append((mine + _before(winding, level, kinds, mine[-1], far)).T.ravel())
    inside = [level.inside([1] * (k + 1) + [0] * (count - k - 1)) for k in range(count)]
    near, far_ = (np.tile(column, len(kinds)) for column in zip(*inside, strict=True))
    return Tally(state, near, far_, *(total.astype(float) for total in sums))


def _before(
    winding: Any, level: Passages, kinds: np.ndarray, steps: np.ndarray, far: bool
) -> np.ndarray:
    """What has been gained before each of the periods."""
    count = len(level.passages)
    if kinds[-1] - kinds[0] + 1 == len(kinds):
        start = winding.gained(level, [int(kinds[0])] * count)[far]
        return np.asarray(start + np.concatenate([[0], np.cumsum(steps[:-1])]))
    return np.array([winding.gained(level, [int(j)] * count)[far] for j in kinds])


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
