"""Descent: equations rewritten in invariants of the configuration, with the proof that they close.

Given functions g_k(q), the engine looks for mass(g), force(g, v) and gdot(g, v).  A tag G_k is
adjoined for each g_k; a Groebner basis of the relations and of g_k - G_k, in an order that ranks
coordinates above tags, rewrites whatever descends in the tags alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.arguments import TEXT, VALUES, accepts, require
from voronec.algebra.field import Fraction
from voronec.algebra.normal import canonical
from voronec.algebra.points import sample_evaluable
from voronec.algebra.rank import proved_rank
from voronec.algebra.ring import Ring
from voronec.algebra.roots import ring_over
from voronec.algebra.shape import expression
from voronec.algebra.tape import Tape
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import html_table, latex_of, plain_text
from voronec.declaration.system import System
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import DefinitionError, EngineLimit


@dataclass(frozen=True, repr=False)
class Reduction:
    """mass(g) vdot = force(g, v),  gdot = rates(g, v): closed equations in invariants, proved.

    ``invariants`` are the m symbols g_k, ``definitions`` what they are in coordinates;
    ``velocities`` the n v of the equations; ``relations`` vanish identically (such as
    |gamma|^2 - 1).  Matrices are SymPy's: ``mass`` n x n, ``force`` n x 1, ``rates`` m x 1.
    """

    system: System
    invariants: tuple[sp.Symbol, ...]
    definitions: tuple[sp.Expr, ...]
    velocities: tuple[sp.Expr, ...]
    mass: sp.ImmutableMatrix
    force: sp.ImmutableMatrix
    rates: sp.ImmutableMatrix
    relations: tuple[sp.Expr, ...]

    def __repr__(self) -> str:
        names = (", ".join(map(str, part)) for part in (self.invariants, self.velocities))
        return "Reduction({!r}, invariants=({}), velocities=({}))".format(self.system.name, *names)

    def _repr_html_(self) -> str:
        """For notebooks: the invariants and the closed equations."""

        def show(expr: Any) -> str:
            return f"${latex_of(expr, self.system.coordinates, self.velocities)}$"

        triples = zip(self.invariants, self.definitions, self.rates, strict=True)
        rows = [(str(g), f"{show(d)}, with the rate {show(r)}") for g, d, r in triples]
        rows += [("masses", show(self.mass)), ("forces", show(self.force))]
        return html_table(f"{self.system.title or self.system.name}, reduced", rows)

    @property
    def momenta(self) -> sp.ImmutableMatrix:
        """G = mass(g) v, n x 1: the momenta conjugate to v where L is quadratic in velocities."""
        return self.mass * sp.Matrix(self.velocities)

    @property
    def momentum_rates(self) -> sp.ImmutableMatrix:
        """dG/dt = force + (dmass/dt) v along the motion, n x 1."""
        total = sp.Matrix(self.force)
        for g, rate in zip(self.invariants, self.rates, strict=True):
            total += self.mass.diff(g) * sp.Matrix(self.velocities) * rate
        return sp.ImmutableMatrix(total)

    def as_dict(self) -> dict[str, Any]:
        """The reduced equations as text that JSON can hold."""
        names = [str(g) for g in self.invariants]
        return {
            "invariants": dict(zip(names, map(plain_text, self.definitions), strict=True)),
            "relations": [plain_text(r) for r in self.relations],
            "mass": [[plain_text(e) for e in self.mass.row(i)] for i in range(self.mass.rows)],
            "force": [plain_text(e) for e in self.force],
            "rates": dict(zip(names, map(plain_text, self.rates), strict=True)),
        }


@accepts(invariants=VALUES)
def descend(
    system: System | VoronecEquations, invariants: Mapping[str, Any] | None = None
) -> Reduction:
    """Rewrite the equations of a system in invariants: its declared ones, or those given by name.

    Raises ``DefinitionError`` where an equation provably does not descend (a direction that keeps
    every invariant changes it), ``EngineLimit`` where no expression was found.
    """
    eqs = system if isinstance(system, VoronecEquations) else derive(system)
    chosen = _choose_invariants(eqs, invariants)
    derivation = eqs.exact
    inside = [eqs.bridge.inward(g) for g in chosen.values()]
    _check_configurational(eqs, chosen, inside)
    tags = [se.Symbol(name) for name in chosen]
    n = derivation.connection.n
    labels = [f"mass[{i},{j}]" for i in range(n) for j in range(n)]
    labels += [f"force[{i}]" for i in range(n)] + [f"d/dt {name}" for name in chosen]
    targets = [e for row in derivation.mass for e in row] + list(derivation.force)
    targets += [derivation.connection.flow_derivative(g, derivation.rates) for g in inside]
    targets, ring, group = _ring_of_invariants(eqs, targets, inside, tags)
    moving = _coordinate_generators(ring, eqs.definition.coordinates)
    entries = []
    for label, target in zip(labels, targets, strict=True):
        element = ring.fraction(target)
        if not _free_of(ring, element, moving):
            _refuse(eqs, label, target, inside)
        entries.append(eqs.bridge.outward(expression(ring, element, group)))
    return Reduction(
        system=eqs.system,
        invariants=tuple(sp.Symbol(name) for name in chosen),
        definitions=tuple(as_expression(g) for g in chosen.values()),
        velocities=eqs.velocities,
        mass=sp.ImmutableMatrix(n, n, entries[: n * n]),
        force=sp.ImmutableMatrix(n, 1, entries[n * n : n * n + n]),
        rates=sp.ImmutableMatrix(len(tags), 1, entries[n * n + n :]),
        relations=_relations_among(eqs, ring, moving),
    )


def in_invariants(
    eqs: VoronecEquations, exprs: Sequence[Any], kept: Sequence[Any] = ()
) -> list[Any | None]:
    """Expressions in the engine's symbols as functions of the declared invariants, of velocities of
    the equations and of the coordinates that are ``kept``; None for those that were not
    rewritten."""
    chosen = _choose_invariants(eqs, None)
    inside = [eqs.bridge.inward(g) for g in chosen.values()]
    tags = [se.Symbol(name) for name in chosen]
    plain, ring, group = _ring_of_invariants(eqs, exprs, inside, tags)
    free = [q for q in eqs.definition.coordinates if q not in kept]
    moving = _coordinate_generators(ring, free)
    elements = [ring.fraction(e) for e in plain]
    return [expression(ring, e, group) if _free_of(ring, e, moving) else None for e in elements]


def _ring_of_invariants(
    eqs: VoronecEquations, exprs: Sequence[Any], inside: Sequence[Any], tags: Sequence[Any]
) -> tuple[list[Any], Ring, list[Any]]:
    """Expressions in normal form, a ring that holds them and ``tags`` for the invariants
    ``inside``, and the velocities that it has."""
    definition = eqs.definition
    plain = canonical(exprs, definition.relations)  # cancel before tags come in
    ideal = [*definition.relations, *(g - t for g, t in zip(inside, tags, strict=True))]
    ring = ring_over([*plain, *inside, *tags, *definition.velocities], ideal)
    return plain, ring, [v for v in definition.velocities if ring.has(v)]


def _choose_invariants(
    eqs: VoronecEquations, invariants: Mapping[str, Any] | None
) -> dict[str, Any]:
    chosen = dict(eqs.system.invariants if invariants is None else invariants)
    if not chosen:
        raise DefinitionError(f"system '{eqs.system.name}' declares no invariants; give some")
    names = {str(s) for s in eqs.system.known_symbols()}
    for name, meaning in chosen.items():
        require("descend", "the name of an invariant", name, TEXT)
        chosen[name] = as_expression(meaning, f"the invariant '{name}'")
        if name in names:
            raise DefinitionError(f"the invariant '{name}' has the name of another symbol")
    return chosen


def _check_configurational(
    eqs: VoronecEquations, chosen: Mapping[str, Any], inside: Sequence[Any]
) -> None:
    d = eqs.definition
    moving = {*d.velocities, *d.coordinate_velocities}
    for name, g in zip(chosen, inside, strict=True):
        if g.free_symbols & moving:
            raise DefinitionError(
                f"the invariant '{name}' contains a velocity; invariants are functions of the "
                "coordinates"
            )


def _coordinate_generators(ring: Ring, coordinates: Sequence[Any]) -> list[int]:
    """The generators whose meaning depends on a coordinate."""
    free = set(coordinates)
    return [i for i, g in enumerate(ring.meaning) if g.free_symbols & free]


def _free_of(ring: Ring, element: Fraction, generators: Sequence[int]) -> bool:
    polynomials = [element.num, *(p for p, _ in ring.field.factors(element.den))]
    return not any(p != 0 and p.degrees()[g] for p in polynomials for g in generators)


def _relations_among(
    eqs: VoronecEquations, ring: Ring, moving: Sequence[int]
) -> tuple[sp.Expr, ...]:
    """The elements of the Groebner basis in which only tags occur."""
    return tuple(
        eqs.bridge.outward(ring.polynomial(p))
        for p in ring.field.ideal
        if not any(p.degrees()[g] for g in moving)
    )


def _refuse(eqs: VoronecEquations, label: str, target: Any, invariants: Sequence[Any]) -> None:
    """Say why a target was not rewritten: dF outside the span of the dg, or a limit."""
    q = eqs.definition.coordinates
    differentials = [e.diff(x) for e in (*invariants, target) for x in q]
    relations = eqs.definition.relations
    differentials += [r.diff(x) for r in relations for x in q]
    rows, width = len(invariants) + 1, len(q)
    known = (*relations, *eqs.definition.conditions)
    for _, values in sample_evaluable(Tape(differentials), known, 256):
        table = [values[i * width : (i + 1) * width] for i in range(rows + len(relations))]
        without = [*table[: rows - 1], *table[rows:]]
        if proved_rank(table, 256) > proved_rank(without, 256):
            raise DefinitionError(
                f"system '{eqs.system.name}': {label} is not a function of the invariants; "
                "add an invariant, or choose others"
            )
    raise EngineLimit(
        f"system '{eqs.system.name}': {label} depends on the invariants only, but no expression "
        "was found"
    )
