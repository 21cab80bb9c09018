"""Systems of one's own that grow: trailers, snakes, flexible bodies; each for us and for SymPy.

A ``Mechanism`` is a list of weights with the places that they stand at; both sides make of it what
their users write: a Lagrangian, or particles for Kane's method.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any

import sympy as sp

import voronec as vo

x, y, v, w = sp.symbols("x y v w")
Places = tuple[tuple[Any, tuple[Any, ...]], ...]


@dataclass(frozen=True)
class Mechanism:
    """``places`` are pairs of a mass (or a moment) and what moves with it; half the mass times the
    square of its velocity is kinetic energy.  ``speeds`` are the quasi-velocities."""

    name: str
    base: tuple[Any, ...]
    fibre: tuple[Any, ...]
    places: Places
    potential: Any
    constraints: tuple[Any, ...]
    speeds: dict[Any, Any]

    @property
    def coordinates(self) -> tuple[Any, ...]:
        """All of them."""
        return (*self.base, *self.fibre)

    @property
    def parameters(self) -> tuple[Any, ...]:
        """The symbols besides, sorted."""
        exprs = [self.potential, *self.constraints, *(e for m, p in self.places for e in (m, *p))]
        found = set().union(*(sp.sympify(e).free_symbols for e in exprs))
        moving = {*self.coordinates, *map(vo.velocity, self.coordinates), vo.time}
        return tuple(sorted(found - moving, key=str))

    def rate(self, expr: Any) -> Any:
        """The time derivative of a function of coordinates and time."""
        expr = sp.sympify(expr)
        parts = [expr.diff(q) * vo.velocity(q) for q in self.coordinates]
        return sp.Add(expr.diff(vo.time), *parts)

    def system(self) -> vo.System:
        """The mechanism as our users declare it, with numbers to run it from."""
        kinetic = sum(m * sum(self.rate(e) ** 2 for e in place) for m, place in self.places) / 2
        start = {str(q): 0.1 + 0.07 * i for i, q in enumerate(self.coordinates)}
        start |= {str(u): 0.3 + 0.1 * i for i, u in enumerate(self.speeds)}
        return vo.System(
            name=self.name,
            fibration=vo.Fibration(self.base, self.fibre),
            frame=vo.Frame.quasi(self.speeds),
            lagrangian=kinetic - self.potential,
            constraints=self.constraints,
            parameters=tuple(
                vo.Parameter(p, 1 + sp.Rational(i, 10), positive=True)
                for i, p in enumerate(self.parameters)
            ),
            scenes={"default": vo.Scene(initial=start, times=(0, 0.1))},
        )

    def kane(self) -> Any:
        """The mechanism as particles for SymPy's method of Kane, not yet formed."""
        from sympy.physics import mechanics as me

        q = {c: me.dynamicsymbols(str(c)) for c in self.coordinates}
        u = {c: me.dynamicsymbols(f"u_{c}") for c in self.coordinates}
        fast = {vo.velocity(c): u[c] for c in self.coordinates}
        ground = me.ReferenceFrame("N")
        origin = me.Point("O")
        origin.set_vel(ground, 0)
        bodies, loads = [], []
        for i, (mass, place) in enumerate(self.places):
            point = me.Point(f"P{i}")
            moved = [self.rate(e).xreplace(fast | q) for e in place]
            axes = (ground.x, ground.y, ground.z)
            point.set_vel(ground, sum(e * a for e, a in zip(moved, axes, strict=False)))
            bodies.append(me.Particle(f"B{i}", point, mass))
        for c in self.coordinates:
            pull = -sp.diff(self.potential, c)
            if pull != 0:
                point = me.Point(f"F_{c}")
                point.set_vel(ground, u[c] * ground.x)
                loads.append((point, pull.xreplace(q) * ground.x))
        independent = self.base[: len(self.speeds)]
        dependent = [c for c in self.coordinates if c not in independent]
        return me.KanesMethod(
            ground, q_ind=[q[c] for c in self.coordinates], u_ind=[u[c] for c in independent],
            kd_eqs=[q[c].diff(vo.time) - u[c] for c in self.coordinates],
            u_dependent=[u[c] for c in dependent],
            velocity_constraints=[e.xreplace(fast | q) for e in self.constraints],
            bodies=bodies, forcelist=loads,
        )  # fmt: skip


