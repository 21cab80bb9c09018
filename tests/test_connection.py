"""The connection and its curvature: identities of geometry, and examples done by hand."""

from __future__ import annotations

import itertools

import pytest
import sympy as sp

import voronec as vo
from voronec import Fibration, Frame, System, prove_equal, time, velocity

x, y, z, s, phi, theta = sp.symbols("x y z s phi theta")
Dx, Dy, Dz, Ds, Dphi, Dtheta = map(velocity, (x, y, z, s, phi, theta))
v, w = sp.symbols("v w")


def chain(base, fibre, constraints):
    kinetic = sum(velocity(c) ** 2 for c in base + fibre) / 2
    system = System("chain", Fibration(base, fibre), kinetic, constraints)
    eqs = vo.derive(system)
    return eqs.kind, eqs.growth, eqs.integrable


u = sp.Symbol("u")
GROWTH = {
    "contact": ((x, y), (z,), (Dz - y * Dx,), ("chaplygin", (2, 3), ())),
    "Heisenberg": ((x, y), (z,), (2 * Dz - x * Dy + y * Dx,), ("chaplygin", (2, 3), ())),
    "Martinet": ((x, y), (z,), (Dz - y**2 * Dx,), ("chaplygin", (2, 3), ())),
    "Engel": ((x, y), (z, s), (Dz - y * Dx, Ds - z * Dx), ("voronec", (2, 3, 4), ())),
    "Cartan": (
        (x, y), (z, s, u), (Dz - y * Dx, Ds - z * Dx, velocity(u) - y**2 * Dx),
        ("voronec", (2, 3, 5), ()),
    ),
    "disc": (
        (phi, theta), (x, y), (Dx - sp.cos(phi) * Dtheta, Dy - sp.sin(phi) * Dtheta),
        ("chaplygin", (2, 3, 4), ()),
    ),
    "gradient": ((x, y), (z,), (Dz - y * Dx - x * Dy,), ("holonomic", (2,), (0,))),
    "integrating factor": (
        (x, y), (z,), (x * Dz - z * Dx + x * z * Dy,), ("holonomic", (2,), (0,)),
    ),
    "one of two": ((x, y), (z, s), (Dz - y * Dx, Ds - x * Dx), ("chaplygin", (2, 3), (1,))),
    "hidden in a sum": (
        (x, y), (z, s), (Dz - y * Dx + Ds - x * Dx, Ds - x * Dx), ("chaplygin", (2, 3), (1,)),
    ),
    "on the other constraint": ((x,), (y, z), (Dy, Dz - y * Dx), ("holonomic", (1,), (0, 1))),
    "moving, integrable": ((x,), (y,), (Dy - time * Dx - x,), ("holonomic", (2,), (0,))),
    "moving": ((x,), (y,), (Dy - time * Dx,), ("chaplygin", (2, 3), ())),
    "affine": ((x,), (y,), (Dy - x,), ("chaplygin", (2, 3), ())),
    "affine in the fibre": ((x,), (y,), (Dy - x * y,), ("voronec", (2, 3), ())),
    "steady": ((x,), (y,), (Dy - 1,), ("holonomic", (2,), (0,))),
    "no fibre": ((x, y), (), (), ("holonomic", (2,), ())),
}  # fmt: skip


@pytest.mark.parametrize("case", GROWTH.values(), ids=GROWTH)
def test_kind_growth_and_integrable_constraints(case):
    *definition, expected = case
    assert chain(*definition) == expected


# Two constraints over two base coordinates: a depends on base, fibre and time, with a free term.
COEFFICIENTS = sp.Matrix([[y * s + time, sp.sin(x) * z], [x * time * z, sp.cos(s) + y**2]])
OFFSET = sp.Matrix([x * s, z * y + time**2])


