"""Frames known by their brackets: against coordinates, against multipliers, and what is refused."""

from __future__ import annotations

import random
from dataclasses import replace
from itertools import combinations

import pytest
import sympy as sp
from without_claims import bare

import voronec as vo
from voronec import DefinitionError, Equation, Fibration, Frame, Measure, Scene, System, velocity
from voronec.kinematics import BodyVelocity, Rotation, skew, skew_entries, wedge_square

pytestmark = pytest.mark.slow

Q = sp.Rational
x, y, z, a = sp.symbols("x y z a")
w1, w2, w3 = w = sp.symbols("w1:4")
omega = sp.symbols("omega1:4")
J = (2, 3, 5)
SPINS = {(omega[0], omega[1]): {omega[2]: 1}, (omega[1], omega[2]): {omega[0]: 1},
         (omega[2], omega[0]): {omega[1]: 1}}  # fmt: skip


def solvable(fibre=(), **options):
    """d/dx, e^x d/dy, e^(a x) d/dz: a group that is not unimodular, a a parameter."""
    free = tuple(v for v in w if v not in fibre)
    frame = Frame.group(
        free,
        {(w1, w2): {w2: 1}, (w3, w1): {w3: -a}},
        {x: w1, y: sp.exp(x) * w2, z: sp.exp(a * x) * w3},
        fibre=fibre,
    )
    return System(
        name="solvable", fibration=Fibration(base=(x, y, z)), frame=frame, parameters=(a,),
        **options,
    )  # fmt: skip


def in_coordinates(fibre, system):
    """The same system with velocities of coordinates."""
    meaning = {
        w1: velocity(x),
        w2: sp.exp(-x) * velocity(y),
        w3: sp.exp(-a * x) * velocity(z),
    }
    of = dict(zip(w, (x, y, z), strict=True))
    bound = tuple(of[v] for v in fibre)
    return System(
        name="coordinates",
        fibration=Fibration(base=tuple(q for q in (x, y, z) if q not in bound), fibre=bound),
        frame=Frame.quasi({v: e for v, e in meaning.items() if v not in fibre}),
        lagrangian=system.lagrangian.subs(meaning, simultaneous=True),
        constraints=tuple(c.subs(meaning, simultaneous=True) for c in system.constraints),
        forces={of[v]: (e * meaning[v] / velocity(of[v])).subs(meaning, simultaneous=True)
                for v, e in system.forces.items()},
        parameters=(a,),
    )  # fmt: skip


def bent_lagrangian(source):
    pairs = zip((x, y, z), w, strict=True)
    kinetic = sum((2 + sp.sin(source.randint(1, 3) * q) ** 2) * v**2 for q, v in pairs)
    bent = w1**4 / (5 + z**2) + w2 * w3 * sp.cos(y) / 3 + x * w1 + vo.time * w2
    return kinetic / 2 + bent - sp.cos(source.randint(1, 3) * x * y) + z * vo.time


POINTS = [
    {x: Q(1, 3), y: Q(-2, 5), z: Q(k, 7), a: Q(2, 3), w1: Q(3, 4), w2: Q(-k, 5), "t": Q(1, k)}
    for k in (2, 3)
]


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("point", POINTS)
def test_both_routes_agree_with_each_other_and_with_coordinates(seed, point):
    """L not quadratic, a constraint that is affine and moves, forces that depend on velocities."""
    source = random.Random(seed)
    bound = (2 + sp.sin(x)) * w3 - y * w1 - source.randint(1, 4) * z * w2 - sp.cos(vo.time)
    system = solvable(
        (w3,),
        lagrangian=bent_lagrangian(source),
        constraints=(bound,),
        forces={w1: -w1 * x, w3: w2 * y},
    )
    by_connection = vo.derive(system).acceleration(point, 50)
    by_multipliers = vo.multiplier_acceleration(system, point, 50)
    assert list(by_connection) == list(by_multipliers) == [x, y, z, *w]
    coordinates = vo.derive(in_coordinates((w3,), system)).acceleration(point, 50)
    for q, found in by_connection.items():
        assert abs(found - by_multipliers[q]) <= Q(10) ** -45
        assert found != 0
        if q in coordinates:
            assert abs(found - coordinates[q]) <= Q(10) ** -45


def test_reactions_are_told_along_the_frame_and_do_no_work():
    system = solvable(
        (w3,), lagrangian=bent_lagrangian(random.Random(1)), constraints=(w3 - x * w1,)
    )
    push = vo.reaction_forces(system, POINTS[0]).generalized
    assert list(push) == list(w)
    speed = {w1: Q(3, 4), w2: Q(-2, 5), w3: Q(1, 4)}
    assert abs(sum(push[v] * speed[v] for v in w)) < Q(10) ** -25 < abs(push[w3])


