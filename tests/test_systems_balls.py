"""Balls on planes and spheres: their claims hold, hold only there, and are those of one family."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
import sympy as sp
from without_claims import bare

import voronec as vo
from voronec import Equation, prove_equal

pytestmark = pytest.mark.slow

PLANE = ("gyroscopic-ball-on-plane", "bobylev-ball", "zhukovsky-ball", "homogeneous-ball")
SPHERE = (
    "ball-on-sphere",
    "gyroscopic-ball-on-sphere",
    "symmetric-ball-on-sphere",
    "symmetric-gyroscopic-ball-on-sphere",
    "homogeneous-ball-on-sphere",
)
BALLS = (*PLANE, *SPHERE, "borisov-fedorov-ball", "chaplygin-ball", "demchenko")
SYMMETRIC = ("symmetric-ball-on-sphere", "symmetric-gyroscopic-ball-on-sphere")

omega = sp.symbols("omega1:4")
gamma = sp.symbols("gamma1:4")
R1, R2, m, A, C, k = sp.symbols("R1 R2 m A C k")
UNIT = sum(g**2 for g in gamma) - 1


def module(name):
    return import_module(f"voronec.systems.{name.replace('-', '_')}")


RELATIONS = {r.label: r for name in BALLS for r in getattr(module(name), "RELATIONS", ())}
SQUARES = {s.label: s for name in BALLS for s in getattr(module(name), "SQUARES", ())}


def verdict_on(name, **claims):
    """The verdict on one claim about a ball, without its own claims."""
    system = vo.load(name)
    stated = bare(system, invariants=system.invariants, **claims)
    return vo.check_claims(stated)[0].verdict


@pytest.mark.parametrize("name", [n for n in BALLS if n != "demchenko"])
def test_the_equations_are_the_printed_ones_and_no_others(name):
    """Gdot = (G + kappa) x omega with this sign, gammadot with this epsilon."""
    declared = vo.load(name).equations
    for key in ("momentum", "normal"):
        right = declared[key]
        turned = Equation(right.function, tuple(-r for r in right.rate))
        assert verdict_on(name, equations={key: turned}).refuted
    if name in SPHERE:
        normal = sp.Matrix(gamma)
        plane = Equation(gamma, tuple(normal.cross(sp.Matrix(omega))))
        assert verdict_on(name, equations={"normal": plane}).refuted


def test_the_normal_momentum_is_constant_on_the_plane_only():
    vertical = vo.load("gyroscopic-ball-on-plane").integrals["vertical momentum"]
    on_sphere = vertical.xreplace({sp.Symbol("R"): R2})
    assert verdict_on("gyroscopic-ball-on-plane", integrals={"F4": vertical}).proved
    assert verdict_on("gyroscopic-ball-on-sphere", integrals={"F4": on_sphere}).refuted


def test_the_integral_of_borisov_and_fedorov_needs_its_weights_and_its_epsilon():
    name = "borisov-fedorov-ball"
    integral = vo.load(name).integrals["Borisov-Fedorov"]
    assert verdict_on(name, integrals={"F4": integral}).proved
    plain = sum(p * g for p, g in zip(module(name).ball.motion.momentum, gamma, strict=True))
    assert verdict_on(name, integrals={"F4": plain}).refuted
    lighter = integral - m * R2**2 * plain
    assert verdict_on(name, integrals={"F4": lighter}).refuted
    assert verdict_on("ball-on-sphere", integrals={"F4": integral}).refuted


def test_a_gyroscope_spoils_the_integral_of_borisov_and_fedorov():
    """Nor does the same sum with the whole momentum do."""
    system = vo.load("gyroscopic-ball-on-sphere")
    mine = module("ball-on-sphere").ball.motion
    whole = module("gyroscopic-ball-on-sphere").ball.motion.whole
    weights = [sum(mine.inertia) - 2 * i + mine.contact_inertia for i in mine.inertia]
    other = sum(b * p * g for b, p, g in zip(weights, whole, gamma, strict=True))
    for integral in (mine.linear_integral, other):
        case = vo.Case(parameters={R1: -R2 / 2}, integrals={"F4": integral})
        shell = bare(system, invariants=system.invariants, cases={"shell": case})
        (verdict,) = [c.verdict for c in vo.check_claims(shell) if c.name == "shell: F4"]
        assert verdict.refuted


@pytest.mark.parametrize("name", ["ball-on-sphere", "gyroscopic-ball-on-plane"])
def test_the_density_needs_its_root(name):
    density = vo.load(name).measure.density
    for power, proved in ((1, True), (0, False), (2, False), (-1, False)):
        verdict = verdict_on(name, measure=vo.Measure(density**power, (*gamma, *omega)))
        assert (verdict.proved, verdict.refuted) == (proved, not proved)


@pytest.mark.parametrize("name", SYMMETRIC)
def test_the_linear_integrals_need_the_ratio_of_the_radii(name):
    """With mu = 2 + R2/R1 in the place of 1 + R2/R1 they are none."""
    ball = module(name).solution
    growth = sp.exp((1 + ball.mu) * sp.asinh(ball.slope(True) * ball.x))
    angle = (1 + ball.mu) * sp.asin(ball.slope(False) * ball.x)
    spread, swing = ball.pair(True), ball.pair(False)
    right = sp.exp(ball.mu * sp.asinh(ball.slope(True) * ball.x))
    for wrong in (
        (spread - ball.partner) * growth,
        (spread + ball.partner) * right,
        swing * sp.cos(angle) - ball.partner * sp.sin(angle),
    ):
        assert verdict_on(name, integrals={"wrong": wrong}).refuted


@pytest.mark.parametrize("name", SYMMETRIC)
def test_the_product_of_the_linear_integrals_is_one_of_the_known_quadratic_ones(name):
    """J+ J- = ((C - A)((A + D) 2 energy - |G + k e3|^2) - (A + D) k^2) / (C + D)."""
    system, D = vo.load(name), m * R2**2
    axial = k if name == "symmetric-gyroscopic-ball-on-sphere" else 0
    twice, square = 2 * system.integrals["energy"], system.integrals["momentum squared"]
    quadratic = ((C - A) * ((A + D) * twice - square) - (A + D) * axial**2) / (C + D)
    oblate, prolate = (system.cases[n].integrals for n in ("oblate", "prolate"))
    product = oblate["growing"] * oblate["falling"]
    assert prove_equal(product, quadratic, relations=(UNIT,)).proved
    squares = prolate["cosine"] ** 2 + prolate["sine"] ** 2
    assert prove_equal(squares, -quadratic, relations=(UNIT,)).proved
    assert not prove_equal(squares, quadratic, relations=(UNIT,)).proved


@pytest.mark.parametrize(
    ("name", "scene", "shape", "axial"),
    [
        (SYMMETRIC[0], "default", "oblate", 0.6),
        (SYMMETRIC[0], "shell", "prolate", 0.3),
        (SYMMETRIC[1], "inner", "prolate", 0.3),
        (SYMMETRIC[1], "shell", "oblate", 0.6),
    ],
)
def test_the_linear_integrals_stay_along_a_motion(name, scene, shape, axial):
    """In numbers, outside, inside and as a shell, for both shapes of the ball."""
    system = vo.load(name)
    names = [*(f"gamma{i}" for i in (1, 2, 3)), *map(str, omega)]
    moved = vo.integrate(
        system, scene=scene, times=np.linspace(0, 10, 21),
        parameters={"C": axial}, outputs=names, tol=1e-13,
    )  # fmt: skip
    values = {p.symbol: p.value for p in system.parameters} | {C: axial}
    values |= system.scenes[scene].parameters
    for integral in system.cases[shape].integrals.values():
        number = sp.lambdify((*gamma, *omega), integral.xreplace(values), "numpy")
        series = number(*(moved[n] for n in names))
        assert np.isrealobj(series) and abs(series[0]) > 1e-3
        assert np.ptp(series) < 1e-8 * abs(series).max()


def test_demchenkos_integrals_are_those_of_the_symmetric_ball_under_zhukovskys_condition():
    """A n + k mu cos(u) and the constant of P s sin(u) are, up to sign, the two of the case."""
    image = {
        sp.Symbol(name): e for name, e in RELATIONS["demchenko -> zhukovsky-ball"].state.items()
    }
    mass = {m: sp.Symbol("M"), C: A}
    case = vo.load("symmetric-gyroscopic-ball-on-sphere").cases["Zhukovsky"].integrals
    theirs = {name: e.xreplace(mass).xreplace(image) for name, e in case.items()}
    demchenko = vo.load("demchenko")
    assert prove_equal(theirs["axial"], -demchenko.integrals["axial"]).proved
    level = demchenko.cases["on the ball"].integrals["level"]
    assert prove_equal(theirs["level"], -level).proved


def test_the_wrong_radius_or_the_wrong_shape_is_no_relation():
    bobylev = RELATIONS["bobylev-ball -> gyroscopic-ball-on-plane"]
    shape = replace(bobylev, parameters={**bobylev.parameters, "I2": C})
    plane = RELATIONS["ball-on-sphere -> chaplygin-ball"]
    radius = replace(plane, parameters={**plane.parameters, "R": 2 * R2})
    finite = replace(plane, limit=None)
    mirrored = RELATIONS["demchenko -> symmetric-gyroscopic-ball-on-sphere"]
    mirrored = replace(mirrored, parameters={**mirrored.parameters, k: -k})
    for wrong in (shape, radius, finite, mirrored):
        assert vo.check_relation(wrong).verdict.refuted


@pytest.mark.parametrize(
    "label",
    [
        "homogeneous-ball-on-sphere -> symmetric-ball-on-sphere",
        "symmetric-gyroscopic-ball-on-sphere -> symmetric-ball-on-sphere",
    ],
)
def test_one_symmetric_ball_on_a_sphere_has_its_measure_from_another(label):
    pulled = vo.check_relation(RELATIONS[label]).pulled
    assert [c.verdict.proved for c in pulled if c.kind == "measure"] == [True]


@pytest.mark.parametrize("name", ["torus-on-ellipsoid", "gyroscopic-torus-on-ellipsoid"])
def test_a_ball_has_its_energy_and_its_momentum_from_the_torus(name):
    relation = next(r for r in module(name).RELATIONS if r.target == name)
    checked = vo.check_relation(relation)
    assert checked.verdict.proved and all(c.verdict.proved for c in checked.pulled)
    assert [(c.kind, c.name) for c in checked.pulled] == [
        ("integral", "energy"),
        ("equation", "momentum"),
    ]


def test_the_axial_integral_of_bobylev_says_nothing_where_the_inertia_is_spherical():
    axial = vo.load("bobylev-ball").integrals["axial"]
    assert prove_equal(axial.xreplace({C: A}), sp.sqrt(A) * k).proved
