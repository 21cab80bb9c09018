"""Chaplygin systems with Abelian symmetry, a flow on tori, constraints that depend on the time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Study, Verdict

from .connections import Connection
from .measures import divergence

X = sp.symbols("x1:3")
S = sp.symbols("s1:3")
DX = tuple(vo.velocity(x) for x in X)
DS = tuple(vo.velocity(s) for s in S)
DELTA = sp.symbols("delta1:3")
BASE, FIBRE = len(X), len(S)
PHI = sp.symbols("varphi1:4")
SPEEDS = sp.symbols("omega1:4")


def on_base(name: str) -> sp.Expr:
    """An unknown function of the base."""
    return sp.Function(name)(*X)


def invariant_lagrangian() -> sp.Expr:
    """T - V, every coefficient free of the fibre."""
    v = (*DX, *DS)
    pairs = [(i, j) for i in range(len(v)) for j in range(len(v))]
    terms = [on_base(f"m{min(p) + 1}{max(p) + 1}") * v[p[0]] * v[p[1]] for p in pairs]
    return sp.Add(*terms) / 2 - on_base("V")


@dataclass(frozen=True)
class Abelian:
    """L and the constraints invariant under the translations of the fibre."""

    eqs: Any

    @classmethod
    def derived(cls) -> Abelian:
        """Derive it."""
        rows = [
            DS[nu] - sp.Add(*[on_base(f"a{nu + 1}{i + 1}") * DX[i] for i in range(BASE)])
            for nu in range(FIBRE)
        ]
        system = vo.System(
            name="abelian-chaplygin",
            fibration=vo.Fibration(base=X, fibre=S),
            lagrangian=invariant_lagrangian(),
            constraints=tuple(rows),
        )
        return cls(vo.derive(system))

    @cached_property
    def motion(self) -> Motion:
        """Along the derived equations."""
        return Motion.of(self.eqs).solved(self.eqs)

    @cached_property
    def connection(self) -> Connection:
        """The lift of the base."""
        lift = [[sp.diff(rate, v) for v in DX] for rate in self.eqs.rates]
        return Connection((*X, *S), sp.Matrix(lift))

    def force(self, x: sp.Matrix, y: sp.Matrix) -> sp.Expr:
        """JK(X, Y) = FL(B(X, Y)) with B(X, Y) = -A([X^h, Y^h]), at the velocity X."""
        slopes = sp.Matrix([sp.diff(invariant_lagrangian(), v) for v in (*DX, *DS)])
        return self.motion.restrict(slopes.dot(-self.connection.curvature(x, y)))

    def study(self) -> Study:
        """The dictionary, in the notation of the base."""
        theta = self.eqs.theta
        rows = [
            sp.diff(theta, x) - self.motion.derivative(sp.diff(theta, v))
            for x, v in zip(X, DX, strict=True)
        ]
        names = {
            "t": vo.time,
            "n": sp.Integer(BASE),
            "L_{red}": theta,
            r"\delta L_{red}": sp.Add(*[row * d for row, d in zip(rows, DELTA, strict=True)]),
            "x_{i}": lambda i: X[i - 1],
            r"\dot x_{i}": lambda i: DX[i - 1],
            r"\delta x_{i}": lambda i: DELTA[i - 1],
            r"\dot x": sp.Matrix(DX),
            r"\delta x": sp.Matrix(DELTA),
            "J": sp.Integer(1),
            r"K(\cdot)": self.force,
        }
        note = f"an Abelian group, n = {BASE}, k = {FIBRE}, every coefficient an arbitrary function"
        return Study(names, {"i": BASE}, self.motion, context=self, note=note)

    def closed(self) -> Verdict:
        """Whether mass and force are free of the fibre and of its velocities."""
        entries = [*self.eqs.mass, *self.eqs.force]
        return all_proved(sp.diff(e, s) for e in entries for s in (*S, *DS))


def fibre_study() -> Study:
    """B at one point, where its components are numbers, and an arbitrary Lagrangian there."""
    v = sp.symbols("v1:5")
    deltas = sp.symbols("d1:5")
    parts = [
        sp.Symbol(f"B{nu}12") * (v[0] * deltas[1] - v[1] * deltas[0]) for nu in range(1, FIBRE + 1)
    ]
    lagrangian = sp.Function("L")(*v)
    names = {
        "n": sp.Integer(BASE),
        "k": sp.Integer(FIBRE),
        "L": lagrangian,
        r"\mathbb F": sp.Integer(1),
        r"L(\cdot)": lambda w: sp.Add(
            *[sp.diff(lagrangian, x) * y for x, y in zip(v, w, strict=True)]
        ),
        r"B(\cdot)": lambda x, y: sp.Matrix([*(0 for _ in range(BASE)), *parts]),
        r"B^{\nu}": lambda nu: parts[nu - 1],
        r"\dot q": sp.Matrix(v),
        r"\dot q_{s}": lambda s: v[s - 1],
        r"\delta q": sp.Matrix(deltas),
    }
    indices = {"s": BASE + FIBRE, r"\nu": FIBRE}
    return Study(names, indices, labelled=frozenset({"B"}))


def torus_study() -> Study:
    """A flow on a torus of three angles, with an unknown factor Phi."""
    factor = sp.Function("Phi")(*PHI)
    rates = {phi: speed / factor for phi, speed in zip(PHI, SPEEDS, strict=True)}
    return Study({r"\Phi": factor}, motion=Motion(rates), context=(factor, rates))


def torus_measure(study: Study) -> Verdict:
    """Whether Phi is the density of an invariant measure of that flow."""
    factor, rates = study.context
    return vo.prove_equal(divergence(factor, rates), 0)


def with_time() -> Verdict:
    """Whether A_ij and A_i are, up to the sign, the components of the curvature on Q x R.

    The lifts are h_i = d_i + a_(nu i) d_nu and h_0 = d_t + a_nu d_nu, every coefficient an unknown
    function of all coordinates and the time.
    """
    places = (*X, *S, vo.time)
    names = [[f"a{nu}{i}" for i in range(1, BASE + 1)] for nu in range(1, FIBRE + 1)]
    rows = [[sp.Function(name)(*places) for name in row] for row in names]
    offsets = [sp.Function(f"a{nu}")(*places) for nu in range(1, FIBRE + 1)]
    constraints = [
        ds - sp.Add(*[a * dx for a, dx in zip(row, DX, strict=True)]) - offset
        for ds, row, offset in zip(DS, rows, offsets, strict=True)
    ]
    system = vo.System(
        name="moving",
        fibration=vo.Fibration(base=X, fibre=S),
        lagrangian=sp.Add(*[v**2 for v in (*DX, *DS)]) / 2,
        constraints=tuple(constraints),
    )
    table = vo.derive(system).curvature
    order = (*X, vo.time, *S)
    lift = sp.Matrix.vstack(
        sp.eye(BASE + 1),
        sp.Matrix([[*row, offset] for row, offset in zip(rows, offsets, strict=True)]),
    )
    link = Connection(order, lift)
    found = []
    for nu in range(FIBRE):
        place = BASE + 1 + nu
        found += [
            link.bracket(i, j)[place] + table[nu, i - 1, j - 1] for i in (1, 2) for j in (1, 2)
        ]
        found += [link.bracket(i, BASE + 1)[place] + table.time[nu, i - 1] for i in (1, 2)]
    return all_proved(found)


def all_proved(values: Any) -> Verdict:
    """Whether all values vanish; the first that does not decides."""
    found = [vo.prove_equal(x, 0) for x in values]
    return next((verdict for verdict in found if not verdict.proved), found[0])
