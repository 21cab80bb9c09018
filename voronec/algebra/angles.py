"""Angles that are given by their tangents: sines and cosines of atan2(y, x) as algebra.

With h = sqrt(x^2 + y^2), sin atan2(y, x) = y/h and cos atan2(y, x) = x/h; sums of such angles with
others by the addition theorems.  Radicands are brought to normal form, so that equal roots are one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import symengine as se

from voronec.algebra.graphs import rebuild
from voronec.algebra.memo import remember
from voronec.algebra.normal import canonical
from voronec.algebra.terms import atoms, summands

MOST = 6
"""The largest multiple of an angle that is written out."""


def holds_angles(exprs: Iterable[Any]) -> bool:
    """Whether one of some symengine expressions holds an atan2."""
    return bool(atoms(exprs, se.atan2))


@dataclass
class Angles:
    """Rewrites expressions on which ``relations`` vanish.

    ``positive`` are functions taken to be positive: the root of the square of one is itself.
    """

    relations: Sequence[Any] = ()
    positive: Sequence[Any] = ()
    _known: dict[Any, Any] = field(default_factory=dict)
    _roots: dict[Any, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for f in self.positive:
            self._roots[self._normal(f**2)] = f

    @remember("_known")
    def resolve(self, expr: Any) -> Any:
        """The expression without sines and cosines of atan2, with its radicands in normal form.

        An atan2 outside of a sine or cosine stays.
        """
        if not expr.args:
            return expr
        if isinstance(expr, se.sin | se.cos) and expr.atoms(se.atan2):
            sine, cosine = self._pair(expr.args[0])
            return sine if isinstance(expr, se.sin) else cosine
        arguments = [self.resolve(a) for a in expr.args]
        if isinstance(expr, se.Pow) and arguments[1].is_Rational and arguments[1].q == 2:
            return self._root(arguments[0]) ** arguments[1].p
        return expr if arguments == list(expr.args) else rebuild(expr, arguments)

    def _pair(self, angle: Any) -> tuple[Any, Any]:
        """Sine and cosine of a sum of angles."""
        terms = summands(angle)
        plain = [t for t in terms if not _multiple(t)]
        rest = se.Add(*plain)
        sine, cosine = se.sin(rest), se.cos(rest)
        if rest.atoms(se.atan2):  # inside of something else: nothing is known of it
            rest = se.Add(*map(self.resolve, plain))
            sine, cosine = se.sin(rest), se.cos(rest)
        for times, inner in filter(None, map(_multiple, terms)):
            y, x = map(self.resolve, inner.args)
            h = self._root(x**2 + y**2)
            a, b = (y / h if times > 0 else -y / h), x / h
            for _ in range(abs(times)):
                sine, cosine = sine * b + cosine * a, cosine * b - sine * a
        return sine, cosine

    def _root(self, radicand: Any) -> Any:
        """The positive root, one object for equal radicands."""
        key = self._normal(radicand)
        if key not in self._roots:
            self._roots[key] = se.sqrt(key)
        return self._roots[key]

    def _normal(self, expr: Any) -> Any:
        return canonical([expr], self.relations)[0]


def _multiple(term: Any) -> tuple[int, Any] | None:
    """n and the atan2, of a small multiple n atan2(y, x)."""
    if isinstance(term, se.atan2):
        return 1, term
    if isinstance(term, se.Mul) and len(term.args) == 2:
        factor, inner = term.args
        small = isinstance(factor, se.Integer) and abs(int(factor)) <= MOST
        if small and isinstance(inner, se.atan2):
            return int(factor), inner
    return None
