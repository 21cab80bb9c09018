"""The audit of a paper: every formula read, checked, and given a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from voronec.audit.cache import Basis, Cache
from voronec.audit.consistency import Examination, defined_name, families, with_uses
from voronec.audit.formula import Formula
from voronec.audit.hooks import call_hook
from voronec.audit.judge import SectionContext, judge_formula, judge_sentence
from voronec.audit.paper import Paper, Section
from voronec.audit.record import Audit, Record, designation_of, worst
from voronec.audit.sentence import Sentence
from voronec.audit.slots import Labels
from voronec.audit.structure import definitions_in, mentions
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript, formulas_by_label
from voronec.errors import DefinitionError, did_you_mean

Progress = Callable[[str, str], None]
Stage = Callable[[str, Sequence[Record]], None]


def audit_paper(
    paper: Paper,
    progress: Progress | None = None,
    cache: Cache | None = None,
    label: str | None = None,
    stage: Stage | None = None,
) -> Audit:
    """A verdict for every formula of a paper.

    progress
        called with the label (or the place) of each unit and its verdict.
    cache
        where finished verdicts are kept; those whose transcription, dictionary and engine are
        unchanged are taken from there, and the others are put there as they come.
    label
        of a display or a section, or what a record is called on the page ("text 3"): audit only
        the sections that have it, and return only what is called so; an unknown one raises
        ``DefinitionError``.
    stage
        called with the title of each section and its records, when it is done.
    """
    sections = paper.sections if label is None else _sections_with(paper, label)
    # What verdicts rest on is looked at before any is made: sources may be edited meanwhile.
    bases = [Basis.of(s, paper.sections) if cache is not None else None for s in sections]
    keys = ["" if basis is None else basis.digest() for basis in bases]
    labels = formulas_by_label(paper.sections)
    records: list[Record] = []
    for section, basis, key in zip(sections, bases, keys, strict=True):
        shelf = None if cache is None or basis is None else _Shelf(cache, basis, key)
        audited = audit_section(section, progress, shelf, labels)
        records += audited
        if stage is not None:
            stage(section.title, audited)
    if label is not None:
        records = [
            r for r in records if label in (r.label, r.designation, _label_of(paper, r.section))
        ]
    return Audit(paper.name, paper.title, tuple(records), paper.references, paper.authors)


def _sections_with(paper: Paper, label: str) -> list[Section]:
    """Those that bear a label, or in which a record is called so, as on the page."""
    sections, labels = [], list[str]()
    for section in paper.sections:
        heading = [section.label] if section.label else []
        everything = list(items(Transcript(section)))
        labels += heading + [item.label for item in everything if item.label]
        if label in heading or any(label in (item.label, item.designation) for item in everything):
            sections.append(section)
    if not sections:
        hint = did_you_mean(label, labels)
        raise DefinitionError(f"nothing in the paper '{paper.name}' is labelled '{label}'{hint}")
    return sections


def _label_of(paper: Paper, title: str) -> str | None:
    return next(s.label for s in paper.sections if s.title == title)


@dataclass(frozen=True)
class _Shelf:
    """The place of a section in the cache."""

    cache: Cache
    basis: Basis
    key: str

    def load(self, ordinal: int) -> list[Examination] | None:
        return self.cache.load(self.key, ordinal)

    def store(self, ordinal: int, found: Sequence[Examination]) -> None:
        if self.basis.digest() == self.key:  # else a source was edited since the audit began
            self.cache.store(self.key, ordinal, found)


@dataclass(frozen=True)
class AuditItem:
    """What gets one record: the formulas of a unit, or a sentence."""

    kind: str
    ordinal: int
    formulas: tuple[Formula, ...] = ()
    sentence: Sentence | None = None

    @property
    def label(self) -> str | None:
        """The label in print."""
        return self.formulas[0].unit.label if self.formulas else None

    @property
    def designation(self) -> str:
        """The label in parentheses, or the place."""
        return designation_of(self.label, self.kind, self.ordinal)

    @property
    def printed(self) -> str:
        """What stands in print."""
        if self.sentence is not None:
            return self.sentence.quotation
        return self.formulas[0].unit.source


def audit_section(
    section: Section,
    progress: Progress | None = None,
    shelf: _Shelf | None = None,
    labels: Labels | None = None,
) -> tuple[Record, ...]:
    """The records of one section; the dictionaries are made only if something is to be done.

    ``labels``: the formulas of the whole paper by their labels, to which sentences may refer.
    """
    work = Work(section, formulas_by_label([section]) if labels is None else labels)
    done: list[tuple[AuditItem, list[Examination]]] = []
    for item in items(work.transcript):
        examinations = shelf.load(item.ordinal) if shelf is not None else None
        if examinations is None:
            examinations = work.examine(item)
            if shelf is not None:
                shelf.store(item.ordinal, examinations)
        done.append((item, examinations))
        if progress is not None:
            progress(item.designation, worst(e.record.verdict for e in examinations))
    everything = [e for _, examinations in done for e in examinations]
    return tuple(_record(section, item, examinations, everything) for item, examinations in done)


def items(transcript: Transcript) -> Iterator[AuditItem]:
    """Units in the order of print, then the formulas of the text, then the sentences."""
    units: dict[int, list[Formula]] = {}
    for formula in transcript.formulas():
        units.setdefault(id(formula.unit), []).append(formula)
    ordinal = 0
    for ordinal, formulas in enumerate(units.values(), start=1):
        yield AuditItem(formulas[0].kind, ordinal, tuple(formulas))
    for number, sentence in enumerate(transcript.section.sentences, start=ordinal + 1):
        yield AuditItem("text", number, sentence=sentence)


def _record(
    section: Section,
    item: AuditItem,
    found: Sequence[Examination],
    everything: Sequence[Examination],
) -> Record:
    formulas = tuple(with_uses(e, everything) for e in found)
    return Record(item.label, section.title, item.ordinal, item.printed, formulas, item.kind)


@dataclass(frozen=True)
class Work:
    """The work on one section.

    ``labels`` are the formulas of the whole paper; ``studies`` the dictionaries, where they are
    made already; ``corrects`` tells whether corrections are sought for what is refuted, and
    ``prints`` whether what was derived is printed beside each verdict.
    """

    section: Section
    labels: Labels
    studies: Mapping[str, Study] | None = None
    corrects: bool = True
    prints: bool = True

    @cached_property
    def transcript(self) -> Transcript:
        """The formulas of the section."""
        return Transcript(self.section)

    @cached_property
    def bench(self) -> SectionContext:
        """The dictionaries, with the names that the section defines."""
        dictionaries = self.studies or call_hook(self.section.studies, self.transcript)
        where = f"section '{self.section.title}'"
        if not isinstance(dictionaries, Mapping) or not dictionaries:
            raise DefinitionError(f"{where}: 'studies' must return a dict of name -> Study")
        for name, study in dictionaries.items():
            if not isinstance(study, Study):
                raise DefinitionError(f"{where}: the study '{name}' is a {type(study).__name__}")
        studies = {n: _with_definitions(s, self.transcript) for n, s in dictionaries.items()}
        bench = SectionContext(self.transcript, studies, self.labels, self.corrects, self.prints)
        bench.refuse_unknown(where)
        return bench

    def examine(self, item: AuditItem) -> list[Examination]:
        """The verdicts of an item."""
        if item.sentence is not None:
            return [Examination(judge_sentence(item.sentence, self.bench), item.designation)]
        return [self._formula(formula, item) for formula in item.formulas]

    def _formula(self, formula: Formula, item: AuditItem) -> Examination:
        check = formula.display.check(formula.position)
        record, chain = judge_formula(formula, check, self.bench)
        marks = formula.piece.quantifiers
        texts = tuple(formula.unit.display[q[0].start : q[-1].end] for q in marks)
        record = replace(record, quantifiers=texts)
        return Examination(
            record,
            item.designation,
            item.label,
            "" if chain is None else defined_name(chain),
            () if chain is None else families(chain),
            check.given,
            check.role == "condition",
        )


def _with_definitions(study: Study, transcript: Transcript) -> Study:
    """Add the names that the section defines."""
    definitions: dict[str, Any] = {}
    for formula in transcript.formulas():
        if formula.display.check(formula.position).role != "definition":
            continue
        try:
            chain = formula.tree(study.vocabulary)
        except DefinitionError:
            continue  # reported where the formula gets its verdict
        for key, node in definitions_in(chain, study).items():
            if key not in definitions and not _circular(key, node, definitions):
                definitions[key] = node
    return study.join(definitions)


def _circular(key: str, node: Any, found: Mapping[str, Any]) -> bool:
    """Whether a definition would lead back to itself through those that are there."""
    waiting, seen = set(mentions(node)), set[str]()
    while waiting:
        name = waiting.pop()
        if name == key:
            return True
        seen.add(name)
        if name in found:
            waiting |= mentions(found[name]) - seen
    return False
