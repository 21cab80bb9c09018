"""Every system has a sketch, which names its coordinates; sketches are values."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest
import sympy as sp

import voronec as vo
from voronec.cli import main


@pytest.mark.parametrize("name", sorted(vo.names()))
def test_every_coordinate_is_named(name: str) -> None:
    system = vo.load(name)
    assert system.sketch is not None
    assert {q.name for q in system.coordinates} <= system.sketch.names


def test_what_is_drawn_is_what_is_declared() -> None:
    x, theta1 = sp.symbols("x theta1")
    sketch = vo.Sketch("seen from above").axes(x, "y").angle((0, 0), 1, 0, 30, theta1)
    assert sketch.names == {"x", "y", "theta1"}
    drawn = [text.get_text() for text in sketch.figure().axes[0].texts]
    assert [text for text in drawn if text] == ["$x$", "$y$", r"$\theta_{1}$"]
    assert vo.Sketch("seen from above") == vo.Sketch("seen from above")
    assert pickle.loads(pickle.dumps(sketch)) == sketch


def test_a_box_has_its_length_along_its_direction() -> None:
    (stroke,) = vo.Sketch().box((1, 2), 4, 2, 90).strokes
    corners = {(round(x, 12), round(y, 12)) for x, y in stroke.points}
    assert corners == {(0, 4), (2, 4), (0, 0), (2, 0)}


@pytest.mark.slow
def test_a_picture_is_one_element_and_the_same_each_time() -> None:
    sketch = vo.load("sleigh").sketch
    assert sketch.svg().startswith("<svg") and sketch.svg() == sketch.svg()
    assert vo.load("sleigh")._repr_html_().startswith("<svg")
    assert sketch._repr_html_() == sketch.svg() and len(repr(sketch)) < 60


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["svg", "png", "pdf"])
def test_show_draws(ending: str, tmp_path: Path) -> None:
    file = tmp_path / f"sleigh.{ending}"
    assert main(["show", "sleigh", "--out", str(file)]) == 0
    assert file.stat().st_size > 3000


def test_what_cannot_be_drawn_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["show", "sleigh", "--out", str(tmp_path / "sleigh.gif")]) == 2
    assert ".svg, .png, .pdf; rename it" in capsys.readouterr().err
    with pytest.raises(vo.DefinitionError, match="label 3 of a sketch is no text"):
        vo.Sketch().text((0, 0), 3)
    with pytest.raises(vo.DefinitionError, match="the sketch is 'sleigh'"):
        vo.System("body", vo.Fibration(sp.Symbol("x")), 0, sketch="sleigh")
