"""Steady motions, their families, spectra and critical values."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
import sympy as sp
from command_line import Call, refused
from scipy.linalg import qr

import voronec as vo
from voronec.errors import DefinitionError, EngineLimit

SMALL = (-30, 30)


def moving(name: str, at: Mapping[str, Any], **options: Any) -> vo.SteadyMotion:
    """The motion with these values, one that is not at rest where there is one."""
    found = vo.steady(vo.load(name), at=at, **options)
    return next((m for m in found if not m.is_rest), found[0])


@pytest.mark.parametrize("lean", ["1/5", "1/2", "-7/10"])
def test_steady_turns_of_a_disc_balance_their_moments(lean: str) -> None:
    motion = moving("falling-disc", {"gamma3": lean, "s": "3/2"})
    g2, g3, p, q, s = motion.y
    # m g R sin - A tan q^2 - (C + m R^2) q s = 0 with m = g = R = 1, A = 1/4, C = 1/2
    assert g3 - g3 / g2 * q**2 / 4 - 1.5 * q * s == pytest.approx(0, abs=1e-12)
    assert p == 0 and g3 == pytest.approx(float(sp.Rational(lean)), abs=1e-14)


def test_a_steady_motion_stays_as_it_is() -> None:
    motion = moving("falling-disc", {"gamma3": "1/2", "s": 2, "gamma2": "sqrt(3)/2"})
    start = {"theta": sp.pi / 6, "p": 0, "q": motion.point["q"], "s": 2}
    found = vo.integrate(vo.load("falling-disc"), initial=start, times=np.linspace(0, 20, 21),
                         outputs=("theta", "q", "s"))  # fmt: skip
    assert max(np.ptp(found[name]) for name in ("theta", "q", "s")) < 1e-10


@pytest.mark.slow
def test_families_are_told_apart_by_what_vanishes_and_by_their_dimension() -> None:
    found = vo.steady(vo.load("suslov"))
    # rest is one of the line of turns, where the linearisation vanishes
    assert [(m.kind, m.dimension) for m in found] == [("rest", 1), ("permanent rotation", 1)]
    assert [m.is_singular for m in found] == [True, False]
    turning = found[1]
    # about the axis M3 = I13 omega1 + I23 omega2 = 0
    assert turning.point["omega1"] / 5 + 2 * turning.point["omega2"] / 5 == pytest.approx(0)


@pytest.mark.parametrize(
    ("name", "at", "kind"),
    [
        ("falling-disc", {"gamma3": 0, "q": 0, "s": 2}, "uniform rolling"),
        ("falling-disc", {"gamma3": 0, "q": 2, "s": 0}, "permanent rotation"),  # on its place
        ("chaplygin-ball", {"gamma3": 1, "omega3": 1}, "permanent rotation"),
        ("two-wheeled-carriage", {}, "uniform rolling"),
        ("sleigh", {}, "steady motion"),  # it slides
    ],
)
def test_steady_motions_are_called_as_in_mechanics(
    name: str, at: Mapping[str, Any], kind: str
) -> None:
    assert moving(name, at, starts=20).kind == kind


@pytest.mark.slow
def test_instability_is_proved_by_an_enclosed_eigenvalue() -> None:
    ball = moving("chaplygin-ball", {"gamma2": 1, "omega2": 1})
    assert ball.verdict.word == "unstable" and ball.verdict.proved
    suslov = moving("suslov", {"omega2": -1})
    assert suslov.verdict.proved
    assert moving("suslov", {"omega2": 1}).verdict.word == "linearly attracting"


ALPHA, BETA, PHI, MU, OMEGA, X = sp.symbols("alpha beta phi mu omega x")
DA, DB, DPHI, DX = map(vo.velocity, (ALPHA, BETA, PHI, X))
DOUBLE = vo.System(
    "double pendulum", vo.Fibration(base=(ALPHA, BETA)),
    DA**2 + DB**2 / 2 + sp.cos(ALPHA - BETA) * DA * DB + 2 * sp.cos(ALPHA) + sp.cos(BETA),
)  # fmt: skip
SPHERICAL = vo.System(
    "spherical pendulum", vo.Fibration(base=(ALPHA, PHI)),
    (DA**2 + sp.sin(ALPHA) ** 2 * DPHI**2) / 2 + sp.cos(ALPHA),
)  # fmt: skip
BEAD = vo.System(
    "bead on a turning hoop", vo.Fibration(base=(ALPHA,)),
    (DA**2 + OMEGA**2 * sp.sin(ALPHA) ** 2) / 2 + 9 * sp.cos(ALPHA), forces={ALPHA: -DA},
    parameters=(OMEGA,),
)  # fmt: skip
VAN_DER_POL = vo.System(
    "van der Pol", vo.Fibration(base=(X,)), DX**2 / 2 - X**2 / 2,
    forces={X: MU * (1 - X**2) * DX}, parameters=(MU,),
)  # fmt: skip


def test_whole_turns_make_no_further_motions_and_each_inverted_one_is_proved_unstable() -> None:
    found = vo.steady(DOUBLE)
    places = {(round(m.y[0] / np.pi, 9), round(m.y[1] / np.pi, 9)): m.verdict for m in found}
    assert {*places} == {(0, 0), (0, 1), (1, 0), (1, 1)} and len(found) == 4
    assert all(verdict.proved for verdict in places.values())
    assert {at: v.word for at, v in places.items() if v.word == "stable"} == {(0, 0): "stable"}


def body(name: str, moments: tuple[Any, ...], potential: Any = 0, **parts: Any) -> vo.System:
    """A body about a fixed point, in Euler's angles; ``potential`` of the vertical in the body."""
    phi, theta, psi = sp.symbols("phi theta psi")
    rotation = vo.kinematics.Rotation.euler("zxz", phi, theta, psi)
    rates, gamma = rotation.body_rates, tuple(rotation.matrix.row(2))
    kinetic = sum(J * w**2 for J, w in zip(moments, rates, strict=True)) / 2
    return vo.System(
        name=name, fibration=vo.Fibration(base=(phi, theta, psi)),
        lagrangian=kinetic - (potential(*gamma) if potential else 0),
        frame=vo.Frame.quasi(dict(zip(sp.symbols("omega1:4"), rates, strict=True))),
        invariants=dict(zip(("gamma1", "gamma2", "gamma3"), gamma, strict=True)), **parts,
    )  # fmt: skip


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_free_body_is_proved_stable_about_its_least_and_its_largest_axis(axis: int) -> None:
    rates = sp.symbols("omega1:4")
    squared = sum((J * w) ** 2 for J, w in zip((1, 2, 3), rates, strict=True))
    free = body("free-body", (1, 2, 3), integrals={"momentum squared": squared})
    (turn,) = vo.steady(free, at={w: int(k == axis) for k, w in enumerate(rates, 1)})
    assert (turn.verdict.word, turn.verdict.proved) == ("unstable" if axis == 2 else "stable", True)


