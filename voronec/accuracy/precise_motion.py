"""Motions in many digits, and how much they magnify relative changes: their condition numbers.

With Phi(t, s) the propagator of the variational equations, o an output, p the parameters,

    kappa(t) = 1 + sum_p |do(t)/dp| |p| / |o|
                 + max over s <= t of sum_i |do(t)/dx (t) Phi(t, s)|_i X_i / |o|.

The first sum is of what an error of the parameters does, the second of what an error made at any
time s on the way does: rounding errors are made all along, not only in the initial data.  |o| is
the largest value of the output along the motion.  X_i is the size of a state: an angle's largest
value, but at least one radian; for other coordinates, and for velocities, the largest of them all.
An angle is what occurs under a sine or a cosine.

heyoka solves the problem in many digits with its variational equations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np

from voronec.accuracy.problem import DIGITS, ProblemFormulation
from voronec.accuracy.solution import output_sizes
from voronec.equations.program import taylor_extras, taylor_system
from voronec.errors import EngineLimit, IntegrationError
from voronec.motion.steppers import heyoka


def sizes(problem: ProblemFormulation, states: np.ndarray) -> np.ndarray:
    """X_i of the kept states (k, n): see the module; shape (n,)."""
    largest = np.abs(states.astype(float)).max(axis=0)
    coordinates = len(problem.program.coordinates)
    angle = np.array([i in problem.angle_places for i in problem.places])
    moving = np.array([i >= coordinates for i in problem.places])
    result = np.maximum(largest, 1.0)
    for group in (moving, ~moving & ~angle):
        if group.any():
            result[group] = largest[group].max() or 1.0
    return result


def condition_numbers(problem: ProblemFormulation, passage: PreciseMotion) -> np.ndarray:
    """kappa of every output at every instant of a passage; shape (k, m)."""
    scale = output_sizes(passage.outputs)
    size = sizes(problem, passage.states)
    constants = np.abs(np.array([float(x) for x in problem.values]))
    count, width = passage.outputs.shape
    drift = np.zeros((passage.states.shape[1], len(constants)), dtype=object)
    result = np.empty((count, width))
    for j in range(count):
        if j:
            drift = times(passage.steps[j - 1], drift) + passage.drives[j - 1]
        slopes = times(passage.gradients[j], drift) + passage.by_parameters[j]
        data = np.abs(slopes.astype(float)) @ constants
        result[j] = 1.0 + (data + _error_growth(passage, j, size)) / scale
    return result


def _error_growth(passage: PreciseMotion, j: int, size: np.ndarray) -> np.ndarray:
    """What an error made at the worst instant up to the j-th does to the outputs there."""
    reach = passage.gradients[j]
    worst = np.abs(reach.astype(float)) @ size
    for step in passage.steps[:j][::-1]:
        reach = times(reach, step)
        worst = np.maximum(worst, np.abs(reach.astype(float)) @ size)
    return worst


def times(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """A product of matrices of many digits."""
    if right.shape[1] == 0:
        return np.zeros((left.shape[0], 0), dtype=object)
    return left.astype(object) @ right.astype(object)


STEPS = 4000
"""Taylor steps between two looks at the keyboard; a span that gets nowhere in these has a pole."""
LEAST = 1e-3
"""The part of what is left that so many steps must cover."""
LONG_DOUBLE, QUADRUPLE = 1e-19, 1e-33
"""The finest tolerances of extended and of quadruple precision."""
GUARD_BITS = 24
"""Bits kept beyond those of the tolerance."""


@dataclass(frozen=True)
class PreciseMotion:
    """A motion in many digits at ``t`` (k,), with the propagators from each instant to the next.

    ``states`` (k, n) and ``outputs`` (k, m); ``gradients`` (k, m, n) and ``by_parameters``
    (k, m, p), what the outputs hold of the state and of the parameters themselves; ``steps``
    (k - 1, n, n) and ``drives`` (k - 1, n, p), d state(next) / d state and / d parameters at the
    instant.  All are arrays of objects with as many digits as the arithmetic has.  Without
    propagators the last two are empty.
    """

    t: np.ndarray
    states: np.ndarray
    outputs: np.ndarray
    gradients: np.ndarray
    by_parameters: np.ndarray
    steps: np.ndarray
    drives: np.ndarray


@dataclass(frozen=True)
class PreciseIntegrator:
    """A compiled integrator of one problem in many digits, and its compiled outputs.

    ``number`` turns a number into the arithmetic's; ``rewind(t, state)`` starts over, ``begin`` the
    state of the problem; ``advance(t)`` goes on and returns the state and the propagators since
    the last ``forget()``; ``look(state)`` returns outputs, and their slopes by states and
    parameters.
    """

    number: Callable[[Any], Any]
    rewind: Callable[[Any, Any], None]
    advance: Callable[[Any], tuple[np.ndarray, np.ndarray, np.ndarray]]
    forget: Callable[[], None]
    look: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
    begin: np.ndarray

    def follow(self, grid: np.ndarray, state: np.ndarray | None = None) -> PreciseMotion:
        """The motion along a grid, starting on its first instant."""
        start = self.begin if state is None else state
        self.rewind(self.number(grid[0]), start)
        states, steps, drives, looks = [start], [], [], [self.look(start)]
        for t in grid[1:]:
            self.forget()
            state, step, drive = self.advance(self.number(t))
            states.append(state)
            steps.append(step)
            drives.append(drive)
            looks.append(self.look(state))
        outputs, gradients, by_parameters = (
            np.array(part, dtype=object) for part in zip(*looks, strict=True)
        )
        return PreciseMotion(
            grid, np.array(states, dtype=object), outputs, gradients, by_parameters,
            np.array(steps, dtype=object), np.array(drives, dtype=object),
        )  # fmt: skip


@dataclass(frozen=True)
class _Arithmetic:
    """Numbers of heyoka's that hold a tolerance: their type, how one is made, their bits."""

    kind: Any
    number: Callable[[Any], Any]
    bits: int | None = None

    @classmethod
    def of(cls, hy: Any, tol: float) -> _Arithmetic:
        """Extended down to a tolerance of 1e-19, quadruple to 1e-33, arbitrary below."""
        kind, bits = np.longdouble, None
        if tol < LONG_DOUBLE:
            kind = hy.real128
        if tol < QUADRUPLE:
            kind, bits = hy.real, int(GUARD_BITS - np.log2(tol))
        more = () if bits is None else (bits,)

        def number(value: Any) -> Any:
            if isinstance(value, mpmath.mpf):
                with mpmath.workdps(DIGITS):
                    return kind(mpmath.nstr(value, DIGITS, strip_zeros=False), *more)
            plain = isinstance(value, float | int | str | np.longdouble)
            return kind(value, *more) if plain else value

        return cls(kind, number, bits)

    @property
    def options(self) -> dict[str, Any]:
        """What heyoka's functions are told of it."""
        return {"fp_type": self.kind} | ({} if self.bits is None else {"prec": self.bits})


