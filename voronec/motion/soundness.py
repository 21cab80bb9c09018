"""No run ends well that did not go well: what must stay along a motion, and whether it is one.

Integrals that are proved and relations between redundant coordinates must stay as far as the
tolerance allows, after as many steps; states must obey the equations that were integrated, and
coordinates those that were derived first, in another form and by other code.

    defect = x(t_8) - x(t_0) - integral of f(t, x(t)) dt

over nine neighbouring instants t_0, ..., t_8.  The integral is that of the polynomial through the
nine rates; how fast the coefficients of its expansion in Legendre polynomials fall says how far it
can be trusted.  Nothing of the integrator that found the states is used.

Angles that are read off on a grid have to be certain of their branches.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import accumulate
from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.cardinal import cardinal_all
from voronec.algebra.numeric_functions import elementary
from voronec.algebra.verdicts import all_vanish
from voronec.declaration.claims import right_of
from voronec.equations.motions import Motions
from voronec.equations.program import Program, compile_program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import VoronecError
from voronec.motion.model.special import is_many_valued
from voronec.motion.observables import evaluate_extras
from voronec.motion.state_probe import at_each, usual_size
from voronec.motion.steppers.run import Problem, Run, Signals, values_along
from voronec.motion.steppers.units import natural_units
from voronec.motion.tolerances import LOOSE, UNIT
from voronec.motion.trajectory import Trajectory

__all__ = [
    "WIDTH",
    "Breach",
    "Judge",
    "JudgeOfMany",
    "LookGrid",
    "Rates",
    "Untold",
    "Windows",
    "again",
    "require_branches",
]


WIDTH = 9
"""Instants in a window."""
RELATIVE, ROUNDING = 1e-6, 1e-7
"""A defect is looked into where it is larger than these parts of the way that a variable goes in
the window, and of the state's size: less than a tenth of the first of the size counts never."""
RESOLUTION = 0.25
"""Of the time in which a motion changes by as much as it is, a window is to be this part."""
FAR_APART = 2.0**16
"""A window of so many roundings of the time holds instants that are apart."""
LOOKS = 3
"""So many windows are added to a grid that has none."""
DOUBT = 2.0
"""A defect counts where it is so many times larger than what the last two coefficients contribute;
the coefficients that are left out are of their size."""
ILL, SAME = 1e4, 1e-9
"""Nodes that magnify rates by more tell nothing; nodes that differ by less are the same."""
BUDGET = 3000
"""Evaluations that integrating a window again may take."""
TWICE = 24
"""Evaluations of a step of DOP853, made from two starts."""
NEARBY, FINE, MARGIN = 1e-7, 1e-11, 1e3
"""How far from the first another start is, the tolerance from there, and how many tolerances the
state may be off."""

