"""Sentences of the running text: what is judged is the print, and each word in a slot decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from sentence_changes import changes
from voronec.systems.demchenko.paper.kinds_of_motion import KINDS_OF_MOTION
from voronec.systems.demchenko.paper.special_solutions import SPECIAL_SOLUTIONS

from voronec.audit import (
    Display,
    FormulaRecord,
    Interval,
    Paper,
    Quoted,
    Range,
    Section,
    Sentence,
    Study,
    Transcript,
    Verdict,
    audit_paper,
    audit_section,
    formulas_by_label,
    load_paper,
)
from voronec.audit.judge import SectionContext, judge_sentence
from voronec.errors import DefinitionError

pytestmark = pytest.mark.slow


def degree(_: Study, __: Range, *, n: int, sort: bool) -> Verdict:
    """A made-up decision."""
    return Verdict("proved" if (n, sort) == (4, True) else "refuted", f"{n}, {sort}")


SENTENCE = Sentence("a @n:number{four} fold root is\n @sort:stability{stable} here", degree)


def verdict_of(sentence: Sentence, section: Section | None = None) -> tuple[str, str]:
    """Verdict and method of a sentence in a section of its own, or in a given one."""
    home = section or Section("s", (), lambda _: {"only": Study({})})
    whole = replace(home, displays=() if section is None else home.displays, inline=())
    labels = formulas_by_label([whole])
    records = audit_section(replace(whole, sentences=(sentence,)), labels=labels)
    return records[-1].verdict, records[-1].decisive.method


def test_the_marks_of_slots_are_no_part_of_the_print() -> None:
    assert SENTENCE.quotation == "a four fold root is\n stable here"
    assert SENTENCE.read({}) == {"n": 4, "sort": True}
    assert verdict_of(SENTENCE) == ("proved", "4, True")


def in_pairs(_: Study, __: Range, *, letters: tuple[str, ...]) -> Verdict:
    """A decision that takes no other number of letters."""
    first, second = letters
    return Verdict("proved" if first != second else "refuted", "two letters")


def test_what_a_decision_cannot_take_is_undecided_and_its_own_fault_an_error() -> None:
    sentence = Sentence("of @letters:names{$a$ and $b$}", in_pairs)
    assert verdict_of(sentence)[0] == "proved"
    verdict, said = verdict_of(replace(sentence, quotation="of $a$, $b$, and $c$"))
    assert verdict == "undecided"
    assert "cannot take what stands in a slot" in said
    assert "too many values" in said
    with pytest.raises(DefinitionError, match="too many values"):
        verdict_of(Sentence("of @letters:names{$a$, $b$, and $c$}", in_pairs))


@pytest.mark.parametrize(
    ("old", "new", "verdict", "said"),
    [
        ("four", "three", "misprint", "3, True"),
        ("stable", "unstable", "misprint", "4, False"),
        ("four", "fuor", "undecided", "did you mean 'four'"),
        ("root is", "root is not", "misprint", "4, False"),
        ("here", "there", "undecided", "which is not the sentence"),
    ],
)
def test_a_word_changed_in_the_print_changes_the_verdict(
    old: str, new: str, verdict: str, said: str
) -> None:
    changed = replace(SENTENCE, quotation=SENTENCE.quotation.replace(old, new))
    found = verdict_of(changed)
    assert found[0] == verdict
    assert said in found[1]


def test_line_ends_are_spaces() -> None:
    assert replace(SENTENCE, quotation=" ".join(SENTENCE.quotation.split())).read({})["n"] == 4


def ignores(_: Study, __: Range, *, n: int, sort: bool) -> Verdict:
    """Its decision does not read what stands in a slot."""
    return Verdict("proved", f"{n}")


@pytest.mark.parametrize(
    ("text", "decide", "complaint"),
    [
        (SENTENCE.text, ignores, "makes no use of the slot 'sort'"),
        ("a @n:number{four}", lambda s, r: Verdict("proved", ""), "no use of the slot 'n'"),
        ("a four", lambda s, r, *, n: Verdict("proved", str(n)), "asks for a slot 'n'; mark one"),
        ("a @n:nummer{four}", degree, "unknown; did you mean 'number'"),
        ("a @n:number{four} @n:number{two}", degree, "use it once"),
        ("a @n:number{four", degree, "do not end"),
        ("a four", None, "give it a decision, or say why there is none"),
    ],
)
def test_a_slot_that_nothing_reads_is_an_error_at_load(
    text: str, decide: Callable[..., Verdict] | None, complaint: str
) -> None:
    with pytest.raises(DefinitionError, match=complaint):
        Sentence(text, decide)


def test_what_nothing_decides_is_listed_as_such() -> None:
    sentence = Sentence("it is famous", unaudited="fame is not derived")
    assert verdict_of(sentence) == ("unaudited", "fame is not derived")


READ = [
    ("number", "Two", 2),
    ("number", "12", 12),
    ("quantifier", "In  general", "generic"),
    ("affirmed", "does not", False),
    ("affirmed", "does", True),
    ("relation", "much bigger than", None),
    ("relation", "bigger", ">"),
    ("names", r"$s_0, \tau_0$", ("s_0", r"\tau_0")),
    ("names", "$u_1$ and $v_1$", ("u_1", "v_1")),
    ("names", r"$\mathbf u$", (r"\mathbf u",)),
    ("interval", r"$x\in (x^{I}, b]$", Interval("x", "x^{I}", "b", (False, True))),
    ("interval", "$(0, 1)$", Interval("", "0", "1", (False, False))),
    ("formula", "$a=b$", Quoted("$a=b$")),
]


@pytest.mark.parametrize(("kind", "printed", "value"), READ)
def test_what_stands_in_a_slot_is_read(kind: str, printed: str, value: Any) -> None:
    sentence = Sentence(
        f"so @it:{kind}{{{printed}}} is", lambda s, r, *, it: Verdict("proved", str(it))
    )
    if value is None:
        with pytest.raises(DefinitionError, match="nothing is known of"):
            sentence.read({})
    else:
        assert sentence.read({}) == {"it": value}


def test_a_reference_is_the_formula_that_bears_the_label() -> None:
    def decide(study: Study, _: Range, *, it: Any) -> Verdict:
        (tree,) = it.trees(study)
        return Verdict("proved", f"{it.label}: {len(tree.parts)} sides")

    display = Display(r"\begin{equation}\label{e} a=a \end{equation}")
    sentence = Sentence(r"by @it:reference{\eqref{e}}", decide)
    here = Section("s", (display,), lambda _: {"only": Study({"a": 1})}, sentences=(sentence,))
    (_, record) = audit_paper(Paper("p", "P", (here,))).records
    assert record.decisive.method == "e: 2 sides"
    lost = replace(sentence, quotation=r"by \eqref{f}")
    (_, record) = audit_paper(Paper("p", "P", (replace(here, sentences=(lost,)),))).records
    assert record.verdict == "undecided"
    assert "labelled 'f'; there are: e" in record.decisive.method


SURVIVORS = {
    # False whatever is said of these precessions: n_0 is missing in print.
    ("nutation", "how"), ("nutation", "ever"), ("nutation", "sort"),
    # The contact point moves with the same speed on both spheres.
    ("smooth", "sphere"),
}  # fmt: skip


def told(record: FormulaRecord) -> tuple[Any, ...]:
    """A verdict with its reason: what is false in print already is false for another one."""
    return record.verdict, *((r["verdict"], r["method"]) for r in record.ranges), record.method


@pytest.mark.parametrize("section", [KINDS_OF_MOTION, SPECIAL_SOLUTIONS], ids=lambda s: s.title)
def test_every_slot_of_these_sections_decides(section: Section) -> None:
    transcript = Transcript(section)
    bench = SectionContext(transcript, section.studies(transcript))
    survived = set()
    for sentence in section.sentences:
        found = told(judge_sentence(sentence, bench))
        for slot, new, changed in changes(sentence):
            if told(judge_sentence(changed, bench)) == found:
                survived.add((getattr(sentence.decide, "__name__", ""), slot, new))
    assert {(name, slot) for name, slot, _ in survived} <= SURVIVORS, sorted(survived)


def test_a_paper_quotes_its_sentences() -> None:
    for section in load_paper("demchenko").sections:
        for sentence in section.sentences:
            assert replace(sentence).quotation == sentence.quotation


@pytest.mark.parametrize("label", ["text 3", "(e)", "e"])
def test_a_record_is_found_by_the_name_that_the_page_shows(label: str) -> None:
    display = Display(r"\begin{equation}\label{e} a=a \end{equation}")
    sections = tuple(
        Section(title, shown, lambda _: {"only": Study({"a": 1})}, sentences=(SENTENCE,) * 2)
        for title, shown in (("s", (display,)), ("t", ()))
    )
    found = audit_paper(Paper("p", "P", sections), label=label).records
    assert [(r.section, r.designation) for r in found] == [
        ("s", "text 3" if " " in label else "(e)")
    ]


def test_a_list_names_each_thing_once() -> None:
    sentence = Sentence("by @it:names{$a, b$} and", lambda s, r, *, it: Verdict("proved", str(it)))
    with pytest.raises(DefinitionError, match="names a twice"):
        replace(sentence, quotation="by $a, a$ and").read({})
