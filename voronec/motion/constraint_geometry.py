"""The constraints of a system, its frame and its inertia at a place, in numbers.

All is told of the wide state: the coordinates and all their velocities.

At a point where the constraints A w + a = 0 are independent, some of the velocities w determine the
others.  How well those of the frame do is told by the metric

    g = d2L/dw2 + s A^T A

in which units and coordinates play no part: of the covectors dw, at unit length, by how far the
restrictions of the frame's to the admissible velocities are from being dependent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.graphs import bases
from voronec.algebra.terms import factors_of
from voronec.declaration.charts import Chart
from voronec.declaration.derivatives import derivative
from voronec.equations.definition import Definition
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.program import Program, compile_program
from voronec.equations.program.python import compiled_digits
from voronec.equations.voronec_equations import VoronecEquations
from voronec.motion.constant_rank import Row, with_implied_rows
from voronec.motion.initial_conditions import Relations
from voronec.motion.reactions import conditions_of
from voronec.motion.singular_denominators import (
    DIGITS,
    SingularDenominator,
    are_infinite,
    are_nearly_dependent,
    around,
    crossing_divisors,
    divisors,
    next_places,
    orthonormal_rows,
    without_factors,
)
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import Signals, constants_along

DEPENDENT = 1e-9
"""Constraints whose least singular value is below this part of the largest are dependent."""
CONTINUOUS = 1e-9
"""What conditions span on two sides of a place is one space where it is the same but for this."""
ON_RELATIONS, NEWTON = 1e-9, 12
"""Places are on the relations where these leave less; so many steps lead there, or none do."""


def _wide_form(d: Definition) -> FirstOrderForm:
    """The coordinates and all their velocities (of a group, those of its frame) as a state, without
    a word of how the velocities change."""
    n = len(d.dots)
    one, zero = se.Integer(1), se.Integer(0)
    return FirstOrderForm(
        coordinates=d.coordinates,
        velocities=tuple(d.dots),
        parameters=d.parameters,
        time=d.time,
        rates=tuple(d.dots if d.group is None else d.group.coordinate_rates(d.dots)),
        mass=tuple(tuple(one if i == j else zero for j in range(n)) for i in range(n)),
        force=(zero,) * n,
        velocity_symbols=() if d.group is None else d.coordinate_velocities,
    )


def _geometry_entries(d: Definition) -> dict[str, Any]:
    """Functions of the wide state by name: rows of the constraints and the relations, rows of the
    frame, each with its offset, and d2L/dw2; of a group also rows of the coordinates' rates."""
    forms = conditions_of(d)
    count = len(forms) - len(d.velocities)
    rates = [] if d.group is None else [(*row, 0) for row in d.group.fields]
    entries: dict[str, Any] = {}
    for kind, rows in (("condition", forms[:count]), ("frame", forms[count:]), ("rate", rates)):
        entries |= _entries_of(kind, rows)
    for a, w in enumerate(d.dots):
        slope = d.lagrangian.diff(w)
        entries |= {f"mass {a},{b}": slope.diff(u) for b, u in enumerate(d.dots[: a + 1])}
    return entries


def _entries_of(kind: str, rows: Sequence[Row]) -> dict[str, Any]:
    return {
        f"{kind} {i},{a}": se.sympify(e) for i, row in enumerate(rows) for a, e in enumerate(row)
    }


def implied_rows(d: Definition, among: Sequence[int] | None = None) -> tuple[list[Row], list[Row]]:
    """Rows of the constraints and the relations of a system, or of some of the constraints, with
    those that they imply, and sums of all these that vanish."""
    rows = conditions_of(d)
    chosen = rows[: -len(d.velocities)] if among is None else [rows[k] for k in among]
    return with_implied_rows(chosen, d.relations, d.coordinates)


