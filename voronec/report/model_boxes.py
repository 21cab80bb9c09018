"""The variables of a model put together for a picture: one box for what plays one part."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from voronec.algebra.typeset import symbol_latex
from voronec.model import Model
from voronec.model.dependence import dependence

__all__ = ["Box", "boxes", "shown"]


@dataclass(frozen=True)
class Box:
    """Names that share a part: the kind of ``Role``, or ``wanted`` for an output that is no
    variable; ``title`` says it in words, names in it as mathematics."""

    names: tuple[str, ...]
    kind: str
    title: str


def boxes(model: Model) -> tuple[dict[str, Box], set[tuple[str, str]]]:
    """Boxes by key, and arrows between their keys.

    A cycle of dependence is one box, with what first integrals give inside it; what is dropped is
    one box; quadratures and constants that stand alike to all others share one.
    """
    kinds = {role.variable: role.kind for role in model.roles}
    arrows = _arrows(model, kinds)
    key = _cycles(kinds, arrows)
    wanted = {name: held for name, held in _wanted(model).items() if name not in key}
    key |= {f"= {name}": f"= {name}" for name in wanted}
    arrows |= {(x, f"= {name}") for name, held in wanted.items() for x in held}
    pairs = {(key[a], key[b]) for a, b in arrows if a in key and b in key and key[a] != key[b]}
    merged = _alike(key, kinds, pairs, {*model.outputs})
    key = {x: merged.get(k, k) for x, k in key.items()}
    pairs = {(merged.get(a, a), merged.get(b, b)) for a, b in pairs}
    members: dict[str, list[str]] = {}
    for x, k in key.items():
        members.setdefault(k, []).append(x)
    found = {k: _box(k, names, kinds, model) for k, names in members.items()}
    return found, {(a, b) for a, b in pairs if a != b}


def _arrows(model: Model, kinds: Mapping[str, str]) -> set[tuple[str, str]]:
    """Which variable stands in the rate, or in the formula, of which other one."""
    kept = {str(x) for x in model.states}
    inside = {(str(a), str(b)) for a, b in dependence(model.cut).edges}
    found = set(inside)
    for a, b in dependence(model.full).edges:
        x, y = str(a), str(b)
        to_dropped = kinds.get(y) == "dropped" and kinds.get(x) != "zero"
        by_given = kinds.get(x) in ("constant", "integral") and y in kept
        if to_dropped or by_given:
            found.add((x, y))
    for name, formula in model.cut.stages:
        if kinds.get(str(name)) == "integral":
            found |= {(str(s), str(name)) for s in formula.free_symbols if str(s) in kinds}
    return {(a, b) for a, b in found if a != b}


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


def _wanted(model: Model) -> dict[str, set[str]]:
    """What each output is computed from."""
    own = model.cut
    stages = {str(name): formula for name, formula in own.stages}
    kinds = {role.variable: role.kind for role in model.roles}
    held: dict[str, set[str]] = {
        name: {str(s) for s in e.free_symbols} for name, e in own.outputs.items()
    }
    held |= {name: {str(s) for s in angle.symbols} for name, angle in own.angles.items()}
    found = {}
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
        found[name] = kept or ({name} if kinds.get(name) == "zero" else set())
    return found


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


def _box(key: str, members: list[str], kinds: Mapping[str, str], model: Model) -> Box:
    names = tuple(x.removeprefix("= ") for x in members)
    if key.startswith("= "):
        read = all(n in model.cut.angles for n in names)
        return Box(names, "wanted", "wanted, read off" if read else "wanted")
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
        title = f"{_listed(given)} by a first integral"
    wanted = [x for x in members if x in model.outputs]
    if wanted:
        title += ", wanted" if len(wanted) == len(members) else f"; {_listed(wanted)} wanted"
    return Box(names, kind, title)


def _listed(names: Iterable[str]) -> str:
    return ", ".join(map(shown, names))


def shown(name: str) -> str:
    """A name as mathematics; what is no bare name stays text."""
    if not name.replace("_", "").isalnum() or not name[0].isalpha():
        return name.replace("$", r"\$")
    if name.endswith("dot") and len(name) > 3:
        return rf"$\dot{{{symbol_latex(name[:-3])}}}$"
    latex = symbol_latex(name)
    if "_" in name and latex.split("_")[0].isalpha() and name.index("_") > 1:
        latex = r"\mathrm{" + name.replace("_", r"\ ") + "}"  # words, not a letter with an index
    return f"${latex}$"
