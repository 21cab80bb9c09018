"""``voronec bench``: every method of ours against a reference, as speed against error."""

from __future__ import annotations

import json
from argparse import Namespace
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from voronec.algebra.columns import columns
from voronec.cli.files import deliver, wanted_folder
from voronec.cli.output import answer, progress, progress_line, wrote
from voronec.cli.values import finite, motion_of
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.accuracy.bench import Bench, Measured, Point

TOLERANCE = 1e-9
"""That of the calls whose stages are shown, unless told."""

MARKS = {"at most": "<= ", "extrapolated": "~ "}
"""What stands before a time that is not interpolated between two runs."""


def execute(arguments: Namespace) -> int:
    """Measure, write ``bench.json``, ``bench.txt`` and ``work-precision.svg``, print the table.

    Stopped by Ctrl-C, what is measured is written all the same.
    """
    tolerances = [finite(word, "--tols") for word in _words(arguments.tols)]
    time = _span(arguments.time)
    system, given = motion_of(arguments)
    del given["scene"]  # the problem chooses one
    _refuse_tables(given["inputs"])
    values = {kind: {k: str(v) for k, v in table.items()} for kind, table in given.items()}
    if arguments.setup:
        return _show_calls(arguments, system.name, time, tolerances, values)
    folder = wanted_folder(arguments.out or f"{system.name}-bench")
    from voronec.accuracy.bench import contenders, measure, measure_setup, scene_problem

    methods = _words(arguments.methods)
    contenders(methods)  # refuses an unknown one before any work
    outputs = tuple(_words(arguments.outputs))
    with progress_line(f"{system.name}: deriving ..."):
        problem = scene_problem(system, arguments.scene, outputs, time, **given)
        bench = measure(
            problem, methods, tolerances,
            setup=lambda: measure_setup(
                arguments.system, arguments.scene, problem.outputs, values=values
            ),
            say=lambda text: progress(f"{system.name}: {text} ..."),
        )  # fmt: skip
    files = write(bench, folder)
    data = {**bench.as_dict(), "files": files}
    answer(arguments.json, lambda: data, [*report(bench), *wrote(files)])
    return 130 if bench.interrupted else 0


def _span(text: str | None) -> float | None:
    """The length of time that is wanted instead of that of the scene."""
    time = None if text is None else finite(text, "--time")
    if time is not None and time <= 0:
        raise DefinitionError(f"--time {text}: give a length of time above zero")
    return time


def _refuse_tables(inputs: Mapping[str, Any]) -> None:
    for name, value in inputs.items():
        if not isinstance(value, str):
            raise DefinitionError(
                f"--input {name}: most methods take no table; give a formula of t, as {name}=sin(t)"
            )


def _show_calls(
    arguments: Namespace,
    name: str,
    time: float | None,
    tolerances: list[float],
    values: dict[str, dict[str, str]],
) -> int:
    """Print where the time of whole calls goes."""
    from voronec.accuracy.bench import measure_calls

    with progress_line(f"{name}: calls in two fresh processes ..."):
        seconds = measure_calls(
            arguments.system, arguments.scene, time, (tolerances or [TOLERANCE])[0], values
        ).as_dict()
    stages = sorted(
        {s for d in seconds.values() for s in d}, key=lambda s: -seconds["first ever"].get(s, 0)
    )
    rows = [[s, *(f"{1e3 * d.get(s, 0.0):.1f}" for d in seconds.values())] for s in stages]
    rows.append(["together", *(f"{1e3 * sum(d.values()):.1f}" for d in seconds.values())])
    answer(arguments.json, lambda: {"system": name, "seconds": seconds}, [
        f"{name}: a whole call of integrate, milliseconds of the processor",
        *columns([["stage", *seconds], *rows]),
        "first in a process: heyoka finds on disk what it has compiled; both with imports",
    ])  # fmt: skip
    return 0


def _words(text: str | None) -> list[str]:
    """The words between commas."""
    return [word.strip() for word in (text or "").split(",") if word.strip()]


