"""The connection and its curvature: identities of geometry, and examples done by hand."""

from __future__ import annotations

import itertools
import random
from dataclasses import replace

import numpy as np
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
    return eqs.kind, eqs.growth, eqs.leaves


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
    "gradient": ((x, y), (z,), (Dz - y * Dx - x * Dy,), ("holonomic", (2,), (z - x * y,))),
    "integrating factor": (
        (x, y), (z,), (x * Dz - z * Dx + x * z * Dy,),
        ("holonomic", (2,), (z * sp.exp(y) / x,)),
    ),
    "one of two": (
        (x, y), (z, s), (Dz - y * Dx, Ds - x * Dx), ("chaplygin", (2, 3), (s - x**2 / 2,)),
    ),
    "hidden in a sum": (
        (x, y), (z, s), (Dz - y * Dx + Ds - x * Dx, Ds - x * Dx),
        ("chaplygin", (2, 3), (s - x**2 / 2,)),
    ),
    "difference": (
        (x, y), (z, s), (Dz - y * Dx, Ds - y * Dx), ("chaplygin", (2, 3), (z - s,)),
    ),
    "difference, in another basis": (
        (x, y), (z, s), (Dz - y * Dx, Ds - Dz), ("chaplygin", (2, 3), (s - z,)),
    ),
    "on the other constraint": (
        (x,), (y, z), (Dy, Dz - y * Dx), ("holonomic", (1,), (y, z - x * y)),
    ),
    "moving, integrable": (
        (x,), (y,), (Dy - time * Dx - x,), ("holonomic", (2,), (y - time * x,)),
    ),
    "a moving multiple": ((x,), (y,), (time * (Dy - Dx),), ("holonomic", (1,), (y - x,))),
    "differential where it is divided by a coordinate": (
        (x, y), (z, s), (y * Ds - Dy, Dz - y * Dx), ("chaplygin", (2, 3), (s - sp.log(y),)),
    ),
    "moving": ((x,), (y,), (Dy - time * Dx,), ("chaplygin", (2, 3), ())),
    "affine": ((x,), (y,), (Dy - x,), ("chaplygin", (2, 3), ())),
    "affine in the fibre": ((x,), (y,), (Dy - x * y,), ("voronec", (2, 3), ())),
    "steady": ((x,), (y,), (Dy - 1,), ("holonomic", (2,), (y - time,))),
    "no fibre": ((x, y), (), (), ("holonomic", (2,), ())),
}  # fmt: skip


@pytest.mark.parametrize("case", GROWTH.values(), ids=GROWTH)
def test_kind_growth_and_what_constraints_hold_constant(case):
    *definition, expected = case
    *found, leaves = chain(*definition)
    assert (*found, [e.expand() for e in leaves]) == (*expected[:2], [*expected[2]])


R, L, b, r, d, e = sp.symbols("R L b r d e")
turn = sp.symbols("turn1:7")
left, right, left2, right2, psi, alpha = sp.symbols("left right left2 right2 psi alpha")


def body_velocity(rates, angle):
    """Forward and to the left."""
    (u, w), c, s = rates, sp.cos(angle), sp.sin(angle)
    return c * u + s * w, c * w - s * u


forward, sideways = body_velocity((Dx, Dy), phi)
WHEELS = (forward - b * Dphi - R * velocity(left), forward + b * Dphi - R * velocity(right))


def omnidirectional():
    """Three wheels at 120 degrees (Campion, Bastin, d'Andrea-Novel 1996, type (3,0))."""
    angles = [2 * sp.pi * k / 3 for k in range(3)]
    rows = [
        R * velocity(q) + sp.sin(a) * forward - sp.cos(a) * sideways - L * Dphi
        for q, a in zip(turn, angles, strict=False)
    ]
    return (x, y, phi), turn[:3], rows, [R * sum(turn[:3]) - 3 * L * phi]


