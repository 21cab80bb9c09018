"""Pictures of a sweep: charts over two parameters, curves over one, histograms, clouds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from voronec.declaration.figure_style import FAINT, INK, MARK, PALE, SOFT, WIDTH, figure_in_style
from voronec.errors import DefinitionError, did_you_mean

PANELS = 6
"""Columns that are drawn where nobody names any."""
BINS = 80
DENSE = 200
"""So many motions at each place show how they are spread."""
SIZES = 100
"""A largest value so many times the median is beside all others on an even axis."""
MOST_DOTS = 100_000
"""Points of a cloud that are drawn, evenly taken from all."""


def plot_sweep(data: Any, points: Callable[[str], Any], names: Sequence[str] | None = None) -> Any:
    """A matplotlib ``Figure`` with a panel for each of ``names``, by default the first columns, of
    a dataset; ``points`` gives the passages of a section by its name.

    A column over two axes of the grid is a chart of colours, over one a curve, both of the median
    over the starts, the curve with a band that holds nine tenths of them, or, where they are many,
    with how they are spread; without a grid it is a histogram.  A section is a cloud of its first
    two quantities.  ``DefinitionError`` for a name that the sweep does not have, and where nothing
    is finished.
    """
    recorded = [str(n) for n in data.attrs["record"]]
    columns = [n for n in recorded if n in data and data[n].dtype.kind == "f"]
    lists = [n for n in recorded if n not in data]
    shown: Sequence[str] = [*columns, *lists][:PANELS]
    if names is not None:
        from voronec.declaration.reading import several  # imports sympy

        shown = several(names, "names", '"max(x)"')
    for name in shown:
        if name not in (*columns, *lists):
            raise DefinitionError(
                f"the sweep has no numbers '{name}'{did_you_mean(name, columns + lists)}"
            )
    count = int(data["finished"].values.sum())
    if not count or not shown:
        raise DefinitionError("nothing of the sweep is finished, so there is no picture")
    wide = 2 if len(shown) > 1 else 1
    rows = -(-len(shown) // wide)
    height = 0.4 + rows * (2.3 if wide == 2 else 3.3)
    with figure_in_style(WIDTH * (1.0 if wide == 2 else 0.7), height) as figure:
        panels = [*figure.subplots(rows, wide, squeeze=False).flat]
        for name, panel in zip(shown, panels, strict=False):
            if name in lists:
                _cloud(panel, points(name), name)
            else:
                _column(figure, panel, data[name].load(), name)
            panel.tick_params(labelsize=8)
        for panel in panels[len(shown) :]:
            panel.set_visible(False)
        title = data.attrs["title"] or data.attrs["system"]
        figure.suptitle(f"{title}: {count} motions", fontsize=10)
    return figure


def _column(figure: Any, panel: Any, column: Any, name: str) -> None:
    """A column over the axes of the grid that have several places, as many as fit a panel."""
    axes = [d for d in column.dims if d in column.coords and column.sizes[d] > 1][:2]
    rest = [d for d in column.dims if d not in axes]
    values = np.moveaxis(column.values, [column.dims.index(d) for d in axes], range(len(axes)))
    values = values.reshape(*values.shape[: len(axes)], -1)
    if not axes:
        _histogram(panel, values.reshape(-1), name)
        return
    places = [column[d].values for d in axes]
    low, middle, high = _quantiles(values)
    spread = values.shape[-1] > 1
    told = f"\nmedian over {', '.join(map(str, rest))}" if spread else ""
    panel.set_title(f"{name}{told}", fontsize=9)
    if len(axes) == 2:
        image = panel.pcolormesh(
            *places, middle.T, cmap="viridis", shading="nearest", rasterized=True
        )
        panel.set_facecolor(PALE)
        figure.colorbar(image, ax=panel, pad=0.02)
        panel.set(xlabel=str(axes[0]), ylabel=str(axes[1]))
        return
    order = np.argsort(places[0])
    if values.shape[-1] >= DENSE:
        _density(panel, places[0][order], values[order])
    elif spread:
        panel.fill_between(places[0][order], low[order], high[order], color=FAINT, linewidth=0)
    panel.plot(places[0][order], middle[order], color=MARK if spread else INK, linewidth=1.0)
    panel.set_xlabel(str(axes[0]))
    panel.margins(x=0)
    panel.spines[["top", "right"]].set_visible(False)


def _density(panel: Any, place: np.ndarray, values: np.ndarray) -> None:
    """How the values are spread at each place, the darker the more of them."""
    bins = min(BINS, round(2 * values.shape[-1] ** 0.5))
    edges = np.linspace(float(np.nanmin(values)), float(np.nanmax(values)), bins + 1)
    counts = np.stack([np.histogram(row[np.isfinite(row)], edges)[0] for row in values], axis=1)
    middles = (edges[1:] + edges[:-1]) / 2
    panel.pcolormesh(place, middles, counts, cmap="Blues", shading="nearest", rasterized=True)


def _quantiles(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The 5th, 50th and 95th of a hundred along the last axis, of the numbers that are there."""
    there = np.isfinite(values).any(axis=-1)
    quantiles = np.full((3, *values.shape[:-1]), np.nan)
    quantiles[:, there] = np.nanquantile(values[there], (0.05, 0.5, 0.95), axis=-1)
    return quantiles[0], quantiles[1], quantiles[2]


def _histogram(panel: Any, values: np.ndarray, name: str) -> None:
    """How often values occur; those of many sizes, as drifts are, by their logarithms."""
    there = values[np.isfinite(values)]
    bins: Any = min(BINS, max(5, len(there) // 10))
    if len(there) and there.min() >= 0 and there.max() > SIZES * np.median(there) > 0:
        there = there[there > 0]
        bins = np.geomspace(there.min(), there.max(), bins + 1)
        panel.set_xscale("log")
    panel.stairs(*np.histogram(there, bins), fill=True, color=SOFT)
    panel.set(ylabel="motions")
    panel.set_title(name, fontsize=9)
    panel.spines[["top", "right"]].set_visible(False)


def _cloud(panel: Any, points: Any, name: str) -> None:
    """The first two quantities of a section, a colour for each motion; of one, against the time."""
    held = [c for c in points.columns if c not in ("row", "t")]
    x, y = held[:2] if len(held) > 1 else ("t", held[0])
    some = points.iloc[:: max(1, len(points) // MOST_DOTS)]
    size = float(np.clip(400.0 / max(len(some), 1) ** 0.5, 0.3, 6.0))
    panel.scatter(
        some[x], some[y], s=size, c=some["row"], cmap="viridis", linewidths=0, rasterized=True
    )
    panel.set(xlabel=x, ylabel=y)
    panel.set_title(f"{name}: {len(points)} points", fontsize=9)
    panel.spines[["top", "right"]].set_visible(False)
