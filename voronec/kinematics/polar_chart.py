"""The chart of polar coordinates in which they are Cartesian ones.

Polar coordinates (r, phi) are singular on their axis, r = 0.  With x = r cos phi, y = r sin phi

    r' = (x x' + y y')/r,    phi' = (x y' - y x')/r^2,

and what a system declares is regular in x and y where the system is so on the axis.  Its
constraints may be written along the lines of r and phi, and have no limit there; solved for other
velocities they have one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.arguments import POINT, SEQUENCE, instance, require
from voronec.algebra.matrices import determinant
from voronec.algebra.normal import shorten, shortest
from voronec.algebra.symbols import names_in, plain_name, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.declaration.charts import Chart
from voronec.declaration.geometry import Frame
from voronec.declaration.reading import expression
from voronec.errors import DefinitionError
from voronec.kinematics.rotations import distinct_names


def cartesian_chart(
    polar: Sequence[Any],
    lagrangian: Any,
    constraints: Sequence[Any] = (),
    frame: Frame | None = None,
    unit: Any = 1,
    near: Mapping[Any, Any] | None = None,
) -> Chart:
    """The chart of a system that is regular where its polar coordinates are not, at r = 0.

    polar
        (r, phi), two symbols: the distance from the axis, not negative, and the angle about it.
        In the chart they mean x = r cos phi and y = r sin phi.
    lagrangian, constraints, frame
        what the system declares.  Where a velocity of the frame is r' it is x' in the chart, and
        phi' is y'; the others keep their values.
    unit
        a length: the chart is used where r is far below it.
    near
        values of the other coordinates for which all is regular on the axis, zero unless told.

    ``DefinitionError`` where something is singular on the axis in x and y, too, or holds phi
    otherwise than by the sine and the cosine of whole multiples: it is not known in x and y then.
    """
    require("cartesian_chart", "polar", polar, SEQUENCE)
    require("cartesian_chart", "constraints", constraints, SEQUENCE)
    if frame is not None:
        require("cartesian_chart", "frame", frame, instance(Frame))
    if near is not None:
        require("cartesian_chart", "near", near, POINT)
    r, phi = distinct_names(tuple(polar), 2, "the polar coordinates")
    moved = _ChartImage(r, phi)
    there, back, sheet = _maps(r, phi, frame)
    changes: dict[str, Any] = {"lagrangian": moved.regular(lagrangian, "the Lagrangian")}
    if constraints:
        changes["constraints"] = moved.solve([expression(c, "a constraint") for c in constraints])
    if frame is not None:
        changes["frame"] = moved.frame(frame)
    length = expression(unit, "unit")
    return Chart(
        state=there, singular=r / length, changes=changes, back=back, singular_there=sp.Integer(1),
        double_cover=(sheet,), near={**(near or {}), r: 0, phi: 0},
    )  # fmt: skip


class _ChartImage:
    """Functions of polar coordinates and velocities in the chart, where r means x and phi y."""

    def __init__(self, r: sp.Expr, phi: sp.Expr) -> None:
        self.r, self.phi = r, phi
        self.dots = velocity(r), velocity(phi)
        self.across = sp.sqrt(r**2 + phi**2)
        dr, dphi = self.dots
        self._angle = {sp.cos(phi): r / self.across, sp.sin(phi): phi / self.across}
        self._values = {
            dr: (r * dr + phi * dphi) / self.across,
            dphi: (r * dphi - phi * dr) / self.across**2,
            r: self.across,
        }

    def regular(self, given: Any, what: str) -> sp.Expr:
        """A declared function in the chart; ``DefinitionError`` where it has no value at r = 0."""
        (image,) = shorten([self._of(expression(given, what))])
        if not self._is_regular(image):
            raise DefinitionError(f"{what} is singular where {self.r} = 0, in x and y as well")
        return image

    def _of(self, expr: sp.Expr) -> sp.Expr:
        opened = sp.expand_trig(expr)
        if self.phi in opened.xreplace({e: sp.Dummy() for e in self._angle}).free_symbols:
            raise DefinitionError(
                f"'{expr}' holds {self.phi} otherwise than by sine and cosine of whole multiples, "
                "and x and y do not tell its turns; such a system has no chart on the axis"
            )
        return opened.xreplace({**self._angle, **self._values})

    def _is_regular(self, expr: sp.Expr) -> bool:
        axis = {self.r: sp.Integer(0), self.phi: sp.Integer(0)}
        # r itself, and its odd powers, have an edge or a jump in a slope there
        roots = (e.base for e in expr.atoms(sp.Pow) if not e.exp.is_integer)
        if any(root.xreplace(axis) == 0 for root in roots):
            return False
        # where a denominator vanishes, SymPy's value is infinite or none
        return not expr.xreplace(axis).has(sp.zoo, sp.nan, sp.oo)

    def solve(self, constraints: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
        """The constraints solved for velocities for which the solution is regular on the axis."""
        rows, bridge = [self._of(c) for c in constraints], SymPyBridge()
        inside = bridge.inward_all(rows)
        axis = dict.fromkeys(bridge.inward_all((self.r, self.phi)), 0)
        for chosen in self._pivots(rows):
            names = bridge.inward_all(chosen)
            matrix = [[row.diff(x) for x in names] for row in inside]
            rest = [row.xreplace(dict.fromkeys(names, 0)) for row in inside]
            # by Cramer's rule
            swapped = [_with_column(matrix, j, rest) for j in range(len(names))]
            below, *above = shortest([determinant(m) for m in (matrix, *swapped)])
            ends = [e.xreplace(axis) for e in (below, *above)]
            if below == 0 or (ends[0] == 0 and any(e not in (0, se.nan) for e in ends[1:])):
                continue  # the solution is infinite there
            solution = [bridge.outward(e) for e in shortest([x / below for x in above])]
            if all(map(self._is_regular, solution)):
                return tuple(v + x for v, x in zip(chosen, solution, strict=True))
        raise DefinitionError(
            f"the constraints are singular where {self.r} = 0, in x and y as well"
        )

    def _pivots(self, rows: Sequence[sp.Expr]) -> Iterator[tuple[sp.Expr, ...]]:
        """Sets of as many velocities as there are constraints, but those of r and phi."""
        held = sorted(set().union(*map(names_in, rows)) - {*self.dots}, key=plain_name)
        dots = [x for x in held if plain_name(x).endswith("dot")]
        yield from combinations(dots, len(rows))

    def frame(self, frame: Frame) -> Frame:
        """The frame in the chart."""
        pairs = zip(frame.velocities, frame.expressions, strict=True)
        return Frame.quasi(
            {v: e if e in self.dots else self.regular(e, f"the velocity '{v}'") for v, e in pairs}
        )


def _with_column(rows: Sequence[Sequence[Any]], j: int, column: Sequence[Any]) -> list[list[Any]]:
    """A matrix with another column in the place of one."""
    return [[*row[:j], x, *row[j + 1 :]] for row, x in zip(rows, column, strict=True)]


def _maps(r: sp.Expr, phi: sp.Expr, frame: Frame | None) -> tuple[dict[Any, Any], ...]:
    """The state in the chart, that of the system, and the sheet with r on the other side."""
    cos, sin, square = sp.cos(phi), sp.sin(phi), r**2 + phi**2
    there = {r: r * cos, phi: r * sin}
    back = {r: sp.sqrt(square), phi: sp.atan2(phi, r)}
    sheet = {r: -r, phi: phi + sp.pi}
    named = {} if frame is None else dict(zip(frame.expressions, frame.velocities, strict=True))
    v, w = (named.get(velocity(q)) for q in (r, phi))
    if (v is None) != (w is None):
        raise DefinitionError(
            f"the frame has one of the velocities of {r} and {phi}; give both, or neither"
        )
    if v is not None:
        there |= {v: v * cos - r * w * sin, w: v * sin + r * w * cos}
        back |= {v: (r * v + phi * w) / sp.sqrt(square), w: (r * w - phi * v) / square}
        sheet[v] = -v
    return there, back, sheet
