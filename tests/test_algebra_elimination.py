"""Linear equations whose coefficients are expressions: solved exactly, or told why not."""

from __future__ import annotations

import pytest
import symengine as se
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from voronec import EngineLimit
from voronec.algebra.elimination import solve_linear
from voronec.algebra.rank import independent_rows, proved_rank
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import decide_equal, decide_zero

x, y, z = se.symbols("x y z")
ONE = se.sin(x) ** 2 + se.cos(x) ** 2
NIL = ONE - 1
DOUBLE = se.sin(2 * x) - 2 * se.sin(x) * se.cos(x)


def residuals(rows, right, solution, skip=()):
    for i, row in enumerate(rows):
        if i in skip:
            continue
        for c, target in enumerate(right[i]):
            total = se.Add(*[e * v[c] for e, v in zip(row, solution.values, strict=True)])
            yield total, target


def solves(rows, right, solution, relations=(), skip=()):
    pairs = residuals(rows, right, solution, skip)
    return all(decide_equal(a, b, relations).proved for a, b in pairs)


def column(*entries):
    return [[se.sympify(e)] for e in entries]


def solved(rows, right, relations=(), **options):
    rows = [[se.sympify(e) for e in row] for row in rows]
    right = [[se.sympify(e) for e in row] for row in right]
    return rows, right, solve_linear(rows, right, relations, **options)


def test_a_full_system_with_three_right_sides():
    rows = [[x, se.sin(y), 1], [se.cos(y), x * z, 0], [1, 0, se.exp(x)]]
    right = [[1, x, 0], [0, y, se.sin(x)], [z, 1, x]]
    rows, right, found = solved(rows, right)
    assert (found.free, found.dependent, found.contradictory) == ((), (), ())
    assert solves(rows, right, found)


def test_each_step_subtracts_the_multiple_it_should():
    """Three steps, every entry full: a shadow that drifts from its entry would be caught here.

    After two steps the last pivot is 1/6 of x^2, and the second one a hidden zero at first sight.
    """
    rows = [[2, 3, 4], [5, se.Rational(15, 2) + NIL, 1], [7, 1, x]]
    rows, right, found = solved(rows, column(1, 2, 3))
    assert found.free == () and solves(rows, right, found)
    exact = sp.Matrix([[2, 3, 4], [5, sp.Rational(15, 2), 1], [7, 1, sp.Symbol("x")]])
    expected = exact.LUsolve(sp.Matrix([1, 2, 3]))
    for (value,), known in zip(found.values, expected, strict=True):
        assert decide_equal(value, se.sympify(known)).proved


def test_a_row_that_only_cancels_exactly_is_dependent():
    """Row 3 = (x row 1 + row 2)/3, written so that nothing cancels by itself."""
    rows = [[3, se.sin(2 * x)], [x + 1, y]]
    last = [
        (3 * x + x + 1) / 3,
        (2 * x * se.sin(x) * se.cos(x) + y * ONE) / 3,
    ]
    rows, right, found = solved([*rows, last], column(1, 2, (x + 2) / 3))
    assert len(found.dependent) == 1 and found.contradictory == () == found.free
    assert solves(rows, right, found)


def test_preferred_rows_are_used_first():
    rows = [[x * y + 1, x], [y, x * x], [1, 0], [0, 1]]
    unknown = [se.Integer(2), x]
    right = [[se.Add(*[e * u for e, u in zip(r, unknown, strict=True)])] for r in rows]
    assert set(solved(rows, right, prefer=2)[2].dependent) == {2, 3}
    assert set(solved(rows[::-1], right[::-1], prefer=2)[2].dependent) == {2, 3}


def test_a_contradiction_is_told_from_a_dependence():
    rows = [[1, x], [2, 2 * x * ONE], [x, x**2]]
    *_, found = solved(rows, column(1, 3, x), prefer=1)
    assert found.free in ((0,), (1,))
    assert len(found.dependent) == 1 and len(found.contradictory) == 1
    assert set(found.dependent + found.contradictory) == {1, 2}
    *_, found = solved([[0, 0], [NIL, DOUBLE]], column(DOUBLE, x))
    assert found.dependent == (0,) and found.contradictory == (1,) and found.free == (0, 1)


def test_unknowns_that_nothing_determines_are_free_and_zero():
    rows, right, found = solved([[0, x, 0, y], [NIL, 1, 0, 0]], column(y, 1))
    assert found.free == (0, 2)
    assert found.values[0] == [0] == found.values[2]
    assert solves(rows, right, found)


HIDDEN = {
    "pythagoras": NIL,
    "double angle": DOUBLE,
    "binomial": (x + y) ** 2 - x**2 - 2 * x * y - y**2,
    "root": se.sqrt(x**2 + 2 * x + 2) - se.sqrt((x + 1) ** 2 + 1),
    "fraction": 1 / (x - y) - (x + y) / (x**2 - y**2),
    "hyperbolic": se.cosh(y) ** 2 - se.sinh(y) ** 2 - 1,
}


@pytest.mark.parametrize("zero", HIDDEN.values(), ids=HIDDEN)
def test_a_hidden_zero_is_never_a_pivot(zero):
    rows, right, found = solved([[zero, x], [y, zero]], column(1, 2))
    assert found.free == () and solves(rows, right, found)
    *_, singular = solved([[zero, x], [zero, 1]], column(x, 1))
    assert singular.free == (0,) and len(singular.dependent) == 1
    *_, emerging = solved([[1, y], [x, x * y + zero]], column(1, x))
    assert emerging.free != () and len(emerging.dependent) == 1


