"""DOP853 compiled by numba: an integrator as a good hand writes it out for its own equations.

The coefficients are those that scipy publishes [HairerNorsettWanner1993], and the step control is
scipy's.  Stages are written without their zeros, on scalars, one line for each component.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np

STAGES = 12

TEMPLATE = """
def advance(grid, start, parameters, tol, rows):
    rows[:] = np.nan
    y_@ = start[@]
    rows[0, @] = y_@
    t, steps, evaluations = grid[0], 0, 2
    order = 1.0 if grid[-1] > grid[0] else -1.0
    (<k0>,) = right(t, <y>, parameters)
    below, slope, bend = 0.0, 0.0, 0.0
    below += (y_@/(tol + tol*abs(y_@)))**2
    slope += (k0_@/(tol + tol*abs(y_@)))**2
    size = 1e-6 if below < 1e-10 or slope < 1e-10 else 0.01*np.sqrt(below/slope)
    trial_@ = y_@ + order*size*k0_@
    (<k1>,) = right(t + order*size, <trial>, parameters)
    bend += ((k1_@ - k0_@)/(tol + tol*abs(y_@)))**2
    bend = np.sqrt(bend/{n})/size
    steep = max(np.sqrt(slope/{n}), bend)
    size = min(100*size, (0.01/steep)**0.125 if steep > 1e-15 else max(1e-6, size*1e-3))
    rejected = False
    for place in range(1, len(grid)):
        while t != grid[place]:
            left = abs(grid[place] - t)
            ends = size >= left
            h = order*(left if ends else size)
            if abs(h) < 1e-15*max(1.0, abs(t)) and not ends:
                return steps, evaluations
            {stages}
            steps += 1
            evaluations += 12
            five, three = 0.0, 0.0
            five += (({fifth})/(tol + tol*max(abs(y_@), abs(ahead_@))))**2
            three += (({third})/(tol + tol*max(abs(y_@), abs(ahead_@))))**2
            wrong = five + 0.01*three
            error = abs(h)*five/np.sqrt(wrong*{n}) if wrong > 0 else 0.0
            if error < 1.0:
                factor = 10.0 if error == 0.0 else min(10.0, 0.9*error**-0.125)
                if rejected:
                    factor = min(1.0, factor)
                rejected = False
                # a step cut short by the grid must not shorten the next
                size = max(size, abs(h)*factor) if ends else abs(h)*factor
                t = grid[place] if ends else t + h
                y_@ = ahead_@
                k0_@ = k12_@
            elif error >= 1.0:
                size = abs(h)*max(0.2, 0.9*error**-0.125)
                rejected = True
            else:
                size = abs(h)*0.2
                rejected = True
        rows[place, @] = y_@
    return steps, evaluations
"""
"""A line with @ stands once for each component; <y> are all components of y."""


def advance_source(n: int) -> str:
    """Source of ``advance(grid, start, parameters, tol, rows)`` for a state of n numbers.

    It calls ``right(t, y_0, y_1, ..., parameters)``, which returns a tuple, fills ``rows`` (k, n),
    and returns the counts of steps and evaluations; steps end on the instants of the grid.  Rows
    are NaN from where a step became too short.
    """
    from scipy.integrate import DOP853

    stages = []
    for s in range(1, STAGES):
        stages.append(f"trial_@ = y_@ + h*({_weighted_sum(DOP853.A[s, :s])})")
        stages.append(f"(<k{s}>,) = right(t + {float(DOP853.C[s])!r}*h, <trial>, parameters)")
    stages.append(f"ahead_@ = y_@ + h*({_weighted_sum(DOP853.B)})")
    stages.append("(<k12>,) = right(t + h, <ahead>, parameters)")
    source = TEMPLATE.format(
        n=n,
        stages="\n            ".join(stages),
        fifth=_weighted_sum(DOP853.E5),
        third=_weighted_sum(DOP853.E3),
    )

    def components(name: re.Match[str]) -> str:
        return ", ".join(f"{name[1]}_{i}" for i in range(n))

    lines = re.sub(r"<(\w+)>", components, source).splitlines()
    each = ([x.replace("@", str(i)) for i in range(n)] if "@" in x else [x] for x in lines)
    return "\n".join(line for some in each for line in some)


def _weighted_sum(row: Any) -> str:
    return " + ".join(f"{float(c)!r}*k{j}_@" for j, c in enumerate(row) if c != 0)


def compiled_dop853(
    right: Callable[..., Any], n: int, fast: bool
) -> Callable[..., tuple[int, int]]:
    """``advance`` for ``right``, both compiled; ``fast`` lets the compiler reorder sums."""
    import numba

    compiler = numba.njit(error_model="numpy", fastmath=fast)
    namespace: dict[str, Any] = {"np": np, "right": compiler(right)}
    exec(compile(advance_source(n), "<dop853>", "exec"), namespace)
    advance: Callable[..., tuple[int, int]] = compiler(namespace["advance"])
    return advance
