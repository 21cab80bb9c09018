"""LaTeX mathematics read into trees, and the values of the trees."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec import DefinitionError, prove_equal, velocity
from voronec.audit import Motion, Study
from voronec.audit.latex.displays import split_display
from voronec.audit.latex.nodes import (
    Bound,
    Call,
    Chain,
    Differential,
    Dot,
    Elementary,
    Listing,
    Name,
    Partial,
    Power,
    Product,
    Quotient,
    Wedge,
)
from voronec.audit.latex.reader import read, read_name
from voronec.audit.latex.vocabulary import Vocabulary
from voronec.audit.meaning import direction, evaluate, rate
from voronec.audit.transcript import Transcript
from voronec.catalogue import load_paper

a, b, u, v, k = sp.symbols("a b u v k")
f = sp.Function("f")

STUDY = Study(
    {
        "a": a,
        "b": b,
        "u": u,
        "v": v,
        "u_1": sp.Symbol("u1"),
        r"\mu'": sp.Symbol("mu1"),
        "k": k,
        "n": sp.Integer(3),
        "x_{i}": lambda i: sp.Symbol(f"x{i}"),
        r"\Theta": u**2 * v,
        r"\wp": lambda z: f(z),
    },
    indices={"i": 3, "j": 3},
    motion=Motion(
        rates={u: velocity(u), v: a * u, velocity(u): velocity(velocity(u))},
        constrained={velocity(v): a * u},
    ),
)


def value(latex: str, **where: int) -> sp.Expr:
    part = read(latex, STUDY.vocabulary).parts[0]
    return evaluate(part, STUDY, where)


def test_products_are_written_side_by_side():
    assert value("2ab") == 2 * a * b
    assert value(r"a\cdot b/k") == a * b / k


@pytest.mark.parametrize(
    ("latex", "expected"),
    [
        (r"\sin u\cos v", sp.sin(u) * sp.cos(v)),
        (r"\sin u v", sp.sin(u) * v),
        (r"\sin 2u", sp.sin(2 * u)),
        (r"\sin^2u_1", sp.sin(sp.Symbol("u1")) ** 2),
        (r"k\mu' \cos{u}_1", k * sp.Symbol("mu1") * sp.cos(sp.Symbol("u1"))),
        (r"\sin\big(u+v\big)a", sp.sin(u + v) * a),
        (r"\sqrt a b", sp.sqrt(a) * b),
        (r"\sqrt[3]{ab}", (a * b) ** sp.Rational(1, 3)),
        (r"-a^2", -(a**2)),
        (r"a^{-2}", a**-2),
        (r"\frac12ab", a * b / 2),
        (r"\frac ab", a / b),
        (r"\frac{a}{b}^2", a**2 / b**2),
        (r"a-b+k", a - b + k),
        (r"a(b+k)", a * (b + k)),
        (r"\wp(u+v)", f(u + v)),
    ],
)
def test_values(latex, expected):
    assert prove_equal(value(latex), expected).proved


def test_a_sum_sign_reaches_over_one_term_and_binds_its_index():
    summed = a * (value("x_1") + value("x_2") + value("x_3"))
    assert value(r"\sum_{i=1}^n x_i a+b") == sp.expand(summed) + b
    assert value(r"\sum_{i=1}^2\sum_{j=1}^i x_j") == 2 * value("x_1") + value("x_2")
    wide = Vocabulary(wide_sums=True)
    assert evaluate(read(r"\sum_{i=1}^n a+b", wide).parts[0], STUDY) == 3 * (a + b)


def test_a_sum_over_ordered_indices():
    pairs = value(r"\sum_{1\le i<j\le n} x_ix_j")
    x = [value(f"x_{i}") for i in (1, 2, 3)]
    assert sp.expand(pairs - (x[0] * x[1] + x[0] * x[2] + x[1] * x[2])) == 0
    assert value(r"\sum_{1\le i\le 2} x_i") == x[0] + x[1]
    assert value(r"\sum_{0<i<n} x_i") == x[0] + x[1]


def test_plus_or_minus_is_a_name_of_the_dictionary():
    for sign in (1, -1):
        study = Study({"a": a, "b": b, r"\pm": sp.Integer(sign)})
        assert evaluate(read(r"a\pm b").parts[0], study) == a + sign * b
        assert evaluate(read(r"a\mp b").parts[0], study) == a - sign * b


def test_differentials_are_rates_and_an_integral_without_limits_has_one():
    assert value("dv") == velocity(v)
    assert value("2u du") == 2 * u * velocity(u)
    assert value(r"d\Theta") == sp.expand(STUDY.motion.derivative(u**2 * v))
    integral = read(r"\int\frac{du}{\sqrt b}").parts[0]
    assert rate(integral, STUDY) == velocity(u) / sp.sqrt(b)
    assert rate(read("u^2").parts[0], STUDY) == 2 * u * velocity(u)
    with pytest.raises(DefinitionError, match="'da' has no value: its rate is not known"):
        value("da")


def test_nothing_is_known_of_a_partial_sign_by_itself():
    free = value(r"\frac{\Theta}{\partial u}") / (u**2 * v)
    assert free.free_symbols.isdisjoint({u, v})


def test_forms_act_on_velocities_and_variations_and_fields_are_formal():
    p, q, dp, dq = sp.symbols("p q dp dq")
    motion = Motion(rates={p: velocity(p), q: velocity(q)})
    study = Study({"p": p, "q": q, "a": a}, motion=motion, variations={p: dp, q: dq})

    def found(latex: str) -> sp.Expr:
        return sp.expand(evaluate(read(latex).parts[0], study))

    assert found(r"a dp\wedge dq") == sp.expand(a * (velocity(p) * dq - dp * velocity(q)))
    assert found(r"dq\wedge dq") == 0
    assert found(r"a\frac{\partial}{\partial q}") == a * direction(q)
    assert found(r"\frac{\partial}{\partial q} aq^2") == 2 * a * q


def test_a_derivative_may_be_taken_at_a_labelled_value():
    x, root = sp.symbols("x root")
    study = Study({"x": x, "x^{I}": root, "X": x**4})
    second = read(r"\frac{\partial^2 X}{\partial x^{I2}}").parts[0]
    assert evaluate(second, study) == 12 * root**2


def test_vectors_and_matrices():
    m, w = sp.diag(1, 2, 4), sp.Matrix([1, 1, 1])
    study = Study({r"\mathbf I": m, "w": w, "D": sp.Integer(3)})
    found = evaluate(read(r"(w-D\mathbf I^{-1}w,w)").parts[0], study)
    assert found == 3 - 3 * sp.Rational(7, 4)
    assert evaluate(read(r"[w,w]").parts[0], study) == sp.zeros(3, 1)
    assert evaluate(read(r"w\times w+w").parts[0], study) == w
    assert evaluate(read(r"\diag(1,2,4)-\mathbf I").parts[0], study) == sp.zeros(3, 3)
    assert evaluate(read(r"\det(\mathbf I)+\tr(\mathbf I)").parts[0], study) == 15


def test_index_expressions_are_computed():
    assert value("x_{n-i}", i=1) == sp.Symbol("x2")
    with pytest.raises(DefinitionError, match="no member"):
        value("x_{i-1}", i=1)


def test_derivatives():
    assert value(r"\frac{\partial\Theta}{\partial u}") == 2 * u * v
    assert value(r"\frac{\partial^2\Theta}{\partial u^2}") == 2 * v
    assert value(r"\frac{\partial^2\Theta}{\partial u\partial v}") == 2 * u
    assert value(r"\dot u") == velocity(u)
    assert value(r"\dot v") == velocity(v)
    assert value(r"\ddot{v}") == a * velocity(u)


def test_names_keep_accents_primes_indices_and_labels_apart():
    assert read_name(r"\alpha_1''") == read_name(r"\alpha''_1") == Name(r"\alpha''", sub=(ONE,))
    assert read_name(r"\tilde{\mathbf G}^{(M)}") == read_name(r"\tilde{\mathbf{G}}^{(M)}")
    assert read_name(r"\dot u_1") == read_name(r"\dot{u}_1") == read_name(r"{\dot u}_1")
    name = read(r"A_{ij}^{(\nu)}").parts[0]
    assert [i.head for i in name.sub] == ["i", "j"]
    assert [i.head for i in name.sup] == [r"\nu"]
    assert isinstance(read(r"\mathbf w^2").parts[0], Power)


ONE = read("1").parts[0]


def test_trees_know_their_place_in_the_source():
    source = r"a=\frac{\partial T}{\partial\dot q_i}\sin u"
    chain = read(source)
    assert isinstance(chain, Chain)
    product = chain.parts[1]
    assert isinstance(product, Product)
    partial, sine = product.factors
    assert isinstance(partial, Partial)
    assert isinstance(partial.variables[0], Dot)
    assert isinstance(sine, Elementary)
    assert source[slice(*partial.at)] == r"\frac{\partial T}{\partial\dot q_i}"
    assert source[slice(*sine.at)] == r"\sin u"


def test_a_parenthesis_applies_a_function_only_where_that_is_known():
    assert isinstance(read("P(s+1)").parts[0], Product)
    assert read("X(x)", Vocabulary(functions=frozenset("X"))).parts[0].arguments
    assert len(read(r"T(t,q_1,\dots,q_n)").parts[0].arguments) == 4
    assert isinstance(read(r"\sum_{i=1}^n x_i").parts[0], Bound)


@pytest.mark.parametrize(
    ("latex", "complaint"),
    [
        (r"a+\frobnicate b", r"character 3: '\\frobnicate' is not understood"),
        (r"a+(b", r"character 3: the '\(' here is not closed: '\)' is missing"),
        (r"2(a-(b+k)", r"character 2: the '\(' here is not closed: '\)' is missing"),
        (r"[a,b)", r"character 1: the '\[' here is not closed: '\]' is missing"),
        (r"\frac{a}{b", r"character 9: the '{' here is not closed: '}' is missing"),
        (r"a\dot 2", r"character 2: '\\dot' must not stand over a number"),
        (r"{a,b}", "a comma between braces is not understood"),
        (r"\wedge a", r"a factor before '\\wedge' is missing"),
        (r"\frac{\partial^k X}{\partial x}", "the order of a derivative must be a number"),
        (r"\sum_{1\le i} a", "a sum runs over indices between bounds"),
        (r"a=", "a term is missing"),
        (r"\frac{a}", "ends early"),
        ("a@b", "'@' is not understood"),
        (r"\sum_{i}^n a", "'=' is missing"),
        ("2_i", "an index must belong to a name"),
    ],
)
def test_what_is_not_understood_is_named_with_its_place(latex, complaint):
    with pytest.raises(DefinitionError, match=complaint):
        read(latex)


READ_WITH = Vocabulary(
    functions=frozenset([r"\wp", r"\zeta(\cdot)", r"\sigma", "X", r"\phi", "A"]),
    labelled=frozenset(["B", r"\omega"]),
)


def test_every_display_of_the_paper_is_read_or_its_open_bracket_is_shown():
    refused = []
    for section in load_paper("demchenko").sections:
        for formula in Transcript(section).formulas():
            try:
                formula.tree(READ_WITH)
            except DefinitionError as error:
                refused.append((formula.printed, str(error)))
    ((printed, complaint),) = refused
    assert printed.startswith("Y=(y-3")
    assert "the '(' here is not closed" in complaint
    assert r">>> (2y\wp'(\zeta)" in complaint


def part(latex: str, vocabulary: Vocabulary = READ_WITH):
    return read(latex, vocabulary).parts[0]


def test_a_function_and_a_variable_may_share_a_letter():
    call = part(r"\zeta(u-v)")
    assert isinstance(call, Call)
    assert call.function == Name(r"\zeta")
    assert part(r"\zeta") == Name(r"\zeta")
    assert isinstance(part(r"\wp(\zeta)").arguments[0], Name)
    assert part(r"\wp''(u)").function == Name(r"\wp''")
    assert read_name(r"\zeta(\cdot)") == Name(r"\zeta(\cdot)")
    both = Study({r"\zeta": a, r"\zeta(\cdot)": lambda z: f(z)})
    assert evaluate(part(r"\zeta(\zeta)", both.vocabulary), both) == f(a)


def test_a_power_of_a_call_is_no_argument():
    power = part(r"\sigma(u)^2")
    assert isinstance(power, Power)
    assert isinstance(power.base, Call)


def test_a_roman_numeral_above_is_a_label():
    assert part("x^{II}") == part("{x}^{II}") == Name("x", sup=(Name("II"),))
    assert part("x^I") == read_name("x^{I}") == Name("x", sup=(Name("I"),))
    second = part(r"\frac{\partial^2 X}{\partial x^{I2}}")
    assert second.variables == (part("x^I"), part("x^I"))
    assert isinstance(part("x^i"), Power)


def test_what_is_read_as_it_is_printed():
    assert part("q^q") == Power(Name("q"), Name("q"))
    assert part('D_1"') == read_name("D''_1")
    quotient = part(r"\frac{\bar{\Theta}}{\partial\dot u}")
    assert isinstance(quotient, Quotient)
    assert quotient.bottom == Differential(Dot(Name("u")), "\\partial")
    assert part(r"\overrightarrow{O_1O}") == Name(r"\overrightarrow{O_1O}")
    assert part(r"\mathbb F") == Name(r"\mathbb{F}")
    assert part(r"[\mathfrak v, \mathfrak M]").bracket == "["
    assert isinstance(part(r"A([X^h,Y^h])").arguments[0], Listing)


def test_signs_that_join_factors():
    wedge = part(r"B^\nu_{ij} dq_i\wedge dq_j")
    assert isinstance(wedge, Wedge)
    assert isinstance(wedge.left, Product)
    assert part(r"a\oplus b") == Call(Name(r"\oplus"), (Name("a"), Name("b")))
    assert part(r"\ker d\pi").function == Name(r"\ker")


def test_relations_of_place_make_a_chain():
    assert read(r"\pi\colon (a,\dots,b)\longmapsto c").relations == (r"\colon", r"\longmapsto")
    assert read(r"x\in D").relations == (r"\in",)


def test_an_unknown_name_is_named():
    with pytest.raises(DefinitionError, match=r"'\\omega_1' is not in the dictionary"):
        value(r"a+\omega_1")


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
