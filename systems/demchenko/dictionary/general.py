"""The dictionary of the section on the Voronec principle: a general system, nothing special in it.

Three base and two fibre coordinates; every coefficient is an unknown function of all coordinates
and the time.  Its constraints are any that are affine in the velocities, and the a's of the paper
are their coefficients; what the paper's equations are compared with is d'Alembert's principle, made
from these constraints alone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study

from .principle import dalembert, forced_motion, lagrange

BASE, FIBRE = 3, 2
TOTAL = BASE + FIBRE

Q = sp.symbols(f"q1:{TOTAL + 1}")
V = tuple(vo.velocity(x) for x in Q)
FORCES = sp.symbols(f"Q1:{TOTAL + 1}")
DELTA = sp.symbols(f"delta1:{BASE + 1}")
COEFFICIENTS = dict.fromkeys(
    ("m", "l"), "$m_{ij}$ and $l_i$ are the coefficients of $T$, quadratic and linear in velocities"
)
"""The letters of the kinetic energy, in words."""
INDICES = {"i": BASE, "j": BASE, r"\nu": FIBRE, r"\mu": FIBRE, "s": TOTAL}


def unknown(name: str) -> sp.Expr:
    """An unknown function of all coordinates and the time."""
    return sp.Function(name)(*Q, vo.time)


def of_base(name: str) -> sp.Expr:
    """An unknown function of the base coordinates alone."""
    return sp.Function(name)(*Q[:BASE])


def kinetic_energy(unknown: Callable[[str], sp.Expr] = unknown) -> sp.Expr:
    """Quadratic, linear and constant terms in the velocities, every coefficient unknown."""
    pairs = [(s, r) for s in range(TOTAL) for r in range(TOTAL)]
    quadratic = [unknown(f"m{min(p) + 1}{max(p) + 1}") * V[p[0]] * V[p[1]] for p in pairs]
    linear = [unknown(f"l{s + 1}") * V[s] for s in range(TOTAL)]
    return sp.Add(*quadratic) / 2 + sp.Add(*linear) + unknown("m0")


def stated_names(unknown: Callable[[str], sp.Expr] = unknown) -> dict[str, Any]:
    """What needs no derivation."""
    return {
        "t": vo.time,
        "n": sp.Integer(BASE),
        "k": sp.Integer(FIBRE),
        "q_{s}": lambda s: Q[s - 1],
        r"\dot q_{s}": lambda s: V[s - 1],
        "Q_{s}": lambda s: FORCES[s - 1],
        r"a_{\nu i}": lambda nu, i: unknown(f"a{nu}{i}"),
        r"a_{\nu}": lambda nu: unknown(f"a{nu}"),
        "T": kinetic_energy(unknown),
    }


def constraints(names: Mapping[str, Any]) -> Iterator[sp.Expr]:
    """What vanishes: a dependent velocity less one that is affine in the independent ones."""
    for nu in range(1, FIBRE + 1):
        along = [names[r"a_{\nu i}"](nu, i + 1) * w for i, w in enumerate(V[:BASE])]
        yield V[BASE + nu - 1] - sp.Add(*along, names[r"a_{\nu}"](nu))


@dataclass(frozen=True)
class General:
    """The derived general system: engine, motion, and the lift of the base velocities."""

    names: Mapping[str, Any]
    eqs: Any
    motion: Motion
    lift: tuple[tuple[sp.Expr, ...], ...]

    @classmethod
    def derive(cls) -> General:
        """Derive it."""
        return cls._with(stated_names())

    @classmethod
    def chaplygin(cls) -> General:
        """The same where nothing depends on the fibre coordinates, nor on the time, and the
        constraints are homogeneous."""
        still: dict[str, Any] = {r"a_{\nu}": lambda nu: sp.Integer(0)}
        return cls._with(stated_names(of_base) | still)

    @classmethod
    def _with(cls, names: Mapping[str, Any]) -> General:
        system = vo.System(
            name="general",
            fibration=vo.Fibration(base=Q[:BASE], fibre=Q[BASE:]),
            lagrangian=names["T"],
            constraints=tuple(constraints(names)),
            parameters=FORCES,
            forces=dict(zip(Q, FORCES, strict=True)),
        )
        eqs = vo.derive(system)
        lift = tuple(tuple(sp.diff(rate, v) for v in V[:BASE]) for rate in eqs.rates)
        motion = forced_motion(eqs, DELTA)
        return cls(names, eqs, motion, lift)

    def dalembert(self, where: Mapping[str, int]) -> sp.Expr:
        """The d'Alembert equation of a base coordinate, as an expression that vanishes."""
        return self._dalembert[where["i"] - 1]

    @cached_property
    def _dalembert(self) -> tuple[sp.Expr, ...]:
        """The generalized forces stand on the left, with a minus sign."""
        sides = zip(lagrange(self.names["T"], Q), FORCES, strict=True)
        left = [side - force for side, force in sides]
        return dalembert(left, list(self.eqs.rates), BASE, self.motion)

    def transposition(self, where: Mapping[str, int]) -> sp.Expr:
        """d(delta q)/dt - delta(dq/dt) of a fibre coordinate, by the engine's curvature."""
        nu, found = where[r"\nu"] - 1, sp.Integer(0)
        for i, variation in enumerate(DELTA):
            along = [self.eqs.curvature[nu, i, j] * w for j, w in enumerate(V[:BASE])]
            found += sp.Add(*along, self.eqs.curvature.time[nu, i]) * variation
        return found

    def chaplygins(self) -> vo.Verdict:
        """Whether the d'Alembert equations are Chaplygin's, and close in the base."""
        energy = self.names["T"]
        theta = self.motion.restrict(energy)
        momenta = [self.motion.restrict(sp.diff(energy, v)) for v in V[BASE:]]
        a = [[self.names[r"a_{\nu i}"](nu + 1, i + 1) for i in range(BASE)] for nu in range(FIBRE)]
        for i in range(BASE):
            right = sp.diff(theta, Q[i]) + FORCES[i]
            for row, momentum, force in zip(a, momenta, FORCES[BASE:], strict=True):
                turn = [(sp.diff(row[i], Q[j]) - sp.diff(row[j], Q[i])) * V[j] for j in range(BASE)]
                right += row[i] * force + momentum * sp.Add(*turn)
            equation = self.motion.derivative(sp.diff(theta, V[i])) - right
            if equation.free_symbols & {vo.time, *Q[BASE:], *V[BASE:]}:
                return vo.Verdict("refuted", "an equation holds the time or a fibre coordinate")
            verdict = vo.prove_equal(equation, self._dalembert[i])
            if not verdict.proved:
                return verdict
        return verdict

    def structure(self) -> list[tuple[str, sp.Expr]]:
        """The first d'Alembert equation, decomposed: how the derivatives of Theta, the forces and
        the momenta K enter it is read off from how the unknown coefficients of T enter."""
        truth = sp.expand(self.dalembert({"i": 1}))
        theta = self.eqs.theta
        inertia = self.motion.derivative(sp.diff(theta, V[0]))
        right = sp.Integer(0)
        rest = inertia - truth
        for s, (q, force) in enumerate(zip(Q, FORCES, strict=True), start=1):
            along = -sp.diff(truth, sp.diff(unknown("m0"), q))
            right += along * sp.Symbol(rf"\frac{{\partial\Theta}}{{\partial q_{{{s}}}}}")
            right -= sp.diff(truth, force) * sp.Symbol(f"Q_{{{s}}}")
            rest -= along * sp.diff(theta, q) - sp.diff(truth, force) * force
        rest = sp.expand(rest)
        for nu in range(1, FIBRE + 1):
            factor = sp.diff(rest, unknown(f"l{BASE + nu}"))
            right += sp.Symbol(f"K_{{{nu}}}") * self._spell(factor, nu)
        return [(r"\frac{d}{dt}\frac{\partial\Theta}{\partial\dot q_{1}}", right)]

    def _spell(self, factor: sp.Expr, nu: int) -> sp.Expr:
        """A combination of velocities, with coefficients called by their name where they are
        components of the curvature."""
        found = sp.Integer(0)
        at_rest = {v: sp.Integer(0) for v in V}
        for j in range(1, BASE + 1):
            coefficient = sp.diff(factor, V[j - 1])
            name = sp.Symbol(f"A_{{1{j}}}^{{({nu})}}")
            same = vo.prove_equal(coefficient, self.eqs.curvature[nu - 1, 0, j - 1]).proved
            found += (name if same and coefficient != 0 else coefficient) * V[j - 1]
        constant = factor.xreplace(at_rest)
        same = vo.prove_equal(constant, self.eqs.curvature.time[nu - 1, 0]).proved
        return found + (sp.Symbol(f"A_{{1}}^{{({nu})}}") if same else constant)

    def study(self) -> Study:
        """The dictionary; derived quantities come from the engine."""
        eqs, lift = self.eqs, self.lift
        virtual = [sp.Add(*[h * d for h, d in zip(row, DELTA, strict=True)]) for row in lift]
        derived = {
            r"\Theta": eqs.theta,
            r"K_{\nu}": lambda nu: eqs.momenta[nu - 1],
            r"A_{ij}^{(\nu)}": lambda i, j, nu: eqs.curvature[nu - 1, i - 1, j - 1],
            r"A_{i}^{(\nu)}": lambda i, nu: eqs.curvature.time[nu - 1, i - 1],
            r"\delta q_{s}": lambda s: virtual[s - 1],
            r"\delta\dot q_{i}": lambda i: vo.velocity(DELTA[i - 1]),
        }
        variations = dict(zip(Q, virtual, strict=True))
        variations |= {v: vo.velocity(d) for v, d in zip(V[:BASE], DELTA, strict=True)}
        return Study(
            {**self.names, **derived},
            INDICES,
            self.motion,
            variations,
            context=self,
            letters=COEFFICIENTS,
            source="d'Alembert's principle and the equations derived for the system 'general'",
            note=f"n = {BASE}, k = {FIBRE}, every coefficient an arbitrary function",
        )
