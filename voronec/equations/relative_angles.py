"""Angles that occur in their differences alone, and the tree of differences that is shortest.

The equations of vehicles in a row on a plane do not change when all headings are turned by the same
amount.  Then mass, force and the rates of the headings are functions of differences of headings: of
each heading and the one before it in a row, or the first where all hang on one.  In products of
sines and cosines of the headings themselves they have exponentially many terms, in those of the
differences as many as are printed.

    a = N (differences, first angle),    N of whole numbers and det N = 1 or -1,

so that sines and cosines of the differences are as independent as those of the angles, and what is
proved in them is proved.  Which angles turn together is seen in numbers: a choice of variables
needs no proof.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
import symengine as se

from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.tape import Tape
from voronec.algebra.terms import atoms

STEP = flint.fmpq(1, 2**40)
"""How far angles are moved for difference quotients, which are right to as many bits."""
ZERO = 2.0**-25
"""Slopes below this, relative to the largest, count as zero."""


@dataclass(frozen=True)
class RelativeAngles:
    """``meaning`` has each difference of angles by its letter, which is called by it; ``values``
    each angle but the first in terms of the first and of the letters."""

    meaning: Mapping[Any, Any]
    values: Mapping[Any, Any]

    @classmethod
    def of(cls, form: Any) -> RelativeAngles | None:
        """The differences in which the equations of a ``FirstOrderForm`` stand; None where there
        are none."""
        held = {*form.coordinates}
        exprs = [*form.force, *(e for row in form.mass for e in row), *form.rates]
        turned = [node.args[0].free_symbols & held for node in atoms(exprs, se.sin, se.cos)]
        angles = [q for q in form.coordinates if any(q in among for among in turned)]
        if form.relations or form.stages or len(angles) < 2:
            return None
        rates = [r for q, r in zip(form.coordinates, form.rates, strict=True) if q in angles]
        slopes = _slopes([*rates, *form.force, *(e for row in form.mass for e in row)], angles)
        if slopes is None:
            return None
        together = _turning_together(slopes)
        holds = slopes[: len(angles)] != 0
        order = sorted(together, key=lambda k: int(holds[k][together].sum()))
        return cls.along(
            {angles[k]: angles[_before(order[:i], holds[k])] for i, k in enumerate(order) if i}
        )

    @classmethod
    def along(cls, before: Mapping[Any, Any]) -> RelativeAngles | None:
        """The differences of angles to those ``before`` them.  The angle that stays is in their
        middle: the sine of another has two terms to the power of the differences between."""
        near = dict[Any, list[Any]]()
        for angle, other in before.items():
            near.setdefault(other, []).append(angle)
            near.setdefault(angle, []).append(other)
        ways = [_outward(near, angle) for angle in near]
        meaning, values = dict[Any, Any](), dict[Any, Any]()
        shortest: Mapping[Any, Any] = min(ways, key=_depth, default={})
        for angle, (other, _) in shortest.items():
            sign = 1 if str(other) < str(angle) else -1
            difference = sign * other - sign * angle
            letter = se.Symbol(str(difference))
            meaning[letter] = difference
            values[angle] = values.get(other, other) - sign * letter
        return cls(meaning, values) if values else None

    def hide(self, expr: Any) -> Any:
        """An expression in the differences."""
        return turn(expr, self.values)

    def show(self, expr: Any) -> Any:
        """An expression in the angles again."""
        return turn(expr, self.meaning)


def turn(expr: Any, values: Mapping[Any, Any]) -> Any:
    """An expression with sums in the place of angles, multiplied out in sines and cosines."""
    turned = {
        node: node.func(se.expand(node.args[0].xreplace(dict(values))))
        for node in atoms([expr], se.sin, se.cos)
        if not node.free_symbols.isdisjoint(values)
    }
    return expr.xreplace(turned).xreplace(dict(values))


def _slopes(exprs: Sequence[Any], angles: Sequence[Any]) -> np.ndarray | None:
    """The derivatives of expressions by angles at a point, a matrix, relative to the largest of an
    expression; None where there is no point."""
    tape = Tape(exprs)
    for point, values in sample_evaluable(tape, bits=GENERIC, count=1):
        moved = [tape.arb({**point, a: point[a] + STEP} if a in point else point, GENERIC)
                 for a in angles]  # fmt: skip
        table = np.array([[float((y - x) / STEP) for x, y in zip(values, column, strict=True)]
                          for column in moved]).T  # fmt: skip
        largest = np.abs(table).max(axis=1, keepdims=True)
        table = table / np.where(largest > ZERO, largest, np.inf)
        return np.where(np.abs(table) > ZERO, table, 0.0)
    return None


def _turning_together(slopes: np.ndarray) -> list[int]:
    """The positions of the angles that nothing changes with when they are moved by one amount."""
    moving = np.flatnonzero(slopes.any(axis=0))
    if len(moving) < 2:
        return []
    _, sizes, rows = np.linalg.svd(slopes[:, moving])
    still = [row for row, size in zip(rows, [*sizes, *[0.0] * len(moving)], strict=False)
             if size < ZERO * sizes[0]]  # fmt: skip
    if len(still) != 1:
        return []
    shift = still[0] / max(still[0], key=abs)
    shift = np.where(np.abs(shift) > ZERO, shift, 0.0)
    held = shift != 0
    return [*map(int, moving[held])] if np.allclose(shift[held], 1, atol=ZERO) else []


def _before(earlier: Sequence[int], holds: np.ndarray) -> int:
    """Of the angles that are placed, the last that the rate of an angle holds, else the first."""
    return next((k for k in reversed(earlier) if holds[k]), earlier[0])


def _outward(near: Mapping[Any, Sequence[Any]], first: Any) -> dict[Any, tuple[Any, int]]:
    """Each angle of a tree but the first, with the one on the way from it and the length of the
    way, in an order in which that one comes earlier."""
    links, waiting = dict[Any, tuple[Any, int]](), [(first, None, 0)]
    for angle, other, depth in waiting:
        if depth:
            links[angle] = other, depth
        waiting += [(q, angle, depth + 1) for q in near[angle] if q != other]
    return links


def _depth(way: Mapping[Any, tuple[Any, int]]) -> int:
    return max(depth for _, depth in way.values())
