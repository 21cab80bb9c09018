"""An ellipsoid that rolls on a plane or a sphere: a chart, and what is seen from the ellipsoid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.declaration.charts import Chart
from voronec.declaration.claims import Equation, Measure
from voronec.declaration.derivatives import derivative
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.scene import Scene
from voronec.declaration.shapes import Shape
from voronec.declaration.system import System
from voronec.errors import DefinitionError
from voronec.kinematics.balls import GAMMA, OMEGA, ZERO
from voronec.kinematics.bodies import kinetic_energy, point_velocity
from voronec.kinematics.carried_contact import CARRIED_VECTORS, carried_vectors, form_values
from voronec.kinematics.convex import ConvexBody
from voronec.kinematics.families import (
    FIXED_RADIUS,
    Words,
    constants,
    join_declarations,
    moment_words,
    rotor_words,
)
from voronec.kinematics.forms import SurfaceForms
from voronec.kinematics.meanings import (
    NORMAL,
    contact_meanings,
    euler_meanings,
    place_meanings,
    vector_meanings,
)
from voronec.kinematics.neumann_charts import HALF_TURN, turned_poles
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.rotations import Rotation
from voronec.kinematics.sketches import contact_views, rolling_sketch, wheel_of
from voronec.kinematics.surfaces import Surface
from voronec.kinematics.vectors import (
    Vector,
    apply_matrix,
    column,
    cross,
    dot,
    matrix_product,
    three,
)

HEIGHT = sp.Symbol("height")
SUPPORT = "distance of the centre from the tangent plane at the contact"


@dataclass(frozen=True)
class RollingEllipsoid:
    """An ellipsoid that rolls without slipping, its mass centred, its axes principal.

    The base is Euler's angles (phi, theta, psi).  ``fibre`` are (x, y), where the centre is over
    the plane; on a sphere, (u, v, p), colatitude and longitude of gamma along the axes of the
    ellipsoid and the support function, bound by ``relations``: then no root occurs.  A spheroid on
    a sphere is carried along: see ``spheroid_on_sphere``.

    axes, mass, inertia
        the semi-axes, the mass and the principal moments.
    sphere
        R1 where it rolls on a sphere; nothing on a plane.
    rotation
        the attitude, by Euler's angles.
    normal, height
        gamma along the axes of the ellipsoid and the support function, in the coordinates.
    moved, constraints
        the velocity of the centre, by omega1, omega2, omega3 and the velocities of the fibre; and
        what vanishes where it does not slip.
    contact
        the point of contact in space, on the sphere divided by its radius.
    coordinates
        those that the equations hold.
    meanings, drawn
        what the coordinates of the fibre are, in words and in the sketch (see ``rolling_sketch``).
    surfaces
        of a spheroid on a sphere, by their forms.

    ``system`` declares it, with what is special beside.
    """

    axes: Sequence[Any]
    mass: Any
    inertia: Sequence[Any]
    sphere: Any
    rotation: Rotation
    fibre: tuple[sp.Expr, ...]
    normal: Vector
    height: sp.Expr
    moved: Sequence[Any]
    constraints: tuple[sp.Expr, ...]
    contact: tuple[sp.Expr, ...]
    coordinates: tuple[sp.Expr, ...]
    meanings: Mapping[Any, str]
    drawn: Mapping[str, Any]
    relations: tuple[sp.Expr, ...] = ()
    surfaces: RollingContact | None = None

    def __post_init__(self) -> None:
        for name, what in (("axes", "semi-axes"), ("inertia", "moments")):
            read = three(getattr(self, name), f"the {what} of an ellipsoid")
            object.__setattr__(self, name, read)

    @classmethod
    def on_plane(cls, axes: Sequence[Any], mass: Any, inertia: Sequence[Any]) -> RollingEllipsoid:
        """On the plane z = 0; the height of the centre is a square root."""
        x, y = fibre = sp.symbols("x y")
        rotation = Rotation.euler("zxz", *sp.symbols("phi theta psi"))
        turn = rotation.matrix
        vertical = three(turn.row(2), "a normal")
        level = _support(axes, vertical)
        placed = ConvexBody.ellipsoid(axes, vertical, level)
        across = apply_matrix(-turn, cross(OMEGA, placed.arm))
        reach = apply_matrix(turn, placed.arm)
        rising = -dot(placed.arm, placed.rolling_rate(OMEGA))
        return cls(
            axes, mass, inertia, None, rotation, fibre, vertical, level,
            moved=(velocity(x), velocity(y), rising),
            constraints=(velocity(x) - across[0], velocity(y) - across[1]),
            contact=(x + reach[0], y + reach[1]),
            coordinates=rotation.coordinates[1:],
            meanings=place_meanings(fibre, "the centre over the plane"),
            drawn={"place": fibre},
        )  # fmt: skip

    @classmethod
    def on_sphere(
        cls, axes: Sequence[Any], mass: Any, inertia: Sequence[Any], sphere: Any
    ) -> RollingEllipsoid:
        """On a fixed sphere of that signed radius R1, negative where it is touched from inside.

        The centre is at R1 gamma - r from that of the sphere, along the axes of the ellipsoid.
        """
        u, v, support = fibre = sp.symbols("u v p")
        rotation = Rotation.euler("zxz", *sp.symbols("phi theta psi"))
        normal = (sp.sin(u) * sp.cos(v), sp.sin(u) * sp.sin(v), sp.cos(u))
        down = column([derivative(x, u) for x in normal])
        along = column([-sp.sin(v), sp.cos(v), sp.Integer(0)])
        placed = ConvexBody.ellipsoid(axes, normal, support)
        rate = down * velocity(u) + along * sp.sin(u) * velocity(v)
        moved = sphere * rate - placed.arm_rate(rate)
        moved += column(cross(OMEGA, sphere * placed.normal - placed.arm))
        turned = placed.rolling_rate(OMEGA, sphere)
        around = dot(turned, along) / sp.sin(u)
        seen = "of the normal gamma, seen from the ellipsoid"
        return cls(
            axes, mass, inertia, sphere, rotation, fibre, normal, support,
            moved=moved,
            constraints=(velocity(u) - dot(turned, down), velocity(v) - around),
            contact=tuple(matrix_product(rotation.matrix, normal)),
            coordinates=fibre,
            meanings={u: f"colatitude {seen}", v: f"longitude {seen}", support: SUPPORT},
            drawn={"on": "sphere", "place": (u, v), "height": support},
            relations=(support**2 - _square_sum(axes, normal),),
        )  # fmt: skip

    @classmethod
    def spheroid_on_sphere(
        cls, axes: Sequence[Any], mass: Any, inertia: Sequence[Any], sphere: Any
    ) -> RollingEllipsoid:
        """An ellipsoid of revolution, semi-axes (a, c), on a sphere; Neumann's coordinates.

        The fibre is what the motion carries along: o = (o1, o2, o3), the place of the centre seen
        from the body, and (u, v, u1, v1, theta).  The base is Euler's angles (phi, chi, psi), for
        Neumann's theta is none of them.  The support function is a square root in u.
        """
        o, (u, v, u1, v1, theta) = sp.symbols("o1:4"), sp.symbols("u v u1 v1 theta")
        (a, c), (equatorial, axial) = axes, inertia
        level = sp.sqrt((a * sp.sin(u)) ** 2 + (c * sp.cos(u)) ** 2)
        body, fixed = Surface.sphere(1, u, v), Surface.sphere(1, u1, v1)
        normal = three(-body.normal, "a normal")
        radii = ((a * c) ** 2 / level**3, a**2 / level)
        contact = RollingContact(
            SurfaceForms.revolution(u, v, radii),
            SurfaceForms.revolution(u1, v1, (sphere, sphere)),
            theta,
        )
        rolled = contact.rolling_velocities(apply_matrix(body.frame.T, OMEGA))
        arm = ConvexBody.ellipsoid((a, a, c), normal, level).arm
        moved = column(point_velocity([velocity(q) for q in o], OMEGA, o))
        rotation = Rotation.euler("zxz", *sp.symbols("phi chi psi"))
        moments, fibre = (equatorial, equatorial, axial), (*o, *rolled)
        rolls = (velocity(q) - rate for q, rate in rolled.items())
        return cls(
            (a, a, c), mass, moments, sphere, rotation, fibre, normal, level,
            moved=moved,
            constraints=(*rolls, *(moved + column(cross(OMEGA, arm)))),
            contact=tuple(fixed.position),
            coordinates=(u, v),
            meanings=contact_meanings(contact) | vector_meanings(o, CARRIED_VECTORS[0]),
            drawn=contact_views(contact, o),
            surfaces=contact,
        )  # fmt: skip

    @cached_property
    def body(self) -> ConvexBody:
        """What is seen from the ellipsoid, in the symbols gamma1, gamma2, gamma3, height."""
        return ConvexBody.ellipsoid(self.axes, GAMMA, HEIGHT)

    @cached_property
    def normal_rate(self) -> sp.ImmutableMatrix:
        """dgamma/dt."""
        return self.body.rolling_rate(OMEGA, self.sphere)

    @property
    def kinetic(self) -> sp.Expr:
        """The kinetic energy in omega1, omega2, omega3 and the velocities of the fibre."""
        return kinetic_energy(self.mass, self.moved, self.inertia, OMEGA)

    @property
    def invariants(self) -> dict[str, sp.Expr]:
        """gamma1, gamma2, gamma3 and height in the coordinates."""
        names = (*map(str, GAMMA), str(HEIGHT))
        return dict(zip(names, (*self.normal, self.height), strict=True))

    @property
    def charts(self) -> dict[str, Chart]:
        """Of Neumann's coordinates, with their poles elsewhere."""
        return {} if self.surfaces is None else _turned_poles(self)

    @property
    def base(self) -> tuple[sp.Expr, ...]:
        """Euler's angles."""
        return self.rotation.coordinates

    @property
    def spin(self) -> dict[sp.Expr, sp.Expr]:
        """omega1, omega2, omega3 by the velocities of Euler's angles."""
        return dict(zip(OMEGA, self.rotation.body_rates, strict=True))

    @property
    def momentum(self) -> sp.ImmutableMatrix:
        """G, the angular momentum about the contact, in gamma, height and omega."""
        return self.body.momentum(self.mass, self.inertia, OMEGA)

    @property
    def density(self) -> sp.Expr:
        """h (A + m r^2) (A C + m (A (r_1^2 + r_2^2) + C r_3^2))^(1/2), for A, A, C the moments.

        The density of a measure of gamma, height and omega where a spheroid rolls on a plane; on
        a sphere times (R1 + r1) (R1 + r2).  The factor h is there because the height, bound to
        gamma, is one of the variables.
        """
        equatorial, _, axial = self.inertia
        x, y, z = self.body.arm
        spread = equatorial * (x**2 + y**2) + axial * z**2
        root = sp.sqrt(equatorial * axial + self.mass * spread)
        return self.body.height * (equatorial + self.mass * (x**2 + y**2 + z**2)) * root

    @property
    def as_any_body(self) -> tuple[dict[Any, Any], dict[str, Any]]:
        """A spheroid on a sphere as a body of unknown surfaces: its state, and their functions."""
        if self.surfaces is None:
            raise DefinitionError("only a spheroid on a sphere is known by the forms of surfaces")
        frame = Surface.sphere(1, *self.coordinates).frame
        arm = apply_matrix(frame, (derivative(self.height, self.coordinates[0]), 0, self.height))
        state = {q: q for q in (*self.base, *self.fibre, *OMEGA)}
        return {**state, **carried_vectors(arm, frame)}, form_values(self.surfaces)

    @property
    def shapes(self) -> tuple[Shape, Shape]:
        """The ellipsoid, and the plane or sphere, as they are drawn."""
        named = {sp.Symbol(name): e for name, e in self.invariants.items()}
        touched = sp.Matrix([*self.contact, 0][:3])
        ground = Shape.plane()
        if self.sphere is not None:
            touched, ground = self.sphere * touched, Shape.ball(self.sphere, role="ground")
        turned = self.rotation.matrix
        if self.surfaces is not None:
            seen = Surface.sphere(1, *self.surfaces.body.coordinates)
            fixed = Surface.sphere(1, *self.surfaces.fixed.coordinates)
            turned = RollingContact(seen, fixed, self.surfaces.theta).attitude
        centre = touched - matrix_product(turned, self.body.arm.xreplace(named))
        placed = {"centre": centre, "attitude": turned, "contact": touched}
        return Shape.ellipsoid(self.axes, **placed), ground

    def scene(
        self,
        caption: str,
        start: Mapping[Any, Any],
        spin: Sequence[Any],
        parameters: Mapping[Any, Any] | None = None,
    ) -> Scene:
        """30 units of time from ``start`` with omega = ``spin``: the contact and omega are shown.

        Coordinates that do not stand in ``start`` begin with 0.
        """
        spun = zip(OMEGA, three(spin, "an angular velocity"), strict=True)
        initial = {**start, **{w: rate for w, rate in spun if rate != 0}}
        shown = self.contact
        if self.surfaces is not None:
            shown = (*self.surfaces.body.coordinates, *self.surfaces.fixed.coordinates)
        return Scene(initial, (0.0, 30.0), parameters or {}, (*shown, *OMEGA), caption)

    def system(
        self,
        *,
        values: Mapping[Any, Any],
        rotor: Sequence[Any] = ZERO,
        gravity: Any = 0,
        **declared: Any,
    ) -> System:
        """The system of this body, with ``values`` of its constants, and what is special to it.

        ``rotor`` is kappa, the momentum of a gyroscope; ``gravity`` pulls along -gamma.  Where body
        and gyroscope have an axis of symmetry there is a measure [BorisovMamaev2002].
        """
        kappa, weight = three(rotor, "the momentum of a rotor"), self.mass * gravity
        common = {
            "fibration": Fibration(self.base, self.fibre, self.relations),
            "frame": Frame.quasi(self.spin),
            "lagrangian": self.kinetic - weight * self.invariants["height"] + dot(kappa, OMEGA),
            "constraints": self.constraints,
            "parameters": constants(values, self._words(kappa, gravity)),
            "invariants": self.invariants,
            "equations": {
                "momentum": Equation(self.momentum, self.momentum_rate(kappa, weight)),
                "normal": Equation(GAMMA, self.normal_rate),
            },
            "integrals": {"energy": dot(self.momentum, OMEGA) / 2 + weight * HEIGHT},
            "charts": self.charts,
            "essential": (*self.coordinates, *OMEGA),
            "meanings": {
                **euler_meanings(self.base),
                **self.meanings,
                **vector_meanings(OMEGA),
                **vector_meanings(map(str, GAMMA), NORMAL),
                "height": SUPPORT,
            },
            "sketch": rolling_sketch(
                body="ellipsoid", attitude=self.base, wheel=wheel_of(kappa), **self.drawn
            ),
            "shapes": self.shapes,
        }
        is_round = self.axes[0] == self.axes[1] and self.inertia[0] == self.inertia[1]
        if is_round and not any(kappa[:2]):
            spread = 1 if self.sphere is None else self.body.curvature_product(self.sphere)
            common["measure"] = Measure(self.density * spread, (*GAMMA, HEIGHT, *OMEGA))
        return join_declarations(common, declared)

    def _words(self, rotor: Vector, gravity: Any) -> Words:
        """What its constants are."""
        a, b, c = self.axes
        axes = dict.fromkeys(self.axes, ("semi-axis", True))
        if a == b:
            axes = {a: ("equatorial semi-axis", True), c: ("polar semi-axis", True)}
        return {
            self.mass: ("mass", True),
            self.sphere: FIXED_RADIUS,
            gravity: ("gravity", False),
            **axes,
            **moment_words(self.inertia),
            **rotor_words(rotor),
        }

    def momentum_rate(self, rotor: Sequence[Any] = (0, 0, 0), weight: Any = 0) -> Any:
        """dG/dt, where a ``rotor`` of constant momentum kappa is built in."""
        whole = self.momentum + sp.Matrix(rotor)
        return self.body.momentum_rate(whole, self.mass, OMEGA, self.normal_rate, weight)