def twisted(frame=None, fibration=None, constraints=None, lagrangian=None):
    rates = COEFFICIENTS * sp.Matrix([Dx, Dy]) + OFFSET
    return System(
        name="twisted",
        fibration=fibration or Fibration((x, y), (z, s)),
        lagrangian=lagrangian or (Dx**2 + Dy**2 + Dz**2 + Ds**2) / 2,
        constraints=constraints or (Dz - rates[0], Ds - rates[1]),
        frame=frame,
    )


def paper_curvature():
    """A_ij^(nu) and A_i^(nu) as printed: partial derivatives, and those along the fibre."""
    base, fibre, a, a0 = (x, y), (z, s), COEFFICIENTS, OFFSET

    def total(expr, i):
        return expr.diff(base[i]) + sum(expr.diff(f) * a[m, i] for m, f in enumerate(fibre))

    def in_time(expr):
        return expr.diff(time) + sum(expr.diff(f) * a0[m] for m, f in enumerate(fibre))

    space = {
        (n, i, j): total(a[n, i], j) - total(a[n, j], i)
        for n, i, j in itertools.product(range(2), repeat=3)
    }
    return space, {(n, i): in_time(a[n, i]) - total(a0[n], i) for n in range(2) for i in range(2)}


def test_curvature_is_the_papers_formula():
    found = vo.derive(twisted()).curvature
    space, in_time = paper_curvature()
    for index, expected in space.items():
        assert prove_equal(found[index], expected).proved
    for index, expected in in_time.items():
        assert prove_equal(found.time[index], expected).proved


def test_curvature_is_antisymmetric_and_does_not_see_the_frame():
    frame = Frame.quasi({v: Dx * (2 + sp.cos(y)) + Dz + time, w: Dy - s * Dx})
    plain, framed = vo.derive(twisted()).curvature, vo.derive(twisted(frame)).curvature
    for n, i, j in itertools.product(range(2), repeat=3):
        assert prove_equal(plain[n, i, j], -plain[n, j, i]).proved
        assert prove_equal(plain[n, i, j], framed[n, i, j]).proved


SIMPLE = System(
    name="simple",
    fibration=Fibration((x, y), (z,)),
    lagrangian=(Dx**2 + Dy**2 + Dz**2) / 2,
    constraints=(Dz - (y * z + time) * Dx - x * z,),
    frame=Frame.quasi({v: Dx * sp.exp(y) - z, w: Dy + x * Dx}),
)


def lift(eqs):
    """h_1, h_2, h_0 as columns over (x, y, z, t), read off the rates."""
    columns = []
    for one in (*eqs.velocities, None):
        rest = eqs.rates.xreplace(dict.fromkeys(eqs.velocities, sp.Integer(0)))
        column = list(rest if one is None else eqs.rates.diff(one))
        columns.append([*column, sp.Integer(int(one is None))])
    return columns


def bracket(p, r):
    names = (x, y, z, time)
    return [
        sum(p[m] * r[c].diff(n) - r[m] * p[c].diff(n) for m, n in enumerate(names))
        for c in range(4)
    ]


def test_brackets_are_what_they_are_called():
    """[h_i, h_j] = c_ij^k h_k + B_ij^A d_A, the time among i and j."""
    eqs = vo.derive(SIMPLE)
    h, c, b = lift(eqs), eqs.brackets.c, eqs.brackets.B
    for i, j in itertools.product(range(3), repeat=2):
        left = bracket(h[i], h[j])
        right = [sum(c[k, i, j] * h[k][m] for k in range(2)) for m in range(4)]
        right[2] += b[0, i, j]
        assert all(prove_equal(p, r).proved for p, r in zip(left, right, strict=True))
        assert prove_equal(b[0, i, j], -b[0, j, i]).proved


