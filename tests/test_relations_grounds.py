"""What a relation may rest on: parameters, functions, limits, ranks, volumes and the time."""

from dataclasses import replace

import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.proof.relations.orders import vanishes

pytestmark = pytest.mark.slow

x, y, q, h = sp.symbols("x y q h")
m, k, w = sp.symbols("m k w")
DX, DQ = vo.velocity(x), vo.velocity(q)
ROOT = sp.sqrt(k / m)


def line(name, lagrangian, *parameters, **more):
    """A point on the line of q."""
    return vo.System(name, vo.Fibration((q,)), lagrangian, parameters=parameters, **more)


f, s = sp.Function("f"), sp.Symbol("s")
DY = vo.velocity(y)
SPRING = vo.System(
    "spring",
    vo.Fibration((x,)),
    m * DX**2 / 2 - k * x**2 / 2,
    parameters=(m, k),
    measure=1,
)
UNIT = line(
    "unit-spring",
    (DQ**2 - w**2 * q**2) / 2,
    w,
    integrals={"energy": DQ**2 + w**2 * q**2},
    equations={"motion": vo.Equation((q, DQ), (DQ, -(w**2) * q))},
    measure=1,
)
FREE = line("free", DQ**2 / 2, integrals={"speed": DQ})
QUARTIC = line("quartic", DQ**2 / 2 - q**4 / 4)
OPEN = line("open", DQ**2 / 2 - f(q))
PAIR = vo.System("pair", vo.Fibration((x, y)), (DX**2 + DY**2) / 2 - x**4 / 4 - y**4 / 4)
OPEN_PAIR = vo.System("open-pair", vo.Fibration((x, y)), (DX**2 + DY**2) / 2 - f(x) - f(y))
SOFT = line("soft", DQ**2 / 2 - sp.sqrt(k) ** 3 * q**2 / 2, k)
HEAVY = line("heavy", m * (DQ**2 / 2 - q), m)
SYSTEMS = (SPRING, UNIT, FREE, QUARTIC, OPEN, PAIR, OPEN_PAIR, SOFT, HEAVY)


def check(*given, **more):
    return vo.check_relation(vo.Relation(*given, **more), SYSTEMS)


POSITIVE = line("positive", DQ**2 / 2 - k * q**2 / 2, vo.Parameter(k, positive=True))
EQUAL = line("equal", m * DQ**2 / 2 - m * q**2 / 2, m, k, possible={"m = k": sp.Eq(m, k)})
APART = line("apart", (DQ**2 - q**2) / 2, m, k, possible={"m is not k": sp.Ne(m, k)})
WAVE = vo.System("wave", vo.Fibration((x,)), (DX**2 - x**2) / 2, parameters=(m, k))
SIZE = vo.System("size", vo.Fibration((x,)), DX**2 / 2 - sp.Abs(k) * x**2 / 2, parameters=(k,))


@pytest.mark.parametrize(
    ("start", "end", "values", "standing"),
    [
        (SIZE, POSITIVE, {k: k}, "proved where k > 0"),
        (SIZE, POSITIVE, {k: sp.Abs(k)}, "proved "),
        (SIZE, POSITIVE, {k: -(1 + k**2)}, "refuted "),
        (SPRING, EQUAL, {m: m, k: k}, "proved where k - m = 0"),
        (WAVE, EQUAL, {m: 1, k: 2}, "refuted "),
        (WAVE, APART, {m: m, k: k}, "proved where k != m"),
        (WAVE, APART, {m: m, k: m}, "refuted "),
    ],
)
def test_what_a_target_declares_of_its_parameters_is_asked_of_their_values(
    start, end, values, standing
):
    relation = vo.Relation(start.name, end.name, state={q: x}, parameters=values)
    found = vo.check_relation(relation, systems=(start, end)).verdict
    assert f"{found.status} {found.limits}" == standing, found


PUSHED = line("pushed", DQ**2 / 2, forces={DQ: f(q)})
RUBBED = vo.System("rubbed", vo.Fibration((x,)), DX**2 / 2, forces={DX: sp.sign(x)})


