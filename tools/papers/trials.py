"""One section of a paper with its misprints corrected, and audited again with an error in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

from papers.english_errors import sentence_slips
from papers.latex_errors import Slip, slips
from voronec.algebra.verdicts import prove_equal
from voronec.audit import Display, Section, Study, Transcript
from voronec.audit.comparisons import value_of
from voronec.audit.consistency import Examination
from voronec.audit.formula import Formula
from voronec.audit.latex.nodes import Chain, Integral, Node, Sum
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.paper_audit import AuditItem, Work, items
from voronec.audit.record import VERDICTS
from voronec.audit.slots import Labels
from voronec.audit.structure import are_multiples, holds_always, integrand, new_names
from voronec.audit.transcript import assignments
from voronec.errors import VoronecError

FAULTS = ("convention", "misprint")
OPEN = ("not read", "undecided")
HIT = "noticed at the right record"
BRACKETS = frozenset("()[]{}")


@dataclass(frozen=True)
class Trial:
    """What became of an error; ``said`` is the verdict with its method, ``fault`` what is wrong."""

    outcome: str
    said: str = ""
    fault: Fault | None = None


@dataclass(frozen=True)
class Fault:
    """A false formula in its section; ``true`` are those that stood in its place before."""

    work: Work
    formula: Formula
    true: tuple[Formula, ...]

    def correction(self) -> str | None:
        """What the audit proposes to read instead."""
        item = AuditItem("display", 1, (self.formula,))
        return replace(self.work, corrects=True).examine(item)[0].record.correction


@dataclass(frozen=True)
class _Spy(Transcript):
    """A transcript that tells what is read in it; "" stands for everything."""

    tell: Callable[[str], None] = field(kw_only=True)

    def formulas(self) -> Iterator[Formula]:
        self.tell("")
        return super().formulas()

    def formula_labelled_as(self, label: str) -> Formula:
        self.tell(label)
        return Transcript(self.section).formula_labelled_as(label)


@dataclass(frozen=True)
class Page:
    """A section; its places are the displays, the formulas of the text, and the sentences.

    ``labels`` are the formulas of the whole paper by their labels.
    """

    source: Section
    labels: Labels = field(default_factory=dict)

    def _work(
        self, section: Section, studies: Mapping[str, Study] | None, corrects: bool = False
    ) -> Work:
        return Work(section, self.labels, studies, corrects, prints=False)

    @cached_property
    def _spy(self) -> tuple[Mapping[str, Study], set[str]]:
        read = set[str]()
        return self.source.studies(_Spy(self.source, tell=read.add)), read

    @cached_property
    def section(self) -> Section:
        """The section as its corrections would have it printed."""
        work = self._work(self.source, self._spy[0])
        wrong = [
            item
            for item in items(work.transcript)
            if item.formulas and _worst(work.examine(item)) in ("misprint", *OPEN)
        ]
        seeking = self._work(self.source, self._spy[0], True)
        mends: dict[str, list[tuple[int, int, str]]] = {}
        for item in wrong:
            for formula, examined in zip(item.formulas, seeking.examine(item), strict=True):
                if examined.record.correction is not None:
                    mend = (*formula.piece.at, examined.record.correction)
                    mends.setdefault(formula.display.latex, []).append(mend)
        displays = tuple(_mend(d, mends) for d in self.source.displays)
        inline = tuple(_mend(d, mends) for d in self.source.inline)
        return replace(self.source, displays=displays, inline=inline)

    @cached_property
    def _whole(self) -> Work:
        """The work on the corrected section."""
        mended = self.section != self.source and bool(self._spy[1])
        return self._work(self.section, None if mended else self._spy[0])

    @cached_property
    def _before(self) -> dict[int, list[Examination]]:
        return {}

    @cached_property
    def _items(self) -> list[AuditItem]:
        return list(items(self._whole.transcript))

    def before(self, item: AuditItem) -> list[Examination]:
        """The verdicts of a record, or of some of its formulas, without an error."""
        whole = self._items[item.ordinal - 1]
        if item.ordinal not in self._before:
            self._before[item.ordinal] = self._whole.examine(whole)
        found = self._before[item.ordinal]
        if whole.sentence is not None:
            return found
        here = {formula.position for formula in item.formulas}
        return [e for f, e in zip(whole.formulas, found, strict=True) if f.position in here]

    @property
    def _displays(self) -> tuple[Display, ...]:
        return (*self.section.displays, *self.section.inline)

    @cached_property
    def _sentences(self) -> list[AuditItem]:
        return [i for i in self._items if i.sentence is not None]

    def latex(self, place: int) -> str:
        """What is printed at a place."""
        displays = self._displays
        if place < len(displays):
            return displays[place].latex
        return self._sentences[place - len(displays)].printed

    def name_of(self, place: int) -> str:
        """How the records of a place are called, and in which section."""
        if place >= len(self._displays):
            here = [self._sentences[place - len(self._displays)].designation]
        else:
            here = [i.designation for i in self._items if self._at(i, place)]
        return f"{', '.join(here)} of '{self.section.title}'"

    def _at(self, item: AuditItem, place: int) -> bool:
        return bool(item.formulas) and item.formulas[0].display is self._displays[place]

    def slips(self) -> Iterator[tuple[int, Slip]]:
        """All errors in formulas, each with its place; words in place of a formula are no part."""
        for place, display in enumerate(self._displays):
            if any(check.role != "words" for check in display.checks):
                yield from ((place, slip) for slip in slips(display.latex))

    def sentence_slips(self) -> Iterator[tuple[int, Slip]]:
        """All errors in sentences, each with its place."""
        for place, item in enumerate(self._sentences, start=len(self._displays)):
            found = sentence_slips(item.printed, tuple(self.labels))
            yield from ((place, slip) for slip in found)

    def sentence_trial(self, place: int, slip: Slip) -> Trial:
        """Audit a sentence again with an error in it: its verdict must change, or what is wrong."""
        item = self._sentences[place - len(self._displays)]
        assert item.sentence is not None
        if item.sentence.decide is None:
            return Trial("survived", "not audited")
        changed = replace(item, sentence=replace(item.sentence, quotation=slip.latex))
        try:
            before, after = self.before(item), self._whole.examine(changed)
        except SENSELESS as error:
            return Trial("undecided", f"refused: {error}")
        told = _tell if _worst(before) == "misprint" else _worst  # wrong already, and how
        same = told(before) == told(after)
        return Trial("survived" if same else HIT, _tell(after))

    def trial(self, place: int, slip: Slip) -> Trial:
        """Audit again what depends on a place, with an error in it."""
        if place >= len(self._displays):
            return self.sentence_trial(place, slip)
        try:
            work, display = self._change(place, slip)
            pairs = self._pairs(work, place, display)
            trial = self._judge(work, pairs) or self._elsewhere(work, place, display)
            return trial or self._survivor(work, pairs, slip)
        except SENSELESS as error:
            labels = {f"({unit.label})" for unit in self._displays[place].units}
            named = any(str(error).startswith(label) for label in labels)
            return Trial(HIT if named else "undecided", f"refused: {error}")

    def _elsewhere(self, work: Work, place: int, display: Display) -> Trial | None:
        """The trial, where another record that rests on the place has become worse."""
        for item in self._dependents(place, display):
            twin = next(i for i in items(work.transcript) if i.ordinal == item.ordinal)
            after, before = work.examine(twin), self.before(item)
            if _worst(after) != _worst(before) and _worst(after) in (*OPEN, *FAULTS):
                outcome = _worst(after) if _worst(after) in OPEN else "noticed elsewhere"
                return Trial(outcome, f"{item.designation}: {_tell(after)}")
        return None

    def _change(self, place: int, slip: Slip) -> tuple[Work, Display]:
        """The work on the section with the error, and the display that bears it."""
        old = self._displays[place]
        display = replace(old, latex=slip.latex)
        displays = tuple(display if d is old else d for d in self.section.displays)
        inline = tuple(display if d is old else d for d in self.section.inline)
        section = replace(self.section, displays=displays, inline=inline)
        if self._is_read(old):
            return self._work(section, None), display
        defines = any(check.role == "definition" for check in old.checks)
        studies = self._whole_studies if defines else self._whole.bench.studies
        return self._work(section, studies), display

    @cached_property
    def _whole_studies(self) -> Mapping[str, Study]:
        if self._whole.studies is not None:
            return self._whole.studies
        return self.section.studies(self._whole.transcript)

    def _is_read(self, display: Display) -> bool:
        """Whether the dictionaries are made from a display."""
        labels = {unit.label for unit in display.units}
        return "" in self._spy[1] or bool(labels & self._spy[1])

    def _pairs(
        self, work: Work, place: int, display: Display
    ) -> list[tuple[AuditItem | None, AuditItem]]:
        """The records at a place before and now, as far as the error is in them."""
        old = [i for i in self._items if self._at(i, place)]
        new = [i for i in items(work.transcript) if i.formulas and i.formulas[0].display is display]
        if len(old) != len(new):
            return [(None, item) for item in new]
        return [(a, b) for a, b in zip(old, new, strict=True) if a.printed != b.printed]

    def _judge(self, work: Work, pairs: list[tuple[AuditItem | None, AuditItem]]) -> Trial | None:
        """The trial, where the verdict of a record at the place itself has become worse.

        The formulas that bear the error are looked at first, and mostly that is enough.
        """
        narrow = [_narrow(old, new) for old, new in pairs]
        several = [*narrow, *(pair for pair in pairs if pair not in narrow)]
        for old, item in several:
            if not item.formulas:
                continue
            found = work.examine(item)
            before = "proved" if old is None else _worst(self.before(old))
            if _worst(found) in OPEN:
                found = replace(work, corrects=True).examine(item)
            if _worst(found) in FAULTS and _worst(found) != before:
                return Trial(HIT, _tell(found), _fault(work, old, item, found))
            if _worst(found) in OPEN and _worst(found) != before:
                return Trial(_worst(found), _tell(found))
        return None

    def _dependents(self, place: int, display: Display) -> Iterator[AuditItem]:
        """The other records that rest on a place, directly or through definitions."""
        every = [i for i in self._items if not self._at(i, place)]
        yield from (i for i in self._items if self._at(i, place) and len(display.units) > 1)
        if self._is_read(self._displays[place]):
            yield from every
            return
        roles = {check.role for check in display.checks}
        if not roles & {"definition", "condition"}:
            return
        here = [i for i in self._items if self._at(i, place)]
        known = {e.defines for i in here for e in self.before(i)} - {""}
        labels = {i.label for i in here} - {None}
        for item in every:
            checks = [f.display.check(f.position) for f in item.formulas]
            uses = {name for e in self.before(item) for name in e.uses} if item.formulas else set()
            if known & uses or any(labels & set(c.given) for c in checks):
                yield item

    def _survivor(
        self, work: Work, pairs: list[tuple[AuditItem | None, AuditItem]], slip: Slip
    ) -> Trial:
        """Whether an error that changes no verdict is one at all."""
        verdicts = "; ".join(_tell(work.examine(item)) for _, item in pairs) or "nothing changed"
        same = [old is not None and _same_record(old, item, work) for old, item in pairs]
        if slip.kind != "repeated" and pairs and all(same):
            return Trial("became true", verdicts)
        return Trial("survived", verdicts)


def _fault(work: Work, old: AuditItem | None, item: AuditItem, found: list[Examination]) -> Fault:
    at = next(i for i, e in enumerate(found) if e.record.verdict == _worst(found))
    if old is None:
        return Fault(work, item.formulas[at], ())
    alone = len(old.formulas) == len(item.formulas)
    return Fault(work, item.formulas[at], old.formulas[at : at + 1] if alone else old.formulas)


def _narrow(old: AuditItem | None, new: AuditItem) -> tuple[AuditItem | None, AuditItem]:
    """Two records with only those formulas that differ."""
    if old is None or len(old.formulas) != len(new.formulas):
        return old, new
    several = [
        (a, b)
        for a, b in zip(old.formulas, new.formulas, strict=True)
        if a.printed != b.printed or _quantifiers(a) != _quantifiers(b)
    ]
    before, after = (tuple(pair[k] for pair in several) for k in (0, 1))
    return replace(old, formulas=before), replace(new, formulas=after)


def _quantifiers(formula: Formula) -> list[list[str]]:
    ranges = [[word.text for word in words] for words in formula.piece.quantifiers]
    return [[formula.piece.phrase], *ranges]


def _mend(display: Display, mends: Mapping[str, list[tuple[int, int, str]]]) -> Display:
    """A display with its formulas as they are corrected."""
    latex = display.latex
    for start, end, correction in sorted(mends.get(display.latex, ()), reverse=True):
        latex = latex[:start] + correction + latex[end:]
    return display if latex == display.latex else replace(display, latex=latex)


def _worst(found: list[Examination]) -> str:
    return max((e.record.verdict for e in found), key=VERDICTS.index, default="undecided")


def _tell(found: list[Examination]) -> str:
    record = next((e.record for e in found if e.record.verdict == _worst(found)), None)
    return "no formula" if record is None else f"{record.verdict}, {record.method}"


def _same_record(old: AuditItem, item: AuditItem, work: Work) -> bool:
    """Whether every formula of a record is proved to say what it said before."""
    if len(old.formulas) != len(item.formulas):
        return False
    for before, after in zip(old.formulas, item.formulas, strict=True):
        study = work.bench.study(after.display.check(after.position))
        if _quantifiers(before) != _quantifiers(after):
            return False
        try:
            one, two = (f.tree(study.vocabulary) for f in (before, after))
        except VoronecError:
            return False
        if new_names(one, study) != new_names(two, study):
            return False
        if not same_claim(one, two, study) or (one == two and _words(before) != _words(after)):
            return False  # in the second case the reader overlooks what has changed
    return True


def _words(formula: Formula) -> list[str]:
    """The words of a formula without its brackets, of which there may be too many."""
    return [w.text for w in formula.piece.tokens if w.text not in BRACKETS]


def same_claim(old: Chain, new: Chain, study: Study) -> bool:
    """Whether two formulas are proved to claim the same: part by part, or link by link.

    What no longer says anything, because it is true off the constraints too, is not the same.
    """
    if old == new:
        return True
    if old.relations != new.relations:
        return False
    try:
        wheres = assignments(old, study)
        if wheres != assignments(new, study):
            return False
        same = all(
            _equal(a, b, study, w)
            for w in wheres
            for a, b in zip(old.parts, new.parts, strict=True)
        )
        links = list(zip(pairwise(old.parts), pairwise(new.parts), strict=True))
        if any(holds_always(*b) and not holds_always(*a) for a, b in links):
            return False
        return same or (
            set(old.relations) == {"="}
            and all(_proportional(a, b, study, w) for w in wheres for a, b in links)
        )
    except SENSELESS:
        return False


def _equal(a: Node, b: Node, study: Study, where: Mapping[str, int]) -> bool:
    if a == b:
        return True
    if isinstance(a, Integral) and isinstance(b, Integral):
        (x, one), (y, two) = integrand(a), integrand(b)
        return (x, a.lower, a.upper) == (y, b.lower, b.upper) and _equal(one, two, study, where)
    one, two = (study.motion.along(value_of(x, study, dict(where))) for x in (a, b))
    if hasattr(one, "shape") != hasattr(two, "shape"):
        return False
    if hasattr(one, "shape"):
        return one.shape == two.shape and all(
            prove_equal(x, y, study.relations).proved for x, y in zip(one, two, strict=True)
        )
    return prove_equal(one, two, study.relations).proved


def _proportional(
    old: tuple[Node, Node], new: tuple[Node, Node], study: Study, where: Mapping[str, int]
) -> bool:
    """Whether left minus right has only changed by a number, before anything is put in.

    Where both are zero then, it must be so whatever the letters mean.
    """
    (a, b), (c, d) = ([evaluate(part, study, where) for part in link] for link in (old, new))
    if len({getattr(x, "shape", ()) for x in (a, b, c, d)}) > 1:
        return False
    one, two = ([*gap] if hasattr(gap, "shape") else [gap] for gap in (a - b, c - d))
    if all(prove_equal(x, 0).proved for x in one):
        return are_multiples(*(Sum(((1, left), (-1, right))) for left, right in (old, new)))
    pairs = list(zip(one, two, strict=True))
    return any(all(prove_equal(y, k * x).proved for x, y in pairs) for k in (1, -1, 2))
