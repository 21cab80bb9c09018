"""The search for first integrals: what it finds is one, what it does not find is not there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import flint
import numpy as np
import pytest
import sympy as sp
from without_claims import bare

import voronec as vo
from voronec.equations.motions import Motions
from voronec.proof.search import gradings, search, searches
from voronec.proof.search.search import SearchProblem

pytestmark = pytest.mark.slow

gamma = sp.symbols("gamma1:4")
omega = sp.symbols("omega1:4")
inertia = sp.symbols("I1:4")
m, R, R1, R2 = sp.symbols("m R R1 R2")
phi, theta, psi = sp.symbols("phi theta psi")
OMEGA3 = -(omega[0] * gamma[0] + omega[1] * gamma[1]) / gamma[2]
SPIN = sum(a * b for a, b in zip(gamma, omega, strict=True))


def free_body(**more):
    """Euler's rigid body: no constraint at all."""
    rotation = vo.kinematics.Rotation.euler("zxz", phi, theta, psi)
    kinetic = vo.kinematics.kinetic_energy(0, (0, 0, 0), inertia, rotation.body_rates)
    vertical = rotation.matrix.row(2)
    return vo.System(
        name="free-body",
        fibration=vo.Fibration((phi, theta, psi), ()),
        frame=vo.Frame.quasi(dict(zip(omega, rotation.body_rates, strict=True))),
        lagrangian=kinetic,
        parameters=inertia,
        invariants=dict(zip(map(str, gamma), vertical, strict=True)),
        **more,
    )


def same_up_to_a_factor(a, b):
    ratio = sp.cancel(a / b)
    return ratio != 0 and not ratio.free_symbols & {*gamma, *omega}


# -- what is found ------------------------------------------------------------------------


def test_chaplygins_ball_has_its_three_integrals_and_no_more() -> None:
    ball = vo.load("chaplygin-ball")
    found = vo.search_integrals(ball, again=True)
    assert len(found.new) == 3 and found.complete and found.known == ()
    assert all(f.verdict.proved for f in found.integrals)
    weighted = sp.Add(*[i * g * w for i, g, w in zip(inertia, gamma, omega, strict=True)])
    assert same_up_to_a_factor(found.integrals[0].expression, weighted)  # (G, gamma)
    rest = vo.search_integrals(ball)
    assert rest.known == ("energy", "momentum squared", "vertical momentum")
    assert rest.integrals == () and rest.complete and rest.dimension == found.dimension == 5
    assert rest.explained == 5  # 1, energy, |G|^2, (G, gamma) and its square


def test_in_momenta_the_integrals_of_the_ball_are_short() -> None:
    found = vo.search_integrals(vo.load("chaplygin-ball"), again=True, momenta=True, positions=1)
    G = sp.symbols("p_omega1:4")
    shown = {f.short for f in found.integrals}
    assert shown == {
        sp.Add(*[a * b for a, b in zip(G, gamma, strict=True)]),
        sp.Add(*[a**2 for a in G]),
    }
    assert set(found.letters) == {str(a) for a in G}


def test_what_is_found_stands_before_the_check_of_claims() -> None:
    ball = vo.load("chaplygin-ball")
    found = vo.search_integrals(ball, again=True)
    alone = bare(ball, invariants=ball.invariants)
    again = replace(alone, integrals={f.name: f.expression for f in found.integrals})
    verdicts = [c.verdict.proved for c in vo.check_claims(again) if c.kind == "integral"]
    assert verdicts == [True] * 3


def test_borisov_and_fedorovs_integral_is_found_at_epsilon_minus_one_only() -> None:
    ball = replace(vo.load("ball-on-sphere"), cases={})
    generic = vo.search_integrals(ball, degree=3, positions=4)
    assert generic.integrals == () and generic.complete and generic.dimension == 3
    special = vo.search_integrals(ball, momenta=True, positions=1, at={"R2": -2 * R1})
    (found,) = special.integrals
    D, G = m * (2 * R1) ** 2, sp.symbols("p_omega1:4")
    total = sum(inertia) + D
    parts = zip(inertia, G, gamma, strict=True)
    assert sp.expand(found.short - sum((total - 2 * i) * p * g for i, p, g in parts)) == 0
    assert found.verdict.proved and found.independent and special.complete


