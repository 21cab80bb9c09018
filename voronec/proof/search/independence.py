"""Which functions a search treats as independent of everything else, though that is not certain.

The ring of an ansatz knows the relations between a sine and its cosine, between a root and what is
under it, and no others.  With a symbol s that is free, exp(s h) and b^(h/s) are transcendental over
all functions that are algebraic in s, where h does not vanish; so generators are taken off one by
one, as long as one has a symbol of its own.  What remains is certain only where Ax's theorem holds
at sight: exponentials, sines and cosines of polynomials in free symbols of which no rational
combination is a number.  The values of unknown functions, and of their slopes, are independent for
generic functions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import symengine as se

from voronec.algebra.exponents import ExponentBasis
from voronec.algebra.generators import Generators, linear_terms
from voronec.algebra.graphs import is_atom
from voronec.algebra.terms import factors_of
from voronec.algebra.verdicts import decide_zero
from voronec.errors import EngineLimit


@dataclass(frozen=True)
class Independence:
    """Of the generators of expressions: ``assumed`` are those whose independence is not certain,
    ``unknown`` are functions that may be any."""

    assumed: tuple[Any, ...]
    unknown: tuple[Any, ...]

    @classmethod
    def of(
        cls, exprs: Sequence[Any], relations: Sequence[Any], ambiguous: Iterable[Any]
    ) -> Independence:
        """Of expressions where relations vanish; ``ambiguous`` are what roots are taken of that may
        be squares."""
        generators = Generators()
        generators.scan([*exprs, *relations])
        generators.settle()
        bound = {s for r in relations for s in r.free_symbols}
        atoms = [a for a in generators.atoms if not isinstance(a, se.Symbol)]
        unknown = [a for a in atoms if is_atom(a)]
        numbers = [a for a in atoms if not is_atom(a) and not a.free_symbols]
        other = [a for a in atoms if not is_atom(a) and a.free_symbols]
        doubtful = _doubtful_functions(unknown, bound)
        held = [*other, *doubtful]
        powers = [_Power(se.Integer(0), a) for a in generators.angles]
        powers += [_Power(b, e) for b, e in generators.units]
        # One of the numbers pi, log 2, ... is transcendental; of two nobody knows.
        constant = [p for p in powers if not p.symbols]
        held += numbers if len(numbers) + len(constant) > 1 else []
        moving = [p for p in powers if p.symbols]
        held += [p.function for p in _uncertain_powers(moving, held, relations)]
        held += [p.function for p in constant] if len(numbers) + len(constant) > 1 else []
        roots = {b: se.Pow(b, 1 / se.Integer(q)) for b, q in generators.radicals.items()}
        held += [roots[b] for b in ambiguous if b in roots]
        return cls(tuple(held), tuple(dict.fromkeys(map(_application, unknown))))


@dataclass(frozen=True)
class _Power:
    """base^exponent; with base 0 the sine and the cosine of the exponent."""

    base: Any
    exponent: Any

    @property
    def function(self) -> Any:
        """What is to be told of it."""
        return se.sin(self.exponent) if self.base == 0 else se.Pow(self.base, self.exponent)

    @property
    def symbols(self) -> set[Any]:
        """What it depends on."""
        return {*self.base.free_symbols, *self.exponent.free_symbols}

    def grows_with(self, s: Any, relations: Sequence[Any]) -> bool:
        """Whether it is b^(s h), b^(h/s), or a sine of these, where b and h hold no s and neither h
        nor log b vanishes."""
        if s in self.base.free_symbols or s not in self.exponent.free_symbols:
            return False
        slopes = [(self.exponent / s).expand(), (self.exponent * s).expand()]
        slope = next((h for h in slopes if s not in h.free_symbols), None)
        if slope is None:
            return False
        rate = slope if self.base in (se.Integer(0), se.E) else slope * se.log(self.base)
        try:
            return bool(decide_zero(rate, relations).refuted)
        except EngineLimit:
            return False

    def is_polynomial(self, bound: set[Any]) -> bool:
        """Whether it is an exponential or a sine of a sum of products of powers of free symbols."""
        factors = [f for t in linear_terms(self.exponent) for f in factors_of(t) if not f.is_Number]
        bases = [f.args[0] if isinstance(f, se.Pow) else f for f in factors]
        powers = [f.args[1] if isinstance(f, se.Pow) else se.Integer(1) for f in factors]
        plain = all(isinstance(b, se.Symbol) and b not in bound for b in bases)
        whole = all(isinstance(e, se.Integer) for e in powers)
        return plain and whole and self.base in (se.Integer(0), se.E)


def _are_independent(powers: Sequence[_Power]) -> bool:
    """Whether no rational combination of the exponents of one base is a number."""
    for base in {p.base for p in powers}:
        moving = {p.exponent: linear_terms(p.exponent) for p in powers if p.base == base}
        for terms in moving.values():
            terms.pop(se.Integer(1), None)
        if len(ExponentBasis(moving).members) < len(moving):
            return False
    return True


def _uncertain_powers(
    powers: list[_Power], held: Sequence[Any], relations: Sequence[Any]
) -> list[_Power]:
    """The powers whose independence of one another and of ``held`` is not certain."""
    bound = {s for r in relations for s in r.free_symbols}
    taken = {s for e in held for s in e.free_symbols} | bound
    while True:
        count = {s: sum(s in p.symbols for p in powers) for p in powers for s in p.symbols}
        lone = {s for s, n in count.items() if n == 1} - taken
        rest = [p for p in powers if not any(p.grows_with(s, relations) for s in p.symbols & lone)]
        if len(rest) == len(powers):
            break
        powers = rest
    if not held and all(p.is_polynomial(bound) for p in powers) and _are_independent(powers):
        return []
    return powers


def _application(atom: Any) -> Any:
    """The unknown function in an atom where it is taken: f(a) of f'(a) and Subs(f'(xi), xi, a)."""
    if isinstance(atom, se.Derivative):
        return _application(atom.args[0])
    if isinstance(atom, se.Subs):
        at = dict(zip(atom.variables, atom.point, strict=True))
        return _application(atom.expr).xreplace(at)
    return atom


def _doubtful_functions(unknown: Sequence[Any], bound: set[Any]) -> list[Any]:
    """Values of unknown functions at places that may be the same: several places must be told apart
    by free symbols."""
    places: dict[str, set[Any]] = {}
    for f in map(_application, unknown):
        places.setdefault(f.get_name(), set()).add(f)

    def plain(f: Any) -> bool:
        return all(isinstance(a, se.Symbol) and a not in bound for a in f.args)

    doubtful = [
        n for n, several in places.items() if len(several) > 1 and not all(map(plain, several))
    ]
    return [a for a in unknown if _application(a).get_name() in doubtful]
