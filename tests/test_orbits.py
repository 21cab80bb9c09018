"""Variational equations, periodic orbits with their multipliers, Lyapunov exponents and rotation
numbers, against closed forms, finite differences in many digits and published values."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares
from scipy.special import ellipk, mathieu_a, mathieu_b

import voronec as vo
from voronec.cli import main
from voronec.dynamics import PhaseSpace, variational_flow

x, y, z, tau = sp.symbols("x y z tau")
vx, vy = vo.velocity(x), vo.velocity(y)
delta, eps = sp.symbols("delta epsilon")


def pendulum() -> vo.System:
    energy = vx**2 / 2 + 1 - sp.cos(x)
    lagrangian = vx**2 / 2 + sp.cos(x)
    plane = vo.Fibration(base=(x,))
    return vo.System("pendulum", plane, lagrangian, integrals={"energy": energy})


def mathieu() -> vo.System:
    """x = A cos t, y = 0 is a motion; beside it y'' + (delta + epsilon A cos t) y = 0."""
    potential = x**2 / 2 + y**2 * (delta + eps * x) / 2
    kinetic = (vx**2 + vy**2) / 2
    return vo.System(
        "mathieu", vo.Fibration(base=(x, y)), kinetic - potential,
        parameters=(vo.Parameter(delta, 0.3), vo.Parameter(eps, 0.2)),
        integrals={"energy": kinetic + potential},
    )  # fmt: skip


def henon_heiles() -> vo.System:
    potential = (x**2 + y**2) / 2 + x**2 * y - y**3 / 3
    kinetic = (vx**2 + vy**2) / 2
    return vo.System(
        "henon-heiles", vo.Fibration(base=(x, y)), kinetic - potential,
        integrals={"energy": kinetic + potential},
    )  # fmt: skip


def lorenz() -> vo.System:
    """The equations of Lorenz as constraints; what is free moves uniformly."""
    v = vo.velocity
    rows = (v(x) - 10 * (y - x), v(y) - x * (28 - z) + y, v(z) - x * y + sp.Rational(8, 3) * z)
    return vo.System("lorenz", vo.Fibration(base=(tau,), fibre=(x, y, z)), v(tau) ** 2 / 2, rows)


@pytest.mark.slow
def test_variations_are_finite_differences_in_many_digits() -> None:
    space = PhaseSpace.of(henon_heiles(), None, {"x": 0.1, "y": -0.2, vx: 0.3}, None, None, ())
    flow, start, end = space.flow(), space.motions.states[0], 1.0
    state = flow.start(start)
    flow.go(state, end, space.motions.values[0], 1e-14)

    def rates(_: Any, s: Any) -> list[Any]:
        own = dict(zip(space.names, s, strict=True))
        a, b = own["x"], own["y"]
        slopes = {"x": own["xdot"], "y": own["ydot"], "xdot": -a - 2 * a * b,
                  "ydot": -b - a**2 + b**2}  # fmt: skip
        return [slopes[name] for name in space.names]

    with mp.workdps(40):

        def at(s: Any) -> Any:
            return mp.matrix(mp.odefun(rates, 0, s, tol=mp.mpf(10) ** -30)(end))

        base, step = [mp.mpf(float(s)) for s in start], mp.mpf(10) ** -12
        for j in range(4):
            up, down = ([*base[:j], base[j] + h, *base[j + 1 :]] for h in (step, -step))
            slope = (at(up) - at(down)) / (2 * step)
            assert np.allclose(state.columns[:, j], [float(s) for s in slope], atol=1e-12)


def test_without_a_compiler_scipy_gives_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    start = {"x": 0.1, "y": -0.2, vx: 0.3}
    space = PhaseSpace.of(henon_heiles(), None, start, None, None, ())
    compiled = space.flow()
    monkeypatch.setenv("PATH", "")
    by_scipy = variational_flow.__wrapped__(space.motions.program)
    assert compiled.compiled
    assert not by_scipy.compiled
    found = []
    for flow in (compiled, by_scipy):
        state = flow.start(space.motions.states[0])
        flow.go(state, 20.0, space.motions.values[0], 1e-12, 4)
        found.append([*state.x, *state.logs, state.divergence])
    assert np.allclose(*found, atol=1e-8)


def test_a_pendulum_has_its_period_in_closed_form() -> None:
    family = vo.periodic(
        pendulum(), initial={"x": 1.0}, variables=("x",), along="energy", to=1.8, points=9
    )
    assert family.ended == "complete"
    assert family["energy"][-1] == pytest.approx(1.8, abs=1e-11)
    for orbit in family:
        assert orbit.period == pytest.approx(4 * ellipk(orbit["energy"] / 2), abs=1e-10)
        assert orbit.closure < 1e-10
        assert len(orbit.trivial) == 2
        assert orbit.trivial_defect < 1e-8


def test_a_pendulum_that_turns_over_closes_up_to_a_turn() -> None:
    (orbit,) = vo.periodic(pendulum(), initial={"x": 0.0, vx: 2.5}, variables=("x",))
    assert [*orbit.turns] == [1, 0]
    square = 4 / 2.5**2  # of the modulus, with which T = 2 k K(k)
    speed = np.sqrt(2 * orbit["energy"])
    square = 4 / speed**2
    assert orbit.period == pytest.approx(4 / speed * ellipk(square), abs=1e-10)


@pytest.mark.slow
def test_periods_double_where_mathieu_functions_say() -> None:
    """delta + epsilon A cos t with t = 2 s is Mathieu's equation, a = 4 delta, q = -2 epsilon A;
    solutions change their sign after a period of x on a_1 and b_1."""
    amplitude, strength = 1.0, 0.2
    family = vo.periodic(
        mathieu(), initial={"x": amplitude}, variables=("x", "y"), parameters={"delta": 0.12},
        hold=("energy",), along="delta", to=0.4, points=15,
    )  # fmt: skip
    q = 2 * strength * amplitude
    expected = sorted([float(mathieu_a(1, q)) / 4, float(mathieu_b(1, q)) / 4])
    assert sorted(c.value for c in family.doublings) == pytest.approx(expected, abs=1e-9)
    inside = [expected[0] < d < expected[1] for d in family["delta"]]
    assert [o.stability == "unstable" for o in family] == inside
    assert [line.get_xdata()[0] for line in family.plot().axes[2].lines[-2:]] == [
        c.value for c in family.doublings
    ]
    for orbit in family:
        assert orbit.period == pytest.approx(2 * np.pi, abs=1e-9)
        assert abs(np.prod(orbit.multipliers) - 1) < 1e-9  # areas are preserved


def test_a_driven_oscillator_has_the_multipliers_of_its_damping() -> None:
    """x'' + 2 c x' + x = cos(w t): after a period T exp(-c T) exp(+-i sqrt(1 - c^2) T)."""
    c, w = 0.1, 1.3
    force = sp.cos(sp.Float(w) * vo.time) - 2 * c * vx
    system = vo.System("driven", vo.Fibration(base=(x,)), vx**2 / 2 - x**2 / 2, forces={x: force})
    span = 2 * np.pi / w
    (orbit,) = vo.periodic(system, initial={"x": 0.3}, period=span, variables=("x",))
    steady = 1 / (1 - w**2 + 2j * c * w)
    assert orbit["x"] == pytest.approx(steady.real, abs=1e-10)
    assert orbit.stability == "asymptotically stable"
    expected = np.exp((-c + 1j * np.sqrt(1 - c**2)) * span)
    assert np.abs(orbit.multipliers - expected).min() < 1e-9
    assert len(orbit.trivial) == 0
    with pytest.raises(vo.DefinitionError, match="give the period"):
        vo.periodic(system, initial={"x": 0.3}, variables=("x",))


