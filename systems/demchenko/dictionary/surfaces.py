"""Two arbitrary surfaces in contact: what the sections on rolling bodies have in common.

Both surfaces are known by their fundamental forms only, along lines of curvature; E, G, D, D'' and
the support are unknown functions, so that what is proved here holds for every pair of surfaces.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

import voronec as vo
from voronec.audit import Motion, shorten
from voronec.kinematics import RollingContact, SurfaceForms

from .verdicts import worst

u, v, theta, u1, v1 = COORDINATES = sp.symbols("u v theta u_1 v_1")
BASE, FIBRE = COORDINATES[:3], COORDINATES[3:]
QUASI = s, tau, n = sp.symbols("s tau n")
SLIP = sp.symbols("m_u m_v m_n")
MASS = sp.Symbol("mass", positive=True)
NOTE = "for arbitrary surfaces"
DETERMINANT_NOTE = (
    "the determinant is a power of the relative curvature's, times that of the inertia about M, "
    "which is positive, and positive factors"
)
SHAPES = {
    "Q": r"$K$ and $K_1$ are the shape operators of the surfaces, $Q$ turns the axes of one into "
    "those of the other"
}
"""The letters of the relative curvature, in words."""
COORDINATE_LETTERS = ("u", "v", r"\vartheta", "u_1", "v_1")


def velocities(coordinates: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, ...]:
    """The velocity symbols of coordinates."""
    return tuple(vo.velocity(q) for q in coordinates)


def vector(components: Any) -> sp.Matrix:
    """A column of SymPy's."""
    return sp.Matrix(list(components))


def joint_verdict(verdicts: Any, method: str) -> vo.Verdict:
    """``worst``, with ``method`` for what all of them prove together."""
    found = worst(verdicts)
    return vo.Verdict("proved", method) if found.proved else found


def typeset(expr: sp.Expr, spelling: Mapping[Any, str]) -> str:
    """A product in the paper's names, unknown functions and their derivatives among them."""
    names = dict(spelling) | {x: x.name for x in expr.free_symbols if "{" in x.name}
    rules = {f: sp.Symbol(spelling[f]) for f in expr.atoms(AppliedUndef)}
    for slope in expr.atoms(sp.Derivative):
        function, variable = spelling[slope.expr], spelling[slope.variables[0]]
        rules[slope] = sp.Symbol(rf"\frac{{\partial {function}}}{{\partial {variable}}}")
    names |= {symbol: symbol.name for symbol in rules.values()}
    text = str(sp.latex(expr.xreplace(rules), symbol_names=names, fold_func_brackets=True))
    return text.replace("- ", "-", 1) if text.startswith("- ") else text


def unknown_contact() -> RollingContact:
    """Two surfaces of which the forms are unknown functions."""
    body, fixed = SurfaceForms.unknown(u, v), SurfaceForms.unknown(u1, v1, "_1")
    return RollingContact(body, fixed, theta)


