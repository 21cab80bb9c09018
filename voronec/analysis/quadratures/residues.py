"""The poles of a rate that is rational in the variable, and the residues there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.normal import quotient
from voronec.algebra.points import sample_evaluable
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import Verdict
from voronec.analysis.quadratures.ground import Ground
from voronec.errors import EngineLimit
from voronec.reading import shown

__all__ = ["decide_residues"]

FREE = se.Symbol("variable")
HIGHEST = 2
"""The degree of the polynomial that is left of a rate without its poles."""
BITS = 192
"""The precision in which residues are read off."""


def decide_residues(ground: Ground, rate: sp.Expr) -> Verdict:
    """A rate has simple poles where they are declared, with residues w, -w or 0, and no others.

    The denominator has as many roots as its degree, all of them declared; and the fraction grows
    no faster than the square of the variable.
    """
    door, motion = ground.field.door, ground.motion
    fraction = quotient(door.inward(rate).xreplace({door.inward(motion.x): FREE}))
    top, bottom = map(_degree, fraction)
    if top > bottom + HIGHEST:
        return Verdict("undecided", f"the rate grows with '{motion.x}' beyond its square")
    if bottom == 0:
        return Verdict("proved", "the rate is a polynomial")
    given = [*motion.poles.items(), *((c, None) for c in motion.others)]
    poles = [
        _Pole.of(door.inward(c), None if w is None else door.inward(w), fraction) for c, w in given
    ]
    shares = _shares(ground, poles)
    if len(shares) != bottom:
        told = f"the rate has {bottom} poles, of which {len(shares)} are declared"
        return Verdict("undecided", told)
    residuals = [(f"pole {shown(pole.place)}", pole.bottom) for pole in shares]
    residuals += [(f"residue at {shown(p.place)}", p.excess(n)) for p, n in shares.items()]
    verdict = ground.zero(residuals)  # for any values of the constants, as if nothing bound them
    if verdict.proved:
        return verdict
    return ground.zero([(label, ground.at_level(e)) for label, e in residuals])


@dataclass(frozen=True)
class _Pole:
    """A fraction top/bottom at a declared pole: both, and the slope of the bottom, there.

    Without a weight the residue may be any.
    """

    place: Any
    weight: Any
    top: Any
    bottom: Any
    slope: Any

    @classmethod
    def of(cls, place: Any, weight: Any, fraction: tuple[Any, Any]) -> _Pole:
        """The values at a place."""
        values = (e.xreplace({FREE: place}) for e in (*fraction, fraction[1].diff(FREE)))
        return cls(place, weight, *values)

    @property
    def share(self) -> Any:
        """The residue in units of the weight."""
        if self.weight is None:
            return se.Integer(0)
        return self.top / (self.slope * self.weight)

    def excess(self, share: int) -> Any:
        """What vanishes where the residue is so many weights."""
        if self.weight is None:
            return se.Integer(0)
        return self.top - share * self.weight * self.slope


def _shares(ground: Ground, poles: Sequence[_Pole]) -> dict[_Pole, int]:
    """The poles at which the fraction has one, each place once; and how many weights the residue
    is there, -1, 0 or 1, as numbers suggest."""
    seen = [ground.at_level(e) for p in poles for e in (p.place, p.bottom, p.share)]
    for _, values in sample_evaluable(Tape(seen), ground.field.hypotheses, BITS, count=1):
        found: dict[_Pole, int] = {}
        places: list[Any] = []
        for i, pole in enumerate(poles):
            place, bottom, share = values[3 * i : 3 * i + 3]
            if bottom.contains(0) and not any(place.overlaps(c) for c in places):
                found[pole] = max(-1, min(1, round(float(share.mid()))))
                places.append(place)
        return found
    raise EngineLimit("no point was found at which the residues can be read off")


def _degree(polynomial: Any) -> int:
    """The degree in the variable of an expanded polynomial."""
    degree = -1
    while polynomial != 0:
        polynomial, degree = se.expand(polynomial.diff(FREE)), degree + 1
    return degree
