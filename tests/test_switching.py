"""Right sides that are not smooth: friction, steps, switches, motions held on switching
surfaces."""

from functools import cache
from importlib.util import find_spec
from shutil import which

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.special import ellipk
from without_claims import bare

import voronec as vo
from voronec.equations.program import Program
from voronec.errors import DefinitionError, EngineLimit, IntegrationError, VoronecError

pytestmark = pytest.mark.slow

x, y, t = sp.Symbol("x"), sp.Symbol("y"), vo.time
Dx, Dy = vo.velocity(x), vo.velocity(y)
METHODS = ("heyoka", "scipy", "lsoda", "flint", "auto")
# The method numba compiles the steps that c has: it is tested in test_compiled_methods.
COMPILED = ("c",) if which("cc") else ()
PRECISION = {"flint": 1e-30}
ERROR = {"flint": 1e-26, "lsoda": 1e-9}


@cache
def mass_point(force=0, potential=0):
    return vo.derive(
        vo.System(
            name="mass point",
            fibration=vo.Fibration(base=(x,)),
            lagrangian=Dx**2 / 2 - potential,
            forces={x: force},
        )
    )


def motion(equations, start, end, method="auto", points=2, **options):
    return vo.integrate(
        equations, initial=dict(zip((x, Dx), start, strict=True)),
        times=np.linspace(0, float(end), points), method=method,
        tol=PRECISION.get(method, 1e-13), **options,
    )  # fmt: skip


def error(method):
    return ERROR.get(method, 1e-11)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("points", "dense"), [(2, False), (31, False), (2, True)])
def test_coulomb_friction_stops_a_block_and_holds_it(method, points, dense):
    found = motion(mass_point(-sp.sign(Dx)), (0, 1), 3, method, points, dense=dense)
    assert abs(found["x"][-1] - 0.5) < error(method) and found["xdot"][-1] == 0
    assert found.cost.switches == 1
    if points > 2:
        s = found.t.astype(float)
        truth = np.where(s < 1, s - s**2 / 2, 0.5)
        assert np.abs(found["x"].astype(float) - truth).max() < max(error(method), 1e-15)
    if dense:
        assert abs(found.at([0.5])["x"][0] - 0.375) < 1e-8 and found.at([2.5])["xdot"][0] == 0


@pytest.mark.parametrize("method", METHODS)
def test_a_spring_against_absolute_values_has_its_period(method):
    with mp.workdps(40):
        quarter = mp.quad(lambda s: 1 / mp.sqrt(mp.mpf(2) / 3 * (1 - s**3)), [0, 1])
    found = motion(mass_point(-sp.Abs(x) * x), (1, 0), 12 * quarter, method)
    assert abs(found["x"][-1] - 1) < error(method) and found.cost.switches == 6


@pytest.mark.parametrize("method", METHODS)
def test_springs_of_two_stiffnesses_have_half_periods(method):
    force = sp.Piecewise((-x, x < 0), (-4 * x, True))
    found = motion(mass_point(force), (0, 1), 3 * np.pi, method)
    with mp.workdps(40):
        late = found.t[-1] - 3 * mp.pi
        assert abs(found["x"][-1] - late) < error(method) and abs(late) < 1e-15
    assert abs(found["xdot"][-1] - 1) < error(method)


@pytest.mark.parametrize("method", METHODS)
def test_quadratic_drag_far_and_into_the_past(method):
    drag = mass_point(-sp.Abs(Dx) * Dx)
    assert abs(motion(drag, (0, 1), 2000, method)["x"][-1] - mp.log(2001)) < 1e-9
    assert abs(motion(drag, (0, 1), -0.5, method)["xdot"][-1] - 2) < 1e-10


@pytest.mark.parametrize("method", METHODS)
def test_a_limited_control_swings_to_the_other_side(method):
    with mp.workdps(40):
        end = 2 * mp.sqrt(2) + mp.acos(-1 / mp.sqrt(3)) - mp.atan(mp.sqrt(2))
    found = motion(mass_point(-sp.Min(1, sp.Max(-1, x))), (2, 0), end, method)
    assert abs(found["x"][-1] + 2) < error(method)


@pytest.mark.parametrize("method", METHODS)
def test_a_body_on_a_belt_sticks_and_slips(method):
    """It sticks up to x = 1, and then x = 1 + sin(t - 1), which touches the speed of the belt."""
    found = motion(mass_point(-x - sp.sign(Dx - 1)), (0, 1), 12, method, 25)
    s = found.t.astype(float)
    truth = np.where(s < 1, s, 1 + np.sin(s - 1))
    assert np.abs(found["x"].astype(float) - truth).max() < 1e-6


def test_weaker_friction_of_faster_slip_makes_a_cycle():
    belt = mass_point(-x - sp.sign(Dx - 1) * (1 + sp.exp(-sp.Abs(Dx - 1))))
    ends = [motion(belt, (0, 0), 30, m)["x"][-1] for m in ("heyoka", "scipy", "flint")]
    assert max(abs(e - ends[-1]) for e in ends) < 1e-11


@pytest.mark.parametrize("method", METHODS)
def test_steps_of_the_time(method):
    saw = motion(mass_point(sp.Mod(t, 1)), (0, 0), 3, method)
    assert abs(saw["x"][-1] - 2) < error(method)
    wave = motion(mass_point(sp.sign(sp.sin(t))), (0, 0), 4, method)
    assert abs(wave["xdot"][-1] - (2 * np.pi - 4)) < max(error(method), 1e-14)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_a_kink_of_the_potential_is_passed(method):
    found = motion(mass_point(0, sp.Abs(x)), (0, 1), 4, method)
    assert abs(found["x"][-1]) < error(method) and abs(found["xdot"][-1] - 1) < error(method)
    assert motion(mass_point(0, sp.Abs(x)), (0, 0), 4, method)["x"][-1] == 0


def test_a_start_on_a_switch_goes_the_way_that_the_fields_lead():
    assert abs(motion(mass_point(2 - sp.sign(Dx)), (0, 0), 3)["x"][-1] - 4.5) < 1e-12
    assert motion(mass_point(sp.Rational(1, 2) - sp.sign(Dx)), (0, 0), 3)["x"][-1] == 0
    falls = motion(mass_point(-1 - sp.sign(x) / 3), (0, 0), 2)
    assert abs(falls["x"][-1] + sp.Rational(4, 3)) < 1e-12


@pytest.mark.parametrize("method", METHODS)
def test_what_is_not_determined_is_said(method):
    with pytest.raises(IntegrationError, match="may leave xdot = 0 on either side"):
        motion(mass_point(sp.sign(Dx)), (0, 0), 1, method)
    with pytest.raises(IntegrationError, match="the past is not determined") as caught:
        motion(mass_point(-sp.sign(Dx)), (0, 0), -1, method)
    assert "\n" not in str(caught.value)
    with pytest.raises(IntegrationError, match="past is not determined"):
        motion(mass_point(-x - sp.sign(Dx - 1)), (2, 0), -10, method)


