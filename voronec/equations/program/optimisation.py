"""Fewer operations for a straight-line program: brackets, shared parts, constants of parameters.

Sums take common factors before brackets.  Then, as long as there is one, the pair of factors that
stands in most products, or the pair of terms that stands in most sums but for a factor, becomes an
assignment of its own [KuipersUedaVermaseren2015].  Every step is an identity.
Sums are products of irreducible factors, nested, where that takes fewer operations.

What parameters alone give is computed once instead of at every step.  Compilers of Taylor's method
take a quotient of parameters for a moving quantity.  So such expressions become parameters
themselves; the program can still be run with other values, without being compiled again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from itertools import combinations, product
from typing import Any

import flint
import symengine as se

from voronec.algebra.brackets import (
    Choice,
    Pair,
    factor_exponents,
    nest_sums,
    share_pairs,
    term_pairs,
    with_term_pair,
)
from voronec.algebra.factors import irreducible_factors, write_polynomial
from voronec.algebra.memo import remember
from voronec.algebra.stages import needed_stages, primitive
from voronec.algebra.terms import factors_of, ordered_terms, rewrite_kinds
from voronec.equations.program.parts import arguments_of
from voronec.equations.program.python import compile_program
from voronec.equations.program.straight import (
    Block,
    Program,
    fresh_names,
    prune,
)
from voronec.equations.program.weight import operation_count
from voronec.errors import EngineLimit

LONG = 1000
"""Programs of more operations stay as they are: pairs are counted anew after every step."""
MANY = 400
"""The brackets of longer programs stay as they are."""
ONE = se.Integer(1)


def shorten_program(program: Program) -> Program:
    """The program, or an equal one whose rates take fewer operations."""
    block = program.derivative
    if block.operations > LONG:
        return program
    known = [program.time, *arguments_of(program)]
    blocks = [block]
    for begin, change in product((block, _without_monomials(block)), _changes(block)):
        changed = [(name, change(se.sympify(e))) for name, e in begin.assignments]
        results = [change(se.sympify(e)) for e in begin.results]
        shared = _SharedParts(changed, results, known).block(fresh_names(known))
        blocks.append(prune(shared.assignments, shared.results))  # names may have cancelled
    shortest = min(blocks, key=lambda b: operation_count(b.expressions))
    return replace(program, derivative=shortest)


def _changes(block: Block) -> Iterator[Callable[[Any], Any]]:
    """What is tried with every right side; the shortest program counts."""
    yield se.sympify
    for choice in (min, max) if block.operations <= MANY else ():
        nest, bracket = (partial(f, choice=choice) for f in (_nest, _bracket_sums))
        yield from (nest, bracket, partial(_in_turn, (_spread_products, nest)))
        yield partial(_in_turn, (_spread_products, nest, bracket))


def _nest(expr: Any, choice: Choice) -> Any:
    return nest_sums(expr, (), choice)


def _in_turn(changes: Iterable[Callable[[Any], Any]], expr: Any) -> Any:
    for change in changes:
        expr = change(expr)
    return expr


def _without_monomials(block: Block) -> Block:
    """The block with products and powers of symbols spelled out: sums of them may have factors."""
    meaning: dict[Any, Any] = {}
    kept = []
    for name, expr in block.assignments:
        spelled = expr.xreplace(meaning)
        if not spelled.atoms(se.Add, se.Function):
            meaning[name] = spelled
        else:
            kept.append((name, spelled))
    return Block(tuple(kept), tuple(se.sympify(e).xreplace(meaning) for e in block.results))


class _SharedParts:
    """Expressions as products {factor: exponent} and sums {term: number}, by names of their own.

    What is named is a product without a number, a sum of such, a root, or another function.
    """

    def __init__(
        self, assignments: Sequence[tuple[Any, Any]], results: Iterable[Any], known: Sequence[Any]
    ) -> None:
        self.products: dict[Any, dict[Any, int]] = {}
        self.sums: dict[Any, dict[Any, Any]] = {}
        self.others: dict[Any, Any] = {}
        self._names: dict[Any, Any] = {}
        self._fresh = fresh_names([*known, *(name for name, _ in assignments)])
        self._read_before: dict[Any, tuple[Any, Any]] = {}
        for name, expr in assignments:
            self._read_before[name] = self._read(expr)
        self.results = [self._read(e) for e in results]
        self._share_factors()
        self._share_terms()
        self._share_factors()

    def _name_for(self, table: dict[Any, Any], key: Any, value: Any) -> Any:
        """The name of something, the same for the same."""
        if key not in self._names:
            self._names[key] = next(self._fresh)
            table[self._names[key]] = value
        return self._names[key]

    def _product(self, powers: Mapping[Any, int]) -> Any:
        left = {s: e for s, e in powers.items() if e}
        if not left:
            return ONE
        if len(left) == 1 and next(iter(left.values())) == 1:
            return next(iter(left))
        return self._name_for(self.products, frozenset(left.items()), left)

    @remember("_read_before")
    def _read(self, expr: Any) -> tuple[Any, Any]:
        """An expression as a number times a name; the name is 1 for numbers."""
        if expr.is_Number:
            return expr, ONE
        if isinstance(expr, se.Symbol) or not expr.args:
            return ONE, expr
        if isinstance(expr, se.Add):
            number, total = primitive(expr)
            if not isinstance(total, se.Add):  # -a - (b - a) is -1 times b
                c, name = self._read(total)
                return number * c, name
            terms: dict[Any, Any] = {}
            for term in ordered_terms(total):
                c, name = self._read(term)
                terms[name] = terms.get(name, 0) + c
            # names may stand for multiples of others, of which nothing is left
            left = {name: c for name, c in terms.items() if c != 0}
            if len(left) < 2:
                name, c = next(iter(left.items()), (ONE, se.Integer(0)))
                return number * c, name
            return number, self._name_for(self.sums, total, left)
        if isinstance(expr, se.Mul):
            number, powers = ONE, Counter[Any]()
            for factor in expr.args:
                base, exponent = _power(factor)
                c, name = self._read(base)
                number *= c**exponent
                powers[name] += exponent
            del powers[ONE]
            return number, self._product(powers)
        base, exponent = _power(expr)
        if exponent != 1:
            c, name = self._read(base)
            return c**exponent, self._product({name: exponent})
        args = [c * name for c, name in map(self._read, expr.args)]
        return ONE, self._name_for(self.others, expr, (expr.func, args))

    def _share_factors(self) -> None:
        """Name pairs of factors that several products hold."""
        share_pairs(self.products, _pairs, self._factor_pair, _with_pair)

    def _factor_pair(self, pair: Pair) -> tuple[dict[Any, Any], Any]:
        first, second, sign = pair
        inner = {first: 2} if first == second else {first: 1, second: sign}
        return inner, self._product(inner)

    def _share_terms(self) -> None:
        """Name pairs of terms that several sums hold but for a factor."""
        share_pairs(self.sums, term_pairs, self._term_pair, with_term_pair)

    def _term_pair(self, pair: Pair) -> tuple[dict[Any, Any], Any]:
        first, second, ratio = pair
        inner = {first: ONE, second: ratio}
        name = next((s for s, terms in self.sums.items() if terms == inner), None)
        return inner, name or self._name_for(self.sums, first + ratio * second, inner)

    def block(self, fresh: Iterator[Any]) -> Block:
        """What was read, every name assigned that is used more than once."""
        definitions = {name: self._definition(name) for name in self._names.values()}
        order = needed_stages(definitions, [s for _, s in self.results])
        uses = Counter(s for name in order for s in definitions[name].free_symbols)
        uses.update(s for _, s in self.results)
        numbered = [(c, s) for name in order for s, c in self.sums.get(name, {}).items()]
        # symengine would multiply 2*(a + b) out
        kept = {s for c, s in (*numbered, *self.results) if c != 1 and s in self.sums}
        meaning: dict[Any, Any] = {}
        assignments: list[tuple[Any, Any]] = []
        for name in order:
            expr = meaning[name] = definitions[name].xreplace(meaning)
            if expr.args and (uses[name] > 1 or name in kept):
                meaning[name] = next(fresh)
                assignments.append((meaning[name], expr))
        return Block(tuple(assignments), tuple(c * meaning.get(s, s) for c, s in self.results))

    def _definition(self, name: Any) -> Any:
        if name in self.products:
            return se.Mul(*[s**e for s, e in self.products[name].items()])
        if name in self.sums:
            return se.Add(*[c * s for s, c in self.sums[name].items()])
        function, args = self.others[name]
        return function(*args)


def _power(factor: Any) -> tuple[Any, int]:
    """Base and exponent of a factor, the root for halves."""
    if isinstance(factor, se.Pow):
        base, exponent = factor.args
        if isinstance(exponent, se.Integer):
            return base, int(exponent)
        twice = 2 * exponent
        if isinstance(twice, se.Integer) and twice != 1:
            return se.sqrt(base), int(twice)
    return factor, 1


def _pairs(powers: Mapping[Any, int]) -> set[Pair]:
    """Pairs of factors: a*b and 1/(a*b) with 1, a/b with -1; squares as a, a, 1."""
    items = sorted(powers.items(), key=str)
    pairs = {(a, a, 1) for a, e in items if abs(e) > 1}
    for (a, e), (b, f) in combinations(items, 2):
        if e * f > 0:
            pairs.add((a, b, 1))
        else:  # a quotient is never turned over: the other has poles elsewhere
            pairs.add((a, b, -1) if e > 0 else (b, a, -1))
    return pairs


def _with_pair(powers: Mapping[Any, int], inner: Mapping[Any, int], name: Any) -> dict[Any, int]:
    """A product with a name for a pair of its factors, as often as it holds the pair."""
    often = min(abs(powers[s]) // abs(e) for s, e in inner.items())
    first = next(iter(inner))
    times = often if powers[first] > 0 else -often
    left = {s: e - times * inner.get(s, 0) for s, e in powers.items()}
    left[name] = left.get(name, 0) + times
    return {s: e for s, e in left.items() if e}


WIDEST = 60
"""Sums of more terms are not factored."""


def _bracket_sums(expr: Any, choice: Any = min) -> Any:
    """An expression whose sums, inner ones first, are nested, or products of the factors that they
    have over Q, functions counted as letters, where that takes fewer operations."""
    return rewrite_kinds(se.sympify(expr), se.Add, lambda total: _shortest(total, choice))


def _spread_products(expr: Any) -> Any:
    """An expression with sums times single factors as sums, inner ones first.

    Products of two sums stay: written out, their terms may cancel, and digits are lost.
    """
    return rewrite_kinds(se.sympify(expr), se.Mul, _spread)


def _spread(term: Any) -> Any:
    sums = [f for f in term.args if isinstance(f, se.Add)]
    held = any(isinstance(f, se.Pow) and isinstance(f.args[0], se.Add) for f in term.args)
    if len(sums) != 1 or held:
        return term
    factor = term / sums[0]
    return se.Add(*[factor * t for t in sums[0].args])


def _shortest(total: Any, choice: Any) -> Any:
    forms = [total, nest_sums(total, (), choice)]
    flat = se.expand(total)
    if isinstance(flat, se.Add) and len(flat.args) <= WIDEST:
        forms += _factor_forms(flat)
    return min(forms, key=lambda e: operation_count([e]))


def _factor_forms(total: Any) -> list[Any]:
    """A sum as a product of factors, each of them nested; none where it has one factor, or is no
    polynomial over Q."""
    terms = [factor_exponents(t) for t in total.args]
    letters = sorted({b for t in terms for b in t if not b.is_Number}, key=str)
    lowest = [min(t.get(b, 0) for t in terms) for b in letters]
    context = flint.fmpq_mpoly_ctx.get([f"x{i}" for i in range(len(letters))], flint.Ordering.lex)
    polynomial = context.constant(0)
    for t in terms:
        number = se.Mul(*[b**e for b, e in t.items() if b.is_Number])
        if not isinstance(number, se.Rational):
            return []
        exponents = tuple(t.get(b, 0) - low for b, low in zip(letters, lowest, strict=True))
        size = flint.fmpq(int(number.p), int(number.q))
        polynomial += context.from_dict({exponents: size})
    try:
        unit, factors = irreducible_factors(polynomial)
    except EngineLimit:
        return []
    outside = [b**low for b, low in zip(letters, lowest, strict=True)]
    inside = [nest_sums(write_polynomial(f, letters), ()) ** e for f, e in factors]
    if len(factors) == 1 and factors[0][1] == 1 and unit == 1 and not any(lowest):
        return []
    return [se.Mul(se.Integer(int(unit.p)) / int(unit.q), *outside, *inside)]


@dataclass(frozen=True)
class HoistedProgram:
    """A ``program`` whose further parameters ``constants`` are functions of those of the original.

    ``definitions`` gives them in order; each may use those before it.
    """

    program: Program
    original: Program
    definitions: tuple[tuple[Any, Any], ...]

    def values(self, parameters: Sequence[Any]) -> list[Any]:
        """Values for the parameters of ``program``, from those of the original.

        What cannot be computed (a parameter is missing, a quotient has no value) is nan, as it
        is in the equations.
        """
        given = list(parameters)
        try:
            return [*given, *self._function(0.0, (), given)]
        except (ZeroDivisionError, ValueError, OverflowError):
            return self._one_by_one(given)

    @cached_property
    def _function(self) -> Any:
        names = [name for name, _ in self.definitions]
        return _compile(self.original, self.original.parameters, self.definitions, names)

    def _one_by_one(self, given: list[Any]) -> list[Any]:
        """Values one by one, where some have none."""
        known = list(self.original.parameters)
        for name, expr in self.definitions:
            function = _compile(self.original, known, (), [expr])
            try:
                given += function(0.0, (), given)
            except (ZeroDivisionError, ValueError, OverflowError):
                given.append(float("nan"))
            known.append(name)
        return given


def _compile(
    program: Program, known: Sequence[Any], assignments: Sequence[Any], results: Sequence[Any]
) -> Any:
    """A function of (0, (), parameters)."""
    names = tuple(f"_{i}" for i in range(len(results)))
    block = Block(tuple(assignments), tuple(results))
    return compile_program(
        Program(program.time, (), (), tuple(known), Block((), ()), names, block), scalar=True
    )[1]


@lru_cache(maxsize=32)  # a run looks at the constants before it compiles with them
def hoist(program: Program) -> HoistedProgram:
    """The program with every largest expression of parameters and numbers as one parameter.

    A sum whose terms share such a factor is written as factor times sum.
    """
    lifting = _Lifting(program)
    derivative, extras = lifting.block(program.derivative), lifting.block(program.extras)
    definitions = tuple((name, e) for e, name in lifting.names.items())
    parameters = (*program.parameters, *(name for name, _ in definitions))
    changed = replace(program, parameters=parameters, derivative=derivative, extras=extras)
    return HoistedProgram(changed, program, definitions)


class _Lifting:
    """One walk over a program; ``names`` maps each expression of constants to its name."""

    def __init__(self, program: Program) -> None:
        self.names: dict[Any, Any] = {}
        self._still: set[Any] = set(program.parameters)
        self._memo: dict[Any, Any] = {}
        blocks = (program.derivative, program.extras)
        known = (*program.state, *program.parameters, program.time)
        self._fresh = fresh_names([*known, *(n for b in blocks for n, _ in b.assignments)], "k")

    def block(self, block: Block) -> Block:
        """The assignments without those that are constant."""
        kept = []
        self._memo = {}  # each block has names of its own, which may be those of another
        for name, expr in block.assignments:
            changed = self.of(expr)
            if changed.free_symbols <= self._still:  # a name for a constant, or for a number
                self._memo[name] = changed
            else:
                kept.append((name, changed))
        results = [self.of(se.sympify(r)) for r in block.results]
        return Block(tuple(kept), tuple(results))

    @remember("_memo")
    def of(self, expr: Any) -> Any:
        """An expression with its constants by name."""
        if not expr.args or expr.is_Number:
            return expr
        args = [self.of(a) for a in ordered_terms(expr)]
        if isinstance(expr, se.Mul):
            return self._product(args)
        if isinstance(expr, se.Add):
            return self._sum(args)
        whole = expr.func(*args)
        return self._name_constant(whole) if whole.free_symbols <= self._still else whole

    def _product(self, args: Iterable[Any]) -> Any:
        """Constant factors together, as one; into a sum whose terms all have constants anyway."""
        still, moving = self._split_constant(se.Mul(*args))
        if still.free_symbols and isinstance(moving, se.Add):
            parts = [self._split_constant(term) for term in ordered_terms(moving)]
            if all(c.free_symbols for c, _ in parts):
                return se.Add(*[self._times(still * c, m) for c, m in parts])
        return self._times(still, moving)

    def _sum(self, args: Iterable[Any]) -> Any:
        """Constant terms together; a factor that all terms share stands before them."""
        total = se.Add(*args)
        if not isinstance(total, se.Add):
            return self.of(total) if total.args else total
        parts = [self._split_constant(term) for term in ordered_terms(total)]
        still = self._name_constant(se.Add(*[c for c, m in parts if m == 1]))
        moving = [(c, m) for c, m in parts if m != 1]
        if not moving:
            return still
        first = moving[0][0]
        ratios = [c / first for c, _ in moving]
        shared = still == 0 and first.free_symbols and all(r.is_Number for r in ratios)
        if len(moving) > 1 and shared:
            inner = se.Add(*[r * m for r, (_, m) in zip(ratios, moving, strict=True)])
            return self._name_constant(first) * inner
        return se.Add(still, *[self._times(c, m) for c, m in moving])

    def _split_constant(self, term: Any) -> tuple[Any, Any]:
        """A term as constant times what moves, the constant in the original's parameters."""
        factors = factors_of(term)
        still = [f for f in factors if f.free_symbols <= self._still]
        moving = [f for f in factors if not f.free_symbols <= self._still]
        return se.Mul(*still), se.Mul(*moving)

    def _times(self, still: Any, moving: Any) -> Any:
        if moving == 1:
            return self._name_constant(still)
        return self._name_constant(still) * moving

    def _name_constant(self, expr: Any) -> Any:
        """A constant by its name; numbers and single parameters have theirs."""
        if expr.is_Number or not expr.args:
            return expr
        if expr not in self.names:
            self.names[expr] = next(self._fresh)
            self._still.add(self.names[expr])
        return self.names[expr]
