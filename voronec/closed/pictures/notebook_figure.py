"""Figures that a notebook shows: it knows those of pyplot alone by itself.

To be imported where a figure is made, since it loads matplotlib.
"""

from __future__ import annotations

import io

from matplotlib.figure import Figure

__all__ = ["NotebookFigure"]


class NotebookFigure(Figure):
    """A figure made without pyplot, which is shown where a cell ends with it."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png", dpi=110)
        return stream.getvalue()
