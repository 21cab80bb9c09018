"""Methods compared at equal error: what each costs where its error is the one asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import exp, isfinite, log

__all__ = ["At", "at_error", "observed_order"]


@dataclass(frozen=True)
class At:
    """A cost at an error, and how it is known.

    ``kind`` is ``interpolated`` between two runs; ``at most`` where every run is better than asked,
    so that the cheapest is an upper bound; ``extrapolated`` along the observed order where no run
    is good enough and this was allowed; ``not reached``, with no ``seconds``, where it was not.
    """

    seconds: float | None
    kind: str


Pairs = Sequence[tuple[float, float]]
"""(error, seconds) of the runs of one method, from coarse to fine."""


def at_error(runs: Pairs, error: float, extrapolate: bool = False) -> At:
    """The cost of one method at an error, on straight lines between its runs in the logarithms.

    Never goes beyond the runs unless ``extrapolate`` is said, and then the answer says so.
    """
    known = [(e, s) for e, s in runs if isfinite(e) and isfinite(s) and e > 0 and s > 0]
    between = [
        _line(one, two, error) for one, two in pairwise(known) if _brackets(one[0], two[0], error)
    ]
    good = [s for e, s in known if e <= error]
    if between:
        # a run that is better and no dearer is an answer too
        return At(min([*between, *good]), "interpolated")
    if good:
        return At(min(good), "at most")
    order = observed_order(known)
    if extrapolate and order is not None:
        nearest = min(known)
        return At(nearest[1] * (nearest[0] / error) ** (1 / order), "extrapolated")
    return At(None, "not reached")


def observed_order(runs: Pairs) -> float | None:
    """p in error ~ cost^-p over the two best runs; None where it cannot be told."""
    ranked = sorted(runs)[:2]
    if len(ranked) < 2 or ranked[0][0] == ranked[1][0] or ranked[0][1] <= ranked[1][1]:
        return None
    (fine, dear), (coarse, cheap) = ranked
    return log(coarse / fine) / log(dear / cheap)


def _brackets(one: float, two: float, error: float) -> bool:
    return min(one, two) <= error <= max(one, two) and one != two


def _line(one: tuple[float, float], two: tuple[float, float], error: float) -> float:
    part = log(error / one[0]) / log(two[0] / one[0])
    return exp(log(one[1]) + part * log(two[1] / one[1]))
