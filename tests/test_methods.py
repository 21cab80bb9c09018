"""One problem by six methods: each against the multipliers at a point, each proved equal."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from typing import Any

import pytest
import sympy as sp
from tool_modules import tool

import voronec as vo
from voronec.audit.lessons import methods
from voronec.audit.lessons.methods import METHODS, MethodComparison, MethodEquations, compare_sides
from voronec.cli import main

PROBLEMS = ("sleigh", "vertical-disc", "two-wheeled-carriage", "snakeboard", "chaplygin-ball")
MORE = ("roller-racer", "ball-on-turntable", "sleigh-on-turntable", "suslov", "free-particle")
MORE += ("falling-disc", "veselova", "nonholonomic-particle")
WITHOUT_BODIES = ("sleigh-on-turntable",)

solved = cache(lambda name: vo.by_methods(vo.load(name)))


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS + MORE)
def test_all_methods_are_proved_equal(name: str) -> None:
    """Five equalities of six methods."""
    found = solved(name)
    assert len(found.methods) == len(METHODS) == 6
    assert [e.verdict.status for e in found.equalities] == ["proved"] * 5
    assert found.proved
    first = "d'Alembert" if name in WITHOUT_BODIES else "Newton and Euler"
    assert found.methods[0].name == f"{first}, with reactions"


def test_reactions_are_those_of_the_textbook() -> None:
    """A disc under its weight: the force at the contact acts on the centre, with its moment."""
    (balances, _) = solved("falling-disc").methods[0].steps
    text = {name: str(right) for name, (_, right) in balances.rows}
    assert text["disc, x"] == "N1" and text["disc, y"] == "N2"
    assert text["disc, z"] == "N3 - m*g" or text["disc, z"] == "N3 - g*m"
    assert text["disc, moment 2"] == "0"  # about the radius through the contact


@pytest.mark.slow
def test_a_wrong_body_is_refuted() -> None:
    """A force that is no weight, an inertia that the Lagrangian does not hold."""
    disc = vo.load("falling-disc")
    (body,) = disc.bodies
    for wrong in (
        replace(body, force=(0, 0, 0)),
        replace(body, inertia=(1, 2, 3)),
        replace(body, turning=body.omega),  # the axes of the inertia do not spin with the disc
    ):
        found = vo.by_methods(replace(disc, bodies=wrong))
        assert found.equalities[0].verdict.refuted and not found.proved


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rolling_disc", "chaos_pendulum", "three_wheeled_carriage"])
def test_bodies_of_models_of_sympy(name: str) -> None:
    """The bodies and loads of a model, which its Lagrangian and forces were made of otherwise."""
    found = vo.by_methods(vo.from_mechanics(tool("figures.mechanics_models").MODELS[name]()))
    assert found.methods[0].name.startswith("Newton") and found.proved


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"velocity": (1, 2)}, "the velocity of the body 'body' has 2 components; give three"),
        ({"inertia": (1, 2)}, "three principal moments"),
        ({"torque": (0, 0, "x")}, "turns nothing, for its omega is 0"),
        ({"force": ("x +", 0, 0)}, "the force of the body 'body'"),
        ({"mass": sp.Symbol("M")}, "the body 'body' contains 'M'"),
    ],
)
def test_wrong_bodies_are_refused(given: dict[str, Any], said: str) -> None:
    x = sp.Symbol("x")
    with pytest.raises(vo.DefinitionError, match=said):
        vo.System(
            name="slide", fibration=vo.Fibration((x,)), lagrangian=vo.velocity(x) ** 2,
            bodies=vo.Body(**{"mass": 1, **given}),
        )  # fmt: skip


def test_a_method_that_cannot_be_written_out_leaves_the_others(monkeypatch) -> None:
    def kane(problem):
        raise vo.EngineLimit("more terms than the budget")

    whole = solved("sleigh")
    own = tuple(kane if m is methods.kane else m for m in methods.METHODS)
    monkeypatch.setattr(methods, "METHODS", own)
    found = vo.by_methods(vo.load("sleigh"))
    assert [m.name for m in found.methods] == [m.name for m in whole.methods if m.name != "Kane"]
    assert found.proved and dict(found.limits) == {"kane": "more terms than the budget"}
    assert "The other methods give the same equations: proved." in str(found)
    assert found.as_dict()["limits"] == dict(found.limits)


@pytest.mark.slow
def test_what_is_too_large_is_told_in_one_line() -> None:
    with pytest.raises(vo.EngineLimit, match=r"bicycle.*no method done.*compared in numbers"):
        vo.by_methods(vo.load("bicycle"))


@pytest.mark.slow
@pytest.mark.parametrize("name", PROBLEMS + MORE)
def test_each_method_agrees_with_the_multipliers(name: str) -> None:
    """At a point, in numbers of the referee, which shares no code with any of them."""
    found = solved(name)
    system = found.problem.equations.system
    things = (*system.coordinates, *system.velocities, *(p.symbol for p in system.parameters))
    point = {x: sp.Rational(k + 3, 2 * k + 5) for k, x in enumerate(things)}
    expected = vo.multiplier_acceleration(system, point, digits=30)
    for method in found.methods:
        rates = _accelerations(found, method, point)
        values = {**point, **rates}
        for symbol, q in zip(found.problem.qdd, system.coordinates, strict=True):
            outside = found.problem.bridge.outward(found.problem.accelerations[symbol])
            assert abs(sp.N(outside.xreplace(values), 30) - expected[q]) < 1e-20, (method.name, q)


def _accelerations(
    found: MethodComparison, method: MethodEquations, point: dict[Any, Any]
) -> dict[Any, Any]:
    """The rates of the velocities that a method's equations give."""
    outward, symbols = (
        found.problem.bridge.outward,
        list(map(found.problem.bridge.outward, found.problem.vd)),
    )
    if method.solved:
        values = [sp.N(outward(e).xreplace(point), 40) for e in method.solved]
        return dict(zip(symbols, values, strict=True))
    residuals = [sp.expand(outward(e).xreplace(point)) for e in method.residuals]
    matrix, right = sp.linear_eq_to_matrix(residuals, symbols)
    return dict(zip(symbols, matrix.evalf(40).LUsolve(right.evalf(40)), strict=True))


