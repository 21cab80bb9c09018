"""Starts at poles of several sets of angles at once, declared charts among them."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from rotations import euler
from test_flow_poles import turning

import voronec as vo
from voronec.equations.attitudes import angles_without_chart, with_attitude_charts
from voronec.equations.motions import Motions
from voronec.proof.relations.charts import check_charts

pytestmark = pytest.mark.slow

FIRST, SECOND = sp.symbols("phi theta psi"), sp.symbols("alpha beta chi")
u, v = sp.symbols("u v")
SPINS = sp.symbols("omega1:4"), sp.symbols("W1:4")
INERTIA = (1.0, 2.0, 2.5), (1.5, 1.0, 2.0)


def body(angles: tuple[sp.Symbol, ...], inertia: tuple[float, ...]) -> tuple[list, sp.Expr]:
    """The angular velocity of a free body along its axes, and its kinetic energy."""
    rates = list(vo.kinematics.Rotation.euler("zxz", *angles).body_rates)
    moments = map(sp.nsimplify, inertia)
    return rates, sum(i * w**2 for i, w in zip(moments, rates, strict=True)) / 2


def free(inertia: tuple[float, ...]):
    """Euler's equations."""
    moments = np.array(inertia)
    return lambda _, omega: np.cross(moments * omega, omega) / moments


def two_bodies() -> vo.System:
    rates, kinetic = zip(*map(body, (FIRST, SECOND), INERTIA), strict=True)
    named = {
        w: e
        for names, own in zip(SPINS, rates, strict=True)
        for w, e in zip(names, own, strict=True)
    }
    return vo.System(
        name="bodies",
        fibration=vo.Fibration(base=(*FIRST, *SECOND)),
        frame=vo.Frame.quasi(named),
        lagrangian=sum(kinetic),
    )


def body_and_point() -> vo.System:
    """A free body, and a point on a sphere, whose chart lays the polar axis down."""
    _, kinetic = body(FIRST, INERTIA[0])
    du, dv = map(vo.velocity, (u, v))
    across = sp.sqrt(sp.sin(u) ** 2 * sp.sin(v) ** 2 + sp.cos(u) ** 2)
    there = {
        u: sp.atan2(across, sp.sin(u) * sp.cos(v)),
        v: sp.atan2(-sp.sin(u) * sp.sin(v), sp.cos(u)),
    }
    return vo.System(
        name="body-and-point",
        fibration=vo.Fibration(base=(*FIRST, u, v)),
        lagrangian=kinetic + (du**2 + sp.sin(u) ** 2 * dv**2) / 2,
        charts={"axis laid down": vo.Chart(state=there, singular=sp.sin(u))},
    )


@pytest.fixture(scope="module")
def pair() -> vo.VoronecEquations:
    return vo.derive(two_bodies())


@pytest.fixture(scope="module")
def mixed() -> vo.VoronecEquations:
    return vo.derive(body_and_point())


@pytest.mark.parametrize("places", [(-1e-8, 1e-8), (-1e-10, -1e-8), (3e-6, -1e-6)])
def test_angles_near_two_poles_keep_their_sides(
    pair: vo.VoronecEquations, places: tuple[float, float]
) -> None:
    start = {
        "theta": places[0], "beta": places[1], "phi": 0.3, "psi": 0.2, "alpha": -0.4, "chi": 1.0,
        "omega1": 0.5, "omega2": 0.7, "omega3": 0.4, "W1": 0.6, "W2": -0.3, "W3": 0.2,
    }  # fmt: skip
    found, exact = (
        vo.integrate(pair, initial=start, times=[0, 1], tol=tol) for tol in (1e-13, 1e-18)
    )
    for name in map(str, (*FIRST, *SECOND)):
        # at 1e-10 from a pole the side is known, and the angles to six digits
        assert float(exact[name][-1]) == pytest.approx(found[name][-1], abs=1e-6), name


@pytest.mark.parametrize("places", [(3e-8, 3e-8), (1e-9, 3e-8), (np.pi - 3e-7, 3e-7)])
def test_a_ball_near_poles_of_both_spheres_turns_as_in_closed_form(
    places: tuple[float, float],
) -> None:
    start = {"u": places[0], "u1": places[1], "s": -0.5, "tau": 0.3, "n": 0.4}
    found, exact = (
        vo.integrate(vo.load("demchenko"), initial=start, times=[0, 2], method=method)
        for method in ("auto", "closed-form")
    )
    for name in ("u", "v", "theta", "u1", "v1"):
        assert found[name][-1] == pytest.approx(exact[name][-1], abs=1e-6), name


@pytest.mark.parametrize("places", [(0.0, 0.0), (0.0, np.pi), (np.pi, 1e-9), (1e-4, 0.0)])
def test_two_bodies_start_at_poles_at_once(
    pair: vo.VoronecEquations, places: tuple[float, float]
) -> None:
    times, starts = np.linspace(0, 2, 9), ((0.3, places[0], 0.2), (-0.4, places[1], 0.1))
    spins = ((0.5, -0.4, 0.3), (-0.2, 0.6, 0.4))
    start = {}
    for names, own, angles, spin in zip(SPINS, (FIRST, SECOND), starts, spins, strict=True):
        start |= {str(n): x for n, x in zip((*own, *names), (*angles, *spin), strict=True)}
    motion = vo.integrate(pair, times=times, initial=start)
    for names, own, angles, spin, inertia in zip(
        SPINS, (FIRST, SECOND), starts, spins, INERTIA, strict=True
    ):
        truth, rates = turning(free(inertia), euler(*angles), spin, times)
        found = np.array([euler(*row) for row in np.transpose([motion[str(q)] for q in own])])
        assert np.abs(found - truth).max() < 1e-10
        assert np.abs(np.transpose([motion[str(n)] for n in names]) - rates).max() < 1e-10
        # of two angles that are free at a pole each keeps its value there
        assert [float(motion[str(q)][0]) for q in own] == list(angles)


