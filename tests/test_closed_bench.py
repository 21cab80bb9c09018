"""The closed form as a contender and as a reference."""

import numpy as np
import pytest

import voronec as vo
from voronec.accuracy import reference as references
from voronec.accuracy.bench import measure, scene_problem
from voronec.accuracy.hard import CASES, reference
from voronec.accuracy.hard.case import case_formulation
from voronec.accuracy.hard.trial import attempt

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def equations():
    return vo.derive(vo.load("demchenko"))


def test_the_closed_form_takes_part_and_is_the_reference(equations):
    found = measure(scene_problem(equations, time=3.0, instants=21), methods=("closed-form",))
    assert "closed form" in found.reference.how[0]
    assert found.reference.accuracy < 1e-15
    assert not found.reference.note
    (row,) = found.methods
    assert [p.setting for p in row.points] == [1e-16]
    assert row.points[0].error < 1e-13


def test_a_long_motion_is_checked_on_its_beginning(equations, monkeypatch):
    monkeypatch.setattr(references, "CROSS_SPAN", 2.0)
    problem = scene_problem(equations, time=300.0, instants=5)
    found = references.reference(problem)
    assert len(found.t) == 5
    assert "agree up to t = 2" in found.note
    exact = vo.closed_form(equations, problem.bare).enclose(300, 20)
    for name in ("s", "tau", "n"):
        assert float(exact[name]) == pytest.approx(found.values[name][-1], abs=1e-15)


def test_a_reference_that_disagrees_is_not_the_closed_form(equations, monkeypatch):
    problem = scene_problem(equations, time=2.0, instants=5)
    right = references.closed_form_values(problem)
    wrong = {n: np.asarray(x, dtype=float) + 1e-6 for n, x in right.items()}
    monkeypatch.setattr(references, "closed_form_values", lambda _: wrong)
    assert references.closed_form_reference(problem, 1e-13) is None


def test_a_system_without_a_motion_has_another_reference():
    problem = scene_problem(vo.load("sleigh"), time=1.0, instants=5)
    assert references.closed_form_reference(problem, 1e-13) is None


@pytest.mark.parametrize("name", ["very-fast-gyroscope", "turning-point", "long"])
def test_hard_cases_are_met_by_the_closed_form(equations, name):
    (case,) = (c for c in CASES if c.name == name)
    trial = attempt(case, equations, "closed-form", reference(case, equations))
    assert trial.verdict == "met"
    assert trial.chosen == "closed-form"
    assert trial.error < 1e-13


def test_references_of_hard_cases_agree_with_the_closed_form(equations):
    (case,) = (c for c in CASES if c.name == "turning-point")
    found = references.closed_form_values(case_formulation(case, equations).problem)
    known = reference(case, equations)
    for name, values in known.values.items():
        assert np.abs(found[name].astype(float) - values).max() < 1e-15
