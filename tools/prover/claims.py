"""Claims and relations for the attack on the prover, of systems whose motions are written out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from random import Random
from typing import Any

import mpmath as mp
import sympy as sp

import voronec as vo
from prover.catalogue import catalogue
from prover.identities import Letters, mutate
from prover.relations import catalogue_relation
from prover.truth import APART, Outside, Statement, number, slope
from voronec.proof.claims import check_claims

x, y, z, q, w = sp.symbols("x y z q w")
X, Y, Z = (vo.velocity(s) for s in (x, y, z))
m, k, c = sp.symbols("m k c")
HALF = sp.Rational(1, 2)
LARGEST = mp.mpf(10) ** 6
"""Where a function is larger than this, the difference says nothing of its rate."""
HALF_MP = mp.mpf(1) / 2


@dataclass(frozen=True)
class Subject:
    """A system, the rates of its state, integrals and further functions to build claims of."""

    system: vo.System
    rates: Mapping[Any, Any]
    integrals: tuple[Any, ...]
    functions: tuple[Any, ...]


def _system(name: str, base: Any, lagrangian: Any, letters: Any, **rest: Any) -> vo.System:
    fibre = rest.pop("fibre", ())
    parameters = tuple(vo.Parameter(s, positive=True) for s in letters)
    fibration = vo.Fibration(base=base, fibre=fibre)
    return vo.System(
        name=name, fibration=fibration, lagrangian=lagrangian, parameters=parameters, **rest
    )


@lru_cache
def made_systems() -> tuple[Subject, ...]:
    """An oscillator, a free particle, two masses on springs, a skate, a knife on a slope."""
    line = m * X**2 / 2 - k * x**2 / 2
    plane = m * (X**2 + Y**2) / 2
    height = plane - k * (x**2 + y**2) / 2
    quartic = X**2 / 2 - x**4 / 4
    skate = (X**2 + Y**2 + Z**2) / 2
    energy, turn = m * X**2 + k * x**2, x * Y - y * X
    return (
        Subject(_system("spring", (x,), line, (m, k)), {x: X, X: -k * x / m}, (energy,), (x, X)),
        Subject(
            _system("free", (x, y), plane, (m,)), {x: X, y: Y, X: 0, Y: 0},
            (X, Y, turn), (x, y, X, Y),
        ),
        Subject(
            _system("isotropic", (x, y), height, (m, k)),
            {x: X, y: Y, X: -k * x / m, Y: -k * y / m},
            (energy, m * Y**2 + k * y**2, turn, m * X * Y + k * x * y), (x, y, X, Y),
        ),
        Subject(
            _system("quartic", (x,), quartic, ()), {x: X, X: -(x**3)}, (2 * X**2 + x**4,), (x, X)
        ),
        Subject(
            _system("tilted", (x, y), skate, (), fibre=(z,), constraints=(Z - y * X,)),
            {x: X, y: Y, X: -y * X * Y / (1 + y**2), Y: 0},
            (Y, (1 + y**2) * X**2, X * sp.sqrt(1 + y**2), (1 + y**2) * X**2 + Y**2), (x, y, X, Y),
        ),
    )  # fmt: skip


# -- truth along motions ------------------------------------------------------------------


def rate_along(function: Any, rates: Mapping[Any, Any], at: Mapping[Any, Any]) -> Any:
    """dF/dt at a state, along the rates."""
    return slope(function, at, {s: number(r, at) for s, r in rates.items()})


def holds_along(function: Any, rate: Any, made: Subject, dice: Random) -> bool | None:
    """Whether dF/dt = G at states in all orthants; None where F is nowhere real."""
    symbols = [*made.rates, *(p.symbol for p in made.system.parameters)]
    tried = 0
    with mp.workdps(60):
        for _ in range(60):
            at = {s: mp.mpf(dice.randint(-300, 300)) / 97 for s in symbols}
            at |= {p.symbol: abs(at[p.symbol]) + HALF_MP for p in made.system.parameters}
            try:
                if abs(number(function, at)) > LARGEST:
                    continue
                found, said = rate_along(function, made.rates, at), number(rate, at)
            except (Outside, ZeroDivisionError, OverflowError):
                continue
            tried += 1
            if abs(found - said) > APART * (1 + abs(found) + abs(said)):
                return False
    return True if tried else None


def claim(dice: Random, family: str, declared: bool, true: bool) -> Statement | None:
    """A claim about a motion, true or false."""
    return CLAIMS[family](dice, declared, true)


def _question(system: vo.System, kind: str, value: Any) -> Callable[[], Any]:
    def ask() -> Any:
        if kind == "measure":
            stated = replace(system, measure=value)
        elif kind == "integral":
            stated = replace(system, integrals={"claimed": value})
        else:
            stated = replace(system, equations={"claimed": value})
        return check_claims(stated)[0].verdict

    return ask


def _tell(system: vo.System, kind: str, value: Any) -> str:
    return f"{system.name}: {kind} {value}"


def _compose(dice: Random, parts: tuple[Any, ...], true: bool) -> Any:
    """A function of integrals; a kink of it harms nobody."""
    a, b = dice.choice(parts), dice.choice(parts)
    return dice.choice(
        (
            a * b, a**2 + b, sp.sin(a), a / (1 + b**2), sp.sqrt(1 + a**2), sp.exp(a) * b,
            sp.atan(a) + b, sp.Abs(a), sp.sqrt(a**2) * b, sp.log(1 + a**2), sp.cos(a / 2) ** 2,
            sp.Max(a, b), a**3 - b,
        )
    )  # fmt: skip


def integral(dice: Random, declared: bool, true: bool) -> Statement | None:
    """Functions of integrals, the same with a coefficient or a sign changed."""
    made = dice.choice(made_systems())
    function = _compose(dice, made.integrals, true)
    if true and dice.random() < 0.5:
        function = function + _nothing(dice, made)
    if not true:
        letters = tuple(p.symbol for p in made.system.parameters)
        function = mutate(Letters(dice, declared, letters, made.functions), function)
        if dice.random() < 0.2:  # constant on one level of an integral alone
            function = (dice.choice(made.integrals) - dice.randint(0, 3)) * dice.choice(
                made.functions
            )
    return _verify(made, "integral", function, 0, dice, true)


def _nothing(dice: Random, made: Subject) -> Any:
    """An expression that vanishes, not at sight."""
    f = dice.choice(made.functions)
    letters = [p.symbol for p in made.system.parameters]
    identities = [
        sp.sin(f) ** 2 + sp.cos(f) ** 2 - 1,
        sp.Abs(f) ** 2 - f**2,
        sp.sin(2 * f) - 2 * sp.sin(f) * sp.cos(f),
        sp.sqrt(1 + f**2) ** 3 - (1 + f**2) * sp.sqrt(1 + f**2),
    ]
    if len(letters) > 1:
        p, r = letters[:2]
        identities += [
            (sp.sqrt(p * r) - sp.sqrt(p) * sp.sqrt(r)) * f,
            (sp.sqrt(p / r) * r - sp.sqrt(p * r)) * f,
            (sp.sqrt(p**2 + 2 * p * r + r**2) - p - r) * f,
            (sp.log(p * r) - sp.log(p) - sp.log(r)) * f,
            sp.sqrt(p * r) * f - p * sp.sqrt(r / p) * f,
        ]
    return dice.choice(identities)


def equation(dice: Random, declared: bool, true: bool) -> Statement | None:
    """The rate of a function, by the chain rule, rewritten or changed."""
    made = dice.choice(made_systems())
    f, g = dice.choice(made.functions), dice.choice(made.functions)
    function = dice.choice((f, f * g, sp.sin(f), sp.sqrt(1 + f**2), sp.exp(f) * g, f**2 - g))
    rate = sum(sp.diff(function, s) * r for s, r in made.rates.items())
    rate = sp.sympify(rate) + (_nothing(dice, made) if true else 0)
    if not true:
        letters = tuple(p.symbol for p in made.system.parameters)
        rate = mutate(Letters(dice, declared, letters, made.functions), rate)
        rate = dice.choice((rate, rate, sp.Abs(rate), rate * sp.sign(f)))
    return _verify(made, "equation", function, rate, dice, true)


def _verify(
    made: Subject, kind: str, function: Any, rate: Any, dice: Random, true: bool
) -> Statement | None:
    """The statement, where its truth is what the numbers say along motions."""
    if not sp.sympify(function).free_symbols & set(made.rates):
        return None
    if any(e.has(sp.zoo, sp.nan, sp.I) for e in map(sp.sympify, (function, rate))):
        return None
    if holds_along(function, rate, made, dice) is not true:
        return None
    value = function if kind == "integral" else vo.Equation((function,), (rate,))
    text = _tell(made.system, kind, value)
    return Statement(f"{kind}s", text, true, _question(made.system, kind, value))


def cuts(dice: Random, declared: bool, true: bool) -> Statement | None:
    """Jumps at states that motions pass: false; at states that stay apart: true."""
    spring, free, isotropic, quartic, _ = made_systems()
    n = sp.Rational(dice.randint(1, 40), 4)
    made, s = dice.choice(((spring, x), (quartic, x), (free, x), (isotropic, y)))
    kept = dice.choice(made.integrals)
    jump = dice.choice((sp.sign(s - n), sp.sqrt((s - n) ** 2) / (s - n), sp.floor(s / n)))
    wrong = (
        jump, kept * (1 + jump), kept + jump / 3, sp.atan(sp.tan(n * s)) - n * s,
        sp.asin(sp.sin(s)) - s if made is free else jump, sp.Heaviside(s - n) * kept,
        sp.exp(jump) * kept, sp.Abs(kept) * jump,
    )  # fmt: skip
    right = (
        sp.sign(kept), sp.Abs(kept), kept * sp.sign(kept**2 + 1), sp.floor(kept / n),
        sp.sqrt(kept**2) / kept, sp.Abs(kept - n), sp.sign(X) * X if made is free else kept,
    )  # fmt: skip
    function = dice.choice(right if true else wrong)
    text = _tell(made.system, "integral", function)
    return Statement("cuts", text, true, _question(made.system, "integral", function))


def measures(dice: Random, declared: bool, true: bool) -> Statement | None:
    """Densities: functions of integrals where a volume is kept, and others."""
    made = dice.choice(made_systems()[:4])
    density = _compose(dice, made.integrals, True) ** 2 + 1
    if not true:
        letters = tuple(p.symbol for p in made.system.parameters)
        density = mutate(Letters(dice, declared, letters, made.functions), density)
    if not density.free_symbols & set(made.rates) or density.has(sp.zoo, sp.nan, sp.I):
        return None
    if holds_along(density, 0, made, dice) is not true:
        return None
    text = _tell(made.system, "measure", density)
    return Statement("measures", text, true, _question(made.system, "measure", density))


# -- relations ----------------------------------------------------------------------------


@lru_cache
def unit() -> vo.System:
    """The oscillator q'' = -w^2 q, to which others are taken."""
    Q = vo.velocity(q)
    return _system("unit", (q,), (Q**2 - w**2 * q**2) / 2, (w,))


def relation(dice: Random, family: str, declared: bool, true: bool) -> Statement | None:
    """A map of an oscillator or of a free particle to the unit oscillator or to itself; or one of
    the catalogue."""
    if family == "catalogue relations":
        return catalogue_relation(dice, family, declared, true)
    if dice.random() < 0.25:
        return _limit(dice, true)
    spring = made_systems()[0].system
    n = sp.Rational(dice.randint(1, 9), dice.randint(1, 4))
    omega = dice.choice(
        (sp.sqrt(k / m), sp.sqrt(k) / sp.sqrt(m), sp.sqrt(k * m) / m, k / sp.sqrt(k * m))
    )
    Q = vo.velocity(q)
    turned = x * sp.cos(n) + X / omega * sp.sin(n)
    state = {q: dice.choice((x, n * x, -x, X, X * omega, turned, sp.sqrt(k) * x))}
    clock, parameter = sp.Integer(1), {w: omega}
    if dice.random() < 0.3:
        clock, parameter = n, {w: omega / n}
    if not true:
        wrong = dice.randrange(6)
        if wrong == 0:
            parameter = {w: mutate(Letters(dice, declared, (k, m), (k, m)), parameter[w])}
        elif wrong == 1:
            clock = clock + dice.choice((1, -HALF, n))
        elif wrong == 5:  # a parameter that changes
            held = dice.choice((x, X, x * X, sp.sqrt(1 + x**2), m * X**2 - k * x**2))
            parameter = {w: omega + n * held}
        elif wrong == 2:  # a bounce
            state = {q: dice.choice((sp.sqrt(x**2), sp.Abs(n * x), sp.Max(x, -x) / n))}
        elif wrong == 3:
            state = {q: x**2 if dice.random() < 0.5 else x + n}
        else:
            state, wrong_rate = {q: n * x, Q: X}, n
            if clock == wrong_rate:
                return None
    if _is_relation(state, parameter, clock, dice) is not true:
        return None
    held = vo.Relation("spring", "unit", state=state, parameters=parameter, clock=clock)
    text = f"spring -> unit: state {state}, parameters {parameter}, clock {clock}"
    return Statement(
        "relations", text, true,
        lambda: vo.check_relation(held, systems=(spring, unit())).verdict,
    )  # fmt: skip


def _limit(dice: Random, true: bool) -> Statement:
    """A quartic spring that becomes a linear one, in an order that is right or too high."""
    small = sp.Symbol("eps")
    power, extra = dice.randint(1, 3), sp.Rational(dice.randint(1, 9), 2)
    order = dice.randint(1, power) if true else power + dice.randint(1, 2)
    line = m * X**2 / 2 - k * x**2 / 2 - c * x ** dice.choice((3, 4))
    bent = _system("bent", (x,), line, (m, k, c))
    spring = made_systems()[0].system
    held = vo.Relation(
        "bent", "spring", state={x: x}, parameters={m: m, k: k},
        limit=vo.Limit(small, {c: extra * small**power}, order),
    )  # fmt: skip
    text = f"{line} -> spring: c = {extra * small**power}, order {order}"
    return Statement(
        "limits", text, true, lambda: vo.check_relation(held, systems=(bent, spring)).verdict
    )


def _is_relation(state: Any, parameter: Any, clock: Any, dice: Random) -> bool | None:
    """q' = nu Q and Q' = -nu w^2 q, and nothing jumps: by differences along the motion."""
    made = made_systems()[0]
    position = sp.sympify(state[q])
    if position.has(sp.Abs, sp.Max) or position == sp.sqrt(x**2):
        return False  # the velocity jumps
    omega = parameter[w]
    if omega.has(sp.zoo, sp.nan, sp.I):
        return None
    if not omega.free_symbols <= {k, m}:
        return holds_along(omega, sp.Integer(0), made, dice)
    velocity = state.get(vo.velocity(q))
    if velocity is None:
        velocity = sum(sp.diff(position, s) * r for s, r in made.rates.items()) / clock
    pairs = ((position, clock * velocity), (velocity, -clock * omega**2 * position))
    found = [holds_along(f, g, made, dice) for f, g in pairs]
    return None if None in found else all(found)


CLAIMS: dict[str, Callable[[Random, bool, bool], Statement | None]] = {
    "integrals": integral,
    "equations": equation,
    "cuts": cuts,
    "measures": measures,
    "catalogue": catalogue,
}
KINDS = {
    "claims": (claim, tuple(CLAIMS)),
    "relations": (relation, ("relations", "catalogue relations")),
}
