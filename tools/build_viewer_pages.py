"""Write a dozen pages of motions that integrate by themselves, and an index: FOLDER/index.html."""

from __future__ import annotations

import html
import sys
from pathlib import Path

from voronec import integrate, load
from voronec.motion.viewer.page import Page

MOTIONS = (
    ("demchenko", "default"), ("demchenko", "inner"), ("demchenko", "shell"),
    ("chaplygin-ball", "default"), ("gyroscopic-ball-on-sphere", "default"),
    ("bychkov-ball", "default"), ("torus-on-ellipsoid", "default"), ("rattleback", "default"),
    ("falling-disc", "default"), ("two-wheeled-carriage", "default"), ("snakeboard", "default"),
    ("bicycle", "default"),
)  # fmt: skip


def build(folder: Path) -> None:
    """The pages, and an index with their titles and captions."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = []
    for name, scene in MOTIONS:
        system = load(name)
        everything = (*system.coordinates, *system.velocities)
        caption = system.scenes[scene].caption
        page = Page(integrate(system, scene=scene, outputs=everything), caption)
        (folder / f"{name}-{scene}.html").write_text(page.text, "utf-8")
        title, said = html.escape(system.title), html.escape(caption)
        rows.append(f'<li><a href="{name}-{scene}.html">{title}</a>: {said}</li>')
    text = "\n".join(rows)
    head = '<!doctype html><meta charset="utf-8"><title>Motions to look at</title>'
    (folder / "index.html").write_text(f"{head}\n<ul>\n{text}\n</ul>\n", "utf-8")


if __name__ == "__main__":
    build(Path(sys.argv[1] if len(sys.argv) > 1 else "viewer-pages"))
