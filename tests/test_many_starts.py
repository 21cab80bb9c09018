"""Starts that are read at once are those that are read one by one."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.equations.program import compile_program
from voronec.motion import initial_conditions, motion_pool
from voronec.motion.initial_conditions import parameter_values, start_of
from voronec.motion.request import Namespace, Starts, name_values, quantity
from voronec.motion.state_probe import quiet, rates_along

COUNT = 7
random = np.random.default_rng(11)
around = lambda *centre: {  # noqa: E731
    name: x + random.uniform(-0.1, 0.1, COUNT) for name, x in centre
}
CASES = {
    "own velocities": ("sleigh", around(("v", 1), ("w", 0.5), ("x", 0))),
    "rates": ("sleigh", around(("xdot", 1), ("phidot", 0.5)) | {"phi": np.zeros(COUNT)}),
    "body": ("ball-on-sphere", around(("u", 2), ("u1", 1), ("omega1", 0.5), ("omega3", 1))),
    "all": ("chaplygin-ball", around(("theta", 1), ("thetadot", 1), ("omega3", 2))),
}


def one_by_one(namespace, scene, starts):
    own = parameter_values(namespace, {}, set())
    program = motion_pool.Program.of(namespace.equations.form)
    values = [own.get(str(p), np.nan) for p in program.parameters]
    rates = partial(rates_along, quiet(compile_program(program)[0], values), 0.0)
    return [
        start_of(namespace, scene, name_values(namespace, s, "initial value"), own, rates).state
        for s in starts
    ]


@pytest.mark.parametrize(("name", "starts"), CASES.values(), ids=CASES)
def test_arrays_and_one_by_one_agree(name, starts, monkeypatch):
    equations = vo.derive(vo.load(name))
    namespace = Namespace.of(equations)
    scene = name_values(namespace, equations.system.scenes["default"].initial, "initial value")
    rows = [{k: float(x[i]) for k, x in starts.items()} for i in range(COUNT)]
    expected, asked = one_by_one(namespace, scene, rows), []
    monkeypatch.setattr(motion_pool, "start_of", lambda *a: asked.append(a) or start_of(*a))
    wanted = dict(quantity(namespace, q) for q in equations.system.coordinates)
    default = equations.system.scenes["default"]
    found = motion_pool.many(equations, default, Starts.of(rows), {}, wanted, 0.0)
    assert not asked and not found.wrong, "all are read at once"
    assert np.abs(found.full - expected).max() < 1e-14 * np.abs(expected).max()


def test_what_does_not_fit_is_left_over():
    equations = vo.derive(vo.load("sleigh"))
    namespace = Namespace.of(equations)
    program = motion_pool.Program.of(equations.form)
    own = {k: np.full(3, x) for k, x in parameter_values(namespace, {}, set()).items()}
    values = np.stack([own[str(p)] for p in program.parameters], axis=-1)
    rates = partial(motion_pool.rates_in_arrays, compile_program(program)[0], values, 0.0)

    def read(starts):
        return initial_conditions.starts_in_arrays(namespace, {}, Starts.of(starts), own, rates)

    fits = {"xdot": 1.0, "ydot": 0.0, "phi": 0.0}
    found = read([fits, {**fits, "ydot": 1.0}, fits])
    assert np.isnan(found[1]).all() and np.isfinite(found[[0, 2]]).all()
    order = [str(x) for x in (*equations.system.coordinates, *equations.system.velocities)]
    assert found[0, order.index("v")] == pytest.approx(1, abs=1e-15)
    for other in ({"xdot": "1", "ydot": 0.0, "phi": 0.0}, {"v": 1.0}, {**fits, "phi": np.inf}):
        found = read([fits, other, fits])
        assert np.isnan(found[1]).all()


def test_a_value_that_stands_for_all_is_read_once(monkeypatch):
    """Arrays are not spread to a mapping for each start, whatever stands beside them."""
    sleigh = vo.derive(vo.load("sleigh"))
    monkeypatch.setattr(motion_pool, "start_of", lambda *_: pytest.fail("one by one"))
    angle, speeds = sp.pi / 6, np.linspace(1, 2, COUNT)
    found = vo.ensemble(sleigh, {"phi": angle, "v": speeds, "w": "1/2"}, times=[0.0, 0.5])
    alone = vo.ensemble(sleigh, {"phi": np.pi / 6, "v": 2.0, "w": 0.5}, times=[0.0, 0.5])
    assert not found.errors and found["v"][:, 0] == pytest.approx(speeds, abs=1e-15)
    for name in found.outputs:
        assert found[name][-1] == pytest.approx(alone[name][0], abs=1e-14)
