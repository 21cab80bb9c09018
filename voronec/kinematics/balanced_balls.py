"""Balanced balls that roll on a plane or a sphere, declared whole, by spin omega and normal gamma.

omega and gamma are along the ball's principal axes; gamma is the normal of the fixed surface at the
contact, towards the centre of the ball.  R1 is the signed radius of a fixed sphere, R2 that of the
ball, D = m R2^2 and epsilon = R1/(R1 + R2), which is 1 on a plane.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.algebra.text import as_expression
from voronec.declaration.claims import Case, Equation, Measure, Poisson
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.kinematics.balls import CYCLES, GAMMA, OMEGA, ZERO, RollingBall, contact_momentum
from voronec.kinematics.families import (
    FIXED_RADIUS,
    Words,
    constants,
    join_declarations,
    moment_words,
    rolling_ratio,
    rotor_words,
)
from voronec.kinematics.rubber import RubberMotion
from voronec.kinematics.vectors import Vector, cross, dot, matrix_product, three

TRACES = {"on the ball": ("u", "v"), "on the sphere": ("u1", "v1")}


@dataclass(frozen=True)
class BallMotion:
    """The motion of a balanced ball that rolls without slipping, reduced to omega and gamma.

        dG/dt = (G + kappa) x omega,    dgamma/dt = epsilon gamma x omega,
        G = I omega + D (omega - (omega, gamma) gamma)

    on a plane [Chaplygin1903] and on a sphere, with the constant momentum kappa of a gyroscope
    [Markeev1985; DragovicGajicJovanovic2020, eqs. (Chap), (Chap*)].

    inertia, contact_inertia, rotor, epsilon
        the principal moments, D, kappa, epsilon.
    """

    inertia: Vector
    contact_inertia: Any
    rotor: Vector = ZERO
    epsilon: Any = sp.Integer(1)

    @property
    def spin(self) -> sp.Matrix:
        """omega, as symbols."""
        return sp.Matrix(OMEGA)

    @property
    def normal(self) -> sp.Matrix:
        """gamma, as symbols."""
        return sp.Matrix(GAMMA)

    @cached_property
    def momentum(self) -> sp.ImmutableMatrix:
        """G, the angular momentum about the contact, without the gyroscope."""
        return contact_momentum(self.inertia, self.contact_inertia, OMEGA, GAMMA)

    @cached_property
    def whole(self) -> sp.ImmutableMatrix:
        """G + kappa, which is constant in space."""
        return self.momentum + sp.ImmutableMatrix(self.rotor)

    @cached_property
    def density(self) -> sp.Expr:
        """sqrt(1 - D ((I + D)^-1 gamma, gamma)), that of an invariant measure [Yaroshchuk1992].

        It is constant, 1 here, where the three moments are the same.
        """
        if len({*self.inertia}) == 1:
            return sp.Integer(1)
        steiner = self.contact_inertia
        terms = (steiner * g**2 / (i + steiner) for g, i in zip(GAMMA, self.inertia, strict=True))
        return sp.sqrt(1 - sp.Add(*terms))

    @cached_property
    def equations(self) -> dict[str, Equation]:
        """The equations of G and of gamma."""
        return {
            "momentum": Equation(tuple(self.momentum), cross(self.whole, self.spin)),
            "normal": Equation(GAMMA, cross(self.epsilon * self.normal, self.spin)),
        }

    @cached_property
    def integrals(self) -> dict[str, sp.Expr]:
        """The energy, the square of G + kappa, and on a plane its vertical component."""
        conserved = {
            "energy": dot(self.momentum, self.spin) / 2,
            "momentum squared": dot(self.whole, self.whole),
        }
        if self.epsilon == 1:
            conserved["vertical momentum"] = dot(self.whole, self.normal)
        return conserved

    @cached_property
    def linear_integral(self) -> sp.Expr:
        """sum of (I_1 + I_2 + I_3 - 2 I_i + D) G_i gamma_i [BorisovFedorov1995].

        It is constant where epsilon = -1, for a shell around a sphere of half its radius, without
        a gyroscope.
        """
        rows = zip(self.inertia, self.momentum, GAMMA, strict=True)
        trace = sp.Add(*self.inertia) + self.contact_inertia
        return sp.Add(*[(trace - 2 * i) * p * g for i, p, g in rows])

    @property
    def measure(self) -> Measure:
        """The invariant measure of gamma and omega."""
        return Measure(self.density, (*GAMMA, *OMEGA))

    @cached_property
    def poisson(self) -> Poisson:
        """On a plane the ball is Hamiltonian on (M, gamma), M = G + kappa [BorisovMamaev2001].

        The time is dtau = dt/root with the density ``root`` of the measure, and the bracket that of
        the ball without a gyroscope: {M_i, M_j} = -root (M_k - D (omega, gamma) gamma_k),
        {M_i, gamma_j} = -root gamma_k.
        """
        root, along = self.density, dot(self.spin, self.normal)
        momenta, bracket = sp.symbols("M1:4"), {}
        for i, j, k in CYCLES:
            bracket[momenta[i], momenta[j]] = -root * (
                momenta[k] - self.contact_inertia * along * GAMMA[k]
            )
            bracket[momenta[i], GAMMA[j]] = -root * GAMMA[k]
            bracket[momenta[i], GAMMA[k]] = root * GAMMA[j]
        return Poisson(
            variables={**dict(zip(momenta, self.whole, strict=True)), **{g: g for g in GAMMA}},
            bracket=bracket,
            hamiltonian=dot(self.momentum, self.spin) / 2,
            clock=1 / root,
        )


@dataclass(frozen=True)
class BalancedBall:
    """A balanced ball, with a gyroscope or without, that rolls on a plane or a sphere.

    ball
        the ball in Neumann's coordinates: contact, mass, moments.
    radius, fixed
        R2 and R1, the signed radius of a fixed sphere; nothing for a plane.
    rotor
        kappa, the momentum of the gyroscope.

    ``system`` declares it where it does not slip, ``rubber_system`` where it does not twist either,
    each with what is special beside.
    """

    ball: RollingBall
    radius: Any
    fixed: Any = None
    rotor: Vector = ZERO

    @classmethod
    def on_sphere(
        cls, fixed: Any, radius: Any, mass: Any, inertia: Sequence[Any], rotor: Sequence[Any] = ZERO
    ) -> BalancedBall:
        """On a sphere of signed radius ``fixed``: negative inside, and for a shell around it."""
        kappa = three(rotor, "the momentum of a rotor")
        return cls(RollingBall.on_sphere(fixed, radius, mass, inertia), radius, fixed, kappa)

    @classmethod
    def on_plane(
        cls, radius: Any, mass: Any, inertia: Sequence[Any], rotor: Sequence[Any] = ZERO
    ) -> BalancedBall:
        """On a plane, touched at (x, y)."""
        kappa = three(rotor, "the momentum of a rotor")
        return cls(RollingBall.on_plane(radius, mass, inertia), radius, None, kappa)

    @property
    def base(self) -> tuple[sp.Expr, ...]:
        """(u, v, theta), Neumann's coordinates of the ball."""
        return self.ball.base

    @property
    def fibre(self) -> tuple[sp.Expr, ...]:
        """(u1, v1) on the sphere, or (x, y) in the plane: the contact."""
        return self.ball.fibre

    @property
    def contact_inertia(self) -> sp.Expr:
        """D = m R2^2."""
        return as_expression(self.ball.mass * self.radius**2)

    @property
    def epsilon(self) -> sp.Expr:
        """R1/(R1 + R2), and 1 on a plane."""
        return rolling_ratio(self.fixed, self.radius)

    @cached_property
    def motion(self) -> BallMotion:
        """Its motion without slip, reduced to omega and gamma, with claims that always hold."""
        return BallMotion(self.ball.inertia, self.contact_inertia, self.rotor, self.epsilon)

    @property
    def horizontal_momentum(self) -> tuple[sp.Expr, ...]:
        """G + kappa along the x and y of a plane, where it is constant, in angles and omega."""
        whole = self.motion.whole.xreplace(dict(zip(GAMMA, self.ball.normal, strict=True)))
        return tuple(matrix_product(self.ball.contact.attitude[:2, :], whole))

    @cached_property
    def rubber(self) -> RubberMotion:
        """The rubber ball: it does not twist either."""
        x, y, z = (moment + self.contact_inertia for moment in self.ball.inertia)
        return RubberMotion((x, y, z), self.rotor, self.epsilon)

    def words(self, mass: str = "mass", radius: str = "radius of the ball") -> Words:
        """What its constants are."""
        return {
            self.fixed: FIXED_RADIUS,
            self.radius: (radius, True),
            self.ball.mass: (mass, True),
            **moment_words(self.ball.inertia),
            **rotor_words(self.rotor),
        }

    def scene(
        self, caption: str, end: float = 40.0, values: Mapping[Any, Any] | None = None
    ) -> Scene:
        """A motion from u = 2 with omega = (1/2, 1, 1), on a sphere from theta = u1 = 1; ``values``
        of constants are this scene's own."""
        (u, v, theta), fixed = self.ball.base, self.ball.fibre
        spun = dict(zip(OMEGA, (sp.Rational(1, 2), 1, 1), strict=True))
        placed = {} if self.fixed is None else {theta: 1, fixed[0]: 1}
        seen = () if self.fixed is None else (u, v)
        start, outputs = {u: 2, **placed, **spun}, (*seen, *fixed, *OMEGA)
        return Scene(start, (0.0, end), values or {}, outputs, caption)

    def rubber_scene(
        self,
        caption: str,
        end: float,
        start: Mapping[Any, Any] | None = None,
        values: Mapping[Any, Any] | None = None,
    ) -> Scene:
        """A motion of the contact from u = 6/5 with omega = (1/20, 1/5, ...), on a sphere from
        u1 = 1, but for what ``start`` gives; ``values`` of constants are this scene's own."""
        (u, v, _), fixed, (w1, w2) = self.base, self.fibre, self.rubber.velocities
        flat = self.fixed is None
        seen = (*fixed, u, v) if flat else (u, v, *fixed)
        placed = {} if flat else {fixed[0]: 1}
        usual: dict[Any, Any] = {u: "6/5", **placed, w1: "1/20", w2: "1/5"}
        return Scene({**usual, **(start or {})}, (0.0, end), values or {}, seen, caption)

    def system(self, *, values: Mapping[Any, Any], **declared: Any) -> System:
        """The system of this ball, with ``values`` of its constants, and what is special to it.

        The entries of ``declared`` that are mappings are added to those which every such ball has:
        equations, integrals, scenes (on a sphere of radius R1, outside, inside, as a shell).
        """
        words = self.words("mass of ball and rotor" if any(self.rotor) else "mass")
        common = {
            **self.ball.declared(rotor=self.rotor),
            "parameters": constants(values, words),
            "equations": self.motion.equations,
            "integrals": self.motion.integrals,
            "measure": self.motion.measure,
        }
        if self.fixed is not None:
            common["drawing"] = TRACES
        if isinstance(self.fixed, sp.Symbol):
            around = "A shell around a sphere of a third of its radius."
            third = {self.fixed: -sp.Rational(1, 3)}
            common["scenes"] = {
                "default": self.scene("Outside a sphere twice as large."),
                "inner": self.scene(
                    "Inside a sphere three times as large.", 60.0, {self.fixed: -3}
                ),
                "shell": self.scene(around, 60.0, third),
            }
        return join_declarations(common, declared)

    def rubber_system(self, *, values: Mapping[Any, Any], **declared: Any) -> System:
        """The system of the ball that does not twist, without scenes of its own.

        Without a gyroscope N is a reducing multiplier; with one the bracket alone says so.
        """
        motion, wheel = self.rubber, any(self.rotor)
        words = self.words(radius="radius" if self.fixed is None else "radius of the ball")
        common = {
            **self.ball.declared(rotor=self.rotor, twists=False),
            "parameters": constants(values, words),
            "equations": motion.equations,
            "integrals": motion.integrals,
            "measure": motion.measure,
            **({"poisson": motion.poisson} if wheel else {"multiplier": motion.reducer}),
        }
        return join_declarations(common, declared)


