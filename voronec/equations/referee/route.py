"""Accelerations and reactions by multipliers, each digit confirmed at a higher precision.

    [ M   -A^T ] [ qddot  ]   [ h ]      A: constraints and differentiated relations
    [ A    0   ] [ lambda ] = [ b ]      M = d2L/dqdot2

This is [Theory, eq. (13)].  Rows of A that depend on others are left out: the accelerations do not
feel them.
The rank is found on the way, in mpmath at the working precision.

Numbers of the point at which equations are evaluated are taken exactly.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from types import MappingProxyType
from typing import Any, TypeAlias

import mpmath as mp
import sympy as sp

from voronec.algebra.arguments import POINT, accepts, require_digits
from voronec.algebra.symbols import plain_name, time
from voronec.algebra.text import as_expression, exact_number
from voronec.declaration.system import System, require_system
from voronec.equations.point_values import named_point
from voronec.equations.referee.names import rate_names
from voronec.equations.referee.plan import Plan, make_plan
from voronec.errors import DefinitionError

SLACK = 1e-9
"""How far a point may lie off its relations, and superfluous velocities off each other."""


@dataclass(frozen=True)
class MultiplierSolution:
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


def solve(plan: Plan, values: Mapping[str, Exact]) -> MultiplierSolution:
    """Solve at mpmath's working precision; ``DefinitionError`` where there is no solution."""
    numbers = {name: _round(value) for name, value in values.items()}
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
    excess = [abs(r) - SLACK * size for r, size in zip(residual, sizes, strict=True)]
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
    elimination = eliminate(matrix, right, width, first=plan.exact)
    _check_consistency(plan, elimination, "contradicts the others")
    for row, rest in elimination.leftover.items():
        if row >= plan.exact and abs(rest) > SLACK * elimination.size + _noise(elimination):
            raise DefinitionError(
                f"the velocity '{plan.velocities[row - plan.exact]}' of the point is off by "
                f"{mp.nstr(rest, 5)} from what the other velocities, the constraints and the "
                "relations make of it; correct the velocities"
            )
    if elimination.free:
        names = ", ".join(f"'{plan.dots[c]}'" for c in elimination.free)
        raise DefinitionError(
            f"constraints and velocities do not determine {names} at this point; add a "
            "constraint, or define the missing velocities with frame="
        )
    numbers.update(zip(plan.dots, elimination.solution, strict=True))
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


def _solve_motion(plan: Plan, numbers: Mapping[str, Any], rows: list[Vector]) -> MultiplierSolution:
    width = len(plan.dots)
    mass, force, right = _split(plan.dynamics(numbers), width * width, width)
    elimination = eliminate(rows, right, width)
    _check_consistency(
        plan, elimination, "depends on the others, and its derivative contradicts them,"
    )
    kept = elimination.independent
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
    determined = _determinacy(rows, width) if elimination.leftover else (True,) * len(rows)
    unique = [m if d else mp.mpf(0) for m, d in zip(multipliers, determined, strict=True)]
    accelerations = _group_accelerations(plan, numbers, motion.solution[:width])
    return MultiplierSolution(accelerations, reaction, unique, determined)


def _group_accelerations(plan: Plan, numbers: Mapping[str, Any], found: Vector) -> Vector:
    """On a group, the accelerations of the coordinates before those of the frame's velocities."""
    if plan.followers is None:
        return found
    flat, width = plan.followers(numbers), len(found) + 1
    rows = [flat[k * width : (k + 1) * width] for k in range(len(plan.coordinates))]
    return [*(mp.fdot(row[:-1], found) + row[-1] for row in rows), *found]


def _determinacy(rows: list[Vector], width: int) -> tuple[bool, ...]:
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


GUARD = 25
"""Decimal digits computed beyond those asked for."""

DOUBLINGS = 5
"""How often the precision is doubled before an answer is given up."""


