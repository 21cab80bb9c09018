"""A dozen motions of the catalogue as pages that integrate by themselves, and their list, with a
small film of each."""

from __future__ import annotations

import html
import re
from base64 import b64encode
from collections.abc import Callable
from importlib.resources import files as resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from voronec.declaration.catalogue import load
from voronec.motion.pictures.scene_film import ShapesInMotion, film
from voronec.motion.prepared_problem import integrate
from voronec.motion.trajectory import Trajectory
from voronec.motion.viewer.page import Page

MOTIONS = (
    ("demchenko", "default", "balls"), ("demchenko", "inner", "balls"),
    ("demchenko", "shell", "balls"), ("chaplygin-ball", "default", "balls"),
    ("gyroscopic-ball-on-sphere", "default", "balls"), ("bychkov-ball", "default", "balls"),
    ("torus-on-ellipsoid", "default", "other bodies"), ("rattleback", "default", "other bodies"),
    ("falling-disc", "default", "wheels"), ("two-wheeled-carriage", "default", "wheels"),
    ("snakeboard", "default", "wheels"), ("bicycle", "default", "wheels"),
)  # fmt: skip
"""Systems, scenes and kinds, in the order of the list."""
STARTS: dict[tuple[str, str], dict[str, Any]] = {
    ("demchenko", "default"): {"n": 3},
    ("rattleback", "default"): {"theta": "1/20", "omega1": "1/10", "omega3": "-7/10"},
}
"""Faster starts, where a scene leaves but a short trace by the time that somebody looks."""
FRAMES, DOTS = 10, 50
"""Frames of a thumbnail, and its dots in an inch of 4.8."""


def write_gallery(folder: Path, tell: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write a page for each of ``MOTIONS``, and ``index.html``, into a folder that exists.

    Returns the files, the index first; ``tell`` is told the name of each before its work.
    """
    files, rows = [folder / "index.html"], []
    kinds = {kind: f"kind{k}" for k, kind in enumerate(dict.fromkeys(m[2] for m in MOTIONS))}
    for name, scene, kind in MOTIONS:
        tell(f"{name}, {scene}")
        system = load(name)
        everything = (*system.coordinates, *system.velocities)
        title = (system.title or name) + ("" if scene == "default" else f", {scene}")
        caption, initial = system.scenes[scene].caption, STARTS.get((name, scene))
        run = integrate(system, scene, initial=initial, outputs=everything)
        files.append(folder / f"{name}-{scene}.html")
        files[-1].write_text(Page(run, caption, title).text, "utf-8")
        rows.append(
            f'<a class="card {kinds[kind]}" href="{files[-1].name}">'
            f'<img alt="" src="{_poster(run)}">'
            f"<b>{html.escape(title)}</b><span>{html.escape(caption)}</span></a>"
        )
    parts = {"ROWS": "\n".join(rows), "STYLE": "", "KINDS": ""}
    for kind, tag in kinds.items():
        parts["KINDS"] += (
            f'<input type="radio" name="kind" id="{tag}"><label for="{tag}">{kind}</label>\n'
        )
        parts["STYLE"] += f"#{tag}:checked ~ main .card:not(.{tag}) {{ display: none; }}\n"
    index = (resources(__package__) / "gallery.html").read_text("utf-8")
    files[0].write_text(re.sub("@([A-Z]+)@", lambda mark: parts[mark[1]], index), "utf-8")
    return files


def _poster(run: Trajectory) -> str:
    """A small film of a motion, as the address of a picture that holds it."""
    with TemporaryDirectory() as place:
        (file,) = film(ShapesInMotion(run), Path(place) / "poster.webp", FRAMES, 4, dots=DOTS)
        return f"data:image/webp;base64,{b64encode(file.read_bytes()).decode()}"
