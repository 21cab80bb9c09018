"""Expressions as sums of terms in letters, arranged and written in as few characters as may be.

A letter is a symbol, a function of something, or a sum that is left together: what is divided by,
or stands under a root.  A term is a number times powers of letters, whose exponents may be negative
or fractions.  So m a^2/(R + r) + sqrt(x) has the letters m, a, x and R + r.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from math import gcd, lcm
from typing import Any, NamedTuple

import symengine as se

from voronec.algebra.typeset import symbol_latex
from voronec.errors import EngineLimit

Rational = Any  # an int, else a Fraction
Monomial = tuple[tuple[int, Rational], ...]
"""((letter, exponent), ...), sorted by letter."""
Terms = dict[Monomial, Rational]
"""A sum, {monomial: coefficient}."""

DEPTH = 2
"""How deep sums are nested in a term; functions may add one more pair of brackets."""
TRIES = 14
"""Up to so many terms two ways are tried of putting a letter before a bracket."""


class Factor(NamedTuple):
    """A letter, or a sum of products in brackets, to a power."""

    base: Any
    exponent: Rational


class LetterProduct(NamedTuple):
    """A number times factors."""

    number: Rational
    factors: tuple[Factor, ...]


Sum = tuple[LetterProduct, ...]


class TermLetter(NamedTuple):
    """What a letter stands for, and its place among the factors of a product."""

    meaning: Any
    rank: tuple[int, int]
    terms: Terms | None = None

    @property
    def moves(self) -> bool:
        """Whether it changes with time."""
        return self.rank[0] >= COORDINATE


PARAMETER, COORDINATE, VELOCITY, ACCELERATION = 0, 3, 6, 7
"""Ranks of letters: parameters stand before what moves, velocities and accelerations last."""


def times(a: Monomial, b: Monomial, power: Rational = 1) -> Monomial:
    """a b^power."""
    exponents = dict(a)
    for i, e in b:
        exponents[i] = exponents.get(i, 0) + e * power
    return tuple(sorted((i, _plain(e)) for i, e in exponents.items() if e))


def _plain(e: Rational) -> Rational:
    return e if type(e) is int or e.denominator != 1 else int(e)


def over(a: Rational, b: Rational) -> Rational:
    """The quotient of two rational numbers; whole ones stay whole, for they are quick."""
    return _plain(Fraction(a, b)) if type(a) is not int or type(b) is not int or a % b else a // b


def add(*sums: Terms) -> Terms:
    """The sum of sums."""
    total: Terms = {}
    for terms in sums:
        for m, c in terms.items():
            total[m] = total.get(m, 0) + c
    return {m: c for m, c in total.items() if c}


def mul(a: Terms, b: Terms) -> Terms:
    """The product of two sums, written out."""
    product: Terms = {}
    for m, c in a.items():
        for n, d in b.items():
            key = times(m, n)
            product[key] = product.get(key, 0) + c * d
    return {m: c for m, c in product.items() if c}


def divide(terms: Terms, by: Terms) -> tuple[Terms, Terms]:
    """Q and R with terms = Q by + R, where R has as few terms as may be: Q are the terms with which
    every term of ``by`` is found in the sum.  No term of Q divides by what the sum does not."""
    rest, quotient = dict(terms), Terms()
    (head, number), *others = by.items()
    for m in [*terms]:
        if m not in rest:
            continue
        key, c = times(m, head, -1), over(rest[m], number)
        below = dict(m)
        if any(e < min(0, below.get(i, 0)) for i, e in key):
            continue
        tail = [(times(key, n), c * d) for n, d in others]
        if all(rest.get(n) == d for n, d in tail):
            del rest[m]
            for n, _ in tail:
                del rest[n]
            quotient[key] = c
    return quotient, rest


class Alphabet:
    """The letters of some expressions, how they are written, and how sums of them are arranged.

    ``rank`` says what kind of thing an atom is, ``text`` and ``latex`` write atoms.  ``work``
    counts the terms that were arranged; beyond twice the ``limit`` they are only written out.
    """

    def __init__(
        self, rank: Callable[[Any], tuple[int, int]], text: Callable[[Any], str],
        latex: Callable[[Any], str], most: int,
    ) -> None:  # fmt: skip
        self._rank, self._text, self._latex, self.most = rank, text, latex, most
        self.letters: list[TermLetter] = []
        self._index: dict[Any, int] = {}
        self.names: dict[int, str] = {}
        self.angles: dict[Any, Any] = {}
        self.named: set[int] = set()
        self.work, self.limit = 0, most
        self.whole = False
        self._read: dict[Any, Terms] = {}
        self._arranged: dict[Any, Sum] = {}
        self._written: dict[Any, str] = {}
        self._ranks: dict[Any, tuple[int, int]] = {}

    # -- letters --------------------------------------------------------------------------

    def index(self, meaning: Any, terms: Terms | None = None) -> int:
        """The number of the letter that stands for an atom, or for a sum."""
        key = meaning if terms is None else frozenset(terms.items())
        if key not in self._index:
            rank = self._rank(meaning) if terms is None else self.rank_of(terms)
            self._index[key] = len(self.letters)
            self.letters.append(TermLetter(meaning, rank, terms))
        return self._index[key]

    def rank_of(self, terms: Terms) -> tuple[int, int]:
        """The place of a sum among factors."""
        highest = max((self.letters[i].rank for m in terms for i, _ in m), default=(PARAMETER, 0))
        return (COORDINATE + 2 if highest[0] >= COORDINATE else COORDINATE - 1, len(self.letters))

    def name(self, name: str, terms: Terms) -> int:
        """The letter of that name for a sum."""
        key = name, frozenset(terms.items())
        if key not in self._index:
            self._index[key] = len(self.letters)
            self.letters.append(TermLetter(None, self.rank_of(terms), terms))
            self.names[self._index[key]] = name
            self.named.add(self._index[key])
        return self._index[key]

    def meaning(self, letter: int) -> Any:
        """The expression that a letter stands for, names replaced."""
        entry = self.letters[letter]
        return entry.meaning if entry.terms is None else self._write_out(entry.terms)

    def expression(self, terms: Terms) -> Any:
        """A sum as an expression."""
        return self._write_out(terms).xreplace(self.angles)

    def _write_out(self, terms: Terms) -> Any:
        return se.Add(*[
            se.Rational(c.numerator, c.denominator)
            * se.Mul(*[se.Pow(self.meaning(i), _number(e)) for i, e in m])
            for m, c in terms.items()
        ])  # fmt: skip

    # -- reading ------------------------------------------------------------------------------

    def read(self, expr: Any) -> Terms:
        """An expression as a sum of terms; where it is ``whole``, sums in products stay letters.

        Raises ``EngineLimit`` where there would be more than ``most`` terms.
        """
        terms = self._read.get((expr, self.whole))
        if terms is None:
            terms = self._read[expr, self.whole] = self._terms(expr)
            if len(terms) > self.most:
                raise EngineLimit(f"more than {self.most} terms")
        return terms

    def _terms(self, expr: Any) -> Terms:
        if isinstance(expr, se.Rational | se.Integer):
            value = _rational(expr)
            return {(): value} if value else {}
        if isinstance(expr, se.Add):
            return add(*map(self.read, expr.args))
        if isinstance(expr, se.Mul):
            product: Terms = {(): 1}
            for part in expr.args:
                factor = self.read(part)
                if self.whole and len(factor) > 1:
                    factor = self._together(factor, 1)
                if len(product) * len(factor) > self.most:
                    raise EngineLimit(f"more than {self.most} terms")
                product = mul(product, factor)
            return product
        if isinstance(expr, se.Pow):
            return self._power(expr)
        if isinstance(expr, se.sin | se.cos) and isinstance(expr.args[0], se.Add):
            return self._of_sum(expr)
        if isinstance(expr, se.tan):
            return mul(self.read(se.sin(expr.args[0])), self.read(1 / se.cos(expr.args[0])))
        return {((self.index(expr), 1),): 1}

    def _of_sum(self, expr: Any) -> Terms:
        """The sine or cosine of a sum of angles, the first of which is positive; symengine has
        signs of its own there, so a letter stands for the sum."""
        angle = expr.args[0]
        terms = self.read(angle)
        sign = -1 if terms[min(terms, key=self._place)] < 0 else 1
        key = "angle", sign * angle
        if key not in self._index:
            self._index[key] = len(self.angles)
            self.angles[se.Symbol(f"angle {len(self.angles)}")] = sign * angle
        stand_in = se.Symbol(f"angle {self._index[key]}")
        turned = sign if isinstance(expr, se.sin) else 1
        return {((self.index(expr.func(stand_in)), 1),): turned}

    def _power(self, expr: Any) -> Terms:
        base, exponent = expr.args
        if not isinstance(exponent, se.Rational | se.Integer) or base.is_Number:
            return {((self.index(expr), 1),): 1}
        power = _rational(exponent)
        terms = self.read(base)
        if len(terms) == 1 and (isinstance(power, int)):
            ((m, c),) = terms.items()
            return {times((), m, power): _plain(Fraction(c) ** power)}
        if isinstance(power, int) and 0 < power <= 4 and not self.whole:
            product = terms
            for _ in range(power - 1):
                if len(product) * len(terms) > self.most:
                    raise EngineLimit(f"more than {self.most} terms")
                product = mul(product, terms)
            return product
        return self._together(terms, power)

    def _together(self, terms: Terms, power: Rational) -> Terms:
        """A power of a sum that stays a letter: its content before it, its first term positive."""
        number, common, rest = self.primitive(terms)
        if not isinstance(power, int):  # roots of factors have signs of their own
            number, common, rest = 1, (), terms
        if len(rest) == 1:
            return {((self.index(self.expression(rest)), power),): 1}
        letter = self.index(None, rest)
        scale = _plain(Fraction(number) ** power) if isinstance(power, int) else 1
        return {times(times((), common, power), ((letter, power),)): scale}

    def primitive(self, terms: Terms) -> tuple[Rational, Monomial, Terms]:
        """A number, a monomial and a sum whose product is a sum: the sum has whole coefficients
        without a common divisor, no letter in all of its terms, and most of its terms positive."""
        if not terms:
            return 1, (), {}
        number = _content(terms.values())
        order = sorted(terms, key=self._place)
        signs = sum(1 if terms[m] > 0 else -1 for m in order)
        if signs < 0 or (signs == 0 and terms[order[0]] < 0):
            number = -number
        common = dict(order[0])
        for m in order:
            powers = dict(m)
            common = {
                i: min(e, powers[i], key=abs)
                for i, e in common.items()
                if i in powers and e * powers[i] > 0
            }
        shared = tuple(sorted(common.items()))
        return number, shared, {times(m, shared, -1): over(c, number) for m, c in terms.items()}

    def _place(self, monomial: Monomial) -> Any:
        ranks = [(self.letters[i].rank, -e) for i, e in monomial]
        fast = sorted(r for r in ranks if r[0][0] >= VELOCITY)
        return not fast, fast, sum(abs(e) for _, e in monomial), sorted(ranks)

    # -- arranging ----------------------------------------------------------------------------

    def arrange(self, terms: Terms, depth: int = DEPTH) -> Sum:
        """A sum in the shortest of: written out, over one denominator, factored, collected by what
        moves, letters before brackets."""
        key = frozenset(terms.items()), depth
        if key not in self._arranged:
            self.work += len(terms)
            deep = depth if self.work < 2 * self.limit else 0
            self._arranged[key] = min(self._forms(terms, deep), key=self.length)
        return self._arranged[key]

    def length(self, parts: Sum) -> int:
        """The characters of a sum, blanks aside."""
        return len(self.text(parts).replace(" ", ""))

    def _forms(self, terms: Terms, depth: int) -> Iterator[Sum]:
        order = sorted(terms, key=self._place)
        yield tuple(self._product(terms[m], m) for m in order)
        if len(terms) < 2 or depth == 0:
            return
        number, common, rest = self.primitive(terms)
        below = self.below(rest)
        few = len(terms) <= TRIES
        if (common or number != 1) and (few or not below):
            yield self._times(number, common, self.arrange(rest, depth - 1))
        if below:
            inner = {times(m, below, -1): c for m, c in rest.items()}
            yield self._times(number, times(common, below), self.arrange(inner, depth - 1))
            rest = inner
            common = times(common, below)
        for kind in (VELOCITY, COORDINATE) if few else (VELOCITY,):
            yield from self._collect(terms, kind, depth)
        if few:
            yield from self._before_brackets(terms, depth)

    def below(self, terms: Terms) -> Monomial:
        """What the terms of a sum divide by, as a monomial with negative exponents."""
        lowest: dict[int, Rational] = {}
        for m in terms:
            for i, e in m:
                if e < lowest.get(i, 0):
                    lowest[i] = e
        return tuple(sorted(lowest.items()))

    def _product(self, number: Rational, m: Monomial) -> LetterProduct:
        return LetterProduct(number, tuple(Factor(i, e) for i, e in m))

    def _times(self, number: Rational, m: Monomial, *sums: Sum) -> Sum:
        """A product as a sum of one product."""
        factors = [Factor(i, e) for i, e in m]
        for parts, count in Counter(sums).items():
            if len(parts) > 1:
                factors.append(Factor(parts, count))
            else:
                number *= parts[0].number ** count
                factors += [Factor(f.base, f.exponent * count) for f in parts[0].factors]
        merged: dict[Any, Rational] = {}
        for f in factors:
            merged[f.base] = _plain(merged.get(f.base, 0) + f.exponent)
        return (LetterProduct(number, tuple(Factor(b, e) for b, e in merged.items() if e)),)

    def _collect(self, terms: Terms, kind: int, depth: int) -> Iterator[Sum]:
        """By the letters of some kind; equal coefficients before brackets."""
        groups: dict[Monomial, Terms] = {}
        for m, c in terms.items():
            key = tuple((i, e) for i, e in m if self.letters[i].rank[0] >= kind)
            groups.setdefault(key, {})[times(m, key, -1)] = c
        if not 1 < len(groups) < len(terms):
            return
        equal: dict[Any, tuple[Terms, Terms]] = {}
        for key, coefficient in groups.items():
            number, common, rest = self.primitive(coefficient)
            one = equal.setdefault(frozenset(rest.items()), (rest, {}))
            one[1][times(key, common)] = number
        products: list[LetterProduct] = []
        for rest, cofactor in equal.values():
            if len(equal) == 1 and len(rest) == 1:
                return
            number, common, inner = self.primitive(cofactor)
            if len(rest) == 1:
                products += self.arrange(mul(rest, cofactor), depth)
            else:
                products += self._times(
                    number, common, self.arrange(rest, depth - 1), self.arrange(inner, depth - 1)
                )
        yield tuple(products)

    def _before_brackets(self, terms: Terms, depth: int) -> Iterator[Sum]:
        counts: Counter[tuple[int, bool]] = Counter()
        for m in terms:
            counts.update((i, e > 0) for i, e in m)
        gains = sorted(
            ((1 - n) * (len(self.letter_text(i)) + 1), i, up)
            for (i, up), n in counts.items()
            if 1 < n < len(terms)
        )
        for _, i, up in gains[:2]:
            inside, outside = Terms(), Terms()
            for m, c in terms.items():
                e = dict(m).get(i, 0)
                (inside if e and (e > 0) == up else outside)[m] = c
            yield (*self.arrange(inside, depth), *self.arrange(outside, depth))

    # -- writing ------------------------------------------------------------------------------

    def letter_text(self, letter: int) -> str:
        """A letter in characters; a sum that has no name in brackets."""
        if letter not in self.names:
            entry = self.letters[letter]
            inner = None if entry.terms is None else self.text(self.arrange(entry.terms))
            self.names[letter] = self._text(entry.meaning) if inner is None else f"({inner})"
        return self.names[letter]

    def text(self, parts: Sum) -> str:
        """A sum in one line."""
        if parts not in self._written:
            self._written[parts] = self._sum_text(parts, self._product_text)
        return self._written[parts]

    def _sum_text(self, parts: Sum, write: Callable[[LetterProduct], str]) -> str:
        text = ""
        first, *others = self.in_order(parts) or [LetterProduct(0, ())]
        for part in (_turn(first), *others) if parts else ():
            sign = "-" if part.number < 0 else "+"
            text += f" {sign} {write(part)}" if text else sign.strip("+") + write(part)
        return text or "0"

    def in_order(self, parts: Sum) -> list[LetterProduct]:
        """The products of a sum as they are written: a positive one first."""
        products = sorted(parts, key=self._product_place)
        first = next((p for p in products if p.number > 0), None)
        if first is not None and products[0].number < 0:
            products.remove(first)
            products.insert(0, first)
        return products

    def _product_place(self, product: LetterProduct) -> Any:
        places = sorted(map(self._factor_place, product.factors))
        fast = [r for _, r, _ in places if r[0] >= VELOCITY]
        return not fast, fast, sum(abs(f.exponent) for f in product.factors), places

    def _factor_place(self, factor: Factor) -> tuple[int, tuple[int, int], Rational]:
        """Where a factor stands: constants, coordinates, velocities, functions, brackets."""
        rank = self._factor_rank(factor.base)
        late = 0
        if not isinstance(factor.base, int) or factor.base not in self.named:
            late = int(rank[0] == COORDINATE + 1)
        return late, rank, -factor.exponent

    def _factor_rank(self, base: Any) -> tuple[int, int]:
        if isinstance(base, int):
            return self.letters[base].rank
        if base not in self._ranks:
            highest = max(self._factor_rank(f.base) for p in base for f in p.factors)
            kind = COORDINATE + 2 if highest[0] >= COORDINATE else COORDINATE - 1
            self._ranks[base] = kind, 0
        return self._ranks[base]

    def parts(self, product: LetterProduct) -> tuple[int, int, list[Factor], list[Factor]]:
        """Numerator and denominator of a product without its sign: numbers and factors."""
        above, below = [], []
        for factor in sorted(self._tangents(product.factors), key=self._factor_place):
            if factor.exponent > 0:
                above.append(factor)
            else:
                below.append(Factor(factor.base, -factor.exponent))
        number = abs(product.number)
        return number.numerator, number.denominator, above, below

    def _tangents(self, factors: tuple[Factor, ...]) -> list[Factor]:
        """Factors with tangents for quotients of sines and cosines."""
        powers: dict[Any, Rational] = {f.base: f.exponent for f in factors}
        for base in [*powers]:
            if not isinstance(base, int) or not isinstance(self.letters[base].meaning, se.sin):
                continue
            angle = self.letters[base].meaning.args[0]
            other = self._index.get(se.cos(angle))
            if other in powers and powers[base] * powers[other] < 0:
                shared = min(abs(powers[base]), abs(powers[other]))
                up = powers[base] > 0
                name = self.index(se.tan(angle) if up else se.cot(angle))
                powers[name] = shared
                powers[base] -= shared if up else -shared
                powers[other] += shared if up else -shared
        return [Factor(b, _plain(e)) for b, e in powers.items() if e]

    def _product_text(self, product: LetterProduct) -> str:
        p, q, top_factors, bottom_factors = self.parts(product)
        above, below = ([self._power_text(f) for f in fs] for fs in (top_factors, bottom_factors))
        top = [str(p)] * (p != 1) + above
        bottom = [str(q)] * (q != 1) + below
        numerator = "*".join(top or ["1"])
        if not bottom:
            return numerator
        return (
            f"{numerator}/{bottom[0]}" if len(bottom) == 1 else f"{numerator}/({'*'.join(bottom)})"
        )

    def _power_text(self, factor: Factor) -> str:
        base, e = factor
        text = self.letter_text(base) if isinstance(base, int) else f"({self.text(base)})"
        if isinstance(e, int):
            return text if e == 1 else f"{text}^{e}"
        inner = text[1:-1] if text.startswith("(") else text
        if e == Fraction(1, 2):
            return f"sqrt({inner})"
        return f"sqrt({inner})^{e.numerator}" if e.denominator == 2 else f"{text}^({e})"

    # -- LaTeX --------------------------------------------------------------------------------

    def latex(self, parts: Sum) -> str:
        """A sum as LaTeX."""
        return self._sum_text(parts, self._product_latex)

    def _product_latex(self, product: LetterProduct) -> str:
        p, q, above, below = self.parts(product)
        alone = [len(above) == p and bool(below), len(below) == q]
        top, bottom = map(self._factors_latex, (above, below), alone)
        if not bottom:
            small = f"{p}{q}" if p < 10 > q else f"{{{p}}}{{{q}}}"
            number = rf"\tfrac{small}" if q != 1 else str(p) if p != 1 or not top else ""
            return f"{number} {top}".strip()
        top = f"{p} {top}".strip() if p != 1 or not top else top
        return rf"\frac{{{top}}}{{{bottom if q == 1 else f'{q} {bottom}'}}}"

    def _factors_latex(self, factors: list[Factor], alone: bool) -> str:
        """Factors one after the other; a bracket that a fraction holds alone needs no brackets."""
        if alone and len(factors) == 1 and factors[0].exponent == 1:
            base = factors[0].base
            inner = self.letters[base].terms if isinstance(base, int) else None
            if not isinstance(base, int):
                return self.latex(base)
            if inner is not None and base not in self.named:
                return self.latex(self.arrange(inner))
        return " ".join(map(self._power_latex, factors))

    def _power_latex(self, factor: Factor) -> str:
        base, e = factor
        root = isinstance(e, Fraction) and e.denominator == 2
        count = e.numerator if root else e
        power = "" if count == 1 else f"^{count}" if 0 <= count < 10 else f"^{{{count}}}"
        entry = self.letters[base] if isinstance(base, int) else None
        if entry is None or (entry.terms is not None and base not in self.named):
            inner = self.latex(base if entry is None else self.arrange(entry.terms or {}))
            text = rf"\left({inner}\right)" if "frac" in inner else f"({inner})"
        else:
            inner = text = (
                symbol_latex(self.names[base]) if entry.terms else self._latex(entry.meaning)
            )
        function = re.match(r"\\(sin|cos|tan|cot)", text)
        if root:
            return rf"\sqrt{{{inner}}}{power}"
        if function:  # \sin^2\phi
            return function[0] + power + text[function.end() :]
        simple = not power or re.fullmatch(r"\(.*\)|(\\d+ot ?)?\\?\w+(_(\w|\{\w+\}))?", text)
        return text + power if simple or "left" in text else f"({text}){power}"


def _turn(product: LetterProduct) -> LetterProduct:
    """A product with a sign before it, where a bracket can take it: (b - a) x for -(a - b) x."""
    for place, (base, e) in enumerate(product.factors if product.number < 0 else ()):
        odd = isinstance(e, int) and e % 2
        if not isinstance(base, int) and odd and any(p.number < 0 for p in base):
            factors = list(product.factors)
            factors[place] = Factor(negate(base), e)
            return LetterProduct(-product.number, tuple(factors))
    return product


def negate(parts: Sum) -> Sum:
    """The negative of a sum, arranged as it is."""
    return tuple(p._replace(number=-p.number) for p in parts)


def _number(e: Rational) -> Any:
    return se.Rational(e.numerator, e.denominator) if isinstance(e, Fraction) else se.Integer(e)


def _content(numbers: Iterable[Fraction]) -> Rational:
    fractions = [*numbers]
    return over(
        gcd(*(abs(c.numerator) for c in fractions)), lcm(*(c.denominator for c in fractions))
    )


def _rational(number: Any) -> Rational:
    return int(number) if isinstance(number, se.Integer) else over(int(number.p), int(number.q))
