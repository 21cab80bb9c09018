"""Claims about systems of the catalogue for the attack on the prover.

They are functions of their integrals, and the same with a place changed, whose rates the
multipliers tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from random import Random
from typing import Any

import mpmath as mp
import sympy as sp

import voronec as vo
from prover.identities import Letters, mutate
from prover.truth import Outside, Statement, number, slope
from voronec.declaration.claims import right_of
from voronec.equations.motions import Motions
from voronec.proof.claims import decide_integral

CHEAP = ("sleigh", "falling-disc", "vertical-disc", "chaplygin-ball", "suslov", "snakeboard")


@lru_cache(maxsize=16)
def _motions(name: str) -> Motions:
    return Motions.of(vo.load(name))


@lru_cache
def _names() -> tuple[str, ...]:
    return tuple(name for name in vo.names() if vo.load(name).integrals)


def catalogue(dice: Random, declared: bool, true: bool) -> Statement | None:
    """Functions of the integrals of a system of the catalogue, and changes of them."""
    name = dice.choice(CHEAP) if dice.random() < 0.5 else dice.choice(_names())
    system = vo.load(name)
    parts = tuple(right_of(e) for e in system.integrals.values())
    if not parts or name in ("bicycle",):
        return None
    function = dice.choice(parts)
    if sp.count_ops(function) > 150:
        return None
    letters = tuple(sorted(function.free_symbols, key=str))
    function = dice.choice((function, 2 * function + 1, function**2, sp.sin(function)))
    if not true:
        function = mutate(Letters(dice, declared, letters, letters), function)
        odd = (sp.zoo, sp.nan, sp.I, sp.Derivative, sp.Subs)
        if function.has(*odd) or _changes(system, function, dice) is not True:
            return None
    text = f"{system.name}: integral {function}"
    return Statement(
        "catalogue", text, true, lambda: decide_integral(_motions(name), function).verdict
    )


def _changes(system: vo.System, function: Any, dice: Random) -> bool | None:
    """Whether a function of coordinates and their velocities changes along a motion, by the
    accelerations of the multipliers; None where that is not asked so."""
    if system.fibration.relations or system.on_group or system.inputs:
        return None
    frame = system.frame.expressions if system.frame is not None else ()
    held = dict(zip(system.velocities, frame, strict=False))
    told = function.xreplace({v: e for v, e in held.items() if v not in system.coordinates})
    dots = [vo.velocity(s) for s in system.coordinates]
    symbols = {*system.coordinates, *dots, *(p.symbol for p in system.parameters)}
    if not told.free_symbols <= symbols:
        return None
    for at in states(system, dice):
        try:
            with mp.workdps(60):
                exact = {s: mp.mpf(v.p) / v.q for s, v in at.items()}
                full = {**exact, **coordinate_rates(system, exact)}
            second = accelerations(system, at)
            with mp.workdps(60):
                rates = {vo.velocity(s): second[s] for s in system.coordinates}
                rates |= {s: full[d] for s, d in zip(system.coordinates, dots, strict=True)}
                rate = slope(told, full, rates)
        except (Outside, ZeroDivisionError, vo.VoronecError, TypeError, ValueError, KeyError):
            continue
        if abs(rate) > mp.mpf(10) ** -8:
            return True
    return None


def accelerations(system: vo.System, at: Mapping[Any, Any]) -> dict[Any, Any]:
    """Second derivatives of the coordinates, by the multipliers."""
    point = {
        s: v if isinstance(v, sp.Basic) else sp.Float(mp.nstr(v, 55), 55) for s, v in at.items()
    }
    found = vo.multiplier_acceleration(system, point, digits=40)
    return {s: mp.mpf(str(found[s])) for s in system.coordinates}


def states(system: vo.System, dice: Random) -> Iterator[dict[Any, sp.Rational]]:
    """Three random states, with the parameters of the system where it gives them."""
    for _ in range(3):
        at = {s: sp.Rational(dice.randint(20, 120), 97) for s in system.coordinates}
        at |= {v: sp.Rational(dice.randint(-200, 200), 97) for v in system.velocities}
        for p in system.parameters:
            value = sp.sympify(p.value)
            known = isinstance(value, sp.Rational) and value > 0
            at[p.symbol] = value if known else sp.Rational(dice.randint(50, 150), 97)
        yield at


def coordinate_rates(system: vo.System, at: Mapping[Any, Any]) -> dict[Any, Any]:
    """Coordinate velocities from those of the equations and the constraints, which are affine."""
    dots = [vo.velocity(s) for s in system.coordinates]
    rows = list(system.constraints)
    frame = system.frame.expressions if system.frame is not None else ()
    rows += [e - v for v, e in zip(system.velocities, frame, strict=False)] or [
        v - at[v] for v in system.velocities
    ]
    zero = {**at, **dict.fromkeys(dots, mp.mpf(0))}
    given = {v: at[v] for v in system.velocities}
    right = [-number(r, {**zero, **({} if frame == () else given)}) for r in rows]
    matrix = mp.matrix(len(rows), len(dots))
    for j, d in enumerate(dots):
        for i, r in enumerate(rows):
            held = {**zero, d: mp.mpf(1), **({} if frame == () else given)}
            matrix[i, j] = number(r, held) + right[i]
    found = mp.lu_solve(matrix, mp.matrix(right))
    return dict(zip(dots, found, strict=True))
