"""The dictionaries of the section on the Voronec principle for a rolling body.

Surfaces, moments of inertia and the force function are arbitrary: the tensor of inertia along
(u, v, n), the arm OM and U are unknown functions.  Momenta, brackets and equations are the
engine's; n', K_1', K_2', Delta_1, Delta_2 are read off from these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study, shorten
from voronec.kinematics import kinetic_energy

from .neumann import inertia_about_contact
from .surfaces import (
    BASE,
    COORDINATES,
    DETERMINANT_NOTE,
    FIBRE,
    MASS,
    NOTE,
    QUASI,
    SHAPES,
    Surfaces,
    joint_verdict,
    theta,
    typeset,
    u1,
    unknown_contact,
    v1,
    vector,
    velocities,
)

POINT = sp.Symbol("M")
DOTS = velocities(BASE)
K = sp.symbols("K_{1} K_{2}")
SPELLED_BASE = ("u", "v", r"\vartheta")
U = sp.Function("U")(*COORDINATES)
SOURCE = "the equations and brackets derived for the system 'rolling-body'"


def tensor() -> sp.Matrix:
    """The inertia about O along (u, v, n), six unknown functions of the place on the body."""
    return sp.Matrix(
        3, 3, lambda i, j: sp.Function(f"J{min(i, j) + 1}{max(i, j) + 1}")(*COORDINATES[:2])
    )


@dataclass(frozen=True)
class Body:
    """The rolling body and its equations of motion, derived."""

    surfaces: Surfaces
    energy: sp.Expr
    eqs: Any

    @classmethod
    def derive(cls) -> Body:
        """Derive them in the five coordinates; the energy is T in the five velocities."""
        contact = unknown_contact()
        energy = kinetic_energy(MASS, contact.centre_velocity, tensor(), contact.spin)
        system = vo.System(
            name="rolling-body",
            fibration=vo.Fibration(base=BASE, fibre=FIBRE),
            lagrangian=energy + U,
            constraints=contact.no_slip,
            parameters=(MASS,),
        )
        eqs = vo.derive(system)
        return cls(Surfaces.of(contact, eqs), energy, eqs)

    @cached_property
    def constrained_energy(self) -> sp.Expr:
        """T on the constraints."""
        return self.surfaces.motion.restrict(self.energy)

    @cached_property
    def momenta(self) -> tuple[sp.Expr, ...]:
        """The momenta of u_1 and v_1 on the constraints."""
        return tuple(map(self.eqs.bridge.outward, self.eqs.raw.momenta[len(BASE) :]))

    @cached_property
    def spin(self) -> sp.Matrix:
        """(s, tau, n) on the constraints."""
        return self.surfaces.motion.restrict(self.surfaces.spin)

    @cached_property
    def residuals(self) -> tuple[sp.Expr, ...]:
        """mass * vdot - force, for u, v, theta."""
        raw, out = self.eqs.raw, self.eqs.bridge.outward_matrix
        accelerations = vector(vo.velocity(w) for w in DOTS)
        return tuple(out(raw.mass) * accelerations - out([[x] for x in raw.force]))

    @cached_property
    def brackets(self) -> sp.Matrix:
        """Row i, column nu: the sum over j of A_ij^(nu) times a base velocity."""
        curvature = self.eqs.curvature
        return sp.Matrix(
            3, 2, lambda i, nu: sp.Add(*[curvature[nu, i, j] * w for j, w in enumerate(DOTS)])
        )

    @cached_property
    def transpositions(self) -> sp.Matrix:
        """d(delta u_1)/dt - delta(du_1/dt) and the same for v_1."""
        return self.brackets.T * vector(self.surfaces.variations)

    @cached_property
    def roots(self) -> tuple[tuple[sp.Expr, sp.Expr], tuple[sp.Expr, sp.Expr]]:
        """sqrt(E), sqrt(G) of the body, and of the fixed surface."""
        (e, g), (e1, g1) = (forms.first for forms in self.surfaces.forms)
        return (sp.sqrt(e), sp.sqrt(g)), (sp.sqrt(e1), sp.sqrt(g1))

    @cached_property
    def turn_matrix(self) -> sp.Matrix:
        """Columns: how what is multiplied by K_1 and by K_2 follows from two other combinations,
        those along u and v; the matrix of the constraints, which is its own inverse."""
        c, s = sp.cos(theta), sp.sin(theta)
        return sp.Matrix([[c, s], [s, -c]])

    @cached_property
    def along(self) -> sp.Matrix:
        """Row i, columns u and v: ``brackets`` along the axes of the body."""
        return self.brackets * sp.diag(*self.roots[1]) * self.turn_matrix

    @cached_property
    def prime(self) -> sp.Expr:
        """n', from how the brackets hold it: along u they are L_u (n delta u - n' du/dt), along v
        L_v (n delta v - n' dv/dt)."""
        (lu, lv), (du, dv, dtheta) = self.roots[0], self.surfaces.variations
        x, y = DOTS[0], DOTS[1]
        by_u = -sp.diff(self.along[0, 1], y) / lv
        by_v, by_theta = (-sp.diff(self.along[i, 0], x) / lu for i in (1, 2))
        return by_u * du + by_v * dv + by_theta * dtheta

    @cached_property
    def primed_momenta(self) -> sp.Matrix:
        """K_1', K_2': the equation of theta is K_1' L_u du/dt + K_2' L_v dv/dt on the right."""
        factors = zip(DOTS, self.roots[0], strict=False)
        rows = [sp.diff(self.brackets.row(2), dot) / length for dot, length in factors]
        return sp.Matrix(rows) * vector(self.momenta)

    @cached_property
    def deltas(self) -> tuple[sp.Expr, sp.Expr]:
        """Delta_1, Delta_2: n = -dtheta/dt + Delta_1 L_u du/dt - Delta_2 L_v dv/dt."""
        lu, lv = self.roots[0]
        return sp.diff(self.spin[2], DOTS[0]) / lu, -sp.diff(self.spin[2], DOTS[1]) / lv

    @cached_property
    def common(self) -> dict[str, Any]:
        """Names that do not depend on what s, tau, n are."""
        names = dict(zip(("K_1", "K_2"), self.momenta, strict=True))
        return {**self.surfaces.names(), **names, r"\mathbf M": MASS, "M": POINT, "U": U}

    @property
    def meanings(self) -> dict[str, Any]:
        """What the letters stand for in coordinate velocities."""
        surfaces = self.surfaces
        slip, centre = vector(surfaces.contact.slip), surfaces.contact.centre_velocity
        return {
            **self.common,
            **dict(zip(("s", r"\tau", "n"), surfaces.spin, strict=True)),
            "T": self.energy,
            r"\bar{\Theta}": self.constrained_energy,
            **{rf"\delta {x}": d for x, d in zip(SPELLED_BASE, surfaces.variations, strict=True)},
            "n'": self.prime,
            **dict(zip(("K_1'", "K_2'"), self.primed_momenta, strict=True)),
            **dict(zip((r"\Delta_1", r"\Delta_2"), self.deltas, strict=True)),
            r"\mathfrak m_\mathbf u": slip[0],
            r"\mathfrak m_\mathbf v": slip[1],
            r"\mathfrak m_\mathbf n": slip[2],
            r"\mathfrak w_\mathbf v": centre[1],
        }

    def studies(self) -> dict[str, Study]:
        """``coordinates``: in coordinate velocities; ``quasi``: s, tau, n are variables."""
        surfaces = self.surfaces
        deltas = surfaces.variations
        variations = surfaces.virtual | {
            w: vo.velocity(d) for w, d in zip(DOTS, deltas, strict=True)
        }
        motion = Motion(
            {**surfaces.motion.rates, **{d: vo.velocity(d) for d in deltas}},
            surfaces.motion.constrained,
            surfaces.motion.accelerations,
        )
        quasi = {
            **self.common,
            **dict(zip(("s", r"\tau", "n"), QUASI, strict=True)),
            r"\Theta": self.quasi_energy,
        }
        given = {**surfaces.roots, **dict(zip(QUASI, self.spin, strict=True))}
        note = f"{NOTE}, any inertia and any force function"
        return {
            "coordinates": Study(
                self.meanings,
                motion=motion,
                letters=SHAPES,
                variations=variations,
                given=surfaces.roots,
                positive=surfaces.positive,
                narrow_functions=True,
                context=self,
                note=note,
                source=SOURCE,
            ),
            "quasi": Study(
                quasi,
                motion=surfaces.motion,
                narrow_functions=True,
                given=given,
                context=self,
                note=note,
                source=SOURCE,
            ),
        }

    @property
    def quasi_energy(self) -> sp.Expr:
        """Theta: T in s, tau, n where the contact does not slip."""
        centre = -vector(QUASI).cross(self.surfaces.arm)
        return kinetic_energy(MASS, centre, tensor(), QUASI)

    def row(self, where: Mapping[str, int]) -> sp.Expr:
        """The equation of a base coordinate, as an expression that vanishes."""
        return self.residuals[where.get("i", 1) - 1]

    def momentum_terms(self, position: int, spelling: Mapping[Any, str]) -> str:
        """K_1 or K_2 by the derivatives of Theta, and what is left, which bears the mass."""
        dot = velocities(FIBRE)[position]
        slopes = [sp.diff(form, dot) for form in self.surfaces.spin]
        moments = [sp.diff(self.quasi_energy, w) for w in QUASI]
        slip = vector(sp.diff(x, dot) for x in self.surfaces.contact.slip)
        orbital = MASS * slip.dot(-vector(QUASI).cross(self.surfaces.arm))
        total = orbital + vector(slopes).dot(vector(moments))
        at = dict(zip(QUASI, self.spin, strict=True))
        if not vo.prove_equal(self.momenta[position], total.xreplace(at)).proved:
            raise vo.DefinitionError("K is not made of Theta's derivatives and the momentum")
        terms = [shorten([orbital])[0]]
        for name, slope in zip(("s", r"\tau", "n"), slopes, strict=True):
            terms.append(slope * sp.Symbol(rf"\frac{{\partial\Theta}}{{\partial {name}}}"))
        return "+".join(typeset(term, spelling) for term in terms).replace("+-", "-")

    def equation_terms(self, position: int) -> list[tuple[str, sp.Expr]]:
        """The equation of u, v or theta in K_1', K_2', Delta_1, Delta_2: brackets decomposed."""
        ev, gu = self._slopes
        names = [sp.Symbol(rf"{{\Delta_{i}}}") for i in (1, 2)]
        solved = {}
        for name, slope, value in zip(names, (ev, gu), self.deltas, strict=True):
            factor = sp.diff(value, slope)
            solved[slope] = slope + (name - value) / factor
        primed = vector(sp.Symbol(f"{{K_{i}'}}") for i in (1, 2))
        turn = (self.along.row(position) * primed)[0].xreplace(solved)
        right = shorten([turn])[0]
        for row, q in enumerate(FIBRE, start=len(BASE)):
            spelled = {u1: "u_1", v1: "v_1"}[q]
            slope = sp.Symbol(rf"\frac{{\partial(\bar{{\Theta}}+U)}}{{\partial {spelled}}}")
            right += self.surfaces.lift[row, position] * slope
        q = SPELLED_BASE[position]
        left = (
            rf"\frac{{d}}{{dt}}\frac{{\partial\bar{{\Theta}}}}{{\partial\dot {q}}}"
            rf"-\frac{{\partial(\bar{{\Theta}}+U)}}{{\partial {q}}}"
        )
        return [(left, right)]

    @property
    def _slopes(self) -> tuple[sp.Expr, sp.Expr]:
        (e, g), (u, v) = self.surfaces.forms[0].first, COORDINATES[:2]
        return sp.diff(e, v), sp.diff(g, u)

    def eight(self) -> vo.Verdict:
        """Whether five coordinates and three velocities have determined derivatives.

        The mass matrix is slopes^T I slopes, with the inertia I about M and the derivatives of
        s, tau, n by the base velocities, whose determinant is that of the relative curvature.
        """
        unknowns = len(self.eqs.coordinates) + len(self.eqs.velocities)
        if unknowns != len(self.eqs.raw.rates) + len(self.residuals) or unknowns != 8:
            return vo.Verdict("refuted", f"{unknowns} unknowns")
        moments = vector(sp.diff(self.quasi_energy, w) for w in QUASI)
        slopes = self.spin.jacobian(DOTS)
        made = slopes.T * moments.jacobian(QUASI) * slopes
        pairs = [*zip(self.eqs.bridge.outward_matrix(self.eqs.raw.mass), made, strict=True)]
        curvature = -self.surfaces.area[0] * self.surfaces.curvature
        pairs.append((slopes.det(method="berkowitz"), curvature))
        found = [vo.prove_equal(a, b) for a, b in pairs]
        return joint_verdict([*found, inertia_about_contact()], DETERMINANT_NOTE)
