"""Bodies, their kinetic energy, and where their mass centres go.

A model may give a point a velocity that is the rate of no function of the coordinates: the contact
point of a rolling disc is at rest, and its centre moves as the rolling lets it.  A Lagrangian of
the coordinates alone would then be wrong.  The place of such a point is a fibre coordinate of its
own, and the velocity that the model gives it a constraint.

Generalized speeds are solved for the rates of coordinates.  Vectors of SymPy's are three components
in the engine's symbols.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.elimination import null_vectors, solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.normal import shortest
from voronec.algebra.rank import generic_rows
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.terms import expand_short
from voronec.algebra.verdicts import all_vanish
from voronec.errors import DefinitionError, EngineLimit

ZERO = se.Integer(0)


@dataclass
class Places:
    """Fibre coordinates for places that no function of the coordinates gives.

    ``name`` makes the symbol of a new coordinate's velocity out of a body and an axis; ``meaning``
    says what independent speeds are in terms of the rates of coordinates; ``rates`` are pairs of
    such symbols with the velocities that the model gives.  ``relations`` vanish on every motion, as
    that of a quaternion of length 1: only what holds along them counts.
    """

    coordinates: Sequence[Any]
    dots: Sequence[Any]
    time: Any
    name: Callable[[str, int], Any]
    meaning: Mapping[Any, Any]
    relations: Sequence[Any] = ()
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
        form, along = self.form(rate), self._along
        pairs = combinations(range(len(form)), 2)
        return self._vanishes(
            {(i, j): [form[j].diff(along[i]) - form[i].diff(along[j])] for i, j in pairs}
        )

    @property
    def _along(self) -> list[Any]:
        return [*self.coordinates, self.time]

    def _vanishes(self, table: Mapping[tuple[int, int], Sequence[Any]]) -> bool:
        """Whether two-forms with these entries vanish on what moves along the relations."""
        if vanish([e for entries in table.values() for e in entries]):
            return True
        if not self.relations:
            return False
        basis, count = self._tangents, len(next(iter(table.values())))
        along = [
            se.Add(*[(a[i] * b[j] - a[j] * b[i]) * entries[k] for (i, j), entries in table.items()])
            for a, b in combinations(basis, 2)
            for k in range(count)
        ]
        return bool(basis) and vanish(along, self.relations)

    @cached_property
    def _tangents(self) -> list[list[Any]]:
        """Rates of coordinates and time that keep the relations, as many as are free."""
        slopes = [[r.diff(q) for q in self._along] for r in self.relations]
        rows = [slopes[r] for r in constraint_rows(slopes, self.relations)]
        return null_vectors(rows, constraint_columns(slopes, self.relations), self.relations)

    def form(self, rate: Any) -> list[Any]:
        """The coefficients of the rates of the coordinates, and the rest."""
        rate = rate.xreplace(self.meaning)
        slopes = [rate.diff(d) for d in self.dots]
        return [*slopes, rate.xreplace(dict.fromkeys(self.dots, ZERO))]

    def turns_something(self, omega: Sequence[Any]) -> bool:
        """Whether an angular velocity, along axes at rest, is that of an orientation which the
        coordinates determine: d_i w_j - d_j w_i = w_i x w_j."""
        forms, along = [self.form(w) for w in omega], self._along
        table: dict[tuple[int, int], list[Any]] = {}
        for i, j in combinations(range(len(along)), 2):
            a, b = ([f[k] for f in forms] for k in (i, j))
            table[i, j] = []
            for axis in range(3):
                y, z = (axis + 1) % 3, (axis + 2) % 3
                curl = b[axis].diff(along[i]) - a[axis].diff(along[j])
                table[i, j].append(curl - (a[y] * b[z] - a[z] * b[y]))
        return self._vanishes(table)


def vanish(exprs: Sequence[Any], relations: Sequence[Any] = ()) -> bool:
    """Whether it is proved that all expressions vanish, where the relations do."""
    try:  # most vanish when they are multiplied out, which is quicker than a proof
        return all_vanish([e for e in map(expand_short, exprs) if e != 0], relations)
    except EngineLimit:
        return False


@dataclass(frozen=True)
class FreeBody:
    """A body in the engine's symbols: the velocity of its mass centre along axes at rest, and, of
    what turns, inertia, angular velocity, and that of ``axes``, in which these two are given.
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
    mass, rates = read.read(body.mass), read.of(velocity, frame)
    if mass != 0:  # the place of what has none matters to nothing
        rates = [places.place_rate(str(body.name), axis, rate) for axis, rate in enumerate(rates)]
    moved = FreeBody(body, mass, rates)
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
            "which the coordinates determine; add coordinates for its orientation with their "
            "kinematic equations, and what binds them, as of a quaternion"
        )
    axes = inertia.args[0][1].args[0][1]
    turning = in_one_line(lambda: axes.ang_vel_in(frame), what)
    return replace(
        moved,
        inertia=read.dyadic(inertia, axes),
        omega=read.of(turn, axes),
        turning=read.of(turning, axes),
        axes=axes,
    )


