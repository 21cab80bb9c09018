"""Curves of critical values of an integral map, in the plane of two of its integrals.

A point is critical where the differentials depend on one another on the manifold of the relations R
and of the integrals that are held,

    l_1 dF_1 + l_2 dF_2 + sum m_j dG_j + sum n_k dR_k = 0,    G = g,   R = 0,   |(l, m, n)| = 1.

Critical points are found by Newton's method from random starts and followed by continuation.  They
fill orbits, and more; of all directions in which they go on, the curve follows that in which the
values (F_1, F_2) and the normal (l_1, l_2) of the curve change most.  Where a family shrinks to a
point of equilibrium the values turn back on themselves, and the curve ends; at a cusp the normal
turns on.

Whether orbits are stable is told by the second variation of the combination, on the tangent space
of the level, of which motion itself takes the directions in which it vanishes: definite, they are
minima or maxima, else saddles [BolsinovBorisovMamaev2010].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from voronec.dynamics.integral_map import IntegralMap
from voronec.dynamics.newton import solve, solve_across

STEP, TURN = 0.02, 0.05
"""The longest step, in the window and in the angle of the normal."""
LONGEST = 0.1
"""The longest step in the units of the variables."""
MOST = 1500
"""Points of a curve on either side of its start."""
SMALL = 1e-6
"""Singular values of the conditions below this part of the largest belong to directions in which
critical points go on; second variations below it vanish."""
SAME = 2e-3
"""Curves are one where their values and normals differ by less, in the window."""
MARGIN = 0.25
"""Curves are found and followed so far beyond the window."""
RECENT = 256
"""What was computed at so many points is kept."""


@dataclass(frozen=True, eq=False)
class CriticalCurve:
    """A curve of critical values: ``values`` (k, 2) of the two integrals, ``points`` (k, n) with
    these, ``normals`` (k,) the angles of the curve's normal; ``kinds`` (k,) are ``stable`` where
    the combination of the integrals has a minimum or maximum there, ``saddle`` where it has none,
    or ``degenerate``; ``isolated`` is a value that stands alone, where both integrals are
    critical."""

    values: np.ndarray
    points: np.ndarray = field(repr=False)
    normals: np.ndarray = field(repr=False)
    kinds: np.ndarray = field(repr=False)

    def __len__(self) -> int:
        return len(self.values)


@dataclass(frozen=True, eq=False)
class CriticalPoints:
    """The conditions on critical points of a map: of the constants in the places ``rows``, the last
    two are those of the plane, over a window (2, 2) of low and high values; others have
    ``targets``."""

    map: IntegralMap
    rows: tuple[int, ...]
    targets: np.ndarray
    window: np.ndarray

    def jets(self, y: np.ndarray) -> list[np.ndarray]:
        """The constants of ``rows``, their gradients and second derivatives at y, in the units."""
        key = y.tobytes()
        if key not in self._recent:
            if len(self._recent) > RECENT:
                self._recent.clear()
            units = self.map.units
            jet = self.map.jet((y[: len(units)] * units)[None], 2)
            value, slope, second = (part[0, [*self.rows]] for part in jet)
            s = self.scales
            self._recent[key] = [value, slope * units / s[:, None],
                                 second * np.outer(units, units) / s[:, None, None]]  # fmt: skip
        return self._recent[key]

    @cached_property
    def _recent(self) -> dict[bytes, list[np.ndarray]]:
        """What was computed last, by the point."""
        return {}

    @cached_property
    def scales(self) -> np.ndarray:
        """The sizes of the constants: of those of the plane the window's."""
        held = np.maximum(np.abs(self.targets), 1.0)
        return np.concatenate([held, np.ptp(self.window, axis=1)])

    @property
    def dimension(self) -> int:
        """The dimension of regular levels."""
        return len(self.map.units) - len(self.rows)

    def conditions(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What vanishes, and its Jacobian, at y: a point in its units, then the multipliers."""
        n, (value, slope, second) = len(self.map.units), self.jets(y)
        weights, held = y[n:], len(self.targets)
        off = (value[:held] - self.targets) / self.scales[:held]
        residuals = np.concatenate([weights @ slope, off, [weights @ weights - 1]])
        slopes = np.zeros((len(residuals), len(y)))
        slopes[:n, :n], slopes[:n, n:] = np.tensordot(weights, second, 1), slope.T
        slopes[n : n + held, :n], slopes[-1, n:] = slope[:held], 2 * weights
        return residuals, slopes

    def values(self, y: np.ndarray) -> np.ndarray:
        """The two integrals, from 0 to 1 in the window, and the angle of the curve's normal, by
        its half turns."""
        plane = (self.jets(y)[0][-2:] - self.window[:, 0]) / self.scales[-2:]
        return np.append(plane, np.arctan2(y[-1], y[-2]) % np.pi)

    def direction(self, y: np.ndarray, before: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
        """In which direction the curve goes on from y, of length one, and how fast the values and
        the normal change then."""
        n, slopes = len(self.map.units), self.conditions(y)[1]
        _, sizes, right = np.linalg.svd(slopes)
        rank = int((sizes > SMALL * sizes[0]).sum())
        kernel = right[rank:].T
        changes = np.zeros((3, len(y)))
        changes[:2, :n] = self.jets(y)[1][-2:]
        changes[2, -2:] = np.array([-y[-1], y[-2]]) / max(y[-2] ** 2 + y[-1] ** 2, 1e-12)
        _, _, turned = np.linalg.svd(changes @ kernel)
        way = kernel @ turned[0]
        if before is not None and way @ before < 0:
            way = -way
        return way, changes @ way

    def is_isolated(self, y: np.ndarray) -> bool:
        """Whether both integrals are critical, as at an equilibrium, or the values stand still."""
        sizes = np.linalg.svd(self.jets(y)[1], compute_uv=False)
        return bool(sizes[-2] < SMALL * sizes[0]) or bool(
            np.linalg.norm(self.direction(y, None)[1]) < SMALL
        )

    def kind(self, y: np.ndarray) -> str:
        """What the second variation says; see ``CriticalCurve``."""
        _, slope, second = self.jets(y)
        lengths = np.linalg.norm(slope, axis=1, keepdims=True)
        slope = slope / np.maximum(lengths, 1e-3 * lengths.max() + 1e-300)
        form = np.tensordot(y[len(self.map.units) :], second, 1)
        _, sizes, right = np.linalg.svd(slope)
        tangent = right[int((sizes > SMALL).sum()) :]
        spectrum = np.linalg.eigvalsh(tangent @ form @ tangent.T)
        # on a critical torus of one dimension less than regular ones the form vanishes
        spectrum = spectrum[np.argsort(np.abs(spectrum))][self.dimension - 1 :]
        if np.abs(spectrum).min(initial=np.inf) < SMALL * np.abs(form).max():
            return "degenerate"
        return "stable" if abs(np.sign(spectrum).sum()) == len(spectrum) else "saddle"

    def starts(self, count: int, seed: int) -> Iterator[np.ndarray]:
        """Critical points to which random starts lead."""
        mapping, held, random = self.map, len(self.targets), np.random.default_rng(seed)
        # slow and fast, so that small values are met, too
        x = mapping.random_points(8 * count, seed) * random.uniform(0.05, 1, size=(8 * count, 1))
        x = mapping.project(x, self.rows[:held], self.targets[mapping.relations :])
        values = (mapping.jet(x, 0)[0][:, [*self.rows[-2:]]] - self.window[:, 0]) / self.scales[-2:]
        outside = np.maximum(-values, values - 1).max(axis=1, initial=0.0)
        tried = 0
        for point in x[np.argsort(outside, kind="stable")]:
            if tried == count:
                return
            weights = random.normal(size=len(self.rows))
            slope = (
                mapping.jet(point[None])[1][0, [*self.rows]] * mapping.units / self.scales[:, None]
            )
            weights = np.linalg.svd(slope.T)[2][-1] + 0.1 * weights
            y = np.concatenate([point / mapping.units, weights / np.linalg.norm(weights)])
            critical = solve(self.conditions, y, np.ones(len(y)))
            if critical is not None and mapping.is_pole(critical[: len(point)] * mapping.units):
                continue
            tried += 1
            if critical is not None and np.hypot(*critical[-2:]) > SMALL:
                yield critical


def critical_curves(
    points: CriticalPoints, starts: int, seed: int, before: Sequence[CriticalCurve] = ()
) -> list[CriticalCurve]:
    """The curves in the window to which so many random starts lead, beside those that are known;
    isolated values are curves of one point."""
    curves, low, size = [*before], points.window[:, 0], points.scales[-2:]
    known = [np.column_stack([(c.values - low) / size, c.normals]) for c in before]
    for y in points.starts(starts, seed):
        value = points.values(y)
        if not _is_inside(value) or any(_is_on(value, path) for path in known):
            continue
        if points.is_isolated(y):
            if not any(np.abs(value[:2] - path[:, :2]).max(axis=1).min() < SAME for path in known):
                curves.append(_curve(points, [y], ["isolated"]))
                known.append(value[None])
            continue
        there = _follow(points, y, 1.0, known)
        back = _follow(points, y, -1.0, [*known, _path(points, [y, *there])[3:]])
        ys = [*back[::-1], y, *there]
        known.append(_path(points, ys))
        curves.append(_curve(points, ys, [points.kind(z) for z in ys]))
    shown = [c for c in curves if (np.abs((c.values - low) / size - 0.5) <= 0.5).all(axis=1).any()]
    return [c for c in shown if len(c) > 1 or not _ends_there(c, shown, size)]


def _ends_there(isolated: CriticalCurve, curves: Sequence[CriticalCurve], size: np.ndarray) -> bool:
    """Whether an isolated value is where curves begin, end or pass."""
    gaps = [np.abs((c.values - isolated.values) / size).max(axis=1).min()
            for c in curves if len(c) > 1]  # fmt: skip
    return min(gaps, default=np.inf) < STEP


def _curve(points: CriticalPoints, ys: Sequence[np.ndarray], kinds: Sequence[str]) -> CriticalCurve:
    path, n = _path(points, ys), len(points.map.units)
    low, size = points.window[:, 0], points.scales[-2:]
    states = np.array([y[:n] for y in ys]) * points.map.units
    return CriticalCurve(low + size * path[:, :2], states, path[:, 2], np.array(kinds))


def _path(points: CriticalPoints, ys: Sequence[np.ndarray]) -> np.ndarray:
    return np.array([points.values(y) for y in ys])


def _is_inside(value: np.ndarray) -> bool:
    return bool((value[:2] > -MARGIN).all() and (value[:2] < 1 + MARGIN).all())


def _is_on(value: np.ndarray, path: np.ndarray) -> bool:
    """Whether a value, with its normal, lies on a path."""
    if len(path) < 2:
        return False
    a, b = path[:-1], path[1:]
    first, last = ((p[:, 2] - value[2] + np.pi / 2) % np.pi - np.pi / 2 for p in (a, b))
    along = b[:, :2] - a[:, :2]
    share = ((value[:2] - a[:, :2]) * along).sum(1) / np.maximum((along**2).sum(1), 1e-300)
    share = np.clip(share, 0, 1)
    off = np.abs(a[:, :2] + share[:, None] * along - value[:2]).max(axis=1)
    turned = np.abs((1 - share) * first + share * last)
    return bool(((off < SAME) & (turned < 10 * SAME)).any())


def _follow(
    points: CriticalPoints, y: np.ndarray, sign: float, known: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """The points of a curve on one side of y: up to the window's edge, to a point where the values
    turn back, or to another curve."""
    way, speed = points.direction(y, None)
    way, speed, ys, step = sign * way, sign * speed, [y], LONGEST
    far = False
    while len(ys) <= MOST:
        pace = max(np.abs(speed[:2]).max() / STEP, abs(speed[2]) / TURN, 1 / LONGEST)
        step = min(step, 1 / pace)
        ahead = solve_across(points.conditions, ys[-1] + step * way, way, np.ones(len(y)))
        if ahead is None or np.linalg.norm(ahead - ys[-1] - step * way) > 0.3 * step:
            step /= 2
            if step < 1e-5:
                break
            continue
        new_way, new_speed = points.direction(ahead, way)
        back = new_speed[:2] @ speed[:2] < 0 and new_speed[2] * speed[2] < SMALL
        stands = np.abs(points.values(ahead) - points.values(ys[-1]))[:2].max() < SMALL
        if back or stands:
            step /= 4  # towards the end of the curve
            if step < SAME or not np.isfinite(new_speed).all():
                break
            continue
        ys.append(ahead)
        way, speed, step = new_way, new_speed, 1.5 * step
        value = points.values(ahead)
        if not _is_inside(value):
            break
        far = far or np.abs(value[:2] - points.values(y)[:2]).max() > 5 * SAME
        if far and (any(_is_on(value, path) for path in known)
                    or (len(ys) > 20 and _is_on(value, _path(points, ys[:-10])))):  # fmt: skip
            break
    return ys[1:]
