"""Equality with three answers: proved, refuted with a witness, undecided."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import Any

import flint
import symengine as se
import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.logic.boolalg import Boolean

from voronec.algebra.arguments import SEVERAL, accepts
from voronec.algebra.composition import angles_of, are_equal, fold_angles
from voronec.algebra.conditions import condition, split_hypotheses
from voronec.algebra.door import Door
from voronec.algebra.field import WORK_LIMIT
from voronec.algebra.generators import linear_terms
from voronec.algebra.points import sample_evaluable
from voronec.algebra.roots import domain_conditions, ring_over
from voronec.algebra.symbols import plain_name
from voronec.algebra.tape import Tape
from voronec.algebra.text import as_expression, quote
from voronec.algebra.typeset import html_table
from voronec.algebra.witnesses import Search
from voronec.errors import DefinitionError, EngineLimit

__all__ = [
    "Verdict",
    "Witness",
    "all_vanish",
    "decide_equal",
    "decide_zero",
    "prove_equal",
    "witness_at",
]

DIGITS = 30
NO_POINT = "no point was found at which both sides have real values"
PROOF_LIMIT = 20_000_000
"""The work a proof may cost: more than a normal form, since nothing has to be written out."""
LONG_SUM, MOST_LONG = 8, 12
"""Terms of an angle whose sine would have some 2^9 terms, and how many angles are looked at."""


@dataclass(frozen=True)
class Witness:
    """A point at which two expressions differ, and their values there to 30 digits."""

    point: dict[str, str]
    left: str
    right: str

    def __str__(self) -> str:
        at = ", ".join(f"{name} = {value}" for name, value in self.point.items())
        return f"{self.left} against {self.right} at {at}"


@dataclass(frozen=True)
class Verdict:
    """The answer to "are these equal?".

    ``status`` is ``proved`` (the difference is zero in an exact normal form), ``refuted`` (with a
    ``witness``: ball arithmetic separates the two sides) or ``undecided``.  ``method`` says how,
    and for an undecided question what the numbers suggest.  A proof about motions may stand up to
    multiples of a period, ``modulo``, and where a ``domain`` bounds what is real.
    """

    status: str
    method: str
    witness: Witness | None = None
    modulo: str = ""
    domain: str = ""

    @property
    def limits(self) -> str:
        """The period and the domain of a proof, in words."""
        period = f"up to multiples of {self.modulo}" if self.modulo else ""
        return " ".join(filter(None, (period, f"where {self.domain}" if self.domain else "")))

    @property
    def proved(self) -> bool:
        """Whether equality is proved."""
        return self.status == "proved"

    @property
    def refuted(self) -> bool:
        """Whether equality is refuted by a witness."""
        return self.status == "refuted"

    @property
    def undecided(self) -> bool:
        """Whether the question stays open."""
        return self.status == "undecided"

    def _repr_html_(self) -> str:
        """For notebooks: the answer, how it was found, and the witness."""
        rows = [("how", self.method), ("with the proviso", self.limits)]
        if self.witness is not None:
            rows += [(name, value) for name, value in self.witness.point.items()]
            rows += [("left side there", self.witness.left), ("right side", self.witness.right)]
        return html_table(self.status, rows)

    def __bool__(self) -> bool:
        raise TypeError("a verdict has three values; ask .proved, .refuted or .undecided")


@accepts(relations=SEVERAL)
def prove_equal(a: Any, b: Any = 0, relations: Sequence[Any] = ()) -> Verdict:
    """Decide whether two SymPy expressions are equal wherever both are defined.

    ``relations`` are expressions that vanish, or conditions, as x > 0.  Symbols are real numbers
    with the signs that SymPy knows; unknown functions stand for arbitrary ones, and a square root
    for its non-negative value.  Never "equal up to 1e-6": see ``Verdict``.
    """
    door = Door()
    a, b = as_expression(a), as_expression(b)
    if a == b:
        if a.has(*_NO_NUMBERS):
            return Verdict("undecided", f"'{quote(a)}' has no value that could be equal to another")
        return Verdict("proved", "identical expressions")
    try:
        single = isinstance(relations, str) or not isinstance(relations, Iterable)
        ideal = [_take_in(r, door) for r in ((relations,) if single else relations)]
        if any(r == se.false or (r.is_Number and r != 0) for r in ideal):
            raise DefinitionError("one of the relations is a nonzero number: nothing satisfies it")
        left, right = door.inward(a), door.inward(b)
        known = [*door.hypotheses, *door.lost_conditions(a), *door.lost_conditions(b)]
        verdict = decide_equal(left, right, [*ideal, *known], pointwise=True)
        return _possible(_fill_witness(verdict, a, b), a.free_symbols | b.free_symbols)
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))


_NO_NUMBERS = (sp.nan, sp.zoo, sp.oo, -sp.oo)


def _take_in(relation: Any, door: Door) -> Any:
    """A relation, or a condition, inside the door."""
    holds = isinstance(relation, Boolean) and not relation.is_Symbol
    return condition(relation, door.inward) if holds else door.inward(relation)


TRIALS, HEIGHT, CLOSE = 200, 300, sp.Float("1e-20")
"""So many random points are tried for letters that cancel, with numerators up to the second; both
sides have the values of the witness to that part."""


def _fill_witness(verdict: Verdict, a: sp.Expr, b: sp.Expr) -> Verdict:
    """The verdict, with values in its witness for letters that cancel at the door: those at which
    both sides are real, as sqrt(x - 1) sqrt(1/(x - 1)) is where x > 1."""
    witness, sides = verdict.witness, sp.Tuple(a, b)
    if witness is None or sides.atoms(AppliedUndef):
        return verdict
    named = {plain_name(x): x for x in sides.free_symbols}
    absent = sorted(named.keys() - witness.point.keys())
    if not absent:
        return verdict
    radicands = [p.base for p in sides.atoms(sp.Pow) if p.exp.is_Rational and not p.exp.is_Integer]
    known = {x: sp.Rational(witness.point[n]) for n, x in named.items() if n in witness.point}
    values, dice = [sp.Rational(v) for v in (witness.left, witness.right)], Random(0)
    for _ in range(TRIALS):
        point = {
            n: sp.Rational(dice.randint(-HEIGHT, HEIGHT), dice.choice((97, 13, 2))) for n in absent
        }
        if not all(_fits(named[n], value) for n, value in point.items()):
            continue
        at = {**known, **{named[n]: value for n, value in point.items()}}
        if not all(sp.N(inside.xreplace(at), DIGITS).is_nonnegative for inside in radicands):
            continue
        found = [sp.N(side.xreplace(at), DIGITS) for side in sides]
        if all((f.is_Float or f.is_zero) and abs(f - v) <= CLOSE * max(1, abs(v))
               for f, v in zip(found, values, strict=True)):  # fmt: skip
            whole = {**witness.point, **{n: str(value) for n, value in point.items()}}
            return replace(verdict, witness=replace(witness, point=whole))
    return verdict


def _fits(symbol: Any, value: sp.Rational) -> bool:
    """Whether a number is what SymPy knows of a symbol."""
    return all(
        getattr(value, f"is_{fact}", holds) in (holds, None)
        for fact, holds in symbol.assumptions0.items()
    )


def _possible(verdict: Verdict, symbols: Iterable[Any]) -> Verdict:
    """The verdict, unless SymPy knows of a symbol what the number in the witness contradicts: that
    it is prime, or irrational."""
    if verdict.witness is None:
        return verdict
    for symbol in symbols:
        value = verdict.witness.point.get(plain_name(symbol))
        if value is not None and not _fits(symbol, sp.Rational(value)):
            why = f"no witness was found with what is known of '{symbol}'"
            return Verdict("undecided", why)
    return verdict


def decide_zero(expr: Any, relations: Sequence[Any] = ()) -> Verdict:
    """``decide_equal`` against zero."""
    return decide_equal(expr, sp.Integer(0), relations)


def decide_equal(
    a: Any,
    b: Any,
    relations: Sequence[Any] = (),
    work_limit: int = PROOF_LIMIT,
    pointwise: bool = False,
) -> Verdict:
    """Decide equality of two symengine expressions, modulo relations that vanish, on states that
    meet the conditions among them.

    A witness is looked for first, in ball arithmetic at sample points; then the normal form of
    the difference is made, within a bound on the work; then witnesses are looked for where branches
    change, on a jump of a sign or a floor only where ``pointwise``.
    """
    a, b = se.sympify(a), se.sympify(b)
    if a == b:
        return Verdict("proved", "identical expressions")
    try:
        tape = Tape([a, b])
        samples = sample_evaluable(tape, relations)
    except EngineLimit:
        samples, tape = [], None
    for point, (left, right) in samples:
        if not left.overlaps(right):
            return Verdict("refuted", "ball arithmetic", witness_at(point, left, right))
    reason = _difference_in_normal_form(a, b, relations, work_limit)
    if reason is None:
        return Verdict("proved", "zero in exact normal form")
    if tape is None:
        return Verdict("undecided", f"{reason}; {NO_POINT}")
    found, agreeing = _look_again(Search(a, b, relations, pointwise), tape, relations)
    if found is not None:
        point, (left, right) = found
        return Verdict("refuted", "ball arithmetic", witness_at(point, left, right))
    try:
        if are_equal(a, b, relations, min(work_limit, WORK_LIMIT)):
            return Verdict("proved", "zero in exact normal form, functions of functions resolved")
    except (EngineLimit, DefinitionError, RecursionError):  # forms nested too deeply
        pass
    evidence = (
        f"the two sides agree to 200 digits at {agreeing} points (no proof)"
        if agreeing
        else NO_POINT
    )
    return Verdict("undecided", f"{reason}; {evidence}")


def _difference_in_normal_form(
    a: Any, b: Any, relations: Sequence[Any], work_limit: int
) -> str | None:
    """Why the normal form of the difference does not prove two sides equal; None where it does."""
    equations, conditions = split_hypotheses(relations)
    known = [*conditions, *domain_conditions([a, b])]
    try:  # signs cost more than most proofs, and most need none
        given = (equations, [*equations, *known]) if known else (equations,)
        for left, right in _forms(a, b):
            # In a difference symengine may write a radicand with other signs than in its sides.
            sides = [left, right, left - right]
            for hypotheses in given:
                if ring_over(sides, hypotheses, work_limit).fraction(left - right).num == 0:
                    return None
    except EngineLimit as limit:
        return str(limit)
    return "the normal form of the difference is not zero"


def _look_again(search: Search, tape: Tape, relations: Sequence[Any]) -> tuple[Any, int]:
    """A witness where branches change, or in many more digits; None where there is none, and at
    how many points the sides agree."""
    agreeing = 0 if search.run() else search.agreement_count()
    if search.found is None:
        for point, values in sample_evaluable(tape, relations, 800, 24, 12):
            agreeing += 1
            if not values[0].overlaps(values[1]):
                search.found = point, values
    return search.found, agreeing


def _forms(a: Any, b: Any) -> Iterator[tuple[Any, Any]]:
    """Both sides, first with one letter for each angle where one is a long sum, whose sine is no
    polynomial of bearable length."""
    angles = angles_of([a, b])
    if len(angles) <= MOST_LONG and any(len(linear_terms(angle)) > LONG_SUM for angle in angles):
        left, right = fold_angles([a, b])
        yield left, right
    yield a, b


def all_vanish(exprs: Sequence[Any], relations: Sequence[Any] = ()) -> bool:
    """Whether all expressions vanish; ``EngineLimit`` where that stays undecided."""
    exprs = [e for e in exprs if e != 0]
    if not exprs:
        return True
    for _, values in sample_evaluable(Tape(exprs), relations, tries=4):
        if any(not value.contains(0) for value in values):
            return False
    for expr in exprs:
        verdict = decide_zero(expr, relations)
        if verdict.refuted:
            return False
        if verdict.undecided:
            raise EngineLimit(
                f"whether all of several expressions vanish is undecided: {verdict.method}"
            )
    return True


def witness_at(point: dict[Any, Any], left: Any, right: Any) -> Witness:
    """A point with two values there."""
    name = _plain if len({*map(_plain, point)}) == len(point) else str
    named = {name(atom): _digits(value, DIGITS) for atom, value in point.items()}
    digits = DIGITS
    while _digits(left, digits) == _digits(right, digits) and digits < 300:
        digits += 10  # show where they part
    return Witness(named, _digits(left, digits), _digits(right, digits))


def _plain(atom: Any) -> str:
    """What is called x where it is x(t): the time adds nothing."""
    name = str(atom)
    return name.removesuffix("(t)") if name.removesuffix("(t)").isidentifier() else name


def _digits(value: Any, digits: int) -> str:
    if isinstance(value, flint.fmpq):
        return str(value)
    return str(value.str(digits, radius=False)) if isinstance(value, flint.arb) else str(value)
