"""Points on relations: where they are looked for, and what they start from."""

from __future__ import annotations

import flint
import symengine as se

from voronec.algebra.points import lift_point, sample_point
from voronec.algebra.tape import Tape

x, y = se.symbols("x y")
CURVE = x**3 + y**3 + x * y - 1


def test_a_point_that_was_found_is_found_again_with_more_digits() -> None:
    """A lifted point holds balls, from which the next one starts."""
    first = lift_point({x: flint.fmpq(1, 3), y: flint.fmpq(4, 5)}, (CURVE,), 60)
    second = lift_point(first, (CURVE,), 300)
    for point, digits in ((first, 15), (second, 80)):
        with flint.ctx.workprec(400):
            a, b = (flint.arb(point[s]) for s in (x, y))
            rest = a**3 + b**3 + a * b - 1
            assert rest.contains(0) and rest.rad() < flint.arb(10) ** -digits
    start, end = (flint.arb(point[x]) for point in (first, second))
    assert abs(float(start) - float(end)) < 1e-6


def test_points_depend_on_conditions_and_precision() -> None:
    """What is kept for one question is not given to another."""
    signs = [sample_point([x], conditions, 0)[x] for conditions in ([x < 0], [x > 0])]
    assert signs[0] < 0 < signs[1]
    rough, fine = (sample_point([x, y], [CURVE], 0, bits) for bits in (60, 300))
    balls = [v for v in fine.values() if isinstance(v, flint.arb)]
    assert balls and all(v.rad() < flint.arb(2) ** -250 for v in balls)
    assert any(isinstance(v, flint.arb) and v.rad() > 1e-40 for v in rough.values())
    rough[x] = flint.fmpq(7)
    assert sample_point([x, y], [CURVE], 0, 60)[x] != 7


def test_points_do_not_hang_on_the_order_of_equal_terms() -> None:
    a, b = se.symbols("left right")
    both = [se.Add(*terms) for terms in ((a**2, b**2, -1), (b**2, a**2, -1))]
    assert both[0] == both[1] and both[0].args != both[1].args
    for circle in both:
        assert Tape([circle]).atoms == [a, b]
        point = lift_point({a: flint.fmpq(-1), b: flint.fmpq(1)}, [circle], 100)
        assert point[a] < 0 < point[b]