@pytest.mark.parametrize("method", METHODS)
def test_a_switch_that_is_only_touched_decides_nothing_in_silence(method):
    """x = -sin t touches 1, beyond which a force jumps outwards: that is not determined, whether
    rounding takes it across or not; with a little more or less speed it is."""
    push = mass_point(-x + 5 * sp.Heaviside(x - 1))
    with pytest.raises(IntegrationError, match=r"touches .* and may turn there or go on beyond"):
        motion(push, (0, -1), 20, method)
    inwards = mass_point(-x - 5 * sp.Heaviside(x - 1))
    assert abs(motion(inwards, (0, -1), 6, method)["x"][-1] + mp.sin(6)) < 1e-6
    slow = motion(push, (0, -1 + 1e-6), 20, method)["x"][-1]
    assert abs(slow + (1 - 1e-6) * mp.sin(20)) < 1e-9
    free = motion(mass_point(-x + sp.Max(0, x - 1)), (0, -1), 20, method)["x"][-1]
    assert abs(free + mp.sin(20)) < 1e-6  # nothing jumps
    fast = -1 - 1e-6
    truth = motion(push, (0, fast), 5.5, "flint")["x"][-1]
    assert abs(motion(push, (0, fast), 5.5, method)["x"][-1] - truth) < 1e-7


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("place", [0, 0.25])
def test_a_switch_is_touched_where_its_function_has_no_size(place, method):
    """x = place + (1 - t)^2 turns at the switching surface, below which the force points away."""
    thrown = mass_point(sp.Piecewise((2, x > sp.Rational(str(place))), (-3, True)))
    start = {x: place + 1, Dx: -2}
    with pytest.raises(IntegrationError, match="may turn there or go on beyond"):
        motion(thrown, start.values(), 2, method)
    if method in ("heyoka", "scipy"):
        higher = {x: place + 1.01, Dx: -2}
        many = vo.ensemble(thrown, starts=[start, higher], times=[0, 2], method=method)
        assert "may turn there" in str(many.errors[0]) and list(many.errors) == [0]
        assert many["x"][1, -1] == pytest.approx(place + 1.01, abs=1e-11)
        passed = vo.section(
            thrown,
            x - place - 0.5,
            outputs=(Dx,),
            starts=[start, higher],
            crossings=1,
            method=method,
        )
        assert "may turn there" in str(passed.errors[0]) and list(passed.start) == [1]
        assert passed["xdot"][0] == pytest.approx(1.4, abs=1e-11)


def test_switches_that_accumulate_are_named():
    """A ball that falls on a plate which takes speed: bounces made of steep springs.  Where nothing
    else moves it, it rests after the last one."""
    force = -2 * sp.sign(x) - sp.sign(Dx)
    with pytest.raises(IntegrationError, match=r"switches .* ever faster") as caught:
        motion(mass_point(force + sp.sin(vo.time) / 5), (1, 0), 40, "scipy")
    assert caught.value.time < 10 and "\n" not in str(caught.value)
    run = motion(mass_point(force), (1, 0), 40, "scipy")
    assert run["x"][-1] == 0 and abs(run["xdot"][-1]) < 1e-11


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_friction_in_the_plane_ends_where_the_direction_of_slip_does(method):
    speed = sp.sqrt(Dx**2 + Dy**2)
    plane = vo.derive(
        vo.System(
            name="puck",
            fibration=vo.Fibration(base=(x, y)),
            lagrangian=(Dx**2 + Dy**2) / 2,
            forces={x: -Dx / speed, y: -Dy / speed},
        )
    )
    with pytest.raises(IntegrationError, match="comes to rest where a root of velocities") as got:
        vo.integrate(plane, initial={Dx: 3, Dy: 4}, times=[0, 8], method=method,
                     tol=PRECISION.get(method, 1e-13))  # fmt: skip
    assert abs(got.value.time - 5) < 1e-4
    line = vo.integrate(plane, initial={Dx: 1}, times=[0, 8], method=method)
    assert abs(line["x"][-1] - 0.5) < 1e-12 and line["xdot"][-1] == 0


@pytest.mark.parametrize("method", ["auto", "scipy", "flint"])
def test_friction_in_the_plane_turns_a_motion_that_nearly_comes_to_rest(method):
    """Under a push of 1 and friction of 1/2, s sin(a)/sqrt(tan(a/2)) = C stays for the speed s at
    an angle a to the push: with p = tan(a/2), dt = -C p^(-3/2) (1 + p^2) dp/2."""
    speed = 2 * sp.sqrt(Dx**2 + Dy**2)
    base, energy = vo.Fibration(base=(x, y)), (Dx**2 + Dy**2) / 2
    forces = {x: 1 - Dx / speed, y: -Dy / speed}
    pushed = vo.System(name="pushed", fibration=base, lagrangian=energy, forces=forces)
    tol = PRECISION.get(method, 1e-13)
    aside = sp.Rational(1, 10**9 if method == "flint" else 10**4)
    run = vo.integrate(pushed, initial={Dx: -1, Dy: aside}, times=[0, 3], method=method, tol=tol)
    with mp.workdps(40):
        slip = mp.mpf(1) / aside.q
        first = (mp.sqrt(1 + slip**2) + 1) / slip
        size = slip / mp.sqrt(first)

        def way(p):
            return size * (p ** mp.mpf(-0.5) - p ** mp.mpf(1.5) / 3)

        left = way(first) + 3
        p = mp.exp(mp.findroot(lambda q: way(mp.exp(q)) - left, [-90, 0], solver="ridder"))
        ends = size * (1 - p**2) / (2 * mp.sqrt(p)), size * mp.sqrt(p)
        assert abs(run["xdot"][-1] - ends[0]) < error(method)
        assert abs(run["ydot"][-1] - ends[1]) < error(method)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_a_speed_that_only_multiplies_ends_nothing(method):
    """Drag -v - 3 v |v|/10 brings a body to rest for ever; thrown up it turns, or nearly rests."""
    speed = sp.sqrt(Dx**2 + Dy**2)
    drag = {x: -Dx * (1 + 3 * speed / 10), y: -Dy * (1 + 3 * speed / 10)}
    base, energy = vo.Fibration(base=(x, y)), (Dx**2 + Dy**2) / 2
    slow = vo.System(name="slow", fibration=base, lagrangian=energy, forces=drag)
    how = {"method": method, "tol": PRECISION.get(method, 1e-13)}
    run = vo.integrate(slow, initial={Dx: 0.6, Dy: 0.8}, times=[0, 40], **how)
    way = np.log(1.3) / 0.3  # the integral of v/(v + 3 v^2/10) over the speeds from 0 to 1
    assert abs(run["x"][-1] - 0.6 * way) < 1e-12 and abs(run["y"][-1] - 0.8 * way) < 1e-12
    push = {
        x: sp.Rational(-3, 5) - 3 * Dx * speed / 10,
        y: sp.Rational(-4, 5) - 3 * Dy * speed / 10,
    }
    up = vo.System(name="up", fibration=base, lagrangian=energy, forces=push)
    root = np.sqrt(0.3)
    height = np.log(1.3) / 0.6 - np.log(np.cosh(3 * root - np.arctan(root))) / 0.3
    for aside in (0, 1e-12):  # at its highest it rests, or passes rest by that
        start = {Dx: 0.6 - 0.8 * aside, Dy: 0.8 + 0.6 * aside}
        run = vo.integrate(up, initial=start, times=[0, 3], **how)
        assert abs(0.6 * run["x"][-1] + 0.8 * run["y"][-1] - height) < 1e-11


