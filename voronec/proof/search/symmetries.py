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

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from math import factorial, prod
from time import perf_counter
from typing import Any

import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.arguments import COUNT, VALUES, accepts
from voronec.algebra.matrices import dot
from voronec.algebra.typeset import html_table, plain_text
from voronec.algebra.verdicts import Verdict
from voronec.declaration.system import System
from voronec.equations.vector_field import VectorField
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit
from voronec.proof.decision import all_zero
from voronec.proof.search.densities import motions_at
from voronec.proof.search.lifting import SURPLUS, lift_kernel
from voronec.proof.search.outcome import plain_data
from voronec.proof.search.probe import Probe, Values, motion_slopes
from voronec.proof.search.rational import RationalFlow
from voronec.proof.search.residues import PRIMES, Array
from voronec.proof.search.search import specialize_field

LARGEST = 10**6
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


@dataclass(frozen=True)
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

    def _repr_html_(self) -> str:
        """For notebooks: what was found, and the statement."""
        rows = [*(("field", str(f)) for f in self.fields), *(("map", str(m)) for m in self.maps)]
        return html_table(f"symmetries of {self.system}", [*rows, ("statement", self.statement)])

    @property
    def is_decided(self) -> bool:
        """Whether all that was found is proved."""
        fields = all(f.verdict.proved for f in self.fields)
        return fields and all(m.verdict.proved for m in self.maps)

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
        texts = {"fields": [*map(str, self.fields)], "maps": [*map(str, self.maps)]}
        return {
            **plain_data(self),
            **texts,
            "decided": self.is_decided,
            "statement": self.statement,
        }


@accepts(at=VALUES, seed=COUNT)
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
    field, rng = motions.field_for(()), np.random.default_rng(abs(seed))
    if any(field.time in e.free_symbols for e in field.entries):
        raise EngineLimit("equations that hold the time: their symmetries are not searched")
    fields = tuple(_affine_fields(field, rng))
    maps: tuple[SymmetryMap, ...] = ()
    times, permuted, missing = list[int](), False, ""
    try:
        flow, elements, permuted = _group(field, rng)
        maps = tuple(_proved_map(field, flow, a) for a in _generators(elements))
        times = [time for *_, time in elements]
    except EngineLimit as limit:  # equations that are not rational
        missing = f"maps were not tried: {limit}"
    name, forward = motions.system.name, times.count(1)
    backward, seconds = len(times) - forward, perf_counter() - begin
    return SymmetrySearch(name, fields, maps, forward, backward, permuted, missing, seconds)


def _affine_fields(field: VectorField, rng: Any) -> Iterator[SymmetryField]:
    """A basis of the affine fields with [X, Y] = c X."""
    slopes = [r.diff(q) for r in field.relations for q in field.positions]
    probe, size = Probe(field, field.variables, [*field.entries, *slopes]), len(field.variables)

    def table(values: Values) -> Array:
        return _commutator_table(field, values)

    for entries in lift_kernel(table, size + 1 + SURPLUS, probe, rng):
        yield _proved_field(field, entries)


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


def _equations(field: VectorField, slopes: Sequence[Any]) -> list[Any]:
    """What vanishes along the motion, in the variables and their slopes."""
    moved = slopes[len(field.positions) :]
    rates = [d - e for d, e in zip(slopes, field.rates, strict=False)]
    return rates + [dot(m, moved) - f for m, f in zip(field.mass, field.force, strict=True)]


def _vanish(field: VectorField, residuals: Sequence[Any]) -> Verdict:
    return all_zero([("", e) for e in residuals], field.hypotheses)