@pytest.mark.parametrize(
    ("start", "end", "value", "status"),
    [
        (WAVE, OPEN, q**2 / 2, "proved"),
        (WAVE, OPEN, q**2 / 2 + sp.sign(q), "refuted"),
        (WAVE, OPEN, q**2 / 2 + sp.floor(q), "refuted"),
        (WAVE, OPEN, q**2 / 2 + sp.atan(q) + sp.atan(1 / q), "refuted"),
        (RUBBED, PUSHED, sp.sign(q), "proved"),
    ],
)
def test_a_potential_does_not_jump_and_a_force_may(start, end, value, status):
    relation = vo.Relation(start.name, end.name, state={q: x}, parameters={f(q): value})
    found = vo.check_relation(relation, systems=(start, end)).verdict
    assert found.status == status, found
    if status == "refuted":
        assert found.method.startswith("the function 'f': it jumps where x ")


def test_claims_are_carried_where_the_parameters_are_possible():
    claimed = replace(POSITIVE, integrals={"energy": DQ**2 + sp.Abs(k) * q**2})
    relation = vo.Relation("size", "positive", state={q: x}, parameters={k: k})
    found = vo.check_relation(relation, systems=(SIZE, claimed))
    assert [c.standing for c in found.pulled] == ["proved where k > 0"]


def test_a_parameter_of_the_target_is_constant_along_the_motions():
    moving = check("quartic", "unit-spring", state={q: q}, parameters={w: q})
    assert moving.verdict.refuted
    assert "the parameter 'w'" in moving.verdict.method
    energy = m * DX**2 / 2 + k * x**2 / 2
    kept = {"state": {q: x}, "parameters": {w: ROOT * energy}, "clock": 1 / energy}
    found = check("spring", "unit-spring", **kept)
    assert found.verdict.proved
    # the volume of one value of the energy is none of all states
    assert "measure" not in {c.kind for c in found.pulled}


@pytest.mark.parametrize(
    ("value", "status"),
    [
        (q**4 / 4, "proved"),
        (x * q**3 / 4, "undecided"),
        (x**2 * q**2 / 2, "undecided"),
        (DX * q**3, "refuted"),
    ],
)
def test_an_unknown_function_is_one_of_its_arguments(value, status):
    """With q = x, x q^3/4 is q^4/4 in other words, but for its derivative; xdot is no function of
    q."""
    point = vo.System("point", vo.Fibration((x,)), DX**2 / 2 - x**4 / 4)
    relation = vo.Relation("point", "open", state={q: x}, parameters={"f": value})
    assert vo.check_relation(relation, [*SYSTEMS, point]).verdict.status == status


def test_state_in_a_function_that_the_arguments_determine():
    """On a circle a = cos u, b = sin u; what a function of u is there may be written in a and b."""
    u, a, b = sp.symbols("u a b")
    du = vo.velocity(u)
    turn = vo.System(
        "turn",
        vo.Fibration((u,), (a, b), relations=(a - sp.cos(u), b - sp.sin(u))),
        du**2 / 2,
        constraints=(vo.velocity(a) + b * du, vo.velocity(b) - a * du),
        forces={u: a},
    )
    pushed = vo.System("pushed", vo.Fibration((u,)), du**2 / 2, forces={u: f(u)})
    other = vo.System("other", vo.Fibration((y,)), DY**2 / 2, forces={y: f(y)})
    systems = (turn, pushed, other)
    fits = vo.Relation("turn", "pushed", {u: u}, {"f": a})
    assert vo.check_relation(fits, systems).verdict.proved
    apart = vo.Relation("turn", "other", {y: 0}, {"f": a})
    found = vo.check_relation(apart, systems)
    assert "no function of its arguments" in found.verdict.method


def test_a_function_of_several_arguments_is_given_by_formal_ones():
    same = {x: x, y: y}
    found = check("pair", "open-pair", state=same, parameters={f(s): s**4 / 4})
    assert found.verdict.proved
    wrong = check("pair", "open-pair", state=same, parameters={f(s): s**2})
    assert wrong.verdict.refuted
    with pytest.raises(vo.DefinitionError, match="name its arguments"):
        check("pair", "open-pair", state=same, parameters={"f": y**4 / 4})


@pytest.mark.parametrize("order", [1, 2, 3])
def test_a_limit_in_which_the_target_degenerates_is_refuted(order):
    limit = vo.Limit(h, {k: h}, order)
    heavy = {"state": {q: q}, "parameters": {m: h**order}, "limit": limit}
    found = check("soft", "heavy", **heavy)
    assert not found.verdict.proved
    still = {"state": {q: x, DQ: 0}, "parameters": {m: 1}, "clock": h**order, "limit": limit}
    found = check("spring", "heavy", **still)
    assert found.verdict.refuted
    assert "the clock stands still" in found.verdict.method


