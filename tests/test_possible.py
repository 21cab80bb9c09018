"""Parameters that no body can have are refused, whatever asks for a motion."""

from __future__ import annotations

import pytest
import sympy as sp

import voronec as vo

x, m, b = sp.symbols("x m b")


def sled(**more) -> vo.System:
    return vo.System(
        name="sled",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=m * vo.velocity(x) ** 2 / 2 - b * x,
        parameters=(vo.Parameter(m, 2), vo.Parameter(b, 1)),
        **more,
    )


LIGHT = "b is at most m / 2, as half of the sled is its runners"


def test_what_no_body_can_have_is_refused_with_its_reason_and_values():
    system = sled(possible={LIGHT: b <= m / 2})
    with pytest.raises(vo.DefinitionError, match=r"sled.*half of the sled.*m = 2, b = 1.5") as told:
        vo.integrate(system, times=[0, 1], initial={}, parameters={"b": 1.5})
    assert "\n" not in str(told.value)
    assert len(vo.integrate(system, times=[0, 1], initial={})) == 2


def test_the_border_is_decided_with_the_doubles_as_they_are():
    system = sled(possible={"3 b < m": 3 * b < m})
    near = 0.1 + 0.2  # larger than 3/10 by 4e-17
    with pytest.raises(vo.DefinitionError):
        vo.integrate(system, times=[0, 1], initial={}, parameters={"m": 0.9, "b": near})
    vo.integrate(
        system,
        times=[0, 1],
        initial={},
        parameters={"m": sp.Rational(901, 1000), "b": sp.Rational(3, 10)},
    )


@pytest.mark.parametrize("condition", [x > 0, b, True])
def test_a_condition_is_a_relation_of_parameters(condition):
    with pytest.raises(vo.DefinitionError, match="no relation of the system's parameters"):
        sled(possible={"so": condition})


def test_the_range_of_a_parameter_is_a_condition() -> None:
    """What SymPy knows of the symbol itself is none."""
    assert vo.Parameter(m, 2).conditions == ()
    assert vo.Parameter(m, 2, positive=True).conditions == (m > 0,)
    assert vo.Parameter(m, 2, lower=1, upper=3).conditions == (m >= 1, m <= 3)
    assert vo.Parameter(sp.Symbol("m", positive=True), 2, positive=True).conditions == ()
