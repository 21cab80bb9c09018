"""Reaction forces along a motion: the multipliers of the constraints, from the accelerations.

    r_a = d/dt dL/dw^a - X_a L + C_ab^c w^b dL/dw^c - Q_a = (A^T lambda)_a     [Theory, eq. (19)]

w are the velocities of the coordinates (X_a = d/dq_a and no brackets), or those of a group's
frame; A holds the constraints as they are given, and the derivatives of the relations between
redundant coordinates.  The accelerations v' come from the equations of motion; w' solves the
differentiated conditions on the velocities.  Both systems are linear, small, and solved in numbers
on the whole grid at once: nothing is inverted in symbols.

Events need functions of the state.  There the same systems are solved by steps of elimination that
share their parts, as an expression graph, of which a program makes assignments: with independent
rows A, lambda solves A A^T lambda = A r.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import symengine as se

from voronec.algebra.matrices import dot
from voronec.algebra.points import sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.rank import independent_rows
from voronec.algebra.shape import operations
from voronec.algebra.tape import Tape
from voronec.algebra.text import as_expression
from voronec.equations.definition import Definition
from voronec.equations.program.low_rank import solve_mass, solve_symmetric
from voronec.equations.program.straight import without_stages
from voronec.errors import DefinitionError, EngineLimit

if TYPE_CHECKING:
    from voronec.equations.derivation import FirstOrderForm
    from voronec.equations.voronec_equations import VoronecEquations

DEPENDENT = 1e-11
"""A singular value below this part of the largest counts as zero."""
CANCELLATION = 1e4
"""Digits are lost where terms are so many times larger than what is left of them: four of the
sixteen of a double."""
LONGEST = 2000
"""Expressions of more operations, as those of a bicycle, take minutes to be written as programs;
of eight constraints elimination without pivots may lose all digits."""
PART = 1e-8
"""A multiplier with a larger part in a vector that A^T annihilates is not unique."""


@dataclass(frozen=True)
class Multipliers:
    """What the reactions are computed from, at each instant.

    ``entries`` maps names to expressions in q, w, t and the parameters, as ``Program.of`` takes
    them.  They and the constant ``fixed`` numbers, both by position, make up one after the other:
    the mass matrix d2L/dw2 (N x N), the part of r without accelerations (N), the conditions on the
    velocities (rows x N) and their rates at fixed w (rows).  The first ``count`` rows are the
    constraints, those up to ``exact`` the relations, the last ones define the ``velocities`` v,
    whose rates are needed too.
    """

    count: int
    exact: int
    width: int
    velocities: tuple[Any, ...]
    entries: Mapping[str, Any]
    fixed: Mapping[int, Any]

    @classmethod
    def of(cls, d: Definition) -> Multipliers:
        """The multipliers of a system, from its definition as it was read.

        Raises ``DefinitionError`` where they are not unique at generic points.
        """
        _independent(d)
        rates = d.group.coordinate_rates(d.dots) if d.group is not None else d.dots
        conditions = conditions_of(d)
        momenta = [d.lagrangian.diff(w) for w in d.dots]
        mass = [p.diff(w) for p in momenta for w in d.dots]
        if d.added:  # accelerations in forces
            mass = [m - e for m, e in zip(mass, (e for row in d.added for e in row), strict=True)]
        rows = [entry for form in conditions for entry in form[:-1]]
        drifts = []
        for form in conditions:
            terms = (entry * w for entry, w in zip(form, d.dots, strict=False))
            drifts.append(drift(d, rates, se.Add(form[-1], *terms)))
        flat = [*mass, *_still(d, rates, momenta), *rows, *drifts]
        held = {i: se.sympify(e) for i, e in enumerate(flat)}
        return cls(
            count=len(d.constraints.matrix),
            exact=len(conditions) - len(d.velocities),
            width=len(d.dots),
            velocities=d.velocities,
            entries={_name(i): e for i, e in held.items() if e.free_symbols},
            fixed={i: e for i, e in held.items() if not e.free_symbols},
        )

    def solve(
        self, series: Mapping[str, Any], accelerations: Sequence[Any]
    ) -> tuple[np.ndarray, np.ndarray]:
        """lambda_k of constraint k, shape (instants, constraints), and at which instants digits
        are lost, (instants,): next to a pole of coordinates inertia and forces are large, and
        cancel.

        ``series`` holds the values of ``entries`` by name, ``accelerations`` those of v', each of
        shape (instants,); with mpmath numbers in them the precision in force is kept.  ``nan``
        where a multiplier is not unique, because constraints depend on each other or on the
        relations there, or where the equations are not defined.
        """
        inputs = [np.asarray(a) for a in (*accelerations, *series.values())]
        precise = any(a.dtype == object for a in inputs)
        mass, still, rows, right = self._matrices(series, accelerations, precise)
        transposed = np.swapaxes(rows[:, : self.exact], 1, 2)
        if precise:
            solutions = [
                _precise(*at) for at in zip(mass, still, rows, right, transposed, strict=True)
            ]
            solved = np.array(solutions, dtype=object).reshape(len(rows), -1)[:, : self.count]
            return solved, np.zeros(len(rows), dtype=bool)
        moved, unique = _least_squares(rows, right)
        moved = np.where(unique, moved, np.nan)
        applied = np.einsum("kij,kj->ki", mass, moved) + still
        multipliers, unique = _least_squares(transposed, applied)
        terms = np.einsum("kij,kj->ki", np.abs(mass), np.abs(moved)) + np.abs(still)
        largest, left = (np.abs(a).max(axis=1, initial=0.0) for a in (terms, applied))
        lost = largest > CANCELLATION * left
        return np.where(unique, multipliers, np.nan)[:, : self.count], lost

    def _matrices(
        self, series: Mapping[str, Any], accelerations: Sequence[Any], precise: bool
    ) -> tuple[Any, ...]:
        """Mass, forces at rest, conditions and the right sides of conditions * w' = right."""
        size, rows = self.width, self.exact + len(self.velocities)
        total = len(self.entries) + len(self.fixed)
        instants = max((np.size(a) for a in (*accelerations, *series.values())), default=1)
        flat = np.empty((instants, total), dtype=object if precise else float)
        for i in range(total):
            given = _name(i) in self.entries
            flat[:, i] = series[_name(i)] if given else _number(self.fixed[i], precise)
        cuts = np.cumsum([size * size, size, rows * size])
        mass, still, left, drift = np.split(flat, cuts, axis=1)
        right = -drift
        for i, acceleration in enumerate(accelerations):
            right[:, self.exact + i] += acceleration
        return mass.reshape(-1, size, size), still, left.reshape(-1, rows, size), right