def _heading(angle: Any) -> tuple[Any, Any]:
    return sp.cos(angle), sp.sin(angle)


def _blade(own: Mechanism, place: Sequence[Any], angle: Any) -> Any:
    """The slip across a blade or a wheel."""
    return own.rate(place[0]) * sp.sin(angle) - own.rate(place[1]) * sp.cos(angle)


def _row(name: str, angles: Sequence[Any], turns: Sequence[Any], ahead: float) -> Mechanism:
    """Bodies in a row on wheels: ``turns`` are the coordinates, ``angles`` the headings in them;
    hinges stand ``ahead`` of the wheels of the body behind, and so far behind those before."""
    count = len(angles)
    mass, moment = sp.symbols(f"m0:{count}"), sp.symbols(f"J0:{count}")
    length = sp.symbols(f"l1:{count}") if count > 1 else ()
    place, places = (x, y), []
    for k, angle in enumerate(angles):
        if k:
            before, behind = _heading(angles[k - 1]), _heading(angle)
            place = tuple(
                p - ahead * length[k - 1] * b - length[k - 1] * h
                for p, b, h in zip(place, before, behind, strict=True)
            )
        places.append((place, angle))
    weights: Places = tuple((m, p) for m, (p, _) in zip(mass, places, strict=True))
    weights += tuple((j, (a,)) for j, a in zip(moment, angles, strict=True))
    own = Mechanism(name, (x, turns[0]), (y, *turns[1:]), weights, sp.S.Zero, (), {})
    along = vo.velocity(x) * sp.cos(turns[0]) + vo.velocity(y) * sp.sin(turns[0])
    blades = tuple(_blade(own, p, a) for p, a in places)
    return replace(own, constraints=blades, speeds={v: along, w: vo.velocity(turns[0])})


def trailer(count: int) -> Mechanism:
    """A car and so many trailers, hinged over the wheels of what is before."""
    angles = sp.symbols(f"theta0:{count + 1}")
    return _row(f"trailer {count}", angles, angles, 0)


def snake(count: int) -> Mechanism:
    """So many links, each on a wheel in its middle, by their headings."""
    angles = sp.symbols(f"theta1:{count + 1}")
    return _row(f"snake {count}", angles, angles, 1)


def relative_snake(count: int) -> Mechanism:
    """The links by the angles between them."""
    turns = sp.symbols(f"phi1:{count + 1}")
    angles = [sp.Add(*turns[: k + 1]) for k in range(count)]
    return _row(f"snake {count} relative", angles, turns, 1)


def flexible_sleigh(count: int) -> Mechanism:
    """A sleigh with a beam in so many modes, of which each bends a mass of its own."""
    phi, modes = sp.Symbol("phi"), sp.symbols(f"q1:{count + 1}")
    m, J, a, mu = sp.symbols("m J a mu")
    stiff = sp.symbols(f"k1:{count + 1}")
    (c, s) = _heading(phi)
    weights: Places = ((m, (x + a * c, y + a * s)), (J, (phi,)))
    for k in range(1, count + 1):
        along = sp.Rational(k, count)
        bend = sum(q * along ** (i + 2) for i, q in enumerate(modes))
        weights += ((mu, (x + along * c - bend * s, y + along * s + bend * c)),)
    springs = sum(k * q**2 for k, q in zip(stiff, modes, strict=True)) / 2
    own = Mechanism(
        f"flexible sleigh {count}", (x, phi, *modes), (y,), weights, springs, (), {}
    )  # fmt: skip
    forward = vo.velocity(x) * c + vo.velocity(y) * s
    rates = {sp.Symbol(f"r{i + 1}"): vo.velocity(q) for i, q in enumerate(modes)}
    speeds = {v: forward, w: vo.velocity(phi), **rates}
    return replace(own, constraints=(_blade(own, (x, y), phi),), speeds=speeds)


