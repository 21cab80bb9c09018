"""The rank test: no further rational integral of a bounded degree, at given parameters.

Take an orbit as a power series x(t) modulo a prime.  If f = P/Q is an integral, P - f(x(0)) Q
vanishes along it; so do multiples of the relations between the letters, and of A - F(x(0)) B for
each known integral F = A/B.  With M the number of monomials up to the degree, those that are
leading in the relations left out, the number

    excess = M - rank(series of the monomials) - rank(multiples of the known integrals)         (31)

bounds from above how many polynomials vanish on the generic orbit beside these multiples.  Where it
is 0, every rational integral up to the degree is a function of the known ones [Theory, eq. (31)].
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import comb
from time import perf_counter
from typing import Any

import flint
import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.arguments import accepts
from voronec.algebra.groebner import groebner_basis
from voronec.algebra.matrices import dot
from voronec.algebra.normal import canonical, quotient
from voronec.algebra.ring import Monomial, Ring, sparse_terms
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import html_table, plain_text
from voronec.algebra.verdicts import decide_zero
from voronec.declaration.reading import quote
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit
from voronec.proof.search.probe import TRIES, Variety
from voronec.proof.search.residues import PRIMES, Array, as_residue, free_columns, inverse
from voronec.proof.search.search import known_integrals, parameter_values, specialize_field

SURPLUS = 10
"""Coefficients of a series, and points, beyond the number of unknowns."""
ORBITS = 3
"""So many orbits, each modulo its own prime, before an excess is reported."""
ENTRY = 100
"""Bytes for one entry of the matrix: as a number of Python's twice, as a residue, and as a list."""


@dataclass(frozen=True, repr=False)
class RationalBound:
    """What the rank test says of rational integrals of degree up to ``degree`` in ``letters``.

    Of ``monomials`` functions, ``rank`` are independent along an orbit, and ``explained`` more are
    multiples of the ``known`` integrals on its level.  ``formal`` are conditions on the parameters
    that the values ``at`` do not meet.
    """

    system: str
    degree: int
    letters: tuple[str, ...]
    at: dict[sp.Expr, sp.Expr]
    known: tuple[str, ...]
    monomials: int
    rank: int
    explained: int
    formal: tuple[str, ...]
    seconds: float

    def __repr__(self) -> str:
        return f"RationalBound({self.system!r}, degree {self.degree}, excess {self.excess})"

    def _repr_html_(self) -> str:
        """For notebooks: the numbers and the statement."""
        rows = [("excess", str(self.excess)), ("statement", self.statement)]
        return html_table(f"rational integrals of {self.system}", rows)

    @property
    def excess(self) -> int:
        """How many polynomials may vanish on an orbit that are no multiples of known integrals."""
        return self.monomials - self.rank - self.explained

    @property
    def decided(self) -> bool:
        """Whether it is proved that there is no further rational integral up to the degree."""
        return self.excess == 0

    @property
    def statement(self) -> str:
        """What is proved, in words."""
        values = ", ".join(f"{s} = {plain_text(v)}" for s, v in self.at.items())
        where = f", for {values}" if values else ""
        if self.formal:
            where += f" (formal: no body has these values, which violate {', '.join(self.formal)})"
        known = ", ".join(self.known) or "none but constants"
        form = f"of degree at most {self.degree} in {', '.join(self.letters)}"
        if self.decided:
            return f"No further rational integral {form}{where}. Known: {known}."
        return (
            f"Undecided: {self.excess} more polynomials {form} vanish on the orbits tried than the "
            f"known integrals explain{where}. There may be a further integral. Known: {known}."
        )

    def as_dict(self) -> dict[str, Any]:
        """The outcome as text and numbers that JSON can hold."""
        return {
            "system": self.system,
            "degree": self.degree,
            "letters": list(self.letters),
            "at": {str(s): plain_text(v) for s, v in self.at.items()},
            "known": list(self.known),
            "monomials": self.monomials,
            "rank": self.rank,
            "explained": self.explained,
            "excess": self.excess,
            "decided": self.decided,
            "formal": list(self.formal),
            "statement": self.statement,
            "seconds": round(self.seconds, 3),
        }


