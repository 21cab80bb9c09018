"""From an exact element back to an expression, in the shortest of several proved forms.

Where the sum of w_a d/da annihilates f, w_a = 1 or -1, f does not change when every angle a is
moved by w_a times the same amount; with the amount that brings one of them, b, to zero,

    f(b, a, ...) = f(0, a - w_a w_b b, ...).

That is an identity, so nothing is lost, and products of sines and cosines of b and a become those
of differences: cos(x) cos(y) + sin(x) sin(y) is cos(x - y).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any

import flint
import symengine as se

from voronec.algebra.factors import irreducible_factors
from voronec.algebra.field import Fraction
from voronec.algebra.ring import Monomial, Ring, sparse_terms
from voronec.algebra.terms import is_exponential, rational, summands

MANY = 30_000
"""Polynomials with more terms than this stay in the angles they are in."""
FEW = 40
"""Up to so many terms every angle is tried for the one that stands still."""


@dataclass(frozen=True)
class TurnedPolynomial:
    """A polynomial of a ring in which generators mean other angles than in the ring: ``angles``
    maps positions (sine, cosine) to the angle whose sine and cosine they are."""

    poly: Any
    angles: Mapping[tuple[int, int], Any]

    def meaning(self, ring: Ring) -> dict[Any, Any]:
        """What the ring's sines and cosines are to be replaced by."""
        replacements = {}
        for (sine, cosine), angle in self.angles.items():
            sign, shown = _leading_sign(angle)
            replacements[ring.meaning[cosine]] = se.cos(shown)
            replacements[ring.meaning[sine]] = sign * se.sin(shown)
        return replacements


def _in_differences(ring: Ring, poly: Any) -> Iterator[TurnedPolynomial]:
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
        yield _relink(ring, TurnedPolynomial(rest, left))


def _leading_sign(angle: Any) -> tuple[int, Any]:
    """The angle or its opposite, so that the symbol that comes first by name is positive."""
    symbols = sorted(angle.free_symbols, key=str)
    first = angle.diff(symbols[0]) if symbols else se.Integer(1)
    return (-1, -angle) if first.is_Number and first < 0 else (1, angle)


def _angles(ring: Ring, poly: Any) -> dict[tuple[int, int], Any]:
    """The angles in a polynomial by the positions of sine and cosine; none where one of them may
    be moved without its sine and cosine telling."""
    degrees = poly.degrees()
    angles = {
        pair: angle
        for pair, angle in zip(ring.angle_indices(), ring.angles(), strict=True)
        if degrees[pair[0]] or degrees[pair[1]]
    }
    moved = set().union(*(angle.free_symbols for angle in angles.values()))
    places = {i for pair in angles for i in pair}
    others = [ring.meaning[i] for i, degree in enumerate(degrees) if degree and i not in places]
    return {} if any(expr.free_symbols & moved for expr in others) else angles


def _symmetry(ring: Ring, poly: Any, pairs: list[tuple[int, int]]) -> dict[tuple[int, int], int]:
    """Charges 1 and -1 of some angles, moved together by which the polynomial stays the same.

    The derivatives by the angles are added one by one to a basis; the first that depends on those
    before it gives the charges.
    """
    basis: list[tuple[tuple[int, ...], Any, dict[int, Any]]] = []
    for position, (sine, cosine) in enumerate(pairs):
        gens = ring.field.gens
        rate = gens[cosine] * poly.derivative(sine) - gens[sine] * poly.derivative(cosine)
        rest, combination = _reduce(ring, rate), {position: flint.fmpq(1)}
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


def _reduce(ring: Ring, poly: Any) -> Any:
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


def _relink(ring: Ring, turned: TurnedPolynomial) -> TurnedPolynomial:
    """Angles a written as (a - b) + b or (a + b) - b, as long as that leaves fewer terms."""
    while True:
        shorter = min(_neighbours(ring, turned), key=lambda t: len(t.poly), default=turned)
        if len(shorter.poly) >= len(turned.poly):
            return turned
        turned = shorter


def _neighbours(ring: Ring, turned: TurnedPolynomial) -> Iterator[TurnedPolynomial]:
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
                yield TurnedPolynomial(_reduce(ring, turned.poly.compose(*values)), angles)


FACTOR_LIMIT = 150
"""Polynomials with more terms than this are not tried for a factorization."""
TRIAL_LIMIT = 40
"""Up to this many terms every form is tried; above, the number of terms decides."""

