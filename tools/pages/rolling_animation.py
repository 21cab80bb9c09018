"""A ball that rolls over a sphere, with the trace of the contact on both, as a strip for print.

The ball carries its own trace along; the other one stays on the fixed sphere.  Rolling outside,
these are two bodies that hide each other; inside, the fixed sphere is glass; a shell around the
fixed sphere is glass itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.closed.pictures.sphere_curves import View, best_view, on_sphere
from voronec.declaration.figure_style import INK, MARK, NO_SPACE, figure_in_style

if TYPE_CHECKING:
    from voronec.motion.pictures.motion_record import MotionRecord

BALL, GROUND, NET, RIM = "#eaf1f8", "#f7f3ec", "#9fb2c6", "#5d6b7a"


@dataclass(frozen=True)
class Rolling:
    """A ball on a sphere, at many instants.

    body, fixed
        (n, 3), unit normals at the contact: of the ball in its own axes, of the sphere in space.
    attitude
        (n, 3, 3): the ball's axes in space, as columns.
    fixed_radius, radius
        of the fixed sphere, negative where the ball rolls inside or is a shell around it, and of
        the ball; its centre is at (R1 + R2) n1.
    times, title
        for the caption.
    """

    body: np.ndarray
    fixed: np.ndarray
    attitude: np.ndarray
    fixed_radius: float
    radius: float
    times: np.ndarray
    title: str = ""

    @property
    def kind(self) -> str:
        """'outer', 'inner' or 'shell'."""
        if self.fixed_radius > 0:
            return "outer"
        return "inner" if -self.fixed_radius > self.radius else "shell"

    @property
    def centres(self) -> np.ndarray:
        """The ball's centre in space, (n, 3)."""
        return (self.fixed_radius + self.radius) * self.fixed


def _rolling_view(rolling: Rolling) -> View:
    """The eye: towards the contact where glass shows it, else so that the ball is seen sideways."""
    if rolling.kind == "inner":
        return best_view(-rolling.fixed)
    view = best_view(rolling.fixed if rolling.kind == "outer" else -rolling.fixed)
    aside = 0.7 if rolling.kind == "outer" else 0.0
    return View(view.longitude + aside, view.height)


def _window(rolling: Rolling, view: View) -> tuple[float, float, float]:
    """Middle and half width of a square that holds both bodies at all times."""
    seen = view.project(rolling.centres)[:, :2]
    big = abs(rolling.fixed_radius)
    low = np.minimum(seen.min(axis=0) - rolling.radius, -big)
    high = np.maximum(seen.max(axis=0) + rolling.radius, big)
    x, y = (low + high) / 2
    return float(x), float(y), 1.03 * float((high - low).max()) / 2


def _draw_rolling(panel: Any, rolling: Rolling, view: View, now: int, width: float = 1.0) -> None:
    """One instant."""
    panel.clear()
    panel.set_axis_off()
    x, y, reach = _window(rolling, view)
    panel.set(aspect="equal", xlim=(x - reach, x + reach), ylim=(y - reach, y + reach))
    sign = np.sign(rolling.fixed_radius)
    ground = _Globe(
        np.zeros(3), abs(rolling.fixed_radius), np.eye(3), sign * rolling.fixed[: now + 1], GROUND,
        MARK,
    )  # fmt: skip
    ball = _Globe(
        rolling.centres[now], rolling.radius, rolling.attitude[now], rolling.body[: now + 1], BALL,
        INK,
    )  # fmt: skip
    near = bool(view.project(ball.centre)[2] >= 0)
    if rolling.kind == "outer":
        behind, before = (ground, ball) if near else (ball, ground)
        behind.opaque(panel, view, 1, width)
        before.opaque(panel, view, 11, width)
    else:
        glass, inside = (ground, ball) if rolling.kind == "inner" else (ball, ground)
        glass.far(panel, view, 1, width)
        inside.opaque(panel, view, 11, width)
        glass.near(panel, view, 21, width)
    at = view.project(rolling.fixed_radius * rolling.fixed[now])
    panel.plot(at[:1], at[1:2], "o", color=MARK if at[2] >= 0 else "white", markeredgecolor=MARK,
               markersize=3.5 * width, markeredgewidth=0.8, zorder=31)  # fmt: skip
    panel.text(x - reach, y - reach, f"$t = {rolling.times[now]:.2f}$", fontsize=9, va="bottom")


