"""Traces of a contact on spheres, for print: vector graphics, made of smooth arcs throughout.

What lies behind a sphere is pale, its parallels there dashed; both limiting parallels, the poles
and the axis, the start and the sense of the motion are marked.  Points that do not tell the curve
between them are shown as points, joined by shortest ways.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed.pictures.sphere_curves import (
    FINE,
    Arcs,
    View,
    best_view,
    great_arcs,
    is_resolved,
    meridian,
    on_sphere,
    parallel,
    smooth_arcs,
)
from voronec.declaration.figure_style import INK, MARK, NO_SPACE, PALE, SOFT, figure_in_style
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.closed import ClosedForm

DENSE = 600
"""Points for each period, of which the picture keeps what it needs."""
FEW, FEWEST, MOST = 3, 5, 16
"""Periods that are drawn: of slow waves, and otherwise."""
SLOW = 0.06
"""A drift in one period below which waves nearly lie on each other."""


def motion_traces(
    closed: ClosedForm,
    titles: Mapping[str, str] | None = None,
    notes: Mapping[str, str] | None = None,
    periods: float | None = None,
    span: float = 20.0,
) -> tuple[SphereTrace, ...]:
    """One ``SphereTrace`` for each declared trace.

    titles, notes
        the name of a trace's longitude -> words above and below it.
    periods
        how much is drawn; by default ``shown_periods``.
    span
        the time that is drawn of a motion without a period.
    """
    traces = []
    for number, trace in enumerate(closed.quadratures.traces):
        u, v = plain_name(trace.colatitude), plain_name(trace.longitude)
        times = _times(closed, shown_periods(closed, v) if periods is None else periods, span)
        values = closed.at(times, (u, v))
        axis = r"$\mathbf{z}$" if number == 0 else rf"$\mathbf{{z}}_{number}$"
        traces.append(SphereTrace(
            values[u], values[v], times, title=(titles or {}).get(v, ""),
            note=(notes or {}).get(v, ""), axis=axis,
        ))  # fmt: skip
    return tuple(traces)


def _times(closed: ClosedForm, periods: float, span: float) -> np.ndarray:
    if not np.isfinite(closed.period):
        return np.linspace(0.0, span, 8 * DENSE + 1)
    return np.linspace(0.0, periods * closed.period, int(DENSE * periods) + 1)


def shown_periods(closed: ClosedForm, longitude: str) -> int:
    """How many periods show what a trace is: all of a closed curve, or about one turn.

    Where the waves nearly lie on each other, more of them would only make a blot.
    """
    turn = closed.turns.get(longitude)
    if turn is None:
        return FEWEST
    if turn.fraction is not None and turn.fraction.denominator <= MOST:
        return int(turn.fraction.denominator)
    if abs(turn.advance) < SLOW:
        return FEW
    return int(np.clip(np.ceil(0.9 * 2 * np.pi / abs(turn.advance)), FEWEST, MOST))


GRID, PALE_MARK = "#e9edf1", "#dcaa9e"


@dataclass(frozen=True)
class SphereTrace:
    """A curve on a sphere, and what a picture says of it.

    colatitude, longitude
        arrays of one length, in radians: the point is (sin u cos v, sin u sin v, cos u).  Where
        they tell the curve, a few hundred for each wave, they are joined smoothly and thinned out.
    times
        the times of these points where their steps are not equal.
    limits
        the colatitudes of the two parallels between which the curve runs; its extremes unless told,
        none where it is empty.
    title, note, axis
        the words above, the small ones below, and the name of the axis or nothing, as mathtext.
    view
        from where it is seen; the best view unless told.
    """

    colatitude: Any
    longitude: Any
    times: Any = None
    limits: Sequence[float] | None = None
    title: str = ""
    note: str = ""
    axis: str = r"$\mathbf{z}$"
    view: View | None = None
    points: np.ndarray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        u, v = np.asarray(self.colatitude, float), np.asarray(self.longitude, float)
        what = f"the trace '{self.title}'"
        if u.ndim != 1 or u.shape != v.shape or len(u) < 2:
            raise DefinitionError(f"{what} needs two arrays of one length, two or more")
        if not (np.isfinite(u).all() and np.isfinite(v).all()):
            raise DefinitionError(f"{what} holds values that are not finite")
        object.__setattr__(self, "points", on_sphere(u, v))

    @property
    def parallels(self) -> tuple[float, ...]:
        """The colatitudes of the limiting parallels, each once."""
        if self.limits is not None:
            return tuple(dict.fromkeys(float(c) for c in self.limits))
        u = np.arccos(np.clip(self.points[:, 2], -1, 1))
        return tuple(dict.fromkeys((float(u.min()), float(u.max()))))


def traces_figure(
    traces: Sequence[SphereTrace], title: str = "", columns: int = 0, side: float = 3.1
) -> Any:
    """A matplotlib ``Figure`` of curves on spheres, row by row.

    traces
        ``SphereTrace``, one sphere each.
    title
        above them all.
    columns, side
        spheres in a row (all of them, at most four, unless told), and the width of each in inches.
    """
    if not traces:
        raise DefinitionError("there is no trace to draw")
    columns = columns or min(len(traces), 4)
    rows = -(-len(traces) // columns)
    noted = any(t.note for t in traces)
    height = rows * (side + (0.34 if noted else 0.16)) + (0.3 if title else 0.0)
    with figure_in_style(columns * side, height) as figure:
        figure.get_layout_engine().set(**NO_SPACE)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for axis in axes:
            axis.set_axis_off()
        for axis, trace in zip(axes, traces, strict=False):
            _draw_sphere(axis, trace, scale=side / 3.1)
        if title:
            figure.suptitle(title, fontsize=11 * (side / 3.1) ** 0.25)
    return figure


def _draw_sphere(axis: Any, trace: SphereTrace, scale: float = 1.0) -> None:
    """One curve on its sphere in matplotlib axes; ``scale`` is of the line widths."""
    view = trace.view or best_view(trace.points)
    _globe(axis, view, trace.axis, scale)
    for colatitude in trace.parallels:
        if np.sin(colatitude) > 1e-9:
            ring = parallel(colatitude, view.longitude).project(view)
            _arcs(axis, ring, MARK, PALE_MARK, 0.65 * scale, dashed=True)
    told = is_resolved(trace.points, trace.times)
    curve = smooth_arcs(trace.points, trace.times, FINE / scale**3) if told else (
        great_arcs(trace.points)
    )  # fmt: skip
    curve = curve.project(view)
    _arcs(axis, curve, INK, PALE, (1.0 if told else 0.5) * scale)
    if not told:
        _dots(axis, view.project(trace.points), scale)
    _arrow(axis, curve, scale)
    _start(axis, curve.handles[0, 0], scale)
    axis.set_title(trace.title, fontsize=10 * scale**0.25, pad=3)
    if trace.note:
        axis.text(0, -1.1, trace.note, ha="center", va="top", fontsize=8 * scale**0.25)


def _globe(axis: Any, view: View, name: str, scale: float) -> None:
    """The outline, a faint net, the poles, and the axis where it leaves the sphere."""
    from matplotlib.patches import Circle

    axis.set(aspect="equal", xlim=(-1.05, 1.05), ylim=(-1.12, 1.26))
    axis.add_patch(Circle((0, 0), 1, facecolor="white", linewidth=0, zorder=1))
    axis.add_patch(Circle((0, 0), 1, fill=False, edgecolor="#5d6b7a", linewidth=0.8 * scale,
                          zorder=2.5))  # fmt: skip
    for longitude in np.arange(12) * np.pi / 6:
        _arcs(axis, meridian(view.longitude + longitude).project(view), GRID, None, 0.5, order=1)
    for colatitude in np.arange(1, 6) * np.pi / 6:
        _arcs(axis, parallel(colatitude).project(view), GRID, None, 0.5, order=1)
    top, bottom = view.project([[0, 0, 1.24], [0, 0, -1.1]])
    shown = view.height > 0 or top[1] > 1 or not name
    _axis(axis, view.project([0, 0, 1]), top, name, scale)
    _axis(axis, view.project([0, 0, -1]), bottom, "" if shown else f"$-{name[1:]}", scale)


def _axis(axis: Any, pole: np.ndarray, tip: np.ndarray, name: str, scale: float) -> None:
    """The piece of the axis outside the sphere at one pole; behind, only what passes the rim."""
    front = pole[2] >= 0
    if not front and abs(tip[1]) <= 1:
        return
    foot = pole[1] if front else np.copysign(1.0, tip[1])
    axis.plot([0, 0], [foot, tip[1]], color=SOFT, linewidth=0.8 * scale, zorder=2.6)
    if front:
        axis.plot([0], [pole[1]], "o", color=SOFT, markersize=2.2 * scale, markeredgewidth=0,
                  zorder=2.6)  # fmt: skip
    axis.text(0.035, tip[1] - 0.01, name, fontsize=8.5 * scale**0.25, va="center", color="#5d6b7a",
              zorder=2.6)  # fmt: skip


def _arcs(
    axis: Any, arcs: Arcs, front: str, back: str | None, width: float, dashed: bool = False,
    order: int = 2,
) -> None:  # fmt: skip
    """What is in front in one colour, what is behind in another, thinner, or not at all."""
    from matplotlib.patches import PathPatch

    pieces = arcs.parts()
    for seen, colour, share in ((False, back, 0.8), (True, front, 1.0)):
        chosen = [piece.handles for piece, side in pieces if side is seen]
        if not chosen or colour is None:
            continue
        hidden = dashed and not seen
        axis.add_patch(PathPatch(
            _path(chosen), fill=False, edgecolor=colour, linewidth=share * width,
            linestyle=(0, (4, 3)) if hidden else "-", capstyle="butt" if hidden else "round",
            joinstyle="round", zorder=order + seen,
        ))  # fmt: skip


def _path(chain: Iterable[np.ndarray]) -> Any:
    """One matplotlib path of several chains of arcs."""
    from matplotlib.path import Path

    points, codes = [], []
    for handles in chain:
        points += [handles[0, :1, :2], handles[:, 1:, :2].reshape(-1, 2)]
        codes += [Path.MOVETO, *[Path.CURVE4] * (3 * len(handles))]
    return Path(np.concatenate(points), codes)


def _arrow(axis: Any, curve: Arcs, scale: float) -> None:
    """An arrowhead where the sense of the motion is seen well, and one at the end if in front."""
    size = 0.06 * scale**-0.4
    for place, heading in _arrow_places(curve):
        across = np.array([-heading[1], heading[0]])
        tip, foot = place + 0.5 * size * heading, place - 0.5 * size * heading
        corners = [tip, foot - 0.4 * size * across, foot + 0.4 * size * across]
        axis.fill(*np.transpose(corners), color=INK, linewidth=0, zorder=4)


def _arrow_places(curve: Arcs) -> list[tuple[np.ndarray, np.ndarray]]:
    """Points and directions: early on the curve, in front and where it runs straight; the end."""
    arcs = curve.handles
    middle = np.tensordot(arcs, [1, 3, 3, 1], axes=(1, 0)) / 8
    heading = arcs[:, 3] + arcs[:, 2] - arcs[:, 1] - arcs[:, 0]
    size = np.linalg.norm(heading, axis=1)
    chord = np.linalg.norm(arcs[:, 3] - arcs[:, 0], axis=1)
    gone = np.cumsum(chord)
    early = (gone > 0.15) & (gone < max(2.0, 0.3 * gone[-1]))
    straight = chord / np.maximum(np.linalg.norm(np.diff(arcs, axis=1), axis=2).sum(axis=1), 1e-12)
    across = np.linalg.norm(heading[:, :2], axis=1) / np.maximum(size, 1e-12)
    merit = np.where(early, middle[:, 2] + 20 * (straight - 1) + across, -np.inf)
    best = int(np.argmax(merit))
    arrows = [(middle[best, :2], heading[best, :2])] if merit[best] > 0.8 else []
    last = arcs[-1, 3] - arcs[-1, 2]
    if arcs[-1, 3, 2] > 0.1 and np.linalg.norm(last[:2]) > 1e-6:
        arrows.append((arcs[-1, 3, :2], last[:2]))
    return [(place, way / np.linalg.norm(way)) for place, way in arrows]


def _dots(axis: Any, places: np.ndarray, scale: float) -> None:
    """Points whose curve is not known."""
    for front, colour in ((False, PALE), (True, INK)):
        x, y, _ = places[(places[:, 2] >= 0) == front].T
        axis.plot(x, y, "o", color=colour, markersize=2.4 * scale, markeredgewidth=0,
                  zorder=3.5 if front else 2.5)  # fmt: skip


def _start(axis: Any, place: np.ndarray, scale: float) -> None:
    axis.plot(
        place[:1], place[1:2], "o", color=MARK if place[2] >= 0 else "white",
        markeredgecolor=MARK, markeredgewidth=0.7, markersize=4 * scale**0.7, zorder=5,
    )  # fmt: skip