ONE = flint.fmpq(1)

Terms = dict[Monomial, Any]
"""A polynomial as {monomial: coefficient}."""


def operations(exprs: Iterable[Any]) -> int:
    """How many operations expressions cost after common subexpressions are shared."""
    replacements, reduced = se.cse([se.sympify(e) for e in exprs])
    return int(se.count_ops(*[r for _, r in replacements], *reduced))


def expand_element(ring: Ring, f: Fraction) -> Any:
    """An element as an expanded numerator over a factored denominator: quick, not short."""
    num, den, below = _lower_roots(ring, f)
    parts = [_sum(ring, sparse_terms(num))] + [se.Pow(g, -1) for g in below]
    parts += [_inverse(_sum(ring, sparse_terms(poly)), e) for poly, e in den]
    return se.Mul(*parts)


def _inverse(below: Any, power: int) -> Any:
    """1/below^power; symengine leaves sums in the exponents of exponentials as they are."""
    if not is_exponential(below):
        return se.Pow(below, -power)
    return se.exp(se.Add(*[-power * w for w in summands(below.args[1])]))


def expression(ring: Ring, f: Fraction, group: Sequence[Any] = ()) -> Any:
    """The shortest expression found for an element.

    ``group`` are generators (velocities, say) by which it may be collected.
    """
    if f.num == 0:
        return se.Integer(0)
    indices = [ring.index(g) for g in group if ring.has(g)]
    pieces = _split(f.num, indices) if indices else {}
    if len(pieces) < 2:
        return _quotient(ring, f)
    collected = []
    for key, piece in pieces.items():
        monomial = [ring.meaning[i] ** int(e) for i, e in zip(indices, key, strict=True) if e]
        part = ring.field.absorb(ring.field.cancel(Fraction(piece, f.den)))
        collected.append(se.Mul(_quotient(ring, part), *monomial))
    apart = se.Add(*collected)  # reads better, so it may cost a little more
    if len(f.num) > TRIAL_LIMIT:
        return apart
    whole = _quotient(ring, f)
    return apart if _cost(apart) <= 3 * _cost(whole) + 10 else whole


def _quotient(ring: Ring, f: Fraction) -> Any:
    num, den, below = _lower_roots(ring, f)
    parts = [_best(ring, num)] + [se.Pow(g, -1) for g in below]
    parts += [_inverse(_best(ring, poly), e) for poly, e in _few_factors(den)]
    return se.Mul(*parts)


def _few_factors(den: Sequence[tuple[Any, int]]) -> Iterator[tuple[Any, int]]:
    """Factors with their exponents; those with the same exponent as one, where it is much shorter:
    x^100 + 1 has six factors."""
    for exponent in dict.fromkeys(e for _, e in den):
        factors = [poly for poly, e in den if e == exponent]
        if 2 < sum(map(len, factors)) <= FACTOR_LIMIT:
            product = prod(factors[1:], start=factors[0])
            if 3 * len(product) < sum(map(len, factors)):
                factors = [product]
        yield from ((poly, exponent) for poly in factors)


def _lower_roots(ring: Ring, f: Fraction) -> tuple[Any, list[tuple[Any, int]], list[Any]]:
    """Write s/(1 - c**2) as 1/s, 1/(1 - c**2) as 1/s**2, and likewise for square roots."""
    num, den = f.num, dict(f.den)
    below: list[Any] = []
    for generator, rest, factors in ring.field.square_roots() if den else ():
        g = ring.field.context.gens()[generator]
        while all(den.get(i, 0) >= e for i, e in factors):
            for i, e in factors:
                den[i] -= e
            ratio = (ring.field.denominator(factors) / rest).leading_coefficient()
            num = num * (1 / ratio)
            pieces = _split(num, [generator])
            even, odd = pieces.get((0,), ring.field.zero), pieces.get((1,), ring.field.zero)
            quotient, remainder = divmod(even, rest)  # num = even + odd*g, g**2 = rest
            if remainder == 0:
                num = odd + quotient * g
                below.append(ring.meaning[generator])
            else:
                below += [ring.meaning[generator]] * 2
    return num, [(poly, e) for poly, e in ring.field.factors(den.items()) if e], below


