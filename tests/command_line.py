"""What a command said, and how a refusal reads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Answer:
    """What a command said."""

    status: int
    out: str
    err: str


Call = Callable[..., Answer]


def refused(answer: Answer) -> str:
    """The one line of a refusal."""
    assert answer.status == 2
    assert answer.out == ""
    assert "Traceback" not in answer.err
    (line,) = answer.err.splitlines()
    assert line.startswith("voronec")
    assert not [p for p in Path().iterdir() if p.suffix not in (".py", ".toml")], (
        "something was written"
    )
    return line
