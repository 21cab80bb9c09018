"""A nonholonomic system is a value: declarations only, nothing is derived here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from voronec.algebra.symbols import functions_of_time, is_symbolic_name, time, velocity
from voronec.declaration import checks
from voronec.declaration.charts import Chart
from voronec.declaration.claims import Case, Poisson, read_claims, right_of
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.quadrature_fit import check_motion
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.reading import expression, mapping, several, shown, vanishing
from voronec.declaration.scene import Parameter, Scene
from voronec.errors import DefinitionError

__all__ = ["System", "require_system"]


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
    possible
        in words, what parameters must meet together for such a body to exist -> the condition, a
        relation of SymPy's or several joined: ``{"3 A < 2 m R^2, as ...": 3*A < 2*m*R**2}``.
        Claims are proved, and refuted, for such bodies only.
    forces
        coordinate -> generalized force, for what does not come from the Lagrangian.
    frame
        quasi-velocities, ``Frame.quasi({v: expression, ...})``, or the frame of a Lie group,
        ``Frame.group(...)``; the base velocities by default.
    invariants
        name -> function of the coordinates to which the equations are claimed to descend.
    integrals, equations, measure
        claims: name -> first integral; name -> ``Equation(function, rate)``; the density of an
        invariant measure in the coordinates and the velocities of the equations, or a
        ``Measure``.  A ``Corrected`` in the place of one stands for a claim misprinted elsewhere.
    multiplier
        claim: a function N of the base coordinates such that with dtau = N dt the equations are
        those of a Lagrangian, Lc written with the new velocities (Chaplygin's reducing multiplier).
    poisson
        claim: a ``Poisson`` bracket and Hamiltonian.
    essential
        claim: variables whose rates depend on nothing but them, the parameters and the time.
    integrable
        claim: ``"Euler-Jacobi"`` where the integrals and the measure suffice for the theorem of
        Euler and Jacobi.
    cases
        name -> ``Case``: claims under special values of parameters.
    undecided
        name of a claim -> why the engine cannot decide it; a measure, a bracket and the like, which
        have no names, are called by their kind: ``measure``, ``poisson``.
    charts
        name -> ``Chart``: other coordinates of the same motion, in which it goes on near a
        singularity of these.
    scenes
        name -> ``Scene``; the one called ``default`` is what ``voronec run NAME`` shows.
    references
        keys of a bibliography; ``title`` and ``description`` say what it is in words.
    drawing
        optional: a function of a trajectory that returns a matplotlib figure, or a mapping of
        titles to pairs (colatitude, longitude) of coordinates, drawn as traces on spheres.
    motion
        ``Quadratures``: the motion in closed form, where there is one.
    inputs
        what moves the system from outside: symbols, or functions u(t), whose values are given at
        run time.  A function of the time that is nothing else is one without being declared.

    Expressions may use plain symbols or ``dynamicsymbols``; the Lagrangian, the forces and the
    constraints may use quasi-velocities too, which stand for their definitions.  Forces may be
    linear in accelerations, ``velocity(velocity(q))``: these become part of the mass matrix.  One
    constraint, parameter or reference may stand without a tuple.  A symbol that is none of these
    raises ``DefinitionError``, as does a name used twice.
    """

    name: str
    fibration: Fibration
    lagrangian: Any
    constraints: tuple[Any, ...] = ()
    parameters: tuple[Any, ...] = ()
    possible: Mapping[str, Any] = field(default_factory=dict)
    forces: Mapping[Any, Any] = field(default_factory=dict)
    frame: Frame | None = None
    integrals: Mapping[str, Any] = field(default_factory=dict)
    measure: Any = None
    invariants: Mapping[str, Any] = field(default_factory=dict)
    equations: Mapping[str, Any] = field(default_factory=dict)
    multiplier: Any = None
    poisson: Poisson | None = None
    essential: tuple[Any, ...] = ()
    integrable: str = ""
    cases: Mapping[str, Case] = field(default_factory=dict)
    undecided: Mapping[str, str] = field(default_factory=dict)
    charts: Mapping[str, Chart] = field(default_factory=dict)
    scenes: Mapping[str, Scene] = field(default_factory=dict)
    references: tuple[str, ...] = ()
    title: str = ""
    description: str = ""
    drawing: Any = None
    motion: Quadratures | None = None
    inputs: tuple[Any, ...] = ()

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
        checks.check_possible(self)
        checks.check_forces(self)
        checks.check_names(self)
        checks.check_symbols(self)
        checks.check_frame(self)
        checks.check_relations(self)
        checks.check_claims(self)
        checks.check_charts(self)
        check_motion(self)

    def _check_kinds(self) -> None:
        """A fibration and a frame come ready made, invariants by name."""
        for name in self.invariants if isinstance(self.invariants, Mapping) else ():
            if not isinstance(name, str):
                raise DefinitionError(
                    f"system '{self.name}': the invariant '{shown(name)}' is no name; give a text"
                )
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
            ("invariants", "invariant", "'name': expression"),
        ):
            values = mapping(getattr(self, name), name, entry)
            read = {k: expression(v, f"{one} '{shown(k)}'") for k, v in values.items()}
            store(name, mapping(read, name, entry))
        for name, value in read_claims(self).items():
            store(name, value)
        entry = "'in words': condition"
        store("possible", mapping(self.possible, "possible", entry))
        if self.multiplier is not None:
            store("multiplier", expression(self.multiplier, "the multiplier"))
        store("essential", several(self.essential, "essential", "symbol"))
        store("undecided", mapping(self.undecided, "undecided", "'claim': 'reason'"))
        store("references", several(self.references, "references", "'Key'"))
        for name, kind, entry in (
            ("charts", Chart, "Chart(state={...}, singular=...)"),
            ("scenes", Scene, "Scene(initial={...}, times=...)"),
            ("cases", Case, "Case(parameters={...}, integrals={...})"),
        ):
            store(name, _all_of(getattr(self, name), name, kind, entry))
        if self.poisson is not None and not isinstance(self.poisson, Poisson):
            raise DefinitionError(
                f"poisson is '{shown(self.poisson)}'; write Poisson(variables, bracket, ...)"
            )
        if self.motion is not None:
            if not isinstance(self.motion, Quadratures):
                raise DefinitionError(
                    f"motion is '{shown(self.motion)}'; write Quadratures(variable={{...}}, ...)"
                )
            store("motion", self.motion.titled(self.drawing))
        store("inputs", self._all_inputs())

    def _all_inputs(self) -> tuple[sp.Expr, ...]:
        """Those declared, then parameters that are functions, then undeclared functions of time."""
        declared = several(self.inputs, "inputs", "symbol")
        for thing in declared:
            if not is_symbolic_name(thing):
                raise DefinitionError(f"the input '{shown(thing)}' is not a symbol, nor u(t)")
        functions = [p.symbol for p in self.parameters if not isinstance(p.symbol, sp.Symbol)]
        frame = self.frame
        held = [self.lagrangian, *self.constraints, *self.forces.values()]
        held += [*self.fibration.relations, *(frame.expressions if frame is not None else ())]
        found = set().union(*map(functions_of_time, held))
        found -= {*self.coordinates, *(frame.ambient if frame is not None else ())}
        return tuple(dict.fromkeys([*declared, *functions, *sorted(found, key=str)]))

    @property
    def coordinates(self) -> tuple[sp.Expr, ...]:
        """Base coordinates, then fibre coordinates."""
        return self.fibration.base + self.fibration.fibre

    @property
    def conditions(self) -> tuple[Any, ...]:
        """What parameters meet, as relations of SymPy's: their ranges, and what is ``possible``."""
        ranges = tuple(c for p in self.parameters for c in p.conditions)
        return (*ranges, *self.possible.values())

    @property
    def velocities(self) -> tuple[sp.Expr, ...]:
        """The independent velocities v of the equations: the frame's, else the base's."""
        if self.frame is not None:
            return self.frame.velocities
        return tuple(velocity(x) for x in self.fibration.base)

    @property
    def accelerations(self) -> tuple[sp.Expr, ...]:
        """What forces may hold linearly: second derivatives of the coordinates, rates of the
        frame's velocities."""
        if self.on_group:
            return ()
        return tuple(velocity(v) for v in (*map(velocity, self.coordinates), *self.velocities))

    @property
    def on_group(self) -> bool:
        """Whether the frame is that of a group: its velocities stand for those of coordinates."""
        return self.frame is not None and self.frame.is_group

    @property
    def directions(self) -> tuple[sp.Expr, ...]:
        """Along which forces act and constraints bind: coordinates, or velocities of a group, those
        of the base before those of the fibre."""
        if self.frame is not None and self.frame.is_group:
            return self.frame.ambient
        return self.coordinates

    @property
    def base_directions(self) -> int:
        """How many of the directions are of the base."""
        return len(self.velocities if self.on_group else self.fibration.base)

    @property
    def invariant_symbols(self) -> tuple[sp.Symbol, ...]:
        """The names of the invariants, as symbols that stand for them in claims."""
        return tuple(sp.Symbol(name) for name in self.invariants)

    @property
    def conserved(self) -> Mapping[str, sp.Expr]:
        """The integrals as functions of coordinates and velocities: of a corrected one the right
        form, and invariants written out."""
        meaning = dict(zip(self.invariant_symbols, self.invariants.values(), strict=True))
        return {name: right_of(e).xreplace(meaning) for name, e in self.integrals.items()}

    def known_symbols(self) -> tuple[sp.Expr, ...]:
        """Everything expressions may be made of, each once."""
        frame = self.frame.ambient if self.frame is not None else ()
        parameters = tuple(p.symbol for p in self.parameters)
        dots = tuple(velocity(x) for x in self.coordinates)
        rates = tuple(velocity(u) for u in self.inputs)
        known = (*self.coordinates, *dots, *frame, *parameters, *self.inputs, *rates, time)
        return tuple(dict.fromkeys(known))


def _all_of(things: Any, place: str, kind: type, entry: str) -> Mapping[str, Any]:
    """A mapping of names to values of one kind."""
    values = mapping(things, place, f"'name': {entry}")
    for name, value in values.items():
        if not isinstance(value, kind):
            raise DefinitionError(
                f"{place.removesuffix('s')} '{name}' is '{shown(value)}'; write {entry}"
            )
    return values


def require_system(thing: Any) -> System:
    """``thing`` itself where it is a ``System``; else ``DefinitionError``, which says the mend."""
    if isinstance(thing, System):
        return thing
    text = isinstance(thing, str)
    mend = f"voronec.load('{shown(thing)}') may give it" if text else "give a System"
    raise DefinitionError(f"'{shown(thing)}' is not a voronec.System; {mend}")