def mecanum():
    """Six wheels in two rows, rollers at 45 degrees (Muir, Neuman 1987): place, side, rollers."""
    wheels = ((1, 1, 1), (1, -1, -1), (0, 1, -1), (0, -1, 1), (-1, 1, 1), (-1, -1, -1))
    rows = [
        R * velocity(q) - (forward - side * b * Dphi - way * (sideways + place * L * Dphi))
        for q, (place, side, way) in zip(turn, wheels, strict=True)
    ]
    one, two, three, four, five, six = (R * q for q in turn)
    leaves = [one - five + 2 * L * phi, two - six - 2 * L * phi,
              one - four + (2 * b + L) * phi, three - two + (2 * b + L) * phi]  # fmt: skip
    return (x, y, phi), turn, rows, leaves


def wheeled_pendulum():
    """Two wheels turning in a body that pitches (Pathak, Franch, Agrawal 2005)."""
    rows = [WHEELS[0] - R * velocity(alpha), WHEELS[1] - R * velocity(alpha), sideways]
    return (left, right, alpha), (x, y, phi), rows, [R * (left - right) + 2 * b * phi]


def caterpillar():
    """Two bodies on two wheels each, hinged at the distances d and e from their axles: a tractor
    with a trailer off its axle (Lamiraux, Laumond 1998) whose wheels are counted."""
    rear = (x - d * sp.cos(phi) - e * sp.cos(psi), y - d * sp.sin(phi) - e * sp.sin(psi))
    moving = (x, y, phi, psi)
    speeds = [sum(f.diff(q) * velocity(q) for q in moving) for f in rear]
    ahead, across = body_velocity(speeds, psi)
    turned = b * velocity(psi)
    behind = [ahead - turned - R * velocity(left2), ahead + turned - R * velocity(right2)]
    rows = [*WHEELS, sideways, across, *behind]
    leaves = [R * (left - right) + 2 * b * phi, R * (left2 - right2) + 2 * b * psi]
    return (left, right), (*moving, left2, right2), rows, leaves


def plate_on_balls():
    """A plate on three equal balls on a plane (rolling as in Neimark, Fufaev 1972): a ball's centre
    goes half as fast as the plate above it, so that differences of centres turn half as fast.
    """
    rows, fibre, spins, centres = [], [], [], []
    for i in "123":
        X, Y, p, n, q = sp.symbols(f"X{i} Y{i} psi{i} nu{i} sigma{i}")
        one = velocity(n) * sp.cos(p) + velocity(q) * sp.sin(n) * sp.sin(p)
        two = velocity(n) * sp.sin(p) - velocity(q) * sp.sin(n) * sp.cos(p)
        rows += [velocity(X) - r * two, velocity(Y) + r * one]
        rows += [2 * velocity(X) - Dx + Dphi * (Y - y), 2 * velocity(Y) - Dy - Dphi * (X - x)]
        fibre += [X, Y, n, q]
        spins.append(p)
        centres.append((X, Y))
    away = [(centres[0][0] - X, centres[0][1] - Y) for X, Y in centres[1:]]
    leaves = [part for pair in away for part in body_velocity(pair, phi / 2)]
    return (x, y, phi, *spins), tuple(fibre), rows, leaves


def carriage():
    system = vo.load("two-wheeled-carriage")
    names = {s: sp.Symbol(s.name) for s in system.known_symbols()}
    base, fibre = (tuple(names[q] for q in part) for part in
                   (system.fibration.base, system.fibration.fibre))  # fmt: skip
    return base, fibre, list(system.constraints), [R * (left - right) + 2 * b * phi]


TEXTBOOK = (carriage, omnidirectional, mecanum, wheeled_pendulum, caterpillar, plate_on_balls)


def written_anew(rows, coordinates, seed, moving):
    """Rows times a random matrix with determinant one, ``moving`` if functions are among its
    entries."""
    rng, n = random.Random(seed), len(rows)
    some = (0, 0, 0, 1, -1, 2) + (coordinates[0], sp.cos(coordinates[2])) * moving
    low, up = (sp.Matrix(n, n, lambda i, j: rng.choice(some)) for _ in range(2))
    low, up = low.lower_triangular(-1) + sp.eye(n), up.upper_triangular(1) + sp.eye(n)
    return list(low * up * sp.Matrix(rows))


