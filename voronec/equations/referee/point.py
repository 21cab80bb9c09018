"""Points at which equations are evaluated: who needs a value, and numbers taken exactly."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Set
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

import mpmath as mp
import sympy as sp

from voronec.algebra.symbols import plain_name, time
from voronec.algebra.text import as_expression, exact_number
from voronec.declaration.system import System
from voronec.equations.referee.names import rate_names
from voronec.errors import DefinitionError

__all__ = ["at_precision", "read_point"]

Exact: TypeAlias = Fraction | mp.mpf | sp.Expr
"""A number without error: a fraction, a binary number of any length, or an exact expression."""
LARGEST = 1e6
"""Logarithm of the largest power that a number may hold: towers of exponentials have no end."""


def read_point(system: System, point: Mapping[Any, Any], held: Set[str]) -> dict[str, Exact]:
    """The point by plain names, completed by the parameters' default values.

    Every coordinate, velocity and parameter must get a value; the time, inputs and their rates only
    where they occur, by their names, that is among ``held``.
    """
    constants = [p for p in system.parameters if isinstance(p.symbol, sp.Symbol)]
    needed = [*map(plain_name, (*system.coordinates, *system.velocities))]
    needed += [p.name for p in constants]
    clock = plain_name(time)
    driven = {name: u for u in system.inputs for name in rate_names(u)}
    values: dict[str, Exact] = {}
    for key, number in point.items():
        name = _name(system, key)
        if name not in needed and name not in (clock, *driven):
            raise DefinitionError(
                f"system '{system.name}': the point names '{name}', which is not one of its "
                f"coordinates, velocities and parameters; these are {', '.join(needed)}"
            )
        if name in values:
            raise DefinitionError(f"the point gives '{name}' twice; give it once")
        values[name] = _exact(name, number)
    for parameter in constants:
        if parameter.value is not None and parameter.name not in values:
            values[parameter.name] = _exact(parameter.name, parameter.value)
    if clock in held:
        needed.append(clock)
    for name in sorted(driven.keys() & held - values.keys()):
        raise DefinitionError(
            f"system '{system.name}': the unknown function '{driven[name]}' has no value; add "
            f"'{name}' to the point"
        )
    missing = [name for name in needed if name not in values]
    if missing:
        raise DefinitionError(
            f"system '{system.name}': the point gives no value for "
            f"{', '.join(repr(name) for name in missing)}; add it to the point"
        )
    values.setdefault(clock, Fraction(0))
    return values


def at_precision(values: Mapping[str, Exact]) -> dict[str, Any]:
    """The numbers as ``mpf`` at the working precision of mpmath."""
    return {name: _round(value) for name, value in values.items()}


def _name(system: System, key: Any) -> str:
    if isinstance(key, str):
        return key
    try:
        return plain_name(as_expression(key))
    except DefinitionError:
        raise DefinitionError(
            f"system '{system.name}': the point has the key '{key}', which is neither a symbol "
            "nor a name"
        ) from None


def _exact(name: str, number: Any) -> Exact:
    """A number as it stands: decimals in strings are decimals, floats are binary."""
    try:
        value = _read(number)
    except (DefinitionError, TypeError, ValueError, OverflowError, AttributeError):
        value = None
    if value is None:
        raise DefinitionError(
            f"the value of '{name}' is '{number}', which is not a real number "
            "of a size that can be written"
        )
    return value


def _read(number: Any) -> Exact | None:
    if isinstance(number, (str, Decimal)):
        return _read(exact_number(str(number), "a number"))
    if isinstance(number, Fraction):
        return number
    if isinstance(number, float):
        return Fraction(float(number)) if math.isfinite(number) else None
    if isinstance(number, (mp.mpf, sp.Float)):
        raw = mp.mp.make_mpf(number._mpf_)
        return raw if mp.isfinite(raw) else None
    if isinstance(number, sp.Lambda):
        return None
    if hasattr(number, "__index__") and not isinstance(number, sp.Basic):
        return Fraction(operator.index(number))
    value = as_expression(number)
    if isinstance(value, sp.Rational):
        return Fraction(int(value.p), int(value.q))
    if isinstance(value, sp.Float):
        return _read(value)
    if not isinstance(value, sp.Expr) or not value.is_number or _is_too_large(value):
        return None
    return value if value.is_real and value.is_finite else None


def _is_too_large(value: sp.Expr) -> bool:
    """Whether a power in it is beyond all sizes; what stands inside is looked at first."""
    for node in sp.postorder_traversal(value):
        if isinstance(node, sp.Pow | sp.exp):
            base, exponent = node.as_base_exp()
            size = abs(sp.log(sp.N(base, 5)) * sp.N(exponent, 5)) if base != 0 else 0
        elif isinstance(node, sp.sinh | sp.cosh):
            size = abs(sp.N(node.args[0], 5))
        else:
            continue
        if not size < LARGEST:
            return True
    return False


def _round(value: Exact) -> Any:
    if isinstance(value, Fraction):
        return mp.mpf(value.numerator) / value.denominator
    if isinstance(value, mp.mpf):
        return +value
    return mp.mp.make_mpf(sp.N(value, mp.mp.dps + 5)._mpf_)
