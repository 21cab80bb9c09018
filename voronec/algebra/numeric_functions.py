"""Functions that programs alone know, with values where their formulas overflow, cancel or fail.

    sinc w = sin(w)/w,    (sin w - w cos w)/w^3 in its slope               (entire)
    expm1 w = exp(w) - 1,    log1p x = log(1 + x)            (all digits where they are small)
    hypot(a, b, ...) = sqrt(a^2 + b^2 + ...)                 (squares overflow before it does)
    size w = |w|      in expressions that are equal for both signs of w, so that it is no cut
    choice(w, p, n) = p (1 + sign w)/2 + n (1 - sign w)/2      (of which one alone is looked at)
    case(w, p, z, n) = p, z or n, for w > 0, w = 0 and w < 0

They are unknown functions of these names; proofs see their formulas.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from typing import Any, NamedTuple

import symengine as se

from voronec.algebra.terms import subexpressions

SINC, SINC_SLOPE = "cardinal sine", "slope of the cardinal sine"
EXPM1, LOG1P = "exponential less one", "logarithm beside one"
HYPOT, SIZE = "length of sides", "size on equal sides"
CHOICE, CASE = "choice between sides", "case of three"


class CardinalQuotient(NamedTuple):
    """f(w)/w^power, f given by ``above``, and its power series: ``coefficient`` takes n to p and q
    of p/q w^n, zero for odd n.  It is used where |w| is below ``REACH``."""

    above: Callable[[Any], Any]
    power: int
    coefficient: Callable[[int], tuple[int, int]]


REACH = 1.0
"""Where |w| is smaller the power series has all digits in a few terms."""


def _turning_sign(n: int) -> int:
    """1, 0, -1, 0, and so on."""
    return (1, 0, -1, 0)[n % 4]


QUOTIENTS: dict[str, CardinalQuotient] = {
    SINC: CardinalQuotient(se.sin, 1, lambda n: (_turning_sign(n), factorial(n + 1))),
    SINC_SLOPE: CardinalQuotient(
        lambda w: se.sin(w) - w * se.cos(w), 3,
        lambda n: ((n + 2) * _turning_sign(n), factorial(n + 3)),
    ),
}  # fmt: skip
"""Functions with a value at zero that a division does not give, by name."""


def _with_quotient(quotient: CardinalQuotient) -> Callable[[Any], Any]:
    return lambda w: quotient.above(w) / w**quotient.power


FORMULAS: dict[str, Callable[..., Any]] = {
    **{name: _with_quotient(quotient) for name, quotient in QUOTIENTS.items()},
    EXPM1: lambda w: se.exp(w) - 1,
    LOG1P: lambda x: se.log(1 + x),
    HYPOT: lambda *sides: se.sqrt(se.Add(*[a**2 for a in sides])),
    SIZE: se.Abs,
    CHOICE: lambda w, p, n: (p * (1 + se.sign(w)) + n * (1 - se.sign(w))) / 2,
    CASE: lambda w, p, z, n: z + se.sign(w) * (p - n) / 2 + se.sign(w) ** 2 * ((p + n) / 2 - z),
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
    while formulas := {f: e for f in subexpressions([expr]) if (e := formula(f)) is not None}:
        expr = expr.xreplace(formulas)
    return expr
