"""Verdicts: what is true is proved, what is false is refuted and mended, and nothing in between."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
import sympy as sp

import voronec as vo
from voronec import DefinitionError, velocity
from voronec.algebra.symbols import plain_name
from voronec.algebra.typeset import symbol_latex
from voronec.audit import (
    Check,
    Convention,
    Display,
    Motion,
    Paper,
    Range,
    Section,
    Study,
    audit_paper,
    load_paper,
)

x, y, w, m, c = sp.symbols("x y w m c")
DEFINITION = Check("definition")
X = {i: sp.Symbol(f"x{i}") for i in (1, 2)}


def oscillator() -> Study:
    """m xddot + c x = 0, with w = xdot."""
    return Study(
        {
            "x": x,
            "y": y,
            "m": m,
            "c": c,
            "w": w,
            "t": sp.Symbol("t"),
            "E": m * w**2 / 2 + c * x**2 / 2,
            "g_{ij}": lambda i, j: X[i] * X[j] ** 2,
            "X_{i}": lambda i: X[i],
        },
        indices={"i": 2, "j": 2},
        motion=Motion(
            rates={x: w, w: velocity(w)},
            constrained={velocity(x): w},
            accelerations={velocity(w): -c * x / m},
        ),
    )


def audit(*displays: Display, study: Study | None = None, **more):
    section = Section("s", displays, lambda _: {"only": study or oscillator()}, **more)
    return audit_paper(Paper("p", "A paper", (section,))).records


def one(latex: str, check: Check | None = None, **options):
    (record,) = audit(Display(f"${latex}$", (check or Check(),)), **options)
    (formula,) = record.formulas
    return formula


def test_an_identity_is_proved():
    assert one("x^2-y^2=(x-y)(x+y)").verdict == "proved"
    assert one(r"\sin^2x+\cos^2x=1").verdict == "proved"


def test_a_value_at_an_instant_is_no_product():
    """x(0) = 0 was proved, as 0 x = 0; a product shows its sign, and a dictionary has functions."""
    for printed in ("x(0)=0", r"\dot x(0)=0", "w(t+1)=w(t)+w", r"\sin x(0)=0", "x^2(2t)=2tx^2"):
        formula = one(printed)
        assert (formula.verdict, formula.correction) == ("not read", None), printed
        assert "a value at an instant or a product" in formula.method
    assert one(r"x\cdot(t+1)=xt+x").verdict == one(r"\dot x(t)^2=w^2(t)").verdict == "proved"
    assert one("m(t)=m").verdict == "not read"
    assert one("2(t+1)x=2(1+t)x").verdict == one("m(x+1)=mx+m").verdict == "proved"
    function = replace(oscillator(), names={**oscillator().names, r"x(\cdot)": lambda s: s**2})
    assert one("x(t+1)=t^2+2t+1", study=function).verdict == "proved"


def test_what_can_be_read_in_two_ways_is_not_read_unless_the_transcription_says_how():
    """Each was called a misprint, and corrected, or proved."""
    for printed, words in {
        r"\cos wt=\cos(wt)": "the cos of a product with t, or t times a cos",
        r"\ln xm=\ln x+\ln m": "the ln of a product with m, or m times a ln",
        r"\cos2wt=\cos(2wt)": "the cos of a product with t",
        r"\sin x/2=\sin(x/2)": "the sin of a quotient, or a sin divided",
        r"1\frac12m=\frac32m": "a mixed number or a product",
        r"1\dfrac{1}{2}m=\frac32m": "a mixed number or a product",
        r"10\,000m=10000m": "two numbers stand side by side",
        r"1{,}500m=1500m": "this comma may stand before decimals or part thousands",
        r"\tan^{-1}(x)=\arctan x": "1/tan or the inverse function",
        r"\sin x^2=\sin(x^2)": "the power of a function or of its argument",
        "w^2/2m=w^2/(2m)": "this quotient can be read in two ways",
        "xw/m c=xwc/m": "this quotient can be read in two ways",
        r"w/2\sqrt m=w/(2\sqrt m)": "this quotient can be read in two ways",
        "w/m(m+c)=w/(m(m+c))": "this quotient can be read in two ways",
        r"\frac{d}{dt}(x+w)m=m\frac{d}{dt}(x+w)": "a factor of what is differentiated",
        "x2=2x": "this number may be an index, a power or a factor",
        "|x|w|-m|=m|xw|": "these bars can be read in two ways",
        "(2) x=2x": "a factor, or the number of the formula",
    }.items():
        formula = one(printed, complete=True)
        assert (formula.verdict, formula.correction) == ("not read", None), printed
        assert words in formula.method
    assert one(r"\cos{wt}=\cos(tw)").verdict == one(r"\cos{w}t=t\cos w").verdict == "proved"
    assert one(r"\sin x\dot x=\dot x\sin x").verdict == "proved"
    assert one(r"\ln2\cdot x=x\ln2").verdict == one("0{,}5m=m/2").verdict == "proved"
    assert one(r"w/{m}(m+c)=w+wc/m").verdict == one("dx/dt m=mw").verdict == "proved"
    own = replace(oscillator(), narrow_functions=True)
    assert one(r"\cos wt=t\cos(w)", study=own).verdict == "proved"
    assert one(r"\cos wt=\cos(tw)", study=own).verdict == "misprint"


def test_every_link_of_a_chain_counts():
    assert one("x+x=2x=x+x").verdict == "proved"
    assert one("x+x=2x=3x").verdict == "misprint"
    assert one("x+x=3x=3x").verdict == "misprint"


@pytest.mark.parametrize(
    ("printed", "correction"),
    [
        ("(x+y)^2=x^2-2xy+y^2", "(x-y)^2=x^2-2xy+y^2"),
        ("x^2-y^2=(x-y)(x-y)", "x^2-y^2=(x+y)(x-y)"),
        (r"\sin 2x=2\sin x\sin x", r"\sin 2x=2\cos x\sin x"),
        ("x^3y=xxyy", "x^2y^2=xxyy"),
        ("g_{ij}=X_iX_j^2+0", None),
        ("g_{ij}=X_jX_j^2", "g_{ij}=X_iX_j^2"),
    ],
)
def test_a_misprint_is_mended_by_one_change_that_is_proved(printed, correction):
    formula = one(printed)
    if correction is None:
        assert formula.verdict == "proved"
        return
    assert formula.verdict == "misprint"
    assert one(formula.correction).verdict == "proved"
    (a, b), (start, end) = formula.struck[0], formula.changes[0]
    mended = formula.printed[:a] + formula.correction[start:end] + formula.printed[b:]
    assert mended == formula.correction


@pytest.mark.slow
def test_what_becomes_of_a_proposed_correction_is_said():
    printed = "(x+y)^3=x^3+3x^2y+4xy^2+5y^3"
    missing = "no correction by a small change was found"
    good = one(printed, Check(proposal="(x+y)^3=x^3+3x^2y+3xy^2+y^3"))
    assert good.correction == "(x+y)^3=x^3+3x^2y+3xy^2+y^3" and good.verdict == "misprint"
    assert [printed[a:b] for a, b in good.struck] == ["4", "5"]
    assert "; the corrected formula is proved (" in good.method
    wrong = one(printed, Check(proposal="(x+y)^3=x^3+3x^2y+3xy^2"))
    assert (wrong.verdict, wrong.correction) == ("misprint", None)
    assert wrong.method.endswith(f"{missing}; the proposed correction is not proved")
    senseless = one(printed, Check(proposal=r"(x+y)^3=\frobnicate"))
    assert f"{missing}; the proposed correction has no meaning: " in senseless.method
    empty = one(printed, Check(proposal="x+y=y+x"))
    assert f"{missing}; the proposed correction is true, but refused: " in empty.method
    assert "proposed" not in one(printed).method
    for unread in ("Q(x+y=x^3", "x=QwQ+x^3"):
        said = one(unread, Check(proposal="x=y")).method
        assert said.endswith("; the proposed correction is not proved"), said


def test_a_misprint_has_a_witness_at_which_the_sides_differ():
    formula = one("g_{ij}=X_jX_j^2")
    witness = formula.witness
    assert witness["printed"] != witness["derived"]
    assert witness["indices"] == {"i": 1, "j": 2}
    point = {sp.Symbol(name): sp.Rational(text) for name, text in witness["point"].items()}
    derived = (X[1] * X[2] ** 2).subs(point)
    printed = (X[2] ** 3).subs(point)
    assert abs(derived - sp.Float(witness["derived"], 30)) < 10**-28
    assert abs(printed - sp.Float(witness["printed"], 30)) < 10**-28


def test_a_claimed_constant_is_differentiated_along_the_motion():
    assert one("E=const").verdict == "proved"
    assert one("x=const").verdict == "misprint"
    doubled = replace(oscillator(), names={**oscillator().names, "E": m * w**2 + c * x**2 / 2})
    assert one("E=const", study=doubled).verdict == "misprint"


def test_an_equation_of_motion_is_compared_with_the_derived_one():
    def truth(study: Study, where: Mapping[str, int]) -> sp.Expr:
        return m * velocity(w) + c * x

    check = Check(truth=truth)
    assert one(r"m\dot w=-cx", check).verdict == "proved"
    assert one(r"-cx-m\dot w=0", check).verdict == "proved"
    assert one(r"-2m\dot w=2cx", check).verdict == "proved", "a factor makes no difference"
    assert one(r"(1+x^2)m\dot w=-(1+x^2)cx", check).verdict == "proved"
    assert one(r"mx\dot w=-cx^2", check).verdict == "proved", "it holds along the motion"
    assert one(r"0\cdot\dot w=0", check).verdict == "misprint"
    for true in (
        r"\dot w=-\frac{cx}{m}",
        r"\frac{\dot w}{c}=-\frac xm",
        r"\dot w^2=\frac{c^2x^2}{m^2}",
    ):
        assert one(true, check).verdict == "proved", "no sign of m or c is known"
    wrong = one(r"m\dot w=cx", check)
    assert wrong.verdict == "misprint"
    assert one(wrong.correction, check).verdict == "proved"
    point = {sp.Symbol(k): sp.Rational(value) for k, value in wrong.witness["point"].items()}
    values = [sp.Float(wrong.witness[side], 30) for side in ("derived", "printed")]
    assert values[0] == -values[1] and abs(values[1] - (c * x).subs(point)) < 10**-28
    assert r"m \dot{w}" in one(r"m\dot w=-cx", check).derived


def test_a_name_that_the_paper_defines_is_a_definition_and_its_uses_are_named():
    first, second = audit(Display("$D=x+y$", (DEFINITION,)), Display("$D^2=x^2+2xy+y^2$"))
    assert (first.verdict, second.verdict) == ("definition", "proved")
    assert "consistent with its uses in display 2" in first.formulas[0].method


def test_a_formula_of_the_running_text_defines_names_and_has_a_record_of_its_own():
    display, text = audit(Display("$D^2=x^2+2xy+y^2$"), inline=(Display("$D=x+y$", (DEFINITION,)),))
    assert (display.verdict, text.verdict) == ("proved", "definition")
    assert (display.kind, text.kind, text.ordinal) == ("display", "text", 2)


def test_a_definition_that_leads_back_to_itself_is_not_used():
    texts = ("$D=x+F$", "$F=D-x$", "$D=D$")
    records = audit(*(Display(text, (DEFINITION,)) for text in texts))
    assert all(r.verdict != "proved" for r in records)


def test_a_printed_range_of_an_index_must_be_its_range():
    study = replace(oscillator(), names={**oscillator().names, "n": sp.Integer(2)})
    assert one(r"g_{ij}=X_iX_j^2 \quad (i=1,\dots,n)", study=study).verdict == "proved"
    formula = one(r"g_{ij}=X_iX_j^2 \quad (i=1,\dots,3)", study=study)
    assert formula.verdict == "misprint"
    assert "the index i runs from 1 to 2" in formula.method


def test_a_definition_that_the_dictionary_contradicts_is_a_misprint():
    definition = Check("definition")
    assert one(r"E=\frac12mw^2+\frac12cx^2", definition).verdict == "definition"
    assert one(r"E=\frac12mw^2-\frac12cx^2", definition).verdict == "misprint"


def test_a_condition_is_in_force_only_where_it_is_given():
    condition = Display(r"\begin{equation}\label{cond} m=2c\end{equation}", (Check("condition"),))
    given, without = Check(given=("cond",)), Check()
    truth = replace(given, truth=lambda study, where: m * velocity(w) + c * x)
    for printed in (
        Display("$mx=2cx$", (given,)),
        *(Display(r"$2\dot w=-x$", (k,)) for k in (given, truth)),
    ):
        first, second = audit(condition, printed)
        assert (first.verdict, second.verdict) == ("definition", "proved")
    assert audit(condition, Display("$mx=2cx$", (without,)))[1].verdict == "misprint"


def test_another_convention_is_told_from_a_misprint():
    convention = Convention("x is taken with the opposite sign", "eq", {"x": -x})
    formula = one(r"xy+xy=-2yx+4xy+y-y-x-x+2x+0\cdot x-xy-xy+xy+xy", Check(convention=convention))
    assert formula.verdict == "proved"
    formula = one(
        "w+F=w-x",
        Check(convention=convention),
        study=replace(oscillator(), names={**oscillator().names, "F": x}),
    )
    assert formula.verdict == "convention"
    assert "against (eq)" in formula.method


@pytest.mark.parametrize(
    ("printed", "why"),
    [
        ("x+z=y", r"character 4: the name 'z' is not in the dictionary; add it, at '$x+ >>> z=y$'"),
        (r"x+\heartsuit=y", r"character 4: '\heartsuit' is not understood"),
        (r"E=\frac12mw^2+\frac12cz^2", "character 24: the name 'z' is not in the dictionary"),
        (r"x=\begin{CD}y@>>>y\end{CD}", r"character 4: '\begin{CD}' is not understood"),
        ("x_y=y", "the index 'y' has no integer value"),
        ("x(w)=w", "character 3: this may be a function of w, or a product"),
        ("x=0,5y", "',' is not understood here"),
        ("x=\N{GREEK SMALL LETTER OMEGA}", "'\N{GREEK SMALL LETTER OMEGA}' is not understood"),
    ],
)
def test_what_is_not_known_is_not_read_and_it_is_said_what_and_where(printed, why):
    formula = one(printed)
    assert (formula.verdict, formula.correction) == ("not read", None)
    assert why in formula.method


def test_a_name_that_nothing_introduces_is_a_misprint_where_the_letters_are_complete():
    formula = one(r"E=\frac12mw^2+\frac12cz^2", complete=True)
    assert (formula.verdict, formula.correction) == ("misprint", r"E=\frac12mw^2+\frac12cx^2")
    assert "'z' is not in the dictionary" in formula.method
    formula = one(r"E=\frac12mz^2+y", complete=True)  # no small change makes it true
    assert (formula.verdict, formula.correction) == ("misprint", None)
    assert "nothing introduces 'z'" in formula.method


def test_what_the_study_leaves_out_is_no_misprint_of_the_print():
    still = Study({"x": x, "y": y})
    assert one(r"\dot x-\dot x=x-x", study=still).verdict == "undecided"


def test_a_display_takes_the_worst_of_its_formulas():
    checks = (Check(), Check(), DEFINITION)
    (record,) = audit(Display(r"\[ x+x=2x, \quad x+x=3x, \quad D=x \]", checks))
    assert [f.verdict for f in record.formulas] == ["proved", "misprint", "definition"]
    assert record.verdict == "misprint"
    assert record.decisive is record.formulas[1]


def test_a_loose_index_is_named():
    formula = one(r"\sum_{i=1}^2X_i=X_i+X_j-X_j+0")
    assert formula.verdict == "misprint"
    assert "nothing binds the index i" in formula.method


def test_a_list_of_arguments_must_name_what_the_function_depends_on():
    notation = one("E(x,w)=E(w,x)")
    assert notation.verdict == one("E=E(x,w)").verdict == "definition"
    assert "of what a quantity is a function" in notation.method
    assert one("2E=2E(x,w)").verdict == "proved"
    formula = one("E(x,t)=E")
    assert (formula.verdict, formula.correction) == ("misprint", "E(x,w)=E")
    assert "'E' depends on 'w'" in formula.method


def test_a_function_is_not_printed_of_what_it_does_not_depend_on():
    polynomial = {"Q": y**2 - m, "m": m, "y": y, "a": sp.Symbol("a")}
    study = Study(polynomial, functions=frozenset("Q"))
    assert one("Q(y)=yy-m", study=study).verdict == "proved"
    formula = one("Q(a)=yy-m", study=study)
    assert formula.verdict == "misprint"
    assert one("Q(a)=Q(y)", study=study).verdict == "misprint"


def test_a_check_must_ask_for_something_that_exists():
    with pytest.raises(DefinitionError, match="the role 'axiom'"):
        Check("axiom")
    for check, what in (
        (Check(study="other"), "no study 'other'; there are: only"),
        (Check(also=("onyl",)), "no study 'onyl'; did you mean 'only'"),
        (Check(within=("up",)), "no range 'up'"),
        (Check(given=("cond",)), "labelled 'cond'"),
    ):
        with pytest.raises(DefinitionError, match=what):
            one("x=x", check)


def test_an_unknown_name_makes_no_definition():
    assert one("D=x").verdict == "not read"
    assert "'D' is not in the dictionary" in one("D=x").method


def test_what_claims_nothing_is_not_proved():
    assert one("x+y").verdict == "undecided"
    assert "it claims nothing" in one("x+y").method
    with pytest.raises(DefinitionError, match="holds no formula"):
        Display(r"\[ \]")


def test_what_is_set_equal_to_itself_says_nothing():
    formula = one("E=E")
    assert (formula.verdict, formula.correction) == ("misprint", None)
    assert "it says nothing" in formula.method
    assert one("xw=wx").verdict == "proved"


def test_what_a_display_says_twice_is_a_misprint():
    (record,) = audit(Display(r"\[ x+x=2x, \quad xw=wx, \quad x+x=2x \]"))
    assert [f.verdict for f in record.formulas] == ["proved", "proved", "misprint"]
    assert "formula 1 of the same display" in record.formulas[2].method


def test_a_value_is_compared_with_every_part():
    check = Check(value=lambda study, where: x**2)
    assert one("xx", check).verdict == "proved"
    assert one("xx=x^2", check).verdict == "proved"
    assert one("xx=x^3", check).verdict == "misprint"


def test_a_function_of_the_paper_that_fails_is_told_as_its_own():
    for check in (
        Check(truth=lambda study, where: study.contxt),
        Check(value=lambda study, where: 1 / 0),
        Check(derived=lambda study, where: 1 / 0),
        Check(decide=lambda study, where: True),
    ):
        with pytest.raises(
            DefinitionError, match=r"test_audit_verdicts.py, line|returns no Verdict"
        ):
            one("x=x", check)


def test_a_rate_that_nobody_gave_is_not_zero():
    study = Study({"x": x})
    assert one("x=const", study=study).verdict == "undecided"
    assert "no rates are known" in one("x=const", study=study).method
    with pytest.raises(DefinitionError, match="is the rate of no symbol"):
        Motion(accelerations={velocity(w): -x})


def test_accelerations_that_nobody_gave_refute_nothing():
    free = Motion(rates={x: w, w: velocity(w)}, constrained={velocity(x): w})
    study = replace(oscillator(), motion=free)
    assert one(r"E=const", study=study).verdict == "undecided"
    assert "Motion.of(eqs).solved(eqs)" in one(r"\dot w=-x", study=study).method
    assert one(r"\dot x=w", study=study).verdict == "proved"


@pytest.mark.slow
def test_an_equation_of_motion_is_refuted_at_a_state_of_the_motion_alone():
    """Two masses that pull at each other: rows of mass * vdot - force, and what follows of both."""
    n, u = sp.symbols("n u")
    rows = (m * velocity(w) + n * velocity(u) + c * x, n * velocity(w) + m * velocity(u))
    names = {"x": x, "w": w, "u": u, "m": m, "n": n, "c": c}
    free = Motion(rates={x: w, y: u, w: velocity(w), u: velocity(u)})
    values = sp.solve(rows, [velocity(w), velocity(u)])
    check = Check(truth=lambda study, where: rows[0])
    verdicts = {
        r"m\dot w+n\dot u=-cx": ("proved", "proved", "proved"),
        r"m\dot w+n\dot u=cx": ("misprint", "misprint", "misprint"),
        r"\dot w+\frac nm\dot u=-\frac cmx": ("proved", "proved", "proved"),
        r"(m^2-n^2)\dot w=-cmx": ("undecided", "misprint", "proved"),
        r"(m^2-n^2)\dot w=cmx": ("undecided", "misprint", "misprint"),
        r"(m+n)(\dot w+\dot u)=-cx": ("undecided", "misprint", "proved"),
        r"\dot w-\dot w=0": ("misprint", "misprint", "misprint"),
    }
    known = ({}, {velocity(s): velocity(s) for s in (w, u)}, values)
    for printed, expected in verdicts.items():
        for some, verdict in zip(known, expected, strict=True):
            study = Study(names, motion=replace(free, accelerations=some))
            formula = one(printed, check, study=study)
            assert formula.verdict == verdict, (printed, some)
            if verdict == "undecided":
                assert "accelerations that are not known" in formula.method
    silent = one(r"\dot w-\dot w=0", check, study=Study(names, motion=free))
    assert "it says nothing of the motion" in silent.method


def test_what_vanishes_without_accelerations_binds_as_a_relation_does():
    check = Check(truth=lambda study, where: x * y - 1)
    study = Study({"x": x, "y": y})
    assert one(r"x=\frac1y", check, study=study).verdict == "proved"
    assert one("x^2y=x", check, study=study).verdict == "proved"
    assert one("x=y", check, study=study).verdict == "misprint"
    assert one("xy-yx=0", check, study=study).verdict == "misprint"


def test_what_has_no_rate_is_constant_only_where_it_is_a_parameter():
    spring = vo.System(
        name="spring",
        fibration=vo.Fibration((x,)),
        lagrangian=m * velocity(x) ** 2 / 2 - c * x**2 / 2,
        parameters=(m, c),
    )
    eqs = vo.derive(spring)
    names = {"x": x, "m": m, "c": c, "z": sp.Symbol("z"), "w": velocity(x)}
    study = Study(names, motion=Motion.of(eqs).solved(eqs), context=eqs)
    assert one("mw^2+cx^2=const", study=study).verdict == "proved"
    stray = one("mw^2+cx^2+z=const", study=study)
    assert stray.verdict == "undecided" and "the rate of 'z' is not known" in stray.method


def test_accelerations_without_a_rate_do_not_stand_still():
    free = replace(oscillator(), motion=Motion(rates={x: w, w: velocity(w)}))
    jerk = one(r"\frac{d}{dt}\ddot x=0", study=free)
    assert jerk.verdict == "undecided" and "is not known" in jerk.method


def test_an_inequality_of_accelerations_is_one_along_the_motion():
    """It was refuted by accelerations that no motion has."""
    kept = sp.symbols("p q", positive=True)
    ranges = (Range("all", "m>0, c>0", dict(zip((m, c), kept, strict=True)), kept),)
    study = replace(oscillator(), ranges=ranges)
    assert one(r"x\dot w\le0", study=study).verdict == "proved"
    assert one(r"0\le x\ddot x", study=study).verdict == "misprint"
    free = replace(study, motion=replace(study.motion, accelerations={}))
    assert one(r"x\dot w\le0", study=free).verdict == "undecided"


def test_an_inequality_without_ranges_is_not_called_wrong():
    assert one("x^2+1>0").verdict == "proved"
    assert one("x>0").verdict == "undecided"
    assert "which are meant" in one("x>0").method


@pytest.mark.parametrize("printed", [r"\frac{w}{x-x}=w", r"w(x-x)^{-1}=w", r"\frac{w}{N}=w"])
def test_what_divides_by_zero_is_a_misprint(printed):
    study = replace(oscillator(), names={**oscillator().names, "N": sp.Integer(0)})
    formula = one(printed, study=study)
    assert (formula.verdict, "a denominator is zero" in formula.method) == ("misprint", True)
    assert ("('N' is zero)" in formula.method) is ("N" in printed)


def true_displays() -> dict[str, list[str]]:
    """Of each system the lines of the table."""
    found: dict[str, list[str]] = {}
    text = (Path(__file__).parent / "true_displays.txt").read_text(encoding="utf-8")
    for line in text.splitlines():
        if line.startswith("[") and "\\" not in line:
            several = found.setdefault(line.strip("[]"), [])
        elif line and not line.startswith("#"):
            several.append(line)
    return found


TRUE = true_displays()
DEFINED = {"sleigh": "$P=J+ma^2$", "chaplygin-ball": "$D=mR^2$"}


def studies_of(name: str, transcript) -> dict[str, Study]:
    """The letters of a system, and its energy T; the ball has vectors."""
    if name == "chaplygin-ball":
        return load_paper(name).sections[0].studies(transcript)
    eqs = vo.derive(vo.load(name))
    known = {plain_name(q): q for q in eqs.coordinates}
    known |= {p.name: p.symbol for p in eqs.system.parameters}
    names = {symbol_latex(k).replace(r"\phi", r"\varphi"): v for k, v in known.items()}
    names |= {"t": vo.time, "T": eqs.theta}
    if name == "sleigh":
        names |= dict(zip(("v", r"\omega"), eqs.velocities, strict=True))
    return {name: Study(names, motion=Motion.of(eqs).solved(eqs), context=eqs)}


def verdicts_on(name: str, several: list[str]) -> list[set[str]]:
    """Of each display the verdicts on its formulas."""
    whole = [d if d.startswith(r"\begin") else f"\\[ {d}\n\\]" for d in several]
    displays = tuple(map(Display, whole))
    inline = (Display(DEFINED[name], (DEFINITION,)),) if name in DEFINED else ()
    section = Section("s", displays, lambda page: studies_of(name, page), inline=inline)
    records = iter(audit_paper(Paper("p", "A paper", (section,))).records)
    units = [[next(records) for _ in display.units] for display in displays]
    return [{f.verdict for record in found for f in record.formulas} for found in units]


@pytest.mark.slow
@pytest.mark.parametrize("name", TRUE)
def test_no_true_display_is_called_a_misprint(name):
    """In other authors' styles; what is marked is read and proved, what is unknown is not read."""
    several = TRUE[name]
    found = verdicts_on(name, [line.removeprefix("+ ") for line in several])
    wrong = [line for line, said in zip(several, found, strict=True) if "misprint" in said]
    pairs = zip(several, found, strict=True)
    missed = [line for line, said in pairs if line.startswith("+ ") and said != {"proved"}]
    assert (wrong, missed) == ([], [])


def test_there_are_many_true_displays():
    assert sum(map(len, TRUE.values())) >= 137 and len(TRUE) == 4


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sleigh", "vertical-disc", "nonholonomic-particle"])
def test_an_error_in_what_is_read_is_a_misprint(name):
    """A sign turned in each display that is proved."""
    marked = (line.removeprefix("+ ") for line in TRUE[name] if line.startswith("+ "))
    right = [
        line
        for line in marked
        if "=" in line and "=0" not in line and "onst" not in line and "|" not in line
    ]
    wrong = [re.sub("=(-?)", lambda m: "=" if m[1] else "=-", line, count=1) for line in right]
    found = verdicts_on(name, wrong)
    missed = [line for line, said in zip(right, found, strict=True) if "misprint" not in said]
    assert right and not missed
