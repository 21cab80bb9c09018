"""First-order equations as a straight-line program, for systems too large for normal forms.

    qdot = H v + h0,   qddot = H vdot + gamma            H, h0, gamma from one elimination
    mass = H^T L_qdot,qdot H
    force = H^T (Q + L_q - d/dt L_qdot)                  at vdot = 0, that is, qddot = gamma

[Theory, eq. (12)].  These are Voronec's equations: the bracket terms are the derivatives of H, and
gamma, which solves the differentiated constraints, holds them.  The Lagrangian and the constraints
are stages (named sums); forward differentiation along the columns of H and along the motion, and
one reverse sweep for L_q and L_qdot with its derivative along the motion, add stages and open none.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import symengine as se

from voronec.algebra.stages import (
    ONE,
    ZERO,
    Cyclic,
    StagedElimination,
    Stages,
    factor_sums,
    needed_stages,
    shared_sums,
)
from voronec.equations.definition import Definition
from voronec.equations.derivation import Derivation, FirstOrderForm
from voronec.errors import EngineLimit


@dataclass(frozen=True)
class StagedSystem:
    """The Lagrangian, the forces and the conditions on velocities as one program of stages.

    ``conditions`` are affine in the velocities: constraints, quasi-velocities of the frame,
    differentiated relations; on a motion they equal ``right``.
    """

    definition: Definition
    stages: Stages
    lagrangian: Any
    forces: tuple[Any, ...]
    conditions: tuple[Any, ...]
    right: tuple[Any, ...]

    @classmethod
    def of(cls, d: Definition, prefix: str) -> StagedSystem:
        """Name the sums of a definition, and the parts that sums share."""
        stages = Stages(prefix)
        dots = d.coordinate_velocities
        frame = d.frame.expressions(dots) if d.frame else []
        meaning = dict(zip(d.velocities, frame, strict=False))  # in constraints, spelled out
        constraints = [d.bridge.inward(c).xreplace(meaning) for c in d.system.constraints]
        affine = _is_affine(constraints, dots)
        conditions = constraints if affine else d.constraints.expressions(dots)
        right = [ZERO] * len(conditions) + list(d.velocities)
        conditions += frame or dots[: d.base]
        conditions += d.differentiated.expressions(dots)
        right += [ZERO] * len(d.relations)
        named = [stages.name(e) for e in (d.lagrangian, *d.forces, *conditions)]
        stages.replace(shared_sums(stages.definitions, stages.fresh))
        count = 1 + len(d.forces)
        return cls(d, stages, named[0], tuple(named[1:count]), tuple(named[count:]), tuple(right))

    @cached_property
    def order(self) -> list[Any]:
        """All stages, each after those it uses."""
        return needed_stages(
            self.stages.definitions, (self.lagrangian, *self.forces, *self.conditions)
        )

    @cached_property
    def moving_stages(self) -> frozenset[Any]:
        """Velocities, and stages that depend on them."""
        moving = set(self.definition.coordinate_velocities)
        for x in self.order:
            if not moving.isdisjoint(self.stages.definitions[x].free_symbols):
                moving.add(x)
        return frozenset(moving)

    def expression(self, x: Any) -> Any:
        """What a stage stands for; anything else is itself."""
        return self.stages.definitions.get(x, x)

    def partials(self, expr: Any) -> list[tuple[Any, Any]]:
        """Pairs (symbol, derivative by it) of an expression; stages are not opened."""
        pairs = ((w, expr.diff(w)) for w in sorted(expr.free_symbols, key=str))
        return [(w, p) for w, p in pairs if p != 0]


def _is_affine(exprs: Sequence[Any], dots: Sequence[Any]) -> bool:
    return not any(se.has_symbol(e.diff(v), w) for e in exprs for v in dots for w in dots)


class StagedMotion:
    """Everything along a motion, as one program ``stages`` in q, v, t."""

    def __init__(self, structure: StagedSystem, prefix: str) -> None:
        self.structure = structure
        d = self.definition = structure.definition
        self.stages = Stages(prefix, Cyclic(d.coordinates))
        self._value: dict[Any, Any] = {}
        for x in structure.order:
            if x not in structure.moving_stages:
                self._value[x] = self.on(structure.expression(x))
        self._lifts: dict[Any, list[Any]] = {}
        self._solve()
        for x in structure.order:
            if x in structure.moving_stages:
                self._value[x] = self.on(structure.expression(x))
        self._accelerate()

    def on(self, expr: Any) -> Any:
        """The value on the motion of an expression in stages of the structure."""
        inside = {w: self._value[w] for w in expr.free_symbols if w in self._value}
        return self.stages.name(expr.xreplace(inside) if inside else expr)

    def _solve(self) -> None:
        """H, h0 and the rates."""
        s, d = self.structure, self.definition
        dots, n = d.coordinate_velocities, len(d.velocities)
        rows = [self._row(c) for c in s.conditions]
        self._elimination = StagedElimination(self.stages, rows, len(dots), d.relations)
        rest: dict[Any, Any] = dict.fromkeys(dots, ZERO)
        offsets = [self._at_rest(c, rest) for c in s.conditions]
        columns = [
            self._elimination.solve([ONE if r == v else ZERO for r in s.right])
            for v in d.velocities
        ]
        drift = self._elimination.solve([-o for o in offsets])
        for a, q in enumerate(dots):
            self._lifts[q] = [columns[i][a] for i in range(n)]
            pairs = zip(self._lifts[q], d.velocities, strict=True)
            self._value[q] = self.stages.total([(ONE, drift[a]), *pairs])

    @property
    def rates(self) -> list[Any]:
        """qdot."""
        return [self._value[v] for v in self.definition.coordinate_velocities]

    def _row(self, condition: Any) -> dict[int, Any]:
        """The coefficients of the velocities in a condition, by a reverse sweep."""
        moving = self.structure.moving_stages
        pushed: dict[Any, list[Any]] = defaultdict(list)
        pushed[condition].append((ONE, ONE))
        if condition not in self.structure.stages.definitions and not condition.is_Symbol:
            del pushed[condition]
            for w, p in self.structure.partials(condition):
                if w in moving:
                    pushed[w].append((ONE, self.on(p)))
        for x in reversed(self.structure.order):
            if x in pushed:
                weight = self.stages.total(pushed.pop(x))
                for w, p in self.structure.partials(self.structure.expression(x)):
                    if w in moving:
                        pushed[w].append((weight, self.on(p)))
        dots = self.definition.coordinate_velocities
        row = {a: self.stages.total(pushed[v]) for a, v in enumerate(dots) if v in pushed}
        return {a: e for a, e in row.items() if e != 0}

    def _at_rest(self, expr: Any, memory: dict[Any, Any]) -> Any:
        """The value at qdot = 0."""
        for w in expr.free_symbols & self.structure.moving_stages:
            if w not in memory:
                memory[w] = self._at_rest(self.structure.expression(w), memory)
        return self.on(expr.xreplace({w: memory[w] for w in expr.free_symbols if w in memory}))

    def lift(self, x: Any) -> list[Any]:
        """The derivatives of a moving symbol by v."""
        if x not in self._lifts:
            parts = [
                (self.on(p), self.lift(w))
                for w, p in self.structure.partials(self.structure.expression(x))
                if w in self.structure.moving_stages
            ]
            self._lifts[x] = [
                self.stages.total((p, column[i]) for p, column in parts)
                for i in range(len(self.definition.velocities))
            ]
        return self._lifts[x]

    def _tangent(self, expr: Any, along: dict[Any, Any]) -> Any:
        """The time derivative of an expression, from those of coordinates and velocities."""
        terms = []
        for w, p in self.structure.partials(expr):
            if w not in along:
                inside = self.structure.stages.definitions.get(w)
                along[w] = ZERO if inside is None else self._tangent(inside, along)
            if along[w] != 0:
                terms.append((self.on(p), along[w]))
        return self.stages.total(terms)

    def _accelerate(self) -> None:
        """gamma, the part of qddot that is left at vdot = 0."""
        d = self.definition
        start = {**dict(zip(d.coordinates, self.rates, strict=True)), d.time: ONE}
        frozen = {**start, **dict.fromkeys(d.coordinate_velocities, ZERO)}
        changes = [-self._tangent(c, frozen) for c in self.structure.conditions]
        self.gamma = self._elimination.solve(changes)
        self._along = start | dict(zip(d.coordinate_velocities, self.gamma, strict=True))

    def equations(self) -> tuple[list[list[Any]], list[Any]]:
        """Mass and force, by one reverse sweep through the Lagrangian."""
        d, s = self.definition, self.structure
        n = len(d.velocities)
        slopes: dict[Any, list[Any]] = defaultdict(list)  # dL/dx
        changes: dict[Any, list[Any]] = defaultdict(list)  # d/dt dL/dx
        halves: dict[tuple[int, int], list[Any]] = defaultdict(list)
        self._push(s.lagrangian, ONE, ZERO, slopes, changes, halves)
        for x in reversed(s.order):
            if x in slopes:
                slope, change = (self.stages.total(m.pop(x, ())) for m in (slopes, changes))
                self._push(s.expression(x), slope, change, slopes, changes, halves)
        excess = [
            self.stages.name(
                self.on(force) + self.stages.total(slopes[q]) - self.stages.total(changes[v])
            )
            for force, q, v in zip(s.forces, d.coordinates, d.coordinate_velocities, strict=True)
        ]
        columns = [[self.lift(v)[i] for v in d.coordinate_velocities] for i in range(n)]
        force = [self.stages.total(zip(column, excess, strict=True)) for column in columns]
        half = {ij: self.stages.total(terms) for ij, terms in halves.items()}
        return [[half.get((max(i, j), min(i, j)), ZERO) for j in range(n)] for i in range(n)], force

    def _push(
        self, expr: Any, slope: Any, change: Any, slopes: Any, changes: Any, halves: Any
    ) -> None:
        """Hand dL/dx of a stage x, and its change, on to what x is made of; add to the mass."""
        moving = self.structure.moving_stages
        partials = self.structure.partials(expr)
        for w, p in partials:
            value = self.on(p)
            slopes[w].append((slope, value))
            if w in moving:
                changes[w] += [(change, value), (slope, self._tangent(p, self._along))]
        inner = [(w, p) for w, p in partials if w in moving]
        second = [
            (w, u, self.on(h) * (ONE if w != u else se.Rational(1, 2)))
            for k, (w, p) in enumerate(inner)
            for u, _ in inner[k:]
            if (h := p.diff(u)) != 0
        ]
        if not second or slope == 0:
            return
        n = len(self.definition.velocities)
        for i in range(n):
            for j in range(i + 1):
                halves[i, j].append((slope, self._bilinear(second, i, j)))

    def _bilinear(self, second: list[tuple[Any, Any, Any]], i: int, j: int) -> Any:
        terms = []
        for w, u, h in second:
            left, right = self.lift(w), self.lift(u)
            if w == u or i == j:
                terms.append((2 * h, left[i] * right[j]))
            else:
                terms.append((h, self.stages.name(left[i] * right[j] + left[j] * right[i])))
        return self.stages.total(terms)


def staged_form(raw: Derivation) -> FirstOrderForm:
    """The first-order form of a derivation with ``stages``; equal to ``raw.form``, much shorter.

    Raises ``EngineLimit`` where the velocities are not determined stage by stage.
    """
    d = raw.definition
    if d.group is not None:
        raise EngineLimit("systems on a group have no staged form")
    if d.added:
        raise EngineLimit("forces that hold accelerations have no staged form")
    taken = {str(s) for s in (*d.coordinates, *d.velocities, *d.parameters, d.time)}
    prefix = "z"
    while any(name.startswith(prefix) for name in taken):
        prefix += "z"
    motion = StagedMotion(StagedSystem.of(d, prefix + "_"), prefix)
    mass, force = motion.equations()
    results = [*motion.rates, *force, *(e for row in mass for e in row)]
    used = needed_stages(motion.stages.definitions, results)
    definitions = factor_sums({x: motion.stages.definitions[x] for x in used}, motion.stages.fresh)
    return FirstOrderForm(
        coordinates=d.coordinates,
        velocities=d.velocities,
        parameters=d.parameters,
        time=d.time,
        rates=tuple(motion.rates),
        mass=tuple(map(tuple, mass)),
        force=tuple(force),
        definitions=raw.definitions,
        velocity_symbols=d.coordinate_velocities,
        relations=d.relations,
        stages=tuple(definitions.items()),
        positive=d.positive,
        inputs=d.inputs,
    )
