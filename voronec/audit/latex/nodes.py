"""What a printed formula is made of: a tree of frozen nodes, each with its place in the source.

``at`` is the half-open range of characters that the node was read from; it does not take part in
comparisons.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from typing import Any

Node = Any
POINT = "\\mapsto"
Place = tuple[int, int]


def _place() -> Any:
    return field(default=(0, 0), compare=False, repr=False)


@dataclass(frozen=True)
class Number:
    """A number as printed, ``2`` or ``0.5``."""

    text: str
    at: Place = _place()


@dataclass(frozen=True)
class Name:
    r"""A letter with accents, primes, indices and a label: ``\alpha_1''``, ``A_{ij}^{(\nu)}``.

    ``head`` is the letter with accents and primes in one spelling; ``sub`` the indices below;
    ``sup`` what stands above and is not an exponent.
    """

    head: str
    sub: tuple[Node, ...] = ()
    sup: tuple[Node, ...] = ()
    at: Place = _place()


TRANSPOSE = (Name("T"), Name("\\top"))
"""What stands above a matrix that is transposed."""


@dataclass(frozen=True)
class Dots:
    r"""``\dots`` in a list."""

    at: Place = _place()


@dataclass(frozen=True)
class Dot:
    r"""``\dot x``, ``\ddot x``: a derivative by the time."""

    body: Node
    order: int = 1
    at: Place = _place()


@dataclass(frozen=True)
class Variation:
    r"""``\delta x``."""

    body: Node
    at: Place = _place()


@dataclass(frozen=True)
class Differential:
    r"""``dx`` (or a ``\partial x`` that is no part of a derivative)."""

    body: Node
    sign: str = "d"
    at: Place = _place()


@dataclass(frozen=True)
class Sum:
    """Signed terms; a single term with the sign -1 is a negative."""

    terms: tuple[tuple[int, Node], ...]
    at: Place = _place()


@dataclass(frozen=True)
class Product:
    """Factors side by side."""

    factors: tuple[Node, ...]
    at: Place = _place()


@dataclass(frozen=True)
class Cross:
    r"""``a \times b``."""

    left: Node
    right: Node
    at: Place = _place()


@dataclass(frozen=True)
class Wedge:
    r"""``a \wedge b``."""

    left: Node
    right: Node
    at: Place = _place()


@dataclass(frozen=True)
class Quotient:
    r"""``\frac{a}{b}`` or ``a/b``."""

    top: Node
    bottom: Node
    at: Place = _place()


@dataclass(frozen=True)
class Power:
    """``a^b``."""

    base: Node
    exponent: Node
    at: Place = _place()


@dataclass(frozen=True)
class Root:
    r"""``\sqrt[n]{a}``."""

    body: Node
    index: Node | None = None
    at: Place = _place()


@dataclass(frozen=True)
class Elementary:
    r"""``\sin a`` and its like; ``function`` without the backslash."""

    function: str
    argument: Node
    at: Place = _place()


@dataclass(frozen=True)
class Call:
    """``f(a, b)``."""

    function: Node
    arguments: tuple[Node, ...]
    at: Place = _place()


@dataclass(frozen=True)
class Listing:
    """``(a, b)`` or ``[a, b]`` that applies nothing: a scalar or a vector product.

    With ``POINT`` for its bracket, the point with these coordinates.
    """

    items: tuple[Node, ...]
    bracket: str
    at: Place = _place()


@dataclass(frozen=True)
class Matrix:
    r"""``\begin{pmatrix} a & b \\\\ c & d \end{pmatrix}``."""

    rows: tuple[tuple[Node, ...], ...]
    at: Place = _place()


@dataclass(frozen=True)
class Cases:
    r"""``\begin{cases} a & x > 0 \\\\ b & x < 0 \end{cases}``: values with conditions.

    The last one may have none."""

    cases: tuple[tuple[Node, ...], ...]
    at: Place = _place()


@dataclass(frozen=True)
class Partial:
    r"""``\frac{\partial f}{\partial x\partial y}``; ``body`` is ``None`` for the bare operator."""

    body: Node | None
    variables: tuple[Node, ...]
    at: Place = _place()


@dataclass(frozen=True)
class Derivative:
    r"""``\frac{d}{dx} f``."""

    body: Node
    variable: Node
    order: int = 1
    at: Place = _place()


@dataclass(frozen=True)
class Bound:
    r"""``\sum_{i=1}^n f``."""

    index: Name
    lower: Node
    upper: Node
    body: Node
    at: Place = _place()


@dataclass(frozen=True)
class Integral:
    r"""``\int_a^b f``; the differential is a factor somewhere in ``body``."""

    body: Node
    lower: Node | None = None
    upper: Node | None = None
    at: Place = _place()


@dataclass(frozen=True)
class Chain:
    """``a = b = c``, or ``a < b``: one more part than relations."""

    parts: tuple[Node, ...]
    relations: tuple[str, ...] = ()
    at: Place = _place()


def walk(node: Node) -> Iterator[Node]:
    """The node and everything under it, in the order of the source."""
    yield node
    for part in fields(node):
        yield from _walk_value(getattr(node, part.name))


def _walk_value(value: Any) -> Iterator[Node]:
    if isinstance(value, tuple):
        for item in value:
            yield from _walk_value(item)
    elif hasattr(value, "at"):
        yield from walk(value)
