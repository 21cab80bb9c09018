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
    joint_verdict,
    u,
    u1,
    v,
    v1,
    vector,
)

TURN = sp.symbols("e_0:4")
QUATERNION = {"e": "$e_0$ to $e_3$ are the quaternion of a rotation"}
STRANGE = {
    **QUATERNION,
    r"\rho": r"$\rho_{u1}$, $\rho_{v1}$, $\epsilon_1$ are the coordinates of $M$ along "
    r"$\mathbf u_1, \mathbf v_1, \mathbf n_1$",
}
"""Letters that are not the paper's, in words."""
ARM = sp.symbols("x y z")
W, P = sp.symbols("w_x w_y w_z"), sp.symbols("p q r")
MOMENTS = sp.symbols("A B C", positive=True)
AXES = (r"\mathbf u", r"\mathbf v", r"\mathbf n")
ENERGY_ARGUMENTS = (*SLIP, *QUASI)


def rotation(quaternion: tuple[Any, ...]) -> sp.Matrix:
    """A rotation matrix from four numbers that are not all zero."""
    at = dict(zip(TURN, quaternion, strict=True))
    matrix = sp.Matrix(Rotation.quaternion(*TURN).matrix).xreplace(at)
    return matrix / sum(x**2 for x in quaternion)


def hat(turn: sp.Matrix) -> sp.Matrix:
    """The matrix of the product with a vector."""
    x, y, z = turn
    return sp.Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def vee(skew: sp.Matrix) -> sp.Matrix:
    """The vector of a skew matrix."""
    return sp.Matrix([skew[2, 1], skew[0, 2], skew[1, 0]])


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
    def turn_rate(self) -> sp.Matrix:
        """The rate of the matrix that turns (u, v, n) into (u1, v1, n1)."""
        return sp.Matrix(self.free.derivative(sp.Matrix(self.surfaces.contact.turn)))

    @cached_property
    def spin(self) -> sp.Matrix:
        """(s, tau, n) from the rotation of the body alone, R = B1 Q B^T: by the product rule
        B^T R^T dR/dt B = Q^T (B1^T dB1/dt) Q + Q^T dQ/dt - B^T dB/dt."""
        turn = sp.Matrix(self.surfaces.contact.turn)
        body, fixed = (hat(vector(forms.frame_rates)) for forms in self.surfaces.forms)
        return vee(turn.T * fixed * turn + turn.T * self.turn_rate - body)

    @cached_property
    def angular(self) -> dict[str, sp.Matrix]:
        """omega, and those of the frames against one another."""
        contact = self.surfaces.contact
        return {
            r"\omega": self.axes * self.spin,
            r"\omega_1": -self.axes * self.surfaces.body_frame,
            r"\omega_2": self.axes * vee(contact.turn.T * self.turn_rate),
            r"\omega_3": self.frame * vector(contact.fixed.frame_rates),
        }

    @cached_property
    def spins(self) -> dict[str, sp.Matrix]:
        """The angular velocities of the four frames against the space, by their rotations."""
        found = {"space": sp.zeros(3, 1), "body": self.axes * self.spin}
        for name, frame in (("fixed", self.frame), ("contact", self.axes)):
            found[name] = frame * vee(frame.T * sp.Matrix(self.free.derivative(frame)))
        return found

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
            **dict(zip(("s", r"\tau", "n"), self.spin, strict=True)),
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

        def study(motion: Motion, more: str = "") -> Study:
            return Study(
                self.names,
                motion=motion,
                labelled=frozenset({r"\mathfrak{v}"}),
                narrow_functions=True,
                given=self.rules,
                positive=self.surfaces.positive,
                context=self,
                note=NOTE,
                letters=STRANGE,
                source="positions and rotations, R^T dR/dt for the angular velocities, and the "
                f"forms of the surfaces{more}",
            )

        solved = "; the constraints as solved for the system 'contact'"
        return {"free": study(self.free), "rolling": study(self.surfaces.motion, solved)}

    def idle(self) -> vo.Verdict:
        """Whether the multipliers of the constraints are a force at the body's point M.

        A force X in space, with the torque OM x X about O, has the power X . dO/dt + (OM x X) .
        omega: for all five velocities that is the multipliers times the constraints, where the
        multipliers are the components of X along u1 and v1.  Its torque about M vanishes; what
        is along n does no work.
        """
        surfaces, names = self.surfaces, self.names
        force = vector(sp.symbols("X_u X_v X_n"))
        arm, push = names[r"\overrightarrow{OM}"], self.axes * force
        power = push.dot(self.free.derivative(names[r"\overrightarrow{O_1O}"]))
        power += arm.cross(push).dot(names[r"\omega"])
        multipliers = (sp.Matrix(surfaces.contact.turn) * force)[:2]
        work = vector(multipliers).dot(vector(surfaces.contact.no_slip))
        found = []
        for q in COORDINATES:
            mine, theirs = (sp.diff(x, vo.velocity(q)).xreplace(self.rules) for x in (power, work))
            found.append(vo.prove_equal(mine, theirs))
        return joint_verdict(found, "its power is that of the multipliers, for all five velocities")

    @cached_property
    def _forms(self) -> sp.Matrix:
        return vector((*self.surfaces.spin, *self.surfaces.contact.slip[:2]))

    def velocities_from_projections(self) -> vo.Verdict:
        """Whether (s, tau, n, m_u, m_v) are linear forms in the five velocities, with the
        determinant sqrt(E G E_1 G_1) times that of the relative curvature."""
        dots = vector(vo.velocity(q) for q in COORDINATES)
        matrix = self._forms.jacobian(dots)
        found = [vo.prove_equal(a, b) for a, b in zip(self._forms, matrix * dots, strict=True)]
        found.append(vo.prove_equal(matrix.det(method="berkowitz"), self.determinant))
        return joint_verdict(found, "linear forms, with the determinant that is derived")

    @property
    def determinant(self) -> sp.Expr:
        """That of (s, tau, n, m_u, m_v) by the velocities of u, v, u_1, v_1, theta."""
        return sp.Mul(*self.surfaces.area) * self.surfaces.curvature


