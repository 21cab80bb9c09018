"""Contacts at the poles of the coordinates of a surface, against vectors, which have none."""

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
from voronec.equations.attitudes import euler_angles, with_attitude_charts
from voronec.equations.motions import Motions
from voronec.proof.relations.charts import check_charts

pytestmark = pytest.mark.slow

SPIN = np.array([0.3, 0.4, 0.5])
MASS = 1.0
Rates = Callable[[Any, Any, Any, Any], tuple[Any, Any, Any]]


def lines(colatitude: float, longitude: float) -> np.ndarray:
    """[e_u e_v n] of a unit sphere, column by column."""
    (s, c), (z, x) = [(np.sin(a), np.cos(a)) for a in (colatitude, longitude)]
    return np.array([[c * x, -z, s * x], [c * z, x, s * z], [-s, 0, c]])


def rolled(rates: Rates, inertia: Any, start: tuple[Any, ...], end: float) -> tuple[Any, ...]:
    """Attitude, normal, arm and angular velocity after a time; (normal', arm') and the arm itself,
    seen from the body, are given by ``rates``, and G = I omega + m r x (omega x r)."""

    def right(_: float, y: np.ndarray) -> np.ndarray:
        R, normal, arm, w = y[:9].reshape(3, 3), y[9:12], y[12:15], y[15:]
        turned, r, moved = rates(R, normal, arm, w)
        G = inertia @ w + MASS * np.cross(r, np.cross(w, r))
        change = np.cross(G, w) + MASS * np.cross(moved, np.cross(w, r))
        change -= MASS * np.cross(moved, np.cross(w, r)) + MASS * np.cross(r, np.cross(w, moved))
        J = inertia + MASS * (r @ r * np.eye(3) - np.outer(r, r))
        # the rows of R are fixed directions as the body sees them
        return np.concatenate([np.cross(R, w).ravel(), turned, moved, np.linalg.solve(J, change)])

    first = np.concatenate([np.ravel(x) for x in start])
    y = solve_ivp(right, (0, end), first, method="DOP853", rtol=2.3e-14, atol=1e-15).y[:, -1]
    return y[:9].reshape(3, 3), y[9:12], y[12:15], y[15:]


def ellipsoid_on_sphere(_: Any, gamma: np.ndarray, arm: Any, w: np.ndarray) -> tuple[Any, ...]:
    """gamma and r from the body, with r = -S gamma/h and dr = -H dgamma."""
    S, R1 = np.diag([1.0, 1.2, 0.8]) ** 2, 2.0
    h = np.sqrt(gamma @ S @ gamma)
    H = S / h - np.outer(S @ gamma, S @ gamma) / h**3
    turned = R1 * np.linalg.solve(R1 * np.eye(3) + H, np.cross(gamma, w))
    return turned, -S @ gamma / h, -H @ turned


def ellipsoid_end(place: tuple[Any, ...], end: float) -> tuple[Any, ...]:
    (phi, theta, psi), (u, v) = place
    R = euler(phi, theta, psi)
    gamma = lines(u, v)[:, 2]
    return rolled(ellipsoid_on_sphere, np.diag([0.4, 0.3, 0.5]), (R, gamma, np.zeros(3), SPIN), end)


@pytest.fixture(scope="module")
def ellipsoid() -> vo.VoronecEquations:
    return vo.derive(vo.load("ellipsoid-on-sphere"))


@pytest.mark.parametrize(
    ("u", "theta", "end"),
    [(0.0, 1.0, 1.0), (np.pi, 1.0, -1.0), (np.pi, 0.0, 1.0), (1e-9, 1.0, 1.0), (1e-5, 1.0, -1.0)],
)
def test_an_ellipsoid_that_touches_at_the_end_of_its_axis(
    ellipsoid: vo.VoronecEquations, u: float, theta: float, end: float
) -> None:
    angles = {"phi": 0.2, "theta": theta, "psi": 0.1}
    S = np.diag([1.0, 1.2, 0.8]) ** 2
    normal = lines(u, 0.3)[:, 2]
    start = {**angles, "u": u, "v": 0.3, "p": np.sqrt(normal @ S @ normal)}
    start |= {f"omega{i}": x for i, x in enumerate(SPIN, 1)}
    motion = vo.integrate(ellipsoid, times=[0, end], outputs=(), initial=start)
    R, gamma, _, spin = ellipsoid_end((tuple(angles.values()), (u, 0.3)), end)
    last = {x: motion[x][-1] for x in motion.outputs}
    found = euler(last["phi"], last["theta"], last["psi"])
    assert np.abs(found - R).max() < 1e-11
    assert np.abs(lines(last["u"], last["v"])[:, 2] - gamma).max() < 1e-11
    assert np.abs([last[f"omega{i}"] - x for i, x in enumerate(spin, 1)]).max() < 1e-11
    assert last["p"] == pytest.approx(np.sqrt(gamma @ S @ gamma), abs=1e-11)


