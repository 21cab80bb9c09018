"""Pictures for print: families of steady motions with their stability and eigenvalues, charts,
families of periodic orbits with their multipliers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.declaration.figure_style import FAINT, INK, MARK, PALE, SOFT, WIDTH, figure_in_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (INK, MARK, "#d98c5f", "#7a5195", SOFT)
"""Of no, one, two, ... unstable eigenvalues."""
STATES = 3
"""So many variables are drawn: those that change most."""


def family_figure(family: Any) -> Figure:
    """Variables over the quantity, unstable motions in other colours; real parts of the eigenvalues
    over it, and the root locus."""
    with figure_in_style(WIDTH, 2.6) as figure:
        left, middle, right = figure.subplots(1, 3)
        _draw_states(left, family)
        x, values = family.values, family.eigenvalues.copy()
        small = 1e-9 * float(np.abs(values).max(initial=0.0))
        values.real[np.abs(values.real) < small] = 0.0
        middle.axhline(0, color=SOFT, linewidth=0.6)
        middle.plot(x, values.real, ".", color=INK, markersize=2)
        for critical in family.critical:
            middle.axvline(critical.value, color=MARK, linewidth=0.7, linestyle="--")
        middle.set(xlabel=_label(family.over), ylabel=r"$\mathrm{Re}\,\lambda$")
        right.axvline(0, color=SOFT, linewidth=0.6)
        colours = (x - x.min()) / (np.ptp(x) or 1.0)
        spread = np.repeat(colours, values.shape[1])
        dots = right.scatter(values.real.ravel(), values.imag.ravel(), c=spread, s=3, vmin=0,
                             vmax=1, cmap="cividis")  # fmt: skip
        bar = figure.colorbar(dots, ax=right, ticks=[0, 1], pad=0.02)
        bar.ax.set_yticklabels(
            [f"{round(float(end), 9):.3g}" for end in (x.min(), x.max())], fontsize=7
        )
        bar.set_label(_label(family.over), labelpad=-8)
        right.set(xlabel=r"$\mathrm{Re}\,\lambda$", ylabel=r"$\mathrm{Im}\,\lambda$")
        if not values.real.any():
            middle.set_ylim(-1, 1)
            right.set_xlim(-1, 1)
        for panel in (left, middle, right):
            panel.tick_params(labelsize=8)
    return figure


def _draw_states(panel: Any, family: Any) -> None:
    points, x = family.points, family.values
    states = [i for i, n in enumerate(family.names) if n != family.over]
    moves = sorted((i for i in states if np.ptp(points[:, i]) > 1e-9), key=lambda i:
                   -float(np.ptp(points[:, i])))[:STATES]  # fmt: skip
    styles = ("-", "--", ":")
    for i, style in zip(moves or states[:1], styles, strict=False):
        for count in sorted(set(family.unstable.tolist())):
            # a piece reaches to the next point, so that the curve has no gaps
            near = family.unstable == count
            near[1:] |= near[:-1].copy()
            panel.plot(x, np.where(near, points[:, i], np.nan), style, linewidth=1.1,
                       color=COLOURS[min(count, 4)])  # fmt: skip
        panel.plot([], [], style, color="black", linewidth=1.1, label=_label(family.names[i]))
    for count in sorted(set(family.unstable.tolist())):
        panel.plot([], [], "s", color=COLOURS[min(count, 4)], label=f"{count} unstable")
    if not moves:
        panel.set_ylim(-1, 1)
    panel.set(xlabel=_label(family.over))
    panel.legend(fontsize=6, frameon=False, handlelength=1.6, labelspacing=0.3)


def orbits_figure(family: Any) -> Figure:
    """Orbits in the plane of the two variables that change most, unstable ones in other colours;
    their periods, and the sizes of their multipliers, over what the family is followed along."""
    with figure_in_style(WIDTH, 2.6) as figure:
        left, middle, right = figure.subplots(1, 3)
        names, x = family.orbits[0].variables, family[family.along]
        spans = sum(np.ptp(orbit.path, axis=0) for orbit in family)
        i, j = sorted(np.argsort(-spans, kind="stable")[:2]) if len(names) > 1 else (0, 0)
        for orbit in family:
            colour = COLOURS[min(orbit.unstable, 4)]
            left.plot(orbit.path[:, i], orbit.path[:, j], color=colour, linewidth=0.7)
        left.set(xlabel=_label(names[i]), ylabel=_label(names[j]))
        middle.plot(x, family["period"], ".-", color=INK, markersize=3, linewidth=0.7)
        middle.set(xlabel=_label(family.along), ylabel="period")
        right.axhline(1, color=SOFT, linewidth=0.6)
        for value, orbit in zip(x, family, strict=True):
            sizes = np.abs(orbit.multipliers)
            right.plot(np.full(len(sizes), value), sizes, ".", color=INK, markersize=3)
        for bifurcation in family.bifurcations:
            right.axvline(bifurcation.value, color=MARK, linewidth=0.7, linestyle="--")
        right.set(xlabel=_label(family.along), ylabel=r"$|\mu|$")
        for panel in (left, middle, right):
            panel.tick_params(labelsize=8)
    return figure


def _label(name: str) -> str:
    import sympy as sp

    return f"${sp.latex(sp.Symbol(name))}$" if name.isidentifier() else name


def chart_figure(chart: Any) -> Figure:
    """A colour for each number of unstable eigenvalues; grey where there is no motion."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    counts = sorted(set(chart.unstable.ravel().tolist()))
    colours = {-1: FAINT, 0: PALE} | dict(enumerate(COLOURS[1:], 1))
    with figure_in_style(0.7 * WIDTH, 3.2) as figure:
        panel = figure.subplots()
        places = np.searchsorted(counts, chart.unstable)
        shades = ListedColormap([colours[min(c, 4)] for c in counts])
        panel.pcolormesh(chart.xs, chart.ys, places, cmap=shades, vmin=-0.5,
                         vmax=len(counts) - 0.5, shading="nearest", rasterized=True)  # fmt: skip
        words = {-1: "no motion", 0: "none unstable"}
        patches = [Patch(color=colours[min(c, 4)], label=words.get(c, f"{c} unstable"))
                   for c in counts]  # fmt: skip
        panel.legend(handles=patches, fontsize=7, loc="upper center", ncols=len(counts),
                     bbox_to_anchor=(0.5, 1.14), frameon=False)  # fmt: skip
        panel.set(xlabel=_label(chart.x), ylabel=_label(chart.y))
        panel.tick_params(labelsize=8)
    return figure
