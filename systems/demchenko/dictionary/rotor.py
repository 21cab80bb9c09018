"""Body and gyroscope taken apart, each with moments of its own, at one moment of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study
from voronec.kinematics import kinetic_energy

from .neumann import QUATERNION, TURN, Attitude, rotation
from .surfaces import MASS, QUASI, vector
from .verdicts import worst

chi = sp.Symbol("chi")
AXIAL = sp.Symbol("C~", positive=True)
LETTERS = ("s", r"\tau", "n")
COSINES = (r"\alpha''", r"\beta''", r"\gamma''")


@dataclass(frozen=True)
class Rotor:
    """Body and gyroscope with moments of their own; the gyroscope is turned by chi about z."""

    attitude: Attitude
    body: tuple[sp.Symbol, ...]
    gyroscope: tuple[sp.Symbol, ...]

    @classmethod
    def arbitrary(cls) -> Rotor:
        """All moments in symbols; the gyroscope is symmetric about its axis."""
        across = sp.Symbol("A_2", positive=True)
        moments = sp.symbols("A_1 B_1 C", positive=True)
        return cls(Attitude.arbitrary(), moments, (across, across, AXIAL))

    @property
    def gyroscope_spin(self) -> sp.Matrix:
        """Angular velocity of the gyroscope along x, y, z."""
        return self.attitude.principal[1] + vector((0, 0, vo.velocity(chi)))

    @property
    def energy(self) -> sp.Expr:
        """The kinetic energy of both."""
        w, p = self.attitude.principal
        c, s = sp.cos(chi), sp.sin(chi)
        turned = sp.Matrix([[c, s, 0], [-s, c, 0], [0, 0, 1]]) * self.gyroscope_spin
        own = kinetic_energy(MASS, w, self.body, p)
        return own + kinetic_energy(0, (0, 0, 0), self.gyroscope, turned)

    @property
    def moment(self) -> sp.Matrix:
        """Angular momentum of both about M along (u, v, n)."""
        spins = sp.diag(*self.body) * self.attitude.principal[1]
        spins += sp.diag(*self.gyroscope) * self.gyroscope_spin
        orbital = self.attitude.arm.cross(MASS * self.attitude.centre)
        return self.attitude.matrix.T * spins - orbital

    @property
    def axial(self) -> sp.Matrix:
        """What the gyroscope itself has of angular momentum along its axis, along (u, v, n)."""
        along = sp.diag(0, 0, 1) * sp.diag(*self.gyroscope) * self.gyroscope_spin
        return self.attitude.matrix.T * along

    def study(self) -> Study:
        """The dictionary; A and B are those of body and gyroscope together, C is the body's."""
        (w, p), matrix = self.attitude.principal, self.attitude.matrix
        a, b, c = self.body
        moments = (a + self.gyroscope[0], b + self.gyroscope[1], c)
        inertia = matrix.T * sp.diag(*moments) * matrix
        along = kinetic_energy(MASS, self.attitude.centre, (inertia + inertia.T) / 2, QUASI)
        names: dict[str, Any] = {
            **dict(zip(("A", "B", "C"), moments, strict=True)),
            **dict(zip(LETTERS, QUASI, strict=True)),
            **dict(zip(("p", "q", "r"), p, strict=True)),
            **dict(zip(COSINES, matrix.row(2), strict=True)),
            r"\mathbf M": MASS,
            r"\tilde C": AXIAL,
            r"\tilde\omega": self.gyroscope_spin[2],
            "k": sp.diff(self.energy, vo.velocity(chi)),
            r"\kappa": self.axial,
            r"\mathbf z": matrix.row(2).T,
            r"\mathbf T": kinetic_energy(MASS, w, moments, p),
            r"\bar{\mathbf T}": along,
            r"\tilde{\mathbf T}": self.energy,
            r"\tilde{\mathbf G}^{(M)}": self.moment,
            r"\mathbf G^{(M)}": self.moment.xreplace({vo.velocity(chi): -p[2]}),
        }
        source = "the energies and momenta of body and gyroscope, each with moments of its own"
        return Study(names, context=self, source=source)


@dataclass(frozen=True)
class TurningAxes:
    """The axes (u, v, n) in the body: any rotation that changes in any way."""

    @property
    def matrix(self) -> sp.Matrix:
        """Components along (u, v, n) to components along x, y, z."""
        return rotation(TURN)

    @property
    def motion(self) -> Motion:
        """The rotation is free."""
        return Motion({x: vo.velocity(x) for x in TURN})

    @property
    def relative(self) -> sp.Matrix:
        """omega_1, by its definition: that of the body against (u, v, n), along these axes."""
        rate = self.matrix.T * self.motion.derivative(self.matrix)
        return -vector((rate[2, 1], rate[0, 2], rate[1, 0]))

    @property
    def axis(self) -> sp.Matrix:
        """z along (u, v, n)."""
        return self.matrix.row(2).T

    def cosines(self) -> vo.Verdict:
        """Whether all three cosines follow the kinematic equations."""
        rates, turned = self.motion.derivative(self.axis), self.relative.cross(self.axis)
        return worst(vo.prove_equal(a, b) for a, b in zip(rates, turned, strict=True))

    def study(self) -> Study:
        """The dictionary."""
        names = {"t": vo.time, **dict(zip(COSINES, self.axis, strict=True))}
        names |= dict(zip(("s_1", r"\tau_1", "n_1"), self.relative, strict=True))
        return Study(
            names,
            motion=self.motion,
            context=self,
            note="for any rotation of the axes",
            letters=QUATERNION,
            source="the kinematics R^T dR/dt of any rotation",
        )