@pytest.mark.parametrize(("start", "period"), [(1.0, 6.5), (0.5, 6.0), (2.0, None)])
def test_the_cycle_of_van_der_pol_is_found_from_inside_and_outside(
    start: float, period: float | None
) -> None:
    system = vo.System(
        "van-der-pol", vo.Fibration(base=(x,)), (vx**2 - x**2) / 2, forces={x: (1 - x**2) * vx}
    )
    (orbit,) = vo.periodic(system, initial={"x": start}, period=period, variables=("x",))
    assert orbit.period == pytest.approx(6.66328685932313, abs=1e-11)
    assert orbit.stability == "asymptotically stable"


def test_multiple_shooting_finds_what_single_shooting_does() -> None:
    one, five = (
        vo.periodic(henon_heiles(), initial={"y": 0.3}, variables=("x", "y"), hold=("energy",),
                    segments=m).orbits[0]
        for m in (1, 5)
    )  # fmt: skip
    assert five.period == pytest.approx(one.period, abs=1e-9)
    assert np.allclose(
        np.sort_complex(five.multipliers), np.sort_complex(one.multipliers), atol=1e-7
    )
    assert one["energy"] == pytest.approx(0.3**2 / 2 - 0.3**3 / 3, abs=1e-12)


def test_a_family_of_the_falling_disc_keeps_its_trivial_multipliers(tmp_path: Path) -> None:
    family = vo.periodic(vo.load("falling-disc"), along="R", to=1.1, points=4)
    assert family["R"][0] == pytest.approx(1.0)
    assert family["R"][-1] == pytest.approx(1.1)
    assert max(orbit.closure for orbit in family) < 1e-10
    assert max(orbit.trivial_defect for orbit in family) < 1e-8
    assert {len(orbit.trivial) for orbit in family} == {4}  # flow, energy, relation, R
    table = np.genfromtxt(family.save(tmp_path / "family.csv"), delimiter=",", names=True)
    assert [*table["R"]] == [*family["R"]]
    assert [*table["period"]] == [*family["period"]]


