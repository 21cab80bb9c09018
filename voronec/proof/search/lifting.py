"""From an integral modulo a prime to one over Q and the parameters.

Each coefficient is a rational function of the parameters, one coefficient being 1; its values at
other parameters and primes come from the same monomials.  Scalings of the system (units of mass
and length, say) make some parameters 1.

Degrees are found along lines, then numerator and denominator by linear algebra over all monomials
within these degrees, then the coefficients from several primes.

Of one class of monomials it is found which of their sums are integrals, and which of these are new.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product
from math import gcd, lcm
from typing import Any, Self

import flint
import numpy as np
import symengine as se

from voronec.algebra.factors import write_polynomial
from voronec.algebra.normal import shortest
from voronec.equations.vector_field import VectorField
from voronec.errors import EngineLimit
from voronec.proof.search.gradings import Gradings
from voronec.proof.search.probe import Probe, Values
from voronec.proof.search.residues import PRIMES, Array, fraction_of, free_columns, kernel

LINE = 26
"""Values along a line: the degrees of numerator and denominator may add up to less than this."""
UNKNOWN_LIMIT = 900
"""How many coefficients numerator and denominator may have together."""

Monomial = tuple[int, ...]
Sampler = Callable[[Array, int], Array]
"""Points (point, variable) and a prime -> the values of several functions, (function, point)."""


@dataclass(frozen=True)
class RationalEntry:
    """numerator/denominator, as {exponents: coefficient}."""

    numerator: dict[Monomial, Any]
    denominator: dict[Monomial, Any]


def rational_functions(
    sample: Sampler, variables: int, rng: Any, primes: Sequence[int] = PRIMES
) -> list[RationalEntry]:
    """The functions behind the values; ``EngineLimit`` where they are too large."""
    p = primes[0]
    base, direction = rng.integers(1, p, (2, variables), dtype=np.int64)
    bounds = [_degrees_along(sample, base, direction, p)]
    for i in range(variables):
        along = np.zeros(variables, dtype=np.int64)
        along[i] = 1
        bounds.append(_degrees_along(sample, base, along, p))
    shapes = []
    for functions in zip(*bounds, strict=True):
        total, single = functions[0], functions[1:]
        shapes.append(tuple(_monomials([s[part] for s in single], total[part]) for part in (0, 1)))
    largest = max(len(above) + len(below) for above, below in shapes)
    if largest > UNKNOWN_LIMIT:
        raise EngineLimit(
            f"the coefficients of an integral have up to {largest} terms; give parameters values"
        )
    return _from_primes(sample, variables, shapes, rng, primes)


def _degrees_along(sample: Sampler, base: Array, along: Array, p: int) -> list[tuple[int, int]]:
    """Degrees of numerator and denominator of each function on a line."""
    places = np.arange(1, LINE + 1, dtype=np.int64)
    points = (base[None, :] + places[:, None] * along[None, :]) % p
    return [_degrees(places.tolist(), row.tolist(), p) for row in sample(points, p)]


def _degrees(places: Sequence[int], values: Sequence[int], p: int) -> tuple[int, int]:
    """Of the rational function through the values, by the Euclidean algorithm."""
    x = flint.nmod_poly([0, 1], p)
    modulus, through = flint.nmod_poly([1], p), flint.nmod_poly([0], p)
    for a, y in zip(places, values, strict=True):
        missing = (y - int(through(a))) * pow(int(modulus(a)), -1, p) % p
        through, modulus = through + modulus * missing, modulus * (x - a)
    before, now = modulus, through
    s, t = flint.nmod_poly([0], p), flint.nmod_poly([1], p)
    best = (now.degree() + t.degree(), now.degree(), t.degree())
    while now.degree() >= 0:
        best = min(best, (now.degree() + t.degree(), now.degree(), t.degree()))
        quotient, rest = divmod(before, now)
        before, now, s, t = now, rest, t, s - quotient * t
    if best[1] < 0:
        return 0, 0
    if best[0] > LINE - 3:
        raise EngineLimit("the coefficients of an integral have a high degree in the parameters")
    return best[1], best[2]


def _monomials(single: Sequence[int], total: int) -> list[Monomial]:
    """Exponents within a bound for each variable and one for their sum."""
    size = 1
    for bound in single:
        size *= bound + 1
    if size > 100 * UNKNOWN_LIMIT:
        raise EngineLimit("the coefficients of an integral have too many terms")
    return [m for m in product(*(range(b + 1) for b in single)) if sum(m) <= total]


def _from_primes(
    sample: Sampler, variables: int, shapes: Sequence[Any], rng: Any, primes: Sequence[int]
) -> list[RationalEntry]:
    """Coefficients modulo more and more primes, until they are those of one fraction each."""
    residues: list[list[int]] = []
    modulus = 1
    for p in primes[:-1]:
        vectors, shapes = _modulo(sample, variables, shapes, p, rng)
        if modulus == 1:
            residues = vectors
        else:
            step = pow(modulus, -1, p)
            residues = [
                [a + modulus * ((b - a) * step % p) for a, b in zip(old, new, strict=True)]
                for old, new in zip(residues, vectors, strict=True)
            ]
        modulus *= p
        entries = _fractions(residues, shapes, modulus)
        if entries is not None and _agree(entries, sample, variables, rng, primes[-1]):
            return entries
    raise EngineLimit("the numbers in an integral are too large to be recovered")


def _modulo(
    sample: Sampler, variables: int, shapes: Sequence[Any], p: int, rng: Any
) -> tuple[list[list[int]], list[Any]]:
    """Coefficients modulo one prime, and the monomials that occur."""
    count = max(len(above) + len(below) for above, below in shapes) + 4
    points = rng.integers(1, p, (count, variables), dtype=np.int64)
    vectors, left = [], []
    for (above, below), values in zip(shapes, sample(points, p), strict=True):
        table = np.concatenate(
            [_powers(points, above, p), -_powers(points, below, p) * values[:, None] % p], axis=1
        )
        basis, _ = kernel(table % p, p)
        if len(basis) != 1:
            raise EngineLimit("the coefficients of an integral could not be recovered")
        vector = basis[0]  # its free coefficient, 1, is the last that occurs, for every prime
        kept = np.flatnonzero(vector)
        vectors.append(vector[kept].tolist())
        left.append(
            (
                [above[i] for i in kept if i < len(above)],
                [below[i - len(above)] for i in kept if i >= len(above)],
            )
        )
    return vectors, left


def _powers(points: Array, monomials: Sequence[Monomial], p: int) -> Array:
    columns = []
    for m in monomials:
        value = np.ones(len(points), dtype=np.int64)
        for i, e in enumerate(m):
            for _ in range(e):
                value = value * points[:, i] % p
        columns.append(value)
    return np.array(columns, dtype=np.int64).reshape(len(monomials), len(points)).T


def _fractions(
    residues: Sequence[Sequence[int]], shapes: Sequence[Any], modulus: int
) -> list[RationalEntry] | None:
    entries = []
    for vector, (above, below) in zip(residues, shapes, strict=True):
        numbers = [fraction_of(int(r), modulus) for r in vector]
        if any(n is None for n in numbers):
            return None
        exact = [flint.fmpq(*n) for n in numbers if n is not None]
        entries.append(
            RationalEntry(
                dict(zip(above, exact[: len(above)], strict=True)),
                dict(zip(below, exact[len(above) :], strict=True)),
            )
        )
    return entries


def _agree(
    found: Sequence[RationalEntry], sample: Sampler, variables: int, rng: Any, p: int
) -> bool:
    """Whether the fractions take the right values at points modulo another prime."""
    points = rng.integers(1, p, (3, variables), dtype=np.int64)
    for q, values in zip(found, sample(points, p), strict=True):
        above, below = (_value(part, points, p) for part in (q.numerator, q.denominator))
        if ((above - below * values) % p).any():
            return False
    return True


def _value(terms: dict[Monomial, Any], points: Array, p: int) -> Array:
    weights = [int(c.p) * pow(int(c.q), -1, p) % p for c in terms.values()]
    columns = _powers(points, list(terms), p) * np.array(weights, dtype=np.int64) % p
    return np.asarray(columns.sum(axis=1) % p)


BATCH = 128
"""Points that are solved for at a time: their table stays in the cache."""
SPARE = 6
"""Points beyond the number of unknown coefficients."""


@dataclass(frozen=True)
class Normalization:
    """Scalings that make the parameters at ``places`` 1: each multiplies one of them alone, with
    weights of all ``parameters`` and of the ``letters``, (scaling, weight)."""

    places: tuple[int, ...]
    parameters: Array
    letters: Array

    @classmethod
    def of(cls, field: VectorField, letters: Sequence[Any], constants: Sequence[Any]) -> Self:
        """That of a field with an ansatz."""
        gradings = Gradings(field, letters, [s for s in constants if s.is_Symbol])
        places, parameters, weights = gradings.normalization(constants)
        return cls(tuple(places), parameters, weights)

    def other_places(self, count: int) -> list[int]:
        """The places of the other parameters."""
        return [i for i in range(count) if i not in self.places]

    def undone(self, quotient: RationalEntry, shift: Array, count: int) -> RationalEntry:
        """A function of the other parameters as one of all, homogeneous of weight ``shift``."""
        left = self.other_places(count)
        parts = []
        for terms in (quotient.numerator, quotient.denominator):
            moved: dict[Monomial, Any] = {}
            for monomial, c in terms.items():
                whole = np.zeros(count, dtype=np.int64)
                whole[left] = monomial
                whole[list(self.places)] = -self.parameters @ whole
                moved[tuple(map(int, whole))] = c
            parts.append(moved)
        above, below = parts
        above = {_raise_power(m, self.places, shift): c for m, c in above.items()}
        lowest = np.min([*above, *below], axis=0) if above or below else np.zeros(count)
        lift = [-int(min(e, 0)) for e in lowest]
        every = range(count)
        return RationalEntry(
            {_raise_power(m, every, lift): c for m, c in above.items()},
            {_raise_power(m, every, lift): c for m, c in below.items()},
        )


def _raise_power(monomial: Monomial, places: Iterable[int], by: Iterable[Any]) -> Monomial:
    raised = list(monomial)
    for i, e in zip(places, by, strict=True):
        raised[i] += int(e)
    return tuple(raised)


def coefficients(
    candidate: ModularIntegral, probe: Probe, normalization: Normalization, rng: Any
) -> list[Any]:
    """The coefficients of an integral, without common factors, in the engine's symbols."""
    count = len(probe.constants)
    left = normalization.other_places(count)

    def sample(points: Array, p: int) -> Array:
        whole = np.ones((len(points), count), dtype=np.int64)
        whole[:, left] = points
        return _sample_coefficients(candidate, probe, whole, p, rng)

    entries = rational_functions(sample, len(left), rng, probe.primes)
    weights = candidate.exponents @ normalization.letters.T
    shifts = weights[candidate.free][None, :] - weights
    whole = [
        normalization.undone(q, shift, count) for q, shift in zip(entries, shifts, strict=True)
    ]
    return _polynomial(whole, probe.constants)


