"""A motion at many times, in doubles, in stretches so short that all arrays stay in the cache."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from flint import ctx

from voronec.elliptic.doubles import (
    BITS,
    PIECE,
    Arguments,
    Doubles,
    QuarticReduction,
    Rows,
    SecularTerm,
    horner,
    matrix,
    two_product,
)
from voronec.elliptic.theta_polynomials import Angle
from voronec.errors import DefinitionError

FAR = 40.0
"""Where sinh is a power of e to the last bit, and at most two terms of a sum count."""


def angle_into(
    angle: Angle, variable: np.ndarray, across: np.ndarray, out: np.ndarray, spare: np.ndarray
) -> None:
    """``atan(X N/D)``, without the sign of the angle and its drift."""
    if len(angle.above) > 1:
        horner(variable, angle.above, out)
        out *= across
        out /= horner(variable, angle.below, spare)
    elif len(angle.below) > 1:
        np.divide(across, horner(variable, angle.below, out), out=out)
    else:
        np.divide(across, angle.below[0], out=out)
    if angle.below[0] == 0.0:
        # The trace passes through the pole: the angle jumps by pi, and has its later value.
        out[np.isnan(out)] = math.inf
    np.arctan(out, out=out)


@np.errstate(all="ignore")
def log_term_part(doubles: Doubles, place: int, number: int, z: np.ndarray) -> np.ndarray:
    """The periodic part that a log term adds to an integral, at z counted from its side."""
    constants, log_term = doubles.constants, doubles.constants.log_terms[place]
    log, zeta = complex(log_term.logs[number]), complex(log_term.zetas[number])
    whole, angle = complex(log_term.place), doubles.log_phases[place]
    value = np.zeros_like(z)
    period = 2 * doubles.half
    images = ((1, -whole.real), (-1, whole.real))
    for sign, shift in images[:1] if constants.kind == "exponential" else images:
        image = z + shift
        count = np.rint(image / period) if math.isfinite(period) else np.zeros_like(z)
        if math.isfinite(period):
            image -= count * period
        if angle is not None and log:
            if log.real:
                value += sign * log.real * _size(doubles, image, count, whole.imag)
            value -= log.imag * _turn(doubles, angle, image)
            if math.isfinite(period):
                value -= log.imag * _gain(doubles, angle, whole.imag) / period * z
        if zeta:
            value += zeta.real * _zeta(doubles, image - sign * 1j * whole.imag)
            value += zeta.real * _wave(doubles) * count
    if log.real and constants.kind == "hyperbolic" and not math.isfinite(period):
        # |z - a| - |z + a|, which ``_size`` leaves out: it is bounded, and they are not
        value -= 2 * log.real * np.clip(z, -abs(whole.real), abs(whole.real)) * np.sign(whole.real)
    if log_term.gains is not None and constants.half is not None:
        with ctx.workprec(BITS):
            drift = float((log_term.gains[number] / (2 * constants.half * constants.scale)).mid())
        value -= drift * z
    return value


def _turn(doubles: Doubles, angle: Angle, z: np.ndarray) -> np.ndarray:
    """The periodic part of a phase."""
    value, spare = np.empty_like(z), np.empty_like(z)
    if doubles.constants.kind == "trigonometric":
        sine, cosine = np.sin(z), np.cos(z)
        angle_into(angle, sine * sine, sine * cosine, value, spare)
        value *= angle.sign
        for k, factor in enumerate(angle.periodic_term, 1):
            value += factor * np.sin(2 * k * z)
        return value
    if doubles.constants.kind == "rational":
        angle_into(angle, z, z, value, spare)
    else:
        angle_into(angle, np.sinh(np.clip(z, -350, 350)) ** 2, np.tanh(z), value, spare)
    return angle.sign * value - angle.drift * z


def _gain(doubles: Doubles, angle: Angle, alpha: float) -> float:
    """What the phase grows by in one period."""
    if doubles.constants.kind == "trigonometric":
        return angle.sign * math.pi
    return angle.sign * math.pi - _wave(doubles) * alpha


def _wave(doubles: Doubles) -> int:
    """m of ``s(z + period) = -C exp(m z) s(z)``."""
    if doubles.constants.kind != "hyperbolic":
        return 0
    return 4 if doubles.constants.partner == "theta2" else 2


def _size(doubles: Doubles, z: np.ndarray, count: np.ndarray, alpha: float) -> np.ndarray:
    """``log abs(s(z + i alpha + count period))``; less ``abs(z)`` if that goes on for ever."""
    if doubles.constants.kind in ("hyperbolic", "exponential"):
        value = (
            np.abs(z)
            - math.log(2)
            + np.log(np.abs(1 + _second_term_ratio(doubles, z + 1j * alpha)))
        )
        near = np.abs(z) < FAR
        value[near] = np.log(np.abs(_sums(doubles, z[near] + 1j * alpha)[0]))
        wave = _wave(doubles)
        if wave and not math.isfinite(doubles.half):
            value -= np.abs(z)
        elif wave:
            value += wave * (count * z + doubles.half * count**2)
        return value
    return np.log(np.abs(_sums(doubles, z + 1j * alpha)[0]))


def _zeta(doubles: Doubles, z: np.ndarray) -> np.ndarray:
    """The real part of ``s'/s`` at complex z."""
    if doubles.constants.kind == "trigonometric":
        return _trigonometric_zeta(doubles, z)
    if doubles.constants.kind in ("hyperbolic", "exponential"):
        rising = _second_term_ratio(doubles, z)
        value = np.sign(z.real) * (1 + 2 * rising / (1 + rising))
        near = np.abs(z.real) < FAR
        sums = _sums(doubles, z[near])
        value[near] = sums[1] / sums[0]
        return np.asarray(value.real)
    value, slope = _sums(doubles, z)
    return np.asarray((slope / value).real)


