"""Accelerations to the last digit, where cancellation and range try to spoil them."""

from __future__ import annotations

import pytest
import sympy as sp

import voronec as vo

x, y, a = sp.symbols("x y a")
Dx, Dy = vo.velocity(x), vo.velocity(y)


def test_a_small_component_beside_a_huge_one_is_not_taken_for_zero() -> None:
    big = sp.Integer(10) ** 60
    one = big * (sp.sqrt(a + 1) - sp.sqrt(a)) * (sp.sqrt(a + 1) + sp.sqrt(a)) - big + 1
    system = vo.System(
        name="pair",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=Dx**2 / 2 + Dy**2 / 2 + sp.Integer(10) ** 50 * x,
        forces={y: one},
        parameters=(a,),
    )
    point = {x: 0, y: 0, Dx: 0, Dy: 0, a: sp.Rational(1, 3)}
    found = vo.derive(system).acceleration(point, 30)
    assert abs(found[y] - 1) < sp.Float("1e-28", 30)


def test_beyond_the_range_of_doubles() -> None:
    eqs = vo.derive(vo.load("demchenko"))
    point = dict.fromkeys(("v", "theta", "u1", "v1", "s", "tau", "n"), 1) | {"u": "1e-200"}
    few, many = eqs.acceleration(point, 30), eqs.acceleration(point, 500)
    assert all(abs(few[q] / many[q] - 1) < sp.Float("1e-28", 30) for q in many)


def test_decimals_are_the_ones_written() -> None:
    assert vo.prove_equal(0.1234567890123456 * x, 0.1234567890123457 * x).refuted
    assert vo.prove_equal(9.81 * x, sp.Rational(981, 100) * x).proved


def test_relations_with_singular_zeros_refute_nothing() -> None:
    assert not vo.prove_equal(y**2, 2, (x - 1, (y**2 - 2) ** 2)).refuted
    assert not vo.prove_equal(x**2 + y**2, 1, (a, (x**2 + y**2 - 1) ** 2)).refuted


def test_an_undecided_switch_is_no_zero() -> None:
    """At 1/3, which no double or ball is, nobody sees on which side of x = k a point lies."""
    x, k = sp.symbols("x k")
    forces = (sp.Piecewise((x + 5, x <= k), (k + 5, True)), sp.floor(3 * x), sp.Heaviside(x - k))
    for force in forces:
        system = vo.System(
            name="switch", fibration=vo.Fibration(base=(x,)), forces={x: force},
            lagrangian=vo.velocity(x) ** 2 / 2, parameters=(vo.Parameter(k, sp.Rational(1, 3)),),
        )  # fmt: skip
        with pytest.raises(vo.DefinitionError, match="just where they switch"):
            vo.derive(system).acceleration({"x": "1/3", "xdot": 0})
        beside = vo.derive(system).acceleration({"x": "1/4", "xdot": 0})
        truth = force.subs({x: sp.Rational(1, 4), k: sp.Rational(1, 3)})
        assert abs(beside[x] - truth) < 1e-28
