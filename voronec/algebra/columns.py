"""Rows of words as aligned columns."""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence


def columns(
    rows: Iterable[Sequence[str]], indent: str = "", right: Container[int] = ()
) -> list[str]:
    """Rows of words as aligned lines, two blanks between columns, some of them, as of numbers,
    aligned at the ``right``."""
    table = [list(row) for row in rows]
    if not table:
        return []
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    sides = [str.rjust if i in right else str.ljust for i in range(len(widths))]
    lines = (
        "  ".join(side(w, n) for side, w, n in zip(sides, row, widths, strict=True))
        for row in table
    )
    return [indent + line.rstrip() for line in lines]
