"""The values of LaTeX mathematics under a dictionary."""

from __future__ import annotations

import pytest
import sympy as sp

from voronec import DefinitionError, prove_equal, velocity
from voronec.audit import Motion, Study
from voronec.audit.latex.reader import read
from voronec.audit.latex.vocabulary import LatexVocabulary
from voronec.audit.meaning import direction, evaluate, rate

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
        (r"\sin{u}v", sp.sin(u) * v),
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
    wide = LatexVocabulary(wide_sums=True)
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
    study = Study({"x": x, "x^{I}": root, "X": x**4}, numbered=frozenset("x"))
    second = read(r"\frac{\partial^2 X}{\partial x^{I2}}", study.vocabulary).parts[0]
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
    assert value(r"-3{\partial\Theta}/{\partial u}") == -6 * u * v
    assert value(r"\frac{\partial^2\Theta}{\partial u^2}") == 2 * v
    assert value(r"\frac{\partial^2\Theta}{\partial u\partial v}") == 2 * u
    assert value(r"\dot u") == velocity(u)
    assert value(r"\dot v") == velocity(v)
    assert value(r"\ddot{v}") == a * velocity(u)


def test_an_unknown_name_is_named():
    with pytest.raises(DefinitionError, match=r"'\\omega_1' is not in the dictionary"):
        value(r"a+\omega_1")


def test_a_letter_that_looks_like_a_roman_numeral_is_an_exponent():
    x, V = sp.symbols("x V")
    study = Study({"x": x, "V": V})
    left, right = read("x^V x=x^{V+1}", study.vocabulary).parts
    assert prove_equal(evaluate(left, study), evaluate(right, study)).proved
    numbered = Study({"x": x, "x^{II}": V, "V": V}, numbered=frozenset("x"))
    assert evaluate(read("x^{II}", numbered.vocabulary).parts[0], numbered) == V


@pytest.mark.parametrize(
    ("first", "second"), [("a_{ij}", "a_{ji}"), ("G", r"\mathrm{G}"), (r"\dot u_1", r"\dot{u}_1")]
)
def test_two_spellings_of_one_name_are_refused(first, second):
    indices = {"i": 2, "j": 2}
    with pytest.raises(DefinitionError) as caught:
        _ = Study({first: a, second: b}, indices).table
    assert f"the names '{first}' and '{second}' of the study are the same" in str(caught.value)


def test_a_name_that_cannot_be_read_is_named():
    with pytest.raises(DefinitionError, match="the name 'bad name' of the study cannot be read: "):
        _ = Study({"bad name": a}).table
