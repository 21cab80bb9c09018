"""Motion by quadratures proved: what a system declares of its motion follows from its equations."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterator
from functools import partial

import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import Verdict
from voronec.analysis.claims import Claim
from voronec.analysis.quadratures.ground import Ground
from voronec.analysis.quadratures.in_space import InSpace
from voronec.analysis.quadratures.residues import decide_residues
from voronec.analysis.walls import across_walls
from voronec.errors import DefinitionError, EngineLimit
from voronec.quadratures import Plane, Trace
from voronec.reading import shown
from voronec.vector_field import Motions

__all__ = ["check_motion", "statements"]


def check_motion(motions: Motions) -> Iterator[Claim]:
    """A claim of kind ``motion`` for everything that the quadratures of a system state."""
    system = motions.system
    if system.motion is None:
        return
    for name, decide in statements(Ground(motions.on_coordinates, system.motion)):
        begin = clock.perf_counter()
        try:
            verdict = decide()
        except EngineLimit as limit:
            verdict = Verdict("undecided", str(limit))
        except DefinitionError as error:  # it makes no sense; the others stand all the same
            verdict = Verdict("refuted", str(error))
        seconds, reason = clock.perf_counter() - begin, system.undecided.get(name, "")
        yield Claim("motion", name, verdict, "coordinates", seconds, reason=reason)


def statements(ground: Ground) -> Iterator[tuple[str, Callable[[], Verdict]]]:
    """The name of each claim, which ``Quadratures.claims`` lists too, and how it is decided."""
    motion = ground.motion
    ways: list[Callable[[], Verdict]] = [partial(_constant, ground, c) for c in motion.constants]
    ways.append(partial(_quartic, ground))
    ways += [partial(_rate, ground, q) for q in motion.integrals]
    ways += [partial(_pole, ground, c) for c in motion.poles]
    ways += [partial(decide_residues, ground, rate) for rate in motion.rates.values()]
    ways += [partial(_trace, ground, t) for t in motion.traces]
    ways += [partial(_velocity, ground, v) for v in motion.velocities]
    if motion.space is not None:
        space = InSpace(ground, motion.space)
        ways += [space.orthogonal, space.constant, space.free, space.inverse]
    if motion.plane is not None:
        ways += [
            partial(_direction, ground, motion.plane),
            partial(_along, ground, motion.plane),
        ]
    return zip(motion.claims, ways, strict=True)


def _constant(ground: Ground, symbol: sp.Symbol) -> Verdict:
    function = ground.level[ground.field.door.inward(symbol)]
    found = ground.zero([("", ground.field.derivative(function))])
    return across_walls(found, ground.field, [("", function)], constant=True)


def _quartic(ground: Ground) -> Verdict:
    found = ground.zero([("", ground.run**2 - ground.on_level(ground.motion.quartic))])
    variable = [("the variable", ground.field.read(ground.motion.meaning))]
    return across_walls(found, ground.field, variable, periods=False)


def _rate(ground: Ground, q: sp.Expr) -> Verdict:
    there = ground.data_for(q)
    found = there(ground.field.derivative(ground.field.read(q)) * ground.pace)
    return ground.zero([("", found - there(ground.on_level(ground.motion.integrals[q])))])


def _pole(ground: Ground, place: sp.Expr) -> Verdict:
    """f(c) + 4 w^2 = 0."""
    motion = ground.motion
    f = motion.quartic.xreplace({motion.x: place})
    return ground.zero([("", ground.on_level(f + 4 * motion.poles[place] ** 2))])


def _trace(ground: Ground, trace: Trace) -> Verdict:
    there = ground.data_for(trace.colatitude)
    found = there(se.cos(ground.field.read(trace.colatitude)))
    return ground.zero([("", found - there(ground.on_level(trace.cosine)))])


def _velocity(ground: Ground, v: sp.Expr) -> Verdict:
    claimed = ground.on_level(ground.motion.velocities[v])
    return ground.zero([("", ground.field.read(v) - claimed)])


def _direction(ground: Ground, plane: Plane) -> Verdict:
    """The vector in the plane is constant, and as long as is said."""
    a, b = (ground.field.read(e) for e in plane.direction)
    found = [
        (f"the rate of {shown(e)}", rate)
        for e, rate in zip(plane.direction, ground.field.derivatives([a, b]), strict=True)
    ]
    found.append(("the length", a**2 + b**2 - ground.on_level(plane.length) ** 2))
    parts = [(shown(e), part) for e, part in zip(plane.direction, (a, b), strict=True)]
    return across_walls(ground.zero(found), ground.field, parts, constant=True)


def _along(ground: Ground, plane: Plane) -> Verdict:
    """length d(x + i y)/dtau = (a + i b)(rates + slopes dz/dtau)."""
    field = ground.field
    a, b = (field.read(e) for e in plane.direction)
    along, across = (
        ground.on_level(rate) + ground.on_level(slope) * ground.run
        for rate, slope in zip(plane.rates, plane.slopes, strict=True)
    )
    length = ground.on_level(plane.length)
    expected = (a * along - b * across, b * along + a * across)
    moved = [length * field.derivative(field.read(q)) * ground.pace for q in plane.place]
    pairs = zip(plane.place, moved, expected, strict=True)
    return ground.zero([(plain_name(q), rate - e) for q, rate, e in pairs])
