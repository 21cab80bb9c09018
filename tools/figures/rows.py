"""The table of speed: motions against honest peers at equal error."""

from __future__ import annotations

from collections.abc import Sequence

from figures import table
from figures.problems import BALL, Extent, around, auto_method
from figures.race import Race, Spread

ERRORS = (1e-6, 1e-9)
MOTIONS = {
    BALL: 1000.0,
    "Demchenko's ball": 1000.0,
    "rattleback": 200.0,
    "Chaplygin's ball": 100.0,
    "chain of seven bodies": 20.0,
}
"""The problems, and how long they are followed.  The bicycle is none: SymPy takes minutes to print
what peers compile for it."""
COLUMNS: dict[str, Sequence[str]] = {
    "heyoka by hand": ("heyoka-by-hand",),
    "DOP853 in numba": (
        "dop853-numba-by-hand", "dop853-numba-fastmath", "dop853-numba-ours", "dop853-numba",
    ),
    "scipy's DOP853, `lambdify`": (
        "dop853-by-hand", "dop853-lambdify-invariants", "dop853-lambdify-coordinates",
    ),
    "MuJoCo": ("mujoco-best",),
}  # fmt: skip
"""Columns of the table: of several peers the fastest counts."""


def peers_table(extent: Extent) -> str:
    """Milliseconds of a run by ``integrate`` and by the peers, and how many times ours theirs is.

    Raises ``DefinitionError`` where a motion cannot be derived or has no reference.
    """
    head = ("motion", "error", "method", "running", "whole call", *COLUMNS)
    lines = [line for name in MOTIONS for line in _lines(name, extent)]
    return table.markdown(head, lines)


def _lines(name: str, extent: Extent) -> list[tuple[str, ...]]:
    """The rows of one motion, an error each."""
    span = MOTIONS[name] * extent.spans
    method = auto_method(name, span)
    peers = [peer for peers in COLUMNS.values() for peer in peers]
    found = around(name, [method, *peers], ERRORS, span, extent.rounds)
    lines = []
    for error in ERRORS:
        ours = found.at(method, error)
        whole = found.at(method, error, "whole")
        theirs = [_fastest(found, peers, error) for peers in COLUMNS.values()]
        cells = [_cell(one, ours) for one in theirs]
        motion = f"{name}, T = {span:g}"
        lines.append((motion, f"{error:g}", method, _milli(ours), _milli(whole), *cells))
    return lines


def _fastest(found: Race, peers: Sequence[str], error: float) -> Spread:
    """Of several peers the one that takes the least time."""
    mujoco = "mujoco-best" in peers
    spreads = [found.at(peer, error, extrapolate=mujoco) for peer in peers]
    return min((s for s in spreads if s.values), key=lambda s: s.median, default=Spread(()))


def _milli(spread: Spread) -> str:
    return f"{1e3 * spread.median:.3g} ms" if spread.values else "not reached"


def _cell(theirs: Spread, ours: Spread) -> str:
    """A peer's time, and how many times ours it is; empty where it does not take part."""
    if not theirs.values:
        return ""
    return f"{_milli(theirs)}: {theirs.over(ours).times()}" if ours.values else _milli(theirs)
