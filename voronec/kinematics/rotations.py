"""Charts of the rotation group, with the angular velocity in body and in space axes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name, velocity
from voronec.declaration.shapes import turn_about
from voronec.errors import DefinitionError
from voronec.kinematics.vectors import Vector, apply_matrix, column, cross, dot, matrix_product

SEQUENCES = tuple(
    "".join(axes) for axes in product("xyz", repeat=3) if axes[0] != axes[1] != axes[2]
)


@dataclass(frozen=True)
class Rotation:
    """The attitude of a rigid body: R takes body components of a vector to space components.

    matrix
        R, 3 x 3; its columns are the body axes seen from space.
    coordinates
        the coordinates of the chart.
    body_rates, space_rates
        the angular velocity omega in body axes, vee(R^T dR/dt), and in space axes,
        vee(dR/dt R^T); columns, linear in the velocities of the coordinates.
        omega has the unit 1/time, positive by the right-hand rule.
    relations
        expressions that vanish, for redundant coordinates: hand them to ``Fibration``.
        There R is orthogonal, and the rates are the angular velocity, on the relations only.
    """

    matrix: sp.ImmutableMatrix
    coordinates: tuple[sp.Expr, ...]
    body_rates: sp.ImmutableMatrix
    space_rates: sp.ImmutableMatrix
    relations: tuple[sp.Expr, ...] = ()

    @classmethod
    def euler(cls, sequence: str, *angles: Any) -> Rotation:
        """Three turns about body axes: R = R_i(angle 1) R_j(angle 2) R_k(angle 3).

        ``sequence`` is one of the twelve, as "zxz" (precession, nutation, spin) or "zyx" (yaw,
        pitch, roll); each turn is about an axis of the body as the turns before have left it.
        omega = sum of angle-velocities times axes.  The chart is singular where the first and the
        third axis coincide.  Anything else raises ``DefinitionError``.
        """
        if sequence not in SEQUENCES:
            raise DefinitionError(
                f"'{sequence}' is not an Euler sequence; use one of {', '.join(SEQUENCES)}"
            )
        return _euler(sequence, distinct_names(angles, 3, "Euler angles"))

    @classmethod
    def quaternion(cls, q0: Any, q1: Any, q2: Any, q3: Any) -> Rotation:
        """The unit quaternion q0 + q1 i + q2 j + q3 k: a chart without a singularity.

        With q = (q1, q2, q3), R = (q0^2 - q.q) 1 + 2 q q^T + 2 q0 hat(q); the body rates are
        twice the vector part of conj(q) dq/dt, the space rates that of dq/dt conj(q).
        ``relations`` holds q0^2 + q1^2 + q2^2 + q3^2 - 1.
        """
        names = distinct_names((q0, q1, q2, q3), 4, "quaternion components")
        scalar, vector = names[0], names[1:]
        dots = [velocity(name) for name in names]
        square = scalar**2 - dot(vector, vector)
        columns = []
        for i in range(3):
            axis = [sp.Integer(i == j) for j in range(3)]
            turned = cross(vector, axis)
            columns.append(
                [
                    sp.expand(square * axis[j] + 2 * vector[i] * vector[j] + 2 * scalar * turned[j])
                    for j in range(3)
                ]
            )
        swirl = cross(vector, dots[1:])
        along = [scalar * dots[i] - dots[0] * names[i] for i in (1, 2, 3)]
        body = [2 * a - 2 * c for a, c in zip(along, swirl, strict=True)]
        space = [2 * a + 2 * c for a, c in zip(along, swirl, strict=True)]
        relation = sum(name**2 for name in names) - 1
        matrix = sp.ImmutableMatrix(columns).T
        return cls(matrix, names, column(body), column(space), (relation,))

    @classmethod
    def entries(cls, symbols: Iterable[Any]) -> Rotation:
        """The nine entries of R themselves, row by row: a chart without a singularity.

        ``relations`` holds the six entries of R^T R - 1 on and above the diagonal.  They leave
        det R = +1 or -1; the initial state says +1, and the motion stays there.
        """
        names = distinct_names(tuple(symbols), 9, "entries of a rotation matrix")
        rows = [names[0:3], names[3:6], names[6:9]]
        columns = list(zip(*rows, strict=True))
        body = _rates_of_triad(columns)
        # the rows are the space axes seen from the body, which turn the opposite way
        space = [-rate for rate in _rates_of_triad(rows)]
        gram = [
            dot(columns[i], columns[j]) - sp.Integer(i == j) for i in range(3) for j in range(i, 3)
        ]
        return cls(sp.ImmutableMatrix(rows), names, column(body), column(space), tuple(gram))


def distinct_names(names: tuple[Any, ...], count: int, what: str) -> tuple[sp.Expr, ...]:
    """``count`` symbols with different names; ``DefinitionError`` tells what is wrong."""
    if len(names) != count:
        raise DefinitionError(f"{what}: {count} symbols are needed, {len(names)} are given")
    seen = set()
    for thing in names:
        if not is_symbolic_name(thing):
            raise DefinitionError(f"{what}: '{thing}' is not a symbol; use sympy.Symbol")
        name = plain_name(thing)
        if name in seen:
            raise DefinitionError(f"{what}: the symbol '{name}' is used twice; rename one of them")
        seen.add(name)
    return names


@lru_cache(maxsize=64)
def _euler(sequence: str, names: tuple[sp.Expr, ...]) -> Rotation:
    """The rotation by three turns, which bodies of a family share, and one body asks for twice."""
    pairs = [*zip(sequence, names, strict=True)]
    turns = [turn_about("xyz".index(axis), angle).tolist() for axis, angle in pairs]
    back = [[*zip(*turn, strict=True)] for turn in turns]
    first, second, third = (
        tuple(velocity(angle) if axis == letter else sp.Integer(0) for axis in "xyz")
        for letter, angle in pairs
    )
    # from the inside out: turns carry the rates about the axes before them, or behind
    body = _sum(third, apply_matrix(back[2], _sum(second, apply_matrix(back[1], first))))
    space = _sum(first, apply_matrix(turns[0], _sum(second, apply_matrix(turns[1], third))))
    return Rotation(matrix_product(*turns), names, column(body), column(space))


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _rates_of_triad(triad: Sequence[Sequence[sp.Expr]]) -> list[sp.Expr]:
    """The angular velocity of an orthonormal triad along its own axes: omega_1 = e_3 . de_2/dt."""
    moved = [[velocity(entry) for entry in axis] for axis in triad]
    return [dot(triad[(i + 2) % 3], moved[(i + 1) % 3]) for i in range(3)]
