"""Functions of functions in one form, where polynomials alone do not see that two are equal.

Arguments are brought to normal form; sines of inverse functions are roots; inverse hyperbolic
functions are logarithms, powers with symbolic exponents exponentials; the logarithm of a product is
the sum of those of the sizes of its factors.  Each step holds wherever both sides have real values,
so what is proved of the forms is proved of the expressions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from math import lcm
from typing import Any

import flint
import symengine as se

from voronec.algebra.certificates import Sign, Signs
from voronec.algebra.conditions import as_rational, split_hypotheses
from voronec.algebra.factors import fraction_factors
from voronec.algebra.generators import TRIGONOMETRIC, linear_terms, prime_factors
from voronec.algebra.graphs import is_atom, is_flat, nodes
from voronec.algebra.memo import remember
from voronec.algebra.normal import Budget, canonical
from voronec.algebra.ring import Ring
from voronec.algebra.roots import domain_conditions, known_sign, ring_over
from voronec.algebra.tape import Tape
from voronec.algebra.terms import factors_of
from voronec.errors import DefinitionError, EngineLimit

LARGEST = 400
"""Nodes of a graph beyond which no further form is tried."""
INNER_WORK = 60_000
"""Term products for an argument."""
FOLD = 6
"""The largest multiple of an inverse function that is written out under a sine."""
MOST_SIGNS = 2
"""How many signs are taken in all cases."""
HALF = se.Rational(1, 2)
_Term = tuple[Any, Any]
INVERSE = (se.asin, se.atan, se.atan2)
_NO_NUMBERS = (se.zoo, se.nan, se.oo, -se.oo)


def are_equal(a: Any, b: Any, relations: Sequence[Any]) -> bool:
    """Whether two symengine expressions are proved to be equal by these forms, where relations
    vanish and conditions among them hold; raises ``EngineLimit`` beyond a bound."""
    if Tape([a, b]).size > LARGEST:
        return False
    in_pieces = any(isinstance(n, se.sign | se.floor) for n in nodes([a, b]))
    return all(
        _agrees_within(left, right, hypotheses, in_pieces)
        for left, right, hypotheses in _cases(a, b, relations)
    )


def _agrees_within(a: Any, b: Any, relations: Sequence[Any], in_pieces: bool) -> bool:
    """Whether two expressions agree, as far as that costs no more than it may."""
    try:
        return _agree(a, b, relations, in_pieces)
    except (EngineLimit, DefinitionError, RecursionError):  # forms nested too deeply
        return False


def _agree(a: Any, b: Any, relations: Sequence[Any], in_pieces: bool) -> bool:
    """Whether two expressions agree in one case; a piece that is not taken need not be real."""
    whole = _whole(relations)
    known = [*relations, *(() if in_pieces else _real_where([a, b], whole))]
    forms = Composition(known)
    if _has_no_value([a, b]):
        return False
    prepared = forms.prepare([a, b])
    if _has_no_value(prepared):
        return False
    left, right = map(forms.resolve, prepared)
    if _has_no_value([left, right]):
        return False
    left, right = fold_angles([left, right])
    known += () if in_pieces else _real_where([left, right], whole)
    ring = ring_over([left, right, left - right], known, split=True)
    if ring.fraction(left - right).num == 0:
        return True
    return _same_squares(ring, left, right, known)


def _same_squares(ring: Ring, left: Any, right: Any, known: Sequence[Any]) -> bool:
    """Whether two sides that are not negative have the same square."""
    signs = Signs.of(ring, split_hypotheses(known)[1], bounded=True)
    if not (_not_negative(left, ring, signs) and _not_negative(right, ring, signs)):
        return False
    one, other = (ring.field.power(ring.fraction(side), 2) for side in (left, right))
    minus = ring.field.mul([ring.field.constant(-1), other])
    return bool(ring.field.add([one, minus]).num == 0)


def _not_negative(expr: Any, ring: Ring, signs: Signs) -> bool:
    """Whether an expression is made of even roots, positive numbers and what has a sign."""
    if isinstance(expr, se.Add | se.Mul):
        if all(_not_negative(a, ring, signs) for a in expr.args):
            return True
    elif isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Rational):
        even = int(expr.args[1].q) % 2 == 0
        if even or _not_negative(expr.args[0], ring, signs):
            return True
    try:
        sign = signs.of_fraction(ring.fraction(expr))
    except (EngineLimit, KeyError):
        return False
    return sign is not None and sign.value >= 0


def _cases(a: Any, b: Any, relations: Sequence[Any]) -> Iterator[tuple[Any, Any, list[Any]]]:
    """Both sides where each sign's argument vanishes, and where it does not: u/|u|."""
    inner = [*dict.fromkeys(n.args[0] for n in nodes([a, b]) if isinstance(n, se.sign))]
    if len(inner) > MOST_SIGNS:
        raise EngineLimit("there are too many signs to take all cases")
    for zero in product((False, True), repeat=len(inner)):
        at, more = {}, []
        for u, vanishes in zip(inner, zero, strict=True):
            at[se.sign(u)] = se.Integer(0) if vanishes else u / se.sqrt(u**2)
            more += [u] if vanishes else []
        if more and any(n.args and isinstance(n, se.sign) for u in more for n in nodes([u])):
            raise EngineLimit("a sign function stands inside another one")
        left, right = a.xreplace(at), b.xreplace(at)
        if not (more and _has_no_value([left, right])):  # 1/sign(u) is not defined where u = 0
            yield left, right, [*relations, *more]


