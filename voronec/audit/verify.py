"""One formula against what is derived: values on both sides, and an exact comparison."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import sympy as sp

from voronec.algebra.symbols import time
from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.audit.meaning import evaluate
from voronec.audit.nodes import Chain, Integral
from voronec.audit.paper import Check
from voronec.audit.structure import integrand, names_constant, new_names, whole_name
from voronec.audit.study import Study
from voronec.audit.transcript import assignments
from voronec.errors import DefinitionError

__all__ = ["Finding", "comparisons", "verify"]


@dataclass(frozen=True)
class Comparison:
    """Two values that a formula claims to be equal, and for which indices.

    ``dots`` are the accelerations, for an equation that may bear a factor.
    """

    left: Any
    right: Any
    where: dict[str, int]
    about: str = ""
    dots: tuple[Any, ...] = ()


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
    left, right = comparison.left, comparison.right
    verdict = prove_equal(left, right)
    if verdict.proved or check.truth is None:
        return verdict
    if prove_equal(-left, right).proved or _proportional(left, right, comparison.dots):
        return Verdict("proved", "zero in exact normal form")
    return verdict


def _proportional(left: Any, right: Any, dots: tuple[Any, ...]) -> bool:
    """Whether two equations, linear in the accelerations, differ by a factor that is not zero."""
    for dot in dots:
        a, b = sp.diff(left, dot), sp.diff(right, dot)
        if b != 0 and prove_equal(a, 0).refuted:
            return prove_equal(left * b, right * a).proved
    return False


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
    for left, right in pairwise(values):
        yield from _componentwise(left, right, where)
    if len(spoken) < len(chain.parts):
        if not values:
            raise DefinitionError("nothing is said of the constant")
        rate = study.motion.along(study.motion.derivative(values[0]))
        rate = rate.xreplace(dict(study.given))
        yield from _componentwise(rate, rate * 0, where, "derivative along the motion")


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
    truth = check.truth(study, where) if check.truth else sp.Integer(0)
    truth = truth.xreplace(dict(study.given))
    about = "left side minus right side"
    return Comparison(left - right, truth, where, about, accelerations(study))


def accelerations(study: Study) -> tuple[Any, ...]:
    """The symbols of accelerations: rates of velocities, which have no rate themselves."""
    rates = study.motion.rates
    return tuple(d for d in rates.values() if d.is_Symbol and d not in rates)


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
    value = study.motion.restrict(evaluate(body, study, where))
    free = [d for d in study.variations.values() if d in study.motion.rates]
    for position, variation in enumerate(free):
        rate = study.motion.rates[variation]
        euler = sp.diff(value, variation) - study.motion.derivative(sp.diff(value, rate))
        number = {**where, "i": position + 1}
        about = "coefficient of the variation"
        yield Comparison(euler, check.truth(study, number), number, about, accelerations(study))
