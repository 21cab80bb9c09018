"""What commands share in printing: JSON, columns, expressions in plain text, progress."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from typing import Any

__all__ = ["columns", "plain", "print_json", "progress", "warn"]


def print_json(data: Any) -> None:
    """Data to stdout as JSON; expressions and numbers of other libraries as text."""
    print(json.dumps(data, indent=2, ensure_ascii=False, default=str))


def columns(rows: Iterable[Sequence[str]], indent: str = "") -> list[str]:
    """Rows of words as aligned lines, two blanks between columns."""
    table = [list(row) for row in rows]
    if not table:
        return []
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = ("  ".join(w.ljust(n) for w, n in zip(row, widths, strict=True)) for row in table)
    return [indent + line.rstrip() for line in lines]


def plain(expr: Any) -> str:
    """A SymPy expression in one line, coordinates by their bare names, powers as ``x^2``."""
    from voronec.algebra.typeset import plain_text

    return plain_text(expr).replace("**", "^")


def warn(message: str) -> None:
    """A warning, one line on stderr."""
    print(f"voronec: warning: {message}", file=sys.stderr)


def progress(message: str) -> None:
    """Progress of long work: one line on stderr that replaces itself, on a terminal only."""
    if sys.stderr.isatty():
        print(f"\r\x1b[2K{message}", end="", file=sys.stderr, flush=True)
