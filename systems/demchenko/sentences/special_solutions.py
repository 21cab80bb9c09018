"""Special Solutions: precessions, stationary motions, remarkable trajectories, their stability."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Study, one_of

from .. import A, axis, k, momentum, n, s, tau, u
from ..dictionary.kinds_of_motion import at_state, body, chain_of, refutation
from ..dictionary.quadratures import PARAMETERS, RATIO, level, x
from ..dictionary.stability import (  # noqa: F401  (named in the print)
    at_rest,
    condition,
    of_sign,
    ordinary_ball,
    ordinary_text,
    precessions_exist,
    rates_of,
    remarkable,
    small_nutation,
    small_nutation_text,
    stationary,
    verdict_of_claim,
)
from ..transcription import sentences
from .claims import agreement, all_of, constant, denial, exists

SPINS = {"s": s, r"\tau": tau, "n": n}


def precession_at(where: Range) -> dict[Any, Any]:
    """The state of a regular precession at cos u = 3/5 of a body of a range, in numbers."""
    numbers = {**body(where), k: 1, s: 1, tau: 0, sp.cos(u): sp.Rational(3, 5)}
    numbers[sp.sin(u)] = sp.Rational(4, 5)
    turning = rates_of(tau)[tau].xreplace(numbers)
    return {**numbers, n: sp.solve(turning, n)[0]}


def classes(study: Study, _: Range, *, count: int) -> vo.Verdict:
    """As many classes as the list has items; each is a record of its own."""
    return agreement(count, study.context.count(r"\item"), "items of the list")


def precessions(study: Study, where: Range, *, how: str, spheres: str, curves: str) -> vo.Verdict:
    """Regular precessions, and what their traces are."""
    found = precessions_exist(study, where)
    along = {"parallels": "u", "meridians": "v", "great circles": "neither"}
    return all_of(
        exists(how, found, at_rest(study, where)),
        agreement(
            one_of(spheres, {"both": 2, "neither": 0, "none of": 0}), 2, "traces on parallels"
        ),
        agreement(one_of(curves, along), "u", "the coordinate that is constant"),
    )


def meaning(formula: Quoted) -> tuple[int, str]:
    """Which derivative of X is compared with zero, and how."""
    return condition(" ".join(formula.latex.strip("$ \n\t").rstrip(" .,").split()))


def by_second(
    study: Study, where: Range, *, sort: bool, when: Quoted, other: bool, opposite: Quoted
) -> vo.Verdict:
    """Stable and unstable by the sign of the second derivative."""
    return all_of(
        verdict_of_claim(of_sign(meaning(when), study, where), sort),
        lambda: verdict_of_claim(of_sign(meaning(opposite), study, where), other),
    )


def by_third(
    study: Study, where: Range, *, between: Quoted, sort: bool, when: Quoted
) -> vo.Verdict:
    """The case that the signs of the second derivative leave open, and a third that vanishes."""
    return all_of(
        agreement(meaning(between), (2, "="), "the case that X'' < 0 and X'' > 0 leave open"),
        lambda: verdict_of_claim(of_sign(meaning(when), study, where), sort),
    )


def by_third_else(study: Study, where: Range, *, one: bool, two: bool, when: Quoted) -> vo.Verdict:
    """The print has two words for one situation."""
    found = of_sign(meaning(when), study, where)
    if one != two:
        about = f"it is called stable and unstable at once; {found.method}"
        return vo.Verdict("refuted", about, found.witness)
    return verdict_of_claim(found, one)


def nutation(
    study: Study,
    where: Range,
    *,
    how: str,
    than: str,
    small: tuple[str, ...],
    ever: str,
    sort: bool,
) -> vo.Verdict:
    """The nutation is small where k is large against all that the bound depends on."""
    found = small_nutation(study, where)
    given = {name.removesuffix("_0") for name in small}
    left = {w for name, w in SPINS.items() if name not in given or than != ">"}
    for name in sorted(given):
        one_of(name, SPINS)
    if left:
        return refuted_nutation(left, where)
    return all_of(
        exists(how, found),
        denial(sort, found) if ever == "all" else exists(ever, denial(sort, found)),
    )


def refuted_nutation(free: set[Any], where: Range) -> vo.Verdict:
    """Components of the initial rotation that are as large as k give a nutation that is not small.

    From u_0 = pi/2, x moves from 0 beyond a number; the others of s_0, tau_0, n_0 are zero.
    """
    start = {w: k if w in free else sp.Integer(0) for w in (s, tau, n)}
    numbers = {**body(where), sp.cos(u): 0, sp.sin(u): 1}
    numbers |= {w: e.xreplace({k: sp.Integer(1)}) for w, e in start.items()} | {k: 1}
    X, reach = sp.Poly(at_state(level().X, numbers), x), sp.Rational(1, 4)
    for end in (reach, -reach):
        inside = X.count_roots(*sorted((0, end)))
        if X.eval(end) > 0 and inside == (1 if X.eval(0) == 0 else 0):
            rest = {f"{w}_0": e for w, e in start.items()}
            point = {"I": 1, "A": numbers[A], "mu'": numbers[RATIO], "u_0": "pi/2", **rest}
            about = "as large as the momentum of the gyroscope, and the nutation is not small"
            some = " and ".join(sorted(f"{w}_0" for w in free))
            return refutation(
                f"{some} may be {about}", point, f"x runs from 0 beyond {end}", "x = 0"
            )
    return vo.Verdict("undecided", "no large nutation was found")


def stands(
    study: Study,
    where: Range,
    *,
    how: str,
    points: int,
    spheres: str,
    speed: str,
    orientation: str,
) -> vo.Verdict:
    """Stationary motions: s = tau = 0, and what is constant then."""
    resting = (sp.Matrix([0, 0, n]).cross(sp.Matrix(list(axis)))).expand()
    square = resting.dot(resting)
    turned = ("the axis turns as n sin u", vo.prove_equal(square, (n * sp.sin(u)) ** 2))
    return all_of(
        exists(how, at_rest(study, where)),
        agreement(points, 1, "points of which a trace consists"),
        agreement(one_of(spheres, {"both": 2, "neither": 0}), 2, "traces that are points"),
        agreement(
            (constant(speed), constant(orientation)), (True, True), "whether both are constant"
        ),
        lambda: chain_of(turned),
    )


def ever_stable(study: Study, where: Range, *, ever: str, sort: bool) -> vo.Verdict:
    """Whether all stationary motions are stable, or unstable, or none is."""
    found = stationary(study, where)
    if ever == "all" and sort:
        return found
    resting = vo.Verdict("proved", "a ball that rests without spinning is stable")
    if ever == "none" or not sort:
        return denial((ever == "none") != sort, resting)
    return vo.Verdict("undecided", f"whether that is so for '{ever}' is not decided here")


def without_spin(study: Study, where: Range, *, sort: str, state: str) -> vo.Verdict:
    """k = 0: n and s^2 + tau^2 are constant, as they are for a ball without a gyroscope."""
    turning = one_of(
        state, {"stays at rest": False, "rests": False, "rotates": True, "moves": True}
    )
    plain = one_of(sort, {"ordinary": True, "gyroscopic": False})
    if turning == plain:
        rate = rates_of(n)[n]
        return chain_of(("the rate of n is zero", vo.prove_equal(rate, 0)))
    if plain:
        return ordinary_ball(study, where)
    return vo.Verdict("undecided", "that is no class of its own")


DEPENDS = {"independent": False, "dependent": True}


def remarkable_ones(study: Study, where: Range, *, how: str, along: str, vector: str) -> vo.Verdict:
    """The axis along the momentum and at rest: the path is the same whatever the energy."""
    found = remarkable(study, where)
    spun = sp.Matrix([s, 0, 0])
    vectors = {"moment": momentum.xreplace(PARAMETERS), "velocity": spun}
    chosen = one_of(vector, vectors).xreplace({tau: 0, n: 0, sp.cos(u): 0, sp.sin(u): 1})
    flat = sp.Matrix(list(axis)).xreplace({sp.cos(u): 0, sp.sin(u): 1})
    products = {"parallel": chosen.cross(flat), "orthogonal": sp.Matrix([chosen.dot(flat)])}
    gap = one_of(along, products)
    steps = [(f"{along} at the equator", vo.prove_equal(e, 0)) for e in gap]
    return all_of(exists(how, found), lambda: chain_of(*steps))


def of_energy(study: Study, where: Range, *, dependence: str) -> vo.Verdict:
    """On them s is free, and with it the energy: the equator is the path for every s."""
    equator: Mapping[Any, Any] = {sp.cos(u): 0, sp.sin(u): 1, tau: 0, n: 0}
    rates = {w: rate.xreplace(equator) for w, rate in rates_of(u, s, tau, n).items()}
    energy = sp.diff(level().declared["energy"].xreplace(equator), s)
    if vo.prove_equal(energy, 0).proved:
        return vo.Verdict("undecided", "the energy does not depend on s")
    found = chain_of(
        *((f"the rate of {w} is zero", vo.prove_equal(r, 0)) for w, r in rates.items())
    )
    return denial(not one_of(dependence, DEPENDS), found)


def latex_of_situation(_: Study) -> str:
    """What was derived instead."""
    return r"\text{and the unstable situation corresponds to}"


SENTENCES = sentences(__file__, globals())
