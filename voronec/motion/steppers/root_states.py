"""Steps through places where a root vanishes, in many digits: the root is a state of its own.

Where g = 0 the root g^(p/q) has no Taylor series in the time.  With r = g^(1/q) as a state, and a
variable s in which the time goes by as t' = q r^(q - 1), everything has one,

    x' = q r^(q - 1) f(x, r),    r' = dg/dt(x, r),

and r passes zero at the pace of g: in the time the motion is a series in powers of 1/q
[Puiseux1850].  Steps are taken in s, end where r vanishes, and are looked at in the time.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace
from math import ceil, lcm, log2
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.graphs import nodes
from voronec.equations.program import Block, Program
from voronec.equations.program.python import compiled_digits
from voronec.equations.program.recurrences import recurrences
from voronec.motion.crossings import Levels, roots
from voronec.motion.steppers.event_states import narrow
from voronec.motion.steppers.integer_taylor import GUARD, DigitsStepper, digit_levels, units_of
from voronec.motion.steppers.run import COLLAPSE, Integrator, Problem, Run
from voronec.motion.steppers.step_loop import IntegratorFailure, Stride, march
from voronec.motion.steppers.units import natural_units

FAR = 64
"""Bits of a way in s that no step goes."""
LOOKS = 8
"""Parts of a step at whose ends roots are looked at."""
CLOSE = 0.7
"""Where a root vanishes, so do the functions of switching surfaces below this power of the
tolerance."""


@dataclass(frozen=True, eq=False)
class RootStates:
    """A motion with the roots r of ``degrees`` q, behind its own states, and the time since its
    origin, the last parameter, behind these; ``bases`` computes their g."""

    program: Program
    bases: Program
    degrees: tuple[int, ...]

    @classmethod
    def of(cls, form: Any, radicands: Collection[Any]) -> RootStates | None:
        """Those of the roots of absolute values in a form, of ``radicands`` that are not negative;
        None where there are none."""
        found: dict[Any, list[Any]] = {}
        for node in nodes(map(se.sympify, form.expressions)):
            if isinstance(node, se.Pow) and isinstance(node.args[0], se.Abs):
                inner = node.args[0].args[0]
                both = {(side * inner).expand(): side * inner for side in (1, -1)}
                base = next((both[x] for g in radicands if (x := g.expand()) in both), None)
                if base is not None:
                    found.setdefault(base, []).append(node)
        if not found:
            return None
        degrees = tuple(lcm(*(int(p.args[1].q) for p in powers)) for powers in found.values())
        names = tuple(se.Symbol(f"root {i}") for i in range(len(found)))
        there = {
            power: r ** (power.args[1] * q)
            for powers, r, q in zip(found.values(), names, degrees, strict=True)
            for power in powers
        }
        known = replace(form, parameters=(*form.parameters, *names))
        bases = Program.of_extras(form, {f"base {i}": g for i, g in enumerate(found)})
        program = _regular(Program.of(_on(known, there)), list(found), names, degrees)
        return cls(program, bases, degrees)

    def start(self, time: Any, state: np.ndarray, parameters: Iterable[Any]) -> np.ndarray:
        """The roots at a state."""
        values = compiled_digits(self.bases)[1](time, list(state), list(parameters))
        pairs = zip(values, self.degrees, strict=True)
        return np.array([mpmath.root(abs(mpmath.mpf(g)), q) for g, q in pairs], dtype=object)


def _on(form: Any, there: dict[Any, Any]) -> Any:
    """A form with powers replaced."""

    def on(expr: Any) -> Any:
        return se.sympify(expr).xreplace(there)

    return replace(
        form, rates=tuple(map(on, form.rates)), force=tuple(map(on, form.force)),
        mass=tuple(tuple(map(on, row)) for row in form.mass),
    )  # fmt: skip


def _regular(
    program: Program, bases: list[Any], names: tuple[Any, ...], degrees: tuple[int, ...]
) -> Program:
    """The program in s, where roots are among its parameters."""
    clock, origin = se.Symbol("time since origin"), se.Symbol("origin of time")
    paces = [q * r ** (q - 1) for r, q in zip(names, degrees, strict=True)]
    pace = se.Mul(*paces)
    own = [f * pace for f in program.derivative.results]
    others = [se.Mul(*paces[:i], *paces[i + 1 :]) for i in range(len(paces))]
    moved = [program.rate(g) * other for g, other in zip(bases, others, strict=True)]
    now = {program.time: origin + clock}
    lines = tuple((name, e.xreplace(now)) for name, e in program.derivative.assignments)
    results = tuple(se.sympify(e).xreplace(now) for e in (*own, *moved, pace))
    return replace(
        program, time=se.Symbol("s along roots"), velocities=(*program.velocities, *names, clock),
        parameters=(*(p for p in program.parameters if p not in names), origin),
        derivative=Block(lines, results), names=(), extras=Block((), ()),
    )  # fmt: skip


def digits_through_roots(problem: Problem) -> Integrator:
    """Taylor's method in any precision for a problem with roots that may vanish."""
    roots, width = problem.roots, len(problem.start)
    assert roots is not None
    rules = recurrences(roots.program)
    bits = ceil(-log2(problem.tol)) + GUARD
    suspect = problem.suspect
    levels = _levels_at_roots(digit_levels(problem.levels, problem.parameters), problem, width)

    def run(grid: np.ndarray) -> Run:
        with mpmath.workprec(bits):
            start = np.array([*map(mpmath.mpf, problem.start)], dtype=object)
            start = np.concatenate([start, roots.start(grid[0], start, problem.parameters)])
            wide = replace(
                problem, start=start,
                suspect=suspect and (lambda times, states: suspect(times, states[:, :width])),
            )  # fmt: skip
            units = np.concatenate([natural_units(problem), np.ones(len(roots.degrees) + 1)])
            own = Problem(
                roots.program, np.append(start, mpmath.mpf(0)), [*problem.parameters, grid[0]],
                problem.tol, units=units,
            )  # fmt: skip
            ways = np.array([0.0, 1.0 if grid[-1] >= grid[0] else -1.0])
            stepper = _RootStepper(DigitsStepper(rules, own, ways, bits), grid, width)
            found = march(wide, grid, stepper, levels)
            times = np.array([mpmath.mpf(t) for t in found.t], dtype=object)
            return narrow(replace(found, t=times), width)

    return run


