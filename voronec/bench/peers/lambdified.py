"""What a user of SymPy does: ``lambdify`` the equations and hand them to scipy.

From the coordinates, mass matrix and force are lambdified, as of ``KanesMethod``, and solved by
numpy at each evaluation.  From the invariants a good hand writes the accelerations out, so that
they are lambdified to plain ``math`` without arrays: an order of magnitude faster.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from voronec.bench.contender import Contender, NotHere, Outcome, Run, timed
from voronec.bench.level import Level, level
from voronec.bench.question import Question
from voronec.errors import VoronecError
from voronec.vector_field import VectorField

__all__ = ["LAMBDIFIED"]

TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)
LONGEST = 20_000
"""Characters of a right-hand side beyond which no hand writes it out."""

RightSide = Callable[[float, np.ndarray], Any]


def _prepare(question: Question, method: str, name: str) -> Run:
    try:
        at = level(question, name)
    except VoronecError as refusal:
        raise NotHere(str(refusal)) from None
    right = _solved(at) if name == "coordinates" else _written_out(at)
    start = at.state

    def run(tol: float) -> Outcome:
        from scipy.integrate import solve_ivp

        grid = question.grid
        found, seconds = timed(
            lambda: solve_ivp(
                right, (grid[0], grid[-1]), start, method=method, t_eval=grid, rtol=tol, atol=tol
            )
        )
        if not found.success or found.y.shape[1] < len(grid):
            raise NotHere(f"scipy stopped: {found.message}")
        values, drift = at.observed(grid, found.y.T)
        return Outcome(values, seconds, int(found.nfev), 0, drift)

    return run


def _solved(at: Level) -> RightSide:
    """Rates, mass and force by one call, the accelerations by ``numpy.linalg.solve``."""
    field, n = at.field, len(at.field.velocities)
    mass = [e for row in field.mass for e in row]
    function = _lambdified(field, [*field.rates, *mass, *field.force], "numpy")
    constants, k = at.constants, len(field.rates)

    def right(t: float, y: np.ndarray) -> np.ndarray:
        flat = np.array(function(t, *y, *constants), dtype=float)
        solved = np.linalg.solve(flat[k : k + n * n].reshape(n, n), flat[k + n * n :])
        return np.concatenate([flat[:k], solved])

    return right


def _written_out(at: Level) -> RightSide:
    """All derivatives by one call on floats; by ``_solved`` where they are too long to write."""
    derivatives = at.field.components
    if sum(len(str(e)) for e in derivatives) > LONGEST:
        return _solved(at)
    function = _lambdified(at.field, derivatives, "math")
    constants = at.constants
    return lambda t, y: function(t, *y.tolist(), *constants)


def _lambdified(field: VectorField, exprs: Any, modules: str) -> Callable[..., Any]:
    symbols = [field.time, *field.variables, *field.parameters]
    plain = {s: sp.Symbol(f"z{i}") for i, s in enumerate(symbols)}
    names = {sp.sympify(s): p for s, p in plain.items()}
    return sp.lambdify(
        list(plain.values()), [sp.sympify(e).xreplace(names) for e in exprs], modules, cse=True
    )


def _peer(method: str, at: str) -> Contender:
    short = method.lower()
    about = f"scipy {method} with lambdify of the equations on the {at}"
    return Contender(
        f"{short}-lambdify-{at}", about, TOLERANCES, partial(_prepare, method=method, name=at)
    )


LAMBDIFIED = tuple(
    _peer(method, at) for method in ("DOP853", "LSODA") for at in ("invariants", "coordinates")
)
