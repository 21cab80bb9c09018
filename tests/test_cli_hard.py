"""``tools/bench.py hard``: what it prints, its statuses, its refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import Answer, Call
from tool_modules import tool

command, trial = tool("hard.command"), tool("hard.trial")
CASES, TOLERANCES = tool("hard").CASES, trial.TOLERANCES

pytestmark = pytest.mark.slow


@pytest.fixture
def hard(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Call:
    """Call the tool with words, in an empty folder and on a screen of known width."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def call(*words: str) -> Answer:
        monkeypatch.setattr("sys.argv", ["bench.py hard", *words])
        capsys.readouterr()
        try:
            status = command.main()
        except SystemExit as end:  # argparse
            status = int(str(end.code))
        said = capsys.readouterr()
        return Answer(status, said.out, said.err)

    return call


def test_cases_are_listed_without_running_any(hard: Call) -> None:
    answer = hard("--list")
    assert answer.status == 0 and len(answer.out.splitlines()) == len(CASES)
    data = json.loads(hard("--list", "--json").out)
    assert [d["case"] for d in data] == [c.name for c in CASES]


def test_rows_say_error_condition_drift_and_verdict(hard: Call) -> None:
    answer = hard("no-gyroscope", "--method", "scipy")
    head, good, last = answer.out.splitlines()
    assert answer.status == 0 and answer.err == ""
    assert head.split() == [
        "case", "method", "error", "condition", "roundings", "drift", "seconds", "verdict",
    ]  # fmt: skip
    assert good.split()[:2] == ["no-gyroscope", "scipy"] and good.endswith("met")
    assert "took no part" in last


def test_json_and_files_tell_the_same(hard: Call) -> None:
    answer = hard("no-gyroscope", "--method", "auto", "--json", "--out", "found")
    (told,) = json.loads(answer.out)
    assert answer.status == 0 and told["good"] and told["trials"][0]["verdict"] == "met"
    assert json.loads(Path("found/hard.json").read_text("utf-8")) == [told]
    assert "### no-gyroscope" in Path("found/hard-cases.md").read_text("utf-8")


def test_the_tools_own_choice_silently_wrong_is_status_1(
    hard: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(TOLERANCES, "auto", 1e-4)
    answer = hard("no-gyroscope", "--method", "auto")
    assert answer.status == 1
    assert "silently wrong: no-gyroscope" in answer.out


def test_another_method_that_misses_is_shown_and_no_failure(
    hard: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(TOLERANCES, "scipy", 1e-4)
    answer = hard("no-gyroscope", "--method", "scipy")
    assert answer.status == 0 and "missed in" in answer.out


def test_ctrl_c_keeps_the_finished_rows(hard: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    true, seen = trial.attempt, []

    def attempt(case: Any, *rest: Any) -> Any:
        seen.append(case.name)
        if len(seen) == 2:
            raise KeyboardInterrupt
        return true(case, *rest)

    monkeypatch.setattr(trial, "attempt", attempt)
    answer = hard("no-gyroscope", "turning-point", "--method", "auto")
    assert answer.status == 130 and "1 of 2 cases done" in answer.err
    assert "no-gyroscope" in answer.out and "turning-point" not in answer.out


def test_unknown_cases_and_methods_are_refused_with_the_nearest(hard: Call) -> None:
    for words, told in (
        (("turning-pint",), "did you mean 'turning-point'"),
        (("--method", "scypi"), "there is no method 'scypi'; did you mean 'scipy'"),
    ):
        answer = hard(*words)
        assert answer.status == 2 and answer.out == "" and told in answer.err
        assert "Traceback" not in answer.err and not [*Path().iterdir()]
