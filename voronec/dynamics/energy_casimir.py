"""Proof of stability by integrals that are definite together: the method of energy and Casimir
functions.

Constants of the motion I_k, among them relations, give at y*, with multipliers mu,

    sum_k mu_k dI_k(y*) = 0,   sum_k mu_k D^2 I_k(y*) > 0  on the kernel of all dI_k(y*)

Then V = sum_k mu_k I_k + N sum_k (I_k - I_k(y*))^2 with N large has a strict minimum there and is
constant in time, so that y* is a stable equilibrium by Lyapunov's theorem [HolmEtAl1985], whether
or not the dI_k are independent.  The first condition and the values of independent I_k are solved
for y and mu by Krawczyk's method; that V is convex in the balls is proved by its minors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import flint
import numpy as np
import symengine as se

from voronec.dynamics.enclosure import BITS, krawczyk
from voronec.dynamics.joint_function import JointFunction
from voronec.dynamics.steady_equations import SteadyEquations
from voronec.equations.motions import Motions
from voronec.equations.program import Block
from voronec.equations.program.straight import fresh_names, share_subexpressions
from voronec.errors import EngineLimit

RANK = 1e-8
"""Gradients depend on one another, and forms are degenerate, to this part of their size."""
WEIGHTS = (1, 100, 10**4, 10**6)
"""Values of N, for constants of size one, that are tried one after another."""
TARGET = "target"
"""What names of values begin with that constants should have."""
PLANES = 60
"""So many half-spaces are cut off before multipliers are given up."""


def proved_stable(
    motions: Motions, equations: SteadyEquations, y: np.ndarray, units: np.ndarray
) -> str | None:
    """The combination of integrals that proves a steady motion stable, as text; None where none is
    found, or the proof does not succeed."""
    constants = equations.constants_of_motion(motions.equations)
    if not constants:
        return None
    n = equations.size
    values = {**equations.values, **dict(zip(equations.names, y, strict=True))}
    with suppress(EngineLimit):
        function = equations.memo.once(
            ("energy-Casimir", *constants), lambda: _lagrange(equations, constants)
        )
        targets = [0 if x is None else x for _, x in constants.values()]
        problem = _Extremum(function, constants, values, y[:n], units[:n])
        here = problem.at_targets(targets).at(np.append(y[:n], np.zeros(len(targets))))[0][n:]
        if not np.isfinite(here).all():
            return None
        pairs = zip(constants.values(), here, strict=True)
        return problem.prove([float(h) if x is None else x for (_, x), h in pairs])
    return None


def _lagrange(equations: SteadyEquations, constants: Mapping[str, Any]) -> JointFunction:
    """sum_k mu_k dI_k (n,), then I - targets (c,), with slopes by y and mu."""
    time, state, symbols = equations.rates.time, equations.rates.state, equations.symbols
    exprs = [e for e, _ in constants.values()]
    multipliers, targets = (
        [se.Symbol(f"{word} {k}") for k in range(len(exprs))] for word in ("multiplier", TARGET)
    )
    rows = share_subexpressions(exprs, fresh_names(symbols, "h"), equations.formulation.stages)
    first = JointFunction.of(time, symbols[1:], rows, state)
    values, slopes = first.joint.results[: len(exprs)], first.joint.results[len(exprs) :]
    gradient = [se.Integer(0)] * len(state)
    for (k, i), slope in zip(first.places, slopes, strict=True):
        gradient[i] += multipliers[k] * slope
    off = [e - target for e, target in zip(values, targets, strict=True)]
    block = Block(first.joint.assignments, (*gradient, *off))
    everything = (*symbols[1:], *multipliers, *targets)
    return JointFunction.of(time, everything, block, (*state, *multipliers))


@dataclass(frozen=True, eq=False)
class _Extremum:
    """Constants of the motion by name, relations and leaf functions first, at a point y (n,), in
    the ``units`` (n,)."""

    function: JointFunction
    constants: Mapping[str, tuple[Any, Any]]
    values: Mapping[str, Any]
    y: np.ndarray
    units: np.ndarray

    def at_targets(self, targets: Sequence[Any]) -> JointFunction:
        """The function with the values that constants should have."""
        named = {f"{TARGET} {k}": x for k, x in enumerate(targets)}
        return self.function.with_values({**self.values, **named})

    def prove(self, targets: Sequence[Any]) -> str | None:
        """The combination as text, where the proof succeeds."""
        n, count, function = len(self.y), len(targets), self.at_targets(targets)
        slopes = [function.at(np.append(self.y, mu))[1] for mu in np.eye(count)]
        gradients = slopes[0][n:, :n] * self.units
        forms = np.array([s[:n, :n] for s in slopes]) * np.outer(self.units, self.units)
        sizes = np.maximum(*(np.linalg.norm(x.reshape(count, -1), axis=1)
                             for x in (gradients, forms)))  # fmt: skip
        sizes = np.where(sizes > 0, sizes, np.inf)  # such as depend on parameters alone
        gradients, forms = gradients / sizes[:, None], forms / sizes[:, None, None]
        left, values, right = np.linalg.svd(gradients)
        rank = int((values > RANK).sum())
        across, free = right[rank:].T, left[:, rank:].T
        weights = _definite_sum([across.T @ np.tensordot(m, forms, 1) @ across for m in free])
        if weights is None:
            return None
        multipliers = weights @ free
        held = list[int]()
        for k in range(count):
            if len(held) < np.linalg.matrix_rank(gradients[[*held, k]], tol=RANK):
                held.append(k)
        with flint.ctx.workprec(BITS):
            start = [*map(flint.arb, np.append(self.y, multipliers / sizes).tolist())]
            places = [*range(n), *(n + k for k in held)]
            box = krawczyk(function, start, places, places)
            if box is None:
                return None
            hessian = function.slopes_in_balls(box, BITS)
            if not self._is_convex(hessian, [(n + k, float(sizes[k])) for k in held]):
                return None
        terms = zip(multipliers, multipliers / sizes, self.constants, strict=True)
        shown = (f"{m:.6g} ({name})" for size, m, name in terms if abs(size) > RANK and m != 0)
        return " + ".join(shown).replace("+ -", "- ")

    def _is_convex(self, slopes: Any, held: Sequence[tuple[int, float]]) -> bool:
        """Whether V is convex in the balls, for some N, in the units."""
        n, units = len(self.y), [*map(float, self.units)]
        rows = [[slopes[i, j] * units[j] / size for j in range(n)] for i, size in held]
        for weight in WEIGHTS:
            whole = [[slopes[i, j] * units[i] * units[j] + weight * sum(r[i] * r[j] for r in rows)
                      for j in range(n)] for i in range(n)]  # fmt: skip
            minors = (flint.arb_mat([row[:k] for row in whole[:k]]).det() for k in range(1, n + 1))
            if all(minor > 0 for minor in minors):
                return True
        return False


def _definite_sum(forms: Sequence[np.ndarray]) -> np.ndarray | None:
    """Weights with which the sum of quadratic forms is positive definite; None where none are
    found.  The least eigenvalue is maximised for weights up to one, by cutting planes."""
    from scipy.optimize import linprog

    count = len(forms)
    if not count:
        return None
    if not forms[0].size:
        return np.zeros(count)
    cuts = [v for form in forms for v in np.linalg.eigh(form)[1].T]
    best, weights = RANK, None
    for _ in range(PLANES):
        rows = [[*(-(v @ form @ v) for form in forms), 1.0] for v in cuts]
        bounds = [(-1.0, 1.0)] * count + [(None, None)]
        plan = linprog([0.0] * count + [-1.0], rows, np.zeros(len(rows)), bounds=bounds)
        least, vectors = np.linalg.eigh(np.tensordot(plan.x[:-1], forms, 1))
        if least[0] > best:
            best, weights = least[0], plan.x[:-1]
        if plan.x[-1] <= RANK or least[0] > plan.x[-1] / 2:
            break
        cuts.append(vectors[:, 0])
    return weights
