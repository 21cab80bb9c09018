"""The machine that puts errors into a paper: what it makes, and what it says of an audit."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp
from tool_modules import tool

import voronec as vo
from voronec.audit import Check, Display, Motion, Section, Study

pytestmark = pytest.mark.slow

latex_errors = tool("papers.latex_errors")
english_errors = tool("papers.english_errors")
paper_trials = tool("papers.trials")
proposals = tool("papers.proposals")


def made(latex, kind):
    return {slip.latex for slip in latex_errors.slips(latex) if slip.kind == kind}


@pytest.mark.parametrize(
    ("kind", "latex", "slip"),
    [
        ("sign", r"$a=b-c$", r"$a=b+c$"),
        ("sign", r"$a=b-c$", r"$a=-b-c$"),
        ("index", r"$a_{n+\nu}=0$", r"$a_{n-\nu}=0$"),
        ("index", r"$a_1+b$", r"$a_2+b$"),
        ("index", r"$a_1+b$", r"$a+b$"),
        ("prime", r"$\mu'+\mu$", r"$\mu+\mu$"),
        ("prime", r"$\mu'+\mu$", r"$\mu'+\mu'$"),
        ("dot", r"$\dot u=u$", r"$ u=u$"),
        ("dot", r"$\dot{u}=u$", r"$\dot{u}=\dot u$"),
        ("factor", r"$abc=d$", r"$a c=d$"),
        ("factor", r"$a=bc$", r"$a=2bc$"),
        ("factor", r"$\sqrt{a}+b$", r"${a}+b$"),
        ("exponent", r"$a^2+b$", r"$a^3+b$"),
        ("exponent", r"$a^2+b$", r"$a+b$"),
        ("dropped term", r"$a=b+c_1-d$", r"$a=b-d$"),
        ("dropped term", r"$a=b+c_1-d$", r"$a=c_1-d$"),
        ("doubled term", r"$a=b-c_1$", r"$a=b-c_1-c_1$"),
        ("sin/cos", r"$\sin u$", r"$\cos u$"),
        ("swapped letters", r"$\dot u+v_1$", r"$\dot v+u_1$"),
        ("inequality", r"$a<b$", r"$a>b$"),
        ("repeated", r"$a=b,\quad c=d$", r"$a=b,\quad a=b$"),
        ("number", r"$\frac12a$", r"$\frac13a$"),
        ("bracket", r"$(a+b)c$", r"$(a+bc)$"),
        ("fraction", r"$\frac{a+1}{b}c$", r"$\frac {b} {a+1}c$"),
        ("differential", r"$\frac{\partial a}{\partial b}$", r"$\frac{ a}{\partial b}$"),
        ("font", r"$\mathbf M=m$", r"$ M=m$"),
    ],
)
def test_each_kind_of_error_is_made(kind, latex, slip):
    assert slip in made(latex, kind)


def test_labels_and_words_stay_and_no_error_is_made_twice():
    latex = r"\begin{equation}\label{a1} a=b_1+b_1 \quad\text{for a}\end{equation}"
    slips = [slip.latex for slip in latex_errors.slips(latex)]
    assert len(set(slips)) == len(slips)
    assert all(r"\label{a1}" in slip and r"\text{for a}" in slip for slip in slips)


@pytest.mark.parametrize(
    ("kind", "text", "slip"),
    [
        ("number", "it has two roots", "it has three roots"),
        ("quantifier", "for all motions", "for some motions"),
        ("negation", "it is stable", "it is not stable"),
        ("negation", "it is not stable", "it is stable"),
        ("order", "$a$ is larger", "$a$ is smaller"),
        ("reference", r"follows from \eqref{a}", r"follows from \eqref{b}"),
        ("condition", "it is stable if $k>0$, always", "it is stable, always"),
        ("inequality", "stable if $k>0$", "stable if $k<0$"),
    ],
)
def test_each_kind_of_error_is_made_in_a_sentence(kind, text, slip):
    found = english_errors.sentence_slips(text, ("a", "b"))
    assert (kind, slip) in {(s.kind, s.latex) for s in found}


m, J, x, w, a = sp.symbols("m J x w a")


def page(*displays, complete=True):
    """A section on a mass on a spring, x' = w, with a number N that the dictionary holds."""
    names = {"m": m, "x": x, "w": w, "a": a, "t": vo.time, "N": m * a}
    study = Study(names, motion=Motion({x: w}))
    section = Section("spring", tuple(displays), lambda _: {"one": study}, complete=complete)
    return paper_trials.Page(section)


def outcome(section, latex, kind="letter", place=0):
    return section.trial(place, latex_errors.Slip(kind, latex, 0)).outcome


def test_the_outcome_of_an_error_is_told():
    section = page(Display("$N=ma$"), Display(r"$\dot x=w$"))
    assert outcome(section, "$N=mx$") == "noticed at the right record"
    assert outcome(section, "$N=QwQ+x^3$") == "noticed at the right record"
    assert outcome(page(Display("$N=ma$"), complete=False), "$N=QwQ+x^3$") == "not read"
    assert outcome(section, "$N=am$") == "became true"
    assert outcome(section, "$-N=-ma$") == "became true"
    assert outcome(section, "$N=N$") == "noticed at the right record"
    assert outcome(section, "$N-N=N-N$") == "noticed at the right record"
    assert outcome(section, "$N-N=0$") == "survived"  # true, but not what it said
    assert outcome(section, r"$\dot x=w+$", place=1) == "noticed at the right record"


