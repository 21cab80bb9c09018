"""The pictures of a motion: its outputs against the time, its path, the system's own drawing.

To be imported where a figure is made, since it loads matplotlib.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np
import sympy as sp
from matplotlib.figure import Figure

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import read_sympy_text
from voronec.algebra.typeset import symbol_latex
from voronec.declaration.figure_style import INK, STYLE, WIDTH
from voronec.declaration.plugin_files import failure
from voronec.declaration.reading import several
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from pathlib import Path

    from voronec.motion.pictures.motion_record import MotionRecord


def pictures(trajectory: MotionRecord) -> dict[str, Any]:
    """Matplotlib figures by name.

    ``plot``, of all outputs; ``path``, where there are outputs ``x`` and ``y``; ``drawing``, where
    the system has one and the trajectory holds what it shows.
    """

    system = trajectory.system
    figures = {"plot": plot_trajectory(trajectory, title=system.title or system.name)}
    if {"x", "y"} <= set(trajectory.outputs):
        figures["path"] = _path(trajectory)
    if system.drawing is not None:
        with suppress(_AbsentData):
            figures["drawing"] = drawing(trajectory)
    return figures


class _AbsentData(DefinitionError):
    """A drawing shows what the trajectory does not hold."""


def drawing(trajectory: MotionRecord) -> Any:
    """The system's own drawing, as a matplotlib figure.

    It is a function of the trajectory, or a mapping of titles to pairs of names (colatitude,
    longitude) for traces on spheres, of which those are drawn that the trajectory holds.
    ``DefinitionError`` where it fails.
    """
    recipe = trajectory.system.drawing
    if isinstance(recipe, Mapping):
        return _spheres(trajectory, recipe)
    try:
        return recipe(trajectory)
    except DefinitionError as error:
        raise _AbsentData(str(error)) from error
    except Exception as error:
        what = failure(error, getattr(getattr(recipe, "__code__", None), "co_filename", "?"))
        name = trajectory.system.name
        raise DefinitionError(f"the drawing of system '{name}' failed: {what}") from error


def _spheres(trajectory: MotionRecord, titled: Mapping[str, Any]) -> Any:
    """The traces that a trajectory holds; ``_AbsentData`` where it is none of them."""

    from voronec.closed.pictures.sphere_picture import SphereTrace, traces_figure

    elapsed = np.abs(np.asarray(trajectory.t, float) - float(trajectory.t[0]))
    traces, missing = [], None
    for title, (u, v) in titled.items():
        try:
            held = trajectory[u], trajectory[v]
        except DefinitionError as error:
            missing = error
            continue
        traces.append(SphereTrace(*held, elapsed, title=title, axis=""))
    if missing is not None and not traces:
        raise _AbsentData(str(missing)) from missing
    return traces_figure(traces)


def save(figure: Any, target: Path | BinaryIO, suffix: str = "") -> None:
    """Write a figure, the same bytes every time, to a path, or in the format ``suffix`` to a
    stream."""
    from matplotlib import rc_context

    suffix = suffix or getattr(target, "suffix", ".svg")
    dated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with rc_context({"svg.hashsalt": "voronec"}):
        figure.savefig(target, dpi=150, metadata=dated.get(suffix), format=suffix[1:])


def _path(trajectory: MotionRecord) -> Any:
    """The curve (x, y) in its plane; the dot is its start."""
    from matplotlib import rc_context

    from voronec.declaration.figure_style import INK, MARK, STYLE

    x, y = trajectory["x"], trajectory["y"]
    with rc_context(STYLE):
        # a long and narrow path has a narrow panel, but never one too narrow for its numbers
        wide, high = (np.ptp(np.asarray(q, dtype=float)) for q in (x, y))
        slim = np.clip(wide / high if wide and 0 < high < np.inf else 1.0, 0.4, 2.5)
        size = (4.5 * min(slim, 1.0) + 0.7, 4.5 * min(1 / slim, 1.0) + 0.7)
        figure = Figure(figsize=size, layout="constrained")
        panel = figure.subplots()
        panel.plot(x, y, color=INK, linewidth=0.9)
        panel.plot(x[:1], y[:1], "o", color=MARK, markersize=4)
        panel.set(xlabel="$x$", ylabel="$y$", aspect="equal", adjustable="datalim")
        _plain_ticks(panel.xaxis)
        _plain_ticks(panel.yaxis)
        _settle_layout(figure)
    return figure


def quantity_label(trajectory: MotionRecord, name: str) -> str:
    """The mathtext of a quantity's name: ``thetadot`` becomes a dotted theta."""
    system = trajectory.system
    for thing in (*system.coordinates, *system.velocities):
        if name == plain_name(thing):
            return f"${symbol_latex(name)}$"
        if name == plain_name(velocity(thing)):
            return rf"$\dot{{{symbol_latex(plain_name(thing))}}}$"
    if name in system.integrals or name in system.invariants:
        return name
    try:
        expr = read_sympy_text(name, "a label", {plain_name(s): s for s in system.known_symbols()})
    except DefinitionError:
        return name
    return f"${sp.latex(expr)}$"


