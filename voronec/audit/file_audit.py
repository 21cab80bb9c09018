"""The audit of a paper as its file stands: every formula against what its system has."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.audit.claim_judge import ClaimJudge
from voronec.audit.claims_in_words import WordClaim, claims_in_words, last_side
from voronec.audit.comparisons import value_of
from voronec.audit.contents import moves, value_or_none
from voronec.audit.curvature_letters import with_curvature
from voronec.audit.introductions import Introductions
from voronec.audit.latex.document import Document, PrintedSentence, read_document
from voronec.audit.letters import names_in, read_letters, study_of, unknown_names, with_words
from voronec.audit.page.referee import referee_lines
from voronec.audit.printed_claims import (
    PrintedClaim,
    applied_letters,
    claim_in_words,
    claims_of,
    has_primes,
)
from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.audit.study import Study, key_of
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, did_you_mean

Progress = Callable[[str, str], None] | None
"""What is told the place of each formula, and its verdict."""


@dataclass(frozen=True)
class PaperAudit:
    """What came out of a paper: the records, with a line and a column each as their label, and
    the letters that nothing explains, with their places.  Sentences that no pattern reads are
    records too, of the verdict "unaudited"."""

    system: System
    audit: Audit
    letters: Mapping[str, list[str]]

    @property
    def records(self) -> tuple[Record, ...]:
        """One for each formula, in the order of print, and for each sentence that is audited."""
        return tuple(r for r in self.audit.records if r.verdict != "unaudited")

    @property
    def errata(self) -> tuple[Record, ...]:
        """Those that are refuted."""
        return self.audit.errata

    def lines(self) -> list[str]:
        """The summary for a referee: what is right, what is wrong, what is not decided."""
        return referee_lines(self.audit, self.letters, self.system.name)

    def as_dict(self) -> dict[str, Any]:
        """The audit as data that JSON can hold."""
        return {
            "paper": self.audit.title,
            "system": self.system.name,
            "counts": self.audit.count(),
            "records": self.audit.as_list(),
            "letters": dict(self.letters),
        }

    def __str__(self) -> str:
        return "\n".join(self.lines())


def audit_paper(
    path: str | Path,
    system: System | VoronecEquations,
    dictionary: str | Path | Mapping[str, Any] | None = None,
    progress: Progress = None,
) -> PaperAudit:
    r"""Every formula of a LaTeX file beside what its system has.

    ``dictionary`` says what letters of the paper are in the system: a TOML file with a table
    ``[letters]``, or a mapping from their LaTeX to expressions.  ``progress`` is called with the
    place of each formula and its verdict.

    Raises ``DefinitionError`` for a file that is no LaTeX, with the place where a file or an
    argument is missing, and for a letter of the dictionary that the paper does not have.
    """
    equations = system if isinstance(system, VoronecEquations) else derive(system)
    document = read_document(path)
    if isinstance(dictionary, (str, Path)):
        dictionary = read_letters(dictionary, equations)
    given = {letter: as_expression(value) for letter, value in (dictionary or {}).items()}
    study = study_of(equations, document.source.body.text)
    study = replace(study, names=_names_with(study, given))
    applied = frozenset(applied_letters(document, study))
    study = replace(study, functions=applied, primes=has_primes(document))
    claims = claims_of(document, study)
    _refuse_strangers(claims, study, given)
    study = with_curvature(with_words(study, claims), claims, document.body.text)
    introduced = Introductions.of(claims, study)
    records = _records(document, introduced, progress)
    title = document.title or Path(path).stem
    audit = Audit(Path(path).stem, title, tuple(records))
    return PaperAudit(equations.system, audit, _unknown_letters(introduced, records))


def _records(document: Document, introduced: Introductions, progress: Progress) -> list[Record]:
    """The records of all formulas, then those of all sentences."""
    judge = ClaimJudge(introduced.claims, introduced)
    records: list[Record] = []
    for number, claim in enumerate(introduced.claims):
        record = introduced.records.get(number) or judge.judge(claim)
        if progress is not None:
            progress(claim.where, record.verdict)
        section = document.sections[claim.section].title
        printed, kind = claim.formula.printed, claim.display.kind
        records.append(Record(claim.where, section, number + 1, printed, (record,), kind))
    _blame_definitions(introduced, records)
    words = SentenceJudge(document, judge)
    for sentence in document.sentences:
        for quoted, record in words.records(sentence):
            label = "line {1}, column {2}".format(*words.place(sentence))
            count = len(records) + 1
            records.append(Record(label, sentence.section, count, quoted, (record,), "text"))
    _spare_strangers(introduced, records)
    return records


def _unknown_letters(introduced: Introductions, records: Sequence[Record]) -> dict[str, list[str]]:
    """The letters that nothing explains, with the lines in which they stand."""
    letters: dict[str, list[str]] = {}
    for claim, record in zip(introduced.claims, records, strict=False):
        if record.verdict == "unknown letters" and claim.chain is not None:
            for letter in unknown_names(claim.chain, introduced.study):
                letters.setdefault(letter, []).append(f"line {claim.place[1]}")
    return letters


def _names_with(study: Study, given: Mapping[str, Any]) -> dict[str, Any]:
    """The names with those of the dictionary in the place of what is spelled alike."""
    keys = {study.key(study.tree(letter)) for letter in given}
    others = {k: v for k, v in study.names.items() if study.key(study.tree(k)) not in keys}
    return {**others, **given}


def _refuse_strangers(claims: Sequence[PrintedClaim], study: Study, letters: Iterable[str]) -> None:
    """``DefinitionError`` for a letter of the dictionary that the paper does not have."""
    names = {key_of(n) for claim in claims if claim.chain for n in names_in(claim.chain)}
    for letter in letters:
        if study.key(study.tree(letter)) not in names:
            near = did_you_mean(letter, names)
            raise DefinitionError(f"the dictionary: '{letter}' is no letter of the paper{near}")


def _blame_definitions(introduced: Introductions, records: list[Record]) -> None:
    """Where all formulas fail that have a letter, two or more, what says its meaning is wrong
    rather than these."""
    for key, definition in introduced.defined_at.items():
        users = [
            number
            for number, claim in enumerate(introduced.claims)
            if claim is not definition and claim.chain is not None
            and key in {key_of(name) for name in names_in(claim.chain)}
        ]  # fmt: skip
        wrong = [number for number in users if records[number].verdict == "misprint"]
        if len(wrong) < 2 or any(records[number].verdict == "proved" for number in users):
            continue
        source = next(i for i, claim in enumerate(introduced.claims) if claim is definition)
        mended = all(records[number].decisive.correction for number in wrong)
        if mended or records[source].verdict != "definition":
            continue  # each can be mended by itself, or the meaning is proved
        places = ", ".join(str(records[number].label) for number in wrong)
        head = replace(
            records[source].decisive,
            verdict="misprint",
            method=f"all formulas fail in which {key} stands: {places}",
            witness=records[wrong[0]].decisive.witness,
        )
        records[source] = replace(records[source], formulas=(head,))
        for number in wrong:
            doubt = f"it contradicts what {key} is in {definition.where}"
            head = FormulaRecord(records[number].printed, "convention", doubt)
            records[number] = replace(records[number], formulas=(head,))


def _spare_strangers(introduced: Introductions, records: list[Record]) -> None:
    """Where more formulas disagree with the system than agree, it is not the paper's."""
    wrong = [n for n, record in enumerate(records) if record.verdict == "misprint"]
    right = 0
    for claim, record in zip(introduced.claims, records, strict=False):
        parts = claim.chain.parts if claim.chain and record.verdict == "proved" else ()
        right += any(moves(part, introduced.study) for part in parts)
    if len(wrong) <= right:
        return
    for number in wrong:
        doubt = "more formulas disagree with the system than agree: is it that of the paper?"
        head = FormulaRecord(records[number].printed, "not read", doubt)
        records[number] = replace(records[number], formulas=(head,))