def test_an_integral_of_a_case_counts_as_known_where_the_case_holds() -> None:
    ball = vo.load("ball-on-sphere")
    assert vo.search_integrals(ball, degree=1, at={"R2": -2 * R1}).integrals == ()
    assert vo.search_integrals(ball, degree=1, at={"R1": -R2 / 2}).integrals == ()
    other = vo.search_integrals(ball, degree=1, at={"R2": -3 * R1})
    assert other.integrals == () and not any("Borisov" in name for name in other.known)
    displaced = vo.load("displaced-rubber-ball")
    partly = vo.search_integrals(displaced, degree=1, positions=1, at={"a1": 0})
    named = {*partly.known, *partly.ignored}
    assert "axial (symmetric)" not in named  # the case asks for I2 = I1 and a2 = 0 too


def test_the_rubber_ball_has_its_integral_at_epsilon_minus_one() -> None:
    ball = vo.load("rubber-ball-on-sphere")
    form = {
        "functions": {"omega3": OMEGA3},
        "denominators": ("mass",),
        "positions": 2,
        "again": True,
    }
    assert len(vo.search_integrals(ball, **form).integrals) == 1  # the energy
    special = vo.search_integrals(ball, at={"R2": -2 * R1}, **form)
    assert len(special.new) == 2 and special.complete
    assert special.new[1].expression.has(gamma[0]) and special.new[1].verdict.proved
    declared = vo.search_integrals(vo.load("rubber-ball-eps-minus-one"), **{**form, "again": False})
    assert declared.integrals == () and declared.dimension == special.dimension


def test_the_displaced_rubber_ball_has_two_integrals() -> None:
    ball = vo.load("displaced-rubber-ball")
    at = {"m": 1, "R": 1, "a1": 0, "a2": 0}
    found = vo.search_integrals(ball, functions={"omega3": OMEGA3}, at=at, positions=2, again=True)
    assert len(found.new) == 2 and found.complete
    known = vo.search_integrals(ball, functions={"omega3": OMEGA3}, at=at, positions=2)
    assert known.integrals == () and "momentum across the normal" in known.known


@pytest.mark.parametrize(
    "name", ["symmetric-ball-on-sphere", "symmetric-gyroscopic-ball-on-sphere"]
)
def test_the_symmetric_ball_has_integrals_with_transcendental_coefficients(name: str) -> None:
    A, C, c, mu = sp.symbols("A C c mu")
    D = c**2 * A * C / (C - A - c**2 * A)  # so that c is the root in the exponent
    at = {"R2": (mu - 1) * R1, "m": D / ((mu - 1) * R1) ** 2}
    letters = {
        "growth": sp.exp(mu * sp.asinh(c * gamma[2])),
        "root": sp.sqrt(1 + c**2 * gamma[2] ** 2),
        "spin": SPIN,
    }
    ball = replace(vo.load(name), cases={})
    found = vo.search_integrals(ball, degree=1, positions=2, functions=letters, at=at)
    (new,) = found.integrals
    assert new.verdict.proved and new.expression.has(sp.exp) and found.complete
    falling = {**letters, "growth": 1 / letters["growth"]}
    (other,) = vo.search_integrals(ball, degree=1, positions=2, functions=falling, at=at).integrals
    assert other.verdict.proved and other.expression != new.expression
    none = vo.search_integrals(ball, degree=1, positions=2, functions={"spin": SPIN}, at=at)
    assert none.integrals == ()


