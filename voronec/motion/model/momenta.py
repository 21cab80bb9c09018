"""Momenta in the place of velocities.

With p = M(g) v the equations are p' = force + M' v.  For many bodies that is far shorter than
M v' = force once v is known from p: a rolling ball's is G' = G x omega.  So the rate is written as

    p_i' = a_i^jk p_j v_k + rest_i

[Theory, eq. (21)]
with numbers a_i^jk such that the rest holds no variable but v; the numbers are the solution of
linear equations, one for each monomial that has to go, and what they give is an identity of normal
forms: a proof.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import flint
import symengine as se

from voronec.algebra.matrices import dot
from voronec.algebra.normal import canonical
from voronec.algebra.ring import sparse_terms
from voronec.algebra.roots import ring_over
from voronec.equations.program import solve_mass
from voronec.equations.program.straight import fresh_names
from voronec.errors import EngineLimit
from voronec.motion.model.level import Level

__all__ = ["momenta_level"]


def momenta_level(level: Level) -> Level | None:
    """The same equations in momenta; None where their rates are no shorter so."""
    v, n = level.velocities, len(level.velocities)
    if not level.exact or level.stages or not n:
        return None
    if not any(level.mass[i][j] != 0 for i, j in product(range(n), repeat=2) if i != j):
        return None  # a diagonal mass gains nothing
    rate = dict(zip(level.positions, level.rates, strict=True))
    momenta = [dot(row, v) for row in level.mass]
    changes = [
        se.Add(f, p.diff(level.time), *[p.diff(q) * rate[q] for q in level.positions])
        for f, p in zip(level.force, momenta, strict=True)
    ]
    try:
        split = _split(changes, momenta, level)
    except EngineLimit:
        return None
    if split is None:
        return None
    names = _names(level, n)
    rates = [
        se.Add(rest, *[a * names[j] * v[k] for (j, k), a in numbers.items()])
        for numbers, rest in split
    ]
    return replace(
        level,
        name="momenta" if level.name == "coordinates" else f"{level.name} and momenta",
        velocities=tuple(names),
        mass=tuple(tuple(se.Integer(int(i == j)) for j in range(n)) for i in range(n)),
        force=tuple(rates),
        stages=_solution(level, names),
        inertia=level.mass,
        start={
            **{x: e for x, e in level.start.items() if x not in v},
            **{p: e.xreplace(dict(level.start)) for p, e in zip(names, momenta, strict=True)},
        },
    )


def _solution(level: Level, names: Sequence[Any]) -> tuple[tuple[Any, Any], ...]:
    """Stages that give the velocities from the momenta: the mass matrix solved."""
    assignments: list[tuple[Any, Any]] = []
    fresh = fresh_names([*level.variables, *level.parameters], "w_")

    def name(expr: Any) -> Any:
        if not expr.args:
            return expr
        assignments.append((next(fresh), expr))
        return assignments[-1][0]

    solution = solve_mass(
        level.mass, names, name, level.parameters, level.relations, level.positive
    )
    return (*assignments, *zip(level.velocities, solution, strict=True))


def _names(level: Level, n: int) -> list[Any]:
    """Symbols for the momenta that nothing else is called by."""
    taken = {str(s) for s in (*level.variables, *level.parameters, *level.start)}
    letter = next(x for x in ("G", "p", "G_") if not any(f"{x}{i + 1}" in taken for i in range(n)))
    return [se.Symbol(f"{letter}{i + 1}") for i in range(n)]


def _split(
    changes: Sequence[Any], momenta: Sequence[Any], level: Level
) -> list[tuple[dict[tuple[int, int], Any], Any]] | None:
    """For each rate: the numbers a^jk that are not zero, and the rest."""
    v = level.velocities
    pairs = [(j, k) for j in range(len(v)) for k in range(len(v))]
    products = [momenta[j] * v[k] for j, k in pairs]
    plain = canonical([*changes, *products], level.relations)
    ring = ring_over(plain, level.relations)
    elements = [ring.fraction(e) for e in plain]
    if any(e.den for e in elements[len(changes) :]):
        return None
    moving = [i for i, g in enumerate(ring.meaning) if g.free_symbols & set(level.positions)]
    columns = [_terms(e.num, moving) for e in elements[len(changes) :]]
    found: list[tuple[dict[tuple[int, int], Any], Any]] = []
    for element, change in zip(elements, changes, strict=False):
        if element.den:
            return None
        numbers = _solve(_terms(element.num, moving), columns)
        if numbers is None:
            return None
        chosen = {pair: a for pair, a in zip(pairs, numbers, strict=True) if a != 0}
        rest = change - se.Add(*[a * products[pairs.index(jk)] for jk, a in chosen.items()])
        found.append((chosen, canonical([rest], level.relations)[0]))
    return found


def _terms(poly: Any, moving: Sequence[int]) -> dict[Any, Any]:
    """The terms that hold a position."""
    held = set(moving)
    return {m: c for m, c in sparse_terms(poly).items() if any(i in held for i, _ in m)}


def _solve(right: dict[Any, Any], columns: Sequence[dict[Any, Any]]) -> list[Any] | None:
    """Numbers with which the columns sum up to the right side, as few as elimination finds."""
    rows = sorted({m for c in (*columns, right) for m in c})
    if not rows:
        return [se.Integer(0)] * len(columns)
    width = len(columns)
    zero = flint.fmpq(0)
    table = flint.fmpq_mat(
        len(rows), width + 1, [c.get(m, zero) for m in rows for c in (*columns, right)]
    )
    reduced, rank = table.rref()
    numbers = [se.Integer(0)] * width
    for i in range(rank):
        pivot = next(j for j in range(width + 1) if reduced[i, j] != 0)
        if pivot == width:
            return None
        value = reduced[i, width]
        numbers[pivot] = se.Integer(int(value.p)) / se.Integer(int(value.q))
    return numbers
