"""What may not jump: a Lagrangian, its momenta, constraints and definitions of velocities.

Where one does, velocities jump too, and the equations between the walls do not say how far.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import symengine as se

from voronec.algebra.verdicts import decide_zero
from voronec.equations.program.walls import plain_roots, radicands
from voronec.errors import DefinitionError, EngineLimit

__all__ = ["require_no_jump", "require_no_jump_of_lagrangian"]


def require_no_jump(place: Callable[[], str], expr: Any, conditions: Sequence[Any] = ()) -> None:
    """Raise ``DefinitionError`` where an expression is proved to jump at a state at which
    conditions hold; ``place`` says what it is."""
    for wall, jump in _jumps(expr):
        if _differs(jump, wall, conditions):
            raise DefinitionError(
                f"{place()} jumps where {wall} = 0, and velocities would with it; use a continuous "
                "one, or end the motion there and start another"
            )


def require_no_jump_of_lagrangian(
    place: str,
    lagrangian: Any,
    velocities: Sequence[Any],
    variables: Sequence[Any],
    conditions: Sequence[Any] = (),
) -> None:
    """The same of a Lagrangian, which may jump in time, and of its momenta, which may not.

    ``variables`` are the coordinates and velocities.
    """
    for wall, jump in _jumps(lagrangian):
        moving = bool(wall.free_symbols & {*variables})
        momenta = [jump.diff(v) for v in velocities]
        jumping = [*([jump] if moving else []), *momenta]
        if any(_differs(e, wall, conditions) for e in jumping):
            raise DefinitionError(
                f"{place}: the Lagrangian jumps where {wall} = 0, which is an impact; use a "
                "continuous one, or a force of finite size"
            )


def _jumps(expr: Any) -> Iterator[tuple[Any, Any]]:
    """Walls of an expression with what it differs by on their sides."""
    expr = se.sympify(expr)
    plain = plain_roots(expr) if radicands([expr], frozenset(expr.free_symbols)) else expr
    seen: set[Any] = set()
    stack = [plain]
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if isinstance(node, se.sign):
            sides = (plain.xreplace({node: se.Integer(s)}) for s in (1, -1))
            yield node.args[0], next(sides) - next(sides)
        elif isinstance(node, se.floor):
            above = plain.xreplace({node: node.args[0]})
            wall = se.sin(se.pi * node.args[0])
            yield wall, above - plain.xreplace({node: node.args[0] - 1})
        stack.extend(node.args)


def _differs(jump: Any, wall: Any, conditions: Sequence[Any]) -> bool:
    if jump == 0:
        return False
    relations = [] if wall.has(se.pi) and isinstance(wall, se.sin) else [wall]
    try:
        return bool(decide_zero(jump, [*relations, *conditions]).refuted)
    except EngineLimit:
        return False
