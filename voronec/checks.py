"""Checks of a system's declaration: each raises one line that names the object and the mend."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.claims import expressions_of
from voronec.errors import DefinitionError
from voronec.reading import shown

if TYPE_CHECKING:
    from voronec.system import System

__all__ = ["check_forces", "check_frame", "check_names", "check_relations", "check_symbols"]


def check_forces(system: System) -> None:
    """Forces act on coordinates."""
    for coordinate in system.forces:
        if coordinate not in system.coordinates:
            listed = ", ".join(f"'{plain_name(q)}'" for q in system.coordinates)
            raise DefinitionError(
                f"system '{system.name}': a force is given for '{shown(coordinate)}', which is not "
                f"a coordinate; coordinates are {listed}"
            )


def check_names(system: System) -> None:
    """No name is used twice."""
    names: dict[str, str] = {}
    for thing, role in _roles(system):
        name = plain_name(thing)
        if name in names:
            raise DefinitionError(
                f"system '{system.name}': the name '{name}' is used twice "
                f"({names[name]} and {role}); rename one of them"
            )
        names[name] = role


def check_symbols(system: System) -> None:
    """Expressions are made of what is declared."""
    declared = set(system.known_symbols())
    places = [(place, expr, declared) for place, expr in _places(system)]
    claimed = declared | set(system.invariant_symbols)
    for place, expr, known in (*places, *((p, e, claimed) for p, e in _claims(system))):
        unknown = sorted(map(str, _names_in(expr) - known))
        if unknown:
            raise DefinitionError(
                f"system '{system.name}': {place} contains '{unknown[0]}', which is neither "
                "coordinate, velocity nor parameter; declare it in parameters=(...) or the "
                "fibration" + _same_name_hint(unknown[0], known)
            )


def check_relations(system: System) -> None:
    """Relations bind coordinates, not velocities."""
    dots = {velocity(q) for q in system.coordinates}
    if system.frame is not None:
        dots |= set(system.frame.velocities)
    for i, relation in enumerate(system.fibration.relations):
        names = _names_in(relation)
        place = f"system '{system.name}': relation {i + 1} ({shown(relation)} = 0)"
        moving = sorted(map(plain_name, names & dots))
        if moving:
            raise DefinitionError(
                f"{place} contains the velocity '{moving[0]}'; a relation binds coordinates only: "
                "make it a constraint"
            )
        if not names & set(system.coordinates):
            raise DefinitionError(f"{place} holds no coordinate; correct or drop it")


def check_frame(system: System) -> None:
    """Quasi-velocities are defined by velocities of coordinates, not by one another."""
    if system.frame is None:
        return
    own = set(system.frame.velocities)
    for v, expr in zip(system.frame.velocities, system.frame.expressions, strict=True):
        used = sorted(map(plain_name, _names_in(expr) & own))
        if used:
            raise DefinitionError(
                f"system '{system.name}': the definition of '{plain_name(v)}' contains the "
                f"quasi-velocity '{used[0]}'; write it with the velocities of the coordinates"
            )


def _roles(system: System) -> Iterator[tuple[sp.Expr, str]]:
    """Every name that a system declares or implies, and what it stands for."""
    for q in system.coordinates:
        yield q, "a coordinate"
    for q in system.coordinates:
        yield velocity(q), "the velocity of a coordinate"
    for v in system.frame.velocities if system.frame is not None else ():
        yield v, "a quasi-velocity"
    for p in system.parameters:
        yield p.symbol, "a parameter"
    for g in system.invariant_symbols:
        yield g, "an invariant"
    yield time, "the time"


def _places(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """Every expression of a system, and what a message calls it."""
    yield "the Lagrangian", system.lagrangian
    for i, constraint in enumerate(system.constraints):
        yield f"constraint {i + 1}", constraint
    for q, force in system.forces.items():
        yield f"the force on '{q}'", force
    if system.frame is not None:
        for v, e in zip(system.frame.velocities, system.frame.expressions, strict=True):
            yield f"the definition of '{v}'", e
    for key, e in system.invariants.items():
        yield f"invariant '{key}'", e
    for i, e in enumerate(system.fibration.relations):
        yield f"relation {i + 1}", e


def _claims(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """Every expression of a claim, in which the invariants may be used by name."""
    holders: list[tuple[str, Any]] = [("", system)]
    holders += [(f"case '{n}': ", c) for n, c in system.cases.items()]
    for place, holder in holders:
        for part in ("integrals", "equations"):
            for key, claim in getattr(holder, part).items():
                for e in expressions_of(claim):
                    yield f"{place}{part.removesuffix('s')} '{key}'", e
        if holder.measure is not None:
            for e in expressions_of(holder.measure):
                yield f"{place}the measure", e
    if system.multiplier is not None:
        yield "the multiplier", system.multiplier
    for variable in system.essential:
        yield "essential", variable


def _names_in(expr: Any) -> set[sp.Expr]:
    """The symbols, functions of time and their derivatives that occur in an expression."""
    found: set[sp.Expr] = set()
    stack = [expr]
    while stack:
        node = stack.pop()
        if is_symbolic_name(node) or _is_time_derivative(node):
            found.add(node)
        elif isinstance(node, sp.Subs):
            stack.extend(node.point)
            stack.extend(s for s in node.expr.free_symbols - set(node.variables))
        else:
            stack.extend(node.args)
    return found


def _is_time_derivative(node: Any) -> bool:
    return isinstance(node, sp.Derivative) and set(node.variables) == {time}


def _same_name_hint(name: str, known: set[sp.Expr]) -> str:
    same = any(name in (str(k), plain_name(k)) for k in known)
    return " (a different symbol of that name is declared: use one symbol object)" if same else ""
