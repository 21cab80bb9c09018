"""Poincare sections: the points at which motions of one system pass through a surface.

Lanes of a batch carry one smooth right side.  Motions whose inputs change in time by tables or
functions, those through switching surfaces and those that fail in lanes are each made by
``integrate``, where passages through the surface are events on the way.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.arguments import (
    CALLABLE,
    COUNT,
    FLAG,
    SEVERAL,
    TEXT,
    TOLERANCE,
    VALUES,
    accepts,
)
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import formula
from voronec.declaration.scene import Scene
from voronec.declaration.system import System, require_system
from voronec.equations.motions import Motions
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError
from voronec.motion.batches import choose_lanes, require_method
from voronec.motion.ensembles import ensemble
from voronec.motion.inputs import drive
from voronec.motion.motion_pool import Drifts, Many, many
from voronec.motion.one_by_one import (
    LoneMotions,
    go_on_alone,
    pass_one_by_one,
)
from voronec.motion.request import (
    Namespace,
    Starts,
    Values,
    begin_of,
    held_name,
    number,
    outputs_of,
    quantity,
    scene_of,
    spread_starts,
)
from voronec.motion.section_passages import (
    FOREVER,
    MotionPassages,
    SectionPassages,
    SectionWatch,
    pass_lanes,
)
from voronec.motion.state_probe import at_each
from voronec.motion.steppers import by_owner, with_parts
from voronec.motion.tolerances import EXACT, FINEST
from voronec.motion.trajectory import Cost
from voronec.motion.verify import CheckOfMany

if TYPE_CHECKING:
    from voronec.motion.storage import NamedArrays

EQUAL = 1e-12
"""How far the integrals may differ, relative to their size."""
TRIES = 40
"""Directions tried for each start that is wanted."""

Integrals = Callable[[np.ndarray], np.ndarray]
"""States (s, n) to the values (s, k) that all starts are to share."""


def starts_alike(
    equations: VoronecEquations,
    scene: Scene | None,
    initial: Mapping[Any, Any],
    parameters: Mapping[Any, Any],
    count: int,
    seed: int = 1,
) -> list[dict[str, float]]:
    """The start of the scene, and others in all directions about it with the same integrals.

    Velocities are turned and stretched at random (by ``seed``), coordinates moved a little;
    Newton steps of least length then lead back to these values.  ``DefinitionError`` where
    the system declares no integral, or no other start is found.
    """
    system = equations.system
    if not system.integrals:
        raise DefinitionError(
            f"system '{system.name}' declares no integral, so no starts alike are known; "
            "give starts as arrays of initial values"
        )
    motions = many(equations, scene, Starts.of([initial]), parameters, {}, begin_of(scene))
    if motions.wrong:
        raise motions.wrong[0]
    names = [plain_name(x) for x in (*system.coordinates, *system.velocities)]
    base, integrals = motions.full[0], _integrals(motions)
    random = np.random.default_rng(seed)
    states, width = [base], len(system.velocities)
    target = integrals(base[None])[0]
    for _ in range(TRIES * count):
        if len(states) == count:
            break
        led = _lead_back(integrals, _aside(base, width, random), target)
        if led is not None:
            states.append(led)
    if len(states) < count:
        raise DefinitionError(
            f"system '{system.name}': only {len(states)} starts with the same integrals were "
            "found; give starts as arrays of initial values"
        )
    return [dict(zip(names, x.tolist(), strict=True)) for x in states]


def _integrals(motions: Many) -> Integrals:
    """All integrals, and the relations between redundant coordinates, at states (s, n)."""
    quantities = dict(motions.ground.integrals)
    relations = motions.namespace.equations.form.relations
    quantities |= {f"relation {k}": e for k, e in enumerate(relations)}
    program = Program.of(motions.ground.form, quantities)
    extras = compile_program(program)[1]

    def integrals(states: np.ndarray) -> np.ndarray:
        rows = np.broadcast_to(motions.values[:1], (len(states), motions.values.shape[1]))
        columns = at_each(extras, program.names, motions.time, states, rows)
        return np.stack(list(columns.values()), axis=-1)

    return integrals


def _aside(base: np.ndarray, width: int, random: np.random.Generator) -> np.ndarray:
    """A state near another: its ``width`` velocities turned, its coordinates moved a little."""
    guess = base.copy()
    turn = random.normal(size=width)
    speed = np.linalg.norm(base[-width:]) if width else 0.0
    guess[-width:] = turn / np.linalg.norm(turn) * (speed or 1.0)
    guess[:-width] += 0.3 * random.normal(size=len(base) - width)
    return guess


def _lead_back(integrals: Integrals, guess: np.ndarray, target: np.ndarray) -> np.ndarray | None:
    """The nearest state with these integrals, by Newton steps of least length; None where they
    fail."""
    x, size = guess, 1.0 + np.abs(target)
    step = 1e-6 * (1.0 + np.abs(guess))
    for _ in range(30):
        shifts = np.diag(step)
        around = integrals(np.vstack([x[None], x + shifts, x - shifts]))
        off, n = around[0] - target, len(x)
        if not np.isfinite(around).all():
            return None
        if (np.abs(off) <= EQUAL * size).all():
            return np.asarray(x)
        slopes = ((around[1 : n + 1] - around[n + 1 :]) / (2 * step[:, None])).T
        change = np.linalg.lstsq(slopes, off, rcond=1e-10)[0]
        # a long step would leave the place where the slopes hold
        x = x - change * min(1.0, 1.0 / (np.linalg.norm(change) + 1e-300))
    return None


INSTANTS = 4001
"""Of the trial: a quantity that comes back often is seen to do so."""
RETURNS = 3
"""How often a quantity must come back within the trial."""
STILL = 1e-9
"""A quantity whose range is below this part of its size does not move."""
LONGER = 5.0
"""The trial, in spans of the scene."""


@dataclass(frozen=True)
class SectionSurface:
    """plane = value, and what is worth recording there."""

    plane: str
    value: float
    outputs: tuple[str, ...]


def suggest_surface(
    equations: VoronecEquations,
    scene: Any = None,
    initial: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    plane: str | None = None,
) -> SectionSurface:
    """The first position or velocity that oscillates along the scene's motion, at zero or else at
    the middle of its range; and a further position and velocity that move.  Where ``plane`` names
    the surface, only the outputs are suggested.

    Positions are the invariants where the system descends to them.  ``DefinitionError`` with the
    names there are where nothing oscillates.
    """
    system = equations.system
    chosen = scene_of(system, scene, True)
    assert chosen is not None
    positions = [*system.invariants] or [plain_name(q) for q in system.coordinates]
    velocities = [plain_name(v) for v in system.velocities]
    start, end = (number(x, "the span's end") for x in chosen.times)
    grid = np.linspace(start, start + LONGER * (end - start), INSTANTS)
    names = [*positions, *velocities]
    trial = ensemble(
        equations, [dict(initial or {})], parameters, grid, names, scene=chosen, tol=1e-9
    )  # fmt: skip
    series = {name: x[0][np.isfinite(x[0])] for name, x in trial.series.items()}
    if plane is not None:
        return SectionSurface(plane, 0.0, _others(series, plane, positions, velocities))
    for name in names:
        value = _passed_value(series[name])
        if value is not None:
            return SectionSurface(name, value, _others(series, name, positions, velocities))
    raise DefinitionError(
        f"system '{system.name}': nothing oscillates along its motion, so no plane suggests "
        f"itself; name one with plane EXPR=VALUE in {', '.join(names)}"
    )


def _passed_value(x: np.ndarray) -> float | None:
    """A value that x passes upwards again and again: zero, or the middle of its range."""
    if len(x) < 2 or _still(x):
        return None
    middle = 0.5 * (x.min() + x.max())
    for value in (0.0, float(f"{middle:.3g}")):
        if np.sum((x[:-1] < value) & (x[1:] >= value)) >= RETURNS:
            return value
    return None


def _still(x: np.ndarray) -> bool:
    return bool(len(x) < 2 or np.ptp(x) <= STILL * max(1.0, np.abs(x).max()))


def _others(
    series: Mapping[str, np.ndarray], plane: str, positions: list[str], velocities: list[str]
) -> tuple[str, ...]:
    """A position and a velocity that move, or two of one kind."""
    moving = [n for n in (*positions, *velocities) if n != plane and not _still(series[n])]
    first = [n for n in moving if n in positions][:1]
    second = [n for n in moving if n in velocities][:1]
    rest = [n for n in moving if n not in (*first, *second)]
    return tuple([*first, *second, *rest][:2])


GRAZE = 1e-4
"""A crossing slower than this part of the quantity's largest rate is called near-tangent."""