@dataclass(frozen=True)
class SymmetricBallMotion:
    """The elementary solution for a ball on a sphere with moments A, A, C and kappa = (0, 0, k).

    Along a motion sigma = (omega, gamma) is a function of x = gamma_3 with

        (A + b x^2) sigma'' + 3 b x sigma' + b (1 - mu^2) sigma = 0,    b = (C - A) D/(C + D),

    mu = 1/epsilon, and mu w = -A sigma' - x w' with w = (C - A) omega_3 + k.  Where
    y^2 = 1 + b x^2/A, y d(y sigma)/dx = (mu/A) partner and d(partner)/dx = mu b sigma, so that
    the pair (A c y sigma, partner), c^2 = |b|/A, turns through mu times the angle of x,
    hyperbolically where C > A [BorisovMamaev2002].
    """

    ball: BallMotion

    @property
    def x(self) -> sp.Expr:
        """gamma_3."""
        return GAMMA[2]

    @property
    def mu(self) -> sp.Expr:
        """1/epsilon = 1 + R2/R1."""
        return 1 / self.ball.epsilon

    @cached_property
    def sigma(self) -> sp.Expr:
        """(omega, gamma), the spin about the normal."""
        return dot(self.ball.spin, self.ball.normal)

    @cached_property
    def b(self) -> sp.Expr:
        """D (C - A)/(C + D)."""
        steiner, (a, _, c) = self.ball.contact_inertia, self.ball.inertia
        return steiner * (c - a) / (c + steiner)

    @cached_property
    def partner(self) -> sp.Expr:
        """b x sigma - w, which turns with A c y sigma."""
        return self.b * self.x * self.sigma - self._axial

    @property
    def _axial(self) -> sp.Expr:
        """w = (C - A) omega_3 + k."""
        a, _, c = self.ball.inertia
        return (c - a) * OMEGA[2] + self.ball.rotor[2]

    def pair(self, oblate: bool) -> sp.Expr:
        """A c y sigma, with c = sqrt(b/A) where C > A, ``oblate``, and sqrt(-b/A) where C < A."""
        a, x = self.ball.inertia[0], self.x
        return a * self.slope(oblate) * sp.sqrt(1 + self.b * x**2 / a) * self.sigma

    def slope(self, oblate: bool) -> sp.Expr:
        """c = sqrt(|b|/A)."""
        return sp.sqrt((self.b if oblate else -self.b) / self.ball.inertia[0])

    @cached_property
    def equations(self) -> dict[str, Equation]:
        """sigma and its derivative by x, as functions of the state, and how they change."""
        (a, _, _), x, mu, b = self.ball.inertia, self.x, self.mu, self.b
        first = -(mu * self._axial + b * (1 - mu) * x * self.sigma) / (a + b * x**2)
        second = -(3 * b * x * first + b * (1 - mu**2) * self.sigma) / (a + b * x**2)
        rate = self.ball.epsilon * (GAMMA[0] * OMEGA[1] - GAMMA[1] * OMEGA[0])  # of x
        return {
            "normal spin": Equation(self.sigma, first * rate),
            "normal spin, derived": Equation(first, second * rate),
        }

    @cached_property
    def cases(self) -> dict[str, Case]:
        """The constants of the solution, two integrals linear in omega: C > A, and C < A."""
        growth = sp.exp(self.mu * sp.asinh(self.slope(True) * self.x))
        angle = self.mu * sp.asin(self.slope(False) * self.x)
        spread, swing, partner = self.pair(True), self.pair(False), self.partner
        grown = {"growing": (spread - partner) * growth, "falling": (spread + partner) / growth}
        turned = {
            "cosine": swing * sp.cos(angle) - partner * sp.sin(angle),
            "sine": swing * sp.sin(angle) + partner * sp.cos(angle),
        }
        return {
            "oblate": Case({}, integrals=grown, integrable="Euler-Jacobi", note="C > A"),
            "prolate": Case({}, integrals=turned, integrable="Euler-Jacobi", note="C < A"),
        }
