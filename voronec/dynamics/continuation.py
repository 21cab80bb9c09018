"""Pseudo-arclength continuation of a curve of solutions, with control of the step.

    F(y) = 0,   t . (y - y0) = ds

From a point y0 a step of the length ds goes along the tangent t; Newton's method leads back onto
the curve within the plane across t [Keller1977; AllgowerGeorg1990].  A step that fails, or after
which the tangent has turned by more than ``TURN`` allows, is halved; after one that succeeds the
next may be twice as long.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from voronec.errors import EngineLimit

SHORTEST = 1e-6
"""A share of the first step, below which a curve is not followed any further."""
TURN = 0.9
"""The least cosine of the angle between tangents at both ends of a step."""
COMPLETE = "complete"
"""Why a curve ends that has come to the end of its span."""


class ContinuationCurve(Protocol):
    """A curve of solutions y (n,), with entries of the sizes ``units`` (n,), over a quantity."""

    @property
    def units(self) -> np.ndarray:
        """The sizes of the entries."""

    def value(self, y: np.ndarray) -> float:
        """The quantity at a point."""

    def slope(self, y: np.ndarray) -> np.ndarray:
        """Its gradient (n,)."""

    def tangent(self, y: np.ndarray, ahead: np.ndarray) -> np.ndarray | None:
        """The tangent (n,) on the side of a direction, of length one in the units; None where there
        is none."""

    def onto(self, y: np.ndarray, across: np.ndarray) -> np.ndarray | None:
        """The point of the curve in the plane through y across a direction, if one is found."""

    def at_value(self, value: Any, near: np.ndarray) -> np.ndarray | None:
        """The point with a value of the quantity, near a point, if one is found."""


def follow(
    curve: ContinuationCurve, start: np.ndarray, sign: float, span: tuple[float, float],
    step: float, most: int, longest: float = np.inf,
    progress: Callable[[float], Any] | None = None,
) -> tuple[list[np.ndarray], str]:  # fmt: skip
    """Points of a curve behind ``start``, as long as the quantity is in the ``span``, and why they
    end: ``COMPLETE``, or in words.

    At first the quantity grows with ``sign`` 1 and falls with -1.  A step changes it by about
    ``step`` and is no longer than ``longest`` in the units; there are ``most`` points at most.
    ``progress`` is called with the quantity at each.  Raises ``EngineLimit`` where no curve leads
    through the start.
    """
    units, points = curve.units, list[np.ndarray]()
    y, t = start, curve.tangent(start, curve.slope(start) * units**2)
    if t is None:
        raise EngineLimit("the solution is isolated: no family leads on from it")
    t = sign * t
    first = length = _length(curve, y, t, step, longest)
    while len(points) < most:
        ahead = curve.onto(y + length * t, t)
        new = None if ahead is None else curve.tangent(ahead, t)
        if ahead is None or new is None or (new / units) @ (t / units) < TURN:
            length /= 2
            if length < SHORTEST * first:
                return points, "it cannot be followed any further"
            continue
        change, value = float(curve.slope(y) @ t) * length, curve.value(ahead)
        edge = span[change > 0] if span[0] <= value <= span[1] else span[value > span[1]]
        if abs(edge - value) < abs(change) / 2 or not span[0] <= value <= span[1]:
            last = curve.at_value(edge, ahead)
            if last is not None or not span[0] <= value <= span[1]:
                return [*points, *([] if last is None else [last])], COMPLETE
        y, t = ahead, new
        length = min(2 * length, _length(curve, y, t, step, longest))
        points.append(y)
        if progress is not None:
            progress(value)
    return points, f"{most} points were made"


def _length(
    curve: ContinuationCurve, y: np.ndarray, t: np.ndarray, step: float, longest: float
) -> float:
    """The length of a step in which the quantity changes by ``step``, ``longest`` at most."""
    rate = abs(float(curve.slope(y) @ t))
    return min(longest, step / rate if rate > 0 else longest)


def between(curve: ContinuationCurve, a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    """The point of the curve at a share of the chord from a to b, two of its points."""
    point = curve.onto(a + share * (b - a), b - a)
    if point is None:
        raise EngineLimit("a family cannot be followed between two of its points")
    return point


def root_between(
    curve: ContinuationCurve, a: np.ndarray, b: np.ndarray, measure: Callable[[np.ndarray], float]
) -> np.ndarray | None:
    """The point of the curve between two at which a function vanishes; None where its signs at both
    are not opposite."""
    from scipy.optimize import brentq

    if not measure(a) * measure(b) < 0:
        return None

    def at(share: float) -> float:
        return measure((a, b)[int(share)] if share in (0, 1) else between(curve, a, b, share))

    share = float(brentq(at, 0.0, 1.0, xtol=1e-13, rtol=1e-13))
    return between(curve, a, b, share)
