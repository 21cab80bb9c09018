"""Chains of relations composed, and squares of two chains decided."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import symengine as se

from voronec.algebra.verdicts import Verdict, decide_equal
from voronec.errors import DefinitionError, EngineLimit
from voronec.relations.checking import completed, decided_at_limit
from voronec.relations.declaration import Relation, Square
from voronec.relations.functions import Functions
from voronec.relations.orders import at_zero
from voronec.relations.statemap import StateMap
from voronec.vector_field import Motions, VectorField

__all__ = ["CheckedSquare", "check_square"]

Find = Callable[[str], Motions]


@dataclass(frozen=True)
class CheckedSquare:
    """A square with its verdict; ``limits`` gives the limits of each chain in their order."""

    square: Square
    limits: tuple[tuple[str, ...], tuple[str, ...]]
    verdict: Verdict


@dataclass(frozen=True)
class _Chain:
    """Several maps one after the other: the end's variables and parameters by the start's.

    ``family`` tells how parameters of the start depend on small ones, in its limits.
    """

    start: VectorField
    end: VectorField
    state: dict[Any, Any]
    parameters: dict[Any, Any]
    clock: Any
    limits: tuple[str, ...]
    family: tuple[tuple[Any, dict[Any, Any]], ...] = ()


def check_square(square: Square, relations: Mapping[str, Relation], motions: Find) -> CheckedSquare:
    """Decide whether two chains of relations agree: states, parameters and clocks.

    ``relations`` by their labels; ``motions`` gives the motions of a system by its name.  An empty
    chain is the identity.  A chain that goes through a limit stands for its limit, and its limits
    are taken one by one, in its order.
    """
    first = _chain([*square.first, *filter(None, [square.up_to])], relations, motions)
    if square.second:
        second = _chain(square.second, relations, motions)
    else:
        second = _identity(first.start)
    _check_ends(square, first, second)
    start, (first, second) = _from_one_start(first, second, motions)
    first, second = _to_one_end(first, second, motions)
    limits = (first.limits, second.limits)
    first, second = _within(first, second.family), _within(second, first.family)
    return CheckedSquare(square, limits, _agreement(start, first, second))


def _agreement(start: VectorField, first: _Chain, second: _Chain) -> Verdict:
    for part in ("state", "parameters"):
        ours, theirs = getattr(first, part), getattr(second, part)
        for x, image in ours.items():
            verdict = decide_equal(image, theirs[x], start.relations)
            if not verdict.proved:
                return Verdict(verdict.status, f"'{x}': {verdict.method}", verdict.witness)
    return decide_equal(first.clock, second.clock, start.relations)


def _chain(labels: Sequence[str], relations: Mapping[str, Relation], motions: Find) -> _Chain:
    """The composite of several relations.

    Where one begins at coordinates that a relation of equal names before it does not reach, since
    it was proved on invariants, that is read on coordinates, if it is proved there as well.
    """
    try:
        return _composed(labels, [StateMap.of(relations[n], motions) for n in labels], motions)
    except _Gap as gap:
        maps = [StateMap.of(relations[n], motions, "coordinates") for n in labels]
        for found in maps:
            if found.relation.state is None and not decided_at_limit(completed(found))[1].proved:
                raise gap from None
        return _composed(labels, maps, motions)


class _Gap(EngineLimit):
    """A chain that comes to invariants, and goes on from coordinates."""


def _composed(labels: Sequence[str], maps: Sequence[StateMap], motions: Find) -> _Chain:
    """Maps one after the other, levels fitted by descent where needed."""
    chain: _Chain | None = None
    for label, found in zip(labels, maps, strict=True):
        link = _at_limit(completed(found))
        if chain is None:
            chain = link
            continue
        if chain.end.system.name != link.start.system.name:
            raise DefinitionError(
                f"the chain {', '.join(labels)} breaks: it comes to '{chain.end.system.name}', and "
                f"'{label}' begins at '{link.start.system.name}'"
            )
        if chain.end.level == "coordinates" and link.start.level == "invariants":
            chain = _then(chain, _descent(motions(chain.end.system.name)))
        elif chain.end.level != link.start.level:
            raise _Gap(
                f"'{label}' is a map of coordinates, and the chain before it knows the invariants "
                f"of '{chain.end.system.name}' only"
            )
        chain = _then(chain, link)
    assert chain is not None
    return chain


def _at_limit(statemap: StateMap) -> _Chain:
    """One relation; where it is a limit, at the limit."""
    rules, small = statemap.relations, statemap.small
    label = () if small is None else (f"{statemap.relation.label}: {small} -> 0",)
    family = () if small is None else ((small, statemap.scaled),)
    return _Chain(
        start=statemap.source,
        end=statemap.target,
        state={x: at_zero(e, rules, small) for x, e in statemap.state.items()},
        parameters={p: at_zero(e, (), small) for p, e in statemap.parameters.items()},
        clock=at_zero(statemap.clock, rules, small),
        limits=label,
        family=family,
    )


def _identity(field: VectorField) -> _Chain:
    state = {x: x for x in (*field.variables, field.time)}
    return _Chain(field, field, state, {p: p for p in field.parameters}, se.Integer(1), ())


def _descent(motions: Motions) -> _Chain:
    """From the coordinates of a system to its invariants."""
    high, low = motions.on_coordinates, motions.on_invariants
    state = {x: high.express(x) for x in low.variables} | {low.time: high.time}
    return _Chain(high, low, state, {p: p for p in high.parameters}, se.Integer(1), ())


def _then(first: _Chain, second: _Chain) -> _Chain:
    """``second`` after ``first``."""
    functions = Functions(first.parameters)
    mapping = {**first.state, **functions.plain}

    def through(expr: Any) -> Any:
        return functions.replaced(expr, mapping)

    return _Chain(
        start=first.start,
        end=second.end,
        state={x: through(e) for x, e in second.state.items()},
        parameters={p: through(e) for p, e in second.parameters.items()},
        clock=first.clock * through(second.clock),
        limits=first.limits + second.limits,
        family=first.family,
    )


def _within(chain: _Chain, family: Sequence[tuple[Any, dict[Any, Any]]]) -> _Chain:
    """A chain where the parameters of its start go to a limit that the other chain begins with.

    It may come to that limit later, or by way of other parameters, and still hold these.
    """
    rules = chain.start.relations
    for small, scaled in family:
        if chain.family:  # it begins with limits of its own: these are taken one by one
            continue
        chain = replace(
            chain,
            state={x: at_zero(e.xreplace(scaled), rules, small) for x, e in chain.state.items()},
            parameters={
                p: at_zero(e.xreplace(scaled), rules, small) for p, e in chain.parameters.items()
            },
            clock=at_zero(chain.clock.xreplace(scaled), rules, small),
        )
    return chain


def _check_ends(square: Square, first: _Chain, second: _Chain) -> None:
    ends = [(c.start.system.name, c.end.system.name) for c in (first, second)]
    if ends[0] != ends[1]:
        raise DefinitionError(
            f"square '{square.label}': one chain leads from '{ends[0][0]}' to '{ends[0][1]}', the "
            f"other from '{ends[1][0]}' to '{ends[1][1]}'"
        )


def _from_one_start(
    first: _Chain, second: _Chain, motions: Find
) -> tuple[VectorField, list[_Chain]]:
    """Both chains from the same variables: from coordinates where one of them needs these."""
    chains = [first, second]
    if first.start.level != second.start.level:
        down = _descent(motions(first.start.system.name))
        chains = [c if c.start.level == "coordinates" else _then(down, c) for c in chains]
    return chains[0].start, chains


def _to_one_end(first: _Chain, second: _Chain, motions: Find) -> tuple[_Chain, _Chain]:
    """Both chains to the same variables: to invariants where one of them comes to these."""
    if first.end.level == second.end.level:
        return first, second
    down = _descent(motions(first.end.system.name))
    fitted = [c if c.end.level == "invariants" else _then(c, down) for c in (first, second)]
    return fitted[0], fitted[1]
