"""Relations decided in the exact algebra: DPhi f = nu g(Phi), and what it does to claims.

Claims of a target are carried along a relation to its source and decided there.  On the zero set of
independent relations R the volume is the Leray form w with dR_1 ... dR_k w = dx.  For vectors w_i
that span the tangent space, w(w_1, ..., w_d) = det(w_1, ..., w_d, n_1, ..., n_k) with any n_j such
that dR_i(n_j) = delta_ij.

What kind of relation it is follows from its maps, and is never declared.

Parameters and unknown functions of a target must have values that such things can have.  A
parameter is a number: along each motion of the source its value is constant.  An unknown function
is one of its arguments: the value V(a, x) of f(a) may hold other state x of the source only where d
V(a(x), x) is a combination of the d a_i, modulo the relations; then V is a function of a where the
map leads.  Its derivatives are taken at constant x, which is right only where the part of dV that
comes from x vanishes.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.branches import has_branches
from voronec.algebra.conditions import split_hypotheses
from voronec.algebra.elimination import independent_columns, null_vectors, solve_linear
from voronec.algebra.matrices import determinant, dot
from voronec.algebra.normal import canonical
from voronec.algebra.rank import generic_rank
from voronec.algebra.symbols import plain_name
from voronec.algebra.terms import atoms
from voronec.algebra.typeset import html_table
from voronec.algebra.verdicts import Verdict, decide_equal, decide_zero
from voronec.declaration.claims import Equation, Measure, right_of
from voronec.declaration.relation import Relation
from voronec.equations.motions import Motions
from voronec.errors import EngineLimit
from voronec.proof.branch_cuts import across_cuts, beside_zeros, not_vacuous
from voronec.proof.claims import Claim
from voronec.proof.decision import all_zero
from voronec.proof.measures import defect
from voronec.proof.nondegeneracy import where_independent, where_nonzero, where_of_rank
from voronec.proof.relations.functions import Infinite
from voronec.proof.relations.orders import all_at_zero, at_zero, vanishes
from voronec.proof.relations.parameters import applications
from voronec.proof.relations.possible import possible_values
from voronec.proof.relations.statemap import StateMap


def residuals(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """Rates of parameters, relations of the target, rates of its positions, its equations.

    Each comes with what a message calls it [Theory, eq. (15)].
    """
    target, pull, nu = statemap.target, statemap.pull_back, statemap.clock
    yield from _moving_parameters(statemap)
    for i, relation in enumerate(target.relations):
        yield f"relation {i + 1} of '{target.system.name}'", pull(relation)
    if _is_timed(statemap):
        yield "the time", statemap.derivative(statemap.state[target.time]) - nu
    for q, rate in zip(target.positions, target.rates, strict=True):
        yield f"d{q}/dt", statemap.derivative(statemap.state[q]) - nu * pull(rate)
    yield from _motion(statemap)


def _motion(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """mass(Phi) d/dt Phi_v - nu force(Phi) for the velocities of the target.

    The accelerations in a row are slopes . vdot; with y mass = slopes in the source, they are
    y . force.
    """
    target, source, pull = statemap.target, statemap.source, statemap.pull_back
    images = [statemap.state[v] for v in target.velocities]
    at_rest = [statemap.scale(source.at_rest(e)) for e in images]
    forces = [statemap.scale(f) for f in source.force]
    for v, row, force in zip(target.velocities, target.mass, target.force, strict=True):
        mass = [pull(e) for e in row]
        slopes = [
            se.Add(*[m * statemap.scale(e.diff(w)) for m, e in zip(mass, images, strict=True)])
            for w in source.velocities
        ]
        y = _multiples(statemap, slopes)
        moved = [a * f for a, f in zip(y, forces, strict=True)]
        moved += [m * e for m, e in zip(mass, at_rest, strict=True)]
        yield f"the equation of '{v}'", se.Add(*moved) - statemap.clock * pull(force)


def _multiples(statemap: StateMap, slopes: Sequence[Any]) -> list[Any]:
    """y with y mass = slopes: where slopes are a multiple of one row, nothing has to be solved."""
    source = statemap.source
    if all(s == 0 for s in slopes):
        return [se.Integer(0)] * len(slopes)
    for index, row in enumerate(source.mass):
        factor = _factor(statemap, slopes, row)
        if factor is not None:
            return [factor if i == index else se.Integer(0) for i in range(len(slopes))]
    return [statemap.scale(line[0]) for line in source.solve([[s] for s in slopes])]


def _factor(statemap: StateMap, slopes: Sequence[Any], row: Sequence[Any]) -> Any:
    """The factor with slopes = factor * row, proved; ``None`` where there is none."""
    scaled = [statemap.scale(e) for e in row]
    at = next((i for i, e in enumerate(scaled) if e != 0), None)
    if at is None or slopes[at] == 0:
        return None
    factor = se.Integer(1) if slopes[at] == scaled[at] else slopes[at] / scaled[at]
    try:
        for s, e in zip(slopes, scaled, strict=True):
            if not decide_zero(s - factor * e, statemap.hypotheses).proved:
                return None
    except EngineLimit:
        return None
    return factor


def _is_timed(statemap: StateMap) -> bool:
    """Whether the time of the target matters, or is mapped."""
    target = statemap.target
    given = {str(k) for k in statemap.relation.state or {}}
    return str(target.time) in given or any(target.time in e.free_symbols for e in target.entries)


@dataclass(frozen=True, repr=False)
class CheckedRelation:
    """A relation with its verdict.

    ``kinds`` says what it is, as computed from the maps; ``levels`` on which variables of source
    and target it stands, ``coordinates`` or ``invariants``.  ``pulled`` are the claims of the
    target, carried to the source, each with its verdict there.
    """

    relation: Relation
    kinds: tuple[str, ...]
    levels: tuple[str, str]
    verdict: Verdict
    pulled: tuple[Claim, ...]
    seconds: float

    def __repr__(self) -> str:
        ends = f"{self.relation.source!r}, {self.relation.target!r}"
        return f"CheckedRelation({ends}, {', '.join(self.kinds)}: {self.verdict.status})"

    def _repr_html_(self) -> str:
        """For notebooks: the maps, the verdict, and the claims that are carried along."""
        maps = [(str(name), str(value)) for name, value in (self.relation.state or {}).items()]
        rows = [("verdict", self.verdict.status), ("kind", ", ".join(self.kinds)), *maps]
        rows += [(f"{c.kind}: {c.name}", c.standing) for c in self.pulled]
        return html_table(f"{self.relation.source} to {self.relation.target}", rows)


def check_relation(relation: Relation, motions: Callable[[str], Motions]) -> CheckedRelation:
    """Decide a relation and the claims that it carries from the target to the source.

    ``motions`` gives the motions of a system by its name.
    Raises ``DefinitionError`` where the relation maps too little or too much.
    """
    start = clock.perf_counter()
    read = StateMap.of(relation, motions)
    kinds, pulled = tuple[str, ...](), tuple[Claim, ...]()
    try:
        statemap = complete_velocities(read)
        stated, verdict = decided_at_limit(statemap)
        verdict = not_vacuous(verdict, statemap.source)
        kinds = _kinds_of(_stated_map(statemap, stated))
        pulled = () if verdict.refuted else tuple(_pulled_claims(stated, verdict.domain))
    except EngineLimit as limit:
        verdict = Verdict("undecided", str(limit))
    return CheckedRelation(
        relation=relation,
        kinds=kinds,
        levels=(read.source.level, read.target.level),
        verdict=verdict,
        pulled=pulled,
        seconds=clock.perf_counter() - start,
    )


def decided_at_limit(statemap: StateMap, beyond: bool = True) -> tuple[StateMap, Verdict]:
    """The verdict, and the map on which it was found; ``beyond`` as in ``across_cuts``.

    A limit of first order, where everything has one, is an exact relation of the limits: all that
    is in a residual is continuous there.
    """
    limit = statemap.relation.limit
    if limit is not None and limit.order == 1:
        try:
            there = at_limit(statemap)
            verdict = _decide_map(there, beyond)
            if not verdict.undecided:
                return there, verdict
        except EngineLimit:
            pass  # a pole that cancels, say: the residuals are expanded instead
    return statemap, _decide_map(statemap, beyond)


def _stated_map(statemap: StateMap, decided: StateMap) -> StateMap:
    """The map that the relation is about: that of the limit, where there is one."""
    if decided.small is None:
        return decided
    try:
        return at_limit(statemap)
    except EngineLimit:
        return statemap


def at_limit(statemap: StateMap) -> StateMap:
    """The relation where the small parameter vanishes; ``EngineLimit`` where that is singular."""
    source, small, rules = statemap.scaled_source, statemap.small, statemap.hypotheses

    def there(exprs: Iterable[Any]) -> tuple[Any, ...]:
        return tuple(at_zero(e, rules, small) for e in exprs)

    field = replace(
        source,
        rates=there(source.rates),
        mass=tuple(map(there, source.mass)),
        force=there(source.force),
        relations=there(source.relations),
        conditions=tuple(c for c in split_hypotheses(rules)[1] if small not in c.free_symbols),
    )
    unit = [[se.Integer(0)] for _ in field.velocities]
    if unit and solve_linear(field.mass, unit, field.hypotheses).free:
        raise EngineLimit(f"the mass matrix is singular where '{small}' vanishes")
    return replace(
        statemap,
        source=field,
        state=dict(zip(statemap.state, there(statemap.state.values()), strict=True)),
        parameters=dict(zip(statemap.parameters, there(statemap.parameters.values()), strict=True)),
        clock=there([statemap.clock])[0],
        small=None,
        scaling={},
    )


def _decide_map(statemap: StateMap, beyond: bool) -> Verdict:
    """Whether DPhi f = nu g(Phi), with nu not zero and a target that is determined there."""
    for verdict in (*_grounds(statemap), *_unsound_functions(statemap)):
        if not verdict.proved:
            return verdict
    for place, residual in residuals(statemap):
        verdict = _decide(statemap, residual)
        if not verdict.proved:
            return replace(verdict, method=f"{place}: {verdict.method}")
    proof = possible_values(statemap)
    return _across_cuts(statemap, proof, beyond) if proof.proved else proof


def _across_cuts(statemap: StateMap, verdict: Verdict, beyond: bool) -> Verdict:
    """The proof with the cuts of the map: positions and the time jump by periods of the target;
    parameters that hold state, potentials, velocities and the clock may not jump."""
    target, field = statemap.target, statemap.scaled_source
    held = [(f"the parameter '{p}'", e) for p, e in statemap.parameters.items() if p.is_Symbol]
    verdict = across_cuts(verdict, field, held, periods=False, constant=True)
    verdict = across_cuts(verdict, field, [*_potentials(statemap)], periods=False)
    for x in (*target.positions, target.time):
        image = [(f"the image '{x}'", statemap.state[x])]
        periods = partial(statemap.is_period, x)
        verdict = across_cuts(verdict, field, image, periods, beyond=beyond)
    fast = [(f"the image '{v}'", statemap.state[v]) for v in target.velocities]
    fast += [("the clock", statemap.clock)]
    verdict = across_cuts(verdict, field, fast, periods=False, beyond=beyond)
    verdict = _where_regular(statemap, verdict)
    verdict = where_nonzero(verdict, field, "the clock", statemap.clock)
    return beside_zeros(verdict, field, "the clock", statemap.clock)


def _where_regular(statemap: StateMap, verdict: Verdict) -> Verdict:
    """The proof where the mass of the target is regular on the image, on every piece of it."""
    size, field = len(statemap.target.mass), statemap.scaled_source
    mass = [statemap.pull_back(e) for row in statemap.target.mass for e in row]
    if not has_branches(mass, frozenset(field.variables)):
        return verdict
    doubt = "whether the mass of the target is regular on the image is open"

    def rows(exprs: Sequence[Any]) -> Matrix:
        return [[*exprs[i : i + size]] for i in range(0, len(exprs), size)]

    return where_of_rank(verdict, field, mass, rows, size, doubt)


def _potentials(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """The unknown functions of which the target takes derivatives, along the image: a jump of one
    is an impulse that no derivative beside it tells of."""
    for name, places in applications(statemap.target).items():
        if _is_differentiated(statemap, name):
            yield from ((f"the function '{name}'", statemap.pull_back(f)) for f in places)


def _grounds(statemap: StateMap) -> Iterator[Verdict]:
    """Whether the clock runs and the target is determined, at the limit where there is one."""
    small, rules = statemap.small, statemap.hypotheses
    where = "" if small is None else f" where '{small}' vanishes"
    try:
        clock_there = at_zero(statemap.clock, rules, small)
        mass = [
            [at_zero(statemap.pull_back(e), rules, small) for e in row]
            for row in statemap.target.mass
        ]
        there = all_at_zero(rules, small)
    except EngineLimit as limit:
        yield Verdict("undecided", f"the clock or the mass of the target: {limit}")
        return
    stands = decide_zero(clock_there, there)
    if stands.proved:
        yield Verdict("refuted", f"the clock stands still{where}")
    elif stands.undecided:
        yield Verdict("undecided", f"whether the clock runs{where}: {stands.method}")
    yield _is_determined(mass, there, where)


def _is_determined(mass: list[list[Any]], relations: Sequence[Any], where: str) -> Verdict:
    """Whether the target's equations of motion determine its accelerations on the image."""
    try:
        if generic_rank(mass, relations) == len(mass):
            return Verdict("proved", "a point where the mass matrix is regular")
        if decide_zero(determinant(mass), relations).proved:
            why = f"the mass matrix of the target is singular on the image{where}"
            return Verdict("refuted", why)
        reason = "its determinant is not proved to vanish"
    except EngineLimit as limit:
        reason = str(limit)
    return Verdict("undecided", f"whether the mass of the target is regular{where}: {reason}")


