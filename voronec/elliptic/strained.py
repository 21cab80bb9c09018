"""Phases, logarithms and zeta functions of the poles at many times, in doubles."""

from __future__ import annotations

import math

import numpy as np
from flint import ctx

from voronec.elliptic.doubles import BITS, Doubles
from voronec.elliptic.theta_polynomials import Angle, horner

__all__ = ["angle_into", "strained"]

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


def strained(doubles: Doubles, place: int, number: int, z: np.ndarray) -> np.ndarray:
    """The periodic part that a strain adds to an integral, at z counted from its side."""
    with np.errstate(all="ignore"):
        return _strained(doubles, place, number, z)


def _strained(doubles: Doubles, place: int, number: int, z: np.ndarray) -> np.ndarray:
    constants, strain = doubles.constants, doubles.constants.strains[place]
    log, zeta = complex(strain.logs[number]), complex(strain.zetas[number])
    whole, angle = complex(strain.place), doubles.drawn[place]
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
            value += (zeta * _zeta(doubles, image - sign * 1j * whole.imag)).real
            value += zeta.real * _wave(doubles) * count
    if log.real and constants.kind == "hyperbolic" and not math.isfinite(period):
        # |z - a| - |z + a|, which ``_size`` leaves out: it is bounded, and they are not
        value -= 2 * log.real * np.clip(z, -abs(whole.real), abs(whole.real)) * np.sign(whole.real)
    if strain.gains is not None and constants.half is not None:
        with ctx.workprec(BITS):
            drift = float((strain.gains[number] / (2 * constants.half * constants.scale)).mid())
        value -= drift * z
    return value


def _turn(doubles: Doubles, angle: Angle, z: np.ndarray) -> np.ndarray:
    """The periodic part of a phase."""
    value, spare = np.empty_like(z), np.empty_like(z)
    if doubles.constants.kind == "trigonometric":
        sine, cosine = np.sin(z), np.cos(z)
        angle_into(angle, sine * sine, sine * cosine, value, spare)
        value *= angle.sign
        for k, factor in enumerate(angle.ripple, 1):
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
        value = np.abs(z) - math.log(2) + np.log(np.abs(1 + _rising(doubles, z + 1j * alpha)))
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
    """``s'/s`` at complex z."""
    if doubles.constants.kind in ("hyperbolic", "exponential"):
        rising = _rising(doubles, z)
        value = np.sign(z.real) * (1 + 2 * rising / (1 + rising))
        near = np.abs(z.real) < FAR
        sums = _sums(doubles, z[near])
        value[near] = sums[1] / sums[0]
        return value
    value, slope = _sums(doubles, z)
    return slope / value


def _rising(doubles: Doubles, z: np.ndarray) -> np.ndarray:
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
    nome = float(doubles.constants.nome.mid())
    growth = float(np.max(np.abs(z.imag if trigonometric else z.real), initial=0.0))
    value, slope = np.zeros_like(z), np.zeros_like(z)
    for n in range(12):
        order, power = 2 * n + 1, (-1) ** n * nome ** (n * (n + 1) // 2)
        if n and (power == 0.0 or math.log(abs(power)) + (order + 1) * growth < -FAR):
            break
        value += power * sine(order * z)
        slope += power * order * cosine(order * z)
    return value, slope
