"""Random systems: the connection's route, the multipliers' route, and d'Alembert by plain SymPy."""

from __future__ import annotations

import random
from dataclasses import dataclass, replace
from itertools import chain

import flint
import pytest
import sympy as sp
from hypothesis import example, given, settings
from hypothesis import strategies as st

import voronec as vo
from voronec import Fibration, Frame, Parameter, System, time, velocity
from voronec.algebra.tape import Tape
from voronec.equations.derivation import Derivation

pytestmark = pytest.mark.slow

Q = sp.Rational
r1, r2, r3, s1, s2 = sp.symbols("r1 r2 r3 s1 s2")
k = sp.Symbol("k", positive=True)
quasi = sp.symbols("v1:4")


@dataclass(frozen=True)
class Made:
    """A random system and a random point of it."""

    system: System
    point: dict


def number(source):
    return Q(source.randint(-6, 6) or 7, source.randint(2, 5))


def smooth(source, names):
    """A random function of some coordinates and the time, of moderate size."""
    pick = source.choice(names)
    other = source.choice(names)
    return source.choice(
        [
            number(source),
            number(source) * pick,
            pick * other / 3,
            sp.sin(pick + number(source) * other),
            sp.cos(pick) * other,
            sp.exp(-(pick**2)) + other,
            sp.sqrt(1 + pick**2) * number(source),
            1 / (2 + sp.cos(other)),
        ]
    )


def lagrangian(source, names, dots, bent):
    """Positive definite in the velocities, with a linear part, a potential, and a bent part."""
    kinetic = sum((3 + smooth(source, names) ** 2) * d**2 for d in dots) / 2
    kinetic += sum(
        source.choice((0, 1)) * sp.sin(smooth(source, names)) * p * q / (2 * len(dots))
        for i, p in enumerate(dots)
        for q in dots[:i]
    )
    linear = sum(smooth(source, names) * d for d in dots)
    extra = sum(d**4 for d in dots) / 20 + sp.exp(dots[0] / 5) if bent else 0
    return k * kinetic + linear + extra - smooth(source, names) * smooth(source, names)


def make(seed, base=2, fibre=1, framed=False, bent=False, moving=True):
    source = random.Random(seed)
    rs, ss = (r1, r2, r3)[:base], (s1, s2)[:fibre]
    coordinates = rs + ss
    names = [*coordinates, time] if moving else list(coordinates)
    dots = [velocity(c) for c in coordinates]
    fibre_dots = dots[base:]
    constraints = []
    for i, own in enumerate(fibre_dots):  # not solved for the fibre velocities
        rest = sum(smooth(source, names) * d for d in dots[:base])
        mixed = sum(d / 4 for j, d in enumerate(fibre_dots) if j != i)
        free = smooth(source, names) if moving else 0
        constraints.append((2 + sp.sin(source.choice(names))) * own + mixed + rest + free)
    frame = None
    if framed:
        definitions = {}
        for i in range(base):
            body = (3 + sp.cos(source.choice(names))) * dots[i]
            body += sum(
                sp.sin(smooth(source, names)) * d / (4 * base) for d in dots if d != dots[i]
            )
            definitions[quasi[i]] = body + (smooth(source, names) if moving else 0)
        frame = Frame.quasi(definitions)
    forces = {
        c: number(source) * source.choice(dots) * smooth(source, names) - number(source) * d
        for c, d in zip(coordinates, dots, strict=True)
        if source.random() < 0.7
    }
    system = System(
        name=f"random-{seed}",
        fibration=Fibration(rs, ss),
        lagrangian=lagrangian(source, names, dots, bent),
        constraints=tuple(constraints),
        frame=frame,
        forces=forces,
        parameters=(Parameter(k, Q(3, 2), positive=True),),
    )
    unknown = quasi[:base] if framed else tuple(dots[:base])
    point = {c: number(source) / 3 for c in (*coordinates, *unknown, time)}
    return Made(system, point)


