"""Signs that are declared count: in equalities, claims, relations and charts, and for witnesses."""

from __future__ import annotations

import random

import pytest
import sympy as sp

import voronec as vo
from voronec.errors import DefinitionError
from voronec.proof.relations.families import carry_back

pytestmark = pytest.mark.slow

k, m, a, b = sp.symbols("k m a b", positive=True)
x, y, z = sp.symbols("x y z")
below = sp.Symbol("n", negative=True)
whole, odd = sp.Symbol("i", integer=True), sp.Symbol("j", odd=True)
root = sp.sqrt

TRUE = {
    "square of a sum": (root(a**2 + 2 * a * b + b**2), a + b),
    "product": (root(k * m, evaluate=False) * root(k), k * root(m)),
    "quotient": (m * root(m / k), root(m**3 * k) / k),
    "fourth roots": ((k * m**5) ** sp.Rational(1, 4), m * root(root(k * m))),
    "radicands of terms": (root((k + m * x**2) * a), root(k + m * x**2) * root(a)),
    "negative": (root(x**2 * below**2), -below * sp.Abs(x)),
    "difference of squares": (root(a**2 - b**2), root(a - b) * root(a + b)),
    "inner roots": (root(k * root(k * m)), root(k) * root(root(k)) * root(root(m))),
    "cosine of less than one": (root((2 + sp.cos(x)) ** 2), 2 + sp.cos(x)),
    "logarithm": (sp.log(k**2 * m / 4), 2 * sp.log(k) + sp.log(m) - 2 * sp.log(2)),
    "exponential of a logarithm": (sp.exp(x * sp.log(k * m)), k**x * m**x),
    "symbolic power": (sp.Pow(k * m, x, evaluate=False), k**x * m**x),
}  # fmt: skip


@pytest.mark.parametrize("sides", TRUE.values(), ids=TRUE)
def test_what_holds_for_declared_signs_is_proved(sides):
    assert vo.prove_equal(*sides).proved


def test_what_holds_for_positive_symbols_is_not_proved_without_them():
    plain = {s: sp.Symbol(s.name) for s in (k, m, a, b, below)}
    left, right = (e.xreplace(plain) for e in TRUE["square of a sum"])
    assert vo.prove_equal(left, right).refuted
    assert vo.prove_equal(root(plain[m] ** 2 * plain[k]), plain[m] * root(plain[k])).refuted


@pytest.mark.parametrize("sides", [
    (root(a**2 - 2 * a * b + b**2), a - b),
    (root(x**2 * k), x * root(k)),
    (root((x + a) ** 2), x + a),
    (root(below**2), below),
    (root(x * y) * root(x / y), x),
    (whole**2, whole), (odd + 1, odd**2),
])  # fmt: skip
def test_witnesses_lie_where_symbols_may(sides):
    verdict = vo.prove_equal(*sides)
    assert verdict.refuted
    symbols = set().union(*(s.free_symbols for s in sides))
    at = {s: sp.Rational(verdict.witness.point[s.name]) for s in symbols}
    for symbol, value in at.items():
        assert all(getattr(value, f"is_{fact}") == so for fact, so in symbol.assumptions0.items())
    left, right = (sp.N(s.subs(at), 40) for s in sides)
    assert abs(left - right) > 1e-20


def test_a_witness_that_cannot_be_is_none():
    assert vo.prove_equal(sp.Symbol("p", prime=True), 1).undecided
    between = sp.Symbol("k", noninteger=True)  # equal: k lies between whole numbers
    assert vo.prove_equal(sp.ceiling(between) - sp.floor(between), 1).undecided
    assert vo.prove_equal(root(whole - whole**2), 0).undecided  # real at 0 and 1 alone


