"""Pseudo-regular precessions: a parameter is large against the state at the beginning.

With a fast gyroscope, k = 1/e, the variable moves by y = e eta only, and the quartic becomes

    f(x0 + e eta) = G0(eta) + e G1(eta) + ...,   G0 quadratic:

a nutation, harmonic in the limit.  Periods and means are integrals around the interval of eta, and
their terms in e are exact [DragovicGajicJovanovic2020, sec. "Special Solutions"].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.factors import in_factors
from voronec.algebra.normal import shorten
from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import exact
from voronec.closed.problem import known_parameters, quadratures_of, read_parameters
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.reading import expression, fixed_mapping, quote
from voronec.declaration.system import System
from voronec.errors import DefinitionError, EngineLimit

Series = Sequence[sp.Expr]


def product(a: Series, b: Series, terms: int) -> list[sp.Expr]:
    """The first terms of a product."""
    return [
        sp.Add(*(a[i] * b[n - i] for i in range(n + 1) if i < len(a) and n - i < len(b)))
        for n in range(terms)
    ]


def inverse(a: Series) -> list[sp.Expr]:
    """1/a, with as many terms; the first coefficient is not zero."""
    return quotient([sp.S.One], a, len(a))


def quotient(a: Series, b: Series, terms: int) -> list[sp.Expr]:
    """a/b; the first coefficient of b is not zero."""
    series: list[sp.Expr] = []
    for n in range(terms):
        known = sp.Add(*(b[i] * series[n - i] for i in range(1, n + 1) if i < len(b)))
        series.append(((a[n] if n < len(a) else 0) - known) / b[0])
    return series


def _square_root(a: Series, terms: int) -> list[sp.Expr]:
    """The root with a positive first coefficient."""
    series = [sp.sqrt(a[0])]
    for n in range(1, terms):
        known = sp.Add(*(series[i] * series[n - i] for i in range(1, n)))
        series.append(in_factors(((a[n] if n < len(a) else 0) - known) / (2 * series[0])))
    return series


def around(
    rate: Series, beside: Series, a: sp.Expr, D: sp.Expr, y: sp.Symbol, terms: int
) -> list[sp.Expr]:
    """The integral of rate * (D - a y^2 + e beside[0] + e^2 beside[1] + ...)^(-1/2) over y, around
    the interval between the roots, divided by 2 pi, as a series in e.

    All of it is a sum of integrals of y^(2m) (D - a y^2)^(-1/2 - j), taken around a path that does
    not meet the roots; those with j > 0 are derivatives by D of those with j = 0.
    """
    width, series = sp.Dummy("D"), []
    powers = [[sp.S.One, *[sp.S.Zero] * terms]]
    shifted = [sp.S.Zero, *beside]
    for _ in range(terms):
        powers.append(product(powers[-1], shifted, terms))
    parts = [product(rate, power, terms) for power in powers[: terms + 1]]
    for n in range(terms):
        total = sp.S.Zero
        for j, part in enumerate(parts):
            poly = sp.Poly(sp.expand(part[n]), y) if part[n] != 0 else None
            for (power,), c in poly.terms() if poly is not None else ():
                total += sp.binomial(sp.Rational(-1, 2), j) * c * _moment(power, j, a, width)
        series.append(total.xreplace({width: D}))
    return series


def _moment(power: int, j: int, a: sp.Expr, D: sp.Symbol) -> sp.Expr:
    """The integral of y^power (D - a y^2)^(-1/2 - j) around the interval, over 2 pi."""
    m, odd = divmod(power, 2)
    if odd or j > m:
        return sp.S.Zero
    value = sp.Rational(sp.binomial(2 * m, m), 4**m) * D**m / a**m / sp.sqrt(a)
    for i in range(j):
        value = -sp.diff(value, D) / (i + sp.Rational(1, 2))
    return value


def half_width(
    beside: Series, a: sp.Expr, D: sp.Expr, y: sp.Symbol, terms: int
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """Half width and centre of the interval between the roots y of the same function."""
    rho, e, slope = sp.Dummy("rho", positive=True), sp.Dummy("e"), sp.Dummy("a")
    root = [rho]
    for n in range(1, terms):
        at = sp.Add(*(c * e**i for i, c in enumerate(root)))
        whole = -slope * (at**2 - rho**2)
        whole += sp.Add(*(e ** (i + 1) * g.subs(y, at) for i, g in enumerate(beside[:n])))
        root.append(sp.expand(sp.expand(whole).coeff(e, n) / (2 * slope * rho)))
    width = sp.sqrt(in_factors(D / a))
    halves, middles = [], []
    for c in root:
        # odd powers of rho belong to the half width; there are none below -2 * terms
        (short,) = shorten([(c * rho ** (2 * terms)).xreplace({slope: a})])
        above, below = sp.fraction(sp.together(short))
        poly = sp.Poly(sp.expand(above), rho)
        parts = {n - 2 * terms: p / below for (n,), p in poly.terms()}
        odd = sp.Add(*(p * (D / a) ** ((n - 1) // 2) for n, p in parts.items() if n % 2))
        even = sp.Add(*(p * (D / a) ** (n // 2) for n, p in parts.items() if n % 2 == 0))
        halves.append(shorten([odd])[0] * width)
        middles.append(shorten([even])[0])
    return halves, middles


@dataclass(frozen=True)
class PseudoRegular:
    """Expansions in 1/k of the nutation that begins at given x and velocities, k > 0.

    large
        the parameter k.
    place
        x at the beginning; velocities are written with their own symbols.
    frequency
        coefficients c of  k (c[0] + c[1]/k + ...).
    half_width, centre
        of the interval of x: (c[0] + c[1]/k + ...)/k, and the same to be added to the place.
    drifts
        angle -> coefficients of its mean rate  c[0] + c[1]/k + ...
    """

    system: System
    large: sp.Symbol
    place: sp.Symbol
    frequency: tuple[sp.Expr, ...]
    half_width: tuple[sp.Expr, ...]
    centre: tuple[sp.Expr, ...]
    drifts: Mapping[Any, tuple[sp.Expr, ...]]

    def at(
        self,
        start: Mapping[Any, Any],
        parameters: Mapping[Any, Any] | None = None,
        terms: int | None = None,
    ) -> dict[str, float]:
        """Numbers for a start, x and velocities: ``frequency``, ``half width``, ``centre``, and
        the drift of each angle by its name; ``terms`` of each series, by default all."""
        values = known_parameters(self.system, parameters or {})
        symbols = [self.place, *self.system.velocities]
        given = _start_values(self.system, start)
        if missing := [str(s) for s in symbols if s not in given]:
            raise DefinitionError(
                f"the start has no '{missing[0]}'; give values for {', '.join(map(str, symbols))}"
            )
        values |= given
        k = values[self.large]
        if not k > 0:
            raise DefinitionError(
                f"'{self.large}' = {k}: expansions hold for positive values; turn the axis round"
            )

        def sum_series(series: tuple[sp.Expr, ...]) -> float:
            kept = series[:terms]
            return float(sum(c.xreplace(values) / k**i for i, c in enumerate(kept)))

        return {
            "frequency": float(k) * sum_series(self.frequency),
            "half width": sum_series(self.half_width) / float(k),
            "centre": float(given[self.place]) + sum_series(self.centre) / float(k),
            **{plain_name(q): sum_series(series) for q, series in self.drifts.items()},
        }


def pseudo_regular(
    system: System,
    large: Any,
    terms: int = 1,
    parameters: Mapping[Any, Any] | None = None,
    start: Mapping[Any, Any] | None = None,
) -> PseudoRegular:
    """The expansions for a large parameter, with so many terms each.

    ``parameters`` and ``start`` (x and velocities at the beginning) are values to put in: all of
    the other parameters; what is left of the start stays symbols, and costs time.  ``EngineLimit``
    where parameters are symbols, and where the limit is no harmonic nutation.
    """
    symbols = {p.name: p.symbol for p in system.parameters}
    if plain_name(large) not in symbols:
        raise DefinitionError(f"system '{system.name}' has no parameter '{quote(large)}'")
    quadratures = quadratures_of(system)
    wanted = {plain_name(t.longitude) for t in quadratures.traces}
    kept = [q for q in quadratures.integrals if plain_name(q) in wanted]
    given = read_parameters(system, parameters or {}) | _start_values(system, start or {})
    limit = _Limit(quadratures, symbols[plain_name(large)], terms, MappingProxyType(given))
    return PseudoRegular(
        system=system,
        large=limit.large,
        place=quadratures.x,
        frequency=limit.spell(limit.paces),
        half_width=limit.spell(limit.widths[0]),
        centre=limit.spell(limit.widths[1]),
        drifts=MappingProxyType({q: limit.spell(limit.drift(q)) for q in kept}),
    )


@dataclass(frozen=True)
class _Limit:
    """One expansion: e = 1/k; eta = middle + y, where the nutation of the limit is centred."""

    quadratures: Quadratures
    large: sp.Symbol
    terms: int
    values: Mapping[Any, sp.Expr]

    @property
    def sine(self) -> sp.Expr:
        """That of the colatitude at the beginning; a symbol where x is one."""
        x = self.values.get(self.quadratures.x)
        return _SINE if x is None else sp.sqrt(1 - x**2)

    def spell(self, series: Sequence[sp.Expr]) -> tuple[sp.Expr, ...]:
        """Coefficients in x and the velocities at the beginning."""
        x = self.quadratures.x
        return tuple(shorten([e.xreplace({_SINE: sp.sqrt(1 - x**2)}) for e in series]))

    @property
    def start(self) -> sp.Expr:
        """x at the beginning."""
        x = self.quadratures.x
        return self.values.get(x, x)

    @cached_property
    def level(self) -> dict[sp.Symbol, sp.Expr]:
        """The constants by the state at the beginning, in e."""
        quadratures = self.quadratures
        (angle,) = quadratures.meaning.free_symbols
        x = quadratures.x
        known = {sp.cos(angle): x, sp.sin(angle): self.sine}
        constants = {c: expr.subs(known) for c, expr in quadratures.constants.items()}
        return {c: self._in_e(expr) for c, expr in constants.items()}

    def _in_e(self, value: sp.Expr) -> sp.Expr:
        return value.xreplace(dict(self.values)).subs(self.large, 1 / _E)

    @cached_property
    def whole(self) -> list[sp.Poly]:
        """G0, G1, ... as polynomials in eta."""
        quadratures = self.quadratures
        x, place = quadratures.x, sp.Dummy("place")
        f = self._in_e(quadratures.quartic.subs(x, place)).xreplace(
            {c: e for c, e in self.level.items() if quadratures.quartic.has(c)}
        )
        inside = sp.expand(f.subs(place, self.start + _E * _ETA))
        if not inside.is_polynomial(_E):
            raise EngineLimit(
                f"'{self.large}' = 1/e makes the quartic no polynomial in e; "
                "give the other parameters numbers, if they have none"
            )
        terms = sp.Poly(inside, _E)
        return [sp.Poly(terms.nth(i), _ETA) for i in range(terms.degree() + 1)]

    @cached_property
    def harmonic(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """(a, D, middle) of G0 = D - a (eta - middle)^2."""
        first = self.whole[0]
        if first.degree() != 2:
            raise EngineLimit(f"for a large '{self.large}' the nutation is not harmonic")
        a, b, c = -first.nth(2), first.nth(1) / 2, first.nth(0)
        a, c = in_factors(a), in_factors(c)
        middle = in_factors(b / a)
        return a, in_factors(c + b * middle), middle

    @cached_property
    def perturbations(self) -> list[sp.Expr]:
        """G1, G2, ... in y."""
        middle = self.harmonic[2]
        return [sp.expand(g.as_expr().subs(_ETA, middle + _Y)) for g in self.whole[1:]]

    @cached_property
    def cycle(self) -> list[sp.Expr]:
        """The integral of G^(-1/2) around the interval over 2 pi: 1/frequency, in e / k."""
        a, D, _ = self.harmonic
        return around([sp.S.One], self.perturbations, a, D, _Y, self.terms)

    @cached_property
    def paces(self) -> list[sp.Expr]:
        """The frequency, in k."""
        return shorten(inverse(self.cycle))

    @cached_property
    def widths(self) -> tuple[list[sp.Expr], list[sp.Expr]]:
        """Half width and centre of the interval of eta."""
        a, D, middle = self.harmonic
        half, centre = half_width(self.perturbations, a, D, _Y, self.terms)
        return half, [centre[0] + middle, *centre[1:]]

    def drift(self, angle: Any) -> list[sp.Expr]:
        """The mean rate of an angle."""
        a, D, _ = self.harmonic
        rate = self._rate(self.quadratures.integrals[angle])
        over = shorten(around(rate, self.perturbations, a, D, _Y, self.terms))
        return product(over, self.paces, self.terms)

    def _rate(self, rate: sp.Expr) -> list[sp.Expr]:
        """A rate as a series in e, with coefficients that are polynomials in y."""
        quadratures, (_, _, middle) = self.quadratures, self.harmonic
        place = sp.Dummy("place")
        value = self._in_e(rate.subs(quadratures.x, place))
        roots = {}
        for c, level in self.level.items():
            if value.has(c):
                roots[c] = self._root(level)
        value = value.xreplace(roots).subs(place, self.start + _E * (middle + _Y))
        above, below = (_series(sp.expand(part)) for part in sp.fraction(sp.together(value)))
        while below[0] == 0 and above[0] == 0:
            above, below = above[1:], below[1:]
        if below[0] == 0:
            raise EngineLimit(f"for a large '{self.large}' a rate has no finite limit")
        return shorten(quotient(above, below, self.terms))

    def _root(self, level: sp.Expr) -> sp.Expr:
        """A constant as a polynomial in e over a power of e; a root by its series."""
        if not (level.is_Pow and level.exp == sp.S.Half):
            return level
        inside = sp.together(sp.expand(level.base))
        above, below = sp.fraction(inside)
        power = sp.degree(below, _E) if below.has(_E) else 0
        series = _series(sp.expand(sp.cancel(above * _E**power / below)))
        root = _square_root(series, self.terms + 2)
        return sp.Add(*(c * _E**i for i, c in enumerate(root))) / _E ** sp.Rational(power, 2)


_E, _ETA, _Y = sp.Symbol("e_", positive=True), sp.Symbol("eta_"), sp.Symbol("y_")
_SINE = sp.Symbol("sine_", positive=True)


def _start_values(system: System, start: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
    """x and velocities at the beginning, by their symbols."""
    symbols = {plain_name(s): s for s in (quadratures_of(system).x, *system.velocities)}
    values = {}
    for key, value in fixed_mapping(start, "start", "x or velocity: value").items():
        if plain_name(key) not in symbols:
            raise DefinitionError(
                f"a start has no '{quote(key)}'; it has values for {', '.join(symbols)}"
            )
        values[symbols[plain_name(key)]] = exact(expression(value, f"the start '{quote(key)}'"))
    return values


def _series(value: sp.Expr) -> list[sp.Expr]:
    """Coefficients of a polynomial in e."""
    poly = sp.Poly(value, _E)
    return [in_factors(poly.nth(i)) for i in range(poly.degree() + 1)]
