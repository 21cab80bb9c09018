"""Two sections of Demchenko's paper: the Voronec principle and the ball on a sphere.

Two misprints are found, and no other formula is called wrong.
"""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from demchenko_audit import audit_of, has_formula
from demchenko_audit import paper as whole

from voronec import DefinitionError
from voronec.audit import Display, Paper, Transcript, audit_paper, load_paper

pytestmark = pytest.mark.slow

VORONEC, BALL = 0, 1


@pytest.fixture(scope="module")
def paper():
    kept = [s for s in whole().sections if s.label in ("VorPr", "ballGyr")]
    return replace(whole(), sections=tuple(replace(s, sentences=()) for s in kept))


@pytest.fixture(scope="module")
def audit(paper):
    found = audit_of(*paper.sections)
    return replace(found, records=tuple(filter(has_formula, found.records)))


@pytest.fixture(scope="module")
def prepared(paper):
    """Sections whose dictionaries are made once, for many trials."""
    made = []
    for section in paper.sections:
        studies = section.studies(Transcript(section))
        made.append(replace(section, studies=lambda _, studies=studies: studies))
    return made


def record(audit, label=None, section=BALL, ordinal=None):
    title = audit.sections[section]
    for found in audit.records:
        if (
            found.section == title
            and label in (None, found.label)
            and ordinal in (None, found.ordinal)
        ):
            return found
    raise AssertionError(f"no record {label or ordinal}")


def test_every_display_of_both_subsections_has_its_record(audit):
    displays = [r for r in audit.records if r.kind == "display"]
    labels = [r.label for r in displays]
    assert labels[:8] == ["v1", "v2", "v3", "v4", None, "v5", "v6", None]
    assert labels[8:] == [
        *("uslovZh", None, "4.2.2", "4.2.789", None, "kinMod**", None),
        *("kinMod*", "GMConst", None, "integrali", "4.3.131415"),
    ]
    assert [len(r.formulas) for r in displays[8:]] == [1, 6, 2, 3, 2, 3, 1, 1, 1, 3, 3, 3]


def test_the_misprints_are_those_of_v3_and_v4_and_nothing_stays_open(audit):
    assert [r.label for r in audit.errata] == ["v3", "v4"]
    counts = audit.count()
    assert (counts["undecided"], counts["convention"], counts["cited"]) == (0, 0, 0)


def test_v3_needs_the_velocity_of_the_fibre(audit):
    formula = record(audit, "v3", VORONEC).decisive
    assert r"\frac{\partial T}{\partial \dot q_\nu}" in formula.printed
    assert formula.correction == formula.printed.replace(r"\dot q_\nu", r"\dot q_{n+\nu}")


def test_v4_needs_the_free_index(audit):
    formula = record(audit, "v4", VORONEC).decisive
    assert formula.correction == formula.printed.replace("A_j^", "A_i^")
    assert "nothing binds the index j" in formula.method
    assert formula.witness["indices"] == {"i": 1, "j": 2}
    assert "K_{1}" in formula.derived
    assert "A_{12}^{(1)}" in formula.derived
    assert "A_{1}^{(1)}" in formula.derived


@pytest.mark.parametrize("label", ["v5", "4.2.2", "4.2.789", "kinMod**", "kinMod*", "GMConst"])
def test_claims_are_proved(audit, label):
    found = next(r for r in audit.records if r.label == label)
    assert found.verdict == "proved"


def test_the_equations_of_motion_are_proved_for_ball_and_rotor_and_for_the_reduced_system(audit):
    for formula in record(audit, "4.3.131415").formulas:
        assert formula.verdict == "proved"
        assert "compared with the derived equation of motion" in formula.method
        assert "proved for 'zhukovsky' too" in formula.method


def test_definitions_name_their_uses(audit):
    assert record(audit, "uslovZh").verdict == "definition"
    assert "(kinMod*)" in record(audit, "uslovZh").decisive.method
    assert "(v4) as corrected" in record(audit, "v1", VORONEC).decisive.method
    assert "(v5)" in record(audit, "v6", VORONEC).decisive.method


def test_what_is_printed_is_the_transcription(audit, paper):
    source = flat("".join(d.latex for s in paper.sections for d in (*s.displays, *s.inline)))
    for found in audit.records:
        for formula in found.formulas:
            assert flat(formula.printed) in source


def flat(latex: str) -> str:
    """Without spacing, alignment, labels and line ends."""
    return re.sub(r"\s|&|\\nonumber|\\label\{[^}]*\}|\\\\", "", latex)


