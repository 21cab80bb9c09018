"""The diagram of relations: which squares generate it, and whether they commute."""

import pytest
import sympy as sp

import voronec as vo
from voronec.equations.motions import Motions
from voronec.errors import EngineLimit
from voronec.proof.check.inventory import Inventory
from voronec.proof.relations.chains import check_square
from voronec.proof.relations.diagram import diagram, squares_of
from voronec.proof.relations.families import Course

x, h = sp.symbols("x h")
a, b, c = sp.symbols("a b c")
DX = vo.velocity(x)


def oscillator(name, stiffness, *parameters, friction=0):
    return vo.System(
        name=name,
        fibration=vo.Fibration((x,)),
        lagrangian=DX**2 / 2 - stiffness * x**2 / 2,
        forces={x: -friction * DX},
        parameters=parameters,
    )


SYSTEMS = {
    s.name: s
    for s in (
        oscillator("sum", a + b + c, a, b, c),
        oscillator("two", a + b, a, b),
        oscillator("one", a, a),
        oscillator("damped", a, a, c, friction=c),
    )
}
MOTIONS = {name: Motions.of(system) for name, system in SYSTEMS.items()}


def edge(source, target, name="", limit=None, state=None, **parameters):
    return vo.Relation(source, target, state, parameters, limit=limit, name=name)


def decide(relations, *squares):
    named = {r.label: r for r in relations}
    return [check_square(s, named, MOTIONS.__getitem__) for s in squares]


ONE_TWO = edge("one", "two", a=a, b=0)
TWO_SUM = edge("two", "sum", a=a, b=b, c=0)
ONE_SUM = edge("one", "sum", a=a, b=0, c=0)
CROSSED = edge("one", "sum", name="turned about", a=0, b=0, c=a)
SWAP = edge("sum", "sum", name="swap", state={x: x}, a=c, b=b, c=a)


def test_a_square_for_each_two_chains_that_nothing_else_joins():
    graph = diagram(SYSTEMS, [ONE_TWO, TWO_SUM, ONE_SUM, SWAP])
    (square,) = squares_of(graph)
    assert {square.first, square.second} == {
        ("one -> two", "two -> sum"),
        ("one -> sum",),
    }
    assert set(graph) == set(SYSTEMS)
    assert graph.edges["one", "sum", "one -> sum"]["relation"] is ONE_SUM


def test_chains_that_share_an_end_need_no_square_of_their_own():
    """A ladder of two squares: the chains around both follow from these."""
    graph = diagram(
        "abcdef",
        [vo.Relation(x, y) for x, y in ("ab", "bc", "de", "ef", "ad", "be", "cf")],
    )
    found = {frozenset({s.first, s.second}) for s in squares_of(graph)}
    assert found == {
        frozenset({("a -> b", "b -> e"), ("a -> d", "d -> e")}),
        frozenset({("b -> c", "c -> f"), ("b -> e", "e -> f")}),
    }


def test_a_square_commutes_or_is_refuted():
    relations = [ONE_TWO, TWO_SUM, ONE_SUM, CROSSED, SWAP]
    found = {
        s.label: c.verdict
        for s in squares_of(diagram(SYSTEMS, relations))
        for c in decide(relations, s)
    }
    status = sorted(v.status for v in found.values())
    # against the relation that leads straight: through two, and the one that is turned about
    assert status == ["proved", "refuted"]
    wrong = next(v for v in found.values() if v.refuted)
    assert wrong.witness is not None


def test_up_to_an_automorphism():
    relations = [ONE_TWO, TWO_SUM, CROSSED, SWAP]
    chains = {"first": ("one -> two", "two -> sum"), "second": ("turned about",)}
    plain, swapped = vo.Square(**chains), vo.Square(**chains, up_to="swap")
    assert [c.verdict.status for c in decide(relations, plain, swapped)] == ["refuted", "proved"]
    graph = diagram(SYSTEMS, relations)
    assert squares_of(graph, [swapped]) == [swapped]


def test_limits_are_taken_in_the_order_of_the_chain():
    vanish = {"limit": vo.Limit(h, {c: h})}
    calm = edge("damped", "one", a=a, **vanish)
    soft = edge("sum", "two", a=a, b=b, limit=vo.Limit(h, {c: h}))
    back = edge("two", "one", name="second spring off", a=a, limit=vo.Limit(h, {b: h}))
    straight = edge("sum", "one", name="both off", a=a, limit=vo.Limit(h, {b: h, c: h}))
    relations = [calm, soft, back, straight]
    (square,) = squares_of(diagram(SYSTEMS, relations))
    (found,) = decide(relations, square)
    assert found.verdict.proved
    assert sorted(map(len, found.limits)) == [1, 2]
    longer = max(found.limits, key=len)
    assert longer == ("sum -> two: h -> 0", "second spring off: h -> 0")


