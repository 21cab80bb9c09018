"""Poisson brackets of the reduced equations: x' = clock {x, H}, skew, with Jacobi's identity.

The variables z are functions of the state x; a derivative by z is taken through the inverse of
dz/dx.  Where relations bind x, z are either as many as all of x, and then the bracket must keep the
relations, or as many as are independent, and then the relations are Casimirs by definition.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict
from voronec.declaration.claims import Poisson
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.proof.decision import Decision, all_zero
from voronec.proof.walls import across_walls

__all__ = ["decide_poisson"]


def decide_poisson(motions: Motions, claim: Poisson) -> Decision:
    """The variables determine the state, Jacobi's identity, kept relations, the equations."""
    functions = [v for k, v in claim.variables.items() if v != k]
    own = {k for k, v in claim.variables.items() if v == k}
    others = (*claim.bracket.values(), claim.hamiltonian, claim.clock)
    names = {*claim.variables} - own
    used = [s for e in others for s in e.free_symbols if s not in names]
    field = motions.field_for([*functions, *own, *used])
    structure = _Structure(field, claim)
    if structure.inverse is None:
        words = f"the {len(claim.variables)} variables do not determine the state"
        why = f"{words} on the {field.level}, of {field.dimension} dimensions"
        return Decision(Verdict("refuted", why), field.level)
    found = all_zero(structure.residuals(), field.hypotheses)
    found = across_walls(found, field, [*structure.named_variables()])
    found = across_walls(found, field, [*structure.named_functions()], periods=False)
    return Decision(found, field.level)


@dataclass(frozen=True)
class _Structure:
    """A bracket inside the door; its variables have symbols of their own."""

    field: VectorField
    claim: Poisson

    @cached_property
    def symbols(self) -> list[Any]:
        """The variables z."""
        return [se.Symbol(f"bracket variable {plain_name(z)}") for z in self.claim.variables]

    @cached_property
    def meaning(self) -> dict[Any, Any]:
        """z as functions of the state."""
        values = [self.field.read(e) for e in self.claim.variables.values()]
        return dict(zip(self.symbols, values, strict=True))

    def read(self, expr: Any) -> Any:
        """A function of z and of the state."""
        inward = self.field.door.inward
        names = map(inward, self.claim.variables)
        return self.field.express(
            inward(expr).xreplace(dict(zip(names, self.symbols, strict=True)))
        )

    @cached_property
    def table(self) -> list[list[Any]]:
        """{z_i, z_j}."""
        keys, size = [*self.claim.variables], len(self.claim.variables)
        table = [[se.Integer(0)] * size for _ in range(size)]
        for (a, b), entry in self.claim.bracket.items():
            i, j = keys.index(a), keys.index(b)
            table[i][j] = self.read(entry)
            table[j][i] = -table[i][j]
        return table

    @cached_property
    def inverse(self) -> list[list[Any]] | None:
        """dx/dz, a row for each state variable; None where z does not determine x."""
        field, functions = self.field, [*self.meaning.values()]
        if len(functions) + len(field.independent_relations) == len(field.variables):
            functions = [*functions, *field.independent_relations]
        size = len(field.variables)
        if len(functions) != size:
            return None
        rows = [[f.diff(x) for x in field.variables] for f in functions]
        unit = [[se.Integer(int(i == j)) for j in range(size)] for i in range(size)]
        solved = solve_linear(rows, unit, field.hypotheses)
        return None if solved.free else solved.values

    def slopes(self, function: Any) -> list[Any]:
        """The derivatives of a function of z and x by each z."""
        assert self.inverse is not None
        found = [function.diff(z) for z in self.symbols]
        for x, row in zip(self.field.variables, self.inverse, strict=True):
            slope = function.diff(x)
            if slope != 0:
                found = [d + slope * e for d, e in zip(found, row, strict=False)]
        return found

    def along(self, i: int, slopes: list[Any]) -> Any:
        """{z_i, F} from the derivatives of F."""
        return dot(self.table[i], slopes)

    def named_variables(self) -> Iterator[tuple[str, Any]]:
        """The variables as functions of the state."""
        names = map(plain_name, self.claim.variables)
        yield from zip(names, self.meaning.values(), strict=True)

    def named_functions(self) -> Iterator[tuple[str, Any]]:
        """The Hamiltonian, the clock and the entries of the bracket as functions of the state."""
        yield "the Hamiltonian", self.read(self.claim.hamiltonian).xreplace(self.meaning)
        yield "the clock", self.read(self.claim.clock).xreplace(self.meaning)
        for (a, b), entry in self.claim.bracket.items():
            name = f"the bracket of {plain_name(a)} with {plain_name(b)}"
            yield name, self.read(entry).xreplace(self.meaning)

    def residuals(self) -> Iterator[tuple[str, Any]]:
        """What has to vanish, with its name."""
        for label, residual in (*self._jacobi(), *self._relation_brackets(), *self._motion()):
            yield label, residual.xreplace(self.meaning)

    def _jacobi(self) -> Iterator[tuple[str, Any]]:
        names = [plain_name(z) for z in self.claim.variables]
        size = range(len(names))
        slopes = {(i, j): self.slopes(self.table[i][j]) for i in size for j in size}
        for i, j, k in combinations(size, 3):
            cycles = ((i, j, k), (j, k, i), (k, i, j))
            total = se.Add(*[self.along(a, slopes[b, c]) for a, b, c in cycles])
            yield f"Jacobi's identity of {names[i]}, {names[j]}, {names[k]}", total

    def _relation_brackets(self) -> Iterator[tuple[str, Any]]:
        """The bracket of each variable with each relation vanishes, as it does by definition where
        the relations are further variables."""
        for relation in self.field.independent_relations:
            slopes = self.slopes(relation)
            for i, z in enumerate(self.claim.variables):
                yield f"the bracket of {plain_name(z)} with {relation}", self.along(i, slopes)

    def _motion(self) -> Iterator[tuple[str, Any]]:
        slopes = self.slopes(self.read(self.claim.hamiltonian))
        clock = self.read(self.claim.clock)
        rates = self.field.derivatives([*self.meaning.values()])
        for i, (z, rate) in enumerate(zip(self.claim.variables, rates, strict=True)):
            yield f"the rate of {plain_name(z)}", rate - clock * self.along(i, slopes)
