r"""What an inversion is given - a polynomial, a start, integrals along the motion - and everything
of the inverted motion that does not depend on time, as real balls.

The sums, with ``r`` the nome and ``z = scale (t - turn)``::

    trigonometric   s(z) = sum (-1)^n r^(n(n+1)/2) sin((2n+1) z)
    hyperbolic      s(z) = sum (-1)^n r^(n(n+1)/2) sinh((2n+1) z)
    rational        s(z) = z
    exponential     s(z) = exp(z/2)

    partner "theta2"   c(z) = sum r^(n(n+1)/2) cos((2n+1) z)     (cosh if hyperbolic)
    partner "theta4"   c(z) = 1 + 2 sum_(n>=1) (-1)^n r^(n^2/2) cosh(2n z)  (hyperbolic, r >= 0)
    partner "one"      c(z) = 1            (rational)
    partner "inverse"  c(z) = exp(-z/2)    (exponential)

and ``x = (base K c^2 + other s^2)/(K c^2 + s^2)`` with ``K = mean`` in every kind
[Theory, eq. (25)]. A half
period is ``z = pi/2`` if trigonometric and ``z = H`` if hyperbolic, where
``r = exp(-4 H)`` with "theta4" and ``r = -exp(-2 H)`` with "theta2"; there c vanishes. With
``y = H - z`` it is ``c(z) = 2 exp(-y) s(y)`` ("theta4") or ``exp(H - 2 y) s(y)`` ("theta2"),
without cancellation near the other end.

The phase of a pole, ``phi(z) = arg s(z - i alpha)`` (z counted from the turning point of its
side, continuous, ``phi(0) = -sign pi/2``), for one period ``|z| <=`` half::

    trigonometric   phi = sign (z - pi/2) + arg(i sign s(z - i alpha) exp(-i sign z))
    the others      phi = sign (-pi/2 + atan(Re s(z - i alpha)/(-sign Im s(z - i alpha))))

and ``phi`` grows by ``gain`` with every period. At ``alpha = 0`` it jumps by ``pi sign`` at
z = 0, where the value after the jump is taken: ``phi(0) = 0`` for ``sign = 1``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from flint import acb, arb


@dataclass(frozen=True)
class Pole:
    """A pole of the integrands, on the x line.

    Attributes:
        place: where the integrand is infinite; a complex place (``acb``) adds the real part of
            its term, so that a conjugate pair is two poles with conjugate shares (or one with
            twice the share).
        weight: the signed ``w`` with ``f(place) = -4 w^2`` exactly, so that the integral of
            ``w/(x - place)`` is an angle; exactly ``arb(0)`` where the place is a root of
            ``f``; None for a pole of any other kind.
    """

    place: arb | acb
    weight: arb | None = None


@dataclass(frozen=True)
class Integral:
    """The integrand ``constant + linear x + square x^2 + sum of share_c w_c/(x - c)``.

    Attributes:
        constant: of the polynomial part.
        linear: of the polynomial part.
        square: of the polynomial part.
        shares: one per pole: an ``int`` (usually -1, 0 or 1) where the pole has a weight,
            else the number over ``x - c`` itself, an ``arb`` or ``acb``.
    """

    constant: arb
    linear: arb
    square: arb
    shares: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Numbers:
    """An inversion problem ``(dx/dt)^2 = f(x)`` at some precision.

    Attributes:
        factors: squarefree coprime factors of ``f``, coefficients ascending with a nonzero
            leading one, and their multiplicities; usually ``((c0, .., c4), 1)`` alone.
            None at all where f vanishes everywhere.
        place: x at t = 0.
        rate: dx/dt at t = 0; exactly ``arb(0)`` at a turning point.
        poles: the poles of the integrands.
        integrals: the integrands.
        at_rest: x stays at a multiple root.
    """

    factors: tuple[tuple[tuple[arb, ...], int], ...]
    place: arb
    rate: arb
    poles: tuple[Pole, ...] = ()
    integrals: tuple[Integral, ...] = ()
    at_rest: bool = False


Source = Callable[[int], Numbers]
"""The numbers of one exact problem at any number of bits; the caller sets flint's ``ctx.prec``."""


