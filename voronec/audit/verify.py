"""One formula against what is derived: an exact answer, for each range of the parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import sympy as sp

from voronec.algebra.signs import prove_inequality
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.audit.comparisons import FormulaComparison, accelerations, comparisons, value_of
from voronec.audit.display import Check, Decision
from voronec.audit.hooks import HookError, call_hook
from voronec.audit.latex.nodes import Chain, Integral, Name, Number, walk
from voronec.audit.structure import bare_letter, integrand, says_nothing
from voronec.audit.study import Range, Study, key_of


@dataclass(frozen=True)
class FormulaOutcome:
    """The outcome for a whole formula; ``comparison`` is the one that decided it.

    ``ranges`` are the outcomes by ranges of the parameters, where that matters; the first range is
    the one that the paper has in mind, and ``verdict`` speaks of it.
    """

    verdict: Verdict
    comparison: FormulaComparison | None = None
    count: int = 0
    ranges: tuple[tuple[Range, Verdict], ...] = ()
    scope: tuple[str, ...] = ()

    @property
    def partial(self) -> bool:
        """Whether it is proved in the paper's own range, but not in every range that is meant."""
        meant = [v for r, v in self.ranges if not self.scope or r.name in self.scope]
        return self.verdict.proved and not all(v.proved for v in meant)


NOTHING = Verdict("undecided", "it claims nothing; give it a relation, or its check a value")
EMPTY = Verdict("refuted", "it says nothing: the two sides of an equality are the same")
IDLE = Verdict(
    "refuted", "it says nothing of the motion: it holds without the derived equation, too"
)
SLACK = Verdict("refuted", "it says too little: the two sides of an inequality are equal")
NEEDS_ACCELERATIONS = Verdict(
    "undecided", "it depends on accelerations that are not known; give Motion.of(eqs).solved(eqs)"
)
NEEDS_SIGNS = Verdict(
    "undecided",
    "false for some signs of the symbols; say with positive symbols, or Study(ranges=...), which "
    "are meant",
)


def verify(chain: Chain, check: Check, study: Study) -> FormulaOutcome:
    """Compare a formula for all values of its free indices; the first failure decides."""
    if check.decide is not None:
        return by_range(study, check.within, check.decide)
    unsaid = omission(chain, study) if check.stationary else ""
    if unsaid:
        return FormulaOutcome(Verdict("refuted", unsaid))
    finding = _compare_chain(chain, check, study)
    if finding.verdict.proved and says_nothing(chain):
        return FormulaOutcome(EMPTY, None, finding.count)
    gaps = list(_inequalities(chain, study))
    if not gaps or not finding.verdict.proved:
        return finding if finding.count or check.role == "definition" else FormulaOutcome(NOTHING)
    if any(_are_equal(gap, study) for gap in gaps):
        return FormulaOutcome(SLACK, None, finding.count)
    ordered = by_range(study, check.within, lambda _, where: _order_verdict(gaps, where))
    if ordered.verdict.refuted:
        if any(_has_unknown_accelerations(a - b, study) for a, _, b in gaps):
            return FormulaOutcome(NEEDS_ACCELERATIONS)
        if not study.ranges:
            return FormulaOutcome(NEEDS_SIGNS)
    return ordered if finding.count == 0 else replace(ordered, count=finding.count + len(gaps))


def by_range(study: Study, within: Sequence[str], decide: Decision) -> FormulaOutcome:
    """The outcome of a decision for each range of the parameters, or for the one of no name."""
    ranges = [r for r in study.ranges if not within or r.name in within] or [Range()]
    outcomes = tuple((r, call_hook(decide, study, r)) for r in ranges)
    for _, outcome in outcomes:
        if not isinstance(outcome, Verdict):
            raise HookError(f"'{decide.__name__}' returns no Verdict")
    return FormulaOutcome(outcomes[0][1], None, 1, outcomes if study.ranges else (), study.scope)


def _compare_chain(chain: Chain, check: Check, study: Study) -> FormulaOutcome:
    count = 0
    doubt: FormulaOutcome | None = None
    for comparison in comparisons(chain, check, study):
        count += 1
        verdict = _equal(comparison, check, study)
        if verdict.refuted:
            return FormulaOutcome(verdict, comparison, count)
        if verdict.undecided:
            doubt = doubt or FormulaOutcome(verdict, comparison, count)
    if doubt is not None:
        return doubt
    if count == 0:
        return FormulaOutcome(Verdict("proved", "nothing is claimed beyond the definition"))
    return FormulaOutcome(Verdict("proved", "zero in exact normal form"), None, count)


