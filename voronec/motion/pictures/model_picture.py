"""The picture of a smallest model: what depends on what, from the core of a motion to the outputs.

Variables whose rates depend on one another share a box; what follows from them stands to the right,
what is wanted at the right end; what is left out is pale.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from voronec.algebra.typeset import symbol_latex
from voronec.declaration.figure_style import FAINT, INK, PALE, SOFT, draw_arrow, figure_in_style
from voronec.motion.formulation import Formulation, Model, dependence
from voronec.motion.pictures.layered_layout import Layout, layered_layout


@dataclass(frozen=True)
class ModelBox:
    """Names that share a part: the kind of ``Role``, or ``wanted`` for an output that is no
    variable; ``title`` says it in words, names in it as mathematics."""

    names: tuple[str, ...]
    kind: str
    title: str


def boxes(model: Model) -> tuple[dict[str, ModelBox], set[tuple[str, str]]]:
    """Boxes by key, and arrows between their keys.

    A cycle of dependence is one box, with what first integrals give inside it; what is dropped is
    one box; quadratures and constants that stand alike to all others share one.
    """
    kinds = {role.variable: role.kind for role in model.roles}
    arrows = _arrows(model, kinds)
    key = _cycles(kinds, arrows)
    wanted = {name: held for name, held in _output_sources(model).items() if name not in key}
    key |= {f"= {name}": f"= {name}" for name in wanted}
    arrows |= {(x, f"= {name}") for name, held in wanted.items() for x in held}
    pairs = {(key[a], key[b]) for a, b in arrows if a in key and b in key and key[a] != key[b]}
    merged = _alike(key, kinds, pairs, {*model.outputs})
    key = {x: merged.get(k, k) for x, k in key.items()}
    pairs = {(merged.get(a, a), merged.get(b, b)) for a, b in pairs}
    members: dict[str, list[str]] = {}
    for x, k in key.items():
        members.setdefault(k, []).append(x)
    nodes = {k: _box(k, names, kinds, model) for k, names in members.items()}
    return nodes, {(a, b) for a, b in pairs if a != b}


def _arrows(model: Model, kinds: Mapping[str, str]) -> set[tuple[str, str]]:
    """Which variable stands in the rate, or in the formula, of which other one."""
    kept = {str(x) for x in model.states}
    arrows = _edges(model.cut)
    for x, y in _edges(model.full):
        to_dropped = kinds.get(y) == "dropped" and kinds.get(x) != "zero"
        by_given = kinds.get(x) in ("constant", "integral") and y in kept
        if to_dropped or by_given:
            arrows.add((x, y))
    for name, formula in model.cut.stages:
        if kinds.get(str(name)) == "integral":
            arrows |= {(str(s), str(name)) for s in formula.free_symbols if str(s) in kinds}
    return {(a, b) for a, b in arrows if a != b}


def _edges(formulation: Formulation) -> set[tuple[str, str]]:
    """Names of variables x and y where the rate of y holds x."""
    return {(str(x), str(y)) for y, sources in dependence(formulation).items() for x in sources}


def _cycles(kinds: Mapping[str, str], arrows: Iterable[tuple[str, str]]) -> dict[str, str]:
    """The key of each variable's box: cycles together, the dropped together, the others alone."""
    import networkx as nx

    graph = nx.DiGraph()
    moving = {x for x, kind in kinds.items() if kind in ("integrated", "integral", "quadrature")}
    graph.add_nodes_from(moving)
    graph.add_edges_from((a, b) for a, b in arrows if a in moving and b in moving)
    circles = {x: min(c) for c in nx.strongly_connected_components(graph) for x in c}
    shown = [x for x, kind in kinds.items() if kind not in ("replaced", "read off")]
    return {x: "dropped" if kinds[x] == "dropped" else circles.get(x, x) for x in shown}


def _output_sources(model: Model) -> dict[str, set[str]]:
    """What each output is computed from."""
    cut = model.cut
    stages = {str(name): formula for name, formula in cut.stages}
    kinds = {role.variable: role.kind for role in model.roles}
    held: dict[str, set[str]] = {
        name: {str(s) for s in e.free_symbols} for name, e in cut.outputs.items()
    }
    held |= {name: {str(s) for s in angle.symbols} for name, angle in cut.angles.items()}
    sources = {}
    for name, symbols in held.items():
        seen: set[str] = set()
        stack = list(symbols)
        while stack:
            s = stack.pop()
            if s not in seen:
                seen.add(s)
                if s in stages and kinds.get(s) != "integral":
                    stack.extend(map(str, stages[s].free_symbols))
        kept = {s for s in seen if s in kinds and kinds[s] not in ("dropped", "replaced")}
        # what is zero is not there any more, unless it is wanted itself
        sources[name] = kept or ({name} if kinds.get(name) == "zero" else set())
    return sources