@dataclass(frozen=True)
class Reactions:
    """What the constraints do: lambda and A^T lambda in d/dt dL/dqdot - dL/dq = Q + A^T lambda.

    ``multipliers``
        lambda_k of constraint k (as given: an expression that vanishes, so twice the expression
        has half the multiplier); None where some of them are not unique, because constraints
        depend on each other or on the relations.
    ``relation_multipliers``
        the same for the relations of redundant coordinates; empty where there are none.
    ``generalized``
        coordinate -> its component of A^T lambda, of constraints and relations together; unique
        always.  Units are those of dL/dq.
    """

    multipliers: tuple[sp.Float, ...] | None
    relation_multipliers: tuple[sp.Float, ...] | None
    generalized: Mapping[sp.Expr, sp.Float]


@accepts(point=POINT)
def multiplier_acceleration(
    system: System, point: Mapping[Any, Any], digits: int = 30
) -> dict[sp.Expr, sp.Float]:
    """Second time derivatives of all coordinates by d'Alembert's principle with multipliers.

    On a group, the derivatives of its frame's velocities follow.

        d/dt dL/dqdot - dL/dq = Q + A^T lambda,    A qddot = b

    where A holds the constraints and the derivatives of the relations.  ``point`` maps symbols or
    names to numbers: coordinates, the velocities ``system.velocities``, parameters without default
    values, and the time where it occurs.  Numbers (int, Fraction, float, Decimal, SymPy's,
    mpmath's, strings) are taken exactly.  Coordinates may be off the relations by rounding (1e-9):
    the nearest point on the relations is taken.

    Every digit is confirmed by a second computation at twice the precision; an inertia (or a
    part of a constraint) that is 10^(digits + 25) times smaller than the others counts as none.

    Raises ``DefinitionError`` for a point that misses a value, has an unknown name or lies off the
    relations; for constraints that are not affine or contradict each other; where an admissible
    velocity has no inertia; for an unknown function; where the equations are not defined.
    """
    solution = _confirm(require_system(system), point, digits)
    things = (*system.coordinates, *(system.directions if system.on_group else ()))
    return _label(things, solution.accelerations, digits)


@accepts(point=POINT)
def reaction_forces(system: System, point: Mapping[Any, Any], digits: int = 30) -> Reactions:
    """The multipliers lambda and the reaction forces A^T lambda at a point, to ``digits`` digits.

    Arguments and errors are those of ``multiplier_acceleration``.
    """
    solution = _confirm(require_system(system), point, digits)
    count = len(system.constraints)

    def unique(part: slice) -> tuple[sp.Float, ...] | None:
        if not all(solution.determined[part]):
            return None
        return tuple(sp.Float(x, digits) for x in solution.multipliers[part])

    return Reactions(
        multipliers=unique(slice(None, count)),
        relation_multipliers=unique(slice(count, None)),
        generalized=MappingProxyType(_label(system.directions, solution.reaction, digits)),
    )


def _label(things: tuple[sp.Expr, ...], numbers: Vector, digits: int) -> dict[sp.Expr, sp.Float]:
    return {x: sp.Float(number, digits) for x, number in zip(things, numbers, strict=True)}


