"""The style that all figures share, and the arrows between the boxes of some.

Figures are made without pyplot, so no window opens and no global state is touched.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

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
NO_SPACE = {"w_pad": 0.02, "h_pad": 0.02, "wspace": 0, "hspace": 0}
"""Of the layout of panels that are as close to each other as may be."""


@contextmanager
def figure_in_style(width: float, height: float, layout: Any = "constrained") -> Iterator[Any]:
    """A matplotlib ``Figure`` of so many inches, to be drawn on while the style is in force."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout=layout)
        yield figure
        figure.draw_without_rendering()  # settles fonts while the style is in force


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
