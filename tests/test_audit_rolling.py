"""The sections on rolling bodies: which of their formulas are wrong, and that a change shows."""

from __future__ import annotations

from dataclasses import replace

import pytest
from demchenko_audit import records_of
from voronec.systems.demchenko.paper.body import BODY
from voronec.systems.demchenko.paper.gyroscope import GYROSCOPE
from voronec.systems.demchenko.paper.neumann import NEUMANN
from voronec.systems.demchenko.paper.voronec_principle import VORONEC_PRINCIPLE

from voronec.audit import audit_section

pytestmark = pytest.mark.slow


def test_verdicts_on_neumanns_variables():
    found = records_of(NEUMANN.title)
    wrong = {record.label: record.formulas[0] for record in found if record.verdict == "misprint"}
    assert set(wrong) == {"kineticka", "kineticka*", None}
    assert "+Bq^2+" in wrong["kineticka"].correction
    assert r"\mathfrak m_\mathbf v" in wrong["kineticka*"].correction
    assert {r.verdict for r in found} == {"misprint", "proved", "definition", "cited", "unaudited"}
    (letter,) = (r for r in found if r.verdict == "misprint" and r.kind == "text")
    assert letter.printed.startswith("the kinetic energy written in terms of")


def test_verdicts_on_the_voronec_principle():
    found = records_of(VORONEC_PRINCIPLE.title)
    assert [r.verdict for r in found[8:10]] == ["definition", "proved"]
    assert [r.verdict for r in found[10:]] == ["proved", "misprint", *["proved"] * 4]


def test_verdicts_on_the_rolling_body():
    found = [record.formulas for record in records_of(BODY.title)]
    assert [[f.verdict for f in formulas] for formulas in found[:6]] == [
        ["definition", "definition"],
        ["convention", "misprint"],
        ["proved", "proved"],
        ["proved", "proved"],
        ["proved"],
        ["definition", "definition"],
    ]
    assert r"-\frac{1}{2\sqrt{E_1G_1}}\frac{\partial G_1}{\partial u_1}" in found[1][1].correction
    for formula in found[7]:
        assert formula.verdict == "misprint"
        assert r"\frac{d}{dt}\frac{\partial\bar{\Theta}}{\partial" in formula.correction
    assert [f.verdict for f in found[8]] == ["proved", "misprint"]
    assert r"}+\frac{\sin\vartheta}{\sqrt{E_1}}" in found[8][1].correction
    assert [f.verdict for f in found[9]] == ["definition"]
    assert [f.verdict for f in found[10]] == ["proved", "misprint", "proved"]
    assert {formulas[0].verdict for formulas in found[11:]} == {"proved"}


def test_verdicts_on_the_gyroscope():
    found = [record.formulas for record in records_of(GYROSCOPE.title)]
    assert [f.verdict for f in found[3]] == ["proved", "misprint", "proved"]
    assert r"+(n-n_1)\frac{\partial\Theta}{\partial s}-" in found[3][1].correction
    others = {f.verdict for formulas in (*found[:3], *found[4:]) for f in formulas}
    assert others == {"proved", "definition"}


MOVED = (
    (NEUMANN, "inline", "D_1'=0", "D_1''=0"),
    (NEUMANN, "displays", r"\dot{\mathbf G}^{(M)}", r"\dot{\tilde{\mathbf G}}^{(M)}"),
    (GYROSCOPE, "displays", r"-\mathfrak v_\mathbf n\frac", r"+\mathfrak v_\mathbf n\frac"),
    (GYROSCOPE, "inline", r"\kappa =k", r"\kappa =-k"),
    (VORONEC_PRINCIPLE, "inline", r"q_s,\dot q_s", "q_s"),
)


@pytest.mark.usefixtures("no_corrections")
@pytest.mark.parametrize(("section", "kind", "old", "new"), MOVED)
def test_what_is_printed_is_what_is_compared(section, kind, old, new):
    (display,) = (d for d in getattr(section, kind) if old in d.latex)
    changed = replace(display, latex=display.latex.replace(old, new, 1))
    alone = {"displays": (), "inline": (), "sentences": (), kind: (changed,)}
    if section is VORONEC_PRINCIPLE:
        alone["displays"] = section.displays[:2]  # its dictionary is made from its constraints
    found = audit_section(replace(section, **alone))
    verdicts = {f.verdict for record in found for f in record.formulas if record.kind == "text"}
    if kind == "displays":
        verdicts = {f.verdict for record in found for f in record.formulas}
    assert verdicts & {"misprint", "undecided"}
