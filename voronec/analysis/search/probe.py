"""Values modulo a prime of an ansatz and of its rate of change, at random points of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from voronec.algebra.ring import sparse_terms
from voronec.analysis.search.independence import Independence
from voronec.analysis.search.residues import PRIMES, Array, inverse
from voronec.analysis.search.variety import Variety
from voronec.errors import EngineLimit
from voronec.vector_field import VectorField

__all__ = ["Probe", "Values"]

TRIES = 20


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
        dynamics = [*field.rates, *field.force, *(e for row in field.mass for e in row)]
        own = [*letters, *(f.diff(x) for f in letters for x in variables), *dynamics]
        present: set[Any] = set().union(*(e.free_symbols for e in (*functions, *dynamics)))
        parameters = [s for s in field.parameters if s in present]
        self.variety = Variety([*functions, *slopes, *dynamics], field.relations, parameters)
        self.functions, self._searched = len(functions), own
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
        found = []
        for i in range(self.count, self.count + self.known):
            above = self.variety.fractions[i].num
            parts = [_degree(above, moving), _degree(above, still)]
            for factor, power in self.variety.denominators(i):
                parts[0] -= power * _degree(factor, moving)
                parts[1] -= power * _degree(factor, still)
            found.append((parts[0], parts[1]))
        return found

    def settings(self, number: int, p: int, rng: Any) -> Array:
        """Random values of the parameters."""
        return np.array(rng.integers(1, p, (number, len(self.constants)), dtype=np.int64))

    def at(self, parameters: Array, count: int, p: int, rng: Any) -> list[Values | None]:
        """Values at ``count`` points for each setting of the parameters; None where there are no
        points."""
        drawn, enough = self.variety.draw(parameters, count, p, rng)
        found: list[Values | None] = [None] * len(parameters)
        motion, regular = self._motion(drawn, p)
        regular &= (drawn[: self.count] != 0).all(axis=(0, 2))
        for s, i in enumerate(np.flatnonzero(enough)):
            if regular[s]:
                found[i] = self._values(drawn[:, s], motion[:, s], parameters[i], p)
        return found

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
                (found,) = self.at(self.settings(1, p, rng), count, p, rng)
                if found is not None:
                    return found
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
        rows = np.concatenate([mass, force[:, None]], axis=1) % p
        regular = np.ones(drawn.shape[1:], dtype=bool)
        for i in range(n):
            for j in range(i + 1, n):  # a row that is not zero there comes up
                rows[i] = np.where(rows[i, i] == 0, (rows[i] + rows[j]) % p, rows[i])
            regular &= rows[i, i] != 0
            rows[i] = rows[i] * inverse(rows[i, i], p) % p
            for j in range(n):
                if j != i:
                    rows[j] = (rows[j] - rows[j, i] * rows[i]) % p
        return np.concatenate([rates, rows[:, n]]), np.asarray(regular.all(axis=1))

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


def _degree(poly: Any, generators: set[int]) -> int:
    """The degree of a polynomial in some of its generators."""
    terms = sparse_terms(poly)
    return max((sum(e for g, e in m if g in generators) for m in terms), default=0)
