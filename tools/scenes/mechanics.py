"""Systems made at random for the fuzzer: generic ones, and classes of mechanics.

Their parameters are drawn anew, in splits and angles that become singular, with forces that are not
smooth, and with forces that depend on the time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any

import sympy as sp

import voronec as vo

x, y, z, theta, phi, psi = sp.symbols("x y z theta phi psi")
s1, s2 = sp.symbols("s1 s2")
k = sp.Symbol("k")
t = vo.time


@dataclass(frozen=True)
class Case:
    """A system, values of its parameters, how large its starts are, and around what place."""

    system: vo.System
    parameters: Mapping[str, float] = field(default_factory=dict)
    size: float = 1.0
    span: float = 10.0
    singular: tuple[str, ...] = ()
    inputs: Mapping[str, sp.Expr] = field(default_factory=dict)
    centre: Mapping[str, float] = field(default_factory=dict)


def dot(q: sp.Symbol) -> sp.Expr:
    """The velocity of a coordinate."""
    return vo.velocity(q)


def some(dice: Random, low: float = 0.3, high: float = 2.0) -> sp.Rational:
    """A number with few digits, of random sign."""
    return dice.choice((-1, 1)) * above(dice, low, high)


def above(dice: Random, low: float = 0.3, high: float = 2.0) -> sp.Rational:
    """A positive number with few digits."""
    return sp.Rational(round(dice.uniform(low, high) * 20), 20)


def smooth(dice: Random, names: list[sp.Symbol]) -> sp.Expr:
    """A smooth function of some coordinates, and perhaps of the time."""
    a, b = dice.choice(names), dice.choice(names)
    return dice.choice(
        [
            some(dice),
            some(dice) * a,
            a * b / 3,
            sp.sin(a + some(dice) * b),
            sp.cos(a) * b,
            sp.exp(-(a**2)) + b,
            sp.sqrt(1 + a**2) * some(dice),
            1 / (2 + sp.cos(b)),
            sp.tanh(a) * some(dice),
            sp.atan(a + b),
            a / (1 + b**2),
        ]
    )


def generic(dice: Random) -> Case:
    """Any Lagrangian that is positive in the velocities, any constraints, affine and in time."""
    base = (x, y, z)[: dice.choice((1, 2, 2, 3))]
    fibre = (s1, s2)[: dice.choice((0, 1, 1, 2))]
    coordinates = base + fibre
    names = [*coordinates, t] if dice.random() < 0.4 else list(coordinates)
    dots = [dot(q) for q in coordinates]
    kinetic = sum((3 + smooth(dice, names) ** 2) * d**2 for d in dots) / 2
    kinetic += sum(
        dice.choice((0, 1)) * sp.sin(smooth(dice, names)) * p * q / (2 * len(dots))
        for i, p in enumerate(dots)
        for q in dots[:i]
    )
    bent = dots[0] ** 4 / 20 if dice.random() < 0.2 else 0
    linear = sum(smooth(dice, names) * d for d in dots) if dice.random() < 0.5 else 0
    potential = sum(q**2 for q in coordinates) / 2 + smooth(dice, names)
    constraints = []
    for i, own in enumerate(fibre):
        rest = sum(smooth(dice, names) * dot(q) for q in base)
        mixed = sum(dot(q) / 4 for j, q in enumerate(fibre) if j != i)
        free = smooth(dice, names) if dice.random() < 0.3 else 0
        constraints.append((2 + sp.sin(dice.choice(names))) * dot(own) + mixed + rest + free)
    forces = {
        q: some(dice) * dice.choice(dots) * smooth(dice, names) - above(dice) * dot(q)
        for q in coordinates
        if dice.random() < 0.5
    }
    L = k * kinetic + linear + bent - potential
    system = _system("generic", base, fibre, L, constraints, forces, (k,))
    return Case(system, {"k": float(above(dice))}, span=5.0)


def blade(dice: Random) -> Case:
    """A sleigh in velocities of coordinates: the split fails where the blade lies along y."""
    m, J, a = above(dice), above(dice), dice.choice((0, above(dice) / 3))
    centre = (dot(x) - a * dot(phi) * sp.sin(phi), dot(y) + a * dot(phi) * sp.cos(phi))
    potential = dice.choice((0, above(dice) * y, above(dice) * (x**2 + y**2) / 2))
    L = m * (centre[0] ** 2 + centre[1] ** 2) / 2 + J * dot(phi) ** 2 / 2 - potential
    c = dot(x) * sp.sin(phi) - dot(y) * sp.cos(phi)
    split = dice.choice((((x, phi), (y,)), ((y, phi), (x,))))
    forces = {phi: some(dice) * sp.sin(t)} if dice.random() < 0.3 else {}
    return Case(_system("blade", *split, L, (c,), forces), singular=("phi",))


def trailers(dice: Random) -> Case:
    """A robot with one or two trailers, in velocities of coordinates."""
    count = dice.choice((1, 2))
    angles = sp.symbols(f"theta0:{count + 1}")
    masses = [above(dice) for _ in angles]
    length = above(dice, 0.6, 1.5)
    kinetic, place = sp.Integer(0), (dot(x), dot(y))
    constraints = []
    for i, (angle, mass) in enumerate(zip(angles, masses, strict=True)):
        if i:
            place = (
                place[0] + length * dot(angle) * sp.sin(angle),
                place[1] - length * dot(angle) * sp.cos(angle),
            )
        kinetic += mass * (place[0] ** 2 + place[1] ** 2) / 2 + above(dice) * dot(angle) ** 2 / 2
        constraints.append(place[0] * sp.sin(angle) - place[1] * sp.cos(angle))
    base, fibre = (x, angles[0]), (y, *angles[1:])
    return Case(_system("trailers", base, fibre, kinetic, constraints, {}), singular=("theta0",))


def racer(dice: Random) -> Case:
    """A roller racer: two bodies, each on an axle that does not slip sideways."""
    d1, d2 = above(dice), above(dice)
    L = above(dice) * (dot(x) ** 2 + dot(y) ** 2) / 2 + above(dice) * dot(theta) ** 2 / 2
    L += above(dice, 0.1, 0.5) * (dot(theta) + dot(phi)) ** 2 / 2
    first = -sp.sin(theta) * dot(x) + sp.cos(theta) * dot(y)
    joint = (dot(x) - d1 * sp.sin(theta) * dot(theta), dot(y) + d1 * sp.cos(theta) * dot(theta))
    turn = dot(theta) + dot(phi)
    second = -sp.sin(theta + phi) * joint[0] + sp.cos(theta + phi) * joint[1] + d2 * turn
    split = dice.choice((((x, phi), (y, theta)), ((theta, phi), (x, y))))
    return Case(_system("racer", *split, L, (first, second), {}), singular=("phi", "theta"))


def top(dice: Random) -> Case:
    """A rigid body about a point, in Euler angles, perhaps with Suslov's constraint."""
    A, B, C = sorted(above(dice, 0.8, 1.5) for _ in range(3))
    w1 = dot(psi) * sp.sin(theta) * sp.sin(phi) + dot(theta) * sp.cos(phi)
    w2 = dot(psi) * sp.sin(theta) * sp.cos(phi) - dot(theta) * sp.sin(phi)
    w3 = dot(phi) + dot(psi) * sp.cos(theta)
    L = (A * w1**2 + B * w2**2 + C * w3**2) / 2 - above(dice) * sp.cos(theta)
    w = sp.symbols("w1:4")
    if dice.random() < 0.5:
        frame = vo.Frame.quasi(dict(zip(w, (w1, w2, w3), strict=True)))
        return Case(_system("top", (psi, theta, phi), (), L, (), {}, (), frame),
                    singular=("theta",))  # fmt: skip
    frame = vo.Frame.quasi(dict(zip(w[:2], (w1, w2), strict=True)))
    held = w3 + some(dice) * w1 / 3
    return Case(_system("held", (theta, phi), (psi,), L, (held,), {}, (), frame),
                singular=("theta",))  # fmt: skip


