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

from voronec.algebra.arguments import COUNT, FLAG, VALUES, accepts
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
from voronec.proof.search.outcome import plain_data
from voronec.proof.search.probe import TRIES, Variety, solve_each
from voronec.proof.search.residues import PRIMES, Array, as_residue, free_columns, inverse
from voronec.proof.search.search import (
    known_integrals,
    parameter_values,
    read_expressions,
    require_bound,
    specialize_field,
)

SURPLUS = 10
"""Coefficients of a series, and points, beyond the number of unknowns."""
ORBITS = 3
"""So many orbits, each modulo its own prime, before an excess is reported."""
ENTRY = 100
"""Bytes for one entry of the matrix: as a number of Python's twice, as a residue, and as a list."""


@dataclass(frozen=True)
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

    def _repr_html_(self) -> str:
        """For notebooks: the numbers and the statement."""
        rows = [("excess", str(self.excess)), ("statement", self.statement)]
        return html_table(f"rational integrals of {self.system}", rows)

    @property
    def excess(self) -> int:
        """How many polynomials may vanish on an orbit that are no multiples of known integrals."""
        return self.monomials - self.rank - self.explained

    @property
    def is_decided(self) -> bool:
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
        if self.is_decided:
            return f"No further rational integral {form}{where}. Known: {known}."
        return (
            f"Undecided: {self.excess} more polynomials {form} vanish on the orbits tried than the "
            f"known integrals explain{where}. There may be a further integral. Known: {known}."
        )

    def as_dict(self) -> dict[str, Any]:
        """The outcome as text and numbers that JSON can hold."""
        numbers = {"excess": self.excess, "decided": self.is_decided, "statement": self.statement}
        return {**plain_data(self), **numbers}


@accepts(degree=COUNT, at=VALUES, momenta=FLAG, seed=COUNT)
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
    require_bound("degree", degree, 1)
    motions = Motions.of(system)
    values = _numbers(motions, at or {})
    field = specialize_field(motions.field_for(()), values)
    claims = known_integrals(motions, field, values)
    known = {
        n: f for n, f in claims.items() if decide_zero(field.derivative(f), field.hypotheses).proved
    }
    flow = RationalFlow(field)
    letters = _LetterFunctions.of(field, flow, known, momenta)
    _require_memory(len(letters.names), degree)
    exponents = letters.monomials(degree)
    rank = explained = 0
    rng = np.random.default_rng(abs(seed))
    for p in letters.primes()[:ORBITS]:
        explained = max(explained, letters.rank_of_multiples(exponents, degree, p, rng))
        length = len(exponents) - explained + SURPLUS
        rank = max(rank, letters.rank_along_orbit(exponents, length, p, rng))
        if rank + explained == len(exponents):
            break
    return RationalBound(
        system=field.system.name,
        degree=degree,
        letters=letters.names,
        at=values,
        known=tuple(letters.known),
        monomials=len(exponents),
        rank=rank,
        explained=explained,
        formal=_violations(motions.system, body, values),
        seconds=perf_counter() - begin,
    )


def _numbers(motions: Motions, at: Mapping[Any, Any]) -> dict[sp.Expr, sp.Expr]:
    """A rational value of every parameter that the equations hold."""
    system, field = motions.system, motions.field_for(())
    held = {s for e in (*field.entries, *field.relations) for s in e.free_symbols}
    given = parameter_values(system, at)
    declared = {p.symbol: as_expression(p.value) for p in system.parameters if p.value is not None}
    exact = {s: sp.Rational(v) if v.is_Float else v for s, v in declared.items() if s not in given}
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


def _violations(system: System, body: Sequence[Any], values: Mapping[Any, Any]) -> tuple[str, ...]:
    """The conditions on the parameters that values do not meet."""
    named = {p.name: p.symbol for p in system.parameters}
    known = read_expressions(system, body, "body")
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
        table = np.zeros((len(self.rows), len(self.nodes)), dtype=np.int64)
        for line, row in zip(table, self.rows, strict=True):
            for monomial, coefficient in row.items():
                line[self.nodes[monomial]] = as_residue(coefficient, p)
        return table

    def values(self, points: Array, p: int) -> Array:
        """(polynomial, point) from (generator, point)."""
        at = np.ones((len(self.nodes), points.shape[1]), dtype=np.int64)
        at[1 : len(points) + 1] = points
        for level in self.levels:
            for node, a, b in level:
                at[node] = at[a] * at[b] % p
        rows = self.coefficients(p)
        sums = [(row[:, None] * at % p).sum(axis=0) % p for row in rows]
        return np.array(sums, dtype=np.int64).reshape(len(rows), points.shape[1])


