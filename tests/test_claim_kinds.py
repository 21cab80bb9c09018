"""Every kind of claim: proved where it is true, refuted where it is made false."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

import voronec as vo
from voronec import (
    Case,
    Corrected,
    DefinitionError,
    Equation,
    Fibration,
    Frame,
    Measure,
    Parameter,
    Poisson,
    System,
    velocity,
)
from voronec.equations.motions import Motions
from voronec.proof.claims import specialise

pytestmark = pytest.mark.slow

x, y, phi, psi = sp.symbols("x y phi psi")
v, w = sp.symbols("v w")
m, k = sp.symbols("m k")
Dx, Dy, Dphi, Dpsi = map(velocity, (x, y, phi, psi))


def skate(**claims):
    """A skate on a slope: it cannot slip sideways; v along the blade, w turning."""
    return System(
        name="skate",
        fibration=Fibration(base=(x, phi), fibre=(y,)),
        frame=Frame.quasi({v: Dx * sp.cos(phi) + Dy * sp.sin(phi), w: Dphi}),
        lagrangian=m * (Dx**2 + Dy**2) / 2 + Dphi**2 / 2 + k * x,
        constraints=(Dx * sp.sin(phi) - Dy * sp.cos(phi),),
        parameters=(Parameter(m, 1, positive=True), Parameter(k, 2)),
        **claims,
    )


def top(**claims):
    """Euler's equations in gamma and omega, made of rotation about a fixed point."""
    angles = sp.symbols("phi theta psi")
    rotation = vo.kinematics.Rotation.euler("zxz", *angles)
    energy = sum(i * r**2 for i, r in zip(INERTIA, rotation.body_rates, strict=True)) / 2
    return System(
        name="top",
        fibration=Fibration(base=angles),
        frame=Frame.quasi(dict(zip(OMEGA, rotation.body_rates, strict=True))),
        lagrangian=energy,
        parameters=INERTIA,
        invariants={f"gamma{i + 1}": g for i, g in enumerate(rotation.matrix.row(2))},
        **claims,
    )


OMEGA, GAMMA = sp.symbols("omega1:4"), sp.symbols("gamma1:4")
INERTIA, G = sp.symbols("I1:4"), sp.symbols("G1:4")
SPIN, NORMAL, MOMENTUM = sp.Matrix(OMEGA), sp.Matrix(GAMMA), sp.Matrix(G)


def only(system, kind):
    (claim,) = (c for c in vo.check_claims(system) if c.kind == kind)
    return claim


def status(system, kind):
    return only(system, kind).verdict.status


# Integrals and equations.


def test_claims_without_coordinates_are_decided_on_the_reduced_field():
    momentum = sp.diag(*INERTIA) * SPIN
    system = top(
        integrals={"vertical": momentum.dot(NORMAL), "tilt": sp.cos(sp.Symbol("theta"))},
        equations={"euler": Equation(momentum, momentum.cross(SPIN))},
    )
    found = {c.name: c for c in vo.check_claims(system)}
    assert found["vertical"].verdict.proved and found["vertical"].level == "invariants"
    assert found["euler"].verdict.proved and found["euler"].level == "invariants"
    assert found["tilt"].verdict.refuted and found["tilt"].level == "coordinates"


def test_the_first_entry_of_an_equation_that_fails_is_named():
    turned = NORMAL.cross(SPIN) + sp.Matrix([0, OMEGA[0], 0])
    claim = only(top(equations={"normal": Equation(NORMAL, turned)}), "equation")
    assert claim.verdict.refuted and claim.verdict.method.startswith("entry 2")
    assert claim.verdict.witness is not None
    assert status(top(equations={"normal": Equation(NORMAL, NORMAL.cross(SPIN))}), "equation")


def test_explicit_time_counts_in_integrals_and_equations():
    system = skate(integrals={"turned": phi - w * vo.time}, equations={"w": Equation(w, 0)})
    assert [c.verdict.status for c in vo.check_claims(system)] == ["proved"] * 2
    off = skate(equations={"w": Equation(w * vo.time, 0)})
    assert only(off, "equation").verdict.refuted


# Corrected claims.

ENERGY = m * v**2 / 2 + w**2 / 2 - k * x


