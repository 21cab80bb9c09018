"""Families of systems: what their constructors declare of a body that is not in the catalogue."""

from __future__ import annotations

import pytest
import sympy as sp

import voronec as vo
from voronec import DefinitionError, Limit, Parameter, Relation, Square
from voronec.kinematics import (
    BalancedBall,
    BallMotion,
    BallOnMovingSphere,
    BodyInRn,
    BodyOfRevolution,
    RollingContact,
    RollingEllipsoid,
    Sleigh,
    Surface,
    SurfaceForms,
    TorusOnEllipsoid,
)
from voronec.kinematics.carried_contact import form_values

pytestmark = pytest.mark.slow

r, b, M, A, C, k = sp.symbols("r b M A C k")
moments = sp.symbols("P1:4")
TABLE = {r: 3, b: 1, M: 2, moments: ("0.5", "0.6", "0.8"), k: "0.25"}


def ball(**more):
    own = BalancedBall.on_sphere(r, b, M, moments, (0, 0, k))
    return own.system(name="own-ball", values={**TABLE, **more.pop("values", {})}, **more)


def test_a_ball_of_ones_own_has_the_claims_of_its_family():
    """With its own letters; the claims are proved from its Lagrangian."""
    verdicts = {c.name: c.verdict for c in vo.check_claims(ball())}
    assert {"momentum", "normal", "energy", "momentum squared"} <= {*verdicts}
    assert all(verdict.proved for verdict in verdicts.values())


@pytest.mark.parametrize("turning", [{"rate": 1 / C}, {"moment": A}], ids=["kept turning", "free"])
def test_a_ball_on_a_moving_sphere_has_the_claims_of_its_family(turning):
    """With its own letters, proved from its Lagrangian; over a sphere at rest G is another."""
    own = BallOnMovingSphere(r, b, M, moments, (0, 0, k), **turning)
    rest = own.momentum.xreplace(dict.fromkeys(own.swirl, 0)) + sp.Matrix(own.rotor)
    claims = {"momentum squared": own.whole.dot(own.whole), "at rest": rest.dot(rest)}
    values = {**TABLE, **{s: 2 for value in turning.values() for s in value.free_symbols}}
    values = {s: vo.Parameter(s, v) if s == C else v for s, v in values.items()}
    system = own.system(name="own-ball", values=values, integrals=claims)
    verdicts = {c.name: c.verdict for c in vo.check_claims(system)}
    assert {"momentum", "normal", "momentum squared", "at rest"} <= {*verdicts}
    assert [name for name, verdict in verdicts.items() if not verdict.proved] == ["at rest"]
    assert verdicts["at rest"].refuted


@pytest.mark.parametrize("turning", [{}, {"rate": 1, "moment": 1}])
def test_a_moving_sphere_is_kept_turning_or_free(turning):
    with pytest.raises(DefinitionError, match=r"give rate=\.\.\. or moment="):
        BallOnMovingSphere(r, b, M, moments, **turning)
    with pytest.raises(DefinitionError, match="the moment of a sphere"):
        BallOnMovingSphere(r, b, M, moments, moment=object())


def test_a_sleigh_of_ones_own_turns_as_its_integrals_say():
    """With its own letters, proved from its Lagrangian; a blade elsewhere would not turn so."""
    sleigh = Sleigh(M, A, b)
    claims = {"energy": sleigh.kinetic, "heading": sleigh.heading_integral}
    own = sleigh.system(name="own-sleigh", values={M: 1, A: 2, b: "0.5"}, integrals=claims)
    assert all(c.verdict.proved for c in vo.check_claims(own))
    false = {"heading": Sleigh(M, A, 2 * b).heading_integral}
    wrong = sleigh.system(name="own-sleigh", values={M: 1, A: 2, b: "0.5"}, integrals=false)
    verdicts = {c.name: c.verdict.status for c in vo.check_claims(wrong)}
    assert verdicts["heading"] == "refuted"


