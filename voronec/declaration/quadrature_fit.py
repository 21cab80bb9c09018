"""Whether a motion by quadratures fits the system that declares it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.declaration.reading import require_known
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.declaration.quadratures import Quadratures
    from voronec.declaration.system import System

__all__ = ["check_motion"]


def check_motion(system: System) -> None:
    """A motion by quadratures is made of the state, parameters and its own symbols, and gives every
    coordinate and every velocity."""
    if system.motion is None:
        return
    place = f"system '{system.name}': motion"
    _check_symbols(system, system.motion, place)
    _check_subjects(system, system.motion, place)
    for q in system.coordinates:
        if q not in system.motion.given:
            raise DefinitionError(f"{place} gives no value to the coordinate '{plain_name(q)}'")
    for w in system.velocities:
        dotted = w in {velocity(q) for q in system.coordinates}
        if w not in system.motion.velocities and not dotted:
            raise DefinitionError(f"{place} gives no value to the velocity '{plain_name(w)}'")


def _check_symbols(system: System, motion: Quadratures, place: str) -> None:
    """Its own symbols are new, and its expressions hold none but known ones."""
    own = {motion.x, *motion.constants}
    for symbol in own:
        meaning = system.invariants.get(plain_name(symbol))
        taken = symbol in system.known_symbols()
        if taken or (meaning is not None and meaning != motion.variable.get(symbol)):
            raise DefinitionError(
                f"{place}: the name '{plain_name(symbol)}' is used twice; rename the variable or "
                "constant of the motion"
            )
    state, resting = {*system.known_symbols()} - {time}, {p.symbol for p in system.parameters}
    for what, expr, inside in motion.expressions():
        known = {"state": state, "level": resting | own, "both": state | own}[inside]
        require_known(f"{place}: {what}", expr, known)


def _check_subjects(system: System, motion: Quadratures, place: str) -> None:
    """What is given a rate or a value is a coordinate or a velocity."""
    for trace in motion.traces:
        for q, role in ((trace.colatitude, "colatitude"), (trace.longitude, "longitude")):
            if q not in system.coordinates:
                raise DefinitionError(f"{place}: the {role} '{q}' of a trace is no coordinate")
        if trace.longitude not in motion.integrals:
            raise DefinitionError(
                f"{place} gives no rate to the longitude '{trace.longitude}' of a trace"
            )
    for q in motion.integrals:
        if q not in system.coordinates:
            raise DefinitionError(f"{place} gives a rate to '{q}', which is no coordinate")
    for v in motion.velocities:
        if v not in system.velocities:
            raise DefinitionError(
                f"{place} gives a value to '{v}', which is no velocity of the equations"
            )
