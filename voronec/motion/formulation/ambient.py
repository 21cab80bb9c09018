"""The ambient formulation: more velocities than are free, and the constraints on them by force.

Where a frame v fails, as omega1 and omega2 of a ball with (omega, gamma) = 0 do at gamma3 = 0, more
velocities w of the body do not: with them the last constraints c = a w + a0 are no longer solved,
but held by their reaction along w,

    M w' = f + a^T lambda,    lambda = -(a M^-1 a^T)^-1 (a M^-1 f + c'),

c' without the accelerations [Theory, eq. (22b)].  The motion keeps c; nothing divides by what
vanishes where v fails.  First integrals are the declared ones, in normal form where c = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.angles import Angles
from voronec.algebra.elimination import solve_linear
from voronec.algebra.normal import canonical, canonical_for_numbers
from voronec.algebra.stand_ins import StandIns
from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.declaration.claims import right_of
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.system import System, bare
from voronec.equations.motions import Motions
from voronec.equations.program.walls import is_rough
from voronec.equations.reduction import in_invariants
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import EngineLimit, VoronecError
from voronec.motion.motion_start import Outset, WideStart
from voronec.motion.request import StartData, Vocabulary
from voronec.motion.split_models import SplitGround, spell_out
from voronec.motion.trajectory import Trajectory

__all__ = ["Formulation", "ambient_formulation"]


@dataclass(frozen=True)
class Formulation:
    """Equations in other variables for the motions of a system, ``home``.

    ``from_home`` gives those of their velocities that home does not have, by name, as functions of
    its coordinates and velocities, in the user's symbols; ``meaning`` the velocities of home that
    they do not have, as functions of theirs.  The other variables are the same.
    """

    home: VoronecEquations
    equations: VoronecEquations
    from_home: Mapping[str, sp.Expr]
    meaning: Mapping[Any, sp.Expr]

    @property
    def home_names(self) -> tuple[str, ...]:
        """The coordinates and velocities of home."""
        system = self.home.system
        return tuple(map(plain_name, (*system.coordinates, *system.velocities)))

    @property
    def vocabulary(self) -> Vocabulary:
        """Names of home, as they are spelled in these variables."""
        return self.equations.memo.once(
            "names of home", lambda: Vocabulary.of(self.equations, self.meaning)
        )

    def start(
        self, vocabulary: Vocabulary, given: StartData, outset: Outset, time: float, exact: bool
    ) -> StartData:
        """The start in these variables: exactly, where velocities of home are given, else by those
        of all coordinates.  ``EngineLimit`` where an ``exact`` start is known in doubles alone."""
        values, names = {**given.scene_initial, **given.initial}, self.home_names
        if {*values} <= {*names} and outset.framed and not outset.notes:
            found = {n: _exactly(values.get(n, 0)) for n in names}
        elif exact:
            raise EngineLimit("the start is not known in these variables but for rounding")
        else:
            ground, own = outset.ground(self.home, time), self.home.system.coordinates
            wide = None if outset.notes else WideStart.of(vocabulary, ground, given, False).wide
            if wide is not None and np.isfinite(wide).all():
                everything = map(plain_name, (*own, *map(velocity, own)))
                found = dict(zip(everything, wide.tolist(), strict=True))
                return replace(given, scene_initial={}, initial=found)
            found = dict(zip(names, outset.state.tolist(), strict=True))
        lost = {*map(plain_name, self.meaning)}
        symbols = {vocabulary.symbols[n]: as_expression(x) for n, x in found.items()}
        beside = {n: e.xreplace(symbols) for n, e in self.from_home.items()}
        kept = {n: x for n, x in found.items() if n not in lost}
        return replace(given, scene_initial={}, initial={**kept, **beside})

    def to_home(self, found: Trajectory) -> Trajectory:
        """A trajectory in these variables as one of the system."""
        events = {name: self._own_state(rows) for name, rows in found.events.items()}
        within = found.within
        return replace(
            self._own_state(found),
            system=self.home.system,
            events=MappingProxyType(events),
            within=None if within is None else lambda times: self.to_home(within(times)),
        )

    def _own_state(self, rows: Any) -> Any:
        """A trajectory, or crossings, with the state of home, where all of it is known."""
        names = self.home_names
        if not {*names} <= {*rows.series, *rows.names}:
            return rows
        state = np.stack([rows[n] for n in names], axis=-1)
        state.flags.writeable = False
        return replace(rows, names=names, state=state)


def _exactly(value: Any) -> Any:
    """A value as given, of a float the number that it is."""
    return sp.Rational(value) if isinstance(value, float) else value


def ambient_formulation(ground: SplitGround, outset: Outset) -> Formulation | None:
    """The ambient formulation of a system: of one whose frame declares velocities ``beside`` its
    own in these, of another in the velocities of its coordinates; None where it is beyond the
    normal form or constraints may become dependent, for groups and redundant coordinates, and where
    forces are not smooth."""
    home = ground.home

    def make() -> Formulation | None:
        system, frame = home.system, home.system.frame
        declared = frame is not None and bool(frame.beside)
        group, charted = frame is not None and frame.is_group, frame is not None and system.charts
        form = home.raw.form
        rough = is_rough((), form.expressions, form.parameters)
        if group or rough or system.fibration.relations or not system.constraints:
            return None
        if not declared and (charted or home.is_large or ground.may_be_dependent(outset.state)):
            return None
        with suppress(VoronecError):
            return _FreeSystem(home, declared).formulation
        return None

    return home.memo.once("ambient formulation", make)


@dataclass(frozen=True)
class _FreeSystem:
    """A system with constraints released: as many of the last as its frame has velocities beside
    its own, where these are ``declared``, else all."""

    home: VoronecEquations
    declared: bool

    @property
    def system(self) -> System:
        """The system."""
        return self.home.system

    @cached_property
    def count(self) -> int:
        """How many constraints are released."""
        frame = self.system.frame
        return len(frame.beside) if self.declared and frame else len(self.system.constraints)

    @property
    def meaning(self) -> Mapping[Any, sp.Expr]:
        """Velocities of home that are none of these, as functions of these."""
        frame = self.system.frame
        if self.declared or frame is None:
            return {}
        return dict(zip(frame.velocities, frame.expressions, strict=True))

    @cached_property
    def free(self) -> System:
        """The system without the constraints."""
        home, k = self.system, self.count
        charts = {
            name: replace(chart, changes={n: self._release(n, x) for n, x in chart.changes.items()})
            for name, chart in home.charts.items()
        }
        base, fibre = home.fibration.base, home.fibration.fibre
        own = spell_out(home, None if self.declared else home.frame)
        return bare(
            home, home.name, **{n: self._release(n, x) for n, x in own.items()}, charts=charts,
            fibration=Fibration((*base, *fibre[-k:]), fibre[:-k]),
            frame=self._release("frame", home.frame),
            invariants=home.invariants if self.declared else {},
        )  # fmt: skip

    def _release(self, part: str, declared: Any) -> Any:
        """A part of what a system declares, where its last constraints are released."""
        if part == "constraints":
            return tuple(declared)[: -self.count]
        if part != "frame":
            return declared
        return Frame.quasi(declared.definitions) if self.declared else None

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
        given = spell_out(self.system, self.system.frame)["constraints"][-self.count :]
        own = [self.motions.on_coordinates.read(c) for c in given]
        if not self.free.invariants:
            return own
        found = in_invariants(self.motions.equations, own)
        if any(c is None for c in found):
            raise EngineLimit("a constraint has no expression in the invariants")
        return found

    @cached_property
    def reactions(self) -> list[Any]:
        """a^T lambda along each of the velocities w, with distances of places as they stand."""
        letters = self._letters
        flow, k = self.flow.in_letters(letters), self.count
        held = [letters.hide(c) for c in self.constraints]
        rows = [[c.diff(w) for w in flow.velocities] for c in held]
        columns = [[*(row[i] for row in rows), f] for i, f in enumerate(flow.force)]
        solved = flow.solve(columns)  # M^-1 a^T, and M^-1 f as the last column
        products = [
            [se.Add(*[a * x[j] for a, x in zip(row, solved, strict=True)]) for j in range(k + 1)]
            for row in rows
        ]
        right = [[-p[-1] - flow.at_rest(c)] for p, c in zip(products, held, strict=True)]
        forces = solve_linear([p[:-1] for p in products], right, flow.relations).values
        pushed = [
            se.Add(*[row[i] * x[0] for row, x in zip(rows, forces, strict=True)])
            for i in range(len(flow.velocities))
        ]
        return [letters.show(e) for e in canonical(pushed, flow.relations)]

    @property
    def _letters(self) -> StandIns:
        """Letters for the distances of places, powers and products of which are taken."""
        form = self.flow.form
        held = [*self.flow.entries, *self.constraints]
        return StandIns.of(held, form, form.velocities) | StandIns.of_distances(held, form)

    @property
    def formulation(self) -> Formulation:
        """The equations with the reactions, and how their velocities follow from those of home."""
        meaning = {se.Symbol(n): self._inward(g) for n, g in self.free.invariants.items()}
        charts = {
            name: replace(chart, changes={**chart.changes, "forces": {
                **chart.changes.get("forces", self.free.forces),
                **self._forces({x: self._in_chart(e, chart) for x, e in meaning.items()}),
            }})
            for name, chart in self.free.charts.items()
        }  # fmt: skip
        system = replace(
            self.free, forces={**self.free.forces, **self._forces(meaning)}, charts=charts,
            integrals=self._integrals(),
        )  # fmt: skip
        below, frame = Motions.of(self.home).on_coordinates, system.frame
        named = frame.expressions if frame is not None else self.free.velocities
        own = {*self.system.velocities}
        fresh = {w: e for w, e in zip(self.free.velocities, named, strict=True) if w not in own}
        found = canonical_for_numbers([below.read(e) for e in fresh.values()], below.form)
        beside = {plain_name(w): below.door.outward(e) for w, e in zip(fresh, found, strict=True)}
        return Formulation(self.home, derive(system), beside, self.meaning)

    def _forces(self, meaning: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
        """The reactions in the user's symbols, by velocity, with the meaning of invariants."""
        names, out = self.free.velocities, self.motions.equations.door.outward
        pushed = zip(names, self.reactions, strict=True)
        return {w: out(e.xreplace(dict(meaning))) for w, e in pushed if e != 0}

    def _in_chart(self, expr: Any, chart: Any) -> Any:
        """A function of the coordinates as one of those of a chart."""
        back = {
            self._inward(x): self._inward(e) for x, e in chart.values(self.free, "back").items()
        }
        return canonical([Angles().resolve(expr.xreplace(back))])[0]

    def _inward(self, expr: Any) -> Any:
        return self.motions.equations.door.inward(expr)

    def _integrals(self) -> dict[str, sp.Expr]:
        """The declared integrals in the velocities w."""
        door, form = self.motions.equations.door, self.flow.form
        ground = replace(form, relations=(*form.relations, *self.constraints))
        spelled = dict(self.meaning)
        if not self.declared:
            names = zip(self.system.invariant_symbols, self.system.invariants.values(), strict=True)
            spelled |= dict(names)
        found = {}
        for name, claim in self.system.integrals.items():
            inside = door.inward(as_expression(right_of(claim)).xreplace(spelled))
            found[name] = door.outward(canonical_for_numbers([inside], ground)[0])
        return found