@dataclass(frozen=True, eq=False, repr=False)
class Section:
    """The points where motions pass through the surface ``plane`` = ``value``.

    ``points`` has shape (k, m) with columns ``outputs``; ``section["u"]`` is one column.  ``t``
    (k,) is the time of each point and ``start`` (k,) the position of its motion among the starts;
    points are in order of the start, then of the time.  ``speed`` (k,) is the rate of the plane's
    quantity: where it is small, the crossing is near-tangent and its time ill-conditioned;
    ``near_tangent`` (k,) marks those slower than 1e-4 of its largest rate.  ``touches`` (start, t)
    came to the surface and turned back.

    ``ends`` says of each start how it ended: ``complete``, ``stopped by hand``, ``no more
    crossings up to t = ...`` or ``failed``; ``errors`` has the failures by position, ``notes`` what
    is to be said of motions, as in ``Ensemble``.
    ``drift`` maps the integrals that the equations in use can express to their largest change up to
    the last point, (starts,), relative as in ``Ensemble``; ``formulation`` names the variables of
    these equations.
    """

    system: System
    plane: str
    value: float
    direction: int
    outputs: tuple[str, ...]
    points: np.ndarray
    t: np.ndarray
    start: np.ndarray
    speed: np.ndarray
    near_tangent: np.ndarray
    touches: tuple[tuple[int, float], ...]
    ends: tuple[str, ...]
    errors: Mapping[int, VoronecError]
    parameters: Mapping[str, np.ndarray]
    drift: Mapping[str, np.ndarray]
    formulation: str
    cost: Cost
    interrupted: bool = False
    notes: Mapping[int, tuple[str, ...]] = field(default_factory=dict)

    def __getitem__(self, key: Any) -> np.ndarray:
        name = held_name(key, self.outputs, "the section holds")
        return self.points[:, self.outputs.index(name)]

    def __len__(self) -> int:
        return len(self.t)

    def plot(self) -> Any:
        """The first two outputs against each other, a colour each motion, as a matplotlib
        ``Figure``; of one output alone the map of returns."""
        from voronec.motion.pictures.section_picture import plot_section

        return plot_section(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the points to ``path``, as ``Trajectory.save`` does."""
        return self._arrays().save(path)

    def to_xarray(self) -> Any:
        """The points as an ``xarray.Dataset``, the header as attributes."""
        return self._arrays().to_xarray()

    def to_pandas(self) -> Any:
        """The points as a ``pandas.DataFrame``, a row for each point."""
        return self._arrays().to_pandas()

    def _arrays(self) -> NamedArrays:
        """The passages along ``point``, each with the number of its motion, ``start``; what is said
        of a motion along ``motion``."""
        from voronec.motion.storage import NamedArrays, of_motions, variables_of

        recorded = {"start": self.start, "t": self.t, **{name: self[name] for name in self.outputs}}
        along = {"speed": self.speed, "near_tangent": self.near_tangent}
        ends = {"end": np.array(self.ends)}
        each = of_motions(len(self.ends), self.errors, ends, self.parameters, drift=self.drift)
        points = [{n: (("point",), x) for n, x in part.items()} for part in (recorded, along)]
        return NamedArrays.of(
            self.system, "Section", variables_of(*points, each), ("point",), recorded,
            plane=self.plane, value=self.value, direction=self.direction,
            touches=[list(x) for x in self.touches], formulation=self.formulation,
            interrupted=self.interrupted, cost=asdict(self.cost),
            notes={str(i): list(told) for i, told in self.notes.items()},
        )  # fmt: skip

    def __repr__(self) -> str:
        plane = f"{self.plane} = {self.value:.6g}"
        points = f"{len(self)} points of {len(self.ends)} motions"
        points += ", stopped by hand" if self.interrupted else ""
        what = f"{plane}, {points}, outputs=({', '.join(self.outputs)})"
        return f"Section({self.system.name!r}, {what})"


@accepts(
    outputs=SEVERAL,
    parameters=VALUES,
    inputs=VALUES,
    initial=VALUES,
    method=TEXT,
    tol=TOLERANCE,
    crossings=COUNT,
    direction=COUNT,
    progress=CALLABLE,
    strict=FLAG,
)
def section(
    system: System | VoronecEquations,
    plane: Any,
    outputs: Sequence[Any] = (),
    scene: Any = None,
    initial: Mapping[Any, Any] | None = None,
    parameters: Mapping[Any, Any] | None = None,
    crossings: int = 1000,
    direction: int = 1,
    starts: int | Mapping[Any, Any] | Sequence[Values] | None = None,
    value: Any = 0,
    until: float | None = None,
    method: str = "auto",
    tol: float = 1e-13,
    progress: Callable[[float], Any] | None = None,
    inputs: Mapping[Any, Any] | None = None,
    strict: bool = True,
) -> Section:
    """The Poincare section of one or several motions.

    plane, value
        a name, symbol or expression, and the value it takes on the surface.
    outputs
        what is recorded there, by default the invariants, or all coordinates where there are none
        or the plane holds one, and the velocities v.
    crossings, until
        how many points each motion gives, and the time after which it is given up.  Without
        ``until`` it is given up when it has not come back for very many steps, or at t = 1e12.
    direction
        1 where the quantity grows, -1 where it falls, 0 for both; a jump through the value counts,
        a pole does not.  A motion that starts on the surface does not count its start.
    starts, initial
        arrays of initial values by name, or a sequence of mappings, as for ``ensemble``; or a
        number: that many starts around the one of ``scene`` and ``initial``, on which all
        integrals of the system have the same values.
    scene, parameters, method, tol, progress, inputs
        as for ``ensemble``; motions begin where the scene does, else at t = 0.  With tables and
        functions for inputs they are followed one by one, up to ``until``, which must be given.

    strict
        whether it is an error where no motion passes through the surface; else there are no points.

    Each crossing is found on the Taylor polynomial of its step (with scipy, on the interpolant) and
    polished to rounding; motions that start at a pole or a singular split, or pass one, are
    followed alone, as by ``integrate``.  Raises ``DefinitionError`` where no motion ever passes
    through the surface; what breaks down later, or loses a proved integral, is in ``errors``.
    Ctrl-C keeps the points that are there.
    """
    began, tol = perf_counter(), max(tol, EXACT)  # many motions go in doubles
    declared = system.system if isinstance(system, VoronecEquations) else require_system(system)
    if direction not in (-1, 0, 1) or crossings < 1:
        raise DefinitionError("direction must be 1, -1 or 0, and crossings at least 1")
    # the start is that of a scene, what is said of it changed, or all of it is said
    needed = initial is None or "default" in declared.scenes
    chosen_scene = scene_of(declared, scene, needed and (starts is None or isinstance(starts, int)))
    driven = drive(system, inputs, chosen_scene)
    equations, given = driven.equations, {**(parameters or {}), **driven.constants}
    namespace = Namespace.of(equations, driven.meaning)
    surface, expr = quantity(namespace, plane, "plane")
    on_plane = number(value, "the value of the plane")
    keys = outputs_of(None, outputs) or _whole(equations, expr)
    begin = begin_of(chosen_scene)
    if until is not None and number(until, "until") <= begin:
        raise DefinitionError(
            f"until = {float(until):g} does not lie after t = {begin:g}, where the motions begin; "
            "sections go forwards in time"
        )
    wanted = dict(quantity(namespace, key) for key in keys)
    looked, level = {**wanted, f"plane {surface}": expr}, expr - sp.Rational(on_plane)
    single, columns = _starts(equations, chosen_scene, starts, initial, given)
    if driven.changing is not None:
        if until is None:
            raise DefinitionError(
                f"system '{declared.name}': inputs that change in time by a table or a function "
                "are followed up to an instant; give until="
            )
        known = {plain_name(s): s for s in declared.known_symbols()}
        spelled = formula(plane, "the plane", known) if isinstance(plane, str) else plane
        columns |= driven.over(begin, until).parameters(begin, until)
        level = spelled - sp.Rational(on_plane)
    motions = many(equations, chosen_scene, single, columns, looked, begin)
    alone = LoneMotions.of_section(motions, single, chosen_scene, method, tol)
    if driven.changing is not None:
        given = {**getattr(chosen_scene, "inputs", {}), **(inputs or {})}
        alone = replace(alone, declared=declared, inputs=given)
    each, width = [MotionPassages() for _ in motions.states], motions.states.shape[1]
    last = FOREVER if until is None else number(until, "until")
    passages = SectionPassages(each, width, crossings, direction, last, progress, strict)
    looked_at = _follow(alone, passages, surface, on_plane, level, keys, began)
    return _section(declared, motions, passages, tuple(wanted), surface, on_plane, *looked_at)


def _follow(
    alone: LoneMotions, passages: SectionPassages, surface: str, value: float, level: sp.Expr,
    outputs: Sequence[Any], began: float,
) -> tuple[Cost, dict[str, np.ndarray]]:  # fmt: skip
    """Follow motions to where the ``level`` is zero, and look at them: what that cost, and how much
    integrals drift; ``DefinitionError`` where that is nowhere."""
    motions, method, tol = alone.motions, alone.method, alone.tol
    follow, used, reason, finest = None, "scipy", "each start alone", tol
    if every := bool(alone.cause or not motions.sound):
        require_method(method)
    else:
        watch = _watch(motions, f"plane {surface}", value)
        follow, used, reason, finest = _followers(motions, watch, method, tol)
    ready = perf_counter()
    if follow is not None:
        follow(passages)
    go_on_alone(alone, passages, level, outputs, every)
    if alone.costs and every:
        used, finest = alone.costs[0].method, alone.costs[0].tolerance
    cost = Cost(
        method=used, reason=reason, tolerance=finest, setup=ready - began,
        run=perf_counter() - ready, steps=passages.steps, evaluations=passages.steps,
    )  # fmt: skip
    _refuse_nothing(motions, passages, surface, value)
    return cost, _look_at(motions, passages, cost)


def _followers(
    motions: Many, watch: SectionWatch, method: str, tol: float
) -> tuple[Callable[[SectionPassages], None], str, str, float]:
    """What follows motions with one right side to their crossings; the method that it takes, why,
    and its tolerance."""
    starts = watch.begin(motions, motions.sound), motions.values[motions.sound]
    lanes, used, reason = choose_lanes(method, watch.program, tol, *starts)
    if lanes is not None:
        return partial(pass_lanes, motions, watch, lanes=lanes), used, reason, tol
    one_by_one = partial(pass_one_by_one, motions, watch, method=used, tol=tol)
    return one_by_one, used, reason, max(tol, FINEST)


def _whole(equations: VoronecEquations, plane: sp.Expr) -> tuple[Any, ...]:
    """What is recorded where nobody says it."""
    system = equations.system
    low = not system.invariants or Motions.of(equations).holds_coordinate([plane])
    return (*(system.coordinates if low else system.invariants), *system.velocities)


def _starts(
    equations: VoronecEquations, scene: Any, starts: Any, initial: Any, parameters: Any
) -> tuple[Starts, dict[Any, Any]]:
    values = dict(initial or {})
    if isinstance(starts, int) and starts > 1:
        rows = starts_alike(equations, scene, values, parameters or {}, starts)
        return spread_starts(rows, parameters or {})
    if isinstance(starts, int):
        starts = None
    single, columns = spread_starts(starts, parameters or {})
    return single.over(values), columns


def _watch(motions: Many, name: str, value: float) -> SectionWatch:
    program = Program.of(motions.ground.form, {"plane": motions.ground.quantities[name]})
    symbols = program.extras.symbols
    needed = np.array([i for i, s in enumerate(program.state) if s in symbols], dtype=int)
    if not len(needed) and program.time not in symbols:
        raise DefinitionError(
            f"the plane '{name.removeprefix('plane ')}' is constant along every motion; name a "
            "quantity that moves"
        )
    extras = compile_program(program)[1]

    width = len(program.state)

    def function(t: Any, states: np.ndarray, values: np.ndarray) -> np.ndarray:
        return at_each(extras, ("plane",), t, states[..., :width], values)["plane"] - value

    wide = with_parts(motions.program, Block((), (motions.ground.quantities[name],)))
    return SectionWatch(function, needed, wide, width)


def _refuse_nothing(motions: Many, passages: SectionPassages, surface: str, value: float) -> None:
    if any(record.count for record in passages.of) or passages.interrupted or not passages.strict:
        return
    for error in (*motions.wrong.values(), *passages.errors.values()):
        raise error
    system = motions.namespace.equations.system.name
    low, high = np.array([(record.low, record.high) for record in passages.of]).T
    if np.isnan(low).all():
        raise DefinitionError(
            f"system '{system}': {surface} has no real value along the motion; choose another plane"
        )
    nearest = int(np.nanargmin(np.maximum(low, -high)))
    low, high = low[nearest] + value, high[nearest] + value
    several = len(motions) > 1
    which = f"start {nearest}, the nearest of {len(motions)}, stays" if several else "it stays"
    way = {1: " upwards", -1: " downwards", 0: ""}[passages.direction]
    raise DefinitionError(
        f"system '{system}': no motion passes through {surface} = {value:g}{way}; up to t = "
        f"{passages.of[nearest].reached:.6g} {which} between {low:.6g} and {high:.6g}; choose "
        "another value, direction or plane"
    )


def _look_at(motions: Many, passages: SectionPassages, cost: Cost) -> dict[str, np.ndarray]:
    """How much integrals drift, see ``Section.drift``; of motions that lose a proved integral, or
    do not obey the equations, keep the points before that, and say so; those that went alone were
    looked at there."""
    equations = motions.namespace.equations
    integrals = {name: f"integral {name}" for name in motions.ground.integrals}
    check = CheckOfMany(equations, motions.program, cost.tolerance, integrals)
    drifts, drift = Drifts(motions, cost.tolerance), {n: np.zeros(len(motions)) for n in integrals}
    steps = cost.steps / max(1, len(motions.sound))
    for i, record in enumerate(passages.of):
        if record.alone is not None:
            for name, array in drift.items():
                array[i] = record.alone[1].get(name, np.nan)
        if not record.parts or record.alone is not None:
            continue
        t = np.concatenate([[motions.time], *(part[0] for part in record.parts)])
        states = np.vstack([motions.states[i], *(part[1] for part in record.parts)])
        ends = motions.time, float(t[-1])
        samples = by_owner(part.within(*ends) for part in record.samples)
        motion = t, states[None], motions.values[i][None]
        series = motions.quantities_along(*motion)
        breaches, notes = check.breaches(*motion, steps, samples, series)
        if notes:
            passages.notes[i] = (*passages.notes.get(i, ()), *notes[0])
        for breach in breaches.values():
            time, state = breach.last or (float(t[breach.row]), states[breach.row])
            passages.cut(i, breach.row)
            what = f"{breach.what} after t = {time:.12g}"
            passages.errors[i] = motions.error(i, what, "end the run before that", time, state)
        kept = slice(record.count + 1)
        series = {name: columns[:, kept] for name, columns in series.items()}
        columns = drifts.along(t[kept], states[None, kept], motions.values[i][None], series)
        for name, array in drift.items():
            array[i] = columns[name][0]
    return drift


def _section(
    system: System, motions: Many, passages: SectionPassages, outputs: tuple[str, ...],
    surface: str, value: float, cost: Cost, drift: Mapping[str, np.ndarray],
) -> Section:  # fmt: skip
    start, t, states, speed = passages.join()
    names, values = motions.program.names, motions.values[start]
    quantities = at_each(motions.extras, names, t, states, values)
    points = np.stack([quantities[name] for name in outputs], axis=-1)
    for i, record in enumerate(passages.of):
        if record.alone is not None:
            points[start == i] = record.alone[0]
    fastest = np.array([record.fastest for record in passages.of])
    for array in (points, t, start, speed):
        array.flags.writeable = False
    return Section(
        system=system,
        plane=surface,
        value=value,
        direction=passages.direction,
        outputs=outputs,
        points=points,
        t=t,
        start=start,
        speed=speed,
        near_tangent=np.abs(speed) < GRAZE * fastest[start],
        touches=tuple(passages.touches),
        ends=tuple(passages.ends(i, motions.wrong) for i in range(len(motions))),
        errors=MappingProxyType({**motions.wrong, **passages.errors}),
        parameters=MappingProxyType(
            {n: x for n, x in motions.parameters.items() if n in system.parameter_names}
        ),
        drift=MappingProxyType(drift),
        formulation=motions.ground.formulation,
        cost=cost,
        interrupted=passages.interrupted,
        notes=MappingProxyType(passages.notes),
    )
