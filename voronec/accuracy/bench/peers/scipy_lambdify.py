"""What a user of SymPy does: ``lambdify`` the equations and hand them to scipy.

From the coordinates, mass matrix and force are lambdified, as of ``KanesMethod``, and solved by
numpy at each evaluation.  From the invariants a good hand writes the accelerations out, so that
they are lambdified to plain ``math`` without arrays: an order of magnitude faster.  Without that
thought, ``lambdify`` with nothing else said writes the same for numpy, term by term (``plain``).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from voronec.accuracy.bench.contender import (
    Contender,
    NotHere,
    Outcome,
    Run,
    level_for,
    time_fastest,
)
from voronec.accuracy.problem import ProblemLevel, ReferenceProblem
from voronec.algebra.text import as_expression
from voronec.equations.vector_field import VectorField

__all__ = ["BY_LAMBDIFY"]

TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13)
LONGEST = 20_000
"""Characters of a right-hand side beyond which no hand writes it out."""

RightSide = Callable[[float, np.ndarray], Any]


def _prepare(question: ReferenceProblem, method: str, name: str, kind: str) -> Run:
    at = level_for(question, name)
    right = RIGHT_SIDES[kind](at)
    start = at.state

    def run(tol: float) -> Outcome:
        from scipy.integrate import solve_ivp

        grid = question.grid
        found, seconds = time_fastest(
            lambda: solve_ivp(
                right, (grid[0], grid[-1]), start, method=method, t_eval=grid, rtol=tol, atol=tol
            )
        )
        if not found.success or found.y.shape[1] < len(grid):
            raise NotHere(f"scipy stopped: {found.message}")
        values, drift = at.outputs_and_drift(grid, found.y.T)
        return Outcome(values, seconds, int(found.nfev), 0, drift)

    return run


def _solve_by_numpy(at: ProblemLevel) -> RightSide:
    """Rates, mass and force by one call, the accelerations by ``numpy.linalg.solve``."""
    field, n = at.field, len(at.field.velocities)
    mass = [e for row in field.mass for e in row]
    function = _lambdify(field, [*field.rates, *mass, *field.force], "numpy")
    constants, k = at.constants, len(field.rates)

    def right(t: float, y: np.ndarray) -> np.ndarray:
        flat = np.array(function(t, *y, *constants), dtype=float)
        solved = np.linalg.solve(flat[k : k + n * n].reshape(n, n), flat[k + n * n :])
        return np.concatenate([flat[:k], solved])

    return right


def _write_derivatives(at: ProblemLevel, plain: bool) -> RightSide:
    """All derivatives by one call on floats; ``plain``: as it comes, in numpy's functions, common
    parts computed again.  By ``_solve_by_numpy`` where they are too long to write."""
    derivatives = at.field.components
    if sum(len(str(e)) for e in derivatives) > LONGEST:
        return _solve_by_numpy(at)
    function = _lambdify(at.field, derivatives, "numpy" if plain else "math", cse=not plain)
    constants = at.constants
    return lambda t, y: function(t, *(y if plain else y.tolist()), *constants)


def _lambdify(field: VectorField, exprs: Any, modules: str, cse: bool = True) -> Callable[..., Any]:
    symbols = [field.time, *field.variables, *field.parameters]
    plain = {s: sp.Symbol(f"z{i}") for i, s in enumerate(symbols)}
    names = {as_expression(s): p for s, p in plain.items()}
    return sp.lambdify(
        list(plain.values()), [as_expression(e).xreplace(names) for e in exprs], modules, cse=cse
    )


RIGHT_SIDES: dict[str, Callable[[ProblemLevel], RightSide]] = {
    "solved": _solve_by_numpy,
    "written out": partial(_write_derivatives, plain=False),
    "plain": partial(_write_derivatives, plain=True),
}


def _peer(method: str, at: str, kind: str = "") -> Contender:
    short = f"{method.lower()}-lambdify-{at}" + (f"-{kind}" if kind else "")
    about = f"scipy {method} with {kind or 'a good'} lambdify of the equations on the {at}"
    how = kind or ("solved" if at == "coordinates" else "written out")
    prepare = partial(_prepare, method=method, name=at, kind=how)
    return Contender(short, about, TOLERANCES, prepare)


BY_LAMBDIFY = (
    _peer("DOP853", "invariants"),
    _peer("DOP853", "invariants", "plain"),
    _peer("DOP853", "coordinates"),
    _peer("LSODA", "invariants"),
    _peer("LSODA", "coordinates"),
)
