"""Where functions pass zero within steps: the finder for one motion, for many, and in any digits.

On a piece of a step a function is sampled at the nine places where Chebyshev's polynomial T_8 is
extreme.  The polynomial through these values, in Bernstein's form

    p(x) = sum_i b_i C(8, i) x^i (1 - x)^(8 - i),    0 <= x <= 1,

has no more zeros between 0 and 1 than b_0, ..., b_8 change their sign, and as many but for an even
number [LaneRiesenfeld1981, thm. 1].  Where that leaves open whether there is none, or one, the
piece is cut in two, at a place at which the function is far from zero.  Both ends of a piece keep
the values that the pieces beside it have there, so that crossings alternate along a whole run.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from math import comb
from typing import Any

import numpy as np

from voronec.motion.request import Guard

DEGREE = 8
"""Of the polynomials that stand for functions on a step."""
NODES = (1 - np.cos(np.pi * np.arange(DEGREE + 1) / DEGREE)) / 2
"""Where functions are looked at, from 0 to 1."""
BERNSTEIN = np.linalg.inv(
    [[comb(DEGREE, i) * s**i * (1 - s) ** (DEGREE - i) for i in range(DEGREE + 1)] for s in NODES]
)
"""Values at the nodes to coefficients; an error of one becomes one of up to 184."""
HIGHEST = np.linalg.inv(np.polynomial.chebyshev.chebvander(2 * NODES - 1, DEGREE))[-2:]
"""Values at the nodes to the last two coefficients of Chebyshev's polynomials, by whose size the
function may be off its polynomial."""
NOISE = 184 * 2.2e-16
"""Rounding of values, as it shows in coefficients."""
ROUGH, COARSE = 0.05, 5
"""What is that far off its polynomial in units of its size, on pieces cut so often, has a pole or a
jump there: it passes zero where it does between two nodes."""
SMALL = 0.035
"""Where a function is smaller than this part of its size no piece is cut, since it may dip there: a
dip lies no further from a node than (a fifth of half a piece), where a parabola is that small."""
CALM = 0.5
"""Where values at the nodes are all of one sign, and none below this part of the largest, the
polynomial through them is nowhere below a sixth of that: Lebesgue's constant of the nodes is 2.28,
and 3/4 - 2.28/4 > 1/6."""
DEEP = 60
"""Pieces are cut no more often: they are as short as doubles can tell."""
FLAT = 1e-6
"""Where a function has come down to this part of its size, it is asked what of it is rounding."""
SPECK = 1e-300
"""What stands for a function that is zero where a motion leaves it."""
TRIES, SLOW = 200, 0.25
"""Of secants and bisections for a root, of which one of three halves what is left where secants are
longer than this part of the last: doubles need no more."""
NEXT = 2.0**-6, 2.0**-20, 2.0**-40
"""How close by, as parts of what is left, it is looked whether a zero is passed."""
BESIDE, TALL = 1e-6, 100.0
"""A pole is told by values so many times larger than at this part of a span from it."""

ROUNDINGS = 2e-15
"""Of the size of a switching surface's function on a step that leaves it: dense output rounds by as
much."""
ROUNDOFF = 1e-14
"""What rounding makes of a state, in units of its size, where a step sums terms larger than it:
where a function goes beyond zero and comes back by less than that makes of it, it touches zero."""

Levels = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,) and states (k, n) to the events' functions (k, m)."""
Function = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,), each within one of pieces (k,), given by their numbers, to values (k,)."""


def crosses(before: Any, after: Any, direction: int = 0) -> Any:
    """Whether functions pass zero between looks, numbers or arrays of them, in a direction, or in
    any: a zero counts for the part of a step that it ends."""
    upwards, downwards = (before < 0) & (after >= 0), (before > 0) & (after <= 0)
    return upwards | downwards if direction == 0 else upwards if direction > 0 else downwards


@dataclass(frozen=True)
class Pieces:
    """Spans of time (k,) with values (9, k) of a function at their nodes, each a part of the piece
    of a number (k,) that was given first, whose largest value is its ``size`` (k,)."""

    start: np.ndarray
    end: np.ndarray
    values: np.ndarray
    number: np.ndarray
    size: np.ndarray

    @classmethod
    def along(cls, start: np.ndarray, end: np.ndarray, values: np.ndarray) -> Pieces:
        """Whole steps s, each for m functions, numbered in this order: values (8 s + 1, m), where
        what ends a step begins the next."""
        rows = _rows(_settle_ends(values))
        size = np.fmax.reduce(np.abs(rows), axis=0)
        return cls(start, end, rows, np.arange(len(start)), size)

    def where(self, which: np.ndarray) -> Pieces:
        """Some of them."""
        return Pieces(
            self.start[which], self.end[which], self.values[:, which], self.number[which],
            self.size[which],
        )  # fmt: skip

    def times(self) -> np.ndarray:
        """The times (9, k) of the nodes."""
        nodes = self.start + NODES[:, None] * (self.end - self.start)
        nodes[-1] = self.end
        return nodes

    def halves(self, function: Function) -> Pieces:
        """Two for each, cut in the middle, or, where the function is small there, beside it."""
        sizes, each = np.abs(self.values), np.arange(len(self.start))
        beside = np.where(sizes[3] > sizes[5], 3, 5)
        middle = np.where(sizes[4] > SMALL * np.fmax.reduce(sizes, axis=0), 4, beside)
        cut, known = self.times()[middle, each], self.values[middle, each]
        twice = Pieces(
            np.concatenate([self.start, cut]), np.concatenate([cut, self.end]),
            np.concatenate([self.values, self.values], axis=1),
            np.tile(self.number, 2), np.tile(self.size, 2),
        )  # fmt: skip
        inner, values = twice.times()[1:-1], twice.values
        # both take a zero there, which is rounding, for what is on one side of it
        known = np.where(known == 0, np.where(self.values[0] < 0, -SPECK, SPECK), known)
        values[-1, : len(each)] = values[0, len(each) :] = known
        heights = function(inner.ravel(), np.tile(twice.number, len(inner)))
        values[1:-1] = heights.reshape(inner.shape)
        return twice

    def signs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The signs (k,) that functions have where pieces begin; how often they pass zero, one time
        at most, -1 where that is open; and whether they are far off their polynomials."""
        whole = np.fmax.reduce(np.abs(self.values), axis=0)
        values = self.values / np.where(whole > 0, whole, 1)
        numbers = values.astype(float)
        off = np.abs(HIGHEST @ numbers).sum(axis=0)
        pattern = BERNSTEIN @ numbers
        pattern = np.where(np.abs(pattern) > NOISE + off, np.sign(pattern), 0.0)
        pattern[0], pattern[-1] = (
            (x > 0) * 1.0 - (x < 0) for x in (self.values[0], self.values[-1])
        )
        pattern[0] = np.where(pattern[0] == 0, pattern[1], pattern[0])
        turns = pattern[:-2] * pattern[2:] == -1
        told = ((pattern[1:-1] != 0) | turns).all(axis=0) & (pattern[0] != 0) & (pattern[-1] != 0)
        # the zero with which a piece begins is no other
        told &= (self.values[0] != 0) | (values[1] * pattern[0] > 0)
        changes = (pattern[:-1] * pattern[1:] == -1).sum(axis=0) + (pattern[1:-1] == 0).sum(axis=0)
        # of what is far from zero rounding may leave the coefficients open
        count = np.where(told & (changes < 2), changes, -1)
        return pattern[0], np.where(_are_calm(numbers), 0, count), ~(off < ROUGH)


