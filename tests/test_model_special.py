"""What is zero and what first integrals give: frozen or left out only where that is proved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
import symengine as se
import sympy as sp
from model_agreement import agreed, kinds, names

import voronec as vo

# -- what is zero ----------------------------------------------------------------------------------

x, y, z, u, v, w, a, b, k, m = sp.symbols("x y z u v w a b k m")


def plane_system(**more: Any) -> vo.System:
    """Two oscillators, of which the second one is driven by the product of both."""
    dx, dy = vo.velocity(x), vo.velocity(y)
    return vo.System(
        name="plane",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=(dx**2 + dy**2) / 2 - (x**2 + y**2 + k * x * y**2) / 2,
        parameters=(vo.Parameter(k, 1),),
        **more,
    )


def test_a_start_on_an_invariant_plane_stays_there() -> None:
    model = agreed(plane_system(), ("x",), initial={"x": 0.3})
    assert names(model) == {"x", "xdot"} and kinds(model)["y"] == "zero"


def test_a_start_off_the_plane_does_not_count_as_on_it() -> None:
    model = agreed(plane_system(), ("x",), initial={"x": 0.3, "y": 1e-300})
    assert names(model) == {"x", "xdot", "y", "ydot"}


def test_a_velocity_that_is_zero_for_an_instant_only_is_kept() -> None:
    model = agreed(plane_system(), ("x",), initial={"y": 0.3})
    assert {"x", "y"} <= names(model)


def test_without_a_start_nothing_counts_as_zero() -> None:
    model = vo.explain(plane_system(), outputs=("x",))
    assert names(model) == {"x", "xdot", "y", "ydot"}


def test_a_parameter_that_is_zero_uncouples_what_it_couples() -> None:
    start = {"x": 0.3, "y": 0.2}
    apart = agreed(plane_system(), ("x",), initial=start, parameters={"k": 0})
    assert names(apart) == {"x", "xdot"}
    assert names(agreed(plane_system(), ("x",), initial=start)) == {"x", "xdot", "y", "ydot"}


def test_an_equilibrium_needs_no_integration() -> None:
    model = agreed(plane_system(), ("x", "y"), initial={})
    assert not model.states
    assert set(kinds(model).values()) == {"zero"}


def test_a_division_by_a_parameter_that_is_zero_is_left_as_it_is() -> None:
    dx = vo.velocity(x)
    force = sp.sin(a * x) / a
    system = vo.System(
        name="quotient", fibration=vo.Fibration(base=(x,)), lagrangian=dx**2 / 2,
        forces={x: -force}, parameters=(vo.Parameter(a, 1),),
    )  # fmt: skip
    model = vo.explain(system, outputs=("x",), initial={"x": 1}, parameters={"a": 0})
    assert se.Symbol("a") in {s for e in model.cut.force for s in e.free_symbols}


# -- first integrals -------------------------------------------------------------------------------


def line_system(rate: Any, integrals: Mapping[str, Any]) -> vo.System:
    """x is the angle of a free rotor; y' = rate(x) x', a rolling constraint."""
    dx, dy = vo.velocity(x), vo.velocity(y)
    return vo.System(
        name="line", fibration=vo.Fibration(base=(x,), fibre=(y,)),
        lagrangian=(dx**2 + dy**2) / 2 - sp.cos(x) / 4, constraints=(dy - rate * dx,),
        integrals=integrals,
    )  # fmt: skip


def test_a_proved_integral_stands_in_for_an_equation() -> None:
    model = agreed(line_system(sp.cos(x), {"a'b": y - sp.sin(x)}), ("y",), initial={"xdot": 1})
    assert kinds(model)["y"] == "integral" and "y" not in names(model)
    assert model.eliminating_integrals == ("a'b",)


def test_a_false_integral_is_never_used() -> None:
    system = line_system(sp.cos(x), {"height": y - 2 * sp.sin(x)})
    model = agreed(system, ("y",), initial={"xdot": 1})
    assert kinds(model)["y"] == "quadrature"


@pytest.mark.slow
def test_an_integral_with_a_branch_is_never_used() -> None:
    # d/dx atan(2 tan x) = 2/(1 + 3 sin(x)^2), but the function jumps where x passes a quarter turn
    rate = 2 / (1 + 3 * sp.sin(x) ** 2)
    for claim in (sp.atan(2 * sp.tan(x)), sp.atan2(2 * sp.sin(x), sp.cos(x))):
        model = agreed(line_system(rate, {"jump": y - claim}), ("y",), end=4, initial={"xdot": 2})
        assert kinds(model)["y"] == "quadrature"


def test_an_integral_that_would_enlarge_errors_is_not_used() -> None:
    steep = line_system(1000 * sp.cos(x), {"height": y - 1000 * sp.sin(x)})
    model = agreed(steep, ("y",), initial={"xdot": sp.Rational(1, 10)})
    assert kinds(model)["y"] == "quadrature"


def test_an_integral_that_holds_the_time_is_used_with_the_time() -> None:
    dx = vo.velocity(x)
    falling = vo.System(
        name="falling", fibration=vo.Fibration(base=(x,)), lagrangian=dx**2 / 2 - x,
        integrals={"fall": dx + vo.time},
    )  # fmt: skip
    model = agreed(falling, ("x",), initial={"x": 1, "xdot": 2})
    assert kinds(model)["xdot"] == "integral" and names(model) == {"x"}


def test_parameters_without_a_start_say_what_is_missing() -> None:
    with pytest.raises(vo.DefinitionError, match="name a scene, or give initial"):
        vo.explain(plane_system(), parameters={"k": 2})