def test_a_correction_needs_a_right_form_and_a_false_print():
    wrong = m * v**2 / 2 + w**2 - k * x - v
    claim = only(skate(integrals={"energy": Corrected(ENERGY, wrong, "Book")}), "integral")
    assert claim.verdict.proved and claim.printed.refuted and claim.source == "Book"
    assert claim.standing == "proved; refuted as printed in Book"
    swapped = only(skate(integrals={"energy": Corrected(wrong, ENERGY, "Book")}), "integral")
    assert swapped.verdict.refuted and swapped.printed.proved


def test_a_print_that_is_true_needs_no_correction():
    claim = only(skate(integrals={"energy": Corrected(ENERGY, 2 * ENERGY, "Book")}), "integral")
    assert claim.verdict.refuted and "nothing to correct" in claim.verdict.method


def test_equations_and_measures_may_be_corrected():
    right, wrong = Equation(w, 0), Equation(w, v)
    system = skate(equations={"w": Corrected(right, wrong, "A")}, measure=Corrected(1, v, "B"))
    for claim in vo.check_claims(system):
        assert claim.verdict.proved and claim.printed.refuted


# Measures.


def sphere(**claims):
    """A free particle on the sphere in redundant coordinates; p is x times a velocity."""
    a, b, c = sp.symbols("a b c")
    return System(
        name="sphere",
        fibration=Fibration((a, b, c), relations=(a**2 + b**2 + c**2 - 1,)),
        frame=Frame.quasi({v: velocity(a), w: velocity(b)}),
        lagrangian=sum(velocity(s) ** 2 for s in (a, b, c)) / 2,
        **claims,
    )


@pytest.mark.parametrize("power", [-4, -3, -2, -1, 0, 1])
def test_a_measure_on_a_sphere_in_redundant_coordinates(power):
    """The volume that belongs to the relation is da db/(2 c); the momenta conjugate to a and b have
    the determinant 1/c^2 in v and w."""
    verdict = status(sphere(measure=sp.Symbol("c") ** power), "measure")
    assert verdict == ("proved" if power == -1 else "refuted")


def test_a_measure_of_a_closed_part_of_the_variables():
    assert status(skate(measure=Measure(1 / w, (phi, w))), "measure") == "proved"
    part = only(skate(measure=Measure(1, (v, w))), "measure").verdict
    assert part.refuted and "'v' changes with 'phi'" in part.method


def test_a_measure_in_invariants_and_its_falsification():
    assert status(top(measure=Measure(1, (*GAMMA, *OMEGA))), "measure") == "proved"
    assert status(top(measure=Measure(GAMMA[0] + 2, (*GAMMA, *OMEGA))), "measure") == "refuted"


HIDDEN = sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1


@pytest.mark.parametrize("density", [0, HIDDEN, HIDDEN * sp.exp(Dx)])
def test_a_density_that_vanishes_is_none(density):
    """Friction has no invariant measure, and zero is no density."""
    system = System(
        name="friction",
        fibration=Fibration((x,)),
        lagrangian=Dx**2 / 2 - x**4 / 4,
        forces={x: -(Dx**3)},
        measure=density,
        integrable="Euler-Jacobi",
    )
    claims = {c.kind: c.verdict for c in vo.check_claims(system)}
    assert claims["measure"].refuted and "vanishes identically" in claims["measure"].method
    assert claims["integrable"].undecided


def test_a_density_that_is_nowhere_seen_is_undecided():
    away = Measure(sp.sqrt(-1 - w**2), (phi, w))
    verdict = only(skate(measure=away), "measure").verdict
    assert verdict.undecided and "whether the density vanishes" in verdict.method


# The reducing multiplier.


def nonuniform(n, power=1, **parts):
    """A particle with ydot = u(x) zdot: a Chaplygin system, whose multiplier is 1/sqrt(1 + u^2)."""
    z, u = sp.Symbol("z"), x**power
    return System(
        name="particle",
        fibration=Fibration(base=(x, z), fibre=(y,)),
        lagrangian=(Dx**2 + Dy**2 + velocity(z) ** 2) / 2 + parts.get("potential", 0),
        constraints=(Dy - u * velocity(z),),
        multiplier=n,
    )


def test_the_multiplier_of_a_particle():
    n = 1 / sp.sqrt(1 + x**2)
    assert status(nonuniform(n), "multiplier") == "proved"
    assert status(nonuniform(n, potential=-(x**4)), "multiplier") == "proved"
    for wrong in (1, 1 / n, n**2, n * (2 + x)):
        claim = only(nonuniform(wrong), "multiplier")
        assert claim.verdict.refuted and claim.verdict.method.startswith("the equation of")