def bowl(dice: Random) -> Case:
    """A particle in a bowl in polar coordinates, or a double pendulum, both plain mechanics."""
    g, m, a = above(dice), above(dice), above(dice)
    if dice.random() < 0.5:
        r = sp.Symbol("r")
        L = m * (dot(r) ** 2 * (1 + a * r**2) + r**2 * dot(phi) ** 2) / 2 - g * r**2 / 2
        return Case(_system("bowl", (r, phi), (), L, (), {}), singular=("r",))
    first = (dot(theta) * sp.cos(theta), dot(theta) * sp.sin(theta))
    second = (first[0] + a * dot(phi) * sp.cos(phi), first[1] + a * dot(phi) * sp.sin(phi))
    L = (first[0] ** 2 + first[1] ** 2 + m * (second[0] ** 2 + second[1] ** 2)) / 2
    L += g * (sp.cos(theta) + m * (sp.cos(theta) + a * sp.cos(phi)))
    return Case(_system("pendulum", (theta, phi), (), L, (), {}))


def far(dice: Random) -> Case:
    """A particle or a sleigh near a place far off, with forces that are powers of the distance from
    there: sums of powers of the coordinates would be rounding."""
    c, d = (dice.choice((20, 300, 5000)) + above(dice) for _ in range(2))
    if dice.random() < 0.3:
        return _far_ring(dice)
    a, b = x - c, y - d
    potential = dice.choice(
        [
            a**4 / 4 + b**2 / 2,
            (a**2 + b**2) ** 2 / 4,
            sp.sqrt(1 + a**2 + b**2) ** 3,
            -3 / (1 + a**2 + 2 * b**2) ** 2,
            a**6 / 6 + a * b / 3 + b**4 / 4 + x / 10,
            (a - b) ** 4 / 4 + (x - c - 1) ** 2 * b**2,
        ]
    )
    L = (dot(x) ** 2 + above(dice) * dot(y) ** 2) / 2 - potential
    centre = {"x": float(c), "y": float(d)}
    if dice.random() < 0.5:
        forces = {x: -(a**3) * b**2 / 4} if dice.random() < 0.5 else {}
        system = _system("far", (x, y), (), L, (), forces)
        return Case(system, size=0.5, span=5.0, centre=centre)
    L += above(dice) * dot(phi) ** 2 / 2
    blade = dot(x) * sp.sin(phi) - dot(y) * sp.cos(phi)
    system = _system("far-blade", (x, phi), (y,), L, (blade,), {})
    return Case(system, size=0.5, span=5.0, singular=("phi",), centre=centre)