@pytest.mark.parametrize("end", [1, -1])
def test_a_speed_that_multiplies_has_a_series_from_rest_in_many_digits(end):
    """v' = 5 - v |v| along a line: a tanh, before it a tan.  With a push that turns, by scipy."""
    speed = sp.sqrt(Dx**2 + Dy**2)
    base, energy = vo.Fibration(base=(x, y)), (Dx**2 + Dy**2) / 2
    forces = {x: 3 - Dx * speed, y: 4 - Dy * speed}
    fall = vo.System(name="fall", fibration=base, lagrangian=energy, forces=forces)
    run = vo.integrate(fall, initial={Dx: 0}, times=[0, end / 4], method="flint", tol=1e-30)
    with mp.workdps(40):
        pace = mp.sqrt(5)
        truth = pace * (mp.tanh if end > 0 else mp.tan)(pace * end / 4)
        assert abs(run["xdot"][-1] - truth * 3 / 5) < 1e-28
        assert abs(run["ydot"][-1] - truth * 4 / 5) < 1e-28
    late = {x: t - Dx * speed**3, y: t**2 - Dy * speed}
    turning = vo.System(name="turning", fibration=base, lagrangian=energy, forces=late)
    found = [
        vo.integrate(turning, initial={Dx: 0}, times=[0, end], method=method, tol=tol)
        for method, tol in (("flint", 1e-20), ("scipy", 1e-13))
    ]
    for name in ("x", "y", "xdot", "ydot"):
        assert abs(found[0][name][-1] - found[1][name][-1]) < 1e-12


def test_roots_that_vanish_on_the_way_are_refused_in_many_digits():
    """A spring -|x|^(3/2) sign x has no Taylor series at x = 0."""
    spring = mass_point(-(sp.Abs(x) ** sp.Rational(3, 2)) * sp.sign(x))
    with pytest.raises(EngineLimit, match="no Taylor series where it vanishes; use method='scipy'"):
        motion(spring, (1, 0), 2, "flint")


@pytest.mark.skipif("c" not in COMPILED, reason="there is no C compiler")
@pytest.mark.parametrize(
    "force",
    [
        -x / 2 - sp.Max(x - sp.Rational(1, 3), 0) ** sp.Rational(4, 3),
        -sp.sqrt(sp.Abs(sp.sin(x))) * sp.sign(sp.sin(x)) - Dx * sp.sqrt(sp.Abs(Dx)) / 3,
        -x + sp.sqrt(sp.Abs(x - sp.sin(2 * t) / 2)),
    ],
)
def test_roots_that_vanish_are_passed_as_by_another_method(force):
    runs = [motion(mass_point(force), (1, 0), 4, method) for method in ("c", "scipy")]
    assert abs(runs[0]["x"][-1] - runs[1]["x"][-1]) < 1e-11
    assert abs(runs[0]["xdot"][-1] - runs[1]["xdot"][-1]) < 1e-11


@pytest.mark.parametrize("method", ["auto", "flint"])
def test_a_body_at_rest_where_two_springs_meet_stays_there(method):
    """Fields that vanish at a state, no faster than in proportion to the way from it, leave it
    nowhere, nor do those that lead back; one that does faster, and leads on, as sqrt|x|, may."""
    stiff, root = sp.Piecewise((-x, x < 0), (-4 * x, True)), sp.sqrt(sp.Abs(x))
    drag = sp.sqrt(sp.Abs(Dx))
    rooted = -(root**3) * sp.sign(x), -root * sp.sign(x), -drag * sp.sign(Dx)
    for force in (stiff, -(x**2) * sp.sign(x) - Dx, *(rooted if method != "flint" else ())):
        run = motion(mass_point(force), (0, 0), 1, method)
        assert run["x"][-1] == 0 == run["xdot"][-1]
    late = sp.Heaviside(vo.time - 3)  # what sets in later is not forgotten
    pushed = motion(mass_point(stiff + late), (0, 0), 4, method)
    assert abs(pushed["x"][-1] - (1 - mp.cos(2)) / 4) < 1e-12
    for force, place in ((root * sp.sign(x), "x"), (root, "x"), (drag, "xdot")):
        refusal = "no Taylor" if method == "flint" else f"may leave {place} = 0 on either side"
        with pytest.raises(VoronecError, match=refusal):
            motion(mass_point(force), (0, 0), 1, method)


@pytest.mark.parametrize("method", ["auto", "flint"])
def test_what_rests_goes_on_where_only_the_time_meets_a_switch(method):
    """At an instant of a switching surface only the side that comes matters: friction that fades at
    t = 1, a push that sets in at t = 2, and one that begins with the motion."""
    freed = -sp.sign(Dx) * sp.Max(0, 1 - t) + sp.Max(0, t - 2)
    run = motion(mass_point(freed), (0, 0), 3, method)
    assert abs(run["x"][-1] - mp.mpf(1) / 6) < 1e-14 and abs(run["xdot"][-1] - 0.5) < 1e-14
    stiff = sp.Piecewise((-x, x < 0), (-4 * x, True))
    run = motion(mass_point(stiff + sp.floor(t)), (0, 0), 2, method)
    assert abs(run["x"][-1] - (1 - mp.cos(2)) / 4) < 1e-14
    pushed = vo.System(
        "pushed", vo.Fibration(base=(x,)), lagrangian=Dx**2 / 2, forces={x: stiff + y}, inputs=(y,)
    )
    ramp = {y: vo.Table([0, 1, 2], [0, 0, 1], "linear")}
    run = motion(pushed, (0, 0), 2, method, inputs=ramp)
    assert abs(run["x"][-1] - (1 - mp.sin(2) / 2) / 4) < 1e-14


@pytest.mark.parametrize("method", ["auto", "flint"])
def test_a_body_rests_where_two_springs_meet_while_another_moves(method):
    pair = vo.System(
        "pair", vo.Fibration(base=(x, y)), lagrangian=(Dx**2 + Dy**2) / 2,
        forces={x: -x, y: -sp.Max(y, Dy / 2) + sp.Heaviside(t - 2)},
    )  # fmt: skip
    start = {"initial": {x: 1}, "method": method, "tol": PRECISION.get(method, 1e-13)}
    rest = vo.integrate(pair, times=[0, 2, 2.5], **start)
    assert rest["y"][1] == 0 and rest["x"][2] == pytest.approx(np.cos(2.5), abs=1e-12)
    assert rest["y"][2] == pytest.approx(4 * np.exp(-0.25) - 3, abs=1e-9)
    steep = vo.System(
        "pair", pair.fibration, lagrangian=pair.lagrangian, forces={y: sp.sqrt(sp.Abs(y))}
    )
    refusal = "no Taylor series" if method == "flint" else "may leave y = 0 on either side"
    with pytest.raises(VoronecError, match=refusal):
        vo.integrate(steep, times=[0, 1], **start | {"initial": {Dx: 1}})


