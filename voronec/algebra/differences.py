"""Polynomials in sines and cosines that depend on angles only through differences or sums.

Where the sum of w_a d/da annihilates f, w_a = 1 or -1, f does not change when every angle a is
moved by w_a times the same amount; with the amount that brings one of them, b, to zero,

    f(b, a, ...) = f(0, a - w_a w_b b, ...).

That is an identity, so nothing is lost, and products of sines and cosines of b and a become those
of differences: cos(x) cos(y) + sin(x) sin(y) is cos(x - y).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import flint
import symengine as se

from voronec.algebra.ring import Ring

__all__ = ["Turned", "in_differences"]

MANY = 30_000
"""Polynomials with more terms than this stay in the angles they are in."""
FEW = 40
"""Up to so many terms every angle is tried for the one that stands still."""


@dataclass(frozen=True)
class Turned:
    """A polynomial of a ring in which generators mean other angles than in the ring: ``angles``
    maps positions (sine, cosine) to the angle whose sine and cosine they are."""

    poly: Any
    angles: Mapping[tuple[int, int], Any]

    def meaning(self, ring: Ring) -> dict[Any, Any]:
        """What the ring's sines and cosines are to be replaced by."""
        found = {}
        for (sine, cosine), angle in self.angles.items():
            sign, shown = _leading(angle)
            found[ring.meaning[cosine]] = se.cos(shown)
            found[ring.meaning[sine]] = sign * se.sin(shown)
        return found


def in_differences(ring: Ring, poly: Any) -> Iterator[Turned]:
    """A polynomial in differences and sums of its angles, where it depends on nothing else.

    One way for each of the angles that may stand still, shortened by going from one difference to
    the next where that leaves fewer terms; none where all of the angles are needed.
    """
    angles = _angles(ring, poly)
    if len(angles) < 2 or len(poly) > MANY or ring.field.ideal:
        return
    charges = _symmetry(ring, poly, list(angles))
    held = {still: _at_zero(ring, poly, still) for still in charges}
    fewest = min(map(len, held.values()), default=0)
    for still, rest in held.items():
        if len(rest) > max(fewest, FEW):
            continue
        left = {
            pair: angle - charges.get(pair, 0) * charges[still] * angles[still]
            for pair, angle in angles.items()
            if pair != still
        }
        yield _relinked(ring, Turned(rest, left))


def _leading(angle: Any) -> tuple[int, Any]:
    """The angle or its opposite, so that the symbol that comes first by name is positive."""
    symbols = sorted(angle.free_symbols, key=str)
    first = angle.diff(symbols[0]) if symbols else se.Integer(1)
    return (-1, -angle) if first.is_Number and first < 0 else (1, angle)


def _angles(ring: Ring, poly: Any) -> dict[tuple[int, int], Any]:
    """The angles in a polynomial by the positions of sine and cosine; none where one of them may
    be moved without its sine and cosine telling."""
    degrees = poly.degrees()
    found = {
        pair: ring.meaning[pair[1]].args[0]
        for pair in ring.angle_indices()
        if degrees[pair[0]] or degrees[pair[1]]
    }
    moved = set().union(*(angle.free_symbols for angle in found.values()))
    own = {i for pair in found for i in pair}
    others = [ring.meaning[i] for i, degree in enumerate(degrees) if degree and i not in own]
    return {} if any(expr.free_symbols & moved for expr in others) else found


def _symmetry(ring: Ring, poly: Any, pairs: list[tuple[int, int]]) -> dict[tuple[int, int], int]:
    """Charges 1 and -1 of some angles, moved together by which the polynomial stays the same.

    The derivatives by the angles are added one by one to a basis; the first that depends on those
    before it gives the charges.
    """
    basis: list[tuple[tuple[int, ...], Any, dict[int, Any]]] = []
    for position, (sine, cosine) in enumerate(pairs):
        gens = ring.field.gens
        rate = gens[cosine] * poly.derivative(sine) - gens[sine] * poly.derivative(cosine)
        rest, combination = _reduced(ring, rate), {position: flint.fmpq(1)}
        for lead, known, known_combination in basis:
            factor = rest.to_dict().get(lead, flint.fmpq(0)) / known.leading_coefficient()
            if factor != 0:
                rest = rest - factor * known
                for i, x in known_combination.items():
                    combination[i] = combination.get(i, flint.fmpq(0)) - factor * x
        if rest == 0:
            held = {i: x for i, x in combination.items() if x != 0}
            first = next(iter(held.values()))
            ratios = {i: x / first for i, x in held.items()}
            if len(ratios) > 1 and all(abs(x) == 1 for x in ratios.values()):
                return {pairs[i]: int(x.p) for i, x in ratios.items()}
            return {}
        basis.append((tuple(map(int, rest.monomial(0))), rest, combination))
    return {}


def _reduced(ring: Ring, poly: Any) -> Any:
    """Modulo the rules of the ring, outside its budget: the work is of the size of the result."""
    for _, _, relation in ring.field.rules:
        poly = divmod(poly, relation)[1]
    return poly


def _at_zero(ring: Ring, poly: Any, pair: tuple[int, int]) -> Any:
    """The polynomial where one angle is zero."""
    sine, cosine = pair
    values = list(ring.field.gens)
    values[sine], values[cosine] = ring.field.zero, ring.field.one
    return poly.compose(*values)


def _relinked(ring: Ring, turned: Turned) -> Turned:
    """Angles a written as (a - b) + b or (a + b) - b, as long as that leaves fewer terms."""
    while True:
        shorter = min(_neighbours(ring, turned), key=lambda t: len(t.poly), default=turned)
        if len(shorter.poly) >= len(turned.poly):
            return turned
        turned = shorter


def _neighbours(ring: Ring, turned: Turned) -> Iterator[Turned]:
    gens = ring.field.gens
    for one in turned.angles:
        for other in turned.angles:
            for sign in (1, -1) if one != other else ():
                (s, c), (s2, c2) = ((gens[i] for i in pair) for pair in (one, other))
                values = list(gens)
                values[one[1]] = c * c2 - sign * s * s2
                values[one[0]] = s * c2 + sign * c * s2
                angles = {**turned.angles}
                angles[one] = angles[one] - sign * angles[other]
                yield Turned(_reduced(ring, turned.poly.compose(*values)), angles)
