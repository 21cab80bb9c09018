"""What a formula claims to be equal: pairs of values, for all values of its free indices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import sympy as sp

from voronec.algebra.symbols import time
from voronec.algebra.verdicts import prove_equal
from voronec.audit.display import Check
from voronec.audit.hooks import call_hook
from voronec.audit.latex.nodes import Chain, Integral
from voronec.audit.latex.tokens import Misprint, Unfamiliar
from voronec.audit.meaning import evaluate, rate
from voronec.audit.structure import integrand, names_constant, new_names, whole_name
from voronec.audit.study import Study
from voronec.audit.transcript import assignments
from voronec.errors import DefinitionError


@dataclass(frozen=True)
class FormulaComparison:
    """Two values that a formula claims to be equal, and for which indices.

    ``relations`` vanish along the motion, besides those of the study; ``free`` is what an equation
    of motion says must vanish, before anything is put in for accelerations.
    """

    left: Any
    right: Any
    where: dict[str, int]
    about: str = ""
    relations: tuple[Any, ...] = ()
    free: Any = None


def comparisons(chain: Chain, check: Check, study: Study) -> Iterator[FormulaComparison]:
    """The values to be compared, one pair at a time."""
    for where in assignments(chain, study):
        if check.stationary:
            yield from _stationary(chain, check, study, where)
        elif check.truth is not None:
            yield _equation(chain, check, study, where)
        elif check.value is not None:
            derived = call_hook(check.value, study, where)
            derived = study.motion.restrict(derived).xreplace(dict(study.given))
            for part in chain.parts:
                yield from _componentwise(value_of(part, study, where), derived, where)
        else:
            yield from _identities(chain, check, study, where)


def value_of(node: Any, study: Study, where: dict[str, int]) -> Any:
    """The value of a part of a formula on the constraints, under the conditions in force."""
    value = study.motion.restrict(evaluate(node, study, where))
    return value.xreplace(dict(study.given)) if study.given else value


def _identities(
    chain: Chain, check: Check, study: Study, where: dict[str, int]
) -> Iterator[FormulaComparison]:
    """Neighbouring parts must be equal; a part that is "const" must not change in time."""
    for group in _equalities(chain):
        # Only a definition may introduce a name; elsewhere an unknown one is an error.
        new = new_names(group, study) if check.role == "definition" else set[str]()
        yield from _equal_parts(group, study, where, new)


def _equal_parts(
    chain: Chain, study: Study, where: dict[str, int], new: set[str]
) -> Iterator[FormulaComparison]:
    if any(isinstance(p, Integral) and p.upper is None for p in chain.parts):
        rates = [study.motion.along(rate(p, study, where)) for p in chain.parts]
        for left, right in pairwise(rates):
            yield from _componentwise(left, right, where, "derivative along the motion")
        return
    spoken = [p for p in chain.parts if not names_constant(p)]
    known = [p for p in spoken if whole_name(p, study) not in new]
    # What is claimed of accelerations is claimed along the motion.
    given = dict(study.given)
    values = [study.motion.along(value_of(p, study, where)).xreplace(given) for p in known]
    # What is on the left is most often the quantity, and what is on the right its printed value.
    for left, right in pairwise(values):
        yield from _componentwise(right, left, where)
    if len(spoken) < len(chain.parts):
        if not values:
            raise DefinitionError("nothing is said of the constant")
        change = study.motion.along(study.motion.derivative(values[0]))
        change = change.xreplace(given)
        yield from _componentwise(change * 0, change, where, "derivative along the motion")


def _equalities(chain: Chain) -> list[Chain]:
    """The stretches of a chain such as a > b = c in which the relation is equality."""
    groups = [[chain.parts[0]]]
    for relation, part in zip(chain.relations, chain.parts[1:], strict=True):
        if relation == "=":
            groups[-1].append(part)
        else:
            groups.append([part])
    return [Chain(tuple(g), ("=",) * (len(g) - 1), chain.at) for g in groups if len(g) > 1]


def _only_equalities(chain: Chain) -> None:
    for relation in chain.relations:
        if relation != "=":
            raise Misprint(f"the relation '{relation}' cannot stand in an equation of motion")


def _componentwise(
    left: Any, right: Any, where: dict[str, int], about: str = ""
) -> Iterator[FormulaComparison]:
    left, right = as_vectors(left, right)
    if isinstance(left, sp.MatrixBase) != isinstance(right, sp.MatrixBase):
        raise Misprint("a vector is set equal to a number")
    if not isinstance(left, sp.MatrixBase):
        yield FormulaComparison(left, right, where, about)
        return
    columns = left.shape[1]
    for position, (a, b) in enumerate(zip(left, right, strict=True)):
        row, column = divmod(position, columns)
        place = f"component {row + 1}" if columns == 1 else f"entry ({row + 1}, {column + 1})"
        yield FormulaComparison(a, b, where, f"{place} {about}".strip())


def as_vectors(left: Any, right: Any) -> tuple[Any, Any]:
    """The number zero stands for the zero vector too."""
    if isinstance(left, sp.MatrixBase) and right == 0:
        return left, left * 0
    if isinstance(right, sp.MatrixBase) and left == 0:
        return right * 0, right
    return left, right


def _equation(chain: Chain, check: Check, study: Study, where: dict[str, int]) -> FormulaComparison:
    _only_equalities(chain)
    if len(chain.parts) != 2:
        raise Unfamiliar("an equation of motion has two sides, one '=' between them")
    left, right = (value_of(part, study, where) for part in chain.parts)
    truth = call_hook(check.truth, study, where) if check.truth else sp.Integer(0)
    return _along_the_motion((left, right), truth, study, where)


def _along_the_motion(
    sides: tuple[Any, Any], truth: Any, study: Study, where: dict[str, int], about: str = ""
) -> FormulaComparison:
    """Both sides with the accelerations of the motion; of those that are not known, one is the one
    with which the derived expression vanishes."""
    motion, given = study.motion, dict(study.given)
    truth = motion.along(truth).xreplace(given)
    solved: dict[Any, Any] = {}
    for dot in accelerations(study):
        slope = sp.diff(truth, dot)
        if slope != 0 and not slope.has(dot) and prove_equal(slope, 0).refuted:
            solved = {dot: -truth.xreplace({dot: sp.Integer(0)}) / slope}
            break
    rest = () if solved or prove_equal(truth, 0, study.relations).proved else (truth,)
    # As in an identity, what is on the right is most often what is printed.
    left, right = (motion.along(side).xreplace(given).xreplace(solved) for side in sides)
    said = f"{about} along the motion".strip()
    return FormulaComparison(right, left, where, said, rest, sides[0] - sides[1])


def accelerations(study: Study) -> tuple[Any, ...]:
    """The symbols of accelerations: rates of velocities, which have no rate themselves."""
    rates = study.motion.rates
    return tuple(d for d in rates.values() if d.is_Symbol and d not in rates)


def _stationary(
    chain: Chain, check: Check, study: Study, where: dict[str, int]
) -> Iterator[FormulaComparison]:
    """Integration by parts: the coefficient of each independent variation must vanish along the
    motion."""
    integral = next(p for p in chain.parts if isinstance(p, Integral))
    if check.truth is None:
        raise DefinitionError("a stationary principle needs a truth")
    variable, body = integrand(integral)
    if evaluate(variable, study, where) != time:
        raise Misprint("the integral of a principle runs over the time")
    value = study.motion.restrict(evaluate(body, study, where))
    letter = next(iter(study.indices), "i")
    free = [d for d in study.variations.values() if d in study.motion.rates]
    for position, variation in enumerate(free):
        rate = study.motion.rates[variation]
        euler = sp.diff(value, variation) - study.motion.derivative(sp.diff(value, rate))
        number = {**where, letter: position + 1}
        about = "coefficient of the variation"
        truth = call_hook(check.truth, study, number)
        yield _along_the_motion((sp.Integer(0), euler), truth, study, number, about)
