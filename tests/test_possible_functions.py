"""Conditions on parameters that have no value at zero are conditions like others."""

import sympy as sp

import voronec as vo

x, k = sp.symbols("x k")
v = vo.velocity(x)


def test_condition_without_value_at_zero() -> None:
    spring = vo.System(
        name="spring",
        fibration=vo.Fibration((x,)),
        lagrangian=(v**2 - k**2 * x**2) / 2,
        parameters=(k,),
        possible={"k is positive, said at length": sp.atan(1 / k) + k > 0},
        integrals={"energy": v**2 + k**2 * x**2, "wrong": v**2 + k * x**2},
    )
    energy, wrong = vo.check_claims(spring)
    assert energy.verdict.proved
    assert wrong.verdict.refuted and sp.Rational(wrong.verdict.witness.point["k"]) > 0
