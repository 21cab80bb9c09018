"""Conditions beside relations: what parameters must meet, 0 < m, and where such points lie.

Hypotheses are symengine expressions that vanish, and symengine's Booleans, which hold.  Signs that
are declared, ranges, and what SymPy knows of its symbols come in here as Booleans, and are carried
along with the relations to all that decides: to normal forms, and to points.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import flint
import symengine as se
import sympy as sp
from symengine.lib.symengine_wrapper import Boolean, BooleanAtom, Relational

from voronec.algebra.tape import Tape
from voronec.errors import DefinitionError


def split_hypotheses(hypotheses: Iterable[Any]) -> tuple[list[Any], list[Any]]:
    """The expressions that vanish, and the conditions that hold; a = b says that a - b vanishes,
    unless it says that a number is whole."""
    equations: list[Any] = []
    conditions: list[Any] = []
    for entry in _each(hypotheses):
        if not isinstance(entry, Boolean):
            equations.append(entry)
        elif isinstance(entry, se.Equality) and not entry.atoms(se.floor):
            equations.append(entry.args[0] - entry.args[1])
        else:
            conditions.append(entry)
    return equations, conditions


def condition(given: Any, inward: Any) -> Any:
    """A relation of SymPy's, or several joined, as one Boolean; ``inward`` takes in its sides."""
    if given in (sp.true, sp.false):
        return se.sympify(bool(given))
    kind = _COMPARISONS.get(type(given))
    if kind is not None:
        return kind(inward(given.lhs), inward(given.rhs))
    joined = _CONNECTIVES.get(type(given))
    if joined is not None:
        return joined(*[condition(part, inward) for part in given.args])
    plain = given.to_nnf() if hasattr(given, "to_nnf") else given
    if plain == given:
        raise DefinitionError(
            f"the condition '{given}' is not made of comparisons; use <, <=, >, >=, Eq, Ne with "
            "&, | and ~"
        )
    return condition(plain, inward)


_COMPARISONS: dict[Any, Any] = {
    sp.StrictGreaterThan: lambda a, b: a > b,
    sp.StrictLessThan: lambda a, b: a < b,
    sp.GreaterThan: lambda a, b: a >= b,
    sp.LessThan: lambda a, b: a <= b,
    sp.Equality: se.Eq,
    sp.Unequality: se.Ne,
}
_CONNECTIVES: dict[Any, Any] = {sp.And: se.And, sp.Or: se.Or, sp.Not: se.Not}


def substituted_conditions(conditions: Iterable[Any], at: Mapping[Any, Any]) -> tuple[Any, ...]:
    """Conditions with symbols replaced, less those that this decides."""
    moved = (c.xreplace(dict(at)) for c in conditions)
    return tuple(c for c in moved if not isinstance(c, BooleanAtom))


def moved_hypotheses(hypotheses: Iterable[Any], at: Mapping[Any, Any]) -> tuple[Any, ...]:
    """Relations and conditions with symbols replaced."""
    equations, conditions = split_hypotheses(hypotheses)
    moved = (e.xreplace(dict(at)) for e in equations)
    return (*moved, *substituted_conditions(conditions, at))


@dataclass(frozen=True)
class _Range:
    """Where a symbol may lie: between bounds, and at whole numbers after scale*x + shift."""

    lower: Any = None
    upper: Any = None
    whole: tuple[Any, Any] | None = None

    def both(self, other: _Range) -> _Range:
        """What meets the one and the other."""
        lowers = [b for b in (self.lower, other.lower) if b is not None]
        uppers = [b for b in (self.upper, other.upper) if b is not None]
        return _Range(
            max(lowers, default=None), min(uppers, default=None), other.whole or self.whole
        )

    def clip(self, value: Any) -> Any:
        """A number that was drawn, brought into the range."""
        if self.whole is None:
            return self._between(value)
        scale, shift = self.whole
        near = (round(float(flint.arb(scale * self._between(4 * value) + shift))) - shift) / scale
        if self.lower is not None and near <= self.lower:
            return near + abs(1 / scale)
        return near - abs(1 / scale) if self.upper is not None and near >= self.upper else near

    def _between(self, value: Any) -> Any:
        lower, upper, size = self.lower, self.upper, abs(value)
        if (lower is None or lower < value) and (upper is None or value < upper):
            return value
        if lower is not None and upper is not None:
            return lower + (upper - lower) * size / (1 + size)
        return upper - size if lower is None else lower + size


