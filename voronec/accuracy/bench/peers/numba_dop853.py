"""DOP853 compiled by numba: with a right-hand side of SymPy's, and with our straight-line program.

The first is what a user of SymPy and numba has, the second shows what the integrator alone does.
The coefficients are those that scipy publishes, and the step control is scipy's; the stages are
written out without their zeros.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from textwrap import dedent, indent
from typing import Any

import numpy as np
import sympy as sp

from voronec.accuracy.bench.contender import Contender, NotHere, Outcome, Run, time_fastest, without
from voronec.accuracy.problem import ProblemLevel, ReferenceProblem, lowest
from voronec.algebra.text import as_expression
from voronec.equations.program import Program, scalar_source

__all__ = ["BY_NUMBA", "right_hand_side", "stepper_source", "unroll"]

STAGES = 12
"""Of DOP853 [HairerNorsettWanner1993]."""
LONGEST = 20_000
"""Characters of a right-hand side beyond which no hand writes it out."""
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 1e-14)
"""To where rounding ends all gain."""


def _prepare(question: ReferenceProblem, ours: bool) -> Run:
    try:
        import numba
    except ImportError:
        raise without("numba") from None
    at = lowest(question)
    function = right_hand_side(at.program) if ours else sympy_right_hand_side(at)
    right = numba.njit(function, error_model="numpy")
    namespace: dict[str, Any] = {"np": np, "right": right}
    exec(compile(stepper_source(len(at.start)), "<voronec dop853>", "exec"), namespace)
    advance = numba.njit(namespace["advance"], error_model="numpy")
    start, constants = at.state, np.array(at.constants)
    advance(question.grid[:2], start, constants, 1e-3, np.empty((2, len(start))))

    def run(tol: float) -> Outcome:
        rows = np.empty((len(question.grid), len(start)))
        (steps, evaluations), seconds = time_fastest(
            lambda: advance(question.grid, start, constants, tol, rows)
        )
        if not np.isfinite(rows).all():
            raise NotHere("the step size collapsed")
        values, drift = at.outputs_and_drift(question.grid, rows)
        return Outcome(values, seconds, evaluations, steps, drift)

    return run


def right_hand_side(program: Program) -> Callable[..., None]:
    """``rhs(t, state, parameters, result)``: our source for compilers, results written in place.

    numba compiles neither the unpacking of an array nor a fresh list without loss.
    """
    places = range(len(program.state))
    states, results = ("".join(f"{x}[{i}], " for i in places) for x in ("state", "result"))
    source = re.sub(
        r"def rhs\(t, (.*), parameters\):",
        rf"def rhs(t, state, parameters, result):\n    \1, = {states}",
        scalar_source(program),
    )
    namespace: dict[str, Any] = {}
    exec(source.replace("    return (", f"    {results}= ("), namespace)
    found: Callable[..., None] = namespace["rhs"]
    return found


def sympy_right_hand_side(at: ProblemLevel) -> Callable[..., None]:
    """The same function as a good hand makes it: SymPy's ``cse`` of rates, mass matrix and force,
    printed as Python, and an elimination in loops for the accelerations."""
    import math

    field, n = at.field, len(at.field.velocities)
    mass = [e for row in field.mass for e in row]
    exprs = [*field.rates, *mass, *field.force]
    if sum(len(str(e)) for e in exprs) > LONGEST:
        raise NotHere("the equations are too long for SymPy")
    symbols = [field.time, *field.variables, *field.parameters]
    names = {as_expression(s): sp.Symbol(f"z{i}") for i, s in enumerate(symbols)}
    shared, found = sp.cse([as_expression(e).xreplace(names) for e in exprs])
    text = [sp.pycode(e, fully_qualified_modules=False) for e in found]
    places = ["t", *(f"state[{i}]" for i in range(len(field.variables)))]
    places += [f"parameters[{i}]" for i in range(len(field.parameters))]
    rows = [f"z{i} = {place}" for i, place in enumerate(places)]
    rows += [f"{x} = {sp.pycode(e, fully_qualified_modules=False)}" for x, e in shared]
    k = len(field.rates)
    rows += [f"result[{i}] = {e}" for i, e in enumerate(text[:k] + text[k + n * n :])]
    rows += [f"m_{i}_{j} = {text[k + n * i + j]}" for i in range(n) for j in range(n)]
    source = "\n    ".join(
        ["def rhs(t, state, parameters, result):", *rows, *_elimination_lines(k, n)]
    )
    namespace: dict[str, Any] = dict(vars(math))
    exec(compile(source, "<sympy rhs>", "exec"), namespace)
    function: Callable[..., None] = namespace["rhs"]
    return function


def _elimination_lines(k: int, n: int) -> list[str]:
    """Lines that solve m x = result[k:] by elimination, x in place of the right side."""
    rows = []
    for p in range(n):
        for i in range(p + 1, n):
            rows.append(f"q = m_{i}_{p}/m_{p}_{p}")
            rows += [f"m_{i}_{j} -= q*m_{p}_{j}" for j in range(p + 1, n)]
            rows.append(f"result[{k + i}] -= q*result[{k + p}]")
    for p in reversed(range(n)):
        rows += [f"result[{k + p}] -= m_{p}_{j}*result[{k + j}]" for j in range(p + 1, n)]
        rows.append(f"result[{k + p}] /= m_{p}_{p}")
    return rows


def stepper_source(n: int) -> str:
    """Source of ``advance(grid, start, parameters, tol, rows)`` for a state of n numbers.

    It fills ``rows`` (k, n) and returns the counts of steps and evaluations; steps end on the
    instants of the grid.  Rows are NaN from where a step became too short.
    """
    from scipy.integrate import DOP853

    stages = []
    for s in range(1, STAGES):
        stages.append(_combination("trial", f"h*({_weighted_sum(DOP853.A[s, :s])})", n))
        stages.append(f"right(t + {DOP853.C[s]!r}*h, trial, parameters, k{s})")
    stages.append(_combination("ahead", f"h*({_weighted_sum(DOP853.B)})", n))
    stages.append("right(t + h, ahead, parameters, k12)")
    return _TEMPLATE.format(
        n=n,
        slopes="\n    ".join(f"k{s} = np.empty({n})" for s in range(STAGES + 1)),
        stages="\n            ".join("\n".join(stages).split("\n")),
        fifth=_weighted_sum(DOP853.E5),
        third=_weighted_sum(DOP853.E3),
    )


def unroll(source: str, n: int) -> str:
    """The same source on scalars: loops over components written out, and ``right`` a function
    ``right(t, y_0, ..., parameters)`` that returns the rates."""

    def each(name: str) -> str:
        return ", ".join(f"{name}_{i}" for i in range(n))

    source = re.sub(r"^ *[\w, ]+ = np\.empty\(.*\n", "", source, flags=re.MULTILINE)
    source = re.sub(
        r"right\((.+), (\w+), parameters, (\w+)\)",
        lambda m: f"{each(m[3])} = right({m[1]}, {each(m[2])}, parameters)",
        source,
    )

    def unroll_loop(loop: re.Match[str]) -> str:
        rows = []
        for i in range(n):
            row = loop[2].replace("start[i]", f"start[{i}]").replace(", i]", f", {i}]")
            rows.append(re.sub(r"(\w+)\[i\]", rf"\1_{i}", row))
        return indent(dedent("".join(rows)), loop[1])

    loops = r"^( *)for i in range\(\d+\):\n((?:\1 +.*\n)+)"
    return re.sub(loops, unroll_loop, source, flags=re.MULTILINE)


def _weighted_sum(row: Any) -> str:
    terms = [f"{float(c)!r}*k{j}[i]" for j, c in enumerate(row) if c != 0]
    return " + ".join(terms)


def _combination(target: str, term: str, n: int) -> str:
    return f"for i in range({n}):\n    {target}[i] = y[i] + {term}"


_TEMPLATE = """
def advance(grid, start, parameters, tol, rows):
    {slopes}
    trial, ahead, y = np.empty({n}), np.empty({n}), np.empty({n})
    rows[:] = np.nan
    for i in range({n}):
        y[i] = start[i]
        rows[0, i] = start[i]
    t, steps, evaluations = grid[0], 0, 2
    order = 1.0 if grid[-1] > grid[0] else -1.0
    right(t, y, parameters, k0)
    below, slope = 0.0, 0.0
    for i in range({n}):
        scale = tol + tol*abs(y[i])
        below += (y[i]/scale)**2
        slope += (k0[i]/scale)**2
    size = 1e-6 if below < 1e-10 or slope < 1e-10 else 0.01*np.sqrt(below/slope)
    for i in range({n}):
        trial[i] = y[i] + order*size*k0[i]
    right(t + order*size, trial, parameters, k1)
    bend = 0.0
    for i in range({n}):
        bend += ((k1[i] - k0[i])/(tol + tol*abs(y[i])))**2
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
            for i in range({n}):
                scale = tol + tol*max(abs(y[i]), abs(ahead[i]))
                five += (({fifth})/scale)**2
                three += (({third})/scale)**2
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
                for i in range({n}):
                    y[i] = ahead[i]
                    k0[i] = k12[i]
            elif error >= 1.0:
                size = abs(h)*max(0.2, 0.9*error**-0.125)
                rejected = True
            else:
                size = abs(h)*0.2
                rejected = True
        for i in range({n}):
            rows[place, i] = y[i]
    return steps, evaluations
"""

BY_NUMBA = (
    Contender(
        "dop853-numba", "DOP853 compiled by numba, right-hand side by SymPy", TOLERANCES,
        partial(_prepare, ours=False),
    ),
    Contender(
        "dop853-numba-ours", "DOP853 compiled by numba, right-hand side by our program",
        TOLERANCES, partial(_prepare, ours=True),
    ),
)  # fmt: skip