def test_special_parameters_allow_more() -> None:
    body = free_body()
    assert [str(f.short) for f in vo.search_integrals(body, degree=1).integrals] == [
        "I1*gamma1*omega1 + I2*gamma2*omega2 + I3*gamma3*omega3"
    ]
    special = vo.search_integrals(body, degree=1, at={"I2": inertia[0]})
    assert omega[2] in {f.expression for f in special.integrals}
    assert "I2 = I1" in special.statement and "I2" not in special.statement.split("generic")[1]


def test_coordinates_under_sines_are_searched_by_sine_and_cosine() -> None:
    sleigh = vo.load("sleigh")
    found = vo.search_integrals(sleigh, again=True, positions=1)
    v, w, J, a = sp.symbols("v w J a")
    assert [sp.expand(f.expression) for f in found.integrals] == [
        sp.expand(m * v**2 + (J + m * a**2) * w**2)
    ]
    assert "cos(phi), sin(phi)" in found.form


@pytest.mark.parametrize("part", [1, 2, sp.Rational(3, 2)])
def test_angles_in_sums_and_in_parts_are_searched_by_sine_and_cosine(part: sp.Expr) -> None:
    """Letters were the bare angles where these stand under a cosine in sums or fractions alone."""
    a, b = sp.symbols("a b")
    da, db = vo.velocity(a), vo.velocity(b)
    links = vo.System(
        name="links", fibration=vo.Fibration((a, b)),
        lagrangian=da**2 + db**2 / 2 + da * db * sp.cos((a - b) / part),
    )  # fmt: skip
    found = vo.search_integrals(links, degree=2, positions=4)
    assert len(found.new) == 2 and found.complete


@pytest.mark.parametrize("pull", [sp.cos, lambda a: sp.cos(a / 2) ** 2, lambda a: 1])
def test_an_angle_that_forces_turn_on_is_a_letter(pull: Any) -> None:
    """The work of a torque, constant or in the mean, is no function of sine and cosine."""
    a, torque = sp.symbols("a torque")
    da = vo.velocity(a)
    wheel = vo.System(
        name="wheel", fibration=vo.Fibration(a), lagrangian=da**2 / 2 + sp.sin(a),
        forces={a: torque * pull(a)}, parameters=(torque,),
    )  # fmt: skip
    found = vo.search_integrals(wheel)
    assert len(found.new) == 1
    assert (a in found.new[0].expression.free_symbols) and ("sin" in found.form)
    assert found.form.endswith(", a") is (pull is not sp.cos)


def test_a_letter_that_holds_the_time_is_not_called_a_constant() -> None:
    letter = {"decay": sp.exp(-2 * vo.time)}
    with pytest.raises(vo.DefinitionError, match="'decay' holds the time, and no state"):
        vo.search_integrals(free_body(), functions=letter)


def test_an_integral_that_is_a_function_of_others_is_told() -> None:
    body = free_body(
        integrals={
            "square": (sum(i * g * w for i, g, w in zip(inertia, gamma, omega, strict=True))) ** 2
        }
    )
    found = vo.search_integrals(body, degree=1)
    assert [f.independent for f in found.integrals] == [False] and found.new == ()


def test_a_declared_function_that_is_no_integral_does_not_count() -> None:
    found = vo.search_integrals(free_body(integrals={"false": omega[0]}), degree=1)
    assert found.known == () and found.ignored == ("false",) and len(found.integrals) == 1


def test_a_declared_integral_in_coordinates_is_brought_down_to_the_invariants() -> None:
    disc = vo.search_integrals(vo.load("falling-disc"), positions=1)
    assert disc.level == "invariants" and disc.known == ("energy",) and disc.integrals == ()
    ball = vo.search_integrals(vo.load("demchenko"), degree=1, positions=1)
    assert ball.known == ("energy", "axial") and ball.integrals == ()
    assert ball.ignored == ("momentum x", "momentum y", "momentum z")  # in space


