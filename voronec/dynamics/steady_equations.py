"""What vanishes at a steady motion: the rates of the smallest formulation, and what binds it.

    f(x, p) = 0,   r(x, p) = 0,   h(x, p) = c

x are the variables on which the accelerations depend, cyclic coordinates left out, so that a
relative equilibrium is a point; r are the relations of redundant variables; h are integrals of the
constraints (leaf functions), and what a user holds.  Values and slopes are one straight-line
program, evaluated in doubles or in balls.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import flint
import numpy as np
import symengine as se
import sympy as sp

from voronec.algebra.memo import Memo
from voronec.algebra.symbols import plain_name
from voronec.algebra.tape import as_ball
from voronec.algebra.terms import atoms
from voronec.algebra.text import name_or_formula
from voronec.declaration.claims import right_of
from voronec.declaration.reading import expression, quote
from voronec.declaration.system import System
from voronec.dynamics.joint_function import JointFunction
from voronec.dynamics.natural_integrals import LEAF, natural_integrals
from voronec.equations.motions import Motions
from voronec.equations.program import Block, Program
from voronec.equations.program.straight import fresh_names, share_subexpressions
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError, VoronecError, did_you_mean
from voronec.motion.formulation import (
    Formulation,
    SmallestModels,
    constants,
    dependence,
    keep_relations,
    needed_variables,
    restrict,
)
from voronec.motion.request import Namespace, number
from voronec.motion.verify import is_proved

RECENT = 64
"""Values at so many points are kept: tangents and slopes ask for them again."""


@dataclass(frozen=True, eq=False)
class SteadyEquations:
    """F(y) with its Jacobian: of each unknown's rate, then of relations, then of ``held``.

    ``unknowns`` are the states, then parameters or inputs that are to be found; ``values`` are
    those of all other constants, exact where they were given so; ``targets`` those of what is held.
    """

    formulation: Formulation
    rates: Program
    unknowns: tuple[Any, ...]
    held: tuple[tuple[str, Any], ...]
    values: Mapping[str, Any]
    targets: Mapping[str, Any]
    memo: Memo = field(default_factory=Memo, repr=False)

    @property
    def system(self) -> System:
        """The system."""
        subject: System = self.formulation.system
        return subject

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the unknowns."""
        return tuple(map(str, self.unknowns))

    @property
    def size(self) -> int:
        """How many states there are."""
        return len(self.rates.state)

    @property
    def constants(self) -> tuple[str, ...]:
        """The names of parameters and inputs that may be found or changed."""
        frozen = {*map(str, constants_of(self.formulation))}
        symbols = (*self.rates.parameters, *self.rates.inputs)
        return tuple(str(p) for p in symbols if str(p) not in frozen)

    def with_unknowns(self, names: Iterable[str]) -> SteadyEquations:
        """The equations with further constants among the unknowns."""
        more = tuple(se.Symbol(n) for n in names if n not in self.names)
        return replace(self, unknowns=(*self.unknowns, *more)) if more else self

    def fix(self, given: Mapping[str, tuple[Any, Any]]) -> SteadyEquations:
        """The equations in which further expressions are held: {name: (expression, value)}."""
        more = {name: e for name, (e, _) in given.items()}
        held = {**dict(self.held), **more}
        values = {**self.targets, **{name: x for name, (_, x) in given.items()}}
        return replace(self, held=tuple(held.items()), targets=values)

    def only_leaves(self, but: Collection[str] = ()) -> SteadyEquations:
        """The equations in which leaf functions alone are held, but those named ``but``."""
        held = (pair for pair in self.held if pair[0] in self.leaves and pair[0] not in but)
        return replace(self, held=tuple(held))

    @property
    def leaves(self) -> dict[str, Any]:
        """Integrals of the constraints: functions of the coordinates alone."""
        still = {*self.system.coordinates, *(p.symbol for p in self.system.parameters)}
        integrals = self.formulation.integrals.items()
        declared = self.system.integrals
        return {
            n: e
            for n, e in integrals
            if (_is_of(declared[n], still) if n in declared else n.startswith(LEAF))
        }

    def proved_integrals(self, equations: VoronecEquations) -> dict[str, Any]:
        """The integrals that are proved, on the formulation, but those that hold the time."""
        natural, time = natural_integrals(equations), self.rates.time
        autonomous = {
            n: e for n, e in self.formulation.integrals.items() if time not in e.free_symbols
        }
        return {n: e for n, e in autonomous.items() if n in natural or is_proved(equations, n)}

    def constants_of_motion(self, equations: VoronecEquations) -> dict[str, tuple[Any, Any]]:
        """Relations, leaf functions and proved integrals, with their values where these are
        known, else None."""
        relations = enumerate(self.formulation.relations, 1)
        vanishing: dict[str, tuple[Any, Any]] = {f"relation {i}": (r, 0) for i, r in relations}
        proved = self.proved_integrals(equations)
        known = {n: (e, self.targets[n]) for n, e in proved.items()
                 if n in self.leaves and n in self.targets}  # fmt: skip
        return vanishing | known | {n: (e, None) for n, e in proved.items() if n not in known}

    @cached_property
    def _joint(self) -> JointFunction:
        """F without its targets; it is made once for all values."""
        joint: JointFunction = self.memo.once((self.unknowns, self.held), self._write)
        return joint.with_values(self.values)

    def _write(self) -> JointFunction:
        derivative = self.rates.derivative
        fresh = fresh_names([*self.symbols, *(n for n, _ in derivative.assignments)], "h")
        beside = [*self.formulation.relations, *(e for _, e in self.held)]
        more = share_subexpressions(beside, fresh, self.formulation.stages)
        rows = Block(
            (*derivative.assignments, *more.assignments), (*derivative.results, *more.results)
        )
        return JointFunction.of(self.rates.time, self.symbols[1:], rows, self.unknowns)

    @cached_property
    def logarithms(self) -> JointFunction:
        """What vanishes where a logarithm has no value."""
        rows = self._joint.rows
        functions = atoms([*(e for _, e in rows.assignments), *rows.results], se.log)
        named = dict(rows.assignments)
        inner = (named.get(f.args[0], f.args[0]) for f in functions)
        bases = tuple(e.args[0] if isinstance(e, se.Pow) else e for e in inner)
        block = share_subexpressions(bases, fresh_names([*self.symbols, *named]), rows.assignments)
        time, *symbols = self.symbols
        return JointFunction.of(time, symbols, block, self.unknowns).with_values(self.values)

    @property
    def symbols(self) -> tuple[Any, ...]:
        """The time, the states, the parameters and the inputs."""
        rates = self.rates
        return (rates.time, *rates.state, *rates.parameters, *rates.inputs)

    @cached_property
    def _recent(self) -> dict[bytes, tuple[np.ndarray, np.ndarray]]:
        """What was computed last, by the point."""
        return {}

    @cached_property
    def _targets(self) -> list[Any]:
        return [self.targets[name] for name, _ in self.held]

    @cached_property
    def _target_doubles(self) -> np.ndarray:
        return np.array([number(x, "a value that is held") for x in self._targets])

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (m,) and its Jacobian (m, n) in doubles; not finite where there is no value."""
        key = y.tobytes()
        if key not in self._recent:
            if len(self._recent) >= RECENT:
                self._recent.clear()
            self._recent[key] = self._at(y)
        return self._recent[key]

    def matrix(self, y: np.ndarray) -> np.ndarray:
        """The matrix A (n, n) of the linearisation dx' = A dx at a steady motion."""
        return self.at(y)[1][: self.size, : self.size]

    def _at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        values, slopes = self._joint.at(y)
        values[len(values) - len(self.held) :] -= self._target_doubles
        return values, slopes

    def balls(self, y: Sequence[Any], bits: int) -> list[Any]:
        """F enclosed at balls y.  ``EngineLimit`` where a function has no evaluation in balls."""
        values = self._joint.balls(y, bits)
        with flint.ctx.workprec(bits):
            for i, target in enumerate(self._targets, len(values) - len(self.held)):
                values[i] -= as_ball(target)
        return values

    def slopes_in_balls(self, y: Sequence[Any], bits: int) -> Any:
        """The Jacobian of F enclosed at balls y, an ``arb_mat``."""
        return self._joint.slopes_in_balls(y, bits)


