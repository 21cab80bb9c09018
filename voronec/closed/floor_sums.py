"""Sums of floors of evenly growing numbers: exact in integers, certified in balls."""

from __future__ import annotations

from typing import Any

from flint import ctx

__all__ = ["certain_floor_sum", "first_doubt", "floor_sum", "scale_to_integers"]


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
