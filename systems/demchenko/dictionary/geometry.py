"""The dictionary to the geometry of homogeneous constraints: a general system once more.

Three base and two fibre coordinates; every coefficient is an unknown function of all coordinates.
B stands for the two-form with the components that the paper prints, B_ij = -A_ij^(nu).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study, Verdict, direction

from .connections import Connection
from .general import BASE, COEFFICIENTS, DELTA, FIBRE, INDICES, TOTAL, Q, V
from .principle import dalembert, forced_motion, lagrange
from .subspaces import direct_sum, leading_places, null_space, span
from .verdicts import all_equal

FREE = sp.symbols(f"eta1:{TOTAL + 1}")
LABELLED_LETTERS = frozenset({"B", r"\omega", "X", "Y", "q"})
SOURCE = (
    "d'Alembert's principle, and the energy on the constraints of the system 'general-homogeneous'"
)
LINEAR = "the connection of arbitrary constraints: linear algebra, and brackets of vector fields"
CURVATURE_SOURCE = f"{LINEAR}; the curvature derived for the system 'general-homogeneous'"
NOTE = f"n = {BASE}, k = {FIBRE}, every coefficient an arbitrary function of the coordinates"


def unknown(name: str) -> sp.Expr:
    """An unknown function of all coordinates."""
    return sp.Function(name)(*Q)


def coefficient(nu: int, i: int) -> sp.Expr:
    """a_(nu i)."""
    return unknown(f"a{nu}{i}")


POTENTIAL = unknown("V")
CONSTRAINTS = tuple(
    V[BASE + nu - 1] - sp.Add(*[coefficient(nu, i + 1) * V[i] for i in range(BASE)])
    for nu in range(1, FIBRE + 1)
)


def kinetic_energy() -> sp.Expr:
    """Quadratic and linear terms in the velocities."""
    pairs = [(s, r) for s in range(TOTAL) for r in range(TOTAL)]
    quadratic = [unknown(f"m{min(p) + 1}{max(p) + 1}") * V[p[0]] * V[p[1]] for p in pairs]
    return sp.Add(*quadratic) / 2 + sp.Add(*[unknown(f"l{s + 1}") * V[s] for s in range(TOTAL)])


@dataclass(frozen=True)
class Geometry:
    """The derived system with its connection."""

    eqs: Any
    motion: Motion
    connection: Connection

    @classmethod
    def derive(cls) -> Geometry:
        """Derive it."""
        system = vo.System(
            name="general-homogeneous",
            fibration=vo.Fibration(base=Q[:BASE], fibre=Q[BASE:]),
            lagrangian=kinetic_energy() - POTENTIAL,
            constraints=CONSTRAINTS,
        )
        eqs = vo.derive(system)
        motion = forced_motion(eqs, DELTA)
        return cls(eqs, motion, Connection(Q, lift_of_constraints()))

    # -- the connection --------------------------------------------------------------------

    def space(self) -> Study:
        """Vectors and forms on the whole tangent bundle."""
        link = self.connection
        fields = {x: link.field([unknown(f"{x}{s + 1}") for s in range(TOTAL)]) for x in "XY"}
        forms = list(link.vertical(V))[BASE:]
        two = [list(link.curvature(V, FREE))[BASE + nu] for nu in range(FIBRE)]
        names = {
            **self.places(),
            **fields,
            **{f"{x}^h": link.horizontal(field) for x, field in fields.items()},
            "X_q": sp.Matrix([0] * BASE + [unknown(f"X{s + 1}") for s in range(BASE, TOTAL)]),
            r"A(\cdot)": link.vertical,
            "A": as_field([0] * BASE + forms),
            r"\omega^{\nu}": lambda nu: forms[nu - 1],
            "B": as_field([0] * BASE + two),
            r"B^{\nu}": lambda nu: two[nu - 1],
            r"B(\cdot)": link.curvature,
            r"\delta q": as_field(self.displacement),
            r"\delta q_{s}": lambda s: self.displacement[s - 1],
        }
        motion = Motion(dict(zip(Q, V, strict=True)))
        variations = dict(zip(Q, FREE, strict=True))
        return Study(
            names,
            INDICES,
            motion,
            variations,
            LABELLED_LETTERS,
            context=self,
            note=NOTE,
            source=LINEAR,
        )

    def places(self) -> dict[str, Any]:
        """Coordinates, coefficients, components of the curvature, subspaces."""
        link, eqs = self.connection, self.eqs
        return {
            "t": vo.time,
            "n": sp.Integer(BASE),
            "k": sp.Integer(FIBRE),
            "q": sp.Matrix(Q),
            "q_{s}": lambda s: Q[s - 1],
            r"\dot q": sp.Matrix(V),
            r"\dot q_{s}": lambda s: V[s - 1],
            r"a_{\nu i}": coefficient,
            r"A_{ij}^{(\nu)}": lambda i, j, nu: eqs.curvature[nu - 1, i - 1, j - 1],
            r"B_{ij}^{\nu}": lambda i, j, nu: link.bracket(i, j)[BASE + nu - 1],
            r"\pi(\cdot)": base_point,
            "T_q": span(sp.eye(TOTAL)),
            "Q": sp.Integer(1),
            r"\mathcal D_q": kernel(sp.Matrix(CONSTRAINTS)),
            r"\mathcal V_q": span(sp.eye(TOTAL)[:, BASE:]),
            r"\oplus": direct_sum,
            r"\ker": kernel,
            r"\in": part_in,
        }

    # -- the motion ------------------------------------------------------------------------

    @cached_property
    def _dalembert(self) -> tuple[sp.Expr, ...]:
        """The d'Alembert equations of L = T - V."""
        left = lagrange(kinetic_energy() - POTENTIAL, Q)
        return dalembert(left, list(self.eqs.rates), BASE, self.motion)

    def dalembert(self, where: Mapping[str, int]) -> sp.Expr:
        """The d'Alembert equation of a base coordinate, as an expression that vanishes."""
        return self._dalembert[where["i"] - 1]

    @cached_property
    def forces(self) -> tuple[sp.Expr, ...]:
        """Q_s: what must stand on the right of the equations of T for those of L = T - V."""
        alone, whole = (lagrange(x, Q) for x in (kinetic_energy(), kinetic_energy() - POTENTIAL))
        return tuple(sp.expand(a - b) for a, b in zip(alone, whole, strict=True))

    def virtual_work(self) -> sp.Expr:
        """All of them, each times its virtual displacement."""
        return sp.Add(*[e * d for e, d in zip(self._dalembert, DELTA, strict=True)])

    @cached_property
    def displacement(self) -> sp.Matrix:
        """A virtual displacement: the constraints, which are homogeneous, solved for it."""
        return lift_of_constraints() * sp.Matrix(DELTA)

    def variational(self) -> sp.Expr:
        """sum_s (dL_c/dq_s - d/dt dL_c/dqdot_s) delta q_s."""
        theta = self.eqs.theta
        rows = [
            sp.diff(theta, q) - self.motion.derivative(sp.diff(theta, v))
            for q, v in zip(Q, V, strict=True)
        ]
        return sp.Matrix(rows).dot(self.displacement)

    def fibre_derivative(self, vector: sp.Matrix) -> sp.Expr:
        """FL(w) = sum_s dL/dqdot_s w_s."""
        slopes = [sp.diff(kinetic_energy(), v) for v in V]
        return self.motion.restrict(sp.Matrix(slopes).dot(vector))

    def right_side(self) -> list[tuple[str, Any]]:
        """What the variational derivative equals along the motion, in terms of B; for print."""
        rest = self.variational() + self.virtual_work()
        momentum = self.fibre_derivative(self.connection.curvature(V, self.displacement))
        text = r"\mathbb FL(B(\dot q,\delta q))"
        signs = [x for x in (1, -1) if vo.prove_equal(rest, x * momentum).proved]
        return [(r"\delta L_c", ("" if signs == [1] else "-") + text)] if signs else []

    def structure(self) -> list[tuple[str, sp.Expr]]:
        """The first d'Alembert equation, decomposed: the factor of each momentum is read off from
        how the unknown linear terms of L enter it."""
        theta, left = self.eqs.theta, r"\frac{d}{dt}\frac{\partial L_c}{\partial\dot q_1}"
        right = sp.Symbol(r"\frac{\partial L_c}{\partial q_{1}}")
        lifted = self.connection.field(list(self.connection.lift[:, 0]))
        rest = self.motion.derivative(sp.diff(theta, V[0])) - self._dalembert[0]
        rest = sp.expand(rest - lifted.along(theta))
        for nu in range(1, FIBRE + 1):
            slope = sp.Symbol(rf"\frac{{\partial L_c}}{{\partial q_{{{BASE + nu}}}}}")
            right += coefficient(nu, 1) * slope
            momentum = sp.Symbol(rf"\frac{{\partial L}}{{\partial\dot q_{{{BASE + nu}}}}}")
            factor = sp.diff(rest, unknown(f"l{BASE + nu}"))
            for j in range(2, BASE + 1):
                part = sp.diff(factor, V[j - 1])
                same = vo.prove_equal(part, -self.connection.bracket(1, j)[BASE + nu - 1]).proved
                name = -sp.Symbol(rf"B_{{1{j}}}^{{{nu}}}") if same else part
                right += momentum * name * V[j - 1]
        return [(left, right)]

    def kernel(self) -> Verdict:
        """Whether what the constraints leave free is the kernel of A."""
        ours = kernel(self.connection.vertical(V))
        return all_equal(zip(kernel(sp.Matrix(CONSTRAINTS)), ours, strict=True))

    def study(self) -> Study:
        """The dictionary of the equations of motion."""
        energy = kinetic_energy()
        names = {
            **self.places(),
            "T": energy,
            "V": POTENTIAL,
            "Q_{s}": lambda s: self.forces[s - 1],
            "L": energy - POTENTIAL,
            r"\Theta": self.motion.restrict(energy),
            "L_c": self.eqs.theta,
            r"\delta q": self.displacement,
            r"\delta q_{s}": lambda s: self.displacement[s - 1],
            r"\delta L_c": self.variational(),
            r"\dot q^h": self.connection.horizontal(sp.Matrix(V)),
        }
        return Study(
            names,
            INDICES,
            self.motion,
            {},
            LABELLED_LETTERS,
            letters=COEFFICIENTS,
            context=self,
            note=NOTE,
            source=SOURCE,
        )

    def lagrangian_study(self) -> Study:
        """The same where L is applied to positions and velocities."""
        value = kinetic_energy() - POTENTIAL

        def lagrangian(q: sp.Matrix, v: sp.Matrix) -> sp.Expr:
            return value.xreplace(dict(zip((*Q, *V), (*q, *v), strict=True)))

        # Nothing is on the constraints but what says so, such as the horizontal velocity.
        free = Motion({x: vo.velocity(x) for x in (*Q, *V)})
        study = self._with({r"L(\cdot)": lagrangian})
        return replace(study, motion=free, functions=frozenset({"V"}))

    def invariant(self) -> Study:
        """The same where FL is applied to a vertical vector; ``opposite`` changes the sign of B."""
        return self._with(
            {
                r"\mathbb F": sp.Integer(1),
                r"L(\cdot)": self.fibre_derivative,
                r"B(\cdot)": self.connection.curvature,
            }
        )

    def _with(self, more: Mapping[str, Any]) -> Study:
        study = self.study()
        return replace(study, names={**study.names, **more})


