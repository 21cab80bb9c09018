"""What was derived of a system, in a form that can be stored and compared entry by entry."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import mpmath as mp
import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import plain_name, time
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import plain_text
from voronec.declaration.system import System
from voronec.equations.curvature import curvature_of, vertical_parts
from voronec.equations.reduction import descend
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit

__all__ = ["StoredDerivation", "is_general", "random_point", "read_derivation"]


POINT_DIGITS = 90
"""How well a point lies on the relations between redundant coordinates."""


def is_general(system: System) -> bool:
    """Whether a system holds functions that nobody has given, as E(u, v); it has no numbers."""
    held = (system.lagrangian, *system.constraints, *system.forces.values())
    named = {*system.coordinates}
    return any(e.atoms(AppliedUndef) - named for e in map(as_expression, held))


def random_point(system: System, seed: int = 0) -> dict[Any, Any]:
    """Coordinates, velocities and the time; parameters near their defaults, with their signs.

    Everything is rational but for redundant coordinates, which Newton's steps bring onto their
    relations.
    """
    source = random.Random(f"{system.name} {seed}")
    state = {s: _number(source) for s in (*system.coordinates, *system.velocities, time)}
    scaled = {}
    for parameter in system.parameters:
        value = 1 if parameter.value is None else parameter.value
        scaled[parameter.symbol] = value * (1 + abs(_number(source)) / 4)
    return _on_relations(system, scaled | state)


def _number(source: random.Random) -> sp.Rational:
    return sp.Rational(source.choice((-1, 1)) * source.randint(200, 1500), 1009)


def _on_relations(system: System, point: Mapping[Any, Any]) -> dict[Any, Any]:
    names, relations = system.coordinates, sp.Matrix(system.fibration.relations)
    moved = dict(point)
    if not relations:
        return moved
    with mp.workdps(POINT_DIGITS):
        for _ in range(12):
            at = {k: sp.N(v, POINT_DIGITS) for k, v in moved.items()}
            slope = relations.jacobian(names).xreplace(at).evalf(POINT_DIGITS)
            residual = relations.xreplace(at).evalf(POINT_DIGITS)
            step = slope.T * (slope * slope.T).LUsolve(residual)
            moved |= {n: at[n] - d for n, d in zip(names, step, strict=True)}
    return moved


FORMAT = 1
LONGEST = 20_000
"""A group of entries with more characters is not stored; the values at points stand for it."""
POINTS = 2
UNASKED = "not computed"
DIGITS = 30
FACTS = ("base", "fibre", "velocities", "parameters", "relations", "kind", "growth", "integrable")

Groups = Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class StoredDerivation:
    """A derivation: ``facts`` on the system, ``groups`` of entries as text, values at ``points``.

    An entry that a group does not list is zero.  A group that is missing was too long, or beyond
    the budget of the exact algebra.  A group on the invariants names them by itself.  ``points``
    are pairs of a point and the accelerations there; ``positive`` is declared to be so.
    """

    name: str
    facts: Mapping[str, Any]
    groups: Groups
    ideals: Mapping[str, list[str]]
    points: tuple[tuple[Mapping[str, str], Mapping[str, str]], ...] = ()
    positive: tuple[str, ...] = ()
    equations: VoronecEquations | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(cls, eqs: VoronecEquations) -> StoredDerivation:
        """Everything that is compared, of a system as it is derived now."""
        relations = [plain_text(r) for r in eqs.system.fibration.relations]
        groups, ideals = _groups(eqs), {"": relations}
        reduced, rules = _reduced_equations(eqs)
        return cls(
            eqs.system.name,
            _facts(eqs) | {"relations": relations},
            groups | reduced,
            ideals | rules,
            tuple(_points(eqs)),
            tuple(dict.fromkeys(_positive(eqs.system))),
            eqs,
        )

    def compact(self) -> StoredDerivation:
        """The compact form: without groups that are too long."""
        short = {k: g for k, g in self.groups.items() if sum(map(len, g.values())) <= LONGEST}
        return replace(self, groups=short)

    def as_dict(self) -> dict[str, Any]:
        """What a file holds."""
        return {
            "format": FORMAT,
            "system": self.name,
            **self.facts,
            "groups": {k: dict(g) for k, g in self.groups.items()},
            "ideals": dict(self.ideals),
            "positive": [*self.positive],
            "points": [{"at": dict(at), "acceleration": dict(a)} for at, a in self.points],
        }

    def text(self) -> str:
        """The compact form as JSON, the same for the same derivation."""
        return json.dumps(self.compact().as_dict(), indent=1, ensure_ascii=False) + "\n"

    @classmethod
    def from_dict(cls, data: Any, place: str) -> StoredDerivation:
        """Read what ``as_dict`` made; ``DefinitionError`` where it is something else."""
        try:
            if data["format"] != FORMAT:
                raise DefinitionError(
                    f"{place} has the format {data['format']}, not {FORMAT}; store it again"
                )
            points = tuple((p["at"], p["acceleration"]) for p in data["points"])
            facts = {fact: data[fact] for fact in FACTS}
            groups = {k: dict(g) for k, g in data["groups"].items()}
            positive = tuple(data.get("positive", ()))  # older files say nothing of signs
            return cls(data["system"], facts, groups, dict(data["ideals"]), points, positive)
        except (KeyError, TypeError, ValueError, AttributeError):
            raise DefinitionError(
                f"{place} holds no derivation; make one by: voronec derive NAME --store FILE.json"
            ) from None


def _positive(system: System) -> Iterator[str]:
    """What is declared to be positive, in names of parameters."""
    own = {p.symbol: sp.Symbol(p.name) for p in system.parameters}
    yield from (p.name for p in system.parameters if p.is_positive)
    for condition in system.conditions:
        for part in condition.args if isinstance(condition, sp.And) else (condition,):
            if isinstance(part, sp.StrictGreaterThan | sp.StrictLessThan):
                yield plain_text((part.gts - part.lts).xreplace(own))


def read_derivation(path: str | Path) -> StoredDerivation:
    """The derivation that a file holds."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise DefinitionError(f"'{path}' cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise DefinitionError(f"'{path}' is not JSON: {error}") from None
    return StoredDerivation.from_dict(data, f"'{path}'")


