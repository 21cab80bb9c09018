"""``voronec section``: pictures, points, reports and refusals."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from voronec.cli import main

pytestmark = pytest.mark.slow

OSCILLATOR = """
import sympy as sp
from voronec import Fibration, Parameter, Scene, System, velocity

x, y, w = sp.symbols("x y w")
SYSTEM = System(
    name="oscillators",
    fibration=Fibration(base=(x, y), fibre=()),
    lagrangian=(velocity(x)**2 - w**2 * x**2 + velocity(y)**2 - y**2) / 2,
    constraints=(),
    parameters=(Parameter(w, 2),),
    integrals={"energy": (velocity(x)**2 + w**2 * x**2 + velocity(y)**2 + y**2) / 2},
    scenes={"default": Scene(initial={x: 1, y: sp.Rational(1, 2)}, times=(0.0, 10.0))},
)
"""


@pytest.fixture
def oscillators(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "oscillators.py").write_text(OSCILLATOR)
    return "oscillators.py"


def points(path):
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def test_the_points_written_are_the_exact_crossings(oscillators, tmp_path, capsys):
    status = main(
        ["section", oscillators, "--plane", "x=0", "--outputs", "y, ydot,x^2+y", "--crossings", "9"]
    )
    assert status == 0
    found = points(tmp_path / "oscillators-section" / "points.csv")
    exact = (1.5 * np.pi + 2 * np.pi * np.arange(9)) / 2
    assert found["t"] == pytest.approx(exact, abs=1e-11)
    assert found["y"] == pytest.approx(np.cos(exact) / 2, abs=1e-11)
    assert found["ydot"] == pytest.approx(-np.sin(exact) / 2, abs=1e-11)
    assert found["x**2 + y"] == pytest.approx(found["y"], abs=1e-11)
    assert "<svg" in (tmp_path / "oscillators-section" / "section.svg").read_text()
    out = capsys.readouterr().out
    assert "oscillators: x = 0, upwards; y, ydot, x**2 + y recorded" in out
    assert "9 points of 1 start," in out
    assert "drift of  energy" in out


def test_settings_reach_the_motion_and_the_report_is_json(oscillators, tmp_path, capsys):
    status = main([
        "section", oscillators, "--plane", "x=1/2", "--outputs", "y", "--set", "w=1", "--set",
        "x=2", "--direction", "down", "--crossings", "2", "--method", "scipy", "--tol", "1e-11",
        "--out", "here", "--json",
    ])  # fmt: skip
    assert status == 0
    report = json.loads(capsys.readouterr().out)
    assert report["points"] == 2
    assert report["method"] == "scipy"
    assert report["tolerance"] == 1e-11
    assert (report["plane"], report["value"], report["direction"]) == ("x", 0.5, -1)
    assert report["ends"] == ["complete"]
    assert sorted(f.rpartition("/")[2] for f in report["files"]) == ["points.csv", "section.svg"]
    first = np.arccos(0.25)
    found = points(tmp_path / "here" / "points.csv")
    assert found["t"] == pytest.approx([first, first + 2 * np.pi], abs=1e-9)


def test_surface_and_outputs_are_suggested(oscillators, capsys):
    assert main(["section", oscillators, "--crossings", "3", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["plane"], report["outputs"]) == ("x", ["y", "xdot"])


def test_several_starts_lie_on_one_level(oscillators, tmp_path):
    arguments = ["--starts", "5", "--crossings", "20", "--plane", "x", "--outputs", "y,ydot,energy"]
    assert main(["section", oscillators, *arguments]) == 0
    found = points(tmp_path / "oscillators-section" / "points.csv")
    assert len(found["t"]) == 100
    assert set(found["start"]) == {0, 1, 2, 3, 4}
    assert np.ptp(found["energy"]) < 1e-10
    amplitudes = {round(a, 6) for a in (found["y"] ** 2 + found["ydot"] ** 2)[::20]}
    assert len(amplitudes) == 5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--plane", "z=0"], "no plane 'z'"),
        (["--plane", "xdo=0"], "did you mean 'xdot'"),
        (["--plane", "x=7"], "stays between -1 and 1"),
        (["--plane", "x=a"], "'a' is not a number"),
        (["--plane", "x+=1"], "is not a formula"),
        (["--plane", "x*q"], "contains 'q'"),
        (["--plane", "x", "--outputs", "yy"], "no output 'yy'"),
        (["--set", "v=1"], "'v'"),
        (["--starts", "0"], "--starts 0"),
        (["--crossings", "-3"], "--crossings -3"),
        (["--tol", "3"], "--tol 3"),
        (["--scene", "defaul"], "did you mean 'default'"),
        (["--until", "soon"], "'soon' is not a number"),
    ],
)
def test_wrong_input_is_one_line_and_writes_nothing(
    oscillators, tmp_path, capsys, arguments, words
):
    before = sorted(tmp_path.iterdir())
    assert main(["section", oscillators, *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert [p for p in sorted(tmp_path.iterdir()) if p.suffix != ".pyc"][: len(before)] == before
    assert not (tmp_path / "oscillators-section").exists()


def test_stopped_by_hand_writes_the_points_there_are(oscillators, tmp_path, monkeypatch, capsys):
    pytest.importorskip("heyoka")
    from voronec.cli import section

    def stop(message: str) -> None:
        if "of the crossings" in message:
            raise KeyboardInterrupt

    monkeypatch.setattr(section, "progress", stop)
    status = main([
        "section", oscillators, "--plane", "x", "--outputs", "y", "--crossings", "1000000",
    ])  # fmt: skip
    assert status == 130
    assert "stopped by hand" in capsys.readouterr().out
    assert len(points(tmp_path / "oscillators-section" / "points.csv")["t"]) > 0


def test_a_section_with_a_table_for_an_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "driven.py").write_text(
        "import sympy as sp\nimport voronec as vo\n"
        "x, u = sp.symbols('x u')\n"
        "SYSTEM = vo.System(name='driven', fibration=vo.Fibration(x), inputs=(u,),\n"
        "    lagrangian=vo.velocity(x)**2/2 - x**2/2, forces={x: u},\n"
        "    scenes={'default': vo.Scene({x: 2}, (0, 9))})\n",
        encoding="utf-8",
    )
    (tmp_path / "u.csv").write_text("t,u\n0,1\n20,1\n", encoding="utf-8")
    base = ["section", "driven.py", "--input", "u=u.csv", "--out", "out"]
    assert main([*base, "--plane", "x=1", "--until", "19"]) == 0
    rows = (tmp_path / "out" / "points.csv").read_text().splitlines()[1:]
    assert len(rows) == 3  # x = 1 + cos t passes upwards at 3, 7, 11 quarters of a turn
    capsys.readouterr()
    for wrong in ([*base, "--until", "19"], [*base, "--plane", "x=1"]):
        assert main(wrong) == 2
        assert len(capsys.readouterr().err.strip().splitlines()) == 1
