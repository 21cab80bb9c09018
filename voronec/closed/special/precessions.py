"""Regular precessions: the motions on which the variable of the quadratures is constant.

The quartic f has a double root there, f(x) = f'(x) = 0.  With the rate w of one angle given at x,
these are three equations for the constants of the motion, and each is linear in one of them after
those before it are solved; so the whole family is rational in x and w.

Another route than the quartic: nothing here uses it.

At a pole the contact stays where the variable has an end of its range: there f(c) = -4 w^2 with the
weight w of the pole c, so w = 0 and f'(c) = 0; both are linear in a constant, and one constant is
left.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.arguments import VALUES, accepts
from voronec.algebra.factors import in_factors
from voronec.algebra.normal import quotient, shorten, shortest
from voronec.algebra.symbols import velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.text import as_expression
from voronec.algebra.verdicts import Verdict, prove_equal
from voronec.closed.arithmetic import exact
from voronec.closed.problem import known_parameters, number, quadratures_of, read_parameters
from voronec.closed.space import turned_upright
from voronec.closed.special.stability import Stability, decide_stability
from voronec.declaration.quadratures import Quadratures, Space
from voronec.declaration.reading import quote
from voronec.declaration.scene import Scene
from voronec.declaration.system import System
from voronec.equations.motions import Motions
from voronec.errors import DefinitionError, EngineLimit


def scene_of(
    family: Precessions, at: Mapping[Any, sp.Expr], aside: sp.Expr, times: tuple[float, float]
) -> Scene:
    """Initial data at a point of the family; ``aside`` is the velocity of the variable."""
    quadratures = family.quadratures
    meaning = quadratures.meaning
    if not isinstance(meaning, sp.cos) or not meaning.args[0].is_Symbol:
        raise DefinitionError(f"'{meaning}' is not the cosine of a coordinate: no scene is made")
    (angle,) = meaning.args
    x = at[family.place]
    sine = sp.sqrt(1 - x**2)
    turning = {velocity(q): e.xreplace(dict(at)) for q, e in _angle_rates(family).items()}
    constants = {c: e.xreplace(dict(at)) for c, e in family.constants.items()}
    here = {velocity(angle): -aside / sine, family.place: x, **constants, **turning, **at}
    state: dict[Any, Any] = {angle: sp.acos(x)}
    for name, expr in quadratures.velocities.items():
        value = expr.subs({sp.cos(angle): x, sp.sin(angle): sine}).xreplace(here)
        state[name] = sp.expand(value)  # so that what is zero reads so
    if quadratures.space is not None:
        state |= upright(quadratures.space, {**state, **at}, angle, x, sine)
    parameters = {p.symbol: at[p.symbol] for p in family.system.parameters if p.symbol in at}
    return Scene(initial=state, parameters=parameters, times=times)


def _angle_rates(family: Precessions) -> dict[Any, sp.Expr]:
    """Rates of the angles that the velocities hold."""
    held = {s for e in family.quadratures.velocities.values() for s in e.atoms(sp.Derivative)}
    held |= {s for e in family.quadratures.velocities.values() for s in e.free_symbols}
    return {q: family.rates[q] for q in family.quadratures.integrals if velocity(q) in held}


def upright(
    space: Space, state: Mapping[Any, sp.Expr], angle: Any, cosine: sp.Expr, sine: sp.Expr
) -> dict[Any, sp.Expr]:
    """Coordinates in space for which the vector lies along the third axis, upwards."""
    known = {k: v for k, v in state.items() if k != angle}
    vector = space.vector.subs({sp.cos(angle): cosine, sp.sin(angle): sine}).xreplace(known)
    return turned_upright(space, vector.applyfunc(sp.expand))


def essential_rates(family: Precessions) -> dict[Any, sp.Expr]:
    """Essential variable -> its rate, by the derived equations."""
    system = family.system
    if not system.essential:
        raise DefinitionError(
            f"system '{system.name}' declares no essential variables; give it essential=(...)"
        )
    field = Motions.of(system).on_coordinates
    outward = field.bridge.outward
    rates = {outward(v): outward(e) for v, e in zip(field.variables, field.components, strict=True)}
    return {v: rates[v].xreplace(dict(family.values)) for v in system.essential}


def at_rest(family: Precessions) -> Verdict:
    """Whether all essential variables move as they do on the family: angles at their rates, the
    colatitude rests, and velocities change with the angles in them alone."""
    for variable, rate in essential_rates(family).items():
        value = family.state.get(variable, variable)
        turning = value.free_symbols & family.quadratures.integrals.keys()
        told = sp.Add(*(sp.diff(value, q) * family.rates[q] for q in turning))
        verdict = prove_equal(_on_family(family, rate), told.xreplace(dict(family.levels)))
        if not verdict.proved:
            return Verdict(
                verdict.status, f"the rate of {variable}: {verdict.method}", verdict.witness
            )
    return Verdict("proved", "the essential variables move so, in exact normal form")


def linear_matrix(family: Precessions) -> sp.Matrix:
    """The matrix of the linearised equations on the family, rows and columns as ``essential``."""
    rates = essential_rates(family)
    rows = [[_on_family(family, sp.diff(e, v)) for v in rates] for e in rates.values()]
    return sp.Matrix([shorten(row) for row in rows])


def _on_family(family: Precessions, value: sp.Expr) -> sp.Expr:
    restricted = family.at_colatitude(value.xreplace(dict(family.state)))
    angle, cosine = family.colatitude
    return as_expression(restricted if angle is None else restricted.subs(angle, sp.acos(cosine)))


@dataclass(frozen=True, repr=False)
class Precessions:
    """The regular precessions of a system with quadratures, as exact expressions.

    place, rate
        the symbols x and w, the two parameters of the family: the constant value of the variable,
        and the rate of the angle ``turning`` by the time of the quartic.
    constants
        constant of the motion -> its value.
    state
        what the state is: velocity of the equations -> value; the velocity of the colatitude is
        zero.
    rates
        angle -> its constant rate.
    branches
        what the family leaves out.
    values
        what was put in for parameters.

    [Demchenko1924, ch. 6; DragovicGajicJovanovic2020, sec. "Special Solutions"]
    """

    system: System
    quadratures: Quadratures
    turning: sp.Expr
    rate: sp.Symbol
    constants: Mapping[sp.Symbol, sp.Expr]
    branches: tuple[Branch, ...]
    values: Mapping[Any, sp.Expr]

    def __repr__(self) -> str:
        rates = ", ".join(map(str, self.rates))
        return f"Precessions({self.system.name!r}, {self.place}, {self.rate}, rates of {rates})"

    @property
    def place(self) -> sp.Symbol:
        """The variable, which is a parameter here."""
        return self.quadratures.x

    def on(self, value: Any) -> sp.Expr:
        """An expression in the variable, constants and parameters, on the family: a function of x,
        w and what is left of the parameters, in its shortest form."""
        restricted = as_expression(value).xreplace(dict(self.constants))
        return short(restricted.xreplace(dict(self.values)))

    @property
    def colatitude(self) -> tuple[Any, sp.Expr]:
        """The angle by which the variable is known, and its cosine by x; None where there is no
        such angle."""
        meaning, x = self.quadratures.meaning, self.place
        if isinstance(meaning, sp.cos):
            return meaning.args[0], x
        traces = (t for t in self.quadratures.traces if meaning.has(t.colatitude))
        pair = next(((t.colatitude, t.cosine) for t in traces), (None, x))
        return pair[0], pair[1].xreplace(dict(self.values))

    def at_colatitude(self, value: Any) -> Any:
        """A function of the state, or a matrix of such, where the variable is x."""
        angle, cosine = self.colatitude
        if angle is None:
            return value.xreplace({self.quadratures.meaning: self.place})
        return value.subs({sp.cos(angle): cosine, sp.sin(angle): sp.sqrt(1 - cosine**2)})

    @cached_property
    def state(self) -> Mapping[Any, sp.Expr]:
        """Velocity of the equations -> its value on the family."""
        velocities = {v: self.on(_at_rest(self, e)) for v, e in self.quadratures.velocities.items()}
        return MappingProxyType(velocities)

    @cached_property
    def levels(self) -> Mapping[sp.Symbol, sp.Expr]:
        """The constants that the quartic does not hold, by the state: the length of a vector."""
        rest = {c: e for c, e in self.quadratures.constants.items() if c not in self.constants}
        return MappingProxyType({c: self._level(e) for c, e in rest.items()})

    def _level(self, value: sp.Expr) -> sp.Expr:
        """A level in its shortest form; of a root, what is under it."""
        if value.is_Pow and value.exp == sp.S.Half:
            return sp.sqrt(self._level(value.base))
        return short(self.at_colatitude(value).xreplace({**self.state, **self.values}))

    @cached_property
    def rates(self) -> Mapping[Any, sp.Expr]:
        """Angle -> its rate, with ``levels`` by their symbols; undefined where a trace rests."""
        quadratures, turning = self.quadratures, {}
        for angle, expr in quadratures.integrals.items():
            value = (
                (expr / quadratures.clock)
                .xreplace(dict(self.constants))
                .xreplace(dict(self.values))
            )
            for symbol, level in self.levels.items():
                value = _linear_in(value, symbol, level**2)
            turning[angle] = short(value)
        return MappingProxyType(turning)

    def derivative(self, order: int) -> sp.Expr:
        """A derivative of the quartic by x, at x, of an order up to 4: zero for 0 and 1.

        Raises ``DefinitionError`` for another order.
        """
        if not isinstance(order, int) or order not in range(5):
            raise DefinitionError(
                f"derivative: order = {quote(order)}; give a whole number from 0 to 4"
            )
        return self._derivatives[order]

    @cached_property
    def _derivatives(self) -> tuple[sp.Expr, ...]:
        f, x = self.quadratures.quartic, self.place
        return tuple(self.on(sp.diff(f, x, order)) for order in range(5))

    @property
    def frequency(self) -> sp.Expr:
        """The frequency of a small nutation, sqrt(-f''(x)/2)/(dt/dtau), in radians by the time of
        the system; f is the quartic."""
        clock = self.on(self.quadratures.clock)
        return sp.sqrt(-self.derivative(2) / 2) / clock

    @cached_property
    def ends(self) -> tuple[End, ...]:
        """The motions at the ends of the range of x, where the contact stays at a pole."""
        return ends_of(self.quadratures, self.values)

    def numbers(self, place: Any, rate: Any, parameters: Mapping[Any, Any]) -> dict[Any, sp.Expr]:
        """Exact values of everything that the family depends on: x, w and all parameters.

        Raises ``DefinitionError`` unless -1 < ``place`` < 1, and for a parameter without a value
        or with another one than was put in.
        """
        given = read_parameters(self.system, parameters)
        free = {p.symbol: given.get(p.symbol, p.value) for p in self.system.parameters}
        told = {s: exact(v) for s, v in free.items() if v is not None and s not in self.values}
        fixed = {s: value.xreplace(told) for s, value in self.values.items()}
        for symbol, value in fixed.items():
            if given.get(symbol, value) != value:
                raise DefinitionError(
                    f"parameter '{symbol}' = {given[symbol]}, but the precessions were made with "
                    f"{value}; make them with the other value, or without one"
                )
        known = known_parameters(self.system, {**given, **fixed})
        given = {self.place: number(place, "x"), self.rate: number(rate, str(self.rate))}
        if not (-1 < given[self.place] < 1):
            raise DefinitionError(
                f"{self.place} = {quote(place)} is not between -1 and 1; at a pole ask 'ends'"
            )
        return {**known, **given}

    def stability(
        self, place: Any, rate: Any, parameters: Mapping[Any, Any] | None = None
    ) -> Stability:
        """Whether x stays near, if u and the velocities begin near: decided exactly, for x =
        ``place`` and w = ``rate``.

        Raises ``DefinitionError`` as ``numbers`` does, and where a denominator of the family
        vanishes.
        """
        at = self.numbers(place, rate, parameters or {})
        for value in self.constants.values():
            if sp.cancel(sp.denom(value).xreplace(at)) == 0:
                raise DefinitionError(
                    f"there is no precession of the family at {self.place} = {quote(place)}, "
                    f"{self.rate} = {quote(rate)}: a denominator vanishes; see 'branches'"
                )
        constants = {c: value.xreplace(at) for c, value in self.constants.items()}
        return decide_stability(self.quadratures, constants, at, at[self.place])

    def scene(
        self,
        place: Any,
        rate: Any,
        parameters: Mapping[Any, Any] | None = None,
        aside: Any = 0,
        times: tuple[float, float] = (0.0, 40.0),
    ) -> Scene:
        """The precession x = ``place``, w = ``rate`` as initial data, upright; ``aside`` is added
        to the velocity of x.  Raises ``DefinitionError`` as ``numbers`` does."""
        at = self.numbers(place, rate, parameters or {})
        return scene_of(self, at, number(aside, "aside"), times)

    def proved(self) -> Verdict:
        """Whether all of it is at rest: the rates of the essential variables, by the equations;
        ``DefinitionError`` where the system declares none."""
        return at_rest(self)


@accepts(parameters=VALUES)
def precessions(system: System, parameters: Mapping[Any, Any] | None = None) -> Precessions:
    """The regular precessions of a system that declares quadratures.

    ``parameters`` -> values to put in, numbers or expressions; the others stay symbols.  Raises
    ``DefinitionError`` where the system declares no quadratures, ``EngineLimit`` where its
    constants do not follow by linear equations.
    """
    quadratures = quadratures_of(system)
    values = {**read_parameters(system, parameters or {})}
    inside = quadratures.quartic.xreplace(values)
    constants = [c for c in quadratures.constants if inside.has(c)]
    rate = _fresh(system, quadratures)
    for angle, expr in quadratures.integrals.items():
        if not (expr.free_symbols & {*constants}):
            continue
        steps = _solve_constants(inside, expr.xreplace(values) - rate, quadratures.x, constants)
        if steps is not None:
            solved, *linear = steps
            branches = _branches_of(
                expr.xreplace(values) - rate, inside, quadratures.x, solved, linear
            )
            return Precessions(
                system, quadratures, angle, rate, MappingProxyType(solved), branches,
                MappingProxyType(values),
            )  # fmt: skip
    raise EngineLimit(
        f"the constants of system '{system.name}' do not follow from x and the rate of an angle by "
        "linear equations; declare an angle whose rate is linear in a constant"
    )


# -- expressions ----------------------------------------------------------------------------


def _at_rest(family: Precessions, value: sp.Expr) -> sp.Expr:
    """An expression where angles turn at their rates and the colatitude is constant."""
    quadratures = family.quadratures
    turning = {velocity(q): e / quadratures.clock for q, e in quadratures.integrals.items()}
    still = {velocity(q): sp.S.Zero for q in quadratures.meaning.free_symbols}
    return family.at_colatitude(value.xreplace({**turning, **still}))


def _fresh(system: System, quadratures: Quadratures) -> sp.Symbol:
    """A symbol w that means nothing else."""
    taken = {str(s) for _, e, _ in quadratures.expressions() for s in e.free_symbols}
    taken |= {*system.parameter_names}
    return next(sp.Symbol(n) for n in ("w", "w_0", "w_00") if n not in taken)


@dataclass(frozen=True)
class End:
    """The ball turns about the normal at a pole; the contact rests on both surfaces.

    place
        1 or -1.
    free
        the velocity that may have any value, or a constant where no velocity is linear in it.
    constants
        constant of the motion -> its value.
    second, third
        derivatives of the quartic there; x has an inner side only, so the motion is stable where
        the first that is not zero makes f negative inside.
    """

    place: sp.Expr
    free: Any
    constants: Mapping[sp.Symbol, sp.Expr]
    second: sp.Expr
    third: sp.Expr


def ends_of(quadratures: Quadratures, values: Mapping[Any, sp.Expr]) -> tuple[End, ...]:
    """The motions at 1 and at -1, where these are poles of the integrals."""
    ends = []
    for place, weight in quadratures.poles.items():
        if place in (1, -1):
            end = _end(quadratures, place, weight.xreplace(dict(values)), values)
            ends += [end] if end is not None else []
    return tuple(sorted(ends, key=lambda end: -end.place))


def _end(
    quadratures: Quadratures, place: sp.Expr, weight: sp.Expr, values: Mapping[Any, sp.Expr]
) -> End | None:
    x = quadratures.x
    f = quadratures.quartic.xreplace(dict(values))
    names = [c for c in quadratures.constants if f.has(c)]
    constants: dict[sp.Symbol, sp.Expr] = {}
    for equation in (weight, sp.diff(f, x).xreplace({x: place})):
        above = sp.numer(sp.together(equation.xreplace(constants)))
        linear = [c for c in names if c not in constants and sp.degree(above, c) == 1]
        if not linear:
            return None
        # the last of them: its coefficient is simplest where constants come by their degree
        value = in_factors(sp.solve(above, linear[-1])[0])
        constants = {c: in_factors(e.xreplace({linear[-1]: value})) for c, e in constants.items()}
        constants[linear[-1]] = value
    (free,) = [c for c in names if c not in constants]
    constants[free] = free
    spin, level = _velocity(quadratures, place, constants, values, free)
    constants = {c: in_factors(constants[c].xreplace({free: level})) for c in names}
    slopes = [sp.diff(f, x, order).xreplace({x: place}) for order in (2, 3)]
    second, third = (in_factors(e.xreplace(constants)) for e in slopes)
    return End(place, spin, MappingProxyType(constants), second, third)


def _velocity(
    quadratures: Quadratures,
    place: sp.Expr,
    constants: Mapping[sp.Symbol, sp.Expr],
    values: Mapping[Any, sp.Expr],
    free: sp.Symbol,
) -> tuple[Any, sp.Expr]:
    """A velocity that is linear in the free constant there, and the constant by it."""
    for name, expr in quadratures.velocities.items():
        here = (
            expr.xreplace({quadratures.x: place}).xreplace(dict(constants)).xreplace(dict(values))
        )
        if free in here.free_symbols and not here.has(sp.Derivative, sp.sin):
            slope = sp.diff(here, free)
            if slope and not slope.has(free):
                return name, sp.solve(here - name, free)[0]
    return free, free


@dataclass(frozen=True)
class Branch:
    """Precessions that the family leaves out: x and w are fixed there, and ``free`` is not.

    Where the coefficient of the last constant and the rest of its equation both vanish, that
    constant may have any value.
    """

    place: sp.Expr
    rate: sp.Expr
    free: sp.Symbol
    constants: Mapping[sp.Symbol, sp.Expr]


def _solve_constants(
    quartic: sp.Expr, rate: sp.Expr, x: sp.Symbol, constants: Sequence[sp.Symbol]
) -> tuple[dict[sp.Symbol, sp.Expr], sp.Expr, sp.Expr, sp.Symbol] | None:
    """The constants by three equations; of the last one its coefficient and its rest, too."""
    bridge = SymPyBridge()
    equations = bridge.inward_all([rate, quartic, sp.diff(quartic, x)])
    place, *left = bridge.inward_all([x, *constants])
    if len(left) != len(equations):
        return None
    solved: dict[Any, Any] = {}
    for equation in equations:
        above, _ = quotient(equation.xreplace(solved))
        slopes = {c: above.diff(c) for c in left}
        linear = [c for c, e in slopes.items() if e != 0 and c not in e.free_symbols]
        if not linear:
            return None
        # A coefficient without x vanishes for no place: such a constant is solved for first.
        constant = min(linear, key=lambda c: place in slopes[c].free_symbols)
        value = -above.xreplace({constant: se.Integer(0)}) / slopes[constant]
        rest, slope = quotient(value)
        solved = {c: e.xreplace({constant: value}) for c, e in solved.items()} | {constant: value}
        solved = {c: shortest([e])[0] for c, e in solved.items()}
        left.remove(constant)
    order = {c: bridge.outward(solved[bridge.inward(c)]) for c in constants}
    return order, bridge.outward(slope), bridge.outward(rest), bridge.outward(constant)


def _branches_of(
    rate: sp.Expr,
    quartic: sp.Expr,
    x: sp.Symbol,
    found: Mapping[sp.Symbol, sp.Expr],
    linear: Sequence[sp.Expr],
) -> tuple[Branch, ...]:
    """Where the coefficient of the last constant vanishes with the rest of its equation."""
    slope, rest, last = linear
    (w,) = rate.free_symbols & slope.free_symbols - {x, *found} - quartic.free_symbols or {None}
    if w is None:
        return ()
    branches = []
    for factor, _ in sp.factor_list(slope)[1]:
        for value in sp.roots(factor, w) if factor.has(w) else ():
            for place in sp.roots(_above(rest.xreplace({w: value})), x):
                branches += _branch(
                    rate.xreplace({w: value}), quartic, (x, place), value, last, found
                )
    return tuple(branches)


def _branch(
    rate: sp.Expr,
    quartic: sp.Expr,
    at: tuple[sp.Symbol, sp.Expr],
    w: sp.Expr,
    last: Any,
    names: Any,
) -> list[Branch]:
    """The constants there, but for ``last``; none outside the range of x."""
    x, place = at
    if place.is_number and not -1 < place < 1:
        return []
    values: dict[sp.Symbol, sp.Expr] = {last: last}
    for equation in (rate, quartic):
        here = _above(equation.xreplace(values).xreplace({x: place}))
        constant = next((c for c in names if c not in values and sp.degree(here, c) == 1), None)
        if constant is None:
            return []
        values[constant] = short(sp.solve(here, constant)[0])
    return [Branch(place, w, last, MappingProxyType(values))]


def short(value: sp.Expr) -> sp.Expr:
    """The shortest proved form."""
    (form,) = shorten([value])
    return form


def _linear_in(value: sp.Expr, symbol: sp.Symbol, square: sp.Expr) -> sp.Expr:
    """A rational function of a symbol whose square is known, the denominator without it."""
    parts = []
    for part in sp.fraction(sp.together(short(value))):
        terms = sp.Poly(sp.expand(part), symbol).as_dict().items()
        even, odd = (
            sp.Add(*(c * square ** (n // 2) for (n,), c in terms if n % 2 == side))
            for side in (0, 1)
        )
        parts.append((short(even), short(odd)))
    (a, b), (c, d) = parts
    if d == 0:
        return short(a / c) + short(b / c) * symbol
    below = short(c**2 - d**2 * square)
    return short((a * c - b * d * square) / below) + short((b * c - a * d) / below) * symbol


def _above(value: sp.Expr) -> sp.Expr:
    """The numerator in lowest terms."""
    return sp.expand(sp.fraction(sp.together(short(value)))[0])