def principal_lines() -> Study:
    """What F and D' are on each surface where the coordinate lines are lines of curvature.

    (1, 0) and (0, 1) are principal directions where the shape operator is diagonal: two linear
    equations for F and D', which are solved where the principal curvatures differ.
    """
    names: dict[str, Any] = {}
    for mark in ("", "_1"):
        spelled = [x + mark for x in ("E", "F", "G", "D", "D'", "D''")]
        e, f, g, d, mixed, dd = sp.symbols(spelled)
        shape = sp.Matrix([[g, -f], [-f, e]]) * sp.Matrix([[d, mixed], [mixed, dd]])
        unknown, conditions = vector((f, mixed)), vector((shape[0, 1], shape[1, 0]))
        constant = conditions.xreplace(dict.fromkeys(unknown, sp.Integer(0)))
        found = conditions.jacobian(unknown).LUsolve(-constant)
        names |= dict(zip(spelled, (e, found[0], g, d, found[1], dd), strict=True))
    source = "the shape operator, diagonal along the lines of curvature"
    return Study(names, note="where the principal curvatures differ", source=source)


def left_handed_frame() -> Study:
    """The axes x, y, z of a frame of negative orientation; products are the usual ones."""
    x, y, z = (sp.Matrix(row) for row in ((1, 0, 0), (0, 1, 0), (0, 0, -1)))
    names = {r"\mathbf x": x, r"\mathbf y": y, r"\mathbf z": z}
    return Study(names, context=(x.cross(y), z), source="the vector products of a frame")


def inertia_about_contact() -> vo.Verdict:
    """Whether the determinant of the inertia about M is positive, along the principal axes."""
    energy = kinetic_energy(MASS, -vector(P).cross(vector(ARM)), MOMENTS, P)
    tensor = vector(sp.diff(energy, w) for w in P).jacobian(P)
    return vo.prove_inequality(tensor.det(method="berkowitz"), ">", 0, real=ARM)


def body_energy() -> Study:
    """The kinetic energy of a body along its principal axes."""
    found: dict[str, Any] = {r"\mathbf T": kinetic_energy(MASS, W, MOMENTS, P)}
    source = "the kinetic energy of a rigid body, from its mass and its tensor of inertia"
    return Study({**found, **constants(), **components(W, P)}, source=source)


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
            context=self,
            source="the kinetic energy of a rigid body, by its inertia turned with the axes",
            note=r"$\mathfrak w_\mathbf v$ read as the projection of the velocity of O on v",
        )
