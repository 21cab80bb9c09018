"""The form in which integrals are sought: monomials in given letters, within bounds on degrees."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from voronec.analysis.search.residues import Array

__all__ = ["Ansatz", "Letter"]


@dataclass(frozen=True)
class Letter:
    """One function of the state, of ``kind`` velocity, position or denominator.

    ``name`` is how it is printed, ``value`` what it is, inside the door, ``meaning`` in the
    user's symbols; a denominator enters by its reciprocal, its meaning is the denominator.
    """

    name: sp.Expr
    value: Any
    meaning: sp.Expr
    kind: str

    @property
    def named(self) -> bool:
        """Whether the name is not the function itself."""
        return bool(self.symbol != self.meaning)

    @property
    def symbol(self) -> sp.Expr:
        """What ``meaning`` is the meaning of: the name, or what the name is the reciprocal of."""
        return 1 / self.name if self.kind == "denominator" else self.name


@dataclass(frozen=True)
class Ansatz:
    """Sums of monomials of degree up to ``degree`` in the letters of kind velocity, ``positions``
    in those of kind position, over up to ``power`` powers of each denominator."""

    letters: tuple[Letter, ...]
    degree: int
    positions: int
    power: int

    def of(self, kind: str) -> list[Letter]:
        """The letters of one kind."""
        return [letter for letter in self.letters if letter.kind == kind]

    def count(self) -> int:
        """How many monomials there are."""
        total = (self.power + 1) ** len(self.of("denominator"))
        for kind, bound in (("velocity", self.degree), ("position", self.positions)):
            total *= int(sp.binomial(len(self.of(kind)) + bound, bound))
        return total

    def exponents(self) -> Array:
        """One row for each monomial, in the order of the letters; low degrees first."""
        columns: dict[str, list[int]] = {"velocity": [], "position": [], "denominator": []}
        for i, letter in enumerate(self.letters):
            columns[letter.kind].append(i)
        rows = []
        for v in _up_to(len(columns["velocity"]), self.degree):
            for q in _up_to(len(columns["position"]), self.positions):
                for d in np.ndindex(*([self.power + 1] * len(columns["denominator"]))):
                    row = np.zeros(len(self.letters), dtype=np.int64)
                    row[columns["velocity"]] = v
                    row[columns["position"]] = q
                    row[columns["denominator"]] = d
                    rows.append(row)
        return np.array(sorted(rows, key=_order), dtype=np.int64).reshape(-1, len(self.letters))

    def degrees(self, exponents: Array) -> Array:
        """The degree in the velocities of each monomial."""
        moving = [letter.kind == "velocity" for letter in self.letters]
        return exponents[:, moving].sum(axis=1)

    def words(self) -> str:
        """The form, in one line."""
        velocities, positions = (
            ", ".join(str(x.name) for x in self.of(kind)) for kind in ("velocity", "position")
        )
        parts = []
        if velocities:
            parts.append(f"of degree up to {self.degree} in {velocities}")
        if positions:
            parts.append(f"of degree up to {self.positions} in {positions}")
        text = "a polynomial " + " and ".join(parts)
        below = [str(x.symbol) for x in self.of("denominator")]
        if below:
            power = f"^{self.power}" if self.power > 1 else ""
            text += " over " + " ".join(f"{b}{power}" for b in below)
        return text.replace("**", "^")


def _up_to(letters: int, degree: int) -> Iterator[Sequence[int]]:
    """Exponents of total degree up to a bound."""
    if letters == 0:
        yield ()
        return
    for first in range(degree + 1):
        for rest in _up_to(letters - 1, degree - first):
            yield (first, *rest)


def _order(row: Array) -> tuple[int, ...]:
    return (int(row.sum()), *(-int(e) for e in row))