class RationalFlow:
    """The motion as polynomials L(x) x' - R(x) that vanish along it, in ``generators`` x -
    coordinates, or cosine and sine of angles, and velocities - and their slopes x'."""

    def __init__(self, field: VectorField) -> None:
        held: set[Any] = set().union(*(e.free_symbols for e in field.entries))
        if field.time in held:
            raise EngineLimit("equations that hold the time have no rank test")
        free = [q for q in field.positions if q not in held]
        state_ring = Ring([*field.entries, *field.relations, *field.velocities, *free])
        allowed = {*field.variables, *(g for pair in state_ring.pairs.values() for g in pair)}
        for foreign in (e for e in state_ring.meaning if e not in allowed):
            raise EngineLimit(
                f"the equations hold '{quote(field.bridge.outward(foreign))}'; the rank test takes "
                "rational ones, in coordinates, cosines and sines"
            )
        self.field, self.pairs, self.generators = field, state_ring.pairs, list(state_ring.meaning)
        self.place = {g: i for i, g in enumerate(self.generators)}
        slopes = [se.Symbol(f"slope {i}") for i in range(len(self.generators))]
        moved = [slopes[self.place[v]] for v in field.velocities]
        rates = dict(zip(field.positions, field.rates, strict=True))
        pushed = {g: dot([g.diff(q) for q in rates], list(rates.values())) for g in self.generators}
        motion = [slopes[self.place[g]] - e for g, e in pushed.items() if g not in field.velocities]
        motion += [dot(m, moved) - f for m, f in zip(field.mass, field.force, strict=True)]
        self.ring = ring = Ring([*motion, *field.relations, *self.generators])
        self._state, self._slope = ([*map(ring.index, e)] for e in (self.generators, slopes))
        polynomials = [ring.fraction(e).num for e in motion]
        bound = [ring.fraction(r).num for r in field.relations]
        bound += [rule for *_, rule in ring.field.rules]
        self._motion, self._bound, self._matrix, self._gradient = (
            _Polynomials.of(len(ring.meaning), polys)
            for polys in (
                polynomials, bound, [f.derivative(i) for f in polynomials for i in self._slope],
                [f.derivative(i) for f in bound for i in self._state],
            )
        )  # fmt: skip
        self.programs = (self._motion, self._bound, self._matrix, self._gradient)
        self._rank = len(field.independent_relations) + len(ring.field.rules)
        self._variety = Variety(self.generators, field.relations, ())

    def whole(self, states: Array, slopes: Any = 0) -> Array:
        """The values of all generators of the ring."""
        whole = np.zeros((len(self.ring.meaning), states.shape[1]), dtype=np.int64)
        whole[self._state], whole[self._slope] = states, slopes
        return whole

    def values(self, polynomials: _Polynomials, states: Array, p: int) -> Array:
        """Polynomials in the generators at states."""
        return polynomials.values(self.whole(states), p)

    def residuals(self, states: Array, slopes: Array, p: int) -> Array:
        """L(x) x' - R(x) and the relations, at states with given slopes: zero on motions."""
        whole = self.whole(states, slopes)
        return np.concatenate([f.values(whole, p) for f in (self._motion, self._bound)])

    def points(self, count: int, p: int, rng: Any) -> Array:
        """Random states modulo p where the relations hold, (generator, point)."""
        for _ in range(TRIES):
            drawn, enough = self._variety.draw(np.zeros((1, 0), dtype=np.int64), count, p, rng)
            if enough[0]:
                return np.asarray(drawn[:, 0])
        raise EngineLimit(f"system '{self.field.system.name}': no state was found modulo a prime")

    def orbit(self, length: int, p: int, rng: Any) -> tuple[Array, Array]:
        """The power series of the generators and of their slopes from a random start,
        (generator, coefficient), at which the relations are smooth and L is regular."""
        size = len(self.generators)
        for _ in range(TRIES):
            start = self.points(1, p, rng)
            gradient = self.values(self._gradient, start, p).reshape(-1, size)
            matrix = self.values(self._matrix, start, p).reshape(size, size, 1)
            inverted, regular = solve_each(matrix, np.eye(size, dtype=np.int64)[:, :, None], p)
            if regular.all() and len(free_columns(gradient, p)[1]) == self._rank:
                return self._orbit(start[:, 0], inverted[:, :, 0], length, p)
        raise EngineLimit(f"system '{self.field.system.name}': no regular state was found")

    def _orbit(self, start: Array, inverted: Array, length: int, p: int) -> tuple[Array, Array]:
        program, table = self._motion, self._motion.coefficients(p)
        x = np.zeros((len(program.nodes), length), dtype=np.int64)
        state, slope = ([i + 1 for i in places] for places in (self._state, self._slope))
        x[0, 0], x[state, 0] = 1, start
        levels = [np.array(level).T for level in program.levels]
        steps = inverse(np.arange(1, length + 1, dtype=np.int64), p)
        for k in range(length):
            for last in (False, True):  # without the new coefficient of the slopes, then with it
                for node, a, b in levels:
                    x[node, k] = (x[a, : k + 1] * x[b, : k + 1][:, ::-1] % p).sum(axis=1) % p
                if not last:
                    rest = (table * x[:, k] % p).sum(axis=1) % p
                    x[slope, k] = -(inverted * rest % p).sum(axis=1) % p
            if k + 1 < length:
                x[state, k + 1] = x[slope, k] * steps[k] % p
        return x[state], x[slope]