@pytest.mark.slow
@pytest.mark.parametrize("make", TEXTBOOK)
def test_textbook_constraints_hold_the_known_functions_constant_in_any_basis(make):
    base, fibre, rows, leaves = make()
    q = (*base, *fibre)
    point = {s: sp.Rational(k + 2, 7) for k, s in enumerate((*q, R, L, b, r, d, e))}
    lagrangian = sum(velocity(s) ** 2 for s in q) / 2
    moving = make not in (caterpillar, plate_on_balls)  # these are too large for the solver
    for seed in range(4 if moving else 2):
        turned = written_anew(rows, q, seed, moving) if seed else rows
        names = sorted({s for f in rows for s in f.free_symbols} - {*q, *map(velocity, q)}, key=str)
        system = System("textbook", Fibration(base, fibre), lagrangian, turned, parameters=names)
        eqs = vo.derive(system)
        assert len(eqs.integrable) == len(eqs.leaves) == len(leaves)
        assert eqs.growth[-1] + len(leaves) == len(q)  # by brackets, which share no code with forms
        slopes = sp.Matrix([[f.diff(s) for s in q] for f in (*leaves, *eqs.leaves)])
        forms = sp.Matrix([[f.diff(velocity(s)) for s in q] for f in eqs.integrable])
        numbers = np.array(slopes.col_join(forms).xreplace(point).evalf().tolist(), dtype=float)
        assert np.linalg.matrix_rank(numbers) == len(leaves)
        assert np.linalg.matrix_rank(numbers[len(leaves) : 2 * len(leaves)]) == len(leaves)


@pytest.mark.slow
def test_leaves_are_integrals_that_check_proves_and_a_search_finds():
    base, fibre, rows, _ = plate_on_balls()
    lagrangian = sum(velocity(s) ** 2 for s in (*base, *fibre)) / 2
    system = System("plate", Fibration(base, fibre), lagrangian, rows, parameters=(r,))
    leaves = vo.derive(system).leaves
    claimed = replace(system, integrals={f"leaf {i}": f for i, f in enumerate(leaves)})
    assert [c.standing for c in vo.check_claims(claimed)] == ["proved"] * 4
    base, fibre, rows, (leaf,) = wheeled_pendulum()
    lagrangian = sum(velocity(s) ** 2 for s in (*base, *fibre)) / 2
    system = System("pendulum", Fibration(base, fibre), lagrangian, rows, parameters=(R, b))
    found = vo.search_integrals(system, degree=0, positions=1).integrals
    assert [sp.cancel(f.expression / leaf).is_number for f in found] == [True]


def test_a_leaf_is_a_relation_in_the_place_of_a_constraint():
    base, fibre, rows, (leaf,) = wheeled_pendulum()
    lagrangian = sum(velocity(s) ** 2 for s in (*base, *fibre)) / 2
    bound = System(
        "bound", Fibration(base, fibre, relations=(leaf - 1,)), lagrangian, rows[1:],
        parameters=(R, b),
    )  # fmt: skip
    free = System("free", Fibration(base, fibre), lagrangian, rows, parameters=(R, b))
    one, two = vo.derive(bound), vo.derive(free)
    assert one.growth == two.growth and one.distribution.dimension == 5 and one.integrable == ()
    parts = [(*eqs.rates, *eqs.mass, *eqs.force) for eqs in (one, two)]
    for f, g in zip(*parts, strict=True):
        assert prove_equal(f, g, [leaf - 1]).proved


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
    assert eqs.kind == "holonomic" and len(eqs.integrable) == len(eqs.leaves) == 1
    assert not any(sp.flatten(eqs.curvature.space)) and not any(sp.flatten(eqs.curvature.time))
