"""Cuts of a function of many branches, and what the function is on either side of one.

Signs, floors, roots of even order, arctangents are analytic but for cuts h = 0: there what stands
inside vanishes, or becomes infinite.  With h = s |h|, s = 1 or -1 the side, and g = c h^k u there

    sign(g) = s^k sign(c u),    g^e = |h|^(k e) (s^k c u)^e,    atan(g) = pi/2 sign(g) - atan(1/g)

are functions of s, analytic where h = 0 [Theory, eq. (14b)].  In the half angles C = cos(a/2),
S = sin(a/2) all polynomials in cos(a) = C^2 - S^2, sin(a) = 2 S C, 1 = C^2 + S^2 factor uniquely.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import flint
import symengine as se

from voronec.algebra.factors import irreducible_factors, write_polynomial
from voronec.algebra.groebner import groebner_basis, reduce_by
from voronec.algebra.memo import remember
from voronec.algebra.ring import Ring
from voronec.algebra.simple_zeros import compose_on_section, has_simple_zeros
from voronec.algebra.terms import rational

HALF_PI = se.pi / 2
_ESSENTIAL = (
    se.sin, se.cos, se.tan, se.cot, se.sec, se.csc, se.sinh, se.cosh, se.tanh, se.coth,
    se.FunctionSymbol,
)  # fmt: skip
_OPEN = (se.asin, se.acos, se.acosh)
_MANY = (se.sign, se.floor, se.atan, se.acot, se.atan2, se.log, se.atanh, se.Abs, *_OPEN)


# -- products of irreducible functions --------------------------------------------------------


@dataclass(frozen=True)
class Factorisation:
    """content * product of h^k over ``powers``; the h are irreducible, and differ.

    ``roots`` are those of the h that are roots themselves, and nowhere negative.
    """

    content: Any
    powers: dict[Any, int]
    roots: frozenset[Any] = frozenset()

    def without(self, h: Any) -> Any:
        """The product without one of its factors, as an expression."""
        return se.Mul(self.content, *[f**k for f, k in self.powers.items() if f != h])

    @property
    def expression(self) -> Any:
        """The product itself."""
        return self.without(None)

    @property
    def odd(self) -> Any:
        """The product of the factors of odd powers: what a square root cannot be taken of."""
        kept = [f ** (1 if k > 0 else -1) for f, k in self.powers.items() if k % 2]
        return se.Mul(self.content, *kept)


@lru_cache(maxsize=4096)
def product_of(
    expr: Any, relations: tuple[Any, ...] = (), moving: frozenset[Any] = frozenset()
) -> Factorisation:
    """The factors of an expression where relations vanish; ``EngineLimit`` where it is too large.

    Several products are the same there: one is taken without further multiple zeros, if possible.
    """
    ring = Ring([expr, *relations])
    value = ring.fraction(expr)
    if value.num == 0:
        return Factorisation(se.Integer(0), {})
    below = ring.field.denominator(value.den)
    plain = _factor(ring, value.num, below)
    if not relations or has_simple_zeros(plain.odd, relations, moving):
        return plain
    for turned in _reorderings(ring, (value.num, below), [ring.fraction(r).num for r in relations]):
        product = _factor(ring, *turned)
        if has_simple_zeros(product.odd, relations, moving):
            return product
    return plain


def divisors_of(expr: Any, relations: tuple[Any, ...] = ()) -> list[Any]:
    """The irreducible functions by which an expression is divided, but for roots."""
    ring = Ring([expr, *relations])
    below = ring.field.denominator(ring.fraction(expr).den)
    product = _factor(ring, below, ring.field.one)
    return [h for h in product.powers if h not in product.roots]


def _reorderings(ring: Ring, polys: Sequence[Any], ideal: Sequence[Any]) -> Iterator[list[Any]]:
    """Polynomials reduced by the relations in other orders of the generators."""
    context = ring.field.context
    names = context.names()
    for last in sorted({i for p in ideal for i, d in enumerate(p.degrees()) if d}):
        order = [i for i in range(len(names)) if i != last] + [last]
        other = flint.fmpq_mpoly_ctx.get([names[i] for i in order], flint.Ordering.lex)
        back = sorted(range(len(order)), key=order.__getitem__)
        basis = groebner_basis([_reorder(p, order, other) for p in ideal], other)
        reduced = (reduce_by(_reorder(p, order, other), basis) for p in polys)
        yield [_reorder(p, back, context) for p in reduced]


def _reorder(poly: Any, order: Sequence[int], context: Any) -> Any:
    return context.from_dict({tuple(m[i] for i in order): c for m, c in poly.to_dict().items()})


def _factor(ring: Ring, above: Any, below: Any) -> Factorisation:
    """The factors of a quotient of polynomials, in half angles."""
    halves = _Halves.of(ring)
    content, powers = se.Integer(1), dict[Any, int]()
    for poly, side in ((above, 1), (below, -1)):
        unit, factors = irreducible_factors(halves.poly(poly))
        number = rational(unit)
        content = content * number if side > 0 else content / number
        for factor, e in factors:
            h = halves.expression(factor)
            if h != 1:
                powers[h] = powers.get(h, 0) + side * int(e)
    roots = frozenset(powers) & {ring.meaning[ring.index(r)] for r in ring.roots.values()}
    return Factorisation(content, {h: k for h, k in powers.items() if k}, roots)


@dataclass
class _Halves:
    """A ring with free generators cos(a/2), sin(a/2) in the place of cos(a), sin(a)."""

    context: Any
    values: list[Any]
    below: dict[int, Any]
    meaning: list[Any]

    @classmethod
    def of(cls, ring: Ring) -> _Halves:
        names = ring.field.context.names()
        context = flint.fmpq_mpoly_ctx.get(names, flint.Ordering.lex)
        gens = context.gens()
        values, meaning, below = list(gens), list(ring.meaning), dict[int, Any]()
        for angle, (s, c) in zip(ring.angles(), ring.angle_indices(), strict=True):
            meaning[c], meaning[s] = se.cos(angle / 2), se.sin(angle / 2)
            values[c] = gens[c] ** 2 - gens[s] ** 2
            values[s] = 2 * gens[s] * gens[c]
            below[s] = below[c] = gens[c] ** 2 + gens[s] ** 2
        return cls(context, values, below, meaning)

    def poly(self, given: Any) -> Any:
        """A polynomial of the ring in the half angles."""
        return compose_on_section(given, self.values, self.below, self.context)

    def expression(self, factor: Any) -> Any:
        """A factor as an expression; 1 = C^2 + S^2."""
        if any(factor == one for one in self.below.values()):
            return se.Integer(1)
        return write_polynomial(factor, self.meaning)


# -- cuts --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class BranchCut:
    """A piece of the zeros of ``function``.

    ``above`` and ``below`` are an expression on its sides, ``function`` > 0 and < 0, as functions
    that go on to the cut, ``turned`` the one below with arctangents continued from above; the
    piece is where all of ``positive`` are so.  An ``edge`` is one
    beyond which the expression is not real.  Where ``whole`` is a symbol, it stands for any whole
    number.
    """

    function: Any
    above: Any
    below: Any
    turned: Any
    positive: tuple[Any, ...] = ()
    edge: bool = False
    whole: Any = None


@dataclass
class Branches:
    """The branches of one expression; ``moving`` are the symbols of the state and the time.

    ``unclear`` are the functions of which it is open whether they make cuts.  ``meets_poles`` asks
    for essential singularities too.
    """

    expr: Any
    moving: frozenset[Any]
    relations: tuple[Any, ...] = ()
    meets_poles: bool = True
    unclear: dict[Any, None] = field(default_factory=dict)
    _found: dict[Any, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        angles = [n for n in _nodes(self.expr) if isinstance(n, se.atan)]
        turned = {n: se.atan(self._without_roots_below(n.args[0])) for n in angles}
        if any(n != t for n, t in turned.items()):  # else it is kept as it is written
            self.expr = self.expr.xreplace(turned)
        for node in _nodes(self.expr):
            if node.free_symbols & self.moving:
                self._look(node)

    def _without_roots_below(self, inside: Any) -> Any:
        """(r - x)/y for y/(x + r), r^2 = x^2 + y^2: the same with a polynomial below.

        Where that vanishes, one of x + r and x - r does, unless in codimension two; where it is the
        second, what stood below does not vanish, and there is no cut.
        """
        rooted = inside.free_symbols & self.moving and any(map(_is_root, _nodes(inside)))
        if self.relations or not rooted:
            return inside
        product = self.product(inside)
        for h, k in product.powers.items():
            line = _line_in_root(h) if k < 0 and h not in product.roots else None
            if line is not None and self._are_coprime(line):
                rest, slope, root = line
                norm = (rest**2 - slope**2 * root.args[0]).expand()
                return product.without(h) * (rest - slope * root) ** -k * norm**k
        return inside

    def _are_coprime(self, line: tuple[Any, Any, Any]) -> bool:
        """Whether a and b r of a + b r vanish together in codimension two only."""
        rest, slope, root = line
        one, other = (self.product(e).powers for e in (rest, slope * root.args[0]))
        return not any(h.free_symbols & self.moving for h in one.keys() & other.keys())

    def branch_cuts(self) -> Iterator[BranchCut]:
        """Every piece of every cut."""
        for h, whole in self._found.items():
            yield from self._pieces(h, whole)

    @property
    def cuts(self) -> list[Any]:
        """The functions whose zeros are cuts, but for the places where floors step."""
        return [h for h, whole in self._found.items() if whole is None]

    def beyond(self, h: Any, side: int) -> Any:
        """The expression as it is wherever a function has the sign of ``side``."""
        return _Side(self, h, side, side, {}, is_local=False)(self.expr)

    def product(self, expr: Any) -> Factorisation:
        """The factors of an expression."""
        return product_of(expr, self.relations, self.moving)

    def _is_simple(self, expr: Any) -> bool:
        return has_simple_zeros(expr, self.relations, self.moving)

    def _look(self, node: Any) -> None:
        """The cuts of one node."""
        if isinstance(node, se.Pow):
            self._look_at_power(*node.args)
        elif isinstance(node, se.sign):
            self._add(node.args[0])
        elif isinstance(node, se.floor):
            count = sum(jump is not None for jump in self._found.values())
            whole = se.Symbol("a whole number" + f" {count + 1}" * (count > 0))
            self._found[node.args[0] - whole] = (node, whole)
        elif isinstance(node, se.atan2):
            self._add(node.args[0])
        elif isinstance(node, se.acot):
            self._add(node.args[0], 1)
        elif isinstance(node, se.atan):
            self._add(node.args[0], -1)
        elif isinstance(node, _OPEN):
            rest = 1 - node.args[0] ** 2
            if not self._is_simple(rest):
                self.unclear.setdefault(rest)
        elif isinstance(node, _ESSENTIAL):
            for argument in node.args:
                self._look_at_pole(argument)

    def _look_at_power(self, base: Any, exponent: Any) -> None:
        if base == se.E:
            self._look_at_pole(exponent)
            return
        if isinstance(exponent, se.Integer) or not base.free_symbols & self.moving:
            return
        if not isinstance(exponent, se.Rational) or self._is_simple(base):
            return
        product = self.product(base)
        for h, k in product.powers.items():
            if k % 2 == 0 and h.free_symbols & self.moving:
                self._found.setdefault(h)
        if product.odd.free_symbols & self.moving and not self._is_simple(product.odd):
            self.unclear.setdefault(product.odd)

    def _look_at_pole(self, argument: Any) -> None:
        if self.meets_poles and any(_divides(n) for n in _nodes(argument)):
            for h, k in self.product(argument).powers.items():
                if k < 0 and h.free_symbols & self.moving:
                    self.unclear.setdefault(h)

    def _add(self, inside: Any, side: int = 0) -> None:
        """The zeros (1), the poles (-1), or both, of what stands inside."""
        product = self.product(inside)
        for h, k in product.powers.items():
            if (
                h not in product.roots
                and h.free_symbols & self.moving
                and (not side or side * k > 0)
            ):
                self._found.setdefault(h)

    def _pieces(self, h: Any, whole: Any) -> Iterator[BranchCut]:
        waiting: list[dict[Any, int]] = [{}]
        while waiting:
            assumed = waiting.pop()
            ways = ((1, 1), (-1, -1), (-1, 1))
            above, below, turned = (_Side(self, h, s, a, assumed, whole) for s, a in ways)
            try:
                sides = above(self.expr), below(self.expr), turned(self.expr)
            except _UnknownSign as needed:
                waiting += [{**assumed, needed.expr: s} for s in (1, -1)]
                continue
            both = above.inside.keys() & below.inside.keys()
            edge = any((above.inside[n] + below.inside[n]).expand() == 0 for n in both)
            where = tuple(s * e for e, s in assumed.items())
            yield BranchCut(h, *sides, where, edge, whole and whole[1])


class _UnknownSign(Exception):
    """The sign of an expression decides which branch there is."""

    def __init__(self, expr: Any) -> None:
        super().__init__(str(expr))
        self.expr = expr


@dataclass
class _Side:
    """Rewrites expressions as they are on one side of a cut, arctangents on the one ``angles``;
    near the cut where that ``is_local``, and else wherever h has that sign."""

    branches: Branches
    h: Any
    side: int
    angles: int
    assumed: dict[Any, int]
    floor: Any = None
    is_local: bool = True
    inside: dict[Any, Any] = field(default_factory=dict)
    _known: dict[Any, Any] = field(default_factory=dict)

    @remember("_known")
    def __call__(self, expr: Any) -> Any:
        if not expr.free_symbols & self.branches.moving or not expr.args:
            return expr
        args = [self(a) for a in expr.args]
        if isinstance(expr, se.Pow) and not isinstance(args[1], se.Integer):
            return self._power(expr, *args)
        if isinstance(expr, se.sign):
            return self._sign(args[0])
        if isinstance(expr, se.floor) and self.floor and expr == self.floor[0]:
            return self.floor[1] if self.side > 0 else self.floor[1] - 1
        if isinstance(expr, se.acot):
            return self._angle(1 / args[0])
        if isinstance(expr, se.atan):
            return self._angle(args[0])
        if isinstance(expr, se.atan2):
            return self._turn(*args)
        if isinstance(expr, se.log) and self.is_local:
            k, rest = self._split(args[0])
            if k:
                self.inside[expr] = rest
                return k * self._logarithm + se.log(rest)
        return expr if args == list(expr.args) else expr.func(*args)

    @property
    def _logarithm(self) -> Any:
        """log |h|, the same on both sides."""
        return se.Symbol("logarithm of the distance")

    def _split(self, inside: Any, side: int = 0) -> tuple[int, Any]:
        """(k, s^k u) with g = h^k u: the sign of what is left is that of g."""
        side = side or self.side
        if self.floor or not inside.free_symbols & self.branches.moving:
            return 0, inside
        product = self.branches.product(inside)
        k = product.powers.get(self.h, 0)
        return k, se.Integer(side ** abs(k)) * product.without(self.h) if k else inside

    def _sign(self, inside: Any) -> Any:
        k, rest = self._split(inside)
        return self._assume(rest) if k else se.sign(inside)

    def _assume(self, expr: Any) -> Any:
        """The sign of an expression on this piece of the cut."""
        if expr.is_Number or not self.is_local:
            return se.sign(expr)
        for known, sign in self.assumed.items():
            for turn in (1, -1):
                if (expr - turn * known).expand() == 0:
                    return se.Integer(turn * sign)
        raise _UnknownSign(expr)

    def _power(self, node: Any, base: Any, exponent: Any) -> Any:
        if base == se.E:
            return se.exp(exponent)
        k, rest = self._split(base)
        if not k:
            return base**exponent
        self.inside[node] = rest
        order = k * exponent
        if not self.is_local:
            return (self.side * self.h) ** order * rest**exponent
        if not isinstance(order, se.Rational):
            return se.exp(order * self._logarithm) * rest**exponent
        if isinstance(order, se.Integer):
            return se.Integer(self.side) ** order * self.h**order * rest**exponent
        if order.p % 2 == 0:
            return (self.h**2) ** (order / 2) * rest**exponent
        return (self.side * self.h) ** order * rest**exponent

    def _angle(self, inside: Any) -> Any:
        """atan(g) = pi/2 sign(g) - atan(1/g)."""
        k, rest = self._split(inside, self.angles)
        if k >= 0:
            return se.atan(inside)
        inverse = se.Integer(self.angles**-k) / (self.h**k * rest)
        return HALF_PI * self._assume(rest) - se.atan(inverse)

    def _turn(self, y: Any, x: Any) -> Any:
        """atan2(y, x) = pi sign(y) + atan2(-y, -x) where x < 0; both over a power of |h|."""
        (k, up), (m, right) = self._split(y, self.angles), self._split(x, self.angles)
        least = min(k, m)
        if (not least and not k) or not self.is_local:
            return se.atan2(y, x)
        h = self.angles * self.h
        y, x = h ** (k - least) * up, h ** (m - least) * right
        if k == least or self._assume(x) > 0:
            return se.atan2(y, x)
        return se.pi * self._assume(up) + se.atan2(-y, -x)


def _nodes(expr: Any) -> Iterator[Any]:
    """What an expression is made of, inner parts first, each once."""
    seen: set[Any] = set()
    stack = [(expr, False)]
    while stack:
        node, done = stack.pop()
        if done:
            yield node
        elif node not in seen and node.args:
            seen.add(node)
            stack.append((node, True))
            stack += [(a, False) for a in node.args]


def _is_root(node: Any) -> bool:
    return isinstance(node, se.Pow) and node.args[1] == se.Rational(1, 2)


def _line_in_root(expr: Any) -> tuple[Any, Any, Any] | None:
    """(a, b, r) of a + b r, where r is the only square root in it."""
    roots = [n for n in _nodes(expr) if _is_root(n)]
    if len(roots) != 1:
        return None
    (root,), letter = roots, se.Dummy()
    line = expr.xreplace({root: letter}).expand()
    slope = line.diff(letter)
    if slope == 0 or letter in slope.free_symbols:
        return None
    return line.xreplace({letter: se.Integer(0)}), slope, root


def _divides(node: Any) -> bool:
    powers = isinstance(node, se.Pow) and node.args[0] != se.E
    return (powers and not _is_positive(node.args[1])) or isinstance(
        node, (se.tan, se.cot, se.sec, se.csc, se.coth, se.log)
    )


def _is_positive(exponent: Any) -> bool:
    return isinstance(exponent, se.Rational) and exponent > 0


def is_plain(expr: Any, moving: frozenset[Any], essential: bool) -> bool:
    """Whether an expression is seen to be continuous wherever it is real.

    It is made of roots, powers and functions without a jump, and divides by nothing that moves; or,
    where singularities that are ``essential`` do no harm, it is of one branch.
    """
    if not essential and not has_branches([expr], moving):
        return True
    jumps = (se.sign, se.floor, se.atan2, se.acot, se.log)
    return not any(
        node.free_symbols & moving and (isinstance(node, jumps) or _divides(node))
        for node in _nodes(expr)
    )


def bounds_of(expr: Any, pieces: bool = True) -> list[Any]:
    """The functions that have to be positive for an expression to be real, but for bases under
    letters, which may be whole numbers; without ``pieces`` those in whatever piece is taken."""
    bounds: dict[Any, None] = {}
    for node in _nodes(expr) if pieces else _nodes_of_every_piece(expr):
        if isinstance(node, (se.asin, se.acos, se.atanh)):
            bounds.setdefault(1 - node.args[0] ** 2)
        elif isinstance(node, se.acosh):
            bounds.setdefault(node.args[0] - 1)
        elif isinstance(node, se.log) or (
            isinstance(node, se.Pow)
            and node.args[0] != se.E
            and not isinstance(node.args[1], se.Integer)
            and not node.args[1].free_symbols
        ):
            bounds.setdefault(node.args[0])
    return [*bounds]


def _nodes_of_every_piece(expr: Any) -> Iterator[Any]:
    """Nodes but for those in a product with a sum of signs, as 1 + sign(x), which may be zero."""
    signed = set[Any]()  # found in one pass: to ask each factor for its signs takes a square of it
    for node in _nodes(expr):
        if isinstance(node, se.sign) or not signed.isdisjoint(node.args):
            signed.add(node)
    waiting, known = [expr], set[Any]()
    while waiting:
        node = waiting.pop()
        if node in known:
            continue
        known.add(node)
        yield node
        is_piece = isinstance(node, se.Mul) and any(
            isinstance(factor, se.Add) and factor in signed for factor in node.args
        )
        waiting += () if is_piece else node.args


def branch_arguments(expr: Any, moving: frozenset[Any]) -> dict[Any, bool]:
    """Functions of which an expression is analytic wherever none is zero or infinite; and whether
    it is real only where they are not negative, since they stand under roots alone.

    A logarithm adds none: where it is real on both sides of a place, it is the same function there.
    """
    arguments: dict[Any, bool] = {}
    for node in _nodes(expr):
        if not is_branching(node) or isinstance(node, (se.log, se.atanh)):
            continue
        is_root = isinstance(node, se.Pow)
        for inside in node.args[:1] if is_root else node.args:
            if isinstance(node, se.floor):
                inside = se.sin(se.pi * inside)
            elif isinstance(node, _OPEN):
                inside = 1 - inside**2
            if inside.free_symbols & moving:
                arguments[inside] = is_root and arguments.get(inside, True)
    return arguments


def has_branches(exprs: Iterable[Any], moving: frozenset[Any]) -> bool:
    """Whether one of some expressions has more branches than one, or may be not real."""
    nodes = (node for expr in exprs for node in _nodes(expr))
    return any(is_branching(node) and node.free_symbols & moving for node in nodes)


def is_branching(node: Any) -> bool:
    """Whether a function or power itself has more branches than one, or may be not real."""
    is_root = isinstance(node, se.Pow) and not isinstance(node.args[1], se.Integer)
    return is_root or isinstance(node, _MANY)