TUBE, BIG, AXES = 0.5, 1.0, np.diag([3.0, 3.0, 2.0]) ** 2


def torus_on_ellipsoid(R: Any, normal: np.ndarray, arm: np.ndarray, w: Any) -> tuple[Any, ...]:
    """The ellipsoid's normal N in space and r from the torus: with outer normals n = -R^T N and
    shape operators K, (K + R^T K1 R) r' = -omega x n."""
    n = -R.T @ normal
    h, flat = np.sqrt(normal @ AXES @ normal), np.eye(3) - np.outer(normal, normal)
    fixed = h * flat @ np.linalg.inv(AXES) @ flat
    across = np.hypot(n[0], n[1])
    around = np.array([-n[1], n[0], 0]) / across
    up = np.cross(around, n)
    own = np.outer(up, up) / TUBE + across / (BIG + TUBE * across) * np.outer(around, around)
    both = own + R.T @ fixed @ R + np.outer(n, n)
    moved = np.linalg.solve(both, -np.cross(w, n))
    return fixed @ R @ moved, arm, moved


def torus_frames(u: float, v: float, u1: float, v1: float, theta: float) -> tuple[Any, ...]:
    """B, and the attitude B1 Q B^T."""
    s, c = np.sin(theta), np.cos(theta)
    Q = np.array([[-s, c, 0], [c, s, 0], [0, 0, -1]])
    return lines(u, v), lines(u1, v1) @ Q @ lines(u, v).T


@pytest.fixture(scope="module")
def torus() -> vo.VoronecEquations:
    return vo.derive(vo.load("torus-on-ellipsoid"))


@pytest.mark.parametrize(
    ("u1", "chi", "end"), [(0.0, 1.0, 1.0), (np.pi, 1.0, -1.0), (np.pi, 0.0, 1.0), (1e-5, 1.0, 1.0)]
)
def test_a_torus_on_the_end_of_the_axis_of_an_ellipsoid(
    torus: vo.VoronecEquations, u1: float, chi: float, end: float
) -> None:
    place = {"u": 1.0, "v": 0.2, "u1": u1, "v1": 0.3, "theta": 0.7}
    normal = lines(u1, 0.3)[:, 2]
    start = {**place, "chi": chi, "w": np.sqrt(normal @ AXES @ normal) / 3}
    start |= dict(zip("s tau n".split(), SPIN, strict=True))
    motion = vo.integrate(torus, times=[0, end], outputs=(), initial=start)
    B, attitude = torus_frames(*place.values())
    arm = B @ [TUBE * 0, 0, TUBE] + BIG * np.array([np.cos(0.2), np.sin(0.2), 0])
    inertia = np.diag([1.0, 1.0, 1.5])
    R, N, r, spin = rolled(torus_on_ellipsoid, inertia, (attitude, normal, arm, B @ SPIN), end)
    last = {x: motion[x][-1] for x in motion.outputs}
    B, attitude = torus_frames(*(last[x] for x in place))
    assert np.abs(attitude - R).max() < 1e-11
    assert np.abs(lines(last["u1"], last["v1"])[:, 2] - N).max() < 1e-11
    assert np.abs(B @ [last[x] for x in ("s", "tau", "n")] - spin).max() < 1e-11
    around = np.array([np.cos(last["v"]), np.sin(last["v"]), 0])
    assert np.abs(TUBE * B[:, 2] + BIG * around - r).max() < 1e-11
    assert last["w"] == pytest.approx(np.sqrt(N @ AXES @ N) / 3, abs=1e-11)


