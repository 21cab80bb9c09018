"""``voronec run``: integrate a motion, save and draw it, and say how well its integrals hold."""

from __future__ import annotations

import math
from argparse import Namespace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.cli.files import delivery, refuse_file
from voronec.cli.output import columns, print_json, progress, warn
from voronec.cli.subject import resolve
from voronec.cli.wanted import outputs_of
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.flow import Trajectory
    from voronec.system import System

__all__ = ["execute"]

INSTANTS = 1001
MOST_INSTANTS = 10_000_000


def execute(arguments: Namespace) -> int:
    """Integrate, write ``trajectory.csv`` and pictures, and report.

    Stopped by Ctrl-C, what is done is written all the same.
    """
    tol = _tolerance(arguments.tol)
    times = _times(arguments.times)
    pairs = [_pair(text) for text in arguments.set]
    outputs = outputs_of(arguments.outputs)
    system, _ = resolve(arguments.system)
    folder = Path(arguments.out or f"{system.name}-run")
    refuse_file(folder)
    parameters, initial = _sorted(system, pairs)
    scene = arguments.scene or _first_scene(system)
    from voronec.flow import integrate

    progress(f"{system.name}: integrating ...")
    try:
        trajectory = integrate(
            system, scene=scene, times=times, outputs=outputs, parameters=parameters,
            initial=initial, method=arguments.method, tol=tol,
        )  # fmt: skip
    finally:
        progress("")
    files = _write(trajectory, folder)
    _report(trajectory, scene, files, arguments.json)
    if _unsound(trajectory):
        warn("an integral drifts far beyond the tolerance: it is none, or the motion is not sound")
        return 1
    return 130 if trajectory.interrupted else 0


def _first_scene(system: System) -> str | None:
    return "default" if "default" in system.scenes else next(iter(system.scenes), None)


def _tolerance(text: str | None) -> float:
    if text is None:
        return 1e-13
    tol = _float(text, "--tol")
    if not 0 < tol < 1:
        raise DefinitionError(f"--tol {text}: give a number between 0 and 1, such as 1e-12")
    return tol


def _times(text: str | None) -> Any:
    """The grid that ``[START:]END[:N]`` means; None where nothing is said."""
    if text is None:
        return None
    import numpy as np

    parts = text.split(":")
    if len(parts) > 3:
        raise DefinitionError(f"--times {text}: give [START:]END[:N], such as 0:20:501")
    if len(parts) == 1:
        parts = ["0", *parts]
    start, end = (_float(part, "--times") for part in parts[:2])
    count = parts[2] if len(parts) == 3 else str(INSTANTS)
    if not count.isdecimal() or not 2 <= int(count) <= MOST_INSTANTS:
        raise DefinitionError(f"--times {text}: give from 2 to {MOST_INSTANTS} instants")
    if start == end:
        raise DefinitionError(f"--times {text}: start and end are the same")
    return np.linspace(start, end, int(count))


def _float(text: str, option: str) -> float:
    try:
        value = float(Fraction(text))
    except (ValueError, ZeroDivisionError, OverflowError):
        value = math.nan
    if not math.isfinite(value):
        raise DefinitionError(f"{option}: '{text}' is not a number")
    return value


def _pair(text: str) -> tuple[str, Any]:
    """NAME=VALUE; a decimal or a fraction is kept exactly."""
    import sympy as sp

    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name:
        raise DefinitionError(f"--set {text}: give NAME=VALUE, such as m=2.5 or a=1/3")
    _float(value, f"--set {name}")
    exact = Fraction(value)
    return name, sp.Rational(exact.numerator, exact.denominator)


def _sorted(system: System, pairs: list[tuple[str, Any]]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values of parameters, and those of coordinates and velocities at the start."""
    from voronec.algebra.symbols import plain_name
    from voronec.catalogue import unknown

    constants = {p.name for p in system.parameters}
    movers = {plain_name(s) for s in system.known_symbols()} - constants - {"t"}
    parameters: dict[str, Any] = {}
    initial: dict[str, Any] = {}
    for name, value in pairs:
        if name not in constants | movers:
            kind = "parameter, coordinate or velocity"
            raise DefinitionError(
                f"system '{system.name}': {unknown(kind, name, constants | movers)}"
            )
        (parameters if name in constants else initial)[name] = value
    return parameters, initial


def _write(trajectory: Trajectory, folder: Path) -> list[Path]:
    from voronec.report.pictures import pictures, save

    with delivery(folder) as workshop:
        trajectory.save(workshop / "trajectory.csv")
        for name, figure in pictures(trajectory).items():
            save(figure, workshop / f"{name}.svg")
        written = sorted(file.name for file in workshop.iterdir())
    return [folder / name for name in written]


def _report(trajectory: Trajectory, scene: str | None, files: list[Path], as_json: bool) -> None:
    cost = trajectory.cost
    if as_json:
        print_json({
            "system": trajectory.system.name, "scene": scene,
            "times": [float(trajectory.t[0]), float(trajectory.t[-1])],
            "instants": len(trajectory.t), "interrupted": trajectory.interrupted,
            "method": cost.method, "reason": cost.reason, "tolerance": cost.tolerance,
            "setup_seconds": cost.setup, "run_seconds": cost.run, "steps": cost.steps,
            "evaluations": cost.evaluations, "parameters": dict(trajectory.parameters),
            "drift": dict(trajectory.drift), "residuals": dict(trajectory.residuals),
            "files": [str(f) for f in files],
        })  # fmt: skip
        return
    what = f"{trajectory.system.name}, scene {scene}" if scene else trajectory.system.name
    print(f"{what}: {_span(trajectory)}")
    print(cost)
    rows = [["drift of", name, f"{value:.1e}"] for name, value in trajectory.drift.items()]
    rows += [["residual of", name, f"{value:.1e}"] for name, value in trajectory.residuals.items()]
    print("\n".join(columns(rows) or ["no integral is declared, so no drift is known"]))
    print("wrote " + ", ".join(str(f) for f in files))


def _unsound(trajectory: Trajectory) -> bool:
    """Whether a declared integral moves by more than the tolerance can excuse."""
    bound = max(1e-6, 1e5 * trajectory.cost.tolerance)
    return any(not value <= bound for value in trajectory.drift.values())


def _span(trajectory: Trajectory) -> str:
    span = f"t from {trajectory.t[0]:g} to {trajectory.t[-1]:g}, {len(trajectory.t)} instants"
    return span + (", stopped by hand" if trajectory.interrupted else "")
