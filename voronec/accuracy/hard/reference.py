"""What the outputs of a case truly are, and its condition numbers.

The cases of this package have their references beside them in ``references.json``, each under a
digest of its declaration, so that nobody waits for them; others are computed on the spot.  A
reference is computed twice: by two forms of the equations, or on one at two tolerances, in many
digits; the largest difference of the two runs is kept as its accuracy.

Where heyoka is not installed, and as an independent check, condition numbers come of many digits
and slightly different data.  Only errors of the data are seen so, not those made on the way: the
condition numbers come out lower, and the judgement stricter.  Of a motion of period P one period is
computed and the rest counted: x(n P + t) = x(t) and Phi(n P + t, 0) = Phi(t, 0) Phi(P, 0)^n.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cache
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from voronec.accuracy.hard.case import ARITHMETICS, HardCase, case_level
from voronec.accuracy.hard.conditioning import (
    PreciseMotion,
    Reel,
    condition_numbers,
    reel,
    sizes,
    times,
)
from voronec.accuracy.problem import ProblemLevel
from voronec.accuracy.reference import ReferenceSolution, difference, output_sizes
from voronec.declaration.catalogue import load
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, IntegrationError
from voronec.motion import Trajectory, integrate
from voronec.motion.closed_form import closed_form

__all__ = [
    "STORE",
    "closed_form_outputs",
    "compute",
    "perturb",
    "reference",
    "slopes",
]

RETURN = 1e-18
"""How far the state may be from its start after one period."""
ITERATIONS = 12
"""Of Newton's method, which doubles digits: more are wanted where there is no period."""
LOOKS = 400
"""Into how many parts a stretch of time is cut where the period is looked for."""


def period(machine: Reel, names: tuple[str, ...], vanishing: str, stretch: float) -> Any:
    """A period, when every state is back; one must be shorter than ``stretch``.

    ``vanishing`` is the state that vanishes at the start; its zeros are refined by Newton's method.
    Raises ``IntegrationError`` where there is none.
    """
    place = names.index(vanishing)
    machine.rewind(machine.number(0.0), machine.begin)
    before, last = machine.begin, 0.0
    for t in np.linspace(0.0, stretch, LOOKS + 1)[1:]:
        state, _, _ = machine.advance(machine.number(t))
        if last > 0 and float(before[place]) * float(state[place]) <= 0:
            zero, there = _zero(machine, place, machine.number(last), before)
            apart = (abs(float(a - b)) for a, b in zip(there, machine.begin, strict=True))
            if max(apart) < RETURN:
                return zero
            machine.rewind(machine.number(t), state)
        before, last = state, t
    raise IntegrationError(f"no period was found up to t = {stretch:g}")


def _zero(machine: Reel, place: int, t: Any, state: np.ndarray) -> tuple[Any, np.ndarray]:
    """The next zero of a component after a time, and the state there."""
    ahead = machine.number(1e-9)
    for _ in range(ITERATIONS):
        machine.rewind(t, state)
        beyond, _, _ = machine.advance(t + ahead)
        change = -state[place] * ahead / (beyond[place] - state[place])
        if abs(float(change)) < 1e-29 * (1.0 + abs(float(t))):
            break
        machine.rewind(t, state)
        t = t + change
        state, _, _ = machine.advance(t)
    return t, state


@dataclass(frozen=True)
class OnePeriod:
    """One period of a motion, and where in which period the wanted instants lie.

    ``turns[j]`` whole periods lie before the j-th instant, and the rest of it is the time
    ``places[j]`` of ``passage``, which ends with the period.
    """

    passage: PreciseMotion
    turns: tuple[int, ...]
    places: tuple[int, ...]

    @property
    def outputs(self) -> np.ndarray:
        """The outputs at the wanted instants."""
        return self.passage.outputs[list(self.places)]

    def condition_numbers(self, problem: ProblemLevel) -> np.ndarray:
        """kappa as in ``conditioning``, errors made after 0, 1, 2, 4, ... and all periods."""
        passage, scale = self.passage, output_sizes(self.passage.outputs)
        size = sizes(problem, passage.states)
        constants = np.abs(np.array([float(x) for x in problem.values]))
        since = _since_start(passage)
        width = passage.states.shape[1]
        result = np.empty(self.outputs.shape)
        for j, (turns, place) in enumerate(zip(self.turns, self.places, strict=True)):
            whole = times(since[place], np.linalg.matrix_power(since[-1], turns))
            slope = times(passage.gradients[place], whole[:width, width:])
            slope = slope + passage.by_parameters[place]
            made = np.zeros(len(scale))
            for back in {0, *(2**i for i in range(turns.bit_length()) if 2**i <= turns), turns}:
                reach = times(since[place], np.linalg.matrix_power(since[-1], back))[:width, :width]
                reach = times(passage.gradients[place], reach)
                made = np.maximum(made, np.abs(reach.astype(float)) @ size)
            data = np.abs(slope.astype(float)) @ constants
            result[j] = 1.0 + (data + made) / scale
        return result


