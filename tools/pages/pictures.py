"""Make the pictures of the documentation: ``python tools/build.py pictures``."""

from __future__ import annotations

from pathlib import Path

import voronec as vo
from voronec.motion.pictures.run_pictures import drawing, save

DOCS = Path(__file__).resolve().parents[2] / "docs"


def main() -> int:
    """Write ``docs/demchenko-traces.png``: the default motion of Demchenko's ball."""
    trajectory = vo.integrate(vo.load("demchenko"), scene="default")
    figure = drawing(trajectory)
    figure.set_dpi(160)
    save(figure, DOCS / "demchenko-traces.png")
    return 0