def test_conditions_stand_beside_relations():
    assert vo.prove_equal(root(x**2), x, (x > 0,)).proved
    assert vo.prove_equal(root((x - y) ** 2), x - y, (x > y + z, z > 0)).proved
    verdict = vo.prove_equal(root(x**2), x, (x**2 + y**2 - 1, y > 0, x < y))
    assert verdict.refuted and -1 < sp.Rational(verdict.witness.point["x"]) < 0
    assert sp.Rational(verdict.witness.point["y"]) > 0


def test_what_has_no_value_equals_nothing():
    for thing in (sp.nan, sp.zoo, sp.oo):
        assert vo.prove_equal(thing, thing).undecided


def test_symbols_that_are_not_real_are_refused_in_one_line():
    with pytest.raises(DefinitionError, match="not real"):
        vo.prove_equal(sp.Symbol("w", imaginary=True) ** 2, 1)
    with pytest.raises(DefinitionError, match="not real"):
        vo.Parameter(sp.Symbol("w", imaginary=True))
    with pytest.raises(DefinitionError, match="declare it once"):
        vo.Parameter(sp.Symbol("w", negative=True), positive=True)


FACTORS = [k, m, a + b, a - b, x, k + x**2, -m, below, 1 + sp.cos(x), sp.sin(x)]


@pytest.mark.parametrize("seed", range(40))
def test_roots_of_products_of_signed_factors_agree_with_numbers(seed):
    """|f g h| against f g h: what is proved SymPy's numbers do not deny, nor what is refuted."""
    source = random.Random(seed)
    chosen = [(source.choice(FACTORS), source.choice((1, 2, 3, -1, -2))) for _ in range(3)]
    product = source.choice((1, -1)) * sp.Mul(*[f**e for f, e in chosen])
    verdict = vo.prove_equal(root(sp.expand(product**2)), product)
    agrees = set()
    for _ in range(20):
        at = {s: sp.Rational(source.randint(1, 40), 7) for s in (k, m, a, b)}
        at |= {below: -sp.Rational(source.randint(1, 40), 7)}
        at |= {x: sp.Rational(source.randint(-40, 40), 9)}
        value = sp.N(product.subs(at), 30)
        agrees |= {value >= 0} if value.is_finite else set()
    assert not (verdict.proved and False in agrees) and not (verdict.refuted and agrees == {True})


# -- systems ----------------------------------------------------------------------------------

M, K, C = sp.symbols("m k c")
X = vo.velocity(x)


def oscillator(*parameters, **declared):
    return vo.System(
        name="oscillator",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=M * X**2 / 2 - K * x**2 / 2,
        parameters=parameters,
        **declared,
    )


PLAIN = (vo.Parameter(M, 1), vo.Parameter(K, 1))
SIGNED = (vo.Parameter(M, 1, positive=True), vo.Parameter(K, 1, lower=sp.Rational(1, 10)))
ENERGY = root(K * M) * x**2 + M * root(M / K) * X**2


def statuses(system):
    return {c.name: c.verdict.status for c in vo.check_claims(system)}


def test_signs_of_parameters_count_in_claims():
    assert statuses(oscillator(*SIGNED, integrals={"e": ENERGY})) == {"e": "proved"}
    assert statuses(oscillator(*PLAIN, integrals={"e": ENERGY}))["e"] == "refuted"


def test_signs_that_sympy_knows_count_in_claims():
    mass, stiffness = sp.symbols("m k", positive=True)
    system = vo.System(
        name="oscillator",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=mass * X**2 / 2 - stiffness * x**2 / 2,
        parameters=(mass, stiffness),
        integrals={"e": ENERGY.xreplace({M: mass, K: stiffness})},
    )
    assert statuses(system)["e"] == "proved"


def test_what_is_possible_counts():
    claim = {"e": x * (root((K - 4 * M) ** 2) - K + 4 * M)}
    assert statuses(oscillator(*PLAIN, integrals=claim))["e"] == "refuted"
    possible = {"the spring is stiff": K > 4 * M}
    assert statuses(oscillator(*PLAIN, possible=possible, integrals=claim))["e"] == "proved"


