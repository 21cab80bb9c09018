"""Chaplygin systems with a group of symmetries, a flow on tori, constraints that depend on time.

The groups are those of two dimensions: the translations, and x -> e^s1 x + s2 of the line, which
is locally the only one that is not Abelian.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import sympy as sp

import voronec as vo
from voronec.audit import Motion, Range, Study, Verdict

from .connections import Connection
from .verdicts import all_equal, all_zero

X = sp.symbols("x1:3")
S = sp.symbols("s1:3")
DX = tuple(vo.velocity(x) for x in X)
DS = tuple(vo.velocity(s) for s in S)
DELTA = sp.symbols("delta1:3")
OTHER, MORE = sp.symbols("y1:3"), sp.symbols("z1:3")
FACTOR = sp.Symbol("lambda")
BASE, FIBRE = len(X), len(S)
PHI = sp.symbols("varphi1:4")
SPEEDS = sp.symbols("omega1:4")


def on_base(name: str) -> sp.Expr:
    """An unknown function of the base."""
    return sp.Function(name)(*X)


@dataclass(frozen=True)
class Chaplygin:
    """L and the constraints invariant under a group: ``turning`` is 1 for the affine group of the
    line, and 0 for the translations."""

    turning: int
    eqs: Any

    @classmethod
    def derive(cls, turning: int) -> Chaplygin:
        """Derive it."""
        rows = [
            rate - sp.Add(*[on_base(f"a{nu}{i}") * x for i, x in enumerate(DX, start=1)])
            for nu, rate in enumerate(group_rates(turning), start=1)
        ]
        system = vo.System(
            name="chaplygin",
            fibration=vo.Fibration(base=X, fibre=S),
            lagrangian=invariant_lagrangian(turning),
            constraints=tuple(rows),
        )
        return cls(turning, vo.derive(system))

    @cached_property
    def motion(self) -> Motion:
        """Along the derived equations."""
        return Motion.of(self.eqs).solved(self.eqs)

    @cached_property
    def connection(self) -> Connection:
        """The lift of the base."""
        lift = [[sp.diff(rate, v) for v in DX] for rate in self.eqs.rates]
        return Connection((*X, *S), sp.Matrix(lift))

    def tensor(self, x: sp.Matrix, y: sp.Matrix, z: sp.Matrix) -> sp.Expr:
        """Sigma(X, Y, Z) = FL at X^h of B(Y, Z), where B(Y, Z) = -A([Y^h, Z^h])."""
        v = (*DX, *DS)
        slopes = [sp.diff(invariant_lagrangian(self.turning), w) for w in v]
        lifted = dict(zip(v, self.connection.lift * sp.Matrix(x), strict=True))
        at = sp.Matrix(slopes).xreplace(lifted)
        return at.dot(-self.connection.curvature(y, z))

    def force(self, x: sp.Matrix, y: sp.Matrix) -> sp.Expr:
        """JK(X, Y) = Sigma(X, X, Y): X stands in two places."""
        return self.tensor(x, x, y)

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
        note = f"groups of two dimensions, n = {BASE}, every coefficient an arbitrary function"
        note += "; quoted for groups of more dimensions"
        source = "the equations and the curvature derived for the system 'chaplygin'"
        return Study(
            names,
            {"i": BASE},
            self.motion,
            domains={r"\delta x": "T_xS"},
            context=self,
            note=note,
            source=source,
        )

    def invariance(self) -> Verdict:
        """Whether the group acts as it is said to, and mass, force and L_red are free of it."""
        entries = [*self.eqs.mass, *self.eqs.force, self.eqs.theta]
        free = all_zero(sp.diff(e, s) for e in entries for s in (*S, *DS))
        return free if acts(self.turning).proved else acts(self.turning)

    def bilinear(self) -> Verdict:
        """Whether JK is linear in its first argument, as a (0,2)-tensor must be."""
        x, delta = sp.Matrix(DX), sp.Matrix(DELTA)
        scaled = self.force(FACTOR * x, delta)
        found = vo.prove_equal(FACTOR * self.force(x, delta), scaled)
        if vo.prove_equal(FACTOR**2 * self.force(x, delta), scaled).proved:
            return replace(found, method="JK(lambda x', dx) = lambda^2 JK(x', dx), which is proved")
        return found

    def three_slots(self) -> str:
        """The tensor from which JK comes, where it is linear in each of three arguments."""
        slots = [sp.Matrix(DX), sp.Matrix(DELTA), sp.Matrix(OTHER)]
        more = sp.Matrix(MORE)
        pairs = []
        for place, slot in enumerate(slots):
            left, right, both = ([*slots] for _ in range(3))
            right[place], both[place] = more, slot + FACTOR * more
            whole = self.tensor(*left) + FACTOR * self.tensor(*right)
            pairs.append((self.tensor(*both), whole))
        text = r"JK(X,Y)=\Sigma(X,X,Y),\quad \Sigma(X,Y,Z)=\langle\mathbb FL(X^h),B(Y^h,Z^h)\rangle"
        return text if all_equal(pairs).proved else ""


def group_rates(turning: int) -> tuple[sp.Expr, ...]:
    """The velocity in the group, carried to the unit by the group's own right translations."""
    return DS[0], DS[1] - turning * S[1] * DS[0]


