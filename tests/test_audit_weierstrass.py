"""Elliptic functions in the audit: addition theorems and the inversion, against theta functions."""

from __future__ import annotations

from dataclasses import replace

import mpmath as mp
import pytest
import sympy as sp
from demchenko_audit import records_of

import voronec as vo
from voronec.audit import Display, Transcript, audit_section, load_paper

pytestmark = pytest.mark.slow

load_paper("demchenko")  # makes the folder of systems importable

from voronec.systems.demchenko.dictionary import inversion, weierstrass  # noqa: E402
from voronec.systems.demchenko.paper.addition_theorems import ADDITION_THEOREMS  # noqa: E402
from voronec.systems.demchenko.paper.inversion import INVERSION  # noqa: E402

PERIOD, NOME = mp.mpf("1.3"), mp.mpf("0.21")
"""A half period, and exp(i pi tau)."""


@pytest.fixture(scope="module")
def addition():
    return records_of(ADDITION_THEOREMS.title)


@pytest.fixture(scope="module")
def inverted():
    return records_of(INVERSION.title)


def log_theta(z, order):
    """Derivatives of log theta_1 at z."""
    t = [mp.jtheta(1, z, NOME, k) for k in range(order + 1)]
    a = [x / t[0] for x in t]
    if order == 1:
        return a[1]
    if order == 2:
        return a[2] - a[1] ** 2
    if order == 3:
        return a[3] - 3 * a[1] * a[2] + 2 * a[1] ** 3
    return a[4] - 4 * a[1] * a[3] - 3 * a[2] ** 2 + 12 * a[1] ** 2 * a[2] - 6 * a[1] ** 4


def scale():
    return mp.pi / (2 * PERIOD)


def eta():
    """zeta at the half period, over the half period."""
    ratio = mp.jtheta(1, 0, NOME, 3) / mp.jtheta(1, 0, NOME, 1)
    return -((mp.pi / PERIOD) ** 2) * ratio / 12


def sigma(z):
    theta = mp.jtheta(1, scale() * z, NOME) / (scale() * mp.jtheta(1, 0, NOME, 1))
    return mp.exp(eta() * z**2 / 2) * theta


def zeta(z):
    return eta() * z + scale() * log_theta(scale() * z, 1)


def wp(z, order=0):
    value = -(scale() ** (order + 2)) * log_theta(scale() * z, order + 2)
    return value - eta() if order == 0 else value


def invariants(z):
    g2 = 12 * wp(z) ** 2 - 2 * wp(z, 2)
    return g2, 4 * wp(z) ** 3 - g2 * wp(z) - wp(z, 1) ** 2


U, V = mp.mpf("0.83"), mp.mpf("0.31")


def numbers(law, u, v):
    """The symbols of an addition law with values from theta functions."""
    g2, g3 = invariants(mp.mpf("0.4"))
    values = {weierstrass.G2: g2, weierstrass.G3: g3}
    for point, z in ((law.u, u), (law.v, v)):
        values |= {point.p: wp(z), point.slope: wp(z, 1)}
        values |= {point.zeta: zeta(z), point.sigma: sigma(z)}
    return values


def at(expr, values):
    symbols = sorted(expr.free_symbols, key=str)
    return sp.lambdify(symbols, expr, "mpmath")(*(values[s] for s in symbols))


@pytest.fixture(autouse=True)
def forty_digits():
    with mp.workdps(40):
        yield


def close(a, b):
    return abs(a - b) < mp.mpf(10) ** -30 * (1 + abs(b))


def test_the_invariants_are_the_same_at_every_argument():
    for a, b in zip(invariants(mp.mpf("0.4")), invariants(mp.mpf("1.1")), strict=True):
        assert close(a, b)


