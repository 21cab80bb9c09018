"""``voronec run``: integrate a motion, save and draw it, and say how well its integrals hold."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from voronec.algebra.columns import columns
from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, progress_line, warn, wrote
from voronec.cli.values import instants, motion_of, outputs_of, tolerance

if TYPE_CHECKING:
    from voronec.motion import Trajectory

PRODUCTS = ("trajectory.csv", "plot.svg", "path.svg", "drawing.svg")
"""What a run may write."""


def execute(arguments: Namespace) -> int:
    """Integrate, write ``trajectory.csv`` and pictures, and report.

    Stopped by Ctrl-C, what is done is written all the same.
    """
    tol = tolerance(arguments.tol)
    times = instants(arguments.times)
    outputs = outputs_of(arguments.outputs)
    system, given = motion_of(arguments)
    folder = wanted_folder(arguments.out or f"{system.name}-run")
    if arguments.animate:
        from voronec.motion.pictures.scene_film import check_film
        from voronec.motion.request import CONFIGURATION

        check_film(system, Path(arguments.animate))
        wanted_folder(str(Path(arguments.animate).parent))
        # what the scene records need not tell where the shapes are
        asked = outputs or (system.scenes[given["scene"]].outputs if given["scene"] else ())
        outputs = (*asked, CONFIGURATION) if asked else ()
    from voronec.motion import integrate

    with progress_line(f"{system.name}: integrating ..."):
        trajectory = integrate(
            system, times=times, outputs=outputs, method=arguments.method, tol=tol, **given,
            progress=lambda share: progress(f"{system.name}: {share:.0%} of the motion"),
        )  # fmt: skip
    files = deliver(folder, lambda to: _write(trajectory, to), PRODUCTS)
    if arguments.animate:
        files += _animate(trajectory, Path(arguments.animate))
    _report(trajectory, given["scene"], files, arguments.json)
    if lost := _lost_integrals(trajectory):
        warn(
            f"the integral {lost} drifts far beyond the tolerance: it is not constant, the motion "
            "comes to where it has no value or jumps, or is wrong; 'voronec check' says where it "
            "is proved, or refutes it"
        )
        return 1
    return 130 if trajectory.interrupted else 0


def _write(trajectory: Trajectory, workshop: Path) -> None:
    from voronec.motion.pictures.run_pictures import pictures, save

    trajectory.save(workshop / "trajectory.csv")
    figures = pictures(trajectory)
    for name, figure in figures.items():
        save(figure, workshop / f"{name}.svg")
    if trajectory.system.drawing is not None and "drawing" not in figures:
        warn("the system's own drawing shows more than these outputs, so it is left out")


def _animate(trajectory: Trajectory, target: Path) -> list[Path]:
    from voronec.motion.pictures.scene_film import ShapesInMotion, film

    name = trajectory.system.name

    def write(workshop: Path) -> None:
        film(
            ShapesInMotion(trajectory), workshop / target.name,
            progress=lambda share: progress(f"{name}: {share:.0%} of the film"),
        )  # fmt: skip

    with progress_line():
        return deliver(target.parent, write)


def _report(trajectory: Trajectory, scene: str | None, files: list[Path], as_json: bool) -> None:
    cost = trajectory.cost
    data = {
        "system": trajectory.system.name, "scene": scene,
        "times": [float(trajectory.t[0]), float(trajectory.t[-1])],
        "instants": len(trajectory.t), "interrupted": trajectory.interrupted,
        "method": cost.method, "reason": cost.reason, "tolerance": cost.tolerance,
        "formulation": cost.formulation, "setup_seconds": cost.setup, "run_seconds": cost.run,
        "steps": cost.steps, "evaluations": cost.evaluations, "switches": cost.switches,
        "parameters": {name: float(x) for name, x in trajectory.parameters.items()},
        "drift": dict(trajectory.drift), "residuals": dict(trajectory.residuals),
        "notes": list(trajectory.notes), "files": files,
    }  # fmt: skip
    what = f"{trajectory.system.name}, scene {scene}" if scene else trajectory.system.name
    rows = [["drift of", name, f"{value:.1e}"] for name, value in trajectory.drift.items()]
    rows += [["residual of", name, f"{value:.1e}"] for name, value in trajectory.residuals.items()]
    answer(as_json, lambda: data, [
        f"{what}: {_span(trajectory)}", cost,
        *(columns(rows) or ["no integral is declared, so no drift is known"]),
        *(f"note: {note}" for note in trajectory.notes), *wrote(files),
    ])  # fmt: skip


def _lost_integrals(trajectory: Trajectory) -> str:
    """Which declared integrals move by more than the tolerance can excuse."""
    bound = max(1e-6, 1e5 * trajectory.cost.tolerance)
    return ", ".join(f"'{x}'" for x, value in trajectory.drift.items() if not value <= bound)


def _span(trajectory: Trajectory) -> str:
    first, last = float(trajectory.t[0]), float(trajectory.t[-1])
    span = f"t from {first:g} to {last:g}, {len(trajectory.t)} instants"
    return span + (", stopped by hand" if trajectory.interrupted else "")
