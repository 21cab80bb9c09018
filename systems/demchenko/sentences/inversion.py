"""Elliptic functions and the inversion of elliptic integrals: what the text says beside displays."""

from __future__ import annotations

from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Range, Reference, Sentence, Study, one_of
from voronec.audit.structure import mentions

from ..dictionary.inversion import by_addition, curve, general, y
from ..dictionary.weierstrass import abel
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


OF_WP = r"\text{(eq:addition1) and (eq:addition2), with $2y$ in them; (eq:elliptic1) and (eq:elliptic2) do not speak of $\wp$}"

ADDITION = (
    Sentence(
        "the Abel theorem for elliptic functions, stating that the sum of @first:word{zeros} of an "
        "elliptic functions @relation:relation{equals} the sum of @second:word{poles} (modulo the "
        "lattice which defines the underlying elliptic curve).",
        equal_sums,
        cited="for the functions wp' - a wp - b alone; for all others it is quoted",
    ),
)

INVERSION = (
    Sentence(
        "which is based on simultaneous parameterizations of the @power:word{square} of the "
        "polynomial $X$ of degree @degree:number{four} in $x$ and the @variable:word{variable} $x$ "
        "in terms of elliptic functions of the @argument:word{same} argument $u$.",
        both_by_u,
    ),
    Sentence(
        r"Using the Addition Theorem \ref{th:Weierstrass.addition} and formulae "
        r"@first:reference{\eqref{eq:elliptic1}} and @second:reference{\eqref{eq:elliptic2}}, one "
        "gets",
        from_the_theorem,
        derived=lambda _: OF_WP,
    ),
    Sentence(
        "Let us introduce the polynomial $Y$ of degree @degree:number{four} in "
        "@variable:names{$y$} as:",
        in_y,
    ),
    Sentence(
        "One can apply the above considerations to an arbitrary polynomial $X$ of degree "
        "@degree:number{four} in @variable:names{$x$}:",
        any_quartic,
    ),
    Sentence(
        "To eliminate the @which:number{second} term with @power:names{$x^3$} one substitutes the "
        "variable",
        shift,
    ),
)
