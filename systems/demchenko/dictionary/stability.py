"""Stability of the particular motions: decisions by the signs of X beside a double root.

A motion with constant x is stable where x stays as near as one likes if the motion begins near
enough, in u, s, tau, n; the angles v, v1 may drift.  Since (b_2/k dx/dt)^2 = X(x), and X depends
continuously on the initial state, X < 0 on both sides at every small distance keeps x in between;
X > 0 on one side lets motions of the same constants, begun there as near as one likes, move away.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Range, Study

from .. import A, axis, k, momentum, n, s, tau, u, u1, v, v1
from .kinds_of_motion import Decide, chained, equal, leading, refuted, signed
from .quadratures import C5, GAMMA, INERTIA, PARAMETERS, RATIO, h, level, p, x

e = sp.Symbol("e", positive=True)
FREE = sp.symbols("g l m a b", positive=True)


# -- regular precessions --------------------------------------------------------------------


def beside(second: int, third: int) -> tuple[Any, Any]:
    """X / y^2 at y = e and y = -e, if the second and third derivative have given signs there.

    X = y^2 (c + d y + a_0 y^2); e is as small as |c| > |d| e + |a_0| e^2, or |d| > |a_0| e,
    requires, and any numbers that satisfy this are positive combinations of FREE.
    """
    g, first, other, a, b = FREE
    c = second * (g + (first + other) * e + (a + b) * e**2)
    d = first - other if second else third * (g + (a + b) * e)
    return c + d * e + (a - b) * e**2, c - d * e + (a - b) * e**2


def stable(second: int, third: int = 0) -> vo.Verdict:
    """Whether a double root of X with these signs of X'' and X''' is stable; X'''' is not zero."""
    right, left = beside(second, third)
    signs = [vo.prove_inequality(side, "<", 0) for side in (right, left)]
    if all(v.proved for v in signs):
        return chained(*(("X < 0 beside the root", v) for v in signs))
    away = next(v for v in (vo.prove_inequality(w, ">", 0) for w in (right, left)) if v.proved)
    return refuted(f"X > 0 on one side of the root: {away.method}", {}, "X > 0", "X < 0")


def precession(position: int, claimed: bool) -> Decide:
    """Whether a precession is stable, or unstable, as claimed, under the condition printed there.

    The context of the study are the conditions of the section as printed, in order; a condition on
    X''' is one besides X'' = 0.
    """

    def decide(study: Study, where: Range) -> vo.Verdict:
        order, relation = condition(study.context[position])
        if order == 3 and condition(study.context[2]) != (2, "="):
            return vo.Verdict("undecided", "the condition on the second derivative is another one")
        if (order, relation) == (3, "="):
            return claimed_of(fourfold(study, where), claimed)
        signs = {(2, "<"): (-1, 0), (2, ">"): (1, 0), (3, "\\ne"): (0, 1)}
        if (order, relation) not in signs:
            return vo.Verdict("undecided", "the condition as printed leaves the sign open")
        return claimed_of(stable(*signs[order, relation]), claimed)

    return decide


def condition(printed: str) -> tuple[int, str]:
    """Which derivative of X is compared with zero, and how."""
    found = re.search(r"\\partial\^(\d) X\}.*?(<|>|=|\\ne) ?0$", printed)
    return (int(found[1]), found[2]) if found else (0, "")


def claimed_of(found: vo.Verdict, claimed: bool) -> vo.Verdict:
    """The verdict on "stable", or on "unstable", where that on "stable" was found."""
    if claimed or found.undecided:
        return found
    if found.refuted:
        return vo.Verdict("proved", found.method)
    return refuted(found.method, {}, "unstable", "stable")


def fourfold(_: Study, where: Range) -> vo.Verdict:
    """X'' = X''' = 0 is stable: X = a_0 y^4 with a_0 < 0.

    X(1) = -phi(1)^2 excludes a_0 > 0; and a_0 = 0 leaves X = 0.
    """
    negative = signed(leading(), "<", where)
    if negative.proved:
        return chained(("X = a_0 y^4 with a_0 < 0", negative))
    return flat(where)


def flat(where: Range) -> vo.Verdict:
    """A precession on which X vanishes identically, and how x leaves it.

    At u = pi/2, n = 0, tau = 0 there is a value of s for that; a small tau makes X a positive
    multiple of 1 - x^2, so that x runs through all latitudes.
    """
    own = level()
    ratio = {name: value.subs(p, 1) for name, value in where.values.items()}
    numbers = {**ratio, A: 1, INERTIA: 8, k: 1, sp.cos(u): 0, sp.sin(u): 1, n: 0}
    mu, b0 = (own.names()[name].xreplace(numbers) for name in (r"\mu", "b_0"))
    numbers[s] = mu * b0 / (own.pace * k).xreplace(numbers)
    constants = {c: value.xreplace(numbers) for c, value in own.integrals.items()}
    X = sp.factor(own.X.xreplace(constants).xreplace(numbers))
    factor = sp.cancel(X / (1 - x**2) / tau**2)
    if not (factor.is_number and factor > 0):
        return vo.Verdict("undecided", "no such precession was found")
    point = {**ratio, A: 1, INERTIA: 8, k: 1, u: "pi/2", n: 0, s: numbers[s]}
    method = f"X = 0 for all x there, and X = {factor} tau^2 (1 - x^2) for tau != 0: x drifts away"
    return refuted(method, point, "x runs through (-1, 1)", "x stays")


