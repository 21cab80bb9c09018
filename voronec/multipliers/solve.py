"""The multiplier equations at one point and one precision.

    [ M   -A^T ] [ qddot  ]   [ h ]      A: constraints and differentiated relations
    [ A    0   ] [ lambda ] = [ b ]      M = d2L/dqdot2

Rows of A that depend on others are left out: the accelerations do not feel them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mpmath as mp

from voronec.errors import DefinitionError
from voronec.multipliers.linear import Elimination, Vector, eliminate, negligible
from voronec.multipliers.plan import Plan
from voronec.multipliers.point import Exact, at_precision

__all__ = ["Solution", "solve"]

GIVEN = 1e-9
"""How far a point may lie off its relations, and superfluous velocities off each other."""


@dataclass(frozen=True)
class Solution:
    """Accelerations, reaction A^T lambda and multipliers (constraints, then relations).

    ``determined`` says of each multiplier whether it is unique; 0 stands where it is not.
    """

    accelerations: Vector
    reaction: Vector
    multipliers: Vector
    determined: tuple[bool, ...]

    @property
    def numbers(self) -> Vector:
        """All of it in one list."""
        return [*self.accelerations, *self.reaction, *self.multipliers]


def solve(plan: Plan, values: Mapping[str, Exact]) -> Solution:
    """Solve at mpmath's working precision; ``DefinitionError`` where there is no solution."""
    numbers = at_precision(values)
    _settle(plan, numbers)
    _check_affinity(plan, numbers)
    rows = _find_velocities(plan, numbers)
    return _solve_motion(plan, numbers, rows)


def _settle(plan: Plan, numbers: dict[str, Any]) -> None:
    """Move the coordinates to the nearest point on the relations (Newton, steps of least norm).

    A point on them stays; one whose numbers were rounded comes so near that ranks can be told.
    """
    if not plan.system.fibration.relations:
        return
    residual, jacobian, sizes = _off_relations(plan, numbers)
    excess = [abs(r) - GIVEN * size for r, size in zip(residual, sizes, strict=True)]
    if max(excess) > 0:
        worst = excess.index(max(excess))
        raise DefinitionError(
            f"the point does not satisfy the relation {plan.system.fibration.relations[worst]}"
            f" = 0 (residual {mp.nstr(residual[worst], 5)}); correct the coordinates"
        )
    target = mp.mpf(10) ** (8 - mp.mp.dps)
    for _ in range(20):
        if all(abs(r) <= target * size for r, size in zip(residual, sizes, strict=True)):
            return
        for name, step in zip(plan.coordinates, _least_step(jacobian, residual), strict=True):
            numbers[name] -= step
        residual, jacobian, sizes = _off_relations(plan, numbers)
    raise DefinitionError(
        "the coordinates satisfy the relations only roughly, and the relations are too nearly "
        "dependent to improve them; give the coordinates with more digits"
    )


def _off_relations(plan: Plan, numbers: Mapping[str, Any]) -> tuple[Vector, list[Vector], Vector]:
    """The relations' values, their gradients, and the size that coordinates give their terms."""
    count, width = len(plan.system.fibration.relations), len(plan.coordinates)
    residual, flat = _split(plan.relations(numbers), count)
    jacobian = [flat[k * width : (k + 1) * width] for k in range(count)]
    reach = [max(abs(numbers[name]), 1) for name in plan.coordinates]
    sizes = [mp.fdot(map(abs, row), reach) for row in jacobian]
    return residual, jacobian, sizes


def _least_step(jacobian: list[Vector], residual: Vector) -> Vector:
    """The shortest x with J x = residual, for the independent rows of J."""
    width = len(jacobian[0])
    kept = eliminate(jacobian, residual, width).independent
    rows = [jacobian[k] for k in kept]
    gram = [[mp.fdot(a, b) for b in rows] for a in rows]
    weights = eliminate(gram, [residual[k] for k in kept], len(kept)).solution
    return [mp.fsum(w * row[i] for w, row in zip(weights, rows, strict=True)) for i in range(width)]


def _find_velocities(plan: Plan, numbers: dict[str, Any]) -> list[Vector]:
    """Solve for qdot, store it in ``numbers``, and return the rows of A."""
    width = len(plan.dots)
    flat = plan.kinematics(numbers)
    forms = [flat[k * (width + 1) : (k + 1) * (width + 1)] for k in range(len(plan.labels))]
    values = [mp.mpf(0)] * plan.exact + [numbers[name] for name in plan.velocities]
    matrix = [form[:-1] for form in forms]
    right = [value - form[-1] for value, form in zip(values, forms, strict=True)]
    found = eliminate(matrix, right, width, first=plan.exact)
    _check_consistency(plan, found, "contradicts the others")
    for row, rest in found.leftover.items():
        if row >= plan.exact and abs(rest) > GIVEN * found.size + _noise(found):
            raise DefinitionError(
                f"the velocity '{plan.velocities[row - plan.exact]}' of the point is off by "
                f"{mp.nstr(rest, 5)} from what the other velocities, the constraints and the "
                "relations make of it; correct the velocities"
            )
    if found.free:
        names = ", ".join(f"'{plan.dots[c]}'" for c in found.free)
        raise DefinitionError(
            f"constraints and velocities do not determine {names} at this point; add a "
            "constraint, or define the missing velocities with frame="
        )
    numbers.update(zip(plan.dots, found.solution, strict=True))
    return matrix[: plan.exact]


