"""``voronec bench``: what it prints and writes, its statuses, its refusals."""

from __future__ import annotations

import json
import signal
from pathlib import Path
from typing import Any

import pytest
from command_line import Call, refused
from tool_modules import tool

import voronec as vo
from voronec.accuracy.bench import scene_problem
from voronec.accuracy.bench.call_time import OTHER, STAGES

pytestmark = pytest.mark.slow

FILE = """
import sympy as sp
import voronec as vo

q = sp.Symbol("q")
k = sp.Symbol("k")
SYSTEM = vo.System(
    name="spring",
    title="A spring",
    fibration=vo.Fibration(base=(q,)),
    lagrangian=(vo.velocity(q) ** 2 - k * q**2) / 2,
    parameters=(vo.Parameter(k, 1, positive=True),),
    integrals={"energy": (vo.velocity(q) ** 2 + k * q**2) / 2},
    scenes={"default": vo.Scene(initial={q: 1}, times=(0, 4))},
)
"""
QUICK = ("--methods", "scipy,lsoda", "--tols", "1e-5,1e-9")


@pytest.fixture(autouse=True)
def no_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set-up is measured in fresh processes, which other tests start."""
    monkeypatch.setattr("voronec.accuracy.bench.measure_setup", lambda *_, **__: None)


@pytest.fixture
def spring(call: Call) -> str:
    Path("spring.py").write_text(FILE)
    return "spring.py"


def test_a_table_a_record_and_a_plot_are_written(call: Call, spring: str) -> None:
    answer = call("bench", spring, *QUICK)
    assert answer.status == 0 and answer.err == ""
    lines = answer.out.splitlines()
    assert lines[0] == "spring, scene default: t from 0 to 4, 101 instants"
    assert lines[1] == "outputs: q, qdot"
    assert lines[2].startswith("reference: accurate to ") and "agree" in lines[2]
    assert lines[-1].startswith("wrote ")
    rows = [line.split() for line in lines]
    table = [r for r in rows if r[:1] == ["scipy"] and r[1:2] in (["1e-05"], ["1e-09"])]
    assert len(table) == 2 and float(table[0][2]) > float(table[1][2])
    folder = Path("spring-bench")
    assert sorted(p.name for p in folder.iterdir()) == [
        "bench.json", "bench.txt", "work-precision.svg",
    ]  # fmt: skip
    assert (folder / "bench.txt").read_text().splitlines() == lines[:-1]
    assert "<svg" in (folder / "work-precision.svg").read_text()


def test_json_is_the_record_that_is_written(call: Call, spring: str) -> None:
    words = ("--time", "1/2", "--set", "k=4", "--outputs", "q", "--out", "there", "--json")
    data = json.loads(call("bench", spring, *QUICK, *words).out)
    assert data.pop("files") == [f"there/{n}" for n in ("bench.json", "bench.txt",
                                                       "work-precision.svg")]  # fmt: skip
    assert data == json.loads(Path("there/bench.json").read_text())
    assert data["times"] == [0, 0.5] and data["parameters"] == {"k": 4}
    assert data["outputs"] == ["q"] and data["setup_seconds"] is None
    assert [m["name"] for m in data["methods"]] == QUICK[1].split(",")
    assert data["reference"]["accuracy"] < 1e-13


def test_what_did_not_take_part_is_named(call: Call, spring: str) -> None:
    answer = call("bench", spring, "--methods", "scipy,closed-form", "--tols", "1e-6")
    lines = answer.out.splitlines()
    assert answer.status == 0 and "did not take part:" in lines
    assert any("closed-form  system 'spring' declares no motion in closed" in x for x in lines)


def _integrate_fails(monkeypatch: pytest.MonkeyPatch, when: Any, error: BaseException) -> None:
    """Whole runs by some methods end with an error."""

    def failing(*words: Any, **named: Any) -> Any:
        if when(named["method"]) and len(named["times"]) > 2:
            raise error
        return vo.integrate(*words, **named)

    monkeypatch.setattr("voronec.accuracy.bench.runs.integrate", failing)


def test_ctrl_c_writes_what_is_measured(
    call: Call, spring: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    _integrate_fails(monkeypatch, "lsoda".__eq__, KeyboardInterrupt())
    answer = call("bench", spring, "--methods", "scipy,lsoda,flint")
    assert answer.status == 130
    assert "stopped by hand; what was measured until then is above" in answer.out
    data = json.loads(Path("spring-bench/bench.json").read_text())
    assert data["interrupted"] and len(data["methods"]) == 1


def test_where_nothing_runs_there_is_a_table_all_the_same(
    call: Call, spring: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    _integrate_fails(monkeypatch, "scipy".__eq__, vo.IntegrationError("it broke"))
    answer = call("bench", spring, "--methods", "scipy", "--tols", "1e-6")
    assert answer.status == 0
    assert "scipy at 1e-06 failed: it broke" in answer.out.splitlines()
    assert not Path("spring-bench/work-precision.svg").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--methods", "scypy"), "there is no method 'scypy'; did you mean 'scipy'"),
        (("--tols", "1e-6,x"), "--tols: 'x' is not a number"),
        (("--tols", "2"), "the tolerance 2 must lie between 0 and 1"),
        (("--scene", "fast"), "has no scene 'fast'; did you mean 'default'"),
        (("--time", "0"), "--time 0: give a length of time above zero"),
        (("--time", "long"), "--time: 'long' is not a number"),
        (("--set", "k"), "--set k: give NAME=VALUE"),
        (("--set", "k=-1"), "parameter 'k' = -1 must be positive"),
        (("--outputs", "r"), "has no output 'r'"),
        (("--out", "spring.py"), "'spring.py' is a file; give a folder with --out"),
    ],
)
def test_wrong_words_are_refused_in_one_line(
    call: Call, spring: str, words: tuple[str, ...], message: str
) -> None:
    assert message in refused(call("bench", spring, *words))


def test_peers_are_measured_beside_ours_by_a_tool_alone(
    call: Call, spring: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    peer = "dop853-lambdify-coordinates"
    assert f"there is no method '{peer}'" in refused(call("bench", spring, "--methods", peer))
    words = ["bench.py", spring, "--methods", "scipy", peer, "mujoco-best", "--tols", "1e-9"]
    monkeypatch.setattr("sys.argv", words)
    assert tool("figures.methods").main() == 0
    lines = capsys.readouterr().out.splitlines()
    rows = {line.split()[0]: line.split() for line in lines if line.split()[1:2] == ["1e-09"]}
    assert {"scipy", peer} <= {*rows} and float(rows[peer][2]) < 1e-6
    assert "  mujoco-best  only for a ball on a plane: chaplygin-ball, homogeneous-ball" in lines


def test_stages_of_calls_are_told_apart(call: Call, spring: str) -> None:
    if not hasattr(signal, "setitimer"):
        pytest.skip("no clock of the processor here")
    answer = call("bench", spring, "--setup", "--json")
    assert answer.status == 0 and answer.err == ""
    seconds = json.loads(answer.out)["seconds"]
    assert seconds["first ever"].keys() <= {*STAGES, OTHER}
    order = [*STAGES]  # the first that fits counts
    assert order.index("elimination") < order.index("code") < order.index("derivation")
    assert all(seconds[call]["import"] > 0 for call in ("first ever", "first in a process"))
    # a name taken from a package asks Python's importer, even where nothing is loaded any more
    loading = seconds["second"].get("import", 0.0)
    assert loading < seconds["first in a process"]["import"] / 20
    assert sum(seconds["second"].values()) > 0
    assert not Path("spring-bench").exists()


def test_a_call_that_fails_says_why(call: Call, spring: str) -> None:
    answer = call("bench", spring, "--setup", "--scene", "nope")
    assert answer.status == 2 and "has no scene 'nope'" in answer.err
    assert "DefinitionError" not in answer.err and answer.err.count("\n") == 1


PUSHED = """
name = "pushed"
lagrangian = "xdot^2/2"
inputs = { u = "push" }
[coordinates]
x = "place"
[forces]
x = "u"
[scenes.default]
initial = { x = 1 }
times = [0, 1]
inputs = { u = { times = [0, 1], values = [3, 3], kind = "held" } }
"""


def test_inputs_are_given_to_every_method(call: Call) -> None:
    Path("pushed.toml").write_text(PUSHED)
    answer = call("bench", "pushed.toml", *QUICK, "--input", "u=6*t", "--json")
    assert answer.status == 0 and answer.err == ""
    for method in json.loads(answer.out)["methods"]:
        assert method["points"][-1]["error"] < 1e-8
    end = scene_problem(vo.load("pushed.toml"), None, ("x",), inputs={"u": "6*t"})
    run = vo.integrate(end.equations, end.bare, times=end.grid)
    assert abs(run["x"][-1] - 2) < 1e-12  # 1 + t^3


def test_tables_are_not_for_a_comparison_of_methods(call: Call) -> None:
    Path("pushed.toml").write_text(PUSHED)
    answer = call("bench", "pushed.toml")
    assert answer.status == 2 and "takes numbers and expressions of t for inputs" in answer.err
    Path("u.csv").write_text("0,1\n1,2\n")
    answer = call("bench", "pushed.toml", "--input", "u=u.csv")
    assert answer.status == 2 and "--input u: most methods take no table" in answer.err
