"""What every printer of a program writes: functions of the same arguments, one for each block."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from voronec.equations.program.jacobian import jacobian, jacobian_columns
from voronec.equations.program.straight import Block, Program

TITLES = "rhs", "extras", "jacobian"
"""The names of the functions."""


class Part(NamedTuple):
    """One function: its name, its purpose in words, what it computes, and what its rows mean; and
    its columns, where it is a matrix."""

    title: str
    purpose: str
    block: Block
    rows: tuple[str, ...]
    columns: tuple[str, ...] = ()

    @property
    def meanings(self) -> list[str]:
        """What each result means."""
        return [f"d({row})/d({x})" for row in self.rows for x in self.columns] or [*self.rows]

    def write(self, values: Sequence[str], begin: str, end: str) -> list[tuple[str, str]]:
        """The results as text, a row of the matrix between ``begin`` and ``end``, with meanings."""
        width = len(self.columns)
        if not width:
            return list(zip(values, self.rows, strict=True))
        lines = [", ".join(values[i : i + width]) for i in range(0, len(values), width)]
        about = [f"of {row}" for row in self.rows]
        return [(f"{begin}{line}{end}", of) for line, of in zip(lines, about, strict=True)]


def parts_of(program: Program, slopes: bool = False) -> list[Part]:
    """The rates of the state, extra quantities where there are any, and, with ``slopes``, the
    Jacobian of the rates."""
    rates = tuple(f"d({s})/dt" for s in program.state)
    parts = [Part("rhs", "Time derivatives of the state.", program.derivative, rates)]
    if program.names:
        purpose = f"Computes {', '.join(program.names)}."
        parts.append(Part("extras", purpose, program.extras, program.names))
    if slopes:
        by = "the state" + (", then by the inputs" if program.inputs else "")
        purpose = f"Derivatives of the rates by {by}: a row for each rate."
        columns = tuple(map(str, jacobian_columns(program)))
        parts.append(Part("jacobian", purpose, jacobian(program), rates, columns))
    return parts


def arguments_of(program: Program) -> tuple[Any, ...]:
    """All symbols that a function is given, but for the time."""
    return (*program.state, *program.parameters, *program.inputs)


def groups_of(program: Program) -> list[tuple[str, tuple[Any, ...]]]:
    """The arguments that are arrays, with what they hold; inputs only where there are any."""
    groups = [("state", program.state), ("parameters", program.parameters)]
    return groups + ([("inputs", program.inputs)] if program.inputs else [])