def _square_sum(axes: Sequence[Any], normal: Sequence[Any]) -> Any:
    """The square of the support function."""
    return sum((q * n) ** 2 for q, n in zip(axes, normal, strict=True))


def _support(axes: Sequence[Any], normal: Sequence[Any]) -> sp.Expr:
    """The distance of the tangent plane with that unit normal from the centre."""
    return sp.sqrt(_square_sum(axes, normal))


def _turned_poles(rolling: RollingEllipsoid) -> dict[str, Chart]:
    """The charts of a spheroid on a sphere: polar axes across its own, and across the sphere's.

    The lines of u and v are no lines of curvature there.  With N = -gamma, along them, and the
    sphere's normal gamma carried along by gamma' + omega x gamma in space, all rates follow.
    """
    *o, u, v, u1, v1, theta = rolling.fibre
    turned = matrix_product(HALF_TURN, Surface.sphere(1, u, v).frame)
    down, across, outer = (turned.col(i) for i in range(3))
    level = _support(rolling.axes, outer)
    placed = ConvexBody.ellipsoid(rolling.axes, tuple(-outer), level)
    rate = placed.rolling_rate(OMEGA, rolling.sphere)
    swing = rate - column(cross(OMEGA, outer))
    x, y = dot(swing, down), dot(swing, across)
    around = -dot(rate, across) / sp.sin(u)
    other = (x * sp.cos(theta) + y * sp.sin(theta)) / sp.sin(u1)
    moved = point_velocity([velocity(q) for q in o], OMEGA, sp.Matrix(o) + placed.arm)
    constraints = (
        velocity(u) + dot(rate, down),
        velocity(v) - around,
        velocity(u1) + x * sp.sin(theta) - y * sp.cos(theta),
        velocity(v1) - other,
        velocity(theta) + dot(OMEGA, outer) + around * sp.cos(u) + other * sp.cos(u1),
        *moved,
    )
    spheres = RollingContact(Surface.sphere(1, u, v), Surface.sphere(rolling.sphere, u1, v1), theta)
    return turned_poles(spheres, {"constraints": constraints})
