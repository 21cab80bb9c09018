"""Errors on the command line advise options, not arguments of Python."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from command_line import Call, refused

pytestmark = pytest.mark.slow

BLOCK = """
name = "block"
lagrangian = "m*xdot^2/2"
[coordinates]
x = "place"
[parameters]
m = { positive = true }
[inputs]
u = "push"
[forces]
x = "u"
"""
PYTHON = re.compile(r"=[{(\[]|\w+='|\bgive times\b")


@pytest.fixture
def block(call: Call) -> str:
    Path("block.toml").write_text(BLOCK)
    return "block.toml"


@pytest.mark.parametrize(
    ("words", "advice"),
    [
        (("run", "--times", "3"), "give --input u=VALUE"),
        (("run", "--times", "3", "--input", "u=1"), "give --set m=VALUE"),
        (("run", "--input", "u=1", "--set", "m=1"), "give --times 0:10"),
        (("explain", "--input", "u=1", "--set", "m=1"), "give --set NAME=VALUE"),
    ],
)
def test_the_mend_is_an_option(call: Call, block: str, words: tuple[str, ...], advice: str) -> None:
    command, *rest = words
    answer = call(command, block, *rest)
    line = refused(answer)
    assert advice in line and not PYTHON.search(line)