def trial(prepared, section, old, new, label=None):
    """The records of one display of the paper with one change in it."""
    (display,) = [
        d
        for d in prepared[section].displays
        if old in d.latex and (label is None or f"{{{label}}}" in d.latex)
    ]
    changed = replace(display, latex=display.latex.replace(old, new, 1))
    others = tuple(changed if d is display else d for d in prepared[section].displays)
    studies = prepared[section].studies
    alone = replace(prepared[section], displays=(changed,), studies=studies)
    kept = [d for d in others if d is not changed and _defines(d)]
    alone = replace(alone, displays=(*kept, changed))
    records = audit_paper(Paper("trial", "", (alone,))).records
    return [r for r in records if r.kind == "display"][-1]


def _defines(display: Display) -> bool:
    return any(label in display.latex for label in ("uslovZh", "kinMod**", "C_2r_2"))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (r"-\mu'\dot{u}\sin\vartheta", r"+\mu'\dot{u}\sin\vartheta"),
        (r"\dot{u}_1=-\mu'", r"\dot{u}_1=-\mu"),
        (r"\alpha_1''=\sin u_1\sin\vartheta", r"\alpha_1''=\sin u\sin\vartheta"),
        (r"=P s-k\sin u", r"=A s-k\sin u"),
        (r"=k\mu\dot u\cos u", r"=k\mu\dot v\cos u"),
    ],
)
def test_an_error_put_into_a_proved_formula_is_found_and_mended(prepared, old, new):
    found = trial(prepared, BALL, old, new)
    assert found.verdict == "misprint"
    assert found.decisive.witness["printed"] != found.decisive.witness["derived"]
    assert found.decisive.correction is not None


@pytest.mark.usefixtures("no_corrections")
@pytest.mark.parametrize(
    ("old", "new"),
    [
        (r"-\big(\frac{\partial a_{\nu j}}", r"-\big(\frac{\partial a_{\nu i}}"),
        (r"\delta q_{n+\nu}=", r"\delta q_{n+\nu}=-"),
        (r"-\delta\dot q_{n+\nu}", r"+\delta\dot q_{n+\nu}"),
    ],
)
def test_an_error_in_the_voronec_principle_is_found(prepared, old, new):
    section = prepared[VORONEC]
    (display,) = [d for d in section.displays if old in d.latex]
    changed = replace(display, latex=display.latex.replace(old, new, 1))
    alone = replace(section, displays=(changed,))
    (found,) = (r for r in audit_paper(Paper("trial", "", (alone,))).records if r.kind == "display")
    assert found.verdict == "misprint"


@pytest.mark.usefixtures("no_corrections")
def test_without_zhukovskys_condition_the_energy_and_the_equations_are_false(prepared):
    section = prepared[BALL]
    changed = tuple(
        replace(d, checks=tuple(replace(c, given=(), also=(), study="rotor") for c in d.checks))
        for d in section.displays
        if _defines(d) or "{kinMod*}" in d.latex or "4.3.131415" in d.latex
    )
    records = audit_paper(Paper("trial", "", (replace(section, displays=changed),))).records
    verdicts = {r.label: [f.verdict for f in r.formulas] for r in records}
    assert verdicts["kinMod*"] == ["misprint"]
    assert set(verdicts["4.3.131415"]) == {"misprint"}
    assert "proved" in verdicts["kinMod**"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (r"$P=I+A$", r"$P=I-A$"),
        (r"$\mu'=\frac{R_2}{R_1}$", r"$\mu'=\frac{R_1}{R_2}$"),
        (r"=1+\mu'", r"=1-\mu'"),
        (r"C_2r_2=k", r"C_1r_2=k"),
    ],
)
def test_a_wrong_definition_is_the_misprint_and_not_what_uses_it(prepared, old, new):
    def changed(displays):
        return tuple(replace(d, latex=d.latex.replace(old, new)) for d in displays)

    section = prepared[BALL]
    broken = replace(section, displays=changed(section.displays), inline=changed(section.inline))
    records = audit_paper(Paper("trial", "", (broken,))).records
    wrong = [f for r in records for f in r.formulas if f.verdict == "misprint"]
    assert [new.strip("$") in f.printed for f in wrong] == [True]
    assert wrong[0].correction is not None


def test_progress_is_told_unit_by_unit(prepared):
    seen = []
    section = replace(prepared[VORONEC], displays=prepared[VORONEC].displays[:2], inline=())
    audit_paper(
        Paper("trial", "", (section,)), lambda label, verdict: seen.append((label, verdict))
    )
    assert seen == [("(v1)", "definition"), ("(v2)", "definition"), ("(v3)", "misprint")]


def test_an_unknown_paper_is_refused():
    with pytest.raises(DefinitionError, match="there is no paper 'demchenco'; did you mean"):
        load_paper("demchenco")
