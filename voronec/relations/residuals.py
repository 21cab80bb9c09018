"""What has to vanish for a relation to hold."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import symengine as se

from voronec.algebra.verdicts import decide_zero
from voronec.errors import EngineLimit
from voronec.relations.dependence import moving_parameters
from voronec.relations.statemap import StateMap

__all__ = ["residuals"]


def residuals(statemap: StateMap) -> Iterator[tuple[str, Any]]:
    """Rates of parameters, relations of the target, rates of its positions, its equations.

    Each comes with what a message calls it [Theory, eq. (15)].
    """
    target, pull, nu = statemap.target, statemap.pull_back, statemap.clock
    yield from moving_parameters(statemap)
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
    held = (*target.rates, *target.force, *(e for row in target.mass for e in row))
    given = {str(k) for k in statemap.relation.state or {}}
    return str(target.time) in given or any(target.time in e.free_symbols for e in held)
