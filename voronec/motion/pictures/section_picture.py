"""The picture of a Poincare section: one dot for each crossing, one colour for each motion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.algebra.text import read_sympy_text
from voronec.algebra.typeset import symbol_latex
from voronec.declaration.figure_style import INK, MARK, SOFT, figure_in_style
from voronec.errors import DefinitionError

COLOURS = (
    INK, MARK, "#2f7d5b", "#8a5aa8", "#b8860b", "#3b8ea5", "#a0522d", "#6b7a1f", "#9b3d6a",
    "#4f5d95",
)  # fmt: skip
"""Dark enough for dots on white, and told apart in print."""


def plot_section(section: Any) -> Any:
    """A matplotlib ``Figure`` of a ``Section``: the first two outputs against each other.

    Where there is only one output, it is drawn against the same output at the crossing before, the
    map of returns.
    """
    x, y, labels = _axes(section)
    starts = np.unique(section.start)
    size = float(np.clip(120.0 / np.sqrt(max(len(section), 1)), 1.0, 4.0))
    with figure_in_style(5.6, 5.2) as figure:
        panel = figure.subplots()
        for k, start in enumerate(starts):
            mine = section.start == start
            panel.plot(
                x[mine], y[mine], ".", color=COLOURS[k % len(COLOURS)], markersize=size,
                markeredgewidth=0, rasterized=len(section) > 20_000,
            )  # fmt: skip
        panel.set(xlabel=labels[0], ylabel=labels[1])
        panel.margins(0.04)
        panel.spines[["top", "right"]].set_visible(False)
        panel.set_title(_title(section), fontsize=10)
    return figure


def plot_levels(
    sections: Sequence[Any], values: Sequence[np.ndarray], reflections: Sequence[tuple[int, int]]
) -> Any:
    """A panel for each section: the motions in colours by rotation numbers, grey where there is
    none, with the images of all points under ``reflections`` of the first two outputs, and the
    lines that these fix."""
    known = np.concatenate(values)
    known = known[np.isfinite(known)]
    low, high = (known.min(), known.max()) if len(known) else (0.0, 1.0)
    shape = {"squeeze": False, "sharex": True, "sharey": True}
    with figure_in_style(1.4 + 4.2 * len(sections), 4.4) as figure:
        panels = figure.subplots(1, len(sections), **shape)[0]
        for panel, section, numbers in zip(panels, sections, values, strict=True):
            x, y, labels = _axes(section)
            each = np.asarray(numbers)[section.start]
            size = float(np.clip(800.0 / max(len(section), 1) ** 0.5, 1.0, 9.0))
            none, style = ~np.isfinite(each), {"s": size, "linewidths": 0, "rasterized": True}
            for a, b in [(1, 1), *reflections]:
                panel.scatter(a * x[none], b * y[none], color=SOFT, **style)
                dots = panel.scatter(a * x[~none], b * y[~none], c=each[~none], cmap="viridis",
                                     vmin=low, vmax=high, **style)  # fmt: skip
            for first, second in reflections:
                if first * second < 0:
                    line = panel.axvline if first < 0 else panel.axhline
                    line(0, color=MARK, linewidth=0.7, linestyle="--")
            panel.set(xlabel=labels[0], ylabel=labels[1])
            panel.margins(0.04)
            panel.spines[["top", "right"]].set_visible(False)
            panel.set_title(_title(section), fontsize=9)
        figure.colorbar(dots, ax=panels, label="rotation number", pad=0.02)
    return figure


def _axes(section: Any) -> tuple[np.ndarray, np.ndarray, tuple[str, str]]:
    if not section.outputs:
        raise DefinitionError("a section without outputs has no picture; name one or two")
    names = [_label(section, name) for name in section.outputs[:2]]
    if len(names) == 2:
        return section.points[:, 0], section.points[:, 1], (names[0], names[1])
    x = section.points[:, 0]
    before, after = x.copy(), np.full_like(x, np.nan)
    after[:-1] = np.where(section.start[1:] == section.start[:-1], x[1:], np.nan)
    return before, after, (f"{names[0]}", f"{names[0]} at the next crossing")


def _label(section: Any, name: str) -> str:
    """The mathtext of a quantity's name; words, such as an integral's, stay words."""
    system = section.system
    things = {plain_name(x): x for x in system.known_symbols()}
    if name.removesuffix("dot") in things and name not in map(plain_name, system.velocities):
        letter = symbol_latex(name.removesuffix("dot"))
        return rf"$\dot{{{letter}}}$" if name.endswith("dot") else f"${letter}$"
    if name in things or name in system.invariants:
        return f"${symbol_latex(name)}$"
    if name in system.integrals:
        return name
    try:
        meant = dict(things) | {g: sp.Symbol(g) for g in system.invariants}
        return f"${sp.latex(read_sympy_text(name, 'a label', meant))}$"
    except DefinitionError:
        return name


def _title(section: Any) -> str:
    way = {1: ", growing", -1: ", falling", 0: ""}[section.direction]
    name = section.system.title or section.system.name
    return f"{name}: {_label(section, section.plane)} = {section.value:g}{way}"
