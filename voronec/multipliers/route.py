"""Accelerations and reactions by multipliers, each digit confirmed at a higher precision."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import mpmath as mp
import sympy as sp

from voronec.arguments import POINT, accepts
from voronec.errors import DefinitionError
from voronec.multipliers.linear import Vector
from voronec.multipliers.plan import Plan, make_plan
from voronec.multipliers.point import Exact, read_point
from voronec.multipliers.solve import Solution, solve
from voronec.system import System, require_system

__all__ = ["Reactions", "multiplier_acceleration", "reaction_forces"]

GUARD = 25
"""Decimal digits computed beyond those asked for."""

DOUBLINGS = 5
"""How often the precision is doubled before an answer is given up."""

_plans: OrderedDict[int, tuple[System, Plan]] = OrderedDict()
_PLANS_KEPT = 32


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
    solution = _confirmed(require_system(system), point, digits)
    things = (*system.coordinates, *(system.directions if system.on_group else ()))
    return _labelled(things, solution.accelerations, digits)


@accepts(point=POINT)
def reaction_forces(system: System, point: Mapping[Any, Any], digits: int = 30) -> Reactions:
    """The multipliers and reaction forces at a point; see ``multiplier_acceleration``."""
    solution = _confirmed(require_system(system), point, digits)
    count = len(system.constraints)

    def unique(part: slice) -> tuple[sp.Float, ...] | None:
        if not all(solution.determined[part]):
            return None
        return tuple(sp.Float(x, digits) for x in solution.multipliers[part])

    return Reactions(
        multipliers=unique(slice(None, count)),
        relation_multipliers=unique(slice(count, None)),
        generalized=MappingProxyType(_labelled(system.directions, solution.reaction, digits)),
    )


def _labelled(things: tuple[sp.Expr, ...], numbers: Vector, digits: int) -> dict[sp.Expr, sp.Float]:
    return {x: sp.Float(number, digits) for x, number in zip(things, numbers, strict=True)}


def _confirmed(system: System, point: Mapping[Any, Any], digits: int) -> Solution:
    """A solution of which two precisions agree to the digits asked for."""
    if not isinstance(digits, int) or digits < 1:
        raise DefinitionError(f"digits = {digits!r} is not a positive whole number")
    try:
        plan = _plan(system)
    except DefinitionError as error:
        raise DefinitionError(f"system '{system.name}': {error}") from None
    values = read_point(system, point, plan.held)
    precision = digits + GUARD
    before = _attempt(plan, values, precision)
    for _ in range(DOUBLINGS):
        precision *= 2
        after = _attempt(plan, values, precision)
        if isinstance(before, DefinitionError) and isinstance(after, DefinitionError):
            raise DefinitionError(f"system '{system.name}': {after}")
        if isinstance(before, Solution) and isinstance(after, Solution):
            settled = _agreed(before, after, digits, precision // 2)
            if settled is not None:
                return settled
        before = after
    raise DefinitionError(
        f"system '{system.name}': {digits} digits could not be confirmed with {precision} at this "
        "point; the equations are singular nearby, so choose another point"
    )


def _attempt(plan: Plan, values: Mapping[str, Exact], precision: int) -> Solution | DefinitionError:
    """A failure at one precision is a value too: more digits may tell two ranks apart."""
    with mp.workdps(precision):
        try:
            return solve(plan, values)
        except DefinitionError as error:
            return error


def _agreed(before: Solution, after: Solution, digits: int, lower: int) -> Solution | None:
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
    return Solution(settled[:n], settled[n:end], settled[end:], after.determined)


def _plan(system: System) -> Plan:
    """The plan of a system, made once; kept with the system, so that its id stays its own."""
    kept = _plans.get(id(system))
    if kept is None:
        kept = _plans[id(system)] = (system, make_plan(system))
        if len(_plans) > _PLANS_KEPT:
            _plans.popitem(last=False)
    return kept[1]
