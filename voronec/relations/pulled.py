"""Claims of a target, carried along a relation to its source and decided there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.analysis.claims import Claim
from voronec.analysis.measures import defect
from voronec.analysis.walls import across_walls
from voronec.claims import Equation, Measure, right_of
from voronec.errors import EngineLimit
from voronec.relations.dependence import foreign
from voronec.relations.orders import vanishes
from voronec.relations.statemap import StateMap
from voronec.relations.substitution import Infinite
from voronec.relations.volumes import corresponds, volume_factor

__all__ = ["pulled_claims"]


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


def _pulled(statemap: StateMap, expr: sp.Expr) -> Any:
    return statemap.pull_back(statemap.target.read(expr))


def _images(statemap: StateMap, *functions: sp.Expr) -> Iterator[Any]:
    yield from (_pulled(statemap, f) for f in functions)


def _rates(statemap: StateMap, function: sp.Expr) -> Iterator[Any]:
    yield statemap.derivative(_pulled(statemap, function))


def _defects(statemap: StateMap, equation: Equation) -> Iterator[Any]:
    for function, rate in zip(equation.function, equation.rate, strict=True):
        moved = statemap.derivative(_pulled(statemap, function))
        yield moved - statemap.clock * _pulled(statemap, rate)


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
    density = _pulled(statemap, right_of(claim).density) * volume_factor(statemap)
    if statemap.clock.free_symbols & {*statemap.source.variables}:
        density = density / statemap.clock  # a clock that only the time drives keeps volumes
    yield density


def _dilation(statemap: StateMap, claim: Any) -> Iterator[Any]:
    for density in _densities(statemap, claim):
        yield statemap.scale(defect(statemap.source, density))