def precise_integrator(
    problem: ProblemFormulation, tol: float, varied: bool = True
) -> PreciseIntegrator:
    """The problem ready to run at a tolerance, in an arithmetic that holds it.

    Without ``varied`` there are no propagators, and a run is many times faster.  Raises
    ``EngineLimit`` where heyoka is not installed.
    """
    try:
        hy = heyoka()
    except ImportError:
        raise EngineLimit(
            f"system '{problem.problem.system.name}': a reference in many digits takes heyoka, "
            "which is not installed; 'pip install heyoka'"
        ) from None
    numbers = _Arithmetic.of(hy, tol)
    pairs = taylor_system(problem.program, number=numbers.number)
    kept = [pairs[i] for i in problem.places]
    variables = [v for v, _ in kept]
    acting = sorted({i for _, rhs in kept for i in _indices(hy, rhs)})
    by = [*variables, *(hy.par[i] for i in acting)]
    begin = np.array([numbers.number(problem.start[i]) for i in problem.places], dtype=object)
    values = np.array([numbers.number(x) for x in problem.values], dtype=numbers.kind)
    integrator = hy.taylor_adaptive(
        hy.var_ode_sys(kept, by, order=1) if varied else kept,
        begin.tolist(),
        pars=values[: max(acting, default=-1) + 1].tolist(),
        tol=numbers.number(tol),
        compact_mode=True,
        **numbers.options,
    )
    return PreciseIntegrator(
        numbers.number,
        *_integrator_functions(
            integrator, numbers, len(kept), acting if varied else None, len(values)
        ),
        _output_function(hy, numbers, problem, variables, values),
        begin,
    )