Rates = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Times (k,) and states (k, n) to the rates (k, n) of the variables; nan where undefined."""


@dataclass(frozen=True)
class Windows:
    """Rows of a grid, in windows: ``rows`` has shape (windows, WIDTH)."""

    rows: np.ndarray

    @classmethod
    def spread(cls, size: int, most: int) -> Windows:
        """As many windows as cover a grid of some size, side by side, or as may be, evenly spread;
        none where the grid is too small."""
        whole = (size - 1) // (WIDTH - 1)
        if whole < 1:
            return cls(np.empty((0, WIDTH), dtype=int))
        starts = np.arange(whole) * (WIDTH - 1)
        if whole > most:
            starts = starts[_spread(whole, most)]
        elif starts[-1] + WIDTH < size:
            starts = np.append(starts, size - WIDTH)
        return cls(starts[:, None] + np.arange(WIDTH))

    @classmethod
    def of(cls, t: np.ndarray, most: int, instants: np.ndarray) -> Windows:
        """Those of a grid, and those that end at some of its ``instants``, beginning among what was
        added to it."""
        ends = np.flatnonzero(np.isin(t, instants))
        looks = ends[ends >= WIDTH - 1, None] + np.arange(1 - WIDTH, 1)
        own = np.ones(len(t), dtype=bool)
        own[looks[:, :-1]] = False
        return cls(np.vstack([np.flatnonzero(own)[cls.spread(int(own.sum()), most).rows], looks]))

    def beside(self, t: np.ndarray, changing: Signals | None) -> Windows:
        """Those in which no function of Python's jumps: to integrate over a jump tells nothing."""
        sharp = [
            part for s in (changing.signals if changing is not None else ()) for part in s.sharp
        ]
        ends = np.sort(t[self.rows[:, [0, -1]]], axis=1)
        meets = [(a <= ends[:, 1]) & (b >= ends[:, 0]) for a, b in sharp]
        return Windows(self.rows[~np.any(meets, axis=0)]) if meets else self

    def doubtful(self, t: np.ndarray, states: np.ndarray, rates: Rates) -> list[int]:
        """The windows whose states seem not to obey the equations, worst first; what the grid does
        not resolve is in no doubt here.

        ``states`` has shape (k, n), their times ``t`` (k,).
        """
        if not len(self.rows) or not states.shape[1]:
            return []
        used, where = np.unique(self.rows, return_inverse=True)
        slopes = rates(t[used], states[used])[where.reshape(self.rows.shape)]
        times, values = t[self.rows], states[self.rows]
        half = (times[:, -1:] - times[:, :1]) / 2
        inverse = _inverse_bases((times - times[:, :1]) / half - 1)
        good = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(values).all(axis=(1, 2))
        good &= np.abs(inverse).max(axis=(1, 2)) < ILL
        kept, half = np.flatnonzero(good), half[good]
        shares = np.broadcast_to(inverse, (len(times), WIDTH, WIDTH))[good] @ slopes[good]
        length = 2 * np.abs(half)
        defect = np.abs(values[good, -1] - values[good, 0] - 2 * half * shares[:, 0])
        allowed = DOUBT * length * np.abs(shares[:, -2:]).sum(axis=1)
        allowed += RELATIVE * length * np.abs(slopes[good]).max(axis=1)
        allowed += ROUNDING * np.maximum(1.0, np.abs(values[good]).max(axis=(1, 2)))[:, None]
        worst = (defect / allowed).max(axis=1)
        return [int(kept[i]) for i in np.argsort(-worst) if worst[i] > 1]


@dataclass(frozen=True)
class LookGrid:
    """A grid that is run on: the ``own`` one with instants ``added`` before some of its ``ends``,
    at which the equations are looked at."""

    own: np.ndarray
    added: np.ndarray = field(default_factory=lambda: np.empty(0))
    ends: np.ndarray = field(default_factory=lambda: np.empty(0))

    @classmethod
    def of(cls, problem: Problem, grid: np.ndarray) -> LookGrid:
        """Where a grid has fewer instants than a window, a part of the time before some of them in
        which the motion changes by as much as it is, at the start."""
        if not len(problem.start) or not 1 < len(grid) < WIDTH:
            return cls(grid)
        rates = program_rates(problem.program, lambda _: list(problem.parameters))
        slopes = rates(grid[:1].astype(float), problem.start[None, :].astype(float))[0]
        with np.errstate(all="ignore"):
            pace = np.min(natural_units(problem) / np.abs(slopes))
        ahead = np.diff(grid)
        before = _spread(len(ahead), LOOKS)
        length = np.minimum(RESOLUTION * pace, np.abs(ahead[before]) / 2)
        if not length.min() > FAR_APART * np.spacing(np.abs(grid).max()):
            return cls(grid)
        steps, ends = np.copysign(length, ahead[before]) / (WIDTH - 1), grid[before + 1]
        return cls(grid, (ends[:, None] - np.outer(steps, np.arange(1, WIDTH))).ravel(), ends)

    @property
    def whole(self) -> np.ndarray:
        """All instants, in order."""
        if not len(self.added):
            return self.own
        order = np.sign(self.own[-1] - self.own[0])
        return order * np.sort(order * np.concatenate([self.own, self.added]))

    def without_looks(self, run: Run) -> Run:
        """The run on its own grid."""
        if not len(self.added):
            return run
        kept = ~np.isin(run.t, self.added)
        return replace(run, t=run.t[kept], states=run.states[kept])