def write(bench: Bench, folder: Path) -> list[Path]:
    """The measurement as ``bench.json``, ``bench.txt`` and ``work-precision.svg`` in a folder."""
    from voronec.accuracy.bench.work_precision_picture import plot_work_precision
    from voronec.motion.pictures.run_pictures import save

    def fill(workshop: Path) -> None:
        data = json.dumps(bench.as_dict(), indent=2, ensure_ascii=False)
        (workshop / "bench.json").write_text(data + "\n", encoding="utf-8")
        (workshop / "bench.txt").write_text("\n".join(report(bench)) + "\n", encoding="utf-8")
        with suppress(DefinitionError):  # no run succeeded; the table says why
            save(plot_work_precision(bench), workshop / "work-precision.svg")

    return deliver(folder, fill)


def report(bench: Bench) -> list[str]:
    """The lines that are printed of a measurement: its reference, its tables, who is absent."""
    problem, reference = bench.problem, bench.reference
    grid = f"t from {problem.grid[0]:g} to {reference.t[-1]:g}, {len(reference.t)} instants"
    lines = [f"{problem.system.name}, scene {problem.scene}: {grid}"]
    lines.append("outputs: " + ", ".join(problem.outputs))
    lines.append(f"reference: accurate to {reference.accuracy:.1e}, where these two agree:")
    lines += [f"  {how}" for how in reference.how]
    lines += [reference.note] if reference.note else []
    if bench.setup is not None:
        s = bench.setup
        lines.append(
            f"set-up ({s.method}), derivation included, imports excluded: cold {s.cold:.2f} s, "
            f"warm {s.warm:.2f} s of CPU (by the clock {s.cold_clock:.2f} s, {s.warm_clock:.2f} s)"
        )
    lines += ["", *_table(bench), "", *_equal(bench)]
    absent = [[m.name, m.absent] for m in bench.methods if m.absent]
    if absent:
        lines += ["", "did not take part:", *columns(absent, "  ")]
    lines += [
        f"{m.name} at {p.setting:g} failed: {p.failed.splitlines()[0]}"
        for m in bench.methods
        for p in m.points
        if p.failed
    ]
    lines += [f"{m.name}: {m.note}" for m in bench.methods if m.note]
    if bench.interrupted:
        lines.append("stopped by hand; what was measured until then is above")
    return lines


def _table(bench: Bench) -> list[str]:
    head = ["method", "setting", "error", "us per unit", "evaluations", "worst drift"]
    rows = [[m.name, *_row(m, p)] for m in bench.methods for p in m.points]
    return columns([head, *rows])


def _row(measured: Measured, point: Point) -> list[str]:
    setting = ("step " if measured.knob != "tolerance" else "") + f"{point.setting:g}"
    if point.failed:
        return [setting, "failed", "-", "-", "-"]
    drift = max((point.drift or {}).values(), default=None)
    return [
        setting, f"{point.error:.1e}", f"{1e6 * point.per_unit:.4g}", str(point.evaluations),
        "-" if drift is None else f"{drift:.1e}",
    ]  # fmt: skip


def _equal(bench: Bench) -> list[str]:
    """Times at equal error, and how many times slower than the fastest of ours."""
    from voronec.accuracy.bench.measurement import AT

    head = ["at equal error"]
    for error in AT:
        head += [f"us per unit at {error:g}", "times the first"]
    rows: list[list[str]] = []
    present = [m for m in bench.methods if m.good]
    first: dict[float, Any] = {}
    for measured in present:
        row = [measured.name]
        for error in AT:
            cost = measured.at(error, extrapolate=measured.has_order)
            if cost.seconds is None:
                row += [cost.kind, "-"]
                continue
            first.setdefault(error, cost.seconds)
            bound = MARKS.get(cost.kind, "")
            row += [f"{bound}{1e6 * cost.seconds:.4g}", f"{cost.seconds / first[error]:.3g}"]
        rows.append(row)
    lines = columns([head, *rows])
    if any(cell.startswith("~") for row in rows for cell in row):
        lines.append("~ no run is that good: extrapolated along the order seen in its finest runs")
    return lines
