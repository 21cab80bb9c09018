"""Of what turns a frame in space is made: longitude, colatitude, and an angle about that axis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.verdicts import prove_equal
from voronec.closed.compiled_motion import Prepared

__all__ = ["Composition", "composition"]


@dataclass(frozen=True)
class Composition:
    """``frame = Rz(longitude) Ry(colatitude) Rz(sense third) F`` with F constant.

    Attributes:
        trace: which of the declared traces has this longitude and colatitude.
        longitude: of one direction of the frame, in space.
        colatitude: of the same.
        third: the angle about that direction.
        sense: 1 or -1, how it is counted.
    """

    trace: int
    longitude: Any
    colatitude: Any
    third: Any
    sense: int


def composition(own: Prepared) -> Composition | None:
    """How the coordinates in space of a motion turn its frame; proved.  None where they do not in
    this way."""
    return own.memo.once("composition", lambda: _composition(own))


def _composition(own: Prepared) -> Composition | None:
    space = own.motion.space
    if space is None:
        return None
    for i, trace in enumerate(own.motion.traces):
        rest = [q for q in space.coordinates if q not in (trace.longitude, trace.colatitude)]
        if len(rest) != 1 or len(space.coordinates) != 3 or rest[0] not in own.motion.angles:
            continue
        for sense in (1, -1):
            found = Composition(i, trace.longitude, trace.colatitude, rest[0], sense)
            if _holds(space.frame, found):
                return found
    return None


def _holds(frame: sp.Matrix, parts: Composition) -> bool:
    """Whether F is free of the coordinates."""
    names = (parts.longitude, parts.colatitude, parts.third)
    v, c, b = own = sp.symbols("longitude colatitude third", cls=sp.Dummy)
    turned = sp.Matrix(frame.xreplace(dict(zip(names, own, strict=True))))
    rest = _about_third(-parts.sense * b) * _about_second(-c) * _about_third(-v) * turned
    still = rest.xreplace(dict.fromkeys(own, sp.Integer(0)))
    return all(prove_equal(e, f).proved for e, f in zip(rest, still, strict=True))


def _about_third(angle: Any) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _about_second(angle: Any) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
