"""Functions that programs alone know, with values where their formulas overflow, cancel or fail.

    sinc w = sin(w)/w,    sinhc w = sinh(w)/w,    exprel w = (exp(w) - 1)/w    (entire)
    expm1 w = exp(w) - 1,    log1p x = log(1 + x)            (all digits where they are small)
    hypot(a, b, ...) = sqrt(a^2 + b^2 + ...)                 (squares overflow before it does)
    size w = |w|      in expressions that are equal for both signs of w, so that it is no wall

They are unknown functions of these names; proofs see their formulas.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import symengine as se

__all__ = [
    "EXPM1", "EXPREL", "FORMULAS", "HYPOT", "LOG1P", "SINC", "SINHC", "SIZE", "elementary",
    "formula", "numeric_name",
]  # fmt: skip

SINC, SINHC, EXPREL = "cardinal sine", "hyperbolic cardinal sine", "relative exponential"
EXPM1, LOG1P = "exponential less one", "logarithm beside one"
HYPOT, SIZE = "length of sides", "size on equal sides"

FORMULAS: dict[str, Callable[..., Any]] = {
    SINC: lambda w: se.sin(w) / w,
    SINHC: lambda w: se.sinh(w) / w,
    EXPREL: lambda w: (se.exp(w) - 1) / w,
    EXPM1: lambda w: se.exp(w) - 1,
    LOG1P: lambda x: se.log(1 + x),
    HYPOT: lambda *sides: se.sqrt(se.Add(*[a**2 for a in sides])),
    SIZE: se.Abs,
}
"""By name, the formula; no function of a user has a name of several words."""


def numeric_name(expr: Any) -> str | None:
    """The name of a function of this kind; None for any other expression."""
    name = expr.get_name() if isinstance(expr, se.FunctionSymbol) else None
    return name if name in FORMULAS else None


def formula(expr: Any) -> Any | None:
    """A function of this kind by its formula; None for any other expression."""
    name = numeric_name(expr)
    return FORMULAS[name](*expr.args) if name is not None else None


def elementary(expr: Any) -> Any:
    """The expression with formulas for all these functions."""
    found = {f: formula(f) for f in expr.atoms(se.FunctionSymbol)}
    while any(f is not None for f in found.values()):
        expr = expr.xreplace({f: e for f, e in found.items() if e is not None})
        found = {f: formula(f) for f in expr.atoms(se.FunctionSymbol)}
    return expr