# C^2 w^2 = 4 A m g l is 4 for these values
@pytest.mark.slow
@pytest.mark.parametrize(("spin", "word"), [("201/100", "stable"), ("199/100", "unstable")])
def test_a_sleeping_top_is_proved_stable_above_the_critical_spin(spin: str, word: str) -> None:
    top = body("top", (1, 1, 1), lambda _a, _b, gamma3: gamma3)
    # of Euler's angles alone it is the pole
    angles = replace(top, frame=None, invariants={})
    for system in (top, angles):
        found = vo.steady(system, at={"gamma3": 1, "omega3": spin})
        (sleeping,) = (m for m in found if m.point.get("gamma3") == 1)
        assert (sleeping.verdict.word, sleeping.verdict.proved) == (word, True)
        assert not sleeping.is_rest
    hanging = vo.steady(top, at={"gamma3": -1, "omega3": 0})[0]
    assert hanging.is_rest and hanging.verdict.word == "stable" and hanging.verdict.proved


@pytest.mark.slow
def test_stability_is_proved_where_integrals_are_definite_and_nowhere_else() -> None:
    # the axes of the largest and of the least moment of a ball
    for axis in (1, 3):
        ball = moving("chaplygin-ball", {f"gamma{axis}": 1, f"omega{axis}": 1})
        assert ball.verdict.word == "stable" and ball.verdict.proved
        assert "momentum squared" in ball.verdict.witness
    # a ball at rest drifts away from its place, and a disc has no integrals but its energy
    resting = vo.steady(vo.load("chaplygin-ball"), at={"omega1": 0, "omega2": 0, "omega3": 0})
    rolling = moving("falling-disc", {"gamma3": 0, "q": 0, "s": 2})
    for motion in (*resting, rolling):
        assert motion.verdict.word == "spectrally stable" and not motion.verdict.proved
    # an integral that is declared and is none proves nothing
    hill = vo.System("hill", vo.Fibration(base=(X,)), vo.velocity(X) ** 2 / 2 + X**4,
                     integrals={"place": X**2})  # fmt: skip
    assert not vo.steady(hill, at={X: 0}, starts=5)[0].verdict.proved
    cone = vo.steady(SPHERICAL, at={"alpha": 1})[0]  # by the momentum of a cyclic coordinate
    assert cone.verdict.word == "stable" and "momentum of phi" in cone.verdict.witness


@pytest.mark.slow
def test_functions_that_constraints_hold_need_no_declaration() -> None:
    x, y, z = sp.symbols("x y z")
    vx, vy, vz = map(vo.velocity, (x, y, z))
    pendulum = vo.System(
        "pendulum by velocities", vo.Fibration(base=(x, y), fibre=(z,)),
        (vx**2 + vy**2 + vz**2) / 2 - z, (x * vx + y * vy + z * vz,),
        scenes={"default": vo.Scene(initial={z: -2, vx: 1}, times=(0, 1))},
    )  # fmt: skip
    found = {round(m.point["z"], 12): m for m in vo.steady(pendulum)}
    assert {at: m.verdict.word for at, m in found.items()} == {2: "unstable", -2: "stable"}
    assert "leaf function" in found[-2].verdict.witness
    assert found[-2].spectrum == pytest.approx([-1j, -1j, 1j, 1j] / np.sqrt(2))


def test_instability_by_a_double_eigenvalue_is_proved() -> None:
    rates = (DA**2 + DPHI**2) / 2
    bowl = vo.System("bowl", vo.Fibration(base=(ALPHA, PHI)),
                     rates - (ALPHA**2 + PHI**2 - 1) ** 2 / 4)  # fmt: skip
    top, ring = vo.steady(bowl)
    assert top.spectrum == pytest.approx([-1, -1, 1, 1])
    assert top.verdict.word == "unstable" and top.verdict.proved
    assert ring.dimension == 1 and ring.verdict.word == "spectrally stable"