def test_bianchi():
    """Cyclic sum of [h_i, [h_j, h_k]] = 0, its fibre part written with c and B."""
    eqs = vo.derive(SIMPLE)
    h, c, b = lift(eqs), eqs.brackets.c, eqs.brackets.B
    names = (x, y, z, time)

    def along(i, expr):
        return sum(h[i][m] * expr.diff(n) for m, n in enumerate(names))

    total = sp.Integer(0)
    horizontal = [sp.Integer(0)] * 2
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        # [h_i, c_jk^l h_l + B_jk d_z]; [h_i, d_z] = -d_z(h_i)
        total += along(i, b[0, j, k]) + sum(c[m, j, k] * b[0, i, m] for m in range(2))
        slope = [h[i][m].diff(z) for m in range(4)]
        duals = horizontal_parts(slope)
        total -= b[0, j, k] * (slope[2] - sum(d * h[m][2] for m, d in enumerate(duals)))
        for p in range(2):
            horizontal[p] += along(i, c[p, j, k]) + sum(c[m, j, k] * c[p, i, m] for m in range(2))
            horizontal[p] -= b[0, j, k] * duals[p]
    assert all(prove_equal(e, 0).proved for e in (total, *horizontal))


def horizontal_parts(field):
    """The coefficients of h_1, h_2 of a field: the frame's forms on its base part."""
    return [field[0] * sp.exp(y), field[1] + x * field[0]]


def test_curvature_is_a_tensor_under_a_change_of_frame():
    """B(h_i, h_j) in one frame is E_i^b E_j^c of that in the other, the time included."""
    frame = vo.derive(SIMPLE)
    plain = vo.derive(System(SIMPLE.name, SIMPLE.fibration, SIMPLE.lagrangian, SIMPLE.constraints))
    h, b, coordinate = lift(frame), frame.brackets.B, plain.brackets.B
    weights = [[column[0], column[1], column[3]] for column in h]
    for i, j in itertools.combinations(range(3), 2):
        expected = sum(
            weights[i][p] * weights[j][q] * coordinate[0, p, q]
            for p, q in itertools.product(range(3), repeat=2)
        )
        assert prove_equal(b[0, i, j], expected).proved


def test_curvature_is_a_tensor_under_a_change_of_fibre_coordinates():
    """S = z exp(x) + t: B^S = dS/dz B^z, and the motion is the same motion."""
    eqs = vo.derive(twisted())
    change = {z: (w - time) * sp.exp(-x)}
    rate = (velocity(w) - 1) * sp.exp(-x) - (w - time) * sp.exp(-x) * Dx

    def moved(expr):
        return expr.xreplace({Dz: rate}).xreplace(change)

    system = twisted(
        fibration=Fibration((x, y), (w, s)),
        constraints=tuple(moved(c) for c in twisted().constraints),
        lagrangian=moved(twisted().lagrangian),
    )
    other = vo.derive(system)
    for one, two, scale in ((eqs.curvature[0, 0, 1], other.curvature[0, 0, 1], sp.exp(x)),
                            (eqs.curvature[1, 0, 1], other.curvature[1, 0, 1], 1),
                            (eqs.curvature.time[0, 0], other.curvature.time[0, 0], sp.exp(x)),
                            (eqs.curvature.time[1, 1], other.curvature.time[1, 1], 1)):  # fmt: skip
        assert prove_equal(two, (one * scale).xreplace(change)).proved
    half = sp.Rational(1, 2)
    point = {x: half, y: -2, s: 3, Dx: 1, Dy: half, time: half}
    there = point | {w: sp.exp(half) * 5 + half}
    one, two = eqs.acceleration(point | {z: 5}, 40), other.acceleration(there, 40)
    assert all(abs(one[n] - two[n]) < 1e-34 * (1 + abs(one[n])) for n in (x, y, s))


def test_integrable_constraints_have_no_curvature():
    surface = x * sp.sin(y) + time * x + y**2
    total = surface.diff(x) * Dx + surface.diff(y) * Dy + surface.diff(time)
    system = System("surface", Fibration((x, y), (z,)), (Dx**2 + Dy**2 + Dz**2) / 2, (Dz - total,))
    eqs = vo.derive(system)
    assert eqs.kind == "holonomic" and eqs.integrable == (0,)
    assert not any(sp.flatten(eqs.curvature.space)) and not any(sp.flatten(eqs.curvature.time))
