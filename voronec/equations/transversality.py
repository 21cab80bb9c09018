"""Whether constraints determine the velocities of the fibre; what to say where they do not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import symengine as se

from voronec.algebra.elimination import solve_linear
from voronec.algebra.symbols import plain_name
from voronec.declaration.system import System
from voronec.equations.connection import AffineForms, FibreSolution, solve_fibre
from voronec.errors import DefinitionError

__all__ = ["solve_for_fibre"]


def solve_for_fibre(
    system: System,
    constraints: AffineForms,
    differentiated: AffineForms,
    ideal: Sequence[Any],
    near: Mapping[str, Any],
    share: float = 0.0,
) -> FibreSolution:
    """The fibre velocities in terms of the others; ``DefinitionError``, with a split that works,
    where the constraints do not determine them."""
    base = system.base_directions
    fibre, solution = solve_fibre(constraints, differentiated, base, ideal, near, share)
    if solution is None:
        return fibre
    k = len(constraints.matrix)
    left_over = [i for i in (*solution.dependent, *solution.contradictory) if i < k]
    if not solution.free and not left_over:
        return fibre
    _explain_dependence(system, constraints, ideal)
    dependent = system.directions[base:]
    names = [plain_name(dependent[j]) for j in solution.free]
    split = _working_split(system, constraints, ideal)
    raise DefinitionError(
        f"system '{system.name}': the constraints do not determine the velocities of the fibre "
        f"(undetermined: {', '.join(names)}); a split that works: "
        f"base=({', '.join(split[0])}), fibre=({', '.join(split[1])})"
    )


def _explain_dependence(system: System, constraints: AffineForms, ideal: Sequence[Any]) -> None:
    """Raise where the constraints themselves are dependent or contradictory."""
    right = [[-o] for o in constraints.offset]
    whole = solve_linear(constraints.matrix, right, ideal)
    if whole.contradictory:
        raise DefinitionError(
            f"system '{system.name}': the constraints contradict each other (constraint "
            f"{whole.contradictory[0] + 1} is inconsistent with the others); correct or drop it"
        )
    if whole.dependent:
        raise DefinitionError(
            f"system '{system.name}': constraint {whole.dependent[0] + 1} follows from the "
            "others; drop it, and move one coordinate from the fibre to the base"
        )


def _working_split(
    system: System, constraints: AffineForms, ideal: Sequence[Any]
) -> tuple[list[str], list[str]]:
    """A choice of fibre coordinates for which the constraints can be solved, near the given one."""
    velocities, base = system.directions, system.base_directions
    total = len(velocities)
    order = [*range(base, total), *range(base)]
    chosen: list[int] = []
    for j in order:
        trial = [*chosen, j]
        columns = [[row[i] for i in trial] for row in constraints.matrix]
        if not solve_linear(columns, [[se.Integer(0)]] * len(columns), ideal).free:
            chosen = trial
        if len(chosen) == len(constraints.matrix):
            break
    names = [plain_name(q) for q in velocities]
    return [names[i] for i in range(total) if i not in chosen], [names[i] for i in sorted(chosen)]
