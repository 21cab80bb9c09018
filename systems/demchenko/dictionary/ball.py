"""The dictionaries of the section on the gyroscopic ball.

``WithRotor`` has ball, rotor and sphere from the frames up: the rotor's angle is a coordinate, and
the moments of inertia are independent, so that the constant axial momentum and the role of
Zhukovsky's condition are derived.  ``Reduced`` is the system of this folder, with the momentum k as
a parameter and the condition built in.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study, shorten
from voronec.kinematics import RollingContact, Surface, kinetic_energy

u, v, theta, chi, u1, v1 = COORDINATES = sp.symbols("u v theta chi u1 v1")
s, tau, n, r2 = QUASI = sp.symbols("s tau n r2")
R1, R2, A1, A2, C1, C2, M = CONSTANTS = sp.symbols("R1 R2 A1 A2 C1 C2 M", positive=True)
GAMMA = sp.Symbol("Gamma")
VERTICAL = sp.Matrix([0, 0, 1])
SOURCE = (
    "the frames of ball, rotor and sphere, and the equations derived for the system "
    "'ball-with-rotor'"
)


@dataclass(frozen=True)
class Rolling:
    """A ball with a rotor on the outside of a sphere, before any constraint is imposed."""

    contact: RollingContact

    @classmethod
    def outer(cls) -> Rolling:
        """The ball in spherical coordinates, as the paper has it."""
        return cls(RollingContact(Surface.sphere(R2, u, v), Surface.sphere(R1, u1, v1), theta))

    @property
    def axes(self) -> sp.Matrix:
        """e_u, e_v, n of the ball at the contact, in space."""
        return sp.Matrix(self.contact.fixed.frame * self.contact.turn)

    @property
    def ball(self) -> sp.Matrix:
        """Angular velocity of the ball, along its own axes."""
        return sp.Matrix(self.contact.angular_velocity)

    @property
    def rotor_spin(self) -> sp.Matrix:
        """Angular velocity of the rotor, along the ball's axes."""
        return self.ball + VERTICAL * vo.velocity(chi)

    @property
    def rotor(self) -> sp.Matrix:
        """Angular velocity of the rotor, along its own axes, turned by chi against the ball's."""
        c, d = sp.cos(chi), sp.sin(chi)
        return sp.Matrix([[c, d, 0], [-d, c, 0], [0, 0, 1]]) * self.rotor_spin

    @property
    def centre(self) -> sp.Matrix:
        """Velocity of the centre along e_u, e_v, n."""
        return sp.Matrix(self.contact.centre_velocity)

    @property
    def energy(self) -> sp.Expr:
        """Kinetic energy of both bodies."""
        ball = kinetic_energy(M, self.centre, (A1, A1, C1), self.ball)
        return ball + kinetic_energy(0, (0, 0, 0), (A2, A2, C2), self.rotor)

    @cached_property
    def momentum(self) -> sp.Matrix:
        """Angular momentum of both about the contact point, along e_u, e_v, n."""
        spins = sp.diag(A1, A1, C1) * self.ball + sp.diag(A2, A2, C2) * self.rotor_spin
        orbital = M * sp.Matrix(self.contact.arm).cross(self.centre)
        return sp.Matrix(self.contact.body.frame.T * spins - orbital)

    def system(self) -> vo.System:
        """The declaration: the ball's contact point, the angle, the rotor's angle are the base."""
        frame = dict(zip(QUASI, (*self.contact.spin, self.rotor[2]), strict=True))
        return vo.System(
            name="ball-with-rotor",
            fibration=vo.Fibration(base=(u, v, theta, chi), fibre=(u1, v1)),
            frame=vo.Frame.quasi(frame),
            lagrangian=self.energy,
            constraints=self.contact.no_slip,
            parameters=CONSTANTS,
        )


