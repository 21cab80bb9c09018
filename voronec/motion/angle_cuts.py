"""Motions that reach the cut of an angle in what may not jump: they end there.

The equations know nothing of the jump of L = v^2/2 - atan(1/(x - 2)) at x = 2: its slope is smooth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from voronec.equations.jumps import AngleCut, angle_cuts
from voronec.errors import IntegrationError
from voronec.motion.request import Guard, Namespace
from voronec.motion.trajectory import Trajectory

CUT = "the cut of an angle"
"""Begins the names of events that nobody asked for."""

Motion = Callable[[tuple[Any, ...], Mapping[str, Any], tuple[Guard, ...], np.ndarray], Trajectory]
"""Of outputs, functions of events by name, events, and a grid."""


@dataclass(frozen=True)
class CutWatch:
    """Looks where motions of a system reach its ``cuts``, by names of events."""

    namespace: Namespace
    cuts: Mapping[str, AngleCut]

    @classmethod
    def of(cls, namespace: Namespace) -> CutWatch:
        """The cuts in the Lagrangian, in constraints and in the frame, which are sought once."""
        d = namespace.equations.definition

        def find() -> dict[str, AngleCut]:
            forms = (("a constraint", d.constraints), ("a quasi-velocity", d.frame))
            places = [(n, e) for n, f in forms if f is not None for e in f.expressions(d.dots)]
            cuts = angle_cuts(d.lagrangian, places, d.coordinates, d.dots, d.time, d.conditions)
            return {f"{CUT} {i}": cut for i, cut in enumerate(cuts)}

        return cls(namespace, namespace.equations.memo.once("cuts of angles", find))

    def motion(
        self, go: Motion, outputs: tuple[Any, ...], functions: Mapping[str, Any],
        events: tuple[Guard, ...], grid: np.ndarray,
    ) -> Trajectory:  # fmt: skip
        """The motion, with nobody looking; ``IntegrationError``, with the motion up to there, where
        it reaches a cut."""
        if not self.cuts:
            return go(outputs, functions, events, grid)
        names = self.namespace.read_outputs(outputs).names
        hidden = tuple(s for n, s in self._sides.items() if n not in names)
        wide = (*(outputs or names), *hidden) if hidden else outputs
        switches = {name: self._outward(cut.switch) for name, cut in self.cuts.items()}
        looks = [Guard(n, stop=cut.side is None) for n, cut in self.cuts.items()]
        failure = None
        try:
            trajectory = go(wide, {**functions, **switches}, (*events, *looks), grid)
        except IntegrationError as error:
            if error.trajectory is None:
                raise
            trajectory, failure = error.trajectory, error
        hit = self._first(trajectory)
        if hit is not None:
            end = float(hit[0])
            early = grid[np.abs(grid - grid[0]) < abs(end - grid[0])]
            raise self._error(*hit, go(outputs, functions, events, np.append(early, end)))
        trajectory = replace(trajectory, outputs=names)
        if hidden and (inside := trajectory.within) is not None:
            trajectory = replace(
                trajectory, within=lambda times: replace(inside(times), outputs=names)
            )
        if failure is not None:
            failure.trajectory = trajectory
            raise failure
        return trajectory

    @property
    def _sides(self) -> dict[str, sp.Expr]:
        """What tells whether a switching surface is a cut there, by the names of outputs."""
        sides = (cut.side for cut in self.cuts.values() if cut.side is not None)
        return {self._name(side): self._outward(side) for side in sides}

    def _name(self, side: Any) -> str:
        return self.namespace.read_condition(self._outward(side))[0]

    def _outward(self, expr: Any) -> sp.Expr:
        return self.namespace.equations.definition.bridge.outward(expr)

    def _first(self, found: Trajectory) -> tuple[Any, np.ndarray, AngleCut] | None:
        """When and where a motion first reaches a cut, and which."""
        hits = []
        for name, cut in self.cuts.items():
            side = "" if cut.side is None else self._name(cut.side)
            rows = found.events.get(name)  # none where a run failed before its first step
            if rows is not None:
                below = rows[side] < 0 if side else np.ones(len(rows), dtype=bool)
                pairs = zip(rows.t[below], rows.state[below], strict=True)
                hits += [(time, state, cut) for time, state in pairs]
        return min(hits, key=lambda hit: abs(hit[0] - found.t[0]), default=None)

    def _error(
        self, time: Any, state: np.ndarray, cut: AngleCut, before: Trajectory
    ) -> IntegrationError:
        """The error of a motion that reaches a cut, and the part ``before``."""
        reason = f"{cut.place} has an angle that jumps where {cut}, and velocities would with it"
        return IntegrationError(
            f"system '{self.namespace.equations.system.name}': {reason}, at t = "
            f"{float(time):.12g}; end the run before that, or give what the motion feels of the "
            "angle, its slopes, as forces",
            time,
            state,
            replace(before, halted=reason),
        )
