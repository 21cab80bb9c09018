"""A body of any shape that rolls: its contact carried along with the motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.symbols import velocity
from voronec.algebra.text import as_expression
from voronec.declaration.claims import Equation
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.system import System
from voronec.kinematics.balls import ZERO
from voronec.kinematics.bodies import (
    kinetic_energy,
    momentum_about_point,
    momentum_rate_about_point,
    point_velocity,
)
from voronec.kinematics.families import constants, join_declarations, moment_words, rotor_words
from voronec.kinematics.forms import SurfaceForms, curvature_lines
from voronec.kinematics.meanings import (
    CURVATURE_LINES,
    contact_meanings,
    euler_meanings,
    vector_meanings,
)
from voronec.kinematics.rolling import RollingContact
from voronec.kinematics.rotations import Rotation
from voronec.kinematics.sketches import contact_views, rolling_sketch, wheel_of
from voronec.kinematics.vectors import column, cross, dot, three

CARRIED_VECTORS = (
    "place of the body's centre",
    "place of the contact from the body's centre",
    "direction of u at the contact",
    "direction of v at the contact",
)
"""What o, r, e, f are."""


@dataclass(frozen=True)
class CarriedContact:
    """A body that rolls on a surface, both known by their forms along lines of curvature.

    The base is Euler's angles (phi, chi, psi) of the body.  The fibre is what the motion carries
    along: o = (o1, o2, o3), the place of O seen from the body; r = OM; e and f, the directions
    e_u and e_v; all of these along the axes of the body; and Neumann's coordinates of ``contact``.
    No position of the surfaces in space or in the body is asked for, and no derivative of their
    forms is taken but for the bending of the coordinate lines.
    """

    contact: RollingContact
    mass: Any
    inertia: tuple[Any, Any, Any]

    @classmethod
    def unknown(cls, mass: Any, inertia: Sequence[Any]) -> CarriedContact:
        """Two surfaces of which nothing is known: see ``unknown_forms``."""
        u, v, u1, v1, theta = sp.symbols("u v u1 v1 theta")
        contact = RollingContact(unknown_forms(u, v), unknown_forms(u1, v1, "1"), theta)
        return cls(contact, mass, three(inertia, "the moments of a body"))

    @property
    def base(self) -> tuple[sp.Expr, ...]:
        """Euler's angles."""
        return self.rotation.coordinates

    @property
    def omega(self) -> sp.Matrix:
        """The angular velocity along the axes of the body, as symbols."""
        return sp.Matrix(sp.symbols("omega1:4"))

    @cached_property
    def rotation(self) -> Rotation:
        """The attitude of the body."""
        return Rotation.euler("zxz", *sp.symbols("phi chi psi"))

    @property
    def spin(self) -> dict[sp.Expr, sp.Expr]:
        """omega by the velocities of Euler's angles."""
        return dict(zip(self.omega, self.rotation.body_rates, strict=True))

    @property
    def vectors(self) -> tuple[sp.Matrix, sp.Matrix, sp.Matrix, sp.Matrix]:
        """o, r, e, f."""
        o, r, e, f = (sp.Matrix(sp.symbols(f"{name}1:4")) for name in "oref")
        return o, r, e, f

    @cached_property
    def rates(self) -> dict[sp.Expr, sp.Expr]:
        """The velocities of the fibre, as functions of the fibre and of omega."""
        o, r, e, f = self.vectors
        n = column(cross(e, f))
        turned = self.contact.rolling_velocities([dot(axis, self.omega) for axis in (e, f, n)])
        known = {velocity(q): rate for q, rate in turned.items()}
        a, b, c = (as_expression(x).xreplace(known) for x in self.contact.body.frame_rates)
        pairs = (
            (o, cross(r + o, self.omega)),
            (r, self.trace(known)),
            (e, c * f - b * n),
            (f, a * n - c * e),
        )
        entries = [pair for q, rate in pairs for pair in zip(q, rate, strict=True)]
        return dict(entries) | turned

    def trace(self, known: dict[sp.Expr, sp.Expr]) -> sp.Matrix:
        """The velocity of the contact over the body, where those of (u, v) are ``known``."""
        x, y, _ = (as_expression(z).xreplace(known) for z in self.contact.body.trace_velocity)
        return x * self.vectors[2] + y * self.vectors[3]

    @property
    def constraints(self) -> tuple[sp.Expr, ...]:
        """Expressions that vanish: the body rolls without slipping."""
        return tuple(velocity(q) - rate for q, rate in self.rates.items())

    @property
    def kinetic(self) -> sp.Expr:
        """The kinetic energy, by omega and the velocity of O."""
        place = self.vectors[0]
        moved = point_velocity([velocity(q) for q in place], self.omega, place)
        return kinetic_energy(self.mass, moved, self.inertia, self.omega)

    @property
    def momentum(self) -> sp.ImmutableMatrix:
        """G = I omega + m r x (omega x r), about the contact."""
        return momentum_about_point(self.mass, self.inertia, self.omega, self.vectors[1])

    def system(
        self, *, values: Mapping[Any, Any], rotor: Sequence[Any] = ZERO, **declared: Any
    ) -> System:
        """The system of this body, with ``values`` of its constants, and what is special to it.

        ``rotor`` is kappa, the momentum of a gyroscope.  The energy is the only integral.
        """
        kappa = three(rotor, "the momentum of a rotor")
        words = {self.mass: ("mass", True), **moment_words(self.inertia), **rotor_words(kappa)}
        place, arm, *lines = self.vectors
        common = {
            "fibration": Fibration(self.base, tuple(self.rates)),
            "frame": Frame.quasi(self.spin),
            "lagrangian": self.kinetic + dot(self.omega, kappa),
            "constraints": self.constraints,
            "parameters": constants(values, words),
            "equations": {"momentum": Equation(self.momentum, self.momentum_rate(kappa))},
            "integrals": {"energy": dot(self.momentum, self.omega) / 2},
            "essential": (*arm, *lines[0], *lines[1], *self.contact.coordinates, *self.omega),
            "meanings": {
                **euler_meanings(self.base),
                **contact_meanings(self.contact, on=CURVATURE_LINES),
                **vector_meanings(self.omega),
                **vector_meanings(place, CARRIED_VECTORS[0]),
                **vector_meanings(arm, CARRIED_VECTORS[1]),
                **vector_meanings(lines[0], CARRIED_VECTORS[2]),
                **vector_meanings(lines[1], CARRIED_VECTORS[3]),
            },
            "sketch": rolling_sketch(
                body="body",
                attitude=self.base,
                **contact_views(self.contact, place),
                wheel=wheel_of(kappa),
                arm=arm,
                lines=lines,
            ),
        }
        return join_declarations(common, declared)

    def momentum_rate(self, rotor: Sequence[Any] = (0, 0, 0)) -> sp.ImmutableMatrix:
        """dG/dt = (G + kappa) x omega + m dr/dt x (omega x r), kappa the momentum of a rotor."""
        arm = self.vectors[1]
        whole, moved = self.momentum + sp.Matrix(rotor), [self.rates[q] for q in arm]
        return momentum_rate_about_point(whole, self.mass, self.omega, arm, moved)


