"""``voronec section``: the Poincare section of a system, as a picture and a table of points."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.algebra.text import name_or_formula
from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, progress_line, warn, wrote
from voronec.cli.values import finite, motion_of, outputs_of, tolerance
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.equations.voronec_equations import VoronecEquations
    from voronec.motion import Section

LONGEST_LIST = 12
"""Starts that are not complete are listed up to so many."""
DIRECTIONS = {"up": 1, "down": -1, "both": 0}


def execute(arguments: Namespace) -> int:
    """Follow the motions, write ``points.csv`` and ``section.svg``, and report.

    Stopped by Ctrl-C, the points that are there are written all the same.
    """
    # long because all options are read and refused before the work, and all is told after it
    tol = tolerance(arguments.tol)
    until = None if arguments.until is None else finite(arguments.until, "--until")
    _refuse_none(arguments)
    plane = None if arguments.plane is None else _plane(arguments.plane)
    outputs = [*outputs_of(arguments.outputs)]
    system, given = motion_of(arguments)
    folder = wanted_folder(arguments.out or f"{system.name}-section")
    from voronec.motion.inputs import drive
    from voronec.motion.sections import section

    with progress_line(f"{system.name}: deriving ..."):
        inputs = given.pop("inputs")
        driven = drive(system, inputs, system.scenes.get(given["scene"]))
        equations: Any = driven.equations
        if driven.changing is None:
            given["parameters"] = {**given["parameters"], **driven.constants}
            plane, value, outputs = _complete_request(equations, plane, outputs, given)
        elif plane is None:
            raise DefinitionError("--plane: with a table for an input name one, EXPR=VALUE")
        else:
            (plane, value), equations, given = plane, system, {**given, "inputs": inputs}
        crossings = section(
            equations, plane, outputs, **given, value=value, starts=arguments.starts,
            crossings=arguments.crossings, direction=DIRECTIONS[arguments.direction], until=until,
            method=arguments.method, tol=tol,
            progress=lambda share: progress(f"{system.name}: {share:.0%} of the crossings"),
        )  # fmt: skip
    if crossings.interrupted and not len(crossings):
        raise KeyboardInterrupt
    files = deliver(folder, lambda to: _write(crossings, to))
    _report(crossings, given["scene"], files, arguments.json)
    for error in crossings.errors.values():
        warn(str(error))
    if crossings.interrupted:
        return 130
    return 1 if crossings.errors else 0


def _refuse_none(arguments: Namespace) -> None:
    for count, option in ((arguments.starts, "--starts"), (arguments.crossings, "--crossings")):
        if count < 1:
            raise DefinitionError(f"{option} {count}: give a number from 1 on")


def _plane(text: str) -> tuple[Any, float]:
    """The quantity and the value in EXPR=VALUE; without a value it is zero."""
    left, equals, right = text.partition("=")
    value = finite(right, f"--plane {text}") if equals else 0.0
    return name_or_formula(left, f"--plane {text}"), value


def _complete_request(
    equations: VoronecEquations, plane: tuple[Any, float] | None, outputs: list[Any], given: Any
) -> tuple[Any, float, list[Any]]:
    """Plane and outputs, what nobody named suggested by a short motion."""
    from voronec.motion.sections import suggest_surface

    if plane is not None and outputs:
        return *plane, outputs
    named = None if plane is None else str(plane[0])
    surface = suggest_surface(equations, plane=named, **given)
    if plane is None:
        plane = (surface.plane, surface.value)
    return *plane, outputs or list(surface.outputs)


def _write(found: Section, workshop: Path) -> None:
    from voronec.motion.pictures.run_pictures import save

    found.save(workshop / "points.csv")
    save(found.plot(), workshop / "section.svg")


def _report(found: Section, scene: str | None, files: list[Path], as_json: bool) -> None:
    cost = found.cost
    rate = len(found) / cost.run if cost.run > 0 else 0.0
    drift = {name: float(x.max()) for name, x in found.drift.items()}
    data = {
        "system": found.system.name, "scene": scene, "plane": found.plane,
        "value": found.value, "direction": found.direction, "outputs": list(found.outputs),
        "points": len(found), "starts": len(found.ends), "points_per_second": rate,
        "near_tangent": int(found.near_tangent.sum()), "touches": len(found.touches),
        "ends": list(found.ends), "errors": {str(i): str(e) for i, e in found.errors.items()},
        "notes": {str(i): list(notes) for i, notes in found.notes.items()},
        "drift": drift, "formulation": found.formulation, "interrupted": found.interrupted,
        "method": cost.method, "reason": cost.reason, "tolerance": cost.tolerance,
        "setup_seconds": cost.setup, "run_seconds": cost.run, "steps": cost.steps,
        "files": files,
    }  # fmt: skip
    stopped = ", stopped by hand" if found.interrupted else ""
    way = {1: "upwards", -1: "downwards", 0: "both ways"}[found.direction]
    starts = "1 start" if len(found.ends) == 1 else f"{len(found.ends)} starts"
    lines = [
        f"{found.system.name}: {found.plane} = {found.value:g}, {way}; "
        f"{', '.join(found.outputs)} recorded{stopped}",
        f"{len(found)} points of {starts}, {rate:.0f} a second; {cost}",
        *columns([["drift of", name, f"{x:.1e}"] for name, x in drift.items()]),
    ]
    if near := data["near_tangent"]:
        lines.append(f"{near} crossings are near-tangent: their times are ill-conditioned")
    if found.touches:
        lines.append(f"{len(found.touches)} times a motion touched the surface and turned back")
    short = [[f"start {i}", end] for i, end in enumerate(found.ends) if end != "complete"]
    short += [[f"start {i}", note] for i, notes in found.notes.items() for note in notes]
    lines += columns(short[:LONGEST_LIST])
    if len(short) > LONGEST_LIST:
        lines.append(f"and {len(short) - LONGEST_LIST} further lines of starts")
    answer(as_json, lambda: data, [*lines, *wrote(files)])
