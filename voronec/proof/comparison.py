"""Two derivations side by side: two systems, or a stored one and today's.

What was derived of a system is stored in a form that can be compared entry by entry: its equations,
and facts on them.  Two systems at hand are compared by a motion too, and by accelerations at points
where they have no exact equations.
"""

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

from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.text import as_expression, read_sympy_text
from voronec.algebra.typeset import html_table, plain_text
from voronec.algebra.verdicts import prove_equal
from voronec.declaration.reading import quote
from voronec.declaration.system import System
from voronec.equations.curvature import curvature_of, vertical_parts
from voronec.equations.reduction import descend
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, VoronecError, file_errors

POINT_DIGITS = 90
"""How well a point lies on the relations between redundant coordinates."""


def is_general(system: System) -> bool:
    """Whether a system holds functions that nobody has given, as E(u, v); it has no numbers."""
    held = (system.lagrangian, *system.constraints, *system.forces.values())
    named = {*system.coordinates}
    return any(e.atoms(AppliedUndef) - named for e in map(as_expression, held))


def random_point(system: System, seed: int = 0) -> dict[Any, Any]:
    """Coordinates, velocities, the time, inputs and their rates; parameters near their defaults,
    with their signs.

    Everything is rational but for redundant coordinates, which Newton's steps bring onto their
    relations.
    """
    source = random.Random(f"{system.name} {seed}")
    signals = [s for u in system.inputs for s in (u, velocity(u))]
    free = (*system.coordinates, *system.velocities, time, *signals)
    state = {s: _number(source) for s in free}
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
"""Of stored derivations; another one is not read."""
LONGEST = 20_000
"""A group of entries with more characters is not stored."""
POINTS = 2
"""At which equations without exact entries are compared: one may be special, two are not."""
ABSENT = "not computed"
DIGITS = 30
"""Of these values: twice a double's, so that rounding is told from a difference."""
SETS = ("parameters", "inputs")
"""Facts that are the same in any order."""
FACTS = ("base", "fibre", "velocities", "parameters", "relations", "kind", "growth", "integrable")

Groups = Mapping[str, Mapping[str, str]]
_NAMES, _TEXTS = [str], {str: str}
_SHAPE = {
    "format": int, "system": str, "base": _NAMES, "fibre": _NAMES, "velocities": _NAMES,
    "parameters": _NAMES, "relations": _NAMES, "inputs": _NAMES, "kind": str,
    "positive": (type(None), _NAMES), "growth": (str, [int]), "integrable": (str, [str]),
    "ideals": {str: _NAMES}, "groups": {str: _TEXTS},
}  # fmt: skip
"""What a file holds: types, lists of one kind, mappings by given keys or, where ``str`` stands for
them, by any; what may be several things is a tuple of them."""


@dataclass(frozen=True)
class StoredDerivation:
    """A derivation: ``facts`` on the system, and its equations, ``groups`` of entries as text.

    An entry that a group does not list is zero.  A group that is missing was too long, or beyond
    the budget of the exact algebra.  A group on the invariants names them by itself.  ``positive``
    is declared to be so, None where a file says nothing of signs.
    """

    name: str
    facts: Mapping[str, Any]
    groups: Groups
    ideals: Mapping[str, list[str]]
    positive: tuple[str, ...] | None = ()
    equations: VoronecEquations | None = field(default=None, repr=False, compare=False)

    @classmethod
    def of(cls, eqs: VoronecEquations) -> StoredDerivation:
        """Everything that is compared, of a system as it is derived now."""
        relations = [plain_text(r) for r in eqs.system.fibration.relations]
        groups, ideals = _entry_groups(eqs), {"": relations}
        reduced, rules = _reduced_equations(eqs)
        return cls(
            eqs.system.name,
            _plain_facts(eqs) | {"relations": relations},
            groups | reduced,
            ideals | rules,
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
            # systems without inputs are stored as they were before there were any
            **{k: fact for k, fact in self.facts.items() if fact or k != "inputs"},
            "groups": {k: dict(g) for k, g in self.groups.items()},
            "ideals": dict(self.ideals),
            "positive": [*(self.positive or ())],
        }

    def text(self) -> str:
        """The compact form as JSON, the same for the same derivation."""
        return json.dumps(self.compact().as_dict(), indent=1, ensure_ascii=False) + "\n"

    @classmethod
    def from_dict(cls, data: Any, place: str) -> StoredDerivation:
        """Read what ``as_dict`` made; ``DefinitionError`` where it is something else."""
        if isinstance(data, dict):  # older files say nothing of inputs and signs
            data = {"format": FORMAT, "inputs": [], "positive": None, **data}
            if data["format"] != FORMAT:
                told = f"has the format {quote(data['format'])}, not {FORMAT}"
                raise DefinitionError(f"{place} {told}; store it again")
        if not _has_shape(data, _SHAPE):
            raise DefinitionError(
                f"{place} holds no derivation; make one by: voronec derive NAME --store FILE.json"
            )
        facts = {fact: data[fact] for fact in (*FACTS, "inputs")}
        signs = None if data["positive"] is None else tuple(data["positive"])
        return cls(data["system"], facts, data["groups"], data["ideals"], signs)


