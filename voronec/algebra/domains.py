"""What an inequality is made of: its relation, and symbols that are real, or negative."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from voronec.algebra.verdicts import Verdict
from voronec.errors import DefinitionError

__all__ = ["RELATIONS", "mirrored", "real_symbols", "refuse_signs"]

RELATIONS = {
    "<": "<",
    ">": ">",
    "<=": "<=",
    ">=": ">=",
    "!=": "!=",
    "\\lt": "<",
    "\\gt": ">",
    "\\le": "<=",
    "\\leq": "<=",
    "\\leqslant": "<=",
    "\\ge": ">=",
    "\\geq": ">=",
    "\\geqslant": ">=",
    "\\ne": "!=",
    "\\neq": "!=",
}
"""Relations by their spellings, in LaTeX too."""


def real_symbols(*sides: Any) -> list[Any]:
    """The symbols of both sides, by name; one that takes no real values is an error."""
    symbols = sorted(set().union(*(side.free_symbols for side in sides)), key=str)
    for symbol in symbols:
        if symbol.is_real is False:
            raise DefinitionError(f"'{symbol}' is not real; inequalities are between real numbers")
    return symbols


def refuse_signs(below: Iterable[Any], declared: Sequence[Any]) -> None:
    """A symbol that SymPy knows to be negative must not be declared otherwise."""
    for symbol in below:
        if symbol in declared:
            raise DefinitionError(
                f"'{symbol}' is negative for SymPy, and declared otherwise; declare it once"
            )


def mirrored(verdict: Verdict) -> Verdict:
    """A verdict on |m| as one on m = -|m|."""
    if verdict.witness is None:
        return verdict
    point = {
        name.strip("|"): f"-{value}" if name.startswith("|") else value
        for name, value in verdict.witness.point.items()
    }
    return replace(verdict, witness=replace(verdict.witness, point=point))
