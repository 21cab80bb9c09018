"""Sketches of mechanisms: what is drawn is declared, stroke by stroke, and drawn when asked for.

A sketch is schematic: it names coordinates, and says where they are measured.  Lengths are those of
the drawing, x to the right and y upwards; angles are in degrees, counted from the x-axis.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import atan2, cos, degrees, isfinite, radians, sin
from types import MappingProxyType
from typing import Any

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.algebra.typeset import symbol_latex
from voronec.declaration.figure_style import INK, MARK, SOFT
from voronec.errors import DefinitionError

Point = tuple[float, float]

FILL = "#e8edf2"
STYLE: Any = {"mathtext.fontset": "cm", "font.family": "serif", "font.size": 10}
LOOKS: Mapping[str, Mapping[str, Any]] = {
    "outline": {"color": INK, "lw": 1.3},
    "thin": {"color": SOFT, "lw": 0.8},
    "dashed": {"color": SOFT, "lw": 0.8, "ls": (0, (4, 3))},
    "heavy": {"color": INK, "lw": 3.2, "solid_capstyle": "butt"},
}
INCHES = 0.85
"""Of a unit of length, so that labels are as large in every sketch."""
NUDGE, LETTER = 0.17, 0.055
"""How far above its stroke a label stands; half the width of a letter."""


def polar(at: Point, radius: float, angle: float) -> Point:
    """The point at a distance and an angle from another."""
    return at[0] + radius * cos(radians(angle)), at[1] + radius * sin(radians(angle))


@dataclass(frozen=True)
class Stroke:
    """One stroke: its kind, a row of the table of drawers; points; numbers; a label in LaTeX."""

    kind: str
    points: tuple[Point, ...]
    numbers: tuple[float, ...] = ()
    label: str = ""
    look: str = ""


@dataclass(frozen=True, repr=False)
class Sketch:
    """A picture of a mechanism, with its coordinates named.

    Every method returns the sketch with one thing more.  A label is a symbol, its name, or several
    joined as text: ``"(x, y)"``; anything else raises ``DefinitionError``.  ``view`` says from
    where one looks; ``names`` are those that stand in labels.  Points are pairs (x, y) in units of
    the drawing, angles in degrees.
    """

    view: str = ""
    strokes: tuple[Stroke, ...] = ()
    names: frozenset[str] = frozenset()

    def _with(
        self,
        kind: str,
        points: Sequence[Point],
        label: Any = "",
        numbers: Sequence[float] = (),
        look: str = "",
    ) -> Sketch:
        text = plain_name(label) if is_symbolic_name(label) else label
        if not isinstance(text, str):
            raise DefinitionError(f"the label {text!r} of a sketch is no text; write it in quotes")
        words = re.findall(r"[A-Za-z_]\w*", text)
        stroke = Stroke(kind, tuple(points), tuple(numbers), _typeset(text), look)
        return Sketch(self.view, (*self.strokes, stroke), self.names | {*words})

    def __repr__(self) -> str:
        return f"Sketch({self.view!r}, {len(self.strokes)} strokes)"

    def line(self, *points: Point, look: str = "outline") -> Sketch:
        """A line through points; looks are ``outline``, ``thin``, ``dashed`` and ``heavy``."""
        return self._with("line", points, look=look)

    def area(self, *points: Point) -> Sketch:
        """A body, by the corners of its outline."""
        return self._with("area", points)

    def ellipse(self, at: Point, width: float, height: float, angle: float = 0) -> Sketch:
        """A filled ellipse with these half-axes, turned by an angle."""
        return self._with("ellipse", (at,), numbers=(width, height, angle))

    def ring(self, at: Point, width: float, height: float, angle: float = 0) -> Sketch:
        """The dashed outline of an ellipse: a parallel on a ball, a hidden edge."""
        return self._with("ring", (at,), numbers=(width, height, angle))

    def dot(self, at: Point, label: Any = "", side: float = 45) -> Sketch:
        """A point, with its label in the direction ``side``."""
        return self._with("dot", (at,), label, (side,))

    def text(self, at: Point, label: Any) -> Sketch:
        """A label alone."""
        return self._with("text", (at,), label)

    def arrow(self, start: Point, end: Point, label: Any = "") -> Sketch:
        """A vector, with its label beyond the head."""
        return self._with("arrow", (start, end), label)

    def angle(self, at: Point, radius: float, start: float, end: float, label: Any = "") -> Sketch:
        """An angle about a point, from one direction to another."""
        return self._with("angle", (at,), label, (radius, start, end))

    def turn(self, at: Point, axis: float, radius: float, label: Any = "") -> Sketch:
        """A turn about an axis in the plane of the drawing, in the direction ``axis``."""
        return self._with("turn", (at,), label, (axis, radius))

    def distance(self, start: Point, end: Point, label: Any, offset: float = 0.25) -> Sketch:
        """A length between two points, drawn at an offset to their left."""
        if tuple(start) == tuple(end):
            raise DefinitionError(
                f"a distance from {start} to itself is not drawn; give two points"
            )
        return self._with("distance", (start, end), label, (offset,))

    def axes(self, x: Any, y: Any, at: Point = (0.0, 0.0), size: float = 1.0) -> Sketch:
        """Axes fixed in space."""
        one = self.arrow(at, (at[0] + size, at[1]), x)
        return one.arrow(at, (at[0], at[1] + size), y)

    def box(self, at: Point, length: float, width: float, angle: float) -> Sketch:
        """A body with corners, by its middle."""
        ahead, aside = polar((0, 0), length / 2, angle), polar((0, 0), width / 2, angle + 90)
        corners = [
            (at[0] + i * ahead[0] + j * aside[0], at[1] + i * ahead[1] + j * aside[1])
            for i, j in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]
        return self.area(*corners)

    def wheel(self, at: Point, angle: float, size: float = 0.5) -> Sketch:
        """A wheel or a blade seen from above."""
        return self.line(polar(at, -size / 2, angle), polar(at, size / 2, angle), look="heavy")

    def figure(self) -> Any:
        """The picture, as a matplotlib ``Figure``."""
        import matplotlib as mpl
        from matplotlib.figure import Figure

        with mpl.rc_context(STYLE):
            figure = Figure(figsize=(4.4, 3.3), layout="constrained")
            axes: Any = figure.add_subplot()
            axes.set_axis_off()
            axes.set_aspect("equal")
            for stroke in self.strokes:
                DRAWERS[stroke.kind](axes, stroke)
            if self.view:
                axes.set_title(self.view, fontsize=9, color=SOFT, loc="left")
            axes.margins(0.06)
            axes.autoscale_view()
            spans = axes.dataLim.width, axes.dataLim.height
            if all(map(isfinite, spans)):  # something is drawn
                figure.set_size_inches(*(INCHES * span + 0.6 for span in spans))
        return figure

    def _repr_html_(self) -> str:
        """For notebooks: the picture."""
        return self.svg()

    def svg(self) -> str:
        """The picture as SVG: the element alone, without a prologue."""
        import matplotlib as mpl

        stream = io.StringIO()
        with mpl.rc_context({**STYLE, "svg.hashsalt": "voronec"}):
            figure = self.figure()
            figure.savefig(stream, format="svg", metadata={"Date": None}, bbox_inches="tight")
        text = stream.getvalue()
        return text[text.index("<svg") :]


def _typeset(text: str) -> str:
    """LaTeX of a label: its names as symbols, unless it is a phrase."""
    if not text or " " in re.sub(r",\s+", ",", text):
        return text
    return "$" + re.sub(r"[A-Za-z]\w*", lambda m: symbol_latex(m[0]), text) + "$"


# -- drawers --------------------------------------------------------------------------------


def _label(axes: Any, at: Point, text: str, color: str = INK, side: float | None = None) -> None:
    """A label at a point, or beside it in a direction, as far off as it is long there."""
    if not text:
        return
    if side is not None:
        across, up = polar((0, 0), 1, side)
        letters = len(re.sub(r"\\[A-Za-z]+", "x", re.sub(r"[${}_ ]", "", text)))
        at = at[0] + across * (0.1 + LETTER * letters), at[1] + up * NUDGE
    axes.text(*at, text, color=color, ha="center", va="center")
    axes.plot(*at, alpha=0)  # so that the limits hold it


def _line(axes: Any, stroke: Stroke) -> None:
    axes.plot(*zip(*stroke.points, strict=True), **LOOKS[stroke.look])


def _area(axes: Any, stroke: Stroke) -> None:
    from matplotlib.patches import Polygon

    axes.add_patch(Polygon(stroke.points, closed=True, fc=FILL, ec=INK, lw=1.3, joinstyle="round"))


def _ellipse(axes: Any, stroke: Stroke) -> None:
    from matplotlib.patches import Ellipse

    width, height, angle = stroke.numbers
    looks = {"fc": "none", "ec": SOFT, "lw": 0.8, "ls": (0, (4, 3))}
    looks = looks if stroke.kind == "ring" else {"fc": FILL, "ec": INK, "lw": 1.3}
    axes.add_patch(Ellipse(stroke.points[0], 2 * width, 2 * height, angle=angle, **looks))


def _dot(axes: Any, stroke: Stroke) -> None:
    axes.plot(*stroke.points[0], "o", ms=4, color=INK)
    _label(axes, stroke.points[0], stroke.label, side=stroke.numbers[0])


def _text(axes: Any, stroke: Stroke) -> None:
    _label(axes, stroke.points[0], stroke.label)


def _arrow(axes: Any, stroke: Stroke) -> None:
    (x0, y0), (x1, y1) = stroke.points
    looks = {"arrowstyle": "-|>", "color": INK, "lw": 1, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x1, y1), (x0, y0), arrowprops=looks)
    axes.plot((x0, x1), (y0, y1), alpha=0)
    _label(axes, (x1, y1), stroke.label, side=degrees(atan2(y1 - y0, x1 - x0)))


def _arc(centre: Point, radius: float, start: float, end: float) -> list[Point]:
    count = 40
    return [polar(centre, radius, start + (end - start) * i / count) for i in range(count + 1)]


def _draw_head(axes: Any, points: Sequence[Point]) -> None:
    """A curve with a head at its end."""
    axes.plot(*zip(*points, strict=True), color=MARK, lw=0.9)
    looks = {"arrowstyle": "-|>", "color": MARK, "lw": 0.9, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", points[-1], points[-3], arrowprops=looks)


def _angle(axes: Any, stroke: Stroke) -> None:
    radius, start, end = stroke.numbers
    at = stroke.points[0]
    _draw_head(axes, _arc(at, radius, start, end))
    middle = (start + end) / 2
    _label(axes, polar(at, radius, middle), stroke.label, MARK, middle)


def _turn(axes: Any, stroke: Stroke) -> None:
    """Three quarters of a circle about the axis, seen from the side."""
    axis, radius = stroke.numbers
    at = stroke.points[0]
    points = []
    for i in range(41):
        across = polar((0, 0), radius, -225 + 270 * i / 40)
        ahead, aside = polar((0, 0), 0.35 * across[1], axis), polar((0, 0), across[0], axis - 90)
        points.append((at[0] + ahead[0] + aside[0], at[1] + ahead[1] + aside[1]))
    _draw_head(axes, points)
    _label(axes, polar(at, radius, axis - 90), stroke.label, MARK, axis - 90)


def _distance(axes: Any, stroke: Stroke) -> None:
    (x0, y0), (x1, y1) = stroke.points
    length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
    offset = stroke.numbers[0]
    dx, dy = -(y1 - y0) / length * offset, (x1 - x0) / length * offset
    looks = {"arrowstyle": "<|-|>", "color": SOFT, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x1 + dx, y1 + dy), (x0 + dx, y0 + dy), arrowprops=looks)
    axes.plot((x0 + dx, x1 + dx), (y0 + dy, y1 + dy), alpha=0)
    step = 1 + NUDGE / abs(offset) if offset else 1
    _label(axes, ((x0 + x1) / 2 + step * dx, (y0 + y1) / 2 + step * dy), stroke.label, SOFT)


DRAWERS: Mapping[str, Callable[[Any, Stroke], None]] = MappingProxyType(
    {
        "line": _line,
        "area": _area,
        "ellipse": _ellipse,
        "ring": _ellipse,
        "dot": _dot,
        "text": _text,
        "arrow": _arrow,
        "angle": _angle,
        "turn": _turn,
        "distance": _distance,
    }
)
"""Kind of a stroke -> what draws it."""