def _has_no_value(exprs: Iterable[Any]) -> bool:
    """Whether something in expressions is infinite, not real, or no number at all."""
    return any(node in _NO_NUMBERS or (node.is_Number and node.is_complex) for node in nodes(exprs))


def _whole(hypotheses: Iterable[Any]) -> frozenset[Any]:
    """The symbols that are whole numbers by hypothesis, or may be, as an r with r - 3 = 0 is."""
    equations, conditions = split_hypotheses(hypotheses)
    told = (c for c in conditions if any(isinstance(n, se.floor) for n in nodes(c.args)))
    return frozenset(Tape([*equations, *(side for c in told for side in c.args)]).atoms)


def _may_be_whole(exponent: Any, whole: frozenset[Any]) -> bool:
    """Whether an exponent may be a whole number, so that the base may be negative."""
    parts = [*nodes([exponent])]
    return any(n in whole or isinstance(n, se.floor | se.sign) for n in parts)


def _has_positive_base(node: Any, whole: frozenset[Any]) -> bool:
    """Whether a node is a power with letters above that are not known to be whole numbers."""
    is_power = isinstance(node, se.Pow) and bool(node.args[0].free_symbols)
    return is_power and not (node.args[1].is_Number or _may_be_whole(node.args[1], whole))


def positive_bases(exprs: Iterable[Any], hypotheses: Iterable[Any]) -> list[Any]:
    """What counts as positive in expressions, since it is raised to powers with letters that are
    not known to be whole numbers, and is not known to be so."""
    known = [*hypotheses]
    whole = _whole(known)
    bases = [n.args[0] for n in nodes(exprs) if _has_positive_base(n, whole)]
    return [b for b in dict.fromkeys(bases) if known_sign(b, known) < 1]


def _real_where(exprs: Sequence[Any], whole: frozenset[Any]) -> Iterator[Any]:
    """What holds where expressions are real: of radicands, of bases of powers with symbolic
    exponents, of what inverse functions are taken of.  Of logarithms nothing: log(x**2) is not said
    to be 2*log(x), which has no value for x < 0."""
    yield from domain_conditions(exprs)
    for node in nodes(exprs):
        inner = node.args[0] if node.args and node.free_symbols else None
        if inner is None or not inner.free_symbols:
            continue
        if _has_positive_base(node, whole):
            yield inner > 0
        elif isinstance(node, se.asin | se.acos):
            yield 1 - inner**2 >= 0
        elif isinstance(node, se.atanh):
            yield 1 - inner**2 > 0


