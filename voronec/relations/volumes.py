"""How a state map changes volumes, where states correspond one to one.

On the zero set of independent relations R the volume is the Leray form w with
dR_1 ... dR_k w = dx.  For vectors w_i that span the tangent space, w(w_1, ..., w_d) =
det(w_1, ..., w_d, n_1, ..., n_k) with any n_j such that dR_i(n_j) = delta_ij.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import symengine as se

from voronec.algebra.determinant import determinant
from voronec.algebra.elimination import solve_linear
from voronec.algebra.normal import canonical
from voronec.errors import EngineLimit
from voronec.relations.kinds import state_rank
from voronec.relations.statemap import StateMap

__all__ = ["corresponds", "volume_factor"]

Matrix = list[list[Any]]


def corresponds(statemap: StateMap) -> bool:
    """Whether states of source and target correspond one to one, near a generic one."""
    source, target = statemap.source, statemap.target
    try:
        return bool(source.dimension == target.dimension == state_rank(statemap))
    except EngineLimit:
        return False


def volume_factor(statemap: StateMap) -> Any:
    """det DPhi between the volumes of source and target, up to sign."""
    source, target = statemap.source, statemap.target
    relations = [statemap.scale(r) for r in source.independent_relations]
    pulled = [statemap.pull_back(r) for r in target.independent_relations]
    is_same = len(source.variables) == len(target.variables) and relations == pulled
    if statemap.is_identity and is_same:
        return se.Integer(1)
    tangents = _tangents(source.variables, relations)
    images = [statemap.state[x] for x in target.variables]
    moved = [
        [se.Add(*[f.diff(x) * e for x, e in zip(source.variables, w, strict=True)]) for f in images]
        for w in tangents
    ]
    above = [*moved, *([statemap.pull_back(e) for e in n] for n in _normals(target))]
    below = [*tangents, *([statemap.scale(e) for e in n] for n in _normals(source))]
    return _determinant(above, statemap.hypotheses) / _determinant(below, statemap.hypotheses)


def _tangents(variables: Sequence[Any], relations: Sequence[Any]) -> Matrix:
    """Vectors that span the tangent space: solutions of dR(w) = 0, some entries chosen free."""
    size = range(len(variables))
    unit = [[se.Integer(int(i == j)) for j in size] for i in size]
    if not relations:
        return unit
    gradient = [[r.diff(x) for x in variables] for r in relations]
    bound = _pivots(gradient, len(relations))
    free = [j for j in size if j not in bound]
    left = [[row[j] for j in bound] for row in gradient]
    right = [[-row[j] for j in free] for row in gradient]
    solved = solve_linear(left, right, relations).values
    rows = []
    for k, j in enumerate(free):
        row = list(unit[j])
        for position, values in zip(bound, solved, strict=True):
            row[position] = values[k]
        rows.append(row)
    return rows


def _pivots(gradient: Matrix, count: int) -> list[int]:
    """Columns in which the gradients are independent, found by elimination from the right."""
    last = list(reversed(range(len(gradient[0]))))
    chosen: list[int] = []
    for j in last:
        trial = [*chosen, j]
        columns = [[row[i] for i in trial] for row in gradient]
        if not solve_linear(columns, [[se.Integer(0)]] * len(columns)).free:
            chosen = trial
        if len(chosen) == count:
            break
    return sorted(chosen)


def _normals(field: Any) -> Matrix:
    """Vectors n_j with dR_i(n_j) = delta_ij: dR^T (dR dR^T)^-1."""
    if not field.relations:
        return []
    gradient = [[r.diff(x) for x in field.variables] for r in field.independent_relations]
    gram = [[_dot(p, q) for q in gradient] for p in gradient]
    unit = [[se.Integer(int(i == j)) for j in range(len(gram))] for i in range(len(gram))]
    inverse = solve_linear(gram, unit, field.hypotheses).values
    columns = zip(*inverse, strict=True)
    return [[_dot(column, across) for across in zip(*gradient, strict=True)] for column in columns]


def _dot(left: Sequence[Any], right: Sequence[Any]) -> Any:
    return se.Add(*[a * b for a, b in zip(left, right, strict=True)])


def _determinant(rows: Matrix, relations: Sequence[Any]) -> Any:
    flat = canonical([e for row in rows for e in row], relations)
    size = len(rows)
    return determinant([flat[i * size : (i + 1) * size] for i in range(size)])