@accepts()
def exclude_rational_integrals(
    system: System | VoronecEquations,
    degree: int = 4,
    *,
    at: Mapping[Any, Any] | None = None,
    momenta: bool = True,
    body: Sequence[Any] = (),
    seed: int = 1,
) -> RationalBound:
    """Whether a system has no rational integral P/Q of a bounded degree beside the known ones.

    degree
        bound on the degrees of P and Q in the letters: invariants, or coordinates with cosine and
        sine for angles, and momenta dLc/dv.
    at
        parameter -> value; the others have their default values.
    momenta
        whether the letters are the momenta, or the velocities of the equations.
    body
        expressions of the parameters that are negative for no body, such as I2 + I3 - I1, or
        2 m R^2 - I1 - I2 - I3 of a ball; where one is, the values are called formal.

    The answer holds for these values of the parameters alone: ``statement`` says it in words, by
    the argument of [Theory, eq. (31)].  Declared integrals count as known where they are proved.
    Raises ``DefinitionError`` for a parameter without a value, ``EngineLimit`` where the equations
    are not rational or the degree asks for more memory than there is.
    """
    begin = perf_counter()
    if degree < 1:
        raise DefinitionError(f"degree is {quote(degree)}; give a number from 1 upward")
    motions = Motions.of(system)
    values = _numbers(motions, at or {})
    field = specialize_field(motions.field_for(()), values)
    claims = known_integrals(motions, field, values)
    known = {
        n: f for n, f in claims.items() if decide_zero(field.derivative(f), field.hypotheses).proved
    }
    flow = RationalFlow(field)
    letters = _Letters.of(field, flow, known, momenta)
    _require_memory(len(letters.names), degree)
    exponents = letters.monomials(degree)
    rank = explained = 0
    rng = np.random.default_rng(seed)
    for p in letters.primes()[:ORBITS]:
        explained = max(explained, letters.rank_of_multiples(exponents, degree, p, rng))
        length = len(exponents) - explained + SURPLUS
        rank = max(rank, letters.rank_along_orbit(exponents, length, p, rng))
        if rank + explained == len(exponents):
            break
    else:
        if not rank:
            raise EngineLimit(f"system '{field.system.name}': no regular point was found")
    return RationalBound(
        system=field.system.name,
        degree=degree,
        letters=letters.names,
        at=values,
        known=tuple(letters.known),
        monomials=len(exponents),
        rank=rank,
        explained=explained,
        formal=_violated(motions.system, body, values),
        seconds=perf_counter() - begin,
    )


def _numbers(motions: Motions, at: Mapping[Any, Any]) -> dict[sp.Expr, sp.Expr]:
    """A rational value of every parameter that the equations hold."""
    system, field = motions.system, motions.field_for(())
    held = {s for e in (*field.entries, *field.relations) for s in e.free_symbols}
    given = parameter_values(system, at)
    own = {p.symbol: as_expression(p.value) for p in system.parameters if p.value is not None}
    exact = {s: sp.Rational(v) if v.is_Float else v for s, v in own.items() if s not in given}
    values = exact | {s: v.xreplace(exact) for s, v in given.items()}
    needed = [p for p in system.parameters if field.bridge.inward(p.symbol) in held]
    for p in needed:
        value = values.get(p.symbol)
        if value is None or not value.is_Rational:
            said = "has no value" if value is None else f"is {quote(value)}"
            raise DefinitionError(
                f"parameter '{p.name}' {said}; give it a rational number: at={{'{p.name}': ...}}"
            )
    return {p.symbol: values[p.symbol] for p in needed}


def _violated(system: System, body: Sequence[Any], values: Mapping[Any, Any]) -> tuple[str, ...]:
    """The conditions on the parameters that values do not meet."""
    named = {p.name: p.symbol for p in system.parameters}
    known = [as_expression(e) for e in body]
    known = [e.xreplace({s: named.get(str(s), s) for s in e.free_symbols}) for e in known]
    conditions = [*system.conditions, *(sp.Ge(e, 0, evaluate=False) for e in known)]
    return tuple(plain_text(c) for c in conditions if c.xreplace(dict(values)).doit() == sp.false)


def _require_memory(letters: int, degree: int) -> None:
    """Refuse a matrix that is larger than the memory of the machine."""
    needed = comb(letters + degree, degree) ** 2 * ENTRY
    if not hasattr(os, "sysconf"):  # where nobody tells
        return
    there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed > there:
        raise EngineLimit(
            f"degree {degree} in {letters} letters asks for {needed / 2**30:.3g} GiB of memory, of "
            f"{there / 2**30:.3g} that there are; lower the degree"
        )