def test_without_constraints_the_equations_are_those_of_euler_and_poincare():
    """No coordinates at all: a free rigid body."""
    system = System(
        name="euler",
        fibration=Fibration(base=()),
        frame=Frame.group(omega, SPINS),
        lagrangian=sum(j * v**2 for j, v in zip(J, omega, strict=True)) / 2,
    )
    eqs = vo.derive(system)
    momentum = sp.Matrix([j * v for j, v in zip(J, omega, strict=True)])
    assert eqs.mass == sp.diag(*J)
    assert (sp.Matrix(eqs.force) - momentum.cross(sp.Matrix(omega))).expand() == sp.zeros(3, 1)
    assert eqs.kind == "holonomic" and eqs.growth == (3,)
    assert eqs.brackets.c[2, 0, 1] == 1 and eqs.brackets.c[2, 1, 0] == -1
    assert eqs.brackets.B.shape == (0, 4, 4)


def test_the_equations_are_those_of_euler_angles():
    """Suslov's body with a force along the body's axes, against the same in coordinates."""
    angles = phi, theta, psi = sp.symbols("phi theta psi")
    spin = Rotation.euler("zxz", *angles).body_rates
    bound = omega[2] - Q(1, 2) * omega[0]
    energy = (sum(j * v**2 for j, v in zip(J, omega, strict=True)) + omega[0] * omega[1]) / 2
    group = System(
        name="group",
        fibration=Fibration(base=()),
        frame=Frame.group(omega[:2], SPINS, fibre=omega[2:]),
        lagrangian=energy,
        constraints=(bound,),
    )
    meaning = dict(zip(omega, spin, strict=True))
    other = System(
        name="angles",
        fibration=Fibration(base=(theta, psi), fibre=(phi,)),
        frame=Frame.quasi({v: meaning[v] for v in omega[:2]}),
        lagrangian=energy.subs(meaning),
        constraints=(bound.subs(meaning),),
    )
    eqs, known = vo.derive(group), vo.derive(other)
    assert eqs.mass == known.mass and eqs.force == known.force
    assert eqs.kind == "voronec" and eqs.growth == known.growth == (2, 3)
    # [h_1, h_2] = [X_1 + X_3/2, X_2] = X_3 - X_1/2 = -h_1/2 + (1 + 1/4) X_3
    assert eqs.brackets.c[0, 0, 1] == -Q(1, 2) and eqs.brackets.B[0, 0, 1] == Q(5, 4)
    assert eqs.curvature[0, 0, 1] == -Q(5, 4)


def test_a_fibre_that_is_an_ideal_makes_a_chaplygin_system():
    """Translations are an ideal of the motions, rotations are none."""
    body = BodyVelocity(3)
    options = {"fibration": Fibration(base=()), "lagrangian": body.energy((1, 2, 3), 1)}
    rolling = tuple(v - u for v, u in zip(body.linear, body.angular, strict=True))
    ideal = Frame.group(body.angular, body.motions, fibre=body.linear)
    other = Frame.group(body.linear, body.motions, fibre=body.angular)
    for frame, kind in ((ideal, "chaplygin"), (other, "voronec")):
        assert vo.derive(System(name="k", frame=frame, constraints=rolling, **options)).kind == kind


def ball(integrals=None, equations=None, measure=None):
    """Chaplygin's ball, with claims."""
    claims = {"integrals": integrals or {}, "equations": equations or {}, "measure": measure}
    return bare(vo.load("chaplygin-ball-in-rn@3"), "ball", **claims)


G = sp.symbols("G12 G13 G23")
DELTA = sp.Symbol("Delta")


@pytest.mark.parametrize(
    "claims",
    [
        {"integrals": {"f": G[0] ** 2 + G[1] ** 2 - G[2] ** 2}},
        {"integrals": {"f": G[0] * sp.Symbol("Omega12") + sp.Symbol("gamma1")}},
        {"integrals": {"f": sp.Symbol("Delta")}},
        {"equations": {"e": Equation(G, skew_entries(skew(G, 3) * BodyVelocity(3).matrix))}},
        {"measure": Measure(DELTA)},
        {"measure": Measure(1 / sp.sqrt(DELTA))},
        {"measure": Measure(sp.sqrt(DELTA) * sp.Symbol("gamma1"))},
    ],
)  # fmt: skip
def test_false_claims_about_momenta_and_the_determinant_are_refuted(claims):
    (claim,) = vo.check_claims(ball(**claims))
    assert claim.verdict.refuted and claim.verdict.witness is not None


