"""What d'Alembert's principle needs of a system, differentiated once and laid out for evaluation.

    d/dt dL/dqdot - dL/dq = Q + C^T lambda,     phi_k(q, qdot, t) = C_k qdot + c_k = 0

With W = (dL/dq) qdot + dL/dt at fixed qdot, the chain rule gives, for the part of d/dt dL/dqdot_i
that holds no acceleration, dW/dqdot_i - dL/dq_i: 2 N derivatives instead of N^2.

On a group with fields X_a, [X_a, X_b] = C_ab^c X_c, the velocities w^a stand for qdot and X_a for
d/dq_a, and the principle reads

    d/dt dL/dw^a - X_a L + C_ab^c w^b dL/dw^c = Q_a + (C^T lambda)_a      [Theory, eq. (19)].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import flint
import mpmath as mp
import symengine as se
import sympy as sp

from voronec.algebra.stable import stable_all
from voronec.algebra.symbols import plain_name, time, velocity
from voronec.algebra.tape import Tape, middle
from voronec.declaration.system import System
from voronec.equations.referee.names import Names
from voronec.errors import DefinitionError

NOISE = flint.arb(2) ** -16
"""Balls that are wider than this part of their size, or of one, tell no value."""


class ExpressionSequence:
    """Several symengine expressions, ready to be evaluated at any precision of mpmath.

    ``names`` are the symbols they need.  A function that is not elementary raises ``EngineLimit``.
    """

    def __init__(self, exprs: Sequence[Any]) -> None:
        self._tape = Tape(stable_all(exprs))
        self.names = [str(s) for s in self._tape.atoms]

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """The values at a point ``{name: mpf}``, at the working precision.

        Raises ``DefinitionError`` where an expression is not defined or not real.
        """
        balls = self._tape.arb(values, mp.mp.prec)
        if not all(b.is_finite() and b.rad() <= NOISE * (1 + abs(b)).upper() for b in balls):
            raise DefinitionError(
                "the equations have no real value at this point (a division by zero, a root or "
                "logarithm of a negative number, a jump); choose another point or other coordinates"
            )
        return [*map(middle, balls)]


@dataclass(frozen=True)
class Form:
    """coefficients * qdot + offset; ``bends`` are second derivatives that ought to vanish."""

    label: str
    coefficients: tuple[Any, ...]
    offset: Any
    bends: tuple[Any, ...]


@dataclass(frozen=True)
class Plan:
    """A system laid out for evaluation; N coordinates, m constraints, r relations, n velocities.

    On a group N counts the velocities of its frame, called ``dots``, which are the velocities of
    the coordinates elsewhere; ``followers`` evaluates to the rates of the coordinates' rates:
    their derivatives by ``dots``, and what is left where these are constant.

    ``relations`` evaluates to the r relations, then their r x N derivatives;
    ``kinematics`` to the coefficients and the offset of each form, N + 1 numbers a form: the
    constraints, the differentiated relations, the definitions of the velocities;
    ``dynamics`` to the mass matrix d2L/dqdot2 (N x N), the N forces that stand for mass * qddot,
    and the m + r right sides of C qddot = ...;
    ``bends`` to what must vanish at any velocities, ``bent`` says of which form.
    ``labels`` name the forms, ``exact`` = m + r counts those that hold exactly.
    """

    system: System
    coordinates: tuple[str, ...]
    dots: tuple[str, ...]
    velocities: tuple[str, ...]
    labels: tuple[str, ...]
    exact: int
    relations: ExpressionSequence
    kinematics: ExpressionSequence
    dynamics: ExpressionSequence
    bends: ExpressionSequence
    bent: tuple[str, ...]
    followers: ExpressionSequence | None

    @property
    def occurring_names(self) -> set[str]:
        """The names of everything that occurs anywhere."""
        parts = (self.relations, self.kinematics, self.dynamics, self.bends)
        return {name for part in parts for name in part.names}


@dataclass(frozen=True)
class _SymbolTable:
    """A system's symbols as the referee names them."""

    system: System
    names: Names
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    qdot: tuple[Any, ...]
    time: Any
    definitions: dict[Any, Any]

    def enter(self, expr: sp.Expr) -> Any:
        """An expression inside, its quasi-velocities written with coordinate velocities."""
        return self.names.read(expr).xreplace(self.definitions)

    def drift(self, expr: Any) -> Any:
        """The time derivative at fixed velocities; inputs go with their rates."""
        terms = [expr.diff(q) * v for q, v in zip(self.q, self.qdot, strict=True)]
        for jet in self.names.inputs:
            terms += [expr.diff(u) * rate for u, rate in pairwise(jet)]
        return se.Add(expr.diff(self.time), *terms)

    def accelerations(self) -> dict[Any, Any]:
        """What forces may hold besides: of each its symbol, in terms of those of qdot."""
        system = self.system
        dots = system.directions if system.on_group else map(velocity, system.coordinates)
        symbols, found = [self.names.symbol(velocity(w)) for w in dots], {}
        if system.on_group:
            return {a: a for a in symbols}
        for v in system.velocities if system.frame is not None else ():
            meant = self.definitions[self.names.symbol(v)]
            parts = (meant.diff(w) * a for w, a in zip(self.v, symbols, strict=True))
            found[self.names.symbol(velocity(v))] = se.Add(self.drift(meant), *parts)
        return {a: a for a in symbols} | found