@cache
def geometry() -> Geometry:
    """The derived system."""
    return Geometry.derive()


def opposite(x: Any, y: Any) -> sp.Matrix:
    """B(X, Y) with the sign changed."""
    return -geometry().connection.curvature(x, y)


def base_point(place: Any) -> sp.Matrix:
    """The projection onto the base: the first coordinates of a point."""
    if len(place) != TOTAL:
        raise vo.DefinitionError(f"a point has {TOTAL} coordinates here, not {len(place)}")
    return sp.Matrix(place[:BASE])


def constraint_rows() -> sp.Matrix:
    """The constraints as one-forms, one in each row."""
    return sp.Matrix(CONSTRAINTS).jacobian(V)


def lift_of_constraints() -> sp.Matrix:
    """The constraints solved for the velocities of the fibre, by linear algebra alone."""
    rows = constraint_rows()
    return sp.Matrix.vstack(sp.eye(BASE), -rows[:, BASE:].LUsolve(rows[:, :BASE]))


def kernel(rates: sp.Matrix) -> sp.Matrix:
    """The velocities for which all of some functions, linear in them, vanish."""
    return null_space(sp.Matrix(rates).jacobian(V))


def as_field(components: Any) -> sp.Expr:
    """A vector field as a sum of formal directions."""
    return sp.Add(*[c * direction(q) for c, q in zip(components, Q, strict=True)])


def part_in(field: sp.Expr, space: sp.Matrix) -> sp.Expr:
    """The part of a field in a subspace: the vector there with the same leading components.

    A subspace is given by its echelon form; a field that lies in it is its own part.
    """
    components = [sp.diff(field, direction(q)) for q in Q]
    return as_field(space * sp.Matrix([components[place] for place in leading_places(space)]))
