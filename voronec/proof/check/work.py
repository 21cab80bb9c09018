"""The work on one unit: declarations in, a result out, whatever the declarations do."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter

from voronec.algebra.verdicts import NUMBERS, Verdict
from voronec.declaration.catalogue import Entry
from voronec.declaration.plugin_files import failure
from voronec.declaration.source_digest import engine_folder
from voronec.equations.motions import Motions
from voronec.errors import DefinitionError, EngineLimit, VoronecError
from voronec.proof.check.report import Finding, Result
from voronec.proof.check.unit import Unit
from voronec.proof.claims import Claim, check_claims


@dataclass
class Derivations:
    """What a process has derived so far, by the name of the system."""

    known: dict[str, tuple[Entry, Motions]] = field(default_factory=dict)

    def motions(self, entry: Entry) -> Motions:
        """The motions of a system, derived when they are first asked for."""
        if entry.name not in self.known or self.known[entry.name][0] != entry:
            self.known[entry.name] = (entry, Motions.of(entry.load()))
        return self.known[entry.name][1]


def examine(unit: Unit, bench: Derivations) -> Result:
    """The result of one unit; an error is a finding, too."""
    start = perf_counter()
    work = {"system": _system, "relation": _relation, "square": _square}[unit.kind]
    notes: tuple[str, ...] = ()
    try:
        findings, notes = work(unit, bench)
    except Exception as error:
        findings = [_failure_finding(unit.kind, unit.name, error)]
    result = Result(
        unit.kind, unit.name, unit.entry.place, tuple(findings), notes=notes,
        systems=tuple(e.name for e in unit.system_entries),
    )  # fmt: skip
    return replace(result, seconds=perf_counter() - start)


def _failure_finding(kind: str, name: str, error: Exception) -> Finding:
    """What an error tells of a unit, or of a part of it."""
    if isinstance(error, EngineLimit):
        return Finding(kind, name, "undecided", str(error))
    if isinstance(error, VoronecError):
        return Finding(kind, name, "broken", str(error))
    return Finding(kind, name, "broken", failure(error, str(engine_folder())))


Work = tuple[list[Finding], tuple[str, ...]]


def _system(unit: Unit, bench: Derivations) -> Work:
    from voronec.proof.quadratures import check_motion
    from voronec.proof.relations.charts import check_charts

    motions = bench.motions(unit.entry)
    findings = [_claim(c, c.reason) for c in check_claims(motions)]
    for kind, check in (("chart", check_charts), ("motion", check_motion)):
        try:
            findings += [_claim(c, c.reason) for c in check(motions)]
        except Exception as error:  # what was found of the rest stands all the same
            findings.append(_failure_finding(kind, unit.name, error))
    return findings, ()


def _relation(unit: Unit, bench: Derivations) -> Work:
    from voronec.proof.relations.decision import check_relation

    relation = unit.entry.load_relations()[0][unit.position]
    entries = {e.name: e for e in unit.system_entries}
    checked = check_relation(relation, lambda name: bench.motions(entries[name]))
    reasons = _admitted_reasons(unit)
    finding = _finding("relation", unit.name, checked.verdict, reasons.get(unit.name, ""))
    carried = [_claim(c, reasons.get(c.name, ""), "carried ") for c in checked.pulled]
    return [finding, *carried], tuple(checked.kinds)


def _square(unit: Unit, bench: Derivations) -> Work:
    from voronec.proof.relations.chains import check_square

    assert unit.square is not None
    relations = [entry.load_relations()[0][position] for entry, position in unit.through]
    entries = {e.name: e for e in unit.system_entries}
    checked = check_square(
        unit.square.declaration(),
        {r.label: r for r in relations},
        lambda name: bench.motions(entries[name]),
    )
    reason = _admitted_reasons(unit).get(unit.name, "")
    notes = tuple(", then ".join(limits) for limits in checked.limits if limits)
    return [_finding("square", unit.name, checked.verdict, reason)], notes


def _admitted_reasons(unit: Unit) -> dict[str, str]:
    """What the systems of a unit, and the one beside it, list as undecided, with the reasons."""
    reasons: dict[str, str] = {}
    for entry in (*unit.system_entries, unit.entry):
        try:
            reasons |= entry.load().undecided
        except DefinitionError:
            continue
    return reasons


def _claim(claim: Claim, reason: str, carried: str = "") -> Finding:
    """A claim; one that a relation carries may be admitted where it is decided, for others."""
    finding = _finding(f"{carried}{claim.kind}", claim.name, claim.verdict, reason)
    if carried and finding.stale:
        finding = replace(finding, admitted="")
    if claim.broken:
        return replace(finding, status="broken", admitted="")
    if claim.printed is None or not claim.printed.refuted:
        return finding
    remark = "; ".join(filter(None, (finding.remark, f"refuted as printed in {claim.source}")))
    return replace(finding, remark=remark)


def _finding(kind: str, name: str, verdict: Verdict, reason: str) -> Finding:
    """A verdict as a finding; numbers that agree are told apart from no answer at all."""
    status, how = verdict.status, verdict.method
    if status == "undecided" and "agree to" in how:
        status = "numeric"
    if verdict.witness is not None:
        how = f"{verdict.witness}" + ("" if how == NUMBERS else f"; {how}")
    return Finding(kind, name, status, how, reason, verdict.limits)
