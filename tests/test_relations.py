"""Relations of motions: decided exactly, their kinds computed, claims carried along them."""

from dataclasses import replace

import pytest
import sympy as sp

import voronec as vo

x, y, h = sp.symbols("x y h")
m, k, w = sp.symbols("m k w")
X, q, p, n = sp.symbols("X q p n")
DX, DQ = vo.velocity(x), vo.velocity(q)

SPRING = vo.System(
    name="spring",
    fibration=vo.Fibration((x,)),
    lagrangian=m * DX**2 / 2 - k * x**2 / 2,
    parameters=(m, k),
    integrals={"energy": m * DX**2 / 2 + k * x**2 / 2},
    measure=1,
)
UNIT = vo.System(
    name="unit-spring",
    fibration=vo.Fibration((q,)),
    lagrangian=(DQ**2 - w**2 * q**2) / 2,
    parameters=(w,),
    integrals={"energy": DQ**2 + w**2 * q**2},
    equations={"motion": vo.Equation((q, DQ), (DQ, -(w**2) * q))},
    measure=1,
)
FREE = vo.System(
    name="free", fibration=vo.Fibration((q,)), lagrangian=DQ**2 / 2, integrals={"speed": DQ}
)
DRIVEN = vo.System(
    name="driven",
    fibration=vo.Fibration((q,)),
    lagrangian=(DQ**2 - w**2 * q**2) / 2 + q * sp.cos(vo.time),
    parameters=(w,),
)
PLANE = vo.System(
    name="plane-oscillator",
    fibration=vo.Fibration((x, y)),
    lagrangian=m * (DX**2 + vo.velocity(y) ** 2) / 2 - k * (x**2 + y**2) / 2,
    parameters=(m, k),
)
SYSTEMS = {s.name: s for s in (SPRING, UNIT, FREE, DRIVEN, PLANE)}
ROOT = sp.sqrt(k / m)


def check(*given, **more):
    return vo.check_relation(vo.Relation(*given, **more), SYSTEMS.values())


def test_a_change_of_parameters_is_a_relation_and_carries_claims():
    found = check("spring", "unit-spring", state={q: x}, parameters={w: ROOT})
    assert found.verdict.proved
    assert found.kinds == ("change of coordinates",)
    carried = {(c.kind, c.name): c.verdict.status for c in found.pulled}
    assert carried == {
        ("integral", "energy"): "proved",
        ("equation", "motion"): "proved",
        ("measure", "density"): "proved",
    }


def test_velocities_follow_from_positions_and_may_be_given():
    assert check("spring", "unit-spring", state={q: x, DQ: DX}, parameters={w: ROOT}).verdict.proved
    wrong = check("spring", "unit-spring", state={q: x, DQ: 2 * DX}, parameters={w: ROOT})
    assert wrong.verdict.refuted
    assert "dq/dt" in wrong.verdict.method


def test_a_wrong_parameter_is_refuted_with_a_witness():
    found = check("spring", "unit-spring", state={q: x}, parameters={w: k / m})
    assert found.verdict.refuted
    assert found.verdict.witness is not None
    assert "the equation of 'qdot'" in found.verdict.method
    assert found.pulled == ()


def test_the_clock_of_a_change_of_time():
    slow = {"state": {q: x}, "parameters": {w: 1}, "clock": ROOT}
    found = check("spring", "unit-spring", **slow)
    assert found.verdict.proved
    assert found.kinds[0] == "change of time"
    assert check("spring", "unit-spring", **{**slow, "clock": 1}).verdict.refuted


def test_a_clock_matters_where_the_target_knows_the_time():
    slow = {"state": {q: x}, "parameters": {w: 1}, "clock": ROOT}
    assert "the time" in check("spring", "driven", **slow).verdict.method


@pytest.mark.parametrize(("order", "status"), [(1, "proved"), (2, "proved"), (3, "refuted")])
def test_a_limit_holds_up_to_its_order(order, status):
    limit = vo.Limit(h, {k: h**2}, order)
    found = check("spring", "free", state={q: x}, limit=limit)
    assert found.verdict.status == status
    assert found.kinds[0] == "limit"


def test_a_limit_with_a_pole_is_refuted():
    found = check("spring", "free", state={q: x}, limit=vo.Limit(h, {k: 1 / h}))
    assert found.verdict.refuted
    assert "pole" in found.verdict.method


def test_nothing_is_proved_where_nothing_is_said():
    """A clock that stands still, or a target without mass, would make every relation true."""
    still = check("spring", "unit-spring", state={q: 1, DQ: 0}, parameters={w: 0}, clock=0)
    assert still.verdict.refuted
    massless = check("unit-spring", "spring", state={x: q}, parameters={m: 0, k: 0})
    assert massless.verdict.refuted
    assert "singular" in massless.verdict.method