@dataclass(frozen=True)
class _Globe:
    """A ball in space with a curve on it."""

    centre: np.ndarray
    radius: float
    attitude: np.ndarray
    curve: np.ndarray
    face: str
    ink: str

    def opaque(self, panel: Any, view: View, order: int, width: float) -> None:
        """What hides others behind it; its own curve shines through."""
        self._disc(panel, view, order, width, self.face, 0.78)
        self._net(panel, view, order + 1, width, True, 0.55)
        self._curve(panel, view, order + 1, 0.9 * width, False, 0.65)
        self._curve(panel, view, order + 2, width, True, 1.0)

    def far(self, panel: Any, view: View, order: int, width: float) -> None:
        """The far half of a globe of glass, seen from within."""
        self._disc(panel, view, order, width, self.face, 0.6)
        self._net(panel, view, order + 1, width, False, 0.45)
        self._curve(panel, view, order + 2, width, False, 0.55)

    def near(self, panel: Any, view: View, order: int, width: float) -> None:
        """Its near half."""
        self._net(panel, view, order + 1, width, True, 0.3)
        self._curve(panel, view, order + 2, width, True, 1.0)

    def _disc(
        self, panel: Any, view: View, order: int, width: float, face: str, alpha: float
    ) -> None:
        from matplotlib.patches import Circle

        x, y, _ = view.project(self.centre)
        panel.add_patch(Circle((x, y), self.radius, facecolor=face, alpha=alpha, linewidth=0,
                               zorder=order))  # fmt: skip
        panel.add_patch(Circle((x, y), self.radius, fill=False, edgecolor=RIM,
                               linewidth=0.9 * width, zorder=order + 0.5))  # fmt: skip

    def _net(
        self, panel: Any, view: View, order: int, width: float, front: bool, alpha: float
    ) -> None:
        """Meridians and parallels, which show how it turns; the pole of its axis."""
        style = {"color": NET, "linewidth": 0.5 * width, "alpha": alpha, "zorder": order}
        for line in _NET:
            self._line(panel, view, line, front, **style)
        for side, colour in ((1.0, self.ink), (-1.0, "white")):
            x, y, depth = self._projection(view, np.array([[0, 0, side]]))[0]
            if (depth >= 0) == front:
                panel.plot([x], [y], "o", color=colour, markeredgecolor=self.ink,
                           markersize=2.6 * width, markeredgewidth=0.6, alpha=max(alpha, 0.5),
                           zorder=order)  # fmt: skip

    def _curve(
        self, panel: Any, view: View, order: int, width: float, front: bool, alpha: float
    ) -> None:
        style = {"color": self.ink, "linewidth": 1.1 * width, "alpha": alpha, "zorder": order}
        self._line(panel, view, self.curve, front, **style)
        x, y, depth = self._projection(view, self.curve[:1])[0]
        if (depth >= 0) == front:  # where it began
            panel.plot([x], [y], "o", color="white", markeredgecolor=self.ink, alpha=alpha,
                       markersize=2.4 * width, markeredgewidth=0.7, zorder=order)  # fmt: skip

    def _line(self, panel: Any, view: View, points: np.ndarray, front: bool, **style: Any) -> None:
        x, y, depth = self._projection(view, points).T
        kept = (depth >= 0) == front
        if kept.any():
            gap = np.where(kept, 0.0, np.nan)
            panel.plot(x + gap, y + gap, solid_joinstyle="round", **style)

    def _projection(self, view: View, points: np.ndarray) -> np.ndarray:
        """(right, up, depth below or above the centre) of points on it."""
        turned = self.radius * points @ self.attitude.T
        seen = view.project(turned)
        seen[:, :2] += view.project(self.centre)[:2]
        return seen


_ARC, _TURN = np.linspace(0, np.pi, 25), np.linspace(0, 2 * np.pi, 49)
_NET = (
    *(on_sphere(_ARC, longitude) for longitude in np.arange(12) * np.pi / 6),
    *(on_sphere(colatitude, _TURN) for colatitude in np.arange(1, 6) * np.pi / 6),
)


COORDINATES, RADII = ("u", "v", "u1", "v1", "theta"), ("R1", "R2")


def rolling_of(trajectory: MotionRecord) -> Rolling:
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


def film_strip(rolling: Rolling, instants: Sequence[int], columns: int = 3) -> Any:
    """Some frames side by side as one matplotlib ``Figure``, for print."""
    rows = -(-len(instants) // columns)
    with figure_in_style(2.15 * columns, 2.35 * rows) as figure:
        figure.get_layout_engine().set(**NO_SPACE)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels:
            panel.set_axis_off()
        view = _rolling_view(rolling)
        for panel, place in zip(panels, instants, strict=False):
            _draw_rolling(panel, rolling, view, place, width=0.7)
    return figure
