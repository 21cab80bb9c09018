"""The verdict on one formula of a paper.

A formula that is refuted is accused only where nothing else can be meant: all its letters are
known, no word of its sentence names a condition, it is no assumption on the state or on parameters,
and there is a state at which it fails.  Everything else is listed apart, with the reason.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from voronec.audit.claims_in_words import CONSTANT_WORD
from voronec.audit.conditions import EXCEPTIONS, earlier_case, excuse, special_cases
from voronec.audit.contents import (
    constant_in,
    has_accelerations,
    is_slope_of_rate,
    lone_name,
)
from voronec.audit.curvature_letters import has_running_indices
from voronec.audit.display import Check, Display
from voronec.audit.introductions import INTEGRAL, Introductions
from voronec.audit.judge import SectionContext, judge_formula
from voronec.audit.latex.nodes import Chain, walk
from voronec.audit.lessons.judgement import GROUNDS
from voronec.audit.letters import name_latex, names_in, unknown_names
from voronec.audit.meaning import SENSELESS
from voronec.audit.paper import Section
from voronec.audit.printed_claims import PrintedClaim
from voronec.audit.record import FormulaRecord
from voronec.audit.structure import names_constant
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript
from voronec.audit.verify import FormulaOutcome, verify
from voronec.audit.wording import witness_of
from voronec.errors import EngineLimit

_SOLUTION = re.compile(r"solution|integra|constant", re.IGNORECASE)


@dataclass(frozen=True)
class ClaimJudge:
    """What the formulas of a paper are judged with: its claims, and what they introduce."""

    claims: Sequence[PrintedClaim]
    introductions: Introductions

    @property
    def study(self) -> Study:
        """The dictionary with what the paper introduces."""
        return self.introductions.study

    def judge(self, claim: PrintedClaim) -> FormulaRecord:
        """The verdict on a formula of the paper, or on one that a sentence makes."""
        printed, chain = claim.formula.printed, claim.chain
        if chain is None:
            return FormulaRecord(printed, "not read", claim.error)
        unknown = unknown_names(chain, self.study)
        forced = self.introductions.is_forced(unknown)
        if unknown and not forced and INTEGRAL.search(claim.sentence):
            constant = self._with_constant(claim, unknown)
            if constant is not None:
                return self._with_own_constant(self._judge_known(constant), claim, constant)
        if len(unknown) == 1 and not forced:
            solution = self._solution(claim, unknown[0])
            if solution is not None:
                return solution
        if (
            unknown
            and chain.relations == ("=",)
            and has_running_indices(chain.parts[0], self.study)
        ):
            return FormulaRecord(
                printed, "definition", f"it introduces {unknown[0]} for all indices"
            )
        if unknown:
            return FormulaRecord(printed, "unknown letters", ", ".join(unknown))
        return self._judge_known(claim)

    def _with_constant(self, claim: PrintedClaim, unknown: Sequence[str]) -> PrintedClaim | None:
        """An integral with the word "const" in the place of its last side, a free constant; None
        where other letters are unknown."""
        chain = claim.chain
        if chain is None or lone_name(chain.parts[-1]) is None or len(unknown) != 1:
            return None
        if unknown != unknown_names(chain.parts[-1], self.study):
            return None
        start = chain.parts[-1].at[0]
        end = claim.formula.piece.at[1]
        display = Display(claim.display.latex.put(start, end, CONSTANT_WORD).text)
        pieces = [(unit, piece) for unit in display.units for piece in unit.pieces]
        unit, piece = pieces[claim.formula.position]
        formula = replace(claim.formula, display=display, unit=unit, piece=piece)
        return replace(claim, formula=formula, chain=formula.tree(self.study.vocabulary))

    def _solution(self, claim: PrintedClaim, letter: str) -> FormulaRecord | None:
        """The record of a wrong solution with one constant, as v = g t + C: what the constant has
        to be changes; None where the letter may be something else."""
        chain, printed = claim.chain, claim.formula.printed
        said = re.match(r"[cC](?![a-zA-Z])", letter) and _SOLUTION.search(claim.sentence)
        if not said or chain is None or len(chain.parts) != 2:
            return None
        _, verdict = constant_in(chain.parts, letter, self.study)
        if verdict is None or not verdict.refuted or verdict.witness is None:
            return None
        witness = witness_of(FormulaOutcome(verdict, None, 1))
        method = f"the rate of what {letter} has to be does not vanish"
        return FormulaRecord(printed, "misprint", method, witness=witness)

    def _with_own_constant(
        self, record: FormulaRecord, claim: PrintedClaim, constant: PrintedClaim
    ) -> FormulaRecord:
        """A record of an integral with its own constant."""
        printed = claim.formula.printed
        letter = printed[len(constant.formula.printed) - len(CONSTANT_WORD) :]
        mended = record.correction and record.correction.replace(CONSTANT_WORD, letter)
        return replace(record, printed=printed, correction=mended)

    def _judge_known(self, claim: PrintedClaim) -> FormulaRecord:
        """The verdict on a formula whose letters are all known."""
        printed, chain = claim.formula.printed, claim.chain
        if chain is None:
            raise AssertionError("a formula that is judged has been read")
        if any(is_slope_of_rate(node, self.study) for node in walk(chain)):
            what = "a partial derivative of an acceleration depends on what stands for this"
            return FormulaRecord(printed, "not read", what)
        ordered = {*chain.relations} != {"="}
        study = self.study if ordered else replace(self.study, ranges=())
        try:
            verdict = verify(chain, Check(), study).verdict
        except EngineLimit as limit:
            return FormulaRecord(printed, "undecided", str(limit))
        except SENSELESS as error:
            return FormulaRecord(printed, "not read", f"it has no value: {error}")
        if verdict.proved:
            return FormulaRecord(printed, "proved", _ground(chain, study), source=study.origin)
        if ordered:
            return FormulaRecord(printed, "definition", "a condition")
        if verdict.undecided:
            return FormulaRecord(printed, "undecided", verdict.method)
        if claim.doubt:
            return FormulaRecord(printed, "not read", claim.doubt)
        cases = special_cases(claim, self.claims, study)
        for case in cases:
            if case.holds(chain):
                method = f"true for {case.said}, which its sentence names"
                if (denied := EXCEPTIONS.search(claim.sentence)) is not None:
                    method = f"{method}; it has '{denied[0]}', too, which is not read"
                    return FormulaRecord(printed, "not read", method)
                return FormulaRecord(printed, "proved", method, source=study.origin)
        if self.introductions.constants & {name_latex(name) for name in names_in(chain)}:
            return FormulaRecord(printed, "not read", "its constant may be another one here")
        spared = excuse(claim, chain, study, self.introductions.defined_at)
        if spared is None and cases:
            reason = f"false in general, and for {cases[-1].said}, which its sentence names"
            return FormulaRecord(printed, "not read", reason)
        earlier = None if spared else earlier_case(claim, chain, self.claims, study)
        if earlier is not None:
            reason = f"false in general, and true for what {earlier.said}: is that meant here?"
            return FormulaRecord(printed, "not read", reason)
        return spared or self._refutation(claim, study)

    def _refutation(self, claim: PrintedClaim, study: Study) -> FormulaRecord:
        """The record of a formula that fails, with a state and a correction, if one is found."""
        section = Section("", tuple(self._displays.get(claim.section, ())), lambda _: {})
        bench = SectionContext(Transcript(section), {"": study})
        record, _ = judge_formula(claim.formula, Check(), bench)
        if record.verdict == "misprint" and record.witness is None:
            return replace(record, verdict="not read", method=f"no state tells: {record.method}")
        return record

    @cached_property
    def _displays(self) -> dict[int, list[Display]]:
        """The displays by sections, each once."""
        grouped: dict[int, dict[Display, None]] = {}
        for claim in self.claims:
            grouped.setdefault(claim.section, {})[claim.formula.display] = None
        return {section: [*displays] for section, displays in grouped.items()}


def _ground(chain: Chain, study: Study) -> str:
    """On what a proved formula rests."""
    if any(names_constant(part) for part in chain.parts):
        return GROUNDS["integral"]
    if not has_accelerations(chain, study):
        return GROUNDS["constraints"]
    return GROUNDS["motion"]
