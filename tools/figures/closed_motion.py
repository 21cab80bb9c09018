"""Demchenko's ball in many digits, however late, by routes that share nothing with the package.

What lies many periods ahead follows from one period: over it the ball turns about K in space, and
about its own axis e3, by angles that do not change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import mpmath
import sympy as sp

from figures.closed_taylor import SPARE, Equations, Taylor, cross, dot, value

NAMES = ("u", "v", "u1", "v1", "theta", "s", "tau", "n")
VALUES = {"R1": 2, "R2": 1, "M": 1, "A": "2/5", "k": 3}
NEAR = 1e-3
"""Sines below this are not taken to tell an angle by."""


@dataclass(frozen=True)
class Motion:
    """A motion by its parameters and initial data, exact: strings, integers, fractions.

    What is not named is zero; ``upright`` replaces theta and u1 by those that put K along z.
    """

    given: Mapping[str, Any]
    upright: bool = False
    digits: int = 60

    @cached_property
    def data(self) -> dict[str, Any]:
        """Parameters and initial data as mpmath numbers."""
        with mpmath.workdps(self.digits + 25):
            names = (*VALUES, *NAMES)
            found = {n: _number(self.given.get(n, VALUES.get(n, 0))) for n in names}
            return {**found, **_upright_start(found)} if self.upright else found

    @cached_property
    def taylor(self) -> Taylor:
        """The motion step by step."""
        d = self.data
        with mpmath.workdps(self.digits + 25):
            own, curved = d["M"] * d["R2"] ** 2, d["R2"] / d["R1"]
            inertia = own + d["A"]
            body, moving = _frame(d["u"], d["v"]), _turned_frame(d["u1"], d["v1"], d["theta"])
            rows, columns = (list(zip(*three, strict=True)) for three in (moving, body))
            axes = [[dot(row, column) for row in rows] for column in columns]
            spins = (inertia * d["s"], inertia * d["tau"], d["A"] * d["n"])
            momentum = [dot(spins, row) + d["k"] * x for row, x in zip(rows, axes[2], strict=True)]
            equations = Equations(momentum, d["k"], inertia, own / d["A"], curved / (1 + curved))
            contact = [-x for x in moving[2]]
            return Taylor(equations, [contact, axes[2], axes[0]], self.digits)

    def at(self, t: Fraction, keep: bool = True) -> dict[str, Any]:
        """Coordinates, spins and x at a time t >= 0, by integration all the way."""
        self.taylor.forward(t, keep)
        with mpmath.workprec(self.taylor.bits + SPARE):
            return self._read(self.taylor.state(t))

    def later(self, t: Fraction) -> dict[str, Any]:
        """The same however late, by whole periods."""
        with mpmath.workprec(self.taylor.bits + SPARE):
            period, about, own = self.turns
            count = int(t / period)
            rest = t - count * period
            self.taylor.forward(rest)
            n1, e3, e1 = self.taylor.state(rest)
            k = self.taylor.equations.momentum
            axis = [x / mpmath.norm(k) for x in k]
            e1 = _turn(e1, e3, -count * own)
            return self._read([_turn(x, axis, count * about) for x in (n1, e3, e1)])

    @cached_property
    def turns(self) -> tuple[Fraction, Any, Any]:
        """The period, the angle about K by which the ball is turned over it (that of v1 where K
        lies along z), and the angle of v."""
        with mpmath.workprec(self.taylor.bits + SPARE):
            first, _, third = self.turning_points(3)
            before, after = self.taylor.state(first), self.taylor.state(third)
            k = self.taylor.equations.momentum
            about = _angle(k, before[:2], after[:2])
            own = [
                [[dot(x, e) for e in (e1, cross(e3, e1), e3)] for x in (n1, k)]
                for n1, e3, e1 in (before, after)
            ]
            return third - first, about, _angle([0, 0, 1], *own)

    def turning_points(self, count: int) -> list[Fraction]:
        """The first turning points of x after the start, which is none itself."""
        found: list[Fraction] = []
        taylor, i = self.taylor, 0
        taylor.forward(Fraction(0))
        while len(found) < count:
            if i == len(taylor.pieces):
                taylor.forward(taylor.pieces[-1].end)
            found += self._turns_of(i)
            i += 1
        return found[:count]

    def _turns_of(self, i: int) -> list[Fraction]:
        taylor, piece = self.taylor, self.taylor.pieces[i]
        slope, found = taylor.slope(piece), []
        grid = [(j << taylor.bits) // 16 for j in range(17)]
        signs = [value(slope, z, taylor.bits) for z in grid]
        if i == 0 and abs(signs[0]) < 1 << 30:  # the start is a turning point
            grid, signs = grid[1:], signs[1:]
        for lo, hi, low, high in zip(grid, grid[1:], signs, signs[1:], strict=False):
            if (low > 0) != (high > 0):
                zero = _zero(slope, lo, hi, low > 0, taylor.bits)
                found.append(piece.begin + piece.step * Fraction(zero, 1 << taylor.bits))
        return found

    def _read(self, state: Sequence[list[Any]]) -> dict[str, Any]:
        n1, e3, e1 = state
        equations, axes = self.taylor.equations, (e1, cross(e3, e1), e3)
        x, y, z = (-dot(n1, e) for e in axes)
        u, v = mpmath.atan2(mpmath.hypot(x, y), z), mpmath.atan2(y, x)
        u1 = mpmath.atan2(mpmath.hypot(n1[0], n1[1]), n1[2])
        v1 = mpmath.atan2(n1[1], n1[0])
        along_u, along_v = (
            [dot(p, row) for row in zip(*axes, strict=True)] for p in _frame(u, v)[:2]
        )
        there = _frame(u1, v1)
        theta = mpmath.atan2(-dot(along_u, there[0]), dot(along_u, there[1]))
        pull = [p - equations.rotor * q for p, q in zip(equations.momentum, e3, strict=True)]
        lean = equations.ratio * dot(pull, n1)
        omega = [(p + lean * q) / equations.inertia for p, q in zip(pull, n1, strict=True)]
        spins = (dot(omega, along_u), dot(omega, along_v), -dot(omega, n1))
        return dict(zip((*NAMES, "x"), (u, v, u1, v1, theta, *spins, z), strict=True))


def _number(given: Any) -> Any:
    digits = mpmath.mp.dps + 10
    return mpmath.mp.make_mpf(sp.Float(sp.sympify(given).evalf(digits), digits)._mpf_)


def _upright_start(d: Mapping[str, Any]) -> dict[str, Any]:
    """theta and u1 where K is along z [DragovicGajicJovanovic2020, eq. (integrali)]."""
    inertia = d["M"] * d["R2"] ** 2 + d["A"]
    along_u, along_v = inertia * d["s"] - d["k"] * mpmath.sin(d["u"]), inertia * d["tau"]
    along_n = d["A"] * d["n"] + d["k"] * mpmath.cos(d["u"])
    return {
        "theta": mpmath.atan2(along_u, -along_v),
        "u1": mpmath.atan2(mpmath.hypot(along_u, along_v), -along_n),
    }


def _frame(u: Any, v: Any) -> tuple[list[Any], list[Any], list[Any]]:
    """e_u, e_v, n of a sphere."""
    a, b, c, d = mpmath.cos(u), mpmath.sin(u), mpmath.cos(v), mpmath.sin(v)
    return [a * c, a * d, -b], [-d, c, mpmath.mpf(0)], [b * c, b * d, a]


def _turned_frame(u1: Any, v1: Any, theta: Any) -> tuple[list[Any], list[Any], list[Any]]:
    """e_u, e_v, n of the ball in space: theta is the angle from e_v1 to e_u."""
    a, b, n = _frame(u1, v1)
    c, s = mpmath.cos(theta), mpmath.sin(theta)
    along_u = [c * y - s * x for x, y in zip(a, b, strict=True)]
    along_v = [c * x + s * y for x, y in zip(a, b, strict=True)]
    return along_u, along_v, [-x for x in n]


def _turn(vector: Sequence[Any], axis: Sequence[Any], angle: Any) -> list[Any]:
    """A vector turned about a unit axis."""
    c, s = mpmath.cos(angle), mpmath.sin(angle)
    rest, swung = dot(axis, vector) * (1 - c), cross(axis, vector)
    return [c * x + s * y + rest * z for x, y, z in zip(vector, swung, axis, strict=True)]


def _angle(axis: Sequence[Any], before: Sequence[Any], after: Sequence[Any]) -> Any:
    """The angle about an axis from the first vector that is not along it to what became of it."""
    axis = [x / mpmath.norm(axis) for x in axis]
    sines = [mpmath.norm(cross(axis, b)) / mpmath.norm(b) for b in before]
    i = next((i for i, s in enumerate(sines) if s > NEAR), sines.index(max(sines)))
    a, b = before[i], after[i]
    flat = [p - dot(a, axis) * q for p, q in zip(a, axis, strict=True)]
    return mpmath.atan2(dot(cross(axis, flat), b), dot(flat, b))


def _zero(slope: Sequence[int], lo: int, hi: int, rising: bool, bits: int) -> int:
    """Newton's method between lo and hi; ``rising``: the slope is positive at lo."""
    steep = [j * c for j, c in enumerate(slope)][1:]
    z = (lo + hi) // 2
    for _ in range(400):
        here, rise = value(slope, z, bits), value(steep, z, bits)
        lo, hi = (z, hi) if (here > 0) == rising else (lo, z)
        new = z - (here << bits) // rise if rise else (lo + hi) // 2
        new = new if lo <= new <= hi else (lo + hi) // 2
        if abs(new - z) <= 4:
            return new
        z = new
    return z