@dataclass(frozen=True)
class SentenceJudge:
    """What the sentences of a paper are judged with."""

    document: Document
    judge: ClaimJudge

    def place(self, sentence: PrintedSentence) -> tuple[str, int, int]:
        """File, line and column of a sentence."""
        return self.document.source.place(self.document.body.origins[sentence.at])

    def records(self, sentence: PrintedSentence) -> Iterator[tuple[str, FormulaRecord]]:
        """The records of a sentence: of its claims, or one that says that it is not audited."""
        quoted = str(sentence)
        claims = claims_in_words(sentence, partial(self._density, sentence), self._side)
        if not claims:
            yield quoted, FormulaRecord("", "unaudited", "no pattern reads it", says=quoted)
        for claim in claims:
            record = self._judge_words(sentence, claim)
            if record.verdict == "misprint" and not claim.alone:
                doubt = "false in general, where its sentence says more than this"
                record = FormulaRecord("", "unaudited", doubt)
            elif record.verdict not in ("proved", "misprint", "unaudited"):
                record = FormulaRecord("", "unaudited", f"{record.verdict}: {record.method}")
            yield quoted, replace(record, says=quoted)

    def _judge_words(self, sentence: PrintedSentence, claim: WordClaim) -> FormulaRecord:
        """The verdict on a claim in words, by the formula that it makes if it makes one."""
        if claim.decide is not None:
            verdict, method = claim.decide(self.judge.study.context)
            return FormulaRecord("", verdict, method, source=self.judge.study.origin)
        made = claim_in_words(
            self.document, sentence, claim.formula, self.judge.study, claim.before, claim.after
        )
        return FormulaRecord("", "not read", "a slot") if made is None else self.judge.judge(made)

    def _density(self, sentence: PrintedSentence, latex: str) -> Any:
        """The value of a formula in the invariants of the system, else None."""
        made = claim_in_words(self.document, sentence, f"${latex}=0$", self.judge.study)
        if made is None or made.chain is None:
            return None
        invariants = self.judge.study.context.system.invariants
        inside = {value: sp.Symbol(name) for name, value in invariants.items()}
        names = {
            letter: value.applyfunc(lambda x: inside.get(x, x))
            if isinstance(value, sp.MatrixBase)
            else inside.get(value, value)
            for letter, value in self.judge.study.names.items()
        }
        study = replace(self.judge.study, names=names)
        return value_or_none(value_of, made.chain.parts[0], study, {})

    def _side(self, label: str) -> str:
        """The last side of the formula with a number, empty where there are several or none."""
        formulas = [c.formula.printed for c in self.judge.claims if c.display.number == label]
        return last_side(formulas[0]) if len(formulas) == 1 else ""
