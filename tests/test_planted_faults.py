"""The script that plants faults: what it plants, and that a fault is where it says."""

from __future__ import annotations

import ast

import pytest
from tool_modules import tool

planted_faults = tool("planted_faults")


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
        ("x[:1]", set()),
    ],
)
def test_each_kind_of_fault_is_planted_where_it_is(text: str, faults: set[tuple[str, str]]) -> None:
    source = f"above\n{text}\n".encode()
    made = planted_faults.faults_in("voronec/x.py", source)
    found = {(fault.kind, fault.plant_in(source).decode().split("\n")[1]) for fault in made}
    assert found == faults and {fault.line for fault in made} <= {2}
    for fault in made:
        ast.parse(fault.plant_in(source))


def test_the_files_that_are_most_about_a_module_come_first() -> None:
    fault = planted_faults.Fault("a.py", 3, "sign", 0, 0, "")
    reached = {
        "whole": {"lines": {"a.py": [1, 3], "b.py": [*range(9)]}},
        "own": {"lines": {"a.py": [3]}},
        "other": {"lines": {"a.py": [1], "b.py": [1]}},
    }
    assert planted_faults.tests_of(fault, reached) == ["own", "whole"]
