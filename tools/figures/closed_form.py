"""Figures of the closed form: ``python tools/bench.py closed-form --page docs/closed-form.md``.

Every figure comes of one run on one machine; nothing here is a test.  The references are stored
(``tools/bench.py references`` makes them) or made on the way, and share no code with the
package.  Some rows need heyoka.
"""

from __future__ import annotations

import argparse
import json
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import voronec as vo
from figures import closed_kinds, closed_rows
from figures.closed_rows import hard_table
from figures.rows import rows_of
from figures.table import Row, markdown, runs, table
from voronec.accuracy.bench import ask, measure, reference
from voronec.accuracy.bench.work_precision_picture import plot_work_precision
from voronec.motion.pictures.run_pictures import save

ROWS: dict[str, Callable[[], Iterator[Row]]] = {**closed_rows.ROWS, **closed_kinds.ROWS}
CASES, CURVE = "cases", "curve"
"""The table of hard cases, and the plot."""
PACKAGES = ("python-flint", "numpy", "heyoka")
MARKS = "<!-- {}: written by tools/bench.py closed-form -->", "<!-- end of {} -->"


def _misses(rows: list[Row]) -> str:
    """Under the table, why figures are missed."""
    missed = [f"- {r.row}: {r.why}." for r in rows if not r.good and r.why]
    return "\n".join(["", "", "What is missed, and why:", "", *missed]) if missed else ""


def cases_table() -> str:
    """Every hard case in Markdown."""
    head = ("case", "error, to 100 periods", "error at 1e6 periods", "radius asked for 20 digits")
    lines = (
        (name, f"{early:.1e}", "-" if late != late else f"{late:.1e}", f"{wide:.1e}")
        for name, early, late, wide in hard_table()
    )
    return markdown(head, lines)


def curve(page: Path) -> str:
    """Speed against error on Demchenko's ball, the closed form among the methods; the plot is
    put beside the page."""
    question = ask(vo.load("demchenko"), time=1000.0)
    exact = reference(question, 1e-13)
    names = ("closed-form", "heyoka", "scipy", "dop853-numba")
    bench = measure(question, names, budget=30.0, against=exact)
    save(plot_work_precision(bench), page.with_suffix(".svg"))
    return runs(bench)


def earlier_figures(page: Path) -> dict[str, Any]:
    """What earlier runs measured, from the file beside the page."""
    file = page.with_suffix(".json")
    known: dict[str, Any] = json.loads(file.read_text("utf-8")) if file.exists() else {}
    return {"rows": {}, CASES: "", CURVE: "", **known}


def write(page: Path, known: dict[str, Any]) -> None:
    """Store what is known beside the page, and put the tables between their marks in it."""
    known["machine"] = _machine()
    page.with_suffix(".json").write_text(json.dumps(known, indent=1) + "\n", "utf-8")
    shown = [Row(**row) for key in ROWS for row in known["rows"].get(key, [])]
    text = page.read_text("utf-8")
    parts = {
        "figures": table(shown) + _misses(shown), CASES: known[CASES], CURVE: known[CURVE],
        "machine": f"Measured on {known['machine']}.",
    }  # fmt: skip
    for name, part in parts.items():
        begin, end = (mark.format(name) for mark in MARKS)
        before, _, rest = text.partition(begin)
        text = before + begin + "\n" + part + "\n" + end + rest.partition(end)[2]
    page.write_text(text, "utf-8")


def main() -> int:
    """Measure, print, and exit with 1 where a figure is missed.

    The page is written after each measurement, so that Ctrl-C keeps what is done.
    """
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    names = [*ROWS, CASES, CURVE]
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"of {', '.join(names)}")
    parser.add_argument("--page", type=Path, help="put them on a page with those measured before")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    options = parser.parse_args()
    unknown = [name for name in options.rows if name not in names]
    if unknown:
        parser.error(f"there is no row '{unknown[0]}'; rows are {', '.join(names)}")
    rows: list[Row] = []
    known = earlier_figures(options.page) if options.page else {"rows": {}}
    for name in options.rows or names:
        if name in ROWS:
            found = rows_of(ROWS[name])
            rows += found
            known["rows"][name] = [asdict(row) for row in found]
            for row in found:
                print(f"{row.row}: {row.reached} ({row.verdict})", file=sys.stderr, flush=True)
        elif options.page:
            known[name] = cases_table() if name == CASES else curve(options.page)
        if options.page:
            write(options.page, known)
    plain = [asdict(row) | {"verdict": row.verdict} for row in rows]
    told = json.dumps({"machine": _machine(), "rows": plain}, indent=1)
    print(told if options.json else table(rows) + _misses(rows))
    return 0 if all(row.good for row in rows) else 1


def _machine() -> str:
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    return f"{platform.machine()}, Python {platform.python_version()}, {packages}"
