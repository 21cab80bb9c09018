"""Motions that begin on the axis of polar coordinates, or pass through it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import voronec as vo
from voronec.equations.motions import Motions
from voronec.proof.relations.charts import check_charts

pytestmark = pytest.mark.slow

r, phi, x, y, v, w = sp.symbols("r phi x y v w")
k, c, R, g = np.sqrt(2 / 7), 1.0, 0.2, 1.0
"""Those of the ball's own scene."""


@pytest.fixture(scope="module")
def ball() -> vo.VoronecEquations:
    return vo.derive(vo.load("ball-on-paraboloid"))


def on_the_paraboloid(spin: float) -> Callable[[float, np.ndarray], list[float]]:
    """Rates of (r, r', phi) of a ball that has been at the vertex with this spin, by its two
    integrals: s and r^2 phi' are functions of r, and the energy along the meridian is left."""

    def moment(r: float) -> float:  # r phi'
        if r < 1e-3:
            return -k * k * R * spin * c * r / 2
        return float(-k * R * spin * np.sinh(k * np.log(1 + c * c * r * r) / 2) / (c * r))

    def height(r: float) -> float:
        """The energy of all but r', over m/2 and the factor of r'^2."""
        s = spin * np.cosh(k * np.log(1 + c * c * r * r) / 2)
        beside = (moment(r) ** 2 + k * k * R * R * s * s) / (1 - k * k) + g * c * r * r
        return float(beside * (1 - k * k))

    def rates(_: float, state: np.ndarray) -> list[float]:
        r, pace, _ = state
        q, step = 1 + c * c * r * r, 1e-5
        slope = (height(abs(r + step)) - height(abs(r - step))) / (2 * step)
        return [pace, -(slope / 2 + c * c * r * pace**2) / q, moment(abs(r)) / max(abs(r), 1e-300)]

    return rates


