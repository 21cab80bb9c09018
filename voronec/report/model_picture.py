"""The picture of a smallest model: what depends on what, from the core of a motion to the outputs.

Variables whose rates depend on one another share a box; what follows from them stands to the right,
what is wanted at the right end; what is left out is pale.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from voronec.model import Model
from voronec.report.layers import Layout, layered
from voronec.report.model_boxes import Box, boxes, shown
from voronec.report.style import FAINT, INK, PALE, SOFT, STYLE

__all__ = ["model_figure"]

GAP, SPACE = 0.62, 0.22
"""Inches from box to box: across, and from row to row."""
LINE, LETTER, PAD = 0.185, 0.09, 0.12
"""Inches: the height of a line, the width of a letter, and the room around them."""
PER_LINE = 22
"""Letters in a line of a box."""
EDGE = 0.15
"""The margin in inches; whoever sets the picture in a page adds a page's."""
LOOKS: Mapping[str, tuple[str, str, str, Any]] = {
    "integrated": (INK, "#eef2f6", "#111111", "solid"),
    "quadrature": (SOFT, "white", "#111111", "solid"),
    "read off": (SOFT, "white", "#111111", "solid"),
    "integral": (SOFT, "white", "#111111", (0, (4, 2))),
    "constant": (SOFT, "white", "#444444", (0, (1, 1.2))),
    "zero": (SOFT, "white", "#444444", (0, (1, 1.2))),
    "wanted": ("white", "white", INK, "solid"),
    "dropped": (FAINT, "white", PALE, "solid"),
}
"""Edge, face, letters and line of each kind of box."""
Place = tuple[float, float]


def model_figure(model: Model) -> Any:
    """A matplotlib figure of what a model keeps, what follows, and what is dropped."""
    import networkx as nx
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    found, edges = boxes(model)
    graph = nx.DiGraph()
    graph.add_nodes_from(found)
    graph.add_edges_from(edges)
    layout = layered(graph)
    places, bends, (width, height) = _places(layout, found)
    with rc_context(STYLE):
        figure = Figure(figsize=(width, height))
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, width), ylim=(0, height))
        axes.set_axis_off()
        for pair in sorted(edges):
            _arrow(axes, found, places, pair, bends.get(pair, ()))
        for key, box in found.items():
            _draw(axes, box, places[key])
        figure.draw_without_rendering()  # settles fonts while the style is in force
    return figure


def _places(
    layout: Layout, found: Mapping[str, Box]
) -> tuple[dict[str, Place], dict[Any, list[Place]], Place]:
    """The middles of the boxes, the points on the ways of long edges, width and height; inches."""
    sizes = {key: _size(box) for key, box in found.items()}
    layers = sorted({x for x, _ in layout.places.values()})
    wide = {x: max(sizes[k][0] for k, p in layout.places.items() if p[0] == x) for x in layers}
    middle, left = {}, EDGE
    for x in layers:
        middle[x] = left + wide[x] / 2
        left += wide[x] + GAP
    points = [*layout.places.values(), *(p for way in layout.bends.values() for p in way)]
    row = max((sizes[k][1] for k in layout.places), default=0.0) + SPACE
    alone, foot, across = _alone(layout.alone, sizes)
    ends = [-p[1] * row - sizes[k][1] / 2 for k, p in layout.places.items()]
    ends += [-y * row for _, y in points]
    lift = EDGE + foot - min(ends, default=0.0)

    def at(point: Place, side: float = 0.0) -> Place:
        across = side * wide[point[0]] / 2
        return middle[point[0]] + across, lift - point[1] * row

    places = {key: at(p) for key, p in layout.places.items()} | alone
    # level where it passes a layer, so that it stays clear of the boxes above and below
    bends = {
        (a, b): [at(p, end if places[b] > places[a] else -end) for p in way for end in (-1, 1)]
        for (a, b), way in layout.bends.items()
    }
    tops = [places[k][1] + sizes[k][1] / 2 for k in places] + [
        y for way in bends.values() for _, y in way
    ]
    width = max(left - GAP if layers else 0.0, across) + EDGE
    return places, bends, (width, max(tops, default=1.0) + EDGE)