def test_multipliers_of_a_ball_are_those_of_its_equations_by_hand() -> None:
    """Chaplygin's ball by hand: (I + D) w - D (g, w) g = G, g' = g x w, G' = G x w; its slopes
    after a period are imaginary parts of motions that start beside it by 1e-30 i, without
    differences of what is nearly equal, and it closes."""
    (orbit,) = vo.periodic(vo.load("chaplygin-ball"))
    values = orbit.parameters
    assert orbit.variables == ("gamma1", "gamma2", "gamma3", "omega1", "omega2", "omega3")
    inertia = np.array([float(values[name]) for name in ("I1", "I2", "I3")])
    d = float(values["m"]) * float(values["R"]) ** 2
    a = 1 / (inertia + d)

    def rates(_: float, s: np.ndarray) -> np.ndarray:
        """Of one motion in each column."""
        g, big = s.reshape(2, 3, -1)
        c = d * (a @ (g * big)) / (1 - d * (a @ g**2))
        w = a[:, None] * (big + c * g)
        return np.concatenate([np.cross(g, w, axis=0), np.cross(big, w, axis=0)]).ravel()

    g, w = np.array(orbit.state, dtype=float).reshape(2, 3)
    start = np.concatenate([g, (inertia + d) * w - d * (g @ w) * g])
    beside = np.column_stack([start, start[:, None] + 1e-30j * np.eye(6)])
    span = (0, float(orbit.period))
    run = solve_ivp(rates, span, beside.ravel(), "DOP853", span[1:], rtol=3e-14, atol=1e-15)
    ends = run.y[:, -1].reshape(6, 7)
    assert np.abs(ends[:, 0] - start).max() < 1e-10
    found = sorted(np.linalg.eigvals(ends[:, 1:].imag / 1e-30).real, reverse=True)
    assert found[0] == pytest.approx(orbit.multipliers[0].real, abs=1e-9)
    assert found[-1] == pytest.approx(orbit.multipliers[-1].real, abs=1e-9)
    assert np.allclose(found[1:-1], 1.0, atol=1e-3)  # Jordan blocks


