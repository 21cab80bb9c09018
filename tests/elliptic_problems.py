"""Inversion problems with known roots and poles, for the tests of ``voronec.elliptic``."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest
from flint import acb, arb, ctx, fmpq

from voronec.elliptic import Integral, Numbers, Pole

ONE_EACH = ("0.1 0 0", "0 1 0", "0 0 1", "0.2 -0.3 0.4")
SHARE = "0.7"
PAIR_SHARE = ("0.7", "0.4")


def working_precision(bits):
    """A fixture: the tests of a module compute with so many bits."""

    @pytest.fixture(autouse=True)
    def fixture():
        before = ctx.prec
        ctx.prec = bits
        yield
        ctx.prec = before

    return fixture


def ball(value):
    exact = Fraction(value)
    return arb(fmpq(exact.numerator, exact.denominator))


def number(value):
    return acb(ball(value[0]), ball(value[1])) if isinstance(value, tuple) else ball(value)


def times(one, two):
    product = [arb(0)] * (len(one) + len(two) - 1)
    for i, a in enumerate(one):
        for j, b in enumerate(two):
            product[i + j] += a * b
    return product


def evaluated(coefficients, x):
    value = x * 0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


def f_at(numbers, x):
    value = x * 0 + 1
    for factor, power in numbers.factors:
        value *= evaluated(factor, x) ** power
    return value


def problem(
    lead, place, sign, roots="", pairs=(), double="", triple="",
    weighted=(), general=(), polynomials=(), rest=False,
):  # fmt: skip
    """The source of ``lead`` times the factors of these roots, with x at ``place``.

    ``pairs`` are complex roots (real and imaginary part); ``weighted`` maps places to the sign of
    their weight, 0 for a root of f; ``general`` has places without weights, complex ones as
    real and imaginary part.
    One integral for each pole and one for each of ``polynomials`` (constant, linear, square).
    """

    def factors():
        simple = [ball(lead)]
        for root in roots.split():
            simple = times(simple, [-ball(root), arb(1)])
        for re, im in pairs:
            simple = times(simple, [ball(re) ** 2 + ball(im) ** 2, -2 * ball(re), arb(1)])
        yield tuple(simple), 1
        for power, places in ((2, double), (3, triple)):
            repeated = [arb(1)]
            for root in places.split():
                repeated = times(repeated, [-ball(root), arb(1)])
            if len(repeated) > 1:
                yield tuple(repeated), power

    def source(bits):
        bare = Numbers(tuple(factors()), ball(place), arb(0))
        poles = [
            Pole(ball(c), arb(0) if w == 0 else w * (-f_at(bare, ball(c))).sqrt() / 2)
            for c, w in dict(weighted).items()
        ]
        poles += [Pole(number(c)) for c in general]
        none = [0 if pole.weight is not None else arb(0) for pole in poles]
        integrals = []
        for at, pole in enumerate(poles):
            share = number(PAIR_SHARE if isinstance(pole.place, acb) else SHARE)
            shares = [*none[:at], 1 if pole.weight is not None else share, *none[at + 1 :]]
            integrals.append(Integral(arb(0), arb(0), arb(0), tuple(shares)))
        for polynomial in polynomials:
            integrals.append(Integral(*map(ball, polynomial.split()), tuple(none)))
        rate = sign * f_at(bare, bare.place).sqrt() if sign else arb(0)
        return Numbers(bare.factors, bare.place, rate, tuple(poles), tuple(integrals), rest)

    return source


def integrand(numbers, integral, x):
    """An integrand at x, by its definition."""
    value = integral.constant + integral.linear * x + integral.square * x**2
    for pole, share in zip(numbers.poles, integral.shares, strict=True):
        if isinstance(pole.place, acb):
            value += (share / (x - pole.place)).real
        else:
            value += share * (1 if pole.weight is None else pole.weight) / (x - pole.place)
    return value


def worst_residual(solution, moments):
    """How far the enclosures are from the equations, by central differences of 10^-10.

    The largest of ``dx/dt - rate``, ``rate^2 - f(x)`` and ``dI/dt - integrand``, relative to
    what is compared where that is above 1; their own error is about 10^-20 of third derivatives.
    """
    step = Fraction(1, 10**10)
    worst = 0.0
    for moment in map(Fraction, moments):
        before, at, after = (solution.enclose(moment + k * step, 50) for k in (-1, 0, 1))
        with_bits = ctx.prec
        try:
            ctx.prec = 300
            numbers = solution.source(300)
            pairs = [((after.x - before.x) / (2 * ball(step)), at.rate)]
            pairs.append((at.rate**2, f_at(numbers, at.x)))
            for j, integral in enumerate(numbers.integrals):
                slope = (after.integrals[j] - before.integrals[j]) / (2 * ball(step))
                pairs.append((slope, integrand(numbers, integral, at.x)))
            found = [abs(float((a - b) / (1 + abs(b)))) for a, b in pairs]
        finally:
            ctx.prec = with_bits
        worst = max([worst, *found])
    return worst


def steps(values):
    return [b - a for a, b in pairwise(values)]
