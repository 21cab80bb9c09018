"""Periodic orbits with their Floquet multipliers, and families of them, as ``periodic`` finds
them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from voronec.algebra.typeset import html_table
from voronec.declaration.system import System
from voronec.dynamics.spectrum import number_text
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARGIN = 1e-6
"""A multiplier is off the unit circle where it is so by more than this."""


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit:
    """A periodic orbit.

    ``state`` (n,) is a point of it in the ``variables``; ``turns`` (n,) says by how many whole
    turns an angle has grown after the ``period``.  ``monodromy`` (n, n) is the slope of the state
    after a period by that before; ``trivial`` are the multipliers that the flow and the constants
    of the motion make 1, ``multipliers`` all others, the largest first.  ``constants`` are the
    values of the constants of the motion by name, ``closure`` what the orbit fails to close by, in
    units of the sizes of the variables; ``path`` (m, n) holds points along it, from ``state`` on.
    """

    system: System
    variables: tuple[str, ...]
    state: np.ndarray
    period: float
    turns: np.ndarray
    monodromy: np.ndarray
    trivial: np.ndarray
    multipliers: np.ndarray
    constants: Mapping[str, float]
    parameters: Mapping[str, float]
    closure: float
    path: np.ndarray

    def __getitem__(self, name: str) -> float:
        known = {"period": self.period, **self.constants,
                 **dict(zip(self.variables, self.state.tolist(), strict=True))}  # fmt: skip
        if name not in known:
            raise DefinitionError(f"the orbit has no '{name}'{did_you_mean(name, known)}")
        return known[name]

    @property
    def unstable(self) -> int:
        """How many multipliers lie outside of the unit circle."""
        return int((np.abs(self.multipliers) > 1 + MARGIN).sum())

    @property
    def stability(self) -> str:
        """``unstable`` where a multiplier lies outside of the unit circle; ``asymptotically
        stable``, as an orbit on the level of the constants, where all but the trivial ones lie
        inside; ``spectrally stable`` else, which is no stability."""
        if self.unstable:
            return "unstable"
        inside = len(self.multipliers) and (np.abs(self.multipliers) < 1 - MARGIN).all()
        return "asymptotically stable" if inside else "spectrally stable"

    @property
    def trivial_defect(self) -> float:
        """By how much the trivial multipliers are off 1."""
        return float(np.abs(self.trivial - 1).max(initial=0.0))

    def lines(self) -> list[str]:
        """What there is to say of the orbit, in words."""
        point = ", ".join(
            f"{n} = {x:.10g}" for n, x in zip(self.variables, self.state, strict=True)
        )
        kept = ", ".join(f"{n} = {x:.10g}" for n, x in self.constants.items())
        others = ", ".join(number_text(z) for z in self.multipliers) or "none"
        return [
            f"period {self.period:.12g}, closed to {self.closure:.1e}; {self.stability}",
            f"through {point}",
            *([f"with {kept}"] if kept else []),
            f"multipliers {others}",
            f"and {len(self.trivial)} trivial ones, 1 to {self.trivial_defect:.1e}",
        ]

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it; a complex number is a pair."""
        return {
            "period": self.period, "closure": self.closure, "stability": self.stability,
            "state": dict(zip(self.variables, self.state.tolist(), strict=True)),
            "constants": dict(self.constants), "turns": self.turns.tolist(),
            "multipliers": [[z.real, z.imag] for z in self.multipliers.astype(complex)],
            "trivial": len(self.trivial), "trivial_defect": self.trivial_defect,
        }  # fmt: skip

    def __repr__(self) -> str:
        words = f"period {self.period:.8g}, {self.stability}"
        return f"PeriodicOrbit({self.system.name!r}, {words})"

    def _repr_html_(self) -> str:
        return html_table(repr(self), [(str(i), line) for i, line in enumerate(self.lines())])


class Bifurcation(NamedTuple):
    """Where a multiplier of a family passes ``at`` 1 or -1 (then the period doubles): the orbit
    there, and the value of what the family is followed along."""

    at: int
    value: float
    orbit: PeriodicOrbit


@dataclass(frozen=True, eq=False, repr=False)
class OrbitFamily:
    """A family of periodic orbits ``along`` a constant of the motion or a parameter, with what was
    found of it: ``bifurcations`` of multipliers through 1 and -1; ``ended`` says why it ends."""

    along: str
    orbits: tuple[PeriodicOrbit, ...]
    bifurcations: tuple[Bifurcation, ...]
    ended: str
    seconds: float

    def __len__(self) -> int:
        return len(self.orbits)

    def __iter__(self) -> Iterator[PeriodicOrbit]:
        return iter(self.orbits)

    @property
    def doublings(self) -> tuple[Bifurcation, ...]:
        """Where the period doubles."""
        return tuple(c for c in self.bifurcations if c.at == -1)

    def __getitem__(self, name: str) -> np.ndarray:
        """A variable, a constant or ``period`` along the family."""
        return np.array([orbit[name] for orbit in self.orbits])

    def plot(self) -> Figure:
        """The orbits in the plane of two variables, their periods and multipliers."""
        from voronec.dynamics.pictures import orbits_figure

        return orbits_figure(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the family to ``path``, as ``Trajectory.save`` does: a row for each orbit."""
        from voronec.motion.storage import NamedArrays

        system, names = self.orbits[0].system, self.orbits[0].variables
        columns = {name: self[name] for name in (self.along, "period", *names)}
        columns["unstable multipliers"] = np.array([orbit.unstable for orbit in self])
        rows = {name: (("orbit",), values) for name, values in columns.items()}
        return NamedArrays.of(system, "OrbitFamily", rows, ("orbit",), (*columns,)).save(path)

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold of it."""
        return {
            "system": self.orbits[0].system.name, "along": self.along, "ended": self.ended,
            "orbits": [orbit.as_dict() for orbit in self], "seconds": self.seconds,
            "bifurcations": [{"multiplier": c.at, "value": c.value, "period": c.orbit.period}
                             for c in self.bifurcations],
        }  # fmt: skip

    def __repr__(self) -> str:
        first, last = self[self.along][[0, -1]]
        span = f"{len(self)} orbits along {self.along} = {first:.6g} .. {last:.6g}"
        return f"OrbitFamily({self.orbits[0].system.name!r}, {span}, {self.ended})"
