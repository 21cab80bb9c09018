"""The splits of a system in numbers: ready to be integrated in, and how good each is at a state.

All of them share the wide state: the coordinates and all their velocities.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.symbols import plain_name
from voronec.derivation import FirstOrderForm
from voronec.equations import VoronecEquations
from voronec.errors import VoronecError
from voronec.flow.divisors import Divisor, around, bases, crossed, divisors, without_factors
from voronec.flow.observing import Watch
from voronec.flow.probe import quantities
from voronec.flow.reactions import Multipliers
from voronec.flow.splits import (
    Geometry,
    equations_near,
    geometry_entries,
    metric_of,
    split_system,
    wide_form,
)
from voronec.program import Program, compiled
from voronec.program.digits import compiled_digits

__all__ = ["CLEAR", "NEAR", "SplitGround", "SplitModel", "candidates"]

NEAR, CLEAR = 0.05, 0.15
"""Below the one, in units of its usual size, a divisor makes its split be left; above the other a
split is good enough.  What is lost in digits is the square of such a number at most."""
AT_POLE = 1e-6
"""Coordinates are singular where a chart's ``singular`` is below it, as in ``blind``."""
ON_RELATIONS, NEWTON = 1e-9, 12
"""Places are on the relations where these leave less; so many steps lead there, or none do."""
_KEPT = "_divisors"


def numbers(program: Program, time: Any, state: Sequence[Any], values: Sequence[Any]) -> list[Any]:
    """The extra quantities of a program at a state of doubles, arrays or mpmath's numbers."""
    digits = any(isinstance(x, mpmath.mpf) for x in state)
    _, extras = (compiled_digits if digits else compiled)(program)
    with np.errstate(all="ignore"):
        return list(extras(time, list(state), list(values)))