def test_infinite_values_are_not_swallowed_by_a_zero():
    odd = vo.System(
        name="odd",
        fibration=vo.Fibration((x,)),
        lagrangian=m * DX**2 / 2,
        parameters=(m, k),
        integrals={"not one": k * (x / k + 1), "speed": DX},
    )
    relation = vo.Relation("free", "odd", {x: q}, {m: 1, k: 0})
    found = vo.check_relation(relation, [*SYSTEMS.values(), odd])
    assert found.verdict.proved
    assert [(c.name, c.verdict.status) for c in found.pulled] == [("speed", "proved")]


def test_reductions_and_embeddings_are_told_by_ranks():
    same = {m: m, k: k}
    down = check("plane-oscillator", "spring", state={x: x}, parameters=same)
    assert (down.verdict.status, down.kinds) == ("proved", ("reduction",))
    up = check("spring", "plane-oscillator", state={x: x, y: 0}, parameters=same)
    assert (up.verdict.status, up.kinds) == ("proved", ("embedding",))
    tilted = check("spring", "plane-oscillator", state={x: x, y: x**2}, parameters=same)
    assert tilted.verdict.refuted


def test_an_automorphism_and_a_specialisation():
    back = check("spring", "spring", state={x: -x}, parameters={m: m, k: k})
    assert (back.verdict.status, back.kinds) == (
        "proved",
        ("automorphism", "change of coordinates"),
    )
    special = check("unit-spring", "spring", state={x: q}, parameters={m: 1, k: w**2})
    assert (special.verdict.status, special.kinds[0]) == ("proved", "specialisation")


def test_a_false_measure_of_the_target_is_refuted_at_the_source():
    false = replace(UNIT, measure=1 + q**2)
    relation = vo.Relation("spring", "unit-spring", state={q: x}, parameters={w: ROOT})
    found = vo.check_relation(relation, [SPRING, false])
    assert [c.verdict.status for c in found.pulled if c.kind == "measure"] == ["refuted"]


@pytest.mark.parametrize(
    ("relation", "words"),
    [
        ({"state": {q: x}}, "leaves the parameter 'w' of 'unit-spring' unmapped"),
        ({"parameters": {w: 1}}, "gives no state"),
        ({"state": {}, "parameters": {w: 1}}, "leaves 'q', 'qdot' of 'unit-spring' unmapped"),
        ({"state": {q: x}, "parameters": {w: n}}, "'w' holds 'n', which 'spring' does not have"),
        ({"state": {q: x}, "parameters": {w: 1, n: 2}}, "parameters maps 'n'"),
        ({"state": {q: x, y: x}, "parameters": {w: 1}}, "state maps 'y'"),
    ],
)
def test_what_is_missing_or_unknown_is_told_in_one_line(relation, words):
    with pytest.raises(vo.DefinitionError) as caught:
        check("spring", "unit-spring", **relation)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_parameter_that_goes_over_by_its_own_name_to_nothing_is_told():
    relation = vo.Relation.of(SPRING, "unit-spring", {"w": 1}, state={q: x})
    with pytest.raises(vo.DefinitionError, match=r"goes over by its own name.* write Relation"):
        vo.check_relation(relation, SYSTEMS.values())


def test_the_limit_scales_parameters_of_the_source():
    with pytest.raises(vo.DefinitionError, match="no parameter of 'spring'"):
        check("spring", "free", state={q: x}, limit=vo.Limit(h, {n: h}))


def test_parameters_that_a_limit_moves_together_come_to_the_target():
    pair = vo.System(
        name="pair-of-springs",
        fibration=vo.Fibration((x,)),
        lagrangian=DX**2 / 2 - (k * n * x) ** 2 / 2,
        parameters=(k, n),
    )
    limit = vo.Limit(h, {k: h * k, n: 1 / h})
    relation = vo.Relation(pair.name, "unit-spring", {q: x}, {w: k * n}, limit=limit)
    assert vo.check_relation(relation, [UNIT, pair]).verdict.proved


def test_polar_coordinates_carry_the_volume():
    r, a = sp.symbols("r a", positive=True)
    polar = vo.System(
        name="polar",
        fibration=vo.Fibration((r, a)),
        lagrangian=m * (vo.velocity(r) ** 2 + r**2 * vo.velocity(a) ** 2) / 2 - k * r**2 / 2,
        parameters=(m, k),
        measure=r**2,
    )
    relation = vo.Relation(
        "polar",
        "plane-oscillator",
        state={x: r * sp.cos(a), y: r * sp.sin(a)},
        parameters={m: m, k: k},
    )
    found = vo.check_relation(relation, [PLANE, polar])
    assert found.verdict.proved
    found = vo.check_relation(relation, [replace(PLANE, measure=1), polar])
    assert [c.verdict.status for c in found.pulled if c.kind == "measure"] == ["proved"]
