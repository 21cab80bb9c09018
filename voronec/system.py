"""A nonholonomic system is a value: declarations only, nothing is derived here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from voronec import checks
from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.errors import DefinitionError
from voronec.geometry import Fibration, Frame
from voronec.reading import expression, mapping, real_number, several, shown, vanishing

__all__ = ["Parameter", "Scene", "System", "require_system"]


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
            raise DefinitionError(
                f"parameter '{shown(self.symbol)}' is not a symbol; use sympy.Symbol"
            )
        for bound in ("lower", "upper"):
            if getattr(self, bound) is not None:
                real_number(getattr(self, bound), f"parameter '{self.name}': {bound}")
        if self.value is not None:
            self.check(self.value)

    @property
    def name(self) -> str:
        """The parameter's name."""
        return plain_name(self.symbol)

    def check(self, value: Any) -> None:
        """Raise ``DefinitionError`` where ``value`` lies outside the declared range."""
        number = real_number(value, f"parameter '{self.name}'")
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

    def __post_init__(self) -> None:
        mapping(self.initial, "initial", "coordinate or velocity: value")
        mapping(self.parameters, "parameters", "parameter: value")


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
        optional: a function of a trajectory that returns a matplotlib figure, or a mapping of
        titles to pairs (colatitude, longitude) of coordinates, drawn as traces on spheres.
    motion
        a closed-form solution, where there is one.

    Expressions may use plain symbols or ``dynamicsymbols``; the Lagrangian, the forces and the
    constraints may use quasi-velocities too, which stand for their definitions.  One constraint,
    parameter or reference may stand without a tuple.  A symbol that is none of these raises
    ``DefinitionError``, as does a name used twice.
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
        if not isinstance(self.name, str) or not self.name:
            raise DefinitionError(
                f"the name of a system is {shown(self.name)!r}, not a text; write name='my-system'"
            )
        self._check_kinds()
        try:
            self._read()
        except DefinitionError as error:
            raise DefinitionError(f"system '{self.name}': {error}") from None
        checks.check_forces(self)
        checks.check_names(self)
        checks.check_symbols(self)
        checks.check_frame(self)
        checks.check_relations(self)

    def _check_kinds(self) -> None:
        """A fibration and a frame come ready made."""
        if not isinstance(self.fibration, Fibration):
            raise DefinitionError(
                f"system '{self.name}': the fibration is '{shown(self.fibration)}'; "
                "write Fibration(base=(...), fibre=(...))"
            )
        if self.frame is not None and not isinstance(self.frame, Frame):
            raise DefinitionError(
                f"system '{self.name}': the frame is '{shown(self.frame)}'; "
                "write Frame.quasi({velocity: expression})"
            )

    def _read(self) -> None:
        """Bring every declaration into its final form."""

        def store(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        store("lagrangian", expression(self.lagrangian, "the Lagrangian"))
        given = enumerate(several(self.constraints, "constraints", "expression"))
        store("constraints", tuple(vanishing(c, f"constraint {i + 1}") for i, c in given))
        parameters = several(self.parameters, "parameters", "Parameter(symbol, value)", Parameter)
        store(
            "parameters", tuple(p if isinstance(p, Parameter) else Parameter(p) for p in parameters)
        )
        for name, one, entry in (
            ("forces", "the force on", "coordinate: force"),
            ("integrals", "integral", "'name': expression"),
            ("invariants", "invariant", "'name': expression"),
        ):
            values = mapping(getattr(self, name), name, entry)
            read = {k: expression(v, f"{one} '{shown(k)}'") for k, v in values.items()}
            store(name, mapping(read, name, entry))
        scenes = mapping(self.scenes, "scenes", "'default': Scene(...)")
        for name, scene in scenes.items():
            if not isinstance(scene, Scene):
                raise DefinitionError(
                    f"scene '{name}' is '{shown(scene)}'; write Scene(initial={{...}}, times=...)"
                )
        store("scenes", scenes)
        store("references", several(self.references, "references", "'Key'"))
        if self.measure is not None:
            store("measure", expression(self.measure, "the measure"))

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

    def known_symbols(self) -> tuple[sp.Expr, ...]:
        """Everything expressions may be made of, each once."""
        frame = self.frame.velocities if self.frame is not None else ()
        parameters = tuple(p.symbol for p in self.parameters)
        dots = tuple(velocity(x) for x in self.coordinates)
        return (*self.coordinates, *dots, *frame, *parameters, time)


def require_system(thing: Any) -> System:
    """``thing`` itself where it is a ``System``; else ``DefinitionError``, which says the mend."""
    if isinstance(thing, System):
        return thing
    mend = f"voronec.load('{thing}') may give it" if isinstance(thing, str) else "give a System"
    raise DefinitionError(f"'{shown(thing)}' is not a voronec.System; {mend}")
