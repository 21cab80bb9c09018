"""Ensembles: many starts with one integrator, each as if it ran alone."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.motion import batches, ensembles, one_by_one
from voronec.motion.steppers import heyoka_stepper
from voronec.motion.steppers import run as run_module

pytestmark = pytest.mark.slow

x, y, w = sp.symbols("x y w")
xdot, ydot = vo.velocity(x), vo.velocity(y)

INSTALLED = importlib.util.find_spec("heyoka") is not None
HEYOKA = pytest.mark.skipif(not INSTALLED, reason="no heyoka")
METHODS = [pytest.param("heyoka", marks=HEYOKA), "scipy"]
GRID = np.linspace(0.0, 6.0, 25)


@pytest.fixture(scope="module")
def oscillator() -> vo.VoronecEquations:
    return vo.derive(
        vo.System(
            name="oscillator",
            fibration=vo.Fibration(base=(x,), fibre=()),
            lagrangian=(xdot**2 - w**2 * x**2) / 2,
            constraints=(),
            parameters=(vo.Parameter(w, 2, positive=True),),
            integrals={"energy": (xdot**2 + w**2 * x**2) / 2},
            scenes={"default": vo.Scene(initial={x: 1}, times=(0.0, 10.0))},
        )
    )


@pytest.fixture(scope="module")
def falling() -> vo.VoronecEquations:
    """y falls to the centre, from rest at y0 in the time pi (y0/2)^(3/2)."""
    return vo.derive(
        vo.System(
            name="falling",
            fibration=vo.Fibration(base=(y,), fibre=()),
            lagrangian=ydot**2 / 2 + 1 / y,
            constraints=(),
            parameters=(),
            integrals={"energy": ydot**2 / 2 - 1 / y},
        )
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("grid", [GRID, GRID[::-1], GRID[:1]])
def test_every_start_moves_as_it_must(oscillator, method, grid):
    amplitudes = np.linspace(-1.0, 2.0, 7)
    found = vo.ensemble(oscillator, {"x": amplitudes}, times=grid, method=method)
    exact = amplitudes[:, None] * np.cos(2 * (grid - grid[0]))
    assert found["x"].shape == (7, len(grid))
    assert np.abs(found["x"] - exact).max() < 2e-12
    assert found.finished.all()
    assert len(found) == 7
    assert found.cost.method == method


@pytest.mark.parametrize("method", METHODS)
def test_parameters_may_be_arrays(oscillator, method):
    rates = np.array([0.5, 1.0, 3.0, 4.0, 6.0])
    found = vo.ensemble(
        oscillator, scene="default", parameters={w: rates}, times=GRID, outputs=(x,), method=method
    )
    assert np.abs(found[x] - np.cos(rates[:, None] * GRID)).max() < 1e-11
    assert found.parameters["w"].tolist() == rates.tolist()


@pytest.mark.parametrize("method", ["auto", "scipy", "heyoka"])
def test_constants_alone_are_answered(method):
    run = vo.ensemble(
        vo.load("sleigh"), {"v": [1, 2]}, times=[0, 1, 2], outputs=("m",), method=method,
        parameters={"m": [1.5, 2.5]},
    )  # fmt: skip
    assert np.array_equal(run["m"], [[1.5] * 3, [2.5] * 3])


def test_starts_may_be_a_list_of_mappings_over_a_scene(oscillator):
    found = vo.ensemble(oscillator, [{}, {"xdot": 2}, {x: 0}], scene="default", times=GRID)
    assert found["x"][:, 0].tolist() == [1.0, 1.0, 0.0]
    assert found["xdot"][:, 0].tolist() == [0.0, 2.0, 0.0]
    assert found.outputs == ("x", "xdot")


@pytest.mark.parametrize("method", METHODS)
def test_a_motion_that_breaks_down_keeps_what_came_before_and_the_others_go_on(falling, method):
    heights = np.array([50.0, 1.0, 60.0, 70.0, 2.0, 80.0])
    found = vo.ensemble(falling, {"y": heights}, times=GRID, method=method)
    assert found.finished.tolist() == [True, False, True, True, False, True]
    assert sorted(found.errors) == [1, 4]
    for i, collision in ((1, np.pi * 0.5**1.5), (4, np.pi)):
        assert isinstance(found.errors[i], vo.IntegrationError)
        assert collision - 0.26 < found.errors[i].time < collision + 1e-6
        assert f"start {i}" in str(found.errors[i])
        before = collision - 1e-6 > GRID
        assert np.isfinite(found["y"][i][before]).all()
        assert np.isnan(found["y"][i][~before]).all()
    alone = vo.ensemble(falling, {"y": heights[[5]]}, times=GRID, method=method)
    assert found["y"][5] == pytest.approx(alone["y"][0], abs=1e-12)


@HEYOKA
def test_what_breaks_down_in_one_load_of_the_lanes_disturbs_no_other(falling, monkeypatch):
    """Of a hundred motions a third come to the centre, each at a time of its own."""
    monkeypatch.setattr("voronec.motion.ensembles.REPORTS", 1)  # they all go together
    heights = np.random.default_rng(3).uniform(0.5, 6.0, 100)
    found = vo.ensemble(falling, {"y": heights}, times=GRID, method="heyoka", tol=1e-12)
    collisions = np.pi * (heights / 2) ** 1.5
    assert found.finished.tolist() == (collisions > GRID[-1]).tolist()
    assert 20 < len(found.errors) < 60
    for i, time in enumerate(collisions):
        before = time - 1e-3 > GRID
        alone = vo.integrate(falling, initial={"y": heights[i]}, times=GRID[before], tol=1e-12)
        assert np.abs(found["y"][i][before] - alone["y"]).max() < 1e-8
        assert np.isnan(found["y"][i][time + 1e-3 < GRID]).all()
        assert i not in found.errors or time - 0.26 < found.errors[i].time < time + 1e-6


@HEYOKA
def test_parameters_of_their_own_go_with_motions_that_stand_beside_broken_ones():
    """The lanes of a load are filled up with others where a motion has ended."""
    grows = vo.System(
        name="grows", fibration=vo.Fibration(base=(x,)), lagrangian=xdot**2 / 2,
        forces={x: w * xdot**2}, parameters=(w,),
    )  # fmt: skip
    pulls = np.linspace(-1.0, 1.0, 41)  # xdot = 1/(1 - w t) ends at t = 1/w
    found = vo.ensemble(grows, {"xdot": 1.0}, {w: pulls}, times=np.linspace(0, 2, 9), tol=1e-13)
    ends = pulls * 2 >= 1
    assert np.array_equal(found.finished, ~ends)
    for i in np.flatnonzero(found.finished):
        exact = 1 / (1 - pulls[i] * found.t)
        assert found["xdot"][i] == pytest.approx(exact, rel=1e-9)


def test_a_start_that_cannot_be_is_marked_and_the_others_go_on(oscillator, falling):
    found = vo.ensemble(oscillator, {"x": 1.0}, {"w": [1.0, -2.0, 3.0]}, times=GRID)
    assert found.finished.tolist() == [True, False, True]
    assert "must be positive" in str(found.errors[1])
    found = vo.ensemble(falling, {"y": [0.0, 60.0]}, times=GRID)
    assert found.finished.tolist() == [False, True]
    assert "not defined at start 0" in str(found.errors[0])


def test_where_every_start_is_wrong_the_first_error_is_raised(falling):
    with pytest.raises(vo.IntegrationError, match="not defined at start 0"):
        vo.ensemble(falling, {"y": [0.0, 0.0]}, times=GRID)


SCRIPT = """
import voronec as vo
from voronec.motion import ensembles
ensembles.WORTH = 0.0
vo.ensemble(vo.load("sleigh"), {"w": [float(k) for k in range(99)]}, times=[0.0, 1.0], jobs=2)
"""


@pytest.fixture
def always_shared(monkeypatch):
    """Processes share all work, as if each motion took long."""
    monkeypatch.setattr(ensembles, "WORTH", 0.0)


@pytest.mark.parametrize("method", METHODS)
def test_processes_change_no_bit(oscillator, falling, method, always_shared):
    """What fails, fails as it would in one process."""
    starts = {"x": np.linspace(0.5, 1.5, 150 if method == "heyoka" else 4)}
    for system, each in ((oscillator, starts), (falling, {"y": [4.0, 0.5, 3.0, 0.0, 1.0]})):
        one, two = (
            vo.ensemble(system, each, times=GRID, jobs=k, method=method, tol=1e-9) for k in (1, 2)
        )
        assert one.errors.keys() == two.errors.keys()
        assert (one.finished == two.finished).all() and one.finished.any()
        for name in one.outputs:
            assert one[name].tobytes() == two[name].tobytes()
        for i, error in one.errors.items():
            assert type(error) is type(two.errors[i]) and str(error) == str(two.errors[i])


def test_a_script_that_processes_cannot_read_is_told_so_in_one_line(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    run = [sys.executable, "script.py"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    told = done.stderr.splitlines()[-1]
    assert done.returncode == 1 and "DefinitionError: several jobs are processes" in told
    assert done.stderr.count("if __name__ == '__main__':") == 1


@HEYOKA
@pytest.mark.parametrize("grid", [np.array([0.0, 40.0]), np.array([0.0, 1.0, 40.0, 40.5])])
def test_long_stretches_are_cut_without_a_trace(oscillator, monkeypatch, grid):
    whole = vo.ensemble(oscillator, {"x": [1.0, 2.0, 3.0]}, times=grid, method="heyoka")
    monkeypatch.setattr(batches, "CHUNK", 7)
    cut = vo.ensemble(oscillator, {"x": [1.0, 2.0, 3.0]}, times=grid, method="heyoka")
    assert np.abs(cut["x"] - whole["x"]).max() < 1e-11
    assert cut.finished.all()


def test_what_was_not_run_since_the_set_up_was_stopped_says_so(oscillator, monkeypatch):
    """It printed as an ensemble of motions like any other."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("voronec.motion.ensembles.many", stop)
    found = vo.ensemble(oscillator, {"x": [0.5, 1.0]}, times=GRID)
    assert found.interrupted and not found.finished.any() and np.isnan(found["x"]).all()
    assert "2 not run: stopped by hand" in repr(found)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_run_stopped_by_hand_keeps_the_finished_starts(oscillator, method, jobs, always_shared):
    def stop(fraction: float) -> None:
        raise KeyboardInterrupt

    starts = {"x": np.linspace(0.5, 1.5, 400 if method == "heyoka" else 5)}
    found = vo.ensemble(oscillator, starts, times=GRID, method=method, progress=stop, jobs=jobs)
    assert found.interrupted
    assert found.finished.any()
    assert not found.errors
    exact = starts["x"][:, None] * np.cos(2 * GRID)
    assert np.abs(found["x"] - exact)[found.finished].max() < 1e-11
    if jobs == 1:
        assert not found.finished.all()
        assert np.isnan(found["x"][~found.finished]).all()