def _trigonometric_zeta(doubles: Doubles, z: np.ndarray) -> np.ndarray:
    """The real part of ``s'/s``, from products of the terms ``c_k sin(k z)`` of s.

    Far from the axis it is small beside the imaginary part, and would be lost in its rounding.
    With z = x + i y two terms, k < n, have in ``Re s' conj(s)`` the share
    c_k c_n ((n + k) sin((n + k) x) cosh((n - k) y) - (n - k) sin((n - k) x) cosh((n + k) y))/2,
    and one with itself c_k^2 k sin(2 k x)/2.
    """
    terms = _terms(doubles, float(np.max(np.abs(z.imag), initial=0.0)))
    x, y, total = z.real, z.imag, np.zeros(z.shape)
    for i, (k, one) in enumerate(terms):
        total += one * one * k / 2 * np.sin(2 * k * x)
        for n, other in terms[i + 1 :]:
            sums = (n + k) * np.sin((n + k) * x) * np.cosh((n - k) * y)
            total += one * other / 2 * (sums - (n - k) * np.sin((n - k) * x) * np.cosh((n + k) * y))
    return np.asarray(total / np.abs(_sums(doubles, z)[0]) ** 2)


def _second_term_ratio(doubles: Doubles, z: np.ndarray) -> np.ndarray:
    """What the second term of s is of the first, far from z = 0 (of -z where z < 0)."""
    if doubles.constants.partner != "theta2":
        return np.zeros_like(z)
    outwards = np.where(z.real < 0, -z, z)
    return np.asarray(np.exp(2 * (outwards - doubles.half)))


