"""What d'Alembert's principle needs of a system, differentiated once and laid out for evaluation.

    d/dt dL/dqdot - dL/dq = Q + C^T lambda,     phi_k(q, qdot, t) = C_k qdot + c_k = 0

With W = (dL/dq) qdot + dL/dt at fixed qdot, the chain rule gives, for the part of d/dt dL/dqdot_i
that holds no acceleration, dW/dqdot_i - dL/dq_i: 2 N derivatives instead of N^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.door import Door
from voronec.algebra.symbols import plain_name, time, velocity
from voronec.errors import DefinitionError
from voronec.multipliers.sequence import Sequenced
from voronec.system import System

__all__ = ["Plan", "make_plan"]


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
    coordinate_velocities: tuple[str, ...]
    velocities: tuple[str, ...]
    labels: tuple[str, ...]
    exact: int
    relations: Sequenced
    kinematics: Sequenced
    dynamics: Sequenced
    bends: Sequenced
    bent: tuple[str, ...]

    @property
    def needs_time(self) -> bool:
        """Whether the time occurs anywhere."""
        parts = (self.relations, self.kinematics, self.dynamics, self.bends)
        return any(plain_name(time) in part.names for part in parts)


@dataclass(frozen=True)
class _Entered:
    """A system's symbols inside the door."""

    system: System
    door: Door
    q: tuple[Any, ...]
    v: tuple[Any, ...]
    time: Any
    definitions: dict[Any, Any]

    def enter(self, expr: sp.Expr) -> Any:
        """An expression inside, its quasi-velocities written with coordinate velocities."""
        return self.door.inward(expr).xreplace(self.definitions)

    def drift(self, expr: Any) -> Any:
        """The time derivative at fixed velocities."""
        terms = (expr.diff(q) * v for q, v in zip(self.q, self.v, strict=True))
        return se.Add(expr.diff(self.time), *terms)


def make_plan(system: System) -> Plan:
    """Differentiate a system's Lagrangian, constraints and relations once."""
    inside = _entered(system)
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
        coordinate_velocities=tuple(map(str, inside.v)),
        velocities=tuple(map(plain_name, system.velocities)),
        labels=tuple(labels),
        exact=exact,
        relations=Sequenced([*relations, *(r.diff(q) for r in relations for q in inside.q)]),
        kinematics=Sequenced([e for f in forms for e in (*f.coefficients, f.offset)]),
        dynamics=Sequenced([*_dynamics(inside), *(-inside.drift(c) for c in bound[:exact])]),
        bends=Sequenced([b for _, b in bends]),
        bent=tuple(label for label, _ in bends),
    )


def _entered(system: System) -> _Entered:
    # A parameter that is a function of the time must keep its derivative: it stays a function.
    moving = [p.symbol for p in system.parameters if not isinstance(p.symbol, sp.Symbol)]
    door = Door(s for s in system.known_symbols() if s not in moving)
    v = tuple(door.inward(velocity(x)) for x in system.coordinates)
    definitions = {}
    if system.frame is not None:
        names = door.inward_all(system.frame.velocities)
        definitions = dict(zip(names, door.inward_all(system.frame.expressions), strict=True))
    for name, expr in definitions.items():
        if any(se.has_symbol(expr, other) for other in definitions):
            raise DefinitionError(
                f"the definition of '{name}' contains a quasi-velocity; "
                "write it with the velocities of the coordinates"
            )
    return _Entered(
        system, door, tuple(map(door.inward, system.coordinates)), v, door.inward(time), definitions
    )


def _dynamics(inside: _Entered) -> list[Any]:
    """The mass matrix row by row, then Q + dL/dq - (d/dt dL/dqdot without accelerations)."""
    lagrangian = _smooth(inside.enter(inside.system.lagrangian))
    change = inside.drift(lagrangian)
    momenta = [lagrangian.diff(v) for v in inside.v]
    zero = sp.Integer(0)
    applied = [inside.enter(inside.system.forces.get(x, zero)) for x in inside.system.coordinates]
    force = [
        q_force + 2 * lagrangian.diff(q) - change.diff(v)
        for q, v, q_force in zip(inside.q, inside.v, applied, strict=True)
    ]
    return [*(p.diff(v) for p in momenta for v in inside.v), *force]


def _form(inside: _Entered, label: str, expr: Any) -> Form:
    """Read an expression that is affine in the velocities, or seems not to be."""
    at_rest = {v: se.Integer(0) for v in inside.v}
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