def lift_vector(
    vector: Callable[[Values], Array | None], size: int, probe: Probe, rng: Any
) -> list[Any]:
    """Functions of the parameters, in the engine's symbols, of which ``vector`` finds the values
    from those of a probe at some setting; None where it finds none."""

    def sample(settings: Array, p: int) -> Array:
        columns = []
        for start in range(0, len(settings), BATCH):
            for values in probe.at(settings[start : start + BATCH], size + SPARE, p, rng):
                column = None if values is None else vector(values)
                if column is None:
                    raise EngineLimit("what was found modulo a prime does not hold in general")
                columns.append(column)
        return np.array(columns, dtype=np.int64).reshape(len(settings), size).T

    p = probe.primes[0]
    first = sample(probe.settings(2, p, rng), p)
    numbers = [fraction_of(int(r), p) for r in first[:, 0]]
    if (first[:, 0] == first[:, 1]).all() and None not in numbers:
        return [se.Integer(n[0]) / n[1] for n in numbers if n is not None]
    entries = rational_functions(sample, len(probe.constants), rng, probe.primes)
    return shortest([_expression(q, probe.constants) for q in entries])


def _expression(quotient: RationalEntry, constants: Sequence[Any]) -> Any:
    context = flint.fmpq_mpoly_ctx.get([f"a{i}" for i in range(len(constants))] or ["a"], "lex")
    parts = (_poly(terms, context) for terms in (quotient.numerator, quotient.denominator))
    above, below = (write_polynomial(part, constants) for part in parts)
    return above / below