def test_the_derived_addition_law_agrees_with_theta_functions():
    law = weierstrass.addition_law("u", "v")
    values = numbers(law, U, V)
    assert close(at(law.wp, values), wp(U + V))
    assert close(at(law.zeta, values), zeta(U + V) - zeta(U) - zeta(V))
    product = sigma(U + V) * sigma(U - V) / (sigma(U) * sigma(V)) ** 2
    assert close(at(law.sigma, values), product)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_functions_of_a_dictionary_agree_with_theta_functions(order):
    here, law = weierstrass.functions("u", "v")
    u, v = here.arguments
    values = numbers(law, U, V)
    values[sp.Symbol(r"\sigma{(u-v)}")] = sigma(U - V)
    given = here.names()[r"\wp" + "'" * order]
    for m, n in ((1, 0), (0, 1), (1, 1), (1, -1), (-1, 1), (-1, -1), (0, -1)):
        place = m * U + n * V
        assert close(at(given(m * u + n * v), values), wp(place, order))
        assert close(at(here.odd(here.zeta)(m * u + n * v), values), zeta(place))
        assert close(at(here.odd(here.sigma)(m * u + n * v), values), sigma(place))


def test_an_argument_that_is_no_sum_is_refused():
    here, _ = weierstrass.functions("u", "v")
    with pytest.raises(vo.DefinitionError, match="at the argument 2"):
        here.names()[r"\wp"](2 * here.arguments[0])


@pytest.mark.parametrize(("part", "factor"), [("wp", -1), ("zeta", 2), ("sigma", -1)])
def test_a_wrong_addition_law_is_not_proved(part, factor):
    law = weierstrass.addition_law("u", "v")
    wrong = replace(law, **{part: factor * getattr(law, part)})
    assert any(verdict.refuted for verdict in wrong.proofs().values())
    with pytest.raises(vo.DefinitionError, match="is not proved"):
        wrong.prove()


@pytest.mark.parametrize("part", ["wp", "zeta", "sigma"])
def test_a_constant_too_many_is_seen_by_the_limit(part):
    law = weierstrass.addition_law("u", "v")
    wrong = replace(law, **{part: getattr(law, part) + 1})
    assert any(verdict.refuted for verdict in wrong.proofs().values())


def test_every_addition_formula_is_proved(addition):
    assert [r.verdict for r in addition] == ["proved"] * 4 + ["cited"]
    assert "for all others it is quoted" in addition[4].decisive.method
    assert [r.label for r in addition[:2]] == ["eq:addition1", "eq:addition2"]


def test_the_verdicts_on_the_inversion(inverted):
    assert [r.verdict for r in inverted] == [
        *("definition", "proved", "proved", "misprint", "proved", "convention", "misprint"),
        *("definition", "proved", "proved", "proved", "proved", "proved"),
        *("definition", "proved"),
        *("proved", "misprint", "proved", "proved", "proved"),
    ]
    assert "say nothing of Weierstrass' function" in inverted[16].decisive.method


def test_the_two_misprints_of_the_quartic_are_corrected(inverted):
    first, second = inverted[3].formulas[0], inverted[6].formulas[0]
    compact = [f.correction.replace(" ", "") for f in (first, second)]
    assert compact[0].startswith(r"Y=(y^2-3\wp(\zeta))^2+2(2y\wp'(\zeta)-\wp''(\zeta))")
    assert r"+9\wp(\zeta)^2-2\wp''(\zeta)" in compact[1] or r"+9\wp^2(\zeta)" in compact[1]
    assert second.witness["printed"] != second.witness["derived"]


def test_the_quartic_agrees_with_theta_functions():
    values = {inversion.AT_C.p: wp(V), inversion.AT_C.slope: wp(V, 1), inversion.SECOND: wp(V, 2)}
    values[inversion.y] = (wp(U, 1) - wp(V, 1)) / (wp(U) - wp(V)) / 2
    polynomial = at(inversion.curve().polynomial, values)
    assert close(polynomial, (wp(U + V) - wp(U)) ** 2)
    printed = polynomial - 9 * wp(V) ** 2 + 9 * wp(V)
    assert not close(printed, (wp(U + V) - wp(U)) ** 2)


