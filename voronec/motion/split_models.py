"""The splits of a system in numbers: ready to be integrated in, and how good each is at a state.

All of them share the wide state: the coordinates and all their velocities.

At a point where the constraints A w + a = 0 are independent, some of the velocities w determine the
others.  Which do so best is told by the metric

    g = d2L/dw2 + s A^T A

in which units and coordinates play no part: of the covectors dw, at unit length, those whose
restrictions to the admissible velocities are farthest from being dependent.  For each choice the
equations are derived anew, exactly, with pivots that are well conditioned at that point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.graphs import bases
from voronec.algebra.normal import canonical
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.terms import factors_of
from voronec.algebra.text import as_expression
from voronec.declaration.charts import Chart
from voronec.declaration.derivatives import derivative
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.system import System, bare
from voronec.equations.definition import Definition, read
from voronec.equations.derivation import Derivation, FirstOrderForm
from voronec.equations.program import Program, compile_program
from voronec.equations.program.python import compiled_digits
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit, VoronecError
from voronec.motion.observables import ObservedQuantities, size_of_terms
from voronec.motion.reactions import Multipliers, conditions_of
from voronec.motion.singular_denominators import (
    CLEAR,
    DIGITS,
    FEW,
    GAIN,
    NEAR,
    SingularDenominator,
    are_dependent,
    are_infinite,
    around,
    crossing_divisors,
    divisors,
    has_limit,
    next_places,
    orthonormal_rows,
    places_beside,
    solution_rows,
    without_factors,
)
from voronec.motion.state_probe import quantities, usual_size
from voronec.motion.steppers import Signals, constants_along

SHARE = 0.1
"""A pivot is no smaller than this part of its row, at the point for which it is chosen."""
DEPENDENT = 1e-9
"""Constraints whose least singular value is below this part of the largest are dependent."""


def _wide_form(d: Definition) -> FirstOrderForm:
    """The coordinates and all their velocities (of a group, those of its frame) as a state: what
    the splits of a system share.  It says nothing of how the velocities change."""
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
    """What ``Geometry.of`` takes, by name, as functions of the wide state: rows of the constraints
    and the relations, rows of the frame, each with its offset, and d2L/dw2; of a group also rows of
    the coordinates' rates."""
    forms = conditions_of(d)
    count = len(forms) - len(d.velocities)
    rates = [] if d.group is None else [(*row, 0) for row in d.group.fields]
    entries: dict[str, Any] = {}
    for kind, rows in (("condition", forms[:count]), ("frame", forms[count:]), ("rate", rates)):
        for i, row in enumerate(rows):
            entries |= {f"{kind} {i},{a}": se.sympify(e) for a, e in enumerate(row)}
    for a, w in enumerate(d.dots):
        slope = d.lagrangian.diff(w)
        entries |= {f"mass {a},{b}": slope.diff(u) for b, u in enumerate(d.dots[: a + 1])}
    return entries


@dataclass(frozen=True)
class Geometry:
    """Frame and metric at one point.

    ``frame`` (n, N) are the rows of the velocities v; ``admissible`` (N, k) is a basis of the
    admissible velocities that is orthonormal in the metric, ``lengths`` are those of the covectors
    dw; k = n where the constraints are independent.
    """

    frame: np.ndarray
    metric: np.ndarray
    admissible: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of(cls, values: Mapping[str, Any], conditions: np.ndarray, frame: np.ndarray) -> Geometry:
        """The geometry from the values of ``_geometry_entries`` at one point, and their rows
        without offsets."""
        metric = _metric_of(values, conditions)
        root = np.linalg.cholesky(metric)
        inverse = np.linalg.inv(root).T  # columns are orthonormal in the metric
        left = conditions @ inverse
        left = left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-300)
        _, sizes, vt = np.linalg.svd(left)
        rank = int((sizes > DEPENDENT * sizes.max(initial=0.0)).sum())
        return cls(frame, metric, inverse @ vt[rank:].T, np.linalg.norm(inverse, axis=1))

    @property
    def quality(self) -> float:
        """How far the velocities v are from being dependent: 1 at best, 0 where they are none."""
        rows = self.frame
        lengths = np.linalg.norm(np.linalg.solve(np.linalg.cholesky(self.metric), rows.T), axis=0)
        if not lengths.all():
            return 0.0
        sizes = np.linalg.svd((rows @ self.admissible) / lengths[:, None], compute_uv=False)
        return float(sizes.min(initial=1.0))

    @property
    def best(self) -> tuple[int, ...]:
        """Positions of the velocities w that are the best frame."""
        import scipy.linalg

        rows = self.admissible / self.lengths[:, None]
        _, _, order = scipy.linalg.qr(rows.T, mode="economic", pivoting=True)
        return tuple(sorted(map(int, order[: len(self.frame)])))


