"""Points at which equations are evaluated: random, the same every time, on the relations."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

import mpmath as mp
import sympy as sp
from sympy.core.function import AppliedUndef

from voronec.algebra.symbols import time
from voronec.algebra.text import sympified
from voronec.system import System

__all__ = ["is_general", "random_point"]

DIGITS = 90
"""How well a point lies on the relations between redundant coordinates."""


def is_general(system: System) -> bool:
    """Whether a system holds functions that nobody has given, as E(u, v); it has no numbers."""
    held = (system.lagrangian, *system.constraints, *system.forces.values())
    named = {*system.coordinates}
    return any(e.atoms(AppliedUndef) - named for e in map(sympified, held))


def random_point(system: System, seed: int = 0) -> dict[Any, Any]:
    """Coordinates, velocities and the time; parameters near their defaults, with their signs.

    Everything is rational but for redundant coordinates, which Newton's steps bring onto their
    relations.
    """
    source = random.Random(f"{system.name} {seed}")
    state = {s: _number(source) for s in (*system.coordinates, *system.velocities, time)}
    scaled = {}
    for parameter in system.parameters:
        value = 1 if parameter.value is None else parameter.value
        scaled[parameter.symbol] = value * (1 + abs(_number(source)) / 4)
    return _on_relations(system, scaled | state)


def _number(source: random.Random) -> sp.Rational:
    return sp.Rational(source.choice((-1, 1)) * source.randint(200, 1500), 1009)


def _on_relations(system: System, point: Mapping[Any, Any]) -> dict[Any, Any]:
    names, relations = system.coordinates, sp.Matrix(system.fibration.relations)
    moved = dict(point)
    if not relations:
        return moved
    with mp.workdps(DIGITS):
        for _ in range(12):
            at = {k: sp.N(v, DIGITS) for k, v in moved.items()}
            slope = relations.jacobian(names).xreplace(at).evalf(DIGITS)
            residual = relations.xreplace(at).evalf(DIGITS)
            step = slope.T * (slope * slope.T).LUsolve(residual)
            moved |= {n: at[n] - d for n, d in zip(names, step, strict=True)}
    return moved
