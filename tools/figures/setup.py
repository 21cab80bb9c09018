"""Large systems of one's own, from nothing to the first equations and to the first step of a run.

``python tools/bench.py setup [SYSTEM ...]``, the worst first; --limit SECONDS for each.

Each figure is CPU time of a fresh process with empty caches, what it imports included, and beside
it SymPy's for the same mechanism: ``KanesMethod`` and its equations; for a run ``lambdify`` with
cse of mass matrix and forcing, and one call.  Of a run of ours everything counts but integrating.
``raw`` are the operations of the derivation as it comes, shared parts counted once; ``printed`` the
characters of rates, mass and force (0 where a program is shown instead), ``lines`` and
``operations`` those of the program.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

LIMIT = 120


def _cpu_seconds() -> float:
    """CPU seconds of this process, of its start too, and of compilers that it waited for."""
    found = os.times()
    return found.user + found.system + found.children_user + found.children_system


def _system(name: str) -> Any:
    from figures.setup_systems import SYSTEMS

    return SYSTEMS[name]().system()


def equations(name: str) -> dict[str, Any]:
    """Seconds to the first equations on the screen."""
    import voronec as vo
    from voronec.equations.voronec_equations import derivation_parts

    lines = next(derivation_parts(vo.derive(_system(name))))
    return {"seconds": _cpu_seconds(), "shown": len("\n".join(lines))}


def run(name: str) -> dict[str, Any]:
    """Seconds of set-up of a run."""
    import voronec as vo

    system = _system(name)
    begun = _cpu_seconds()
    grid = [0.0, 0.01, 0.02]
    motion = vo.integrate(system, times=grid)
    return {
        "seconds": _cpu_seconds() - begun - motion.cost.run,
        "by": f"{motion.cost.method}, {motion.cost.formulation}",
    }


def sizes(name: str) -> dict[str, Any]:
    """How long the equations are, and the program."""
    import voronec as vo
    from voronec.algebra.shape import operations
    from voronec.algebra.typeset import caret_text
    from voronec.equations.program import operation_count

    eqs = vo.derive(_system(name))
    raw = operations(eqs.raw.form.expressions)
    entries = [*eqs.rates, *eqs.mass, *eqs.force] if eqs.is_short else []
    return {
        "raw": raw,
        "printed": sum(len(caret_text(e)) for e in entries),
        "lines": len(eqs.python().splitlines()),
        "operations": operation_count(eqs.program.derivative.expressions),
    }


def sympy_equations(name: str) -> dict[str, Any]:
    """Seconds to SymPy's equations."""
    _form_of(name)
    return {"seconds": _cpu_seconds()}


def sympy_run(name: str) -> dict[str, Any]:
    """Seconds to SymPy's function of a run, and one call of it."""
    import sympy as sp

    begun = _cpu_seconds()
    method = _form_of(name)
    letters = {x: sp.Symbol(f"s{i}") for i, x in enumerate([*method.q, *method.u])}
    table = [e.xreplace(letters) for e in (method.mass_matrix_full, method.forcing_full)]
    given = sorted(set().union(*(e.free_symbols for e in table)), key=str)
    function = sp.lambdify(given, table, cse=True)
    function(*[0.1 + 0.07 * i for i in range(len(given))])
    return {"seconds": _cpu_seconds() - begun}


def _form_of(name: str) -> Any:
    from figures.setup_systems import SYSTEMS

    method = SYSTEMS[name]().kane()
    method.kanes_equations()
    return method


MEASURES: dict[str, Callable[[str], dict[str, Any]]] = {
    "equations": equations,
    "sympy_equations": sympy_equations,
    "run": run,
    "sympy_run": sympy_run,
    "sizes": sizes,
}


def child(measure: str, name: str, limit: int) -> dict[str, Any]:
    """What a fresh process measures; ``failed`` says why it does not."""
    with tempfile.TemporaryDirectory() as caches:
        found = subprocess.run(
            [sys.executable, sys.argv[0].split()[0], "setup", name, "--measure", measure],
            capture_output=True, text=True, check=False,
            env={**os.environ, "XDG_CACHE_HOME": caches},
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5)),
        )  # fmt: skip
    if found.returncode:
        told = found.stderr.strip().splitlines()[-1:] or [f"over {limit} s"]
        return {"failed": told[0][:70] if found.returncode > 0 else f"over {limit} s"}
    answer: dict[str, Any] = json.loads(found.stdout.splitlines()[-1])
    return answer


def _text(found: dict[str, Any], key: str = "seconds") -> str:
    value = found.get(key, "-")
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def main() -> int:
    """Measure and print."""
    from figures.setup_systems import SYSTEMS

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("systems", nargs="*", metavar="SYSTEM", help=", ".join(SYSTEMS))
    parser.add_argument("--limit", type=int, default=LIMIT, help="CPU seconds for each figure")
    parser.add_argument("--only", nargs="*", choices=[*MEASURES], default=[*MEASURES])
    parser.add_argument("--measure", choices=[*MEASURES], help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        print(json.dumps(MEASURES[options.measure](options.systems[0])))
        return 0
    print(
        f"{'system':12} {'equations':>9} {'SymPy':>7} {'set-up':>7} {'SymPy':>7} "
        f"{'raw':>6} {'printed':>7} {'lines':>5} {'program':>7}  run by"
    )
    began = time.monotonic()
    for name in options.systems or SYSTEMS:
        told = {m: child(m, name, options.limit) if m in options.only else {} for m in MEASURES}
        a, b, c, d, e = told.values()
        print(
            f"{name:12} {_text(a):>9} {_text(b):>7} {_text(c):>7} {_text(d):>7} "
            f"{_text(e, 'raw'):>6} {_text(e, 'printed'):>7} {_text(e, 'lines'):>5} "
            f"{_text(e, 'operations'):>7}  {_text(c, 'by')}"
            + "".join(f"; {m}: {f['failed']}" for m, f in told.items() if "failed" in f),
            flush=True,
        )
    print(f"{time.monotonic() - began:.0f} s in all")
    return 0