@dataclass(frozen=True)
class RootBrackets:
    """Spans (k,) within numbered pieces at whose ends functions have values of different signs."""

    start: np.ndarray
    before: np.ndarray
    end: np.ndarray
    after: np.ndarray
    number: np.ndarray

    @property
    def parts(self) -> tuple[np.ndarray, ...]:
        """All of them, those of ``roots`` first."""
        return self.start, self.before, self.end, self.after, self.number

    def where(self, which: np.ndarray) -> RootBrackets:
        """Some of them."""
        return RootBrackets(*(part[which] for part in self.parts))


def _brackets(pieces: Pieces, first: np.ndarray, single: bool) -> list[RootBrackets]:
    """Between which nodes functions pass zero, from a sign (k,) at the first; of ``single``
    crossings between the ends of the piece where the nodes tell another number."""
    values = pieces.values.copy()
    values[0] = np.where(values[0] == 0, first * SPECK, values[0])
    for later, row in pairwise(values[:0:-1]):  # zeros are on the side of what comes after them
        row[:] = np.where(row == 0, np.where(later < 0, -SPECK, SPECK), row)
    last = np.where(np.abs(values) <= SPECK, 0 * values, values)  # where it is zero, it passes
    passes, times = crosses(values[:-1], values[1:]), pieces.times()
    ends = np.zeros(values.shape[1], dtype=bool)
    if single:
        one, ends = passes.sum(axis=0) == 1, crosses(values[0], values[-1])
        passes, ends = passes & one & ends, ends & ~one
    node, which = np.nonzero(passes)
    inner = RootBrackets(
        times[node, which], values[node, which], times[node + 1, which], last[node + 1, which],
        pieces.number[which],
    )  # fmt: skip
    outer = RootBrackets(pieces.start, values[0], pieces.end, last[-1], pieces.number)
    return [inner, outer.where(ends)]


