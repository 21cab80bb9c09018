"""The picture of an ensemble: some of its motions, and how all of them spread in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.declaration.figure_style import FAINT, INK, MARK, SOFT, WIDTH, figure_in_style
from voronec.declaration.reading import several
from voronec.errors import DefinitionError
from voronec.motion.pictures.run_pictures import quantity_label

if TYPE_CHECKING:
    from voronec.motion.pictures.motion_record import MotionRecord

CURVES = 12
"""So many motions are drawn one by one."""


def plot_ensemble(
    ensemble: MotionRecord, finished: np.ndarray, names: Sequence[str] | None = None
) -> Any:
    """A matplotlib ``Figure`` with a panel for each quantity, on one time axis; ``finished`` marks
    the motions that are shown, and a band holds nine
    of ten motions, from the 5th to the 95th of a hundred."""
    shown = several(ensemble.outputs if names is None else names, "names", '"x"')
    if not shown:
        raise DefinitionError("there is nothing to plot; name outputs")
    there = np.flatnonzero(finished)
    if not len(there):
        raise DefinitionError("no motion of the ensemble is finished, so there is no picture")
    some = there[np.linspace(0, len(there) - 1, min(CURVES, len(there))).astype(int)]
    with figure_in_style(WIDTH, 0.8 + 1.2 * len(shown)) as figure:
        panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for name, panel in zip(shown, panels, strict=True):
            values = ensemble[name]
            low, middle, high = np.nanquantile(values[there], (0.05, 0.5, 0.95), axis=0)
            panel.fill_between(ensemble.t, low, high, color=FAINT, linewidth=0)
            panel.plot(ensemble.t, values[some].T, color=SOFT, linewidth=0.5)
            panel.plot(ensemble.t, middle, color=MARK if len(there) > 1 else INK, linewidth=1.1)
            panel.set_ylabel(quantity_label(ensemble, name))
            panel.margins(x=0)
            panel.spines[["top", "right"]].set_visible(False)
        panels[-1].set_xlabel("$t$")
        title = ensemble.system.title or ensemble.system.name
        figure.suptitle(f"{title}: {len(there)} motions, their median and nine tenths", fontsize=10)
    return figure
