"""Passages of motions that are integrated alone, as by ``integrate``.

Where inputs change in time these are all motions; else those whose equations came near a place at
which they are singular: ``integrate`` goes on in other charts and splits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.algebra.text import formula
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.errors import DefinitionError, IntegrationError, VoronecError
from voronec.motion.integration import integrate
from voronec.motion.motion_pool import Many
from voronec.motion.one_by_one import crossing_speeds, time_scale
from voronec.motion.request import Event, Values, label
from voronec.motion.section_passages import PATIENCE, SectionPassages, SectionWatch
from voronec.motion.trajectory import Cost, Trajectory

__all__ = ["DrivenPassages", "driven_passages", "go_on_alone"]

PLANE = "the plane of the section"
STEP = 1e-6
"""The step of difference quotients, in units of the time that a motion is followed."""
LOOKS = 2001
"""Instants at which the largest rate of the plane's quantity is seen."""


@dataclass
class DrivenPassages:
    """What was found of several motions: rows (start, t, outputs, speed), in their order, the
    largest rate of the plane's quantity, how each ended, and what went wrong."""

    rows: list[tuple[int, float, np.ndarray, float]] = field(default_factory=list)
    fastest: list[float] = field(default_factory=list)
    ends: list[str] = field(default_factory=list)
    errors: dict[int, VoronecError] = field(default_factory=dict)
    drift: dict[str, list[float]] = field(default_factory=dict)
    cost: Cost | None = None
    steps: int = 0
    interrupted: bool = False


def driven_passages(
    system: System, plane: Any, value: float, direction: int, outputs: Sequence[str],
    starts: Sequence[Values], parameters: Mapping[Any, Any], crossings: int, until: float | None,
    progress: Callable[[float], Any] | None, **options: Any,
) -> DrivenPassages:  # fmt: skip
    """The passages of motions from several starts, up to the time ``until``."""
    if until is None:
        raise DefinitionError(
            f"system '{system.name}': inputs that change in time by a table or a function are "
            "followed up to an instant; give until="
        )
    known = {plain_name(s): s for s in system.known_symbols()}
    quantity = formula(plane, "the plane", known) if isinstance(plane, str) else plane
    level = quantity - sp.Rational(value)
    event = Event(level, PLANE, direction)
    own = plain_name(level) if is_symbolic_name(level) else label(level)
    found = DrivenPassages()
    for i, start in enumerate(starts):
        chosen = {k: x[i] if isinstance(x, np.ndarray) else x for k, x in parameters.items()}
        try:
            run = integrate(
                system, times=[_begin(options), until], initial=start, parameters=chosen,
                outputs=[*outputs, level], events=(event,), dense=True, **options,
            )  # fmt: skip
        except KeyboardInterrupt:
            found.interrupted = True
            break
        except IntegrationError as error:
            found.errors[i] = error
            _note(found, i, error.trajectory, crossings, "failed", len(outputs), own)
            continue
        end = f"no more crossings up to t = {until:.6g}"
        _note(found, i, run, crossings, end, len(outputs), own)
        if progress is not None:
            progress((i + 1) / len(starts))
    return found


def _begin(options: Mapping[str, Any]) -> float:
    scene = options.get("scene")
    return 0.0 if scene is None else float(scene.times[0])


def _note(
    found: DrivenPassages, i: int, run: Trajectory | None, crossings: int, end: str, width: int,
    own: str,
) -> None:  # fmt: skip
    """Take in what one motion shows; the plane's quantity, where it is among the outputs, is
    called ``own``."""
    if run is None or PLANE not in run.events:
        found.ends.append(end)
        found.fastest.append(np.inf)
        return
    names = run.outputs[:width]
    level = run.outputs[-1] if len(run.outputs) > width else own  # it is an output itself
    passed = run.events[PLANE]
    count = min(len(passed), crossings)
    h = STEP * abs(float(run.t[-1]) - float(run.t[0]))
    fine = np.linspace(float(run.t[0]), float(run.t[-1]), LOOKS)
    rates = np.abs(np.diff(run.at(fine)[level])) / np.diff(fine)
    points = np.stack([passed[name] for name in names], axis=-1)
    for k in range(count):
        t = float(passed.t[k])
        sides = run.at([max(t - h, fine[0]), min(t + h, fine[-1])])
        speed = float(np.diff(sides[level])[0] / np.diff(sides.t)[0])
        found.rows.append((i, t, points[k], speed))
    found.fastest.append(float(rates.max()))
    found.ends.append("complete" if count == crossings else end)
    found.cost = run.cost
    found.steps += run.cost.steps
    for name, drift in run.drift.items():
        found.drift.setdefault(name, []).append(float(drift))


LONGER = 4.0
"""A motion alone is followed so many times longer until it has made all its passages."""
FIRST = 16.0
"""It is followed over so many units of its time scale at first, or over twice the time up to where
it failed."""


def go_on_alone(
    motions: Many, watch: SectionWatch, passages: SectionPassages, level: sp.Expr, method: str,
    tol: float,
) -> None:  # fmt: skip
    """Motions that failed on the way, once more, each alone, up to their passages through ``level``
    = 0; what fails alone, too, keeps its first error."""
    try:
        for i in sorted(passages.errors):
            if not passages.interrupted[0]:
                _pass_alone(motions, watch, passages, level, method, tol, i)
    except KeyboardInterrupt:
        passages.interrupted[0] = True


def _pass_alone(
    motions: Many, watch: SectionWatch, passages: SectionPassages, level: sp.Expr, method: str,
    tol: float, i: int,
) -> None:  # fmt: skip
    equations = motions.vocabulary.equations
    names = [*equations.system.coordinates, *equations.system.velocities]
    constants = {name: float(x[i]) for name, x in motions.parameters.items()}
    start = dict(zip(names, motions.full[i].tolist(), strict=True))
    event = Event(level, PLANE, passages.direction)
    unit = time_scale(motions, motions.time, motions.states[i], motions.values[i])
    span, run = max(FIRST * unit, 2 * (passages.reached[i] - motions.time)), None
    while run is None or not (
        len(run.events[PLANE]) >= passages.wanted
        or run.t[-1] >= passages.until
        or run.cost.steps > PATIENCE
    ):
        end = min(motions.time + span, passages.until)
        try:
            run = integrate(
                equations, Scene({}, (0.0, 1.0)), [motions.time, end], names, constants, start,
                method, tol, events=(event,),
            )  # fmt: skip
        except IntegrationError as error:
            run = error.trajectory
            if run is None or len(run.events[PLANE]) < passages.wanted:
                return
        if run.interrupted:
            raise KeyboardInterrupt
        span *= LONGER
    del passages.errors[i]
    passed, passages.parts[i] = run.events[PLANE], []
    passages.count[i], passages.idle[i] = 0, run.cost.steps
    t = np.asarray(passed.t, dtype=float)
    full = np.stack([np.asarray(passed[plain_name(x)], dtype=float) for x in names], axis=-1)
    states = motions.on_ground(i, t, full)
    speeds = crossing_speeds(motions, watch, t, states, motions.values[i], unit)
    passages.put(i, t, states, speeds)
    largest = np.abs(speeds).max(initial=0.0)
    passages.note_range(i, float(run.t[-1]), run.cost.steps, (np.nan, np.nan, largest))
    passages.steps[0] += run.cost.steps