def test_a_declared_integral_that_holds_the_time_is_not_used() -> None:
    x = sp.Symbol("x")
    particle = vo.System(
        name="particle",
        fibration=vo.Fibration((x,)),
        lagrangian=vo.velocity(x) ** 2 / 2,
        integrals={"start": x - vo.time * vo.velocity(x)},
    )
    found = vo.search_integrals(particle, degree=1, positions=1)
    assert found.ignored == ("start",) and [f.short for f in found.new] == [vo.velocity(x)]


def test_large_numbers_in_an_integral_are_recovered() -> None:
    big = [sp.Rational(1234567891011, 37), sp.Integer(98765432101234), sp.Rational(7, 10**12 + 39)]
    at = dict(zip(map(str, inertia), big, strict=True))
    found = vo.search_integrals(free_body(), degree=1, at=at)
    expected = sp.Add(*[b * g * w for b, g, w in zip(big, gamma, omega, strict=True)])
    assert same_up_to_a_factor(found.integrals[0].expression, expected)


# -- what is not there: another route -----------------------------------------------------


def by_brute_force(system, degree, positions, values):
    """The dimension of the space of integrals, over Q: every coefficient of the rate, multiplied
    by the determinant of the mass, on the unit sphere of gamma."""
    field = Motions.of(system).on_invariants
    out = field.bridge.outward
    mass = sp.Matrix([[out(e) for e in row] for row in field.mass]).subs(values)
    force = sp.Matrix([out(f) for f in field.force]).subs(values)
    rates = [out(r).subs(values) for r in field.rates]
    det = sp.expand(mass.det())
    pushed = mass.adjugate() * force
    state = (*gamma, *omega)
    field_times_det = [*(det * r for r in rates), *pushed]
    monomials = [
        sp.prod(x**e for x, e in zip(state, exponents, strict=True))
        for exponents in np.ndindex(*[positions + 1] * 2, 2, *[degree + 1] * 3)
        if sum(exponents[:3]) <= positions and sum(exponents[3:]) <= degree
    ]  # gamma3 at most once: a basis on the sphere
    sphere = sp.Poly(
        gamma[2] ** 2 + gamma[0] ** 2 + gamma[1] ** 2 - 1, gamma[2], *gamma[:2], *omega
    )
    columns = []
    for monomial in monomials:
        rate = sum(monomial.diff(x) * f for x, f in zip(state, field_times_det, strict=True))
        columns.append(sp.Poly(rate, *sphere.gens).rem(sphere).as_dict())
    rows = sorted({key for column in columns for key in column})
    if not rows:
        return len(monomials)
    table = [
        [flint.fmpq(int(c.get(r, sp.S.Zero).p), int(c.get(r, sp.S.Zero).q)) for c in columns]
        for r in rows
    ]
    return len(monomials) - flint.fmpq_mat(table).rank()


VALUES = {"I1": sp.Rational(3, 7), "I2": 2, "I3": sp.Rational(11, 5)}


SPECIAL = {
    "free": (free_body(), VALUES),
    "symmetric": (free_body(), {**VALUES, "I2": sp.Rational(3, 7)}),
    "spherical": (free_body(), dict.fromkeys(("I1", "I2", "I3"), sp.Integer(2))),
    "ball": (vo.load("chaplygin-ball"), {**VALUES, "m": 1, "R": 2}),
}


@pytest.mark.parametrize(
    ("name", "degree", "positions"),
    [
        *((name, *degrees) for name in SPECIAL for degrees in ((1, 2), (2, 1))),
        *((name, 2, 2) for name in ("free", "symmetric", "spherical")),
    ],
)
def test_the_dimension_is_that_of_brute_force(name: str, degree: int, positions: int) -> None:
    system, at = SPECIAL[name]
    found = vo.search_integrals(system, degree=degree, positions=positions, at=at)
    symbols = {sp.Symbol(k): v for k, v in at.items()}
    assert found.dimension == by_brute_force(system, degree, positions, symbols)
    assert found.complete


