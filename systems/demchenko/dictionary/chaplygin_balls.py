"""A dynamically non-symmetric ball, with or without a gyroscope, on a sphere or on a plane.

The ball is derived in Neumann's coordinates and brought down to omega and gamma, the normal of the
fixed surface, both along the ball's principal axes.  A sphere of negative radius is one that is
touched from inside, or that lies within the ball.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Range, Study, Verdict, shorten
from voronec.kinematics import RollingBall, Surface

from .measures import density, quadratic
from .verdicts import all_equal, worst

u, v, theta, u1, v1 = sp.symbols("u v theta u1 v1")
OMEGA = sp.Matrix(sp.symbols("omega1:4"))
GAMMA = sp.Matrix(sp.symbols("gamma1:4"))
KAPPA = sp.ImmutableMatrix(sp.symbols("kappa1:4"))
MOMENTS = sp.symbols("I1:4", positive=True)
R1, R2, M = sp.symbols("R1 R2 M", positive=True)
SIGNED_RADIUS = sp.Symbol("R")
D = M * R2**2
POINT, OTHER = (
    dict(zip((*GAMMA, *OMEGA), sp.sympify(numbers.split()), strict=True))
    for numbers in ("2/7 3/7 6/7 1 5 -3", "1/9 -4/9 8/9 2 1 7")
)

_p, _q = sp.symbols("p q", positive=True)
CONFIGURATIONS = (
    Range("outer rolling", r"\epsilon=R_1/(R_1+R_2)", {SIGNED_RADIUS: _p}, (_p,)),
    Range("inner rolling", r"\epsilon=R_1/(R_1-R_2), R_1>R_2", {SIGNED_RADIUS: -R2 - _p}, (_p,)),
    Range(
        "shell rolling",
        r"\epsilon=R_1/(R_1-R_2), R_1<R_2",
        {SIGNED_RADIUS: -_p, R2: _p + _q},
        (_p, _q),
    ),
)


def rolling_ball(fixed: Surface) -> RollingBall:
    """The ball before it is brought down, on a fixed surface in the coordinates u1, v1."""
    return RollingBall.on(fixed, R2, M, MOMENTS)


def system_of(ball: RollingBall, kappa: sp.Matrix) -> vo.System:
    """The declaration, with a gyroscope's momentum."""
    spin = sp.Matrix(ball.spin)

    def holds(symbol: sp.Symbol) -> bool:
        return any(e.has(symbol) for e in (ball.energy, *ball.no_slip, *kappa))

    return vo.System(
        name="ball",
        fibration=vo.Fibration((u, v, theta), (u1, v1)),
        frame=vo.Frame.quasi(dict(zip(OMEGA, spin, strict=True))),
        lagrangian=ball.energy + kappa.dot(spin),
        constraints=ball.no_slip,
        parameters=tuple(x for x in (R1, R2, M, *MOMENTS, SIGNED_RADIUS, *KAPPA) if holds(x)),
        invariants=dict(zip(map(str, GAMMA), ball.normal, strict=True)),
    )