def test_no_witness_lies_where_parameters_cannot():
    false = {"e": ENERGY + x, "f": (K - 4 * M) * x}
    possible = {"the spring is stiff": sp.And(K > 4 * M, M < 3)}
    for claim in vo.check_claims(oscillator(*SIGNED, possible=possible, integrals=false)):
        at = {s: sp.Rational(claim.verdict.witness.point[s.name]) for s in (K, M)}
        assert claim.verdict.refuted and possible["the spring is stiff"].subs(at) == sp.true
        assert at[M] > 0 and at[K] >= sp.Rational(1, 10)


def test_a_case_keeps_what_its_values_must_meet():
    rigid = {"e": root((K - 4 * M) ** 2) * x - (4 * C * M - 4 * M) * x}
    case = vo.Case({K: 4 * C * M}, integrals=rigid)
    stiff = {"the spring is stiff": K > 4 * M}
    parameters = (*SIGNED, vo.Parameter(C, 2))
    found = oscillator(*parameters, possible=stiff, cases={"one": case})
    assert statuses(found) == {"one: e": "proved"}


def test_signs_count_in_relations():
    """sqrt(k/m) and sqrt(k m)/m are one frequency; the map is one of positive parameters."""
    w = sp.Symbol("w")
    unit = vo.System(
        name="unit",
        fibration=vo.Fibration(base=(y,)),
        lagrangian=vo.velocity(y) ** 2 / 2 - w**2 * y**2 / 2,
        parameters=(vo.Parameter(w, 1, positive=True),),
    )
    scaled = root(K / M) * x, root(K * M) / M * X
    relation = vo.Relation(
        "oscillator", "unit", state={y: scaled[0], vo.velocity(y): scaled[1]},
        parameters={w: root(K / M)},
    )  # fmt: skip
    systems = (oscillator(*SIGNED), unit)
    assert vo.check_relation(relation, systems).verdict.proved
    wrong = vo.Relation(
        "oscillator", "unit", state={y: x, vo.velocity(y): X}, parameters={w: root(K * M)}
    )
    verdict = vo.check_relation(wrong, systems).verdict
    assert verdict.refuted and all(sp.Rational(verdict.witness.point[n]) > 0 for n in ("k", "m"))


def test_cuts_know_what_is_declared():
    """x^2 + a - b and x^2 + c are positive where parameters may lie: no state is on such a cut."""
    size, other, least = sp.symbols("a b c")
    below_zero = sp.Symbol("n", negative=True)
    parameters = (
        *SIGNED,
        vo.Parameter(size),
        vo.Parameter(other),
        vo.Parameter(least, 2, lower=1),
        vo.Parameter(below_zero),
    )
    above = (x**2 + size - other, x**2 + least, x**2 - below_zero)
    claims = {str(i): sp.sign(h) * (M * X**2 + K * x**2) for i, h in enumerate(above)}
    plain = {below_zero: sp.Symbol("n")}
    free = (*SIGNED, *(vo.Parameter(s) for s in (size, other, least, plain[below_zero])))
    spelled = {i: e.xreplace(plain) for i, e in claims.items()}
    assert "proved" not in statuses(oscillator(*free, integrals=spelled)).values()
    possible = {"a is larger": size > other}
    found = statuses(oscillator(*parameters, possible=possible, integrals=claims))
    assert found == dict.fromkeys(claims, "proved")


def test_what_has_no_value_on_a_cut_ends_without_a_proof():
    """With K, M of any sign a quotient of the rate has none where the sign's argument vanishes."""
    claim = {"e": sp.sign(x**2 + C) * ENERGY}
    assert statuses(oscillator(*PLAIN, vo.Parameter(C), integrals=claim))["e"] != "proved"


