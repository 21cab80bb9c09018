"""Taylor coefficients of the motion in any precision: a program as recurrences on integers.

With c_k the coefficients of h^k, every operation has a recurrence, such as

    (a b)_k = sum_i a_i b_(k-i),   (a / b)_k = (a_k - sum_(i>0) b_i (a / b)_(k-i)) / b_0,
    F(a)_k = (1/k) sum_(i>0) i a_i F'(a)_(k-i)   (automatic differentiation).

Numbers are integers in units of 2^-bits: Python multiplies them in place, needs nothing installed,
and a coefficient times h^k is the shorter the higher k, as it should be.

With c_k the coefficient of h^k times h^k, all in units of 2^-P. See
``voronec.equations.program.recurrences``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from math import isqrt
from operator import mul
from typing import Any

import flint
import symengine as se

from voronec.algebra.cardinal import coefficient
from voronec.algebra.memo import remember
from voronec.algebra.numeric_functions import (
    FORMULAS,
    HYPOT,
    QUOTIENTS,
    REACH,
    SIZE,
    numeric_name,
)
from voronec.algebra.tape import Tape
from voronec.equations.program.dialect import TERMS, execute, rational, rewrite
from voronec.equations.program.straight import Program
from voronec.errors import EngineLimit

_CURVES = (se.sin, se.sinh, se.cos, se.cosh)


@dataclass
class Coefficients:
    """Lists of coefficients by name, with a line for order 0 and one for the higher orders."""

    moving: set[Any] = field(default_factory=set)
    known: dict[Any, str] = field(default_factory=dict)
    constants: dict[str, Any] = field(default_factory=dict)
    still: dict[Any, Any] = field(default_factory=dict)
    numbers: dict[Any, str] = field(default_factory=dict)
    first: list[str] = field(default_factory=list)
    later: list[str] = field(default_factory=list)
    divisors: list[str] = field(default_factory=list)
    factors: dict[tuple[str, str], None] = field(default_factory=dict)
    helpers: dict[tuple[str, str], str] = field(default_factory=dict)
    count: int = 0

    def assign(self, name: Any, expr: Any) -> None:
        """An assignment of the program."""
        if expr.free_symbols & self.moving:
            self.moving.add(name)
            self.known[name] = self.series(expr)
        else:
            self.still[name] = expr.xreplace(self.still)

    @remember("known")
    def series(self, expr: Any) -> str:
        """The list of an expression that moves."""
        if isinstance(expr, se.Add):
            return self._sum(expr)
        if isinstance(expr, se.Mul):
            return self._product(expr)
        if isinstance(expr, se.Pow):
            return self._power(expr)
        other = rewrite(expr)
        if other is not None:
            return self.series(other)
        name = numeric_name(expr)
        if name is not None:
            return self._numeric(name, expr.args)
        return self._function(expr)

    def term(self, expr: Any) -> tuple[str, str]:
        """A right side at order 0 and at order k; a constant has nothing at higher orders."""
        if expr.free_symbols & self.moving:
            name = self.series(expr)
            return f"{name}[0]", f"{name}[k]"
        return self.constant(expr), "0"

    def constant(self, expr: Any) -> str:
        """The name of a number that parameters alone give."""
        value = expr.xreplace(self.still)
        if value not in self.numbers:
            self.numbers[value] = f"K{len(self.numbers)}"
            self.constants[self.numbers[value]] = value
        return self.numbers[value]

    def entry(self, first: str, later: str) -> str:
        """A new list: what it begins with, and its entry of order k."""
        name = f"a{self.count}"
        self.count += 1
        self.first.append(f"{name} = [{first}]")
        self.later.append(f"{name}.append({later})")
        return name

    def reverse(self, name: str) -> str:
        """The list up to order k, backwards."""
        return self._helper("reverse", name, None, f"{name}[::-1]")

    def weigh(self, name: str) -> str:
        """The list i a_i from i = 1 on."""
        return self._helper("weighted", name, "", f"k*{name}[k]")

    def _helper(self, kind: str, name: str, first: str | None, later: str) -> str:
        helper = self.helpers.get((kind, name))
        if helper is None:
            helper = self.helpers[kind, name] = f"{kind[0]}_{name}"
            if first is None:
                self.later.append(f"{helper} = {later}")
            else:
                self.first.append(f"{helper} = [{first}]")
                self.later.append(f"{helper}.append({later})")
        return helper

    def product(self, a: str, b: str) -> str:
        """a b."""
        a, b = sorted((a, b))
        name = self.helpers.get((a, b))
        if name is None:
            self.factors[a, b] = None
            first = f"{a}[0]*{b}[0] >> P"
            if a == b:
                r = self.reverse(a)
                half = f"2*sum(map(mul, {a}[:(k + 1) // 2], {r}))"
                later = f"{half} + (0 if k % 2 else {a}[k // 2]**2) >> P"
            else:
                later = f"sum(map(mul, {a}, {self.reverse(b)})) >> P"
            name = self.helpers[a, b] = self.entry(first, later)
        return name

    def quotient(self, above: tuple[str, str], b: str) -> str:
        """above / b."""
        name = f"a{self.count}"
        self.divisors.append(f"{b}[0]")
        first, later = above
        head = f"({later} << P) - " if later != "0" else "-"
        inner = f"sum(map(mul, {b}[1:], {name}[::-1]))"
        return self.entry(f"({first} << P)//{b}[0]", f"({head}{inner})//{b}[0]")

    def power(self, a: str, p: int, q: int) -> str:
        """a^(p/q): k a_0 c_k = sum_(i>0) (p/q i a_i c_(k-i) - a_i (k-i) c_(k-i))."""
        if q == 1:
            return self._whole(a, p)
        if p < 0:
            return self.quotient(("ONE", "0"), self.power(a, -p, q))
        name = f"a{self.count}"
        self.divisors.append(f"{a}[0]")
        if (p, q) == (1, 2):
            half = f"sum(map(mul, {name}[1:], {name}[:0:-1]))"
            return self.entry(f"isqrt({a}[0] << P)", f"(({a}[k] << P) - {half})//(2*{name}[0])")
        if q == 2:
            return self.product(self.power(a, 1, 2), self._whole(a, p // 2))
        inner = f"sum(({p}*i - {q}*(k - i))*{a}[i]*{name}[k - i] for i in range(1, k + 1))"
        return self.entry(f"power({a}[0], {p}, {q})", f"{inner}//({q}*k*{a}[0])")

    def _whole(self, a: str, p: int) -> str:
        if p < 0:
            return self.quotient(("ONE", "0"), self._whole(a, -p))
        if p == 1:
            return a
        half = self._whole(a, p // 2)
        square = self.product(half, half)
        return self.product(square, a) if p % 2 else square

    def primitive(self, first: str, pairs: Sequence[tuple[str, str, str]]) -> str:
        """A function by its slope: k c_k = sum of +- (i a_i) g_(k-i), given (sign, a, g)."""
        inner = " ".join(
            f"{sign} sum(map(mul, {self.weigh(a)}, {f'{g}[k - 1::-1]'}))" for sign, a, g in pairs
        )
        return self.entry(first, f"({inner} >> P)//k")

    def _sum(self, expr: Any) -> str:
        first, later = [], []
        for argument in expr.args:
            begin, then = self._scale(argument)
            first.append(begin)
            later += [then] if then != "0" else []
        return self.entry(_total(first), _total(later))

    def _scale(self, expr: Any) -> tuple[str, str]:
        """A term of a sum: a small rational factor needs no list of its own."""
        if isinstance(expr, se.Mul) and expr.args[0].is_Number:
            p, q = rational(expr.args[0])
            begin, then = self.term(se.Mul(*expr.args[1:]))
            if then == "0":
                return self.constant(expr), "0"
            over = f"//{q}" if q != 1 else ""
            return f"{p}*{begin}{over}", f"{p}*{then}{over}"
        return self.term(expr)

    def _product(self, expr: Any) -> str:
        still, above, below = [], [], []
        for factor in expr.args:
            if not factor.free_symbols & self.moving:
                still.append(factor)
            elif isinstance(factor, se.Pow) and factor.args[1].is_Number and factor.args[1] < 0:
                below.append(self.series(1 / factor))
            else:
                above.append(self.series(factor))
        scale = self.constant(se.Mul(*still)) if still else ""
        if not above:
            return self.quotient((scale or "ONE", "0"), self._join(below))
        top = self._join(above)
        if scale:
            top = self.entry(f"{scale}*{top}[0] >> P", f"{scale}*{top}[k] >> P")
        return self.quotient((f"{top}[0]", f"{top}[k]"), self._join(below)) if below else top

    def _join(self, names: Sequence[str]) -> str:
        result, *others = names
        for name in others:
            result = self.product(result, name)
        return result

    def _power(self, expr: Any) -> str:
        base, exponent = expr.args
        if exponent.is_Number:
            return self.power(self.series(base), *rational(exponent))
        if base == se.E:
            return self._exp(self.series(exponent))
        return self._exp(self.series(exponent * se.log(base)))

    def _exp(self, a: str) -> str:
        name = f"a{self.count}"
        weighted = self.weigh(a)
        later = f"(sum(map(mul, {weighted}, {name}[::-1])) >> P)//k"
        return self.entry(f"apply('exp', {a}[0])", later)

    def _numeric(self, name: str, args: Sequence[Any]) -> str:
        """What programs alone know; all but quotients by its formula, as nothing overflows here."""
        if name == SIZE:
            a = self.series(args[0])
            sign = f"(1 if {a}[0] >= 0 else -1)"  # |w| at w = 0 is what it is on one of its sides
            return self.entry(f"{sign}*{a}[0]", f"{sign}*{a}[k]")
        if name == HYPOT:
            return self._length(args)
        if name not in QUOTIENTS:
            return self.series(FORMULAS[name](*args))
        return self._quotient_of(name, args[0])

    def _length(self, sides: Sequence[Any]) -> str:
        """The root of a^2 + b^2 + ...: ``_Length`` tells it where all of them vanish, too."""
        moving = [self.series(a) for a in sides if a.free_symbols & self.moving]
        still = [self.constant(a) for a in sides if not a.free_symbols & self.moving]
        made = f"l_a{self.count}"
        self.first.append(f"{made} = length([{', '.join(moving)}], [{', '.join(still)}])")
        self.divisors.append(f"({made}.least or ONE)")
        return self.entry(f"{made}.entry(0)", f"{made}.entry(k)")

    def _quotient_of(self, name: str, w: Any) -> str:
        """sin(w)/w and the like: ``Composed`` divides, or expands where |w| is small."""
        quotient = QUOTIENTS[name]
        a, below, above = (self.series(e) for e in (w, w**quotient.power, quotient.above(w)))
        made = f"c_a{self.count}"
        self.first.append(f"{made} = composed({name!r}, {a}, {below}, {above})")
        return self.entry(f"{made}.entry(0)", f"{made}.entry(k)")

    def _function(self, expr: Any) -> str:
        kind, a = type(expr), self.series(expr.args[0]) if type(expr) is not se.atan2 else ""
        if kind in _CURVES:
            return self._curves(a, "h" if kind in (se.sinh, se.cosh) else "")[
                kind in (se.cos, se.cosh)
            ]
        if kind is se.tan:
            sine, cosine = self._curves(a, "")
            return self.quotient((f"{sine}[0]", f"{sine}[k]"), cosine)
        if kind is se.tanh:
            return self._tangent(a)
        if kind is se.atan2:
            return self._angle(*expr.args)
        if kind in (se.Abs, se.sign):
            sign = f"(({a}[0] > 0) - ({a}[0] < 0))"
            if kind is se.sign:
                return self.entry(f"{sign}*ONE", "0")
            return self.entry(f"{sign}*{a}[0]", f"{sign}*{a}[k]")
        slope = _slope(kind, expr.args[0])
        if slope is None:
            raise EngineLimit(f"'{kind.__name__}' has no recurrence here; use method='scipy'")
        name = kind.__name__
        return self.primitive(f"apply('{name}', {a}[0])", [("", a, self.series(slope))])

    def _curves(self, a: str, kind: str) -> tuple[str, str]:
        """sin and cos of a, or sinh and cosh."""
        if (f"sin{kind}", a) in self.helpers:
            return self.helpers[f"sin{kind}", a], self.helpers[f"cos{kind}", a]
        sine, cosine = f"a{self.count}", f"a{self.count + 1}"
        weighted = self.weigh(a)
        sign = "" if kind else "-"
        # both from orders below k: the cosine must not see what the sine has just got
        self.entry(
            f"apply('sin{kind}', {a}[0])",
            f"(sum(map(mul, {weighted}, {cosine}[::-1])) >> P)//k",
        )
        self.entry(
            f"apply('cos{kind}', {a}[0])",
            f"({sign}sum(map(mul, {weighted}, {sine}[k - 1::-1])) >> P)//k",
        )
        self.helpers[f"sin{kind}", a], self.helpers[f"cos{kind}", a] = sine, cosine
        return sine, cosine

    def _tangent(self, a: str) -> str:
        """tanh a, whose slope is 1 - tanh^2 a: sinh and cosh would overflow."""
        name = f"a{self.count}"
        self.entry(
            f"tangent({a}[0])",
            f"(sum(map(mul, {self.weigh(a)}, s_{name}[::-1])) >> P)//k",
        )
        self.first.append(f"s_{name} = [ONE - ({name}[0]**2 >> P)]")
        self.later.append(f"s_{name}.append(-(sum(map(mul, {name}, {name}[::-1])) >> P))")
        return name

    def _angle(self, y: Any, x: Any) -> str:
        """atan2(y, x): its slope is (x y' - y x')/(x^2 + y^2)."""
        square = x**2 + y**2
        slopes = [
            (sign, self.series(part), self.series(other / square))
            for sign, part, other in (("", y, x), ("-", x, y))
            if part.free_symbols & self.moving
        ]
        above, below = (self.term(part)[0] for part in (y, x))
        return self.primitive(f"apply('atan2', {above}, {below})", slopes)

    def source(self, results: Sequence[tuple[str, str]]) -> str:
        """The function ``expand(state, t, h, order)``."""
        n = len(results)
        rows = ["def expand(state, t, h, order):"]
        rows += [f"    y{i} = [state[{i}]]" for i in range(n)]
        rows += ["    s = [t]", *(f"    {line}" for line in self.first)]
        rows += [f"    r{i} = {first}" for i, (first, _) in enumerate(results)]
        rows += ["    k = 0", "    while True:", "        k += 1"]
        rows += [f"        y{i}.append((r{i}*h >> P)//k)" for i in range(n)]
        rows += ["        if k == order:", "            break"]
        rows += ["        s.append(h if k == 1 else 0)"]
        rows += [f"        {line}" for line in self.later]
        rows += [f"        r{i} = {later}" for i, (_, later) in enumerate(results)]
        least = ", ".join(["ONE", *(f"abs({d})" for d in dict.fromkeys(self.divisors))])
        pairs = ", ".join(f"({a}[0], {b}[0])" for a, b in self.factors if a != b)
        states = ", ".join(f"y{i}" for i in range(n))
        return "\n".join(
            [*rows, f"    return [{states}], min({least}, ONE), magnification([{pairs}])", ""]
        )


def _total(terms: Sequence[str]) -> str:
    """A sum; Python's compiler descends a level for every sign, and for a long list none."""
    return " + ".join(terms) if len(terms) <= TERMS else f"sum(({', '.join(terms)}))"


