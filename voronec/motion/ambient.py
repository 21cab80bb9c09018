"""The ambient formulation: more velocities than are free, and the constraints on them by force.

Where a frame v fails, as omega1 and omega2 of a ball with (omega, gamma) = 0 do at gamma3 = 0, more
velocities w of the body do not: with them the last constraints c = a w + a0 are no longer solved,
but held by their reactions, whose impulses p are velocities themselves,

    M w' + a^T p' = f,    a w' = -c',                                  [Theory, eq. (22a)]

c' without the accelerations.  The motion keeps c; nothing divides by what vanishes where v fails.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import mpmath
import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.angles import Angles
from voronec.algebra.normal import canonical, canonical_for_numbers
from voronec.algebra.rank import generic_rows
from voronec.algebra.symbols import plain_name, unused_name, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.text import as_expression
from voronec.declaration.charts import Chart
from voronec.declaration.claims import right_of
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.system import System, bare, spell_out, system_in
from voronec.equations.definition import Definition, read
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.motions import Motions
from voronec.equations.reduction import in_invariants
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, IntegrationError, VoronecError
from voronec.motion.constraint_geometry import implied_rows
from voronec.motion.motion_start import InitialState, WideStart
from voronec.motion.reactions import drift
from voronec.motion.request import Namespace, StartData, state_names
from voronec.motion.trajectory import Trajectory

DEPENDENT = "the constraints become dependent"


@dataclass(frozen=True)
class AmbientFormulation:
    """Equations in other variables for the motions of a system, ``home``.

    ``beside`` gives those of their velocities that no velocities of coordinates are, by name, as
    functions of the coordinates and velocities of home, in the user's symbols; ``meaning`` the
    velocities and invariants of home that they do not have, as functions of theirs.
    """

    home: VoronecEquations
    equations: VoronecEquations
    beside: Mapping[str, sp.Expr]
    meaning: Mapping[Any, sp.Expr]

    def namespace(self, inputs: Mapping[Any, sp.Expr]) -> Namespace:
        """Names of home, as they are spelled in these variables, with those of its inputs."""
        found = Namespace.of(self.equations, {**inputs, **self.meaning})
        return replace(found, home=self.home)

    def start(
        self, namespace: Namespace, given: StartData, outset: InitialState, time: float, bits: int,
        project: bool,
    ) -> StartData:  # fmt: skip
        """The start in these variables, in so many ``bits`` where these are not zero: by all
        velocities of the coordinates, or by those of home and of the frame, where they are given or
        where no velocities of coordinates are numbers."""
        names, values = state_names(self.home.system), {**given.scene_initial, **given.initial}
        if outset.notes and outset.framed:  # what was moved is not moved elsewhere
            values = dict(zip(names, outset.state.tolist(), strict=True))
            given = replace(given, scene_initial={}, initial=values)
        if outset.framed and self.beside and {*values} <= {*names}:
            found = {n: _exactly(values.get(n, 0)) for n in names}
        else:
            ground, own = outset.ground(self.home, time), self.home.system.coordinates
            framed = outset.state if outset.framed and not bits else None
            start = WideStart.of(namespace, ground, given, project, framed)
            wide = start.exact(bits)[0] if bits else start.wide
            if bits or np.isfinite(wide).all():
                group = self.home.system.on_group
                dots = self.home.system.directions if group else map(velocity, own)
                everything = map(plain_name, (*own, *dots))
                found = dict(zip(everything, map(_exactly, wide), strict=True))
                return replace(given, scene_initial={}, initial=found)
            found = dict(zip(names, outset.state.tolist(), strict=True))
        symbols = {namespace.symbols[n]: as_expression(x) for n, x in found.items()}
        found |= {n: e.xreplace(symbols) for n, e in self.beside.items()}
        return replace(given, scene_initial={}, initial=found)

    def to_home(self, found: Trajectory, outputs: tuple[str, ...]) -> Trajectory:
        """A trajectory in these variables as one of the system, with the outputs asked for."""
        events = {name: self._own_state(rows) for name, rows in found.events.items()}
        within = found.within
        return replace(
            self._own_state(found),
            system=self.home.system,
            outputs=outputs,
            events=MappingProxyType(events),
            within=None if within is None else lambda t: self.to_home(within(t), outputs),
        )

    def failure(self, error: IntegrationError, outputs: tuple[str, ...]) -> IntegrationError:
        """The error of a run in these variables as one of the system."""
        assert error.trajectory is not None
        found = self.to_home(error.trajectory, outputs)
        reason = DEPENDENT if error.singular else found.halted
        return IntegrationError(
            f"system '{self.home.system.name}': {reason} after t = {float(error.time):.12g}; end "
            "the run before that, or use another chart",
            error.time,
            error.state,
            replace(found, halted=reason),
        )

    def _own_state(self, rows: Any) -> Any:
        """A trajectory, or crossings, with the state of home."""
        names = state_names(self.home.system)
        state = np.stack([rows[n] for n in names], axis=-1)
        state.flags.writeable = False
        return replace(rows, names=names, state=state)


def _exactly(value: Any) -> Any:
    """A value as given, of a float or a number of mpmath the fraction that it is."""
    if isinstance(value, mpmath.mpf):
        return sp.Rational(*mpmath.libmp.to_rational(value._mpf_))
    return sp.Rational(value) if isinstance(value, float) else value


def ambient_formulation(home: VoronecEquations, reactions: bool) -> AmbientFormulation | None:
    """The ambient formulation of a system: in the velocities of its frame and those that it
    declares ``beside`` them, else, or where ``reactions`` are asked for, in those of its
    coordinates, or of its group; None where nothing binds the velocities, and where the equations
    have no such form."""

    def make() -> AmbientFormulation | None:
        system, frame = home.system, home.system.frame
        if not (system.constraints or system.fibration.relations or frame):
            return None
        with suppress(VoronecError):
            if system.on_group:
                return _on_group(home)
            if frame is not None and frame.beside and not reactions:
                return _FrameFormulation(home, frame).formulation
            return _on_coordinates(home)
        return None

    return home.memo.once(("ambient formulation", reactions), make)


@dataclass(frozen=True)
class _Constraint:
    """A constraint that is held by its reaction: its rate is the ``slopes`` times the rates of
    velocities, and a ``remainder``."""

    slopes: Mapping[Any, sp.Expr]
    remainder: sp.Expr


LARGE = sp.Integer(2) ** 20
"""Impulses are measured in so many units: nothing depends on them, and their errors, large where
constraints are almost dependent, would make steps short."""


def _with_reactions(
    forces: Mapping[Any, Any],
    held: Sequence[_Constraint],
    impulses: Sequence[Any],
    massless: bool = False,
    idle: Sequence[Sequence[sp.Expr]] = (),
    inertia: Any = 1,
) -> dict[Any, sp.Expr]:
    """Forces with the reactions of constraints, and those along the ``impulses`` of the reactions,
    which are velocities in ``LARGE`` units.

    Where some velocities are ``massless`` the rates of the constraints, which vanish, give them
    inertia.  Sums of reactions that do nothing, with the ``idle`` coefficients b, b a = 0, vanish:
    a w' - b^T b p'/inertia = -c'.
    """
    found = {q: as_expression(e) for q, e in forces.items()}
    for constraint, p in zip(held, impulses, strict=True):
        rate = sp.Add(
            constraint.remainder, *(a * velocity(w) for w, a in constraint.slopes.items())
        )
        for w, a in constraint.slopes.items():
            pull = LARGE * velocity(p) + (rate if massless else 0)
            found[w] = found.get(w, sp.Integer(0)) - a * pull
        found[p] = -LARGE * rate
    for row in idle:
        whole = sp.Add(*(b * velocity(p) for b, p in zip(row, impulses, strict=True)))
        for b, p in zip(row, impulses, strict=True):
            found[p] += b * LARGE**2 * whole / inertia
    return found


# -- in the velocities of the coordinates ---------------------------------------------------


def _on_coordinates(home: VoronecEquations) -> AmbientFormulation:
    system, frame, d = home.system, home.system.frame, home.definition
    count = len(implied_rows(d)[0])
    sums = _fresh(system, "sum", count)

    def free(parts: Mapping[str, Any], there: Definition) -> dict[str, Any]:
        if len(implied_rows(there)[0]) != count:
            raise EngineLimit("a chart has other constraints")
        forces = _held_by_reactions(parts["forces"], there, [*map(velocity, sums)])
        return {"lagrangian": parts["lagrangian"], "constraints": (), "forces": forces}

    charts = {}
    for name, declared in system.charts.items():
        chart = _chart_of_velocities(system, declared)
        there = read(system_in(system, name))
        charts[name] = replace(chart, changes=free(chart.changes, there))
    moved = bare(
        system, system.name, **free(spell_out(system, frame), d), frame=None,
        fibration=Fibration((*system.coordinates, *sums)), charts=charts,
    )  # fmt: skip
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    meaning |= zip(system.invariant_symbols, system.invariants.values(), strict=True)
    conditions = (*d.constraints.expressions(d.dots), *d.differentiated.expressions(d.dots))
    form = replace(home.raw.form, velocities=d.dots)
    integrals = _integrals(system, d.bridge, meaning, form, conditions)
    return AmbientFormulation(home, derive(replace(moved, integrals=integrals)), {}, meaning)


def _fresh(system: System, title: str, count: int) -> list[sp.Symbol]:
    taken = {plain_name(s) for s in system.known_symbols()}
    return [sp.Symbol(unused_name(f"{title}{i + 1}", taken)) for i in range(count)]


def _held_by_reactions(
    forces: Mapping[Any, Any], d: Definition, impulses: Sequence[Any],
    among: Sequence[int] | None = None,
) -> dict[Any, sp.Expr]:  # fmt: skip
    """Forces with the reactions of the constraints and the relations of a system."""
    held, out, (rows, idle) = [], d.bridge.outward, implied_rows(d, among)
    rates = d.dots if d.group is None else d.group.coordinate_rates(d.dots)
    for *row, offset in rows:
        whole = se.Add(offset, *(a * w for a, w in zip(row, d.dots, strict=True)))
        slopes = {out(w): out(a) for a, w in zip(row, d.dots, strict=True) if a != 0}
        held.append(_Constraint(slopes, out(drift(d, rates, whole))))
    mass = [[d.lagrangian.diff(u).diff(w) for u in d.dots] for w in d.dots]
    massless = len(generic_rows(mass, d.relations)) < len(mass)
    inertia = out(se.Add(*(mass[k][k] for k in range(len(mass)))))
    sums = [[out(b) for b in row] for row in idle]
    return _with_reactions(forces, held, impulses, massless, sums, inertia)


def _integrals(
    system: System,
    bridge: SymPyBridge,
    meaning: Mapping[Any, Any],
    form: FirstOrderForm,
    held: Iterable[Any],
) -> dict[str, sp.Expr]:
    """The declared integrals in the velocities of a form, in normal form where constraints that
    are ``held`` vanish; ``meaning`` are velocities of the system as functions of these."""
    ground, found = replace(form, relations=(*form.relations, *held)), {}
    for name, claim in system.integrals.items():
        found[name] = as_expression(right_of(claim)).xreplace(meaning).xreplace(meaning)
        with suppress(EngineLimit):
            short = canonical_for_numbers([bridge.inward(found[name])], ground)[0]
            found[name] = bridge.outward(short)
    return found


def _on_group(home: VoronecEquations) -> AmbientFormulation:
    """In all velocities of a group but those that a constraint of their own gives everywhere."""
    system, frame, d = home.system, home.system.frame, home.definition
    assert frame is not None
    matrix, own = d.constraints.matrix, {}
    for a, w in enumerate(d.dots[d.base :], d.base):
        rows = [k for k, row in enumerate(matrix) if row[a] != 0]
        if len(rows) == 1 and rows[0] not in own and matrix[rows[0]][a].is_Number:
            own[rows[0]] = w
    conditions = d.constraints.expressions(d.dots)
    solved = {w: w - conditions[k] / conditions[k].diff(w) for k, w in own.items()}
    held = [k for k in range(len(matrix)) if k not in own]
    names = dict(zip(d.dots, system.directions, strict=True))
    free = [w for w in d.dots if w not in solved]
    impulses = _fresh(system, "impulse", len(implied_rows(d, held)[0]))
    moved = bare(
        system, system.name, constraints=tuple(system.constraints[k] for k in own),
        forces=_held_by_reactions(system.forces, d, impulses, held),
        frame=Frame.group(
            (*map(names.get, free), *impulses), frame.brackets or {}, frame.rates,
            tuple(map(names.get, solved)),
        ),
    )  # fmt: skip
    # the momenta are p_a dw^a/dv_i, in all velocities
    inertial, slopes = d.lagrangian.xreplace(solved), dict(home.raw.form.dependent)
    parts = {
        p: se.Add(*(inertial.diff(w) * slopes.get(w, w).diff(v) for w in free))
        for p, v in zip(d.momenta, d.velocities, strict=False)
    }
    out = d.bridge.outward
    meaning = {out(x): out(e) for x, e in parts.items()}
    meaning |= zip(system.invariant_symbols, system.invariants.values(), strict=True)
    spelled = meaning | {out(w): out(e) for w, e in solved.items()}
    form = replace(home.raw.form, velocities=(*free,))
    rest = [conditions[k] for k in held]
    integrals = _integrals(system, d.bridge, spelled, form, rest)
    return AmbientFormulation(home, derive(replace(moved, integrals=integrals)), {}, meaning)


# -- systems written otherwise ---------------------------------------------------------------


def _chart_of_velocities(system: System, chart: Chart) -> Chart:
    """A chart of a system in the velocities of the coordinates, which follow these."""
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


# -- in the velocities of a frame and others beside them ------------------------------------


@dataclass(frozen=True)
class _FrameFormulation:
    """A system whose frame has velocities beside its own, without as many of its last
    constraints."""

    home: VoronecEquations
    frame: Frame

    @property
    def count(self) -> int:
        """How many constraints are released."""
        return len(self.frame.beside)

    @cached_property
    def free(self) -> System:
        """The system without the constraints."""
        home, k = self.home.system, self.count
        charts = {
            name: replace(chart, changes={n: self._release(n, x) for n, x in chart.changes.items()})
            for name, chart in home.charts.items()
        }
        base, fibre = home.fibration.base, home.fibration.fibre
        parts = {n: self._release(n, x) for n, x in spell_out(home, None).items()}
        return bare(
            home, home.name, **parts, charts=charts, invariants=home.invariants,
            fibration=Fibration((*base, *fibre[-k:]), fibre[:-k]),
            frame=self._release("frame", self.frame),
        )  # fmt: skip

    def _release(self, part: str, declared: Any) -> Any:
        """A part of what a system declares, where its last constraints are released."""
        if part == "constraints":
            return tuple(declared)[: -self.count]
        return Frame.quasi(declared.definitions) if part == "frame" else declared

    @cached_property
    def motions(self) -> Motions:
        """The motions of that."""
        return Motions.of(derive(self.free))

    @cached_property
    def flow(self) -> VectorField:
        """Its equations, in the invariants where there are some."""
        return self.motions.on_invariants if self.free.invariants else self.motions.on_coordinates

    @cached_property
    def constraints(self) -> list[Any]:
        """The released constraints c as functions of its state."""
        given = spell_out(self.home.system, self.frame)["constraints"][-self.count :]
        own = [self.motions.on_coordinates.read(c) for c in given]
        if not self.free.invariants:
            return own
        found = in_invariants(self.motions.equations, own)
        if any(c is None for c in found):
            raise EngineLimit("a constraint has no expression in the invariants")
        return found

    @property
    def formulation(self) -> AmbientFormulation:
        """The equations with the reactions, and how their velocities follow from those of home."""
        free = self.free
        sums, impulses = (_fresh(free, title, self.count) for title in ("sum", "impulse"))
        meaning = {se.Symbol(n): self._inward(g) for n, g in free.invariants.items()}

        def forces(given: Mapping[Any, Any], meaning: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
            out, held = self.motions.equations.bridge.outward, []
            for c in self.constraints:
                pairs = zip(free.velocities, self.flow.velocities, strict=True)
                slopes = {w: out(c.diff(v).xreplace(meaning)) for w, v in pairs if c.diff(v) != 0}
                held.append(_Constraint(slopes, out(self.flow.at_rest(c).xreplace(meaning))))
            return _with_reactions(given, held, impulses)

        def frame_with_impulses(own: Any) -> Frame:
            return Frame.quasi(
                own.definitions | dict(zip(impulses, map(velocity, sums), strict=True))
            )

        charts = {}
        for name, chart in free.charts.items():
            there = {x: self._in_chart(e, chart) for x, e in meaning.items()}
            changes = {
                **chart.changes,
                "forces": forces(chart.changes.get("forces", free.forces), there),
            }
            if "frame" in changes:
                changes["frame"] = frame_with_impulses(changes["frame"])
            charts[name] = replace(chart, changes=changes)
        system = replace(
            free, forces=forces(free.forces, meaning), charts=charts,
            frame=frame_with_impulses(self.frame),
            fibration=Fibration((*free.fibration.base, *sums), free.fibration.fibre),
            integrals=_integrals(
                self.home.system, self.motions.equations.bridge, {}, self.flow.form,
                self.constraints,
            ),
        )  # fmt: skip
        below, own = Motions.of(self.home).on_coordinates, {*self.home.system.velocities}
        fresh = {w: e for w, e in self.frame.definitions.items() if w not in own}
        found = canonical_for_numbers([below.read(e) for e in fresh.values()], below.form)
        beside = {plain_name(w): below.bridge.outward(e) for w, e in zip(fresh, found, strict=True)}
        return AmbientFormulation(self.home, derive(system), beside, {})

    def _in_chart(self, expr: Any, chart: Any) -> Any:
        """A function of the coordinates as one of those of a chart."""
        back = {
            self._inward(x): self._inward(e) for x, e in chart.values(self.free, "back").items()
        }
        return canonical([Angles().resolve(expr.xreplace(back))])[0]

    def _inward(self, expr: Any) -> Any:
        return self.motions.equations.bridge.inward(expr)