@dataclass(frozen=True)
class Ball:
    """The equations in omega and gamma."""

    reduced: Any
    kappa: sp.Matrix
    more: Mapping[str, sp.Expr] = field(default_factory=dict)

    @classmethod
    @cache  # dictionaries and sentences ask for the same few balls
    def on(cls, fixed: Surface, kappa: sp.ImmutableMatrix | None = None) -> Ball:
        """Derive them."""
        still = sp.zeros(3, 1) if kappa is None else kappa
        return cls(vo.descend(system_of(rolling_ball(fixed), still)), still)

    @classmethod
    def on_sphere(cls, radius: Any, kappa: sp.ImmutableMatrix | None = None) -> Ball:
        """Rolling on a sphere; a negative radius as said above."""
        return cls.on(Surface.sphere(radius, u1, v1), kappa)

    @classmethod
    def on_plane(cls, kappa: sp.ImmutableMatrix | None = None) -> Ball:
        """Rolling on a plane."""
        return cls.on(Surface.plane(u1, v1), kappa)

    @property
    def relations(self) -> tuple[sp.Expr, ...]:
        """gamma is a unit vector."""
        return tuple(self.reduced.relations)

    @cached_property
    def momentum(self) -> sp.Matrix:
        """G, without the gyroscope."""
        return sp.Matrix(self.reduced.momenta)

    @cached_property
    def epsilon(self) -> sp.Expr:
        """The factor in gammadot: the coefficient of gamma_2 omega_3 in the rate of gamma_1."""
        return shorten([sp.diff(self.reduced.rates[0], GAMMA[1], OMEGA[2])])[0]

    @cached_property
    def surplus(self) -> sp.Expr:
        """D in G = I omega + D omega - D (omega, gamma) gamma, by its part off the diagonal."""
        return shorten([-sp.diff(self.momentum[0], OMEGA[1]) / (GAMMA[0] * GAMMA[1])])[0]

    @cached_property
    def motion(self) -> Motion:
        """How omega and gamma change."""
        dots = [vo.velocity(w) for w in OMEGA]
        accelerations = self.reduced.mass.LUsolve(self.reduced.force)
        return Motion(
            rates=dict(zip((*GAMMA, *OMEGA), (*self.reduced.rates, *dots), strict=True)),
            accelerations=dict(zip(dots, accelerations, strict=True)),
        )

    @cached_property
    def flow(self) -> dict[sp.Expr, sp.Expr]:
        """The vector field in the space of gamma and omega."""
        return {x: self.motion.along(rate) for x, rate in self.motion.rates.items()}

    @cached_property
    def density(self) -> sp.Expr:
        """Of an invariant measure: a power of det(I^-1 dG/domega), the power found."""
        base = quadratic(self.reduced.mass.det() / tensor().det(), GAMMA, self.relations)
        return density(base, self.flow, POINT)

    def measure(self, where: Range | None = None) -> Verdict:
        """Whether that is invariant, in a range of the parameters."""
        return self._vanishes(vo.divergence(self.density, self.flow), where)

    def _vanishes(self, value: sp.Expr, where: Range | None) -> Verdict:
        values = {} if where is None else dict(where.values)
        return vo.prove_equal(value.xreplace(values), 0, self.relations)

    def wider_density(self) -> str:
        """The density where gamma is not a unit vector, for the equations that G = I omega -
        D (omega, gamma) gamma defines there; proved."""
        momentum = tensor() * OMEGA - D * OMEGA.dot(GAMMA) * GAMMA
        turned = self.epsilon * GAMMA.cross(OMEGA)
        right = momentum.cross(OMEGA) - momentum.jacobian(GAMMA) * turned
        rates = momentum.jacobian(OMEGA).LUsolve(right)
        weight = sp.sqrt(1 - D * (tensor().inv() * GAMMA).dot(GAMMA))
        flow = dict(zip((*GAMMA, *OMEGA), (*turned, *rates), strict=True))
        proved = vo.prove_equal(vo.divergence(weight, flow), 0).proved
        return r"\mu=\sqrt{1-D(\mathbf I^{-1}\gamma,\gamma)}\quad\text{for all }\gamma" * proved

    @cached_property
    def energy(self) -> sp.Expr:
        """The kinetic energy, by the mass matrix."""
        return (OMEGA.T * self.reduced.mass * OMEGA)[0] / 2

    @cached_property
    def integrals(self) -> dict[str, sp.Expr]:
        """|gamma|^2, the energy, the square and the normal part of the whole momentum."""
        whole = self.momentum + self.kappa
        return {
            "F_1": GAMMA.dot(GAMMA),
            "F_2": self.energy,
            "F_3": whole.dot(whole),
            "F_4": whole.dot(GAMMA),
            **self.more,
        }

    def constant(self, value: sp.Expr, where: Range | None = None) -> Verdict:
        """Whether a function of the state is an integral, in a range of the parameters."""
        return self._vanishes(self.motion.along(self.motion.derivative(value)), where)

    def still(self, name: str) -> list[tuple[str, sp.Expr]]:
        """For print: the rate of an integral along the motion, in normal form."""
        rate = self.motion.along(self.motion.derivative(self.integrals[name]))
        return [(rf"\frac{{d}}{{dt}}{name}", shorten([rate], self.relations)[0])]

    def constants(self, names: Sequence[str], where: Range | None = None) -> Verdict:
        """Whether several of the integrals are ones."""
        return worst(self.constant(self.integrals[name], where) for name in names)

    def independent(self, names: Sequence[str]) -> Verdict:
        """Whether integrals have independent gradients at a point, by exact numbers."""
        numbers = dict(
            zip((*MOMENTS, M, R2, *KAPPA), sp.sympify("2 3 5 1 1 3 7 2".split()), strict=True)
        )
        numbers |= {R1: sp.Integer(2), SIGNED_RADIUS: sp.Integer(2), **POINT}
        values = sp.Matrix([self.integrals[name] for name in names])
        rank = values.jacobian((*GAMMA, *OMEGA)).xreplace(numbers).rank()
        if rank == len(names):
            return Verdict("proved", f"their gradients have the rank {rank} at a point")
        return Verdict("undecided", f"their gradients have the rank {rank} at a point")

    @cached_property
    def weighted_momentum(self) -> sp.Expr:
        """The only sum b_i G_i gamma_i, up to a factor, that can be an integral."""
        return self._sum(self.momentum, GAMMA)

    @cached_property
    def integral_forms(self) -> dict[str, sp.Expr]:
        """The same integrals, found: sums of squares and products by ``_sum``, and the energy.

        On a plane the normal part of the momentum is among them.
        """
        whole, rest = self.momentum + self.kappa, list(self.integrals)[4:]
        sums = {"F_1": self._sum(GAMMA, GAMMA), "F_3": self._sum(whole, whole)}
        if self.epsilon == 1:
            sums["F_4"] = self._sum(whole, GAMMA)
        return {"F_2": self.energy, **sums, **{name: self.integrals[name] for name in rest}}

    def _sum(self, left: sp.Matrix, right: sp.Matrix) -> sp.Expr:
        """The only sum b_i left_i right_i, up to a factor, that can be an integral.

        Its rate is linear in b; at two points that leaves one direction.  Whether the rate
        vanishes everywhere remains to be proved.
        """
        rates = dict(zip((*GAMMA, *self.momentum), self._changes, strict=True))
        rates |= {g + k: rates[g] for g, k in zip(self.momentum, self.kappa, strict=True)}
        row = [rates[a] * b + a * rates[b] for a, b in zip(left, right, strict=True)]
        first, second = (sp.Matrix(shorten([e.xreplace(p) for e in row])) for p in (POINT, OTHER))
        factors = zip(least(first.cross(second)), left, right, strict=True)
        return sp.Add(*[b * a * c for b, a, c in factors])

    @property
    def _changes(self) -> tuple[sp.Expr, ...]:
        """The rates of gamma and of G."""
        return (*self.reduced.rates, *self.reduced.momentum_rates)

    def names(self) -> dict[str, Any]:
        """What the paper's letters stand for."""
        found: dict[str, Any] = {
            "t": vo.time,
            "R_1": R1,
            "R_2": R2,
            r"\mathbf M": M,
            "D": self.surplus,
            r"\epsilon": self.epsilon,
            r"\omega": OMEGA,
            r"\gamma": GAMMA,
            r"\mathbf G": self.momentum,
            r"\mathbb I": sp.diag(*MOMENTS),
            r"\mathbf I": tensor(),
            r"\mathbb E": sp.eye(3),
            r"\mu": self.density,
        }
        if not self.kappa.is_zero_matrix:  # the letter of a gyroscope, where there is one
            found[r"\kappa"] = self.kappa
        for i in (1, 2, 3):
            found[f"I_{i}"] = MOMENTS[i - 1]
            found[rf"\gamma_{i}"] = GAMMA[i - 1]
            found[rf"\omega_{i}"] = OMEGA[i - 1]
            found[rf"\mathbf G_{i}"] = self.momentum[i - 1]
        return found | self.integral_forms

    def study(self, more: Mapping[str, Any] | None = None, ranges: Any = ()) -> Study:
        """The dictionary; ``more`` adds names."""
        names = {**self.names(), **(more or {})}
        return Study(
            names,
            motion=self.motion,
            relations=self.relations,
            ranges=ranges,
            functions=frozenset({r"\mu"}),
            context=self,
            note="where (gamma, gamma) = 1" + self._epsilon_note,
            source="the equations derived for the system 'ball', in omega and the normal",
        )

    @property
    def _epsilon_note(self) -> str:
        """The value of epsilon, where it is a number."""
        return f", for epsilon = {self.epsilon}" if self.epsilon.is_Number else ""

    def with_linear_integral(self) -> Study:
        """The dictionary with the integral linear in the momentum and in the normal."""
        found = {r"\tilde F_4": self.weighted_momentum}
        return replace(self.study(found), context=replace(self, more=found))


def momentum_is_about_contact() -> Verdict:
    """Whether mass times omega is the angular momentum about the point of contact."""
    ball = rolling_ball(Surface.sphere(SIGNED_RADIUS, u1, v1))
    eqs = vo.derive(system_of(ball, sp.zeros(3, 1)))
    found = Motion.of(eqs).restrict(sp.Matrix(ball.momentum))
    return all_equal(zip(eqs.mass * OMEGA, found, strict=True))


def least(direction: sp.Matrix) -> tuple[sp.Expr, ...]:
    """Its shortest multiple whose entries are polynomials, positive where all moments are small."""
    entries = shorten([x / direction[2] for x in direction])
    scale = sp.lcm_list([sp.fraction(x)[1] for x in entries])
    found = shorten([x * scale for x in entries])
    small = found[2].xreplace(dict.fromkeys(MOMENTS, sp.Integer(0)))
    return tuple(-x if small.is_negative else x for x in found)


def tensor() -> sp.Matrix:
    """The inertia of the ball about its centre, with D added to each moment."""
    return sp.diag(*(moment + D for moment in MOMENTS))
