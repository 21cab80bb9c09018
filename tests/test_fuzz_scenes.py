"""The fuzzer's own referee against closed forms, and that it tells right from wrong."""

from __future__ import annotations

import shutil
from dataclasses import replace
from math import cos, exp, pi, sin

import pytest
import sympy as sp
from tool_modules import tool

import voronec as vo

x, phi, y = sp.symbols("x phi y")
xdot = vo.velocity(x)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="the referee is compiled"),
]


def motion(system, q, v, times, tolerance=3e-17, precision="long double"):
    reference = tool("scenes.reference")
    referee = reference.Referee(reference.mechanics_of(system))
    start = referee.start(q, v, [], times[0])
    found = referee.motion(start, [], times[0], times, tolerance, precision)
    assert found.outcome == "done"
    return found


def particle(force, potential=0):
    return vo.System("p", vo.Fibration(x), xdot**2 / 2 - potential, forces={x: force})


def test_friction_brings_a_particle_to_rest_and_holds_it():
    found = motion(particle(-sp.sign(xdot)), [0], [1], [0.0, 0.5, 1.0, 3.0])
    places = [float(row[0]) for row in found.states]
    assert places == pytest.approx([0, 0.375, 0.5, 0.5], abs=1e-15)
    assert found.slides == 1


def test_what_is_held_is_let_go_where_the_drive_beats_the_friction():
    force = 2 * sp.sin(vo.time) - sp.sign(xdot)
    row = motion(particle(force), [0], [0], [0.0, 2.0]).states[-1]
    free = pi / 6  # 2 sin t = 1
    assert float(row[1]) == pytest.approx(2 * (cos(free) - cos(2)) - (2 - free), abs=1e-15)


def test_quadratic_drag_and_a_spring_of_two_stiffnesses():
    drag = motion(particle(-sp.Abs(xdot) * xdot), [0], [-1], [0.0, 5.0]).states[-1]
    assert float(drag[1]) == pytest.approx(-1 / 6, abs=1e-16)
    spring = sp.Piecewise((-x, x > 0), (-4 * x, True))
    row = motion(particle(spring), [0], [1], [0.0, pi + pi / 4]).states[-1]
    assert float(row[0]) == pytest.approx(-0.5, abs=1e-15)


def test_a_sleigh_runs_round_in_both_precisions():
    sleigh = vo.load("sleigh")
    system = replace(
        sleigh,
        lagrangian=sleigh.lagrangian.subs({"m": 1, "J": 1, "a": 0}),
        parameters=(), integrals={}, equations={}, measure=None, integrable="", essential=(),
        cases={}, scenes={}, shapes=(), bodies=(),
    )  # fmt: skip
    for precision, tolerance, off in (("long double", 3e-17, 1e-14), ("quad", 1e-24, 1e-15)):
        row = motion(system, [0, 0, 0], [1, 2], [0.0, 7.0], tolerance, precision).states[-1]
        assert float(row[0]) == pytest.approx(sin(14) / 2, abs=off)
        assert float(row[1]) == 14
        assert float(row[2]) == pytest.approx((1 - cos(14)) / 2, abs=off)


def test_a_driven_particle_forgets_its_start_backwards_too():
    found = motion(particle(-xdot), [0], [1], [0.0, -2.0]).states[-1]
    assert float(found[1]) == pytest.approx(exp(2), abs=1e-15)


def test_an_answer_that_is_off_is_wrong_and_a_right_one_is_right(monkeypatch):
    scene = tool("scenes.scene")
    announced = []
    judged = scene.Workshop(1, "sleigh").judge("smooth", 1, lambda *about: announced.append(about))
    assert judged[:2] == ("sleigh", "right") and announced == [(judged[0], judged[3])]
    asked, said = scene.answer_of, []

    def off(*about):
        columns, notes = asked(*about)
        return {n: column + 1e-6 for n, column in columns.items()}, (*notes, *said)

    monkeypatch.setattr(scene, "answer_of", off)
    assert scene.Workshop(1, "sleigh").judge("smooth", 1, print)[1] == "wrong"
    said.append("lsoda took 65563 steps, whose errors add up, to 7e-09")
    assert scene.Workshop(1, "sleigh").judge("smooth", 1, print)[1] == "wrong, and said so"


def test_starts_at_singular_places_are_swept_and_judged(monkeypatch):
    sweep = tool("scenes.starts")
    bench = sweep.Bench.of("ball-on-turntable", 1)
    place = next(q for where, q in bench.places() if where == "theta = 0: coordinates")
    assert place[1] == 0
    starts = list(bench.starts(place))
    assert bench.judge(starts[0])[0] == "right"
    answer = bench.answer(starts[0])
    monkeypatch.setattr(sweep.Bench, "answer", lambda *_: {**answer, "n": answer["n"] + 1e-3})
    assert bench.judge(starts[0])[0] == "wrong"


