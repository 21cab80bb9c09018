"""Models of SymPy's mechanics against SymPy: ``python tools/bench.py mechanics [MODEL ...]``.

Both sides begin with the objects that a user has (``mechanics_models.py``), SymPy's cache empty:
SymPy's with ``KanesMethod(...)`` and ``kanes_equations``, or ``form_lagranges_equations``; ours
with ``from_mechanics`` and what a program is made of.  Times are CPU times of one run, the median
of three, so that only their ratio counts.  Operations are those of SymPy's ``rhs()`` after its
``cse``, and of the program that we print, for the same variables: sums, products, quotients, roots
and functions, both counted by one function.
"""

from __future__ import annotations

import argparse
import statistics
import time
from typing import Any

import sympy as sp
from sympy.core.cache import clear_cache
from sympy.core.function import AppliedUndef
from sympy.physics import mechanics as me

import voronec as vo
from figures.mechanics_models import MODELS
from voronec.equations.program import operation_count
from voronec.equations.program.straight import prune

ENDLESS = ("whipple_bicycle",)
"""Models whose ``rhs()`` SymPy's ``cse`` is not through with after four minutes: a share of 0."""


def time_of(work: Any, make: Any) -> tuple[float, Any]:
    """CPU time of one run on a model that was made before, the median of three, and what came
    out."""
    times = []
    for _ in range(3):
        model = make()
        clear_cache()
        start = time.process_time()
        done = work(model)
        times.append(time.process_time() - start)
    return statistics.median(times), done


def remade(method: Any) -> Any:
    """The call of the method's constructor: for Kane's it solves constraints, which is work."""
    if isinstance(method, me.LagrangesMethod):
        return method
    free = len(method.q) - len(method._qdep)
    count = len(method.u) - len(method._udep)
    kinematic = method._k_ku_implicit * method.u
    kinematic += method._k_kqdot_implicit * method.q.diff(vo.time) + method._f_k_implicit
    motion = [*(method._k_nh * method.u + method._f_nh)] if method._udep else None
    return me.KanesMethod(
        method._inertial, method.q[:free], method.u[:count], kd_eqs=kinematic,
        q_dependent=[*method._qdep], configuration_constraints=[*method._f_h],
        u_dependent=[*method._udep], velocity_constraints=motion,
        u_auxiliary=[*method._uaux], bodies=method.bodies, forcelist=method.loads,
    )  # fmt: skip


def theirs(method: Any) -> Any:
    """SymPy's derivation."""
    method = remade(method)
    if isinstance(method, me.KanesMethod):
        method.kanes_equations()
    else:
        method.form_lagranges_equations()
    return method.mass_matrix_full, method.forcing_full, method


def ours(method: Any) -> vo.VoronecEquations:
    """The engine's, up to the form that programs are made of."""
    eqs = vo.derive(vo.from_mechanics(method))
    _ = eqs.raw.form
    return eqs


def program(eqs: vo.VoronecEquations, method: Any) -> int:
    """Operations of the program that is printed, for the rates of what SymPy's state holds."""
    found, known = eqs.program, {str(x.func) for x in method.q}
    wanted = [str(x) in known or x in found.velocities for x in found.state]
    results = [e for e, kept in zip(found.derivative.results, wanted, strict=True) if kept]
    block = prune(found.derivative.assignments, results)
    return operation_count(block.expressions)


def cse_operations(method: Any) -> int:
    """Operations of SymPy's right-hand side after its ``cse``; its state are letters."""
    letters = {x: sp.Symbol(str(x.func)) for x in sp.Matrix(method.rhs()).atoms(AppliedUndef)}
    replacements, reduced = sp.cse(method.rhs().xreplace(letters))
    return operation_count([*(e for _, e in replacements), *(e for m in reduced for e in m)])


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("models", nargs="*", metavar="MODEL", help=", ".join(MODELS))
    chosen = parser.parse_args().models or [*MODELS]
    for warm in (theirs, ours):  # modules are imported, tables made
        warm(MODELS["rolling_disc"]())
    faster, shorter = [], []
    print(f"{'model':36} {'SymPy s':>8} {'ours s':>8} {'times':>6}   {'cse':>6} {'ours':>6} share")
    for name in chosen:
        slow, (*_, method) = time_of(theirs, MODELS[name])
        quick, eqs = time_of(ours, MODELS[name])
        count = program(eqs, method)
        there = 0 if name in ENDLESS else cse_operations(method)
        faster.append(slow / quick)
        shorter.append(count / there if there else 0.0)
        print(
            f"{name:36} {slow:8.3f} {quick:8.3f} {faster[-1]:6.1f}   {there:6} {count:6} "
            f"{shorter[-1]:.2f}", flush=True,
        )  # fmt: skip
    times, share = statistics.median(faster), statistics.median(shorter)
    print(f"median: {times:.1f} times as fast, {share:.2f} of the operations")
    return 0
