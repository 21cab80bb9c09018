r"""Weierstrass' functions of two arguments and of their sum and difference.

What ``\wp``, ``\zeta`` and ``\sigma`` are at u + v is derived, not quoted.  Each is a polynomial in
wp(v) and wp'(v) over a power of wp(v) - wp(u), because of its poles as a function of v; the
coefficients follow from the expansions at v = 0.  Then it is proved: the candidate satisfies the
same differential equations in u and in v as the function itself, identically modulo
wp'^2 = 4 wp^3 - g2 wp - g3, and both start with the same term at v = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Study

G2, G3 = sp.symbols("g_2 g_3")
STEP = sp.Symbol("z")
"""The small argument of an expansion."""

Rates = Mapping[sp.Symbol, sp.Expr]
Place = tuple[int, int]
"""m u + n v, with m and n from -1, 0, 1, as (m, n)."""


def rate(expr: Any, rates: Rates) -> sp.Expr:
    """The derivative of an expression whose symbols have the given derivatives."""
    return sp.Add(*[sp.diff(expr, symbol) * slope for symbol, slope in rates.items()])


@dataclass(frozen=True)
class Point:
    """The values of the functions at one argument, as symbols; only p and slope are related."""

    p: sp.Symbol
    slope: sp.Symbol
    zeta: sp.Symbol
    sigma: sp.Symbol

    @classmethod
    def at(cls, argument: str) -> Point:
        """Symbols named after an argument in LaTeX; the braces make them print as they are."""
        heads = (r"\wp", r"\wp'", r"\zeta", r"\sigma")
        return cls(*(sp.Symbol(f"{head}{{({argument})}}") for head in heads))

    @property
    def second(self) -> sp.Expr:
        """The second derivative of wp."""
        return 6 * self.p**2 - G2 / 2

    @property
    def rates(self) -> dict[sp.Symbol, sp.Expr]:
        """Derivatives by the argument."""
        zeta, sigma = -self.p, self.sigma * self.zeta
        return {self.p: self.slope, self.slope: self.second, self.zeta: zeta, self.sigma: sigma}

    @property
    def curve(self) -> sp.Expr:
        """What vanishes: wp'^2 - 4 wp^3 + g2 wp + g3."""
        return self.slope**2 - 4 * self.p**3 + G2 * self.p + G3

    def taylor(self, order: int) -> sp.Expr:
        """wp at the argument plus ``STEP``."""
        terms, value = [], sp.sympify(self.p)
        for k in range(order + 1):
            terms.append(value * STEP**k / sp.factorial(k))
            value = rate(value, self.rates)
        return sp.Add(*terms)


@cache
def at_zero() -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """wp, wp' and zeta at ``STEP``; what is left out of wp has the order 6 and higher."""
    c = sp.symbols("c1 c2")
    wp = STEP**-2 + c[0] * STEP**2 + c[1] * STEP**4
    wp = wp.xreplace(match_coefficients(sp.diff(wp, STEP) ** 2, 4 * wp**3 - G2 * wp - G3, c))
    return wp, sp.diff(wp, STEP), -sp.integrate(sp.expand(wp), STEP)


def match_coefficients(
    left: sp.Expr, right: sp.Expr, unknown: Sequence[sp.Symbol]
) -> dict[Any, sp.Expr]:
    """The unknown coefficients for which two expansions agree up to the term without ``STEP``."""
    gap = sp.expand(left - right)
    lowest = -int(sp.degree(sp.numer(sp.together(gap.xreplace({STEP: 1 / STEP}))), STEP))
    found = sp.solve([gap.coeff(STEP, k) for k in range(lowest, 1)], unknown, dict=True)
    if len(found) != 1:
        raise vo.DefinitionError(f"expansions in {STEP}: no unique {unknown} makes them agree")
    return dict(found[0])


