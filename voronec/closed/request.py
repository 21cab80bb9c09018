"""What users give who ask about a declared motion: a system, parameters, exact numbers."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import sympy as sp
from flint import arb

from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import compile_expressions, exact
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.reading import expression, fixed_mapping, quote, real_number
from voronec.declaration.system import System
from voronec.errors import DefinitionError, did_you_mean

__all__ = ["known_parameters", "number", "quadratures_of", "read_parameters"]


def quadratures_of(system: System) -> Quadratures:
    """The declaration; an error in one line where there is none."""
    if not isinstance(system, System):
        raise DefinitionError(f"'{quote(system)}' is no system; load one with vo.load")
    if not isinstance(system.motion, Quadratures):
        raise DefinitionError(
            f"system '{system.name}' declares no quadratures; give it motion=vo.Quadratures(...)"
        )
    return system.motion


def exact_instant(t: Any) -> Any:
    """A time as what it is: a ball, or an exact number."""
    if isinstance(t, arb):
        return t
    found = exact(real_number(t, "t"))
    if found.is_Rational:
        return Fraction(int(found.p), int(found.q))
    function = compile_expressions([found], ())
    return lambda _: function([])[0]


def read_parameters(system: System, parameters: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
    """Parameter -> expression, by the symbols of the system."""
    own = {p.name: p.symbol for p in system.parameters}
    found = {}
    for key, value in fixed_mapping(parameters, "parameters", "parameter: value").items():
        if plain_name(key) not in own:
            raise DefinitionError(
                f"system '{system.name}' has no parameter '{quote(key)}'"
                f"{did_you_mean(quote(key), own)}"
            )
        found[own[plain_name(key)]] = exact(expression(value, f"the parameter '{quote(key)}'"))
    return found


def known_parameters(system: System, parameters: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
    """Every parameter as an exact number: what is given, else the default."""
    given = read_parameters(system, parameters)
    found = {}
    for p in system.parameters:
        value = given.get(p.symbol, p.value)
        if value is None or not as_expression(value).is_number:
            raise DefinitionError(f"parameter '{p.name}' has no value; give parameters={{...}}")
        found[p.symbol] = exact(value)
    return found


def number(value: Any, name: str) -> sp.Expr:
    """An exact number."""
    number = exact(expression(value, name))
    if not number.is_number:
        raise DefinitionError(f"{name} = {quote(value)} is not a number; give one")
    return number
