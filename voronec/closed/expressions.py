"""What a motion's numbers mean: cosines of traces, rates of angles, velocities, as expressions.

In the velocities a system declares, sines and cosines of colatitudes and the velocities of
coordinates are symbols, each of which has its own accurate value along the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.closed.compiled_motion import Prepared

__all__ = ["Reading", "reading_of", "velocities_in_doubles"]


@dataclass(frozen=True, eq=False)
class Reading:
    """The velocities of the equations, to be evaluated along a motion.

    ``symbols`` are the level's, then ``x``, then for each trace sine and cosine of its colatitude
    and the colatitude's velocity, then the velocity of each angle, then ``coordinates``, then
    what stands for ``polynomials`` in x; ``expressions`` in these, in the order of ``velocities``.
    """

    symbols: tuple[Any, ...]
    coordinates: tuple[Any, ...]
    polynomials: tuple[Any, ...]
    expressions: tuple[Any, ...]
    velocities: tuple[Any, ...]


def reading_of(own: Prepared) -> Reading:
    """The velocities of a prepared motion."""
    return own.memo.once("reading", lambda: _make_reading(own))


def _make_reading(own: Prepared) -> Reading:
    motion, symbols = own.motion, [*own.level, own.motion.x]
    meaning: dict[Any, Any] = {}
    for i, trace in enumerate(motion.traces):
        sine, cosine, rate = sp.symbols(f"sine{i} cosine{i} colatitude_rate{i}", cls=sp.Dummy)
        meaning |= {sp.sin(trace.colatitude): sine, sp.cos(trace.colatitude): cosine,
                    velocity(trace.colatitude): rate}  # fmt: skip
        symbols += [sine, cosine, rate]
    for q in motion.angles:
        rate = sp.Dummy(f"rate of {q}")
        meaning[velocity(q)] = rate
        symbols.append(rate)
    declared = {velocity(q): velocity(q) for q in own.system.coordinates} | dict(motion.velocities)
    found = tuple(declared[v].xreplace(meaning) for v in own.system.velocities)
    held = {s for e in found for s in e.free_symbols}
    coordinates = tuple(q for q in own.system.coordinates if q in held)
    moving = {*symbols[len(own.level) + 1 :], *coordinates}
    kept: dict[Any, Any] = {}
    found = tuple(_lift(e, own.motion.x, moving, kept) for e in found)
    symbols += [*coordinates, *kept.values()]
    return Reading(tuple(symbols), coordinates, tuple(kept), found, tuple(own.system.velocities))


def _lift(expr: Any, x: Any, moving: set[Any], kept: dict[Any, Any]) -> Any:
    """The expression with symbols for what it holds of parameters, constants and x as a polynomial:
    1 + R2/R1 is no good in doubles where R1 is nearly -R2."""
    if expr.is_Atom:
        return expr
    if not expr.free_symbols & moving and expr.free_symbols and expr.is_polynomial(x):
        return kept.setdefault(expr, sp.Dummy(f"polynomial{len(kept)}"))
    return expr.func(*(_lift(a, x, moving, kept) for a in expr.args)) if expr.args else expr


def velocities_in_doubles(own: Prepared) -> Any:
    """The velocities of the equations as a function of arrays, in the order of a reading."""
    read = reading_of(own)
    return own.memo.once(
        "velocities in doubles",
        lambda: sp.lambdify(read.symbols, list(read.expressions), "numpy", cse=True),
    )
