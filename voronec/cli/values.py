"""Numbers typed on a command line: a tolerance, and NAME=VALUE for parameters and starts."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.system import System

__all__ = ["finite", "pair", "split_values", "tolerance"]


def finite(text: str, place: str) -> float:
    """A number, which may be a fraction; ``DefinitionError`` names the place."""
    try:
        value = float(Fraction(text.strip()))
    except (ValueError, ZeroDivisionError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise DefinitionError(f"{place}: '{text}' is not a number")
    return value


def tolerance(text: str | None) -> float:
    """The value of ``--tol``; 1e-13 unless told."""
    if text is None:
        return 1e-13
    tol = finite(text, "--tol")
    if not 0 < tol < 1:
        raise DefinitionError(f"--tol {text}: give a number between 0 and 1, such as 1e-12")
    return tol


def pair(text: str) -> tuple[str, Any]:
    """NAME=VALUE; a decimal or a fraction is kept exactly."""
    import sympy as sp

    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name:
        raise DefinitionError(f"--set {text}: give NAME=VALUE, such as m=2.5 or a=1/3")
    finite(value, f"--set {name}")
    exact = Fraction(value)
    return name, sp.Rational(exact.numerator, exact.denominator)


def split_values(
    system: System, pairs: Iterable[tuple[str, Any]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values of parameters, and those of coordinates and velocities at the start."""
    from voronec.algebra.symbols import plain_name
    from voronec.catalogue import unknown

    constants = {p.name for p in system.parameters}
    movers = {plain_name(s) for s in system.known_symbols()} - constants - {"t"}
    parameters: dict[str, Any] = {}
    initial: dict[str, Any] = {}
    for name, value in pairs:
        if name not in constants | movers:
            kind = "parameter, coordinate or velocity"
            raise DefinitionError(
                f"system '{system.name}': {unknown(kind, name, constants | movers)}"
            )
        (parameters if name in constants else initial)[name] = value
    return parameters, initial
