"""``voronec graph``: the diagram as lines, data and a picture."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import networkx
import pytest
from command_line import Call, refused

from voronec import Limit, Relation
from voronec.motion.pictures.layered_layout import layered_layout
from voronec.proof.check import Inventory, graph
from voronec.proof.diagram_picture import diagram_figure

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def own_store(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))


def test_the_object_holds_every_system_and_relation() -> None:
    stock, whole = Inventory.of(), graph()
    assert isinstance(whole, networkx.MultiDiGraph)
    assert {*stock.entries} <= {*whole}
    assert {key for *_, key in whole.edges(keys=True)} == {r.label for r in stock.relations}
    near = graph(["vertical-disc"])
    assert {"vertical-disc", "falling-disc"} <= {*near} < {*whole}


def test_the_command_lists_relations_with_verdicts_of_the_last_check(call: Call) -> None:
    def status() -> str:
        lines = call("graph", "vertical-disc").out.splitlines()
        return next(x for x in lines if x.startswith("vertical-disc -> falling-disc "))

    assert status().endswith("not checked")
    call("check", "vertical-disc", "--jobs", "1")
    assert status().endswith("proved") and "specialisation" in status()


@pytest.mark.parametrize(
    ("suffix", "head"), [(".svg", b"<?xml"), (".png", b"\x89PNG"), (".dot", b"digraph")]
)
def test_it_is_written_in_the_format_of_the_name(call: Call, suffix: str, head: bytes) -> None:
    answer = call("graph", "vertical-disc", "--out", f"g{suffix}")
    assert answer.status == 0 and f"wrote g{suffix}" in answer.out
    assert Path(f"g{suffix}").read_bytes().startswith(head)


def test_a_file_stands_in_the_diagram_by_the_name_of_its_system(call: Call) -> None:
    text = """
import sympy as sp
import voronec as vo

s = sp.Symbol("s")
SYSTEM = vo.System("mine", vo.Fibration(s), vo.velocity(s) ** 2 / 2)
RELATIONS = (vo.Relation("mine", "mine", state={s: -s}),)
"""
    Path("x.py").write_text(text)
    assert call("graph", "x.py").out.startswith("mine -> mine ")
    assert json.loads(call("graph", "x.py", "--json").out)["nodes"] == ["mine"]
    both = json.loads(call("graph", "vertical-disc", "x.py", "--json").out)["nodes"]
    assert {"mine", "vertical-disc", "falling-disc"} <= {*both}


def test_data_are_written_and_printed_alike(call: Call) -> None:
    call("graph", "vertical-disc", "--out", "g.json")
    data = json.loads(Path("g.json").read_text())
    assert data == json.loads(call("graph", "vertical-disc", "--json").out)
    ends = {(e["source"], e["target"]) for e in data["edges"]}
    assert ("vertical-disc", "falling-disc") in ends and "falling-disc" in data["nodes"]


def test_wrong_words_are_refused(call: Call) -> None:
    assert "must end in .svg" in refused(call("graph", "--out", "g.gif"))
    assert "no system 'slegh'" in refused(call("graph", "slegh"))


def test_each_kind_has_its_line() -> None:
    assert Relation("a", "b").line == "specialisation"
    assert Relation("a", "b", state={"x": "x"}).line == "specialisation"
    assert Relation("a", "b", state={"x": "y"}).line == "change of coordinates"
    assert Relation("a", "b", clock=2).line == "change of time"
    assert Relation("a", "b", limit=Limit("h", {"m": "h"})).line == "limit"


def web() -> networkx.MultiDiGraph:
    found = networkx.MultiDiGraph()
    pairs = ["ab", "bc", "cd", "ad", "ec", "fd", "bb", "ab", "da"]
    for number, (a, b) in enumerate(pairs):
        name = f"{a} -> {b} {number}"
        found.add_edge(a, b, key=name, relation=Relation(a, b, name=name))
    found.add_node("z")
    return found


def test_layers_lead_forward_and_nothing_overlaps() -> None:
    found = layered_layout(web())
    assert found.alone == ("z",) and {*found.places} == {*"abcdef"}
    column = {n: p[0] for n, p in found.places.items()}
    assert all(column[a] < column[b] for a, b in ("ab", "bc", "cd", "ad", "ec", "fd"))
    assert len(found.bends["a", "d"]) == column["d"] - column["a"] - 1
    for layer in {*column.values()}:
        heights = sorted(p[1] for p in found.places.values() if p[0] == layer)
        assert all(b - a >= 0.99 for a, b in pairwise(heights))


def test_a_crowded_layer_keeps_its_distances() -> None:
    crowded = networkx.MultiDiGraph((f"a{i}", f"b{j}") for i in range(7) for j in range(i, 5))
    crowded.add_edges_from((f"b{j}", "c") for j in range(5))
    found = layered_layout(crowded)
    for layer in (0.0, 1.0):
        heights = sorted(p[1] for p in found.places.values() if p[0] == layer)
        assert len(heights) >= 5
        assert all(b - a >= 0.99 for a, b in pairwise(heights))


def test_paths_that_are_folded_between_two_layers_do_not_cross() -> None:
    """Fiedler's vector of a path is monotonous along it; the names have another order."""
    pairs = [(f"a{i * 4 % 7}", f"b{j * 3 % 7}") for i in range(7) for j in (i - 1, i) if j >= 0]
    folded = networkx.MultiDiGraph([*pairs, *((b.upper(), a.upper()) for a, b in pairs)])
    places = layered_layout(folded).places
    ends = sorted((places[a][1], places[b][1]) for a, b in folded.edges())
    assert len({*places.values()}) == 28
    assert all(b <= d for (a, b), (c, d) in pairwise(ends) if a < c)


def test_the_picture_names_every_system_and_marks_what_is_not_proved() -> None:
    figure = diagram_figure(web(), {"a -> b 0": "proved", "b -> c 1": "refuted"})
    (axes,) = figure.axes
    assert {*"abcdefz"} <= {t.get_text() for t in axes.texts}
    words = [t.get_text() for t in axes.get_legend().get_texts()]
    assert {"limit", "not proved", "not checked"} <= {*words}
    colors = {p.get_edgecolor() for p in axes.patches}
    assert len(colors) == 4  # boxes, proved, not proved, not checked
    assert len({p.get_edgecolor() for p in diagram_figure(web()).axes[0].patches}) == 2


def test_the_picture_of_nothing_is_a_picture() -> None:
    assert diagram_figure(networkx.MultiDiGraph()).axes
