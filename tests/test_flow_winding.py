"""States that grow do not loosen the steps of the others, and come out whole."""

from __future__ import annotations

import numpy as np
import pytest
import symengine as se

import voronec as vo
from voronec.equations.program import Block
from voronec.motion.steppers.heyoka_stepper import TurnCount
from voronec.motion.steppers.units import _angles

pytestmark = pytest.mark.slow

a, b, v = se.symbols("a b v")


def test_what_is_taken_out_comes_back_to_a_rounding() -> None:
    winding = TurnCount(np.array([0]), np.array([1]), 3, np.ones(3))
    state = np.array([0.1, 40.0, 5.0])
    for _ in range(1000):
        state[:2] += (0.1, 7.0)
        winding.take(state)
        assert state[0] == 0 and abs(state[1]) < 3.2 and state[2] == 5
    whole = winding.whole(state)
    assert whole == pytest.approx([0.1 + 1000 * 0.1, 7040.0, 5.0], rel=4e-16)
    kept = winding.now()
    winding.reset()
    assert kept.whole(state) == pytest.approx(whole, rel=0)


@pytest.mark.parametrize(
    ("assignments", "results", "turning"),
    [
        ((), (v, se.cos(a) * v), {a}),
        ((), (v, se.sin(2 * a - b)), {a, b}),
        ((), (v, se.sin(a / 2)), set()),
        ((), (v, se.sin(a) + a), set()),
        (((se.Symbol("x"), a + b),), (v, se.sin(se.Symbol("x"))), {a, b}),
        (((se.Symbol("x"), a + b),), (v, se.Symbol("x") ** 2), set()),
        (((se.Symbol("x"), a * b),), (v, se.sin(se.Symbol("x"))), set()),
    ],
)
def test_angles_are_what_occurs_in_whole_multiples_under_sines(
    assignments: tuple[tuple[se.Expr, se.Expr], ...], results: tuple[se.Expr, ...],
    turning: set[se.Expr],
) -> None:  # fmt: skip
    assert _angles([Block(assignments, results)], [a, b, v]) & {a, b} >= turning
    assert not (_angles([Block(assignments, results)], [a, b, v]) - turning - {b} - {v})
    assert v not in _angles([Block(assignments, results)], [a, b, v])


def test_an_angle_of_ten_million_radians_costs_the_others_nothing() -> None:
    pytest.importorskip("heyoka")
    equations = vo.derive(vo.load("demchenko"))
    times, outputs = np.linspace(0, 50, 11), ("u", "s", "tau", "n", "v")
    initial = {"u": 1, "s": 0.2, "n": 1.5, "u1": 1}
    small, large = (
        vo.integrate(
            equations, times=times, outputs=outputs, initial=initial | {"v": start},
            method="heyoka",
        )
        for start in (0.0, 1e7)
    )  # fmt: skip
    for name in ("u", "s", "tau", "n"):
        assert large[name] == pytest.approx(small[name], abs=1e-11), name
    assert large["v"] - 1e7 == pytest.approx(small["v"], abs=4e-9)
    assert large.cost.steps == small.cost.steps
