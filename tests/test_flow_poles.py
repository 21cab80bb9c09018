"""Angles near the poles of their coordinates, against the attitude integrated without any."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from rotations import euler
from scipy.integrate import solve_ivp

import voronec as vo
from voronec.declaration.claims import without_claims
from voronec.equations.attitudes import with_attitude_charts
from voronec.equations.motions import Motions
from voronec.motion.formulation.formulation import with_positive_denominators
from voronec.proof.relations.charts import check_charts

pytestmark = pytest.mark.slow

SPIN = (0.5, 1.0, 1.0)


def turning(rates: Callable[[np.ndarray, np.ndarray], np.ndarray], start: np.ndarray, spin: Any,
            times: Any) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Attitudes (k, 3, 3) and body angular velocities (k, 3): R' = R hat(omega)."""

    def right(_: float, y: np.ndarray) -> np.ndarray:
        attitude, omega = y[:9].reshape(3, 3), y[9:12]
        # the rows of R are fixed directions as the body sees them
        return np.concatenate([np.cross(attitude, omega).ravel(), rates(attitude, omega)])

    first = np.concatenate([start.ravel(), spin])
    found = solve_ivp(
        right, (times[0], times[-1]), first, method="DOP853", t_eval=times, rtol=2.3e-14, atol=1e-15
    )
    return found.y[:9].T.reshape(-1, 3, 3), found.y[9:12].T


