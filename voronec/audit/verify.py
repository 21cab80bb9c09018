"""One formula against what is derived: values on both sides, and an exact comparison."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import time
from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.audit.meaning import (
    definitions_in,
    evaluate,
    integrand,
    names_constant,
    whole_name,
)
from voronec.audit.nodes import Chain, Integral
from voronec.audit.paper import Check
from voronec.audit.study import Study
from voronec.audit.transcript import assignments
from voronec.errors import DefinitionError

__all__ = ["Finding", "comparisons", "new_names", "verify"]


@dataclass(frozen=True)
class Comparison:
    """Two values that a formula claims to be equal, and for which indices."""

    left: Any
    right: Any
    where: dict[str, int]
    about: str = ""


@dataclass(frozen=True)
class Finding:
    """The outcome for a whole formula; ``comparison`` is the one that decided it."""

    verdict: Verdict
    comparison: Comparison | None = None
    count: int = 0


def verify(chain: Chain, check: Check, study: Study) -> Finding:
    """Compare a formula for all values of its free indices; the first failure decides."""
    count = 0
    doubt: Finding | None = None
    for comparison in comparisons(chain, check, study):
        count += 1
        verdict = _equal(comparison, check)
        if verdict.refuted:
            return Finding(verdict, comparison, count)
        if verdict.undecided:
            doubt = doubt or Finding(verdict, comparison, count)
    if doubt is not None:
        return doubt
    if count == 0:
        return Finding(Verdict("proved", "nothing is claimed beyond the definition"))
    return Finding(Verdict("proved", "zero in exact normal form"), None, count)


def _equal(comparison: Comparison, check: Check) -> Verdict:
    verdict = prove_equal(comparison.left, comparison.right)
    if verdict.proved or check.truth is None:
        return verdict
    negative = prove_equal(-comparison.left, comparison.right)
    return negative if negative.proved else verdict


def comparisons(chain: Chain, check: Check, study: Study) -> Iterator[Comparison]:
    """The values to be compared, one pair at a time."""
    for where in assignments(chain, study):
        if check.stationary:
            yield from _stationary(chain, check, study, where)
        elif check.truth is not None:
            yield _equation(chain, check, study, where)
        else:
            yield from _identities(chain, study, where)


def _value(node: Any, study: Study, where: dict[str, int]) -> Any:
    value = study.motion.restrict(evaluate(node, study, where))
    return value.xreplace(dict(study.given)) if study.given else value


def _identities(chain: Chain, study: Study, where: dict[str, int]) -> Iterator[Comparison]:
    """Neighbouring parts must be equal; a part that is "const" must not change in time."""
    _only_equalities(chain)
    new = new_names(chain, study)
    spoken = [p for p in chain.parts if not names_constant(p)]
    known = [p for p in spoken if whole_name(p, study) not in new]
    values = [_value(p, study, where) for p in known]
    for left, right in zip(values, values[1:], strict=False):
        yield from _componentwise(left, right, where)
    if len(spoken) < len(chain.parts):
        rate = study.motion.along(study.motion.derivative(values[0]))
        rate = rate.xreplace(dict(study.given))
        yield from _componentwise(rate, rate * 0, where, "derivative along the motion")


def new_names(chain: Chain, study: Study) -> set[str]:
    """The names that this formula, and no earlier one, defines."""
    found = definitions_in(chain, study)
    return {key for key, node in found.items() if study.defined.get(key, node) == node}


def _only_equalities(chain: Chain) -> None:
    for relation in chain.relations:
        if relation != "=":
            raise DefinitionError(f"the relation '{relation}' is not decided by an identity")


def _componentwise(
    left: Any, right: Any, where: dict[str, int], about: str = ""
) -> Iterator[Comparison]:
    if isinstance(left, sp.MatrixBase) != isinstance(right, sp.MatrixBase):
        raise DefinitionError("a vector is set equal to a number")
    if not isinstance(left, sp.MatrixBase):
        yield Comparison(left, right, where, about)
        return
    for position, (a, b) in enumerate(zip(left, right, strict=True)):
        yield Comparison(a, b, where, f"component {position + 1} {about}".strip())


def _equation(chain: Chain, check: Check, study: Study, where: dict[str, int]) -> Comparison:
    _only_equalities(chain)
    left, right = (_value(part, study, where) for part in chain.parts)
    truth = check.truth(study, **_plain(where)) if check.truth else sp.Integer(0)
    return Comparison(left - right, truth, where)


def _plain(where: dict[str, int]) -> dict[str, int]:
    return {letter.lstrip("\\"): value for letter, value in where.items()}


def _stationary(
    chain: Chain, check: Check, study: Study, where: dict[str, int]
) -> Iterator[Comparison]:
    """Integration by parts: the coefficient of each independent variation must be the truth."""
    integral = next((p for p in chain.parts if isinstance(p, Integral)), None)
    if integral is None or check.truth is None:
        raise DefinitionError("a stationary principle needs an integral and a truth")
    variable, body = integrand(integral)
    if evaluate(variable, study, where) != time:
        raise DefinitionError("the integral of a principle runs over the time")
    value = sp.expand(study.motion.restrict(evaluate(body, study, where)))
    free = [d for q, d in study.variations.items() if q in study.motion.rates and d.is_Symbol]
    for position, variation in enumerate(x for x in free if x in study.motion.rates):
        rate = study.motion.rates[variation]
        euler = sp.diff(value, variation) - study.motion.derivative(sp.diff(value, rate))
        yield Comparison(euler, check.truth(study, i=position + 1), {**where, "i": position + 1})
