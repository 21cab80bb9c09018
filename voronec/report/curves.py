"""The picture of a motion: the system's own drawing, else its outputs against the time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from voronec.errors import DefinitionError
from voronec.execution import failure

if TYPE_CHECKING:
    from pathlib import Path

    from voronec.flow import Trajectory

__all__ = ["draw", "save"]


def draw(trajectory: Trajectory) -> Any:
    """A matplotlib figure of a trajectory.

    Raises ``DefinitionError`` where the drawing of the system fails.
    """
    drawing = trajectory.system.drawing
    if drawing is None:
        return _curves(trajectory)
    try:
        return drawing(trajectory)
    except Exception as error:
        what = failure(error, getattr(getattr(drawing, "__code__", None), "co_filename", "?"))
        name = trajectory.system.name
        raise DefinitionError(f"the drawing of system '{name}' failed: {what}") from error


def save(figure: Any, path: Path) -> None:
    """Write a figure, the same bytes every time; its format is that of the path."""
    from matplotlib import rc_context

    dated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with rc_context({"svg.hashsalt": "voronec"}):
        figure.savefig(path, dpi=150, metadata=dated.get(path.suffix))


def _curves(trajectory: Trajectory) -> Any:
    """One panel an output, and the path in the plane where there are outputs ``x`` and ``y``."""
    from matplotlib.figure import Figure

    names = trajectory.outputs
    plane = {"x", "y"} <= set(names)
    rows = max(len(names), 1)
    figure = Figure(figsize=(10 if plane else 7, 1 + 1.3 * rows), layout="constrained")
    grid = figure.add_gridspec(rows, 2 if plane else 1)
    first = None
    for row, name in enumerate(names):
        first = panel = figure.add_subplot(grid[row, 0], sharex=first)
        panel.plot(trajectory.t, trajectory[name], linewidth=1.1)
        panel.set_ylabel(name)
        panel.tick_params(labelbottom=row == rows - 1)
        panel.grid(alpha=0.25)
    if first is not None:
        first.set_xlabel("t")
    if plane:
        path = figure.add_subplot(grid[:, 1])
        path.plot(trajectory["x"], trajectory["y"], linewidth=1.1)
        path.plot(trajectory["x"][:1], trajectory["y"][:1], "o", markersize=4)
        path.set(xlabel="x", ylabel="y", aspect="equal", title="path, from the dot")
        path.grid(alpha=0.25)
    figure.suptitle(trajectory.system.title or trajectory.system.name)
    return figure
