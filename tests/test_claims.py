"""Claims as they are declared, and claims that are false."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
import sympy as sp
from balls import R, inertia, m, omega, rolling_ball
from sympy.core.function import AppliedUndef

import voronec as vo
from voronec import Fibration, Frame, Measure, System, kinematics, prove_equal, velocity
from voronec.declaration.claims import right_of
from voronec.equations.motions import Motions
from voronec.proof.claims import check_claims, specialise
from voronec.proof.measures import defect, measured_field

NOTHING = {
    "integrals": {},
    "equations": {},
    "measure": None,
    "invariants": {},
    "multiplier": None,
    "poisson": None,
    "essential": (),
    "integrable": "",
    "cases": {},
    "undecided": {},
}


@cache
def derived(name):
    return vo.derive(vo.load(name))


def verdict_on(system, **claims):
    """The first verdict on a system of which these are the only claims."""
    bare = replace(system, **NOTHING)
    return check_claims(replace(bare, **claims))[0].verdict


@pytest.mark.slow
def test_what_is_declared_undecided_is_true_in_numbers():
    names = [n for n in vo.names() if vo.load(n).undecided]
    assert names
    for name in names:
        admitted = [c for c in check_claims(derived(name)) if c.reason]
        assert admitted, name
        for claim in admitted:
            assert claim.is_admitted and "agree to 200 digits" in claim.verdict.method, name


MOVING = (
    "ball-on-turntable-in-time", "bicycle", "chaplygin-ball", "demchenko", "falling-disc",
    "rubber-ball-in-rn", "sleigh", "veselova-in-new-time",
)  # fmt: skip
"""In coordinates, Euler angles, quasi-velocities, on a group, and with the time."""


@pytest.mark.slow
@pytest.mark.parametrize("name", MOVING)
def test_a_claim_that_is_off_is_refuted_at_a_point(name):
    """With a coordinate added to the energy, the rate is that coordinate's."""
    system, eqs = vo.load(name), derived(name)
    moving = next(q for q, r in zip(system.coordinates, eqs.rates, strict=True) if r != 0)
    energy = system.conserved.get("energy", sp.Integer(0))
    verdict = verdict_on(system, integrals={"off": energy + moving})
    assert verdict.refuted and verdict.witness.left != verdict.witness.right == "0"
    rate = eqs.rates[system.coordinates.index(moving)]
    names = rate.free_symbols | rate.atoms(AppliedUndef, sp.Derivative)
    place = verdict.witness.point
    at = {s: sp.Rational(place.get(str(eqs.bridge.inward(s)), 0)) for s in names}
    assert abs(sp.N(rate.xreplace(at), 30) - sp.Float(verdict.witness.left, 30)) < 1e-20


MEASURED = (
    "ball-on-turntable-in-time", "demchenko", "nonholonomic-particle",
    "rubber-ball-in-new-time", "sleigh", "veselova", "veselova-in-rn",
)  # fmt: skip
"""Measures in coordinates, invariants, parts of the state, on a group, and with the time."""


def with_measure(system, factor):
    """The verdict on the density times a factor, in the variables of the measure."""
    measure = right_of(system.measure)
    claimed = Measure(measure.density * factor, measure.variables)
    return verdict_on(system, measure=claimed, invariants=system.invariants)


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_a_density_times_an_integral_is_a_density_and_times_another_function_is_none(name):
    system, motions = vo.load(name), Motions(derived(name))
    field, chosen = measured_field(motions, measure := right_of(system.measure)), set()
    chosen = {*measure.variables} or {*system.known_symbols(), *system.invariant_symbols}
    constant = {p.symbol for p in system.parameters}
    for integral in map(right_of, system.integrals.values()):
        if integral.free_symbols <= chosen | constant:
            assert with_measure(system, integral).proved
    rates = zip(field.variables, field.components, strict=True)
    own = {field.bridge.inward(x) for x in chosen}
    moving = next(field.bridge.outward(x) for x, rate in rates if rate != 0 and x in own)
    wrong = with_measure(system, 2 + sp.sin(moving))
    assert wrong.refuted and wrong.witness.left != wrong.witness.right


@pytest.mark.slow
def test_the_measure_of_chaplygins_ball_needs_its_root():
    """Chaplygin's multiplier sqrt(1 - D (gamma, (I + D)^-1 gamma)) and sin(theta), both."""
    ball = vo.load("chaplygin-ball")
    density = ball.cases["in Euler angles"].measure.density
    volume = sp.sin(sp.Symbol("theta"))
    assert verdict_on(ball, measure=density).proved
    for wrong in (1, volume, density / volume, volume / density, density**2):
        assert verdict_on(ball, measure=wrong).refuted


