"""The dictionaries of the section on Neumann's variables.

``Space`` puts two arbitrary surfaces into space: the frame M u1 v1 n1 is an unknown rotation, whose
derivatives are those that the forms of the fixed surface prescribe.  Velocities are made from
positions alone, so that the relations between them are derived.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study
from voronec.kinematics import Rotation, kinetic_energy

from .surfaces import (
    COORDINATES,
    MASS,
    NOTE,
    QUASI,
    SLIP,
    Surfaces,
    nonzero,
    u,
    u1,
    v,
    v1,
    vector,
    worst,
)

TURN = sp.symbols("e_0:4")
W, P = sp.symbols("w_x w_y w_z"), sp.symbols("p q r")
MOMENTS = sp.symbols("A B C", positive=True)
AXES = (r"\mathbf u", r"\mathbf v", r"\mathbf n")
ENERGY_ARGUMENTS = (*SLIP, *QUASI)
PARTICLES = 3


def rotation(quaternion: tuple[Any, ...]) -> sp.Matrix:
    """A rotation matrix from four numbers that are not all zero."""
    at = dict(zip(TURN, quaternion, strict=True))
    matrix = sp.Matrix(Rotation.quaternion(*TURN).matrix).xreplace(at)
    return matrix / sum(x**2 for x in quaternion)


@dataclass(frozen=True)
class Space:
    """Vectors in space: positions, their velocities, angular velocities."""

    surfaces: Surfaces

    @property
    def free(self) -> Motion:
        """All five velocities are free."""
        rates = {q: vo.velocity(q) for q in COORDINATES}
        return Motion(rates | {w: vo.velocity(w) for w in rates.values()})

    @cached_property
    def quaternion(self) -> tuple[sp.Expr, ...]:
        """Unknown functions that give the frame on the fixed surface."""
        return tuple(sp.Function(x.name)(u1, v1) for x in TURN)

    @cached_property
    def frame(self) -> sp.Matrix:
        """Components along (u1, v1, n1) to components in space."""
        return rotation(self.quaternion)

    @cached_property
    def axes(self) -> sp.Matrix:
        """Components along (u, v, n) to components in space."""
        return self.frame * self.surfaces.contact.turn

    @cached_property
    def rules(self) -> dict[sp.Expr, sp.Expr]:
        """Derivatives of unknown functions: those of the forms, and those of the frame."""
        found = dict(self.surfaces.roots)
        for forms in self.surfaces.forms:
            found |= forms.rules()
        a, *rest = self.quaternion
        b = vector(rest)
        for q in (u1, v1):
            turn = vector(sp.diff(x, vo.velocity(q)) for x in self.surfaces.forms[1].frame_rates)
            moved = [-b.dot(turn), *(a * turn + b.cross(turn))]
            found |= {sp.diff(x, q): y / 2 for x, y in zip(self.quaternion, moved, strict=True)}
        return found

    @cached_property
    def angular(self) -> dict[str, sp.Matrix]:
        """omega, and those of the frames against one another."""
        contact = self.surfaces.contact
        turning = contact.turn.T * self.free.derivative(sp.Matrix(contact.turn))
        between = sp.Matrix([turning[2, 1], turning[0, 2], turning[1, 0]])
        return {
            r"\omega": self.axes * self.surfaces.spin,
            r"\omega_1": -self.axes * self.surfaces.body_frame,
            r"\omega_2": self.axes * between,
            r"\omega_3": self.frame * vector(contact.fixed.frame_rates),
        }

    @cached_property
    def names(self) -> dict[str, Any]:
        """The dictionary; vectors have components in space."""
        surfaces, contact = self.surfaces, self.surfaces.contact
        place = self.frame * vector(surfaces.forms[1].support or ())
        arm = self.axes * surfaces.arm
        centre, omega = place - arm, self.angular[r"\omega"]
        slip = omega.cross(arm) + self.free.derivative(centre)
        return {
            **surfaces.names(),
            **self.angular,
            **dict(zip(("s", r"\tau", "n"), surfaces.spin, strict=True)),
            **dict(zip(("x_1", "y_1", "z_1"), place, strict=True)),
            **{name: sp.Function(name)(u, v) for name in ("x", "y", "z")},
            r"\overrightarrow{OM}": arm,
            r"\overrightarrow{O_1O}": centre,
            r"\mathfrak v^1": self.free.derivative(place),
            r"\mathfrak v": self.axes * vector(contact.body.trace_velocity),
            r"\mathfrak m": slip,
            **{rf"\mathfrak m_{axis}": (self.axes.T * slip)[i] for i, axis in enumerate(AXES)},
        }

    def studies(self) -> dict[str, Study]:
        """``free``: nothing is constrained; ``rolling``: without slipping."""

        def study(motion: Motion) -> Study:
            return Study(
                self.names,
                motion=motion,
                labelled=frozenset({r"\mathfrak{v}"}),
                given=self.rules,
                context=self,
                note=NOTE,
            )

        return {"free": study(self.free), "rolling": study(self.surfaces.motion)}

    def same_condition(self) -> vo.Verdict:
        """Whether the trace's velocities differ by the left side of the usual condition."""
        names = self.names
        difference = names[r"\mathfrak v^1"] - names[r"\mathfrak v"] - names[r"\mathfrak m"]
        return worst(vo.prove_equal(x.xreplace(self.rules)) for x in difference)

    def idle(self) -> vo.Verdict:
        """Whether a force at the body's point M does no work in a virtual displacement."""
        motion = self.surfaces.motion
        return worst(vo.prove_equal(motion.restrict(x), 0) for x in self.surfaces.contact.slip)

    def velocities_from_projections(self) -> vo.Verdict:
        """Whether (s, tau, n, m_u, m_v) are independent linear forms in the five velocities."""
        forms = vector((*self.surfaces.spin, *self.surfaces.contact.slip[:2]))
        dots = [vo.velocity(q) for q in COORDINATES]
        matrix = forms.jacobian(dots)
        linear = [vo.prove_equal(a, b) for a, b in zip(forms, matrix * vector(dots), strict=True)]
        verdict = worst(linear)
        return nonzero(matrix.det(method="berkowitz")) if verdict.proved else verdict