@pytest.mark.parametrize("u", [U, mp.mpf("2.2")])
def test_the_curve_gives_the_functions_at_u(u):
    values = {inversion.AT_C.p: wp(V), inversion.AT_C.slope: wp(V, 1), inversion.SECOND: wp(V, 2)}
    values[inversion.y] = zeta(u + V) - zeta(u) - zeta(V)
    rate = wp(u) - wp(u + V)
    curve = inversion.curve(1 if rate > 0 else -1)
    values[inversion.slope] = abs(rate)
    for order in range(3):
        assert close(at(curve.at_u[order], values), wp(u, order))
        assert close(at(curve.at_sum[order], values), wp(u + V, order))


def test_both_branches_of_the_root_occur():
    assert wp(U) > wp(U + V)
    assert wp(mp.mpf("2.2")) < wp(mp.mpf("2.2") + V)


def test_the_shift_of_any_quartic_is_found():
    shift, (p, first, second) = inversion.coefficients()
    a = dict(zip(inversion.QUARTIC_COEFFICIENTS, (3, -2, 5, 7, sp.Rational(1, 2)), strict=True))
    quartic = inversion.QUARTIC_COEFFICIENTS[0] * inversion.quartic(p, first, second)
    shifted = inversion.general(inversion.y + shift)
    assert sp.expand((shifted - quartic).subs(a)) == 0


def test_the_sign_of_the_root_names_the_formula_against_it(inverted):
    record = inverted[5].formulas[0]
    assert r"\sqrt{Y}=\wp(u)-\wp(u+\zeta)" in record.method
    assert r"\sqrt{X}=\sqrt{a_0}\frac{dx}{du}" in record.method


BROKEN = [
    (ADDITION_THEOREMS, 0, r"+\wp(u)", r"-\wp(u)"),
    (ADDITION_THEOREMS, 0, r"\frac14", r"\frac12"),
    (ADDITION_THEOREMS, 0, r"\wp'(u)-", r"\wp'(u)+"),
    (ADDITION_THEOREMS, 1, "-2(", "+2("),
    (ADDITION_THEOREMS, 1, r"\wp''(\zeta)", r"\wp''(u)"),
    (ADDITION_THEOREMS, 2, r"=-\frac", r"=\frac"),
    (ADDITION_THEOREMS, 2, r"\sigma(u)^2", r"\sigma(u)"),
    (ADDITION_THEOREMS, 3, r"+\zeta(u+v)", r"-\zeta(u+v)"),
    (ADDITION_THEOREMS, 3, r"2\zeta(u)", r"2\zeta(v)"),
    (INVERSION, 0, "2y", "y"),
    (INVERSION, 1, r"-3\wp", r"+3\wp"),
    (INVERSION, 2, "-2y", "+2y"),
    (INVERSION, 4, r"-\wp(u)", r"+\wp(u)"),
    (INVERSION, 7, "6a_2", "4a_2"),
    (INVERSION, 8, "-a_0a_2", "+a_0a_2"),
    (INVERSION, 8, "2a_1^3", "3a_1^3"),
    (INVERSION, 9, r"x=-\frac", r"x=\frac"),
    (INVERSION, 9, r"(-\wp(u+\zeta)+\wp(u))", r"(\wp(u+\zeta)-\wp(u))"),
    (INVERSION, 10, r"-\wp(u+\zeta)+", r"-\wp(u+\zeta)-"),
    (INVERSION, 11, r"=\sqrt{a_0}", r"=-\sqrt{a_0}"),
    (INVERSION, 12, r"\frac{u}{\sqrt{a_0}}", r"\frac{u}{a_0}"),
    (INVERSION, 12, r"\sqrt X", "X"),
]


@pytest.fixture(scope="module")
def studies():
    return {s.title: s.studies(Transcript(s)) for s in (ADDITION_THEOREMS, INVERSION)}


@pytest.mark.parametrize(("section", "position", "old", "new"), BROKEN)
def test_a_broken_formula_is_refuted_at_a_point(section, position, old, new, studies):
    display = section.displays[position]
    assert old in display.latex
    broken = Display(display.latex.replace(old, new, 1), display.checks)
    made = studies[section.title]
    alone = replace(section, displays=(broken,), inline=(), sentences=(), studies=lambda _: made)
    (record,) = audit_section(alone)
    assert record.verdict == "misprint"
    assert record.decisive.witness["printed"] != record.decisive.witness["derived"]
