"""Inequalities with three answers: proved by a certificate, refuted at a rational point, undecided.

A polynomial has a sign where its factors have one; a factor where it is a sum of terms of one sign,
a quadratic form that its discriminant makes definite, or a polynomial in one variable without
roots.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import flint
import sympy as sp

from voronec.algebra.counterexamples import Question
from voronec.algebra.domains import RELATIONS, mirrored, real_symbols, refuse_signs
from voronec.algebra.door import Door
from voronec.algebra.field import Fraction
from voronec.algebra.ring import Ring
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import sympified
from voronec.algebra.verdicts import PROOF_LIMIT, Verdict
from voronec.arguments import SEVERAL, TEXT, accepts
from voronec.errors import DefinitionError, EngineLimit, shown

__all__ = ["RELATIONS", "known_sign", "prove_inequality"]

_MEANT = {"<": ((-1,), True), ">": ((1,), True), "<=": ((-1, 0), False), ">=": ((1, 0), False)}
_DEPTH = 8


@accepts(relation=TEXT, positive=SEVERAL, real=SEVERAL)
def prove_inequality(
    a: Any, relation: str, b: Any = 0, positive: Sequence[Any] = (), real: Sequence[Any] = ()
) -> Verdict:
    r"""Decide whether ``a relation b`` holds wherever both sides are defined.

    ``relation`` is one of < <= > >= != or its LaTeX.  The symbols ``positive``, and those that
    SymPy knows to be positive, run over all positive numbers, those that it knows to be negative
    over all negative ones, every other one over all real numbers, whatever else SymPy knows;
    ``real`` names some of these, so that one in both lists is an error, as is a symbol that is not
    real.  Proved: the method says by which certificate.  Refuted: the witness is a point, rational
    in every symbol.
    """
    positive, real = (_symbols(given) for given in (positive, real))
    if relation not in RELATIONS:
        raise DefinitionError(
            f"'{shown(relation)}' is no inequality; use one of "
            f"{', '.join(dict.fromkeys(RELATIONS))}"
        )
    both = [s for s in real if s in positive]
    if both:
        raise DefinitionError(f"'{both[0]}' is declared positive and real; declare it once")
    a, b = sympified(a), sympified(b)
    symbols = real_symbols(a, b)
    below = {s: sp.Symbol(f"|{s.name}|") for s in symbols if s.is_negative}
    if below:
        refuse_signs(below, (*positive, *real))
        mirror = {s: -size for s, size in below.items()}
        sizes = (*positive, *below.values())
        return mirrored(
            prove_inequality(a.xreplace(mirror), relation, b.xreplace(mirror), sizes, real)
        )
    door = Door()
    left, right = door.inward(a), door.inward(b)
    above = {str(door.inward(s)) for s in positive}
    above |= {plain_name(s) for s in symbols if s.is_positive}
    question = Question(left, RELATIONS[relation], right, frozenset(above))
    try:
        ring = Ring([left, right], (), PROOF_LIMIT)
        difference = ring.fraction(left - right)
        signs = _Signs.of(ring, question.positive)
    except EngineLimit as limit:
        return question.searched((), str(limit))
    found = signs.of_fraction(difference)
    if found is not None and found.settles(question.relation):
        return Verdict("proved", f"the difference of the sides is {found.in_words}: {found.reason}")
    roots = signs.vanishing(difference.num)
    return question.searched(roots, "no certificate of a sign was found")


def _symbols(given: Any) -> tuple[Any, ...]:
    """One or several symbols, given by name or themselves."""
    single = isinstance(given, str) or not isinstance(given, Iterable)
    return tuple(sympified(s, "a symbol") for s in ((given,) if single else given))


# -- certificates -------------------------------------------------------------------------


@dataclass(frozen=True)
class _Sign:
    """value 1, -1 or 0; not ``strict``: the polynomial may vanish as well."""

    value: int
    strict: bool
    reason: str

    @property
    def in_words(self) -> str:
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

    def times(self, other: _Sign) -> _Sign:
        reason = "; ".join(r for r in (self.reason, other.reason) if r)
        return _Sign(self.value * other.value, self.strict and other.strict, reason)


@dataclass(frozen=True)
class _Signs:
    """Signs of the polynomials of a ring; ``kinds`` has an entry for each generator.

    ``known`` keeps what was found, and at which depth of the search.
    """

    ring: Ring
    kinds: list[str]
    known: dict[str, tuple[_Sign | None, int]]

    @classmethod
    def of(cls, ring: Ring, positive: Iterable[str]) -> _Signs:
        """An even root is not negative, and a root is positive where its radicand is."""
        kinds = ["positive" if str(m) in set(positive) else "real" for m in ring.meaning]
        signs = cls(ring, kinds, {})
        for base, root in ring.roots.items():
            inside = signs.of_fraction(ring.fraction(base))
            good = inside is not None and inside.value == 1 and inside.strict
            even = ring.found.radicals[base] % 2 == 0
            if ring.meaning[ring.index(root)] == root and (good or even):
                kinds[ring.index(root)] = "positive" if good else "nonnegative"
                signs.known.clear()
        return signs

    def of_fraction(self, fraction: Fraction) -> _Sign | None:
        """The sign of a fraction wherever it is defined."""
        found = self.of_polynomial(fraction.num)
        for factor, exponent in self.ring.field.factors(fraction.den):
            below = self.of_polynomial(factor**exponent)
            if found is None or below is None:
                return None
            found = found.times(_Sign(below.value, True, below.reason))
        return found

    def of_polynomial(self, poly: Any, depth: int = 0) -> _Sign | None:
        """The sign of a polynomial, by its factors."""
        key = str(poly)
        sign, tried = self.known.get(key, (None, _DEPTH + 1))
        if sign is None and depth < tried:
            self.known[key] = None, depth  # what is being asked for is no reason
            self.known[key] = self._of_factors(poly, depth), depth
        return self.known.get(key, (None, depth))[0]  # beyond the depth nothing is kept

    def _of_factors(self, poly: Any, depth: int) -> _Sign | None:
        if poly == 0:
            return _Sign(0, True, "the normal form is zero")
        unit, factors = poly.factor()
        found = _Sign(1 if unit > 0 else -1, True, "")
        for factor, exponent in factors:
            sign = self._of_irreducible(factor, depth)
            if exponent % 2 == 0:
                strict = sign is not None and sign.strict
                sign = _Sign(1, strict, f"({self.spelled(factor)})^{exponent} is no less than 0")
            elif sign is None:
                return None
            found = found.times(sign)
        if not found.reason:
            return replace(found, reason="a number")
        return replace(found, reason=f"minus a product: {found.reason}") if unit < 0 else found

    def _of_irreducible(self, poly: Any, depth: int) -> _Sign | None:
        """The first certificate of a strict sign, else the first of any."""
        weak: _Sign | None = None
        for sign in self._certificates(poly, depth):
            if sign is not None and sign.strict:
                return sign
            weak = weak or sign
        return weak

    def _certificates(self, poly: Any, depth: int) -> Iterator[_Sign | None]:
        yield self._of_terms(poly)
        yield self._without_roots(poly)
        places = self._used(poly)
        yield from (self._by_coefficients(poly, place, depth) for place in places)
        yield from (self._by_discriminant(poly, place, depth) for place in places)

    def _of_terms(self, poly: Any) -> _Sign | None:
        """All terms have one sign: even powers of real symbols, any of positive ones."""
        value, strict = 0, False
        for exponents, coefficient in poly.to_dict().items():
            used = [(self.kinds[i], e) for i, e in enumerate(exponents) if e]
            if any(kind == "real" and e % 2 for kind, e in used):
                return None
            sign = 1 if coefficient > 0 else -1
            if value == -sign:
                return None
            value, strict = sign, strict or all(kind == "positive" for kind, _ in used)
        found = _Sign(value, strict, "")
        each = "" if len(poly) == 1 else "every term of "
        return replace(found, reason=f"{each}{self.spelled(poly)} is {found.in_words}")

    def _without_roots(self, poly: Any) -> _Sign | None:
        """A polynomial in one variable that has no root in the range of the variable."""
        places = self._used(poly)
        if len(places) != 1 or self._is_bound(places[0]):
            return None
        (place,) = places
        powers = {e[place]: c for e, c in poly.to_dict().items()}
        terms = [powers.get(i, 0) for i in range(max(powers), -1, -1)]
        exact = [sp.Rational(int(flint.fmpq(c).p), int(flint.fmpq(c).q)) for c in terms]
        lower = 0 if self.kinds[place] == "positive" else None
        one = sp.Poly(exact, sp.Symbol("x"))
        if one.count_roots(lower, None):
            return None
        text = f"{self.spelled(poly)} has no root there (Sturm), and its sign at 1"
        return _Sign(1 if one.eval(1) > 0 else -1, True, text)

    def _by_coefficients(self, poly: Any, place: int, depth: int) -> _Sign | None:
        """Collected in one variable, all coefficients have one sign."""
        parts = self._collected(poly, place)
        if self.kinds[place] == "real" and any(power % 2 for power in parts):
            return None
        signs = {power: self.of_polynomial(c, depth + 1) for power, c in parts.items()}
        found = [(power, s) for power, s in signs.items() if s is not None]
        if len(found) < len(parts) or len({s.value for _, s in found}) > 1:
            return None
        positive = self.kinds[place] == "positive"
        strict = any(s.strict and (positive or not power) for power, s in found)
        reasons = "; ".join(dict.fromkeys(s.reason for _, s in found))
        text = f"its coefficients in {self.ring.meaning[place]} agree in sign ({reasons})"
        return _Sign(found[0][1].value, strict, text)

    def _by_discriminant(self, poly: Any, place: int, depth: int) -> _Sign | None:
        """a y^2 + b y + c for y = x^k: definite where 4ac > b^2, semidefinite where a > 0, too."""
        parts = self._collected(poly, place)
        half, odd = divmod(max(parts), 2)
        if odd or self._is_bound(place) or not parts.keys() <= {0, half, 2 * half}:
            return None
        zero = self.ring.field.zero
        a, b, c = parts[2 * half], parts.get(half, zero), parts.get(0, zero)
        below = self.of_polynomial(4 * a * c - b * b, depth + 1)
        first = self.of_polynomial(a, depth + 1)
        if below is None or first is None or below.value < 0:
            return None
        definite = below.value > 0 and below.strict
        if not (definite or first.strict or self._agrees(c, first, depth)):
            return None
        name = str(self.ring.meaning[place]) + (f"^{half}" if half > 1 else "")
        text = f"{self.spelled(poly)} as a quadratic in {name}: its leading coefficient is "
        text += f"{first.in_words} ({first.reason}), 4ac - b^2 is {below.in_words} "
        return _Sign(first.value, definite, text + f"({below.reason})")

    def _agrees(self, poly: Any, other: _Sign, depth: int) -> bool:
        """Whether a polynomial has the sign of another one, or none."""
        sign = self.of_polynomial(poly, depth + 1)
        return sign is not None and sign.value in (0, other.value)

    # -- polynomials ----------------------------------------------------------------------

    def _used(self, poly: Any) -> list[int]:
        return [i for i, degree in enumerate(poly.degrees()) if degree]

    def _is_bound(self, place: int) -> bool:
        """Whether a generator is no free variable, but a root or a sine."""
        return any(place == rule for rule, _, _ in self.ring.field.rules)

    def _collected(self, poly: Any, place: int) -> dict[int, Any]:
        """Coefficients by powers of one generator."""
        parts: dict[int, dict[tuple[int, ...], Any]] = {}
        for exponents, coefficient in poly.to_dict().items():
            rest = tuple(0 if i == place else int(e) for i, e in enumerate(exponents))
            parts.setdefault(int(exponents[place]), {})[rest] = coefficient
        context = self.ring.field.context
        return {power: context.from_dict(terms) for power, terms in parts.items()}

    def spelled(self, poly: Any) -> str:
        """A polynomial in the user's names; a long one is cut short."""
        text = str(self.ring.polynomial(poly)).replace("**", "^")
        return text if len(text) <= 120 else f"a polynomial of {len(poly)} terms"

    def vanishing(self, poly: Any) -> list[tuple[Any, Any]]:
        """(variable, value): where factors that are linear in a variable vanish."""
        found = []
        for factor, _ in poly.factor()[1] if poly != 0 else ():
            for place in self._used(factor):
                parts = self._collected(factor, place)
                if max(parts) == 1 and not self._is_bound(place):
                    above, below = parts.get(0, self.ring.field.zero), parts[1]
                    value = -self.ring.polynomial(above) / self.ring.polynomial(below)
                    found.append((self.ring.meaning[place], value))
        return found


def known_sign(
    expr: Any, relations: Sequence[Any] = (), positive: Iterable[str] = (), strict: bool = False
) -> int:
    """1 or -1 where an expression inside the door is proved to have nowhere the other sign, or 0.

    ``relations`` vanish, and symbols of the names ``positive`` are so; ``strict``: nor is it zero.
    """
    try:
        ring = Ring([expr], relations)
        found = _Signs.of(ring, positive).of_fraction(ring.fraction(expr))
    except EngineLimit:
        return 0
    return found.value if found is not None and (found.strict or not strict) else 0
