"""The ball that neither slips nor turns about the common normal, and Veselova's rigid body.

Both have two degrees of freedom: omega_1 and omega_2 are the quasi-velocities, and omega_3 follows
from (omega, gamma) = 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study, Verdict, shorten
from voronec.kinematics import Rotation, Surface, kinetic_energy

from .chaplygin_balls import (
    GAMMA,
    MOMENTS,
    OMEGA,
    POINT,
    R1,
    R2,
    Ball,
    D,
    M,
    rolling_ball,
    tensor,
    theta,
    u,
    u1,
    v,
    v1,
)
from .measures import density, quadratic
from .verdicts import all_equal

phi, psi = sp.symbols("phi psi")
THIRD = -(OMEGA[0] * GAMMA[0] + OMEGA[1] * GAMMA[1]) / GAMMA[2]
AREA = 1 / GAMMA[2]


def rubber_system(fixed: Surface) -> vo.System:
    """The ball on a fixed surface with the third constraint."""
    rolling = rolling_ball(fixed)
    return vo.System(
        name="rubber-ball",
        fibration=vo.Fibration((u, v), (u1, v1, theta)),
        frame=vo.Frame.quasi(dict(zip(OMEGA[:2], rolling.spin[:2], strict=True))),
        lagrangian=rolling.energy,
        constraints=(*rolling.no_slip, rolling.no_twist),
        parameters=tuple(
            x
            for x in (R1, R2, M, *MOMENTS)
            if rolling.energy.has(x) or any(e.has(x) for e in rolling.no_slip)
        ),
        invariants=dict(zip(map(str, GAMMA), rolling.normal, strict=True)),
    )


def veselova_system() -> vo.System:
    """A rigid body with moments I_i + D about a fixed point, which does not turn about gamma,
    a direction fixed in space."""
    rotation = Rotation.euler("zxz", phi, theta, psi)
    rates = rotation.body_rates
    return vo.System(
        name="veselova",
        fibration=vo.Fibration((theta, psi), (phi,)),
        frame=vo.Frame.quasi(dict(zip(OMEGA[:2], rates[:2], strict=True))),
        lagrangian=kinetic_energy(0, (0, 0, 0), [x + D for x in MOMENTS], rates),
        constraints=(rotation.space_rates[2],),
        parameters=(M, R2, *MOMENTS),
        invariants=dict(zip(map(str, GAMMA), rotation.matrix[2, :], strict=True)),
    )


@dataclass(frozen=True)
class Rubber:
    """Its equations in omega_1, omega_2 and gamma, and the same ball without the constraint."""

    reduced: Any
    free: Ball

    @classmethod
    def on_sphere(cls, radius: Any) -> Rubber:
        """Rolling on a sphere; a negative radius is touched from inside."""
        fixed = Surface.sphere(radius, u1, v1)
        return cls(vo.descend(rubber_system(fixed)), Ball.on_sphere(radius))

    @classmethod
    def on_plane(cls) -> Rubber:
        """Rolling on a plane."""
        return cls(vo.descend(rubber_system(Surface.plane(u1, v1))), Ball.on_plane())

    @property
    def relations(self) -> tuple[sp.Expr, ...]:
        """gamma is a unit vector."""
        return tuple(self.reduced.relations)

    @cached_property
    def motion(self) -> Motion:
        """How the state changes, with omega_3 on the constraint."""
        dots = [vo.velocity(w) for w in OMEGA[:2]]
        accelerations = self.reduced.mass.LUsolve(self.reduced.force)
        return Motion(
            rates=dict(zip((*GAMMA, *OMEGA[:2]), (*self.normal_rate, *dots), strict=True)),
            constrained={OMEGA[2]: THIRD},
            accelerations=dict(zip(dots, accelerations, strict=True)),
        )

    @cached_property
    def flow(self) -> dict[sp.Expr, sp.Expr]:
        """The vector field in the space of omega_1, omega_2 and gamma."""
        return {x: self.motion.along(rate) for x, rate in self.motion.rates.items()}

    @cached_property
    def normal_rate(self) -> sp.Matrix:
        """The rate epsilon gamma x omega of gamma, which keeps |gamma| wherever gamma is.

        Epsilon stands in the rate of gamma_3, which is free of omega_3.
        """
        factor = -sp.diff(self.reduced.rates[2], OMEGA[0]) / GAMMA[1]
        (epsilon,) = shorten([factor], self.relations)
        return epsilon * GAMMA.cross(OMEGA).xreplace({OMEGA[2]: THIRD})

    @cached_property
    def no_twist(self) -> Verdict:
        """Whether gamma turns so, with omega_3 by (omega, gamma) = 0.

        The rates of the system have omega_3 eliminated by the engine, from the velocities alone.
        """
        return all_equal(zip(self.normal_rate, self.reduced.rates, strict=True), self.relations)

    @cached_property
    def momentum(self) -> sp.Matrix:
        """G of the free ball, on the constraint."""
        return sp.Matrix(self.motion.restrict(self.free.momentum))

    @cached_property
    def multiplier(self) -> sp.Expr:
        """The component along gamma of dG/dt - G x omega."""
        rate = self.motion.along(self.motion.derivative(self.momentum))
        return (rate - self.momentum.cross(self.motion.restrict(OMEGA))).dot(GAMMA)

    @cached_property
    def density(self) -> sp.Expr:
        """A power of the determinant of the inertia in the plane normal to gamma, the power found.

        On the constraint, the volume of the space of omega is domega_1 domega_2 / |gamma_3|.
        """
        area = self.reduced.mass.det() / AREA**2 / tensor().det()
        base = quadratic(shorten([area], self.relations)[0], GAMMA, self.relations)
        return density(base, self.flow, POINT, AREA)

    def measure(self, _: Any = None) -> Verdict:
        """Whether that is invariant."""
        weight = self.density * AREA
        return vo.prove_equal(vo.divergence(weight, self.flow), 0, self.relations)

    def study(self) -> Study:
        """The dictionary; omega_3 is proved to be what the engine's elimination gives."""
        if not self.no_twist.proved:
            raise vo.DefinitionError(f"omega_3 is not what was eliminated: {self.no_twist.method}")
        names = self.free.names()
        for name in ("F_1", "F_2", "F_3", "F_4", r"\mu"):
            names.pop(name, None)
        names |= {
            r"\mathbf G": self.momentum,
            r"\dot\gamma": sp.Matrix(self.motion.restrict(self.reduced.rates)),
            r"\lambda": self.multiplier,
            r"\mu_\epsilon": self.density,
        }
        return Study(
            names,
            motion=self.motion,
            relations=self.relations,
            functions=frozenset({r"\mu"}),
            context=self,
            source="the equations derived for the system 'rubber-ball', which does not turn about "
            "the normal, and those of the system 'ball', which does",
            note="where (gamma, gamma) = 1 and (omega, gamma) = 0",
        )


def is_veselovas(rubber: Rubber) -> Verdict:
    """Whether the equations of Veselova's body are those of the rubber ball."""
    ours, theirs = rubber.reduced, vo.descend(veselova_system())
    pairs = [*zip(ours.rates, theirs.rates, strict=True)]
    pairs += zip(ours.mass.LUsolve(ours.force), theirs.mass.LUsolve(theirs.force), strict=True)
    return all_equal(pairs, rubber.relations)
