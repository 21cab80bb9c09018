"""A place on a plane that goes round evenly, where nothing singles out a direction there."""

from __future__ import annotations

from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.precision import SHARP
from voronec.closed.arithmetic import ball, compile_expressions, precise
from voronec.closed.clock import whole_turns_off
from voronec.closed.compiled_motion import CompiledMotion
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.space import Attitude


def steady_rates(form: InvertedMotion, bits: int) -> list[Any]:
    """The velocities of all coordinates at rest of the variable; of a motion that is turned in
    space, without those of its coordinates in space.  Constant, but for a place on a plane that
    goes round (``wheels``)."""
    attitude, coordinates = form.attitude, form.system.coordinates
    if attitude is not None:
        rates = attitude.rates(bits)
        return [ball(0) if q in attitude.coordinates and not attitude.upright else r
                for q, r in zip(coordinates, rates, strict=True)]  # fmt: skip
    if form.wheels:
        # by frame and constraints, at the start
        velocities: list[Any] = Attitude(form.problem, form.quadratures.space).rates(bits)  # type: ignore[arg-type]
        return velocities
    return [form.exact(e)(bits) for e in form.rates_at_rest]


def place_on_grid(form: InvertedMotion, grid: np.ndarray) -> dict[Any, np.ndarray]:
    """The place on a grid of times: with W its velocity at the start and w the rate at which that
    turns, place = start + (2/w) sin(w t/2) W turned by w t/2."""
    x, y, first, second, a, b, spin = _rolling(form, SHARP)
    half = 2 * np.pi * whole_turns_off(spin / 2, grid)
    length = 2 * np.sin(half) / float(spin) if float(spin) else grid
    cosine, sine, a, b = np.cos(half), np.sin(half), float(a), float(b)
    return {
        x: float(first) + length * (a * cosine - b * sine),
        y: float(second) + length * (a * sine + b * cosine),
    }


def rolled_in_balls(form: InvertedMotion, time: Any, bits: int) -> dict[Any, Any]:
    """The place at one time, in balls."""
    x, y, first, second, a, b, spin = _rolling(form, bits)
    half = spin * time / 2
    length, cosine, sine = half.sinc() * time, half.cos(), half.sin()
    return {
        x: first + length * (a * cosine - b * sine),
        y: second + length * (a * sine + b * cosine),
    }


def _rolling(form: InvertedMotion, bits: int) -> tuple[Any, ...]:
    """The place, where it starts, its velocity there, and the rate at which that turns."""
    plane = form.quadratures.plane
    assert plane is not None
    rates = dict(zip(form.system.coordinates, steady_rates(form, bits), strict=True))
    (x, y), start = plane.place, [form.exact(q)(bits) for q in plane.place]
    compiled = form.problem.prepared
    turning = compiled.memo.once("turning", lambda: _turning_angles(compiled))
    with precise(bits):
        spin = sum((rates[q] * c for q, c in turning.items()), ball(0))
    return x, y, *start, rates[x], rates[y], spin


def _turning_angles(own: CompiledMotion) -> dict[Any, int]:
    """The angles that turn the vector in the plane, and how often each does.

    Where an angle alone grows and the vector turns, at any state, what the vector is made of
    besides does not move with the variable at rest.
    """
    plane = own.motion.plane
    assert plane is not None
    a, b = plane.direction
    slopes = [sp.diff(e, q) for q in own.motion.angles for e in (a, b)]
    turning = {}
    with precise(SHARP):
        given = [ball(sp.Rational(sp.prime(i + 20), sp.prime(i + 41)))
                 for i in range(len(own.inputs))]  # fmt: skip
        first, second, *moved = compile_expressions([a, b, *slopes], own.inputs)(given)
        for i, q in enumerate(own.motion.angles):
            along, across = moved[2 * i : 2 * i + 2]
            times = round(float((first * across - second * along)
                                / (first * first + second * second)))  # fmt: skip
            if (along + times * second).contains(0) and (across - times * first).contains(0):
                turning[q] = times
    return turning
