"""The traces of a motion in closed form, ready to be drawn on spheres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.report.sphere_picture import SphereTrace

if TYPE_CHECKING:
    from voronec.closed import ClosedForm

__all__ = ["motion_traces", "shown_periods"]

DENSE = 600
"""Points for each period, of which the picture keeps what it needs."""
FEW, FEWEST, MOST = 3, 5, 16
"""Periods that are drawn: of slow waves, and otherwise."""
SLOW = 0.06
"""A drift in one period below which waves nearly lie on each other."""


def motion_traces(
    closed: ClosedForm,
    titles: Mapping[str, str] | None = None,
    notes: Mapping[str, str] | None = None,
    periods: float | None = None,
    span: float = 20.0,
) -> tuple[SphereTrace, ...]:
    """One ``SphereTrace`` for each declared trace.

    titles, notes
        the name of a trace's longitude -> words above and below it.
    periods
        how much is drawn; by default ``shown_periods``.
    span
        the time that is drawn of a motion without a period.
    """
    found = []
    for number, trace in enumerate(closed.quadratures.traces):
        u, v = plain_name(trace.colatitude), plain_name(trace.longitude)
        times = _times(closed, shown_periods(closed, v) if periods is None else periods, span)
        values = closed.at(times, (u, v))
        axis = r"$\mathbf{z}$" if number == 0 else rf"$\mathbf{{z}}_{number}$"
        found.append(SphereTrace(
            values[u], values[v], times, title=(titles or {}).get(v, ""),
            note=(notes or {}).get(v, ""), axis=axis,
        ))  # fmt: skip
    return tuple(found)


def _times(closed: ClosedForm, periods: float, span: float) -> np.ndarray:
    if not np.isfinite(closed.period):
        return np.linspace(0.0, span, 8 * DENSE + 1)
    return np.linspace(0.0, periods * closed.period, int(DENSE * periods) + 1)


def shown_periods(closed: ClosedForm, longitude: str) -> int:
    """How many periods show what a trace is: all of a closed curve, or about one turn.

    Where the waves nearly lie on each other, more of them would only make a blot.
    """
    turn = closed.turns.get(longitude)
    if turn is None:
        return FEWEST
    if turn.fraction is not None and turn.fraction.denominator <= MOST:
        return int(turn.fraction.denominator)
    if abs(turn.advance) < SLOW:
        return FEW
    return int(np.clip(np.ceil(0.9 * 2 * np.pi / abs(turn.advance)), FEWEST, MOST))