@dataclass(frozen=True)
class WithRotor:
    """The derived system of ball and rotor."""

    rolling: Rolling
    eqs: Any
    motion: Motion

    @classmethod
    def derive(cls) -> WithRotor:
        """Derive it."""
        rolling = Rolling.outer()
        eqs = vo.derive(rolling.system())
        return cls(rolling, eqs, Motion.of(eqs).solved(eqs))

    def names(self) -> dict[str, Any]:
        """What the paper's letters stand for."""
        roll = self.rolling
        place = sp.Matrix(roll.contact.fixed.position)
        letters = r"t u v \vartheta u_1 v_1 s \tau n r_2 R_1 R_2 A_1 A_2 C_1 C_2 \mathbf{M} \Gamma"
        places = (vo.time, u, v, theta, u1, v1)
        symbols = (*places, *QUASI, *CONSTANTS, GAMMA)
        found: dict[str, Any] = dict(zip(letters.split(), symbols, strict=True))
        found |= {
            r"\tilde{\mathbf{T}}": roll.energy,
            r"\mathbf{w}": roll.axes * roll.centre,
            r"\tilde{\mathbf{G}}^{(M)}": roll.axes * roll.momentum,
            r"\mathfrak{v}": self.motion.derivative(place),
            r"\mathfrak{M}": M * roll.axes * roll.centre,
        }
        found |= self.constants() | ratios(self.eqs)
        vectors = {
            ("p_1", "q_1", "r_1"): roll.ball,
            ("p_2", "q_2"): roll.rotor[:2],
            (r"\alpha_1''", r"\beta_1''", r"\gamma_1''"): roll.axes.T * VERTICAL,
            ("x_1", "y_1", "z_1"): place,
            ("x", "y", "z"): roll.contact.attitude.T * (place - roll.contact.centre),
        }
        for names, vector in vectors.items():
            found |= dict(zip(names, vector, strict=True))
        return found

    def constants(self) -> dict[str, sp.Expr]:
        """P, I, A, C from the energy in s, tau, n; k, the momentum that belongs to chi.

        Along e_u of the equator, and along the axis of symmetry, lie e_v and the normal: that is
        where the coefficient of tau^2, and those of n^2 at the equator and at the pole, come from.
        """
        energy, velocities = self.motion.restrict(self.rolling.energy), vo.velocity(chi)
        P, spin = sp.diff(energy, tau, 2), sp.diff(energy, n, 2)
        k = self.motion.restrict(sp.diff(self.rolling.energy, velocities))
        values = [P, M * sp.diff(P, M), spin.subs(u, sp.pi / 2), spin.subs(u, 0), k]
        return dict(zip(("P", "I", "A", "C", "k"), shorten(values), strict=True))

    def condition(self) -> sp.Expr:
        """The C1 for which the momentum along the normal has the coefficient A of n, wherever."""
        coefficient = sp.diff(self.motion.restrict(self.rolling.momentum[2]), n)
        surplus = coefficient - self.constants()["A"]
        found = sp.solve(surplus.subs(u, 0), C1)[0]
        if not vo.prove_equal(surplus, (C1 - found) * sp.cos(u) ** 2).proved:
            raise vo.DefinitionError("the coefficient of n is not A + (C - A) cos^2 u")
        return found

    def projections(self) -> tuple[list[sp.Expr], list[sp.Expr]]:
        """A vertical vector of length Gamma, and the momentum, along e_u, e_v, n."""
        momentum = self.motion.restrict(self.rolling.momentum)
        return shorten(list(self.rolling.axes.T * VERTICAL * GAMMA)), shorten(list(momentum))

    def upright(self) -> dict[str, sp.Expr]:
        """s, tau, n where the momentum is vertical, of length Gamma: a linear system."""
        vertical, momentum = self.projections()
        equations = [a - b for a, b in zip(momentum, vertical, strict=True)]
        matrix, right = sp.linear_eq_to_matrix(equations, (s, tau, n))
        solution = shorten(list(matrix.LUsolve(right)))
        return dict(zip(("s", r"\tau", "n"), solution, strict=True))

    def in_velocities(self) -> dict[sp.Expr, sp.Expr]:
        """The quasi-velocities in terms of the velocities of the base, on the constraints."""
        base = [vo.velocity(q) for q in COORDINATES[: len(QUASI)]]
        equations = [rate - dot for rate, dot in zip(self.eqs.rates, base, strict=False)]
        matrix, right = sp.linear_eq_to_matrix(equations, QUASI)
        return dict(zip(QUASI, matrix.LUsolve(right), strict=True))

    def studies(self) -> dict[str, Study]:
        """The dictionaries of this system.

        ``rotor``; ``spheres``, with the coefficients of the forms of both and the torque that the
        momentum shows; ``zhukovsky``, under the derived condition on C_1; and ``upright``, where
        the axis z_1 is laid along the momentum besides.
        """
        names = self.names()
        condition = {C1: self.condition()}
        rotor = Study(
            names,
            motion=self.motion,
            in_velocities=self.in_velocities(),
            positive=(sp.sin(u), sp.sin(u1)),
            narrow_functions=True,
            context=self,
            source=SOURCE,
        )
        zhukovsky = replace(rotor, given=condition)
        spheres = replace(rotor, names={**names, **self.forms()}, given=upward())
        upright = Study(
            {**names, **self.upright()},
            motion=self.motion,
            narrow_functions=True,
            given=condition,
            context=self,
            source=f"{SOURCE}; a vertical momentum, by linear elimination",
        )
        return {"rotor": rotor, "zhukovsky": zhukovsky, "spheres": spheres, "upright": upright}

    def forms(self) -> dict[str, Any]:
        """The fundamental forms of both spheres, and the torque about the contact point."""
        roll = self.rolling
        found: dict[str, Any] = {}
        for surface, mark in ((roll.contact.body, ""), (roll.contact.fixed, "_1")):
            found |= dict(
                zip((f"E{mark}", f"F{mark}", f"G{mark}"), surface.first_form, strict=True)
            )
            second = (f"D{mark}", f"D'{mark}", f"D''{mark}")
            found |= dict(zip(second, surface.second_form, strict=True))
        names = self.names()
        rate = self.motion.along(self.motion.derivative(names[r"\tilde{\mathbf{G}}^{(M)}"]))
        torque = rate + names[r"\mathfrak{v}"].cross(names[r"\mathfrak{M}"])
        return {**found, r"\mathbf L^{(M)}": self.motion.restrict(torque)}

    def equation(self, row: int) -> sp.Expr:
        """Row of mass * vdot - force."""
        return residual(self.eqs, row)