@dataclass(frozen=True)
class SplitGround:
    """What the splits of one motion share: the system, its parameters by name, and the time.

    ``home`` are the equations as they are declared.
    """

    home: VoronecEquations
    constants: Mapping[str, float]
    time: float

    def values(self, program: Program, constants: Mapping[str, Any] | None = None) -> list[Any]:
        """The parameters of a program, those that have no value not a number."""
        given = self.constants if constants is None else constants
        return [given.get(str(p), np.nan) for p in program.parameters]

    @cached_property
    def wide(self) -> FirstOrderForm:
        """The form of the wide state."""
        return wide_form(self.home.definition)

    @cached_property
    def _geometry(self) -> Program:
        return quantities(self.wide, geometry_entries(self.home.definition))

    def _entries(self, time: Any, wide: Any, constants: Any = None) -> dict[str, Any]:
        """The entries of constraints, frame and mass at a wide state, by name."""
        program = self._geometry
        flat = numbers(program, time, list(wide), self.values(program, constants))
        return dict(zip(program.names, flat, strict=True))

    def _rows_of(self, entries: Mapping[str, Any], kind: Any) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the conditions and of the frame, with their offsets, as numbers of a kind."""
        d = self.home.definition
        width = len(d.dots) + 1

        def rows(name: str, count: int) -> np.ndarray:
            flat = [entries[f"{name} {i},{a}"] for i in range(count) for a in range(width)]
            return np.array(flat, dtype=kind).reshape(count, width)

        conditions = len(d.constraints.matrix) + len(d.differentiated.matrix)
        return rows("condition", conditions), rows("frame", len(d.velocities))

    def geometry(self, time: float, wide: np.ndarray) -> Geometry:
        """Frame and metric at a wide state; ``LinAlgError`` where coordinates fail."""
        entries = self._entries(time, wide.astype(float).tolist())
        conditions, frame = self._rows_of(entries, float)
        return Geometry.of(entries, conditions[:, :-1], frame[:, :-1])

    def strength(self, time: float, wide: np.ndarray) -> float:
        """How independent the constraints are at a wide state: the volume of their rows, in units
        of the usual one around it."""

        def volume(state: np.ndarray) -> float:
            rows = self.rows(time, state)[0][:, :-1]
            return float(np.sqrt(np.abs(np.linalg.det(rows @ rows.T)))) if len(rows) else 1.0

        count = len(self.home.definition.coordinates)
        places = self._on_relations(around(wide[:count]))
        rest = np.zeros(len(wide) - count)
        usual = np.array([volume(np.concatenate([q, rest])) for q in places.T])
        finite = usual[np.isfinite(usual)]
        return volume(wide) / float(np.median(finite)) if len(finite) else 1.0

    def rows(self, time: Any, wide: np.ndarray, constants: Any = None) -> tuple[np.ndarray, ...]:
        """Rows of the conditions and of the frame, with their offsets, as numbers of the kind that
        the wide state has."""
        return self._rows_of(self._entries(time, wide.tolist(), constants), wide.dtype)

    def soundness(self, places: np.ndarray) -> np.ndarray:
        """The determinant of the metric (k,) at states (n, k) of the coordinates, at rest."""
        d, count = self.home.definition, places.shape[1]
        wide = np.vstack([places[: len(d.coordinates)], np.zeros((len(d.dots), count))])
        entries = self._entries(self.time, wide)
        rows = {name: np.broadcast_to(x, (count,)) for name, x in entries.items()}
        found = np.zeros(count)
        for k in range(count):
            at = {name: row[k] for name, row in rows.items()}
            if np.isfinite([*at.values()]).all():
                conditions = self._rows_of(at, float)[0][:, :-1]
                found[k] = np.abs(np.linalg.det(metric_of(at, conditions)))
        return found

    def watched(self, form: FirstOrderForm, below: Program, start: np.ndarray) -> list[Divisor]:
        """What a form divides by and what vanishes though the motion goes on.

        ``below`` gives the form's states, called ``start x``, and what it takes for constant,
        called ``frozen p``, on the coordinates and velocities ``start`` (n,).  What was found is
        kept with the system.
        """
        key = (form.coordinates, tuple(sorted(self.constants.items())))
        kept = self.home.system.__dict__.setdefault(_KEPT, {})
        left = (without_factors(f, self._poles) for f in divisors(form) if f not in self._others)
        found = [f for f in dict.fromkeys(left) if f not in self._others and not f.is_Number]
        fresh = [f for f in found if (f, key) not in kept]
        risky = self._crossed(fresh, form, below, start) if fresh else []
        kept |= {(f, key): None for f in fresh} | {(d.function, key): d for d in risky}
        return [d for f in found if (d := kept[f, key]) is not None]

    @cached_property
    def _others(self) -> set[Any]:
        """Divisors that are none of a split: those of forces, and poles of charts."""
        d = self.home.definition
        return {*self._poles, *bases((d.lagrangian, *d.forces))}

    @cached_property
    def _poles(self) -> tuple[Any, ...]:
        """The factors of what vanishes where declared charts begin, each once."""
        found: dict[Any, None] = {}
        for chart in self.home.system.charts.values():
            inside = self.home.definition.door.inward(chart.singular)
            found |= dict.fromkeys(inside.args if isinstance(inside, se.Mul) else (inside,))
        return tuple(found)

    def _crossed(
        self, found: list[Any], form: FirstOrderForm, below: Program, start: np.ndarray
    ) -> list[Divisor]:
        program = quantities(form, {str(i): f for i, f in enumerate(found)})
        names, own = below.names, self.values(below)

        def values(places: np.ndarray) -> np.ndarray:
            count = places.shape[1]
            known = dict(zip(names, numbers(below, self.time, list(places), own), strict=True))
            state = [known[f"start {x}"] for x in program.state]
            given = {**self.constants} | {n.removeprefix("frozen "): x for n, x in known.items()}
            flat = numbers(program, self.time, state, self.values(program, given))
            return np.array([np.broadcast_to(x, (count,)) for x in flat], dtype=float)

        places = around(start)
        moved = self._on_relations(places)
        places = moved if moved.shape[1] else places
        return crossed(found, places, values, self.soundness, self._on_relations)

    def _on_relations(self, places: np.ndarray) -> np.ndarray:
        """States (n, k) moved onto the relations between redundant coordinates, those for which
        Newton's method gets there."""
        form = self.home.raw.form
        if not form.relations:
            return places
        m, n, count = len(form.relations), len(form.coordinates), places.shape[1]
        slopes = [r.diff(q) for r in form.relations for q in form.coordinates]
        program = quantities(form, {str(i): e for i, e in enumerate((*form.relations, *slopes))})
        moved, values = places.copy(), self.values(program)
        for _ in range(NEWTON):
            flat = numbers(program, self.time, list(moved), values)
            rows = np.array([np.broadcast_to(x, (count,)) for x in flat], dtype=float).T
            off, steep = rows[:, :m, None], rows[:, m:].reshape(count, m, n)
            good = np.isfinite(rows).all(axis=1)
            steep = np.where(good[:, None, None], steep, 0.0)
            moved[:n] -= (np.linalg.pinv(steep) @ np.where(good[:, None, None], off, 0.0))[..., 0].T
        there = good & (np.abs(rows[:, :m]).max(axis=1) < ON_RELATIONS)
        return moved[:, there]

    def smallest(
        self, form: FirstOrderForm, guards: Sequence[Divisor], state: Any, values: Sequence[Any]
    ) -> float:
        """The least of some divisors at a state of a form, in units of their usual sizes."""
        if not guards:
            return np.inf
        program = quantities(form, {str(i): g.function for i, g in enumerate(guards)})
        sizes = numbers(program, self.time, list(state), values)
        parts = [abs(x) / g.scale for x, g in zip(sizes, guards, strict=True)]
        return float(min(x if np.isfinite(x) else 0.0 for x in parts))


