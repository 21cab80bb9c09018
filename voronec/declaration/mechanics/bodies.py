"""Bodies, their kinetic energy, and where their mass centres go.

A model may give a point a velocity that is the rate of no function of the coordinates: the contact
point of a rolling disc is at rest, and its centre moves as the rolling lets it.  A Lagrangian of
the coordinates alone would then be wrong.  The place of such a point is a fibre coordinate of its
own, and the velocity that the model gives it a constraint.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Any

import symengine as se

from voronec.algebra.verdicts import all_vanish
from voronec.declaration.mechanics.vectors import ZERO, Components, dot, in_one_line
from voronec.errors import DefinitionError, EngineLimit

__all__ = ["FreeBody", "Places", "free_body", "vanish"]


@dataclass
class Places:
    """Fibre coordinates for places that no function of the coordinates gives.

    ``name`` makes the symbol of a new coordinate's velocity out of a body and an axis; ``meaning``
    says what independent speeds are in terms of the rates of coordinates; ``rates`` are pairs of
    such symbols with the velocities that the model gives.
    """

    coordinates: Sequence[Any]
    dots: Sequence[Any]
    time: Any
    name: Callable[[str, int], Any]
    meaning: Mapping[Any, Any]
    rates: list[tuple[Any, Any]] = field(default_factory=list)
    _axes: dict[int, list[tuple[Any, Any]]] = field(default_factory=dict)

    def place_rate(self, body: str, axis: int, rate: Any) -> Any:
        """A velocity along an axis at rest as the rate of something: of a function of the
        coordinates, of a place that there is already and such a function, or of a new place."""
        if self._is_exact(rate):
            return rate
        for dot_symbol, other in self._axes.setdefault(axis, []):
            if self._is_exact(rate - other):
                return dot_symbol + (rate - other)
        symbol = self.name(body, axis)
        self._axes[axis].append((symbol, rate))
        self.rates.append((symbol, rate))
        return symbol

    def _is_exact(self, rate: Any) -> bool:
        form = self.form(rate)
        pairs = combinations(range(len(form)), 2)
        along = [*self.coordinates, self.time]
        curls = [form[j].diff(along[i]) - form[i].diff(along[j]) for i, j in pairs]
        return vanish(curls)

    def form(self, rate: Any) -> list[Any]:
        """The coefficients of the rates of the coordinates, and the rest."""
        rate = rate.xreplace(self.meaning)
        slopes = [rate.diff(d) for d in self.dots]
        return [*slopes, rate.xreplace(dict.fromkeys(self.dots, ZERO))]

    def turns_something(self, omega: Sequence[Any]) -> bool:
        """Whether an angular velocity, along axes at rest, is that of an orientation which the
        coordinates determine: d_i w_j - d_j w_i = w_i x w_j."""
        forms = [self.form(w) for w in omega]
        along = [*self.coordinates, self.time]
        defects = []
        for i, j in combinations(range(len(along)), 2):
            a, b = ([f[k] for f in forms] for k in (i, j))
            for axis in range(3):
                y, z = (axis + 1) % 3, (axis + 2) % 3
                curl = b[axis].diff(along[i]) - a[axis].diff(along[j])
                defects.append(curl - (a[y] * b[z] - a[z] * b[y]))
        return vanish(defects)


def vanish(exprs: Sequence[Any]) -> bool:
    """Whether it is proved that all expressions vanish."""
    try:  # most vanish when they are multiplied out, which is quicker than a proof
        return all_vanish([e for e in map(se.expand, exprs) if e != 0])
    except EngineLimit:
        return False


@dataclass(frozen=True)
class FreeBody:
    """A body inside the door: the velocity of its mass centre along axes at rest, and, of what
    turns, inertia, angular velocity, and that of ``axes``, in which these two are given.
    ``model`` is what it was read from."""

    model: Any
    mass: Any
    velocity: Sequence[Any]
    inertia: Sequence[Sequence[Any]] = ((ZERO,) * 3,) * 3
    omega: Sequence[Any] = (ZERO,) * 3
    turning: Sequence[Any] = (ZERO,) * 3
    axes: Any = None

    @property
    def energy(self) -> Any:
        """m v^2 / 2 + w I w / 2."""
        spin = [dot(row, self.omega) for row in self.inertia]
        half = se.Rational(1, 2)
        return half * self.mass * dot(self.velocity, self.velocity) + half * dot(self.omega, spin)

    def bears(self, where: Any) -> bool:
        """Whether a load there is one at the mass centre, or one that turns the body."""
        turns = self.axes is not None and where == self.model.frame
        return turns or where == self.model.masscenter


def free_body(body: Any, frame: Any, read: Components, places: Places) -> FreeBody:
    """A ``Particle`` or a ``RigidBody``, read."""
    velocity = in_one_line(lambda: body.masscenter.vel(frame), f"the velocity of '{body.name}'")
    rates = [
        places.place_rate(str(body.name), axis, rate)
        for axis, rate in enumerate(read.of(velocity, frame))
    ]
    moved = FreeBody(body, read.read(body.mass), rates)
    if not hasattr(body, "central_inertia"):
        return moved
    what = f"the rotation of '{body.name}'"
    turn = in_one_line(lambda: body.frame.ang_vel_in(frame), what)
    inertia = body.central_inertia
    if not getattr(inertia, "args", ()) or not turn.args:
        return moved
    if not places.turns_something(read.of(turn, frame)):
        raise DefinitionError(
            f"from_mechanics: the angular velocity of '{body.name}' is that of no orientation "
            "which the coordinates determine; add coordinates for its orientation, with their "
            "kinematic equations"
        )
    own = inertia.args[0][1].args[0][1]
    turning = in_one_line(lambda: own.ang_vel_in(frame), what)
    return replace(
        moved,
        inertia=read.dyadic(inertia, own),
        omega=read.of(turn, own),
        turning=read.of(turning, own),
        axes=own,
    )