def upward() -> dict[sp.Expr, sp.Expr]:
    """sin u and sin u_1 are positive: u and u_1 are distances from a pole."""
    found: dict[sp.Expr, sp.Expr] = {}
    for angle in (u, u1):
        root = sp.sqrt(sp.sin(angle) ** 2)
        found |= {root: sp.sin(angle), 1 / root: 1 / sp.sin(angle)}
    return found


@dataclass(frozen=True)
class ReducedBall:
    """The system ``demchenko``, derived."""

    eqs: Any

    @classmethod
    def derive(cls) -> ReducedBall:
        """Derive it."""
        from .. import SYSTEM

        return cls(vo.derive(SYSTEM))

    def study(self) -> Study:
        """The dictionary: coordinates, quasi-velocities and parameters of the system."""
        spelled = ("u", "v", r"\vartheta", "u_1", "v_1")
        names = dict(zip(spelled, self.eqs.coordinates, strict=True))
        names |= dict(zip(("s", r"\tau", "n"), self.eqs.velocities, strict=True))
        spelled = ("R_1", "R_2", r"\mathbf{M}", "A", "k")
        symbols = dict(zip(spelled, (p.symbol for p in self.eqs.system.parameters), strict=True))
        mass = symbols[r"\mathbf{M}"]
        P = self.eqs.mass[1, 1]
        names |= symbols | ratios(self.eqs) | {"P": P, "I": mass * sp.diff(P, mass)}
        motion = Motion.of(self.eqs).solved(self.eqs)
        sines = tuple(sp.sin(symbol) for symbol in (names["u"], names["u_1"]))
        names = {"t": vo.time, **names}
        return Study(names, motion=motion, positive=sines, narrow_functions=True, context=self)

    def equation(self, row: int) -> sp.Expr:
        """Row of mass * vdot - force."""
        return residual(self.eqs, row)


def ratios(eqs: Any) -> dict[str, sp.Expr]:
    """mu from tau = -mu udot; mu' from the constraint u1dot = -mu' udot sin theta + ..."""
    along = eqs.velocities[1]
    slope, fibre = (sp.diff(rate, along) for rate in (eqs.rates[0], eqs.rates[-2]))
    ratio = -fibre / slope / sp.sin(eqs.coordinates[2])
    return dict(zip((r"\mu", r"\mu'"), shorten([-1 / slope, ratio]), strict=True))


def residual(eqs: Any, row: int) -> sp.Expr:
    """Row of mass * vdot - force, which vanishes along the motion."""
    dots = sp.Matrix([vo.velocity(w) for w in eqs.velocities])
    return (eqs.mass * dots - eqs.force)[row]