@dataclass(frozen=True)
class AdditionLaw:
    """The functions at u + v in terms of those at u and at v.

    ``wp`` is wp(u+v); ``zeta`` is zeta(u+v) - zeta(u) - zeta(v); ``sigma`` is
    sigma(u+v) sigma(u-v) / (sigma(u)^2 sigma(v)^2).
    """

    u: Point
    v: Point
    wp: sp.Expr
    zeta: sp.Expr
    sigma: sp.Expr

    @classmethod
    def derive(cls, u: Point, v: Point) -> AdditionLaw:
        """Find the three by their expansions at v = 0."""
        a, b, c, d = unknown = sp.symbols("a b c d")
        wp, slope, zeta = at_zero()
        small, gap = {v.p: wp, v.slope: slope}, v.p - u.p
        shift = sp.integrate(u.taylor(4), STEP)  # zeta(u) - zeta(u+v)

        def find(top: sp.Expr, target: sp.Expr) -> sp.Expr:
            names = [x for x in unknown if top.has(x)]
            return top.xreplace(match_coefficients(top.xreplace(small), sp.expand(target), names))

        wide, narrow = (gap**k for k in (2, 1))
        double = find(a + b * v.p + c * v.p**2 + d * v.slope, wide.xreplace(small) * u.taylor(4))
        simple = find(a + b * v.p + c * v.slope, narrow.xreplace(small) * (-shift - zeta))
        # sigma(v)^2 = v^2 + O(v^6), and the other factor is 1 - wp(u) v^2 + O(v^4)
        product = find(a + b * v.p, STEP**-2 * (1 - u.p * STEP**2))
        return cls(u, v, double / wide, simple / narrow, product)

    @property
    def relations(self) -> tuple[sp.Expr, sp.Expr]:
        """What vanishes."""
        return self.u.curve, self.v.curve

    def mirror(self, expr: sp.Expr) -> sp.Expr:
        """The same with -v for v; wp is even."""
        return expr.xreplace({self.v.slope: -self.v.slope})

    def start(self, expr: sp.Expr) -> sp.Expr:
        """The expansion at v = 0 up to the constant term, where ``STEP`` stands for v."""
        wp, slope, _ = at_zero()
        small = sp.together(expr.xreplace({self.v.p: wp, self.v.slope: slope}))
        return sp.expand(sp.series(small, STEP, 0, 1).removeO())

    def claims(self) -> dict[str, tuple[sp.Expr, sp.Expr]]:
        """Pairs that must be equal for the three to be what they are called."""
        u, v = self.u, self.v
        other = self.mirror(self.zeta)

        def by(point: Point, expr: sp.Expr) -> sp.Expr:
            return rate(expr, point.rates)

        return {
            "wp(u+v) depends on u+v alone": (by(u, self.wp), by(v, self.wp)),
            "wp(u+v) at v = 0": (self.start(self.wp), u.p),
            "zeta(u+v) by u": (by(u, self.zeta), u.p - self.wp),
            "zeta(u+v) by v": (by(v, self.zeta), v.p - self.wp),
            "zeta(u+v) at v = 0": (self.start(self.zeta), -1 / STEP),
            "log sigma(u+v) sigma(u-v) by u": (by(u, self.sigma), self.sigma * (self.zeta + other)),
            "log sigma(u+v) sigma(u-v) by v": (by(v, self.sigma), self.sigma * (self.zeta - other)),
            "sigma(u+v) sigma(u-v) at v = 0": (self.start(self.sigma * STEP**2), sp.Integer(1)),
        }

    def proofs(self) -> dict[str, vo.Verdict]:
        """The verdict on each claim."""
        return {k: vo.prove_equal(a, b, self.relations) for k, (a, b) in self.claims().items()}

    def prove(self) -> AdditionLaw:
        """Itself, if every claim is proved."""
        insist(self.proofs())
        return self


def insist(proofs: Mapping[str, vo.Verdict]) -> None:
    """Raise ``DefinitionError`` unless every verdict is proved."""
    for claim, verdict in proofs.items():
        if not verdict.proved:
            raise vo.DefinitionError(f"the addition law: '{claim}' is not proved: {verdict.method}")


@cache
def addition_law(u: str, v: str) -> AdditionLaw:
    """The proved law for two arguments, named in LaTeX."""
    return AdditionLaw.derive(Point.at(u), Point.at(v)).prove()