def reactions_of_state(equations: VoronecEquations, d: Definition) -> list[Any]:
    """lambda_k of each constraint k of a definition in the engine's symbols, in q, w, t and the
    parameters.

    Raises ``DefinitionError`` where they are not unique at generic points, ``EngineLimit`` where
    they are too long.
    """
    multipliers, kept = Multipliers.of(d), _independent(d)
    total = len(multipliers.entries) + len(multipliers.fixed)
    flat = [multipliers.entries.get(_name(i), multipliers.fixed.get(i)) for i in range(total)]
    n = multipliers.width
    form = without_stages(equations.form, {})[0]
    moved = _accelerations(d, form)
    mass, still, rows = flat[: n * n], flat[n * n : n * n + n], flat[n * n + n :]
    applied = [dot(mass[i * n : i * n + n], moved) + still[i] for i in range(n)]
    forms = [rows[k * n : k * n + n] for k in kept]
    gram = [[dot(a, b) for b in forms] for a in forms]
    right = [dot(row, applied) for row in forms]
    reactions = dict(zip(kept, solve_symmetric(gram, right, se.sympify), strict=True))
    raw = [reactions[k].xreplace(form.rates_by_velocity) for k in range(multipliers.count)]
    return [_shorter(equations, e) for e in raw]


def _shorter(equations: VoronecEquations, raw: Any) -> Any:
    """The normal form of an expression, where the equations have one and it is shorter;
    ``EngineLimit`` for what is too long."""
    short = raw
    if not equations.is_large and equations.in_normal_form:
        with suppress(EngineLimit):
            short = min(raw, equations.exact.polish([raw])[0], key=lambda e: operations([e]))
    if operations([short]) > LONGEST:
        raise EngineLimit(
            f"system '{equations.system.name}': its reactions are too long for formulas, events "
            "and sections; ask for each as an output of its own, on a fine grid"
        )
    return short


def _accelerations(d: Definition, form: FirstOrderForm) -> list[Any]:
    """w' along the motion, from w(q, v, t)."""
    slopes = solve_mass(form.mass, form.force, se.sympify, form.parameters)
    moving = dict(zip((*form.coordinates, *form.velocities), (*form.rates, *slopes), strict=True))
    known = form.rates_by_velocity
    velocities = [se.sympify(known.get(w, w)).xreplace(known) for w in d.dots]
    return [
        e.diff(form.time) + se.Add(*[e.diff(x) * f for x, f in moving.items()]) for e in velocities
    ]


def _name(i: int) -> str:
    return f"for the reactions, {i}"


def _number(value: Any, precise: bool) -> Any:
    """A constant as a double, or as an mpmath number at the precision in force."""
    if not precise:
        return float(value)
    import mpmath as mp
    import sympy as sp

    digits = mp.mp.dps + 5
    return mp.mpf(sp.Float(as_expression(value).evalf(digits), digits)._mpf_)


def conditions_of(d: Definition) -> list[tuple[Any, ...]]:
    """Coefficients of w, then the offset: constraints, relations, definitions of v."""
    forms: list[tuple[Any, Any]] = [*zip(d.constraints.matrix, d.constraints.offset, strict=True)]
    forms += zip(d.differentiated.matrix, d.differentiated.offset, strict=True)
    if d.frame is not None:
        forms += zip(d.frame.matrix, d.frame.offset, strict=True)
    else:
        units = [[se.Integer(i == a) for a in range(len(d.dots))] for i in range(len(d.velocities))]
        forms += [(row, se.Integer(0)) for row in units]
    return [(*row, offset) for row, offset in forms]


