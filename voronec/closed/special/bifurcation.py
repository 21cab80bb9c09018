"""The bifurcation set: levels of the constants on which the quartic has a multiple root.

In the plane of two constants, the third being given, it is where the discriminant vanishes; the
precessions parametrise it, and the motions at the poles add single points.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.precision import PROOF
from voronec.algebra.text import as_expression
from voronec.closed.arithmetic import ball, compile_expressions, exact, precise
from voronec.closed.special.plane import Strip, sign_on, strips
from voronec.closed.special.precessions import Precessions, known_parameters, precessions
from voronec.closed.special.stability import decide_stability
from voronec.declaration.reading import expression, fixed_mapping, quote
from voronec.declaration.system import System
from voronec.errors import DefinitionError

STEPS = (1 - np.cos(np.linspace(0, np.pi, 63))) / 2
"""Shares of an interval, dense towards its ends and with them."""


@dataclass(frozen=True)
class LevelCurve:
    """A piece of the bifurcation set: ``points`` (m, 2) in the plane, with ``x`` and ``rate`` (m,)
    of the precessions on it, all of them stable or none."""

    points: np.ndarray
    x: np.ndarray
    rate: np.ndarray
    stable: bool


@dataclass(frozen=True)
class LevelPoint:
    """A single point: a motion at a pole, or a precession that the family leaves out."""

    point: tuple[float, float]
    x: float
    stable: bool
    what: str


@dataclass(frozen=True)
class BifurcationSet:
    """Where the number of motions changes in the plane of two constants.

    plane
        the two constants; ``fixed`` are the values of the others.
    discriminant
        polynomial in the two constants, zero where the quartic has a multiple root anywhere.
    curves, points
        multiple roots with -1 < x < 1, and at the poles.
    """

    system: str
    parameters: Mapping[str, sp.Expr]
    plane: tuple[sp.Symbol, sp.Symbol]
    fixed: Mapping[sp.Symbol, sp.Expr]
    quartic: sp.Expr
    variable: sp.Symbol
    discriminant: sp.Expr
    curves: tuple[LevelCurve, ...]
    points: tuple[LevelPoint, ...]

    def motions(self, first: Any, second: Any) -> int:
        """How many motions there are on a level: intervals of [-1, 1] in which f >= 0.

        A single point counts as one, but not a simple root at a pole with f < 0 beside it: there
        the squares of the velocities would be negative.  Decided exactly.
        """
        at = dict(zip(self.plane, (exact(first), exact(second)), strict=True))
        f = sp.Poly(self.quartic.xreplace(at), self.variable)
        if f.is_zero:
            return 1
        roots = [r for r, _ in f.sqf_part().intervals(inf=-1, sup=1, eps=Fraction(1, 10**9))]
        edges = [sp.Integer(-1), *[e for r in roots for e in r], sp.Integer(1)]
        gaps = list(zip(edges[::2], edges[1::2], strict=True))
        positive = [bool(a < b and f.eval((a + b) / 2) > 0) for a, b in gaps]
        slope = f.diff()
        empty = sum(bool(f.eval(x) == 0 and x * slope.eval(x) > 0) for x in (-1, 1))
        # a root begins a motion where f is not positive before it
        return sum(1 for i in range(len(roots)) if not positive[i]) + int(positive[0]) - empty


def bifurcation_set(
    system: System,
    plane: tuple[Any, Any],
    fixed: Mapping[Any, Any],
    parameters: Mapping[Any, Any] | None = None,
    window: tuple[float, float] | None = None,
) -> BifurcationSet:
    """The bifurcation set in the plane of two constants of the motion.

    ``plane`` names two of the constants that the quartic holds; ``fixed`` gives the value of the
    third; ``window`` is the range of the rate w of the precessions that are drawn.
    """
    values = known_parameters(system, parameters or {})
    family = precessions(system, values)
    axes, (other, value) = _read(family, plane, fixed)
    x, w = family.place, family.rate
    f = family.quadratures.quartic.xreplace({**values, other: value})
    above, below = sp.fraction(sp.together(family.constants[other] - value))
    second = sp.fraction(sp.together(family.derivative(2)))[0]
    cuts = [below]
    cells = strips([above], x, w, window, cuts=[*cuts, *_meetings(above, second, x)])
    curves = [c for strip in cells for c in _graphs(family, strip, axes)]
    curves += _vertical(family, above, axes, window)
    names = {p.symbol: p.name for p in system.parameters}
    return BifurcationSet(
        system=system.name,
        parameters={names[s]: v for s, v in values.items()},
        plane=axes,
        fixed={other: value},
        quartic=sp.expand(f),
        variable=x,
        discriminant=_discriminant(f, x),
        curves=tuple(curves),
        points=tuple(_points(family, axes, other, value)),
    )


def _read(
    family: Precessions, plane: tuple[Any, Any], fixed: Mapping[Any, Any]
) -> tuple[tuple[sp.Symbol, sp.Symbol], tuple[sp.Symbol, sp.Expr]]:
    """The constants by name: two of the plane, and the third with its value."""
    constants = {str(c): c for c in family.constants}
    given = fixed_mapping(fixed, "fixed", "constant: value")
    asked = [*map(str, plane), *map(str, given)]
    if len(plane) != 2 or sorted(asked) != sorted(constants):
        raise DefinitionError(
            f"plane {quote(tuple(map(str, plane)))} and fixed {quote([*map(str, given)])} must "
            f"name each of the constants {', '.join(constants)} once: two in plane, one in fixed"
        )
    ((name, value),) = given.items()
    number = exact(expression(value, f"the constant '{name}'"))
    return (constants[asked[0]], constants[asked[1]]), (constants[str(name)], number)


def _discriminant(f: sp.Expr, x: sp.Symbol) -> sp.Expr:
    above = sp.fraction(sp.together(f))[0]
    discriminant = sp.discriminant(sp.Poly(above, x))
    return sp.prod(factor for factor, _ in sp.factor_list(discriminant)[1])


def _meetings(curve: sp.Expr, second: sp.Expr, x: sp.Symbol) -> list[sp.Expr]:
    """Where stability may change along the curve."""
    resultants = []
    for factor, _ in sp.factor_list(curve)[1]:
        if factor.has(x):
            resultants.append(sp.resultant(factor, second, x))
    return [e for e in resultants if e != 0]


def _graphs(
    family: Precessions, strip: Strip, axes: tuple[sp.Symbol, sp.Symbol]
) -> list[LevelCurve]:
    """The pieces over an interval of w, up to where they end."""
    rows = strip.abscissae()
    limits = [_limits(family, strip, axes, end) for end in strip.ends]
    pieces = []
    drawn = zip(strip.graphs(), strip.signs(family.derivative(2)), *limits, strict=True)
    for graph, sign, first, last in drawn:
        points = _map_points(family, axes, graph[1:-1], rows[1:-1])
        closed = [p for p in (first, points, last) if p is not None]
        kept = slice(int(first is None), len(rows) - int(last is None))
        pieces.append(LevelCurve(np.vstack(closed), graph[kept], rows[kept], sign < 0))
    return pieces


def _limits(
    family: Precessions, strip: Strip, axes: tuple[sp.Symbol, sp.Symbol], end: Fraction
) -> list[np.ndarray | None]:
    """Where in the plane the curves of a strip end; None for those that run away.

    Taken hard beside the critical value, in balls: what is 0/0 there has its limit.
    """
    exprs = tuple(family.constants[c] for c in axes)
    function = compile_expressions(exprs, (family.place, family.rate))

    def points(w: Fraction) -> np.ndarray:
        with precise(PROOF):
            places = [ball(low).union(ball(high)) for low, high in strip.places_at(w)]
            columns = [function([place, ball(w)]) for place in places]
            return np.array([[float(v) for v in column] for column in columns])

    at, near = points(end), points(end + (strip.inside - end) / 2**60)
    settled = np.abs(at - near) < 1e-6 * (1 + np.abs(near))
    return [p if fixed.all() else None for p, fixed in zip(at, settled, strict=True)]


def _vertical(
    family: Precessions,
    curve: sp.Expr,
    axes: tuple[sp.Symbol, sp.Symbol],
    window: tuple[float, float] | None,
) -> list[LevelCurve]:
    """Pieces on which w is constant: factors of the curve that hold no x."""
    x, w = family.place, family.rate
    second = family.derivative(2)
    above = sp.fraction(sp.together(second))[0]
    pieces = []
    for flat in (f for f, _ in sp.factor_list(curve)[1] if not f.has(x) and f.has(w)):
        edges = [Fraction(-1), *_crossings(sp.resultant(flat, above, w), x), Fraction(1)]
        for isolated, _ in sp.Poly(flat, w).intervals(eps=Fraction(1, 10**60)):
            rate = float(sum(isolated) / 2)
            if window and not window[0] <= rate <= window[1]:
                continue
            pair = (_plain(isolated[0]), _plain(isolated[1]))
            for a, b in pairwise(edges):
                middle = (a + b) / 2
                sign = sign_on(second, {x: (middle, middle), w: pair})
                graph = float(a) + float(b - a) * STEPS
                points = _map_points(family, axes, graph, np.full_like(graph, rate))
                pieces.append(LevelCurve(points, graph, np.full_like(graph, rate), sign < 0))
    return pieces


def _crossings(poly: sp.Expr, x: sp.Symbol) -> list[Fraction]:
    """Where a polynomial in x vanishes in (-1, 1), rounded."""
    if not poly.has(x):
        return []
    intervals = sp.Poly(poly, x).sqf_part().intervals(inf=-1, sup=1, eps=Fraction(1, 10**20))
    middles = [_plain((a + b) / 2) for (a, b), _ in intervals]
    return [m for m in middles if abs(m) < 1]


def _plain(value: Any) -> Fraction:
    number = sp.Rational(value)
    return Fraction(int(number.p), int(number.q))


def _map_points(
    family: Precessions, axes: tuple[sp.Symbol, sp.Symbol], x: np.ndarray, w: np.ndarray
) -> np.ndarray:
    variables = (family.place, family.rate)
    columns = [sp.lambdify(variables, family.constants[c], "numpy")(x, w) for c in axes]
    return np.column_stack([np.broadcast_to(c, x.shape) for c in columns])


def _points(
    family: Precessions,
    axes: tuple[sp.Symbol, sp.Symbol],
    other: sp.Symbol,
    value: sp.Expr,
) -> list[LevelPoint]:
    """Motions at the poles and precessions that the family leaves out, on this level."""
    motions = [(e.place, e.free, e.constants, "at a pole") for e in family.ends]
    motions += [(b.place, b.free, b.constants, "beside the family") for b in family.branches]
    points = []
    for place, free, constants, what in motions:
        level = sp.expand(constants[other] - value)
        roots = sp.roots(level, free) if level.has(free) else {}
        for root in roots:
            if not root.is_real:
                continue
            known = {c: as_expression(e).xreplace({free: root}) for c, e in constants.items()}
            stable = decide_stability(family.quadratures, known, dict(family.values), place).stable
            point = tuple(float(known[c]) for c in axes)
            points.append(LevelPoint((point[0], point[1]), float(place), stable, what))
    return points
