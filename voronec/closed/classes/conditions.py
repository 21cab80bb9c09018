"""What a start must meet for a class, solved exactly for velocities that occur linearly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import sympy as sp

from voronec.algebra.door import Door
from voronec.algebra.normal import canonical
from voronec.closed.classes.curve import Curve, Declared
from voronec.closed.classes.tally import remainder

__all__ = ["NEEDED", "Conditions", "conditions", "solutions"]

NEEDED = {"B": 1, "C": 2, "C1": 2, "C2": 2, "D1": 1, "D2": 1, "D3": 2, "E1+E2": 2, "A|C": 2}
"""Roots that phi must have."""


@dataclass(frozen=True, eq=False)
class Conditions:
    """``vanishing``, then ``further``: functions of the start that must be zero.

    ``elsewhere``: they hold where the trace passes the pole; the start is to be another point.
    """

    vanishing: tuple[Any, ...]
    further: tuple[Any, ...] = ()
    elsewhere: bool = False


@cache
def conditions(known: Declared, curve: Curve, label: str) -> Conditions:
    """What makes a motion start at a parallel, with cusps or poles as its class says."""
    parts = set(label.split("+"))
    wanted = [known.rate]
    if parts & {"D1", "D2", "D3"}:
        wanted.append(known.started(curve.above_at(known.motion.x)))
    further = ()
    if "D3" in parts:
        further = tuple(known.started(e) for e in remainder(known.quartic, curve.above))
    elsewhere = False
    for side, name in ((1, "E1"), (-1, "E2")):
        if name in parts:
            offset, slope = curve.cosine
            at_pole = known.started(curve.above_at((side - offset) / slope))
            if _rational(at_pole):
                wanted.append(at_pole)
            else:
                wanted.append(known.started(1 - (offset + slope * known.motion.x) ** 2))
                elsewhere = True
    return Conditions(tuple(map(_short, wanted)), further, elsewhere)


def _rational(value: Any) -> bool:
    """Whether no root of anything occurs."""
    return all(p.exp.is_Integer for p in value.atoms(sp.Pow))


def _short(value: Any) -> Any:
    """The numerator in normal form."""
    door = Door()
    found = door.outward(canonical([door.inward(value)], ())[0])
    return sp.fraction(sp.together(found))[0]


def solutions(
    wanted: Conditions, known: Mapping[Any, Any], velocities: Sequence[Any]
) -> Iterator[dict[Any, Any]]:
    """Exact velocities that meet conditions, one after the other; those left free are not there.

    ``known`` gives parameters and coordinates.  A factor that is linear in a velocity gives it; the
    conditions left are solved with it.
    """
    given = dict(known)
    first = [sp.expand(c.xreplace(given)) for c in wanted.vanishing]
    for found in _solved(first, {}, velocities):
        # long formulas wait until numbers have made them short
        rest = [e.xreplace({**given, **found}) for e in wanted.further]
        rest = [sp.fraction(sp.together(sp.expand(e)))[0] for e in rest]
        yield from _solved(rest, found, velocities)


def _solved(
    left: list[Any], found: dict[Any, Any], velocities: Sequence[Any]
) -> Iterator[dict[Any, Any]]:
    left = [c for c in left if c != 0]
    if not left:
        yield found
        return
    if any(not c.has(*velocities) for c in left):
        return
    first = min(left, key=lambda c: (len(c.free_symbols), sp.count_ops(c)))
    for factor, _ in sp.factor_list(first)[1]:
        for velocity in velocities:
            if not factor.has(velocity) or sp.degree(factor, velocity) != 1:
                continue
            slope = factor.coeff(velocity, 1)
            if slope.has(*velocities):
                continue
            value = sp.expand(-factor.coeff(velocity, 0) / slope)
            rest = [sp.expand(c.xreplace({velocity: value})) for c in left if c is not first]
            later = {v: sp.expand(e.xreplace({velocity: value})) for v, e in found.items()}
            yield from _solved(rest, {**later, velocity: value}, velocities)
            break
