"""One motion in exact numbers: its level, decisions about it, and what is to be inverted.

The discriminant tells whether there is a multiple root; the subresultants of the polynomial and its
slope tell the greatest common divisor of the two, whose roots are the multiple ones.

What users give is read here as well: a system, parameters, exact numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from typing import Any

import sympy as sp
from flint import arb

from voronec.algebra.memo import Memo
from voronec.algebra.precision import FIRST, GENERIC, PROOF
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import Function, ball, compile_expressions, exact, precise, vanishes
from voronec.closed.compiled_motion import CompiledMotion
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.reading import expression, fixed_mapping, quote, real_number
from voronec.declaration.system import System
from voronec.errors import DefinitionError, EngineLimit, did_you_mean

Factors = tuple[tuple[tuple[Any, ...], int], ...]


@cache
def _symbols(degree: int) -> tuple[Any, ...]:
    return sp.symbols(f"c0:{degree + 1}")


@cache
def _chain(degree: int) -> dict[int, tuple[Any, ...]]:
    """Subresultants of a polynomial and its slope by their degrees, coefficients ascending."""
    x, names = sp.Symbol("x"), _symbols(degree)
    poly = sum(c * x**i for i, c in enumerate(names))
    chain = {}
    for e in sp.subresultants(poly, sp.diff(poly, x), x)[2:]:
        p = sp.Poly(e, x)
        chain[p.degree()] = tuple(p.coeff_monomial(x**i) for i in range(p.degree() + 1))
    return chain


@cache
def _balls(degree: int, of: int) -> Function:
    return compile_expressions(_chain(degree)[of], _symbols(degree))


def squarefree(problem: InversionProblem, values: Sequence[Any]) -> Factors:
    """Factors of the quartic with their multiplicities, from its coefficients as balls.

    Coefficients ascend; the last of each is not zero.  A constant factor stands alone; there are
    none where everything vanishes.
    """
    symbols = problem.prepared.quartic
    degree = len(values) - 1
    while degree and values[degree].contains(0) and not _nonzero(problem, symbols[degree]):
        degree -= 1
    coefficients = list(values[: degree + 1])
    if degree < 2:
        if degree == 0 and not _nonzero(problem, symbols[0]):
            return ()
        return ((tuple(coefficients), 1),)
    meaning = dict(zip(_symbols(degree), symbols, strict=False))
    if not _balls(degree, 0)(coefficients)[0].contains(0):
        return ((tuple(coefficients), 1),)
    common = 0
    while common < degree - 1 and not _nonzero(
        problem, _chain(degree)[common][-1].xreplace(meaning)
    ):
        common += 1
    if common == 0:
        return ((tuple(coefficients), 1),)
    if common == degree - 1:
        root = -coefficients[-2] / (degree * coefficients[-1])
        return _with_constant(((-root, ball(1)), degree), coefficients[-1:])
    shared = _balls(degree, common)(coefficients)
    if common == 2:
        a, b, c = (e.xreplace(meaning) for e in _chain(degree)[2])
        if _nonzero(problem, b**2 - 4 * a * c):
            square = tuple(e / shared[2] for e in shared)
            return _with_constant((square, 2), coefficients[-1:])
        shared = [shared[1], 2 * shared[2]]
    root, times = -shared[0] / shared[1], common + 1
    rest = coefficients
    for _ in range(times):
        rest = _without(rest, root)
    return _with_constant(((-root, ball(1)), times), rest)


def _with_constant(factor: tuple[tuple[Any, ...], int], rest: Sequence[Any]) -> Factors:
    return (factor, (tuple(rest), 1))


def _without(poly: Sequence[Any], root: Any) -> list[Any]:
    """The quotient by x - root."""
    quotient = [poly[-1]]
    for c in reversed(poly[1:-1]):
        quotient.append(c + root * quotient[-1])
    return quotient[::-1]


def _nonzero(problem: InversionProblem, expr: Any) -> bool:
    return problem.sign(expr) != 0


LADDER = (FIRST, GENERIC, PROOF, 1000)
"""Bits at which a sign is looked for; where the last still leaves it open, algebra decides."""
BEYOND = (4000, 16000)
"""And where algebra proves nothing, or that the number is not zero, however small."""


def nearest_whole(at: Callable[[int], Any]) -> int:
    """The whole number nearest to a number that a function of bits gives as a ball, and that lies
    within a quarter of it; ``EngineLimit`` where no bits tell."""
    for bits in (*LADDER, *BEYOND):
        with precise(bits):
            nearest = (at(bits) + ball(0.5)).floor()
        if nearest.is_exact():
            return int(nearest.unique_fmpz())
    raise EngineLimit("whole turns at the start cannot be told; give initial data exactly")


@dataclass(frozen=True, eq=False)
class InversionProblem:
    """A motion ready to be inverted.

    ``values`` gives every symbol of ``prepared.inputs``: an exact number (int, float, mpmath's or
    sympy's), or, where only digits are known, a function of bits to a ball.
    """

    prepared: CompiledMotion
    values: Mapping[Any, Any]
    _kept: Memo = field(default_factory=Memo, repr=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """What is declared and the values travel; the rest is computed again."""
        if any(callable(value) for value in self.values.values()):
            raise DefinitionError(
                "a motion in closed form whose start follows from other data cannot be pickled; "
                "pickle what it was made from, or give coordinates and velocities of the equations"
            )
        return InversionProblem, (self.prepared, dict(self.values))

    def start_balls(self, bits: int) -> list[Any]:
        """The start as balls, in the order of ``prepared.inputs``."""
        return self._once("given", lambda: [
            v(bits) if callable(v) else ball(v)
            for v in (self.values[s] for s in self.prepared.inputs)
        ], bits)  # fmt: skip

    def start_by_symbol(self, bits: int) -> dict[Any, Any]:
        """The start as balls, by coordinate, velocity and parameter."""
        return dict(zip(self.prepared.inputs, self.start_balls(bits), strict=True))

    def level(self, bits: int) -> list[Any]:
        """Parameters and constants as balls, in the order of ``prepared.level``."""
        count = len(self.prepared.system.parameters)
        start = self.start_balls(bits)
        return [*start[len(start) - count :], *self._start_values(bits)[:-2]]

    def place(self, bits: int) -> Any:
        """The variable at the start."""
        return self._start_values(bits)[-2]

    def rate(self, bits: int) -> Any:
        """The rate of the variable at the start; exactly zero at a turning point."""
        rate = self._start_values(bits)[-1]
        return ball(0) if self._is_zero(rate, self.prepared.rate) else rate

    def exact(self, expr: Any) -> Callable[[int], Any]:
        """An expression in constants, parameters and the start, at any number of bits."""
        symbols = (*self.prepared.inputs, *self.prepared.motion.constants)
        what = ("compiled", expr)
        function = self.prepared.memo.once(what, lambda: compile_expressions([expr], symbols))

        def at(bits: int) -> Any:
            with precise(bits):
                return function([*self.start_balls(bits), *self._start_values(bits)[:-2]])[0]

        return at

    def sign(self, expr: Any) -> int:
        """-1, 0 or 1, decided exactly; ``EngineLimit`` where no proof is found.

        Balls of growing precision tell a sign; where the last still holds zero, algebra proves
        that the number is zero.
        """
        read = as_expression(expr)
        return int(self._kept.once(("sign", read), lambda: self._sign(read)))

    def _sign(self, expr: Any) -> int:
        told = self._sign_from_balls(expr, LADDER)
        if told is None and self._is_exact(expr) and vanishes(self.exact_number(expr)):
            return 0
        told = self._sign_from_balls(expr, BEYOND) if told is None else told
        if told is not None:
            return told
        raise EngineLimit(
            f"whether '{_short(expr)}' is zero cannot be decided: it is less than "
            f"2^-{BEYOND[-1] // 2}, and no proof is found; give initial data exactly, such as "
            "Rational(1, 3)"
        )

    def _sign_from_balls(self, expr: Any, ladder: Sequence[int]) -> int | None:
        """The sign where balls of so many bits tell it."""
        at = self.exact(expr)
        for bits in ladder:
            value = at(bits)
            if value > 0 or value < 0:
                return 1 if value > 0 else -1
            if value.is_zero():
                return 0
        return None

    def exact_number(self, expr: Any) -> sp.Expr:
        """The exact number that an expression is."""
        meaning = {**self.prepared.motion.constants}
        inner = as_expression(expr).xreplace(meaning)
        known = {s: exact(v) for s, v in self.values.items() if not callable(v)}
        return inner.xreplace(known)

    def _is_exact(self, expr: Any) -> bool:
        held = as_expression(expr).xreplace({**self.prepared.motion.constants}).free_symbols
        return not any(callable(self.values.get(s)) for s in held)

    def _is_zero(self, value: Any, expr: Any) -> bool:
        if value.is_zero():
            return True
        return bool(value.contains(0)) and self.sign(expr) == 0

    def _start_values(self, bits: int) -> list[Any]:
        """Constants, the variable and its rate."""
        given = self.start_balls(bits)
        return self._once("start", lambda: self.prepared.initial_values(given), bits)

    def _once(self, what: str, make: Callable[[], Any], bits: int) -> Any:
        def precisely() -> Any:
            with precise(bits):
                return make()

        return self._kept.once((what, bits), precisely)

    # -- what is inverted ------------------------------------------------------------------

    def table(self, bits: int) -> list[Any]:
        """``prepared.parts`` of this level."""
        level = self.level(bits)
        return self._once("table", lambda: self.prepared.parts(level), bits)

    @property
    def rests(self) -> bool:
        """Whether the variable stays where it is: at a multiple root of the quartic."""
        return bool(self._kept.once("rests", self._rests))

    def _rests(self) -> bool:
        if not self.rate(LADDER[0]).is_zero():
            return False
        x = self.prepared.motion.x
        slope = sp.diff(self.prepared.motion.quartic, x)
        return self.sign(slope.xreplace({x: self.prepared.motion.meaning})) == 0

    def source(self, bits: int) -> Any:
        """The problem at a number of bits, for ``voronec.elliptic.invert``."""
        from voronec.elliptic.constants import Integral, Numbers, Pole

        compiled = self.prepared
        if self.rests:  # nothing is integrated: all rates are constant
            with precise(bits):
                factors = squarefree(self, self.table(bits)[:5])
                return Numbers(factors, self.place(bits), ball(0), at_rest=True)
        with precise(bits):
            table, others = self.table(bits), self.others(bits)
            count = len(compiled.poles)
            poles = tuple(
                Pole(table[5 + 2 * i], self._weight(table[6 + 2 * i], i)) for i in range(count)
            )
            poles += tuple(Pole(place) for place, _ in others)
            first = 5 + 2 * count
            integrals = tuple(
                Integral(
                    self._exact_coefficient(table[first + 3 * j], j, 0),
                    self._exact_coefficient(table[first + 3 * j + 1], j, 1),
                    self._exact_coefficient(table[first + 3 * j + 2], j, 2),
                    (*shares, *(residues[j] for _, residues in others)),
                )
                for j, shares in enumerate(compiled.shares)
            )
            return Numbers(
                factors=squarefree(self, table[:5]),
                place=self.place(bits),
                rate=self.rate(bits),
                poles=poles,
                integrals=integrals,
            )

    def others(self, bits: int) -> list[tuple[Any, list[Any]]]:
        """The poles without a weight: place, and residues of all rates, then of all slopes.

        Real balls; or complex ones, one of each conjugate pair, with twice the residues: the real
        part is that of both.
        """
        if not self.prepared.others:
            return []
        level = self.level(bits)
        return list(self._once("others", lambda: self._others(level), bits))

    def _others(self, level: list[Any]) -> list[tuple[Any, list[Any]]]:
        from flint import acb

        from voronec.elliptic.roots import OpenDecision

        flat = self.prepared.fractions.foreign(list(map(acb, level)))
        count, others = len(self.prepared.others), []
        rows = len(flat) // count - 1
        for i, met in enumerate(self.prepared.fractions.meets):
            place = acb(flat[i])
            if not place.is_finite():
                raise OpenDecision("a pole may lie at infinity")
            if not place.imag.is_zero() and place.imag.contains(0):
                raise OpenDecision("a pole may be real")
            residues = flat[count + i * rows : count + (i + 1) * rows]
            row = [acb(r) if m else 0 for r, m in zip(residues, met, strict=True)]
            if place.imag.is_zero():
                place, row = place.real, [r.real if m else 0 for r, m in zip(row, met, strict=True)]
            elif place.imag < 0:
                continue
            else:
                row = [2 * r for r in row]
            others.append((place, row))
        return others

    def _exact_coefficient(self, value: Any, j: int, i: int) -> Any:
        """A coefficient; exactly 0 where it is that."""
        if value.is_zero() or not value.contains(0):
            return value
        try:
            return ball(0) if self.sign(self.prepared.fractions.quotients[j][i]) == 0 else value
        except EngineLimit:  # as good, only slower
            return value

    def _weight(self, value: Any, i: int) -> Any:
        return ball(0) if self._is_zero(value, self.prepared.poles[i][1]) else value

    def branch(self, colatitude: Any) -> tuple[int, int]:
        """(sign, turns) of a colatitude that starts at no pole: sign (0..pi) + 2 pi turns."""
        side = self.sign(sp.sin(colatitude))  # a double may round it onto a pole
        value = self.exact(colatitude)
        return side, nearest_whole(lambda bits: (value(bits) / ball(1).pi() - ball(side) / 2) / 2)

    def check(self) -> None:
        """Raise ``DefinitionError`` for a start or parameters at which the motion is singular."""
        compiled, name = self.prepared, self.prepared.system.name
        if not all(c.is_finite() for c in self.table(LADDER[0])[:5]):
            symbols = [p.symbol for p in compiled.system.parameters]
            held = ", ".join(f"{s} = {self.values[s]}" for s in symbols)
            raise DefinitionError(
                f"system '{name}': the motion in closed form is singular for {held}; change these"
            )
        if not all(c.is_finite() for c in self._start_values(LADDER[0])):
            raise DefinitionError(
                f"system '{name}': the closed form has no value at the start; start elsewhere"
            )
        for trace in compiled.motion.traces:
            pole = sp.sin(trace.colatitude)
            if self._is_zero(self.exact(pole)(LADDER[0]), pole):
                q = trace.colatitude
                raise DefinitionError(
                    f"system '{name}': the start {q} = {self.values[q]} is a pole of the "
                    "coordinates; start elsewhere, or turn the coordinates"
                )


def _short(expr: Any) -> str:
    text = str(expr)
    return text if len(text) <= 60 else f"{text[:57]}..."


def quadratures_of(system: System) -> Quadratures:
    """The declaration; an error in one line where there is none."""
    if not isinstance(system, System):
        raise DefinitionError(f"'{quote(system)}' is no system; load one with vo.load")
    if not isinstance(system.motion, Quadratures):
        raise DefinitionError(
            f"system '{system.name}' declares no quadratures; give it motion=vo.Quadratures(...)"
        )
    return system.motion


def exact_instant(t: Any) -> Any:
    """A time as what it is: a ball, or an exact number."""
    if isinstance(t, arb):
        return t
    instant = exact(real_number(t, "t"))
    if instant.is_Rational:
        return Fraction(int(instant.p), int(instant.q))
    function = compile_expressions([instant], ())
    return lambda _: function([])[0]


def read_parameters(system: System, parameters: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
    """Parameter -> expression, by the symbols of the system."""
    symbols = {p.name: p.symbol for p in system.parameters}
    values = {}
    for key, value in fixed_mapping(parameters, "parameters", "parameter: value").items():
        if plain_name(key) not in symbols:
            raise DefinitionError(
                f"system '{system.name}' has no parameter '{quote(key)}'"
                f"{did_you_mean(quote(key), symbols)}"
            )
        values[symbols[plain_name(key)]] = exact(expression(value, f"the parameter '{quote(key)}'"))
    return values


def known_parameters(system: System, parameters: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
    """Every parameter as an exact number: what is given, else the default."""
    given = read_parameters(system, parameters)
    values = {}
    for p in system.parameters:
        value = given.get(p.symbol, p.value)
        if value is None or not as_expression(value).is_number:
            raise DefinitionError(f"parameter '{p.name}' has no value; give parameters={{...}}")
        values[p.symbol] = exact(value)
    return values


def number(value: Any, name: str) -> sp.Expr:
    """An exact number."""
    number = exact(expression(value, name))
    if not number.is_number:
        raise DefinitionError(f"{name} = {quote(value)} is not a number; give one")
    return number