@dataclass(frozen=True)
class _Polynomials:
    """Polynomials in the generators of a ring, written as sums over ``nodes``: 1, the generators,
    and products of two nodes before, level by level."""

    nodes: dict[Monomial, int]
    levels: list[list[tuple[int, int, int]]]
    rows: list[dict[Monomial, Any]]

    @classmethod
    def of(cls, size: int, polynomials: Sequence[Any]) -> _Polynomials:
        rows = [sparse_terms(f) for f in polynomials]
        nodes: dict[Monomial, int] = {(): 0} | {((g, 1),): g + 1 for g in range(size)}
        levels: list[list[tuple[int, int, int]]] = []

        def add(monomial: Monomial) -> int:
            if monomial not in nodes:
                g, e = monomial[-1]
                rest = (*monomial[:-1], (g, e - 1)) if e > 1 else monomial[:-1]
                below = add(rest)
                depth = sum(k for _, k in monomial) - 2
                levels.extend([] for _ in range(depth + 1 - len(levels)))
                nodes[monomial] = len(nodes)
                levels[depth].append((nodes[monomial], below, g + 1))
            return nodes[monomial]

        for row in rows:
            for monomial in row:
                add(monomial)
        return cls(nodes, levels, rows)

    def coefficients(self, p: int) -> Array:
        """(polynomial, node), modulo p."""
        found = np.zeros((len(self.rows), len(self.nodes)), dtype=np.int64)
        for line, row in zip(found, self.rows, strict=True):
            for monomial, coefficient in row.items():
                line[self.nodes[monomial]] = as_residue(coefficient, p)
        return found

    def values(self, points: Array, p: int) -> Array:
        """(polynomial, point) from (generator, point)."""
        at = np.ones((len(self.nodes), points.shape[1]), dtype=np.int64)
        at[1 : len(points) + 1] = points
        for level in self.levels:
            for node, a, b in level:
                at[node] = at[a] * at[b] % p
        rows = self.coefficients(p)
        found = [(row[:, None] * at % p).sum(axis=0) % p for row in rows]
        return np.array(found, dtype=np.int64).reshape(len(rows), points.shape[1])