@pytest.mark.slow
def test_a_constant_velocity_has_the_value_that_is_asked_for() -> None:
    board = vo.load("snakeboard")
    with pytest.raises(DefinitionError, match="of constants: phidot = "):
        vo.steady(board)  # the wheels turn in its scene
    found = vo.steady(board, at={"phidot": 0})
    assert found[0].dimension >= 2 and found[0].verdict.word == "spectrally stable"


@pytest.mark.slow
def test_a_spherical_pendulum_hangs_and_stands_at_the_poles_of_its_coordinates() -> None:
    cones = [m for m in vo.steady(SPHERICAL) if "alpha" in m.point]
    assert cones and all(abs(np.sin(m.point["alpha"])) > 1e-3 for m in cones)
    poles = {m.point["n3"]: m for m in vo.steady(SPHERICAL) if "n3" in m.point}
    assert {at: (m.kind, m.verdict.word) for at, m in poles.items()} == {
        1: ("rest", "stable"), -1: ("rest", "unstable")
    }  # fmt: skip
    assert all(m.verdict.proved and m.point["n1"] == m.point["n2"] == 0 for m in poles.values())
    assert poles[-1].spectrum == pytest.approx([-1, -1, 1, 1])


def test_steady_cones_of_a_spherical_pendulum() -> None:
    for cone in vo.steady(SPHERICAL, at={"alpha": 1}):
        assert cone.point["phidot"] ** 2 == pytest.approx(1 / np.cos(1))
        frequency = np.sqrt((1 + 3 * np.cos(1) ** 2) / np.cos(1))
        assert abs(cone.spectrum[-1].imag) == pytest.approx(frequency)


@pytest.mark.slow
def test_a_bead_at_the_critical_speed_is_alone_and_not_linearly_attracted() -> None:
    for at in ({}, {"alpha": 0}):
        low = next(m for m in vo.steady(BEAD, at=at, parameters={OMEGA: 3}) if m.y[0] == 0)
        assert low.dimension == 0 and low.zeros == 1
        assert low.verdict.word == "spectrally stable"
    (low,) = vo.steady(BEAD, at={"alpha": 0}, parameters={OMEGA: 2})
    assert low.verdict.word == "linearly attracting"


# at -1 a point of the curve lies on the critical value
@pytest.mark.parametrize("low", [-1, -1.3, -2])
def test_an_oscillator_of_van_der_pol_loses_stability_at_zero(low: float) -> None:
    (critical,) = vo.stability(VAN_DER_POL, "mu", (low, 3), parameters={MU: 1}).critical
    assert (critical.way, critical.below, critical.above) == ("pair", 0, 2)
    assert critical.value == pytest.approx(0, abs=1e-12)


@pytest.mark.slow
def test_roots_are_not_negative() -> None:
    for motion in vo.steady(vo.load("rattleback"), at={"omega3": 1}):
        assert motion.point["height"] > 0


def test_the_critical_spin_of_a_rolling_disc(tmp_path: Path) -> None:
    # s^2 = m g R A/(C (C + m R^2)) = 1/3
    found = moving("falling-disc", {"gamma3": 0, "q": 0, "s": 2}).along("s", (0, 3), hold="q")
    (critical,) = found.critical
    assert (critical.way, critical.below, critical.above) == ("real", 1, 0)
    with mp.workdps(30):
        assert abs(critical.exact - 1 / mp.sqrt(3)) < 1e-25
    assert {*found.unstable} == {0, 1}
    table = np.genfromtxt(found.save(tmp_path / "family.csv"), delimiter=",", names=True)
    assert [*table["s"]] == [*found.values]
    assert [*table["unstable_eigenvalues"]] == [*found.unstable]


def test_the_critical_spin_of_a_disc_on_its_edge_turning_about_the_vertical() -> None:
    # q^2 = m g R/(A + m R^2 - ...) : 4/5 with these values
    found = moving("falling-disc", {"gamma3": 0, "s": 0, "q": 1}).along("q", ("1/10", 3))
    (critical,) = found.critical
    with mp.workdps(30):
        assert abs(critical.exact**2 - mp.mpf(4) / 5) < 1e-25


@pytest.mark.slow
def test_a_rattleback_is_stable_one_way_above_a_threshold() -> None:
    motion = moving("rattleback", {"gamma3": 1, "omega3": "1/2"})
    found = motion.along("omega3", (-2, 2), count=40)
    low, high = found.critical
    assert low.way == high.way == "pair"
    assert low.value == pytest.approx(-high.value, abs=1e-12)
    assert [low.below, low.above, high.below, high.above] == [4, 2, 2, 0]


def test_a_parameter_changes_with_what_is_free_held() -> None:
    motion = moving("falling-disc", {"gamma3": 0, "q": 0, "s": 1})
    found = motion.along("g", ("1/10", 5), hold=("s", "q"))
    (critical,) = found.critical  # s^2 C (C + m R^2) = m g R A
    assert critical.value == pytest.approx(3, abs=1e-12)
    assert found.at(critical.value).point["g"] == pytest.approx(3)