@pytest.mark.parametrize("wrong", [None, 1, "m", [M], object()])
def test_values_and_integrals_are_mappings(wrong):
    with pytest.raises(DefinitionError, match=r"values = .* is not a mapping"):
        Sleigh(M, A, b).system(name="own", values=wrong)
    with pytest.raises(DefinitionError, match="integrals"):
        Sleigh(M, A, b).system(name="own", values={M: 1, A: 2, b: 3}, integrals=wrong)


def test_a_sleigh_says_what_its_mass_may_be():
    with pytest.raises(DefinitionError, match="the mass of a sleigh"):
        Sleigh(object(), A, b)


def test_constants_come_in_the_order_of_the_table_with_their_words():
    rows = [(p.name, p.value, p.positive, p.meaning) for p in ball().parameters]
    assert rows[:3] == [
        ("r", 3, False, "radius of the fixed sphere, signed"),
        ("b", 1, True, "radius of the ball"),
        ("M", 2, True, "mass of ball and rotor"),
    ]
    assert rows[3] == ("P1", sp.Rational(1, 2), True, "principal moment")
    assert rows[-1] == ("k", sp.Rational(1, 4), False, "axial momentum of the gyroscope")


def test_what_is_declared_beside_joins_what_the_ball_has():
    """Entries are added, those of the same name replaced; a further constant says its words."""
    c = sp.Symbol("c")
    own = ball(
        integrals={"energy": sp.Integer(1), "more": c},
        values={c: Parameter(c, 5, meaning="of mine")},
        drawing=None,
    )
    assert list(own.integrals) == ["energy", "momentum squared", "more"]
    assert own.integrals["energy"] == 1
    assert own.parameters[-1].meaning == "of mine"
    assert own.drawing is None


def test_a_constant_that_the_body_does_not_have_is_refused():
    with pytest.raises(DefinitionError, match="'A' is no constant of this body; it has r, b, M"):
        ball(values={A: 1})
    with pytest.raises(DefinitionError, match=r"P1, P2, P3.* 2 values"):
        ball(values={moments: (1, 2)})


def test_the_density_of_a_spherical_ball_is_constant_and_of_no_other():
    assert BallMotion((A, A, A), M * b**2).density == 1
    assert BallMotion((A, A, C), M * b**2).density != 1


def test_one_parameter_for_each_symbol():
    x, y = Parameter.each((A, C), ("0.5", 2), positive=True, meaning="moment")
    assert x == Parameter(A, sp.Rational(1, 2), positive=True, meaning="moment")
    assert (y.symbol, y.value) == (C, 2)
    with pytest.raises(DefinitionError, match="3 values are given for 2 parameters"):
        Parameter.each((A, C), (1, 2, 3))


def test_parameters_keep_their_names_but_for_those_changed():
    """Neither one that occurs in a changed one goes over by its name, nor one that moves."""
    h, source = sp.Symbol("h"), ball()
    own = Relation.of(source, "wide", {"R": b, "J": k + 1}, limit=Limit(h, {r: 1 / h}))
    assert own.parameters == {"R": b, "J": k + 1, "M": M, **{str(p): p for p in moments}}
    assert (own.source, own.target) == ("own-ball", "wide")
    assert Relation.of(source, "same").parameters == {p.name: p.symbol for p in source.parameters}


def test_a_usual_limit_is_named_by_what_moves():
    """To zero as h p, to infinity as 1/h, with a small parameter whose letter the system lacks."""
    h, h0, source = *sp.symbols("h h0"), ball()
    both = Relation.of(source, "flat", vanish=moments, grow=r)
    assert both.limit == Limit(h, {**{p: h * p for p in moments}, r: 1 / h})
    assert {*both.parameters} == {"b", "M", "k"}
    heavy = BalancedBall.on_plane(b, h, moments).system(
        name="heavy", values={b: 1, h: 2, moments: (1, 2, 2)}
    )
    assert Relation.of(heavy, "light", vanish="h").limit == Limit(h0, {h: h * h0})


