"""``voronec run --method closed-form`` as a user calls it."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest
from command_line import Call, refused

import voronec as vo

pytestmark = pytest.mark.slow


def test_run_evaluates_the_motion_in_closed_form(call: Call, tmp_path: Path) -> None:
    answer = call("run", "demchenko", "--method", "closed-form", "--times", "4:11", "--json")
    assert answer.status == 0
    told = json.loads(answer.out)
    assert told["method"] == "closed-form"
    assert told["steps"] == 0
    assert max(told["drift"].values()) < 1e-13


def test_run_gives_as_many_digits_as_are_asked_for(call: Call, tmp_path: Path) -> None:
    words = ("run", "demchenko", "--method", "closed-form", "--times", "0:2:3", "--outputs", "u")
    rows = []
    for tol in ("1e-50", "1e-60"):
        assert call(*words, "--tol", tol, "--out", f"at-{tol}").status == 0
        (file,) = tmp_path.glob(f"**/at-{tol}/trajectory.csv")
        rows.append(list(csv.DictReader(file.open()))[-1]["u"])
    assert rows[0][:50] == rows[1][:50]
    assert rows[0] != rows[1]


def test_run_says_in_a_line_what_has_no_closed_form(
    call: Call, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vo, "names", lambda: ["demchenko", "snakeboard"])
    answer = call("run", "snakeboard", "--method", "closed-form")
    assert "declares no motion in closed form" in refused(answer)


@pytest.mark.parametrize(
    ("span", "more", "method"),
    [
        (10**6, {}, "closed-form"),
        (10**6, {"outputs": ("u1",), "initial": {"u1": 1.2, "theta": 0.3}}, "closed-form"),
        (10**4, {"events": ("tau",)}, "heyoka"),
        (10**3, {}, "closed-form"),
        (10**2, {}, "heyoka"),
    ],
)
def test_auto_evaluates_long_motions(span: int, more: Any, method: str) -> None:
    if method == "heyoka":
        pytest.importorskip("heyoka")
        span = min(span, 10**4)
    given = {"outputs": ("u", "n"), "scene": "default", "tol": 1e-16, **more}
    found = vo.integrate(vo.load("demchenko"), times=[0, span], **given)
    assert found.cost.method == method
