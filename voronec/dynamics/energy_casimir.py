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
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flint
import numpy as np
import symengine as se

from voronec.algebra.tape import as_ball
from voronec.dynamics.enclosure import BITS, krawczyk
from voronec.dynamics.joint_function import JointFunction
from voronec.dynamics.newton import polish
from voronec.dynamics.steady_equations import SteadyEquations
from voronec.equations.motions import Motions
from voronec.equations.program import Block
from voronec.equations.program.straight import fresh_names, share_subexpressions
from voronec.errors import EngineLimit

RANK = 1e-8
"""Gradients depend on one another, and forms are degenerate, to this part of their size."""
WEIGHTS = (1, 100, 10**4, 10**6)
"""Values of N, for constants of size one, that are tried one after another."""
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
    try:
        problem = _Extremum(equations, constants, y[: equations.size], units[: equations.size])
        return problem.prove()
    except EngineLimit:
        return None


@dataclass(frozen=True, eq=False)
class _Extremum:
    """Constants of the motion {name: (expression, value or None)}, relations and what has a value
    first, at a point y (n,)."""

    equations: SteadyEquations
    constants: Mapping[str, tuple[Any, Any]]
    y: np.ndarray
    units: np.ndarray

    @cached_property
    def lagrange(self) -> JointFunction:
        """sum_k mu_k dI_k (n,), then I (c,), with slopes by y and mu."""
        found: JointFunction = self.equations.memo.once(
            ("energy-Casimir", *self.constants), self._write
        )
        return found

    @cached_property
    def multipliers(self) -> tuple[Any, ...]:
        return tuple(se.Symbol(f"multiplier {k}") for k in range(len(self.constants)))

    def _write(self) -> JointFunction:
        equations = self.equations
        state = equations.rates.state
        exprs = [e for e, _ in self.constants.values()]
        fresh = fresh_names(equations.symbols, "h")
        rows = share_subexpressions(exprs, fresh, equations.formulation.stages)
        first = JointFunction.of(equations.rates.time, equations.symbols[1:], rows, state)
        values, slopes = first.joint.results[: len(exprs)], first.joint.results[len(exprs) :]
        gradient = [se.Integer(0)] * len(state)
        for (k, i), slope in zip(first.places, slopes, strict=True):
            gradient[i] += self.multipliers[k] * slope
        block = Block(first.joint.assignments, (*gradient, *values))
        symbols = (*equations.symbols[1:], *self.multipliers)
        return JointFunction.of(equations.rates.time, symbols, block, (*state, *self.multipliers))

    @cached_property
    def values(self) -> Mapping[str, Any]:
        """Those of all parameters, among them what was found."""
        equations = self.equations
        return {**equations.values, **dict(zip(equations.names, self.y, strict=False))}

    def prove(self) -> str | None:
        """The combination as text, where the proof succeeds."""
        n, scales = len(self.y), self._sizes
        gradients, forms = self._gradients / scales[:, None], self._forms / scales[:, None, None]
        left, sizes, right = np.linalg.svd(gradients)
        rank = int((sizes > RANK).sum())
        across, free = right[rank:].T, left[:, rank:].T
        weights = _definite_sum([across.T @ np.tensordot(m, forms, 1) @ across for m in free])
        if weights is None:
            return None
        multipliers = weights @ free / scales
        held = list[int]()
        for k in range(len(gradients)):
            if len(held) < np.linalg.matrix_rank(gradients[[*held, k]], tol=RANK):
                held.append(k)
        conditions = _Conditions(self.lagrange, self.values, (*range(n), *(n + k for k in held)),
                                 self._targets(held))  # fmt: skip
        start = np.concatenate([self.y, multipliers])
        with flint.ctx.workprec(BITS):
            columns = [*range(n), *(n + k for k in held)]
            middle = polish(conditions, start, BITS)
            box = krawczyk(conditions, middle, [*range(len(columns))], columns)
            if box is None or not self._is_convex(conditions.slopes_in_balls(box, BITS), held):
                return None
        terms = zip(multipliers * scales, multipliers, self.constants, strict=True)
        return " + ".join(f"{m:.6g} ({name})" for size, m, name in terms if abs(size) > RANK)

    def _targets(self, held: Sequence[int]) -> list[Any]:
        """The values of independent constants, those without one as at the point."""
        given, here = [x for _, x in self.constants.values()], self._at_zero[0][len(self.y) :]
        return [given[k] if given[k] is not None else float(here[k]) for k in held]

    @cached_property
    def _at_zero(self) -> tuple[np.ndarray, np.ndarray]:
        return self._at(np.zeros(len(self.constants)))

    def _at(self, multipliers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y = np.concatenate([self.y, multipliers])
        return self.lagrange.at(y, self.lagrange.doubles(self.values))

    @cached_property
    def _gradients(self) -> np.ndarray:
        """dI (c, n) in the units."""
        n = len(self.y)
        return self._at_zero[1][n:, :n] * self.units

    @cached_property
    def _forms(self) -> np.ndarray:
        """D^2 I (c, n, n) in the units."""
        n = len(self.y)
        found = [self._at(row)[1][:n, :n] for row in np.eye(len(self.constants))]
        return np.array(found) * np.outer(self.units, self.units)

    @cached_property
    def _sizes(self) -> np.ndarray:
        """How large the constants are (c,), by both."""
        sizes = np.maximum(np.linalg.norm(self._gradients, axis=1),
                           np.linalg.norm(self._forms, axis=(1, 2)))  # fmt: skip
        return np.where(sizes > 0, sizes, 1.0)

    def _is_convex(self, slopes: Any, held: Sequence[int]) -> bool:
        """Whether V is convex in the balls, for some N."""
        n, count = len(self.y), len(held)
        units = flint.arb_mat(n, n, [float(u) if i == j else 0 for i, u in enumerate(self.units)
                                     for j in range(n)])  # fmt: skip
        rows = flint.arb_mat(count, n, [slopes[n + i, j] / float(self._sizes[k])
                                        for i, k in enumerate(held) for j in range(n)])  # fmt: skip
        form = units * flint.arb_mat(n, n, [slopes[i, j] for i in range(n) for j in range(n)])
        form, rows = form * units, rows * units
        for weight in WEIGHTS:
            whole = form + rows.transpose() * rows * weight
            minors = (flint.arb_mat(k, k, [whole[i, j] for i in range(k) for j in range(k)]).det()
                      for k in range(1, n + 1))  # fmt: skip
            if all(minor > 0 for minor in minors):
                return True
        return False


@dataclass(frozen=True, eq=False)
class _Conditions:
    """Some results of a function, the last of them without their targets."""

    function: JointFunction
    values: Mapping[str, Any]
    rows: tuple[int, ...]
    targets: Sequence[Any]

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values and slopes in doubles."""
        found, slopes = self.function.at(y, self.function.doubles(self.values))
        found = found[[*self.rows]]
        found[len(found) - len(self.targets) :] -= np.array([*map(float, self.targets)])
        return found, slopes[[*self.rows]]

    def balls(self, y: Sequence[Any], bits: int) -> list[Any]:
        """Values in balls."""
        found = self.function.balls(y, self.values, bits)
        found = [found[i] for i in self.rows]
        with flint.ctx.workprec(bits):
            for i, target in enumerate(self.targets, len(found) - len(self.targets)):
                found[i] -= as_ball(target)
        return found

    def slopes_in_balls(self, y: Sequence[Any], bits: int) -> Any:
        """Slopes in balls."""
        found = self.function.slopes_in_balls(y, self.values, bits)
        n = found.ncols()
        return flint.arb_mat(len(self.rows), n, [found[i, j] for i in self.rows for j in range(n)])


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
    best, found = RANK, None
    for _ in range(PLANES):
        rows = [[*(-(v @ form @ v) for form in forms), 1.0] for v in cuts]
        bounds = [(-1.0, 1.0)] * count + [(None, None)]
        plan = linprog([0.0] * count + [-1.0], rows, np.zeros(len(rows)), bounds=bounds)
        least, vectors = np.linalg.eigh(np.tensordot(plan.x[:-1], forms, 1))
        if least[0] > best:
            best, found = least[0], plan.x[:-1]
        if plan.x[-1] <= RANK or least[0] > plan.x[-1] / 2:
            break
        cuts.append(vectors[:, 0])
    return found
