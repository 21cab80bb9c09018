"""Motions by the equations with multipliers, differentiated once and integrated in all velocities:
M q'' - A^T lambda = Q - h, A q'' = -b.  They know neither frame nor split."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo
from voronec import velocity


def multiplier_motion(system: vo.System, start: Mapping[str, float], times: np.ndarray) -> Any:
    """Coordinates (N, k) at times (k,), from coordinates and all their velocities by name."""
    q, dots = system.coordinates, [velocity(x) for x in system.coordinates]
    frame = system.frame
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    meaning |= {p.symbol: sp.N(p.value) for p in system.parameters}

    def spelled(expr: Any) -> sp.Expr:
        return sp.sympify(expr).xreplace(meaning).xreplace(meaning)

    energy = spelled(system.lagrangian)
    slips = [spelled(c) for c in system.constraints]
    slips += [
        sum(sp.diff(r, x) * v for x, v in zip(q, dots, strict=True))
        for r in map(spelled, system.fibration.relations)
    ]
    momenta = [sp.diff(energy, v) for v in dots]

    def drift(expr: Any) -> sp.Expr:
        return sp.Add(*(sp.diff(expr, x) * v for x, v in zip(q, dots, strict=True)))

    parts = [
        sp.Matrix(momenta).jacobian(dots),
        sp.Matrix([drift(p) - sp.diff(energy, x) for p, x in zip(momenta, q, strict=True)]),
        sp.Matrix(slips).jacobian(dots),
        sp.Matrix([drift(c) for c in slips]),
    ]
    names = sp.symbols(f"z0:{2 * len(q)}")
    plain = dict(zip((*dots, *q), (*names[len(q) :], *names[: len(q)]), strict=True))
    function = sp.lambdify([names], [part.xreplace(plain) for part in parts], cse=True)

    def rhs(_time: float, state: np.ndarray) -> np.ndarray:
        mass, force, rows, rest = (np.array(x, dtype=float) for x in function(state))
        whole = np.block([[mass, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
        found = np.linalg.solve(whole, -np.vstack([force, rest]))[:, 0]
        return np.concatenate([state[len(q) :], found[: len(q)]])

    first = [start.get(str(x), 0.0) for x in q] + [start[f"{x}dot"] for x in q]
    found = solve_ivp(rhs, (times[0], times[-1]), first, "DOP853", times, rtol=2.3e-14, atol=1e-14)
    return found.y[: len(q)]


def all_velocities(system: vo.System, start: Mapping[str, float]) -> dict[str, float]:
    """The start with the velocities of all coordinates, by linear algebra on the declarations."""
    dots = [velocity(x) for x in system.coordinates]
    frame = system.frame
    given = {p.symbol: sp.N(p.value) for p in system.parameters}
    given |= {x: sp.Float(start.get(str(x), 0)) for x in system.coordinates}
    rows = list(system.constraints)
    rows += [
        sp.Add(*(sp.diff(r, x) * velocity(x) for x in system.coordinates))
        for r in system.fibration.relations
    ]
    if frame is not None:
        pairs = zip(frame.velocities, frame.expressions, strict=True)
        rows += [e - sp.Float(start[str(v)]) for v, e in pairs]
    else:
        rows += [velocity(x) - sp.Float(start[f"{x}dot"]) for x in system.fibration.base]
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    plain = sp.Matrix([sp.sympify(r).xreplace(meaning).xreplace(given) for r in rows])
    matrix = np.array(plain.jacobian(dots), dtype=float)
    right = -np.array(plain.xreplace(dict.fromkeys(dots, sp.Integer(0))), dtype=float)[:, 0]
    found = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return {**start, **{f"{x}dot": v for x, v in zip(system.coordinates, found, strict=True)}}


def worst(run: vo.Trajectory, truth: np.ndarray) -> float:
    """The largest error of a coordinate."""
    names = [str(x) for x in run.system.coordinates]
    found = np.array([run[name].astype(float) for name in names])
    return float(np.abs(found - truth).max())
