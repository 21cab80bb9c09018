"""Checks of a system's declaration: each raises one line that names the object and the mend."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import sympy as sp
from sympy.logic.boolalg import Boolean

from voronec.algebra.symbols import names_in, plain_name, time, velocity
from voronec.algebra.text import sympified
from voronec.declaration.claims import (
    THEOREMS,
    Corrected,
    Measure,
    claim_names,
    expressions_of,
    right_of,
)
from voronec.declaration.reading import require_known, shown
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.declaration.geometry import Frame
    from voronec.declaration.system import System

__all__ = [
    "check_charts",
    "check_claims",
    "check_forces",
    "check_frame",
    "check_names",
    "check_possible",
    "check_relations",
    "check_symbols",
    "require_possible",
]


LONGEST_NAME = 100
"""How long a name may be."""


def check_possible(system: System) -> None:
    """Conditions on the parameters are relations among them, and of nothing else."""
    symbols = {p.symbol for p in system.parameters}
    for words, condition in system.possible.items():
        stray = getattr(condition, "free_symbols", symbols) - symbols
        if not isinstance(condition, Boolean) or condition.is_Symbol or stray:
            raise DefinitionError(
                f"system '{system.name}': the condition '{words}' is '{shown(condition)}', which "
                "is no relation of the system's parameters; write one such as 2*A > m*R**2"
            )


def require_possible(system: System, given: Mapping[str, Any]) -> None:
    """Refuse parameters, by name, that no body can have, decided with the exact values."""
    values = {p.symbol: given.get(p.name, p.value) for p in system.parameters}
    exact = {s: sp.Rational(x) if isinstance(x, float) else x for s, x in values.items()}
    known = {s: sympified(x) for s, x in exact.items() if x is not None}
    for words, condition in system.possible.items():
        if condition.xreplace(known) is sp.false:
            involved = [p.symbol for p in system.parameters if condition.has(p.symbol)]
            held = ", ".join(f"{s} = {values[s]}" for s in involved)
            raise DefinitionError(f"system '{system.name}': {words}; not so with {held}")


def check_forces(system: System) -> None:
    """Forces act on coordinates; on a group along the fields of its frame."""
    one, all_of = "a coordinate", "coordinates"
    if system.on_group:
        one, all_of = "a velocity of the frame", "these"
    for coordinate in system.forces:
        if coordinate not in system.directions:
            listed = ", ".join(f"'{plain_name(q)}'" for q in system.directions)
            raise DefinitionError(
                f"system '{system.name}': a force is given for '{shown(coordinate)}', which is not "
                f"{one}; {all_of} are {listed}"
            )


def check_names(system: System) -> None:
    """No name is used twice."""
    names: dict[str, str] = {}
    for thing, role in _roles(system):
        name = plain_name(thing)
        _require_name(system, name, role)
        if name in names:
            raise DefinitionError(
                f"system '{system.name}': the name '{name}' is used twice "
                f"({names[name]} and {role}); rename one of them"
            )
        names[name] = role
    _require_name(system, system.name, "the system")
    for title in ("integrals", "invariants", "equations", "cases", "scenes", "charts", "possible"):
        for words in getattr(system, title):
            if not isinstance(words, str) or not words.strip() or not words.isprintable():
                raise DefinitionError(
                    f"system '{shown(system.name)}': '{shown(words)}' among its {title} is no "
                    "name; give words of printable letters"
                )
    for title in ("title", "description"):
        if not isinstance(getattr(system, title), str):
            raise DefinitionError(
                f"system '{system.name}': {title} = {shown(getattr(system, title))} is no text"
            )


def _require_name(system: System, name: str, role: str) -> None:
    """Names are quoted in tables, file names and source: they are words."""
    if not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        raise DefinitionError(
            f"system '{shown(system.name)}': the name '{shown(name)}' ({role}) is no word; give "
            f"one of printable letters, {LONGEST_NAME} at most"
        )


def check_symbols(system: System) -> None:
    """Expressions are made of what is declared."""
    declared = set(system.known_symbols())
    places = [(place, expr, declared) for place, expr in _places(system)]
    claimed = declared | set(system.invariant_symbols)
    claimed |= set(system.frame.named if system.frame is not None else ())
    inputs, pushed = set(system.inputs), declared | set(system.accelerations)
    places += [(p, e, pushed) for p, e in _forces(system)]
    for place, expr, known in (*places, *((p, e, claimed) for p, e in _claims(system))):
        require_known(f"system '{system.name}': {place}", expr, known, inputs)


def check_claims(system: System) -> None:
    """Claims name what there is: variables of one level, parameters, theorems, other claims."""
    place = f"system '{system.name}'"
    for label, holder in _holders(system):
        if not isinstance(holder.integrable, str) or holder.integrable not in ("", *THEOREMS):
            raise DefinitionError(
                f"{place}: {label}integrable is '{shown(holder.integrable)}'; "
                f"known theorems: {', '.join(THEOREMS)}"
            )
        for measure in _both(holder.measure):
            _check_variables(system, measure)
    known = {*system.coordinates, *system.velocities, *system.invariant_symbols}
    for variable in system.essential:
        if variable not in known:
            raise DefinitionError(
                f"{place}: essential holds '{shown(variable)}', which is no coordinate, velocity "
                "of the equations or invariant"
            )
    names = {p.name for p in system.parameters}
    for label, case in system.cases.items():
        for key in case.parameters:
            name = plain_name(key)
            if name not in names:
                raise DefinitionError(
                    f"{place}: case '{label}' gives a value to '{name}', which is no parameter"
                )
    claimed = {*claim_names(system), *(system.motion.claims if system.motion else ())}
    for name in system.undecided:
        if name not in claimed:
            raise DefinitionError(
                f"{place}: undecided holds '{shown(name)}', which is no claim; "
                f"claims are {', '.join(sorted(claimed)) or 'none'}"
            )


def _holders(system: System) -> Iterator[tuple[str, Any]]:
    """What claims are declared in: the system, and its cases."""
    yield "", system
    for name, case in system.cases.items():
        yield f"case '{name}': ", case


def _both(measure: Any) -> Iterator[Measure]:
    """The right one and the printed one; the measure itself, if there is any."""
    if measure is not None:
        yield right_of(measure)
    if isinstance(measure, Corrected):
        yield measure.printed


def _check_variables(system: System, measure: Measure) -> None:
    given, velocities = {*measure.variables}, {*system.velocities}
    if given <= {*system.coordinates} | velocities:
        return
    if not given <= {*system.invariant_symbols} | velocities:
        raise DefinitionError(
            f"system '{system.name}': the variables of the measure are neither among coordinates "
            "and velocities of the equations nor among invariants and these velocities"
        )
    dots = {velocity(q) for q in system.coordinates} - velocities
    foreign = sorted(map(str, names_in(measure.density) & ({*system.coordinates} | dots)))
    if foreign:
        raise DefinitionError(
            f"system '{system.name}': the measure in invariants holds '{foreign[0]}'; write its "
            "density with invariants too"
        )


def check_charts(system: System) -> None:
    """Charts map variables, to functions of them and of parameters."""
    names = sorted(map(plain_name, (*system.coordinates, *system.velocities)))
    resting = {*system.coordinates, *(p.symbol for p in system.parameters)}
    for name, chart in system.charts.items():
        place = f"system '{system.name}': chart '{name}'"
        for key in {*chart.state, *chart.back}.union(*chart.twins) - {*names}:
            wrong = f"{place} maps '{key}', which is no coordinate or velocity"
            raise DefinitionError(wrong + did_you_mean(key, names))
        maps = (chart.state, chart.back, *chart.twins)
        for expr in (e for images in maps for e in images.values()):
            require_known(place, expr, {*system.known_symbols()} - {time})
        for expr in (chart.singular, chart.singular_there):
            require_known(f"{place}: singular", expr, resting)


def check_relations(system: System) -> None:
    """Relations bind coordinates, not velocities."""
    dots = {velocity(q) for q in system.coordinates}
    if system.frame is not None:
        dots |= set(system.frame.ambient)
    for i, relation in enumerate(system.fibration.relations):
        names = names_in(relation)
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
    if system.frame.is_group:
        _check_group(system, system.frame)
        return
    own = set(system.frame.velocities)
    for v, expr in zip(system.frame.velocities, system.frame.expressions, strict=True):
        used = sorted(map(plain_name, names_in(expr) & own))
        if used:
            raise DefinitionError(
                f"system '{system.name}': the definition of '{plain_name(v)}' contains the "
                f"quasi-velocity '{used[0]}'; write it with the velocities of the coordinates"
            )


def _check_group(system: System, frame: Frame) -> None:
    """The rates of a group are those of the coordinates, and its brackets are constant."""
    place = f"system '{system.name}'"
    if system.fibration.fibre:
        raise DefinitionError(
            f"{place}: with Frame.group all coordinates stand in the base; the fibre is that of "
            "the frame, Frame.group(..., fibre=(...))"
        )
    for q in system.coordinates:
        if q not in frame.rates:
            raise DefinitionError(
                f"{place}: the frame gives no rate for '{plain_name(q)}'; add it to rates={{...}}"
            )
    for q in frame.rates:
        if q not in system.coordinates:
            raise DefinitionError(
                f"{place}: the frame gives a rate for '{shown(q)}', which is not a coordinate; "
                "add it to Fibration(base=(...))"
            )
    constant = {p.symbol for p in system.parameters if isinstance(p.symbol, sp.Symbol)}
    for pair, parts in (frame.brackets or {}).items():
        for value in parts.values():
            moving = sorted(map(str, names_in(value) - constant))
            if moving:
                names = ", ".join(map(plain_name, pair))
                raise DefinitionError(
                    f"{place}: the bracket of {names} contains '{moving[0]}'; the brackets of a "
                    "group hold numbers and constant parameters only"
                )


def _roles(system: System) -> Iterator[tuple[sp.Expr, str]]:
    """Every name that a system declares or implies, and what it stands for."""
    for q in system.coordinates:
        yield q, "a coordinate"
    for q in system.coordinates:
        yield velocity(q), "the velocity of a coordinate"
    for v in system.frame.ambient if system.frame is not None else ():
        yield v, "a quasi-velocity"
    for name in system.frame.named if system.frame is not None else ():
        yield name, "a name in the frame"
    for p in system.parameters:
        yield p.symbol, "a parameter"
    constants = {p.symbol for p in system.parameters}
    for u in system.inputs:
        if u not in constants:
            yield u, "an input"
        yield velocity(u), "the rate of an input"
    for g in system.invariant_symbols:
        yield g, "an invariant"
    yield time, "the time"


def _places(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """Every expression of a system, and what a message calls it."""
    yield "the Lagrangian", system.lagrangian
    for i, constraint in enumerate(system.constraints):
        yield f"constraint {i + 1}", constraint
    if system.frame is not None:
        for v, e in zip(system.frame.velocities, system.frame.expressions, strict=True):
            yield f"the definition of '{v}'", e
        for q, e in system.frame.rates.items():
            yield f"the rate of '{q}'", e
    for key, e in system.invariants.items():
        yield f"invariant '{key}'", e
    for i, e in enumerate(system.fibration.relations):
        yield f"relation {i + 1}", e


def _forces(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """The forces, which may hold accelerations besides."""
    for q, force in system.forces.items():
        yield f"the force on '{q}'", force


def _claims(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """Every expression of a claim, in which the invariants may be used by name."""
    for place, holder in _holders(system):
        for part in ("integrals", "equations"):
            for key, claim in getattr(holder, part).items():
                for e in expressions_of(claim):
                    yield f"{place}{part.removesuffix('s')} '{key}'", e
        if holder.measure is not None:
            for e in expressions_of(holder.measure):
                yield f"{place}the measure", e
        if holder.multiplier is not None:
            yield f"{place}the multiplier", holder.multiplier
    for variable in system.essential:
        yield "essential", variable
    if system.poisson is not None:
        own = {*system.poisson.variables}
        for e in expressions_of(system.poisson):
            yield "poisson", e.xreplace(dict.fromkeys(own, sp.Integer(1)))
