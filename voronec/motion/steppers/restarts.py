"""Runs whose parameters change at known instants: each piece begins where the last one ended.

No step goes over a change, so every method keeps its order, and a jump is met exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np

from voronec.equations.program import compile_program
from voronec.motion.steppers.run import Problem, Run, Stepper, in_parts
from voronec.motion.steppers.signals import exact_mpf

__all__ = ["in_pieces"]


def in_pieces(make: Callable[[Problem], Stepper], problem: Problem, anew: bool) -> Stepper:
    """The stepper of a problem with ``changing`` parameters: made once, or ``anew`` for each piece,
    where it asks for its numbers ``exact`` when it is made."""
    changing, names = problem.changing, [str(p) for p in problem.program.parameters]
    assert changing is not None
    given = list(problem.parameters)
    left = changing if changing.python_signal is not None else None
    own = replace(
        problem, start=problem.start.copy(), parameters=given, progress=None, changing=left
    )
    once = None if anew else make(own)

    def on_piece(state: np.ndarray, times: np.ndarray) -> Run:
        values = changing.on(float(times[0]), float(times[-1]))
        given[:] = [float(values.get(n, x)) for n, x in zip(names, given, strict=True)]
        own.start[:] = state.astype(float)
        if once is not None:
            return once(times)

        def exact(bits: int) -> tuple[np.ndarray, Sequence[Any]]:
            first, known = problem.exact(bits) if problem.exact else (state, problem.parameters)
            with mpmath.workprec(bits):
                numbers = [exact_mpf(values.get(n, x)) for n, x in zip(names, known, strict=True)]
            return (first if state is problem.start else state), numbers

        return make(replace(own, exact=exact))(times)

    return lambda grid: _run_in_pieces(problem, grid, on_piece)


def _run_in_pieces(
    problem: Problem, grid: np.ndarray, on_piece: Callable[[np.ndarray, np.ndarray], Run]
) -> Run:
    """Piece after piece, up to the end of the grid; ``on_piece`` goes on from a state (n,)."""
    assert problem.changing is not None
    parts: list[Run] = []
    state, time = problem.start, grid[0]
    order = 1.0 if grid[-1] >= grid[0] else -1.0
    for end in [*problem.changing.knots(float(grid[0]), float(grid[-1])), float(grid[-1])]:
        inside = grid[(order * grid > order * time) & (order * grid < order * end)]
        times = [time, *inside, *([end] if end != time else [])]
        parts.append(on_piece(state, np.array(times)))
        last = parts[-1]
        if last.halt is not None or last.interrupted or last.stopped:
            break
        time, state = end, last.states[-1]
        if end != float(grid[-1]):
            parts[-1] = last = _with_jumps(problem, last, (float(last.t[0]), end, float(grid[-1])))
            if last.stopped:
                break
        if problem.progress is not None:
            problem.progress(float((end - grid[0]) / ((grid[-1] - grid[0]) or 1.0)))
    return _join_runs(parts, grid, problem)


def _with_jumps(problem: Problem, part: Run, times: tuple[float, float, float]) -> Run:
    """A piece with the events whose functions jump through zero at its end, with what changes;
    ``times`` are its ends, and the end of the run."""
    levels, changing = problem.levels, problem.changing
    if levels is None or changing is None or not problem.events:
        return part
    first, end, later = times
    ahead = [t for t in changing.knots(end, later) if t != end]
    state, given = part.states[-1], list(map(str, levels.parameters))
    own = dict(zip(map(str, problem.program.parameters), problem.parameters, strict=True))
    sides = []
    for values in (changing.on(first, end), changing.on(end, ahead[0] if ahead else later)):
        known = {**own, **values}
        numbers = [float(known[name]) for name in given]
        found = compile_program(levels)[1](end, [float(x) for x in state], numbers)
        sides.append(dict(zip(levels.names, map(float, found), strict=True)))
    crossings, stopped = dict(part.crossings), ""
    order = 1 if later >= first else -1
    for event in problem.events:
        before, after = (side[event.name] for side in sides)
        wanted = event.direction == 0 or (after > before) == (event.direction * order > 0)
        if before * after < 0 and wanted:
            t, states = crossings[event.name]
            moment = np.array([part.t[-1]], dtype=part.t.dtype)
            crossings[event.name] = np.append(t, moment), np.vstack([states, state])
            stopped = stopped or (event.name if event.stop else "")
    return replace(part, crossings=crossings, stopped=stopped)


def _join_runs(parts: Sequence[Run], grid: np.ndarray, problem: Problem) -> Run:
    """One run of several; the instants between them are left out where nobody asked for them."""
    last, times, rows = parts[-1], [], []
    for i, part in enumerate(parts):
        asked = np.isin(part.t.astype(float), grid)
        asked[0] = i == 0
        if part is last and (last.stopped or last.interrupted):
            asked[-1] = asked[-1] or i == 0 or len(part.t) > 1
        times.append(part.t[asked])
        rows.append(part.states[asked])
    crossings = {
        name: (
            np.concatenate([part.crossings[name][0] for part in parts]),
            np.concatenate([part.crossings[name][1] for part in parts]),
        )
        for name in last.crossings
    }
    return replace(
        last,
        t=np.concatenate(times),
        states=np.vstack(rows),
        steps=sum(part.steps for part in parts),
        evaluations=sum(part.evaluations for part in parts),
        crossings=crossings,
        switches=sum(part.switches for part in parts),
        held=any(part.held for part in parts),
        prepared=sum(part.prepared for part in parts),
        notes=tuple(dict.fromkeys(note for part in parts for note in part.notes)),
        inside=_inside(parts) if problem.dense else None,
        ends=tuple(end for part in parts for end in part.ends),
    )


def _inside(parts: Sequence[Run]) -> Callable[[np.ndarray], np.ndarray] | None:
    """States at any times reached, from the dense output of each part."""
    functions = [part.inside for part in parts]
    if any(f is None for f in functions):
        return None
    ends = [part.t[-1] for part in parts]
    order = 1.0 if ends[-1] >= parts[0].t[0] else -1.0
    return lambda times: in_parts(ends, order, functions, times, parts[0].states)
