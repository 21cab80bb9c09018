"""A nonholonomic system is a value: declarations only, nothing is derived here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.errors import DefinitionError
from voronec.geometry import Fibration, Frame

__all__ = ["Parameter", "Scene", "System"]


@dataclass(frozen=True)
class Parameter:
    """A constant of a system: its symbol, a default value, the range it may take.

    ``lower`` and ``upper`` are bounds that a value must not pass; ``positive`` asks for a value
    above zero.  ``meaning`` says in words what the constant is.  An unknown function of the time,
    ``f(t)``, is a parameter too: it is carried along exactly, and has no value.
    """

    symbol: sp.Expr
    value: Any = None
    positive: bool = False
    lower: Any = None
    upper: Any = None
    meaning: str = ""

    def __post_init__(self) -> None:
        if not is_symbolic_name(self.symbol):
            raise DefinitionError(f"parameter '{self.symbol}' is not a symbol; use sympy.Symbol")
        if self.value is not None:
            self.check(self.value)

    @property
    def name(self) -> str:
        """The parameter's name."""
        return plain_name(self.symbol)

    def check(self, value: Any) -> None:
        """Raise ``DefinitionError`` where ``value`` lies outside the declared range."""
        number = sp.sympify(value)
        if not number.is_number or number.is_real is False:
            raise DefinitionError(f"parameter '{self.name}' = {value} is not a real number")
        if self.positive and not number > 0:
            raise DefinitionError(f"parameter '{self.name}' = {value} must be positive")
        if self.lower is not None and number < sp.sympify(self.lower):
            raise DefinitionError(f"parameter '{self.name}' = {value} is below {self.lower}")
        if self.upper is not None and number > sp.sympify(self.upper):
            raise DefinitionError(f"parameter '{self.name}' = {value} is above {self.upper}")


@dataclass(frozen=True)
class Scene:
    """One motion to look at: initial data, a time span, and what is wanted from it.

    ``initial`` gives coordinates and velocities (quasi-velocities of the frame, or coordinate
    velocities of the base) by symbol or name; what is not named starts at zero.  ``parameters``
    overrides defaults.  ``times`` is ``(start, end)``.  ``outputs`` are coordinates, velocities
    or expressions in them; empty means all coordinates and velocities.
    """

    initial: Mapping[Any, Any]
    times: tuple[float, float] = (0.0, 10.0)
    parameters: Mapping[Any, Any] = field(default_factory=dict)
    outputs: tuple[Any, ...] = ()
    caption: str = ""


