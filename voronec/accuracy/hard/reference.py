"""What the outputs of a case truly are, and its condition numbers.

The cases of this package have their references beside them in ``references.json``, each under a
digest of its declaration, so that nobody waits for them; others are computed on the spot.  A
reference is computed twice: by two forms of the equations, or on one at two tolerances, in many
digits; the largest difference of the two runs is kept as its accuracy.

Of a motion of period P one period is computed and the rest counted: x(n P + t) = x(t) and
Phi(n P + t, 0) = Phi(t, 0) Phi(P, 0)^n.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from voronec.accuracy.hard.case import ARITHMETICS, HardCase, case_formulation
from voronec.accuracy.precise_motion import (
    PreciseIntegrator,
    PreciseMotion,
    condition_numbers,
    precise_integrator,
    sizes,
    times,
)
from voronec.accuracy.problem import ProblemFormulation
from voronec.accuracy.reference import closed_form_values, taylor_values
from voronec.accuracy.solution import ReferenceSolution, agreement, output_sizes
from voronec.declaration.catalogue import load
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, IntegrationError
from voronec.motion import Trajectory, integrate
from voronec.motion.methods import METHODS

RETURN = 1e-18
"""How far the state may be from its start after one period."""
ITERATIONS = 12
"""Of Newton's method, which doubles digits: more are wanted where there is no period."""
LOOKS = 400
"""Into how many parts a stretch of time is cut where the period is looked for."""


def period(
    machine: PreciseIntegrator, names: tuple[str, ...], vanishing: str, segment: float
) -> Any:
    """A period, when every state is back; one must be shorter than ``stretch``.

    ``vanishing`` is the state that vanishes at the start; its zeros are refined by Newton's method.
    Raises ``IntegrationError`` where there is none.
    """
    place = names.index(vanishing)
    machine.rewind(machine.number(0.0), machine.begin)
    before, last = machine.begin, 0.0
    for t in np.linspace(0.0, segment, LOOKS + 1)[1:]:
        state, _, _ = machine.advance(machine.number(t))
        if last > 0 and float(before[place]) * float(state[place]) <= 0:
            zero, there = _zero(machine, place, machine.number(last), before)
            apart = (abs(float(a - b)) for a, b in zip(there, machine.begin, strict=True))
            if max(apart) < RETURN:
                return zero
            machine.rewind(machine.number(t), state)
        before, last = state, t
    raise IntegrationError(f"no period was found up to t = {segment:g}")


def _zero(
    machine: PreciseIntegrator, place: int, t: Any, state: np.ndarray
) -> tuple[Any, np.ndarray]:
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

    def condition_numbers(self, problem: ProblemFormulation) -> np.ndarray:
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


