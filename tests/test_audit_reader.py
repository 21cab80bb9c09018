"""LaTeX mathematics read into trees."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec import DefinitionError
from voronec.audit import Study, Transcript, load_paper
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
from voronec.audit.latex.vocabulary import LatexVocabulary
from voronec.audit.meaning import evaluate

a = sp.Symbol("a")
f = sp.Function("f")


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
    assert read("X(x)", LatexVocabulary(functions=frozenset("X"))).parts[0].arguments
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


READ_WITH = LatexVocabulary(
    functions=frozenset(
        [*r"\wp \zeta(\cdot) \sigma \phi \psi \mu \mu_\epsilon \pi \theta X F V A".split()]
    ),
    labelled=frozenset(["B", r"\omega"]),
    numbered=frozenset("x"),
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


def part(latex: str, vocabulary: LatexVocabulary = READ_WITH):
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
    assert isinstance(part("y^V"), Power)
    assert part("x^{V+1}").base == Name("x")


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
    inside = read(r"a=x\in D")
    assert inside.relations == ("=", "=")
    assert inside.parts[2] == Call(Name(r"\in"), (Name("x"), Name("D")))
