"""Constraints are sufficient as well as necessary: how many independent conditions are printed.

A formula that is true where the constraints hold may say less than they do, or what another one has
said already.  With the constraints forgotten, the gradients of left minus right have to be
independent of each other and of those before, wherever the constraints hold.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from typing import Any

import sympy as sp

from voronec.algebra.normal import shorten
from voronec.algebra.signs import prove_inequality
from voronec.algebra.verdicts import Verdict
from voronec.audit.comparisons import accelerations
from voronec.audit.display import Check
from voronec.audit.formula import Formula
from voronec.audit.latex.nodes import Chain
from voronec.audit.meaning import evaluate
from voronec.audit.study import Study
from voronec.audit.transcript import Transcript, assignments

__all__ = ["independent_conditions"]


def independent_conditions(
    formula: Formula, chain: Chain, check: Check, study: Study, transcript: Transcript
) -> Verdict:
    """Whether a formula adds as many conditions as it should to those before it in its display."""
    before, rows = 0, _gradients(chain, study)
    for other in transcript.formulas():
        if other.display is not formula.display or other.position >= formula.position:
            continue
        number = other.display.check(other.position).constrains
        if number:
            rows = _gradients(other.tree(study.vocabulary), study) + rows
            before += number
    return _rank(rows, before + check.constrains, study)


def _gradients(chain: Chain, study: Study) -> list[dict[sp.Expr, sp.Expr]]:
    """By velocities, on the constraints: the derivatives of left minus right of every equation."""
    study, virtual = _free_variations(study)
    motion, found, dots = study.motion, [], accelerations(study)
    velocities = {x for x, rate in motion.rates.items() if rate in dots}
    velocities |= {*motion.constrained, *study.variations.values()}
    for where in assignments(chain, study):
        first, *rest = [evaluate(part, study, where) for part in chain.parts]
        for part in rest:
            gap = part if first == 0 else first if part == 0 else first - part
            for value in gap if isinstance(gap, sp.MatrixBase) else [gap]:
                symbols = value.free_symbols & velocities
                slopes = {x: motion.restrict(sp.diff(value, x).xreplace(virtual)) for x in symbols}
                found.append({x: e.xreplace(dict(study.given)) for x, e in slopes.items()})
    return found


def _free_variations(study: Study) -> tuple[Study, dict[sp.Expr, sp.Expr]]:
    """A study whose variations obey no constraint, and what the constraints make of them."""
    bound = {x: d for x, d in study.variations.items() if not isinstance(d, sp.Symbol)}
    free = {x: sp.Symbol(f"{{variation of {x}}}") for x in bound}
    virtual = {free[x]: d for x, d in bound.items()}
    return replace(study, variations={**study.variations, **free}), virtual


def _rank(rows: list[dict[sp.Expr, sp.Expr]], wanted: int, study: Study) -> Verdict:
    """Whether so many of some gradients are independent everywhere."""
    columns = sorted({x for row in rows for x, slope in row.items() if slope != 0}, key=str)
    said = f"{wanted} independent condition" + "s" * (wanted > 1)
    table = sp.Matrix([[row.get(x, 0) for x in columns] for row in rows])
    alive = _minors(table, wanted, study.relations)
    if not alive:
        return Verdict("refuted", f"with what stands before it there are not {said}")
    if any(_nowhere_zero(value, study) for value in alive) or _nowhere_zero(
        shorten([sp.Add(*(m**2 if len(rows) == wanted else m for m in alive))], study.relations)[0],
        study,
    ):
        return Verdict("proved", f"with what stands before it {said}")
    return Verdict("undecided", f"whether there are {said} everywhere is not decided")


def _minors(table: sp.Matrix, size: int, relations: tuple[Any, ...]) -> list[Any]:
    """Those of all rows that do not vanish, the shortest first; with more rows, for each choice of
    columns the sum of the squares: a principal minor of A^T A, whose entries are short where the
    rows are components of vectors."""
    if min(table.shape) < size:
        return []
    chosen = [list(c) for c in combinations(range(table.cols), size)]
    if table.rows > size:
        products = sp.Matrix(table.cols, table.cols, shorten(list(table.T * table), relations))
        minors = [products.extract(c, c).det(method="berkowitz") for c in chosen]
    else:
        minors = [table[:, c].det() for c in chosen]
    found = shorten(minors, relations)
    return sorted((m for m in found if m != 0), key=sp.count_ops)


def _nowhere_zero(value: Any, study: Study) -> bool:
    """Whether it does not vanish where what the study says to be positive is positive."""
    sizes = {x: sp.Symbol(f"size{i}", positive=True) for i, x in enumerate(study.positive)}
    return prove_inequality(value.xreplace(sizes), "!=", 0).proved