@dataclass(frozen=True)
class Functions:
    """Weierstrass' functions for a dictionary: defined at u, v, u + v, u - v and the negatives.

    ``wp`` holds wp, wp', wp'' at each place; ``zeta`` and ``sigma`` hold one value.
    """

    arguments: tuple[sp.Symbol, sp.Symbol]
    wp: Mapping[Place, Sequence[sp.Expr]]
    zeta: Mapping[Place, sp.Expr]
    sigma: Mapping[Place, sp.Expr]

    def names(self) -> dict[str, Callable[[Any], sp.Expr]]:
        r"""``\wp`` and its derivatives."""
        return {r"\wp" + "'" * order: self._derivative(order) for order in range(3)}

    def odd(self, values: Mapping[Place, sp.Expr]) -> Callable[[Any], sp.Expr]:
        """An odd function with the given values."""

        def value(argument: Any) -> sp.Expr:
            sign, place = self._place(argument, values)
            return sign * values[place]

        return value

    def _derivative(self, order: int) -> Callable[[Any], sp.Expr]:
        def value(argument: Any) -> sp.Expr:
            sign, place = self._place(argument, self.wp)
            return sign**order * self.wp[place][order]

        return value

    def _place(self, argument: Any, places: Iterable[Place]) -> tuple[int, Place]:
        """Sign and place of an argument: at the place or at its negative."""
        u, v = self.arguments
        argument = sp.expand(argument)
        for m, n in places:
            for sign in (1, -1):
                if argument == sign * (m * u + n * v):
                    return sign, (m, n)
        raise vo.DefinitionError(f"no elliptic function is known at the argument {argument}")


def functions(u: str, v: str) -> tuple[Functions, AdditionLaw]:
    """The functions of two arguments, named in LaTeX, and the law that they come from."""
    law = addition_law(u, v)
    wp: dict[Place, tuple[sp.Expr, ...]] = {}
    for place, point in (((1, 0), law.u), ((0, 1), law.v)):
        wp[place] = (point.p, point.slope, point.second)
    total = [law.wp]
    for _ in range(2):
        total.append(rate(total[-1], law.u.rates))
    wp |= {(1, 1): tuple(total), (1, -1): tuple(law.mirror(value) for value in total)}
    zetas = {(1, 0): law.u.zeta, (0, 1): law.v.zeta}
    zetas[1, 1] = law.u.zeta + law.v.zeta + law.zeta
    zetas[1, -1] = law.u.zeta - law.v.zeta + law.mirror(law.zeta)
    apart = sp.Symbol(rf"\sigma{{({u}-{v})}}")
    sigmas = {(1, 0): law.u.sigma, (0, 1): law.v.sigma, (1, -1): apart}
    sigmas[1, 1] = law.sigma * law.u.sigma**2 * law.v.sigma**2 / apart
    arguments = (sp.Symbol(u), sp.Symbol(v))
    return Functions(arguments, wp, zetas, sigmas), law


SOURCE = "the differential equation of wp, and the expansions at 0"
NOTE = "the functions at a sum are proved by their derivatives in both arguments and the limit at 0"


def addition_studies() -> dict[str, Study]:
    r"""``sum``, where ``\zeta`` is an argument; ``difference``, where it is a function of u, v."""
    here, law = functions("u", r"\zeta")
    letters = dict(zip(("u", r"\zeta"), here.arguments, strict=True))
    first = Study(
        {**letters, **here.names()},
        relations=law.relations,
        letters={"g": r"$g_2$ is the invariant of $\wp$ in $\wp'^2=4\wp^3-g_2\wp-g_3$"},
        context=law,
        note=NOTE,
        source=SOURCE,
    )
    there, law = functions("u", "v")
    names: dict[str, Any] = dict(zip(("u", "v"), there.arguments, strict=True))
    names |= there.names()
    names |= {r"\zeta": there.odd(there.zeta), r"\sigma": there.odd(there.sigma)}
    second = Study(names, relations=law.relations, context=law, note=NOTE, source=SOURCE)
    return {"sum": first, "difference": second}


def abel(study: Study, _: Any) -> vo.Verdict:
    """Abel's theorem for the functions from which the others are made by products and quotients.

    wp' - a wp - b has the zeros u, v, -u-v if it has the zeros u, v: a line through two points of
    the curve meets it a third time there; its pole 0 has the order three.
    """
    law = study.context
    steep = (law.u.slope - law.v.slope) / (law.u.p - law.v.p)
    third = -rate(law.wp, law.u.rates)
    on_line = law.u.slope + steep * (law.wp - law.u.p)
    verdict = vo.prove_equal(third, on_line, law.relations)
    about = (
        "the zeros u, v, -u-v of wp' - a wp - b; that every elliptic function is made of such "
        "by products and quotients is quoted"
    )
    return vo.Verdict(verdict.status, f"{verdict.method}; {about}", verdict.witness)
