"""No run ends well that did not go well: what must stay along a motion, and whether it is one.

Integrals that are proved and relations between redundant coordinates must stay as far as the
tolerance allows, after as many steps; states must obey the equations that were integrated, and
coordinates those that were derived first, in another form and by other code (``step_defects``).

Angles that are read off on a grid have to be certain of their branches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.numeric_functions import elementary
from voronec.algebra.verdicts import all_vanish
from voronec.declaration.claims import right_of
from voronec.equations.motions import Motions
from voronec.equations.program import Program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import VoronecError
from voronec.motion.formulation import is_many_valued
from voronec.motion.observables import evaluate_extras
from voronec.motion.state_probe import changes, usual_size
from voronec.motion.step_defects import program_rates, strayed_rows, wrong_steps
from voronec.motion.steppers import (
    OwnedSamples,
    Rates,
    Run,
    Signals,
    StepSamples,
    by_owner,
    spread,
    values_along,
)
from voronec.motion.tolerances import LOOSE, UNIT
from voronec.motion.trajectory import Trajectory

FREE = 10
"""So many steps are allowed to everybody."""
ROWS = 200
"""Instants that are looked at."""
LONG = 100_000
"""Operations, shared ones counted every time, above which the equations derived first are let be:
to make them ready would take longer than a run."""
HASTE = {"opt_level": 0}
"""To have LLVM optimise what a run evaluates a few times takes three times as long as the rest."""
REGULAR = 1e12
"""The condition number of a mass matrix below which accelerations mean something."""
PARTS = 100
"""Parts of a run that are looked at, between changes of the right side."""
FEW = 4
"""Steps in which the original equations are looked at."""
DISOBEDIENT = "the states do not obey the equations"
SLOPE = 6e-6
"""The step of difference quotients: the cube root of the rounding."""
JUMP = 0.01
"""A quantity jumps at a state where it changes, beside it, by less than this part of what it
changes on the first step away from it."""


@dataclass(frozen=True)
class Breach:
    """What went wrong, in words, and the last row of the grid before it was seen, or the ``last``
    time and state, where that is known better."""

    what: str
    row: int
    last: tuple[float, np.ndarray] | None = None

    @classmethod
    def of_step(cls, t: np.ndarray, part: StepSamples, i: int) -> Breach:
        """A step of a run along a grid (k,) does not obey the equations."""
        begin, order = float(part.times[i, 0]), 1.0 if t[-1] >= t[0] else -1.0
        row = int(np.searchsorted(order * t, order * begin, side="right")) - 1
        return cls(DISOBEDIENT, max(row, 0), last=(begin, part.states[i, 0].copy()))


MERE_CLAIM, JUMPS = "is only claimed", "jumps with the forces"


@dataclass(frozen=True)
class SolutionCheck:
    """What is known of a run: its program at ``values`` of the parameters, numpy's doubles, with a
    tolerance.

    ``integrals`` and ``relations`` name extra quantities of the program, and those that give the
    size of the terms; parameters that are ``changing`` are those of the start among the ``values``;
    of the integrals ``jumping`` with the forces, named in the same way, no proof holds across the
    jumps.
    """

    equations: VoronecEquations
    program: Program
    values: Sequence[float]
    tol: float
    steps: int
    integrals: Mapping[str, tuple[str, str]]
    relations: Mapping[str, str]
    changing: Signals | None = None
    jumping: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    def breach(
        self,
        t: np.ndarray,
        states: np.ndarray,
        samples: Sequence[StepSamples],
        at_home: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
        constants: Mapping[str, Any] | None = None,
    ) -> tuple[Breach | None, tuple[str, ...]]:
        """What went wrong first, if anything did, and what is to be said of mere claims; ``states``
        (k, n) are those at instants ``t`` (k,), and ``samples`` those of the steps.

        Where nothing did, some steps are held against the equations derived first, at their
        ``constants``: ``at_home`` takes times (k,) and states (k, n) to coordinates and velocities
        (k, m)."""
        breaches, notes = self.losses(t, states)
        parts = self._inner(t, samples)
        breaches += self._wrong_steps(t, parts, program_rates(self.program, self.at))
        strayed = (row for part in parts for row in strayed_rows(t, states[None], part, self.tol))
        breaches += [Breach(DISOBEDIENT, row) for row in strayed]
        if not breaches and at_home is not None:
            rates = original_rates(self.equations, constants or {}, self.changing)
            if rates is not None:
                some = (part.pick(spread(len(part.times), FEW)) for part in parts[:FEW])
                wrong = self._wrong_steps(t, [part.through(at_home) for part in some], rates)
                breaches = [replace(breach, last=None) for breach in wrong]
        return min(breaches, key=lambda b: b.row, default=None), notes

    def _inner(self, t: np.ndarray, samples: Sequence[StepSamples]) -> list[StepSamples]:
        """The samples of the steps to instants ``t``, in which no function of Python's jumps."""
        inputs = self.changing.signals if self.changing is not None else ()
        jumps = [span for signal in inputs for span in signal.sharp]
        some = (samples[i] for i in spread(len(samples), PARTS))
        inner = (part.within(float(t[0]), float(t[-1]), jumps) for part in some)
        return [part for part in inner if part.states.size]

    def _wrong_steps(
        self, t: np.ndarray, parts: Sequence[StepSamples], rates: Rates
    ) -> list[Breach]:
        """The steps that do not obey the equations."""
        steps = wrong_steps(by_owner(parts), lambda _: rates, self.tol)
        return [Breach.of_step(t, part, i) for _, part, i in steps]

    def at(self, t: np.ndarray) -> list[Any]:
        """The values of the parameters at times (k,): doubles, or arrays of them."""
        if self.changing is None:
            return [*self.values]
        return values_along(self.changing, map(str, self.program.parameters), self.values, t)

    def losses(
        self, t: np.ndarray, states: np.ndarray, most: int = ROWS
    ) -> tuple[list[Breach], tuple[str, ...]]:
        """Relations and integrals that did not stay, looked at in so many rows at ``most``, and
        notes on those that need not."""
        rows = spread(len(t), most)
        relations = {name: (key, "") for name, key in self.relations.items()}
        run, breaches, notes = (t[rows], states[rows], self.tol, self.steps), [], []
        lost = ConservedQuantities({**self.integrals, **relations}, self._extras).losses(*run)
        lost |= ConservedQuantities(self.jumping, self._extras, jumping=True).losses(*run)
        for name, (i, change, allowed) in lost.items():
            amount = f"by {change:.2g}, where the tolerance allows {allowed:.2g}"
            if name in relations:
                breaches.append(Breach(f"the relation {name} is lost {amount}", int(rows[i - 1])))
            elif self._is_certain(name):
                breaches.append(Breach(f"the integral '{name}' drifts {amount}", int(rows[i - 1])))
            else:
                why = JUMPS if name in self.jumping else MERE_CLAIM
                told = f"and drifts: at t = {t[rows[i]]:.6g} it has changed {amount}"
                notes.append(f"the integral '{name}' {why}, {told}")
        return breaches, tuple(notes)

    def _is_certain(self, name: str) -> bool:
        """Whether an integral must stay: proofs take parameters for constants, and hold between
        jumps."""
        if name in self.jumping or self.changing is not None:
            return False
        return is_proved(self.equations, name)

    def _extras(self, t: np.ndarray, states: np.ndarray) -> Mapping[str, np.ndarray]:
        return evaluate_extras(self.program, t, states, self.at(t))


