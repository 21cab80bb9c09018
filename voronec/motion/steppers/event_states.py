"""Functions that are looked at on the way, integrated beside the state.

A method chooses its steps by the states alone.  A function of these may pass zero many times in one
such step, as sin(50 x) does where x grows evenly; where what bends in it is a state, too, steps are
as short as it asks for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.terms import atoms
from voronec.equations.program import Block, Program
from voronec.equations.program.jacobian import flow_derivative
from voronec.equations.program.straight import prune
from voronec.errors import EngineLimit
from voronec.motion.steppers.run import Integrator, Problem, Run

SMOOTH = (se.Add, se.Mul, se.sin, se.cos, se.sinh, se.cosh, se.tanh, se.atan, se.asinh)
PERIODIC = (se.tan, se.cot, se.sec, se.csc)


@lru_cache(maxsize=32)  # to differentiate takes longer than most runs
def with_parts(program: Program, block: Block, whole: bool = False) -> Program:
    """The program with what bends in the results of a block as further states behind its own, or
    with the ``whole`` results.

    What has no poles, corners or jumps is taken whole; of other functions the arguments are, of
    periodic ones the sine.  The program itself where nothing bends, or nobody differentiates it.
    """
    fresh = {name: se.Symbol(f"line of part {i}") for i, (name, _) in enumerate(block.assignments)}
    renamed = tuple((fresh[n], se.sympify(e).xreplace(fresh)) for n, e in block.assignments)
    results = [se.sympify(e).xreplace(fresh) for e in block.results]
    bends = _bending_parts(dict(renamed), results, {program.time, *program.state})
    parts = tuple(results if whole else bends)
    given = {program.time, *program.state, *program.parameters}
    known = given | {name for name, _ in (*program.derivative.assignments, *renamed)}
    if not parts or any(not e.free_symbols <= known for e in parts):
        return program
    lines = (*program.derivative.assignments, *renamed)
    try:
        moved = flow_derivative(program, Block(lines, parts))
    except EngineLimit:
        return program
    rates = tuple(rate for rate in moved.results if rate != 0)
    kept = prune(moved.assignments, (*program.derivative.results, *rates))
    if atoms(kept.expressions, se.Derivative, se.Subs):
        return program
    return program.beside(Block(kept.assignments, rates), "part")


def _bending_parts(lines: dict[Any, Any], results: list[Any], moving: set[Any]) -> Iterator[Any]:
    """Smooth functions, each once, that are no sums of states."""
    moving, waiting, seen = set(moving), list(results), set[Any]()
    uneven = set[Any]()
    for name, expr in lines.items():
        if expr.free_symbols & moving:
            moving.add(name)
            if not _is_smooth(expr, moving, uneven):
                uneven.add(name)
    while waiting:
        node = waiting.pop()
        if node in seen or not node.free_symbols & moving:
            continue
        seen.add(node)
        if _is_smooth(node, moving, uneven):
            bends = node.free_symbols & lines.keys() & moving
            if bends or any(node.diff(x).free_symbols & moving for x in node.free_symbols):
                yield node
        elif node in lines:
            waiting.append(lines[node])
        elif isinstance(node, PERIODIC):
            waiting.append(se.sin(node.args[0]))
        elif isinstance(node, se.floor | se.ceiling):
            waiting.append(se.sin(se.pi * node.args[0]))
        else:
            waiting += node.args


def _is_smooth(expr: Any, moving: set[Any], uneven: set[Any]) -> bool:
    """Whether an expression is a whole function of what moves, with known derivatives."""
    waiting = [expr]
    while waiting:
        node = waiting.pop()
        if node in uneven:
            return False
        if not node.args or not node.free_symbols & moving:
            continue
        if isinstance(node, se.Pow):
            base, exponent = node.args
            if base != se.E and not (isinstance(exponent, se.Integer) and exponent > 0):
                return False
        elif not isinstance(node, SMOOTH):
            return False
        waiting += node.args
    return True


def make_with_event_states(make: Any, problem: Problem) -> Integrator:
    """The stepper that a method makes of a problem, with functions of its events beside the state;
    those that are rare do not count, nor do those that are ``apart``."""
    levels = problem.levels
    assert levels is not None
    pairs = zip(levels.names, levels.extras.results, strict=True)
    apart = problem.coarse | problem.apart
    results = tuple(e for name, e in pairs if name not in apart)
    if not (problem.program.state and results):
        return make(problem)
    wide = with_parts(problem.program, replace(levels.extras, results=results), problem.whole)
    width, more = len(problem.start), len(wide.state) - len(problem.start)
    if not more:
        return make(problem)

    def exact(bits: int) -> tuple[np.ndarray, Any]:
        assert problem.exact is not None
        state, numbers = problem.exact(bits)
        return _extend(np.asarray(state, dtype=object), more), numbers

    suspect = problem.suspect
    wider = replace(
        problem,
        program=wide,
        start=_extend(problem.start, more),
        units=None if problem.units is None else _extend(problem.units, more),
        levels=replace(wide, names=levels.names, extras=levels.extras),
        exact=problem.exact and exact,
        suspect=suspect and (lambda times, states: suspect(times, states[:, :width])),
    )
    start, solver = wider.start, make(wider)

    def run(times: np.ndarray) -> Run:
        start[:width] = problem.start  # which runs in pieces overwrite
        start[width:] = 1
        return narrow(solver(times), width)

    return run


def _extend(row: np.ndarray, more: int) -> np.ndarray:
    return np.concatenate([row, np.ones(more, dtype=row.dtype)])


def narrow(run: Run, width: int) -> Run:
    """A run without what stands behind the first entries of its states."""
    inside, halt = run.inside, run.halt
    return replace(
        run,
        states=run.states[:, :width],
        crossings={name: (t, x[:, :width]) for name, (t, x) in run.crossings.items()},
        inside=None if inside is None else lambda times: inside(times)[:, :width],
        halt=halt and replace(halt, state=halt.state[:width]),
        samples=tuple(part.narrow(width) for part in run.samples),
    )
