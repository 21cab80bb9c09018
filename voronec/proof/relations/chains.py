"""Chains of relations composed, and squares of two chains decided."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import starmap
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.conditions import moved_hypotheses, split_hypotheses
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import Verdict, decide_equal
from voronec.declaration.relation import Relation, Square
from voronec.equations.motions import Motions
from voronec.equations.vector_field import VectorField
from voronec.errors import DefinitionError, EngineLimit
from voronec.proof.branch_cuts import positive_domain
from voronec.proof.relations.decision import complete_velocities, decided_at_limit
from voronec.proof.relations.families import Course, carry_back
from voronec.proof.relations.functions import Functions, formal, substitute
from voronec.proof.relations.orders import all_at_zero, at_zero
from voronec.proof.relations.parameters import applications
from voronec.proof.relations.statemap import StateMap

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

    ``hypotheses`` hold on the start's states.  ``small`` is the small parameter of a single
    limit, not yet taken, and ``scaling`` the parameters that it moves.  ``family`` tells how those
    of the start depend on small ones, in the limits that have been taken, in their order.
    """

    start: VectorField
    end: VectorField
    state: dict[Any, Any]
    parameters: dict[Any, Any]
    clock: Any
    hypotheses: tuple[Any, ...]
    limits: tuple[str, ...] = ()
    family: tuple[tuple[Any, dict[Any, Any]], ...] = ()
    small: Any = None
    scaling: dict[Any, Any] = field(default_factory=dict)

    def map(self, change: Callable[[Any], Any]) -> _Chain:
        """The chain with a change of every expression, as a limit of parameters."""
        return replace(
            self,
            state={x: change(e) for x, e in self.state.items()},
            parameters={p: change(e) for p, e in self.parameters.items()},
            clock=change(self.clock),
        )

    def within(self, small: Any, scaled: dict[Any, Any]) -> _Chain:
        """The limit where parameters of the start depend on a small one, which vanishes."""
        rules = moved_hypotheses(self.hypotheses, scaled)
        limit = self.map(lambda e: at_zero(e.xreplace(scaled), rules, small))
        return replace(limit, hypotheses=all_at_zero(rules, small))


def check_square(square: Square, relations: Mapping[str, Relation], motions: Find) -> CheckedSquare:
    """Decide whether two chains of relations agree: states, parameters and clocks.

    ``relations`` by their labels; ``motions`` gives the motions of a system by its name.  An empty
    chain is the identity.  A limit in a chain is carried back to parameters of the start of the
    chain, and taken on all of the chain up to it; so limits are taken one by one, in its order.
    Where a limit of one chain moves parameters, the other is taken in that limit as well.
    Raises ``DefinitionError`` where a chain fixes a parameter that its limit moves.
    """
    first = _chain([*square.first, *filter(None, [square.up_to])], relations, motions)
    if square.second:
        second = _chain(square.second, relations, motions)
    else:
        second = _identity(first.start)
    _check_ends(square, first, second)
    first, second = _from_one_start(first, second, motions)
    first, second = _to_one_end(first, second, motions)
    limits = (first.limits, second.limits)
    _check_limits(square, relations)
    for small, scaled in (*first.family, *second.family):
        first, second = first.within(small, scaled), second.within(small, scaled)
    return CheckedSquare(square, limits, _agreement(first, second))


def _check_limits(square: Square, relations: Mapping[str, Relation]) -> None:
    chains = (square.first, square.second)
    first, second = (Course.of(relations[n] for n in labels) for labels in chains)
    if first is not None and second is not None and not first.is_compatible(second):
        raise EngineLimit("the limits of the two chains move a parameter to different values")


def _agreement(first: _Chain, second: _Chain) -> Verdict:
    for part in ("state", "parameters"):
        ours, theirs = getattr(first, part), getattr(second, part)
        for x, image in ours.items():
            verdict = decide_equal(image, theirs[x], first.hypotheses)
            if not verdict.proved and not x.is_Symbol:
                verdict = _compare_functions(x, first, second) or verdict
            if not verdict.proved:
                return Verdict(verdict.status, f"'{x}': {verdict.method}", verdict.witness)
    verdict = decide_equal(first.clock, second.clock, first.hypotheses)
    images = [e for c in (first, second) for e in (*c.state.values(), *c.parameters.values())]
    images += [first.clock, second.clock]
    return verdict.where(*positive_domain(first.start, images, first.hypotheses))


def _compare_functions(function: Any, first: _Chain, second: _Chain) -> Verdict | None:
    """Whether values of an unknown function that hold state agree where the end takes it."""
    values = [chain.parameters[function] for chain in (first, second)]
    known = {*function.args, *first.start.parameters}
    places = applications(first.end)[function.get_name()]
    if len(places) > 1 or all(v.free_symbols <= known for v in values):
        return None
    images = [substitute(a, first.state) for a in places[0].args]
    at = dict(zip(function.args, images, strict=True))
    left, right = (substitute(v, at) for v in values)
    return decide_equal(left, right, first.hypotheses)


