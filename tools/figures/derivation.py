"""Derivation against SymPy: ``python tools/bench.py derivation --page docs/benchmarks.md``.

Every figure is a ratio, a count or a time of one run on one machine; nothing here is a test.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import voronec as vo
from figures import table
from figures.measure import (
    by_sympy,
    command,
    count_operations,
    median_time,
    operations,
    sympy_operations,
)
from figures.table import Row, Sheet
from voronec.equations.program import Program
from voronec.equations.reduction import descend
from voronec.proof.comparison import random_point

DIGITS = 50


def derivation() -> Iterator[Row]:
    """Demchenko's ball in Neumann coordinates against SymPy's Lagrange equations."""
    ball = vo.load("demchenko")
    # without the quasi-velocities, which SymPy does not know
    plain = _equations_alone(ball, None)
    slow, _ = by_sympy(plain)
    raw = median_time(lambda: _equations(plain).raw.form)
    exact = median_time(lambda: _normal_form(plain))
    framed = median_time(lambda: _normal_form(ball))
    for name, seconds in (
        ("unsimplified", raw),
        ("exact normal form, coordinate velocities", exact),
        ("exact normal form, velocities (s, tau, n)", framed),
    ):
        yield Row(
            f"Demchenko's ball, {name}, against SymPy's {slow:.2f} s",
            f"{slow / seconds:.0f} times as fast ({1000 * seconds:.1f} ms)",
        )


def balls() -> Iterator[Row]:
    """Descent of the Chaplygin ball; a ball without symmetry in exact normal form."""
    chaplygin = vo.load("chaplygin-ball")
    descent = median_time(lambda: descend(replace(chaplygin)), runs=3)
    yield Row("Chaplygin ball, Euler angles to the proved (G, gamma) equations", f"{descent:.2f} s")
    ball = vo.load("gyroscopic-ball-on-sphere")
    for frame, name in ((None, "coordinate velocities"), (ball.frame, "its angular velocity")):
        alone = _equations_alone(ball, frame)
        seconds = median_time(partial(_normal_form, alone), runs=3)
        told = f"{seconds:.2f} s"
        if frame is None:
            slow, _ = by_sympy(alone)
            told += f", SymPy's unsimplified equations {slow / seconds:.1f} times"
        yield Row(f"non-symmetric gyroscopic ball, exact mass and force, {name}", told)


def bicycle() -> Iterator[Row]:
    """A large system: derived, evaluated to 30 digits, written as a program."""
    system = vo.load("bicycle")
    point = random_point(system, 1)
    seconds = median_time(lambda: _equations(system).acceleration(point, digits=30), runs=3)
    size = f"{system.lagrangian.count_ops()} operations in L"
    yield Row(f"bicycle ({size}), derived and its accelerations to 30 digits", f"{seconds:.2f} s")
    program = Program.of(vo.derive(system).form).derivative
    count = count_operations(program.expressions)
    yield Row("bicycle, operations of the right-hand side", str(count))


def shortness() -> Iterator[Row]:
    """Operations of Demchenko's first-order right-hand side, engine against SymPy."""
    ball = vo.load("demchenko")
    eqs = vo.derive(ball)
    engine = operations([*eqs.rates, *eqs.mass.LUsolve(eqs.force)])
    _, method = by_sympy(ball)
    other = sympy_operations(method)
    yield Row(
        "Demchenko's right-hand side, operations against SymPy's",
        f"{engine} / {other} = {engine / other:.3f}",
    )


def help_page() -> Iterator[Row]:
    """``voronec --help`` from a cold interpreter."""
    script = Path(sys.executable).with_name("voronec")
    runs = [command(str(script), "--help") for _ in range(9)]
    seconds = statistics.median(elapsed for elapsed, _ in runs)
    works = all(run.returncode == 0 and "usage" in run.stdout.lower() for _, run in runs)
    _, traced = command(sys.executable, "-X", "importtime", str(script), "--help")
    imported = {line.rpartition("|")[2].strip() for line in traced.stderr.splitlines()}
    heavy = ", ".join(sorted(imported & {"sympy", "numpy"}))
    yield Row(
        "voronec --help",
        f"{seconds:.2f} s, loads {heavy or 'neither sympy nor numpy'}" if works else "it fails",
    )


def routes() -> Iterator[Row]:
    """Accelerations of every system, Voronec's equations against multipliers."""
    worst: dict[str, float] = {}
    for name in vo.names():
        system = vo.load(name)
        eqs = vo.derive(system)
        worst[name] = max(_deviation(system, eqs, random_point(system, i)) for i in range(3))
    name = max(worst, key=lambda key: worst[key])
    yield Row(
        f"accelerations by both routes, {len(worst)} systems, {DIGITS} digits",
        f"largest relative deviation {worst[name]:.1e} ({name})",
    )


def _equations_alone(system: vo.System, frame: vo.Frame | None) -> vo.System:
    """What equations are derived of, in a frame or in coordinate velocities; no claims."""
    return vo.System(
        name=system.name, fibration=system.fibration, lagrangian=system.lagrangian,
        constraints=system.constraints, parameters=system.parameters, frame=frame,
    )  # fmt: skip


def _equations(system: vo.System) -> vo.VoronecEquations:
    """The equations derived anew: a copy of a system knows nothing that was derived before."""
    return vo.derive(replace(system))


def _normal_form(system: vo.System) -> Any:
    eqs = _equations(system)
    return eqs.mass, eqs.force


def _deviation(system: vo.System, eqs: vo.VoronecEquations, point: dict[Any, Any]) -> float:
    one = eqs.acceleration(point, digits=DIGITS)
    other = vo.multiplier_acceleration(system, point, digits=DIGITS + 10)
    scale = max(map(abs, one.values()))
    return float(max(abs(one[q] - other[q]) for q in one) / scale) if scale else 0.0


ROWS: dict[str, Callable[[], Iterator[Row]]] = {
    "derivation": derivation,
    "balls": balls,
    "bicycle": bicycle,
    "shortness": shortness,
    "help": help_page,
    "routes": routes,
}


SHEET = Sheet("tools/bench.py derivation", ROWS, {}, ("sympy",))


def main() -> int:
    """Measure, print, and write the page."""
    return table.main(__doc__, lambda _short: SHEET)
