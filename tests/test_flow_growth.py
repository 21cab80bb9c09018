"""What leaves the unit in which it set out loosens the steps of nothing else."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import sympy as sp

import voronec as vo

x, y, z, u, v, angle = sp.symbols("x y z u v angle")
DX, DY, DZ, DU, DV, SPIN = map(vo.velocity, (x, y, z, u, v, angle))
ENERGY = (DX**2 + DY**2) / 2 + x**2 / 2 - 1250 * y**2
"""A place that repels, beside a quick oscillator: x = a cosh t, y = cos 50 t."""
SIZE = 1e-9
END = 25.0
GRIDS = {
    "sparse": np.array([0.0, END]),
    "grid": np.linspace(0, END, 501),
    "backwards": np.linspace(0, -END, 26),
}


def repelling(**more: object) -> vo.System:
    given = {"fibration": vo.Fibration((x, y)), "lagrangian": ENERGY, **more}
    return vo.System(name="repelling", **given)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def beside() -> vo.VoronecEquations:
    return vo.derive(repelling())


def errors(times: np.ndarray, xs: np.ndarray, ys: np.ndarray, size: float = SIZE) -> float:
    """The largest error of the oscillator, and of the other in units of itself."""
    return float(
        max(
            np.abs(ys - np.cos(50 * times)).max(),
            np.abs(xs / (size * np.cosh(times)) - 1).max(),
        )
    )


@pytest.mark.parametrize("size", [SIZE, 1.0], ids=["tiny", "ordinary"])
@pytest.mark.parametrize("times", GRIDS.values(), ids=GRIDS.keys())
def test_what_grows(beside: vo.VoronecEquations, times: np.ndarray, size: float) -> None:
    run = vo.integrate(beside, initial={x: size, y: 1}, times=times, method="heyoka")
    assert errors(times, run["x"], run["y"], size) < 1e-12


def test_what_grows_far_beyond_ordinary_size(beside: vo.VoronecEquations) -> None:
    times = np.array([0.0, 40.0])
    run = vo.integrate(beside, initial={x: SIZE, y: 1}, times=times, method="heyoka")
    assert errors(times, run["x"], run["y"]) < 1e-12


def test_dense_output_and_events_of_what_grows(beside: vo.VoronecEquations) -> None:
    event, last = vo.Event(y - sp.Rational(1, 2), "half"), vo.Event(x - 10, "far", stop=True)
    run = vo.integrate(
        beside, initial={x: SIZE, y: 1}, times=[0, 30], method="heyoka", dense=True,
        events=(event, last),
    )  # fmt: skip
    end = np.arccosh(10 / SIZE)
    assert run.stopped == "far"
    assert abs(run.t[-1] - end) < 1e-12
    times = np.linspace(0, end * (1 - 1e-15), 2000)
    within = run.within(times)
    assert errors(times, within["x"], within["y"]) < 1e-12
    turns = np.arange(0, 200)[:, None]
    truth = ((2 * np.pi * turns + np.array([np.pi / 3, 5 * np.pi / 3])) / 50).ravel()
    truth = truth[truth < end]
    assert len(run.events["half"].t) == len(truth)
    assert np.abs(run.events["half"].t - truth).max() < 1e-13


@pytest.mark.slow
def test_a_path_that_nothing_depends_on() -> None:
    """z'' = x: a quadrature in a tiny unit, whose rate grows."""
    made = repelling(
        fibration=vo.Fibration((x, y, z)), lagrangian=ENERGY + DZ**2 / 2, forces={z: x}
    )
    times = np.linspace(0, END, 26)
    start = {x: SIZE, DX: SIZE, y: 1, DY: 50, DZ: SIZE}
    run = vo.integrate(made, initial=start, times=times, method="heyoka")
    assert np.abs(run["y"] - np.cos(50 * times) - np.sin(50 * times)).max() < 1e-12
    assert np.abs(run["z"][1:] / (SIZE * np.expm1(times[1:])) - 1).max() < 1e-12


def test_an_event_next_to_the_start_while_others_grow(beside: vo.VoronecEquations) -> None:
    """y comes back to 1 at once; before it does x is far beyond its unit."""
    event = vo.Event(y - 1, "back")
    run = vo.integrate(
        beside, initial={x: SIZE, DX: 1, y: 1, DY: 0.05}, times=[0, 1], method="heyoka",
        events=(event,),
    )  # fmt: skip
    assert len(run.events["back"].t) == 15
    assert abs(run.events["back"].t[0] - np.arctan(1e-3) / 25) < 1e-14


def test_an_input_between_pieces_of_the_growth() -> None:
    """A table that moves nothing cuts the run into pieces."""
    push = sp.Symbol("push")
    made = repelling(
        fibration=vo.Fibration((x, y, z)), lagrangian=ENERGY + DZ**2 / 2,
        inputs=(push,), forces={z: push},
    )  # fmt: skip
    table = vo.Table([0, 10, 20, 30], [1, 1, 1, 1], kind="held")
    run = vo.integrate(
        made, initial={x: SIZE, y: 1}, times=GRIDS["grid"], method="heyoka", inputs={push: table}
    )
    assert errors(GRIDS["grid"], run["x"], run["y"]) < 1e-12


@pytest.mark.slow
def test_ensembles_of_what_grows(beside: vo.VoronecEquations) -> None:
    few, ordinary = np.array([1e-9, 1e-12, 1.0, 3e-8, 1e-10]), np.array([1.0, 1e-3, 2.0])
    for sizes, times in product((few, ordinary), GRIDS.values()):
        run = vo.ensemble(beside, {x: sizes, y: 1}, {}, times, ("x", "y"), method="heyoka")
        assert not run.errors
        worst = [errors(times, *(run[n][i] for n in "xy"), size) for i, size in enumerate(sizes)]
        assert max(worst) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("sizes", [(1e-9, 1e-12, 3e-8), (1.0, 1e-3, 2.0)], ids=["tiny", "ordinary"])
def test_a_section_of_what_grows(beside: vo.VoronecEquations, sizes: tuple[float, ...]) -> None:
    points = vo.section(
        beside,
        "y",
        ("x", "ydot"),
        crossings=200,
        method="heyoka",
        starts={x: [*sizes], y: np.ones(3)},
    )
    truth = (1.5 * np.pi + 2 * np.pi * np.arange(200)) / 50
    for i, size in enumerate(sizes):
        mine = points.start == i
        assert np.abs(points.t[mine] - truth).max() < 1e-13
        assert np.abs(points["x"][mine] / (size * np.cosh(truth)) - 1).max() < 1e-12


@pytest.mark.parametrize("spin", [0.0635, 0.2])  # once when it has grown, and again and again
def test_growth_through_a_singular_split(spin: float) -> None:
    """A skate that turns beside them, to where its velocities along y no longer follow."""
    made = repelling(
        fibration=vo.Fibration((u, angle, x, y), (v,)),
        lagrangian=ENERGY + (DU**2 + DV**2 + SPIN**2) / 2,
        constraints=(DV * sp.cos(angle) - DU * sp.sin(angle),),
    )
    run = vo.integrate(
        made, initial={x: SIZE, y: 1, DU: 1, SPIN: spin}, times=GRIDS["grid"], method="heyoka"
    )
    assert errors(GRIDS["grid"], run["x"], run["y"]) < 1e-12
    assert np.abs(run["u"] - np.sin(spin * run.t) / spin).max() < 1e-11


@pytest.mark.slow
def test_growth_through_charts() -> None:
    """A point on a sphere beside them, on a great circle that passes next to the poles."""
    made = repelling(
        fibration=vo.Fibration((angle, u, x, y)),
        lagrangian=ENERGY + (SPIN**2 + sp.sin(angle) ** 2 * DU**2) / 2,
    )
    run = vo.integrate(
        made, initial={x: SIZE, y: 1, angle: sp.pi / 2, SPIN: 0.3, DU: 1e-9},
        times=GRIDS["grid"], method="heyoka",
    )  # fmt: skip
    assert run.cost.switches > 1
    assert errors(GRIDS["grid"], run["x"], run["y"]) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("many", [False, True])
def test_what_is_large_and_dies_away(many: bool) -> None:
    """x = a exp(-t/2) cos wt beside y = cos t + sin t: small against its first unit, it has all
    digits still."""
    made = repelling(lagrangian=(DX**2 + DY**2) / 2 - 1250 * x**2 - y**2 / 2, forces={x: -DX})
    times, size = np.linspace(0, 60, 61), 1e12
    start = {x: size, DX: -size / 2, y: 1, DY: 1}
    if many:
        start[x], start[DX] = np.full(3, size), np.full(3, -size / 2)
        run = vo.ensemble(made, start, {}, times, ("x", "y"), method="heyoka")
        xs, ys = run["x"][1], run["y"][1]
    else:
        one = vo.integrate(made, initial=start, times=times, method="heyoka")
        xs, ys = one["x"], one["y"]
    envelope = size * np.exp(-times / 2)
    truth = np.cos(np.sqrt(2500 - 0.25) * times)
    assert np.abs(xs / envelope - truth).max() < 2e-12
    assert np.abs(ys - np.cos(times) - np.sin(times)).max() < 1e-12


@pytest.mark.slow
def test_growth_without_end() -> None:
    """x'' = 6 x^2 beside a slow oscillator: 1/(T - t)^2 is infinite at T, and so it is told."""
    made = repelling(lagrangian=(DX**2 + DY**2) / 2 + 2 * x**3 - y**2)
    end = SIZE**-0.5
    start = {x: SIZE, DX: 2 * SIZE**1.5, y: 1}
    with pytest.raises(vo.IntegrationError, match=r"finite after t = 31622\.776") as caught:
        vo.integrate(made, initial=start, times=[0, 2 * end], method="heyoka")
    assert caught.value.state is not None
    start[x] = np.full(3, SIZE)
    times = np.linspace(0, 2 * end, 101)
    run = vo.ensemble(made, start, {}, times, ("x", "y"), method="heyoka")
    assert len(run.errors) == 3
    assert all("after t = 31622.776" in str(error) for error in run.errors.values())
    assert np.abs(run["x"][:, :50] * (end - times[:50]) ** 2 - 1).max() < 1e-9
