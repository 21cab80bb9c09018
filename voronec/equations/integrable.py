"""The combinations of constraints that integrate, and the functions that they hold constant.

    I_0 = span(constraints),   I_(k+1) = {w in I_k : dw = 0 mod I_k}          the derived flag

It ends with the one-forms that annihilate the involutive closure of the distribution, whatever
basis the constraints are written in; they have integrals by the theorem of Frobenius.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import combinations, product
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.elimination import null_vectors
from voronec.algebra.matrices import change_entries, dot
from voronec.algebra.normal import shortest, without_denominators
from voronec.algebra.rank import generic_rows
from voronec.algebra.shape import operations
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import all_vanish, decide_zero
from voronec.equations.connection import EhresmannConnection
from voronec.equations.definition import Definition
from voronec.equations.distribution import FieldSpace
from voronec.errors import EngineLimit

Rows = list[list[Any]]
Defects = Callable[[Rows, Rows], Rows]
"""Of rows and the fields that they annihilate: what vanishes, an entry for each row."""
LONG = 40
"""Integrands of more operations are not tried: SymPy takes seconds for each, in vain mostly."""


def integrate(
    definition: Definition, connection: EhresmannConnection, most: int
) -> tuple[list[Any], list[Any]]:
    """What integrates of the constraints: a basis of the one-forms that annihilate the closure, the
    differentials of relations left out, each as a combination of the velocities that vanishes; and
    functions held constant, whose differentials span the first of the forms.

    That the forms annihilate it is proved, and that there are no others; ``most`` is an upper bound
    for their number.  Raises ``EngineLimit`` where they are beyond the exact algebra.
    """
    relations, space = definition.relations, FieldSpace(connection, True)
    variables = (*definition.coordinates, definition.time)
    bound, given = (
        [[*row, offset] for row, offset in zip(f.matrix, f.offset, strict=True)]
        for f in (definition.differentiated, definition.constraints)
    )
    plain = definition.group is None  # forms over the fields of a group have no potentials

    def slopes_of(rows: Rows, _: Rows) -> Rows:
        return [[e.diff(q) for e in c] for q in variables for c in zip(*rows, strict=True)]

    def brackets(rows: Rows, fields: Rows) -> Rows:
        vectors = [space.bracket(tuple(x), tuple(y)) for x, y in combinations(fields, 2)]
        return [[dot(w, b) for w in rows] for b in vectors]

    closed = [row for row in given if plain and most and _is_closed(row, variables, relations)]
    forms: Rows = []
    columns: list[int] = []
    for defects in (slopes_of, brackets) if plain else (brackets,):
        if len(_enlargement(bound, closed, relations)) < most:
            forms, columns = _flag([*given, *bound], definition.base, defects, relations)
            closed += [without_denominators(row, relations) for row in forms]
    closed = _enlargement(bound, closed, relations)
    functions: list[Any] = []
    slopes = bound
    for f in _functions(closed, forms, columns, variables, relations) if plain else ():
        slope = [f.diff(x) for x in variables]
        if _enlargement(slopes, [slope], relations):
            functions.append(f)
            slopes = [*slopes, slope]
    last = _enlargement(slopes, closed, relations)
    ordered = [*(row for row in closed if row not in last), *last]
    return [dot(row, (*definition.dots, se.Integer(1))) for row in ordered], functions


def _flag(
    rows: Rows, base: int, defects: Defects, relations: Sequence[Any]
) -> tuple[Rows, list[int]]:
    """The last of the modules I_(k+1) = {w in I_k : every defect of w vanishes}, of which rows span
    the first, as reduced rows, the same for every basis; and the columns of their units.

    What is left out on the way has a defect, by pivots proved not to vanish; what stays has none,
    in normal form.
    """
    units: list[int] = []
    while rows:
        rows, units = _echelon_form(rows, base, relations)
        fields = null_vectors(rows, units, relations)
        shortened = _shortest(defects(rows, fields), relations)
        kept = _enlargement([], shortened, relations)
        if not kept:
            if all_vanish([e for row in shortened for e in row], relations):
                break
            raise EngineLimit("which combinations of the constraints integrate is undecided")
        pivots = generic_rows([list(column) for column in zip(*kept, strict=True)], relations)
        factors = null_vectors(kept, pivots, relations)
        rows = [[dot(m, column) for column in zip(*rows, strict=True)] for m in factors]
    return rows, units


def _echelon_form(rows: Rows, base: int, relations: Sequence[Any]) -> tuple[Rows, list[int]]:
    """Rows that span the same, with units in the first columns that can have them, those of the
    fibre before those of the base and the time; in normal form after each step, since what cancels
    would grow beyond use."""
    time = len(rows[0]) - 1 if rows else base
    order = [*range(base, time), *range(base), time]
    units = [order[k] for k in generic_rows([[r[j] for r in rows] for j in order], relations)]
    done: Rows = []
    rows = _shortest(rows, relations)
    for u in units:
        able = [row for row in rows if generic_rows([[row[u]]], relations)]
        if not able:
            raise EngineLimit("no pivot of the constraints is proved not to vanish")
        pivot = min(able, key=lambda row: operations([row[u]]))
        head = [e / pivot[u] for e in pivot]
        left = [*done, *(row for row in rows if row is not pivot)]
        turned = [[a - row[u] * b for a, b in zip(row, head, strict=True)] for row in left]
        head, *turned = _shortest([head, *turned], relations)
        done, rows = [*turned[: len(done)], head], turned[len(done) :]
    return done, units


def _enlargement(known: Rows, rows: Rows, relations: Sequence[Any]) -> Rows:
    """The rows that, one after the other, enlarge the span of what is known."""
    kept = generic_rows([*known, *rows], relations)
    return [rows[i - len(known)] for i in kept if i >= len(known)]


def _shortest(rows: Rows, relations: Sequence[Any]) -> Rows:
    return change_entries(partial(shortest, relations=relations), rows)


def _is_closed(row: list[Any], variables: Sequence[Any], relations: Sequence[Any]) -> bool:
    pairs = combinations(zip(row, variables, strict=True), 2)
    return all(decide_zero(a.diff(y) - b.diff(x), relations).proved for (a, x), (b, y) in pairs)


def _functions(
    rows: Rows, forms: Rows, units: list[int], variables: Sequence[Any], relations: Sequence[Any]
) -> Iterator[Any]:
    """Functions whose differentials are among rows, or combinations of forms with units: where
    dw = A ^ w with commuting A = dP, the forms exp(P) w are closed."""
    import networkx as nx

    for row in rows:
        yield from _potential(row, variables, relations)
    size = range(len(forms))
    slopes = {(i, k): [e.diff(variables[units[k]]) for e in forms[i]] for i in size for k in size}
    linked = nx.Graph([pair for pair, row in slopes.items() if any(e != 0 for e in row)])
    linked.add_nodes_from(size)
    for block in map(sorted, nx.connected_components(linked)):
        cells = product(block, repeat=2)
        parts = [p for pair in cells for p in _potential(slopes[pair], variables, relations)]
        if len(parts) == len(block) ** 2:
            power = sp.Matrix(len(block), len(block), [*map(as_expression, parts)])
            columns = [*zip(*(forms[i] for i in block), strict=True)]
            for factors in _exponential(power):
                row = [dot(factors, column) for column in columns]
                yield from _potential(row, variables, relations)


def _potential(row: list[Any], variables: Sequence[Any], relations: Sequence[Any]) -> Iterator[Any]:
    """The function that has a row for its slopes, if it is found: one along each coordinate."""
    if not _is_closed(row, variables, relations):
        return
    potential = se.Integer(0)
    for e, x in zip(row, variables, strict=True):
        (rest,) = shortest([e - potential.diff(x)], relations)
        potential += _primitive(rest, x)
    pairs = zip(row, variables, strict=True)
    if not potential.has(se.nan) and all(
        decide_zero(e - potential.diff(x), relations).proved for e, x in pairs
    ):
        yield potential


def _primitive(f: Any, x: Any) -> Any:
    """An integral of f dx; nan where SymPy has none, or would take long."""
    from sympy.integrals.manualintegrate import manualintegrate

    f, names = _with_positive_names(f, x)
    f = sp.expand(f)
    if sp.count_ops(f) > LONG:
        return se.nan
    integral = manualintegrate(f, as_expression(x)).xreplace(names)
    return se.nan if integral.has(sp.Integral, sp.Piecewise) else se.sympify(integral)


def _exponential(power: sp.Matrix) -> Iterable[list[Any]]:
    """The rows of exp(P), with real sines and cosines."""
    power, names = _with_positive_names(power)
    for row in power.exp().xreplace(names).tolist():
        yield [se.sympify(sp.expand(e.rewrite(sp.cos)) if e.has(sp.I) else e) for e in row]


def _with_positive_names(f: Any, *but: Any) -> tuple[Any, dict[Any, Any]]:
    """In SymPy, with symbols taken for positive, so that it asks for no cases; and these again."""
    f = as_expression(f)
    names = {s: sp.Dummy(positive=True) for s in f.free_symbols - {*map(as_expression, but)}}
    return f.xreplace(names), {d: s for s, d in names.items()}
