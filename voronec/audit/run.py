"""The audit of a paper: every formula read, checked, and given a verdict."""

from __future__ import annotations

import re
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import sympy as sp

from voronec.audit.consistency import Examined, with_uses
from voronec.audit.correction import Spare, correct
from voronec.audit.derived import derived_latex
from voronec.audit.meaning import UnknownName, evaluate
from voronec.audit.nodes import Chain
from voronec.audit.paper import Check, Paper, Section
from voronec.audit.record import Audit, FormulaRecord, Record, worst
from voronec.audit.structure import (
    definitions_in,
    free_indices,
    names_constant,
    new_names,
)
from voronec.audit.study import Study
from voronec.audit.transcript import Formula, Transcript
from voronec.audit.verify import Finding, verify
from voronec.errors import DefinitionError, VoronecError

__all__ = ["audit_paper", "audit_section"]

Progress = Callable[[str, str], None]


def audit_paper(paper: Paper, progress: Progress | None = None) -> Audit:
    """A verdict for every formula of a paper.

    ``progress`` is called with the label (or the place) of each unit and its verdict.
    """
    records = [r for s in paper.sections for r in audit_section(s, progress)]
    return Audit(paper.name, paper.title, tuple(records), paper.references, paper.authors)


@dataclass(frozen=True)
class _Bench:
    """What the formulas of one section are checked with."""

    transcript: Transcript
    studies: Mapping[str, Study]

    def study(self, check: Check, name: str = "") -> Study:
        """The dictionary that a check asks for, or the one called ``name``."""
        name = name or check.study or next(iter(self.studies))
        if name not in self.studies:
            raise DefinitionError(f"a check asks for the study '{name}', which is not defined")
        study = self.studies[name]
        return replace(study, given=self._given(check, study)) if check.given else study

    def _given(self, check: Check, study: Study) -> dict[sp.Expr, sp.Expr]:
        """Conditions that the paper states as equations ``symbol = expression``."""
        found: dict[sp.Expr, sp.Expr] = {}
        for label in check.given:
            chain = self.transcript.labelled(label).tree(study.vocabulary)
            try:
                symbol, value = (evaluate(part, study) for part in chain.parts)
            except UnknownName:
                continue  # the system has the condition built in
            found[symbol] = value
        return found


def audit_section(section: Section, progress: Progress | None = None) -> tuple[Record, ...]:
    """The records of one section."""
    transcript = Transcript(section)
    studies = {
        name: _with_definitions(study, transcript)
        for name, study in section.studies(transcript).items()
    }
    bench = _Bench(transcript, studies)
    units: dict[int, list[Examined]] = {}
    for formula in transcript.formulas():
        unit = units.setdefault(id(formula.unit), [])
        unit.append(_examine(formula, bench, ordinal=len(units)))
        if progress is not None and formula.piece is formula.unit.pieces[-1]:
            progress(unit[0].called, worst(e.record.verdict for e in unit))
    everything = [e for unit in units.values() for e in unit]
    return tuple(_record(section, unit, everything) for unit in units.values())


def _record(section: Section, unit: Sequence[Examined], everything: Sequence[Examined]) -> Record:
    formulas = tuple(with_uses(e, everything) for e in unit)
    first = unit[0].formula.unit
    return Record(first.label, section.title, unit[0].ordinal, first.source, formulas)


def _with_definitions(study: Study, transcript: Transcript) -> Study:
    """Add the names that asides and displays of the section define."""
    chains = transcript.asides(study.vocabulary)
    for formula in transcript.formulas():
        try:
            chains.append(formula.tree(study.vocabulary))
        except DefinitionError:
            continue  # reported where the formula gets its verdict
    found: dict[str, Any] = {}
    for chain in chains:
        for key, node in definitions_in(chain, study).items():
            found.setdefault(key, node)
    return study.join(found)


def _examine(formula: Formula, bench: _Bench, ordinal: int) -> Examined:
    """One formula: its verdict, and what was derived."""
    started = clock.perf_counter()
    check = formula.display.check(formula.position)
    chain: Chain | None = None
    try:
        study = bench.study(check)
        chain = formula.tree(study.vocabulary)
        record = _judge(formula, chain, check, study, Spare.of(bench.transcript, study))
        record = _elsewhere(record, formula, check, bench)
        record = replace(record, method=_with_note(record, study))
    except (VoronecError, ArithmeticError, LookupError, TypeError, ValueError) as error:
        # a formula may make no sense, such as the sum of a vector and a number
        record = FormulaRecord(formula.printed, "undecided", str(error))
    marks = tuple(formula.unit.display[q[0].start : q[-1].end] for q in formula.piece.quantifiers)
    record = replace(record, quantifiers=marks, seconds=clock.perf_counter() - started)
    return Examined(formula, check, chain, record, ordinal)


