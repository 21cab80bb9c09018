"""The roots of f as certified balls, and the two real ones between which x moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

from flint import acb, acb_poly, arb, arb_poly, ctx

from voronec.elliptic.constants import Numbers, Source
from voronec.errors import DefinitionError, EngineLimit

MORE = 8
"""How many times the precision flint may work with: roots that nearly agree need it."""


def isolations(polynomial: acb_poly) -> Iterator[list[acb]]:
    """Isolating balls of all roots, narrower ones each time: for who asks again.

    There may be none, where the roots cannot be told apart at the present precision.
    """
    for narrow in (None, 2.0**-40, arb(2) ** (-ctx.prec // 4), arb(2) ** (-ctx.prec // 2)):
        try:
            yield polynomial.roots(tol=narrow, maxprec=MORE * ctx.prec)
        except ValueError:
            break


FIRST_BITS = 64
"""At first: hardly dearer than doubles, and enough for nearly all motions."""
MOST_BITS = 1 << 13
"""Beyond this, or eight times what was asked for, no decision is tried again."""

Value = TypeVar("Value")


class OpenDecision(Exception):
    """A decision that more bits may settle; the message says which."""


@dataclass(frozen=True)
class Root:
    """A root of f.

    Attributes:
        value: a real ball, or a complex one that is surely not real.
        times: its multiplicity.
    """

    value: arb | acb
    times: int

    @property
    def real(self) -> bool:
        """Whether it is real."""
        return isinstance(self.value, arb)


@dataclass(frozen=True)
class Ends:
    """Where x moves.

    Attributes:
        lower: the real root below, of which x comes near (or which it reaches).
        upper: the real root above.
        roots: all finite roots of f, real ones first and ascending.
        start: the end at which x starts, exactly; None if it starts between them.
        at_rest: x stays at the multiple root ``start`` (both ends are that root).
    """

    lower: Root
    upper: Root
    roots: tuple[Root, ...]
    start: Root | None
    at_rest: bool


def ends_of(source: Source, bits: int = FIRST_BITS) -> Ends:
    """The roots of f and the interval of x alone, at the least precision that decides them.

    ``source`` gives the numbers of the problem at any precision, in bits; ``bits`` is the first one
    that is tried, then twice as many.

    Raises:
        DefinitionError: there is no real motion, or x is not between two roots.
        EngineLimit: two roots could not be told apart.
    """
    return resolve(lambda working: interval(source(working)), bits)


def resolve(work: Callable[[int], Value], bits: int) -> Value:
    """The result of ``work`` at the first of ``bits``, twice as many, ... at which it decides.

    Raises:
        EngineLimit: it did not at the most that are tried.
    """
    reason = ""
    before = ctx.prec
    most = max(MOST_BITS, 8 * bits)
    try:
        while bits <= most:
            ctx.prec = bits
            try:
                return work(bits)
            except (OpenDecision, ZeroDivisionError) as undecided:
                reason = str(undecided)
            bits *= 2
    finally:
        ctx.prec = before
    raise EngineLimit(f"undecided at {most} bits: {reason}")


def coefficients(numbers: Numbers) -> list[arb]:
    """The coefficients of f, ascending, five of them."""
    product = arb_poly([1 if numbers.factors else 0])
    for factor, times in numbers.factors:
        product *= arb_poly(list(factor)) ** times
    values = list(product.coeffs())
    if len(values) > 5:
        raise DefinitionError(
            f"f has degree {len(values) - 1}: only degrees up to 4 have elliptic integrals"
        )
    return values + [arb(0)] * (5 - len(values))


def value_at(numbers: Numbers, x: arb | acb) -> arb | acb:
    """f(x), through its factors, so that it is small only where it must be."""
    value = x * 0 + (1 if numbers.factors else 0)
    for factor, times in numbers.factors:
        part = x * 0
        for coefficient in reversed(factor):
            part = part * x + coefficient
        value *= power(part, times)
    return value


def all_roots(numbers: Numbers) -> tuple[Root, ...]:
    """The finite roots of f, real ones first and ascending; all of them surely distinct.

    Raises:
        OpenDecision: two could not be told apart.
    """
    roots: list[Root] = []
    for factor, times in numbers.factors:
        if len(factor) > 1:
            roots += [Root(value, times) for value in _factor_roots(factor)]
    real = sorted((root for root in roots if root.real), key=lambda root: root.value.mid())
    for one, next_one in pairwise(real):
        if not one.value < next_one.value:
            raise OpenDecision(f"two roots near x = {one.value.str(5, radius=False)} may be equal")
    return (*real, *(root for root in roots if not root.real))


def interval(numbers: Numbers) -> Ends:
    """The interval of x at the precision of the numbers.

    Raises:
        OpenDecision: more bits are needed.
        DefinitionError: there is no real motion, or x is not between two roots.
    """
    coefficient = coefficients(numbers)
    _contradiction(numbers)
    if not numbers.factors:
        anywhere = Root(numbers.place, 0)
        return Ends(anywhere, anywhere, (), anywhere, True)
    roots = all_roots(numbers)
    real = tuple(root for root in roots if root.real)
    if numbers.at_rest or numbers.rate.is_zero():
        start = _start(numbers, real)
        if start.times > 1:
            return Ends(start, start, roots, start, True)
        if numbers.at_rest:
            raise DefinitionError(
                f"x does not rest at {show_ball(numbers.place)}: that root of f is simple"
            )
        place = real.index(start)
        rises = arb_poly(coefficient).derivative()(start.value)
        if not (rises > 0 or rises < 0):
            raise OpenDecision(f"a root near x = {show_ball(start.value)} may be double")
        lower, upper = (place, place + 1) if rises > 0 else (place - 1, place)
    else:
        start = None
        below = [_below(root, numbers.place) for root in real]
        lower, upper = sum(below) - 1, sum(below)
    if lower < 0 or upper >= len(real):
        side = "below" if lower < 0 else "above"
        raise DefinitionError(
            f"x is not bounded: f has no root {side} x = {show_ball(numbers.place)}; "
            "choose a variable that moves between two roots"
        )
    return Ends(real[lower], real[upper], roots, start, False)


def power(value: arb | acb, exponent: int) -> arb | acb:
    """A power of a ball as a product: flint's own is no number for a ball around 0."""
    result = value * 0 + 1
    for _ in range(exponent):
        result *= value
    return result