def referee_field(system: vo.System, values: dict[str, float]) -> Any:
    """(q, v)' in doubles by multipliers, from what a system declares alone: M q'' - C^T l = -b,
    C q'' = -c."""
    q, v = [*system.coordinates], [*system.velocities]
    dots = [vo.velocity(x) for x in q]
    plain = {d: sp.Symbol(f"rate {i}") for i, d in enumerate(dots)}
    rates = [*plain.values()]
    given = {p.symbol: values[p.name] for p in system.parameters}
    frame = system.frame
    meaning = dict(zip(v, v, strict=True)) if frame is None else dict(frame.definitions)
    assert not system.forces
    relations = [sum(r.diff(x) * vo.velocity(x) for x in q) for r in system.fibration.relations]
    lagrangian, *rows = (
        sp.sympify(e).xreplace(meaning).xreplace(plain).xreplace(given)
        for e in (system.lagrangian, *system.constraints, *relations, *(meaning[w] for w in v))
    )
    rows, quasi = sp.Matrix(rows[: -len(v)] or [[]]), sp.Matrix(rows[-len(v) :])
    momenta, moving = sp.Matrix([lagrangian]).jacobian(rates), sp.Matrix(rates)
    bias = momenta.jacobian(q) * moving - sp.Matrix([lagrangian]).jacobian(q).T
    still = dict.fromkeys(rates, 0)
    parts = [momenta.jacobian(rates), bias, rows.jacobian(rates), rows.jacobian(q) * moving,
             quasi.jacobian(rates), quasi.jacobian(q) * moving,
             rows.xreplace(still), quasi.xreplace(still)]  # fmt: skip
    by_place = sp.lambdify([q], [parts[i] for i in (2, 4, 6, 7)], cse=True)
    everything = sp.lambdify([q, rates], parts[:6], cse=True)

    def field(_: float, x: np.ndarray) -> np.ndarray:
        place, speeds = x[: len(q)], x[len(q) :]
        c, w, c0, w0 = by_place(place)
        going = np.linalg.solve(np.vstack([c, w]), np.append(-c0, speeds - w0.ravel()))
        mass, b, c, bent, w, turned = everything(place, going)
        k = len(c)
        whole = np.block([[mass, c.T], [c, np.zeros((k, k))]])
        found = np.linalg.solve(whole, -np.concatenate([b.ravel(), bent.ravel()]))
        return np.concatenate([going, w @ found[: len(q)] + turned.ravel()])

    return field


WEAVE = {
    "phi": 0.00164, "delta": 0.00007, "theta": 0.00168, "roll_rate": 0.01483, "steer_rate": 0.01909,
    "speed": 4.30388,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("bicycle", WEAVE),
        ("falling-disc", {}),
        ("sleigh-on-turntable", {}),
        ("ball-on-sphere", {"u": 1, "theta": 1, "u1": 1, "omega1": 0, "omega2": 0, "omega3": 1}),
    ],
)
def test_monodromies_are_slopes_of_the_multiplier_route(name: str, given: dict[str, Any]) -> None:
    system = vo.load(name)
    (orbit,) = vo.periodic(system, initial=given or None,
                           period=1.8268 if name == "bicycle" else None)  # fmt: skip
    assert orbit.closure < 1e-10
    ground = PhaseSpace.of(system, None, given or None, None, None, ()).motions.ground
    states = [sp.Symbol(str(s)) for s in (*system.coordinates, *system.velocities)]
    values = dict(orbit.parameters)
    numbers = {sp.Symbol(n): x for n, x in values.items()}
    sigma = sp.Matrix([sp.sympify(e) for e in ground.start]).xreplace(numbers)
    place = sp.lambdify([states], sigma, cse=True)
    slopes = sp.lambdify([states], sigma.jacobian(states), cse=True)
    scene = {str(k): float(x) for k, x in system.scenes["default"].initial.items()} | given
    known = dict(zip(orbit.variables, orbit.state, strict=True))
    begin = [float(known.get(str(s), scene.get(str(s), 0.3))) for s in states]
    x = least_squares(lambda s: place(s).ravel() - orbit.state, begin, slopes,
                      xtol=1e-15, ftol=1e-15, gtol=1e-15).x  # fmt: skip
    field, step, ends = referee_field(system, values), 1e-30, []
    for row in np.eye(len(x)):  # slopes by imaginary steps lose no digits
        found = solve_ivp(field, (0, orbit.period), x + 1j * step * row, "DOP853", rtol=3e-14,
                          atol=1e-14)  # fmt: skip
        ends.append(place(found.y[:, -1]).ravel().imag / step)
    off = orbit.monodromy @ slopes(x) - np.array(ends).T
    assert np.abs(off).max() < 5e-11 * np.abs(orbit.monodromy).max()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"initial": {"x": 0.0}, "variables": ("x",)}, "equilibrium"),
        ({"initial": {"x": 1.0}, "variables": ("x",), "period": -1.0}, "above 0"),
        ({"initial": {"x": 1.0}, "variables": ("x",), "hold": ("enrgy",)}, "did you mean 'energy'"),
        ({"initial": {"x": 1.0}, "variables": ("x",), "along": "g", "to": 1.0}, "neither"),
        ({"initial": {"x": 1.0}, "variables": ("x",), "along": "energy"}, "both or none"),
        ({"initial": {"x": 1.0}, "variables": ("x",), "segments": 0}, "1 to"),
        ({"initial": {"x": 1.0}, "variables": ("x",), "points": 1}, "2 orbits"),
    ],
)
def test_a_guess_that_makes_no_sense_is_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(vo.DefinitionError, match=words):
        vo.periodic(pendulum(), **given)


