"""One formula against what is derived: values on both sides, and an exact comparison."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import sympy as sp

from voronec.algebra.signs import prove_inequality
from voronec.algebra.symbols import time
from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.audit.latex.nodes import Chain, Integral, Number
from voronec.audit.meaning import evaluate, rate
from voronec.audit.paper import Check
from voronec.audit.structure import integrand, names_constant, new_names, whole_name
from voronec.audit.study import Range, Study
from voronec.audit.transcript import assignments
from voronec.errors import DefinitionError

__all__ = ["Finding", "by_range", "comparisons", "verify"]


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
    """The outcome for a whole formula; ``comparison`` is the one that decided it.

    ``ranges`` are the outcomes by ranges of the parameters, where that matters; the first range is
    the one that the paper has in mind, and ``verdict`` speaks of it.
    """

    verdict: Verdict
    comparison: Comparison | None = None
    count: int = 0
    ranges: tuple[tuple[Range, Verdict], ...] = ()

    @property
    def partial(self) -> bool:
        """Whether it is proved in the paper's own range, but not in every range."""
        return self.verdict.proved and not all(v.proved for _, v in self.ranges)


def verify(chain: Chain, check: Check, study: Study) -> Finding:
    """Compare a formula for all values of its free indices; the first failure decides."""
    if check.decide is not None:
        decide = check.decide
        return by_range(study, check.within, lambda where: decide(study, where))
    unsaid = _unsaid(chain) if check.stationary else ""
    if unsaid:
        return Finding(Verdict("refuted", unsaid))
    finding = _compared(chain, check, study)
    gaps = list(_inequalities(chain, study))
    if not gaps or not finding.verdict.proved:
        return finding
    ordered = by_range(study, check.within, lambda where: _ordered(gaps, where))
    return ordered if finding.count == 0 else replace(ordered, count=finding.count + len(gaps))


def by_range(study: Study, within: Sequence[str], decide: Callable[[Range], Verdict]) -> Finding:
    """The outcome of a decision for each range of the parameters."""
    ranges = [r for r in study.ranges if not within or r.name in within] or [Range()]
    outcomes = tuple((r, decide(r)) for r in ranges)
    return Finding(outcomes[0][1], None, 1, outcomes if study.ranges else ())


def _compared(chain: Chain, check: Check, study: Study) -> Finding:
    count = 0
    doubt: Finding | None = None
    for comparison in comparisons(chain, check, study):
        count += 1
        verdict = _equal(comparison, check, study)
        if verdict.refuted:
            return Finding(verdict, comparison, count)
        if verdict.undecided:
            doubt = doubt or Finding(verdict, comparison, count)
    if doubt is not None:
        return doubt
    if count == 0:
        return Finding(Verdict("proved", "nothing is claimed beyond the definition"))
    return Finding(Verdict("proved", "zero in exact normal form"), None, count)


def _ordered(gaps: Sequence[tuple[Any, str, Any]], where: Range) -> Verdict:
    """Whether all inequalities hold in a range; the first that does not decides."""
    found = []
    for left, relation, right in gaps:
        a, b = (sp.sympify(side).xreplace(dict(where.values)) for side in (left, right))
        found.append(prove_inequality(a, relation, b, where.positive, where.real))
        if not found[-1].proved:
            return found[-1]
    return found[0]


def _equal(comparison: Comparison, check: Check, study: Study) -> Verdict:
    left, right = comparison.left, comparison.right
    verdict = prove_equal(left, right, study.relations)
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
        elif check.value is not None:
            derived = study.motion.restrict(check.value(study, where)).xreplace(dict(study.given))
            yield from _componentwise(_value(chain.parts[0], study, where), derived, where)
        else:
            yield from _identities(chain, study, where)


def _value(node: Any, study: Study, where: dict[str, int]) -> Any:
    value = study.motion.restrict(evaluate(node, study, where))
    return value.xreplace(dict(study.given)) if study.given else value


def _identities(chain: Chain, study: Study, where: dict[str, int]) -> Iterator[Comparison]:
    """Neighbouring parts must be equal; a part that is "const" must not change in time."""
    for group in _equalities(chain):
        yield from _equal_parts(group, study, where)