def _decide(statemap: StateMap, residual: Any) -> Verdict:
    limit = statemap.relation.limit
    order = 1 if limit is None else limit.order
    try:
        return vanishes(residual, statemap.hypotheses, statemap.small, order)
    except EngineLimit as error:
        return Verdict("undecided", str(error))


def complete_velocities(statemap: StateMap) -> StateMap:
    """The map with the velocities that follow from the positions: v(q', q), q' = q-dot / nu."""
    target = statemap.target
    missing = [v for v in target.velocities if v not in statemap.state]
    if not missing:
        return statemap
    dots = {
        dot: statemap.derivative(statemap.state[q]) / statemap.clock
        for q, dot in zip(target.positions, target.dots, strict=True)
    }
    partial = replace(statemap, state={**statemap.state, **dots})
    velocities = {v: partial.pull_back(target.definitions[v]) for v in missing}
    return replace(statemap, state={**statemap.state, **velocities})


Matrix = list[list[Any]]


def corresponds(statemap: StateMap) -> bool:
    """Whether states of source and target correspond one to one, near a generic one."""
    source, target = statemap.source, statemap.target
    try:
        return bool(source.dimension == target.dimension == _state_rank(statemap))
    except EngineLimit:
        return False


def _volume_factor(statemap: StateMap) -> Any:
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
    if not relations:
        return [[se.Integer(int(i == j)) for j in size] for i in size]
    gradient = [[r.diff(x) for x in variables] for r in relations]
    return null_vectors(gradient, independent_columns(gradient, reversed(size)), relations)


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