def _far_ring(dice: Random) -> Case:
    """A bead on an ellipse about a place far off, in redundant coordinates, that drives a third
    one.  Much farther away steps, whose tolerance is relative to x, would be what is seen."""
    c, k, w = dice.choice((20, 300)) + above(dice), above(dice), sp.Symbol("w")
    a = x - c
    lifts = dice.choice([0, a, a**2, a * y, (1 + a) ** 3])
    drive = dot(z) - lifts * dot(x) - some(dice) * y * dot(y)
    L = (dot(x) ** 2 + dot(y) ** 2 + dot(z) ** 2) / 2
    L -= dice.choice([y, a / 3 + y, a**4, a * y, sp.sqrt(2 + a**2), x / 5])
    system = vo.System(
        name="far-ring",
        fibration=vo.Fibration(base=(x, y), fibre=(z,), relations=(a**2 + k * y**2 - 1,)),
        lagrangian=L,
        constraints=(drive,),
        frame=vo.Frame.quasi({w: a * dot(y) - k * y * dot(x)}),
    )
    return Case(system, size=0.5, span=5.0, centre={"x": float(c)})


def rough(dice: Random) -> Case:
    """One or two oscillators, a sleigh or a carriage, with forces that are not smooth."""
    chance = dice.random()
    if chance < 0.4:
        return _rough_sleigh(dice) if chance < 0.2 else _rough_carriage(dice)
    coordinates = (x, y)[: dice.choice((1, 1, 2))]
    L = sum(above(dice) * dot(q) ** 2 / 2 - above(dice) * q**2 / 2 for q in coordinates)
    if len(coordinates) == 2:
        L -= some(dice) * x * y / 8
    forces = {q: _not_smooth(dice, q) for q in coordinates}
    if dice.random() < 0.2:
        L -= above(dice) * sp.Abs(coordinates[0] - some(dice) / 4)
    return Case(_system("rough", coordinates, (), L, (), forces), span=15.0)


def _not_smooth(dice: Random, q: sp.Symbol) -> sp.Expr:
    v, c, d = dot(q), above(dice, 0.1, 1.0), some(dice)
    drive = dice.choice((0, above(dice) * sp.sin(above(dice) * t)))
    return drive + dice.choice(
        [
            -c * sp.sign(v),
            -c * sp.Abs(v) * v,
            -c * sp.Abs(q) * q,
            -c * sp.Heaviside(q - d) * (q - d),
            sp.Max(-c, sp.Min(c, -3 * q - v)),
            sp.Piecewise((-c * q, q > d), (-2 * c * q - c * d, True)) - v / 5,
            -c * sp.sign(q) - v / 4,
            -c * sp.sign(v - d) - v / 10,
            -c * sp.Max(0, q - d) - v / 10,
            -c * sp.Abs(sp.sin(q)),
            c * sp.sign(sp.sin(2 * t)),
            -c * sp.Min(1, sp.Abs(v)) * sp.sign(v),
        ]
    )


def _rough_sleigh(dice: Random) -> Case:
    m, J, a, c = above(dice), above(dice), above(dice) / 3, above(dice, 0.05, 0.4)
    v, w = sp.symbols("v w")
    centre = (dot(x) - a * dot(phi) * sp.sin(phi), dot(y) + a * dot(phi) * sp.cos(phi))
    L = m * (centre[0] ** 2 + centre[1] ** 2) / 2 + J * dot(phi) ** 2 / 2
    along = dot(x) * sp.cos(phi) + dot(y) * sp.sin(phi)
    pull = dice.choice([-c * sp.sign(along), -c * along * sp.Abs(along),
                        c * sp.Max(0, 1 - along), -c * sp.Abs(along)])  # fmt: skip
    forces = {x: pull * sp.cos(phi), y: pull * sp.sin(phi)}
    if dice.random() < 0.5:
        forces[phi] = -c * sp.sign(dot(phi))
    frame = vo.Frame.quasi({v: along, w: dot(phi)})
    constraint = dot(x) * sp.sin(phi) - dot(y) * sp.cos(phi)
    return Case(_system("rough-sleigh", (x, phi), (y,), L, (constraint,), forces, (), frame))


