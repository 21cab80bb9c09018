"""Identities for the attack on the prover, true ones and false ones.

True ones come by rules that hold where both sides are real, false ones by a change in one side
that a point shows to matter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from random import Random
from typing import Any

import sympy as sp

import voronec as vo
from prover.truth import Statement, difference_at, first_difference

Pair = tuple[Any, Any]
HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Letters:
    """Symbols that are positive, if declared so, and real ones; ``dice`` chooses."""

    dice: Random
    declared: bool
    above: tuple[sp.Symbol, ...]
    real: tuple[sp.Symbol, ...]

    @classmethod
    def draw(cls, dice: Random, declared: bool) -> Letters:
        """Letters with signs or without."""
        above = tuple(sp.symbols("a b k m", positive=True)) if declared else ()
        real = tuple(sp.symbols("x y z", real=True if dice.random() < 0.5 else None))
        return cls(dice, declared, above, real)

    def possible(self, at: Mapping[Any, Any]) -> bool:
        """Whether the symbols may have these values."""
        return all(at[s] > 0 for s in self.above if s in at)

    def coin(self, share: float = 0.5) -> bool:
        """Yes with the given probability."""
        return self.dice.random() < share


def small(own: Letters) -> sp.Rational:
    """A number with few digits."""
    n = own.dice.choice((1, 2, 3, 4, 5, HALF, sp.Rational(2, 3), sp.Rational(3, 4)))
    return sp.Rational(own.dice.choice((1, -1)) * n)


def root(own: Letters, e: Any) -> Any:
    """A square root, evaluated by SymPy or left as it is."""
    return sp.sqrt(e) if own.coin() else sp.Pow(e, HALF, evaluate=False)


def size(own: Letters, e: Any) -> Any:
    """An absolute value in one of its spellings."""
    return sp.Abs(e) if own.coin() else root(own, e**2)


def twice(e: Any) -> Pair:
    """An expression that is on both sides."""
    return e, e


def leaf(own: Letters) -> Pair:
    """A letter, a multiple or a sum of letters."""
    letters = own.above + own.real
    p, q = own.dice.choice(letters), own.dice.choice(letters)
    return twice(
        own.dice.choice((p, p, p, small(own) * p, p + q, p - q, p * q, p + small(own), p**2))
    )


def real(own: Letters, depth: int) -> Pair:
    """Two equal expressions of any sign."""
    if depth <= 0 or own.coin(0.4):
        return leaf(own)
    return own.dice.choice([*RULES.values()])(own, depth - 1)


def above(own: Letters, depth: int) -> Pair:
    """Two equal expressions that are positive."""
    kind = own.dice.randrange(6)
    if own.above and (kind < 3 or depth <= 0):
        p, q = own.dice.choice(own.above), own.dice.choice(own.above)
        return twice(own.dice.choice((p, p, p * q, p / q, p + q, p**2, 2 * p, p + 1)))
    u, v = real(own, depth - 1)
    return own.dice.choice(
        ((u**2 + 1, v**2 + 1), (sp.cos(u) + 2, sp.cos(v) + 2), (u**2 + 2, v**2 + 2))
    )


def roots(own: Letters, depth: int) -> Pair:
    """Roots of products and quotients."""
    (p, P), (q, Q), (u, U), (v, V) = (
        above(own, depth),
        above(own, depth),
        real(own, depth),
        real(own, 0),
    )
    s = lambda e: root(own, e)  # noqa: E731
    return own.dice.choice(
        (
            lambda: (s(p * q), s(P) * s(Q)),
            lambda: (s(p / q), s(P) / s(Q)),
            lambda: (p * s(q / p), s(P * Q)),
            lambda: (s(p * q) / q, s(P / Q)),
            lambda: (s(p**2 + 2 * p * q + q**2), P + Q),
            lambda: (s(p**2 * q), P * s(Q)),
            lambda: (s(p**2 / q**3), P / (Q * s(Q))),
            lambda: ((s(p) + s(q)) ** 2, P + Q + 2 * s(P * Q)),
            lambda: (1 / (s(p) + s(q)), (s(P) - s(Q)) / (P - Q)),
            lambda: (s(p + q + 2 * s(p * q)), s(P) + s(Q)),
            lambda: (s(u / v) * s(v / U), sp.Integer(1)),
            lambda: (s(u) * s(v), s(U * V)),
            lambda: (s(u * v) * s(u / v), size(own, U)),
            lambda: (s(u / v), s(U * V) / size(own, V)),
            lambda: (s(u**2 * p), size(own, U) * s(P)),
            lambda: (u * s(p / (p + u**2)), U * s(P) / s(P + U**2)),
        )
    )()


def sizes(own: Letters, depth: int) -> Pair:
    """Absolute values, largest and least of two, signs."""
    (u, U), (v, V), (p, P) = real(own, depth), real(own, depth), above(own, depth)
    a = lambda e: size(own, e)  # noqa: E731
    return own.dice.choice(
        (
            lambda: (a(u * v), a(U) * a(V)),
            lambda: (a(u / v), a(U) / a(V)),
            lambda: (a(u) ** 2, U**2),
            lambda: (a(u - v), a(V - U)),
            lambda: (sp.Max(u, v) + sp.Min(u, v), U + V),
            lambda: (sp.Max(u, v), (U + V + a(U - V)) / 2),
            lambda: (sp.Max(u, v) * sp.Min(u, v), U * V),
            lambda: (sp.sign(u) * a(u), U),
            lambda: (u / a(u), a(U) / U),
            lambda: (a(p * u), P * a(U)),
            lambda: (a(a(u) - a(v)) * (a(u) + a(v)), a(U**2 - V**2)),
            lambda: (a(p), P),
            lambda: (a(u) * u * a(u), U**3),
            lambda: (a(u**3), U**2 * a(U)),
            lambda: (a(u + v) ** 2 + a(u - v) ** 2, 2 * U**2 + 2 * V**2),
        )
    )()


def halves(own: Letters, depth: int) -> Pair:
    """Half angles and small multiples."""
    (u, U), (v, V) = real(own, depth), leaf(own)
    sin, cos, tan = sp.sin, sp.cos, sp.tan
    return own.dice.choice(
        (
            lambda: (sin(u), 2 * sin(U / 2) * cos(U / 2)),
            lambda: (cos(u), 1 - 2 * sin(U / 2) ** 2),
            lambda: (tan(u / 2), sin(U) / (1 + cos(U))),
            lambda: (tan(u / 2), (1 - cos(U)) / sin(U)),
            lambda: (sin(u), 2 * tan(U / 2) / (1 + tan(U / 2) ** 2)),
            lambda: (size(own, sin(u / 2)), root(own, (1 - cos(U)) / 2)),
            lambda: (root(own, 2) * size(own, cos(u / 2)), root(own, 1 + cos(U))),
            lambda: (root(own, 1 + sin(u)), size(own, sin(U / 2) + cos(U / 2))),
            lambda: (size(own, tan(u / 2)), root(own, (1 - cos(U)) / (1 + cos(U)))),
            lambda: (sin(3 * u), 3 * sin(U) - 4 * sin(U) ** 3),
            lambda: (tan(u), 2 * tan(U / 2) / (1 - tan(U / 2) ** 2)),
            lambda: (cos((u + v) / 2) * cos((u - v) / 2), (cos(U) + cos(V)) / 2),
            lambda: (size(own, sin(u)), 2 * size(own, sin(U / 2)) * size(own, cos(U / 2))),
            lambda: (1 / cos(u) - cos(u), tan(U) * sin(U)),
        )
    )()


def nested_functions(own: Letters, depth: int) -> Pair:
    """Trigonometric functions of functions, and inverse ones."""
    (u, U), (v, V), (p, _) = real(own, depth), real(own, depth), above(own, depth)
    sin, cos, tan = sp.sin, sp.cos, sp.tan
    return own.dice.choice(
        (
            lambda: (sin(u + v), sin(U) * cos(V) + cos(U) * sin(V)),
            lambda: (cos(u + v) + cos(u - v), 2 * cos(U) * cos(V)),
            lambda: (sin(u) ** 2 + cos(U) ** 2, sp.Integer(1)),
            lambda: (tan(u + v), (tan(U) + tan(V)) / (1 - tan(U) * tan(V))),
            lambda: (sin(sin(u) + v), sin(sin(U)) * cos(V) + cos(sin(U)) * sin(V)),
            lambda: (sin(sp.atan(u)), U / root(own, 1 + U**2)),
            lambda: (cos(sp.asin(u)), root(own, 1 - U**2)),
            lambda: (sin(2 * sp.acos(u)), 2 * U * root(own, 1 - U**2)),
            lambda: (tan(sp.atan(u) + v), (U + tan(V)) / (1 - U * tan(V))),
            lambda: (cos(sp.atan2(u, v)), V / root(own, U**2 + V**2)),
            lambda: (sin(2 * sp.atan2(u, v)), 2 * U * V / (U**2 + V**2)),
            lambda: (sp.asin(u) + sp.acos(u), sp.pi / 2),
            lambda: (sp.atan(p) + sp.atan(1 / p), sp.pi / 2),
            lambda: (sp.atan(-u), -sp.atan(U)),
            lambda: (tan(sp.asin(u)), U / root(own, 1 - U**2)),
            lambda: (sp.sin(sp.cos(u) ** 2), sp.sin(1 - sp.sin(U) ** 2)),
        )
    )()


def exponentials(own: Letters, depth: int) -> Pair:
    """Exponentials, powers with letters in the exponent, hyperbolic functions."""
    (u, U), (v, V), (p, P), (q, Q) = (
        real(own, depth),
        real(own, depth),
        above(own, depth),
        above(own, 0),
    )
    exp = sp.exp
    return own.dice.choice(
        (
            lambda: (exp(u + v), exp(U) * exp(V)),
            lambda: (exp(u) ** 2 * exp(-u), exp(U)),
            lambda: (root(own, exp(2 * u)), exp(U)),
            lambda: (sp.cosh(u) ** 2 - sp.sinh(U) ** 2, sp.Integer(1)),
            lambda: (sp.sinh(2 * u), 2 * sp.sinh(U) * sp.cosh(U)),
            lambda: (sp.tanh(u), (exp(2 * U) - 1) / (exp(2 * U) + 1)),
            lambda: (p**u * q**u, (P * Q) ** U),
            lambda: ((p / q) ** u, P**U * Q ** (-U)),
            lambda: (p ** (u + 1), P * P**U),
            lambda: (root(own, p**u) ** 2, P**U),
            lambda: (sp.cosh(sp.asinh(u)), root(own, 1 + U**2)),
            lambda: (sp.cosh(u / 2) ** 2, (1 + sp.cosh(U)) / 2),
            lambda: (root(own, (sp.cosh(u) + 1) / 2), sp.cosh(U / 2)),
            lambda: (size(own, sp.sinh(u / 2)), root(own, (sp.cosh(U) - 1) / 2)),
        )
    )()


def logarithms(own: Letters, depth: int) -> Pair:
    """Logarithms of products, quotients, powers and exponentials."""
    (u, U), (v, V), (p, P), (q, Q) = (
        real(own, depth),
        real(own, depth),
        above(own, depth),
        above(own, 0),
    )
    log = sp.log
    return own.dice.choice(
        (
            lambda: (log(p * q), log(P) + log(Q)),
            lambda: (log(p / q), log(P) - log(Q)),
            lambda: (log(p**2 * q), 2 * log(P) + log(Q)),
            lambda: (log(root(own, p)), log(P) / 2),
            lambda: (log(u) + log(v), log(U * V)),
            lambda: (log(u**2), 2 * log(size(own, U))),
            lambda: (sp.exp(log(p)), P),
            lambda: (log(sp.exp(u)), U),
            lambda: (log(p * sp.exp(u)), log(P) + U),
            lambda: (sp.exp(log(p) + log(q)), P * Q),
            lambda: (sp.exp(log(p) / 2), root(own, P)),
            lambda: (p**u, sp.exp(U * log(P))),
            lambda: (log(p**u), U * log(P)),
            lambda: (sp.asinh(u), log(U + root(own, U**2 + 1))),
            lambda: (sp.atanh(u), log((1 + U) / (1 - U)) / 2),
            lambda: (log(u / v), log(size(own, U)) - log(size(own, V))),
            lambda: (log(p**2 - q**2) - log(p + q), log(size(own, P - Q))),
        )
    )()


RULES: dict[str, Callable[[Letters, int], Pair]] = {
    "roots": roots,
    "sizes": sizes,
    "half angles": halves,
    "nested trigonometry": nested_functions,
}
FAMILIES = {**RULES, "exponentials": exponentials, "logarithms": logarithms}


def branches(own: Letters, depth: int) -> Pair:
    """What holds on one branch only."""
    (u, U), (v, V), (p, _) = real(own, depth), real(own, depth), above(own, depth)
    far = own.dice.choice((3, 20, 50, 1000))
    return own.dice.choice(
        (
            lambda: (root(own, u**2), U),
            lambda: (root(own, (u - v) ** 2), U - V),
            lambda: (sp.Abs(u), sp.Abs(V) + U - V),
            lambda: (root(own, u * v), U * root(own, V / U)),
            lambda: (root(own, u / v), root(own, U * V) / V),
            lambda: (sp.Abs(u - far), far - U),
            lambda: (sp.Abs(u + v), sp.Abs(U) + sp.Abs(V)),
            lambda: (root(own, 1 - sp.cos(u) ** 2), sp.sin(U)),
            lambda: (root(own, (1 + sp.cos(u)) / 2), sp.cos(U / 2)),
            lambda: (sp.asin(sp.sin(u)), U),
            lambda: (sp.atan(sp.tan(u / far)), U / far),
            lambda: (sp.acos(sp.cos(u)), U),
            lambda: (sp.atan2(u, v), sp.atan(U / V)),
            lambda: (sp.acosh(sp.cosh(u)), U),
            lambda: (sp.atan(u) + sp.atan(1 / u), sp.pi / 2),
            lambda: (sp.atan(u) + sp.atan(v), sp.atan((U + V) / (1 - U * V))),
            lambda: (sp.log(u**2 + p), sp.log(U**2) + sp.log(p)),
            lambda: (sp.sign(u) * sp.sign(v), sp.sign(U + V)),
            lambda: (sp.Max(u, v), U),
            lambda: (root(own, p + u**2), root(own, p) + sp.Abs(U)),
            lambda: (sp.Max(u, -far), U),
        )
    )()


def mutate(own: Letters, e: Any) -> Any:
    """An expression with one place of it changed: a number, a sign, a function, a letter."""
    places = [n for n in sp.preorder_traversal(e) if not isinstance(n, sp.Tuple)]
    node = own.dice.choice(places)
    swaps: dict[Any, Any] = {sp.sin: sp.cos, sp.cos: sp.sin, sp.Abs: lambda x: x, sp.log: sp.atan}
    if isinstance(node, sp.Rational):
        new = node + own.dice.choice((1, -1)) / sp.Integer(own.dice.choice((1, 2, 1000)))
    elif type(node) in swaps and own.coin():
        new = swaps[type(node)](node.args[0])
    elif isinstance(node, sp.Symbol) and own.coin():
        new = own.dice.choice(own.above + own.real)
    elif isinstance(node, sp.Pow) and own.coin():
        new = node.base ** (node.exp + own.dice.choice((1, -1)))
    else:
        new = own.dice.choice((-node, node + small(own), node * (1 + node**2)))
    return e.subs(node, new)


def identity(dice: Random, family: str, declared: bool, true: bool) -> Statement | None:
    """An identity of a family whose truth is known; None where the dice made nothing of use."""
    own = Letters.draw(dice, declared)
    depth = dice.choice((0, 0, 1, 1, 2))
    branch = not true and own.coin()
    try:
        left, right = (branches if branch else FAMILIES[family])(own, depth)
        if not true and not branch:
            right = mutate(own, right)
    except ValueError:
        return None  # SymPy makes no maximum of what is undefined
    if any(bad in sp.Tuple(left, right).atoms() for bad in (sp.nan, sp.zoo, sp.oo, -sp.oo, sp.I)):
        return None
    if sp.count_ops(left) + sp.count_ops(right) > 120 or left == right:
        return None
    apart = first_difference(left, right, own.possible, dice)
    if true != (apart is None) or not (apart or _is_real_somewhere(left, right, own)):
        return None
    text = f"{left} = {right}"
    kind = ("branches" if branch else family) + (", declared" if declared else "")
    return Statement(kind, text, true, lambda: vo.prove_equal(left, right), (left, right))


def _is_real_somewhere(left: Any, right: Any, own: Letters) -> bool:
    """Whether both sides have values at some point: else there is nothing to prove."""
    symbols = sorted(sp.Tuple(left, right).free_symbols, key=str)
    for _ in range(60):
        at = {s: sp.Rational(own.dice.randint(-300, 300), 97) for s in symbols}
        at |= {s: abs(at[s]) for s in own.above if s in at}
        if difference_at(left, right, at) is not None:
            return True
    return False