def test_families_stay_where_parameters_have_a_meaning() -> None:
    with pytest.raises(vo.DefinitionError, match="must be positive"):
        vo.periodic(vo.load("falling-disc"), along="R", to=-1)


def test_an_unstable_cycle_is_found_among_motions_that_blow_up() -> None:
    x = sp.Symbol("x")
    rate = vo.velocity(x)
    backwards = vo.System("van der Pol backwards", vo.Fibration(base=(x,)), rate**2 / 2 - x**2 / 2,
                          forces={x: (x**2 - 1) * rate})  # fmt: skip
    (orbit,) = vo.periodic(backwards, initial={x: 2})
    assert orbit.period == pytest.approx(6.66328685932313, abs=1e-11)
    assert orbit.stability == "unstable"
    with pytest.raises(vo.VoronecError, match="singular"):
        vo.periodic(backwards, initial={x: 2.1})


@pytest.mark.slow
def test_exponents_of_lorenz_are_as_published() -> None:
    found = vo.exponents(
        lorenz(), initial={"x": 1, "y": 1, "z": 20}, variables=("x", "y", "z"), bar=0.01
    )
    published = np.array([0.9056, 0.0, -14.5723])  # [Sprott2003]
    assert found.is_settled[0]
    assert (np.abs(found.values[0] - published) <= found.bars[0] + 1e-4).all()
    assert found.zeros[0] == found.least_zeros[0] == 1
    assert found.divergence[0] == pytest.approx(-10 - 1 - 8 / 3, abs=1e-9)
    assert found.sum_defects[0] < 1e-7


def test_exponents_of_henon_and_heiles_come_in_pairs() -> None:
    start = {"x": 0, "y": -0.25, vx: 0.42081}
    found = vo.exponents(henon_heiles(), initial=start, bar=0.02, until=3e4)
    assert found.least_zeros[0] == found.zeros[0] == 2
    assert abs(found.values[0, 0] - 0.047) <= found.bars[0, 0]  # [Skokos2010]
    assert found.pair_defects[0] < 1e-8
    assert found.reversal is not None
    assert found.drift[0] < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["chaplygin-ball", "zhukovsky-ball", "bobylev-ball"])
def test_integrable_balls_have_zeros_alone(name: str) -> None:
    found = vo.exponents(vo.load(name), bar=0.01)
    assert found.is_settled[0]
    assert found.zeros[0] == len(found.variables)
    assert (np.abs(found.values) < 0.01).all()


def test_exponents_of_a_linear_system_are_real_parts() -> None:
    """x'' + 2 c x' + x = 0: both exponents are -c; a motion at rest is an equilibrium."""
    c = sp.Symbol("c")
    system = vo.System(
        "damped", vo.Fibration(base=(x,)), vx**2 / 2 - x**2 / 2, forces={x: -2 * c * vx},
        parameters=(vo.Parameter(c, 0.25),),
    )  # fmt: skip
    found = vo.exponents(system, starts=[{"x": 1.0}, {"x": 0.5}], variables=("x",), bar=1e-2)
    assert (np.abs(found.values + 0.25) <= found.bars).all()
    assert [*found.least_zeros] == [0, 0]
    table = found.to_pandas()
    assert len(table) == 4


def test_rough_right_sides_are_refused() -> None:
    system = vo.System(
        "rough", vo.Fibration(base=(x,)), vx**2 / 2 - x**2 / 2, forces={x: -sp.sign(vx)}
    )
    with pytest.raises(vo.DefinitionError, match="not smooth"):
        vo.exponents(system, initial={"x": 1.0}, variables=("x",))


@pytest.mark.slow
@pytest.mark.parametrize(
    "given", [{"count": 0}, {"count": 9}, {"bar": 0.0}, {"until": -1.0}, {"initial": {"a": 1}}]
)
def test_numbers_that_make_no_sense_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(vo.DefinitionError):
        vo.exponents(vo.load("chaplygin-ball"), **given)