def _slope(kind: type, x: Any) -> Any | None:
    """The derivative of a function, where it is algebraic."""
    rules: dict[type, Callable[[Any], Any]] = {
        se.log: lambda a: 1 / a,
        se.asin: lambda a: 1 / se.sqrt(1 - a**2),
        se.acos: lambda a: -1 / se.sqrt(1 - a**2),
        se.atan: lambda a: 1 / (1 + a**2),
        se.asinh: lambda a: 1 / se.sqrt(1 + a**2),
        se.acosh: lambda a: 1 / (se.sqrt(a - 1) * se.sqrt(a + 1)),
        se.atanh: lambda a: 1 / (1 - a**2),
    }
    rule = rules.get(kind)
    return rule(x) if rule else None


Expansion = Callable[[Sequence[int], int, int, int], tuple[list[list[int]], int, int]]
"""``f(state, t, h, order)``: rows of c_k h^k, k = 0 .. order, for every variable of the state, the
least absolute value of what was divided by, and the bits before the point of the largest factor."""


@dataclass(frozen=True)
class Recurrences:
    """``source`` of the expansion; ``constants`` are what parameters alone give, by name."""

    source: str
    constants: dict[str, Any]
    parameters: tuple[Any, ...]

    def magnitude(self, values: Sequence[Any]) -> int:
        """Bits before the point of the largest constant, which makes roundings so much larger."""
        numbers = self._numbers(values, 64)
        return max([0, *(fixed_point(x, 0).bit_length() for x in numbers)])

    def expansion(self, values: Sequence[Any], bits: int) -> Expansion:
        """The compiled expansion at parameters, in units of 2^-bits."""
        numbers = self._numbers(values, bits + 64)
        with flint.ctx.workprec(bits + 64):
            known = {
                name: fixed_point(x, bits) for name, x in zip(self.constants, numbers, strict=True)
            }
        functions: dict[str, Any] = {"mul": mul, "isqrt": isqrt, "apply": _ball_function(bits)}
        functions["power"] = _power_function(bits)
        functions["tangent"] = _tangent(bits)
        functions["magnification"] = partial(_magnification, bits)
        functions["composed"] = partial(_Composition, bits)
        functions["length"] = _Length
        names = {"P": bits, "ONE": 1 << bits, **functions, **known}
        expand: Expansion = execute(self.source, "recurrences", names)["expand"]
        return expand

    def _numbers(self, values: Sequence[Any], bits: int) -> list[Any]:
        """The constants in balls."""
        point = {str(p): v for p, v in zip(self.parameters, values, strict=True)}
        return list(self._tape.arb({a: point[str(a)] for a in self._tape.atoms}, bits))

    @cached_property
    def _tape(self) -> Tape:
        return Tape(list(self.constants.values()))


