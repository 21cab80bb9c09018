"""Rubber balls and Veselova's system: their claims hold, and hold only as they are stated."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec import Measure
from voronec.algebra.verdicts import decide_zero
from voronec.equations.motions import Motions
from voronec.proof.claims import check_claims
from voronec.proof.relations.decision import check_relation

pytestmark = pytest.mark.slow

ON_SPHERES = (
    "rubber-ball-on-sphere",
    "rubber-ball-eps-minus-one",
    "gyroscopic-rubber-ball-on-sphere",
)
ON_PLANES = (
    "rubber-ball-on-plane",
    "gyroscopic-rubber-ball-on-plane",
    "displaced-rubber-ball",
)
LAGRANGE = ("rubber-ball-in-new-time", "veselova-in-new-time")
SYSTEMS = (*ON_SPHERES, *ON_PLANES, "veselova", *LAGRANGE)
WITH_MULTIPLIER = (
    "rubber-ball-on-sphere",
    "rubber-ball-eps-minus-one",
    "rubber-ball-on-plane",
    "veselova",
)


def module(name):
    return import_module(f"voronec.systems.{name.replace('-', '_')}")


@cache
def motions(name):
    return Motions.of(vo.load(name))


@cache
def claims(name):
    return check_claims(motions(name))


def motion(name):
    """The motion of a system, reduced to omega and gamma."""
    declared = module(name)
    return declared.motion if hasattr(declared, "motion") else declared.ball.rubber


RELATIONS = {r.label: r for name in SYSTEMS for r in getattr(module(name), "RELATIONS", ())}
SQUARES = {s.label: s for name in SYSTEMS for s in getattr(module(name), "SQUARES", ())}


def verdict_on(name, **changed):
    """The verdict on one claim, in the place of all that the system claims."""
    bare = replace(
        vo.load(name),
        integrals={}, equations={}, measure=None, multiplier=None, poisson=None, essential=(),
        cases={}, integrable="",
    )  # fmt: skip
    kind = next(iter(changed)).removesuffix("s")
    return next(c for c in check_claims(replace(bare, **changed)) if c.kind == kind).verdict


@pytest.mark.parametrize("name", SYSTEMS)
def test_no_integral_is_a_mere_number(name):
    field = motions(name).on_coordinates
    for claim in vo.load(name).integrals.values():
        slopes = [field.read(claim).diff(w) for w in field.velocities]
        assert any(decide_zero(slope, field.relations).refuted for slope in slopes)


@pytest.mark.parametrize("name", ["rubber-ball-on-sphere", "rubber-ball-on-plane"])
def test_the_printed_multiplier_of_the_twist_is_refuted(name):
    momentum = next(c for c in claims(name) if (c.kind, c.name) == ("equation", "momentum"))
    assert momentum.printed is not None
    assert momentum.printed.refuted


@pytest.mark.parametrize("name", [*ON_SPHERES, "rubber-ball-on-plane", "veselova", *LAGRANGE])
def test_the_measure_has_no_other_power(name):
    own = vo.load(name).measure
    other = Measure(own.density * motion(name).form, own.variables)
    assert verdict_on(name, measure=other).refuted


@pytest.mark.parametrize("name", WITH_MULTIPLIER)
def test_the_reducing_multiplier_has_no_other_power(name):
    assert verdict_on(name, multiplier=vo.load(name).multiplier / motion(name).form).refuted


@pytest.mark.parametrize(
    "name", ["gyroscopic-rubber-ball-on-sphere", "gyroscopic-rubber-ball-on-plane"]
)
def test_the_gyroscope_is_a_magnetic_field_of_that_sign(name):
    own, ball = vo.load(name).poisson, motion(name)
    field = -ball.reducer * sp.Matrix(ball.rotor).dot(ball.normal) / ball.epsilon**2
    for strength in (0, -1):
        key, gamma3 = sp.symbols("M1 M2"), ball.normal[2]
        entry = own.bracket[key] + (strength - 1) * field * gamma3
        other = replace(own, bracket={**own.bracket, key: entry})
        assert verdict_on(name, poisson=other).refuted


@pytest.mark.parametrize(
    "name", ["gyroscopic-rubber-ball-on-sphere", "gyroscopic-rubber-ball-on-plane"]
)
def test_without_the_change_of_time_the_bracket_is_not_that_of_the_motion(name):
    assert verdict_on(name, poisson=replace(vo.load(name).poisson, clock=1)).refuted


def test_the_second_integral_of_the_shell_needs_its_radius():
    shell = module("rubber-ball-eps-minus-one")
    found = shell.SYSTEM.integrals["Borisov and Mamaev"]
    assert verdict_on("rubber-ball-on-sphere", integrals={"second": found}).refuted


def test_the_momentum_across_the_normal_changes_with_a_gyroscope_or_a_displacement():
    plane = module("rubber-ball-on-plane").SYSTEM.integrals["momentum across the normal"]
    ball = module("displaced-rubber-ball")
    across = {"across": ball.L.dot(ball.L)}
    assert verdict_on("gyroscopic-rubber-ball-on-plane", integrals={"across": plane}).refuted
    assert verdict_on("displaced-rubber-ball", integrals=across).refuted


def test_on_a_plane_only_the_part_of_the_momentum_across_the_normal_keeps_its_length():
    ball = module("rubber-ball-on-plane").motion
    for other in (ball.momentum.dot(ball.momentum), ball.momentum.dot(ball.normal)):
        assert verdict_on("rubber-ball-on-plane", integrals={"momentum": other}).refuted


def test_the_axial_integral_needs_the_symmetry():
    for name in ("rubber-ball-on-sphere", "gyroscopic-rubber-ball-on-sphere"):
        axial = vo.load(name).cases["symmetric"].integrals["axial"]
        assert verdict_on(name, integrals={"axial": axial}).refuted


def test_a_ball_on_a_plane_has_the_moments_of_veselovas_body_about_the_contact():
    own = RELATIONS["rubber-ball-on-plane -> veselova"]
    inertia = module("rubber-ball-on-plane").inertia
    other = replace(own, parameters={f"J{i + 1}": x for i, x in enumerate(inertia)})
    assert check_relation(other, motions).verdict.refuted


def test_the_plane_is_the_limit_for_a_ball_of_the_same_radius():
    own = RELATIONS["rubber-ball-on-sphere -> rubber-ball-on-plane"]
    other = replace(own, parameters={**own.parameters, "R": 2 * sp.Symbol("R2")})
    assert check_relation(other, motions).verdict.refuted


def test_the_new_time_is_no_other():
    own = RELATIONS["veselova -> veselova-in-new-time"]
    assert "change of time" in check_relation(own, motions).kinds
    assert check_relation(replace(own, clock=1), motions).verdict.refuted


@pytest.mark.parametrize(
    ("name", "closed"), [("rubber-ball-on-plane", True), ("displaced-rubber-ball", False)]
)
def test_displaced_the_ball_has_no_measure_with_a_density_in_the_position(name, closed):
    """div f = a du/dt + b dv/dt is a total derivative where a_v = b_u, and only there."""
    field = motions(name).on_coordinates
    rates = dict(zip(field.variables, field.components, strict=True))
    u, v, *omega = [x for x in rates if str(x) in ("u", "v", "omega1", "omega2")]
    divergence = sum(rates[x].diff(x) for x in (u, v, *omega))
    (p, q), (r, s) = ([rates[x].diff(w) for x in (u, v)] for w in omega)
    first, second = (divergence.diff(w) for w in omega)
    a, b = ((first * s - q * second) / (p * s - q * r), (p * second - first * r) / (p * s - q * r))
    assert decide_zero(a.diff(v) - b.diff(u), field.relations).proved is closed


def test_ball_on_plane_and_veselovas_body_move_alike():
    """By numbers: from the same omega and gamma the two come to the same state."""
    gamma = sp.symbols("gamma1:4")
    start = {"omega1": 0.1, "omega2": 0.2}
    ball, body = vo.load("rubber-ball-on-plane"), vo.load("veselova")
    times = np.linspace(0, 5, 11)
    moved = []
    for system, angles, values in (
        (ball, {"u": np.pi - 0.6, "v": -np.pi / 2 - 1}, {}),
        (body, {"theta": 0.6, "psi": 1}, {"J1": 1.4, "J2": 1.5, "J3": 1.7}),
    ):
        names = [system.invariants[str(g)] for g in gamma]
        run = vo.integrate(
            system, times=times, outputs=names, parameters=values, initial={**angles, **start}
        )
        moved.append(np.array([run[str(e)] for e in names]))
    assert np.ptp(moved[0], axis=1).max() > 0.5
    assert np.allclose(moved[0], moved[1], atol=1e-10)