def test_a_zero_that_cannot_be_settled_is_no_guess():
    with pytest.raises(EngineLimit, match="undecided"):
        solved([[1, 1], [1, 1 + se.asin(se.sin(x / 10**6)) - x / 10**6]], column(1, 2))


def test_a_tiny_entry_is_a_pivot():
    tiny = se.Integer(1) / se.Integer(10) ** 50
    rows, right, found = solved([[1, 1], [1, 1 + tiny]], column(1, 2))
    assert found.free == () and solves(rows, right, found)
    assert found.values[1] == [1 / tiny]


def test_equations_without_real_values_are_a_limit():
    with pytest.raises(EngineLimit, match="no point"):
        solved([[se.sqrt(-1 - x**2), 1]], column(1))


@pytest.mark.parametrize("entry", [x, se.sin(x), x * y, se.cos(x) - 1])
def test_pivots_avoid_what_vanishes_near_a_point(entry):
    """Both unknown orders solve generically; at x = 0 only the pivot 2 + y does."""
    rows = [[entry, 2 + y], [1 + y * y, entry]]
    at = {"x": 0, "y": se.Rational(1, 3)}
    rows, right, found = solved(rows, column(1, x + y), near=at)
    assert solves(rows, right, found)
    tape = Tape([v[0] for v in found.values])
    assert all(v.is_finite() for v in tape.arb({a: at[str(a)] for a in tape.atoms}, 128))


def test_pivots_that_vanish_later_are_avoided_too():
    """After the first step the second row begins with x, which vanishes at the point; z does not.

    The multiple of the first row is 1/2 there, so a product of 2 and 1 would not see that.
    """
    rows = [[2, 4, 0], [1, 2 + x, z], [y, 3 * y, x]]
    at = {"x": 0, "y": 3, "z": 5}
    rows, right, found = solved(rows, column(1, y, 2), near=at)
    assert solves(rows, right, found)
    values = Tape([v[0] for v in found.values]).arb(at, 128)
    assert all(v.is_finite() for v in values)


def test_a_pivot_that_vanishes_at_the_point_is_better_than_none():
    rows, right, found = solved([[x]], column(y), near={"x": 0})
    assert solves(rows, right, found) and found.free == ()


CIRCLE = x**2 + y**2 - 1


def test_relations_decide_what_vanishes():
    rows = [[x, y], [x * (x**2 + y**2), y]]
    *_, without = solved(rows, column(1, 1))
    rows, right, within = solved(rows, column(1, 1), (CIRCLE,))
    assert without.free == () and without.dependent == ()
    assert len(within.free) == 1 and len(within.dependent) == 1
    assert solves(rows, right, within, (CIRCLE,))
    *_, torn = solved([[x, y], [x * (x**2 + y**2), y]], column(1, 2), (CIRCLE,))
    assert len(torn.contradictory) == 1


def test_the_velocity_on_a_circle():
    """x xdot + y ydot = 0, x ydot - y xdot = w: xdot = -y w, ydot = x w."""
    *_, found = solved([[x, y], [-y, x]], column(0, z), (CIRCLE,))
    for (value,), known in zip(found.values, (-y * z, x * z), strict=True):
        assert decide_equal(value, known, (CIRCLE,)).proved


pool = st.sampled_from(
    [se.Integer(n) for n in (0, 0, 1, -2, 3)] + [x, y, NIL, ONE, x * y, se.sin(x), x + NIL, DOUBLE]
)
small = st.integers(-2, 2)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.lists(pool, min_size=3, max_size=3), min_size=1, max_size=3),
    st.lists(st.lists(small, min_size=3, max_size=3), max_size=2),
    st.lists(pool, min_size=3, max_size=3),
    st.booleans(),
)
def test_the_outcome_is_that_of_the_rank(own, mixtures, unknown, torn):
    """Rows, and combinations of them, against the rank of the matrix in numbers."""
    rows = own + [
        [se.Add(*[k * row[j] for k, row in zip(m, own, strict=False)]) * ONE for j in range(3)]
        for m in mixtures
    ]
    right = [[se.Add(*[e * u for e, u in zip(row, unknown, strict=True)])] for row in rows]
    if torn:
        right[-1] = [right[-1][0] + x]
    found = solve_linear(rows, right)
    numbers = {x: se.Integer(7) / 5, y: se.Integer(-11) / 3}
    values = Tape([e for row in rows for e in row]).arb(numbers, 300)
    table = [values[3 * i : 3 * i + 3] for i in range(len(rows))]
    pivots = 3 - len(found.free)
    assert pivots == proved_rank(table, 300) == len(independent_rows(table, 300))
    assert pivots + len(found.dependent) + len(found.contradictory) == len(rows)
    assert solves(rows, right, found, skip=found.contradictory) or found.contradictory
    assert torn or not found.contradictory
    assert all(decide_zero(v[0]).proved for j, v in enumerate(found.values) if j in found.free)


def test_nothing_to_solve():
    assert solve_linear([], []).values == []
    assert solve_linear([[x, y]], [[]]).free in ((0,), (1,))