def plate_on_balls() -> Mechanism:
    """A plate that rolls on three balls, which roll on a table: half as fast as the plate over
    them."""
    phi, (M, J, mu) = sp.Symbol("phi"), sp.symbols("M J mu")
    centres = [sp.symbols(f"x{i} y{i}") for i in (1, 2, 3)]
    weights: Places = ((M, (x, y)), (J, (phi,)), *((mu, c) for c in centres))
    own = Mechanism(
        "plate on three balls", (x, y, phi), tuple(q for c in centres for q in c), weights,
        sp.S.Zero, (), {},
    )  # fmt: skip
    dx, dy, turn = map(vo.velocity, (x, y, phi))
    slips = tuple(
        slip
        for a, b in centres
        for slip in (
            2 * vo.velocity(a) - (dx - turn * (b - y)), 2 * vo.velocity(b) - (dy + turn * (a - x))
        )
    )  # fmt: skip
    speeds = {v: dx, sp.Symbol("u"): dy, w: turn}
    return replace(own, constraints=slips, speeds=speeds)


def manipulator_on_cart(count: int) -> Mechanism:
    """An arm of so many links on a cart with two wheels: the links turn in a vertical plane over
    the cart's heading."""
    phi, joints = sp.Symbol("phi"), sp.symbols(f"q1:{count + 1}")
    m, J, g = sp.symbols("m J g")
    mass, length = sp.symbols(f"m1:{count + 1}"), sp.symbols(f"l1:{count + 1}")
    weights: Places = ((m, (x, y)), (J, (phi,)))
    reach, height, potential = sp.S.Zero, sp.S.Zero, sp.S.Zero
    for k in range(count):
        lean = sp.Add(*joints[: k + 1])
        reach, height = reach + length[k] * sp.sin(lean), height + length[k] * sp.cos(lean)
        weights += ((mass[k], (x + reach * sp.cos(phi), y + reach * sp.sin(phi), height)),)
        potential += mass[k] * g * height
    own = Mechanism(
        f"manipulator {count} on a cart", (x, phi, *joints), (y,), weights, potential, (), {}
    )  # fmt: skip
    forward = vo.velocity(x) * sp.cos(phi) + vo.velocity(y) * sp.sin(phi)
    rates = {sp.Symbol(f"r{i + 1}"): vo.velocity(q) for i, q in enumerate(joints)}
    speeds = {v: forward, w: vo.velocity(phi), **rates}
    return replace(own, constraints=(_blade(own, (x, y), phi),), speeds=speeds)


@dataclass(frozen=True)
class _Pair:
    """A system and SymPy's model of it, written apart."""

    system: Callable[[], vo.System]
    kane: Callable[[], Any]


def _vibrating_disc() -> vo.System:
    """The falling disc of the catalogue on a plane that shakes up and down."""
    disc = vo.load("falling-disc")
    m, amplitude, rate = sp.Symbol("m"), sp.Symbol("h"), sp.Symbol("Omega")
    lift = amplitude * rate * sp.cos(rate * vo.time)
    theta, R, g = sp.symbols("theta R g")
    upward = lift - R * vo.velocity(theta) * sp.sin(theta)
    still = m * R**2 * vo.velocity(theta) ** 2 * sp.sin(theta) ** 2 / 2
    shaken = sp.expand(disc.lagrangian) - sp.expand(still) + m * upward**2 / 2
    shaken -= m * g * amplitude * sp.sin(rate * vo.time)
    return vo.System(
        name="disc on a vibrating plane", fibration=disc.fibration, frame=disc.frame,
        lagrangian=shaken, constraints=disc.constraints,
        parameters=(*disc.parameters, vo.Parameter(amplitude, "0.01"), vo.Parameter(rate, 20)),
        scenes={"default": next(iter(disc.scenes.values()))},
    )  # fmt: skip