@dataclass(frozen=True)
class ConservedQuantities:
    """Quantities that must stay: ``names`` of extra quantities of a program, and of those which
    give the size of their terms (empty where these are not known).

    ``extras(t, states)`` gives all quantities of the program at times (k,) and states (k, n).
    Where they are ``jumping`` a state may lie just on a jump: slopes across it say nothing, and
    a quantity has its value there, though none is beside it.
    """

    names: Mapping[str, tuple[str, str]]
    extras: Callable[[np.ndarray, np.ndarray], Mapping[str, np.ndarray]]
    jumping: bool = False

    def losses(
        self, t: np.ndarray, states: np.ndarray, tol: float, steps: int
    ) -> dict[str, tuple[int, float, float]]:
        """Of those that did not stay: the row where that is seen first, the change and what is
        allowed there."""
        if len(t) < 2 or not self.names:
            return {}
        values = self.extras(t, states)
        off = [abs(values[key][0]) for key, size in self.names.values() if not size]
        share = np.abs(t - t[0]) / abs(t[-1] - t[0])
        per_unit = LOOSE * max(tol, UNIT) * (FREE + steps * share)
        if off:
            per_unit += LOOSE * np.nan_to_num(max(off))
        here = np.array([values[key] for key, _ in self.names.values()])
        sizes = np.array([values[size] if size else share**0 for _, size in self.names.values()])
        with np.errstate(all="ignore"):
            least = per_unit * np.maximum(sizes, sizes[:, :1])
            if np.isfinite(least).all() and (np.abs(here - here[:, :1]) <= least).all():
                return {}
        drifts = {}
        for name, (key, size) in self.names.items():
            # at a pole of coordinates, where a run may begin, a quantity may have no value
            rows = np.flatnonzero(np.isfinite(values[key]) & np.isfinite(values[size or key]))
            if len(rows) < 2:
                continue
            unit, here = per_unit[rows], values[key][rows]
            change = np.abs(here - here[0])
            allowed = unit * (_scale(np.abs(values[size][rows])) if size else 1.0)
            if not (change > allowed).any():
                continue
            slopes, rough = self._around(key, t[rows], states[rows])
            allowed = np.maximum(allowed, unit * _scale(slopes))
            # where a quotient is rounding over rounding, a quantity is not what it is beside it
            sure = rough <= allowed
            change = np.where(sure, np.abs(here - here[np.argmax(sure)]), 0.0)
            bad = np.flatnonzero(change > allowed)
            if len(bad):
                drifts[name] = int(rows[bad[0]]), float(change[bad[0]]), float(allowed[bad[0]])
        return drifts

    def _around(self, key: str, t: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """By how much a quantity changes, to first order, with each variable by its size, at least
        one unit, or by that of the largest: what tolerances are relative to; and by how much it is
        off the mean of its values on both sides, which says whether it has one.  What its curvature
        makes of that is four times as much at twice the distance, and is left out."""
        largest = np.maximum(1.0, np.abs(states).max(axis=1, initial=0.0))
        here, total, rough = self.extras(t, states)[key], np.zeros(len(t)), np.zeros(len(t))
        for j in range(states.shape[1]):
            step = SLOPE * np.maximum(np.abs(states[:, j]), 1e-3)
            ends = []
            for places in (1, -1, 2, -2):
                moved = states.copy()
                moved[:, j] += places * step
                ends.append(self.extras(t, moved)[key])
            above, below, far_above, far_below = ends
            with np.errstate(all="ignore"):
                flat = np.abs(far_above - above) + np.abs(far_below - below)
                jumps = flat < JUMP * np.maximum(np.abs(above - here), np.abs(below - here))
                jumps &= self.jumping
                total += np.where(jumps, flat, np.abs(above - below)) / (2 * step)
                near, far = here - (above + below) / 2, here - (far_above + far_below) / 2
                off = np.where(jumps, 0.0, np.abs(4 * near - far) / 3)
                rough = np.fmax(rough, off)
        return total * largest, rough


def _scale(sizes: np.ndarray) -> np.ndarray:
    """Sizes at the instants compared: here, at the start, and along the way, where a single large
    one counts for nothing."""
    return np.maximum(np.nan_to_num(sizes, nan=np.inf), max(float(sizes[0]), usual_size(sizes)))


def is_proved(equations: VoronecEquations, name: str) -> bool:
    """Whether the claimed integral of this name is proved to be one, and no motion can change over
    to another of its branches; where that exceeds the budget, it is not.  Proofs are kept with the
    equations."""
    integral = equations.system.integrals[name]
    return equations.memo.once(f"proved integral {name}", lambda: _prove(equations, integral))


def _prove(equations: VoronecEquations, integral: Any) -> bool:
    function = right_of(integral)
    try:
        field = Motions.of(equations).field_for([function])
        read = field.read_with_momenta(function)
        rate = field.derivative(read)
        return not is_many_valued(read) and bool(all_vanish([rate], field.relations))
    except VoronecError:
        return False


def original_rates(
    equations: VoronecEquations, constants: Mapping[str, Any], changing: Signals | None
) -> Rates | None:
    """The equations on the coordinates as they were derived first, evaluated by symengine, the
    mass matrix inverted in numbers.

    None where they are too long, or hold a function that symengine does not know; what symengine
    makes of them stays with the equations.
    """
    form = equations.raw.form
    evaluate = equations.memo.once("original rates", lambda: _evaluator(form))
    if evaluate is None:
        return None
    width, n = len(form.rates), len(form.velocities)
    names = equations.memo.once("original parameters", lambda: [*map(str, form.parameters)])
    still = [constants.get(name, np.nan) for name in names]

    def rates(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        given = values_along(changing, names, still, t)
        columns = np.empty((1 + states.shape[1] + len(given), len(t)))
        for row, x in zip(columns, (t, *states.T, *given), strict=True):
            row[:] = x
        rows = np.asarray(evaluate(columns.T), dtype=float).reshape(len(t), -1)
        sound = np.isfinite(rows).all(axis=1)
        if n:
            mass, force = rows[:, width : width + n * n].reshape(-1, n, n), rows[:, width + n * n :]
            mass[~sound] = 0.0
            sizes = np.abs(np.linalg.eigvalsh(mass))
            sound &= sizes.max(axis=1) / REGULAR < sizes.min(axis=1)
            mass[~sound] = np.eye(n)
            rows[:, width : width + n] = np.linalg.solve(mass, force[:, :, None])[:, :, 0]
        rows[~sound] = np.nan
        return rows[:, : width + n]

    return rates


def _evaluator(form: Any) -> Any:
    """Rates, mass matrix and force of a form as a function of arrays; None where there is none."""
    flat = [*form.rates, *(e for row in form.mass for e in row), *form.force]
    # counted one by one: where the first are long enough, the rest would take milliseconds
    counts = accumulate(map(se.count_ops, flat))
    if form.stages or not flat or any(count > LONG for count in counts):
        return None  # the form of a large system is the one that was integrated
    inputs = [form.time, *form.coordinates, *form.velocities, *form.parameters]
    try:
        return se.Lambdify(inputs, [elementary(e) for e in cardinal_all(flat)], cse=True, **HASTE)
    except (RuntimeError, TypeError, ValueError, NotImplementedError):
        return None


@dataclass
class CheckOfMany:
    """What went wrong first with motions of one program, each with values of its own.

    ``integrals`` maps names of integrals to those of extra quantities of the program.
    """

    equations: VoronecEquations
    program: Program
    tol: float
    integrals: Mapping[str, str]

    def breaches(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray, steps: float,
        samples: Sequence[OwnedSamples], series: Mapping[str, np.ndarray],
    ) -> tuple[dict[int, Breach], dict[int, tuple[str, ...]]]:  # fmt: skip
        """What went wrong with which motion, and what is to be said of mere claims: states
        (m, k, n) at ``t`` (k,), parameters (m, p), ``samples`` of the steps, each took so many; and
        the extra quantities (m, k) there."""
        notes, first = dict[int, tuple[str, ...]](), dict[int, Breach]()
        breaches = [*self._disobedient(t, states, values, samples)]
        for i, name in self._drifts_at(series):
            whole, integrals = (
                np.isfinite(states[i]).all(axis=1),
                {name: (self.integrals[name],) * 2},
            )
            one = SolutionCheck(
                self.equations, self.program, [*values[i]], self.tol, int(steps), integrals, {}
            )
            lost, told = one.losses(t[whole], states[i][whole], len(t))
            breaches += [(i, breach) for breach in lost]
            if told:
                notes[i] = (*notes.get(i, ()), *told)
        for i, breach in breaches:
            if i not in first or breach.row < first[i].row:
                first[i] = breach
        return first, notes

    def _drifts_at(self, series: Mapping[str, np.ndarray]) -> Iterator[tuple[int, str]]:
        """The motions of which an integral may be lost, and its name."""
        for name, key in self.integrals.items():
            start = series[key][:, :1]
            allowed = LOOSE * max(self.tol, UNIT) * FREE * np.abs(start)
            moved = (changes(series[key], start) > allowed).any(axis=1)
            yield from ((i, name) for i in np.flatnonzero(moved).tolist())

    def _disobedient(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray,
        samples: Sequence[OwnedSamples],
    ) -> Iterator[tuple[int, Breach]]:  # fmt: skip
        """The motions whose states do not obey the equations, all steps looked at together."""

        def rates_of(owner: np.ndarray) -> Rates:
            return program_rates(
                self.program, lambda t: [*np.repeat(values[owner], len(t) // len(owner), axis=0).T]
            )

        for owners, part in samples:
            for row in strayed_rows(t, states[owners[:1]], part, self.tol):
                yield int(owners[0]), Breach(DISOBEDIENT, row)
        for i, part, step in wrong_steps(samples, rates_of, self.tol):
            yield i, Breach.of_step(t, part, step)


PER_STEP = 4
"""So many points of the grid in a step, on the average, tell the branches of angles apart; nowhere
may two be farther apart than the shortest step between them."""
SWING = np.pi / 2
"""What an angle may turn by from one point to the next; where it is more, a pole is near."""


class Untold(Exception):
    """Branches of angles could not be told: these are to be integrated."""


def require_branches(trajectory: Trajectory, names: Iterable[str], run: Run) -> None:
    """Raise ``Untold`` where the integrator's own steps do not tell branches apart.

    Within a step a motion is nearly a polynomial: what turns by more than half a turn between two
    points that are nearer to each other than the steps there has come near its pole.
    """
    angles = [trajectory[name].astype(float) for name in names]
    if not angles or run.steps == 0:
        return
    if len(trajectory) < PER_STEP * run.steps or not is_resolved(trajectory.t, run.ends):
        raise Untold
    if any(np.abs(np.diff(angle)).max(initial=0.0) > SWING for angle in angles):
        raise Untold


def is_resolved(grid: np.ndarray, ends: Iterable[float]) -> bool:
    """Whether no two neighbours on a grid are farther apart than the shortest step between them."""
    marks = np.abs(np.array([grid[0], *ends], dtype=float) - float(grid[0]))
    times = np.abs(grid.astype(float) - float(grid[0]))
    lengths = np.diff(marks)
    if not lengths.size:
        return False
    lengths[-1] = max(lengths[-1], *lengths[-2:])  # the last step ends where the grid does
    first = np.searchsorted(marks, times[:-1], side="right") - 1
    last = np.searchsorted(marks, times[1:], side="left") - 1
    first, last = (np.clip(place, 0, lengths.size - 1) for place in (first, last))
    shortest = np.minimum(lengths[first], lengths[last])
    return bool((np.diff(times) <= shortest).all() and (last - first <= 1).all())