def _has_shape(data: Any, shape: Any) -> bool:
    """Whether what JSON holds has a shape, as ``_SHAPE`` says it."""
    if isinstance(shape, tuple):
        return any(_has_shape(data, one) for one in shape)
    if isinstance(shape, list):
        return isinstance(data, list) and all(_has_shape(x, shape[0]) for x in data)
    if not isinstance(shape, dict) or not isinstance(data, dict):
        return type(data) is shape
    wanted = dict.fromkeys(data, shape[str]) if str in shape else shape
    return all(k in data and _has_shape(data[k], one) for k, one in wanted.items())


def _positive(system: System) -> Iterator[str]:
    """What is declared to be positive, in names of parameters."""
    named = {p.symbol: sp.Symbol(p.name) for p in system.parameters}
    yield from (p.name for p in system.parameters if p.is_positive)
    for condition in system.conditions:
        for part in condition.args if isinstance(condition, sp.And) else (condition,):
            if isinstance(part, sp.StrictGreaterThan | sp.StrictLessThan):
                yield plain_text((part.gts - part.lts).xreplace(named))


def read_derivation(path: str | Path) -> StoredDerivation:
    """The derivation that a file holds."""
    try:
        with file_errors(Path(path), "a stored derivation"):
            data = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise DefinitionError(f"'{path}' is not JSON: {error}") from None
    return StoredDerivation.from_dict(data, f"'{path}'")


def _plain_facts(eqs: VoronecEquations) -> dict[str, Any]:
    """Brackets of fields that hold unknown functions grow beyond use: no growth vector then."""
    system, general = eqs.system, is_general(eqs.system)
    return {
        "base": _names(system.fibration.base),
        "fibre": _names(system.fibration.fibre),
        "velocities": _names(system.velocities),
        "parameters": [*system.parameter_names],
        "inputs": _names(system.inputs),
        "kind": _within(lambda: eqs.kind),
        "growth": ABSENT if general else _within(lambda: [int(n) for n in eqs.growth]),
        "integrable": ABSENT if general else _within(lambda: [*map(plain_text, eqs.integrable)]),
    }


def _within(make: Callable[[], Any]) -> Any:
    """A fact; ``undecided`` where it is beyond the budget."""
    try:
        return make()
    except EngineLimit:
        return "undecided"


def _names(symbols: Iterable[Any]) -> list[str]:
    return [plain_name(s) for s in symbols]


def _entry_groups(eqs: VoronecEquations) -> dict[str, dict[str, str]]:
    """Rates, mass, force and curvature, where they have an exact normal form."""
    if not eqs.in_normal_form:
        return {}
    v = _names(eqs.velocities)
    groups = {
        "rates": _nonzero(zip(_names(eqs.coordinates), eqs.rates, strict=True)),
        "mass": _symmetric(v, eqs.mass),
        "force": _nonzero(zip(v, eqs.force, strict=True)),
    }
    if eqs.has_coordinate_frame:
        try:
            parts = vertical_parts(eqs.exact)
        except EngineLimit:
            return groups
        groups["curvature"] = _curvature(eqs, parts)
    return groups


