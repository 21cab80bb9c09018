"""What commands share in printing: JSON, columns, expressions in plain text, progress."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any


def answer(as_json: bool, data: Callable[[], Any], lines: Iterable[Any]) -> None:
    """What a command says, to stdout: data as JSON, expressions and numbers of other libraries as
    text; or lines.  Only what is printed is made."""
    if as_json:
        print(json.dumps(data(), indent=2, ensure_ascii=False, default=str))
    else:
        for line in lines:
            print(line)


def wrote(files: Iterable[Any]) -> list[str]:
    """The line that says where results are; none where nothing was written."""
    return ["wrote " + ", ".join(map(str, files))] if files else []


def plain(expr: Any) -> str:
    """A SymPy expression in one line, coordinates by their bare names, powers as ``x^2``."""
    from voronec.algebra.typeset import caret_text

    return caret_text(expr)


def warn(message: str) -> None:
    """A warning, one line on stderr."""
    print(f"voronec: warning: {message}", file=sys.stderr)


def progress(message: str) -> None:
    """Progress of long work: one line on stderr that replaces itself, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\x1b[2K{message}", end="", file=sys.stderr, flush=True)


@contextmanager
def progress_line(message: str = "") -> Iterator[None]:
    """Progress of the work inside, a message first; its line goes when the work ends."""
    progress(message)
    try:
        yield
    finally:
        progress("")