def test_a_quotient_by_a_sign_is_defined_off_its_zeros():
    size, product = sp.Abs(sp.cos(x)), sp.cos(x - y) * sp.cos(x + y)
    doubled = sp.cos(2 * x) / 2 + sp.cos(2 * y) / 2
    assert vo.prove_equal(sp.Abs(product) / sp.sign(size), sp.Abs(doubled)).proved
    assert vo.prove_equal(sp.Abs(product) / sp.sign(size), sp.Abs(doubled) + size).refuted


def test_what_jumps_where_parameters_cannot_lie_is_continuous():
    energy = M * X**2 / 2 - K * x**2 * sp.sign(x**2 + C) / 2

    def derived(*parameters):
        return vo.derive(
            vo.System("s", fibration=vo.Fibration((x,)), lagrangian=energy, parameters=parameters)
        )

    with pytest.raises(DefinitionError, match="jumps where"):
        derived(*PLAIN, vo.Parameter(C))
    assert derived(*PLAIN, vo.Parameter(C, 1, positive=True)).rates


def test_systems_are_compared_where_their_parameters_may_lie():
    def spring(frequency, *parameters):
        return vo.System(
            name="spring",
            fibration=vo.Fibration((x,)),
            lagrangian=(X**2 - frequency * x**2) / 2,
            parameters=parameters,
        )

    roots = root(K / M), root(K * M) / M
    assert vo.compare(*(spring(r, *SIGNED) for r in roots)).equal
    free = vo.compare(*(spring(r, *PLAIN) for r in roots))
    assert {row.status for row in free.differences} == {"refuted"}


def test_what_is_written_bounds_what_is_real_even_where_it_cancels():
    """sqrt(x)*sqrt(x), not evaluated, is real for x >= 0 alone, and so equals |x|; x does not."""
    x, y = sp.symbols("x y")
    written = sp.Mul(sp.sqrt(x), sp.sqrt(x), evaluate=False)
    assert vo.prove_equal(written, sp.Abs(x)).proved
    assert vo.prove_equal(x, sp.Abs(x)).refuted
    twice = sp.Mul(sp.sqrt(y) / sp.sqrt(x), sp.sqrt(x) * sp.sqrt(y), evaluate=False)
    assert vo.prove_equal(twice, sp.Abs(y)).proved
    logarithms = sp.Add(sp.log(y), -sp.log(y), sp.Abs(y), evaluate=False)
    assert vo.prove_equal(logarithms, y).proved
    found = vo.prove_equal(written, sp.Abs(x) + 1)
    assert found.refuted and sp.Rational(found.witness.point["x"]) >= 0


def test_the_logarithm_of_a_square_is_twice_that_of_the_size():
    """log(x**2) = 2*log(x) is neither proved nor refuted: for x < 0 the right side has no value."""
    assert vo.prove_equal(sp.log(x**2), 2 * sp.log(x)).undecided
    assert vo.prove_equal(sp.log(x**2), 2 * sp.log(sp.Abs(x))).proved
    assert vo.prove_equal(sp.log(x**2), 2 * sp.log(x), relations=[x > 0]).proved


def test_exponentials_of_what_is_positive_are_above_one():
    """sinh has the sign of its argument, so that half arguments have roots without sizes."""
    assert vo.prove_equal(sp.sinh(a / 2), root((sp.cosh(a) - 1) / 2)).proved
    assert vo.prove_equal(sp.sinh(below / 2), -root((sp.cosh(below) - 1) / 2)).proved
    assert vo.prove_equal(sp.sinh(x / 2), root((sp.cosh(x) - 1) / 2)).refuted
    assert vo.prove_equal(sp.sinh((a - b) / 2), root((sp.cosh(a - b) - 1) / 2)).refuted


def test_signs_count_where_a_limit_is_carried_back():
    """What vanishes by the signs of parameters need not be moved to zero."""
    m, k, small = sp.symbols("m k small")
    nothing = {"p": sp.sqrt(m * k**2) - k * sp.sqrt(m)}
    assert carry_back(nothing, {"p": small}, small, [k > 0, m > 0]) == {}
    assert carry_back(nothing, {"p": small}, small) != {}
