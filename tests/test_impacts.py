"""A law of impacts v+ = R(q) v- is one more transition of the loop over phases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.equations.program import Program
from voronec.motion.steppers import Problem, Run
from voronec.motion.transitions import (
    ZENO,
    Arrival,
    Guard,
    Phase,
    Solver,
    choose,
    quantities,
    restart,
)

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Impact:
    """The state is another one where a gap closes."""

    law: Callable[[np.ndarray], np.ndarray]

    def next(self, phase: Phase, here: Arrival) -> Phase:
        state = self.law(here.state)
        return replace(phase, time=here.time, state=state, home=state)


def bounce(system, start, values, gap, law, grid, method="scipy") -> Run:
    """The motion, with what the ``law`` makes of its states (n,) where the ``gap`` closes."""
    equations = vo.derive(system)
    form, start = equations.form, np.array(start, dtype=float)
    guard = Guard("gap", -1, stop=True)
    levels = quantities(form, {guard.name: equations.bridge.inward(gap)})
    numbers = [float(values[str(p)]) for p in form.parameters]
    problem = Problem(
        Program.of(form),
        start,
        numbers,
        1e-13,
        (guard,),
        levels,
        True,
        switching_surfaces=frozenset({"gap"}),
    )
    solver, _ = choose(method, problem, grid)
    guards = {guard.name: Impact(law)}
    phase = Phase(None, grid[0], start, start, restart(solver, problem), guards)
    return Solver(grid, problem.events, dense=True).run(phase)


E, G, HEIGHT = 0.6, 9.81, 1.3
x = sp.Symbol("x")
BALL = vo.System(
    name="ball", fibration=vo.Fibration(base=(x,)),
    lagrangian=vo.velocity(x) ** 2 / 2 - sp.Float(G) * x,
)  # fmt: skip


@pytest.mark.parametrize("method", ["scipy", "heyoka"])
def test_a_particle_bounces_at_the_times_of_galilei(method):
    """Falling takes sqrt(2 h/g), and each flight e times as long as the one before."""
    pytest.importorskip(method)
    fall, grid = np.sqrt(2 * HEIGHT / G), np.linspace(0, 1.9, 20)
    run = bounce(BALL, [HEIGHT, 0], {}, x, lambda s: s * [0, -E], grid, method)
    impacts = fall + np.cumsum([0, *2 * fall * E ** np.arange(1, 30)])
    found, exact = run.crossings["gap"][0], impacts[impacts < grid[-1]]
    assert len(found) == len(exact) == 5
    assert np.abs(found - exact).max() < 1e-12
    energies = [G * HEIGHT * E ** (2 * np.searchsorted(exact, t)) for t in grid]
    assert np.abs(run.states[:, 1] ** 2 / 2 + G * run.states[:, 0] - energies).max() < 1e-11
    assert np.abs(run.inside(grid) - run.states).max() < 1e-12


def test_bounces_that_have_no_end_stop_the_run_where_they_accumulate():
    fall = np.sqrt(2 * HEIGHT / G)
    run = bounce(BALL, [HEIGHT, 0], {}, x, lambda s: s * [0, -E], np.linspace(0, 9, 10))
    assert run.halt.reason == ZENO
    assert abs(run.halt.time - fall * (1 + E) / (1 - E)) < 1e-6
    assert run.t[-1] <= run.halt.time


@pytest.mark.parametrize("restitution", [1.0, 0.4])
def test_a_sleigh_hits_a_wall_with_its_nose(restitution):
    """Without friction the wall pushes along n = d(x + b cos phi)/d(v, w), and the matrix
    R = 1 - (1 + e) M^-1 n n^T/(n^T M^-1 n) of the velocities takes from the energy
    (1 - e^2) (n v-)^2/(2 n^T M^-1 n).  With the centre of mass over the blade v and w are constant
    before, and x + b cos phi = x0 + (v/w) (sin phi - sin phi0) + b cos phi."""
    sleigh, m, inertia, nose, wall = vo.load("sleigh"), 2.0, 0.5, 0.7, 1.5
    names = [str(q) for q in vo.derive(sleigh).form.coordinates]
    at, v, w, angle = names.index("phi"), 1.2, 0.3, 0.25
    gap = wall - sp.Symbol("x") - sp.Float(nose) * sp.cos(sp.Symbol("phi"))
    mass = np.array([m, inertia])

    def normal(state):
        return np.array([np.cos(state[at]), -nose * np.sin(state[at])])

    def law(state):
        n = normal(state)
        push = (1 + restitution) * (n @ state[-2:]) / (n @ (n / mass))
        return np.concatenate([state[:-2], state[-2:] - push * n / mass])

    start = [{"phi": angle, "x": 0.0, "y": 0.0}[name] for name in names]
    values, grid = {"m": m, "J": inertia, "a": 0.0}, np.linspace(0, 1.5, 4)
    run = bounce(sleigh, [*start, v, w], values, gap, law, grid)
    (time,), (hit,) = run.crossings["gap"]
    size, shift = np.hypot(v / w, nose), np.arctan2(nose, v / w)
    exact = (np.arcsin((wall + v / w * np.sin(angle)) / size) - shift - angle) / w
    assert abs(time - exact) < 1e-12
    n, after = normal(hit), run.states[-1][-2:]
    assert abs(n @ after + restitution * (n @ [v, w])) < 1e-11
    lost = (1 - restitution**2) * (n @ [v, w]) ** 2 / (2 * n @ (n / mass))
    assert abs(mass @ np.array([v, w]) ** 2 / 2 - mass @ after**2 / 2 - lost) < 1e-11
    assert abs(after[1] - w) > 0.1  # it turns about: the push is not through the centre
