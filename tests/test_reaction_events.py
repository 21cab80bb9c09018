"""Reactions as functions of the state: where a body leaves its surface, slips, or is pressed."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

import voronec as vo

r, theta, psi, m, g, a = sp.symbols("r theta psi m g a")
Dr, Dtheta, Dpsi = map(vo.velocity, (r, theta, psi))
BEAD_ENERGY = m * (Dr**2 + r**2 * Dtheta**2) / 2
HEIGHT = m * g * r * sp.cos(theta)
GIVEN = {m: 2, g: 9.81}
TOP = {theta: 0.01, r: 1}


def make_bead(**more) -> vo.System:
    return vo.System(
        name="bead",
        fibration=vo.Fibration(base=(theta,), fibre=(r,)),
        lagrangian=BEAD_ENERGY - HEIGHT,
        constraints=(Dr,),
        parameters=(m, g),
        **more,
    )


BEAD = make_bead()
BALL = vo.System(
    name="ball on a sphere",
    fibration=vo.Fibration(base=(theta,), fibre=(r, psi)),
    lagrangian=BEAD_ENERGY + m * a**2 * Dpsi**2 / 5 - HEIGHT,
    constraints=(Dr, r * Dtheta - a * Dpsi),
    parameters=(m, g, a),
)
LEAVE = vo.Event("reaction 1", stop=True)


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c"])
def test_a_bead_leaves_the_sphere_at_two_thirds_of_its_height(method: str) -> None:
    run = vo.integrate(
        BEAD, times=[0, 20], initial=TOP, parameters=GIVEN, events=LEAVE, method=method
    )
    assert run.stopped == "reaction 1"
    assert abs(np.cos(run["theta"][-1]) - 2 / 3 * np.cos(0.01)) < 1e-12


def test_it_does_so_in_many_digits() -> None:
    run = vo.integrate(
        BEAD, times=[0, 20], initial={theta: sp.Rational(1, 2), r: 1}, parameters={m: 2, g: 10},
        events=LEAVE, tol=1e-40,
    )  # fmt: skip
    with mp.workdps(45):
        assert abs(mp.cos(run["theta"][-1]) - mp.cos(mp.mpf(1) / 2) * 2 / 3) < 1e-38


def test_a_ball_rolls_down_to_ten_seventeenths_but_slips_before() -> None:
    given = {"times": [0, 20], "initial": TOP, "parameters": {**GIVEN, a: 0.2}}
    run = vo.integrate(BALL, events=LEAVE, **given)
    assert abs(np.cos(run["theta"][-1]) - 10 / 17 * np.cos(0.01)) < 1e-12
    slip = vo.Event("reaction_2 + reaction 1 / 10", name="slip", stop=True)
    names = ("reaction 1", "reaction 2", "reaction_2 / m")
    run = vo.integrate(BALL, events=slip, outputs=names, **given)
    normal, friction, share = (run[name] for name in run.outputs)
    assert run.stopped == "slip" and run.outputs[:2] == names[:2]
    assert abs(friction[-1] + normal[-1] / 10) < 1e-12
    assert np.abs(share - friction / 2).max() < 1e-12


def test_where_a_reaction_has_a_value_there_is_a_section() -> None:
    given = {"parameters": {m: 2, g: 1}, "outputs": ("theta", "thetadot", "reaction 1")}
    starts = [{theta: 2.5, r: 1}, {theta: 2.4, r: 1}]
    found = vo.section(BEAD, "reaction 1", value=-2, starts=starts, crossings=3, **given)
    assert len(found["theta"]) == 6
    assert np.abs(found["reaction 1"] + 2).max() < 1e-9
    assert np.abs(2 * (np.cos(found["theta"]) - found["thetadot"] ** 2) + 2).max() < 1e-9
    many = vo.ensemble(BEAD, starts=starts, times=[0, 1], **given)
    alone = vo.integrate(BEAD, times=[0, 1], initial=starts[1], **given)
    assert np.abs(many["reaction 1"][1] - alone["reaction 1"]).max() < 1e-9


@pytest.mark.slow
def test_in_charts_and_for_all_multipliers_of_demchenkos_ball() -> None:
    """Its equations have charts, and as many constraints as free velocities."""
    ball = vo.load("demchenko")
    run = vo.integrate(
        ball, times=np.linspace(0, 3, 301), outputs=("reaction 1",), events=["reaction 1"]
    )
    found = run.events["reaction 1"]
    assert np.count_nonzero(np.diff(np.sign(run["reaction 1"]))) == len(found) > 2
    assert np.abs(found["reaction 1"]).max() < 1e-11


def test_what_friction_holds_has_no_known_reaction() -> None:
    rough = make_bead(forces={theta: -10 * m * g * sp.sign(Dtheta)})
    given = {"initial": {theta: 1, r: 1, Dtheta: 0.1}, "parameters": GIVEN}
    with pytest.raises(vo.DefinitionError, match="reactions are not known while friction holds"):
        vo.integrate(rough, times=[0, 5], events="reaction 1", outputs=("theta",), **given)
    with pytest.raises(vo.DefinitionError, match="ask for them of single motions, by integrate"):
        vo.ensemble(rough, starts=[TOP], times=[0, 1], outputs=("reaction 1",), parameters=GIVEN)


@pytest.mark.parametrize(
    ("event", "words"),
    [
        ("reaction 3", "no output 'reaction 3'; did you mean 'reaction 1'"),
        ("reaction_3 - 1", "contains 'reaction_3'; did you mean 'reaction_1'"),
        ("configuration", "'configuration' stands for several quantities, where events"),
    ],
)
def test_other_names_are_refused(event: str, words: str) -> None:
    with pytest.raises(vo.DefinitionError, match=words):
        vo.integrate(BEAD, times=[0, 1], initial=TOP, parameters=GIVEN, events=event)


def test_a_name_that_the_system_has_given_stays_its_own() -> None:
    own = sp.Symbol("reaction_1")
    system = vo.System(
        name="own", fibration=vo.Fibration(base=(theta,), fibre=(r,)),
        lagrangian=Dr**2 / 2 + r**2 * Dtheta**2 / 2, constraints=(Dr,),
        parameters=(vo.Parameter(own, 3),),
    )  # fmt: skip
    start = {theta: 0, r: 1, Dtheta: 1}
    run = vo.integrate(system, times=[0, 2], initial=start, events="theta*reaction_1 - 3",
                       outputs=("reaction 1", "2*reaction_1"))  # fmt: skip
    assert abs(run.events["reaction_1*theta - 3"].t[0] - 1) < 1e-12
    assert abs(run["reaction 1"][0] + 1) < 1e-12 and run[2 * own][0] == 6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["bicycle", "torus-on-ellipsoid"])
def test_reactions_that_are_too_long_are_refused_at_once(name: str) -> None:
    with pytest.raises(vo.EngineLimit, match="too long for formulas, events and sections; ask for"):
        vo.integrate(vo.load(name), times=[0, 1], events="reaction 1")


@pytest.mark.filterwarnings("error")
def test_where_a_skate_on_a_slope_is_not_pressed_aside_in_all_splits() -> None:
    """The fibre fails where cos(phi) vanishes, and the run goes on in other velocities."""
    x, y, phi = sp.symbols("x y phi")
    dx, dy, dphi = map(vo.velocity, (x, y, phi))
    skate = vo.System(
        name="skate",
        fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=dx**2 + dy**2 + 3 * dphi**2 / 2 - x,
        constraints=(dx * sp.sin(phi) - dy * sp.cos(phi),),
    )
    run = vo.integrate(
        skate, times=np.linspace(0, 9, 901), initial={phi: 0.3, dphi: 1, dx: 0.2},
        events="reaction 1", outputs=("reaction 1", phi),
    )  # fmt: skip
    found = run.events["reaction 1"]
    assert np.abs(found["reaction 1"]).max() < 1e-12
    assert np.count_nonzero(np.diff(np.sign(run["reaction 1"]))) == len(found) == 4


def test_on_a_hoop_that_grows_the_reaction_bears_its_acceleration() -> None:
    t = vo.time
    hoop = vo.System(
        name="hoop",
        fibration=vo.Fibration(base=(theta,), fibre=(r,)),
        lagrangian=(Dr**2 + r**2 * Dtheta**2) / 2 - 9 * r * sp.cos(theta),
        constraints=(Dr - t * sp.sin(t) / 10,),
    )
    run = vo.integrate(
        hoop, times=[0, 2], initial={theta: 0.5, r: 1}, events="reaction 1",
        outputs=("r", "theta", "thetadot"),
    )  # fmt: skip
    found = run.events["reaction 1"]
    outward = (np.sin(found.t) + found.t * np.cos(found.t)) / 10
    pressure = outward - found["r"] * found["thetadot"] ** 2 + 9 * np.cos(found["theta"])
    assert len(found) == 2 and np.abs(pressure).max() < 1e-12
