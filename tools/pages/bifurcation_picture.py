"""The bifurcation set of a quadrature xdot^2 = f(x), drawn in the plane of two constants.

On its curves f has a double root in the range of x, and x may rest; between them the plane is
shaded by how many intervals of x there are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from voronec.declaration.figure_style import INK, MARK, figure_in_style
from voronec.errors import DefinitionError

if TYPE_CHECKING:
    from voronec.closed.special.bifurcation import BifurcationSet

ONE, TWO, POLE = "#eaf0f6", "#c3d4e4", "#2f7d5b"
Window = tuple[tuple[float, float], tuple[float, float]]


def _window(one: BifurcationSet) -> Window:
    """What shows the unstable curves and the single points, with as much around them."""
    loose = [c.points for c in one.curves if not c.stable]
    core = [*loose, *[np.array([p.point]) for p in one.points]]
    every = np.concatenate([c.points for c in one.curves])
    if not loose:
        core += [np.quantile(every, [0.1, 0.6], axis=0)]
    shown = np.concatenate(core)
    left, right = shown[:, 0].min(), shown[:, 0].max()
    left, right = left - 0.3 * (right - left), right + 0.3 * (right - left)
    inside = every[(every[:, 0] > left) & (every[:, 0] < right), 1]
    low, high = min(shown[:, 1].min(), inside.min()), shown[:, 1].max()
    tall = (high - low) or 1.0
    return (float(left), float(right)), (float(low - 0.06 * tall), float(high + 0.2 * tall))


def levels_of(one: BifurcationSet, grid: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For values of the first constant, what the second must be for one and for two intervals.

    f is linear in the second constant and grows with it, so there is a motion at x where it is at
    least U(x) with f = 0: from the least U on there is one, and two from the second hollow of U up
    to the ridge between them (nan where there is no ridge).
    """
    across, up = one.plane
    f = sp.expand(one.quartic)
    if sp.degree(f, up) != 1:
        raise DefinitionError(f"the quartic is not linear in {up}; put such a constant second")
    height = sp.cancel(-f.subs(up, 0) / sp.diff(f, up))
    place = -np.cos(np.linspace(0.0, np.pi, 1603))[1:-1]
    value = sp.lambdify((one.variable, across), height, "numpy")(place[None, :], grid[:, None])
    least = value.min(axis=1)
    second, ridge = np.full_like(grid, np.nan), np.full_like(grid, np.nan)
    inner = value[:, 1:-1]
    top = (inner > value[:, :-2]) & (inner >= value[:, 2:])
    for i in np.flatnonzero(top.any(axis=1)):
        peak = 1 + int(np.argmax(np.where(top[i], inner[i], -np.inf)))
        second[i] = max(value[i, :peak].min(), value[i, peak:].min())
        ridge[i] = value[i, peak]
    return least, second, ridge


def bifurcation_figure(
    sets: Mapping[str, BifurcationSet],
    labels: tuple[str, str] | None = None,
    poles: Mapping[str, Mapping[str, float]] | None = None,
    windows: Mapping[str, Window] | None = None,
    note: str = "",
) -> Any:
    """A matplotlib ``Figure``, one panel for each set.

    sets
        title of a panel -> set; the quartic is linear in the second constant of its plane.
    labels
        of the two axes, as mathtext; the names of the constants unless told.
    poles
        title -> {name: value of the first constant for which traces pass through a pole}.
    windows
        title -> ((left, right), (low, high)).
    note
        small words above the legend.
    """
    if not sets:
        raise DefinitionError("there is no bifurcation set to draw")
    with figure_in_style(0.4 + 2.1 * len(sets), 3.4) as figure:
        panels = figure.subplots(1, len(sets), squeeze=False)[0]
        for panel, (name, one) in zip(panels, sets.items(), strict=True):
            window = (windows or {}).get(name) or _window(one)
            _panel(panel, one, window)
            _poles(panel, (poles or {}).get(name, {}), window)
            across, up = labels or (f"${one.plane[0]}$", f"${one.plane[1]}$")
            panel.set_title(name, fontsize=9)
            panel.set_xlabel(across)
            if panel is panels[0]:
                panel.set_ylabel(up)
        _legend(figure, bool(poles), note)
    return figure


def _panel(panel: Any, one: BifurcationSet, window: Window) -> None:
    (left, right), (low, high) = window
    grid = np.linspace(left, right, 240)
    least, second, ridge = levels_of(one, grid)
    panel.fill_between(grid, least, high, where=least < high, color=ONE, linewidth=0, zorder=1)
    panel.fill_between(grid, second, ridge, where=np.isfinite(ridge), color=TWO, linewidth=0,
                       zorder=1.5)  # fmt: skip
    for curve in one.curves:
        style: Any = (
            {"color": INK, "linewidth": 1.1, "zorder": 4} if curve.stable
            else {"color": MARK, "linewidth": 1.0, "linestyle": (0, (5, 2)), "zorder": 3}
        )  # fmt: skip
        panel.plot(*curve.points.T, **style)
    for point in one.points:
        colour = INK if point.stable else MARK
        panel.plot(*point.point, "o", color=colour if point.stable else "white", markersize=4,
                   markeredgecolor=colour, markeredgewidth=0.9, zorder=5)  # fmt: skip
    panel.set(xlim=(left, right), ylim=(low, high))


def _poles(panel: Any, poles: Mapping[str, float], window: Window) -> None:
    (left, right), (_, high) = window
    for name, place in poles.items():
        if left < place < right:
            panel.axvline(place, color=POLE, linewidth=0.7, linestyle=(0, (1, 1.5)), zorder=2)
            panel.annotate(name, (place, high), (0, -3), textcoords="offset points", rotation=90,
                           ha="right", va="top", fontsize=7.5, color=POLE)  # fmt: skip


def _legend(figure: Any, poles: bool, note: str) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    keys: list[Any] = [
        Patch(color=ONE, linewidth=0, label="one interval of $x$"),
        Patch(color=TWO, linewidth=0, label="two"),
        Line2D([], [], color=INK, linewidth=1.1, label="stable precessions"),
        Line2D([], [], color=MARK, linewidth=1, linestyle=(0, (5, 2)), label="unstable"),
    ]
    keys.append(Line2D([], [], color=INK, marker="o", markersize=4, linewidth=0,
                       label="single motions (open: unstable)"))  # fmt: skip
    if poles:
        keys.append(Line2D([], [], color=POLE, linewidth=0.7, linestyle=(0, (1, 1.5)),
                           label="through a pole"))  # fmt: skip
    figure.legend(handles=keys, loc="outside lower center", ncols=3, frameon=False,
                  fontsize=8, title=note or None, title_fontsize=8)  # fmt: skip
