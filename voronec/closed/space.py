"""Turning a motion in space, so that the constant vector lies along the third axis, and back.

With E the moving frame in space and m the vector along it, K = E m is constant.  A rotation Q
takes the third axis to K / |K|; E' = Q^T E moves so that its vector is upright, and E = Q E'.

A frame is made of a longitude, a colatitude, and an angle about that axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.precision import FIRST, PROOF
from voronec.algebra.symbols import velocity
from voronec.algebra.verdicts import prove_equal
from voronec.closed.arithmetic import Function, ball, compile_expressions, precise
from voronec.closed.compiled_motion import CompiledMotion
from voronec.closed.problem import InversionProblem, nearest_whole
from voronec.declaration.quadratures import Space
from voronec.errors import DefinitionError, EngineLimit

ACROSS = sp.ImmutableMatrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
"""A position in which no coordinate of a contact is singular, for a vector that is zero."""


def turned_upright(space: Space, vector: Sequence[sp.Expr]) -> dict[Any, sp.Expr]:
    """Coordinates in space for which a vector, given along the moving frame, points upwards.

    The frame has the vector's direction as its third row; its second row is level, so that the
    longitude of a contact in space is zero.
    """
    entries: Mapping[Any, sp.Expr] = dict(zip(space.entries, _frame(*vector), strict=True))
    return {q: e.xreplace(entries) for q, e in space.coordinates.items()}


def _frame(a: sp.Expr, b: sp.Expr, c: sp.Expr) -> sp.Matrix:
    level = sp.expand(a**2 + b**2)
    size = sp.expand(level + c**2)
    if size == 0:
        return ACROSS
    third = sp.Matrix([[a, b, c]]) / sp.sqrt(size)
    second = sp.Matrix([[-b, a, 0]]) / sp.sqrt(level) if level != 0 else sp.Matrix([[0, 1, 0]])
    return sp.Matrix.vstack(second.cross(third), second, third)


LADDER = (FIRST, PROOF, 4 * PROOF)
"""Bits at which a vector is told to point upwards or down; one that all but lies counts as up."""
MOST = 1 << 12
"""Bits at which the start is computed, at most."""
SPARE = 24
"""Bits of it that may be lost."""


@dataclass(frozen=True, eq=False)
class Attitude:
    """How one motion lies in space."""

    problem: InversionProblem
    space: Space
    _kept: Memo = field(default_factory=Memo, repr=False)

    @cached_property
    def coordinates(self) -> tuple[Any, ...]:
        """The coordinates that are turned."""
        return tuple(self.space.coordinates)

    @cached_property
    def upright(self) -> bool:
        """Whether the vector lies along the third axis, upwards; decided exactly.

        Where no proof is found the motion is turned, by a small angle or none, which is as right.
        """
        # Seen from the frame: an angle about the third axis does not occur.
        axis = self.space.frame.row(2).T
        try:
            level = all(self.problem.sign(e) == 0 for e in self.space.vector.cross(axis))
            return level and self.problem.sign(self.space.vector.dot(axis)) > 0
        except EngineLimit:
            return False

    @cached_property
    def vanishes(self) -> bool:
        """Whether the vector is zero."""
        return all(self.problem.sign(e) == 0 for e in self.space.vector)

    @cached_property
    def machines(self) -> tuple[Function, Function, Function]:
        """Compiled: inputs to frame and vector, entries to coordinates, turned coordinates to the
        frame."""
        return self.problem.prepared.memo.once("frame in space", self._compile)

    def _compile(self) -> tuple[Function, Function, Function]:
        frame, vector, coordinates = self.space.frame, self.space.vector, self.coordinates
        foreign = frame.free_symbols - {*coordinates}
        if foreign:
            raise DefinitionError(
                f"the frame in space holds '{min(foreign, key=str)}', which is not among the "
                f"coordinates in space {', '.join(map(str, coordinates))}"
            )
        return (
            compile_expressions([*frame, *vector], self.problem.prepared.inputs),
            compile_expressions(self.space.coordinates.values(), tuple(self.space.entries)),
            compile_expressions(list(frame), coordinates),
        )

    def start(self, bits: int) -> tuple[list[Any], list[Any]]:
        """Frame (9, row by row) and vector (3) at the start."""

        def make() -> list[Any]:
            with precise(bits):
                return self.machines[0](self.problem.start_balls(bits))

        row = self._kept.once(("start", bits), make)
        return row[:9], row[9:]

    def turn(self, bits: int) -> list[Any]:
        """Q (9, row by row): the third axis to the direction of the vector."""
        return list(self._kept.once(("turn", bits), lambda: self._turn(bits)))

    def _turn(self, bits: int) -> list[Any]:
        with precise(bits):
            frame, vector = self.start(bits)
            a, b, c = times(frame, vector)
            size = (a * a + b * b + c * c).sqrt()
            return rotation_to([a / size, b / size, c / size], self.upper)

    @cached_property
    def upper(self) -> bool:
        """Whether the vector points upwards, as far as this can be told."""
        for bits in LADDER:
            with precise(bits):
                height = times(*self.start(bits))[2]
            if not height.contains(0):
                return bool(height > 0)
        return True

    def begin(self, bits: int) -> list[Any]:
        """The turned coordinates at the start, of E' = Q^T E, to nearly so many bits."""
        return list(self._kept.once(("begin", bits), lambda: self._sharply(bits)))

    def _sharply(self, bits: int) -> list[Any]:
        # near a pole of these coordinates entries of E' are small, their directions need more bits
        start, work = self._begin(bits), bits
        while work < MOST and not all(e.rad() < ball(2) ** (SPARE - bits) for e in start):
            work *= 2
            start = self._begin(work)
        return start

    def _begin(self, bits: int) -> list[Any]:
        with precise(bits):
            turned = product(transpose(self.turn(bits)), self.start(bits)[0])
            if self.is_aligned:
                # the directions in which these entries leave zero
                a, b, c = self.spin(bits)
                skew = [ball(0), -c, b, c, ball(0), -a, -b, a, ball(0)]
                moved = product(turned, skew)
                for i in (2, 5, 6, 7):
                    turned[i] = moved[i]
            return self.machines[1](turned)

    @cached_property
    def is_aligned(self) -> bool:
        """Whether the vector starts along the third direction of the frame: turned upright, the
        motion then starts at a pole, out of which it runs."""
        return all(self.problem.sign(e) == 0 for e in self.space.vector[:2])

    def shift_to_branch(self, read: list[Any], bits: int) -> dict[Any, Any]:
        """Coordinates from those read off the frame: on the branch on which the motion starts.

        A colatitude that starts below 0 or above pi goes on there.
        """
        shifted = {}
        with precise(bits):
            for q, e, (side, turns) in zip(self.coordinates, read, self.branches, strict=True):
                shifted[q] = side * e + turns * ball(1).pi()
        return shifted

    @cached_property
    def branches(self) -> list[tuple[int, int]]:
        """(sign, half turns) of each coordinate: value = sign (value read off) + turns pi."""
        colatitudes = {t.colatitude for t in self.problem.prepared.motion.traces}

        def halves(bits: int, i: int, q: Any) -> Any:
            read = self.machines[1](self.start(bits)[0])[i]
            return (self.problem.start_by_symbol(bits)[q] - read) / ball(1).pi()

        pairs = []
        for i, q in enumerate(self.coordinates):
            if q in colatitudes:
                side, turns = self.problem.branch(q)
                pairs.append((side, 2 * turns))
            else:
                pairs.append((1, nearest_whole(partial(halves, i=i, q=q))))
        return pairs

    def spin(self, bits: int) -> list[Any]:
        """Angular velocity of the frame along itself (3) at the start: E^T dE/dt."""
        with precise(bits):
            rates = self.rates(bits)
            flat = self._slopes(self.problem.start_balls(bits))
            moved = [sum((flat[9 * k + i] * r for k, r in enumerate(rates)), ball(0))
                     for i in range(9)]  # fmt: skip
            skew = product(transpose(self.start(bits)[0]), moved)
            return [skew[7], skew[2], skew[3]]

    @cached_property
    def _slopes(self) -> Function:
        """The slopes of the frame by the coordinates, compiled."""
        coordinates = self.problem.prepared.system.coordinates
        slopes = [sp.diff(e, q) for q in coordinates for e in self.space.frame]
        return compile_expressions(slopes, self.problem.prepared.inputs)

    @cached_property
    def _rate_equations(self) -> Function:
        """Rows and right sides of the equations for the velocities of all coordinates, compiled."""
        system = self.problem.prepared.system
        dots = [sp.Dummy() for _ in system.coordinates]
        unknown = dict(zip(map(velocity, system.coordinates), dots, strict=True))
        rows = [e.xreplace(unknown) for e in system.constraints]
        if system.frame is None:
            rows += [unknown[v] - v for v in system.velocities]
        else:
            pairs = zip(system.frame.velocities, system.frame.expressions, strict=True)
            rows += [e.xreplace(unknown) - v for v, e in pairs]
        still = dict.fromkeys(dots, sp.Integer(0))
        table = [sp.diff(e, d) for e in rows for d in dots]
        table += [-e.xreplace(still) for e in rows]
        return compile_expressions(table, self.problem.prepared.inputs)

    def rates(self, bits: int) -> list[Any]:
        """The velocities of all coordinates at the start, by frame and constraints."""
        from flint import arb_mat

        with precise(bits):
            flat = self._rate_equations(self.problem.start_balls(bits))
            n = len(self.problem.prepared.system.coordinates)
            left = arb_mat(n, n, flat[: n * n])
            return list(left.solve(arb_mat(n, 1, flat[n * n :])).entries())


