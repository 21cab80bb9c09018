"""What the search for integrals rests on: residues, points on varieties, interpolation."""

from __future__ import annotations

import flint
import numpy as np
import pytest
import symengine as se

from voronec import EngineLimit
from voronec.proof.search.lifting import rational_functions
from voronec.proof.search.probe import Variety
from voronec.proof.search.residues import PRIMES, fraction_of, inverse, kernel, root

p = PRIMES[0]
x, y, z, a, b = se.symbols("x y z a b")


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def test_the_primes_are_safe_and_their_products_fit() -> None:
    for prime in PRIMES:
        assert flint.fmpz(prime).is_prime() and flint.fmpz((prime - 1) // 2).is_prime()
        assert prime % 4 == 3 and prime < 2**31
    assert len(set(PRIMES)) == len(PRIMES)


@pytest.mark.parametrize("degree", [2, 3, 4, 5, 6])
def test_roots_are_roots_where_they_exist(degree: int, rng) -> None:
    values = rng.integers(1, p, 400, dtype=np.int64)
    found, exists = root(values, degree, p)
    powers = np.array([pow(int(r), degree, p) for r in found])
    assert (powers[exists] == values[exists]).all()
    assert exists.all() if degree % 2 else 100 < exists.sum() < 300
    lost = values[~exists].tolist()
    assert all(pow(v, (p - 1) // 2, p) == p - 1 for v in lost)  # no square at all


def test_inverses_and_kernels() -> None:
    values = np.array([1, 2, p - 1, 12345], dtype=np.int64)
    assert (values * inverse(values, p) % p == 1).all()
    matrix = np.array([[1, 2, 3], [2, 4, 6]], dtype=np.int64)
    vectors, free = kernel(matrix, p)
    assert free == [1, 2] and not (matrix @ vectors.T % p).any()
    assert vectors[:, free].tolist() == [[1, 0], [0, 1]]


@pytest.mark.parametrize("fraction", [(0, 1), (-7, 3), (30000, 31001), (1, 32767)])
def test_small_fractions_come_back_from_residues(fraction) -> None:
    n, d = fraction
    assert fraction_of(n * pow(d, -1, p) % p, p) == fraction


def test_points_lie_on_the_variety(rng) -> None:
    u, v, w = se.symbols("u v w")
    relations = [x**2 + y**2 + z**2 - 1, u**2 + v**2 + w**2 - a, x * u + y * v + z * w]
    exprs = [*relations, se.sqrt(1 + x**2) ** 2 - 1 - x**2, se.sin(b) ** 2 + se.cos(b) ** 2, x, a]
    variety = Variety(exprs, relations, [a])
    drawn, enough = variety.draw(rng.integers(1, p, (3, 1), dtype=np.int64), 30, p, rng)
    assert enough.all() and drawn.shape == (len(exprs), 3, 30)
    assert not drawn[:4].any() and (drawn[4] == 1).all()
    assert len(set(drawn[5].ravel().tolist())) == 90  # the points differ
    assert [len(set(row.tolist())) for row in drawn[6]] == [1, 1, 1]  # the parameter stays


def test_relations_beyond_square_roots_are_a_limit() -> None:
    with pytest.raises(EngineLimit, match="square roots"):
        Variety([x], [x**3 + y**3 - 1], [])


def sampler(*functions):
    def sample(points, prime):
        rows = []
        for above, below in functions:
            values = [above(*map(int, q)) * pow(below(*map(int, q)), -1, prime) for q in points]
            rows.append([v % prime for v in values])
        return np.array(rows, dtype=np.int64)

    return sample


def test_rational_functions_come_back_from_their_values(rng) -> None:
    first = (lambda s, t: 3 * s**2 * t - 7 * t, lambda s, t: s + 5 * t**2)
    second = (lambda s, t: 10**12 + 39, lambda s, t: 7)
    third = (lambda s, t: 0, lambda s, t: 1)
    one, two, three = rational_functions(sampler(first, second, third), 2, rng)
    lead = one.denominator[1, 0]
    assert {m: c / lead for m, c in one.numerator.items()} == {(2, 1): 3, (0, 1): -7}
    assert {m: c / lead for m, c in one.denominator.items()} == {(1, 0): 1, (0, 2): 5}
    assert two.numerator[0, 0] / two.denominator[0, 0] == flint.fmpq(10**12 + 39, 7)
    assert not any(three.numerator.values())


def test_high_degrees_are_a_limit(rng) -> None:
    high = (lambda s: s**20 + 1, lambda s: s**19 - 3)
    with pytest.raises(EngineLimit, match="high degree"):
        rational_functions(sampler(high), 1, rng)
