"""A reference solution: outputs on a grid, and how far two independent runs of it agree."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import mpmath
import numpy as np

UNIT = 2.0**-53
"""The largest relative error of rounding to a double."""
NOTHING = 1e-20
"""An output that stays below this is zero, and is compared absolutely: |o| is one."""
FINEST_DIGITS = 80
"""Digits in which two runs are compared: more than any of their numbers has."""


@dataclass(frozen=True, eq=False)
class ReferenceSolution:
    """Values of the outputs, each of shape (k,), on the times ``t`` (k,).

    ``accuracy`` is the largest difference of the two runs in ``how``, relative to the size of the
    output; ``note`` says so where they agree only on a part of the grid that was asked for.
    ``condition``, where it is known, are the condition numbers of every output (k,).
    """

    t: np.ndarray
    values: Mapping[str, np.ndarray]
    accuracy: float
    how: tuple[str, ...]
    note: str = ""
    condition: Mapping[str, np.ndarray] = field(default_factory=dict)

    @property
    def provenance(self) -> str:
        """How it was made, in a line."""
        return "; ".join(self.how)

    @property
    def largest_condition(self) -> float:
        """The largest condition number of any output at any instant."""
        return max(float(c.max()) for c in self.condition.values())

    def errors(
        self, values: Mapping[str, Any], angles: Collection[str] = ()
    ) -> dict[str, np.ndarray]:
        """The errors of outputs, as ``difference`` says."""
        return {n: difference(x, self.values[n], n in angles) for n, x in values.items()}

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON; condition numbers to three digits."""
        return {
            "t": self.t.tolist(),
            "values": {n: x.tolist() for n, x in self.values.items()},
            "condition": {n: [float(f"{c:.3g}") for c in x] for n, x in self.condition.items()},
            "agreed": float(f"{self.accuracy:.2g}"),
            "made": self.provenance,
        }

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> ReferenceSolution:
        """From plain data."""
        values, condition = (
            {n: np.array(x) for n, x in data[k].items()} for k in ("values", "condition")
        )
        how = tuple(str(data["made"]).split("; "))
        return cls(np.array(data["t"]), values, float(data["agreed"]), how, condition=condition)


def agreement(
    t: np.ndarray,
    runs: Sequence[tuple[str, Mapping[str, np.ndarray]]],
    needed: float = np.inf,
    angles: Collection[str] = (),
) -> ReferenceSolution | None:
    """The reference that two named runs on the grid ``t`` (k,) make: the values of the first.

    It is cut where they differ by more than ``needed``; None where they do so at once.
    """
    (first, one), (second, two) = runs
    apart = np.max([difference(one[n], two[n], n in angles) for n in one], axis=0)
    wrong = np.nonzero(~(apart <= needed))[0]
    good = int(wrong[0]) if len(wrong) else len(apart)
    if good < 2:
        return None
    note = ""
    if good < len(apart):
        note = (
            f"the two runs agree to {needed:g} up to t = {t[good - 1]:g} only; "
            "the rest is not measured"
        )
    values = {n: np.asarray(x[:good], dtype=float) for n, x in one.items()}
    return ReferenceSolution(t[:good], values, float(apart[:good].max()), (first, second), note)


def output_sizes(outputs: np.ndarray) -> np.ndarray:
    """|o|, the largest value of every output (k, m) or (k,); one where it is always nothing."""
    largest = np.abs(outputs.astype(float)).max(axis=0)
    return np.where(largest > NOTHING, largest, 1.0)


def difference(values: Any, exact: Any, angle: bool = False) -> np.ndarray:
    """|values - exact| (k,) or (k, m), relative to the output's largest size.

    Of an angle the difference is taken modulo 2 pi, in radians.  Both may hold numbers of more
    digits than a double has, each of its own kind: mpmath's or heyoka's.
    """
    values, exact = np.asarray(values), np.asarray(exact)
    if object in (values.dtype, exact.dtype):
        with mpmath.workdps(FINEST_DIGITS):
            pairs = zip(values.flat, exact.flat, strict=True)
            gaps = [float(_digits(a) - _digits(b)) for a, b in pairs]
        apart = np.array(gaps).reshape(exact.shape)
    else:
        apart = np.asarray(values - exact, dtype=float)
    if angle:
        return np.abs((apart + np.pi) % (2 * np.pi) - np.pi)
    return np.abs(apart) / output_sizes(exact)


def _digits(value: Any) -> Any:
    return mpmath.mpf(value if isinstance(value, float | mpmath.mpf) else str(value))