def test_folds_and_branch_points_are_located() -> None:
    # x'' = a - x^2 - x' folds at a = 0; x'' = a x - x^3 - x' branches there
    x, a = sp.symbols("x a")
    for potential, kind in ((a * x - x**3 / 3, "fold"), (a * x**2 / 2 - x**4 / 4, "branch")):
        system = vo.System(
            name=kind, fibration=vo.Fibration(base=(x,), fibre=()), constraints=(),
            lagrangian=vo.velocity(x) ** 2 / 2 + potential,
            forces={x: -vo.velocity(x)}, parameters=(vo.Parameter(a, 1),),
        )  # fmt: skip
        (start,) = vo.steady(system, at={"x": 1} if kind == "fold" else {"x": 0})
        found = start.along("a", (-1, 2), count=50)
        if kind == "fold":
            assert found.folds == pytest.approx([0], abs=1e-10)
            assert found["x"].min() == pytest.approx(-np.sqrt(2), abs=1e-9)
            assert found.branch_points == ()
        else:
            assert found.branch_points == pytest.approx([0], abs=1e-10) and found.folds == ()
        (critical,) = found.critical
        assert critical.value == pytest.approx(0, abs=1e-10) and critical.way == "real"


@pytest.mark.parametrize("strength", [1, X**2])
def test_a_family_tells_where_it_passes_over_the_pole_of_a_logarithm(strength: Any) -> None:
    c = sp.Symbol("c")
    push = (c - X) * (1 + strength * sp.log(X**2) / 9) - DX
    system = vo.System("logarithm", vo.Fibration(base=(X,)), DX**2 / 2, forces={X: push},
                       parameters=(vo.Parameter(c, sp.Rational(1, 3)),))  # fmt: skip
    motion = vo.steady(system, at={X: sp.Rational(1, 3)})[0]
    assert motion.along(c, (-1, 1), count=20).logarithmic_poles == pytest.approx([0], abs=1e-9)
    assert motion.along(c, ("1/5", 1), count=20).logarithmic_poles == ()


def test_pairs_that_meet_on_the_imaginary_axis() -> None:
    # x'' = -w x + b y', y'' = -w y - b x' with w < 0 is stable for b^2 > -4 w
    x, y, b = sp.symbols("x y b")
    vx, vy = vo.velocity(x), vo.velocity(y)
    system = vo.System(
        name="gyroscopic", fibration=vo.Fibration(base=(x, y), fibre=()), constraints=(),
        lagrangian=(vx**2 + vy**2) / 2 + (x**2 + 2 * y**2) / 2,
        forces={x: b * vy, y: -b * vx}, parameters=(vo.Parameter(b, 1),),
    )  # fmt: skip
    (rest,) = vo.steady(system)
    family = rest.along("b", ("1/2", 5))
    (critical,) = family.critical
    # the energy is constant, but indefinite: what is stabilised by gyroscopic forces is not proved
    assert [part.motion.verdict.word for part in family.ranges] == ["unstable", "spectrally stable"]
    # lambda^4 + (b^2 - 3) lambda^2 + 2: b^2 = 3 + 2 sqrt(2)
    assert critical.way == "meeting"
    with mp.workdps(30):
        assert abs(critical.exact - (1 + mp.sqrt(2))) < 1e-20


def test_what_drives_a_system_is_found() -> None:
    # m v' = u - k v: the trim at v = 2
    x, k = sp.symbols("x k")
    u = sp.Function("u")(vo.time)
    system = vo.System(
        name="cart", fibration=vo.Fibration(base=(x,), fibre=()), constraints=(),
        lagrangian=vo.velocity(x) ** 2 / 2, forces={x: u - k * vo.velocity(x)},
        parameters=(vo.Parameter(k, 3),), inputs=(u,),
    )  # fmt: skip
    (motion,) = vo.steady(system, at={"xdot": 2}, free="u")
    assert motion.point["u"] == pytest.approx(6) and motion.spectrum == pytest.approx([-3])
    with pytest.raises(DefinitionError, match="'u' has no value"):
        vo.steady(system, at={"xdot": 2})


@pytest.mark.slow
def test_families_are_found_exactly_with_their_critical_values() -> None:
    m, g, R, A, C, s = sp.symbols("m g R A C s")
    found = vo.steady(vo.load("falling-disc"), at={"gamma3": 0, "q": 0}, starts=20, exact=True)
    spin = C * (C + m * R**2) * s**2
    conditions = {sp.expand(f) for family in found.families for f in family.conditions["real"]}
    for sign in (1, -1):  # upright on either side of the disc
        assert sp.expand(spin + sign * m * g * R * A) in conditions
    assert [family.dimension for family in found.families] == [1, 1]
    suslov = vo.steady(vo.load("suslov"), starts=20, exact=True)
    I13, I23, w1, w2 = sp.symbols("I13 I23 omega1 omega2")
    (family,) = suslov.families
    assert family.equations == (I13 * w1 + I23 * w2,) and family.dimension == 1
    # it turns stably in one direction alone
    assert [*family.ranges("omega1")] == [(-sp.oo, 0, 0), (0, sp.oo, 1)]


