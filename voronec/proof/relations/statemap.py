"""A relation read: the map of states and parameters between two vector fields, in the engine's
symbols."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.angles import Angles, holds_angles
from voronec.algebra.conditions import substituted_conditions
from voronec.algebra.points import is_possible
from voronec.algebra.symbols import plain_name, time
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import decide_zero
from voronec.declaration.relation import Relation
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.errors import DefinitionError, did_you_mean
from voronec.proof.relations.functions import Functions
from voronec.proof.relations.parameters import by_name, read_parameters, refuse_unknown

NONE: Mapping[str, Any] = MappingProxyType({})


def is_period(entries: Sequence[Any], relations: Sequence[Any], x: Any, jump: Any) -> bool:
    """Whether equations and relations are the same where a position is moved by a constant.

    One that nothing depends on may be an angle, or a length: whole turns alone are taken for a
    period of it.
    """
    held = [e for e in (*entries, *relations) if x in e.free_symbols]
    if not held:
        return isinstance(jump / (2 * se.pi), se.Integer)
    moved = (e.xreplace({x: x + jump}) - e for e in held)
    return all(decide_zero(e, relations).proved for e in moved)


@dataclass(frozen=True)
class StateMap:
    """Phi and what comes with it: target variables and parameters in terms of the source.

    ``state`` has an entry for every variable of the target field, ``time`` among them;
    ``scaling`` takes parameters of the source to functions of the small one.
    """

    relation: Relation
    source: VectorField
    target: VectorField
    state: dict[Any, Any]
    parameters: dict[Any, Any]
    clock: Any
    small: Any
    scaling: dict[Any, Any]

    @classmethod
    def of(cls, relation: Relation, motions: Callable[[str], Motions], level: str = "") -> StateMap:
        """Read a relation; ``motions`` gives the motions of a system by its name.

        ``level`` is the one on which a relation without a state is wanted.
        Raises ``DefinitionError`` where a variable or a parameter of the target is unmapped, or
        where something is mapped that the target does not have.
        """
        start, end = motions(relation.source), motions(relation.target)
        given = by_name(relation.state or {})
        shared = level and {*_variables(end.system, level)} <= {*_variables(start.system, level)}
        if relation.state is not None or not shared:
            level = _target_level(relation, start.system, end.system)
        target = end.at(level)
        if relation.state is None:
            given = {str(x): _symbol(start.system, str(x)) for x in target.variables}
        exprs = [*given.values(), relation.clock]
        low = start.holds_coordinate(exprs) or not start.system.invariants
        source = start.on_coordinates if low else start.on_invariants
        reader = _Reader(relation, source)
        state = _state(relation, reader, target, given)
        return cls(
            relation=relation,
            source=source,
            target=target,
            state=state,
            parameters=read_parameters(relation, reader, target),
            clock=reader.read(relation.clock, "the clock"),
            small=reader.small,
            scaling=reader.scaled_parameters,
        )

    @cached_property
    def _functions(self) -> Functions:
        return Functions(self.parameters)

    def pull_back(self, expr: Any) -> Any:
        """A function of the target's state, as one of the source's.

        Raises ``EngineLimit`` where it is infinite on the image.
        """
        mapping = {**self.state, **self._functions.plain}
        return self._resolve(self._functions.replace(expr, mapping))

    def scale(self, expr: Any) -> Any:
        """A function of the source's state with its parameters as functions of the small one."""
        return expr.xreplace(self.scaling) if self.scaling else expr

    def derivative(self, function: Any) -> Any:
        """d/dt along the motion of the source."""
        return self._resolve(self.scale(self.source.derivative(function)))

    @cached_property
    def scaled_source(self) -> VectorField:
        """The field of the source, its parameters as functions of the small one."""
        source = self.source
        if not self.scaling:
            return source
        return replace(
            source,
            rates=tuple(map(self.scale, source.rates)),
            mass=tuple(tuple(map(self.scale, row)) for row in source.mass),
            force=tuple(map(self.scale, source.force)),
            relations=self.relations,
        )

    @cached_property
    def _angles(self) -> Angles | None:
        """What is known of the angles that the map gives by their tangents, where it does."""
        return Angles(self.relations) if holds_angles(self.state.values()) else None

    def _resolve(self, expr: Any) -> Any:
        return expr if self._angles is None else self._angles.resolve(expr)

    @property
    def relations(self) -> tuple[Any, ...]:
        """What vanishes on the states of the source."""
        return tuple(self.scale(r) for r in self.source.relations)

    @property
    def source_conditions(self) -> tuple[Any, ...]:
        """What is known of the parameters of the source."""
        return substituted_conditions(self.source.conditions, self.scaling)

    @cached_property
    def hypotheses(self) -> tuple[Any, ...]:
        """What vanishes on the states of the source, and what is known of its parameters and of
        the images of the target's."""
        conditions = self.source_conditions
        images = {**self.state, **{p: v for p, v in self.parameters.items() if p.is_Symbol}}
        mapped = (c for c in self.target.conditions if c.free_symbols <= images.keys())
        both = (*conditions, *substituted_conditions(mapped, images))
        # a map to values that the target declares impossible is no reason to know anything
        return self.relations + (both if is_possible(both) else conditions)

    def is_period(self, x: Any, jump: Any) -> bool:
        """Whether the target is the same where a position is so moved; the time is none."""
        target = self.target
        generic = replace(self, state={y: se.Symbol(f"image of {y}") for y in self.state})
        known = [generic.pull_back(r) for r in target.relations]
        entries = [generic.pull_back(e) for e in target.entries]
        timed = x == target.time and not any(x in e.free_symbols for e in target.entries)
        return not timed and is_period(entries, known, generic.state[x], jump)

    @property
    def is_identity(self) -> bool:
        """Whether every variable goes to the one of the same name."""
        return all(x == image for x, image in self.state.items())


