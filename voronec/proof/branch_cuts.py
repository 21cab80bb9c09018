"""Cuts that motions cross: where a function that is constant off them jumps.

A derivative that vanishes where it exists proves nothing across a cut h = 0 of the function
[Theory, eqs. (14a), (14b),
(14c)].  A cut is harmless where no state lies on it, or where the field is
singular or jumps itself; where motions keep it, h' = 0 on h = 0; where the function is the same
on both sides, F+ = F- on h = 0; and where it is real on one side alone.  A jump by a constant
is one by a period, unless the function is constant but for its jumps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import islice
from math import gcd
from typing import Any

import flint
import symengine as se

from voronec.algebra.branches import (
    BranchCut,
    Branches,
    bounds_of,
    branch_arguments,
    divisors_of,
    has_branches,
    is_plain,
    product_of,
)
from voronec.algebra.composition import positive_bases
from voronec.algebra.conditions import domain_of, moved_hypotheses, split_hypotheses
from voronec.algebra.normal import canonical
from voronec.algebra.points import consistent, sample_evaluable, sample_point
from voronec.algebra.precision import GENERIC
from voronec.algebra.roots import known_sign, ring_over
from voronec.algebra.tape import Tape
from voronec.algebra.terms import factors_of, rational
from voronec.algebra.verdicts import Verdict, witness_at
from voronec.equations.vector_field import VectorField
from voronec.errors import DefinitionError, EngineLimit, quote

_SEEDS = 96
"""How many states are looked for on a cut, at most: a piece of it may be a sixteenth of all."""
_FIRST = 16
"""How many of these are looked for before it is asked whether there are any."""
_TRIES = 4
"""How many points are looked for at which an expression may not vanish."""
_ENOUGH = 8
"""At how many states a radicand is looked at."""
_CLOSE = se.Rational(1, 1000)
"""A value of a function close to its zeros."""


def across_cuts(
    verdict: Verdict,
    field: VectorField,
    functions: Sequence[tuple[str, Any]],
    periods: bool | Callable[[Any], bool] = True,
    constant: bool = False,
    beyond: bool = False,
) -> Verdict:
    """A proof off the cuts of some functions, as what it is with them.

    functions
        with what a message calls each, in the engine's symbols, in the variables of the field.
    periods
        whether a jump by a constant leaves a claim standing, up to multiples of it; or of which
        constants that is so.
    constant
        whether the functions are proved to be constant along motions off their cuts.
    beyond
        whether poles of the equations, which motions may pass, are looked at; it is so of what is
        constant.
    """
    if not verdict.proved:
        return verdict
    ground = _Ground(field, periods, constant, beyond or constant)
    verdicts = []
    for label, function in functions:
        if not constant or ground.has_letters or has_branches([function], function.free_symbols):
            try:
                one = ground.verdict_on(function, verdict)
            except EngineLimit as limit:
                one = Verdict("undecided", f"its cuts: {limit}")
            verdicts.append(replace(one, method=f"{label}: {one.method}") if label else one)
    for status in ("refuted", "undecided"):
        for one in verdicts:
            if one.status == status:
                return one
    return _join_proofs(verdict, verdicts)


def flow_across_cuts(verdict: Verdict, field: VectorField, density: Any) -> Verdict:
    """A proof that div(density f) = 0 off the cuts of the field, as what it is with them.

    Volume passes a cut h = 0 unchanged where density f(h) is the same on both sides, as it is
    where a force jumps with a place; friction, which jumps with a velocity, presses it together.
    """
    if not verdict.proved:
        return verdict
    try:
        return _Ground(field).verdict_on_flow(density, verdict)
    except EngineLimit as limit:
        return Verdict("undecided", f"the cuts of the field: {limit}")


def not_vacuous(verdict: Verdict, field: VectorField) -> Verdict:
    """A proof about motions, unless it is not known that there are any."""
    return verdict if not verdict.proved or field.existence.proved else field.existence


def beside_zeros(verdict: Verdict, field: VectorField, name: str, function: Any) -> Verdict:
    """A proof in which something must neither vanish nor be infinite, as a clock, beside its zeros
    and poles that motions pass."""
    ground = _Ground(field)
    moving = ground.variables
    if not verdict.proved or not function.free_symbols & moving:
        return verdict
    try:
        both = [h for e in (1 / function, function) for h in divisors_of(e, field.relations)]
        divisors = dict.fromkeys(h for h in both if h.free_symbols & moving)
        passed = [h for h in divisors if ground.is_passed(h)]
    except EngineLimit:
        return verdict.where(f"{name} != 0")
    return verdict.where(*(f"{_show(field.bridge.outward(h))} != 0" for h in passed))


def positive_domain(field: VectorField, exprs: Sequence[Any], known: Sequence[Any]) -> list[str]:
    """What a proof takes for positive in expressions in the engine's symbols, in words: bases under
    letters that may be whole numbers, for all that hypotheses say that are ``known``."""
    bases = positive_bases(exprs, known)
    open_ones = [b for b in bases if known_sign(b, field.conditions) < 1]
    return [f"{_show(field.bridge.outward(b))} > 0" for b in open_ones]


def _join_proofs(verdict: Verdict, found: Sequence[Verdict]) -> Verdict:
    """A proof with the periods and the domain of several."""
    modulo = ", ".join(dict.fromkeys(v.modulo for v in (verdict, *found) if v.modulo))
    return replace(verdict, modulo=modulo).where(*(v.domain for v in found))


@dataclass(frozen=True)
class _Ground:
    """The field across whose motions cuts lie."""

    field: VectorField
    periods: bool | Callable[[Any], bool] = False
    constant: bool = False
    beyond: bool = False

    @cached_property
    def variables(self) -> frozenset[Any]:
        """What moves."""
        return frozenset({*self.field.variables, self.field.time})

    @property
    def relations(self) -> tuple[Any, ...]:
        return tuple(self.field.relations)

    @cached_property
    def hypotheses(self) -> tuple[Any, ...]:
        """What holds on all states: the field's hypotheses, and that the inertia is positive."""
        named = self.field.determinant
        return (*self.field.hypotheses, *(() if named is None else (named > 0,)))

    def verdict_on(self, function: Any, proof: Verdict) -> Verdict:
        """The verdict on one function with a proof off its cuts."""
        gaps = self._gaps(function) if self.beyond else []
        proof = replace(proof, domain=", ".join(gaps))
        if is_plain(function, self.variables, essential=not self.constant):
            return self._with_domain(proof, function)
        relations = _relations_of(function, self.relations)
        branches = Branches(function, self.variables, relations, not self.constant)
        open_cuts = [h for h in branches.unclear if not self._has_sign(h, strict=True)]
        open_cuts = [h for h in open_cuts if not self._is_kept(h)]
        met = [j for cut in branches.branch_cuts() if (j := self._jump(cut)) is not None]
        jumps = [j for j in met if not j.domain]
        proof = replace(proof, domain="").where(*(j.domain for j in met), proof.domain)
        seen = [j for j in met if j.witness is not None]
        false = [j for j in jumps if j.witness is not None and j.period is None]
        if seen and self._is_constant(function):
            words = f"it is constant but for jumps: {seen[0].words}"
            return Verdict("refuted", words, seen[0].witness)
        if false:
            return Verdict("refuted", false[0].words, false[0].witness)
        if any(j.witness is None for j in jumps):
            return Verdict("undecided", next(j.words for j in jumps if j.witness is None))
        if open_cuts:
            return Verdict("undecided", f"whether it jumps where {_show(open_cuts[0])} = 0")
        if jumps:
            periods = _smallest([j.period for j in jumps])
            proof = replace(proof, modulo=" and ".join(map(self._write, periods)))
        return self._with_domain(proof, function)

    def verdict_on_flow(self, density: Any, proof: Verdict) -> Verdict:
        """The verdict on an invariant measure with a proof off the cuts of the field."""
        for h in self._field_jumps:
            there, flow = (*self.hypotheses, h), density * self.field.derivative(h)
            for cut in Branches(flow, self.variables, self.relations, False).branch_cuts():
                if not (_is_same_cut(cut.function, h) and self._may_jump(cut)):
                    continue
                place = self._place(cut)
                sides = [cut.above, cut.below, *cut.positive]
                for point, (above, below, *rest), _ in self._states(sides, there, cut.whole):
                    if not above.overlaps(below) and all(e > 0 for e in rest):
                        words = f"volume is lost or won where {place}: the flow through it jumps"
                        return Verdict("refuted", words, witness_at(point, above, below))
                return Verdict("undecided", f"whether the flow jumps where {place} is open")
        return proof

    def _with_domain(self, proof: Verdict, function: Any) -> Verdict:
        """The proof with the domain on which the function is real, where that is less than all."""
        bounds = bounds_of(function)
        for b in bounds_of(function, pieces=False):
            if known_sign(b, self.hypotheses, strict=True) < 0:
                return Verdict("refuted", f"it has no real value, since {self._write(b)} < 0")
        for b in positive_bases([function], self.hypotheses):
            if known_sign(b, self.hypotheses, strict=True) < 0:
                why = f"{self._write(b)} < 0 stands under a letter that may be no whole number"
                return Verdict("undecided", why)
        if bounds and not sample_evaluable(Tape([function]), self.hypotheses, count=1):
            return Verdict("undecided", "no state was found at which it has a real value")
        moving = [b for b in bounds if b.free_symbols & self.variables]
        parts = [function, self.field.derivative(function)] if self.has_letters else [function]
        crossed = (f"{self._write(b)} > 0" for b in moving if self._is_crossed(b))
        words = dict.fromkeys([*positive_domain(self.field, parts, self.hypotheses), *crossed])
        return replace(proof, domain=", ".join(filter(None, (proof.domain, *words))))

    @cached_property
    def has_letters(self) -> bool:
        """Whether the field holds powers of what letters above it say to be positive."""
        return bool(positive_bases(self.field.entries, self.hypotheses))

    def _is_crossed(self, bound: Any) -> bool:
        """Whether a function is negative at some state at which the inertia is positive."""
        states = islice(self._states([bound], self.hypotheses), _ENOUGH)
        return any(v < 0 and _is_positive(mass) for _, (v,), mass in states)

    def is_passed(self, h: Any) -> bool:
        """Whether motions may pass from one side of h = 0 to the other."""
        return not (self._has_sign(h) or self._is_kept(h)) and self._has_sides(h)

    # -- singular places -----------------------------------------------------------------------

    def _gaps(self, function: Any) -> list[str]:
        """Beside which places a field is regular, where a function may have another branch beyond.

        Velocities are bound there, so that what is 0/0 of independent velocities need not jump on
        a cut: a motion comes to xdot = 0 and cos(phi) = 0 together, and Abs(xdot)/cos(phi) jumps.
        A function is the same on both sides where all that it has branches of stays along motions,
        or has one sign in whatever velocities; what stands under roots alone has it, where real.
        """
        insides = {
            e: is_root
            for e, is_root in branch_arguments(function, self.variables).items()
            if not (
                self._is_unit_everywhere(e)
                or self._vanishes(self.field.derivative(e), self.hypotheses)
            )
        }
        try:
            poles = self._poles if insides else []
        except EngineLimit:
            return ["the equations are regular"]
        open_ones = [
            h for h in poles if not all(self._is_unit(e, h, r) for e, r in insides.items())
        ]
        return [f"{self._write(h)} != 0" for h in open_ones]

    def _is_unit_everywhere(self, expr: Any) -> bool:
        """Whether it is a function of positions of one sign that is zero in codimension two only:
        an irreducible factor of odd power with more zeros would change the sign there."""
        if not expr.free_symbols.isdisjoint(self.field.velocities) or not self._has_sign(expr):
            return False
        powers = product_of(expr, self.relations, self.variables).powers
        return all(k % 2 for h, k in powers.items() if h.free_symbols & self.variables)

    @property
    def _poles(self) -> list[Any]:
        """Irreducible functions by which rates are divided, where motions may be on both sides."""
        return self.field.memo.once("poles", self._find_poles)

    def _find_poles(self) -> list[Any]:
        rates = reversed(self.field.components)  # the longest first: they may be too long
        divisors = [h for e in rates for h in divisors_of(e, self.relations)]
        moving = [h for h in dict.fromkeys(divisors) if h.free_symbols & self.variables]
        return [h for h in moving if not self._has_sign(h) and self._has_sides(h)]

    def _has_sides(self, h: Any) -> bool:
        """Whether there are states close to h = 0, of positive inertia, on both of its sides."""
        return all(
            any(_is_positive(mass) for *_, mass in self._states([h], (*self.hypotheses, h - e)))
            for e in (_CLOSE, -_CLOSE)
        )

    def _is_unit(self, expr: Any, h: Any, signed: bool) -> bool:
        """Whether it is a function of positions with one sign, maybe known to be ``signed``, and
        not zero all over h = 0; what is signed may be so there, if that is on one side alone."""
        if not expr.free_symbols.isdisjoint(self.field.velocities):
            return False
        there = (*self.hypotheses, h)

        def stays(f: Any, power: int) -> bool:
            if signed and f == h:
                return bool(power % 2)
            has_sign = signed or any(known_sign(f, k) for k in (self.field.conditions, there))
            return has_sign and not self._vanishes(f, there)

        powers = product_of(expr, self.relations, self.variables).powers
        return all(stays(f, k) for f, k in powers.items() if f.free_symbols & self.variables)

    # -- one cut -------------------------------------------------------------------------------

    def _jump(self, cut: BranchCut) -> _Jump | None:
        """The jump on a piece of a cut; None where there is none that a motion would meet."""
        if not self._may_jump(cut):
            return None
        h, jump = cut.function, cut.above - cut.below
        there = (*self.hypotheses, h)
        # before states are sought in vain: a proof that no motion crosses costs less
        if self._is_kept(h):
            return _Jump("", None, None, self._beside(cut))
        crossing = next(self._crossings(cut, there, _FIRST), None)
        if crossing is None and self._is_singular(there):
            return None  # what is constant beside poles alone is told of all of them
        crossing = crossing or next(self._crossings(cut, there, _SEEDS), None)
        if crossing is not None:
            words = f"it jumps where {self._place(cut)}, which motions cross"
            # a map or a density that jumps where the field does still tears the motion that crosses
            is_excused = self.constant and self._is_jump_of_field(h)
            domain = self._beside(cut) if is_excused else ""
            is_turn = self._vanishes(cut.turned - cut.above, there)
            period = self._period(jump) if is_turn else None
            return _Jump(words, period, witness_at(*crossing), domain)
        if self._is_pole(cut, there):
            return None
        return _Jump(f"whether it jumps where {self._place(cut)} is open", None, None)

    def _may_jump(self, cut: BranchCut) -> bool:
        """Whether some state may lie on a piece of a cut at which its sides differ."""
        h, there = cut.function, (*self.hypotheses, cut.function)
        if cut.above == cut.below or cut.edge or self._has_sign(h):
            return False
        if any(known_sign(e, there) < 0 for e in cut.positive):
            return False
        return not self._vanishes(cut.above - cut.below, there)

    def _has_sign(self, h: Any, strict: bool = False) -> bool:
        """Whether h does not change its sign; ``strict``: nor is it zero."""
        ways = (self.hypotheses, self.field.conditions)  # relations may hide that terms are squares
        return any(known_sign(h, known, strict) for known in ways)

    def _is_kept(self, h: Any) -> bool:
        """Whether motions keep h = 0, and none crosses it."""
        return self._vanishes(self.field.derivative(h), (*self.hypotheses, h))

    def _is_jump_of_field(self, h: Any) -> bool:
        """Whether the field itself jumps where h = 0, as with friction."""
        return any(_is_same_cut(h, k) for k in self._field_jumps)

    @cached_property
    def _field_jumps(self) -> list[Any]:
        field = self.field
        return [
            cut.function
            for e in field.entries
            if has_branches([e], self.variables)
            for cut in Branches(e, self.variables, self.relations, False).branch_cuts()
            if not self._vanishes(cut.above - cut.below, (*self.hypotheses, cut.function))
        ]

    def _is_singular(self, there: tuple[Any, ...]) -> bool:
        """Whether the field is singular all over a cut: a rate has a pole, or inertia is none."""
        return any(self._is_pole_of(e, there) for e in self.field.components)

    def _is_pole(self, cut: BranchCut, there: tuple[Any, ...]) -> bool:
        """Whether both sides tend to infinity."""
        return self._is_pole_of(cut.above, there) and self._is_pole_of(cut.below, there)

    def _is_pole_of(self, expr: Any, there: tuple[Any, ...]) -> bool:
        if not expr.free_symbols & self.variables or expr == 0:
            return False
        return self._vanishes(1 / expr, there)

    def _period(self, jump: Any) -> Any:
        """The jump, where it is a constant and the claim may be one up to periods."""
        if not self.periods:
            return None
        try:
            short = canonical([jump], self.hypotheses)[0]
        except EngineLimit:
            return None
        if short.free_symbols & self.variables:
            return None
        if self.periods is not True and not self.periods(short):
            return None
        return -short if _is_negative(short) else short

    def _crossings(
        self, cut: BranchCut, there: tuple[Any, ...], tries: int
    ) -> Iterator[tuple[dict[Any, Any], Any, Any]]:
        """States on a cut, at which motions cross it, with different values on its sides.

        Where these are 0/0 at every state that is looked for, common factors are cancelled.
        """
        speed = self.field.derivative(cut.function)
        sides = [cut.above, cut.below]
        for _ in range(2):
            met, exprs = False, [*sides, speed, *cut.positive]
            for point, values, _ in self._states(exprs, there, cut.whole, tries):
                met = True
                above, below, rate, *rest = values
                if not (rate.contains(0) or above.overlaps(below)) and all(e > 0 for e in rest):
                    yield point, above, below
            if met or tries < _SEEDS:
                return
            sides = [product_of(e, self.relations, self.variables).expression for e in sides]

    def _states(
        self,
        exprs: Sequence[Any],
        hypotheses: Sequence[Any],
        whole: Any = None,
        tries: int = _SEEDS,
    ) -> Iterator[tuple[dict[Any, Any], list[Any], Any]]:
        """Admissible states where hypotheses hold, with the values of expressions and the mass,
        where the field is regular: the mass has an inverse and everything is finite."""
        field, count = self.field, len(exprs)
        size = len(field.mass)
        entries = [e for row in field.mass for e in row]
        at = {} if whole is None else {whole: se.Integer(0)}
        needed = [e.xreplace(at) for e in (*exprs, *entries, *field.rates, *field.force)]
        bound = [h.xreplace(at) for h in hypotheses]
        try:
            tape = Tape(needed)
        except EngineLimit:
            return
        for seed in range(1, 2 * tries, 2):
            try:
                point = self._point(tape, bound, seed)
                values = tape.arb(point, GENERIC)
            except EngineLimit:
                continue
            if not all(v.is_finite() for v in values):
                continue
            mass = flint.arb_mat(size, size, values[count : count + size * size])
            if not size or not mass.det().contains(0):
                yield point, values[:count], mass

    def _values(self, expr: Any, hypotheses: Sequence[Any]) -> Iterator[Any]:
        """Values of an expression where hypotheses hold, on states that may be singular."""
        tape = Tape([expr])
        for seed in range(1, 2 * _TRIES, 2):
            try:
                point = self._point(tape, hypotheses, seed)
            except EngineLimit:
                continue
            (value,) = tape.arb(point, GENERIC)
            if value.is_finite() and consistent(tape.atoms, point, GENERIC):
                yield value

    def _point(self, tape: Tape, hypotheses: Sequence[Any], seed: int) -> dict[Any, Any]:
        """A state where hypotheses hold, with parameters that are positive unless they may not be;
        a relation that is a variable itself makes it vanish exactly."""
        equations, conditions = split_hypotheses(hypotheses)
        zero = {e: flint.fmpq(0) for e in equations if e in self.variables}
        atoms = dict.fromkeys([*tape.atoms, *Tape(equations).atoms])
        still = [a for a in atoms if isinstance(a, se.Symbol) and a not in self.variables]
        on_still = [c for c in conditions if self.variables.isdisjoint(c.free_symbols)]
        known = sample_point(still, on_still, seed - 1) | zero
        at = {a: rational(v) for a, v in known.items()}
        rest = [h for h in moved_hypotheses(hypotheses, at) if h != 0]
        free = [a for a in tape.atoms if a not in at]
        point = {**sample_point(free, rest, seed, GENERIC), **known}
        if not domain_of(tuple(conditions)).admits(point, GENERIC):
            raise EngineLimit("conditions do not hold where these variables vanish")
        return point

    # -- decisions ------------------------------------------------------------------------------

    def _vanishes(self, expr: Any, hypotheses: Sequence[Any]) -> bool:
        """Whether it is proved that an expression vanishes; where nothing satisfies the relations
        everything does."""
        equations, conditions = split_hypotheses(hypotheses)
        try:
            if any(not value.contains(0) for value in self._values(expr, hypotheses)):
                return False
            return any(  # most proofs need no signs, which cost more than they do
                ring_over([expr], known).fraction(expr).num == 0
                for known in ((equations, hypotheses) if conditions else (equations,))
            )
        except DefinitionError:
            return True
        except (EngineLimit, ZeroDivisionError):
            return False

    def _is_constant(self, function: Any) -> bool:
        """Whether a function is constant off its cuts."""
        return all(self._vanishes(function.diff(x), self.hypotheses) for x in self.variables)

    def _beside(self, cut: BranchCut) -> str:
        """Where a cut is not, in words."""
        if cut.whole is not None:
            return f"{self._write(cut.function + cut.whole)} is no whole number"
        return f"{self._write(cut.function)} != 0"

    def _place(self, cut: BranchCut) -> str:
        """Where a cut is, in words."""
        if cut.whole is not None:
            return f"{self._write(cut.function + cut.whole)} is a whole number"
        return f"{self._write(cut.function)} = 0"

    def _write(self, expr: Any) -> str:
        return _show(self.field.bridge.outward(expr))