def fold(reel: Reel, length: Any, grid: np.ndarray) -> OnePeriod:
    """One period through all that is left of the wanted times when whole periods are taken off."""
    turns = [int(float(t) // float(length)) for t in grid]
    rest = [reel.number(float(t)) - n * length for t, n in zip(grid, turns, strict=True)]
    stops: list[Any] = []  # numbers of heyoka have an order, but no hash
    for t in sorted([reel.number(0.0), *rest, length]):
        stops += [] if stops and stops[-1] == t else [t]
    passage = reel.follow(np.array(stops, dtype=object))
    return OnePeriod(passage, tuple(turns), tuple(stops.index(t) for t in rest))


def _since_start(passage: PreciseMotion) -> list[np.ndarray]:
    """d (state, parameters) at every instant / d the same at the start."""
    n, p = passage.states.shape[1], passage.drives.shape[2]
    found = [np.eye(n + p, dtype=int).astype(object)]
    for step, drive in zip(passage.steps, passage.drives, strict=True):
        whole = np.eye(n + p, dtype=int).astype(object)
        whole[:n, :n], whole[:n, n:] = step, drive
        found.append(times(whole, found[-1]))
    return found


CHANGE = 1e-12
"""By what part of its size a datum is changed, either way: 25 digits leave 13 of the slope."""
DIGITS = (1e-25, 1e-21)
"""Tolerances of the run, and of the one that it is compared with."""


def perturb(
    case: HardCase, equations: VoronecEquations
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], float]:
    """Outputs, condition numbers, and how far two runs agree; raises ``EngineLimit`` for a case
    whose reference lies on the invariants, or counts periods."""
    if case.level != "coordinates" or case.period:
        raise EngineLimit(
            f"hard case '{case.name}' has no stored reference, and computing one takes heyoka, "
            "which is not installed; 'pip install heyoka'"
        )
    first, second = (_perturbed_run(case, equations, tol) for tol in DIGITS)
    values = {n: np.asarray(first[n], dtype=float) for n in first.outputs}
    size = {n: float(output_sizes(x[:, None])[0]) for n, x in values.items()}
    apart = max(float(difference(first[n], second[n]).max()) for n in values)
    asked = case_level(case, equations)
    condition = {n: np.ones_like(x) for n, x in values.items()}
    for by, weight in _weights(asked, case, equations).items():
        for n, slope in slopes(case, equations, by).items():
            condition[n] += np.abs(slope) * weight / size[n]
    return values, condition, apart


def slopes(case: HardCase, equations: VoronecEquations, by: str) -> dict[str, np.ndarray]:
    """d output / d datum at every instant; ``by`` names a coordinate, a velocity or a parameter."""
    asked = case_level(case, equations)
    data = _data(asked)
    step = CHANGE * max(1.0, abs(float(data[by])))
    kind = "parameters" if by in map(str, asked.program.parameters) else "initial"
    ahead, behind = (
        _perturbed_run(case, equations, DIGITS[0], **{kind: {by: x}})
        for x in (data[by] + step, data[by] - step)
    )
    return {n: np.asarray((ahead[n] - behind[n]) / (2 * step), dtype=float) for n in ahead.outputs}


def _data(asked: ProblemLevel) -> dict[str, Any]:
    """States at the start and parameters by name, as exact as SymPy holds them."""
    import sympy as sp

    names = [*map(str, asked.program.state), *map(str, asked.program.parameters)]
    numbers = [*asked.start, *asked.values]
    return {n: sp.Float(x, 40) for n, x in zip(names, numbers, strict=True)}


def _weights(asked: ProblemLevel, case: HardCase, equations: VoronecEquations) -> dict[str, float]:
    """The sizes of what may be in error: states that the outputs need, and parameters."""
    followed = integrate(equations, scene=case.scene, times=case.grid, outputs=asked.names)
    states = np.column_stack([followed[name] for name in asked.names])
    weights = dict(zip(asked.names, sizes(asked, states).tolist(), strict=True))
    data = _data(asked)
    return weights | {str(p): abs(float(data[str(p)])) for p in asked.program.parameters}


def _perturbed_run(
    case: HardCase, equations: VoronecEquations, tol: float, **data: Any
) -> Trajectory:
    return integrate(equations, scene=case.scene, times=case.grid, method="flint", tol=tol, **data)


STORE = Path(__file__).with_name("references.json")
TOLERANCES = {"quadruple": (1e-30, 1e-27), "extended": (3e-19, 1e-17)}
"""Of the first run, and of the second."""
IN_A_PERIOD = 20
"""At so many instants of a period an angle is looked at, to follow it."""
FOLLOWABLE = 4000
"""At so many instants at most."""
LONGEST_CHECK = 2e5
"""A periodic motion is followed to the end, as a check of its period, up to this span."""


def reference(case: HardCase, equations: VoronecEquations | None = None) -> ReferenceSolution:
    """The stored reference of a case; computed now where none is stored for its declaration.

    Raises ``EngineLimit`` where it must be computed and heyoka is not installed.
    """
    stored = _stored_references().get(case.name)
    if stored is not None and stored["digest"] == case.digest:
        return ReferenceSolution.from_dict(stored)
    return compute(case, equations)


@cache
def _stored_references() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
    return found


def compute(case: HardCase, equations: VoronecEquations | None = None) -> ReferenceSolution:
    """The reference of a case by two runs in many digits, and its condition numbers."""
    own = equations or derive(load(case.system))
    asked = case_level(case, own)
    try:
        outputs, condition = _run(case, asked)
        again, how = _again(case, own, asked)
    except ImportError:
        values, slopes, apart = perturb(case, own)
        how = "against 21 digits, data changed in place of variations"
        both = "25 digits on coordinates", how
        return ReferenceSolution(case.grid, values, apart, both, condition=slopes)
    names = asked.program.names
    return ReferenceSolution(
        case.grid,
        dict(zip(names, outputs.astype(float).T, strict=True)),
        float(difference(again, outputs).max()),
        (f"{ARITHMETICS[case.arithmetic]} digits on {case.level}", how),
        condition=dict(zip(names, condition.T, strict=True)),
    )


def _run(case: HardCase, asked: ProblemLevel) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (k, m) and condition numbers (k, m)."""
    tol = TOLERANCES[case.arithmetic][0]
    machine = reel(asked, case.arithmetic, tol)
    if not case.period:
        passage = machine.follow(case.grid)
        return passage.outputs, condition_numbers(asked, passage)
    whole = fold(machine, _case_period(case, asked, tol)[1], case.grid)
    return whole.outputs, whole.condition_numbers(asked)


def _case_period(case: HardCase, asked: ProblemLevel, tol: float) -> tuple[Reel, Any]:
    """What follows the motion without its variations, and its period."""
    single = reel(asked, case.arithmetic, tol, varied=False)
    return single, period(single, asked.names, case.period, float(case.scene.times[1]) / 100)


def _again(case: HardCase, own: VoronecEquations, asked: ProblemLevel) -> tuple[np.ndarray, str]:
    """The outputs once more, as independently as may be, and how."""
    if case.period and float(case.scene.times[1]) > LONGEST_CHECK:
        tol = TOLERANCES[case.arithmetic][1]
        single, length = _case_period(case, asked, tol)
        return fold(single, length, case.grid).outputs, "one period at two tolerances"
    if case.period:
        whole = reel(asked, "extended", TOLERANCES["extended"][0], varied=False)
        return whole.follow(case.grid).outputs, "one period against the whole span"
    found = closed_form_outputs(case, own, asked)
    if found is not None:
        return found, "against the closed form"
    tol = TOLERANCES[case.arithmetic][1]
    try:
        raw = case.level == "coordinates"
        other = case_level(replace(case, level="coordinates"), own, raw)
        found = reel(other, case.arithmetic, tol, varied=False).follow(case.grid).outputs
        if np.isfinite(found.astype(float)).all():
            return found, f"against the {'unsimplified ' if raw else ''}equations on coordinates"
    except IntegrationError:
        pass  # a pole on the way: then at another tolerance
    found = reel(asked, case.arithmetic, tol, varied=False).follow(case.grid).outputs
    return found, "against another tolerance"


def closed_form_outputs(
    case: HardCase, own: VoronecEquations, asked: ProblemLevel
) -> np.ndarray | None:
    """The outputs by the declared motion, where there is one that can be followed: where the vector
    in space is not upright, angles are continuous only on a fine grid."""
    if own.system.motion is None:
        return None
    try:
        form = closed_form(own, case.scene)
    except EngineLimit:
        return None
    finer = 1
    if form.attitude is not None and not form.attitude.upright:
        finer = ceil(IN_A_PERIOD * abs(case.grid[1] - case.grid[0]) / min(form.period, 1.0))
    if finer * len(case.grid) > FOLLOWABLE:
        return None
    steps = np.arange(finer * (len(case.grid) - 1) + 1)
    grid = np.interp(steps / finer, np.arange(len(case.grid)), case.grid)
    grid[::finer] = case.grid
    tol = TOLERANCES[case.arithmetic][0]
    seen = integrate(own, case.scene, times=grid, method="closed-form", tol=tol)
    return np.stack([seen[name][::finer] for name in asked.program.names], axis=-1)
