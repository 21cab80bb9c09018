r"""The inversion of an elliptic integral: a quartic polynomial and a point that moves on its curve.

y = zeta(u + c) - zeta(u) - zeta(c), where c is the paper's argument ``\zeta``, has two simple poles
and y'^2 is a polynomial Y of degree four in y.  So y and y' are coordinates on the curve
y'^2 = Y(y), and everything else is rational in them.  y' is a positive symbol: the roots in the
paper are taken where x grows with u.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study

from .weierstrass import (
    G2,
    G3,
    STEP,
    Functions,
    Point,
    addition_law,
    at_zero,
    insist,
    match_coefficients,
    rate,
)

y, c = sp.Symbol("y"), sp.Symbol(r"\zeta")
slope = sp.Symbol("{y'}", positive=True)
a0 = sp.Symbol("a_0")
QUARTIC_COEFFICIENTS = (a0, *sp.symbols("a_1:5"))
"""The coefficients of X, without their binomial factors."""

AT_C = Point.at(r"\zeta")
SECOND = sp.Symbol(r"\wp''{(\zeta)}")
SOURCE = "the addition law of wp, derived from its differential equation and its poles"
NOTE = (
    r"$y'=\frac{dy}{du}$; the roots are taken where $x$ grows with $u$; $a_0$ has either sign; for "
    r"$a_0<0<X$, as on the ball, $u$ is imaginary"
)


def quartic(p: Any, first: Any, second: Any) -> sp.Expr:
    """Y, from wp, wp', wp'' at c."""
    found = _quartic().xreplace({AT_C.p: p, AT_C.slope: first})
    return sp.expand(found.xreplace({G2: 12 * p**2 - 2 * second}))


@cache
def _quartic() -> sp.Expr:
    """The polynomial Y with y'^2 = Y(y), by the expansions at u = 0; then proved."""
    law = addition_law("u", r"\zeta")
    _, _, zeta = at_zero()
    small = -sp.integrate(AT_C.taylor(4), STEP) - zeta
    unknown = sp.symbols("k0:5")
    powers = sp.Add(*[k * small**n for n, k in enumerate(unknown)])
    found = match_coefficients(powers, sp.diff(small, STEP) ** 2, unknown)
    polynomial = sp.Add(*[found[k] * y**n for n, k in enumerate(unknown)])
    left, right = rate(law.zeta, law.u.rates) ** 2, polynomial.xreplace({y: law.zeta})
    insist({"y'^2 = Y(y)": vo.prove_equal(left, right, law.relations)})
    return polynomial


