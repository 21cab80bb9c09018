"""A declared motion made ready for numbers, once: compiled, its integrals by partial fractions.

The rate of an angle is ``c0 + c1 x + c2 x^2 + sum of share w/(x - c)`` over the declared poles c
with their weights w, and over poles of any other kind (see ``fractions``).

In the velocities a system declares, sines and cosines of colatitudes and the velocities of
coordinates are symbols, each of which has its own accurate value along the motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.precision import SHARP
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import Function, ball, compile_expressions, exact, precise, vanishes
from voronec.closed.fractions import PartialFractions, ascending_coefficients, partial_fractions
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.system import System
from voronec.errors import DefinitionError

DEGREE = 4
"""Of the square of the rate of the variable, at most."""


def _nothing(_: Any) -> list[Any]:
    return []


@dataclass(frozen=True, eq=False)
class CompiledMotion:
    """A system's motion ready for numbers; ``special`` are parameters whose values, exactly these,
    send poles to infinity.

    inputs, level
        the symbols of a start (coordinates, velocities, parameters), and of a level (parameters,
        constants).
    initial_values
        inputs -> the constants, then the variable and its rate.
    parts
        level -> quartic (5), then place and weight of each pole, the quotient (3) of each integral,
        the cosine of each trace (2), and the slopes of a place on a plane (3 each).
    rates
        of the angles, then of the place on a plane, along and across, then of the time where the
        quartic is in another one.
    poles, others
        place and weight of the poles that lie at finite places; places of the other ones.
    cosines
        offset and slope of those that are affine; nothing for the others.
    fractions
        rates and slopes as partial fractions; ``shares`` are whole numbers, one per pole.
    """

    system: System
    special: Mapping[Any, Any]
    inputs: tuple[Any, ...]
    level: tuple[Any, ...]
    initial_values: Function
    rate: Any
    quartic: tuple[Any, ...]
    poles: tuple[tuple[Any, Any], ...]
    rates: tuple[Any, ...]
    cosines: tuple[tuple[Any, Any], ...]
    others: tuple[Any, ...] = ()
    parts: Function = _nothing
    fractions: PartialFractions = field(default_factory=PartialFractions)

    @cached_property
    def memo(self) -> Memo:
        """What is computed of it once."""
        return Memo()

    def __reduce__(self) -> tuple[Any, ...]:
        """Compiled functions stay behind: the declaration is compiled again."""
        return _prepare_with, (self.system, dict(self.special))

    @property
    def shares(self) -> tuple[tuple[int, ...], ...]:
        """Of each integral, one per pole."""
        return self.fractions.shares

    @property
    def motion(self) -> Quadratures:
        """The declaration."""
        return motion_of(self.system)

    @property
    def quotient_at(self) -> int:
        """Where in ``parts`` the quotients begin."""
        return 5 + 2 * len(self.poles)

    @property
    def cosine_at(self) -> int:
        """Where in ``parts`` the cosines begin."""
        return self.quotient_at + 3 * len(self.rates)

    @property
    def slope_at(self) -> int:
        """Where in ``parts`` the slopes of a place on a plane begin."""
        return self.cosine_at + 2 * len(self.cosines)


def motion_of(system: System) -> Quadratures:
    """The declared motion of a system; ``DefinitionError`` where it has none."""
    if system.motion is not None:
        return system.motion
    from voronec.declaration.catalogue import load, names

    having = [n for n in names() if load(n).motion is not None]
    raise DefinitionError(
        f"system '{system.name}' declares no motion in closed form; of the catalogue these do: "
        f"{', '.join(having) or 'none'}"
    )


def prepare(system: System, values: Mapping[Any, Any]) -> CompiledMotion:
    """The motion of a system ready for numbers like ``values``, which give the parameters."""
    motion = motion_of(system)
    critical = motion.memo.once("critical", lambda: _critical(system, motion))
    special = {s: e for factor, s, e in critical if _is_zero(factor, values)}
    return _prepare_with(system, special)


def _prepare_with(system: System, special: Mapping[Any, Any]) -> CompiledMotion:
    """The motion made ready where it is known which parameters send poles to infinity."""
    motion = motion_of(system)
    what = ("prepared", frozenset(special.items()))
    return motion.memo.once(what, lambda: _prepare(system, motion, special))


def _is_zero(factor: Any, values: Mapping[Any, Any]) -> bool:
    if any(values.get(s) is None or callable(values[s]) for s in factor.free_symbols):
        return False
    return bool(vanishes(factor.xreplace({s: exact(values[s]) for s in factor.free_symbols})))


def _critical(system: System, motion: Quadratures) -> list[tuple[Any, Any, Any]]:
    """Polynomials in the parameters whose vanishing sends a pole to infinity, each with a parameter
    and what it is then."""
    parameters = {p.symbol for p in system.parameters if p.symbol.is_Symbol}
    cases: dict[Any, tuple[Any, Any, Any]] = {}
    for place in (*motion.poles, *motion.others):
        for factor in _factors(sp.fraction(sp.together(place))[1], parameters):
            known = _solution_for(factor, sorted(parameters & factor.free_symbols, key=str)[::-1])
            if known is not None:
                cases.setdefault(known, (factor, *known))
    return list(cases.values())


def _factors(below: Any, own: set[Any]) -> list[Any]:
    factors: list[Any] = []
    for part in sp.Mul.make_args(below):
        above = sp.fraction(sp.together(part.base if part.is_Pow else part))[0]
        if above.free_symbols and above.free_symbols <= own and above.is_polynomial(*own):
            factors += [factor for factor, _ in sp.factor_list(above)[1]]
    return factors


def _solution_for(factor: Any, symbols: list[Any]) -> tuple[Any, Any] | None:
    for s in symbols:
        slope = sp.diff(factor, s)
        if slope.is_number:
            return s, s - sp.expand(factor / slope)
    return None


def _prepare(system: System, motion: Quadratures, special: Mapping[Any, Any]) -> CompiledMotion:
    parameters = tuple(p.symbol for p in system.parameters)
    rates = [e.xreplace(special) for e in motion.integrals.values()]
    plane = motion.plane
    if plane is not None:
        rates += [as_expression(e).xreplace(special) for e in plane.rates]
    if motion.clock != 1:
        rates.append(motion.clock.xreplace(special))
    rate = _rate_of_variable(system, motion)
    inputs = (*system.coordinates, *system.velocities, *parameters)
    poles = {c: w for c, w in motion.poles.items() if _is_finite(c, special)}
    straight = motion.clock == 1
    raw = CompiledMotion(
        system=system,
        special=special,
        inputs=inputs,
        level=(*parameters, *motion.constants),
        initial_values=compile_expressions(
            [*motion.constants.values(), motion.meaning, rate], inputs
        ),
        rate=rate,
        quartic=ascending_coefficients(motion.quartic.xreplace(special), motion.x, DEGREE),
        poles=tuple((c.xreplace(special), w.xreplace(special)) for c, w in poles.items()),
        others=tuple(c.xreplace(special) for c in motion.others if _is_finite(c, special)),
        rates=tuple(rates),
        cosines=tuple(
            (e[0], e[1])
            for e in (
                ascending_coefficients(t.cosine.xreplace(special), motion.x, 1)
                for t in motion.traces
            )
        ) if straight else (),
    )  # fmt: skip
    slopes = [e.xreplace(special) for e in plane.slopes] if plane is not None else []
    whole = partial_fractions(
        rates, slopes, raw.poles, raw.others, motion.x, raw.level, _example(raw)
    )
    flat = [*raw.quartic, *(e for pole in raw.poles for e in pole)]
    flat += [e for q in whole.quotients for e in q] + [e for c in raw.cosines for e in c]
    flat += [e for q in whole.slopes for e in q]
    return replace(raw, parts=compile_expressions(flat, raw.level), fractions=whole)


def _is_finite(place: Any, special: Mapping[Any, Any]) -> bool:
    return bool(sp.fraction(sp.together(place))[1].xreplace(special) != 0)


def _rate_of_variable(system: System, motion: Quadratures) -> Any:
    """dx/dtau as a function of the state, by the declared velocities."""
    dots = [velocity(q) for q in system.coordinates]
    pairs = [(v, e) for v, e in motion.velocities.items() if e.has(*dots)]
    meaning = {motion.x: motion.meaning, **motion.constants}
    rate = sp.Integer(0)
    for q, dot in zip(system.coordinates, dots, strict=True):
        slope = sp.diff(motion.meaning, q)
        if slope != 0:
            value = dot if dot in system.velocities else _coordinate_rate(system, pairs, dot, dots)
            rate += slope * value.xreplace(meaning)
    return rate if motion.clock == 1 else rate * motion.clock.xreplace(meaning)


def _coordinate_rate(
    system: System, pairs: list[tuple[Any, Any]], dot: Any, dots: list[Any]
) -> Any:
    """The velocity of a coordinate out of the velocities, which are affine in two such at most."""
    alone = [(v, e) for v, e in pairs if e.has(dot) and not e.has(*(d for d in dots if d != dot))]
    rows = alone[:1] or pairs
    unknowns = [d for d in dots if any(e.has(d) for _, e in rows)]
    if dot not in unknowns or len(unknowns) > 2:
        raise DefinitionError(
            f"system '{system.name}': the declared velocities of the motion do not give "
            f"'{plain_name(dot)}'; write one such as tau: -mu*velocity(u)"
        )
    still = dict.fromkeys(unknowns, sp.Integer(0))
    table = [[sp.diff(e, d) for d in unknowns] for _, e in rows]
    right = [v - e.xreplace(still) for v, e in rows]
    if len(rows) == 1:
        return right[0] / table[0][0]
    i = unknowns.index(dot)
    normal = [[sp.Add(*[r[a] * r[b] for r in table]) for b in range(len(unknowns))]
              for a in range(len(unknowns))]  # fmt: skip
    onto = [
        sp.Add(*[r[a] * c for r, c in zip(table, right, strict=True)]) for a in range(len(unknowns))
    ]
    if len(unknowns) == 1:
        return onto[0] / normal[0][0]
    j = 1 - i
    determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0]
    return (onto[i] * normal[j][j] - onto[j] * normal[i][j]) / determinant


def _example(raw: CompiledMotion) -> list[Any]:
    """Values of the symbols of a level, of a motion whose numbers are fractions of primes."""
    plain = {s: sp.Rational(sp.prime(i + 20), sp.prime(i + 41)) for i, s in enumerate(raw.inputs)}
    known = {s: e.xreplace(plain) for s, e in raw.special.items()}
    with precise(SHARP):
        given = [ball({**plain, **known}[s]) for s in raw.inputs]
        count = len(raw.system.parameters)
        return [*given[len(given) - count :], *raw.initial_values(given)[:-2]]


@dataclass(frozen=True, eq=False)
class Reading:
    """The velocities of the equations, to be evaluated along a motion.

    ``symbols`` are the level's, then ``x`` and its rate, then for each trace sine and cosine of its
    colatitude and the velocity of that, then the velocity of each angle, then ``coordinates``, then
    what stands for ``polynomials`` in x; ``expressions`` in these, in the order of ``velocities``.
    """

    symbols: tuple[Any, ...]
    coordinates: tuple[Any, ...]
    polynomials: tuple[Any, ...]
    expressions: tuple[Any, ...]
    velocities: tuple[Any, ...]


def reading_of(own: CompiledMotion) -> Reading:
    """The velocities of a prepared motion."""
    return own.memo.once("reading", lambda: _make_reading(own))


def _make_reading(own: CompiledMotion) -> Reading:
    motion, change = own.motion, sp.Dummy("rate of the variable")
    symbols = [*own.level, motion.x, change]
    meaning: dict[Any, Any] = {}
    if motion.meaning in own.system.coordinates:
        meaning |= {motion.meaning: motion.x, velocity(motion.meaning): change}
    for i, trace in enumerate(motion.traces):
        sine, cosine, rate = sp.symbols(f"sine{i} cosine{i} colatitude_rate{i}", cls=sp.Dummy)
        meaning |= {sp.sin(trace.colatitude): sine, sp.cos(trace.colatitude): cosine,
                    velocity(trace.colatitude): rate}  # fmt: skip
        symbols += [sine, cosine, rate]
    for q in motion.angles:
        rate = sp.Dummy(f"rate of {q}")
        meaning[velocity(q)] = rate
        symbols.append(rate)
    declared = {velocity(q): velocity(q) for q in own.system.coordinates} | dict(motion.velocities)
    velocities = tuple(declared[v].xreplace(meaning) for v in own.system.velocities)
    held = {s for e in velocities for s in e.free_symbols}
    coordinates = tuple(q for q in own.system.coordinates if q in held)
    moving = {*symbols[len(own.level) + 1 :], *coordinates}
    kept: dict[Any, Any] = {}
    velocities = tuple(_lift(e, own.motion.x, moving, kept) for e in velocities)
    symbols += [*coordinates, *kept.values()]
    return Reading(
        tuple(symbols), coordinates, tuple(kept), velocities, tuple(own.system.velocities)
    )


def _lift(expr: Any, x: Any, moving: set[Any], kept: dict[Any, Any]) -> Any:
    """The expression with symbols for what it holds of parameters, constants and x as a polynomial:
    1 + R2/R1 is no good in doubles where R1 is nearly -R2."""
    if expr.is_Atom:
        return expr
    if not expr.free_symbols & moving and expr.free_symbols and expr.is_polynomial(x):
        return kept.setdefault(expr, sp.Dummy(f"polynomial{len(kept)}"))
    return expr.func(*(_lift(a, x, moving, kept) for a in expr.args)) if expr.args else expr


def velocities_in_doubles(own: CompiledMotion) -> Any:
    """The velocities of the equations as a function of arrays, in the order of a reading."""
    read = reading_of(own)
    return own.memo.once(
        "velocities in doubles",
        lambda: sp.lambdify(read.symbols, list(read.expressions), "numpy", cse=True),
    )