def test_mass_that_vanishes_with_the_small_parameter_hides_nothing():
    limit = vo.Limit(h, {k: h}, 2)
    found = check("spring", "heavy", state={q: x}, parameters={m: h**2}, limit=limit)
    assert found.verdict.refuted
    assert "singular on the image where 'h' vanishes" in found.verdict.method


def test_roots_of_the_small_parameter_are_left_undecided():
    found = check("soft", "free", state={q: q}, limit=vo.Limit(h, {k: h}, 2))
    assert found.verdict.undecided
    small = se.Symbol("h")
    for expr in (small ** se.Rational(3, 2), small * se.log(small), se.asin(1 - small) - se.pi / 2):
        assert vanishes(expr, [], small, 1).undecided
    assert vanishes(se.sqrt(1 + small) - 1 - small / 2, [], small, 2).proved


def test_relations_that_hold_the_small_parameter():
    small, z = se.symbols("h z")
    on = [z - 1 - small]
    assert vanishes(z - 1, on, small, 1).proved
    assert vanishes(small * (z - 1), on, small, 2).undecided  # true, not seen
    assert vanishes(z - 2, on, small, 1).refuted
    assert vanishes(small * (z - 1 - small), on, small, 3).proved


def test_where_no_point_is_found_nothing_is_refuted():
    far = line("far", sp.sqrt(q - 1000) * DQ**2 / 2)
    found = vo.check_relation(vo.Relation("far", "far"), [far])
    assert found.verdict.undecided
    assert not {"reduction", "embedding"} & {*found.kinds}


def test_the_kind_of_a_limit_is_that_of_its_map_at_the_limit():
    found = check("spring", "free", state={q: h * x}, limit=vo.Limit(h, {k: h}))
    assert found.kinds == ("limit", "constant map")


def circle(name, *relations, density=1):
    turning = x * DY - y * DX
    return vo.System(
        name,
        vo.Fibration((x, y), relations=relations),
        (DX**2 + DY**2) / 2,
        frame=vo.Frame.quasi({w: turning}),
        measure=density,
    )


def test_redundant_relations_count_once_and_volumes_know_their_relations():
    round_one = x**2 + y**2 - 1
    plain = circle("plain", round_one)
    twice = circle("twice", round_one, x * round_one)
    scaled = circle("scaled", round_one * (1 + x**2), density=1 + x**2)
    for source, target in (("twice", "plain"), ("plain", "scaled")):
        found = vo.check_relation(vo.Relation(source, target), (plain, twice, scaled))
        assert (found.verdict.status, found.kinds) == ("proved", ("equality",))
        assert [c.verdict.status for c in found.pulled if c.kind == "measure"] == ["proved"]


def test_claims_that_hold_the_time_need_a_map_of_time():
    timed = line("timed", DQ**2 / 2, integrals={"start": q - vo.time * DQ, "speed": DQ}, measure=1)
    slow = vo.Relation("free", "timed", {q: q}, clock=2)
    found = vo.check_relation(slow, [timed, FREE])
    assert {c.name for c in found.pulled} == {"speed", "density"}
    known = vo.Relation("free", "timed", {q: q, vo.time: 2 * vo.time}, clock=2)
    found = vo.check_relation(known, [timed, FREE])
    assert {c.name: c.verdict.status for c in found.pulled} == dict.fromkeys(
        ("start", "speed", "density"), "proved"
    )


def test_a_clock_of_state_and_time_carries_no_measure():
    v, nu = sp.Symbol("v"), (1 + x**2) * sp.exp(vo.time)
    # x' = nu v, v' = -nu x: an oscillator whose time runs with nu
    source = vo.System(
        "hurried",
        vo.Fibration((x,)),
        DX**2 / (2 * nu**2),
        frame=vo.Frame.quasi({v: DX / nu}),
        forces={x: -x - DX / nu**2},
    )
    relation = vo.Relation("hurried", "unit-spring", {q: x, DQ: v}, {w: 1}, clock=nu)
    found = vo.check_relation(relation, [source, UNIT])
    assert found.verdict.proved
    assert {c.kind for c in found.pulled} == {"integral", "equation"}