def test_names_of_momenta_stand_for_what_they_are():
    """The same claims with the momenta written out, decided with the inverse of the mass."""
    system = ball()
    eqs = vo.derive(system)
    meaning = dict(zip(G, eqs.mass * sp.Matrix(eqs.velocities), strict=True))
    square = sum(g**2 for g in G)
    written = ball(
        {"named": square, "written": square.subs(meaning)}, measure=Measure(sp.sqrt(eqs.mass.det()))
    )
    assert all(c.verdict.proved for c in vo.check_claims(written))


def body_with_invariants(**claims):
    """A heavy top; of its angular velocity the third part is c times the first."""
    normal, named = sp.Matrix((x, y, z)), sp.symbols("M1 M2")
    rates = dict(zip((x, y, z), normal.cross(sp.Matrix(omega)), strict=True))
    first, second, third = omega
    kinetic = sum(j * v**2 for j, v in zip(J, omega, strict=True)) / 2
    return System(
        name="bound-top",
        fibration=Fibration(base=(x, y, z), relations=(normal.dot(normal) - 1,)),
        frame=Frame.group(
            (first, second), SPINS, rates, fibre=(third,), momenta=named, determinant=DELTA,
        ),
        lagrangian=kinetic - z,
        constraints=(third - a * first,),
        parameters=(a,),
        invariants={"g1": x, "g2": y, "g3": z},
        **claims,
    )  # fmt: skip


def test_what_moves_is_no_constant_on_the_invariants():
    """Named momenta, the determinant and dependent velocities beside names of invariants."""
    M1, g1, g2, g3 = sp.symbols("M1 g1:4")
    first, second, third = omega
    inertia = J[0] + J[2] * a**2  # of the first velocity, with the third
    energy = (inertia * first**2 + J[1] * second**2) / 2 + g3
    found = body_with_invariants(
        integrals={
            "energy": energy,
            "bound": third - a * first,
            "named": M1 - inertia * first,
            "momentum": M1,
            "momentum over g1": M1 * (2 + g1),
            "third": third,
        },
        equations={
            "normal": Equation(g1, g2 * third - g3 * second),
            "third": Equation(third, 0),
        },
    )
    said = {(c.kind, c.name): c.verdict.status for c in vo.check_claims(found)}
    true = {("integral", n) for n in ("energy", "bound", "named")} | {("equation", "normal")}
    true |= {("descent", "g1, g2, g3")}
    assert said == {k: "proved" if k in true else "refuted" for k in said}


def test_a_measure_on_the_invariants_knows_the_determinant_and_no_momentum():
    volume = (*sp.symbols("g1:4"), *omega[:2])
    ball = replace(body_with_invariants(), parameters=(), constraints=(omega[2],))
    ball = replace(ball, lagrangian=ball.lagrangian + sp.Symbol("z") * omega[0] ** 2)
    eqs = vo.derive(ball)
    assert eqs.mass.det().has(z)
    for power in (1, 2):
        claims = [
            only_measure(replace(ball, measure=Measure(f**power, volume)))
            for f in (DELTA, eqs.mass.det().subs(z, sp.Symbol("g3")))
        ]
        assert claims[0].status == claims[1].status != "undecided"
    for moving in (sp.Symbol("M1"), omega[2]):
        verdict = only_measure(replace(ball, measure=Measure(2 + moving**2, volume)))
        assert verdict.undecided and "has no meaning on the invariants" in verdict.method


def only_measure(system):
    (claim,) = (c for c in vo.check_claims(system) if c.kind == "measure")
    return claim.verdict


def test_dependent_velocities_and_momenta_can_be_watched():
    scene = Scene(initial={"gamma3": 1, "Omega12": 1, "Omega13": 2}, times=(0.0, 1.0))
    traj = vo.integrate(ball(), scene=scene, outputs=("W1", "G13", "gamma1"))
    assert traj["W1"][0] == pytest.approx(2)  # R Omega gamma
    assert traj["G13"][0] == pytest.approx((0.5 + 1) * 2)  # I13 + D
    assert traj.residuals and max(traj.residuals.values()) < 1e-12


def test_programs_and_latex_are_written():
    eqs = vo.derive(ball())
    assert "Omega12" in eqs.python() and "gamma1" in eqs.c() and r"\gamma_{1}" in eqs.latex()
    data = eqs.as_dict()
    assert data["fibre"] == ["W1", "W2", "W3"] and set(data["rates"]) == {
        "gamma1", "gamma2", "gamma3",
    }  # fmt: skip


