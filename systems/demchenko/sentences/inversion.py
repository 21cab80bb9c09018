"""Elliptic functions and the inversion of elliptic integrals: what the text says beside displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Range, Reference, Study, one_of
from voronec.audit.structure import mentions

from ..dictionary.inversion import by_addition, curve, general, y
from ..dictionary.weierstrass import abel
from ..transcription import sentences
from .claims import agreement, all_of, denial, residuals


def equal_sums(study: Study, where: Range, *, first: str, relation: str, second: str) -> vo.Verdict:
    """Abel's theorem for one function; for all others it is quoted."""
    sums = {"zeros", "poles"}
    return all_of(
        agreement({first, second}, sums, "of what the sums are taken"),
        denial(one_of(relation, {"=": True, "!=": False}), abel(study, where)),
    )


def both_by_u(
    _: Study, __: Range, *, power: str, degree: int, variable: str, argument: str
) -> vo.Verdict:
    """X is a_0 y'^2, so that its root and its powers are rational in y and y', as x is."""
    powers = {"square": sp.Integer(2), "square root": sp.Rational(1, 2), "cube": sp.Integer(3)}
    exponent = one_of(power, powers) * 2
    one_of(variable, {"variable": True})
    return all_of(
        agreement(degree, int(sp.Poly(curve().polynomial, y).degree()), "the degree"),
        agreement(bool(exponent.is_integer), True, "whether that power is rational in y and y'"),
        agreement(
            one_of(argument, {"same": True, "different": False}), True, "one argument for both"
        ),
    )


def from_the_theorem(
    study: Study, where: Range, *, first: Reference, second: Reference
) -> vo.Verdict:
    """Which formulas give the two relations: those that speak of Weierstrass' function."""
    silent = [r for r in (first, second) if not any(_speaks(tree) for tree in r.trees(study))]
    found = by_addition(study, where)
    if silent:
        labels = " and ".join(f"({r.label})" for r in silent)
        about = f"{labels} say nothing of Weierstrass' function; what gives the relations: "
        return vo.Verdict("refuted", about + found.method)
    relations = study.relations
    gaps = [gap for r in (first, second) for gap in residuals(r, study)]
    true = (vo.prove_equal(gap, 0, relations) for gap in gaps)
    steps = all_of(*true)
    different = agreement(len({first.label, second.label}), 2, "formulas")
    return all_of(different, steps, found)


def _speaks(tree: Any) -> bool:
    return any(name.startswith(r"\wp") for name in mentions(tree))


def in_y(study: Study, _: Range, *, degree: int, variable: tuple[str, ...]) -> vo.Verdict:
    """The degree of Y."""
    letter = one_of(variable[0], {"y": y})
    return agreement(degree, int(sp.Poly(curve().polynomial, letter).degree()), "the degree of Y")


def any_quartic(study: Study, _: Range, *, degree: int, variable: tuple[str, ...]) -> vo.Verdict:
    """Every polynomial X of that degree is a_0 Y(x - h) for some values at c."""
    letter = one_of(variable[0], {"x": sp.Symbol("x")})
    return agreement(degree, int(sp.Poly(general(letter), letter).degree()), "the degree of X")


def shift(study: Study, _: Range, *, which: int, power: tuple[str, ...]) -> vo.Verdict:
    """The term that a shift of the variable takes away: Y has none of that power."""
    coefficients = sp.Poly(curve().polynomial, y).all_coeffs()
    missing = [n for n, c in enumerate(coefficients, start=1) if c == 0]
    powers = [f"x^{len(coefficients) - n}" for n in missing]
    return all_of(
        agreement([which], missing, "terms that are missing"),
        agreement([power[0].replace("{", "").replace("}", "")], powers, "its power"),
    )


def latex_of_source(_: Study) -> str:
    """What it takes instead of what the print names."""
    return r"\text{(eq:addition1) and (eq:addition2), with $2y$ in them; (eq:elliptic1) and (eq:elliptic2) do not speak of $\wp$}"


TEXT = sentences(__file__, globals())
ADDITION, INVERSION = TEXT[:1], TEXT[1:]
