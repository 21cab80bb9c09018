"""Points at which an inequality fails."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, product
from random import Random
from typing import Any

import flint
import symengine as se

from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import Verdict, Witness, decide_equal

__all__ = ["Question"]

_TIES = 60
"""How many points, at which balls cannot tell the sides apart, are looked at exactly."""


@dataclass(frozen=True)
class Question:
    """Whether ``left relation right``, in symengine; ``positive`` are names of symbols."""

    left: Any
    relation: str
    right: Any
    positive: frozenset[str]

    def violated_by(self, difference: Any) -> bool:
        """Whether a ball around the difference shows that the relation fails."""
        tests = {"<": difference > 0, ">": difference < 0, "<=": difference > 0}
        return bool({**tests, ">=": difference < 0, "!=": False}[self.relation])

    def searched(self, roots: Sequence[tuple[Any, Any]], reason: str) -> Verdict:
        """Refuted by a point, or undecided."""
        tape = Tape([self.left, self.right])
        ties = _TIES if self.relation in ("<", ">", "!=") else 0
        for point in self._points(tape.atoms, roots):
            left, right = tape.arb(point, 160)
            if not (left.is_finite() and right.is_finite()):
                continue
            if self.violated_by(left - right):
                return Verdict("refuted", "a rational point", _witness(point, left, right))
            if ties and (left - right).contains(0):
                ties -= 1
                at = {atom: _exact(value) for atom, value in point.items()}
                if decide_equal(self.left.xreplace(at), self.right.xreplace(at)).proved:
                    method = "a rational point at which both sides are equal"
                    return Verdict("refuted", method, _witness(point, left, left))
        return Verdict("undecided", f"{reason}, nor a point that refutes it")

    def _points(self, atoms: Sequence[Any], roots: Sequence[Any]) -> Iterator[dict[Any, Any]]:
        """Small numbers first, then numbers of all sizes; each is moved onto each root, too."""
        for values in self._values(len(atoms)):
            signed = zip(atoms, values, strict=True)
            point = {a: abs(v) + (not v) if str(a) in self.positive else v for a, v in signed}
            yield point
            for variable, root in roots:
                value = _value(root, point)
                if value is not None:
                    moved = flint.fmpq(int(value.p), int(value.q))
                    if str(variable) not in self.positive or moved > 0:
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
        value = root.xreplace({a: _exact(v) for a, v in point.items()})
    except RuntimeError:  # symengine cannot multiply complex infinity by a complex number
        return None
    return value if value.is_Number and getattr(value, "q", 0) != 0 else None


def _exact(value: Any) -> Any:
    return se.Integer(int(value.p)) / se.Integer(int(value.q))


def _witness(point: dict[Any, Any], left: Any, right: Any) -> Witness:
    named = {str(atom): str(value) for atom, value in point.items()}
    return Witness(named, _spelled(left), _spelled(right))


def _spelled(ball: Any) -> str:
    """Thirty digits; a ball about zero that is left beside an exact answer is zero."""
    return "0" if ball.contains(0) else str(ball.str(30, radius=False))
