"""Fewer operations by two identities: shared factors before brackets, and shared pairs named.

A sum takes the factor that most of its terms share before a bracket, and so on inside:
a*b*c + a*b*d is a*b*(c + d).  The pair of parts that most entries of a table hold becomes an entry
of its own, and so on with what is left [KuipersUedaVermaseren2015].
"""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, MutableMapping, Set
from functools import lru_cache
from typing import Any

import symengine as se

from voronec.algebra.terms import factors_of

Choice = Callable[..., Any]
"""``min`` or ``max``: which of several factors that are as frequent stands before a bracket."""
Pair = tuple[Any, Any, Any]
"""Two parts, and the exponent or the number of the second where that of the first is 1."""
DEEPEST = 60
"""So many factors are taken out one inside the other: a power series nests as deep as it goes."""
_text = lru_cache(2**16)(str)


def nest_sums(expr: Any, constants: Iterable[Any], choice: Choice = min) -> Any:
    """An expression whose sums take the factor that most of their terms share before a bracket,
    and so on inside; ``constants`` are no such factors, ``choice`` is made by name."""
    return _nest(se.sympify(expr), set(constants), choice, {})


def _nest(expr: Any, still: set[Any], choice: Choice, memo: dict[Any, Any]) -> Any:
    if not expr.args or expr.is_Number:
        return expr
    done = memo.get(expr)
    if done is None:
        args = [_nest(a, still, choice, memo) for a in expr.args]
        if isinstance(expr, se.Add):
            done = bracket([*map(factor_exponents, args)], still, choice)
        else:
            done = expr.func(*args)
        memo[expr] = done
    return done


def factor_exponents(term: Any) -> dict[Any, int]:
    """A term as {factor: exponent}; numbers and odd powers are factors of their own."""
    exponents: dict[Any, int] = {}
    for factor in factors_of(term):
        base, exponent = factor, 1
        if isinstance(factor, se.Pow) and isinstance(factor.args[1], se.Integer):
            base, exponent = factor.args[0], int(factor.args[1])
        exponents[base] = exponents.get(base, 0) + exponent
    return exponents


def bracket(
    terms: list[dict[Any, int]], still: Set[Any], choice: Choice,
    name: Callable[[Any], Any] = se.sympify, depth: int = 0,
) -> Any:  # fmt: skip
    """The sum of terms, as ``factor_exponents`` has them, factors that they share before brackets,
    the most frequent first; what stands in a bracket is what ``name`` makes of it."""

    def parts(term: dict[Any, int]) -> list[tuple[Any, int]]:
        moving = (b for b in term if not (b.is_Number or b.free_symbols <= still))
        return [(base, 1 if term[base] > 0 else -1) for base in moving]

    counts = Counter(part for term in terms for part in parts(term))
    heads = []
    while depth < DEEPEST and (frequent := max(counts.values(), default=0)) > 1:
        base, sign = choice((k for k, n in counts.items() if n == frequent), key=str)
        inside = [term for term in terms if term.get(base, 0) * sign > 0]
        terms = [term for term in terms if term.get(base, 0) * sign <= 0]
        counts.subtract(part for term in inside for part in parts(term))
        rest = [
            {b: e - sign * (b == base) for b, e in term.items() if e != sign or b != base}
            for term in inside
        ]
        factor = base if sign > 0 else 1 / base
        heads.append(factor * name(bracket(rest, still, choice, name, depth + 1)))
    products = (se.Mul(*[se.Pow(b, e) for b, e in term.items()]) for term in terms)
    return se.Add(*heads, *products)


def share_pairs(
    table: MutableMapping[Any, dict[Any, Any]],
    pairs: Callable[[Mapping[Any, Any]], set[Pair]],
    define: Callable[[Pair], tuple[Mapping[Any, Any], Any]],
    put: Callable[[Mapping[Any, Any], Mapping[Any, Any], Any], dict[Any, Any]],
) -> None:
    """Name pairs of parts that several entries of a table hold, most first.

    ``pairs`` are those of an entry, ``define`` makes a pair an entry of its own and returns it with
    its name, and ``put`` is an entry with the name in the place of the pair.
    """
    where: dict[Pair, set[Any]] = defaultdict(set)
    for x, parts in table.items():
        for pair in pairs(parts):
            where[pair].add(x)
    heap = [(-len(users), str(pair), pair) for pair, users in where.items() if len(users) > 1]
    heapq.heapify(heap)
    while heap:
        often, text, pair = heapq.heappop(heap)
        if -often != len(where[pair]):
            if len(where[pair]) > 1:
                heapq.heappush(heap, (-len(where[pair]), text, pair))
            continue
        inner, name = define(pair)
        for x in sorted(where[pair] - {name}, key=_text):
            before = pairs(table[x])
            table[x] = put(table[x], inner, name)
            after = pairs(table[x])
            for gone in before - after:
                where[gone].discard(x)
            for new in after - before:
                where[new].add(x)
                if len(where[new]) > 1:
                    heapq.heappush(heap, (-len(where[new]), str(new), new))


def term_pairs(terms: Mapping[Any, Any]) -> set[Pair]:
    """Pairs of terms of a sum {term: number}, with the ratio of their numbers."""
    order = sorted(terms, key=_text)
    return {(a, b, terms[b] / terms[a]) for i, a in enumerate(order) for b in order[i + 1 :]}


def with_term_pair(terms: Mapping[Any, Any], inner: Mapping[Any, Any], name: Any) -> dict[Any, Any]:
    """A sum with a name for a pair of its terms."""
    rest = {s: c for s, c in terms.items() if s not in inner}
    rest[name] = rest.get(name, 0) + terms[next(iter(inner))]
    return {s: c for s, c in rest.items() if c != 0}
