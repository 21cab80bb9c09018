"""The style that all figures share.

Figures are made without pyplot, so no window opens and no global state is touched.
"""

from __future__ import annotations

from typing import Any

__all__ = ["FAINT", "INK", "MARK", "PALE", "SOFT", "STYLE", "WIDTH"]

INK, PALE, SOFT, FAINT, MARK = "#1b3a5c", "#a9b7c6", "#8a97a6", "#dfe4ea", "#b3361e"
STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["DejaVu Serif"],
    "mathtext.fontset": "cm",
    "font.size": 9,
    "axes.labelsize": 10,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "axes.formatter.use_mathtext": True,
    "svg.fonttype": "path",
}
WIDTH = 6.4
"""Inches: the text width of a page."""