def _pulled_claims(statemap: StateMap, domain: str) -> Iterator[Claim]:
    """The claims of the target as they stand for the source, on the domain of the relation."""
    for claim in _carried_claims(statemap):
        yield replace(claim, verdict=claim.verdict.where(domain))


def _carried_claims(statemap: StateMap) -> Iterator[Claim]:
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
            periods = kind != "measure"
            verdict = across_cuts(verdict, field, inside, periods, is_constant, beyond=True)
            if kind == "measure":
                verdict = where_nonzero(verdict, field, "the density", inside[0][1])
    except Infinite:
        return
    except EngineLimit as reached:
        verdict = Verdict("undecided", str(reached))
    yield Claim(kind, name, verdict)


def _is_mapped(statemap: StateMap, *exprs: sp.Expr) -> bool:
    """Whether functions of the target's state are functions of what is mapped."""
    target = statemap.target
    known = {*target.variables, *target.parameters, target.time}
    named = (target.bridge.inward(e).free_symbols <= known for e in exprs)
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
    variables = (*target.system.coordinates, *target.system.velocities)
    given = {str(v) for v in measure.variables or map(plain_name, variables)}
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
    density = _pull_back(statemap, right_of(claim).density) * _volume_factor(statemap)
    if statemap.clock.free_symbols & {*statemap.source.variables}:
        density = density / statemap.clock  # a clock that only the time drives keeps volumes
    yield density


