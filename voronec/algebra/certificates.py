"""Signs of polynomials with a certificate, on all states that hypotheses admit.

A polynomial has a sign where its factors have one; a factor where it is known to have one, where it
is a sum of terms of one sign, a quadratic form that its discriminant makes definite, a polynomial
in one variable without roots, or where the bounds of a sine or a cosine decide.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import flint
import symengine as se

from voronec.algebra.conditions import comparisons, split_hypotheses
from voronec.algebra.factors import irreducible_factors
from voronec.algebra.field import Fraction
from voronec.algebra.graphs import nodes
from voronec.algebra.ring import Ring
from voronec.errors import EngineLimit

_MEANT = {"<": ((-1,), True), ">": ((1,), True), "<=": ((-1, 0), False), ">=": ((1, 0), False)}
_DEPTH = 8
"""How deep certificates may rest on others."""
_SHALLOW, _FEW = 2, 24
"""How deep they may rest on others, and how many terms a polynomial may have, where normal forms
ask for signs: the search grows with the power of the number of variables."""
_MOST_POLYNOMIALS = 3_000
"""How many polynomials the search for one certificate may lead to."""
_LONG = 300
"""How many terms one of these may have that others are to rest on: squares of long ones, seldom of
one sign, take minutes to be factored."""
_WIDE = 120
"""How many letters a polynomial that a reason spells out may have."""
_KINDS = {1: ("nonnegative", "positive"), -1: ("nonpositive", "negative")}
"""What a generator is by the sign it is known to have: not strictly, and strictly."""
_ONE_SIGN = {"positive": 1, "nonnegative": 1, "negative": -1, "nonpositive": -1}
_STRICT = ("positive", "negative")


@dataclass(frozen=True)
class Sign:
    """value 1, -1 or 0; not ``strict``: the polynomial may vanish as well."""

    value: int
    strict: bool
    reason: str

    @property
    def in_words(self) -> str:
        """What it says of the polynomial."""
        if self.value == 0:
            return "zero"
        if self.strict:
            return "positive" if self.value > 0 else "negative"
        return "nowhere negative" if self.value > 0 else "nowhere positive"

    def settles(self, relation: str) -> bool:
        """Whether it proves the relation to zero."""
        if relation == "!=":
            return self.value != 0 and self.strict
        values, strict = _MEANT[relation]
        return self.value in values and (self.strict or not strict)

    def times(self, other: Sign) -> Sign:
        """The sign of a product."""
        reason = "; ".join(r for r in (self.reason, other.reason) if r)
        return Sign(self.value * other.value, self.strict and other.strict, reason)


@dataclass
class Signs:
    """Signs of the polynomials of a ring; ``kinds`` has an entry for each generator.

    ``facts`` are polynomials whose sign hypotheses give, by their text.  ``known`` keeps what was
    found, and at which depth of the search.  Sines and cosines are free numbers unless
    ``bounded``.  Generators are above their lower ``bounds``.
    """

    ring: Ring
    kinds: list[str]
    known: dict[str, tuple[Sign | None, int]]
    facts: dict[str, tuple[Any, Sign]] = field(default_factory=dict)
    bounded: bool = False
    bounds: dict[int, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, ring: Ring, hypotheses: Iterable[Any] = (), bounded: bool = False) -> Signs:
        """Signs where hypotheses hold.

        An even root is not negative, and a root is positive where its radicand is; so are
        exponentials, which are above one where the exponent is positive.
        """
        hypotheses = [*hypotheses]
        kinds = ["positive" if _is_positive(m) else "real" for m in ring.meaning]
        signs = cls(ring, kinds, {}, {}, bounded)
        for expr, strict in sorted(comparisons(hypotheses), key=lambda c: len(c[0].free_symbols)):
            signs._learn(expr, strict)
        for (base, exponent), unit in ring.units.items():
            side = _sign_of_argument(exponent, hypotheses) if base == se.E else 0
            if side:
                signs._learn(side * (unit - 1), True)
        for base, root in ring.roots.items():
            inside = signs.of_fraction(ring.fraction(base))
            good = inside is not None and inside.value == 1 and inside.strict
            even = ring.found.radicals[base] % 2 == 0
            if ring.meaning[ring.index(root)] == root and (good or even):
                kinds[ring.index(root)] = "positive" if good else "nonnegative"
                signs.known.clear()
        return signs

    def _learn(self, expr: Any, strict: bool) -> None:
        """Take in that an expression of the ring is positive, or not negative: what that says of
        the one factor of it whose sign is not known."""
        try:
            fraction = self.ring.fraction(expr)
            unit, factors = irreducible_factors(fraction.num)
        except (KeyError, EngineLimit):  # the hypothesis is about something else, or too large
            return
        factors = [*factors, *self.ring.field.factors(fraction.den)]
        value, open_ones = (1 if unit > 0 else -1), []
        for factor, exponent in factors:
            sign = self.of_polynomial(factor)
            if sign is not None and sign.strict and sign.value:
                value *= sign.value**exponent
            elif exponent % 2:
                open_ones.append(factor)
            elif not strict:  # where it vanishes nothing is said of the others
                return
        if len(open_ones) == 1:
            self._note(open_ones[0], Sign(value, strict, "by hypothesis"))

    def _note(self, poly: Any, sign: Sign) -> None:
        places = self._generators_of(poly)
        if len(poly) == 1 and len(places) == 1 and poly.total_degree() == 1:
            value = sign.value if poly.leading_coefficient() > 0 else -sign.value
            weak, strict = _KINDS[value]
            if sign.strict or self.kinds[places[0]] == "real":
                self.kinds[places[0]] = strict if sign.strict else weak
        else:
            self.facts[str(poly)] = poly, sign
            if len(poly) == 2 and len(places) == 1 and poly.total_degree() == 1:
                self._note_bound(poly, places[0], sign)
        self.known.clear()

    def _note_bound(self, poly: Any, place: int, sign: Sign) -> None:
        """A generator above a positive number is positive, one below a negative one negative; of
        one that is above a number this is kept."""
        slope = poly.leading_coefficient()
        bound = (slope * self.ring.field.gens[place] - poly).leading_coefficient() / slope
        side = sign.value if slope > 0 else -sign.value
        if side * bound > 0:
            self.kinds[place] = _KINDS[side][1]
        if side > 0 and sign.strict:
            self.bounds[place] = bound

    def of_fraction(self, fraction: Fraction) -> Sign | None:
        """The sign of a fraction wherever it is defined."""
        sign = self.of_polynomial(fraction.num)
        for factor, exponent in self.ring.field.factors(fraction.den):
            below = self.of_polynomial(factor**exponent)
            if sign is None or below is None:
                return None
            sign = sign.times(Sign(below.value, True, below.reason))
        return sign

    def of_polynomial(self, poly: Any, depth: int = 0) -> Sign | None:
        """The sign of a polynomial, by its factors."""
        if depth and len(poly) > _LONG:
            return None
        key = str(poly)
        sign, tried = self.known.get(key, (None, _DEPTH + 1))
        if sign is None and depth < tried and len(self.known) < _MOST_POLYNOMIALS:
            self.known[key] = None, depth  # what is being asked for is no reason
            self.known[key] = self._of_factors(poly, depth), depth
        return self.known.get(key, (None, depth))[0]

    def _of_factors(self, poly: Any, depth: int) -> Sign | None:
        if poly == 0:
            return Sign(0, True, "the normal form is zero")
        try:
            unit, factors = irreducible_factors(poly)
        except EngineLimit:
            return None
        product = Sign(1 if unit > 0 else -1, True, "")
        for factor, exponent in factors:
            sign = self._of_irreducible(factor, depth)
            if exponent % 2 == 0:
                strict = sign is not None and sign.strict
                sign = Sign(1, strict, f"({self.spell(factor)})^{exponent} is no less than 0")
            elif sign is None:
                return None
            product = product.times(sign)
        if not product.reason:
            return replace(product, reason="a number")
        return (
            replace(product, reason=f"minus a product: {product.reason}") if unit < 0 else product
        )

    def _of_irreducible(self, poly: Any, depth: int) -> Sign | None:
        """The first certificate of a strict sign, else the first of any."""
        weak: Sign | None = None
        for sign in self._certificates(poly, depth):
            if sign is not None and sign.strict:
                return sign
            weak = weak or sign
        return weak

    def _certificates(self, poly: Any, depth: int) -> Iterator[Sign | None]:
        yield self._of_terms(poly)
        yield self._by_facts(poly, depth)
        yield self._above_bounds(poly)
        yield self._at_ends(poly, depth)
        yield self._without_roots(poly)
        if self.bounded and (depth > _SHALLOW or len(poly) > _FEW):
            return
        places = self._generators_of(poly)
        yield from (self._by_coefficients(poly, place, depth) for place in places)
        yield from (self._by_norm(poly, place, depth) for place in places)
        yield from (self._by_discriminant(poly, place, depth) for place in places)

    def _of_terms(self, poly: Any) -> Sign | None:
        """All terms have one sign: even powers of real symbols, any of those that have one."""
        value, strict = 0, False
        for exponents, coefficient in poly.to_dict().items():
            used = [(self.kinds[i], e) for i, e in enumerate(exponents) if e]
            if any(kind == "real" and e % 2 for kind, e in used):
                return None
            sign = 1 if coefficient > 0 else -1
            for kind, e in used:
                sign *= _ONE_SIGN.get(kind, 1) ** int(e)
            if value == -sign:
                return None
            value, strict = sign, strict or all(kind in _STRICT for kind, _ in used)
        common = Sign(value, strict, "")
        each = "" if len(poly) == 1 else "every term of "
        return replace(common, reason=f"{each}{self.spell(poly)} is {common.in_words}")

    def _by_facts(self, poly: Any, depth: int) -> Sign | None:
        """It is a polynomial whose sign is known, up to a factor, or more than one."""
        for fact, known in self.facts.values():
            ratio = poly.leading_coefficient() / fact.leading_coefficient()
            value = known.value if ratio > 0 else -known.value
            rest = poly - ratio * fact
            if rest == 0:
                return replace(known, value=value)
            if len(rest) < len(poly):
                beyond = self.of_polynomial(rest, depth + 1)
                if beyond is not None and beyond.value == value:
                    reason = f"{self.spell(fact)} is {known.in_words} by hypothesis"
                    return Sign(value, known.strict or beyond.strict, reason)
        return None

    def _above_bounds(self, poly: Any) -> Sign | None:
        """All terms have one sign, written in how far generators are above their lower bounds."""
        bounds = {place: low for place, low in self.bounds.items() if poly.degrees()[place]}
        if not bounds or len(poly) > _FEW:
            return None
        gens = self.ring.field.gens
        moved = poly.compose(*[g + bounds.get(i, 0) for i, g in enumerate(gens)])
        kinds = {**dict(enumerate(self.kinds)), **dict.fromkeys(bounds, "positive")}
        signs = replace(self, kinds=[kinds[i] for i in range(len(gens))])
        sign = signs._of_terms(moved)
        above = ", ".join(f"{self.ring.meaning[i]} > {low}" for i, low in bounds.items())
        return None if sign is None else replace(sign, reason=f"{sign.reason}, where {above}")

    def _at_ends(self, poly: Any, depth: int) -> Sign | None:
        """Linear in a sine or a cosine between -1 and 1, or in its square: the signs at the ends
        agree."""
        for pair in self.ring.angle_indices() if self.bounded else ():
            there = [place for place in pair if poly.degrees()[place]]
            powers = {int(e[there[0]]) for e in poly.to_dict()} if len(there) == 1 else set[int]()
            if not powers or not powers <= {0, max(powers)} or max(powers) > 2:
                continue
            ends = [-1, 1] if max(powers) == 1 else [0, 1]
            at = [self._with(poly, there[0], end) for end in ends]
            signs = [self.of_polynomial(p, depth + 1) for p in at]
            settled = [sign for sign in signs if sign is not None]
            values = {sign.value for sign in settled} - {0}
            if len(settled) == 2 and len(values) == 1:
                strict = all(sign.strict and sign.value for sign in settled)
                reason = f"{self.spell(poly)} has one sign at the ends of "
                reason += f"{self.ring.meaning[there[0]]}"
                return Sign(values.pop(), strict, reason)
        return None

    def _with(self, poly: Any, place: int, value: int) -> Any:
        """A polynomial with a number for a generator."""
        gens = self.ring.field.gens
        number = self.ring.field.context.constant(value)
        return poly.compose(*[number if i == place else g for i, g in enumerate(gens)])

    def _without_roots(self, poly: Any) -> Sign | None:
        """A polynomial in one variable that has no root in the range of the variable."""
        places = self._generators_of(poly)
        if len(places) != 1 or self._is_bound(places[0]):
            return None
        (place,) = places
        powers = {e[place]: c for e, c in poly.to_dict().items()}
        one = flint.fmpq_poly([flint.fmpq(powers.get(i, 0)) for i in range(max(powers) + 1)])
        side = _ONE_SIGN.get(self.kinds[place], 0)
        roots = [root.real for root, _ in one.complex_roots() if root.imag == 0]
        if not all(side * root < 0 for root in roots):  # balls, each of one root alone
            return None
        at = side or 1
        text = f"{self.spell(poly)} has no root there (all were isolated), and its sign at {at}"
        return Sign(1 if one(at) > 0 else -1, True, text)

    def _by_coefficients(self, poly: Any, place: int, depth: int) -> Sign | None:
        """Collected in one variable, all coefficients have one sign."""
        side = _ONE_SIGN.get(self.kinds[place], 0)
        if not side and poly.degrees()[place] % 2:
            return None
        parts = self._coefficients(poly, place)
        if not side and any(power % 2 for power in parts):
            return None
        parts = {power: part * (side or 1) ** power for power, part in parts.items()}
        signs: dict[int, Sign] = {}
        for power in sorted(parts, key=lambda power: len(parts[power])):
            sign = self.of_polynomial(parts[power], depth + 1)
            if sign is None or any(sign.value != other.value for other in signs.values()):
                return None
            signs[power] = sign
        moved = self.kinds[place] in _STRICT
        strict = any(s.strict and (moved or not power) for power, s in signs.items())
        reasons = "; ".join(dict.fromkeys(signs[power].reason for power in parts))
        text = f"its coefficients in {self.ring.meaning[place]} agree in sign ({reasons})"
        return Sign(signs[min(signs)].value, strict, text)

    def _by_norm(self, poly: Any, place: int, depth: int) -> Sign | None:
        """a + b r with a square root r: b r is the larger where b^2 r^2 - a^2 is not negative, else
        a; the larger has the sign."""
        field = self.ring.field
        rule = next((r for q, degree, r in field.rules if q == place and degree == 2), None)
        if rule is None or _ONE_SIGN.get(self.kinds[place]) != 1:
            return None
        parts = self._coefficients(poly, place)
        if parts.keys() != {0, 1}:
            return None
        try:
            excess_of = field.reduce(
                parts[1] ** 2 * (field.gens[place] ** 2 - rule) - parts[0] ** 2
            )
        except EngineLimit:
            return None
        excess = self.of_polynomial(excess_of, depth + 1)
        if excess is None:
            return None
        larger = self.of_polynomial(parts[1] if excess.value >= 0 else parts[0], depth + 1)
        if larger is None or not larger.value:
            return None
        text = f"{self.spell(poly)} has the sign of the larger of its parts ({larger.reason})"
        return Sign(larger.value, excess.strict and excess.value != 0 and larger.strict, text)

    def _by_discriminant(self, poly: Any, place: int, depth: int) -> Sign | None:
        """a y^2 + b y + c for y = x^k: definite where 4ac > b^2, semidefinite where a > 0, too."""
        half, odd = divmod(poly.degrees()[place], 2)
        if odd or self._is_bound(place):
            return None
        parts = self._coefficients(poly, place)
        if not parts.keys() <= {0, half, 2 * half}:
            return None
        zero = self.ring.field.zero
        a, b, c = parts[2 * half], parts.get(half, zero), parts.get(0, zero)
        first = self.of_polynomial(a, depth + 1)
        if first is None:
            return None
        below = self.of_polynomial(4 * a * c - b * b, depth + 1)
        if below is None or below.value < 0:
            return None
        definite = below.value > 0 and below.strict
        if not (definite or first.strict or self._agrees(c, first, depth)):
            return None
        name = str(self.ring.meaning[place]) + (f"^{half}" if half > 1 else "")
        text = f"{self.spell(poly)} as a quadratic in {name}: its leading coefficient is "
        text += f"{first.in_words} ({first.reason}), 4ac - b^2 is {below.in_words} "
        return Sign(first.value, definite, text + f"({below.reason})")

    def _agrees(self, poly: Any, other: Sign, depth: int) -> bool:
        """Whether a polynomial has the sign of another one, or none."""
        sign = self.of_polynomial(poly, depth + 1)
        return sign is not None and sign.value in (0, other.value)

    # -- polynomials ----------------------------------------------------------------------

    def _generators_of(self, poly: Any) -> list[int]:
        return [i for i, degree in enumerate(poly.degrees()) if degree]

    def _is_bound(self, place: int) -> bool:
        """Whether a generator is no free variable, but a root or a sine."""
        return any(place == rule for rule, _, _ in self.ring.field.rules)

    def _coefficients(self, poly: Any, place: int) -> dict[int, Any]:
        """Coefficients by powers of one generator."""
        parts: dict[int, dict[tuple[int, ...], Any]] = {}
        for exponents, coefficient in poly.to_dict().items():
            rest = (*exponents[:place], 0, *exponents[place + 1 :])
            parts.setdefault(int(exponents[place]), {})[rest] = coefficient
        context = self.ring.field.context
        return {power: context.from_dict(terms) for power, terms in parts.items()}

    def spell(self, poly: Any) -> str:
        """A polynomial in the user's names; a long one is cut short."""
        if 4 * len(poly) <= _WIDE:  # no term takes fewer letters, with its sign
            text = str(self.ring.polynomial(poly)).replace("**", "^")
            if len(text) <= _WIDE:
                return text
        return f"a polynomial of {len(poly)} terms"

    def linear_zeros(self, poly: Any) -> list[tuple[Any, Any]]:
        """(symbol, value): where factors that are linear in a symbol vanish.  A function does not
        take any value: it is no unknown."""
        zeros = []
        for factor, _ in irreducible_factors(poly)[1] if poly != 0 else ():
            for place in self._generators_of(factor):
                parts = self._coefficients(factor, place)
                is_free = self.ring.meaning[place].is_Symbol and not self._is_bound(place)
                if max(parts) == 1 and is_free:
                    above, below = parts.get(0, self.ring.field.zero), parts[1]
                    value = -self.ring.polynomial(above) / self.ring.polynomial(below)
                    zeros.append((self.ring.meaning[place], value))
        return zeros


def _sign_of_argument(argument: Any, hypotheses: Sequence[Any]) -> int:
    """The strict sign of what an exponential is taken of, or 0."""
    symbols = argument.free_symbols
    known = [
        c
        for c in split_hypotheses(hypotheses)[1]
        if c.free_symbols <= symbols and _is_plain(c.args)
    ]
    if not known or not _is_plain([argument]):
        return 0
    try:
        ring = Ring([argument, *(e for e, _ in comparisons(known))])
        sign = Signs.of(ring, known).of_fraction(ring.fraction(argument))
    except EngineLimit:
        return 0
    return sign.value if sign is not None and sign.strict else 0


def _is_plain(exprs: Iterable[Any]) -> bool:
    """Whether expressions are sums and products of symbols and numbers: no further exponentials."""
    plain = (se.Symbol, se.Number, se.Add, se.Mul)
    return all(
        isinstance(n, plain) or (isinstance(n, se.Pow) and isinstance(n.args[1], se.Integer))
        for n in nodes(exprs)
    )


def _is_positive(meaning: Any) -> bool:
    """Whether a generator stands for a positive number, or an exponential."""
    return meaning in (se.pi, se.E) or (isinstance(meaning, se.Pow) and meaning.args[0] == se.E)
