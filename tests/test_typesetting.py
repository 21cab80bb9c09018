"""LaTeX of a paper typeset anew: as MathML for the page, coloured for the article."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from latex_shape import complaints

from voronec.audit import Transcript
from voronec.audit.page.article import display, escape_text, inline, own_commands
from voronec.audit.page.mathml import convert, mathml, prose
from voronec.audit.wording import readable
from voronec.declaration.catalogue import load_paper, papers
from voronec.errors import DefinitionError

SECTIONS = [
    pytest.param(section, id=f"{name}-{number}")
    for name in papers()
    for number, section in enumerate(load_paper(name).sections)
]
LONG = (
    r"K_1=M\sqrt{E_1}\big[(\epsilon s-\rho_u n)\cos\vartheta+"
    r"\left(\epsilon\tau-\rho_v n\right)\sin\vartheta\big]"
)


def plain(element: str) -> str:
    """The characters of a formula, without the elements around them."""
    return "".join(ElementTree.fromstring(element).itertext()).replace("\u2061", "")


@pytest.mark.parametrize(
    ("latex", "expected"),
    [
        (r"\frac12", "<mfrac><mn>1</mn><mn>2</mn></mfrac>"),
        (r"q_{ij}^{2}", "<msubsup><mi>q</mi><mrow><mi>i</mi><mi>j</mi></mrow><mn>2</mn>"),
        (r"\mu'", '<msup><mi>μ</mi><mo class="prime">′</mo></msup>'),
        (r"D_1''", '<msubsup><mi>D</mi><mn>1</mn><mo class="prime">″</mo></msubsup>'),
        (r"\sum_{i=1}^n", '<munderover><mo lspace="0" rspace="0">∑</mo>'),
        (r"\int\limits_a^b", '<munderover><mo lspace="0" rspace="0">∫</mo>'),
        (r"\int_a^b", '<msubsup><mo lspace="0" rspace="0">∫</mo>'),
        (r"\dot u", '<mover accent="true"><mi>u</mi>'),
        (r"\overrightarrow{OM}", "<mrow><mi>O</mi><mi>M</mi></mrow>"),
        (r"\mathbf M", "<mi>\U0001d40c</mi>"),
        (r"\mathfrak m_\mathbf u", "<msub><mi>\U0001d52a</mi><mi>\U0001d42e</mi></msub>"),
        (r"\mathbb FL", "<mi>\U0001d53d</mi><mi>L</mi>"),
        (r"\Gamma", '<mi mathvariant="normal">Γ</mi>'),
        (r"\sqrt[3]{x}", "<mroot><mi>x</mi><mn>3</mn></mroot>"),
        (r"\sin^2u", "<mi>sin</mi></mrow><mn>2</mn></msup><mo"),
        (r"a<b", "<mo>&lt;</mo>"),
        (r"-a", '<mo lspace="0" rspace="0">−</mo><mi>a</mi>'),
        (r"\text{of $M$ with}", "<mtext>of\xa0</mtext><mi>M</mi><mtext>\xa0with</mtext>"),
        (r"\diag(I_1)", "<mi>diag</mi>"),
        (r"\begin{pmatrix} a & b \\ c & d \end{pmatrix}", "<mtable"),
        (
            r"\left.\frac{a}{b}\right|_0",
            "<mfrac><mi>a</mi><mi>b</mi></mfrac><mo>|</mo></mrow><mn>0</mn></msub>",
        ),
    ],
)
def test_mathml(latex, expected):
    found = mathml(latex)
    assert expected in found
    ElementTree.fromstring(found)


def test_brackets_have_the_size_that_is_printed():
    assert 'minsize="1.2em"' in mathml(r"\big(\frac{a}{b}\big)")
    assert "<mo>(</mo>" in mathml(r"\left(\frac{a}{b}\right)")
    assert '<mo stretchy="false">(</mo>' in mathml(r"\left(a+b_1\right)"), (
        "it grows with what is tall"
    )
    assert '<mo stretchy="false">(</mo>' in mathml(r"(a+b_1)")


def test_a_bracket_that_is_not_closed_in_print_stays_as_it_is():
    assert plain(mathml(r"\frac12(P(s+\tau^2)")) == "12(P(s+τ2)"


def test_what_cannot_be_typeset_is_shown_as_its_source():
    assert mathml(r"\frac{a<") == r'<code class="latex">\frac{a&lt;</code>'


@pytest.mark.parametrize(
    "latex", ["{a", "a}", r"\left( a", r"a \right)", r"\begin{aligned} a", r"\frac{a}"]
)
def test_what_does_not_match_is_no_formula(latex):
    with pytest.raises(DefinitionError):
        convert(latex)


@pytest.mark.parametrize(
    ("marks", "expected"),
    [
        (((2, 3),), '<mrow class="m"><msub><mi>A</mi><mi>j</mi></msub></mrow>'),
        (
            ((3, 7),),
            '<mrow class="m"><mrow></mrow><mo>=</mo><msub><mi>B</mi><mi>i</mi></msub></mrow>',
        ),
        (((1, 1),), "<msub><mi>A</mi><mi>j</mi></msub>"),
    ],
)
def test_marked_characters_are_one_element_of_the_class(marks, expected):
    assert expected in mathml("A_j=B_i", marks, "m")


def test_a_bracket_that_is_added_is_marked():
    bracket = '<mrow class="m"><mo stretchy="false">)</mo></mrow>'
    assert bracket in mathml("2(a+b)", ((5, 6),), "m")
    assert bracket in mathml(r"(\frac{a}{b})", ((12, 13),), "m")


def test_an_accent_that_is_added_is_marked_with_its_letter():
    assert '<mrow class="m"><mover' in mathml(r"\dot q_1", ((0, 5),), "m")


def test_words_may_hold_formulas():
    assert prose("Where $a<b$ & so on") == f"Where {mathml('a<b', inline=True)} &amp; so on"
    assert prose("5 $ < 6") == "5 $ &lt; 6"


@pytest.mark.parametrize("section", SECTIONS)
def test_every_formula_of_the_papers_is_typeset(section):
    for shown in (*section.displays, *section.inline):
        found = mathml(shown.latex)
        assert "<code" not in found, shown.latex
        assert "\\" not in found, shown.latex
        assert own_commands(shown.latex) <= {"\\diag"}, shown.latex
        ElementTree.fromstring(found)
    for claim in section.sentences:
        assert "<code" not in prose(readable(claim.quotation))
        assert "$" not in prose(readable(claim.quotation))


@pytest.mark.slow
@pytest.mark.parametrize("section", SECTIONS)
def test_every_formula_of_the_papers_compiles_wherever_it_is_marked(section):
    for formula in Transcript(section).formulas():
        latex = formula.printed
        for start in range(0, len(latex), 7):
            text = display(latex, ((start, start + 5),), "struck")
            assert complaints(text) == [], text
        assert "\\label" not in display(latex)


def pieces(latex: str) -> list[str]:
    """The characters between the places where a line of the page may end."""
    found = ElementTree.fromstring(mathml(latex)).findall("math")
    return ["".join(piece.itertext()).replace("\u2061", "") for piece in found]


def test_a_line_of_the_page_may_end_before_a_sign_outside_short_brackets():
    assert pieces(LONG) == ["K1", "=M√E1[(ϵs−ρun)cosϑ+(ϵτ−ρvn)sinϑ]".replace("√", "")]
    assert pieces("a=(b+c)d-e") == ["a", "=(b+c)d", "−e"]
    long = pieces(LONG.replace("s-", "s+a+b+c+d+e+f+g+h+j+k-"))
    assert [part[0] for part in long] == ["K", "=", "+"]
    derived = "q=" + r"\left(" + "+".join(f"a_{n}" for n in range(20)) + r"\right)"
    assert len(pieces(derived)) == 21


def test_the_article_leaves_lines_to_tex():
    found = display(LONG)
    assert found.startswith("\\formulas{" + LONG + "}{")
    assert "\\left" not in found.removeprefix("\\formulas{" + LONG + "}")
    assert complaints(found) == []
    assert display("a=b") == "\\formula{a=b}\n"


@pytest.mark.parametrize(
    ("latex", "marks", "expected"),
    [
        ("A_j=B_i", ((2, 3),), r"{\struck{A_j}}=B_i"),
        (r"q_{n+\nu}", ((2, 9),), r"{\struck{q_{n+\nu}}}"),
        (r"q_{n+\nu}", ((4, 5),), r"{\struck{q_{n+\nu}}}"),
        (r"\frac{a}{b}", ((5, 10),), r"\frac{\struck{{a}}}{{\struck{b}}}"),
        (r"\frac{a}{b}", ((5, 11),), r"\frac{\struck{{a}}}{\struck{{b}}}"),
        (r"\left(a\right)", ((0, 7),), r"\left({\struck{a}}\right)"),
        (r"m_\mathbf v", ((10, 11),), r"{\struck{m_\mathbf v}}"),
        (r"\int_a^{t_2}b", ((9, 11),), r"\int_a^{{\struck{t_2}}}b"),
        (r"(a)^2", ((3, 5),), r"(a)^{\struck{2}}"),
        (r"\mathbf v", ((8, 9),), r"{\struck{\mathbf v}}"),
        (r"\big(a", ((4, 5),), r"{\struck{\big(}}a"),
        (r"a \label{x}= b", (), "a = b"),
    ],
)
def test_marks_in_latex_keep_the_braces_in_balance(latex, marks, expected):
    assert display(latex, marks, "struck").startswith(
        ("\\formula{" + expected + "}", "\\formulas{" + expected + "}")
    )


def test_lines_outside_an_environment_get_one():
    assert display(r"a &= b \\ c &= d").startswith("\\widetable{\\begin{aligned}")
    marked = "\\begin{aligned}\n{\\struck{a}} & {\\struck{b}}\n\\end{aligned}"
    assert display("a & b", ((0, 5),), "struck") == f"\\widetable{{{marked}}}\n"


def test_plain_text_is_escaped():
    assert escape_text(r"50% of {a_b} & \x") == r"50\% of \{a\_b\} \& \textbackslash{}x"
    assert escape_text("x ≥ ν") == r"x \ensuremath{\geq} \ensuremath{\nu}"
    assert inline(r"5% of $a_1$") == r"5\% of $a_1$"


def test_the_shape_of_latex_is_judged():
    assert complaints(r"{a} $b$ \begin{x} \[ \left( \right) \] \end{x} \{") == []
    for wrong in ("{", "}", "$a", r"\begin{x}", r"\begin{x} { \end{x} }", r"\left( }", r"\["):
        assert complaints(wrong), wrong


def test_numbers_keep_their_digits():
    assert re.findall(r"<mn>([^<]*)</mn>", mathml("1.25+300")) == ["1.25", "300"]
