"""One motion whose elliptic integral is inverted: what all its evaluations begin with.

It knows what angles grow by in a period, and whether that is likely a rational part of a whole
turn.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.precision import GENERIC, SHARP
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import ball, precise
from voronec.closed.fractions import ascending_coefficients
from voronec.closed.problem import InversionProblem
from voronec.closed.space import Attitude
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.system import System
from voronec.errors import EngineLimit


@dataclass(frozen=True, eq=False, repr=False)
class InvertedMotion:
    """The variable of a motion by quadratures, inverted, with its constants and its start.

    ``memo`` keeps what evaluations compute of it: the clock, tables, whole turns.
    """

    problem: InversionProblem
    memo: Memo = field(default_factory=Memo, init=False)

    @cached_property
    def system(self) -> System:
        """The system that moves."""
        return self.problem.prepared.system

    @cached_property
    def quadratures(self) -> Quadratures:
        """The declaration of the motion."""
        return self.problem.prepared.motion

    @cached_property
    def rests(self) -> bool:
        """Whether the variable stays at a multiple root: a regular precession."""
        return self.problem.rests

    @cached_property
    def solution(self) -> Any:
        """The inverted elliptic integral, ``voronec.elliptic.Solution``."""
        from voronec.elliptic import invert

        return invert(self.problem.source)

    @cached_property
    def attitude(self) -> Attitude | None:
        """How the motion lies in space; None where the system declares no space."""
        space = self.quadratures.space
        return None if space is None else Attitude(self.problem, space)

    # -- what there is to know -------------------------------------------------------------

    @cached_property
    def constants(self) -> Mapping[str, float]:
        """The constants of the motion by name."""
        level = self.problem.level(GENERIC)[len(self.system.parameters) :]
        names = map(plain_name, self.quadratures.constants)
        return MappingProxyType(dict(zip(names, map(float, level), strict=True)))

    @property
    def kind(self) -> str:
        """What the functions are: ``trigonometric``, ``hyperbolic``, ``rational``,
        ``exponential``, or ``rest``."""
        return "rest" if self.rests else str(self.solution.constants(GENERIC).kind)

    @property
    def period(self) -> float:
        """The time from one turning point of the variable to the next alike; infinite where it
        tends to a limit, and where it rests."""
        if self.rests:
            return float("inf")
        if self.quadratures.clock == 1:
            return float(self.solution.period)
        # the last of the integrals is the time
        advances = self.solution.constants(GENERIC).advances
        return (
            float("inf")
            if advances is None
            else float(advances[len(self.problem.prepared.rates) - 1])
        )

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the greatest value of the variable, or their limits."""
        if self.rests:
            x = float(self.problem.place(GENERIC))
            return x, x
        low, high = self.solution.ends
        return low, high

    @property
    def roots(self) -> tuple[complex, ...]:
        """The finite roots of the quartic, each as often as it is repeated; none where it vanishes
        for every x."""
        if self._flat:
            return ()
        return tuple(self.solution.roots)

    @property
    def invariants(self) -> tuple[float, float, float]:
        """Weierstrass' g2 and g3, and the discriminant g2^3 - 27 g3^2."""
        if self._flat:
            return 0.0, 0.0, 0.0
        g2, g3, discriminant = self.solution.invariants
        return g2, g3, discriminant

    @property
    def arguments(self) -> Mapping[str, complex | None]:
        """The complex times at which the variable reaches each pole, from the turning point at
        one end; by the place of the pole.  None where it adds no angle."""
        names = [str(c) for c, _ in self.problem.prepared.poles]
        if self.rests:
            return MappingProxyType(dict.fromkeys(names))
        return MappingProxyType(dict(zip(names, self.solution.arguments, strict=True)))

    @cached_property
    def _flat(self) -> bool:
        return self.rests and not self.problem.source(GENERIC).factors

    # -- decisions -------------------------------------------------------------------------

    def exact(self, expr: Any) -> Callable[[int], Any]:
        """An expression in constants and parameters at any number of bits, as a ball."""
        return self.problem.exact(as_expression(expr))

    def sign(self, expr: Any) -> int:
        """-1, 0 or 1, decided exactly; ``EngineLimit`` where no proof is found."""
        return self.problem.sign(expr)

    def polynomial(self, expr: Any) -> tuple[sp.Expr, ...]:
        """The coefficients of a polynomial in the variable, ascending, as expressions."""
        degree = sp.degree(as_expression(expr), self.quadratures.x) if expr else 0
        return ascending_coefficients(expr, self.quadratures.x, int(max(degree, 0)))

    # -- parts -----------------------------------------------------------------------------

    def begin(self, bits: int) -> list[Any]:
        """The angles at the start, in the order of the integrals; of the motion turned upright."""
        given = self.problem.start_by_symbol(bits)
        if self.attitude is not None and not self.attitude.upright and not self.rests:
            attitude = self.attitude
            given |= dict(zip(attitude.coordinates, attitude.begin(bits), strict=True))
        return [given[q] for q in self.quadratures.angles]

    def branch(self, i: int) -> tuple[int, int]:
        """Of the colatitude of trace i: (sign, turns), colatitude = sign (0..pi) + 2 pi turns."""
        trace = self.quadratures.traces[i].colatitude
        turned = self.attitude is not None and not self.attitude.upright
        if turned and self.attitude is not None and trace in self.attitude.coordinates:
            return 1, 0
        return self.problem.branch(trace)

    @cached_property
    def wheels(self) -> bool:
        """Whether the variable rests and the vector in the plane vanishes: nothing singles out a
        direction then, and the place goes round evenly."""
        plane = self.quadratures.plane
        if plane is None or not self.rests:
            return False
        return all(self.sign(e) == 0 for e in plane.direction)

    @cached_property
    def rates_at_rest(self) -> tuple[sp.Expr, ...]:
        """The velocities of all coordinates where the variable rests, in constants."""
        motion, rates = self.quadratures, self.problem.prepared.rates
        velocities = dict(zip(motion.angles, rates, strict=False))
        if motion.plane is not None:
            a, b = (e / motion.plane.length for e in motion.plane.direction)
            along, across = rates[len(motion.angles) : len(motion.angles) + 2]
            x, y = motion.plane.place
            velocities |= {x: a * along - b * across, y: b * along + a * across}
        meaning = {motion.x: motion.meaning}
        return tuple(
            (velocities.get(q, sp.Integer(0)) / motion.clock).xreplace(meaning)
            for q in self.system.coordinates
        )

    def direction(self, bits: int) -> tuple[Any, Any]:
        """The unit vector along which a place on a plane is counted."""
        plane = self.quadratures.plane
        assert plane is not None
        if self.sign(plane.length) == 0:
            raise EngineLimit(
                f"system '{self.system.name}': the vector in the plane vanishes, so that no "
                "direction tells the place; use another method"
            )
        with precise(bits):
            size = self.exact(plane.length)(bits)
            first, second = (self.exact(e)(bits) / size for e in plane.direction)
            return first, second


