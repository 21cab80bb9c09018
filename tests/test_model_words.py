"""What is said of the smallest model: text, data and picture; and refusals."""

from __future__ import annotations

from dataclasses import replace

import networkx
import pytest
from model_agreement import kinds

import voronec as vo
from voronec.motion.explanation import model_text
from voronec.motion.pictures.model_picture import boxes, model_figure

# -- what is said of it ----------------------------------------------------------------------------


def test_the_text_names_every_variable_with_its_reason() -> None:
    text = model_text(vo.explain(vo.load("demchenko"), outputs=("u", "v")))
    assert "the smallest model for u, v" in text
    assert "first integral 'axial'" in text and "theta, u1, v1" in text
    assert "no output depends on it" in text and "chosen" in text
    assert "declared integrals that can be followed: energy" in text


def test_a_refuted_integral_is_not_followed() -> None:
    sleigh = vo.load("sleigh")
    speed = sleigh.velocities[0]
    model = vo.explain(replace(sleigh, integrals={**sleigh.integrals, "speed": speed}))
    assert model.refuted == ("speed",) and "speed" not in model.integrals
    assert "declared integrals that are not constant, which is proved: speed" in model_text(model)
    assert model.as_dict()["refuted"] == ["speed"]


@pytest.mark.slow
def test_every_coordinate_and_velocity_has_a_role() -> None:
    for name in ("demchenko", "ball-on-sphere", "snakeboard", "bicycle"):
        system = vo.load(name)
        model = vo.explain(system, outputs=(system.coordinates[0],))
        assert {*map(str, (*system.coordinates, *system.velocities))} <= {*kinds(model)}


def test_data_hold_what_the_text_says() -> None:
    data = vo.explain(vo.load("sleigh"), outputs=("phi",)).as_dict()
    assert data["states"] == ["phi", "v", "w"] and data["formulation"] == "coordinates"
    assert {"name": "x", "kind": "dropped", "why": "no output depends on it"} in data["variables"]
    assert ["w", "phi"] in data["edges"] and data["formulations"][0]["chosen"]


def test_the_picture_has_the_cycles_together_and_the_dropped_apart() -> None:
    model = vo.explain(vo.load("sleigh"), outputs=("x",))
    found, arrows = boxes(model)
    by_names = {box.names: key for key, box in found.items()}
    core = by_names["v", "w"]
    assert found[by_names["y",]].kind == "dropped"
    assert (core, by_names["phi",]) in arrows and (by_names["phi",], by_names["x",]) in arrows
    graph = networkx.DiGraph(arrows)
    assert networkx.is_directed_acyclic_graph(graph)


@pytest.mark.slow
def test_boxes_lie_in_the_picture_and_not_on_each_other() -> None:
    for name in ("snakeboard", "bicycle", "ball-on-sphere"):
        figure = model_figure(
            vo.explain(vo.load(name), outputs=("x",) if name != "ball-on-sphere" else ("u",))
        )
        (axes,) = figure.axes
        frames = [p.get_bbox() for p in axes.patches if type(p).__name__ == "FancyBboxPatch"]
        width, height = figure.get_size_inches()
        for i, one in enumerate(frames):
            assert 0 <= one.x0 < one.x1 <= width and 0 <= one.y0 < one.y1 <= height
            for other in frames[:i]:
                apart = one.x1 < other.x0 or other.x1 < one.x0
                assert apart or one.y1 < other.y0 or other.y1 < one.y0


# -- refusals --------------------------------------------------------------------------------------


def test_unknown_words_are_refused_with_the_nearest_name() -> None:
    system = vo.load("sleigh")
    with pytest.raises(vo.DefinitionError, match="no output 'phy'; did you mean 'phi'"):
        vo.explain(system, outputs=("phy",))
    with pytest.raises(vo.DefinitionError, match="no scene 'defalt'; did you mean 'default'"):
        vo.explain(system, scene="defalt")
    with pytest.raises(vo.DefinitionError, match="parameter"):
        vo.explain(system, parameters={"zzz": 1})
    with pytest.raises(vo.DefinitionError, match="initial value"):
        vo.explain(system, initial={"zzz": 1})