def _levels_at_roots(levels: Levels, problem: Problem, width: int) -> Levels:
    """The functions of events, those of switching surfaces zero where a root vanishes and they
    nearly do."""
    names = problem.levels.names if problem.levels is not None else ()
    switching_surfaces = np.array(
        [name in problem.switching_surfaces for name in names], dtype=bool
    )

    def function(t: np.ndarray, states: np.ndarray) -> np.ndarray:
        found = np.array(levels(t, states[:, :width]))
        at_root = (states[:, width:] == 0).any(axis=1)
        small = abs(found) < problem.tol**CLOSE
        found[at_root[:, None] & small & switching_surfaces] = 0
        return found

    return function


@dataclass
class _RootStepper:
    """The integrator in s, whose steps are looked at in the time."""

    inner: DigitsStepper
    grid: np.ndarray
    width: int

    @property
    def evaluations(self) -> int:
        """How often the coefficients were computed."""
        return self.inner.evaluations

    def advance(self) -> Stride:
        """The next step, up to where a root vanishes or the grid ends."""
        inner, origin, end = self.inner, self.grid[0], self.grid[-1] - self.grid[0]
        ahead = 1 if end >= 0 else -1
        inner.end = inner.time + ahead * (1 << inner.bits + FAR)
        stride = inner.advance()

        def row(s: Any) -> np.ndarray:
            return np.asarray(stride.at(np.array([s], dtype=object))[0])

        first = row(stride.start)
        s, column = self._root_in(stride, row)
        last = row(s)
        if column is not None:
            last[column] = mpmath.mpf(0)
        if ahead * (last[-1] - end) >= 0:
            s = _place(row, stride.start, first, s, last, -1, end)
            last = row(s)
            last[-1] = mpmath.mpf(end)
        if s != stride.end:
            inner.time, inner.state = (
                units_of(s, inner.bits),
                [units_of(x, inner.bits) for x in last],
            )

        def at(times: np.ndarray) -> np.ndarray:
            return np.array([
                last if t == origin + last[-1]
                else row(_place(row, stride.start, first, s, last, -1, t - origin))
                for t in times
            ], dtype=object)[:, :-1]  # fmt: skip

        return Stride(origin + first[-1], origin + last[-1], last[:-1], at)

    def _root_in(self, stride: Stride, row: Callable[[Any], np.ndarray]) -> tuple[Any, int | None]:
        """Where the first of the roots vanishes in a step, and which; else the end of the step."""
        a, before = stride.start, row(stride.start)
        for k in range(1, LOOKS + 1):
            b = stride.end if k == LOOKS else a + (stride.end - stride.start) / LOOKS
            after = row(b)
            fallen = [i for i in range(self.width, len(after) - 1) if after[i] <= 0]
            if any(before[i] <= 0 for i in fallen):
                raise IntegratorFailure(COLLAPSE)
            if fallen:
                places = [(_place(row, a, before, b, after, i, 0), i) for i in fallen]
                return min(places, key=lambda place: abs(place[0] - a))
            a, before = b, after
        return stride.end, None


def _place(
    row: Callable[[Any], np.ndarray], a: Any, before: np.ndarray, b: Any, after: np.ndarray,
    column: int, level: Any,
) -> Any:  # fmt: skip
    """Where between a and b a state reaches a level."""
    left, right = before[column] - level, after[column] - level
    if left == 0 or (left > 0) == (right > 0):
        return a if abs(left) <= abs(right) else b
    known = (np.array([x], dtype=object) for x in (a, left, b, right))
    return roots(lambda s, _: np.array([row(s[0])[column] - level]), *known)[0]
