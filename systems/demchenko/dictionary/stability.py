"""Stability of the particular motions: decisions by the signs of X beside a double root.

A motion with constant x is stable where x stays as near as one likes if the motion begins near
enough, in u, s, tau, n; the angles v, v1 may drift.  Since (b_2/k dx/dt)^2 = X(x), and X depends
continuously on the initial state, X < 0 on both sides at every small distance keeps x in between;
X > 0 on one side lets motions of the same constants, begun there as near as one likes, move away.
This is for a root with -1 < x < 1, which has two sides; at x = 1 or -1, where only the inner side
matters, the ball spins in its place: a stationary motion.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Range, Sentence, Study

from .. import A, axis, k, momentum, n, s, tau, u, u1, v, v1
from .kinds_of_motion import (
    Decide,
    at_state,
    body,
    chain_of,
    equal,
    insist_equal,
    leading_coefficient,
    refutation,
    sign_in_range,
)
from .quadratures import C5, INERTIA, PARAMETERS, RATIO, h, level, x
from .trajectories import height

e = sp.Symbol("e", positive=True)
FREE = sp.symbols("g l m a b", positive=True)
NEAR = "at any small distance e from it, g, l, m, a, b being any positive numbers"


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
        return chain_of(*((f"X < 0 beside the root, {NEAR}", v) for v in signs))
    away = next(v for v in (vo.prove_inequality(w, ">", 0) for w in (right, left)) if v.proved)
    return refutation(f"X > 0 on one side of the root, {NEAR}: {away.method}", {}, "X > 0", "X < 0")


@dataclass(frozen=True)
class PrintedSection:
    """What the section prints: its conditions in order, and its sentences."""

    conditions: tuple[str, ...]
    sentences: tuple[Sentence, ...]

    def word(self, opening: str, slot: str) -> Any:
        """What stands in a slot of the sentence that begins so."""
        sentence = next(s for s in self.sentences if s.text.startswith(opening))
        return sentence.read({})[slot]


def precession(position: int, opening: str, slot: str) -> Decide:
    """Whether a precession is what a sentence calls it, under the condition printed there.

    The context of the study is ``Printed``; a condition on X''' is one besides X'' = 0.
    """

    def decide(study: Study, where: Range) -> vo.Verdict:
        found = condition(study.context.conditions[position])
        claimed = study.context.word(opening, slot)
        if found[0] == 3 and condition(study.context.conditions[2]) != (2, "="):
            return vo.Verdict("undecided", "the condition on the second derivative is another one")
        return verdict_of_claim(of_sign(found, study, where), claimed)

    return decide


def of_sign(found: tuple[int, str], study: Study, where: Range) -> vo.Verdict:
    """Whether a precession is stable under a condition; one on X''' is besides X'' = 0."""
    signs = {(2, "<"): (-1, 0), (2, ">"): (1, 0), (3, "\\ne"): (0, 1)}
    if found == (3, "="):
        return fourfold(study, where)
    if found in signs:
        return stable(*signs[found])
    return vo.Verdict("undecided", "the condition as printed leaves the sign open")


def left_open(study: Study, _: Range) -> vo.Verdict:
    """Whether the third condition is the case between the first two."""
    if condition(study.context.conditions[2]) == (2, "="):
        return vo.Verdict("proved", "a number that is neither positive nor negative is zero")
    return vo.Verdict("refuted", "the case that the two before leave open is X'' = 0")


def condition(printed: str) -> tuple[int, str]:
    """Which derivative of X by x^I is compared with zero, and how; (0, "") for anything else."""
    above, below = r"\\frac\{\\partial\^(\d)X\}", r"\{\\partialx\^\{I(\d)\}\}(<|>|=|\\ne)0"
    found = re.fullmatch(above + below, printed.replace(" ", ""))
    if found is None or found[1] != found[2]:
        return 0, ""
    return int(found[1]), found[3]


def verdict_of_claim(found: vo.Verdict, claimed: bool) -> vo.Verdict:
    """The verdict on "stable", or on "unstable", where that on "stable" was found."""
    if claimed or found.undecided:
        return found
    if found.refuted:
        return vo.Verdict("proved", found.method)
    return refutation(found.method, {}, "unstable", "stable")


def fourfold(_: Study, where: Range) -> vo.Verdict:
    """X'' = X''' = 0 is stable: X = a_0 y^4 with a_0 < 0.

    X(1) = -phi(1)^2 excludes a_0 > 0; and a_0 = 0 leaves X = 0.
    """
    negative = sign_in_range(leading_coefficient(), "<", where)
    if negative.proved:
        return chain_of(("X = a_0 y^4 with a_0 < 0", negative))
    return flat(where)


def flat(where: Range) -> vo.Verdict:
    """A precession on which X vanishes identically, and how x leaves it.

    At u = pi/2, n = 0, tau = 0 there is a value of s for that, if a_0 = 0; a small tau makes X a
    positive multiple of 1 - x^2, so that x runs through all latitudes.
    """
    own = level()
    bare = body(where, leading_coefficient())
    numbers = {**bare, k: 1, sp.cos(u): 0, sp.sin(u): 1, n: 0}
    mu, b0 = (own.names()[name].xreplace(numbers) for name in (r"\mu", "b_0"))
    numbers[s] = mu * b0 / (own.pace * k).xreplace(numbers)
    X = sp.factor(at_state(own.X, numbers))
    factor = sp.cancel(X / (1 - x**2) / tau**2)
    if not (factor.is_number and factor > 0):
        return vo.Verdict("undecided", "no such precession was found")
    point = {**bare, k: 1, u: "pi/2", n: 0, s: numbers[s]}
    method = f"X = 0 for all x there, and X = {factor} tau^2 (1 - x^2) for tau != 0: x drifts away"
    return refutation(method, point, "x runs through (-1, 1)", "x stays")


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
    return chain_of(*found, ("Gamma cos u1 = k mu' x - C_5 is constant with x", height()))


def rates_of(*symbols: Any) -> dict[Any, Any]:
    """Rates along the motion."""
    return {symbol: level().rate(symbol) for symbol in symbols}


# -- fast and stationary motions ------------------------------------------------------------


def bound_steps(where: Range) -> list[tuple[str, vo.Verdict]]:
    """|x - x(0)| <= 2 sqrt(2 h A) / (k |mu|) on every motion."""
    own = level()
    spin = C5 - k * own.mu * x
    energy = equal(2 * h * A - spin**2, A * own.P * (s**2 + tau**2))
    margin = sign_in_range(A * own.P * (s**2 + tau**2), ">=", where)
    return [
        ("2hA - (C5 - k mu x)^2 = A P (s^2 + tau^2)", energy),
        ("so k |mu| |x - x(0)| <= 2 sqrt(2 h A), whatever the range", margin),
    ]


def small_nutation(_: Study, where: Range) -> vo.Verdict:
    """The bound goes to zero as k grows, the state at the beginning being given."""
    free = vo.prove_equal(sp.diff(level().integrals[h], k), 0)
    return chain_of(
        *bound_steps(where),
        ("h is given by s_0, tau_0, n_0 alone, so that the bound goes to zero as k grows", free),
        ("a small n_0/k is needed", with_normal_spin(where)),
    )


def with_normal_spin(where: Range) -> vo.Verdict:
    """s_0 = tau_0 = 0, n_0 = k, u_0 = pi/2: x moves from 0 to a number that is not small."""
    reach = sp.Rational(1, 4)
    numbers = {**body(where), k: 1, s: 0, tau: 0, n: 1, sp.cos(u): 0, sp.sin(u): 1}
    X = sp.Poly(at_state(level().X, numbers), x)
    for end in (reach, -reach):
        inside = X.count_roots(*sorted((0, end)))
        if X.eval(0) == 0 and X.eval(end) > 0 and inside == 1:
            start = f"I = 1, A = {numbers[A]}, R_2/R_1 = {numbers[RATIO]}, k = n_0 = 1"
            about = f"{start}, u_0 = pi/2, s_0 = tau_0 = 0 x runs from 0 beyond {end}"
            return vo.Verdict("proved", f"for {about}, since X > 0 in between")
    return vo.Verdict("undecided", "no large nutation was found")


def small_nutation_text(_: Study) -> str:
    """The bound as LaTeX, and what must be small."""
    insist_equal(level().integrals[h] * 2 * A, A * level().P * (s**2 + tau**2) + A**2 * n**2)
    return (
        r"|x-x(0)|\le\frac{2}{|k\mu|}\sqrt{AP(s_0^2+\tau_0^2)+A^2n_0^2}"
        r"\quad\text{(so $n_0$, too, must be small against $k$)}"
    )


def at_rest(_: Study, __: Range) -> vo.Verdict:
    """s = tau = 0 stays so just where k n sin u = 0; then u, v, u1, v1 and n are constant."""
    own, rest = level(), {s: 0, tau: 0}
    steps = [(f"the rate of {w} is zero", (r, 0)) for w, r in rates_of(u, v, u1, v1, s, n).items()]
    steps.append(("P d tau/dt = k n sin u", (own.P * own.rate(tau), k * n * sp.sin(u))))
    found = ((what, vo.prove_equal(a.xreplace(rest), b)) for what, (a, b) in steps)
    return chain_of(*found)


def ordinary_ball(_: Study, __: Range) -> vo.Verdict:
    """k = 0: n and s^2 + tau^2 are constant, and so is the momentum, whatever the axis does."""
    rates = {w: rate.subs(k, 0) for w, rate in rates_of(s, tau, n).items()}
    speed = 2 * s * rates[s] + 2 * tau * rates[tau]
    return chain_of(
        ("the rate of n is zero", vo.prove_equal(rates[n], 0)),
        ("the rate of s^2 + tau^2 is zero", vo.prove_equal(speed, 0)),
    )


def ordinary_text(_: Study) -> str:
    """Which constants k = 0 leaves without a value, as LaTeX: k divides them."""
    names = level().names()
    for name in ("x_0", r"\bar\Gamma", "h'"):
        if vo.prove_equal(sp.denom(sp.cancel(names[name] ** 2)).subs(k, 0), 0).refuted:
            raise vo.DefinitionError(f"k does not divide '{name}'")
    return r"\dot n=0,\quad\text{while $x_0$, $\bar\Gamma$ and $h'$ are divided by $k=0$}"


@cache
def polar(end: int) -> Any:
    """X / (1 - end x)^2 at x = end, for the ball that spins there with s = tau = 0."""
    own = level()
    here = {sp.cos(u): end, sp.sin(u): 0, s: 0, tau: 0}
    constants = {c: value.xreplace(here) for c, value in own.integrals.items()}
    return sp.cancel(sp.cancel(own.X.xreplace(constants) / (1 - end * x) ** 2).subs(x, end))


def stationary(_: Study, where: Range) -> vo.Verdict:
    """At rest (n = 0, h = 0) by the bound of the nutation; at x = 1, -1 by the sign inside."""
    calm = vo.prove_equal(level().integrals[h].xreplace({s: 0, tau: 0, n: 0}), 0)
    steps = [*bound_steps(where), ("2h = 0 at rest, so that n = 0 is stable", calm)]
    for end in (1, -1):
        sign, worse = (sign_in_range(polar(end), relation, where) for relation in ("<", "<="))
        if worse.refuted:
            return spinning_away(where, end, worse)
        steps.append((f"X / (1 - |x|)^2 < 0 at x = {end}", sign))
    return chain_of(*steps)


def spinning_away(where: Range, end: int, worse: vo.Verdict) -> vo.Verdict:
    """A motion that leaves the pole: n between the two values at which X'' vanishes."""
    own, reach = level(), end * sp.Rational(1, 2)
    numbers = {**body(where), k: 1, sp.cos(u): end, sp.sin(u): 0, s: 0, tau: 0}
    numbers[n] = (-2 * end * k * own.mu / own.P).xreplace(numbers)
    X = sp.Poly(sp.cancel(at_state(own.X, numbers) / (1 - end * x) ** 2), x)
    if X.eval(end) > 0 and X.count_roots(*sorted((end, reach))) == 0:
        beside = f"with its constants, a motion begun beside x = {end} runs beyond x = {reach}"
        return refutation(f"{beside}: X > 0 there", numbers, f"beyond {reach}", f"x stays at {end}")
    return replace(worse, method=f"a ball that spins at x = {end}: X > 0, {worse.method}")


# -- remarkable trajectories ----------------------------------------------------------------


def remarkable(_: Study, __: Range) -> vo.Verdict:
    """Axis along the momentum and at rest: both cross products with the axis vanish.

    Their sum of squares gives tau = 0, their difference s cos u = 0.  If s = 0, the axis rests for
    n sin u = 0; if s is not 0, cos u = 0, and then the axis rests for n = 0.
    """
    own, along = level(), sp.Matrix(list(axis))
    parallel, resting = (
        sp.Matrix(list(vector)).cross(along).expand()
        for vector in (momentum.xreplace(PARAMETERS), (s, tau, n))
    )
    both = parallel - A * resting
    pole, equator = {sp.sin(u): 0, s: 0, tau: 0}, {sp.cos(u): 0, sp.sin(u): 1, tau: 0, n: 0}
    steps = [
        ("tau = 0", resting[0] ** 2 + resting[2] ** 2, tau**2),
        ("then I s cos u = 0", both[1], -INERTIA * s * sp.cos(u)),
        ("s = 0 leaves n sin u = 0: n = 0, or a pole", resting[1].subs(s, 0), -n * sp.sin(u)),
        ("cos u = 0 leaves n sin u = 0: n = 0", resting[1].subs(sp.cos(u), 0), -n * sp.sin(u)),
        ("cos u1 = 0 at the equator", own.upright[sp.cos(u1)].xreplace(equator), 0),
    ]
    for case in ({s: 0, tau: 0, n: 0}, pole, equator):
        rates = [rate.subs(s, 0) if s in case else rate for rate in rates_of(u, s, tau, n).values()]
        where = ", ".join(f"{name} = {value}" for name, value in case.items())
        squares = sp.Add(*(entry.xreplace(case) ** 2 for entry in (*parallel, *resting, *rates)))
        steps.append((f"along the momentum, at rest, and so for ever, for {where}", squares, 0))
    return chain_of(*((what, vo.prove_equal(a, b)) for what, a, b in steps))