@dataclass(frozen=True)
class System:
    """A nonholonomic system: the contract between a plugin and the engine.

    name
        what ``voronec show NAME`` calls it; letters, digits and hyphens.
    fibration
        ``Fibration(base, fibre)``; the constraints must determine the fibre velocities.
    lagrangian
        L(q, qdot, t), any expression of coordinates, their velocities, parameters and the time.
    constraints
        expressions that vanish, affine in the velocities; as many as there are fibre coordinates.
    parameters
        ``Parameter(symbol, value, ...)``, or a bare symbol for one without a default value.
    forces
        coordinate -> generalized force, for what does not come from the Lagrangian.
    frame
        quasi-velocities, ``Frame.quasi({v: expression, ...})``; the base velocities by default.
    integrals, measure
        claims: name -> first integral; density of an invariant measure in the coordinates and
        the velocities of the equations.
    invariants
        name -> function of the coordinates to which the equations are claimed to descend.
    scenes
        name -> ``Scene``; the one called ``default`` is what ``voronec run NAME`` shows.
    references
        keys of a bibliography; ``title`` and ``description`` say what it is in words.
    drawing
        optional: a function of a trajectory that returns a matplotlib figure.
    motion
        a closed-form solution, where there is one.

    Expressions may use plain symbols or ``dynamicsymbols``.  A symbol that is none of these
    raises ``DefinitionError``, as does a name used twice.
    """

    name: str
    fibration: Fibration
    lagrangian: Any
    constraints: tuple[Any, ...] = ()
    parameters: tuple[Any, ...] = ()
    forces: Mapping[Any, Any] = field(default_factory=dict)
    frame: Frame | None = None
    integrals: Mapping[str, Any] = field(default_factory=dict)
    measure: Any = None
    invariants: Mapping[str, Any] = field(default_factory=dict)
    scenes: Mapping[str, Scene] = field(default_factory=dict)
    references: tuple[str, ...] = ()
    title: str = ""
    description: str = ""
    drawing: Any = None
    motion: Any = None

    def __post_init__(self) -> None:
        store = object.__setattr__
        store(self, "lagrangian", sp.sympify(self.lagrangian))
        store(self, "constraints", tuple(_vanishing(c) for c in self.constraints))
        parameters = (p if isinstance(p, Parameter) else Parameter(p) for p in self.parameters)
        store(self, "parameters", tuple(parameters))
        for name in ("forces", "integrals", "invariants"):
            values = {k: sp.sympify(v) for k, v in getattr(self, name).items()}
            store(self, name, MappingProxyType(values))
        store(self, "scenes", MappingProxyType(dict(self.scenes)))
        store(self, "references", tuple(self.references))
        if self.measure is not None:
            store(self, "measure", sp.sympify(self.measure))
        self._check_forces()
        self._check_repetitions()
        self._check_symbols()

    @property
    def coordinates(self) -> tuple[sp.Expr, ...]:
        """Base coordinates, then fibre coordinates."""
        return self.fibration.base + self.fibration.fibre

    @property
    def velocities(self) -> tuple[sp.Expr, ...]:
        """The independent velocities v of the equations: the frame's, else the base's."""
        if self.frame is not None:
            return self.frame.velocities
        return tuple(velocity(x) for x in self.fibration.base)

    def parameter(self, name: str) -> Parameter:
        """The parameter of that name."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise DefinitionError(f"system '{self.name}' has no parameter '{name}'")

    def known_symbols(self) -> tuple[sp.Expr, ...]:
        """Everything expressions may be made of, each once."""
        frame = self.frame.velocities if self.frame is not None else ()
        parameters = tuple(p.symbol for p in self.parameters)
        dots = tuple(velocity(x) for x in self.coordinates)
        return (*self.coordinates, *dots, *frame, *parameters, time)

    def _check_forces(self) -> None:
        for coordinate in self.forces:
            if coordinate not in self.coordinates:
                raise DefinitionError(
                    f"system '{self.name}': a force is given for '{coordinate}', which is not a "
                    f"coordinate; coordinates are {_listed(self.coordinates)}"
                )

    def _check_repetitions(self) -> None:
        names: dict[str, sp.Expr] = {}
        for thing in self.known_symbols():
            name = plain_name(thing)
            if name in names:
                raise DefinitionError(
                    f"system '{self.name}': the name '{name}' is used twice "
                    f"({_role(self, names[name])} and {_role(self, thing)}); rename one of them"
                )
            names[name] = thing

    def _check_symbols(self) -> None:
        places = {"the Lagrangian": self.lagrangian}
        places |= {f"constraint {i + 1}": c for i, c in enumerate(self.constraints)}
        places |= {f"the force on '{q}'": force for q, force in self.forces.items()}
        if self.frame is not None:
            pairs = zip(self.frame.velocities, self.frame.expressions, strict=True)
            places |= {f"the definition of '{v}'": e for v, e in pairs}
        places |= {f"integral '{key}'": e for key, e in self.integrals.items()}
        places |= {f"invariant '{key}'": e for key, e in self.invariants.items()}
        if self.measure is not None:
            places["the measure"] = self.measure
        places |= {f"relation {i + 1}": e for i, e in enumerate(self.fibration.relations)}
        known = set(self.known_symbols())
        for place, expr in places.items():
            unknown = sorted(map(str, _names_in(expr) - known))
            if unknown:
                raise DefinitionError(
                    f"system '{self.name}': {place} contains '{unknown[0]}', which is neither "
                    "coordinate, velocity nor parameter; declare it in parameters=(...) or the "
                    "fibration" + _same_name_hint(unknown[0], known)
                )


def _vanishing(constraint: Any) -> sp.Expr:
    """A constraint as an expression that vanishes; ``sympy.Eq`` is accepted."""
    constraint = sp.sympify(constraint)
    if isinstance(constraint, sp.Equality):
        return constraint.lhs - constraint.rhs
    if not isinstance(constraint, sp.Expr):
        raise DefinitionError(f"constraint '{constraint}' is not an expression that vanishes")
    return constraint


def _names_in(expr: sp.Expr) -> set[sp.Expr]:
    """The symbols, functions of time and their derivatives that occur in an expression."""
    found: set[sp.Expr] = set()
    stack = [expr]
    while stack:
        node = stack.pop()
        if is_symbolic_name(node) or (isinstance(node, sp.Derivative) and node.variables == (time,) * len(node.variables)):
            found.add(node)
        elif isinstance(node, sp.Subs):
            stack.extend(node.point)
            stack.extend(s for s in node.expr.free_symbols - set(node.variables))
        else:
            stack.extend(node.args)
    return found


def _listed(things: tuple[Any, ...]) -> str:
    return ", ".join(f"'{plain_name(t)}'" for t in things)


def _role(system: System, thing: sp.Expr) -> str:
    if thing in system.coordinates:
        return "a coordinate"
    if thing == time:
        return "the time"
    if thing in [p.symbol for p in system.parameters]:
        return "a parameter"
    if system.frame is not None and thing in system.frame.velocities:
        return "a quasi-velocity"
    return "the velocity of a coordinate"


def _same_name_hint(name: str, known: set[sp.Expr]) -> str:
    same = [k for k in known if str(k) == name]
    return " (a different symbol of that name is declared: use one symbol object)" if same else ""
