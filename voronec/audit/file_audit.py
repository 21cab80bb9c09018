"""The audit of a paper as its file stands: every formula against what its system has.

A formula that is refuted is accused only where nothing else can be meant: all its letters are
known, no word of its sentence names a condition, it is no assumption on the state or on parameters,
and there is a state at which it fails.  Everything else is listed apart, with the reason.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import prove_equal
from voronec.audit.claims_in_words import CONSTANT_WORD, WordClaim, claims_in_words, last_side
from voronec.audit.comparisons import value_of
from voronec.audit.display import Check, Display
from voronec.audit.formula import Formula
from voronec.audit.judge import SectionContext, judge_formula
from voronec.audit.latex.document import (
    Document,
    PrintedDisplay,
    PrintedSentence,
    read_document,
)
from voronec.audit.latex.nodes import (
    Chain,
    Derivative,
    Differential,
    Dot,
    Name,
    Node,
    Number,
    Partial,
    Power,
    Product,
    Quotient,
    Sum,
    walk,
)
from voronec.audit.latex.tex_file import MarkedText
from voronec.audit.lessons.judgement import GROUNDS
from voronec.audit.letters import (
    has_usual_words,
    names_in,
    read_letters,
    study_of,
    unknown_names,
    with_words,
)
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.page.referee import referee_lines
from voronec.audit.paper import Section
from voronec.audit.record import Audit, FormulaRecord, Record
from voronec.audit.structure import names_constant
from voronec.audit.study import Study, key_of
from voronec.audit.transcript import Transcript
from voronec.audit.verify import FormulaOutcome, verify
from voronec.audit.wording import witness_of
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, did_you_mean

_INTEGRAL = re.compile(
    r"\bintegrals?\b|constant|conserv|preserv|invariant|first integral", re.IGNORECASE
)
_CONDITIONS = re.compile(
    r"\b(if|when|whenever|unless|provided|suppos\w*|assum\w*|absence"
    r"|without(?! (?:slip|skid|los|fric))|neglect\w*|small|near|limit\w*|approximat\w*|at rest"
    r"|at the (?:initial|moment|instant)|initial\w*|steady|stationary|equilibri\w*|lineari[sz]\w*"
    r"|(?:special|particular) (?:cas|solution|motion|value)\w*|virtual"
    r"|unconstrained|would|as if|first order|rescal\w*|normali[sz]\w*"
    r"|dimensionless|nondimensional\w*|units|vakonomic|variational|remov\w*"
    r"|free (?:body|motion)|holonomic case|substitutes? (?:the )?variables?|new variables?"
    r"|(?:change|transformation) of (?:the )?variables?|by (?:the|a) substitution"
    r"|wrong\w*|erroneous\w*|incorrect\w*|false|misprint\w*|instead of|in (?:\w+ )?(?:book|paper)"
    r"|solution)\b",
    re.IGNORECASE,
)
"""Words of a sentence which say that a formula in it need not hold always."""
_ASSUMPTIONS = re.compile(
    r"\b(?:let|take(?! the)|choose|put|set|setting|putting|consider|fix|impose|requir\w*)\b"
    r"[\w\s:]{0,25}$"
    r"|\b(?:with|for|where|at|on|as)\s*$",
    re.IGNORECASE,
)
"""Words right before a formula that make an assumption of it."""
_INTEGRALS = re.compile(r"\bintegrals?\b|conserv", re.IGNORECASE)
_BEHIND = re.compile(r"\W*(?:for|if|when|provided|at|near|where)\b")
"""Words right behind a formula that restrict it."""
_SOLUTION = re.compile(r"solution|integra|constant", re.IGNORECASE)
_LIMIT = re.compile(r"\$\s*([^$=]+?)\s*\\(?:to|rightarrow)\s*(-?\d+)\s*\$")
"""A limit at a number, as ``$k\to 0$``."""
_AT_REST = re.compile(r"\bat rest\b", re.IGNORECASE)
_REACTIONS = re.compile(r"multiplier|reaction|constraint force|lagrange's equations", re.IGNORECASE)


@dataclass(frozen=True)
class PrintedClaim:
    """A formula of the paper with its display, its place and its tree, where it can be read.

    ``error`` says why it cannot; ``doubt``, why it can be read in two ways, of which it is the one
    in which a function takes the next name alone.
    """

    formula: Formula
    display: PrintedDisplay
    section: int
    place: tuple[str, int, int]
    chain: Chain | None
    error: str = ""
    doubt: str = ""

    @property
    def sentence(self) -> str:
        """The words around it."""
        return f"{self.display.before} {self.display.after}"

    @property
    def where(self) -> str:
        """Line and column, and the number in print."""
        number = f"({self.display.number}), " if self.display.number else ""
        return f"{number}line {self.place[1]}, column {self.place[2]}"


def claims_of(document: Document, study: Study) -> list[PrintedClaim]:
    """The formulas of a paper as they are read with a dictionary."""
    found: list[PrintedClaim] = []
    for number, section in enumerate(document.sections):
        for display in section.displays:
            found += _claims_in(document, number, display, study)
    return found


def _claims_in(
    document: Document, section: int, display: PrintedDisplay, study: Study
) -> Iterator[PrintedClaim]:
    """The formulas of a display of a section."""
    for position, unit, piece in display.formulas:
        formula = Formula(Display(display.latex.text), unit, piece, position, display.kind)
        at = document.source.place(display.latex.origins[piece.at[0]])
        yield PrintedClaim(formula, display, section, at, *_tree(formula, study))


def _tree(formula: Formula, study: Study) -> tuple[Chain | None, str, str]:
    """The tree of a formula, why there is none, and why there may be another."""
    try:
        return formula.tree(study.vocabulary), "", ""
    except DefinitionError as refusal:
        doubt = str(refusal)
    try:
        return formula.tree(replace(study.vocabulary, narrow_functions=True)), "", doubt
    except DefinitionError:
        return None, doubt, ""


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
    progress: Callable[[str, str], None] | None = None,
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
    work = _Work(document, study, given)
    return work.audit(Path(path).stem, equations.system, progress)


def _names_with(study: Study, given: Mapping[str, Any]) -> dict[str, Any]:
    """The names with those of the dictionary in the place of what is spelled alike."""
    keys = {study.key(study.tree(letter)) for letter in given}
    return {k: v for k, v in study.names.items() if study.key(study.tree(k)) not in keys} | dict(
        given
    )


@dataclass
class _Work:
    """The work on one paper: ``study`` grows by what the paper defines."""

    document: Document
    study: Study
    dictionary: Mapping[str, Any]
    claims: list[PrintedClaim] = field(default_factory=list)
    defined_at: dict[str, PrintedClaim] = field(default_factory=dict)
    found: dict[int, FormulaRecord] = field(default_factory=dict)
    unknown: dict[str, list[str]] = field(default_factory=dict)

    def audit(
        self, name: str, system: System, progress: Callable[[str, str], None] | None
    ) -> PaperAudit:
        self.claims = claims_of(self.document, self.study)
        self._refuse_strangers()
        by_display: dict[int, tuple[PrintedDisplay, list[Chain]]] = {}
        for claim in self.claims:
            entry = by_display.setdefault(id(claim.display), (claim.display, []))
            if claim.chain is not None:
                entry[1].append(claim.chain)
        self.study = with_words(self.study, by_display.values())
        self._define()
        self._multipliers()
        records = []
        for number, claim in enumerate(self.claims):
            record = self.found.get(number) or self._judge(claim)
            if progress is not None:
                progress(claim.where, record.verdict)
            section = self.document.sections[claim.section].title
            printed, kind = claim.formula.printed, claim.display.kind
            records.append(Record(claim.where, section, number + 1, printed, (record,), kind))
        self._blame_definitions(records)
        for sentence in self.document.sentences:
            for quoted, record in self._in_words(sentence):
                label = "line {1}, column {2}".format(*self._place(sentence))
                count = len(records) + 1
                records.append(Record(label, sentence.section, count, quoted, (record,), "text"))
        self._spare_strangers(records)
        title = self.document.title or name
        return PaperAudit(system, Audit(name, title, tuple(records)), self.unknown)

    def _refuse_strangers(self) -> None:
        """``DefinitionError`` for a letter of the dictionary that the paper does not have."""
        names = {key_of(n) for claim in self.claims if claim.chain for n in names_in(claim.chain)}
        for letter in self.dictionary:
            if self.study.key(self.study.tree(letter)) not in names:
                near = did_you_mean(letter, names)
                raise DefinitionError(f"the dictionary: '{letter}' is no letter of the paper{near}")

    # -- what the paper introduces ---------------------------------------------------------

    def _define(self) -> None:
        """Definitions wherever they stand; those that need others come after these."""
        changed = True
        while changed:
            changed = False
            for number, claim in enumerate(self.claims):
                if claim.chain is None or number in self.found:
                    continue
                unknown = unknown_names(claim.chain, self.study)
                if unknown and self._define_by(number, claim, unknown):
                    changed = True

    def _define_by(self, number: int, claim: PrintedClaim, unknown: Sequence[str]) -> bool:
        """Whether a formula is taken for a definition, or for an integral with its constant."""
        chain = claim.chain
        if chain is None or {*chain.relations} != {"="} or self._is_forced(unknown):
            return False
        parts = [(part, unknown_names(part, self.study)) for part in chain.parts]
        known = [part for part, names in parts if not names]
        lone = [part for part, _ in parts if _lone(part) is not None and part not in known]
        if len(unknown) == 1 and known and lone:
            name, value = _solve_for(lone[0], known[0])
            if name is None:
                return False
            first = parts[0][0] is lone[0]
            if not first and isinstance(known[0], Name) and not self._is_constant(known[0]):
                return False  # v = v_0 says something of a state
            if not first and self._is_constant(known[0]):
                self.found[number] = FormulaRecord(
                    claim.formula.printed, "proved", GROUNDS["integral"], source=self.study.origin
                )
            elif not first and (_INTEGRAL.search(claim.sentence) or not isinstance(lone[0], Name)):
                return False  # judged as an integral
            else:
                self.found[number] = FormulaRecord(
                    claim.formula.printed, "definition", f"it introduces {unknown[0]}"
                )
            self.study = self.study.join({key_of(name): value})
            self.defined_at[key_of(name)] = claim
            return True
        return False

    def _is_forced(self, unknown: Sequence[str]) -> bool:
        """Whether letters stand for multipliers or reactions."""
        return any(letter in self._forces for letter in unknown)

    @cached_property
    def _forces(self) -> frozenset[str]:
        """Letters that nothing explains, in equations with accelerations: lambda and mu, and what a
        sentence on multipliers or reactions has."""
        found: set[str] = set()
        for claim in self.claims:
            if claim.chain is None or not _has_accelerations(claim.chain, self.study):
                continue
            said = _REACTIONS.search(claim.sentence)
            for letter in unknown_names(claim.chain, self.study):
                if said or re.match(r"\\(?:lambda|mu)(?![a-zA-Z])", letter):
                    found.add(letter)
        return frozenset(found)

    def _is_constant(self, part: Node) -> bool:
        """Whether a part keeps its value along every motion."""
        chain = Chain((part, Name("const")), ("=",))
        outcome = _value_or_none(verify, chain, Check(), self.study)
        return outcome is not None and outcome.verdict.proved

    def _multipliers(self) -> None:
        """The values of multipliers, each from the first equation that has it."""
        symbols = {letter: sp.Dummy(letter) for letter in sorted(self._forces)}
        if not symbols:
            return
        study = replace(self.study, names={**self.study.names, **symbols})
        values: dict[Any, Any] = {}
        for number, claim in enumerate(self.claims):
            if claim.chain is None or number in self.found or len(claim.chain.parts) != 2:
                continue
            unknown = unknown_names(claim.chain, self.study)
            if not unknown or not {*unknown} <= symbols.keys():
                continue
            try:
                left, right = (
                    study.motion.along(value_of(p, study, {})) for p in claim.chain.parts
                )
                gap = sp.expand((left - right).xreplace(values))
            except SENSELESS:
                continue
            mine = [s for s in symbols.values() if gap.has(s)]
            if not mine or not _is_linear(gap, mine):
                continue
            slope = sp.diff(gap, mine[0])
            value = -(gap - slope * mine[0]) / slope
            values = {s: v.xreplace({mine[0]: value}) for s, v in values.items()} | {mine[0]: value}
            letter = next(k for k, s in symbols.items() if s == mine[0])
            self.found[number] = FormulaRecord(
                claim.formula.printed, "definition", f"it says what {letter} is"
            )
            self.defined_at[letter] = claim
        solved = {k: values[s] for k, s in symbols.items() if s in values}
        solved = {k: v for k, v in solved.items() if not v.free_symbols & {*symbols.values()}}
        self.study = replace(self.study, names={**self.study.names, **solved})

    def _blame_definitions(self, records: list[Record]) -> None:
        """Where all formulas fail that have a letter, two or more, what says its meaning is wrong
        rather than these."""
        for key, definition in self.defined_at.items():
            users = [
                number
                for number, claim in enumerate(self.claims)
                if claim is not definition and claim.chain is not None
                and key in {key_of(name) for name in names_in(claim.chain)}
            ]  # fmt: skip
            wrong = [number for number in users if records[number].verdict == "misprint"]
            if len(wrong) < 2 or any(records[number].verdict == "proved" for number in users):
                continue
            source = next(i for i, claim in enumerate(self.claims) if claim is definition)
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

    def _spare_strangers(self, records: list[Record]) -> None:
        """Where more formulas disagree with the system than agree, it is not the paper's."""
        wrong = [n for n, record in enumerate(records) if record.verdict == "misprint"]
        right = [
            claim
            for claim, record in zip(self.claims, records, strict=False)
            if record.verdict == "proved" and claim.chain is not None
            and any(_moves(part, self.study) for part in claim.chain.parts)
        ]  # fmt: skip
        if len(wrong) <= len(right):
            return
        for number in wrong:
            doubt = "more formulas disagree with the system than agree: is it that of the paper?"
            head = FormulaRecord(records[number].printed, "not read", doubt)
            records[number] = replace(records[number], formulas=(head,))

    # -- sentences -------------------------------------------------------------------------

    def _place(self, sentence: PrintedSentence) -> tuple[str, int, int]:
        return self.document.source.place(self.document.body.origins[sentence.at])

    def _in_words(self, sentence: PrintedSentence) -> Iterator[tuple[str, FormulaRecord]]:
        """The records of a sentence: of its claims, or one that says that it is not audited."""
        quoted = str(sentence)
        found = claims_in_words(sentence, partial(self._density, sentence), self._side)
        if not found:
            yield quoted, FormulaRecord("", "unaudited", "no pattern reads it", says=quoted)
        for claim in found:
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
            verdict, method = claim.decide(self.study.context)
            return FormulaRecord("", verdict, method, source=self.study.origin)
        made = self._claim_of(sentence, claim.formula, claim.before, claim.after)
        return FormulaRecord("", "not read", "a slot") if made is None else self._judge(made)

    def _claim_of(
        self, sentence: PrintedSentence, latex: str, before: str = "", after: str = ""
    ) -> PrintedClaim | None:
        """A formula that stands in the words of a sentence, as a claim."""
        marked = MarkedText(latex, (self.document.body.origins[sentence.at],) * len(latex))
        display = PrintedDisplay(marked, "text", "", before, after, sentence.number)
        titles = [section.title for section in self.document.sections]
        section = titles.index(sentence.section) if sentence.section in titles else 0
        found = [*_claims_in(self.document, section, display, self.study)]
        return found[0] if len(found) == 1 else None

    def _density(self, sentence: PrintedSentence, latex: str) -> Any:
        """The value of a formula in the invariants of the system, else None."""
        made = self._claim_of(sentence, f"${latex}=0$")
        if made is None or made.chain is None:
            return None
        invariants = self.study.context.system.invariants
        inside = {value: sp.Symbol(name) for name, value in invariants.items()}
        names = {
            letter: value.applyfunc(lambda x: inside.get(x, x))
            if isinstance(value, sp.MatrixBase)
            else inside.get(value, value)
            for letter, value in self.study.names.items()
        }
        study = replace(self.study, names=names)
        return _value_or_none(value_of, made.chain.parts[0], study, {})

    def _side(self, label: str) -> str:
        """The last side of the formula with a number, empty where there are several or none."""
        found = [c.formula.printed for c in self.claims if c.display.number == label]
        return last_side(found[0]) if len(found) == 1 else ""

    # -- verdicts --------------------------------------------------------------------------

    def _judge(self, claim: PrintedClaim) -> FormulaRecord:
        printed, chain = claim.formula.printed, claim.chain
        if chain is None:
            return FormulaRecord(printed, "not read", claim.error)
        unknown = unknown_names(chain, self.study)
        if unknown and _INTEGRAL.search(claim.sentence) and not self._is_forced(unknown):
            constant = self._with_constant(claim, unknown)
            if constant is not None:
                return self._with_own_constant(self._judge_known(constant), claim, constant)
        if len(unknown) == 1 and not self._is_forced(unknown):
            solution = self._solution(claim, unknown[0])
            if solution is not None:
                return solution
        if unknown:
            for letter in unknown:
                self.unknown.setdefault(letter, []).append(f"line {claim.place[1]}")
            return FormulaRecord(printed, "unknown letters", ", ".join(unknown))
        return self._judge_known(claim)

    def _with_constant(self, claim: PrintedClaim, unknown: Sequence[str]) -> PrintedClaim | None:
        """An integral with the word "const" in the place of its last side, a free constant; None
        where other letters are unknown."""
        chain = claim.chain
        if chain is None or _lone(chain.parts[-1]) is None or len(unknown) != 1:
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
        """The verdict on a solution with one constant, as v = g t + C: what the constant has to be
        must not change; None where the letter may be something else."""
        symbol, chain = sp.Dummy(letter), claim.chain
        study = replace(self.study, names={**self.study.names, letter: symbol}, ranges=())
        if chain is None or len(chain.parts) != 2:
            return None
        try:
            left, right = (study.motion.along(value_of(p, study, {})) for p in chain.parts)
            gap = sp.expand(left - right)
            slope = sp.diff(gap, symbol)
            if not _is_linear(gap, [symbol]) or slope.free_symbols & {*study.motion.rates}:
                return None
            value = -(gap - slope * symbol) / slope
            verdict = prove_equal(study.motion.along(study.motion.derivative(value)), 0)
        except SENSELESS:
            return None
        printed = claim.formula.printed
        if verdict.proved:
            return FormulaRecord(printed, "proved", GROUNDS["integral"], source=study.origin)
        said = re.match(r"[cC](?![a-zA-Z])", letter) and _SOLUTION.search(claim.sentence)
        if not said or not verdict.refuted or verdict.witness is None:
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
        if any(_is_slope_of_rate(node, self.study) for node in walk(chain)):
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
        cases = self._special_cases(claim, study)
        for said, special in cases:
            outcome = _value_or_none(verify, chain, Check(), special)
            if outcome is not None and outcome.verdict.proved:
                method = f"true for {said}, which its sentence names"
                return FormulaRecord(printed, "proved", method, source=study.origin)
        excuse = self._excuse(claim, chain, study)
        if excuse is None and cases:
            reason = f"false in general, and for {cases[-1][0]}, which its sentence names"
            return FormulaRecord(printed, "not read", reason)
        return excuse or self._refutation(claim, study)

    def _refutation(self, claim: PrintedClaim, study: Study) -> FormulaRecord:
        """The record of a formula that fails, with a state and a correction, if one is found."""
        section = Section("", tuple(self._displays[claim.section]), lambda _: {})
        bench = SectionContext(Transcript(section), {"": study})
        record, _ = judge_formula(claim.formula, Check(), bench)
        if record.verdict == "misprint" and record.witness is None:
            return replace(record, verdict="not read", method=f"no state tells: {record.method}")
        return record

    @cached_property
    def _displays(self) -> list[list[Display]]:
        """The displays by sections, each once."""
        found: list[list[Display]] = [[] for _ in self.document.sections]
        for claim in self.claims:
            own = found[claim.section]
            if claim.formula.display not in own:
                own.append(claim.formula.display)
        return found

    def _special_cases(self, claim: PrintedClaim, study: Study) -> list[tuple[str, Study]]:
        """What the sentence names before a formula: conditions, each alone and all together."""
        found: list[tuple[str, dict[Any, Any]]] = []
        moving = self.study.motion.rates
        words = claim.sentence
        if _AT_REST.search(words):
            found.append(("rest", dict.fromkeys(self.study.context.velocities, sp.S.Zero)))
        for letter, value in _LIMIT.findall(words):
            node = _value_or_none(self.study.tree, letter)
            symbol = node and self.study.table.get(self.study.key(node))
            if isinstance(symbol, sp.Symbol):
                found.append((f"${letter}\\to {value}$", {symbol: sp.Integer(value)}))
        for other in self.claims:
            beside = other.display.sentence == claim.display.sentence and other is not claim
            if not beside or not other.chain or self._holds(other, study):
                continue
            values = _value_or_none(_values, other.chain.parts, study)
            still = values and not getattr(values[-1], "free_symbols", set()) & {*moving}
            if still and isinstance(values[0], sp.Symbol):
                given = {x: values[-1] for x in values[:-1] if isinstance(x, sp.Symbol)}
                found.append((f"${other.formula.printed}$", given))
        if len(found) > 1:
            together: dict[Any, Any] = {}
            for _, given in found:
                together |= given
            found.append((" and ".join(said for said, _ in found), together))
        constant = _has_constancy(claim)
        return [
            (said, replace(study, given=given))
            for said, given in found
            if not (constant and given.keys() & moving.keys())
        ]

    def _holds(self, claim: PrintedClaim, study: Study) -> bool:
        """Whether a formula is true in general, so that it is no condition."""
        outcome = _value_or_none(verify, claim.chain, Check(), study)
        return outcome is not None and outcome.verdict.proved

    def _excuse(self, claim: PrintedClaim, chain: Chain, study: Study) -> FormulaRecord | None:
        """What else a refuted formula may be than wrong, as a record; else None."""
        printed = claim.formula.printed
        parts = [part for part in chain.parts if not names_constant(part)]
        about = self._condition_on(parts, study, constant=len(parts) < len(chain.parts))
        if about == "parameters":
            known = [key_of(n) for n in names_in(tuple(parts)) if key_of(n) in self.defined_at]
            for key in known[:1]:
                said = f"'{key}' is defined otherwise in {self.defined_at[key].where}"
                return FormulaRecord(printed, "convention", said)
        if about == "parameters" or (about and not _INTEGRALS.search(claim.display.before)):
            return FormulaRecord(printed, "definition", f"a condition on the {about}")
        for part in parts:
            if isinstance(part, Name) and not has_usual_words(part, claim.sentence):
                return FormulaRecord(printed, "not read", f"{part.head} may be something else here")
        words = claim.display.before.rpartition("\n\n")[2]
        condition = _CONDITIONS.search(words) or _ASSUMPTIONS.search(_without_commands(words))
        condition = condition or _BEHIND.match(claim.display.after)
        if condition is None:
            return None
        said = f"its sentence has '{condition[0].strip()}', a condition that is not read"
        return FormulaRecord(printed, "not read", f"false in general; {said}")

    def _condition_on(self, parts: Sequence[Node], study: Study, constant: bool) -> str:
        """Of what a formula may only say what value it has: parameters, the state, coordinates."""
        motion = self.study.motion
        values = _value_or_none(_values, parts, study) or []
        symbols: list[set[Any]] = [getattr(value, "free_symbols", set()) for value in values]
        states = {s for s in (*motion.rates, *motion.rates.values()) if s.is_Symbol}
        if values and not any(held & states for held in symbols):
            return "parameters"
        still = constant or any(not held & states for held in symbols)
        for part, held in zip(parts, symbols, strict=False):
            moving = held & states and not held <= motion.accelerations.keys()
            velocity_alone = isinstance(part, Dot) and len(held) == 1 and moving
            if still and (velocity_alone or (isinstance(part, Name) and held & states)):
                return "state"
        return "" if any(_moves(part, self.study) for part in parts) else "coordinates"