class Composition:
    """Rewrites expressions from the inside out, under hypotheses."""

    def __init__(self, hypotheses: Sequence[Any]) -> None:
        self._hypotheses = hypotheses
        self._conditions = split_hypotheses(hypotheses)[1]
        self._whole = _whole(hypotheses)
        self._known: dict[Any, Any] = {}

    @remember("_known")
    def resolve(self, expr: Any) -> Any:
        """The expression with every function in it in one form."""
        if not expr.args or is_atom(expr):
            return expr
        if isinstance(expr, se.Pow):
            return self._power(*expr.args)
        if is_flat(expr):
            return se.Integer(0)
        arguments = [self.resolve(a) for a in expr.args]
        if isinstance(expr, TRIGONOMETRIC):
            return self._trigonometric(type(expr), arguments[0])
        rule = _RULES.get(type(expr))
        if rule is not None:
            return rule(self, *arguments)
        if not isinstance(expr, se.Add | se.Mul):
            arguments = [self._normal(a) for a in arguments]
        return expr.func(*arguments)

    def _normal(self, expr: Any) -> Any:
        """An argument in normal form; as it stands where that costs too much."""
        try:
            return canonical([expr], self._hypotheses, Budget(INNER_WORK), split=True)[0]
        except (EngineLimit, DefinitionError):
            return expr

    # -- sines ----------------------------------------------------------------------------

    def _angle(self, angle: Any) -> Any:
        """A sum whose terms are in normal form."""
        try:
            terms = linear_terms(angle)
            parts = [c * (t if t.is_Number else self._normal(t)) for t, c in terms.items()]
            return se.Add(*parts)
        except EngineLimit:
            return angle

    def _trigonometric(self, kind: type, angle: Any) -> Any:
        sine, cosine = self._pair(self._angle(angle))
        table: dict[type, Callable[[], Any]] = {
            se.sin: lambda: sine,
            se.cos: lambda: cosine,
            se.tan: lambda: sine / cosine,
            se.cot: lambda: cosine / sine,
            se.sec: lambda: 1 / cosine,
            se.csc: lambda: 1 / sine,
        }
        return table[kind]()

    def _pair(self, angle: Any) -> tuple[Any, Any]:
        """Sine and cosine of a sum, with inverse functions written out."""
        rest, written = list[_Term](), list[_Term]()
        for term, n in linear_terms(angle).items():
            halved = isinstance(2 * n, se.Integer) and isinstance(term, se.asin | se.atan)
            small = (halved or isinstance(n, se.Integer)) and abs(n) <= FOLD
            (written if small and isinstance(term, INVERSE) else rest).append((term, n))
        plain = se.Add(*[c * t for t, c in rest])
        sine, cosine = se.sin(plain), se.cos(plain)
        for term, n in written:
            s, c = _of_inverse(term)
            if not isinstance(n, se.Integer):  # half of an angle whose cosine is not negative
                half = se.sqrt((1 + c) / 2)
                s, c, n = s / (2 * half), half, 2 * n
            for _ in range(abs(int(n))):
                up = s if n > 0 else -s
                sine, cosine = sine * c + cosine * up, cosine * c - sine * up
        return sine, cosine

    def prepare(self, exprs: Sequence[Any]) -> list[Any]:
        """Expressions with the angles in normal form, as far as no sines stand in them, and
        folded; what has no value in the case at hand is left as it is."""
        at: dict[Any, tuple[Any, Any]] = {}
        for angle in angles_of(exprs):
            vector = linear_terms(angle)
            outer = [t for t in vector if t.atoms(*TRIGONOMETRIC)]
            kept = se.Add(*[vector.pop(t) * t for t in outer])
            at[angle] = (
                kept,
                se.Add(*[c * self._angle(self.resolve(t)) for t, c in vector.items()]),
            )
        known: dict[Any, Any] = {}
        prepared = [_with_angles(e, at, known) for e in exprs]
        return prepared if _has_no_value(prepared) else fold_angles(prepared)

    # -- exponentials and logarithms ------------------------------------------------------

    def _power(self, base: Any, exponent: Any) -> Any:
        if base != se.E and isinstance(exponent, se.Rational):
            inner = self.resolve(base)
            return se.Pow(inner if exponent.q == 1 else self._normal(inner), exponent)
        exponent = self.resolve(exponent)
        if base != se.E:
            inner = self.resolve(base)
            if _may_be_whole(exponent, self._whole) and not self.is_positive(inner):
                return se.Pow(self._normal(inner), exponent)
            exponent = exponent * self._logarithm(inner)
        parts, rest = [], []
        for term, c in linear_terms(exponent).items():
            if isinstance(term, se.log):
                parts.append(se.Pow(term.args[0], c))
            else:
                rest.append(c * self._product(term))
        return se.Mul(se.exp(se.Add(*rest)), *parts)

    def is_positive(self, expr: Any) -> bool:
        """Whether it is known that an expression is positive."""
        try:
            ring = ring_over([expr], self._hypotheses, INNER_WORK)
            sign = Signs.of(ring, self._conditions, bounded=True).of_fraction(ring.fraction(expr))
        except (EngineLimit, DefinitionError):
            return False
        return sign is not None and sign.value == 1 and sign.strict

    def _product(self, term: Any) -> Any:
        """A term in normal form, its logarithms apart."""
        if term.is_Number:
            return term
        factors = factors_of(term)
        logs = [f for f in factors if f.atoms(se.log)]
        return se.Mul(self._normal(se.Mul(*[f for f in factors if f not in logs])), *logs)

    def _logarithm(self, argument: Any) -> Any:
        """The sum of the logarithms of the sizes of factors; a single factor of either sign stays
        as it is, so that nothing is said of log(x) where x is negative."""
        try:
            ring = ring_over([argument], self._hypotheses, INNER_WORK, split=True)
            fraction = ring.fraction(argument)
            unit, powers = fraction_factors(fraction.num, ring.field.factors(fraction.den))
            signs = Signs.of(ring, self._conditions, bounded=True)
        except (EngineLimit, DefinitionError):
            return se.log(argument)
        terms, others = list[Any](), list[_Term]()
        for poly, e in powers:
            size = self._size(ring, signs, poly)
            if size is None:
                others.append((ring.polynomial(poly), e))
            else:
                terms.append(e * size)
                unit = -unit if e % 2 and _is_negative(signs.of_polynomial(poly)) else unit
        odd = [(f, 1 if e > 0 else -1) for f, e in others if e % 2]
        if len(odd) == 1:
            ((single, once),) = odd
            terms.append(once * se.log(single if unit > 0 else -single))
            others = [(f, e - once if f == single else e) for f, e in others]
        elif unit < 0 and not odd:  # the size of what is negative is another function
            return se.log(argument)
        terms += [e * HALF * se.log(f**2) for f, e in others]
        for n, side in ((int(unit.p), 1), (int(unit.q), -1)):
            terms += [side * k * se.log(se.Integer(p)) for p, k in prime_factors(abs(n)).items()]
        return se.Add(*terms)

    def _size(self, ring: Ring, signs: Signs, poly: Any) -> Any:
        """The logarithm of the size of an irreducible polynomial; None where its sign is open."""
        expr = ring.polynomial(poly)
        if isinstance(expr, se.Pow):
            base, exponent = expr.args
            return exponent if base == se.E else exponent * self._logarithm(base)
        sign = signs.of_polynomial(poly)
        return se.log(sign.value * expr) if sign is not None and sign.value else None

    # -- inverse functions ----------------------------------------------------------------

    def _odd(self, kind: Any, argument: Any) -> Any:
        """asin or atan, odd in its argument; the arctangent of what has a sign, or of the
        reciprocal."""
        argument = self._normal(argument)
        try:
            ring = ring_over([argument], self._hypotheses, INNER_WORK, split=True)
            fraction = ring.fraction(argument)
            if fraction.num == 0:
                return se.Integer(0)
            above, below = fraction.num, ring.field.denominator(fraction.den)
            sign = Signs.of(ring, self._conditions, bounded=True).of_fraction(fraction)
        except (EngineLimit, DefinitionError):
            return kind(argument)
        if sign is None or not (sign.strict and sign.value):
            opposite = self._normal(-argument)  # one of the two, whichever is asked for
            if (len(str(opposite)), str(opposite)) < (len(str(argument)), str(argument)):
                return -kind(opposite)
            return kind(argument)
        positive = argument if sign.value > 0 else self._normal(-argument)
        texts = [str(p / p.leading_coefficient()) for p in (above, below)]
        if kind is se.atan and texts[0] < texts[1]:
            return sign.value * (se.pi / 2 - kind(self._normal(1 / positive)))
        return sign.value * kind(positive)


