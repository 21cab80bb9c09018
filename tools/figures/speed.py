"""Speed against error, figure by figure: ``python tools/bench.py speed --page docs/speed.md``.

Every figure is a ratio or a time of one run on one machine; nothing here is a test.  Needs heyoka,
scipy, numba and mujoco (the extra ``bench``).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from figures import calls, many, programs, rows, setup
from figures.extent import FULL, SHORT, Extent
from figures.rows import ball, measure_ball, rows_of
from figures.table import Row, runs, table
from voronec.accuracy.bench import Bench
from voronec.accuracy.bench.work_precision_picture import plot_work_precision
from voronec.motion.pictures.run_pictures import save

ROWS = {**calls.ROWS, **rows.ROWS, **programs.ROWS, **many.ROWS, **setup.ROWS}
CURVE = "curve"
"""The plot and the table of methods."""
CURVES = (
    "heyoka", "heyoka-full", "heyoka-by-hand", "scipy", "dop853-numba",
    "dop853-lambdify-invariants", "dop853-lambdify-coordinates",
)  # fmt: skip
PACKAGES = "heyoka scipy numba mujoco numpy sympy symengine".split()

PAGE = """# Speed against error

Written by `python tools/bench.py speed --page docs/speed.md`: every row comes from one run on one
machine; naming rows measures those anew and keeps the others. Times are CPU time of one thread,
set-up excluded unless said. Both sides of a ratio take turns. "1.1 times (1 to 1.2 in 5)" is the
middle of five repetitions, the smallest and the largest; a repetition of a short run is the best
of many, and what takes more than two seconds is repeated once. A whole call is one of `integrate`
after the first: all is read, checked and evaluated. The plot takes one method after the other.
Methods are compared at equal error, never at equal tolerance: the error is the
largest of all outputs over the whole grid against a reference that two independent runs of over 20
digits agree on, and a time at an error is interpolated between the runs on either side of it.
Unless said otherwise the motion is the ball without symmetry on a sphere, scene `default`,
T = 1000, and the outputs are gamma and omega.

{table}

{reasons}

The peers run in the same process and are given the same numbers. None of them does what another
can: MuJoCo solves contact with friction of many bodies, and the peers with `lambdify` that start
from reduced equations start from what the engine found. On short runs the overhead of a call shows:
when it was tried, MuJoCo was 4652 times slower at T = 40 and 1407 times at T = 10.

## The ball on a sphere, method by method

![Error against CPU time](speed.svg)

{curve}

The reference is accurate to {accuracy:.0e}.

`voronec bench NAME` measures any other system in this way. The hard cases have a page of their own:
[hard cases](hard-cases.md).

Measured on {machine}.
"""


def reasons(rows: list[Row]) -> str:
    """Why figures are missed, each once."""
    missed: dict[str, list[str]] = {}
    for row in rows:
        if not row.good and row.why:
            missed.setdefault(row.why, []).append(row.row)
    if not missed:
        return "Every figure is reached."
    lines = ["What is missed, and why:", ""]
    lines += [f"- {'; '.join(what)}. {why[0].upper()}{why[1:]}." for why, what in missed.items()]
    return "\n".join(lines)


def curves(extent: Extent) -> Bench:
    """Error against time of the methods on the ball."""
    question, exact = ball(extent)
    return Bench(question, exact, tuple(measure_ball(name, extent) for name in CURVES), {})


def curve_table(bench: Bench) -> str:
    """The runs of a measurement in Markdown."""
    return "\n".join([runs(bench), "", *(f"- `{m.name}`: {m.about}" for m in bench.methods)])


def earlier_figures(page: Path) -> dict[str, Any]:
    """What earlier runs measured, from the file beside the page."""
    file = page.with_suffix(".json")
    known: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {}
    return {"rows": {}, "curve": "", "accuracy": 0.0, **known}


def write_page(page: Path, name: str, rows: list[Row], extent: Extent) -> None:
    """Put a measurement among those kept, and write the page anew."""
    known = earlier_figures(page)
    if name == CURVE:
        bench = curves(extent)
        save(plot_work_precision(bench), page.with_suffix(".svg"))
        known |= {"curve": curve_table(bench), "accuracy": bench.reference.accuracy}
    else:
        known["rows"][name] = [asdict(row) for row in rows]
    known["machine"] = _machine()
    page.with_suffix(".json").write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    shown = [Row(**row) for key in ROWS for row in known["rows"].get(key, [])]
    shown.sort(key=lambda row: row.good)  # what is missed is named first
    text = PAGE.format(
        table=table(shown), reasons=reasons(shown), curve=known["curve"],
        accuracy=known["accuracy"], machine=known["machine"],
    )  # fmt: skip
    page.write_text(text, encoding="utf-8")


def main() -> int:
    """Measure, print, and exit with 1 where a figure is missed.

    The page is written after each measurement, so that Ctrl-C keeps what is done.
    """
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    names = [*ROWS, CURVE]
    parser.add_argument("rows", nargs="*", metavar="ROW", help=f"of {', '.join(names)}")
    parser.add_argument("--page", type=Path, help="put them on a page with those measured before")
    parser.add_argument("--json", action="store_true", help="print the rows as JSON")
    parser.add_argument("--short", action="store_true", help="see only that all rows run")
    options = parser.parse_args()
    extent = SHORT if options.short else FULL
    unknown = [name for name in options.rows if name not in names]
    if unknown:
        parser.error(f"there is no row '{unknown[0]}'; rows are {', '.join(names)}")
    if absent := _absent_packages():
        parser.error(f"not installed: {', '.join(absent)}; install the extra 'bench'")
    rows: list[Row] = []
    for name in options.rows or names:
        found = rows_of(ROWS[name], extent) if name != CURVE else []
        rows += found
        for row in found:
            print(f"{row.row}: {row.reached} ({row.verdict})", file=sys.stderr, flush=True)
        if options.page:
            write_page(options.page, name, found, extent)
    print(json.dumps(_plain(rows), indent=1) if options.json else table(rows))
    return 0 if all(row.good for row in rows) else 1


def _plain(rows: list[Row]) -> dict[str, Any]:
    plain = [asdict(row) | {"verdict": row.verdict} for row in rows]
    return {"machine": _machine(), "rows": plain}


def _absent_packages() -> list[str]:
    absent = []
    for name in PACKAGES:
        try:
            version(name)
        except PackageNotFoundError:
            absent.append(name)
    return absent


def _machine() -> str:
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    load, cores = os.getloadavg()[0], os.cpu_count() or 1
    busy = f"; the machine had other work, {load:.0f} processes on {cores} cores"
    return (
        f"{platform.machine()}, Python {platform.python_version()}, {packages}"
        f"{busy if load > cores else ''}"
    )
