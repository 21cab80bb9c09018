"""Families of steady motions over a quantity: folds, branch points, critical values.

Where a motion belongs to a family of d dimensions, d - 1 variables are held, so that a curve is
left, which ``continuation`` follows.  At a fold the quantity turns back; at a branch point the
Jacobian loses one more rank, where the determinant of its regular rows and the tangent changes its
sign.  A critical value is where the number of eigenvalues right of the imaginary axis changes.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import flint
import mpmath as mp
import numpy as np

from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name
from voronec.declaration.reading import several
from voronec.declaration.system import System
from voronec.dynamics.continuation import COMPLETE, follow, root_between
from voronec.dynamics.newton import null_space, pivots, polish, solve, solve_across
from voronec.dynamics.spectrum import (
    Deflation,
    characteristic,
    conditions_in_doubles,
    discriminant,
    has_opposites,
    hurwitz,
    to_mpf,
    unstable_count,
)
from voronec.dynamics.steady_equations import SteadyEquations, check_parameters, read_quantity
from voronec.errors import DefinitionError, IntegrationError
from voronec.motion.request import number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST = 0.25
"""A step goes no further than this, in the units of the variables."""
TIMES = 20
"""A family has at most so many times the points that were asked for."""
CRITICAL_BITS = 200
"""Bits of the balls in which critical values are computed: 60 digits, of which a determinant may
lose half."""
FLAT = 1e-4
"""Where the quantity changes by less than this along the curve, in the units, there is a fold."""
ROUNDING = 1e-9
"""Conditions below this share of what they are at the next point are zero but for rounding."""
ZERO = 1e-12
"""Variables below this, in their units, are zero but for rounding."""
MOST_SECANTS = 8
"""The most steps of the secant method: from eight digits three steps lead to thirty."""
WAYS = {
    "real": "a real eigenvalue passes through zero",
    "pair": "a pair crosses the imaginary axis",
    "meeting": "two pairs meet on the imaginary axis",
}


@dataclass(frozen=True)
class Critical:
    """Where the number of eigenvalues on the right changes: the ``value`` of the quantity, to the
    digits of ``exact``, in which way, a word of ``WAYS``, and the numbers ``below`` and ``above``
    it, along the family."""

    value: float
    exact: mp.mpf
    way: str
    below: int
    above: int

    def __str__(self) -> str:
        return f"{mp.nstr(self.exact, 15)}: {WAYS[self.way]}, {self.below} -> {self.above} unstable"


@dataclass(frozen=True, eq=False)
class StabilityRange:
    """A part of a family, from one value of its quantity to another, all along which as many
    eigenvalues lie on the right; a ``motion`` in its middle has the ``verdict``."""

    begin: float
    end: float
    unstable: int
    motion: Any

    def __str__(self) -> str:
        return f"{self.begin:.6g} to {self.end:.6g}: {self.motion.verdict}"


@dataclass(frozen=True, eq=False, repr=False)
class SteadyFamily:
    """A family of steady motions along which the quantity ``over`` changes, and those ``held`` are
    constant.

    ``motion`` is the one from which it was followed.  ``values`` (k,) are those of the quantity,
    ``points`` (k, n) those of the variables ``names``, in the order of the curve; ``folds`` and
    ``branch_points`` are values of the quantity.  ``ends`` says why the curve ends on either side:
    ``complete`` where it has come to the end of the span.
    """

    motion: Any
    over: str
    held: tuple[str, ...]
    curve: SolutionCurve = field(repr=False)
    points: np.ndarray
    values: np.ndarray
    ends: tuple[str, str]
    memo: Memo = field(default_factory=Memo, init=False, repr=False)

    @property
    def system(self) -> System:
        """The system."""
        return self.motion.system

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the variables, one for each column of ``points``."""
        return self.curve.equations.names

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: Any) -> np.ndarray:
        name = plain_name(name)
        if name == self.over:
            return self.values
        if name not in self.names:
            raise DefinitionError(
                f"the family holds no '{name}'; name one of {', '.join(self.names)}"
            )
        column: np.ndarray = self.points[:, self.names.index(name)]
        return column

    def __repr__(self) -> str:
        span = f"{self.values.min():.6g} to {self.values.max():.6g}"
        return f"SteadyFamily({self.system.name!r}, {self.over} from {span}, {len(self)} motions)"

    @cached_property
    def matrices(self) -> np.ndarray:
        """The matrices A (k, n, n) of dx' = A dx."""
        return np.array([self.curve.equations.matrix(y) for y in self.points])

    @cached_property
    def deflation(self) -> Deflation:
        """The eigenvalues that vanish along the whole family: the fewest that vanish at a point."""
        return Deflation.of_family([*self.matrices])

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """The eigenvalues (k, m) of each motion, without those that vanish along the whole family,
        by real part, then imaginary part."""
        return np.array([self.deflation.eigenvalues(matrix) for matrix in self.matrices])

    @cached_property
    def unstable(self) -> np.ndarray:
        """How many eigenvalues (k,) of each motion lie right of the imaginary axis."""
        return np.array([unstable_count(row) for row in self.eigenvalues])

    @cached_property
    def folds(self) -> tuple[float, ...]:
        """The values at which the quantity turns back."""
        curve = self.curve
        return tuple(
            self._values_at_roots(lambda y, before, ahead: curve.slope(y) @ curve.tangent(y, ahead))
        )

    @cached_property
    def branch_points(self) -> tuple[float, ...]:
        """The values at which other families branch off."""
        return tuple(self._values_at_roots(self.curve.regularity))

    @cached_property
    def logarithmic_poles(self) -> tuple[float, ...]:
        """About where the curve passes over points at which a logarithm has no value."""
        arguments = self.curve.equations.logarithms
        poles = set[float]()
        for (a, b), (x, y) in zip(pairwise(self.points), pairwise(self.values), strict=True):
            low, high = arguments.at(a)[0], arguments.at(b)[0]
            passed = low * high < 0
            poles |= {*(x + (y - x) * low[passed] / (low - high)[passed]).tolist()}
        return tuple(map(self._without_rounding, sorted(poles)))

    def _values_at_roots(self, measure: Callable[..., float]) -> Iterator[float]:
        """The values at which a function of a point, the point before it and the direction between
        these vanishes."""
        for a, b in pairwise(self.points):
            y = root_between(self.curve, a, b, partial(measure, before=a, ahead=b - a))
            if y is not None:
                yield self._without_rounding(self.curve.value(y))

    def _without_rounding(self, value: Any) -> Any:
        """A value of the quantity, which is zero where it is one but for rounding."""
        return value if abs(value) > 1e-14 * float(np.ptp(self.values)) else abs(0 * value)

    @cached_property
    def critical(self) -> tuple[Critical, ...]:
        """The critical values of the quantity, in the order of the curve, to 30 digits."""
        return tuple(c for c in self._changes.values() if c is not None)

    @cached_property
    def ranges(self) -> tuple[StabilityRange, ...]:
        """The parts of the curve between changes of ``unstable``, in its order, each with the
        verdict on a motion in its middle."""
        edges = [0, *(k + 1 for k in self._changes), len(self)]
        ends = [self.values[0], *(c and c.value for c in self._changes.values()), self.values[-1]]
        parts = []
        for (i, j), (begin, end) in zip(pairwise(edges), pairwise(ends), strict=True):
            begin, end = (float(self.values[k]) if x is None else float(x)
                          for x, k in ((begin, i), (end, j - 1)))  # fmt: skip
            middle = (i + j) // 2
            motion = self._motion_at(float(self.values[middle]), self.points[middle])
            parts.append(StabilityRange(begin, end, int(self.unstable[middle]), motion))
        return tuple(parts)

    @cached_property
    def _changes(self) -> dict[int, Critical | None]:
        """Behind which points the number of eigenvalues on the right changes, and the critical
        value there, where it is located."""
        changes = dict[int, Critical | None]()
        for k in map(int, np.flatnonzero(np.diff(self.unstable))):
            # a point may lie on the critical value itself: then its neighbours tell
            ends = ((i, j) for i, j in ((k, k + 1), (k - 1, k + 1), (k, k + 2))
                    if i >= 0 and j < len(self))  # fmt: skip
            tries = (self._critical(k, self.points[[i, j]]) for i, j in ends)
            changes[k] = next((c for c in tries if c is not None), None)
        return changes

    def _critical(self, k: int, between: np.ndarray) -> Critical | None:
        """The critical value between the points k and k + 1, looked for between two of the curve
        (2, n); None where no condition changes its sign."""
        a, b = between
        below, above = int(self.unstable[k]), int(self.unstable[k + 1])
        ends = self._conditions(a), self._conditions(b)
        for way in ends[0]:
            low, high = sorted((ends[0][way], ends[1][way]))
            if not low < 0 < high or min(-low, high) < ROUNDING * max(-low, high):
                continue  # a zero on one of the points has the sign of its rounding
            if ((below - above) % 2 == 1) != (way == "real"):
                continue
            y = root_between(self.curve, a, b, partial(self._condition, way))
            if y is not None:
                exact = self._without_rounding(self._in_digits(way, y, a, b))
                return Critical(float(exact), exact, way, below, above)
        return None

    def _conditions(self, y: np.ndarray) -> dict[str, float]:
        """What changes its sign at critical values, at a point of the curve."""
        matrix = self.deflation.remainder(self.curve.equations.matrix(y))
        return conditions_in_doubles(matrix, self.has_opposites)

    def _condition(self, way: str, y: np.ndarray) -> float:
        return self._conditions(y)[way]

    @cached_property
    def has_opposites(self) -> bool:
        """Whether all along with each eigenvalue its negative is one."""
        return all(has_opposites(self.deflation.remainder(matrix)) for matrix in self.matrices)

    def _in_digits(self, way: str, near: np.ndarray, a: np.ndarray, b: np.ndarray) -> mp.mpf:
        """Where a condition vanishes, by secants from what doubles tell; at a fold, where the
        quantity is no coordinate of the curve, it is as exact as doubles are."""
        rough, along = self.curve.value(near), self.curve.tangent(near, b - a)
        rate = abs(float(self.curve.slope(near) @ along))
        if rate < FLAT * float(np.abs(self.curve.slope(near) * self.curve.units).max()):
            return mp.mpf(rough)
        width = 1e-7 * abs(self.curve.value(b) - self.curve.value(a))
        with mp.workprec(CRITICAL_BITS), flint.ctx.workprec(CRITICAL_BITS):
            x = [mp.mpf(rough) - width, mp.mpf(rough)]
            values = [self._exact_condition(way, value, near) for value in x]
            for _ in range(MOST_SECANTS):
                if values[-1] in (0, values[-2]):
                    break
                step = values[-1] * (x[-1] - x[-2]) / (values[-1] - values[-2])
                x.append(x[-1] - step)
                if abs(step) < mp.mpf(10) ** -28 * max(abs(x[-1]), 1):
                    break
                values.append(self._exact_condition(way, x[-1], near))
            return x[-1]

    def _exact_condition(self, way: str, value: mp.mpf, near: np.ndarray) -> mp.mpf:
        motion = self._motion_at(value, near)
        exact = polish(motion.equations, motion.y, CRITICAL_BITS)
        slopes = motion.equations.slopes_in_balls(exact, CRITICAL_BITS)
        coefficients = characteristic(slopes, motion.equations.size, self.deflation.zeros)
        coefficients = [c.mid() for c in coefficients]
        if way == "real":
            return to_mpf(coefficients[0])
        return to_mpf(hurwitz(coefficients) if way == "pair" else discriminant(coefficients[::2]))

    def at(self, value: Any) -> Any:
        """The motion with a value of the quantity, on the curve nearest to its beginning."""
        x = number(value, f"the value of '{self.over}'")
        inside = (self.values[:-1] - x) * (self.values[1:] - x) <= 0
        if not inside.any():
            raise DefinitionError(
                f"the family has no motion with {self.over} = {x:g}; give a value between "
                f"{self.values.min():g} and {self.values.max():g}"
            )
        return self._motion_at(value, self.points[int(np.flatnonzero(inside)[0])])

    def _motion_at(self, value: Any, near: np.ndarray) -> Any:
        """The motion with a value of the quantity, near a point of the curve."""
        curve = self.curve.with_value(value)
        y = solve(curve.function, near, curve.units)
        if y is None:
            raise IntegrationError(
                f"the family is lost at {self.over} = {float(value):g}", float(value), near
            )
        y = np.where(np.abs(y) < ZERO * curve.units, 0.0, y)
        return replace(self.motion, equations=curve.equations, y=y, units=curve.units)

    def plot(self) -> Figure:
        """The family over its quantity, with stability in colours, and its eigenvalues."""
        from voronec.dynamics.pictures import family_figure

        return family_figure(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the family to ``path``, as ``Trajectory.save`` does: a row for each motion."""
        from voronec.motion.storage import NamedArrays

        columns = {self.over: self.values, **dict(zip(self.names, self.points.T, strict=True))}
        columns["unstable eigenvalues"] = self.unstable
        rows = {name: (("motion",), values) for name, values in columns.items()}
        return NamedArrays.of(self.system, "SteadyFamily", rows, ("motion",), (*columns,)).save(
            path
        )

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "system": self.system.name, "over": self.over, "held": list(self.held),
            "names": list(self.names), "values": self.values.tolist(),
            "points": self.points.tolist(), "unstable": self.unstable.tolist(),
            "eigenvalues": [[[e.real, e.imag] for e in row] for row in self.eigenvalues],
            "folds": list(self.folds), "branch_points": list(self.branch_points),
            "critical": [
                {"value": c.value, "digits": mp.nstr(c.exact, 30), "way": WAYS[c.way],
                 "below": c.below, "above": c.above}
                for c in self.critical
            ],
            "ranges": [
                {"begin": r.begin, "end": r.end, "unstable": r.unstable,
                 "stability": str(r.motion.verdict)}
                for r in self.ranges
            ],
            "ends": list(self.ends), "logarithmic_poles": list(self.logarithmic_poles),
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class SolutionCurve:
    """A curve of solutions: ``equations``, the last of whose held expressions is the quantity over
    which it goes; ``is_point`` where that is held, too."""

    equations: SteadyEquations
    units: np.ndarray
    is_point: bool = False

    def function(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F and its Jacobian, without the quantity but where it is held."""
        value, slopes = self.equations.at(y)
        return (value, slopes) if self.is_point else (value[:-1], slopes[:-1])

    def value(self, y: np.ndarray) -> float:
        """The quantity."""
        return float(self.equations.at(y)[0][-1])

    def slope(self, y: np.ndarray) -> np.ndarray:
        """Its gradient (n,)."""
        gradient: np.ndarray = self.equations.at(y)[1][-1]
        return gradient

    def tangent(self, y: np.ndarray, ahead: np.ndarray) -> np.ndarray:
        """The tangent (n,) on the side of ``ahead``, of length one in the units."""
        t: np.ndarray = null_space(self.function(y)[1], self.units, 1)[:, 0]
        return t if (t / self.units) @ (ahead / self.units) >= 0 else -t

    def regularity(self, y: np.ndarray, before: np.ndarray, ahead: np.ndarray) -> float:
        """The determinant of the rows that are regular at the point before, and the tangent on the
        side of ``ahead``."""
        left, sizes, _ = np.linalg.svd(self.function(before)[1] * self.units)
        rows = left[:, : len(y) - 1].T @ (self.function(y)[1] * self.units)
        matrix = np.vstack([rows / sizes[: len(rows), None], self.tangent(y, ahead) / self.units])
        return float(np.linalg.det(matrix))

    def onto(self, y: np.ndarray, across: np.ndarray) -> np.ndarray | None:
        """The point of the curve in the plane through y across a direction."""
        return solve_across(self.function, y, across, self.units)

    def with_value(self, value: Any) -> SolutionCurve:
        """The point of the curve at which the quantity has a value, as the equations for it."""
        name, expr = self.equations.held[-1]
        return SolutionCurve(self.equations.fix({name: (expr, value)}), self.units, True)

    def at_value(self, value: Any, near: np.ndarray) -> np.ndarray | None:
        """The point with a value of the quantity, near a point."""
        return solve(self.with_value(value).function, near, self.units)


def steady_family(
    motion: Any, over: Any, between: Sequence[Any], hold: Any, count: int
) -> SteadyFamily:
    """The family of a motion over a quantity, as ``SteadyMotion.along`` has it."""
    if not isinstance(between, Sequence) or isinstance(between, str) or len(between) != 2:
        raise DefinitionError("between: give the two ends of the span, such as between=(0, 10)")
    low, high = sorted(number(x, "between") for x in between)
    if not low < high or count < 2:
        raise DefinitionError("between: give two different values, and a count of two or more")
    given = curve_of(motion, over, several(hold, "hold", "name"))
    curve, start, held = given.curve, given.begin, given.held
    name = curve.equations.held[-1][0]
    check_parameters(motion.system, (name, low), (name, high))
    begin = curve.value(start)
    if not low <= begin <= high:
        start = _towards(curve, start, begin, low if begin < low else high, name)
    step = (high - low) / count
    (back, first), (on, last) = (
        follow(curve, start, sign, (low, high), step, TIMES * count, LONGEST)
        for sign in (-1.0, 1.0)
    )
    points = np.array([*reversed(back), start, *on])
    values = np.array([curve.value(y) for y in points])
    return SteadyFamily(motion, name, held, curve, points, values, (first, last))


@dataclass(frozen=True, eq=False)
class CurveStart:
    """A curve, its first point, and what is held on it."""

    curve: SolutionCurve
    begin: np.ndarray
    held: tuple[str, ...]


def curve_of(
    motion: Any, over: Any, hold: Sequence[Any], besides: Sequence[Any] = ()
) -> CurveStart:
    """The curve of a motion over a quantity; ``besides`` are held at its values, as those of
    ``hold``, constants too."""
    equations, y, units = motion.equations, motion.y, motion.units
    for key in (over, *besides):
        name = plain_name(key)
        if name in equations.constants and name not in equations.names:
            value = number(equations.values[name], f"parameter '{name}'")
            equations = equations.with_unknowns([name])
            y, units = np.append(y, value), np.append(units, abs(value) or 1.0)
    name, expr = read_quantity(equations, motion.motions, over)
    equations = equations.only_leaves(but=(name,))
    held = dict[str, tuple[Any, Any]]()
    for key in (*hold, *besides):
        label, e = read_quantity(equations, motion.motions, key)
        held[label] = (e, float(equations.fix({label: (e, 0)}).at(y)[0][-1]))
    equations = equations.fix(held)
    curve = SolutionCurve(equations.fix({name: (expr, 0)}), units)
    space = null_space(curve.function(y)[1], units)
    slope = curve.slope(y)
    if np.abs(slope @ space).max(initial=0.0) < 1e-9 * np.abs(slope * units).max(initial=1e-300):
        raise DefinitionError(
            f"system '{motion.system.name}': '{name}' does not change along the family of this "
            f"motion; follow it over one of {', '.join(motion.free) or 'the parameters'}"
        )
    if space.shape[1] > 1:
        main = space.T @ slope
        rest = space @ np.linalg.svd(main[None, :])[2][1:].T
        weights = np.where(y == 0, 4.0, 1.0) / units  # what is zero is held at zero rather
        more = {
            equations.names[i]: (equations.unknowns[i], float(y[i]))
            for i in pivots(rest * weights[:, None])
        }
        held |= more
        curve = SolutionCurve(equations.fix(more).fix({name: (expr, 0)}), units)
    return CurveStart(curve, y, tuple(held))


def _towards(
    curve: SolutionCurve, start: np.ndarray, begin: float, target: float, name: str
) -> np.ndarray:
    """The first point of the curve in the span."""
    sign = 1.0 if target > begin else -1.0
    span = (min(begin, target), max(begin, target))
    points, why = follow(curve, start, sign, span, abs(target - begin) / 20, 400, LONGEST)
    if why != COMPLETE:
        raise DefinitionError(
            f"the family does not reach {name} = {target:g}: from {begin:g} on, {why}; give "
            "another span"
        )
    return points[-1]
