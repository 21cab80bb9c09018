"""Looking at the equations at single states: rates, the start, and why a run failed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from voronec.equations import VoronecEquations
from voronec.errors import DefinitionError, IntegrationError
from voronec.flow.steppers import Halt
from voronec.program import Program, compiled

__all__ = ["Probe"]

SINGULAR = 1e-13
"""A mass matrix with a smaller eigenvalue, in units of its diagonal, counts as singular."""
NEARLY = 1e-6
"""The same in units of the start's diagonal, for naming the cause where a run broke down."""
ON_RELATIONS = 1e-9
"""How far a point may lie off the relations between redundant coordinates."""


@dataclass(frozen=True)
class Probe:
    """The program of a system at given parameters and starting time."""

    equations: VoronecEquations
    program: Program
    values: list[float]
    time: float

    def rates(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Velocities of all coordinates (n, k) at one q (n,) and several v (m, k)."""
        width = v.shape[1]
        columns = [*np.repeat(q[:, None], width, axis=1), *v]
        rhs, _ = compiled(self.program)
        with np.errstate(all="ignore"):
            rates = rhs(np.float64(self.time), columns, [np.float64(x) for x in self.values])
        return np.array([np.broadcast_to(r, (width,)) for r in rates[: len(q)]], dtype=float)

    def check(self, start: np.ndarray) -> None:
        """Raise where no motion starts: relations violated, or equations undefined."""
        self._check_relations(start)
        mass = self._mass(self.time, start)
        if _smallest(mass, mass) < SINGULAR:
            raise IntegrationError(
                f"system '{self.equations.system.name}': the mass matrix is singular at the "
                f"initial point ({self._shown(start)}); start elsewhere or use another chart",
                self.time,
                start,
            )
        rhs, _ = compiled(self.program)
        with np.errstate(all="ignore"):
            slope = rhs(np.float64(self.time), list(start), [np.float64(x) for x in self.values])
        if not np.isfinite(np.array(slope, dtype=float)).all():
            raise IntegrationError(
                f"system '{self.equations.system.name}': the equations are not defined at the "
                f"initial point ({self._shown(start)}); start elsewhere or use another chart",
                self.time,
                start,
            )

    def failure(self, start: np.ndarray, halt: Halt) -> IntegrationError:
        """The error for a run that stopped short, with what can be said about the cause."""
        masses = self._mass(self.time, start), self._mass(halt.time, halt.state)
        cause = "; the mass matrix is singular there" if _smallest(*masses) < NEARLY else ""
        return IntegrationError(
            f"system '{self.equations.system.name}': {halt.reason} after t = {halt.time:.12g} "
            f"({self._shown(halt.state)}){cause}; end the run before that, or use another chart",
            halt.time,
            halt.state,
        )

    def _mass(self, time: float, state: np.ndarray) -> np.ndarray:
        form = self.equations.form
        n = len(form.velocities)
        entries = {f"{i},{j}": form.mass[i][j] for i in range(n) for j in range(n)}
        _, extras = compiled(Program.of(form, entries))
        with np.errstate(all="ignore"):
            flat = extras(np.float64(time), list(state), [np.float64(x) for x in self.values])
        return np.array(flat, dtype=float).reshape(n, n)

    def _check_relations(self, start: np.ndarray) -> None:
        form, relations = self.equations.form, self.equations.system.fibration.relations
        wanted = {str(r): inside for r, inside in zip(relations, form.relations, strict=True)}
        _, extras = compiled(Program.of(form, wanted))
        numbers = extras(np.float64(self.time), list(start), self.values)
        for relation, residual in zip(wanted, numbers, strict=True):
            if not abs(residual) < ON_RELATIONS:
                raise DefinitionError(
                    f"system '{self.equations.system.name}': the initial point does not satisfy "
                    f"the relation {relation} = 0 (residual {float(residual):.3g}); correct the "
                    "coordinates"
                )

    def _shown(self, state: np.ndarray) -> str:
        pairs = zip(self.program.state, state, strict=True)
        return ", ".join(f"{name} = {value:.6g}" for name, value in pairs)


def _smallest(scale: np.ndarray, mass: np.ndarray) -> float:
    """The least eigenvalue of a mass matrix, in units of the diagonal of another, over the largest.

    Zero where the other has a zero on its diagonal; infinite where a matrix is undefined.
    """
    if not (len(mass) and np.isfinite(mass).all() and np.isfinite(scale).all()):
        return np.inf
    units = np.sqrt(np.abs(np.diag(scale)))
    if not units.all():
        return 0.0
    sizes = np.abs(np.linalg.eigvalsh(mass / np.outer(units, units)))
    return float(sizes.min() / max(1.0, sizes.max()))