def fixed_point(ball: Any, bits: int) -> int:
    """The middle of a ball in units of 2^-bits; ``ValueError`` where it is not finite."""
    if not ball.is_finite():
        raise ValueError("not a finite number")
    mantissa, exponent = map(int, ball.mid().man_exp())
    shift = exponent + bits
    return mantissa << shift if shift >= 0 else mantissa >> -shift


def _ball(number: int, bits: int) -> Any:
    return flint.arb(number) * flint.arb(2) ** -bits


def _ball_function(bits: int) -> Callable[..., int]:
    def apply(name: str, *numbers: int) -> int:
        with flint.ctx.workprec(bits + 32 + max(n.bit_length() for n in numbers)):
            balls = [_ball(n, bits) for n in numbers]
            return fixed_point(getattr(flint.arb, name)(*balls), bits)

    return apply


def _tangent(bits: int) -> Callable[[int], int]:
    apply, one = _ball_function(bits), 1 << bits

    def tangent(number: int) -> int:
        """tanh; where it is 1 to the last digit it is flat, and no rounding is to grow in it."""
        tanh = apply("tanh", number)
        return tanh if one - abs(tanh) > 1 else (one if number > 0 else -one)

    return tangent


class _Composition:
    """Coefficients of F(w) = f(w)/w^p from those of w, w^p and f(w), as they come.

    For small |w_0|, where to divide loses digits, F is expanded at w_0 and (w - w_0)^j put in.
    """

    def __init__(
        self, bits: int, name: str, w: list[int], below: list[int], above: list[int]
    ) -> None:
        self.bits, self.name, self.w, self.below, self.above = bits, name, w, below, above
        self.near = abs(w[0]) < int(REACH * (1 << bits))
        self.found: list[int] = []
        self.slopes: list[int] = []
        self.powers: list[list[int]] = []

    def entry(self, k: int) -> int:
        """The coefficient of order k; lower ones were asked for before."""
        self.found.append(self._power_sum(k) if self.near else self._quotient(k))
        return self.found[k]

    def _quotient(self, k: int) -> int:
        inner = sum(map(mul, self.below[1:], self.found[::-1]))
        return ((self.above[k] << self.bits) - inner) // self.below[0]

    def _power_sum(self, k: int) -> int:
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