def find_crossings(
    function: Function, pieces: Pieces, rounding: Function
) -> tuple[RootBrackets, list[tuple[int, Any]]]:
    """Spans in each of which a function passes zero once, and the numbers and times of what touches
    zero.

    ``rounding`` tells by how much it may change functions: what dips below zero and comes back by
    less touches it.
    """
    brackets, touches = list[RootBrackets](), list[tuple[int, Any]]()

    def keep(which: np.ndarray, single: bool) -> None:
        if level == 0 or which.any():
            brackets.extend(_brackets(pieces.where(which), first[which], single))

    for level in range(DEEP + 1):
        first, count, off = pieces.signs()
        keep(count == 1, single=True)
        if not (count < 0).any():
            break
        pieces, first, off = pieces.where(count < 0), first[count < 0], off[count < 0]
        most = np.fmax.reduce(np.abs(pieces.values), axis=0)
        deep, asked = np.full(len(most), np.nan), off | (most <= FLAT * pieces.size)
        if asked.any():
            sides = (rounding(t[asked], pieces.number[asked]) for t in (pieces.start, pieces.end))
            deep[asked] = np.maximum(*sides)
        ends = pieces.values[[0, -1]]
        # a dip no deeper than rounding, before a piece may be cut in it
        least = (np.where(ends[0] < 0, -1, 1) * pieces.values).min(axis=0)
        shallow = (ends[0] * ends[1] > 0) & (least >= -deep) & (most * SMALL <= deep)
        flat = ((most <= deep) | shallow).astype(bool)
        keep(flat, single=True)
        meets = flat & (pieces.values[0] * pieces.values[-1] > 0) & (abs(pieces.values[0]) > SPECK)
        lowest = np.argmin(np.abs(pieces.values), axis=0), np.arange(len(most))
        touches += zip(pieces.number[meets].tolist(), pieces.times()[lowest][meets], strict=True)
        rough = ~flat & ((off & (level >= COARSE)) | (level == DEEP))
        keep(rough, single=False)
        if (flat | rough).all():
            break
        pieces = pieces.where(~(flat | rough)).halves(function)
    return RootBrackets(
        *map(np.concatenate, zip(*(b.parts for b in brackets), strict=True))
    ), touches


def _rows(values: np.ndarray) -> np.ndarray:
    """Values (8 s + 1, m) along steps as those (9, s m) at the nodes of each piece."""
    nodes = np.arange(DEGREE + 1)[:, None] + DEGREE * np.arange(len(values) // DEGREE)
    return values[nodes].reshape(DEGREE + 1, -1)


def _are_calm(rows: np.ndarray) -> np.ndarray:
    """Which pieces (k,), from values (9, k) at their nodes, are so far from zero that nothing else
    has to be asked: that is told of many at once in a tenth of the time."""
    low, high = rows.min(axis=0), rows.max(axis=0)
    least, most = np.where(high < 0, -high, low), np.maximum(-low, high)
    off = np.abs(HIGHEST @ rows).sum(axis=0)
    return np.asarray((least > CALM * most) & (off < most / 6))


def _settle_ends(values: np.ndarray) -> np.ndarray:
    """Values (8 s + 1, m) along steps in which zeros at the ends of steps are taken for what is on
    the side of what comes after them; the last one is passed, where the function was not zero."""
    for row, event in np.argwhere(values[DEGREE::DEGREE] == 0) * [DEGREE, 1] + [DEGREE, 0]:
        ahead, behind = values[row:, event], values[:row, event]
        known = behind[behind != 0][-1:]
        stays = np.where(np.abs(known) <= SPECK, known, -known)
        values[row, event] = SPECK if [*ahead[ahead != 0], *stays, 1][0] > 0 else -SPECK
    return values


def roots(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray], a: Any, left: Any, b: Any, right: Any
) -> np.ndarray:
    """Zeros (k,) between a and b (k,), at which functions have values of different signs, to the
    last digits of the numbers in use: the first number that is not before each of them.

    ``function`` takes times and the positions of what is looked at.  Secants go through the last
    two points, or through both ends where they would lead out (Dekker), and of three of them one
    gives way to bisection where they become shorter slowly.  A point that they do not move by a
    digit is looked at from close by, beyond the zero.
    """
    a, left, b, right = (np.array(x) for x in (a, left, b, right))
    c, before, begin, end, upwards = a.copy(), left.copy(), a.copy(), b.copy(), right > 0
    live = np.flatnonzero((right != 0) & (a != b))
    for count in range(TRIES):
        p, q, r, f, g, e = (x[live] for x in (a, b, c, left, right, before))
        middle = p + (q - p) / 2
        with np.errstate(all="ignore"):
            ends = q - g * (q - p) / (g - f)
            latest = np.where(g == e, ends, q - g * (q - r) / np.where(g == e, g - f, g - e))
        low, high = np.minimum(p, q), np.maximum(p, q)
        place = np.where((low < ends) & (ends < high), ends, middle)
        place = np.where((low < latest) & (latest < high), latest, place)
        for part in NEXT if (still := latest == q).any() else ():
            near = q + (p - q) * part
            place = np.where(still & (near != q), near, place)
        if count % 3 == 2:
            place = np.where(np.abs(latest - q) > SLOW * np.abs(q - r), middle, place)
        moves = (place != p) & (place != q)
        if not moves.any():
            break
        live, place, p, q, f, g = (x[moves] for x in (live, place, p, q, f, g))
        value = function(place, live)
        same = (value > 0) == (g > 0)
        a[live], left[live] = np.where(same, p, q), np.where(same, f, g)
        c[live], before[live], b[live], right[live] = q, g, place, value
        live = live[value != 0]
    passed = (right == 0) | ((right > 0) == upwards)
    zeros, other = np.where(passed, b, a), np.where(passed, a, b)
    # the end itself, where a pole may lie just beside it, is no better than its neighbour
    return np.where((zeros == end) & (other != begin) & (right != 0), other, zeros)