@pytest.mark.parametrize("method", ["scipy", *COMPILED])
def test_friction_holds_a_body_where_a_root_of_its_place_has_no_slope(method):
    """At x = 0 under -sqrt|x|: one looked for a step for ever, others lost the state."""
    root = -sp.sqrt(sp.Abs(x)) * sp.sign(x)
    held = motion(mass_point(root - sp.sign(Dx) / 2), (0, 0), 3, method)
    assert held["x"][-1] == 0 == held["xdot"][-1]
    carried = motion(mass_point(root - 2 * sp.sign(Dx - sp.sin(t))), (0, 0), 1, method)
    assert abs(carried["x"][-1] - (1 - mp.cos(1))) < 1e-11


def test_two_bodies_with_friction_between_them_stop_together_and_apart():
    """Two blocks, one on the other: both slide, stick to each other, and stop."""
    system = vo.System(
        name="blocks",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=(Dx**2 + Dy**2) / 2,
        forces={x: -sp.sign(Dx - Dy), y: sp.sign(Dx - Dy) - sp.sign(Dy) / 2},
    )
    for method in ("heyoka", "scipy", "flint"):
        found = vo.integrate(system, initial={Dx: 3}, times=[0, 20], method=method)
        # together at t = 2 with speed 1, then slower by 1/4 in a unit of time
        assert abs(found["x"][-1] - 6) < 1e-11 and abs(found["y"][-1] - 3) < 1e-11
        assert found["xdot"][-1] == 0 == found["ydot"][-1]


def test_a_sleigh_with_friction_against_its_turning():
    base = vo.load("sleigh")
    c = sp.Rational(1, 3)
    phi = next(q for q in base.coordinates if str(q) == "phi")
    system = bare(base, "braked sleigh", forces={phi: -c * sp.sign(vo.velocity(phi))})
    equations = vo.derive(system)
    numbers = {p.symbol: sp.nsimplify(p.value) for p in base.parameters}
    rates = list((equations.mass.inv() * equations.force).subs(numbers))
    v, w = equations.velocities
    moving = sp.lambdify((v, w), [r.subs(sp.sign(w), 1) for r in rates], "mpmath")
    with mp.workdps(30):
        path = mp.odefun(lambda _s, z: moving(*z), 0, [mp.mpf(1), mp.mpf(1)], tol=mp.mpf("1e-20"))
        stop = mp.findroot(lambda s: path(s)[1], (mp.mpf("0.5"), mp.mpf(1)), tol=1e-18)
        speed = path(stop)[0]
    for method in ("heyoka", "scipy", "flint", "auto"):
        found = vo.integrate(
            equations, initial={v: 1, w: 1}, times=[0, 6], outputs=(v, w), method=method
        )
        assert found[w][-1] == 0 and abs(found[v][-1] - speed) < 1e-11


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("base", ["x", "y"])
def test_friction_goes_on_where_a_frame_fails(base, method):
    """A skate that turns evenly while friction brakes it: v = 2 - s/2, to rest at s = 4.  Its x'
    does not tell its motion where it heads along y, nor y' where it heads along x."""
    phi = sp.Symbol("phi")
    Dphi, v = vo.velocity(phi), Dx * sp.cos(phi) + Dy * sp.sin(phi)
    free, bound = (x, y) if base == "x" else (y, x)
    skate = vo.System(
        name="skate",
        fibration=vo.Fibration(base=(free, phi), fibre=(bound,)),
        lagrangian=(Dx**2 + Dy**2 + Dphi**2) / 2,
        constraints=(Dx * sp.sin(phi) - Dy * sp.cos(phi),),
        forces={x: -sp.sign(v) * sp.cos(phi) / 2, y: -sp.sign(v) * sp.sin(phi) / 2},
    )
    # sin(phi) = 3/5 at the start, in digits
    start = {phi: sp.asin(sp.Rational(3, 5)), Dx: sp.Rational(8, 5), Dy: sp.Rational(6, 5), Dphi: 1}
    found = vo.integrate(
        skate, initial=start, times=np.linspace(0, 9, 13), method=method,
        tol=PRECISION.get(method, 1e-13), events=(vo.Event(y - 2, "above"),),
    )  # fmt: skip
    assert found.cost.switches == 1  # where it comes to rest

    def place(s):
        angle = mp.asin(mp.mpf(3) / 5) + s
        return (
            (2 - s / 2) * mp.sin(angle) - mp.cos(angle) / 2,
            -(2 - s / 2) * mp.cos(angle) - mp.sin(angle) / 2,
        )

    with mp.workdps(40):
        begin = place(mp.mpf(0))
        for name, i in (("x", 0), ("y", 1)):
            truth = [place(min(mp.mpf(float(s)), mp.mpf(4)))[i] - begin[i] for s in found.t]
            off = max(abs(a - b) for a, b in zip(found[name], truth, strict=True))
            assert off < error(method)
        passed = mp.findroot(lambda s: place(s)[1] - begin[1] - 2, 1.5)
        assert abs(found.events["above"].t[0] - passed) < error(method)


@pytest.mark.parametrize("method", ["scipy", "heyoka"])
def test_a_sleigh_held_by_friction_stands_still(method):
    sleigh = vo.load("sleigh")
    v = sleigh.velocities[0]
    braked = vo.derive(bare(sleigh, "dragged sleigh", forces={v: -sp.sign(v) / 2}))
    assert braked.force[0].atoms(sp.sign) == {sp.sign(v)}
    start, mass = {"v": 1.0, "phi": 0.7}, {"m": 1.5}
    run = vo.integrate(braked, initial=start, parameters=mass, times=[0, 5], method=method)
    assert run["v"][-1] == 0 and run["x"][-1] == pytest.approx(1.5 * np.cos(0.7), abs=1e-12)


@pytest.mark.parametrize("method", ["scipy", "heyoka", "flint"])
def test_a_mass_that_jumps_with_the_velocity(method):
    """A pendulum with the mass 1.3 on its way out and 0.7 back: half a period is that of the
    pendulum times the root of its mass, by a complete elliptic integral."""
    theta = sp.Symbol("theta")
    dot, gain = vo.velocity(theta), sp.Rational(3, 10)
    pendulum = vo.System(
        name="jumping mass",
        fibration=vo.Fibration(base=(theta,)),
        lagrangian=dot**2 / 2 + sp.cos(theta),
        forces={theta: gain * sp.sign(dot) * sp.Symbol("thetadotdot")},
    )
    half = 2 * ellipk(np.sin(0.5) ** 2)
    times = np.cumsum([0, np.sqrt(1.3), np.sqrt(0.7), np.sqrt(1.3)]) * half
    run = vo.integrate(pendulum, initial={"theta": 1}, times=times, method=method)
    assert run["theta"].astype(float) == pytest.approx([1, -1, 1, -1], abs=1e-10)