def _check_affinity(plan: Plan, numbers: Mapping[str, Any]) -> None:
    """What looked as if it bent in the velocities must not do so at generic ones."""
    generic = {v: mp.mpf(3 * k + 4) / (7 + k) for k, v in enumerate(plan.dots)}
    values = plan.bends({**numbers, **generic}) if plan.bent else []
    for label, value in zip(plan.bent, values, strict=True):
        if abs(value) > negligible():
            raise DefinitionError(
                f"{label} is not affine in the velocities; solve it for a velocity or "
                "differentiate it first"
            )


def _noise(found: Elimination) -> Any:
    """What remains of a right side where rounding alone can have left it."""
    return negligible() * max(found.size, mp.sqrt(negligible()))


def _check_consistency(plan: Plan, found: Elimination, verb: str) -> None:
    for row, rest in found.leftover.items():
        if row < plan.exact and abs(rest) > _noise(found):
            raise DefinitionError(
                f"{plan.labels[row]} {verb} at this point (by {mp.nstr(rest, 5)}); correct or "
                "drop it, or choose another point"
            )


def _solve_motion(plan: Plan, numbers: Mapping[str, Any], rows: list[Vector]) -> Solution:
    width = len(plan.dots)
    mass, force, right = _split(plan.dynamics(numbers), width * width, width)
    found = eliminate(rows, right, width)
    _check_consistency(plan, found, "depends on the others, and its derivative contradicts them,")
    kept = found.independent
    # Multipliers are scaled so that the size of the masses plays no part in what counts as zero.
    unit = max(map(abs, mass), default=mp.mpf(0)) or mp.mpf(1)
    sizes = {k: max(map(abs, rows[k])) for k in kept}
    upper = [
        [m / unit for m in mass[i * width : (i + 1) * width]]
        + [-rows[k][i] / sizes[k] for k in kept]
        for i in range(width)
    ]
    lower = [[c / sizes[k] for c in rows[k]] + [mp.mpf(0)] * len(kept) for k in kept]
    sides = [f / unit for f in force] + [right[k] / sizes[k] for k in kept]
    motion = eliminate(upper + lower, sides, width + len(kept))
    if motion.free:
        _refuse(plan, motion.kernel[0][:width])
    scaled = dict(zip(kept, motion.solution[width:], strict=True))
    multipliers = [
        scaled[k] * unit / sizes[k] if k in scaled else mp.mpf(0) for k in range(len(rows))
    ]
    reaction = [
        mp.fsum(m * row[i] for m, row in zip(multipliers, rows, strict=True)) for i in range(width)
    ]
    determined = _determined(rows, width) if found.leftover else (True,) * len(rows)
    unique = [m if d else mp.mpf(0) for m, d in zip(multipliers, determined, strict=True)]
    accelerations = _followed(plan, numbers, motion.solution[:width])
    return Solution(accelerations, reaction, unique, determined)


def _followed(plan: Plan, numbers: Mapping[str, Any], found: Vector) -> Vector:
    """On a group, the accelerations of the coordinates before those of the frame's velocities."""
    if plan.followers is None:
        return found
    flat, width = plan.followers(numbers), len(found) + 1
    rows = [flat[k * width : (k + 1) * width] for k in range(len(plan.coordinates))]
    return [*(mp.fdot(row[:-1], found) + row[-1] for row in rows), *found]


def _determined(rows: list[Vector], width: int) -> tuple[bool, ...]:
    """Which multipliers A^T lambda determines: those on which no null vector of A^T has a part."""
    transposed = [[row[i] for row in rows] for i in range(width)]
    kernel = eliminate(transposed, [mp.mpf(0)] * width, len(rows)).kernel
    return tuple(all(abs(vector[k]) <= negligible() for vector in kernel) for k in range(len(rows)))


def _refuse(plan: Plan, direction: Vector) -> None:
    largest = max(map(abs, direction)) or mp.mpf(1)
    parts = [
        f"{name} = {mp.nstr(x / largest, 5)}"
        for name, x in zip(plan.dots, direction, strict=True)
        if abs(x) > negligible() * largest
    ]
    raise DefinitionError(
        "the mass matrix is singular: no inertia resists the admissible velocity "
        f"({', '.join(parts)}); add its kinetic energy, or remove the coordinate"
    )


def _split(flat: Vector, *lengths: int) -> list[Vector]:
    """Consecutive pieces of a list, and the rest."""
    pieces, start = [], 0
    for length in lengths:
        pieces.append(flat[start : start + length])
        start += length
    return [*pieces, flat[start:]]
