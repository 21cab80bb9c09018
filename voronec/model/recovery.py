"""Angles read off invariants.

Where two functions of the invariants are a = r cos(q), b = r sin(q), with r free of the angle q,
the angle is atan2(b, a) up to a half turn; and r itself, the root of a^2 + b^2 up to its sign, is
one more function to read others off, such as the colatitude u from cos(u) and r = sin(u).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import combinations, permutations
from typing import Any

import symengine as se

from voronec.algebra.verdicts import all_vanish
from voronec.vector_field import Motions

__all__ = ["Angle", "recovered_angles"]


@dataclass(frozen=True)
class Angle:
    """q = atan2(sine, cosine) up to signs and turns that the start tells.

    Both are in terms of the invariants, with a common factor r whose sign does not change while the
    chart holds; a root stands for a factor of either sign, and keeps it too.  ``meaning`` is what
    the two are, r cos(q) and r sin(q), in the coordinates; ``roots`` tells which of them is a root.
    """

    coordinate: Any
    cosine: Any
    sine: Any
    meaning: tuple[Any, Any]
    roots: tuple[bool, bool]

    def mapped(self, on: Callable[[Any], Any]) -> Angle:
        """The angle with its expressions replaced."""
        return replace(self, cosine=on(self.cosine), sine=on(self.sine))

    def signs(self, start: Mapping[Any, float]) -> tuple[int, int]:
        """With which signs of cosine and sine the angle is what it is at the start.

        ``start`` gives the numbers of the coordinates there, and of parameters.
        """
        begin = float(start[self.coordinate])
        true = [float(e.subs(dict(start)).n(53, real=True)) for e in self.meaning]
        reverse = -1 if true[0] * math.cos(begin) + true[1] * math.sin(begin) < 0 else 1
        # a root is never negative, what it stands for may be
        i, j = (-1 if root and x < 0 else 1 for x, root in zip(true, self.roots, strict=True))
        return reverse * i, reverse * j

    @property
    def symbols(self) -> set[Any]:
        """What it is read off."""
        return set(self.cosine.free_symbols | self.sine.free_symbols)


def recovered_angles(motions: Motions, wanted: Mapping[str, Any]) -> dict[str, Angle]:
    """Those wanted quantities that are coordinates and can be read off the invariants."""
    d, door = motions.equations.definition, motions.equations.door
    names = {e: name for name, e in wanted.items() if e in d.coordinates}
    if not names:
        return {}
    known = [(se.Symbol(name), door.inward(g)) for name, g in motions.system.invariants.items()]
    angles = [q for q in d.coordinates if any(se.has_symbol(g, q) for _, g in known)]
    found: dict[Any, Angle] = {}
    while True:
        fresh = _next(known, [q for q in angles if q not in found])
        if fresh is None:
            break
        angle, modulus, meaning = fresh
        found[angle.coordinate] = angle
        if modulus is not None:
            known.append((modulus, meaning))
    return {name: found[q] for q, name in names.items() if q in found}


def _next(known: Iterable[tuple[Any, Any]], angles: Iterable[Any]) -> tuple[Angle, Any, Any] | None:
    """One more angle, and the factor that is known with it: as read off, and as it is."""
    functions = list(known)
    for q in angles:
        for pair in combinations([f for f in functions if se.has_symbol(f[1], q)], 2):
            for (a, cosine), (b, sine) in permutations(pair):
                for sign in (1, -1):
                    if not _turns(cosine, sign * sine, q):
                        continue
                    factor = _factor(cosine, sign * sine, q)
                    root = se.sqrt(a**2 + b**2)
                    angle = Angle(
                        q, a, sign * b, (cosine, sign * sine), (bool(a.args), bool(b.args))
                    )  # fmt: skip
                    return angle, (None if factor is None else root), factor
    return None


def _turns(cosine: Any, sine: Any, q: Any) -> bool:
    """Whether the two are a factor times cos(q) and sin(q), up to one turn for both."""
    return all_vanish([cosine.diff(q) + sine, sine.diff(q) - cosine]) and all_vanish(
        [cosine * se.sin(q) - sine * se.cos(q)]
    )


def _factor(cosine: Any, sine: Any, q: Any) -> Any | None:
    """r = a cos(q) + b sin(q), in the other coordinates."""
    total = cosine.subs({q: 0})
    return total if all_vanish([cosine * se.cos(q) + sine * se.sin(q) - total]) else None