def test_a_limit_is_taken_on_the_whole_chain():
    """A map that holds the small parameter goes to its limit, too."""
    pair = oscillator("pair", a + b, a, b)
    motions = {**MOTIONS, "pair": Motions.of(pair)}
    stretched = edge("two", "pair", state={x: x * (1 + b)}, name="stretched", a=a, b=b)
    plain = edge("two", "pair", state={x: x}, name="plain", a=a, b=b)
    off = edge("pair", "one", name="off", limit=vo.Limit(h, {b: h}), a=a)
    named = {r.label: r for r in (stretched, plain, off)}
    square = vo.Square(("stretched", "off"), ("plain", "off"))
    assert check_square(square, named, motions.__getitem__).verdict.proved
    shrunk = edge("two", "pair", state={x: x * b}, name="shrunk", a=a, b=b)
    grown = edge("pair", "one", state={x: x / b}, name="grown", limit=off.limit, a=a)
    named |= {r.label: r for r in (shrunk, grown)}
    square = vo.Square(("shrunk", "grown"), ("plain", "off"))  # x b / b, before b vanishes
    assert check_square(square, named, motions.__getitem__).verdict.proved
    exact = vo.Square(("stretched",), ("plain",))
    assert check_square(exact, named, motions.__getitem__).verdict.refuted


def test_a_limit_is_carried_back_through_quotients():
    """b = a/c comes to zero where a does; d = 1/c does so where c is infinite."""
    ratio = edge("damped", "two", name="ratio", a=c, b=a / (a + c))
    back = edge("two", "one", name="back", limit=vo.Limit(h, {b: h * b}), a=a)
    course = Course.of([ratio, back])
    assert dict(course.limits) == {"a": 0}
    assert dict(course.values) == {"a": c}
    reciprocal = edge("damped", "two", name="reciprocal", a=a, b=1 / c)
    far = Course.of([reciprocal, edge("two", "one", limit=vo.Limit(h, {b: h}), a=a)])
    assert dict(far.limits) == {"c": sp.zoo}


def test_a_parameter_at_its_limit_need_not_move():
    chain = edge("one", "two", name="none", a=a, b=0)
    back = edge("two", "one", name="back", limit=vo.Limit(h, {b: h}), a=a)
    (found,) = decide([chain, back], vo.Square(("none", "back"), ()))
    assert found.verdict.proved
    assert Course.of([chain, back]).limits == {}


def test_a_chain_that_fixes_what_its_limit_moves_has_no_meaning():
    fixed = edge("one", "two", name="fixed", a=a, b=1)
    off = edge("two", "damped", name="off", limit=vo.Limit(h, {b: h}), a=a, c=0)
    keep = edge("two", "damped", name="keep", a=a, c=b)
    straight = edge("one", "damped", name="straight", a=a, c=1)
    relations = [fixed, off, keep, straight]
    squares = squares_of(diagram(SYSTEMS, relations))
    assert {frozenset({s.first, s.second}) for s in squares} == {
        frozenset({("off",), ("keep",)}),
        frozenset({("fixed", "keep"), ("straight",)}),
    }
    with pytest.raises(vo.DefinitionError, match="fixes a parameter that the limit"):
        decide(relations, vo.Square(("fixed", "off"), ("straight",)))


def test_chains_that_differ_are_not_joined_by_their_common_limit():
    off = edge("two", "damped", name="a limit", limit=vo.Limit(h, {b: h}), a=a, c=0)
    once = edge("two", "damped", name="once", a=a, c=b)
    twice = edge("two", "damped", name="twice", a=a, c=2 * b)
    relations = [off, once, twice]
    squares = squares_of(diagram(SYSTEMS, relations))
    found = {
        frozenset((*s.first, *s.second)): v
        for s, v in zip(squares, _verdicts(relations, squares), strict=True)
    }
    assert found == {
        frozenset({"once", "twice"}): "refuted",
        frozenset({"a limit", "once"}): "proved",
    }


def _verdicts(relations, squares):
    return [c.verdict.status for c in decide(relations, *squares)]


