"""Speed against error: problems, references of proved accuracy, peers, comparison."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from tool_modules import tool

import voronec as vo
from voronec.accuracy import bench
from voronec.accuracy import reference as references
from voronec.accuracy.bench import OWN, Contender, Measured, NotHere, Outcome, Point
from voronec.accuracy.bench.work_precision_picture import plot_work_precision
from voronec.accuracy.problem import formulation, lowest
from voronec.accuracy.solution import agreement
from voronec.equations.program import Program, compile_program
from voronec.motion.methods import METHODS

peers = tool("figures.peers")
mujoco_ball = tool("figures.mujoco_ball")
numba_dop853 = tool("figures.numba_dop853")
ALL = (*OWN, *peers.PEERS)

pytestmark = pytest.mark.slow

q, p = sp.symbols("q p")
SPRING = vo.System(
    name="two-springs",
    fibration=vo.Fibration(base=(q, p)),
    lagrangian=(vo.velocity(q) ** 2 + vo.velocity(p) ** 2 - q**2 - 4 * p**2) / 2,
    integrals={"energy": (vo.velocity(q) ** 2 + vo.velocity(p) ** 2 + q**2 + 4 * p**2) / 2},
    scenes={"default": vo.Scene(initial={q: 1, vo.velocity(p): 2}, times=(0, 3))},
)


@pytest.fixture(scope="module")
def spring() -> bench.ReferenceProblem:
    return bench.scene_problem(SPRING, outputs=("q", "p"), instants=13)


@pytest.fixture(scope="module")
def ball() -> bench.ReferenceProblem:
    return bench.scene_problem(vo.load("chaplygin-ball"), time=2.0, instants=11)


def known(problem: bench.ReferenceProblem) -> bench.ReferenceSolution:
    """The closed form of the springs, in place of a reference."""
    t = problem.grid
    return bench.ReferenceSolution(t, {"q": np.cos(t), "p": np.sin(2 * t)}, 1e-16, ("one", "other"))


def contender(name: str) -> Contender:
    return bench.contenders([name], ALL)[0]


def test_every_method_gets_the_same_doubles(ball: bench.ReferenceProblem) -> None:
    assert ball.initial["omega3"] == 0.2 and ball.parameters["I1"] == 0.4
    assert ball.outputs == ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
    low, high = formulation(ball, "invariants"), formulation(ball, "coordinates")
    assert len(low.start) == 6 and len(high.start) == 8
    # the normal is a function of the doubles, known beyond them
    assert abs(low.start[1] ** 2 + low.start[2] ** 2 - 1) < 1e-15
    assert low.start[2] != math.cos(1.0) and float(low.start[2]) == math.cos(1.0)


def test_a_time_replaces_the_length_of_the_scene() -> None:
    problem = bench.scene_problem(SPRING, time=7.0, parameters={}, initial={"q": 3})
    assert problem.span == 7 and problem.initial["q"] == 3 and problem.scene == "default"
    assert problem.outputs == ("q", "p", "qdot", "pdot")


def test_angles_are_coordinates_that_only_turn() -> None:
    problem = bench.scene_problem(vo.load("sleigh"), time=1.0)
    assert problem.angles == {"phi"}
    assert bench.scene_problem(SPRING).angles == frozenset()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"scene": "defualt"}, "no scene 'defualt'; did you mean 'default'"),
        ({"time": 0.0}, "over the time 0 cannot be measured"),
        ({"time": math.inf}, "cannot be measured"),
        ({"outputs": ("qq",)}, "no output 'qq'"),
        ({"instants": 1}, "instants = 1: give 2 or more"),
    ],
)
def test_a_problem_that_makes_no_sense_is_refused(words: dict[str, Any], message: str) -> None:
    with pytest.raises(vo.DefinitionError, match=message):
        bench.scene_problem(SPRING, **words)


def test_reactions_are_not_compared_and_a_configuration_is_its_coordinates() -> None:
    sleigh = vo.load("sleigh")
    with pytest.raises(vo.DefinitionError, match="'reaction 1' takes no part in a comparison"):
        bench.scene_problem(sleigh, outputs=("x", "reaction 1"))
    assert bench.scene_problem(sleigh, outputs=("configuration",)).outputs == ("x", "phi", "y")


def test_a_reference_is_as_good_as_it_says(spring: bench.ReferenceProblem) -> None:
    found = bench.reference(spring)
    exact = known(spring)
    assert found.accuracy < 1e-15 and found.note == "" and len(set(found.how)) == 2
    for name in spring.outputs:
        np.testing.assert_allclose(found.values[name], exact.values[name], rtol=0, atol=4e-16)


def test_two_runs_meet_on_different_equations(ball: bench.ReferenceProblem) -> None:
    pytest.importorskip("heyoka")
    one, other = (
        references.taylor_values(formulation(ball, name), 1e-30)
        for name in ("coordinates", "invariants")
    )
    found = agreement(ball.grid, [("one", one), ("other", other)], 1e-25)
    assert found is not None and len(found.t) == len(ball.grid)


def test_more_digits_are_better_digits(ball: bench.ReferenceProblem) -> None:
    pytest.importorskip("heyoka")
    at = formulation(ball, "invariants")
    rough, fine, finest = (references.taylor_values(at, tol)["omega1"] for tol in (
        1e-17, 1e-25, 1e-50
    ))  # fmt: skip
    apart = [bench.difference(x, finest).max() for x in (rough, fine)]
    assert 0 < apart[1] < 1e-22 < apart[0] < 1e-14


def test_runs_that_part_are_used_up_to_there(spring: bench.ReferenceProblem) -> None:
    exact = dict(known(spring).values)
    wrong = {"q": exact["q"].copy(), "p": exact["p"]}
    wrong["q"][7:] += 1e-6
    found = agreement(spring.grid, [("a", exact), ("b", wrong)], 1e-12)
    assert found is not None and len(found.t) == 7 and found.how == ("a", "b")
    assert "up to t = 1.5 only" in found.note
    wrong["q"][1] = np.nan
    assert agreement(spring.grid, [("a", exact), ("b", wrong)], 1e-12) is None


def test_a_reference_whose_runs_disagree_is_refused() -> None:
    ball = bench.scene_problem(vo.load("ball-on-sphere"), time=1.0, instants=3)
    with pytest.raises(vo.IntegrationError, match="on no part of the grid, so there is no ref"):
        bench.reference(ball, needed=1e-60)


def test_one_run_is_no_reference(
    spring: bench.ReferenceProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(METHODS, "heyoka", replace(METHODS["heyoka"], library="no_such_library"))

    def refuse(*_: Any, **__: Any) -> None:
        raise vo.EngineLimit("not here")

    monkeypatch.setattr(references, "integrate", refuse)
    with pytest.raises(vo.EngineLimit, match="no two independent high-precision runs"):
        bench.reference(spring)


def test_a_fraction_in_the_equations_keeps_its_digits() -> None:
    pytest.importorskip("heyoka")
    third = vo.System(
        name="third",
        fibration=vo.Fibration(base=(q,)),
        lagrangian=vo.velocity(q) ** 2 / 2 - q**2 / 6,
        scenes={"default": vo.Scene(initial={q: 1}, times=(0, 1))},
    )
    problem = bench.scene_problem(third, outputs=("q",), instants=3)
    found = references.taylor_values(formulation(problem, "coordinates"), 1e-30)["q"]
    with mpmath.workdps(40):
        exact = [mpmath.cos(t / mpmath.sqrt(3)) for t in (0, 0.5, 1)]
    assert bench.difference(found, np.array(exact)).max() < 1e-28


def test_a_difference_of_angles_is_taken_modulo_a_turn() -> None:
    exact = np.array([0.0, 100.0])
    turned = np.array([0.1, 100.0 - 2 * np.pi])
    np.testing.assert_allclose(bench.difference(turned, exact, True), [0.1, 0], atol=1e-12)
    np.testing.assert_allclose(bench.difference(turned, exact, False), [1e-3, 0.02 * np.pi])
    assert bench.difference(np.array([1e-3]), np.array([0.0]), False)[0] == 1e-3


RUNS = [(1e-4, 1.0), (1e-6, 2.0), (1e-10, 8.0)]


def test_costs_are_interpolated_in_the_logarithms() -> None:
    assert bench.at_error(RUNS, 1e-8) == bench.At(pytest.approx(4.0), "interpolated")
    assert bench.at_error(RUNS, 1e-6).seconds == pytest.approx(2.0)


def test_nothing_is_extrapolated_silently() -> None:
    assert bench.at_error(RUNS, 1e-2) == bench.At(1.0, "at most")
    assert bench.at_error(RUNS, 1e-12) == bench.At(None, "not reached")
    far = bench.at_error(RUNS, 1e-12, extrapolate=True)
    assert far.kind == "extrapolated" and far.seconds == pytest.approx(16.0)
    assert bench.at_error([], 1e-6, extrapolate=True) == bench.At(None, "not reached")


def test_a_cheaper_run_that_is_better_counts() -> None:
    assert bench.at_error([(1e-5, 3.0), (1e-7, 3.0), (1e-9, 1.0)], 1e-6).seconds == 1.0


def test_the_observed_order_is_that_of_the_finest_runs() -> None:
    assert bench.observed_order([(1e-2, 1.0), (1e-3, 2.0), (2.5e-4, 4.0)]) == pytest.approx(2)
    assert bench.observed_order([(1e-3, 1.0), (1e-3, 2.0)]) is None
    assert bench.observed_order([(1e-5, 1.0), (1e-3, 2.0)]) is None, "worse for more work"


@pytest.mark.parametrize(
    ("name", "package"),
    [("dop853-numba", "numba"), ("mujoco-best", "mujoco"), ("heyoka-by-hand", "heyoka")],
)
def test_a_peer_that_is_not_installed_is_said_to_be(
    ball: bench.ReferenceProblem, monkeypatch: pytest.MonkeyPatch, name: str, package: str
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    found = bench.measure(
        ball, [name], against=bench.ReferenceSolution(ball.grid, {}, 1e-16, ("", "")), among=ALL
    )
    assert found[name].absent == f"not installed: {package}" and found[name].points == ()


@pytest.mark.parametrize("name", ["mujoco-best", "heyoka-by-hand", "dop853-lambdify-invariants"])
def test_a_peer_that_does_not_fit_says_why(spring: bench.ReferenceProblem, name: str) -> None:
    with pytest.raises(NotHere):
        contender(name).prepare(spring)


def test_a_peer_refuses_outputs_that_it_does_not_compute() -> None:
    problem = bench.scene_problem(vo.load("chaplygin-ball"), outputs=("x", "omega1"), time=1.0)
    with pytest.raises(NotHere, match="does not compute x"):
        contender("heyoka-by-hand").prepare(problem)


def test_our_source_of_dop853_is_dop853(spring: bench.ReferenceProblem) -> None:
    def right(_t: float, q: float, p: float, v: float, w: float, _parameters: Any) -> Any:
        return v, w, -q, -4 * p

    namespace: dict[str, Any] = {"np": np, "right": right}
    exec(numba_dop853.advance_source(4), namespace)
    start, errors, counts = np.array([1.0, 0.0, 0.0, 2.0]), [], []
    for tol in (1e-6, 1e-9, 1e-12):
        rows = np.empty((len(spring.grid), 4))
        counts.append(namespace["advance"](spring.grid, start, np.array([]), tol, rows))
        errors.append(np.abs(rows[:, 0] - np.cos(spring.grid)).max())
    assert errors[1] < 1e-9 and errors[2] < 2e-13, errors
    assert counts[0][0] <= counts[1][0] < counts[2][0]
    # backward, to the start again
    rows = np.empty((2, 4))
    end = np.array([np.cos(3), np.sin(6), -np.sin(3), 2 * np.cos(6)])
    namespace["advance"](np.array([3.0, 0.0]), end, np.array([]), 1e-12, rows)
    np.testing.assert_allclose(rows[1], [1, 0, 0, 2], atol=1e-11)


@pytest.mark.parametrize("name", ["dop853-numba-by-hand", "dop853-numba-fastmath"])
def test_dop853_of_numba_is_as_accurate(ball: bench.ReferenceProblem, name: str) -> None:
    pytest.importorskip("heyoka")
    pytest.importorskip("numba")
    found = bench.measure(ball, [name], [1e-11], against=_exact(ball), among=ALL)[name]
    assert found.points[0].error < 1e-9, found


def test_formulations_have_our_right_hand_side(ball: bench.ReferenceProblem) -> None:
    at = lowest(ball)
    ours, _ = compile_program(at.program)
    state = np.array([0.48, 0.6, 0.64, 0.5, 2.1, 0.4])  # |gamma| = 1, where forms may differ
    expected = np.array(ours(0.0, list(state), list(at.constants)))
    for kind in ("program", "sympy"):
        function, constants = peers.reduction(ball, kind=kind).source()
        np.testing.assert_allclose(
            function(0.0, *state, constants), expected, rtol=1e-13, atol=1e-15
        )
    for kind in ("solved", "written out", "plain"):
        right = peers.reduction(ball, kind=kind).right()
        np.testing.assert_allclose(right(0.0, state), expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("name", peers.BY_HAND)
def test_a_program_by_hand_is_the_engines_motion(name: str) -> None:
    hy = pytest.importorskip("heyoka")
    problem = bench.scene_problem(vo.load(name), time=3.0, instants=7)
    hand = peers.BY_HAND[name](problem.parameters)
    named = peers.reduction(problem).values
    integrator = hy.taylor_adaptive(hand.equations, hand.start(named).tolist(), tol=1e-15)
    found = hand.back(integrator.propagate_grid(problem.grid)[-1])
    ours = vo.integrate(
        problem.equations, problem.bare, problem.grid, tuple(found), method="scipy", tol=1e-12
    )
    for key, values in found.items():
        turned = key == "v"  # known up to whole turns
        assert bench.difference(values, ours[key], turned).max() < 1e-9, key


PEERS = (
    "dop853-lambdify-invariants",
    "lsoda-lambdify-coordinates",
    "heyoka-by-hand",
    "dop853-by-hand",
    "scipy",
)


@pytest.mark.parametrize("name", PEERS)
def test_finer_tolerances_are_nearer_to_the_reference(
    ball: bench.ReferenceProblem, name: str
) -> None:
    if "by-hand" in name:
        pytest.importorskip("heyoka")
    exact = _exact(ball)
    found = bench.measure(ball, [name], [1e-5, 1e-10], against=exact, among=ALL)[name]
    assert found.absent == "" and [p.failed for p in found.points] == ["", ""]
    rough, fine = found.points
    assert fine.error < 1e-8 and fine.error < rough.error
    assert fine.drift is not None and max(fine.drift.values()) < 1e-8
    assert set(fine.drift) == set(ball.system.integrals)
    assert fine.evaluations > 0 and fine.per_unit > 0


def test_mujoco_converges_with_its_best_settings_only(ball: bench.ReferenceProblem) -> None:
    pytest.importorskip("mujoco")
    names = ("mujoco-best", "mujoco-default")
    errors = {}
    for name in names:
        run = contender(name).prepare(ball)
        outcomes = [run(step) for step in (2e-2, 5e-3)]
        errors[name] = [
            max(
                bench.difference(o.values[n], _exact(ball).values[n], False).max()
                for n in ball.outputs
            )
            for o in outcomes
        ]
    assert errors["mujoco-best"][1] < 1e-4 < errors["mujoco-default"][1]
    assert errors["mujoco-best"][1] < errors["mujoco-best"][0] / 4, "second order"


def test_the_model_of_mujoco_holds_the_ball(ball: bench.ReferenceProblem) -> None:
    text = mujoco_ball.model_text(mujoco_ball.BEST, 0.5, 2.0, 3.0, (0.4, 0.5, 0.7))
    assert 'diaginertia="0.4 0.5 0.7"' in text and 'mass="2.0"' in text
    assert 'size="3.0"' in text and 'timestep="0.5"' in text and 'solref="0.375 1"' in text


EXACT: dict[str, bench.ReferenceSolution] = {}


def _exact(ball: bench.ReferenceProblem) -> bench.ReferenceSolution:
    if "ball" not in EXACT:
        EXACT["ball"] = bench.reference(ball)
    return EXACT["ball"]


def _made(name: str, run: Any, tolerances: tuple[float, ...] = (1e-2, 1e-4)) -> Contender:
    return Contender(name, "ours: made for a test", tolerances, lambda _problem: run)


def _answer(problem: bench.ReferenceProblem, wrong: float, seconds: float = 0.5) -> Outcome:
    values = {n: x + wrong for n, x in known(problem).values.items()}
    return Outcome(values, seconds, 7, 3, {"energy": wrong})


def test_a_measurement_is_plain_data(spring: bench.ReferenceProblem) -> None:
    among = (_made("good", lambda tol: _answer(spring, tol)),)
    found = bench.measure(spring, among=among, against=known(spring))
    data = json.loads(json.dumps(found.as_dict(), allow_nan=False))
    assert data["system"] == "two-springs" and data["times"] == [0, 3]
    assert data["reference"] == {
        "accuracy": 1e-16, "how": ["one", "other"], "until": 3.0, "note": "",
    }  # fmt: skip
    (method,) = data["methods"]
    assert [p["setting"] for p in method["points"]] == [1e-2, 1e-4]
    point = method["points"][1]
    assert point["error"] == pytest.approx(1e-4, rel=0.1) and set(point["errors"]) == {"q", "p"}
    assert point["seconds_per_unit"] == pytest.approx(0.5 / 3) and point["drift"] == {
        "energy": 1e-4
    }
    assert data["at_equal_error"][0] == {
        "error": 1e-6, "methods": {"good": {"seconds_per_unit": None, "kind": "not reached"}},
    }  # fmt: skip
    assert "numpy" in data["machine"]


def test_an_error_is_never_less_than_the_reference_knows(spring: bench.ReferenceProblem) -> None:
    among = (_made("good", lambda tol: _answer(spring, 0.0)),)
    assert (
        bench.measure(spring, among=among, against=known(spring))["good"].points[0].error == 1e-16
    )


def test_a_run_that_fails_is_kept_with_its_reason(spring: bench.ReferenceProblem) -> None:
    def run(tol: float) -> Outcome:
        if tol > 1e-3:
            raise vo.IntegrationError("it broke")
        return _answer(spring, np.nan)

    among = (_made("bad", run),)
    points = bench.measure(spring, among=among, against=known(spring))["bad"].points
    assert [p.failed for p in points] == ["it broke", "the outputs are not finite"]


def test_what_would_take_too_long_is_left_out_and_named(spring: bench.ReferenceProblem) -> None:
    among = (_made("slow", lambda tol: _answer(spring, tol, seconds=10.0)),)
    found = bench.measure(spring, among=among, against=known(spring), budget=20.0)["slow"]
    assert [p.setting for p in found.points] == [1e-2]
    assert found.note == "tolerance 0.0001 and finer left out: over 20 s a run"


def test_ctrl_c_keeps_what_is_measured(spring: bench.ReferenceProblem) -> None:
    def run(tol: float) -> Outcome:
        if tol < 1e-3:
            raise KeyboardInterrupt
        return _answer(spring, tol)

    among = (
        _made("first", lambda tol: _answer(spring, tol)), _made("second", run), _made("third", run)
    )  # fmt: skip
    found = bench.measure(spring, among=among, against=known(spring))
    assert found.interrupted and [m.name for m in found.methods] == ["first", "second"]
    assert [len(m.points) for m in found.methods] == [2, 1]


def test_only_the_part_that_the_reference_covers_is_measured(
    spring: bench.ReferenceProblem,
) -> None:
    grids = []

    def prepare(problem: bench.ReferenceProblem) -> Any:
        grids.append(problem.grid)
        return lambda tol: _answer(problem, tol)

    among = (Contender("seen", "", (1e-2,), prepare),)
    full = known(spring)
    short = bench.ReferenceSolution(
        full.t[:5], {n: x[:5] for n, x in full.values.items()}, 1e-16, ("", "")
    )
    bench.measure(spring, among=among, against=short)
    assert len(grids[0]) == 5 and grids[0][-1] == 1.0


def test_steps_are_not_taken_for_tolerances(spring: bench.ReferenceProblem) -> None:
    seen: list[float] = []

    def prepare(_problem: bench.ReferenceProblem) -> Any:
        return lambda step: seen.append(step) or _answer(spring, step)

    among = (Contender("stepped", "", (0.5, 0.25), prepare, knob="step"),)
    bench.measure(spring, tolerances=[1e-9], among=among, against=known(spring))
    assert seen == [0.5, 0.25]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"methods": ["heyoke"]}, "no method 'heyoke'; did you mean 'heyoka"),
        ({"tolerances": [0.0]}, "the tolerance 0 must lie between 0 and 1"),
    ],
)
def test_methods_and_tolerances_that_are_none_are_refused(
    spring: bench.ReferenceProblem, words: dict[str, Any], message: str
) -> None:
    with pytest.raises(vo.DefinitionError, match=message):
        bench.measure(spring, against=known(spring), **words)


def test_names_of_methods_are_not_given_twice() -> None:
    assert len({c.name for c in ALL}) == len(ALL)


def test_every_method_of_integrate_is_measured() -> None:
    assert set(METHODS) <= {c.name for c in OWN}


def test_the_plot_holds_every_method_that_ran(spring: bench.ReferenceProblem) -> None:
    points = tuple(Point(e, e, s, 1, 1, {}, {}) for e, s in RUNS)
    ours = Measured("taylor", "ours: it", points=points)
    peer = Measured("other", "theirs", points=points[:2])
    gone = Measured("gone", "", absent="not installed: x")
    found = bench.Bench(spring, known(spring), (ours, peer, gone), {})
    panel = plot_work_precision(found).axes[0]
    lines = {line.get_label(): line for line in panel.lines if not line.get_label().startswith("_")}
    assert set(lines) == {"taylor", "other"}
    assert list(lines["taylor"].get_xdata()) == [1.0, 2.0, 8.0]
    assert lines["taylor"].get_linewidth() > lines["other"].get_linewidth()
    assert panel.get_xscale() == panel.get_yscale() == "log"
    with pytest.raises(vo.DefinitionError, match="no run succeeded"):
        plot_work_precision(bench.Bench(spring, known(spring), (gone,), {}))


def test_set_up_is_measured_in_fresh_processes(tmp_path: Path) -> None:
    assert bench.measure_setup(str(tmp_path / "none.py"), None, ()) is None
    found = bench.measure_setup("sleigh", None, ("x",), method="scipy")
    assert found is not None and found.method == "scipy"
    assert found.warm > 0 and found.cold > 0 and found.load > 0


def test_a_program_has_the_outputs_and_integrals_of_its_level(ball: bench.ReferenceProblem) -> None:
    at = formulation(ball, "invariants")
    assert isinstance(at.program, Program) and at.name == "invariants"
    values, drift = at.outputs_and_drift(np.array([0.0, 1.0]), np.array([at.state, 2 * at.state]))
    assert values["omega2"].tolist() == [2.0, 4.0]
    assert set(drift) == {"energy", "momentum squared", "vertical momentum"}
    assert drift["energy"] > 1