class _Length:
    """Coefficients of c with c^2 = a^2 + b^2 + ... from those of the sides, as they come.

    Squares keep twice the digits, so that none is lost.  Where all sides vanish as h^m, as those of
    a body that starts from rest, c = h^m sqrt((a/h^m)^2 + ...) has a series as well, on the side to
    which the step h leads.
    """

    def __init__(self, moving: Sequence[list[int]], still: Sequence[int]) -> None:
        self.moving, self.still = moving, sum(a**2 for a in still)
        self.found: list[int] = []
        self.zeros = 0

    def entry(self, k: int) -> int:
        """The coefficient of order k; lower ones were asked for before."""
        m, c = self.zeros, self.found
        squares = sum(sum(map(mul, a[m:], a[: m - 1 if m else None : -1])) for a in self.moving)
        if m == k:
            c.append(isqrt(squares + (self.still if k == 0 else 0)))
            self.zeros += c[k] == 0
        else:
            half = sum(map(mul, c[m + 1 :], c[:m:-1]))
            c.append((squares - half) // (2 * c[m]))
        return c[k]

    @property
    def least(self) -> int:
        """What is divided by; zero where nothing is."""
        return self.found[self.zeros] if self.zeros < len(self.found) else 0


def _magnification(bits: int, pairs: Sequence[tuple[int, int]]) -> int:
    """Bits before the point of the largest number that multiplies one below 1, whose last digits
    it makes so much larger."""
    mixed = (max(abs(a), abs(b)) for a, b in pairs if min(abs(a), abs(b)) >> bits == 0)
    return max(0, max(mixed, default=0).bit_length() - bits)


def _power_function(bits: int) -> Callable[[int, int, int], int]:
    def power(number: int, p: int, q: int) -> int:
        with flint.ctx.workprec(bits + 32 + number.bit_length()):
            exponent = flint.arb(flint.fmpq(p, q))
            return fixed_point(_ball(number, bits) ** exponent, bits)

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
