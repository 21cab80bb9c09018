"""``voronec graph``: the systems and their relations, drawn or listed."""

from __future__ import annotations

import io
import json
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.cli.files import replace
from voronec.cli.output import answer, progress_line, warn
from voronec.cli.subject import is_file, name_in
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.proof.check import Inventory

PICTURES = (".svg", ".png", ".pdf")


def execute(arguments: Namespace) -> int:
    """List the diagram, or write it into a file of the kind that its name says."""
    from voronec.proof.check import Inventory, known_results
    from voronec.proof.check.inventory import around

    path = None if arguments.out is None else Path(arguments.out)
    if path is not None and path.suffix not in (*PICTURES, ".dot", ".json"):
        raise DefinitionError(
            f"'{path}' must end in {', '.join(PICTURES)}, .dot or .json; rename it"
        )
    with progress_line("reading the systems"):
        stock = Inventory.of(filter(is_file, arguments.names))
        names = {name_in(stock, subject) for subject in arguments.names}
        graph = around(stock.graph, names) if names else stock.graph
        known = {r.name: r for r in known_results(stock, names) if r.kind == "relation"}
    data = _data(graph, known)
    _warn_of_trouble(stock)
    if path is not None:
        replace(path, _content(graph, data, path.suffix))
    if path is not None:
        told = f"wrote {path}: {len(graph)} systems, {graph.number_of_edges()} relations"
        answer(arguments.json, lambda: {"file": str(path)}, [told])
        return 0
    rows = ([e["label"], e["line"], ", ".join(e["kinds"]), e["status"]] for e in data["edges"])
    alone = (f"{n} stands alone" for n in sorted(graph) if not graph.degree(n))
    answer(arguments.json, lambda: data, [*columns(rows), *alone])
    return 0


def _warn_of_trouble(stock: Inventory) -> None:
    for trouble in stock.all_troubles:
        warn(f"{trouble.kind} '{trouble.name}': {trouble.why}")


def _data(graph: Any, known: dict[str, Any]) -> dict[str, Any]:
    """Nodes and edges; kinds and verdicts are those of an earlier check, if nothing changed."""
    edges = []
    for source, target, label, data in sorted(graph.edges(keys=True, data=True), key=str):
        result = known.get(label)
        edges.append({
            "label": label, "source": source, "target": target,
            "line": data["relation"].line, "note": data["relation"].note,
            "kinds": list(result.notes) if result else [],
            "status": result.status if result else "not checked",
        })  # fmt: skip
    return {"nodes": sorted(graph), "edges": edges}


def _content(graph: Any, data: dict[str, Any], suffix: str) -> str | bytes:
    if suffix == ".json":
        return json.dumps(data, indent=1, ensure_ascii=False) + "\n"
    if suffix == ".dot":
        return _dot(data)
    from voronec.motion.pictures.run_pictures import save
    from voronec.proof.diagram_picture import diagram_figure

    status = {e["label"]: e["status"] for e in data["edges"] if e["status"] != "not checked"}
    stream = io.BytesIO()
    save(diagram_figure(graph, status or None), stream, suffix)
    return stream.getvalue()


def _dot(data: dict[str, Any]) -> str:
    """The diagram in the language of graphviz."""
    # graphviz knows no dash-dotted lines: a change of time is bold instead
    styles = {"limit": "dashed", "change of time": "bold", "change of coordinates": "dotted"}
    lines = [f"  {_quote(node)};" for node in data["nodes"]]
    for edge in data["edges"]:
        style = styles.get(edge["line"], "solid")
        ends = f"{_quote(edge['source'])} -> {_quote(edge['target'])}"
        lines.append(f"  {ends} [label={_quote(edge['label'])}, style={style}];")
    return "\n".join(["digraph voronec {", "  rankdir=LR;", "  node [shape=box];", *lines, "}", ""])


def _quote(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
