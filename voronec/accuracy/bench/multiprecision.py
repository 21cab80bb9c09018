"""heyoka's Taylor method in more digits than a double has."""

from __future__ import annotations

from typing import Any

import numpy as np
import symengine as se

from voronec.accuracy.bench.level import BenchLevel
from voronec.equations.program import mpmath_source, taylor_system
from voronec.errors import IntegrationError

__all__ = ["precise_outputs", "precise_states", "why_not"]

QUADRUPLE = 33
"""Up to so many digits quadruple precision does; it is faster than arbitrary precision."""
GUARD = 5
"""Digits kept beyond those asked for."""


def why_not(level: BenchLevel) -> str | None:
    """Why heyoka cannot run this exactly, or None where it can.

    Its expressions hold constants as doubles, so a fraction such as 1/3 would be rounded.
    """
    try:
        import heyoka  # noqa: F401
    except ImportError:
        return "heyoka is not installed"
    for expr in level.program.derivative.expressions:
        for number in _numbers(expr):
            p, q = int(number.p), int(number.q)
            if q & (q - 1) or abs(p) > 2**53:
                return f"the equations hold the constant {number}, which is no double"
    return None


def _numbers(expr: Any) -> set[Any]:
    if isinstance(expr, se.Rational):
        return {expr}
    return set().union(*(_numbers(a) for a in expr.args)) if expr.args else set()


def precise_outputs(level: BenchLevel, grid: np.ndarray, digits: int) -> dict[str, np.ndarray]:
    """The outputs on the grid, arrays of mpmath numbers, evaluated in as many digits."""
    import mpmath

    states = precise_states(level, grid, digits)
    namespace: dict[str, Any] = {}
    exec(compile(mpmath_source(level.program), "<voronec reference>", "exec"), namespace)
    with mpmath.workdps(digits + GUARD):
        constants = [mpmath.mpf(x) for x in level.constants]
        rows = [
            namespace["extras"](mpmath.mpf(float(t)), [mpmath.mpf(x) for x in state], constants)
            for t, state in zip(grid, states, strict=True)
        ]
        place = {name: i for i, name in enumerate(level.program.names)}
        # inside, where a number is not rounded to a double on the way
        return {n: np.array([mpmath.mpf(r[place[n]]) for r in rows]) for n in level.outputs}


def precise_states(level: BenchLevel, grid: np.ndarray, digits: int) -> list[list[str]]:
    """States on the grid as decimal texts, one list for each instant."""
    import heyoka as hy
    import mpmath

    bits = int((digits + GUARD) * 3.33) + 8
    quadruple = digits <= QUADRUPLE and hasattr(hy, "real128")
    with mpmath.workdps(digits + 2 * GUARD):
        texts = [mpmath.nstr(x, digits + 2 * GUARD) for x in level.start]

    def own(text: Any) -> Any:
        """A number of heyoka's, from a text or a double."""
        if quadruple:
            return hy.real128(text)
        return hy.real(text, bits)

    used = [i for i, p in enumerate(level.program.parameters)
            if p in level.program.derivative.symbols]  # fmt: skip
    integrator = hy.taylor_adaptive(
        taylor_system(level.program),
        np.array([own(t) for t in texts]),
        pars=np.array([own(x) for x in level.constants[: max(used, default=-1) + 1]]),
        time=own(float(grid[0])),
        fp_type=hy.real128 if quadruple else hy.real,
        tol=own(f"1e-{digits}"),
        compact_mode=True,
        **({} if quadruple else {"prec": bits}),
    )
    outcome, *_, rows = integrator.propagate_grid(np.array([own(float(t)) for t in grid]))
    if len(rows) < len(grid):
        raise IntegrationError(
            f"system '{level.field.system.name}': the run of {digits} digits for the reference "
            f"stopped at t = {float(integrator.time):g} ({outcome}); end the motion before that"
        )
    return [[str(x) for x in row] for row in rows]
