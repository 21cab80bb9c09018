"""Where coordinates are singular: poles of Euler's angles, and directions in which nothing moves.

A run in coordinates that are singular at poles watches these.  At a pole of angles two of them turn
about one axis.  A chart f that is regular there tells such directions apart: with q' = f(q) they
are the null vectors of df/dq.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from random import Random
from typing import Any, NamedTuple

import numpy as np
import symengine as se

from voronec.algebra.symbols import plain_name
from voronec.algebra.verdicts import all_vanish
from voronec.declaration.charts import Chart
from voronec.equations.attitudes import EulerAngles, angles_without_chart, euler_angles
from voronec.equations.program import Program, compile_program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import IntegrationError
from voronec.motion.constraint_geometry import ConstraintGeometry, numbers_of_chart, pole_factors
from voronec.motion.numeric_model import ProgrammedModel
from voronec.motion.singular_denominators import with_events
from voronec.motion.state_probe import quantities, quiet
from voronec.motion.steppers import Problem, Run, Termination

NEAR_POLE = "a pole of the angles is near"
"""Begins the names of the events, one for each body."""
LAST = se.Rational(1, 10**6)
"""No run passes a pole nearer than this in coordinates that are singular there: what is lost in
digits is the inverse of such a number."""
PASSAGE = "a pole of the coordinates is passed"
"""The name of an event that nobody asked for, and that stops nothing."""
BEYOND = f"the motion comes within {float(LAST):g} of a pole of its angles, where no chart leads on"
LARGE = 1e12
"""Rates beyond this, for a state of ordinary size, are a division by zero."""
POLE = 1e-6
"""At a pole of angles sines, and parts of unit vectors that vanish there, are below this."""
FINE = se.Rational(1, 10**5)
"""Nearer to poles beyond which declared charts lead, angles that are carried along on invariants
lose more than 1e-11 by rounding, the inverse of this times that of doubles."""


class NearPole(IntegrationError):
    """A motion has come, or starts, near a pole of angles at which its equations are singular."""


class CoordinatePole(NamedTuple):
    """Where an ``angle``, or a radius, has a ``value``, coordinates are singular; ``distance`` is
    a function of it that vanishes there, and at other poles of that angle.  ``near`` is how small
    it may be, where that is not left to the guard."""

    angle: Any
    value: float
    distance: Any
    near: Any = None

    @classmethod
    def of_charts(cls, equations: VoronecEquations) -> tuple[CoordinatePole, ...]:
        """Those at which a declared chart of the system begins, for models without charts."""
        return tuple(
            cls(angle, value, factor, FINE)
            for factor in sorted(pole_factors(equations), key=str)
            for angle in (factor.free_symbols if len(factor.free_symbols) == 1 else ())
            for value in (0.0, np.pi / 2)
            if abs(float(factor.subs({angle: value}))) < POLE
        )

    @classmethod
    def of_attitudes(cls, triples: Iterable[EulerAngles]) -> tuple[CoordinatePole, ...]:
        """Those of Euler's angles, or of longitude and colatitude."""
        return tuple(cls(t.theta, -float(t.shift), t.singular) for t in triples)


