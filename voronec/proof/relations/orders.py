"""Whether something vanishes, exactly or as a small parameter tends to zero."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import symengine as se

from voronec.algebra.conditions import split_hypotheses
from voronec.algebra.normal import quotient
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.errors import EngineLimit
from voronec.proof.relations.functions import Infinite, substitute


def vanishes(expr: Any, relations: Sequence[Any], small: Any = None, order: int = 1) -> Verdict:
    """Whether an expression is zero; with a small parameter, whether it is O(small^order).

    The expression is written as a quotient without common factors.  Where its denominator does not
    vanish with the small parameter, and both are smooth there, the Taylor coefficients of the
    numerator are decided one by one.  Where relations hold the small parameter, a coefficient is
    refuted only on their zero set at the limit.
    """
    equations, _ = split_hypotheses(relations)
    bound = small is not None and any(small in r.free_symbols for r in equations)
    if small is None or not (bound or small in expr.free_symbols):
        return decide_zero(expr, relations)
    try:
        there = all_at_zero(relations, small)
        above, below = quotient(expr, equations)
        pole = decide_zero(_put(below, small, there), there)
        is_rough = any(small in f.free_symbols for f in above.atoms(se.Function))
        for _ in range(order):
            value = _put(above, small, there)
            if pole.proved and not bound and decide_zero(value, relations).refuted:
                return Verdict("refuted", f"it has a pole where '{small}' vanishes")
            if not pole.refuted:
                raise EngineLimit(f"the denominator vanishes with '{small}'")
            verdict = decide_zero(value, relations)
            if bound and not verdict.proved:
                verdict = _at_limit(decide_zero(value, there), order)
            if not verdict.proved:
                return verdict
            above = above.diff(small)
        if is_rough:
            _put(above, small, there)  # smooth enough for the last term
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))
    return Verdict("proved", f"zero in exact normal form up to terms of order {order} in '{small}'")


def _at_limit(verdict: Verdict, order: int) -> Verdict:
    """What follows where a coefficient vanishes, or not, on the relations at the limit.

    There it differs from its values near by on them by terms of first order.
    """
    if verdict.proved and order > 1:
        return Verdict("undecided", "a coefficient vanishes on the relations at the limit only")
    return verdict


def at_zero(expr: Any, relations: Sequence[Any], small: Any) -> Any:
    """The value of an expression where the small parameter vanishes; ``EngineLimit`` at a pole.

    Where no denominator in it vanishes, nor what stands under a root, it is continuous there and
    the value is put in; else common factors are cancelled first.
    """
    if small is None or small not in expr.free_symbols:
        return expr
    there = all_at_zero(relations, small)
    try:
        return _put(expr, small, there)
    except Infinite:
        above, below = (
            _put(part, small, there) for part in quotient(expr, split_hypotheses(relations)[0])
        )
        if not decide_zero(below, there).refuted:
            raise Infinite(f"'{expr}' has no limit where '{small}' vanishes") from None
        return above / below


def all_at_zero(hypotheses: Sequence[Any], small: Any) -> tuple[Any, ...]:
    """Relations where the small parameter vanishes, and the conditions that do not hold it."""
    equations, conditions = split_hypotheses(hypotheses)
    there = [_put(e, small, hypotheses) if small in e.free_symbols else e for e in equations]
    return (*there, *(c for c in conditions if small not in c.free_symbols))


def _put(expr: Any, small: Any, relations: Sequence[Any]) -> Any:
    """An expression at zero, where it is proved to be smooth."""

    def check(base: Any) -> None:
        if not decide_zero(base, relations).refuted:
            raise Infinite(f"a denominator or a radicand vanishes with '{small}'")

    return substitute(expr, {small: se.Integer(0)}, check)
