"""The dictionaries of the section on a body with a gyroscope.

``WithGyroscope`` has arbitrary surfaces and an arbitrary inertia: the gyroscope's angle is a
coordinate of the engine's system, whose equations are projected on the fields that define s, tau,
n.  The equations of Newton and Euler, without the reaction at M, are proved to say the same; and
these hold for a point M that moves in any way, so that its velocity along n, which the contact
excludes, stays in them as a symbol: what the paper multiplies by it is compared, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study, shorten
from voronec.kinematics import kinetic_energy

from .body import DOTS, U, tensor
from .moments import SPEED
from .neumann import AXES, inertia_about_contact
from .rotor import AXIAL, COSINES, LETTERS, chi
from .surfaces import (
    BASE,
    COORDINATES,
    DETERMINANT_NOTE,
    FIBRE,
    MASS,
    NOTE,
    QUASI,
    SHAPES,
    SLIP,
    Surfaces,
    joint_verdict,
    unknown_contact,
    vector,
)

SOURCE = (
    "the equations derived for the system 'body-with-gyroscope', and the laws of Newton and Euler"
)
CLIMB, HEIGHT = sp.symbols("v_n h")
"""The velocity of M along n, and the height of M over the surface: at the moment, zero."""


@dataclass(frozen=True)
class Balance:
    """d/dt momentum + turning x momentum + trace x push = drive - k omega x axis."""

    rate: sp.Matrix
    momentum: sp.Matrix
    omega: sp.Matrix
    body: sp.Matrix
    trace: sp.Matrix
    push: sp.Matrix
    drive: sp.Matrix
    axial: sp.Expr
    axis: sp.Matrix

    @property
    def left(self) -> sp.Matrix:
        """What changes: the axes turn by omega - omega_1, and M moves."""
        turning = self.omega - self.body
        return self.rate + turning.cross(self.momentum) + self.trace.cross(self.push)

    @property
    def right(self) -> sp.Matrix:
        """What drives it."""
        return self.drive - self.axial * self.omega.cross(self.axis)

    @classmethod
    def of_letters(cls) -> Balance:
        """In the paper's names."""

        def triple(text: str, letters: tuple[str, ...] = LETTERS) -> sp.Matrix:
            return vector(sp.Symbol(text.replace("#", x)) for x in letters)

        return cls(
            triple(r"\frac{d}{dt}\frac{\partial\Theta}{\partial #}"),
            triple(r"\frac{\partial\Theta}{\partial #}"),
            triple("{#}"),
            triple("{#_1}"),
            triple(r"\mathfrak v_{#}", AXES),
            triple(r"\frac{\partial\bar{\mathbf T}}{\partial\mathfrak m_{#}}", AXES),
            triple(r"\frac{\partial\bar{\dot{U}}}{\partial #}"),
            sp.Symbol("{k}"),
            triple("{#}", COSINES),
        )


