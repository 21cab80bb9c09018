"""Results in a notebook and on their way to another process: short forms, tables, pictures."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import voronec as vo

DISC = vo.Relation(
    "vertical-disc",
    "sleigh",
    state={"x": "x", "y": "y", "phi": "phi", "v": "R*thetadot", "w": "phidot"},
    parameters={"m": "m + B/R^2", "J": "C", "a": 0},
)


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    sleigh = vo.load("sleigh")
    equations = vo.derive(sleigh)
    starts = [{"v": 1.0, "w": 0.1 * k} for k in range(3)]
    return {
        "system": sleigh,
        "large system": vo.load("rattleback"),
        "equations": equations,
        "curvature": equations.curvature,
        "trajectory": vo.integrate(equations, times=np.linspace(0, 2, 21)),
        "ensemble": vo.ensemble(equations, starts, times=np.linspace(0, 2, 21)),
        "section": vo.section(vo.load("ball-on-sphere"), "u1dot", crossings=3),
        "model": vo.explain(sleigh),
        "verdict": vo.prove_equal("x", "x + 1"),
        "claim": vo.check_claims(sleigh)[1],
        "relation": vo.check_relation(DISC),
        "search": vo.search_integrals(vo.load("chaplygin-ball"), degree=2, again=True),
        "comparison": vo.compare(sleigh, vo.load("vertical-disc")),
        "reduction": vo.descend(vo.load("chaplygin-ball")),
        "closed form": vo.closed_form(vo.load("demchenko")),
        "methods": vo.by_methods(sleigh),
        "judgement": vo.judge(sleigh, r"\dot v = a w^2"),
        "lesson": vo.lesson(sleigh),
        "large curvature": vo.derive(vo.load("bicycle")).curvature,
        "brackets": vo.derive(vo.load("bicycle")).brackets,
        "precessions": vo.precessions(vo.load("demchenko")),
    }


@pytest.mark.slow
def test_every_result_is_short(results: dict[str, Any]) -> None:
    for name, result in results.items():
        assert len(repr(result)) < 400 and "\n" not in repr(result), name
        own = getattr(result, "system", "")
        assert getattr(own, "name", own) in repr(result)


@pytest.mark.slow
def test_formulas_of_a_notebook_are_those_of_the_system(results: dict[str, Any]) -> None:
    table = results["system"]._repr_html_()
    assert r"\dot{\phi}" in table and "centre of mass" in table and "<script" not in table
    shown = results["equations"]._repr_latex_()
    assert shown.startswith("$") and r"\dot v &= a w^2" in shown


@pytest.mark.slow
def test_tables_of_a_notebook_say_what_was_found(results: dict[str, Any]) -> None:
    expected = {
        "verdict": ("refuted", "ball arithmetic"),
        "claim": ("integral: heading", "proved where w != 0"),
        "relation": ("vertical-disc to sleigh", "R*thetadot", "proved"),
        "search": ("first integrals of chaplygin-ball", "degree up to 2", r"\gamma_{1}"),
        "comparison": ("facts: base", "different"),
        "reduction": (r"\gamma_{1}", "masses"),
        "closed form": ("period", "between"),
        "ensemble": ("3 motions", "drift of energy"),
        "model": ("quadrature", "follows from others"),
        "methods": ("Chaplygin and Hamel", "proved"),
        "curvature": ("A[0, 0, 1]", "cos(phi)^(-2)"),
        "large curvature": ("nonzero", "characters"),
    }
    for name, words in expected.items():
        table = results[name]._repr_html_()
        assert table.startswith("<table>") and "<script" not in table
        for word in words:
            assert word in table.replace("&#x27;", "'"), (name, word, table)


@pytest.mark.slow
def test_a_closed_form_is_the_same_where_it_arrives(results: dict[str, Any]) -> None:
    form = results["closed form"]
    found = pickle.loads(pickle.dumps(form))
    there, here = (f.at([0.0, 1e5], ("u", "v")) for f in (found, form))
    assert np.array_equal(there["u"], here["u"]) and np.array_equal(there["v"], here["v"])
    assert found.enclose(7, digits=30)["u"].overlaps(form.enclose(7, digits=30)["u"])
    assert vo.closed_form(found.system, parameters={"k": 5}).period != form.period


def test_a_start_known_by_its_digits_stays_and_says_so() -> None:
    ball = vo.load("demchenko")
    start = {"u": 1, "u1": 1.2, "theta": 0.4, "vdot": 0.3, "n": 1}
    form = vo.closed_form(ball, initial=start)
    with pytest.raises(vo.DefinitionError, match="cannot be pickled"):
        pickle.dumps(form)
    assert copy.deepcopy(form) is form


def test_what_a_user_wrote_is_text_in_a_table(results: dict[str, Any]) -> None:
    import dataclasses

    system = dataclasses.replace(results["system"], title="<script>alert(1)</script>")
    assert "<script" not in system._repr_html_()


def test_equations_are_shown_on_a_terminal(
    results: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    results["equations"].show()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("sleigh") and any(line.startswith("  xdot") for line in lines)


@pytest.mark.slow
def test_a_trajectory_draws_itself(results: dict[str, Any], tmp_path: Path) -> None:
    motion = results["trajectory"]
    figure = motion.plot(["v", "w"])
    assert [panel.get_ylabel() for panel in figure.axes] == ["$v$", "$w$"]
    assert np.array_equal(figure.axes[0].lines[0].get_ydata(), motion["v"])
    assert figure._repr_png_().startswith(b"\x89PNG")  # a notebook shows it without pyplot
    with pytest.raises(vo.DefinitionError, match="speed"):
        motion.plot(["speed"])
    with pytest.raises(vo.DefinitionError, match=r"is no film; write FILE\.gif"):
        motion.animate(tmp_path / "motion.doc")
    assert not [*tmp_path.iterdir()]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "file", "begins"),
    [
        ("demchenko", "ball.gif", b"GIF8"),
        ("snakeboard", "board.webp", b"RIFF"),
        ("spherical-robot", "robot.gif", b"GIF8"),  # which has inputs
    ],
)
def test_a_film_of_what_has_shapes(tmp_path: Path, name: str, file: str, begins: bytes) -> None:
    system = vo.load(name)
    motion = vo.integrate(
        system, scene="default", times=np.linspace(0, 1, 4), outputs=("configuration",)
    )
    assert motion.animate(tmp_path / file).read_bytes().startswith(begins)


@pytest.mark.slow
def test_a_film_by_the_ffmpeg_of_a_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the machine has none; the frames reach it, and the file that it writes is the film."""
    program = tmp_path / "ffmpeg"
    program.write_text('#!/bin/sh\nfor last; do :; done\n/usr/bin/wc -c > "$last"\n')
    program.chmod(0o700)
    monkeypatch.setenv("PATH", str(tmp_path / "nowhere"))
    package = SimpleNamespace(get_ffmpeg_exe=lambda: str(program))
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", package)
    motion = vo.integrate(vo.load("snakeboard"), times=np.linspace(0, 1, 3))
    written = motion.animate(tmp_path / "board.mp4")
    assert int(written.read_text()) == 3 * 4 * 480**2  # frames, bytes of a dot, dots
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(vo.DefinitionError, match=r"install 'voronec\[film\]', or write FILE\.gif"):
        motion.animate(tmp_path / "none.mp4")