def _curvature(eqs: VoronecEquations, parts: Any) -> dict[str, str]:
    a = curvature_of(parts, eqs.definition, eqs.bridge.outward)
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
        reduced = descend(eqs)
    except (DefinitionError, EngineLimit):
        return {}, {}
    v = _names(eqs.velocities)
    groups = {
        "reduced rates": _nonzero(zip(map(str, reduced.invariants), reduced.rates, strict=True)),
        "reduced mass": _symmetric(v, reduced.mass),
        "reduced force": _nonzero(zip(v, reduced.force, strict=True)),
    }
    return groups, {"reduced": [plain_text(r) for r in reduced.relations]}


def _symmetric(names: list[str], matrix: Any) -> dict[str, str]:
    size = range(len(names))
    return _nonzero((f"{names[i]},{names[j]}", matrix[i, j]) for i in size for j in size if i <= j)


def _nonzero(pairs: Iterable[tuple[str, Any]]) -> dict[str, str]:
    return {name: plain_text(e) for name, e in pairs if e != 0}


def read_expression(text: Any) -> sp.Expr:
    """What ``plain_text`` wrote; every name is a symbol but ``pi``, an unknown function a function.

    Raises ``DefinitionError`` for anything that is no expression.
    """
    if not isinstance(text, str):
        raise DefinitionError(f"'{quote(text)}' is no text of an expression")
    return read_sympy_text(text, "a stored expression")


AGREEMENT = sp.Float("1e-24", 30)
"""How far accelerations to ``DIGITS`` may lie apart, relative to the largest."""
INSTANTS = 201
"""At how many instants motions are compared."""


@dataclass(frozen=True)
class Row:
    """One thing compared.

    ``status`` is ``identical`` (the same text), ``proved`` (written differently, and equal),
    ``refuted``, ``undecided``, ``numeric`` (numbers that agree to 24 digits), or, of facts,
    ``different``.  ``domain`` bounds where a proof holds, as where one side alone declares
    a > 0.
    """

    group: str
    name: str
    status: str
    first: str
    second: str
    how: str = ""
    domain: str = ""

    @property
    def is_same(self) -> bool:
        """Whether both sides are the same, as far as is known, for all that either admits."""
        return self.status in ("identical", "proved", "numeric") and not self.domain


@dataclass(frozen=True, repr=False)
class Comparison:
    """All that was compared of ``first`` and ``second``.

    ``deviations`` gives the largest difference of each variable along the motion of the first
    one's scene ``default``; ``remark`` says why there are none.  ``exact`` is false where a side
    has no entries of mass or force: then numbers at points stand for the accelerations.
    """

    first: str
    second: str
    rows: tuple[Row, ...]
    deviations: dict[str, float]
    remark: str = ""
    exact: bool = True

    def __repr__(self) -> str:
        counts = f"{len(self.rows)} rows, {len(self.differences)} different"
        return f"Comparison({self.first!r}, {self.second!r}, {counts})"

    def _repr_html_(self) -> str:
        """For notebooks: each row with its verdict."""
        rows = [(f"{r.group}: {r.name}", f"{r.status}: {r.first} | {r.second}") for r in self.rows]
        return html_table(f"{self.first} and {self.second}", rows)

    @property
    def differences(self) -> tuple[Row, ...]:
        """What is not the same, or not known to be."""
        return tuple(r for r in self.rows if not r.is_same)

    @property
    def rewritten_rows(self) -> tuple[Row, ...]:
        """What is written differently, and proved equal."""
        return tuple(r for r in self.rows if r.status == "proved" and r.is_same)

    @property
    def equal(self) -> bool:
        """Whether everything is the same, by numbers at points where it is not ``exact``."""
        return not self.differences

    @property
    def outcome(self) -> str:
        """The end of a report in words."""
        if not self.equal:
            return "different"
        return "equal" if self.exact else "equal by numbers at points, which are no proof"

    def as_dict(self) -> dict[str, Any]:
        """Everything, as data."""
        return {
            "first": self.first,
            "second": self.second,
            "equal": self.equal,
            "exact": self.exact,
            "rows": [vars(row) for row in self.rows],
            "deviations": self.deviations,
            "remark": self.remark,
        }


