"""The variational equations of a program, compiled as one program with the motion.

    x' = f(x, t),   Y' = J(x, t) Y,   J = df/dx,   q' = tr J

The right side and the entries of its Jacobian share their subexpressions; DOP853 carries all three
and re-orthogonalises the columns of Y on the way [BenettinEtAl1980], in machine code where there is
a C compiler, else by scipy.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from voronec.dynamics.variational_source import ARRIVAL, LIMIT, NO_STEP, flow_source
from voronec.equations.program import (
    Block,
    HoistedProgram,
    Program,
    c_source,
    compile_program,
    hoist,
)
from voronec.equations.program.jacobian import joint_block
from voronec.errors import DefinitionError, IntegrationError
from voronec.motion.steppers import kept_library

EVERY = 4
"""So many steps go between two orthogonalisations: in one step a column grows by no more than some
powers of e, or the step were shorter."""
MOST = 200_000
"""Steps of one way; where more are needed they have collapsed at a singularity."""


@dataclass(eq=False)
class VariationalState:
    """Where a motion and its variations are: ``clock`` has the time, the next step and its growth;
    ``z`` the state, the integral of the divergence and the columns; ``logs`` (k,) the logarithms
    of all lengths that were taken out of the columns; ``counts`` steps and evaluations."""

    clock: np.ndarray
    z: np.ndarray
    units: np.ndarray
    logs: np.ndarray
    counts: np.ndarray

    @property
    def time(self) -> float:
        """The instant."""
        return float(self.clock[0])

    @property
    def x(self) -> np.ndarray:
        """The state (n,)."""
        return self.z[: len(self.units)]

    @property
    def divergence(self) -> float:
        """The integral of the divergence so far."""
        return float(self.z[len(self.units)])

    @property
    def columns(self) -> np.ndarray:
        """The columns Y (n, k)."""
        return self.z[len(self.units) + 1 :].reshape(len(self.units), -1)


@dataclass(frozen=True, eq=False)
class VariationalFlow:
    """The flow of a program with ``k`` of its variations, ready to run; ``places`` say which
    entries of the Jacobian are not zero.  ``compiled`` tells whether it is machine code."""

    program: Program
    k: int
    joint: HoistedProgram
    places: tuple[tuple[int, int], ...]
    drive: Callable[..., int]
    compiled: bool

    def start(
        self, x: Any, columns: Any = None, time: float = 0.0, units: Any = None
    ) -> VariationalState:
        """At a state (n,), with columns (n, k): unit vectors, in the ``units`` of the states (n,),
        where none are given."""
        n = len(self.program.state)
        sizes = np.ones(n) if units is None else np.asarray(units, dtype=float)
        given = np.diag(sizes)[:, : self.k] if columns is None else np.asarray(columns, float)
        z = np.concatenate([np.asarray(x, dtype=float), [0.0], given.ravel()])
        return VariationalState(
            np.array([time, 0.0, 0.0]), z, sizes, np.zeros(self.k), np.zeros(2, dtype=np.int64)
        )

    def go(
        self, state: VariationalState, end: float, values: Any, tol: float, every: int = 0,
        limit: int | None = None,
    ) -> bool:  # fmt: skip
        """Carry a state on to the instant ``end``, or by ``limit`` steps; whether it is there.

        ``values`` (p,) are the parameters; after ``every`` steps, and at the end, the columns are
        made orthonormal, never where it is 0.  ``IntegrationError`` where no step is short enough,
        or, without a limit, the end is not reached in very many.
        """
        known = np.array(self.joint.values([float(x) for x in values]), dtype=float)
        outcome = self.drive(state, known, end, tol, limit or MOST, every)
        lost = outcome == NO_STEP or (limit is None and outcome == LIMIT)
        if lost or not np.isfinite(state.z).all():
            raise self.failure(state)
        return outcome == ARRIVAL

    def failure(self, state: VariationalState) -> IntegrationError:
        """Why there is no way on."""
        return IntegrationError(
            f"the motion and its variations cannot be continued beyond t = {state.time:.6g}: the "
            f"variables {', '.join(map(str, self.program.state))} are singular there; name others, "
            "or start elsewhere", state.time, state.x.copy(),
        )  # fmt: skip

    def rates(self, x: Any, values: Any, time: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """The rates (n,) and their Jacobian (n, n) at a state."""
        n, known = len(self.program.state), self.joint.values([float(v) for v in values])
        outputs = _evaluator(self.joint.program)(time, [*map(float, x), *[0.0] * len(self.places)],
                                               known)  # fmt: skip
        matrix = np.zeros((n, n))
        for (i, j), entry in zip(self.places, outputs[n:], strict=True):
            matrix[i, j] = entry
        return np.array(outputs[:n], dtype=float), matrix


def _evaluator(program: Program) -> Callable[..., Any]:
    return compile_program(program, scalar=True)[0]


@lru_cache(maxsize=32)
def variational_flow(program: Program, k: int | None = None) -> VariationalFlow:
    """The flow of a program with k variations, by default as many as there are states.

    ``EngineLimit`` where a function of the program has no derivative.
    """
    both, places = joint_block(program, program.derivative, program.state)
    n, bare = len(program.state), replace(program, names=(), extras=Block((), ()))
    rates, slopes = (replace(both, results=part) for part in (both.results[:n], both.results[n:]))
    joint = hoist(replace(bare, derivative=rates).beside(slopes, "slope"))
    count = n if k is None else k
    try:
        drive, compiled = _compiled_drive(joint.program, n, count, places), True
    except DefinitionError:  # there is no compiler here
        drive, compiled = _drive_of_scipy(joint.program, n, count, places), False
    return VariationalFlow(program, count, joint, places, drive, compiled)


def _compiled_drive(
    program: Program, n: int, k: int, places: tuple[tuple[int, int], ...]
) -> Callable[..., int]:
    """The loop in machine code."""
    source = flow_source(c_source(program), n, k, places)
    library = kept_library(source, lambda: {"flow.c": source}, "-O3")
    drive, pointer, integer = library.drive, ctypes.c_void_p, ctypes.c_longlong
    drive.restype = integer
    drive.argtypes = [*[pointer] * 6, ctypes.c_double, ctypes.c_double, integer, integer]

    def run(
        state: VariationalState, known: np.ndarray, end: float, tol: float, limit: int, every: int
    ) -> int:
        arrays = state.clock, state.z, known, state.units, state.logs, state.counts
        addresses = [array.ctypes.data for array in arrays]
        return int(drive(*addresses, end, tol, limit, every))

    return run


def _drive_of_scipy(
    program: Program, n: int, k: int, places: tuple[tuple[int, int], ...]
) -> Callable[..., int]:
    """The loop in Python, by scipy's DOP853."""
    from scipy.integrate import DOP853

    evaluate, blank = _evaluator(program), [0.0] * len(places)
    rows, columns = (np.array(part, dtype=int) for part in zip(*places, strict=True))

    def run(
        state: VariationalState, known: np.ndarray, end: float, tol: float, limit: int, every: int
    ) -> int:
        given = known.tolist()

        def slope(t: float, z: np.ndarray) -> np.ndarray:
            outputs = np.array(evaluate(t, [*z[:n].tolist(), *blank], given), dtype=float)
            matrix = np.zeros((n, n))
            matrix[rows, columns] = outputs[n:]
            y = matrix @ z[n + 1 :].reshape(n, k)
            return np.concatenate([outputs[:n], [np.trace(matrix)], y.ravel()])

        scale = tol * np.concatenate([state.units, [1.0], np.repeat(state.units, k)])
        stepper, steps = None, 0
        while state.time != end and steps < limit:
            if stepper is None:
                first = min(state.clock[1], abs(end - state.time)) or None
                stepper = DOP853(slope, state.time, state.z, end, rtol=max(tol, 3e-14),
                                 atol=scale, first_step=first)  # fmt: skip
            stepper.step()
            if stepper.status == "failed":
                return NO_STEP
            steps += 1
            state.counts += (1, 12)
            state.clock[:2], state.z[:] = (stepper.t, stepper.h_abs), stepper.y
            if every and (state.counts[0] % every == 0 or state.time == end):
                q, r = np.linalg.qr(state.columns / state.units[:, None])
                state.columns[:] = q * np.sign(np.diag(r)) * state.units[:, None]
                state.logs += np.log(np.abs(np.diag(r)))
                stepper = None
        return ARRIVAL if state.time == end else LIMIT

    return run