OTHERS = (Display(r"$\dot x=w$"), Display("$2N=2ma$"), Display("$Nx=max$"))


def test_a_letter_that_other_formulas_have_is_missing_in_the_dictionary_else_misprinted():
    section = page(Display("$N=ma$"), Display("$Qx=Qx+w-w$"), *OTHERS)
    assert outcome(section, "$N=QwQ+x^3$") == "not read"
    assert outcome(section, "$N=ZwZ+x^3$") == "noticed at the right record"
    assert outcome(section, "$N=m(a$") == "noticed at the right record"


def test_what_the_reader_overlooks_has_not_become_true():
    definitions = (Check("definition"),)
    defined, used = Display("$P=7m+3ax+5$", definitions), Display("$Pw-7mw=3axw+5w$")
    section = page(Display(r"$\frac{d}{dt}x=w$"), defined, used, *OTHERS)
    assert outcome(section, r"$\frac{d}{dt^2}x=w$") == "noticed at the right record"
    assert outcome(section, "$PP=7m+3ax+5$", place=1) == "noticed at the right record"
    assert outcome(section, "$p=7m+3ax+5$", place=1) == "undecided"  # nothing else has p


def test_an_error_in_a_definition_is_noticed_where_it_is_used():
    definition = Display("$P=2m$", (Check("definition"),))
    section = page(definition, Display("$Pa=2N$"))
    assert outcome(section, "$P=3m$") == "noticed elsewhere"


def test_what_stands_in_print_is_corrected_before_errors_are_made():
    section = page(Display("$N=mx$"))
    assert section.latex(0) == "$N=ma$"
    assert outcome(section, "$N=mx$") == "noticed at the right record"


MASS, SPRING = (sp.Symbol(name, positive=True) for name in ("mass", "stiffness"))


def energy_page():
    """A section on the energy of a mass on a spring."""
    speed = vo.velocity(x)
    energy = MASS * speed**2 / 2 - SPRING * x**2 / 2
    spring = vo.System("spring", vo.Fibration((x,), ()), energy, parameters=(MASS, SPRING))
    eqs = vo.derive(spring)
    names = {"m": MASS, "c": SPRING, "x": x, "v": speed, "t": vo.time, "T": MASS * speed**2 / 2}
    names |= {"V": SPRING * x**2 / 2}
    study = Study(names, motion=Motion.of(eqs).solved(eqs), context=eqs)
    return paper_trials.Page(
        Section("energy", (Display("$T+V=const$"), Display("$2T=mv^2$")), lambda _: {"one": study})
    )


@pytest.mark.parametrize(
    ("place", "wrong", "proposed", "kind", "why"),
    [
        (1, "$2T=mv^3$", "2T=mv^2", "restored", ""),
        (1, "$2T=mv^3$", "-2T=-mv^2", "equivalent", ""),
        (1, "$2V=cv^2$", "2V=cx^2", "another", ""),
        (1, "$2T=mv^3$", "2T=mv^4", "senseless", "it is not proved"),
        (1, "$2T=mv^3$", "2T=2T", "senseless", "it says nothing"),
        (1, "$2T=mv^3$", "2T=3T-T", "senseless", "it says nothing"),
        (1, "$2T=mv^3$", "2V+T=cx^2+mv^2-T", "senseless", "what stood there is nearer"),
    ],
)
def test_what_a_proposed_correction_is_worth(place, wrong, proposed, kind, why):
    fault = energy_page().trial(place, latex_errors.Slip("letter", wrong, 0)).fault
    found = proposals.judge(proposed, fault)
    assert (found.kind, found.why) == (kind, why)


def test_a_correction_is_sought_of_what_is_noticed():
    fault = energy_page().trial(1, latex_errors.Slip("exponent", "$2T=mv^3$", 0)).fault
    assert fault.correction() == "2T=mv^2"


def test_every_kind_of_premise_of_a_system_is_changed():
    system = vo.load("demchenko")
    found = {p.what: p.changed for p in tool("papers.premises").premises(system)}
    assert {f"{x} doubled in the Lagrangian" for x in ("M", "R1", "R2", "A", "k")} < set(found)
    assert {f"{x} doubled in its definition" for x in ("s", "tau", "n")} < set(found)
    assert all(changed != system for changed in found.values())
    assert found["a sign turned in constraint 1"].constraints != system.constraints
    assert "the Lagrangian times 1 + u1^2" in found


def test_before_any_change_each_system_is_derived_as_it_is():
    seen = {}
    outside, inside = vo.load("demchenko"), replace(vo.load("demchenko"), constraints=())
    noted = [tool("papers.premises").note_system(seen, system) for system in (outside, inside)]
    assert noted == [outside, inside] and outside != inside and seen == {"demchenko": outside}