DIGITS = 50
"""To so many a rational fraction is recognised."""
MOST = 1000
"""Denominators up to this."""


@dataclass(frozen=True)
class Turn:
    """What an angle grows by in a period.

    ``advance`` in radians; ``fraction`` is a fraction whose denominator is at most 1000 and with
    which advance / (2 pi) agrees to 50 digits: the curve is likely closed then, which is no proof.
    """

    advance: float
    fraction: Fraction | None = None


def turns_of(form: InvertedMotion) -> dict[str, Turn]:
    """The turns of all angles by name; none where there is no period."""
    if form.rests:
        return {}
    with precise(SHARP):
        advances = form.solution.constants(SHARP).advances
        if advances is None:
            return {}
        pairs = zip(form.quadratures.angles, advances, strict=False)
        return {plain_name(q): turn_of(a) for q, a in pairs}


def turn_of(advance: Any) -> Turn:
    """The turn by an advance, a ball: a fraction of 2 pi where the ball is that to many digits."""
    fraction = _fraction(advance)
    if fraction is not None:  # the advance is that of the fraction, to the last bit of a double
        advance = 2 * ball(1).pi() * fraction.numerator / fraction.denominator
    return Turn(float(advance), fraction)


def _fraction(advance: Any) -> Fraction | None:
    whole = advance / (2 * ball(1).pi())
    mantissa, exponent = whole.mid().man_exp()
    middle = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    near = middle.limit_denominator(MOST)
    off = abs(whole - ball(near.numerator) / near.denominator)
    return near if off < ball(10) ** -DIGITS else None
