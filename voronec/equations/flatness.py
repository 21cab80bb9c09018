"""Flat outputs by dynamic extension.

Each output y_j is differentiated until inputs appear, y_j^(r_j) = b_j + A_j u.  Where A has full
rank and r_1 + r_2 + ... is the dimension of the state, the state is a function of the outputs and
their rates, and so are the inputs.  Where the rank is smaller, the highest rates of as many outputs
as are independent become inputs w = b + A u, and then, one integrator more, coordinates of a larger
state: the algorithm of [Isidori1995, sect. 5.4], which ends where the outputs are flat.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.normal import canonical
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.errors import EngineLimit

__all__ = ["flatness"]

NODES = 30_000
"""Rates of more nodes are not differentiated again."""
Independent = Callable[[Sequence[tuple[Any, ...]]], list[int]]


@dataclass(frozen=True)
class _ExtendedSystem:
    """A system with integrators before some of its inputs: the rates of its ``state`` are ``drift``
    and ``fields``, one for each input."""

    state: tuple[Any, ...]
    drift: tuple[Any, ...]
    fields: tuple[tuple[Any, ...], ...]
    relations: tuple[Any, ...]

    def along(self, field: Sequence[Any], function: Any) -> Any:
        """The derivative of a function along a field."""
        pairs = zip(self.state, field, strict=True)
        return se.Add(*[rate * function.diff(x) for x, rate in pairs if rate != 0])

    def relative_degree(self, output: Any) -> tuple[int, Any, tuple[Any, ...]] | None:
        """The order r at which inputs appear in the rates of an output, b and A; None where none
        do, or nobody can decide it."""
        for order in range(1, len(self.state) + 1):
            slopes = []
            for field in self.fields:
                slope = self.along(field, output)
                found = decide_zero(slope, self.relations)
                if found.undecided:
                    return None
                slopes.append(se.Integer(0) if found.proved else slope)
            output = self.along(self.drift, output)
            if any(slope != 0 for slope in slopes):
                return order, output, tuple(slopes)
            if Tape([output]).size > NODES:
                return None
        return None

    def prolong(
        self, rows: Sequence[tuple[Any, ...]], offsets: Sequence[Any], independent: Independent
    ) -> _ExtendedSystem:
        """The system whose inputs are the rates of w = b + A u, rows of full rank, and what is left
        of u."""
        columns = independent(list(zip(*rows, strict=True)))
        others = [k for k in range(len(self.fields)) if k not in columns]
        square = [[row[c] for c in columns] for row in rows]
        unit = range(len(rows))
        right = [
            [se.Integer(int(i == k)) for k in unit] + [-offsets[i], *(-row[k] for k in others)]
            for i, row in enumerate(rows)
        ]
        solved = solve_linear(square, right, self.relations).values
        fresh = tuple(se.Symbol(f"rate {len(self.state) + i}") for i in unit)
        drift, moved = list(self.drift), [list(self.fields[k]) for k in others]
        for c, values in zip(columns, solved, strict=True):
            given = se.Add(values[len(unit)], *[values[k] * fresh[k] for k in unit])
            drift = [f + g * given for f, g in zip(drift, self.fields[c], strict=True)]
            for field, share in zip(moved, values[len(unit) + 1 :], strict=True):
                field[:] = [f + g * share for f, g in zip(field, self.fields[c], strict=True)]
        with suppress(EngineLimit):
            drift = canonical(drift, self.relations)
        zero, size = se.Integer(0), len(self.state)
        integrators = [(*[zero] * size, *(se.Integer(int(i == k)) for i in unit)) for k in unit]
        return _ExtendedSystem(
            (*self.state, *fresh),
            (*drift, *[zero for _ in unit]),
            (*integrators, *((*field, *[zero for _ in unit]) for field in moved)),
            self.relations,
        )


def flatness(
    state: Sequence[Any], drift: Sequence[Any], fields: Sequence[Sequence[Any]],
    outputs: Sequence[Any], relations: Sequence[Any], redundant: int, independent: Independent,
) -> Verdict:  # fmt: skip
    """Whether outputs are flat; ``independent`` gives the rows that are so at a generic point, and
    ``redundant`` variables of the state are bound by relations."""
    system = _ExtendedSystem(
        tuple(state), tuple(drift), tuple(map(tuple, fields)), tuple(relations)
    )
    for _ in range(len(system.state)):
        met = [system.relative_degree(y) for y in outputs]
        found = [m for m in met if m is not None]
        if len(found) < len(met):
            return Verdict("undecided", "an output holds no input, whatever its rates, or too much")
        rows = [row for _, _, row in found]
        kept = independent(rows)
        if len(kept) == len(rows):
            total = sum(order for order, _, _ in found)
            size = len(system.state) - redundant
            if total == size:
                words = f"the outputs and {max(order for order, _, _ in found)} of their rates"
                return Verdict("proved", f"{words} determine state and inputs near generic states")
            words = f"{total} rates of the outputs are independent, and the state has {size}"
            return Verdict("refuted", f"{words} dimensions: a motion is left that they do not see")
        offsets = [found[k][1] for k in kept]
        system = system.prolong([rows[k] for k in kept], offsets, independent)
    return Verdict("undecided", f"{len(state)} times as many integrators do not suffice")