def _facts(eqs: VoronecEquations) -> dict[str, Any]:
    """Brackets of fields that hold unknown functions grow beyond use: no growth vector then."""
    system, general = eqs.system, is_general(eqs.system)
    return {
        "base": _names(system.fibration.base),
        "fibre": _names(system.fibration.fibre),
        "velocities": _names(system.velocities),
        "parameters": [p.name for p in system.parameters],
        "kind": _within(lambda: eqs.kind),
        "growth": UNASKED if general else _within(lambda: [int(n) for n in eqs.growth]),
        "integrable": UNASKED if general else _within(lambda: [i + 1 for i in eqs.integrable]),
    }


def _within(make: Callable[[], Any]) -> Any:
    """A fact; ``undecided`` where it is beyond the budget."""
    try:
        return make()
    except EngineLimit:
        return "undecided"


def _names(symbols: Iterable[Any]) -> list[str]:
    return [plain_name(s) for s in symbols]


def _groups(eqs: VoronecEquations) -> dict[str, dict[str, str]]:
    """Rates, mass, force and curvature, where they have an exact normal form."""
    if not eqs.in_normal_form:
        return {}
    v = _names(eqs.velocities)
    found = {
        "rates": _nonzero(zip(_names(eqs.coordinates), eqs.rates, strict=True)),
        "mass": _symmetric(v, eqs.mass),
        "force": _nonzero(zip(v, eqs.force, strict=True)),
    }
    if eqs.has_coordinate_frame:
        try:
            parts = vertical_parts(eqs.exact)
        except EngineLimit:
            return found
        found["curvature"] = _curvature(eqs, parts)
    return found


def _curvature(eqs: VoronecEquations, parts: Any) -> dict[str, str]:
    a = curvature_of(parts, eqs.definition, eqs.door.outward)
    base, fibre = (_names(part) for part in (eqs.system.fibration.base, eqs.system.fibration.fibre))
    pairs = [(i, j) for i in range(len(base)) for j in range(len(base)) if i < j]
    entries = [
        (f"{name}[{base[i]},{base[j]}]", a[nu, i, j])
        for nu, name in enumerate(fibre)
        for i, j in pairs
    ]
    entries += [
        (f"{name}[{base[i]}]", a.time[nu, i])
        for nu, name in enumerate(fibre)
        for i in range(len(base))
    ]
    return _nonzero(entries)


def _reduced_equations(
    eqs: VoronecEquations,
) -> tuple[dict[str, dict[str, str]], dict[str, list[str]]]:
    """The equations in the invariants, and the relations among these."""
    if not eqs.system.invariants:
        return {}, {}
    try:
        found = descend(eqs)
    except (DefinitionError, EngineLimit):
        return {}, {}
    v = _names(eqs.velocities)
    groups = {
        "reduced rates": _nonzero(zip(map(str, found.invariants), found.rates, strict=True)),
        "reduced mass": _symmetric(v, found.mass),
        "reduced force": _nonzero(zip(v, found.force, strict=True)),
    }
    return groups, {"reduced": [plain_text(r) for r in found.relations]}


def _symmetric(names: list[str], matrix: Any) -> dict[str, str]:
    size = range(len(names))
    return _nonzero((f"{names[i]},{names[j]}", matrix[i, j]) for i in size for j in size if i <= j)


def _nonzero(pairs: Iterable[tuple[str, Any]]) -> dict[str, str]:
    return {name: plain_text(e) for name, e in pairs if e != 0}


def _points(eqs: VoronecEquations) -> Iterable[tuple[dict[str, str], dict[str, str]]]:
    """The accelerations at a few points where there are some."""
    for seed in range(0 if is_general(eqs.system) else POINTS):
        point = random_point(eqs.system, seed)
        try:
            found = eqs.acceleration(point, digits=DIGITS)
        except (DefinitionError, EngineLimit):
            continue
        at = {plain_name(k): _digits(x) for k, x in point.items() if _is_name(k)}
        yield at, {plain_name(q): str(a) for q, a in found.items()}


def _is_name(thing: Any) -> bool:
    try:
        return bool(plain_name(thing))
    except DefinitionError:
        return False


def _digits(value: Any) -> str:
    number = as_expression(value)
    return str(number) if number.is_Rational else str(sp.N(number, 60))
