"""One formula, or one claim in words: its verdict, and what was derived.

Constraints have to be sufficient as well as necessary.  A formula that is true where the
constraints hold may say less than they do, or what another one has said already.  With the
constraints forgotten, the gradients of left minus right have to be independent of each other and of
those before, wherever the constraints hold.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from itertools import combinations
from typing import Any

import sympy as sp

from voronec.algebra.normal import shorten
from voronec.algebra.signs import prove_inequality
from voronec.algebra.verdicts import Verdict
from voronec.audit.comparisons import accelerations
from voronec.audit.correction import Correction, Spare, close_brackets, correct
from voronec.audit.display import Check, Decision
from voronec.audit.formula import Formula
from voronec.audit.hooks import HookError, call_hook
from voronec.audit.latex.displays import Piece
from voronec.audit.latex.nodes import Chain, walk
from voronec.audit.latex.reader import read, read_tokens
from voronec.audit.latex.tokens import (
    ELLIPSES,
    Ambiguous,
    Misprint,
    Token,
    Unfamiliar,
    complain,
)
from voronec.audit.meaning import SENSELESS, UnknownName, evaluate
from voronec.audit.record import FormulaRecord
from voronec.audit.sentence import Sentence
from voronec.audit.slots import Labels, tight
from voronec.audit.structure import (
    free_indices,
    marks,
    mentions,
    new_names,
    states_dependence,
)
from voronec.audit.study import Range, Study, UnknownRate, name_or_nothing
from voronec.audit.transcript import Transcript, assignments
from voronec.audit.verify import SLACK, FormulaOutcome, by_range, verify
from voronec.audit.wording import (
    derived_latex,
    loose_index,
    method_of,
    ranges_of,
    readable,
    with_note,
    witness_of,
)
from voronec.errors import DefinitionError, did_you_mean


@dataclass(frozen=True)
class SectionContext:
    """What the formulas of one section are checked with.

    ``corrects``: corrections are sought; ``prints``: what was derived is printed beside a verdict.
    """

    transcript: Transcript
    studies: Mapping[str, Study]
    labels: Labels = field(default_factory=dict)
    corrects: bool = True
    prints: bool = True

    def correction(self, formula: Formula, check: Check, study: Study) -> Correction | None:
        """What makes a formula true, a single change or the proposal, if it is to be sought."""
        if not self.corrects:
            return None
        spare = Spare.of(self.transcript, study)
        return correct(formula, check, study, spare)

    def study(self, check: Check | Sentence, name: str = "") -> Study:
        """The dictionary that a check asks for, or the one called ``name``."""
        study = self.studies[name or check.study or next(iter(self.studies))]
        if isinstance(check, Sentence) or not check.given:
            return study
        return replace(study, given={**self._stated_conditions(check, study), **study.given})

    def is_mentioned(
        self, name: str, formula: Formula, check: Check, index: bool = False, anywhere: bool = False
    ) -> bool:
        """Whether another formula has a name, as an index or not; under the same dictionary only,
        unless ``anywhere``."""
        study = self.study(check)
        for other in self.transcript.formulas():
            itself = (other.display, other.position) == (formula.display, formula.position)
            same = other.display.check(other.position).study == check.study
            if itself or not (same or anywhere):
                continue
            try:
                names = marks(other.tree(study.vocabulary), study, index)
            except DefinitionError:
                continue  # reported where that formula gets its verdict
            if name in names:
                return True
        return False

    @property
    def complete(self) -> bool:
        """Whether what is not known here is a fault of the print."""
        return self.transcript.section.complete

    def refuse_unknown(self, where: str) -> None:
        """``DefinitionError`` where a check names a study, a range or a label that is not there."""
        section = self.transcript.section
        checks = [c for d in (*section.displays, *section.inline) for c in d.checks]
        several: list[Check | Sentence] = [*checks, *section.sentences]
        named = {
            "study": {*(c.study for c in several), *(n for c in checks for n in c.also)} - {""},
            "range": {name for c in several for name in c.within},
        }
        there = {
            "study": set(self.studies),
            "range": {r.name for study in self.studies.values() for r in study.ranges},
        }
        for kind, wanted in named.items():
            for name in sorted(wanted - there[kind]):
                hint = did_you_mean(name, there[kind])
                raise DefinitionError(f"{where}: there is no {kind} '{name}'{hint}")
        for label in (label for check in checks for label in check.given):
            self.transcript.formula_labelled_as(label)

    def _stated_conditions(self, check: Check, study: Study) -> dict[sp.Expr, sp.Expr]:
        """Conditions that the paper states as equations ``symbol = expression``."""
        conditions: dict[sp.Expr, sp.Expr] = {}
        for label in check.given:
            chain = self.transcript.formula_labelled_as(label).tree(study.vocabulary)
            try:
                symbol, value = (evaluate(part, study) for part in chain.parts)
            except UnknownName:
                continue  # the system has the condition built in
            conditions[symbol] = value
        return conditions


def judge_sentence(sentence: Sentence, bench: SectionContext) -> FormulaRecord:
    """A sentence of the running text: the ranges of the parameters in which it holds."""
    says = readable(sentence.quotation)
    if sentence.decide is None:
        return FormulaRecord("", "unaudited", sentence.unaudited, says=says)
    try:
        study = bench.study(sentence)
        decide = _bound(sentence.decide, sentence.read(bench.labels))
        finding = by_range(study, sentence.within, decide)
        derived = call_hook(sentence.derived, study) if sentence.derived is not None else None
    except HookError as error:
        if sentence.is_original:
            raise
        fault = f"its decision cannot take what stands in a slot: {error}"
        return FormulaRecord("", "undecided", fault, says=says)
    except SENSELESS as error:
        return FormulaRecord("", "undecided", str(error), says=says)
    record = FormulaRecord("", "proved", method_of(finding), derived, says=says)
    record = replace(record, source=sentence.source or study.origin)
    record = replace(record, ranges=ranges_of(finding), method=with_note(record, study))
    if finding.verdict.proved and sentence.cited:
        return replace(record, verdict="cited", method=f"{record.method}; {sentence.cited}")
    if finding.verdict.proved:
        return replace(record, verdict="convention" if finding.partial else "proved")
    verdict = "undecided" if finding.verdict.undecided else "misprint"
    return replace(record, verdict=verdict, witness=witness_of(finding))


def _bound(decide: Callable[..., Verdict], slots: Mapping[str, Any]) -> Decision:
    """A decision with the values of its slots."""

    @wraps(decide)
    def bound(study: Study, where: Range) -> Verdict:
        return decide(study, where, **slots)

    return bound


def judge_formula(
    formula: Formula, check: Check, bench: SectionContext
) -> tuple[FormulaRecord, Chain | None]:
    """A formula under the dictionaries of its section, and its tree where it can be read."""
    if check.role == "words":
        return FormulaRecord(formula.printed, "definition", "defined in words"), None
    if check.sentence is not None:
        said = replace(check.sentence, quotation=formula.printed)
        return replace(judge_sentence(said, bench), printed=formula.printed, says=""), None
    chain: Chain | None = None
    try:
        study = bench.study(check)
        chain = formula.tree(study.vocabulary)
        record = _judge_formula(formula, chain, check, study, bench)
        record = _elsewhere(record, formula, check, bench)
        record = replace(record, method=with_note(record, study))
    except HookError:
        raise
    except SENSELESS as error:
        what = "cannot be read" if chain is None else "has no value"
        record = _without_value(formula, check, bench, error, what)
        record = _with_proposal(record, check, bench)
    return replace(record, says=check.says, source=_source(record, check, bench)), chain


def _source(record: FormulaRecord, check: Check, bench: SectionContext) -> str:
    """What the derived side was made from, where the verdict comes of a comparison with it."""
    if record.verdict not in ("proved", "convention", "misprint", "cited"):
        return ""
    several = [check.source] if check.source else []
    names = ("",) if several else ("", *check.also)
    several += [bench.study(check, name).origin for name in names]
    return "; ".join(dict.fromkeys(s for s in several if s))


def _without_value(
    formula: Formula, check: Check, bench: SectionContext, error: Exception, what: str
) -> FormulaRecord:
    """What cannot be read, or has no value, is a misprint where that is a fault of the print; what
    is not known is not read."""
    if isinstance(error, UnknownRate) or not isinstance(error, FAULTS_OF_PRINT):
        return FormulaRecord(formula.printed, "undecided", str(error))
    unusual = isinstance(error, Unfamiliar) or not isinstance(error, Misprint)
    if not isinstance(error, Ambiguous) and (bench.complete or not unusual):
        record = _made_true(formula, check, bench, f"it {what} as printed ({error})")
        if record is not None:
            return record
        fault = _meaningless(formula, check, bench, error)
        if fault:
            return FormulaRecord(formula.printed, "misprint", f"it {what} as printed: {fault}")
    return FormulaRecord(
        formula.printed, "not read", _message_with_place(formula, check, bench, error)
    )


def _message_with_place(
    formula: Formula, check: Check, bench: SectionContext, error: Exception
) -> str:
    """What is not known, with the place of the name."""
    if not isinstance(error, UnknownName):
        return str(error)
    names = walk(formula.tree(bench.study(check).vocabulary))
    at = next((n.at[0] for n in names if name_or_nothing(n) == error.name), formula.piece.at[0])
    return str(complain(formula.unit.display, at, str(error)))


def _meaningless(formula: Formula, check: Check, bench: SectionContext, error: Exception) -> str:
    """What is wrong with a formula that no dictionary could give a value; else nothing.

    A name that other formulas have, too, is one that the dictionary lacks: no fault of the print.
    """
    if isinstance(error, (Misprint, TypeError, ValueError, AttributeError)):
        return str(error)
    if not isinstance(error, UnknownName):
        return ""
    chain = formula.tree(bench.study(check).vocabulary)
    if check.role == "definition" and error.name in mentions(chain.parts[0]):
        return f"it introduces nothing, and '{error.name}' has no value"
    if bench.is_mentioned(error.name, formula, check, error.index):
        return ""
    return f"nothing introduces '{error.name}', and no other formula here has it"


FAULTS_OF_PRINT = (DefinitionError, TypeError, ValueError, AttributeError)
"""What may be wrong in print: a name, a vector in the place of a number; no limit of the engine."""


def _made_true(
    formula: Formula, check: Check, bench: SectionContext, fault: str
) -> FormulaRecord | None:
    """The record of a misprint, where a small change makes true what says nothing as printed."""
    study = bench.study(check)
    correction = bench.correction(formula, check, study)
    if correction is None:
        return None
    latex = correction.latex
    derived = derived_latex(read(latex, study.vocabulary), latex, check, study, True)
    witness = _closed_witness(formula.printed, check, study)
    record = FormulaRecord(formula.printed, "misprint", "", derived, witness=witness)
    method = f"{fault}; the corrected formula is proved ({correction.method})"
    return _with_correction(record, correction, method)


def _closed_witness(printed: str, check: Check, study: Study) -> dict[str, Any] | None:
    """Values of what is printed, with the brackets that are open closed at the end."""
    whole = close_brackets(printed, study.vocabulary)
    if whole is None:
        return None
    try:
        witness = witness_of(verify(read(whole, study.vocabulary), check, study))
    except SENSELESS:
        return None
    if witness is not None:
        witness["about"] = "with what is open closed at the end"
    return witness


def _elsewhere(
    record: FormulaRecord, formula: Formula, check: Check, bench: SectionContext
) -> FormulaRecord:
    """A proved formula under the further dictionaries; what fails there takes over."""
    good = ("proved", "definition")
    for name in check.also if record.verdict in good else ():
        study = bench.study(check, name)
        other = _judge_formula(formula, formula.tree(study.vocabulary), check, study, bench)
        if other.verdict not in good:
            return other
        record = replace(record, method=f"{record.method}; proved for '{name}' too")
    return record


NOTHING_LESS = Verdict("proved", "")
"""What is no constraint need not be sufficient."""


def _judge_formula(
    formula: Formula, chain: Chain, check: Check, study: Study, bench: SectionContext
) -> FormulaRecord:
    """The verdict on one formula: what is derived, then whether it says more than is known."""
    printed = formula.printed
    if check.role == "condition" and check.value is None and check.truth is None:
        return FormulaRecord(printed, "definition", "a condition")
    finding = verify(chain, check, study)
    proved = finding.verdict.proved
    derived = None
    if bench.prints:
        derived = derived_latex(chain, formula.unit.display, check, study, proved)
    if finding.verdict.refuted:
        return _judge_refutation(formula, chain, check, study, finding, derived, bench)
    if proved and not finding.count and (unused := _unused_name(formula, chain, check, bench)):
        fault = f"it introduces '{unused}', which no other formula here has"
        mended = _made_true(formula, check, bench, fault)
        if mended is not None and unused not in mentions(
            read(str(mended.correction), study.vocabulary)
        ):
            return mended
        return FormulaRecord(printed, "undecided", fault, derived)
    if not proved:
        status = "cited" if check.role == "cited" else "undecided"
        return _record_with_ranges(printed, status, finding.verdict.method, derived, finding)
    fault = _wrong_range(formula, chain, study) or _said_before(formula, chain, study, bench)
    if fault:
        return FormulaRecord(printed, "misprint", fault, derived)
    several = NOTHING_LESS
    if check.constrains:
        several = _independent_conditions(formula, chain, check, study, bench.transcript)
    if not several.proved:
        verdict = "misprint" if several.refuted else "undecided"
        return FormulaRecord(printed, verdict, several.method, derived)
    words = (method_of(finding, chain, check), several.method, check.cited)
    method = "; ".join(filter(None, words))
    verdict = _proved_as(finding, chain, check, study)
    return _record_with_ranges(printed, verdict, method, derived, finding)


def _record_with_ranges(
    printed: str, verdict: str, method: str, derived: str | None, finding: FormulaOutcome
) -> FormulaRecord:
    return FormulaRecord(printed, verdict, method, derived, ranges=ranges_of(finding))


def _proved_as(finding: FormulaOutcome, chain: Chain, check: Check, study: Study) -> str:
    """The verdict on what is proved: whether it is a fact, or true by what is agreed or cited."""
    if check.role == "condition":
        return "definition"
    if check.role == "definition" and not (finding.count and new_names(chain, study)):
        return "definition"
    if states_dependence(chain):
        return "definition"  # it is notation: what it says of the quantity is said elsewhere
    if check.role == "cited" or check.cited:
        return "cited"  # it is what was meant; whether that is a fact is not proved here
    return "convention" if finding.partial else "proved"


def _said_before(formula: Formula, chain: Chain, study: Study, bench: SectionContext) -> str:
    """Where a formula of a display repeats one before it; else nothing."""
    for other in bench.transcript.formulas():
        if other.display is not formula.display or other.position >= formula.position:
            continue
        try:
            same = other.tree(study.vocabulary) == chain
        except DefinitionError:
            continue  # reported where that formula gets its verdict
        if same and _words(other.piece) == _words(formula.piece):
            return f"formula {other.position + 1} of the same display says this already"
    return ""


def _unused_name(formula: Formula, chain: Chain, check: Check, bench: SectionContext) -> str:
    """A name that a definition introduces and nothing else has; else nothing."""
    names = sorted(new_names(chain, bench.study(check)))
    if not bench.complete or any(
        bench.is_mentioned(x, formula, check, anywhere=True) for x in names
    ):
        return ""
    return names[0] if names else ""


def _words(piece: Piece) -> list[list[str]]:
    return [[piece.phrase], *([word.text for word in words] for words in piece.quantifiers)]


UNIVERSAL = ("all", "any", "every", "each", "arbitrary")
PARTIAL = ("some", "no")
"""Words for what a formula that is proved holds for, and for what says less, or the opposite."""


def _wrong_range(formula: Formula, chain: Chain, study: Study) -> str:
    """What is wrong with the printed ranges of the indices, ``i=1,\\dots,n``; else nothing."""
    phrase = formula.piece.phrase
    if phrase.startswith("for ") and phrase.split()[1] not in UNIVERSAL:
        fault = f"it holds for all, and is printed '{phrase}'"
        if phrase.split()[1] not in PARTIAL:
            raise Unfamiliar(fault)
        return fault
    for words in formula.piece.quantifiers:
        if any(word.text == "\\in" for word in words):
            fault = _wrong_domain([word.text for word in words], study)
            if fault:
                return fault
        equal = [i for i, word in enumerate(words) if word.text == "="]
        if not equal and ELLIPSES.isdisjoint(word.text for word in words):
            continue  # no range of an index
        letter, after = words[0].text, _last_part(words)
        if equal != [1] or letter not in study.indices:
            raise Unfamiliar(f"the range of an index reads '{' '.join(w.text for w in words)}'")
        if letter not in free_indices(chain, study):
            raise Unfamiliar(f"the index {_spoken_name(letter)} of the range is not free here")
        top = read_tokens(words[after:], formula.unit.display, study.vocabulary)
        numbers = [word.text for word in words[2:after] if word.text not in (",", *ELLIPSES)]
        last = evaluate(top.parts[0], study)
        if numbers != [str(i) for i in range(1, len(numbers) + 1)] or not numbers:
            return f"the range of the index {_spoken_name(letter)} does not count from 1"
        if last != study.indices[letter]:
            return (
                f"the index {_spoken_name(letter)} runs from 1 to {study.indices[letter]} here, "
                f"and is printed to run to {last}"
            )
    return ""


def _wrong_domain(words: Sequence[str], study: Study) -> str:
    """What is wrong with the space in which a vector is printed to lie; else nothing."""
    cut = words.index("\\in")
    vector, space = tight(" ".join(words[:cut])), tight(" ".join(words[cut + 1 :]))
    if vector not in study.domains:
        raise Unfamiliar(f"it is printed for all {vector}, of which nothing is known here")
    if space != study.domains[vector]:
        return f"{vector} lies in {study.domains[vector]}, and is printed to lie in {space}"
    return ""


def _last_part(words: Sequence[Token]) -> int:
    """The position behind the last comma or dots."""
    return max((i for i, w in enumerate(words) if w.text in (",", *ELLIPSES)), default=1) + 1


def _spoken_name(letter: str) -> str:
    return letter.lstrip("\\")


def _judge_refutation(
    formula: Formula,
    chain: Chain,
    check: Check,
    study: Study,
    finding: FormulaOutcome,
    derived: str | None,
    bench: SectionContext,
) -> FormulaRecord:
    """Not an identity as printed: another reading, another convention, or a misprint."""
    if not bench.complete:
        if formula.unit.condition:
            said = f"it is printed with '{formula.unit.condition}', and a condition is not read"
            return FormulaRecord(formula.printed, "not read", said, derived)
        if finding.verdict == SLACK:
            return FormulaRecord(formula.printed, "undecided", SLACK.method, derived)
    record = FormulaRecord(formula.printed, "misprint", "", derived, witness=witness_of(finding))
    record = replace(record, ranges=ranges_of(finding))
    wide = formula.tree(replace(study.vocabulary, wide_sums=True))
    if wide != chain and verify(wide, check, study).verdict.proved:
        method = "proved with the sum sign reaching to the end of its group"
        return replace(record, verdict="proved", method=method, witness=None)
    if check.convention is not None:
        other = replace(study, names={**study.names, **check.convention.names})
        against = check.convention.against
        if verify(chain, check, other).verdict.proved:
            method = f"true if {check.convention.statement}; against ({against})"
            return replace(record, verdict="convention", method=method)
        mended = bench.correction(formula, check, other)
        if mended is not None and len(mended.changes) == 1:
            method = f"refuted as printed, even if {check.convention.statement}, as against "
            method += f"({against}); with that, the corrected formula is proved ({mended.method})"
            return _with_correction(record, mended, method)
    loose = loose_index(formula, chain, study)
    if finding.verdict.witness is None:
        loose += f": {finding.verdict.method}"
    correction = bench.correction(formula, check, study)
    if correction is None:
        method = f"refuted as printed{loose}; no correction by a small change was found"
        return _with_proposal(replace(record, method=method), check, bench)
    method = f"refuted as printed{loose}; the corrected formula is proved ({correction.method})"
    return _with_correction(record, correction, method)


def _with_proposal(record: FormulaRecord, check: Check, bench: SectionContext) -> FormulaRecord:
    """Where no correction was found: what has become of the one that the transcription proposes."""
    if check.proposal is None or record.correction is not None or not bench.corrects:
        return record
    study = bench.study(check)
    try:
        true = verify(read(check.proposal, study.vocabulary), check, study).verdict.proved
        fault = REFUSAL if true else "is not proved"
    except SENSELESS as error:
        fault = f"has no meaning: {error}"
    return replace(record, method=f"{record.method}; the proposed correction {fault}")


REFUSAL = "is true, but refused: it says too little, repeats something, or adds what print lacks"
"""Why a proposal that is proved is no correction."""


def _with_correction(record: FormulaRecord, correction: Correction, method: str) -> FormulaRecord:
    return replace(
        record,
        method=method,
        correction=correction.latex,
        changes=correction.changes,
        struck=correction.struck,
    )


def _independent_conditions(
    formula: Formula, chain: Chain, check: Check, study: Study, transcript: Transcript
) -> Verdict:
    """Whether a formula adds as many conditions as it should to those before it in its display."""
    before, rows = 0, _gradients(chain, study)
    for other in transcript.formulas():
        if other.display is not formula.display or other.position >= formula.position:
            continue
        number = other.display.check(other.position).constrains
        if number:
            rows = _gradients(other.tree(study.vocabulary), study) + rows
            before += number
    return _rank(rows, before + check.constrains, study)


def _gradients(chain: Chain, study: Study) -> list[dict[sp.Expr, sp.Expr]]:
    """By velocities, on the constraints: the derivatives of left minus right of every equation."""
    study, virtual = _free_variations(study)
    motion, gradients, dots = study.motion, [], accelerations(study)
    velocities = {x for x, rate in motion.rates.items() if rate in dots}
    velocities |= {*motion.constrained, *study.variations.values()}
    for where in assignments(chain, study):
        first, *rest = [evaluate(part, study, where) for part in chain.parts]
        for part in rest:
            gap = part if first == 0 else first if part == 0 else first - part
            for value in gap if isinstance(gap, sp.MatrixBase) else [gap]:
                symbols = value.free_symbols & velocities
                slopes = {x: motion.restrict(sp.diff(value, x).xreplace(virtual)) for x in symbols}
                gradients.append({x: e.xreplace(dict(study.given)) for x, e in slopes.items()})
    return gradients


def _free_variations(study: Study) -> tuple[Study, dict[sp.Expr, sp.Expr]]:
    """A study whose variations obey no constraint, and what the constraints make of them."""
    bound = {x: d for x, d in study.variations.items() if not isinstance(d, sp.Symbol)}
    free = {x: sp.Symbol(f"{{variation of {x}}}") for x in bound}
    virtual = {free[x]: d for x, d in bound.items()}
    return replace(study, variations={**study.variations, **free}), virtual


def _rank(rows: list[dict[sp.Expr, sp.Expr]], wanted: int, study: Study) -> Verdict:
    """Whether so many of some gradients are independent everywhere."""
    columns = sorted({x for row in rows for x, slope in row.items() if slope != 0}, key=str)
    said = f"{wanted} independent condition" + "s" * (wanted > 1)
    table = sp.Matrix([[row.get(x, 0) for x in columns] for row in rows])
    alive = _minors(table, wanted, study.relations)
    if not alive:
        return Verdict("refuted", f"with what stands before it there are not {said}")
    if any(_nowhere_zero(value, study) for value in alive) or _nowhere_zero(
        shorten([sp.Add(*(m**2 if len(rows) == wanted else m for m in alive))], study.relations)[0],
        study,
    ):
        return Verdict("proved", f"with what stands before it {said}")
    return Verdict("undecided", f"whether there are {said} everywhere is not decided")


def _minors(table: sp.Matrix, size: int, relations: tuple[Any, ...]) -> list[Any]:
    """Those of all rows that do not vanish, the shortest first; with more rows, for each choice of
    columns the sum of the squares: a principal minor of A^T A, whose entries are short where the
    rows are components of vectors."""
    if min(table.shape) < size:
        return []
    chosen = [list(c) for c in combinations(range(table.cols), size)]
    if table.rows > size:
        products = sp.Matrix(table.cols, table.cols, shorten(list(table.T * table), relations))
        minors = [products.extract(c, c).det(method="berkowitz") for c in chosen]
    else:
        minors = [table[:, c].det() for c in chosen]
    shortened = shorten(minors, relations)
    return sorted((m for m in shortened if m != 0), key=sp.count_ops)


def _nowhere_zero(value: Any, study: Study) -> bool:
    """Whether it does not vanish where what the study says to be positive is positive."""
    sizes = {x: sp.Symbol(f"size{i}", positive=True) for i, x in enumerate(study.positive)}
    return prove_inequality(value.xreplace(sizes), "!=", 0).proved