@pytest.mark.slow
def test_stability_is_told_by_ranges_with_exact_ends() -> None:
    at = {"gamma3": 0, "q": 0}
    found = vo.steady(vo.load("falling-disc"), at=at, starts=20, exact=True)
    upright = next(f for f in found.families if sp.Symbol("gamma2") - 1 in f.equations)
    critical = sp.sqrt(3) / 3
    assert [*upright.ranges("s")] == [
        (-sp.oo, -critical, 0), (-critical, critical, 1), (critical, sp.oo, 0)
    ]  # fmt: skip
    with pytest.raises(EngineLimit, match="holds s beside g"):
        upright.ranges("g")
    at = {"gamma1": 0, "gamma2": 0, "omega3": 1}
    ball = vo.steady(vo.load("chaplygin-ball"), at=at, starts=20, exact=True).families[0]
    assert [r.unstable for r in ball.ranges("I3")] == [0, 1, 0]  # between I1 and I2 it is unstable
    values = {p.name: p.value for p in vo.load("chaplygin-ball").parameters}
    assert [r.high for r in ball.ranges("I3")][:2] == [values["I1"], values["I2"]]
    # pairs meet on the imaginary axis beside roots that are damped
    x, y, z, c = sp.symbols("x y z c")
    vx, vy, vz = map(vo.velocity, (x, y, z))
    beside = vo.System(
        "beside", vo.Fibration(base=(x, y, z)),
        (vx**2 + vy**2 + vz**2 + c * (x * vy - y * vx) + x**2 + y**2 - z**2) / 2,
        forces={z: -vz}, parameters=(vo.Parameter(c, 1),),
    )  # fmt: skip
    (hill,) = vo.steady(beside, starts=5, exact=True).families
    assert [*hill.ranges(c)] == [(-sp.oo, -2, 0), (-2, 2, 2), (2, sp.oo, 0)]
    along = found[0].along("s", (0, 3), count=20, hold="q")
    low, high = along.ranges
    assert (low.begin, low.end, high.end) == (0, along.critical[0].value, 3)
    assert [low.motion.verdict.word, high.motion.verdict.word] == ["unstable", "spectrally stable"]


def routh_sphere() -> vo.System:
    """A ball on a plane whose mass centre lies on its axis of inertia, a below its middle."""
    x, y, phi, theta, psi = sp.symbols("x y phi theta psi")
    m, g, R, a, A, C = sp.symbols("m g R a A C")
    rotation = vo.kinematics.Rotation.euler("zxz", phi, theta, psi)
    rates, gamma = rotation.body_rates, tuple(rotation.matrix.row(2))
    arm = sp.Matrix([-R * gamma[0], -R * gamma[1], a - R * gamma[2]])
    slip = -rotation.matrix * sp.Matrix(vo.kinematics.cross(rates, tuple(arm)))
    height = R - a * gamma[2]
    climb = sum(height.diff(q) * vo.velocity(q) for q in (theta, psi))
    centre = (vo.velocity(x), vo.velocity(y), climb)
    return vo.System(
        name="routh-sphere",
        fibration=vo.Fibration(base=(phi, theta, psi), fibre=(x, y)),
        frame=vo.Frame.quasi(dict(zip(sp.symbols("omega1:4"), rates, strict=True))),
        lagrangian=vo.kinematics.kinetic_energy(m, centre, sp.diag(A, A, C), rates)
        - m * g * height,
        constraints=(vo.velocity(x) - slip[0], vo.velocity(y) - slip[1]),
        parameters=(
            *(vo.Parameter(p, 1, positive=True) for p in (m, g, R)), vo.Parameter(a, "1/4"),
            vo.Parameter(A, "1/2", positive=True), vo.Parameter(C, "2/5", positive=True),
        ),
        invariants=dict(zip(("gamma1", "gamma2", "gamma3"), gamma, strict=True)),
    )  # fmt: skip


@pytest.mark.slow
def test_a_sphere_of_routh_stands_on_its_light_side_above_a_spin() -> None:
    m, g, R, a, A, C, w = sp.symbols("m g R a A C omega3")
    # (C + m R h)^2 w^2 = 4 m g a (A + m h^2) with the mass centre h = R + a above the plane
    h = R + a
    condition = (C + m * R * h) ** 2 * w**2 - 4 * m * g * a * (A + m * h**2)
    system = routh_sphere()
    at = {"gamma1": 0, "gamma2": 0, "omega3": 3}
    motion = next(m for m in vo.steady(system, at=at, starts=40) if m.point["gamma3"] < 0)
    (critical,) = motion.along("omega3", ("1/10", 6)).critical
    assert critical.way == "meeting"
    with mp.workdps(30):
        assert abs(critical.exact**2 - mp.mpf("2.0625") / mp.mpf("1.65") ** 2) < 1e-20
    found = vo.steady(system, at={"gamma1": 0, "gamma2": 0}, starts=10, exact=True)
    top = next(f for f in found.families if sp.Symbol("gamma3") + 1 in f.equations)
    assert sp.expand(condition) in {sp.expand(f) for f in top.conditions["meeting"]}


@pytest.mark.slow
def test_turns_about_an_axis_of_a_ball_lose_stability_where_moments_are_equal() -> None:
    found = vo.steady(vo.load("chaplygin-ball"), starts=20, exact=True)
    assert sorted(f.dimension for f in found.families) == [1, 1, 1, 1, 1, 1, 2]
    I1, I2, I3 = sp.symbols("I1 I2 I3")
    (about, _) = (f for f in found.families if f.zero == ("gamma1", "gamma2", "omega1", "omega2"))
    assert {*about.conditions["real"]} == {I1 - I3, I2 - I3}


@pytest.mark.slow
def test_an_elimination_beyond_its_budget_leaves_numbers(call: Call) -> None:
    answer = call("steady", "rattleback", "--exact", "--starts", "20", "--at", "omega3=1")
    assert answer.status == 0 and "the steady motions are known in numbers" in answer.err


MASS = ((80.81722, 2.31941332208709), (2.31941332208709, 0.29784188199686))
STILL = ((-80.95, -2.59951685249872), (-2.59951685249872, -0.80329488458618))
FAST = ((0.0, 76.59734589573222), (0.0, 2.65431523794604))
DAMPING = ((0.0, 33.86641391492494), (-0.85035641456978, 1.68540397397560))
"""M, K0, K2, C1 of the benchmark bicycle, as they are printed [Meijaard2007, (A1)]."""