Side = System | VoronecEquations | StoredDerivation


def compare(first: Side, second: Side) -> Comparison:
    """Compare what can be compared: entries of the same variables, values at the same points.

    Either side is a system, its equations, or what was kept of an earlier derivation; anything
    else raises ``DefinitionError``.
    """
    first, second = _derivation_of(first), _derivation_of(second)
    rows = [
        *_facts(first, second),
        *(row for group in _groups(first, second) for row in _entries(first, second, group)),
    ]
    exact = all(group in d.groups for d in (first, second) for group in ("mass", "force"))
    if not exact and {*first.facts["velocities"]} == {*second.facts["velocities"]}:
        numbers = [*_accelerations(first, second)]
        how = "one side has no exact equations, and there is no point with numbers of both"
        rows += numbers or [Row("accelerations", "all", "undecided", "", "", how)]
    deviations, remark = _motions(first, second)
    return Comparison(first.name, second.name, tuple(rows), deviations, remark, exact)


def _derivation_of(side: Side) -> StoredDerivation:
    if isinstance(side, StoredDerivation):
        return side
    return StoredDerivation.of(side if isinstance(side, VoronecEquations) else derive(side))


def _facts(first: StoredDerivation, second: StoredDerivation) -> Iterator[Row]:
    with_inputs = any(d.facts["inputs"] for d in (first, second))
    for fact in (*FACTS, "inputs") if with_inputs else FACTS:
        pair = [d.facts[fact] for d in (first, second)]
        ours, theirs = map(_show, pair)
        same = {*pair[0]} == {*pair[1]} if fact in SETS else ours == theirs
        status = "identical" if same else "different"
        if "undecided" in (ours, theirs) and ours != theirs:
            status = "undecided"
        yield Row("facts", fact, status, ours, theirs)
    ours, theirs = (str(_dimension(d)) for d in (first, second))
    yield Row("facts", "dimension", "identical" if ours == theirs else "different", ours, theirs)


def _dimension(d: StoredDerivation) -> int:
    """The dimension of the space of states."""
    facts = d.facts
    size = sum(len(facts[part]) for part in ("base", "fibre", "velocities"))
    return size - len(facts["relations"])


def _show(fact: Any) -> str:
    return ", ".join(map(str, fact)) if isinstance(fact, list) else str(fact)


def _groups(first: StoredDerivation, second: StoredDerivation) -> Iterator[str]:
    """The groups of entries that stand in the same variables on both sides."""

    def same(*parts: str) -> bool:
        return all({*first.facts[p]} == {*second.facts[p]} for p in parts)

    if same("velocities"):
        for group in ("rates", "mass", "force", "reduced rates", "reduced mass", "reduced force"):
            if group in first.groups and group in second.groups:
                yield group
    if same("base", "fibre") and all("curvature" in d.groups for d in (first, second)):
        yield "curvature"


def _entries(first: StoredDerivation, second: StoredDerivation, group: str) -> Iterator[Row]:
    ours, theirs = first.groups[group], second.groups[group]
    part = "reduced" if group.startswith("reduced") else ""
    shared, unshared = _known(first, second)
    for name in dict.fromkeys((*ours, *theirs)):
        a, b = ours.get(name, "0"), theirs.get(name, "0")
        if a == b:
            yield Row(group, name, "identical", a, b)
            continue
        ideal = [*map(read_expression, first.ideals.get(part, ())), *shared]
        sides = read_expression(a), read_expression(b)
        verdict = prove_equal(*sides, ideal)
        used = [c for c in unshared if any(c.free_symbols & e.free_symbols for e in sides)]
        if used and not verdict.proved:
            closer = prove_equal(*sides, [*ideal, *unshared]).where(*map(str, used))
            verdict = verdict if closer.undecided else closer
        how = verdict.method if verdict.witness is None else str(verdict.witness)
        yield Row(group, name, verdict.status, a, b, how, verdict.domain)