def lift_kernel(
    table: Callable[[Values], Array], points: int, probe: Probe, rng: Any
) -> Iterator[dict[int, Any]]:
    """The vectors that a table of values of a probe takes to zero, by their entries: each is 1 at
    one place, and the others are functions of the parameters."""
    values = probe.one(points, rng)
    vectors, free = kernel(table(values), values.p)
    for vector, place in zip(vectors, free, strict=True):
        support = [int(i) for i in np.flatnonzero(vector) if i != place]

        def solve(values: Values, support: Sequence[int] = support, place: int = place) -> Any:
            vectors, last = kernel(table(values)[:, [*support, place]], values.p)
            return vectors[0][:-1] if last == [len(support)] else None

        weights = lift_vector(solve, len(support), probe, rng) if support else []
        yield {place: se.Integer(1), **dict(zip(support, weights, strict=True))}


def _sample_coefficients(
    candidate: ModularIntegral, probe: Probe, points: Array, p: int, rng: Any
) -> Array:
    """The coefficients at given parameters, (coefficient, setting)."""
    columns: list[Array] = []
    for start in range(0, len(points), BATCH):
        batch = points[start : start + BATCH]
        for values in probe.at(batch, len(candidate.exponents) + SPARE, p, rng):
            if values is None:
                raise EngineLimit("an integral has no value at some parameters; give them values")
            rates = values.rates(candidate.exponents, values.monomials(candidate.exponents))
            columns.append(_normalized_vector(rates, candidate.free, p))
    return np.array(columns, dtype=np.int64).T


