"""The straight-line form is the form it is made from, on systems of every kind."""

from __future__ import annotations

import flint
import pytest
import sympy as sp

import voronec as vo
from voronec.algebra.points import sample_evaluable
from voronec.algebra.tape import Tape
from voronec.equations.definition import read
from voronec.equations.derivation import Derivation, FirstOrderForm
from voronec.equations.program import Program
from voronec.equations.referee import multiplier_acceleration
from voronec.equations.staged_equations import staged_form

BITS = 400
x, y, z, a, b, k = sp.symbols("x y z a b k")
W, U = sp.symbols("w u")
X, Y, Z, A, B = map(vo.velocity, (x, y, z, a, b))
PLAIN = sp.sqrt(1 + X**2 + Y**2 + (1 + x**2) * Z**2 + sp.cos(y) * X * Z) - k * x * sp.sin(z)
TURNING = (X**2 + Y**2 + (2 + sp.sin(a)) * A**2 + B**2 + A * B * sp.cos(b)) / 2 - k * sp.cos(b)
TURNED = sp.cos(a) * X + sp.sin(a) * Y


def systems() -> dict[str, vo.System]:
    t, constant = vo.time, (vo.Parameter(k, 2),)
    moving = vo.Fibration(base=(a, b), fibre=(x, y))
    rolling = (TURNED - sp.cos(b) * B - t, sp.cos(a) * Y - sp.sin(a) * X + t * sp.sin(b) * A)
    round_ = vo.Fibration(base=(x, y), fibre=(z,), relations=(x**2 + y**2 - 1 - t / 9,))
    return {
        "not quadratic": vo.System(
            name="general", fibration=vo.Fibration(base=(x, y), fibre=(z,)), lagrangian=PLAIN,
            constraints=(Z - y * X - sp.sin(x) * Y,), parameters=constant,
            forces={x: -Y * Z, z: k * Z**2 + X},
        ),
        "affine in time": vo.System(
            name="affine", fibration=moving, lagrangian=TURNING + t * X * A,
            constraints=rolling, parameters=constant, forces={a: -k * B * X},
        ),
        "frame": vo.System(
            name="framed", fibration=moving, lagrangian=TURNING, constraints=rolling,
            frame=vo.Frame.quasi({sp.Symbol("w"): A + sp.cos(b) * B, sp.Symbol("u"): B + x}),
            parameters=constant,
        ),
        "constraints on quasi-velocities": vo.System(
            name="shorthand", fibration=moving, lagrangian=TURNING,
            constraints=(TURNED - sp.cos(b) * W, sp.cos(a) * Y - sp.sin(a) * X + x * U),
            frame=vo.Frame.quasi({W: A + sp.cos(b) * B, U: B + sp.sin(a) * A}),
            parameters=constant,
        ),
        "redundant": vo.System(
            name="redundant", fibration=round_, lagrangian=(X**2 + Y**2 + Z**2) / 2 - k * x * z,
            constraints=(Z - x * Y + y * X,),
            frame=vo.Frame.quasi({sp.Symbol("w"): x * Y - y * X}), parameters=constant,
        ),
    }  # fmt: skip


def results(form: FirstOrderForm) -> list[object]:
    return [*form.rates, *form.force, *(e for row in form.mass for e in row)]


@pytest.mark.parametrize("kind", systems())
def test_equals_the_raw_form(kind: str) -> None:
    definition = read(systems()[kind])
    raw = Derivation(definition, False)
    lean = staged_form(raw)
    wanted = results(raw.form)
    given = Tape([*wanted, *definition.velocities, *definition.parameters, definition.time])
    samples = sample_evaluable(given, definition.relations, BITS)
    assert samples
    for point, values in samples:
        known = dict(point)
        for name, expr in lean.stages:
            known[name] = Tape([expr]).arb(known, BITS)[0]
        found = Tape(results(lean)).arb(known, BITS)
        with flint.ctx.workprec(BITS):
            for left, right in zip(values, found, strict=False):
                assert abs(left - right) < flint.arb(10) ** -50


def test_equals_the_multipliers() -> None:
    system = systems()["affine in time"]
    form = staged_form(Derivation(read(system), False))
    point = {"a": "0.3", "b": "0.7", "x": "0.2", "y": "-0.4", "adot": "1.1", "bdot": "-0.6"}
    point |= {"k": "2", "t": "0.9"}
    known = {name: sp.Rational(value) for name, value in point.items()}
    block = Program.of(form).derivative
    values = dict(known)
    for name, expr in block.assignments:
        values[str(name)] = Tape([expr]).arb(values, BITS)[0]
    found = Tape(block.results).arb(values, BITS)[-2:]
    wanted = multiplier_acceleration(system, known, digits=40)
    for q, value in zip((a, b), found, strict=True):
        assert abs(sp.Float(value.str(45, radius=False), 45) - wanted[q]) < 1e-35


def test_a_coordinate_that_cancels_is_gone() -> None:
    plane = vo.System(
        name="plane", fibration=vo.Fibration(base=(a, b), fibre=(x, y)), lagrangian=TURNING.subs(
            sp.sin(a), 0), constraints=(X - sp.cos(a) * B, Y - sp.sin(a) * B),
        parameters=(vo.Parameter(k, 2),),
    )  # fmt: skip
    form = staged_form(Derivation(read(plane), False))
    inner = dict(form.stages)
    stack, seen = [*form.force, *(e for row in form.mass for e in row)], set()
    while stack:
        free = stack.pop().free_symbols
        seen |= free
        stack += [inner[s] for s in free if s in inner]
    assert "a" not in map(str, seen)
