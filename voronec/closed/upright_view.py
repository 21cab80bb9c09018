"""A motion, turned upright, at a stretch of times: what there is to see of it, in doubles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from voronec.algebra.symbols import plain_name
from voronec.closed.bernstein import evaluate_form
from voronec.closed.expressions import reading_of, velocities_in_doubles
from voronec.closed.inverted_motion import InvertedMotion
from voronec.closed.rounded_constants import rounded_constants

__all__ = ["UprightView", "wrap_angle"]

TURN = 2 * np.pi


@dataclass(frozen=True, eq=False)
class UprightView:
    """Coordinates and velocities of a motion turned upright.

    Attributes:
        form: the motion.
        at: the elliptic motion, a ``Stretch`` of a sample.
        whole: whether angles are continuous, else in (-pi, pi].
        shifted: whether continuous angles start in (-pi, pi], whole turns less than they do.
    """

    form: InvertedMotion
    at: Any
    whole: bool
    shifted: bool = False

    def rows(self, plain: Sequence[str], circles: Sequence[Any]) -> list[np.ndarray]:
        """Coordinates and velocities by name, then cosine and sine of each of ``circles``."""
        coordinates = {plain_name(q): q for q in self.form.system.coordinates}
        found = [
            self.coordinate(coordinates[n]) if n in coordinates else self.velocities[n]
            for n in plain
        ]
        # continuous angles have lost digits late; those that start small are of one period only
        near = self if self.shifted else UprightView(self.form, self.at, False)
        for q in circles:
            angle = near.coordinate(q)
            found += [np.cos(angle), np.sin(angle)]
        return found

    def coordinate(self, q: Any) -> np.ndarray:
        """An angle that is an integral, a colatitude, or a place on a plane."""
        form, angles = self.form, self.form.quadratures.angles
        if q in angles:
            j = angles.index(q)
            whole, part = rounded_constants(form).starts[j]
            if self.whole:
                return np.asarray(self.at.integral(j, part if self.shifted else whole))
            return np.asarray(self.at.modulo(j, part))
        for i, trace in enumerate(form.quadratures.traces):
            if trace.colatitude == q:
                side, turns = rounded_constants(form).branches[i]
                plain = self.at.colatitude(*rounded_constants(form).reach[i])
                if (side, turns) == (1, 0):
                    return np.asarray(plain)
                moved = side * plain + turns * TURN
                return np.asarray(moved) if self.whole else wrap_angle(moved)
        return self.place[q]

    @cached_property
    def place(self) -> dict[Any, np.ndarray]:
        """On a plane."""
        form, plane, x = self.form, self.form.quadratures.plane, self.at.x
        assert plane is not None
        start, origin, (first, second) = rounded_constants(form).place
        moved = []
        for i, (a, b, c) in enumerate(rounded_constants(form).slides):
            whole = self.at.integral(len(form.quadratures.angles) + i)
            rest = (x - start) * (a + b * (x + start) / 2 + c * (x * x + x * start + start**2) / 3)
            moved.append(whole + rest)
        return {
            plane.place[0]: origin[0] + first * moved[0] - second * moved[1],
            plane.place[1]: origin[1] + second * moved[0] + first * moved[1],
        }

    @cached_property
    def velocities(self) -> dict[str, np.ndarray]:
        """The velocities of the equations, accurate relative to their size near the poles."""
        form, own, x = self.form, self.form.problem.prepared, self.at.x
        rates = self._rates()
        values: list[Any] = [*rounded_constants(form).level, x]
        for i in range(len(form.quadratures.traces)):
            south, north = (self.at.affine(*ends) for ends in rounded_constants(form).reach[i])
            offset, slope = rounded_constants(form).cosines[i]
            sine = rounded_constants(form).branches[i][0] * np.sqrt(south * north)
            with np.errstate(all="ignore"):
                values += [sine, offset + slope * x, -slope * self.at.rate / sine]
        values += rates[: len(form.quadratures.angles)]
        values += [self.coordinate(q) for q in reading_of(own).coordinates]
        values += [evaluate_form(p, *self._weights) for p in rounded_constants(form).polynomials]
        with np.errstate(all="ignore"):
            found = velocities_in_doubles(own)(*values)
        names = map(plain_name, form.system.velocities)
        return {n: np.broadcast_to(e, x.shape) for n, e in zip(names, found, strict=True)}

    @cached_property
    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Of both ends in x."""
        return self.at.affine(1.0, 0.0), self.at.affine(0.0, 1.0)

    def _rates(self) -> list[Any]:
        apart = [self.at.affine(*ends) for ends in rounded_constants(self.form).distances]
        found = []
        for numerator, used in rounded_constants(self.form).fractions:
            rate = evaluate_form(numerator, *self._weights)
            for i in used:
                rate = rate / apart[i]
            found.append(rate)
        return found


def wrap_angle(angle: np.ndarray) -> np.ndarray:
    """In (-pi, pi]."""
    return np.asarray(angle - TURN * np.ceil(angle / TURN - 0.5))
