"""Inequalities and claims in words: decided range by range, with a witness where they fail."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec.audit import (
    Check,
    Display,
    Paper,
    Range,
    Section,
    Sentence,
    Study,
    Verdict,
    audit_paper,
)

pytestmark = pytest.mark.slow

a, b, p = sp.symbols("a b p")
P, B = sp.symbols("P B", positive=True)
UP = Range("up", "a>1", {a: 1 + P, b: B}, (P, B))
DOWN = Range("down", "0<a<1", {a: 1 / (1 + P), b: B}, (P, B))


def records(*displays, sentences=(), ranges=(UP, DOWN)):
    study = Study({"a": a, "b": b, "c": a * b}, ranges=ranges)
    section = Section("s", displays, lambda _: {"only": study}, sentences=sentences)
    return audit_paper(Paper("p", "A paper", (section,))).records


def one(latex, check=None, **more):
    (record,) = records(Display(f"${latex}$", (check or Check(),)), **more)
    return record.formulas[0]


def verdicts(formula):
    return {entry["range"]: entry["verdict"] for entry in formula.ranges}


def test_an_inequality_that_holds_in_every_range_is_proved():
    formula = one("c+1>c")
    assert formula.verdict == "proved"
    assert verdicts(formula) == {"up": "proved", "down": "proved"}


def test_an_inequality_that_holds_only_in_the_range_of_the_paper_is_a_convention():
    formula = one("c>b")
    assert formula.verdict == "convention"
    assert verdicts(formula) == {"up": "proved", "down": "refuted"}
    assert "true for up, false for down" in formula.method


def test_a_sentence_that_names_its_range_is_judged_there():
    formula = one("c>b", Check(within=("up",)))
    assert (formula.verdict, verdicts(formula)) == ("proved", {"up": "proved"})


def test_a_false_inequality_has_a_witness_that_can_be_checked():
    formula = one("c<b")
    assert formula.verdict == "misprint"
    point = {s: sp.Rational(formula.witness["point"][str(s)]) for s in (P, B)}
    values = [e.xreplace(UP.values).xreplace(point) for e in (a * b, b)]
    assert values[0] >= values[1]


def test_every_link_of_a_mixed_chain_counts():
    assert one("c+2>c+1=1+c", Check(within=("up",))).verdict == "proved"
    assert one("c+2>c+1=2+c", Check(within=("up",))).verdict == "misprint"
    assert one("c+1>c+2=2+c", Check(within=("up",))).verdict == "misprint"


def test_a_claim_in_words_is_a_record_of_the_text():
    def decide(study: Study, where: Range) -> Verdict:
        return Verdict("proved" if where.name == "up" else "refuted", "as it is")

    (record,) = records(sentences=(Sentence("$a$ is large", decide, derived=lambda study: "a>1"),))
    assert (record.kind, record.printed, record.label) == ("text", "$a$ is large", None)
    assert record.verdict == "convention"
    assert record.as_dict()["derived"] == "a>1"


def test_a_claim_that_fails_where_the_paper_makes_it_is_an_error_of_the_paper():
    (record,) = records(
        sentences=(Sentence("$a$ is small", lambda s, r: Verdict("refuted", "no")),)
    )
    assert record.verdict == "misprint"


@pytest.mark.parametrize("verdict", ["proved", "refuted", "undecided"])
def test_a_display_may_be_a_condition_within_a_sentence(verdict):
    check = Check(decide=lambda s, r: Verdict(verdict, "by hand"), says="stable where $a>0$")
    formula = one("a>0", check, ranges=())
    expected = {"proved": "proved", "refuted": "misprint", "undecided": "undecided"}
    assert formula.verdict == expected[verdict]
    assert formula.says == "stable where $a>0$"
