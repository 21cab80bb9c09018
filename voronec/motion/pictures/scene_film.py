"""Films and pictures of any system with shapes, from the scene that its page shows.

Surfaces are cut into small quadrilaterals, drawn from the farthest to the nearest, so that bodies
in front hide what is behind.  Films are written by Pillow as .gif or .webp, by the program ffmpeg
as .mp4, or frame by frame.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.declaration.figure_style import INK, MARK, STYLE
from voronec.equations.program import compile_program
from voronec.errors import DefinitionError
from voronec.motion.viewer.page import Page, check_shapes, mesh_program

if TYPE_CHECKING:
    from voronec.declaration.system import System
    from voronec.motion.pictures.motion_record import MotionRecord

TONES = {"body": ("#dce9f7", "#7fa8d4"), "ground": ("#f7f2e8", "#e3d6bd")}
"""Two tones of a chequered surface."""
TURN, HEIGHT = 0.9, 0.45
"""Where the eye stands, about the vertical and above the horizon, where no trace tells better."""
POSE = 15
"""Numbers of a shape at an instant: centre, attitude row by row, contact."""
FAR_PATH = 12.0
"""A path so many times as large as the body is followed."""


@dataclass(frozen=True)
class ShapesInMotion:
    """The shapes of a system along a ``trajectory`` of n instants."""

    trajectory: MotionRecord

    @cached_property
    def page(self) -> Page:
        """The page of the motion."""
        return Page(self.trajectory)

    @cached_property
    def numbers(self) -> list[float]:
        """The values of the parameters."""
        values = self.trajectory.parameters
        return [float(values.get(str(p), np.nan)) for p in self.page.program.parameters]

    @cached_property
    def poses(self) -> np.ndarray:
        """Where the shapes are (n, shapes, POSE).  ``DefinitionError`` where the trajectory lacks
        what they depend on."""
        program, record = self.page.program, self.trajectory
        t, shapes = np.asarray(record.t, dtype=float), self.trajectory.system.shapes
        states = [
            np.asarray(record[str(x)], dtype=float)
            if str(x) in record.outputs else np.full(len(t), np.nan) for x in program.state
        ]  # fmt: skip
        pushed = [[np.nan] * len(program.inputs)] if program.inputs else []  # no shape needs them
        with np.errstate(all="ignore"):
            extras = compile_program(program)[1]
            columns = extras(t, states, self.numbers, *pushed)[: POSE * len(shapes)]
        poses = np.stack([np.broadcast_to(x, t.shape) for x in columns], axis=-1).astype(float)
        if not np.isfinite(poses).all():
            raise DefinitionError(
                f"system '{record.system.name}': the places of its shapes need coordinates that "
                "the trajectory does not hold; integrate with outputs='configuration'"
            )
        return poses.reshape(len(t), len(shapes), POSE)

    @cached_property
    def reach(self) -> tuple[np.ndarray, np.ndarray]:
        """The corners of a box that holds the middles of all bodies at all times."""
        bounded = [i for i, shape in enumerate(self.trajectory.system.shapes) if _is_bounded(shape)]
        centres = self.poses[:, bounded, :3].reshape(-1, 3) if bounded else np.zeros((1, 3))
        return centres.min(axis=0), centres.max(axis=0)

    @cached_property
    def sizes(self) -> list[float]:
        """How far each shape reaches from its middle; 0 for what has no end."""
        return [
            float(np.linalg.norm(np.concatenate([q for q, _ in parts]), axis=-1).max())
            if _is_bounded(shape) else 0.0
            for shape, parts in zip(self.trajectory.system.shapes, self.finite_patches, strict=True)
        ]  # fmt: skip

    @cached_property
    def grains(self) -> list[float]:
        """How far each shape's quadrilaterals reach from their middles, and a fifth more, so that
        lines along an edge are drawn whole; 0 for what has no end."""
        return [
            0.6 * max(float(np.linalg.norm(q[:, 2] - q[:, 0], axis=-1).max()) for q, _ in parts)
            if _is_bounded(shape) else 0.0
            for shape, parts in zip(self.trajectory.system.shapes, self.finite_patches, strict=True)
        ]  # fmt: skip

    @cached_property
    def body(self) -> int:
        """The first shape that moves."""
        roles = [shape.role for shape in self.trajectory.system.shapes]
        return roles.index("body") if "body" in roles else 0

    @cached_property
    def finite_patches(self) -> list[list[tuple[np.ndarray, np.ndarray]]]:
        """Quadrilaterals (q, 4, 3) of each patch in the shape's own axes, and their tones (q,)."""
        return [
            [self._quads(k, patch.ranges) for k, patch in patches if patch.ranges is not None]
            for patches in self._patches()
        ]

    @cached_property
    def meshes(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Quadrilaterals of each shape, those without end as far as the motion goes."""
        low, high = self.reach
        most = max(float((high - low).max()), 4 * max(self.sizes)) + 2 * max(self.sizes)
        step, whole = most / 8, list[tuple[np.ndarray, np.ndarray]]()
        middle = np.round((low + high) / 2 / step) * step
        for patches in self._patches():
            parts = [
                self._quads(k, patch.ranges or [(c - most, c + most) for c in middle[:2]])
                for k, patch in patches
            ]
            quads, tones = (np.concatenate(each) for each in zip(*parts, strict=True))
            whole.append((quads, tones))
        return whole

    def _patches(self) -> list[list[tuple[int, Any]]]:
        number, patches = 0, []
        for shape in self.trajectory.system.shapes:
            patches.append([*enumerate(shape.patches, number)])
            number += len(shape.patches)
        return patches

    @cached_property
    def _points(self) -> Callable[..., Any]:
        shapes = self.trajectory.system.shapes
        return compile_program(mesh_program(shapes, self.page.namespace))[1]

    def _quads(self, place: int, ranges: Any) -> tuple[np.ndarray, np.ndarray]:
        sides = [(float(low), float(high)) for low, high in ranges]
        cells = [32 if high - low > 3 else 16 for low, high in sides]
        grid = np.meshgrid(
            *(np.linspace(*s, n + 1) for s, n in zip(sides, cells, strict=True)), indexing="ij"
        )
        every = self._points(0.0, grid, self.numbers)[3 * place : 3 * place + 3]
        points = np.stack([np.broadcast_to(x, grid[0].shape) for x in every], axis=-1)
        corners = [points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]]
        tones = np.add.outer(np.arange(cells[0]) // 4, np.arange(cells[1]) // 4) % 2
        return np.stack(corners, axis=2).reshape(-1, 4, 3).astype(float), tones.ravel()

    @cached_property
    def axes(self) -> np.ndarray:
        """Right, up and towards the eye (3, 3), from where the contacts are seen best."""
        contacts = [i for i, s in enumerate(self.trajectory.system.shapes) if s.contact is not None]
        away = self.poses[:, contacts, 12:] - self.poses[:, contacts, :3]
        aside = away.reshape(-1, 3).mean(axis=0) if contacts else np.zeros(3)
        size = np.linalg.norm(aside)
        sideways = size > 0 and np.hypot(*aside[:2]) > 0.3 * size
        turn = float(np.arctan2(aside[1], aside[0])) + 0.7 if sideways else TURN
        c, s, flat, up = np.cos(turn), np.sin(turn), np.cos(HEIGHT), np.sin(HEIGHT)
        return np.array([[-s, c, 0], [-up * c, -up * s, flat], [flat * c, flat * s, up]])

    def is_glass(self, i: int) -> bool:
        """Whether a shape holds another one of the other role within."""
        shapes, sizes, start = self.trajectory.system.shapes, self.sizes, self.poses[0, :, :3]
        return any(
            0 < sizes[j] < sizes[i] and shapes[i].role != shapes[j].role
            and np.linalg.norm(start[i] - start[j]) < sizes[i] for j in range(len(shapes))
        )  # fmt: skip

    def window(self, now: int) -> tuple[np.ndarray, float]:
        """Middle and half width of a square that shows the bodies; a small one is followed."""
        low, high = self.reach
        largest, half = max(self.sizes), float(np.linalg.norm(high - low)) / 2
        size = self.sizes[self.body]
        if size and half > FAR_PATH * size and largest == size:
            return self.axes[:2] @ self.poses[now, self.body, :3], 5 * size
        return self.axes[:2] @ (low + high) / 2, half + 1.1 * largest

    def draw(self, panel: Any, now: int) -> None:
        """One instant."""
        from matplotlib.collections import PolyCollection

        middle, half = self.window(now)
        polygons, colours, depths = [], [], []
        for i, shape in enumerate(self.trajectory.system.shapes):
            pose, (quads, tones) = self.poses[now, i], self.meshes[i]
            seen = (quads @ pose[3:12].reshape(3, 3).T + pose[:3]) @ self.axes.T
            polygons.append(seen[..., :2])
            colours.append(
                _surface_colours(seen, tones, TONES[shape.role], 0.3 if self.is_glass(i) else 1)
            )
            depth = seen[..., 2].mean(axis=1)
            depths.append(depth if _is_bounded(shape) else depth - 1e6 * (1 + np.abs(depth).max()))
            for line, colour, above in self._traces(i, now):
                flat, near = _ribbon(line @ self.axes.T, half / 160)
                polygons.append(flat)
                colours.append(np.tile(_rgba(colour), (len(flat), 1)))
                depths.append(near + above)
        order = np.argsort(np.concatenate(depths), kind="stable")
        ordered = [np.concatenate(each)[order] for each in (polygons, colours)]
        panel.clear()
        panel.set_axis_off()
        panel.add_collection(
            PolyCollection(
                [*ordered[0]], facecolors=ordered[1], edgecolors=ordered[1], linewidths=0.3
            )
        )
        (x, y), t = middle, float(self.trajectory.t[now])
        panel.set(aspect="equal", xlim=(x - half, x + half), ylim=(y - half, y + half))
        panel.text(0.02, 0.02, f"$t = {t:.2f}$", transform=panel.transAxes, fontsize=10)

    def _traces(self, i: int, now: int) -> list[tuple[np.ndarray, str, float]]:
        """The traces (k, 3) of a contact as they lie at an instant: on the body, and in space; and
        by how much they are nearer than the quadrilaterals on which they lie."""
        if self.trajectory.system.shapes[i].contact is None or not now:
            return []
        past, pose = self.poses[: now + 1, i], self.poses[now, i]
        contacts = np.einsum(
            "kji,kj->ki", past[:, 3:12].reshape(-1, 3, 3), past[:, 12:] - past[:, :3]
        )
        on_body = contacts @ pose[3:12].reshape(3, 3).T + pose[:3]
        grounds = zip(self.trajectory.system.shapes, self.grains, strict=True)
        under = max((grain for shape, grain in grounds if shape.role == "ground"), default=0.0)
        return [(on_body, INK, self.grains[i]), (past[:, 12:], MARK, under)]


def _is_bounded(shape: Any) -> bool:
    return all(patch.ranges is not None for patch in shape.patches)


def _rgba(colour: str, alpha: float = 1.0) -> np.ndarray:
    from matplotlib.colors import to_rgba

    return np.array(to_rgba(colour, alpha))


def _surface_colours(
    seen: np.ndarray, tones: np.ndarray, colours: Sequence[str], alpha: float
) -> np.ndarray:
    """Colours (q, 4) of quadrilaterals (q, 4, 3), lighter where they face the light."""
    normal = np.cross(seen[:, 2] - seen[:, 0], seen[:, 3] - seen[:, 1])
    size = np.linalg.norm(normal, axis=1)
    light = np.abs(normal @ np.array([-0.35, 0.5, 0.79])) / np.where(size > 0, size, 1.0)
    shades = np.stack([_rgba(colours[k], alpha) for k in (0, 1)])[tones]
    shades[:, :3] *= (0.62 + 0.38 * light)[:, None]
    return shades


def _ribbon(line: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """A line (k, 3) as thin quadrilaterals (k - 1, 4, 2), and how near they are."""
    begin, end = line[:-1], line[1:]
    along = (end - begin)[:, :2]
    size = np.linalg.norm(along, axis=1, keepdims=True)
    unit = along / np.where(size > 0, size, 1.0)
    aside, on = width * np.stack([-unit[:, 1], unit[:, 0]], axis=1), 0.4 * width * unit
    a, b = begin[:, :2] - on, end[:, :2] + on
    return np.stack([a + aside, b + aside, b - aside, a - aside], axis=1), (begin + end)[:, 2] / 2


def check_film(system: System, target: Path) -> None:
    """``DefinitionError`` where no film of the system can be written there, before any work."""
    check_shapes(system)
    if not target.parent.is_dir():
        raise DefinitionError(f"'{target}' cannot be written: there is no '{target.parent}'")
    _writer(target, 1)


def film(
    shown: ShapesInMotion, target: Path, frames: int = 160, rate: int = 20,
    progress: Callable[[float], None] | None = None, dots: int = 100,
) -> tuple[Path, ...]:  # fmt: skip
    """Write a film, and return what was written.

    target
        FILE.gif, FILE.webp; FILE.mp4, where ``ffmpeg_program`` is there; or FILE.png, FILE.svg
        for single frames FILE-0001.png and so on.
    frames, rate
        how many, spread evenly over the run, and how many in a second.
    progress
        called with the share that is done.
    dots
        in an inch, of 4.8 by 4.8.
    """
    from matplotlib import rc_context

    writer, dated = _writer(target, rate), {"Date": None} if target.suffix == ".svg" else None
    settings = {"svg.hashsalt": "voronec", "animation.ffmpeg_path": ffmpeg_program()}
    with rc_context(STYLE | settings):
        figure, panel = _stage(shown.trajectory.system)
        chosen = np.unique(np.linspace(0, len(shown.trajectory.t) - 1, frames).astype(int))
        written = [target] if writer else []
        if writer:
            writer.setup(figure, str(target), dpi=dots)
        for number, place in enumerate(chosen):
            shown.draw(panel, int(place))
            if writer:
                writer.grab_frame()
            else:
                written.append(target.with_stem(f"{target.stem}-{number + 1:04d}"))
                figure.savefig(written[-1], metadata=dated)
            if progress:
                progress((number + 1) / len(chosen))
        if writer:
            writer.finish()
    return tuple(written)


def picture(shown: ShapesInMotion, now: int) -> Any:
    """One instant as a matplotlib ``Figure``."""
    figure, panel = _stage(shown.trajectory.system)
    shown.draw(panel, now)
    return figure


def _writer(target: Path, rate: int) -> Any:
    """What puts frames together; None for single ones."""
    from matplotlib import animation

    if target.suffix in (".png", ".svg"):
        return None
    if target.suffix in (".gif", ".webp"):
        return animation.PillowWriter(fps=rate)
    if target.suffix != ".mp4":
        raise DefinitionError(
            f"'{target}' is no film; write FILE.gif, FILE.webp, FILE.mp4, or FILE.png"
        )
    if not ffmpeg_program():
        raise DefinitionError(
            f"'{target}' needs the program ffmpeg, which is not installed; install it, or the "
            "package with it, pip install 'voronec[film]', or write FILE.gif"
        )
    return animation.FFMpegWriter(fps=rate)


def ffmpeg_program() -> str:
    """Where the program ffmpeg is: the machine's, else that of the package imageio-ffmpeg; empty
    where there is neither."""
    program = which("ffmpeg")
    if program is None:
        try:
            program = import_module("imageio_ffmpeg").get_ffmpeg_exe()
        except (ImportError, RuntimeError):  # the package is not there, or has no program here
            return ""
    return str(program)


def _stage(system: System) -> tuple[Any, Any]:
    """A square figure with one panel."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.8, 4.8))
    FigureCanvasAgg(figure)
    panel = figure.add_axes((0, 0, 1, 0.95))
    figure.suptitle(system.title or system.name, fontsize=10, y=0.985)
    return figure, panel