def _split(poly: Any, indices: Sequence[int]) -> dict[tuple[int, ...], Any]:
    """A polynomial sorted by its powers of some generators."""
    sorted_terms: dict[tuple[int, ...], dict[tuple[int, ...], Any]] = {}
    for monomial, coefficient in poly.to_dict().items():
        rest = list(monomial)
        for i in indices:
            rest[i] = 0
        key = tuple(int(monomial[i]) for i in indices)
        sorted_terms.setdefault(key, {})[tuple(rest)] = coefficient
    context = poly.context()
    return {key: context.from_dict(terms) for key, terms in sorted_terms.items()}


def _cost(expr: Any) -> int:
    return int(se.count_ops(expr))


# -- polynomials as expressions -------------------------------------------------------------


def _sum(ring: Ring, terms: Terms) -> Any:
    return se.Add(*[ring.term(m, c) for m, c in terms.items()])


def _best(ring: Ring, poly: Any) -> Any:
    """The cheapest form in the angles as they are, or in their differences where these suffice."""
    turned = list(_in_differences(ring, poly))
    forms = [_in_angles(ring, t.poly).xreplace(t.meaning(ring)) for t in turned]
    if not any(2 * len(t.poly) < len(poly) for t in turned):
        forms.insert(0, _in_angles(ring, poly))
    return min(forms, key=_cost)


def _in_angles(ring: Ring, poly: Any) -> Any:
    """The cheapest of: expanded, factored, nested; each with c**2 or s**2 eliminated."""
    best = None
    for sine, cosine in ring.angle_indices():
        if poly.degrees()[cosine] < 2:
            continue
        other = _prefer_sine(ring, poly, sine, cosine)
        if len(other) < len(poly):
            poly, best = other, None
        elif len(other) == len(poly) <= TRIAL_LIMIT:
            best = _cheapest(ring, poly) if best is None else best
            form = _cheapest(ring, other)
            if _cost(form) < _cost(best):
                poly, best = other, form
    return _cheapest(ring, poly) if best is None else best


def _cheapest(ring: Ring, poly: Any) -> Any:
    if len(poly) < 2:
        return _sum(ring, sparse_terms(poly))
    if len(poly) > FACTOR_LIMIT:
        return _horner(ring, sparse_terms(poly))
    content, parts = irreducible_factors(poly)
    number = rational(content)
    forms = [_sum(ring, sparse_terms(poly))]
    if len(parts) > 1 or parts[0][1] > 1 or content != 1:
        forms.append(se.Mul(number, *[_sum(ring, sparse_terms(p)) ** e for p, e in parts]))
    nested = [_horner(ring, sparse_terms(p)) ** e for p, e in parts]
    return min([*forms, se.Mul(number, *nested)], key=_cost)


def _horner(ring: Ring, terms: Terms) -> Any:
    """Horner's scheme in the generator that most terms share, again and again."""
    common = _common_monomial(terms)
    if common and len(terms) > 1:
        return ring.term(common, ONE) * _horner(ring, _divide(terms, dict(common)))
    counts: dict[int, int] = {}
    for monomial in terms:
        for i, _ in monomial:
            counts[i] = counts.get(i, 0) + 1
    most = max(counts, key=counts.__getitem__, default=-1)
    if counts.get(most, 0) < 2 or len(terms) <= 2:
        return _sum(ring, terms)
    inside = {m: c for m, c in terms.items() if any(i == most for i, _ in m)}
    outside = {m: c for m, c in terms.items() if m not in inside}
    return _horner(ring, inside) + _horner(ring, outside)


def _common_monomial(terms: Terms) -> Monomial:
    """The greatest monomial that divides every term."""
    monomials = iter(terms)
    shared = dict(next(monomials))
    for monomial in monomials:
        powers = dict(monomial)
        shared = {i: min(e, powers[i]) for i, e in shared.items() if i in powers}
        if not shared:
            break
    return tuple(shared.items())


def _divide(terms: Terms, powers: dict[int, int]) -> Terms:
    return {
        tuple((i, e - powers.get(i, 0)) for i, e in monomial if e > powers.get(i, 0)): coefficient
        for monomial, coefficient in terms.items()
    }


def _prefer_sine(ring: Ring, poly: Any, sine: int, cosine: int) -> Any:
    """Replace c**2 by 1 - s**2."""
    square = 1 - ring.field.context.gens()[sine] ** 2
    total = ring.field.zero
    for (power,), piece in _split(poly, [cosine]).items():
        bare = ring.field.context.gens()[cosine] ** (power % 2)
        total += piece * square ** (power // 2) * bare
    return total
