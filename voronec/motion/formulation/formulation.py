"""The equations of a system in one formulation: which variables, their rates, what is to be solved.

    positions' = rates,   mass * velocities' = force

Formulations are proved to be equivalent: coordinates, invariants, and momenta in the place of
velocities.

Where two functions of the invariants are a = r cos(q), b = r sin(q), with r free of the angle q,
the angle is atan2(b, a) up to a half turn; and r itself, the root of a^2 + b^2 up to its sign, is
one more function to read others off, such as the colatitude u from cos(u) and r = sin(u).

Which variables the rates of which others hold is read off, exactly on normal forms.  Velocities
that the mass matrix couples are solved for together, so each stands for the whole block.

Denominators are made free of cancellation, sums of squares in place of differences.  The normal
form of an angle's rate on the Poisson vector has the denominator (1 + z) (z - 1), which near a
pole, z = 1 - 1e-14, is all rounding.  On |(x, y, z)|^2 = 1 it is -(x^2 + y^2), whose terms cannot
cancel.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import combinations, permutations
from typing import Any

import symengine as se
import sympy as sp
from symengine.lib.symengine_wrapper import ComplexBase

from voronec.algebra.graphs import nodes
from voronec.algebra.normal import canonical, shortest
from voronec.algebra.terms import atoms, factors_of, rewrite_kinds, summands
from voronec.algebra.verdicts import all_vanish
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.motions import Motions
from voronec.equations.reduction import in_invariants
from voronec.equations.vector_field import EquationsOfMotion, VectorField
from voronec.errors import EngineLimit, VoronecError


@dataclass(frozen=True)
class AngleOutput:
    """q = atan2(sine, cosine) up to signs and turns that the start tells.

    Both are in terms of the invariants, with a common factor r whose sign does not change while the
    chart holds; a root stands for a factor of either sign, and keeps it too.  ``meaning`` is what
    the two are, r cos(q) and r sin(q), in the coordinates; ``roots`` tells which of them is a root.
    """

    coordinate: Any
    cosine: Any
    sine: Any
    meaning: tuple[Any, Any]
    roots: tuple[bool, bool]

    def map(self, on: Callable[[Any], Any]) -> AngleOutput:
        """The angle with its expressions replaced."""
        return replace(self, cosine=on(self.cosine), sine=on(self.sine))

    def signs(self, start: Mapping[Any, float]) -> tuple[int, int]:
        """With which signs of cosine and sine the angle is what it is at the start.

        ``start`` gives the numbers of the coordinates there, and of parameters.
        """
        begin = float(start[self.coordinate])
        true = [float(e.subs(dict(start)).n(53, real=True)) for e in self.meaning]
        reverse = -1 if true[0] * math.cos(begin) + true[1] * math.sin(begin) < 0 else 1
        # a root is never negative, what it stands for may be
        i, j = (-1 if root and x < 0 else 1 for x, root in zip(true, self.roots, strict=True))
        return reverse * i, reverse * j

    @property
    def symbols(self) -> set[Any]:
        """What it is read off."""
        return set(self.cosine.free_symbols | self.sine.free_symbols)


def _recovered_angles(motions: Motions, wanted: Mapping[str, Any]) -> dict[str, AngleOutput]:
    """Those wanted quantities that are coordinates and can be read off the invariants."""
    d, bridge = motions.equations.definition, motions.equations.bridge
    names = {e: name for name, e in wanted.items() if e in d.coordinates}
    if not names:
        return {}
    known = [(se.Symbol(name), bridge.inward(g)) for name, g in motions.system.invariants.items()]
    angles = [q for q in d.coordinates if any(se.has_symbol(g, q) for _, g in known)]
    recovered: dict[Any, AngleOutput] = {}
    while True:
        fresh = _next(known, [q for q in angles if q not in recovered])
        if fresh is None:
            break
        angle, modulus, meaning = fresh
        recovered[angle.coordinate] = angle
        if modulus is not None:
            known.append((modulus, meaning))
    return {name: recovered[q] for q, name in names.items() if q in recovered}


def _next(
    known: Iterable[tuple[Any, Any]], angles: Iterable[Any]
) -> tuple[AngleOutput, Any, Any] | None:
    """One more angle, and the factor that is known with it: as read off, and as it is."""
    functions = list(known)
    for q in angles:
        for pair in combinations([f for f in functions if se.has_symbol(f[1], q)], 2):
            for (a, cosine), (b, sine) in permutations(pair):
                for sign in (1, -1):
                    if not _turns(cosine, sign * sine, q):
                        continue
                    factor = _factor(cosine, sign * sine, q)
                    root = se.sqrt(a**2 + b**2)
                    side = b if b.args else sign * b  # a root has no sign of its own
                    angle = AngleOutput(
                        q, a, side, (cosine, sign * sine), (bool(a.args), bool(b.args))
                    )  # fmt: skip
                    return angle, (None if factor is None else root), factor
    return None


def _turns(cosine: Any, sine: Any, q: Any) -> bool:
    """Whether the two are a factor times cos(q) and sin(q), up to one turn for both."""
    return all_vanish([cosine.diff(q) + sine, sine.diff(q) - cosine]) and all_vanish(
        [cosine * se.sin(q) - sine * se.cos(q)]
    )


def _factor(cosine: Any, sine: Any, q: Any) -> Any | None:
    """r = a cos(q) + b sin(q), in the other coordinates."""
    total = cosine.subs({q: 0})
    return total if all_vanish([cosine * se.cos(q) + sine * se.sin(q) - total]) else None


INFINITE = (se.zoo, se.nan, se.oo, -se.oo)
"""What a division by zero leaves."""


@dataclass(frozen=True)
class Formulation(EquationsOfMotion):
    """Equations in symengine, with what the wanted quantities are on them.

    ``stages`` are pairs (name, expression) that everything else may use.  ``start`` says what each
    variable is in terms of coordinates and velocities of the equations.  ``quantities`` holds the
    wanted outputs and those first integrals that this formulation can express, by name; ``angles``
    are outputs that are read off invariants.  ``exact`` tells normal forms from expressions whose
    symbols may be there in vain.  ``inertia`` is the mass matrix of the velocities, where momenta
    stand in for them.
    """

    name: str
    system: Any
    start: Mapping[Any, Any]
    outputs: Mapping[str, Any]
    integrals: Mapping[str, Any]
    angles: Mapping[str, AngleOutput] = field(default_factory=dict)
    stages: tuple[tuple[Any, Any], ...] = ()
    exact: bool = True
    inertia: tuple[tuple[Any, ...], ...] | None = None

    @cached_property
    def positive(self) -> tuple[Any, ...]:
        """The parameters that are declared to be positive."""
        return tuple(se.Symbol(p.name) for p in self.system.parameters if p.is_positive)

    @cached_property
    def form(self) -> FirstOrderForm:
        """What a ``Program`` is made of, with the stages."""
        return replace(super().form, stages=self.stages, positive=self.positive)

    def substitute(self, values: Mapping[Any, Any]) -> Formulation:
        """The formulation with symbols replaced; integrals that then have no meaning are left
        out."""
        given = dict(values)

        def on(expr: Any) -> Any:
            return expr.subs(given) if given.keys() & expr.free_symbols else expr

        return replace(
            self,
            rates=tuple(map(on, self.rates)),
            mass=tuple(tuple(map(on, row)) for row in self.mass),
            force=tuple(map(on, self.force)),
            relations=tuple(map(on, self.relations)),
            outputs={name: on(e) for name, e in self.outputs.items()},
            integrals={name: e for name, x in self.integrals.items() if is_finite(e := on(x))},
            angles={name: a.map(on) for name, a in self.angles.items()},
            stages=tuple((name, on(e)) for name, e in self.stages),
            inertia=self.inertia and tuple(tuple(map(on, row)) for row in self.inertia),
        )


def is_finite(expr: Any) -> bool:
    """Whether an expression holds no infinity, such as a division by zero leaves, and no complex
    number, such as log(-1)."""
    return not any(expr == bad or expr.has(bad) for bad in INFINITE) and not atoms(
        [expr], ComplexBase
    )


def coordinates_formulation(
    motions: Motions, wanted: Mapping[str, sp.Expr], integrals: Mapping[str, sp.Expr]
) -> Formulation:
    """The equations in coordinates and the velocities of the frame.

    Normal forms where they are within the budget; else the straight-line form.
    """
    equations, flow = motions.equations, motions.for_numbers
    exact = not equations.is_large and equations.in_normal_form
    outputs = {name: flow.read(e) for name, e in wanted.items()}
    claims = _readable(flow, integrals)
    if not equations.is_large:
        outputs = {name: _plainest(flow, e) for name, e in outputs.items()}
        claims = {name: _plainest(flow, e) for name, e in claims.items()}
    d = equations.definition
    formulation = Formulation(
        name="coordinates",
        system=equations.system,
        positions=flow.positions,
        velocities=flow.velocities,
        rates=flow.rates,
        mass=flow.mass,
        force=flow.force,
        parameters=flow.parameters,
        time=flow.time,
        relations=flow.relations,
        start={x: x for x in flow.variables},
        outputs=outputs,
        integrals=claims,
        exact=exact,
    )
    if exact or d.group is not None:
        return formulation
    lean = equations.form
    return replace(
        formulation, rates=lean.rates, mass=lean.mass, force=lean.force, stages=lean.stages
    )


def _plainest(flow: VectorField, expr: Any) -> Any:
    """An expression without variables that it holds in vain, where a normal form tells so."""
    try:
        (normal,) = canonical([expr], flow.relations)
    except EngineLimit:
        return expr
    return normal if normal.free_symbols < expr.free_symbols else expr


def _readable(flow: VectorField, exprs: Mapping[str, sp.Expr]) -> dict[str, Any]:
    readable = {}
    for name, expr in exprs.items():
        try:
            readable[name] = flow.read(expr)
        except VoronecError:
            continue
    return readable


def invariants_formulation(
    motions: Motions,
    wanted: Mapping[str, sp.Expr],
    integrals: Mapping[str, sp.Expr],
    followed: Collection[str] = (),
) -> Formulation | None:
    """The equations in the declared invariants and the velocities; None where they do not close.

    A coordinate that is wanted and is no function of the invariants is kept beside them, with all
    that its rate needs; an angle whose cosine and sine are invariants up to a factor is read off.
    """
    if not motions.system.invariants:
        return None
    try:
        flow = motions.on_invariants
    except VoronecError:
        return None  # they do not close: a false claim, but the motion is there
    try:
        plain = _readable(flow, wanted)
        spelled = {n: motions.on_coordinates.read(e) for n, e in wanted.items() if n not in plain}
        free = {n: e for n, e in spelled.items() if n not in followed}
        sides = _recovered_angles(motions, free)
        others, kept, rates = _express_outputs(motions, spelled, sides)
    except EngineLimit:
        return None
    d = motions.equations.definition
    bridge = motions.equations.bridge
    start = {se.Symbol(name): bridge.inward(g) for name, g in motions.system.invariants.items()}
    return Formulation(
        name="invariants",
        system=motions.system,
        positions=(*flow.positions, *kept),
        velocities=flow.velocities,
        rates=(*flow.rates, *rates),
        mass=flow.mass,
        force=flow.force,
        parameters=flow.parameters,
        time=flow.time,
        relations=flow.relations,
        start={**start, **{x: x for x in (*kept, *d.velocities)}},
        outputs=plain | others,
        integrals=_claims(motions, flow, integrals, kept),
        angles=sides,
    )


def _claims(
    motions: Motions, flow: VectorField, integrals: Mapping[str, sp.Expr], kept: Sequence[Any]
) -> dict[str, Any]:
    """The integrals that are functions of the invariants, the velocities and what is kept."""
    readable = _readable(flow, integrals)
    others = {name: e for name, e in integrals.items() if name not in readable}
    if not others:
        return readable
    low = _readable(motions.on_coordinates, others)
    try:
        rewritten = in_invariants(motions.equations, list(low.values()), kept)
    except EngineLimit:
        return readable
    named = zip(low, rewritten, strict=True)
    return readable | {name: e for name, e in named if e is not None}


def _express_outputs(
    motions: Motions, spelled: Mapping[str, Any], angles: Mapping[str, AngleOutput]
) -> tuple[dict[str, Any], tuple[Any, ...], list[Any]]:
    """Outputs on the invariants; the coordinates that they keep, and the rates of these."""
    todo = {name: e for name, e in spelled.items() if name not in angles}
    if not todo:
        return {}, (), []
    low = motions.on_coordinates
    rate = dict(zip(low.positions, low.rates, strict=True))
    kept: list[Any] = []
    while True:
        targets = [*todo.values(), *(rate[q] for q in kept)]
        expressions = in_invariants(motions.equations, targets, kept)
        missing = [t for t, f in zip(targets, expressions, strict=True) if f is None]
        if not missing:
            count, ideal = len(todo), motions.on_invariants.relations
            expressions = [with_positive_denominators(e, ideal) for e in expressions]
            return (
                dict(zip(todo, expressions[:count], strict=True)),
                tuple(kept),
                expressions[count:],
            )
        needed = set().union(*(t.free_symbols for t in missing)) - set(kept)
        fresh = [q for q in low.positions if q in needed]
        if not fresh:
            raise EngineLimit("an output has no expression in the invariants")
        kept += fresh


Sources = Mapping[Any, tuple[Any, ...]]
"""The variables that the rate of each variable holds."""


def blocks(formulation: Formulation) -> list[list[int]]:
    """Positions of velocities that the mass matrix couples, block by block."""
    mass, left = formulation.mass, [*range(len(formulation.velocities))]
    coupled = {i: [j for j in left if mass[i][j] != 0 or mass[j][i] != 0] for i in left}
    groups = []
    while left:
        block = closure(coupled, left[:1])
        groups.append(sorted(block))
        left = [i for i in left if i not in block]
    return groups


def dependence(formulation: Formulation) -> Sources:
    """What the rate of each variable of a formulation holds."""
    graph = {
        q: tuple(holds(formulation, [rate]))
        for q, rate in zip(formulation.positions, formulation.rates, strict=True)
    }
    for block in blocks(formulation):
        inside = [formulation.mass[i][j] for i in block for j in block]
        inside += [formulation.force[i] for i in block]
        velocities = [formulation.velocities[i] for i in block]
        shared = velocities if len(velocities) > 1 else []
        sources = tuple(dict.fromkeys([*holds(formulation, inside), *shared]))
        graph |= dict.fromkeys(velocities, sources)
    return graph


def holds(formulation: Formulation, exprs: Iterable[Any]) -> list[Any]:
    """The variables of a formulation on which expressions depend, those inside stages included."""
    stages = dict(formulation.stages)
    seen: set[Any] = set()
    stack = [s for e in exprs for s in e.free_symbols]
    while stack:
        symbol = stack.pop()
        if symbol not in seen:
            seen.add(symbol)
            if symbol in stages:
                stack.extend(stages[symbol].free_symbols)
    return [x for x in formulation.variables if x in seen]


def needed_variables(formulation: Formulation, sources: Sources) -> list[Any]:
    """The smallest closed set of variables on which the outputs depend."""
    exprs = [*formulation.outputs.values()]
    for angle in formulation.angles.values():
        exprs += [angle.cosine, angle.sine]
    closed = closure(sources, holds(formulation, exprs))
    return [x for x in formulation.variables if x in closed]


def cyclic(sources: Sources, kept: Sequence[Any]) -> set[Any]:
    """The variables that take part in a cycle of dependence; the others are quadratures."""
    inside = {x: tuple(y for y in sources[x] if y in kept) for x in kept}
    return {x for x in kept if x in closure(inside, inside[x])}


def closure(sources: Mapping[Any, Sequence[Any]], roots: Iterable[Any]) -> set[Any]:
    """The roots, and all on which they depend."""
    reached: set[Any] = set()
    stack = [*roots]
    while stack:
        x = stack.pop()
        if x not in reached:
            reached.add(x)
            stack += sources[x]
    return reached


def restrict(formulation: Formulation, kept: Iterable[Any]) -> Formulation:
    """The formulation with some of its variables; the rest must not occur in what is kept."""
    held = set(kept)
    at = [i for i, q in enumerate(formulation.positions) if q in held]
    moving = [i for i, v in enumerate(formulation.velocities) if v in held]
    usable = {*held, *formulation.parameters, formulation.time}
    stages = []
    for name, expr in formulation.stages:
        if expr.free_symbols <= usable:
            stages.append((name, expr))
            usable.add(name)
    return replace(
        formulation,
        positions=tuple(formulation.positions[i] for i in at),
        velocities=tuple(formulation.velocities[i] for i in moving),
        rates=tuple(formulation.rates[i] for i in at),
        mass=tuple(tuple(formulation.mass[i][j] for j in moving) for i in moving),
        force=tuple(formulation.force[i] for i in moving),
        relations=tuple(r for r in formulation.relations if r.free_symbols <= usable),
        integrals={n: e for n, e in formulation.integrals.items() if e.free_symbols <= usable},
        stages=tuple(stages),
    )


def keep_relations(formulation: Formulation) -> Formulation:
    """The formulation with rates that keep each relation r of its positions also beside the motion.

    Where r = 0 rates may be written in many ways, and D r = sum of dr/dx x' is a multiple c r.  If
    it is not zero, what rounding takes r off zero grows as exp(int c dt).  On a sphere, sum of
    x_i^2 = k, the rates are x_j' = sum_i x_i (x_i x_j' - x_j x_i')/k, which keep it identically;
    a root h^2 = f(x) has the rate that f gives it.
    """
    rates = dict(zip(formulation.positions, formulation.rates, strict=True))
    symbols = {*formulation.positions, *formulation.parameters}
    relations = (
        [r for r in formulation.relations if r.free_symbols <= symbols] if formulation.exact else []
    )
    try:
        for mend in (_on_sphere, _of_root):
            for relation in relations:
                lost = se.Add(*[relation.diff(x) * rate for x, rate in rates.items()])
                if canonical([lost])[0] != 0:
                    rates |= mend(formulation, relation, rates)
    except EngineLimit:
        return formulation
    return replace(formulation, rates=tuple(rates.values()))


def _on_sphere(formulation: Formulation, relation: Any, rates: Mapping[Any, Any]) -> dict[Any, Any]:
    """Rates that keep a sphere, by what turns its points; none for another relation."""
    held = [x for x in formulation.positions if x in relation.free_symbols]
    scale = relation.diff(held[0]).diff(held[0]) / 2
    size = se.expand(se.Add(*[x**2 for x in held]) - relation / scale) if scale != 0 else None
    if size is None or size == 0 or not size.free_symbols <= set(formulation.positive):
        return {}
    pairs = list(combinations(held, 2))
    turning = [x * rates[y] - y * rates[x] for x, y in pairs]
    turns = shortest(turning, formulation.relations)
    tangent = dict.fromkeys(held, se.Integer(0))
    for (x, y), turn in zip(pairs, turns, strict=True):
        tangent[x] -= y * turn / size
        tangent[y] += x * turn / size
    return {x: with_positive_denominators(e, formulation.relations) for x, e in tangent.items()}


def _of_root(formulation: Formulation, relation: Any, rates: Mapping[Any, Any]) -> dict[Any, Any]:
    """The rate of a root that f gives, where that divides by nothing that may vanish; else none."""
    for h in formulation.positions:
        slope = relation.diff(h)
        if slope == 0 or not (slope / h).is_Number:
            continue
        others = [relation.diff(x) * rate for x, rate in rates.items() if x != h]
        (rate,) = shortest([-se.Add(*others) / slope])
        square = se.expand(h**2 - 2 * h / slope * relation)
        if _divides(h, rates[h]) or not _divides(h, rate) or _is_definite(formulation, square):
            return {h: rate}
    return {}


def _is_definite(formulation: Formulation, square: Any) -> bool:
    """Whether a polynomial is a sum of the squares of all that lies on a sphere."""
    free = [t for t in summands(square) if not t.free_symbols & set(formulation.positions)]
    for relation in map(se.expand, formulation.relations):
        if _constant(relation) != 0:
            reduced = se.expand(square - se.Add(*free) / _constant(relation) * relation)
            if relation.free_symbols <= reduced.free_symbols and _is_positive(reduced):
                return True
    return False


def _divides(x: Any, expr: Any) -> bool:
    """Whether an expression is divided by a symbol."""
    powers = (n.args for n in nodes([expr]) if isinstance(n, se.Pow))
    return any(base == x and power.is_Number and power < 0 for base, power in powers)


def with_positive_denominators(expr: Any, relations: Sequence[Any]) -> Any:
    """An expression with denominators that equal a sum of squares, where ``relations`` vanish,
    written as that sum."""
    expanded = [r for r in map(se.expand, relations) if _constant(r) != 0]
    change = partial(_divide, relations=expanded)
    return rewrite_kinds(expr, (se.Mul, se.Pow), change) if expanded else expr


def _divide(product: Any, relations: Sequence[Any]) -> Any:
    """A product, with single factors and pairs of its denominator replaced."""
    factors = factors_of(product)
    below = {
        f.args[0]: int(-f.args[1])
        for f in factors
        if isinstance(f, se.Pow) and isinstance(f.args[1], se.Integer) and f.args[1] < 0
    }
    for count in (1, 2):
        for bases in combinations([b for b in below if isinstance(b, se.Add)], count):
            power = min((below[b] for b in bases), default=0)
            sign, squares = _as_squares(se.Mul(*bases), relations) if power else (1, None)
            if squares is not None:
                product = product * se.Mul(*bases) ** power * sign**power / squares**power
                below = {b: n - power * (b in bases) for b, n in below.items()}
    return product


def _as_squares(divisor: Any, relations: Sequence[Any]) -> tuple[int, Any | None]:
    """The sign and the sum of squares that a divisor is where the relations vanish, if it is one:
    a multiple of a relation takes its constant term away."""
    poly = se.expand(divisor)
    size = _constant(poly)
    for relation in relations:
        reduced = se.expand(poly - size / _constant(relation) * relation)
        # a sum of all the squares never vanishes: then nothing cancels as it is
        vanishes = reduced.free_symbols < relation.free_symbols
        for sign in (1, -1) if size != 0 and reduced != 0 and vanishes else ():
            if _is_positive(se.expand(sign * reduced)):
                return sign, se.expand(sign * reduced)
    return 1, None


def _constant(poly: Any) -> Any:
    """The constant term of an expanded polynomial, a number."""
    terms = summands(poly)
    return se.Add(*[t for t in terms if t.is_Number])


def _is_positive(poly: Any) -> bool:
    """Whether every term is a positive number times even powers of symbols."""
    terms = summands(poly)
    return all(_is_square(f) for t in terms for f in (factors_of(t)))


def _is_square(factor: Any) -> bool:
    if factor.is_Number:
        return bool(factor > 0)
    if not isinstance(factor, se.Pow) or not factor.args[0].is_Symbol:
        return False
    power = factor.args[1]
    return isinstance(power, se.Integer) and power > 0 and int(power) % 2 == 0
