"""The phase portrait of a quadrature xdot^2 = f(x), with the polynomial f above it.

One constant of the motion is varied and the others are held: each of its values is one level.
Where f has a double root with f > 0 beside it, the level is a separatrix; where f < 0 beside it,
the level is a point, at which x rests.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from voronec.declaration.figure_style import INK, MARK, SOFT, figure_in_style
from voronec.errors import DefinitionError

THIN, BAND = "#7d93ab", "#e7edf4"


@dataclass(frozen=True)
class PhaseLevel:
    """One level of a portrait.

    coefficients
        of f, ascending.
    double
        a double root, where there is one.
    kind
        "motion": the one in question; "separatrix"; "rest", a point; "other".
    place
        of a motion, a value of x on it; the others between other roots are not this motion.
    """

    coefficients: tuple[float, ...]
    kind: str = "other"
    double: float | None = None
    place: float | None = None

    def __call__(self, x: Any) -> np.ndarray:
        """f(x)."""
        values: np.ndarray = np.polynomial.polynomial.polyval(x, self.coefficients)
        return values

    @property
    def roots(self) -> tuple[float, ...]:
        """Real roots between -1 and 1, ascending; a double one once."""
        inner = self.coefficients
        if self.double is not None:
            square = (self.double**2, -2 * self.double, 1.0)
            inner = tuple(np.polynomial.polynomial.polydiv(inner, square)[0])
        found = np.roots(inner[::-1])
        real = [float(r.real) for r in found if abs(r.imag) < 1e-9 and abs(r.real) <= 1 + 1e-9]
        return tuple(sorted({*real, *([] if self.double is None else [self.double])}))

    @property
    def intervals(self) -> tuple[tuple[float, float], ...]:
        """Where f > 0, between neighbouring roots."""
        pairs = zip(self.roots[:-1], self.roots[1:], strict=True)
        return tuple((a, b) for a, b in pairs if self((a + b) / 2) > 0)

    @property
    def own(self) -> tuple[tuple[float, float], ...]:
        """The interval that holds ``place``; all where none is told."""
        if self.place is None:
            return self.intervals
        return tuple((a, b) for a, b in self.intervals if a - 1e-9 <= self.place <= b + 1e-9)


def phase_levels(
    quartic: sp.Expr,
    x: sp.Symbol,
    constant: sp.Symbol,
    value: Any,
    place: float | None = None,
    count: int = 15,
) -> tuple[PhaseLevel, ...]:
    """Levels of f around one value of a constant: those with double roots, and some between.

    quartic
        f, where everything but ``x`` and ``constant`` is a rational number.
    value
        of the constant, for the motion in question.
    place
        a value of x on it, where there may be two intervals.
    count
        of levels beside those that mean something.

    Raises ``DefinitionError`` where other symbols are left, and where there is no motion.
    """
    if quartic.free_symbols - {x, constant}:
        raise DefinitionError(
            f"the quartic {quartic} still holds symbols; put numbers in for all but {x}, {constant}"
        )
    critical = _critical(quartic, x, constant)
    levels = [
        PhaseLevel(_numbers(quartic, x, constant, c), "separatrix" if bend > 0 else "rest", at)
        for c, at, bend in critical
    ]
    marks = [c for c, _, _ in critical]
    marks = sorted({*marks, float(value)})
    reach = (marks[-1] - marks[0]) or abs(marks[0]) or 1.0
    between = np.linspace(marks[0] - 0.5 * reach, marks[-1] + 0.9 * reach, count)
    levels += [PhaseLevel(_numbers(quartic, x, constant, c)) for c in between]
    chosen = PhaseLevel(_numbers(quartic, x, constant, value), "motion", None, place)
    if not chosen.own:
        at = "" if place is None else f" at {x} = {place:g}"
        raise DefinitionError(f"there is no motion with {constant} = {value}{at}: f < 0 there")
    return tuple(level for level in [*levels, chosen] if level.intervals or level.kind == "rest")


def _critical(
    quartic: sp.Expr, x: sp.Symbol, constant: sp.Symbol
) -> list[tuple[float, float, float]]:
    """Values of the constant for which f has a double root in (-1, 1), the root, and f'' there."""
    slope = sp.diff(quartic, x)
    common = sp.resultant(sp.expand(quartic), sp.expand(slope), x)
    found = []
    for c in sp.Poly(common, constant).sqf_part().nroots(n=40, maxsteps=200):
        if abs(sp.im(c)) > 1e-25:
            continue
        here = sp.Poly(slope.subs(constant, sp.re(c)), x).nroots(n=30, maxsteps=200)
        for root in here:
            near = abs(sp.im(root)) < 1e-12 and abs(sp.re(root)) < 1
            if near and abs(quartic.subs({constant: sp.re(c), x: sp.re(root)})) < 1e-15:
                bend = sp.diff(slope, x).subs({constant: sp.re(c), x: sp.re(root)})
                found.append((float(sp.re(c)), float(sp.re(root)), float(bend)))
    return sorted(found)


def _numbers(quartic: sp.Expr, x: sp.Symbol, constant: sp.Symbol, value: Any) -> tuple[float, ...]:
    poly = sp.Poly(quartic.subs(constant, value), x)
    return tuple(float(c) for c in reversed(poly.all_coeffs()))


def phase_figure(levels: Sequence[PhaseLevel], note: str = "") -> Any:
    """A matplotlib ``Figure``: f above, the plane (x, xdot) below, on one axis of x.

    levels
        of ``phase_levels``, or others; f is drawn for the motion and for the separatrices.
    """
    if not levels:
        raise DefinitionError("there is no level to draw")
    with figure_in_style(4.0, 4.5) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1, 1.6))
        _quartics(above, levels)
        order = ("other", "rest", "separatrix", "motion")
        for level in sorted(levels, key=lambda level: order.index(level.kind)):
            _ovals(below, level)
        _frame(below, levels)
        _links(above, below, levels)
        if note:
            figure.supxlabel(note, fontsize=8)
    return figure


LOOK: dict[str, Any] = {
    "other": {"color": THIN, "linewidth": 0.6},
    "separatrix": {"color": MARK, "linewidth": 1.1},
    "motion": {"color": INK, "linewidth": 1.7},
}


def _quartics(panel: Any, levels: Iterable[PhaseLevel]) -> None:
    """f for the motion and the separatrices, its roots, and where it is positive."""
    place = np.linspace(-1, 1, 801)
    tops = [0.0]
    for level in levels:
        if level.kind not in ("motion", "separatrix"):
            continue
        panel.plot(place, level(place), **LOOK[level.kind])
        tops += [float(level(place).max())]
        if level.kind == "motion":
            for a, b in level.own:
                inside = np.linspace(a, b, 201)
                panel.fill_between(inside, level(inside), color=BAND, linewidth=0, zorder=1)
            panel.plot(level.roots, 0 * np.array(level.roots), "o", color=INK, markersize=3.6,
                       zorder=5)  # fmt: skip
        elif level.double is not None:
            panel.plot([level.double], [0], "o", color=MARK, markersize=3.6, zorder=4)
    top = max(tops) or 1.0
    panel.axhline(0, color="#444444", linewidth=0.6)
    panel.set_ylim(-0.6 * top, 1.12 * top)
    panel.set_ylabel("$f(x)$")
    panel.spines[["top", "right"]].set_visible(False)


def _ovals(panel: Any, level: PhaseLevel) -> None:
    """The curves xdot = +-sqrt(f), parametrised so that they are smooth at their ends."""
    if level.kind == "rest":
        panel.plot([level.double], [0], "o", color=INK, markersize=2.6, zorder=5)
        return
    angle = np.linspace(0, np.pi, 91)
    for a, b in level.intervals:
        kind = level.kind if (a, b) in level.own else "other"
        x = (a + b) / 2 - (b - a) / 2 * np.cos(angle)
        rate = np.sqrt(np.maximum(level(x), 0))
        rate[[0, -1]] = 0.0
        panel.plot(
            np.concatenate([x, x[::-1]]), np.concatenate([rate, -rate[::-1]]),
            solid_joinstyle="round", zorder=4 if kind == "motion" else 3, **LOOK[kind],
        )  # fmt: skip
    if level.kind == "separatrix":
        panel.plot([level.double], [0], "o", color=MARK, markersize=3.2, zorder=5)


def _frame(panel: Any, levels: Sequence[PhaseLevel]) -> None:
    """Axes, and the height that shows the separatrices and the motion whole."""
    place = np.linspace(-1, 1, 801)
    weighty = [level for level in levels if level.kind in ("motion", "separatrix")] or levels
    top = max(float(np.sqrt(max(level(place).max(), 0.0))) for level in weighty) or 1.0
    panel.set(xlim=(-1, 1), ylim=(-1.45 * top, 1.45 * top), xlabel="$x$")
    panel.set_xticks((-1, -0.5, 0, 0.5, 1))
    panel.set_ylabel(r"$\dot{x}$")
    panel.axhline(0, color="#444444", linewidth=0.4, zorder=1)
    panel.spines[["top", "right"]].set_visible(False)


def _links(above: Any, below: Any, levels: Iterable[PhaseLevel]) -> None:
    """The roots, carried from one panel to the other; the interval of the motion."""
    from matplotlib.patches import ConnectionPatch

    for level in levels:
        if level.kind != "motion":
            continue
        for root in sorted({r for pair in level.own for r in pair}):
            line = ConnectionPatch(
                (root, 0), (root, 0), above.transData, below.transData, color=SOFT, linewidth=0.6,
                linestyle=(0, (2, 2)), zorder=0.5,
            )  # fmt: skip
            below.figure.add_artist(line)
        for a, b in level.own:
            below.plot([a, b], [0, 0], color=INK, linewidth=2.2, solid_capstyle="butt", zorder=2)