@dataclass(frozen=True)
class PoleNotes:
    """Looks where a run passes through poles at which its own equations are regular, as those of a
    special motion may be: angles change by half a turn there, or go on, and nothing tells which.

    ``levels`` are the factors of what vanishes at the poles of charts and of Euler's angles, on
    the model, by name.
    """

    levels: Mapping[str, Any]

    @classmethod
    def of(
        cls,
        equations: VoronecEquations,
        variables: Iterable[Any],
        outputs: Iterable[str],
        charted: bool,
        guard: PoleGuard | None = None,
    ) -> PoleNotes:
        """Nothing to look at where no coordinate is among the ``outputs``, or the model does not
        hold the angle between poles among its variables; where a ``guard`` stops the run before a
        pole, or where it is ``charted``, goes through the charts of the system, which look out for
        their own."""
        if {*outputs}.isdisjoint(map(plain_name, equations.system.coordinates)):
            return cls({})
        attitudes = CoordinatePole.of_attitudes(angles_without_chart(equations))
        charts = () if charted else CoordinatePole.of_charts(equations)
        levels = () if guard is None else guard.levels.values()
        held = {*variables}.difference(*(e.free_symbols for e in levels))
        known = [p.distance for p in (*charts, *attitudes) if p.angle in held]
        return cls({f"{PASSAGE} {i}": e for i, e in enumerate(known)})

    def watch(self, problem: Problem, form: Any, functions: Mapping[str, Any]) -> Problem:
        """The problem, with the poles among its events."""
        return with_events(problem, form, functions, self.levels) if self.levels else problem

    def with_notes(self, run: Run) -> Run:
        """The run without the passages that were watched, and with a note of them."""
        if not self.levels:
            return run
        times = [float(t) for name in self.levels for t in run.crossings.get(name, ((),))[0]]
        order = 1 if run.t[-1] >= run.t[0] else -1
        passages = sorted((t for t in times if t != run.t[0]), key=lambda t: order * t)
        run = run.without({*self.levels})
        return replace(run, notes=(*run.notes, *passage_notes(passages)))


def passage_notes(times: Sequence[float]) -> tuple[str, ...]:
    """What is to be said of a run that passes through poles of its coordinates."""
    if not times:
        return ()
    often = f", the first of {len(times)} times" if len(times) > 1 else ""
    return (
        f"at t = {times[0]:.12g}{often} the motion passes through a pole of the coordinates: "
        "angles after it are known up to whole turns",
    )


@dataclass(frozen=True)
class PoleGuard:
    """Stops a run where one of ``levels``, functions on its model by name, is no longer positive:
    so ``near`` to a pole is the sine of a polar angle."""

    name: str
    program: Program
    levels: Mapping[str, Any]
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
        poles: Iterable[CoordinatePole],
    ) -> PoleGuard | None:
        """None where no equation of the model is singular at any of the ``poles``.

        ``start`` (n,) is on the coordinates.
        """
        levels = [
            (_distance(equations, made, pole), pole.near or near)
            for pole in poles
            if _is_singular(equations, made, pole, start, constants, time)
        ]
        # not their product, which is positive where two bodies are at poles at once
        margins = {
            f"{NEAR_POLE} {i}": d - radius**2
            for i, (d, radius) in enumerate(levels)
            if d is not None
        }
        if not margins:
            return None
        return cls(equations.system.name, made.program, margins, made.form, near)

    def check(self, state: np.ndarray, values: Sequence[float], time: float) -> None:
        """Raise an error for a start that is near one: ``NearPole`` where charts are still to be
        tried."""
        program = self._levels
        constants = dict(zip(map(str, self.program.parameters), values, strict=True))
        given = [constants[str(p)] for p in program.parameters]
        if all(value > 0 for value in quiet(compile_program(program)[1], given)(time, list(state))):
            return
        if self.near != LAST:
            raise self._near(time, state)
        raise IntegrationError(
            f"system '{self.name}': {BEYOND}, at the initial point; start elsewhere", time, state
        )

    @cached_property
    def _levels(self) -> Program:
        return quantities(self.form, self.levels)

    def watch(self, problem: Problem, functions: Mapping[str, Any], grid: np.ndarray) -> Problem:
        """The problem, with the poles among its events, whose ``functions`` go by name."""
        order = 1 if grid[-1] >= grid[0] else -1
        return with_events(problem, self.form, functions, self.levels, direction=-order, stop=True)

    def without_poles(self, run: Run) -> Run:
        """The run without the poles among its events; raises ``NearPole`` where it has come near
        one, and charts are still to be tried."""
        names = {*self.levels}
        if run.stopped not in names:
            return run.without(names)
        if self.near != LAST:
            raise self._near(run.t[-1], run.states[-1])
        halt = Termination(BEYOND, run.t[-1], run.states[-1])
        return replace(run.without(names), stopped="", halt=halt)

    def _near(self, time: float, state: np.ndarray) -> NearPole:
        return NearPole(
            f"system '{self.name}': the motion comes near a pole of its angles at t = {time:.12g}",
            time,
            state,
        )