def _spread(size: int, most: int) -> np.ndarray:
    """As many of so many indices as may be, evenly spread, each once."""
    found = np.linspace(0, size - 1, most).astype(int)
    # numpy's unique loads its masked arrays
    return found[np.diff(found, prepend=-1) > 0]


def _inverse_bases(nodes: np.ndarray) -> np.ndarray:
    """From values at nodes (windows, WIDTH) to shares of Legendre polynomials: matrices, one for
    all windows where all have the same nodes."""
    if np.abs(nodes - nodes[0]).max() < SAME:
        nodes = nodes[:1]
    basis = np.ones((*nodes.shape, WIDTH))
    basis[..., 1] = nodes
    for k in range(2, WIDTH):
        basis[..., k] = (2 - 1 / k) * nodes * basis[..., k - 1] - (1 - 1 / k) * basis[..., k - 2]
    found = np.full_like(basis, np.inf)
    sound = np.linalg.det(basis) != 0
    found[sound] = np.linalg.inv(basis[sound])
    return found


def _is_affordable(steps: Any, tol: float) -> Any:
    """Whether windows that took so many steps can be integrated ``again`` within the budget."""
    return TWICE * steps * min(1.0, (tol / FINE) ** (1 / 8)) <= BUDGET


def again(
    rates: Rates, t: np.ndarray, states: np.ndarray, tol: float, steps: float = 0.0
) -> np.ndarray | None:
    """The defect of the last state of a window, by variable, in units of what is allowed: the
    motion is integrated again from the first state by a Runge-Kutta method.

    Also from a start nearby, which tells how far what the tolerance leaves open grows.  None where
    that cannot be done within the budget of evaluations.  ``steps`` are those that the motion took
    in the window by a method of order 8 or more: this one takes no fewer, unless it may be coarser.
    """
    if not _is_affordable(steps, tol):
        return None
    from scipy.integrate import DOP853

    size = np.maximum(1.0, np.abs(states).max(initial=0.0))
    left = [BUDGET]

    def single(time: float, state: np.ndarray) -> np.ndarray:
        left[0] -= 1
        if left[0] < 0:
            raise _OverBudget
        return rates(np.array([time]), state[None, :])[0]

    ends = []
    for start in (states[0], states[0] + NEARBY * size * _signs(states.shape[1])):
        solver = DOP853(single, t[0], start, t[-1], rtol=FINE, atol=FINE)
        try:
            with np.errstate(all="ignore"):
                while solver.status == "running":
                    solver.step()
        except (_OverBudget, ValueError):
            return None
        if solver.status != "finished" or not np.isfinite(solver.y).all():
            return None
        ends.append(solver.y)
    grown = np.abs(ends[1] - ends[0]) / NEARBY
    allowed = RELATIVE * size + MARGIN * max(tol, FINE) * grown
    return np.asarray(np.abs(states[-1] - ends[0]) / allowed)


class _OverBudget(Exception):
    """More evaluations than there were to spend."""


def _signs(count: int) -> np.ndarray:
    return np.where(np.arange(count) % 2, -1.0, 1.0)


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
MOST, FEW, EACH = 128, 12, 4
"""Windows in which the equations that were integrated are looked at, and the original ones, and
those of each of many motions."""
DISOBEDIENT = "the states do not obey the equations"
WORST = 3
"""Windows in doubt, of each motion, that are integrated again."""
SLOPE = 6e-6
"""The step of difference quotients: the cube root of the rounding."""


