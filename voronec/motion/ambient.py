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
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, IntegrationError, VoronecError
from voronec.motion.constant_rank import Row
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
        names = Namespace.of(self.equations, {**inputs, **self.meaning})
        return replace(names, home=self.home)

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
            initial = {n: _exactly(values.get(n, 0)) for n in names}
        else:
            ground, coordinates = outset.ground(self.home, time), self.home.system.coordinates
            framed = outset.state if outset.framed and not bits else None
            start = WideStart.of(namespace, ground, given, project, framed)
            wide = start.exact(bits)[0] if bits else start.wide
            if bits or np.isfinite(wide).all():
                group = self.home.system.on_group
                dots = self.home.system.directions if group else map(velocity, coordinates)
                everything = map(plain_name, (*coordinates, *dots))
                initial = dict(zip(everything, map(_exactly, wide), strict=True))
                return replace(given, scene_initial={}, initial=initial)
            initial = dict(zip(names, outset.state.tolist(), strict=True))
        symbols = {namespace.symbols[n]: as_expression(x) for n, x in initial.items()}
        initial |= {n: e.xreplace(symbols) for n, e in self.beside.items()}
        return replace(given, scene_initial={}, initial=initial)

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
        trajectory = self.to_home(error.trajectory, outputs)
        reason = DEPENDENT if error.singular else trajectory.halted
        return IntegrationError(
            f"system '{self.home.system.name}': {reason} after t = {float(error.time):.12g}; end "
            "the run before that, or use another chart",
            error.time,
            error.state,
            replace(trajectory, halted=reason),
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
                return _on_frame(home, frame)
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
    loads = {q: as_expression(e) for q, e in forces.items()}
    for constraint, p in zip(held, impulses, strict=True):
        rate = sp.Add(
            constraint.remainder, *(a * velocity(w) for w, a in constraint.slopes.items())
        )
        for w, a in constraint.slopes.items():
            pull = LARGE * velocity(p) + (rate if massless else 0)
            loads[w] = loads.get(w, sp.Integer(0)) - a * pull
        loads[p] = -LARGE * rate
    for row in idle:
        whole = sp.Add(*(b * velocity(p) for b, p in zip(row, impulses, strict=True)))
        for b, p in zip(row, impulses, strict=True):
            loads[p] += b * LARGE**2 * whole / inertia
    return loads


# -- in the velocities of the coordinates ---------------------------------------------------


def _on_coordinates(home: VoronecEquations) -> AmbientFormulation:
    system, frame, d = home.system, home.system.frame, home.definition
    implied = implied_rows(d)
    sums = _fresh(system, "sum", len(implied[0]))

    def free(parts: Mapping[str, Any], there: Definition) -> dict[str, Any]:
        rows = implied if there is d else implied_rows(there)
        if len(rows[0]) != len(sums):
            raise EngineLimit("a chart has other constraints")
        forces = _held_by_reactions(parts["forces"], there, [*map(velocity, sums)], *rows)
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
    rows: Sequence[Row], idle: Sequence[Row],
) -> dict[Any, sp.Expr]:  # fmt: skip
    """Forces with the reactions of the constraints and the relations of a system."""
    held, out = [], d.bridge.outward
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
    ground, integrals = replace(form, relations=(*form.relations, *held)), {}
    for name, claim in system.integrals.items():
        integrals[name] = as_expression(right_of(claim)).xreplace(meaning).xreplace(meaning)
        with suppress(EngineLimit):
            short = canonical_for_numbers([bridge.inward(integrals[name])], ground)[0]
            integrals[name] = bridge.outward(short)
    return integrals