WEAVE = (
    "3.52696170990070 0.80774027519930", "2.68234517512745 1.68066296590675",
    "1.70675605663975 2.31582447384325", "0.41325331521125 3.07910818603206",
    "-0.77534188219585 4.46486771378823", "-1.52644486584142 5.87673060598709",
    "-2.13875644258362 7.19525913329805", "-2.69348683581097 8.46037971396931",
    "-3.21675402252485 9.69377351531791", "-3.72016840437287 10.90681139476287",
)  # fmt: skip
CAPSIZE = (
    "-3.13164324790656 -3.13423125066578 -3.07158645641514 -2.63366137253667 -1.42944427361326 "
    "-0.32286642900409 -0.00406690076970 0.10268170574766 0.14327879765713 0.15790184030917 "
    "0.16105338653172"
).split()
CASTERING = (
    "-5.53094371765393 -7.11008014637442 -8.67387984831735 -10.35101467245920 -12.15861426576447 "
    "-14.07838969279822 -16.08537123098026 -18.15788466125262 -20.27940894394569 "
    "-22.43788559040858 -24.62459635017404"
).split()
"""Eigenvalues at 0 to 10 m/s, as they are printed [Meijaard2007, table 2]; castering at 7 m/s ends
with the digits 5202 here, and with 5177 by the matrices as they are printed."""


def printed_eigenvalues(speed: int) -> list[mp.mpc]:
    """The four at a speed; at rest those of weave are the opposites of the others."""
    real = [mp.mpf(CAPSIZE[speed]), mp.mpf(CASTERING[speed])]
    if not speed:
        return [*real, *(-x for x in real)]
    pair = mp.mpc(*WEAVE[speed - 1].split())
    return [*real, pair, mp.conj(pair)]


@pytest.mark.slow
def test_the_bicycle_has_the_published_eigenvalues_and_critical_speeds() -> None:
    motion = moving("bicycle", {"phi": 0, "delta": 0, "speed": 5}, starts=5)
    family = motion.along("speed", (0, 10))
    still, fast, damping = map(np.array, (STILL, FAST, DAMPING))
    for speed in range(11):
        inverse = np.linalg.inv(np.array(MASS))
        below = -inverse @ np.hstack([9.81 * still + speed**2 * fast, speed * damping])
        printed = np.linalg.eigvals(np.vstack([np.eye(4)[2:], below]))
        there = family.at(speed)
        ours = there.spectrum
        gaps = np.abs(ours[:, None] - printed[None, :]).min(axis=1)
        assert len(ours) == 4 and gaps.max() < 1e-11
        exact = [e for e in there.eigenvalues(20) if e != 0]
        for e in printed_eigenvalues(speed):
            off = min(abs(e - x) for x in exact)
            assert off < (7e-13 if str(e.real).startswith("-18.15") else 1.1e-13)
    for slow in (family.at(3), moving("bicycle", {"delta": "1/2"}, starts=5)):  # and a turn
        assert slow.kind == "uniform rolling"
        assert slow.verdict.word == "unstable" and slow.verdict.proved
    weave, capsize = family.critical
    assert (weave.way, capsize.way) == ("pair", "real")
    assert weave.value == pytest.approx(4.29238253634111, abs=5e-14)
    assert capsize.value == pytest.approx(6.02426201538837, abs=5e-14)
    assert family.branch_points == pytest.approx([capsize.value], abs=1e-9)


@pytest.mark.slow
def test_commands_print_and_refuse(call: Call) -> None:
    answer = call("steady", "suslov", "--json")
    told = json.loads(answer.out)
    assert answer.status == 0 and [m["kind"] for m in told["motions"]] == [
        "rest",
        "permanent rotation",
    ]
    answer = call("stability", "falling-disc", "--over", "s", "--between", "0:3", "--at",
                     "gamma3=0", "--at", "q=0", "--hold", "q")  # fmt: skip
    assert "critical: s = 0.577350269189626: a real eigenvalue passes through zero" in answer.out
    for words in (
        ("steady", "falling-disc", "--at", "gama=1"),
        ("steady", "falling-disc", "--at", "s=1", "--at", "p=1"),
        ("steady", "falling-disc", "--set", "mass=1"),
        ("steady", "sleigh-in-time"),
        ("steady", "vertical-disc"),
        ("stability", "falling-disc", "--over", "p", "--between", "0:3"),
        ("stability", "falling-disc", "--over", "s", "--between", "3"),
        ("stability", "falling-disc", "--over", "R", "--between=-1:2"),
    ):
        refused(call(*words))


