"""Two derivations compared: facts, entries with verdicts, accelerations, a motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.algebra.text import exact_number, read_sympy_text
from voronec.algebra.typeset import html_table
from voronec.algebra.verdicts import prove_equal
from voronec.declaration.reading import quote
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit, VoronecError
from voronec.proof.comparison.stored_derivation import FACTS, StoredDerivation

__all__ = ["Comparison", "Row", "compare", "read_expression"]


def read_expression(text: Any) -> sp.Expr:
    """What ``plain_text`` wrote; every name is a symbol but ``pi``, an unknown function a function.

    Raises ``DefinitionError`` for anything that is no expression.
    """
    if not isinstance(text, str):
        raise DefinitionError(f"'{quote(text)}' is no text of an expression")
    return read_sympy_text(text, "a stored expression")


AGREEMENT = sp.Float("1e-24", 30)
"""How far accelerations of 30 digits may lie apart, relative to the largest."""
SEEN = 201
"""At how many instants motions are compared."""


@dataclass(frozen=True)
class Row:
    """One thing compared.

    ``status`` is ``identical`` (the same text), ``proved`` (written differently, and equal),
    ``refuted``, ``undecided``, ``numeric`` (numbers that agree to 24 digits), or, of facts,
    ``different``.
    """

    group: str
    name: str
    status: str
    first: str
    second: str
    how: str = ""


@dataclass(frozen=True, repr=False)
class Comparison:
    """All that was compared of ``first`` and ``second``.

    ``deviations`` gives the largest difference of each variable along the motion of the first
    one's scene ``default``; ``remark`` says why there are none.
    """

    first: str
    second: str
    rows: tuple[Row, ...]
    deviations: dict[str, float]
    remark: str = ""

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
        return tuple(r for r in self.rows if r.status not in ("identical", "proved", "numeric"))

    @property
    def rewritten_rows(self) -> tuple[Row, ...]:
        """What is written differently, and proved equal."""
        return tuple(r for r in self.rows if r.status == "proved")

    @property
    def equal(self) -> bool:
        """Whether everything is the same."""
        return not self.differences

    def as_dict(self) -> dict[str, Any]:
        """Everything, as data."""
        return {
            "first": self.first,
            "second": self.second,
            "equal": self.equal,
            "rows": [vars(row) for row in self.rows],
            "deviations": self.deviations,
            "remark": self.remark,
        }


Side = System | VoronecEquations | StoredDerivation


def compare(first: Side, second: Side) -> Comparison:
    """Compare what can be compared: entries of the same variables, values at the same points.

    Either side is a system, its equations, or what was kept of an earlier derivation.
    """
    first, second = _derivation_of(first), _derivation_of(second)
    rows = [
        *_facts(first, second),
        *(row for group in _groups(first, second) for row in _entries(first, second, group)),
        *_values(first, second),
    ]
    deviations, remark = _motions(first, second)
    return Comparison(first.name, second.name, tuple(rows), deviations, remark)


def _derivation_of(side: Side) -> StoredDerivation:
    if isinstance(side, StoredDerivation):
        return side
    return StoredDerivation.of(side if isinstance(side, VoronecEquations) else derive(side))


def _facts(first: StoredDerivation, second: StoredDerivation) -> Iterator[Row]:
    for fact in FACTS:
        ours, theirs = (_show(d.facts[fact]) for d in (first, second))
        status = "identical" if ours == theirs else "different"
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
    known = [*_conditions(first), *_conditions(second)]
    for name in dict.fromkeys((*ours, *theirs)):
        a, b = ours.get(name, "0"), theirs.get(name, "0")
        if a == b:
            yield Row(group, name, "identical", a, b)
            continue
        ideal = [*map(read_expression, first.ideals.get(part, ())), *known]
        verdict = prove_equal(read_expression(a), read_expression(b), ideal)
        how = verdict.method if verdict.witness is None else str(verdict.witness)
        yield Row(group, name, verdict.status, a, b, how)


def _conditions(side: StoredDerivation) -> list[Any]:
    """What is declared of the parameters of a system, in the symbols that entries are read in."""
    signs = [read_expression(text) > 0 for text in side.positive]
    if side.equations is None:
        return signs
    system = side.equations.system
    own = {p.symbol: sp.Symbol(p.name) for p in system.parameters}
    return [*signs, *(c.xreplace(own) for c in system.conditions)]


def _values(first: StoredDerivation, second: StoredDerivation) -> Iterator[Row]:
    """Accelerations at the points of one side, which the other side knows or computes."""
    for ours, theirs in ((first, second), (second, first)):
        rows: list[Row] = []
        for number, (at, stored) in enumerate(ours.points):
            found = _acceleration(theirs, at)
            if found is not None:
                rows += _point(number + 1, at, stored, found, ours is second)
        if rows:
            yield from rows
            return
    if {*first.facts["velocities"]} == {*second.facts["velocities"]} and not (
        "mass" in first.groups and "mass" in second.groups
    ):
        how = "one side has no exact equations, and there is no point that both know"
        yield Row("accelerations", "all", "undecided", "", "", how)


def _acceleration(side: StoredDerivation, at: Any) -> dict[str, str] | None:
    """The accelerations of one side at a point; None where it knows none there."""
    for point, stored in side.points:
        if point == at:
            return dict(stored)
    if side.equations is None:
        return None
    point = {k: _stored_number(x) for k, x in at.items()}
    known = {plain_name(s) for s in side.equations.system.known_symbols() if is_symbolic_name(s)}
    if not {*at} <= known:
        return None
    try:
        found = side.equations.acceleration(point, digits=30)
    except (DefinitionError, EngineLimit):
        return None
    return {plain_name(q): str(a) for q, a in found.items()}


def _stored_number(number: Any) -> sp.Expr:
    return exact_number(str(number), "a number of a stored derivation")


def _point(number: int, at: Any, stored: Any, found: Any, swapped: bool) -> Iterator[Row]:
    size = 1 + max((abs(_stored_number(a)) for a in stored.values()), default=0)
    for name, value in stored.items():
        other = found.get(name)
        if other is None:
            continue
        close = abs(_stored_number(value) - _stored_number(other)) <= AGREEMENT * size
        status = "numeric" if close else "refuted"
        a, b = (other, value) if swapped else (value, other)
        how = "" if close else "at " + ", ".join(f"{k} = {x}" for k, x in at.items())
        yield Row(f"acceleration at point {number}", name, status, a, b, how)


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
    grid = np.linspace(begin, end, SEEN)
    outputs = _variables(ours.system)
    first = integrate(ours, scene="default", times=grid, outputs=outputs)
    shared = {p.name for p in theirs.system.parameters} & {*first.parameters}
    start = dict(zip(first.names, map(float, first.state[0]), strict=True))
    second = integrate(
        theirs,
        times=grid,
        outputs=outputs,
        parameters={name: first.parameters[name] for name in sorted(shared)},
        initial=start,
    )
    return {x: float(np.max(np.abs(first[x] - second[x]))) for x in outputs}


def _variables(system: System) -> list[str]:
    """The names of coordinates and velocities."""
    return [plain_name(x) for x in (*system.coordinates, *system.velocities)]