def _proved_field(field: VectorField, entries: Mapping[int, Any]) -> SymmetryField:
    size, variables = len(field.variables), [*field.variables, se.Integer(1)]
    y, clock = [se.Integer(0)] * size, entries.get(size * (size + 1), se.Integer(0))
    for place, weight in entries.items():
        if place < size * (size + 1):
            y[place // (size + 1)] += weight * variables[place % (size + 1)]

    def along(function: Any) -> Any:
        return se.Add(*[c * function.diff(x) for c, x in zip(y, field.variables, strict=True)])

    turn = [[c.diff(x) for x in field.variables] for c in y]
    slopes = [se.Symbol(f"slope {i}") for i in range(size)]
    pushed = [dot(row, slopes) - clock * d for row, d in zip(turn, slopes, strict=True)]

    def prolong(row: Any) -> Any:
        """The change of an equation between the variables and their slopes."""
        return along(row) + dot(pushed, [row.diff(d) for d in slopes])

    still, kept = len(field.positions), [along(r) for r in field.relations]
    verdict = Verdict("undecided", "")
    # where Y changes the mass by a factor, no inverse of it is needed
    for factor in dict.fromkeys((se.Integer(0), -2 * clock)):
        rows = _equations(field, slopes)
        back = [*zip(*turn[still:], strict=True)][still:]  # the transposed matrix of the velocities
        residuals = [
            prolong(e) - dot(row[:still], rows[:still]) + clock * e
            for e, row in zip(rows[:still], turn, strict=False)
        ]
        residuals += [
            prolong(e) + dot(row, rows[still:]) - (factor - clock) * e
            for e, row in zip(rows[still:], back, strict=True)
        ]
        verdict = verdict if verdict.proved else _vanish(field, [*kept, *residuals])
    if not verdict.proved:
        rows = [d - e for d, e in zip(slopes, field.components, strict=True)]
        changes = zip(rows, turn, strict=True)
        residuals = [prolong(e) - dot(gradient, rows) + clock * e for e, gradient in changes]
        verdict = _vanish(field, [*kept, *residuals])
    outward = field.bridge.outward
    shown = {outward(x): outward(c) for x, c in zip(field.variables, y, strict=True) if c != 0}
    return SymmetryField(shown, outward(clock), verdict)


Element = tuple[tuple[int, ...], tuple[int, ...], int]
"""Of a signed permutation of generators: places, signs, and 1 or -1 for the time."""


def _group(field: VectorField, rng: Any) -> tuple[RationalFlow, list[Element], bool]:
    """The signed permutations of the generators of a flow that take motions to motions, and whether
    more than changes of sign were tried."""
    held = {s for e in (*field.entries, *field.relations) for s in e.free_symbols}
    drawn = {s: int(rng.integers(2, LARGEST)) for s in field.parameters if s in held}
    values = {field.bridge.outward(s): sp.Integer(n) for s, n in drawn.items()}
    flow, p = RationalFlow(specialize_field(field, values)), PRIMES[0]
    size = len(flow.generators)
    if 2**size > MAPS:
        raise EngineLimit(f"there are {size} variables")
    orbit = [series[:, 0] for series in flow.orbit(1, p, rng)]
    signs = np.array([*product((1, -1), repeat=size)], dtype=np.int64)
    orders, elements = _arrangements(flow), list[Element]()
    for order in orders:
        images, moved = ((signs * part[list(order)]).T % p for part in orbit)
        for time in (1, -1):
            good = ~flow.residuals(images, time * moved % p, p).any(axis=0)
            elements += [(order, tuple(map(int, s)), time) for s in signs[good]]
    return flow, [e for e in elements if _is_map(flow, e)], len(orders) > 1


def _generators(elements: Sequence[Element]) -> list[Element]:
    """Elements that generate all, those that move least first."""

    def extent(e: Element) -> tuple[int, ...]:
        return (sum(i != o for i, o in enumerate(e[0])), sum(s < 0 for s in e[1]), -e[2])

    unit, *rest = sorted(elements, key=extent)
    made, chosen = {unit}, list[Element]()
    for element in rest:
        if element not in made:
            chosen.append(element)
            grown = [*made]
            while grown:
                grown = [x for a in chosen for b in grown if (x := _compose(a, b)) not in made]
                made.update(grown)
    return chosen


def _compose(a: Element, b: Element) -> Element:
    order = tuple(b[0][i] for i in a[0])
    return order, tuple(s * b[1][i] for s, i in zip(a[1], a[0], strict=True)), a[2] * b[2]


def _arrangements(flow: RationalFlow) -> list[tuple[int, ...]]:
    """The permutations of generators that are tried: of positions, of angles, of velocities; where
    they are too many, the identity."""
    place, field, size = flow.place, flow.field, len(flow.generators)
    plain = [(place[x],) for x in field.positions if x in place and x not in flow.pairs]
    pairs = [(place[c], place[s]) for c, s in flow.pairs.values()]
    groups: list[list[tuple[int, ...]]] = [
        [*plain],
        [*pairs],
        [(place[v],) for v in field.velocities],
    ]
    if prod(factorial(len(g)) for g in groups) * 2**size > MAPS:
        return [tuple(range(size))]
    places, orders = [i for group in groups for one in group for i in one], []
    for chosen in product(*map(permutations, groups)):
        moved = dict(
            zip(places, [i for group in chosen for one in group for i in one], strict=True)
        )
        orders.append(tuple(moved.get(i, i) for i in range(size)))
    return orders


def _is_map(flow: RationalFlow, element: Element) -> bool:
    """Whether an angle that stands bare too is mapped as its cosine and sine are."""
    place, (order, signs, _) = flow.place, element
    both = [(place[a], place[c], place[s]) for a, (c, s) in flow.pairs.items() if a in place]
    return all(order[c] == c and signs[c] > 0 and signs[q] == signs[s] for q, c, s in both)


def _proved_map(field: VectorField, flow: RationalFlow, element: Element) -> SymmetryMap:
    place, (order, signs, time) = flow.place, element
    images: dict[Any, Any] = {
        x: signs[place[x]] * flow.generators[order[place[x]]] for x in field.variables if x in place
    }
    angles = {place[c]: a for a, (c, _) in flow.pairs.items()}
    for a, (c, s) in flow.pairs.items():
        up, side, turn = signs[place[c]], signs[place[s]], a / c.args[0]
        # cos and sin of (w + k pi)/d are those of w/d with their signs
        images.setdefault(a, up * side * angles[order[place[c]]] + (se.pi * turn if up < 0 else 0))
    moved = {x: e for x, e in images.items() if e != x}
    targets = [next(iter(images[x].free_symbols)) for x in field.variables]
    factors = [time * images[x].diff(y) for x, y in zip(field.variables, targets, strict=True)]
    places = [field.variables.index(y) for y in targets]
    slopes = [se.Symbol(f"slope {i}") for i in range(len(targets))]
    turned = dict(
        zip(slopes, [f * slopes[i] for f, i in zip(factors, places, strict=True)], strict=True)
    )
    kept = [r.xreplace(moved) for r in field.relations]
    solved = (d - e for d, e in zip(slopes, field.components, strict=True))
    verdict = Verdict("undecided", "")
    for rows in (_equations(field, slopes), solved):  # where the mass is kept, without its inverse
        rows = [*rows]
        residuals = [
            e.xreplace({**moved, **turned}) - f * rows[i]
            for e, f, i in zip(rows, factors, places, strict=True)
        ]
        verdict = verdict if verdict.proved else _vanish(field, [*kept, *residuals])
    outward = field.bridge.outward
    shown = {outward(x): outward(e) for x, e in moved.items()}
    return SymmetryMap(shown, time < 0, verdict)