def _frame_quality(metric: np.ndarray, conditions: np.ndarray, frame: np.ndarray) -> float:
    """How far the velocities v, of which ``frame`` (n, N) are the rows, are from being dependent
    where ``conditions`` hold: 1 at best, 0 where they are none."""
    root = np.linalg.cholesky(metric)
    inverse = np.linalg.inv(root).T  # columns are orthonormal in the metric
    left = conditions @ inverse
    left = left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)
    _, sizes, vt = np.linalg.svd(left)
    rank = int((sizes > DEPENDENT * sizes.max(initial=0.0)).sum())
    lengths = np.linalg.norm(np.linalg.solve(root, frame.T), axis=0)
    if not lengths.all():
        return 0.0
    directions = (frame @ inverse @ vt[rank:].T) / lengths[:, None]
    return float(np.linalg.svd(directions, compute_uv=False).min(initial=1.0))


def _metric_of(values: Mapping[str, Any], rows: np.ndarray) -> np.ndarray:
    """g = d2L/dw2 + s A^T A with s such that both parts are of one size, at one point, or at each
    of several, shape (..., velocities, velocities) [Theory, eq. (22c)]."""
    mass = _mass_of(values, rows.shape[-1])
    square = np.swapaxes(rows, -1, -2) @ rows
    inertia, size = (np.trace(x, axis1=-2, axis2=-1)[..., None, None] for x in (mass, square))
    scale = np.where(size == 0, 1.0, inertia / np.where(size == 0, 1.0, size))
    metric: np.ndarray = mass + np.where(scale == 0, 1.0, scale) * square
    return metric


def _mass_of(values: Mapping[str, Any], width: int) -> np.ndarray:
    table = [[values[f"mass {max(a, b)},{min(a, b)}"] for b in range(width)] for a in range(width)]
    return np.moveaxis(np.array(table, dtype=float), (0, 1), (-2, -1))


def numbers(program: Program, time: Any, state: Sequence[Any], values: Sequence[Any]) -> list[Any]:
    """The extra quantities of a program at a state of doubles, arrays or mpmath's numbers."""
    digits = any(isinstance(x, mpmath.mpf) for x in state)
    _, extras = (compiled_digits if digits else compile_program)(program)
    # a Python float that is divided by zero is an exception, one of NumPy's is infinite
    plain = list(state) if digits else [np.float64(x) if isinstance(x, float) else x for x in state]
    with np.errstate(all="ignore"):
        return list(extras(time, plain, list(values)))