def carried_vectors(arm: Any, frame: sp.MatrixBase) -> dict[str, sp.Expr]:
    """r, e and f of a body whose moving ``frame`` [e f n] is known, along its axes."""
    vectors = {"r": sp.Matrix(arm), "e": frame.col(0), "f": frame.col(1)}
    return {f"{name}{i + 1}": x for name, vector in vectors.items() for i, x in enumerate(vector)}


def form_values(contact: RollingContact) -> dict[str, sp.Expr]:
    """The values that the functions of ``unknown_forms`` have for two surfaces that are known."""
    forms: dict[str, sp.Expr] = {}
    for surface, mark in ((contact.body, ""), (contact.fixed, "1")):
        for letter, pair in zip("Lkb", curvature_lines(surface), strict=True):
            for name, value in zip("uv", pair, strict=True):
                forms[f"{letter}_{name}{mark}"] = value
    return forms


def unknown_forms(u: sp.Expr, v: sp.Expr, mark: str = "") -> SurfaceForms:
    """Any surface: lengths L_u, L_v, curvatures k_u = -D/E, k_v = -D''/G and bendings b_u, b_v.

    All are unknown functions of u and v; the bendings are E_v/(2 L_u L_v) and G_u/(2 L_u L_v).
    """
    names = (f"{name}{mark}" for name in ("L_u", "L_v", "k_u", "k_v", "b_u", "b_v"))
    lu, lv, ku, kv, bu, bv = (sp.Function(name)(u, v) for name in names)
    second = (-ku * lu**2, -kv * lv**2)
    return SurfaceForms((u, v), (lu**2, lv**2), second, (lu, lv), None, (bu, bv))
