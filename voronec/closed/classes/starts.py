"""Starts that are to be shown: upright in space, and away from a pole of a sphere."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.algebra.text import sympified
from voronec.closed.form import ClosedForm
from voronec.closed.upright import turned_upright
from voronec.system import System

__all__ = ["elsewhere", "fill"]

SHARE = sp.Rational(1, 3)
LARGEST = 60
"""The largest denominator of a cosine at which a motion is started anew."""


def fill(system: System, own: Mapping[Any, Any], start: Mapping[Any, Any]) -> dict[Any, Any]:
    """A start with the coordinates in space such that the constant vector is upright."""
    space = system.motion.space if system.motion is not None else None
    if space is None:
        return dict(start)
    values = {**own, **start}
    vector = [sp.nsimplify(sp.simplify(e.xreplace(values))) for e in space.vector]
    turned = {q: sp.simplify(e) for q, e in turned_upright(space, vector).items()}
    return {**start, **{q: sp.Integer(0) if e is sp.nan else e for q, e in turned.items()}}


def elsewhere(closed: ClosedForm, start: Mapping[Any, Any]) -> dict[Any, Any]:
    """The same motion from another point, in exact numbers; for a start at which a trace is at its
    pole.  It is left where coordinates or velocities are not given by x alone."""
    motion, problem = closed.quadratures, closed.problem
    moving = [q for q in closed.system.coordinates if motion.meaning.has(q)]
    if len(moving) != 1:
        return dict(start)
    (q,) = moving
    low, high = closed.ends
    place = sp.Rational(low + (high - low) * float(SHARE)).limit_denominator(LARGEST)
    level = {s: sp.nsimplify(sp.simplify(problem.spelled(s))) for s in motion.constants}
    level |= {p.symbol: sympified(problem.values[p.symbol]) for p in closed.system.parameters}
    level |= {motion.x: place}
    solved = sp.solve(motion.meaning - place, q)
    angle = next(a for a in solved if 0 <= float(a) <= float(sp.pi))
    pace = sp.sqrt(sp.simplify(motion.quartic.xreplace(level)))
    rates = {velocity(p): e.xreplace(level) for p, e in motion.integrals.items()}
    rates[velocity(q)] = pace / sp.diff(motion.meaning, q).subs(q, angle)
    found = {**dict.fromkeys(closed.system.coordinates, sp.Integer(0)), q: angle}
    for v in closed.system.velocities:
        value = motion.velocities.get(v, v).xreplace({**rates, **level, q: angle})
        found[v] = sp.nsimplify(sp.simplify(value))
    return found
