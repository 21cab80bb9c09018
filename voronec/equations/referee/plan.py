"""What d'Alembert's principle needs of a system, differentiated once and laid out for evaluation.

    d/dt dL/dqdot - dL/dq = Q + C^T lambda,     phi_k(q, qdot, t) = C_k qdot + c_k = 0

With W = (dL/dq) qdot + dL/dt at fixed qdot, the chain rule gives, for the part of d/dt dL/dqdot_i
that holds no acceleration, dW/dqdot_i - dL/dq_i: 2 N derivatives instead of N^2.

On a group with fields X_a, [X_a, X_b] = C_ab^c X_c, the velocities w^a stand for qdot and X_a for
d/dq_a, and the principle reads

    d/dt dL/dw^a - X_a L + C_ab^c w^b dL/dw^c = Q_a + (C^T lambda)_a      [Theory, eq. (19)].
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import mpmath as mp
import symengine as se
import sympy as sp

from voronec.algebra import numeric_functions as numeric
from voronec.algebra.stable import stable_all
from voronec.algebra.symbols import plain_name, time, velocity
from voronec.declaration.system import System
from voronec.equations.referee.names import Names
from voronec.errors import DefinitionError

Operation = Callable[..., Any]

_NAMES = (
    "sin cos tan cot sec csc asin acos atan acot atan2 "
    "sinh cosh tanh coth asinh acosh atanh log sign floor"
).split()
_FUNCTIONS: dict[str, Operation] = {name: getattr(mp, name) for name in _NAMES} | {"Abs": mp.fabs}
_FUNCTIONS |= {
    numeric.SINC: mp.sinc,
    numeric.SINC_SLOPE: lambda a: mp.hyp0f1(mp.mpf(5) / 2, -a * a / 4) / 3,
    numeric.EXPM1: mp.expm1,
    numeric.LOG1P: mp.log1p,
    numeric.SIZE: mp.fabs,
    numeric.HYPOT: lambda *sides: mp.sqrt(mp.fsum(a * a for a in sides)),
}
_CONDITIONS: dict[str, Operation] = {
    "LessThan": lambda a, b: a <= b,
    "StrictLessThan": lambda a, b: a < b,
    "Equality": lambda a, b: a == b,
    "Unequality": lambda a, b: a != b,
    "And": lambda *given: all(given),
    "Or": lambda *given: any(given),
    "Not": lambda given: not given,
    "BooleanTrue": lambda: True,
    "BooleanFalse": lambda: False,
}
_CONSTANTS: dict[Any, Operation] = {se.pi: lambda: +mp.pi, se.E: lambda: +mp.e}


class ExpressionSequence:
    """Several symengine expressions, ready to be evaluated at any precision of mpmath.

    ``names`` are the symbols they need, in the order of their slots.  A function that is not
    elementary raises ``DefinitionError``.
    """

    def __init__(self, exprs: Sequence[Any]) -> None:
        roots = stable_all(exprs)
        order = _operands_first(roots)
        symbols = [e for e in order if isinstance(e, se.Symbol)]
        composite = [e for e in order if not isinstance(e, se.Symbol)]
        slots = {e: slot for slot, e in enumerate([*symbols, *composite])}
        self.names = [str(s) for s in symbols]
        self._steps = [(op, [slots[a] for a in args]) for op, args in map(_step, composite)]
        self._outputs = [slots[root] for root in roots]

    def __call__(self, values: Mapping[str, Any]) -> list[Any]:
        """The values at a point ``{name: mpf}``, at the working precision.

        Raises ``DefinitionError`` where an expression is not defined or not real.
        """
        numbers = [values[name] for name in self.names]
        try:
            for operation, slots in self._steps:
                numbers.append(operation(*[numbers[s] for s in slots]))
        except (ZeroDivisionError, ValueError, OverflowError):
            raise DefinitionError(
                "the equations are not defined at this point (a division by zero or a function "
                "outside its domain); choose another point or other coordinates"
            ) from None
        return [_real(numbers[slot]) for slot in self._outputs]


def _operands_first(roots: Sequence[Any]) -> list[Any]:
    """Every subexpression once, after its operands."""
    order: dict[Any, None] = {}
    stack = [(root, False) for root in reversed(roots)]
    while stack:
        expr, ready = stack.pop()
        if expr in order:
            continue
        if ready:
            order[expr] = None
        else:
            stack.append((expr, True))
            operands = () if isinstance(expr, se.Symbol) else _step(expr)[1]
            stack.extend((a, False) for a in operands)
    return list(order)


def _step(expr: Any) -> tuple[Operation, Sequence[Any]]:
    """The operation at the root of an expression, and its operands."""
    if expr in _CONSTANTS:
        return _CONSTANTS[expr], ()
    if type(expr).__name__ in _CONDITIONS:
        return _CONDITIONS[type(expr).__name__], expr.args
    if isinstance(expr, se.Piecewise):
        return _first_case, expr.args
    if _is_level(expr):
        return (lambda: mp.mpf(0)), ()
    if isinstance(expr, se.Rational):  # an Integer is a Rational
        p, q = int(expr.p), int(expr.q)
        return (lambda: mp.mpf(p) / q), ()
    if isinstance(expr, se.Add):
        return _sum, expr.args
    if isinstance(expr, se.Mul):
        return _product, expr.args
    if isinstance(expr, se.Pow):
        return _power(*expr.args)
    function = _FUNCTIONS.get(numeric.numeric_name(expr) or type(expr).__name__)
    if function is not None:
        return function, expr.args
    raise DefinitionError(f"'{expr}' has no real value; write it with elementary functions")


def _first_case(*pairs: Any) -> Any:
    """Of values and conditions by turns, the value whose condition is the first that holds."""
    held = (value for value, holds in zip(pairs[::2], pairs[1::2], strict=True) if holds)
    return next(held, mp.nan)


def _is_level(expr: Any) -> bool:
    """Whether an expression is a derivative of a sign or a floor, which do not slope."""
    inner = expr.expr if isinstance(expr, se.Subs) else expr
    return isinstance(inner, se.Derivative) and isinstance(inner.args[0], (se.sign, se.floor))


def _sum(*terms: Any) -> Any:
    return mp.fsum(terms)


def _product(*factors: Any) -> Any:
    result = factors[0]
    for factor in factors[1:]:
        result = result * factor
    return result


def _power(base: Any, exponent: Any) -> tuple[Operation, Sequence[Any]]:
    if base == se.E:
        return mp.exp, (exponent,)
    if isinstance(exponent, se.Rational):
        p, q = int(exponent.p), int(exponent.q)
        if q == 1:
            return (lambda a: a**p), (base,)
        if q == 2:
            return (lambda a: mp.sqrt(a) ** p), (base,)
        return (lambda a: a ** (mp.mpf(p) / q)), (base,)
    return mp.power, (base, exponent)


def _real(number: Any) -> Any:
    if isinstance(number, mp.mpc) and number.imag == 0:
        number = number.real
    if not isinstance(number, mp.mpf) or not mp.isfinite(number):
        raise DefinitionError(
            "the equations have no real value at this point (a root or logarithm of a negative "
            "number, or an infinity); choose another point"
        )
    return number


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
        symbols, rates = [self.names.symbol(velocity(w)) for w in dots], {}
        if system.on_group:
            return {a: a for a in symbols}
        for v in system.velocities if system.frame is not None else ():
            meant = self.definitions[self.names.symbol(v)]
            parts = (meant.diff(w) * a for w, a in zip(self.v, symbols, strict=True))
            rates[self.names.symbol(velocity(v))] = se.Add(self.drift(meant), *parts)
        return {a: a for a in symbols} | rates


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
    # what is given in cases has no derivative in symengine, not even by a symbol it does not hold
    slopes = [f.diff(a) if a in f.free_symbols else se.Integer(0) for f in spelled for a in symbols]
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
    while moduli := expr.atoms(se.Abs):
        expr = expr.xreplace({node: se.sqrt(node.args[0] ** 2) for node in moduli})
    return expr
