"""The picture of a bifurcation diagram."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.declaration.figure_style import FAINT, INK, MARK, SOFT, figure_in_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = {"stable": INK, "saddle": MARK, "degenerate": "#b8860b", "isolated": INK}
SHADES = ("#ffffff", "#eef2f6", "#dce5ee", "#c6d5e4", "#aec4d8", "#96b3cd")
"""Of regions with no, one, two, ... tori."""


def diagram_figure(diagram: Any) -> Figure:
    """Critical curves, those of saddles in another colour; regions in shades, with the number of
    components; steady motions as dots, hollow where they are unstable."""
    with figure_in_style(5.6, 4.6) as figure:
        panel = figure.subplots()
        if diagram.raster is not None:
            _shade(panel, diagram)
        for kind, colour in COLOURS.items():
            for curve in diagram.curves:
                near = curve.kinds == kind
                near[1:] |= near[:-1].copy()
                x, y = np.where(near[:, None], curve.values, np.nan).T
                panel.plot(x, y, "." if len(curve) == 1 else "-", color=colour, linewidth=1.2)
            if any((curve.kinds == kind).any() for curve in diagram.curves):
                panel.plot([], [], "-", color=colour, label=kind)
        for value, motion in zip(diagram.steady_values, diagram.steady, strict=True):
            unstable = motion.verdict.word == "unstable"
            panel.plot(*value, "o", markersize=4.5, color=MARK if unstable else INK,
                       markerfacecolor="white" if unstable else INK, zorder=4)  # fmt: skip
        panel.set_xlim(*diagram.window[0])
        panel.set_ylim(*diagram.window[1])
        panel.set(xlabel=diagram.axes[0], ylabel=diagram.axes[1])
        held = ", ".join(f"{name} = {value:.4g}" for name, value in diagram.held.items())
        title = diagram.system.title or diagram.system.name
        panel.set_title(f"{title}{f': {held}' if held else ''}", fontsize=9)
        if panel.get_legend_handles_labels()[0]:
            panel.legend(fontsize=7, frameon=False)
    return figure


def _shade(panel: Any, diagram: Any) -> None:
    from matplotlib.colors import ListedColormap

    counts = [-1 if r.components is None else r.components for r in diagram.regions]
    shown = np.array([*(min(max(c, 0), len(SHADES) - 1) for c in counts), 0])
    cells = shown[diagram.raster.labels].T  # -1, on curves, takes the last
    extent = (*diagram.window[0], *diagram.window[1])
    panel.imshow(cells, origin="lower", extent=extent, aspect="auto", cmap=ListedColormap(SHADES),
                 vmin=-0.5, vmax=len(SHADES) - 0.5, interpolation="nearest")  # fmt: skip
    for region, count in zip(diagram.regions, counts, strict=True):
        if region.share > 0.004:
            words = {-1: "?", 0: "none"}.get(count, str(count))
            panel.text(*region.place, words, ha="center", va="center", fontsize=9, color="#333333",
                       bbox={"facecolor": FAINT, "edgecolor": SOFT, "linewidth": 0.4,
                             "boxstyle": "round,pad=0.2"})  # fmt: skip
