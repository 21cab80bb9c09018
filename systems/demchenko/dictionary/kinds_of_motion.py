"""What can be decided about the constants of the paper, and about the kinds of motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Range, Study

from .. import A, k, n, s, tau, u
from .quadratures import C5, GAMMA, INERTIA, RATIO, h, level, p, share, x

Decide = Callable[[Study, Range], vo.Verdict]


def sign_in_range(value: Any, relation: str, where: Range) -> vo.Verdict:
    """The sign of an expression in a range, k being positive: else the axis is turned round."""
    inside = sp.sympify(value).xreplace(dict(where.values))
    return vo.prove_inequality(inside, relation, 0, (*where.positive, k))


def chain_of(*steps: tuple[str, vo.Verdict]) -> vo.Verdict:
    """Proved where all steps are; else the first that is not."""
    for what, verdict in steps:
        if not verdict.proved:
            return vo.Verdict(verdict.status, f"{what}: {verdict.method}", verdict.witness)
    return vo.Verdict("proved", "; ".join(f"{what} ({v.method})" for what, v in steps))


def equal(left: Any, right: Any) -> vo.Verdict:
    """Equality by the state: constants are replaced by what they are along the motion."""
    given = level().integrals
    sides = [sp.sympify(e).subs(x, sp.cos(u)).xreplace(given) for e in (left, right)]
    return vo.prove_equal(*sides)


def refutation(method: str, point: Mapping[Any, Any], left: Any, right: Any) -> vo.Verdict:
    """Refuted by exact values."""
    named = {str(name): str(value) for name, value in point.items()}
    return vo.Verdict("refuted", method, vo.Witness(named, str(left), str(right)))


def body(where: Range, zero: Any = None) -> dict[Any, Any]:
    """A body of a range with I = 1: its A and mu'; the A for which ``zero`` vanishes, if any."""
    numbers = {INERTIA: sp.Integer(1), p: sp.Integer(1 if zero is None else 3)}
    inside = {name: value.xreplace(numbers) for name, value in where.values.items()}
    part = 1 if zero is None else sp.solve(zero.xreplace(numbers).xreplace(inside), share)[0]
    if not part > 0:
        raise vo.DefinitionError(f"no such body: {where.statement} does not hold for it")
    return {
        INERTIA: numbers[INERTIA],
        **{a: value.subs(share, part) for a, value in inside.items()},
    }


def at_state(value: Any, numbers: Mapping[Any, Any]) -> Any:
    """A value in x and the constants of the motion, at a state of a body."""
    constants = {c: e.xreplace(numbers) for c, e in level().integrals.items()}
    return value.xreplace(constants).xreplace(numbers)


# -- the polynomial X -----------------------------------------------------------------------


def leading_coefficient() -> Any:
    """The coefficient of x^4 in X."""
    return level().quartic.LC()


def leading_text(_: Study) -> str:
    """The same as LaTeX."""
    insist_equal(leading_coefficient(), -INERTIA * (INERTIA * level().mu ** 2 + 4 * A * RATIO))
    return r"a_0=-I(I\mu^2+4A\mu')"


def insist_equal(left: Any, right: Any) -> None:
    """What is printed as derived must be proved."""
    if not vo.prove_equal(left, right).proved:
        raise vo.DefinitionError(f"'{left}' is to be printed as '{right}', which it is not")


def quadratic(_: Study, __: Range) -> vo.Verdict:
    """Degrees of phi, psi, F, theta; X by phi and psi; the printed forms."""
    own = level()
    degrees = [sp.Poly(q, x).degree() for q in (own.phi, own.psi, own.F, own.theta)]
    if max(degrees) > 2:
        return refutation("a degree is larger", {}, max(degrees), 2)
    form = vo.prove_equal(own.X, (1 - x**2) * own.psi - own.phi**2)
    return chain_of(("phi, psi, F, theta have degree two; X = (1 - x^2) psi - phi^2", form))


def quadratic_text(_: Study) -> str:
    """phi, psi, theta and F as LaTeX."""
    return r",\quad ".join(f"{left}={right}" for left, right in forms())


def forms(*wanted: str) -> list[tuple[str, str]]:
    """The proved forms of some of phi, psi, theta, F: LaTeX of both sides."""
    for _, _, value, form in printed_forms():
        insist_equal(value, form)
    return [(left, right) for left, right, _, _ in printed_forms() if not wanted or left in wanted]


def in_seconds(_: Study, __: Any) -> list[tuple[str, str]]:
    """The square of the rate of x by X, X by the state."""
    own = level()
    left = (own.rate(sp.cos(u)) * own.pace) ** 2
    if not equal(left, own.X).proved:
        raise vo.DefinitionError("the square of the rate of x is not X / pace^2")
    return [(r"\big(\frac{dx}{dt}\big)^2", r"\frac{k^2}{b_2^2}X(x)")]


def by_state(_: Study, __: Any) -> list[tuple[str, str]]:
    """X by the state."""
    own = level()
    if not equal(own.X, (own.pace * tau * sp.sin(u) / own.mu) ** 2).proved:
        raise vo.DefinitionError("X is not what the state gives")
    return [("X", r"\frac{b_2^2\tau^2\sin^2u}{k^2\mu^2}")]