@pytest.mark.parametrize(
    ("moves", "words"),
    [
        ({"grow": "P4"}, "'P4' vanishes or grows, but is no parameter of 'own-ball'; did you mean"),
        ({"vanish": (k, k)}, "'k' moves in two ways"),
        ({"vanish": k, "grow": k}, "'k' moves in two ways"),
        ({"grow": r, "limit": Limit("h", {r: "1/h"})}, "'r' moves in two ways"),
        ({"vanish": {k}}, "vanish = .* is not a tuple; write vanish=.parameter, ...."),
    ],
)
def test_a_usual_limit_moves_each_parameter_once(moves, words):
    with pytest.raises(DefinitionError, match=words):
        Relation.of(ball(), "flat", **moves)


def test_a_relation_into_a_system_keeps_what_is_not_changed():
    """On its invariants, on its coordinates where one of them is given, or without a state."""
    own, kept = ball(), {str(p): p for p in moments} | {"b": b, "M": M}
    w1, w2, w3, g1 = sp.symbols("omega1:4 gamma1")
    names = {f"{letter}{i}" for letter in ("omega", "gamma") for i in "123"}
    mirror = Relation.into(own, "own-ball", {g1: -g1, "omega2": -w2, k: -k}, name="mirror")
    assert {*mirror.state} == names
    assert mirror.state["gamma1"] == -g1
    assert (mirror.state["omega1"], mirror.state["omega2"]) == (w1, -w2)
    assert mirror.parameters == {**kept, "r": r, "k": -k}
    assert (mirror.source, mirror.target, mirror.name) == ("own-ball", "own-ball", "mirror")
    assert Relation.into(own, "still", {k: 0}).state is None

    v1 = own.coordinates[-1]
    placed = {str(q): q for q in own.coordinates}
    turn = Relation.into(own, "own-ball", {v1: v1 + 1, sp.Symbol("t"): vo.time})
    assert turn.state == {**placed, "v1": v1 + 1, "t": vo.time}
    whole = Relation.into(own, "own-ball", {v1: v1 + 1, w3: -w3})
    assert whole.state == {**placed, "v1": v1 + 1, "omega1": w1, "omega2": w2, "omega3": -w3}


def test_a_relation_into_a_system_is_decided_and_names_what_is_unknown():
    """With the time run back, the momentum of the gyroscope turned: proved; not turned: refuted."""
    own = ball()
    back = {f"omega{i}": -sp.Symbol(f"omega{i}") for i in "123"}
    for turned, status in (({k: -k}, "proved"), ({}, "refuted")):
        reversed_ = Relation.into(own, "own-ball", {**back, **turned}, clock=-1, name="back")
        assert vo.check_relation(reversed_, systems=(own,)).verdict.status == status
    with pytest.raises(DefinitionError, match="maps 'omega4', which 'own-ball' does not have"):
        vo.check_relation(Relation.into(own, "own-ball", {**back, "omega4": 0}), systems=(own,))


def test_squares_through_systems_pass_the_relations_between_neighbours():
    own = Square.through(("a", "b", "d"), ("a", "c", "d"), name="both ways")
    assert own == Square(("a -> b", "b -> d"), ("a -> c", "c -> d"), name="both ways")


@pytest.mark.parametrize(
    ("axes", "body", "rotor", "known"),
    [
        ((r, r, b), (A, A, C), (0, 0, k), True),
        ((r, r, b), (A, A, C), (k, 0, 0), False),
        ((r, r, b), moments, (0, 0, 0), False),
        ((r, M, b), (A, A, C), (0, 0, 0), False),
    ],
)
def test_an_ellipsoid_has_a_measure_where_body_and_gyroscope_have_an_axis(axes, body, rotor, known):
    mass, weight = sp.symbols("mass weight")
    names = {*axes, *body, *rotor, mass, weight} - {0}
    own = RollingEllipsoid.on_plane(axes, mass, body).system(
        name="own", rotor=rotor, gravity=weight, values=dict.fromkeys(sorted(names, key=str), 1)
    )
    assert (own.measure is not None) == known
    assert own.integrals["energy"].has(weight)


