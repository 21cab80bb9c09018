"""A frame in space proved: orthogonal, with a constant vector, and of no matter to the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict
from voronec.analysis.quadratures.ground import Ground, Residuals
from voronec.analysis.walls import across_walls
from voronec.quadratures import Space

__all__ = ["InSpace"]


@dataclass(frozen=True)
class InSpace:
    """What is stated of a frame in space, a matrix of functions of the state."""

    ground: Ground
    space: Space

    @cached_property
    def frame(self) -> list[list[Any]]:
        """The rows of the frame."""
        read = self.ground.field.read
        return [[read(self.space.frame[i, j]) for j in range(3)] for i in range(3)]

    @cached_property
    def vector(self) -> list[Any]:
        """The components of the vector along the frame."""
        return [self.ground.field.read(e) for e in self.space.vector]

    def orthogonal(self) -> Verdict:
        """E^T E = 1, and the columns are right-handed."""
        a, b, c = zip(*self.frame, strict=True)
        found = [("lengths", _dot(e, e) - 1) for e in (a, b)]
        found.append(("right angle", _dot(a, b)))
        crossed = [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]
        found += [("third column", x - y) for x, y in zip(crossed, c, strict=True)]
        return self.ground.zero(found)

    def constant(self) -> Verdict:
        """d(E m)/dt = 0."""
        rates = self.ground.field.derivatives([_dot(row, self.vector) for row in self.frame])
        found = self.ground.zero([(f"component {i + 1}", r) for i, r in enumerate(rates)])
        parts = [(f"component {i + 1}", _dot(row, self.vector)) for i, row in enumerate(self.frame)]
        return across_walls(found, self.ground.field, parts, constant=True)

    def free(self) -> Verdict:
        """Nothing else, nor how the frame turns along itself, depends on coordinates in space."""
        field = self.ground.field
        own = [field.read(q) for q in self.space.coordinates]
        pairs = zip(field.variables, field.components, strict=True)
        rest = [(f"the rate of {q}", rate) for q, rate in pairs if q not in own]
        rest += [(f"the vector, {i + 1}", m) for i, m in enumerate(self.vector)]
        rest += [(f"{s}", e) for s, e in self.ground.level.items()]
        rest += [(f"the turning, {i + 1}", e) for i, e in enumerate(self._turning())]
        found = [
            (f"{what} by {q}", e.diff(q)) for what, e in rest for q in own if q in e.free_symbols
        ]
        return self.ground.zero(found)

    def _turning(self) -> list[Any]:
        """The three entries of E^T dE/dt."""
        field = self.ground.field
        a, b, c = zip(*self.frame, strict=True)
        pairs = ((a, b), (b, c), (c, a))
        return [_dot(x, [field.derivative(e) for e in y]) for x, y in pairs]

    def inverse(self) -> Verdict:
        """The coordinates read off the frame are themselves, up to whole turns."""
        field, angles = self.ground.field, self.ground.angles
        entries = {
            field.door.inward(self.space.entries[i, j]): self.frame[i][j]
            for i in range(3) for j in range(3)
        }  # fmt: skip
        found: Residuals = []
        for q, value in self.space.coordinates.items():
            off = field.door.inward(value).xreplace(entries) - field.read(q)
            found += [
                (f"sin({plain_name(q)})", angles.resolved(se.sin(off))),
                (f"cos({plain_name(q)})", angles.resolved(se.cos(off)) - 1),
            ]
        return self.ground.zero(found)


def _dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return se.Add(*[x * y for x, y in zip(a, b, strict=True)])
