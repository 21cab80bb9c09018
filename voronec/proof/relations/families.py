"""Limits at the end of a chain, carried back to its start.

A limit moves parameters of its source: p = s(h, parameters).  In a chain these are functions Q of
the parameters of the start.  A family of those belongs to it where Q_p = s_p and every other Q is
what it was; where none does, the chain has no meaning, as one that fixes p.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import prove_equal
from voronec.declaration.relation import Limit, Relation
from voronec.proof.relations.parameters import by_name

Values = Mapping[str, sp.Expr]


@dataclass(frozen=True)
class Course:
    """What a chain does to parameters: those of its end, in terms of those of its start.

    ``values`` are missing at the start; ``limits`` are the parameters of the start that the limits
    move, each with where it goes.
    """

    values: Values | None = None
    limits: Mapping[str, sp.Expr] = field(default_factory=dict)

    def through(self, relation: Relation) -> Course | None:
        """With one more relation; ``None`` where its limit moves what the chain has fixed."""
        known = {} if self.values is None else self.values
        given = {n: _plain(v) for n, v in by_name(relation.parameters).items()}
        here = {sp.Symbol(n): v for n, v in known.items()}
        limit, moved = relation.limit, dict(self.limits)
        if limit is None:
            return Course({n: v.xreplace(here) for n, v in given.items()}, moved)
        small = sp.Symbol(f"small {limit.small}")
        named = {sp.Symbol(str(limit.small)): small}
        scaled = {n: v.xreplace(named) for n, v in _scaled_parameters(limit).items()}
        family: Values | None = scaled
        if self.values is not None:
            family = carry_back(known, scaled, small)
        if family is None:
            return None
        moved |= {n: _at_zero(v, small) for n, v in family.items()}
        moving = {sp.Symbol(n): v for n, v in scaled.items()}
        values = {n: v.xreplace({**moving, **named}).xreplace(here) for n, v in given.items()}
        return Course({n: _at_zero(v, small) for n, v in values.items()}, moved)

    def is_compatible(self, other: Course) -> bool:
        """Whether the limits of both move no parameter to different values."""
        return all(other.limits.get(n, v) == v for n, v in self.limits.items())

    @classmethod
    def of(cls, relations: Iterable[Relation]) -> Course | None:
        """That of a whole chain."""
        course: Course | None = cls()
        for relation in relations:
            if course is not None:
                course = course.through(relation)
        return course


def _scaled_parameters(limit: Limit) -> dict[str, sp.Expr]:
    return {n: _plain(as_expression(v)) for n, v in by_name(limit.parameters).items()}


def _plain(expr: sp.Expr) -> sp.Expr:
    """An expression in symbols that are told by their names alone."""
    return expr.xreplace({s: sp.Symbol(str(s)) for s in expr.free_symbols})


def carry_back(
    values: Values, scaled: Values, small: sp.Symbol, known: Sequence[Any] = ()
) -> Values | None:
    """Parameters of the start, as functions of the small one, for which those of the end follow a
    limit; of several families, the first by name.  ``known`` are signs of those parameters.

    Where the end has a parameter at its limit already, nothing has to move.
    """
    here = {sp.Symbol(n): v for n, v in values.items()}
    wanted = dict(values)
    for name, scale in scaled.items():
        target = scale.xreplace(here)
        if name not in values:
            return None
        if not _equal(values[name], _at_zero(target, small), known):
            wanted[name] = target
    first = [*(n for n in values if n in scaled), *(n for n in values if n not in scaled)]
    return _solve_pairs([(values[n], wanted[n]) for n in first], {}, known)


def _solve_pairs(
    pairs: list[tuple[sp.Expr, sp.Expr]], found: dict[str, sp.Expr], known: Sequence[Any]
) -> Values | None:
    """Values of symbols that make all pairs equal."""
    moving = {sp.Symbol(n): v for n, v in found.items()}
    for value, wanted in pairs:
        if _equal(value.xreplace(moving), wanted, known):
            continue
        for name in sorted({s.name for s in value.free_symbols} - {*found}):
            root = _root(value.xreplace({**moving, sp.Symbol(name): UNKNOWN}), wanted)
            solution = None if root is None else _solve_pairs(pairs, {**found, name: root}, known)
            if solution is not None:
                return solution
        return None
    return found


UNKNOWN = sp.Dummy()
MEMORY = 4096
"""So many answers are remembered: chains have their relations in common, and ask the same."""


@lru_cache(MEMORY)
def _root(value: sp.Expr, wanted: sp.Expr) -> sp.Expr | None:
    """Where a quotient of two linear functions of the unknown takes a value, else ``None``."""
    above, below = sp.fraction(sp.together(value))
    equation = sp.expand(above - wanted * below)
    slope = equation.diff(UNKNOWN)
    if slope.has(UNKNOWN) or _equal(slope, sp.Integer(0), ()):
        return None
    return sp.cancel(-equation.xreplace({UNKNOWN: sp.Integer(0)}) / slope)


def _equal(left: sp.Expr, right: sp.Expr, known: Sequence[Any]) -> bool:
    if left.has(sp.zoo, sp.nan) or right.has(sp.zoo, sp.nan):
        return bool(left == right)
    return _is_proved(left, right, (*known,))


@lru_cache(MEMORY)
def _is_proved(left: sp.Expr, right: sp.Expr, known: tuple[Any, ...]) -> bool:
    return prove_equal(left, right, known).proved


@lru_cache(MEMORY)
def _at_zero(expr: sp.Expr, small: sp.Symbol) -> Any:
    """The value where the small parameter vanishes; ``zoo`` where it is infinite."""
    if small not in expr.free_symbols:
        return expr
    above, below = (e.subs(small, 0) for e in sp.fraction(sp.cancel(expr)))
    return sp.zoo if below == 0 else sp.cancel(above / below)
