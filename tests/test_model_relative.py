"""Relative angles as variables of the smallest model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from model_agreement import agreed, kinds, names

import voronec as vo
from voronec.motion.formulation import smallest

pytestmark = pytest.mark.slow

RELATIVE = "coordinates with relative angles"


@pytest.fixture(scope="module")
def robot() -> vo.VoronecEquations:
    return vo.derive(vo.load("robot-with-two-trailers"))


def test_a_robot_needs_the_differences_of_its_headings(robot: vo.VoronecEquations) -> None:
    model = agreed(robot, ("v", "way"))
    assert model.formulation == RELATIVE
    assert names(model) == {"theta0 - theta1", "theta1 - theta2", "v"}
    assert kinds(model)["theta1"] == "replaced" and kinds(model)["theta0"] == "dropped"
    plain = next(c for c in model.candidates if c.formulation == "coordinates")
    chosen = next(c for c in model.candidates if c.chosen)
    assert chosen.weight < plain.weight and chosen.states < plain.states


@pytest.mark.parametrize("outputs", [("theta1",), ("theta2", "x")])
def test_the_headings_themselves_come_back(
    robot: vo.VoronecEquations, outputs: tuple[str, ...]
) -> None:
    model = agreed(robot, outputs)
    assert model.formulation == RELATIVE and "theta0" in names(model)


def test_numbers_are_those_of_the_equations_in_headings(
    robot: vo.VoronecEquations, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The headings of both, over several turns, and forwards as backwards."""
    times, shown = np.linspace(0, 30, 61), ("theta0", "theta1", "theta2", "v", "x")
    found = vo.integrate(robot, times=times, outputs=shown)
    assert found.cost.formulation == RELATIVE and abs(found["theta2"][-1]) > 10
    monkeypatch.setattr(smallest, "relative_formulation", lambda _: None)
    plain = vo.integrate(replace(robot), times=times, outputs=shown)
    assert plain.cost.formulation == "coordinates"
    for name in shown:
        assert found[name] == pytest.approx(plain[name], abs=1e-10)


def test_an_event_and_a_section_see_the_headings(robot: vo.VoronecEquations) -> None:
    motion = vo.integrate(robot, times=[0, 20], outputs=("v",), events=("theta2",))
    assert motion.cost.formulation == RELATIVE
    whole = vo.integrate(robot, times=[0, 20], events=("theta2",), method="scipy")
    assert len(motion.events["theta2"].t)
    assert motion.events["theta2"].t == pytest.approx(whole.events["theta2"].t, abs=1e-9)


x, a, b, c = sp.symbols("x a b c")


def rotors(potential: sp.Expr, coupling: sp.Expr | int = 0) -> vo.System:
    """Three rotors on one axis."""
    da, db, dc = map(vo.velocity, (a, b, c))
    return vo.System(
        name="rotors", fibration=vo.Fibration(base=(a, b, c)),
        lagrangian=(da**2 + 2 * db**2 + 3 * dc**2) / 2 + coupling * da * db - potential,
    )  # fmt: skip


def test_rotors_that_pull_at_one_another() -> None:
    pull = sp.cos(a - b) + sp.cos(b - c) * sp.cos(a - c)
    start = {"a": 1, "b": 0.3, "adot": 0.5}
    system = rotors(pull, sp.cos(a - b) / 2)
    model = agreed(system, ("adot",), initial=start)
    assert model.formulation == RELATIVE and len(model.states) == 5


def test_angles_that_turn_against_one_another_are_added() -> None:
    model = agreed(rotors(sp.cos(a + b - c)), ("adot",), initial={"a": 1, "adot": 0.5})
    assert any(each.formulation == RELATIVE for each in model.candidates)


@pytest.mark.parametrize(
    "potential", [sp.cos(a - b) + sp.cos(c) + sp.sin(b) * sp.sin(a), (a - b) ** 2 + sp.cos(a - c)]
)
def test_what_holds_an_angle_itself_keeps_it(potential: sp.Expr) -> None:
    model = agreed(rotors(potential), ("adot", "b"), initial={"a": 1, "c": 0.2, "adot": 0.5})
    assert {"a", "b"} <= names(model)
