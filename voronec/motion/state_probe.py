"""Looking at the equations at single states: rates, the start, mass matrices, why a run failed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from operator import mul
from typing import Any

import numpy as np

from voronec.algebra.memo import Memo
from voronec.equations.program import Program, compile_program, hoist
from voronec.errors import DefinitionError, IntegrationError
from voronec.motion.steppers import FAR, Signals, Suspect, Termination, values_along

SINGULAR = 1e-13
"""A mass matrix with a smaller eigenvalue, in units of its diagonal, counts as singular."""
DEPENDENT = 1e-6
"""The bound for a matrix with rows of multipliers, whose smallest eigenvalue is about the square of
how independent the constraints are: they lose more digits then than they leave."""
INFINITE = 1e14
"""Rates of coordinates this many times the largest coordinate or velocity may be divisions by
zero."""
ASIDE, FALLEN = 1e-9, 1e-3
"""They are where a state that is moved by the first part of its size, or of one, has rates below
the second part of them."""
NEARLY = 1e-6
"""The bound, also in units of the start's diagonal, for naming the cause where a run broke down."""
INDEFINITE = "the mass matrix is not positive definite at the start; check the signs in L"
"""What a run is told that begins with a mass matrix that no bodies have."""

Right = Callable[[float, Any], Any]
"""The right-hand side at a time and a state, whose entries may be arrays."""


def quiet(rhs: Callable[..., Any], values: Sequence[float]) -> Right:
    """A compiled right-hand side at given parameters, undefined where it is so without a word."""
    given = [np.float64(x) for x in values]

    def right(time: float, columns: Any) -> Any:
        with np.errstate(all="ignore"):
            return rhs(np.float64(time), columns, given)

    return right


