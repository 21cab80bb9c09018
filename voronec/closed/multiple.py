"""Multiple roots: a polynomial as a product of squarefree ones, decided exactly.

The discriminant tells whether there is a multiple root; the subresultants of the polynomial and its
slope tell the greatest common divisor of the two, whose roots are the multiple ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.closed.arithmetic import Function, ball, compiled

if TYPE_CHECKING:
    from voronec.closed.problem import Problem

__all__ = ["squarefree"]

Factors = tuple[tuple[tuple[Any, ...], int], ...]


@cache
def _symbols(degree: int) -> tuple[Any, ...]:
    return sp.symbols(f"c0:{degree + 1}")


@cache
def _chain(degree: int) -> dict[int, tuple[Any, ...]]:
    """Subresultants of a polynomial and its slope by their degrees, coefficients ascending."""
    x, names = sp.Symbol("x"), _symbols(degree)
    poly = sum(c * x**i for i, c in enumerate(names))
    found = {}
    for e in sp.subresultants(poly, sp.diff(poly, x), x)[2:]:
        p = sp.Poly(e, x)
        found[p.degree()] = tuple(p.coeff_monomial(x**i) for i in range(p.degree() + 1))
    return found


@cache
def _balls(degree: int, of: int) -> Function:
    return compiled(_chain(degree)[of], _symbols(degree))


def squarefree(problem: Problem, values: Sequence[Any]) -> Factors:
    """Factors of the quartic with their multiplicities, from its coefficients as balls.

    Coefficients ascend; the last of each is not zero.  A constant factor stands alone; there are
    none where everything vanishes.
    """
    symbols = problem.prepared.quartic
    degree = len(values) - 1
    while degree and values[degree].contains(0) and not _nonzero(problem, symbols[degree]):
        degree -= 1
    own = list(values[: degree + 1])
    if degree < 2:
        if degree == 0 and not _nonzero(problem, symbols[0]):
            return ()
        return ((tuple(own), 1),)
    meaning = dict(zip(_symbols(degree), symbols, strict=False))
    if not _balls(degree, 0)(own)[0].contains(0):
        return ((tuple(own), 1),)
    common = 0
    while common < degree - 1 and not _nonzero(
        problem, _chain(degree)[common][-1].xreplace(meaning)
    ):
        common += 1
    if common == 0:
        return ((tuple(own), 1),)
    if common == degree - 1:
        root = -own[-2] / (degree * own[-1])
        return _with_constant(((-root, ball(1)), degree), own[-1:])
    shared = _balls(degree, common)(own)
    if common == 2:
        a, b, c = (e.xreplace(meaning) for e in _chain(degree)[2])
        if _nonzero(problem, b**2 - 4 * a * c):
            square = tuple(e / shared[2] for e in shared)
            return _with_constant((square, 2), own[-1:])
        shared = [shared[1], 2 * shared[2]]
    root, times = -shared[0] / shared[1], common + 1
    rest = own
    for _ in range(times):
        rest = _without(rest, root)
    return _with_constant(((-root, ball(1)), times), rest)


def _with_constant(factor: tuple[tuple[Any, ...], int], rest: Sequence[Any]) -> Factors:
    return (factor, (tuple(rest), 1))


def _without(poly: Sequence[Any], root: Any) -> list[Any]:
    """The quotient by x - root."""
    found = [poly[-1]]
    for c in reversed(poly[1:-1]):
        found.append(c + root * found[-1])
    return found[::-1]


def _nonzero(problem: Problem, expr: Any) -> bool:
    return problem.sign(expr) != 0