@pytest.mark.slow
def test_demchenkos_measure_is_the_volume_of_both_spheres():
    ball = vo.load("demchenko")
    u, u1 = sp.symbols("u u1")
    assert verdict_on(ball, measure=3 * sp.sin(u) * sp.sin(u1)).proved
    for wrong in (1, sp.sin(u), sp.sin(u1), sp.sin(u) ** 2 * sp.sin(u1)):
        assert verdict_on(ball, measure=wrong).refuted


def test_the_sleigh_has_no_simple_measure():
    """Its equilibria v > 0 attract: only a density that is singular where w = 0 is invariant."""
    sleigh = vo.load("sleigh")
    v, w, phi, a = sp.symbols("v w phi a")
    for naive in (1, v**2 + 1, sp.cos(phi), sp.exp(phi), 1 + w**2, sp.exp(-v)):
        verdict = verdict_on(sleigh, measure=naive)
        assert verdict.refuted and verdict.witness.left != "0"
    assert verdict_on(sleigh, measure=1 / w).proved
    balanced = specialise(sleigh, {a: 0})
    assert verdict_on(balanced, integrals={"v": v}).proved
    assert verdict_on(balanced, measure=1).proved


@pytest.mark.parametrize(
    ("relation", "status", "words"),
    [
        (lambda x, y: x**2 + y**2 + 1, "refuted", "no motions: x**2 + y**2 + 1 = 0 holds nowhere"),
        (lambda x, y: sp.sin(x) - y**2 - 2, "refuted", "there are no motions"),
        (lambda x, y: sp.sqrt(x) + 1 + y**2, "refuted", "there are no motions"),
        (lambda x, y: x**4 * y**2 + x**2 * y**4 - 3 * x**2 * y**2 + 2, "undecided", "no point"),
    ],
)
@pytest.mark.parametrize("framed", [False, True])
def test_relations_that_no_state_meets_leave_no_motions(relation, status, words, framed):
    x, y, w = sp.symbols("x y w")
    bound = relation(x, y)
    split = ((x, y), ()) if framed else ((x,), (y,))
    empty = System(
        name="empty",
        fibration=Fibration(*split, relations=(bound,)),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2,
        frame=vo.Frame.quasi({w: velocity(x) / bound.diff(y)}) if framed else None,
        integrals={"x": x},
        measure=1,
    )
    found = vo.check_claims(empty)
    assert [c.kind for c in found] == ["integral", "measure"]
    assert {c.verdict.status for c in found} == {status}
    assert all(words in c.verdict.method for c in found)


def test_the_divergence_of_a_size_is_that_of_a_real_number():
    x = sp.Symbol("x")
    assert vo.divergence(sp.Abs(x), {x: sp.Abs(x) * x}) == 2 * x**2 + sp.Abs(x) ** 2


@pytest.mark.parametrize("bent", [0, 1], ids=["quadratic", "quartic"])
def test_the_divergence_is_the_divergence(bent):
    """(1 + x^2 + bent v^2) vdot = -k v - x v^2, xdot = v: by hand, and d(v^2 x)/dt."""
    x, k = sp.symbols("x k")
    v = velocity(x)
    system = System(
        name="drag",
        fibration=Fibration((x,)),
        lagrangian=(1 + x**2) * v**2 / 2 + bent * v**4 / 12,
        forces={x: -k * v},
        parameters=(k,),
    )
    field = Motions.of(system).on_coordinates
    vdot = -(k * v + x * v**2) / (1 + x**2 + bent * v**2)
    for density in (sp.Integer(1), x**2 * v, sp.exp(x)):
        found = field.bridge.outward(defect(field, field.read(density)))
        expected = vo.divergence(density, {x: v, v: vdot})
        assert expected == (density * v).diff(x) + (density * vdot).diff(v)
        assert prove_equal(found, expected).proved
    rate = field.bridge.outward(field.derivative(field.read(v**2 * x)))
    assert prove_equal(rate, 2 * x * v * vdot + v**3).proved


def test_time_and_moving_constraints_count():
    """A bead on a turning rod: not the energy but Jacobi's integral stays."""
    r, phi, big = sp.symbols("r phi Omega")
    energy = (velocity(r) ** 2 + r**2 * velocity(phi) ** 2) / 2
    system = System(
        name="rod",
        fibration=Fibration((r,), (phi,)),
        lagrangian=energy,
        constraints=(velocity(phi) - big,),
        parameters=(big,),
    )
    assert verdict_on(system, integrals={"energy": energy}).refuted
    jacobi = (velocity(r) ** 2 - r**2 * big**2) / 2
    assert verdict_on(system, integrals={"jacobi": jacobi}).proved
    assert verdict_on(system, integrals={"angle": phi - big * vo.time}).proved
    assert verdict_on(system, integrals={"angle": phi}).refuted
    growing = (velocity(r) - big * r) * sp.exp(big * vo.time)
    assert verdict_on(system, integrals={"growing": growing}).proved