def _is_of(integral: Any, symbols: Collection[Any]) -> bool:
    """Whether a claimed integral holds these symbols alone."""
    function = right_of(integral)
    return bool(function.free_symbols <= {*symbols}) and not function.has(sp.Derivative)


def constants_of(formulation: Formulation) -> tuple[Any, ...]:
    """Parameters of a formulation that are constant variables."""
    declared = {p.name for p in formulation.system.parameters} | {
        plain_name(u) for u in formulation.system.inputs
    }
    return tuple(p for p in formulation.parameters if str(p) not in declared)


def steady_formulation(equations: VoronecEquations) -> Formulation:
    """The smallest formulation for the velocities: what accelerations do not depend on is left out,
    constant variables are parameters.  It is kept with the equations."""
    return equations.memo.once("steady formulation", lambda: _make(equations))


def _make(equations: VoronecEquations) -> Formulation:
    space = Namespace.of(equations)
    wanted = space.read_outputs(equations.system.velocities).terms
    integrals = {name: space.claims[name] for name in equations.system.integrals}
    integrals |= natural_integrals(equations)
    formulation = SmallestModels.of(Motions.of(equations), wanted, integrals).general.full
    kept = needed_variables(formulation, dependence(formulation))
    still = constants(formulation)
    formulation = replace(formulation, parameters=(*formulation.parameters, *still))
    return keep_relations(restrict(formulation, [x for x in kept if x not in still]))


