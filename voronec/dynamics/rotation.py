"""Rotation numbers of the points in which a motion passes through a section.

    rho = lim (1/N) sum (theta_(n+1) - theta_n) / 2 pi

theta is the angle of the n-th point about a centre, its steps between 0 and a whole turn.  The mean
is weighted by w(s) = exp(-1/(s (1 - s))), with which it converges faster than any power of N where
the motion is quasi-periodic [DasEtAl2016]; the weighted means of both halves tell how far it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from voronec.algebra.arguments import accepts, instance
from voronec.errors import DefinitionError
from voronec.motion import Section

FEWEST = 20
"""Points that a rotation number takes at least."""


@dataclass(frozen=True, eq=False)
class RotationNumbers:
    """Rotation numbers (s,), one for each start of a section, with ``bars`` (s,): by how far
    the means of all points and of both halves lie apart, large where the motion is chaotic.  They
    are no numbers where a start has too few points, or these do not go once around the centre."""

    values: np.ndarray
    bars: np.ndarray
    centres: np.ndarray


@accepts(section=instance(Section))
def rotation_numbers(
    section: Section, centre: Sequence[float] | None = None
) -> RotationNumbers:  # fmt: skip
    """The rotation numbers of the motions of a section, in the plane of its first two outputs.

    ``centre`` is a point about which the curves go; by default the mean of each motion's points.
    Turns are counted from the first output to the second.  Raises ``DefinitionError`` where the
    section has fewer outputs than two.
    """
    if len(section.outputs) < 2:
        raise DefinitionError("rotation_numbers: the section records one quantity; record two")
    plane = np.stack([section[name] for name in section.outputs[:2]], axis=1).astype(float)
    count = len(section.ends)
    values, bars, centres = np.full(count, np.nan), np.full(count, np.nan), np.zeros((count, 2))
    for i in range(count):
        points = plane[section.start == i]
        if len(points) < FEWEST or not np.ptp(points, axis=0).all():
            continue
        centres[i] = points.mean(axis=0) if centre is None else centre
        angles = np.arctan2(*((points - centres[i]) / np.ptp(points, axis=0)).T[::-1])
        if np.diff(np.sort(angles), append=np.min(angles) + 2 * np.pi).max() > np.pi:
            continue
        steps = np.mod(np.diff(angles) / (2 * np.pi), 1.0)
        half = len(steps) // 2
        value = _weighted_mean(steps)
        if abs(value - np.round(value)) * len(steps) < 1:
            continue  # less than one turn in all, about a centre that is none
        values[i] = value
        halves = _weighted_mean(steps[:half]), _weighted_mean(steps[half:])
        bars[i] = np.ptp([values[i], *halves])
    return RotationNumbers(values, bars, centres)


def _weighted_mean(steps: np.ndarray) -> float:
    place = np.arange(1, len(steps) + 1) / (len(steps) + 1)
    weights = np.exp(-1 / (place * (1 - place)))
    return float(weights @ steps / weights.sum())
