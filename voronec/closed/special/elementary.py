"""Where the quartic is quadratic: the ordinary ball, whose gyroscope is at rest.

    x(t) = centre + half_width cos(frequency (t - t0)),

and every integral is a linear function of the time plus arc tangents: at a pole c of weight w,
f(c) = -4 w^2 makes the integral of w/(x - c) one arc tangent of a multiple of tan(phase/2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.normal import shorten
from voronec.algebra.text import as_expression
from voronec.closed.problem import quadratures_of, read_parameters
from voronec.declaration.system import System
from voronec.errors import EngineLimit


@dataclass(frozen=True)
class Elementary:
    """A motion by sines, in the constants of the motion and the parameters.

    frequency, centre, half_width
        of x; the half width is not negative.
    rates
        angle -> the part of its rate that does not change.
    shares
        angle -> {pole: share}: the integral is  rate t + sum of share * ``periodic_term``.
    weights
        pole -> its weight.
    """

    frequency: sp.Expr
    centre: sp.Expr
    half_width: sp.Expr
    rates: Mapping[Any, sp.Expr]
    shares: Mapping[Any, Mapping[sp.Expr, int]]
    weights: Mapping[sp.Expr, sp.Expr]

    def periodic_term(self, pole: Any, phase: Any) -> sp.Expr:
        """The integral of w/(x - pole) dt from the phase 0, where x is largest, for |phase| < pi.

        Both cosines of the pole are of one sign, so that the root is real.
        """
        c, w = as_expression(pole), self.weights[as_expression(pole)]
        low, high = self.centre - self.half_width - c, self.centre + self.half_width - c
        side = sp.sign(w) * sp.sign(high)
        return side * sp.atan(sp.sqrt(low / high) * sp.tan(as_expression(phase) / 2))


def elementary(system: System, parameters: Mapping[Any, Any]) -> Elementary:
    """The motion where the values of ``parameters`` make the quartic a quadratic: k = 0.

    ``EngineLimit`` where they do not, or a pole goes to infinity together with its residue.
    """
    quadratures = quadratures_of(system)
    values = read_parameters(system, parameters)
    x = quadratures.x
    f = sp.Poly(sp.expand(quadratures.quartic.xreplace(values)), x)
    if f.degree() != 2:
        raise EngineLimit(f"the quartic has degree {f.degree()}, not 2; put in k = 0, say")
    a, b, c = -f.nth(2), f.nth(1) / 2, f.nth(0)
    a, centre, square = shorten([a, b / a, (b**2 / a + c) / a])
    weights = _finite(quadratures.poles, values)
    rates, shares = {}, {}
    for angle, rate in quadratures.integrals.items():
        rest = sp.together(rate.xreplace(values))
        shares[angle] = {p: _share(rest, x, p, w) for p, w in weights.items()}
        linear = rest - sp.Add(*(n * weights[p] / (x - p) for p, n in shares[angle].items()))
        (constant,) = shorten([linear])
        if constant.has(x):
            raise EngineLimit(f"the rate of '{angle}' has a pole that is not declared")
        rates[angle] = constant
    return Elementary(
        sp.sqrt(a), centre, sp.sqrt(square), MappingProxyType(rates), MappingProxyType(shares),
        MappingProxyType(weights),
    )  # fmt: skip


def _finite(
    poles: Mapping[sp.Expr, sp.Expr], values: Mapping[Any, sp.Expr]
) -> dict[sp.Expr, sp.Expr]:
    """The poles that these values leave in the finite, with their weights."""
    finite = {}
    for place, weight in poles.items():
        below = sp.denom(sp.together(place)).xreplace(dict(values))
        if below != 0:
            finite[place.xreplace(dict(values))] = shorten([weight.xreplace(dict(values))])[0]
    return finite


def _share(rate: sp.Expr, x: sp.Symbol, pole: sp.Expr, weight: sp.Expr) -> int:
    """The residue at a pole in units of the weight."""
    (residue,) = shorten([sp.cancel(rate * (x - pole)).subs(x, pole) / weight])
    return int(residue)
