"""Relations of the catalogue for the attack on the prover, as they are declared, and changed.

They are rewritten, or a coefficient is changed, two values exchanged, a condition dropped, an order
raised.  The multipliers of both systems tell which of them hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from random import Random
from typing import Any

import mpmath as mp
import sympy as sp

import voronec as vo
from prover.catalogue import accelerations, coordinate_rates, states
from prover.identities import Letters, mutate
from prover.truth import Outside, Statement, number, slope
from voronec.declaration.catalogue import entries

APART = mp.mpf(10) ** -9
"""A residual is one beyond this, relatively; accelerations have 40 digits."""
SMALL = (mp.mpf(10) ** -4, mp.mpf(10) ** -6)
"""Values of a small parameter, at which the order of a residual is seen."""
HEAVY = ("bicycle", "robot-with-two-trailers")
"""Systems whose multipliers take long."""


@dataclass(frozen=True)
class Pair:
    """A relation with its two systems, both in coordinates that nothing binds."""

    relation: vo.Relation
    source: vo.System
    target: vo.System


@lru_cache
def declared_pairs() -> tuple[Pair, ...]:
    """The relations of the catalogue that coordinates and velocities can tell the truth of."""
    found = []
    for entry in entries()[0]:
        for relation in entry.load_relations()[0]:
            if relation.source in HEAVY or relation.target in HEAVY:
                continue
            pair = Pair(relation, vo.load(relation.source), vo.load(relation.target))
            if _is_plain(pair):
                found.append(pair)
    return tuple(found)


def _is_plain(pair: Pair) -> bool:
    for system in (pair.source, pair.target):
        if system.fibration.relations or system.on_group or system.inputs:
            return False
    named = {str(s) for s in pair.relation.state or ()}
    if pair.relation.state is None:
        return {*map(str, pair.target.coordinates)} <= {*map(str, pair.source.coordinates)}
    return {*map(str, pair.target.coordinates)} <= named


def catalogue_relation(dice: Random, family: str, declared: bool, true: bool) -> Statement | None:
    """A relation of the catalogue, rewritten; or one with a change that the numbers show."""
    pair = dice.choice(declared_pairs())
    relation = _rewrite(pair, dice) if true else _change(pair, dice)
    if relation is None or holds(replace(pair, relation=relation), dice) is not true:
        return None
    text = f"{relation.label}: state {_tell(relation.state)}, parameters "
    text += f"{_tell(relation.parameters)}, clock {relation.clock}, limit {relation.limit}"
    ask = lambda: vo.check_relation(relation, systems=(pair.source, pair.target)).verdict  # noqa: E731
    return Statement("catalogue relations", text, true, ask)


def _tell(values: Mapping[Any, Any] | None) -> str:
    return "as named" if values is None else str({str(k): v for k, v in values.items()})


# -- changes ------------------------------------------------------------------------------


def _rewrite(pair: Pair, dice: Random) -> vo.Relation:
    """One value of it in other words."""
    relation = pair.relation
    ones = [sp.Integer(1)]
    for p in pair.source.parameters[:3]:
        s = p.symbol
        ones += [sp.sin(s) ** 2 + sp.cos(s) ** 2, sp.sqrt(1 + s**2) ** 3 / sp.sqrt(1 + s**2) - s**2]
        ones += [sp.Abs(s) / s, sp.sqrt(s) * sp.sqrt(1 / s)] if p.positive else []
    return _with_value(relation, dice, lambda e: e * dice.choice(ones))


def _change(pair: Pair, dice: Random) -> vo.Relation | None:
    relation, kind = pair.relation, dice.randrange(5)
    letters = tuple(p.symbol for p in pair.source.parameters)
    own = Letters(dice, True, letters, letters + tuple(pair.source.coordinates))
    if kind == 0 and relation.limit is not None:
        return replace(relation, limit=replace(relation.limit, order=relation.limit.order + 1))
    if kind == 1:  # two values exchanged
        part = "state" if relation.state and dice.random() < 0.6 else "parameters"
        values = dict(getattr(relation, part))
        if len(values) < 2:
            return None
        one, other = dice.sample([*values], 2)
        values[one], values[other] = values[other], values[one]
        return _with_values(relation, part, values)
    if kind == 2:  # a value that the relation fixes is left free
        free = {
            n: v for n, v in relation.parameters.items() if not _names(v) & {*map(str, letters)}
        }
        if not free or not letters:
            return None
        return replace(relation, parameters={**relation.parameters, dice.choice([*free]):
                                             dice.choice(letters)})  # fmt: skip
    if kind == 3:
        factor = dice.choice((-1, 2, sp.Rational(1001, 1000)))
        return replace(relation, clock=relation.clock * factor)
    return _with_value(relation, dice, lambda e: mutate(own, e))


def _with_values(relation: vo.Relation, part: str, values: Mapping[Any, Any]) -> vo.Relation:
    if part == "state":
        return replace(relation, state=values)
    return replace(relation, parameters=values)


def _names(expr: Any) -> set[str]:
    return {str(s) for s in sp.sympify(expr).free_symbols}


def _with_value(relation: vo.Relation, dice: Random, change: Any) -> vo.Relation:
    """One value of the state, of the parameters or the clock changed."""
    places = [("state", k) for k in relation.state or ()]
    places += [("parameters", k) for k in relation.parameters] + [("clock", None)]
    part, key = dice.choice(places)
    if key is None:
        return replace(relation, clock=change(relation.clock))
    values = dict(getattr(relation, part))
    values[key] = change(values[key])
    return _with_values(relation, part, values)


# -- truth --------------------------------------------------------------------------------


def holds(pair: Pair, dice: Random) -> bool | None:
    """Whether images of motions are motions, at random states; None where that is not seen."""
    found = []
    for at in states(pair.source, dice):
        try:
            found.append(_holds_at(pair, at))
        except (Outside, ZeroDivisionError, vo.VoronecError, TypeError, ValueError, KeyError):
            continue
        if found[-1] is False:
            return False
    return True if True in found and None not in found else None


def _holds_at(pair: Pair, at: Mapping[Any, Any]) -> bool | None:
    limit = pair.relation.limit
    if limit is None:
        return _verdict(pair, [_residual(pair, at)], 0)
    sizes = []
    for small in SMALL:
        known = {str(k): v for k, v in limit.parameters.items()}
        value = sp.Rational(str(small))
        moved = dict(at)
        for p in pair.source.parameters:
            if str(p.symbol) in known:
                scale = sp.sympify(known[str(p.symbol)])
                named = {s: at[t] for s in scale.free_symbols for t in at if str(s) == str(t)}
                moved[p.symbol] = scale.subs({**named, limit.small: value})
        if not all(sp.sympify(v).is_Rational for v in moved.values()):
            return None
        sizes.append(_residual(pair, moved))
    return _verdict(pair, sizes, limit.order)


def _verdict(pair: Pair, sizes: list[tuple[Any, Any]], order: int) -> bool | None:
    """What residuals in coordinates, and in invariants where the target has some, say together."""
    bounded = [_vanishes([s[level] for s in sizes], order) for level in (0, 1)]
    if pair.target.invariants and pair.relation.state is None:
        return bounded[0] if bounded[0] == bounded[1] else None
    return bounded[0]


def _vanishes(sizes: list[Any], order: int) -> bool | None:
    if not order:
        return bool(sizes[0] < APART)
    ratios = [s / e**order for s, e in zip(sizes, SMALL, strict=True)]
    if ratios[1] < 3 * ratios[0] + APART:
        return True
    return False if ratios[1] > 20 * ratios[0] else None


def _residual(pair: Pair, at: Mapping[Any, Any]) -> tuple[Any, Any]:
    """The largest difference of DPhi f and nu g(Phi), of coordinates with velocities, and of the
    invariants."""
    source, target = pair.source, pair.target
    with mp.workdps(60):
        exact = {s: mp.mpf(int(v.p)) / int(v.q) for s, v in map(_exact, at.items())}
        exact.setdefault(vo.time, mp.mpf(37) / 97)
        flow = _flow(source, exact)
        image, frame = _image(pair), _velocities(target)
        values = {s: number(e, flow[0]) for s, e in image.items()}
        clock = number(_in_dots(source, pair.relation.clock), flow[0])
        there = _flow(target, values)
        sizes = []
        for name, e in image.items():
            if name in target.coordinates or name in target.velocities:
                rate = _rate(e, flow)
                meaning = frame.get(name, name)
                sizes.append(_apart(rate, clock * _rate(meaning, there)))
        held = [*target.invariants.values()]
        named = pair.relation.state is None
        own = {str(k): e for k, e in source.invariants.items()} if named else {}
        for n, e in zip(target.invariants, held, strict=True):  # by the same names
            if str(n) in own and _apart(number(own[str(n)], flow[0]), number(e, there[0])) > APART:
                raise Outside
        seen = [
            _apart(_rate(own[str(n)], flow), clock * _rate(e, there))
            for n, e in zip(target.invariants, held, strict=True)
            if str(n) in own
        ]
    return max(sizes), max(seen, default=mp.mpf(0))


def _exact(pair: tuple[Any, Any]) -> tuple[Any, Any]:
    return pair[0], sp.Rational(pair[1])


def _apart(a: Any, b: Any) -> Any:
    return abs(a - b) / (1 + abs(a) + abs(b))


def _rate(expr: Any, flow: tuple[Mapping[Any, Any], Mapping[Any, Any]]) -> Any:
    """The derivative of an expression along a flow."""
    return slope(expr, *flow)


def _flow(system: vo.System, at: Mapping[Any, Any]) -> tuple[dict[Any, Any], dict[Any, Any]]:
    """A state with coordinate velocities, and the rates of all of it, by the multipliers."""
    full = {**at, **coordinate_rates(system, at)}
    second = accelerations(system, at)
    rates = {vo.velocity(s): second[s] for s in system.coordinates}
    rates |= {s: full[vo.velocity(s)] for s in system.coordinates}
    return full, {**rates, vo.time: mp.mpf(1)}


def _velocities(system: vo.System) -> dict[Any, Any]:
    """The velocities of the equations in terms of coordinate velocities."""
    frame = system.frame.expressions if system.frame is not None else ()
    return dict(zip(system.velocities, frame, strict=False))


def _in_dots(system: vo.System, expr: Any) -> Any:
    """An expression of the source without quasi-velocities."""
    return sp.sympify(expr).xreplace(_velocities(system))


def _image(pair: Pair) -> dict[Any, Any]:
    """Variables and parameters of the target as functions of the source's."""
    source, target, relation = pair.source, pair.target, pair.relation
    given = {str(k): v for k, v in (relation.state or {}).items()}
    found: dict[Any, Any] = {}
    for q in target.coordinates:
        found[q] = _in_dots(source, _value_of(given, source, str(q)))
    clock = _in_dots(source, relation.clock)
    dots = {vo.velocity(q): _derivative(source, e) / clock for q, e in found.items()}
    frame = _velocities(target)
    parameters = {str(k): v for k, v in relation.parameters.items()}
    for p in target.parameters:
        found[p.symbol] = _in_dots(source, _value_of(parameters, source, str(p.symbol)))
    for v in target.velocities:
        meaning = sp.sympify(frame.get(v, v))
        derived = meaning.xreplace({**found, **dots})
        if str(v) not in given and relation.state is None:
            derived = _symbol_of(source, str(v))
        found[v] = _in_dots(source, given.get(str(v), derived))
    found[vo.time] = vo.time / clock if clock.is_Number else sp.Integer(0)
    return found


def _value_of(values: Mapping[str, Any], source: vo.System, name: str) -> Any:
    """What a relation says of a name; else what bears it in the source."""
    return values[name] if name in values else _symbol_of(source, name)


def _symbol_of(system: vo.System, name: str) -> Any:
    known = [*system.coordinates, *system.velocities, *(p.symbol for p in system.parameters)]
    found = {str(s): s for s in known}
    return found[name]


def _derivative(system: vo.System, expr: Any) -> Any:
    """d/dt of a function of coordinates and the time, in coordinate velocities."""
    return sum(
        (sp.diff(expr, s) * vo.velocity(s) for s in system.coordinates), sp.diff(expr, vo.time)
    )
