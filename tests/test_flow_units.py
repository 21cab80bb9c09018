"""The same motion in other units of length and time has the same errors."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import voronec as vo

TIMES = np.linspace(0, 20, 21)


@pytest.fixture(scope="module")
def ball() -> vo.VoronecEquations:
    return vo.derive(vo.load("chaplygin-ball"))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_a_ball_in_other_units(ball: vo.VoronecEquations, method: str) -> None:
    truth = vo.integrate(ball, times=TIMES, outputs=("x", "omega1"), tol=1e-20)
    true_x, true_spin = (truth[name].astype(float) for name in ("x", "omega1"))
    steps = set()
    for length, rate in ((1.0, 1.0), (1e9, 1.0), (1e-9, 1.0), (1.0, 1e6), (1e6, 1e-5)):
        moments = {f"I{i}": x * length**2 for i, x in enumerate((0.4, 0.5, 0.7), 1)}
        start = {f"omega{i}": x * rate for i, x in enumerate((0.5, 2, 0.2), 1)}
        motion = vo.integrate(
            ball, times=TIMES / rate, outputs=("x", "omega1"), method=method,
            parameters={"R": length, **moments}, initial=start | {"theta": 1},
        )  # fmt: skip
        steps.add(motion.cost.steps)
        assert np.abs(motion["x"] / length - true_x).max() < 2e-11
        assert np.abs(motion["omega1"] / rate - true_spin).max() < 2e-12
    assert max(steps) <= 1.05 * min(steps)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["heyoka", "scipy", "flint"])
def test_powers_of_a_short_length_cost_no_digits(method: str) -> None:
    """A quartic potential x^4/l^3: in fixed point the roundings of x^3 are 1/l^3 times as large."""
    x, y, length = sp.symbols("x y l")
    Dx, Dy = vo.velocity(x), vo.velocity(y)
    potential = x**4 / (4 * length**3) + y**2 / (2 * length) + x**2 * y**2 / length**3
    made = vo.System(
        name="quartic",
        fibration=vo.Fibration((x, y)),
        lagrangian=(Dx**2 + Dy**2) / 2 - length * potential,
        parameters=(length,),
    )
    ends = []
    for size in (1.0, 2.0**-30, 2.0**30):
        run = vo.integrate(
            made, initial={x: size, Dy: 0.25 * size}, parameters={length: size}, times=[0, 7, 20],
            method=method, tol=1e-20 if method == "flint" else 1e-13,
        )  # fmt: skip
        ends.append([float(run[name][-1]) / size for name in ("x", "ydot")])
    assert np.ptp(ends, axis=0).max() < 1e-11


@pytest.mark.slow
@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_motions_of_many_sizes_at_once(ball: vo.VoronecEquations, method: str) -> None:
    """An ensemble of balls, and a section, whose units of length differ from motion to motion."""
    truth = vo.integrate(ball, times=TIMES, outputs=("x", "omega1"), tol=1e-20)
    true_x, true_spin = (truth[name].astype(float) for name in ("x", "omega1"))
    sizes = np.array([1.0, 1e9, 1e-9, 1e6, 3e8])
    given = {f"I{i}": x * sizes**2 for i, x in enumerate((0.4, 0.5, 0.7), 1)} | {"R": sizes}
    start = {"omega1": 0.5, "omega2": 2.0, "omega3": 0.2, "theta": np.ones(5)}
    run = vo.ensemble(ball, start, given, TIMES, ("x", "omega1"), method=method)
    assert not run.errors
    assert np.abs(run["x"] / sizes[:, None] - true_x).max() < 2e-11
    assert np.abs(run["omega1"] - true_spin).max() < 2e-12
    points = vo.section(
        ball, "omega1", ("x", "omega2"), parameters=given, crossings=3, method=method,
        starts=start, value=1,
    )  # fmt: skip
    for column in (points["x"] / sizes[points.start], points["omega2"], points.t):
        rows = column.reshape(5, 3)
        assert np.abs(rows - rows[0]).max() < 2e-11


@pytest.mark.parametrize("method", ["heyoka", "scipy"])
def test_rates_that_are_rounding_tell_no_time(method: str) -> None:
    x, z, p, q = sp.symbols("x z p q")
    fast = vo.System(
        name="fast",
        fibration=vo.Fibration(base=(x, z)),
        lagrangian=(vo.velocity(x) ** 2 + vo.velocity(z) ** 2) / 2,
        forces={x: 3 * p - q, z: sp.cos(40 * sp.Symbol("t"))},
        parameters=(vo.Parameter(p, 0.1), vo.Parameter(q, 0.3)),
    )
    motion = vo.integrate(
        fast, initial={"xdot": 1}, times=TIMES, outputs=(vo.velocity(x), vo.velocity(z)),
        method=method,
    )  # fmt: skip
    found = motion[str(vo.velocity(z))]
    assert np.abs(found - np.sin(40 * TIMES) / 40).max() < 1e-11


def test_the_drift_of_a_small_integral_is_relative() -> None:
    x, k = sp.symbols("x k")
    energy = vo.velocity(x) ** 2 / 2 + k * x**2 / 2
    spring = vo.System(
        name="spring",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=vo.velocity(x) ** 2 / 2 - k * x**2 / 2,
        forces={x: -vo.velocity(x) * sp.Rational(1, 10**7)},
        parameters=(vo.Parameter(k, sp.Rational(1, 10**12), positive=True),),
        integrals={"energy": energy},
    )
    still = {x: 1, vo.velocity(x): 0}
    motion = vo.integrate(spring, initial=still, times=[0, 1e6], method="scipy", outputs=("x",))
    assert motion.drift["energy"] > 1e-3


@pytest.mark.parametrize("method", ["scipy", "lsoda", "heyoka"])
def test_what_is_small_since_large_terms_balance_has_their_size(method: str) -> None:
    """A pendulum held by a torque: no errors below the rounding of the torque are asked for."""
    angle = sp.Symbol("angle")
    swing = vo.velocity(angle)
    held = vo.System(
        name="held", fibration=vo.Fibration(base=(angle,), fibre=()),
        lagrangian=swing**2 / 2 + sp.cos(angle), constraints=(), forces={angle: sp.sin(1)},
    )  # fmt: skip
    runs = [
        vo.integrate(held, initial={"angle": 1, "angledot": s}, times=[0, 20], method=method)
        for s in (1e-3, 1e-10)
    ]
    assert runs[1].cost.steps <= 2 * runs[0].cost.steps
    assert abs(runs[1]["angle"][-1] - 1 - 1e-10 * np.sin(np.sqrt(np.cos(1)) * 20)
               / np.sqrt(np.cos(1))) < 1e-11  # fmt: skip


def test_a_rate_that_is_rounding_tells_no_size_of_what_is_at_rest() -> None:
    """A sleigh that friction holds: its speed is zero, and stays so but for rounding."""
    x, y, phi, v, w = sp.symbols("x y phi v w")
    dots = [vo.velocity(q) for q in (x, y, phi)]
    c, s = sp.cos(phi), sp.sin(phi)
    along = dots[0] * c + dots[1] * s
    sleigh = vo.System(
        name="held-sleigh", fibration=vo.Fibration(base=(x, phi), fibre=(y,)),
        lagrangian=sp.Rational(13, 40) * dots[2] ** 2 + sp.Rational(9, 20) * (
            (dots[0] - sp.Rational(13, 30) * dots[2] * s) ** 2
            + (dots[1] + sp.Rational(13, 30) * dots[2] * c) ** 2
        ),
        constraints=(dots[0] * s - dots[1] * c,),
        forces={
            x: -c * sp.sign(along) / 10, y: -s * sp.sign(along) / 10, phi: -sp.sign(dots[2]) / 10,
        },
        frame=vo.Frame.quasi({v: along, w: dots[2]}),
    )  # fmt: skip
    start = {"x": 0.027, "phi": 0, "y": 0.526, "v": -0.131, "w": 0.423}
    run = vo.integrate(sleigh, initial=start, times=[0, 1.968])
    assert abs(run["v"][-1]) < 1e-12 and run.cost.steps < 1000


@pytest.mark.parametrize("size", [1e-30, 1e-100, 1e-300])
def test_small_states_have_all_digits_in_integers(size: float) -> None:
    x = sp.Symbol("x")
    spring = vo.System(
        name="spring", fibration=vo.Fibration((x,)),
        lagrangian=vo.velocity(x) ** 2 / 2 - x**2 / 2,
    )  # fmt: skip
    run = vo.integrate(spring, initial={"x": size}, times=[0, 1], method="flint")
    assert float(run["x"][-1]) / size == pytest.approx(np.cos(1), rel=1e-13)


def test_a_sleigh_in_units_far_apart_takes_the_same_steps() -> None:
    """m, J and a enter only as m a/(J + m a^2); a w^2 vanishes beside v."""
    sleigh = vo.derive(vo.load("sleigh"))
    runs = [
        vo.integrate(sleigh, times=[0, 8], parameters={"m": m, "J": J, "a": a}, method="heyoka")
        for m, J, a in ((1e-100, 1e-300, 1e-200), (1, 1e-40, 1e-40))
    ]
    assert runs[0].cost.steps == runs[1].cost.steps
    for run in runs:  # v = -1, w = 0.05 e^t
        assert run["w"][-1] == pytest.approx(0.05 * np.exp(8), rel=1e-12)
        assert run["phi"][-1] == pytest.approx(0.05 * (np.exp(8) - 1), rel=1e-12)


@pytest.mark.slow
def test_terms_that_cancel_in_every_state_show_as_well() -> None:
    """A roller racer comes to run in a circle, phidot falls to 1e-13: its rate is the difference of
    terms of order 100, at every angle of the joint, and rounding of these is not to be resolved."""
    theta, phi, x, y = sp.symbols("theta phi x y")
    turn, bend, along, across = map(vo.velocity, (theta, phi, x, y))
    joint = (along - 1.4 * turn * sp.sin(theta), across + 1.4 * turn * sp.cos(theta))
    racer = vo.System(
        name="racer", fibration=vo.Fibration(base=(theta, phi), fibre=(x, y)),
        lagrangian=5 * turn**2 / 8 + 27 * (along**2 + across**2) / 40 + (bend + turn) ** 2 / 4,
        constraints=(
            across * sp.cos(theta) - along * sp.sin(theta),
            joint[1] * sp.cos(phi + theta) - joint[0] * sp.sin(phi + theta) + 1.5 * (bend + turn),
        ),
    )  # fmt: skip
    start = {
        "theta": 1.142, "phi": -0.261, "x": 0.219, "y": 2.242, "thetadot": -1.344, "phidot": 0.51,
    }  # fmt: skip
    times = [0, 5.3, 7]
    truth = vo.integrate(racer, initial=start, times=times, outputs=("x", "phi"), method="heyoka")
    found = vo.integrate(racer, initial=start, times=times, outputs=("x", "phi"), method="lsoda")
    assert np.abs(found["x"] - truth["x"]).max() < 1e-7
    assert found.cost.steps < 3000


@pytest.mark.slow
def test_the_rounding_of_a_rate_that_is_all_but_zero_does_not_shorten_steps() -> None:
    """A racer settles into a steady turn, from split to split; phidot is rounding there, in units
    in which it is large."""
    theta, phi, x, y = sp.symbols("theta phi x y")
    turn, swing, vx, vy = sp.symbols("thetadot phidot xdot ydot")
    racer = vo.System(
        name="racer",
        fibration=vo.Fibration(base=(x, phi), fibre=(y, theta)),
        lagrangian=vx**2 / 2 + vy**2 / 2 + 3 * turn**2 / 20 + (swing + turn) ** 2 / 10,
        constraints=(
            vy * sp.cos(theta) - vx * sp.sin(theta),
            sp.Rational(3, 4) * (swing + turn)
            - (vx - turn * sp.sin(theta) / 2) * sp.sin(phi + theta)
            + (vy + turn * sp.cos(theta) / 2) * sp.cos(phi + theta),
        ),
    )
    start = {"x": -0.749, "phi": 0.385, "y": 0.437, "theta": 1.125, "xdot": -1.519, "phidot": 1.817}
    times = np.concatenate([[0.0], np.linspace(120, 132.55, 20)])
    motion = vo.integrate(racer, initial=start, times=times)
    assert motion.cost.steps < 5000
    assert np.ptp(motion["phi"][1:]) < 1e-10
    rate = np.diff(motion["theta"][1:]) / np.diff(times[1:])
    assert np.ptp(rate) < 1e-10


@pytest.mark.parametrize("method", ["heyoka", "scipy", "lsoda", "c"])
@pytest.mark.parametrize("a", [1e-8, 1e-9, 1e-11])
def test_slow_velocities_tell_no_length_where_the_body_turns(method: str, a: float) -> None:
    """The sleigh goes round within a unit of time: its way is as long as it is in that, and not in
    the time in which its velocities change.  The truth is that of the first order in a."""
    v, w, first, J, end = 0.75, 2.0, 0.25, 0.5, 4.0
    run = vo.integrate(
        vo.load("sleigh"), initial={"v": v, "w": w, "phi": first}, times=[0, end], method=method,
        parameters={"a": a, "m": 1, "J": J},
    )  # fmt: skip
    t, weights = np.polynomial.legendre.leggauss(40)
    t = (t + 1) * end / 2
    speeds = v + a * w**2 * t - 1j * v * (a * v * w / J) * t**2 / 2
    place = (weights * speeds * np.exp(1j * (first + w * t))).sum() * end / 2
    assert abs(complex(run["x"][-1], run["y"][-1]) - place) < 5e-13


@pytest.mark.filterwarnings("error")
def test_first_steps_that_are_short_in_their_units_do_not_keep_later_ones_short() -> None:
    """A large place and a small speed, which is soon as large, in an ensemble."""
    x = sp.Symbol("x")
    rate = vo.velocity(x)
    spring = vo.System("spring", vo.Fibration((x,)), (rate**2 - x**2) / 2)
    runs = vo.ensemble(spring, {x: [0.0, 1e60], rate: 1.0}, times=[0, 1])
    assert runs.cost.steps < 1000 and abs(runs["x"][1, -1] / 1e60 - np.cos(1)) < 1e-12
    free = vo.System("free", vo.Fibration((x,)), rate**2 / 2)
    far = vo.ensemble(free, {x: [1.0, 2.0], rate: 1.0}, times=[0, 1e308], method="heyoka")
    assert (far["x"][:, -1] == 1e308).all()


def spring(mass: float, length: float, time: float) -> dict[str, object]:
    """A stiffening spring in other units: what ``integrate`` and its kin are given; a claim of it
    is wrong."""
    x, m, k, size = sp.symbols("x m k size", positive=True)
    dot = vo.velocity(x)
    pull = k * x**2 / 2 + k * x**4 / (4 * size**2)
    system = vo.System(
        name="spring",
        fibration=vo.Fibration(base=(x,)),
        lagrangian=m * dot**2 / 2 - pull,
        parameters=(m, k, size),
        integrals={"energy": m * dot**2 / 2 + pull, "wrong": m * dot**2},
    )
    given = {"m": mass, "k": mass / time**2, "size": length}
    return {"system": system, "parameters": given, "method": "scipy", "tol": 1e-10}


@pytest.mark.slow
@pytest.mark.parametrize("many", ["integrate", "ensemble", "section"])
def test_the_drift_is_that_of_other_units(many: str) -> None:
    """Absolute numbers stood for sizes: of masses of 1e-20 the drift seemed to be 1e-34."""

    def drifts(mass: float, length: float, time: float) -> list[float]:
        given = spring(mass, length, time)
        times = time * np.linspace(0, 10, 51)
        starts = {"x": length * np.array([1.0, 0.5, 0.0]), "xdot": [0, 0, length / time]}
        if many == "integrate":
            start = {name: values[0] for name, values in starts.items()}
            drift = vo.integrate(initial=start, times=times, **given).drift
        elif many == "ensemble":
            drift = vo.ensemble(starts=starts, times=times, **given).drift
        else:
            end = 20 * time
            found = vo.section(plane="x", starts=starts, crossings=3, until=end, **given)
            drift = {**found.drift, "wrong": np.ones(3)}  # it is equal at all crossings but one
        return [np.atleast_1d(drift[name]) for name in ("energy", "wrong")]

    for mass, length, time in ((1e-20, 1, 1), (1, 1e20, 1), (1, 1, 1e-20), (1e-20, 1e20, 1e20)):
        energy, wrong = drifts(mass, length, time)
        assert (energy > 1e-16).all() and (energy < 1e-8).all(), (mass, length, time)
        assert wrong == pytest.approx(np.ones(len(wrong)), abs=0.02)
