"""Clocks and counters of the benchmark; SymPy's own derivation of the same system."""

from __future__ import annotations

import statistics
import subprocess
import time
from collections.abc import Callable, Iterable
from typing import Any

import sympy as sp
from sympy.core.cache import clear_cache
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import voronec as vo


def median_time(work: Callable[[], Any], runs: int = 7) -> float:
    """The median CPU time of several runs, in seconds, each with SymPy's cache empty."""
    times = []
    for _ in range(runs):
        clear_cache()
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def by_sympy(system: vo.System) -> tuple[float, LagrangesMethod]:
    """SymPy's Lagrange equations of a system's own Lagrangian and constraints, and their CPU
    time.

    SymPy wants coordinates as functions of time; they are put in before the clock starts, and
    SymPy's cache is emptied.
    """
    q = {c: dynamicsymbols(str(c)) for c in system.coordinates}
    moving = q | {vo.velocity(c): function.diff(vo.time) for c, function in q.items()}
    lagrangian = system.lagrangian.xreplace(moving)
    constraints = [c.xreplace(moving) for c in system.constraints]
    clear_cache()
    method = LagrangesMethod(lagrangian, list(q.values()), nonhol_coneqs=constraints)
    start = time.process_time()
    method.form_lagranges_equations()
    return time.process_time() - start, method


def count_operations(exprs: Iterable[Any]) -> int:
    """SymPy's ``count_ops``, summed."""
    return sum(int(sp.sympify(e).count_ops()) for e in exprs)


def operations(exprs: Iterable[sp.Expr]) -> int:
    """SymPy's ``count_ops`` of expressions after SymPy's ``cse``."""
    replacements, reduced = sp.cse(list(exprs))
    return count_operations([*(e for _, e in replacements), *reduced])


def sympy_operations(method: LagrangesMethod) -> int:
    """Operations of SymPy's right-hand side, multipliers and all."""
    return operations(method.mass_matrix_full.LUsolve(method.forcing_full))


def command(*arguments: str) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Run a program to its end: wall-clock time, and how it ended."""
    start = time.perf_counter()
    run = subprocess.run(arguments, check=False, capture_output=True, text=True)
    return time.perf_counter() - start, run
