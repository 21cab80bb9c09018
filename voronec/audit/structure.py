"""What can be said of a formula without giving it a value: its free indices, its new names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import sympy as sp

from voronec.audit.latex.nodes import (
    Bound,
    Call,
    Chain,
    Differential,
    Integral,
    Listing,
    Name,
    Node,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    walk,
)
from voronec.audit.study import Study, key_of, spell
from voronec.errors import DefinitionError


def free_names(node: Node, study: Study) -> Iterator[Name]:
    """The index letters of a formula that no sum binds, at each place where they stand."""
    yield from _free(node, study, frozenset())


def _free(part: Any, study: Study, bound: frozenset[str]) -> Iterator[Name]:
    if isinstance(part, tuple):
        for item in part:
            yield from _free(item, study, bound)
    elif isinstance(part, Bound):
        yield from _free((part.lower, part.upper), study, bound)
        yield from _free(part.body, study, bound | {part.index.head})
    elif isinstance(part, Call):
        yield from _free(part.function, study, bound)
    elif study.is_index(part):
        if part.head not in bound:
            yield part
    elif hasattr(part, "at"):
        for value in vars(part).values():
            yield from _free(value, study, bound)


def free_indices(node: Node, study: Study) -> tuple[str, ...]:
    """The letters of ``free_names``, each once, in the order of their appearance."""
    return tuple(dict.fromkeys(name.head for name in free_names(node, study)))


def integrand(node: Integral) -> tuple[Node, Node]:
    """The variable of an integral, and what stands beside its differential."""
    factors = node.body.factors if isinstance(node.body, Product) else (node.body,)
    signs = [f for f in factors if isinstance(f, Differential)]
    if len(signs) != 1:
        raise DefinitionError("an integral needs one differential beside its integrand")
    rest = tuple(f for f in factors if f is not signs[0])
    return signs[0].body, rest[0] if len(rest) == 1 else Product(rest)


def mentions(node: Node) -> set[str]:
    """The canonical keys of the names in a tree."""
    return {key_of(part) for part in walk(node) if isinstance(part, Name)}


def marks(node: Any, study: Study, index: bool) -> set[str]:
    """The keys of the names in a tree: of those that stand as indices, or of all others.

    What stands as an index in a name that the dictionary has as a whole is no index.
    """
    keys: set[str] = set()
    if isinstance(node, tuple):
        return keys.union(*(marks(item, study, index) for item in node))
    if isinstance(node, Name):
        inside = () if key_of(node) in study.table else (*node.sub, *node.sup)
        return mentions(Listing(inside, "(")) if index else {key_of(node)}
    if hasattr(node, "at"):
        return keys.union(*(marks(value, study, index) for value in vars(node).values()))
    return keys


def bare_letter(name: Name) -> str:
    """The letter of a name without its accents and primes."""
    bare = re.sub(r"^(?:\\[a-zA-Z]+\{)+|\}+$", "", name.head) or name.head
    return bare.rstrip("'")


def names_constant(part: Node) -> bool:
    """Whether a part of a chain is the word "const"."""
    return isinstance(part, Name) and part.head == "const"


def whole_name(part: Node, study: Study) -> str | None:
    """The key of a part that is a single name which the dictionary does not hold."""
    if not isinstance(part, Name) or names_constant(part):
        return None
    key = key_of(part)

    def slot(index: Node) -> str:
        return "#" if any(study.is_index(name) for name in walk(index)) else spell(index)

    family = key_of(part, slot)
    return None if key in study.table or family in study.table else key


def definitions_in(chain: Chain, study: Study) -> dict[str, Node]:
    """The names that a chain of equalities defines, each with the part that defines it."""
    definitions: dict[str, Node] = {}
    for (left, right), relation in zip(pairwise(chain.parts), chain.relations, strict=True):
        for part, other in ((left, right), (right, left)):
            key = whole_name(part, study)
            if key is not None and relation == "=":
                definitions.setdefault(key, other)
    return definitions


def new_names(chain: Chain, study: Study) -> set[str]:
    """The names that this formula, and no earlier one, defines."""
    definitions = definitions_in(chain, study)
    return {key for key, node in definitions.items() if study.defined.get(key, node) == node}


def holds_always(left: Node, right: Node) -> bool:
    """Whether two sides are equal whatever their letters mean."""
    return left == right or bool(sp.expand(_in_letters(left) - _in_letters(right)) == 0)


def are_multiples(left: Node, right: Node) -> bool:
    """Whether one side is a number times the other, neither zero, whatever their letters mean."""
    a, b = (sp.expand(_in_letters(side)).as_coefficients_dict() for side in (left, right))
    if not a or a.keys() != b.keys() or not any(a.values()):
        return False
    return len({value / b[term] for term, value in a.items()}) == 1


def _in_letters(node: Node) -> Any:
    """The value of a tree with its names as letters, which may stand for matrices."""
    if isinstance(node, Number):
        return sp.Rational(node.text)
    if isinstance(node, Sum):
        return sp.Add(*(sign * _in_letters(term) for sign, term in node.terms))
    if isinstance(node, Product):
        return sp.Mul(*map(_in_letters, node.factors))
    if isinstance(node, Quotient):
        return _in_letters(node.top) / _in_letters(node.bottom)
    if isinstance(node, Power):
        return _in_letters(node.base) ** _in_letters(node.exponent)
    return sp.Symbol(repr(node), commutative=False)


def says_nothing(chain: Chain) -> bool:
    """Whether a formula sets something equal to itself."""
    links = zip(pairwise(chain.parts), chain.relations, strict=True)
    return any(relation == "=" and a == b for (a, b), relation in links)


def states_dependence(chain: Chain) -> bool:
    """Whether a formula says no more than of what a quantity is a function, as F = F(x)."""
    names = {part.function if isinstance(part, Call) else part for part in chain.parts}
    return len(names) == 1 and {*chain.relations} == {"="}