def test_a_multiplier_needs_a_lagrangian_over_the_base():
    claim = only(nonuniform(1, potential=y), "multiplier")
    assert claim.verdict.refuted and "Lc depends on 'y'" in claim.verdict.method
    claim = only(nonuniform(1 + y**2), "multiplier")
    assert claim.verdict.refuted and "the multiplier depends on 'y'" in claim.verdict.method


@pytest.mark.parametrize("zero", [0, HIDDEN])
def test_a_multiplier_that_vanishes_is_refuted(zero):
    claim = only(nonuniform(sp.sympify(zero)), "multiplier")
    assert claim.verdict.refuted and "vanishes identically" in claim.verdict.method


def test_a_multiplier_in_a_frame_of_quasi_velocities():
    z = sp.Symbol("z")
    plain = nonuniform(1 / sp.sqrt(1 + x**2))
    framed = {"frame": Frame.quasi({v: Dx + velocity(z), w: 2 * velocity(z) * (1 + x**2)})}
    assert status(replace(plain, **framed), "multiplier") == "proved"
    assert status(replace(plain, **framed, multiplier=sp.Integer(1)), "multiplier") == "refuted"


# Brackets.


def lie_poisson(change=0, hamiltonian=None, clock=1):
    a, b, c = G
    g1, g2, g3 = GAMMA
    return Poisson(
        variables={s: s for s in GAMMA} | dict(zip(G, sp.diag(*INERTIA) * SPIN, strict=True)),
        bracket={
            (a, b): -c + change, (b, c): -a, (c, a): -b,
            (a, g2): -g3, (a, g3): g2, (b, g1): g3, (b, g3): -g1, (c, g1): -g2, (c, g2): g1,
        },
        hamiltonian=MOMENTUM.dot(SPIN) / 2 if hamiltonian is None else hamiltonian,
        clock=clock,
    )  # fmt: skip


def test_eulers_equations_are_hamiltonian():
    claim = only(top(poisson=lie_poisson()), "poisson")
    assert claim.verdict.proved and claim.level == "invariants"
    scaled = lie_poisson(hamiltonian=MOMENTUM.dot(SPIN), clock=sp.Rational(1, 2))
    assert status(top(poisson=scaled), "poisson") == "proved"


@pytest.mark.parametrize(
    ("claim", "part"),
    [
        (lie_poisson(change=G[0]), "Jacobi's identity"),
        (lie_poisson(change=GAMMA[0] * GAMMA[1]), "Jacobi's identity"),
        (lie_poisson(hamiltonian=MOMENTUM.dot(SPIN)), "the rate of"),
        (lie_poisson(clock=GAMMA[0]), "the rate of"),
    ],
    ids=["of momentum", "of gamma", "hamiltonian", "clock"],
)
def test_the_part_of_a_bracket_that_fails_is_named(claim, part):
    verdict = only(top(poisson=claim), "poisson").verdict
    assert verdict.refuted and verdict.method.startswith(part)


def test_a_bracket_keeps_the_relations():
    """Brackets that hold on gamma of any length, but let the length change."""
    loose = Poisson(
        variables={s: s for s in (*GAMMA, *OMEGA)},
        bracket={(g, o): sp.Integer(1) for g, o in zip(GAMMA, OMEGA, strict=True)},
        hamiltonian=sp.Integer(0),
    )
    verdict = only(top(poisson=loose), "poisson").verdict
    assert verdict.refuted and verdict.method.startswith("the bracket of omega1 with")


def circle(**claims):
    """A particle on a circle in redundant coordinates."""
    a, b = sp.symbols("a b")
    return System(
        name="circle",
        fibration=Fibration((a, b), relations=(a**2 + b**2 - 1,)),
        frame=Frame.quasi({v: a * velocity(b) - b * velocity(a)}),
        lagrangian=(velocity(a) ** 2 + velocity(b) ** 2) / 2,
        **claims,
    )


def test_a_bracket_of_as_many_variables_as_are_independent():
    a, b, slope = sp.symbols("a b slope")
    variables = {slope: b / a, v: v}
    true = Poisson(variables, {(slope, v): 1 + slope**2}, v**2 / 2)
    also = Poisson(variables, {(slope, v): 1 / a**2}, v**2 / 2)
    false = Poisson(variables, {(slope, v): 1 + 2 * slope**2}, v**2 / 2)
    found = [status(circle(poisson=claim), "poisson") for claim in (true, also, false)]
    assert found == ["proved", "proved", "refuted"]


