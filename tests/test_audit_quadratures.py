"""The sections on the quadratures, the kinds of motion and the special solutions."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import pytest
import sympy as sp
from demchenko_audit import records_of
from voronec.systems.demchenko.dictionary import kinds_of_motion as kinds
from voronec.systems.demchenko.dictionary import stability
from voronec.systems.demchenko.dictionary.quadratures import RANGES, level, x
from voronec.systems.demchenko.paper.kinds_of_motion import KINDS_OF_MOTION
from voronec.systems.demchenko.paper.quadratures import QUADRATURES
from voronec.systems.demchenko.paper.special_solutions import SPECIAL_SOLUTIONS

from voronec.audit import FormulaRecord, Range, Record, Study, audit_section

pytestmark = pytest.mark.slow

OUTER, INNER, SHELL = RANGES


@cache
def study() -> Study:
    return level().study({})


@pytest.fixture(scope="module")
def records() -> dict[str, tuple[Record, ...]]:
    sections = (QUADRATURES, KINDS_OF_MOTION, SPECIAL_SOLUTIONS)
    return {section.title: records_of(section.title) for section in sections}


def formulas(records: tuple[Record, ...], kind: str) -> list[FormulaRecord]:
    return [f for r in records if r.kind == kind for f in r.formulas]


def in_ranges(record: FormulaRecord) -> tuple[str, ...]:
    return tuple(r["verdict"] for r in record.ranges)


def test_every_display_of_the_quadratures_has_its_verdict(
    records: dict[str, tuple[Record, ...]],
) -> None:
    found = [r.verdict for r in records[QUADRATURES.title] if r.kind == "display"]
    expected = "convention proved proved proved proved definition definition misprint misprint "
    assert found == (expected + "proved proved definition proved proved").split()


def test_the_misprints_are_corrected(records: dict[str, tuple[Record, ...]]) -> None:
    wrong = [f for r in records[QUADRATURES.title] for f in r.formulas if f.verdict == "misprint"]
    assert [f.correction for f in wrong] == [
        "b_0>b_1>P=A+I",
        r"b_2^2\tau^2=-2b_2A^2n^2+4b_2Ah-b_2^2s^2",
    ]
    assert all(f.witness for f in wrong)


def test_the_rate_of_x_is_true_in_another_unit_of_time(
    records: dict[str, tuple[Record, ...]],
) -> None:
    (rate,) = records[QUADRATURES.title][0].formulas
    assert "unit of time is $b_2/k$" in rate.method and "(4.4.13)" in rate.method
    assert rate.derived == r"\big(\frac{dx}{dt}\big)^2 = \frac{k^2}{b_2^2}X(x)"


def test_claims_hold_in_the_ranges_in_which_they_are_true(
    records: dict[str, tuple[Record, ...]],
) -> None:
    everywhere, outer = ("proved",) * 3, ("proved", "refuted", "refuted")
    found = {
        title: [in_ranges(f) for f in formulas(several, "text") if f.says]
        for title, several in records.items()
    }
    middle = [everywhere] * 9
    assert found[QUADRATURES.title] == [outer, *middle, outer]
    nowhere = ("refuted",) * 3
    kinds = [*[everywhere] * 2, nowhere, nowhere, *[everywhere] * 2, nowhere, nowhere]
    captions: list[tuple[str, ...]] = [()] * 9
    assert found[KINDS_OF_MOTION.title] == [*kinds, everywhere, everywhere, *captions]
    special = [(), everywhere, everywhere, outer, nowhere, nowhere, everywhere, outer]
    assert found[SPECIAL_SOLUTIONS.title] == [*special, *[everywhere] * 3]
    displayed = formulas(records[SPECIAL_SOLUTIONS.title], "display")
    assert [in_ranges(f) for f in displayed] == [everywhere] * 3 + [outer, everywhere]


BROKEN = [
    (0, "=X(x)", "=-X(x)"),
    (3, "=2h", "=h"),
    (5, "I\\mu +A,", "I\\mu -A,"),
    (9, "\\sin^2 u", "\\cos^2 u"),
    (11, "\\sqrt{2hA}", "\\sqrt{hA}"),
    (11, "{\\mu k}", "{\\mu' k}"),
    (12, "\\theta(x)", "\\phi(x)"),
    (13, "a_0(x-x^I)", "a_0(x+x^I)"),
]


@pytest.mark.usefixtures("no_corrections")
@pytest.mark.parametrize(("position", "old", "new"), BROKEN)
def test_a_change_of_a_correct_formula_is_noticed(position: int, old: str, new: str) -> None:
    displays = list(QUADRATURES.displays)
    latex = displays[position].latex.replace(old, new, 1)
    assert latex != displays[position].latex
    displays[position] = replace(displays[position], latex=latex)
    records = audit_section(replace(QUADRATURES, displays=tuple(displays), sentences=()))
    wrong = {r.ordinal - 1 for r in records if r.verdict == "misprint"}
    assert wrong == {position, 7, 8}  # two are wrong in print


def test_what_contradicts_the_claims_is_refuted() -> None:
    for second, third, truth in ((-1, 0, True), (1, 0, False), (0, 1, False), (0, -1, False)):
        assert stability.verdict_of_claim(stability.stable(second, third), truth).proved
        assert stability.verdict_of_claim(stability.stable(second, third), not truth).refuted
    assert kinds.sign_in_range(kinds.leading_coefficient(), ">", OUTER).refuted
    assert kinds.sign_in_range(
        kinds.leading_coefficient(), ">", INNER
    ).refuted  # it has either sign there
    assert kinds.sign_in_range(kinds.leading_coefficient(), "<", SHELL).refuted


@pytest.mark.parametrize("where", [INNER, SHELL], ids=["inner", "shell"])
def test_the_spinning_ball_that_is_not_stable(where: Range) -> None:
    """(k mu - b_1 n)^2 + 4 P n k mu < 0 by hand, at the witness."""
    witness = stability.stationary(study(), where).witness
    assert witness is not None
    at = {name: Fraction(value) for name, value in witness.point.items()}
    ratio = at["mu'"]
    assert -1 < ratio < 0 if where is INNER else ratio < -1
    assert 3 * at["A"] < 2 * at["I"] if where is INNER else 2 * at["A"] > at["I"]
    mu, P = 1 + ratio, at["I"] + at["A"]
    b1 = at["I"] * mu + at["A"]
    assert (at["k"] * mu - b1 * at["n"]) ** 2 + 4 * P * at["n"] * at["k"] * mu < 0


@pytest.mark.usefixtures("no_corrections")
@pytest.mark.parametrize(
    ("position", "old", "new"),
    [
        (0, "<0", ">0"),
        (0, "x^{I2}", "x^{I3}"),
        (1, ">0", "<0"),
        (2, "=0", "\\ne0"),
        (2, "\\partial^2", "\\partial^3"),
        (3, "=0", "\\ne0"),
        (4, "3", "2"),
    ],
)
def test_the_printed_conditions_of_stability_are_read(position: int, old: str, new: str) -> None:
    displays = list(SPECIAL_SOLUTIONS.displays)
    latex = displays[position].latex.replace(old, new)
    displays[position] = replace(displays[position], latex=latex)
    records = audit_section(replace(SPECIAL_SOLUTIONS, displays=tuple(displays), sentences=()))
    assert records[position].verdict in ("misprint", "undecided")


def test_a_root_of_order_four_is_stable_only_outside() -> None:
    """Without motion X vanishes for all x; set in motion, x runs over all of (-1, 1)."""
    assert stability.fourfold(study(), OUTER).proved
    for where in (INNER, SHELL):
        found = stability.fourfold(study(), where)
        assert found.refuted and "x drifts away" in found.method


@pytest.mark.parametrize("where", RANGES, ids=lambda where: where.name)
def test_witnesses_are_bodies(where: Range) -> None:
    """Mass within R2 of the centre, or for a shell beyond it, under Zhukovsky's condition."""
    degenerate = (
        kinds.body(where, kinds.leading_coefficient()) if where is not OUTER else kinds.body(where)
    )
    for numbers in (kinds.body(where), degenerate):
        A = numbers[sp.Symbol("A")]
        assert sp.Rational(1, 2) <= A if where is SHELL else 3 * A < 2


def test_a_spin_of_the_size_of_k_makes_the_nutation_large() -> None:
    """By hand: P taudot = k sin u, so that x leaves 0 at once; its reach is the next root of X."""
    for where in RANGES:
        found = stability.with_normal_spin(where)
        assert found.proved and "x runs from 0 beyond" in found.method


def test_motion_between_the_middle_roots() -> None:
    found = kinds.outer_gaps(study(), INNER)
    assert found.refuted and found.witness is not None
    assert found.witness.left == "2 roots below x"
    assert kinds.outer_gaps(study(), OUTER).proved


def test_polynomials_of_the_level() -> None:
    own = level()
    assert [sp.Poly(q, x).degree() for q in (own.X, own.phi, own.psi, own.F, own.theta)] == [
        4,
        2,
        2,
        2,
        2,
    ]
