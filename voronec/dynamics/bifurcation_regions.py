"""Regions of a bifurcation diagram, and the components of the levels in them.

The curves of critical values cut the window into regions; in each, compact levels are all alike.  A
level is sampled by Newton's method from random points, and points belong to one component where
short steps on the level lead from one to the other.  All that is computed: a region narrower than a
cell of the raster, and a component that no random point leads to, are missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from voronec.dynamics.bifurcation_curves import CriticalPoints

CELLS = 300
"""Cells of the raster in each direction."""
FEWEST = 9
"""Regions of fewer cells are left out."""
SAMPLES = {1: 60, 2: 400}
"""Random points, by the dimension of the level, of which twice components are made."""
NEIGHBOURS = 20
"""Of each component so many points are compared with those of others that lie nearest."""
WALK = 12
"""The way from point to point is cut into so many steps, and has four times as many at most."""
SMALLEST = 0.02
"""A component has this part of the points, or more: fewer are points that found no neighbours."""
PLACES, ASIDE = 5, 5
"""Levels of a region that are looked at; at random so many cells away from its edge."""


@dataclass(frozen=True, eq=False)
class DiagramRegion:
    """A part of the window: ``components`` of the levels in it, none where there are no motions,
    and None where levels of it differ, as they do where levels are not compact; ``place`` (2,) is
    deep inside, ``share`` its part of the window."""

    place: tuple[float, float]
    share: float
    components: int | None
    counts: tuple[int, ...] = field(repr=False)

    @property
    def is_uniform(self) -> bool:
        """Whether all levels that were looked at have as many components."""
        return len({*self.counts}) == 1


@dataclass(frozen=True, eq=False)
class LevelComponents:
    """Points (m, n) of a level, and of which component (m,) each is."""

    points: np.ndarray
    labels: np.ndarray

    @property
    def count(self) -> int:
        """How many components there are."""
        return int(self.labels.max(initial=-1)) + 1


def level_components(
    points: CriticalPoints, place: Sequence[float], seed: int = 1
) -> LevelComponents:
    """The components of the level of which ``place`` (2,) are the values of the two integrals."""
    from scipy.spatial import cKDTree

    mapping, count = points.map, SAMPLES.get(points.dimension, SAMPLES[2])
    targets = [*points.targets, *place]
    x = mapping.project(mapping.random_points(count, seed), points.rows, targets)
    if len(x) < 2:
        return LevelComponents(x, np.zeros(len(x), dtype=int))
    # once more, with the sizes that the variables have on the level
    sizes = np.sqrt((x**2).mean(axis=0))
    units = np.maximum(sizes, 1e-3 * mapping.units)
    units[mapping.angles] = 1.0
    x = np.vstack(
        [x, mapping.project(mapping.random_points(count, seed, units), points.rows, targets)]
    )
    there = mapping.spread(x, units)
    near = cKDTree(there).query(there, min(3, len(x)))[1]
    tried = np.unique([sorted((i, j)) for i, row in enumerate(near) for j in row[1:]], axis=0)
    joined = tried[_are_joined(points, x[tried[:, 0]], x[tried[:, 1]], targets, units)]
    while True:
        labels = _labels(len(x), joined)
        tried = _between_components(there, labels)
        fresh = tried[_are_joined(points, x[tried[:, 0]], x[tried[:, 1]], targets, units)]
        if not len(fresh):
            break
        joined = np.vstack([joined, fresh])
    sizes = np.bincount(labels)
    kept = np.flatnonzero(sizes >= max(2, SMALLEST * len(x)))
    order = {int(k): i for i, k in enumerate(kept[np.argsort(-sizes[kept], kind="stable")])}
    inside = np.isin(labels, kept)
    return LevelComponents(x[inside], np.array([order[int(k)] for k in labels[inside]], dtype=int))


def _labels(count: int, joined: np.ndarray) -> np.ndarray:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(joined)), joined.T), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def _between_components(scaled: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Pairs (p, 2) of the points that lie nearest between each component and the others."""
    from scipy.spatial import cKDTree

    pairs = [np.zeros((0, 2), dtype=int)]
    for k in range(int(labels.max()) + 1):
        inside, outside = np.flatnonzero(labels == k), np.flatnonzero(labels != k)
        if len(outside):
            gaps, other = cKDTree(scaled[outside]).query(scaled[inside])
            first = np.argsort(gaps)[:NEIGHBOURS]
            pairs.append(np.column_stack([inside[first], outside[other[first]]]))
    return np.vstack(pairs)