@pytest.mark.parametrize("place", [(0.0, 1.0), (0.0, 1e-6), (1.0, 1e-6), (np.pi, 0.0)])
def test_angles_of_a_body_have_charts_beside_declared_ones(
    mixed: vo.VoronecEquations, place: tuple[float, float]
) -> None:
    theta, polar = place
    times, (a, b, c) = np.linspace(0, 2, 9), (0.4, 0.3, 0.5)
    start = {"phi": 0.3, "theta": theta, "psi": 0.2, "u": polar, "v": 0.7, "udot": 0.6}
    start |= {"phidot": a, "thetadot": b, "psidot": c}
    s = a * np.sin(theta)
    spin = (b * np.cos(0.2) + s * np.sin(0.2), s * np.cos(0.2) - b * np.sin(0.2))
    spin += (c + a * np.cos(theta),)
    motion = vo.integrate(mixed, times=times, initial=start)
    truth, _ = turning(free(INERTIA[0]), euler(0.3, theta, 0.2), spin, times)
    found = [euler(*row) for row in np.transpose([motion[str(q)] for q in FIRST])]
    assert np.abs(np.array(found) - truth).max() < 1e-10
    # the point goes along the meridian
    across, along = np.sin(motion["u"]) * np.cos(motion["v"] - 0.7), np.cos(motion["u"])
    assert np.abs(across - np.sin(polar + 0.6 * times)).max() < 1e-10
    assert np.abs(along - np.cos(polar + 0.6 * times)).max() < 1e-10


def test_charts_of_both_kinds_are_proved(mixed: vo.VoronecEquations) -> None:
    assert [str(t.theta) for t in angles_without_chart(mixed)] == ["theta"]
    charted = with_attitude_charts(mixed)
    assert charted is not None and not angles_without_chart(charted)
    verdicts = {c.name: c.verdict for c in check_charts(Motions(charted))}
    assert len(verdicts) == 3
    assert all(verdict.proved for verdict in verdicts.values()), verdicts


@pytest.mark.parametrize("off", [1e-12, -1e-11, 1e-9])
def test_rates_that_are_infinite_at_a_pole_tell_no_units(off: float) -> None:
    """The centre of a homogeneous ball goes straight on, and evenly."""
    start = {"u": off, "v": 0.208, "theta": 0.275, "x": -0.29, "y": -0.698}
    start |= {"omega1": 0.663, "omega2": -0.282, "omega3": -0.26}
    run = vo.integrate(
        vo.load("homogeneous-ball"), initial=start, times=[0, 0.5, 1],
        method="heyoka",
    )  # fmt: skip
    for name in ("x", "y"):
        assert run[name][2] - run[name][1] == pytest.approx(run[name][1] - run[name][0], abs=1e-13)


def test_a_pole_that_doubles_miss_is_one() -> None:
    """sin(pi) is 1e-16: the motion went off in some direction, without a word, while the invariants
    went another way.  Along them: gamma' = R1 (R1 + H)^-1 (gamma x omega) at the start."""
    body = vo.load("ellipsoid-on-sphere")
    start = {"phi": -0.2, "theta": 1.1, "psi": 0.2, "u": np.pi, "v": 0.0, "p": 0.8}
    start |= {"omega1": 0.6, "omega2": 0.9, "omega3": -0.15}
    run = vo.integrate(body, initial=start, times=[0, 1e-4], outputs=("u", "v"))
    # gamma = -e3, and H = S/h across it
    S = np.array([1.0, 1.44])
    turned = 2 / (2 + S / 0.8) * np.array([0.9, -0.6])
    u, v = run["u"][-1], run["v"][-1]
    went = np.sin(u) * np.array([np.cos(v), np.sin(v)]) / 1e-4
    assert went == pytest.approx(turned, abs=1e-3)


def test_steps_are_counted_where_the_coordinates_are_regular():
    """In those that are singular at the start steps are short beyond all measure, and the method
    would be one for long runs."""
    system = vo.derive(vo.load("gyroscopic-spheroid-on-sphere"))
    start = {"chi": 1, "u": sp.pi, "u1": 1, "omega1": "0.3", "omega2": "-0.4", "omega3": "0.5"}
    found = vo.integrate(system, initial=start, times=[0, 1], outputs=("u",))
    assert found.cost.method == "scipy" and "less time than compiling" in found.cost.reason
    again = vo.integrate(system, initial=start, times=[0, 1], outputs=("u",), method="heyoka")
    assert found["u"][-1] == pytest.approx(again["u"][-1], abs=1e-11)


def test_relations_of_other_coordinates_leave_a_chart_to_be_proved():
    """A unit vector beside the angles: it binds none of them, and their images jump nowhere."""
    charted = with_attitude_charts(vo.derive(vo.load("bychkov-ball")))
    assert charted is not None and charted.definition.relations
    (found,) = check_charts(Motions(charted))
    assert found.verdict.proved
