"""``voronec hard``: what it prints, its statuses, its refusals."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from command_line import Call, refused

from voronec.accuracy.hard import CASES, trial
from voronec.accuracy.hard.trial import TOLERANCES

pytestmark = pytest.mark.slow


def test_cases_are_listed_without_running_any(call: Call) -> None:
    answer = call("hard", "--list")
    assert answer.status == 0 and len(answer.out.splitlines()) == len(CASES)
    data = json.loads(call("hard", "--list", "--json").out)
    assert [d["case"] for d in data] == [c.name for c in CASES]


def test_rows_say_error_condition_drift_and_verdict(call: Call) -> None:
    answer = call("hard", "no-gyroscope", "--method", "scipy")
    head, good, last = answer.out.splitlines()
    assert answer.status == 0 and answer.err == ""
    assert head.split() == [
        "case", "method", "error", "condition", "roundings", "drift", "seconds", "verdict",
    ]  # fmt: skip
    assert good.split()[:2] == ["no-gyroscope", "scipy"] and good.endswith("met")
    assert "took no part" in last


def test_json_and_files_tell_the_same(call: Call) -> None:
    answer = call("hard", "no-gyroscope", "--method", "auto", "--json", "--out", "found")
    (told,) = json.loads(answer.out)
    assert answer.status == 0 and told["good"] and told["trials"][0]["verdict"] == "met"
    assert json.loads(Path("found/hard.json").read_text("utf-8")) == [told]
    assert "### no-gyroscope" in Path("found/hard-cases.md").read_text("utf-8")


def test_the_tools_own_choice_silently_wrong_is_status_1(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(TOLERANCES, "auto", 1e-4)
    answer = call("hard", "no-gyroscope", "--method", "auto")
    assert answer.status == 1
    assert "silently wrong: no-gyroscope" in answer.out


def test_another_method_that_misses_is_shown_and_no_failure(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(TOLERANCES, "scipy", 1e-4)
    answer = call("hard", "no-gyroscope", "--method", "scipy")
    assert answer.status == 0 and "missed in" in answer.out


def test_ctrl_c_keeps_the_finished_rows(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    true, seen = trial.attempt, []

    def attempt(case: Any, *rest: Any) -> Any:
        seen.append(case.name)
        if len(seen) == 2:
            raise KeyboardInterrupt
        return true(case, *rest)

    monkeypatch.setattr(trial, "attempt", attempt)
    answer = call("hard", "no-gyroscope", "turning-point", "--method", "auto")
    assert answer.status == 130 and "1 of 2 cases done" in answer.err
    assert "no-gyroscope" in answer.out and "turning-point" not in answer.out


def test_unknown_cases_and_methods_are_refused_with_the_nearest(call: Call) -> None:
    assert "did you mean 'turning-point'" in refused(call("hard", "turning-pint"))
    assert "there is no method 'scypi'; did you mean 'scipy'" in refused(
        call("hard", "--method", "scypi")
    )