def chaplygin(attitude: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """G = (I + D) omega - D (omega, gamma) gamma, G' = G x omega, gamma' = gamma x omega."""
    inertia, normal = np.diag([1.4, 1.5, 1.7]), attitude[2]
    moving = np.cross(normal, omega)
    momentum = inertia @ omega - omega.dot(normal) * normal
    known = np.cross(momentum, omega) + omega.dot(moving) * normal + omega.dot(normal) * moving
    return np.linalg.solve(inertia - np.outer(normal, normal), known)


@pytest.fixture(scope="module")
def ball() -> vo.VoronecEquations:
    return vo.derive(vo.load("chaplygin-ball"))


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_angles_on_invariants_near_a_pole(ball: vo.VoronecEquations, method: str) -> None:
    start = {"theta": 1e-7, **{f"omega{i}": x for i, x in enumerate(SPIN, 1)}}
    times = np.linspace(0, 3, 31)
    motion = vo.integrate(
        ball, times=times, outputs=("phi",), initial=start, tol=1e-16, method=method
    )
    attitudes, _ = turning(chaplygin, euler(0, 1e-7, 0), SPIN, times)
    phi = np.arctan2(attitudes[-1, 0, 2], -attitudes[-1, 1, 2])
    assert abs(np.remainder(motion["phi"][-1] - phi + np.pi, 2 * np.pi) - np.pi) < 1e-8


def test_denominators_that_are_sums_of_squares() -> None:
    import symengine as se

    x, y, z, a = se.symbols("x y z a")
    sphere = [x**2 + y**2 + z**2 - 1]
    found = with_positive_denominators(a / ((1 + z) * (z - 1)), sphere)
    assert found == -a / (x**2 + y**2)
    assert with_positive_denominators(a / (1 - z**2), sphere) == a / (x**2 + y**2)
    for other in (a / (1 + z), a / (2 - z**2), a / z, se.Integer(1)):
        assert with_positive_denominators(other, sphere) == other
    assert sp.simplify(sp.sympify(with_positive_denominators(1 / (z**2 - 1) ** 2, sphere))) == (
        1 / sp.sympify(x**2 + y**2) ** 2
    )


POLAR = ("homogeneous-ball", "zhukovsky-ball", "bobylev-ball", "gyroscopic-ball-on-plane")


@pytest.mark.parametrize("name", POLAR)
def test_whole_turns_past_a_pole_do_not_depend_on_the_grid(name: str) -> None:
    ball = vo.derive(vo.load(name))
    spins = tuple(map(str, ball.system.velocities))
    wanted = ("configuration", *spins)
    start = {"u": 1e-4, "v": 1.3, **dict(zip(spins, (0.9, 1.4, 0.6), strict=True))}
    back = vo.integrate(ball, times=[0, -1.5], initial=start, outputs=wanted)
    begin = {x: back[x][-1] for x in back.outputs}

    def ends(grid: np.ndarray, method: str = "scipy", **more: Any) -> np.ndarray:
        motion = vo.integrate(
            ball, times=grid, initial=begin, outputs=wanted, method=method, **more
        )
        assert motion.cost.switches == 2
        return np.array([motion[x][-1] for x in motion.outputs])

    fine = np.unique(np.concatenate([np.linspace(-1.5, 1.5, 301), np.linspace(-1e-2, 1e-2, 4001)]))
    truth = ends(fine)
    # on the fine grid no angle moves by more than a right angle between two instants
    whole = vo.integrate(ball, times=fine, initial=begin, outputs=wanted, method="scipy")
    assert max(np.abs(np.diff(whole[x])).max() for x in ("u", "v", "theta")) < np.pi / 2
    for method in ("scipy", "heyoka"):
        assert ends(np.array([-1.5, 1.5]), method) == pytest.approx(truth, abs=1e-9)
        assert ends(np.linspace(-1.5, 1.5, 7), method) == pytest.approx(truth, abs=1e-9)


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_motion_through_a_pole_says_so(method: str) -> None:
    ball = vo.derive(vo.load("homogeneous-ball"))
    # about the horizontal axis across v = 0.3, at right angles to the meridian
    start = {"u": 1, "v": 0.3, "omega1": -np.sin(0.3), "omega2": np.cos(0.3)}
    for times in ([0, 3], [0, 0.5, 1, 1.5, 3]):
        motion = vo.integrate(
            ball, times=times, initial=start, method=method, outputs=("configuration",)
        )
        assert motion["u"][-1] == pytest.approx(2)
        (note,) = motion.notes
        assert note.startswith("at t = 1 the motion passes through a pole of the coordinates")


def matrices(motion: vo.Trajectory) -> np.ndarray:
    """Attitudes (k, 3, 3) of a motion in Euler angles."""
    return np.array(
        [
            euler(*angles)
            for angles in zip(*(motion[x] for x in ("phi", "theta", "psi")), strict=True)
        ]
    )


@pytest.mark.parametrize(
    ("theta", "method", "end"),
    [
        (0.0, "heyoka", 3.0),
        (0.0, "scipy", -3.0),
        (1e-12, "scipy", 3.0),
        (1e-7, "scipy", -3.0),
        (-1e-5, "heyoka", -3.0),
        (np.pi, "scipy", 3.0),
        (1e-4 - np.pi, "scipy", 3.0),
    ],
)
def test_a_ball_that_starts_at_a_pole(
    ball: vo.VoronecEquations, theta: float, method: str, end: float
) -> None:
    start = {"phi": 0.3, "theta": theta, "psi": 0.2}
    start |= {f"omega{i}": x for i, x in enumerate(SPIN, 1)}
    times = np.linspace(0, end, 31)
    truth, spins = turning(chaplygin, euler(0.3, theta, 0.2), SPIN, times)
    motion = vo.integrate(ball, times=times, outputs=(), initial=start, method=method)
    assert np.abs(matrices(motion) - truth).max() < 1e-11
    assert max(np.abs(motion[f"omega{i + 1}"] - spins[:, i]).max() for i in range(3)) < 1e-11
    assert motion["phi"][0] == 0.3 and motion["theta"][0] == theta and motion["psi"][0] == 0.2
    # the same turns on two instants, and on many
    ends = vo.integrate(ball, times=[0, end], outputs=("phi", "psi"), initial=start)
    fine = vo.integrate(ball, times=np.linspace(0, end, 3001), outputs=(), initial=start)
    for angle in ("phi", "psi"):
        assert ends[angle][-1] == pytest.approx(motion[angle][-1], abs=1e-9)
        assert fine[angle][-1] == pytest.approx(motion[angle][-1], abs=1e-9)
    # phi and psi leave the pole as they can, but their sum or difference does not jump
    upright = np.cos(theta) > 0
    both = fine["phi"] + fine["psi"] if upright else fine["phi"] - fine["psi"]
    assert np.abs(np.diff(both)).max() < 0.01


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_instants_may_follow_a_start_at_a_pole_at_once(
    ball: vo.VoronecEquations, method: str
) -> None:
    start = {"phi": 0.3, "theta": 0, "psi": 0.2}
    start |= {f"omega{i}": x for i, x in enumerate(SPIN, 1)}
    times = np.array([0, 1e-300, 1e-11, 1e-8, 1])
    truth, _ = turning(chaplygin, euler(0.3, 0, 0.2), SPIN, times)
    for order in (1, -1):
        motion = vo.integrate(ball, times=order * times, outputs=(), initial=start, method=method)
        if order == 1:
            assert np.abs(matrices(motion) - truth).max() < 1e-11
        ends = vo.integrate(ball, times=[0, order], outputs=(), initial=start, method=method)
        for angle in ("phi", "theta", "psi"):
            assert motion[angle][-1] == pytest.approx(ends[angle][-1], abs=1e-11)


@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_a_start_at_a_pole_is_given_by_velocities_of_angles(
    ball: vo.VoronecEquations, theta: float
) -> None:
    # there phi and psi turn the body about one axis, and theta about the line of nodes
    spin = (0.3 * np.cos(0.2), -0.3 * np.sin(0.2), 0.5 + 0.4 * np.cos(theta))
    rates = {"phidot": 0.4, "thetadot": 0.3, "psidot": 0.5}
    times = np.linspace(0, 2, 9)
    truth, _ = turning(chaplygin, euler(0.3, theta, 0.2), spin, times)
    motion = vo.integrate(
        ball, times=times, outputs=(), initial={"phi": 0.3, "theta": theta, "psi": 0.2, **rates}
    )
    assert np.abs(matrices(motion) - truth).max() < 1e-11


def test_digits_at_a_pole_are_refused_in_one_line(ball: vo.VoronecEquations) -> None:
    for spin in ({"omega1": 1}, {"phidot": 0, "thetadot": 1}):
        with pytest.raises(vo.IntegrationError, match=r"starts at a pole .* give tol=1e-16 or"):
            vo.integrate(ball, times=[0, 1], outputs=(), initial={"theta": 0, **spin}, tol=1e-20)
    inside = vo.integrate(
        ball, times=[0, 1], outputs=("omega1",), initial={"theta": 0, "omega1": 1}, tol=1e-20
    )
    assert inside.drift["energy"] < 1e-19  # the equations of the invariants have no poles


def test_a_ball_that_comes_near_a_pole_on_its_way(ball: vo.VoronecEquations) -> None:
    spins = [f"omega{i}" for i in (1, 2, 3)]
    start = {"theta": 1e-6, **dict(zip(spins, SPIN, strict=True))}
    back = vo.integrate(ball, times=[0, -2], outputs=(), initial=start)
    begin = {x: back[x][-1] for x in ("phi", "theta", "psi", *spins)}
    truth, _ = turning(
        chaplygin, euler(begin["phi"], begin["theta"], begin["psi"]), [begin[w] for w in spins],
        np.linspace(-2, 2, 9),
    )  # fmt: skip
    for method in ("heyoka", "scipy"):
        motion = vo.integrate(
            ball, times=np.linspace(-2, 2, 9), outputs=(), initial=begin, method=method
        )
        assert motion.cost.switches == 2
        assert np.abs(matrices(motion) - truth).max() < 1e-10
        again = vo.integrate(ball, times=[-2, 2], outputs=("phi",), initial=begin, method=method)
        assert again["phi"][-1] == pytest.approx(motion["phi"][-1], abs=1e-9)


def test_a_body_that_rests_upright_turns_about_its_axis(ball: vo.VoronecEquations) -> None:
    start = {"theta": 0, "phi": 0.4, "omega1": 0, "omega2": 0, "omega3": 2}
    motion = vo.integrate(ball, times=[0, 1, 2], initial=start, outputs=("configuration",))
    assert motion["phi"] + motion["psi"] == pytest.approx([0.4, 2.4, 4.4])
    assert np.abs(motion["theta"]).max() < 1e-12 and np.abs(motion["x"]).max() < 1e-12


@pytest.mark.parametrize("name", ["chaplygin-ball", "suslov", "veselova", "rattleback"])
def test_charts_of_attitudes_are_proved(name: str) -> None:
    charted = with_attitude_charts(vo.derive(vo.load(name)))
    assert charted is not None
    verdicts = [claim.verdict for claim in check_charts(Motions.of(charted))]
    assert verdicts and all(verdict.proved for verdict in verdicts)


def test_what_is_not_regular_at_the_poles_has_no_chart() -> None:
    ball = vo.load("chaplygin-ball")
    theta = next(q for q in ball.coordinates if str(q) == "theta")
    for torque in (sp.cot(theta), sp.cos(theta / 3)):
        assert with_attitude_charts(vo.derive(replace(ball, forces={theta: torque}))) is None
    # the angle of the chart is another one: a potential of the old one is not that of the new
    for potential in (theta**2, sp.exp(theta), sp.cos(theta * sp.cos(theta))):
        bound = replace(ball, lagrangian=ball.lagrangian - potential, **without_claims())
        assert with_attitude_charts(vo.derive(bound)) is None
    assert with_attitude_charts(vo.derive(vo.load("falling-disc"))) is None


def test_a_body_without_a_frame_in_angles_of_another_sequence() -> None:
    angles = sp.symbols("yaw pitch roll")
    rotation = vo.kinematics.Rotation.euler("zyx", *angles)
    moments = (sp.Rational(7, 5), sp.Rational(3, 2), sp.Rational(17, 10))
    body = vo.System(
        name="free-body",
        fibration=vo.Fibration(base=angles),
        lagrangian=vo.kinematics.kinetic_energy(0, (0, 0, 0), moments, rotation.body_rates),
    )
    inertia = np.array(moments, dtype=float)

    def free(_: np.ndarray, omega: np.ndarray) -> np.ndarray:
        return np.cross(inertia * omega, omega) / inertia

    matrix = sp.lambdify(angles, rotation.matrix)
    at = (0.3, np.pi / 2 - 1e-5, 0.2)
    rates = sp.lambdify((*angles, *map(vo.velocity, angles)), rotation.body_rates)
    dots = (0.4, -0.7, 0.9)
    spin = np.array(rates(*at, *dots), dtype=float).ravel()
    times = np.linspace(0, 3, 13)
    truth, _ = turning(free, np.array(matrix(*at), dtype=float), spin, times)
    start = dict(zip(map(str, angles), at, strict=True))
    start |= {str(vo.velocity(q)): x for q, x in zip(angles, dots, strict=True)}
    motion = vo.integrate(body, times=times, initial=start, method="scipy")
    found = np.array([matrix(*row) for row in zip(*(motion[str(q)] for q in angles), strict=True)])
    assert motion.cost.switches >= 1
    assert np.abs(found.reshape(-1, 3, 3) - truth).max() < 1e-9


def test_rates_keep_their_denominators_where_parameters_are_zero() -> None:
    ball = vo.derive(vo.load("displaced-rubber-ball"))
    start = {"u": 1e-4, "v": 1.046, "theta": 0.443, "omega1": 0.645, "omega2": 0.668}
    times = [0, -0.5, -1]
    angles = ("u", "v", "theta")
    inside = vo.integrate(ball, times=times, outputs=(), initial=start, method="heyoka")
    charted = vo.integrate(ball, times=times, outputs=(*angles, "reaction 1"), initial=start)
    # invariants with angles beside them, and, for the reaction, angles in another chart
    assert (inside.cost.formulation, charted.cost.formulation) == ("invariants", "coordinates")
    assert charted.cost.switches == 1
    for angle in angles:
        assert inside[angle] == pytest.approx(charted[angle], abs=1e-11)


def irregular(rough: bool) -> tuple[vo.System, Callable[[np.ndarray, np.ndarray], float]]:
    """A ball with a torque f (e3 - gamma3 gamma) that is no polynomial in the attitude, or jumps:
    no chart leads past a pole; and f."""
    ball = vo.load("chaplygin-ball")
    theta, psi = (next(q for q in ball.coordinates if str(q) == x) for x in ("theta", "psi"))
    size = (
        -sp.sign(sp.Symbol("omega3") - sp.Rational(9, 10)) / 10
        if rough
        else 1 / (10 + sp.cos(theta / 3))
    )
    # what turns psi alone has no moment about the vertical and the line of nodes
    system = replace(ball, name="torque", forces={psi: size * sp.sin(theta) ** 2}, integrals={})
    if rough:
        return system, lambda _, omega: -0.1 * np.sign(omega[2] - 0.9)
    return system, lambda R, _: 1 / (10 + np.cos(np.arccos(R[2, 2]) / 3))


@pytest.mark.parametrize(("rough", "method"), [(False, "heyoka"), (True, "scipy")])
def test_a_pole_beyond_which_no_chart_leads(rough: bool, method: str) -> None:
    system, size = irregular(rough)
    equations = vo.derive(system)
    assert rough or with_attitude_charts(equations) is None

    def rates(attitude: np.ndarray, omega: np.ndarray) -> np.ndarray:
        normal = attitude[2]
        torque = size(attitude, omega) * (np.array([0, 0, 1]) - normal[2] * normal)
        inertia = np.diag([1.4, 1.5, 1.7]) - np.outer(normal, normal)
        return chaplygin(attitude, omega) + np.linalg.solve(inertia, torque)

    start = {"phi": 0.2, "psi": 0.3, **{f"omega{i}": x for i, x in enumerate(SPIN, 1)}}
    end = 0.4 if rough else 1.0  # before omega3 comes to its switching surface
    times = np.linspace(0, end, 5)
    motion = vo.integrate(
        equations, times=times, outputs=(), initial={**start, "theta": 1e-5}, method=method
    )
    truth, _ = turning(rates, euler(0.2, 1e-5, 0.3), SPIN, times)
    assert np.abs(matrices(motion) - truth).max() < 1e-10
    for theta in (0.0, 1e-8):
        with pytest.raises(vo.IntegrationError, match=r"within 1e-06 of a pole .* start elsewhere"):
            vo.integrate(
                equations, times=times, initial={**start, "theta": theta}, method=method,
                outputs=("phi",),
            )  # fmt: skip
    # about the line of nodes, straight to the pole
    upright = {"theta": 1e-3, "phi": 0, "psi": 0, "omega1": -1, "omega2": 0, "omega3": 0}
    with pytest.raises(vo.IntegrationError, match=r"within 1e-06 of a pole") as found:
        vo.integrate(equations, times=[0, 5e-4, 2], outputs=(), initial=upright, method=method)
    assert found.value.trajectory is not None and found.value.trajectory.t[-1] >= 5e-4


def switched_pendulum(switch: Callable[[sp.Expr], sp.Expr]) -> vo.System:
    """A spherical pendulum with a force that jumps where theta' is that function of theta."""
    theta, phi = sp.symbols("theta phi")
    td, pd = vo.velocity(theta), vo.velocity(phi)
    return vo.System(
        name="spherical-pendulum",
        fibration=vo.Fibration(base=(theta, phi)),
        lagrangian=(td**2 + sp.sin(theta) ** 2 * pd**2) / 2 + sp.cos(theta),
        forces={theta: -sp.sign(td - switch(theta))},
    )


def test_what_switches_is_not_defined_at_a_pole_without_charts() -> None:
    pendulum = switched_pendulum(lambda theta: sp.sin(1 / theta))
    with pytest.raises(vo.IntegrationError, match="at the initial point; start elsewhere"):
        vo.integrate(pendulum, initial={"theta": 0, "thetadot": 1}, times=[0, 1])


@pytest.mark.parametrize("side", [1, -1])
def test_what_switches_on_both_sides_of_a_pole_begins_there(side: int) -> None:
    """cot(theta) falls from infinity: the force drives on until theta' = cot(theta), then back till
    that is so again, and there both hold the motion: cos(theta)' = -cos(theta)."""
    pendulum = switched_pendulum(sp.cot)
    start = {"theta": 0, "thetadot": side}
    run = vo.integrate(pendulum, initial=start, times=[0, 1], method="scipy")

    def reached(_: float, z: np.ndarray) -> float:
        return z[1] * np.sin(z[0]) - np.cos(z[0])

    reached.terminal = True  # type: ignore[attr-defined]
    time, state = 0.0, np.array([0.0, 1.0])
    for push in (1, -1):
        reached.direction = push  # type: ignore[attr-defined]
        part = solve_ivp(
            lambda _, z, push=push: [z[1], push - np.sin(z[0])], (time, 1), state, "DOP853",
            rtol=1e-12, atol=1e-13, events=reached,
        )  # fmt: skip
        time, state = part.t[-1], part.y[:, -1]
    assert 0 < time < 1
    theta = np.arccos(np.cos(state[0]) * np.exp(time - 1))
    assert run["theta"][-1] == pytest.approx(side * theta, abs=1e-10)
    assert run["thetadot"][-1] == pytest.approx(side / np.tan(theta), abs=1e-10)


def test_dense_runs_keep_whole_turns_of_the_own_chart() -> None:
    """Between two distant instants of the grid an angle turns by more than pi, before and after the
    run passes a pole: in the own chart nothing is to be put on another branch."""
    ball = vo.derive(vo.load("ball-on-paraboloid"))
    start = {"r": 0.543, "phi": -1.585, "psi": 2.387, "alpha": -1.439, "beta": 0.716,
             "v": -0.829, "w": 0.95, "s": 0.142}  # fmt: skip
    times = np.linspace(0.5, 5.539, 10001)
    fine = vo.integrate(ball, initial=start, times=times)
    dense = vo.integrate(ball, initial=start, times=times[[0, -1]], dense=True)
    assert fine.cost.switches and np.abs(np.diff(fine["psi"])).max() < 1
    found = dense.at(times)
    for angle in ("alpha", "beta", "psi", "phi"):
        assert np.abs(found[angle] - fine[angle]).max() < 1e-9


@pytest.mark.parametrize("off", [0.0, 1e-12])
def test_a_start_at_the_pole_of_a_declared_chart_does_not_run_on_invariants(off: float) -> None:
    ball = vo.derive(vo.load("displaced-rubber-ball"))
    start = {"u": np.pi + off, "v": 0.48, "theta": 0.07, "omega1": -0.039, "omega2": 0.818}
    run = vo.integrate(ball, initial=start, times=[0, 1], method="heyoka")
    normal = vo.integrate(ball, initial=start, times=[0, 1], outputs=("gamma1", "gamma2"))
    polar, angle = run["u"][-1], run["v"][-1]
    assert abs(-np.sin(polar) * np.cos(angle) - normal["gamma1"][-1]) < 1e-10
    assert abs(-np.sin(polar) * np.sin(angle) - normal["gamma2"][-1]) < 1e-10


@pytest.mark.parametrize("method", ["heyoka", "scipy", "c", "flint"])
def test_a_special_motion_through_poles_at_which_it_is_regular_says_so(method: str) -> None:
    """Demchenko's ball, rolling in a plane: u' = -2/3 and u1' = 1/3, so that both pass poles."""
    start = {"u": 1, "v": 0.3, "theta": sp.pi / 2, "u1": 1, "v1": 0.2, "s": 0, "tau": 1, "n": 0}
    given = {"initial": start, "parameters": {"k": 0}, "method": method}
    given |= {"tol": 1e-20} if method == "flint" else {}
    ball = vo.derive(vo.load("demchenko"))
    ends = {1.4: (), 20: ("1.5, the first of 6 times",), -20: ("-3, the first",)}
    if method == "flint":  # with u1 -> 0 it is refused: a quotient there has no series
        del ends[-20]
    for end, words in ends.items():
        run = vo.integrate(ball, times=[0, end], **given)
        assert len(run.notes) == len(words) and not run.events
        for said in words:
            assert f"at t = {said}" in run.notes[0] and "up to whole turns" in run.notes[0]
    turnless = vo.integrate(ball, times=[0, 20], outputs=("s", "tau"), **given)
    assert turnless.notes == ()


@pytest.mark.parametrize("method", ["auto", "scipy", "flint"])
@pytest.mark.parametrize("rubbing", [False, True])
def test_a_body_that_tips_over_its_pole_in_a_plane_says_so(method: str, rubbing: bool) -> None:
    """An ellipsoid on a plane, theta' < 0, and no other rate: phi and psi stay as they are, where
    they might as well change by half a turn.  A motor that is cut off at theta = 1/5 is not
    smooth."""
    body = vo.load("ellipsoid-on-plane")
    if rubbing:
        theta = next(q for q in body.coordinates if q.name == "theta")
        body = replace(
            body, **without_claims(), forces={theta: -sp.Heaviside(theta - sp.Rational(1, 5)) / 100}
        )
    start = {"theta": 0.4, "thetadot": -1, "phidot": 0, "psidot": 0}
    given = {"initial": start, "times": [0, 1], "method": method}
    given |= {"tol": 1e-20} if method == "flint" else {}
    run = vo.integrate(body, **given)
    assert run["theta"][-1] < 0 and not run.events
    (said,) = run.notes
    passed = float(said.split("at t = ")[1].split()[0])
    assert "up to whole turns" in said
    before = vo.integrate(body, **(given | {"times": [0, passed]}))
    assert abs(float(before["theta"][-1])) < 1e-9
    assert vo.integrate(body, outputs=("omega1",), **given).notes == ()


@pytest.mark.parametrize(("method", "tol"), [("heyoka", 1e-16), ("scipy", 1e-12), ("auto", 1e-13)])
def test_a_motion_through_a_pole_up_to_rounding_says_so(method: str, tol: float) -> None:
    """On invariants, with angles carried along, it came within 1e-15 of the pole without a word."""
    ball = vo.load("demchenko")
    pole = {"u": 1, "s": 0.3, "tau": 0.2, "n": 0.4, "u1": 0, "theta": 0.3}
    back = vo.integrate(ball, initial=pole, times=[0, -3], method="heyoka", tol=1e-16)
    start = {name: float(back[name][-1]) for name in back.names}
    run = vo.integrate(ball, initial=start, times=[-3, 3], method=method, tol=tol)
    (said,) = run.notes
    assert "pole of the coordinates" in said
    assert abs(float(said.split("at t = ")[1].split()[0])) < 1e-9
    column = {**start, "u1": np.array([0.5, start["u1"]])}
    together = vo.ensemble(ball, column, times=[-3, 3], tol=1e-13)
    assert [*together.notes] == [1] and "pole of the coordinates" in together.notes[1][0]


def test_motions_of_an_ensemble_that_tip_over_a_pole_say_so() -> None:
    starts = {
        "theta": np.array([0.4, 1.4]),
        "thetadot": -1,
        "phidot": 0,
        "psidot": np.array([0, 0.3]),
    }
    found = vo.ensemble(vo.load("ellipsoid-on-plane"), starts, times=[0, 1])
    assert [*found.notes] == [0] and found.finished.all() and not found.errors
    assert "at t = 0.363152379" in found.notes[0][0]


def test_angles_that_only_events_hold_keep_their_unit():
    """phi is 5e-18 in the chart beyond the pole: heyoka had it in such units."""
    rates = {"phidot": -0.6521612371516327, "thetadot": -0.6685498945274808}
    rates["psidot"] = rates["phidot"]
    start = {"phi": 0.043686266005180885, "theta": np.pi, "psi": np.pi / 2, **rates}
    asked = {"initial": start, "times": [0, 1], "outputs": ("phi", "gamma1", "gamma2")}
    runs = [vo.integrate(vo.load("suslov"), method=m, **asked) for m in ("auto", "scipy")]
    assert all(abs(runs[0][k][-1] - runs[1][k][-1]) < 1e-11 for k in runs[0].outputs)
    assert abs(runs[0]["gamma2"][-1]) > 0.05


def test_velocities_at_a_pole_are_not_lost_beside_rates_without_bound():
    """n = phidot + psidot cos(theta); the plate turns, so phidot has terms of 1e15."""
    start = {"theta": np.pi, "phi": -0.6, "psi": 0.5, "x": 0.8, "phidot": 0.75, "psidot": 0.78125}
    rates = {"thetadot": 0.1, "xdot": -0.2, "ydot": 0.7}
    run = vo.integrate(
        vo.load("ball-on-turntable"), initial=start | rates, times=[0, 1], outputs=("n",),
        project=True,
    )  # fmt: skip
    assert abs(run["n"][0] + 0.03125) < 1e-12


@pytest.mark.parametrize("theta", [-1e-4, -1e-10])
def test_the_side_of_a_pole_is_told_far_from_the_origin(theta: float) -> None:
    """Angles do not depend on where the ball is, however far."""
    ball = vo.derive(vo.load("chaplygin-ball"))
    start = {"theta": theta, "phi": 0.3, "psi": 0.2, "omega1": 0.5, "omega2": 1, "omega3": 1}
    here, there = (
        vo.integrate(ball, initial={**start, "x": x}, times=[0, 2], outputs=()) for x in (0, 1e8)
    )
    for name in ("phi", "theta", "psi"):
        assert there[name][-1] == pytest.approx(here[name][-1], abs=1e-9), name
    assert here["theta"][-1] < 0
