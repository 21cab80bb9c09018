"""A declared motion made ready for numbers, once: compiled, its integrals by partial fractions.

The rate of an angle is ``c0 + c1 x + c2 x^2 + sum of share w/(x - c)`` over the declared poles c
with their weights w.  The polynomial is the quotient of a division; the shares are whole numbers,
and are read off a motion whose numbers are in no special position.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.closed.arithmetic import Function, ball, compiled, precise
from voronec.errors import DefinitionError, EngineLimit
from voronec.quadratures import Quadratures
from voronec.system import System

__all__ = ["Prepared", "ascending", "motion_of", "prepared"]

DEGREE = 4
"""Of the square of the rate of the variable, at most."""
MOST = 6
"""Of numerators and denominators of rates, at most."""
BITS = 256
"""Of the motion off which shares are read."""
NEAR = 2.0**-100
"""A share is this near to a whole number, as a check."""


def _nothing(_: Any) -> list[Any]:
    return []


@dataclass(frozen=True, eq=False)
class Prepared:
    """A system's motion ready for numbers; ``zeros`` are parameters that are exactly zero.

    inputs, level
        the symbols of a start (coordinates, velocities, parameters), and of a level (parameters,
        constants).
    starting
        inputs -> the constants, then the variable and its rate.
    parts
        level -> quartic (5), then place and weight of each pole, the quotient (3) of each integral,
        the cosine of each trace (2), and the slopes of a place on a plane (3 each).
    rates
        of the angles, then of the place on a plane, along and across (of a motion in the time
        itself).
    poles, shares
        place and weight of the poles that lie at finite places; for each integral its shares.
    """

    system: System
    zeros: frozenset[Any]
    inputs: tuple[Any, ...]
    level: tuple[Any, ...]
    starting: Function
    rate: Any
    quartic: tuple[Any, ...]
    poles: tuple[tuple[Any, Any], ...]
    rates: tuple[Any, ...]
    cosines: tuple[tuple[Any, Any], ...]
    parts: Function = _nothing
    shares: tuple[tuple[int, ...], ...] = ()

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


_KNOWN: dict[tuple[int, frozenset[Any]], Prepared] = {}


def motion_of(system: System) -> Quadratures:
    """The declared motion of a system; ``DefinitionError`` where it has none."""
    if system.motion is not None:
        return system.motion
    import voronec

    having = [n for n in voronec.names() if voronec.load(n).motion is not None]
    raise DefinitionError(
        f"system '{system.name}' declares no motion in closed form; of the catalogue these do: "
        f"{', '.join(having) or 'none'}"
    )


def prepared(system: System, values: Mapping[Any, Any]) -> Prepared:
    """The motion of a system ready for numbers like ``values``, which give the parameters."""
    motion = motion_of(system)
    critical = [s for s in _vanishing(system, motion) if values.get(s) == 0]
    key = (id(motion), frozenset(critical))
    if key not in _KNOWN or _KNOWN[key].system.motion is not motion:
        _KNOWN[key] = _prepare(system, motion, frozenset(critical))
    return _KNOWN[key]


_CRITICAL: dict[int, tuple[Quadratures, list[Any]]] = {}


def _vanishing(system: System, motion: Quadratures) -> list[Any]:
    """The parameters whose vanishing sends a pole to infinity."""
    if id(motion) not in _CRITICAL or _CRITICAL[id(motion)][0] is not motion:
        below = [sp.fraction(sp.together(c))[1] for c in motion.poles]
        symbols = [p.symbol for p in system.parameters if p.symbol.is_Symbol]
        found = [s for s in symbols if any(d.subs(s, 0) == 0 for d in below)]
        _CRITICAL[id(motion)] = (motion, found)
    return _CRITICAL[id(motion)][1]


def _prepare(system: System, motion: Quadratures, zeros: frozenset[Any]) -> Prepared:
    gone = dict.fromkeys(zeros, sp.Integer(0))
    own = tuple(p.symbol for p in system.parameters)
    rates = [e.xreplace(gone) for e in motion.integrals.values()]
    plane = motion.plane if motion.clock == 1 else None
    if plane is not None:
        rates += [sp.sympify(e).xreplace(gone) for e in plane.rates]
    rate = _rate_of_variable(system, motion)
    inputs = (*system.coordinates, *system.velocities, *own)
    raw = Prepared(
        system=system,
        zeros=zeros,
        inputs=inputs,
        level=(*own, *motion.constants),
        starting=compiled([*motion.constants.values(), motion.meaning, rate], inputs),
        rate=rate,
        quartic=ascending(motion.quartic.xreplace(gone), motion.x, DEGREE),
        poles=tuple(
            (c.xreplace(gone), w.xreplace(gone))
            for c, w in motion.poles.items()
            if sp.fraction(sp.together(c))[1].xreplace(gone) != 0
        ),
        rates=tuple(rates),
        cosines=tuple(
            (e[0], e[1])
            for e in (ascending(t.cosine.xreplace(gone), motion.x, 1) for t in motion.traces)
        ),
    )
    own_values = _example(raw)
    slopes = [e.xreplace(gone) for e in plane.slopes] if plane is not None else []
    for e in slopes:
        if not e.is_polynomial(motion.x):
            raise EngineLimit(
                f"system '{system.name}': the place on the plane holds '{e}' along the variable, "
                "and only polynomials are integrated there"
            )
    terms = [[_term(raw, t, own_values) for t in sp.Add.make_args(e)] for e in rates]
    quotients = [_sum(_quotient(n, d) for n, d, _ in row) for row in terms]
    flat = [*raw.quartic, *(e for pole in raw.poles for e in pole)]
    flat += [e for q in quotients for e in q] + [e for c in raw.cosines for e in c]
    flat += [c for e in slopes for c in ascending(e, motion.x, 2)]
    shares = _shares(raw, [[t for _, _, t in row] for row in terms], own_values)
    return replace(raw, parts=compiled(flat, raw.level), shares=shares)


def _rate_of_variable(system: System, motion: Quadratures) -> Any:
    """dx/dt as a function of the state, by the declared velocities."""
    dots = [velocity(q) for q in system.coordinates]
    pairs = [(v, e) for v, e in motion.velocities.items() if e.has(*dots)]
    meaning = {motion.x: motion.meaning, **motion.constants}
    found = sp.Integer(0)
    for q, dot in zip(system.coordinates, dots, strict=True):
        slope = sp.diff(motion.meaning, q)
        if slope != 0:
            value = dot if dot in system.velocities else _solved(system, pairs, dot, dots)
            found += slope * value.xreplace(meaning)
    return found


def _solved(system: System, pairs: list[tuple[Any, Any]], dot: Any, dots: list[Any]) -> Any:
    """The velocity of a coordinate out of the velocities, which are affine in two such at most."""
    alone = [(v, e) for v, e in pairs if e.has(dot) and not e.has(*(d for d in dots if d != dot))]
    rows = alone[:1] or pairs
    own = [d for d in dots if any(e.has(d) for _, e in rows)]
    if dot not in own or len(own) > 2:
        raise DefinitionError(
            f"system '{system.name}': the declared velocities of the motion do not give "
            f"'{plain_name(dot)}'; write one such as tau: -mu*velocity(u)"
        )
    still = dict.fromkeys(own, sp.Integer(0))
    table = [[sp.diff(e, d) for d in own] for _, e in rows]
    right = [v - e.xreplace(still) for v, e in rows]
    if len(rows) == 1:
        return right[0] / table[0][0]
    i = own.index(dot)
    normal = [[sp.Add(*[r[a] * r[b] for r in table]) for b in range(len(own))]
              for a in range(len(own))]  # fmt: skip
    onto = [sp.Add(*[r[a] * c for r, c in zip(table, right, strict=True)]) for a in range(len(own))]
    if len(own) == 1:
        return onto[0] / normal[0][0]
    j = 1 - i
    determinant = normal[0][0] * normal[1][1] - normal[0][1] * normal[1][0]
    return (onto[i] * normal[j][j] - onto[j] * normal[i][j]) / determinant


def ascending(value: Any, x: Any, degree: int) -> tuple[Any, ...]:
    """The coefficients of a polynomial, by its slopes at 0: nothing is multiplied out."""
    found, slope = [], sp.sympify(value)
    for i in range(degree + 1):
        found.append(slope.xreplace({x: sp.Integer(0)}) / sp.factorial(i))
        slope = sp.diff(slope, x)
    return tuple(found)


def _example(raw: Prepared) -> list[Any]:
    """Values of the symbols of a level, of a motion whose numbers are fractions of primes."""
    with precise(BITS):
        given = [
            ball(0) if s in raw.zeros else ball(sp.Rational(sp.prime(i + 20), sp.prime(i + 41)))
            for i, s in enumerate(raw.inputs)
        ]
        count = len(raw.system.parameters)
        return [*given[len(given) - count :], *raw.starting(given)[:-2]]


def _term(raw: Prepared, term: Any, example: list[Any]) -> tuple[Any, Any, Any]:
    """Coefficients of numerator and denominator of a rational function, up to the last that does
    not vanish, and both themselves."""
    above, below = sp.fraction(term)
    x = raw.motion.x
    parts = []
    for value in (above, below):
        row = list(ascending(value, x, MOST))
        with precise(BITS):
            seen = compiled(row, raw.level)(example)
        while len(row) > 1 and seen[len(row) - 1].contains(0):
            row.pop()
        parts.append(row)
    return parts[0], parts[1], (above, below)


def _quotient(above: list[Any], below: list[Any]) -> tuple[Any, ...]:
    """Of a division of polynomials, ascending, three coefficients."""
    rest, found = list(above), [sp.Integer(0)] * 3
    while len(rest) >= len(below):
        shift, factor = len(rest) - len(below), rest[-1] / below[-1]
        if shift > 2:
            raise EngineLimit("a rate grows faster than the square of the variable")
        found[shift] += factor
        for i, c in enumerate(below[:-1]):
            rest[shift + i] -= factor * c
        rest.pop()
    return tuple(found)


def _sum(rows: Any) -> tuple[Any, ...]:
    return tuple(sp.Add(*column) for column in zip(*rows, strict=True))


def _shares(
    raw: Prepared, terms: list[list[tuple[Any, Any]]], example: list[Any]
) -> tuple[tuple[int, ...], ...]:
    """Residues over weights."""
    x = raw.motion.x
    with precise(BITS):
        flat = compiled([e for pole in raw.poles for e in pole], raw.level)(example)
        places = list(zip(flat[::2], flat[1::2], strict=True))
        found = []
        for row in terms:
            parts = [e for n, d in row for e in (n, d, sp.diff(d, x))]
            at = compiled(parts, (*raw.level, x))
            found.append(tuple(_share(at([*example, c]), w) for c, w in places))
    return tuple(found)


def _share(values: list[Any], weight: Any) -> int:
    residue = ball(0)
    for i in range(0, len(values), 3):
        above, below, slope = values[i : i + 3]
        if below.contains(0) and not slope.contains(0):
            residue += above / slope
    share = residue / weight
    whole = round(float(share))
    if not abs(share - whole) < NEAR:
        raise DefinitionError(
            f"a rate of the declared motion has the residue {float(share):.6g} times the weight of "
            "its pole, no whole number; declare the weight w with f(c) = -4 w^2"
        )
    return whole