@pytest.mark.parametrize("name", ["chaplygin-ball", "demchenko", "falling-disc", "vertical-disc"])
def test_classes_do_not_change_the_result(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    options = {"degree": 2, "positions": 2, "again": True}
    apart = vo.search_integrals(vo.load(name), **options)
    monkeypatch.setattr(gradings.Gradings, "classes", lambda self, rows: [(0,)] * len(rows))
    together = vo.search_integrals(vo.load(name), **options)
    assert apart.classes > 1 and together.classes == 1
    assert apart.dimension == together.dimension
    assert len(apart.new) == len(together.new)


def test_a_ball_has_one_scaling_and_four_changes_of_sign_that_a_gyroscope_breaks() -> None:
    field = Motions.of(vo.load("chaplygin-ball")).on_invariants
    found = gradings.Gradings(field, field.variables).classes(np.eye(6, dtype=np.int64))
    assert len(set(found)) == 6 and {len(c) for c in found} == {1 + 4}
    broken = Motions.of(vo.load("gyroscopic-ball-on-plane")).on_invariants
    classes = gradings.Gradings(broken, broken.variables).classes(np.eye(6, dtype=np.int64))
    (normal,), (spin,) = {*classes[:3]}, {*classes[3:]}  # only gamma -> -gamma is left
    assert len(normal) == 1 and normal != spin


def test_a_function_and_the_root_in_its_slope_change_sign_together() -> None:
    # d/dt exp(asinh(x)) holds sqrt(1 + x^2): no symmetry turns the one without the other.
    x, y = sp.symbols("x y")
    system = vo.System(
        name="two-points", fibration=vo.Fibration((x, y)),
        lagrangian=(vo.velocity(x) ** 2 / (1 + x**2) + vo.velocity(y) ** 2) / 2,
    )  # fmt: skip
    letters = {
        "e": sp.exp(sp.asinh(x)),
        "r": sp.sqrt(1 + x**2),
        "speed": vo.velocity(x) / sp.sqrt(1 + x**2),
    }
    found = vo.search_integrals(system, degree=1, positions=1, functions=letters)
    assert sp.Symbol("speed") in {f.short for f in found.integrals}
    question = SearchProblem.about(system, 1, 1, (), 1, letters, False, {}, False)
    grading = gradings.Gradings(question.field, [a.value for a in question.ansatz.letters])
    names = [str(a.name) for a in question.ansatz.letters]
    rows = np.eye(len(names), dtype=np.int64)
    assert grading.classes(rows)[names.index("r")] == grading.classes(rows)[names.index("e")]


# -- what is said -------------------------------------------------------------------------


def test_the_statement_says_for_which_parameters_it_holds() -> None:
    said = vo.search_integrals(vo.load("chaplygin-ball"), degree=1, positions=1).statement
    assert "for generic m, R, I1, I2, I3" in said and "may allow more" in said
    numbers = {"m": 1, "R": 1, "I1": 2, "I2": 3, "I3": 4}
    found = vo.search_integrals(vo.load("chaplygin-ball"), degree=1, positions=0, at=numbers)
    assert found.statement.startswith("No first integral but constants") and found.parameters == ()
    assert "generic" not in found.statement and "may allow" not in found.statement


def test_an_integral_that_is_not_lifted_is_counted_and_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_):
        raise vo.EngineLimit("too large")

    monkeypatch.setattr(search, "coefficients", refuse)
    found = vo.search_integrals(free_body(), degree=1)
    assert found.integrals == () and found.missing == 1 and not found.complete
    assert "of dimension at most 2" in found.statement


def test_every_step_tells_what_is_known_so_far() -> None:
    steps = list(searches(free_body(), degree=1, positions=1))
    assert not steps[0].finished and not steps[0].complete and "stopped" in steps[0].statement
    assert steps[-1].finished and steps[-1].examined == steps[-1].monomials
    lines = []
    vo.search_integrals(free_body(), degree=1, positions=1, progress=lines.append)
    assert len(lines) == len(steps) and "1 found" in lines[-1]


