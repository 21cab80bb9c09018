"""Rational functions of several variables, from their values modulo primes.

Degrees are found along lines, then numerator and denominator by linear algebra over all monomials
within these degrees, then the coefficients from several primes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import flint
import numpy as np

from voronec.analysis.search.residues import PRIMES, Array, fraction_of, kernel
from voronec.errors import EngineLimit

__all__ = ["Quotient", "rational_functions"]

LINE = 26
"""Values along a line: the degrees of numerator and denominator may add up to less than this."""
UNKNOWN_LIMIT = 900
"""How many coefficients numerator and denominator may have together."""

Monomial = tuple[int, ...]
Sampler = Callable[[Array, int], Array]
"""Points (point, variable) and a prime -> the values of several functions, (function, point)."""


@dataclass(frozen=True)
class Quotient:
    """numerator/denominator, as {exponents: coefficient}."""

    numerator: dict[Monomial, Any]
    denominator: dict[Monomial, Any]


def rational_functions(
    sample: Sampler, variables: int, rng: Any, primes: Sequence[int] = PRIMES
) -> list[Quotient]:
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
) -> list[Quotient]:
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
        found = _fractions(residues, shapes, modulus)
        if found is not None and _agree(found, sample, variables, rng, primes[-1]):
            return found
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
) -> list[Quotient] | None:
    found = []
    for vector, (above, below) in zip(residues, shapes, strict=True):
        numbers = [fraction_of(int(r), modulus) for r in vector]
        if any(n is None for n in numbers):
            return None
        exact = [flint.fmpq(*n) for n in numbers if n is not None]
        found.append(
            Quotient(
                dict(zip(above, exact[: len(above)], strict=True)),
                dict(zip(below, exact[len(above) :], strict=True)),
            )
        )
    return found


def _agree(found: Sequence[Quotient], sample: Sampler, variables: int, rng: Any, p: int) -> bool:
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
