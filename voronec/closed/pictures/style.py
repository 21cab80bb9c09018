"""The style that all figures share, and the arrows between the boxes of some.

Figures are made without pyplot, so no window opens and no global state is touched.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

__all__ = ["FAINT", "INK", "MARK", "PALE", "SOFT", "STYLE", "WIDTH", "draw_arrow"]

INK, PALE, SOFT, FAINT, MARK = "#1b3a5c", "#a9b7c6", "#8a97a6", "#dfe4ea", "#b3361e"
STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["DejaVu Serif"],
    "mathtext.fontset": "cm",
    "font.size": 9,
    "axes.labelsize": 10,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "axes.formatter.use_mathtext": True,
    "svg.fonttype": "path",
}
WIDTH = 6.4
"""Inches: the text width of a page."""


def draw_arrow(
    axes: Any,
    points: Sequence[tuple[float, float]],
    head: tuple[tuple[float, float], tuple[float, float]],
    color: str,
    width: float,
    dashes: str = "-",
) -> None:
    """A smooth curve through points of a figure, level at each, and the head of an arrow.

    ``head`` are the ends of the line under the head, ``width`` is that of all lines in points, and
    ``dashes`` the style of the curve in matplotlib's words.
    """
    from matplotlib.patches import FancyArrowPatch, PathPatch
    from matplotlib.path import Path

    vertices, codes = [points[0]], [Path.MOVETO]
    for (x0, y0), (x1, y1) in pairwise(points):
        middle = (x0 + x1) / 2
        vertices += [(middle, y0), (middle, y1), (x1, y1)]
        codes += [Path.CURVE4] * 3
    style: dict[str, Any] = {"edgecolor": color, "linewidth": width, "zorder": 2}
    axes.add_patch(PathPatch(Path(vertices, codes), facecolor="none", linestyle=dashes, **style))
    axes.add_patch(
        FancyArrowPatch(*head, arrowstyle="-|>", mutation_scale=7, facecolor=color, shrinkA=0,
                        shrinkB=0, **style)
    )  # fmt: skip