def test_the_outcome_goes_into_json() -> None:
    data = vo.search_integrals(free_body(), degree=1).as_dict()
    assert data["complete"] and data["integrals"][0]["verdict"] == "proved"
    assert data["dimension"] == 2 and data["at"] == {}


# -- measures, multipliers, symmetries, gauge momenta -----------------------------------------

w, Y, g, I13, I23, c = sp.symbols("w Y g I13 I23 c")
MEASURES = {
    "sleigh": 1 / w,
    "growing-sleigh": (1 + g * vo.time) / w,
    "suslov": 1 / (I13 * omega[0] + I23 * omega[1]),
    "nonholonomic-particle": sp.sqrt(1 + Y**2),
}


def damped_mass() -> vo.System:
    """A mass whose resistance grows with its velocity: density exp(c x)."""
    x = sp.Symbol("x")
    v = vo.velocity(x)
    return vo.System(
        name="damped-mass",
        fibration=vo.Fibration((x,), ()),
        lagrangian=v**2 / 2 - x**2 / 2,
        forces={x: -c * v**2 / 2},
        parameters=(c,),
    )


@pytest.mark.parametrize("name", MEASURES)
def test_a_declared_measure_is_found_untold(name: str) -> None:
    found = vo.search_measures(replace(vo.load(name), measure=None)).found
    assert found is not None and found.verdict.proved
    assert sp.cancel((found.expression / MEASURES[name]) ** 2).is_Rational


def test_a_density_may_be_an_exponential_or_have_powers_that_are_functions_of_parameters() -> None:
    found = vo.search_measures(damped_mass()).found
    assert found is not None and found.verdict.proved
    assert found.expression == sp.exp(c * sp.Symbol("x"))
    numbers = {"I1": 1, "I2": 2, "I3": 2, "m": 1}
    ball = vo.search_measures(vo.load("rubber-ball-on-sphere"), at=numbers).found
    assert ball is not None and ball.verdict.proved
    powers = [sp.cancel(p.exp) for p in ball.expression.atoms(sp.Pow)]
    assert sp.cancel((R1 + R2) / (2 * R1)) in powers


def test_a_measure_of_another_form_is_not_found_and_the_form_is_told() -> None:
    result = vo.search_measures(vo.load("robot-with-two-trailers"))
    assert result.found is None and not result.is_decided
    assert result.statement.endswith("a product of powers of these factors was not found.")


@pytest.mark.parametrize("name", ["veselova", "nonholonomic-particle", "vertical-disc"])
def test_a_declared_multiplier_is_found_untold(name: str) -> None:
    system = vo.load(name)
    found = vo.search_reducing_multipliers(replace(system, multiplier=None)).found
    assert found is not None and found.verdict.proved
    ratio = found.expression / system.multiplier
    cosines = {gamma[i]: e for i, e in enumerate(system.invariants.values())}
    points = [{s: sp.Rational(k + j, 9) for k, s in enumerate([phi, theta, psi])} for j in (1, 4)]
    moments = {s: k + 2 for k, s in enumerate(sp.symbols("J1:4"))}
    values = [ratio.xreplace(cosines).xreplace(moments).evalf(30, subs=p) for p in points]
    assert abs(values[0] - values[1]) < 1e-25 if ratio.free_symbols else ratio == 1


def test_a_multiplier_of_a_case_in_four_dimensions_is_found_without_the_determinants_name() -> None:
    system = vo.load("veselova-in-rn")
    found = vo.search_reducing_multipliers(system, at=system.cases["J = a a"].parameters).found
    assert found is not None and found.verdict.proved


def test_a_multiplier_that_is_not_there_is_excluded() -> None:
    result = vo.search_reducing_multipliers(vo.load("falling-disc"))
    assert result.found is None and result.excluded and "proved not to exist" in result.statement