def _distance(
    equations: VoronecEquations, made: ProgrammedModel, pole: CoordinatePole
) -> Any | None:
    """The square of what vanishes at a pole, on a model; None where it has none."""
    variables = {*made.program.state, *made.program.parameters}
    if pole.angle in variables:
        return pole.distance**2
    for name, g in equations.system.invariants.items():
        invariant, symbol = equations.bridge.inward(g), se.Symbol(name)
        alone = invariant.free_symbols == {pole.angle}
        if symbol in variables and alone and all_vanish([invariant**2 + pole.distance**2 - 1]):
            return 1 - symbol**2
    return None


def _is_singular(
    equations: VoronecEquations,
    made: ProgrammedModel,
    pole: CoordinatePole,
    start: np.ndarray,
    constants: Mapping[str, float],
    time: float,
) -> bool:
    """Whether rates of a model are infinite at a pole, for a state that is arbitrary else."""
    if not {*equations.definition.coordinates} & {*made.program.state}:
        return False
    dice = Random(0)
    state = np.array([dice.uniform(0.5, 1.5) for _ in start])
    state[equations.definition.coordinates.index(pole.angle)] = pole.value
    model, values = made.place(state, constants, time)
    rates = quiet(compile_program(made.program)[0], values)(time, list(model))
    sizes = np.abs(np.array(rates, dtype=float))
    return bool((~(sizes < LARGE)).any())


def blind_directions(ground: ConstraintGeometry, wide: np.ndarray) -> np.ndarray:
    """An orthonormal basis (N, k) of the directions in which coordinates may change at a wide state
    though nothing moves; k is zero where coordinates are regular."""
    if ground.home.definition.group is not None:
        return np.zeros((len(ground.home.definition.dots), 0))
    directions = [
        polar_directions(ground.home, wide),
        charted_directions(ground, wide),
        carried_directions(ground, wide),
    ]
    vectors, sizes, _ = np.linalg.svd(np.hstack(directions), full_matrices=False)
    return np.asarray(vectors[:, sizes > POLE])


def polar_directions(equations: VoronecEquations, state: np.ndarray) -> np.ndarray:
    """Directions (N, k), of unit length, in which Euler's angles may change at their poles while
    the attitude stays; k is zero where a state (coordinates first) is at none.

    Rz(phi) Rx(c) Rz(s psi) knows only phi + s psi where c = 0, and phi - s psi where c = pi.
    """
    d, directions = equations.definition, []
    for angles in euler_angles(equations):
        polar = float(state[d.coordinates.index(angles.theta)]) + float(angles.shift)
        if abs(np.sin(polar)) < POLE:
            direction = np.zeros(len(d.dots))
            for x, rate in angles.blind.items():
                direction[d.coordinates.index(x)] = rate.subs({angles.theta: polar - angles.shift})
            directions.append(direction / np.linalg.norm(direction))
    return np.array(directions).reshape(-1, len(d.dots)).T


def charted_directions(ground: ConstraintGeometry, wide: np.ndarray) -> np.ndarray:
    """An orthonormal basis (N, k) of what the declared chart that is best at a wide state does not
    see; k is zero where the system's own coordinates are regular, or no chart is."""
    system = ground.home.system
    none = np.zeros((len(ground.home.definition.dots), 0))
    if ground.home.definition.group is not None:
        return none
    if not any(_may_be_singular(ground, chart, wide) for chart in system.charts.values()):
        return none  # as of most starts: no slopes are derived
    looked = [_distances(ground, chart, wide) for chart in system.charts.values()]
    here, there, slopes = max(looked, key=lambda found: found[1], default=(1.0, 0.0, none))
    if not here < POLE or not there > POLE:
        return none
    _, sizes, basis = np.linalg.svd(slopes)
    return np.asarray(basis[sizes < POLE * sizes.max()].T)