def _metric_of(values: Mapping[str, Any], rows: np.ndarray) -> np.ndarray:
    """g = d2L/dw2 + s A^T A with s such that both parts are of one size, at one point, or at each
    of several, shape (..., velocities, velocities) [Theory, eq. (22b)]."""
    mass = _mass_of(values, rows.shape[-1])
    square = np.swapaxes(rows, -1, -2) @ rows
    inertia, size = (np.trace(x, axis1=-2, axis2=-1)[..., None, None] for x in (mass, square))
    scale = np.where(size == 0, 1.0, inertia / np.where(size == 0, 1.0, size))
    found: np.ndarray = mass + np.where(scale == 0, 1.0, scale) * square
    return found


def _mass_of(values: Mapping[str, Any], width: int) -> np.ndarray:
    table = [[values[f"mass {max(a, b)},{min(a, b)}"] for b in range(width)] for a in range(width)]
    return np.moveaxis(np.array(table, dtype=float), (0, 1), (-2, -1))


# -- other systems for the same motion ------------------------------------------------------


def _split_system(system: System, chosen: Sequence[int]) -> System:
    """The system with those velocities as its independent ones: positions among the velocities of
    the coordinates, or of a group's frame.  Claims and scenes are left out."""
    frame = system.frame
    own = [system.directions[a] for a in chosen]
    rest = tuple(x for x in system.directions if x not in own)
    title = f"{system.name}, {', '.join(map(plain_name, own))}"
    if frame is not None and frame.is_group:
        group = Frame.group(own, frame.brackets or {}, frame.rates, rest)
        return bare(system, title, frame=group)
    if system.fibration.relations:
        taken = {plain_name(s) for s in system.known_symbols()}
        dots = {fresh_symbol(f"d{plain_name(q)}", taken): velocity(q) for q in own}
        return bare(system, title, **spell_out(system, frame), frame=Frame.quasi(dots))
    return bare(
        system,
        title,
        **spell_out(system, frame),
        frame=None,
        fibration=Fibration(tuple(own), rest),
        charts=split_charts(system),
    )


def fresh_symbol(name: str, taken: set[str]) -> sp.Symbol:
    """A symbol with a name, or one like it, that is not taken."""
    while name in taken:
        name += "_"
    return sp.Symbol(name)


