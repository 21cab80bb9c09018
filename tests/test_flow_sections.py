"""Poincare sections: exact crossings of known motions, by both integrators."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec.motion.sections import starts_alike, suggest_surface

pytestmark = pytest.mark.slow

x, y, w = sp.symbols("x y w")
xdot, ydot = vo.velocity(x), vo.velocity(y)

INSTALLED = importlib.util.find_spec("heyoka") is not None
METHODS = [
    pytest.param("heyoka", marks=pytest.mark.skipif(not INSTALLED, reason="no heyoka")),
    "scipy",
]


@pytest.fixture(scope="module")
def oscillator() -> vo.VoronecEquations:
    """x = a cos(w t) + ..., with no constraint."""
    return vo.derive(
        vo.System(
            name="oscillator",
            fibration=vo.Fibration(base=(x,), fibre=()),
            lagrangian=(xdot**2 - w**2 * x**2) / 2,
            constraints=(),
            parameters=(vo.Parameter(w, 2),),
            integrals={"energy": (xdot**2 + w**2 * x**2) / 2},
            scenes={"default": vo.Scene(initial={x: 1}, times=(0.0, 10.0))},
        )
    )


@pytest.fixture(scope="module")
def falling() -> vo.VoronecEquations:
    """x oscillates; y falls to the centre, from rest at y0 in the time pi (y0/2)^(3/2)."""
    return vo.derive(
        vo.System(
            name="falling",
            fibration=vo.Fibration(base=(x, y), fibre=()),
            lagrangian=(xdot**2 - x**2 + ydot**2) / 2 + 1 / y,
            constraints=(),
            parameters=(),
            integrals={},
        )
    )


@pytest.mark.parametrize("method", METHODS)
def test_crossings_of_an_oscillator_are_exact(oscillator, method):
    found = vo.section(
        oscillator, "x", ("x", "xdot"), initial={"x": 1}, scene="default", crossings=12,
        method=method,
    )  # fmt: skip
    exact = (1.5 * np.pi + 2 * np.pi * np.arange(12)) / 2
    assert np.abs(found.t - exact).max() < 2e-12
    assert np.abs(found["x"]).max() < 1e-14
    assert np.abs(found["xdot"] - 2.0).max() < 1e-11
    assert np.abs(found.speed - 2.0).max() < 1e-6
    assert found.ends == ("complete",)
    assert not found.near_tangent.any()
    assert found.drift["energy"].max() < 1e-11


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("direction", "phases"), [(1, [5]), (-1, [1]), (0, [1, 5])])
def test_the_direction_picks_rising_or_falling_crossings(oscillator, method, direction, phases):
    found = vo.section(
        oscillator, x, ("xdot",), scene="default", crossings=6, direction=direction, value=0.5,
        method=method,
    )  # fmt: skip
    turns = 2 * np.pi * np.arange(6)
    exact = np.sort(np.concatenate([p * np.pi / 3 + turns for p in phases]))[:6] / 2
    assert np.abs(found.t - exact).max() < 2e-12


@pytest.mark.parametrize("method", METHODS)
def test_a_start_on_the_surface_is_no_crossing(oscillator, method):
    found = vo.section(
        oscillator, "x", ("xdot",), starts=[{"x": 0.3, "xdot": 1}], crossings=3, method=method,
        value=np.nextafter(0.3, 1),
    )  # fmt: skip
    assert found.t == pytest.approx(np.pi * np.arange(1, 4), abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_two_crossings_between_samples_are_both_found_and_called_near_tangent(oscillator, method):
    found = vo.section(
        oscillator, "x", ("xdot",), starts={"x": [0.0], "xdot": [2.0]}, value=1 - 1e-9,
        direction=0, crossings=6, method=method,
    )  # fmt: skip
    apart = np.arccos(1 - 1e-9)
    exact = np.array([np.pi / 2 + 2 * np.pi * k + s * apart for k in range(3) for s in (-1, 1)]) / 2
    assert np.abs(found.t - exact).max() < 1e-7
    assert found.near_tangent.all()


@pytest.mark.parametrize("method", METHODS)
def test_two_crossings_next_to_the_end_of_a_step_are_both_found(oscillator, method):
    ahead = np.linspace(0, 1.2, 40)
    starts = {"x": np.sin(ahead), "xdot": 2 * np.cos(ahead)}
    found = vo.section(
        oscillator, "x", ("xdot",), starts=starts, value=1 - 1e-9, direction=0, crossings=4,
        method=method,
    )  # fmt: skip
    apart = np.arccos(1 - 1e-9)
    turns = np.array([np.pi / 2 + 2 * np.pi * k + s * apart for k in range(2) for s in (-1, 1)])
    for i, start in enumerate(ahead):
        assert found.t[found.start == i] == pytest.approx((turns - start) / 2, abs=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_a_touch_is_told_apart_from_a_crossing(oscillator, method):
    starts = {"x": [0.0, 0.0], "xdot": [2.0, 2.5]}
    found = vo.section(
        oscillator, "x", ("xdot",), starts=starts, value=1, crossings=3, until=10.0, method=method
    )
    assert set(found.start.tolist()) == {1}
    assert {i for i, _ in found.touches} == {0}
    exact = np.pi / 4 + np.pi * np.arange(3)
    assert sorted(t for _, t in found.touches)[:3] == pytest.approx(exact, abs=1e-4)
    assert found.ends[0].startswith("no more crossings up to t = 1")


def test_a_surface_given_by_an_expression_holds_to_rounding(falling):
    expr = x**2 - xdot + sp.cos(y)
    starts = [{"x": 1, "y": 90, "xdot": 0.25 * k} for k in range(7)]
    found = vo.section(falling, expr, ("x", "xdot", "y"), starts=starts, crossings=9, direction=-1)
    residual = found["x"] ** 2 - found["xdot"] + np.cos(found["y"])
    assert len(found) == 63
    assert np.abs(residual).max() < 1e-13
    assert (found.speed < 0).all()


def test_every_start_of_many_is_followed_as_if_alone(oscillator):
    speeds = np.linspace(1.0, 3.0, 11)
    together = vo.section(
        oscillator, "x", ("xdot",), starts={"xdot": speeds}, crossings=4, value=0.25
    )
    assert together.start.tolist() == np.repeat(np.arange(11), 4).tolist()
    for i in (0, 6, 10):
        alone = vo.section(
            oscillator, "x", ("xdot",), starts={"xdot": speeds[i : i + 1]}, crossings=4, value=0.25
        )
        assert together.t[together.start == i] == pytest.approx(alone.t, abs=1e-12)
    first = np.arcsin(0.5 / speeds) / 2
    assert together.t[::4] == pytest.approx(first, abs=1e-13)


def test_parameters_may_differ_from_start_to_start(oscillator):
    found = vo.section(
        oscillator, "x", ("xdot",), scene="default", parameters={"w": [1.0, 2.0, 5.0]}, crossings=1
    )
    assert found.t == pytest.approx(1.5 * np.pi / np.array([1.0, 2.0, 5.0]), abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_a_motion_that_breaks_down_does_not_stop_the_others(falling, method):
    starts = [{"x": 1, "y": 80}, {"x": 1, "y": 1}, {"x": 1, "y": 90}]
    found = vo.section(falling, "x", ("xdot", "y"), starts=starts, crossings=3, method=method)
    assert list(found.ends) == ["complete", "failed", "complete"]
    assert isinstance(found.errors[1], vo.IntegrationError)
    assert found.errors[1].time < np.pi * 0.5**1.5 + 1e-6
    assert "start 1" in str(found.errors[1])
    assert found.start.tolist() == [0, 0, 0, 2, 2, 2]


@pytest.mark.parametrize("method", METHODS)
def test_a_run_stopped_by_hand_keeps_its_points(oscillator, method):
    calls = []

    def stop(fraction: float) -> None:
        calls.append(fraction)
        raise KeyboardInterrupt

    found = vo.section(
        oscillator, "x", ("xdot",), starts={"xdot": [1.0, 2.0]}, method=method,
        crossings=100_000 if method == "heyoka" else 3, progress=stop,
    )  # fmt: skip
    assert found.interrupted
    assert len(calls) == 1
    assert len(found) >= 3
    assert "stopped by hand" in found.ends
    assert found.t[:3] == pytest.approx(np.pi * np.arange(1, 4), abs=1e-11)


def test_bad_input_is_refused_in_one_line(oscillator):
    cases = [
        ({"plane": "xdo"}, "did you mean 'xdot'"),
        ({"plane": sp.Symbol("z") - 1}, "contains 'z'"),
        ({"plane": "x", "value": 3}, "stays between -1 and 1"),
        ({"plane": "w"}, "constant along every motion"),
        ({"plane": "x", "outputs": ("vx",)}, "no output 'vx'"),
        ({"plane": "x", "crossings": 0}, "at least 1"),
        ({"plane": "x", "method": "euler"}, "no method 'euler'"),
        ({"plane": "x", "scene": "defalt"}, "did you mean 'default'"),
    ]
    for given, words in cases:
        with pytest.raises(vo.DefinitionError) as refused:
            vo.section(oscillator, **({"scene": "default"} | given))
        assert words in str(refused.value)
        assert "\n" not in str(refused.value)


def test_starts_on_a_level_share_all_integrals_and_differ():
    equations = vo.derive(vo.load("ball-on-sphere"))
    scene = equations.system.scenes["default"]
    starts = starts_alike(equations, scene, {}, {}, 6)
    still = vo.ensemble(equations, starts, times=[0.0], outputs=("energy", "momentum squared"))
    for name in still.outputs:
        assert np.ptp(still[name]) < 1e-10
    assert len({round(s["omega1"], 6) for s in starts}) == 6


def test_without_integrals_no_level_is_known(falling):
    with pytest.raises(vo.DefinitionError, match="declares no integral"):
        vo.section(falling, "x", scene=vo.Scene(initial={x: 1, y: 50}), starts=4)


def test_a_surface_is_suggested_where_something_oscillates(oscillator):
    surface = suggest_surface(oscillator)
    assert (surface.plane, surface.value, surface.outputs) == ("x", 0.0, ("xdot",))
    resting = vo.Scene(initial={}, times=(0.0, 10.0))
    with pytest.raises(vo.DefinitionError, match="nothing oscillates"):
        suggest_surface(oscillator, resting)


def test_the_reduced_ball_and_its_coordinates_have_one_section():
    equations = vo.derive(vo.load("ball-on-sphere"))
    given = {"scene": "default", "crossings": 5}
    low = vo.section(equations, "gamma1", ("gamma2", "omega1"), **given)
    high = vo.section(equations, "gamma1", ("gamma2", "omega1", "u"), **given)
    assert low.formulation.startswith("invariants")
    assert high.formulation == "coordinates"
    assert low.t == pytest.approx(high.t, abs=1e-10)
    assert low.points == pytest.approx(high.points[:, :2], abs=1e-10)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_plane_of_the_time_alone_is_passed_when_it_is_that_time(method):
    """No state is needed to see the crossing: the point is the motion at that time."""
    sleigh = vo.load("sleigh")
    found = vo.section(sleigh, "t", value=0.5, crossings=1, until=1, outputs=("x",), method=method)
    there = vo.integrate(sleigh, times=[0, 0.5], outputs=("x",))
    assert found.t[0] == pytest.approx(0.5, abs=1e-13)
    assert found["x"][0] == pytest.approx(there["x"][-1], abs=1e-11)


@pytest.fixture(scope="module")
def beside_pole():
    """Starts of a ball of which one passes a pole of its angles, and the events of both in twenty
    digits."""
    ball = vo.derive(vo.load("chaplygin-ball"))
    names = ("phi", "theta", "psi", "x", "y", "omega1", "omega2", "omega3")
    near = {"theta": 1e-8, "omega1": 0.5, "omega2": 1, "omega3": 1}
    back = vo.integrate(ball, times=[0, -1], outputs=(), initial=near)
    begin = {x: float(back[x][-1]) for x in names}
    starts = [begin, {**begin, "theta": 0.7}]
    rises = [
        vo.integrate(
            ball, times=[0, 43], outputs=("omega2", "x"), initial=start, tol=1e-18,
            events=(vo.Event("omega1", "upwards", 1),),
        ).events["upwards"]
        for start in starts
    ]  # fmt: skip
    return ball, names, starts, rises


@pytest.mark.parametrize("method", METHODS)
def test_a_motion_that_passes_a_pole_goes_on_in_another_chart(method, beside_pole):
    ball, names, starts, rises = beside_pole
    found = vo.section(ball, "omega1", names, starts=starts, crossings=2, method=method)
    assert list(found.ends) == ["complete", "complete"] and not found.errors
    for i, truth in enumerate(rises):
        mine = found.start == i
        assert found.t[mine] == pytest.approx(truth.t[:2].astype(float), abs=1e-10)
        for name, off in (("omega2", 1e-10), ("x", 1e-9)):
            assert found[name][mine] == pytest.approx(truth[name][:2].astype(float), abs=off)


def test_a_plane_without_a_real_value_is_refused(oscillator):
    with pytest.raises(vo.DefinitionError, match="has no real value along the motion"):
        vo.section(oscillator, sp.sqrt(-(x**2) - 1), crossings=1, until=30)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
@pytest.mark.filterwarnings("error")
def test_a_motion_that_grows_without_bound_ends_its_section_in_one_line(method: str) -> None:
    growing = vo.System(
        name="growing", fibration=vo.Fibration((x,), ()),
        lagrangian=(vo.velocity(x) ** 2 + x**2) / 2,
    )  # fmt: skip
    start = {x: 1, vo.velocity(x): 1}
    with pytest.raises(vo.IntegrationError, match=r"start 0: .* after t = 7[01]\d"):
        vo.section(growing, starts=[start], plane=x + 5, crossings=3, method=method)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("fold", [20, 50])
def test_a_surface_that_is_passed_more_often_than_steps_are_taken(oscillator, method, fold):
    """sin(k x + 3/10) along x = sin t: where k sin t + 3/10 is a multiple of pi."""
    found = vo.section(
        oscillator, sp.sin(fold * x + sp.Rational(3, 10)), ("x",), parameters={"w": 1},
        starts=[{"x": 0, "xdot": 1}], crossings=1000, until=20.0, direction=0, method=method,
    )  # fmt: skip
    grid = np.linspace(0, 20, 4_000_001)[1:]
    values = np.sin(fold * np.sin(grid) + 0.3)
    truth = grid[1:][np.diff(np.sign(values)) != 0]
    assert len(found) == len(truth)
    assert np.abs(np.sort(found.t) - truth).max() < 1e-5
    assert np.abs(np.sin(fold * np.sin(found.t) + 0.3)).max() < 1e-11


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c"])
def test_poles_of_a_surface_are_no_crossings(method):
    """1/(x - 1/3) changes its sign at its pole; tan(2 x) has zeros beside its poles."""
    swing = vo.System(
        name="swing", fibration=vo.Fibration(x), lagrangian=(vo.velocity(x) ** 2 - x**2) / 2
    )
    start = {x: 0, vo.velocity(x): 1}
    options = {"starts": [start], "until": 20, "method": method, "direction": 0}
    found = vo.section(swing, sp.tan(2 * x), **options)
    assert found.t == pytest.approx(np.arange(1, 7) * np.pi, abs=1e-9)
    for surface in (1 / (x - sp.Rational(1, 3)), 1 / x):
        with pytest.raises(vo.DefinitionError, match="no motion passes through"):
            vo.section(swing, surface, **options)
    if method == "heyoka":  # a pole of a function that it follows ends its run, with a word
        return
    run = vo.integrate(
        swing, initial=start, times=[0, 20], method=method,
        events=(vo.Event(1 / (x - sp.Rational(1, 3)), "pole"), vo.Event(sp.tan(2 * x), "zero")),
    )  # fmt: skip
    assert len(run.events["pole"].t) == 0 and len(run.events["zero"].t) == 6


def test_a_start_may_be_given_without_a_scene():
    swing = vo.System(
        name="swing", fibration=vo.Fibration(x), lagrangian=(vo.velocity(x) ** 2 - x**2) / 2
    )
    found = vo.section(swing, vo.velocity(x), initial={x: 1}, crossings=2)
    assert found.t == pytest.approx([np.pi, 3 * np.pi], abs=1e-10)


@pytest.mark.parametrize("method", ["auto", "scipy"])
def test_the_surface_of_a_section_with_a_table_may_be_an_output(method):
    push = sp.Symbol("u")
    cart = vo.System(
        name="cart", fibration=vo.Fibration(x), lagrangian=vo.velocity(x) ** 2 / 2,
        forces={x: push}, inputs=(push,),
    )  # fmt: skip
    table = vo.Table([0, 1, 4], [-1, 1, 1])
    found = vo.section(
        cart, vo.velocity(x), initial={x: 0, vo.velocity(x): 0.1}, until=4, direction=0,
        crossings=3, inputs={push: table}, method=method,
    )  # fmt: skip
    # 0.1 - t + t^2 = 0 up to t = 1
    assert found.t == pytest.approx([0.5 - np.sqrt(0.15), 0.5 + np.sqrt(0.15)], abs=1e-9)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
@pytest.mark.parametrize(
    ("surface", "times"),
    [
        (sp.Mod(x, 1) - sp.Rational(1, 2), lambda k: (k + 1) / 2 - 0.1),
        (sp.floor(x) - sp.Rational(5, 2), lambda k: 2.9 if k == 0 else None),
        (sp.sign(sp.sin(x)), lambda k: (k + 1) * np.pi - 0.1),
        (sp.atan(sp.tan(x)), lambda k: (k + 1) * np.pi / 2 - 0.1),
        (sp.tan(x), lambda k: (k + 1) * np.pi - 0.1),
        (sp.sin(50 * x) / x, lambda k: (k + 2) * np.pi / 50 - 0.1),
    ],
)
def test_surfaces_that_jump_or_have_poles_are_seen_on_long_steps(surface, times, method):
    """A point that moves evenly, of which steps are as long as one likes; jumps through zero count,
    as for events."""
    free = vo.System(name="free", fibration=vo.Fibration(x), lagrangian=vo.velocity(x) ** 2 / 2)
    start = {x: sp.Rational(1, 10), vo.velocity(x): 1}
    found = vo.section(
        free, surface, ("x",), starts=[start], until=30, crossings=9, direction=0, method=method
    )
    truth = [t for k in range(9) if (t := times(k)) is not None]
    assert found.t == pytest.approx(truth, abs=1e-10)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_surface_far_away_is_reached_by_a_motion_that_is_even(method):
    """It was said to have no real value there: the first step led to 1e300."""
    free = vo.System(name="free", fibration=vo.Fibration(x), lagrangian=vo.velocity(x) ** 2 / 2)
    start = {x: 0, vo.velocity(x): 1}
    found = vo.section(free, x, ("x",), value=1e5, starts=[start], crossings=1, method=method)
    assert found.t == pytest.approx([1e5], rel=1e-14)
    with pytest.raises(vo.DefinitionError, match="no motion passes through x = -1"):
        vo.section(free, x, ("x",), value=-1, starts=[start], crossings=1, method=method)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", ["formula", "table"])
def test_a_section_begins_where_its_scene_does(method, kind):
    # a table begins there, too: it went from t = 0 where the input is a formula
    u = sp.Symbol("u")
    driven = vo.System(
        name="driven", fibration=vo.Fibration(base=(x,)), lagrangian=xdot**2 / 2 - x**2 / 2,
        forces={x: u}, inputs=(u,),
    )  # fmt: skip
    value = vo.time / 3 if kind == "formula" else vo.Table([0, 60], [0, 20])
    found = vo.section(
        driven, "x - t/3", ("x",), scene=vo.Scene({x: 0, xdot: 0}, (6, 10)), crossings=3,
        direction=0, until=30, inputs={u: value}, method=method,
    )  # fmt: skip
    # x = t/3 - 2 cos(t - 6) - sin(t - 6)/3
    expected = 6 + np.pi - np.arctan(6) + np.pi * np.arange(3)
    assert found.t == pytest.approx(expected, abs=1e-9)
    assert found.points[:, 0] == pytest.approx(expected / 3, abs=1e-9)


@pytest.mark.parametrize("until", [0, -3])
def test_a_section_that_ends_before_it_begins_is_refused(oscillator, until):
    with pytest.raises(vo.DefinitionError, match="sections go forwards in time"):
        vo.section(oscillator, "x", until=until)


@pytest.mark.parametrize("method", METHODS)
def test_starts_where_the_velocities_are_no_frame_go_alone_or_are_refused(method):
    y, phi = sp.symbols("y phi")
    dy, turn = vo.velocity(y), vo.velocity(phi)
    blade = vo.System(
        name="blade",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=(xdot**2 + dy**2 + turn**2) / 2,
        constraints=(xdot * sp.sin(phi) - dy * sp.cos(phi),),
    )
    up, beside = {dy: 1, turn: 0.3, phi: sp.pi / 2}, {xdot: 1, turn: 0.3, phi: np.pi / 2 + 1e-9}
    others = [{xdot: 1, turn: 0.3, phi: 0.5}, beside, up]
    options = {"value": -1, "crossings": 1, "direction": -1, "method": method}
    found = vo.section(blade, x, ("y",), starts=others, **options)
    assert [*found.errors] == [1] and "almost no frame" in str(found.errors[1])
    # circles: x = (cos(0.3 t) - 1)/0.3, x = (sin(0.5 + 0.3 t) - sin(0.5))/(0.3 cos(0.5))
    along = np.pi - np.arcsin(np.sin(0.5) - 0.3 * np.cos(0.5)) - 0.5
    assert found.t == pytest.approx(np.array([along, np.arccos(0.7)]) / 0.3, abs=1e-10)
    assert found["y"][1] == pytest.approx(np.sqrt(1 - 0.7**2) / 0.3, abs=1e-10)
    single = vo.section(blade, x, ("y",), initial=up, **options)
    assert single.t == pytest.approx(found.t[1:]) and single.cost.method == method
    with pytest.raises(vo.DefinitionError, match="almost no frame"):
        vo.section(blade, x, ("y",), starts=[beside], **options)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "roots", [(1, 2, 3), (1, 1.5, 2, 2.5, 3, 3.5), (1, 1.00002, 3, 3.5)], ids=str
)
def test_a_motion_that_is_a_polynomial_passes_at_each_of_its_roots(roots, method):
    """Over one long step looks that are as far apart as these see none of them change a sign."""
    place = sp.expand(sp.prod([vo.time - sp.Rational(root) for root in roots]))
    rate = place.diff(vo.time)
    system = vo.System("p", vo.Fibration(x), xdot**2 / 2, forces={x: rate.diff(vo.time)})
    start = {x: place.subs(vo.time, 0), xdot: rate.subs(vo.time, 0)}
    found = vo.section(
        system, x, (xdot,), initial=start, crossings=9, direction=0, until=4.0, method=method
    )
    assert found.t == pytest.approx(roots, abs=1e-9)
