"""What equations divide by, and where that vanishes though the motion goes on.

Velocities that are no frame at some place, or a constraint solved for the wrong unknown, leave a
divisor that changes its sign there: 1/gamma3, 1/cos(u), 1/sin(alpha - phi).  The motion passes the
place, the equations do not, and Taylor's method may step over it without a sign.  Where coordinates
fail, at the pole of a sphere, the metric

    g = d2L/dw2 + A^T A                                     w: velocities, A w + a = 0: constraints

is singular as well; those divisors are the business of charts.

Where coordinates that are carried along have a pole,

    du1/dt = x,    dv1/dt = y/sin(u1),    dtheta/dt = -n - y cot(u1),

rows are infinite, and what finite rates meet is the limit of the space that they span: y = 0 and
dtheta/dt + cos(u1) dv1/dt = -n.  It is looked at so near, in so many digits, that it is the limit
to the last digit of a double.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, log2
from random import Random
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.graphs import bases
from voronec.algebra.normal import canonical
from voronec.equations.program.switches import Sides, is_rough, plain_roots
from voronec.motion.request import Guard, Namespace
from voronec.motion.state_probe import quantities, usual_size
from voronec.motion.steppers import Problem

SAMPLES, FEW = 1024, 128
"""So many random places tell whether a function changes its sign, and how large it is: its usual
size is then known to a few hundredths, and other places would lead a run the same way.  Of zeros
and metrics, which cost more, so few are looked at."""
REACH = np.pi
"""Places are taken so far around the start, in units of one or of the coordinate's size."""
HALVINGS = 40
"""Of a bracket of doubles, to next to rounding."""
POLE = 1e-5
"""Where the metric is nearer to being singular than this part of the usual, coordinates fail."""
TRUE = 1e-3
"""A function that is found to be larger where its sign changes has a pole there."""
LOW, TOUCH = 1e-2, 1e-9
"""A function that keeps its sign may touch zero, as 1 + cos(phi) does, where it is as small at some
random place as the one; it does where the search from there finds it as small as the other."""
DESCENTS, DESCENT, SLOPE = 8, 12, 1e-6
"""From so many places, in so many steps, with slopes taken over such a part of a coordinate."""
NEAR = 0.1
"""Below this, in units of its usual size, a divisor makes its velocities be left for all: what is
lost in digits is the square of such a number at most."""

EDGE = 1.01
"""A divisor so close to its level is at it: a passage at the start is not seen."""
Field = Callable[[np.ndarray], np.ndarray]
"""States (n, k), a column each, to values (m, k)."""


@dataclass(frozen=True)
class SingularDenominator:
    """A function that vanishes somewhere, and how large it usually is."""

    function: Any
    scale: float

    @property
    def exponent(self) -> int:
        """The logarithm to base two of the value that is watched, the nearest whole one: so that
        programs differ little."""
        return round(log2(NEAR * self.scale))

    def is_near(self, value: float) -> bool:
        """Whether a value is at the level that is watched or below, or none: a motion that starts
        there does not pass it."""
        return not EDGE * 2.0**self.exponent < abs(value) < inf


@lru_cache(maxsize=32)  # it is asked before every run
def divisors(form: Any, changing: tuple[Any, ...] = ()) -> tuple[Any, ...]:
    """What rates, mass and force are divided by, as far as it moves, or is of ``changing``
    parameters; each once."""
    moving = {*form.coordinates, *form.velocities, form.time, *(name for name, _ in form.stages)}
    moving |= {*changing}
    denominators: dict[Any, None] = {}
    exprs = cardinal_all([*form.expressions, *(e for _, e in form.stages)])
    for base in bases(exprs):
        if base.free_symbols & moving:
            denominators[base] = None
    if form.stages or not is_rough((), exprs, form.parameters):
        return tuple(denominators)
    slopes = _slopes_of_corners(denominators, exprs, frozenset(form.parameters))
    return tuple(b for b in denominators if b not in slopes)


def _slopes_of_corners(
    divisors: Iterable[Any], exprs: Sequence[Any], still: frozenset[Any]
) -> set[Any]:
    """Those of divisors, each the function of a switching surface or its square, by which
    expressions do not divide on either side of the switching surface, as sqrt(x^2)/x does not, the
    slope of |x|."""
    slopes = set(divisors)
    for side in (lambda _: 1), (lambda _: -1):
        change = Sides(side, lambda _: se.Integer(0), still)
        made = [change(plain_roots(e, still)) for e in exprs]
        functions = [switch.function for switch in change.switches]
        switches = {b: f for b in slopes for f in functions if _is_power(b, f)}
        left = [*bases(made)]
        slopes = {b for b, f in switches.items() if not any(_is_power(d, f) for d in left)}
    return slopes