def test_the_variables_of_a_bracket_determine_the_state():
    p = sp.Symbol("p")
    few = Poisson({p: m * v, w: w}, {(p, w): sp.Integer(1)}, p)
    verdict = only(skate(poisson=few), "poisson").verdict
    assert verdict.refuted and "do not determine the state" in verdict.method
    twice = Poisson(dict(zip(sp.symbols("p1:6"), (x, y, phi, w, w**2), strict=True)), {}, 0)
    assert "do not determine" in only(skate(poisson=twice), "poisson").verdict.method


def test_canonical_variables_of_an_oscillator_with_its_state_in_the_bracket():
    q, p = sp.symbols("q p")
    system = System(
        name="oscillator",
        fibration=Fibration(x),
        lagrangian=m * Dx**2 / 2 - k * x**2 / 2,
        parameters=(m, k),
        poisson=Poisson({q: x**3, p: m * Dx}, {(q, p): 3 * x**2}, p**2 / (2 * m) + k * x**2 / 2),
    )
    assert status(system, "poisson") == "proved"


# Closed parts of the state, integrability, cases.


def test_closed_parts_of_the_state():
    assert status(skate(essential=(phi, v, w)), "essential") == "proved"
    verdict = only(skate(essential=(v, w)), "essential").verdict
    assert verdict.refuted and "'v' changes with 'phi'" in verdict.method
    assert verdict.witness is not None
    assert status(top(essential=OMEGA), "essential") == "proved"
    verdict = only(top(essential=GAMMA), "essential").verdict
    assert verdict.refuted and "changes with 'omega" in verdict.method


def test_the_time_is_no_variable_of_a_closed_part():
    driven = System(
        name="driven",
        fibration=Fibration((x, y)),
        lagrangian=(Dx**2 + Dy**2) / 2 + x * sp.cos(vo.time) + y * x,
        essential=(x, y, Dx, Dy),
    )
    assert status(driven, "essential") == "proved"
    apart = replace(driven, lagrangian=driven.lagrangian - y * x, essential=(x, Dx))
    assert status(apart, "essential") == "proved"
    assert status(replace(driven, essential=(x, Dx)), "essential") == "refuted"


def test_a_part_with_variables_that_relations_bind():
    """Of gamma on the sphere gamma1 alone is not closed; gamma3^2 is a function of the others."""
    assert only(top(essential=(GAMMA[0], *OMEGA)), "essential").verdict.refuted
    verdict = only(top(essential=(*GAMMA[:2], *OMEGA)), "essential").verdict
    assert verdict.undecided  # gamma3 is a function of gamma1 and gamma2 up to its sign


EULER = {
    "energy": sum(i * o**2 for i, o in zip(INERTIA, OMEGA, strict=True)),
    "momentum": sum((i * o) ** 2 for i, o in zip(INERTIA, OMEGA, strict=True)),
    "vertical": sum(i * o * g for i, o, g in zip(INERTIA, OMEGA, GAMMA, strict=True)),
}
UNIFORM = Measure(1, (*GAMMA, *OMEGA))


def test_the_theorem_of_euler_and_jacobi():
    whole = top(integrals=EULER, measure=UNIFORM, integrable="Euler-Jacobi")
    claim = only(whole, "integrable")
    assert (
        claim.verdict.proved and "3 independent integrals in 5 dimensions" in claim.verdict.method
    )


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"integrals": {k: EULER[k] for k in ("energy", "momentum")}}, "asks for 3"),
        ({"integrals": EULER | {"vertical": EULER["energy"] ** 2}}, "2 integrals are independent"),
        ({"integrals": EULER | {"vertical": OMEGA[0]}}, "asks for 3"),
        ({"measure": Measure(GAMMA[0], (*GAMMA, *OMEGA))}, "the measure is refuted"),
        ({"measure": None}, "no measure is declared"),
    ],
    ids=["too few", "dependent", "no integral", "no measure", "none declared"],
)
def test_the_theorem_needs_everything(change, expected):
    """Where its conditions are not met by what is declared, it says nothing: others may exist."""
    whole = {"integrals": EULER, "measure": UNIFORM, "integrable": "Euler-Jacobi"} | change
    verdict = only(top(**whole), "integrable").verdict
    assert verdict.undecided and expected in verdict.method