@dataclass(frozen=True)
class _Jump:
    """A jump with its witness; without one it is open whether there is any.  With a ``domain`` the
    verdict is one for each side of the cut: motions keep it, or the field jumps there, too."""

    words: str
    period: Any
    witness: Any
    domain: str = ""


def _is_same_cut(h: Any, k: Any) -> bool:
    return bool((h - k).expand() == 0 or (h + k).expand() == 0)


def _is_positive(mass: Any) -> bool:
    """Whether a matrix is positive definite: its leading minors are positive."""
    rows = mass.tolist()
    sizes = range(1, len(rows) + 1)
    minors = (flint.arb_mat([row[:n] for row in rows[:n]]).det() for n in sizes)
    return all(minor > 0 for minor in minors)


def _is_negative(expr: Any) -> bool:
    factors = factors_of(expr)
    return any(f.is_Number and f < 0 for f in factors)


def _relations_of(function: Any, relations: Sequence[Any]) -> tuple[Any, ...]:
    """The relations that bind symbols of a function, and those that bind symbols of these: others
    hold of other factors of a product, on which the function is constant."""
    held, kept = function.free_symbols, list[Any]()
    while further := [r for r in relations if r not in kept and r.free_symbols & held]:
        kept += further
        held = held.union(*(r.free_symbols for r in further))
    return tuple(r for r in relations if r in kept)


def _smallest(periods: Sequence[Any]) -> list[Any]:
    """Periods of which all others are multiples."""
    groups: dict[Any, list[Any]] = {}
    for period in periods:
        for first in groups:
            ratio = (period / first).expand()
            if isinstance(ratio, se.Rational):
                groups[first].append(ratio)
                break
        else:
            groups[period] = [se.Integer(1)]
    return [first * reduce(_common, ratios) for first, ratios in groups.items()]


def _common(a: Any, b: Any) -> Any:
    """The largest rational of which two are whole multiples."""
    below = int(a.q) * int(b.q)
    return se.Integer(gcd(int(a.p) * int(b.q), int(b.p) * int(a.q))) / se.Integer(below)


def _show(expr: Any) -> str:
    return str(quote(expr))