def full_velocities(made):
    """All coordinate velocities at the point, by SymPy."""
    system, dots = made.system, [velocity(c) for c in made.system.coordinates]
    equations = list(system.constraints)
    if system.frame is not None:
        pairs = zip(system.frame.velocities, system.frame.expressions, strict=True)
        equations += [e - v for v, e in pairs]
    else:
        equations += [d - made.point[d] for d in dots[: len(system.fibration.base)]]
    at = {**made.point, k: Q(3, 2)}
    equations = [e.xreplace({p: n for p, n in at.items() if p not in dots}) for e in equations]
    matrix, right = sp.linear_eq_to_matrix(equations, dots)
    solution = matrix.evalf(60).LUsolve(right.evalf(60))
    return dict(zip(dots, solution, strict=True))


def projected(made):
    """d'Alembert: the Euler-Lagrange residual vanishes on a basis of virtual velocities."""
    system, coordinates = made.system, made.system.coordinates
    dots = [velocity(c) for c in coordinates]
    at = {**made.point, k: Q(3, 2), **full_velocities(made)}

    def there(expr):
        return sp.sympify(expr).xreplace(at).evalf(60)

    def drift(expr):
        """d/dt without the accelerations."""
        return expr.diff(time) + sum(
            expr.diff(c) * d for c, d in zip(coordinates, dots, strict=True)
        )

    lag = system.lagrangian
    mass = sp.Matrix(len(dots), len(dots), lambda i, j: there(lag.diff(dots[i], dots[j])))
    force = sp.Matrix(
        [
            there(lag.diff(c) - drift(lag.diff(d)) + system.forces.get(c, 0))
            for c, d in zip(coordinates, dots, strict=True)
        ]
    )
    rows = sp.Matrix([[there(c.diff(d)) for d in dots] for c in system.constraints])
    second = sp.Matrix([-there(drift(c)) for c in system.constraints])
    base = len(system.fibration.base)
    lift = (-rows[:, base:].LUsolve(rows[:, :base])) if rows.rows else sp.zeros(0, base)
    virtual = sp.Matrix.vstack(sp.eye(base), lift)
    whole = sp.Matrix.vstack(virtual.T * mass, rows)
    return dict(
        zip(coordinates, whole.LUsolve(sp.Matrix.vstack(virtual.T * force, second)), strict=True)
    )


def agree(one, other, digits=40):
    assert list(one) == list(other)
    size = 1 + max(abs(v) for v in one.values())
    for name in one:
        assert abs(one[name] - other[name]) <= size * Q(1, 10**digits), (name, one, other)


shapes = st.fixed_dictionaries(
    {
        "base": st.integers(1, 3),
        "fibre": st.integers(0, 2),
        "framed": st.booleans(),
        "bent": st.booleans(),
        "moving": st.booleans(),
    }
)


SUMS_BESIDE_SUMS = {"base": 3, "fibre": 1, "framed": True, "bent": False, "moving": True}
"""A system whose sums were once expanded for every pair of them, for minutes."""
LONG_EXPONENTS = {"base": 3, "fibre": 1, "framed": True, "bent": True, "moving": False}
"""One whose exponents were written out, without end, in all the memory there was."""


@settings(max_examples=2, deadline=None)
@example(3833, SUMS_BESIDE_SUMS)
@example(126798201, LONG_EXPONENTS)
@given(st.integers(0, 10**9), shapes)
def test_both_routes_agree_to_forty_digits(seed, shape):
    made = make(seed, **shape)
    ours = vo.derive(made.system).acceleration(made.point, digits=50)
    agree(ours, vo.multiplier_acceleration(made.system, made.point, digits=50))


@pytest.mark.parametrize(
    ("seed", "framed", "bent"),
    [(0, False, False), (0, True, True), (1, False, False), (1, False, True)],
)
def test_all_three_routes_agree(seed, framed, bent):
    made = make(seed + 100, 2, 1 + seed % 2, framed, bent)
    ours = vo.derive(made.system).acceleration(made.point, digits=50)
    agree(ours, projected(made))