def test_what_is_steep_is_smooth_and_what_vanishes_at_infinity_is_no_motion() -> None:
    v = vo.velocity(X)
    line = vo.Fibration(base=(X,))
    for potential in ((1 - sp.exp(-X)) ** 2, sp.cosh(X), sp.log(1 + X**2) + X**20):
        (rest,) = vo.steady(vo.System("hollow", line, v**2 / 2 - potential), starts=20)
        assert rest.point == {"x": 0, "xdot": 0} and rest.verdict.word == "stable"
    belt = vo.System("belt", line, v**2 / 2 - X**2 / 2, forces={X: sp.tanh(9 * (1 - v)) * (2 - v)})
    rounded = vo.System("rounded", line, v**2 / 2 - X**2, forces={X: -v / sp.sqrt(v**2 + 1)})
    assert vo.steady(rounded, starts=20)[0].verdict.word == "linearly attracting"
    (held,) = vo.steady(belt, starts=20)
    assert held.point["x"] == pytest.approx(2 * np.tanh(9))
    for wrong, words in ((sp.exp(X), "none of 20 starts"), (sp.Abs(X), "not smooth")):
        with pytest.raises(DefinitionError, match=words):
            vo.steady(vo.System("no rest", line, v**2 / 2 - wrong), starts=20)
    y, c = sp.symbols("y c")  # at y = 0 slopes are so large that all is small beside them
    steep = vo.System(
        "steep", vo.Fibration(base=(X, y)),
        (v**2 + vo.velocity(y) ** 2) / 2 - X - sp.sin(y + c) ** -2,
        parameters=(vo.Parameter(c, sp.pi),),
    )  # fmt: skip
    for at in ({}, {y: 0}):
        with pytest.raises(DefinitionError, match="none of 20 starts"):
            vo.steady(steep, at=at, starts=20)
    beyond = vo.steady(vo.System("well", line, v**2 / 2 - X**2 / 2 + sp.log(X)), at={X: -1})
    assert not beyond[0].verdict.proved  # the energy has no value there


@pytest.mark.parametrize(
    "option",
    [{"starts": 0}, {"at": 3}, {"at": {"s": "x"}}, {"free": "p"}, {"parameters": {"R": -1}}],
)
def test_bad_arguments_are_refused(option: Mapping[str, Any]) -> None:
    with pytest.raises(DefinitionError):
        vo.steady(vo.load("falling-disc"), **option)


@pytest.mark.slow
def test_charts_count_unstable_eigenvalues() -> None:
    motion = moving("falling-disc", {"gamma3": 0, "q": 0, "s": 1})
    with pytest.raises(DefinitionError, match="must be positive"):
        motion.chart(("s", 0.1, 2), ("R", -1, 5), hold="q")
    found = motion.chart(("s", 0.1, 2), ("g", 0.1, 5), count=12, hold="q")
    for i, j in product(range(12), range(12)):
        unstable = found.xs[j] ** 2 * 0.75 < found.ys[i] / 4
        assert found.unstable[i, j] == int(unstable)
    assert found.plot() is not None


DIGITS = 80
STEP = mp.mpf(10) ** -25


def referee_field(system: vo.System, values: Mapping[Any, Any]) -> Any:
    """(q, v)' at a point, by multipliers; of the engine nothing but the names is used."""
    q = [*system.coordinates]
    dots = [vo.velocity(x) for x in q]
    frame = system.frame
    v = [*system.velocities]
    meaning = dict(zip(v, v, strict=True)) if frame is None else dict(frame.definitions)
    rows = [*system.constraints, *(meaning[x] - x for x in v)]
    rows += [sp.Add(*[r.diff(x) * vo.velocity(x) for x in q]) for r in system.fibration.relations]
    plain = {d: sp.Symbol(f"rate {i}") for i, d in enumerate(dots)}
    rows = [sp.sympify(r).xreplace(plain) for r in rows]
    rates = [*plain.values()]
    matrix = sp.Matrix(rows).jacobian(rates)
    rest = sp.Matrix([r.xreplace(dict.fromkeys(rates, sp.Integer(0))) for r in rows])
    quasi = [sp.sympify(meaning[x]).xreplace(plain) for x in v]
    by_place = sp.Matrix(quasi).jacobian(q)
    by_rate = sp.Matrix(quasi).jacobian(rates)
    solve_for = sp.lambdify([q, v], [m.xreplace(values) for m in (matrix, rest)], "mpmath")
    slopes = sp.lambdify([q, rates], [m.xreplace(values) for m in (by_place, by_rate)], "mpmath")

    def field(x: list[mp.mpf]) -> list[mp.mpf]:
        place, speeds = x[: len(q)], x[len(q) :]
        left, right = solve_for(place, speeds)
        moving = [*mp.lu_solve(left, -right)]
        point = {**dict(zip([*q, *v], x, strict=True)), **values}
        found = vo.multiplier_acceleration(system, point, digits=DIGITS)
        bent = mp.matrix([mp.mpf(sp.N(found[c], DIGITS)) for c in q])
        here, along = slopes(place, moving)
        return [*moving, *(here * mp.matrix(moving) + along * bent)]

    return field


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "at"),
    [
        ("falling-disc", {"gamma3": "1/2", "s": "3/2"}),
        ("rattleback", {"gamma3": 1, "omega3": "1/2"}),
        ("chaplygin-ball", {"gamma2": 1, "omega2": 1}),
        ("veselova", {"gamma2": 1}),
        ("sleigh-on-turntable", {"v": "1/10"}),
        ("ball-on-sphere", {"gamma1": 0, "gamma3": 0, "G2": "1/2"}),
        ("torus-on-ellipsoid", {"s": "1/2"}),
        ("bicycle", {"delta": "1/2"}),
    ],
)
def test_spectra_agree_with_differences_of_the_multiplier_route(
    name: str, at: Mapping[str, Any]
) -> None:
    motion = moving(name, at)
    with mp.workdps(DIGITS):
        theirs = referee_eigenvalues(motion)
        ours = [e for e in motion.eigenvalues(40) if e != 0]
        if name == "veselova":  # all its steady motions are rest, and all eigenvalues vanish
            assert not ours and max(map(abs, theirs)) < 1e-12
        else:
            assert ours
        for value in ours:
            assert min(abs(value - other) for other in theirs) < mp.mpf(10) ** -30 * abs(value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "at", "over", "between"),
    [
        ("rattleback", {"gamma3": 1, "omega3": "1/2"}, "omega3", (1, 2)),
        ("falling-disc", {"gamma3": 0, "q": 0, "s": 1}, "s", (0, 2)),
        ("sleigh-on-turntable", {"v": "1/10"}, "v", (-1, 1)),
        ("bicycle", {"phi": 0, "delta": 0, "speed": 4}, "speed", (4, 5)),
        ("chaplygin-ball", {"gamma1": 1, "omega1": 1}, "I2", ("3/10", "9/20")),
        ("ball-on-sphere", {"gamma1": 0, "gamma3": 0, "G2": "1/2"}, "I3", ("2/5", "3/5")),
        ("torus-on-ellipsoid", {"s": "1/2"}, "R", (1, "3/2")),
    ],
)
def test_critical_values_agree_with_differences_of_the_multiplier_route(
    name: str, at: Mapping[str, Any], over: str, between: tuple[float, float]
) -> None:
    hold = tuple(at) if over in ("I2", "I3", "R") else ()  # parameters
    family = moving(name, at, starts=20).along(over, between, hold=hold, count=10)
    (critical,) = family.critical
    with mp.workdps(DIGITS):
        theirs = referee_eigenvalues(family.at(critical.exact))
        # a zero of multiplicity two is known to half of the digits
        assert sorted(abs(e.real) for e in theirs)[0] < 1e-12
        ends = [referee_eigenvalues(family.at(critical.exact + s * mp.mpf(10) ** -12))
                for s in (1, -1)]  # fmt: skip
        counts = [sum(e.real > mp.mpf(10) ** -16 for e in found) for found in ends]
        assert {*counts} == {critical.below, critical.above}


