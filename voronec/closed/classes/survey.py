"""The classes of very many motions at once, as far as bounded doubles prove them.

With x = middle + half cos(psi) and f = (end - x)(x - start) g(x),

    drift = integral over 0 <= psi <= 2 pi of rate(x)/sqrt(g(x)),

of a function that is analytic and periodic: sums over n equal steps are wrong by no more than
4 pi max|integrand| / (exp(n a) - 1), the maximum over the strip |Im psi| <= a.

Roots of many polynomials at once are each in a disc that is proved to hold it: for approximations
z_i of the roots of a polynomial with leading coefficient a and degree n, the discs about z_i of
radius n |p(z_i)/(a prod_{j != i} (z_i - z_j))| hold all roots, and as many of them as discs where
some hang together (B. T. Smith's form of Gerschgorin's theorem).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed.classes.error_bounds import UNIT, BoundedNumber, compile_with_bounds
from voronec.closed.classes.trace_classes import (
    Curve,
    DeclaredTraces,
    declared_traces,
    label_trace,
    tally,
)
from voronec.closed.closed_form import ClosedForm
from voronec.closed.compiled_motion import prepare
from voronec.closed.problem import InversionProblem
from voronec.declaration.system import System
from voronec.errors import DefinitionError, EngineLimit, did_you_mean

STEPS = (16, 48, 160, 640)
"""Steps over half a turn; the next only for what the one before leaves open."""
SHARE = 0.75
"""How much of the strip is used that is free of singularities."""


@dataclass(frozen=True)
class Path:
    """Many motions between two roots of their f.

    ``lower``, ``upper``: the ends; ``lead``: of f; ``roots``: the discs of all roots, of which
    ``ends`` (n, 2) are the columns of the two ends; ``phi``, ``cosine``: of the trace.
    """

    lower: BoundedNumber
    upper: BoundedNumber
    lead: BoundedNumber
    roots: Discs
    ends: np.ndarray
    phi: tuple[BoundedNumber, ...]
    cosine: tuple[BoundedNumber, BoundedNumber]

    def take(self, chosen: Any) -> Path:
        """Some of the motions."""
        roots = Discs(self.roots.centre[chosen], self.roots.radius[chosen], self.roots.kind[chosen])
        return Path(
            self.lower.take(chosen), self.upper.take(chosen), self.lead.take(chosen), roots,
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


def drifts(path: Path, steps: Sequence[int] = STEPS) -> tuple[BoundedNumber, BoundedNumber]:
    """Drift of the longitude and period of every motion; wider the nearer to a separatrix."""
    count = len(path.ends)
    bounds = [(np.zeros(count), np.full(count, np.inf)) for _ in range(2)]
    left = np.arange(count)
    for n in steps:
        if not len(left):
            break
        for (mid, err), part in zip(bounds, _sums(path.take(left), n), strict=True):
            mid[left], err[left] = part.mid, part.err
        left = left[(np.abs(bounds[0][0]) <= bounds[0][1])[left]]
    return BoundedNumber(*bounds[0]), BoundedNumber(*bounds[1])


def _sums(path: Path, n: int) -> tuple[BoundedNumber, BoundedNumber]:
    others = path.others
    centre = np.take_along_axis(path.roots.centre, others, axis=1)
    radius = np.take_along_axis(path.roots.radius, others, axis=1)
    middle, half = (path.lower + path.upper) * 0.5, (path.upper - path.lower) * 0.5
    angles = (np.arange(n) + 0.5) * (np.pi / n)
    waves = BoundedNumber(np.cos(angles)[None, :], np.full((1, n), 2.0**-50))
    x = _column(middle) + _column(half) * waves
    g = -_column(path.lead)
    for k in range(centre.shape[1]):
        g = g * _away(x, centre[:, k], radius[:, k])
    pace = 1 / g.sqrt()
    cosine = _column(path.cosine[0]) + _column(path.cosine[1]) * x
    rate = _horner([_column(p) for p in path.phi], x) / ((1 - cosine) * (1 + cosine))
    bounds = _beyond(path, centre, radius, 2 * n)
    return _total(rate * pace, bounds[0], n), _total(pace, bounds[1], n)


def _total(values: BoundedNumber, bound: Any, n: int) -> BoundedNumber:
    step = 2 * np.pi / n
    mid = np.nan_to_num(values.mid.sum(axis=1) * step)
    err = (values.err.sum(axis=1) + n * UNIT * np.abs(values.mid).sum(axis=1)) * step
    err = np.where(np.isfinite(err) & np.isfinite(bound), err * (1 + n * UNIT) + bound, np.inf)
    return BoundedNumber(mid, err + 4 * UNIT * np.abs(mid))


def _column(value: BoundedNumber) -> BoundedNumber:
    return BoundedNumber(value.mid[:, None], value.err[:, None])


def _horner(coefficients: Sequence[BoundedNumber], x: BoundedNumber) -> BoundedNumber:
    total = coefficients[-1]
    for c in coefficients[-2::-1]:
        total = total * x + c
    return total


def _away(x: BoundedNumber, centre: np.ndarray, radius: np.ndarray) -> BoundedNumber:
    """x - c for a real root c; for a pair of complex ones both factors at the first, none at the
    second."""
    straight = x - _column(BoundedNumber(centre.real, radius))
    height = _column(BoundedNumber(centre.imag, radius))
    pair = straight * straight + height * height
    real, first = (centre.imag == 0)[:, None], (centre.imag > 0)[:, None]
    mid = np.where(real, straight.mid, np.where(first, pair.mid, 1.0))
    return BoundedNumber(mid, np.where(real, straight.err, np.where(first, pair.err, 0.0)))


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
        lead = np.abs(path.lead.mid) - path.lead.err
        pace = 1 / np.sqrt(lead * np.prod(room[: len(roots)], axis=0))
        farthest = np.maximum(np.abs(low.mid), np.abs(high.mid)) + wide * inside
        size = sum(p.size * farthest**k for k, p in enumerate(path.phi))
        steep = np.maximum(np.abs(slope.mid) - slope.err, 0) ** 2
        rate = size / (steep * np.prod(room[len(roots) :], axis=0))
        fall = 4 * np.pi * (1 + 1e-9) / np.expm1(n * strip)
    return rate * pace * fall, pace * fall


NO_VERDICT = "undecided"
"""The label of a motion on which algebra has no verdict."""


def classify_many(
    system: System,
    parameters: Mapping[Any, Any],
    initial: Mapping[Any, Any],
    trace: str | None = None,
) -> Survey:
    """The class of every one of n motions on one sphere, the first unless told.

    ``parameters`` and ``initial`` give arrays or numbers by name or symbol, used as the doubles
    they are; what is not given is the parameter's default, and 0 at the start.
    """
    surveyed = survey(system, parameters, initial, trace)
    values = arrays(declared_traces(system), parameters, initial)
    labels, reversals = surveyed.labels.astype(object), surveyed.reversals.copy()
    for i in surveyed.open:
        label, turns = _exact_label(system, [row[i] for row in values], trace)
        labels[i] = label
        reversals[i] = turns
    return replace(surveyed, labels=labels, reversals=reversals)


def _exact_label(system: System, row: list[Any], trace: str | None) -> tuple[str, int]:
    """Label and number of reversals of one motion."""
    known = declared_traces(system)
    curve = known.curve(trace)
    values = dict(zip(known.inputs, map(float, row), strict=True))
    closed = ClosedForm(InversionProblem(prepare(system, values), values))
    try:
        counts = tally(closed.problem, curve)
        if counts is None:
            return "parallel", 0
        label = label_trace(closed, curve, counts)
    except EngineLimit:
        return NO_VERDICT, -1
    return label, sum(times % 2 for _, times in counts.inner)


LOOPS = ("A", "B", "C")
CHUNK = 20_000
"""Motions that are classified at once: their arrays stay within some megabytes."""


@dataclass(frozen=True)
class Survey:
    """Traces of n motions on one sphere, each array (n,).

    labels
        the class; empty where doubles do not decide it.
    reversals
        roots of phi strictly between the ends; -1 where open.
    lower, upper
        cosines of the parallels, approximately; nan where open.
    drift, period
        of the longitude in a period, and the period, approximately; nan where not asked for.
    """

    labels: np.ndarray
    reversals: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    drift: np.ndarray
    period: np.ndarray

    @classmethod
    def blank(cls, count: int) -> Survey:
        """Of so many motions, all of them open."""
        unknown = (np.full(count, np.nan) for _ in range(4))
        return cls(np.full(count, "", dtype="U8"), np.full(count, -1), *unknown)

    @property
    def open(self) -> np.ndarray:
        """Which motions have no class yet."""
        return np.nonzero(self.labels == "")[0]


def survey(
    system: System,
    parameters: Mapping[Any, Any],
    initial: Mapping[Any, Any],
    trace: str | None = None,
    every_drift: bool = False,
) -> Survey:
    """Classes A, B, C1, C2, "parallel" and "point" of many motions, as far as doubles prove them.

    ``parameters`` and ``initial`` give arrays or numbers by name or symbol; what is not given is
    the parameter's default, and 0 at the start.  With ``every_drift`` drift and period are there
    for all motions, not only where the class depends on them.
    """
    known = declared_traces(system)
    values = arrays(known, parameters, initial)
    count = len(values[0])
    with np.errstate(all="ignore"):  # what is not finite is left open
        parts = [
            _survey(known, known.curve(trace), [v[i : i + CHUNK] for v in values], every_drift)
            for i in range(0, count, CHUNK)
        ]
    names = Survey.__dataclass_fields__
    return Survey(**{n: np.concatenate([getattr(p, n) for p in parts]) for n in names})


def arrays(
    known: DeclaredTraces, parameters: Mapping[Any, Any], initial: Mapping[Any, Any]
) -> list[np.ndarray]:
    """Arrays of one length for every symbol of a start."""
    given = {plain_name(k): v for k, v in {**parameters, **initial}.items()}
    names = [plain_name(s) for s in known.inputs]
    for name in given:
        if name not in names:
            raise DefinitionError(f"there is no '{name}'{did_you_mean(name, names)}")
    usual = {p.name: p.value for p in known.system.parameters}
    rows = [np.atleast_1d(np.asarray(given.get(n, usual.get(n, 0)), dtype=float)) for n in names]
    count = max(map(len, rows))
    return [np.broadcast_to(row, count).copy() for row in rows]


@dataclass(frozen=True)
class _TraceFunctions:
    initial_values: Callable[..., list[BoundedNumber]]
    level: Callable[..., list[BoundedNumber]]


def _formulas(known: DeclaredTraces, curve: Curve) -> _TraceFunctions:
    values = (*known.quartic, *curve.cosine, *curve.phi)
    return _TraceFunctions(
        compile_with_bounds(known.inputs, known.initial_values),
        compile_with_bounds(known.level, values),
    )


def _survey(
    known: DeclaredTraces, curve: Curve, values: list[np.ndarray], every_drift: bool
) -> Survey:
    formulas = known.memo.once(("in bounds", curve), lambda: _formulas(known, curve))
    parameters = values[len(values) - len(known.system.parameters) :]
    *constants, place, rate = formulas.initial_values(*values)
    raw = formulas.level(*parameters, *constants)
    count = len(values[0])
    numbers = [_fill(e, count) for e in (*raw, place, rate)]
    quartic, cosine, phi = numbers[:5], numbers[5:7], numbers[7:-2]
    surveyed = Survey.blank(count)
    heights, steps = degrees(quartic), degrees(phi)
    for height, step in {*zip(heights.tolist(), steps.tolist(), strict=True)}:
        chosen = np.nonzero((heights == height) & (steps == step))[0]
        if height < 2 or step < -1:
            continue
        group = _Group(
            [c.take(chosen) for c in quartic[: height + 1]],
            [c.take(chosen) for c in phi[: step + 1]],
            (cosine[0].take(chosen), cosine[1].take(chosen)),
            numbers[-2].take(chosen), numbers[-1].take(chosen),
        )  # fmt: skip
        group.enter(surveyed, chosen, every_drift)
    return surveyed


def _fill(value: BoundedNumber, count: int) -> BoundedNumber:
    mid, err = (np.broadcast_to(np.asarray(a, dtype=float), count) for a in (value.mid, value.err))
    good = np.isfinite(mid) & np.isfinite(err)
    return BoundedNumber(np.where(good, mid, 0.0), np.where(good, err, np.inf))


@dataclass(frozen=True)
class _Group:
    """Motions whose f have one degree, and whose phi have one."""

    quartic: list[BoundedNumber]
    phi: list[BoundedNumber]
    cosine: tuple[BoundedNumber, BoundedNumber]
    place: BoundedNumber
    rate: BoundedNumber

    def enter(self, found: Survey, rows: np.ndarray, every_drift: bool) -> None:
        """Write what is certain into some rows of a survey."""
        roots = discs(self.quartic)
        ends, good = _ends(roots, self.place, self.rate, self.quartic[-1])
        low, high = (_end(roots, ends[:, i]) for i in (0, 1))
        offset, slope = self.cosine
        edges = [offset + slope * e for e in (low, high)]
        tilt = slope.sign
        inside, counted = self._inside(low, high)
        flat = slope.zero & good
        free = good & (tilt != 0) & counted & self._off_poles(low, high)
        labels = np.where(flat, "parallel" if self.phi else "point", "")
        labels = np.where(free, np.array([*LOOPS, "", ""])[np.minimum(inside, 3)], labels)
        if not self.phi:
            labels = np.where(free, "", labels)  # a meridian: left to the exact route
        asked = np.nonzero(good & (tilt != 0) if every_drift else free & (labels == "C"))[0]
        if len(asked) and self.phi:
            path = Path(low, high, self.quartic[-1], roots, ends, tuple(self.phi), self.cosine)
            drift, period = drifts(path.take(asked))
            sign = np.array(["", "1", "2"])[drift.sign]
            named = np.where(drift.sign == 0, "", np.char.add("C", sign))
            labels = labels.astype("U8")
            loops = labels[asked] == "C"
            labels[asked] = np.where(loops, named, labels[asked])
            # at cusps and poles the bound is infinite, and the number is good all the same
            found.drift[rows[asked]], found.period[rows[asked]] = drift.mid, period.mid
        found.labels[rows] = labels
        found.reversals[rows] = np.where(free, inside, -1)
        both = np.sort([e.mid for e in edges], axis=0)
        found.lower[rows], found.upper[rows] = np.where(good, both, np.nan)

    def _inside(self, low: BoundedNumber, high: BoundedNumber) -> tuple[np.ndarray, np.ndarray]:
        """How many roots phi has between the ends, and where that is certain."""
        count = len(low.mid)
        if not self.phi:
            return np.zeros(count, dtype=int), np.ones(count, dtype=bool)
        roots = discs(self.phi)
        real, radius = np.nan_to_num(roots.real), roots.radius * (1 + 4 * UNIT)
        left, right = real - radius, real + radius
        below, above = (low.mid + low.err)[:, None], (high.mid - high.err)[:, None]
        inside = (left > below) & (right < above)
        outside = (right < (low.mid - low.err)[:, None]) | (left > (high.mid + high.err)[:, None])
        straight = roots.kind == 1
        certain = np.all(~straight | inside | outside, axis=1) & roots.known
        return np.sum(straight & inside, axis=1), certain

    def _off_poles(self, low: BoundedNumber, high: BoundedNumber) -> np.ndarray:
        """Where neither end can be a pole of the sphere."""
        offset, slope = self.cosine
        clear = np.ones(len(low.mid), dtype=bool)
        for side in (1, -1):
            place = (side - offset) / slope
            for end in (low, high):
                clear &= (place - end).sign != 0
        return clear


def _end(roots: Discs, column: np.ndarray) -> BoundedNumber:
    pick = column[:, None]
    return BoundedNumber(np.take_along_axis(roots.centre, pick, axis=1)[:, 0].real,
                   np.take_along_axis(roots.radius, pick, axis=1)[:, 0])  # fmt: skip


def _ends(
    roots: Discs, place: BoundedNumber, rate: BoundedNumber, lead: BoundedNumber
) -> tuple[np.ndarray, np.ndarray]:
    """The columns of the roots between which x runs (n, 2), and where that is certain.

    At a turning point, where the rate is exactly zero, x is one of the roots itself, and f is
    positive on the side to which it goes.
    """
    real = roots.kind == 1
    centre, radius = roots.centre.real, roots.radius * (1 + 4 * UNIT)
    x, blur = place.mid[:, None], place.err[:, None] + UNIT * np.abs(place.mid[:, None])
    above, below = real & (centre - radius > x + blur), real & (centre + radius < x - blur)
    here = real & ~above & ~below
    upward = np.sign(lead.mid) * np.where(np.sum(above, axis=1) % 2, -1, 1) > 0
    start = np.sum(here, axis=1)
    moving = (rate.sign != 0) & (start == 0)
    turning = rate.zero & (start == 1)
    next_up = np.argmin(np.where(above, centre, np.inf), axis=1)
    next_down = np.argmax(np.where(below, centre, -np.inf), axis=1)
    current = np.argmax(here, axis=1)
    low = np.where(turning & upward, current, next_down)
    high = np.where(turning & ~upward, current, next_up)
    has_up, has_down = np.any(above, axis=1), np.any(below, axis=1)
    whole = np.where(turning, np.where(upward, has_up, has_down), has_up & has_down)
    return np.stack([low, high], axis=1), roots.known & (moving | turning) & whole


@dataclass(frozen=True)
class Discs:
    """Roots of n polynomials of one degree d, in rows: ``centre`` (complex) and ``radius``, (n, d).

    ``kind`` is 1 where the disc holds one root, a real one, and its centre is real; -1 where it
    does not meet the real axis; 0 where that is not known.
    """

    centre: np.ndarray
    radius: np.ndarray
    kind: np.ndarray

    @property
    def real(self) -> np.ndarray:
        """The real roots; nan in place of others."""
        return np.where(self.kind == 1, self.centre.real, np.nan)

    @property
    def known(self) -> np.ndarray:
        """Which polynomials have all their roots told apart."""
        return np.all(self.kind != 0, axis=1)


def degrees(coefficients: Sequence[BoundedNumber]) -> np.ndarray:
    """The degree of each polynomial, -1 of zero, -2 where that is not certain."""
    count = len(coefficients[0].mid)
    degree = np.full(count, -1)
    for power, c in enumerate(coefficients):
        degree = np.where(c.sign != 0, power, np.where(c.zero, degree, -2))
    return degree


def discs(coefficients: Sequence[BoundedNumber]) -> Discs:
    """The roots of polynomials whose leading coefficients are certainly not zero."""
    n = len(coefficients) - 1
    mids = np.stack([c.mid for c in coefficients], axis=1)
    errs = np.stack([c.err for c in coefficients], axis=1)
    if n == 0:
        empty = np.zeros((len(mids), 0))
        return Discs(empty.astype(complex), empty, empty.astype(int))
    centre = _weierstrass_correction(mids, _companion_eigenvalues(mids))
    radius = _radii(mids, errs, centre)
    # where a disc meets the real axis and is alone, so is the one about its projection
    near = np.abs(centre.imag) <= radius
    straight = np.where(near, centre.real, centre)
    wide = np.where(near, radius + np.abs(centre.imag), radius)
    apart = np.abs(straight[:, :, None] - straight[:, None, :])
    free = (apart > (wide[:, :, None] + wide[:, None, :]) * (1 + 4 * UNIT)) | np.eye(n, dtype=bool)
    alone = np.all(free, axis=2) & np.isfinite(wide)
    kind = np.where(near, np.where(alone, 1, 0), np.where(np.isfinite(wide), -1, 0))
    return Discs(straight.astype(complex), wide, kind)


def _companion_eigenvalues(mids: np.ndarray) -> np.ndarray:
    """Eigenvalues of the companion matrices."""
    n = mids.shape[1] - 1
    matrix = np.zeros((len(mids), n, n))
    matrix[:, :, n - 1] = -mids[:, :n] / mids[:, n:]
    if n > 1:
        matrix[:, np.arange(1, n), np.arange(n - 1)] = 1
    return np.linalg.eigvals(matrix).astype(complex)


def _weierstrass_correction(mids: np.ndarray, roots: np.ndarray) -> np.ndarray:
    """Two rounds of Weierstrass' correction: the eigenvalues are not quite as good as doubles."""
    for _ in range(2):
        step = _value(mids, roots) / (mids[:, -1:] * _products(roots))
        roots = roots - np.where(np.isfinite(step), step, 0)
    return roots


def _radii(mids: np.ndarray, errs: np.ndarray, roots: np.ndarray) -> np.ndarray:
    n = mids.shape[1] - 1
    size = np.abs(roots)
    rounding = 16 * (n + 2) * UNIT * _value(np.abs(mids), size) + _value(errs, size)
    value = np.abs(_value(mids, roots)) + rounding.real
    leading = np.abs(mids[:, -1:]) - errs[:, -1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = n * value * (1 + 64 * UNIT) / (leading * np.abs(_products(roots)))
    return np.where(np.isfinite(radius), radius, np.inf)


def _value(mids: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The polynomials at several places each."""
    total = np.zeros_like(at)
    for column in mids.T[::-1]:
        total = total * at + column[:, None]
    return total


def _products(roots: np.ndarray) -> Any:
    """prod over j != i of (z_i - z_j)."""
    apart = roots[:, :, None] - roots[:, None, :]
    diagonal = np.arange(roots.shape[1])
    apart[:, diagonal, diagonal] = 1
    products = np.prod(apart, axis=2)
    return np.where(products == 0, np.nan, products)