@pytest.mark.parametrize("n", [2, 3, 4, 5])
def test_brackets_of_bodies_are_the_commutators_of_matrices(n):
    body = BodyVelocity(n)
    names = (*body.angular, *body.linear)
    whole = sp.zeros(n + 1, n + 1)
    whole[:n, :n], whole[:n, n] = body.matrix, sp.Matrix(body.linear)
    unit = {v: whole.diff(v) for v in names}
    for p, q in combinations(names, 2):
        found = body.motions.get((p, q), {})
        other = body.motions.get((q, p), {})
        total = sum((unit[c] * k for c, k in found.items()), sp.zeros(n + 1, n + 1))
        total -= sum((unit[c] * k for c, k in other.items()), sp.zeros(n + 1, n + 1))
        assert total == unit[p] * unit[q] - unit[q] * unit[p]


def test_a_skew_matrix_times_itself():
    m = skew(sp.symbols("m1:7"), 4)
    assert (wedge_square(m)[0] ** 2 - m.det()).expand() == 0
    five = skew(sp.symbols("m1:11"), 5)
    assert (five * wedge_square(five)).expand() == sp.zeros(5, 1)
    assert wedge_square(m.as_mutable()) == wedge_square(m)
    assert skew_entries(m.as_mutable()) == sp.symbols("m1:7")


def system(brackets=SPINS, rates=None, coordinates=(), velocities=omega, fibre=(), **options):
    given = {"lagrangian": sum(v**2 for v in omega), "name": "wrong"} | options
    return System(
        fibration=given.pop("fibration", Fibration(base=coordinates)),
        frame=Frame.group(velocities, brackets, rates, fibre=fibre),
        **given,
    )


clocked = sp.Function("m")(vo.time)
TURNED = dict(zip((x, y, z), sp.Matrix((x, y, z)).cross(sp.Matrix(omega)), strict=True))
BAD = {
    "Jacobi": (
        lambda: system({(omega[0], omega[1]): {omega[0]: 1}, (omega[0], omega[2]): {omega[1]: 1}}),
        "Jacobi's identity for omega1, omega2, omega3",
    ),
    "rates": (
        lambda: system(rates={q: -r for q, r in TURNED.items()}, coordinates=(x, y, z)),
        "the rate of 'x' does not obey the bracket of omega1 and omega2",
    ),
    "bent rates": (
        lambda: system(rates={x: omega[0] ** 2}, coordinates=(x,)), "'x' is not linear",
    ),
    "missing rate": (lambda: system(coordinates=(x,)), "no rate for 'x'"),
    "foreign rate": (lambda: system(rates={x: omega[0]}), "rate for 'x', which is not a coord"),
    "moving bracket": (
        lambda: system({(omega[0], omega[1]): {omega[2]: x}}, {x: 0}, (x,)), "contains 'x'",
    ),
    "time in a rate": (
        lambda: system({}, {x: vo.time * w1}, (x,), (w1,), lagrangian=w1**2),
        "the rate of 'x' holds the time",
    ),
    "a rate that grows": (
        lambda: system({}, {x: clocked * w1}, (x,), (w1,), lagrangian=w1**2, parameters=(clocked,)),
        "the rate of 'x' holds the time",
    ),
    "bracket twice": (
        lambda: system({**SPINS, (omega[1], omega[0]): {omega[2]: -1}}), "given twice",
    ),
    "foreign bracket": (lambda: system({(omega[0], x): {omega[2]: 1}}), "velocities of the frame"),
    "relation": (
        lambda: system(
            rates=TURNED, fibration=Fibration(base=(x, y, z), relations=(x**2 + y - z,))
        ),
        r"does not keep the relation x\*\*2 \+ y - z = 0",
    ),
    "fibre coordinates": (
        lambda: system(rates={x: 0}, fibration=Fibration(base=(), fibre=(x,))), "stand in the base",
    ),
    "count": (lambda: system(velocities=omega[:2], fibre=omega[2:]), "0 constraint.* for 1 veloc"),
    "open fibre": (
        lambda: system(velocities=omega[:2], fibre=omega[2:], constraints=(omega[0] - omega[1],)),
        r"undetermined: omega3\); a split that works: base=\(omega[123], omega[123]\)",
    ),
    "force": (
        lambda: system(rates=TURNED, coordinates=(x, y, z), forces={x: 1}),
        "'x', which is not a velocity of the frame",
    ),
    "no inertia": (lambda: system(lagrangian=omega[0] ** 2), "gives 'omega2' no inertia"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_what_is_wrong_is_told_in_one_line(case):
    make, message = case
    with pytest.raises(DefinitionError, match=message) as caught:
        vo.derive(make())
    assert "\n" not in str(caught.value)


def test_momenta_are_named_for_every_velocity_or_for_none():
    with pytest.raises(DefinitionError, match="3 velocities and 1 momenta"):
        Frame.group(omega, SPINS, momenta=(x,))
