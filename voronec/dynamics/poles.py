"""Variables that are regular at the poles of spherical coordinates and of Euler's angles.

There the angles have no values, and steady motions such as a sleeping top are none in them.  With

    gamma = R^T e,   omega                      of a body, R its attitude and e its polar axis,
    n = (sin theta cos phi, sin theta sin phi, cos theta),   dn1/dt, dn2/dt        of a direction

as invariants and velocities, equations that close in these are regular.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import count
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.symbols import plain_name
from voronec.declaration.claims import right_of
from voronec.declaration.geometry import Frame
from voronec.declaration.system import bare, spell_out
from voronec.dynamics.natural_integrals import is_long
from voronec.equations.attitudes import EulerAngles, euler_angles
from voronec.equations.voronec_equations import VoronecEquations, derive
from voronec.errors import VoronecError

DIRECTION = ("n1", "n2", "n3", "n1dot", "n2dot")
BODY = ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")


def regular_at_poles(
    equations: VoronecEquations, variables: tuple[Any, ...]
) -> tuple[VoronecEquations, tuple[tuple[str, ...], ...]] | None:
    """The equations in such variables, and for each attitude the names of those that vanish at its
    poles; None where no attitude has its polar angle among the ``variables``, and where there are
    no such equations."""
    if equations.definition.group is not None or is_long(equations):
        return None
    base = equations.definition.coordinates[: equations.definition.base]
    angles = [t for t in euler_angles(equations)
              if t.theta in variables and {*t.symbols} <= {*base}]  # fmt: skip
    if not angles:
        return None
    with suppress(VoronecError):
        return equations.memo.once("regular at poles", lambda: _rewrite(equations, angles))
    return None


def _rewrite(
    equations: VoronecEquations, angles: list[EulerAngles]
) -> tuple[VoronecEquations, tuple[tuple[str, ...], ...]]:
    d, system = equations.definition, equations.system
    taken, out = {plain_name(s) for s in system.known_symbols()}, d.bridge.outward
    rates, dots = dict[Any, Any](), dict(zip(d.coordinates, d.dots, strict=True))
    invariants, polar = dict(system.invariants), []
    for t in angles:
        vector, spin = _vector(t, dots)
        names = _fresh(DIRECTION if t.psi is None else BODY, taken)
        invariants |= zip(names[:3], map(out, vector), strict=True)
        rates |= zip(map(sp.Symbol, names[3:]), map(out, spin), strict=True)
        polar.append(names[:2])
    turning = {x for t in angles for x in t.symbols}
    for q in d.coordinates[: d.base]:
        if q not in turning:
            rates[sp.Symbol(_fresh((f"{q}_rate",), taken)[0])] = out(dots[q])
    frame = system.frame
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    integrals = {n: right_of(e).xreplace(meaning) for n, e in system.integrals.items()}
    moved = bare(system, system.name, **spell_out(system, frame), frame=Frame.quasi(rates),
                 invariants=invariants, integrals=integrals)  # fmt: skip
    return derive(moved), tuple(polar)


def _vector(t: EulerAngles, dots: dict[Any, Any]) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The polar axis, or the direction, and the velocities."""
    phi, theta, psi = t.upright
    turn = phi if t.psi is None else sp.pi / 2 - psi
    across, up = se.sin(theta), se.cos(theta)
    vector = (across * se.cos(turn), across * se.sin(turn), up)
    if t.psi is not None:
        return vector, t.body_rates(dots)
    return vector, tuple(se.Add(*[e.diff(q) * dots[q] for q in t.symbols]) for e in vector[:2])


def _fresh(names: tuple[str, ...], taken: set[str]) -> tuple[str, ...]:
    """The names with one number behind them, where one of them is taken."""
    tries: Iterator[tuple[str, ...]] = (
        tuple(f"{n}_{i}" for n in names) if i else names for i in count()
    )
    fresh = next(each for each in tries if not taken & {*each})
    taken |= {*fresh}
    return fresh