def fold(machine: PreciseIntegrator, length: Any, grid: np.ndarray) -> OnePeriod:
    """One period through all that is left of the wanted times when whole periods are taken off."""
    turns = [int(float(t) // float(length)) for t in grid]
    rest = [machine.number(float(t)) - n * length for t, n in zip(grid, turns, strict=True)]
    stops: list[Any] = []  # numbers of heyoka have an order, but no hash
    for t in sorted([machine.number(0.0), *rest, length]):
        stops += [] if stops and stops[-1] == t else [t]
    passage = machine.follow(np.array(stops, dtype=object))
    return OnePeriod(passage, tuple(turns), tuple(stops.index(t) for t in rest))


def _since_start(passage: PreciseMotion) -> list[np.ndarray]:
    """d (state, parameters) at every instant / d the same at the start."""
    n, p = passage.states.shape[1], passage.drives.shape[2]
    transitions = [np.eye(n + p, dtype=int).astype(object)]
    for step, drive in zip(passage.steps, passage.drives, strict=True):
        whole = np.eye(n + p, dtype=int).astype(object)
        whole[:n, :n], whole[:n, n:] = step, drive
        transitions.append(times(whole, transitions[-1]))
    return transitions


STORE = Path(__file__).with_name("references.json")
TOLERANCES = {"quadruple": (1e-30, 1e-27), "extended": (3e-19, 1e-17)}
"""Of the first run, and of the second."""
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
    references: dict[str, Any] = json.loads(STORE.read_text("utf-8")) if STORE.exists() else {}
    return references


def compute(case: HardCase, equations: VoronecEquations | None = None) -> ReferenceSolution:
    """The reference of a case by two runs in many digits, and its condition numbers."""
    equations = equations or derive(load(case.system))
    asked = case_formulation(case, equations)
    if METHODS["heyoka"].absence:
        return changed_data_reference(case, equations)
    outputs, condition = _first_run(case, asked)
    names = asked.program.names
    name = f"{ARITHMETICS[case.arithmetic]} digits on {case.formulation}"
    first = (name, _by_name(asked, outputs))
    solution = _agreement(case, first, _second_run(case, equations, asked))
    return replace(solution, condition=dict(zip(names, condition.T, strict=True)))


def _agreement(
    case: HardCase,
    first: tuple[str, Mapping[str, np.ndarray]],
    second: tuple[str, Mapping[str, np.ndarray]],
) -> ReferenceSolution:
    """The reference of two runs by name; how far they agree is judged by the condition later."""
    solution = agreement(case.grid, [first, second])
    if solution is None or len(solution.t) < case.points:
        raise IntegrationError(
            f"hard case '{case.name}': a run in many digits ends in what is no number, so there is "
            "no reference; take a shorter span"
        )
    return solution


def _by_name(asked: ProblemFormulation, outputs: np.ndarray) -> dict[str, np.ndarray]:
    """Outputs (k, m) by name."""
    return dict(zip(asked.program.names, outputs.T, strict=True))


def _first_run(case: HardCase, asked: ProblemFormulation) -> tuple[np.ndarray, np.ndarray]:
    """Outputs (k, m) and condition numbers (k, m)."""
    tol = TOLERANCES[case.arithmetic][0]
    machine = precise_integrator(asked, tol)
    if not case.period:
        passage = machine.follow(case.grid)
        return passage.outputs, condition_numbers(asked, passage)
    whole = fold(machine, _case_period(case, asked, tol)[1], case.grid)
    return whole.outputs, whole.condition_numbers(asked)


def _case_period(
    case: HardCase, asked: ProblemFormulation, tol: float
) -> tuple[PreciseIntegrator, Any]:
    """What follows the motion without its variations, and its period."""
    single = precise_integrator(asked, tol, varied=False)
    return single, period(single, asked.names, case.period, float(case.scene.times[1]) / 100)


def _second_run(
    case: HardCase, equations: VoronecEquations, asked: ProblemFormulation
) -> tuple[str, Mapping[str, np.ndarray]]:
    """How the outputs are computed once more, as independently as may be, and the outputs."""
    tol = TOLERANCES[case.arithmetic][1]
    if case.period and float(case.scene.times[1]) > LONGEST_CHECK:
        single, length = _case_period(case, asked, tol)
        folded = fold(single, length, case.grid).outputs
        return "one period at two tolerances", _by_name(asked, folded)
    if case.period:
        values = taylor_values(asked, TOLERANCES["extended"][0])
        return "one period against the whole span", values
    if equations.system.motion is not None:
        with suppress(EngineLimit, IntegrationError):
            return "against the closed form", closed_form_values(asked.problem)
    raw = case.formulation == "coordinates"
    with suppress(IntegrationError):  # a pole on the way: then at another tolerance
        values = taylor_values(
            case_formulation(replace(case, formulation="coordinates"), equations, raw), tol
        )
        if all(np.isfinite(x.astype(float)).all() for x in values.values()):
            return f"against the {'unsimplified ' if raw else ''}equations on coordinates", values
    return "against another tolerance", taylor_values(asked, tol)


CHANGE = 1e-12
"""By what part of its size a datum is changed, either way: 25 digits leave 13 of the slope."""


def changed_data_reference(case: HardCase, equations: VoronecEquations) -> ReferenceSolution:
    """The reference of a case without heyoka: condition numbers come of slightly changed data.

    Errors of the data alone are seen so, not those made on the way: the condition numbers come out
    lower, and the judgement stricter.  Raises ``EngineLimit`` for a case whose reference lies on
    the invariants, or counts periods.
    """
    if case.formulation != "coordinates" or case.period:
        raise EngineLimit(
            f"hard case '{case.name}' has no stored reference, and computing one takes heyoka, "
            "which is not installed; 'pip install heyoka'"
        )
    asked = case_formulation(case, equations)

    def run(tol: float, **changed: Any) -> Trajectory:
        return integrate(
            equations, scene=case.scene, times=case.grid, method="flint", tol=tol, **changed
        )

    first, second = ({n: one[n] for n in one.outputs} for one in (run(tol=1e-25), run(tol=1e-21)))
    how = "against 21 digits, data changed in place of variations"
    solution = _agreement(case, ("25 digits on coordinates", first), (how, second))
    weights = _weights(asked, run(tol=1e-21, outputs=asked.names))
    condition = {n: np.ones(len(case.grid)) for n in first}
    for kind, data in (
        ("initial", _pairs(asked.program.state, asked.start)),
        ("parameters", _pairs(asked.program.parameters, asked.values)),
    ):
        for name, datum in data:
            if str(name) not in weights:
                continue
            step = CHANGE * max(1.0, abs(float(datum)))
            ahead, behind = (
                run(tol=1e-25, **{kind: {str(name): x}}) for x in (datum + step, datum - step)
            )
            for n, values in solution.values.items():
                slope = np.asarray((ahead[n] - behind[n]) / (2 * step), dtype=float)
                condition[n] += np.abs(slope) * weights[str(name)] / output_sizes(values)
    return replace(solution, condition=condition)


def _weights(asked: ProblemFormulation, run: Trajectory) -> dict[str, float]:
    """The sizes of what may be in error: states that the outputs need, and parameters."""
    states = np.column_stack([run[name] for name in asked.names])
    weights = dict(zip(asked.names, sizes(asked, states).tolist(), strict=True))
    parameters = zip(asked.program.parameters, asked.values, strict=True)
    return weights | {str(p): abs(float(x)) for p, x in parameters}


def _pairs(symbols: Iterable[Any], numbers: Iterable[Any]) -> list[tuple[Any, Any]]:
    """Symbols with their numbers, as exact as SymPy holds them."""
    import sympy as sp

    return [(s, sp.Float(x, 40)) for s, x in zip(symbols, numbers, strict=True)]
