"""Factors, terms and words that a formula lacks or has too many, and what else may be missing."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from voronec import time, velocity
from voronec.audit import Check, Display, Motion, Range, Section, Study, Transcript
from voronec.audit.correction import Correction, Spare, close_brackets, correct
from voronec.audit.latex.vocabulary import LatexVocabulary

pytestmark = pytest.mark.slow

v, w, a, m, J, u = sp.symbols("v omega a m J u")
W = velocity(w)
SLEIGH = Motion(
    rates={v: velocity(v), w: W, u: w},
    accelerations={velocity(v): a * w**2, W: -m * a * v * w / (J + m * a**2)},
)
NAMES = {"v": v, r"\omega": w, "a": a, "m": m, "J": J, "u": u, r"\Omega": w}
STUDY = Study(NAMES, motion=SLEIGH)


def mend(
    latex: str, check: Check | None = None, study: Study = STUDY, *others: str
) -> Correction | None:
    displays = tuple(Display(f"${text}$") for text in (latex, *others))
    transcript = Transcript(Section("s", displays, lambda _: {"only": study}))
    formula = next(iter(transcript.formulas()))
    return correct(formula, check or Check(), study, Spare.of(transcript, study))


def test_a_chain_of_inequalities_is_corrected_to_one_that_rises_or_falls():
    p, q, a, i = sizes = sp.symbols("p q A I", positive=True)
    names = {"b_0": a + i + p + q, "b_1": a + i + p, "P": a + i, "A": a, "I": i}
    study = Study(names, ranges=(Range("all", "p,q,A,I>0", {}, sizes),))
    found = mend("b_0>b_1<P=A+I", None, study)
    assert found is not None and flat(found.latex) == "b_0>b_1>P=A+I"


def flat(latex: str) -> str:
    return latex.replace(" ", "")


ENERGY = {"T": m * v**2 / 2 + (J + m * a**2) * w**2 / 2}


@pytest.mark.parametrize(
    ("printed", "mended"),
    [
        (r"T=mv^2+\frac12(J+ma^2)\omega^2", r"T=\frac12mv^2+\frac12(J+ma^2)\omega^2"),
        (r"T=\frac12mv^2+\frac12(J+a^2)\omega^2", r"T=\frac12mv^2+\frac12(J+ma^2)\omega^2"),
        (r"T=\frac12mv^2+\frac12(J+m)\omega^2", r"T=\frac12mv^2+\frac12(J+ma^2)\omega^2"),
        (r"T=\frac12v^2+\frac12(J+ma^2)\omega^2", r"T=\frac12mv^2+\frac12(J+ma^2)\omega^2"),
        (r"T=\frac12mv^2+\frac12(J+ma^2)", r"T=\frac12mv^2+\frac12(J+ma^2)\omega^2"),
        (r"2T=mv^2+(J+ma^2)\omega^2+mav", r"2T=mv^2+(J+ma^2)\omega^2"),
        (r"2T=mav^2+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
        (r"4T=mv^2+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
        (r"T=\frac{mv^2+(J+ma^2)\omega^2}{2a}", r"T=\frac{mv^2+(J+ma^2)\omega^2}{2}"),
        (r"2T=\frac{mv^2}{a}+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
        (r"2T=J+mv^2+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
        (r"2T=\sin mv^2+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
    ],
)
def test_a_factor_a_term_or_a_word_more_or_less(printed, mended):
    study = replace(STUDY, names={**NAMES, **ENERGY})
    assert mend(printed, study=study).latex == mended


@pytest.mark.parametrize(
    ("printed", "mended"),
    [
        (r"\dot v=a\omega", r"\dot v=a\omega^2"),
        (r"\dot v=\omega^2", r"\dot v=a\omega^2"),
        (r"(J+ma^2)\dot\omega=mav\omega", r"(J+ma^2)\dot\omega=-mav\omega"),
        (r"(J+m)\dot\omega=-mav\omega", r"(J+ma^2)\dot\omega=-mav\omega"),
        (r"(J+a^2)\dot\omega=-mav\omega", r"(J+ma^2)\dot\omega=-mav\omega"),
        (r"(J+ma^2)\dot\omega=-mv\omega", r"(J+ma^2)\dot\omega=-amv\omega"),
        (r"(J+ma^2)\dot\omega=-mav\omega-mv", r"(J+ma^2)\dot\omega=-mav\omega"),
    ],
)
def test_equations_of_motion_are_mended_along_the_motion(printed, mended):
    found = mend(printed)
    assert flat(found.latex) == flat(mended)


def test_with_a_truth_accelerations_are_free():
    def truth(study, where):
        return (J + m * a**2) * W + m * a * v * w

    found = mend(r"(J+m)\dot\omega=-mav\omega", Check(truth=truth))
    assert found.latex == r"(J+ma^2)\dot\omega=-mav\omega"


def test_a_derived_value_is_what_every_side_is_mended_to():
    check = Check(value=lambda study, where: m * a * v)
    assert mend("mv", check).latex in ("mav", "mva", "amv")
    assert mend("mav+J", check).latex == "mav"


def test_a_name_that_the_section_prints_elsewhere_is_put_in():
    names = {**NAMES, "B": m * sp.Symbol("R1") + J + v * a}
    r = {"r_1": sp.Symbol("R1"), "R_1": sp.Symbol("R1")}
    study = replace(STUDY, names={**names, **r})
    assert mend("B=m+J+va", None, study, "R_1=R_1").latex == "B=R_1m+J+va"
    assert mend("B=m+J+va", None, study).latex == "B=r_1m+J+va", "the dictionary has it"
    assert mend("B=m+J+va", None, replace(STUDY, names=names)) is None


@pytest.mark.parametrize("digit", "789")
def test_every_digit_is_tried(digit):
    study = replace(STUDY, names={**NAMES, "B": int(digit) * m + v + a * w + J})
    assert mend(r"B=4m+v+a\omega+J", study=study).latex == rf"B={digit}m+v+a\omega+J"
    study = replace(STUDY, names={**NAMES, "B": m / int(digit) + v + a * w + J})
    assert mend(r"B=\frac14m+v+a\omega+J", study=study).latex == rf"B=\frac1{digit}m+v+a\omega+J"


@pytest.mark.parametrize(
    ("printed", "mended"),
    [
        (r"\frac{T}{\partial v}=mv", r"\frac{\partial T}{\partial v}=mv"),
        (r"\frac{\partial T}{v}=mv", r"\frac{\partial T}{\partial v}=mv"),
        (r"\frac{u}{dt}=\omega", r"\frac{du}{dt}=\omega"),
        (r"\frac{du}{t}=\omega", r"\frac{du}{dt}=\omega"),
        (r"2T-mv^2+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
        (r"2T=mv^v+(J+ma^2)\omega^2", r"2T=mv^2+(J+ma^2)\omega^2"),
    ],
)
def test_a_sign_of_differentiation_a_relation_or_an_exponent(printed, mended):
    study = replace(STUDY, names={**NAMES, **ENERGY, "t": time})
    assert mend(printed, study=study).latex == mended


def test_open_brackets_are_closed_at_the_end():
    plain = LatexVocabulary()
    assert close_brackets("a(b+[c+(d", plain) == "a(b+[c+(d)])"
    assert close_brackets("a(b)", plain) is None
    assert close_brackets(r"a(b\frobnicate", plain) is None
    assert close_brackets("[a(b]", plain) is None
    study = replace(STUDY, names={**NAMES, "T": m * (v**2 + a**2 * w**2) / 2})
    assert mend(r"2T=m(v^2+[a^2\omega^2", study=study).latex == r"2T=m(v^2+[a^2\omega^2])"
