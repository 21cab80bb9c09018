"""Claims of a target, carried along a relation to its source and decided there.

On the zero set of independent relations R the volume is the Leray form w with
dR_1 ... dR_k w = dx.  For vectors w_i that span the tangent space, w(w_1, ..., w_d) =
det(w_1, ..., w_d, n_1, ..., n_k) with any n_j such that dR_i(n_j) = delta_ij.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import determinant, dot
from voronec.algebra.normal import canonical
from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.claims import Equation, Measure, right_of
from voronec.errors import EngineLimit
from voronec.proof.claims import Claim
from voronec.proof.measures import defect
from voronec.proof.relations.dependence import foreign
from voronec.proof.relations.functions import Infinite
from voronec.proof.relations.kinds import state_rank
from voronec.proof.relations.orders import vanishes
from voronec.proof.relations.statemap import StateMap
from voronec.proof.walls import across_walls

__all__ = ["corresponds", "pulled_claims", "volume_factor"]


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
    gram = [[dot(p, q) for q in gradient] for p in gradient]
    unit = [[se.Integer(int(i == j)) for j in range(len(gram))] for i in range(len(gram))]
    inverse = solve_linear(gram, unit, field.hypotheses).values
    columns = zip(*inverse, strict=True)
    return [[dot(column, across) for across in zip(*gradient, strict=True)] for column in columns]


def _determinant(rows: Matrix, relations: Sequence[Any]) -> Any:
    flat = canonical([e for row in rows for e in row], relations)
    size = len(rows)
    return determinant([flat[i * size : (i + 1) * size] for i in range(size)])


def pulled_claims(statemap: StateMap) -> Iterator[Claim]:
    """Integrals, equations and the measure of the target, as they stand for the source.

    F(Phi) is an integral; d/dt F(Phi) = nu rate(Phi); and where states correspond one to one,
    rho(Phi) det DPhi / nu is the density of an invariant measure [Theory, eq. (16)].  A claim that
    the map says nothing about, as one of coordinates where invariants are mapped, or that is
    infinite on the image, is left out.
    """
    system = statemap.target.system
    for name, claim in system.integrals.items():
        function = right_of(claim)
        if _is_mapped(statemap, function):
            images = _images(statemap, function)
            yield from _claim(statemap, "integral", name, _rates(statemap, function), images)
    for name, claim in system.equations.items():
        equation: Equation = right_of(claim)
        if _is_mapped(statemap, *equation.function, *equation.rate):
            images = _images(statemap, *equation.function)
            yield from _claim(statemap, "equation", name, _defects(statemap, equation), images)
    if system.measure is not None and _is_measured(statemap, right_of(system.measure)):
        density = _densities(statemap, system.measure)
        dilation = _dilation(statemap, system.measure)
        yield from _claim(statemap, "measure", "density", dilation, density)


def _claim(
    statemap: StateMap, kind: str, name: str, residuals: Iterator[Any], functions: Iterator[Any]
) -> Iterator[Claim]:
    """The claim that residuals vanish, unless it has no meaning on the image; ``functions`` are
    what must not jump."""
    limit = statemap.relation.limit
    order = 1 if limit is None else limit.order
    verdict = Verdict("proved", "nothing to decide")
    try:
        for residual in residuals:
            verdict = vanishes(residual, statemap.hypotheses, statemap.small, order)
            if not verdict.proved:
                break
        if verdict.proved:
            field, is_constant = statemap.scaled_source, kind == "integral"
            inside = [("", f) for f in functions]
            verdict = across_walls(verdict, field, inside, kind != "measure", is_constant)
    except Infinite:
        return
    except EngineLimit as reached:
        verdict = Verdict("undecided", str(reached))
    yield Claim(kind, name, verdict)


def _is_mapped(statemap: StateMap, *exprs: sp.Expr) -> bool:
    """Whether functions of the target's state are functions of what is mapped."""
    target = statemap.target
    known = {*target.variables, *target.parameters, target.time}
    named = (target.door.inward(e).free_symbols <= known for e in exprs)
    if target.level == "invariants" and not all(named):
        return False
    is_timed = any(target.time in target.read(e).free_symbols for e in exprs)
    return not is_timed or _has_time(statemap)


def _has_time(statemap: StateMap) -> bool:
    """Whether the map gives the time of the target: one that runs with the rate nu."""
    rate = statemap.derivative(statemap.state[statemap.target.time])
    return decide_zero(rate - statemap.clock, statemap.hypotheses).proved


def _pull_back(statemap: StateMap, expr: sp.Expr) -> Any:
    return statemap.pull_back(statemap.target.read(expr))


def _images(statemap: StateMap, *functions: sp.Expr) -> Iterator[Any]:
    yield from (_pull_back(statemap, f) for f in functions)


def _rates(statemap: StateMap, function: sp.Expr) -> Iterator[Any]:
    yield statemap.derivative(_pull_back(statemap, function))


def _defects(statemap: StateMap, equation: Equation) -> Iterator[Any]:
    for function, rate in zip(equation.function, equation.rate, strict=True):
        moved = statemap.derivative(_pull_back(statemap, function))
        yield moved - statemap.clock * _pull_back(statemap, rate)


def _is_measured(statemap: StateMap, measure: Measure) -> bool:
    """Whether states correspond one to one, and the density is one in the mapped variables."""
    target = statemap.target
    own = (*target.system.coordinates, *target.system.velocities)
    given = {str(v) for v in measure.variables or map(plain_name, own)}
    if given != {str(x) for x in target.variables} or not corresponds(statemap):
        return False
    return _is_mapped(statemap, measure.density) and _has_plain_clock(statemap)


def _has_plain_clock(statemap: StateMap) -> bool:
    """Whether (16) holds: parameters are numbers, and a clock that the state drives is all there
    is to the time."""
    source, clock = statemap.source, statemap.clock
    numbers = [(p, v) for p, v in statemap.parameters.items() if p.is_Symbol]
    if any(foreign(statemap, p, v) for p, v in numbers):
        return False
    if not clock.free_symbols & {*source.variables}:
        return True
    timed = [clock, *(statemap.state[x] for x in statemap.target.variables)]
    moved = statemap.state[statemap.target.time].free_symbols & {*source.variables}
    return not moved and not any(source.time in e.free_symbols for e in timed)


def _densities(statemap: StateMap, claim: Any) -> Iterator[Any]:
    density = _pull_back(statemap, right_of(claim).density) * volume_factor(statemap)
    if statemap.clock.free_symbols & {*statemap.source.variables}:
        density = density / statemap.clock  # a clock that only the time drives keeps volumes
    yield density


def _dilation(statemap: StateMap, claim: Any) -> Iterator[Any]:
    for density in _densities(statemap, claim):
        yield statemap.scale(defect(statemap.source, density))
