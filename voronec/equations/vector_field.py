"""The motion of a system as a vector field.

    positions' = rates,   mass * velocities' = force

Claims and relations are statements about such fields.  Everything here is in the engine's symbols.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.branches import bounds_of
from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import determinant, is_product
from voronec.algebra.memo import Memo
from voronec.algebra.normal import canonical, shortest
from voronec.algebra.points import sample_evaluable
from voronec.algebra.rank import generic_rows
from voronec.algebra.roots import known_sign
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.tape import Tape
from voronec.algebra.terms import atoms
from voronec.algebra.verdicts import Verdict
from voronec.declaration.geometry import moving_names
from voronec.declaration.system import System
from voronec.equations.derivation import Derivation, FirstOrderForm
from voronec.equations.derived_equations import DerivedEquations
from voronec.errors import EngineLimit, quote

NO_POINT = "no point was found on the relations between the variables"


@dataclass(frozen=True)
class EquationsOfMotion:
    """positions' = rates, mass * velocities' = force, where ``relations`` vanish."""

    positions: tuple[Any, ...]
    velocities: tuple[Any, ...]
    time: Any
    parameters: tuple[Any, ...]
    rates: tuple[Any, ...]
    mass: tuple[tuple[Any, ...], ...]
    force: tuple[Any, ...]
    relations: tuple[Any, ...]

    @cached_property
    def variables(self) -> tuple[Any, ...]:
        """Positions, then velocities."""
        return self.positions + self.velocities

    @property
    def form(self) -> FirstOrderForm:
        """What a ``Program`` is made of; the velocities need no further definitions."""
        return FirstOrderForm(
            coordinates=self.positions,
            velocities=self.velocities,
            parameters=self.parameters,
            time=self.time,
            rates=self.rates,
            mass=self.mass,
            force=self.force,
            relations=self.relations,
        )


@dataclass(frozen=True)
class VectorField(EquationsOfMotion):
    """A field on ``variables``, positions before velocities, where ``relations`` vanish.

    ``meaning`` says what other symbols stand for: velocities of coordinates in terms of the state,
    and, on the coordinates, the invariants.  There ``dots`` are the symbols of the coordinates'
    velocities, and ``definitions`` give the velocities of the equations in terms of them;
    ``momenta`` are named in functions, dLc/dv, and ``determinant`` is a name of that of the mass.
    On a group ``turning[i][k]`` is C_ab^k h_i^a w^b, k over the independent velocities.
    ``level`` is ``coordinates`` or ``invariants``.  ``conditions`` are what is known besides, as
    signs of parameters.
    """

    system: System
    level: str
    bridge: SymPyBridge
    meaning: dict[Any, Any]
    dots: tuple[Any, ...] = ()
    definitions: dict[Any, Any] = field(default_factory=dict)
    momenta: dict[Any, Any] = field(default_factory=dict)
    determinant: Any = None
    turning: tuple[tuple[Any, ...], ...] = ()
    conditions: tuple[Any, ...] = ()
    memo: Memo = field(default_factory=Memo, init=False, repr=False, compare=False)

    @property
    def hypotheses(self) -> tuple[Any, ...]:
        """What is taken for granted where something is decided: relations and conditions."""
        return self.relations + self.conditions

    @property
    def dimension(self) -> int:
        """How many of the variables are independent where the relations vanish."""
        return len(self.variables) - len(self.independent_relations)

    def read(self, expr: sp.Expr) -> Any:
        """A function of the state, from the user's symbols."""
        return self.express(self.bridge.inward(expr))

    def read_with_momenta(self, expr: sp.Expr) -> Any:
        """A function of the state with named momenta as they are: its rate is simpler so."""
        return self._own(self._spell_determinant(self.bridge.inward(expr)).xreplace(self.meaning))

    def read_density(self, expr: sp.Expr) -> Any:
        """A density, with the determinant of the mass by its name."""
        return self._own(self.bridge.inward(expr).xreplace(self.meaning).xreplace(self.momenta))

    def read_branches(self, expr: sp.Expr) -> Any:
        """A function whose branches are sought, where the determinant is raised to powers only: it
        is nowhere zero, and has no branches; else spelled out."""
        named = self.read_density(expr)
        inside = [p for p in atoms([named], se.Pow) if self.determinant == p.args[0]]
        rest = named.xreplace(dict.fromkeys(inside, se.Integer(1)))
        return self.read(expr) if self.determinant in rest.free_symbols else named

    def express(self, expr: Any) -> Any:
        """A function in the engine's symbols, with everything that has a meaning spelled out."""
        return self._own(
            self._spell_determinant(expr).xreplace(self.meaning).xreplace(self.momenta)
        )

    @cached_property
    def _foreign(self) -> frozenset[Any]:
        """What moves with the system, but has no meaning on this level."""
        known = {*self.variables, *self.momenta, self.determinant}
        moving = moving_names(self.system.coordinates, self.system.frame)
        return frozenset({*map(self.bridge.inward, moving)} - known)

    def _own(self, expr: Any) -> Any:
        """A function that holds nothing foreign: what moves must not pass for a constant."""
        for symbol in sorted(expr.free_symbols & self._foreign, key=str):
            raise EngineLimit(
                f"'{symbol}' of system '{self.system.name}' has no meaning on the {self.level}; "
                "write the function in the variables there"
            )
        return expr

    def _spell_determinant(self, expr: Any) -> Any:
        """An expression with the determinant of the mass spelled out."""
        if self.determinant is None or self.determinant not in expr.free_symbols:
            return expr
        return expr.xreplace({self.determinant: determinant(self.mass)})

    def solve(self, columns: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """mass^-1 times the columns of a matrix given by rows."""
        if not self.velocities:
            return []
        return solve_linear(self.mass, columns, self.hypotheses).values

    @cached_property
    def accelerations(self) -> tuple[Any, ...]:
        """velocities' = mass^-1 force, in normal form where that is within the budget."""
        raw = [row[0] for row in self.solve([[f] for f in self.force])]
        try:
            return tuple(canonical(raw, self.relations))
        except EngineLimit:
            return tuple(raw)

    @property
    def components(self) -> tuple[Any, ...]:
        """The rates of all variables."""
        return self.rates + self.accelerations

    def derivative(self, function: Any) -> Any:
        """d/dt along the motion."""
        return self.derivatives([function])[0]

    def derivatives(self, functions: Sequence[Any]) -> list[Any]:
        """d/dt of several functions along the motion.

        dF/dv . mass^-1 force is computed as y . force with mass y = dF/dv [Theory, eq. (14)]; of an
        energy y is v.
        """
        rates = [self.at_rest(f) for f in functions]
        slopes = [self._slopes(f) for f in functions]
        moving = [k for k, row in enumerate(slopes) if any(s != 0 for s in row)]
        momenta = slopes[moving[0]] if len(moving) == 1 else ()
        if momenta and is_product(momenta, self.mass, self.velocities, self.hypotheses):
            power = [v * f for v, f in zip(self.velocities, self.force, strict=True)]
            rates[moving[0]] = se.Add(rates[moving[0]], *power)
        elif moving:
            columns = zip(*[slopes[k] for k in moving], strict=True)
            solved = self.solve([list(row) for row in columns])
            for column, k in enumerate(moving):
                pushed = [row[column] * f for row, f in zip(solved, self.force, strict=True)]
                rates[k] = se.Add(rates[k], *pushed)
        return rates

    def at_rest(self, function: Any) -> Any:
        """The part of d/dt that holds no acceleration."""
        pairs = [*zip(self.positions, self.rates, strict=True)]
        if not self.momenta.keys().isdisjoint(function.free_symbols):
            pairs += zip(self.momenta, self._momentum_rates, strict=True)
        rate = se.Add(function.diff(self.time), *[rate * function.diff(q) for q, rate in pairs])
        return rate.xreplace(self.momenta)

    def _slopes(self, function: Any) -> list[Any]:
        """dF/dv, named momenta held; where it vanishes, dF/dt needs no acceleration."""
        slopes = [function.diff(v).xreplace(self.momenta) for v in self.velocities]
        if self.momenta.keys().isdisjoint(function.free_symbols):
            return slopes
        return [s if s == 0 else canonical([s], self.relations)[0] for s in slopes]

    @cached_property
    def _momentum_rates(self) -> list[Any]:
        """d/dt dLc/dv = force + the rate of the momenta where the velocities are constant."""
        pairs = [*zip(self.positions, self.rates, strict=True)]
        drifts = [
            se.Add(p.diff(self.time), *[rate * p.diff(q) for q, rate in pairs])
            for p in self.momenta.values()
        ]
        rates = [f + d for f, d in zip(self.force, drifts, strict=True)]
        return canonical(rates, self.relations)

    @cached_property
    def independent_relations(self) -> tuple[Any, ...]:
        """As many of the relations as are independent, by their rank at a point."""
        slopes = [[r.diff(q) for q in self.positions] for r in self.relations]
        rows = generic_rows(slopes, self.hypotheses, failure=NO_POINT)
        return tuple(self.relations[i] for i in rows)

    @cached_property
    def existence(self) -> Verdict:
        """Whether there are motions: whether the equations have real values at some state."""
        for b in dict.fromkeys(b for e in self.entries for b in bounds_of(e, pieces=False)):
            if known_sign(b, self.hypotheses, strict=True) < 0:
                words = f"their equations are real where {quote(self.bridge.outward(b))} >= 0 alone"
                return Verdict("refuted", f"there are no motions: {words}")
        try:
            everywhere = not any(map(bounds_of, self.entries))
            real = everywhere or sample_evaluable(Tape(self.entries), self.hypotheses, count=1)
        except EngineLimit:  # what nobody evaluates, as an unknown function
            real = True
        if real:
            return Verdict("proved", "a state at which the equations have real values")
        return Verdict("undecided", "no state was found at which the equations have real values")

    @property
    def entries(self) -> list[Any]:
        """All expressions of the equations: rates, force, and mass row by row."""
        return [*self.rates, *self.force, *(e for row in self.mass for e in row)]


def on_coordinates(equations: DerivedEquations) -> VectorField:
    """The field on coordinates and velocities, which is made once."""
    return equations.memo.once("field", lambda: _field(equations, equations.best))


def for_numbers(equations: DerivedEquations) -> VectorField:
    """The field on coordinates, without normal forms where these would be too large to be of
    use."""
    if not equations.is_large:
        return on_coordinates(equations)
    return equations.memo.once("field for numbers", lambda: _field(equations, equations.raw))


def _field(equations: DerivedEquations, d: Derivation) -> VectorField:
    bridge = equations.bridge
    definition = d.definition
    rates = tuple(d.rates)
    meaning = dict(zip(definition.coordinate_velocities, rates, strict=True)) | dict(d.dependent)
    for v in definition.velocities:
        meaning.pop(v, None)
    for name, g in equations.system.invariants.items():
        meaning[se.Symbol(name)] = bridge.inward(g)
    return VectorField(
        system=equations.system,
        level="coordinates",
        bridge=bridge,
        positions=definition.coordinates,
        velocities=definition.velocities,
        time=definition.time,
        parameters=definition.parameters,
        rates=rates,
        mass=tuple(map(tuple, d.mass)),
        force=tuple(d.force),
        relations=definition.relations,
        meaning=meaning,
        dots=tuple(definition.coordinate_velocities),
        definitions=dict(zip(definition.velocities, d.definitions, strict=True)),
        momenta=dict(d.named_momenta),
        determinant=definition.determinant,
        turning=d.group_terms,
        conditions=definition.conditions,
    )


def solved_form(equations: DerivedEquations) -> FirstOrderForm | None:
    """vdot = mass^-1 force in the shortest form, kept with the equations: what mass and force share
    is gone.

    None where it is not tried, or beyond the budget.
    """
    return equations.memo.once("solved form", lambda: _solve(equations))


SHORT = 300
"""Forms that cost more operations are not solved: what comes out is longer, nearly always."""


def _solve(equations: DerivedEquations) -> FirstOrderForm | None:
    if equations.is_large or not equations.in_normal_form or equations.operations > SHORT:
        return None
    form, field = equations.exact.form, on_coordinates(equations)
    try:
        rates = tuple(shortest(field.accelerations, form.relations, form.velocities))
    except EngineLimit:
        return None
    size = range(len(rates))
    unit = tuple(tuple(se.Integer(int(i == j)) for j in size) for i in size)
    return replace(form, mass=unit, force=rates)