def _normalized_vector(rates: Array, free: int, p: int) -> Array:
    """The only vector that ``rates`` takes to zero, 1 at the place ``free``."""
    others = [j for j in range(rates.shape[1]) if j != free]
    vectors, last = kernel(rates[:, [*others, free]], p)
    if last != [len(others)]:
        raise EngineLimit("an integral found modulo a prime is not one for all parameters")
    vector = np.zeros(rates.shape[1], dtype=np.int64)
    vector[[*others, free]] = vectors[0]
    return vector


def _polynomial(quotients: list[RationalEntry], constants: list[Any]) -> list[Any]:
    """Coefficients multiplied by what makes them polynomials without a common factor."""
    context = flint.fmpq_mpoly_ctx.get([f"a{i}" for i in range(len(constants))] or ["a"], "lex")
    parts = [(_poly(q.numerator, context), _poly(q.denominator, context)) for q in quotients]
    below = reduce(lambda a, b: a * b / a.gcd(b), [d for _, d in parts])
    cleared = [n * (below / d) for n, d in parts]
    common = reduce(lambda a, b: a.gcd(b), cleared)
    cleared = [c / common for c in cleared]
    numbers = [x for c in cleared for x in c.coeffs()]
    scale = flint.fmpq(lcm(*(int(x.q) for x in numbers)), 1)
    scale /= gcd(*(int((x * scale).p) for x in numbers))
    if numbers[0] < 0:
        scale = -scale
    return shortest([write_polynomial(c * scale, constants) for c in cleared])


def _poly(terms: dict[Monomial, Any], context: Any) -> Any:
    width = len(context.names())
    padded = {(*m, *([0] * (width - len(m)))): c for m, c in terms.items()}
    return context.from_dict(padded)


SURPLUS = 25
"""Points beyond the number of unknowns, at which a dependence would have to hold by chance."""
PRODUCT_LIMIT = 300
"""How many products of known integrals are set off at most."""


@dataclass(frozen=True)
class KnownFunction:
    """An integral that is known: its degrees in velocities and positions, and, where it was
    found, its monomials and their coefficients; else its place among the declared ones."""

    degree: int
    positions: int
    place: int = -1
    exponents: Array | None = None
    vector: Array | None = None

    def values(self, at: Values) -> Array:
        """Its values at the points."""
        if self.exponents is None or self.vector is None:
            return np.asarray(at.known[self.place])
        return combine(at.monomials(self.exponents), self.vector, at.p)

    def gradient(self, at: Values) -> Array:
        """Its gradient, (variable, point)."""
        if self.exponents is None or self.vector is None:
            return np.asarray(at.known_slopes[self.place])
        return at.gradient(self.exponents, at.monomials(self.exponents), self.vector)


