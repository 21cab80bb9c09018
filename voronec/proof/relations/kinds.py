"""What kind of relation it is: computed from its maps, never declared."""

from __future__ import annotations

from collections.abc import Iterator

from voronec.algebra.rank import generic_rank
from voronec.algebra.verdicts import decide_equal
from voronec.errors import EngineLimit
from voronec.proof.relations.statemap import StateMap

__all__ = ["kinds_of", "state_rank"]


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
    is_limit = statemap.relation.limit is not None
    if is_limit:
        words.append("limit")
    if not decide_equal(statemap.clock, 1, statemap.hypotheses).proved:
        words.append("change of time")
    if not is_limit and _is_special(statemap):
        words.append("specialisation")
    if statemap.relation.source == statemap.relation.target:
        words.append("automorphism")
    try:
        return (*words, *_by_rank(statemap, bool(words)))
    except EngineLimit:  # no point was found: nothing is said about ranks
        return tuple(words)


def _by_rank(statemap: StateMap, is_named: bool) -> Iterator[str]:
    rank, sizes = state_rank(statemap), (statemap.source.dimension, statemap.target.dimension)
    if rank < sizes[0]:
        yield "reduction"
    if rank < sizes[1]:
        yield "embedding"
    if sizes == (rank, rank):
        if not statemap.is_identity:
            yield "change of coordinates"
        elif not is_named:
            yield "equality"


def state_rank(statemap: StateMap) -> int:
    """The rank of the state map on states of the source.

    Raises ``EngineLimit`` where no point is found.
    """
    source = statemap.source
    images = [statemap.state[x] for x in statemap.target.variables]
    gradients = [[f.diff(x) for x in source.variables] for f in images]
    kept = [statemap.scale(r) for r in source.independent_relations]
    bound = [[r.diff(x) for x in source.variables] for r in kept]
    return generic_rank([*bound, *gradients], statemap.hypotheses) - len(bound)


def _is_special(statemap: StateMap) -> bool:
    parameters = statemap.source.parameters
    values = [v for p, v in statemap.parameters.items() if not p.args]
    if not values:
        return False
    rows = [[value.diff(p) for p in parameters] for value in values]
    try:
        return (generic_rank(rows, ()) if parameters else 0) < len(values)
    except EngineLimit:
        return False
