"""Whole turns of coordinates in space, for any direction of the constant vector and without a grid.

A coordinate read off the frame is known up to whole turns.  Beside it stands another angle, which
is continuous, known at every time, and never more than a quarter of a turn away: phi or nothing,
less the whole turns that phi gains while the contact is within a cap around the fixed pole
[Theory, eqs. (28), (29), (30)].  Over N periods these are sums of N floors of numbers that grow
evenly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from flint import arb, ctx

from voronec.algebra.memo import remember
from voronec.algebra.symbols import plain_name
from voronec.closed.arithmetic import precise
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.passages import (
    MOST_BITS,
    CapPassage,
    CapPassages,
    CapTally,
    certain_floor_sum,
    first_doubt,
    floor,
    moving_passages,
    resting_passages,
    tally,
)
from voronec.closed.space import FrameProduct, composition, transpose
from voronec.closed.space import times as rotated
from voronec.elliptic.many_times import Sample
from voronec.elliptic.roots import OpenDecision
from voronec.errors import EngineLimit

FIRST, MOST = 192, 1 << 12
"""Bits at which turns are counted, at first and at most."""
SURE = 0.49
"""A number that lies so near to a whole one is meant to be it."""
SHARP = 2.0**-72
"""Errors of phases, in turns, that are well below those of whole numbers of 2^-64."""
ROUGH = 1e-9
"""Of doubles that are phases, in turns; what is nearer to a pole is evaluated in balls."""
HALVINGS = 80
"""More than a double has digits, over any span."""
TURN = 2 * np.pi

Value = TypeVar("Value")
Angles = tuple[arb, arb]
"""Longitude and third angle."""
Turns = tuple[int, int]
Rows = Mapping[Any, np.ndarray]


class NoWholeTurns(EngineLimit):
    """Angles have no number of whole turns: a pole of their coordinates is passed.

    ``names`` are theirs; ``time``, since the start, is that of the passage.
    """

    def __init__(self, names: Sequence[Any], time: float | None) -> None:
        self.names, self.time = tuple(names), time
        super().__init__(f"{turnless_message(names, time)}; ask for them modulo a turn")

    def __reduce__(self) -> Any:
        return type(self), (self.names, self.time)


def turnless_message(names: Sequence[Any], time: float | None, start: float = 0.0) -> str:
    """That angles have no number of whole turns beyond an instant, counted from the start."""
    text = " and ".join(map(plain_name, names))
    have = "have" if len(names) > 1 else "has"
    if time is None:
        return f"{text} {have} no number of whole turns that can be told"
    return (
        f"{text} {have} no number of whole turns beyond t = {start + time:.15g}, where the contact "
        "passes through a pole"
    )


class PolePassage(OpenDecision):
    """A passage that is one through the pole, as far as so many bits tell."""

    def __init__(self, time: Any) -> None:
        super().__init__("a passage may be one through the pole")
        self.time = float(time.mid())


@dataclass(eq=False)
class Winding:
    """The whole turns of the coordinates in space of one motion that is not upright."""

    form: InvertedMotion
    _levels: dict[int, CapPassages | None] = field(default_factory=dict, repr=False)

    @cached_property
    def parts(self) -> FrameProduct:
        """How the coordinates turn the frame.

        Raises:
            EngineLimit: in another way than a longitude, a colatitude and a third angle do.
        """
        product = composition(self.form.problem.prepared)
        if product is None:
            raise EngineLimit(
                f"system '{self.form.system.name}': whole turns in space are known where the frame "
                "is made of the longitude and the colatitude of a trace and an angle about that "
                "axis; ask for the angles modulo a turn"
            )
        return product

    @property
    def names(self) -> tuple[Any, Any]:
        """The two coordinates that wind."""
        return self.parts.longitude, self.parts.third

    @remember("_levels")
    def passages(self, bits: int) -> CapPassages | None:
        """When caps are entered and left; None where the contact stays at one place in space."""
        form, parts = self.form, self.parts
        if form.rests and self._stands:
            return None
        if form.rests:
            return resting_passages(form, parts, bits, self._upper)
        return moving_passages(form, parts, bits)

    @cached_property
    def _stands(self) -> bool:
        """Whether the contact of a frame that turns evenly stays where it is, as far as can be
        told."""
        bits = FIRST
        while bits <= MOST:
            try:
                with precise(bits):
                    resting_passages(self.form, self.parts, bits, self._upper)
            except (OpenDecision, ZeroDivisionError):
                bits *= 2
            else:
                return False
        return True

    @cached_property
    def _upper(self) -> bool:
        """Whether the spin of a frame that turns evenly points upwards, as far as can be told."""
        attitude, bits = self.form.attitude, FIRST
        assert attitude is not None
        while bits <= MOST_BITS:
            with precise(bits):
                height = rotated(attitude.start(bits)[0], attitude.spin(bits))[2]
            if not height.contains(0):
                return bool(height > 0)
            bits *= 2
        return True

    # -- what is counted -------------------------------------------------------------------

    def gain(self, level: CapPassages, numbers: Sequence[int]) -> Turns:
        """What phi gains in whole turns within the near cap, and within the far one, up to
        constants, when so many passages of each kind have been.

        Raises:
            OpenDecision: a floor is open.
        """
        totals, open_ = [0, 0], []
        for passage, count in zip(level.passages, numbers, strict=True):
            floors = certain_floor_sum(count, passage.phase, level.advance)
            if floors is None:
                number = first_doubt(count, passage.phase, level.advance)
                open_.append(self.pole(level, passage, number))
            else:
                totals[passage.far] += passage.way * floors
        if open_:
            raise min(open_, key=lambda doubt: abs(doubt.time))
        return totals[0], totals[1]

    def pole(self, level: CapPassages, passage: CapPassage, number: int) -> PolePassage:
        """That a passage may be one through the pole."""
        time = passage.time
        return PolePassage(time if level.period is None else time + number * level.period)

    def centres(self, level: CapPassages | None, time: arb, upright: Angles) -> Angles:
        """Angles that are continuous, and less than half a turn from the longitude and from
        ``sense third``, up to whole turns that do not change with the time.

        Raises:
            OpenDecision: more bits are needed.
        """
        if level is None:
            longitude, third, spin = self._initial_attitude(ctx.prec)
            return longitude, self.parts.sense * third + spin * time
        pi, numbers = arb.pi(), level.numbers(time)
        near, far = level.inside(numbers)
        first, last = self.gain(level, numbers)
        along, about = level.side * upright[0], self.parts.sense * upright[1]
        phase = along - level.longitude
        self._stays(level, phase / (2 * pi), time)
        if near or far:
            along = level.longitude + (pi if near else 0)
            about += phase - pi if near else -phase
        about += pi if level.side < 0 else 0
        return along - 2 * pi * (first + last), about + 2 * pi * (first - last)

    def turns(self, level: CapPassages | None, time: arb, upright: Angles, read: Angles) -> Turns:
        """How many whole turns longitude and third angle have beyond those that are read off, up
        to constants.

        Raises:
            OpenDecision: more bits are needed.
        """
        longitude, third = self.centres(level, time, upright)
        sense, turn = self.parts.sense, 2 * arb.pi()
        return _nearest((longitude - read[0]) / turn), sense * _nearest(
            (third - sense * read[1]) / turn
        )

    @cached_property
    def origin(self) -> Turns:
        """Half turns from longitude and third angle, as they are counted here, to those of the
        start."""

        def work(bits: int) -> Turns:
            attitude, level = self.form.attitude, self.passages(bits)
            assert attitude is not None
            plain = dict(
                zip(
                    attitude.coordinates, attitude.machines[1](attitude.start(bits)[0]), strict=True
                )
            )
            read = plain[self.names[0]], plain[self.names[1]]
            first, second = self.turns(level, arb(0), self.upright(level, None, bits), read)
            begun = [given - r for given, r in zip(self._start_values(bits), read, strict=True)]
            halves = [_nearest(e / arb.pi()) for e in begun]
            return halves[0] - 2 * first, halves[1] - 2 * second

        return self.certain(work)

    def upright(self, level: CapPassages | None, moved: Mapping[Any, arb] | None, bits: int,
                time: Any = 0) -> Angles:  # fmt: skip
        """Longitude and third angle about the constant axis, continuous; ``moved`` has them where
        the variable moves, None means the start."""
        if level is None:
            return arb(0), arb(0)
        if level.start is not None:
            return level.start[0] + level.rate * time, level.start[1]
        if moved is None:
            moved = dict(zip(self.form.quadratures.angles, self.form.begin(bits), strict=True))
        return moved[self.names[0]], moved[self.names[1]]

    def _start_values(self, bits: int) -> tuple[arb, ...]:
        values = self.form.problem.start_by_symbol(bits)
        return values[self.names[0]], values[self.names[1]]

    # -- in balls --------------------------------------------------------------------------

    def continuous(
        self, time: arb, moved: Mapping[Any, arb] | None, read: Mapping[Any, arb], bits: int
    ) -> dict[Any, arb]:
        """Longitude and third angle from those that are read off at a time, on the branch on which
        they start; no numbers where so many bits are too few.

        Raises:
            EngineLimit: a pole of the coordinates is passed before.
        """
        plain = read[self.names[0]], read[self.names[1]]
        if not all(e.is_finite() for e in plain):
            return dict(zip(self.names, plain, strict=True))
        try:
            level = self.passages(bits)
            turns = self.turns(level, time, self.upright(level, moved, bits, time), plain)
        except OpenDecision as reason:
            if bits >= MOST:
                raise self._refusal(reason) from None
            return dict.fromkeys(self.names, arb("nan"))
        rows = zip(self.names, plain, turns, self.origin, strict=True)
        return {q: r + (2 * n + half) * arb.pi() for q, r, n, half in rows}

    def certain(self, work: Callable[[int], Value]) -> Value:
        """What a work gives at the least bits at which it decides."""
        bits = FIRST
        while True:
            with precise(bits):
                try:
                    return work(bits)
                except (OpenDecision, ZeroDivisionError) as reason:
                    if bits >= MOST:
                        raise self._refusal(reason) from None
            bits *= 2

    def _refusal(self, reason: Exception) -> NoWholeTurns:
        return NoWholeTurns(self.names, reason.time if isinstance(reason, PolePassage) else None)

    # -- in doubles ------------------------------------------------------------------------

    def unwind(self, times: np.ndarray, moved: Rows, read: Rows) -> None:
        """Make longitude and third angle, as far as they are among those that are read off,
        continuous in place.  ``moved`` has both of the motion turned upright, where the variable
        moves.

        Raises:
            EngineLimit: a pole of the coordinates is passed.
        """
        level, counted = self.certain(lambda bits: self._tally(times, bits))
        if level is None or counted is None:
            with precise(FIRST):
                longitude, third, spin = map(float, self._initial_attitude(FIRST))
            centres = [np.full(times.shape, longitude), third + self.parts.sense * spin * times]
        else:
            centres = self._centres(level, counted, times, moved)
        for q, centre, half in zip(self.names, centres, self.origin, strict=True):
            if q in read:
                whole = centre - read[q]
                whole /= TURN
                np.rint(whole, out=whole)
                whole *= 2
                whole += half
                whole *= np.pi
                read[q][:] += whole

    def _tally(self, times: np.ndarray, bits: int) -> tuple[CapPassages | None, CapTally | None]:
        level = self.passages(bits)
        if level is None:
            return None, None
        phases = [p.phase for p in level.passages]
        if any(value.rad() > SHARP for value in (*phases, level.advance)):
            raise OpenDecision("phases are not accurate enough")
        return level, tally(self, level, times)

    def _centres(
        self, level: CapPassages, counted: CapTally, times: np.ndarray, moved: Rows
    ) -> list[np.ndarray]:
        """What ``centres`` gives, the second one as the third angle is counted."""
        side, sense, pole = level.side, self.parts.sense, float(level.longitude.mid())
        if level.start is not None:
            first, second = map(float, level.start)
            along, about = side * (first + float(level.rate) * times), np.full(times.shape, second)
        else:
            along, about = side * moved[self.names[0]], moved[self.names[1]]
        if level.borders:
            self._stay(level, (along - pole) / TURN, times)
        near, far, state = counted.near, counted.far, counted.state
        free, swung = ~(near | far), near.astype(float) - far
        low = pole + np.pi * near
        low[free] = 0.0
        low -= TURN * (counted.first + counted.last)
        high = -np.pi * near - swung * pole + TURN * (counted.first - counted.last)
        high += np.pi if side < 0 else 0.0
        longitude, third = along * free[state], along * swung[state]
        longitude += low[state]
        third += high[state]
        third *= sense
        third += about
        return [longitude, third]

    # -- where no cap is entered -----------------------------------------------------------

    def _initial_attitude(self, bits: int) -> tuple[arb, arb, arb]:
        """Longitude and third angle at the start, and the spin of the frame about the normal of
        the contact, where that stays where it is."""
        attitude, problem = self.form.attitude, self.form.problem
        assert attitude is not None
        v, b = self._start_values(bits)
        c = problem.exact(self.parts.colatitude)(bits)
        normal = [c.sin() * v.cos(), c.sin() * v.sin(), c.cos()]
        along = rotated(transpose(attitude.start(bits)[0]), normal)
        return v, b, sum((w * e for w, e in zip(attitude.spin(bits), along, strict=True)), arb(0))

    def _stays(self, level: CapPassages, now: arb, time: arb) -> None:
        """That a contact which stays on a parallel through a pole has not passed that pole."""
        met = []
        for half in level.borders:
            ends = [
                e.floor().unique_fmpz()
                for e in (self._phase_at_start(level, ctx.prec) + half, now + half)
            ]
            if None in ends:
                raise PolePassage(time)
            if ends[0] != ends[1]:
                met.append(self._first_passage(level, half, float(time.mid())))
        if met:
            raise NoWholeTurns(self.names, min(met, key=abs))

    def _stay(self, level: CapPassages, phases: np.ndarray, times: np.ndarray) -> None:
        """That a contact has not passed a pole up to many times; what is too near to tell is
        evaluated in balls."""
        met = []
        for half in level.borders:
            with precise(FIRST):
                begun = floor(self._phase_at_start(level, FIRST) + half)
            shifted = phases + float(half)
            past = np.flatnonzero(np.maximum(begun - shifted, shifted - begun - 1) > ROUGH)
            if past.size:
                first = times[past[np.argmin(np.abs(times[past]))]]
                met.append(self._first_passage(level, half, float(first)))
        if met:
            raise NoWholeTurns(self.names, min(met, key=abs))

    def _phase_at_start(self, level: CapPassages, bits: int) -> arb:
        """phi at the start, in turns."""
        start = self.upright(level, None, bits)[0]
        return (level.side * start - level.longitude) / (2 * arb.pi())

    def _first_passage(self, level: CapPassages, half: arb, time: float) -> float:
        """When the pole is first met on the way to a time that lies beyond, by halving."""
        begun = float(self._phase_at_start(level, FIRST) + half)

        def phase(t: float) -> float:
            if level.rate is not None:
                return begun + level.side * float(level.rate) * t / TURN
            j = self.form.quadratures.angles.index(self.names[0])
            return begun + level.side * float(Sample.of(self.form.solution, t).integral(j)) / TURN

        before, after = 0.0, time
        for _ in range(HALVINGS):
            middle = (before + after) / 2
            if np.floor(phase(middle)) == np.floor(begun):
                before = middle
            else:
                after = middle
        return (before + after) / 2


def winding_of(form: InvertedMotion) -> Winding:
    """The whole turns of a motion that is not upright, kept with it."""
    return form.memo.once("winding", lambda: Winding(form))


def passed_poles(form: InvertedMotion, times: np.ndarray) -> dict[float, tuple[Any, ...]]:
    """Passages through a pole of a motion's own coordinates, on the way from the start to the
    times: the angles that have no number of whole turns beyond, by the first instant.  Half a turn
    is counted at each, and nothing makes it that."""
    if form.rests or not times.size:
        return {}
    attitude, constants = form.attitude, form.solution.constants(FIRST)
    elsewhere = () if attitude is None or attitude.upright else attitude.coordinates
    early, late = min(0.0, float(times.min())), max(0.0, float(times.max()))
    longitudes = {t.longitude for t in form.quadratures.traces}
    passed: dict[float, tuple[Any, ...]] = {}
    for one in constants.phases:
        met = _met_between(constants, one.side, early, late) if one.alpha.is_zero() else None
        turned = [q for q, w in zip(form.quadratures.angles, one.shares, strict=False) if w != 0]
        # a pole about the constant vector is none in space, where a pole of the body is one, too
        upright_only = bool({*turned} & {*elsewhere} & longitudes)
        names = tuple(q for q in turned if not (upright_only and q in elsewhere))
        if met is not None and names:
            passed[met] = names
    return passed


def _met_between(constants: Any, side: int, early: float, late: float) -> float | None:
    """The turning point of that side which is nearest to t = 0, apart from 0 itself."""
    first = float(constants.turn)
    if constants.half is None:
        moments = [first]
    else:
        period = 2 * float(constants.half)
        first += side * period / 2
        moments = [first + period * j for j in (-2, -1, 0, 1, 2)]
    passed = [t for t in moments if t != 0 and early <= t <= late]
    return min(passed, key=abs, default=None)


def _nearest(value: arb) -> int:
    nearest = floor(value + arb(0.5))
    if not abs(value - nearest) < SURE:
        raise OpenDecision("whole turns need more bits")
    return nearest