def show_ball(value: arb) -> str:
    """A ball as a short number."""
    return str(value.str(6, radius=False))


def _below(root: Root, place: arb) -> bool:
    if root.value < place:
        return True
    if root.value > place:
        return False
    raise OpenDecision(f"x = {show_ball(place)} may be a root of f, with a rate that may be 0")


def _start(numbers: Numbers, real: tuple[Root, ...]) -> Root:
    near = [root for root in real if root.value.overlaps(numbers.place)]
    if len(near) > 1:
        raise OpenDecision(f"two roots of f are near x = {show_ball(numbers.place)}")
    if not near:
        raise DefinitionError(
            f"the rate is 0 where f is not: x = {show_ball(numbers.place)} is no root of f"
        )
    return near[0]


def _contradiction(numbers: Numbers) -> None:
    value = value_at(numbers, numbers.place)
    square = numbers.rate * numbers.rate
    if value < 0:
        raise DefinitionError(
            f"no real motion: (dx/dt)^2 = {show_ball(value)} < 0 at x = {show_ball(numbers.place)}"
        )
    if not value.overlaps(square):
        raise DefinitionError(
            f"the start contradicts itself: (dx/dt)^2 = {show_ball(square)} by the rate, "
            f"{show_ball(value)} by f at x = {show_ball(numbers.place)}"
        )


def _factor_roots(factor: tuple[arb, ...]) -> list[arb | acb]:
    """The roots of a squarefree factor, refined as far as the precision goes."""
    if factor[-1].contains(0):
        raise OpenDecision("the leading coefficient of f may be 0")
    polynomial = acb_poly([acb(value) for value in factor])
    # Isolating balls may be too wide for the method of Newton: then narrower ones.
    for balls in isolations(polynomial):
        try:
            return [_sharp(factor, polynomial, balls, place) for place in range(len(balls))]
        except OpenDecision:
            continue
    raise OpenDecision("two roots of f may be equal")


def _sharp(
    factor: tuple[arb, ...], polynomial: acb_poly, balls: list[acb], place: int
) -> arb | acb:
    """One root from the isolating balls of all, real where it is."""
    ball = balls[place]
    if not ball.imag.contains(0):
        return _refine_root(polynomial, ball)
    others = (other for at, other in enumerate(balls) if at != place)
    if any(ball.conjugate().overlaps(other) for other in others):
        raise OpenDecision("two roots of f may be equal or complex")
    # Its conjugate is a root in the mirrored ball, hence itself: it is real.
    return _refine_root(arb_poly(list(factor)), ball.real)


def _refine_root(polynomial: arb_poly | acb_poly, ball: arb | acb) -> arb | acb:
    """The root in an isolating ball, by the interval method of Newton."""
    derivative = polynomial.derivative()
    for _ in range(60):
        middle = ball.mid()
        step = derivative(ball)
        if step.contains(0):
            raise OpenDecision("two roots of f may be equal")
        better = middle - polynomial(middle) / step
        if not better.overlaps(ball):
            raise OpenDecision("a root of f needs more bits")
        if not better.rad() * 2 < ball.rad():
            ball = better if better.rad() < ball.rad() else ball
            floor = (polynomial(middle) / derivative(middle)).rad() + _last_bit(middle)
            if ball.rad() > 16 * floor:
                raise OpenDecision("the method of Newton needs a narrower ball")
            return ball
        ball = better
    return ball


def _last_bit(value: arb | acb) -> arb:
    return abs(value).abs_upper() * arb(2) ** -ctx.prec
