"""Linear symmetries of the equations: fields that commute with the motion, and signed permutations.

An affine field Y = B x + b on the variables x takes motions to motions, up to a change of clock,
where [X, Y] = c X [Theory, eq. (34)], which is linear in B, b and c; on relations R between
variables Y(R) = 0 where R = 0.  Solved at random points modulo a prime, it gives all of them for
generic parameters.

A signed permutation A of the variables is a symmetry where X(A x) = A X(x), and a reversor where
X(A x) = -A X(x).  All are tried at a random point modulo a prime, at random parameters.

Whatever is found is proved by the exact algebra: from mass and force, where a symmetry keeps the
mass, else from the accelerations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from math import factorial, prod
from time import perf_counter
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.arguments import accepts
from voronec.algebra.matrices import dot
from voronec.algebra.typeset import html_table, plain_text
from voronec.algebra.verdicts import Verdict
from voronec.declaration.system import System
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit
from voronec.proof.decision import all_zero
from voronec.proof.search.densities import motions_at
from voronec.proof.search.lifting import lift_vector
from voronec.proof.search.probe import Probe, Values, motion_slopes
from voronec.proof.search.rational import RationalFlow
from voronec.proof.search.residues import PRIMES, Array, kernel
from voronec.proof.search.search import specialize_field

SPARE = 12
"""Points beyond the number of unknowns."""
DRAWN = 10**6
"""Parameters are drawn below it."""
MAPS = 100_000
"""So many signed permutations are tried; where there are more, changes of sign alone."""


@dataclass(frozen=True)
class SymmetryField:
    """A field of symmetries: its component at each variable, other components zero, the factor c of
    [X, Y] = c X, and the verdict."""

    components: dict[sp.Expr, sp.Expr]
    clock: sp.Expr
    verdict: Verdict

    def __str__(self) -> str:
        parts = [f"({plain_text(e)}) d/d{x}" for x, e in self.components.items()]
        return " + ".join(parts) + (f", clock {plain_text(self.clock)}" if self.clock != 0 else "")


@dataclass(frozen=True)
class SymmetryMap:
    """A linear map of the variables, by what each becomes; ``reverses`` says whether the time runs
    backwards in the image."""

    images: dict[sp.Expr, sp.Expr]
    reverses: bool
    verdict: Verdict

    def __str__(self) -> str:
        parts = [f"{x} -> {plain_text(e)}" for x, e in self.images.items()]
        return ", ".join(parts) + (", t -> -t" if self.reverses else "")


@dataclass(frozen=True, repr=False)
class SymmetrySearch:
    """The symmetries found: affine ``fields``, a basis for generic parameters, and ``maps`` that
    generate all signed permutations, ``symmetries`` and ``reversors`` in number.

    ``permuted`` says whether permutations were tried, or changes of sign alone.
    """

    system: str
    fields: tuple[SymmetryField, ...]
    maps: tuple[SymmetryMap, ...]
    symmetries: int
    reversors: int
    permuted: bool
    missing: str
    seconds: float

    def __repr__(self) -> str:
        return f"SymmetrySearch({self.system!r}, {len(self.fields)} fields, {len(self.maps)} maps)"

    def _repr_html_(self) -> str:
        """For notebooks: what was found, and the statement."""
        rows = [*(("field", str(f)) for f in self.fields), *(("map", str(m)) for m in self.maps)]
        return html_table(f"symmetries of {self.system}", [*rows, ("statement", self.statement)])

    @property
    def decided(self) -> bool:
        """Whether all that was found is proved."""
        return all(f.verdict.proved for f in (*self.fields, *self.maps))

    @property
    def statement(self) -> str:
        """What was found, in words."""
        form = "signed permutations" if self.permuted else "changes of sign"
        counted = f"{self.symmetries} {form} are symmetries and {self.reversors} are reversors"
        counted = self.missing or counted
        fields = f"{len(self.fields)} independent affine fields take motions to motions"
        return f"{fields}; {counted}."

    def as_dict(self) -> dict[str, Any]:
        """The outcome as text and numbers that JSON can hold."""
        return {
            "system": self.system,
            "fields": [{"field": str(f), "verdict": f.verdict.status} for f in self.fields],
            "maps": [
                {"map": str(m), "reverses": m.reverses, "verdict": m.verdict.status}
                for m in self.maps
            ],
            "symmetries": self.symmetries,
            "reversors": self.reversors,
            "statement": self.statement,
            "seconds": round(self.seconds, 3),
        }


@accepts()
def search_symmetries(
    system: System | VoronecEquations, *, at: Mapping[Any, Any] | None = None, seed: int = 1
) -> SymmetrySearch:
    """Search linear symmetries and reversors of the equations of a system.

    ``at`` gives parameters special values, numbers or functions of others.  The variables are the
    invariants, where the system descends to them, else the coordinates, and the velocities.  What
    is found carries the verdict of the exact algebra.  Raises ``EngineLimit`` for equations that
    hold the time, or are too large.
    """
    begin, motions = perf_counter(), motions_at(system, at or {})
    field, rng = motions.field_for(()), np.random.default_rng(seed)
    if any(field.time in e.free_symbols for e in field.entries):
        raise EngineLimit("equations that hold the time: their symmetries are not searched")
    fields = tuple(_affine_fields(field, rng))
    try:
        group = _Group.of(field, rng)
    except EngineLimit as limit:  # equations that are not rational
        return SymmetrySearch(
            motions.system.name, fields, (), 0, 0, False, f"maps were not tried: {limit}",
            perf_counter() - begin,
        )  # fmt: skip
    maps = tuple(_proved_map(field, group.flow, a) for a in group.generators())
    backward = sum(t < 0 for *_, t in group.elements)
    return SymmetrySearch(
        motions.system.name, fields, maps, len(group.elements) - backward, backward,
        group.permuted, "", perf_counter() - begin,
    )  # fmt: skip


def _affine_fields(field: VectorField, rng: Any) -> Iterator[SymmetryField]:
    """A basis of the affine fields with [X, Y] = c X."""
    slopes = [r.diff(q) for r in field.relations for q in field.positions]
    probe, size = Probe(field, field.variables, [*field.entries, *slopes]), len(field.variables)

    def table(values: Values) -> Array:
        return _commutator_table(field, values)

    for entries in lift_kernel(table, size + 1 + SPARE, probe, rng):
        yield _proved_field(field, entries)


def lift_kernel(
    table: Callable[[Values], Array], points: int, probe: Probe, rng: Any
) -> Iterator[dict[int, Any]]:
    """The vectors that a table of values of a probe takes to zero, by their entries: each is 1 at
    one place, and the others are functions of the parameters."""
    values = probe.one(points, rng)
    vectors, free = kernel(table(values), values.p)
    for vector, place in zip(vectors, free, strict=True):
        support = [int(i) for i in np.flatnonzero(vector) if i != place]

        def solve(values: Values, support: Sequence[int] = support, place: int = place) -> Any:
            found, last = kernel(table(values)[:, [*support, place]], values.p)
            return found[0][:-1] if last == [len(support)] else None

        weights = lift_vector(solve, len(support), probe, rng) if support else []
        yield {place: se.Integer(1), **dict(zip(support, weights, strict=True))}


def _commutator_table(field: VectorField, values: Values) -> Array:
    """X(Y) - Y(X) - c X, and Y(R), at every point, linear in the entries of B, in b and c: an entry
    B_ij stands at i (n + 1) + j, b_i at i (n + 1) + n."""
    p, size, points = values.p, len(field.variables), values.points
    slopes = motion_slopes(field, values)
    ones = np.concatenate([values.letters, np.ones((1, points), dtype=np.int64)])
    moved = np.concatenate([values.motion, np.zeros((1, points), dtype=np.int64)])
    unknown = size * (size + 1) + 1
    gradients = values.known[len(field.entries) :].reshape(-1, len(field.positions), points)
    table = np.zeros((size + len(gradients), unknown, points), dtype=np.int64)
    for i in range(size):
        block = slice(i * (size + 1), (i + 1) * (size + 1))
        table[:size, block] = -slopes[:, i, None] * ones % p
        table[i, block] += moved
        if i < len(field.positions):
            table[size:, block] = gradients[:, i, None] * ones % p
    table[:size, -1] = -values.motion
    return np.moveaxis(table % p, 2, 1).reshape(-1, unknown)


def _proved_field(field: VectorField, entries: Mapping[int, Any]) -> SymmetryField:
    size, variables = len(field.variables), [*field.variables, se.Integer(1)]
    y, clock = [se.Integer(0)] * size, entries.get(size * (size + 1), se.Integer(0))
    for place, weight in entries.items():
        if place < size * (size + 1):
            y[place // (size + 1)] += weight * variables[place % (size + 1)]

    def along(function: Any) -> Any:
        return se.Add(*[c * function.diff(x) for c, x in zip(y, field.variables, strict=True)])

    still = len(field.positions)
    kept = [(f"the relation '{r}'", along(r)) for r in field.relations]
    pushed = dict(zip(field.variables, field.rates, strict=False))
    rates = [
        se.Add(*[rate * c.diff(q) for q, rate in pushed.items()]) - along(rate) - clock * rate
        for c, rate in zip(y, field.rates, strict=False)
    ]
    turn = [[c.diff(v) for v in field.velocities] for c in y[still:]]
    # without the inverse of the mass, where Y changes the mass by a factor
    for factor in dict.fromkeys((se.Integer(0), -2 * clock)):
        mass = [
            along(m) + dot(column, other) + dot(row, back) - factor * m
            for row, column in zip(field.mass, zip(*turn, strict=True), strict=True)
            for m, other, back in zip(
                row, zip(*field.mass, strict=True), zip(*turn, strict=True), strict=True
            )
        ]
        force = [
            along(f) + dot(column, field.force) - (factor - clock) * f
            for f, column in zip(field.force, zip(*turn, strict=True), strict=True)
        ]
        found = all_zero([*kept, *(("", e) for e in (*rates, *mass, *force))], field.hypotheses)
        if found.proved:
            break
    else:
        residuals = [
            (f"the rate of '{x}'", field.derivative(c) - along(rate) - clock * rate)
            for x, c, rate in zip(field.variables, y, field.components, strict=True)
        ]
        found = all_zero([*residuals, *kept], field.hypotheses)
    outward = field.bridge.outward
    shown = {outward(x): outward(c) for x, c in zip(field.variables, y, strict=True) if c != 0}
    return SymmetryField(shown, outward(clock), found)


Element = tuple[tuple[int, ...], tuple[int, ...], int]
"""Of a signed permutation of generators: places, signs, and 1 or -1 for the time."""


@dataclass(frozen=True)
class _Group:
    """Signed permutations of the generators of a flow that take motions to motions."""

    flow: RationalFlow
    elements: tuple[Element, ...]
    permuted: bool

    @classmethod
    def of(cls, field: VectorField, rng: Any) -> _Group:
        held = {s for e in (*field.entries, *field.relations) for s in e.free_symbols}
        numbers = {
            s: sp.Integer(int(rng.integers(2, DRAWN))) for s in field.parameters if s in held
        }
        values = {field.bridge.outward(s): n for s, n in numbers.items()}
        flow, p = RationalFlow(specialize_field(field, values)), PRIMES[0]
        size, start = len(flow.ring.meaning), flow.points(1, p, rng)[:, 0]
        orbit = flow.orbit(start, 2, p)
        if orbit is None or 2**size > MAPS:
            raise EngineLimit(
                "no regular state was found" if orbit is None else "too many variables"
            )
        signs = np.array([*product((1, -1), repeat=size)], dtype=np.int64)
        orders, permuted = _arrangements(flow)
        found: list[Element] = []
        for order in orders:
            images, moved = ((signs * orbit[list(order), k]).T % p for k in (0, 1))
            for time in (1, -1):
                good = ~flow.residuals(images, time * moved % p, p).any(axis=0)
                found += [(order, tuple(map(int, s)), time) for s in signs[good]]
        return cls(flow, tuple(e for e in found if _is_map(flow, e)), permuted)

    def generators(self) -> list[Element]:
        """Elements that generate all, those that move least first."""
        size = len(self.flow.ring.meaning)
        unit = (tuple(range(size)), (1,) * size, 1)
        made, chosen = {unit}, list[Element]()

        def moved(e: Element) -> tuple[int, ...]:
            changed = sum(i != o for i, o in enumerate(e[0]))
            return (changed, sum(s < 0 for s in e[1]), -e[2])

        for element in sorted(self.elements, key=moved):
            if element in made:
                continue
            chosen.append(element)
            grown = [*made]
            while grown:
                grown = [x for a in chosen for b in grown if (x := _compose(a, b)) not in made]
                made.update(grown)
        return chosen


def _compose(a: Element, b: Element) -> Element:
    order = tuple(b[0][i] for i in a[0])
    return order, tuple(s * b[1][i] for s, i in zip(a[1], a[0], strict=True)), a[2] * b[2]


def _arrangements(flow: RationalFlow) -> tuple[list[tuple[int, ...]], bool]:
    """The permutations of generators that are tried: of positions, of velocities, and of angles."""
    ring, field, size = flow.ring, flow.field, len(flow.ring.meaning)
    kinds = [[ring.index(x)] for x in field.positions if ring.has(x) and x not in ring.pairs]
    pairs = [[ring.index(c), ring.index(s)] for c, s in ring.pairs.values()]
    groups = [kinds, pairs, [[ring.index(v)] for v in field.velocities]]
    count = prod(factorial(len(g)) for g in groups) * 2**size
    if count > MAPS:
        return [tuple(range(size))], False
    found = []
    for chosen in product(*(permutations(g) for g in groups)):
        order = list(range(size))
        for group, images in zip(groups, chosen, strict=True):
            for places, targets in zip(group, images, strict=True):
                for i, j in zip(places, targets, strict=True):
                    order[i] = j
        found.append(tuple(order))
    return found, True


def _is_map(flow: RationalFlow, element: Element) -> bool:
    """Whether an angle that stands bare too is mapped as its cosine and sine are."""
    ring, (order, signs, _) = flow.ring, element
    both = [
        (ring.index(a), *map(ring.index, pair)) for a, pair in ring.pairs.items() if ring.has(a)
    ]
    return all(order[c] == c and signs[c] > 0 and signs[q] == signs[s] for q, c, s in both)


def _proved_map(field: VectorField, flow: RationalFlow, element: Element) -> SymmetryMap:
    ring, (order, signs, time) = flow.ring, element
    images: dict[Any, Any] = {}
    for x in field.variables:
        if ring.has(x):
            i = ring.index(x)
            images[x] = signs[i] * ring.meaning[order[i]]
    angles = list(ring.pairs)
    parts = dict(zip(angles, ring.found.angles.values(), strict=True))
    cosines = [ring.index(c) for c, _ in ring.pairs.values()]
    for a, (c, s) in ring.pairs.items():
        other = angles[cosines.index(order[ring.index(c)])]
        up, side = signs[ring.index(c)], signs[ring.index(s)]
        # cos and sin of (w + k pi)/d are those of w/d with their signs
        images.setdefault(a, up * side * other + (se.pi * parts[a] if up < 0 else 0))
    moved = {x: e for x, e in images.items() if e != x}
    targets = [next(iter(images[x].free_symbols)) for x in field.variables]
    factors = [time * images[x].diff(y) for x, y in zip(field.variables, targets, strict=True)]
    places, still = [field.variables.index(y) for y in targets], len(field.positions)
    kept = [(f"the relation '{r}'", r.xreplace(moved)) for r in field.relations]

    def rates(all_rates: Sequence[Any]) -> list[tuple[str, Any]]:
        return [
            (f"the rate of '{x}'", f * all_rates[i] - rate.xreplace(moved))
            for x, f, i, rate in zip(field.variables, factors, places, all_rates, strict=False)
        ]

    # without the inverse of the mass, where the map keeps the mass
    size = range(len(field.velocities))
    sign, at = factors[still:], [i - still for i in places[still:]]
    kinetic = [
        ("", sign[i] * sign[j] * field.mass[i][j].xreplace(moved) - field.mass[at[i]][at[j]])
        for i in size
        for j in size
    ]
    work = [("", sign[i] * field.force[i].xreplace(moved) - field.force[at[i]]) for i in size]
    found = all_zero([*kept, *rates(field.rates), *kinetic, *work], field.hypotheses)
    if not found.proved:
        found = all_zero([*kept, *rates(field.components)], field.hypotheses)
    outward = field.bridge.outward
    shown = {outward(x): outward(e) for x, e in moved.items()}
    return SymmetryMap(shown, time < 0, found)