@dataclass(frozen=True)
class ConstraintGeometry:
    """The constraints, the frame and the inertia of a system, with parameters by name, at a time.

    Constants that are ``changing`` are those of the start.
    """

    home: VoronecEquations
    constants: Mapping[str, float]
    time: float
    changing: Signals | None = None

    def values(
        self, program: Program, time: Any, constants: Mapping[str, Any] | None = None
    ) -> list[Any]:
        """The parameters of a program at a time, or at times (k,), those that have no value not a
        number."""
        given = self.at(time, constants)
        return [given.get(str(p), np.nan) for p in program.parameters]

    def at(self, time: Any, constants: Mapping[str, Any] | None = None) -> Mapping[str, Any]:
        """The parameters by name, those that change as they are at a time, or at times (k,)."""
        given = self.constants if constants is None else constants
        if self.changing is None:
            return given
        times = np.asarray(time)
        changed = constants_along(self.changing, {}, np.atleast_1d(times))
        return {**given, **(changed if times.ndim else {name: x[0] for name, x in changed.items()})}

    @cached_property
    def wide(self) -> FirstOrderForm:
        """The form of the wide state."""
        return _wide_form(self.home.definition)

    @property
    def _geometry(self) -> Program:
        def make() -> Program:
            return quantities(self.wide, _geometry_entries(self.home.definition))

        return self.home.memo.once("geometry", make)

    def _entries(self, time: Any, wide: Any, constants: Any = None) -> dict[str, Any]:
        """The entries of constraints, frame and mass at a wide state, by name."""
        return self._by_name(self._geometry, time, wide, constants)

    def _by_name(self, program: Program, time: Any, wide: Any, constants: Any) -> dict[str, Any]:
        flat = numbers(program, time, list(wide), self.values(program, time, constants))
        return dict(zip(program.names, flat, strict=True))

    def _limit_entries(self, time: Any, wide: np.ndarray, constants: Any = None) -> dict[str, Any]:
        """Entries by name; as they are by continuity where the constraints are infinite or
        nearly dependent."""
        entries = self._entries(time, wide.tolist(), constants)
        rows = self._rows_of(entries, wide.dtype)[0][:, :-1].astype(float)
        if not np.isfinite(rows).all() or are_infinite(rows):
            in_doubles = self.home.definition.group is None and wide.dtype != object
            return entries | (self._finite_rows(time, wide) if in_doubles else {})
        if are_nearly_dependent(rows) and (implied := self._implied_conditions) is not None:
            return entries | self._by_name(implied, time, wide, constants)
        return entries

    @property
    def _implied_conditions(self) -> Program | None:
        """The entries of constraints and what they imply where they are dependent, if anything."""
        d = self.home.definition

        def make() -> Program | None:
            rows, idle = implied_rows(d)
            return quantities(self.wide, _entries_of("condition", rows)) if idle else None

        return self.home.memo.once("implied constraints", make)

    def _finite_rows(self, time: float, wide: np.ndarray) -> dict[str, Any]:
        """Conditions with the limit of the space that infinite ones span; none where there is no
        limit."""
        count, spans = len(self.home.definition.coordinates), []
        with mpmath.workdps(DIGITS):
            constants = {name: mpmath.mpf(x) for name, x in self.at(time).items()}
            for q in next_places(wide[:count]):
                try:
                    entries = self._entries(
                        mpmath.mpf(time), [*q, *map(mpmath.mpf, wide[count:])], constants
                    )
                except ArithmeticError:
                    return {}
                spans.append(orthonormal_rows(self._rows_of(entries, object)[0]).astype(float))
        here, there = (rows.T @ rows for rows in spans)
        if not (np.abs(here - there) < CONTINUOUS).all():
            return {}
        return {
            f"condition {i},{a}": x for i, row in enumerate(spans[0]) for a, x in enumerate(row)
        }

    def _rows_of(self, entries: Mapping[str, Any], kind: Any) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the conditions and of the frame, with their offsets, as numbers of a kind, at one
        point, or at each of several (..., rows, velocities + 1)."""
        conditions = sum(name.startswith("condition") and name.endswith(",0") for name in entries)
        return (
            self._table(entries, "condition", conditions, kind),
            self._table(entries, "frame", len(self.home.definition.velocities), kind),
        )

    def _table(self, entries: Mapping[str, Any], name: str, count: int, kind: Any) -> np.ndarray:
        width = len(self.home.definition.dots) + 1
        flat = [entries[f"{name} {i},{a}"] for i in range(count) for a in range(width)]
        table = np.array(flat, dtype=kind)
        return np.moveaxis(table.reshape(count, width, *table.shape[1:]), (0, 1), (-2, -1))

    def coordinate_rows(self, time: Any, wide: np.ndarray, constants: Any = None) -> np.ndarray:
        """Rows of the coordinates' velocities on a group, with their offsets; none without one."""
        group = self.home.definition.group
        entries = self._entries(time, wide.tolist(), constants)
        return self._table(entries, "rate", len(group.fields) if group else 0, wide.dtype)

    def metric(self, time: float, wide: np.ndarray) -> np.ndarray:
        """The metric at a wide state, shape (velocities, velocities)."""
        entries = self._limit_entries(time, wide.astype(float))
        return _metric_of(entries, self._rows_of(entries, float)[0][:, :-1])

    def mass(self, time: float, wide: np.ndarray) -> np.ndarray:
        """d2L/dw2 at a wide state, shape (velocities, velocities)."""
        return _mass_of(
            self._entries(time, wide.astype(float).tolist()), len(self.home.definition.dots)
        )

    def frame_quality(self, time: float, wide: np.ndarray) -> float:
        """How far the velocities v are from being dependent at a wide state, 0 where they are no
        frame; ``LinAlgError`` where coordinates fail."""
        entries = self._limit_entries(time, wide.astype(float))
        conditions, frame = (rows[:, :-1] for rows in self._rows_of(entries, float))
        return _frame_quality(_metric_of(entries, conditions), conditions, frame)

    def rows(self, time: Any, wide: np.ndarray, constants: Any = None) -> tuple[np.ndarray, ...]:
        """Rows of the conditions and of the frame, with their offsets, as numbers of the kind that
        the wide state has."""
        return self._rows_of(self._limit_entries(time, wide, constants), wide.dtype)

    def soundness(self, places: np.ndarray) -> np.ndarray:
        """The determinant of the metric (k,) at states (n, k) of the coordinates, at rest, and what
        moves besides."""
        d, count = self.home.definition, places.shape[1]
        wide = np.vstack([places[: len(d.coordinates)], np.zeros((len(d.dots), count))])
        _, time, changed = self._apart(places)
        entries = replace(self, changing=None)._entries(time, wide, {**self.constants, **changed})
        table = np.array([np.broadcast_to(x, (count,)) for x in entries.values()], dtype=float)
        sound = np.isfinite(table).all(axis=0)
        at = dict(zip(entries, table[:, sound], strict=True))
        conditions = self._rows_of(at, float)[0][..., :-1]
        determinants = np.zeros(count)
        determinants[sound] = np.abs(np.linalg.det(_metric_of(at, conditions)))
        return determinants

    def watch_divisors(
        self, form: FirstOrderForm, below: Program, start: np.ndarray, rough: bool = False
    ) -> list[SingularDenominator]:
        """What a form divides by and what vanishes though the motion goes on.

        ``below`` gives the form's states, called ``start x``, and what it takes for constant,
        called ``frozen p``, on the coordinates and velocities ``start`` (n,).  Where the equations
        are ``rough`` only functions of the place are meant, and not the speeds by which friction
        divides.  What was found is kept with the system.
        """
        d = self.home.definition
        if not (d.constraints.matrix or d.frame or d.relations):
            return []
        key = (form.coordinates, tuple(sorted(self.constants.items())))
        kept: dict[Any, Any] = self.home.system.memo.once("divisors", dict)
        moving = tuple(map(se.Symbol, self._changing_names))
        every = (f for f in divisors(form, moving) if f not in self._others)
        left = (without_factors(f, pole_factors(self.home)) for f in every)
        candidates = [f for f in dict.fromkeys(left) if f not in self._others and not f.is_Number]
        if rough:
            candidates = [f for f in candidates if not f.free_symbols & {*form.velocities}]
        fresh = [f for f in candidates if (f, key) not in kept]
        risky = self._crossing_divisors(fresh, form, below, start) if fresh else []
        kept |= {(f, key): None for f in fresh} | {(d.function, key): d for d in risky}
        return [d for f in candidates if (d := kept[f, key]) is not None]

    @property
    def _others(self) -> set[Any]:
        """Divisors in any velocities: those of forces and of the slopes of the Lagrangian, and
        poles of charts."""
        d = self.home.definition
        slopes = (d.lagrangian.diff(x) for x in (*d.coordinates, *d.dots))
        return self.home.memo.once(
            "divisors in all velocities",
            lambda: {*pole_factors(self.home), *bases((d.lagrangian, *slopes, *d.forces))},
        )

    def _crossing_divisors(
        self, found: list[Any], form: FirstOrderForm, below: Program, start: np.ndarray
    ) -> list[SingularDenominator]:
        program = quantities(form, {str(i): f for i, f in enumerate(found)})
        still = replace(self, changing=None)

        def values(places: np.ndarray) -> np.ndarray:
            count = places.shape[1]
            states, time, changed = self._apart(places)
            given = {**self.constants, **changed}
            flat = numbers(below, time, list(states), still.values(below, time, given))
            known = dict(zip(below.names, flat, strict=True))
            state = [known[f"start {x}"] for x in program.state]
            given |= {n.removeprefix("frozen "): x for n, x in known.items()}
            flat = numbers(program, time, state, still.values(program, time, given))
            return np.array([np.broadcast_to(x, (count,)) for x in flat], dtype=float)

        besides = [self.time, *(self.constants[name] for name in self._changing_names)]
        places = around(np.append(start, besides))
        moved = self._on_relations(places)
        places = moved if moved.shape[1] else places
        return crossing_divisors(found, places, values, self.soundness, self._on_relations)

    @property
    def _changing_names(self) -> list[str]:
        return sorted(self.changing.names & self.constants.keys()) if self.changing else []

    def _apart(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
        """Places taken apart: states (n, k), times (k,), and what changes with the time by name."""
        names = self._changing_names
        states, (time, *changed) = np.split(places, [len(places) - 1 - len(names)])
        return states, time, dict(zip(names, changed, strict=True))

    def _on_relations(self, places: np.ndarray) -> np.ndarray:
        """States (n, k) moved onto the relations between redundant coordinates, those for which
        Newton's method gets there."""
        form = self.home.raw.form
        if not form.relations:
            return places
        n, moved = len(form.coordinates), places.copy()
        relations = Relations.of(form, self.at(self.time), self.time)
        for _ in range(NEWTON):
            off, slopes = relations.evaluate(moved[:n])
            good = np.isfinite(off).all(axis=0) & np.isfinite(slopes).all(axis=(0, 1))
            steep, left = (np.where(good, x, 0.0).T for x in (slopes, off))
            moved[:n] -= (np.linalg.pinv(steep.swapaxes(1, 2)) @ left[..., None])[..., 0].T
        return moved[:, good & (np.abs(off).max(axis=0) < ON_RELATIONS)]

    def is_near_zero(
        self, form: FirstOrderForm, watched: Sequence[SingularDenominator], state: Any,
        values: Sequence[Any],
    ) -> bool:  # fmt: skip
        """Whether one of some divisors of a form is near zero at a state."""
        program = quantities(form, {str(i): d.function for i, d in enumerate(watched)})
        levels = numbers(program, self.time, list(state), values)
        return any(d.is_near(float(x)) for d, x in zip(watched, levels, strict=True))


def pole_factors(equations: VoronecEquations) -> tuple[Any, ...]:
    """The factors of what vanishes where declared charts begin, each once."""

    def make() -> tuple[Any, ...]:
        charts = equations.system.charts.values()
        factors = (f for c in charts for f in factors_of(equations.bridge.inward(c.singular)))
        return tuple(dict.fromkeys(factors))

    return equations.memo.once("factors of poles", make)


def numbers_of_chart(
    ground: ConstraintGeometry, chart: Chart, time: float, wide: np.ndarray
) -> list[float] | None:
    """What vanishes where the own coordinates are singular, and where those of a chart are, and the
    slopes of the coordinates in the chart by the own ones, row by row; None where one of these has
    no value."""
    d, values = ground.home.definition, chart.values(ground.home.system)
    outside = ground.home.system.coordinates
    images = {q: d.bridge.inward(values[x]) for q, x in zip(d.coordinates, outside, strict=True)}
    wanted = [
        d.bridge.inward(chart.singular),
        d.bridge.inward(chart.singular_there).xreplace(images),
    ]
    # slopes as sympy has them: x/(x^2 + y^2) of an arctangent is defined where x or y is zero
    wanted += [d.bridge.inward(derivative(values[q], x)) for q in outside for x in outside]
    program = quantities(ground.wide, {str(i): se.sympify(e) for i, e in enumerate(wanted)})
    try:
        return [*map(float, numbers(program, time, wide.tolist(), ground.values(program, time)))]
    except ArithmeticError:
        return None