def _independent(d: Definition) -> list[int]:
    """Which rows of constraints, then relations, are independent; ``DefinitionError`` where a
    constraint depends on others: constraints do not, but together with the relations they may."""
    slopes = [[r.diff(q) for q in d.coordinates] for r in d.relations]
    if d.group is not None:  # along the fields X_a
        fields = [*zip(*d.group.fields, strict=True)]
        slopes = [[dot(row, field) for field in fields] for row in slopes]
    forms = [*d.constraints.matrix, *slopes]
    count, width = len(d.constraints.matrix), len(d.dots)
    if len(forms) == count:
        return [*range(count)]
    tape = Tape([entry for form in forms for entry in form])
    for _, values in sample_evaluable(tape, d.relations, GENERIC, count=1):
        rows = [values[i : i + width] for i in range(0, len(values), width)]
        kept = independent_rows(rows, GENERIC)
        rank = len(kept)
        for k in range(count):
            if len(independent_rows(rows[:k] + rows[k + 1 :], GENERIC)) == rank:
                raise DefinitionError(
                    f"system '{d.system.name}': 'reaction {k + 1}' is not unique, because "
                    f"constraint {k + 1} depends on the others and the relations; "
                    "voronec.reaction_forces gives the forces along the coordinates"
                )
        return list(kept)
    return [*range(count)]


def drift(d: Definition, rates: Sequence[Any], expr: Any) -> Any:
    """The time derivative at fixed w."""
    terms = (expr.diff(q) * rate for q, rate in zip(d.coordinates, rates, strict=True))
    return se.Add(expr.diff(d.time), *terms)


def _still(d: Definition, rates: Sequence[Any], momenta: Sequence[Any]) -> list[Any]:
    """The part of r that holds no w'.

    With P = (dL/dq) qdot + dL/dt, d/dt dL/dw^a at fixed w is dP/dw^a - X_a L, since X_a is linear.
    """
    power = drift(d, rates, d.lagrangian)
    slopes = [d.lagrangian.diff(q) for q in d.coordinates]
    result = []
    for a, (w, applied) in enumerate(zip(d.dots, d.forces, strict=True)):
        along = se.Add(*[s * rate.diff(w) for s, rate in zip(slopes, rates, strict=True)])
        terms = [power.diff(w), -2 * along, -applied]
        if d.group is not None:
            unit = [se.Integer(b == a) for b in range(len(d.dots))]
            turned = d.group.bracket(unit, d.dots)
            terms += [t * p for t, p in zip(turned, momenta, strict=True)]
        result.append(se.Add(*terms))
    return result


def _least_squares(matrices: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The shortest x with matrix x = right in the mean, and which of its entries are unique.

    Shapes (k, rows, n) and (k, rows) give (k, n) twice.  Columns are scaled to unit length, so
    that units play no part in what counts as dependent.
    """
    sound = np.isfinite(matrices).all(axis=(1, 2)) & np.isfinite(right).all(axis=1)
    matrices = np.where(sound[:, None, None], matrices, 0.0)
    lengths = np.linalg.norm(matrices, axis=1)
    lengths[lengths == 0] = 1.0
    u, sizes, vt = np.linalg.svd(matrices / lengths[:, None, :], full_matrices=True)
    count, n = sizes.shape[1], matrices.shape[2]
    kept = sizes > DEPENDENT * sizes.max(axis=1, initial=0.0, keepdims=True)
    inverse = np.divide(1.0, sizes, where=kept, out=np.zeros_like(sizes))
    parts = np.einsum("kri,kr->ki", u[:, :, :count], np.where(sound[:, None], right, 0.0))
    solution = np.einsum("kin,ki->kn", vt[:, :count], parts * inverse)
    null = np.ones((len(matrices), n), dtype=bool)
    null[:, :count] = ~kept
    reach = np.abs(np.where(null[:, :, None], vt, 0.0)).max(axis=1, initial=0.0)
    return solution / lengths, (reach <= PART) & sound[:, None]


def _precise(
    mass: np.ndarray, still: np.ndarray, rows: np.ndarray, right: np.ndarray, forms: np.ndarray
) -> list[Any]:
    """The multipliers at one instant, at mpmath's working precision."""
    import mpmath as mp

    if not all(mp.isfinite(x) for part in (mass, still, rows, right) for x in part.flat):
        return [mp.nan] * forms.shape[1]
    with mp.workprec(2 * mp.mp.prec):  # the normal equations square the condition number
        try:
            moved = mp.lu_solve(mp.matrix(rows.tolist()), mp.matrix(right.tolist()))
            applied = mp.matrix(mass.tolist()) * moved + mp.matrix(still.tolist())
            solution = mp.lu_solve(mp.matrix(forms.tolist()), applied)
        except (ValueError, ZeroDivisionError):
            return [mp.nan] * forms.shape[1]
    return [+value for value in solution]