def referee_eigenvalues(motion: vo.SteadyMotion) -> list[mp.mpc]:
    """The eigenvalues of the reduced motion by differences of the multiplier route."""
    system = motion.system
    names = [str(x) for x in (*system.coordinates, *system.velocities)]
    point = motion.in_digits(DIGITS)
    start = {str(x): e for x, e in motion.equations.formulation.start.items()}
    meaning = {n: sp.sympify(start[n]) for n in point if n in start}
    values = {p.symbol: point.get(p.name, p.value) for p in system.parameters}
    meaning = {n: sp.sympify(e).xreplace(values) for n, e in meaning.items()}
    held = sorted({str(s) for e in meaning.values() for s in e.free_symbols})
    sides = [e - sp.Float(point[n], DIGITS) for n, e in meaning.items()]
    function = sp.lambdify([sp.Symbol(n) for n in held], sides, "mpmath")
    near = [mp.mpf("0.4") + mp.mpf(i) / 7 for i in range(len(held))]
    near = [point.get(n, x) for n, x in zip(held, near, strict=True)]
    known = dict(zip(held, solution(function, near), strict=True))
    x = [known.get(n, mp.mpf("0.3") if n != "z" else mp.mpf(0)) for n in names]
    field, symbols = referee_field(system, values), [*map(sp.Symbol, names)]
    inner = sp.Matrix([*meaning.values()]).jacobian(symbols)
    along = sp.lambdify([symbols], inner, "mpmath")
    columns = []
    for i in range(len(x)):
        pair = [[*x[:i], x[i] + sign * STEP, *x[i + 1 :]] for sign in (1, -1)]
        up, down = (along(y) * mp.matrix(field(y)) for y in pair)
        columns.append([(a - b) / (2 * STEP) for a, b in zip(up, down, strict=True)])
    # with sigma(q, v) the variables of the reduced motion, A D(sigma) = D(sigma')
    slopes, rates = along(x), mp.matrix(columns).T
    rank = int(np.linalg.matrix_rank(np.array(slopes.tolist(), dtype=float), tol=1e-9))
    order = qr(np.array(slopes.tolist(), dtype=float), pivoting=True, mode="r")[1][:rank]
    base = mp.matrix([[slopes[i, int(j)] for j in order] for i in range(slopes.rows)])
    ends = mp.matrix([[rates[i, int(j)] for j in order] for i in range(slopes.rows)])
    return mp.eig(reduced(base, ends), left=False, right=False)


def reduced(base: mp.matrix, ends: mp.matrix) -> mp.matrix:
    """A with base A = ends, whose columns lie in the image."""
    return mp.inverse(base.T * base) * (base.T * ends)


def solution(function: Any, x: list[mp.mpf]) -> list[mp.mpf]:
    """Of equations that are more than their unknowns, by Newton's method of least squares."""
    for _ in range(200):
        values = mp.matrix(function(*x))
        slopes = mp.zeros(len(values), len(x))
        for j in range(len(x)):
            ahead = mp.matrix(function(*x[:j], x[j] + STEP, *x[j + 1 :]))
            slopes[:, j] = (ahead - values) / STEP
        damping = mp.norm(values) ** 2 / 1000
        step = mp.lu_solve(slopes.T * slopes + damping * mp.eye(len(x)), slopes.T * values)
        x = [a - b for a, b in zip(x, step, strict=True)]
        if mp.norm(step) < mp.mpf(10) ** -60:
            return x
    raise AssertionError("no coordinates were found")
