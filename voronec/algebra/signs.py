"""Inequalities with three answers: proved by a certificate, refuted at a rational point, undecided.

A polynomial has a sign where its factors have one; a factor where it is a sum of terms of one sign,
a quadratic form that its discriminant makes definite, or a polynomial in one variable without
roots.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, product
from random import Random
from typing import Any

import flint
import symengine as se
import sympy as sp

from voronec.algebra.arguments import SEVERAL, TEXT, accepts
from voronec.algebra.certificates import Signs
from voronec.algebra.precision import GENERIC
from voronec.algebra.ring import Ring
from voronec.algebra.symbols import plain_name
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.tape import Tape
from voronec.algebra.terms import rational
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import PROOF_LIMIT, Verdict, Witness, decide_equal
from voronec.errors import DefinitionError, EngineLimit, quote

_TIES = 60
"""How many points, at which balls cannot tell the sides apart, are looked at exactly."""


@dataclass(frozen=True)
class Inequality:
    """Whether ``left relation right``, in symengine; ``signs`` of symbols by name, 1 or -1;
    ``narrow`` are symbols of which more is known, so that points may be none of theirs."""

    left: Any
    relation: str
    right: Any
    signs: Mapping[str, int]
    narrow: Sequence[sp.Symbol] = ()

    def is_violated_by(self, difference: Any) -> bool:
        """Whether a ball around the difference shows that the relation fails."""
        tests = {"<": difference > 0, ">": difference < 0, "<=": difference > 0}
        return bool({**tests, ">=": difference < 0, "!=": False}[self.relation])

    def search(self, roots: Sequence[tuple[Any, Any]], reason: str) -> Verdict:
        """Refuted by a point, or undecided."""
        if self.narrow:
            more = f"what is declared of '{self.narrow[0]}' is more than a sign"
            return Verdict("undecided", f"{reason}; {more}: no point is sought")
        tape = Tape([self.left, self.right])
        ties = _TIES if self.relation in ("<", ">", "!=") else 0
        # where a letter is an exponent, exact values may have millions of digits
        roots = [r for r in roots if all(p.args[1].is_Number for p in r[1].atoms(se.Pow))]
        for point in self._points(tape.atoms, roots):
            left, right = tape.arb(point, GENERIC)
            if not (left.is_finite() and right.is_finite()):
                continue
            if self.is_violated_by(left - right):
                return Verdict("refuted", "a rational point", _witness(point, left, right))
            if ties and (left - right).contains(0):
                ties -= 1
                at = {atom: rational(value) for atom, value in point.items()}
                if decide_equal(self.left.xreplace(at), self.right.xreplace(at)).proved:
                    method = "a rational point at which both sides are equal"
                    return Verdict("refuted", method, _witness(point, left, left))
        return Verdict("undecided", f"{reason}, nor a point that refutes it")

    def _points(self, atoms: Sequence[Any], roots: Sequence[Any]) -> Iterator[dict[Any, Any]]:
        """Small numbers first, then numbers of all sizes; each is moved onto each root, too."""
        for values in self._values(len(atoms)):
            point = dict(zip(atoms, values, strict=True))
            for atom in atoms:
                if side := self.signs.get(str(atom)):
                    point[atom] = side * (abs(point[atom]) + (not point[atom]))
            yield point
            for variable, root in roots:
                value, side = _value(root, point), self.signs.get(str(variable), 0)
                if value is not None:
                    moved = flint.fmpq(int(value.p), int(value.q))
                    if not side or side * moved > 0:
                        yield {**point, variable: moved}

    def _values(self, count: int) -> Iterator[tuple[Any, ...]]:
        source = Random("voronec signs")
        small = [flint.fmpq(p, q) for p, q in ((1, 1), (2, 1), (1, 2), (-1, 1), (3, 1), (0, 1))]
        yield from islice(product(small, repeat=count), 400)
        for number in range(2000 if count else 0):
            scale = 1 if number < 800 else 6
            yield tuple(_random(source, scale) for _ in range(count))


def _random(source: Random, scale: int) -> Any:
    """A rational number of random size and sign."""
    above = source.choice((1, -1)) * source.randint(1, 12)
    size = flint.fmpq(10) ** source.randint(-scale, scale)
    return flint.fmpq(above, source.randint(1, 12)) * size


def _value(root: Any, point: dict[Any, Any]) -> Any:
    """A root at a point, or ``None`` where it is no rational number, as beyond a branch point."""
    try:
        value = root.xreplace({a: rational(v) for a, v in point.items()})
    except RuntimeError:  # symengine cannot multiply complex infinity by a complex number
        return None
    return value if value.is_Number and getattr(value, "q", 0) != 0 else None


def _witness(point: dict[Any, Any], left: Any, right: Any) -> Witness:
    named = {str(atom): str(value) for atom, value in point.items()}
    return Witness(named, _spell_ball(left), _spell_ball(right))


def _spell_ball(ball: Any) -> str:
    """Thirty digits; a ball about zero that is left beside an exact answer is zero."""
    return "0" if ball.contains(0) else str(ball.str(30, radius=False))


RELATIONS = {
    **{relation: relation for relation in ("<", ">", "<=", ">=", "!=")},
    "\\lt": "<",
    "\\gt": ">",
    **dict.fromkeys(("\\le", "\\leq", "\\leqslant"), "<="),
    **dict.fromkeys(("\\ge", "\\geq", "\\geqslant"), ">="),
    **dict.fromkeys(("\\ne", "\\neq"), "!="),
}
"""Relations by their spellings, in LaTeX too."""


def _real_symbols(*sides: Any) -> list[Any]:
    """The symbols of both sides, by name; one that takes no real values is an error."""
    symbols = sorted(set().union(*(side.free_symbols for side in sides)), key=str)
    for symbol in symbols:
        if symbol.is_real is False:
            raise DefinitionError(f"'{symbol}' is not real; inequalities are between real numbers")
    return symbols


@accepts(relation=TEXT, positive=SEVERAL, real=SEVERAL)
def prove_inequality(
    a: Any, relation: str, b: Any = 0, positive: Sequence[Any] = (), real: Sequence[Any] = ()
) -> Verdict:
    r"""Decide whether ``a relation b`` holds wherever both sides are defined.

    ``relation`` is one of < <= > >= != or its LaTeX.  The symbols ``positive``, and those that
    SymPy knows to be positive, run over all positive numbers, those that it knows to be negative
    over all negative ones, every other one over all real numbers; ``real`` names some of these, so
    that one in both lists is a ``DefinitionError``, as is a symbol that is not real, and a
    ``relation`` that is none of these.  Proved: the method says by which certificate.  Refuted: the
    witness is a point, rational in every symbol.  What is not proved of symbols that SymPy knows
    more of, such as integers, is undecided.
    """
    positive, real = (_symbols(given) for given in (positive, real))
    if relation not in RELATIONS:
        raise DefinitionError(
            f"'{quote(relation)}' is no inequality; use one of "
            f"{', '.join(dict.fromkeys(RELATIONS))}"
        )
    both = [s for s in real if s in positive]
    if both:
        raise DefinitionError(f"'{both[0]}' is declared positive and real; declare it once")
    a, b = as_expression(a), as_expression(b)
    symbols = _real_symbols(a, b)
    for symbol in symbols:
        if symbol.is_negative and symbol in (*positive, *real):
            raise DefinitionError(
                f"'{symbol}' is negative for SymPy, and declared otherwise; declare it once"
            )
    bridge = SymPyBridge()
    left, right = bridge.inward(a), bridge.inward(b)
    known = {str(bridge.inward(s)): 1 for s in positive}
    known |= {plain_name(s): 1 if s.is_positive else -1
              for s in symbols if s.is_positive or s.is_negative}  # fmt: skip
    narrow = [s for s in symbols if s not in (*positive, *real) and _is_narrow(s)]
    question = Inequality(left, RELATIONS[relation], right, known, narrow)
    try:
        ring = Ring([left, right, left - right], (), PROOF_LIMIT)
        difference = ring.fraction(left - right)
        signs = Signs.of(ring, [known[name] * se.Symbol(name) > 0 for name in sorted(known)])
    except EngineLimit as limit:
        return question.search((), str(limit))
    sign = signs.of_fraction(difference)
    if sign is not None and sign.settles(question.relation):
        return Verdict("proved", f"the difference of the sides is {sign.in_words}: {sign.reason}")
    roots = signs.linear_zeros(difference.num)
    return question.search(roots, "no certificate of a sign was found")


def _is_narrow(symbol: sp.Symbol) -> bool:
    """Whether SymPy knows more of a symbol than that it is real, or its sign."""
    wide: tuple[dict[str, bool], ...] = ({}, {"real": True}, {"positive": True}, {"negative": True})
    return all(symbol.assumptions0 != sp.Symbol("x", **known).assumptions0 for known in wide)


def _symbols(given: Any) -> tuple[Any, ...]:
    """One or several symbols, given by name or themselves."""
    single = isinstance(given, str) or not isinstance(given, Iterable)
    return tuple(as_expression(s, "a symbol") for s in ((given,) if single else given))