def _dilation(statemap: StateMap, claim: Any) -> Iterator[Any]:
    for density in _densities(statemap, claim):
        yield statemap.scale(defect(statemap.source, density))


def _kinds_of(statemap: StateMap) -> tuple[str, ...]:
    """The words that apply, the most telling one first.

    limit
        it holds as a small parameter tends to zero.
    change of time
        the clock is not 1.
    specialisation
        the parameters of the source fill fewer dimensions than those of the target.
    automorphism
        it leads from a system to itself.
    constant map
        all states go to one, and nothing is told of the source.
    reduction, embedding
        the state map forgets part of the source; does not fill the target.
    change of coordinates, equality
        states correspond one to one, under other names or the same ones.

    Where a parameter or a side of a cut makes the rank of the state map less, that is told last.
    """
    words = []
    is_limit = statemap.relation.limit is not None
    if is_limit:
        words.append("limit")
    if not decide_equal(statemap.clock, 1, statemap.hypotheses).proved:
        words.append("change of time")
    if not is_limit and _is_special(statemap):
        words.append("specialisation")
    if statemap.relation.source == statemap.relation.target:
        words.append("automorphism")
    try:
        return (*words, *_by_rank(statemap, bool(words)))
    except EngineLimit:  # no point was found: nothing is said about ranks
        return tuple(words)