@dataclass(frozen=True)
class ThetaPhase:
    """The angle that one pole adds to the integrals.

    Attributes:
        side: 0 where z is counted from the turning point at ``base``, 1 from the one at
            ``other``, half a period later (each side reduced to its own nearest period).
        alpha: imaginary part of the pole in z, signed.
        sign: of alpha; 1 where alpha is exactly 0.
        gain: what the phase grows by in one period; None if there is no period.
        shares: one per integral, the factor of this phase: an ``int`` at a pole with a
            weight, else an ``arb``.
        pole: its number among the poles of the problem, None for infinity.
    """

    side: int
    alpha: arb
    sign: int
    gain: arb | None
    shares: tuple[int | arb, ...]
    pole: int | None = None


@dataclass(frozen=True)
class LogTerm:
    """The part of the integrals with logarithms and zeta functions: no whole angle.

    It adds to integral j the real part of ``logs_j log(s(z - a)/s(z + a)) +
    zetas_j (s'(z - a)/s(z - a) + s'(z + a)/s(z + a))`` with ``a = place`` and z counted from
    the turning point of ``side``; the logarithm is continuous along real z: its imaginary
    part is ``phi(z - Re a) + phi(z + Re a)`` with the phase of ``alpha = Im a`` (see the head
    of the module). For the kind "exponential", ``s`` is sinh here and the terms with
    ``z + a`` are absent.

    Attributes:
        side: 0 or 1, as of a phase.
        place: the pole in z.
        logs: one per integral.
        zetas: one per integral.
        gains: what this part of each integral grows by in one period; None if there is none.
        pole: its number among the poles of the problem, None for infinity.
    """

    side: int
    place: acb
    logs: tuple[acb, ...]
    zetas: tuple[acb, ...]
    gains: tuple[arb, ...] | None
    pole: int | None = None


@dataclass(frozen=True)
class Constants:
    """An inverted motion: what is needed to evaluate it at any time.

    ``I_j(t) = rates_j (t - turn) + sum of share phi(z) + log terms + (p + q x) dx/dt - starts_j``,
    with ``(p, q) = bounded_terms_j``.

    Attributes:
        kind: "trigonometric", "hyperbolic", "rational", "exponential" (both ends are double
            roots) or "rest".
        base: x at the time ``turn``, a turning point (kind "exponential": the limit of x
            long ago, and ``turn`` is when x is in the middle).
        other: x half a period later, or its limit.
        turn: the time of the turning point at ``base`` nearest to t = 0; exactly 0 where the
            motion starts at it.
        half: half of the period, None where it is infinite.
        scale: ``z = scale (t - turn)``.
        nome: r, real and signed, ``|r| < 0.0434``; 0 in the elementary limits.
        mean: K.
        partner: "theta2", "theta4", "one" or "inverse": which sum c is.
        phases: of the poles that turn the integrals (poles that add nothing are left out).
        log_terms: the logarithms and zeta functions.
        bounded_terms: one pair per integral; zeros but for a polynomial part where f has degree
            2 or 3.
        rates: one per integral: the whole linear rate, all shifts included.
        advances: of each integral per period, None where the period is infinite.
        starts: the value of each integral's expression at t = 0.
        roots: of f, each as often as it is repeated, finite ones only.
        invariants: g2, g3 and the discriminant ``g2^3 - 27 g3^2``.
    """

    kind: str
    base: arb
    other: arb
    turn: arb
    half: arb | None
    scale: arb
    nome: arb
    mean: arb
    partner: str
    phases: tuple[ThetaPhase, ...]
    log_terms: tuple[LogTerm, ...]
    bounded_terms: tuple[tuple[arb, arb], ...]
    rates: tuple[arb, ...]
    advances: tuple[arb, ...] | None
    starts: tuple[arb, ...]
    roots: tuple[acb, ...]
    invariants: tuple[arb, arb, arb]