@dataclass(frozen=True)
class Breach:
    """What went wrong, in words, and the last row of the grid before it was seen; what is wrong of
    a ``claim`` alone is only to be told."""

    what: str
    row: int
    claim: bool = False


MERE_CLAIM = "is only claimed"


def _drift_note(name: str, why: str, time: float, amount: str) -> str:
    return f"the integral '{name}' {why}, and drifts: at t = {time:.6g} it has changed {amount}"


@dataclass(frozen=True)
class Judge:
    """What is known of a run: its program at ``values`` of the parameters, with a tolerance.

    ``integrals`` and ``relations`` name extra quantities of the program, and those that give the
    size of the terms; ``vanishing`` are further relations, expressions in the program's symbols;
    parameters that are ``changing`` are those of the start among the ``values``; of integrals that
    are ``jumping`` with the forces no proof holds across the jumps.  Before the instants ``looks``
    the grid has more, for the equations' sake.
    """

    equations: VoronecEquations
    program: Program
    values: Sequence[float]
    tol: float
    steps: int
    integrals: Mapping[str, tuple[str, str]]
    relations: Mapping[str, str]
    vanishing: Sequence[Any] = ()
    changing: Signals | None = None
    jumping: bool = False
    looks: np.ndarray = field(default_factory=lambda: np.empty(0))

    def breach(self, t: np.ndarray, states: np.ndarray) -> tuple[Breach | None, tuple[str, ...]]:
        """What went wrong first, if anything did, and what is to be said of mere claims."""
        found, notes = self._losses(t, states)
        rates = program_rates(self.program, self.at)
        found += disobedient(
            t, states, rates, self.tol, Windows.of(t, MOST, self.looks), self.changing
        )
        return min(found, key=lambda b: b.row, default=None), notes

    def check_integrals(
        self, t: np.ndarray, states: np.ndarray
    ) -> tuple[Breach | None, tuple[str, ...]]:
        """The same of integrals and relations alone."""
        found, notes = self._losses(t, states)
        return min(found, key=lambda b: b.row, default=None), notes

    def at(self, t: np.ndarray) -> list[Any]:
        """The values of the parameters at times (k,): doubles, or arrays of them."""
        return values_along(self.changing, map(str, self.program.parameters), self.values, t)

    def original(
        self, t: np.ndarray, states: np.ndarray, constants: Mapping[str, Any]
    ) -> Breach | None:
        """The same of coordinates and velocities (k, n), by the equations derived first."""
        if len(t) < WIDTH:
            return None
        rates = original_rates(self.equations, constants, self.changing)
        if rates is None:
            return None
        found = disobedient(
            t, states, rates, self.tol, Windows.of(t, FEW, self.looks), self.changing
        )
        return min(found, key=lambda b: b.row, default=None)

    def _losses(self, t: np.ndarray, states: np.ndarray) -> tuple[list[Breach], tuple[str, ...]]:
        rows = _spread(len(t), ROWS)
        relations = {name: (key, "") for name, key in self.relations.items()}
        relations |= {f"{e} = 0": (f"vanishing {e}", "") for e in self.vanishing}
        conserved = ConservedQuantities({**self.integrals, **relations}, self._extras())
        breaches, notes = [], []
        lost = conserved.losses(t[rows], states[rows], self.tol, self.steps)
        for name, (i, change, allowed) in lost.items():
            amount = f"by {change:.2g}, where the tolerance allows {allowed:.2g}"
            if name in relations:
                breaches.append(Breach(f"the relation {name} is lost {amount}", int(rows[i - 1])))
            elif self._is_certain(name):
                breaches.append(Breach(f"the integral '{name}' drifts {amount}", int(rows[i - 1])))
            else:
                why = "jumps with the forces" if self.jumping else MERE_CLAIM
                notes.append(_drift_note(name, why, t[rows[i]], amount))
        return breaches, tuple(notes)

    def _is_certain(self, name: str) -> bool:
        """Whether an integral must stay: proofs take parameters for constants, and hold between
        jumps."""
        if self.jumping or self.changing is not None:
            return False
        return is_proved(self.equations, self.equations.system.integrals[name])

    def _extras(self) -> Callable[[np.ndarray, np.ndarray], Mapping[str, np.ndarray]]:
        program = self.program
        inputs = (program.time, *program.state, *program.parameters)
        further = _function(inputs, tuple(self.vanishing)) if self.vanishing else None

        def extras(t: np.ndarray, states: np.ndarray) -> Mapping[str, np.ndarray]:
            given = self.at(t)
            found = evaluate_extras(program, t, states, given)
            if further is not None:
                wide = [np.broadcast_to(x, t.shape) for x in given]
                columns = further(np.column_stack([t, states, *wide])).reshape(len(t), -1).T
                names = (f"vanishing {e}" for e in self.vanishing)
                found |= zip(names, columns, strict=True)
            return found

        return extras