class RationalFlow:
    """The motion as L(x) x' = R(x), polynomials in ``generators``: coordinates, or cosine and sine
    of angles, and velocities."""

    def __init__(self, field: VectorField) -> None:
        held: set[Any] = set().union(*(e.free_symbols for e in field.entries))
        if field.time in held:
            raise EngineLimit("equations that hold the time have no rank test")
        free = [q for q in field.positions if q not in held]
        self.field = field
        self.ring = ring = Ring([*field.entries, *field.relations, *field.velocities, *free], ())
        fractions = [[ring.fraction(r)] for r in field.rates]
        rows = [
            [*map(ring.fraction, row), ring.fraction(f)]
            for row, f in zip(field.mass, field.force, strict=True)
        ]
        angles = {
            a: (c, s, d)
            for (a, (c, s)), d in zip(ring.pairs.items(), ring.found.angles.values(), strict=True)
        }
        own = {*field.variables, *(g for c, s, _ in angles.values() for g in (c, s))}
        for foreign in (e for e in ring.meaning if e not in own):
            raise EngineLimit(
                f"the equations hold '{quote(field.bridge.outward(foreign))}'; the rank test takes "
                "rational ones, in coordinates, cosines and sines"
            )
        index = ring.index
        self.places: list[tuple[int, int]] = []
        entries, right = [], []

        def add(row: int, columns: Sequence[int], parts: Sequence[Any]) -> None:
            *left, last = _over_common_denominator(ring, parts)
            for column, entry in zip(columns, left, strict=True):
                if entry != 0:
                    self.places.append((row, column))
                    entries.append(entry)
            right.append((row, last))

        for q, (rate,) in zip(field.positions, fractions, strict=True):
            one = ring.field.constant(1)
            if ring.has(q):
                add(index(q), [index(q)], [one, rate])
            if q in angles:
                c, s, d = angles[q]
                turn = ring.field.mul([rate, ring.field.constant(1, int(d))])
                up, down = (ring.fraction(e) for e in (c, -s))
                add(index(c), [index(c)], [one, ring.field.mul([down, turn])])
                add(index(s), [index(s)], [one, ring.field.mul([up, turn])])
        columns = [index(v) for v in field.velocities]
        for v, row in zip(field.velocities, rows, strict=True):
            add(index(v), columns, row)
        right = [poly for _, poly in sorted(right, key=lambda x: x[0])]
        self.polynomials = _Polynomials.of(len(ring.meaning), [*entries, *right])
        self.variety = Variety(ring.meaning, field.relations, ())
        bound = [
            *(ring.fraction(r).num for r in field.relations),
            *(r for *_, r in ring.field.rules),
        ]
        slopes = [f.derivative(i) for f in bound for i in range(len(ring.meaning))]
        self.bound = _Polynomials.of(len(ring.meaning), bound)
        self._slopes = _Polynomials.of(len(ring.meaning), slopes)
        self._rank = len(field.independent_relations) + len(ring.field.rules)

    def residuals(self, states: Array, slopes: Array, p: int) -> Array:
        """L(x) x' - R(x) and the relations, at states with given slopes: zero on motions."""
        value, count = self.polynomials.values(states, p), len(self.places)
        total = -value[count:]
        row, column = np.array(self.places).T
        np.add.at(total, row, value[:count] * slopes[column] % p)
        return np.concatenate([total % p, self.bound.values(states, p)])

    def points(self, count: int, p: int, rng: Any) -> Array:
        """Random states modulo p where the relations hold, (generator, point)."""
        for _ in range(TRIES):
            drawn, enough = self.variety.draw(np.zeros((1, 0), dtype=np.int64), count, p, rng)
            if enough[0]:
                return np.asarray(drawn[:, 0])
        raise EngineLimit(f"system '{self.field.system.name}': no state was found modulo a prime")

    def is_smooth(self, state: Array, p: int) -> bool:
        """Whether the differentials of the relations have their full rank at a state."""
        slopes = self._slopes.values(state[:, None], p).reshape(-1, len(state))
        return len(free_columns(slopes, p)[1]) == self._rank

    def orbit(self, start: Array, length: int, p: int) -> Array | None:
        """The power series from a start, (generator, coefficient); None where L is singular."""
        program, size = self.polynomials, len(start)
        table = program.coefficients(p)
        x = np.zeros((len(program.nodes), length), dtype=np.int64)
        x[0, 0], x[1 : size + 1, 0] = 1, start
        value = np.zeros((len(table), length), dtype=np.int64)
        slopes = np.zeros((size, length), dtype=np.int64)
        row, column = np.array(self.places).T
        levels = [np.array(level).T for level in program.levels]
        entries, solve = len(self.places), None
        steps = inverse(np.arange(1, length + 1, dtype=np.int64), p)
        for k in range(length):
            for node, a, b in levels:
                x[node, k] = (
                    (x[a, : k + 1] * x[b, k::-1] % p).sum(axis=1) % p
                    if k
                    else x[a, 0] * x[b, 0] % p
                )
            value[:, k] = (table * x[:, k] % p).sum(axis=1) % p
            if solve is None:
                matrix = np.zeros((size, size), dtype=np.int64)
                matrix[row, column] = value[:entries, 0]
                solve = _inverse_matrix(matrix, p)
                if solve is None:
                    return None
            rest = value[entries:, k].copy()
            if k:
                earlier = (value[:entries, k:0:-1] * slopes[column, :k] % p).sum(axis=1) % p
                np.subtract.at(rest, row, earlier)
            slopes[:, k] = (solve * (rest % p) % p).sum(axis=1) % p
            if k + 1 < length:
                x[1 : size + 1, k + 1] = slopes[:, k] * steps[k] % p
        return x[1 : size + 1]


def _inverse_matrix(matrix: Array, p: int) -> Array | None:
    size = len(matrix)
    try:
        found = flint.nmod_mat(size, size, matrix.ravel().tolist(), p).inv()
    except ZeroDivisionError:
        return None
    return np.array([[int(x) for x in row] for row in found.tolist()], dtype=np.int64)


def _over_common_denominator(ring: Ring, fractions: Sequence[Any]) -> list[Any]:
    """The numerators of fractions over one common denominator."""
    powers: dict[int, int] = {}
    for f in fractions:
        for i, e in f.den:
            powers[i] = max(powers.get(i, 0), e)
    return [
        f.num * ring.field.denominator([(i, e - dict(f.den).get(i, 0)) for i, e in powers.items()])
        for f in fractions
    ]


