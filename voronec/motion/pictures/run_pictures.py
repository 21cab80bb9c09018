"""The pictures of a motion: its outputs against the time, its path, the system's own drawing."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, BinaryIO

from voronec.declaration.plugin_files import failure
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from pathlib import Path

    from voronec.motion.pictures.motion_record import MotionRecord

__all__ = ["drawing", "pictures", "save"]


def pictures(trajectory: MotionRecord) -> dict[str, Any]:
    """Matplotlib figures by name.

    ``plot``, of all outputs; ``path``, where there are outputs ``x`` and ``y``; ``drawing``, where
    the system has one and the trajectory holds what it shows.
    """
    from voronec.motion.pictures.time_plots import plot_trajectory

    system = trajectory.system
    found = {"plot": plot_trajectory(trajectory, title=system.title or system.name)}
    if {"x", "y"} <= set(trajectory.outputs):
        found["path"] = _path(trajectory)
    if system.drawing is not None:
        with suppress(_AbsentData):
            found["drawing"] = drawing(trajectory)
    return found


class _AbsentData(DefinitionError):
    """A drawing shows what the trajectory does not hold."""


def drawing(trajectory: MotionRecord) -> Any:
    """The system's own drawing, as a matplotlib figure.

    It is a function of the trajectory, or a mapping of titles to pairs of names (colatitude,
    longitude) for traces on spheres, of which those are drawn that the trajectory holds.
    ``DefinitionError`` where it fails.
    """
    own = trajectory.system.drawing
    if isinstance(own, Mapping):
        return _spheres(trajectory, own)
    try:
        return own(trajectory)
    except DefinitionError as error:
        raise _AbsentData(str(error)) from error
    except Exception as error:
        what = failure(error, getattr(getattr(own, "__code__", None), "co_filename", "?"))
        name = trajectory.system.name
        raise DefinitionError(f"the drawing of system '{name}' failed: {what}") from error


def _spheres(trajectory: MotionRecord, titled: Mapping[str, Any]) -> Any:
    """The traces that a trajectory holds; ``_AbsentData`` where it is none of them."""
    import numpy as np

    from voronec.closed.pictures.sphere_picture import SphereTrace, traces_figure

    elapsed = np.abs(np.asarray(trajectory.t, float) - float(trajectory.t[0]))
    found, missing = [], None
    for title, (u, v) in titled.items():
        try:
            held = trajectory[u], trajectory[v]
        except DefinitionError as error:
            missing = error
            continue
        found.append(SphereTrace(*held, elapsed, title=title, axis=""))
    if missing is not None and not found:
        raise _AbsentData(str(missing)) from missing
    return traces_figure(found)


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
    import numpy as np
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    from voronec.closed.pictures.style import INK, MARK, STYLE
    from voronec.motion.pictures.time_plots import plain_ticks, settle_layout

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
        plain_ticks(panel.xaxis)
        plain_ticks(panel.yaxis)
        settle_layout(figure)
    return figure