@dataclass(frozen=True)
class _LetterFunctions:
    """What the polynomials of the test are polynomials in, by ``names``, as functions of the
    generators of a flow: numerators and then denominators.

    ``known`` are known integrals A/B, A and B as polynomials in the letters, with the larger of
    their degrees; ``leading`` are the leading monomials of the relations between the letters.
    """

    flow: RationalFlow
    names: tuple[str, ...]
    functions: _Polynomials
    known: dict[str, tuple[_Polynomials, int]]
    leading: tuple[tuple[int, ...], ...]

    @classmethod
    def of(
        cls, field: VectorField, flow: RationalFlow, known: Mapping[str, Any], momenta: bool
    ) -> _LetterFunctions:
        ring, moving = flow.ring, [*field.velocities]
        generators = (g for q in field.positions for g in (q, *flow.pairs.get(q, ())))
        still = [g for g in generators if g in flow.place]
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
        relations = [*field.relations, *(c**2 + s**2 - 1 for c, s in flow.pairs.values())]
        usable = {}
        for name, pair in integrals.items():
            polynomials = _in_letters(order, pair)
            if polynomials is not None:
                degree = max(int(f.total_degree()) for f in polynomials)
                usable[name] = (_Polynomials.of(len(order), polynomials), degree)
        bound = _in_letters(order, relations)
        if bound is None:
            raise EngineLimit("the relations are no polynomials in the letters of the rank test")
        return cls(flow, tuple(names), read, usable, _leading_monomials(bound))

    def primes(self) -> list[int]:
        """Primes that divide no denominator."""
        suitable = []
        integrals = (k for k, _ in self.known.values())
        programs = [*self.flow.programs, self.functions, *integrals]
        for p in PRIMES:
            try:
                for program in programs:
                    program.coefficients(p)
            except ZeroDivisionError:
                continue
            suitable.append(p)
        return suitable

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
        table = self.flow.values(self.functions, states, p)
        size = len(self.names)
        return table[:size] * inverse(table[size:], p) % p

    def rank_along_orbit(self, exponents: Array, length: int, p: int, rng: Any) -> int:
        """How many of the monomials are independent along one orbit, by series of a length."""
        states, slopes = self.flow.orbit(length, p, rng)
        at: list[Any] = [flint.nmod_poly([1], p)]
        at += [flint.nmod_poly(row.tolist(), p) for row in self.flow.whole(states, slopes)]
        at += [None] * (len(self.functions.nodes) - len(at))
        for node, a, b in (step for level in self.functions.levels for step in level):
            at[node] = at[a].mul_low(at[b], length)
        sums = []
        for row in self.functions.coefficients(p):
            terms = [at[i] * int(row[i]) for i in np.flatnonzero(row)]
            sums.append(sum(terms, flint.nmod_poly([0], p)))
        size = len(self.names)
        if not all(int(below[0]) for below in sums[size:]):
            return 0
        parts = zip(sums[:size], sums[size:], strict=True)
        letters = [a.mul_low(b.inverse_series_trunc(length), length) for a, b in parts]
        monomials = [flint.nmod_poly([1], p)] * len(exponents)
        for i, parent, letter in _steps(exponents):
            monomials[i] = monomials[parent].mul_low(letters[letter], length)
        rows = [[*poly.coeffs(), *([0] * length)][:length] for poly in monomials]
        return _rank(rows, p)

    def rank_of_multiples(self, exponents: Array, degree: int, p: int, rng: Any) -> int:
        """How many multiples of the known integrals on a level, of degrees up to the bound, are
        independent functions: their rank at random states."""
        if not self.known:
            return 0
        totals = exponents.sum(axis=1)
        factors = [exponents[totals <= degree - bound] for _, bound in self.known.values()]
        count = sum(map(len, factors)) + SURPLUS
        letters = self.values(self.flow.points(count, p, rng), p)
        values = [known.values(letters, p) for known, _ in self.known.values()]
        columns: list[Array] = []
        regular = np.flatnonzero(np.all([below for _, below in values], axis=0))
        if not len(regular):
            return 0
        place = regular[0]  # the state whose level is meant
        for (above, below), rows in zip(values, factors, strict=True):
            level = above[place] * pow(int(below[place]), -1, p) % p
            vanishing = (above - level * below) % p
            columns += [m * vanishing % p for m in _products(rows, letters, p)]
        return _rank([column.tolist() for column in columns], p)


