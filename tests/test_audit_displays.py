"""A display, cut into its numbered units and formulas."""

from __future__ import annotations

import pytest

from voronec import DefinitionError
from voronec.audit.latex.displays import split_display


def test_a_display_is_split_into_numbered_units_and_formulas():
    display = r"""\begin{eqnarray}
    && T(t,q)=a, \label{one} \\
    && K = b\nonumber \\
    &=& c+\frac12 d, \quad A=B \qquad (i=1,\dots,n). \label{two}
    \end{eqnarray}"""
    one, two = split_display(display)
    assert (one.label, two.label) == ("one", "two")
    assert len(one.pieces) == 1
    chain, second = two.pieces
    assert [t.text for t in chain.tokens if t.text == "="] == ["=", "="]
    assert [t.text for t in second.tokens] == ["A", "=", "B"]
    assert second.quantifiers


def test_lines_of_an_aligned_display_belong_to_one_unit():
    display = r"""\begin{equation}\label{both}\begin{aligned}
    &a=b\\
    -&c=d,\quad \text{and}\quad e=f\\
    \end{aligned}\end{equation}"""
    (unit,) = split_display(display)
    assert unit.label == "both"
    assert ["".join(t.text for t in p.tokens) for p in unit.pieces] == ["a=b", "-c=d", "e=f"]


def formulas(display: str) -> list[str]:
    (unit,) = split_display(display)
    return ["".join(t.text for t in p.tokens) for p in unit.pieces]


def test_expressions_without_a_relation_stand_by_themselves_after_a_comma():
    assert formulas(r"\[ a+b,\quad c+d,\quad e \]") == ["a+b", "c+d", "e"]
    assert formulas(r"\[\begin{aligned} a[b],\\ c[d],\\ \end{aligned}\]") == ["a[b]", "c[d]"]
    assert formulas(r"\[\begin{aligned} a&=b\\ &+c,\\ d&=e\end{aligned}\]") == ["a=b+c", "d=e"]


def test_dots_between_formulas_are_no_formula_and_a_last_stop_is_left_out():
    assert formulas(r"\[ a_1=b, \dots, a_m=c. \]") == ["a_1=b", "a_m=c"]
    assert formulas(r"\[ a=2(b-c. \]") == ["a=2(b-c"]


def test_words_after_a_colon_belong_to_the_formula_and_for_all_quantifies():
    (piece,) = split_display(r"$\omega\colon \text{of $a$ in $b$, i.e. c},$")[0].pieces
    assert [t.text for t in piece.tokens][2:] == ["of $a$ in $b$, i.e. c"]
    (piece,) = split_display(r"$a=b \quad \mathrm{for\;all}\quad x\in D$")[0].pieces
    assert [[t.text for t in q] for q in piece.quantifiers] == [["x", r"\in", "D"]]


def test_the_size_of_a_bracket_belongs_to_it():
    source = r"$\big(a\big)^2=b$"
    (piece,) = split_display(source)[0].pieces
    assert source[slice(*piece.at)] == r"\big(a\big)^2=b"


def test_a_display_needs_its_delimiters():
    with pytest.raises(DefinitionError, match="must start with"):
        split_display("a=b")
    with pytest.raises(DefinitionError, match="is missing"):
        split_display(r"\begin{equation} a=b")