def test_the_command_line_tells_exponents(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exponents", "chaplygin-ball", "--bar", "0.02", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["zeros"] == 6
    assert found["settled"]
    assert main(["exponents", "chaplygin-ball", "--bar", "1e-9", "--until", "100"]) == 1
    said = capsys.readouterr()
    assert "not settled" in said.out
    assert "have settled" in said.err
    assert main(["exponents", "chaplygin-ball", "--bar", "-1"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_the_command_line_tells_orbits(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["periodic", "falling-disc", "--along", "R=1.05", "--points", "3"]
    assert main([*words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["ended"] == "complete"
    assert all(orbit["trivial_defect"] < 1e-8 for orbit in found["orbits"])
    assert main(words) == 0
    assert "spectrally stable" in capsys.readouterr().out
    assert main(["periodic", "falling-disc", "--along", "radius=2"]) == 2
    assert "neither a proved integral nor a parameter" in capsys.readouterr().err


@pytest.mark.slow
def test_portraits_of_henon_and_heiles_are_symmetric_and_tell_chaos() -> None:
    sections = []
    for energy, lows in ((1 / 12, (0.1, 0.3)), (1 / 8, (0.3, -0.15))):
        rows = [
            {"x": 0, "y": low, vy: 0, vx: float(np.sqrt(2 * energy - low**2 + 2 * low**3 / 3))}
            for low in lows
        ]
        sections.append(vo.section(henon_heiles(), "x", ("y", "ydot"), starts=rows, crossings=150))
    found = vo.section_portrait(sections)
    # (x, y) -> (-x, y) with the time reversed keeps x = 0 and the crossings upwards
    assert found.reflections == ((1, -1),)
    assert found.numbers[0].bars.max() < 1e-4 < 3e-3 < found.numbers[1].bars[1]
    panels = found.plot().axes
    assert [panel.get_xlabel() for panel in panels[:2]] == ["$y$", "$y$"]
    with pytest.raises(vo.DefinitionError, match="differ in their system, plane"):
        vo.section_portrait([sections[0], replace(sections[0], value=1.0)])


def test_rotation_numbers_of_independent_oscillators_are_quotients() -> None:
    """Between two passages of x through 0 the other oscillator turns by its frequency."""
    root = sp.sqrt(2)
    system = vo.System(
        "oscillators", vo.Fibration(base=(x, y)), (vx**2 + vy**2 - x**2 - 2 * y**2) / 2
    )
    found = vo.section(
        system, "x", ("y", "ydot"), starts=[{vx: 1.0, "y": 0.5}, {vx: 1.0}], crossings=400
    )
    numbers = vo.rotation_numbers(found)
    # (y, y') turns clockwise, by a part 1 - (sqrt 2 - 1) from y to y'
    assert numbers.values[0] == pytest.approx(1 - float(root - 1), abs=1e-8)
    assert numbers.bars[0] < 1e-6
    assert np.isnan(numbers.values[1])  # a single point has none


def test_slow_rotation_numbers_of_a_pendulum_lie_within_their_bars() -> None:
    """Small swings are almost as fast as the oscillator that shows their section."""
    system = vo.System("pendulum beside an oscillator", vo.Fibration(base=(x, y)),
                       (vx**2 + vy**2 - y**2) / 2 + sp.cos(x))  # fmt: skip
    starts = [{x: a, vy: 1.0} for a in (0.2, 0.3, 0.5)]
    found = vo.section(system, "y", ("x", "xdot"), starts=starts, crossings=400)
    numbers = vo.rotation_numbers(found)
    periods = [float(4 * mp.ellipk(mp.sin(start[x] / 2) ** 2)) for start in starts]
    off = np.abs(numbers.values - (1 - 2 * np.pi / np.array(periods)))
    # the first goes less than once around in 400 steps
    assert np.isnan(off[0]) and (off[1:] <= numbers.bars[1:]).all()


def test_sweeps_record_exponents(tmp_path: Any) -> None:
    found = vo.sweep(
        pendulum(), {"x": [0.5, 1.0]}, record=["exponents(2)"], out=tmp_path / "run.zarr",
        times=200.0, jobs=1, initial={"xdot": 0.1},
    )  # fmt: skip
    table = found.to_xarray()
    assert (np.abs(table["exponent(1)"]) <= table["bar(1)"] + 1e-9).all()
    assert (table["exponent(2)"] <= table["exponent(1)"]).all()