def test_at_a_pole_a_sum_of_angles_is_defined_and_is_compared(monkeypatch):
    """Of phi alone nothing can be said there; where the attitude is another one, that is told."""
    sweep, poles = tool("scenes.starts"), tool("scenes.pole_values")
    bench = sweep.Bench.of("ball-on-turntable", 1)
    place = next(q for where, q in bench.places() if where == "theta = 0: coordinates")
    functions = {"sine of phi": sp.sin(bench.referee.mechanics.q[bench.names.index("phi")])}
    known = poles.find_values(bench.referee, functions, place, bench.values)
    assert "+1 phi +1 psi" in {*known} or "+1 psi +1 phi" in {*known}
    assert not {"+1 phi", "+1 psi", "sine of phi"} & {*known}
    start = next(bench.starts(place))
    assert bench.judge(start)[0] == "right"
    answer = bench.answer(start)
    turned = {**answer, "phi": answer["phi"] + 1e-3}
    monkeypatch.setattr(sweep.Bench, "answer", lambda *_: turned)
    outcome, detail = bench.judge(start)
    assert outcome == "wrong" and "phi" in detail


def test_what_is_followed_back_to_a_pole_is_known_in_many_digits():
    """Instants farther off gave 1e-5 with an estimate below it, and a right answer was wrong."""
    sweep = tool("scenes.starts")
    bench = sweep.Bench.of("ball-on-turntable", 1)
    place = next(q for where, q in bench.places() if where == "theta = 0: coordinates")
    start = next(bench.starts(place))
    off = bench.backward(start, bench.answer(start))
    assert max(gap for gap, _ in off.values()) < 1e-9
    assert max(allowed for _, allowed in off.values()) < 1e-5


@pytest.mark.parametrize(
    ("name", "where", "outcomes"),
    [
        ("ball-on-turntable", "theta = 0", ["", ""]),
        # of the velocities of a snakeboard none tells how fast it goes where its axles are in line
        ("snakeboard", "phi = 0", ["undetermined", ""]),
        ("falling-disc", "theta = 1.57", ["undefined", "undefined"]),
    ],
)
def test_the_referee_tells_whether_a_start_begins_a_motion(name, where, outcomes):
    bench = tool("scenes.starts").Bench.of(name, 1)
    place = next(q for why, q in bench.places() if why.startswith(f"{where}:"))
    assert [bench.defect(start)[0] for start in bench.starts(place)] == outcomes


def test_functions_that_a_system_leaves_open_have_an_example():
    made = tool("scenes.open_functions")
    P = sp.Function("P")(x)
    system = vo.System("p", vo.Fibration((x, y)), (xdot**2 + P.diff(x) ** 2) / 2 - P)
    found = made.fill_functions(system)
    assert not found.lagrangian.atoms(sp.core.function.AppliedUndef)
    assert sp.simplify(found.lagrangian.diff(x).subs(xdot, 0)) != 0
    assert made.fill_functions(found) is found


def test_a_method_whose_estimate_is_sharp_errs_by_its_tolerance():
    """On x' = x, whose relative condition is 1, a hundred units are less than DOP853 promises."""
    from scipy.integrate import solve_ivp

    scene = tool("scenes.scene")
    found = solve_ivp(lambda _, y: y, (0, 10), [1.0], method="DOP853", rtol=1e-13, atol=1e-13)
    off = abs(found.y[0, -1] / exp(10) - 1)
    assert 100 * scene.UNIT < off < 100 * scene.UNIT * scene.SHARP["scipy"]


def test_the_start_of_the_referee_takes_all_velocities_of_coordinates():
    """Also where declared velocities are singular: here the declared one is x times the rate."""
    system = vo.System(
        "p", vo.Fibration(x, y), (xdot**2 + vo.velocity(y) ** 2) / 2,
        constraints=(vo.velocity(y) - 2 * xdot,), frame=vo.Frame.quasi({phi: x * xdot}),
    )  # fmt: skip
    reference = tool("scenes.reference")
    referee = reference.Referee(reference.mechanics_of(system))
    state = referee.start_of_rates([0, 1], [1, 2 + 1e-12], [], 0.0)
    assert [float(s) for s in state[:2]] == [0, 1]
    assert float(state[3] - 2 * state[2]) == pytest.approx(0, abs=1e-15)
    assert float(state[2]) == pytest.approx(1, abs=1e-12)
