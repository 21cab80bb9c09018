"""What a search may say: strong statements only where nothing hides behind the generators."""

from __future__ import annotations

import pytest
import sympy as sp

import voronec as vo
from voronec import velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.proof.search.independence import Independence

pytestmark = pytest.mark.slow

x, y, z, a, mu = sp.symbols("x y z a mu")
f = sp.Function("f")


def particle(potential: sp.Expr, *parameters: sp.Symbol) -> vo.System:
    """A particle in the plane."""
    return vo.System(
        name="particle",
        fibration=vo.Fibration((x, y)),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2 - potential,
        parameters=parameters,
    )


def linear(system: vo.System, **options: object) -> vo.IntegralSearch:
    return vo.search_integrals(system, degree=1, positions=1, **options)


HIDDEN = {
    "a constant": sp.exp(2 * sp.asinh(x)) - 2 * x * sp.sqrt(1 + x**2) - 2 * x**2,
    "a power": sp.exp(y * sp.log(x)) - x**y,
    "a base": sp.Integer(4) ** x - sp.Integer(2) ** (2 * x),
    "a square": sp.sqrt((1 + x**2) ** 2) - x**2,
    "a product of roots": sp.sqrt((1 + x**2) * (2 + y**2)) - sp.sqrt(1 + x**2) * sp.sqrt(2 + y**2),
    "a nested root": sp.sqrt(x**2 + 1 + 2 * x**2 * sp.sqrt(1 + x**2) + x**4)
    - sp.sqrt(1 + x**2)
    - x**2,
}


@pytest.mark.parametrize("potential", HIDDEN.values(), ids=HIDDEN)
def test_where_functions_may_depend_on_one_another_the_statement_is_conditional(
    potential: sp.Expr,
) -> None:
    """All these are constant for positive x and y, and momentum along x and y is an integral."""
    for place in ({x: 0.3, y: 0.7}, {x: 1.3, y: 0.2}):
        assert abs(float(potential.subs(place).diff(x).evalf())) < 1e-9
        assert abs(float((potential.diff(x) + potential.diff(y)).subs(place).evalf())) < 1e-9
    found = linear(particle(potential))
    assert found.assumed and not found.complete
    assert found.statement.startswith("Treating ") and "independent (not proved)" in found.statement
    assert found.as_dict()["assumed"] and not found.as_dict()["complete"]


CERTAIN = {
    "an exponential": (sp.exp(x * y) + sp.exp(x) * y, ()),
    "an angle and its exponential": (sp.exp(x) * sp.sin(x) + y**3, ()),
    "bells": (sp.exp(-((x - y) ** 2)) + sp.exp(x + y) * y, ()),
    "a symbolic power": ((1 + x**2 + y**2) ** mu, (mu,)),
    "a symbolic root": ((1 + x**2 + y**2) ** (1 / mu), (mu,)),
    "a growth": (sp.exp(mu * sp.asinh(x)) * y, (mu,)),
    "roots": (sp.sqrt(1 + x**2) * sp.sqrt(2 + y**2) + sp.sqrt(2) * x, ()),
    "roots of parameters": (sp.sqrt(a) * x**2 + y * x * sp.sqrt(a + 1), (a,)),
    "a nested root": (sp.sqrt(y + 3 + sp.sqrt(1 + x**2)), ()),
    "a power of a number": (sp.Integer(2) ** x * y, ()),
}


@pytest.mark.parametrize(("potential", "parameters"), CERTAIN.values(), ids=CERTAIN)
def test_where_functions_are_independent_the_statement_is_not_conditional(
    potential: sp.Expr, parameters: tuple[sp.Symbol, ...]
) -> None:
    found = linear(particle(potential, *parameters))
    assert found.complete and found.assumed == () and "Treating" not in found.statement
    assert "log" not in found.statement  # no number counts among the generic parameters


def test_functions_of_bound_variables_are_not_certain() -> None:
    """On the circle exp(x^2 - 1) is exp(-y^2)."""
    turning = sp.Symbol("w")
    circle = vo.System(
        name="circle",
        fibration=vo.Fibration((x, y), relations=(x**2 + y**2 - 1,)),
        frame=vo.Frame.quasi({turning: x * velocity(y) - y * velocity(x)}),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2 - sp.exp(x**2 - 1) + sp.exp(-(y**2)),
    )
    found = linear(circle)
    assert {*found.assumed} >= {sp.exp(x**2 - 1), sp.exp(-(y**2))} and not found.complete


@pytest.mark.parametrize(
    ("potential", "names"),
    [
        (f(x) + f(y), "f(x), f(y)"),
        (f(x, y), "f(x, y)"),
        (f(x) + a * y, "a, f(x)"),
    ],
)
def test_unknown_functions_are_named_among_what_is_generic(potential: sp.Expr, names: str) -> None:
    found = linear(particle(potential, *sorted(potential.free_symbols - {x, y}, key=str)))
    assert f"for generic {names}" in found.statement
    assert "Special functions may allow more" in found.statement
    assert found.complete and len(found.as_dict()["unknown"]) == len(found.unknown)


def test_unknown_functions_at_places_that_may_be_equal_are_not_certain() -> None:
    bridge = SymPyBridge()
    here, there, apart = map(bridge.inward, (f(2 * x), f(x + sp.asinh(sp.sinh(x))), f(y)))
    assert Independence.of([here], (), ()).assumed == ()
    assert {*Independence.of([here, there], (), ()).assumed} >= {here, there}
    assert Independence.of([apart, bridge.inward(f(x))], (), ()).assumed == ()
    bound = [bridge.inward(x - y)]
    assert len(Independence.of([apart, bridge.inward(f(x))], bound, ()).assumed) == 2


# -- roots of numbers ---------------------------------------------------------------------


@pytest.mark.parametrize("name", ["sleigh", "growing-sleigh"])
@pytest.mark.parametrize("mass", [2, sp.Rational(3, 2)])
def test_a_root_of_a_number_that_one_prime_does_not_have_is_found_by_another(
    name: str, mass: sp.Expr
) -> None:
    system = vo.load(name)
    generic = vo.search_integrals(system, degree=2, positions=0)
    found = vo.search_integrals(system, degree=2, positions=0, at={"m": mass, "J": 1})
    assert found.complete and found.dimension == generic.dimension


@pytest.mark.parametrize("number", [2, 3, 5, 6])
def test_integrals_are_lifted_where_roots_of_numbers_occur(number: int) -> None:
    found = linear(particle(sp.sqrt(number) * (x + y) ** 4), again=True)
    (difference,) = found.new
    assert sp.cancel(difference.expression / (velocity(x) - velocity(y))).is_number
    assert found.complete and difference.verdict.proved


def test_where_too_few_primes_have_the_roots_nothing_is_denied() -> None:
    found = linear(particle(sp.sqrt(30) * (x + y) ** 4), again=True)
    assert found.dimension == 2 and found.missing + len(found.integrals) == 1
    with pytest.raises(vo.EngineLimit, match="no prime was found modulo which all roots"):
        linear(particle(sp.sqrt(2 * 3 * 5 * 7 * 11 * 13) * (x + y) ** 4))
