"""Clocks and counters of the benchmark; SymPy's own derivation of the same system."""

from __future__ import annotations

import random
import statistics
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import sympy as sp
from sympy.core.cache import clear_cache
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import voronec as vo

__all__ = [
    "by_sympy",
    "command",
    "count_operations",
    "median_time",
    "operations",
    "random_point",
    "sympy_operations",
]


def median_time(work: Callable[[], Any], runs: int = 7) -> float:
    """The median wall-clock time of several runs, in seconds, each with SymPy's cache empty."""
    times = []
    for _ in range(runs):
        clear_cache()
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def by_sympy(system: vo.System) -> tuple[float, LagrangesMethod]:
    """SymPy's Lagrange equations of a system's own Lagrangian and constraints, and their time.

    SymPy wants coordinates as functions of time; they are put in before the clock starts, and
    SymPy's cache is emptied.
    """
    q = {c: dynamicsymbols(str(c)) for c in system.coordinates}
    moving = q | {vo.velocity(c): function.diff(vo.time) for c, function in q.items()}
    lagrangian = system.lagrangian.xreplace(moving)
    constraints = [c.xreplace(moving) for c in system.constraints]
    clear_cache()
    method = LagrangesMethod(lagrangian, list(q.values()), nonhol_coneqs=constraints)
    start = time.perf_counter()
    method.form_lagranges_equations()
    return time.perf_counter() - start, method


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


def random_point(system: vo.System, dice: random.Random) -> dict[str, Any]:
    """Random coordinates and velocities on the relations, default or random parameters."""
    point: dict[str, Any] = {
        p.name: sp.Rational(dice.randint(500, 1500), 1000) if p.value is None else p.value
        for p in system.parameters
    }
    for symbol in (*system.coordinates, *system.velocities, vo.time):
        point[_name(symbol)] = sp.Rational(dice.randint(-900, 900), 1000)
    return point | _on_relations(system, point)


def _name(symbol: sp.Expr) -> str:
    return str(symbol) if isinstance(symbol, sp.Symbol) else str(symbol.func.__name__)


def _on_relations(system: vo.System, point: Mapping[str, Any]) -> dict[str, Any]:
    """The coordinates, moved onto the relations between them by Newton's method."""
    relations = sp.Matrix(list(system.fibration.relations))
    if not relations.rows:
        return {}
    q = sp.Matrix([sp.Symbol(_name(c)) for c in system.coordinates])
    plain = {c: sp.Symbol(_name(c)) for c in system.coordinates}
    relations = relations.xreplace(
        plain | {sp.Symbol(p): v for p, v in point.items() if sp.Symbol(p) not in q}
    )
    slope = relations.jacobian(q)
    value = sp.Matrix([sp.N(point[str(c)], 70) for c in q])
    for _ in range(9):
        at = dict(zip(q, value, strict=True))
        steep = sp.N(slope.xreplace(at), 70)
        value -= steep.T * (steep * steep.T).LUsolve(sp.N(relations.xreplace(at), 70))
    return {str(c): x for c, x in zip(q, value, strict=True)}


def command(*arguments: str) -> tuple[float, subprocess.CompletedProcess[str]]:
    """Run a program to its end: wall-clock time, and how it ended."""
    start = time.perf_counter()
    run = subprocess.run(arguments, check=False, capture_output=True, text=True)
    return time.perf_counter() - start, run
