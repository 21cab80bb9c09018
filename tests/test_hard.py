"""Hard cases: references that are right, condition numbers by formula, verdicts that can fail."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.accuracy.hard import (
    CASES,
    QUICK,
    HardCase,
    compute,
    every_case,
    named_cases,
    reference,
)
from voronec.accuracy.hard.case import case_formulation
from voronec.accuracy.hard.page import cells, page, tally
from voronec.accuracy.hard.reference import STORE, changed_data_reference
from voronec.accuracy.hard.trial import TOLERANCES, attempt, judge, trials
from voronec.accuracy.precise_motion import precise_integrator
from voronec.accuracy.solution import UNIT, ReferenceSolution
from voronec.motion.methods import METHODS

pytestmark = pytest.mark.slow

x, w = sp.symbols("x w")
Dx = vo.velocity(x)
PAGE = Path(__file__).resolve().parent.parent / "docs" / "hard-cases.md"
NAMED = {case.name: case for case in CASES}


def particle(force: sp.Expr) -> vo.System:
    """One coordinate, unit mass."""
    return vo.System(
        name="particle", fibration=vo.Fibration(base=(x,), fibre=()),
        lagrangian=Dx**2 / 2, forces={x: force}, parameters=(vo.Parameter(w, 2),),
    )  # fmt: skip


def on_the_line(end: float, points: int, **more: Any) -> HardCase:
    scene = vo.Scene({x: 1}, (0, end), {}, ("x",), "A particle on a line.")
    return HardCase("line", "particle", scene, points=points, **more)


def test_a_case_that_makes_no_sense_is_refused_with_the_mend() -> None:
    scene = vo.Scene({x: 1}, (0, 1), {}, ("x",))
    for wrong, said in (
        ({"formulation": "momenta"}, "give coordinates, invariants or ''"),
        ({"arithmetic": "double"}, "give quadruple or extended"),
        ({"methods": ("euler",)}, "method 'euler'"),
        ({"methods": [{}]}, "method '{}'"),
        ({"points": 1}, "give 2 or more"),
        ({"scene": vo.Scene({x: 1})}, r"give a scene with outputs"),
    ):
        with pytest.raises(vo.DefinitionError, match=said):
            HardCase(**{"name": "line", "system": "particle", "scene": scene, **wrong})


def test_names_are_unique_and_the_quick_ones_exist() -> None:
    assert len(NAMED) == len(CASES) and {*QUICK} <= {*NAMED}


def test_every_case_has_the_reference_of_its_own_declaration() -> None:
    kept = json.loads(STORE.read_text("utf-8"))
    assert {*kept} == {case.name for case in CASES if case.formulation}
    for case in CASES:
        if case.formulation:
            assert kept[case.name]["digest"] == case.digest, case.name
            found = reference(case)
            assert {*found.values} == {*found.condition} and len(found.t) == case.points


def test_two_runs_of_every_reference_agree_far_below_what_is_allowed() -> None:
    for case in CASES:
        if case.formulation and case.name != "past-the-horizon":
            known = reference(case)
            allowed = max(1e-10, 100 * UNIT * known.largest_condition)
            assert known.accuracy <= 1e-2 * allowed, (case.name, known.accuracy)


def test_a_changed_declaration_has_another_digest() -> None:
    case = NAMED["turning-point"]
    other = replace(case.scene, parameters={"k": 4})
    assert case.digest != replace(case, scene=other).digest
    assert case.digest == replace(case, methods=("scipy",)).digest


@pytest.mark.parametrize("name", ["chaotic-sleigh", "turning-point"])
def test_stored_values_are_those_of_the_integrator_in_25_digits(name: str) -> None:
    case = NAMED[name]
    known, few = reference(case), case.grid[:4]
    found = vo.integrate(
        vo.load(case.system), scene=case.scene, times=few, method="flint", tol=1e-25
    )
    for output, values in known.values.items():
        apart = np.abs((found[output] - values[:4]).astype(float)).max()
        assert apart <= 4 * UNIT * (1 + np.abs(values).max()), output


def test_condition_numbers_of_an_unstable_particle_follow_the_formula() -> None:
    pytest.importorskip("heyoka")
    case = on_the_line(3.0, 7)
    found = compute(case, vo.derive(particle(x)))
    t, end = found.t, 3.0
    assert found.values["x"] == pytest.approx(np.cosh(t), rel=1e-15)
    # an error of each state at s = 0 grows most: cosh(t) X_x + sinh(t) X_v over |o| = cosh(end)
    grown = np.cosh(t) * np.cosh(end) + np.sinh(t) * np.sinh(end)
    assert found.condition["x"] == pytest.approx(1 + grown / np.cosh(end), rel=1e-12)
    assert found.accuracy < 1e-25


def test_errors_made_on_the_way_count_where_they_grow_more_than_those_of_the_start() -> None:
    pytest.importorskip("heyoka")
    # damped: an error of the start is forgotten, exp(-12), one made at the end is not
    case = on_the_line(12.0, 25)
    damped = vo.derive(particle(-3 * Dx - 2 * (x - 1)))
    found = compute(case, damped)
    assert found.condition["x"][-1] >= 1.9


def test_a_parameter_in_error_counts() -> None:
    pytest.importorskip("heyoka")
    case = on_the_line(20.0, 11)
    found = compute(case, vo.derive(particle(-(w**2) * x)))
    t = found.t
    assert found.values["x"] == pytest.approx(np.cos(2 * t), abs=1e-15)
    data = 2 * t * np.abs(np.sin(2 * t))  # |dx/dw| |w|
    # of x: at most 1; of v: at most max|v| / w = 1
    made = found.condition["x"] - 1 - data
    assert (made <= np.sqrt(2) * 1.01).all() and (made >= 0.9).all()


def test_a_fraction_in_the_equations_is_not_rounded_to_a_double() -> None:
    pytest.importorskip("heyoka")
    found = compute(on_the_line(1000.0, 3), vo.derive(particle(-x / 3)))
    with mpmath.workdps(30):
        exact = [float(mpmath.cos(t / mpmath.sqrt(3))) for t in found.t]
    assert found.values["x"] == pytest.approx(exact, abs=2 * UNIT)


def test_counted_periods_are_the_whole_motion() -> None:
    pytest.importorskip("heyoka")
    oscillator = vo.derive(particle(-(w**2) * x - x**3))
    whole = compute(on_the_line(400.0, 5), oscillator)
    folded = compute(on_the_line(400.0, 5, period=str(Dx.name)), oscillator)
    assert folded.values["x"] == pytest.approx(whole.values["x"], abs=1e-16)
    assert folded.accuracy < 1e-15
    ratio = folded.condition["x"][1:] / whole.condition["x"][1:]
    assert (ratio > 0.5).all() and (ratio < 2).all()


def test_a_closed_form_and_heyoka_are_compared_in_many_digits() -> None:
    pytest.importorskip("heyoka")
    (case,) = named_cases(["no-gyroscope"], CASES)
    found = compute(case)
    assert "closed form" in found.provenance and found.accuracy < 1e-15


def test_a_motion_without_a_period_is_refused() -> None:
    pytest.importorskip("heyoka")
    case = on_the_line(100.0, 3, period=str(Dx.name))
    with pytest.raises(vo.IntegrationError, match="no period was found"):
        compute(case, vo.derive(particle(-x - Dx / 10)))


def test_data_that_are_no_doubles_keep_their_digits() -> None:
    (case,) = named_cases(["near-the-pole"], CASES)
    at = case_formulation(case, vo.derive(vo.load(case.system)))
    with mpmath.workdps(50):
        assert abs(at.start[0] - mpmath.mpf("0.001")) < 1e-48, "not the double next to it"
        assert abs(at.values[3] - mpmath.mpf("0.4")) < 1e-48


def test_changed_data_confirm_the_variational_equations() -> None:
    pytest.importorskip("heyoka")
    own, case = vo.derive(particle(x - w * x**3)), on_the_line(2.0, 4)
    found, exact = changed_data_reference(case, own), compute(case, own)
    assert found.values["x"] == pytest.approx(exact.values["x"], abs=1e-16)
    assert found.accuracy < 1e-18
    # errors of the data alone: lower than with those made on the way, by little here
    assert (found.condition["x"] <= exact.condition["x"] * 1.001).all()
    assert (found.condition["x"] >= exact.condition["x"] / 4).all()
    at, step = case_formulation(case, own), sp.Rational(1, 10**12)
    passage = precise_integrator(at, 1e-30).follow(case.grid)
    for by, value, slope in (
        ("initial", {"x": 1}, passage.steps[0][0, [*map(str, at.program.state)].index("x")]),
        ("parameters", {"w": 2}, passage.drives[0][0, 0]),
    ):
        ((name, datum),) = value.items()
        ahead, behind = (
            vo.integrate(
                own, case.scene, times=case.grid[:2], method="flint", tol=1e-25,
                **{by: {name: datum + change}},
            )["x"][1]
            for change in (step, -step)
        )  # fmt: skip
        assert float((ahead - behind) / (2 * step)) == pytest.approx(float(slope), rel=1e-11)


def test_without_heyoka_data_are_changed_or_a_case_is_unjudged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("voronec.accuracy.hard.trial.load", lambda _: particle(-x))
    monkeypatch.setitem(METHODS, "heyoka", replace(METHODS["heyoka"], library="no_such_library"))
    found = compute(on_the_line(1.0, 3), vo.derive(particle(-x)))
    assert "data changed" in found.provenance
    (finding,) = trials([on_the_line(1.0, 3, period=str(Dx.name))], ("scipy",))
    assert finding.trials[0].verdict == "unjudged"
    assert "takes heyoka, which is not installed" in finding.trials[0].reason


def trajectory(error: float, drift: float = 0.0) -> Any:
    """What a method may have found: the output x, at two instants."""
    return _Found({"x": np.array([1.0, 2.0 + 2 * error])}, drift)


class _Found(SimpleNamespace):
    def __init__(self, series: dict[str, np.ndarray], drift: float) -> None:
        super().__init__(
            series=series, drift={"energy": drift}, cost=SimpleNamespace(method="scipy", run=1.0)
        )

    def __getitem__(self, name: str) -> np.ndarray:
        return self.series[name]


def known(condition: float) -> ReferenceSolution:
    t, values = np.array([0.0, 1.0]), {"x": np.array([1.0, 2.0])}
    return ReferenceSolution(t, values, 0.0, (), condition={"x": np.array([1.0, condition])})


@pytest.mark.parametrize(
    ("error", "condition", "drift", "verdict"),
    [
        (0.9e-10, 1.0, 0.0, "met"),
        (1.1e-10, 1.0, 0.0, "missed"),
        (1.1e-10, 1e5, 0.0, "met"),
        (90 * UNIT * 1e8, 1e8, 0.0, "met"),
        (110 * UNIT * 1e8, 1e8, 0.0, "missed"),
        (np.nan, 1e8, 0.0, "missed"),
        (1.0, 1e15, 1e-13, "kept"),
        (1.0, 1e15, 1e-11, "lost"),
    ],
)
def test_an_error_is_judged_by_the_condition(
    error: float, condition: float, drift: float, verdict: str
) -> None:
    case = on_the_line(1.0, 2)
    trial = judge(case, "auto", trajectory(error, drift), known(condition))
    assert trial.verdict == verdict
    assert trial.good == (verdict in ("met", "kept"))
    if np.isfinite(error):
        assert trial.roundings == pytest.approx(error / UNIT / condition, rel=1e-3)


def test_an_output_that_is_zero_is_compared_absolutely() -> None:
    t, values = np.array([0.0, 1.0]), {"x": np.array([0.0, 1e-40])}
    zero = ReferenceSolution(t, values, 0.0, (), condition={"x": np.ones(2)})
    case = on_the_line(1.0, 2)
    assert judge(case, "auto", _Found({"x": np.array([0.0, 1e-16])}, 0.0), zero).verdict == "met"
    found = _Found({"x": np.array([0.0, 1e-9])}, 0.0)
    assert judge(case, "auto", found, zero).verdict == "missed"


def test_only_cases_past_the_horizon_have_no_digit_left() -> None:
    for case in CASES:
        if case.formulation:
            lost = 100 * UNIT * reference(case).largest_condition > 1
            assert lost == (case.name == "past-the-horizon"), case.name


def refuse(*_given: Any, **_named: Any) -> None:
    raise vo.IntegrationError("system 'line': no motion starts here")


def test_a_motion_where_none_starts_is_wrong_and_a_refusal_right(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = on_the_line(1.0, 2, formulation="")
    assert judge(case, "auto", trajectory(0.0), None).verdict == "missed"
    monkeypatch.setattr("voronec.accuracy.hard.trial.integrate", refuse)
    trial = attempt(case, vo.derive(particle(x)), "auto", None)
    assert trial.verdict == "refused" and trial.good and "no motion starts" in trial.reason


def test_the_tools_own_choice_is_never_silently_wrong_on_the_quick_cases() -> None:
    for finding in trials([NAMED[n] for n in QUICK], ("auto",)):
        assert finding.good, finding.trials


def test_the_choice_of_who_gives_no_tolerance_is_shown_and_does_not_decide(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(TOLERANCES, "default", 1e-4)
    finest, given = next(trials([NAMED["no-gyroscope"]], ("auto", "default"))).trials
    assert finest.verdict == "met" and finest.automatic
    assert given.verdict == "missed" and not given.automatic
    finding = next(trials([NAMED["no-gyroscope"]], ("default",)))
    assert finding.good and cells(finding.trials[0])[0].endswith("(default)")
    rows = {row[0]: row for row in tally([finding])}
    assert rows["default"][1] == "1" and rows["default"][-1] == "no-gyroscope"


def test_a_coarse_method_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(TOLERANCES, "auto", 1e-4)
    (finding,) = trials([NAMED["no-gyroscope"]], ("auto",))
    assert not finding.good and finding.trials[0].verdict == "missed"


def test_a_plugin_declares_cases_beside_its_system(monkeypatch: pytest.MonkeyPatch) -> None:
    from voronec.accuracy.hard import cases

    own = on_the_line(1.0, 2)
    entry = SimpleNamespace(name="particle", distribution="theirs", module="their_particle")
    bad = SimpleNamespace(name="other", distribution="theirs", module="their_other")
    monkeypatch.setitem(sys.modules, "their_particle", SimpleNamespace(HARD_CASES=(own,)))
    monkeypatch.setitem(sys.modules, "their_other", SimpleNamespace(HARD_CASES=("case",)))
    monkeypatch.setattr(cases, "entries", lambda: ((entry, bad), ()))
    found, warnings = every_case()
    assert found[-1] is own and len(found) == len(CASES) + 1
    (warning,) = warnings
    assert "other" in warning and "HARD_CASES = (HardCase(...),)" in warning


def test_the_committed_page_tells_every_case() -> None:
    text = PAGE.read_text("utf-8")
    for case in CASES:
        assert f"### {case.name}\n" in text and case.hard in text, case.name


def test_a_page_shows_refusals_with_their_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("voronec.accuracy.hard.trial.integrate", refuse)
    (finding,) = trials([NAMED["no-gyroscope"]], ("scipy",))
    assert "| refused: system 'line': no motion starts here |" in page([finding])
