"""Which motions a sweep has: a grid of values, times a list or draw of starts, in chunks.

The motions are the places of an array with an axis for each name of the grid, and an axis ``start``
where there are several starts.  A chunk is a box of that array whose rows follow one another in C
order, so that it is one shard of what is stored.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.declaration.catalogue import unknown
from voronec.declaration.reading import doubles
from voronec.declaration.system import System
from voronec.errors import DefinitionError, quote

START = "start"
"""The axis of starts."""
METHODS = ("sobol", "uniform", "level")


@dataclass(frozen=True)
class Draws:
    """``count`` random starts.

    ``ranges`` map coordinates, velocities or parameters to (low, high), between which they are
    drawn by ``method``: ``sobol``, scrambled points of Sobol' that fill the box evenly, best when
    the count is a power of two; or ``uniform``.  ``level`` takes no ranges: the starts have the
    values that all integrals have at the start of the scene.
    """

    count: int
    ranges: Mapping[Any, tuple[Any, Any]] = field(default_factory=dict)
    method: str = "sobol"

    def __post_init__(self) -> None:
        if not isinstance(self.count, int) or self.count < 1:
            raise DefinitionError(f"draws: count = {quote(self.count)}; give a number from 1 on")
        if self.method not in METHODS:
            raise DefinitionError(
                f"draws: method = {quote(self.method)} must be one of {', '.join(METHODS)}"
            )
        if (self.method == "level") == bool(self.ranges):
            raise DefinitionError(
                "draws on a level of the integrals take no ranges; others take at least one, "
                "{'omega1': (-1, 1)}"
            )

    def values(self, seed: int) -> dict[str, np.ndarray]:
        """The numbers drawn between the ends of ranges, by name."""
        from scipy.stats import qmc

        ends = [doubles(pair, f"draws: the range of '{k}'") for k, pair in self.ranges.items()]
        for name, pair in zip(self.ranges, ends, strict=True):
            if pair.shape != (2,) or not pair[0] < pair[1] or not np.isfinite(pair).all():
                raise DefinitionError(f"draws: the range of '{name}' must be (low, high)")
        random = np.random.default_rng(seed)
        if self.method == "uniform":
            unit = random.random((self.count, len(ends)))
        else:
            with warnings.catch_warnings():  # balance wants a power of two, as is documented
                warnings.simplefilter("ignore")
                unit = qmc.Sobol(len(ends), scramble=True, seed=random).random(self.count)
        return {
            _name(k): low + (high - low) * unit[:, i]
            for i, (k, (low, high)) in enumerate(zip(self.ranges, ends, strict=True))
        }


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """The values on the ``axes`` of the grid, and those of each start, both by name; ``size`` says
    how many motions make a chunk at most."""

    axes: Mapping[str, np.ndarray]
    starts: Mapping[str, np.ndarray]
    size: int

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """How long each axis is."""
        count = len(next(iter(self.starts.values()), ()))
        lengths = tuple(map(len, self.axes.values()))
        return (*lengths, max(count, 1)) if count or not lengths else lengths

    @property
    def dimensions(self) -> tuple[str, ...]:
        """The names of all axes."""
        return (*self.axes, START)[: len(self.shape)] if self.axes else (START,)

    def __len__(self) -> int:
        return math.prod(self.shape)

    @cached_property
    def box(self) -> tuple[int, ...]:
        """The shape of a chunk."""
        sides, left = [], self.size
        for length in reversed(self.shape):
            sides.append(max(1, min(length, left)))
            left //= length
        return tuple(reversed(sides))

    @property
    def cells(self) -> tuple[int, ...]:
        """How many chunks lie along each axis."""
        return tuple(-(-n // k) for n, k in zip(self.shape, self.box, strict=True))

    @property
    def chunks(self) -> int:
        """How many chunks there are."""
        return math.prod(self.cells)

    def place(self, chunk: int) -> tuple[slice, ...]:
        """Where the motions of a chunk stand in the array."""
        at = np.unravel_index(chunk, self.cells)
        sides = zip(map(int, at), self.box, self.shape, strict=True)
        return tuple(slice(i * k, min((i + 1) * k, n)) for i, k, n in sides)

    def rows(self, chunk: int) -> np.ndarray:
        """The numbers of its motions, in C order of the whole array."""
        ranges = [np.arange(part.start, part.stop) for part in self.place(chunk)]
        return np.ravel_multi_index(np.meshgrid(*ranges, indexing="ij"), self.shape).reshape(-1)

    def columns(self, chunk: int) -> dict[str, np.ndarray]:
        """What its motions start from, an entry each, by name."""
        indices = dict(zip(self.dimensions, np.unravel_index(self.rows(chunk), self.shape),
                           strict=True))  # fmt: skip
        grid = {name: values[indices[name]] for name, values in self.axes.items()}
        return grid | {name: values[indices[START]] for name, values in self.starts.items()}


def make_plan(
    system: System, grid: Any, starts: Any, seed: int, size: int,
    alike: Callable[[int], Sequence[Mapping[str, float]]],
) -> SweepPlan:  # fmt: skip
    """The motions that are asked for; ``alike`` gives so many starts on one level of the integrals.

    ``DefinitionError`` for a name that the system does not know, or that stands twice.
    """
    axes = {_name(k): _values(x, f"the grid of '{k}'") for k, x in (grid or {}).items()}
    if isinstance(starts, Draws):
        listed = _columns(alike(starts.count)) if starts.method == "level" else starts.values(seed)
    elif isinstance(starts, Mapping):
        listed = {_name(k): _values(x, f"the starts '{k}'") for k, x in starts.items()}
    elif starts is None:
        listed = {}
    else:
        if isinstance(starts, str) or not all(isinstance(row, Mapping) for row in starts):
            raise DefinitionError(
                "starts: give arrays by name, {'x': [0, 1]}, a list of mappings, or vo.Draws(...)"
            )
        listed = _columns([{_name(k): x for k, x in row.items()} for row in starts])
    sizes = {name: len(values) for name, values in listed.items() if len(values) > 1}
    if len({*sizes.values()}) > 1:
        told = ", ".join(f"'{name}' has {count}" for name, count in sizes.items())
        raise DefinitionError(f"starts: give as many values of each; {told}")
    count = max(sizes.values(), default=1)
    listed = {name: np.broadcast_to(values, (count,)) for name, values in listed.items()}
    known = {*system.parameter_names, *map(plain_name, system.known_symbols())} - {"t"}
    for name in (*axes, *listed):
        if name not in known:
            kind = "parameter, coordinate or velocity"
            raise DefinitionError(f"system '{system.name}': {unknown(kind, name, known)}")
        if name == START or (name in axes and name in listed):
            raise DefinitionError(f"'{name}' cannot stand in the grid and in the starts; rename it")
    return SweepPlan(axes, listed, size)


def _name(key: Any) -> str:
    return key if isinstance(key, str) else plain_name(key)


def _values(given: Any, place: str) -> np.ndarray:
    values = np.atleast_1d(doubles(given, place))
    if values.ndim != 1 or not len(values) or not np.isfinite(values).all():
        raise DefinitionError(f"{place}: give a list of finite numbers")
    return values


def _columns(rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """Rows of the same names as columns."""
    names = dict.fromkeys(name for row in rows for name in row)
    for i, row in enumerate(rows):
        if missing := names.keys() - row.keys():
            raise DefinitionError(f"start {i} has no '{min(missing)}'; give all starts one form")
    return {name: _values([row[name] for row in rows], f"the starts '{name}'") for name in names}