@dataclass(frozen=True)
class Curve:
    """The curve y'^2 = Y(y) with given values of wp, wp', wp'' at c; ``branch`` is the sign of y'.

    ``p`` and ``first`` are wp and wp' at u, rational in y and y'.
    """

    at_c: tuple[sp.Expr, sp.Expr, sp.Expr]
    branch: int = 1

    @property
    def dot(self) -> sp.Expr:
        """dy/du."""
        return self.branch * slope

    @property
    def polynomial(self) -> sp.Expr:
        """Y(y)."""
        return quartic(*self.at_c)

    @property
    def relation(self) -> sp.Expr:
        """What vanishes on the curve."""
        return slope**2 - self.polynomial

    @property
    def fraction(self) -> sp.Expr:
        """y in wp and wp' at u."""
        return addition_law("u", r"\zeta").zeta

    @property
    def rates(self) -> dict[sp.Symbol, sp.Expr]:
        """Derivatives by u."""
        return {y: self.dot, slope: self.branch * sp.diff(self.polynomial, y) / 2}

    @property
    def invariants(self) -> dict[sp.Symbol, sp.Expr]:
        """g2 from wp'' at c, and then g3 from wp'."""
        p, first, second = self.at_c
        g2 = 12 * p**2 - 2 * second
        return {G2: g2, G3: 4 * p**3 - g2 * p - first**2}

    @property
    def at_u(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """wp, wp', wp'' at u: where the addition law gives y and y'."""
        law = addition_law("u", r"\zeta")
        places = {law.v.p: self.at_c[0], law.v.slope: self.at_c[1]}
        first = sp.solve(law.zeta.xreplace(places) - y, law.u.slope)[0]
        total = y**2 - law.u.p - self.at_c[0]  # wp(u+c), see ``proofs``
        p = sp.solve(law.u.p - total - self.dot, law.u.p)[0]
        return p, first.xreplace({law.u.p: p}), 6 * p**2 - self.invariants[G2] / 2

    @property
    def at_sum(self) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """wp, wp', wp'' at u + c."""
        p = self.at_u[0] - self.dot
        values = [p, rate(p, self.rates)]
        return values[0], values[1], 6 * p**2 - self.invariants[G2] / 2

    def functions(self) -> Functions:
        """What stands for wp in a dictionary."""
        wp = {(1, 0): self.at_u, (0, 1): self.at_c, (1, 1): self.at_sum}
        return Functions((vo.time, c), wp, {}, {})

    def claims(self) -> dict[str, tuple[sp.Expr, sp.Expr]]:
        """Pairs that must be equal for the values at u and at u + c to be those of wp."""
        law = addition_law("u", r"\zeta")
        p, first, second = self.at_u
        here = {law.u.p: p, law.u.slope: first, AT_C.p: self.at_c[0], AT_C.slope: self.at_c[1]}
        here |= self.invariants
        values = {e: e.xreplace(here) for e in (law.wp, law.zeta, law.u.curve, law.v.curve)}
        return {
            "wp'(u)": (rate(p, self.rates), first),
            "wp''(u)": (rate(first, self.rates), second),
            "the curve at u": (values[law.u.curve], sp.Integer(0)),
            "the curve at c": (values[law.v.curve], sp.Integer(0)),
            "y": (values[law.zeta], y),
            "wp(u+c)": (values[law.wp], self.at_sum[0]),
            "wp''(u+c)": (rate(self.at_sum[1], self.rates), self.at_sum[2]),
        }

    def proofs(self) -> dict[str, vo.Verdict]:
        """The verdict on each claim."""
        return {k: vo.prove_equal(a, b, (self.relation,)) for k, (a, b) in self.claims().items()}


@cache
def curve(branch: int = 1) -> Curve:
    """The curve with symbols for the values at c, proved."""
    found = Curve((AT_C.p, AT_C.slope, SECOND), branch)
    insist(found.proofs())
    return found


@cache
def coefficients() -> tuple[sp.Expr, tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """The shift h for which X(y + h) = a0 Y(y), and wp, wp', wp'' at c: by comparison."""
    h, values = sp.Symbol("h"), (AT_C.p, AT_C.slope, SECOND)
    gap = sp.Poly(sp.expand(general(y + h) - a0 * quartic(*values)), y)
    shift = sp.solve(gap.coeff_monomial(y**3), h)[0]
    rest = [gap.coeff_monomial(y**k).subs(h, shift) for k in range(3)]
    found = sp.solve(rest, values, dict=True)[0]
    return shift, tuple(sp.together(found[v]) for v in values)


def general(x: Any) -> sp.Expr:
    """A quartic with binomial factors."""
    return sp.Add(
        *[sp.binomial(4, k) * a * x ** (4 - k) for k, a in enumerate(QUARTIC_COEFFICIENTS)]
    )


def other_branch(argument: Any) -> sp.Expr:
    """wp where y falls as u grows."""
    return curve(-1).functions().names()[r"\wp"](argument)


def by_addition(_: Study, __: Any) -> vo.Verdict:
    """Whether the two relations hold where wp(u+c) is what the addition theorem says.

    With 2y for the fraction they are the theorem and the formula after it, word by word.
    """
    law = addition_law("u", r"\zeta")
    total = sp.Symbol(r"\wp{(u+\zeta)}")
    p, q, first, second = law.u.p, law.v.p, law.v.slope, law.v.second
    theorem = total + p + q - sp.Rational(1, 4) * (2 * y) ** 2
    after = first * 2 * y - second + 2 * (p - q) * (total - q)
    sums = (p - q) + (total - q) - (y**2 - 3 * q)
    products = 2 * (p - q) * (total - q) - (second - 2 * y * first)
    given = {total: law.wp, y: law.zeta}
    steps = [
        ("the first is the addition theorem", (sums, theorem), ()),
        ("the second is (eq:addition2)", (products, after), ()),
        ("this holds with the theorem", (after.xreplace(given), sp.Integer(0)), law.relations),
    ]
    for what, sides, relations in steps:
        verdict = vo.prove_equal(*sides, relations)
        if not verdict.proved:
            return vo.Verdict(verdict.status, f"{what}: {verdict.method}", verdict.witness)
    return vo.Verdict("proved", "; ".join(f"{what} (exact)" for what, _, _ in steps))


def inversion_studies() -> dict[str, Study]:
    r"""``y``: any c; ``x``: c that belongs to a given X; ``polynomial``: X as a function."""
    first = _study(curve(), {})
    shift, at_c = coefficients()
    names: dict[str, Any] = {f"a_{k}": a for k, a in enumerate(QUARTIC_COEFFICIENTS)}
    names |= {"x": y + shift, "h": shift, "X": a0 * slope**2}
    second = _study(Curve(at_c), names)
    third = replace(second, names={**second.names, "X": _value_of_x(shift, at_c)})
    return {"y": first, "x": second, "polynomial": third}


def _value_of_x(shift: sp.Expr, at_c: tuple[sp.Expr, ...]) -> Callable[[Any], sp.Expr]:
    """X, as a function of x."""
    return lambda x: a0 * quartic(*at_c).xreplace({y: x - shift})


def _study(at: Curve, more: dict[str, Any]) -> Study:
    names = {"u": vo.time, r"\zeta": c, "y": y, "Y": slope**2, **at.functions().names(), **more}
    motion = Motion(at.rates)
    return Study(
        names,
        motion=motion,
        functions=frozenset({"X", r"\phi", "F", r"\theta"}),  # of formulas that it refers to
        relations=(at.relation,),
        context=at,
        note=NOTE,
        source=SOURCE,
    )