def _equal_parts(chain: Chain, study: Study, where: dict[str, int]) -> Iterator[Comparison]:
    if any(isinstance(p, Integral) and p.upper is None for p in chain.parts):
        rates = [rate(p, study, where) for p in chain.parts]
        for left, right in pairwise(rates):
            yield from _componentwise(left, right, where, "derivative along the motion")
        return
    new = new_names(chain, study)
    spoken = [p for p in chain.parts if not names_constant(p)]
    known = [p for p in spoken if whole_name(p, study) not in new]
    # What is claimed of accelerations is claimed along the motion.
    values = [study.motion.along(_value(p, study, where)) for p in known]
    # What is on the left is most often the quantity, and what is on the right its printed value.
    for left, right in pairwise(values):
        yield from _componentwise(right, left, where)
    if len(spoken) < len(chain.parts):
        if not values:
            raise DefinitionError("nothing is said of the constant")
        change = study.motion.along(study.motion.derivative(values[0]))
        change = change.xreplace(dict(study.given))
        yield from _componentwise(change * 0, change, where, "derivative along the motion")


def _equalities(chain: Chain) -> list[Chain]:
    """The stretches of a chain such as a > b = c in which the relation is equality."""
    groups = [[chain.parts[0]]]
    for relation, part in zip(chain.relations, chain.parts[1:], strict=True):
        if relation == "=":
            groups[-1].append(part)
        else:
            groups.append([part])
    return [Chain(tuple(g), ("=",) * (len(g) - 1), chain.at) for g in groups if len(g) > 1]


ORDER = {"\\le": "<=", "\\leq": "<=", "\\ge": ">=", "\\geq": ">=", "\\ne": "!=", "\\neq": "!="}


def _inequalities(chain: Chain, study: Study) -> Iterator[tuple[Any, str, Any]]:
    """The pairs of neighbouring parts between which an inequality stands."""
    for (left, right), relation in zip(pairwise(chain.parts), chain.relations, strict=True):
        if relation != "=":
            sides = (_value(part, study, {}) for part in (left, right))
            yield next(sides), ORDER.get(relation, relation), next(sides)


def _only_equalities(chain: Chain) -> None:
    for relation in chain.relations:
        if relation != "=":
            raise DefinitionError(
                f"the relation '{relation}' cannot stand in an equation of motion"
            )


def _componentwise(
    left: Any, right: Any, where: dict[str, int], about: str = ""
) -> Iterator[Comparison]:
    left, right = _as_vectors(left, right)
    if isinstance(left, sp.MatrixBase) != isinstance(right, sp.MatrixBase):
        raise DefinitionError("a vector is set equal to a number")
    if not isinstance(left, sp.MatrixBase):
        yield Comparison(left, right, where, about)
        return
    for position, (a, b) in enumerate(zip(left, right, strict=True)):
        yield Comparison(a, b, where, f"component {position + 1} {about}".strip())


def _as_vectors(left: Any, right: Any) -> tuple[Any, Any]:
    """The number zero stands for the zero vector too."""
    if isinstance(left, sp.MatrixBase) and right == 0:
        return left, left * 0
    if isinstance(right, sp.MatrixBase) and left == 0:
        return right * 0, right
    return left, right


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


def _unsaid(chain: Chain) -> str:
    """What an integral principle fails to say before any value is compared."""
    integral = next((p for p in chain.parts if isinstance(p, Integral)), None)
    if integral is None:
        return "no integral is printed"
    if not (len(chain.parts) == 2 and chain.relations == ("=",) and Number("0") in chain.parts):
        return "the integral is not set equal to zero"
    variable, _ = integrand(integral)
    if integral.upper == variable:
        return "the upper limit is the variable of integration, not a fixed moment"
    return ""


def _stationary(
    chain: Chain, check: Check, study: Study, where: dict[str, int]
) -> Iterator[Comparison]:
    """Integration by parts: the coefficient of each independent variation must be the truth."""
    integral = next(p for p in chain.parts if isinstance(p, Integral))
    if check.truth is None:
        raise DefinitionError("a stationary principle needs a truth")
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