@dataclass(frozen=True)
class _Reader:
    """Reads expressions of a relation in the symbols of its source."""

    relation: Relation
    source: VectorField

    @property
    def small(self) -> Any:
        limit = self.relation.limit
        return None if limit is None else self.source.bridge.inward(limit.small)

    @cached_property
    def scaled_parameters(self) -> dict[Any, Any]:
        limit = self.relation.limit
        if limit is None:
            return {}
        symbols = {p.name: p.symbol for p in self.source.system.parameters}
        scaled = {}
        for key, value in by_name(limit.parameters).items():
            if key not in symbols:
                raise DefinitionError(
                    f"relation '{self.relation.label}': the limit scales '{key}', which is no "
                    f"parameter of '{self.source.system.name}'" + did_you_mean(key, symbols)
                )
            scaled[self.source.bridge.inward(symbols[key])] = self.source.bridge.inward(value)
        return scaled

    def read(self, expr: sp.Expr, place: str, formals: Mapping[str, Any] = NONE) -> Any:
        """An expression in the engine's symbols; ``formals`` are put in for symbols of these
        names."""
        known = {*self.source.system.known_symbols(), *self.source.system.invariant_symbols}
        if self.relation.limit is not None:
            known.add(self.relation.limit.small)
        names = {*map(plain_name, known), *formals}
        for symbol in as_expression(expr).free_symbols:
            if str(symbol) not in names:
                raise DefinitionError(
                    f"relation '{self.relation.label}': {place} holds '{symbol}', which "
                    f"'{self.source.system.name}' does not have" + did_you_mean(str(symbol), names)
                )
        inside = self.source.bridge.inward(expr)
        if formals:
            inside = inside.xreplace({se.Symbol(name): slot for name, slot in formals.items()})
        return self.source.express(inside).xreplace(self.scaled_parameters)


def _symbol(system: System, name: str) -> sp.Expr:
    """The symbol of a state variable of a system, by its name."""
    known = {plain_name(s): s for s in (*system.known_symbols(), *system.invariant_symbols)}
    return known[name]


def _variables(system: System, level: str) -> list[str]:
    positions = system.invariant_symbols if level == "invariants" else system.coordinates
    return [plain_name(x) for x in (*positions, *system.velocities)]


def _target_level(relation: Relation, source: System, target: System) -> str:
    """The level of the target whose variables the relation maps."""
    levels = (["invariants"] if target.invariants else []) + ["coordinates"]
    if relation.state is None:
        for level in levels:
            available = (
                _variables(source, level) if level == "coordinates" or source.invariants else []
            )
            if set(_variables(target, level)) <= set(available):
                return level
        raise DefinitionError(
            f"relation '{relation.label}' gives no state, and the variables of '{target.name}' "
            f"are not those of '{source.name}'; write state={{variable: expression}}"
        )
    given = set(by_name(relation.state)) - {plain_name(time)}
    for level in levels:
        positions = {plain_name(x) for x in target.coordinates}
        if level == "invariants":
            positions = {str(g) for g in target.invariant_symbols}
        if positions <= given:
            return level
    missing = [x for x in _variables(target, levels[0]) if x not in given]
    raise DefinitionError(
        f"relation '{relation.label}' leaves {', '.join(repr(x) for x in missing)} of "
        f"'{target.name}' unmapped; add to state="
    )


def _state(
    relation: Relation, reader: _Reader, target: VectorField, given: Mapping[str, Any]
) -> dict[Any, Any]:
    """Every variable of the target; velocities that are not given follow from the positions."""
    known = [*map(str, target.variables), str(target.time)]
    refuse_unknown(relation, "state", given, known, target.system.name)
    state = {x: reader.read(given[str(x)], f"'{x}'") for x in target.variables if str(x) in given}
    state[target.time] = reader.read(given.get(str(target.time), time), "the time")
    missing = [v for v in target.velocities if v not in state]
    if missing and target.level == "invariants":
        raise DefinitionError(
            f"relation '{relation.label}' leaves {', '.join(repr(str(v)) for v in missing)} of "
            f"'{target.system.name}' unmapped; add to state="
        )
    return state