@pytest.mark.parametrize("seed", range(1, 4))
def test_accelerations_do_not_depend_on_the_frame(seed):
    made = make(seed + 200, 2, 2, framed=True, bent=bool(seed % 2))
    system = made.system
    plain = replace(system, name="plain", frame=None)
    base = [velocity(c) for c in system.fibration.base]
    found = full_velocities(made)
    point = {c: n for c, n in made.point.items() if c not in quasi}
    there = vo.derive(plain).acceleration(point | {d: found[d] for d in base}, digits=50)
    agree(vo.derive(system).acceleration(made.point, digits=50), there)


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_the_order_and_scale_of_constraints_play_no_part(seed):
    made = make(seed + 300, 2, 2, framed=bool(seed % 2))
    system = made.system
    first, second = system.constraints
    mixed = (second * (2 + sp.cos(r1)) - first, first * sp.exp(s1))
    other = replace(system, name="other", constraints=mixed)
    agree(
        vo.derive(system).acceleration(made.point, digits=50),
        vo.derive(other).acceleration(made.point, digits=50),
    )


@pytest.mark.parametrize("seed", range(6))
def test_power_balance(seed):
    """dE/dt + dL/dt = Q qdot, plus what affine constraints put in: their reactions times a_0."""
    made = make(seed + 400, 2, 1, framed=bool(seed % 2), bent=seed > 2, moving=seed % 3 == 0)
    system = made.system
    dots = [velocity(c) for c in system.coordinates]
    found = vo.derive(system).acceleration(made.point, digits=50)
    at = {**made.point, k: Q(3, 2), **full_velocities(made)}
    lag = system.lagrangian
    energy = sum(d * lag.diff(d) for d in dots) - lag
    change = energy.diff(time) + sum(
        energy.diff(c) * d + energy.diff(d) * found[c]
        for c, d in zip(system.coordinates, dots, strict=True)
    )
    power = sum(force * velocity(c) for c, force in system.forces.items()) - lag.diff(time)
    (constraint,) = system.constraints
    momentum, own = lag.diff(dots[-1]), system.coordinates[-1]
    residual = momentum.diff(time) - lag.diff(own) - system.forces.get(own, 0)
    residual += sum(
        momentum.diff(c) * d + momentum.diff(d) * found[c]
        for c, d in zip(system.coordinates, dots, strict=True)
    )
    # The multiplier from the fibre equation; the constraint is row * qdot + offset.
    multiplier = residual / constraint.diff(dots[-1])
    offset = constraint.xreplace(dict.fromkeys(dots, sp.Integer(0)))
    assert abs((change - power + multiplier * offset).xreplace(at).evalf(50)) < Q(1, 10**35)


@pytest.mark.parametrize("framed", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_exact_and_raw_forms_agree(seed, framed):
    system = small(seed, framed)
    eqs = vo.derive(system)
    # without the budget that dense systems like these exceed
    exact = Derivation(eqs.definition, exact=True)
    names = (*system.coordinates, *system.velocities, time, k)
    at = {eqs.bridge.inward(c): flint.fmpq(7 * i + 4, 29) for i, c in enumerate(names)}
    for one, other in (
        ([*chain.from_iterable(exact.mass)], [*chain.from_iterable(eqs.raw.mass)]),
        (exact.force, eqs.raw.force),
        (exact.rates, eqs.raw.rates),
        (exact.right, eqs.raw.right),
        (exact.momenta, eqs.raw.momenta),
        (exact.quasi_momenta, eqs.raw.quasi_momenta),
    ):
        left, right = Tape(one).arb(at, 300), Tape(other).arb(at, 300)
        assert all(p.overlaps(q) for p, q in zip(left, right, strict=True))
        assert all(p.rel_accuracy_bits() > 150 for p in (*left, *right) if not p.contains(0))


def small(seed, framed):
    """A random system whose normal forms are short."""
    source = random.Random(seed)
    p, q, s = velocity(r1), velocity(r2), velocity(s1)
    pieces = [r1, s1, r1 * r2, sp.sin(r1), sp.cos(s1), sp.sin(r1 + r2), time, sp.sqrt(1 + r2**2)]
    one, two, three, four, five = source.sample(pieces, 5)
    frame = Frame.quasi({quasi[0]: p + three * s / 5, quasi[1]: 2 * q - one}) if framed else None
    return System(
        name="small",
        fibration=Fibration((r1, r2), (s1,)),
        lagrangian=(k * p**2 + 2 * q**2 + (1 + one**2) * s**2) / 2 + two * p - k * four,
        constraints=((2 + k**2) * s - one * p - two * q - five,),
        forces={r1: -p * three, s1: q},
        frame=frame,
        parameters=(k,),
    )