def test_a_surface_that_is_explicit_and_its_forms_give_the_same_functions():
    """A torus on a sphere, whose radii of curvature are known: b and r + b sin(u) over sin(u)."""
    u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
    fixed = Surface.sphere(M, u1, v1)
    forms = SurfaceForms.revolution(u, v, (b, (r + b * sp.sin(u)) / sp.sin(u)))
    explicit, known = (
        BodyOfRevolution(RollingContact(body, fixed, theta), 1, A, C).contact
        for body in (Surface.torus(r, b, u, v), forms)
    )
    state, functions = BodyOfRevolution(explicit, 1, A, C).as_any_body
    other = form_values(known)
    assert functions.keys() == other.keys() and functions["k_u1"] == 1 / M
    for name, value in functions.items():
        assert vo.prove_equal(value, other[name]).proved, name
    assert state["r3"] == b * sp.cos(u)


def test_the_ellipsoid_below_a_torus_is_one():
    """Its curvatures, by w, are those of x^2/r^2 + y^2/r^2 + z^2/b^2 = 1 by its normal."""
    torus = TorusOnEllipsoid((M, M), (r, b), 1, (A, C)).body.contact
    u1, v1 = torus.fixed.coordinates
    root = sp.sqrt(sp.sin(u1) ** 2 + (b / r) ** 2 * sp.cos(u1) ** 2)
    around, up = r * sp.sin(u1) / root, b**2 * sp.cos(u1) / (r * root)
    place = (around * sp.cos(v1), around * sp.sin(v1), up)
    assert vo.prove_equal((around / r) ** 2 + (up / b) ** 2, 1).proved
    own, other = (
        form_values(RollingContact(torus.body, fixed, torus.theta))
        for fixed in (torus.fixed, Surface((u1, v1), place))
    )
    for name in ("k_u1", "k_v1"):
        at = {r: 3, b: 2, sp.Symbol("w"): root.subs({r: 3, b: 2})}
        # squares: the surface by its place has lengths with the sign of a root
        assert vo.prove_equal(own[name].subs(at) ** 2, other[name].subs(at) ** 2).proved, name


def test_names_that_load_on_first_use_are_listed():
    assert set(dir(vo.kinematics)) == set(vo.kinematics.__all__)


def test_a_torus_whose_tube_has_one_radius_is_refused():
    with pytest.raises(DefinitionError, match="the radii of a torus are two"):
        TorusOnEllipsoid((r,), (r, b), 1, (A, C))


def test_the_names_of_a_body_in_three_dimensions():
    ball = BodyInRn(3, M, r)
    state, own = ball.in_space
    spin = sp.Matrix([state[f"omega{i}"] for i in (1, 2, 3)])
    vector = sp.Matrix(sp.symbols("x1:4"))
    assert (ball.body.matrix * vector - spin.cross(vector)).expand() == sp.zeros(3, 1)
    assert own == dict(zip(("I1", "I2", "I3"), sp.symbols("I23 I13 I12"), strict=True))
    assert ball.scene("All.", 1.0).outputs == (*ball.normal, *ball.velocities)
    assert ball.scene("One.", 1.0, ball.normal[:1]).outputs == (ball.normal[0],)
    known = ball.relation_in_space("own", "low")
    assert (known.source, known.target, known.state) == ("own@3", "low", state)
    assert known.parameters == {M: M, r: r, **own}
    point = BodyInRn(3, twists=False)
    assert point.relation_in_space("body", "low").parameters == point.in_space[1]


def test_the_scene_of_a_rubber_ball_shows_its_contact():
    """On a sphere with the contact there, on a plane with the place; what is given wins."""
    flat, round_ = BalancedBall.on_plane(b, M, moments), BalancedBall.on_sphere(r, b, M, moments)
    u, v, u1, v1, w1, w2, x, y = sp.symbols("u v u1 v1 omega1 omega2 x y")
    usual = {u: sp.Rational(6, 5), w1: sp.Rational(1, 20), w2: sp.Rational(1, 5)}
    scene = round_.rubber_scene("Round.", 3.0, {w1: 1}, {r: 4})
    assert scene.initial == {**usual, u1: 1, w1: 1}
    assert (scene.outputs, scene.parameters) == ((u, v, u1, v1), {r: 4})
    scene = flat.rubber_scene("Flat.", 3.0)
    assert (scene.initial, scene.outputs, scene.times) == (usual, (x, y, u, v), (0.0, 3.0))
