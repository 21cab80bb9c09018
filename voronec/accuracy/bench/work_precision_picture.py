"""The work-precision plot of a measurement: error against CPU time per unit of time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.accuracy.bench import Bench, Measured

COLOURS = ("#1b3a5c", "#b3361e", "#2f7d5b", "#b07d12", "#6b4a8a", "#3d8fb0", "#8a97a6", "#7a4a2b")
MARKERS = "osD^vP*X"
SIZE = (6.4, 4.4)
"""Inches."""


def plot_work_precision(bench: Bench) -> Any:
    """Error against CPU time per unit of time, both logarithmic; lower and further left is better.

    Our own methods are drawn thick, peers thin; the accuracy of the reference is a dashed line.
    Returns a matplotlib ``Figure``; ``DefinitionError`` where no run succeeded.
    """
    from voronec.declaration.figure_style import SOFT, figure_in_style

    shown = [m for m in bench.methods if m.good]
    if not shown:
        raise DefinitionError("no run succeeded, so there is nothing to plot")
    with figure_in_style(*SIZE) as figure:
        panel = figure.subplots()
        panel.set(xscale="log", yscale="log")
        for place, measured in enumerate(shown):
            _curve(panel, measured, place)
        panel.axhline(bench.reference.accuracy, color=SOFT, linewidth=0.7, linestyle=(0, (4, 3)))
        panel.annotate(
            "accuracy of the reference", (1, bench.reference.accuracy), (-2, 2),
            xycoords=("axes fraction", "data"), textcoords="offset points", ha="right",
            fontsize=7, color=SOFT,
        )  # fmt: skip
        panel.set_xlabel("CPU seconds per unit of time")
        panel.set_ylabel("largest relative error of the outputs")
        panel.grid(which="major", color="#dfe4ea", linewidth=0.5)
        panel.spines[["top", "right"]].set_visible(False)
        figure.legend(loc="outside right upper", fontsize=7.5, frameon=False, handlelength=2.2)
        system = bench.problem.system
        panel.set_title(f"{system.title or system.name}, T = {bench.problem.span:g}", fontsize=10)
    return figure


def _curve(panel: Any, measured: Measured, place: int) -> None:
    ours = measured.about.startswith("ours")
    colour = COLOURS[place % len(COLOURS)]
    panel.plot(
        [p.per_unit for p in measured.good],
        [p.error for p in measured.good],
        marker=MARKERS[place % len(MARKERS)],
        markersize=4.5 if ours else 3.5,
        linewidth=1.6 if ours else 0.8,
        linestyle="-" if place < len(COLOURS) else (0, (3, 1.5)),
        color=colour,
        markerfacecolor=colour if ours else "white",
        label=measured.name,
    )
