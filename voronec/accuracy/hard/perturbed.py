"""A reference without the variational equations: many digits, and slightly different data.

Where heyoka is not installed this is how a case that has no stored reference gets one; elsewhere
it is the independent check of the condition numbers.  Only errors of the data are seen, not those
made on the way, so the condition numbers come out lower, and the judgement stricter.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from voronec.accuracy.hard.case import HardCase
from voronec.accuracy.hard.closed import PreciseProblem, problem
from voronec.accuracy.hard.conditioning import output_sizes, sizes
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import EngineLimit
from voronec.motion import Trajectory, integrate

__all__ = ["perturbed", "slopes"]

CHANGE = 1e-12
"""By what part of its size a datum is changed, either way: 25 digits leave 13 of the slope."""
DIGITS = (1e-25, 1e-21)
"""Tolerances of the run, and of the one that it is compared with."""


def perturbed(
    case: HardCase, equations: VoronecEquations
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], float]:
    """Outputs, condition numbers, and how far two runs agree; raises ``EngineLimit`` for a case
    whose reference lies on the invariants, or counts periods."""
    if case.level != "coordinates" or case.period:
        raise EngineLimit(
            f"hard case '{case.name}' has no stored reference, and computing one takes heyoka, "
            "which is not installed; 'pip install heyoka'"
        )
    first, second = (_run(case, equations, tol=tol) for tol in DIGITS)
    values = {n: np.asarray(first[n], dtype=float) for n in first.outputs}
    size = {n: float(output_sizes(x[:, None])[0]) for n, x in values.items()}
    apart = max(_apart(first[n], second[n], size[n]) for n in values)
    asked = problem(case, equations)
    condition = {n: np.ones_like(x) for n, x in values.items()}
    for by, weight in _weights(asked, case, equations).items():
        for n, slope in slopes(case, equations, by).items():
            condition[n] += np.abs(slope) * weight / size[n]
    return values, condition, apart


def slopes(case: HardCase, equations: VoronecEquations, by: str) -> dict[str, np.ndarray]:
    """d output / d datum at every instant; ``by`` names a coordinate, a velocity or a parameter."""
    asked = problem(case, equations)
    data = _data(asked)
    step = CHANGE * max(1.0, abs(float(data[by])))
    constants = {str(p) for p in asked.program.parameters}
    ahead, behind = (
        _run(case, equations, parameters={by: x})
        if by in constants
        else _run(case, equations, initial={by: x})
        for x in (data[by] + step, data[by] - step)
    )
    return {n: np.asarray((ahead[n] - behind[n]) / (2 * step), dtype=float) for n in ahead.outputs}


def _data(asked: PreciseProblem) -> dict[str, Any]:
    """States at the start and parameters by name, as exact as SymPy holds them."""
    import sympy as sp

    names = [*map(str, asked.program.state), *map(str, asked.program.parameters)]
    numbers = [*asked.start, *asked.values]
    return {n: sp.Float(x, 40) for n, x in zip(names, numbers, strict=True)}


def _weights(
    asked: PreciseProblem, case: HardCase, equations: VoronecEquations
) -> dict[str, float]:
    """The sizes of what may be in error: states that the outputs need, and parameters."""
    followed = integrate(equations, scene=case.scene, times=case.grid, outputs=asked.names)
    states = np.column_stack([followed[name] for name in asked.names])
    weights = dict(zip(asked.names, sizes(asked, states).tolist(), strict=True))
    data = _data(asked)
    return weights | {str(p): abs(float(data[str(p)])) for p in asked.program.parameters}


def _run(
    case: HardCase,
    equations: VoronecEquations,
    tol: float = DIGITS[0],
    initial: Mapping[str, Any] | None = None,
    parameters: Mapping[str, Any] | None = None,
) -> Trajectory:
    return integrate(
        equations, scene=case.scene, times=case.grid, method="flint", tol=tol, initial=initial,
        parameters=parameters,
    )  # fmt: skip


def _apart(first: np.ndarray, second: np.ndarray, size: float) -> float:
    return float(max(abs(a - b) for a, b in zip(first, second, strict=True))) / size