def test_the_sleigh_has_the_symmetries_of_the_plane_and_its_reversors() -> None:
    result = vo.search_symmetries(vo.load("sleigh"))
    x, y, v = sp.symbols("x y v")
    assert result.is_decided and (result.symmetries, result.reversors) == (4, 4)
    fields = [f.components for f in result.fields]
    assert {x: 1} in fields and {y: 1} in fields and {x: -y, phi: 1, y: x} in fields
    assert any(f.clock != 0 and f.components.keys() == {v, w} for f in result.fields)  # a scaling
    images = [m.images for m in result.maps if not m.reverses]
    assert {y: -y, phi: -phi, w: -w} in images and {x: -x, phi: sp.pi - phi, w: -w} in images


def test_equal_moments_bring_a_rotation_and_a_gyroscope_takes_scaling_away() -> None:
    ball = vo.load("chaplygin-ball")
    plain = vo.search_symmetries(ball)
    round_ball = vo.search_symmetries(ball, at={"I2": inertia[0]})
    assert len(plain.fields) == 1 and len(round_ball.fields) == 2 and round_ball.is_decided
    turned = {gamma[0]: -gamma[1], gamma[1]: gamma[0], omega[0]: -omega[1], omega[1]: omega[0]}
    assert turned in [f.components for f in round_ball.fields]
    assert round_ball.symmetries == 2 * plain.symmetries  # the axes may be exchanged
    wheel = vo.search_symmetries(vo.load("gyroscopic-ball-on-plane"))
    assert wheel.fields == () and (wheel.symmetries, wheel.reversors) == (2, 0)  # gamma -> -gamma


def test_integrals_of_the_sleigh_are_gauge_momenta() -> None:
    sleigh = vo.load("sleigh")
    at = sleigh.cases["centre of mass over the blade"].parameters
    result = vo.search_gauge_momenta(sleigh, positions=1, at=at)
    kinds = {m.expression: m for m in result.momenta}
    v, x, y = sp.symbols("v x y")
    assert kinds[w].kind == "momentum of a horizontal symmetry"
    assert kinds[v].kind == "gauge momentum" and result.is_decided
    assert kinds[v].generator == {x: sp.cos(phi) / m, y: sp.sin(phi) / m}
    along = {
        q: sum(f * result.symmetries[name].get(q, 0) for name, f in kinds[v].coefficients.items())
        for q in (x, y, phi)
    }
    assert along == {**kinds[v].generator, phi: 0}
    with pytest.raises(vo.DefinitionError, match="'bent' is not proved to leave the Lagrangian"):
        vo.search_gauge_momenta(sleigh, fields={"bent": {"x": x}})
    with pytest.raises(vo.DefinitionError, match="'v' is no integral"):
        vo.search_gauge_momenta(sleigh, integrals=["v"])


# -- the rank test -------------------------------------------------------------------------

UNTOLD = replace(
    vo.load("chaplygin-ball"),
    integrals={k: vo.load("chaplygin-ball").integrals[k] for k in ("energy", "momentum squared")},
)
WHEEL = {f"kappa{i}": sp.Rational(i, 7) for i in (1, 2, 3)}
STILL = dict.fromkeys(WHEEL, 0)


def test_the_gyroscopic_ball_has_an_excess_where_an_integral_is_known_and_only_there() -> None:
    ball, inside = vo.load("gyroscopic-ball-on-sphere"), {"R1": sp.Rational(-1, 2)}  # epsilon = -1
    assert vo.exclude_rational_integrals(ball, 4).is_decided
    assert vo.exclude_rational_integrals(ball, 4, at=inside | WHEEL).is_decided
    assert vo.exclude_rational_integrals(ball, 4, at={"R1": -3} | STILL).is_decided
    assert vo.exclude_rational_integrals(ball, 4, at=inside | STILL).excess > 0  # Borisov-Fedorov
    assert vo.exclude_rational_integrals(UNTOLD, 2).excess > 0  # (G, gamma) is not told