def _alike(
    key: Mapping[str, str],
    kinds: Mapping[str, str],
    pairs: Iterable[tuple[str, str]],
    outputs: set[str],
) -> dict[str, str]:
    """Boxes of one kind with the same arrows, all of them wanted or none, are one."""
    pairs = set(pairs)
    groups: dict[Any, list[str]] = {}
    for k in dict.fromkeys(key.values()):
        kind = "wanted" if k.startswith("= ") else kinds.get(k, "dropped")
        if kind in ("integrated", "dropped"):
            continue
        before = frozenset(a for a, b in pairs if b == k)
        after = frozenset(b for a, b in pairs if a == k)
        groups.setdefault((kind, k in outputs, before, after), []).append(k)
    return {k: group[0] for group in groups.values() for k in group}


def _box(key: str, members: list[str], kinds: Mapping[str, str], model: Model) -> ModelBox:
    names = tuple(x.removeprefix("= ") for x in members)
    if key.startswith("= "):
        read = all(n in model.cut.angles for n in names)
        return ModelBox(names, "wanted", "wanted, read off" if read else "wanted")
    kind = "integrated" if "integrated" in {kinds[x] for x in members} else kinds[members[0]]
    titles = {
        "integrated": "integrated" if len(names) == 1 else "integrated together",
        "quadrature": "quadrature" if len(names) == 1 else "quadratures",
        "integral": "by a first integral",
        "constant": "constant",
        "zero": "zero for ever",
        "dropped": "dropped",
    }
    title = titles[kind]
    given = [x for x in members if kinds[x] == "integral"]
    if kind == "integrated" and given:
        title = f"{_list_names(given)} by a first integral"
    wanted = [x for x in members if x in model.outputs]
    if wanted:
        title += ", wanted" if len(wanted) == len(members) else f"; {_list_names(wanted)} wanted"
    return ModelBox(names, kind, title)


def _list_names(names: Iterable[str]) -> str:
    return ", ".join(map(_show_name, names))


def _show_name(name: str) -> str:
    """A name as mathematics; what is no bare name stays text."""
    if not name.replace("_", "").isalnum() or not name[0].isalpha():
        return name.replace("$", r"\$")
    if name.endswith("dot") and len(name) > 3:
        return rf"$\dot{{{symbol_latex(name[:-3])}}}$"
    latex = symbol_latex(name)
    if "_" in name and latex.split("_")[0].isalpha() and name.index("_") > 1:
        latex = r"\mathrm{" + name.replace("_", r"\ ") + "}"  # words, not a letter with an index
    return f"${latex}$"


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

    nodes, edges = boxes(model)
    graph = nx.DiGraph()
    graph.add_nodes_from(nodes)
    graph.add_edges_from(edges)
    layout = layered_layout(graph)
    places, bends, (width, height) = _places(layout, nodes)
    with figure_in_style(width, height, layout=None) as figure:
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, width), ylim=(0, height))
        axes.set_axis_off()
        for pair in sorted(edges):
            _arrow(axes, nodes, places, pair, bends.get(pair, ()))
        for key, box in nodes.items():
            _draw(axes, box, places[key])
    return figure


def _places(
    layout: Layout, found: Mapping[str, ModelBox]
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


def _size(box: ModelBox) -> Place:
    """Width and height in inches."""
    lines = _lines(box)
    longest = max(*(_letters(line) for line in lines), _room(box.title) * 0.72)
    return longest * LETTER + 2 * PAD, (len(lines) + 0.8) * LINE + PAD


def _lines(box: ModelBox) -> list[list[str]]:
    """The names in a box, as many in a line as have room."""
    rows: list[list[str]] = [[]]
    for name in box.names:
        if rows[-1] and _letters([*rows[-1], name]) > PER_LINE:
            rows.append([])
        rows[-1].append(name)
    return rows


def _letters(names: Sequence[str]) -> int:
    """The room that names take, in letters; a Greek letter is one."""
    return sum(_room(_show_name(n)) for n in names) + 2 * len(names) - 2


def _room(text: str) -> int:
    """Letters of a text in which commands of mathematics may stand."""
    bare = re.sub(r"\\mathrm|\\dot|[{}$_]", "", text)
    return len(re.sub(r"\\[a-zA-Z]+", "x", bare))


def _draw(axes: Any, box: ModelBox, place: Place) -> None:
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
        text = ",  ".join(map(_show_name, names))
        axes.text(place[0], top - i * LINE, text, ha="center", va="center", fontsize=9.5,
                  color=ink, zorder=4)  # fmt: skip
    axes.text(
        place[0], top - (len(lines) - 0.05) * LINE, box.title, ha="center", va="center",
        fontsize=6.8, color=ink if box.kind == "dropped" else "#5a6672", zorder=4, style="italic",
    )  # fmt: skip


def _arrow(
    axes: Any, found: Mapping[str, ModelBox], places: Mapping[str, Place], pair: tuple[str, str],
    bends: Sequence[Place],
) -> None:  # fmt: skip
    """A smooth arrow from the side of one box to the side of another."""
    a, b = pair
    color = FAINT if found[b].kind == "dropped" else SOFT
    (xa, ya), (xb, yb) = places[a], places[b]
    forth = 1 if xb > xa else -1
    begin = (xa + forth * _size(found[a])[0] / 2, ya)
    end = (xb - forth * (_size(found[b])[0] / 2 + 0.07), yb)
    tip = (end[0] + forth * 0.07, end[1])
    draw_arrow(axes, [begin, *bends, end], (end, tip), color, 0.8)