@dataclass(frozen=True)
class _Known:
    """A known integral A/B as polynomials in the letters, and the larger of their degrees."""

    polynomials: _Polynomials
    degree: int


@dataclass(frozen=True)
class _Letters:
    """What the polynomials of the test are polynomials in, by ``names``, as functions of the
    generators of a flow: numerators and then denominators.

    ``leading`` are the leading monomials of the relations between the letters.
    """

    flow: RationalFlow
    names: tuple[str, ...]
    functions: _Polynomials
    known: dict[str, _Known]
    leading: tuple[tuple[int, ...], ...]

    @classmethod
    def of(
        cls, field: VectorField, flow: RationalFlow, known: Mapping[str, Any], momenta: bool
    ) -> _Letters:
        ring, moving = flow.ring, [*field.velocities]
        still = [g for q in field.positions for g in (q, *ring.pairs.get(q, ())) if ring.has(g)]
        functions, solved = moving, dict[Any, Any]()
        names = [str(field.bridge.outward(g)) for g in [*still, *moving]]
        if momenta:
            functions = canonical([dot(row, moving) for row in field.mass], field.relations)
            letters = [se.Symbol(f"p_{v}") for v in moving]
            names[len(still) :] = map(str, letters)
            rows = [row[0] for row in field.solve([[x] for x in letters])]
            solved, moving = dict(zip(moving, rows, strict=True)), letters
        fractions = [*map(ring.fraction, [*still, *functions])]
        below = [ring.field.denominator(f.den) for f in fractions]
        read = _Polynomials.of(len(ring.meaning), [*(f.num for f in fractions), *below])
        order = [*still, *moving]
        integrals = {n: quotient(f.xreplace(solved), field.relations) for n, f in known.items()}
        relations = [*field.relations, *(c**2 + s**2 - 1 for c, s in ring.pairs.values())]
        found = {}
        for name, pair in integrals.items():
            polynomials = _in_letters(order, pair)
            if polynomials is not None:
                degree = max(int(f.total_degree()) for f in polynomials)
                found[name] = _Known(_Polynomials.of(len(order), polynomials), degree)
        bound = _in_letters(order, relations)
        if bound is None:
            raise EngineLimit("the relations are no polynomials in the letters of the rank test")
        return cls(flow, tuple(names), read, found, _leading(bound))

    def primes(self) -> list[int]:
        """Primes that divide no denominator."""
        found = []
        programs = [
            self.flow.polynomials,
            self.functions,
            *(k.polynomials for k in self.known.values()),
        ]
        for p in PRIMES:
            try:
                for program in programs:
                    program.coefficients(p)
            except ZeroDivisionError:
                continue
            found.append(p)
        return found

    def monomials(self, degree: int) -> Array:
        """Exponents up to a degree, without multiples of leading monomials; low degrees first."""
        size = len(self.names)
        rows, last = [(0,) * size], [(0,) * size]
        for _ in range(degree):
            grown = {
                (*row[:i], row[i] + 1, *row[i + 1 :])
                for row in last
                for i in range(max((k for k, e in enumerate(row) if e), default=0), size)
            }
            last = sorted(row for row in grown if not self._is_leading(row))
            rows += last
        return np.array(rows, dtype=np.int64)

    def _is_leading(self, row: Sequence[int]) -> bool:
        return any(all(a >= b for a, b in zip(row, top, strict=True)) for top in self.leading)

    def values(self, states: Array, p: int) -> Array:
        """The letters at states, (letter, state)."""
        found = self.functions.values(states, p)
        size = len(self.names)
        return found[:size] * inverse(found[size:], p) % p

    def rank_along_orbit(self, exponents: Array, length: int, p: int, rng: Any) -> int:
        """How many of the monomials are independent along one orbit, by series of a length; 0 where
        no orbit was found."""
        for _ in range(TRIES):
            start = self.flow.points(1, p, rng)[:, 0]
            orbit = self.flow.orbit(start, length, p) if self.flow.is_smooth(start, p) else None
            if orbit is None:
                continue
            series = self._series([flint.nmod_poly(row.tolist(), p) for row in orbit], length, p)
            if series is not None:
                return _rank_of_products(exponents, series, length, p)
        return 0

    def _series(self, generators: list[Any], length: int, p: int) -> list[Any] | None:
        """The letters along an orbit; None where one is infinite at its start."""
        at: list[Any] = [flint.nmod_poly([1], p), *generators]
        at += [None] * (len(self.functions.nodes) - len(at))
        for level in self.functions.levels:
            for node, a, b in level:
                at[node] = at[a].mul_low(at[b], length)
        sums = []
        for row in self.functions.coefficients(p):
            terms = [at[i] * int(row[i]) for i in np.flatnonzero(row)]
            sums.append(sum(terms, flint.nmod_poly([0], p)))
        size, found = len(self.names), []
        for above, below in zip(sums[:size], sums[size:], strict=True):
            if int(below[0]) == 0:
                return None
            found.append(above.mul_low(below.inverse_series_trunc(length), length))
        return found

    def rank_of_multiples(self, exponents: Array, degree: int, p: int, rng: Any) -> int:
        """How many multiples of the known integrals on a level, of degrees up to the bound, are
        independent functions: their rank at random states."""
        if not self.known:
            return 0
        totals = exponents.sum(axis=1)
        factors = [exponents[totals <= degree - known.degree] for known in self.known.values()]
        count = sum(map(len, factors)) + SURPLUS
        letters = self.values(self.flow.points(count, p, rng), p)
        values = [known.polynomials.values(letters, p) for known in self.known.values()]
        columns: list[Array] = []
        regular = np.flatnonzero(np.all([below for _, below in values], axis=0))
        if not len(regular):
            return 0
        place = regular[0]  # the state whose level is meant
        for (above, below), rows in zip(values, factors, strict=True):
            level = above[place] * pow(int(below[place]), -1, p) % p
            vanishing = (above - level * below) % p
            columns += [m * vanishing % p for m in _products(rows, letters, p)]
        entries = [x for column in columns for x in column.tolist()]
        return int(flint.nmod_mat(len(columns), count, entries, p).rank())


