"""A ball that rolls over a sphere, with the trace of the contact on both, as a film.

Films are written by Pillow as .gif, by the program ffmpeg as .mp4, or frame by frame.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.errors import DefinitionError
from voronec.report.rolling_drawing import Rolling, draw_rolling, rolling_view
from voronec.report.sphere_curves import on_sphere
from voronec.report.style import STYLE

if TYPE_CHECKING:
    from voronec.flow import Trajectory
    from voronec.system import System

__all__ = ["Rolling", "check_film", "film", "film_strip", "rolling_of"]

COORDINATES, RADII = ("u", "v", "u1", "v1", "theta"), ("R1", "R2")


def check_film(system: System, target: Path) -> None:
    """``DefinitionError`` where no film of the system can be written there, before any work."""
    names = {plain_name(q) for q in system.coordinates} | {p.name for p in system.parameters}
    missing = [name for name in (*COORDINATES, *RADII) if name not in names]
    if missing:
        raise DefinitionError(
            f"'{system.name}' makes no film of a ball on a sphere: it has no "
            f"{', '.join(missing)}; films need {', '.join(COORDINATES)} and radii R1, R2"
        )
    if not target.parent.is_dir():
        raise DefinitionError(f"'{target}' cannot be written: there is no '{target.parent}'")
    _writer(target, 1)


def rolling_of(trajectory: Trajectory) -> Rolling:
    """The ball of a trajectory in Neumann's coordinates u, v, u1, v1, theta, with radii R1, R2.

    Its attitude is R = B1 Q B^T, with the frames B1, B of both spheres and the turn Q(theta) about
    the common normal (docs/conventions.md).  ``DefinitionError`` where the run holds less.
    """
    system = trajectory.system
    u, v, u1, v1, theta = (np.asarray(trajectory[name], float) for name in COORDINATES)
    outer, own = (float(trajectory.parameters[name]) for name in RADII)
    attitude = _frames(u1, v1) @ _turns(theta) @ np.swapaxes(_frames(u, v), 1, 2)
    return Rolling(
        on_sphere(u, v), on_sphere(u1, v1), attitude, outer, own, np.asarray(trajectory.t, float),
        system.title or system.name,
    )  # fmt: skip


def _frames(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(e_u, e_v, n) of a sphere, as columns."""
    along = on_sphere(u + np.pi / 2, v)
    across = on_sphere(np.pi / 2, v + np.pi / 2)
    return np.stack([along, np.broadcast_to(across, along.shape), on_sphere(u, v)], axis=-1)


def _turns(theta: np.ndarray) -> np.ndarray:
    turns = np.zeros((len(theta), 3, 3))
    turns[:, 0, 0], turns[:, 0, 1] = -np.sin(theta), np.cos(theta)
    turns[:, 1, 0], turns[:, 1, 1] = np.cos(theta), np.sin(theta)
    turns[:, 2, 2] = -1
    return turns


def film(
    rolling: Rolling,
    target: Path,
    frames: int = 160,
    rate: int = 20,
    progress: Callable[[float], None] | None = None,
) -> tuple[Path, ...]:
    """Write a film, and return what was written.

    target
        FILE.gif; FILE.mp4, where the program ffmpeg is installed; or FILE.png, FILE.svg for single
        frames FILE-0001.png and so on.
    frames, rate
        how many, spread evenly over the run, and how many in a second.
    progress
        called with the share that is done.
    """
    from matplotlib import rc_context

    writer = _writer(target, rate)
    with rc_context({**STYLE, "svg.hashsalt": "voronec"}):
        figure, panel = _stage(rolling)
        view = rolling_view(rolling)
        chosen = np.unique(np.linspace(0, len(rolling.times) - 1, frames).astype(int))
        written = [target] if writer else []
        if writer:
            writer.setup(figure, str(target), dpi=100)
        for number, place in enumerate(chosen):
            draw_rolling(panel, rolling, view, int(place))
            if writer:
                writer.grab_frame()
            else:
                written.append(target.with_stem(f"{target.stem}-{number + 1:04d}"))
                figure.savefig(written[-1], metadata=_undated(target))
            if progress:
                progress((number + 1) / len(chosen))
        if writer:
            writer.finish()
    return tuple(written)


def _undated(target: Path) -> dict[str, Any] | None:
    return {"Date": None} if target.suffix == ".svg" else None


def _writer(target: Path, rate: int) -> Any:
    """What puts frames together; None for single ones."""
    from matplotlib import animation

    if target.suffix in (".png", ".svg"):
        return None
    if target.suffix == ".gif":
        return animation.PillowWriter(fps=rate)
    if target.suffix != ".mp4":
        raise DefinitionError(f"'{target}' is no film; write FILE.gif, FILE.mp4, or FILE.png")
    if not animation.FFMpegWriter.isAvailable():
        raise DefinitionError(
            f"'{target}' needs the program ffmpeg, which is not installed; write FILE.gif instead"
        )
    return animation.FFMpegWriter(fps=rate)


def film_strip(rolling: Rolling, instants: Sequence[int], columns: int = 3) -> Any:
    """Some frames side by side as one matplotlib ``Figure``, for print."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    rows = -(-len(instants) // columns)
    with rc_context(STYLE):
        figure = Figure(figsize=(2.15 * columns, 2.35 * rows))
        figure.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, wspace=0, hspace=0)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels:
            panel.set_axis_off()
        view = rolling_view(rolling)
        for panel, place in zip(panels, instants, strict=False):
            draw_rolling(panel, rolling, view, place, width=0.7)
        figure.draw_without_rendering()
    return figure


def _stage(rolling: Rolling) -> tuple[Any, Any]:
    """A square figure with one panel."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.8, 4.8))
    FigureCanvasAgg(figure)
    panel = figure.add_axes((0, 0, 1, 0.95))
    figure.suptitle(rolling.title, fontsize=10, y=0.985)
    return figure, panel