def _on_group(home: VoronecEquations) -> AmbientFormulation:
    """In all velocities of a group but those that a constraint of their own gives everywhere."""
    system, frame, d = home.system, home.system.frame, home.definition
    assert frame is not None
    matrix, pivots = d.constraints.matrix, {}
    for a, w in enumerate(d.dots[d.base :], d.base):
        rows = [k for k, row in enumerate(matrix) if row[a] != 0]
        if len(rows) == 1 and rows[0] not in pivots and matrix[rows[0]][a].is_Number:
            pivots[rows[0]] = w
    conditions = d.constraints.expressions(d.dots)
    solved = {w: w - conditions[k] / conditions[k].diff(w) for k, w in pivots.items()}
    held = [k for k in range(len(matrix)) if k not in pivots]
    names = dict(zip(d.dots, system.directions, strict=True))
    free = [w for w in d.dots if w not in solved]
    implied = implied_rows(d, held)
    impulses = _fresh(system, "impulse", len(implied[0]))
    moved = bare(
        system, system.name, constraints=tuple(system.constraints[k] for k in pivots),
        forces=_held_by_reactions(system.forces, d, impulses, *implied),
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


def _on_frame(home: VoronecEquations, frame: Frame) -> AmbientFormulation:
    """Of a system whose frame has velocities beside its own, without as many of its last
    constraints."""
    system, count = home.system, len(frame.beside)

    def release(part: str, declared: Any) -> Any:
        if part == "constraints":
            return tuple(declared)[:-count]
        return Frame.quasi(declared.definitions) if part == "frame" else declared

    base, fibre, spelled = system.fibration.base, system.fibration.fibre, spell_out(system, None)
    charts = {
        name: replace(chart, changes={n: release(n, x) for n, x in chart.changes.items()})
        for name, chart in system.charts.items()
    }
    free = bare(
        system, system.name, **{n: release(n, x) for n, x in spelled.items()}, charts=charts,
        invariants=system.invariants, frame=release("frame", frame),
        fibration=Fibration((*base, *fibre[-count:]), fibre[:-count]),
    )  # fmt: skip
    motions = Motions.of(derive(free))
    flow = motions.on_invariants if free.invariants else motions.on_coordinates
    bridge = motions.equations.bridge
    given = spell_out(system, frame)["constraints"][-count:]
    constraints = [motions.on_coordinates.read(c) for c in given]
    if free.invariants:
        constraints = in_invariants(motions.equations, constraints)
    if any(c is None for c in constraints):
        raise EngineLimit("a constraint has no expression in the invariants")
    sums, impulses = (_fresh(free, title, count) for title in ("sum", "impulse"))
    meaning = {se.Symbol(n): bridge.inward(g) for n, g in free.invariants.items()}

    def parts(forces: Mapping[Any, Any], own: Frame | None, meaning: Mapping[Any, Any]) -> Any:
        """Forces with the reactions, and a frame with their impulses."""
        held = []
        for c in constraints:
            pairs = zip(free.velocities, flow.velocities, strict=True)
            slopes = {w: c.diff(v).xreplace(meaning) for w, v in pairs if c.diff(v) != 0}
            out = {w: bridge.outward(e) for w, e in slopes.items()}
            held.append(_Constraint(out, bridge.outward(flow.at_rest(c).xreplace(meaning))))
        changes = {"forces": _with_reactions(forces, held, impulses)}
        moving = dict(zip(impulses, map(velocity, sums), strict=True))
        return changes | ({"frame": Frame.quasi(own.definitions | moving)} if own else {})

    moved = {}
    for name, chart in free.charts.items():
        back = {bridge.inward(x): bridge.inward(e) for x, e in chart.values(free, "back").items()}
        there = {x: canonical([Angles().resolve(e.xreplace(back))])[0] for x, e in meaning.items()}
        fresh = parts(chart.changes.get("forces", free.forces), chart.changes.get("frame"), there)
        moved[name] = replace(chart, changes={**chart.changes, **fresh})
    whole = replace(
        free, charts=moved, **parts(free.forces, frame, meaning),
        fibration=Fibration((*free.fibration.base, *sums), free.fibration.fibre),
        integrals=_integrals(system, bridge, {}, flow.form, constraints),
    )  # fmt: skip
    below = Motions.of(home).on_coordinates
    others = {w: e for w, e in frame.definitions.items() if w not in {*system.velocities}}
    definitions = canonical_for_numbers([below.read(e) for e in others.values()], below.form)
    beside = zip(map(plain_name, others), map(below.bridge.outward, definitions), strict=True)
    return AmbientFormulation(home, derive(whole), dict(beside), {})
