"""Solving the system in terms of elliptic functions: what the text says beside its displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Quoted, Range, Reference, Study, one_of

from .. import A, k, n, s, tau, theta, u, u1, v, v1
from ..dictionary.kinds_of_motion import (  # noqa: F401  (named in the print)
    chain_of,
    leading_coefficient,
    leading_text,
    quadratic,
    quadratic_text,
    sign_in_range,
)
from ..dictionary.quadratures import GAMMA, h, level, x
from ..transcription import sentences
from .claims import agreement, all_of, both_sides, constant, denial, equals, residuals, value

POLYNOMIALS = {r"\phi": "phi", r"\psi": "psi", "F": "F", r"\theta": "theta", "X": "X"}


def degree_of(study: Study, where: Range, *, degree: int, variable: tuple[str, ...]) -> vo.Verdict:
    """The coefficient of x^4 does not vanish, and there is no higher power."""
    highest = int(level().quartic.degree())
    return all_of(
        agreement(variable, ("x",), "the variable"),
        agreement(degree, highest, "the degree"),
        chain_of(
            (
                "the coefficient of x^4 is not zero",
                sign_in_range(leading_coefficient(), "!=", where),
            )
        ),
    )


def exact_rate(study: Study, _: Range, *, which: str, equations: Reference) -> vo.Verdict:
    """One equation is the rate of A n + k mu cos u."""
    gaps = residuals(equations, study)
    order = {"first": 0, "second": 1, "third": 2, "last": len(gaps) - 1}
    whole = A * n + k * level().mu * sp.cos(u)
    rate = study.motion.derivative(whole)
    gap = study.motion.restrict(gaps[one_of(which, order)])
    return equals(
        [(gap, rate)], f"equation '{which}' of ({equations.label}) and d/dt(A n + k mu x)"
    )


def never_changes(
    study: Study, _: Range, *, definition: Quoted, sort: str, centre: tuple[str, ...]
) -> vo.Verdict:
    """C_5 and x_0 along the motion, by the state."""
    given = level().integrals
    left, right = (part.xreplace(given) for part in both_sides(definition, study))
    other = sp.sympify(value(centre[0], study)).xreplace(given)
    rates = [level().rate(e) for e in (left, other)]
    return all_of(
        equals([(left, right)], "both sides by the state"),
        denial(constant(sort), equals(((rate, 0) for rate in rates), "their rates")),
    )


def elimination(
    study: Study, _: Range, *, wanted: tuple[str, ...], gone: tuple[str, ...]
) -> vo.Verdict:
    """One velocity is taken out of the length of the momentum by the energy; what remains is linear."""
    own, square = level(), sp.Symbol("square")
    symbols = {"s": s, r"\tau": tau, "n": n}
    left, out = one_of(wanted[0], symbols), one_of(gone[0], symbols)
    energy = sp.expand(own.integrals[h] - h).subs(out**2, square)
    found = sp.solve(energy, square)[0]
    area = sp.expand(sp.expand(own.integrals[GAMMA] ** 2 - GAMMA**2).subs(out**2, found))
    curved = vo.prove_equal(sp.diff(area, left, 2), 0)
    if not vo.prove_equal(sp.diff(area, out), 0).proved:
        return vo.Verdict("refuted", f"{gone[0]} stays there: its first power is in the momentum")
    if vo.prove_equal(sp.diff(area, left), 0).proved:
        return vo.Verdict("refuted", f"{wanted[0]} is no longer there")
    return chain_of((f"what is left is linear in {wanted[0]}", curved))


def from_energy(study: Study, _: Range, *, integral: Reference) -> vo.Verdict:
    """It gives tau^2 by s, n and the energy alone."""
    (gap,) = residuals(integral, study)
    square = sp.Symbol("square")
    held = sp.expand(gap).subs(tau**2, square)
    slope = sp.diff(held, square)
    movable = {str(w) for w in (s, n, h, u, GAMMA, tau) if sp.diff(held, w) != 0}
    by_state = level().integrals
    return all_of(
        agreement(movable, {"s", "n", "h"}, "what it holds beside tau^2"),
        denial(False, vo.prove_equal(slope, 0)),
        equals([(gap.xreplace(by_state), 0)], f"({integral.label}) by the state"),
    )


def product_with(
    study: Study, _: Range, *, factor: Quoted, first: Reference, second: Reference
) -> vo.Verdict:
    """tau^2 from the energy, times a factor, with n and s sin u from two formulas, is X."""
    own, product = level(), sp.Symbol("product")
    energy = 2 * (own.integrals[h] - h)
    speed = sp.solve(sp.expand(energy).subs(tau**2, product), product)[0]
    by_axis = sp.solve(residuals(first, study)[0], n)
    by_area = sp.solve(residuals(second, study)[0], s)
    if len(by_axis) != 1 or len(by_area) != 1:
        return vo.Verdict("refuted", f"({first.label}), ({second.label}) do not give n and s")
    by = sp.sympify(_one(factor, study)) * speed
    left = by.xreplace({n: by_axis[0], s: by_area[0]})
    right = own.mu**2 * own.X.subs(x, sp.cos(u)) / own.pace**2
    found = [(e.xreplace(own.integrals)) for e in (left, right)]
    return equals([tuple(found)], "tau^2 times the factor, and X")


def _one(formula: Quoted, study: Study) -> Any:
    return value(formula, study)


def substitution(
    study: Study,
    _: Range,
    *,
    what: tuple[str, ...],
    which: int,
    source: Reference,
    into: Reference,
    result: Reference,
) -> vo.Verdict:
    """With tau by the rate of u the formula is the equation for x, in the unit of time of X."""
    own, symbol = level(), value(what[0], study)
    gaps = residuals(source, study)
    if not 1 <= which <= len(gaps):
        return vo.Verdict("refuted", f"({source.label}) has {len(gaps)} equations")
    found = sp.solve(gaps[which - 1], symbol)
    if len(found) != 1:
        return vo.Verdict(
            "refuted", f"equation {which} of ({source.label}) does not give {what[0]}"
        )
    (gap,) = residuals(into, study)
    b2 = own.pace * k
    made = sp.expand(gap.xreplace({symbol: found[0]}) / (own.mu * k) ** 2)
    (wanted,) = residuals(result, study)
    rate = sp.Symbol("rate")
    turned = {vo.velocity(u): rate}
    scaled = wanted.xreplace({vo.velocity(u): rate * b2 / k})
    return equals([(made.xreplace(turned), scaled)], f"({result.label}) in the unit of time b_2/k")


def by_x(
    study: Study, _: Range, *, velocities: tuple[str, ...], angles: tuple[str, ...]
) -> vo.Verdict:
    """On a level of the integrals these are algebraic in x."""
    state = level().state
    known = {w for w in (s, tau, n) if w in state}
    known |= {w for w in (theta, u1) if any(sp.sympify(key).has(w) for key in state)}
    named = {value(name, study) for name in (*velocities, *angles)}
    return agreement({str(w) for w in named}, {str(w) for w in known}, "algebraic in x")


def further(study: Study, _: Range, *, count: int) -> vo.Verdict:
    """The angles of which only the rates are functions of x."""
    state = level().state
    left = [w for w in (v, v1, theta, u1) if not any(sp.sympify(key).has(w) for key in state)]
    return agreement(
        count, len(left), f"angles that are integrals in x: {', '.join(map(str, left))}"
    )


def polynomials(study: Study, where: Range, *, names: tuple[str, ...], degree: int) -> vo.Verdict:
    """The degrees of the polynomials in the rates of v and v_1."""
    own = level()
    degrees = {int(sp.Poly(getattr(own, one_of(name, POLYNOMIALS)), x).degree()) for name in names}
    return all_of(agreement({degree}, degrees, "degrees"), lambda: quadratic(study, where))


def in_products(
    study: Study,
    where: Range,
    *,
    name: tuple[str, ...],
    degree: int,
    lead: tuple[str, ...],
    sign: str,
    sort: str,
) -> vo.Verdict:
    """psi, and the coefficient before the product of the linear factors."""
    own = level()
    mine = int(sp.Poly(getattr(own, one_of(name[0], POLYNOMIALS)), x).degree())
    coefficient = one_of(lead[0], {"a_0": leading_coefficient()})
    return all_of(
        agreement(degree, mine, f"the degree of ${name[0]}$"),
        agreement(
            constant(sort), not coefficient.free_symbols & {s, tau, n}, "whether it is constant"
        ),
        chain_of((f"a_0 {sign} 0", sign_in_range(coefficient, sign, where))),
    )


SENTENCES = sentences(__file__, globals())
