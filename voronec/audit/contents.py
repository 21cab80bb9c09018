"""What stands in a formula under a dictionary: accelerations, velocities, a single name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import sympy as sp

from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.audit.comparisons import value_of
from voronec.audit.latex.nodes import (
    Call,
    Chain,
    Derivative,
    Differential,
    Dot,
    Name,
    Node,
    Number,
    Partial,
    Power,
    Product,
    Quotient,
    Sum,
    walk,
)
from voronec.audit.meaning import SENSELESS, evaluate
from voronec.audit.structure import names_constant
from voronec.audit.study import Study


def value_or_none(work: Callable[..., Any], *arguments: Any) -> Any:
    """What comes out; None for what has no value."""
    try:
        return work(*arguments)
    except SENSELESS:
        return None


def values_of(parts: Sequence[Node], study: Study) -> list[Any]:
    """The values of the parts of a formula on the constraints."""
    return [value_of(part, study, {}) for part in parts]


def has_accelerations(chain: Chain, study: Study) -> bool:
    """Whether rates of velocities stand in a formula."""
    dots = {*study.motion.accelerations}
    for node in walk(chain):
        if isinstance(node, (Dot, Derivative, Differential)):
            value = value_or_none(evaluate, node, study)
            if getattr(node, "order", 1) > 1 or getattr(value, "free_symbols", set()) & dots:
                return True
    return False


def moves(part: Node, study: Study) -> bool:
    """Whether a part holds a rate, a velocity, or what is made of these."""
    still = {*study.context.coordinates}
    moving = {s for s in (*study.motion.rates, *study.motion.constrained) if s not in still}
    value = value_or_none(evaluate, part, study)
    dotted = any(isinstance(node, (Dot, Derivative, Differential)) for node in walk(part))
    return dotted or bool(getattr(value, "free_symbols", set()) & moving)


def is_slope_of_rate(node: Node, study: Study) -> bool:
    """Whether a node is a partial derivative of what holds accelerations."""
    value = value_or_none(evaluate, node.body, study) if isinstance(node, Partial) else None
    return bool(getattr(value, "free_symbols", set()) & study.motion.accelerations.keys())


def lone_name(part: Node) -> Name | None:
    """The single name of a part that holds numbers besides, as ``2h``, ``c^2`` and ``M(q)``."""
    if isinstance(part, Name):
        return None if names_constant(part) else part
    if isinstance(part, Call) and isinstance(part.function, Name):
        return part.function
    if isinstance(part, Sum) and len(part.terms) == 1:
        return lone_name(part.terms[0][1])
    if isinstance(part, Power) and isinstance(part.exponent, Number):
        return lone_name(part.base)
    if isinstance(part, Quotient) and isinstance(part.bottom, Number):
        return lone_name(part.top)
    if isinstance(part, Product):
        rest = [f for f in part.factors if not isinstance(f, Number)]
        return lone_name(rest[0]) if len(rest) == 1 else None
    return None


def solve_for(part: Node, value: Node) -> tuple[Name | None, Node]:
    """The name of a part that is equal to a value, and what it is then; a power stays unsolved."""
    if isinstance(part, Name):
        return part, value
    if isinstance(part, Call):
        return part.function, value
    if isinstance(part, Sum) and len(part.terms) == 1:
        return solve_for(part.terms[0][1], Sum(((-1, value),)))
    if isinstance(part, Quotient):
        return solve_for(part.top, Product((part.bottom, value)))
    if isinstance(part, Product):
        numbers = tuple(f for f in part.factors if isinstance(f, Number))
        rest = next(f for f in part.factors if not isinstance(f, Number))
        return solve_for(rest, Quotient(value, Product(numbers)))
    return None, value


def constant_in(parts: Sequence[Node], letter: str, study: Study) -> tuple[Any, Verdict | None]:
    """What a letter has to be where two sides are linear in it, and whether that is a constant;
    no verdict where it may be something else."""
    symbol = sp.Dummy(letter)
    study = replace(study, names={**study.names, letter: symbol}, ranges=())
    try:
        left, right = (study.motion.along(value) for value in values_of(parts, study))
        gap = sp.expand(left - right)
        slope = sp.diff(gap, symbol)
        if not is_linear(gap, [symbol]) or slope.free_symbols & {*study.motion.rates}:
            return None, None
        value = -gap.xreplace({symbol: sp.S.Zero}) / slope
        return value, prove_equal(study.motion.along(study.motion.derivative(value)), 0)
    except SENSELESS:
        return None, None


def is_linear(gap: Any, symbols: Sequence[Any]) -> bool:
    """Whether an expression is linear in some symbols together."""
    slopes = [sp.diff(gap, s) for s in symbols]
    return not any(slope.has(*symbols) for slope in slopes) and not prove_equal(slopes[0], 0).proved
