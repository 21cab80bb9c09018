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
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.text import as_expression
from voronec.declaration.claims import right_of
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.system import System, bare, system_in
from voronec.equations.definition import Definition, read
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.motions import Motions
from voronec.equations.program.switches import is_rough
from voronec.equations.reduction import in_invariants
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, VoronecError
from voronec.motion.motion_start import InitialState, WideStart
from voronec.motion.reactions import conditions_of, drift
from voronec.motion.request import Namespace, StartData
from voronec.motion.split_models import fresh_symbol, spell_out, split_charts
from voronec.motion.trajectory import Trajectory


@dataclass(frozen=True)
class AmbientFormulation:
    """Equations in other variables for the motions of a system, ``home``.

    ``beside`` gives those of their velocities that no velocities of coordinates are, by name, as
    functions of the coordinates and velocities of home, in the user's symbols; ``meaning`` the
    velocities of home that they do not have, as functions of theirs.
    """

    home: VoronecEquations
    equations: VoronecEquations
    beside: Mapping[str, sp.Expr]
    meaning: Mapping[Any, sp.Expr]

    @property
    def home_names(self) -> tuple[str, ...]:
        """The coordinates and velocities of home."""
        system = self.home.system
        return tuple(map(plain_name, (*system.coordinates, *system.velocities)))

    def namespace(self, inputs: Mapping[Any, sp.Expr]) -> Namespace:
        """Names of home, as they are spelled in these variables, with those of its inputs."""
        found = Namespace.of(self.equations, {**inputs, **self.meaning})
        d = self.home.definition
        return replace(found, home_definition=replace(d, frame=None, velocities=d.dots))

    def start(
        self, namespace: Namespace, given: StartData, outset: InitialState, time: float, bits: int
    ) -> StartData:
        """The start in these variables, in so many ``bits`` where these are not zero: by all
        velocities of the coordinates, or by those of home and of the frame, where they are given or
        where no velocities of coordinates are numbers."""
        names, values = self.home_names, {**given.scene_initial, **given.initial}
        if outset.notes and outset.framed:  # what was moved is not moved elsewhere
            values = dict(zip(names, outset.state.tolist(), strict=True))
            given = replace(given, scene_initial={}, initial=values)
        if outset.framed and self.beside and {*values} <= {*names}:
            found = {n: _exactly(values.get(n, 0)) for n in names}
        else:
            ground, own = outset.ground(self.home, time), self.home.system.coordinates
            framed = outset.state if outset.framed and not bits else None
            start = WideStart.of(namespace, ground, given, False, framed)
            wide = start.exact(bits)[0] if bits else start.wide
            if bits or np.isfinite(wide).all():
                everything = map(plain_name, (*own, *map(velocity, own)))
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

    def _own_state(self, rows: Any) -> Any:
        """A trajectory, or crossings, with the state of home."""
        state = np.stack([rows[n] for n in self.home_names], axis=-1)
        state.flags.writeable = False
        return replace(rows, names=self.home_names, state=state)


def _exactly(value: Any) -> Any:
    """A value as given, of a float or a number of mpmath the fraction that it is."""
    if isinstance(value, mpmath.mpf):
        return sp.Rational(*mpmath.libmp.to_rational(value._mpf_))
    return sp.Rational(value) if isinstance(value, float) else value


def ambient_formulation(home: VoronecEquations, reactions: bool) -> AmbientFormulation | None:
    """The ambient formulation of a system: in the velocities of its frame and those that it
    declares ``beside`` them, else, or where ``reactions`` are asked for, in those of its
    coordinates; None on groups, where forces are not smooth, and where the equations have no such
    form."""

    def make() -> AmbientFormulation | None:
        system, frame = home.system, home.system.frame
        form, bound = home.raw.form, system.constraints or system.fibration.relations
        if system.on_group or not bound or is_rough((), form.expressions, form.parameters):
            return None  # velocities that friction holds at zero would be rounding
        with suppress(VoronecError):
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


def _with_reactions(
    forces: Mapping[Any, Any], held: Sequence[_Constraint], sums: Sequence[Any], massless: bool
) -> dict[Any, sp.Expr]:
    """Forces with the reactions of constraints, those along the ``sums`` among them, coordinates
    whose velocities are the impulses of the reactions.

    Where some velocities are ``massless`` the rates of the constraints, which vanish, give them
    inertia.
    """
    found = {q: as_expression(e) for q, e in forces.items()}
    for constraint, p in zip(held, sums, strict=True):
        rate = sp.Add(
            constraint.remainder, *(a * velocity(w) for w, a in constraint.slopes.items())
        )
        for w, a in constraint.slopes.items():
            pull = velocity(velocity(p)) + (rate if massless else 0)
            found[w] = found.get(w, sp.Integer(0)) - a * pull
        found[p] = -rate
    return found


# -- in the velocities of the coordinates ---------------------------------------------------


def _on_coordinates(home: VoronecEquations) -> AmbientFormulation:
    system, frame, d = home.system, home.system.frame, home.definition
    mass = [[d.lagrangian.diff(u).diff(w) for u in d.dots] for w in d.dots]
    massless = len(generic_rows(mass, d.relations)) < len(mass)
    count = len(d.constraints.matrix) + len(d.differentiated.matrix)
    sums = _fresh(system, "sum", count)

    def free(parts: Mapping[str, Any], there: Definition) -> dict[str, Any]:
        forces = _with_reactions(parts["forces"], _constraints_of(there), sums, massless)
        return {"lagrangian": parts["lagrangian"], "constraints": (), "forces": forces}

    charts = {
        name: replace(split, changes=free(split.changes, read(system_in(system, name))))
        for name, split in split_charts(system).items()
    }
    moved = bare(
        system, system.name, **free(spell_out(system, frame), d), frame=None,
        fibration=Fibration((*system.coordinates, *sums)), charts=charts,
    )  # fmt: skip
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    named = dict(zip(system.invariant_symbols, system.invariants.values(), strict=True))
    conditions = (*d.constraints.expressions(d.dots), *d.differentiated.expressions(d.dots))
    form = replace(home.raw.form, velocities=d.dots)
    integrals = _integrals(system, d.bridge, {**meaning, **named}, form, conditions)
    return AmbientFormulation(home, derive(replace(moved, integrals=integrals)), {}, meaning)


def _fresh(system: System, title: str, count: int) -> list[sp.Symbol]:
    taken = {plain_name(s) for s in system.known_symbols()}
    return [fresh_symbol(f"{title}{i + 1}", taken) for i in range(count)]


def _constraints_of(d: Definition) -> list[_Constraint]:
    """The constraints and the relations of a system, in the velocities of its coordinates."""
    found, out = [], d.bridge.outward
    for *row, offset in conditions_of(d)[: -len(d.velocities)]:
        whole = se.Add(offset, *(a * w for a, w in zip(row, d.dots, strict=True)))
        slopes = {out(w): out(a) for a, w in zip(row, d.dots, strict=True) if a != 0}
        found.append(_Constraint(slopes, out(drift(d, d.dots, whole))))
    return found


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
            return _with_reactions(given, held, sums, False)

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