def precessions_exist(_: Study, __: Range) -> vo.Verdict:
    """s is free; n follows from it so that nothing but v, v1 and theta changes."""
    own, rates = level(), rates_of(u, s, tau, n)
    turning = rates[tau].subs(tau, 0)
    slope, rest = sp.Poly(sp.together(turning), n).all_coeffs()
    steady = {tau: 0, n: sp.cancel(-rest / slope)}
    steps = [(f"the rate of {w} is zero", rate) for w, rate in rates.items()]
    double = sp.diff(own.X, x).subs(x, sp.cos(u)).xreplace(own.integrals)
    steps.append(("cos u is a double root of X", double))
    found = [(what, vo.prove_equal(value.xreplace(steady), 0)) for what, value in steps]
    height = equal(own.upright[sp.cos(u1)], -(C5 - k * RATIO * x) / GAMMA)
    return chained(*found, ("Gamma cos u1 = k mu' x - C_5 is constant with x", height))


def rates_of(*symbols: Any) -> dict[Any, Any]:
    """Rates along the motion."""
    return {symbol: level().rate(symbol) for symbol in symbols}


# -- fast and stationary motions ------------------------------------------------------------


def small_nutation(_: Study, where: Range) -> vo.Verdict:
    """|x - x(0)| <= 2 sqrt(2 h A) / (k |mu|) on every motion."""
    own = level()
    spin = C5 - k * own.mu * x
    energy = equal(2 * h * A - spin**2, A * own.P * (s**2 + tau**2))
    margin = signed(A * own.P * (s**2 + tau**2), ">=", where)
    return chained(
        ("2hA - (C5 - k mu x)^2 = A P (s^2 + tau^2)", energy),
        ("so k |mu| |x - x(0)| <= 2 sqrt(2 h A), whatever the range", margin),
    )


def at_rest(_: Study, __: Range) -> vo.Verdict:
    """s = tau = 0 stays so just where k n sin u = 0; then u, v, u1, v1 and n are constant."""
    own, rest = level(), {s: 0, tau: 0}
    steps = [(f"the rate of {w} is zero", (r, 0)) for w, r in rates_of(u, v, u1, v1, s, n).items()]
    steps.append(("P d tau/dt = k n sin u", (own.P * own.rate(tau), k * n * sp.sin(u))))
    found = ((what, vo.prove_equal(a.xreplace(rest), b)) for what, (a, b) in steps)
    return chained(*found)


@cache
def polar(end: int) -> Any:
    """X / (1 - end x)^2 at x = end, for the ball that spins there with s = tau = 0."""
    own = level()
    here = {sp.cos(u): end, sp.sin(u): 0, s: 0, tau: 0}
    constants = {c: value.xreplace(here) for c, value in own.integrals.items()}
    return sp.cancel(sp.cancel(own.X.xreplace(constants) / (1 - end * x) ** 2).subs(x, end))


def stationary(study: Study, where: Range) -> vo.Verdict:
    """At rest (n = 0) by the bound of the nutation; at x = 1 or -1 by the sign beside it."""
    steps = [("n = 0", small_nutation(study, where))]
    for end in (1, -1):
        sign, worse = (signed(polar(end), relation, where) for relation in ("<", "<="))
        if worse.refuted:
            method = f"a ball that spins at x = {end}: X / (1 - |x|)^2 is positive beside it"
            return replace(worse, method=f"{method}, {worse.method}")
        steps.append((f"X / (1 - |x|)^2 < 0 at x = {end}", sign))
    return chained(*steps)


# -- remarkable trajectories ----------------------------------------------------------------


def remarkable(_: Study, __: Range) -> vo.Verdict:
    """Axis along the momentum and at rest: then u = u1 = pi/2, n = tau = 0, and s is free."""
    along = sp.Matrix(axis)
    spin = sp.Matrix([s, tau, n])
    parallel, resting = (
        sp.expand(vector.cross(along.T if vector.shape[0] == 1 else along)[1].subs(tau, 0))
        for vector in (momentum.xreplace(PARAMETERS), spin)
    )
    equator = {sp.cos(u): 0, sp.sin(u): 1, tau: 0, n: 0}
    steps = [
        (
            "both need I s cos u = 0 besides tau = 0",
            (parallel - A * resting, -INERTIA * s * sp.cos(u)),
        ),
        ("axis and momentum are parallel where u = pi/2, n = 0", (parallel.xreplace(equator), 0)),
        ("the axis rests there", (resting.xreplace(equator), 0)),
        ("cos u1 = 0", (level().upright[sp.cos(u1)].xreplace(equator), 0)),
    ]
    rates = rates_of(u, s, tau, n)
    steps += [(f"the rate of {w} is zero", (r.xreplace(equator), 0)) for w, r in rates.items()]
    return chained(*((what, vo.prove_equal(*sides)) for what, sides in steps))
