"""Densities of invariant measures, and reducing multipliers, by linear algebra over an ansatz.

With log rho = a_1 log p_1 + ... + a_k log p_k + a polynomial in the state, the condition for an
invariant measure is linear in the coefficients:

    a_1 X(p_1)/p_1 + ... + a_k X(p_k)/p_k + X(polynomial) + div X - tr C = 0,               (32)

C as in [Theory, eq. (14)].  The p_i are factors that the equations hold.  At random points modulo
a prime it is a system of numbers.  Its solution is lifted to Q and the parameters, and the density
is handed to the prover of declared measures, which derives the divergence by formulas of its own.

In another time, dtau = N dt, N a reducing multiplier, the volume of coordinates and momenta is
invariant; so N^(k - 1) times that volume is in the time t, for k independent velocities, and N
follows from the density [Theory, eq. (33)].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations_with_replacement
from math import comb
from time import perf_counter
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.arguments import COUNT, VALUES, accepts
from voronec.algebra.factors import irreducible_factors
from voronec.algebra.matrices import determinant
from voronec.algebra.points import sample_evaluable
from voronec.algebra.roots import ring_over
from voronec.algebra.shape import operations
from voronec.algebra.tape import Tape
from voronec.algebra.typeset import html_table, latex_of, plain_text
from voronec.algebra.verdicts import Verdict
from voronec.declaration.claims import Measure
from voronec.declaration.scene import Parameter
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit
from voronec.proof.claims import specialise
from voronec.proof.hamiltonian_form import decide_multiplier
from voronec.proof.measures import decide_measure
from voronec.proof.search.lifting import SURPLUS, lift_vector
from voronec.proof.search.outcome import plain_data
from voronec.proof.search.probe import Probe, Values, motion_slopes, solve_each
from voronec.proof.search.residues import Array, free_columns
from voronec.proof.search.search import CLASS_LIMIT, parameter_values, read_expressions

FACTORS = 60
"""So many factors are taken into an ansatz, the shortest first."""
TERMS = 400
"""Polynomials with more terms are not taken apart."""


@dataclass(frozen=True)
class FoundDensity:
    """A density, or a reducing multiplier: ``expression`` in the user's symbols, the ``variables``
    whose volume it multiplies (none for a multiplier), and the verdict of the exact algebra."""

    expression: sp.Expr
    variables: tuple[sp.Expr, ...]
    verdict: Verdict


@dataclass(frozen=True)
class DensitySearch:
    """The outcome of a search for a density or a reducing multiplier, ``kind``.

    ``factors`` are those of the ansatz; ``excluded`` says whether it is proved that nothing is of
    its form, for generic parameters.
    """

    system: str
    kind: str
    factors: tuple[sp.Expr, ...]
    found: FoundDensity | None
    excluded: bool
    seconds: float

    def _repr_html_(self) -> str:
        """For notebooks: what was found, and the statement."""
        rows = [("factors", ", ".join(map(str, self.factors))), ("statement", self.statement)]
        if self.found is not None:
            rows.insert(0, (self.kind, f"${latex_of(self.found.expression, ())}$"))
        return html_table(f"{self.kind} of {self.system}", rows)

    @property
    def is_decided(self) -> bool:
        """Whether something is proved: what was found, or that there is none."""
        return self.excluded if self.found is None else self.found.verdict.proved

    @property
    def statement(self) -> str:
        """What is proved, in words."""
        article = "an" if self.kind[0] in "aeiou" else "a"
        if self.found is not None:
            verdict = self.found.verdict
            words = " ".join(filter(None, (verdict.status, verdict.limits)))
            why = "" if verdict.proved else f", {verdict.method}"
            return f"{plain_text(self.found.expression)} is {article} {self.kind}: {words}{why}."
        sure = (
            "is proved not to exist, for generic parameters" if self.excluded else "was not found"
        )
        return f"{article.title()} {self.kind} that is a product of powers of these factors {sure}."

    def as_dict(self) -> dict[str, Any]:
        """The outcome as text and numbers that JSON can hold."""
        return {**plain_data(self), "decided": self.is_decided, "statement": self.statement}


@accepts(exponent=COUNT, at=VALUES, seed=COUNT)
def search_measures(
    system: System | VoronecEquations,
    *,
    factors: Sequence[Any] = (),
    exponent: int = 2,
    at: Mapping[Any, Any] | None = None,
    seed: int = 1,
) -> DensitySearch:
    """Search an invariant measure whose density is a product of powers and of an exponential.

    factors
        further factors of the density, beside those that mass, rates and forces hold.
    exponent
        bound on the degree of the polynomial whose exponential is a factor (2).
    at
        parameter -> special value, a number or a function of other parameters, old or new.

    The variables are the invariants, where the system descends to them, with the velocities, else
    the coordinates; where none is found on the invariants, coordinates come next.  Powers may be
    functions of the parameters.  A density that is found carries the verdict of the prover of
    declared measures.  Raises ``DefinitionError`` for what makes no sense, ``EngineLimit`` for
    equations too large.
    """
    begin, motions = perf_counter(), motions_at(system, at or {})
    last: DensitySearch | None = None
    # a density of positions alone vanishes at fewer states
    steps = [(level, moving) for level in _levels(motions) for moving in (False, True)]
    for level, moving in steps:
        field = motions.at(level)
        ansatz = _Ansatz.of(field, factors, exponent * moving, velocities=moving)
        solved, excluded = ansatz.solve(np.random.default_rng(abs(seed)))
        finding = None
        if solved is not None:
            variables = tuple(map(field.bridge.outward, field.variables))
            density = field.bridge.outward(solved)
            verdict = decide_measure(motions, Measure(density, variables)).verdict
            finding = FoundDensity(density, variables, verdict)
        last = _result(motions, "invariant measure", ansatz, finding, excluded, begin)
        if finding is not None:
            break
    assert last is not None
    return last


@accepts(at=VALUES, seed=COUNT)
def search_reducing_multipliers(
    system: System | VoronecEquations,
    *,
    factors: Sequence[Any] = (),
    at: Mapping[Any, Any] | None = None,
    seed: int = 1,
) -> DensitySearch:
    """Search Chaplygin's reducing multiplier N, a product of powers of functions of position.

    The options are those of ``search_measures``.  What is found carries the verdict of the prover
    of declared multipliers.  Raises as that does, and ``EngineLimit`` where the velocities are no
    frame on the space of the base.
    """
    begin, motions = perf_counter(), motions_at(system, at or {})
    field = motions.on_coordinates
    if field.level != "coordinates":
        raise EngineLimit("a reducing multiplier is sought on coordinates")
    count = len(field.velocities)
    if count > 1:
        weight = _volume_of_momenta(motions)
        ansatz = _Ansatz.of(
            field, factors, 0, velocities=False, weight=weight, scale=count - 1, base=_base(motions)
        )
        solved, excluded = ansatz.solve(np.random.default_rng(abs(seed)))
    else:  # with one velocity all are, or none is
        ansatz, excluded = _Ansatz(field, (), (), None, 1, 0), False
        solved = se.Integer(1)
    finding = None
    if solved is not None:
        multiplier = field.bridge.outward(solved)
        verdict = decide_multiplier(motions, multiplier).verdict
        if not verdict.refuted:
            finding = FoundDensity(multiplier, (), verdict)
    return _result(motions, "reducing multiplier", ansatz, finding, excluded, begin)


def motions_at(system: System | VoronecEquations, at: Mapping[Any, Any]) -> Motions:
    """The motions at special values of parameters; symbols that are new become parameters."""
    motions = Motions.of(system)
    values = parameter_values(motions.system, at)
    if not values:
        return motions
    known = {p.symbol for p in motions.system.parameters}
    fresh = sorted({s for v in values.values() for s in v.free_symbols} - known, key=str)
    return Motions.of(specialise(motions.system, values, tuple(map(Parameter, fresh))))


def _levels(motions: Motions) -> list[str]:
    """The levels of a system, the lower one first."""
    low = motions.field_for(()).level
    return ["invariants", "coordinates"] if low == "invariants" else ["coordinates"]


def _result(
    motions: Motions, kind: str, ansatz: _Ansatz, found: FoundDensity | None, excluded: bool,
    begin: float,
) -> DensitySearch:  # fmt: skip
    factors = tuple(map(ansatz.field.bridge.outward, ansatz.factors))
    name = motions.system.name
    return DensitySearch(name, kind, factors, found, excluded, perf_counter() - begin)


def _base(motions: Motions) -> int:
    """How many positions are those of the base: all, where relations bind them."""
    field, definition = motions.on_coordinates, motions.equations.definition
    return (
        len(field.positions) if definition.group is not None or field.relations else definition.base
    )


def _volume_of_momenta(motions: Motions) -> Any:
    """By what the volume of coordinates and velocities is multiplied to be that of coordinates and
    momenta: det(mass)/det[h | grad R] det(grad R grad R^T), h the frame, R the relations."""
    field = motions.on_coordinates
    relations, places = field.independent_relations, range(_base(motions))
    if len(places) != len(field.velocities) + len(relations):
        raise EngineLimit("the velocities are no frame on the space of the base")
    slopes = [[r.diff(field.positions[i]) for i in places] for r in relations]
    frame = [[field.rates[i].diff(v) for i in places] for v in field.velocities]
    gram = [[se.Add(*map(se.Mul, a, b)) for b in slopes] for a in slopes]
    return determinant(field.mass) * determinant(gram) / determinant([*frame, *slopes])


@dataclass(frozen=True)
class _Ansatz:
    """A density rho^scale weight, with log rho = sum a_i log(factor_i) + sum c_k term_k, in the
    first ``base`` positions of a field and its velocities."""

    field: VectorField
    factors: tuple[Any, ...]
    terms: tuple[Any, ...]
    weight: Any
    scale: int
    base: int

    @classmethod
    def of(
        cls, field: VectorField, given: Sequence[Any], exponent: int, velocities: bool,
        weight: Any = None, scale: int = 1, base: int | None = None,
    ) -> _Ansatz:  # fmt: skip
        """Factors that the equations hold, the shortest first, and monomials of an exponent."""
        if any(field.time in e.free_symbols for e in field.entries):  # the time is a coordinate
            field = replace(
                field, positions=(*field.positions, field.time), time=se.Symbol("no time"),
                rates=(*field.rates, se.Integer(1)),
            )  # fmt: skip
        base = len(field.positions) if base is None else base
        moving = {*field.positions[:base], *(field.velocities if velocities else ())}
        extra = [*map(field.read, read_expressions(field.system, given, "factors"))]
        count = comb(len(field.variables) + exponent, exponent) if exponent > 0 else 1
        if count > CLASS_LIMIT:
            raise EngineLimit(
                f"the exponent has {count} monomials, more than {CLASS_LIMIT}; lower its degree"
            )
        by_name = field.determinant is not None and weight is None
        named = [determinant(field.mass)] if by_name else []
        held = [*extra, *named, *_factors(field, [] if weight is None else [weight])]
        usable = [f for f in held if (s := f.free_symbols & {*field.variables}) and s <= moving]
        factors = list(dict.fromkeys(usable))[: FACTORS + len(extra)]
        degrees = range(1, exponent + 1)
        free = field.variables
        terms = [se.Mul(*m) for d in degrees for m in combinations_with_replacement(free, d)]
        return cls(field, tuple(factors), tuple(terms), weight, scale, base)

    def solve(self, rng: Any) -> tuple[Any, bool]:
        """The density, None where there is none; and whether it is proved that there is no
        other."""
        probe = self._probe()
        count = len(self.factors) + len(self.terms) + SURPLUS
        values = probe.one(count, rng)
        table = self._table(values)
        _, pivots = free_columns(table, values.p)
        last = table.shape[1] - 1
        sure = len(pivots) == last + (last in pivots)
        if last in pivots:
            return None, sure

        def vector(values: Values) -> Array | None:
            echelon, leading = free_columns(self._table(values)[:, [*pivots, -1]], values.p)
            return -echelon[:, -1] % values.p if leading == [*range(len(pivots))] else None

        powers = lift_vector(vector, len(pivots), probe, rng)
        return self._density(dict(zip(pivots, powers, strict=True))), sure

    def _probe(self) -> Probe:
        field = self.field
        slopes = [r.diff(q) for r in field.independent_relations for q in field.positions]
        letters = [*self.factors, *self.terms, *([] if self.weight is None else [self.weight])]
        return Probe(field, letters, [*field.entries, *slopes])

    def _table(self, values: Values) -> Array:
        """The terms of [Theory, eq. (32)], (point, unknown), those without unknowns last."""
        p, count = values.p, len(self.factors)
        rates = values.logarithmic.copy()
        end = count + len(self.terms)
        rates[count:end] = rates[count:end] * values.letters[count:end] % p
        known = self._divergence(values)
        if self.weight is not None:
            known = known + rates[end]
        return np.concatenate([rates[:end] * self.scale % p, known[None, :] % p]).T

    def _divergence(self, values: Values) -> Array:
        """div X - tr C at every point, from the slopes of the equations."""
        field, p = self.field, values.p
        still, size = len(field.positions), len(field.variables)
        slopes = motion_slopes(field, values)
        total = sum(slopes[i, i] for i in (*range(self.base), *range(still, size)))
        count = len(field.independent_relations)
        if not count:
            return total
        entries = len(field.entries)
        gradient = values.known[entries:].reshape(count, still, values.points)
        bent = values.known_slopes[entries:].reshape(count, still, size, values.points)
        drift = np.zeros((count, still, values.points), dtype=np.int64)
        for x in range(still):
            pushed = gradient[:, x, None] * slopes[x, :still] % p
            drift = (drift + bent[:, x, :still] * values.motion[x] + pushed) % p
        _, chosen = free_columns(gradient[:, :, 0], p)
        turned, right = gradient[:, chosen].swapaxes(0, 1), drift[:, chosen].swapaxes(0, 1)
        solved, _ = solve_each(turned, right, p)
        return total - sum(solved[i, i] for i in range(count))

    def _density(self, powers: Mapping[int, Any]) -> Any:
        """The density by its powers; factors under roots are positive at some state."""
        named = None if self.field.determinant is None else determinant(self.field.mass)
        parts, exponents = [], []
        for i, a in powers.items():
            if i >= len(self.factors):
                exponents.append(a * self.terms[i - len(self.factors)])
            elif self.factors[i] == named:
                parts.append(self.field.determinant**a)
            elif a != 0:
                f = self.factors[i]
                turned = not isinstance(a, se.Integer) and self._is_negative(f)
                parts.append((-f if turned else f) ** a)
        return se.Mul(*parts, se.exp(se.Add(*exponents)))

    def _is_negative(self, factor: Any) -> bool:
        for _, (value,) in sample_evaluable(Tape([factor]), self.field.hypotheses, count=1):
            return bool(value < 0)
        return False


def _factors(field: VectorField, more: Sequence[Any]) -> list[Any]:
    """The irreducible factors that mass, its minors, rates and forces hold, and what moves in them:
    coordinates, velocities, cosines, sines, roots; the shortest first."""
    size = len(field.mass)
    minors = [determinant([row[:k] for row in field.mass[:k]]) for k in range(1, size + 1)]
    minors += [row[i] for i, row in enumerate(field.mass)]
    exprs = [*field.entries, *minors, *more]
    factors: dict[Any, None] = {}
    for relations in dict.fromkeys((tuple(field.relations), ())):
        ring = ring_over(exprs, relations)
        for g in ring.meaning:
            if g.free_symbols & {*field.variables}:
                factors[g] = None
        for e in exprs:
            element = ring.fraction(e)
            polys = [element.num, *(f for f, _ in ring.field.factors(element.den))]
            for poly in polys:
                if poly != 0 and len(poly) <= TERMS:
                    for factor, _ in irreducible_factors(poly)[1]:
                        factors[ring.polynomial(factor)] = None
    factors |= dict.fromkeys(x for x in field.variables)
    return sorted(factors, key=lambda e: (operations([e]), str(e)))
