"""The Jacobian of a straight-line program, by the chain rule along its assignments.

With c_k = f_k(x, c_1, ..., c_(k-1)) the slopes are

    dc_k/dx_j = df_k/dx_j + sum_(i<k) df_k/dc_i dc_i/dx_j

(forward mode [GriewankWalther2008, ch. 3]), and only those that are not zero are written down.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from typing import Any

import symengine as se

from voronec.algebra import numeric_functions as numeric
from voronec.algebra.graphs import nodes
from voronec.equations.program.straight import Block, Program, fresh_names, share_subexpressions
from voronec.errors import EngineLimit

_SLOPES: dict[str, Callable[..., tuple[Any, ...]]] = {
    numeric.SINC: lambda w: (-w * se.Function(numeric.SINC_SLOPE)(w),),
    numeric.EXPM1: lambda w: (se.exp(w),),
    numeric.LOG1P: lambda w: (1 / (1 + w),),
    numeric.HYPOT: lambda *sides: tuple(a / se.Function(numeric.HYPOT)(*sides) for a in sides),
    numeric.SIZE: lambda w: (se.sign(w),),
    "Abs": lambda w: (se.sign(w),),
    "sign": lambda w: (se.Integer(0),),
    "floor": lambda w: (se.Integer(0),),
}
"""The slopes of functions that programs alone know, in such functions, and of those with corners
and jumps; SymEngine differentiates the others."""


def jacobian_columns(program: Program) -> tuple[Any, ...]:
    """What the columns of the Jacobian belong to: the entries of the state, then the inputs."""
    return (*program.state, *program.inputs)


@lru_cache(maxsize=32)
def jacobian(program: Program) -> Block:
    """The derivatives of the rates of the state, row by row: of each rate by every entry of the
    state, then by every input.

    At corners of |w| and jumps they are those beside it.  ``EngineLimit`` names a function that
    nobody differentiates.
    """
    columns = jacobian_columns(program)
    assignments, rows = _rows(program.derivative, {x: {x: se.Integer(1)} for x in columns})
    entries = [row.get(x, se.Integer(0)) for row in rows for x in columns]
    known = [program.time, *columns, *program.parameters]
    return share_subexpressions(entries, fresh_names(known), assignments)


def joint_block(
    program: Program, block: Block, by: Sequence[Any]
) -> tuple[Block, tuple[tuple[int, int], ...]]:
    """The results of a block of a program, and behind them their slopes by symbols that are not
    zero, with all subexpressions shared; and of which result by which symbol each is the slope.

    ``EngineLimit`` names a function that nobody differentiates.
    """
    assignments, rows = _rows(block, {x: {x: se.Integer(1)} for x in by})
    slopes = {(i, j): row[x] for i, row in enumerate(rows) for j, x in enumerate(by) if x in row}
    known = [program.time, *program.state, *program.parameters, *program.inputs]
    results = [*block.results, *slopes.values()]
    return share_subexpressions(results, fresh_names(known), assignments), tuple(slopes)


def flow_derivative(program: Program, block: Block) -> Block:
    """How fast the results of a block change along the motion of a program, whose own assignments
    are those of the block.

    ``EngineLimit`` names a function that nobody differentiates.
    """
    rates = zip(program.state, program.derivative.results, strict=True)
    slopes = {x: {program.time: rate} for x, rate in rates}
    slopes[program.time] = {program.time: se.Integer(1)}
    assignments, rows = _rows(block, slopes)
    return Block(assignments, tuple(row.get(program.time, se.Integer(0)) for row in rows))


def _rows(
    block: Block, known: dict[Any, dict[Any, Any]]
) -> tuple[tuple[tuple[Any, Any], ...], list[dict[Any, Any]]]:
    """The slopes of a block's results by columns, row by row, where those of what it is given are
    ``known``; and its assignments, with those of slopes that are more than a symbol behind."""
    slopes, assignments = dict(known), list(block.assignments)
    for name, expr in block.assignments:
        slopes[name] = {}
        for x, slope in _chain_slopes(se.sympify(expr), slopes).items():
            if slope.args:
                assignments.append((se.Symbol(f"d {name} / d {x}"), slope))
                slope = assignments[-1][0]
            slopes[name][x] = slope
    return tuple(assignments), [_chain_slopes(se.sympify(e), slopes) for e in block.results]


def _chain_slopes(expr: Any, slopes: dict[Any, dict[Any, Any]]) -> dict[Any, Any]:
    """The slopes of an expression by the columns that it depends on."""
    if any(numeric.numeric_name(n) in (numeric.CHOICE, numeric.CASE) for n in nodes([expr])):
        return _gradient(expr, {s: slopes.get(s, {}) for s in expr.free_symbols})
    partials = _gradient(expr, {})
    return weighted_sum(
        [(partials[s], slopes[s]) for s in sorted(partials, key=str) if s in slopes]
    )


def weighted_sum(pairs: Iterable[tuple[Any, dict[Any, Any]]]) -> dict[Any, Any]:
    """The sum of rows {position: entry} with factors, without entries that are zero."""
    products: dict[Any, list[Any]] = {}
    for factor, row in pairs:
        for x, slope in row.items():
            products.setdefault(x, []).append(factor * slope)
    sums = {x: se.Add(*terms) for x, terms in products.items()}
    return {x: total for x, total in sums.items() if total != 0}


def _gradient(expr: Any, known: dict[Any, dict[Any, Any]]) -> dict[Any, Any]:
    """The partial derivatives of an expression by its symbols, or by that by which those of its
    symbols are ``known``."""
    if expr in known:
        return known[expr]
    if isinstance(expr, se.Symbol):
        return {expr: se.Integer(1)}
    if expr.args:
        if numeric.numeric_name(expr) in (numeric.CHOICE, numeric.CASE):
            known[expr] = _gradient_of_choice(expr, known)
        else:
            rows = [_gradient(a, known) for a in expr.args]
            moving = [(i, row) for i, row in enumerate(rows) if row]
            known[expr] = weighted_sum((_partial(expr, i), row) for i, row in moving)
    return known.get(expr, {})


def _gradient_of_choice(expr: Any, known: dict[Any, Any]) -> dict[Any, Any]:
    """That of a choice, which is a choice: the slope of a side that is not in force may be
    infinite.  Across the switching surface it is on it that of the side which has the value there,
    or between; along the switching surface it is that of the value there."""
    switch, up, *middle, down = expr.args
    rows = [_gradient(a, known) for a in expr.args[1:]]
    across = {x for symbol in switch.free_symbols for x in known[symbol]}
    gradient, zero = {}, se.Integer(0)
    for x in {x: None for row in rows for x in row}:
        above, *on, below = (row.get(x, zero) for row in rows)
        if x in across and on:
            on = [] if up == down else [above] * (middle == [up]) or [below] * (middle == [down])
        name = numeric.CASE if on else numeric.CHOICE
        same = all(slope == above for slope in (*on, below))
        gradient[x] = above if same else se.Function(name)(switch, above, *on, below)
    return gradient


def _partial(expr: Any, position: int) -> Any:
    """The derivative of a sum, product, power or function by one of its arguments."""
    name = numeric.numeric_name(expr) or type(expr).__name__
    if name in _SLOPES:
        return _SLOPES[name](*expr.args)[position]
    if isinstance(expr, se.Add):
        return se.Integer(1)
    letters = [se.Symbol(f"argument {i}") for i in range(len(expr.args))]
    slope = expr.func(*letters).diff(letters[position])
    if slope.atoms(se.Derivative, se.Subs):
        raise EngineLimit(f"the Jacobian: '{name}' is not differentiated; leave the Jacobian out")
    return slope.xreplace(dict(zip(letters, expr.args, strict=True)))
