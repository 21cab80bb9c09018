"""Values modulo a prime of an ansatz and of its rate of change, at random points of the motion.

Every expression is a fraction in the generators of a ring; the values of these are drawn at
random, those of radicals and of variables bound by relations computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import isqrt
from typing import Any

import flint
import numpy as np

from voronec.algebra.groebner import groebner_basis
from voronec.algebra.ring import Ring, sparse_terms
from voronec.algebra.verdicts import PROOF_LIMIT
from voronec.equations.vector_field import VectorField
from voronec.errors import EngineLimit
from voronec.proof.search.independence import Independence
from voronec.proof.search.residues import PRIMES, Array, as_residue, inverse, root

SURPLUS = 40
"""Points drawn beyond those asked for; some fall out because a square root does not exist."""
SIGNS = 40
"""At so many points a square root must exist before what is under it counts as a square."""
SIGN_LIMIT = 10
"""With so many roots some may be met at too few points, and count as doubtful."""


@dataclass(frozen=True)
class _Bound:
    """A generator that is a root of a polynomial in earlier ones, of degree one or two."""

    generator: int
    polynomial: dict[int, Any]


class Variety:
    """Values of ``exprs`` at random points where ``relations`` vanish.

    ``parameters`` are the symbols that keep one value for many points.
    """

    def __init__(
        self, exprs: Sequence[Any], relations: Sequence[Any], parameters: Sequence[Any]
    ) -> None:
        self.ring = Ring([*exprs, *relations, *parameters], (), PROOF_LIMIT)
        self.fractions = [self.ring.fraction(e) for e in exprs]
        equations = [self.ring.fraction(r).num for r in relations]
        self.relations = [e for e in equations if e != 0]
        self._rules = {g: (q, self.ring.field.gens[g] ** q - r) for g, q, r in self.rules}
        self.fixed = self._parameter_generators(parameters)
        self.parameters = sorted((self.fixed & self._present()) - set(self._rules))
        self._bound = self._triangular()

    @property
    def constants(self) -> list[Any]:
        """What keeps one value for many points: the parameters and what is made of them."""
        return [self.ring.meaning[i] for i in self.parameters]

    @property
    def rules(self) -> list[tuple[int, int, Any]]:
        """(generator, q, g^q - f) for each radical and each sine."""
        return list(self.ring.field.rules)

    @property
    def size(self) -> int:
        """How many generators there are."""
        return len(self.ring.meaning)

    def has_numbers(self, p: int) -> bool:
        """Whether the roots of numbers exist modulo p."""
        for degree, under in self._rules.values():
            if under.is_constant():
                (number,) = sparse_terms(under).values() or (flint.fmpq(0),)
                _, exists = root(np.array([as_residue(number, p)]), degree, p)
                if not exists.all():
                    return False
        return True

    def ambiguous(self, p: int, rng: Any) -> list[Any]:
        """What roots of even degree are taken of that are not proved to bring in something new.

        A square has a root at every point: one without disproves it.
        """
        rules = self._rules.items()
        even = [g for g, (q, under) in rules if q % 2 == 0 and not under.is_constant()]
        total = SIGNS * 2 ** min(len(self.rules) + len(self._bound), SIGN_LIMIT)
        genuine: set[int] = set()
        alive = np.ones(total, dtype=bool)
        self._fill([None] * self.size, alive, total, p, rng, genuine)
        sines = {s for s, _ in self.ring.angle_indices()}
        doubtful = [g for g in even if g not in genuine | sines]
        bases = {self.ring.index(e): base for base, e in self.ring.roots.items()}
        return [bases[g] for g in doubtful]

    def denominators(self, index: int) -> list[tuple[Any, int]]:
        """The factors under an expression, with their powers."""
        return list(self.ring.field.factors(self.fractions[index].den))

    def _present(self) -> set[int]:
        """The generators that occur."""
        polynomials = [*self.relations, *(f for _, f in self._rules.values())]
        for i, f in enumerate(self.fractions):
            polynomials += [f.num, *(factor for factor, _ in self.denominators(i))]
        return {g for poly in polynomials for m in sparse_terms(poly) for g, _ in m}

    def _parameter_generators(self, parameters: Sequence[Any]) -> set[int]:
        """The generators that depend on nothing but parameters."""
        free = set(parameters)
        return {i for i, e in enumerate(self.ring.meaning) if e.free_symbols <= free}

    def _triangular(self) -> list[_Bound]:
        """The relations, each solved for one generator in terms of those before."""
        if not self.relations:
            return []
        used = {g for r in self.relations for m in sparse_terms(r) for g, _ in m}
        if used & set(self._rules):
            raise EngineLimit("relations that hold sines or roots are not solved")
        order = sorted(used, key=lambda g: (g in self.fixed, -g))
        place = {g: i for i, g in enumerate(order)}
        context = flint.fmpq_mpoly_ctx.get([f"z{i}" for i in range(len(order))], "lex")
        moved = []
        for poly in self.relations:
            terms = {}
            for monomial, coefficient in sparse_terms(poly).items():
                exponents = [0] * len(order)
                for g, e in monomial:
                    exponents[place[g]] = e
                terms[tuple(exponents)] = coefficient
            moved.append(context.from_dict(terms))
        leading: dict[int, list[Any]] = {}
        for poly in groebner_basis(moved, context):
            highest = next(i for i, d in enumerate(poly.degrees()) if d)
            leading.setdefault(highest, []).append(poly)
        solved = []
        for i in sorted(leading, reverse=True):
            power, _, poly = min((int(f.degrees()[i]), k, f) for k, f in enumerate(leading[i]))
            if order[i] in self.fixed or power > 2:
                raise EngineLimit("the relations are not solved by square roots alone")
            solved.append(_Bound(order[i], self._by_power(poly, i, order)))
        return solved

    def _by_power(self, poly: Any, top: int, order: Sequence[int]) -> dict[int, Any]:
        parts: dict[int, Any] = {}
        context = self.ring.field.context
        for monomial, coefficient in poly.to_dict().items():
            exponents = [0] * self.size
            for i, e in enumerate(monomial):
                if i != top:
                    exponents[order[i]] = int(e)
            part = parts.setdefault(int(monomial[top]), {})
            part[tuple(exponents)] = coefficient
        return {power: context.from_dict(terms) for power, terms in parts.items()}

    def draw(self, parameters: Array, count: int, p: int, rng: Any) -> tuple[Array, Array]:
        """Values of the expressions, (expression, setting, point), for settings of the parameters.

        The second array says which settings have ``count`` points; the others are to be left out.
        """
        roots = sum(2 in b.polynomial for b in self._bound)
        roots += sum(degree % 2 == 0 for degree, _ in self._rules.values())
        trials = 2**roots * (count + 8 * isqrt(count) + SURPLUS)
        settings = len(parameters)
        values: list[Any] = [None] * self.size
        for i, column in zip(self.parameters, parameters.T, strict=True):
            values[i] = np.repeat(column % p, trials)
        alive = np.ones(settings * trials, dtype=bool)
        self._fill(values, alive, settings * trials, p, rng)
        for relation in self.relations:
            alive &= self._polynomial(relation, values, p) == 0
        enough = alive.reshape(settings, trials).sum(axis=1) >= count
        rows = alive.reshape(settings, trials)
        keep = np.concatenate(
            [s * trials + np.flatnonzero(rows[s])[:count] for s in np.flatnonzero(enough)]
            or [np.zeros(0, dtype=np.int64)]
        )
        values = [v[keep] for v in values]
        table, sound = self._evaluate(values, p)
        whole = sound.reshape(int(enough.sum()), count).all(axis=1)
        shaped = table.reshape(len(table), int(enough.sum()), count)[:, whole]
        enough[enough] = whole
        return shaped, enough

    def _fill(
        self,
        values: list[Any],
        alive: Array,
        total: int,
        p: int,
        rng: Any,
        genuine: set[int] | None = None,
    ) -> None:
        """Give every generator its values; ``alive`` loses the points that do not exist.

        ``genuine`` gains the roots that some points do not have.
        """
        bound = {b.generator for b in self._bound}
        for i in range(self.size):
            if values[i] is None and i not in bound and i not in self._rules:
                values[i] = rng.integers(1, p, total, dtype=np.int64)
        for b in self._bound:
            self._solve(b, values, alive, p)
        for generator, degree, _ in reversed(self.rules):  # inner radicals before outer ones
            value = self._polynomial(self._rules[generator][1], values, p)
            radical, exists = root(value, degree, p)
            values[generator] = radical
            if genuine is not None and (alive & ~exists).any():
                genuine.add(generator)
            alive &= exists

    def _solve(self, b: _Bound, values: list[Any], alive: Array, p: int) -> None:
        """The linear or quadratic equation of one generator.

        Of two roots one is taken: as the other generators vary, no polynomial tells which.
        """
        zero = np.zeros(len(alive), dtype=np.int64)
        c, d, a = (
            self._polynomial(b.polynomial[k], values, p) if k in b.polynomial else zero
            for k in (0, 1, 2)
        )
        if 2 not in b.polynomial:
            alive &= d != 0
            values[b.generator] = -c * inverse(d, p) % p
            return
        radical, exists = root((d * d - 4 * a % p * c) % p, 2, p)
        alive &= exists & (a != 0)
        values[b.generator] = (radical - d) % p * inverse(2 * a % p, p) % p

    def _polynomial(self, poly: Any, values: Sequence[Any], p: int) -> Array:
        length = next(len(v) for v in values if v is not None)
        total = np.zeros(length, dtype=np.int64)
        powers: dict[tuple[int, int], Array] = {}

        def power(g: int, e: int) -> Array:
            known = powers.get((g, e))
            if known is None:
                known = values[g] if e == 1 else power(g, e - 1) * values[g] % p
                powers[g, e] = known
            return known

        for monomial, coefficient in sparse_terms(poly).items():
            term = np.full(length, as_residue(coefficient, p), dtype=np.int64)
            for g, e in monomial:
                term = term * power(g, e) % p
            total = (total + term) % p
        return total

    def _evaluate(self, values: Sequence[Any], p: int) -> tuple[Array, Array]:
        """All expressions, and at which points none of them has a vanishing denominator."""
        length = len(values[0]) if values else 0
        sound = np.ones(length, dtype=bool)
        below: dict[str, Array] = {}
        rows = []
        for i, f in enumerate(self.fractions):
            value = self._polynomial(f.num, values, p)
            for factor, power in self.denominators(i):
                key = str(factor)
                if key not in below:
                    divisor = self._polynomial(factor, values, p)
                    sound &= divisor != 0
                    below[key] = inverse(divisor, p)
                for _ in range(power):
                    value = value * below[key] % p
            rows.append(value)
        return np.array(rows, dtype=np.int64).reshape(len(rows), length), sound


TRIES = 20
"""Points that may be singular modulo a prime, one after the other."""


@dataclass(frozen=True)
class Values:
    """At each point: letters and known functions, their rates, their gradients by the variables.

    All arrays are (function, point) or (function, variable, point), modulo ``p``; ``parameters``
    are the values of the parameters.
    """

    p: int
    parameters: Array
    letters: Array
    slopes: Array
    known: Array
    known_rates: Array
    known_slopes: Array
    relation_slopes: Array
    motion: Array

    @property
    def points(self) -> int:
        """How many points there are."""
        return int(self.motion.shape[1])

    @cached_property
    def logarithmic(self) -> Array:
        """The rates of the letters, each over the letter."""
        rates = np.zeros(self.letters.shape, dtype=np.int64)
        for i, moved in enumerate(self.motion):
            rates = (rates + self.slopes[:, i] * moved) % self.p
        return rates * inverse(self.letters, self.p) % self.p

    def monomials(self, exponents: Array) -> Array:
        """The values of monomials, (point, monomial)."""
        columns = []
        powers = [[np.ones(self.points, dtype=np.int64)] for _ in self.letters]
        for row in exponents:
            value = powers[0][0] if len(powers) else np.ones(self.points, dtype=np.int64)
            for i in np.flatnonzero(row):
                while len(powers[i]) <= row[i]:
                    powers[i].append(powers[i][-1] * self.letters[i] % self.p)
                value = value * powers[i][row[i]] % self.p
            columns.append(value)
        return np.array(columns, dtype=np.int64).reshape(len(columns), self.points).T

    def rates(self, exponents: Array, values: Array) -> Array:
        """The rates of change of monomials, (point, monomial), from their values."""
        return values * ((exponents @ self.logarithmic) % self.p).T % self.p

    def gradient(self, exponents: Array, values: Array, vector: Array) -> Array:
        """The gradient of a sum of monomials with coefficients, (variable, point)."""
        over = inverse(self.letters, self.p)
        rows = []
        for i in range(self.slopes.shape[1]):
            each = (exponents @ (self.slopes[:, i] * over % self.p)) % self.p
            terms = values.T * each % self.p * vector[:, None] % self.p
            rows.append(terms.sum(axis=0) % self.p)
        return np.array(rows)


class Probe:
    """Draws ``Values`` for a field, the letters of an ansatz, and known functions."""

    def __init__(
        self, field: VectorField, letters: Sequence[Any], known: Sequence[Any] = ()
    ) -> None:
        variables = field.variables
        self.field, self.count, self.known = field, len(letters), len(known)
        functions = [*letters, *known, *field.relations]
        slopes = [f.diff(x) for f in functions for x in variables]
        dynamics = field.entries
        searched = [*letters, *(f.diff(x) for f in letters for x in variables), *dynamics]
        present: set[Any] = set().union(*(e.free_symbols for e in (*functions, *dynamics)))
        parameters = [s for s in field.parameters if s in present]
        self.variety = Variety([*functions, *slopes, *dynamics], field.relations, parameters)
        self.functions, self._searched = len(functions), searched
        if any(f.diff(field.time) != 0 for f in functions):
            raise EngineLimit("an ansatz that holds the time is not searched")

    @property
    def constants(self) -> list[Any]:
        """The parameters of which the coefficients of an integral are functions."""
        return self.variety.constants

    def degrees_of_known(self) -> list[tuple[int, int]]:
        """The degrees of each known function in velocities and in everything else that moves."""
        ring, field = self.variety.ring, self.field
        moving = {ring.index(v) for v in field.velocities if ring.has(v)}
        still = set(range(self.variety.size)) - moving - self.variety.fixed
        degrees = []
        for i in range(self.count, self.count + self.known):
            above = self.variety.fractions[i].num
            parts = [_degree(above, moving), _degree(above, still)]
            for factor, power in self.variety.denominators(i):
                parts[0] -= power * _degree(factor, moving)
                parts[1] -= power * _degree(factor, still)
            degrees.append((parts[0], parts[1]))
        return degrees

    def settings(self, number: int, p: int, rng: Any) -> Array:
        """Random values of the parameters."""
        return np.array(rng.integers(1, p, (number, len(self.constants)), dtype=np.int64))

    def at(self, parameters: Array, count: int, p: int, rng: Any) -> list[Values | None]:
        """Values at ``count`` points for each setting of the parameters; None where there are no
        points."""
        drawn, enough = self.variety.draw(parameters, count, p, rng)
        samples: list[Values | None] = [None] * len(parameters)
        motion, regular = self._motion(drawn, p)
        regular &= (drawn[: self.count] != 0).all(axis=(0, 2))
        for s, i in enumerate(np.flatnonzero(enough)):
            if regular[s]:
                samples[i] = self._values(drawn[:, s], motion[:, s], parameters[i], p)
        return samples

    @cached_property
    def primes(self) -> tuple[int, ...]:
        """The primes modulo which the roots of numbers exist."""
        return tuple(p for p in PRIMES if self.variety.has_numbers(p))

    def independence(self, rng: Any) -> Independence:
        """Which functions in the letters and in the equations are taken as independent."""
        ambiguous = self.variety.ambiguous(self.primes[0], rng) if self.primes else ()
        return Independence.of(self._searched, self.field.relations, ambiguous)

    def one(self, count: int, rng: Any) -> Values:
        """Values for some random setting, modulo the first prime that has some."""
        for p in self.primes:
            for _ in range(TRIES):
                (sample,) = self.at(self.settings(1, p, rng), count, p, rng)
                if sample is not None:
                    return sample
        why = "no points were found at which to test an ansatz"
        if not self.primes:
            why += ": no prime was found modulo which all roots of numbers exist; give other values"
        raise EngineLimit(f"system '{self.field.system.name}': {why}")

    def _motion(self, drawn: Array, p: int) -> tuple[Array, Array]:
        """The rates of all variables, and for which settings the mass is regular throughout."""
        n, first = len(self.field.velocities), self.functions * (1 + len(self.field.variables))
        rates = drawn[first : first + len(self.field.rates)]
        rest = drawn[first + len(self.field.rates) :]
        force, mass = rest[:n], rest[n:].reshape(n, n, *drawn.shape[1:])
        solved, regular = solve_each(mass, force[:, None], p)
        return np.concatenate([rates, solved[:, 0]]), np.asarray(regular.all(axis=1))

    def _values(self, drawn: Array, motion: Array, parameters: Array, p: int) -> Values:
        width = len(self.field.variables)
        functions = drawn[: self.functions]
        slopes = drawn[self.functions : self.functions * (1 + width)]
        slopes = slopes.reshape(self.functions, width, drawn.shape[1])
        a, b = self.count, self.count + self.known
        known_rates = np.zeros(functions[a:b].shape, dtype=np.int64)
        for i, moved in enumerate(motion):
            known_rates = (known_rates + slopes[a:b, i] * moved) % p
        return Values(
            p=p,
            parameters=parameters,
            letters=functions[:a],
            slopes=slopes[:a],
            known=functions[a:b],
            known_rates=known_rates,
            known_slopes=slopes[a:b],
            relation_slopes=slopes[b:],
            motion=motion,
        )


def solve_each(matrix: Array, columns: Array, p: int) -> tuple[Array, Array]:
    """matrix^-1 columns at every point, and where that exists; points stand in the last axes."""
    size = len(matrix)
    rows = np.concatenate([matrix, columns], axis=1) % p
    regular = np.ones(rows.shape[2:], dtype=bool)
    for i in range(size):
        for j in range(i + 1, size):  # a row that is not zero there comes up
            rows[i] = np.where(rows[i, i] == 0, (rows[i] + rows[j]) % p, rows[i])
        regular &= rows[i, i] != 0
        rows[i] = rows[i] * inverse(rows[i, i], p) % p
        for j in range(size):
            if j != i:
                rows[j] = (rows[j] - rows[j, i] * rows[i]) % p
    return rows[:, size:], regular


def motion_slopes(field: VectorField, values: Values) -> Array:
    """The slopes of the motion, (variable, by variable, point): the known functions of the values
    begin with the entries of the field."""
    p, still, moving = values.p, len(field.positions), len(field.velocities)
    rates, rest = values.known_slopes[:still], values.known_slopes[still:]
    columns, end = rest[:moving], moving + moving**2
    mass = rest[moving:end].reshape(moving, moving, *rest.shape[1:])
    for k in range(moving):
        columns = (columns - mass[:, k] * values.motion[still + k] % p) % p
    matrix = values.known[still + moving : still + end].reshape(moving, moving, values.points)
    solved, _ = solve_each(matrix, columns, p)
    return np.concatenate([rates, solved])


def _degree(poly: Any, generators: set[int]) -> int:
    """The degree of a polynomial in some of its generators."""
    terms = sparse_terms(poly)
    return max((sum(e for g, e in m if g in generators) for m in terms), default=0)
