"""The section on contemporary mechanics: what is proved, what is not, and that changes are seen."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import sympy as sp
from demchenko_audit import has_formula, labels, records_of
from voronec.systems.demchenko.dictionary.chaplygin_balls import (
    CONFIGURATIONS,
    GAMMA,
    KAPPA,
    OMEGA,
    R1,
    R2,
    SIGNED_RADIUS,
    Ball,
    D,
    tensor,
)
from voronec.systems.demchenko.dictionary.gyroscopic_balls import is_demchenkos
from voronec.systems.demchenko.dictionary.reductions import DELTA, DX, Chaplygin, acts
from voronec.systems.demchenko.dictionary.rubber_balls import Rubber
from voronec.systems.demchenko.dictionary.verdicts import worst
from voronec.systems.demchenko.paper.contemporary import CONTEMPORARY, studies

import voronec as vo
from voronec.audit import Display, Paper, Section, audit_paper, audit_section

pytestmark = pytest.mark.slow

EXPECTED = {
    2: "convention",
    4: "misprint",
    5: "convention",
    6: "definition",
    7: "definition",
    9: "cited",
}


@cache
def dictionaries():
    return studies(None)


def audit(displays=(), inline=(), sentences=()):
    section = replace(
        CONTEMPORARY,
        displays=tuple(displays),
        inline=tuple(inline),
        sentences=tuple(sentences),
        studies=lambda _: dictionaries(),
    )
    return audit_section(section, labels=labels())


def everything():
    """The records of the whole section."""
    return records_of(CONTEMPORARY.title)


def found(fragment):
    """The display or formula of the text that holds a fragment."""
    everything = (*CONTEMPORARY.displays, *CONTEMPORARY.inline)
    (display,) = [d for d in everything if fragment in d.latex]
    return display


DEFINED = [d for d in CONTEMPORARY.inline if r"=\mathbb I+D" in d.latex or "=\\mathbf M" in d.latex]


def changed(fragment, before, after):
    """The verdicts of the formulas of a display in which something is changed."""
    display = found(fragment)
    assert before in display.latex
    latex = display.latex.replace(before, after, 1)
    section = Section(
        "s",
        (Display(latex, tuple(replace(c, convention=None) for c in display.checks)),),
        lambda _: dictionaries(),
        inline=tuple(d for d in DEFINED if d is not display),
        complete=True,
    )
    return [f.verdict for f in audit_paper(Paper("p", "A paper", (section,))).records[0].formulas]


def test_the_displays_have_these_verdicts():
    records = [r for r in everything() if r.kind == "display"]
    for number, record in zip(range(1, 18), records, strict=True):
        assert record.verdict == EXPECTED.get(number, "proved"), (number, record)


def test_the_formulas_of_the_text_are_proved_or_definitions():
    of_text = [r for r in everything() if r.kind == "text" and has_formula(r)]
    records = [r for r in of_text if "lambda" not in r.printed]
    assert len(records) == len(of_text) - 1
    assert {r.verdict for r in records} == {"proved", "definition"}
    assert sum(r.verdict == "proved" for r in records) == 7


def test_every_sentence_but_one_is_proved_in_every_configuration():
    records = [r for r in everything() if not has_formula(r)]
    assert len(records) == len(CONTEMPORARY.sentences)
    others = [(r.verdict, " ".join(r.printed.split())) for r in records if r.verdict != "proved"]
    assert [verdict for verdict, _ in others] == [
        *("misprint", "cited", *("unaudited",) * 5, "misprint", "unaudited", "unaudited"),
    ]
    assert "tensor field" in others[0][1]
    assert r"rolling without slipping over the \begin" in others[-3][1]
    ranged = [r.formulas[0].ranges for r in records if r.formulas[0].ranges]
    assert sorted(map(len, ranged)) == [1, *[3] * 4]
    assert {x["verdict"] for ranges in ranged for x in ranges} == {"proved"}


def test_a_vector_of_constants_keeps_no_derivative_from_print():
    (record,) = [r for r in everything() if r.label == "cl:int*"]
    rates = [rf"\frac{{d}}{{dt}}F_{number} = 0" for number in range(1, 5)]
    assert [f.derived for f in record.formulas] == rates


@pytest.mark.parametrize("turning", [0, 1])
def test_jk_is_quadratic_in_its_first_argument_and_comes_from_three_slots(turning):
    system = Chaplygin.derive(turning)
    assert acts(turning).proved
    x, delta = sp.Matrix(DX), sp.Matrix(DELTA)
    force, scale = system.force(x, delta), sp.Symbol("scale")
    assert vo.prove_equal(system.force(scale * x, delta), scale**2 * force).proved
    assert vo.prove_equal(system.force(x, scale * delta), scale * force).proved
    assert system.bilinear().refuted
    assert r"\Sigma(X,X,Y)" in system.three_slots()


def test_the_sentence_on_jk_is_refuted_with_a_witness():
    (record,) = (r for r in everything() if not has_formula(r) and "tensor" in r.printed)
    (formula,) = record.formulas
    assert formula.verdict == "misprint"
    assert formula.witness["printed"] != formula.witness["derived"]
    assert r"\Sigma(X,Y,Z)" in formula.derived


@pytest.mark.parametrize(
    ("kind", "verdict"),
    [
        ("(0, 2)", "misprint"),
        ("(0,3)", "proved"),
        ("(1,1)", "misprint"),
        ("(2,0)", "misprint"),
        ("(1,2)", "misprint"),
        ("(3,0)", "misprint"),
        ("(a,b)", "undecided"),
    ],
)
def test_the_kind_of_a_tensor_is_a_pair_and_not_its_sum(kind, verdict):
    (sentence,) = [s for s in CONTEMPORARY.sentences if "tensor field" in s.quotation]
    quotation = sentence.quotation.replace("(0,2)", kind)
    (record,) = audit(sentences=[replace(sentence, quotation=quotation)])
    assert record.verdict == verdict
    assert "cannot take" not in record.decisive.method


def test_nothing_compared_is_nothing_proved():
    assert worst([]).undecided
    assert worst([vo.prove_equal(1, 1), vo.prove_equal(1, 2), vo.prove_equal(1, 1)]).refuted


def test_a_dot_is_missing_in_the_voronec_equations():
    (record,) = (r for r in everything() if r.label == "v4*")
    (formula,) = record.formulas
    assert formula.verdict == "misprint" and formula.witness
    assert r"\frac{\partial L}{\partial \dot q_{n+\nu}} B_{ij}^{\nu}" in formula.correction


def test_the_multiplier_of_the_rubber_ball_is_misprinted():
    """As printed it vanishes; gamma belongs where the first G stands."""
    (record,) = (r for r in everything() if has_formula(r) and r.printed.startswith(r"\lambda=-"))
    (formula,) = record.formulas
    assert formula.verdict == "misprint"
    assert formula.correction.startswith(r"\lambda=-(\gamma,\mathbf I^{-1}(\mathbf G\times")
    rubber = Rubber.on_sphere(R1)
    spin, momentum = rubber.motion.restrict(OMEGA), rubber.momentum
    printed = momentum.dot(tensor().inv() * momentum.cross(spin))
    assert vo.prove_equal(printed, 0, rubber.relations).proved
    assert vo.prove_equal(rubber.multiplier, 0, rubber.relations).refuted


def test_what_is_derived_for_a_power_is_printed_without_factors_that_cancel():
    (record,) = (r for r in everything() if r.printed.startswith(r"\mu_\epsilon(\gamma)="))
    (formula,) = record.formulas
    assert formula.verdict == "proved"
    assert formula.derived.endswith(r"\right)^{\frac{1}{2 \epsilon}}")


def test_one_sign_of_the_curvature_is_against_the_other():
    """With the other sign both formulas hold, without any further convention."""
    displays = [r for r in everything() if r.kind == "display"]
    for fragment, before, after in (
        ("B(X,Y)=-A", "=-A", "=A"),
        ("v5*", r"=\mathbb", r"=-\mathbb"),
    ):
        (record,) = (r for r in displays if r.label == fragment or fragment in r.printed)
        assert "against" in record.formulas[0].method
        assert changed(fragment, before, after) == ["proved"]


BROKEN = [
    (r"\oplus", r"\oplus \mathcal V_q", r"\oplus \mathcal D_q"),
    (r"\longmapsto", "dq_{n+\\nu}-", "dq_{n+\\nu}+"),
    (r"\longmapsto", r"\sum_{1\le i<j\le n}", r"\sum_{1\le i\le j\le n-1}"),
    (r"\longmapsto", "= - \\big(".replace("= -", "=  -"), "=  \\big("),
    (r"B_{ij}^\nu=-A", "=-A", "=A"),
    ("ChaplyginRed", "= JK", "=- JK"),
    ("ChaplyginRed", r"JK(\dot x,\delta x)", r"JK(\delta x,\dot x)"),
    ("ChaplyginRed", r"JK(\dot x", r"JK(2\dot x"),
    ("$Q_s", "=-", "="),
    ("$Q_s", "=-", "=-7"),
    ("$Q_s", r"\partial q_s", r"\partial\dot q_s"),
    (r"=\Theta-V", r"\dot q^h", r"\dot q"),
    (r"\in \mathcal D_q", r"\mathcal D_q", r"\mathcal V_q"),
    (r"\in \mathcal D_q", r"\delta q_s", r"7\delta q_s"),
    (r"B^\nu(\dot q", r"B^\nu(\dot q,\delta q)", r"B^\nu(\delta q,\dot q)"),
    (r"B^\nu(\dot q", r"FL( B(\dot q,\delta q))=\sum", r"FL( B(\delta q,\dot q))=\sum"),
    ("Jacobi2", r"\omega_1/", r"\omega_2"),
    ("Jacobi2", r"=\omega_m/", r"=-\omega_m/"),
    ("Jacobi2", r"\Phi>0", r"\Phi<0"),
    ("Epsilon", r"\pm", r"\mp"),
    (r"\label{Chap}", r"{\mathbf G}\times\omega", r"\omega\times{\mathbf G}"),
    (r"\label{Chap}", r"\epsilon", r"\epsilon^2"),
    ("mu-ch", r"-D\mathbf", r"+D\mathbf"),
    ("mu-ch", r"\sqrt{", r"2\sqrt{"),
    (r"\tilde F_4", "I_2+I_3-I_1", "I_2-I_3+I_1"),
    ("e3a", r"+\lambda", r"-\lambda"),
    (r"\label{Chap*}", r"+\kappa", r"-\kappa"),
    ("cl:int*", r"\kappa,\gamma", r"2\kappa,\gamma"),
    (r"\mu_\epsilon", r"{2\epsilon}", r"{\epsilon}"),
    (r"D\omega-D (", "-D (", "+D ("),
]


@pytest.mark.usefixtures("no_corrections")
@pytest.mark.parametrize("case", BROKEN, ids=lambda c: f"{c[0]}: {c[2]}")
def test_a_changed_formula_is_not_proved(case):
    assert "misprint" in changed(*case)


def test_a_ball_on_a_sphere_has_no_more_than_three_of_the_integrals():
    ball = Ball.on_sphere(SIGNED_RADIUS, KAPPA)
    assert ball.constants(["F_1", "F_2", "F_3"]).proved
    for where in CONFIGURATIONS:
        assert ball.constant(ball.integrals["F_4"], where).refuted
    assert Ball.on_plane(KAPPA).constant(ball.integrals["F_4"]).proved
    free = Ball.on_sphere(-R2 / 2)
    assert free.constant(free.weighted_momentum).proved
    assert Ball.on_sphere(-R2 / 3).constant(free.weighted_momentum).refuted
    with_rotor = Ball.on_sphere(-R2 / 2, KAPPA)
    assert with_rotor.constant(with_rotor.weighted_momentum).refuted


def test_the_printed_density_needs_a_unit_vector():
    ball = Ball.on_plane()
    assert ball.wider_density()
    momentum = tensor() * OMEGA - D * OMEGA.dot(GAMMA) * GAMMA
    turned = GAMMA.cross(OMEGA)
    right = momentum.cross(OMEGA) - momentum.jacobian(GAMMA) * turned
    rates = momentum.jacobian(OMEGA).LUsolve(right)
    printed = sp.sqrt((GAMMA - D * tensor().inv() * GAMMA).dot(GAMMA))
    flow = zip((*GAMMA, *OMEGA), (*turned, *rates), strict=True)
    growth = sum(sp.diff(printed * rate, x) for x, rate in flow)
    assert vo.prove_equal(growth, 0, [GAMMA.dot(GAMMA) - 1]).proved
    assert vo.prove_equal(growth, 0).refuted


@pytest.mark.parametrize(
    ("fragment", "before", "after", "verdict"),
    [
        ("label{mu-ch}", r"\mu(\gamma)", r"\mu(\omega)", "misprint"),  # it depends on gamma
        (r"\mu_\epsilon(\gamma)", r"\mu_\epsilon(\gamma)", r"\mu_\epsilon(\omega)", "misprint"),
        (
            "label{cl:int}",
            r"({\mathbf G},{\mathbf G})",
            r"({\mathbf G}+\kappa,{\mathbf G})",
            "misprint",
        ),
        (r"$D=", "=", "=2", "misprint"),
        (r"\mathbb I=", "I_3", "I_2", "misprint"),
        (r"\mathbb E=", "1,1,1", "1,1,2", "misprint"),
        ("label{e3a}", r"(\omega,\gamma)=0", r"(\gamma,\gamma)=1", "misprint"),
        ("label{ChaplyginRed}", "T_x S", "T_x Q", "misprint"),
        ("label{ChaplyginRed}", r"for\;all", r"for\;some", "misprint"),
        ("label{Jacobi2}", r"\dot\varphi_1", r"\dot g_1", "misprint"),
        (r"\longmapsto", r"(q_1,\dots,q_n),\\", r"(q_1,\dots,q_k),\\", "misprint"),
    ],
)
def test_what_was_not_read_before_is_read(fragment, before, after, verdict):
    assert verdict in changed(fragment, before, after)


@pytest.mark.parametrize("kind", ["outer", "plane with gyroscope"])
def test_integrals_that_are_listed_are_independent(kind):
    ball = dictionaries()[kind].context
    assert ball.independent(["F_1", "F_2", "F_3", "F_4"]).proved
    doubled = replace(ball, more={"F_5": ball.integrals["F_1"] * ball.integrals["F_2"]})
    assert not doubled.independent(["F_1", "F_2", "F_5"]).proved


@pytest.mark.parametrize(
    ("beginning", "before", "after", "verdict"),
    [
        ("There are", "three", "two", "misprint"),
        ("(ii) rolling", "inner", "outer", "misprint"),
        ("(ii) rolling", "R_1>R_2", "R_1<R_2", "misprint"),
        ("(ii) rolling", "(ii)", "(iii)", "misprint"),
        ("the equations of motion of", "orthogonal", "parallel", "misprint"),
        ("The problem is integrable", "Euler-Jacobi", "Liouville", "undecided"),
        ("Markeev", "integrable", "nonintegrable", "misprint"),
        ("Markeev", "a plane", "a sphere", "undecided"),  # nobody knows
        ("The system is integrated", "-1}(0)", "-1}(1)", "misprint"),
        (r"For $\epsilon=1$", r"\epsilon=1", r"\epsilon=-1", "misprint"),
        (r"For $\epsilon=1$", r"\epsilon=1", r"\epsilon=2", "misprint"),
        (r"For $\epsilon=1$", r"\epsilon=1", r"\epsilon=0", "undecided"),  # there is no such ball
        (r"For $\epsilon=1$", "({\\mathbf\nG}", "F_4({\\mathbf G}", "undecided"),  # which one?
        (r"For $\epsilon=1$", "=({\\mathbf\nG},\\gamma)", "", "undecided"),
    ],
)
def test_a_word_changed_in_a_sentence_is_seen(beginning, before, after, verdict):
    (sentence,) = [s for s in CONTEMPORARY.sentences if s.quotation.startswith(beginning)]
    assert before in sentence.quotation
    quotation = sentence.quotation.replace(before, after)
    records = audit(sentences=[sentence, replace(sentence, quotation=quotation)])
    assert [r.verdict for r in records] == ["proved", verdict]


def test_zhukovskys_condition_makes_the_moments_of_demchenkos_ball_equal():
    first, second = sp.symbols("A1 A2", positive=True)
    system = vo.load("demchenko")
    assert is_demchenkos(system, first + second).proved
    for other in (first - second, first, 2 * second):
        assert is_demchenkos(system, other).refuted
