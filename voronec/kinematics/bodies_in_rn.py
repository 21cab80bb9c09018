"""Balls of R^n that roll, and bodies of R^n about a fixed point, declared on their groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

from voronec.declaration.claims import Case, Equation, Measure
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.reading import real_text
from voronec.declaration.relation import Limit, Relation, Square
from voronec.declaration.scene import Parameter, Scene
from voronec.declaration.system import System
from voronec.kinematics.families import FIXED_RADIUS, constants, join_declarations, rolling_ratio
from voronec.kinematics.groups import (
    BodyVelocity,
    product_form,
    product_moments,
    skew,
    skew_entries,
    wedge_square,
)
from voronec.kinematics.meanings import NORMAL, SPIN, vector_meanings
from voronec.kinematics.sketches import pinned_sketch, rolling_sketch

DETERMINANT = sp.Symbol("Delta")
SECOND_MOMENTS = ("0.4", "0.3", "0.1", "0.2", "0.5")
"""All different, so that no two axes are alike."""


@dataclass(frozen=True)
class BodyInRn:
    """A balanced ball of R^n on a hyperplane or a sphere, or a body of R^n about a fixed point.

    dimension
        n.
    mass, radius
        m and R2 of a ball; nothing for a body about a point.
    fixed
        R1, the signed radius of a fixed sphere S^(n-1); nothing for a hyperplane.
    twists
        whether it turns in planes at right angles to gamma; without, Omega = gamma u^T - u gamma^T,
        and the velocities are Omega_in, good where gamma_n is not 0.

    The configuration space is SE(n) or SO(n), given by its frame, ``BodyVelocity``.  gamma is a
    unit vector, the normal of what the ball rolls on, seen from it; with W = R2 Omega gamma

        dgamma/dt = -Omega gamma + W/(R1 + R2) = -epsilon Omega gamma,    epsilon = R1/(R1 + R2),

    which is 1 on a hyperplane and about a point.  A ball that twists has the momentum about the
    contact G = I Omega + m R2^2 (gamma gamma^T Omega + Omega gamma gamma^T), dG/dt = [G, Omega]
    [FedorovKozlov1995, Jovanovic2010, Jovanovic2018].  Without twist, G_ij = (I_ij + m R2^2)
    Omega_ij and d(G gamma)/dt = -Omega G gamma + (1 - epsilon) G Omega gamma [FedorovJovanovic2004,
    Jovanovic2018].
    """

    dimension: int
    mass: Any = sp.Integer(0)
    radius: Any = None
    fixed: Any = None
    twists: bool = True

    @cached_property
    def body(self) -> BodyVelocity:
        """The names of its velocities."""
        return BodyVelocity(self.dimension)

    @property
    def normal(self) -> sp.Matrix:
        """gamma."""
        return sp.Matrix(self.body.normal)

    @property
    def rolls(self) -> bool:
        """Whether it is a ball, and no body about a point."""
        return self.radius is not None

    @property
    def letter(self) -> str:
        """Of the moments in the planes of two axes: I of a ball, J about a point."""
        return "I" if self.rolls else "J"

    @property
    def moments(self) -> tuple[sp.Symbol, ...]:
        """I_ij or J_ij, i < j."""
        return self.body.skew_symbols(self.letter)

    @property
    def contact_inertia(self) -> sp.Expr:
        """m R2^2."""
        return self.mass * self.radius**2 if self.rolls else sp.Integer(0)

    @property
    def contact_moments(self) -> list[sp.Expr]:
        """The moments about the contact, I_ij + m R2^2, or about the point."""
        return [i + self.contact_inertia for i in self.moments]

    @property
    def epsilon(self) -> sp.Expr:
        """R1/(R1 + R2), or 1."""
        return rolling_ratio(self.fixed, self.radius)

    @property
    def velocities(self) -> tuple[sp.Symbol, ...]:
        """Omega_ij, or without twist Omega_in."""
        return self.body.angular if self.twists else self.body.last

    @property
    def momenta(self) -> tuple[sp.Symbol, ...]:
        """Names of the momenta of the velocities: G_ij, or without twist P_i."""
        if self.twists:
            return self.body.skew_symbols("G")
        return tuple(sp.symbols(f"P1:{self.dimension}"))

    @cached_property
    def energy(self) -> sp.Expr:
        """The kinetic energy, without constraints."""
        return self.body.energy(self.moments, self.mass)

    @cached_property
    def equations(self) -> dict[str, Equation]:
        """The equations of the momentum, and of gamma over a sphere."""
        body, gamma, laws = self.body, self.normal, {}
        if self.twists:
            momentum, turning = skew(self.momenta, self.dimension), body.matrix
            rate = skew_entries(momentum * turning - turning * momentum)
            laws["momentum"] = Equation(self.momenta, rate)
            if self.fixed is None:
                along, square = momentum * gamma, wedge_square(momentum)
                laws["momentum of the normal"] = Equation(along, body.apparent_rate(along))
                if self.dimension == 5:
                    laws["momentum wedge momentum"] = Equation(square, body.apparent_rate(square))
        else:
            along = body.normal_momentum(self.momenta)
            entries = [i * w for i, w in zip(self.contact_moments, body.angular, strict=True)]
            slipping = (1 - self.epsilon) * skew(entries, self.dimension) * body.matrix * gamma
            laws["momentum"] = Equation(along, body.apparent_rate(along) + slipping)
        if self.fixed is not None:
            laws["normal"] = Equation(gamma, self.epsilon * body.apparent_rate(gamma))
        return laws

    @cached_property
    def integrals(self) -> dict[str, sp.Expr]:
        """The energy, and what is constant because G or G gamma is fixed in space."""
        momenta, gamma, plane = sp.Matrix(self.momenta), self.normal, self.fixed is None
        conserved = {"energy": momenta.dot(sp.Matrix(self.velocities)) - self.energy}
        if not self.twists:
            along = self.body.normal_momentum(self.momenta)
            return {**conserved, "momentum squared": along.dot(along)} if plane else conserved
        momentum = skew(self.momenta, self.dimension)
        along, square = momentum * gamma, wedge_square(momentum)
        conserved["momentum squared"] = sp.Add(*(p**2 for p in self.momenta))
        if plane:
            conserved["momentum of the normal squared"] = along.dot(along)
            if self.dimension == 3:
                axial = sp.Matrix([momentum[2, 1], momentum[0, 2], momentum[1, 0]])
                conserved["vertical momentum"] = axial.dot(gamma)
        if self.dimension == 4:
            conserved["momentum wedge momentum"] = square[0]
        if self.dimension == 5:
            conserved["momentum wedge momentum squared"] = square.dot(square)
            if plane:
                conserved["momentum wedge momentum along the normal"] = square.dot(gamma)
        return conserved

    @property
    def measure(self) -> Measure:
        """sqrt(Delta), Delta the determinant of the mass matrix; without twist over a sphere
        Delta^(1/(2 epsilon)) gamma_n^((n - 2)(1/epsilon - 1))."""
        if self.twists:
            return Measure(sp.sqrt(DETERMINANT))
        last = self.normal[-1] ** ((self.dimension - 2) * (1 / self.epsilon - 1))
        return Measure(DETERMINANT ** (1 / (2 * self.epsilon)) * last)

    @cached_property
    def form(self) -> sp.Expr:
        """a_1 (gamma, A gamma) for moments a_i a_j about the contact."""
        return product_form(self.contact_moments, self.normal)

    @property
    def reducer(self) -> sp.Expr:
        """(gamma, A gamma)^(1/(2 epsilon) - 1): for moments a_i a_j without twist a reducing
        multiplier, in another time gamma moves on a geodesic of a metric on the sphere."""
        return self.form ** (1 / (2 * self.epsilon) - 1)

    def product_case(self) -> dict[str, Case]:
        """The case of moments a_i a_j about the contact, or the point; for n = 3 all are such."""
        if self.twists or self.dimension == 3:
            return {}
        n = self.dimension
        values = {
            f"{self.letter}{i}{j}": value - self.contact_inertia
            for (i, j), value in product_moments(self.contact_moments, n).items()
        }
        if not self.rolls:
            density = self.form ** sp.Rational(n - 2, 2) / self.normal[-1] ** (n - 2)
            measure = Measure(density, (*self.normal, *self.velocities))
            note = "moments that are products, J_ij = a_i a_j"
            return {"J = a a": Case(values, measure=measure, multiplier=self.reducer, note=note)}
        sums = f"I_ij + {self.mass} {self.radius}^2 = a_i a_j"
        note = f"moments about the contact that are products, {sums}"
        return {"I + D = a a": Case(values, multiplier=self.reducer, note=note)}

    def scene(self, caption: str, end: float, outputs: Sequence[Any] = ()) -> Scene:
        """A motion from gamma = (-3, 0, ..., 0, 4)/5, with all velocities different from 0.

        Unless ``outputs`` are given, they are gamma and, with twist, the velocities.
        """
        start = [sp.Rational(k, 5) for k in (-3, *[0] * (self.dimension - 2), 4)]
        count = range(len(self.velocities))
        turning = [sp.Rational(4 * (i % 2) - 3, 10 + i) for i in count]
        if self.twists:
            turning = [sp.Rational(5 - 3 * (i % 3), 4 + i) for i in count]
        names, values = (*self.normal, *self.velocities), (*start, *turning)
        seen = tuple(outputs) or (names if self.twists else tuple(self.normal))
        return Scene(dict(zip(names, values, strict=True)), (0.0, end), {}, seen, caption)

    def system(
        self,
        *,
        values: Mapping[Any, Any],
        second_moments: Sequence[str] = SECOND_MOMENTS,
        **declared: Any,
    ) -> System:
        """The system of this body, with ``values`` of its constants, and what is special to it.

        ``second_moments`` a_i are those of the mass, by axis: the moments are a_i + a_j.
        """
        body, gamma = self.body, self.normal
        words: dict[Any, tuple[str, bool]] = {self.mass: ("mass", True)}
        rolled, moving, on, radius = (), None, "plane", "radius"
        if self.fixed is not None:
            moving = sp.Matrix(body.linear) / (self.fixed + self.radius)
            on, radius, words[self.fixed] = "sphere", "radius of the ball", FIXED_RADIUS
        if self.rolls:
            words[self.radius] = (radius, True)
            rolled = tuple(sp.Matrix(body.linear) - self.radius * body.matrix * gamma)
            sketch = rolling_sketch(on=on, gamma=gamma, note=f"in $R^{self.dimension}$")
        else:
            sketch = pinned_sketch(gamma=gamma)
        common = {
            "fibration": Fibration(body.normal, relations=(gamma.dot(gamma) - 1,)),
            "frame": Frame.group(
                self.velocities,
                body.motions if self.rolls else body.rotations,
                dict(zip(gamma, body.apparent_rate(gamma, moving), strict=True)),
                fibre=(*(() if self.twists else body.others), *(body.linear if self.rolls else ())),
                momenta=self.momenta,
                determinant=DETERMINANT,
            ),
            "lagrangian": self.energy,
            "constraints": (*rolled, *(() if self.twists else body.twist(gamma))),
            "parameters": (*constants(values, words), *self._moments(second_moments)),
            "integrals": self.integrals,
            "equations": self.equations,
            "measure": self.measure,
            "multiplier": None if self.twists or self.dimension != 3 else self.reducer,
            "cases": self.product_case(),
            "meanings": self._meanings,
            "sketch": sketch,
        }
        return join_declarations(common, declared)

    @property
    def _meanings(self) -> dict[Any, str]:
        """Of gamma, of Omega and, for a ball, of the velocity of its centre."""
        body, normal = self.body, NORMAL if self.rolls else "direction fixed in space"
        turning = {
            name: f"{SPIN} in the plane of the axes {i} and {j} of the body"
            for name, (i, j) in zip(body.angular, body.pairs, strict=True)
        }
        moved = vector_meanings(body.linear, "velocity of the centre") if self.rolls else {}
        return {**vector_meanings(self.normal, normal), **turning, **moved}

    def _moments(self, second_moments: Sequence[str]) -> list[Parameter]:
        """The moments in the planes of two axes."""
        a = [real_text(x, "a second moment") for x in second_moments]
        return [
            Parameter(
                moment,
                a[i - 1] + a[j - 1],
                positive=True,
                meaning=f"moment in the plane of the axes {i} and {j}",
            )
            for (i, j), moment in zip(self.body.pairs, self.moments, strict=True)
        ]

    @property
    def in_space(self) -> tuple[dict[str, sp.Expr], dict[str, sp.Expr]]:
        """For n = 3: gamma and omega, Omega x = omega x x, and the moments about the axes."""
        (w12, w13, w23), (i12, i13, i23) = self.body.angular, self.moments
        spin = {"omega1": -w23, "omega2": w13} | ({"omega3": -w12} if self.twists else {})
        state = {**{str(g): g for g in self.normal}, **spin}
        return state, {f"{self.letter}{k}": x for k, x in zip("123", (i23, i13, i12), strict=True)}

    def relation_in_space(self, name: str, target: str) -> Relation:
        """From ``name`` for n = 3, which this is, to the same in ordinary coordinates."""
        state, moments = self.in_space
        kept = {s: s for s in (self.fixed, self.radius, self.mass) if isinstance(s, sp.Symbol)}
        given = {**kept, **moments}
        return Relation(f"{name}@3", target, state, given, note="three dimensions")

    def large_sphere(
        self, name: str, flat: str, low: str, low_flat: str
    ) -> tuple[tuple[Relation, ...], tuple[Square, ...]]:
        """What the balls ``name`` on a sphere, of which this is the one for n = 3, have to do with
        ``flat`` on a hyperplane, and with ``low`` and ``low_flat`` in ordinary coordinates.

        For n = 5 the limit holds too; the claims that it carries are too large to be decided.
        """
        small, straight = sp.Symbol("h"), replace(self, fixed=None, twists=True)
        limits = [
            Relation(
                f"{name}{at}",
                f"{flat}{at}",
                parameters={
                    self.mass: self.mass,
                    "R": self.radius,
                    **{i: i for i in replace(straight, dimension=n).moments},
                },
                limit=Limit(small, {self.fixed: 1 / small}),
                note="the sphere becomes a hyperplane",
            )
            for n, at in ((3, "@3"), (4, ""))
        ]
        known = self.relation_in_space(name, low)
        square = Square.through((f"{name}@3", low, low_flat), (f"{name}@3", f"{flat}@3", low_flat))
        return (known, *limits), (square,)
