"""From an integral modulo a prime to one over Q and the parameters.

Each coefficient is a rational function of the parameters, one coefficient being 1; its values at
other parameters and primes come from the same monomials.  Scalings of the system (units of mass
and length, say) make some parameters 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from math import gcd, lcm
from typing import Any, Self

import flint
import numpy as np
import symengine as se

from voronec.algebra.normal import shortest
from voronec.analysis.search.gradings import Gradings
from voronec.analysis.search.interpolation import Monomial, Quotient, rational_functions
from voronec.analysis.search.kernels import Candidate
from voronec.analysis.search.probe import Probe
from voronec.analysis.search.residues import Array, kernel
from voronec.errors import EngineLimit
from voronec.vector_field import VectorField

__all__ = ["Normalization", "coefficients"]

BATCH = 128
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

    def left(self, count: int) -> list[int]:
        """The places of the other parameters."""
        return [i for i in range(count) if i not in self.places]

    def undone(self, quotient: Quotient, shift: Array, count: int) -> Quotient:
        """A function of the other parameters as one of all, homogeneous of weight ``shift``."""
        left = self.left(count)
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
        above = {_raised(m, self.places, shift): c for m, c in above.items()}
        lowest = np.min([*above, *below], axis=0) if above or below else np.zeros(count)
        lift = [-int(min(e, 0)) for e in lowest]
        every = range(count)
        return Quotient(
            {_raised(m, every, lift): c for m, c in above.items()},
            {_raised(m, every, lift): c for m, c in below.items()},
        )


def _raised(monomial: Monomial, places: Iterable[int], by: Iterable[Any]) -> Monomial:
    found = list(monomial)
    for i, e in zip(places, by, strict=True):
        found[i] += int(e)
    return tuple(found)


def coefficients(
    candidate: Candidate, probe: Probe, normalization: Normalization, rng: Any
) -> list[Any]:
    """The coefficients of an integral, without common factors, inside the door."""
    count = len(probe.constants)
    left = normalization.left(count)

    def sample(points: Array, p: int) -> Array:
        whole = np.ones((len(points), count), dtype=np.int64)
        whole[:, left] = points
        return _sampled(candidate, probe, whole, p, rng)

    found = rational_functions(sample, len(left), rng, probe.primes)
    weights = candidate.exponents @ normalization.letters.T
    shifts = weights[candidate.free][None, :] - weights
    whole = [normalization.undone(q, shift, count) for q, shift in zip(found, shifts, strict=True)]
    return _polynomial(whole, probe.constants)


def _sampled(candidate: Candidate, probe: Probe, points: Array, p: int, rng: Any) -> Array:
    """The coefficients at given parameters, (coefficient, setting)."""
    columns: list[Array] = []
    for start in range(0, len(points), BATCH):
        batch = points[start : start + BATCH]
        for values in probe.at(batch, len(candidate.exponents) + SPARE, p, rng):
            if values is None:
                raise EngineLimit("an integral has no value at some parameters; give them values")
            rates = values.rates(candidate.exponents, values.monomials(candidate.exponents))
            columns.append(_normalized(rates, candidate.free, p))
    return np.array(columns, dtype=np.int64).T


def _normalized(rates: Array, free: int, p: int) -> Array:
    """The only vector that ``rates`` takes to zero, 1 at the place ``free``."""
    others = [j for j in range(rates.shape[1]) if j != free]
    vectors, last = kernel(rates[:, [*others, free]], p)
    if last != [len(others)]:
        raise EngineLimit("an integral modulo a prime is none for all parameters")
    found = np.zeros(rates.shape[1], dtype=np.int64)
    found[[*others, free]] = vectors[0]
    return found


def _polynomial(quotients: list[Quotient], constants: list[Any]) -> list[Any]:
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
    return shortest([_expression(c * scale, constants) for c in cleared])


def _poly(terms: dict[Monomial, Any], context: Any) -> Any:
    width = len(context.names())
    padded = {(*m, *([0] * (width - len(m)))): c for m, c in terms.items()}
    return context.from_dict(padded)


def _expression(poly: Any, constants: list[Any]) -> Any:
    terms = []
    for monomial, c in poly.to_dict().items():
        number = se.Integer(int(c.p)) / se.Integer(int(c.q))
        powers = [x ** int(e) for x, e in zip(constants, monomial, strict=False) if e]
        terms.append(se.Mul(number, *powers))
    return se.Add(*terms)
