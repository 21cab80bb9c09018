"""Rates along the motion: first integrals, and equations that a system is said to satisfy."""

from __future__ import annotations

from typing import Any

import sympy as sp

from voronec.algebra.tape import is_atom
from voronec.analysis.decision import Decision, all_zero
from voronec.analysis.walls import across_walls
from voronec.claims import Equation, expressions_of
from voronec.vector_field import Motions

__all__ = ["decide_equation", "decide_integral"]


def decide_integral(motions: Motions, function: sp.Expr) -> Decision:
    """dF/dt = 0 along the motion."""
    field = motions.deciding([function])
    named = field.read_named(function)
    inner = _innermost(named, frozenset(field.parameters))
    found = all_zero([("", field.derivative(inner))], field.hypotheses)
    if not found.proved and inner != named:
        found = all_zero([("", field.derivative(named))], field.hypotheses)
    inside = [("", field.read_branches(function))]
    return Decision(across_walls(found, field, inside, constant=True), field.level)


def decide_equation(motions: Motions, equation: Equation) -> Decision:
    """dF/dt = G along the motion, entry by entry; the first entry that fails is named."""
    field = motions.deciding([*expressions_of(equation)])
    functions = [field.read_named(f) for f in equation.function]
    found = field.derivatives(functions)
    claimed = [field.read(g) for g in equation.rate]
    residuals = [a - b for a, b in zip(found, claimed, strict=True)]
    verdict = all_zero(_numbered(residuals), field.hypotheses)
    inside = _numbered([field.read_branches(f) for f in equation.function])
    return Decision(across_walls(verdict, field, inside), field.level)


def _innermost(function: Any, still: frozenset[Any]) -> Any:
    """G where a function is f(G): with G it is an integral, off the walls of f."""
    while True:
        moving = [a for a in function.args if not a.free_symbols <= still]
        if len(moving) != 1 or is_atom(function):
            return function
        (function,) = moving


def _numbered(residuals: list[Any]) -> list[tuple[str, Any]]:
    if len(residuals) == 1:
        return [("", residuals[0])]
    return [(f"entry {i + 1}", r) for i, r in enumerate(residuals)]
