"""The page of speed: ``python tools/bench.py speed --page docs/speed.md``.

Every figure is a time of one run on one machine; nothing here is a test.  Needs heyoka, scipy,
numba and mujoco (the extra ``bench``).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

from figures import table
from figures.calls import calls
from figures.many import many
from figures.problems import BALL, FULL, SHORT, Extent, exact, measurement, problem
from figures.rows import peers_table
from figures.table import Sheet
from voronec.accuracy.bench import Bench

SPAN = 1000.0
CURVES = (
    "heyoka", "heyoka-full", "c", "scipy", "heyoka-by-hand", "dop853-numba-by-hand",
    "dop853-by-hand", "dop853-lambdify-coordinates",
)  # fmt: skip


def curve(page: Path, extent: Extent) -> str:
    """Error against time on the ball, drawn beside the page; what each method is."""
    span = SPAN * extent.spans
    methods = tuple(measurement(BALL, method, span) for method in CURVES)
    true = exact(BALL, span)
    table.plot(Bench(problem(BALL, span), true, methods, {}), page)
    return "\n".join(f"- `{m.name}`: {m.about}" for m in methods)


def sheet(short: bool) -> Sheet:
    """The figures of speed, in full or to see that they run."""
    extent = SHORT if short else FULL
    return Sheet(
        "tools/bench.py speed",
        {},
        {
            "curve": partial(curve, extent=extent),
            "calls": partial(calls, extent=extent),
            "many": partial(many, extent=extent),
            "peers": lambda _page: peers_table(extent),
        },
        "heyoka scipy numba mujoco numpy sympy symengine".split(),
    )


def main() -> int:
    """Measure, print, and write the page."""
    return table.main(__doc__, sheet)