_RULES: dict[type, Callable[..., Any]] = {
    se.asin: lambda own, u: own._odd(se.asin, u),
    se.acos: lambda own, u: se.pi / 2 - own._odd(se.asin, u),
    se.atan: lambda own, u: own._odd(se.atan, u),
    se.acot: lambda own, u: own._odd(se.atan, 1 / u),
    se.log: lambda own, u: own._logarithm(u),
    se.asinh: lambda own, u: own._logarithm(u + se.sqrt(u**2 + 1)),
    se.acosh: lambda own, u: own._logarithm(u + se.sqrt(u**2 - 1)),
    se.atanh: lambda own, u: HALF * own._logarithm((1 + u) / (1 - u)),
}


def _is_negative(sign: Sign | None) -> bool:
    return sign is not None and sign.value < 0


def _of_inverse(term: Any) -> tuple[Any, Any]:
    """Sine and cosine of an inverse function."""
    u = term.args[0]
    if isinstance(term, se.asin):
        return u, se.sqrt(1 - u**2)
    below = term.args[1] if isinstance(term, se.atan2) else se.Integer(1)
    size = se.sqrt(u**2 + below**2)
    return u / size, below / size


def angles_of(exprs: Iterable[Any]) -> list[Any]:
    """What sines and the like are taken of."""
    return [*dict.fromkeys(n.args[0] for n in nodes(exprs) if isinstance(n, TRIGONOMETRIC))]