def acts(turning: int) -> Verdict:
    """Whether these rates are invariant under s1 -> s1 + a, s2 -> s2 + b exp(turning s1)."""
    a, b = sp.symbols("a b")
    moved = (S[0] + a, S[1] + b * sp.exp(turning * S[0]))
    shift = dict(zip(S, moved, strict=True))
    for ds, value in zip(DS, moved, strict=True):
        shift[ds] = sp.Add(*[sp.diff(value, s) * w for s, w in zip(S, DS, strict=True)])
    rates = group_rates(turning)
    return all_equal((rate.xreplace(shift), rate) for rate in rates)


def invariant_lagrangian(turning: int) -> sp.Expr:
    """T - V, every coefficient free of the fibre, in velocities that are invariant."""
    v = (*DX, *group_rates(turning))
    pairs = [(i, j) for i in range(len(v)) for j in range(len(v))]
    terms = [on_base(f"m{min(p) + 1}{max(p) + 1}") * v[p[0]] * v[p[1]] for p in pairs]
    return sp.Add(*terms) / 2 - on_base("V")


def fibre_study() -> Study:
    """B at one point, where its components are numbers, and an arbitrary Lagrangian there."""
    v = sp.symbols("v1:5")
    deltas = sp.symbols("d1:5")
    sizes = sp.symbols(f"B1:{FIBRE + 1}_12")

    def component(nu: int) -> Callable[[sp.Matrix, sp.Matrix], sp.Expr]:
        return lambda x, y: sizes[nu - 1] * (x[0] * y[1] - x[1] * y[0])

    def curvature(x: sp.Matrix, y: sp.Matrix) -> sp.Matrix:
        found = [component(nu)(x, y) for nu in range(1, FIBRE + 1)]
        return sp.Matrix([*(0 for _ in range(BASE)), *found])

    lagrangian = sp.Function("L")(*v)
    names = {
        "n": sp.Integer(BASE),
        "k": sp.Integer(FIBRE),
        "L": lagrangian,
        r"\mathbb F": sp.Integer(1),
        r"L(\cdot)": lambda w: sp.Add(
            *[sp.diff(lagrangian, x) * y for x, y in zip(v, w, strict=True)]
        ),
        r"B(\cdot)": curvature,
        r"B^{\nu}": component,
        r"\dot q": sp.Matrix(v),
        r"\dot q_{s}": lambda s: v[s - 1],
        r"\delta q": sp.Matrix(deltas),
    }
    indices = {"s": BASE + FIBRE, r"\nu": FIBRE}
    source = "the derivative of an arbitrary Lagrangian along the fibre, and any two-form"
    return Study(names, indices, labelled=frozenset({"B"}), source=source)


def torus_study() -> Study:
    """A flow on a torus of three angles, with an unknown positive factor Phi."""
    factor = sp.Function("Phi")(*PHI)
    value = sp.Symbol("p", positive=True)
    regular = Range("regular tori", r"\Phi>0", {factor: value}, (value,), letters={"p": r"\Phi=p"})
    rates = {phi: speed / factor for phi, speed in zip(PHI, SPEEDS, strict=True)}
    names = {
        "m": sp.Integer(len(PHI)),
        r"\Phi": factor,
        r"\varphi_{i}": lambda i: PHI[i - 1],
        r"\omega_{i}": lambda i: SPEEDS[i - 1],
    }
    return Study(
        names,
        {"i": len(PHI)},
        Motion(rates),
        ranges=(regular,),
        context=(factor, rates),
        source="a flow on a torus with an arbitrary factor of time",
    )


def torus_measure(study: Study) -> Verdict:
    """Whether Phi is the density of an invariant measure of that flow."""
    factor, rates = study.context
    return vo.prove_equal(vo.divergence(factor, rates), 0)


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
    return all_zero(found)