def rates_along(right: Right, time: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The quantities (l, k) of a program at one q (n,) and several v (m, k)."""
    width = v.shape[1]
    columns = [*np.repeat(q[:, None], width, axis=1), *v]
    return np.array([np.broadcast_to(r, (width,)) for r in right(time, columns)], dtype=float)


def at_each(
    function: Any, names: Sequence[str], t: Any, states: np.ndarray, values: np.ndarray
) -> dict[str, np.ndarray]:
    """Quantities at states (..., n) with parameters (..., p), each an array of shape (...)."""
    shape = states.shape[:-1]
    columns = (list(x.transpose(-1, *range(x.ndim - 1))) for x in (states, values))
    with np.errstate(all="ignore"):
        arrays = [np.asarray(r, dtype=float) for r in function(t, *columns)]
    return {
        name: r if r.shape == shape else np.broadcast_to(r, shape)
        for name, r in zip(names, arrays, strict=True)
    }


def changes(values: np.ndarray, start: Any) -> np.ndarray:
    """How much values differ from where they start; not a number where both are infinite."""
    with np.errstate(invalid="ignore"):
        return np.abs(values - start)


def usual_size(sizes: np.ndarray) -> float:
    """The median of those sizes that are finite; zero where there are none.

    That of numpy imports masked arrays first, which takes longer than all else here.
    """
    finite = np.sort(sizes[np.isfinite(sizes)])
    n = len(finite)
    return float(finite[(n - 1) // 2] + finite[n // 2]) / 2 if n else 0.0


def quantities(form: Any, extras: Any) -> Program:
    """A program for extra quantities alone, on the state and the parameters of a form."""
    return Program.of_extras(form, extras)


def rates_program(form: Any, fibre: Sequence[Any]) -> Program:
    """A program for the velocities of all coordinates, and those of the fibre of a group."""
    rates = {f"rate {i}": e for i, e in enumerate((*form.rates, *fibre))}
    still = replace(form, mass=(), force=())  # the equations of motion play no part
    return quantities(still, rates)


def mass_program(form: Any) -> Program:
    """A program for the entries of a form's mass matrix on and below the diagonal, row by row."""
    n = len(form.velocities)
    return quantities(form, {f"{i},{j}": form.mass[i][j] for i in range(n) for j in range(i + 1)})


@dataclass(frozen=True)
class StateProbe:
    """The program of a first-order form at given parameters and starting time.

    ``name`` is the system's, for messages; ``inertia`` the ``mass_program`` of the form, where it
    is made already.
    """

    name: str
    form: Any
    program: Program
    values: Sequence[float]
    time: float
    changing: Signals | None = None
    inertia: Program | None = None
    memo: Memo = field(default_factory=Memo, init=False, repr=False, compare=False)

    def rates(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """What a ``rates_program`` gives (l, k) at one q (n,) and several v (m, k)."""
        return rates_along(quiet(compile_program(self.program)[1], self.values), self.time, q, v)

    def check(self, start: np.ndarray) -> tuple[str, ...]:
        """Raise where no motion starts: the equations are singular or undefined; a note where the
        mass matrix is not positive definite, as that of no body is."""
        slope, mass, sizes = self._beginning(start)
        if np.abs(sizes).min(initial=np.inf) < SINGULAR:
            raise self._nowhere("the mass matrix is singular", start)
        meaningless = self._meaningless()
        if meaningless:
            raise DefinitionError(
                f"system '{self.name}': the equations, or outputs, are not defined for "
                f"{meaningless}; change these values"
            )
        rates = np.abs(np.array(slope, dtype=float))
        if not np.isfinite(rates).all() or self._is_infinite(start, rates):
            raise self._nowhere("the equations are not defined", start)
        massive = np.count_nonzero(np.diag(mass))  # rows of multipliers hold none
        sound = not len(sizes) or (sizes > 0).sum() >= massive
        return () if sound else (INDEFINITE,)

    def _beginning(self, start: np.ndarray) -> tuple[Any, np.ndarray, np.ndarray]:
        """Rates, the mass matrix and its eigenvalues in units of its diagonal at the start, which
        both ``check`` and ``suspect`` ask for."""

        def look() -> tuple[Any, np.ndarray, np.ndarray]:
            slope, mass = self._on_floats(start) or (
                self._rhs(self.time, list(start)),
                self.masses(np.array([self.time]), start[None, :])[0],
            )
            return slope, mass, _scaled_eigenvalues(mass, mass)

        return self.memo.last("beginning", start.tobytes(), look)

    def _on_floats(self, start: np.ndarray) -> tuple[Any, np.ndarray] | None:
        """Rates and mass matrix at the start, in a tenth of the time that arrays take; None where
        one has no value in Python's arithmetic, which may be infinite."""
        if self.changing is not None:
            return None
        right, entries = (
            compile_program(p, scalar=True)[i]
            for i, p in enumerate((self.program, self._mass_program))
        )
        state, values, n = start.tolist(), [*map(float, self.values)], len(self.form.velocities)
        try:
            slope, flat = right(self.time, state, values), iter(entries(self.time, state, values))
        except (ArithmeticError, ValueError):
            return None
        mass = np.empty((n, n))
        for i in range(n):
            for j in range(i + 1):
                mass[i, j] = mass[j, i] = next(flat)
        return slope, mass

    def _is_infinite(self, start: np.ndarray, rates: np.ndarray) -> bool:
        """Whether rates of coordinates are infinite but for rounding, as sin(pi) is no zero.

        Such rates are far larger than the state, and fall when that is moved a little.
        """
        count = len(self.form.coordinates)
        turning = rates[:count] / INFINITE > np.abs(start).max(initial=0.0)
        if not turning.any():
            return False
        beside = self._rhs(self.time, list(start + ASIDE * np.maximum(1.0, np.abs(start))))
        moved = np.abs(np.array(beside[:count], dtype=float))
        return bool((moved < FALLEN * rates[:count])[turning].any())

    def suspect(self, start: np.ndarray) -> Suspect | None:
        """Finds states with a singular mass matrix, or beyond one; None where it is constant, and
        where it is not defined at the start, from which ``check`` lets nothing begin.

        Beyond one the number of negative eigenvalues is not that of the start.
        """
        moving = {*self.program.state, self.program.time}
        if not self._mass_program.extras.symbols & moving:
            return None
        _, base, sizes = self._beginning(start)
        if not np.isfinite(base).all():
            return None
        units = _units(base)
        scale = np.outer(units, units) if units.all() else np.ones_like(base)
        negative = int(((sizes if units.all() else np.linalg.eigvalsh(base)) < 0).sum())
        least_sound = SINGULAR if (np.diag(base) > 0).all() else DEPENDENT

        def first(t: np.ndarray, states: np.ndarray) -> int | None:
            if not negative and _are_definite(self._lower_rows(t, states), np.diag(scale)):
                return None
            masses = self.masses(t, states) / scale
            masses[~np.isfinite(masses).all(axis=(1, 2))] = base / scale
            sizes = np.linalg.eigvalsh(masses)
            least = np.abs(sizes).min(axis=1)
            small = least < least_sound * np.abs(sizes).max(axis=1)
            for i in np.flatnonzero(small & bool(units.all())):  # others may have grown without end
                small[i] = min(least[i], _smallest(masses[i], masses[i])) < least_sound
            bad = np.flatnonzero(((sizes < 0).sum(axis=1) != negative) | small)
            return int(bad[0]) if len(bad) else None

        return first

    def failure(self, start: np.ndarray, halt: Termination, trajectory: Any) -> IntegrationError:
        """The error for a run that stopped short, with what can be said about the cause."""
        state = np.array(halt.state, dtype=float)
        times = np.array([self.time, float(halt.time)])
        masses = self.masses(times, np.array([np.array(start, dtype=float), state]))
        least = min(_smallest(mass, masses[1]) for mass in masses)
        singular = halt.singular or least < NEARLY
        cause = "; the mass matrix is singular there" if singular else ""
        mend, after = "end the run before that, or use another chart", " after"
        if halt.mend:
            cause, mend, after = "", halt.mend, "; the run is kept up to"
        elif halt.reason == FAR:
            cause, mend = "", "ask for a shorter span or a coarser tolerance"
        return IntegrationError(
            f"system '{self.name}': {halt.reason}{after} t = {float(halt.time):.12g} "
            f"({self._show_state(state)}){cause}; {mend}",
            halt.time,
            halt.state,
            trajectory,
            singular,
        )

    @cached_property
    def _rhs(self) -> Right:
        return quiet(compile_program(self.program)[0], self.values)

    @cached_property
    def _mass_program(self) -> Program:
        return self.inertia or mass_program(self.form)

    @cached_property
    def _mass_entries(self) -> Any:
        return compile_program(self._mass_program)[1]

    def masses(self, t: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Mass matrices (k, n, n) at times (k,) and states (k, m)."""
        n = len(self.form.velocities)
        result = np.empty((len(t), n, n))
        for i, row in enumerate(self._lower_rows(t, states)):
            for j, column in enumerate(row):
                result[:, i, j] = result[:, j, i] = column
        return result

    def _lower_rows(self, t: np.ndarray, states: np.ndarray) -> list[list[Any]]:
        """Their entries on and below the diagonal, row by row, arrays (k,) or constants."""
        if not self.form.velocities:
            return []
        with np.errstate(all="ignore"):
            flat = iter(self._mass_entries(t, list(states.T), self._values(t)))
        return [[next(flat) for _ in range(i + 1)] for i in range(len(self.form.velocities))]

    def _values(self, t: np.ndarray) -> list[Any]:
        """The parameters at times (k,)."""
        return values_along(self.changing, map(str, self.program.parameters), self.values, t)

    def _meaningless(self) -> str:
        """The parameters and velocities that stay, with their values, of which the equations or
        outputs hold an expression without a value, such as the inverse of a sum that vanishes."""
        raised = hoist(self.program)
        given = list(map(float, self.values))
        values = raised.values(given)[len(given) :]
        if np.isfinite(values).all():
            return ""
        known = dict(zip(map(str, self.program.parameters), given, strict=True))
        meaning: dict[Any, Any] = {}
        for (symbol, expr), value in zip(raised.definitions, values, strict=True):
            meaning[symbol] = expr.xreplace(meaning)
            names = sorted(map(str, meaning[symbol].free_symbols))
            if names and not np.isfinite(value):
                return ", ".join(f"{name} = {known[name]:.6g}" for name in names)
        return ""

    def _nowhere(self, what: str, start: np.ndarray) -> IntegrationError:
        return IntegrationError(
            f"system '{self.name}': {what} at the initial point ({self._show_state(start)}); start "
            "elsewhere or use another chart",
            self.time,
            start,
        )

    def _show_state(self, state: np.ndarray) -> str:
        pairs = zip(self.program.state, state, strict=True)
        return ", ".join(f"{name} = {value:.6g}" for name, value in pairs)


def _are_definite(rows: Sequence[Sequence[Any]], units: np.ndarray) -> bool:
    """Whether matrices, given by arrays (k,) of their entries on and below the diagonal, are
    positive definite and far from singular where their diagonal is in some units (n,), told in a
    tenth of the time that their eigenvalues take: the least is at least det / trace^n times the
    largest."""
    rest = [[np.asarray(x) for x in row] for row in rows]
    with np.errstate(all="ignore"):
        trace = sum(row[-1] / unit for row, unit in zip(rest, units.tolist(), strict=True))
        for j, row in enumerate(rest):
            for i in range(j + 1, len(rest)):
                share = rest[i][j] / row[j]
                for k in range(j + 1, i + 1):
                    rest[i][k] = rest[i][k] - share * rest[k][j]
        pivots = [row[-1] / unit for row, unit in zip(rest, units.tolist(), strict=True)]
        far = reduce(mul, pivots) > SINGULAR * trace ** len(rest)
        return bool(np.min(far) and np.min(reduce(np.minimum, pivots)) > 0)


def _smallest(scale: np.ndarray, mass: np.ndarray) -> float:
    """The least eigenvalue of a mass matrix, in the units of another.

    Zero where the other has a row of zeros; infinite where a matrix is undefined.
    """
    return float(np.abs(_scaled_eigenvalues(scale, mass)).min(initial=np.inf))


def _scaled_eigenvalues(scale: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """The eigenvalues of a mass matrix in units of the diagonal of another, which have the signs of
    its own; one zero where that has a row of zeros, none where a matrix is undefined."""
    if not (len(mass) and np.isfinite(mass).all() and np.isfinite(scale).all()):
        return np.empty(0)
    units = _units(scale)
    if not units.all():
        return np.zeros(1)
    return np.asarray(np.linalg.eigvalsh(mass / np.outer(units, units)))


def _units(mass: np.ndarray) -> np.ndarray:
    """The square roots of the diagonal, and units of rows without a positive one, as of
    multipliers, in which their largest entry is one."""
    units, massive = np.sqrt(np.abs(np.diag(mass))), np.diag(mass) > 0
    for i in np.flatnonzero(~massive):
        units[i] = (np.abs(mass[i, massive]) / units[massive]).max(initial=units[i])
    return units
