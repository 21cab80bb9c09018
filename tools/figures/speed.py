"""Speed against error, figure by figure: ``python tools/bench.py speed --page docs/speed.md``.

Every figure is a ratio or a time of one run on one machine; nothing here is a test.  Needs heyoka,
scipy, numba and mujoco (the extra ``bench``).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from figures import calls, many, rows, table
from figures.problems import FULL, SHORT, Extent, exact, measurement, problem
from figures.table import Sheet
from voronec.accuracy.bench import Bench

ROWS = {**calls.ROWS, **rows.ROWS, **many.ROWS, "setup": calls.setup, "large": rows.large}
CURVES = (
    "heyoka", "heyoka-full", "heyoka-by-hand", "scipy", "dop853-numba",
    "dop853-lambdify-invariants", "dop853-lambdify-coordinates",
)  # fmt: skip


def curve(page: Path, extent: Extent) -> str:
    """Error against time of the methods on the ball, and what each of them is."""
    name = "ball on a sphere"
    methods = tuple(measurement(name, method, extent) for method in CURVES)
    true = exact(name, extent)
    lines = [table.curve(Bench(problem(name, extent), true, methods, {}), page), ""]
    lines += [f"- `{m.name}`: {m.about}" for m in methods]
    return "\n".join([*lines, "", f"The reference is accurate to {true.accuracy:.0e}."])


def sheet(short: bool) -> Sheet:
    """The figures of speed, in full or to see that they run."""
    extent = SHORT if short else FULL
    return Sheet(
        "tools/bench.py speed",
        {name: partial(row, extent) for name, row in ROWS.items()},
        {"curve": partial(curve, extent=extent)},
        "heyoka scipy numba mujoco numpy sympy symengine".split(),
        missed_first=True,
    )


def main() -> int:
    """Measure, print, and exit with 1 where a figure is missed."""
    return table.main(__doc__, sheet)
