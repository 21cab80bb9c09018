"""Whether parameters have, where a relation maps them, values that its target declares possible.

Proofs take for granted what is declared of the target: where it may fail, the verdict says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symengine.lib.symengine_wrapper import Boolean, BooleanAtom

from voronec.algebra.conditions import comparisons, split_hypotheses
from voronec.algebra.roots import known_sign
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.errors import quote
from voronec.proof.relations.statemap import StateMap


def possible_values(statemap: StateMap) -> Verdict:
    """Proved on the domain where parameters meet the conditions of the target; refuted where none
    does.

    Zero, where a sign ends, is a special case of the target, and allowed.  What moves in a limit
    is small, and has the sign that is wanted.
    """
    target, at = statemap.target, statemap.parameters
    known = (*statemap.relations, *statemap.source_conditions)
    conditions = [c for c in target.conditions if c.free_symbols <= at.keys()]
    domain = []
    for one in (part for group in split_hypotheses(conditions) for part in group):
        image = one.xreplace(at)
        if image in known or statemap.small in image.free_symbols:
            continue
        holds = _holds(one, at, known)
        if holds is False:
            words = f"'{target.system.name}' declares {_write(one, target)}; here it is"
            return Verdict("refuted", f"{words} {_write(image, statemap.source)}")
        if holds is None:
            domain.append(_write(image, statemap.source))
    return Verdict("proved", "zero in exact normal form", domain=", ".join(domain))


def _holds(one: Any, at: dict[Any, Any], known: Sequence[Any]) -> bool | None:
    """Whether a condition holds everywhere, or nowhere; None where neither is known."""
    image = one.xreplace(at)
    for expr, _ in comparisons([one]):
        value = expr.xreplace(at)
        if value == 0 or known_sign(value, known) > 0:
            return True
        return False if known_sign(value, known, strict=True) < 0 else None
    if isinstance(image, BooleanAtom):
        return bool(image)
    if isinstance(image, Boolean):
        return None
    if decide_zero(image, known).proved:
        return True
    return None if image.free_symbols else False


def _write(one: Any, field: Any) -> str:
    """A condition, or what vanishes, in words."""
    for expr, _ in comparisons([one]):
        return f"{quote(field.bridge.outward(expr))} > 0"
    return str(one) if isinstance(one, Boolean) else f"{quote(field.bridge.outward(one))} = 0"