def _by_rank(statemap: StateMap, is_named: bool) -> Iterator[str]:
    rank, sizes = _state_rank(statemap), (statemap.source.dimension, statemap.target.dimension)
    if not rank and any(sizes):
        yield "constant map"
        return
    if rank < sizes[0]:
        yield "reduction"
    if rank < sizes[1]:
        yield "embedding"
    if sizes == (rank, rank):
        if not statemap.is_identity:
            yield "change of coordinates"
        elif not is_named:
            yield "equality"
    if not statemap.is_identity and statemap.small is None:
        domain = _where_of_full_rank(statemap, rank).domain
        yield from [f"of less rank unless {domain}"] if domain else []


def _where_of_full_rank(statemap: StateMap, rank: int) -> Verdict:
    """Where the state map has the rank that it has at a generic state."""
    field = statemap.scaled_source
    images = [statemap.state[x] for x in statemap.target.variables]
    proof = Verdict("proved", "the rank at a point")
    return where_independent(
        proof, field, images, field.variables, field.independent_relations, rank
    )


def _state_rank(statemap: StateMap) -> int:
    """The rank of the state map on states of the source.

    Raises ``EngineLimit`` where no point is found.
    """
    source = statemap.source
    images = [statemap.state[x] for x in statemap.target.variables]
    gradients = [[f.diff(x) for x in source.variables] for f in images]
    kept = [statemap.scale(r) for r in source.independent_relations]
    bound = [[r.diff(x) for x in source.variables] for r in kept]
    return generic_rank([*bound, *gradients], statemap.hypotheses) - len(bound)