def test_chains_that_an_automorphism_tells_apart_are_not_joined():
    copy = oscillator("copy", a + b + c, a, b, c)
    on = edge("sum", "copy", name="on", a=a, b=b, c=c)
    relations = [ONE_SUM, CROSSED, SWAP, on]
    swapped = vo.Square(("one -> sum",), ("turned about",), up_to="swap")
    graph = diagram([*SYSTEMS, copy.name], relations)
    declared, asked = squares_of(graph, [swapped])
    assert declared is swapped
    assert {asked.first, asked.second} == {("one -> sum", "on"), ("turned about", "on")}
    named = {r.label: r for r in relations}
    motions = {**MOTIONS, "copy": Motions.of(copy)}
    assert check_square(asked, named, motions.__getitem__).verdict.refuted


def test_limits_to_different_values_are_not_compared():
    off = edge("two", "one", name="off", limit=vo.Limit(h, {b: h}), a=a)
    far = edge("two", "one", name="far", limit=vo.Limit(h, {b: 1 / h}), a=a)
    assert squares_of(diagram(SYSTEMS, [off, far])) == []
    with pytest.raises(EngineLimit, match="different values"):
        decide([off, far], vo.Square(("off",), ("far",)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "chain",
    [
        ("borisov-fedorov-ball -> ball-on-sphere", "ball-on-sphere -> chaplygin-ball"),
        (
            "rubber-ball-eps-minus-one -> rubber-ball-on-sphere",
            "rubber-ball-on-sphere -> rubber-ball-on-plane",
        ),
    ],
)
def test_a_ball_inside_a_sphere_of_half_its_radius_comes_to_no_plane(chain):
    stock = Inventory.of()
    relations = {r.label: stock.relation(r) for r in stock.relations}
    assert Course.of(relations[label] for label in chain) is None
    for face in stock.faces:
        for side in (face.first, face.second):
            assert chain != side[: len(chain)]


def test_a_chain_that_leads_back_must_be_the_identity():
    there = edge("one", "damped", name="there", a=a, c=0)
    back = edge("damped", "one", name="back", a=a, limit=vo.Limit(h, {c: h}))
    circles = squares_of(diagram(SYSTEMS, [there, back]))
    assert {c.first for c in circles} == {("there", "back"), ("back", "there")}
    assert {c.second for c in circles} == {()}
    (found,) = decide([there, back], vo.Square(("there", "back"), ()))
    assert found.verdict.proved
    doubled = edge("one", "damped", name="there", a=2 * a, c=0)
    (found,) = decide([doubled, back], vo.Square(("there", "back"), ()))
    assert found.verdict.refuted


def test_chains_pass_from_coordinates_to_invariants():
    ball = vo.load("chaplygin-ball")
    motions = {"ball": Motions.of(ball), "chaplygin-ball": Motions.of(ball)}
    keep = {p.symbol: p.symbol for p in ball.parameters}
    variables = (*ball.coordinates, *ball.velocities)
    turned = {s: s for s in variables} | {sp.Symbol("phi"): sp.Symbol("phi") + 1}
    turned |= {
        sp.Symbol("x"): sp.cos(1) * sp.Symbol("x") - sp.sin(1) * sp.Symbol("y"),
        sp.Symbol("y"): sp.sin(1) * sp.Symbol("x") + sp.cos(1) * sp.Symbol("y"),
    }
    turn = vo.Relation("ball", "ball", turned, keep, name="turn about the vertical")
    below = vo.Relation("ball", "ball", None, keep, name="identity of the invariants")
    named = {r.label: r for r in (turn, below)}
    square = vo.Square((turn.label, below.label), (below.label,))
    assert check_square(square, named, motions.__getitem__).verdict.proved


@pytest.mark.parametrize(
    ("relations", "squares", "words"),
    [
        ([ONE_TWO, ONE_TWO], [], "two relations are called 'one -> two'"),
        ([edge("one", "twoo")], [], "there is no system 'twoo'; did you mean 'two'?"),
        ([ONE_TWO], [vo.Square(("one -> two",), ("one -> tow",))], "no relation 'one -> tow'"),
    ],
)
def test_a_diagram_that_makes_no_sense_is_refused(relations, squares, words):
    with pytest.raises(vo.DefinitionError) as caught:
        squares_of(diagram(SYSTEMS, relations), squares)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("square", "words"),
    [
        (vo.Square(("two -> sum", "one -> two"), ("one -> sum",)), "breaks: it comes to 'sum'"),
        (vo.Square(("one -> two",), ("one -> sum",)), "leads from 'one' to 'two'"),
    ],
)
def test_chains_that_do_not_fit_are_refused(square, words):
    with pytest.raises(vo.DefinitionError, match=words):
        decide([ONE_TWO, TWO_SUM, ONE_SUM], square)