@pytest.mark.parametrize("k", range(1, 6))
def test_a_method_with_a_fault_is_refuted(k: int) -> None:
    """A changed sign in a method's last equation shows, with a witness."""
    found = solved("sleigh")
    good = found.methods[k]
    bad = replace(good, residuals=(*good.residuals[:-1], good.residuals[-1] + found.problem.v[0]))
    assert compare_sides(found.problem, found.methods[k - 1], bad).verdict.refuted


def test_forces_and_time_and_no_constraint() -> None:
    """Friction, a law of motion in time, a Lagrangian with gyroscopic terms."""
    x, y, k, w = sp.symbols("x y k w")
    dx, dy = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="driven",
        fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(dx**2 + dy**2) / 2 + vo.time * (x * dy - y * dx) - x**2,
        constraints=(dy - x * sp.sin(w * vo.time) - dx * vo.time,),
        parameters=(k, w),
        forces={x: -k * dx, y: -k * dy},
    )
    found = vo.by_methods(system)
    assert found.proved
    point = {x: 2, y: 3, dx: 5, vo.time: 7, k: 11, w: 13}
    expected = vo.multiplier_acceleration(system, point)[x]
    for method in found.methods:
        (value,) = _accelerations(found, method, point).values()
        assert abs(value - expected) < 1e-20


def test_what_is_refused() -> None:
    """Redundant coordinates, and kinetic energies that are not quadratic."""
    x = sp.Symbol("x")
    quartic = vo.System("quartic", vo.Fibration((x,), ()), vo.velocity(x) ** 4)
    with pytest.raises(vo.DefinitionError, match="not quadratic"):
        vo.by_methods(quartic)
    with pytest.raises(vo.DefinitionError, match="independent coordinates"):
        vo.by_methods(vo.load("chaplygin-ball-in-rn"))


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    """Six headings and a proof; the same as data."""
    assert main(["methods", "vertical-disc"]) == 0
    text = capsys.readouterr().out
    for number, name in enumerate(
        ("Newton and Euler", "Lagrange", "Kane", "Gibbs", "Chaplygin", "Hamel")
    ):
        assert f"\n{number + 1}. {name}" in text
    assert len(re.findall(r"C\*dphidot/dt += 0\n", text)) == 6
    assert text.rstrip().endswith("All methods give the same equations: proved.")
    assert main(["methods", "vertical-disc", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["proved"] is True
    assert len(data["methods"]) == 6
    assert len(data["equalities"]) == 5