def _are_joined(
    points: CriticalPoints, a: np.ndarray, b: np.ndarray, targets: Sequence[float],
    units: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Which points of a level (p, n) are reached from which on it, by short steps along it towards
    them, in units of the level."""
    mapping, here = points.map, a.copy()
    length = np.linalg.norm(mapping.difference(a, b) / units, axis=1) / WALK
    joined, todo = np.zeros(len(a), dtype=bool), np.arange(len(a))
    for _ in range(4 * WALK):
        way = mapping.difference(here[todo], b[todo]) / units
        near = np.linalg.norm(way, axis=1) < 1.1 * length[todo]
        joined[todo[near]] = True
        todo, way = todo[~near], way[~near]
        if not len(todo):
            break
        slopes = mapping.jet(here[todo])[1][:, [*points.rows]] * units
        across = np.linalg.pinv(slopes) @ (slopes @ way[..., None])
        along = way - across[..., 0]
        pace = length[todo] / np.maximum(np.linalg.norm(along, axis=1), 1e-300)
        ahead = here[todo] + units * along * pace[:, None]
        here[todo], met = mapping.settle(ahead, points.rows, targets)
        met &= np.linalg.norm((here[todo] - ahead) / units, axis=1) < length[todo]
        todo = todo[met]
    return joined


@dataclass(frozen=True, eq=False)
class Raster:
    """The regions of a window as cells: ``labels`` (CELLS, CELLS) are numbers of regions, first by
    the first integral, and -1 on curves and where a region is too small."""

    window: np.ndarray
    labels: np.ndarray
    regions: tuple[DiagramRegion, ...]

    def at(self, place: Sequence[float]) -> int:
        """The number of the region of a place (2,), or -1; outside of the window, too."""
        cell = (np.asarray(place) - self.window[:, 0]) / np.ptp(self.window, axis=1) * CELLS
        inside = (cell >= 0).all() and (cell < CELLS).all()
        return int(self.labels[*cell.astype(int)]) if inside else -1


def regions_of(points: CriticalPoints, curves: Sequence[Any]) -> Raster:
    """The regions that curves of critical values leave in the window."""
    from scipy import ndimage

    window = points.window
    free = np.ones((CELLS, CELLS), dtype=bool)
    for curve in curves:
        way = (curve.values - window[:, 0]) / np.ptp(window, axis=1) * CELLS
        steps = np.linspace(0, 1, 64)[:, None, None]
        cells = np.floor((1 - steps) * way[:-1] + steps * way[1:]).reshape(-1, 2).astype(int)
        cells = cells[(cells >= 0).all(axis=1) & (cells < CELLS).all(axis=1)]
        free[*cells.T] = False
    pieces, count = ndimage.label(free)
    labels, regions = np.full(free.shape, -1), list[DiagramRegion]()
    for k in range(1, count + 1):
        inside = pieces == k
        if inside.sum() < FEWEST:
            continue
        labels[inside] = len(regions)
        regions.append(_region(points, inside))
    return Raster(window, labels, tuple(regions))


def _region(points: CriticalPoints, inside: np.ndarray) -> DiagramRegion:
    """A region of the raster: levels are looked at where it is widest, and at random."""
    from scipy import ndimage

    window = points.window
    depth = ndimage.distance_transform_edt(np.pad(inside, 1))[1:-1, 1:-1]
    widest = np.unravel_index(int(np.argmax(depth)), depth.shape)
    aside = np.argwhere(depth > min(ASIDE, depth.max() / 2))
    random = np.random.default_rng(len(aside))
    cells = np.array([widest, *random.choice(aside, PLACES - 1)])
    places = window[:, 0] + (cells + 0.5) / CELLS * np.ptp(window, axis=1)
    counts = tuple(level_components(points, place).count for place in places)
    agreed = counts.count(counts[0]) > len(counts) / 2
    x, y = places[0].tolist()
    return DiagramRegion((x, y), float(inside.mean()), counts[0] if agreed else None, counts)
