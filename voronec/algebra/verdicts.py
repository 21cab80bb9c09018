"""Equality with three answers: proved, refuted with a witness, undecided.

Witnesses against an equality are looked for where branches change.  Cuts are what stands under
roots, signs, floors, two-place arctangents and logarithms, factor by factor: there a function turns
into another one.  Points are taken in the orthants of the atoms, at special rational numbers, of
all sizes, on cuts, and on both sides of each.  Points at which the cuts have the same signs tell
the same, so one of each kind is looked at with more digits.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice, product
from random import Random
from typing import Any

import flint
import symengine as se
import sympy as sp
from sympy.logic.boolalg import Boolean

from voronec.algebra.arguments import SEVERAL, accepts
from voronec.algebra.composition import angles_of, are_equal, fold_angles, positive_bases
from voronec.algebra.conditions import condition, domain_of, split_hypotheses
from voronec.algebra.factors import irreducible_factors
from voronec.algebra.generators import linear_terms
from voronec.algebra.graphs import nodes
from voronec.algebra.points import consistent, lift_point, sample_evaluable
from voronec.algebra.precision import GENERIC
from voronec.algebra.ring import Ring
from voronec.algebra.roots import domain_conditions, ring_over
from voronec.algebra.sympy_bridge import NoValue, SymPyBridge
from voronec.algebra.tape import Tape
from voronec.algebra.terms import rational
from voronec.algebra.text import as_expression, quote
from voronec.algebra.typeset import html_table
from voronec.errors import DefinitionError, EngineLimit

DIGITS = 30
"""Of the values of a witness that are told."""
NUMBERS = "ball arithmetic"
"""How the two sides of an equality are told apart at a point."""
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
        return f"{self.left} against {self.right}" + (f" at {at}" if at else "")


def _conditions_of(domain: str) -> list[str]:
    """The conditions of a domain, which stand apart by commas outside brackets; what is cut short
    by dots may leave some open."""
    conditions, depth = [""], 0
    for part in domain.split(", "):
        conditions[-1] += f", {part}" if depth else part
        depth = 0 if "..." in part else depth + part.count("(") - part.count(")")
        conditions += [] if depth else [""]
    return conditions


@dataclass(frozen=True)
class Verdict:
    """The answer to "are these equal?".

    ``status`` is ``proved`` (the difference is zero in an exact normal form), ``refuted`` (with a
    ``witness``: ball arithmetic separates the two sides) or ``undecided``.  ``method`` says how,
    and for an undecided question what the numbers suggest.  A proof may stand where a ``domain``
    bounds what is real, and one about motions up to multiples of a period, ``modulo``.
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

    def where(self, *words: str) -> Verdict:
        """A proof that stands where these hold, too; any other verdict as it is."""
        every = (part for text in (self.domain, *words) for part in _conditions_of(text))
        domain = dict.fromkeys(filter(None, every))
        signs = [c[:-4] for c in domain if c.endswith((" > 0", " < 0")) and " or " not in c]
        for function in signs:  # what has a sign is not zero
            domain.pop(f"{function} != 0", None)
        return replace(self, domain=", ".join(domain)) if self.proved else self

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
    for its non-negative value; what is raised to a power with letters that are not known to be
    whole, nor bound by ``relations``, is taken for positive, and the ``domain`` of the answer says
    so.  What turns out to have no value anywhere, as 1/(|x| - sqrt(x^2)), is undecided: both sides
    are defined nowhere.  Never "equal up to 1e-6": see ``Verdict``.
    Raises ``DefinitionError`` for what is no expression.
    """
    bridge = SymPyBridge()
    a, b = as_expression(a), as_expression(b)
    if a == b:
        if a.has(*_NO_NUMBERS):
            return Verdict("undecided", f"'{quote(a)}' has no value that could be equal to another")
        return Verdict("proved", "identical expressions")
    try:
        single = isinstance(relations, str) or not isinstance(relations, Iterable)
        ideal = [_take_in(r, bridge) for r in ((relations,) if single else relations)]
        if any(r == se.false or (r.is_Number and r != 0) for r in ideal):
            raise DefinitionError("one of the relations is a nonzero number: nothing satisfies it")
        try:
            left, right = bridge.inward(a), bridge.inward(b)
        except NoValue as refusal:
            return Verdict("undecided", str(refusal))
        known = [*bridge.hypotheses, *bridge.lost_conditions(a), *bridge.lost_conditions(b)]
        known = [*ideal, *known]
        verdict = decide_equal(left, right, known, pointwise=True)
        if verdict.proved:
            bases = positive_bases([left, right], known)
            return verdict.where(*(f"{quote(bridge.outward(b))} > 0" for b in bases))
        return verdict
    except EngineLimit as limit:
        return Verdict("undecided", str(limit))


_NO_NUMBERS = (sp.nan, sp.zoo, sp.oo, -sp.oo)


def _take_in(relation: Any, bridge: SymPyBridge) -> Any:
    """A relation, or a condition, in the engine's symbols."""
    holds = isinstance(relation, Boolean) and not relation.is_Symbol
    return condition(relation, bridge.inward) if holds else bridge.inward(relation)