def steady_equations(
    equations: VoronecEquations,
    parameters: Mapping[str, Any],
    start: Mapping[str, Any],
) -> SteadyEquations:
    """The equations with the values of all parameters and inputs; what has none stays open, and
    ``start`` tells where leaf functions are read off.

    ``DefinitionError`` where the system depends on the time, and where nothing changes.
    """
    formulation = steady_formulation(equations)
    program = Program.of(formulation.form)
    system = equations.system
    if program.time in program.derivative.symbols:
        raise DefinitionError(
            f"system '{system.name}' depends on the time: it has no steady motions; make what "
            "moves a coordinate, or an input"
        )
    if not program.state:
        raise DefinitionError(
            f"system '{system.name}': its velocities are constant in every motion, so that all its "
            "motions are steady"
        )
    if program.has_corners:
        raise DefinitionError(
            f"system '{system.name}': its right side is not smooth (signs, steps or corners stand "
            "in it), so that it has no Jacobian; replace what is not smooth"
        )
    values: dict[str, Any] = {p.name: p.value for p in system.parameters if p.value is not None}
    values |= {str(x): start.get(str(x), 0) for x in constants_of(formulation)}
    values |= parameters
    problem = SteadyEquations(formulation, program, program.state, (), values, {})
    given = {n: (e, _value_there(e, {**start, **values})) for n, e in problem.leaves.items()}
    return problem.fix({n: (e, x) for n, (e, x) in given.items() if x is not None})


def _value_there(expr: Any, at: Mapping[str, Any]) -> Any:
    """The value of a leaf function at the start, with coordinates that are not told zero; None
    where that is no number."""
    symbols = {s: as_symengine(at.get(str(s), 0)) for s in expr.free_symbols}
    try:
        value = expr.xreplace(symbols)._sympy_()
    except (RuntimeError, TypeError, ValueError):
        return None
    return value if value.is_number and value.is_finite else None


def as_symengine(value: Any) -> Any:
    """A value for an expression."""
    return se.sympify(expression(value, "a value"))


def read_quantity(equations: SteadyEquations, motions: Motions, key: Any) -> tuple[str, Any]:
    """What a user names - a variable, an integral, a constant or a formula in these - as an
    expression on the formulation."""
    formulation, system = equations.formulation, equations.system
    symbols = {str(x): x for x in (*formulation.variables, *formulation.parameters)}
    symbols |= {str(x): x for x in equations.rates.inputs}
    known = {**symbols, **formulation.integrals}
    name = plain_name(key)
    if name in known:
        return name, known[name]
    place = f"system '{system.name}': '{quote(name)}'"
    read = name_or_formula(key, place) if isinstance(key, str) else expression(key, place)
    if isinstance(read, str):
        space = Namespace.of(motions.equations)
        if read not in space.known:
            raise DefinitionError(f"{place} is unknown{did_you_mean(read, [*known])}")
        read = space.known[read]
    try:
        flow = motions.at(
            "invariants" if formulation.name.startswith("invariants") else "coordinates"
        )
        expr = flow.read(read)
    except VoronecError:
        expr = motions.equations.bridge.inward(read)
    if expr.free_symbols <= {*symbols.values()}:
        return name, expr
    raise DefinitionError(
        f"{place} is no function of the variables of steady motions; name some of "
        f"{', '.join(known)}, or a formula in them"
    )


def check_parameters(system: System, *given: tuple[str, Any]) -> None:
    """``DefinitionError`` where a parameter leaves the range that is declared for it."""
    declared = {p.name: p for p in system.parameters}
    for name, value in given:
        if name in declared:
            declared[name].check(value)


def require_values(equations: SteadyEquations) -> None:
    """``DefinitionError`` where a parameter or input has no value."""
    system = equations.system
    for p in (*equations.rates.parameters, *equations.rates.inputs):
        if p not in equations.unknowns and equations.values.get(str(p)) is None:
            raise DefinitionError(
                f"system '{system.name}': '{p}' has no value; give parameters={{'{p}': number}}, "
                f"or find it: free=('{p}',)"
            )
