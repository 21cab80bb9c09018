"""Other variables of a formulation: momenta in the place of velocities, and relative angles.

With momenta p = M(g) v the equations are p' = force + M' v.  For many bodies that is far shorter
than M v' = force once v is known from p: a rolling ball's is G' = G x omega.  So the rate is
written as

    p_i' = a_i^jk p_j v_k + rest_i

[Theory, eq. (21)]
with numbers a_i^jk such that the rest holds no variable but v; the numbers are the solution of
linear equations, one for each monomial that has to go, and what they give is an identity of normal
forms: a proof.

Relative angles stand in the place of angles that only occur in their differences.  Where the
equations do not change when several angles are moved together, as those of vehicles in
a row on a plane, they hold the angles in certain linear forms alone: theta0 - theta1, theta1 -
theta2.  These are the variables then; of the angles themselves as few stay as others are made of,

    a = N (forms, angles that stay),    N of whole numbers,

and they are quadratures, integrated where an output needs them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, product
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import linear_terms
from voronec.algebra.matrices import dot
from voronec.algebra.normal import canonical, canonical_for_numbers
from voronec.algebra.ring import sparse_terms
from voronec.algebra.roots import ring_over
from voronec.algebra.terms import atoms, rational
from voronec.equations.program import names_into, solve_mass
from voronec.equations.program.straight import fresh_names
from voronec.equations.relative_angles import turn
from voronec.errors import EngineLimit
from voronec.motion.formulation.formulation import Formulation, closure, dependence


def momenta_formulation(formulation: Formulation) -> Formulation | None:
    """The equations in momenta; None where their rates are no shorter so."""
    v, n = formulation.velocities, len(formulation.velocities)
    if not formulation.exact or formulation.stages or not n:
        return None
    if not any(formulation.mass[i][j] != 0 for i, j in product(range(n), repeat=2) if i != j):
        return None  # a diagonal mass gains nothing
    rate = dict(zip(formulation.positions, formulation.rates, strict=True))
    momenta = [dot(row, v) for row in formulation.mass]
    changes = [
        se.Add(f, p.diff(formulation.time), *[p.diff(q) * rate[q] for q in formulation.positions])
        for f, p in zip(formulation.force, momenta, strict=True)
    ]
    try:
        split = _split(changes, momenta, formulation)
    except EngineLimit:
        return None
    if split is None:
        return None
    names = _names(formulation, n)
    rates = [
        se.Add(rest, *[a * names[j] * v[k] for (j, k), a in numbers.items()])
        for numbers, rest in split
    ]
    return replace(
        formulation,
        name="momenta" if formulation.name == "coordinates" else f"{formulation.name} and momenta",
        velocities=tuple(names),
        mass=tuple(tuple(se.Integer(int(i == j)) for j in range(n)) for i in range(n)),
        force=tuple(rates),
        stages=_solution(formulation, names),
        inertia=formulation.mass,
        start={
            **{x: e for x, e in formulation.start.items() if x not in v},
            **{p: e.xreplace(dict(formulation.start)) for p, e in zip(names, momenta, strict=True)},
        },
    )


def _solution(formulation: Formulation, names: Sequence[Any]) -> tuple[tuple[Any, Any], ...]:
    """Stages that give the velocities from the momenta: the mass matrix solved."""
    assignments: list[tuple[Any, Any]] = []
    fresh = fresh_names([*formulation.variables, *formulation.parameters], "w_")
    name = names_into(assignments, fresh)
    solution = solve_mass(
        formulation.mass,
        names,
        name,
        formulation.parameters,
        formulation.relations,
        formulation.positive,
    )
    return (*assignments, *zip(formulation.velocities, solution, strict=True))


def _names(formulation: Formulation, n: int) -> list[Any]:
    """Symbols for the momenta that nothing else is called by."""
    taken = {str(s) for s in (*formulation.variables, *formulation.parameters, *formulation.start)}
    letter = next(x for x in ("G", "p", "G_") if not any(f"{x}{i + 1}" in taken for i in range(n)))
    return [se.Symbol(f"{letter}{i + 1}") for i in range(n)]


def _split(
    changes: Sequence[Any], momenta: Sequence[Any], formulation: Formulation
) -> list[tuple[dict[tuple[int, int], Any], Any]] | None:
    """For each rate: the numbers a^jk that are not zero, and the rest."""
    v = formulation.velocities
    pairs = [(j, k) for j in range(len(v)) for k in range(len(v))]
    products = [momenta[j] * v[k] for j, k in pairs]
    plain = canonical([*changes, *products], formulation.relations)
    ring = ring_over(plain, formulation.relations)
    elements = [ring.fraction(e) for e in plain]
    if any(e.den for e in elements[len(changes) :]):
        return None
    moving = [i for i, g in enumerate(ring.meaning) if g.free_symbols & set(formulation.positions)]
    columns = [_terms(e.num, moving) for e in elements[len(changes) :]]
    splits: list[tuple[dict[tuple[int, int], Any], Any]] = []
    for element, change in zip(elements, changes, strict=False):
        if element.den:
            return None
        numbers = _solve(_terms(element.num, moving), columns)
        if numbers is None:
            return None
        chosen = {pair: a for pair, a in zip(pairs, numbers, strict=True) if a != 0}
        rest = change - se.Add(*[a * products[pairs.index(jk)] for jk, a in chosen.items()])
        splits.append((chosen, canonical_for_numbers([rest], formulation.form)[0]))
    return splits


def _terms(poly: Any, moving: Sequence[int]) -> dict[Any, Any]:
    """The terms that hold a position."""
    held = set(moving)
    return {m: c for m, c in sparse_terms(poly).items() if any(i in held for i, _ in m)}


def _solve(right: dict[Any, Any], columns: Sequence[dict[Any, Any]]) -> list[Any] | None:
    """Numbers with which the columns sum up to the right side, as few as elimination finds."""
    rows = sorted({m for c in (*columns, right) for m in c})
    if not rows:
        return [se.Integer(0)] * len(columns)
    width = len(columns)
    zero = flint.fmpq(0)
    table = flint.fmpq_mat(
        len(rows), width + 1, [c.get(m, zero) for m in rows for c in (*columns, right)]
    )
    reduced, rank = table.rref()
    numbers = [se.Integer(0)] * width
    for i in range(rank):
        pivot = next(j for j in range(width + 1) if reduced[i, j] != 0)
        if pivot == width:
            return None
        value = reduced[i, width]
        numbers[pivot] = rational(value)
    return numbers


_Form = tuple[int, ...]
"""The whole numbers by which angles stand in a linear form."""


def relative_formulation(formulation: Formulation) -> Formulation | None:
    """The equations in relative angles; None where the velocities' equations change with a
    common shift of the angles, or have no normal form."""
    if (
        not formulation.exact
        or formulation.stages
        or formulation.system.charts
        or not _hints(formulation)
    ):
        return None
    try:
        change = _relative_angles(formulation)
        return None if change is None else _rewrite_formulation(formulation, *change)
    except EngineLimit:
        return None


def _hints(formulation: Formulation) -> bool:
    """Whether a normal form holds the sine or the cosine of several angles at once: only then are
    others looked at."""
    exprs = [*formulation.force, *(e for row in formulation.mass for e in row)]
    positions = {*formulation.positions}
    turned = (node.args[0] for node in atoms(exprs, se.sin, se.cos))
    return any(len(argument.free_symbols & positions) > 1 for argument in turned)


def _relative_angles(formulation: Formulation) -> tuple[dict[Any, Any], dict[Any, Any]] | None:
    """New variables in terms of the angles, and the angles in terms of new variables and of those
    that stay."""
    core = closure(dependence(formulation), formulation.velocities)
    rates = [r for q, r in zip(formulation.positions, formulation.rates, strict=True) if q in core]
    masses = [e for row in formulation.mass for e in row]
    angles, forms = _linear_forms(
        [*rates, *formulation.force, *masses],
        [q for q in formulation.positions if q in core],
    )
    basis = _independent([form for form, _ in forms.most_common()])
    if len(basis) in (0, len(angles)) or all(sum(map(bool, form)) < 2 for form in basis):
        return None
    for kept in combinations(range(len(angles)), len(angles) - len(basis)):
        rows = [*basis, *(tuple(int(i == k) for i in range(len(angles))) for k in kept)]
        square = flint.fmpz_mat(list(map(list, rows)))
        if abs(int(square.det())) == 1:
            names = [dot(form, angles) for form in basis]
            # a form that is one angle is that angle, another a variable called by the form
            fresh = {e if e.is_Symbol else se.Symbol(str(e)): e for e in names}
            variables = [*fresh, *(angles[k] for k in kept)]
            inverse = square.inv()
            turned = {
                q: dot([int(inverse[i, j].p) for j in range(len(angles))], variables)
                for i, q in enumerate(angles)
                if i not in kept and q not in fresh  # a form that is one angle stays it
            }
            return fresh, turned
    return None


def _linear_forms(exprs: Iterable[Any], among: Sequence[Any]) -> tuple[list[Any], Counter[_Form]]:
    """Those of the variables that stand under sines and cosines only, in whole multiples, and the
    linear forms in which they stand there, counted."""
    arguments, bare = Counter[Any](), set[Any]()
    for expr in exprs:
        waiting, seen = [expr], set[Any]()
        while waiting:
            node = waiting.pop()
            if isinstance(node, (se.sin, se.cos)):
                arguments[node.args[0]] += 1
            elif node.is_Symbol:
                bare.add(node)
            elif node not in seen:
                seen.add(node)
                waiting.extend(node.args)
    angles = [q for q in among if q not in bare]
    while True:
        terms = {a: linear_terms(a) for a in arguments if a.free_symbols & {*angles}}
        mixed = set().union(*(a.free_symbols for a, t in terms.items() if not _whole(t, angles)))
        if not mixed & {*angles}:
            break
        angles = [q for q in angles if q not in mixed]
    forms = Counter[_Form]()
    for argument, multiples in terms.items():
        form = tuple(int(multiples.get(q, 0)) for q in angles)
        sign = next(x for x in form if x) // abs(next(x for x in form if x))
        forms[tuple(sign * x for x in form)] += arguments[argument]
    return angles, forms


def _whole(terms: Mapping[Any, Any], angles: Sequence[Any]) -> bool:
    """Whether a sum is one of whole multiples of angles."""
    return all(q in angles and isinstance(c, se.Integer) for q, c in terms.items())


def _independent(forms: Iterable[_Form]) -> list[_Form]:
    """As many of the forms as are independent, the first ones first."""
    independent: list[_Form] = []
    for form in forms:
        if flint.fmpz_mat([list(f) for f in (*independent, form)]).rank() > len(independent):
            independent.append(form)
    return independent


def _rewrite_formulation(
    formulation: Formulation, fresh: Mapping[Any, Any], turned: Mapping[Any, Any]
) -> Formulation:
    """The formulation in new variables: ``fresh`` as forms in the angles, ``turned`` the angles
    that are given up, in the new ones."""
    rate = dict(zip(formulation.positions, formulation.rates, strict=True))
    new = [x for x in fresh if x not in rate]
    kept = [q for q in formulation.positions if q not in turned]
    forms = [fresh[x] for x in new]
    moving = [se.Add(*[e.diff(q) * rate[q] for q in e.free_symbols]) for e in forms]
    moving += [rate[q] for q in kept]
    # mass and force are short already, and stand in the forms
    return replace(
        formulation,
        name="coordinates with relative angles",
        positions=(*new, *kept),
        rates=tuple(canonical_for_numbers([turn(e, turned) for e in moving], formulation.form)),
        force=tuple(turn(e, turned) for e in formulation.force),
        mass=tuple(tuple(turn(e, turned) for e in row) for row in formulation.mass),
        start={**formulation.start, **{x: fresh[x] for x in new}},
        outputs={name: _plain(e, turned, formulation) for name, e in formulation.outputs.items()},
        integrals={
            name: _plain(e, turned, formulation) for name, e in formulation.integrals.items()
        },
    )


def _plain(expr: Any, turned: Mapping[Any, Any], formulation: Formulation) -> Any:
    """A function in the new variables, without those that it holds in vain."""
    if not turned.keys() & expr.free_symbols:
        return expr
    moved = turn(expr, turned)
    try:
        normal = canonical_for_numbers([moved], formulation.form)[0]
    except EngineLimit:
        return moved
    return normal if normal.free_symbols < moved.free_symbols else moved
