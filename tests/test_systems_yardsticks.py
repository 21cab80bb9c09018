"""The classical yardsticks: their claims and relations hold, and hold only as they are stated."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib import import_module

import numpy as np
import pytest
import sympy as sp
from without_claims import bare

import voronec as vo
from voronec import Equation, Measure, Relation, prove_equal, velocity

pytestmark = pytest.mark.slow

SLEIGHS = ("sleigh", "growing-sleigh", "sleigh-in-time", "sleigh-on-turntable")
TABLES = ("ball-on-turntable", "ball-on-turntable-in-time")
CARRIAGES = ("vertical-disc", "falling-disc", "two-wheeled-carriage", "snakeboard")
OTHERS = ("free-particle", "nonholonomic-particle", "suslov", "rattleback")
YARDSTICKS = (*SLEIGHS, *TABLES, *CARRIAGES, *OTHERS)

x, y, phi, theta, psi = sp.symbols("x y phi theta psi")
v, w, m, J, a, R, A, Omega = sp.symbols("v w m J a R A Omega")
Dx, Dy, Dphi = map(velocity, (x, y, phi))


def module(name):
    return import_module(f"voronec.systems.{name.replace('-', '_')}")


RELATIONS = {r.label: r for name in YARDSTICKS for r in getattr(module(name), "RELATIONS", ())}
SQUARES = {s.label: s for name in YARDSTICKS for s in getattr(module(name), "SQUARES", ())}


def verdict_on(system, **claims):
    """The verdict on one claim about a system, without its own claims."""
    (claim,) = vo.check_claims(bare(system, system.name, **claims))
    return claim.verdict


@pytest.mark.parametrize("name", [n for n in YARDSTICKS if vo.load(n).essential])
def test_the_essential_variables_are_not_just_all_of_the_reduced_motion(name):
    """What the invariants give is closed by descent already."""
    system = vo.load(name)
    everything = {*system.invariants, *map(str, system.velocities)}
    assert not system.invariants or {*map(str, system.essential)} != everything


@pytest.mark.parametrize(
    ("label", "target"),
    [
        ("two-wheeled-carriage -> sleigh", {"m": m}),
        ("vertical-disc -> sleigh", {"a": 1}),
        ("sleigh -> sleigh-in-time", {"b1": 1}),
        ("growing-sleigh -> sleigh", {"J": 2 * J}),
        ("ball-on-turntable -> homogeneous-ball", None),
        ("nonholonomic-particle -> free-particle", None),
        ("snakeboard -> free-particle", None),
        ("free-particle -> homogeneous-ball", None),
        ("free-particle -> suslov", {"I13": 1}),
        ("free-particle -> veselova", {"J1": 2 * m}),
        ("sleigh on a turntable reversed", {"Omega": Omega}),
        ("sleigh on a turntable mirrored", {"beside": sp.Symbol("beside")}),
    ],
)
def test_a_relation_with_another_parameter_or_clock_is_refuted(label, target):
    right = RELATIONS[label]
    if target is None:
        wrong = replace(right, clock=2 * right.clock)
    else:
        wrong = replace(right, parameters={**right.parameters, **target})
    assert vo.check_relation(wrong).verdict.refuted


def test_an_upright_disc_that_turns_does_not_stay_upright():
    Dtheta = velocity(theta)
    upright = {"gamma2": 1, "gamma3": 0, "p": 0, "q": Dphi, "s": Dtheta}
    right = RELATIONS["vertical-disc -> falling-disc"]
    found = vo.check_relation(replace(right, state=upright))
    assert found.verdict.refuted and "'p'" in found.verdict.method


@pytest.mark.parametrize("name", ["sleigh", "suslov", "two-wheeled-carriage"])
def test_no_volume_is_kept_where_motions_die_out(name):
    system = vo.load(name)
    assert verdict_on(system, measure=Measure(1, system.velocities)).refuted


def test_the_multiplier_of_the_particle_is_a_clock_that_runs():
    particle = vo.load("nonholonomic-particle")
    for wrong in (1, 1 / particle.multiplier, particle.multiplier**2):
        assert verdict_on(particle, multiplier=sp.sympify(wrong)).refuted


def test_the_turning_table_feeds_energy_to_the_ball():
    table = module("ball-on-turntable")
    assert verdict_on(table.SYSTEM, integrals={"energy": table.kinetic}).refuted
    moved = table.kinetic + table.Omega * table.about_axis
    assert verdict_on(table.SYSTEM, integrals={"the other way": moved}).refuted


def test_a_homogeneous_ball_circles_with_two_sevenths_of_the_tables_frequency():
    motion = vo.integrate(vo.load("ball-on-turntable"), times=np.linspace(0, 7 * np.pi, 29))
    for name in ("x", "y", "vx", "vy"):
        assert abs(motion[name][-1] - motion[name][0]) < 1e-9
    assert np.ptp(motion["x"]) > 0.5


def test_two_integrals_of_the_turntable_survive_any_change_of_its_speed():
    """(m R^2 + A) vx + A Omega(t) y is constant, and the energy of none of them."""
    table, speed = module("ball-on-turntable"), sp.Function("Omega")(vo.time)
    at = {Omega: speed}
    bonds = tuple(c.subs(at) for c in table.SYSTEM.constraints)
    given = (m, R, A, speed)
    turned = bare(table.SYSTEM, "any-table", constraints=bonds, parameters=given)
    both = m * R**2 + A
    for integral in (both * table.vx + A * speed * y, both * table.vy - A * speed * x, table.n):
        assert verdict_on(turned, integrals={"one": integral}).proved
    assert verdict_on(turned, integrals={"speed": table.vx**2 + table.vy**2}).refuted


def test_a_sleigh_that_grows_by_any_law_preserves_momenta_not_velocities():
    growth, one = sp.Function("f")(vo.time), vo.load("sleigh")
    K = J + m * a**2
    given = (m, J, a, growth)
    grown = bare(one, "any-sleigh", lagrangian=growth * one.lagrangian, parameters=given)
    law = Equation((growth * v, growth * w), (growth * a * w**2, -growth * m * a * v * w / K))
    assert verdict_on(grown, equations={"momenta": law}).proved
    assert verdict_on(grown, integrals={"energy": growth * one.lagrangian}).refuted
    assert verdict_on(grown, integrals={"of the momenta": growth**2 * one.lagrangian}).proved


def test_the_sleigh_turns_about_by_what_its_heading_says():
    """From v = -V to v = V, far back and far on, the heading changes by pi sqrt(K/m)/a."""
    sleigh = vo.load("sleigh")
    start = {"v": -1, "w": 1e-9, "x": 0, "y": 0, "phi": 0}
    motion = vo.integrate(sleigh, initial=start, times=np.linspace(0, 400, 401))
    assert abs(motion["v"][-1] - 1) < 1e-9
    turn = np.pi * np.sqrt(0.5 + 0.09) / 0.3
    assert abs(motion["phi"][-1] - turn) < 1e-6


def test_the_free_body_of_suslov_ends_where_it_turns_about_the_axis_without_momentum():
    motion = vo.integrate(vo.load("suslov"), scene="default")
    first, last = ([motion[f"omega{i}"][k] for i in (1, 2)] for k in (0, -1))
    assert abs(first[0] / 5 + 2 * first[1] / 5) > 0.01
    assert abs(last[0] / 5 + 2 * last[1] / 5) < 1e-7
    steady = vo.integrate(vo.load("suslov"), scene="principal")
    assert np.ptp(steady["omega1"]) == np.ptp(steady["omega2"]) == 0


@cache
def rattling(spin, hand):
    """The spin of a rattleback in the course of time."""
    start = {"theta": 0.01, "omega1": 0.02, "omega3": spin}
    equations = vo.derive(bare(vo.load("rattleback"), "rattleback"))
    times = np.linspace(0, 120, 241)
    motion = vo.integrate(equations, initial=start, parameters={"I12": hand}, times=times)
    return motion["omega3"]


def test_the_rattleback_turns_back_from_one_hand_only():
    against, along = rattling(-0.5, -0.25), rattling(0.5, -0.25)
    assert against[0] == -0.5 and against[-1] > 0.4
    assert min(along) > 0.4


def test_the_mirror_image_of_a_rattleback_has_the_other_hand():
    here, image = rattling(-0.5, -0.25), rattling(0.5, 0.25)
    assert np.allclose(here, -image, atol=1e-6)
    assert not np.allclose(here, -rattling(0.5, -0.25), atol=1e-2)


def test_neither_mirror_nor_reversal_alone_keeps_the_sleigh_on_its_turntable():
    """Both together keep the table and move the hook: the system is not reversible."""
    back, mirrored = (RELATIONS[f"sleigh on a turntable {k}"] for k in ("reversed", "mirrored"))
    both = Relation(
        back.source,
        back.target,
        state={"x": x, "y": -y, "phi": -phi, "v": -v, "w": w},
        parameters={**back.parameters, "Omega": Omega, "beside": -sp.Symbol("beside")},
        clock=-1,
    )
    assert vo.check_relation(both).verdict.proved
    same = replace(both, parameters={**both.parameters, "beside": sp.Symbol("beside")})
    assert vo.check_relation(same).verdict.refuted
    assert mirrored.parameters["beside"] == -sp.Symbol("beside")


def test_nearby_sleighs_on_the_turntable_part():
    whole = vo.load("sleigh-on-turntable")
    table = bare(whole, "turntable", scenes=whole.scenes)
    times = np.linspace(0, 200, 201)

    def ends(shift):
        start = {"x": 1 + shift, "v": 0.5, "w": 0.5}
        return vo.integrate(table, initial=start, parameters={"a": 0}, times=times)

    gap = np.abs(ends(0)["w"] - ends(1e-9)["w"])
    assert gap[:10].max() < 1e-7 < 1e-5 < gap[-20:].max()


SNAKEBOARD = module("snakeboard")


def test_the_rear_wheels_of_the_snakeboard_turn_by_phi_and_the_front_wheels_against_it():
    board = SNAKEBOARD
    for constraint, place, turn in zip(board.SYSTEM.constraints, (-1, 1), (phi, -phi), strict=True):
        ahead = place * board.length * velocity(theta)  # of the wheels' place, against the middle's
        moved = (Dx - ahead * sp.sin(theta), Dy + ahead * sp.cos(theta))
        across = moved[1] * sp.cos(theta + turn) - moved[0] * sp.sin(theta + turn)
        assert prove_equal(constraint, across).proved


def test_factors_that_divide_by_trigonometry_alone_cancel():
    eqs, board = vo.derive(SNAKEBOARD.SYSTEM), SNAKEBOARD
    assert eqs.mass[2, 2] == 2 * board.wheels
    assert eqs.mass[0, 1] == eqs.mass[1, 1] == board.rotor
    assert not any(
        e.has(sp.cos(phi + theta)) or e.count_ops() > 60 for e in [*eqs.mass, *eqs.force]
    )
    slide = -board.length * velocity(theta) * sp.cos(phi) / sp.sin(phi)
    assert list(eqs.rates[3:, 0]) == [slide * sp.cos(theta), slide * sp.sin(theta)]


def test_the_board_passes_where_a_pivot_would_vanish():
    energy = {"energy": SNAKEBOARD.kinetic}
    board = bare(SNAKEBOARD.SYSTEM, "board", integrals=energy, scenes=SNAKEBOARD.SYSTEM.scenes)
    motion = vo.integrate(board, method="scipy", tol=1e-11)
    crossing = motion["theta"] + motion["phi"]
    assert crossing[0] < 1.5 < crossing[-1]  # cos(theta + phi) = 0 on the way
    assert motion.drift["energy"] < 1e-8


def test_both_routes_agree_where_a_pivot_would_vanish():
    board = SNAKEBOARD.SYSTEM
    point = {theta: sp.pi / 2 - sp.Rational(3, 10), phi: sp.Rational(3, 10), psi: 0, x: 0, y: 0}
    point |= {velocity(theta): 1, velocity(psi): 2, Dphi: sp.Rational(1, 7)}
    here = vo.derive(SNAKEBOARD.SYSTEM).acceleration(point, 40)
    there = vo.multiplier_acceleration(board, point, 40)
    assert all(abs(here[q] - there[q]) < sp.Float("1e-38", 40) for q in here)


def test_steering_is_free_of_the_reaction_of_the_wheels():
    eqs = vo.derive(SNAKEBOARD.SYSTEM)
    acceleration = eqs.mass.LUsolve(eqs.force)
    assert prove_equal(acceleration[2], 0).proved