def _ground(chain: Chain, study: Study) -> str:
    """On what a proved formula rests."""
    if any(names_constant(part) for part in chain.parts):
        return GROUNDS["integral"]
    if not _has_accelerations(chain, study):
        return GROUNDS["constraints"]
    return GROUNDS["motion"]


def _has_accelerations(chain: Chain, study: Study) -> bool:
    """Whether rates of velocities stand in a formula."""
    dots = {*study.motion.accelerations}
    for part in chain.parts:
        for node in walk(part):
            if isinstance(node, (Dot, Derivative, Differential)):
                value = _value_or_none(evaluate, node, study)
                order = getattr(node, "order", 1)
                if order > 1 or (
                    value is not None and getattr(value, "free_symbols", set()) & dots
                ):
                    return True
    return False


def _moves(part: Node, study: Study) -> bool:
    """Whether a part holds a rate, a velocity, or what is made of these."""
    still = {*study.context.coordinates}
    moving = {s for s in (*study.motion.rates, *study.motion.constrained) if s not in still}
    value = _value_or_none(evaluate, part, study)
    dotted = any(isinstance(node, (Dot, Derivative, Differential)) for node in walk(part))
    return dotted or bool(getattr(value, "free_symbols", set()) & moving)


def _is_slope_of_rate(node: Node, study: Study) -> bool:
    """Whether a node is a partial derivative of what holds accelerations."""
    value = _value_or_none(evaluate, node.body, study) if isinstance(node, Partial) else None
    return bool(getattr(value, "free_symbols", set()) & study.motion.accelerations.keys())