def fold_angles(exprs: Sequence[Any]) -> list[Any]:
    """Expressions with whole multiples of new symbols for what of angles holds no sines.

    The symbols stand for parts of sums that span them all over the rational numbers.  So the half
    of x + y is the half of something, sin(x) is 2 sin(x/2) cos(x/2), and however long two angles
    are, their sum and their difference are made of two letters.
    """
    vectors = {a: linear_terms(a) for a in angles_of(exprs)}
    kept = {a: _take_constant_part(v) for a, v in vectors.items()}
    new = dict.fromkeys(vectors, se.Integer(0))
    for held in _coordinates([*vectors.values()]):
        fine = lcm(*(int(r.q) for r in held))
        name = se.Dummy()
        for a, ratio in zip(vectors, held, strict=True):
            new[a] += se.Integer(int((ratio * fine).p)) * name
    known: dict[Any, Any] = {}
    at = {a: (kept[a], new[a]) for a in vectors}
    return [_with_angles(e, at, known) for e in exprs]


def _take_constant_part(vector: dict[Any, Any]) -> Any:
    """The part of a sum, taken out of it, that stays as it is: turns, inverse functions, what holds
    sines, a sum that is a number."""
    fixed = (*INVERSE, se.acos)
    stay = [t for t in vector if isinstance(t, fixed) or t.atoms(*TRIGONOMETRIC)]
    alone = {*vector} - {*stay} <= {se.Integer(1), se.pi}
    stay += [t for t in (se.pi, se.Integer(1)) if t in vector and (alone or t == se.pi)]
    return se.Add(*[vector.pop(t) * t for t in stay])


def _coordinates(vectors: Sequence[dict[Any, Any]]) -> Iterator[list[Any]]:
    """Rows of coordinates of vectors, in a basis of some of them, the shortest first; in the terms
    themselves where there are no more of these."""
    names = [*dict.fromkeys(k for v in vectors for k in v)]
    rows = [[as_rational(se.sympify(v.get(k, 0))) for v in vectors] for k in names]
    if not names:
        return
    order = sorted(range(len(vectors)), key=lambda i: len(vectors[i]))
    matrix = flint.fmpq_mat([[row[i] for i in order] for row in rows])
    reduced, rank = matrix.rref()
    if rank == len(names) and any(len(v) == 1 for v in vectors):
        yield from rows
        return
    back = sorted(range(len(order)), key=order.__getitem__)
    for i in range(rank):
        yield [reduced[i, j] for j in back]


def _with_angles(expr: Any, at: dict[Any, tuple[Any, Any]], known: dict[Any, Any]) -> Any:
    """An expression with the angles under sines replaced, each by what stays of it, in which the
    same is done, and by what is new."""
    if not expr.args or is_atom(expr):
        return expr
    if expr not in known:
        if isinstance(expr, TRIGONOMETRIC):
            kept, new = at[expr.args[0]]
            known[expr] = expr.func(_with_angles(kept, at, known) + new)
        else:
            known[expr] = expr.func(*[_with_angles(a, at, known) for a in expr.args])
    return known[expr]