@dataclass(frozen=True)
class Surfaces:
    """A body on a surface; ``rates`` are the derivatives of the coordinates on the constraints."""

    contact: RollingContact
    rates: tuple[sp.Expr, ...]

    @classmethod
    def arbitrary(cls) -> Surfaces:
        """Both surfaces unknown; the constraints are solved by the engine."""
        contact = unknown_contact()
        system = vo.System(
            name="contact",
            fibration=vo.Fibration(base=BASE, fibre=FIBRE),
            lagrangian=sum(w**2 for w in velocities(BASE)),
            constraints=contact.no_slip,
        )
        return cls.of(contact, vo.derive(system))

    @classmethod
    def of(cls, contact: RollingContact, eqs: Any) -> Surfaces:
        """The rates are those of derived equations, whose constraints are those of the contact."""
        found = shorten([eqs.bridge.outward(rate) for rate in eqs.raw.rates])
        rates = dict(zip(eqs.coordinates, found, strict=True))
        return cls(contact, tuple(sp.expand(rates[q]) for q in COORDINATES))

    @cached_property
    def motion(self) -> Motion:
        """Base velocities are free, as are their rates under some force; those of the fibre are as
        the constraints have it."""
        found = dict(zip(COORDINATES, self.rates, strict=True))
        constrained = dict(zip(velocities(FIBRE), self.rates[len(BASE) :], strict=True))
        accelerations = {w: vo.velocity(w) for w in velocities(BASE)}
        free = {a: a for a in accelerations.values()}
        return Motion(found | accelerations, constrained, free)

    @property
    def positive(self) -> tuple[sp.Expr, ...]:
        """E, G, E_1, G_1."""
        return tuple(x for forms in self.forms for x in forms.first)

    @cached_property
    def roots(self) -> dict[sp.Expr, sp.Expr]:
        """sqrt(E G) = sqrt(E) sqrt(G): the coefficients are positive."""
        found: dict[sp.Expr, sp.Expr] = {}
        for forms in self.forms:
            e, g = forms.first
            split = sp.sqrt(e) * sp.sqrt(g)
            found |= {sp.sqrt(e * g): split, 1 / sp.sqrt(e * g): 1 / split}
        return found

    @property
    def forms(self) -> tuple[SurfaceForms, SurfaceForms]:
        """The forms of the body's surface and of the fixed one."""
        found = self.contact.body, self.contact.fixed
        assert isinstance(found[0], SurfaceForms)
        assert isinstance(found[1], SurfaceForms)
        return found[0], found[1]

    @cached_property
    def spin(self) -> sp.Matrix:
        """(s, tau, n) in the velocities of all coordinates."""
        return vector(self.contact.spin)

    @property
    def arm(self) -> sp.Matrix:
        """OM along (u, v, n)."""
        return vector(self.contact.arm)

    @cached_property
    def curvature(self) -> sp.Expr:
        """The determinant of the relative curvature K + Q K_1 Q, K = diag(D/E, D''/G).

        The normals are opposite, so that it is the sum of the shape operators that is relative;
        Q turns the axes of one surface into those of the other.
        """
        (a, b), (a1, b1) = (
            (forms.second[0] / forms.first[0], forms.second[1] / forms.first[1])
            for forms in self.forms
        )
        c, s = sp.cos(theta), sp.sin(theta)
        along = a * (a1 * c**2 + b1 * s**2) + b * (a1 * s**2 + b1 * c**2)
        return a * b + a1 * b1 + along

    def spelled_curvature(self, spelling: Mapping[Any, str]) -> str:
        """That determinant in the paper's names."""
        return rf"\det(K+QK_1Q) = {typeset(self.curvature, spelling)}"

    @cached_property
    def area(self) -> tuple[sp.Expr, sp.Expr]:
        """sqrt(E G) of the body and of the fixed surface."""
        first, second = (sp.sqrt(e) * sp.sqrt(g) for e, g in (f.first for f in self.forms))
        return first, second

    def dependent(self) -> vo.Verdict:
        """Whether the constraints can be solved for the velocities of the fibre: determinant."""
        a, b = vector(self.contact.no_slip).jacobian(velocities(FIBRE)).tolist()
        verdict = vo.prove_equal(a[0] * b[1] - a[1] * b[0], self.area[1])
        if not verdict.proved:
            return verdict
        e, g = sp.symbols("E_1 G_1", positive=True)
        return vo.prove_inequality(sp.sqrt(e) * sp.sqrt(g), ">", 0)

    @cached_property
    def lift(self) -> sp.Matrix:
        """How the velocities of all coordinates follow from those of the base."""
        return sp.Matrix([[sp.diff(rate, w) for w in velocities(BASE)] for rate in self.rates])

    @cached_property
    def frame_equations(self) -> Any:
        """The same contact in the frame of the quasi-velocities s, tau, n."""
        system = vo.System(
            name="contact-in-frame",
            fibration=vo.Fibration(base=BASE, fibre=FIBRE),
            frame=vo.Frame.quasi(dict(zip(QUASI, self.contact.spin, strict=True))),
            lagrangian=sum(w**2 for w in velocities(BASE)),
            constraints=self.contact.no_slip,
        )
        return vo.derive(system)

    @cached_property
    def fields(self) -> sp.Matrix:
        """Columns: velocities of all coordinates, for s = 1, for tau = 1, for n = 1."""
        rates = vector(map(self.frame_equations.bridge.outward, self.frame_equations.exact.rates))
        return rates.jacobian(QUASI)

    def commutators(self) -> vo.Verdict:
        """Whether the engine's brackets of those fields are what rotations make of them.

        omega([X_i, X_j]) = e_i x e_j - omega_1(X_i) x e_j + omega_1(X_j) x e_i along (u, v, n),
        where [X_i, X_j] = c_ij^k X_k + B_ij^A d_A.
        """
        brackets, spin = self.frame_equations.brackets, self.spin.jacobian(velocities(COORDINATES))
        body, fixed = self.forms
        rules = {**self.roots, **body.rules(), **fixed.rules()}
        relative = -self.body_frame.jacobian(velocities(COORDINATES)) * self.fields
        axes, verdicts = sp.eye(3), []
        for i, j in ((0, 1), (0, 2), (1, 2)):
            along = vector(brackets.c[k, i, j] for k in range(3))
            upright = vector(brackets.B[a, i, j] for a in range(2))
            turned = axes[:, i].cross(axes[:, j]) - relative[:, i].cross(axes[:, j])
            turned += relative[:, j].cross(axes[:, i])
            difference = (along + spin[:, len(BASE) :] * upright - turned).xreplace(rules)
            verdicts += [vo.prove_equal(x, 0) for x in difference]
        dual = self.motion.restrict(spin) * self.fields - axes
        return worst([*verdicts, *(vo.prove_equal(x, 0) for x in dual)])

    @cached_property
    def virtual(self) -> dict[sp.Expr, sp.Expr]:
        """The virtual displacements: velocities on the constraints with variations for them."""
        free = dict(zip(velocities(BASE), self.variations, strict=True))
        return {q: rate.xreplace(free) for q, rate in zip(COORDINATES, self.rates, strict=True)}

    @property
    def variations(self) -> tuple[sp.Symbol, ...]:
        """The independent variations."""
        return sp.symbols("delta_u delta_v delta_theta")

    @property
    def body_frame(self) -> sp.Matrix:
        """The angular velocity of M u v n against the body, along its axes."""
        return vector(self.forms[0].frame_rates)

    def names(self) -> dict[str, Any]:
        """Coordinates and coefficients of the forms."""
        found: dict[str, Any] = {
            "t": vo.time,
            **dict(zip(COORDINATE_LETTERS, COORDINATES, strict=True)),
        }
        for forms, mark in zip(self.forms, ("", "_1"), strict=True):
            first = zip(("E", "F", "G"), forms.first_form, strict=True)
            second = zip(("D", "D'", "D''"), forms.second_form, strict=True)
            found |= {name + mark: value for name, value in (*first, *second)}
        found |= dict(zip((r"\rho_u", r"\rho_v", r"\epsilon"), self.arm, strict=True))
        return found