@dataclass(frozen=True)
class Domain:
    """The points at which conditions hold: drawn numbers are moved there, and points judged."""

    conditions: tuple[Any, ...]

    def linked_symbols(self, atoms: Sequence[Any]) -> list[Any]:
        """Further symbols that conditions tie to given ones."""
        linked, waiting = dict.fromkeys(atoms), [atoms for _, atoms in self._ties]
        while touched := [
            s for s in waiting if not s.isdisjoint(linked) and not s <= linked.keys()
        ]:
            for symbols in touched:
                linked.update(dict.fromkeys(sorted(symbols, key=str)))
        return [*linked][len(atoms) :]

    def clip(self, point: Mapping[Any, Any]) -> dict[Any, Any]:
        """A drawn point, each number of it brought into the range of its symbol."""
        ranges = self._ranges
        return {
            a: ranges[a].clip(v) if a in ranges and isinstance(v, flint.fmpq) else v
            for a, v in point.items()
        }

    def admits(self, point: Mapping[Any, Any], bits: int) -> bool:
        """Whether all conditions on the atoms of a point are sure to hold there."""
        known = (c for c, atoms in self._ties if atoms <= point.keys())
        return all(_holds(c, self._sides, point, bits) is True for c in known)

    @cached_property
    def _ranges(self) -> dict[Any, _Range]:
        ranges: dict[Any, _Range] = {}
        for one in _each(self.conditions):
            symbol, limits = _range_of(one) or (None, None)
            if symbol is not None and limits is not None:
                ranges[symbol] = limits.both(ranges[symbol]) if symbol in ranges else limits
        return ranges

    @cached_property
    def _ties(self) -> list[tuple[Any, set[Any]]]:
        """Each condition with the atoms that it ties."""
        return [(c, _atoms(c)) for c in _each(self.conditions)]

    @cached_property
    def _sides(self) -> dict[Any, Tape]:
        """The two sides of comparisons, as they are asked for."""
        return {}


@lru_cache(maxsize=256)
def domain_of(conditions: tuple[Any, ...]) -> Domain:
    """Where conditions hold; what was made ready for the same ones is used again."""
    return Domain(conditions)


def _each(conditions: Iterable[Any]) -> Iterator[Any]:
    """Conditions, those joined by "and" one by one."""
    for one in conditions:
        if isinstance(one, se.And):
            yield from _each(one.args)
        else:
            yield one


def comparisons(hypotheses: Iterable[Any]) -> Iterator[tuple[Any, bool]]:
    """(expression, strict) for each hypothesis that says that an expression is positive, or not
    negative."""
    for one in _each(split_hypotheses(hypotheses)[1]):
        if isinstance(one, se.StrictLessThan | se.LessThan):
            yield one.args[1] - one.args[0], isinstance(one, se.StrictLessThan)


def _atoms(one: Any) -> set[Any]:
    return {a for side in _sides_of(one) for a in Tape([side]).atoms}


def _sides_of(one: Any) -> Iterator[Any]:
    for part in one.args:
        if isinstance(part, Boolean):
            yield from _sides_of(part)
        else:
            yield part


def _holds(one: Any, tapes: dict[Any, Tape], point: Mapping[Any, Any], bits: int) -> bool | None:
    """Whether a condition holds at a point; None where balls do not tell."""
    if isinstance(one, BooleanAtom):
        return bool(one)
    if isinstance(one, se.And | se.Or):
        parts = [_holds(part, tapes, point, bits) for part in one.args]
        settled = isinstance(one, se.Or)
        return settled if settled in parts else None if None in parts else not settled
    if one not in tapes:
        tapes[one] = Tape(one.args)
    left, right = tapes[one].arb(point, bits)
    if isinstance(one, se.StrictLessThan):
        return _decide(left < right, left >= right)
    if isinstance(one, se.LessThan):
        return _decide(left <= right, left > right)
    same = _decide(bool(left.is_exact() and left == right), not left.overlaps(right))
    return same if isinstance(one, se.Equality) or same is None else not same


def _decide(yes: Any, no: Any) -> bool | None:
    return True if yes else False if no else None


def _range_of(one: Any) -> tuple[Any, _Range] | None:
    """The atom that a condition bounds by numbers, and how; None for any other condition."""
    atoms = _atoms(one)
    if len(atoms) != 1 or not isinstance(one, Relational):
        return None
    (atom,) = atoms
    left, right = one.args
    if isinstance(one, se.Equality):
        inner = left.args[0] if isinstance(left, se.floor) else right.args[0] if right.args else 0
        line = _line(inner, atom) if {left, right} == {inner, se.floor(inner)} else None
        return None if line is None else (atom, _Range(whole=line))
    line = _line(right - left, atom)
    if line is None or not isinstance(one, se.StrictLessThan | se.LessThan):
        return None
    slope, rest = line
    return atom, _Range(lower=-rest / slope) if slope > 0 else _Range(upper=-rest / slope)


def _line(expr: Any, atom: Any) -> tuple[Any, Any] | None:
    """a and b of a*atom + b, rational numbers with a not zero."""
    bare = se.Symbol("bounded quantity")
    line = se.expand(expr.xreplace({atom: bare}))
    slope = line.diff(bare)
    if slope.free_symbols:  # no line, and maybe without a value at zero, as atan(1/x)
        return None
    rest = line.xreplace({bare: se.Integer(0)})
    if not all(isinstance(x, se.Rational) for x in (slope, rest)) or slope == 0:
        return None
    return as_rational(slope), as_rational(rest)


def as_rational(number: Any) -> Any:
    """A rational number of symengine's in flint's."""
    return flint.fmpq(int(number.p), int(number.q))
