"""What many longitudes grow by in a period, with a proved bound of the error.

With x = middle + half cos(psi) and f = (end - x)(x - start) g(x),

    drift = integral over 0 <= psi <= 2 pi of rate(x)/sqrt(g(x)),

of a function that is analytic and periodic: sums over n equal steps are wrong by no more than
4 pi max|integrand| / (exp(n a) - 1), the maximum over the strip |Im psi| <= a.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from voronec.closed.classes.bounded import UNIT, Bounded
from voronec.closed.classes.discs import Discs

__all__ = ["Path", "drifts"]

STEPS = (16, 48, 160, 640)
"""Steps over half a turn; the next only for what the one before leaves open."""
SHARE = 0.75
"""How much of the strip is used that is free of singularities."""


@dataclass(frozen=True)
class Path:
    """Many motions between two roots of their f.

    ``lower``, ``upper``: the ends; ``leading``: of f; ``roots``: the discs of all roots, of which
    ``ends`` (n, 2) are the columns of the two ends; ``phi``, ``cosine``: of the trace.
    """

    lower: Bounded
    upper: Bounded
    leading: Bounded
    roots: Discs
    ends: np.ndarray
    phi: tuple[Bounded, ...]
    cosine: tuple[Bounded, Bounded]

    def take(self, chosen: Any) -> Path:
        """Some of the motions."""
        roots = Discs(self.roots.centre[chosen], self.roots.radius[chosen], self.roots.kind[chosen])
        return Path(
            self.lower.take(chosen), self.upper.take(chosen), self.leading.take(chosen), roots,
            self.ends[chosen], tuple(p.take(chosen) for p in self.phi),
            (self.cosine[0].take(chosen), self.cosine[1].take(chosen)),
        )  # fmt: skip

    @property
    def others(self) -> np.ndarray:
        """The columns of the roots that are no ends, (n, degree - 2)."""
        count = self.roots.centre.shape[1]
        free = np.ones((len(self.ends), count), dtype=bool)
        np.put_along_axis(free, self.ends, False, axis=1)
        return np.nonzero(free)[1].reshape(len(self.ends), count - 2)


def drifts(path: Path, steps: Sequence[int] = STEPS) -> tuple[Bounded, Bounded]:
    """Drift of the longitude and period of every motion; wider the nearer to a separatrix."""
    count = len(path.ends)
    found = [(np.zeros(count), np.full(count, np.inf)) for _ in range(2)]
    left = np.arange(count)
    for n in steps:
        if not len(left):
            break
        for (mid, err), part in zip(found, _sums(path.take(left), n), strict=True):
            mid[left], err[left] = part.mid, part.err
        left = left[(np.abs(found[0][0]) <= found[0][1])[left]]
    return Bounded(*found[0]), Bounded(*found[1])


def _sums(path: Path, n: int) -> tuple[Bounded, Bounded]:
    others = path.others
    centre = np.take_along_axis(path.roots.centre, others, axis=1)
    radius = np.take_along_axis(path.roots.radius, others, axis=1)
    middle, half = (path.lower + path.upper) * 0.5, (path.upper - path.lower) * 0.5
    angles = (np.arange(n) + 0.5) * (np.pi / n)
    waves = Bounded(np.cos(angles)[None, :], np.full((1, n), 2.0**-50))
    x = _column(middle) + _column(half) * waves
    g = -_column(path.leading)
    for k in range(centre.shape[1]):
        g = g * _away(x, centre[:, k], radius[:, k])
    pace = 1 / g.sqrt()
    cosine = _column(path.cosine[0]) + _column(path.cosine[1]) * x
    rate = _horner([_column(p) for p in path.phi], x) / ((1 - cosine) * (1 + cosine))
    bounds = _beyond(path, centre, radius, 2 * n)
    return _total(rate * pace, bounds[0], n), _total(pace, bounds[1], n)


def _total(values: Bounded, bound: Any, n: int) -> Bounded:
    step = 2 * np.pi / n
    mid = np.nan_to_num(values.mid.sum(axis=1) * step)
    err = (values.err.sum(axis=1) + n * UNIT * np.abs(values.mid).sum(axis=1)) * step
    err = np.where(np.isfinite(err) & np.isfinite(bound), err * (1 + n * UNIT) + bound, np.inf)
    return Bounded(mid, err + 4 * UNIT * np.abs(mid))


def _column(value: Bounded) -> Bounded:
    return Bounded(value.mid[:, None], value.err[:, None])


def _horner(coefficients: Sequence[Bounded], x: Bounded) -> Bounded:
    total = coefficients[-1]
    for c in coefficients[-2::-1]:
        total = total * x + c
    return total


def _away(x: Bounded, centre: np.ndarray, radius: np.ndarray) -> Bounded:
    """x - c for a real root c; for a pair of complex ones both factors at the first, none at the
    second."""
    straight = x - _column(Bounded(centre.real, radius))
    height = _column(Bounded(centre.imag, radius))
    pair = straight * straight + height * height
    real, first = (centre.imag == 0)[:, None], (centre.imag > 0)[:, None]
    mid = np.where(real, straight.mid, np.where(first, pair.mid, 1.0))
    return Bounded(mid, np.where(real, straight.err, np.where(first, pair.err, 0.0)))


def _beyond(path: Path, centre: np.ndarray, radius: np.ndarray, n: int) -> tuple[Any, Any]:
    """What the sums over n steps of a whole turn may be wrong by: of the drift, of the period.

    In the strip |x - c| >= half (cosh(a_c) - cosh(a)), where cosh(a_c) is half the sum of the
    distances of c from the ends, in units of half.
    """
    low, high = path.lower, path.upper
    half = (high.mid - low.mid) / 2 - (low.err + high.err)
    wide = (high.mid - low.mid) / 2 + (low.err + high.err)
    offset, slope = path.cosine

    def reach(c: Any, error: Any) -> Any:
        apart = np.abs(c - low.mid) + np.abs(c - high.mid)
        error = 2 * error + 2 * low.err + 2 * high.err + 8 * UNIT * (np.abs(c) + apart)
        return np.maximum((apart - error) / (2 * wide), 1.0)

    roots = [reach(centre[:, k], radius[:, k]) for k in range(centre.shape[1])]
    edges = [(side - offset) / slope for side in (1, -1)]
    poles = [reach(c.mid, c.err) for c in edges]
    nearest = np.min([*roots, *poles], axis=0)
    strip = np.minimum(SHARE * np.arccosh(nearest), 3.0)
    inside = np.cosh(strip)
    room = [half * (c - inside) * (1 - 1e-9) for c in (*roots, *poles)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        lead = np.abs(path.leading.mid) - path.leading.err
        pace = 1 / np.sqrt(lead * np.prod(room[: len(roots)], axis=0))
        farthest = np.maximum(np.abs(low.mid), np.abs(high.mid)) + wide * inside
        size = sum(p.size * farthest**k for k, p in enumerate(path.phi))
        steep = np.maximum(np.abs(slope.mid) - slope.err, 0) ** 2
        rate = size / (steep * np.prod(room[len(roots) :], axis=0))
        fall = 4 * np.pi * (1 + 1e-9) / np.expm1(n * strip)
    return rate * pace * fall, pace * fall