def _is_pole(
    level: Callable[[Any], Any], begin: tuple[Any, Any], time: Any, end: tuple[Any, Any]
) -> bool:
    """Whether a function that changes its sign at a ``time`` between two is infinite there.

    It is larger than at both, or, where one of them is beside the pole, than a little way off: on
    the side of its own sign, since it may also jump, be it beyond that one.
    """
    (a, before), (b, after), value = begin, end, level(time)
    height, sizes = abs(value), (abs(before), abs(after))
    if not height < float("inf") or height > max(sizes):
        return True
    way = (b - a if (value > 0) == (after > 0) else a - b) * BESIDE
    return bool(height > min(sizes) and height > TALL * abs(level(time + way)))


@dataclass(frozen=True)
class StepCourse:
    """Consecutive steps, as events are looked for on them: the times (s + 1,) at which they end,
    the first their start, and states (k, n) at times (k,).  ``before`` are the values (m,) that the
    functions had where the steps before ended, where these are known; ``looks`` gives the states
    at all ``times`` at once, where that is faster."""

    ends: np.ndarray
    at: Callable[[np.ndarray], np.ndarray]
    before: np.ndarray | None = None
    looks: Callable[[], np.ndarray] | None = None

    @property
    def times(self) -> np.ndarray:
        """Where functions are looked at, (8 s + 1,)."""
        begin, length = self.ends[:-1, None], np.diff(self.ends)[:, None]
        return np.append((begin + NODES[:-1] * length).ravel(), self.ends[-1:])


@dataclass(frozen=True)
class Findings:
    """Times at which events happen within steps, in the order of the motion, those at which their
    functions only touch zero, and the values (m,) of all functions at the ``end``: zeros there have
    the sign of the side that is taken for theirs."""

    passages: list[tuple[Any, Guard]]
    touches: list[tuple[Any, Guard]]
    end: np.ndarray


def crossings(
    events: Mapping[int, Guard],
    levels: Levels,
    course: StepCourse,
    switching_surfaces: frozenset[str] = frozenset(),
) -> Findings:
    """What happens on steps.

    ``events`` are given by the columns of their ``levels``.  Those named in ``switching_surfaces``
    fall from what is not negative where the steps start, but for rounding: they may start on a
    switching surface.
    """
    with np.errstate(all="ignore"):
        return _Search(events, levels, course, switching_surfaces).result()