@pytest.mark.parametrize(
    ("density", "domain"),
    [
        (1, ""),
        (-2, ""),
        (Dx**2 + Dy**2, ""),
        (Dx, "xdot != 0"),
        (Dx**3 * (1 + Dy**2), "xdot != 0"),
        (1 / (Dx * Dy + Dx**2), "xdot != 0, xdot + ydot != 0"),
        (Dx**2, ""),
        (sp.Abs(Dx), ""),
        (sp.sqrt(Dx), "xdot > 0"),
        (k * Dx - 1, "k*xdot - 1 != 0"),
        # no zero of it is found: it is negative in a small disc far from where points are drawn
        (
            (Dx - 30) ** 2 + (Dx * Dy - 20) ** 2 - 1,
            "xdot**2*ydot**2 + xdot**2 - 40*xdot*ydot - 60*xdot + 1299 != 0",
        ),
    ],
)
def test_a_measure_whose_density_changes_its_sign_says_where(density, domain):
    """Where nothing acts on a point every function of its velocity is a density."""
    point = System(
        name="point",
        fibration=Fibration((x, y)),
        lagrangian=(Dx**2 + Dy**2) / 2,
        parameters=(k,),
        measure=Measure(density, (Dx, Dy)),
        integrable="Euler-Jacobi",
    )
    claims = {c.kind: c.verdict for c in vo.check_claims(point)}
    for verdict in claims.values():
        assert verdict.proved and {*verdict.domain.split(", ")} == {*domain.split(", ")}


def test_integrals_of_other_variables_do_not_count():
    part = {"measure": Measure(1, OMEGA), "integrable": "Euler-Jacobi"}
    for name, expected in (("energy", "proved"), ("vertical", "undecided")):
        system = top(integrals={name: EULER[name]}, **part)
        assert status(system, "integrable") == expected


def test_the_theorem_is_one_of_autonomous_systems():
    still = {"measure": Measure(1, (x, Dx)), "integrable": "Euler-Jacobi"}
    for force, expected in ((-x, "proved"), (sp.cos(vo.time), "undecided")):
        system = System(
            name="driven",
            fibration=Fibration(x),
            lagrangian=Dx**2 / 2,
            forces={x: force},
            **still,
        )
        assert status(system, "integrable") == expected


def test_relations_with_other_variables_bind_a_part_of_them_or_not():
    a, b = sp.symbols("a b")
    free = circle(measure=Measure(1, (v,)), integrable="Euler-Jacobi")
    assert status(free, "measure") == "proved" and status(free, "integrable") == "proved"
    system = System(
        name="point",
        fibration=Fibration((x,), (a, b), relations=(a**2 + b**2 - 1, a - 2 * b)),
        lagrangian=Dx**2 / 2,
        measure=Measure(1, (a, x, Dx)),
    )
    assert "bind those of the measure" in only(system, "measure").verdict.method


def test_a_case_has_claims_of_its_own():
    i1, i2, i3 = INERTIA
    cases = {
        "symmetric": Case({i2: i1}, integrals={"axial": OMEGA[2]}, integrable="Euler-Jacobi"),
        "wrong": Case({i3: 2 * i1}, integrals={"axial": OMEGA[2]}),
    }
    # Where all moments are equal, energy and momentum are the same and are too few.
    cases["round"] = Case({i2: i1, i3: i1}, integrable="Euler-Jacobi")
    system = top(integrals=EULER, measure=UNIFORM, cases=cases)
    found = {c.name: c.verdict.status for c in vo.check_claims(system)}
    assert found["round: Euler-Jacobi"] == "undecided"
    assert found["symmetric: axial"] == "proved" and found["wrong: axial"] == "refuted"
    assert found["symmetric: Euler-Jacobi"] == "proved"


def test_a_case_may_hold_an_input():
    free, pushed = (Case({w: push}, integrals={"speed": Dx}) for push in (0, 1))
    system = System(
        name="cart",
        fibration=Fibration((x,)),
        lagrangian=Dx**2 / 2,
        inputs=(w,),
        forces={x: w},
        scenes={"pushed": vo.Scene({}, inputs={w: 1})},
        cases={"free": free, "pushed": pushed},
    )
    found = {c.name: c.verdict.status for c in vo.check_claims(system)}
    assert found == {"free: speed": "proved", "pushed: speed": "refuted"}


