"""The sums of the theta functions as rigorous balls, real or complex, and the phase of a pole."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from flint import acb, arb, ctx

from voronec.elliptic.roots import OpenDecision, power

__all__ = ["Sums", "phase"]

Term = Callable[[int], arb | acb]
Power = Callable[[int], int]
ONE = arb(1)


@dataclass(frozen=True)
class Sums:
    """The functions s, its derivative and c of ``voronec.elliptic.constants``.

    Attributes:
        kind: as there.
        nome: as there.
        partner: as there.
    """

    kind: str
    nome: arb
    partner: str

    def s(self, z: arb | acb) -> arb | acb:
        """The odd sum."""
        if self.kind == "rational":
            return z
        if self.kind == "exponential":
            return (z / 2).exp()
        odd = _sin if self.kind == "trigonometric" else _sinh
        # |sin kz| <= k |z| exp(k growth), so that the rest is small beside a small sum
        small = ONE.min(z.abs_upper())
        return self._sum(z, lambda n: (-1) ** n * odd((2 * n + 1) * z), _triangle, small)

    def slope(self, z: arb | acb) -> arb | acb:
        """The derivative of s."""
        if self.kind == "rational":
            return z * 0 + 1
        if self.kind == "exponential":
            return (z / 2).exp() / 2
        even = _cos if self.kind == "trigonometric" else _cosh
        return self._sum(z, lambda n: (-1) ** n * (2 * n + 1) * even((2 * n + 1) * z), _triangle)

    def zeta(self, z: arb | acb) -> arb | acb:
        """``s'/s``."""
        return self.slope(z) / self.s(z)

    def bend(self, z: arb | acb) -> arb | acb:
        """The derivative of ``s'/s``."""
        if self.kind == "rational":
            return -1 / (z * z)
        odd, turns = (_sin, -1) if self.kind == "trigonometric" else (_sinh, 1)
        second = self._sum(
            z, lambda n: turns * (-1) ** n * (2 * n + 1) ** 2 * odd((2 * n + 1) * z), _triangle
        )
        return second / self.s(z) - power(self.zeta(z), 2)

    def c(self, z: arb | acb) -> arb | acb:
        """The partner."""
        if self.partner == "one":
            return z * 0 + 1
        if self.partner == "inverse":
            return (-z / 2).exp()
        if self.partner == "theta4":
            return self._sum(
                z, lambda n: (-1) ** n * (2 if n else 1) * _cosh(2 * n * z), lambda n: n * n
            )
        even = _cos if self.kind == "trigonometric" else _cosh
        return self._sum(z, lambda n: even((2 * n + 1) * z), _triangle)

    def fall(self, z: arb | acb) -> arb | acb:
        """The derivative of c."""
        if self.partner == "one":
            return z * 0
        if self.partner == "inverse":
            return -(-z / 2).exp() / 2
        if self.partner == "theta4":
            return self._sum(z, lambda n: (-1) ** n * 4 * n * _sinh(2 * n * z), lambda n: n * n)
        odd, turns = (_sin, -1) if self.kind == "trigonometric" else (_sinh, 1)
        return self._sum(z, lambda n: turns * (2 * n + 1) * odd((2 * n + 1) * z), _triangle)

    def _sum(self, z: arb | acb, term: Term, power: Power, small: arb = ONE) -> arb | acb:
        """Sum of ``nome^(power/2)`` times the term, and a ball for the rest of the series."""
        if self.nome.is_zero():
            return term(0)
        count = self._count(z)
        total = z * 0
        for n in range(count):
            total += _nome_power(self.nome, power(n)) * term(n)
        tail = arb(0, (small * self._bound(z, count)).upper())
        return total + (acb(tail, tail) if isinstance(z, acb) else tail)

    def _growth(self, z: arb | acb) -> arb:
        """An upper bound of the exponent by which sin z or sinh z grows."""
        if isinstance(z, acb):
            part = z.imag if self.kind == "trigonometric" else z.real
            return part.abs_upper()
        return arb(0) if self.kind == "trigonometric" else z.abs_upper()

    def _count(self, z: arb | acb) -> int:
        growth, decay = float(self._growth(z)), -float(self.nome.abs_upper().log())
        if not (math.isfinite(growth) and decay > 0):
            raise OpenDecision("a sum needs more bits")
        below = ctx.prec * math.log(2) + 10
        n = 1
        while n * n / 2 * decay - 2 * (n + 1) * growth < below or n * decay < 2 * growth + 2:
            n += 1
        return n

    def _bound(self, z: arb | acb, count: int) -> arb:
        """The rest from ``count`` on: twice its first term, at least, in absolute value.

        Each term is below ``2 (2n+1)^2 |r|^(n^2/2) exp((2n+1) growth)``; the ratio of two
        successive ones is below ``(25/9) |r|^n exp(2 growth) < 1/2``, by the choice of ``count``.
        """
        size = self.nome.abs_upper()
        first = _nome_power(size, count * count) * ((2 * count + 1) * self._growth(z)).exp()
        return (4 * (2 * count + 1) ** 2 * first).upper()


def phase(sums: Sums, z: arb, alpha: arb, sign: int) -> arb:
    """``arg s(z - i alpha)`` continued from ``-sign pi/2`` at z = 0, within half a period.

    Raises:
        Unresolved: the balls are too wide.
    """
    if alpha.is_zero():
        if z.is_zero() or z > 0:
            return arb(0)
        if z < 0:
            return -sign * arb.pi()
        raise OpenDecision("the moment is that of a passage through a pole, or very near it")
    value = sums.s(acb(z, -alpha))
    if sums.kind == "trigonometric":
        turned = value * acb(0, sign) * acb(0, -sign * z).exp()
        part = _arctangent(turned.imag, turned.real)
        return sign * (z - arb.pi() / 2) + part
    return sign * (_arctangent(value.real, -sign * value.imag) - arb.pi() / 2)


def _arctangent(across: arb, along: arb) -> arb:
    """The angle in (-pi/2, pi/2) of a direction with ``along > 0``."""
    if not along > 0:
        raise OpenDecision("the angle of a pole needs more bits")
    return (across / along).atan()


def _nome_power(nome: arb, halves: int) -> arb:
    """``nome^(halves/2)``; a half power only of a positive nome."""
    return nome ** (halves // 2) if halves % 2 == 0 else nome.sqrt() ** halves


def _triangle(n: int) -> int:
    return n * (n + 1)


def _sin(z: arb | acb) -> arb | acb:
    return z.sin()


def _cos(z: arb | acb) -> arb | acb:
    return z.cos()


def _sinh(z: arb | acb) -> arb | acb:
    return z.sinh()


def _cosh(z: arb | acb) -> arb | acb:
    return z.cosh()