def _chain(labels: Sequence[str], relations: Mapping[str, Relation], motions: Find) -> _Chain:
    """The composite of several relations.

    Where one begins at coordinates that a relation of equal names before it does not reach, since
    it was proved on invariants, that is read on coordinates, if it is proved there as well.
    """
    try:
        return _compose(labels, [StateMap.of(relations[n], motions) for n in labels], motions)
    except _Gap as gap:
        maps = [StateMap.of(relations[n], motions, "coordinates") for n in labels]
        for statemap in maps:
            if (
                statemap.relation.state is None
                and not decided_at_limit(complete_velocities(statemap))[1].proved
            ):
                raise gap from None
        return _compose(labels, maps, motions)


class _Gap(EngineLimit):
    """A chain that comes to invariants, and goes on from coordinates."""


def _compose(labels: Sequence[str], maps: Sequence[StateMap], motions: Find) -> _Chain:
    """Maps one after the other, levels fitted by descent where needed."""
    chain = _identity(maps[0].source)
    for label, statemap in zip(labels, maps, strict=True):
        link = _link(complete_velocities(statemap))
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
    return chain


def _link(statemap: StateMap) -> _Chain:
    """One relation, its limit not yet taken; its small parameter bears a name of its own."""
    chain = replace(
        _identity(statemap.source),
        end=statemap.target,
        state=statemap.state,
        parameters=statemap.parameters,
        clock=statemap.clock,
    )
    if statemap.small is None:
        return chain
    small = se.Symbol(f"small {statemap.small}")
    named = {statemap.small: small}
    return replace(
        chain.map(lambda e: e.xreplace(named)),
        limits=(f"{statemap.relation.label}: {statemap.small} -> 0",),
        small=small,
        scaling={p: e.xreplace(named) for p, e in statemap.scaling.items()},
    )


def _identity(start: VectorField) -> _Chain:
    state = {x: x for x in (*start.variables, start.time)}
    parameters = {p: p for p in start.parameters}
    parameters |= {f: f for f in starmap(formal, applications(start).items())}
    return _Chain(start, start, state, parameters, se.Integer(1), tuple(start.hypotheses))


def _descent(motions: Motions) -> _Chain:
    """From the coordinates of a system to its invariants."""
    high, low = motions.on_coordinates, motions.on_invariants
    state = {x: high.express(x) for x in low.variables} | {low.time: high.time}
    return replace(_identity(high), end=low, state=state)


def _then(first: _Chain, second: _Chain) -> _Chain:
    """``second`` after ``first``; where it is a limit, that is taken on the whole.

    Parameters in ``second`` are those before its own limit, which it has put in already.
    """
    small, family = second.small, first.family
    moving = {} if small is None else _limit_parameters(first, second)
    functions = Functions(first.parameters)
    moved = {x: e.xreplace(moving) for x, e in first.state.items()}
    mapping = {**moved, **functions.plain}
    chain = second.map(lambda e: functions.replace(e, mapping))
    rules = moved_hypotheses(first.hypotheses, moving)
    chain = replace(
        chain,
        start=first.start,
        clock=first.clock.xreplace(moving) * chain.clock,
        hypotheses=rules,
        limits=first.limits + second.limits,
        family=family if small is None else (*family, (small, moving)),
        small=None,
        scaling={},
    )
    return chain if small is None else chain.within(small, {})


def _limit_parameters(first: _Chain, second: _Chain) -> dict[Any, Any]:
    """The parameters of the start of ``first`` for which those of its end follow a limit."""
    small = sp.Symbol(str(second.small))
    values = {str(p): as_expression(e) for p, e in first.parameters.items() if p.is_Symbol}
    scaled = {str(p): as_expression(e) for p, e in second.scaling.items()}
    symbols = {str(p): p for p in first.start.parameters}
    ranges = (
        c
        for c in split_hypotheses(first.hypotheses)[1]
        if {*map(str, c.free_symbols)} <= symbols.keys()
    )
    family = carry_back(values, scaled, small, [as_expression(c) for c in ranges])
    if family is None or not symbols.keys() >= family.keys():
        raise DefinitionError(
            f"the chain that comes to '{second.start.system.name}' fixes a parameter that the "
            f"limit '{second.limits[0]}' moves; leave it out"
        )
    return {symbols[name]: se.sympify(value) for name, value in family.items()}


def _check_ends(square: Square, first: _Chain, second: _Chain) -> None:
    ends = [(c.start.system.name, c.end.system.name) for c in (first, second)]
    if ends[0] != ends[1]:
        raise DefinitionError(
            f"square '{square.label}': one chain leads from '{ends[0][0]}' to '{ends[0][1]}', the "
            f"other from '{ends[1][0]}' to '{ends[1][1]}'"
        )


def _from_one_start(first: _Chain, second: _Chain, motions: Find) -> tuple[_Chain, _Chain]:
    """Both chains from the same variables: from coordinates where one of them needs these."""
    if first.start.level == second.start.level:
        return first, second
    down = _descent(motions(first.start.system.name))
    fitted = [c if c.start.level == "coordinates" else _then(down, c) for c in (first, second)]
    return fitted[0], fitted[1]


def _to_one_end(first: _Chain, second: _Chain, motions: Find) -> tuple[_Chain, _Chain]:
    """Both chains to the same variables: to invariants where one of them comes to these."""
    if first.end.level == second.end.level:
        return first, second
    down = _descent(motions(first.end.system.name))
    fitted = [c if c.end.level == "invariants" else _then(c, down) for c in (first, second)]
    return fitted[0], fitted[1]