LARGEST = 1e300
"""Beyond this the limits of a panel would be no doubles."""


def plot_trajectory(
    trajectory: MotionRecord, names: Sequence[str] | None = None, title: str | None = None
) -> Any:
    """Quantities against the time, one panel each, on one time axis.

    ``names`` are what ``trajectory[...]`` understands, by default its outputs.  Returns a
    matplotlib ``Figure``; save it as SVG or PDF for print.
    """
    from matplotlib import rc_context

    shown = several(trajectory.outputs if names is None else names, "names", '"x"')
    if not shown:
        raise DefinitionError("there is nothing to plot; name outputs")
    columns = 1 if len(shown) <= 5 else 2
    rows = -(-len(shown) // columns)
    with rc_context(STYLE):
        height = 1.15 if rows < 5 else 0.95
        figure = NotebookFigure(figsize=(WIDTH, 0.5 + height * rows), layout="constrained")
        panels = figure.subplots(rows, columns, sharex=True, squeeze=False)
        for place, panel in enumerate(panels.T.flat):
            if place >= len(shown):
                panel.set_visible(False)
                continue
            _curve(panel, trajectory, shown[place])
            lowest = place % rows == rows - 1 or place == len(shown) - 1
            panel.tick_params(labelbottom=lowest)
        figure.align_ylabels()
        figure.supxlabel("$t$", fontsize=10)
        if title:
            figure.suptitle(title, fontsize=10)
        _settle_layout(figure)
    return figure


def _settle_layout(figure: Any) -> None:
    """Settle the fonts, while the style is in force, and the layout, which costs a drawing."""
    from matplotlib import rc_context

    figure.get_layout_engine().execute(figure)
    with rc_context({"figure.autolayout": False, "figure.constrained_layout.use": False}):
        # none at all: with a placeholder of its own matplotlib draws twice to save once
        figure.set_layout_engine(None)


def _plain_ticks(axis: Any) -> None:
    """Digits at the ticks of an axis are text: only a power of ten above it is a formula, and to
    typeset each takes longer than the motion."""
    from matplotlib.ticker import ScalarFormatter

    class Digits(ScalarFormatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            label: str = super().__call__(x, pos)
            return label.removeprefix("$\\mathdefault{").removesuffix("}$")

    axis.set_major_formatter(Digits(useMathText=True))


def _curve(panel: Any, trajectory: MotionRecord, name: str) -> None:
    from matplotlib.ticker import MaxNLocator

    values = trajectory[name]
    panel.plot(trajectory.t, values, color=INK, linewidth=0.9)
    panel.set_ylabel(quantity_label(trajectory, name))
    panel.margins(x=0)
    _plain_ticks(panel.xaxis)
    _plain_ticks(panel.yaxis)
    panel.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
    panel.spines[["top", "right"]].set_visible(False)
    known = np.asarray(values, dtype=float)
    known = known[np.abs(known) < LARGEST]  # an output may have a pole on the way
    size = np.abs(known).max(initial=0.0)
    if len(known) and np.ptp(known) <= 1e-9 * size:
        # a constant is a level line, not magnified rounding
        panel.set_ylim(known[0] - 0.5 * (size or 1.0), known[0] + 0.5 * (size or 1.0))


class NotebookFigure(Figure):
    """A figure made without pyplot, which is shown where a cell ends with it."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png", dpi=110)
        return stream.getvalue()
