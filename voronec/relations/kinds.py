"""What kind of relation it is: computed from its maps, never declared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from voronec.algebra.points import sample_evaluable
from voronec.algebra.rank import proved_rank
from voronec.algebra.tape import Tape
from voronec.algebra.verdicts import decide_equal
from voronec.errors import EngineLimit
from voronec.relations.statemap import StateMap

__all__ = ["generic_rank", "kinds_of", "state_rank"]

BITS = 256


def kinds_of(statemap: StateMap) -> tuple[str, ...]:
    """The words that apply, the most telling one first.

    limit
        it holds as a small parameter tends to zero.
    change of time
        the clock is not 1.
    specialisation
        the parameters of the source fill fewer dimensions than those of the target.
    automorphism
        it leads from a system to itself.
    reduction, embedding
        the state map forgets part of the source; does not fill the target.
    change of coordinates, equality
        states correspond one to one, under other names or the same ones.
    """
    words = []
    if statemap.small is not None:
        words.append("limit")
    if not decide_equal(statemap.clock, 1).proved:
        words.append("change of time")
    if statemap.small is None and _is_special(statemap):
        words.append("specialisation")
    if statemap.relation.source == statemap.relation.target:
        words.append("automorphism")
    rank = state_rank(statemap)
    if rank < statemap.source.dimension:
        words.append("reduction")
    if rank < statemap.target.dimension:
        words.append("embedding")
    if rank == statemap.source.dimension == statemap.target.dimension:
        if not statemap.is_identity:
            words.append("change of coordinates")
        elif not words:
            words.append("equality")
    return tuple(words)


def state_rank(statemap: StateMap) -> int:
    """The rank of the state map on states of the source."""
    source = statemap.source
    images = [statemap.state[x] for x in statemap.target.variables]
    gradients = [[f.diff(x) for x in source.variables] for f in images]
    bound = [[r.diff(x) for x in source.variables] for r in statemap.relations]
    return generic_rank([*bound, *gradients], statemap.relations) - len(bound)


def _is_special(statemap: StateMap) -> bool:
    parameters = statemap.source.parameters
    values = [v for p, v in statemap.parameters.items() if not p.args]
    if not values:
        return False
    rows = [[value.diff(p) for p in parameters] for value in values]
    return (generic_rank(rows, ()) if parameters else 0) < len(values)


def generic_rank(rows: Sequence[Sequence[Any]], relations: Sequence[Any]) -> int:
    """The rank at a generic point: the largest proved one among several."""
    width = len(rows[0]) if rows else 0
    entries = [e for row in rows for e in row]
    if not entries:
        return 0
    try:
        samples = sample_evaluable(Tape(entries), relations, BITS)
    except EngineLimit:
        return 0
    tables = ([v[i : i + width] for i in range(0, len(v), width)] for _, v in samples)
    return max((proved_rank(table, BITS) for table in tables), default=0)
