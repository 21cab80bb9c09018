"""Charts: declared, proved, and gone through near singularities."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from pole_free import VALUES, reference, without_poles

import voronec as vo
from voronec.declaration.claims import without_claims
from voronec.equations.motions import Motions
from voronec.equations.program import Program, compile_program
from voronec.motion.atlas import kept_charts
from voronec.motion.methods import choose
from voronec.motion.request import Event
from voronec.motion.state_probe import quantities
from voronec.motion.steppers import Problem
from voronec.motion.steppers.run import part_at
from voronec.motion.transitions.charts import through_charts
from voronec.proof.relations.charts import check_charts

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def demchenko():
    return vo.derive(vo.load("demchenko"))


def run(equations, start, times, method="scipy", tol=1e-13, charts=True, **more):
    """States on a grid, in the charts of a system or in its own only."""
    program, functions = Program.of(equations.form), more.pop("functions", {})
    values = [VALUES[str(p)] for p in program.parameters]
    problem = Problem(program, np.array(start, dtype=float), values, tol, **more)
    grid = np.array(times, dtype=float)
    if charts:
        return through_charts(method, problem, grid, equations, functions)[0](grid)
    return choose(method, problem, grid)[0](grid)


NEAR_POLE = [1e-6, 0.4, 1.0, 1.2, 0.3, 0.7, 0.2, 0.3]
"""The contact almost at the pole of the ball."""
ON_BOTH_POLES = [0.0, 0.4, 1.0, 0.0, 0.3, 0.7, 0.2, 0.3]


def verdicts(system):
    return {claim.name: claim.verdict for claim in check_charts(Motions.of(system))}


def test_the_charts_of_a_ball_on_a_sphere_are_proved():
    found = verdicts(vo.load("demchenko"))
    assert len(found) == 3
    assert all(verdict.proved for verdict in found.values()), found


def test_the_chart_of_a_ball_on_a_plane_turns_the_ball_alone():
    system = vo.load("zhukovsky-ball")
    assert [*system.charts] == ["pole of the ball turned"]
    assert verdicts(system)["pole of the ball turned"].proved


def changed(system, name, **changes):
    chart = replace(system.charts[name], **changes)
    return replace(system, charts={name: chart})


def test_a_chart_that_is_no_motion_is_refuted():
    system = vo.load("demchenko")
    wrong = changed(system, "pole of the ball turned", changes={})  # the rotor is left where it was
    verdict = verdicts(wrong)["pole of the ball turned"]
    assert verdict.refuted
    assert verdict.witness is not None


def test_a_chart_whose_way_back_leads_elsewhere_is_refuted():
    system = vo.load("demchenko")
    name = "pole of the sphere turned"
    theta = sp.Symbol("theta")
    back = {**system.charts[name].state, "theta": system.charts[name].state["theta"] + 1}
    verdict = verdicts(changed(system, name, back=back))[name]
    assert verdict.refuted
    assert verdict.method.startswith("there and back")
    assert theta in back["theta"].free_symbols


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"state": {"w": sp.Symbol("u")}}, "maps 'w', which is no coordinate"),
        ({"state": {"u": sp.Symbol("w")}}, "contains 'w', which is neither"),
        ({"singular": sp.Symbol("w")}, "contains 'w', which is neither"),
    ],
)
def test_a_chart_names_what_it_does_not_know(changes, message):
    system = vo.load("demchenko")
    with pytest.raises(vo.DefinitionError, match=message):
        changed(system, "pole of the sphere turned", **changes)


def test_a_chart_may_not_change_the_fibration():
    with pytest.raises(vo.DefinitionError, match="a chart changes 'fibration'; it may change lag"):
        vo.Chart({"u": sp.Symbol("u")}, sp.Symbol("u"), {"fibration": None})


def test_there_and_back_is_the_identity(demchenko):
    charts = kept_charts(demchenko, demchenko.form)
    rng = np.random.default_rng(5)
    size = 200
    rows = rng.uniform(0.1, 3.0, (size, 8))  # u and u1 between 0 and pi
    for chart in charts:
        forward, back = (
            compile_program(quantities(demchenko.form, {str(x): e for x, e in values.items()}))[1]
            for values in (chart.there, chart.back)
        )
        constants = [VALUES[str(p)] for p in demchenko.form.parameters]
        there = forward(np.zeros(size), list(rows.T), constants)
        again = np.array(back(np.zeros(size), there, constants)).T
        off = again - rows
        off[:, :5] -= 2 * np.pi * np.rint(off[:, :5] / (2 * np.pi))
        # theta is a sum of angles of several turns, and near a pole angles are known less well
        scale = 1 / np.minimum(np.abs(np.sin(rows[:, 0])), np.abs(np.sin(rows[:, 3])))
        assert np.abs(off / scale[:, None]).max() < 4e-14, chart.name
        there, again = np.array(there).T, again
        same = [
            np.abs(without_poles(a) - without_poles(b)).max()
            for a, b in zip(rows, again, strict=True)
        ]
        assert max(same) < 4e-15


def test_a_run_through_the_pole_agrees_with_the_equations_that_have_none(demchenko):
    start = run(demchenko, NEAR_POLE, [0, -1.5]).states[-1]
    found = run(demchenko, start, [-1.5, 1.5])
    assert found.switches == 2
    assert np.abs(without_poles(found.states[-1]) - reference(start, 3)).max() < 1e-12


def test_a_run_in_charts_takes_a_fraction_of_the_evaluations(demchenko):
    start = run(demchenko, NEAR_POLE, [0, -1.5]).states[-1]
    found, plain = (run(demchenko, start, [-1.5, 1.5], charts=c) for c in (True, False))
    assert 3 * found.evaluations < plain.evaluations


def test_a_run_may_start_on_both_poles(demchenko):
    found = run(demchenko, ON_BOTH_POLES, [0, 2])
    assert found.switches == 1
    assert np.abs(without_poles(found.states[-1]) - reference(ON_BOTH_POLES, 2)).max() < 1e-12


def test_a_run_from_a_pole_of_the_ball_stays_on_its_side_of_the_sphere(demchenko):
    """u1 and v1 are regular there, and go on as they began: not with -u1 and v1 + pi."""
    start = [0.0, 0.4, 1.0, -0.5, *NEAR_POLE[4:]]
    found = run(demchenko, start, np.linspace(0, 0.4, 5))
    assert found.switches == 1 and (found.states[:, 0] >= 0).all()
    assert np.abs(np.diff(found.states[:, 3:5], axis=0)).max() < 0.2
    assert np.abs(without_poles(found.states[-1]) - reference(start, 0.4)).max() < 1e-12


def test_angles_come_back_on_their_branch(demchenko):
    start = run(demchenko, [1e-3, *NEAR_POLE[1:]], [0, -3]).states[-1]
    grid = np.linspace(-3, 3, 601)
    found, plain = (run(demchenko, start, grid, charts=c) for c in (True, False))
    assert found.switches == 2
    assert np.abs(found.states - plain.states).max() < 1e-9


def test_a_run_backwards_retraces_the_way(demchenko):
    there = run(demchenko, NEAR_POLE, [0, 1.0, 2.0])
    back = run(demchenko, there.states[-1], [2.0, 1.0, 0.0])
    assert back.switches == 1
    assert np.abs(without_poles(back.states[1]) - without_poles(there.states[1])).max() < 1e-12
    assert np.abs(without_poles(back.states[2]) - without_poles(np.array(NEAR_POLE))).max() < 1e-11


def test_events_happen_in_every_chart(demchenko):
    start = run(demchenko, [1e-3, *NEAR_POLE[1:]], [0, -1]).states[-1]
    u = demchenko.bridge.inward(sp.Symbol("u"))
    dot = demchenko.bridge.inward(vo.velocity(sp.Symbol("u")))
    functions = {"lowest": dot, "close": u - sp.Rational(1, 200)}
    events = (Event("lowest", "lowest", 1), Event("close", "close", -1))
    more = {"events": events, "levels": quantities(demchenko.form, functions)}
    seen = run(demchenko, start, [-1, 1], functions=functions, **more)
    plain = run(demchenko, start, [-1, 1], charts=False, **more)
    assert seen.switches == 2
    for name in functions:
        (t, states), (expected, where) = seen.crossings[name], plain.crossings[name]
        assert len(t) == len(expected) == 1
        assert abs(t[0] - expected[0]) < 1e-9
        assert np.abs(without_poles(states[0]) - without_poles(where[0])).max() < 1e-9


def test_an_event_in_another_chart_stops_the_run(demchenko):
    start = run(demchenko, [1e-3, *NEAR_POLE[1:]], [0, -1]).states[-1]
    functions = {"close": demchenko.bridge.inward(sp.Symbol("u")) - sp.Rational(1, 200)}
    more = {
        "events": (Event("close", "close", -1, True),),
        "levels": quantities(demchenko.form, functions),
        "functions": functions,
    }
    stopped = run(demchenko, start, [-1, 0, 1], **more)
    assert stopped.stopped == "close"
    assert len(stopped.t) == 2
    assert stopped.states[-1, 0] == pytest.approx(1 / 200, abs=1e-12)


def test_dense_runs_are_known_everywhere(demchenko):
    start = run(demchenko, [1e-3, *NEAR_POLE[1:]], [0, -2]).states[-1]
    times = np.linspace(-1.9, 1.9, 97)
    dense = run(demchenko, start, [-2, 2], dense=True)
    plain = run(demchenko, start, [-2, *times, 2], charts=False)
    assert dense.switches == 2
    assert np.abs(dense.inside(times) - plain.states[1:-1]).max() < 1e-9


def test_heyoka_goes_through_the_charts_to_the_last_digits(demchenko):
    pytest.importorskip("heyoka")
    start = run(demchenko, NEAR_POLE, [0, -1.5]).states[-1]
    found = run(demchenko, start, [-1.5, 0.5, 1.5], "heyoka", 1e-16)
    assert found.switches == 2
    assert np.abs(without_poles(found.states[-1]) - reference(start, 3)).max() < 1e-14


def test_what_leaves_out_the_sphere_keeps_the_chart_of_the_ball(demchenko):
    form = demchenko.form
    kept = [i for i, q in enumerate(form.coordinates) if str(q) in ("u", "v")]
    smaller = replace(
        form,
        coordinates=tuple(form.coordinates[i] for i in kept),
        rates=tuple(form.rates[i] for i in kept),
        velocity_symbols=tuple(form.velocity_symbols[i] for i in kept),
    )
    charts = kept_charts(demchenko, smaller)
    assert [c.name for c in charts] == ["pole of the ball turned"]
    values = [VALUES[str(p)] for p in form.parameters]
    start = np.array([1e-6, 0.4, 0.7, 0.2, 0.3])
    problem = Problem(Program.of(smaller), start, values, 1e-13)
    grid = np.array([0.0, 1.0])
    found = through_charts("scipy", problem, grid, demchenko, {}, smaller)[0](grid)
    whole = run(demchenko, NEAR_POLE, grid)
    assert found.switches == 1
    assert np.abs(found.states[-1] - whole.states[-1][[0, 1, 5, 6, 7]]).max() < 1e-9


@pytest.mark.parametrize("chosen", [(0,), (1,), (0, 1)])
def test_a_run_comes_home_on_the_side_on_which_it_was(demchenko, chosen):
    """Colatitudes below zero are as good as others: (u, v, theta) is (-u, v + pi, theta + pi)."""
    system = demchenko.system
    sheets = system.charts["both poles turned"].sheet_values(system)
    names = [*system.coordinates, *system.velocities]
    plain = dict(zip(names, [0.02, 0.4, 0.03, *NEAR_POLE[3:]], strict=True))
    other = plain
    for i in chosen:
        other = {x: float(e.subs(other)) for x, e in sheets[i].items()}
    runs = [run(demchenko, [*map(s.get, names)], [0, 0.7, 1.5]) for s in (plain, other)]
    assert runs[1].switches
    for i, u in enumerate(("u", "u1")):
        column, sign = names.index(sp.Symbol(u)), -1 if i in chosen else 1
        assert np.abs(runs[1].states[:, column] - sign * runs[0].states[:, column]).max() < 1e-10


def test_a_twin_that_is_another_state_is_refuted():
    system = vo.load("zhukovsky-ball")
    name = "pole of the ball turned"
    (sheet,) = system.charts[name].double_cover
    wrong = changed(system, name, double_cover=({**sheet, "theta": sp.Symbol("theta")},))
    assert verdicts(wrong)[name].refuted


@pytest.mark.parametrize("double_cover", [0.5, 10**400, lambda: 1, "x", [3], None])
def test_sheets_that_are_no_maps_are_refused_in_one_line(double_cover):
    x = sp.Symbol("x")
    with pytest.raises(vo.DefinitionError, match=r"double_cover|sheet") as got:
        vo.Chart(state={x: -x}, singular=x, double_cover=double_cover)
    assert str(got.value).isprintable()


@pytest.mark.parametrize("order", [1, -1], ids=["future", "past"])
def test_a_part_of_a_run_holds_the_instant_at_which_it_ends(order):
    times = order * np.array([0.0, 0.5, 0.6, 2.0, 2.5, 9.0])
    assert [*part_at([order * 0.5, order * 2.0, order * 4.0], order, times)] == [0, 0, 1, 1, 2, 2]


@pytest.mark.parametrize(("colatitude", "u1"), [(np.pi, 0.8), (0, 0)])
def test_a_body_with_an_open_surface_starts_at_a_pole_of_the_sphere_or_its_own(colatitude, u1):
    body, ball = vo.load("symmetric-body-on-sphere"), vo.load("displaced-ball-on-sphere")
    assert verdicts(body)["pole of the sphere turned"].proved
    u = body.coordinates[0]
    shape = {
        sp.Function("P")(u): 1 - sp.cos(u) / 5,
        sp.Function("V")(u): -sp.Rational(3, 5) * sp.cos(u),
    }

    def known(expr):
        return sp.sympify(expr).subs(shape).doit()

    own = replace(
        body, **without_claims(), invariants={}, lagrangian=known(body.lagrangian),
        constraints=tuple(map(known, body.constraints)),
    )  # fmt: skip
    sizes, paces = {"A": "2/5", "C": "1/2"}, {"s": 0.4, "tau": -0.7, "n": 0.9}
    place = {"u": colatitude, "v": 0, "theta": 0.3, "u1": u1, "v1": 0.2}
    c, s = np.cos(colatitude), np.sin(colatitude)
    omega = [[c, 0, s], [0, 1, 0], [-s, 0, c]] @ np.array([*paces.values()])
    turning = dict(zip(("omega1", "omega2", "omega3"), omega, strict=True))
    asked = {"parameters": sizes, "times": [0.0, 2.0], "tol": 1e-13}
    motion = vo.integrate(own, initial=place | paces, **asked)
    other = vo.integrate(ball, initial=place | turning, **asked)
    for name in ("u", "v", "u1", "v1"):
        off = motion[name][-1] - other[name][-1]
        assert np.abs(np.exp(1j * off) - 1) < 1e-10, name


def test_a_chart_is_proved_for_every_function_of_what_it_turns():
    u, v = sp.symbols("u v")
    up, across = sp.cos(u), sp.sin(u) * sp.cos(v)
    potential = sp.Function("V")
    kinetic = (vo.velocity(u) ** 2 + (sp.sin(u) * vo.velocity(v)) ** 2) / 2
    reach = sp.sqrt((sp.sin(u) * sp.sin(v)) ** 2 + up**2)
    state = {u: sp.atan2(reach, across), v: sp.atan2(-sp.sin(u) * sp.sin(v), up)}

    def turned(height):
        chart = vo.Chart(state, sp.sin(u), {"lagrangian": kinetic - potential(height)})
        return vo.System(
            name="point on a sphere", fibration=vo.Fibration((u, v), ()),
            lagrangian=kinetic - potential(up), charts={"turned": chart},
        )  # fmt: skip

    assert verdicts(turned(across))["turned"].proved
    assert not verdicts(turned(across**3))["turned"].proved


def test_the_velocity_of_a_size_is_that_of_a_real_number():
    x, y = sp.symbols("x y")
    xdot, ydot = map(vo.velocity, (x, y))
    length = sp.Abs(2 + sp.cos(x))
    chart = vo.Chart(
        {y: y + length}, x, back={y: y - length},
        changes={"lagrangian": (xdot**2 + (ydot + sp.sin(x) * xdot) ** 2) / 2},
    )  # fmt: skip
    particle = vo.System(
        name="particle", fibration=vo.Fibration((x, y)), lagrangian=(xdot**2 + ydot**2) / 2,
        charts={"bent": chart},
    )  # fmt: skip
    assert not chart.values(particle)[ydot].has(sp.re, sp.im)
    assert verdicts(particle)["bent"].proved
