"""Curves on the unit sphere, seen from afar: the eye, the horizon, and smooth paths for print.

A curve is points in space along a parameter, usually the time.  It is drawn as cubic arcs whose
ends and tangents are the curve's own, never as a polygon: a cusp, where the velocity vanishes, and
a passage through a pole stay what they are at any magnification.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

FINE = 2e-4
"""How far arcs may lie from the curve, in radii: 1/50 of a point on a sphere of 3 inches."""
CLOSE = 0.03
"""How far from a curve of every other point the rest may lie; all together err 16 times less."""
LONG = 0.05
"""A step, in radii, above which a cubic leaves the sphere visibly."""


@dataclass(frozen=True)
class View:
    """An orthographic look at the unit sphere, its axis upright in the picture.

    longitude, height
        where the eye stands, far away, in radians; ``height`` is above the equator.
    """

    longitude: float
    height: float

    def project(self, points: Any) -> np.ndarray:
        """Points in space, in the last axis, as (right, up, towards the eye)."""
        cos, sin = np.cos(self.longitude), np.sin(self.longitude)
        rise, run = np.sin(self.height), np.cos(self.height)
        right = (-sin, cos, 0.0)
        up = (-rise * cos, -rise * sin, run)
        eye = (run * cos, run * sin, rise)
        seen: np.ndarray = np.asarray(points, float) @ np.array([right, up, eye]).T
        return seen


@dataclass(frozen=True)
class Arcs:
    """Cubic arcs, one after the other: ``handles[i]`` are the four points of Bezier's form."""

    handles: np.ndarray  # (arcs, 4, 3)

    def project(self, view: View) -> Arcs:
        """The arcs as (right, up, towards the eye)."""
        return Arcs(view.project(self.handles))

    def parts(self) -> tuple[tuple[Arcs, bool], ...]:
        """Pieces that end at the horizon, in order; with each, whether it is in front.

        The arcs are those of ``seen``: the horizon is where the third coordinate is zero.
        """
        arcs = np.array([piece for arc in self.handles for piece in _cut(arc)])
        front = arcs[:, :, 2] @ np.array([1.0, 3.0, 3.0, 1.0]) >= 0  # 8 times the depth half way
        ends = np.flatnonzero(np.diff(front)) + 1
        sides = front[np.concatenate([[0], ends])]
        pieces = np.split(arcs, ends)
        return tuple((Arcs(a), bool(side)) for a, side in zip(pieces, sides, strict=True))


def _cut(arc: np.ndarray) -> list[np.ndarray]:
    """One arc, divided where it crosses the horizon."""
    depth = arc[:, 2]
    if depth.min() >= 0 or depth.max() <= 0:
        return [arc]
    pieces, done = [], 0.0
    for place in _crossings(depth):
        left, arc = _divide_arc(arc, (place - done) / (1 - done))
        pieces.append(left)
        done = place
    return [*pieces, arc]


def _crossings(depth: np.ndarray) -> list[float]:
    """Where in (0, 1) a cubic in Bernstein's form changes its sign."""
    a, b, c, d = depth
    roots = np.roots([d - 3 * c + 3 * b - a, 3 * c - 6 * b + 3 * a, 3 * b - 3 * a, a])
    real = roots.real[np.abs(roots.imag) < 1e-9]
    return sorted(float(r) for r in real if 1e-9 < r < 1 - 1e-9)


def _divide_arc(arc: np.ndarray, place: float) -> tuple[np.ndarray, np.ndarray]:
    """The two parts of a cubic arc, by de Casteljau's construction."""
    rows = [arc]
    while len(rows[-1]) > 1:
        rows.append((1 - place) * rows[-1][:-1] + place * rows[-1][1:])
    left = np.array([row[0] for row in rows])
    right = np.array([row[-1] for row in reversed(rows)])
    left[-1, 2] = right[0, 2] = 0.0
    return left, right


def on_sphere(colatitude: Any, longitude: Any) -> np.ndarray:
    """The points (sin u cos v, sin u sin v, cos u), in the last axis."""
    u, v = np.broadcast_arrays(np.asarray(colatitude, float), np.asarray(longitude, float))
    return np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)


def parallel(colatitude: float, start: float = 0.0) -> Arcs:
    """A whole parallel, from the longitude ``start`` on."""
    longitudes = start + np.linspace(0.0, 2 * np.pi, 8 + 1)
    tangents = np.sin(colatitude) * on_sphere(np.pi / 2, longitudes + np.pi / 2)
    return _join_points(on_sphere(colatitude, longitudes), tangents, _circular(longitudes))


def meridian(longitude: float) -> Arcs:
    """Half a great circle, from the pole on top to the other one."""
    colatitudes = np.linspace(0.0, np.pi, 4 + 1)
    tangents = on_sphere(colatitudes + np.pi / 2, longitude)
    return _join_points(on_sphere(colatitudes, longitude), tangents, _circular(colatitudes))


def _circular(angles: np.ndarray) -> np.ndarray:
    """Places whose steps make cubic arcs lie on a circle, to 1/200000 of its radius."""
    return np.arange(len(angles)) * 4 * np.tan((angles[1] - angles[0]) / 4)


