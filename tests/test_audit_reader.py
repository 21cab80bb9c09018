"""LaTeX mathematics read into trees, and the values of the trees."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec import DefinitionError, prove_equal, velocity
from voronec.audit import Motion, Study
from voronec.audit.displays import split_display
from voronec.audit.meaning import evaluate
from voronec.audit.nodes import Bound, Chain, Dot, Elementary, Name, Partial, Power, Product
from voronec.audit.reader import read, read_name
from voronec.audit.vocabulary import Vocabulary

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
        (r"a+(b", r"'\)' is missing"),
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


def test_a_display_needs_its_delimiters():
    with pytest.raises(DefinitionError, match="must start with"):
        split_display("a=b")
    with pytest.raises(DefinitionError, match="is missing"):
        split_display(r"\begin{equation} a=b")
