"""Remarkable trajectories: the same path for every energy [Painleve, Bilimovic].

The accelerations have a part B that is linear in the velocities v, and a part Q that is quadratic.
On a path that is run through at different speeds, B must lie along v; since B does no work, it must
vanish: v is in the kernel of a matrix.  The path stays so where Q keeps v there.
[DragovicGajicJovanovic2020, sec. "Special Solutions"]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.closed.special.precessions import Precessions, essential_rates
from voronec.errors import EngineLimit


@dataclass(frozen=True)
class Remarkable:
    """Paths that do not depend on the energy, away from the poles.

    places
        x on each of them, constant.
    direction
        velocity -> its value, up to a factor that is free, as a function of x: where B vanishes.
    workless
        the proof that B does no work, on which it rests that there are no others.
    """

    places: tuple[sp.Expr, ...]
    direction: Mapping[Any, sp.Expr]
    workless: Verdict


def remarkable(family: Precessions) -> Remarkable:
    """All paths with -1 < x < 1 that motions of every energy follow.

    ``EngineLimit`` where B vanishes for more than one direction, or x would not be constant.
    """
    system = family.system
    rates = essential_rates(family)
    velocities = [v for v in system.essential if v in system.velocities]
    scale = sp.Dummy("scale")
    scaled = {v: scale * v for v in velocities}
    parts = {v: sp.expand(rates[v].xreplace(scaled)) for v in velocities}
    linear = [parts[v].coeff(scale, 1) for v in velocities]
    matrix = sp.Matrix([[sp.diff(b, v) for v in velocities] for b in linear])
    (angle,) = family.quadratures.meaning.free_symbols
    x = family.place
    kernel = family.at_colatitude(matrix).applyfunc(sp.simplify).nullspace()
    if len(kernel) != 1:
        raise EngineLimit(f"the linear part vanishes in {len(kernel)} directions, not in one")
    whole = sp.lcm_list([sp.denom(sp.together(e)) for e in kernel[0]])
    along = {v: sp.cancel(e * whole) for v, e in zip(velocities, kernel[0], strict=True)}
    if family.at_colatitude(rates[angle]).xreplace(along).simplify() != 0:
        raise EngineLimit("x is not constant where the linear part vanishes")
    square = [family.at_colatitude(parts[v].coeff(scale, 2)).xreplace(along) for v in velocities]
    energy = system.integrals.get("energy")
    if energy is None:
        raise EngineLimit(f"system '{system.name}' declares no integral 'energy'")
    power = sum(sp.diff(energy, v).xreplace(dict(family.values)) * b
                for v, b in zip(velocities, linear, strict=True))  # fmt: skip
    return Remarkable(_common(square, x), MappingProxyType(along), prove_equal(sp.expand(power), 0))


def _common(values: list[sp.Expr], x: sp.Symbol) -> tuple[sp.Expr, ...]:
    """Where all of them vanish, in (-1, 1)."""
    above = [sp.numer(sp.together(sp.simplify(v))) for v in values]
    kept = [sp.Poly((v / sp.sqrt(1 - x**2)).simplify() if v.has(sp.sqrt(1 - x**2)) else v, x)
            for v in above if v != 0]  # fmt: skip
    if not kept:
        raise EngineLimit("every x is a remarkable path")
    shared = kept[0]
    for poly in kept[1:]:
        shared = shared.gcd(poly)
    roots = sp.roots(shared.as_expr(), x)
    return tuple(r for r in roots if r.is_real and abs(r) < 1)
