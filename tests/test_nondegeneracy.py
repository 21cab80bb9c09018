"""What a claim needs besides equalities is asked for on every piece of the space.

The truth is computed apart from the engine: slopes by differences at random states.
"""

from __future__ import annotations

from itertools import combinations
from random import Random

import numpy as np
import pytest
import sympy as sp

import voronec as vo
from voronec import Measure, Parameter, Poisson, Relation
from voronec.algebra.pieces import pieces_of
from voronec.equations.motions import Motions
from voronec.proof.claims import check_claims
from voronec.proof.quadratures import check_motion

x, y, q, r, p, a, b = sp.symbols("x y q r p a b")
v, w, qdot = map(vo.velocity, (x, y, q))
WORDS = {s.name: s for s in (x, y, v, w, a, b)}
STEP = 1e-6


def plane(**claims):
    lagrangian = claims.pop("lagrangian", (v**2 + w**2) / 2)
    return vo.System("plane", vo.Fibration((x, y)), lagrangian, **claims)


def line(**claims):
    return vo.System("line", vo.Fibration((x,)), claims.pop("lagrangian", v**2 / 2), **claims)


def only(system, kind):
    return next(c for c in check_claims(system) if c.kind == kind)


def holds(domain, at):
    """Whether the conditions of a domain hold at a point."""
    clauses = [c.split(" or ") for c in domain.split(", ")] if domain else []
    return all(any(_compare(part, at) for part in clause) for clause in clauses)


def _compare(words, at):
    left, sign, _ = words.rsplit(" ", 2)
    value = float(sp.sympify(left, locals=WORDS).subs(at))
    return {">": value > 0, "<": value < 0, "!=": value != 0}[sign]


def is_theorem(functions, density, at, state):
    """Whether functions are independent and a density is not zero, at a point."""
    numeric = sp.lambdify([*at], [*functions, density], "numpy")
    values = {s: float(e) for s, e in at.items()}
    middle = np.array(numeric(*values.values()), dtype=float)
    slopes = []
    for s in state:
        beside = {**values, s: values[s] + STEP}
        slopes.append((np.array(numeric(*beside.values()), dtype=float) - middle)[:-1] / STEP)
    found = np.linalg.svd(np.array(slopes), compute_uv=False)
    return bool(found[-1] > 1e-3 and abs(middle[-1]) > 1e-6)


THEOREMS = [
    (v, w, 1), (v, sp.Abs(w), 1), (v, 2 * w + sp.Abs(w), 1), (v, w, sp.Abs(w)), (v, sp.atan(w), 1),
    (v * w, v**2 + w**2, 1), (v, w, 2 + sp.sign(w)), (v, sp.Max(w, 2 * w), 1),
    (v, w + sp.Abs(w), 1), (v, w + sp.sqrt(w**2), 1), (v, sp.Min(0, w), 1), (v, w, sp.Max(0, w)),
    (v, w, w - sp.sqrt(w**2)), (v, w, 1 + sp.sign(w)), (v, w, (sp.sign(v) + sp.sign(w)) ** 2),
    (v, sp.Piecewise((w, w > 1), (0, True)), 1), (v, w * (1 + sp.sign(v)), 1),
    (v, sp.Max(v, w), 1), (v + w, sp.Abs(v) - sp.Abs(w), 1), (v, v * w + sp.Abs(v * w), 1),
    (v, sp.Abs(v + w) - sp.Abs(v) - w, 1), (v, w**3 + (w**2) ** sp.Rational(3, 2), 1),
    (v, sp.sqrt((w - 1) ** 2) + w, 1), (v, w, sp.atan(w) + sp.atan(1 / w) - sp.pi / 2),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("first", "second", "density"), THEOREMS)
def test_a_theorem_holds_on_the_pieces_on_which_its_integrals_are_independent(
    first, second, density
):
    claim = only(
        plane(integrals={"a": first, "b": second}, measure=density, integrable="Euler-Jacobi"),
        "integrable",
    )
    assert claim.verdict.proved, claim.verdict
    source, met = Random(1), set()
    for _ in range(40):
        at = {s: sp.Rational(source.randint(-2500, 2500), 1009) for s in (x, y, v, w)}
        truth = is_theorem((first, second), sp.sympify(density), at, (x, y, v, w))
        assert holds(claim.verdict.domain, at) is truth, (claim.verdict.domain, at)
        met.add(truth)
    assert True in met


def test_functions_that_are_dependent_on_every_piece_are_not_enough():
    # where all three roots are real their product is the triple, or its opposite
    triple = v * w * (v + w)
    roots = [sp.sqrt(s * t) for s, t in combinations((v, w, v + w), 2)]
    for second in (v, sp.Abs(v), triple + sp.Mul(*roots)):
        system = plane(integrals={"a": v, "b": second}, measure=1, integrable="Euler-Jacobi")
        assert only(system, "integrable").verdict.undecided


@pytest.mark.parametrize(
    ("second", "density", "domain"),
    [
        (a * w, 1, "a != 0"), (w, a, "a != 0"), ((a - b) * w, 1, "a - b != 0"),
        (w + a * (v - w), 1, "a - 1 != 0"), ((a + sp.Abs(a)) * w, 1, "a > 0"), (w + a * v, 1, ""),
    ],
)  # fmt: skip
def test_letters_at_which_a_theorem_fails_are_named(second, density, domain):
    claims = {"integrals": {"a": v, "b": second}, "measure": density, "integrable": "Euler-Jacobi"}
    found = only(plane(**claims, parameters=(a, b)), "integrable").verdict
    assert found.proved and found.domain == domain
    signed = (Parameter(a, 1, positive=True), b)
    if domain in ("a != 0", "a > 0"):
        assert only(plane(**claims, parameters=signed), "integrable").standing == "proved"


