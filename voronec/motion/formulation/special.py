"""What need not be integrated: constants, what stays at zero, what a first integral tells."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

import flint
import symengine as se

from voronec.algebra.graphs import nodes
from voronec.algebra.normal import Budget, canonical, canonical_for_numbers
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.roots import known_sign
from voronec.algebra.shape import operations
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import all_vanish
from voronec.errors import EngineLimit
from voronec.motion.formulation.formulation import (
    Formulation,
    blocks,
    is_finite,
    restrict,
    with_positive_denominators,
)

STEADY = {"sin", "cos", "exp", "sinh", "cosh", "tanh"}
"""Functions that are continuous wherever they are defined; a tangent's poles, for one, are not."""

Steep = Callable[[Any, tuple[Any, ...]], bool]
"""Whether a slope of an integral is steep enough beside the others, at the start."""


def without_parameters(formulation: Formulation, zero: Mapping[Any, Any]) -> list[Formulation]:
    """The formulation with parameters that are zero taken out, as it then stands and in normal
    forms; as it is where that makes no sense."""
    reduced = formulation.substitute(zero)
    if not _finite(reduced):
        return [formulation]
    plain = replace(
        reduced,
        rates=tuple(with_positive_denominators(e, formulation.relations) for e in reduced.rates),
    )
    tidied = _tidy(reduced)
    return [plain] if tidied is reduced else [plain, tidied]


def at_zero(formulation: Formulation, zeros: Collection[Any]) -> list[Any]:
    """The largest set of variables, all zero at the start, that stay at zero for ever.

    On it every rate vanishes identically: an invariant subspace, proved.  What a sign or a floor
    depends on is none of them: where it is zero the rate is not that of the motions nearby; nor is
    what a root makes so steep that it may leave.
    """
    chosen = [x for x in formulation.variables if x in zeros]
    steps = _steps(formulation, chosen)
    chosen = [x for x in chosen if x not in steps]
    while chosen:
        plane = formulation.substitute(dict.fromkeys(chosen, se.Integer(0)))
        if not _finite(plane):
            return []
        stay = [x for x in chosen if _rests(plane, x, chosen)]
        if len(stay) == len(chosen):
            return chosen
        chosen = stay
    return []


def _steps(formulation: Formulation, among: list[Any]) -> set[Any]:
    """What signs and floors in the rates depend on, and roots of sizes that vanish."""
    exprs = (
        [e for _, e in formulation.stages] + [*formulation.rates, *formulation.force]
        if among
        else []
    )
    zero = dict.fromkeys(among, se.Integer(0))

    def is_abrupt(node: Any) -> bool:
        is_root = isinstance(node, se.Pow)
        return isinstance(node, se.sign | se.floor) or (is_root and _is_steep_root(node, zero))

    met = filter(is_abrupt, nodes(map(se.sympify, exprs)))
    return set().union(*(n.free_symbols for n in met))


def _is_steep_root(base: Any, zero: Mapping[Any, Any]) -> bool:
    """Whether a power is |h|^e, of infinite slope where h vanishes."""
    exponent, is_size = se.Integer(1), False
    while isinstance(base, se.Abs) or (isinstance(base, se.Pow) and base.args[1].is_Number):
        power = base.args[1] if isinstance(base, se.Pow) else se.Integer(1)
        is_size = is_size or isinstance(base, se.Abs) or power == 2
        base, exponent = base.args[0], exponent * power
    if not 0 < exponent < 1 or base.xreplace(zero) != 0:
        return False
    return is_size or bool(2 * exponent < 1 and known_sign(base) > 0)


def _rests(formulation: Formulation, x: Any, chosen: list[Any]) -> bool:
    """Whether the rate of a variable vanishes where all the chosen ones do."""
    if x in formulation.positions:
        return vanish([formulation.rates[formulation.positions.index(x)]], formulation)
    i = formulation.velocities.index(x)
    others = [j for j, v in enumerate(formulation.velocities) if v not in chosen]
    return vanish([formulation.force[i], *(formulation.mass[i][j] for j in others)], formulation)


def vanish(exprs: list[Any], formulation: Formulation) -> bool:
    """Whether expressions are proved to vanish in the formulation, its stages opened."""
    stages = dict(formulation.stages)
    opened = []
    for expr in exprs:
        while expr.free_symbols & stages.keys():
            expr = expr.xreplace(stages)
        opened.append(expr)
    try:
        return all_vanish(opened, formulation.relations)
    except EngineLimit:
        return False