@dataclass(frozen=True)
class Speeds:
    """What each speed is in terms of the rates; what else the kinematic equations demand.

    ``unplaced`` are the positions of speeds that no coordinate belongs to: each is the rate of a
    coordinate of its own.
    """

    values: tuple[Any, ...]
    left_over: tuple[Any, ...]
    unplaced: tuple[int, ...]


def constraint_rows(rows: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> list[int]:
    """The rows that, one after the other, enlarge the span of those before, at a generic point:
    where relations vanish, or anywhere, if no point is found there."""
    failure = "no point was found at which the constraints of a model have values"
    try:
        return generic_rows(rows, relations, failure=failure)
    except EngineLimit:
        return generic_rows(rows, failure=failure)


def constraint_columns(rows: Sequence[Sequence[Any]], relations: Sequence[Any] = ()) -> list[int]:
    """The columns that, one after the other, enlarge the span of those before."""
    return constraint_rows([*zip(*rows, strict=True)], relations) if rows else []


def solve_speeds(
    equations: Sequence[Any], speeds: Sequence[Any], dots: Sequence[Any], fresh: Sequence[Any]
) -> Speeds:
    """Solve kinematic equations for the speeds; ``fresh[j]`` is the rate of the coordinate that
    speed j gets where no other belongs to it.  Where there are more equations than speeds, those
    that hold the least define the speeds: u = qdot does, and the others are constraints."""
    moving = {*speeds, *dots}
    equations = sorted(equations, key=lambda e: len(e.free_symbols & moving))
    rows = [[e.diff(u) for u in speeds] for e in equations]
    for row, equation in zip(rows, equations, strict=True):
        if any(e.free_symbols & moving for e in row):
            raise DefinitionError(
                f"from_mechanics: the kinematic equation {equation} = 0 is not linear in the "
                "speeds; solve it for the rates first"
            )
    kept = constraint_rows(rows)
    columns = constraint_columns([rows[i] for i in kept])
    unplaced = [j for j in range(len(speeds)) if j not in columns]
    at_rest = dict.fromkeys(speeds, se.Integer(0))
    left = [rows[i] for i in kept]
    right = [[-equations[i].xreplace(at_rest)] for i in kept]
    for j in unplaced:
        left.append([se.Integer(int(k == j)) for k in range(len(speeds))])
        right.append([fresh[j]])
    values = tuple(v[0] for v in solve_linear(left, right).values) if left else ()
    if any(e.free_symbols for row in left for e in row):
        values = _tidy(values)
    meaning = dict(zip(speeds, values, strict=True))
    rest = (equations[i].xreplace(meaning) for i in range(len(equations)) if i not in kept)
    return Speeds(values, tuple(rest), tuple(unplaced))


def _tidy(values: Sequence[Any]) -> tuple[Any, ...]:
    """In the shortest form, where that is within the budget: pivots that vanish somewhere, as the
    cosine of a yaw, are in vain in most of what they divide."""
    try:
        return tuple(shortest(values))
    except EngineLimit:
        return tuple(values)


def in_one_line(ask: Callable[[], Any], what: str) -> Any:
    """What SymPy answers; its refusal, as where nothing connects two frames, in one line."""
    try:
        return ask()
    except (ValueError, TypeError, NotImplementedError) as error:
        text = " ".join(str(error).split())
        raise DefinitionError(f"from_mechanics: {what}: {text}") from None


@dataclass
class Components:
    """Reads vectors; ``speed_values`` says what speeds stand for, inside."""

    bridge: SymPyBridge
    speed_values: Mapping[Any, Any] = field(default_factory=dict)
    _turns: dict[Any, Any] = field(default_factory=dict)

    def of(self, vector: Any, frame: Any) -> list[Any]:
        """The components of a vector along the axes of a frame."""
        total = [ZERO, ZERO, ZERO]
        for column, axes in getattr(vector, "args", ()):
            part = [self.read(c) for c in column]
            if axes != frame:
                part = [dot(row, part) for row in self._turn(frame, axes)]
            total = [a + b for a, b in zip(total, part, strict=True)]
        return total

    def dyadic(self, dyadic: Any, frame: Any) -> list[list[Any]]:
        """The components of a dyadic, as inertia is, along the axes of a frame."""
        table = [[ZERO] * 3 for _ in range(3)]
        for size, left, right in getattr(dyadic, "args", ()):
            a, b, m = self.of(left, frame), self.of(right, frame), self.read(size)
            for i in range(3):
                for j in range(3):
                    table[i][j] += m * a[i] * b[j]
        return table

    def read(self, expr: sp.Expr) -> Any:
        """An expression, speeds replaced by what they stand for."""
        return self.bridge.inward(expr).xreplace(self.speed_values)

    def _turn(self, frame: Any, own: Any) -> list[list[Any]]:
        """The matrix that takes components along ``own`` to those along ``frame``."""
        if (frame, own) not in self._turns:
            what = f"the axes of {own} and {frame}"
            matrix = in_one_line(lambda: frame.dcm(own), what)
            self._turns[frame, own] = [[self.read(e) for e in matrix.row(i)] for i in range(3)]
        return self._turns[frame, own]