def test_events_at_a_switch_and_between_are_seen():
    rest, half = vo.Event(Dx, name="rest"), vo.Event(x - sp.Rational(3, 8), name="half")
    for method in ("heyoka", "scipy", "flint"):
        found = motion(mass_point(-sp.sign(Dx)), (0, 1), 3, method, events=(rest, half))
        assert len(found.events["rest"]) == 1 and len(found.events["half"]) == 1
        assert abs(found.events["rest"].t[0] - 1) < 1e-11
        assert abs(found.events["half"].t[0] - 0.5) < 1e-9
    end = motion(mass_point(-sp.sign(Dx)), (0, 1), 3, events=(vo.Event(Dx, "rest", stop=True),))
    assert end.stopped == "rest" and abs(end.t[-1] - 1) < 1e-12
    size = vo.Event(sp.Abs(x) - sp.Rational(1, 2), name="size")
    swing = motion(mass_point(-x), (1, 0), 2 * np.pi, "heyoka", events=(size,))
    assert np.allclose(swing.events["size"].t, np.pi * np.array([1, 2, 4, 5]) / 3, atol=1e-12)


@pytest.mark.parametrize("name", ["wall 0", "turn at wall 0", "weight 0", "event 1", "event 0"])
def test_what_users_call_their_events_is_theirs(name):
    """Runs that watch switching surfaces, charts and cuts for themselves know what they watch by no
    name."""
    events = (vo.Event(x - sp.Rational(3, 10), name), vo.Event(x - sp.Rational(4, 10)))
    found = motion(mass_point(-sp.sign(Dx)), (0, 1), 3, events=events)
    assert [*found.events] == [name, "x - 2/5"] and abs(found["x"][-1] - 0.5) < 1e-12
    assert np.allclose(found.events[name].t, [1 - np.sqrt(0.4)], atol=1e-12)
    halted = motion(mass_point(-sp.sign(Dx)), (0, 1), 3, events=(vo.Event(events[0].function, name,
                    stop=True), events[1]))  # fmt: skip
    assert halted.stopped == name and not len(halted.events["x - 2/5"])
    assert abs(halted.t[-1] - 1 + np.sqrt(0.4)) < 1e-12


REFEREED = [
    (-2 * sp.Max(Dx, x, 0) + sp.Min(x, 1), 0),
    (sp.Heaviside(x - Dx), -(sp.Max(x, y) ** 2)),
    (sp.Piecewise((x, x < Dx), (Dx**2, (x > 2) | (Dx < -1)), (3, True)), -sp.Abs(x * y)),
    (sp.Mod(x, 2) + sp.floor(3 * Dx) - sp.ceiling(y) + sp.frac(t), sp.sqrt((x - y) ** 2)),
    (sp.sign(Dx) * sp.Abs(Dx) ** sp.Rational(3, 2), -sp.Piecewise((x**2, x < 0), (2 * x**2, True))),
]


@pytest.mark.parametrize(("force", "term"), REFEREED, ids=str)
def test_the_referee_agrees_off_the_switches(force, term):
    system = vo.System(
        name="pieces",
        fibration=vo.Fibration(base=(x, y)),
        lagrangian=(Dx**2 + Dy**2 * (1 + x**2)) / 2 + term,
        forces={x: force},
    )
    equations = vo.derive(system)
    for numbers in ((1.3, -0.4, 0.7, 0.2), (-1.3, 0.4, -1.7, 1.2), (2.6, 3.4, -0.7, 0.2)):
        point = {**dict(zip((x, y, Dx, Dy), numbers, strict=True)), t: 0.25}
        own, other = equations.acceleration(point), vo.multiplier_acceleration(system, point)
        assert max(abs(own[q] - other[q]) for q in (x, y)) < 1e-25


def test_generated_python_is_defined_on_the_switches():
    source = mass_point(-sp.sign(Dx) - sp.floor(x), sp.Abs(x) + x**2).python()
    space = {}
    exec(source, space)
    assert [float(r) for r in space["rhs"](0.0, [0.0, 0.0], [])] == [0, 0]
    assert [float(r) for r in space["rhs"](0.0, [1.5, -2.0], [])] == [-2, -4]


@pytest.mark.parametrize("name", ["sleigh", "chaplygin-ball", "falling-disc", "rattleback"])
def test_what_is_smooth_has_no_switches(name):
    form = vo.derive(vo.load(name)).form
    assert not Program.of(form).derivative.is_rough(form.parameters, form.velocities)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_ensembles_and_sections_go_motion_by_motion(method):
    mu = sp.Symbol("mu")
    blocks = vo.System(
        name="blocks",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=Dx**2 / 2,
        forces={x: -mu * sp.sign(Dx)},
        parameters=(vo.Parameter(mu, 1.0),),
    )
    found = vo.ensemble(
        blocks, starts={Dx: [1, 2, 3]}, parameters={mu: [1, 2, 0.5]}, times=[0, 1, 20],
        method=method,
    )  # fmt: skip
    assert np.abs(found["x"][:, -1] - [0.5, 1, 9]).max() < 1e-11 and not found.errors
    assert (found["xdot"][:, -1] == 0).all() and found.cost.method == method
    springs = mass_point(sp.Piecewise((-x, x < 0), (-4 * x, True)))
    points = vo.section(springs, x, starts={Dx: 1}, crossings=4, method=method)
    assert np.abs(points.t / np.pi - [1.5, 3, 4.5, 6]).max() < 1e-11
    assert np.abs(points["xdot"] - 1).max() < 1e-11 and np.abs(points.speed - 1).max() < 1e-5
    lost = vo.ensemble(mass_point(sp.sign(Dx)), starts={Dx: [0, 1]}, times=[0, 1], method=method)
    assert "on either side" in str(lost.errors[0]) and abs(lost["xdot"][1, -1] - 2) < 1e-11


@pytest.mark.parametrize("method", ["auto", "heyoka", "scipy"])
def test_an_ensemble_whose_first_start_goes_nowhere_says_why(method):
    friction, back = mass_point(-sp.sign(Dx)), {"times": [0, -1], "method": method}
    for speeds in ([0], [0, 0], [0, 1], [1, 0]):
        found = vo.ensemble(friction, starts={Dx: speeds}, **back)
        assert list(found.errors) == [i for i, v in enumerate(speeds) if v == 0]
        assert all("the past is not determined" in str(e) for e in found.errors.values())
        assert (
            np.abs(found["xdot"][[i for i, v in enumerate(speeds) if v], -1] - 2).max(initial=0)
            < 1e-11
        )
        if any(speeds) and (method != "auto" or find_spec("heyoka")):
            assert found.cost.method == ("heyoka" if method == "auto" else method)