def times(matrix: Sequence[Any], vector: Sequence[Any]) -> list[Any]:
    """A matrix, row by row, times a vector."""
    return [sum((matrix[3 * i + j] * vector[j] for j in range(1, 3)), matrix[3 * i] * vector[0])
            for i in range(3)]  # fmt: skip


def product(first: Sequence[Any], second: Sequence[Any]) -> list[Any]:
    """Of two matrices, row by row."""
    return [
        sum((first[3 * i + k] * second[3 * k + j] for k in range(1, 3)), first[3 * i] * second[j])
        for i in range(3)
        for j in range(3)
    ]


def transpose(matrix: Sequence[Any]) -> list[Any]:
    """Row by row."""
    return [matrix[3 * j + i] for i in range(3) for j in range(3)]


def rotation_to(axis: Sequence[Any], upper: bool) -> list[Any]:
    """A rotation of the third axis to a unit vector: the smallest one, or, to one that points
    downwards, half a turn about the first axis and the smallest one from its lower end."""
    if upper:
        return _towards(*axis)
    q = _towards(*(-e for e in axis))
    return [q[0], -q[1], -q[2], q[3], -q[4], -q[5], q[6], -q[7], -q[8]]


def _towards(a: Any, b: Any, c: Any) -> list[Any]:
    """The smallest rotation of the third axis to a unit vector that is not its opposite."""
    s = 1 / (1 + c)
    return [1 - a * a * s, -a * b * s, a, -a * b * s, 1 - b * b * s, b, -a, -b, c]


