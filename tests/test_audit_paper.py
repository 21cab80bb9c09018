"""The whole of Demchenko's paper: which formulas are wrong, which need a convention, and that
nothing stays open."""

from __future__ import annotations

import pytest
import sympy as sp
from demchenko_audit import audit_of, paper

from voronec.audit import Display, Paper, Section, Study, audit_paper, audit_section

pytestmark = pytest.mark.slow

BODY = "The Voronec principle and rolling of a body over a surface"
GYROSCOPE = "Rolling of a body with a gyroscope"
QUADRATURES = "Solving the system in terms of elliptic functions and elliptic integrals"
INVERSION = "Inversion of elliptic integrals"
CONTEMPORARY = "Demchenko's PhD thesis and contemporary nonholonomic mechanics"

# label, or the section and the ordinal -> for ... read ...
ERRATA = {
    "kineticka": [("q^q", "q^2")],
    "kineticka*": [(r"\mathfrak w_", r"\mathfrak m_")],
    "v3": [(r"\dot q_\nu}", r"\dot q_{n+\nu}}")],
    "v4": [(r"A_j^{(\nu)}\big", r"A_i^{(\nu)}\big")],
    (BODY, 2): [(r"] +\frac{1}{2", r"] -\frac{1}{2")],
    (BODY, 7): [("^{t}", "^{t_2}"), ("]dt", "]dt=0")],
    "jednacine1": [(r"\frac{\bar{\Theta}}", r"\frac{\partial\bar{\Theta}}")],
    (BODY, 9): [
        (r"-\frac{\sin\vartheta}{\sqrt{E_1}}", r"+\frac{\sin\vartheta}{\sqrt{E_1}}"),
    ],
    (GYROSCOPE, 4): [
        (r"(n-n_1)\frac{\partial\Theta}{\partial n}", r"(n-n_1)\frac{\partial\Theta}{\partial s}"),
    ],
    (QUADRATURES, 8): [("A+1", "A+I")],
    (QUADRATURES, 9): [("2b_2Ah", "4b_2Ah")],
    (INVERSION, 4): [("(y-3", "(y^2-3"), (r"\wp''(\zeta)", r"\wp''(\zeta))")],
    (INVERSION, 7): [(r"9\wp(\zeta)", r"9\wp(\zeta)^2")],
    "v4*": [(r"\frac{\partial L}{\partial q_", r"\frac{\partial L}{\partial \dot q_")],
}
CONVENTIONS = {
    "eq:elliptic1": "(4.4.13)",
    (INVERSION, 6): r"\sqrt{X}",
    (CONTEMPORARY, 2): "v4*",
    "v5*": "v4*",
}
IN_WORDS = {
    r"where $\psi$ is also a quadratic polynomial": {"inner rolling", "shell rolling"},
    "where $X(x)$ is a degree four polynomial": {"inner rolling", "shell rolling"},
    "Such motion is always stable": {"inner rolling", "shell rolling"},
    "The first case would not produce any real motion": set(),
}


@pytest.fixture(scope="module")
def audit():
    return audit_of(*paper().sections)


def test_the_audit_of_a_paper_is_that_of_its_sections():
    names = {n: sp.Symbol(n) for n in "xy"}
    first, second = (
        Section(title, (Display(f"$x+y={sum}$"),), lambda _: {"one": Study(names)})
        for title, sum in (("first", "y+x"), ("second", "y-x"))
    )
    found = audit_paper(Paper("two", "Two sections", (first, second)))
    assert found.records == (*audit_section(first), *audit_section(second))
    assert [r.verdict for r in found.records] == ["proved", "misprint"]


def place(record):
    return record.label or (record.section, record.ordinal)


def displays(audit, verdict):
    return [r for r in audit.records if r.kind == "display" and r.verdict == verdict]


def test_the_errata_are_these_and_each_is_the_smallest_true_change(audit):
    found = {place(r): r for r in displays(audit, "misprint")}
    assert found.keys() == ERRATA.keys()
    for where, changes in ERRATA.items():
        wrong = [f for f in found[where].formulas if f.verdict == "misprint"]
        for formula in wrong:
            mended = formula.printed
            for old, new in changes:
                assert old in mended, where
                head, _, tail = (
                    mended.rpartition(old) if where == (INVERSION, 4) else (mended.partition(old))
                )
                mended = head + new + tail
            assert formula.correction == mended
            assert "is proved" in formula.method


def test_every_misprint_has_a_witness_but_for_what_is_only_left_out(audit):
    for record in displays(audit, "misprint"):
        for formula in record.formulas:
            if formula.verdict == "misprint" and place(record) != (BODY, 7):
                assert formula.witness["printed"] != formula.witness["derived"]


def test_conventions_name_what_contradicts_them(audit):
    found = {place(r): r.decisive.method for r in displays(audit, "convention")}
    assert found.keys() == CONVENTIONS.keys()
    for where, text in CONVENTIONS.items():
        assert text in found[where]


def test_sentences_of_the_text_hold_where_they_are_said_to(audit):
    for start, elsewhere in IN_WORDS.items():
        (record,) = (r for r in audit.records if r.printed.startswith(start))
        assert record.verdict == "proved"
        by_range = {e["range"]: e["verdict"] for e in record.decisive.ranges}
        assert by_range["outer rolling"] == "proved"
        assert {name for name, verdict in by_range.items() if verdict == "refuted"} == elsewhere
        assert ("does not extend to inner rolling" in record.decisive.method) == bool(elsewhere)


def test_nothing_is_undecided_and_little_is_only_quoted(audit):
    assert not [place(r) for r in audit.records if r.verdict == "undecided"]
    cited = [r for r in audit.records if r.verdict == "cited"]
    assert [place(r) for r in cited if r.kind == "display"] == ["eq:lawmoments", "Jacobi2"]
    said = [r.printed[:16] for r in cited if r.kind == "text" and "caption" not in r.printed]
    assert said == ["the Abel theorem", "In the case of i"]
    # of the caption of a figure the curve is audited, and the rest quoted
    assert sum(r.printed.startswith(r"\caption") for r in cited) == 9
    stated = [r for r in audit.records if r.kind == "text" and not r.formulas[0].printed]
    unaudited = [r for r in stated if r.verdict == "unaudited"]
    assert len(stated) > 100
    assert 10 * len(unaudited) <= len(stated)
    assert sum(r.kind == "display" for r in audit.records) == 96