def test_roots_that_vanish_on_a_switch():
    with mp.workdps(30):
        quarter = mp.quad(lambda s: 1 / mp.sqrt(mp.mpf(4) / 3 * (1 - s**1.5)), [0, 0.5, 1])
    springs = mass_point(-sp.sign(x) * sp.sqrt(sp.Abs(x)))
    for method in ("scipy", "auto", "lsoda"):
        found = motion(springs, (1, 0), 8 * quarter, method)
        assert abs(found["x"][-1] - 1) < 1e-9 and found.cost.switches == 4
    with pytest.raises(EngineLimit, match="no Taylor series where it vanishes"):
        motion(springs, (1, 0), 1, "heyoka")
    one_side = mass_point(sp.Piecewise((-sp.sqrt(x), x > 0), (-x, True)))
    round_trip = mp.pi + 2 * mp.mpf(0.75) ** (mp.mpf(1) / 6) * quarter
    for method in ("auto", "scipy"):
        back = motion(one_side, (-1, 0), round_trip, method)
        assert abs(back["x"][-1] + 1) < 1e-9 and back.cost.switches == 2


BLOWS = [
    Dx**2 / 2 - sp.Heaviside(x), Dx**2 * (1 + sp.Heaviside(x)), Dx**2 / 2 + sp.Abs(Dx),
    Dx**2 / 2 - sp.floor(x), Dx**2 / 2 + sp.sign(sp.sin(t)) * Dx * x,
    Dx**2 / 2 - sp.Piecewise((x**2, x < 1), (2 * x, True)),
]  # fmt: skip
KINKS = [
    Dx**2 / 2 - sp.Abs(x), Dx**2 / 2 - sp.Max(x, 0) ** 2, Dx**2 / 2 + sp.Abs(Dx) * Dx,
    Dx**2 / 2 - sp.frac(x) * (1 - sp.frac(x)), Dx**2 / 2 - sp.sign(sp.sin(t)) * x,
    Dx**2 / 2 - sp.Piecewise((x**2, x < 1), (2 * x - 1, True)),
]  # fmt: skip


def test_lagrangians_have_kinks_but_do_not_jump():
    for lagrangian in BLOWS:
        with pytest.raises(DefinitionError, match=r"the Lagrangian jumps where .* = 0"):
            vo.derive(vo.System("blow", vo.Fibration(base=(x,)), lagrangian))
    for lagrangian in KINKS:
        assert vo.derive(vo.System("kink", vo.Fibration(base=(x,)), lagrangian)).force is not None
    step = vo.System("rail", vo.Fibration((x,), (y,)), Dx**2 + Dy**2, (Dy - sp.sign(x) * Dx,))
    with pytest.raises(DefinitionError, match=r"constraint 1 .* jumps where x = 0"):
        vo.derive(step)