def _confirm(system: System, point: Mapping[Any, Any], digits: int) -> MultiplierSolution:
    """A solution of which two precisions agree to the digits asked for."""
    require_digits(f"system '{system.name}'", digits)
    try:
        plan: Plan = system.memo.once("plan of the referee", lambda: make_plan(system))
    except DefinitionError as error:
        raise DefinitionError(f"system '{system.name}': {error}") from None
    values = _read_point(system, point, plan.occurring_names)
    precision = digits + GUARD
    before = _attempt(plan, values, precision)
    for _ in range(DOUBLINGS):
        precision *= 2
        after = _attempt(plan, values, precision)
        if isinstance(before, DefinitionError) and isinstance(after, DefinitionError):
            raise DefinitionError(f"system '{system.name}': {after}")
        if isinstance(before, MultiplierSolution) and isinstance(after, MultiplierSolution):
            settled = _later_solution(before, after, digits, precision // 2)
            if settled is not None:
                return settled
        before = after
    raise DefinitionError(
        f"system '{system.name}': {digits} digits could not be confirmed with {precision} at this "
        "point; the equations are singular nearby, so choose another point"
    )


def _attempt(
    plan: Plan, values: Mapping[str, Exact], precision: int
) -> MultiplierSolution | DefinitionError:
    """A failure at one precision is a value too: more digits may tell two ranks apart."""
    with mp.workdps(precision):
        try:
            return solve(plan, values)
        except DefinitionError as error:
            return error


def _later_solution(
    before: MultiplierSolution, after: MultiplierSolution, digits: int, lower: int
) -> MultiplierSolution | None:
    """The later solution if the earlier one, made with ``lower`` digits, confirms it.

    A number that shrinks with the precision is zero: what was computed of it is rounding alone.
    """
    if before.determined != after.determined:
        return None
    settled = []
    with mp.workdps(lower):
        near, vanishing = mp.mpf(10) ** (-digits - 3), mp.mpf(10) ** (-4 * lower // 5)
        for a, b in zip(before.numbers, after.numbers, strict=True):
            if abs(b) <= abs(a) * vanishing:
                settled.append(mp.mpf(0))
            elif abs(a - b) <= near * abs(b):
                settled.append(b)
            else:
                return None
    n = len(after.accelerations)
    end = n + len(after.reaction)
    return MultiplierSolution(settled[:n], settled[n:end], settled[end:], after.determined)


Exact: TypeAlias = Fraction | mp.mpf | sp.Expr
"""A number without error: a fraction, a binary number of any length, or an exact expression."""
LARGEST = 1e6
"""Logarithm of the largest power that a number may hold: towers of exponentials have no end."""


def _read_point(system: System, point: Mapping[Any, Any], held: Set[str]) -> dict[str, Exact]:
    """The point by plain names; the time, inputs and their rates only where they occur, by their
    names, that is among ``held``."""
    clock = plain_name(time)
    driven = {name: u for u in system.inputs for name in rate_names(u)}
    values = named_point(system, point, {clock, *driven}, _exact)
    for name in sorted(driven.keys() & held - values.keys()):
        raise DefinitionError(
            f"system '{system.name}': the unknown function '{driven[name]}' has no value; add "
            f"'{name}' to the point"
        )
    if clock in held and clock not in values:
        raise DefinitionError(
            f"the point gives no value for '{clock}' of system '{system.name}'; add it to the point"
        )
    return {clock: Fraction(0), **values}


def _exact(system: System, name: str, number: Any) -> Exact:
    """A number as it stands: decimals in strings are decimals, floats are binary."""
    try:
        value = _read(number)
    except (DefinitionError, TypeError, ValueError, OverflowError, AttributeError):
        value = None
    if value is None:
        raise DefinitionError(
            f"system '{system.name}': the value of '{name}' is '{number}', which is not a real "
            "number of a size that can be written"
        )
    return value


def _read(number: Any) -> Exact | None:
    if isinstance(number, (str, Decimal)):
        return _read(exact_number(str(number), "a number"))
    if isinstance(number, Fraction):
        return number
    if isinstance(number, float):
        return Fraction(float(number)) if math.isfinite(number) else None
    if isinstance(number, (mp.mpf, sp.Float)):
        raw = mp.mp.make_mpf(number._mpf_)
        return raw if mp.isfinite(raw) else None
    if isinstance(number, sp.Lambda):
        return None
    if hasattr(number, "__index__") and not isinstance(number, sp.Basic):
        return Fraction(operator.index(number))
    value = as_expression(number)
    if isinstance(value, sp.Rational):
        return Fraction(int(value.p), int(value.q))
    if isinstance(value, sp.Float):
        return _read(value)
    if not isinstance(value, sp.Expr) or not value.is_number or _is_too_large(value):
        return None
    return value if value.is_real and value.is_finite else None


def _is_too_large(value: sp.Expr) -> bool:
    """Whether a power in it is beyond all sizes; what stands inside is looked at first."""
    for node in sp.postorder_traversal(value):
        if isinstance(node, sp.Pow | sp.exp):
            base, exponent = node.as_base_exp()
            size = abs(sp.log(sp.N(base, 5)) * sp.N(exponent, 5)) if base != 0 else 0
        elif isinstance(node, sp.sinh | sp.cosh):
            size = abs(sp.N(node.args[0], 5))
        else:
            continue
        if not size < LARGEST:
            return True
    return False


def _round(value: Exact) -> Any:
    """A number as ``mpf`` at the working precision of mpmath."""
    if isinstance(value, Fraction):
        return mp.mpf(value.numerator) / value.denominator
    if isinstance(value, mp.mpf):
        return +value
    return mp.mp.make_mpf(sp.N(value, mp.mp.dps + 5)._mpf_)


Vector = list[Any]


@dataclass(frozen=True)
class Elimination:
    """What Gauss-Jordan elimination of A x = b found.

    ``pivots`` are (row, column) pairs: these rows are independent.  ``leftover`` maps every other
    row to what remains of its right side, which is zero where the system is consistent.
    ``solution`` has zeros in the ``free`` columns; ``kernel`` has a vector for each free column.
    ``size`` is the largest right side; rows were divided by their largest coefficient.
    """

    pivots: tuple[tuple[int, int], ...]
    leftover: dict[int, Any]
    free: tuple[int, ...]
    solution: Vector
    kernel: tuple[Vector, ...]
    size: Any

    @property
    def independent(self) -> list[int]:
        """The rows that carry a pivot, in their order."""
        return sorted(row for row, _ in self.pivots)


def negligible() -> Any:
    """Where a pivot counts as zero: half the working digits, relative to its row."""
    return mp.mpf(10) ** (-mp.mp.dps // 2)


def eliminate(
    matrix: Sequence[Vector],
    right: Vector,
    width: int,
    first: int | None = None,
) -> Elimination:
    """Solve A x = b with the largest pivot of all, A having ``width`` columns.

    The ``first`` rows are used up before later ones are touched: so rows that hold exactly come
    before rows that hold to the accuracy of somebody's numbers.
    """
    rows = _scale_rows(matrix, right)
    count = len(rows)
    groups = [range(count)] if first is None else [range(first), range(first, count)]
    size = max((abs(row[-1]) for row in rows), default=mp.mpf(0))
    tiny = negligible()
    pivots: list[tuple[int, int]] = []
    columns = list(range(width))
    for group in groups:
        open_rows = list(group)
        while open_rows and columns:
            largest, r, c = max((abs(rows[r][c]), -r, -c) for r in open_rows for c in columns)
            if largest <= tiny:
                break
            r, c = -r, -c
            pivots.append((r, c))
            open_rows.remove(r)
            columns.remove(c)
            _clear(rows, r, c)
    solution = [mp.mpf(0)] * width
    kernel = [[mp.mpf(int(c == f)) for c in range(width)] for f in columns]
    for r, c in pivots:
        solution[c] = rows[r][-1]
        for vector, f in zip(kernel, columns, strict=True):
            vector[c] = -rows[r][f]
    used = {r for r, _ in pivots}
    leftover = {r: rows[r][-1] for r in range(count) if r not in used}
    return Elimination(tuple(pivots), leftover, tuple(columns), solution, tuple(kernel), size)


def _scale_rows(matrix: Sequence[Vector], right: Vector) -> list[Vector]:
    """Augmented rows, each divided by its largest coefficient unless all of them are noise."""
    sizes = [max(map(abs, row), default=mp.mpf(0)) for row in matrix]
    largest = max(sizes, default=mp.mpf(0)) or mp.mpf(1)
    floor = largest * negligible()
    scales = [size if size > floor else largest for size in sizes]
    return [
        [entry / scale for entry in (*row, b)]
        for row, b, scale in zip(matrix, right, scales, strict=True)
    ]


def _clear(rows: list[Vector], pivot_row: int, column: int) -> None:
    """Make the pivot 1 and everything else in its column 0."""
    pivot = rows[pivot_row][column]
    base = rows[pivot_row] = [entry / pivot if entry else entry for entry in rows[pivot_row]]
    filled = [j for j, entry in enumerate(base) if entry]
    for index, row in enumerate(rows):
        factor = row[column]
        if index == pivot_row or not factor:
            continue
        for j in filled:
            row[j] -= factor * base[j]
        row[column] = mp.mpf(0)