@dataclass(frozen=True)
class WithGyroscope:
    """Body and gyroscope on arbitrary surfaces."""

    surfaces: Surfaces
    eqs: Any
    axis: sp.Matrix

    @classmethod
    def derive(cls) -> WithGyroscope:
        """Derive the equations; the gyroscope's angle chi is a coordinate of the base."""
        contact = unknown_contact()
        axis = vector(sp.Function(x)(*COORDINATES[:2]) for x in ("alpha''", "beta''", "gamma''"))
        axial = axis.dot(vector(contact.spin)) + vo.velocity(chi)
        body = kinetic_energy(MASS, contact.centre_velocity, tensor(), contact.spin)
        system = vo.System(
            name="body-with-gyroscope",
            fibration=vo.Fibration(base=(*BASE, chi), fibre=FIBRE),
            lagrangian=body + AXIAL * axial**2 / 2 + U,
            constraints=contact.no_slip,
            parameters=(MASS, AXIAL),
        )
        eqs = vo.derive(system)
        return cls(Surfaces.of(contact, eqs), eqs, axis)

    @cached_property
    def spin(self) -> sp.Matrix:
        """(s, tau, n) on the constraints."""
        return self.surfaces.motion.restrict(self.surfaces.spin)

    @cached_property
    def slopes(self) -> sp.Matrix:
        """(s, tau, n) = slopes * (du/dt, dv/dt, dtheta/dt)."""
        return self.spin.jacobian(DOTS)

    @cached_property
    def rules(self) -> dict[sp.Expr, sp.Expr]:
        """Derivatives of the unknown functions."""
        body, fixed = self.surfaces.forms
        return {**fixed.rules(), **body.rules(vectors=(self.axis,), tensors=(tensor(),))}

    @cached_property
    def constraint_values(self) -> dict[sp.Expr, sp.Expr]:
        """What the symbols of a formula are on the constraints."""
        spin = dict(zip(QUASI, self.spin, strict=True))
        absent = dict.fromkeys((*SLIP, HEIGHT), sp.Integer(0))
        return {**self.surfaces.roots, **self.rules, **spin, **absent}

    @cached_property
    def motion(self) -> Motion:
        """s, tau, n change as their values in velocities do."""
        motion = self.surfaces.motion
        rates = dict(zip(QUASI, motion.derivative(self.spin), strict=True))
        # No acceleration: nothing here holds the second derivative of the height.
        climbing = {HEIGHT: CLIMB, CLIMB: sp.Integer(0)}
        return replace(motion, rates={**motion.rates, **rates, **climbing})

    @property
    def arm(self) -> sp.Matrix:
        """OM along (u, v, n)."""
        return self.surfaces.arm + vector((0, 0, HEIGHT))

    @property
    def trace(self) -> sp.Matrix:
        """The velocity of M against the body, along (u, v, n)."""
        return vector(self.surfaces.contact.body.trace_velocity) + vector((0, 0, CLIMB))

    @cached_property
    def axial(self) -> sp.Expr:
        """k: the momentum of the gyroscope's angle, where its speed is omega~."""
        spun = vo.velocity(chi)
        carried = self.axis.dot(self.surfaces.spin)
        momentum = sp.diff(self.eqs.system.lagrangian, spun)
        return shorten([momentum.xreplace({spun: SPEED - carried})])[0]

    @property
    def energies(self) -> tuple[sp.Expr, sp.Expr]:
        """T-bar in the slip and s, tau, n; Theta, where nothing slips."""
        centre = vector(SLIP) - vector(QUASI).cross(self.arm)
        energy = kinetic_energy(MASS, centre, tensor(), QUASI)
        return energy, energy.xreplace(dict.fromkeys(SLIP, sp.Integer(0)))

    @cached_property
    def power(self) -> sp.Expr:
        """dU/dt in s, tau, n."""
        return sp.Matrix([U]).jacobian(COORDINATES).dot(self.surfaces.fields * vector(QUASI))

    @cached_property
    def balance(self) -> Balance:
        """The moments about M along (u, v, n), from the energies."""
        bar, theta = self.energies
        momentum = vector(sp.diff(theta, w) for w in QUASI)
        return Balance(
            rate=self.motion.derivative(momentum),
            momentum=momentum,
            omega=vector(QUASI),
            body=-self.surfaces.body_frame,
            trace=self.trace,
            push=vector(sp.diff(bar, m) for m in SLIP),
            drive=vector(sp.diff(self.power, w) for w in QUASI),
            axial=self.axial,
            axis=self.axis,
        )

    @cached_property
    def residuals(self) -> tuple[sp.Expr, ...]:
        """The engine's mass * vdot - force for u, v, theta, chi."""
        raw, out = self.eqs.raw, self.eqs.bridge.outward_matrix
        dots = vector(vo.velocity(w) for w in (*DOTS, vo.velocity(chi)))
        return tuple(out(raw.mass) * dots - out([[x] for x in raw.force]))

    @cached_property
    def spin_residuals(self) -> tuple[sp.Expr, ...]:
        """The residuals of u, v, theta where the gyroscope's speed omega~ is constant; what turns
        chi by -axis . omega keeps that speed, and is part of s, tau and n."""
        carried = self.axis.dot(self.spin)
        rates = {
            vo.velocity(vo.velocity(chi)): -self.surfaces.motion.derivative(carried),
            vo.velocity(chi): SPEED - carried,
        }
        turned = [sp.diff(carried, w) for w in DOTS]
        rows = zip(self.residuals, turned, strict=False)
        return tuple((row - t * self.residuals[3]).xreplace(rates) for row, t in rows)

    @cached_property
    def newton(self) -> sp.Matrix:
        """d/dt (angular momentum about O) - OM x mass (acceleration of O) - torque about M.

        The law of moments about O, with the reaction that the law of motion of O gives.
        """
        omega, axial = vector(QUASI), self.axial
        turning = omega + self.surfaces.body_frame
        spin, speed = tensor() * omega + axial * self.axis, -omega.cross(self.arm)
        about, pull = (self.motion.derivative(x) + turning.cross(x) for x in (spin, speed))
        return about - self.arm.cross(MASS * pull) - self.balance.drive

    @cached_property
    def rows(self) -> sp.Matrix:
        """The equations along s, tau, n, proved to be the engine's, and to be the balance.

        The engine's rows are slopes^T times those; comparing in that direction needs no inverse.
        """
        rows = self.newton.xreplace(self.constraint_values)
        balance = (self.balance.left - self.balance.right).xreplace(self.constraint_values)
        contact = self.slopes.T * rows.xreplace({CLIMB: sp.Integer(0)})
        engine = vector(self.spin_residuals).xreplace(self.constraint_values)
        for mine, theirs in zip((*contact, *rows), (*engine, *balance), strict=True):
            verdict = vo.prove_equal(mine, theirs)
            if not verdict.proved:
                raise vo.DefinitionError(f"the balance of moments differs: {verdict.method}")
        return rows

    def terms(self, position: int) -> list[tuple[Any, Any]]:
        """A row as it stands in the balance of moments, in names."""
        spelled = Balance.of_letters()
        return [(spelled.left[position], spelled.right[position])]

    def constant_speed(self) -> vo.Verdict:
        """Whether the equation of chi says that omega~ is constant."""
        speed = self.axis.dot(self.spin) + vo.velocity(chi)
        rate = self.surfaces.motion.derivative(speed - vo.velocity(chi))
        rate += vo.velocity(vo.velocity(chi))
        return vo.prove_equal(self.residuals[3], AXIAL * rate)

    def commutators(self) -> vo.Verdict:
        """Whether the fields of s, tau, n are dual to these, and have the brackets of rotations."""
        return self.surfaces.commutators()

    def eight(self) -> vo.Verdict:
        """Whether coordinates and s, tau, n have determined derivatives: s, tau, n give the
        velocities by the relative curvature, and the inertia about M is not degenerate."""
        _ = self.rows
        slopes = self.slopes.det(method="berkowitz")
        found = [vo.prove_equal(slopes, -self.surfaces.area[0] * self.surfaces.curvature)]
        return joint_verdict([*found, inertia_about_contact()], DETERMINANT_NOTE)

    def studies(self) -> dict[str, Study]:
        """``motion``; and ``balance``, for the moments about M."""
        bar, theta = self.energies
        names: dict[str, Any] = {
            **self.surfaces.names(),
            "U": U,
            **dict(zip(LETTERS, QUASI, strict=True)),
            **dict(zip(("s_1", r"\tau_1", "n_1"), -self.surfaces.body_frame, strict=True)),
            **dict(zip((rf"\mathfrak v_{x}" for x in AXES), self.trace, strict=True)),
            **dict(zip((rf"\mathfrak m_{x}" for x in AXES), SLIP, strict=True)),
            **dict(zip(COSINES, self.axis, strict=True)),
            r"\bar{\mathbf T}": bar,
            r"\Theta": theta,
            r"\bar{\dot{U}}": self.power,
            r"\tilde C": AXIAL,
            r"\tilde\omega": SPEED,
            "k": self.axial,
        }
        note = f"{NOTE}, any inertia and any force function"
        study = Study(
            names,
            motion=self.motion,
            given=self.constraint_values,
            letters=SHAPES,
            context=self,
            note=note,
            source=SOURCE,
        )
        climbing = f"{note}, and for any velocity of $M$ along $\\mathbf n$"
        return {"motion": study, "balance": replace(study, note=climbing)}