def test_reactions_are_refused_while_friction_holds():
    rail = vo.System(
        name="rail",
        fibration=vo.Fibration((x,), (y,)),
        lagrangian=(Dx**2 + Dy**2) / 2,
        constraints=(Dy - Dx,),
        forces={x: -sp.sign(Dx)},
    )
    given = {"initial": {Dx: 1, Dy: 1}, "outputs": ("x", "reaction 1")}
    early = vo.integrate(rail, times=[0, 1], **given)
    assert abs(early["x"][-1] - 0.75) < 1e-12 and abs(abs(early["reaction 1"][-1]) - 0.5) < 1e-12
    with pytest.raises(DefinitionError, match="reactions are not known while friction holds"):
        vo.integrate(rail, times=[0, 5], **given)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_many_fold_angles_beside_a_switch_are_not_expanded(method):
    drive = sp.Rational(39, 20)  # in terms of t/20 a polynomial of degree 39
    found = motion(mass_point(sp.sin(drive * t) + sp.Max(0, x - 100)), (0, 0), 3, method)
    truth = 3 / float(drive) - np.sin(3 * float(drive)) / float(drive) ** 2
    assert abs(found["x"][-1] - truth) < 1e-12


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_speed_that_grows_without_bound_ends_the_run(method):
    # backwards from speed 1 drag makes it 1 / (1 + t); heyoka's steps fall to zero there
    with pytest.raises(IntegrationError) as caught:
        motion(mass_point(-Dx * sp.Abs(Dx)), (0, 1), -5, method)
    assert float(caught.value.time) == pytest.approx(-1, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_push_that_friction_just_bears_moves_nothing(method):
    """The function of the release is zero all along: it was switched at a step after another."""
    push = sp.Symbol("u")
    block = vo.System(
        name="block", fibration=vo.Fibration(x), lagrangian=Dx**2 / 2,
        forces={x: push - sp.sign(Dx)}, inputs=(push,),
    )  # fmt: skip
    rest = vo.integrate(block, initial={x: 0}, times=[0, 2], method=method, inputs={push: 1})
    assert [rest["x"][-1], rest["xdot"][-1]] == [0, 0]
    table = vo.Table([0, 1, 2], [1, 2, 2], "held")
    run = vo.integrate(block, initial={x: 0}, times=[0, 2], method=method, inputs={push: table})
    assert float(run["x"][-1]) == pytest.approx(0.5, abs=1e-9)


def test_a_motion_may_end_in_any_precision_just_where_it_switches():
    """Backwards to t = 0, where t modulo 1 jumps; the instant is met but for the last bit."""
    system = mass_point(sp.Mod(t, 1) - sp.floor(2 * x) / 3, x**2)
    start = {x: 1, Dx: sp.Rational(1, 2)}
    run = vo.integrate(system, initial=start, times=[0, 7.3], method="flint")
    end = {x: run["x"][-1], Dx: run["xdot"][-1]}
    back = vo.integrate(system, initial=end, times=[7.3, 0], method="flint")
    assert float(back["x"][-1]) == pytest.approx(1, abs=1e-9)
    assert float(back["xdot"][-1]) == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_an_integral_that_jumps_with_friction_is_told_of(method):
    """Of each half of a swing it is one; at both ends, where nothing moves, it has other values."""
    swing = vo.System(
        name="swing", fibration=vo.Fibration(x), lagrangian=(Dx**2 - x**2) / 2,
        forces={x: -sp.sign(Dx)}, integrals={"half": Dx**2 + (x + sp.sign(Dx)) ** 2},
    )  # fmt: skip
    given = {"method": method, "tol": PRECISION.get(method, 1e-13)}
    for times in ([0, 8], [0, 1, 4, 8], np.linspace(0, 8, 31)):
        run = vo.integrate(swing, initial={x: 4, Dx: 0}, times=times, **given)
        (note,) = run.notes
        assert "'half' jumps with the forces, and drifts" in note
        assert ("by 16," if len(times) == 2 else "by 7,") in note
    assert not vo.integrate(swing, initial={x: 3, Dx: -1}, times=[1, 2, 3], **given).notes


@pytest.mark.parametrize("method", METHODS)
def test_an_event_whose_function_jumps_through_zero_happens_there(method):
    swing = mass_point(potential=x**2 / 2)
    events = (
        vo.Event(sp.sign(x), "side"), vo.Event(sp.Heaviside(x) - 0.5, "up", direction=1),
        vo.Event(Dx * sp.sign(x), "both"), vo.Event(sp.sign(x) + 2, "never"),
    )  # fmt: skip
    run = vo.integrate(
        swing, initial={x: 1, Dx: 0}, times=[0, 10], method=method, events=events,
        tol=PRECISION.get(method, 1e-13),
    )  # fmt: skip
    passages = np.pi * (np.arange(3) + 0.5)
    error = ERROR.get(method, 1e-10)
    assert run.events["side"].t.astype(float) == pytest.approx(passages, abs=max(error, 1e-14))
    assert run.events["up"].t.astype(float) == pytest.approx(passages[1:2], abs=1e-8)
    assert len(run.events["both"].t) == 6 and len(run.events["never"].t) == 0
    back = vo.integrate(
        swing, initial={x: 1, Dx: 0}, times=[0, -10], method=method, events=events[:2],
        tol=PRECISION.get(method, 1e-13),
    )  # fmt: skip
    assert len(back.events["side"].t) == 3 and len(back.events["up"].t) == 2


def by_small_steps(rate, start, end):
    """DOP853 in steps so short that a corner in one costs little: nothing of the engine."""
    return solve_ivp(
        lambda s, z: (z[1], rate(s, z[0])), (0, end), start, method="DOP853", rtol=1e-11,
        atol=1e-11, max_step=2e-3,
    ).y[0, -1]  # fmt: skip


@cache
def pulled_by_small_steps(pull):
    """The end of a motion from x = 1, xdot = 2 after a time of 5; once for all methods."""
    return by_small_steps(lambda s, z: -pull(s, z), (1, 2), 5)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
@pytest.mark.parametrize(
    ("force", "potential"),
    [
        (0, lambda u: sp.Abs(u)),
        (lambda u: -u / sp.sqrt(u**2), 0),
        (lambda u: -(sp.atan(u) + sp.atan(1 / u)) * 2 / sp.pi, 0),
        (0, lambda u: sp.Piecewise((u, u > 0), (-u, True))),
    ],
)
def test_what_is_constant_in_pieces_is_no_constant(force, potential, method):
    # cos(7 t) is too far a multiple for a normal form, and what cancels is looked for in stages
    u = x - t / 2
    made = mass_point((force(u) if force else 0) + sp.cos(7 * t), potential(u) if potential else 0)
    found = float(motion(made, (1, 0), 3, method)["x"][-1])
    assert found == pytest.approx(
        by_small_steps(lambda s, z: np.cos(7 * s) - np.sign(z - s / 2), (1, 0), 3), abs=1e-4
    )
    plain = motion(mass_point(sp.cos(7 * t) - sp.sign(u)), (1, 0), 3, method)
    assert found == pytest.approx(float(plain["x"][-1]), abs=1e-9)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
@pytest.mark.parametrize(
    ("force", "rate"),
    [
        (sp.asin(sp.sin(2 * x)), lambda s, z: np.arcsin(np.sin(2 * z))),
        (sp.acos(sp.cos(x)), lambda s, z: np.arccos(np.cos(z))),
        (sp.acos(sp.cos(2 * x)) * sp.sin(x), lambda s, z: np.arccos(np.cos(2 * z)) * np.sin(z)),
        (3 * sp.asin(sp.sin(3 * t)), lambda s, z: 3 * np.arcsin(np.sin(3 * s))),
        (sp.asin(2 * x / (1 + x**2)), lambda s, z: np.arcsin(2 * z / (1 + z**2))),
        (sp.asin(sp.sin(x + 1)), lambda s, z: np.arcsin(np.sin(z + 1))),
        (sp.acos(sp.cos(t - 2 * x)), lambda s, z: np.arccos(np.cos(s - 2 * z))),
        (sp.asin(sp.Abs(sp.sin(x))), lambda s, z: np.arcsin(np.abs(np.sin(z)))),
        (sp.acosh(1 + x**2), lambda s, z: np.arccosh(1 + z**2)),
        (sp.acosh(sp.cosh(x)), lambda s, z: abs(z)),
        (sp.atan(sp.tan(x)), lambda s, z: np.arctan(np.tan(z))),
        (sp.atan((x - 3) / (x - 4)), lambda s, z: np.arctan((z - 3) / (z - 4))),
        (sp.acot(x - 2), lambda s, z: np.arctan(1 / (z - 2))),
        (x * sp.atan((x - 4) ** -2), lambda s, z: z * np.arctan((z - 4) ** -2)),
    ],
)
def test_inverse_functions_have_their_corners_and_jumps(force, rate, method):
    found = float(motion(mass_point(-force), (1, 2), 5, method)["x"][-1])
    truth = pulled_by_small_steps(rate)
    assert found == pytest.approx(truth, abs=1e-5)
    if method != "scipy":
        assert found == pytest.approx(
            float(motion(mass_point(-force), (1, 2), 5, "scipy")["x"][-1]), abs=1e-10
        )


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_the_edge_of_an_inverse_function_is_said(method):
    """acos(1 - |x|) is as steep as sqrt(|x|) there."""
    with pytest.raises(IntegrationError, match=r"not determined|collapsed"):
        motion(mass_point(-sp.acos(1 - sp.Abs(x))), (1, 2), 5, method)


def test_an_arctangent_without_a_jump_is_no_switch():
    bounded = (
        sp.atan(sp.sin(x) / (2 + sp.cos(x))) + sp.atan(x / (1 + x**2)) + sp.asin(sp.sin(x) / 2)
    )
    assert motion(mass_point(-bounded), (1, 2), 5, "scipy").cost.switches == 0


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_window_narrower_than_rounding_of_a_square_is_seen(method):
    # the square of 10^9 x is under 1 for 5e-11 units of time, which moves x by no more
    force = -x + sp.Min(1, 10**18 * x**2)
    found = motion(mass_point(force), (40, 0), 6, method)
    assert found["x"][-1] == pytest.approx(1 + 39 * np.cos(6), abs=1e-9)
    assert found.cost.switches == 4
    many = vo.ensemble(
        mass_point(force - sp.sign(Dx) / 5), starts=[{x: 3, Dx: 2}, {x: 4, Dx: 1}], times=[0, 6],
        method=method,
    )  # fmt: skip
    one = motion(mass_point(force - sp.sign(Dx) / 5), (3, 2), 6, "scipy")
    assert many["x"][0, -1] == pytest.approx(float(one["x"][-1]), abs=1e-9)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
@pytest.mark.parametrize(
    ("root", "pull", "speed"),
    [
        (sp.sqrt(1 - sp.sin(x)), -x / 4, 3),
        (sp.sqrt(3 - 3 * sp.sin(2 * x + 1)), -x / 4, 3),
        (sp.sqrt(1 - sp.sin(9 * x)), -x / 9, 2),
        (sp.sqrt(1 + sp.cos(x)), sp.cos(9 * x) - x / 4, 3),
    ],
)
def test_one_less_a_sine_has_its_corners_where_the_sine_is_one(root, pull, speed, method):
    """The energy is kept, with the work of the root by quadrature between its corners."""
    end = motion(mass_point(root + pull), (1.5, speed), 40, method)
    place, rate = float(end["x"][-1]), float(end["xdot"][-1])
    f, sides = sp.lambdify(x, root, "mpmath"), sorted((1.5, place))
    # corners of all four are odd multiples of pi/36, or places of (pi/2 - 1)/2 + k pi
    zeros = {k * mp.pi / 36 for k in range(-99, 400)}
    zeros |= {(mp.pi / 2 - 1) / 2 + k * mp.pi for k in range(-9, 12)}
    inner = sorted(z for z in zeros if sides[0] < z < sides[1])
    work = mp.quad(f, [sides[0], *inner, sides[1]]) * (1 if place > 1.5 else -1)
    gained = sp.integrate(pull, x).subs(x, place) - sp.integrate(pull, x).subs(x, 1.5)
    assert abs(rate**2 / 2 - speed**2 / 2 - work - float(gained)) < 1e-11


def test_a_section_of_a_motion_that_friction_holds_ends():
    """From 1 the body turns at 4/5, 3/5, ..., then stays at 0: what comes no more is not waited for
    up to t = 1e12 in small steps."""
    dry = vo.System(
        name="dry",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=(Dx**2 - x**2) / 2,
        forces={x: -sp.sign(Dx) / 10},
    )
    turns = vo.section(dry, "xdot", initial={x: 1}, crossings=6, direction=0, outputs=("x",))
    assert np.abs(turns["x"] - [-0.8, 0.6, -0.4, 0.2, 0]).max() < 1e-12
    assert np.abs(turns.t - np.pi * np.arange(1, 6)).max() < 1e-12
    with pytest.raises(DefinitionError, match=r"no motion passes through x = 10 upwards"):
        vo.section(dry, "x", value=10, initial={x: 1})


@pytest.mark.parametrize("tol", [0, -1, 2])
def test_a_tolerance_that_is_none_is_refused_with_friction_too(tol):
    rubbed = mass_point(-x - sp.sign(Dx) / 10)
    for call in (
        lambda: vo.integrate(rubbed, initial={x: 1}, times=[0, 1], tol=tol),
        lambda: vo.section(rubbed, "x", initial={x: 1}, tol=tol),
        lambda: vo.ensemble(rubbed, {x: [1.0]}, {}, [0, 1], tol=tol),
    ):
        with pytest.raises(DefinitionError, match="between 0 and 1"):
            call()


def test_many_motions_are_no_finer_than_doubles(recwarn):
    """heyoka's series would only grow, and take minutes."""
    for force in (-x - sp.sign(Dx) / 10, -x - Dx / 10):
        found = vo.section(mass_point(force), "x", initial={x: 1}, crossings=20, tol=1e-320)
        assert len(found["x"]) > 1 and found.cost.tolerance >= 1e-16
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]


