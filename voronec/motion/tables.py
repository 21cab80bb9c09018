"""Tables of an input: values at instants, held or interpolated between them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from voronec.declaration.reading import doubles
from voronec.declaration.table_file import KINDS, require_table
from voronec.errors import DefinitionError
from voronec.motion.steppers.signals import Signal

__all__ = ["Table"]

DEGREES = dict(zip(KINDS, (0, 1, 3), strict=True))
"""The degree of the polynomial between two instants."""


@dataclass(frozen=True)
class Table:
    """An input by its ``values`` (k,) at ``times`` (k,), which grow.

    ``kind``
        ``held``: each value holds until the next instant, the last one for ever; ``linear``:
        straight lines between the values; ``cubic``: the spline with two continuous derivatives
        (scipy's ``CubicSpline``).

    At the instants a run starts anew, so that no step goes over a corner.
    """

    times: Any
    values: Any
    kind: str = "linear"

    def __post_init__(self) -> None:
        if self.kind not in DEGREES:
            raise DefinitionError(
                f"a table is of kind '{self.kind}'; kinds are {', '.join(DEGREES)}"
            )
        times = doubles(self.times, "the times of a table")
        values = doubles(self.values, "the values of a table")
        for name, array in (("times", times), ("values", values)):
            if array.ndim != 1:
                shape = " x ".join(map(str, array.shape)) or "a single number"
                raise DefinitionError(
                    f"the {name} of a table are {shape}; give a list of numbers, such as [0, 1, 2]"
                )
        require_table(times.tolist(), values.tolist(), self.kind)
        for name, array in (("times", times), ("values", values)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def signal(self, name: str) -> Signal:
        """The polynomials between the instants, exactly as the doubles give them."""
        times = tuple(map(Fraction, self.times.tolist()))
        values = tuple(map(Fraction, self.values.tolist()))
        last = inf if self.kind == "held" else float(times[-1])
        if self.kind == "held":
            pieces: tuple[Any, ...] = tuple((v,) for v in values)
        elif self.kind == "linear":
            pieces = tuple(
                (values[k], (values[k + 1] - values[k]) / (times[k + 1] - times[k]))
                for k in range(len(times) - 1)
            )
        else:
            from scipy.interpolate import CubicSpline

            highest_first = CubicSpline(self.times, self.values).c
            factors = (1, 1, 2, 6)
            pieces = tuple(
                tuple(Fraction(float(c)) * f for c, f in zip(column[::-1], factors, strict=True))
                for column in highest_first.T
            )
        return Signal(
            name, DEGREES[self.kind], f"a {self.kind} table", first=float(times[0]), last=last,
            instants=times, pieces=pieces,
        )  # fmt: skip