def _is_special(statemap: StateMap) -> bool:
    parameters = statemap.source.parameters
    values = [v for p, v in statemap.parameters.items() if not p.args]
    if not values:
        return False
    rows = [[value.diff(p) for p in parameters] for value in values]
    try:
        return (generic_rank(rows, ()) if parameters else 0) < len(values)
    except EngineLimit:
        return False


def foreign(statemap: StateMap, symbol: Any, value: Any) -> list[Any]:
    """What the value of a parameter or a function holds of the state and the time of the source."""
    arguments = () if symbol.is_Symbol else symbol.args
    allowed = {*arguments, *statemap.source.parameters, statemap.small}
    return sorted(value.free_symbols - allowed, key=str)


def _moving_parameters(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """The rates of parameters that hold state or time: they have to vanish."""
    for symbol, value in statemap.parameters.items():
        if symbol.is_Symbol and foreign(statemap, symbol, value):
            yield f"the parameter '{symbol}'", statemap.derivative(value)


def _unsound_functions(statemap: StateMap) -> Iterator[Verdict]:
    """Why the value of an unknown function is none, or was not proved to be one."""
    for function, value in statemap.parameters.items():
        if function.is_Symbol:
            continue
        held = [z for z in foreign(statemap, function, value) if not _is_constant(statemap, z)]
        if held:
            try:
                why = _unsound(statemap, function, value, held)
            except EngineLimit as limit:
                why = Verdict("undecided", f"the function '{function.get_name()}': {limit}")
            if why is not None:
                yield why


def _is_constant(statemap: StateMap, variable: Any) -> bool:
    return decide_zero(statemap.derivative(variable), statemap.hypotheses).proved


def _unsound(statemap: StateMap, function: Any, value: Any, held: Sequence[Any]) -> Verdict | None:
    name = function.get_name()
    places = applications(statemap.target)[name]
    if len(places) > 1:
        raise EngineLimit("it holds state, and is taken of several arguments")
    images = [statemap.pull_back(a) for a in places[0].args]
    at = dict(zip(function.args, images, strict=True))
    variables = (*statemap.source.variables, statemap.source.time)
    slopes = {z: value.diff(z).xreplace(at) for z in held}
    part = [slopes.get(x, se.Integer(0)) for x in variables]
    if _is_spanned(statemap, part, (), variables):
        return None
    held_by = f"the value of '{name}' holds state"
    if not _is_spanned(statemap, part, images, variables):
        return Verdict("refuted", f"{held_by} that is no function of its arguments")
    if _is_differentiated(statemap, name):
        return Verdict("undecided", f"{held_by}, and the target differentiates it")
    return None


def _is_spanned(
    statemap: StateMap, part: Sequence[Any], functions: Sequence[Any], variables: Sequence[Any]
) -> bool:
    """Whether a differential is a combination of those of functions and of the relations."""
    rows = [[f.diff(x) for f in (*functions, *statemap.relations)] for x in variables]
    if not rows[0]:
        verdict = all_zero((("", e) for e in part), statemap.hypotheses)
        if verdict.undecided:
            raise EngineLimit(verdict.method)
        return verdict.proved
    solved = solve_linear(rows, [[e] for e in part], statemap.hypotheses)
    return not solved.contradictory


def _is_differentiated(statemap: StateMap, name: str) -> bool:
    target = statemap.target
    inner = atoms((*target.entries, *target.relations), se.Derivative, se.Subs)
    return any(f.get_name() == name for d in inner for f in d.atoms(se.FunctionSymbol))