def _integrator_functions(
    integrator: Any, numbers: _Arithmetic, size: int, acting: list[int] | None, count: int
) -> tuple[Callable[..., None], Callable[..., Any], Callable[[], None]]:
    """``rewind``, ``advance`` and ``forget`` of an integrator; ``acting`` are the parameters by
    which it varies the motion, None where it does not."""
    rows, columns = (0, 0) if acting is None else (size, size + len(acting))
    kind, number = numbers.kind, numbers.number
    fresh = np.array([number(int(i == j)) for i in range(rows) for j in range(columns)], dtype=kind)

    def rewind(t: Any, state: Any) -> None:
        integrator.time = t
        integrator.state[:size] = np.array(list(state), dtype=kind)
        forget()

    def forget() -> None:
        integrator.state[size:] = fresh

    def advance(t: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        _propagate(integrator, t, size)
        slopes = integrator.state[size:].astype(object).reshape(rows, columns)
        drives = np.zeros((rows, count), dtype=object)
        if acting:
            drives[:, acting] = slopes[:, size:]
        return integrator.state[:size].astype(object), slopes[:, :size], drives

    return rewind, advance, forget


def _propagate(integrator: Any, t: Any, size: int) -> None:
    """On to a time; ``IntegrationError`` where the steps shrink to nothing."""
    import heyoka as hy

    outcome, moving = hy.taylor_outcome.step_limit, True
    while outcome == hy.taylor_outcome.step_limit and moving:
        before = integrator.time
        outcome = integrator.propagate_until(t, max_steps=STEPS)[0]
        moving = float(integrator.time - before) > LEAST * abs(float(t - before))
    if outcome != hy.taylor_outcome.time_limit:
        raise IntegrationError(
            f"the reference broke down at t = {float(integrator.time):.12g}",
            float(integrator.time),
            integrator.state[:size].astype(float),
        )


def _indices(hy: Any, expr: Any) -> list[int]:
    """Which parameters par[i] an expression holds; heyoka calls them ``p0, p1, ...``."""
    return [int(str(p).removeprefix("p")) for p in hy.get_params(expr)]


def _output_function(
    hy: Any,
    numbers: _Arithmetic,
    problem: ProblemFormulation,
    variables: list[Any],
    values: np.ndarray,
) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Outputs, their slopes by the kept states, and by the parameters, at a state."""
    outputs = list(taylor_extras(problem.program, number=numbers.number).values())
    size, count = len(variables), len(values)
    by = [*variables, *(hy.par[i] for i in range(count))]
    slopes = [hy.diff(o, x) for o in outputs for x in by]
    every = [*outputs, *slopes]
    used = max((i + 1 for e in every for i in _indices(hy, e)), default=0)
    function = hy.cfunc(every, vars=variables, **numbers.options)

    def look(state: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        point = np.array(list(state), dtype=numbers.kind)
        entries = function(point, pars=values[:used]) if used else function(point)
        entries = entries.astype(object)
        table = entries[len(outputs) :].reshape(len(outputs), size + count)
        return entries[: len(outputs)], table[:, :size], table[:, size:]

    return look
