"""The relations between redundant coordinates in numbers, and the nearest point on them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from voronec.program import Program, compiled

if TYPE_CHECKING:
    from voronec.derivation import FirstOrderForm

__all__ = ["Relations"]

STEPS = 500
"""How many steps towards the nearest point are tried."""
DAMPINGS = (1.0, 0.3, 0.1)
"""Parts of a full step: where full steps run back and forth, shorter ones do not."""
STILL = 1e-14
"""A step below this part of the coordinates' size is the last."""
DEPENDENT = 1e-10
"""Gradients whose singular values are below this part of the largest count as dependent."""


@dataclass(frozen=True)
class Relations:
    """r(q) = 0 at given parameters and time: ``evaluate(q)`` gives r (m,) and dr/dq (m, n)."""

    evaluate: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]

    @classmethod
    def of(cls, form: FirstOrderForm, parameters: Mapping[str, float], time: float) -> Relations:
        """The relations of a first-order form."""
        m, n = len(form.relations), len(form.coordinates)
        # the equations of motion play no part: a form that stands still is compiled at once
        symbols, extras = _residuals_and_slopes(replace(
            form, velocities=(), rates=(0,) * n, mass=(), force=(), definitions=(), dependent=(),
            stages=(),
        ))  # fmt: skip
        values = [np.float64(parameters.get(str(p), np.nan)) for p in symbols]

        def evaluate(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            with np.errstate(all="ignore"):
                flat: list[Any] = extras(np.float64(time), list(q), values)
            numbers = np.array(flat, dtype=float)
            return numbers[:m], numbers[m:].reshape(m, n)

        return cls(evaluate)

    def residuals(self, q: np.ndarray) -> np.ndarray:
        """What the relations leave at q, which ought to vanish."""
        return self.evaluate(q)[0]

    def nearest(self, q: np.ndarray, accuracy: float) -> np.ndarray | None:
        """The point on the relations at the least distance from q; None where none is found.

        Gauss and Newton: from p the next point is the nearest to q on the relations made linear
        at p.  Where that stands still, q - p is normal to the relations.
        """
        for damping in DAMPINGS:
            found = self._iterated(q, damping)
            if found is not None and np.abs(self.residuals(found)).max() < accuracy:
                return found
        return None

    def _iterated(self, q: np.ndarray, damping: float) -> np.ndarray | None:
        p = q
        for _ in range(STEPS):
            off, slopes = self.evaluate(p)
            if not (np.isfinite(off).all() and np.isfinite(slopes).all()):
                return None
            away = q - p
            normal = np.linalg.lstsq(slopes, off + slopes @ away, rcond=DEPENDENT)[0]
            step = damping * (away - normal)
            p = p + step
            if np.linalg.norm(step) <= STILL * (1.0 + np.linalg.norm(p)):
                return p
        return None


@lru_cache(maxsize=16)  # each of many starts asks for it
def _residuals_and_slopes(form: FirstOrderForm) -> tuple[tuple[Any, ...], Callable[..., Any]]:
    """The parameters of a function for the relations and then their slopes, row by row; and it."""
    slopes = [r.diff(q) for r in form.relations for q in form.coordinates]
    program = Program.of(form, {str(i): e for i, e in enumerate([*form.relations, *slopes])})
    return program.parameters, compiled(program)[1]
