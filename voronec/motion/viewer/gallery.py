"""A dozen motions of the catalogue as pages that integrate by themselves, and their list."""

from __future__ import annotations

import html
from collections.abc import Callable
from pathlib import Path

from voronec.declaration.catalogue import load
from voronec.motion.prepared_problem import integrate
from voronec.motion.viewer.page import Page

MOTIONS = (
    ("demchenko", "default"), ("demchenko", "inner"), ("demchenko", "shell"),
    ("chaplygin-ball", "default"), ("gyroscopic-ball-on-sphere", "default"),
    ("bychkov-ball", "default"), ("torus-on-ellipsoid", "default"), ("rattleback", "default"),
    ("falling-disc", "default"), ("two-wheeled-carriage", "default"), ("snakeboard", "default"),
    ("bicycle", "default"),
)  # fmt: skip
"""Systems and scenes, in the order of the list."""
INDEX = """<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Motions to look at</title>
<style>
body { max-width: 46rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; }
li { margin: 0.5rem 0; }
</style>
<h1>Motions to look at</h1>
<p>Each page integrates the equations of motion by itself, and needs no network.</p>
<ol>
@ROWS@
</ol>
</html>
"""


def write_gallery(folder: Path, tell: Callable[[str], None] = lambda _: None) -> list[Path]:
    """Write a page for each of ``MOTIONS``, and ``index.html``, into a folder that exists.

    Returns the files, the index first; ``tell`` is told the name of each before its work.
    """
    files, rows = [folder / "index.html"], []
    for name, scene in MOTIONS:
        tell(f"{name}, {scene}")
        system = load(name)
        everything = (*system.coordinates, *system.velocities)
        caption = system.scenes[scene].caption
        page = Page(integrate(system, scene=scene, outputs=everything), caption)
        files.append(folder / f"{name}-{scene}.html")
        files[-1].write_text(page.text, "utf-8")
        title, said = html.escape(system.title), html.escape(caption)
        rows.append(f'<li><a href="{files[-1].name}">{title}</a>: {said}</li>')
    files[0].write_text(INDEX.replace("@ROWS@", "\n".join(rows)), "utf-8")
    return files