def test_a_specialised_system_knows_the_parameter_no_more():
    level = specialise(skate(integrals={"energy": ENERGY, "odd": x / k}), {"k": 0})
    assert [p.name for p in level.parameters] == ["m"] and k not in level.lagrangian.free_symbols
    assert dict(level.integrals) == {"energy": ENERGY.subs(k, 0)}  # x/k has no value
    assert [c.verdict.status for c in vo.check_claims(level)] == ["proved"]
    h = sp.Symbol("h")
    slow = specialise(skate(), {k: h**2}, new=(Parameter(h, 1),))
    assert {p.name for p in slow.parameters} == {"m", "h"}
    with pytest.raises(DefinitionError, match="no parameter 'a'"):
        specialise(skate(), {"a": 1})


# What is declared undecided.


HIDDEN = sp.log(k * k) - 2 * sp.log(k)  # zero where k is positive, which is not known


def test_logarithms_of_a_positive_parameter_are_combined():
    system = skate(equations={"w": Equation(w, sp.log(m * m) - 2 * sp.log(m))})
    assert only(system, "equation").verdict.proved


def test_one_undecided_entry_leaves_an_equation_undecided():
    system = skate(equations={"w": Equation((w, phi, w), (0, w + HIDDEN, 0))})
    verdict = only(system, "equation").verdict
    assert verdict.undecided and verdict.method.startswith("entry 2")


def test_an_undecided_claim_is_admitted_and_a_decided_one_is_reported():
    system = skate(
        integrals={"energy": ENERGY, "hidden": w + x * HIDDEN},
        undecided={"hidden": "logarithms are not combined", "energy": "it is large"},
    )
    found = {c.name: c for c in vo.check_claims(system)}
    assert found["hidden"].is_admitted and not found["hidden"].stale
    assert found["hidden"].standing == "undecided: logarithms are not combined"
    assert found["energy"].stale and "out of date" in found["energy"].standing


# Declarations that make no sense.


@pytest.mark.parametrize(
    ("claims", "message"),
    [
        ({"integrable": "Liouville"}, "known theorems"),
        ({"undecided": {"enrgy": "?"}}, "which is no claim"),
        ({"essential": (v, m)}, "essential holds 'm'"),
        ({"cases": {"one": Case({"q": 1})}}, "gives a value to 'q'"),
        ({"measure": Measure(1, (v, m))}, "neither among"),
    ],
    ids=["theorem", "undecided", "essential", "case", "measure"],
)
def test_what_claims_name_exists(claims, message):
    with pytest.raises(DefinitionError, match=message):
        skate(**claims)


@pytest.mark.parametrize("table", [{(v, w): 1, (w, v): -1}, {(v, v): 0}], ids=["both", "same"])
def test_a_bracket_is_given_once_for_each_pair(table):
    with pytest.raises(DefinitionError, match="given twice"):
        Poisson({v: v, w: w}, table, v)


def test_a_measure_in_invariants_holds_no_coordinate():
    with pytest.raises(DefinitionError, match="holds 'theta'"):
        top(measure=Measure(sp.Symbol("theta"), (*GAMMA, *OMEGA)))


def test_conserved_quantities_are_written_out():
    system = top(integrals={"vertical": Corrected(GAMMA[0], GAMMA[1], "A")})
    assert system.conserved["vertical"] == system.invariants["gamma1"]


def test_one_motion_serves_several_questions():
    motions = Motions.of(top(integrals=EULER))
    assert [c.verdict.status for c in vo.check_claims(motions)] == ["proved"] * 4
    assert motions.on_invariants.dimension == 5


def test_what_divides_by_a_hidden_zero_has_no_value():
    """Inside, both are one root; what was infinite had no derivative, and so was an integral."""
    nothing = sp.Abs(v) - sp.sqrt(v**2)
    for hidden in (v / nothing, v + sp.log(nothing)):
        for kind, claims in (
            ("integral", {"integrals": {"F": hidden}}),
            ("equation", {"equations": {"F": Equation(hidden, 0)}}),
            ("measure", {"measure": Measure(hidden, (phi, v, w))}),
        ):
            verdict = only(skate(**claims), kind).verdict
            assert verdict.refuted and "has no value" in verdict.method
