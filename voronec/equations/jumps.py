"""Jumps of what velocities depend on: of a Lagrangian, its momenta, constraints and frames.

Where one jumps, velocities jump too, and the equations between the switching surfaces do not say
how far.  What is proved to jump is refused.  An angle of coordinates, as atan(1/(x - 2)), may be
meant on one side of its cut: the places of such cuts are kept, for runs to end there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.graphs import nodes
from voronec.algebra.normal import canonical
from voronec.algebra.roots import known_sign
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.terms import factors_of
from voronec.algebra.verdicts import decide_zero
from voronec.equations.program.switches import plain_roots, radicands, switch_factors
from voronec.errors import DefinitionError, EngineLimit


@dataclass(frozen=True)
class AngleCut:
    """Where an angle of coordinates in a ``place`` of a definition jumps: where the ``switching
    surface`` passes zero, and, if there is one, the ``side`` is negative."""

    place: str
    switch: Any
    side: Any = None

    def __str__(self) -> str:
        beside = "" if self.side is None else f" and {self.side} < 0"
        return f"{self.switch} = 0{beside}"


def angle_cuts(
    lagrangian: Any, forms: Iterable[tuple[str, Any]], coordinates: Sequence[Any],
    velocities: Sequence[Any], time: Any, conditions: Sequence[Any],
) -> tuple[AngleCut, ...]:  # fmt: skip
    """The cuts of angles of ``coordinates`` at which a Lagrangian is proved to jump by more than
    the rate of what is constant on either side, or one of ``forms``, named, or its derivative by a
    velocity, to jump at all, while conditions hold."""
    held = {*coordinates}
    cuts: dict[Any, AngleCut] = {}
    for place, expr in (("the Lagrangian", lagrangian), *forms):
        if not any(n.free_symbols & held for n in nodes([expr]) if isinstance(n, _ARCS)):
            continue
        for switch, jump, side in _jumps_of_angles(expr):
            kicks = [jump, *(jump.diff(v) for v in velocities)]
            if expr is lagrangian:
                kicks = _kicks(jump, switch, (*coordinates, time), velocities)
            if switch.free_symbols & held and any(_differs(e, switch, conditions) for e in kicks):
                cuts.setdefault((switch, side), AngleCut(place, switch, side))
    return tuple(cuts.values())


def _kicks(jump: Any, switch: Any, places: Sequence[Any], velocities: Sequence[Any]) -> list[Any]:
    """What is zero where a jump of a Lagrangian leaves the velocities alone: the jumps of momenta
    and of minus the energy are along the gradient of the switching surface, by coordinates and
    time, ``places``; so it is for the rate of a function that jumps by a constant."""
    momenta = [jump.diff(v) for v in velocities]
    momenta.append(jump - sum(p * v for p, v in zip(momenta, velocities, strict=True)))
    rows = zip(momenta, (switch.diff(q) for q in places), strict=True)
    return [p * m - o * n for (p, n), (o, m) in combinations(rows, 2)]


def require_no_jump(
    place: Callable[[], str], expr: Any, conditions: Sequence[Any], variables: Iterable[Any] = ()
) -> None:
    """Raise ``DefinitionError`` where an expression is proved to jump at a state at which
    conditions hold; ``place`` says what it is."""
    for switch, jump in _jumps(expr, variables):
        if _differs(jump, switch, conditions):
            raise DefinitionError(
                f"{place()} jumps where {switch} = 0, and velocities would with it; use a "
                "continuous one, or end the motion there and start another"
            )


def require_continuous(place: str, function: sp.Expr) -> None:
    """Raise ``DefinitionError`` where a function of the time is proved to jump."""
    bridge = SymPyBridge()
    inside = bridge.inward(function)
    require_no_jump(partial(str, place), inside, bridge.hypotheses)


def require_no_jump_of_lagrangian(
    place: str,
    lagrangian: Any,
    velocities: Sequence[Any],
    variables: Sequence[Any],
    conditions: Sequence[Any],
) -> None:
    """Raise ``DefinitionError`` where momenta jump, or a Lagrangian does but for jumps in time.

    ``variables`` are the coordinates and velocities.
    """
    for switch, jump in _jumps(lagrangian, variables):
        moving = bool(switch.free_symbols & {*variables})
        momenta = [jump.diff(v) for v in velocities]
        jumping = [*([jump] if moving else []), *momenta]
        if any(_differs(e, switch, conditions) for e in jumping):
            raise DefinitionError(
                f"{place}: the Lagrangian jumps where {switch} = 0, which is an impact; use a "
                "continuous one, or a force of finite size"
            )


def _jumps(expr: Any, variables: Iterable[Any] = ()) -> Iterator[tuple[Any, Any]]:
    """Switching surfaces of an expression with what it differs by on their sides.

    Angles of what holds ``variables`` are no switching surfaces: atan(y/x) is meant on one side of
    x = 0.  Time goes on, and passes the cuts of its own.
    """
    for switch, jump, side in _jumps_of_angles(expr, {*variables}):
        # atan2(y, x) = +-pi where y = 0 > x
        yield switch, jump if side is None else jump * (1 - se.sign(side))


def _jumps_of_angles(expr: Any, held: Set[Any] = frozenset()) -> Iterator[tuple[Any, Any, Any]]:
    """Switching surfaces of an expression, what it differs by on their sides, and what is negative
    where it does; None where that is all along the switching surface.  Angles of what is ``held``
    are left alone."""
    expr = se.sympify(expr)
    plain = plain_roots(expr) if radicands([expr], frozenset(expr.free_symbols)) else expr
    arcs = [n for n in nodes([plain]) if isinstance(n, _ARCS) and not n.free_symbols & held]
    plain = plain.xreplace({arc: plain_roots(arc) for arc in arcs})
    for node in nodes([plain]):
        if isinstance(node, se.sign):
            sides = (plain.xreplace({node: se.Integer(s)}) for s in (1, -1))
            jump = next(sides) - next(sides)
            yield from ((switch, jump, None) for switch in _changes_of_sign(node.args[0]))
        elif isinstance(node, se.floor):
            above = plain.xreplace({node: node.args[0]})
            switch = se.sin(se.pi * node.args[0])
            yield switch, above - plain.xreplace({node: node.args[0] - 1}), None
        elif isinstance(node, se.atan2) and not node.free_symbols & held:
            y, x = node.args
            # x sign(x) has the sign of x/x
            if known_sign(x.xreplace({n: 1 / n.args[0] for n in x.atoms(se.sign)})) > 0:
                continue
            jump = plain.xreplace({node: se.pi}) - plain.xreplace({node: -se.pi})
            yield from ((switch, jump, x) for switch in _changes_of_sign(y))


_ARCS = (se.asin, se.acos, se.atan, se.acot, se.atan2)


def _changes_of_sign(function: Any) -> Iterator[Any]:
    """The factors of a function where it changes its sign."""
    for factor in switch_factors(function) or factors_of(function):
        base, exponent = factor.args if isinstance(factor, se.Pow) else (factor, se.Integer(1))
        is_even = isinstance(exponent, se.Integer) and exponent % 2 == 0
        if base.free_symbols and not (is_even or isinstance(base, (se.Abs, se.sign))):
            yield base


def _differs(jump: Any, switch: Any, conditions: Sequence[Any]) -> bool:
    if jump == 0:
        return False
    relations = [] if switch.has(se.pi) and isinstance(switch, se.sin) else [switch]
    try:
        jump = canonical([jump])[0]  # 2 sin(u)/sin(u) is 2 beside u = 0
        return bool(decide_zero(jump, [*relations, *conditions]).refuted)
    except EngineLimit:
        return False
