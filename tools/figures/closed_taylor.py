"""A ball on a sphere by Taylor's method in integers: nothing of it comes from the package.

In space, n1 is the outward normal of the fixed sphere at the contact, e3 and e1 are axes of the
ball, and K = P omega - I (omega . n1) n1 + k e3 is constant, so that

    dn1/dt = (mu'/mu) omega x n1,    de/dt = omega x e,    P omega = K - k e3 + a n1,
    a = (I/A) (K - k e3) . n1

are polynomials, and no chart has a singularity in the way.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import ceil, log2
from operator import mul
from typing import Any

import mpmath

SPARE = 40
"""Bits by which what is prepared is more accurate than the steps."""
CYCLE = ((1, 2), (2, 0), (0, 1))


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """a . b, also of series in integers, one coefficient of the product."""
    return sum(map(mul, a, b))


def cross(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """a x b."""
    return [a[i] * b[j] - a[j] * b[i] for i, j in CYCLE]


def value(polynomial: Sequence[int], point: int, bits: int) -> int:
    """A polynomial, coefficients ascending, in integers with a fixed point."""
    total = 0
    for c in reversed(polynomial):
        total = ((total * point) >> bits) + c
    return total


@dataclass(frozen=True)
class Equations:
    """K, k and the constants of the ball, as mpmath numbers: P, I/A, mu'/mu."""

    momentum: list[Any]
    rotor: Any
    inertia: Any
    ratio: Any
    slide: Any

    @property
    def rate(self) -> Any:
        """A bound on how fast the vectors turn."""
        fast = mpmath.norm(self.momentum) + abs(self.rotor)
        return fast / self.inertia * (1 + abs(self.slide) + abs(self.ratio))


@dataclass(frozen=True)
class Piece:
    """One step: n1, e3, e1 as nine series in (t - begin)/step, in integers."""

    begin: Fraction
    step: Fraction
    rows: list[list[int]]

    @property
    def end(self) -> Fraction:
        """Where the next one begins."""
        return self.begin + self.step


@dataclass
class Taylor:
    """A motion from its start (n1, e3, e1), with about ``digits`` digits in every step."""

    equations: Equations
    start: list[list[Any]]
    digits: int
    pieces: list[Piece] = field(default_factory=list)

    @property
    def bits(self) -> int:
        """Behind the point."""
        return ceil(self.digits * log2(10)) + 24

    @property
    def order(self) -> int:
        """Of the series: steps are then a seventh of the distance to the nearest singularity."""
        return int(1.15 * self.digits) + 4

    def forward(self, until: Fraction, keep: bool = True) -> None:
        """Make pieces up to a time; without ``keep`` only the last one stays."""
        with mpmath.workprec(self.bits + SPARE):
            while not self.pieces or self.pieces[-1].end <= until:
                begin, pace, state = Fraction(0), self._pace, []
                if self.pieces:
                    last = self.pieces[-1]
                    begin, pace, state = last.end, last.step, [sum(r) for r in last.rows]
                rows, step = self._step(state or self._begin, pace)
                if not keep:
                    self.pieces.clear()
                self.pieces.append(Piece(begin, step, rows))

    def state(self, t: Fraction) -> list[list[Any]]:
        """(n1, e3, e1) at a time that has been reached, as mpmath numbers."""
        piece = self.pieces[max(bisect_right(self.pieces, t, key=lambda p: p.begin) - 1, 0)]
        part = (t - piece.begin) / piece.step
        point = (part.numerator << self.bits) // part.denominator
        found = [
            mpmath.ldexp(mpmath.mpf(value(r, point, self.bits)), -self.bits) for r in piece.rows
        ]
        return [found[0:3], found[3:6], found[6:9]]

    def slope(self, piece: Piece) -> list[int]:
        """dx/dt on a piece up to a positive factor, x = -n1 . e3."""
        rows = piece.rows
        x = [
            -sum(dot(rows[i][: j + 1], rows[3 + i][j::-1]) for i in range(3)) >> self.bits
            for j in range(len(rows[0]))
        ]
        return [j * c for j, c in enumerate(x)][1:]

    @cached_property
    def _begin(self) -> list[int]:
        return [self._integer(x) for vector in self.start for x in vector]

    @cached_property
    def _pace(self) -> Fraction:
        rate = self.equations.rate
        return (
            Fraction(2) ** int(mpmath.floor(mpmath.log(1 / rate, 2)) + 1) if rate else Fraction(1)
        )

    def _integer(self, x: Any) -> int:
        return int(mpmath.nint(mpmath.ldexp(x, self.bits)))

    def _step(self, state: list[int], pace: Fraction) -> tuple[list[list[int]], Fraction]:
        """Series scaled by a step for which their last coefficients are nothing, and the step."""
        rows = self._series(state, 2 * pace)
        tail = max(abs(r[j]) for r in rows for j in (self.order - 1, self.order))
        part = min(32, int(32 * 2.0 ** (-log2(tail) / self.order))) if tail else 32
        if part < 1:
            return self._step(state, pace / 8)
        scaled = [[c * part**j >> 5 * j for j, c in enumerate(r)] for r in rows]
        return scaled, 2 * pace * Fraction(part, 32)

    def _series(self, state: list[int], step: Fraction) -> list[list[int]]:
        b, e = self.bits, self.equations
        pace = mpmath.mpf(step.numerator) / step.denominator / e.inertia
        pull = [self._integer(pace * x) for x in e.momentum]
        slide = [self._integer(pace * x * e.slide) for x in e.momentum]
        lean = [self._integer(pace * x * e.ratio) for x in e.momentum]
        rotor, slid, leant = (
            self._integer(pace * e.rotor * factor) for factor in (1, e.slide, e.ratio)
        )
        rows = [[x] for x in state]
        n1, e3, e1 = rows[0:3], rows[3:6], rows[6:9]
        across: list[list[int]] = [[], [], []]  # e3 x n1
        beside: list[list[int]] = [[], [], []]  # n1 x e1
        a: list[int] = []
        for j in range(self.order):
            back_n, back_1 = [x[::-1] for x in n1], [x[::-1] for x in e1]
            own = []  # e3 x e1
            for i, (p, q) in enumerate(CYCLE):
                across[i].append((dot(e3[p], back_n[q]) - dot(e3[q], back_n[p])) >> b)
                beside[i].append((dot(n1[p], back_1[q]) - dot(n1[q], back_1[p])) >> b)
                own.append((dot(e3[p], back_1[q]) - dot(e3[q], back_1[p])) >> b)
            level = sum(dot(e3[i], back_n[i]) for i in range(3)) >> b
            a.append((sum(lean[i] * n1[i][j] for i in range(3)) - leant * level) >> b)
            back_a = a[::-1]
            of_n, of_3, of_1 = (
                cross(v, [x[j] for x in w]) for v, w in ((slide, n1), (pull, e3), (pull, e1))
            )
            for i in range(3):
                n1[i].append((of_n[i] - slid * across[i][j] >> b) // (j + 1))
                e3[i].append((of_3[i] - dot(back_a, across[i]) >> b) // (j + 1))
                e1[i].append((of_1[i] - rotor * own[i] + dot(back_a, beside[i]) >> b) // (j + 1))
        return rows
