"""Vectors of SymPy's as three components inside the door."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.door import Door
from voronec.algebra.matrices import dot
from voronec.errors import DefinitionError

__all__ = ["Components", "in_one_line"]

ZERO = se.Integer(0)


def in_one_line(ask: Callable[[], Any], what: str) -> Any:
    """What SymPy answers; its refusal, as where nothing connects two frames, in one line."""
    try:
        return ask()
    except (ValueError, TypeError, NotImplementedError) as error:
        text = " ".join(str(error).split())
        raise DefinitionError(f"from_mechanics: {what}: {text}") from None


@dataclass(frozen=True)
class Components:
    """Reads vectors; ``spelled`` says what speeds stand for, inside."""

    door: Door
    spelled: Mapping[Any, Any] = field(default_factory=dict)
    _turns: dict[Any, Any] = field(default_factory=dict)

    def of(self, vector: Any, frame: Any) -> list[Any]:
        """The components of a vector along the axes of a frame."""
        total = [ZERO, ZERO, ZERO]
        for column, own in getattr(vector, "args", ()):
            part = [self.read(c) for c in column]
            if own != frame:
                part = [dot(row, part) for row in self._turn(frame, own)]
            total = [a + b for a, b in zip(total, part, strict=True)]
        return total

    def dyadic(self, dyadic: Any, frame: Any) -> list[list[Any]]:
        """The components of a dyadic, as inertia is, along the axes of a frame."""
        table = [[ZERO] * 3 for _ in range(3)]
        for size, left, right in getattr(dyadic, "args", ()):
            a, b, m = self.of(left, frame), self.of(right, frame), self.read(size)
            for i in range(3):
                for j in range(3):
                    table[i][j] += m * a[i] * b[j]
        return table

    def read(self, expr: sp.Expr) -> Any:
        """An expression, speeds replaced by what they stand for."""
        return self.door.inward(expr).xreplace(self.spelled)

    def _turn(self, frame: Any, own: Any) -> list[list[Any]]:
        """The matrix that takes components along ``own`` to those along ``frame``."""
        if (frame, own) not in self._turns:
            what = f"the axes of {own} and {frame}"
            matrix = in_one_line(lambda: frame.dcm(own), what)
            self._turns[frame, own] = [[self.read(e) for e in matrix.row(i)] for i in range(3)]
        return self._turns[frame, own]
