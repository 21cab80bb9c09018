"""Where right-hand sides are not smooth: signs, absolute values, floors, cuts of angles.

Such a function is smooth on either side of a switching surface g = 0 (a floor: of every whole g).
Here it is found, and replaced by what it is on one side.  Roots of squares are absolute values in
disguise, (h^2 u)^r = |h|^(2r) u^r, and become such first, as do inverse functions with corners and
jumps,

    asin(g) = atan2(g, sqrt(1 - g^2)),    atan(n/d) = atan2(n sign(d), |d|);

derivatives of signs and floors vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from math import exp, inf
from typing import Any

import symengine as se

from voronec.algebra.factors import irreducible_factors
from voronec.algebra.generators import TRIGONOMETRIC
from voronec.algebra.graphs import is_flat, nodes
from voronec.algebra.memo import remember
from voronec.algebra.numeric_functions import formula
from voronec.algebra.ring import Ring
from voronec.algebra.roots import known_sign
from voronec.algebra.terms import factors_of, is_exponential, rational, summands
from voronec.errors import EngineLimit

SATURATION = se.Integer(17)
"""tanh w is flat to rounding for |w| a little beyond this: there a series knows nothing of what is
to come, and a step as long as it allows would go over all of it."""
FLAT = 0.59
"""tanh w is flat to a tolerance tol where |w| is greater than so many times -log(tol), which is
(1 + 0.6 log(e/2))/2, rounded: the order of a series is 0.6 times -log(tol)."""
LITTLE = 1e-6
"""A number beside squares is seen from far where it is larger than this part of their largest."""
LONG = 100
"""Radicands of more operations are not searched for squares."""
WITH_SIGN = (se.asin, se.atan, se.atan2, se.tanh, se.sinh, se.asinh)
"""Functions that have the sign of their argument, an angle of y that of atan2(y, x)."""
_CORNERS = (
    se.sign, se.Abs, se.floor, se.atan2, se.Derivative, se.Subs, se.asin, se.acos, se.acosh,
    se.atan, se.acot,
)  # fmt: skip
_STEEP = (se.tanh, se.sinh, se.cosh)


@dataclass(frozen=True)
class Switch:
    """Where ``function`` vanishes, or, of a floor (``whole``), where it is any whole number.

    One that is ``fixed`` holds nothing that moves but ``floors``, symbols of other switching
    surfaces: it is nowhere met, and its sign may be zero.
    """

    function: Any
    whole: bool = False
    floors: frozenset[Any] = frozenset()
    fixed: bool = False


@dataclass
class Sides:
    """Rewrites expressions as they are on given sides of switching surfaces.

    ``side`` is asked for 1 or -1 at each switching surface of a sign; a floor becomes a symbol of
    its own, given by ``number``.  ``switches`` are those that were met; ``still`` symbols
    alone make none. Of radicands that are ``cusps`` the absolute value is taken.  tanh w is the
    same on all sides of its switching surfaces, |w| = ``saturated``, and half of that, within which
    squares of 1 - |tanh w| are not flat either; they keep a step from going over it.  So are
    cosh w, sinh w and exp 2 w, and a root whose corner a constant rounds.
    """

    side: Callable[[Switch], int]
    number: Callable[[Switch], Any]
    still: frozenset[Any] = frozenset()
    cusps: frozenset[Any] = frozenset()
    saturated: Any = SATURATION
    switches: dict[Switch, None] = field(default_factory=dict)
    _known: dict[Any, Any] = field(default_factory=dict)
    _floors: set[Any] = field(default_factory=set)

    @remember("_known")
    def __call__(self, expr: Any) -> Any:
        """The expression on the sides."""
        if not expr.args:
            return expr
        if isinstance(expr, (se.sin, se.cos)):
            return expr.func(self._angle_argument(expr.args[0]))
        args = [self(a) for a in expr.args]
        if isinstance(expr, (se.sign, se.Abs)):
            side = self._side(args[0])
            return side if isinstance(expr, se.sign) else side * args[0]
        if isinstance(expr, se.floor) and not args[0].free_symbols <= self.still:
            switch = self._switch(args[0], True)
            floor = self.number(switch)
            self._floors |= floor.free_symbols
            return floor
        if isinstance(expr, se.atan2):
            return self._angle(*args)
        if isinstance(expr, se.Pow) and expr.args[0] in self.cusps and _is_root(expr):
            return se.Abs(args[0]) ** args[1]
        if isinstance(expr, (se.tanh, se.sinh, se.cosh)):
            self._watch(args[0])
        elif is_exponential(expr):
            self._watch(args[1] / 2)
        elif isinstance(expr, se.Pow) and _is_root(expr):
            self._watch_rounding(args[0])
        return expr if args == list(expr.args) else expr.func(*args)

    def _watch(self, argument: Any) -> None:
        if not argument.free_symbols <= self.still:
            for end in (self.saturated, self.saturated / 2):
                self._side(argument - end)
                self._side(argument + end)

    def _watch_rounding(self, radicand: Any) -> None:
        """The place where the squares in a radicand are 1/sqrt(tol) times its constant: beyond, a
        series does not see the constant, which rounds the corner of the root."""
        moving, constant = rounding(radicand, self.still) or (se.Integer(0), se.Integer(0))
        beyond = se.Integer(round(exp(self.saturated / (2 * FLAT))))
        if moving != 0:
            self._side(moving - beyond * constant)

    def _side(self, function: Any) -> Any:
        if function.free_symbols <= self.still:
            return se.sign(function)
        if isinstance(function, se.Mul):
            return se.Mul(*map(self._side, function.args))
        if isinstance(function, WITH_SIGN):
            return self._side(function.args[0])
        if isinstance(function, se.Pow) and isinstance(function.args[1], se.Rational):
            below, exponent = function.args
            return self._side(below) if exponent.p % 2 and exponent.q % 2 else se.Integer(1)
        if isinstance(function, se.Add) and int(se.count_ops(function)) <= LONG:
            flat = function.expand()  # min(x, 1) - 1 is zero where x is greater
            if flat.free_symbols <= self.still:
                return se.sign(flat)
        if (factors := switch_factors(function)) is not None:
            return se.Mul(*map(self._side, factors))
        return se.Integer(self.side(self._switch(function)))

    def _switch(self, function: Any, whole: bool = False) -> Switch:
        """A switching surface that is met, with the floors in it."""
        moving = function.free_symbols - self.still
        floors = frozenset(moving & self._floors)
        switch = Switch(function, whole, floors, floors == moving)
        self.switches.setdefault(switch)
        return switch

    def _angle(self, y: Any, x: Any) -> Any:
        """atan2(y, x), which jumps where y = 0 > x: there it is +-pi + atan2(-y, -x)."""
        right = self._side(x)
        if not right.is_Number or right >= 0:
            return se.atan2(y, x)
        return self._side(y) * se.pi + se.atan2(-y, -x)

    def _angle_argument(self, expr: Any) -> Any:
        """The argument of a sine: whole turns of an angle in it are nothing."""
        terms = summands(expr)
        return se.Add(*[self._turn(t) for t in terms])

    def _turn(self, term: Any) -> Any:
        factors = factors_of(term)
        plain = [f for f in factors if not isinstance(f, se.atan2)]
        if len(plain) + 1 == len(factors) and all(isinstance(f, se.Integer) for f in plain):
            angle = next(f for f in factors if isinstance(f, se.atan2))
            return se.Mul(*plain, se.atan2(*map(self, angle.args)))
        return self(term)


def has_switches(exprs: Iterable[Any], still: Iterable[Any] = ()) -> bool:
    """Whether one of some expressions, with plain roots, is not smooth; ``still`` are symbols that
    do not move."""
    met = Sides(lambda _: 1, lambda _: se.Integer(0), frozenset(still))
    for expr in exprs:
        met(se.sympify(expr))
        if met.switches:
            return True
    return False


def radicands(exprs: Iterable[Any], among: frozenset[Any]) -> list[Any]:
    """The radicands in expressions that hold one of some symbols."""
    bases: dict[Any, None] = {}
    for node in nodes(map(se.sympify, exprs)):
        if isinstance(node, se.Pow) and _is_root(node) and node.args[0].free_symbols & among:
            bases.setdefault(node.args[0])
    return list(bases)


def rounding(
    radicand: Any, still: frozenset[Any], little: float = LITTLE
) -> tuple[Any, Any] | None:
    """(squares that move, constant) of a radicand that is the sum of both; None of any other, and
    where the constant is a number that is not ``little``."""
    terms = radicand.args if isinstance(radicand, se.Add) else ()
    constant = se.Add(*[e for e in terms if e.free_symbols <= still])
    moving = [e for e in terms if not e.free_symbols <= still]
    if constant == 0 or not moving or not all(map(_is_unbounded_square, moving)):
        return None
    factors = [f for e in moving for f in (e.args if isinstance(e, se.Mul) else ()) if f.is_Number]
    if constant.is_Number and constant > little * max([1, *factors]):
        return None
    return se.Add(*moving), constant


def _is_unbounded_square(term: Any) -> bool:
    """Whether a term is a square at sight, up to a number, and no function of an angle."""
    factors = factors_of(term)
    if any(f.is_Number and f < 0 for f in factors) or term.atoms(se.Function):
        return False
    powers = [f for f in factors if not f.is_Number]
    return all(
        isinstance(f, se.Pow) and f.args[1].is_Integer and f.args[1] % 2 == 0 for f in powers
    )


def _is_root(power: Any) -> bool:
    return isinstance(power.args[1], se.Rational) and power.args[1].q != 1


def is_rough(
    assignments: Iterable[tuple[Any, Any]],
    results: Iterable[Any],
    still: Iterable[Any],
    velocities: Iterable[Any] = (),
    steep: bool = True,
) -> bool:
    """Whether straight-line code may have switching surfaces, or a root of velocities, or, where
    asked for, what is smooth but ``steep``; at the cost of a look at each of its nodes."""
    meaning = dict(assignments)
    fixed, moving = frozenset(still), set(velocities)
    for name, expr in meaning.items() if moving else ():
        if expr.free_symbols & moving:
            moving.add(name)
    for node in nodes([*meaning.values(), *map(se.sympify, results)]):
        plain = formula(node)
        node = node if plain is None else plain
        if isinstance(node, _CORNERS) or (steep and isinstance(node, _STEEP)):
            return True
        if steep and is_exponential(node) and not node.free_symbols <= fixed:
            return True
        if isinstance(node, se.Pow) and _is_root(node):
            base, exponent = node.args
            if rounding(_inside(base, meaning), fixed, LITTLE if steep else inf):
                if steep:
                    return True
                continue
            if base.free_symbols & moving:
                return True
            power = _inside(base, meaning) ** exponent
            if plain_roots(power, fixed) != power:
                return True
    return False


def write_roots_out(
    exprs: Iterable[Any], meaning: Mapping[Any, Any], still: frozenset[Any]
) -> dict[Any, Any]:
    """Roots of squares that are seen in what the names in them mean alone, written out."""
    written = {}
    for node in nodes(map(se.sympify, exprs)) if meaning else ():
        if isinstance(node, se.Pow) and _is_root(node) and node.free_symbols & meaning.keys():
            power = _inside(node.args[0], meaning) ** node.args[1]
            if plain_roots(power, still) != power:
                written[node] = power
    return written


def _inside(expr: Any, meaning: Mapping[Any, Any]) -> Any:
    """An expression with the names in it spelled out, as far as it stays short."""
    while expr.free_symbols & meaning.keys():
        longer = expr.xreplace(meaning)
        if int(se.count_ops(longer)) > LONG:
            break
        expr = longer
    return expr


def plain_roots(
    expr: Any, still: frozenset[Any] = frozenset(), known: dict[Any, Any] | None = None
) -> Any:
    """The expression with roots of squares as absolute values, and flat derivatives as zero.

    Squares of ``still`` symbols alone stay under their roots.
    """
    known = {} if known is None else known
    plain = known.get(expr)
    if plain is None:
        plain = known[expr] = _plain(expr, still, known)
    return plain


def _plain(expr: Any, still: frozenset[Any], known: dict[Any, Any]) -> Any:
    if not expr.args:
        return expr
    if is_flat(expr):
        return se.Integer(0)
    if isinstance(expr, (se.FunctionSymbol, se.Derivative, se.Subs)):
        return expr
    args = [plain_roots(a, still, known) for a in expr.args]
    if isinstance(expr, se.Pow) and isinstance(args[1], se.Rational) and args[1].q != 1:
        root, rest = square_part(args[0])
        factors = factors_of(root)
        kept = se.Mul(*[f for f in factors if f.free_symbols <= still])
        if kept != root:
            return _size(root / kept, 2 * args[1]) * (rest * kept**2) ** args[1]
    if isinstance(expr, (se.asin, se.acos, se.acosh)):
        return _arcsine(expr.func(*args), still)
    if isinstance(expr, (se.atan, se.acot)):
        return _arctangent(expr.func(*args), still)
    return expr if args == list(expr.args) else expr.func(*args)


def _arcsine(expr: Any, still: frozenset[Any]) -> Any:
    """asin(g), acos(g) or acosh(g), by the angle of (g, sqrt(1 - g^2)) or the inverse sine of
    sqrt(g^2 - 1), where that root has corners."""
    argument = expr.args[0]
    square = se.Mul(*map(_square, factors_of(argument)))
    root, rest = square_part(square - 1 if isinstance(expr, se.acosh) else 1 - square)
    if root.free_symbols <= still:
        return expr
    size = se.Abs(root) * se.sqrt(rest)
    if isinstance(expr, se.acosh):
        return se.asinh(size)
    angle = se.atan2(argument, size)
    return angle if isinstance(expr, se.asin) else se.pi / 2 - angle


def _square(factor: Any) -> Any:
    if isinstance(factor, se.sign):
        return se.Integer(1)
    if isinstance(factor, se.Abs):
        return factor.args[0] ** 2
    return factor.args[0] ** (2 * factor.args[1]) if isinstance(factor, se.Pow) else factor**2


def _arctangent(expr: Any, still: frozenset[Any]) -> Any:
    """atan(n/d) or acot(d/n), by the angle of (n sign(d), |d|) where d may vanish."""
    quotient = se.Mul(*map(_in_sines, factors_of(expr.args[0])))
    above, below = quotient.as_numer_denom()
    if isinstance(expr, se.acot):
        above, below = below, above
    powers = [(f.args if isinstance(f, se.Pow) else (f, 1)) for f in factors_of(below)]
    odd = se.Mul(*[b for b, e in powers if not (isinstance(e, se.Integer) and e % 2 == 0)])
    sign = known_sign(odd, strict=True)
    if below.free_symbols <= still or (odd == below and sign):
        return expr
    side = sign or se.sign(odd)
    return se.atan2(above * side, below * side)


def _in_sines(factor: Any) -> Any:
    """A tangent or cotangent as a quotient that tells where it is infinite."""
    if isinstance(factor, se.tan):
        return se.sin(*factor.args) / se.cos(*factor.args)
    return se.cos(*factor.args) / se.sin(*factor.args) if isinstance(factor, se.cot) else factor


def _size(expr: Any, exponent: Any) -> Any:
    """|expr|^exponent, so that it divides where powers of the expression do."""
    if exponent.q != 1:
        return se.Abs(expr) ** exponent
    power = expr**exponent
    return power if exponent.p % 2 == 0 else power * se.sign(expr)


@lru_cache(maxsize=256)
def switch_factors(function: Any) -> tuple[Any, ...] | None:
    """Factors with the sign of a sum, where it has several: (a x)^2 - 1 has two zeros so close
    together that a step sees neither, a x - 1 and a x + 1 have one each.  None where the sum is
    better left as it is."""
    if not isinstance(function, se.Add) or int(se.count_ops(function)) > LONG:
        return None
    try:
        ring = Ring([function])
        value = ring.fraction(function)
        content, factors = irreducible_factors(value.num)
        below = ring.polynomial(ring.field.denominator(value.den))
    except EngineLimit:
        return None
    odd = [*(ring.polynomial(poly) for poly, e in factors if e % 2), below]
    if len(factors) < 2 or any(f.atoms(se.Abs, se.sign) for f in odd):
        return None
    signs = [1 if content > 0 else -1, *(known_sign(f, strict=True) or f for f in odd)]
    return tuple(map(se.sympify, signs))


@lru_cache(maxsize=256)
def square_part(base: Any) -> tuple[Any, Any]:
    """(h, u) with h^2 u = base; h = 1 where no square is found in it."""
    one = se.Integer(1)
    if isinstance(base, (se.Mul, se.Pow)):
        roots, rest = [], []
        for factor in factors_of(base):
            below, exponent = factor.args if isinstance(factor, se.Pow) else (factor, one)
            inner, left = (one, one) if factor.is_Number else square_part(below)
            if factor.is_Number or not isinstance(exponent, se.Integer):
                rest.append(factor)
            elif exponent % 2 == 0:
                roots.append(below ** (exponent / 2))
            else:
                roots.append(below ** ((exponent - 1) / 2) * inner)
                rest.append(left if inner != 1 else below)
        return se.Mul(*roots), se.Mul(*rest)
    if isinstance(base, se.Add) and base.free_symbols and int(se.count_ops(base)) < LONG:
        # the sine of a sum, or of 9 x, is one of an angle, and not what its theorem makes of it
        angles = {f.args[0] for f in base.atoms(*TRIGONOMETRIC) if f.args[0].args}
        back = {se.Symbol(f"angle {i}"): a for i, a in enumerate(sorted(angles, key=str))}
        short = base.subs({a: name for name, a in back.items()})
        for whole in dict.fromkeys((short, base)):
            try:
                root, rest = _square_factor(whole)
            except EngineLimit:
                continue
            if root != 1:
                return root.xreplace(back), rest.xreplace(back)
    return one, base


def _square_factor(base: Any) -> tuple[Any, Any]:
    """The square part of a sum, by its factors; 1 -+ cos a and 1 -+ sin a are twice the square of a
    sine or cosine."""
    ring = Ring([base])
    value = ring.fraction(base)
    content, factors = irreducible_factors(value.num)
    halves = []
    for angle, (c, s) in ring.pairs.items():
        half = angle / (2 * ring.found.angles[angle])
        halves += [(1 - c, se.sin(half)), (1 + c, se.cos(half))]
        halves += [(1 - s, se.sin(se.pi / 4 - half)), (1 + s, se.sin(se.pi / 4 + half))]
    root, rest = se.Integer(1), rational(content)
    for poly, e in factors:
        expr = ring.polynomial(poly)
        twice = next(((h, k) for g, h in halves for k in (1, -1) if expr == (k * g).expand()), None)
        if twice is not None:
            root, rest = root * twice[0] ** e, rest * (2 * twice[1]) ** e
            continue
        root, rest = root * expr ** (e // 2), rest * expr ** (e % 2)
    if root == 1 or (rest.is_Number and rest < 0):
        return se.Integer(1), base
    return root, rest / ring.polynomial(ring.field.denominator(value.den))