def test_densities_and_multipliers_hold_where_they_do_not_vanish():
    for density, standing in (
        (sp.Max(0, w), "proved where ydot > 0"), (sp.Abs(w), "proved"), (a, "proved where a != 0"),
    ):  # fmt: skip
        assert only(plane(measure=density, parameters=(a,)), "measure").standing == standing
    chosen = Measure(sp.Max(0, w), (w,))
    assert only(plane(measure=chosen), "measure").standing == "proved where ydot > 0"
    for multiplier, standing in (
        (sp.Max(0, x), "proved where x > 0"), (x, "proved where x != 0"),
        (a, "proved where a != 0"), (1 / x, "proved where x != 0"),
    ):  # fmt: skip
        system = line(multiplier=multiplier, parameters=(a,))
        assert only(system, "multiplier").standing == standing


def test_multipliers_and_clocks_with_a_pole_are_ones_beside_it():
    """Where the equations have a pole, too, another constant on its other side is no jump."""
    split = line(lagrangian=v**2 / x**2 / 2, multiplier=2 + sp.sign(x))
    assert only(split, "multiplier").standing == "proved where x != 0"
    bracket = Poisson({x: x, p: v}, {(x, p): x}, p**2 / 2, clock=1 / x)
    assert only(line(poisson=bracket), "poisson").standing == "proved where x != 0"


def test_the_variables_of_a_bracket_determine_the_state_on_every_piece():
    def standing(image, entry, hamiltonian, **claims):
        bracket = Poisson({x: x, p: image}, {(x, p): entry}, hamiltonian)
        return only(line(poisson=bracket, **claims), "poisson").standing

    assert standing(v * sp.Abs(v), 2 * sp.Abs(v), v**2 / 2) == "proved"
    assert standing(a * v, a, p**2 / a**2 / 2, parameters=(a,)) == "proved where a != 0"
    flat = plane(
        lagrangian=v**2 / 2 + w**2 / 2,
        poisson=Poisson(
            {x: x, y: y, p: v, q: sp.Max(0, w)}, {(x, p): 1, (y, q): 1}, (p**2 + q**2) / 2
        ),
    )
    assert not only(flat, "poisson").verdict.proved


free = vo.System(
    "free", vo.Fibration((q,)), qdot**2 / 2, integrals={"speed": qdot}, measure=sp.Integer(1)
)


def related(system, state, **more):
    relation = Relation(system.name, "free", state=state, **more)
    return vo.check_relation(relation, systems=(system, free))


def test_a_map_that_forgets_everything_says_so():
    for image in (0, 5):
        assert related(line(), {q: image}).kinds == ("constant map",)
    held = related(line(), {q: x})
    assert held.kinds == ("change of coordinates",) and held.pulled[-1].standing == "proved"


@pytest.mark.parametrize(
    ("image", "words"),
    [(a * x, "a != 0"), ((a - b) * x, "a - b != 0"), (x * sp.Heaviside(v), "xdot > 0")],
)
def test_where_a_map_loses_more_than_elsewhere_is_told(image, words):
    state = {q: image} if image.has(a) else {q: image, qdot: sp.Max(0, v)}
    found = related(line(parameters=(a, b)), state)
    assert found.verdict.proved
    assert found.kinds == ("change of coordinates", f"of less rank unless {words}")
    (density,) = [c for c in found.pulled if c.kind == "measure"]
    assert density.standing == f"proved where {words}"
    signed = (Parameter(a, 1, positive=True), b)
    if words == "a != 0":
        assert related(line(parameters=signed), state).kinds == ("change of coordinates",)


def test_a_clock_that_stands_still_on_one_side_is_one_on_the_other():
    found = related(plane(), {q: 5, qdot: 0}, clock=sp.Max(0, w))
    assert found.verdict.proved and found.verdict.domain == "ydot > 0"
    assert related(line(), {q: 5, qdot: 0}, clock=1 / x).verdict.domain == "x != 0"


def test_floors_that_stay_in_slopes_leave_the_theorem_open():
    claims = {"measure": 1, "integrable": "Euler-Jacobi"}
    sloped = plane(integrals={"a": v, "b": w * sp.floor(w)}, **claims)
    assert only(sloped, "integrable").verdict.undecided
    shifted = plane(integrals={"a": v, "b": w - sp.floor(v) / 2}, **claims)
    assert only(shifted, "integrable").verdict.proved


def test_pieces_are_the_expression_on_each_side():
    import symengine as se

    s, u = se.symbols("s u")
    (whole,) = pieces_of([s**2 + u])
    assert whole.sides == () and whole.exprs == (s**2 + u,)
    found = {p.sides: p.exprs for p in pieces_of([s + se.sqrt(s**2), se.sign(s * u)])}
    assert len(found) == 4
    for sides, (first, second) in found.items():
        signs = dict(sides)
        assert (first - s * (1 + signs[s])).expand() == 0 and second == signs[s] * signs[u]


def test_nothing_is_proved_of_the_motion_of_a_system_that_has_none():
    motion = vo.Quadratures({r: x}, {p: v, a: w}, p**2, {x: p, y: a})

    def verdicts(**forces):
        return [c.verdict for c in check_motion(Motions.of(plane(motion=motion, **forces)))]

    assert all(found.proved for found in verdicts())
    unreal = verdicts(forces={y: sp.sqrt(-1 - y**2)})
    assert not any(found.proved for found in unreal)
    assert unreal[0].refuted and "no motions" in unreal[0].method