def disobedient(
    t: np.ndarray, states: np.ndarray, rates: Rates, tol: float, among: Windows,
    changing: Signals | None = None,
) -> list[Breach]:  # fmt: skip
    """Windows of the grid, ``among`` some, whose states do not obey the equations; what seems not
    to is integrated again."""
    windows = among.beside(t, changing)
    found = []
    for i in windows.doubtful(t, states, rates)[:WORST]:
        rows = windows.rows[i]
        off = again(rates, t[rows], states[rows], tol)
        if off is not None and off.max() > 1:
            found.append(Breach(DISOBEDIENT, int(rows[0])))
    return found


@dataclass(frozen=True)
class ConservedQuantities:
    """Quantities that must stay: ``names`` of extra quantities of a program, and of those which
    give the size of their terms (empty where these are not known).

    ``extras(t, states)`` gives all quantities of the program at times (k,) and states (k, n).
    """

    names: Mapping[str, tuple[str, str]]
    extras: Callable[[np.ndarray, np.ndarray], Mapping[str, np.ndarray]]

    def losses(
        self, t: np.ndarray, states: np.ndarray, tol: float, steps: int
    ) -> dict[str, tuple[int, float, float]]:
        """Of those that did not stay: the row where that is seen first, the change and what is
        allowed there."""
        if len(t) < 2:
            return {}
        values = self.extras(t, states)
        off = [abs(values[key][0]) for key, size in self.names.values() if not size]
        share = np.abs(t - t[0]) / abs(t[-1] - t[0])
        per_unit = LOOSE * max(tol, UNIT) * (FREE + steps * share)
        per_unit = per_unit + LOOSE * np.nan_to_num(max(off, default=0.0))
        found = {}
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
                found[name] = int(rows[bad[0]]), float(change[bad[0]]), float(allowed[bad[0]])
        return found

    def _around(self, key: str, t: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """By how much a quantity changes, to first order, with each variable by its size, at least
        one unit, or by that of the largest: what tolerances are relative to; and by how much it is
        off the mean of its values on both sides, which says whether it has one."""
        largest = np.maximum(1.0, np.abs(states).max(axis=1, initial=0.0))
        here, total, rough = self.extras(t, states)[key], np.zeros(len(t)), np.zeros(len(t))
        for j in range(states.shape[1]):
            step = SLOPE * np.maximum(np.abs(states[:, j]), 1e-3)
            ends = []
            for sign in (1, -1):
                moved = states.copy()
                moved[:, j] += sign * step
                ends.append(self.extras(t, moved)[key])
            with np.errstate(all="ignore"):
                total += np.abs(ends[0] - ends[1]) / (2 * step)
                rough = np.fmax(rough, np.abs(here - (ends[0] + ends[1]) / 2))
        return total * largest, rough


def _scale(sizes: np.ndarray) -> np.ndarray:
    """Sizes at the instants compared: here, at the start, and along the way, where a single large
    one counts for nothing."""
    return np.maximum(np.nan_to_num(sizes, nan=np.inf), max(float(sizes[0]), usual_size(sizes)))


@lru_cache(maxsize=32)  # runs of one system have the same relations
def _function(inputs: tuple[Any, ...], exprs: tuple[Any, ...]) -> Any:
    return se.Lambdify(list(inputs), list(exprs), **HASTE)


def is_proved(equations: VoronecEquations, integral: Any) -> bool:
    """Whether a claimed integral is proved to be one, and no motion can change over to another of
    its branches; where that exceeds the budget, it is not."""
    function = right_of(integral)
    try:
        field = Motions.of(equations).field_for([function])
        read = field.read_with_momenta(function)
        rate = field.derivative(read)
        return not is_many_valued(read) and bool(all_vanish([rate], field.relations))
    except VoronecError:
        return False


def program_rates(program: Program, at: Callable[[np.ndarray], list[Any]]) -> Rates:
    """The right-hand side that was integrated, ``at`` giving its parameters at times (k,)."""
    rhs = compile_program(program)[0]

    def rates(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        with np.errstate(all="ignore"):
            found = rhs(t, list(states.T), at(t))
        return np.stack([np.broadcast_to(np.asarray(r, float), t.shape) for r in found], axis=-1)

    return rates


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
    names = [str(p) for p in form.parameters]
    still = {name: float(constants.get(name, np.nan)) for name in names}

    def rates(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        given = still if changing is None else still | changing.along(t)
        wide = [np.broadcast_to(np.asarray(given[name], float), t.shape) for name in names]
        rows = np.asarray(evaluate(np.column_stack([t, states, *wide])), dtype=float)
        rows = rows.reshape(len(t), -1)
        result = np.full(states.shape, np.nan)
        result[:, :width] = rows[:, :width]
        sound = np.isfinite(rows).all(axis=1)
        if n:
            mass = rows[:, width : width + n * n].reshape(-1, n, n)
            sizes = np.abs(np.linalg.eigvalsh(mass[sound]))
            sound[sound] = sizes.max(axis=1) / REGULAR < sizes.min(axis=1)
            force = rows[sound, width + n * n :, None]
            result[sound, width:] = np.linalg.solve(mass[sound], force)[:, :, 0]
        result[~sound] = np.nan
        return result

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


@dataclass(frozen=True)
class JudgeOfMany:
    """The same of motions of one program, each with values of its own.

    ``integrals`` maps names of integrals to those of extra quantities of the program.
    """

    equations: VoronecEquations
    program: Program
    tol: float
    integrals: Mapping[str, str]
    _proofs: dict[str, bool] = field(default_factory=dict)

    def breaches(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray, steps: float
    ) -> tuple[dict[int, Breach], dict[int, tuple[str, ...]]]:
        """What went wrong with which motion, and what is to be said of mere claims: states
        (m, k, n) at ``t`` (k,), parameters (m, p); each took so many steps."""
        found, notes = self._disobedient(t, states, values, steps), dict[int, tuple[str, ...]]()
        for i, breach in self.losses(np.broadcast_to(t, states.shape[:2]), states, values, steps):
            if breach.claim:
                notes[i] = (*notes.get(i, ()), breach.what)
            elif i not in found or breach.row < found[i].row:
                found[i] = breach
        return found, notes

    def losses(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray, steps: float
    ) -> Iterator[tuple[int, Breach]]:
        """The motions that lost an integral, with times (m, k) of their own."""
        each = np.broadcast_to(values[:, None, :], (*t.shape, values.shape[-1]))
        extras = compile_program(self.program)[1]
        series = at_each(extras, self.program.names, t, states, each)
        for name, key in self.integrals.items():
            change, size = np.abs(series[key] - series[key][:, :1]), np.abs(series[key][:, :1])
            allowed = LOOSE * max(self.tol, UNIT) * FREE * size
            for i in np.flatnonzero((change > allowed).any(axis=1)):
                whole = np.isfinite(states[i]).all(axis=1)
                breach = self._judge(name, key, t[i][whole], states[i][whole], values[i], steps)
                if breach is not None:
                    yield int(i), breach

    def _judge(
        self,
        name: str,
        key: str,
        t: np.ndarray,
        states: np.ndarray,
        values: np.ndarray,
        steps: float,
    ) -> Breach | None:
        function, names = compile_program(self.program)[1], self.program.names

        def extras(times: np.ndarray, rows: np.ndarray) -> Mapping[str, np.ndarray]:
            each = np.broadcast_to(values, (len(rows), len(values)))
            return at_each(function, names, times, rows, each)

        lost = ConservedQuantities({name: (key, key)}, extras).losses(
            t, states, self.tol, int(steps)
        )
        if name not in lost:
            return None
        row, change, allowed = lost[name]
        amount = f"by {change:.2g}, where the tolerance allows {allowed:.2g}"
        if not self._is_proved(name):
            return Breach(_drift_note(name, MERE_CLAIM, t[row], amount), row, claim=True)
        return Breach(f"the integral '{name}' drifts {amount}", row - 1)

    def _is_proved(self, name: str) -> bool:
        if name not in self._proofs:
            own = self.equations
            self._proofs[name] = is_proved(own, own.system.integrals[name])
        return self._proofs[name]

    def _disobedient(
        self, t: np.ndarray, states: np.ndarray, values: np.ndarray, steps: float
    ) -> dict[int, Breach]:
        """Motions whose states do not obey the equations, in a few windows of each, such as can be
        integrated again; to the windows they are one long motion, and the parameters variables at
        rest."""
        count, size, n = states.shape
        single = Windows.spread(size, EACH).rows
        parts = np.ptp(t[single], axis=1) / (np.ptp(t) or 1.0)
        single = single[_is_affordable(steps * parts, self.tol)]
        if not len(single):
            return {}
        windows = Windows((size * np.arange(count)[:, None, None] + single).reshape(-1, WIDTH))
        each = np.broadcast_to(values[:, None, :], (count, size, values.shape[-1]))
        joined = np.concatenate([states, each], axis=-1).reshape(count * size, -1)
        rhs = compile_program(self.program)[0]

        def rates(times: np.ndarray, rows: np.ndarray) -> np.ndarray:
            with np.errstate(all="ignore"):
                slopes = rhs(times, list(rows.T[:n]), list(rows.T[n:]))
            result = np.zeros(rows.shape)
            for j, slope in enumerate(slopes):
                result[:, j] = slope
            return result

        times, found = np.tile(t, count), {}
        looks = dict.fromkeys(range(count), WORST)
        for w in windows.doubtful(times, joined, rates):
            rows = windows.rows[w]
            i = int(rows[0] // size)
            looks[i] -= 1
            if i in found or looks[i] < 0:
                continue
            one = _rates_of_one(self.program, values[i])
            part = float(np.ptp(times[rows]) / np.ptp(t))
            off = again(one, times[rows], joined[rows, :n], self.tol, steps * part)
            if off is not None and off.max() > 1:
                found[i] = Breach(DISOBEDIENT, int(rows[0] % size))
        return found


def _rates_of_one(program: Program, values: np.ndarray) -> Rates:
    """The rates of one state at a time, with parameters (p,): numbers cost less than arrays."""
    rhs, constants = compile_program(program, scalar=True)[0], values.tolist()

    def rates(times: np.ndarray, rows: np.ndarray) -> np.ndarray:
        try:
            return np.array([rhs(float(times[0]), rows[0].tolist(), constants)], dtype=float)
        except (ZeroDivisionError, ValueError, OverflowError):
            return np.full(rows.shape, np.nan)

    return rates


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
