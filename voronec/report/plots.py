"""Figures for a paper: quantities against the time, and the traces of a contact on spheres.

Figures are made without pyplot, so no window opens and no global state is touched.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.typeset import symbol_latex
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.flow import Trajectory

__all__ = ["plot_sphere_traces", "plot_trajectory", "quantity_label"]

INK, PALE, SOFT, FAINT = "#1b3a5c", "#b4c0cd", "#8a97a6", "#dfe4ea"
MARK, PALE_MARK = "#b3361e", "#e6c2ba"
STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["DejaVu Serif"],
    "mathtext.fontset": "cm",
    "font.size": 9,
    "axes.labelsize": 10,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "axes.formatter.use_mathtext": True,
    "svg.fonttype": "path",
}
WIDTH = 6.4
"""Inches: the text width of a page."""


def quantity_label(trajectory: Trajectory, name: str) -> str:
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
        expr = sp.sympify(name, locals={plain_name(s): s for s in system.known_symbols()})
    except (sp.SympifyError, TypeError, SyntaxError, AttributeError):
        return name
    return f"${sp.latex(expr)}$"


def plot_trajectory(
    trajectory: Trajectory, names: Sequence[str] | None = None, title: str | None = None
) -> Any:
    """Quantities against the time, one panel each, on one time axis.

    ``names`` are what ``trajectory[...]`` understands, by default its outputs.  Returns a
    matplotlib ``Figure``; save it as SVG or PDF for print.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    shown = tuple(trajectory.outputs if names is None else names)
    if not shown:
        raise DefinitionError("there is nothing to plot; name outputs")
    columns = 1 if len(shown) <= 5 else 2
    rows = -(-len(shown) // columns)
    with rc_context(STYLE):
        height = 1.15 if rows < 5 else 0.95
        figure = Figure(figsize=(WIDTH, 0.5 + height * rows), layout="constrained")
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
        figure.draw_without_rendering()  # settles fonts while the style is in force
    return figure


def _curve(panel: Any, trajectory: Trajectory, name: str) -> None:
    from matplotlib.ticker import MaxNLocator

    values = trajectory[name]
    panel.plot(trajectory.t, values, color=INK, linewidth=0.9)
    panel.set_ylabel(quantity_label(trajectory, name))
    panel.margins(x=0)
    panel.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
    panel.spines[["top", "right"]].set_visible(False)
    spread, size = np.ptp(values), np.abs(values).max()
    if spread <= 1e-9 * size or spread == 0:  # a constant is a level line, not magnified rounding
        panel.set_ylim(values[0] - 0.5 * (size or 1.0), values[0] + 0.5 * (size or 1.0))


@dataclass(frozen=True)
class _View:
    """An orthographic look at the unit sphere, from a longitude and a height above the equator."""

    longitude: float
    height: float

    def project(self, colatitude: Any, longitude: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Right, up, and towards the eye, of points on the sphere."""
        u, v = np.broadcast_arrays(np.asarray(colatitude, float), np.asarray(longitude, float))
        point = np.array([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)])
        cos, sin = np.cos(self.longitude), np.sin(self.longitude)
        rise, run = np.sin(self.height), np.cos(self.height)
        right = np.array([-sin, cos, 0.0])
        eye = np.array([run * cos, run * sin, rise])
        return right @ point, np.cross(eye, right) @ point, eye @ point


def plot_sphere_traces(
    traces: Mapping[str, tuple[Any, Any]],
    parallels: bool = True,
    height: float | None = None,
    longitudes: Sequence[float | None] = (),
) -> Any:
    """Curves on spheres side by side, seen from afar; all is vector graphics.

    traces
        title -> (colatitude u, longitude v), arrays in radians; a point is
        (sin u cos v, sin u sin v, cos u), so the pole u = 0 is on top.
    parallels
        whether to draw the two parallels between which each curve runs.
    height
        the eye's angle above the equator, in radians; by default on the side of the curve, and
        the higher the nearer it runs to the pole.
    longitudes
        the eye's longitude for each sphere; None, or nothing, looks at the curve's middle, or near
        its start where it goes around.

    What lies behind the sphere is pale; a dot marks the start (open where it is behind), an arrow
    the end.  Returns a matplotlib ``Figure``.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    if not traces:
        raise DefinitionError("there is no trace to draw; give {title: (colatitude, longitude)}")
    with rc_context(STYLE):
        side = min(3.2, WIDTH / len(traces) + 0.6)
        figure = Figure(figsize=(side * len(traces), side + 0.2), layout="constrained")
        axes = figure.subplots(1, len(traces), squeeze=False)[0]
        eyes = (*longitudes, *[None] * len(traces))
        for axis, (title, trace), eye in zip(axes, traces.items(), eyes, strict=False):
            u, v = _trace(title, *trace)
            rise = _rise(u) if height is None else height
            view = _View(_towards(v) if eye is None else eye, rise)
            _sphere(axis, view)
            if parallels:
                _limits(axis, view, u)
            _path(axis, view, u, v)
            axis.set_title(title, fontsize=10, pad=4)
        figure.draw_without_rendering()
    return figure


def _towards(v: np.ndarray) -> float:
    """The longitude from which a curve is best seen."""
    if np.ptp(v) < 0.8 * np.pi:
        return float((v.min() + v.max()) / 2)
    return float(v[0] + 0.7 * np.sign(v[-1] - v[0]))


def _rise(u: np.ndarray) -> float:
    """The height from which a curve is best seen."""
    latitude = float(np.cos(u).mean())
    return (0.25 + 0.6 * abs(latitude)) * (1.0 if latitude > -0.1 else -1.0)


def _trace(title: str, colatitude: Any, longitude: Any) -> tuple[np.ndarray, np.ndarray]:
    u, v = np.asarray(colatitude, dtype=float), np.asarray(longitude, dtype=float)
    if u.ndim != 1 or u.shape != v.shape or len(u) < 2:
        raise DefinitionError(f"the trace '{title}' needs two arrays of one length, two or more")
    if not (np.isfinite(u).all() and np.isfinite(v).all()):
        raise DefinitionError(f"the trace '{title}' holds values that are not finite")
    return _refined(u, v)


def _refined(u: np.ndarray, v: np.ndarray, largest: float = 0.04) -> tuple[np.ndarray, np.ndarray]:
    """Points in between, where a step on the sphere is long enough to show its corners."""
    from scipy.interpolate import CubicSpline

    steps = np.hypot(np.diff(u), np.diff(v))
    parts = np.maximum(1, np.minimum(200, np.ceil(steps / largest))).astype(int)
    place = np.arange(len(u), dtype=float)
    fine = np.concatenate([*(i + np.arange(k) / k for i, k in enumerate(parts)), place[-1:]])
    return CubicSpline(place, u)(fine), CubicSpline(place, v)(fine)


def _sphere(axis: Any, view: _View) -> None:
    """The outline, meridians and parallels of a globe, hardly visible."""
    from matplotlib.patches import Circle

    axis.set_aspect("equal")
    axis.set_axis_off()
    axis.set_xlim(-1.06, 1.06)
    axis.set_ylim(-1.06, 1.06)
    axis.add_patch(Circle((0, 0), 1, facecolor="#fbfcfd", edgecolor=SOFT, linewidth=0.8))
    turn = np.linspace(0, 2 * np.pi, 361)
    arc = np.linspace(0, np.pi, 181)
    for longitude in np.arange(0, 2 * np.pi, np.pi / 6):
        _front(axis, view.project(arc, view.longitude + longitude), FAINT, 0.45)
    for colatitude in np.arange(1, 6) * np.pi / 6:
        _front(axis, view.project(colatitude, turn), FAINT, 0.45)


def _limits(axis: Any, view: _View, u: np.ndarray) -> None:
    """The parallels at the least and the greatest colatitude."""
    turn = view.longitude + np.linspace(-np.pi, np.pi, 721)
    for colatitude in {float(u.min()), float(u.max())}:
        points = view.project(colatitude, turn)
        _back(axis, points, PALE_MARK, 0.6, dashes=(0, (5, 2.5)))
        _front(axis, points, MARK, 0.7, dashes=(0, (5, 2.5)))


def _path(axis: Any, view: _View, u: np.ndarray, v: np.ndarray) -> None:
    points = view.project(u, v)
    _back(axis, points, PALE, 0.6)
    _front(axis, points, INK, 0.95)
    x, y, depth = points
    _arrow(axis, points)
    visible = depth[0] >= 0
    axis.plot(x[:1], y[:1], "o", color=MARK if visible else "white", markeredgecolor=MARK,
              markersize=4, zorder=5)  # fmt: skip


def _arrow(axis: Any, points: tuple[np.ndarray, ...]) -> None:
    """The sense of the motion, at the end of the curve."""
    x, y, depth = points
    color = INK if depth[-1] >= 0 else SOFT
    axis.annotate(
        "", (x[-1], y[-1]), (x[-2], y[-2]), zorder=4,
        arrowprops={"arrowstyle": "-|>", "color": color, "linewidth": 0.9, "shrinkA": 0,
                    "shrinkB": 0, "mutation_scale": 8},
    )  # fmt: skip


def _front(axis: Any, points: Iterable[Any], color: str, width: float, dashes: Any = "-") -> None:
    x, y, depth = points
    _part(axis, x, y, depth >= 0, color=color, linewidth=width, linestyle=dashes, zorder=3)


def _back(axis: Any, points: Iterable[Any], color: str, width: float, dashes: Any = "-") -> None:
    x, y, depth = points
    _part(axis, x, y, depth < 0, color=color, linewidth=width, linestyle=dashes, zorder=2)


def _part(axis: Any, x: np.ndarray, y: np.ndarray, kept: np.ndarray, **style: Any) -> None:
    """A line with gaps where it is not kept."""
    if kept.any():
        gap = np.where(kept, 0.0, np.nan)
        axis.plot(x + gap, y + gap, solid_joinstyle="round", **style)
