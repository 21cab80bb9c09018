"""Where a contact runs and how a body is turned: traces on spheres, in space, over a plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.symbols import names_in, plain_name
from voronec.errors import DefinitionError
from voronec.reading import expression, mapping, several, shown

__all__ = ["Plane", "Space", "Trace", "store"]


@dataclass(frozen=True)
class Trace:
    """The trace of a contact on a sphere: its colatitude and longitude, both coordinates.

    ``cosine`` is that of the colatitude, rational in the variable, affine where the time is that of
    the quartic; ``title`` the key under which the
    system's ``drawing`` has the two coordinates, filled in by the system.
    """

    colatitude: Any
    longitude: Any
    cosine: Any
    title: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "cosine", expression(self.cosine, "the cosine of a trace"))


@dataclass(frozen=True)
class Space:
    """How a body is turned in space, where only the direction of one vector matters.

    frame
        3 x 3 orthogonal, a function of the state: the columns are a moving frame in space.
    vector
        3 components along that frame; ``frame * vector`` is constant in space.
    coordinates
        coordinate -> its value as a function of ``entries``, those of the frame; written with
        ``atan2``, which is accurate everywhere.  Nothing else depends on these coordinates.
    entries
        3 x 3 symbols.

    Integrals and traces of these coordinates hold where ``frame * vector`` lies along the third
    axis, upwards; any other motion is such a one, turned in space.
    """

    frame: sp.ImmutableMatrix
    vector: sp.ImmutableMatrix
    coordinates: Mapping[Any, Any]
    entries: sp.ImmutableMatrix

    def __post_init__(self) -> None:
        for name, shape in (("frame", (3, 3)), ("vector", (3, 1)), ("entries", (3, 3))):
            given = getattr(self, name)
            if not isinstance(given, sp.MatrixBase) or given.shape != shape:
                raise DefinitionError(
                    f"{name} of a space is '{shown(given)}'; write a sympy Matrix of shape {shape}"
                )
            object.__setattr__(self, name, sp.ImmutableMatrix(given))
        if not all(isinstance(e, sp.Symbol) for e in self.entries):
            raise DefinitionError("entries of a space hold more than symbols; write 9 symbols")
        store(self, "coordinates", self.coordinates, "a coordinate in space")
        for q, value in self.coordinates.items():
            foreign = sorted(map(str, names_in(value) - {*self.entries}))
            if foreign:
                raise DefinitionError(
                    f"the coordinate '{plain_name(q)}' in space holds '{foreign[0]}'; write it "
                    "with the entries of the frame"
                )


@dataclass(frozen=True)
class Plane:
    """How a contact runs over a plane, along and across a vector that is constant there.

    place
        (x, y), two coordinates.
    direction
        (a, b), functions of the state, constant along the motion: a vector in the plane.
    length
        its length, a function of constants and parameters.
    rates
        d/dtau of the place along the vector and across it, to its left, as far as they are
        integrals: rational in the variable.
    slopes
        the rest of both by the variable, rational in it: what has come back has moved nothing.

    In complex numbers, with d = (a + i b)/length and the variable z,
    d(x + i y) = d ((rates[0] + i rates[1]) dtau + (slopes[0] + i slopes[1]) dz).
    """

    place: tuple[Any, Any]
    direction: tuple[Any, Any]
    length: Any
    rates: tuple[Any, Any] = (0, 0)
    slopes: tuple[Any, Any] = (0, 0)

    def __post_init__(self) -> None:
        for name in ("place", "direction", "rates", "slopes"):
            given = several(getattr(self, name), name, "one, other")
            if len(given) != 2:
                raise DefinitionError(f"{name} of a plane holds {len(given)} entries; write two")
            read = tuple(expression(e, f"{name} of a plane") for e in given)
            object.__setattr__(self, name, read)
        object.__setattr__(self, "length", expression(self.length, "length of a plane"))


def store(owner: Any, name: str, given: Any, what: str) -> None:
    """A mapping to expressions in its final form."""
    values = mapping(given, name, "symbol: expression")
    read = {k: expression(e, f"{what} '{shown(k)}'") for k, e in values.items()}
    object.__setattr__(owner, name, MappingProxyType(read))