def _known(first: StoredDerivation, second: StoredDerivation) -> tuple[list[Any], list[Any]]:
    """What is declared of the parameters on both sides, and what one side alone declares, in the
    symbols that entries are read in.  Files tell signs alone; one that tells none takes the other
    side's."""
    files = first.equations is None or second.equations is None
    ours, theirs = (_conditions(side, files) for side in (first, second))
    known = [side for side in (ours, theirs) if side is not None] or [[]]
    ours, theirs = known[0], known[-1]
    shared = [c for c in ours if c in theirs]
    return shared, [c for c in dict.fromkeys((*ours, *theirs)) if c not in shared]


def _conditions(side: StoredDerivation, signs_alone: bool) -> list[Any] | None:
    """What is declared of the parameters of a system; None where that is not known."""
    if side.positive is None:
        return None
    signs = [read_expression(text) > 0 for text in side.positive]
    if signs_alone or side.equations is None:
        return signs
    system = side.equations.system
    named = {p.symbol: sp.Symbol(p.name) for p in system.parameters}
    return [*signs, *(c.xreplace(named) for c in system.conditions)]


def _accelerations(first: StoredDerivation, second: StoredDerivation) -> Iterator[Row]:
    """The accelerations of both sides at a few points of the first one."""
    ours, theirs = first.equations, second.equations
    points: Iterable[Any] = ()
    if ours is not None and theirs is not None and not is_general(ours.system):
        points = [random_point(ours.system, seed) for seed in range(POINTS)]
    for number, point in enumerate(points, 1):
        at = {plain_name(k): x for k, x in point.items()}
        try:
            a, b = (eqs.acceleration(at, digits=DIGITS) for eqs in (ours, theirs) if eqs)
        except (DefinitionError, EngineLimit):
            continue
        size = 1 + max(map(abs, a.values()), default=0)
        for q in a.keys() & b.keys():
            close = abs(a[q] - b[q]) <= AGREEMENT * size
            status = "numeric" if close else "refuted"
            how = "" if close else "at " + ", ".join(f"{k} = {x}" for k, x in at.items())
            name = plain_name(q)
            yield Row(f"acceleration at point {number}", name, status, str(a[q]), str(b[q]), how)


def _motions(first: StoredDerivation, second: StoredDerivation) -> tuple[dict[str, float], str]:
    """The motion of the first one's scene ``default``, integrated for both."""
    if first.equations is None or second.equations is None:
        return {}, "a stored derivation has no motions"
    ours, theirs = first.equations.system, second.equations.system
    if {*_variables(ours)} != {*_variables(theirs)}:
        return {}, "the variables differ"
    if "default" not in ours.scenes:
        return {}, f"'{ours.name}' has no scene 'default'"
    try:
        return _deviations(first.equations, second.equations), ""
    except VoronecError as error:
        return {}, str(error)


def _deviations(ours: Any, theirs: Any) -> dict[str, float]:
    import numpy as np

    from voronec.motion import integrate

    scene = ours.system.scenes["default"]
    begin, end = map(float, scene.times)
    grid = np.linspace(begin, end, INSTANTS)
    outputs = _variables(ours.system)
    first = integrate(ours, scene="default", times=grid, outputs=outputs)
    shared = {*theirs.system.parameter_names} & {*first.parameters}
    parameters = {name: first.parameters[name] for name in sorted(shared)}
    alike = replace(scene, parameters=parameters)
    second = integrate(theirs, scene=alike, times=grid, outputs=outputs)
    return {x: float(np.max(np.abs(first[x] - second[x]))) for x in outputs}


def _variables(system: System) -> list[str]:
    """The names of coordinates and velocities."""
    return [plain_name(x) for x in (*system.coordinates, *system.velocities)]
