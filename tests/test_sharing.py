"""Programs with fewer operations: equal to those they come from, regular where these are."""

from __future__ import annotations

import random
import zlib
from typing import Any

import pytest
import symengine as se
import sympy as sp
from tool_modules import tool

import voronec as vo
from voronec.equations.program import (
    Block,
    Program,
    compile_program,
    operation_count,
    shorten_program,
)

bench = tool("figures.mechanics")
a, b, c, x, y = se.symbols("a b c x y")


def program(*rates: Any) -> Program:
    """A program of the rates of as many coordinates."""
    state = (x, y)[: len(rates)]
    none = Block((), ())
    return Program(se.Symbol("t"), state, (), (a, b, c), Block((), rates), (), none)


def values(block: Block, point: dict[Any, Any]) -> list[sp.Expr]:
    """The results, assignment by assignment, in exact numbers or in 40 digits."""
    known = dict(point)
    for name, expr in block.assignments:
        known[name] = sp.N(sp.sympify(expr.xreplace(known)), 40)
    return [sp.N(sp.sympify(e.xreplace(known)), 40) for e in block.results]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sleigh", "demchenko", "falling-disc", "rattleback"])
def test_shorter_programs_compute_the_same(name: str) -> None:
    long = Program.of(vo.derive(vo.load(name)).form)
    short = shorten_program(long)
    assert operation_count(short.derivative.expressions) < operation_count(
        long.derivative.expressions
    )
    dice = random.Random(zlib.crc32(name.encode()))
    given = (*long.state, *long.parameters)
    numbers = [dice.uniform(0.5, 1.5) for _ in given]
    state, parameters = numbers[: len(long.state)], numbers[len(long.state) :]
    found = [compile_program(p, scalar=True)[0](0.0, state, parameters) for p in (long, short)]
    assert found[0] == pytest.approx(found[1], rel=1e-13, abs=1e-13)


def test_a_quotient_is_not_turned_over() -> None:
    """a/(x y) and b x y/a are both regular at their own places: neither is made of the other."""
    short = shorten_program(program(a / (b * x) * c, a / (b * x) * y)).derivative
    at = dict.fromkeys((b, c, x, y), se.Integer(2)) | {a: se.Integer(0)}
    assert values(short, at) == [0, 0]
    turned = shorten_program(program(a * c / x, x * c / a)).derivative
    assert values(turned, {a: se.Integer(0), x: se.Integer(2), c: se.Integer(3)})[0] == 0


def test_common_factors_of_sums_are_found() -> None:
    square = a**2 - 4 * a * b + 4 * b**2
    short = shorten_program(program(c * square + x, (a - 2 * b) * y)).derivative
    assert operation_count(short.expressions) == 6  # a - 2 b is computed once, and squared


def test_products_of_two_sums_are_not_written_out() -> None:
    """(a - b)(x - y) is exact to the last digits where a b x y are close; its terms are not."""
    short = shorten_program(program((a - b) * (x - y) * c, (a - b) * (x - y)))
    at = {a: 1.0 + 1e-9, b: 1.0, x: 1.0 + 1e-9, y: 1.0, c: 1.0}
    known: dict[Any, Any] = {s: se.RealDouble(v) for s, v in at.items()}
    for name, expr in short.derivative.assignments:
        known[name] = expr.xreplace(known)
    exact = (at[a] - at[b]) * (at[x] - at[y])
    assert float(short.derivative.results[1].xreplace(known)) == pytest.approx(exact, rel=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["rolling_disc", "chaos_pendulum", pytest.param("four_bar_linkage", marks=pytest.mark.slow)],
)
def test_half_of_the_operations_of_rhs_after_cse(name: str) -> None:
    method = bench.MODELS[name]()
    method.kanes_equations()
    equations = vo.derive(vo.from_mechanics(method))
    assert 2 * bench.program(equations, method) <= bench.cse_operations(method)