def test_no_excess_is_no_proof_that_a_ball_is_not_integrable() -> None:
    result = vo.exclude_rational_integrals(vo.load("symmetric-gyroscopic-ball-on-sphere"), 4)
    assert result.is_decided  # integrals with powers of functions of gamma3 are there
    assert result.statement.startswith("No further rational integral of degree at most 4 in gamma1")


def test_no_excess_is_reported_below_an_integral_that_is_shown() -> None:
    """F G^-1 of polynomials too: an excess begins at the larger of their degrees, not before."""
    free = free_body()
    moments = dict(zip(inertia, (2, 3, 5), strict=True))
    told = replace(
        free, integrals={"energy": sum(i * v**2 for i, v in zip(inertia, omega, strict=True))}
    )
    assert vo.exclude_rational_integrals(free, 1, at=moments).is_decided
    assert vo.exclude_rational_integrals(free, 2, at=moments).excess >= 3
    one, two = (vo.exclude_rational_integrals(s, 2, at=moments).excess for s in (told, free))
    assert one == two - 1


def test_values_that_no_body_has_are_called_formal() -> None:
    result = vo.exclude_rational_integrals(UNTOLD, 1, at={"I1": 9}, body=("I2 + I3 - I1",))
    assert result.formal == ("-I1 + I2 + I3 >= 0",) and "formal: no body" in result.statement
    assert vo.exclude_rational_integrals(UNTOLD, 1, body=("I2 + I3 - I1",)).formal == ()


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("chaplygin-ball", {"degree": 80}, "GiB of memory, of"),
        (
            "chaplygin-ball",
            {"at": {"I1": sp.sqrt(2)}},
            "'I1' is sqrt\\(2\\); give it a rational number",
        ),
        ("chaplygin-ball", {"degree": 0}, "degree is 0; give a number from 1 upward"),
        ("sleigh-in-time", {}, "equations that hold the time have no rank test"),
        ("rubber-ball-in-new-time", {}, "the rank test takes rational ones"),
    ],
)
def test_what_has_no_rank_test_is_refused_in_a_line(name, options, words) -> None:
    with pytest.raises((vo.EngineLimit, vo.DefinitionError), match=words) as error:
        vo.exclude_rational_integrals(vo.load(name), **options)
    assert "\n" not in str(error.value)


# -- what is refused ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"degree": -1}, "degree is -1; give a number"),
        ({"positions": True}, "positions is True; give a number"),
        ({"at": {"I4": 1}}, "no parameter 'I4'; did you mean"),
        ({"at": {"I1": inertia[1], "I2": 1}}, "holds a parameter that has a value itself"),
        ({"functions": {"f": sp.Symbol("gama1")}}, "no symbol 'gama1'; did you mean 'gamma1'"),
        ({"functions": {"I1": gamma[0] ** 2}}, "the name 'I1' is taken"),
        ({"functions": {"one": inertia[0]}}, "the function 'one' is a constant"),
        ({"functions": {"G": None}}, "declares no equation 'G'"),
        ({"denominators": (inertia[0],)}, "is a constant; leave it out"),
    ],
)  # fmt: skip
def test_a_wrong_question_is_refused_in_a_line(options, words) -> None:
    with pytest.raises(vo.DefinitionError) as error:
        vo.search_integrals(free_body(), **options)
    assert words in str(error.value)


def test_parameters_at_which_there_are_no_equations_are_refused() -> None:
    with pytest.raises(vo.DefinitionError, match="no value at R1 = -R2"):
        vo.search_integrals(vo.load("ball-on-sphere"), at={"R1": -R2})


def test_an_ansatz_beyond_the_limit_is_refused_with_its_size() -> None:
    with pytest.raises(vo.EngineLimit, match="more than the limit 10; lower a degree"):
        vo.search_integrals(vo.load("chaplygin-ball"), limit=10)
    with pytest.raises(vo.EngineLimit, match="monomials; lower a degree"):
        vo.search_integrals(vo.load("chaplygin-ball"), degree=30, positions=30)