def make_plan(system: System) -> Plan:
    """Differentiate a system's Lagrangian, constraints and relations once."""
    inside = _enter(system)
    relations = [_smooth(inside.enter(r)) for r in system.fibration.relations]
    bound = [_smooth(inside.enter(c)) for c in system.constraints]
    bound += [inside.drift(r) for r in relations]
    labels = [f"constraint {i + 1}" for i in range(len(system.constraints))]
    labels += [f"the derivative of relation {i + 1}" for i in range(len(relations))]
    exact = len(bound)
    for v in system.velocities:
        bound.append(inside.enter(v))
        labels.append(f"the definition of '{plain_name(v)}'")
    forms = [_form(inside, *pair) for pair in zip(labels, bound, strict=True)]
    bends = [(f.label, b) for f in forms for b in f.bends]
    return Plan(
        system=system,
        coordinates=tuple(map(str, inside.q)),
        dots=tuple(map(str, inside.v)),
        velocities=tuple(map(plain_name, system.velocities)),
        labels=tuple(labels),
        exact=exact,
        relations=ExpressionSequence(
            [*relations, *(r.diff(q) for r in relations for q in inside.q)]
        ),
        kinematics=ExpressionSequence([e for f in forms for e in (*f.coefficients, f.offset)]),
        dynamics=ExpressionSequence(
            [*_dynamics(inside), *(-inside.drift(c) for c in bound[:exact])]
        ),
        bends=ExpressionSequence([b for _, b in bends]),
        bent=tuple(label for label, _ in bends),
        followers=_followers(inside),
    )


def _enter(system: System) -> _SymbolTable:
    names, frame = Names(system), system.frame
    clock = names.symbol(time)
    v = tuple(names.symbol(velocity(x)) for x in system.coordinates)
    q = tuple(map(names.symbol, system.coordinates))
    if frame is not None and frame.is_group:
        w = tuple(map(names.symbol, frame.ambient))
        rates = tuple(names.read(frame.rates[x]) for x in system.coordinates)
        return _SymbolTable(system, names, q, w, rates, clock, dict(zip(v, rates, strict=True)))
    definitions = {}
    if frame is not None:
        symbols = map(names.symbol, frame.velocities)
        definitions = dict(zip(symbols, map(names.read, frame.expressions), strict=True))
    for name, expr in definitions.items():
        if any(se.has_symbol(expr, other) for other in definitions):
            raise DefinitionError(
                f"the definition of '{name}' contains a quasi-velocity; "
                "write it with the velocities of the coordinates"
            )
    return _SymbolTable(system, names, q, v, v, clock, definitions)