def _rough_carriage(dice: Random) -> Case:
    """A carriage on two wheels, turned by s1 and s2, with dry friction in two places: one sets in
    while another holds, and what held lets go."""
    m, J, wheel, half = (above(dice) for _ in range(4))
    v, w = sp.symbols("v w")
    along = dot(x) * sp.cos(phi) + dot(y) * sp.sin(phi)
    squares = m * (dot(x) ** 2 + dot(y) ** 2) + J * dot(phi) ** 2
    L = (squares + (dot(s1) ** 2 + dot(s2) ** 2) / 5) / 2
    constraints = (
        dot(x) * sp.sin(phi) - dot(y) * sp.cos(phi),
        wheel * dot(s1) - along + half * dot(phi),
        wheel * dot(s2) - along - half * dot(phi),
    )
    forces = {q: -above(dice, 0.1, 0.6) * sp.sign(dot(q))
              for q in dice.sample([s1, s2, x, phi], 2)}  # fmt: skip
    driven = dice.choice([*forces])
    forces[driven] += dice.choice((0, sp.cos(t) / 3, some(dice, 0.1, 0.5)))
    frame = vo.Frame.quasi({v: along, w: dot(phi)})
    return Case(_system("rough-carriage", (x, phi), (y, s1, s2), L, constraints, forces, (), frame),
                size=0.7, span=6.0)  # fmt: skip


def driven_mechanics(dice: Random) -> Case:
    """Mechanics driven by functions of the time."""
    made = dice.choice((blade, bowl, generic))(dice)
    system = made.system
    u = dice.choice(
        [
            sp.sin(above(dice) * t) * some(dice),
            sp.exp(-t / 5) * some(dice),
            sp.tanh(20 * (t - 1)) * some(dice),
            some(dice) / (1 + t**2),
            sp.cos(t**2 / 10) * some(dice),
        ]
    )
    forces = {**system.forces}
    q = dice.choice(system.coordinates)
    forces[q] = forces.get(q, 0) + u
    return Case(
        replace(system, name="driven", forces=forces),
        made.parameters,
        made.size,
        min(made.span, 8.0),
        made.singular,
    )


def _system(
    name: str,
    base: tuple[Any, ...],
    fibre: tuple[Any, ...],
    lagrangian: Any,
    constraints: Any,
    forces: Mapping[Any, Any],
    parameters: Any = (),
    frame: vo.Frame | None = None,
) -> vo.System:
    return vo.System(
        name=name,
        fibration=vo.Fibration(base=base, fibre=fibre),
        lagrangian=lagrangian,
        constraints=tuple(constraints),
        forces=forces,
        parameters=tuple(parameters),
        frame=frame,
    )


KINDS_OF_MECHANICS: Mapping[str, tuple[Callable[[Random], Case], ...]] = {
    "smooth": (generic, blade, trailers, racer, top, bowl, far),
    "singular": (blade, trailers, racer, top, bowl),
    "nonsmooth": (rough,),
    "inputs": (driven_mechanics,),
    "turns": (blade, bowl, top),
}


def source_of(system: vo.System) -> str:
    """Python text that makes the system again."""
    names = sorted({str(s) for s in system.known_symbols()} - {"t"})
    fibration, frame = system.fibration, system.frame
    forces = ", ".join(f"{q}: {f}" for q, f in system.forces.items())
    lines = [
        "from sympy import *",
        "import voronec as vo",
        f"{', '.join(names)}, = symbols({' '.join(names)!r})",
        "t = vo.time",
        *(f"{u.func} = Function({str(u.func)!r})" for u in system.inputs),
        f"system = vo.System(name={system.name!r}, fibration=vo.Fibration(base={fibration.base}, "
        f"fibre={fibration.fibre}, relations={fibration.relations}),",
        f"    lagrangian={system.lagrangian},",
        f"    constraints={system.constraints}, forces={{{forces}}},",
        f"    parameters={tuple(p.symbol for p in system.parameters)},",
    ]
    if frame is not None:
        pairs = ", ".join(
            f"{v}: {e}" for v, e in zip(frame.velocities, frame.expressions, strict=True)
        )
        lines.append(f"    frame=vo.Frame.quasi({{{pairs}}}),")
    return "\n".join([*lines, ")"])
