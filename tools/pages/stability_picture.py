"""Stability charts of regular precessions: one panel for each way of rolling."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.declaration.figure_style import INK, MARK, figure_in_style
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.closed.special.stability_chart import StabilityChart

STABLE, UNSTABLE = "#e3ecf5", "#f3d9d2"
"""Told apart in print without colours, too: the second is hatched."""

FINE = 2e-4
"""Of the panel: 1/30 of a point."""
SMALL = 0.15
"""Of a region: a width in x that is hardly seen."""


def stability_figure(
    charts: Mapping[str, StabilityChart],
    labels: tuple[str, str] | None = None,
    note: str = "",
) -> Any:
    """A matplotlib ``Figure``: where regular precessions are stable.

    charts
        title of a panel -> chart, whose regions and boundary curves are drawn.
    labels
        of the two axes, as mathtext; the names of the chart unless told.
    note
        small words above the legend.

    Unstable regions too small for the panel are shown once more in a corner, larger.
    """
    from matplotlib import rc_context

    if not charts:
        raise DefinitionError("there is no chart to draw")
    columns = min(3, len(charts))
    rows = -(-len(charts) // columns)
    size = (0.5 + 1.95 * columns, 0.8 + 2.2 * rows)
    with rc_context({"hatch.linewidth": 0.35}), figure_in_style(*size) as figure:
        panels = figure.subplots(rows, columns, squeeze=False)
        for panel in panels.ravel()[len(charts) :]:
            panel.set_axis_off()
        for panel, (name, chart) in zip(panels.ravel(), charts.items(), strict=False):
            _chart(panel, chart)
            panel.set_title(name, fontsize=9)
            x, y = labels or chart.axes
            if panel in panels[-1]:
                panel.set_xlabel(x)
            if panel in panels[:, 0]:
                panel.set_ylabel(y)
        _legend(figure, note)
    return figure


def _chart(panel: Any, chart: StabilityChart) -> None:
    panel.set(xlim=(-1, 1), ylim=chart.window, xticks=(-1, -0.5, 0, 0.5, 1))
    _draw_regions(panel, chart)
    panel.set_xticklabels(("$-1$", "", "0", "", "1"))
    small = [r.outline for r in chart.regions if not r.stable and np.ptp(r.outline[:, 0]) < SMALL]
    if small:
        _enlarge(panel, chart, np.concatenate(small))


def _draw_regions(panel: Any, chart: StabilityChart) -> None:
    """Regions, their boundaries, and rates without a member, for the limits of a panel."""
    low, high = panel.get_ylim()
    size = np.array([np.ptp(panel.get_xlim()), high - low])
    panel.set_facecolor(STABLE)  # the ground, so that no seams show between stable regions
    for region in chart.regions:
        if not region.stable:
            panel.fill(*thin_line(region.outline, size).T, linewidth=0, zorder=1, **_hatching())
    for curve in chart.curves:
        panel.plot(*thin_line(curve, size).T, color=INK, linewidth=1.0, solid_capstyle="round",
                   zorder=3)  # fmt: skip
    for line in _excluded_rates(chart):
        if low < line < high:
            panel.axhline(line, color=MARK, linewidth=0.8, linestyle=(0, (4, 2.5)), zorder=3)


def thin_line(points: np.ndarray, size: np.ndarray) -> np.ndarray:
    """The points of a line that it needs, by Douglas and Peucker: both its ends among them."""
    if len(points) < 3:
        return points
    away = (points - points[0]) / size
    way = away[-1]
    length = float(np.hypot(*way))
    off = np.hypot(*away.T)
    if length > 0:
        off = np.abs(way[0] * away[:, 1] - way[1] * away[:, 0]) / length
    far = int(np.argmax(off))
    if off[far] < FINE:
        return points[[0, -1]]
    return np.concatenate([thin_line(points[: far + 1], size)[:-1], thin_line(points[far:], size)])


def _enlarge(panel: Any, chart: StabilityChart, points: np.ndarray) -> None:
    """What is around some points, in a corner."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    (left, low), (right, high) = middle - np.ptp(points, axis=0), middle + np.ptp(points, axis=0)
    corner = panel.inset_axes((0.63, 0.04, 0.34, 0.2), xlim=(left, right), ylim=(low, high))
    corner.set(xticks=(), yticks=())
    corner.spines[:].set(color="#444444", linewidth=0.5)
    _draw_regions(corner, chart)
    panel.indicate_inset_zoom(corner, edgecolor="#444444", linewidth=0.5, alpha=1.0)


def _hatching() -> dict[str, Any]:
    return {"facecolor": UNSTABLE, "hatch": "////", "edgecolor": "#d9a090"}


def _excluded_rates(chart: StabilityChart) -> list[float]:
    """Where the family has no member: real roots of a polynomial in one variable."""
    import sympy as sp

    if len(chart.excluded.free_symbols) != 1:
        return []
    (w,) = chart.excluded.free_symbols
    if str(w) == chart.axes[0]:
        return []
    roots = sp.Poly(chart.excluded, w).sqf_part().nroots(n=20)
    return [float(sp.re(r)) for r in roots if abs(sp.im(r)) < 1e-12]


def _legend(figure: Any, note: str) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    keys = [
        Patch(facecolor=STABLE, edgecolor="#9fb2c6", linewidth=0.4, label="stable"),
        Patch(linewidth=0, label="unstable", **_hatching()),
        Line2D([], [], color=INK, linewidth=1.0, label="$f''(x) = 0$"),
        Line2D([], [], color=MARK, linewidth=0.8, linestyle=(0, (4, 2.5)), label="no precession"),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=4, frameon=False, fontsize=8,
                  title=note or None, title_fontsize=8)  # fmt: skip
