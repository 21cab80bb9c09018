"""Arrays of doubles that know how wrong they are: |true - mid| <= err, rounding included.

With these the formulas of a declaration are evaluated for many motions at once, and a sign that is
read off is certain.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

UNIT = 2.0**-52
"""Twice the rounding error of one operation: it covers that of the bound's own arithmetic."""
LIBRARY = 8 * UNIT
"""The error of a sine, a cosine or an arc of the library, relative to its largest values."""
TINY = 1e-300
"""What underflow may lose."""


@dataclass(frozen=True)
class BoundedNumber:
    """Numbers ``mid`` with errors of at most ``err``: arrays of one shape, or numbers."""

    mid: Any
    err: Any

    __array_ufunc__ = None  # numpy's arrays leave the arithmetic to this class

    @classmethod
    def of(cls, value: Any) -> BoundedNumber:
        """A value as it is; a fraction that Python has rounded carries its rounding."""
        if isinstance(value, BoundedNumber):
            return value
        if isinstance(value, np.ndarray):
            return cls(value.astype(float), np.zeros(value.shape))
        number = float(value)
        exact = number.is_integer() and abs(number) < 1 / UNIT
        return cls(number, 0.0 if exact else abs(number) * UNIT)

    @property
    def sign(self) -> Any:
        """-1 or 1 where it is certain, 0 elsewhere, exact zeros included."""
        return np.where(np.abs(self.mid) > self.err, np.sign(self.mid), 0).astype(int)

    @property
    def zero(self) -> Any:
        """Where the number is exactly 0."""
        return (self.mid == 0) & (self.err == 0)

    @property
    def size(self) -> Any:
        """An upper bound of the absolute value."""
        return np.abs(self.mid) + self.err

    def take(self, chosen: Any) -> BoundedNumber:
        """Some of the numbers."""
        return BoundedNumber(self.mid[chosen], self.err[chosen])

    def __neg__(self) -> BoundedNumber:
        return BoundedNumber(-self.mid, self.err)

    def __add__(self, other: Any) -> BoundedNumber:
        other = BoundedNumber.of(other)
        return _round_result(self.mid + other.mid, self.err + other.err)

    def __mul__(self, other: Any) -> BoundedNumber:
        other = BoundedNumber.of(other)
        err = np.abs(self.mid) * other.err + np.abs(other.mid) * self.err + self.err * other.err
        # a factor that is exactly zero makes an exact zero: it must not become merely small
        nothing = self.zero | other.zero
        product = _round_result(self.mid * other.mid, err + TINY)
        return BoundedNumber(
            np.where(nothing, 0.0, product.mid), np.where(nothing, 0.0, product.err)
        )

    def __truediv__(self, other: Any) -> BoundedNumber:
        other = BoundedNumber.of(other)
        with np.errstate(divide="ignore", invalid="ignore"):
            mid = self.mid / other.mid
            room = np.abs(other.mid) - other.err
            err = (self.err + np.abs(mid) * other.err) / room + TINY
            good = room > 0
        quotient = _round_result(np.where(good, mid, 0.0), np.where(good, err, np.inf))
        nothing = self.zero & good
        return BoundedNumber(
            np.where(nothing, 0.0, quotient.mid), np.where(nothing, 0.0, quotient.err)
        )

    def __pow__(self, power: Any) -> BoundedNumber:
        if power == 0.5:
            return self.sqrt()
        if power != int(power):
            return (self.sqrt()) ** (2 * power)
        if power < 0:
            return 1 / self ** (-power)
        product = BoundedNumber.of(1)
        for _ in range(int(power)):
            product = product * self
        return product

    def __sub__(self, other: Any) -> BoundedNumber:
        return self + (-BoundedNumber.of(other))

    def __radd__(self, other: Any) -> BoundedNumber:
        return self + other

    def __rsub__(self, other: Any) -> BoundedNumber:
        return (-self) + other

    def __rmul__(self, other: Any) -> BoundedNumber:
        return self * other

    def __rtruediv__(self, other: Any) -> BoundedNumber:
        return BoundedNumber.of(other) / self

    def sqrt(self) -> BoundedNumber:
        """The root; of what may be negative, that of its positive part."""
        root = np.sqrt(np.maximum(self.mid, 0.0))
        low = np.sqrt(np.maximum(self.mid - self.err, 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            near = np.where(self.err == 0, 0.0, self.err / (root + low))
        far = np.sqrt(self.size)
        return _round_result(root, np.where(np.isfinite(near), np.minimum(near, far), far))


def _round_result(mid: Any, err: Any) -> BoundedNumber:
    """A result of one operation; an exact zero stays exact."""
    return BoundedNumber(mid, err * (1 + 8 * UNIT) + np.abs(mid) * UNIT)


def _wave(function: Callable[[Any], Any]) -> Callable[[Any], BoundedNumber]:
    """A sine or a cosine; of an exact 0 the value is exact."""

    def of(value: Any) -> BoundedNumber:
        angle = BoundedNumber.of(value)
        err = np.where(angle.zero, 0.0, np.minimum(angle.err, 2.0) + LIBRARY)
        return BoundedNumber(function(angle.mid), err)

    return of


_FUNCTIONS = {
    "sin": _wave(np.sin),
    "cos": _wave(np.cos),
    "sqrt": lambda value: BoundedNumber.of(value).sqrt(),
    "Abs": lambda value: BoundedNumber(
        np.abs(BoundedNumber.of(value).mid), BoundedNumber.of(value).err
    ),
}


def compile_with_bounds(
    arguments: Sequence[sp.Symbol], values: Sequence[sp.Expr]
) -> Callable[..., list[BoundedNumber]]:
    """Expressions as a function of ``BoundedNumber`` arguments."""
    function = sp.lambdify(list(arguments), list(values), modules=[_FUNCTIONS], cse=True)

    def evaluate(*given: Any) -> list[BoundedNumber]:
        return [BoundedNumber.of(e) for e in function(*map(BoundedNumber.of, given))]

    return evaluate
