"""Figures as rows, and the tables that pages show."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from voronec.accuracy.bench import Bench

__all__ = ["Row", "markdown", "runs", "table"]


@dataclass(frozen=True)
class Row:
    """One figure: what is measured, asked and reached; ``why`` is said where it is missed."""

    row: str
    asked: str
    reached: str
    good: bool
    why: str = ""

    @property
    def verdict(self) -> str:
        """In one word."""
        return "reached" if self.good else "missed"


def markdown(head: Sequence[str], lines: Iterable[Sequence[Any]]) -> str:
    """A table in Markdown."""
    first, *rows = ("| " + " | ".join(map(str, row)) + " |" for row in (head, *lines))
    return "\n".join([first, "|" + "---|" * len(head), *rows])


def table(rows: Iterable[Row]) -> str:
    """The table of figures."""
    head = ("what", "asked", "reached", "verdict")
    return markdown(head, ((r.row, r.asked, r.reached, r.verdict) for r in rows))


def runs(bench: Bench) -> str:
    """The table of the runs of a measurement."""
    head = ("method", "tolerance", "error", "µs per unit of time", "steps or evaluations")
    return markdown(
        head,
        (
            (one.name, f"{p.setting:g}", f"{p.error:.1e}", f"{1e6 * p.per_unit:.3g}", p.evaluations)
            for one in bench.methods
            for p in one.good
        ),
    )
