"""``voronec explain``, and the outputs of ``voronec run``."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from command_line import Call, refused

pytestmark = pytest.mark.slow


def test_it_says_what_is_kept_and_why(call: Call) -> None:
    answer = call("explain", "sleigh", "--outputs", "phi")
    assert answer.status == 0 and answer.err == ""
    rows = {line.split()[0]: line for line in answer.out.splitlines() if line}
    assert "v, w" in rows["integrated"] and "phi" in rows["quadrature"]
    assert "x, y" in rows["dropped"] and "no output depends on it" in rows["dropped"]
    assert not [*Path().iterdir()]


def test_without_outputs_those_of_the_scene_are_meant(call: Call) -> None:
    data = json.loads(call("explain", "sleigh", "--json").out)
    assert data["states"] == ["x", "phi", "y", "v", "w"]
    assert data["scene"] == "default" and data["files"] == []


def test_a_system_without_a_default_scene_is_explained_in_its_first(call: Call) -> None:
    Path("own.py").write_text(OWN)
    data = json.loads(call("explain", "own.py", "--json").out)
    assert data["scene"] == "first" and data["states"] == ["x", "xdot"]


def test_values_of_the_start_decide_what_is_frozen(call: Call) -> None:
    def kinds(*words: str) -> dict[str, str]:
        data = json.loads(call("explain", "sleigh", "--outputs", "x", "--json", *words).out)
        return {v["name"]: v["kind"] for v in data["variables"]}

    assert kinds()["w"] == "integrated"
    assert kinds("--set", "w=0", "--set", "v=0")["w"] == "zero"


def test_formulas_and_names_with_blanks_may_be_wanted(call: Call) -> None:
    data = json.loads(call("explain", "sleigh", "--outputs", "v*w, energy", "--json").out)
    assert data["states"] == ["v", "w"]
    assert call("explain", "demchenko", "--outputs", "momentum z").status == 0


def test_a_folder_gets_the_words_and_the_pictures(call: Call) -> None:
    answer = call("explain", "sleigh", "--outputs", "x", "--out", "why")
    assert answer.status == 0 and "wrote why/dependence.png" in answer.out
    assert {f.name for f in Path("why").iterdir()} == {
        "dependence.png", "dependence.svg", "explanation.txt",
    }  # fmt: skip
    assert Path("why/explanation.txt").read_text() in answer.out + "\n"
    assert Path("why/dependence.png").read_bytes().startswith(b"\x89PNG")
    before = Path("why/dependence.svg").read_bytes()
    call("explain", "sleigh", "--outputs", "x", "--out", "why")
    assert Path("why/dependence.svg").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--outputs", "phy"), "did you mean 'phi'"),
        (("--outputs", "phi,"), "separate names by commas"),
        (("--outputs", "phi+"), "is not a formula"),
        (("--scene", "defalt"), "did you mean 'default'"),
        (("--set", "mm=1"), "no parameter, coordinate or velocity 'mm'"),
        (("--set", "m"), "give NAME=VALUE"),
        (("--set", "m=-1"), "must be positive"),
    ],
)
def test_wrong_words_are_refused(call: Call, words: tuple[str, ...], said: str) -> None:
    assert said in refused(call("explain", "sleigh", *words))


def test_a_run_keeps_to_its_outputs(call: Call) -> None:
    answer = call("run", "sleigh", "--outputs", "phi, v*w", "--times", "1:5", "--method", "scipy")
    assert answer.status == 0
    with Path("sleigh-run/trajectory.csv").open(newline="") as file:
        assert next(csv.reader(file)) == ["t", "phi", "v*w"]
    assert "no output 'phy'" in call("run", "sleigh", "--outputs", "phy").err


OWN = """
import sympy as sp
import voronec as vo

x, y = sp.symbols("x y")
SYSTEM = vo.System(
    name="own", fibration=vo.Fibration(base=(x, y)),
    lagrangian=(vo.velocity(x) ** 2 + vo.velocity(y) ** 2 - x**2 - y**2) / 2,
    scenes={"first": vo.Scene(initial={x: 1}, outputs=("x",))},
)
"""
