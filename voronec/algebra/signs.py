"""Inequalities with three answers: proved by a certificate, refuted at a rational point, undecided.

A polynomial has a sign where its factors have one; a factor where it is a sum of terms of one sign,
a quadratic form that its discriminant makes definite, or a polynomial in one variable without
roots.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.certificates import Signs
from voronec.algebra.counterexamples import Question
from voronec.algebra.domains import RELATIONS, mirrored, real_symbols, refuse_signs
from voronec.algebra.door import Door
from voronec.algebra.ring import Ring
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import sympified
from voronec.algebra.verdicts import PROOF_LIMIT, Verdict
from voronec.arguments import SEVERAL, TEXT, accepts
from voronec.errors import DefinitionError, EngineLimit, shown

__all__ = ["RELATIONS", "known_sign", "prove_inequality"]


@accepts(relation=TEXT, positive=SEVERAL, real=SEVERAL)
def prove_inequality(
    a: Any, relation: str, b: Any = 0, positive: Sequence[Any] = (), real: Sequence[Any] = ()
) -> Verdict:
    r"""Decide whether ``a relation b`` holds wherever both sides are defined.

    ``relation`` is one of < <= > >= != or its LaTeX.  The symbols ``positive``, and those that
    SymPy knows to be positive, run over all positive numbers, those that it knows to be negative
    over all negative ones, every other one over all real numbers, whatever else SymPy knows;
    ``real`` names some of these, so that one in both lists is an error, as is a symbol that is not
    real.  Proved: the method says by which certificate.  Refuted: the witness is a point, rational
    in every symbol.
    """
    positive, real = (_symbols(given) for given in (positive, real))
    if relation not in RELATIONS:
        raise DefinitionError(
            f"'{shown(relation)}' is no inequality; use one of "
            f"{', '.join(dict.fromkeys(RELATIONS))}"
        )
    both = [s for s in real if s in positive]
    if both:
        raise DefinitionError(f"'{both[0]}' is declared positive and real; declare it once")
    a, b = sympified(a), sympified(b)
    symbols = real_symbols(a, b)
    below = {s: sp.Symbol(f"|{s.name}|") for s in symbols if s.is_negative}
    if below:
        refuse_signs(below, (*positive, *real))
        mirror = {s: -size for s, size in below.items()}
        sizes = (*positive, *below.values())
        return mirrored(
            prove_inequality(a.xreplace(mirror), relation, b.xreplace(mirror), sizes, real)
        )
    door = Door()
    left, right = door.inward(a), door.inward(b)
    above = {str(door.inward(s)) for s in positive}
    above |= {plain_name(s) for s in symbols if s.is_positive}
    question = Question(left, RELATIONS[relation], right, frozenset(above))
    try:
        ring = Ring([left, right], (), PROOF_LIMIT)
        difference = ring.fraction(left - right)
        signs = Signs.of(ring, [se.Symbol(name) > 0 for name in sorted(above)])
    except EngineLimit as limit:
        return question.searched((), str(limit))
    found = signs.of_fraction(difference)
    if found is not None and found.settles(question.relation):
        return Verdict("proved", f"the difference of the sides is {found.in_words}: {found.reason}")
    roots = signs.vanishing(difference.num)
    return question.searched(roots, "no certificate of a sign was found")


def _symbols(given: Any) -> tuple[Any, ...]:
    """One or several symbols, given by name or themselves."""
    single = isinstance(given, str) or not isinstance(given, Iterable)
    return tuple(sympified(s, "a symbol") for s in ((given,) if single else given))


def known_sign(expr: Any, hypotheses: Sequence[Any] = (), strict: bool = False) -> int:
    """1 or -1 where an expression inside the door is proved to have nowhere the other sign, or 0.

    ``hypotheses`` vanish, or are conditions that hold; ``strict``: nor is it zero.
    """
    try:
        ring = Ring([expr], hypotheses)
        found = Signs.of(ring, hypotheses, bounded=True).of_fraction(ring.fraction(expr))
    except EngineLimit:
        return 0
    return found.value if found is not None and (found.strict or not strict) else 0
