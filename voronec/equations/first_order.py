"""Expressions to first order about a point: value and slopes together, node by node.

    f(x0 + dx) = f(x0) + df/dx dx

At a point most of what a derivation writes is zero or a number, so that no derivative of the whole
is ever written out.  Values are symengine expressions in what the point leaves open.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import symengine as se

from voronec.algebra.graphs import is_atom, is_flat
from voronec.errors import EngineLimit

__all__ = ["FirstOrder", "expand"]

FirstOrder = tuple[Any, dict[int, Any]]
"""The value, and the slopes along the variables by their positions where they do not vanish."""

_NOT_FINITE = (se.zoo, se.nan, se.oo)


def expand(
    exprs: Sequence[Any], variables: Sequence[Any], point: Mapping[Any, Any]
) -> list[FirstOrder]:
    """Each expression to first order in the variables, at a point {atom: expression}.

    Raises ``EngineLimit`` where an expression has no finite value there.
    """
    known: dict[Any, FirstOrder] = {}
    for k, x in enumerate(variables):
        known[x] = (point.get(x, x), {k: se.Integer(1)})
    return [_expand(se.sympify(e), known, point) for e in exprs]


def _expand(expr: Any, known: dict[Any, FirstOrder], point: Mapping[Any, Any]) -> FirstOrder:
    found = known.get(expr)
    if found is None:
        found = known[expr] = _first_order(expr, known, point)
        if any(part in _NOT_FINITE for part in (found[0], *found[0].args)):
            raise EngineLimit(f"'{expr}' has no finite value at the point")
    return found


def _first_order(expr: Any, known: dict[Any, FirstOrder], point: Mapping[Any, Any]) -> FirstOrder:
    if is_atom(expr):
        return point.get(expr, expr), {}
    if is_flat(expr) or not expr.args:
        return (se.Integer(0) if is_flat(expr) else expr), {}
    parts = [_expand(a, known, point) for a in expr.args]
    if isinstance(expr, se.Add):
        return se.Add(*[v for v, _ in parts]), _sums([(se.Integer(1), s) for _, s in parts])
    if isinstance(expr, se.Mul):
        return _product(parts)
    values = [v for v, _ in parts]
    value = expr.func(*values)
    root = isinstance(expr, se.Pow) and values[0] == 0 and values[1].is_Number and values[1] < 1
    if root and any(known[s][1] for s in expr.args[0].free_symbols if s in known):
        raise EngineLimit(f"'{expr}' has a corner there")
    moving = [i for i, (_, slopes) in enumerate(parts) if slopes]
    if not moving:
        return value, {}
    if (corner := _corner(expr, values)) is not None:
        return value, _sums([(slope, parts[i][1]) for i, slope in corner.items()])
    names = [se.Symbol(f"argument {i}") for i in range(len(parts))]
    form, at = expr.func(*names), dict(zip(names, values, strict=True))
    if isinstance(expr, se.Pow) and moving == [0]:
        form = names[0] ** values[1]
    return value, _sums([(form.diff(names[i]).xreplace(at), parts[i][1]) for i in moving])


def _corner(expr: Any, values: Sequence[Any]) -> dict[int, Any] | None:
    """The slopes of a function with corners or steps by its arguments, where these are numbers;
    None for all else.  ``EngineLimit`` at a corner, where there are no slopes."""
    kinds = (se.sign, se.Abs, se.floor, se.ceiling, se.Max, se.Min)
    if not isinstance(expr, kinds) or any(v.free_symbols for v in values):
        return None
    sizes = [float(v) for v in values]
    if isinstance(expr, se.Max | se.Min):
        best = (max if isinstance(expr, se.Max) else min)(sizes)
        at = [i for i, size in enumerate(sizes) if size == best]
        slopes, on_corner = {at[0]: se.Integer(1)}, len(at) > 1
    elif isinstance(expr, se.floor | se.ceiling):
        slopes, on_corner = {}, sizes[0].is_integer()
    else:
        slopes = {0: se.sign(values[0])} if isinstance(expr, se.Abs) else {}
        on_corner = sizes[0] == 0
    if on_corner:
        raise EngineLimit(f"'{expr}' has a corner or a step there")
    return slopes


def _product(parts: Sequence[FirstOrder]) -> FirstOrder:
    total: FirstOrder = (se.Integer(1), {})
    for value, slopes in parts:
        total = total[0] * value, _sums([(value, total[1]), (total[0], slopes)])
    return total


def _sums(pairs: Sequence[tuple[Any, Mapping[int, Any]]]) -> dict[int, Any]:
    """Slopes with factors, added up."""
    found: dict[int, list[Any]] = {}
    for factor, slopes in pairs:
        if factor != 0:
            for k, slope in slopes.items():
                found.setdefault(k, []).append(factor * slope)
    sums = {k: se.Add(*terms) for k, terms in found.items()}
    return {k: total for k, total in sums.items() if total != 0}
