"""Taylor coefficients of the motion in any precision: a program as recurrences on integers.

With c_k the coefficients of h^k, every operation has a recurrence, such as

    (a b)_k = sum_i a_i b_(k-i),   (a / b)_k = (a_k - sum_(i>0) b_i (a / b)_(k-i)) / b_0,
    F(a)_k = (1/k) sum_(i>0) i a_i F'(a)_(k-i)   (automatic differentiation).

Numbers are integers in units of 2^-bits: Python multiplies them in place, needs nothing installed,
and a coefficient times h^k is the shorter the higher k, as it should be.
"""

from __future__ import annotations

import hashlib
import linecache
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from math import isqrt
from operator import mul
from typing import Any

import flint

from voronec.algebra.cardinal import coefficient
from voronec.algebra.tape import Tape
from voronec.program.coefficients import Coefficients
from voronec.program.printing import code
from voronec.program.straight import Program

__all__ = ["Recurrences", "fixed", "recurrences"]

Expansion = Callable[[Sequence[int], int, int, int], tuple[list[list[int]], int]]
"""``f(state, t, h, order)``: rows of c_k h^k, k = 0 .. order, for every variable of the state, and
the least absolute value of what was divided by."""


@dataclass(frozen=True)
class Recurrences:
    """``source`` of the expansion; ``constants`` are what parameters alone give, by name."""

    source: str
    constants: dict[str, Any]
    parameters: tuple[Any, ...]

    def expansion(self, values: Sequence[Any], bits: int) -> Expansion:
        """The compiled expansion at parameters, in units of 2^-bits."""
        filename = f"<voronec recurrences {hashlib.sha256(self.source.encode()).hexdigest()[:12]}>"
        lines = self.source.splitlines(keepends=True)
        linecache.cache[filename] = (len(self.source), None, lines, filename)
        point = {str(p): v for p, v in zip(self.parameters, values, strict=True)}
        numbers = self._tape.arb({a: point[str(a)] for a in self._tape.atoms}, bits + 64)
        with flint.ctx.workprec(bits + 64):
            known = {name: fixed(x, bits) for name, x in zip(self.constants, numbers, strict=True)}
        functions: dict[str, Any] = {"mul": mul, "isqrt": isqrt, "apply": _applied(bits)}
        functions["power"] = _powered(bits)
        functions["tangent"] = _tangent(bits)
        functions["composed"] = partial(_Composed, bits)
        namespace: dict[str, Any] = {"P": bits, "ONE": 1 << bits, **functions, **known}
        exec(code(self.source, filename), namespace)
        return namespace["expand"]

    @cached_property
    def _tape(self) -> Tape:
        return Tape(list(self.constants.values()))


def fixed(ball: Any, bits: int) -> int:
    """The middle of a ball in units of 2^-bits; ``ValueError`` where it is not finite."""
    if not ball.is_finite():
        raise ValueError("not a finite number")
    mantissa, exponent = map(int, ball.mid().man_exp())
    shift = exponent + bits
    return mantissa << shift if shift >= 0 else mantissa >> -shift


def _ball(number: int, bits: int) -> Any:
    return flint.arb(number) * flint.arb(2) ** -bits


def _applied(bits: int) -> Callable[..., int]:
    def apply(name: str, *numbers: int) -> int:
        with flint.ctx.workprec(bits + 32 + max(n.bit_length() for n in numbers)):
            balls = [_ball(n, bits) for n in numbers]
            return fixed(getattr(flint.arb, name)(*balls), bits)

    return apply


def _tangent(bits: int) -> Callable[[int], int]:
    apply, one = _applied(bits), 1 << bits

    def tangent(number: int) -> int:
        """tanh; where it is 1 to the last digit it is flat, and no rounding is to grow in it."""
        found = apply("tanh", number)
        return found if one - abs(found) > 1 else (one if number > 0 else -one)

    return tangent


class _Composed:
    """Coefficients of F(w) = f(w)/w, f(0) = 0, from those of w and of f(w), as they come.

    For |w_0| < 1, where to divide loses digits, F is expanded at w_0 and (w - w_0)^j put in.
    """

    def __init__(self, bits: int, name: str, w: list[int], above: list[int]) -> None:
        self.bits, self.name, self.w, self.above = bits, name, w, above
        self.near = abs(w[0]) < 1 << bits
        self.found: list[int] = []
        self.slopes: list[int] = []
        self.powers: list[list[int]] = []

    def entry(self, k: int) -> int:
        """The coefficient of order k; lower ones were asked for before."""
        self.found.append(self._expanded(k) if self.near else self._divided(k))
        return self.found[k]

    def _divided(self, k: int) -> int:
        inner = sum(map(mul, self.w[1:], self.found[::-1]))
        return ((self.above[k] << self.bits) - inner) // self.w[0]

    def _expanded(self, k: int) -> int:
        """sum_j F_j [(w - w_0)^j]_k; of the power j all that is below order j vanishes."""
        self.slopes.append(coefficient(self.name, self.w[0], k, self.bits))
        if k == 0:
            return self.slopes[0]
        self.powers.append([0] * k)
        self.powers[0].append(self.w[k])
        for j in range(1, k):
            lower = self.powers[j - 1]
            terms = (self.w[i] * lower[k - i] for i in range(1, k - j + 1))
            self.powers[j].append(sum(terms) >> self.bits)
        return sum(map(mul, self.slopes[1:], [p[k] for p in self.powers])) >> self.bits


def _powered(bits: int) -> Callable[[int, int, int], int]:
    def power(number: int, p: int, q: int) -> int:
        with flint.ctx.workprec(bits + 32 + number.bit_length()):
            exponent = flint.arb(flint.fmpq(p, q))
            return fixed(_ball(number, bits) ** exponent, bits)

    return power


def recurrences(program: Program) -> Recurrences:
    """The recurrences of a program; ``EngineLimit`` for a function that has none here."""
    tape = Coefficients()
    tape.moving = {*program.state, program.time}
    for i, symbol in enumerate(program.state):
        tape.known[symbol] = f"y{i}"
    tape.known[program.time] = "s"
    for name, expr in program.derivative.assignments:
        tape.assign(name, expr)
    results = [tape.term(r) for r in program.derivative.results]
    return Recurrences(tape.source(results), tape.constants, tuple(program.parameters))
