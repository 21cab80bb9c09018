"""The picture of systems and relations: layers from the special to the general and to limits."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from voronec.declaration.figure_style import INK, MARK, PALE, SOFT, STYLE, draw_arrow
from voronec.motion.pictures.layered_layout import Layout, layered_layout

LINES: dict[str, Any] = {
    "specialisation": "solid",
    "change of coordinates": (0, (1, 1.2)),
    "change of time": (0, (6, 1.5, 1, 1.5)),
    "limit": (0, (4, 2.2)),
}
"""The kinds of relations that are told apart, each with its line."""
HUES = dict(zip(LINES, (INK, "#2f7d5b", "#8a5a12", "#6a4c93"), strict=True))
Known = Mapping[str, str] | None
COLUMN, ROW = 2.75, 0.5
"""Inches from layer to layer, and for one unit of height."""
FONTS = {"font.family": ["DejaVu Serif", "DejaVu Sans"]}  # the second one has the arrow
HALF = 0.86
"""Half the width of a label, in inches."""


def diagram_figure(graph: Any, status: Known = None) -> Any:
    """A matplotlib figure of a diagram; ``status`` gives the verdicts of relations by label.

    What is not proved is drawn in red, what nobody has checked pale.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    layout = layered_layout(graph)
    width, low, high = _extent(layout)
    with rc_context(STYLE | FONTS):
        figure = Figure(figsize=(width, high - low))
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(-HALF - 0.25, width - HALF - 0.25), ylim=(low, high))
        axes.set_axis_off()
        places = {n: _inches(p) for n, p in layout.places.items()}
        places |= _beside(layout, width, low)
        for pair in sorted({(a, b) for a, b in graph.edges() if a != b}):
            _draw_edges(axes, graph, pair, places, layout, status)
        for node, place in places.items():
            turns = [d["relation"] for a, b, d in graph.edges(data=True) if a == b == node]
            _draw_node(axes, node, place, turns, status)
        _legend(axes, status)
        figure.draw_without_rendering()  # settles fonts while the style is in force
    return figure


def _inches(place: tuple[float, float]) -> tuple[float, float]:
    return place[0] * COLUMN, -place[1] * ROW


def _extent(layout: Layout) -> tuple[float, float, float]:
    """The width, and the lowest and the highest ordinate."""
    points = [*layout.places.values(), *(p for way in layout.bends.values() for p in way)]
    xs, ys = ([p[i] for p in map(_inches, points)] or [0.0] for i in (0, 1))
    width = max(xs) + 2 * HALF + 0.5
    width = max(width, 3 * COLUMN)
    rows = -(-len(layout.alone) // _per_row(width))
    return width, min(ys) - 0.7 - 0.6 * rows, max(ys) + 1.0


def _per_row(width: float) -> int:
    return max(1, int(width // (2 * HALF + 0.3)))


def _beside(layout: Layout, width: float, low: float) -> dict[Any, tuple[float, float]]:
    """Systems without relations, in rows at the foot."""
    per = _per_row(width)
    rows = -(-len(layout.alone) // per)
    return {
        node: ((i % per) * (2 * HALF + 0.3), low + 0.4 + 0.6 * (rows - 1 - i // per))
        for i, node in enumerate(layout.alone)
    }


def _draw_node(axes: Any, node: str, place: Any, turns: Sequence[Any], known: Known) -> None:
    """A name in its box; loops, the automorphisms, are a turned arrow with their number."""
    from matplotlib.patches import FancyBboxPatch

    lines = textwrap.wrap(node, 24, break_long_words=False)
    width, height = 2 * HALF - 0.08, 0.12 + 0.125 * len(lines)
    corner = (place[0] - width / 2, place[1] - height / 2)
    style = "round,pad=0.04,rounding_size=0.07"
    axes.add_patch(
        FancyBboxPatch(corner, width, height, style, fc="white", ec=SOFT, lw=0.7, zorder=3)
    )
    axes.text(
        *place, "\n".join(lines), ha="center", va="center", fontsize=7.5, color="#111111",
        linespacing=1.15, zorder=4,
    )  # fmt: skip
    if turns:
        color = _color([r.label for r in turns], known, INK)
        mark = "\u21bb" + (f" {len(turns)}" if len(turns) > 1 else "")
        axes.text(
            place[0] + HALF - 0.06, place[1], mark, fontsize=8, color=color, zorder=5,
            ha="right", va="center", fontfamily="DejaVu Sans",
        )  # fmt: skip


def _draw_edges(
    axes: Any, graph: Any, pair: tuple[str, str], places: Any, layout: Layout, known: Known
) -> None:
    """All relations of one system with another, side by side."""
    relations = [data["relation"] for data in graph[pair[0]][pair[1]].values()]
    forth = 1 if places[pair[1]][0] > places[pair[0]][0] else -1
    bends = [_inches(p) for p in layout.bends.get(pair, ())]
    # Level where it passes a layer, so that it stays clear of the boxes above and below.
    level = [(x + end * forth * HALF, y) for x, y in bends for end in (-1, 1)]
    way = [places[pair[0]], *level, places[pair[1]]]
    for number, relation in enumerate(relations):
        shift = (number - (len(relations) - 1) / 2) * 0.14
        kind = relation.line
        _draw_arrow(axes, way, shift, kind, _color([relation.label], known, HUES[kind]))


def _color(labels: Sequence[str], known: Known, usual: str) -> str:
    """Red for what is not proved, pale for what nobody has checked."""
    if known is None:
        return usual
    if any(known.get(label, "proved") != "proved" for label in labels):
        return MARK
    return usual if all(label in known for label in labels) else PALE


def _draw_arrow(axes: Any, way: Sequence[Any], shift: float, kind: str, color: str) -> None:
    """A smooth curve through the points of its way, level where it begins and ends."""
    forth = 1 if way[-1][0] > way[0][0] else -1
    points = [(x, y + shift) for x, y in way]
    points[0] = (points[0][0] + forth * HALF, points[0][1])
    points[-1] = (points[-1][0] - forth * (HALF + 0.08), points[-1][1])
    x, y = points[-1]
    draw_arrow(
        axes, points, ((x - forth * 0.03, y), (x + forth * 0.07, y)), color, 0.9, LINES[kind]
    )


def _legend(axes: Any, known: Known) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=HUES[kind], linestyle=line, linewidth=1.1, label=kind)
        for kind, line in LINES.items()
    ]
    if known is not None:
        handles.append(Line2D([], [], color=MARK, linewidth=1.1, label="not proved"))
        handles.append(Line2D([], [], color=PALE, linewidth=1.1, label="not checked"))
    handles.append(Line2D([], [], linestyle="", label="\u21bb  automorphism"))
    axes.legend(
        handles=handles, loc="upper left", ncols=len(handles), frameon=False, fontsize=8,
        handlelength=3.2, borderaxespad=0.6,
    )  # fmt: skip
