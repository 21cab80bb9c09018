"""Where the roots of phi lie among the ends of a motion, decided exactly.

Balls of growing precision tell numbers apart.  Where they do not, algebra says whether the numbers
are equal: whether f and phi have a root in common is read off the remainder of f by phi, and
whether an end is a pole of the sphere off the value of f there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import sympy as sp

from voronec.algebra.precision import FIRST
from voronec.closed.arithmetic import precise
from voronec.closed.classes.trace_polynomials import Curve
from voronec.closed.problem import InversionProblem
from voronec.errors import EngineLimit

__all__ = ["Tally", "remainder", "tally"]


@dataclass(frozen=True)
class Tally:
    """What is counted of one trace; pairs are (lower end of x, upper end of x).

    rest, flat, still
        x stays where it is; the cosine does not depend on x; phi vanishes, at x where that is at
        rest, identically otherwise.
    inner
        (place, multiplicity) of the roots of phi strictly between the ends.
    ends
        places of the ends.
    met
        whether phi vanishes at the end.
    poles
        the cosine there, 1 or -1; 0 where it is neither.
    limits
        whether the end is a multiple root of f.
    tilt
        sign of the cosine's slope.
    """

    rest: bool = False
    flat: bool = False
    still: bool = False
    inner: tuple[tuple[float, int], ...] = ()
    ends: tuple[float, float] = (float("nan"), float("nan"))
    met: tuple[bool, bool] = (False, False)
    poles: tuple[int, int] = (0, 0)
    limits: tuple[bool, bool] = (False, False)
    tilt: int = 1


def tally(problem: InversionProblem, curve: Curve) -> Tally | None:
    """The counts of a trace; None where its cosine has no value on this level."""
    if not all(problem.exact(c)(FIRST).is_finite() for c in curve.cosine):
        return None
    search = _Search(problem, curve)
    if problem.rests:
        return search.at_rest()
    return search.between()


@dataclass(frozen=True, eq=False)
class _Search:
    problem: InversionProblem
    curve: Curve

    @cached_property
    def phi(self) -> tuple[Any, ...]:
        """The coefficients up to the last that is not zero."""
        found = list(self.curve.above)
        while found and self.problem.sign(found[-1]) == 0:
            found.pop()
        return tuple(found)

    @cached_property
    def double(self) -> bool:
        """Whether phi, of degree 2, is a square."""
        c, b, a = self.phi
        return self.problem.sign(b**2 - 4 * a * c) == 0

    def at_rest(self) -> Tally:
        """x is a multiple root of f and stays there."""
        motion = self.problem.prepared.motion
        x, (offset, slope) = motion.meaning, self.curve.cosine
        cosine = offset + slope * x
        pole = next((s for s in (1, -1) if self.problem.sign(cosine - s) == 0), 0)
        still = pole != 0 or self.problem.sign(self.curve.above_at(x)) == 0
        place = float(self.problem.place(FIRST))
        return Tally(rest=True, still=still, ends=(place, place), poles=(pole, pole),
                     tilt=self.problem.sign(slope) or 1)  # fmt: skip

    def between(self) -> Tally:
        """x runs between two roots of f, or towards them."""
        from voronec.elliptic.roots import ends_of, resolve

        source, slope = self.problem.source, self.curve.cosine[1]
        tilt = self.problem.sign(slope)

        def attempt(bits: int) -> Tally:
            ends = ends_of(source, bits)
            pair = (ends.lower, ends.upper)
            others = [r.value for r in ends.roots if r not in pair and r.real]
            at = self._roots(bits)
            poles = tuple(self._pole(e.value, others, bits) if tilt else 0 for e in pair)
            inner, met = [], [False, False]
            for root, times in at:
                where = self._where(root, [e.value for e in pair], others, at, bits)
                if where == "inside":
                    inner.append((float(root), times))
                elif where in (0, 1):
                    met[int(where)] = True
            return Tally(
                flat=tilt == 0, still=not self.phi, inner=tuple(inner),
                ends=(float(pair[0].value), float(pair[1].value)), met=(met[0], met[1]),
                poles=(poles[0], poles[1]), limits=(pair[0].times > 1, pair[1].times > 1),
                tilt=tilt or 1,
            )  # fmt: skip

        return resolve(attempt, FIRST)

    def _values(self, expressions: Sequence[Any], bits: int) -> list[Any]:
        return [self.problem.exact(e)(bits) for e in expressions]

    def _roots(self, bits: int) -> list[tuple[Any, int]]:
        """The real roots of phi, ascending, and their multiplicities."""
        if len(self.phi) < 2:
            return []
        values = self._values(self.phi, bits)
        with precise(bits):
            if len(values) == 2:
                return [(-values[0] / values[1], 1)]
            if len(values) == 3:
                c, b, a = values
                if self.double:
                    return [(-b / (2 * a), 2)]
                if self.problem.sign(self.phi[1] ** 2 - 4 * self.phi[2] * self.phi[0]) < 0:
                    return []
                root = (b * b - 4 * a * c).sqrt()
                pair = [(-b - root) / (2 * a), (-b + root) / (2 * a)]
                return [(r, 1) for r in (pair if a > 0 else pair[::-1])]
            return _isolate_roots(values)

    def _where(
        self, root: Any, ends: list[Any], others: list[Any], all_roots: Any, bits: int
    ) -> Any:
        """``inside``, ``outside``, or the index of the end that the root is."""
        from voronec.elliptic.roots import OpenDecision

        lower, upper = ends
        if root > lower and root < upper:
            return "inside"
        if root < lower or root > upper:
            return "outside"
        index = 0 if root.overlaps(lower) else 1
        alone = not any(root.overlaps(o) for o in (*others, ends[1 - index]))
        if alone and self._is_shared(root, all_roots, bits):
            return index
        raise OpenDecision("a root of phi may be an end of the motion")

    def _is_shared(self, root: Any, all_roots: Any, bits: int) -> bool:
        """Whether a root of phi is surely a root of f, too."""
        if len(self.phi) > 3:
            raise EngineLimit("phi has degree 3 or more; equal roots are decided up to degree 2")
        rest = self.quartic_remainder
        if all(self.problem.sign(e) == 0 for e in rest):
            return True
        if len(rest) == 1 or self.problem.sign(rest[1]) == 0:
            return False
        (p0, p1, p2), (r0, r1) = self.phi, rest
        if self.problem.sign(p2 * r0**2 - p1 * r0 * r1 + p0 * r1**2) != 0:
            return False
        below, above = self._values(rest, bits)
        with precise(bits):
            place = -below / above
            return [place.overlaps(r) for r, _ in all_roots].count(True) == 1 and bool(
                place.overlaps(root)
            )

    @cached_property
    def quartic_remainder(self) -> tuple[Any, ...]:
        """Of f by phi, up to a factor: coefficients as expressions."""
        return remainder(self.problem.prepared.quartic, self.phi)

    def _pole(self, end: Any, others: list[Any], bits: int) -> int:
        """The cosine at an end of the motion, where that is 1 or -1."""
        from voronec.elliptic.roots import OpenDecision

        offset, slope = self.curve.cosine
        x = self.problem.prepared.motion.x
        for side in (1, -1):
            place = (side - offset) / slope
            (value,) = self._values([place], bits)
            if not value.overlaps(end):
                continue
            alone = not any(value.overlaps(o) for o in others)
            at_pole = self.problem.prepared.motion.quartic.xreplace({x: place})
            if alone and self.problem.sign(at_pole) == 0:
                return side
            raise OpenDecision("an end of the motion may be a pole of the sphere")
        return 0


def remainder(quartic: Sequence[Any], phi: Sequence[Any]) -> tuple[Any, ...]:
    """Coefficients of the remainder of one polynomial by another, up to a factor."""
    names, formulas = _remainder(len(phi) - 1)
    meaning = dict(zip(names, (*quartic, *phi), strict=True))
    return tuple(e.xreplace(meaning) for e in formulas)


@cache
def _remainder(degree: int) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Symbols of a quartic and of a polynomial of some degree, and the pseudo-remainder."""
    x = sp.Symbol("x")
    above, below = sp.symbols("f0:5"), sp.symbols(f"p0:{degree + 1}")
    rest = sp.prem(
        sum(c * x**i for i, c in enumerate(above)), sum(c * x**i for i, c in enumerate(below)), x
    )
    poly = sp.Poly(rest, x)
    return (*above, *below), tuple(poly.coeff_monomial(x**i) for i in range(degree))


def _isolate_roots(values: list[Any]) -> list[tuple[Any, int]]:
    """The real roots of a polynomial without multiple ones."""
    from flint import acb_poly

    from voronec.elliptic.roots import OpenDecision

    try:
        found = acb_poly(values).roots()
    except ValueError:
        raise OpenDecision("phi may have a multiple root") from None
    return [(r.real, 1) for r in found if r.imag.contains(0)]