@dataclass(frozen=True)
class FrameProduct:
    """``frame = Rz(longitude) Ry(colatitude) Rz(sense third) F`` with F constant.

    Attributes:
        trace: which of the declared traces has this longitude and colatitude.
        longitude: of one direction of the frame, in space.
        colatitude: of the same.
        third: the angle about that direction.
        sense: 1 or -1, how it is counted.
    """

    trace: int
    longitude: Any
    colatitude: Any
    third: Any
    sense: int


def composition(own: CompiledMotion) -> FrameProduct | None:
    """How the coordinates in space of a motion turn its frame; proved.  None where they do not in
    this way."""
    return own.memo.once("composition", lambda: _composition(own))


def _composition(own: CompiledMotion) -> FrameProduct | None:
    space = own.motion.space
    if space is None:
        return None
    for i, trace in enumerate(own.motion.traces):
        rest = [q for q in space.coordinates if q not in (trace.longitude, trace.colatitude)]
        if len(rest) != 1 or len(space.coordinates) != 3 or rest[0] not in own.motion.angles:
            continue
        for sense in (1, -1):
            parts = FrameProduct(i, trace.longitude, trace.colatitude, rest[0], sense)
            if _holds(space.frame, parts):
                return parts
    return None


def _holds(frame: sp.Matrix, parts: FrameProduct) -> bool:
    """Whether F is free of the coordinates."""
    names = (parts.longitude, parts.colatitude, parts.third)
    v, c, b = symbols = sp.symbols("longitude colatitude third", cls=sp.Dummy)
    turned = sp.Matrix(frame.xreplace(dict(zip(names, symbols, strict=True))))
    rest = _about_third(-parts.sense * b) * _about_second(-c) * _about_third(-v) * turned
    still = rest.xreplace(dict.fromkeys(symbols, sp.Integer(0)))
    return all(prove_equal(e, f).proved for e, f in zip(rest, still, strict=True))


def _about_third(angle: Any) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def _about_second(angle: Any) -> sp.Matrix:
    c, s = sp.cos(angle), sp.sin(angle)
    return sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]])
