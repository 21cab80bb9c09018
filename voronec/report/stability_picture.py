"""Stability charts of regular precessions: one panel for each way of rolling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.errors import DefinitionError
from voronec.report.plots import INK, MARK, STYLE

if TYPE_CHECKING:
    from voronec.closed.special.chart import StabilityChart

__all__ = ["STABLE", "UNSTABLE", "stability_figure"]

STABLE, UNSTABLE = "#e3ecf5", "#f3d9d2"
"""Told apart in print without colours, too: the second is hatched."""


def stability_figure(
    charts: Mapping[str, StabilityChart],
    title: str = "",
    labels: tuple[str, str] | None = None,
    columns: int = 3,
) -> Any:
    """A matplotlib ``Figure``: where regular precessions are stable.

    charts
        title of a panel -> chart, whose regions and boundary curves are drawn.
    labels
        of the two axes, as mathtext; the names of the chart unless told.
    columns
        panels in a row.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    if not charts:
        raise DefinitionError("there is no chart to draw")
    columns = min(columns, len(charts))
    rows = -(-len(charts) // columns)
    with rc_context({**STYLE, "hatch.linewidth": 0.35}):
        figure = Figure(figsize=(0.6 + 2.5 * columns, 0.8 + 2.7 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False)
        for panel in panels.ravel()[len(charts) :]:
            panel.set_axis_off()
        for panel, (name, chart) in zip(panels.ravel(), charts.items(), strict=False):
            _chart(panel, chart)
            panel.set_title(name, fontsize=10)
            x, y = labels or chart.axes
            panel.set_xlabel(x)
            if panel in panels[:, 0]:
                panel.set_ylabel(y)
        _legend(figure)
        if title:
            figure.suptitle(title, fontsize=10.5)
        figure.draw_without_rendering()  # settles fonts while the style is in force
    return figure


def _chart(panel: Any, chart: StabilityChart) -> None:
    panel.set_facecolor(STABLE)  # the ground, so that no seams show between stable regions
    for region in chart.regions:
        if not region.stable:
            panel.fill(*region.outline.T, linewidth=0, zorder=1, **_hatched())
    low, high = chart.window
    for curve in chart.curves:
        panel.plot(*curve.T, color=INK, linewidth=1.0, solid_capstyle="round", zorder=3)
    panel.set(xlim=(-1, 1), ylim=(low, high))
    for line in _excluded(chart):
        if low < line < high:
            panel.axhline(line, color=MARK, linewidth=0.8, linestyle=(0, (4, 2.5)), zorder=3)


def _hatched() -> dict[str, Any]:
    return {"facecolor": UNSTABLE, "hatch": "////", "edgecolor": "#d9a090"}


def _excluded(chart: StabilityChart) -> list[float]:
    """Where the family has no member: real roots of a polynomial in one variable."""
    import sympy as sp

    if len(chart.excluded.free_symbols) != 1:
        return []
    (w,) = chart.excluded.free_symbols
    if str(w) == chart.axes[0]:
        return []
    roots = sp.Poly(chart.excluded, w).sqf_part().nroots(n=20)
    return [float(sp.re(r)) for r in roots if abs(sp.im(r)) < 1e-12]


def _legend(figure: Any) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    keys = [
        Patch(facecolor=STABLE, edgecolor="#9fb2c6", linewidth=0.4, label="stable"),
        Patch(linewidth=0, label="unstable", **_hatched()),
        Line2D([], [], color=INK, linewidth=1.0, label="$f''(x) = 0$"),
        Line2D([], [], color=MARK, linewidth=0.8, linestyle=(0, (4, 2.5)), label="no precession"),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=4, frameon=False, fontsize=8.5)