def _elsewhere(
    record: FormulaRecord, formula: Formula, check: Check, bench: _Bench
) -> FormulaRecord:
    """A proved formula under the further dictionaries; what fails there takes over."""
    for name in check.also if record.verdict == "proved" else ():
        study = bench.study(check, name)
        other = _judge(
            formula, formula.tree(study.vocabulary), check, study, Spare.of(bench.transcript, study)
        )
        if other.verdict != "proved":
            return other
        record = replace(record, method=f"{record.method}; proved for '{name}' too")
    return record


def _judge(
    formula: Formula, chain: Chain, check: Check, study: Study, spare: Spare
) -> FormulaRecord:
    printed = formula.printed
    if check.role == "condition":
        return FormulaRecord(printed, "definition", "a condition")
    finding = verify(chain, check, study)
    proved = finding.verdict.proved
    derived = derived_latex(chain, formula.unit.display, check, study, proved)
    if proved:
        verdict = "proved"
        if check.role == "definition" or (finding.count == 0 and new_names(chain, study)):
            verdict = "definition"
        return FormulaRecord(printed, verdict, _method(finding, chain, check), derived)
    if finding.verdict.undecided:
        status = "cited" if check.role == "cited" else "undecided"
        return FormulaRecord(printed, status, finding.verdict.method, derived)
    return _refuted(formula, chain, check, study, finding, derived, spare)


def _refuted(
    formula: Formula,
    chain: Chain,
    check: Check,
    study: Study,
    finding: Finding,
    derived: str | None,
    spare: Spare,
) -> FormulaRecord:
    """Not an identity as printed: another reading, another convention, or a misprint."""
    printed, witness = formula.printed, _witness(finding)
    wide = replace(study.vocabulary, wide_sums=True)
    if verify(formula.tree(wide), check, study).verdict.proved:
        method = "proved with the sum sign reaching to the end of its group"
        return FormulaRecord(printed, "proved", method, derived)
    if check.convention is not None:
        other = replace(study, names={**study.names, **check.convention.names})
        if verify(chain, check, other).verdict.proved:
            method = f"true if {check.convention.statement}; against ({check.convention.against})"
            return FormulaRecord(printed, "convention", method, derived, witness=witness)
    correction = correct(formula, check, study, spare)
    if correction is None:
        loose = _loose(formula, chain, study)
        method = f"refuted as printed{loose}; no correction by a single change was found"
        return FormulaRecord(printed, "misprint", method, derived, witness=witness)
    return FormulaRecord(
        printed,
        "misprint",
        f"refuted as printed{_loose(formula, chain, study)}; the corrected formula is proved "
        f"({correction.method})",
        derived,
        correction.latex,
        correction.changes,
        correction.struck,
        witness,
    )


def _method(finding: Finding, chain: Chain, check: Check) -> str:
    parts = [finding.verdict.method]
    if finding.count > 1:
        parts.append(f"{finding.count} comparisons")
    if check.stationary:
        parts.append("variations integrated by parts, compared with the d'Alembert equations")
    elif check.truth is not None:
        parts.append("compared with the derived equation of motion")
    elif names_constant(chain.parts[-1]):
        parts.append("its derivative along the motion vanishes")
    if check.given:
        parts.append("given " + ", ".join(f"({label})" for label in check.given))
    return "; ".join(parts)


def _witness(finding: Finding) -> dict[str, Any] | None:
    comparison, witness = finding.comparison, finding.verdict.witness
    if comparison is None or witness is None:
        return None
    found: dict[str, Any] = {
        "point": {_plain(name): value for name, value in witness.point.items()},
        "printed": witness.left,
        "derived": witness.right,
    }
    if comparison.where:
        found["indices"] = {letter.lstrip("\\"): i for letter, i in comparison.where.items()}
    if comparison.about:
        found["about"] = comparison.about
    return found


def _plain(name: str) -> str:
    """An atom's name without the arguments of unknown functions."""
    return re.sub(r"(?<=\w)\((?:[\w ]+,\s*)+\w+\)", "", name)


def _loose(formula: Formula, chain: Chain, study: Study) -> str:
    """Say it where an index is bound by nothing."""
    bound = {w.text for words in formula.piece.quantifiers for w in words}
    bound |= set(free_indices(chain.parts[0], study))
    loose = [letter for letter in free_indices(chain, study) if letter not in bound]
    return f", where nothing binds the index {loose[0]}" if loose else ""


def _with_note(record: FormulaRecord, study: Study) -> str:
    return f"{record.method}; {study.note}" if study.note else record.method
