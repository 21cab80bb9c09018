"""A numerically hard case: a motion of a system of the catalogue, and what is hard about it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.algebra.arguments import COUNT, SEQUENCE, TEXT, require
from voronec.declaration.scene import Scene
from voronec.errors import DefinitionError, quote
from voronec.motion.methods import METHODS

__all__ = ["ARITHMETICS", "HardCase"]

ARITHMETICS = {"quadruple": 33, "extended": 19}
"""What a reference is computed in, with its decimal digits."""


@dataclass(frozen=True)
class HardCase:
    """A motion on which methods are tried, with outputs that are compared with a reference.

    name
        lower-case words joined by hyphens.
    system
        the name of a system of the catalogue; nothing is imported until the case is run.
    scene
        initial data (coordinates and velocities of the equations only), parameters, span and
        outputs; every output is compared, and the caption says what is hard.
    points
        how many instants of the span are compared, the start included.
    level
        where the reference is computed: ``coordinates``, ``invariants`` (free of poles), or ``""``
        where no motion starts and only a refusal is right.
    period
        a state of the closed system that vanishes at the start and after every period: the
        reference then follows one period and counts the rest; ``""`` where there is none.
    arithmetic
        of the reference, ``quadruple`` (33 digits) or ``extended`` (19 digits, for long spans).
    methods
        which of heyoka, scipy, numba, c, lsoda and flint are worth waiting for; the closed form is
        tried wherever the system declares one.
    chaotic
        whether errors grow exponentially; said in the table.
    """

    name: str
    system: str
    scene: Scene
    points: int = 41
    level: str = "coordinates"
    period: str = ""
    arithmetic: str = "quadruple"
    methods: tuple[str, ...] = ("heyoka", "scipy", "lsoda")
    chaotic: bool = False

    def __post_init__(self) -> None:
        for name in ("name", "system", "level", "period", "arithmetic"):
            require("hard case", name, getattr(self, name), TEXT)
        require(f"hard case '{self.name}'", "points", self.points, COUNT)
        require(f"hard case '{self.name}'", "methods", self.methods, SEQUENCE)
        if not isinstance(self.scene, Scene):
            raise self._wrong(f"scene = {quote(self.scene)}", "a voronec.Scene")
        if self.level not in ("coordinates", "invariants", ""):
            raise self._wrong(f"level = '{self.level}'", "coordinates, invariants or ''")
        if self.arithmetic not in ARITHMETICS:
            raise self._wrong(f"arithmetic = '{self.arithmetic}'", " or ".join(ARITHMETICS))
        if unknown := [m for m in self.methods if m not in [*METHODS]]:
            raise self._wrong(f"method '{quote(unknown[0])}'", ", ".join(METHODS))
        if self.points < 2:
            raise self._wrong(f"points = {self.points}", "2 or more")
        if not self.scene.outputs:
            raise self._wrong("no outputs", "a scene with outputs=(...)")

    def _wrong(self, what: str, mend: str) -> DefinitionError:
        return DefinitionError(f"hard case '{self.name}': {what}; give {mend}")

    @property
    def hard(self) -> str:
        """What is hard, in a sentence."""
        return self.scene.caption

    @property
    def grid(self) -> np.ndarray:
        """The instants at which outputs are compared, shape (points,)."""
        start, end = self.scene.times
        return np.linspace(float(start), float(end), self.points)

    @property
    def digest(self) -> str:
        """A digest of all that the reference depends on."""
        scene = self.scene
        told: list[Any] = [self.system, self.points, self.level, self.period, self.arithmetic]
        told += [*map(str, scene.times), *map(str, scene.outputs)]
        for mapping in (scene.initial, scene.parameters):
            told.append(sorted((str(k), str(v)) for k, v in mapping.items()))
        return hashlib.sha256(repr(told).encode()).hexdigest()[:16]
