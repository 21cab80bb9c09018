"""Products and derivatives of ``kinematics``: SymPy's, without the questions that it asks."""

import pytest
import sympy as sp

from voronec import Fibration, System, kinematics, velocity
from voronec.errors import DefinitionError

x, y, z = sp.symbols("x y z")
P = sp.Function("P")(x)


def test_products_of_matrices_are_those_of_sympy():
    turn = kinematics.Rotation.euler("zxz", x, y, z).matrix
    moved = sp.Matrix([P, sp.Integer(0), x + y])
    assert kinematics.matrix_product(turn, turn.T, moved) == turn * turn.T * moved
    assert kinematics.matrix_product([[x, 0], [y, 1]], (y, z)) == sp.Matrix([x * y, y**2 + z])
    with pytest.raises(DefinitionError, match="2 columns meet 1 rows"):
        kinematics.matrix_product([[x, y]], [[x, y]])
    assert kinematics.dot(moved, moved) == moved.dot(moved)
    column = turn.col(1)
    assert kinematics.cross(column, moved) == tuple(column.cross(moved))


def test_products_do_not_ask_whether_entries_are_finite():
    entry = sp.Symbol("asked_1") * sp.Symbol("asked_2") + sp.Symbol("asked_3")
    kinematics.matrix_product(sp.eye(3), (entry, 0, entry))
    kinematics.cross((entry, 0, 0), (0, entry, 0))
    assert "finite" not in entry._assumptions
    sp.eye(3) * sp.Matrix([entry, 0, entry])
    assert "finite" in entry._assumptions  # SymPy's product does


def test_derivatives_are_those_of_sympy():
    functions = (
        x * sp.sin(x * y) ** 3 / sp.sqrt(1 + x**2 * P),
        sp.exp(-x) * P.diff(x) ** 2 + sp.atan2(x, y) + x**y,
        (1 + x) ** sp.cos(x),
        sp.Function("f")(x**2, y),
        y + sp.pi,
    )
    for function in functions:
        for name in (x, y):
            assert sp.srepr(kinematics.derivative(function, name)) == sp.srepr(function.diff(name))


@pytest.mark.parametrize(
    ("function", "slope"),
    [
        (sp.Abs(x * y), y * sp.sign(x * y)),
        (sp.atan2(y, sp.Abs(x)), -y * sp.sign(x) / (x**2 + y**2)),
        (y ** sp.Abs(x), y ** sp.Abs(x) * sp.log(y) * sp.sign(x)),
        (x * sp.Max(x, y), sp.Max(x, y) + x * (1 + sp.sign(x - y)) / 2),
        (sp.Piecewise((sp.Abs(x), y > 0), (x * sp.sign(x), True)), sp.sign(x)),
        (sp.Mod(x, y), 1),
    ],
)  # fmt: skip
def test_derivatives_are_those_of_real_variables(function, slope):
    found = kinematics.derivative(function, x)
    assert not found.has(sp.re, sp.im, sp.Derivative)
    sides = [{x: a, y: b} for a in (-0.7, 1.3) for b in (0.4, 1.9)]
    assert all(abs((found - slope).subs(at).n()) < 1e-12 for at in sides)


def test_names_in_shared_parts_are_looked_for_once():
    shared = x
    for _ in range(60):  # 2^60 paths lead to x
        shared = sp.Function("f")(shared, shared)
    kinetic = [velocity(q) ** 2 / 2 for q in (x, y)]
    System("shared", Fibration(base=(x,)), kinetic[0], forces={x: shared})
    with pytest.raises(DefinitionError, match="the force on 'y' contains 'x', which is neither"):
        System("shared", Fibration(base=(y,)), kinetic[1], forces={y: shared})


def test_what_a_body_asks_for_again_is_made_once():
    assert kinematics.Surface.sphere(1, x, y) is kinematics.Surface.sphere(sp.Integer(1), x, y)
    angles = (x, y, z)
    assert kinematics.Rotation.euler("zyx", *angles) is kinematics.Rotation.euler("zyx", *angles)


@pytest.mark.parametrize(
    ("read", "words"),
    [
        (lambda: kinematics.cross(sp, 1), "neither a vector nor a matrix"),
        (lambda: kinematics.cross((1, 2, 3), (1, 2, range(3))), "of kind range"),
        (lambda: kinematics.cross((x, y), (x, y, z)), "2 components; give three"),
        (lambda: kinematics.dot((x, y), (x,)), "2 components meets one of 1"),
        (lambda: kinematics.dot((object(),), (x,)), "write a sympy expression"),
        (lambda: kinematics.matrix_product([[x, y], [z]], (x, y)), "not as long as one another"),
        (lambda: kinematics.derivative(x, 3), "'3' is no symbol"),
    ],
)
def test_what_is_no_vector_is_refused(read, words):
    with pytest.raises(DefinitionError, match=words):
        read()