u, c = sp.symbols("u c")
PROFILES = {
    "polynomial": 1 + c / 4 + c**2 / 9,
    "transcendental": 2 + sp.sin(c) / 4,
}
"""Support functions by the cosine of the colatitude."""


def body_of_revolution(support: sp.Expr) -> vo.VoronecEquations:
    """The body of revolution on a sphere with a support function of u, and without a force."""
    system = vo.load("symmetric-body-on-sphere")
    known = {sp.Function("P")(u): support, sp.Function("V")(u): sp.Integer(0)}

    def read(e: Any) -> Any:
        return e.subs(known).doit()

    filled = {
        "lagrangian": read(system.lagrangian),
        "constraints": [*map(read, system.constraints)],
    }
    return vo.derive(replace(system, **{**without_claims(), **filled}))


@pytest.fixture(scope="module", params=PROFILES)
def profile(request: Any) -> tuple[vo.VoronecEquations, sp.Expr]:
    """A body of revolution, and its support function by the cosine."""
    support = PROFILES[request.param]
    return body_of_revolution(support.subs(c, sp.cos(u))), support


def revolution_on_sphere(support: sp.Expr) -> tuple[Callable[[Any], Any], Rates]:
    """r = OM of an outer normal n, and the rates of both: with h(x) = |x| p(x_3/|x|) these are
    r = dh/dn, n' = R1 (R1 + H)^-1 (n x omega) and r' = H n', H the second derivatives of h."""
    value, slope, bend = (sp.lambdify(c, sp.diff(support, c, k)) for k in range(3))

    def arm(n: np.ndarray) -> np.ndarray:
        return value(n[2]) * n + slope(n[2]) * (np.array([0, 0, 1]) - n[2] * n)

    def rates(_: Any, n: np.ndarray, __: Any, w: np.ndarray) -> tuple[Any, ...]:
        aside = np.array([0, 0, 1]) - n[2] * n
        across = np.eye(3) - np.outer(n, n)
        H = (value(n[2]) - n[2] * slope(n[2])) * across + bend(n[2]) * np.outer(aside, aside)
        turned = 2.0 * np.linalg.solve(2.0 * np.eye(3) + H, np.cross(n, w))
        return turned, arm(n), H @ turned

    return arm, rates


@pytest.mark.parametrize(
    ("colatitude", "u1", "end"), [(0.0, 1.0, 1.0), (np.pi, 1.0, -1.0), (1e-6, 0.0, 1.0)]
)
def test_a_body_of_revolution_touches_at_the_end_of_its_axis(
    profile: tuple[vo.VoronecEquations, sp.Expr], colatitude: float, u1: float, end: float
) -> None:
    equations, support = profile
    arm, rates = revolution_on_sphere(support)
    place = {"u": colatitude, "v": 0.2, "u1": u1, "v1": 0.3, "theta": 0.7}
    start = {**place, **dict(zip("s tau n".split(), SPIN, strict=True))}
    motion = vo.integrate(equations, times=[0, end], outputs=(), initial=start)
    B, attitude = torus_frames(*place.values())
    begin = (attitude, B[:, 2], arm(B[:, 2]), B @ SPIN)
    R, n, _, spin = rolled(rates, np.diag([1.0, 1.0, 1.5]), begin, end)
    last = {x: motion[x][-1] for x in motion.outputs}
    B, attitude = torus_frames(*(last[x] for x in place))
    assert np.abs(attitude - R).max() < 1e-11
    assert np.abs(B[:, 2] - n).max() < 1e-11
    assert np.abs(B @ [last[x] for x in ("s", "tau", "n")] - spin).max() < 1e-11


def test_charts_of_a_body_of_revolution_are_proved_where_its_profile_closes() -> None:
    """Beside the chart at the poles of the sphere, and after it; with a ridge on the axis there is
    none."""
    charted = with_attitude_charts(body_of_revolution(1 + sp.cos(u) / 4 + sp.cos(u) ** 2 / 9))
    assert charted is not None
    verdicts = {claim.name: claim.verdict for claim in check_charts(Motions(charted))}
    assert len(verdicts) == 3
    assert all(verdict.proved for verdict in verdicts.values()), verdicts
    assert with_attitude_charts(body_of_revolution(1 + sp.sin(u) / 4)) is None


