"""What carries the motions of an ensemble, block by block: in this process, or in several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from voronec.errors import IntegrationError, VoronecError
from voronec.motion.batches import Lanes, Look, StopRequest, along
from voronec.motion.methods import METHODS
from voronec.motion.motion_pool import Drifts, Many
from voronec.motion.one_by_one import LoneMotions, LoneStart, along_one, states_along
from voronec.motion.steppers import OwnedSamples, by_owner
from voronec.motion.tolerances import FINEST
from voronec.motion.trajectory import Trajectory
from voronec.motion.verify import CheckOfMany

TOGETHER = 64
"""So many motions of a compiled loop go together: they are looked at together."""


@dataclass(frozen=True, eq=False)
class MotionBlock:
    """Motions that go together: their ``numbers`` (m,), states (m, n) and parameters (m, p)."""

    numbers: np.ndarray
    states: np.ndarray
    values: np.ndarray

    @classmethod
    def of(cls, motions: Many, numbers: np.ndarray) -> MotionBlock:
        """Some of the motions."""
        return cls(numbers, motions.states[numbers], motions.values[numbers])


@dataclass(frozen=True, eq=False)
class CarriedBlock:
    """What came of the first motions (m,) of a block: outputs (m, k) and drifts (m,) by name, and
    by position errors, notes, and which are to go ``alone`` once more."""

    series: Mapping[str, np.ndarray]
    drift: Mapping[str, np.ndarray]
    errors: Mapping[int, IntegrationError]
    notes: Mapping[int, tuple[str, ...]]
    alone: Sequence[int]
    steps: int


@dataclass(eq=False)
class Carrier:
    """All that motions of one program have in common.

    ``motions`` is one of them; ``lanes`` carry many at once, else they go one by one by a
    ``method``; ``lone`` carries those that go alone.
    """

    motions: Many
    lone: LoneMotions
    grid: np.ndarray
    outputs: tuple[str, ...]
    keys: Sequence[Any]
    tol: float
    lanes: Lanes | None
    method: str

    @property
    def finest(self) -> float:
        """The tolerance that the method takes."""
        return self.tol if self.lanes else max(self.tol, FINEST)

    @property
    def first(self) -> int:
        """How many motions go together at first."""
        if self.lanes is not None:
            return self.lanes.width
        return TOGETHER if METHODS[self.method].loop else 1

    @cached_property
    def drifts(self) -> Drifts:
        """How much integrals change."""
        return Drifts(self.motions, self.finest)

    @cached_property
    def check(self) -> CheckOfMany:
        """Whether motions went well."""
        return CheckOfMany(
            self.motions.namespace.equations,
            self.motions.program,
            self.finest,
            {name: f"integral {name}" for name in self.motions.ground.integrals},
        )

    def __getstate__(self) -> dict[str, Any]:
        """As it was made: what was compiled since does not go to other processes."""
        motions, lanes = replace(self.motions), self.lanes
        if lanes is not None:
            lanes = replace(lanes, raised=replace(lanes.raised), output=None, samples=[])
        stripped = {"motions": motions, "lanes": lanes, "lone": replace(self.lone, motions=motions)}
        return {f.name: getattr(self, f.name) for f in fields(self)} | stripped

    def __call__(self, task: MotionBlock | LoneStart) -> CarriedBlock | Trajectory | VoronecError:
        """What came of a block, or of a motion alone."""
        return self.carry(task) if isinstance(task, MotionBlock) else self.carry_alone(task)

    def carry_alone(self, start: LoneStart) -> Trajectory | VoronecError:
        """A motion as ``integrate`` makes it, or its error."""
        try:
            return self.lone.run(start, self.grid, self.keys)
        except VoronecError as error:
            return error

    def carry(self, block: MotionBlock, stopped: Look = lambda: False) -> CarriedBlock:
        """A block of motions, or its first ones where somebody asked to stop."""
        loads = list[_Load]()
        alone, steps, done = list[int](), 0, 0
        width = self.lanes.most if self.lanes else 1
        try:
            for i in range(0, len(block.numbers), width):
                part = slice(i, i + width)
                load, taken, doubtful = self._load(block.states[part], block.values[part], stopped)
                alone += [i + k for k in doubtful]
                loads.append(load)
                steps, done = steps + taken, done + len(load[0])
        except StopRequest:
            pass
        return self._look_at(loads, block.values[:done], alone, steps)

    def _load(
        self, states: np.ndarray, values: np.ndarray, stopped: Look
    ) -> tuple[_Load, int, Sequence[int]]:
        """Some motions together, how many steps they took, and which are to go alone."""
        if self.lanes is not None:
            rows, failed, steps, near, samples = along(
                self.lanes, states, values, self.grid, stopped
            )
            return (rows, failed, samples), steps, near
        run, error, short = along_one(
            self.method, self.motions.program, states[0], values[0], self.grid, self.tol,
            self.motions.divisor_watch(values[0]),
        )  # fmt: skip
        failed, rows = {} if error is None else {0: error}, states_along(run, self.grid)[None]
        return (rows, failed, by_owner(run.samples)), run.steps, [0] if short else []

    def _look_at(
        self, loads: list[_Load], values: np.ndarray, alone: list[int], steps: int
    ) -> CarriedBlock:
        """The outputs of what is done, after a look at whether it went well."""
        if not loads:
            return CarriedBlock({}, {}, {}, {}, (), steps)
        rows, grid = np.concatenate([load[0] for load in loads]), self.grid
        failed, samples, at = dict[int, IntegrationError](), list[OwnedSamples](), 0
        for load, errors, parts in loads:
            failed |= {at + i: error for i, error in errors.items()}
            samples += [(at + indices, part) for indices, part in parts]
            at += len(load)
        quantities = self.motions.quantities_along(grid, rows, values)
        breaches, notes = self.check.breaches(
            grid, rows, values, steps / len(rows), samples, quantities
        )
        for i, breach in breaches.items():
            time, state = breach.last or (float(grid[breach.row]), rows[i, breach.row].copy())
            failed[i] = IntegrationError(f"{breach.what} after t = {time:.12g}", time, state)
            rows[i, breach.row + 1 :] = np.nan
        # followed once more by ``integrate``, which tells what a pole leaves open
        alone += np.flatnonzero(self.motions.across_poles(rows)).tolist()
        if breaches:
            quantities = self.motions.quantities_along(grid, rows, values)
        series = {name: quantities[name] for name in self.outputs}
        drift = self.drifts.along(grid, rows, values, quantities)
        return CarriedBlock(series, drift, failed, notes, alone, steps)


_Load = tuple[np.ndarray, Mapping[int, IntegrationError], Sequence[OwnedSamples]]
"""States of motions along the grid, what failed, and samples of steps, by their place here."""