def _rank(rows: Sequence[Sequence[int]], p: int) -> int:
    width = len(rows[0]) if rows else 0
    return int(flint.nmod_mat(len(rows), width, [x for row in rows for x in row], p).rank())


def _in_letters(order: Sequence[Any], exprs: Sequence[Any]) -> list[Any] | None:
    """Expressions as polynomials in the letters; None where they hold anything else."""
    symbols = [se.Symbol(f"letter {i}") for i in range(len(order))]
    renamed = dict(zip(order, symbols, strict=True))
    context = flint.fmpq_mpoly_ctx.get([f"x{i}" for i in range(len(order))], "degrevlex")
    ring = Ring([*(e.xreplace(renamed) for e in exprs), *symbols])
    places = [ring.index(x) for x in symbols]
    polynomials = []
    for e in exprs:
        element, terms = ring.fraction(e.xreplace(renamed)), {}
        for monomial, c in element.num.to_dict().items():
            terms[tuple(int(monomial[i]) for i in places)] = c
            if sum(map(int, monomial)) > sum(int(monomial[i]) for i in places):
                return None
        if element.den:
            return None
        polynomials.append(context.from_dict(terms))
    return polynomials


def _leading_monomials(relations: Sequence[Any]) -> tuple[tuple[int, ...], ...]:
    """The leading monomials of a Groebner basis, by total degree first."""
    if not relations:
        return ()
    basis = groebner_basis(relations, relations[0].context())
    return tuple(tuple(int(e) for e in next(iter(f.to_dict()))) for f in basis)


def _products(exponents: Array, letters: Array, p: int) -> Array:
    """The values of monomials, (monomial, point); each is a letter times one before it."""
    monomials = np.ones((len(exponents), letters.shape[1]), dtype=np.int64)
    for i, parent, letter in _steps(exponents):
        monomials[i] = monomials[parent] * letters[letter] % p
    return monomials


def _steps(exponents: Array) -> Iterator[tuple[int, int, int]]:
    """Of each monomial but 1 its place, that of one with a letter less, and the letter."""
    places = {tuple(row): i for i, row in enumerate(exponents.tolist())}
    for row, i in places.items():
        for letter, e in enumerate(row):
            if e:
                yield i, places[(*row[:letter], e - 1, *row[letter + 1 :])], letter
                break