def constants(formulation: Formulation) -> list[Any]:
    """Variables whose rates vanish identically."""
    alone = [block[0] for block in blocks(formulation) if len(block) == 1]
    fixed = [
        q for q, rate in zip(formulation.positions, formulation.rates, strict=True) if rate == 0
    ]
    return fixed + [formulation.velocities[i] for i in alone if formulation.force[i] == 0]


def level_of(integral: str) -> Any:
    """The symbol for the constant value of an integral that stands in for an equation."""
    return se.Symbol(f"level of {integral}")


def by_integrals(
    formulation: Formulation, proved: Callable[[str], bool], steep: Steep
) -> tuple[Formulation, dict[Any, tuple[str, Any, Any]]]:
    """Variables that first integrals give, instead of equations.

    An integral is used for a variable x in which it is linear with a constant coefficient: then
    x = (level - rest) / coefficient everywhere.  Maps x to the integral's name, the symbol of its
    level and its expression.
    """
    given: dict[Any, tuple[str, Any, Any]] = {}
    for name, integral in formulation.integrals.items():
        if given.keys() & integral.free_symbols:
            continue
        x = _solvable(formulation, integral, steep)
        if x is None or not proved(name):
            continue
        slope = integral.diff(x)
        symbol = level_of(name)
        rest = integral.subs({x: 0})
        given[x] = (name, symbol, integral)
        left = [y for y in formulation.variables if y != x]
        stages = ((x, (symbol - rest) / slope), *formulation.stages)
        formulation = replace(
            formulation, stages=stages, parameters=(*formulation.parameters, symbol)
        )
        formulation = restrict(formulation, left)
    return formulation, given


def _solvable(formulation: Formulation, integral: Any, steep: Steep) -> Any | None:
    """The variable that an integral gives well, if there is one."""
    inside = integral.free_symbols
    if is_many_valued(integral):
        return None
    alone = {formulation.velocities[block[0]] for block in blocks(formulation) if len(block) == 1}
    if not inside <= {*formulation.variables, *formulation.parameters, formulation.time}:
        return None
    for x in reversed(formulation.variables):
        if x not in inside or not (x in alone or x in formulation.positions):
            continue
        slope, moving = integral.diff(x), {*formulation.variables, formulation.time}
        if _differs(slope, moving) or (slope := _short(slope)).free_symbols & moving:
            continue
        others = (integral.diff(y) for y in formulation.variables if y != x and y in inside)
        if steep(slope, tuple(others)):
            return x
    return None


def _differs(expr: Any, symbols: Collection[Any]) -> bool:
    """Whether an expression has two values for different symbols, as two points show: its normal
    form tells so, too, but may be long."""
    tape = Tape([expr])
    for point, (value,) in sample_evaluable(tape, count=1):
        moved = {s: x + flint.fmpq(1, 7) if s in symbols else x for s, x in point.items()}
        return not tape.arb(moved, GENERIC)[0].overlaps(value)
    return False


def _short(expr: Any) -> Any:
    """The normal form, or, where that is too large, the expression as it is."""
    try:
        return canonical([expr])[0]
    except EngineLimit:
        return expr


def is_many_valued(expr: Any) -> bool:
    """Whether an expression may hold a function with branches or steps, on which a motion may
    change over: its rate vanishes, and yet it is not constant along the motion."""
    composed = (n for n in nodes([expr]) if n.args and not isinstance(n, se.Add | se.Mul | se.Pow))
    return any(type(n).__name__ not in STEADY for n in composed)


def _finite(formulation: Formulation) -> bool:
    parts = [*formulation.rates, *formulation.force, *(e for row in formulation.mass for e in row)]
    parts += [e for _, e in formulation.stages] + [*formulation.outputs.values()]
    return all(map(is_finite, map(se.sympify, parts)))


def _tidy(formulation: Formulation) -> Formulation:
    """Normal forms again, after something was put in, where they have no more terms than it has
    operations; rates without denominators that cancel."""
    if not formulation.exact or formulation.stages:
        return formulation
    flat = [*formulation.rates, *formulation.force, *(e for row in formulation.mass for e in row)]
    try:
        flat = canonical_for_numbers(flat, formulation.form, Budget(terms=operations(flat)))
    except EngineLimit:
        return formulation
    n, k = len(formulation.velocities), len(formulation.rates)
    rows = flat[k + n :]
    return replace(
        formulation,
        rates=tuple(with_positive_denominators(e, formulation.relations) for e in flat[:k]),
        force=tuple(flat[k : k + n]),
        mass=tuple(tuple(rows[i * n : (i + 1) * n]) for i in range(n)),
    )