def _values(parts: Sequence[Node], study: Study) -> list[Any]:
    return [value_of(part, study, {}) for part in parts]


def _value_or_none(work: Callable[..., Any], *arguments: Any) -> Any:
    """What comes out; None for what has no value."""
    try:
        return work(*arguments)
    except SENSELESS:
        return None


def _lone(part: Node) -> Name | None:
    """The single name of a part that holds numbers besides, as ``2h`` and ``c^2``."""
    if isinstance(part, Name):
        return None if names_constant(part) else part
    if isinstance(part, Sum) and len(part.terms) == 1:
        return _lone(part.terms[0][1])
    if isinstance(part, Power) and isinstance(part.exponent, Number):
        return _lone(part.base)
    if isinstance(part, Quotient) and isinstance(part.bottom, Number):
        return _lone(part.top)
    if isinstance(part, Product):
        rest = [f for f in part.factors if not isinstance(f, Number)]
        return _lone(rest[0]) if len(rest) == 1 else None
    return None


def _solve_for(part: Node, value: Node) -> tuple[Name | None, Node]:
    """The name of a part that is equal to a value, and what it is then; a power stays unsolved."""
    if isinstance(part, Name):
        return part, value
    if isinstance(part, Sum) and len(part.terms) == 1:
        return _solve_for(part.terms[0][1], Sum(((-1, value),)))
    if isinstance(part, Quotient):
        return _solve_for(part.top, Product((part.bottom, value)))
    if isinstance(part, Product):
        numbers = tuple(f for f in part.factors if isinstance(f, Number))
        rest = next(f for f in part.factors if not isinstance(f, Number))
        return _solve_for(rest, Quotient(value, Product(numbers)))
    return None, value


def _has_constancy(claim: PrintedClaim) -> bool:
    return claim.chain is not None and any(map(names_constant, claim.chain.parts))


def _is_linear(gap: Any, symbols: Sequence[Any]) -> bool:
    """Whether an expression is linear in some symbols together."""
    slopes = [sp.diff(gap, s) for s in symbols]
    return not any(slope.has(*symbols) for slope in slopes) and not prove_equal(slopes[0], 0).proved


def _without_commands(words: str) -> str:
    return re.sub(r"\\[a-zA-Z]+\*?|[{}$\\]", " ", words)