def _vibrating_disc_by_kane() -> Any:
    from sympy.physics import mechanics as me

    from figures.mechanics_models import frame, kane

    q, u = me.dynamicsymbols("q1:6"), me.dynamicsymbols("u1:6")
    r, m, g, A, C, h, rate = sp.symbols("r m g A C h Omega")
    ground = me.ReferenceFrame("N")
    yaw = frame(ground, "Y", q[2], ground.z)
    lean = frame(yaw, "L", q[3], yaw.x)
    disc = frame(lean, "R", q[4], lean.y)
    disc.set_ang_vel(ground, u[3] * yaw.x + u[2] * yaw.z + u[4] * lean.y)
    contact, centre = me.Point("C"), me.Point("O")
    lift = h * rate * sp.cos(rate * vo.time)
    centre.set_vel(
        ground,
        u[0] * ground.x + u[1] * ground.y + lift * ground.z
        + (u[3] * yaw.x + u[2] * yaw.z).cross(r * lean.z),
    )  # fmt: skip
    contact.set_vel(ground, centre.vel(ground) + disc.ang_vel_in(ground).cross(-r * lean.z))
    body = me.RigidBody("D", centre, disc, m, (me.inertia(lean, A, C, A), centre))
    slips = [(contact.vel(ground) - lift * ground.z).dot(a) for a in (yaw.x, yaw.y)]
    return kane(
        ground, q, u[2:], [p.diff(vo.time) - s for p, s in zip(q, u, strict=True)], [body],
        [(centre, -m * g * ground.z)], u_dependent=u[:2], velocity_constraints=slips,
    )  # fmt: skip


def _bicycle_with_rider() -> vo.System:
    """The bicycle of the catalogue with a rider who leans: a mass on a spring over the saddle."""

    own = import_module("voronec.systems.bicycle")
    from voronec.kinematics import cross, dot

    mass, length, stiff, alpha, rate = sp.symbols("m_P l_P k_P alpha lean_rate")
    turn, reach = vo.velocity(alpha), length * sp.sin(alpha)
    omega = own.about_y(own.theta, own.frame_omega)
    place = (own.x_B, reach, -own.r_R - length * sp.cos(alpha))
    moved = own.add(own.about_y(own.theta, own.centre_velocity), cross(omega, place))
    moved = own.add(moved, (sp.S.Zero, length * turn * sp.cos(alpha), reach * turn))
    depth = own.centre_depth + dot(own.about_y(own.theta, own.frame_down), place)
    bicycle = own.SYSTEM
    lagrangian = bicycle.lagrangian + mass * dot(moved, moved) / 2 + mass * own.g * depth
    assert bicycle.frame is not None
    speeds = dict(zip(bicycle.frame.velocities, bicycle.frame.expressions, strict=True))
    numbers = {mass: 40, length: "0.6", stiff: 2000}
    return vo.System(
        name="bicycle with a leaning rider",
        fibration=vo.Fibration((*bicycle.fibration.base, alpha), bicycle.fibration.fibre),
        frame=vo.Frame.quasi({**speeds, rate: turn}),
        lagrangian=lagrangian - stiff * alpha**2 / 2,
        constraints=bicycle.constraints,
        parameters=(*bicycle.parameters, *(vo.Parameter(p, e) for p, e in numbers.items())),
        scenes={"default": bicycle.scenes["default"]},
    )


def _bicycle_by_kane() -> Any:
    """SymPy's bicycle, its rider rigid: less work than ours."""
    from figures.mechanics_models import whipple_bicycle

    return whipple_bicycle()


SYSTEMS: dict[str, Callable[[], Mechanism | _Pair]] = {
    "bicycle": lambda: _Pair(_bicycle_with_rider, _bicycle_by_kane),
    "sleigh-6": partial(flexible_sleigh, 6),
    "disc": lambda: _Pair(_vibrating_disc, _vibrating_disc_by_kane),
    "plate": plate_on_balls,
    **{f"cart-{n}": partial(manipulator_on_cart, n) for n in (3, 2)},
    **{f"trailer-{n}": partial(trailer, n) for n in (10, 6, 5, 4, 8, 3, 2, 1, 7, 9)},
    **{f"snake-{n}": partial(snake, n) for n in (20, 6, 4, 10, 3, 2, 14)},
    **{f"relative-{n}": partial(relative_snake, n) for n in (20, 6, 4, 10, 3, 2, 14)},
}
"""By the word that asks for it, the worst ones first."""
