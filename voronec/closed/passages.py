"""When the contact of a motion turned upright passes the two parallels through the fixed pole.

Seen from the constant vector K the fixed axis has the colatitude alpha <= pi/2 and the longitude
lambda, the contact c and lambda + phi.  Only within the caps c < alpha and c > pi - alpha do the
angles about the fixed axis wind otherwise than phi [Theory, eqs. (28), (29)].

Passages are counted by sums of floors of evenly growing numbers, exact in integers and certified
in balls.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, ctx

from voronec.closed.arithmetic import angle, ball
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.space import FrameProduct, product, rotation_to, times, transpose
from voronec.elliptic.roots import OpenDecision
from voronec.elliptic.theta_balls import moment_of
from voronec.errors import EngineLimit


def floor_sum(count: int, first: int, step: int, unit: int) -> int:
    """The sum of ``floor((first + j step)/unit)`` over j = 0, ..., count - 1.

    By Euclid's algorithm on step and unit, lattice points under a line: O(log count) steps.
    """
    total, more = 0, count
    while more > 0:
        whole, step = divmod(step, unit)
        total += whole * (more * (more - 1) // 2)
        whole, first = divmod(first, unit)
        total += whole * more
        # the points below the line, counted by rows: each row begins one column further
        more, first = divmod(step * more + first, unit)
        step, unit = unit, step
    return total


def certain_floor_sum(count: int, first: Any, step: Any) -> int | None:
    """The sum of ``floor(first + j step)`` over whole numbers j from 0 up to ``count``, which is
    left out; over those from ``count`` up to 0, negative, where ``count`` is negative.

    Both are balls; None where these leave a floor open.
    """
    low, high = bracketed_floor_sum(count, first, step)
    return low if low == high else None


def bracketed_floor_sum(count: int, first: Any, step: Any) -> tuple[int, int]:
    """The least and the greatest value that the sum may have: equal where every floor is sure."""
    if count < 0:
        low, high = bracketed_floor_sum(-count, first - step, -step)
        return -high, -low
    unit = 1 << ctx.prec
    begin, rise = scale_to_integers(first, ctx.prec), scale_to_integers(step, ctx.prec)
    low, high = (floor_sum(count, a, b, unit) for a, b in zip(begin, rise, strict=True))
    return low, high


def first_doubt(count: int, first: Any, step: Any) -> int:
    """The whole number j, nearest to 0, whose floor is not sure in such a sum."""
    if count < 0:
        return -1 - first_doubt(-count, first - step, -step)
    sure, unsure = 0, count
    while unsure - sure > 1:
        middle = (sure + unsure) // 2
        if certain_floor_sum(middle, first, step) is None:
            unsure = middle
        else:
            sure = middle
    return sure


def scale_to_integers(value: Any, bits: int) -> tuple[int, int]:
    """Whole numbers below and above a ball in units of ``2^-bits``."""
    (middle, power), (radius, least) = (
        map(int, part.man_exp()) for part in (value.mid(), value.rad())
    )
    shift = min(power, least, -bits)
    middle, radius, rest = middle << power - shift, radius << least - shift, -bits - shift
    return middle - radius >> rest, -(-middle - radius >> rest)


BITS = 64
"""Of the fraction of a phase: whole numbers of them wrap around by themselves."""
SPARSE = 2000
"""So many periods are looked at, one after the other, in the time that one sum over them takes."""
MOST_TURNS = 1 << 46
"""In a period: so many leave doubles the digits that tell whole turns."""
CHUNK = 1 << 20
"""Periods that are looked at at once."""


@dataclass(frozen=True)
class CapTally:
    """States of a motion with respect to the caps, and the state at each time.

    Attributes:
        state: of each time, its number.
        near, far: of each state: whether the contact is in that cap.
        first, last: of each state: whole turns that phi has gained in the near cap and in the far
            one, up to constants.
    """

    state: np.ndarray
    near: np.ndarray
    far: np.ndarray
    first: np.ndarray
    last: np.ndarray


def tally(winding: Any, level: CapPassages, times: np.ndarray) -> CapTally:
    """The states at times.

    Raises:
        OpenDecision: more bits are needed.
    """
    count = len(level.passages)
    if level.period is None:
        moments = [float(p.time.mid()) for p in level.passages]
        state = np.searchsorted(moments, times, side="right")
        numbers = [[1] * k + [0] * (count - k) for k in range(count + 1)]
        return _tally_states(winding, level, state, numbers)
    if not count:
        return _tally_states(winding, level, np.zeros(times.size, dtype=np.intp), [[]])
    period = float(level.period.mid())
    begin = level.passages[0].time
    windows = np.floor((times - float(begin.mid())) / period)
    rest = times - float(begin.mid()) - windows * period
    state = np.zeros(times.size, dtype=np.intp)
    for passage in level.passages[1:]:
        state += rest >= float((passage.time - begin).mid())
    low, high = (int(e) for e in (windows.min(initial=0), windows.max(initial=0)))
    if high - low <= max(SPARSE, times.size):
        kinds, places = np.arange(low, high + 1), windows.astype(np.intp) - low
    else:
        kinds, places = np.unique(windows.astype(np.int64), return_inverse=True)
    state += count * places.ravel()
    return _periodic(winding, level, state, kinds)


def _tally_states(
    winding: Any, level: CapPassages, state: np.ndarray, numbers: Sequence[Sequence[int]]
) -> CapTally:
    """Each state by itself, from how many passages of each kind there have been."""
    inside = [level.inside(row) for row in numbers]
    gained = [winding.gain(level, row) for row in numbers]
    near, far = (np.array(column) for column in zip(*inside, strict=True))
    first, last = (np.array(column, dtype=float) for column in zip(*gained, strict=True))
    return CapTally(state, near, far, first, last)


def _periodic(winding: Any, level: CapPassages, state: np.ndarray, kinds: np.ndarray) -> CapTally:
    """A state between each passage and the next, in each of the periods ``kinds``."""
    count = len(level.passages)
    before = _before(winding, level, kinds)
    sums = [
        (total + np.cumsum(steps, axis=0)).T.ravel().astype(float)
        for total, steps in zip(before, _steps(winding, level, kinds), strict=True)
    ]
    inside = [level.inside([1] * (k + 1) + [0] * (count - k - 1)) for k in range(count)]
    near, far = (np.tile(column, len(kinds)) for column in zip(*inside, strict=True))
    return CapTally(state, near, far, *sums)


def _steps(winding: Any, level: CapPassages, kinds: np.ndarray) -> list[np.ndarray]:
    """What is gained at each passage of these periods: in the near cap, and in the far one."""
    steps = np.array([p.way * _floors(p, level, kinds, winding) for p in level.passages])
    far = np.array([p.far for p in level.passages])[:, None]
    return [np.where(far, 0, steps), np.where(far, steps, 0)]


def _before(winding: Any, level: CapPassages, kinds: np.ndarray) -> np.ndarray:
    """What has been gained before each of the periods, which ascend: in both caps."""
    count, gains = len(level.passages), []
    for part in np.split(kinds, np.flatnonzero(np.diff(kinds // CHUNK)) + 1):
        first, last = int(part[0]), int(part[-1])
        if last - first > SPARSE * len(part):
            sums = [winding.gain(level, [int(j)] * count) for j in part]
            gains.append(np.array(sums, dtype=np.int64).T)
            continue
        start = winding.gain(level, [first] * count)
        steps = _steps(winding, level, np.arange(first, last))
        rows = [np.cumsum([s, *step.sum(axis=0)]) for s, step in zip(start, steps, strict=True)]
        gains.append(np.array(rows)[:, part - first])
    return np.concatenate(gains, axis=1)


def _floors(passage: CapPassage, level: CapPassages, kinds: np.ndarray, winding: Any) -> np.ndarray:
    """``floor(phase + j advance)``, exactly: in whole numbers of 2^-64, and in balls where that
    leaves it open."""
    one = 1 << BITS
    (first, start), (step, rise) = (
        divmod(scale_to_integers(value, BITS)[0], one) for value in (passage.phase, level.advance)
    )
    if max(abs(first), abs(step)) > MOST_TURNS:
        raise EngineLimit(
            "angles make too many turns between passages of poles to be counted in doubles; "
            "ask for them modulo a turn, or enclose one instant"
        )
    fraction = np.uint64(start) + kinds.astype(np.uint64) * np.uint64(rise)
    carried = (start + kinds * float(rise)) / one - fraction / one
    floors = first + kinds * step + np.rint(carried).astype(np.int64)
    error = (np.abs(kinds) + 2).astype(np.uint64)
    for place in np.flatnonzero((fraction < error) | (~fraction < error)):
        j = int(kinds[place])
        sure = certain_floor_sum(1, passage.phase + j * level.advance, arb(0))
        if sure is None:
            raise OpenDecision(winding.pole(level, passage, j))
        floors[place] = sure
    return np.asarray(floors)


MOST_BITS = 2048
"""Bits at which a turning point that cannot be told from the border of a cap is taken for one
that touches it: it leaves the turns open only where it is the pole too."""


@dataclass(frozen=True)
class CapPassage:
    """Of the border of a cap, again in each period.

    Attributes:
        time: of the first.
        phase: phi there in turns; at the far cap half a turn more.
        far: whether the cap is c > pi - alpha.
        way: 1 out of the cap, -1 into it.
    """

    time: arb
    phase: arb
    far: bool
    way: int


@dataclass(frozen=True)
class CapPassages:
    """Of one motion, at one precision.

    Attributes:
        side: 1, or -1 where K points downwards: all angles are then those about -K.
        longitude: lambda.
        rate: of the longitude of the contact where the variable rests.
        start: of such a motion, the longitude about K, and the angle about the contact's normal.
        period: None where there is none.
        advance: of phi in a period, in turns.
        passages: in the order of time.
        near: whether the contact is in c < alpha before the first of them.
        far: whether it is in c > pi - alpha.
        borders: where it stays on a parallel through the pole: 0 for that of the near cap, 1/2
            for that of the far one.
    """

    side: int
    longitude: arb
    period: arb | None
    advance: arb
    passages: tuple[CapPassage, ...]
    near: bool
    far: bool
    borders: tuple[arb, ...]
    start: tuple[arb, arb] | None = None
    rate: Any = None

    def inside(self, numbers: Sequence[int]) -> tuple[bool, bool]:
        """Whether the contact is in the near cap, and in the far one, when so many passages of
        each kind have been."""
        flags = [int(self.near), int(self.far)]
        for passage, number in zip(self.passages, numbers, strict=True):
            flags[passage.far] -= passage.way * number
        return flags[0] > 0, flags[1] > 0

    def numbers(self, time: arb) -> list[int]:
        """How many passages of each kind there have been since the first, that one with them;
        those that are missing before it count negative.  Near a passage either number will do."""
        if self.period is None:
            return [int(time.mid() >= p.time.mid()) for p in self.passages]
        return [1 + floor((time - p.time) / self.period) for p in self.passages]


def moving_passages(form: InvertedMotion, parts: FrameProduct, bits: int) -> CapPassages:
    """Those of a motion whose variable moves.

    Raises:
        OpenDecision: more bits are needed.
    """
    attitude = form.attitude
    assert attitude is not None
    side, height, longitude = _pole(attitude.turn(bits), 1 if attitude.upper else -1)
    constants = form.solution.constants(bits)
    offset, slope = _cosine(form, parts, bits)
    ends = [side * (offset + slope * x) for x in (constants.base, constants.other)]
    j = form.quadratures.angles.index(parts.longitude)
    begin = form.begin(bits)[j]

    def phase(time: arb, half: int) -> arb:
        moved = moment_of(constants, time).expressions[j] - constants.starts[j]
        return (side * (begin + moved) - longitude) / (2 * arb.pi()) + arb(half) / 2

    passages: list[CapPassage] = []
    inside, borders = [], []
    for far in (False, True):
        level = -height if far else height
        signs = [_sign(level - e if far else e - level) for e in ends]
        for time, way in _times(form, constants, signs, (side * level - offset, slope), bits):
            passages.append(CapPassage(time, phase(time, far), far, way))
        # before the first of them the variable is beyond the other end, or at the first there is
        early = signs[0] if constants.kind == "exponential" else signs[1]
        inside.append((early or signs[0] or signs[1]) > 0)
        borders += [arb(far) / 2] * (signs == [0, 0])
    passages.sort(key=lambda p: (float(p.time.mid()), p.way))
    advances = constants.advances
    return CapPassages(
        side, longitude,
        None if constants.half is None else 2 * constants.half,
        arb(0) if advances is None else side * advances[j] / (2 * arb.pi()),
        tuple(passages), inside[0], inside[1], tuple(borders),
    )  # fmt: skip


def resting_passages(
    form: InvertedMotion, parts: FrameProduct, bits: int, upper: bool
) -> CapPassages:
    """Where the variable rests there are none: the frame turns evenly about its spin, of which
    ``upper`` says whether it points upwards.

    Raises:
        OpenDecision: more bits are needed, or the contact stays where it is.
    """
    attitude = form.attitude
    assert attitude is not None
    spin, frame = attitude.spin(bits), attitude.start(bits)[0]
    rate = sum((w * w for w in spin), ball(0)).nonnegative_part().sqrt()
    if not rate > 0:
        raise OpenDecision("the frame may be still")
    turn = rotation_to([e / rate for e in times(frame, spin)], upper)
    side, height, longitude = _pole(turn, 1 if upper else -1)
    upright = attitude.machines[1](product(transpose(turn), frame))
    values = dict(zip(attitude.coordinates, upright, strict=True))
    v, c, b = (values[q] for q in (parts.longitude, parts.colatitude, parts.third))
    if not c.sin() > 0:
        raise OpenDecision("the frame may turn about the normal of the contact alone")
    signs = [_sign(gap) for gap in (side * c.cos() - height, -height - side * c.cos())]
    borders = tuple(arb(far) / 2 for far, sign in enumerate(signs) if sign == 0)
    return CapPassages(
        side, longitude, None, arb(0), (), signs[0] > 0, signs[1] > 0, borders, (v, b), rate
    )


def _pole(turn: list[Any], side: int) -> tuple[int, arb, arb]:
    """Where the fixed axis is seen, from K or from -K: side, cosine of alpha, and lambda."""
    return side, side * turn[8], angle(side * turn[7], turn[6])


def _cosine(form: InvertedMotion, parts: FrameProduct, bits: int) -> tuple[arb, arb]:
    """Offset and slope of the cosine of the colatitude about K."""
    first = form.problem.prepared.cosine_at + 2 * parts.trace
    offset, slope = form.problem.table(bits)[first : first + 2]
    symbols = form.problem.prepared.cosines[parts.trace]
    if slope.contains(0) and (slope.is_zero() or form.sign(symbols[1]) == 0):
        slope = arb(0)
    return offset, slope


def _times(
    form: InvertedMotion, constants: Any, signs: list[int], line: tuple[arb, arb], bits: int
) -> Iterator[tuple[arb, int]]:
    """When the variable passes ``line[0]/line[1]``, and which way, out of a cap or into it, if
    ``signs`` say where its ends are; in one period."""
    lonely = constants.kind == "exponential"
    if signs[0] * signs[1] < 0:
        delay = form.solution.delay(line[0] / line[1], bits)
        yield constants.turn + delay, -signs[1]
        if not lonely:
            yield constants.turn - delay, signs[1]
    elif signs[0] == 0 != signs[1] and not lonely:
        yield from ((constants.turn, way) for way in (-1, 1))
    elif signs[1] == 0 != signs[0] and constants.half is not None:
        yield from ((constants.turn + constants.half, way) for way in (-1, 1))


def floor(value: arb) -> int:
    """Of the middle of a ball."""
    return int(value.mid().floor().unique_fmpz())


def _sign(value: arb) -> int:
    if value > 0 or value < 0:
        return 1 if value > 0 else -1
    if ctx.prec < MOST_BITS:
        raise OpenDecision("a turning point may lie on the border of a cap")
    return 0