def _same(one: Any, other: Any) -> None:
    assert type(one) is type(other)
    if isinstance(one, vo.VoronecEquations):
        assert one.latex() == other.latex() and one.system == other.system
    elif isinstance(one, vo.Trajectory | vo.Ensemble):
        assert np.array_equal(one.t, other.t) and one.series.keys() == other.series.keys()
        assert all(np.array_equal(one[name], other[name]) for name in one.series)
    elif isinstance(one, vo.Section):
        assert np.array_equal(one.points, other.points)
    else:
        assert repr(one) == repr(other)


@pytest.mark.slow
def test_results_are_pickled_and_copied(results: dict[str, Any]) -> None:
    for result in results.values():
        _same(pickle.loads(pickle.dumps(result)), result)
        _same(copy.copy(result), result)
        _same(copy.deepcopy(result), result)


@pytest.mark.parametrize("name", sorted(vo.names()))
def test_every_system_is_pickled(name: str) -> None:
    system = vo.load(name)
    found = pickle.loads(pickle.dumps(system))
    assert found == system
    with pytest.raises(TypeError):
        found.scenes["other"] = None


def test_what_lies_between_instants_stays_behind_and_says_so() -> None:
    motion = vo.integrate(vo.load("sleigh"), times=np.linspace(0, 1, 5), dense=True)
    assert copy.deepcopy(motion).at([0.3])["x"] == motion.at([0.3])["x"]
    found = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(found["x"], motion["x"]) and any("stayed" in n for n in found.notes)
    with pytest.raises(vo.DefinitionError, match="dense=True"):
        found.at([0.3])


@pytest.mark.slow
def test_another_process_reads_a_motion(results: dict[str, Any], tmp_path: Path) -> None:
    file = tmp_path / "motion.pickle"
    file.write_bytes(pickle.dumps(results["trajectory"]))
    code = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb'))['x'][-1].hex())"
    done = subprocess.run(
        [sys.executable, "-c", code, str(file)], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == float(results["trajectory"]["x"][-1]).hex()