@dataclass(frozen=True, eq=False)
class SplitModel:
    """One split, ready to be integrated in; ``guards`` are the divisors that it watches."""

    ground: SplitGround
    equations: VoronecEquations
    form: FirstOrderForm
    watch: Watch
    functions: Mapping[str, Any]
    guards: tuple[Divisor, ...] = field(default=())

    @classmethod
    def of(
        cls,
        ground: SplitGround,
        equations: VoronecEquations,
        form: FirstOrderForm,
        watch: Watch,
        functions: Mapping[str, Any],
        wide: np.ndarray,
    ) -> SplitModel:
        """A split with what is watched and the functions of events, given for the home split."""
        home = ground.home
        meaning = dict(home.raw.form.dependent)
        own = tuple(home.definition.velocities)
        quasi = dict(zip(own, home.raw.form.definitions, strict=True))
        if tuple(form.velocities) == own:  # those of coordinates need not exist, at poles
            quasi = {}

        def moved(expr: Any) -> Any:
            return se.sympify(expr).xreplace(meaning).xreplace(quasi)

        expressions = {name: moved(e) for name, e in watch.expressions.items()}
        multipliers = watch.multipliers
        if multipliers is not None:
            expressions = {n: e for n, e in expressions.items() if n not in multipliers.entries}
            multipliers = Multipliers.of(equations.definition)
            expressions |= multipliers.entries
        inside = (*home.definition.coordinates, *home.definition.velocities)
        names = (*home.system.coordinates, *home.system.velocities)
        for x, symbol in zip(names, inside, strict=True):
            expressions[f"home {plain_name(x)}"] = moved(symbol)
        model = cls(
            ground,
            equations,
            form,
            replace(watch, expressions=expressions, multipliers=multipliers),
            {name: moved(e) for name, e in functions.items()},
        )
        state = model.narrow(ground.time, wide)
        found = replace(ground, home=equations).watched(form, model._own, state)
        return replace(model, guards=tuple(found))

    @cached_property
    def program(self) -> Program:
        """The right-hand side, with everything watched."""
        return Program.of(self.form, self.watch.expressions)

    @cached_property
    def _own(self) -> Program:
        return quantities(self.form, {f"start {x}": x for x in self._states})

    @property
    def _states(self) -> tuple[Any, ...]:
        return (*self.form.coordinates, *self.form.velocities)

    @cached_property
    def _widening(self) -> Program:
        d = self.ground.home.definition
        return quantities(self.form, {str(x): x for x in (*d.coordinates, *d.dots)})

    @cached_property
    def _narrowing(self) -> Program:
        form = self.form
        velocities = dict(zip(form.velocities, self.equations.raw.form.definitions, strict=True))
        entries = {str(q): q for q in form.coordinates} | {str(v): e for v, e in velocities.items()}
        return quantities(self.ground.wide, entries)

    def widened(self, time: Any, state: Any, constants: Any = None) -> np.ndarray:
        """The wide state of a state of the split, of numbers of the same kind."""
        return self._mapped(self._widening, time, state, constants)

    def narrow(self, time: Any, wide: Any, constants: Any = None) -> np.ndarray:
        """The state of the split at a wide state."""
        return self._mapped(self._narrowing, time, wide, constants)

    def _mapped(self, program: Program, time: Any, state: Any, constants: Any) -> np.ndarray:
        digits = np.asarray(state).dtype == object
        found = numbers(program, time, list(state), self.ground.values(program, constants))
        if digits:
            return np.array([mpmath.mpf(x) for x in found], dtype=object)
        return np.array(found, dtype=float)

    def lowered(self, time: float, wide: np.ndarray, factor: float) -> SplitModel:
        """The same with the guards that are small at a wide state lowered by a factor, or, for
        zero, left out."""
        state, values = self.narrow(time, wide.astype(float)), self.ground.values(self.program)
        guards = []
        for guard in self.guards:
            if self.ground.smallest(self.form, [guard], state, values) > CLEAR:
                guards.append(guard)
            elif factor:
                guards.append(replace(guard, scale=factor * guard.scale))
        return replace(self, guards=tuple(guards))

    def quality(self, time: Any, wide: np.ndarray) -> float:
        """How far the divisors are from zero at a wide state, in units of their usual sizes; 0
        where the equations have no value there, and no chart leads on."""
        wide = wide.astype(float)
        state, program = self.narrow(float(time), wide), self.program
        values = self.ground.values(program)
        with np.errstate(all="ignore"):
            rates = compiled(program)[0](np.float64(time), [np.float64(x) for x in state], values)
        defined = np.isfinite(np.array(rates, dtype=float)).all()
        if not (defined or (np.isfinite(state).all() and self._at_pole(state))):
            return 0.0
        return self.ground.smallest(self.form, self.guards, state, values)

    def _at_pole(self, state: np.ndarray) -> bool:
        """Whether a state is where the coordinates are singular and charts of the split begin."""
        d = self.equations.definition
        charts = self.equations.system.charts.values()
        singular = [d.door.inward(chart.singular) for chart in charts]
        program = quantities(self.form, {str(i): e for i, e in enumerate(singular)})
        there = numbers(program, self.ground.time, state.tolist(), self.ground.values(program))
        return any(abs(x) < AT_POLE for x in there)


def candidates(ground: SplitGround, time: float, wide: np.ndarray) -> Any:
    """Equations to try at a wide state, with their forms, one after the other."""
    home, point = ground.home, _point(ground, time, wide)
    yield home, home.form
    geometry = ground.geometry(time, wide)
    systems = [home.system] if geometry.quality > CLEAR else []
    systems.append(split_system(home.system, geometry.best))
    for system in systems:
        try:
            equations = equations_near(system, point)
            yield equations, equations.form
            yield equations, equations.raw.form
        except VoronecError:
            continue


def _point(ground: SplitGround, time: float, wide: np.ndarray) -> dict[str, Any]:
    """Numbers of coordinates, parameters and the time by name, exact as doubles."""
    d = ground.home.definition
    named = dict(zip(map(str, d.coordinates), wide.tolist(), strict=False))
    return {**ground.constants, **named, str(d.time): time}