def test_progress_ends_at_one(oscillator):
    told = []
    vo.ensemble(oscillator, {"x": np.ones(70)}, times=GRID, progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1.0


@pytest.mark.parametrize("method", METHODS)
def test_drift_is_that_of_each_start(oscillator, method):
    found = vo.ensemble(oscillator, {"x": [0.0, 1e-3, 1.0]}, times=GRID, method=method)
    assert found.drift["energy"].shape == (3,)
    assert found.drift["energy"][2] < 1e-11
    assert found.drift["energy"][0] == 0.0
    alone = vo.integrate(oscillator, times=GRID, initial={"x": 1e-3}, method=method)
    assert found.drift["energy"][1] < 10 * max(1e-12, alone.drift["energy"]) < 1e-9


def test_integrals_that_do_not_hold_show_in_the_drift(oscillator):
    system = oscillator.system
    wrong = vo.System(
        name="wrong", fibration=system.fibration, lagrangian=system.lagrangian, constraints=(),
        parameters=system.parameters, integrals={"wrong": x**2},
    )  # fmt: skip
    found = vo.ensemble(wrong, {"x": [1.0, 2.0]}, times=GRID)
    assert found.drift["wrong"].min() > 0.5


def test_the_smallest_model_gives_the_same_as_the_coordinates():
    equations = vo.derive(vo.load("ball-on-sphere"))
    starts = {"omega1": [0.5, 0.6, 0.7], "omega2": [1.0, -1.0, 0.2]}
    names = ("gamma1", "omega1")
    low = vo.ensemble(equations, starts, scene="default", times=GRID, outputs=names)
    high = vo.ensemble(equations, starts, scene="default", times=GRID, outputs=(*names, "u"))
    alone = vo.integrate(equations, "default", GRID, names, initial={"omega1": 0.6, "omega2": -1.0})
    assert low.formulation != high.formulation
    for name in names:
        assert low[name] == pytest.approx(high[name], abs=1e-10)
        assert low[name][1] == pytest.approx(alone[name], abs=1e-10)


def test_bad_input_is_refused_in_one_line(oscillator):
    cases = [
        ({"starts": {"x": [1, 2], "xdot": [1, 2, 3]}}, "has 2 entries, where others have 3"),
        ({"starts": []}, "the list of starts has no entries; give one for each motion"),
        ({"starts": {"z": [1.0]}}, "no initial value 'z'"),
        ({"starts": [{"w": 1}]}, "no initial value 'w', a parameter; give parameters={'w': ...}"),
        ({"starts": {w: [1]}}, "no initial value 'w', a parameter; give parameters={'w': ...}"),
        ({"starts": {"x": []}}, "one-dimensional array"),
        ({"starts": [1.0, 2.0]}, "list of mappings"),
        ({"starts": {"x": [1.0]}, "outputs": ("xx",)}, "no output 'xx'"),
        ({"starts": {"x": [1.0]}, "parameters": {"ww": 1}}, "no parameter 'ww'"),
        ({"starts": {"x": [1.0]}, "times": [0, 1, 0.5]}, "strictly monotonic"),
        ({"starts": {"x": [1.0]}, "tol": 2.0}, "between 0 and 1"),
        ({"starts": {"x": [1.0]}, "method": "flint"}, "no method 'flint'"),
        ({"starts": {"x": [1.0]}, "scene": "defaul"}, "did you mean 'default'"),
    ]
    for given, words in cases:
        with pytest.raises(vo.DefinitionError) as refused:
            vo.ensemble(oscillator, **({"times": GRID} | given))
        assert words in str(refused.value), words
        assert "\n" not in str(refused.value)
    found = vo.ensemble(oscillator, {"x": [1.0]}, times=GRID)
    with pytest.raises(vo.DefinitionError, match="did you mean 'xdot'"):
        found["xdo"]


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_starts_at_poles_and_near_them_move_as_if_alone(method):
    ball = vo.derive(vo.load("chaplygin-ball"))
    starts = {"theta": [0.0, 1e-9, 0.3], "omega1": 0.5, "omega2": 1.0, "omega3": 1.0}
    times = np.linspace(0, 2, 5)
    # and one that comes to a pole on its way
    begin = vo.integrate(
        ball, times=[0, -1], outputs=(), method=method,
        initial={"theta": 1e-8, "omega1": 0.5, "omega2": 1, "omega3": 1},
    )  # fmt: skip
    names = ("phi", "theta", "psi", "x", "y", "omega1", "omega2", "omega3")
    rows = [
        {**{k: x for k, x in starts.items() if k != "theta"}, "theta": x} for x in starts["theta"]
    ]
    rows.append({name: begin[name][-1] for name in names})
    turns = vo.ensemble(ball, starts=rows, times=times, outputs=names, method=method)
    assert not turns.errors and turns.finished.all() and turns.cost.switches >= 3
    for i, row in enumerate(rows):
        alone = vo.integrate(ball, initial=row, times=times, outputs=names, method=method)
        for name in names:
            assert turns[name][i] == pytest.approx(alone[name], abs=1e-11)


def test_where_every_start_is_at_a_pole_each_goes_alone():
    ball = vo.derive(vo.load("chaplygin-ball"))
    times = np.linspace(0, 1, 3)
    turns = vo.ensemble(
        ball,
        starts={"theta": 0.0, "omega1": [0.5, 0.2], "omega2": 1.0},
        times=times,
        outputs=("phi",),
    )
    assert turns.finished.all() and "alone" in turns.cost.reason


def test_a_motion_through_its_singular_split_is_as_if_alone():
    ball = vo.derive(vo.load("rubber-ball-on-plane"))
    times = np.linspace(0, 6, 13)
    start = {"v": 0.5, "theta": 0.3, "omega1": 0.7, "omega2": [-0.2, 0.3], "u": [1.2, 1.0]}
    for method, tol in (("scipy", 1e-13), ("heyoka", 1e-16)):
        turns = vo.ensemble(ball, starts=start, times=times, outputs=(), method=method, tol=tol)
        assert not turns.errors
        for i in range(2):
            row = {k: x[i] if isinstance(x, list) else x for k, x in start.items()}
            alone = vo.integrate(ball, initial=row, times=times, outputs=(), tol=tol)
            for name in alone.outputs:
                assert turns[name][i] == pytest.approx(alone[name], abs=1e-10)


def test_a_look_back_at_long_steps_does_not_end_a_motion():
    """Steps vary so much in length that they are gone over again, in the middle of an interval."""
    ball, dice = vo.derive(vo.load("ball-on-sphere")), np.random.default_rng(1)
    starts = [
        {"u": 0.7 + 0.6 * dice.random(), "u1": 0.9 + 0.3 * dice.random()}
        | {f"omega{k}": dice.uniform(-1, 1) for k in (1, 2, 3)}
        for _ in range(43)
    ]
    starts = [starts[i] for i in (3, 6, 9, 11, 19, 29, 42)]  # whose steps end one after another
    options = {"times": [0, 100], "outputs": ("u", "v"), "tol": 1e-12}
    many = vo.ensemble(ball, starts, method="heyoka", **options)
    for i, start in enumerate(starts):
        alone = vo.integrate(ball, initial=start, method="scipy", **options)
        for name in ("u", "v"):
            assert many[name][i][-1] == pytest.approx(alone[name][-1], abs=1e-7)


def test_a_motion_whose_steps_lead_nowhere_is_given_up_and_goes_on_alone():
    """Where the new time stands still the steps of DOP853 become ever shorter."""
    ball = vo.derive(vo.load("veselova-in-new-time"))
    start = {"gamma1": -0.7715241163850226, "gamma2": 0.6346085672337947}
    start |= {"gamma3": 0.044972260670111425, "Omega1": -0.273, "Omega2": -0.038}
    inertia = {"J1": 1.1143884171903848, "J2": 1.6142348188643547, "J3": 1.5429880954340192}
    run = {"parameters": inertia, "times": [0, -19], "outputs": ("gamma1", "Omega1")}
    turns = vo.ensemble(ball, [start], method="scipy", tol=1e-13, **run)
    alone = vo.integrate(ball, initial=start, method="heyoka", tol=1e-13, **run)
    assert turns.finished.all()
    for name in run["outputs"]:
        assert turns[name][0] == pytest.approx(alone[name], abs=1e-8)


@pytest.mark.parametrize("count", [63, 64, 320])
def test_a_motion_that_comes_to_rest_where_taylor_coefficients_vanish(count: int) -> None:
    """x'' = 1 - x^2 rests at 0 after one unit of time, where a piece of the grid ends: heyoka's own
    step from there is far too long."""
    x = sp.Symbol("x")
    bowl = vo.derive(vo.System("bowl", vo.Fibration(x), vo.velocity(x) ** 2 / 2 + x - x**3 / 3))
    rest = {"x": 0, "xdot": 0}
    back = vo.integrate(bowl, initial=rest, times=[1, 0], tol=1e-22, method="flint")
    ahead = vo.integrate(bowl, initial=rest, times=[1, 4, 7, 10], tol=1e-22, method="flint")
    start = {name: float(back[name][-1]) for name in ("x", "xdot")}
    times = np.concatenate([np.linspace(0, 1, count + 1), [4, 7, 10]])
    run = vo.ensemble(bowl, [start] * 2, times=times, outputs=("x",), method="heyoka")
    assert not run.errors
    assert np.abs(run["x"][:, -3:] - ahead["x"][1:].astype(float)).max() < 1e-12


@HEYOKA
def test_pieces_of_a_grid_may_end_an_ulp_beside_it():
    """A body at rest goes from piece to piece in one step, whose end is rounded."""
    rest = vo.System(name="rest", fibration=vo.Fibration(x), lagrangian=-(xdot**2) * x**2 / 2)
    found = vo.ensemble(rest, {x: [1.0]}, times=np.linspace(0, 20, 2001), method="heyoka")
    assert found.finished.all()
    assert (found["x"] == 1).all()


def test_motions_gone_over_alone_are_kept_when_stopped_by_hand():
    """With an input that changes in time motions go one by one; the second is stopped."""
    calls: list[float] = []

    def force(t: float) -> float:
        if calls.count(0.0) > 60:
            raise KeyboardInterrupt
        calls.append(0.0 if done else 1.0)
        return 0.0

    done: list[float] = []
    pushed = vo.System(
        name="pushed", fibration=vo.Fibration(x), lagrangian=xdot**2 / 2, forces={x: w}, inputs=(w,)
    )
    found = vo.ensemble(
        pushed, {x: [1.0, 2.0, 3.0]}, times=GRID, inputs={w: force}, progress=done.append
    )
    assert found.interrupted
    assert found.finished.tolist() == [True, False, False]
    assert (found["x"][0] == 1).all() and np.isnan(found["x"][2]).all()


def test_starts_that_nobody_came_to_did_nothing_wrong(monkeypatch):
    """Those at a pole of the angles go alone: stopped by hand before the second, or before the
    first, the others are not told to be undefined there."""
    starts = {"theta": np.zeros(3), "omega1": np.array([0.1, 0.2, 0.3]), "omega3": np.ones(3)}
    alone, stops = one_by_one.integrate, iter([False, True, True])

    def stopped(*arguments, **options):
        if next(stops):
            raise KeyboardInterrupt
        return alone(*arguments, **options)

    monkeypatch.setattr(one_by_one, "integrate", stopped)
    ball = vo.load("chaplygin-ball")
    for done in ([True, False, False], [False, False, False]):
        found = vo.ensemble(ball, starts, times=[0, 1], outputs=("phi",))
        assert found.interrupted and not found.errors and found.finished.tolist() == done


def test_a_motion_that_leads_nowhere_does_not_keep_the_others_waiting(monkeypatch) -> None:
    """A disc that lies flat, beside one that rolls: it took a step of 1e-9 after the other."""
    for module in (run_module, heyoka_stepper):  # alone it is given up sooner, too
        monkeypatch.setattr(module, "WINDOW", 100)
    monkeypatch.setattr(heyoka_stepper, "LONG", 10_000)
    starts = {"theta": [0.2, np.pi / 2], "s": [1, 1]}
    found = vo.ensemble(
        vo.load("falling-disc"), starts=starts, times=[0, 1, 3], outputs=("theta", "x")
    )
    assert set(found.errors) == {1}
    alone = vo.integrate(vo.load("falling-disc"), initial={"theta": 0.2, "s": 1}, times=[0, 1, 3])
    assert found["theta"][0] == pytest.approx(alone["theta"], abs=1e-9)


def test_a_long_way_is_not_refused_for_steps_that_were_not_counted(oscillator, monkeypatch):
    """The steps before the first look seemed to lead twice as far as those after it."""
    monkeypatch.setattr("voronec.motion.batches.LONG", 10_000)
    end = 4e5
    found = vo.ensemble(oscillator, starts={"x": [1.0, 2.0], "xdot": 0.0}, times=[0, end])
    assert not found.errors and found.finished.all()


@pytest.mark.filterwarnings("error")
def test_a_motion_without_a_number_has_no_drift():
    light = vo.System(
        "light", vo.Fibration((x,)), w * xdot**2 / 2 - x**4 / 4, parameters=(w,),
        integrals={"energy": w * xdot**2 / 2 + x**4 / 4},
    )  # fmt: skip
    found = vo.ensemble(light, {x: [0.5], xdot: 0}, {w: 1e-300}, times=[0, 1], method="heyoka")
    assert set(found.errors) == {0} and np.isnan(found.drift["energy"]).all()


def test_starts_that_ask_for_boundless_speeds_are_refused_beside_others() -> None:
    pytest.importorskip("heyoka")
    x, y, phi = sp.symbols("x y phi")
    dx, dy, turn = map(vo.velocity, (x, y, phi))
    blade = vo.System(
        name="blade",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=(dx**2 + dy**2 + turn**2) / 2,
        constraints=(dx * sp.sin(phi) - dy * sp.cos(phi),),
    )
    given = {dx: 1, turn: 0.3}  # along the blade: dy = dx tan(phi)
    starts = [{phi: 0.5, **given}, {phi: np.pi / 2 + 1e-10, **given}]
    found = vo.ensemble(blade, starts=starts, times=[0, 1], method="heyoka")
    assert [*found.errors] == [1] and "almost no frame" in str(found.errors[1])
    aside = (np.cos(0.5) - np.cos(0.8)) / (0.3 * np.cos(0.5))  # at a constant speed on a circle
    assert found["y"][0, -1] == pytest.approx(aside, abs=1e-11) and found.cost.steps < 100


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("many", ["ensemble", "section"])
def test_an_integral_that_is_infinite_at_one_start_hides_no_drift_of_others(many):
    x = sp.Symbol("x")
    v = vo.velocity(x)
    spring = vo.System(
        name="spring", fibration=vo.Fibration((x,)), lagrangian=(v**2 - x**2) / 2,
        integrals={"wrong": 1 / (x - 1) + v**2},
    )  # fmt: skip
    starts = {x: [1.0, 0.5]}  # the second begins at -2, and has more than 0.2 of v^2 on its way
    if many == "ensemble":
        found = vo.ensemble(spring, starts, times=np.linspace(0, 5, 21))
    else:
        found = vo.section(spring, x, starts=starts, crossings=2)
    assert found.drift["wrong"][1] > 0.1 and not found.drift["wrong"][0] < np.inf
