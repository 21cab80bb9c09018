"""The pieces into which cuts divide a space: on each of them expressions are analytic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.branches import Branches, has_branches
from voronec.algebra.graphs import is_flat, nodes
from voronec.errors import EngineLimit

MOST_PIECES = 64
"""Into so many pieces a space is cut, at most."""


@dataclass(frozen=True)
class SpacePiece:
    """Expressions as they are on a piece of the space; ``sides`` are functions, each with the sign
    that it has there."""

    exprs: tuple[Any, ...]
    sides: tuple[tuple[Any, int], ...] = ()


def pieces_of(exprs: Sequence[Any], relations: tuple[Any, ...] = ()) -> list[SpacePiece]:
    """The pieces into which the cuts of expressions cut the space of all of their symbols.

    Raises ``EngineLimit`` where there are too many.  Places of which it is open whether they are
    cuts divide nothing.
    """
    symbols = frozenset[Any]().union(*(e.free_symbols for e in exprs))
    if not has_branches(exprs, symbols):
        return [SpacePiece(tuple(exprs))]
    steps = dict.fromkeys(filter(is_flat, nodes(exprs)), se.Integer(0))
    exprs = [e.xreplace(steps) for e in exprs]  # derivatives of signs vanish where they exist
    tags = [se.Dummy() for _ in exprs]
    whole = se.Add(*map(se.Mul, tags, exprs))
    waiting, pieces = [SpacePiece((whole,))], list[SpacePiece]()
    while waiting:
        piece = waiting.pop()
        branches = Branches(piece.exprs[0], symbols, relations, meets_poles=False)
        past = [h for h, _ in piece.sides]
        h = next((h for h in branches.cuts if h not in past), None)
        if h is not None:
            sides = ((1, branches.beyond(h, 1)), (-1, branches.beyond(h, -1)))
            waiting += [SpacePiece((e,), (*piece.sides, (h, s))) for s, e in sides]
        else:
            pieces.append(SpacePiece(tuple(branches.expr.diff(t) for t in tags), piece.sides))
        if len(waiting) + len(pieces) > MOST_PIECES:
            raise EngineLimit(f"its cuts divide the space into more than {MOST_PIECES} pieces")
    return pieces