def smooth_arcs(points: np.ndarray, times: np.ndarray | None = None, fine: float = FINE) -> Arcs:
    """As few cubic arcs as keep within ``fine`` of a curve given at many times.

    points
        (n, 3), of unit length, dense enough that nothing happens in between (see ``settled``).
    times
        where on the curve they are, growing; equal steps unless told.  A curve that is smooth in
        the time is drawn so even where it has a cusp.
    """
    from scipy.interpolate import CubicSpline

    place = _places(points, times)
    spline = CubicSpline(place, points)
    parts = min(64, int(np.ceil(np.linalg.norm(np.diff(points, axis=0), axis=1).max() / LONG)))
    if parts > 1:  # between given points the curve stays on the sphere, too
        shares = np.arange(parts) / parts
        inner = (place[:-1, None] + np.diff(place)[:, None] * shares).ravel()
        place = np.concatenate([inner, place[-1:]])
        points = spline(place)
        points /= np.linalg.norm(points, axis=1)[:, None]
        spline = CubicSpline(place, points)
    tangents = spline(place, 1)
    kept = _arc_ends(place, points, tangents, fine)
    return _join_points(points[kept], tangents[kept], place[kept])


def is_resolved(points: np.ndarray, times: np.ndarray | None = None) -> bool:
    """Whether points tell the curve: one through every other of them passes by the rest."""
    from scipy.interpolate import CubicSpline

    if len(points) < 8:
        return False
    place = _places(points, times)
    coarse = CubicSpline(place[::2], points[::2])
    last = len(points) - 1 - len(points) % 2  # beyond the last even point nothing is between
    off = np.linalg.norm(coarse(place[1:last:2]) - points[1:last:2], axis=1)
    return bool(off.max() < CLOSE)


def great_arcs(points: np.ndarray) -> Arcs:
    """Points on the sphere, joined in order by the shortest ways."""
    arcs = [_shortest(p, q) for p, q in pairwise(points)]
    return Arcs(np.concatenate([a.handles for a in arcs]))


def _shortest(first: np.ndarray, last: np.ndarray) -> Arcs:
    """Part of a great circle."""
    across = last - (first @ last) * first
    if np.linalg.norm(across) < 1e-12:
        across = np.cross(first, np.eye(3)[np.argmin(np.abs(first))])
    across = across / np.linalg.norm(across)
    angles = np.linspace(0.0, np.arctan2(across @ last, first @ last), 4 + 1)[:, None]
    around = np.cos(angles) * first + np.sin(angles) * across
    tangents = np.cos(angles) * across - np.sin(angles) * first
    return _join_points(around, tangents, _circular(angles[:, 0]))


def _places(points: np.ndarray, times: np.ndarray | None) -> np.ndarray:
    return np.arange(len(points), dtype=float) if times is None else np.asarray(times, float)


def _arc_ends(place: np.ndarray, points: np.ndarray, slopes: np.ndarray, fine: float) -> np.ndarray:
    """Indices of the points between which cubic arcs follow all others; halves what does not."""
    ends = np.unique(np.linspace(0, len(points) - 1, 9).astype(int))
    while True:
        far = _deviations(place, points, slopes, ends) > fine
        far &= np.diff(ends) > 1
        if not far.any():
            return ends
        middle = (ends[:-1] + ends[1:])[far] // 2
        ends = np.union1d(ends, middle)


def _deviations(
    place: np.ndarray, points: np.ndarray, slopes: np.ndarray, ends: np.ndarray
) -> np.ndarray:
    """For each arc between neighbouring ``ends``, how far it runs from the points within it."""
    arc = np.minimum(np.searchsorted(ends, np.arange(len(points)), side="right") - 1, len(ends) - 2)
    left, right = ends[arc], ends[arc + 1]
    step = (place[right] - place[left])[:, None]
    s = (place - place[left])[:, None] / step
    value = (
        (1 + 2 * s) * (1 - s) ** 2 * points[left]
        + s * (1 - s) ** 2 * step * slopes[left]
        + s**2 * (3 - 2 * s) * points[right]
        + s**2 * (s - 1) * step * slopes[right]
    )
    off = np.linalg.norm(value - points, axis=1)
    largest = np.zeros(len(ends) - 1)
    np.maximum.at(largest, arc, off)
    return largest


def _join_points(points: np.ndarray, slopes: np.ndarray, place: np.ndarray) -> Arcs:
    """The arcs through points with given derivatives there."""
    step = np.diff(place)[:, None] / 3
    first, last = points[:-1], points[1:]
    return Arcs(
        np.stack([first, first + step * slopes[:-1], last - step * slopes[1:], last], axis=1)
    )


def best_view(points: np.ndarray, start: bool = True) -> View:
    """From where a curve is seen best.

    What counts is its length, and the more so where it turns sharply; what is near the rim counts
    little and what is behind nothing.  With ``start``, its beginning counts twice.
    """
    steps = np.diff(points, axis=0)
    length = np.linalg.norm(steps, axis=1)
    heading = steps / np.maximum(length, 1e-300)[:, None]
    bend = np.linalg.norm(np.diff(heading, axis=0), axis=1)
    weight = length + 0.03 * np.concatenate([bend, [0.0]])
    if not weight.any():
        weight = np.ones_like(length)  # a contact at rest
    if start:
        weight *= 1 + np.exp(-np.cumsum(length) / 2)
    middle = (points[1:] + points[:-1]) / 2
    best, view = -np.inf, View(0.0, 0.4)
    for height in np.radians([20, -20, 30, -30, 10, -10, 45, -45, 60, -60]):
        for longitude in np.arange(0, 2 * np.pi, np.pi / 18):
            depth = View(longitude, height).project(middle)[:, 2]
            score = weight @ np.clip(depth / 0.7, -0.2, 1.0) / weight.sum()
            score -= 0.3 * abs(abs(height) - np.radians(20))  # rings should look like rings
            if score > best + 1e-9:
                best, view = score, View(float(longitude), float(height))
    return view
