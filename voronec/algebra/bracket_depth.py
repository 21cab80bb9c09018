"""Names for sums in brackets that are nested too deeply, or too long for a line.

A name stands for a sum as it is arranged, so nothing is multiplied out or divided again: what is
printed gets shallow and short by as many names as that takes, in one way through all sums and one
more, which puts the names wherever the sums stand.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from math import inf
from typing import Any

from voronec.algebra.laurent import ACCELERATION, Alphabet, Factor, LetterProduct, Sum, negate

DEEP = 3
"""Brackets are not nested deeper."""


def depth(text: str) -> int:
    """How deep brackets are nested."""
    level = most = 0
    for letter in text:
        level += (letter == "(") - (letter == ")")
        most = max(most, level)
    return most


class BracketDepth:
    """Sums of an alphabet and what is named in them.

    ``fresh`` makes a letter for a sum beside the names that there are; ``room`` is how many
    characters a product of a side may have.  ``definitions`` are names with what they stand for.
    """

    def __init__(
        self,
        alphabet: Alphabet,
        fresh: Callable[[Sum, Iterable[int]], int],
        room: int,
        names: Iterable[tuple[int, Sum]] = (),
    ) -> None:
        self.alphabet, self._fresh, self._room = alphabet, fresh, room
        self.definitions: dict[int, Sum] = {}
        self._turned: dict[Any, int] = {}
        self._named: dict[Sum, tuple[int, int]] = {}
        for letter, parts in names:
            new, positive, terms = letter, parts, alphabet.letters[letter].terms
            if terms and alphabet.text(parts).startswith("-"):  # what is positive has the name
                positive, opposite = negate(parts), {m: -c for m, c in terms.items()}
                new = self._turned[letter] = alphabet.name(alphabet.names[letter], opposite)
            self._define(new, positive)

    def fold(self, sides: Iterable[Sum]) -> list[Sum]:
        """Sides of equations with names, which stand in what is named too."""
        folded = [*sides]
        for _ in range(2):
            folded = [*map(self._side, folded)]
            for i in [*self.definitions]:
                self.definitions[i] = self._side(self.definitions[i])
        return folded

    def read_in_order(self, sides: Iterable[Sum]) -> list[int]:
        """The names as a reader meets them, each after those that it is defined by."""
        left = {self.alphabet.letter_text(i): i for i in self.definitions}
        letters: list[int] = []

        def read(parts: Sum) -> None:
            for word in re.findall(r"\w+", self.alphabet.text(parts)):
                if (letter := left.pop(word, None)) is not None:
                    read(self.definitions[letter])
                    letters.append(letter)

        for parts in sides:
            read(parts)
        return letters

    def _side(self, parts: Sum) -> Sum:
        return tuple(self._product(product, self._room) for product in parts)

    def _product(self, product: LetterProduct, room: float = inf) -> LetterProduct:
        """A product with names that there are, and with new ones until it is shallow and fits."""
        for k, (base, _) in enumerate(product.factors):
            if base in self._turned:
                product = _replace_factor(product, k, self._turned[base], -1)
            elif (inside := self._inside(base)) is not None:
                parts = tuple(map(self._product, inside))
                if parts in self._named:
                    product = _replace_factor(product, k, *self._name(parts))
                elif parts != inside:
                    product = _replace_factor(product, k, parts, 1)
        while (deep := depth(text := self.alphabet.text((product,))) > DEEP) or len(text) > room:
            inside_of = {k: self._inside(f.base) for k, f in enumerate(product.factors)
                         if not self._leads(f.base)}  # fmt: skip
            texts = {k: self.alphabet.text(parts) for k, parts in inside_of.items() if parts}
            if not texts:
                break
            worst = max(texts, key=lambda k: (deep * depth(texts[k]), len(texts[k])))
            product = _replace_factor(product, worst, *self._name(inside_of[worst] or ()))
        return product

    def _inside(self, base: Any) -> Sum | None:
        """The sum that stands in brackets."""
        if not isinstance(base, int):
            return tuple(base)
        terms = self.alphabet.letters[base].terms
        is_unnamed = terms is not None and base not in self.alphabet.named
        return self.alphabet.arrange(terms or {}) if is_unnamed else None

    def _leads(self, base: Any) -> bool:
        """Whether accelerations stand in brackets: they stay on the left side."""
        if (inside := self._inside(base)) is None:
            return self.alphabet.letters[base].rank[0] == ACCELERATION
        return any(self._leads(f.base) for product in inside for f in product.factors)

    def _name(self, parts: Sum) -> tuple[int, int]:
        """The letter that is named for a sum, or for its negative, and the sign."""
        if parts not in self._named:
            positive = negate(parts) if self.alphabet.text(parts).startswith("-") else parts
            letter = self._fresh(positive, self.definitions)
            self._define(letter, positive)
            self.definitions[letter] = self._side(positive)
        return self._named[parts]

    def _define(self, letter: int, parts: Sum) -> None:
        self.definitions[letter] = parts
        self._named |= {parts: (letter, 1), negate(parts): (letter, -1)}


def _replace_factor(product: LetterProduct, k: int, base: Any, sign: int) -> LetterProduct:
    """A product with another base, times a sign, under one of its exponents."""
    factors, e = list(product.factors), product.factors[k].exponent
    if sign < 0 and not isinstance(e, int):
        base, sign = (LetterProduct(-1, (Factor(base, 1),)),), 1
    factors[k] = Factor(base, e)
    return LetterProduct(product.number * (sign if e % 2 else 1), tuple(factors))
