"""Gauge momenta: linear integrals as momenta of fields along the orbits of a group.

An integral J that is linear in the velocities is p(xi), p the momenta dLc/dv, of one field xi that
the constraints allow, its *generator*.  Where xi is sum f_a(q) Y_a with fields Y_a that leave the
Lagrangian unchanged, J is a gauge momentum; where all f_a are constants it is the momentum of a
horizontal symmetry [FassoGiacobbeSansonetto2008].

The Y_a are found as affine fields on the coordinates, by linear algebra at random points modulo a
prime, or are given.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.arguments import COUNT, VALUES, accepts
from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.normal import canonical, shortest
from voronec.algebra.terms import atoms
from voronec.algebra.typeset import html_table, plain_text
from voronec.algebra.verdicts import Verdict, decide_zero
from voronec.declaration.reading import fixed_mapping, quote
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, EngineLimit
from voronec.proof.claims import decide_integral
from voronec.proof.decision import all_zero
from voronec.proof.search.densities import motions_at
from voronec.proof.search.lifting import SURPLUS, lift_kernel
from voronec.proof.search.outcome import plain_data
from voronec.proof.search.probe import Probe, Values
from voronec.proof.search.residues import Array
from voronec.proof.search.search import read_expressions, search_integrals

CIRCULAR = (se.sin, se.cos, se.tan)


@dataclass(frozen=True)
class GaugeMomentum:
    """A linear integral p(xi): ``expression``, the components of xi at the coordinates, and the
    ``coefficients`` f_a of xi = sum f_a Y_a; None where xi is not along the fields Y_a found.

    ``verdict`` is that on the integral and on the coefficients.
    """

    expression: sp.Expr
    generator: dict[sp.Expr, sp.Expr]
    coefficients: dict[str, sp.Expr] | None
    kind: str
    verdict: Verdict


@dataclass(frozen=True)
class GaugeSearch:
    """Linear integrals with their generators; ``symmetries`` are the fields Y_a, by name."""

    system: str
    symmetries: dict[str, dict[sp.Expr, sp.Expr]]
    momenta: tuple[GaugeMomentum, ...]
    seconds: float

    def _repr_html_(self) -> str:
        """For notebooks: each integral with what it is."""
        rows = [(plain_text(m.expression), self.words(m)) for m in self.momenta]
        return html_table(f"gauge momenta of {self.system}", [*rows, ("statement", self.statement)])

    def words(self, momentum: GaugeMomentum) -> str:
        """What an integral is, and of which field."""
        parts = momentum.coefficients
        if parts is None:
            return f"{momentum.kind}: {write_field(momentum.generator)}"
        along = " + ".join(f"({plain_text(f)}) {name}" for name, f in parts.items() if f != 0)
        return f"{momentum.kind}: {along}"

    @property
    def is_decided(self) -> bool:
        """Whether all integrals are proved."""
        return all(m.verdict.proved for m in self.momenta)

    @property
    def statement(self) -> str:
        """What was found, in words."""
        gauge = sum(m.coefficients is not None for m in self.momenta)
        return (
            f"Of {len(self.momenta)} integrals linear in the velocities {gauge} are gauge momenta "
            f"of {len(self.symmetries)} affine fields that leave the Lagrangian unchanged."
        )

    def as_dict(self) -> dict[str, Any]:
        """The outcome as text and numbers that JSON can hold."""
        return {**plain_data(self), "decided": self.is_decided, "statement": self.statement}


def write_field(components: Mapping[Any, Any]) -> str:
    """A field on the coordinates, as text."""
    return " + ".join(f"({plain_text(e)}) d/d{x}" for x, e in components.items()) or "0"


@accepts(positions=COUNT, fields=VALUES, at=VALUES, seed=COUNT)
def search_gauge_momenta(
    system: System | VoronecEquations,
    *,
    positions: int = 3,
    integrals: Sequence[Any] = (),
    fields: Mapping[str, Mapping[Any, Any]] | None = None,
    at: Mapping[Any, Any] | None = None,
    seed: int = 1,
) -> GaugeSearch:
    """Which integrals linear in the velocities are momenta of a group, and of which fields.

    positions
        bound on the degree in the positions of the integrals that are searched (3).
    integrals
        further linear integrals, as expressions, that need not be polynomials.
    fields
        name -> {coordinate: component}, further fields that leave the Lagrangian unchanged.
    at
        parameter -> special value, a number or a function of others.

    Every integral and every field carries a proof.  Raises ``DefinitionError`` for a field that
    changes the Lagrangian, or an integral that is none; ``EngineLimit`` on groups, where the
    Lagrangian is no function of coordinates and their velocities.
    """
    begin, motions = perf_counter(), motions_at(system, at or {})
    field, definition = motions.on_coordinates, motions.equations.definition
    if definition.group is not None:
        raise EngineLimit("gauge momenta are searched where coordinates have velocities")
    search = search_integrals(motions.equations, degree=1, positions=positions, again=True)
    linear = [f.expression for f in search.integrals if f.verdict.proved]
    linear += read_expressions(motions.system, integrals, "integrals")
    symmetries = {f"Y{i + 1}": y for i, y in enumerate(_affine_symmetries(motions, seed))}
    for name, given in (fields or {}).items():
        place = f"the field '{quote(name)}'"
        named = {str(q): c for q, c in fixed_mapping(given, place, "coordinate: component").items()}
        read = [named.pop(str(q), 0) for q in motions.system.coordinates]
        if named:
            raise DefinitionError(f"{place} has no coordinate '{quote(next(iter(named)))}'")
        symmetries[str(name)] = [*map(field.read, read_expressions(motions.system, read, place))]
        if not _leaves_lagrangian(motions, symmetries[str(name)]):
            raise DefinitionError(f"{place} is not proved to leave the Lagrangian as it is")
    momenta = [_gauge_momentum(motions, e, symmetries) for e in linear]
    coordinates = motions.system.coordinates
    shown = {
        name: {x: field.bridge.outward(c) for x, c in zip(coordinates, y, strict=True) if c != 0}
        for name, y in symmetries.items()
    }
    kept = tuple(m for m in momenta if m is not None)
    return GaugeSearch(motions.system.name, shown, kept, perf_counter() - begin)


def _affine_symmetries(motions: Motions, seed: int) -> list[list[Any]]:
    """A basis of the affine fields B q + b that leave the Lagrangian and the relations as they
    are."""
    field, definition = motions.on_coordinates, motions.equations.definition
    n, dots = len(definition.coordinates), definition.coordinate_velocities
    unit = tuple(tuple(se.Integer(int(i == j)) for j in range(n)) for i in range(n))
    free = replace(
        field, velocities=dots, rates=dots, mass=unit, force=(se.Integer(0),) * n, meaning={}
    )
    slopes = [r.diff(q) for r in field.relations for q in definition.coordinates]
    probe = Probe(free, free.variables, [definition.lagrangian, *slopes])

    def table(values: Values) -> Array:
        p, points = values.p, values.points
        ones = np.ones((1, points), dtype=np.int64)
        q, v = np.split(values.letters, 2)
        state, moved = np.concatenate([q, ones]), np.concatenate([v, 0 * ones])
        gradients = values.known[1:].reshape(-1, n, points)
        by_state, by_rate = np.split(values.known_slopes[0], 2)
        first = (by_state[:, None] * state + by_rate[:, None] * moved % p) % p
        rest = [g[:, None] * state % p for g in gradients]
        return (
            np.array([first, *rest])
            .reshape(1 + len(rest), -1, points)
            .swapaxes(1, 2)
            .reshape(-1, n * (n + 1))
        )

    # a component that is linear in an angle is no function on the circle
    turning = {
        x for a in atoms([definition.lagrangian, *field.entries], *CIRCULAR) for x in a.free_symbols
    }
    state = [*definition.coordinates, se.Integer(1)]
    allowed = [i for i in range(n * (n + 1)) if state[i % (n + 1)] not in turning]
    rng, symmetries = np.random.default_rng(abs(seed)), []
    for entries in lift_kernel(lambda v: table(v)[:, allowed], len(allowed) + SURPLUS, probe, rng):
        y = [se.Integer(0)] * n
        for place, weight in entries.items():
            component, factor = divmod(allowed[place], n + 1)
            y[component] += weight * state[factor]
        if _leaves_lagrangian(motions, y):
            symmetries.append(y)
    return symmetries


def _leaves_lagrangian(motions: Motions, y: Sequence[Any]) -> bool:
    """Whether it is proved that a field on the coordinates leaves Lagrangian and relations as they
    are."""
    definition = motions.equations.definition
    pairs = [*zip(definition.coordinates, definition.coordinate_velocities, strict=True)]
    lifted = [se.Add(*[v * c.diff(q) for q, v in pairs]) for c in y]
    along = [
        se.Add(*[c * r.diff(q) for c, (q, _) in zip(y, pairs, strict=True)])
        for r in (definition.lagrangian, *definition.relations)
    ]
    along[0] += se.Add(
        *[c * definition.lagrangian.diff(v) for c, (_, v) in zip(lifted, pairs, strict=True)]
    )
    return all_zero([("", e) for e in along], definition.relations).proved


def _gauge_momentum(
    motions: Motions, integral: sp.Expr, symmetries: Mapping[str, Sequence[Any]]
) -> GaugeMomentum | None:
    """What a linear integral is the momentum of; None for one that is not p(xi)."""
    field, derivation = motions.on_coordinates, motions.equations.best
    function = field.read(integral)
    verdict = decide_integral(motions, integral).verdict
    if verdict.refuted:
        raise DefinitionError(f"'{plain_text(integral)}' is no integral: {verdict.method}")
    xi = [row[0] for row in field.solve([[function.diff(v)] for v in field.velocities])]
    rest = function - dot(derivation.quasi_momenta, xi)
    moving = {*field.velocities}
    if any(e.free_symbols & moving for e in xi) or not decide_zero(rest, field.hypotheses).proved:
        return None
    lift = [
        se.Add(*[r.diff(v) * c for v, c in zip(field.velocities, xi, strict=True)])
        for r in field.rates
    ]
    lift = shortest(canonical(lift, field.relations))
    outward = field.bridge.outward
    generator = {
        outward(q): outward(c) for q, c in zip(field.positions, lift, strict=True) if c != 0
    }
    names, fields = list(symmetries), list(symmetries.values())
    coefficients, kind = None, "not along the orbits of the fields found"
    rows = [[y[i] for y in fields] for i in range(len(lift))] if fields else []
    solved = solve_linear(rows, [[c] for c in lift], field.hypotheses) if fields else None
    if solved is not None and not solved.contradictory:
        values = [row[0] for row in solved.values]
        residuals = [("", c - dot(row, values)) for c, row in zip(lift, rows, strict=True)]
        if all_zero(residuals, field.hypotheses).proved:
            coefficients = dict(zip(names, map(outward, shortest(values)), strict=True))
            still = not any(f.free_symbols & {*field.positions} for f in values)
            kind = "momentum of a horizontal symmetry" if still else "gauge momentum"
    return GaugeMomentum(integral, generator, coefficients, kind, verdict)
