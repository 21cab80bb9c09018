"""One letter for arguments of functions that are equal, though they are written otherwise.

f(u) = f(v) follows from u = v, and what holds for every value of a letter holds for that of an
argument.  From the inside out arguments are compared at a few points; where the ratio is one small
rational number c at all of them, u = c v is proved, and sines and exponentials of both are taken of
multiples of one letter; other functions are taken of v.  Points only say what is tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import TRIGONOMETRIC
from voronec.algebra.graphs import is_atom, nodes
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import SHARP
from voronec.algebra.tape import Tape
from voronec.algebra.terms import summands

__all__ = ["Congruence"]

MOST = 40
"""How many arguments are compared."""
LARGEST_RATIO = 64
"""Numerators and denominators of ratios of arguments that are looked for."""
_ONE = se.Integer(1)
_INNER = (se.log, se.asin, se.acos, se.atan, se.atan2, se.asinh, se.acosh, se.atanh)
"""Functions beside roots that are taken of the same expression where arguments are equal."""
_INVERSE = (se.asin, se.acos, se.atan, se.atan2)


@dataclass(frozen=True)
class _Argument:
    """An argument as it was written and with letters, its values, and its letter."""

    argument: Any
    letter_form: Any
    values: list[Any]
    letter: Any


@dataclass
class Congruence:
    """Rewrites expressions; ``proves`` decides whether two of them are equal, ``is_positive``
    whether one is known to be positive.  Of sums ``whole`` ones are compared, or their terms."""

    proves: Callable[[Any, Any], bool]
    is_positive: Callable[[Any], bool]
    whole: bool
    conditions: list[Any] = field(default_factory=list)
    """What is known of the letters."""
    changed: bool = False
    """Whether two arguments were found to be equal that are written otherwise."""
    _kept: list[_Argument] = field(default_factory=list)
    _values: dict[Any, list[Any]] = field(default_factory=dict)
    _known: dict[Any, Any] = field(default_factory=dict)

    def replace_by_letters(self, exprs: Sequence[Any], relations: Sequence[Any]) -> list[Any]:
        """Expressions with letters for what functions are taken of."""
        parts = [_ONE, *dict.fromkeys(_arguments(exprs))]
        if not 1 < len(parts) <= MOST:
            return [*exprs]
        samples = sample_evaluable(Tape(parts), relations, SHARP)
        if not samples:
            return [*exprs]
        columns = zip(*(values for _, values in samples), strict=True)
        self._values = {p: [*column] for p, column in zip(parts, columns, strict=True)}
        for part in parts:
            if not _holds_functions(part):
                self._keep(part, part, part)
        return [self._rewrite(e) for e in exprs]

    def _rewrite(self, expr: Any) -> Any:
        if not expr.args or is_atom(expr):
            return expr
        if expr not in self._known:
            self._known[expr] = self._function(expr)
        return self._known[expr]

    def _function(self, expr: Any) -> Any:
        if isinstance(expr, TRIGONOMETRIC):
            return expr.func(self._sum(expr.args[0]))
        if isinstance(expr, se.Pow) and expr.args[0] == se.E:
            return se.exp(self._sum(expr.args[1]))
        if isinstance(expr, se.Pow) and not isinstance(expr.args[1], se.Integer):
            base, exponent = expr.args
            symbolic = not exponent.is_Number
            return se.Pow(self._replace(base), self._sum(exponent) if symbolic else exponent)
        if isinstance(expr, _INNER):
            return expr.func(*[self._replace(a) for a in expr.args])
        return expr.func(*[self._rewrite(a) for a in expr.args])

    def _replace(self, argument: Any) -> Any:
        """An argument, or what it was proved to be equal to."""
        if not _holds_functions(argument):
            return argument
        ratio, kept = self._class_of(argument)
        return ratio * kept.letter_form

    def _sum(self, argument: Any) -> Any:
        """An angle or an exponent, in letters for what holds functions."""
        if self.whole and _holds_functions(argument) and self._has_partner(argument):
            ratio, kept = self._class_of(argument)
            return ratio * kept.letter
        return se.Add(*[c * self._term(t) for t, c in _terms(argument)])

    def _term(self, term: Any) -> Any:
        """A letter for a term; sines of inverse functions are no sines of just any angle."""
        if not _holds_functions(term):
            return term
        if isinstance(term, _INVERSE):
            return self._rewrite(term)
        ratio, kept = self._class_of(term)
        return ratio * kept.letter

    def _has_partner(self, argument: Any) -> bool:
        """Whether another expression may be a multiple of an argument."""
        mine = self._values.get(argument)
        others = (v for e, v in self._values.items() if e != argument)
        return mine is not None and any(_ratio(mine, v) is not None for v in others)

    def _class_of(self, argument: Any) -> tuple[Any, _Argument]:
        """(c, v) for an argument that is proved to be c v; v may be new."""
        rewritten = self._rewrite(argument)
        values = self._values.get(argument, [])
        for kept in self._kept if values else ():
            ratio = _ratio(values, kept.values)
            if ratio is None:
                continue
            pairs = ((rewritten, kept.letter_form), (argument, kept.argument))
            if any(u == ratio * v for u, v in pairs):
                return ratio, kept
            if any(self.proves(u, ratio * v) for u, v in pairs):
                self.changed = True
                return ratio, kept
        letter = se.Dummy()
        if self.is_positive(argument):
            self.conditions.append(letter > 0)
        return _ONE, self._keep(argument, rewritten, letter)

    def _keep(self, argument: Any, lettered: Any, letter: Any) -> _Argument:
        new = _Argument(argument, lettered, self._values.get(argument, []), letter)
        if new.values:
            self._kept.append(new)
        return new


def _holds_functions(expr: Any) -> bool:
    """Whether an expression holds a function or a root."""
    return any(not _is_plain(n) for n in nodes([expr]))


def _is_plain(node: Any) -> bool:
    if isinstance(node, se.Pow):
        return isinstance(node.args[1], se.Integer)
    return not node.args or isinstance(node, se.Add | se.Mul) or is_atom(node)


def _terms(argument: Any) -> Iterator[tuple[Any, Any]]:
    """(term, number): a sum as it is written; a number stands as a term."""
    number, rest = _number_of(argument)
    for term in summands(rest):
        inner, bare = _number_of(term)
        yield bare, number * inner


def _number_of(product: Any) -> tuple[Any, Any]:
    """c and u of a rational c times u."""
    if isinstance(product, se.Mul) and isinstance(product.args[0], se.Rational):
        return product.args[0], se.Mul(*product.args[1:])
    return _ONE, product


def _arguments(exprs: Sequence[Any]) -> Iterator[Any]:
    """What functions are taken of: of sines and exponentials the terms, too."""
    for node in nodes(exprs):
        if not node.args or is_atom(node):
            continue
        power = isinstance(node, se.Pow)
        if isinstance(node, TRIGONOMETRIC) or (power and not node.args[1].is_Number):
            angle = node.args[-1]
            yield angle
            yield from (t for t, _ in _terms(angle) if _holds_functions(t))
        if power and not isinstance(node.args[1], se.Integer) and node.args[0] != se.E:
            yield node.args[0]
        elif isinstance(node, _INNER):
            yield from node.args


def _ratio(above: Sequence[Any], below: Sequence[Any]) -> Any:
    """The small rational number that all quotients of values may be; else None."""
    found: set[Fraction] = set()
    for u, v in zip(above, below, strict=True):
        if v.contains(0):
            return None
        quotient = u / v
        near = Fraction(float(quotient.mid())).limit_denominator(LARGEST_RATIO)
        if not 0 < abs(near.numerator) <= LARGEST_RATIO or len(found | {near}) > 1:
            return None
        if not quotient.contains(flint.fmpq(near.numerator, near.denominator)):
            return None
        found.add(near)
    (ratio,) = found
    return se.Rational(ratio.numerator, ratio.denominator)