def spell_out(
    system: System, frame: Frame | None, changes: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Lagrangian, constraints and forces, with changes, without the quasi-velocities of a frame."""
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    names = ("lagrangian", "constraints", "forces")
    own = {name: getattr(system, name) for name in names} | dict(changes or {})

    def on(expr: Any) -> Any:
        return as_expression(expr).xreplace(meaning)

    return {
        "lagrangian": on(own["lagrangian"]),
        "constraints": tuple(map(on, own["constraints"])),
        "forces": {q: on(e) for q, e in own["forces"].items()},
    }


def split_charts(system: System) -> dict[str, Chart]:
    """The charts of a system as those of its split: the velocities follow the coordinates."""
    return {name: _split_chart(system, chart) for name, chart in system.charts.items()}


def _split_chart(system: System, chart: Chart) -> Chart:
    """A chart of the system as one of its split: the velocities follow the coordinates."""
    frame = chart.changes.get("frame", system.frame)
    quasi = set() if frame is None else {plain_name(v) for v in frame.velocities}
    changes = {name: e for name, e in chart.changes.items() if name != "frame"}

    def own(values: Mapping[str, Any]) -> dict[str, Any]:
        return {name: e for name, e in values.items() if name not in quasi}

    return replace(
        chart,
        state=own(chart.state),
        back=own(chart.back),
        double_cover=tuple(map(own, chart.double_cover)),
        changes=spell_out(system, frame, changes),
    )


def _equations_near(
    home: VoronecEquations, system: System, near: Mapping[str, Any]
) -> VoronecEquations:
    """The equations of a split of ``home`` with pivots that are well conditioned at a point,
    numbers by name; every run of ``home`` has the same."""
    definition = read(system, near, SHARE)
    what = system.name, definition.fibre
    if what == (home.system.name, home.definition.fibre):
        return home
    return home.memo.once(
        ("split", what),
        lambda: VoronecEquations(
            system, definition, Derivation(definition, False), Derivation(definition, True)
        ),
    )


AT_POLE = 1e-6
"""Coordinates are singular where a chart's ``singular`` is below it, as in ``blind``."""
CONTINUOUS = 1e-9
"""What conditions span on two sides of a place is one space where it is the same but for this."""
ON_RELATIONS, NEWTON = 1e-9, 12
"""Places are on the relations where these leave less; so many steps lead there, or none do."""


def numbers(program: Program, time: Any, state: Sequence[Any], values: Sequence[Any]) -> list[Any]:
    """The extra quantities of a program at a state of doubles, arrays or mpmath's numbers."""
    digits = any(isinstance(x, mpmath.mpf) for x in state)
    _, extras = (compiled_digits if digits else compile_program)(program)
    # a Python float that is divided by zero is an exception, one of NumPy's is infinite
    plain = list(state) if digits else [np.float64(x) if isinstance(x, float) else x for x in state]
    with np.errstate(all="ignore"):
        return list(extras(time, plain, list(values)))


@dataclass(frozen=True)
class SplitContext:
    """What the splits of one motion share: the system, its parameters by name, and the time.

    ``home`` are the equations as they are declared, ``framed`` (n,) is the start on their
    coordinates and velocities where no velocities of the coordinates belong to it: those of its
    wide state are not numbers.  Constants that are ``changing`` are those of the start.
    """

    home: VoronecEquations
    constants: Mapping[str, float]
    time: float
    framed: np.ndarray | None = None
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
        found = constants_along(self.changing, {}, np.atleast_1d(times))
        return {**given, **(found if times.ndim else {name: x[0] for name, x in found.items()})}

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
        """Entries by name; as they are by continuity where the constraints are infinite, or those
        of a group dependent."""
        entries = self._entries(time, wide.tolist(), constants)
        rows = self._rows_of(entries, wide.dtype)[0][:, :-1].astype(float)
        if self.home.definition.group is None:
            infinite = wide.dtype != object and are_infinite(rows)
            return entries | (self._finite_rows(time, wide) if infinite else {})
        if not np.isfinite(rows).all():
            return entries
        if are_dependent(rows):
            with suppress(VoronecError, np.linalg.LinAlgError):
                solution = self._limit(float(time), wide.astype(float))
                if solution is not None:
                    return entries | self._by_name(solution, time, wide, constants)
        return entries

    def _finite_rows(self, time: float, wide: np.ndarray) -> dict[str, Any]:
        """Conditions with the limit of the space that infinite ones span; none where there is no
        limit."""
        count, found = len(self.home.definition.coordinates), []
        with mpmath.workdps(DIGITS):
            constants = {name: mpmath.mpf(x) for name, x in self.at(time).items()}
            for q in next_places(wide[:count]):
                try:
                    entries = self._entries(
                        mpmath.mpf(time), [*q, *map(mpmath.mpf, wide[count:])], constants
                    )
                except ArithmeticError:
                    return {}
                found.append(orthonormal_rows(self._rows_of(entries, object)[0]).astype(float))
        here, there = (rows.T @ rows for rows in found)
        if not (np.abs(here - there) < CONTINUOUS).all():
            return {}
        return {
            f"condition {i},{a}": x for i, row in enumerate(found[0]) for a, x in enumerate(row)
        }

    def _limit(self, time: float, wide: np.ndarray) -> Program | None:
        """The entries of the constraints, solved for velocities that depend on the others beside a
        wide state; None where they have no limit there."""
        count = len(self.home.definition.coordinates)
        places = self._on_relations(places_beside(wide[:count]))
        beside = []
        for q in places.T:
            entries = self._entries(time, [*q, *wide[count:]])
            conditions, frame = self._rows_of(entries, float)
            beside.append(Geometry.of(entries, conditions[:, :-1], frame[:, :-1]))
        if not beside:
            return None
        solution = self._solution(beside[0].best)
        there = self._by_name(solution, time, wide, None)
        rows = self._table(there, "condition", len(self.home.definition.constraints.matrix), float)[
            :, :-1
        ]
        return solution if has_limit(rows, [g.admissible for g in beside]) else None

    def _solution(self, chosen: tuple[int, ...]) -> Program:
        """The entries of the constraints of a group, solved for all velocities but some."""

        def make() -> Program:
            system = self.home.system
            rows = solution_rows(_split_system(system, chosen), system.directions)
            entries = {f"condition {i},{a}": e for i, r in enumerate(rows) for a, e in enumerate(r)}
            return quantities(self.wide, entries)

        return self.home.memo.once(("constraints solved beside", chosen), make)

    def _rows_of(self, entries: Mapping[str, Any], kind: Any) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the conditions and of the frame, with their offsets, as numbers of a kind, at one
        point, or at each of several (..., rows, velocities + 1)."""
        d = self.home.definition
        conditions = len(d.constraints.matrix) + len(d.differentiated.matrix)
        return (
            self._table(entries, "condition", conditions, kind),
            self._table(entries, "frame", len(d.velocities), kind),
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

    def geometry(self, time: float, wide: np.ndarray) -> Geometry:
        """Frame and metric at a wide state; ``LinAlgError`` where coordinates fail."""
        entries = self._limit_entries(time, wide.astype(float))
        conditions, frame = self._rows_of(entries, float)
        return Geometry.of(entries, conditions[:, :-1], frame[:, :-1])

    def strength(self, time: float, wide: np.ndarray) -> float:
        """How independent the constraints are at a wide state: the volume of their rows, in units
        of the usual one around it."""

        def volume(state: np.ndarray) -> float:
            rows = self.rows(time, state)[0][:, :-1]
            return float(np.sqrt(np.abs(np.linalg.det(rows @ rows.T)))) if len(rows) else 1.0

        count = len(self.home.definition.coordinates)
        places = self._on_relations(around(wide[:count])[:, :FEW])
        rest = np.zeros(len(wide) - count)
        usual = np.array([volume(np.concatenate([q, rest])) for q in places.T])
        return volume(wide) / usual_size(usual, volume(wide))

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
        found = np.zeros(count)
        found[sound] = np.abs(np.linalg.det(_metric_of(at, conditions)))
        return found

    def watch_divisors(
        self, form: FirstOrderForm, below: Program, start: np.ndarray, rough: bool = False
    ) -> list[SingularDenominator]:
        """What a form divides by and what vanishes though the motion goes on.

        ``below`` gives the form's states, called ``start x``, and what it takes for constant,
        called ``frozen p``, on the coordinates and velocities ``start`` (n,).  Where the equations
        are ``rough`` only those are meant that another split may not have: functions of the place,
        and not the speeds by which friction divides.  What was found is kept with the system.
        """
        d = self.home.definition
        if rough and not (d.constraints.matrix or d.frame or d.relations):
            return []
        key = (form.coordinates, tuple(sorted(self.constants.items())))
        kept: dict[Any, Any] = self.home.system.memo.once("divisors", dict)
        moving = tuple(map(se.Symbol, self._changing_names))
        every = (f for f in divisors(form, moving) if f not in self._others)
        left = (without_factors(f, self._poles) for f in every)
        found = [f for f in dict.fromkeys(left) if f not in self._others and not f.is_Number]
        if rough:
            found = [f for f in found if not f.free_symbols & {*form.velocities}]
        fresh = [f for f in found if (f, key) not in kept]
        risky = self._crossing_divisors(fresh, form, below, start) if fresh else []
        kept |= {(f, key): None for f in fresh} | {(d.function, key): d for d in risky}
        return [d for f in found if (d := kept[f, key]) is not None]

    @property
    def _others(self) -> set[Any]:
        """Divisors that are none of a split: those of forces and of the slopes of the Lagrangian,
        and poles of charts."""
        d = self.home.definition
        slopes = (d.lagrangian.diff(x) for x in (*d.coordinates, *d.dots))
        return self.home.memo.once(
            "divisors of no split",
            lambda: {*self._poles, *bases((d.lagrangian, *slopes, *d.forces))},
        )

    @cached_property
    def _poles(self) -> tuple[Any, ...]:
        """The factors of what vanishes where declared charts begin, each once."""
        found: dict[Any, None] = {}
        for chart in self.home.system.charts.values():
            inside = self.home.definition.bridge.inward(chart.singular)
            found |= dict.fromkeys(factors_of(inside))
        return tuple(found)

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
        m, n, count = len(form.relations), len(form.coordinates), places.shape[1]
        slopes = [r.diff(q) for r in form.relations for q in form.coordinates]
        program = quantities(form, {str(i): e for i, e in enumerate((*form.relations, *slopes))})
        moved, values = places.copy(), self.values(program, self.time)
        still = [0.0] * len(form.velocities)
        for _ in range(NEWTON):
            flat = numbers(program, self.time, [*moved[:n], *still], values)
            rows = np.array([np.broadcast_to(x, (count,)) for x in flat], dtype=float).T
            off, steep = rows[:, :m, None], rows[:, m:].reshape(count, m, n)
            good = np.isfinite(rows).all(axis=1)
            steep = np.where(good[:, None, None], steep, 0.0)
            moved[:n] -= (np.linalg.pinv(steep) @ np.where(good[:, None, None], off, 0.0))[..., 0].T
        there = good & (np.abs(rows[:, :m]).max(axis=1) < ON_RELATIONS)
        return moved[:, there]

    def sizes(
        self,
        program: Program,
        guards: Sequence[SingularDenominator],
        state: Any,
        values: Sequence[Any],
    ) -> list[float]:
        """Divisors at a state in units of their usual sizes, from their ``divisor_program``."""
        sizes = numbers(program, self.time, list(state), values)
        parts = [abs(float(x)) / g.scale for x, g in zip(sizes, guards, strict=True)]
        return [x if np.isfinite(x) else 0.0 for x in parts]


def divisor_program(form: FirstOrderForm, guards: Sequence[SingularDenominator]) -> Program:
    """A program for some divisors of a form."""
    return quantities(form, {str(i): g.function for i, g in enumerate(guards)})


@dataclass(frozen=True, eq=False)
class SplitModel:
    """One split, ready to be integrated in; ``guards`` are the divisors that it watches, and
    ``unbounded`` its program but for their bounds, which are parameters that nothing else holds."""

    ground: SplitContext
    equations: VoronecEquations
    form: FirstOrderForm
    watch: ObservedQuantities
    functions: Mapping[str, Any]
    unbounded: Program
    guards: tuple[SingularDenominator, ...] = field(default=())

    @classmethod
    def of(
        cls,
        ground: SplitContext,
        equations: VoronecEquations,
        form: FirstOrderForm,
        watch: ObservedQuantities,
        functions: Mapping[str, Any],
        wide: np.ndarray,
    ) -> SplitModel:
        """A split with what is watched and the functions of events, given for the home split."""
        home = ground.home
        # those of a group's fibre follow in other ways in other splits
        momenta = {x: e for x, e in home.raw.form.dependent if x not in home.definition.dots}
        own = tuple(home.definition.velocities)
        quasi = dict(zip(own, home.raw.form.definitions, strict=True))
        if tuple(form.velocities) == own:  # those of coordinates need not exist, at poles
            quasi = {}

        def substitute(expr: Any) -> Any:
            return se.sympify(expr).xreplace(momenta).xreplace(quasi)

        expressions = {name: substitute(e) for name, e in watch.expressions.items()}
        if quasi and momenta:
            expressions |= _without_momenta(watch, momenta, form, home.definition.relations)
        multipliers = watch.multipliers
        if multipliers is not None:
            expressions = {n: e for n, e in expressions.items() if n not in multipliers.entries}
            multipliers = Multipliers.of(equations.definition)
            expressions |= multipliers.entries
        inside = (*home.definition.coordinates, *home.definition.velocities)
        names = (*home.system.coordinates, *home.system.velocities)
        for x, symbol in zip(names, inside, strict=True):
            expressions[f"home {plain_name(x)}"] = substitute(symbol)
        model = cls(
            ground,
            equations,
            form,
            replace(watch, expressions=expressions, multipliers=multipliers),
            {name: substitute(e) for name, e in functions.items()},
            Program.of(form, expressions),
        )
        state = model.narrow(ground.time, wide)
        there, rough = replace(ground, home=equations), model.unbounded.is_rough
        found = there.watch_divisors(form, model._own, state, rough)
        return replace(model, guards=tuple(found))

    @cached_property
    def bounds(self) -> tuple[Any, ...]:
        """The symbols of the values at which its divisors are watched."""
        return tuple(se.Symbol(f"bound of divisor {i}") for i in range(len(self.guards)))

    @cached_property
    def bounded_form(self) -> FirstOrderForm:
        """The form, with its bounds among the parameters."""
        return replace(self.form, parameters=(*self.form.parameters, *self.bounds))

    @cached_property
    def program(self) -> Program:
        """The right-hand side, with everything watched."""
        plain = self.unbounded
        return replace(plain, parameters=(*plain.parameters, *self.bounds))

    @cached_property
    def _own(self) -> Program:
        return quantities(self.form, {f"start {x}": x for x in self._states})

    @property
    def _states(self) -> tuple[Any, ...]:
        return (*self.form.coordinates, *self.form.velocities)

    @cached_property
    def _wide_program(self) -> Program:
        d = self.ground.home.definition
        return quantities(self.form, {str(x): x for x in (*d.coordinates, *d.dots)})

    @cached_property
    def _narrow_program(self) -> Program:
        form = self.form
        velocities = dict(zip(form.velocities, self.equations.raw.form.definitions, strict=True))
        entries = {str(q): q for q in form.coordinates} | {str(v): e for v, e in velocities.items()}
        return quantities(self.ground.wide, entries)

    def widen(self, time: Any, state: Any, constants: Any = None) -> np.ndarray:
        """The wide state of a state of the split, of numbers of the same kind."""
        return self._map(self._wide_program, time, state, constants)

    def narrow(self, time: Any, wide: Any, constants: Any = None) -> np.ndarray:
        """The state of the split at a wide state."""
        framed = self.ground.framed
        if framed is not None and self.equations is self.ground.home and np.isnan(wide[-1]):
            return framed
        return self._map(self._narrow_program, time, wide, constants)

    def _map(self, program: Program, time: Any, state: Any, constants: Any) -> np.ndarray:
        digits = np.asarray(state).dtype == object
        found = numbers(program, time, list(state), self.ground.values(program, time, constants))
        if digits:
            return np.array([mpmath.mpf(x) for x in found], dtype=object)
        return np.array(found, dtype=float)

    def bounds_from(self, time: float, wide: np.ndarray) -> dict[str, float]:
        """The values at which divisors are watched in a stretch that begins at a wide state, by the
        names of their symbols: those that are small there are watched for being so many times
        smaller."""
        sizes = self._sizes(time, self.narrow(time, wide.astype(float)))
        exponents = [
            g.exponent(NEAR if size > CLEAR else size / GAIN)
            for g, size in zip(self.guards, sizes, strict=True)
        ]
        return {str(b): 2.0**k for b, k in zip(self.bounds, exponents, strict=True)}

    def _sizes(self, time: float, state: np.ndarray) -> list[float]:
        there, values = replace(self.ground, time=time), self.ground.values(self._divisors, time)
        return there.sizes(self._divisors, self.guards, state, values)

    @cached_property
    def _divisors(self) -> Program:
        return divisor_program(self.form, self.guards)

    def quality(self, time: Any, wide: np.ndarray) -> float:
        """How far the divisors are from zero at a wide state, in units of their usual sizes; 0
        where the equations have no value there, and no chart leads on."""
        time, wide = float(time), wide.astype(float)
        state, program = self.narrow(time, wide), self.program
        values = self.ground.values(program, time)
        with np.errstate(all="ignore"):
            rates = compile_program(program)[0](
                np.float64(time), [np.float64(x) for x in state], values
            )
        defined = np.isfinite(np.array(rates, dtype=float)).all()
        if not (defined or (np.isfinite(state).all() and self._at_pole(time, state))):
            return 0.0
        return min(self._sizes(time, state), default=np.inf)

    def _at_pole(self, time: float, state: np.ndarray) -> bool:
        """Whether a state is where the coordinates are singular and charts of the split begin."""
        d = self.equations.definition
        charts = self.equations.system.charts.values()
        singular = [d.bridge.inward(chart.singular) for chart in charts]
        program = quantities(self.form, {str(i): e for i, e in enumerate(singular)})
        there = numbers(program, time, state.tolist(), self.ground.values(program, time))
        return any(abs(x) < AT_POLE for x in there)


def _without_momenta(
    watch: ObservedQuantities,
    momenta: Mapping[Any, Any],
    form: FirstOrderForm,
    relations: Sequence[Any],
) -> dict[str, Any]:
    """What is watched and holds momenta of the home split, in the velocities of another: in normal
    form, since momenta divide by what may vanish in this one, and the whole need not."""
    sizes = {watch.sizes[name]: key for name, key in watch.integrals.items()}
    dependent, found = dict(form.dependent), dict[str, Any]()
    for name, expr in watch.expressions.items():
        if name not in sizes and se.sympify(expr).free_symbols & momenta.keys():
            written = se.sympify(expr).xreplace(momenta).xreplace(dependent)
            with suppress(EngineLimit):
                written = canonical([written], relations)[0]
            found[name] = written
    return found | {size: size_of_terms(found[key]) for size, key in sizes.items() if key in found}


def candidates(ground: SplitContext, time: float, wide: np.ndarray) -> Any:
    """Equations to try at a wide state, with their forms, one after the other."""
    home, point = ground.home, _point(ground, time, wide)
    yield home, home.form
    try:
        geometry = ground.geometry(time, wide)
        systems = [home.system] if geometry.quality > CLEAR else []
        systems.append(_split_system(home.system, geometry.best))
    except np.linalg.LinAlgError:  # at a pole the own velocities may need other pivots alone
        systems = [home.system]
    for system in systems:
        try:
            equations = _equations_near(home, system, point)
            yield equations, equations.form
            yield equations, equations.raw.form
        except VoronecError:
            continue


def numbers_of_chart(
    ground: SplitContext, chart: Chart, time: float, wide: np.ndarray
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


def _point(ground: SplitContext, time: float, wide: np.ndarray) -> dict[str, Any]:
    """Numbers of coordinates, parameters and the time by name, exact as doubles."""
    d = ground.home.definition
    named = dict(zip(map(str, d.coordinates), wide.tolist(), strict=False))
    return {**ground.at(time), **named, str(d.time): time}