def principal_lines() -> vo.Verdict:
    """F = D' = 0 along lines of curvature.

    (1, 0) and (0, 1) are principal directions where E D' = F D and G D' = F D''.  Then
    F (E D'' - G D) vanishes, so F does where the principal curvatures differ, and E D' too.
    """
    e, f, g, d, mixed, dd = sp.symbols("E F G D D' D''")
    first, second = e * mixed - f * d, g * mixed - f * dd
    return vo.prove_equal(g * first - e * second, f * (e * dd - g * d))


def body_energy() -> Study:
    """The kinetic energy of a body along its principal axes."""
    found: dict[str, Any] = {r"\mathbf T": kinetic_energy(MASS, W, MOMENTS, P)}
    return Study({**found, **constants(), **components(W, P)})


def constants() -> dict[str, Any]:
    """Mass and principal moments."""
    return {r"\mathbf M": MASS, **dict(zip(("A", "B", "C"), MOMENTS, strict=True))}


def components(w: Any, p: Any) -> dict[str, Any]:
    """Velocity of O and angular velocity along the principal axes."""
    spelled = (r"\mathbf w_\mathbf x", r"\mathbf w_\mathbf y", r"\mathbf w_\mathbf z")
    return dict(zip((*spelled, "p", "q", "r"), (*w, *p), strict=True))


@dataclass(frozen=True)
class Attitude:
    """The principal axes O x y z at a moment: an arbitrary rotation of (u, v, n)."""

    arm: sp.Matrix
    matrix: sp.Matrix

    @classmethod
    def arbitrary(cls) -> Attitude:
        """Arm and rotation in symbols."""
        return cls(vector(sp.symbols("rho_u rho_v epsilon")), rotation(TURN))

    @property
    def centre(self) -> sp.Matrix:
        """The velocity of O along (u, v, n), from that of the contact: m - omega x OM."""
        return vector(SLIP) - vector(QUASI).cross(self.arm)

    @property
    def principal(self) -> tuple[sp.Matrix, sp.Matrix]:
        """Velocity of O and angular velocity along x, y, z."""
        return self.matrix * self.centre, self.matrix * vector(QUASI)

    def study(self) -> Study:
        """The two energies as functions of their arguments."""
        inertia = self.matrix.T * sp.diag(*MOMENTS) * self.matrix
        along = kinetic_energy(MASS, self.centre, ((inertia + inertia.T) / 2), QUASI)

        def bar(*values: Any) -> Any:
            return along.xreplace(dict(zip(ENERGY_ARGUMENTS, values, strict=True)))

        def plain(*values: Any) -> Any:
            return kinetic_energy(MASS, values[:3], MOMENTS, values[3:])

        projections = (rf"\mathfrak m_{axis}" for axis in AXES)
        return Study(
            {
                r"\bar{\mathbf T}": bar,
                r"\mathbf T": plain,
                **constants(),
                **components(*self.principal),
                **dict(zip(projections, SLIP, strict=True)),
                **dict(zip(("s", r"\tau", "n"), QUASI, strict=True)),
                r"\mathfrak w_\mathbf v": self.centre[1],
            },
            note=r"$\mathfrak w_\mathbf v$ read as the projection of the velocity of O on v",
        )


def particles(trace: str) -> Study:
    """Newton's laws for mass points that act on one another along their connecting lines.

    ``trace`` is the name of the velocity of M, which moves in any way.
    """
    masses = sp.symbols(f"m1:{PARTICLES + 1}", positive=True)
    places, speeds, forces = (
        [vector(sp.symbols(f"{x}{i}_1:4")) for i in range(1, PARTICLES + 1)] for x in "xwf"
    )
    point, speed = vector(sp.symbols("M_1:4")), vector(sp.symbols("dM_1:4"))
    rates = dict(zip(point, speed, strict=True))
    for i, (m, x, w) in enumerate(zip(masses, places, speeds, strict=True)):
        inner = [_strength(i, j) * (x - y) for j, y in enumerate(places) if j != i]
        rates |= dict(zip(x, w, strict=True))
        rates |= dict(zip(w, sum(inner, forces[i]) / m, strict=True))
    momenta = [m * w for m, w in zip(masses, speeds, strict=True)]
    arms = [x - point for x in places]
    none = sp.zeros(3, 1)
    moment = sum((a.cross(p) for a, p in zip(arms, momenta, strict=True)), none)
    names: dict[str, Any] = {
        r"\mathfrak M": sum(momenta, none),
        r"\mathbf F": sum(forces, none),
        r"\mathbf L^{(M)}": sum((a.cross(f) for a, f in zip(arms, forces, strict=True)), none),
        r"\mathbf G^{(M)}": moment,
        r"\tilde{\mathbf G}^{(M)}": moment,
        trace: speed,
    }
    return Study(
        names,
        motion=Motion(rates),
        labelled=frozenset({r"\mathfrak{v}"}),
        note="for mass points with inner forces along their connecting lines",
    )


def _strength(i: int, j: int) -> sp.Symbol:
    """What the inner force between two mass points is per distance."""
    return sp.Symbol(f"lambda_{min(i, j) + 1}{max(i, j) + 1}")
