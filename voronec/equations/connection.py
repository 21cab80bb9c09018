"""The Ehresmann connection that constraints define, and its curvature.

    rdot = E v + e0,   sdot = a v + a0                     r over the base, s over the fibre
    h_i = E_i^b d_b + a_i^A d_A,   h_0 = d_t + e0^b d_b + a0^A d_A          horizontal lift
    [h_i, h_j] = c_ij^k h_k + B_ij^A d_A                   frame coefficients c, curvature B

Indices: i = 0..n-1 are the velocities v, index n is the time (v^n = 1)
[Theory, eqs. (4), (5), (6)].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.algebra.elimination import LinearSolution, solve_linear
from voronec.algebra.terms import factors_of, summands
from voronec.algebra.verdicts import decide_zero
from voronec.equations.group_frame import GroupFrame
from voronec.errors import DefinitionError

Tidy = Callable[[Sequence[Any]], list[Any]]


@dataclass(frozen=True)
class AffineForms:
    """Forms that are affine in the velocities: matrix * qdot + offset.

    ``matrix`` has a row a form and a column a coordinate, base coordinates first.
    """

    matrix: tuple[tuple[Any, ...], ...]
    offset: tuple[Any, ...]

    @classmethod
    def of(cls, exprs: Sequence[Any], velocities: Sequence[Any]) -> AffineForms | int:
        """Read the coefficients; the index of the first expression that is not affine, if any."""
        rows, offsets = [], []
        at_rest = {v: se.Integer(0) for v in velocities}
        for index, expr in enumerate(exprs):
            if any(n.free_symbols & at_rest.keys() for n in expr.atoms(se.sign, se.floor)):
                return index  # it jumps, and has no slope there
            row = tuple(expr.diff(v) for v in velocities)
            offset = expr.xreplace(at_rest)
            used = [v for v in velocities if v in expr.free_symbols]
            if any(se.has_symbol(d, v) for d in row for v in used):
                # velocities that only seem to occur; what is linear in pieces is not affine
                row = tuple(d.xreplace(at_rest) for d in row)
                whole = se.Add(offset, *[d * v for d, v in zip(row, velocities, strict=True)])
                if whole.has(se.nan) or not decide_zero(expr - whole).proved:
                    return index
            rows.append(row)
            offsets.append(offset)
        return cls(tuple(rows), tuple(offsets))

    def expressions(self, velocities: Sequence[Any]) -> list[Any]:
        """The forms as expressions in the velocities."""
        return [
            se.Add(o, *[e * v for e, v in zip(row, velocities, strict=True)])
            for row, o in zip(self.matrix, self.offset, strict=True)
        ]


@dataclass(frozen=True)
class FibreSolution:
    """sdot = S rdot + s0: the fibre velocities that the constraints determine.

    ``matrix[A][b]`` is S, the Voronec coefficients a_(nu i); ``offset[A]`` is s0.
    """

    matrix: tuple[tuple[Any, ...], ...]
    offset: tuple[Any, ...]


@dataclass(frozen=True)
class EhresmannConnection:
    """The horizontal lift of a frame: qdot_a = lift[a][i] v_i + lift[a][n].

    ``coordinates`` and ``time`` are symengine symbols; the first ``base`` of them are base ones.
    On a group the rows of the lift are components along its fields X_a in the place of d_a, the
    first ``base`` of them those of the independent velocities.
    """

    coordinates: tuple[Any, ...]
    base: int
    velocities: tuple[Any, ...]
    time: Any
    lift: tuple[tuple[Any, ...], ...]
    group: GroupFrame | None = None

    @property
    def n(self) -> int:
        """The number of independent velocities; also the index of the time."""
        return len(self.velocities)

    @property
    def rates(self) -> list[Any]:
        """qdot as expressions in q, v, t; on a group, all velocities of its frame."""
        return [
            se.Add(*[h * v for h, v in zip(row, self.velocities, strict=False)], row[-1])
            for row in self.lift
        ]

    @cached_property
    def coordinate_lift(self) -> tuple[tuple[Any, ...], ...]:
        """The horizontal fields on the coordinates, a row for each."""
        if self.group is None:
            return self.lift
        columns = [self.group.coordinate_rates(column) for column in zip(*self.lift, strict=True)]
        return tuple(zip(*columns, strict=True))

    def along(self, i: int, function: Any, slope: Callable[..., Any] = se.diff) -> Any:
        """h_i(function): the derivative along a horizontal field; ``slope`` differentiates."""
        terms = [
            row[i] * slope(function, q)
            for q, row in zip(self.coordinates, self.coordinate_lift, strict=True)
            if row[i] != 0
        ]
        if i == self.n:
            terms.append(slope(function, self.time))
        return se.Add(*terms) if terms else se.Integer(0)

    def broken_relation(self, relations: Sequence[Any]) -> int | None:
        """The position of the first relation that some horizontal field does not keep, if any."""
        for k, relation in enumerate(relations):
            slopes = [self.along(i, relation) for i in range(self.n + 1)]
            if not all(decide_zero(slope, relations).proved for slope in slopes):
                return k
        return None

    def flow_derivative(
        self, function: Any, rates: Sequence[Any], slope: Callable[..., Any] = se.diff
    ) -> Any:
        """The derivative of a function of q, t (and v, held fixed) along the motion."""
        terms = [
            rate * slope(function, q)
            for q, rate in zip(self.coordinates, rates, strict=True)
            if rate != 0
        ]
        return se.Add(slope(function, self.time), *terms)

    def bracket(self, i: int, j: int) -> list[Any]:
        """The components of [h_i, h_j] on all coordinates, or along all fields of a group
        [Theory, eq. (18)]."""
        moved = [self.along(i, row[j]) - self.along(j, row[i]) for row in self.lift]
        if self.group is None:
            return moved
        turned = self.group.bracket([r[i] for r in self.lift], [r[j] for r in self.lift])
        return [m + t for m, t in zip(moved, turned, strict=True)]

    def decompose(
        self, i: int, j: int, dual: Sequence[Sequence[Any]], tidy: Tidy
    ) -> tuple[list[Any], list[Any]]:
        """c_ij^k and B_ij^A of a bracket; dual[k][b] recovers v_k from base velocities."""
        field = tidy(self.bracket(i, j))
        c = tidy([se.Add(*[d * x for d, x in zip(row, field, strict=False)]) for row in dual])
        vertical = [
            x - se.Add(*[ck * row[k] for k, ck in enumerate(c)])
            for x, row in zip(field[self.base :], self.lift[self.base :], strict=True)
        ]
        return c, tidy(vertical)


def shared_slopes(functions: Sequence[Any], variables: Sequence[Any]) -> Callable[..., Any]:
    """The derivatives of functions by variables, slope(function, variable).

    symengine differentiates what is shared once in a call.  So the functions are differentiated
    together, as a sum with a mark before each: apart, equal parts would be made again and again,
    and to find out that nested ones are equal takes 2^depth comparisons.
    """
    marks = {se.Symbol(f"mark {k}"): f for k, f in enumerate(dict.fromkeys(functions))}
    whole = se.Add(*[mark * f for mark, f in marks.items()])
    slopes: dict[Any, list[Any]] = {}
    for q in variables:
        for term in summands(whole.diff(q)):
            mark = next((part for part in factors_of(term) if part in marks), None)
            if mark is not None:
                slopes.setdefault((marks[mark], q), []).append(term / mark)
    return lambda function, q: se.Add(*slopes.get((function, q), ()))


def solve_fibre(
    constraints: AffineForms,
    relations: AffineForms,
    base: int,
    ideal: Sequence[Any],
    near: Mapping[str, Any] | None = None,
) -> tuple[FibreSolution, LinearSolution | None]:
    """Solve the constraints, with differentiated relations, for the fibre velocities.

    ``ideal`` are the relations themselves.  The elimination comes along for whoever asks what is
    free, dependent or contradictory: its rows are the constraints, then the relations that bind
    fibre velocities; its right sides the base velocities, then 1.  At the point ``near`` the
    solution is defined where possible.
    """
    binding = [i for i, row in enumerate(relations.matrix) if any(e != 0 for e in row[base:])]
    rows = [*constraints.matrix, *(relations.matrix[i] for i in binding)]
    offsets = [*constraints.offset, *(relations.offset[i] for i in binding)]
    if not rows:
        return FibreSolution((), ()), None
    left = [row[base:] for row in rows]
    right = [[-e for e in row[:base]] + [-o] for row, o in zip(rows, offsets, strict=True)]
    solution = solve_linear(left, right, ideal, len(constraints.matrix), near)
    fibre = FibreSolution(
        tuple(tuple(v[:-1]) for v in solution.values), tuple(v[-1] for v in solution.values)
    )
    return fibre, solution


class UndeterminedVelocities(DefinitionError):
    """Velocities that the given conditions leave open; ``free`` are their positions."""

    def __init__(self, free: Sequence[int]) -> None:
        super().__init__("the conditions leave velocities undetermined")
        self.free = tuple(free)


def coordinate_lift(fibre: FibreSolution, base: int) -> list[list[Any]]:
    """The lift of the base velocities: the unit matrix over S, the offset last."""
    rows = [[se.Integer(int(i == b)) for i in range(base)] + [se.Integer(0)] for b in range(base)]
    return rows + [[*s, o] for s, o in zip(fibre.matrix, fibre.offset, strict=True)]


def framed_lift(
    constraints: AffineForms,
    frame: AffineForms,
    relations: AffineForms,
    ideal: Sequence[Any],
    near: Mapping[str, Any] | None = None,
) -> list[list[Any]]:
    """The lift of quasi-velocities: constraints and definitions solved for all velocities at once.

    Raises ``UndeterminedVelocities`` where they leave velocities open, or fix more than they may.
    """
    n = len(frame.matrix)
    rows = [*constraints.matrix, *frame.matrix, *relations.matrix]
    nothing = [se.Integer(0)] * n
    right = [[*nothing, -o] for o in constraints.offset]
    right += [
        [se.Integer(int(i == k)) for i in range(n)] + [-o] for k, o in enumerate(frame.offset)
    ]
    right += [[*nothing, -o] for o in relations.offset]
    preferred = len(rows) - len(relations.matrix)
    solution = solve_linear(rows, right, ideal, preferred, near)
    if solution.free or solution.contradictory or any(i < preferred for i in solution.dependent):
        raise UndeterminedVelocities(solution.free)
    return solution.values


def dual_rows(frame: AffineForms, fibre: FibreSolution, base: int) -> list[list[Any]]:
    """v_k = dual[k][b] rdot_b + ...: the frame on the constraints, in base velocities alone."""
    return [
        [
            row[b] + se.Add(*[w * s[b] for w, s in zip(row[base:], fibre.matrix, strict=True)])
            for b in range(base)
        ]
        for row in frame.matrix
    ]