def printed_forms() -> list[tuple[str, str, Any, Any]]:
    """phi, psi, theta, F in the letters of the paper: LaTeX of both sides, and their values."""
    own, names = level(), level().names()
    P, mu, x0 = own.P, own.mu, names["x_0"]
    spin = C5 - k * mu * x
    speed = 2 * P / (k * mu) * (2 * h * A - spin**2)
    width = 2 * h * A / (k * mu) ** 2
    b0, b1, b2, area = (names[b] for b in ("b_0", "b_1", "b_2", r"\bar\Gamma"))
    return [
        (
            r"\phi(x)",
            r"-b_0x^2+2b_1x_0x-\bar\Gamma",
            own.phi,
            -b0 * x**2 + 2 * b1 * x0 * x - area,
        ),
        (r"\psi(x)", r"2b_2\left(h'^2-(x-x_0)^2\right)", own.psi, 2 * b2 * (width - (x - x0) ** 2)),
        (
            r"\theta(x)",
            r"\Gamma^2-(C_5-k\mu'x)^2",
            own.theta,
            GAMMA**2 - (C5 - k * RATIO * x) ** 2,
        ),
        (
            "F(x)",
            r"\mu'\Gamma\left(\tfrac{2P}{k\mu}\left(2hA-(C_5-k\mu x)^2\right)-k\phi(x)\right)",
            own.F,
            RATIO * GAMMA * (speed - k * own.phi),
        ),
    ]


def even_count(_: Study, __: Range) -> vo.Verdict:
    """Roots that are not real come in pairs; the degree is even unless a_0 = 0."""
    if vo.prove_equal(leading_coefficient(), 0).refuted and level().quartic.degree() == 4:
        return vo.Verdict("proved", "X has degree four unless a_0 = 0, and complex roots in pairs")
    return vo.Verdict("undecided", "X has not the degree four")


def without_roots(_: Study, __: Range) -> vo.Verdict:
    """A polynomial X without real roots is negative, since X(1) is not positive."""
    own = level()
    ends = own.X.subs(x, 1), -(own.phi.subs(x, 1) ** 2)
    return chain_of(("X(1) = -phi(1)^2, so that X < 0 if it has no root", vo.prove_equal(*ends)))


def single_gap(_: Study, __: Range) -> vo.Verdict:
    """With two real roots x lies between them.

    That is where X > 0 for a_0 < 0.  For a_0 > 0, X is positive outside the roots, and there are
    x = 1 and x = -1 between them, since X <= 0 at both: no motion is left.
    """
    own = level()
    q, low, wide = sp.symbols("q1:4", positive=True)
    inside = q / (1 + q)
    pair = {"between": inside, "above": 1 + q, "below": -q}
    steps = []
    for end in (1, -1):
        ends = own.X.subs(x, end), -(own.phi.subs(x, end) ** 2)
        steps.append((f"X({end}) = -phi({end})^2", vo.prove_equal(*ends)))
    for name, place in pair.items():
        value = -place * (place - 1) * ((place - low) ** 2 + wide)
        relation = ">" if name == "between" else "<"
        found = vo.prove_inequality(value, relation, 0)
        steps.append((f"-X/a_0 {relation} 0 {name} the roots", found))
    return chain_of(*steps)


def gaps_text(_: Study) -> str:
    """Where x runs between these roots, as LaTeX."""
    insist_equal(leading_coefficient(), -INERTIA * (INERTIA * level().mu ** 2 + 4 * A * RATIO))
    return r"I\mu^2+4A\mu'=-a_0/I>0"


def outer_gaps(_: Study, where: Range) -> vo.Verdict:
    """With four real roots x lies between the two largest, or the two smallest.

    Just where a_0 < 0: where a_0 > 0, X(1) and X(-1) <= 0 put x = 1 and x = -1 into the gaps in
    which X < 0, so that X > 0 is left between the middle roots alone.
    """
    negative = sign_in_range(leading_coefficient(), "<", where)
    if not negative.proved:
        return _between_the_middle_roots(where)
    return chain_of(("a_0 < 0", negative), *_signs_of_the_gaps())


def _signs_of_the_gaps() -> list[tuple[str, vo.Verdict]]:
    """For a_0 < 0 and any four real roots, X < 0 in the middle gap and outside all roots."""
    q = sp.symbols("q1:5", positive=True)
    roots = [0, q[0], q[0] + q[1], q[0] + q[1] + q[2]]
    places = {"below all roots": -q[3], "above all roots": roots[3] + q[3]}
    places["between the middle roots"] = roots[1] + q[1] * q[3] / (1 + q[3])
    return [
        (f"{name} X < 0", vo.prove_inequality(-sp.prod(place - r for r in roots), "<", 0))
        for name, place in places.items()
    ]


def _between_the_middle_roots(where: Range) -> vo.Verdict:
    """Data with a_0 > 0: X < 0 at the ends, X > 0 at x; so one root on each side of each."""
    place = sp.Rational(3, 5)
    state = {k: 1, s: sp.Rational(1, 5), n: 1, tau: 1}
    numbers = {**body(where), **state, sp.cos(u): place, sp.sin(u): sp.Rational(4, 5)}
    X = sp.Poly(at_state(level().X, numbers), x)
    below = X.count_roots(None, place)
    if X.LC() > 0 and X.eval(place) > 0 and X.count_roots() == 4 and below == 2:
        point = {str(name).replace("(u)", " u"): value for name, value in numbers.items()}
        method = "a_0 > 0 there, and the motion runs between the second and the third root"
        return refutation(method, point, f"{below} roots below x", "1 or 3 roots below x")
    return vo.Verdict("undecided", "a_0 may be positive")
