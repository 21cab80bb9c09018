"""Where regular precessions are stable: the plane of the two parameters of the family.

The boundary is f''(x) = 0, a polynomial in x and w for given parameters of the system.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.factors import in_factors
from voronec.algebra.text import as_expression
from voronec.closed.special.plane import Strip, strips
from voronec.closed.special.precessions import known_parameters, precessions
from voronec.closed.special.stability import sign_of
from voronec.declaration.reading import quote
from voronec.declaration.system import System
from voronec.errors import DefinitionError


@dataclass(frozen=True)
class Region:
    """A cell of the plane in which f'' has one sign, proved at one exact point of it.

    ``outline`` (m, 2) is its closed boundary for drawing, in units of the axes; ``sample`` an exact
    point (x, w / unit) inside.
    """

    stable: bool
    sample: tuple[Fraction, Fraction]
    outline: np.ndarray


@dataclass(frozen=True)
class StabilityChart:
    """Stability of the regular precessions in the plane of x and of w in some unit.

    axes
        what runs along the two axes, in words.
    boundary
        the polynomial in (x, w) that vanishes where f'' = 0.
    excluded
        a polynomial in w that vanishes where the family has no member (but see its branches).
    curves
        f'' = 0 as arrays (m, 2).
    regions
        cells, together the whole window.
    window
        the range of w in units.
    """

    system: str
    parameters: Mapping[str, sp.Expr]
    axes: tuple[str, str]
    unit: sp.Expr
    boundary: sp.Expr
    excluded: sp.Expr
    curves: tuple[np.ndarray, ...]
    regions: tuple[Region, ...]
    window: tuple[float, float]


def chart_of(
    system: System,
    parameters: Mapping[Any, Any] | None = None,
    unit: Any = 1,
    window: tuple[float, float] | None = None,
) -> StabilityChart:
    """The chart for given parameters, by default those of the system; ``unit`` is that of w.

    ``unit`` may hold parameters, as k/A does; ``window`` is a range of w in this unit, by default
    one in which every change is seen.
    """
    values = known_parameters(system, parameters or {})
    family = precessions(system, values)
    scale = as_expression(unit).xreplace(values)
    if not (scale.is_number and sign_of(scale) > 0):
        raise DefinitionError(f"unit = {quote(unit)} is not a positive number; write one like k/A")
    x, w = family.place, family.rate
    second = sp.cancel(family.derivative(2).xreplace({w: w * scale}))
    above, below = sp.fraction(in_factors(second))
    names = {p.symbol: p.name for p in system.parameters}
    cells = strips([above], x, w, window, cuts=[below])
    if not cells:
        raise DefinitionError(f"window = {quote(window)} is empty; write (low, high)")
    regions = [r for strip in cells for r in _regions(strip, second, x, w)]
    return StabilityChart(
        system=system.name,
        parameters={names[s]: v for s, v in values.items()},
        axes=(str(x), f"{w}" if scale == 1 else f"{w} / ({unit})"),
        unit=scale,
        boundary=sp.expand(above),
        excluded=sp.expand(below),
        curves=_curves(cells),
        regions=tuple(regions),
        window=(float(cells[0].ends[0]), float(cells[-1].ends[1])),
    )


def _regions(strip: Strip, second: sp.Expr, x: sp.Symbol, w: sp.Symbol) -> list[Region]:
    """The cells over an interval of w, with the sign of f'' in each."""
    here = sp.Rational(strip.inside.numerator, strip.inside.denominator)
    rows = strip.abscissae()
    ones = np.ones_like(rows)
    edges = [-ones, *strip.graphs(), ones]
    regions = []
    for place, left, right in zip(strip.places(), edges, edges[1:], strict=False):
        at = sp.Rational(place.numerator, place.denominator)
        sign = sign_of(second.xreplace({x: at, w: here}))
        outline = _outline(rows, left, right)
        regions.append(Region(sign < 0, (place, strip.inside), outline))
    return regions


def _outline(rows: np.ndarray, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Up along one curve and down along the other."""
    up = np.column_stack([left, rows])
    down = np.column_stack([right, rows])[::-1]
    return np.vstack([up, down, up[:1]])


def _curves(cells: list[Strip]) -> tuple[np.ndarray, ...]:
    return tuple(
        np.column_stack([graph, strip.abscissae()]) for strip in cells for graph in strip.graphs()
    )