@pytest.mark.parametrize("pace", [0.3, -0.9])
def test_a_ball_leaves_the_vertex(ball: vo.VoronecEquations, pace: float) -> None:
    start = {"r": 0, "phi": 0.4, "alpha": 0.8, "beta": 0.6, "v": pace, "w": 5, "s": -0.7}
    motion = vo.integrate(ball, times=[0, 1e-3, 0.7], initial=start)
    assert any("'w' has no meaning there" in note for note in motion.notes)
    found = solve_ivp(
        on_the_paraboloid(-0.7), (0, 0.7), [0.0, abs(pace), 0.4 + np.pi * (pace < 0)],
        rtol=1e-11, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    assert motion["r"][-1] == pytest.approx(found[0], abs=1e-8)
    assert motion["v"][-1] == pytest.approx(found[1], abs=1e-8)
    assert np.exp(1j * motion["phi"][-1]) == pytest.approx(np.exp(1j * found[2]), abs=1e-8)
    assert motion["w"][1] == pytest.approx(k * k * R * 0.7 * c / 2, rel=1e-4)
    assert max(motion.drift.values()) < 1e-11


@pytest.mark.parametrize("name", ["the chart becomes singular", "quadrant of an angle 0"])
def test_an_event_may_be_called_as_what_a_run_watches(ball: vo.VoronecEquations, name: str) -> None:
    start = {"r": 0, "phi": 0.4, "alpha": 0.8, "beta": 0.6, "v": 0.3, "w": 5, "s": -0.7}
    times = [0, 1e-3, 0.7]
    stop = vo.Event(sp.Symbol("r") - sp.Rational(1, 100), name, stop=True)
    motion = vo.integrate(ball, times=times, initial=start, events=(stop,))
    assert motion.stopped == name and motion["r"][-1] == pytest.approx(0.01, abs=1e-12)
    assert [len(passages) for passages in motion.events.values()] == [1]


def test_a_ball_without_spin_passes_through_the_vertex(ball: vo.VoronecEquations) -> None:
    start = {"r": 0.5, "phi": 0.4, "alpha": 0.8, "beta": 0.6, "v": -0.6, "w": 0, "s": 0}
    motion = vo.integrate(ball, times=np.linspace(0, 2, 41), initial=start, outputs=("r", "phi"))
    found = solve_ivp(
        on_the_paraboloid(0.0), (0, 2), [0.5, -0.6, 0], t_eval=motion.t, rtol=1e-11, atol=1e-12
    ).y[0]
    assert found.min() < -0.1
    place = motion["r"] * np.exp(1j * (motion["phi"] - 0.4))
    assert place == pytest.approx(found, abs=1e-8)


def polar_oscillator() -> vo.System:
    """A particle on a spring in polar coordinates, under a constant force along y."""
    dr, dphi = vo.velocity(r), vo.velocity(phi)
    lagrangian = (dr**2 + r**2 * dphi**2) / 2 - r**2 / 2 + r * sp.sin(phi) / 5
    frame = vo.Frame.quasi({v: dr, w: dphi})
    chart = vo.kinematics.cartesian_chart((r, phi), lagrangian, frame=frame)
    return vo.System(
        "oscillator", vo.Fibration(base=(r, phi)), lagrangian, frame=frame, charts={"axis": chart}
    )


def test_an_oscillator_starts_and_swings_through_the_axis() -> None:
    equations = vo.derive(polar_oscillator())
    (claim,) = check_charts(Motions.of(equations))
    assert claim.verdict.proved
    start = {"r": 0, "phi": 0.3, "v": 1.5}
    motion = vo.integrate(equations, times=np.linspace(0, 9, 50), initial=start)
    t, pace = motion.t, 1.5 * np.exp(0.3j)
    truth = pace.real * np.sin(t) + 1j * (pace.imag * np.sin(t) + (1 - np.cos(t)) / 5)
    found = motion["r"] * np.exp(1j * motion["phi"])
    assert found == pytest.approx(truth, abs=1e-11)


def test_what_is_singular_on_the_axis_has_no_such_chart() -> None:
    dr, dphi = vo.velocity(r), vo.velocity(phi)
    kinetic = (dr**2 + r**2 * dphi**2) / 2
    with pytest.raises(vo.DefinitionError, match="the Lagrangian is singular where r = 0"):
        vo.kinematics.cartesian_chart((r, phi), kinetic + 1 / r**2)
    with pytest.raises(vo.DefinitionError, match="give both, or neither"):
        vo.kinematics.cartesian_chart((r, phi), kinetic, frame=vo.Frame.quasi({v: dr, w: r * dphi}))
    s = sp.Symbol("s")
    sliding = vo.velocity(s) - dphi
    with pytest.raises(vo.DefinitionError, match="the constraints are singular where r = 0"):
        vo.kinematics.cartesian_chart((r, phi), kinetic + vo.velocity(s) ** 2, [sliding])


@pytest.mark.parametrize("potential", [phi, r**2 * sp.cos(phi / 2), r**2 * sp.tan(phi), phi * r**2])
def test_an_angle_whose_turns_count_has_no_chart_on_the_axis(potential: sp.Expr) -> None:
    kinetic = (vo.velocity(r) ** 2 + r**2 * vo.velocity(phi) ** 2) / 2
    with pytest.raises(vo.DefinitionError, match="holds phi otherwise than by sine and cosine"):
        vo.kinematics.cartesian_chart((r, phi), kinetic - potential)


@pytest.mark.parametrize("potential", [sp.log(r), r, r**3])
def test_what_is_not_smooth_on_the_axis_has_no_chart_there(potential: sp.Expr) -> None:
    kinetic = (vo.velocity(r) ** 2 + r**2 * vo.velocity(phi) ** 2) / 2
    with pytest.raises(vo.DefinitionError, match="the Lagrangian is singular where r = 0"):
        vo.kinematics.cartesian_chart((r, phi), kinetic - potential)