@dataclass(frozen=True)
class ModularIntegral:
    """An integral modulo p: a sum of independent monomials, one of which has coefficient 1.

    ``free`` is the place of that one.
    """

    exponents: Array
    vector: Array
    free: int


@dataclass(frozen=True)
class Kernel:
    """Of ``independent`` functions of a class, a space of ``dimension`` consists of integrals, of
    which ``known`` are sums of products of known ones."""

    independent: int
    dimension: int
    known: int
    new: tuple[ModularIntegral, ...]


def combine(values: Array, vector: Array, p: int) -> Array:
    """values . vector modulo p."""
    return np.asarray((values * vector % p).sum(axis=1) % p)


def products(known: Sequence[KnownFunction], degree: int, positions: int) -> list[tuple[int, ...]]:
    """Exponents of the products of known integrals within the degrees, 1 first."""
    exponents = []
    for row in _within(known, degree, positions):
        exponents.append(row)
        if len(exponents) == PRODUCT_LIMIT:
            break
    return exponents


def _within(
    known: Sequence[KnownFunction], degree: int, positions: int
) -> Iterator[tuple[int, ...]]:
    if not known:
        yield ()
        return
    first = known[0]
    dv = max(first.degree, 0)
    dq = max(first.positions, 1) if dv == 0 else 0
    power = 0
    while power * dv <= degree and power * dq <= positions:
        for rest in _within(known[1:], degree - power * dv, positions - power * dq):
            yield (power, *rest)
        power += 1


def product_values(
    known: Sequence[KnownFunction], powers: Sequence[tuple[int, ...]], at: Values
) -> Array:
    """The values of products of known integrals, (point, product)."""
    factors = [k.values(at) for k in known]
    columns = []
    for row in powers:
        value = np.ones(at.points, dtype=np.int64)
        for factor, e in zip(factors, row, strict=True):
            for _ in range(e):
                value = value * factor % at.p
        columns.append(value)
    return np.array(columns, dtype=np.int64).T


def investigate(exponents: Array, at: Values, known: Array) -> Kernel:
    """The integrals among sums of monomials; ``known``: values of known ones, (point, integral)."""
    values = at.monomials(exponents)
    _, independent = free_columns(values, at.p)
    exponents, values = exponents[independent], values[:, independent]
    rates = at.rates(exponents, values)
    vectors, free = _sparse_kernel(rates, at.p)
    if not free:
        return Kernel(len(independent), 0, 0, ())
    # Known ones inside the class: sums of products that are sums of its monomials.
    together, _ = kernel(np.concatenate([values, known], axis=1), at.p)
    inside, pivots = free_columns(together[:, : len(independent)][:, free], at.p)
    new = [_candidate(exponents, vectors[i], j) for i, j in enumerate(free) if i not in set(pivots)]
    return Kernel(len(independent), len(free), len(inside), tuple(new))


def _sparse_kernel(rates: Array, p: int) -> tuple[Array, list[int]]:
    """The kernel in echelon form, by the order of the columns or its reverse: the sparser one."""
    vectors, free = kernel(rates, p)
    if not free:
        return vectors, free
    turned, ends = kernel(rates[:, ::-1], p)
    turned, ends = turned[:, ::-1], [rates.shape[1] - 1 - j for j in ends]
    if np.count_nonzero(turned) < np.count_nonzero(vectors):
        return turned, ends
    return vectors, free


def _candidate(exponents: Array, vector: Array, free: int) -> ModularIntegral:
    support = np.flatnonzero(vector)
    place = int(np.flatnonzero(support == free)[0])
    return ModularIntegral(exponents[support], vector[support], place)


def rank_of(gradients: Sequence[Array], at: Values) -> int:
    """The rank of the gradients of functions at one point: so many are independent there."""
    rows = [*(g[:, 0] for g in at.relation_slopes), *(g[:, 0] for g in gradients)]
    if not rows:
        return 0
    _, pivots = free_columns(np.array(rows, dtype=np.int64), at.p)
    return len(pivots)
