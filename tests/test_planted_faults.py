"""The script that plants faults: what it plants, and that a fault is where it says."""

from __future__ import annotations

import ast
import sys
from types import SimpleNamespace

import pytest
from tool_modules import tool

planted_faults = tool("planted_faults")
HEAD = "def f(a, b, c, x):\n"


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("a + b", {("sign", "(a - b)"), ("dropped term", "(a)")}),
        ("-a * b", {("sign", "(a) * b")}),
        ("x[0]", {("index", "x[(0 + 1)]")}),
        ("a <= b", {("bound", "(a < b)")}),
        ("a == b and c", {("condition", "(a != b) and c"), ("condition", "(a == b or c)")}),
        ("1 if é else 2", {("condition", "1 if (not (é)) else 2")}),
        ("f'{a}' + b", set()),
        ("f'{a + b}'", set()),
        ("x[:1]", set()),
    ],
)
def test_each_kind_of_fault_is_planted_where_it_is(text: str, faults: set[tuple[str, str]]) -> None:
    source = f"{HEAD}    {text}\n".encode()
    made = planted_faults.faults_in("voronec/x.py", source)
    found = {(fault.kind, fault.plant_in(source).decode().split("\n")[1].strip()) for fault in made}
    assert found == faults and {fault.line for fault in made} <= {2}
    for fault in made:
        ast.parse(fault.plant_in(source))
        ast.parse(fault.probe_in(source, 1))


def test_a_probe_tells_that_its_place_is_reached_and_changes_nothing(monkeypatch) -> None:
    source = f"{HEAD}    return [1, 2][0] - (3 if a else 4)\n".encode()
    (fault,) = (f for f in planted_faults.faults_in("x.py", source) if f.kind == "index")
    told: list[int] = []
    monkeypatch.setitem(sys.modules, "planted_probe", SimpleNamespace(reached=told.append))
    space: dict = {}
    exec(fault.probe_in(source, 7), space)
    assert space["f"](True, 0, 0, {}) == -2 and told == [7]


def test_tests_that_pass_without_a_fault_and_come_by_few_are_first() -> None:
    told = ("0", "a"), ("1", "a"), ("0", "b"), ("0", "c"), ("fails", "c")
    assert planted_faults.tests_of(3, dict.fromkeys(told)) == [["b", "a"], ["a"], []]