def _is_power(divisor: Any, function: Any) -> bool:
    """Whether a divisor is a function, or its square, up to a number."""
    return divisor.free_symbols == function.free_symbols and any(
        canonical([divisor / function**k])[0].is_Number for k in (1, 2)
    )


def without_factors(function: Any, factors: Iterable[Any]) -> Any:
    """A function divided by factors, each as often as it divides every one of its terms.

    What is a pole of coordinates may stand in a divisor that is none: sin(beta) in
    sin(beta) cos(beta) r - sin(beta)^2, with a rest that vanishes elsewhere.
    """
    for factor in factors:
        name = se.Dummy("factor")
        rest = se.expand(function.xreplace({factor: name}))
        while name in rest.free_symbols and rest.xreplace({name: se.Integer(0)}) == 0:
            rest = se.expand(rest / name)
            function = rest.xreplace({name: factor})
    return function


def around(start: np.ndarray) -> np.ndarray:
    """Places (n, k) at random around a start (n,)."""
    places: np.ndarray = (
        start[:, None] + _ways(start.size, SAMPLES) * np.maximum(1.0, np.abs(start))[:, None]
    )
    return places


def _ways(size: int, count: int) -> np.ndarray:
    """Ways (size, count) at random, the same every time."""
    dice = Random(0)  # NumPy's generators load slowly
    ways = np.array([dice.uniform(-REACH, REACH) for _ in range(size * count)])
    return ways.reshape(size, count)


def crossing_divisors(
    functions: Sequence[Any], places: np.ndarray, values: Field, soundness: Field, onto: Field
) -> list[SingularDenominator]:
    """Those functions that change their sign, or touch zero, where the coordinates are good.

    ``places`` (n, k) are states of the coordinates and the velocities; ``values`` gives all
    functions there, and ``soundness`` how far the metric g is from being singular; ``onto`` moves
    places onto the relations between redundant coordinates.
    """
    sizes, usual = values(places), -1.0
    denominators = []
    for i, (function, row) in enumerate(zip(functions, sizes, strict=True)):
        below, above = places[:, row < 0], places[:, row > 0]
        count = min(below.shape[1], above.shape[1], FEW)
        scale = _middle_size(np.abs(row))
        if count:
            zeros = onto(_between(values, i, below[:, :count], above[:, :count]))
        else:
            first = np.argsort(np.abs(row))[:DESCENTS]
            first = first[np.abs(row[first]) < LOW * scale]
            zeros = _downhill(values, i, places[:, first], onto)
        if not zeros.size:
            continue
        # a change of sign through infinity is no zero, nor is one off the relations
        low = TRUE * scale if count else TOUCH * min(scale, _size_around(values, i, zeros, onto))
        true = np.abs(values(zeros)[i]) < low
        usual = usual_size(soundness(places[:, :FEW])) if usual < 0 else usual
        if (true & (soundness(zeros) > POLE * usual)).any():
            denominators.append(SingularDenominator(function, scale))
    return denominators


def _between(values: Field, i: int, below: np.ndarray, above: np.ndarray) -> np.ndarray:
    """Where the i-th of some functions changes its sign on the ways between places."""
    for _ in range(HALVINGS):
        middle = (below + above) / 2
        under = values(middle)[i] < 0
        below, above = np.where(under, middle, below), np.where(under, above, middle)
    zeros: np.ndarray = (below + above) / 2
    return zeros


def _downhill(values: Field, i: int, places: np.ndarray, onto: Field) -> np.ndarray:
    """Where the i-th of some functions, which keep their sign, is next to zero near some places: by
    Newton's method for a double zero, x - 2 f grad f / |grad f|^2."""
    for _ in range(DESCENT if places.size else 0):
        n, count = places.shape
        steps = SLOPE * np.maximum(1.0, np.abs(places))
        beside = places[:, None, :] + np.eye(n)[:, :, None] * steps
        back = places[:, None, :] - np.eye(n)[:, :, None] * steps
        there = values(np.concatenate([places, beside.reshape(n, -1), back.reshape(n, -1)], axis=1))
        size, after, before = np.split(there[i], [count, count * (n + 1)])
        slope = (after - before).reshape(n, count) / (2 * steps)
        with np.errstate(all="ignore"):
            move = 2 * size * slope / (slope**2).sum(axis=0)
        places = onto(places - np.where(np.isfinite(move), move, 0.0))
    return places