@pytest.mark.parametrize("colatitude", [0.0, np.pi])
def test_velocities_along_meridians_and_parallels_are_turned_at_the_poles(
    colatitude: float,
) -> None:
    """A point on a unit sphere, heavy: x'' = -e3 + (x_3 - |x'|^2) x."""
    phi, theta, a, b = sp.symbols("phi theta a b")
    along, across = vo.velocity(theta), sp.sin(theta) * vo.velocity(phi)
    frame = vo.Frame.quasi({a: along, b: across})
    energies = (along**2 + across**2) / 2, sp.cos(theta)
    point = vo.System("point", vo.Fibration((phi, theta)), energies[0] - energies[1], frame=frame)
    start = {"phi": 0.2, "theta": colatitude, "a": 0.3, "b": 0.4}
    motion = vo.integrate(point, times=[0, 1], outputs=(), initial=start)

    def right(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[3:], (y[2] - y[3:] @ y[3:]) * y[:3] - [0, 0, 1]])

    def vectors(state: Any) -> np.ndarray:
        e_u, e_v, normal = lines(state["theta"], state["phi"]).T
        return np.concatenate([normal, state["a"] * e_u + state["b"] * e_v])

    end = solve_ivp(right, (0, 1), vectors(start), method="DOP853", rtol=2.3e-14, atol=1e-15).y
    found = vectors({x: motion[x][-1] for x in motion.outputs})
    assert np.abs(found - end[:, -1]).max() < 1e-12


def test_directions_and_contacts_are_recognised(
    ellipsoid: vo.VoronecEquations, torus: vo.VoronecEquations
) -> None:
    for equations, last in ((ellipsoid, ["psi", None]), (torus, ["psi", "theta"])):
        assert [a.psi if a.psi is None else str(a.psi) for a in euler_angles(equations)] == last
        charted = with_attitude_charts(equations)
        assert charted is not None and len(charted.system.charts) == 3
        assert any("relations" in c.changes for c in charted.system.charts.values())


def test_an_energy_that_is_rounding_over_rounding_at_the_start_is_no_drift() -> None:
    """At gamma = e2 omega1 and omega2 are no frame; what the engine finds is followed back there by
    (I + D) omega' = G x omega + lambda gamma, gamma' = k gamma x omega, omega . gamma = 0."""
    ball = vo.load("rubber-ball-on-sphere")
    rates = {"udot": 0.025887788476464807, "vdot": 0.4906465495129713}
    rates |= {"u1dot": 0.22843233445714728, "v1dot": -0.0916935629505034}
    start = {"u": np.pi / 2, "v": np.pi / 2, "u1": 1.401748901317881, "v1": -0.5163682022258144}
    start |= {"theta": -0.42949197011134455, "thetadot": 0.015426839494958426, **rates}
    motion = vo.integrate(ball, times=[0, 0.5, 1], outputs=(), initial=start)
    values = {p.name: float(p.value) for p in ball.parameters}
    whole = np.diag([values[f"I{i}"] for i in (1, 2, 3)]) + values["m"] * values[
        "R2"
    ] ** 2 * np.eye(3)
    share = values["R1"] / (values["R1"] + values["R2"])

    def right(_: float, y: np.ndarray) -> np.ndarray:
        w, gamma = y[:3], y[3:]
        free, along = (np.linalg.solve(whole, x) for x in (np.cross(whole @ w, w), gamma))
        slope = free - along * (free @ gamma) / (along @ gamma)
        return np.concatenate([slope, share * np.cross(gamma, w)])

    gamma = lines(motion["u"][-1], motion["v"][-1])[:, 2]
    one, two = motion["omega1"][-1], motion["omega2"][-1]
    spin = [one, two, -(one * gamma[0] + two * gamma[1]) / gamma[2]]
    end = np.concatenate([spin, gamma])
    back = solve_ivp(right, (1, 0), end, method="DOP853", rtol=2.3e-14, atol=1e-15).y[:, -1]
    assert np.abs(back[3:] - [0, 1, 0]).max() < 1e-10 and abs(back[1]) < 1e-10
