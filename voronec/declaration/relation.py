"""Relations between systems, and squares of them: declarations only.

A relation is one statement: a map Phi of states and a clock nu such that

    DPhi(x) f(x) = nu(x) g(Phi(x)),

with f the motion of the source and g that of the target, exactly or up to a power of a small
parameter.  What kind it is, follows from the maps.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import sympy as sp
from sympy.core.symbol import uniquely_named_symbol

from voronec.algebra.arguments import TEXT, require, takes_fields
from voronec.algebra.symbols import plain_name, time
from voronec.declaration.reading import expression, fixed_mapping, quote, several
from voronec.errors import DefinitionError, did_you_mean


@takes_fields
@dataclass(frozen=True)
class Limit:
    """A parameter that tends to zero: ``parameters`` of the source are functions of it.

    The relation holds up to terms of ``order`` in it.  At zero the clock must run and the target
    must be determined, and what is expanded must be smooth there.
    """

    small: sp.Symbol
    parameters: Mapping[Any, Any]
    order: int = 1

    def __post_init__(self) -> None:
        values = fixed_mapping(self.parameters, "parameters of a limit", "parameter: expression")
        object.__setattr__(self, "parameters", values)
        if not isinstance(self.order, int) or self.order < 1:
            raise DefinitionError(
                f"the order of a limit is {quote(self.order)}; give an integer from 1 upward"
            )


@takes_fields
@dataclass(frozen=True)
class Relation:
    """Motions of ``source`` are, through ``state``, motions of ``target``.

    source, target
        names of systems; the relation stands in the file of one of them.
    state
        each state variable of the target (coordinates and velocities, or invariants and
        velocities) as a function of the state, the parameters and the time of the source; by
        symbol or name.  Without it, variables of the same names are the same.
    parameters
        each parameter of the target as a function of parameters of the source, or of what is
        constant along its motions; an unknown function of the target by its arguments there, or,
        where it is taken of several, as ``{f(s): value in s}``.
    clock
        nu; the time of the target runs with the rate nu.
    limit
        ``Limit`` where the relation holds as a parameter tends to zero.
    name
        tells relations between the same two systems apart.
    """

    source: str
    target: str
    state: Mapping[Any, Any] | None = None
    parameters: Mapping[Any, Any] = field(default_factory=dict)
    clock: Any = sp.Integer(1)
    limit: Limit | None = None
    name: str = ""
    note: str = ""

    def __post_init__(self) -> None:
        for name in ("source", "target", "name", "note"):
            require("a relation", name, getattr(self, name), TEXT)
        place = f"relation '{self.label}'"
        object.__setattr__(self, "clock", expression(self.clock, f"{place}: the clock"))
        for part, entry in (("state", "variable: expression"), ("parameters", "parameter: value")):
            given = getattr(self, part)
            if given is not None:
                values = fixed_mapping(given, f"{place}: {part}", entry)
                read = {k: expression(v, f"{place}: '{quote(k)}'") for k, v in values.items()}
                object.__setattr__(self, part, fixed_mapping(read, part, entry))

    @classmethod
    def of(
        cls,
        system: Any,
        target: str,
        changed: Mapping[Any, Any] | None = None,
        *,
        vanish: Any = (),
        grow: Any = (),
        **more: Any,
    ) -> Relation:
        """A relation from a ``System``; its parameters keep their names, but for those ``changed``.

        ``changed`` gives parameters of the target; a parameter of the system that occurs in one of
        these, or that moves in the ``limit``, does not go over by its own name.  ``vanish`` and
        ``grow`` name what moves in the usual limits, one parameter p or several: to zero as h p,
        to infinity as 1/h.  ``DefinitionError`` where one is no parameter, or moves otherwise too.
        """
        if vanish or grow:
            more["limit"] = _usual_limit(system, vanish, grow, more.get("limit"))
        given = {quote(name): value for name, value in (changed or {}).items()}
        values = [expression(v, f"a parameter of '{target}'") for v in given.values()]
        used = set().union(*(value.free_symbols for value in values))
        limit = more.get("limit")
        moved = set(map(str, limit.parameters)) if limit is not None else set()
        resting = [p for p in system.parameters if p.symbol not in used and p.name not in moved]
        kept = {p.name: p.symbol for p in resting if p.name not in given}
        return cls(system.name, target, parameters={**kept, **(changed or {})}, **more)

    @classmethod
    def into(cls, system: Any, source: str, changed: Mapping[Any, Any], **more: Any) -> Relation:
        """A relation to a ``System``, which may be the source too; what is not ``changed`` is kept.

        ``changed`` gives variables, parameters and unknown functions of the system by what they are
        in the source; others are what bears their names there.  Where no coordinate is given, the
        state is that of the invariants; on coordinates velocities follow where none is given.
        """
        given = {plain_name(name): value for name, value in changed.items()}
        places, rates = system.coordinates, system.velocities
        if system.invariants and given.keys().isdisjoint(map(plain_name, places)):
            places = system.invariant_symbols
        elif given.keys().isdisjoint(map(plain_name, rates)):
            rates = ()
        kept = {plain_name(x): x for x in (*places, *rates)}
        state = {name: value for name, value in given.items() if name in {*kept, plain_name(time)}}
        parameters = {p.name: given.get(p.name, p.symbol) for p in system.parameters}
        used = {*state, *parameters}
        rest = {name: value for name, value in changed.items() if plain_name(name) not in used}
        mapped = {**kept, **state} if state else None
        return cls(source, system.name, mapped, {**parameters, **rest}, **more)

    @property
    def label(self) -> str:
        """What the relation is called in tables and in squares."""
        return self.name or f"{self.source} -> {self.target}"

    @property
    def line(self) -> str:
        """Of what kind it is by its declaration alone, as pictures draw it."""
        if self.limit is not None:
            return "limit"
        if self.clock != 1:
            return "change of time"
        same = all(str(k) == str(v) for k, v in (self.state or {}).items())
        return "specialisation" if same else "change of coordinates"


def _usual_limit(system: Any, vanish: Any, grow: Any, limit: Any) -> Limit:
    """The limit in which parameters of a system ``vanish`` as h p and ``grow`` as 1/h."""
    zero, far = several(vanish, "vanish", "parameter"), several(grow, "grow", "parameter")
    moved, symbols = [str(p) for p in (*zero, *far)], {p.name: p.symbol for p in system.parameters}
    for name in moved:
        if name not in symbols:
            raise DefinitionError(
                f"'{quote(name)}' vanishes or grows, but is no parameter of '{system.name}'"
                + did_you_mean(name, symbols)
            )
    if limit is not None or len({*moved}) < len(moved):
        raise DefinitionError(
            f"'{moved[-1]}' moves in two ways; name it once in vanish= or grow=, or give limit="
        )
    small = uniquely_named_symbol("h", (*system.known_symbols(), *system.invariant_symbols))
    values = [small * symbols[name] for name in moved[: len(zero)]] + [1 / small] * len(far)
    return Limit(small, dict(zip((symbols[name] for name in moved), values, strict=True)))


@takes_fields
@dataclass(frozen=True)
class Square:
    """Two chains of relations, given by their labels, from one system to another, that agree.

    ``up_to`` is the label of a relation of the last system with itself, an automorphism, that
    takes the end of the first chain to that of the second.  Where limits occur, those of a chain
    are carried back to the parameters of its start and taken in its order; the chains agree in the
    limits of both.  A chain that fixes a parameter which its limit moves has no meaning.
    """

    first: tuple[str, ...]
    second: tuple[str, ...]
    up_to: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        for part in ("first", "second"):
            object.__setattr__(self, part, several(getattr(self, part), part, "'label'"))
        for label in (self.name, self.up_to, *self.first, *self.second):
            require("a square", "a label", label, TEXT)

    @classmethod
    def through(
        cls, first: Sequence[str], second: Sequence[str], name: str = "", up_to: str = ""
    ) -> Square:
        """Two chains by the systems that they pass, each from one to the next."""
        chains = [
            tuple(f"{a} -> {b}" for a, b in itertools.pairwise(chain)) for chain in (first, second)
        ]
        return cls(chains[0], chains[1], up_to, name)

    @property
    def label(self) -> str:
        """What the square is called in tables."""
        return self.name or f"{', '.join(self.first)} = {', '.join(self.second) or 'identity'}"