@dataclass
class _Search:
    """The search for m events on s steps: piece i is that of event i mod m on step i // m; ``held``
    (m,) are switching surfaces on which the steps start."""

    events: Mapping[int, Guard]
    levels: Levels
    course: StepCourse
    switching_surfaces: frozenset[str]
    states: np.ndarray = field(init=False)
    held: np.ndarray = field(init=False)
    pieces: Pieces = field(init=False)

    def result(self) -> Findings:
        """What ``crossings`` gives."""
        course, ends, guards = self.course, self.course.ends, list(self.events.values())
        self.states = course.looks() if course.looks else course.at(course.times)
        values = self.levels(self.course.times, self.states)
        if self.course.before is not None:
            values[0] = self.course.before
        every, values = values[-1].copy(), self.looks(values[:, [*self.events]])
        count, calm = len(guards), _are_calm(_rows(values.astype(float)))
        if calm.all():
            return Findings([], [], every)
        begin, end = np.repeat(ends[:-1], count), np.repeat(ends[1:], count)
        self.pieces = Pieces.along(begin, end, values)
        brackets, touches = find_crossings(self.value, self.pieces.where(~calm), self.depth)
        every[[*self.events]] = values[-1]  # zeros are settled there
        met = [(time, guards[n % count]) for n, time in touches]
        events = brackets.number % count
        way = np.array([guard.direction for guard in guards])[events]
        rises = (brackets.after > brackets.before) == (ends[-1] > ends[0])
        brackets = brackets.where((way == 0) | (rises == (way > 0)))
        if not len(brackets.number):
            return Findings([], met, every)
        times = roots(lambda t, i: self.value(t, brackets.number[i]), *brackets.parts[:4])
        heights, sizes = (
            np.abs(self.value(times, brackets.number)),
            np.abs([brackets.before, brackets.after]),
        )
        tall = ~(heights <= np.minimum(*sizes))
        kept = [
            (time, guards[brackets.number[i] % count])
            for i, time in enumerate(times)
            if not (tall[i] and self.is_pole(brackets, i, time))
        ]
        kept.sort(key=lambda pair: abs(pair[0] - ends[0]))
        return Findings(kept, met, every)

    def looks(self, values: np.ndarray) -> np.ndarray:
        """Values (k, m) along the steps: a switching surface on which they start is beyond none,
        and stays there where its function is zero, as that of a push that is just what friction
        bears."""
        switching_surfaces = np.array(
            [guard.name in self.switching_surfaces for guard in self.events.values()]
        )
        self.held = switching_surfaces & (values[0] <= 0).astype(bool)
        values[0, self.held] = SPECK
        values[(values == 0) & self.held] = SPECK
        return values

    def value(self, times: np.ndarray, number: np.ndarray) -> np.ndarray:
        """The functions of pieces (k,) at times (k,)."""
        event = number % len(self.events)
        every = self.levels(times, self.course.at(times))
        heights = every[np.arange(len(times)), np.array([*self.events])[event]]
        heights[(heights == 0) & self.held[event]] = SPECK
        return heights

    def depth(self, times: np.ndarray, number: np.ndarray) -> np.ndarray:
        """By how much rounding may change the functions of pieces (k,) about times (k,): that of
        states, by a part of the largest values that these have on a step."""
        if times.dtype == object:
            return np.zeros(len(times))
        steps, events = np.divmod(number, len(self.events))
        each = len(self.course.ends) - 1, DEGREE, self.states.shape[1]
        sizes = np.abs(self.states[:-1]).reshape(each).max(axis=1)
        here, off = self.course.at(times)[:, None, :], ROUNDOFF * sizes[steps]
        rows = np.concatenate([here, here + off[:, :, None] * np.eye(off.shape[1])], axis=1)
        values = self.levels(np.repeat(times, rows.shape[1]), np.concatenate(rows))
        columns = np.array([*self.events])[events]
        heights = values.reshape(*rows.shape[:2], -1)[np.arange(len(columns)), :, columns]
        depth = np.nansum(np.abs(heights[:, 1:] - heights[:, :1]), axis=1)
        # beside the switching surface that a step leaves, values are the rounding of its dense
        # output, too
        leaves = self.held[events] & (steps == 0)
        return np.where(leaves, 2 * depth + ROUNDINGS * self.pieces.size[number], depth)

    def is_pole(self, found: RootBrackets, place: int, time: Any) -> bool:
        """Whether a function passes zero through a pole; switching surfaces have none."""
        number = found.number[place : place + 1]
        if [*self.events.values()][
            int(number[0]) % len(self.events)
        ].name in self.switching_surfaces:
            return False

        def level(moment: Any) -> Any:
            return self.value(np.array([moment], self.course.times.dtype), number)[0]

        start, before, end, after, _ = (x[place] for x in found.parts)
        return _is_pole(level, (start, before), time, (end, after))
