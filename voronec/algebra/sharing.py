"""Fewer operations in a straight-line program: shared parts of sums, common factors."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any

import symengine as se

from voronec.algebra.stages import ONE, coefficient, primitive, sorted_stages

__all__ = ["factored", "shared_sums"]

Bag = dict[Any, Any]
"""A sum as {term without number: number}."""
Pair = tuple[Any, Any, Any]
"""Two terms of a sum and the ratio of their numbers."""

WIDEST = 60
"""Sums with more terms than this are left alone."""


def _split(term: Any) -> tuple[Any, Any]:
    number = coefficient(term)
    return (ONE, number) if term.is_Number else (term / number, number)


def shared_sums(definitions: Mapping[Any, Any], fresh: Callable[[], Any]) -> dict[Any, Any]:
    """Name every pair of terms that several sums share, up to a factor, most shared first.

    Pairs of named pairs follow, so that longer common parts are found, too.
    """
    bags = {
        x: dict(map(_split, e.args))
        for x, e in definitions.items()
        if isinstance(e, se.Add) and len(e.args) <= WIDEST
    }
    keys: dict[Any, str] = {}
    where: dict[Pair, set[Any]] = defaultdict(set)
    for x, bag in bags.items():
        for pair in _pairs(bag, keys):
            where[pair].add(x)
    heap = [_entry(p, where, keys) for p, users in where.items() if len(users) > 1]
    heapq.heapify(heap)
    while heap:
        count, _, pair = heapq.heappop(heap)
        if len(where[pair]) < 2:
            continue
        if len(where[pair]) != -count:
            heapq.heappush(heap, _entry(pair, where, keys))
            continue
        first, second, ratio = pair
        name = fresh()
        for x in sorted(where[pair], key=str):
            before = _pairs(bags[x], keys)
            number = bags[x].pop(first)
            del bags[x][second]
            bags[x][name] = number
            after = _pairs(bags[x], keys)
            for p in before - after:
                where[p].discard(x)
            for p in after - before:
                where[p].add(x)
                if len(where[p]) > 1:
                    heapq.heappush(heap, _entry(p, where, keys))
        bags[name] = {first: ONE, second: ratio}
    sums = {x: se.Add(*[c * m for m, c in bag.items()]) for x, bag in bags.items()}
    return sorted_stages({**definitions, **sums})


def _pairs(bag: Bag, keys: dict[Any, str]) -> set[Pair]:
    for term in bag:
        if term not in keys:
            keys[term] = str(term)
    order = sorted(bag, key=keys.__getitem__)
    return {(a, b, bag[b] / bag[a]) for i, a in enumerate(order) for b in order[i + 1 :]}


def _entry(pair: Pair, where: Mapping[Pair, set[Any]], keys: Mapping[Any, str]) -> Any:
    first, second, ratio = pair
    return -len(where[pair]), (keys[first], keys[second], str(ratio)), pair


def factored(definitions: Mapping[Any, Any], fresh: Callable[[], Any]) -> dict[Any, Any]:
    """Write a*b + a*c as a*(b + c) in every sum, the factor that most terms share first."""
    names: dict[Any, Any] = {}
    result: dict[Any, Any] = {}

    def name(expr: Any) -> Any:
        if not isinstance(expr, se.Add):
            return expr
        number, expr = primitive(expr)
        if expr not in names:
            names[expr] = fresh()
            result[names[expr]] = expr
        return number * names[expr]

    for x, expr in definitions.items():
        result[x] = expr
        if isinstance(expr, se.Add):
            result[x] = _collected([(c, _powers(m)) for m, c in map(_split, expr.args)], name)
    return sorted_stages(result)


def _powers(term: Any) -> dict[Any, int]:
    """The factors of a term with their exponents; what has no whole positive exponent is one."""
    powers: dict[Any, int] = {}
    for f in term.args if isinstance(term, se.Mul) else (term,):
        if isinstance(f, se.Pow) and isinstance(f.args[1], se.Integer) and f.args[1] > 0:
            powers[f.args[0]] = int(f.args[1])
        elif f != 1:
            powers[f] = 1
    return powers


def _collected(terms: list[tuple[Any, dict[Any, int]]], name: Callable[[Any], Any]) -> Any:
    counts: dict[Any, int] = defaultdict(int)
    for _, powers in terms:
        for f in powers:
            counts[f] += 1
    most = max(counts, key=lambda f: (counts[f], str(f)), default=None)
    if most is None or counts[most] < 2:
        return se.Add(*[c * se.Mul(*[f**e for f, e in p.items()]) for c, p in terms])
    inside = []
    for c, powers in terms:
        if most in powers:
            inside.append((c, {f: e - (f == most) for f, e in powers.items() if e > (f == most)}))
    outside = [(c, powers) for c, powers in terms if most not in powers]
    head = most * name(_collected(inside, name))
    return head + _collected(outside, name) if outside else head
