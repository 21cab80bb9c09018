"""What a call of ``integrate`` costs, short or long: the second picture of the page of speed."""

from __future__ import annotations

from math import isnan
from pathlib import Path

from figures import table
from figures.problems import BALL, Extent, around
from voronec.accuracy.bench import measure_calls

SPANS = (1.0, 10.0, 100.0, 1000.0)
ERROR = 1e-9
LINES = {
    "heyoka": ("whole call of integrate", "run of integrate"),
    "heyoka-by-hand": ("heyoka by hand",),
    "dop853-numba-by-hand": ("DOP853 in numba, by hand",),
    "dop853-by-hand": ("scipy's DOP853, lambdify by hand",),
}
"""Methods and the lines of the picture that come of them."""


def calls(page: Path, extent: Extent) -> str:
    """Time of a call against its span, drawn beside the page; the table, and the first calls."""
    lines: dict[str, list[float]] = {name: [] for names in LINES.values() for name in names}
    for span in SPANS:
        found = around(BALL, LINES, (ERROR,), span * extent.spans, extent.rounds)
        for method, names in LINES.items():
            for name in names:
                what = "whole" if name.startswith("whole") else "run"
                lines[name].append(1e3 * found.at(method, ERROR, what).median)
    table.picture(
        {name: (SPANS, times) for name, times in lines.items()},
        ("units of time followed", "milliseconds of CPU a call"),
        f"Ball without symmetry on a sphere, error {ERROR:g}", page, "calls",
    )  # fmt: skip
    head = ("milliseconds", *(f"T = {span * extent.spans:g}" for span in SPANS))
    rows = (
        (name, *("not reached" if isnan(x) else f"{x:.3g}" for x in times))
        for name, times in lines.items()
    )
    first = measure_calls("ball-on-sphere", None, 10.0, 1e-11)
    return "\n".join([
        table.markdown(head, rows), "",
        f"The first call ever takes {sum(first.unknown.values()):.2g} s of CPU, imports and "
        f"compilation included, and the first call of a later process, which finds compiled code "
        f"on the disk, {sum(first.known.values()):.2g} s.",
    ])  # fmt: skip
