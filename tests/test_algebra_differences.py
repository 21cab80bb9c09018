"""Forms in differences of angles: short where the angles matter only so, and always equal."""

from __future__ import annotations

import random
from math import isclose

import pytest
import symengine as se
import sympy as sp

import voronec as vo
from voronec.algebra.normal import shorten
from voronec.algebra.terms import atoms

a, b, c, d, k, r = sp.symbols("a b c d k r")


def size(expr):
    return sp.count_ops(expr)


@pytest.mark.parametrize(
    ("long", "short"),
    [
        (sp.cos(a) * sp.cos(b) + sp.sin(a) * sp.sin(b), sp.cos(a - b)),
        (sp.cos(a) * sp.cos(b) - sp.sin(a) * sp.sin(b), sp.cos(a + b)),
        (sp.sin(a) * sp.cos(b) - sp.cos(a) * sp.sin(b), sp.sin(a - b)),
        (k * sp.cos(a - b) * sp.cos(b - c), k * sp.cos(a - b) * sp.cos(b - c)),
        (sp.cos(a + b - c), sp.cos(a + b - c)),
        (sp.cos(a - b) * r + sp.cos(c - d), r * sp.cos(a - b) + sp.cos(c - d)),
        (1 / (2 + sp.cos(a - b)), 1 / (sp.cos(a - b) + 2)),
    ],
)
def test_products_become_functions_of_differences(long, short):
    (found,) = shorten([sp.expand_trig(long)])
    assert sp.simplify(found - short) == 0
    assert size(found) <= size(short) + 1


def test_a_chain_goes_from_one_difference_to_the_next():
    chain = (3 + sp.cos(a - b) ** 2 * (1 + k * sp.cos(b - c) ** 2 * sp.sin(c - d))) * r
    (found,) = shorten([sp.expand_trig(chain)])
    assert size(found) <= size(chain) + 4
    assert vo.prove_equal(found, chain).proved


@pytest.mark.parametrize(
    "expr",
    [
        sp.cos(a) * sp.cos(b) + sp.sin(a) * sp.sin(b) * 2,  # of both angles
        sp.cos(a) * sp.cos(b) * a + sp.sin(a) * sp.sin(b) * a,  # an angle stands outside too
        sp.cos(a) * sp.sqrt(2 + sp.cos(b)) + sp.sin(a) * sp.sin(b),
    ],
)
def test_what_needs_all_of_its_angles_stays_in_them(expr):
    (found,) = shorten([expr])
    assert found.atoms(sp.cos, sp.sin) <= {f(x) for f in (sp.sin, sp.cos) for x in (a, b)}
    assert vo.prove_equal(found, expr).proved


@pytest.mark.slow
def test_random_polynomials_in_differences_keep_their_value():
    dice = random.Random(4)
    for _ in range(12):
        angles = dice.sample((a, b, c), 3)
        terms = [
            dice.randint(-3, 3) * k ** dice.randint(0, 1)
            * dice.choice((sp.sin, sp.cos))(angles[0] - angles[1]) ** dice.randint(0, 2)
            * dice.choice((sp.sin, sp.cos))(angles[1] + dice.choice((1, -1)) * angles[2])
            for _ in range(3)
        ]  # fmt: skip
        expr = sp.Add(*terms)
        (found,) = shorten([sp.expand_trig(expr)])
        at = {s: sp.Rational(dice.randint(-90, 90), 37) for s in (a, b, c, k)}
        assert isclose(found.subs(at).evalf(30), expr.subs(at).evalf(30), abs_tol=1e-25)


def test_the_equations_of_a_robot_with_trailers_are_short():
    equations = vo.derive(vo.load("robot-with-two-trailers"))
    moved, force = str(equations.mass[0, 0]), str(equations.force[0])
    assert len(moved) < 150 and "theta0 - theta1" in moved  # 1091 in the headings themselves
    assert len(force) < 1000  # 6372
    headings = {sp.Symbol(f"theta{i}") for i in range(3)}
    bare = equations.force[0].atoms(sp.sin, sp.cos)
    assert all(len(f.args[0].free_symbols & headings) == 2 for f in bare)


def test_parts_that_sums_share_are_looked_at_once():
    """Written out there are 2^90 of them."""
    nest = x = se.Symbol("x")
    for _ in range(90):
        nest = se.sin(nest) + se.cos(nest)
    assert len(atoms([nest], se.sin)) == 90 and atoms([nest], se.sin, se.Symbol) > {x}
    assert atoms([nest], se.Derivative) == set()
