"""The smallest change that makes a false formula true, or none."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

import voronec as vo
from voronec import velocity
from voronec.audit import Check, Display, Motion, Range, Section, Study, Transcript
from voronec.audit.correction import Correction, Spare, correct
from voronec.audit.formula import Formula
from voronec.audit.latex.reader import read
from voronec.audit.structure import are_multiples
from voronec.audit.verify import omission, verify

pytestmark = pytest.mark.slow

x, y, w, m, c, M = sp.symbols("x y w m c M")
g = sp.Function("g")

STUDY = Study(
    {
        "x": x,
        "y": y,
        "w": w,
        "m": m,
        "c": c,
        "t": sp.Symbol("t"),
        "P": x + y,
        r"\mathbf{M}": M,
        r"\mathfrak{m}": x * y,
        r"\mathfrak{w}": x - y,
        "L": m * w**2 / 2 + g(x, y),
        "v_{i}": lambda i: sp.Symbol(f"v{i}"),
        "r": sp.Matrix([x, y, w]),
    },
    indices={"i": 2, "j": 2},
    motion=Motion(
        rates={x: w, w: velocity(w)},
        constrained={velocity(x): w},
        accelerations={velocity(w): -c * x / m},
    ),
)


def formula(latex: str) -> Formula:
    section = Section("s", (Display(f"${latex}$"),), lambda _: {"only": STUDY})
    (found,) = Transcript(section).formulas()
    return found


def mend(latex: str, check: Check | None = None, study: Study = STUDY) -> Correction | None:
    section = Section("s", (Display(f"${latex}$"),), lambda _: {"only": study})
    spare = Spare.of(Transcript(section), study)
    return correct(formula(latex), check or Check(), study, spare)


@pytest.mark.parametrize(
    ("printed", "mended"),
    [
        ("P^2=x^2+2xy+y^y", "P^2=x^2+2xy+y^2"),
        ("P^2=x^2+3xy+y^2", "P^2=x^2+2xy+y^2"),
        ("P^2=x^2+xy+y^2", "P^2=x^2+2xy+y^2"),
        ("P^2=x^2-2xy+y^2", "P^2=x^2+2xy+y^2"),
        ("P(x-y)=x^2-y", "P(x-y)=x^2-y^2"),
        ("P(x-y)=(x^2-y^2)^2", "P(x-y)=(x^2-y^2)"),
        (r"x\mathfrak w=x^2-\mathfrak w", r"x\mathfrak w=x^2-\mathfrak m"),
        ("mP=my+1x", "mP=my+mx"),
        (r"\mathbf{M}P=Mx+\mathbf My", r"\mathbf{M}P=\mathbf Mx+\mathbf My"),
        (r"w\mathfrak m=w\mathbf My+x-x", r"w\mathfrak m=wxy+x-x"),
        (r"\frac{L}{\partial w}=mw", r"\frac{\partial L}{\partial w}=mw"),
    ],
)
def test_one_change(printed, mended):
    found = mend(printed)
    assert verify(read(found.latex, STUDY.vocabulary), Check(), STUDY).verdict.proved
    assert flat(found.latex) == flat(mended)


def test_a_term_that_stands_twice_is_no_correction():
    assert mend("3y+P=x+y+y") is None
    assert mend("P^2=x^2+2xy+y^2+y^2").latex == "P^2=x^2+2xy+y^2"


def test_a_number_on_both_sides_is_no_correction():
    positive = sp.symbols("p q", positive=True)
    at = Range("all", "x>y>0", {x: sum(positive), y: positive[1]}, positive)
    study = replace(STUDY, ranges=(at,))
    assert mend("x>2y>0", study=study).latex == "x>y>0"


def test_a_power_of_both_sides_is_no_correction():
    assert mend("(x+y)^2=P").latex == "(x+y)=P"
    halved = replace(STUDY, names={**STUDY.names, "S": (x + y) ** 2 / 2})
    assert mend("2S=(x+y)^3", study=halved).latex == "2S=(x+y)^2"


def test_a_number_in_a_product_of_vectors_is_not_balanced_by_one_outside():
    names = {**STUDY.names, "q": sp.Matrix([y, w, x]), "S": x * y + y * w + w * x}
    study = replace(STUDY, names=names)
    assert mend("S=(r,2q)", study=study).latex == "S=(r,q)"


def test_an_index_that_stands_twice_in_a_name_is_no_correction():
    names = {**STUDY.names, "g_{ij}": lambda i, j: sp.Symbol(f"g{i}{j}")}
    names["h_{ij}"] = lambda i, j: -sp.Symbol(f"g{i}{j}")
    study = replace(STUDY, names=names)
    assert mend("h_{jj}=-g_{ij}", study=study).latex == "h_{ij}=-g_{ij}"
    assert mend("h_{ii}=-g_{ij}", study=study).latex == "h_{ij}=-g_{ij}"


def test_a_function_beside_itself_is_no_correction():
    study = replace(STUDY, names={**STUDY.names, "F": x**2 + y}, functions=frozenset("F"))
    assert mend("FF(x,y)=(x^2+y)^1", study=study).latex == "F(x,y)=(x^2+y)^1"
    assert mend("FF(x,y)=(x^2+y)(x^2+x)", study=study) is None


def test_a_quotient_of_a_number_and_a_differential_is_no_correction():
    study = replace(STUDY, names={**STUDY.names, "K": x + y})
    assert mend(r"\frac{M}{dt}=K", study=study) is None
    assert mend(r"\frac{dy}{dt}=w", study=study).latex == r"\frac{dx}{dt}=w"


def test_what_the_display_says_already_is_no_correction():
    study = replace(STUDY, names={**STUDY.names, "P_0": x + 2 * y, "P_1": x + y})
    display = Display(r"\[ P_0=x+2y, \quad P_1=x+2y \]")
    section = Section("s", (display,), lambda _: {"only": study})
    _, wrong = Transcript(section).formulas()
    spare = Spare.of(Transcript(section), study)
    assert correct(wrong, Check(), study, spare).latex == "P_1=x+y"


def test_what_is_added_and_taken_away_again_is_no_correction():
    assert mend("Q+x-y=x") is None, "y+x-y=x is true, and says nothing of Q"
    assert mend("x+3c-c=x+2c") is None or "c-c" not in mend("x+3c-c=x+2c").latex


def flat(latex: str) -> str:
    return latex.replace(" ", "")


@pytest.mark.parametrize(
    ("printed", "mended"),
    [
        # in two terms, in two factors, in nested brackets
        ("P^3=x^3+3x^2y+4xy^2+5y^3", "P^3=x^3+3x^2y+3xy^2+y^3"),
        ("w^2(x^2-y^2)=2w^2(x+2y)(x-y)", "w^2(x^2-y^2)=w^2(x+y)(x-y)"),
        (r"\dot x(P^2+c)=w(x^2-2xy+y^3+c)", r"\dot x(P^2+c)=w(x^2+2xy+y^2+c)"),
        (r"(x+y)^2P=x^3+3x^2y+3xy^2-y+w-w", "(x+y)^2P=x^3+3x^2y+3xy^2+y^3+w-w"),
        ("mP^2+cw=m(x^2+2yx-y^3)+cw", "mP^2+cw=m(x^2+2yx+y^2)+cw"),
    ],
)
def test_two_changes_are_proposed_and_proved(printed, mended):
    assert mend(printed) is None
    found = mend(printed, Check(proposal=mended))
    assert verify(read(found.latex, STUDY.vocabulary), Check(), STUDY).verdict.proved
    assert len(found.changes) == len(found.struck) == 2
    assert found.latex == mended and restored(printed, found) == mended


def restored(printed: str, found: Correction) -> str:
    """The corrected formula, from what is struck and what is changed."""
    text, last = "", 0
    for (a, b), (start, end) in zip(found.struck, found.changes, strict=True):
        text += printed[last:a] + found.latex[start:end]
        last = b
    return text + printed[last:]


@pytest.mark.parametrize("printed", ["P^2=x^2+3xy+y^2", "Y=(P-x+2(c-(x+y)^2"])
def test_changes_and_what_they_strike_belong_together(printed):
    study = replace(STUDY, names={**STUDY.names, "Y": y + 2 * (c - (x + y) ** 2)})
    section = Section("s", (Display(f"${printed}$"),), lambda _: {"only": study})
    (found,) = Transcript(section).formulas()
    mended = correct(found, Check(), study)
    if mended is not None:
        assert restored(printed, mended) == mended.latex


def test_a_bracket_that_is_not_closed_is_closed():
    found = mend("P^2=x(x+y)+y(x+y")
    assert found.latex == "P^2=x(x+y)+y(x+y)"
    assert found.changes == ((16, 17),)
    assert found.struck == ((16, 16),)
    assert mend("P^2=x(x+y)+3y(x+y") is None, "two changes are left to a proposal"


def test_a_font_is_changed_at_all_places_of_a_letter_as_one_change():
    printed = "(M+x)^2=M^2+2Mx+x^2"
    study = replace(STUDY, names={**STUDY.names, "M": c, "Q": (M + x) ** 2})
    found = mend(printed.replace("(M+x)^2", "Q"), study=study)
    assert flat(found.latex) == r"Q=\mathbfM^2+2\mathbfMx+x^2"
    assert len(found.changes) == 2
    # one exponent on another is no formula, and so no nearer correction
    assert "^2^2" not in mend(printed, study=study).latex


def test_no_correction_is_claimed_where_none_is_proved():
    assert mend("P^3+w=x^2+cy+wm+cx^3y-w^2m") is None
    assert mend(r"\sin P=x+y+cw") is None


def test_a_formula_that_says_nothing_is_no_correction():
    assert mend("x=y") is None
    assert mend("P=w") is None


def test_a_quantity_beside_a_multiple_of_itself_says_no_more_than_its_sign():
    def link(latex: str) -> bool:
        left, right = read(latex, STUDY.vocabulary).parts
        return are_multiples(left, right)

    assert link("2x>x") and link("x+y<2y+2x") and link("2x(x+y)>x^2+xy")
    assert link("2x+3y>4x+6y") and not link("2x+3y>3x+2y")
    assert not (link("2x>0") or link("2x>y") or link("x+2y>x+y") or link("x^2>x"))


def test_a_term_is_not_struck_by_a_derivative_that_is_zero():
    spurious = mend(r"w\dot x+c\dot w=w^2+m\dot x+c\dot w")
    assert spurious.latex == r"w\dot x+c\dot w=w^2+c\dot w"
    study = replace(STUDY, names={**STUDY.names, "F": sp.Integer(0)})
    assert mend("P^2=x^2+2xy+y^2+cP^2", study=study).latex == "P^2=x^2+2xy+y^2"


def test_a_new_name_is_no_correction():
    study = replace(STUDY, names={k: v for k, v in STUDY.names.items() if k != "P"})
    found = correct(formula("x=w=w+c-c"), Check(), study, Spare(letters=("P",)))
    assert found is None or "P" not in found.latex


def test_a_proposal_is_tried_last_and_must_be_proved():
    printed = "P^3+w=x^2+cy+wm+cx^3y-w^2m"
    good = Check(proposal="P^3+w=x^3+3x^2y+3xy^2+y^3+w")
    found = mend(printed, good)
    assert found.latex == good.proposal
    assert restored(printed, found) == found.latex
    assert len(found.changes) > 2
    assert mend(printed, Check(proposal="P^3+w=x^3+y^3+w")) is None
    assert mend(printed, Check(proposal=r"P^3+\frobnicate")) is None
    assert mend("P^2=x^2+3xy+y^2", good).latex == "P^2=x^2+2xy+y^2"


def test_a_sentence_is_decided_and_not_mended():
    assert mend("x=y", Check(decide=lambda study, where: None, proposal="x=x")) is None


def test_an_equation_of_motion_is_mended_up_to_its_factor():
    def truth(study, where):
        return m * velocity(w) + c * x + m * y * w

    assert mend(r"m\dot w=-cy-myw", Check(truth=truth)).latex == r"m\dot w=-cx-myw"
    assert mend(r"2m\dot w=-2cx-2mxw", Check(truth=truth)).latex == r"2m\dot w=-2cx-2myw"
    assert mend(r"cx+mxw=-m\dot w", Check(truth=truth)).latex == r"cx+myw=-m\dot w"


def test_a_constant_is_mended_without_numbers():
    study = replace(STUDY, names={**STUDY.names, "L": c})
    found = mend(r"\frac12mw^2+\frac12cx^3=const", study=study)
    assert found.latex == r"\frac12mw^2+\frac12cx^2=const"


def test_a_formula_of_which_nothing_is_left_is_no_correction():
    energy = {"E": m * w**2 / 2 + c * x**2 / 2, "F": x**2 + y, "Q": sp.Symbol("Q")}
    study = replace(STUDY, names={**STUDY.names, **energy})
    assert mend("F=const", study=study) is None
    assert mend(r"\tilde E=const", study=study).latex == "E=const"


def test_vectors_are_mended():
    names = {**STUDY.names, "s": sp.Matrix([c, m, y])}
    study = replace(STUDY, names={**names, "q": 2 * names["r"] + names["s"].cross(names["r"])})
    assert mend(r"q=2r+r\times s", study=study).latex in (r"q=2r-r\times s", r"q=2r+s\times r")
    assert mend("q=2r+[r,s]", study=study).latex in ("q=2r-[r,s]", "q=2r+[s,r]")


def test_indices_are_mended_for_all_their_values():
    found = mend(r"\sum_{i=1}^2 v_iv_i=v_1^2+v_1^2")
    sums = ("v_1^2+v_2^2", "v_2^2+v_1^2")
    assert flat(found.latex) in [r"\sum_{i=1}^2v_iv_i=" + both for both in sums]


def test_values_on_relations():
    study = replace(STUDY, relations=(c**2 - m**2 - 1,))
    assert mend("c^2P=m^3P+P", study=study).latex == "c^2P=m^2P+P"


def test_of_two_equal_changes_the_one_that_is_printed_nearby_is_made():
    printed = r"\sum_{i=1}^2v_iv_i=v_1^2+v_1^2"
    for neighbour in ("v_1^2+v_2^2", "v_2^2+v_1^2"):
        spare = Spare(formulas=(f"y={neighbour}", f"v_i={neighbour}"))
        found = correct(formula(printed), Check(), STUDY, spare)
        assert found.latex.endswith("=" + neighbour)


def test_the_limits_of_an_integral_principle_bear_no_letter_of_something_else():
    study = Study({"T": x, "t": vo.time, "U": g(x)})
    for limit, said in (("T_1", True), ("T'_1", True), ("t_1", False), ("t'_1", False)):
        chain = read(rf"\int_{{{limit}}}^{{t_2}} U\,dt=0", study.vocabulary)
        assert ("bears the letter" in omission(chain, study)) is said


def test_a_sum_of_two_integrals_is_no_correction():
    """Energy and momentum of a free particle are constant, and so is their sum."""
    free = vo.System("particle", vo.Fibration((x,), ()), m * velocity(x) ** 2 / 2, parameters=(m,))
    eqs = vo.derive(free)
    names = {"T": eqs.theta, "m": m, "x": x, "v": velocity(x), "t": vo.time}
    study = Study(names, motion=Motion.of(eqs).solved(eqs), context=eqs)
    section = Section("s", (Display("$T+mx=const$"),), lambda _: {"only": study})
    (formula,) = Transcript(section).formulas()
    found = correct(formula, Check(), study, Spare.of(Transcript(section), study))
    assert found is not None and found.latex in ("T=const", "mv=const")