def _alone(
    keys: Sequence[str], sizes: Mapping[str, Place]
) -> tuple[dict[str, Place], float, float]:
    """Boxes without arrows in a row at the foot: their places, its height and its end."""
    height = max((sizes[k][1] for k in keys), default=0.0)
    places, x = {}, EDGE
    for key in keys:
        places[key] = (x + sizes[key][0] / 2, EDGE + height / 2)
        x += sizes[key][0] + SPACE
    return places, height + SPACE if keys else 0.0, x - SPACE


def _size(box: Box) -> Place:
    """Width and height in inches."""
    lines = _lines(box)
    longest = max(*(_letters(line) for line in lines), _room(box.title) * 0.72)
    return longest * LETTER + 2 * PAD, (len(lines) + 0.8) * LINE + PAD


def _lines(box: Box) -> list[list[str]]:
    """The names in a box, as many in a line as have room."""
    rows: list[list[str]] = [[]]
    for name in box.names:
        if rows[-1] and _letters([*rows[-1], name]) > PER_LINE:
            rows.append([])
        rows[-1].append(name)
    return rows


def _letters(names: Sequence[str]) -> int:
    """The room that names take, in letters; a Greek letter is one."""
    return sum(_room(shown(n)) for n in names) + 2 * len(names) - 2


def _room(text: str) -> int:
    """Letters of a text in which commands of mathematics may stand."""
    bare = re.sub(r"\\mathrm|\\dot|[{}$_]", "", text)
    return len(re.sub(r"\\[a-zA-Z]+", "x", bare))


def _draw(axes: Any, box: Box, place: Place) -> None:
    """A box with its names, and below them in small letters what it is."""
    from matplotlib.patches import FancyBboxPatch

    edge, face, ink, line = LOOKS[box.kind]
    width, height = _size(box)
    corner = (place[0] - width / 2, place[1] - height / 2)
    style = "round,pad=0,rounding_size=0.06"
    axes.add_patch(
        FancyBboxPatch(
            corner, width, height, style, fc=face, ec=edge, lw=0.8, linestyle=line, zorder=3
        )
    )
    lines = _lines(box)
    top = place[1] + height / 2 - PAD / 2 - LINE / 2
    for i, names in enumerate(lines):
        text = ",  ".join(map(shown, names))
        axes.text(place[0], top - i * LINE, text, ha="center", va="center", fontsize=9.5,
                  color=ink, zorder=4)  # fmt: skip
    axes.text(
        place[0], top - (len(lines) - 0.05) * LINE, box.title, ha="center", va="center",
        fontsize=6.8, color=ink if box.kind == "dropped" else "#5a6672", zorder=4, style="italic",
    )  # fmt: skip


def _arrow(
    axes: Any, found: Mapping[str, Box], places: Mapping[str, Place], pair: tuple[str, str],
    bends: Sequence[Place],
) -> None:  # fmt: skip
    """A smooth arrow from the side of one box to the side of another."""
    from matplotlib.patches import FancyArrowPatch, PathPatch
    from matplotlib.path import Path

    a, b = pair
    color = FAINT if found[b].kind == "dropped" else SOFT
    (xa, ya), (xb, yb) = places[a], places[b]
    forth = 1 if xb > xa else -1
    begin = (xa + forth * _size(found[a])[0] / 2, ya)
    end = (xb - forth * (_size(found[b])[0] / 2 + 0.07), yb)
    points = [begin, *bends, end]
    vertices, codes = [points[0]], [Path.MOVETO]
    for (x0, y0), (x1, y1) in pairwise(points):
        middle = (x0 + x1) / 2
        vertices += [(middle, y0), (middle, y1), (x1, y1)]
        codes += [Path.CURVE4] * 3
    style: dict[str, Any] = {"edgecolor": color, "linewidth": 0.8, "zorder": 2}
    axes.add_patch(PathPatch(Path(np.array(vertices), codes), facecolor="none", **style))
    tip = (end[0] + forth * 0.07, end[1])
    axes.add_patch(
        FancyArrowPatch(end, tip, arrowstyle="-|>", mutation_scale=7, facecolor=color, shrinkA=0,
                        shrinkB=0, **style)
    )  # fmt: skip
