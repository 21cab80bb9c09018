"""Make the pictures of the documentation: ``python tools/build_pictures.py``."""

from __future__ import annotations

from pathlib import Path

import voronec as vo
from voronec.motion.pictures.run_pictures import drawing, save

DOCS = Path(__file__).resolve().parent.parent / "docs"


def main() -> None:
    """Write ``docs/demchenko-traces.png``: the default motion of Demchenko's ball."""
    trajectory = vo.integrate(vo.load("demchenko"), scene="default")
    figure = drawing(trajectory)
    figure.set_dpi(160)
    save(figure, DOCS / "demchenko-traces.png")


if __name__ == "__main__":
    main()