def decide_zero(expr: Any, relations: Sequence[Any] = ()) -> Verdict:
    """``decide_equal`` against zero."""
    return decide_equal(expr, sp.Integer(0), relations)


def decide_equal(
    a: Any,
    b: Any,
    relations: Sequence[Any] = (),
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
            return Verdict("refuted", NUMBERS, witness_at(point, left, right))
    reason = _difference_in_normal_form(a, b, relations)
    if reason is None:
        return Verdict("proved", "zero in exact normal form")
    if tape is None:
        return Verdict("undecided", f"{reason}; {NO_POINT}")
    witness, agreeing = _look_again(WitnessSearch(a, b, relations, pointwise), tape, relations)
    if witness is not None:
        point, (left, right) = witness
        return Verdict("refuted", NUMBERS, witness_at(point, left, right))
    try:
        if are_equal(a, b, relations):
            return Verdict("proved", "zero in exact normal form, functions of functions resolved")
    except (EngineLimit, DefinitionError, RecursionError):  # forms nested too deeply
        pass
    evidence = (
        f"the two sides agree to 200 digits at {agreeing} points (no proof)"
        if agreeing
        else NO_POINT
    )
    return Verdict("undecided", f"{reason}; {evidence}")


def _difference_in_normal_form(a: Any, b: Any, relations: Sequence[Any]) -> str | None:
    """Why the normal form of the difference does not prove two sides equal; None where it does."""
    equations, conditions = split_hypotheses(relations)
    known = [*conditions, *domain_conditions([a, b])]
    try:  # signs cost more than most proofs, and most need none
        given = (equations, [*equations, *known]) if known else (equations,)
        for left, right in _forms(a, b):
            # In a difference symengine may write a radicand with other signs than in its sides.
            sides = [left, right, left - right]
            for hypotheses in given:
                if ring_over(sides, hypotheses, PROOF_LIMIT).fraction(left - right).num == 0:
                    return None
    except EngineLimit as limit:
        return str(limit)
    return "the normal form of the difference is not zero"


def _look_again(search: WitnessSearch, tape: Tape, relations: Sequence[Any]) -> tuple[Any, int]:
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


WORK = 120_000
"""Nodes that a search may evaluate: a part of a second, whatever the size of the graph."""
NEWTON = 200
"""How often relations are evaluated for a point on them, with their derivatives."""
FAILURE = 20
"""How many points one costs that is not found: Newton's method goes to its end."""
MOST_POINTS = 600
MOST_WALLS = 12
"""For a witness so many points are looked at, at most, beside so many cuts and edges."""
FACTOR_WORK = 20_000
"""Term products for the factors of a cut; without them it is taken as it stands."""
BITS, MORE_BITS = GENERIC, 800
"""Bits at a point, and where agreement to 200 digits is to be seen."""
KINDS = 12
"""How many kinds of points, by the signs of cuts, are looked at with more digits."""
BISECTIONS = 26
"""Of a way between two points, towards a cut: to a hundred-millionth of it."""

Point = dict[Any, Any]
_SMALL = [flint.fmpq(p, q) for p, q in ((1, 1), (-1, 1), (0, 1), (1, 2), (2, 1), (-1, 2), (3, 1))]


@dataclass
class WitnessSearch:
    """A search for a point at which two symengine expressions differ, where relations vanish
    and conditions hold.

    ``found`` is the point and the two values there, if there is one; ``kinds`` has a point for each
    pattern of signs of the cuts at which both sides have values.  Points on a jump count where
    ``pointwise``: what holds along motions, or of derivatives, says nothing there.
    """

    left: Any
    right: Any
    relations: Sequence[Any] = ()
    pointwise: bool = True
    found: tuple[Point, list[Any]] | None = None
    kinds: dict[tuple[int, ...], Point] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.cuts, self.edges = _cuts_of([self.left, self.right])
        self._sides = Tape([self.left, self.right])
        self._signs = Tape([*self.cuts, *self.edges])
        parts = [*nodes([self.left, self.right])]
        self._jumps = Tape([n.args[0] for n in parts if isinstance(n, se.sign)])
        self._steps = Tape([n.args[0] for n in parts if isinstance(n, se.floor)])
        self._turns = Tape([e for n in parts if isinstance(n, se.atan2) for e in n.args])
        self._source = Random("voronec witnesses")
        self.atoms = [*self._sides.atoms]
        equations, conditions = split_hypotheses(self.relations)
        for atom in (*self._signs.atoms, *Tape(equations).atoms):
            if atom not in self.atoms:
                self.atoms.append(atom)
        self.atoms += domain_of(tuple(conditions)).linked_symbols(self.atoms)
        bound = Tape(equations).size * len(equations)
        self._cost = self._sides.size + self._signs.size + NEWTON * bound
        self._work = min(WORK, MOST_POINTS * self._cost)
        self._tried: list[tuple[Point, list[int]]] = []

    def run(self) -> bool:
        """Look for a witness; whether one was found."""
        return any(
            self._refutes(point)
            for points in (self._scatter(), self._beside_cuts())
            for point in points
        )

    def agreement_count(self) -> int:
        """At how many points of different kinds the sides agree to 200 digits; a point at which
        they do not becomes what is found."""
        count = 0
        for start in [*self.kinds.values()][:KINDS]:
            point = self._lift(start, MORE_BITS)
            count += point is not None and self._compare(point, MORE_BITS)
            if self.found is not None:
                break
        return count

    # -- points ---------------------------------------------------------------------------

    def _refutes(self, start: Point) -> bool:
        """Whether a point, moved onto the relations, is a witness."""
        point = self._lift(start, BITS)
        if point is None:
            return False
        signs = [_sign(v) for v in self._signs.arb(point, BITS)]
        self._tried.append((point, signs))
        if self._compare(point, BITS):
            self.kinds.setdefault(tuple(signs), point)
        return self.found is not None

    def _lift(self, start: Point, bits: int) -> Point | None:
        """A point on the relations; none where it is not found, or was sought too often."""
        if self._work < 0:
            return None
        self._work -= self._cost
        try:
            return lift_point(start, self.relations, bits)
        except EngineLimit:
            self._work -= FAILURE * self._cost
            return None

    def _compare(self, point: Point, bits: int) -> bool:
        """Whether both sides have values at a point; where these differ, it is what is found."""
        left, right = self._sides.arb(point, bits)
        if not (left.is_finite() and right.is_finite()):
            return False
        if not self.pointwise and self._is_on_jump(point, bits):
            return False
        if self._has_no_angle(point, bits):
            return False
        if not left.overlaps(right) and consistent(self.atoms, point, bits):
            self.found = point, [left, right]
        return True

    def _has_no_angle(self, point: Point, bits: int) -> bool:
        """Whether the angle of the origin is asked for, which ball arithmetic gives as zero."""
        ends = iter(self._turns.arb(point, bits))
        return any(y.contains(0) and x.contains(0) for y, x in zip(ends, ends, strict=True))

    def _is_on_jump(self, point: Point, bits: int) -> bool:
        return any(v.contains(0) for v in self._jumps.arb(point, bits)) or any(
            v.contains_integer() for v in self._steps.arb(point, bits)
        )

    def _scatter(self) -> Iterator[Point]:
        """Special numbers, then numbers of every sign and of all sizes."""
        count, draw = len(self.atoms), self._source
        yield from islice(self._grid(), 60)
        orthants = [*product((1, -1), repeat=min(count, 5))]
        for index in range(3 * len(orthants)):
            signs = [
                *orthants[index % len(orthants)],
                *(draw.choice((1, -1)) for _ in range(count)),
            ]
            yield {a: s * self._number(1) for a, s in zip(self.atoms, signs, strict=False)}
        for _ in range(60):
            yield {a: draw.choice((1, -1)) * self._number(4) for a in self.atoms}

    def _grid(self) -> Iterator[Point]:
        if len(self.atoms) <= 2:
            for values in product(_SMALL, repeat=len(self.atoms)):
                yield dict(zip(self.atoms, values, strict=True))
        while self.atoms:
            yield {a: self._source.choice(_SMALL) for a in self.atoms}

    def _number(self, scale: int) -> Any:
        """A positive rational number of random size."""
        size = flint.fmpq(10) ** self._source.randint(-1 if scale == 1 else -3, scale)
        return flint.fmpq(self._source.randint(100, 1000), 907) * (1 if scale == 1 else size)

    # -- cuts ----------------------------------------------------------------------------

    def _beside_cuts(self) -> Iterator[Point]:
        """On each cut, where it is linear in something; and on both of its sides, near it."""
        for place, cut in enumerate((*self.cuts, *self.edges)):
            yield from islice(self._on(cut), 18)
            below = [p for p, signs in self._tried if signs[place] < 0][:3]
            above = [p for p, signs in self._tried if signs[place] > 0][:3]
            tape = Tape([cut])
            for low, high in zip(below, above, strict=False):
                yield from self._bisect(tape, low, high)

    def _on(self, cut: Any) -> Iterator[Point]:
        """Points moved along an atom to a rational zero, and to both sides of it, however far."""
        for atom in self.atoms:
            slope = cut.diff(atom) if isinstance(atom, se.Symbol) else se.Integer(0)
            if slope == 0 or atom in slope.free_symbols:
                continue
            rest = cut.xreplace({atom: se.Integer(0)})
            for start, _ in self._tried[:2]:
                at = {a: rational(v) for a, v in start.items() if isinstance(v, flint.fmpq)}
                above, below = rest.xreplace(at), slope.xreplace(at)
                if isinstance(above, se.Rational) and isinstance(below, se.Rational) and below != 0:
                    root = -above / below
                    for step in (0, 1, -1):
                        yield {**start, atom: flint.fmpq(int(root.p), int(root.q)) + step}

    def _bisect(self, tape: Tape, low: Point, high: Point) -> Iterator[Point]:
        """Points beside a zero of a function, nearer and nearer to it."""
        for step in range(BISECTIONS):
            middle = self._lift({a: _between(low[a], high[a]) for a in low}, BITS)
            if middle is None:
                return
            sign = _sign(tape.arb(middle, BITS)[0])
            if sign == 0:
                yield middle
                return
            low, high = (middle, high) if sign < 0 else (low, middle)
            if step % 8 == 3:
                yield low
                yield high
        yield low
        yield high


def _cuts_of(exprs: Iterable[Any]) -> tuple[list[Any], list[Any]]:
    """Where a function turns into another one: zeros of factors of what stands under roots, signs
    and the like; and what is not negative where everything is real."""
    cuts: dict[Any, None] = {}
    edges: dict[Any, None] = {}
    for node in nodes(exprs):
        inner = _edge(node)
        if inner is not None and inner.free_symbols:
            edges.setdefault(inner)
        for argument in _turns(node):
            if argument.free_symbols and len(cuts) < MOST_WALLS:
                cuts.update(dict.fromkeys(_factors(argument)))
    return [*cuts][:MOST_WALLS], [*edges][:MOST_WALLS]


def _turns(node: Any) -> tuple[Any, ...]:
    """Arguments at whose zeros a function has a jump, a kink or an end."""
    if isinstance(node, se.sign | se.log | se.atan2):
        return tuple(node.args)
    if isinstance(node, se.floor):
        return (node.args[0], se.sin(se.pi * node.args[0]))
    if isinstance(node, se.atan | se.acot):
        return (1 / node.args[0],)
    edge = _edge(node)
    return () if edge is None else (edge,)


def _edge(node: Any) -> Any:
    """What must not be negative for a function to be real."""
    if isinstance(node, se.log):
        return node.args[0]
    if isinstance(node, se.Pow) and node.args[0] != se.E:
        return None if isinstance(node.args[1], se.Integer) else node.args[0]
    if isinstance(node, se.asin | se.acos | se.atanh):
        return 1 - node.args[0] ** 2
    return node.args[0] - 1 if isinstance(node, se.acosh) else None


def _factors(cut: Any) -> list[Any]:
    """The irreducible factors of a cut and of its denominator, as expressions."""
    try:
        ring = Ring([cut], (), FACTOR_WORK)
        fraction = ring.fraction(cut)
    except EngineLimit:
        return [cut]
    if fraction.num == 0:
        return []
    parts = [p for p, _ in irreducible_factors(fraction.num)[1]]
    parts += [p for p, _ in ring.field.factors(fraction.den)]
    return [ring.polynomial(p) for p in parts]


def _sign(ball: Any) -> int:
    return 1 if ball > 0 else -1 if ball < 0 else 0


def _between(a: Any, b: Any) -> Any:
    """The middle of two numbers; exact for rational ones."""
    if isinstance(a, flint.fmpq) and isinstance(b, flint.fmpq):
        return (a + b) / 2
    return ((flint.arb(a) + flint.arb(b)) / 2).mid()