def test_a_switch_on_which_the_equations_are_0_over_0_is_passed_in_many_digits():
    """An angle acos(x/r) is |y|/r beside y = 0; there its slope is none."""
    point = vo.System(
        "point", vo.Fibration(base=(x, y)),
        lagrangian=(Dx**2 + Dy**2) / 2 - sp.acos(x / sp.sqrt(x**2 + y**2)),
    )  # fmt: skip
    asked = {"times": [0, 0.1, 2], "initial": {x: 2, y: 1, Dy: -1}}
    digits, doubles = vo.integrate(point, tol=1e-25, **asked), vo.integrate(point, **asked)
    for name in ("x", "y"):
        assert digits[name].astype(float) == pytest.approx(doubles[name], abs=1e-12)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("corner", [0, -3])
def test_a_load_that_sets_in_leads_away_from_a_corner_at_rest(method, corner):
    """x'' = -k x + a s from rest, s = t - 1, with k > 0 on one side, 0 or 1 on the other: beside
    the corner the way is a s^3/6, less than the rounding of a step's dense output."""
    z, late = x - corner, sp.Max(0, t - 1)
    pulls = sp.Piecewise((-z, z < 0), (-4 * z, True))
    sine = float(1 - mp.sin(1))
    cases = (
        (pulls + late, float(1 - mp.sin(2) / 2) / 4), (pulls - late, -sine),
        (-abs(z) + late, sine), (-abs(z) - late, float(1 - mp.sinh(1))),
        (-sp.Max(z, 0) + late, sine), (-sp.Max(z, 0) - late, -1 / 6),
    )  # fmt: skip
    for force, way in cases:
        found = motion(mass_point(force), (corner, 0), 2, method)
        assert abs(float(found["x"][-1]) - corner - way) < max(error(method), 1e-15), force


@pytest.mark.parametrize("method", [*METHODS, *COMPILED])
def test_a_table_that_sets_in_leads_away_from_a_corner_at_rest(method):
    pulls = sp.Piecewise((-x, x < 0), (-4 * x, True))
    pushed = vo.System(
        "pushed", vo.Fibration(base=(x,)), lagrangian=Dx**2 / 2, forces={x: pulls + y}, inputs=(y,)
    )
    ramp = {y: vo.Table([0, 1, 2], [0, 0, 1], "linear")}
    found = motion(pushed, (0, 0), 2, method, inputs=ramp)
    assert abs(float(found["x"][-1]) - float(1 - mp.sin(2) / 2) / 4) < max(error(method), 1e-15)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "lsoda"])
def test_an_integral_that_jumps_is_told_of_where_a_frame_fails(method):
    """A skate turns through a right angle, where ydot = xdot tan(theta) ends, until friction stops
    it after 8 units of time: the integral is 1 before, and 0 from there on."""
    theta = sp.Symbol("theta")
    turn = vo.velocity(theta)
    skate = vo.System(
        "skate", vo.Fibration(base=(x, theta), fibre=(y,)),
        lagrangian=(Dx**2 + Dy**2 + turn**2) / 2,
        constraints=(Dx * sp.sin(theta) - Dy * sp.cos(theta),),
        forces={theta: -sp.sign(turn) / 8},
        integrals={"work": turn**2 + theta * sp.sign(turn) / 4},
    )  # fmt: skip
    start = {x: 0, y: 0, theta: 0, Dx: 1, turn: 1}
    run = vo.integrate(skate, initial=start, times=[0, 4, 9, 12], method=method, tol=1e-12)
    assert np.abs(run["work"] - [1, 1, 0, 0]).max() < 1e-9
    (note,) = run.notes
    assert "'work' jumps with the forces, and drifts" in note and "changed by 1," in note


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_ensembles_and_sections_tell_of_integrals_that_are_not_kept_with_friction(method):
    swing = vo.System(
        name="swing", fibration=vo.Fibration(x), lagrangian=(Dx**2 - x**2) / 2,
        forces={x: -sp.sign(Dx) / 8},
        integrals={"half": Dx**2 + (x + sp.sign(Dx) / 8) ** 2, "energy": Dx**2 + x**2},
    )  # fmt: skip
    both = vo.ensemble(swing, {x: [3, 4], Dx: [-1, 0]}, times=[0, 1, 4, 8], method=method)
    starts = {x: [3, 4], Dx: [-1, -1]}
    some = vo.section(swing, x, starts=starts, crossings=3, until=20, method=method)
    for many in (both, some):
        assert len(many.notes) == 2 and not many.errors
        for notes in many.notes.values():
            told = "".join(notes)
            assert len(notes) == 2 and "'energy' is only claimed, and drifts" in told
            assert "'half' jumps with the forces, and drifts" in told