def quaternion_ball():
    rotation = kinematics.Rotation.quaternion(*sp.symbols("q0:4"))
    gamma, spin = sp.Matrix(rotation.matrix.row(2)).T, sp.Matrix(omega)
    momentum = sp.diag(*inertia) * spin + m * R**2 * (spin - gamma * gamma.dot(spin))
    share = sum(m * R**2 * g**2 / (i + m * R**2) for g, i in zip(gamma, inertia, strict=True))
    return replace(
        rolling_ball(rotation, {}),
        integrals={"squared": momentum.dot(momentum), "along": momentum.dot(gamma)},
        measure=sp.sqrt(1 - share),
    )


@pytest.mark.slow
def test_claims_in_redundant_coordinates_hold_on_the_relations():
    ball = quaternion_ball()
    assert [c.verdict.status for c in check_claims(ball)] == ["proved"] * 3
    q0 = sp.Symbol("q0")
    wrong = verdict_on(ball, integrals={"wrong": ball.integrals["squared"] + q0})
    place = [sp.Rational(wrong.witness.point[f"q{i}"]) for i in range(4)]
    assert wrong.refuted and abs(sum(c**2 for c in place) - 1) < 1e-25
    assert not verdict_on(ball, measure=1).proved


def test_a_measure_on_a_circle_is_that_of_the_circle():
    """With w = angular velocity / x the density is x; off the circle the field may be anything."""
    x, y, w = sp.symbols("x y w")
    system = System(
        name="circle",
        fibration=Fibration((x, y), relations=(x**2 + y**2 - 1,)),
        frame=Frame.quasi({w: (x * velocity(y) - y * velocity(x)) / x}),
        lagrangian=(velocity(x) ** 2 + velocity(y) ** 2) / 2,
    )
    assert verdict_on(system, measure=x).proved
    assert verdict_on(system, measure=1).refuted


def test_a_false_descent_is_refuted():
    ball = vo.load("chaplygin-ball")
    verdict = verdict_on(ball, invariants={"height": sp.cos(sp.Symbol("theta"))})
    assert verdict.refuted and "not a function of the invariants" in verdict.method


def test_a_claim_beyond_the_budget_is_undecided():
    sleigh = vo.load("sleigh")
    phi, x, y, w = sp.symbols("phi x y w")
    huge = (sum(p.symbol for p in sleigh.parameters) + phi + x + y + sp.sin(phi)) ** 60
    energy = sleigh.integrals["energy"]
    hidden = energy + huge * (sp.sin(phi + w) ** 2 + sp.cos(phi + w) ** 2) - huge
    for claim in (energy * sp.exp(huge) ** 0 + hidden, sp.sqrt(energy**2 + 1) * energy**40):
        assert not verdict_on(sleigh, integrals={"huge": claim}).refuted
    assert not verdict_on(sleigh, measure=1 / (huge + 1) + hidden).proved


def test_a_claim_with_a_function_that_is_not_known_may_be_true():
    """The error function of the energy is an integral; that the engine has none refutes nothing."""
    x, d = sp.Symbol("x"), velocity(sp.Symbol("x"))
    spring = System(name="spring", fibration=Fibration((x,)), lagrangian=(d**2 - x**2) / 2)
    energy = d**2 + x**2
    for claim in (
        {"integrals": {"error function": sp.erf(energy)}},
        {"measure": 2 + sp.besselj(0, energy) ** 2},
    ):
        verdict = verdict_on(spring, **claim)
        assert verdict.undecided and "does not differentiate" in verdict.method, claim


def test_a_claim_that_divides_by_a_hidden_zero_has_an_answer():
    sleigh, w, phi = vo.load("sleigh"), *sp.symbols("w phi")
    nowhere = w / (sp.sin(phi) ** 2 + sp.cos(phi) ** 2 - 1)
    assert verdict_on(sleigh, integrals={"nowhere": nowhere}).undecided
    assert verdict_on(sleigh, measure=nowhere).undecided
    potential = replace(sleigh, lagrangian=sleigh.lagrangian + 1 / nowhere + nowhere)
    assert not verdict_on(potential, integrals={"w": w}).proved