def _in_letters(order: Sequence[Any], exprs: Sequence[Any]) -> list[Any] | None:
    """Expressions as polynomials in the letters; None where they hold anything else."""
    symbols = [se.Symbol(f"letter {i}") for i in range(len(order))]
    renamed = dict(zip(order, symbols, strict=True))
    context = flint.fmpq_mpoly_ctx.get([f"x{i}" for i in range(len(order))], "degrevlex")
    ring = Ring([*(e.xreplace(renamed) for e in exprs), *symbols])
    places = [ring.index(x) for x in symbols]
    found = []
    for e in exprs:
        element, terms = ring.fraction(e.xreplace(renamed)), {}
        for monomial, c in element.num.to_dict().items():
            terms[tuple(int(monomial[i]) for i in places)] = c
            if sum(map(int, monomial)) > sum(int(monomial[i]) for i in places):
                return None
        if element.den:
            return None
        found.append(context.from_dict(terms))
    return found


def _leading(relations: Sequence[Any]) -> tuple[tuple[int, ...], ...]:
    """The leading monomials of a Groebner basis, by total degree first."""
    if not relations:
        return ()
    basis = groebner_basis(relations, relations[0].context())
    return tuple(tuple(int(e) for e in next(iter(f.to_dict()))) for f in basis)


def _products(exponents: Array, letters: Array, p: int) -> Array:
    """The values of monomials, (monomial, point); each is a letter times one before it."""
    found = np.ones((len(exponents), letters.shape[1]), dtype=np.int64)
    for i, parent, letter in _steps(exponents):
        found[i] = found[parent] * letters[letter] % p
    return found


def _rank_of_products(exponents: Array, letters: Sequence[Any], length: int, p: int) -> int:
    """The rank of the series of monomials."""
    found = [flint.nmod_poly([1], p)] * len(exponents)
    for i, parent, letter in _steps(exponents):
        found[i] = found[parent].mul_low(letters[letter], length)
    entries: list[int] = []
    for poly in found:
        row = poly.coeffs()
        entries += row
        entries += [0] * (length - len(row))
    return int(flint.nmod_mat(len(exponents), length, entries, p).rank())


def _steps(exponents: Array) -> Iterator[tuple[int, int, int]]:
    """Of each monomial but 1 its place, that of one with a letter less, and the letter."""
    places = {tuple(row): i for i, row in enumerate(exponents.tolist())}
    for row, i in places.items():
        for letter, e in enumerate(row):
            if e:
                yield i, places[(*row[:letter], e - 1, *row[letter + 1 :])], letter
                break
