"""Eliminations of matrices that are diagonal plus one product; weights; constants; brackets."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
import pytest
import symengine as se
from hypothesis import given, settings
from hypothesis import strategies as st

from voronec.algebra.brackets import nest_sums
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.program import (
    Program,
    compile_program,
    hoist,
    solve_mass,
    taylor_system,
)
from voronec.equations.program.low_rank import eliminations, low_rank, solve_symmetric
from voronec.equations.program.weight import QUOTIENT, SQUARE, evaluation_weight, taylor_weight

x, y, z, w, a, b, c, d = se.symbols("x y z w a b c d")
ONE = se.Integer(1)


def rolling(scale: Any, diagonal: Any, column: Any) -> list[list[Any]]:
    """diag(diagonal) + scale * column column^T, expanded."""
    return [
        [se.expand(scale * u * v) + (diagonal[i] if i == j else 0) for j, v in enumerate(column)]
        for i, u in enumerate(column)
    ]


def straight(matrix: Any, right: Any, **known: Any) -> tuple[list[tuple[Any, Any]], list[Any]]:
    """Assignments and results of ``solved``."""
    assignments: list[tuple[Any, Any]] = []
    fresh = (se.Symbol(f"n{i}") for i in count())

    def name(expr: Any) -> Any:
        if not expr.args:
            return expr
        assignments.append((next(fresh), expr))
        return assignments[-1][0]

    if known.pop("triangular", False):
        return assignments, solve_symmetric(matrix, right, name)
    return assignments, solve_mass(matrix, right, name, **known)


def values(assignments: Any, results: Any, at: dict[Any, Any]) -> list[Any]:
    """Results with exact numbers put in, one assignment after the other."""
    at = dict(at)
    for name, expr in assignments:
        at[name] = expr.xreplace(at)
    return [se.sympify(r).xreplace(at) for r in results]


whole = st.integers(-4, 4)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(
    points=st.lists(whole, min_size=4, max_size=4),
    right=st.lists(whole, min_size=4, max_size=4),
    inertia=st.lists(st.integers(1, 5), min_size=4, max_size=4),
    shear=st.lists(st.integers(1, 3), min_size=4, max_size=4),
    sign=st.sampled_from([1, -1]),
)
def test_the_solution_is_that_of_the_triangular_elimination_exactly(
    points: Any, right: Any, inertia: Any, shear: Any, sign: int
) -> None:
    column = [k * u for k, u in zip(shear, (x, y, z, w), strict=True)]
    matrix = rolling(sign * a * b**2, [a * i + c for i in inertia], column)
    force = [se.Integer(f) for f in right]
    low = straight(matrix, force, constants=(a, b, c), positive=(a, c))
    full = straight(matrix, force, triangular=True)
    # small enough for both signs to leave the matrix positive
    at = dict(zip((x, y, z, w), points, strict=True))
    at |= {a: ONE, b: ONE / 60, c: ONE / 2}
    found = values(*low, at)
    assert found == values(*full, at)
    numbers = [[e.subs(at) for e in row] for row in matrix]
    assert [se.Add(*map(se.Mul, row, found)) for row in numbers] == force
    weights = [taylor_weight(*both, (a, b, c)) for both in (low, full)]
    assert weights[0] < 0.6 * weights[1]


def test_the_parts_are_recognised_in_expanded_entries() -> None:
    found = low_rank(rolling(-a * b**2, [c, c + d, d], [x, y, z]))
    assert found is not None
    assert (found.diagonal, found.scale, found.column) == (
        (c, c + d, d), -a * b**2, (x, y, z),
    )  # fmt: skip
    # the square of a sine goes into the column, where only sin^2 + cos^2 = 1 shows it
    normal = (se.sin(x) * se.sin(y), se.cos(x) * se.sin(y), se.cos(y))
    angular = low_rank(rolling(-a, [b, b, c], normal))
    assert angular is not None and angular.scale == -a and angular.column == normal


def test_relations_shorten_the_pivot() -> None:
    sphere = [x**2 + y**2 + z**2 - 1]
    found = low_rank(rolling(-a, [b + a] * 3, [x, y, z]), sphere)
    assert found is not None
    assert not found.pivot.free_symbols & {x, y, z}


@pytest.mark.parametrize(
    "matrix",
    [
        [[a, x], [x, b]],
        [[a, x, 0], [x, b, y], [0, y, c]],
        [[a, x, y, z], [x, b, w, x], [y, w, c, y], [z, x, y, d]],
    ],
    ids=["two rows", "a zero", "higher rank"],
)
def test_other_matrices_are_left_alone(matrix: Any) -> None:
    matrix = [[se.sympify(e) for e in row] for row in matrix]
    assert low_rank(matrix) is None
    assert [e.rows for e in eliminations(matrix)] == [tuple(range(len(matrix)))]


@pytest.mark.parametrize("heading", [(0, 1), (1, 0), (3, 4)])
def test_rows_of_multipliers_wait_for_those_with_inertia(heading: tuple[int, int]) -> None:
    """A skate with two rotors: eliminated before y it would divide by x, which may vanish."""
    rows = [[a, 0, 0, 0, x], [0, b, z, z, y], [0, z, c, z, 0], [0, z, z, d, 0], [x, y, 0, 0, 0]]
    matrix = [[se.sympify(e) for e in row] for row in rows]
    at = dict(zip((x, y, a, b, c, d, z), map(se.Integer, (*heading, 2, 3, 5, 7, 1)), strict=True))
    right = [*map(se.Integer, (1, 2, 3, 4, 5))]
    found = values(*straight(matrix, right), at)
    for row, entry in zip(matrix, right, strict=True):
        terms = (e.xreplace(at) * f for e, f in zip(row, found, strict=True))
        assert se.Add(*terms) == entry


def chosen(scale: Any, diagonal: Any, positive: Any) -> bool:
    """Whether the product is eliminated on its own."""
    matrix = rolling(scale, diagonal, [x, y, z])
    (only,) = eliminations(matrix, (a, b, c, d), (), positive)
    return len(only.expressions) == 8


def test_what_is_not_proved_stable_is_refused() -> None:
    inertia = [a + b, 2 * a + b, 3 * a + b]
    assert chosen(-b, inertia, (a, b))
    assert chosen(b, inertia, (a, b))
    assert chosen(-b * c**2, inertia, (a, b)), "an even power has a sign"
    assert not chosen(-b, inertia, (a,)), "b may be negative"
    assert not chosen(-b, [a - b, a + b, a + b], (a, b)), "a - b may vanish"
    assert not chosen(c, inertia, (a, b)), "c may have either sign"
    assert not chosen(-b, [c**2, a, a], (a, b)), "c may be zero"


def test_a_program_knows_a_ball_about_its_contact() -> None:
    names = se.symbols("p q r")
    form = FirstOrderForm(
        coordinates=(x, y, z), velocities=names, parameters=(a, b, c, d), time=se.Symbol("t"),
        rates=tuple(names), mass=tuple(map(tuple, rolling(-d, [a + d, b + d, c + d], [x, y, z]))),
        force=(x * y, y * z, z * x), velocity_symbols=se.symbols("dx dy dz"), definitions=(),
    )  # fmt: skip
    full = Program.of(form)
    low = Program.of(replace(form, positive=(a, b, c, d)))
    # 3 forces, 3 squares, 3 + 3 products with the normal, a quotient
    assert 9 + 3 * SQUARE + QUOTIENT <= low.weight < 9 + 3 * SQUARE + QUOTIENT + 1
    assert full.weight > 1.5 * low.weight
    state, parameters = [0.3, -0.4, 0.5, 1.0, 2.0, 3.0], [0.4, 0.5, 0.7, 1.1]
    one, two = (compile_program(p, scalar=True)[0](0.0, state, parameters) for p in (low, full))
    assert np.allclose(one, two, rtol=1e-14, atol=1e-15)


def test_weights_count_products_of_what_moves_once() -> None:
    def weight(*exprs: Any) -> float:
        return round(taylor_weight((), exprs, (a, b, c)))

    assert weight(x + y - 3 * a * z) == 0
    assert weight(a * b / (a + c) * x + se.sin(a)) == 0
    assert weight(x * y, x * y + 3 * a * z, x * y * z) == 3
    assert taylor_weight((), [x**2], ()) == SQUARE
    assert taylor_weight((), [x / y], ()) == QUOTIENT
    assert taylor_weight((), [x * z / (y * w)], ()) == 2 + QUOTIENT
    sine, both = (taylor_weight((), e, ()) for e in ([se.sin(x)], [se.sin(x), se.cos(x)]))
    assert sine == both > 2
    named = [(d, a + b), (w, x * y)]
    assert round(taylor_weight(named, [d * x, w + d, w * x], (a, b))) == 2


def test_evaluations_weigh_functions_and_quotients_more() -> None:
    assert evaluation_weight([x + y + z, x * y]) == 3
    assert evaluation_weight([x**2]) == 1 and evaluation_weight([x**4]) == 2
    assert evaluation_weight([1 / x]) > evaluation_weight([x * y])
    assert evaluation_weight([se.sin(x), 2 * se.sin(x)]) == evaluation_weight([se.sin(x)]) + 1


@settings(max_examples=40, deadline=None)
@given(
    terms=st.lists(
        st.tuples(whole, st.lists(st.integers(-1, 3), min_size=4, max_size=4)),
        min_size=1, max_size=8,
    )
)  # fmt: skip
def test_brackets_change_nothing_but_the_weight(terms: Any) -> None:
    expr = se.Add(*[
        n * se.Mul(*map(se.Pow, (x, y, z, a), powers)) for n, powers in terms
    ])  # fmt: skip
    short = nest_sums(expr, (a,))
    at = {x: ONE / 3, y: se.Integer(5), z: ONE * 2 / 7, a: se.Integer(11)}
    assert short.subs(at) == expr.subs(at)


def test_brackets_save_products() -> None:
    expr = se.expand(x * y * (a * z + b * w + 2 * x))
    assert taylor_weight((), [nest_sums(expr, (a, b))], (a, b)) < 2.6
    assert taylor_weight((), [expr], (a, b)) > 4


def constants_of(parameters: Any) -> Any:
    form = FirstOrderForm(
        coordinates=(x,), velocities=(y,), parameters=(a, b, c), time=se.Symbol("t"),
        rates=(a / (b + 1) * x + a / (b + 1) * y,), mass=((ONE,),),
        force=(se.sqrt(a) * x * y / c + se.sin(a * b) + a * b,), velocity_symbols=(w,),
        definitions=(),
    )  # fmt: skip
    return Program.of(form, {"speed": 2 * a * b * x}), parameters


def test_constants_are_computed_once_and_give_the_same_motion() -> None:
    program, given_values = constants_of([1.3, 0.7, 2.1])
    raised = hoist(program)
    assert raised.program.parameters[:3] == program.parameters
    extended = raised.values(given_values)
    assert len(extended) == len(raised.program.parameters) == 3 + len(raised.definitions)
    state = [0.4, -0.6]
    for before, after in zip(
        compile_program(program), compile_program(raised.program), strict=True
    ):
        found = after(0.0, state, extended)
        assert np.allclose(found, before(0.0, state, given_values), rtol=1e-14)
    still = set(raised.program.parameters)
    for block in (raised.program.derivative, raised.program.extras):
        nodes = list(block.expressions)
        while nodes:
            node = nodes.pop()
            assert not node.args or node.is_Number or not node.free_symbols <= still, node
            if isinstance(node, se.Mul | se.Add):
                assert sum(f.free_symbols <= still for f in node.args) <= 1, node
            nodes += node.args


def test_a_constant_without_a_value_is_nan_and_the_others_are_kept() -> None:
    program, _ = constants_of(None)
    raised = hoist(program)
    extended = raised.values([1.0, -1.0, 2.0])  # b + 1 = 0
    missing = [math.isnan(v) for v in extended[3:]]
    assert any(missing) and not all(missing)


def test_heyoka_takes_the_raised_program() -> None:
    hy = pytest.importorskip("heyoka")
    program, given_values = constants_of([1.3, 0.7, 2.1])
    raised = hoist(program)
    pairs = taylor_system(raised.program)
    function = hy.cfunc([e for _, e in pairs], vars=[s for s, _ in pairs])
    numbers = raised.values(given_values)[: function.nparams]
    found = function(inputs=np.array([0.4, -0.6]), pars=np.array(numbers))
    expected = compile_program(program)[0](0.0, [0.4, -0.6], given_values)
    assert np.allclose(found, expected, rtol=1e-14)