def carried_directions(ground: ConstraintGeometry, wide: np.ndarray) -> np.ndarray:
    """An orthonormal basis (N, k) of the directions in which coordinates without inertia may change
    at a wide state: carried along by others, they have a pole there."""
    count = len(ground.home.definition.coordinates)
    rest = np.zeros(len(wide) - count)
    q = wide[:count].astype(float)
    masses = [ground.mass(ground.time, np.concatenate([x, rest])) for x in (q, q + BESIDE)]
    rows = ground.rows(ground.time, np.concatenate([q, rest]))[0][:, :-1]
    table = np.vstack([rows, *masses])
    if not np.isfinite(table).all():
        return np.zeros((len(rest), 0))
    sizes = np.linalg.norm(table, axis=1, keepdims=True)
    _, values, basis = np.linalg.svd(table / np.where(sizes > 0, sizes, 1.0))
    return np.asarray(basis[values < POLE * values.max(initial=0.0)].T)


IDLE, BESIDE = 1e-15, 0.1
"""A metric is singular where an eigenvalue is below the one, which is rounding, in units in which
its diagonal is one where all coordinates are larger by the other, if it is not singular there."""


def idle_directions(ground: ConstraintGeometry, wide: np.ndarray) -> np.ndarray:
    """A basis (N, k) of the directions in which coordinates may change at a wide state though
    neither inertia nor constraints resist, while they do beside it: the contact of a disc that lies
    flat may be any point of its rim."""
    count = len(ground.home.definition.coordinates)
    rest = np.zeros(len(wide) - count)
    here, beside = (
        ground.metric(ground.time, np.concatenate([wide[:count] + step, rest]))
        for step in (0.0, BESIDE)
    )
    units = np.sqrt(np.abs(np.diag(beside)))
    if not (np.isfinite([here, beside]).all() and units.all()):
        return np.zeros((len(units), 0))
    scale = np.outer(units, units)
    sizes, vectors = np.linalg.eigh(here / scale)
    regular = np.linalg.eigvalsh(beside / scale) > POLE**2
    return np.asarray((vectors / units[:, None])[:, (sizes < IDLE) & regular])


def _may_be_singular(ground: ConstraintGeometry, chart: Chart, wide: np.ndarray) -> bool:
    """Whether the own coordinates may be singular at a wide state, where a chart is declared."""
    d = ground.home.definition
    at = {se.Symbol(name): se.RealDouble(float(x)) for name, x in ground.constants.items()}
    at |= {q: se.RealDouble(float(x)) for q, x in zip(d.coordinates, wide, strict=False)}
    try:
        return abs(float(d.bridge.inward(chart.singular).xreplace(at).n(real=True))) < POLE
    except (ArithmeticError, RuntimeError, TypeError, ValueError):
        return True  # of the time, or no number there: the slopes tell


def open_beyond(rows: np.ndarray, blind: np.ndarray) -> np.ndarray:
    """Directions (N, k) that conditions with such rows leave open, less their parts along blind
    ones; what is left is small where nothing that moves is open."""
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    _, values, basis = np.linalg.svd(rows / np.where(sizes > 0, sizes, 1.0))
    rank = int((values > POLE * values.max(initial=0.0)).sum())
    ways = basis[rank:].T
    return np.asarray(ways - blind @ (blind.T @ ways))


def _distances(
    ground: ConstraintGeometry, chart: Chart, wide: np.ndarray
) -> tuple[float, float, Any]:
    """How far a wide state is from the singularities of the own coordinates and of a chart, 0 where
    the chart has no value, and df/dq."""
    numbers = numbers_of_chart(ground, chart, ground.time, wide.astype(float))
    if numbers is None:
        return 1.0, 0.0, None
    singular, there, *slopes = numbers
    if not np.isfinite(slopes).all():
        return abs(singular), 0.0, None
    count = len(ground.home.definition.coordinates)
    return abs(singular), abs(there), np.array(slopes).reshape(count, -1)
