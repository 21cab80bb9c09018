"""The poles of Euler's angles, watched by a run in coordinates that are singular there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.verdicts import all_vanish
from voronec.equations.attitudes import EulerAngles, angles_without_chart, euler_angles
from voronec.equations.program import Program, compile_program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import IntegrationError
from voronec.motion.events import Event
from voronec.motion.numeric_model import ProgrammedModel
from voronec.motion.state_probe import quantities, quiet
from voronec.motion.steppers import Halt, Problem, Run

__all__ = ["LAST", "NearPole", "PoleGuard"]

POLE = "a pole of the angles is near"
"""Begins the names of the events, one for each body."""
LAST = se.Rational(1, 10**6)
"""No run passes a pole nearer than this in coordinates that are singular there: what is lost in
digits is the inverse of such a number."""
BEYOND = f"the motion comes within {float(LAST):g} of a pole of its angles, where no chart leads on"
LARGE = 1e12
"""Rates beyond this, for a state of ordinary size, are a division by zero."""


class NearPole(IntegrationError):
    """A motion has come, or starts, near a pole of angles at which its equations are singular."""


@dataclass(frozen=True)
class PoleGuard:
    """Stops a run where one of ``levels``, functions on its model by name, is no longer positive:
    so ``near`` to a pole is the sine of a polar angle."""

    name: str
    program: Program
    levels: Mapping[str, Any]
    functions: Mapping[str, Any]
    form: Any
    near: Any

    @classmethod
    def of(
        cls,
        equations: VoronecEquations,
        made: ProgrammedModel,
        start: np.ndarray,
        constants: Mapping[str, float],
        time: float,
        near: Any,
        charts: bool,
    ) -> PoleGuard | None:
        """None where no equation of the model is singular at a pole, but where ``charts`` lead on.

        ``start`` (n,) is on the coordinates.
        """
        levels = [
            _distance(equations, made, angles)
            for angles in (angles_without_chart if charts else euler_angles)(equations)
            if _is_singular(equations, made, angles, start, constants, time)
        ]
        # not their product, which is positive where two bodies are at poles at once
        found = {f"{POLE} {i}": d - near**2 for i, d in enumerate(levels) if d is not None}
        if not found:
            return None
        return cls(
            equations.system.name, made.program, found, made.event_functions, made.form, near
        )

    def check(self, state: np.ndarray, values: Sequence[float], time: float) -> None:
        """Raise an error for a start that is near one: ``NearPole`` where charts are still to be
        tried."""
        program = quantities(self.form, self.levels)
        own = dict(zip(map(str, self.program.parameters), values, strict=True))
        given = [own[str(p)] for p in program.parameters]
        if all(value > 0 for value in quiet(compile_program(program)[1], given)(time, list(state))):
            return
        if self.near != LAST:
            raise self._near(time, state)
        raise IntegrationError(
            f"system '{self.name}': {BEYOND}, at the initial point; start elsewhere", time, state
        )

    def watch(self, problem: Problem, grid: np.ndarray) -> Problem:
        """The problem, with the poles among its events."""
        order = 1 if grid[-1] >= grid[0] else -1
        return replace(
            problem,
            events=(*problem.events, *(Event(n, n, -order, stop=True) for n in self.levels)),
            levels=quantities(self.form, {**self.functions, **self.levels}),
            coarse=problem.coarse | self.levels.keys(),
        )

    def without_poles(self, run: Run) -> Run:
        """The run as if nobody had watched; raises ``NearPole`` where it has come near one, and
        charts are still to be tried."""
        names = {*self.levels}
        if run.stopped not in names:
            return run.without(names)
        if self.near != LAST:
            raise self._near(run.t[-1], run.states[-1])
        halt = Halt(BEYOND, run.t[-1], run.states[-1])
        return replace(run.without(names), stopped="", halt=halt)

    def _near(self, time: float, state: np.ndarray) -> NearPole:
        return NearPole(
            f"system '{self.name}': the motion comes near a pole of its angles at t = {time:.12g}",
            time,
            state,
        )


def _distance(
    equations: VoronecEquations, made: ProgrammedModel, angles: EulerAngles
) -> Any | None:
    """The square of the sine that vanishes at the poles, on a model; None where it has none."""
    variables = {*made.program.state, *made.program.parameters}
    if angles.theta in variables:
        return angles.singular**2
    cosine = se.cos(angles.theta + angles.shift)
    for name, g in equations.system.invariants.items():
        own, symbol = equations.door.inward(g), se.Symbol(name)
        alone = own.free_symbols == {angles.theta}
        if symbol in variables and alone and all_vanish([own**2 - cosine**2]):
            return 1 - symbol**2
    return None


def _is_singular(
    equations: VoronecEquations,
    made: ProgrammedModel,
    angles: EulerAngles,
    start: np.ndarray,
    constants: Mapping[str, float],
    time: float,
) -> bool:
    """Whether rates of a model are infinite at a pole, for a state that is arbitrary else."""
    if not {*map(str, angles.symbols)} & {*map(str, made.program.state)}:
        return False
    state = np.random.default_rng(0).uniform(0.5, 1.5, len(start))
    state[equations.definition.coordinates.index(angles.theta)] = -float(angles.shift)
    model, values = made.place(state, constants, time)
    rates = quiet(compile_program(made.program)[0], values)(time, list(model))
    sizes = np.abs(np.array(rates, dtype=float))
    return bool((~(sizes < LARGE)).any())
