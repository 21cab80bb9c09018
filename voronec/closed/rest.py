"""Where the variable rests at a multiple root, all rates are constant; the frame turns evenly."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from voronec.closed.arithmetic import ball

__all__ = ["turned_by"]


def turned_by(spin: Sequence[Any], t: Any) -> list[Any]:
    """exp(t Omega^) = I + t sinc(w t) Omega^ + t^2/2 sinc^2(w t/2) Omega^^2, row by row."""
    a, b, c = spin
    angle = (a * a + b * b + c * c).nonnegative_part().sqrt() * t
    if not angle.is_finite():
        angle = ball(0).union((a * a + b * b + c * c).abs_upper().sqrt() * t)
    first, half = angle.sinc() * t, (angle / 2).sinc() * t
    second = half * half / 2
    return [
        1 - second * (b * b + c * c),
        second * a * b - first * c,
        second * a * c + first * b,
        second * a * b + first * c,
        1 - second * (a * a + c * c),
        second * b * c - first * a,
        second * a * c - first * b,
        second * b * c + first * a,
        1 - second * (a * a + b * b),
    ]