def _sums(doubles: Doubles, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """s and its derivative at complex z."""
    kind = doubles.constants.kind
    if kind == "rational":
        return z, np.ones_like(z)
    trigonometric = kind == "trigonometric"
    sine, cosine = (np.sin, np.cos) if trigonometric else (np.sinh, np.cosh)
    growth = float(np.max(np.abs(z.imag if trigonometric else z.real), initial=0.0))
    value, slope = np.zeros_like(z), np.zeros_like(z)
    for order, power in _terms(doubles, growth):
        value += power * sine(order * z)
        slope += power * order * cosine(order * z)
    return value, slope


def _terms(doubles: Doubles, growth: float) -> list[tuple[int, float]]:
    """(k, c_k) of the terms of s that count as far as ``growth`` from the axis."""
    nome = float(doubles.constants.nome.mid())
    terms: list[tuple[int, float]] = []
    for n in range(12):
        order, power = 2 * n + 1, (-1) ** n * nome ** (n * (n + 1) // 2)
        if n and (power == 0.0 or math.log(abs(power)) + (order + 1) * growth < -FAR):
            break
        terms.append((order, power))
    return terms


TURN = 2 * math.pi
Origin = tuple[float, float]


@dataclass(frozen=True, eq=False)
class TimeStretch:
    """The motion at a stretch of times; what several results need is computed once.

    Attributes:
        doubles: the motion.
        arguments: of the sums at the times.
        secular_terms: of the integrals.
        origins: of each integral: its value at t = 0 before it is taken off, in radians and turns.
    """

    doubles: Doubles
    arguments: Arguments
    secular_terms: tuple[SecularTerm, ...]
    origins: tuple[Origin, ...]

    @property
    def x(self) -> np.ndarray:
        """The variable."""
        return self.affine(self.doubles.base, self.doubles.other)

    def affine(self, at_base: float, at_other: float) -> np.ndarray:
        """An affine function of x from its values at the ends."""
        near, far = self.arguments.weights
        scratch = self.arguments.scratch
        value = np.multiply(near, at_base, out=self.arguments.spare())
        mark = scratch.mark()
        value += np.multiply(far, at_other, out=self.arguments.spare())
        scratch.free(mark)
        return value

    def colatitude(self, south: tuple[float, float], north: tuple[float, float]) -> np.ndarray:
        """``2 atan sqrt((1 - l)/(1 + l))``, from ``1 - l`` and ``1 + l`` at both ends."""
        angle = self.affine(*south)
        mark = self.arguments.scratch.mark()
        angle /= self.affine(*north)
        self.arguments.scratch.free(mark)
        np.sqrt(angle, out=angle)
        np.arctan(angle, out=angle)
        angle *= 2.0
        return angle

    @cached_property
    def rate(self) -> np.ndarray:
        """dx/dt."""
        doubles = self.doubles
        near, far = self.arguments.weights
        kind = doubles.constants.kind
        if kind == "rest":
            return np.zeros_like(near)
        if kind == "exponential":
            return 2 * doubles.scale * doubles.span * near * far
        square = doubles.gradient * near * far
        for ratio in doubles.ratios:
            share = near + ratio.real * far
            square *= share**2 + (ratio.imag * far) ** 2 if ratio.imag else np.abs(share)
        speed = np.copysign(np.sqrt(square), self.arguments.phase_reduction[1])
        speed *= math.copysign(1.0, doubles.span) * (1 - 2 * self.arguments.odd)
        return speed

    def integral(self, number: int, start: float = 0.0) -> np.ndarray:
        """An integral along the motion, ``start`` at t = 0 and continuous."""
        value = self._sum(number, start)
        if self.secular_terms[number].exact:
            # far from a turning point large terms cancel: they tell whole turns, and no more
            small = self.modulo(number, start)
            value = small + TURN * np.rint((value - small) / TURN)
        return value

    def _sum(self, number: int, start: float) -> np.ndarray:
        """The sum of its terms, wrong by the last digits of the largest."""
        secular_term = self.secular_terms[number]
        count, rest = self.arguments.phase_reduction
        periodic = self._periodic(number)
        value = np.multiply(rest, secular_term.slope, out=self.arguments.spare())
        mark = self.arguments.scratch.mark()
        spare = self.arguments.spare()
        if secular_term.second:
            value += np.multiply(count, secular_term.second, out=spare)
        _add(value, periodic, 1.0, spare)
        value += start - self.origins[number][0]
        # The only rounding of the size of the value is the last.
        if secular_term.first:
            value += np.multiply(count, secular_term.first, out=spare)
        self.arguments.scratch.free(mark)
        return value

    def modulo(self, number: int, start: float = 0.0) -> np.ndarray:
        """The sum as an angle in (-pi, pi]."""
        periodic = self._periodic(number)
        value = self.arguments.spare()
        mark = self.arguments.scratch.mark()
        spare = self.arguments.spare()
        self._turns(self.secular_terms[number], value, spare)
        _add(value, periodic, 1 / TURN, spare)
        value += start / TURN - self.origins[number][1]
        np.subtract(value, 0.5, out=spare)
        value -= np.ceil(spare, out=spare)
        value *= TURN
        self.arguments.scratch.free(mark)
        return value

    def _turns(self, secular_term: SecularTerm, value: np.ndarray, spare: np.ndarray) -> None:
        """The steady part of an integral in turns, less whole ones."""
        count, rest = self.arguments.phase_reduction
        high, low = secular_term.spin
        other = self.arguments.spare()
        if secular_term.exact:
            first, second = self.arguments.reduction.tail(self.arguments.times, count)
            product, error = two_product(first, high)
            product -= np.rint(product)
            np.add(product, error + first * low + second * high, out=value)
        else:
            np.multiply(rest, high, out=value)
        for share in secular_term.turns:
            if share:
                more = np.multiply(count, share, out=spare)
                more -= np.rint(more, out=other)
                value += more

    def _periodic(self, number: int) -> list[tuple[float, np.ndarray]]:
        """The periodic parts of an integral: factors and arrays."""
        doubles = self.doubles
        parts = [(share, self._angles(place)) for place, share in doubles.shares[number]]
        periodic_term = doubles.periodic_terms[number]
        if periodic_term.size:
            powers = self.arguments.powers[: periodic_term.size]
            parts.append((1.0, np.matmul(periodic_term, powers, out=self.arguments.spare())))
        for place in doubles.log_terms[number]:
            z = self.arguments.z(doubles.constants.log_terms[place].side)
            parts.append((1.0, log_term_part(doubles, place, number, z)))
        p, q = doubles.bounded_terms[number]
        if p or q:
            parts.append((1.0, (p + q * self.x) * self.rate))
        return parts

    @cached_property
    def _known(self) -> dict[int, np.ndarray]:
        return {}

    def _angles(self, place: int) -> np.ndarray:
        """The periodic part of a phase, but for its periodic term."""
        if place in self._known:
            return self._known[place]
        angle = self.doubles.angles[place]
        variable, across, z = self.arguments.own(angle.side)
        value = self.arguments.new()
        mark = self.arguments.scratch.mark()
        angle_into(angle, variable, across, value, self.arguments.spare())
        self.arguments.scratch.free(mark)
        sign = angle.sign
        if angle.side == 1 and self.doubles.constants.kind == "trigonometric":
            sign = -sign  # X is that of the base
        if sign < 0:
            np.negative(value, out=value)
        if angle.drift:
            value -= angle.drift * z
        self._known[place] = value
        return value


def _add(
    value: np.ndarray, parts: list[tuple[float, np.ndarray]], unit: float, spare: np.ndarray
) -> None:
    """Add parts with their factors, in that unit."""
    for share, part in parts:
        factor = share * unit
        if factor == 1.0:
            value += part
        elif factor == -1.0:
            value -= part
        else:
            value += np.multiply(part, factor, out=spare)


BLOCK = 8192
"""Times in a stretch."""
ROWS = 64
"""Arrays of a stretch that are made at once."""


@dataclass(frozen=True, eq=False)
class Sample:
    """The motion at given times; every result is an array of their shape.

    Nothing is computed that is not asked for, and what several results need is kept: up to about
    forty doubles per time. ``each`` keeps nothing, and is the fastest for several results.

    Attributes:
        times: in one dimension.
        shape: of the results.
        model: the motion at no times.
    """

    times: np.ndarray
    shape: tuple[int, ...]
    model: TimeStretch

    @classmethod
    def of(cls, solution: Any, times: Any) -> Sample:
        """The sample of a solution at times, taken as the doubles they are.

        Raises:
            DefinitionError: a time is not a finite number.
            EngineLimit: a time is more than 2^40 half periods away.
        """
        array = np.asarray(times, dtype=float)
        flat = np.ascontiguousarray(array.ravel())
        latest = max(float(flat.max()), -float(flat.min()), 0.0) if flat.size else 0.0
        if not math.isfinite(latest) or latest != latest:
            raise DefinitionError("a time of a sample is not a finite number")
        return cls(flat, array.shape, _model(solution.doubles, latest))

    @property
    def x(self) -> np.ndarray:
        """The variable."""
        return self._join(lambda at: at.x)

    @property
    def rate(self) -> np.ndarray:
        """dx/dt, accurate relative to its size near the turning points."""
        return self._join(lambda at: at.rate)

    def affine(self, at_base: float, at_other: float) -> np.ndarray:
        """An affine function of x from its values at the ends.

        Where those have one sign it is accurate to the last bits, however small.
        """
        return self._join(lambda at: at.affine(at_base, at_other))

    def colatitude(self, south: tuple[float, float], north: tuple[float, float]) -> np.ndarray:
        """The angle in [0, pi] whose cosine l is affine in x, accurate near both poles.

        South and north are the values of ``1 - l`` and ``1 + l`` at base and other, which must
        not be negative: the angle is ``2 atan sqrt((1 - l)/(1 + l))``.
        """
        return self._join(lambda at: at.colatitude(south, north))

    def integral(self, number: int, start: float = 0.0) -> np.ndarray:
        """An integral along the motion: ``start`` at t = 0, continuous, with all its turns."""
        return self._join(lambda at: at.integral(number, start))

    def modulo(self, number: int, start: float = 0.0) -> np.ndarray:
        """An integral as an angle in (-pi, pi], as accurate late as early."""
        return self._join(lambda at: at.modulo(number, start))

    def each(self, work: Callable[[TimeStretch], Sequence[np.ndarray]]) -> tuple[np.ndarray, ...]:
        """Several results at once: what ``work`` makes of a stretch, for all times.

        A ``TimeStretch`` has the properties and methods of a sample:
        ``sample.each(lambda at: (at.x, at.integral(0), at.modulo(1)))``.
        """
        size = min(BLOCK, self.times.size)
        memory, scratch = Rows(ROWS, size), Rows(ROWS, size)
        whole: np.ndarray | None = None
        for part, times in self._parts():
            values = _quietly(work, _at(self.model, times, memory, scratch))
            if whole is None:
                whole = matrix(len(values), self.times.size)
            for row, value in zip(whole, values, strict=True):
                row[part] = value
            memory.free()
            scratch.free()
        return () if whole is None else tuple(row.reshape(self.shape) for row in whole)

    def _join(self, work: Callable[[TimeStretch], np.ndarray]) -> np.ndarray:
        whole = self._results.new(self.times.size)
        scratch, stretches = self._stretches
        for part, stretch in stretches:
            whole[part] = _quietly(work, stretch)
            scratch.free()
        return whole.reshape(self.shape)

    @cached_property
    def _results(self) -> Rows:
        """Memory of results, a piece for several of them."""
        size = self.times.size
        return Rows(max(1, PIECE // size) if size > 4 * BLOCK else 1, size)

    @cached_property
    def _stretches(self) -> tuple[Rows, list[tuple[slice, TimeStretch]]]:
        size = min(BLOCK, self.times.size)
        many = max(ROWS, PIECE // BLOCK) if self.times.size > 4 * BLOCK else ROWS
        memory, scratch = Rows(many, size), Rows(ROWS, size)
        return scratch, [
            (part, _at(self.model, times, memory, scratch)) for part, times in self._parts()
        ]

    def _parts(self) -> Iterator[tuple[slice, np.ndarray]]:
        for start in range(0, max(self.times.size, 1), BLOCK):
            part = slice(start, start + BLOCK)
            yield part, self.times[part]


def _model(doubles: Doubles, latest: float) -> TimeStretch:
    """The motion at no times yet, with the values of the integrals at t = 0; the last is kept."""
    if latest not in doubles.models:
        made = _make_model(doubles, latest)
        doubles.models.clear()
        doubles.models[latest] = made
    model: TimeStretch = doubles.models[latest]
    return model


def _make_model(doubles: Doubles, latest: float) -> TimeStretch:
    here = _bare(doubles, doubles.reduction(latest), latest)
    if len(doubles.origins) < len(here.secular_terms):
        start = _at(
            _bare(doubles, doubles.reduction(0.0), 0.0), np.zeros(1), Rows(ROWS, 1), Rows(ROWS, 1)
        )
        origins = []
        for number in range(len(here.secular_terms)):
            radians = _quietly(partial(TimeStretch._sum, number=number, start=0.0), start)
            turned = _quietly(partial(TimeStretch.modulo, number=number), start)
            origins.append((float(radians[0]), float(turned[0]) / TURN))
        doubles.origins[:] = origins
    return replace(here, origins=tuple(doubles.origins))


def _bare(doubles: Doubles, reduction: QuarticReduction, latest: float) -> TimeStretch:
    count = len(doubles.constants.rates)
    secular_terms = tuple(
        doubles.secular_term(number, reduction, latest) for number in range(count)
    )
    arguments = Arguments(doubles, np.zeros(0), reduction, Rows(1, 0), Rows(1, 0))
    return TimeStretch(doubles, arguments, secular_terms, ((0.0, 0.0),) * count)


def _at(model: TimeStretch, times: np.ndarray, memory: Rows, scratch: Rows) -> TimeStretch:
    arguments = replace(model.arguments, times=times, memory=memory, scratch=scratch)
    return replace(model, arguments=arguments)


def _quietly(work: Callable[[TimeStretch], Any], stretch: TimeStretch) -> Any:
    """What happens at infinite ratios is meant."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        return work(stretch)
