"""Whether something vanishes, exactly or as a small parameter tends to zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import symengine as se

from voronec.algebra.normal import quotient
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.errors import EngineLimit
from voronec.relations.substitution import Infinite, substituted

__all__ = ["at_zero", "vanishes"]


def vanishes(expr: Any, relations: Sequence[Any], small: Any = None, order: int = 1) -> Verdict:
    """Whether an expression is zero; with a small parameter, whether it is O(small^order).

    The expression is written as a quotient without common factors.  Where its denominator does not
    vanish with the small parameter, the Taylor coefficients of the numerator are decided one by
    one.
    """
    if small is None or small not in expr.free_symbols:
        return decide_zero(expr, relations)
    try:
        above, below = quotient(expr, relations)
        pole = decide_zero(_put(below, small, relations), relations)
        for _ in range(order):
            verdict = decide_zero(_put(above, small, relations), relations)
            if pole.proved and verdict.refuted:
                return Verdict("refuted", f"it has a pole where '{small}' vanishes")
            if not pole.refuted:
                raise EngineLimit(f"the denominator vanishes with '{small}'")
            if not verdict.proved:
                return verdict
            above = above.diff(small)
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))
    return Verdict("proved", f"zero in exact normal form up to terms of order {order} in '{small}'")


def at_zero(expr: Any, relations: Sequence[Any], small: Any) -> Any:
    """The value of an expression where the small parameter vanishes; ``EngineLimit`` at a pole.

    Where no denominator in it vanishes, it is continuous there and the value is put in; else
    common factors are cancelled first.
    """
    if small is None or small not in expr.free_symbols:
        return expr
    try:
        return _put(expr, small, relations)
    except Infinite:
        above, below = (_put(part, small, relations) for part in quotient(expr, relations))
        if not decide_zero(below, relations).refuted:
            raise Infinite(f"'{expr}' has no limit where '{small}' vanishes") from None
        return above / below


def _put(expr: Any, small: Any, relations: Sequence[Any]) -> Any:
    """An expression at zero, where every denominator in it is proved not to vanish."""

    def check(base: Any) -> None:
        if not decide_zero(base, relations).refuted:
            raise Infinite(f"a denominator vanishes with '{small}'")

    return substituted(expr, {small: se.Integer(0)}, check)