def _order_verdict(gaps: Sequence[tuple[Any, str, Any]], where: Range) -> Verdict:
    """Whether all inequalities hold in a range; the first that does not decides."""
    verdicts = []
    for left, relation, right in gaps:
        a, b = (as_expression(side).xreplace(dict(where.values)) for side in (left, right))
        verdicts.append(prove_inequality(a, relation, b, where.positive, where.real))
        if not verdicts[-1].proved:
            return verdicts[-1]
    return verdicts[0]


def _equal(comparison: FormulaComparison, check: Check, study: Study) -> Verdict:
    left, right = comparison.left, comparison.right
    verdict = prove_equal(left, right, (*study.relations, *comparison.relations))
    # what defines is true off the motion, too
    moves = check.role != "definition" and _has_unknown_accelerations(left - right, study)
    if verdict.refuted and moves:
        return NEEDS_ACCELERATIONS
    if verdict.refuted and not study.ranges and _hangs_on_signs(left, right):
        return NEEDS_SIGNS
    free = comparison.free
    if verdict.proved and free is not None and prove_equal(free, 0, study.relations).proved:
        return IDLE
    return verdict


def _hangs_on_signs(left: Any, right: Any) -> bool:
    """Whether sides have sizes, or roots with which they are equal for positive symbols."""
    if (left - right).has(sp.Abs, sp.sign):
        return True
    roots = any(not power.exp.is_Integer for power in (left - right).atoms(sp.Pow))
    positive = {x: sp.Symbol(f"{x}", positive=True) for x in (left - right).free_symbols}
    return roots and prove_equal(left.xreplace(positive), right.xreplace(positive)).proved


def _has_unknown_accelerations(value: Any, study: Study) -> bool:
    """Whether accelerations stand in a value of which the motion says nothing."""
    rates = study.motion.rates
    velocities = {s for rate in rates.values() for s in rate.free_symbols} & set(rates)
    unknown = {rates[v] for v in velocities} & set(accelerations(study))
    return bool((unknown - set(study.motion.accelerations)) & value.free_symbols)


def _inequalities(chain: Chain, study: Study) -> Iterator[tuple[Any, str, Any]]:
    """The pairs of neighbouring parts between which an inequality stands, along the motion."""
    along, given = study.motion.along, dict(study.given)
    for (left, right), relation in zip(pairwise(chain.parts), chain.relations, strict=True):
        if relation != "=":
            sides = (along(value_of(part, study, {})).xreplace(given) for part in (left, right))
            yield next(sides), relation, next(sides)


def _are_equal(gap: tuple[Any, str, Any], study: Study) -> bool:
    """Whether two sides of which one is printed not to be larger are one and the same."""
    left, relation, right = gap
    slack = relation in ("\\le", "\\leq", "\\ge", "\\geq")
    return slack and prove_equal(left, right, study.relations).proved


def omission(chain: Chain, study: Study) -> str:
    """What an integral principle fails to say before any value is compared."""
    integral = next((p for p in chain.parts if isinstance(p, Integral)), None)
    if integral is None:
        return "no integral is printed"
    if not (len(chain.parts) == 2 and chain.relations == ("=",) and Number("0") in chain.parts):
        return "the integral is not set equal to zero"
    variable, _ = integrand(integral)
    if variable in (integral.lower, integral.upper):
        return "a limit is the variable of integration, not a fixed moment"
    if integral.lower == integral.upper:
        return "the two limits are the same"
    heads = {bare_letter(part) for part in _names_of(study)} - {
        bare_letter(p) for p in _names(variable)
    }
    for limit in _names((integral.lower, integral.upper)):
        if bare_letter(limit) in heads:
            return f"the limit '{key_of(limit)}' bears the letter of something else"
    return ""


def _names(part: Any) -> Iterator[Name]:
    """The names in a part of a formula."""
    parts = part if isinstance(part, tuple) else (part,)
    for one in parts:
        if one is not None:
            yield from (node for node in walk(one) if isinstance(node, Name))


def _names_of(study: Study) -> Iterator[Name]:
    """What the names of a dictionary are names of, without dots and variations."""
    for name in study.names:
        yield from _names(study.tree(name))