def _size_around(values: Field, i: int, zeros: np.ndarray, onto: Field) -> float:
    """How large the i-th of some functions usually is around the lowest of its zeros, in units of
    one: 1 + (x - c)^4 is so large over places of the size of c that its one passes for nothing."""
    lowest = zeros[:, [np.argmin(np.abs(values(zeros)[i]))]]
    return _middle_size(np.abs(values(onto(lowest + _ways(len(zeros), FEW)))[i]))


def _middle_size(sizes: np.ndarray) -> float:
    """The geometric mean of the middle half of those sizes that are finite and not zero: of many
    it hangs less than the median on which they are, where few are near that."""
    finite = np.sort(sizes[np.isfinite(sizes) & (sizes > 0)])
    n = len(finite)
    return float(np.exp(np.log(finite[n // 4 : n - n // 4]).mean())) if n else 0.0


# -- watched along a run --------------------------------------------------------------------


def with_events(
    problem: Problem, form: Any, functions: Mapping[str, Any], levels: Mapping[str, Any], **how: Any
) -> Problem:
    """A problem with events at zeros of further functions on its model, by name."""
    return replace(
        problem,
        events=(*problem.events, *(Guard(name, **how) for name in levels)),
        levels=quantities(form, {**functions, **levels}),
        coarse=problem.coarse | levels.keys(),
    )


def watch_levels(watched: Sequence[SingularDenominator]) -> dict[str, Any]:
    """Functions that vanish where a divisor comes near zero, by the names of events."""
    return {
        f"divisor {i} near zero": d.function**2 - (se.Integer(2) ** d.exponent) ** 2
        for i, d in enumerate(watched)
    }


class NearSingularDenominator(Exception):
    """A model of the system of ``namespace`` divides by what comes near zero: all velocities have
    to be taken."""

    def __init__(self, namespace: Namespace) -> None:
        super().__init__("a divisor comes near zero")
        self.namespace = namespace


NEARLY_DEPENDENT = 1e-3
"""Constraints whose least singular value is below this part of the largest lose three digits or
more; with what they imply beside them none are lost."""


def are_nearly_dependent(rows: np.ndarray) -> bool:
    """Whether the rows (m, N) of constraints are dependent at one place, or next to it."""
    sizes = np.linalg.svd(_unit(rows), compute_uv=False)
    return bool(sizes.min(initial=1.0) < NEARLY_DEPENDENT * sizes.max(initial=1.0))


def _unit(rows: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(rows / np.where(lengths == 0, 1.0, lengths))


DIGITS = 120
"""Of numbers in which infinite rows are looked at."""
NEXT = mpmath.mpf("1e-20")
"""So far beside a place that is: at two poles at once rows are the inverse of its square."""
SAME = mpmath.mpf("1e-80")
"""A row that is, but for this part, a sum of others is dependent."""
INFINITE = 1e8
"""An entry of rows so many times the middle one is a division by zero."""


def are_infinite(rows: np.ndarray) -> bool:
    """Whether rows (m, N) of constraints divide by zero, but for rounding."""
    sizes = np.abs(rows[rows != 0])
    return bool(sizes.size and not sizes.max() < INFINITE * np.median(sizes))


def next_places(q: np.ndarray) -> list[list[Any]]:
    """Two places next to coordinates q (n,), on opposite sides, in mpmath's numbers."""
    dice = Random(0)
    ways = [NEXT * dice.uniform(0.5, 1) for _ in q]
    return [
        [mpmath.mpf(x) + sign * way for x, way in zip(q, ways, strict=True)] for sign in (1, -1)
    ]


def orthonormal_rows(rows: np.ndarray) -> np.ndarray:
    """Orthonormal rows that span what rows (m, N + 1) with offsets do, and zeros for those that
    depend on the others."""
    basis: list[np.ndarray] = []
    for row in rows:
        rest = row / (mpmath.sqrt(row[:-1].dot(row[:-1])) or 1)
        for other in basis:
            rest = rest - rest[:-1].dot(other[:-1]) * other
        size = mpmath.sqrt(rest[:-1].dot(rest[:-1]))
        basis.append(rest / size if size > SAME else 0 * rest)
    return np.array(basis)
