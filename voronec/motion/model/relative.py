"""Relative angles in the place of angles that only occur in their differences.

Where the equations do not change when several angles are moved together, as those of vehicles in
a row on a plane, they hold the angles in certain linear forms alone: theta0 - theta1, theta1 -
theta2.  These are the variables then; of the angles themselves as few stay as others are made of,

    a = N (forms, angles that stay),    N of whole numbers,

and they are quadratures, integrated where an output needs them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import flint
import symengine as se

from voronec.algebra.generators import linear_terms
from voronec.algebra.matrices import dot
from voronec.algebra.normal import canonical, shortest
from voronec.errors import EngineLimit
from voronec.motion.model.level import Level, closure, dependence

__all__ = ["relative_level"]

_Form = tuple[int, ...]
"""The whole numbers by which angles stand in a linear form."""


def relative_level(level: Level) -> Level | None:
    """The same equations in relative angles; None where the velocities' equations change with a
    common shift of the angles, or have no normal form."""
    if not level.exact or level.stages or level.system.charts or not _hints(level):
        return None
    try:
        found = _relative_angles(level)
        return None if found is None else _rewrite_level(level, *found)
    except EngineLimit:
        return None


def _hints(level: Level) -> bool:
    """Whether a normal form holds the sine or the cosine of several angles at once: only then are
    others looked at."""
    exprs = [*level.force, *(e for row in level.mass for e in row)]
    own = {*level.positions}
    turned = (node.args[0] for e in exprs for node in e.atoms(se.sin, se.cos))
    return any(len(argument.free_symbols & own) > 1 for argument in turned)


def _relative_angles(level: Level) -> tuple[dict[Any, Any], dict[Any, Any]] | None:
    """New variables in terms of the angles, and the angles in terms of new variables and of those
    that stay."""
    core = closure(dependence(level), level.velocities)
    rates = [r for q, r in zip(level.positions, level.rates, strict=True) if q in core]
    masses = [e for row in level.mass for e in row]
    angles, forms = _linear_forms(
        shortest([*rates, *level.force, *masses], level.relations),
        [q for q in level.positions if q in core],
    )
    basis = _independent([form for form, _ in forms.most_common()])
    if len(basis) in (0, len(angles)) or all(sum(map(bool, form)) < 2 for form in basis):
        return None
    for kept in combinations(range(len(angles)), len(angles) - len(basis)):
        rows = [*basis, *(tuple(int(i == k) for i in range(len(angles))) for k in kept)]
        square = flint.fmpz_mat(list(map(list, rows)))
        if abs(int(square.det())) == 1:
            names = [dot(form, angles) for form in basis]
            fresh = {_variable_of(e): e for e in names}
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
    for argument, found in terms.items():
        form = tuple(int(found.get(q, 0)) for q in angles)
        sign = next(x for x in form if x) // abs(next(x for x in form if x))
        forms[tuple(sign * x for x in form)] += arguments[argument]
    return angles, forms


def _whole(terms: Mapping[Any, Any], angles: Sequence[Any]) -> bool:
    """Whether a sum is one of whole multiples of angles."""
    return all(q in angles and isinstance(c, se.Integer) for q, c in terms.items())


def _independent(forms: Iterable[_Form]) -> list[_Form]:
    """As many of the forms as are independent, the first ones first."""
    found: list[_Form] = []
    for form in forms:
        if flint.fmpz_mat([list(f) for f in (*found, form)]).rank() > len(found):
            found.append(form)
    return found


def _variable_of(form: Any) -> Any:
    """The variable that a linear form is: of one angle that angle, else one called by the form."""
    return form if form.is_Symbol else se.Symbol(str(form))


def _rewrite_level(level: Level, fresh: Mapping[Any, Any], turned: Mapping[Any, Any]) -> Level:
    """The level in new variables: ``fresh`` as forms in the angles, ``turned`` the angles that are
    given up, in the new ones."""
    rate = dict(zip(level.positions, level.rates, strict=True))
    new = [x for x in fresh if x not in rate]
    kept = [q for q in level.positions if q not in turned]
    moving = [_form_rate(fresh[x], rate) for x in new] + [rate[q] for q in kept]
    width = len(level.velocities)
    flat = [*moving, *level.force, *(e for row in level.mass for e in row)]
    flat = canonical([e.xreplace(dict(turned)) for e in flat], level.relations)
    rows = flat[len(moving) + width :]
    return replace(
        level,
        name="coordinates with relative angles",
        positions=(*new, *kept),
        rates=tuple(flat[: len(moving)]),
        force=tuple(flat[len(moving) : len(moving) + width]),
        mass=tuple(tuple(rows[i * width : (i + 1) * width]) for i in range(width)),
        start={**level.start, **{x: fresh[x] for x in new}},
        outputs={name: _plain(e, turned, level) for name, e in level.outputs.items()},
        integrals={name: _plain(e, turned, level) for name, e in level.integrals.items()},
    )


def _form_rate(form: Any, rate: Mapping[Any, Any]) -> Any:
    """The rate of a linear form."""
    return se.Add(*[form.diff(q) * rate[q] for q in form.free_symbols])


def _plain(expr: Any, turned: Mapping[Any, Any], level: Level) -> Any:
    """A function in the new variables, without those that it holds in vain."""
    if not turned.keys() & expr.free_symbols:
        return expr
    moved = expr.xreplace(dict(turned))
    try:
        return canonical([moved], level.relations)[0]
    except EngineLimit:
        return moved
