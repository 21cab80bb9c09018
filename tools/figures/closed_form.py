"""Figures of the closed form: ``python tools/bench.py closed-form --page docs/closed-form.md``.

Every figure comes of one run on one machine; nothing here is a test.  The references are stored
(``tools/bench.py references`` makes them) or made on the way, and share no code with the
package.  Some rows need heyoka.
"""

from __future__ import annotations

from pathlib import Path

import voronec as vo
from figures import closed_kinds, closed_rows, table
from figures.closed_rows import hard_table
from figures.peers import PEERS
from figures.table import Sheet
from voronec.accuracy.bench import OWN, measure, reference, scene_problem


def cases_table(_page: Path) -> str:
    """Every hard case in Markdown."""
    head = ("case", "error, to 100 periods", "error at 1e6 periods", "radius asked for 20 digits")
    lines = (
        (name, f"{early:.1e}", "-" if late != late else f"{late:.1e}", f"{wide:.1e}")
        for name, early, late, wide in hard_table()
    )
    return table.markdown(head, lines)


def curve(page: Path) -> str:
    """Speed against error on Demchenko's ball, the closed form among the methods."""
    problem = scene_problem(vo.load("demchenko"), time=1000.0)
    names = ("closed-form", "heyoka", "scipy", "dop853-numba")
    true = reference(problem, 1e-13)
    bench = measure(problem, names, budget=30.0, against=true, among=(*OWN, *PEERS))
    table.plot(bench, page)
    return table.runs(bench)


SHEET = Sheet(
    "tools/bench.py closed-form",
    {**closed_rows.ROWS, **closed_kinds.ROWS},
    {"cases": cases_table, "curve": curve},
    ("python-flint", "numpy", "heyoka"),
)


def main() -> int:
    """Measure, print, and write the page."""
    return table.main(__doc__, lambda _short: SHEET)