def _dynamics(inside: _SymbolTable) -> list[Any]:
    """The mass matrix row by row, then Q + dL/dq - (d/dt dL/dqdot without accelerations).

    What the forces hold of the accelerations counts as mass.
    """
    lagrangian = _smooth(inside.enter(inside.system.lagrangian))
    change = inside.drift(lagrangian)
    momenta = [lagrangian.diff(v) for v in inside.v]
    slopes = [lagrangian.diff(q) for q in inside.q]
    if inside.qdot != inside.v:  # X_a L
        slopes = [
            se.Add(*[s * rate.diff(w) for s, rate in zip(slopes, inside.qdot, strict=True)])
            for w in inside.v
        ]
    applied, pushed = _read_forces(inside)
    force = [
        q_force + 2 * slope - change.diff(v) - turn
        for slope, v, q_force, turn in zip(
            slopes, inside.v, applied, _group_terms(inside, momenta), strict=True
        )
    ]
    mass = [p.diff(v) for p in momenta for v in inside.v]
    return [*(m - x for m, x in zip(mass, pushed, strict=True)), *force]


def _read_forces(inside: _SymbolTable) -> tuple[list[Any], list[Any]]:
    """The forces without accelerations, and their slopes by each of these, row by row."""
    system, zero = inside.system, sp.Integer(0)
    applied = [inside.enter(system.forces.get(x, zero)) for x in system.directions]
    meant = inside.accelerations()
    symbols = [a for a, expr in meant.items() if a == expr]
    spelled = [f.xreplace(meant) for f in applied]
    slopes = [f.diff(a) for f in spelled for a in symbols]
    if any(se.has_symbol(slope, a) for slope in slopes for a in symbols):
        raise DefinitionError("a force is not linear in the accelerations; solve it for them")
    return [f.xreplace(dict.fromkeys(symbols, se.Integer(0))) for f in spelled], slopes


def _group_terms(inside: _SymbolTable, momenta: list[Any]) -> list[Any]:
    """C_ab^c w^b p_c of a group; zero in coordinates."""
    frame = inside.system.frame
    total = dict.fromkeys(inside.v, se.Integer(0))
    momentum = dict(zip(inside.v, momenta, strict=True))
    for pair, parts in ((frame.brackets if frame is not None else None) or {}).items():
        a, b = map(inside.names.symbol, pair)
        weight = se.Add(
            *[inside.names.read(x) * momentum[inside.names.symbol(c)] for c, x in parts.items()]
        )
        total[a] += b * weight
        total[b] -= a * weight
    return list(total.values())


def _followers(inside: _SymbolTable) -> ExpressionSequence | None:
    """On a group, the second derivatives of the coordinates: A wdot + b, row by row."""
    if inside.qdot == inside.v:
        return None
    return ExpressionSequence(
        [e for r in inside.qdot for e in (*(r.diff(w) for w in inside.v), inside.drift(r))]
    )


def _form(inside: _SymbolTable, label: str, expr: Any) -> Form:
    """Read an expression that is affine in the velocities, or seems not to be."""
    at_rest = {v: se.Integer(0) for v in inside.v}
    if any(n.free_symbols & at_rest.keys() for n in expr.atoms(se.sign, se.floor)):
        nothing = se.Integer(0)  # what jumps with a velocity has no slope there, and bends
        return Form(label, (nothing,) * len(inside.v), nothing, (se.Integer(1),))
    coefficients = [expr.diff(v) for v in inside.v]
    bends = [
        bend
        for i, c in enumerate(coefficients)
        for v in inside.v[: i + 1]
        if se.has_symbol(c, v) and se.expand(bend := c.diff(v)) != 0
    ]
    plain = tuple(c.xreplace(at_rest) for c in coefficients)
    return Form(label, plain, expr.xreplace(at_rest), tuple(bends))


def _smooth(expr: Any) -> Any:
    """Absolute values as roots of squares, which can be differentiated away from zero."""
    while found := expr.atoms(se.Abs):
        expr = expr.xreplace({node: se.sqrt(node.args[0] ** 2) for node in found})
    return expr
