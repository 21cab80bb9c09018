"""A nonholonomic system is a value: declarations only, nothing is derived here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import sympy as sp
from sympy.logic.boolalg import Boolean

from voronec.algebra.arguments import takes_fields
from voronec.algebra.memo import Memo
from voronec.algebra.symbols import (
    functions_of_time,
    is_symbolic_name,
    names_in,
    plain_name,
    time,
    velocity,
)
from voronec.algebra.text import as_expression
from voronec.algebra.typeset import html_table, latex_of
from voronec.declaration.bodies import Body
from voronec.declaration.charts import Chart
from voronec.declaration.claims import (
    KINDS,
    THEOREMS,
    Case,
    Corrected,
    Measure,
    Poisson,
    claim_names,
    declared_claims,
    expressions_of,
    read_claims,
    right_of,
    without_claims,
)
from voronec.declaration.geometry import Fibration, Frame, along_coordinates
from voronec.declaration.quadratures import Quadratures
from voronec.declaration.reading import (
    expression,
    fixed_mapping,
    quote,
    require_known,
    several,
    vanishing_expression,
)
from voronec.declaration.scene import Parameter, Scene
from voronec.declaration.shapes import MESH, Shape
from voronec.declaration.sketch import Sketch
from voronec.errors import DefinitionError, did_you_mean


@takes_fields
@dataclass(frozen=True, repr=False)
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
        One without velocities, as that of a closed loop, becomes a relation of the fibration: the
        coordinates are redundant, it is differentiated, and the start must satisfy it.
    parameters
        ``Parameter(symbol, value, ...)``, or a bare symbol for one without a default value.
    possible
        in words, what parameters must meet together for such a body to exist -> the condition, a
        relation of SymPy's or several joined: ``{"3 A < 2 m R^2, as ...": 3*A < 2*m*R**2}``.
        Claims are proved, and refuted, for such bodies only.
    forces
        coordinate -> generalized force, for what does not come from the Lagrangian; or velocity ->
        force that does the work force * velocity, quasi-velocities and combinations of velocities
        among them; each by symbol or name.  What is along velocities is kept along the coordinates.
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
    assertions
        name -> ``Assertion``: a claim of a kind of one's own, with how it is decided.
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
    shapes
        ``Shape``: bodies, and surfaces that they roll on, with their places as expressions, for the
        viewer (``voronec view``).
    bodies
        ``Body``: rigid bodies with their velocities and what acts on them, for the method of Newton
        and Euler (``voronec methods``); they change nothing of the equations.
    motion
        ``Quadratures``: the motion in closed form, where there is one.
    meanings
        coordinate, velocity, integral, invariant or input, by symbol or name -> what it is, in
        words.
    sketch
        a ``Sketch`` of the mechanism with its coordinates named.
    inputs
        what moves the system from outside: symbols, or functions u(t), whose values are given at
        run time.  A function of the time that is nothing else is one without being declared.

    Expressions may use plain symbols or ``dynamicsymbols``; the Lagrangian, the forces and the
    constraints may use quasi-velocities too, which stand for their definitions.  Forces may be
    linear in accelerations, ``velocity(velocity(q))``: these become part of the mass matrix.  One
    constraint, parameter or reference may stand without a tuple.  A symbol that is none of these
    raises ``DefinitionError``, as does a name used twice.  Angles are in radians, all else is in
    units of the user's that fit together.
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
    assertions: Mapping[str, Any] = field(default_factory=dict)
    meanings: Mapping[Any, str] = field(default_factory=dict)
    shapes: tuple[Shape, ...] = ()
    sketch: Sketch | None = None
    bodies: tuple[Body, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise DefinitionError(
                f"the name of a system is {quote(self.name)!r}, not a text; write name='my-system'"
            )
        try:
            self._check_kinds()
            self._read()
            for check in CHECKS:
                check(self)
        except DefinitionError as error:
            raise DefinitionError(f"system '{quote(self.name)}': {error}") from None

    def _check_kinds(self) -> None:
        """A fibration, a frame and a sketch come ready made, invariants by name."""
        for name in self.invariants if isinstance(self.invariants, Mapping) else ():
            if not isinstance(name, str):
                raise DefinitionError(f"the invariant '{quote(name)}' is no name; give a text")
        for name, kind, mend in (
            ("fibration", Fibration, "Fibration(base=(...), fibre=(...))"),
            ("sketch", Sketch, "Sketch('seen from above').axes('x', 'y')..."),
            ("frame", Frame, "Frame.quasi({velocity: expression})"),
        ):
            given = getattr(self, name)
            if not isinstance(given, kind) and (given is not None or name == "fibration"):
                raise DefinitionError(f"the {name} is '{quote(given)}'; write {mend}")

    def _read(self) -> None:
        """Bring every declaration into its final form."""
        # long because it is a list: one entry for each declaration, in the order of need

        def store(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        store("lagrangian", expression(self.lagrangian, "the Lagrangian"))
        given = enumerate(several(self.constraints, "constraints", "expression"))
        store(
            "constraints", tuple(vanishing_expression(c, f"constraint {i + 1}") for i, c in given)
        )
        self._take_loops(store)
        parameters = several(self.parameters, "parameters", "Parameter(symbol, value)", Parameter)
        store(
            "parameters", tuple(p if isinstance(p, Parameter) else Parameter(p) for p in parameters)
        )
        for name, one, entry in (
            ("forces", "the force on", "coordinate: force"),
            ("invariants", "invariant", "'name': expression"),
        ):
            store(name, _expressions_of(getattr(self, name), name, one, entry))
        spread = () if self.on_group else self.coordinates
        forces = along_coordinates(self.forces, spread, self.frame)
        store("forces", fixed_mapping(forces, "forces", "coordinate: force"))
        for name, value in read_claims(self).items():
            store(name, value)
        entry = "'in words': condition"
        store("possible", fixed_mapping(self.possible, "possible", entry))
        store("undecided", fixed_mapping(self.undecided, "undecided", "'claim': 'reason'"))
        store("essential", several(self.essential, "essential", "velocity"))
        store("references", several(self.references, "references", "'Key'"))
        for name, kind, entry in (
            ("charts", Chart, "Chart(state={...}, singular=...)"),
            ("scenes", Scene, "Scene(initial={...}, times=...)"),
            ("cases", Case, "Case(parameters={...}, integrals={...})"),
        ):
            store(name, _all_of(getattr(self, name), name, kind, entry))
        if self.motion is not None:
            store("motion", self._titled_motion())
        shape, body = "Shape.ball(radius, centre=(x, y, z))", "Body(mass, velocity, inertia, omega)"
        store("shapes", _several_of(self.shapes, "shapes", Shape, shape))
        store("bodies", _several_of(self.bodies, "bodies", Body, body))
        store("inputs", self._all_inputs())
        meanings = fixed_mapping(self.meanings, "meanings", "coordinate: 'in words'")
        named = {k if isinstance(k, str) else plain_name(k): v for k, v in meanings.items()}
        store("meanings", fixed_mapping(named, "meanings", "coordinate: 'in words'"))

    def _titled_motion(self) -> Quadratures:
        if not isinstance(self.motion, Quadratures):
            raise DefinitionError(
                f"motion is '{quote(self.motion)}'; write Quadratures(variable={{...}}, ...)"
            )
        return self.motion.with_titles(self.drawing)

    def _take_loops(self, store: Callable[[str, Any], None]) -> None:
        """Constraints that hold coordinates and no velocity, as those of a closed loop, become
        relations of redundant coordinates; on a group they stay, and are refused."""
        if self.on_group:
            return
        held, frame = set(self.coordinates), self.frame.velocities if self.frame is not None else ()
        moving = {*map(velocity, held), *frame}
        names = [names_in(c) for c in self.constraints]
        loops = [bool(n & held) and not n & moving for n in names]
        if any(loops):
            pairs = [*zip(self.constraints, loops, strict=True)]
            relations = (*self.fibration.relations, *(c for c, loop in pairs if loop))
            store("fibration", replace(self.fibration, relations=relations))
            store("constraints", tuple(c for c, loop in pairs if not loop))

    def _all_inputs(self) -> tuple[sp.Expr, ...]:
        """Those declared, then parameters that are functions, then undeclared functions of time."""
        declared = several(self.inputs, "inputs", "symbol")
        for thing in declared:
            if not is_symbolic_name(thing):
                raise DefinitionError(f"the input '{quote(thing)}' is not a symbol, nor u(t)")
            if thing.is_nonnegative or thing.is_nonpositive:
                raise DefinitionError(
                    f"the input '{quote(thing)}' is a symbol of one sign, by which SymPy shortens "
                    "what holds it; an input may take any value: give a symbol without assumptions"
                )
        functions = [p.symbol for p in self.parameters if not isinstance(p.symbol, sp.Symbol)]
        frame = self.frame
        held = [self.lagrangian, *self.constraints, *self.forces.values()]
        held += [*self.fibration.relations, *(frame.definitions.values() if frame else ())]
        held += [e for body in self.bodies for e in body.expressions]
        undeclared = set().union(*map(functions_of_time, held))
        undeclared -= {*self.coordinates, *(frame.ambient if frame is not None else ())}
        return tuple(dict.fromkeys([*declared, *functions, *sorted(undeclared, key=str)]))

    @cached_property
    def memo(self) -> Memo:
        """What is computed of it once."""
        return Memo()

    def __repr__(self) -> str:
        names = (", ".join(map(plain_name, part)) for part in (self.coordinates, self.velocities))
        return "System({!r}, coordinates=({}), velocities=({}))".format(self.name, *names)

    def _repr_html_(self) -> str:
        """For notebooks: what is declared, in formulas."""

        def typeset(exprs: Iterable[Any]) -> str:
            shown = (latex_of(e, self.coordinates, self.velocities) for e in exprs)
            return ", ".join(f"${e}$" for e in shown)

        def name_pairs(things: Iterable[Any]) -> list[tuple[str, str]]:
            said = [(typeset([x]), self.meanings.get(plain_name(x), "")) for x in things]
            return [(symbol, words) for symbol, words in said if words]

        rows = [
            ("coordinates", typeset(self.coordinates)),
            *name_pairs(self.coordinates),
            ("velocities", typeset(self.velocities)),
            *name_pairs(self.velocities),
            ("Lagrangian", typeset([self.lagrangian])),
            ("constraints, which vanish", typeset(self.constraints)),
        ]
        rows += [(f"force along {plain_name(q)}", typeset([e])) for q, e in self.forces.items()]
        for parameter in self.parameters:
            value = "" if parameter.value is None else f" = {parameter.value}"
            rows.append((f"{parameter.name}{value}", parameter.meaning or "a parameter"))
        table = html_table(self.title or self.name, rows)
        return table if self.sketch is None else self.sketch.svg() + table

    def __getstate__(self) -> dict[str, Any]:
        """What is declared travels; what was derived from it is derived again."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @property
    def coordinates(self) -> tuple[sp.Expr, ...]:
        """Base coordinates, then fibre coordinates."""
        return self.fibration.base + self.fibration.fibre

    @cached_property
    def parameter_names(self) -> tuple[str, ...]:
        """The names of the parameters."""
        return tuple(p.name for p in self.parameters)

    @property
    def first_scene(self) -> str | None:
        """The scene where nobody names one: ``default``, else the first; None where none is."""
        return "default" if "default" in self.scenes else next(iter(self.scenes), None)

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
            return tuple(map(velocity, self.directions))
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


def _several_of(given: Any, name: str, kind: type, entry: str) -> tuple[Any, ...]:
    """Values of one class; the message of an error says how one is written."""
    values = tuple(several(given, name, entry, kind))
    for value in values:
        if not isinstance(value, kind):
            raise DefinitionError(f"{name} holds '{quote(value)}'; write {entry}")
    return values


def _expressions_of(given: Any, name: str, one: str, entry: str) -> Mapping[Any, sp.Expr]:
    """A mapping to expressions, of which ``one`` says in messages what each is."""
    values = fixed_mapping(given, name, entry)
    quoted = {k: plain_name(k) if is_symbolic_name(k) else quote(k) for k in values}
    read = {k: expression(v, f"{one} '{quoted[k]}'") for k, v in values.items()}
    return fixed_mapping(read, name, entry)


def _all_of(things: Any, place: str, kind: type, entry: str) -> Mapping[str, Any]:
    """A mapping of names to values of one kind."""
    values = fixed_mapping(things, place, f"'name': {entry}")
    for name, value in values.items():
        if not isinstance(value, kind):
            raise DefinitionError(
                f"{place.removesuffix('s')} '{name}' is '{quote(value)}'; write {entry}"
            )
    return values


def require_system(thing: Any) -> System:
    """``thing`` itself where it is a ``System``; else ``DefinitionError``, which says the mend."""
    if isinstance(thing, System):
        return thing
    text = isinstance(thing, str)
    mend = f"voronec.load('{quote(thing)}') may give it" if text else "give a System"
    raise DefinitionError(f"'{quote(thing)}' is not a voronec.System; {mend}")


def system_in(system: System, name: str) -> System:
    """A system in one of its charts, without its claims and scenes."""
    changes = dict(system.charts[name].changes)
    if "relations" in changes:
        relations = changes.pop("relations")
        changes["fibration"] = replace(system.fibration, relations=relations)
    return bare(system, f"{system.name}, {name}", **changes)


def bare(system: System, name: str, **changes: Any) -> System:
    """A system by another name, with changes, without its claims, charts and scenes."""
    empty: dict[str, Any] = {
        **without_claims(),
        **{x: {} for x in ("invariants", "scenes", "charts")},
        **dict.fromkeys(("drawing", "motion")),
        "shapes": (),
        "bodies": (),
    }
    return replace(system, name=name, **{**empty, **changes})


def spell_out(
    system: System, frame: Frame | None, changes: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Lagrangian, constraints and forces, with changes, without the quasi-velocities of a frame."""
    meaning = {} if frame is None else dict(zip(frame.velocities, frame.expressions, strict=True))
    names = ("lagrangian", "constraints", "forces")
    parts = {name: getattr(system, name) for name in names} | dict(changes or {})

    def on(expr: Any) -> Any:
        return as_expression(expr).xreplace(meaning)

    return {
        "lagrangian": on(parts["lagrangian"]),
        "constraints": tuple(map(on, parts["constraints"])),
        "forces": {q: on(e) for q, e in parts["forces"].items()},
    }


LONGEST_NAME = 100
"""How long a name may be."""


def check_possible(system: System) -> None:
    """Conditions on the parameters are relations among them, and of nothing else."""
    symbols = {p.symbol for p in system.parameters}
    for words, condition in system.possible.items():
        stray = getattr(condition, "free_symbols", symbols) - symbols
        if not isinstance(condition, Boolean) or condition.is_Symbol or stray:
            raise DefinitionError(
                f"the condition '{words}' is '{quote(condition)}', which is no relation of the "
                "system's parameters; write one such as 2*A > m*R**2"
            )


def require_possible(system: System, given: Mapping[str, Any]) -> None:
    """Refuse parameters, by name, that no body can have, decided with the exact values."""
    values = {p.symbol: given.get(p.name, p.value) for p in system.parameters}
    exact = {s: sp.Rational(x) if isinstance(x, float) else x for s, x in values.items()}
    known = {s: as_expression(x) for s, x in exact.items() if x is not None}
    for words, condition in system.possible.items():
        if condition.xreplace(known) is sp.false:
            involved = [p.symbol for p in system.parameters if condition.has(p.symbol)]
            held = ", ".join(f"{s} = {values[s]}" for s in involved)
            raise DefinitionError(f"system '{system.name}': {words}; not so with {held}")


def check_forces(system: System) -> None:
    """Forces act along coordinates and velocities; on a group along the fields of its frame."""
    one, all_of = "neither a coordinate nor a velocity", "coordinates"
    if system.on_group:
        one, all_of = "not a velocity of the frame", "these"
    for direction in system.forces:
        if direction not in system.directions:
            listed = ", ".join(f"'{plain_name(q)}'" for q in system.directions)
            if not system.on_group:
                listed += ", velocities " + ", ".join(
                    f"'{plain_name(v)}'"
                    for v in dict.fromkeys((*system.velocities, *map(velocity, system.coordinates)))
                )
            raise DefinitionError(
                f"a force is given for '{quote(direction)}', which is {one}; {all_of} are {listed}"
            )


def check_names(system: System) -> None:
    """No name is used twice."""
    names: dict[str, str] = {}
    for thing, role in _roles(system):
        name = plain_name(thing)
        _require_name(name, role)
        if name in names:
            raise DefinitionError(
                f"the name '{name}' is used twice ({names[name]} and {role}); rename one of them"
            )
        names[name] = role
    _require_name(system.name, "the system")
    named = (*(kind.field for kind in KINDS if kind.entry), "invariants", "cases", "scenes")
    for title in (*named, "charts", "possible"):
        for words in getattr(system, title):
            if not isinstance(words, str) or not words.strip() or not words.isprintable():
                raise DefinitionError(
                    f"'{quote(words)}' among its {title} is no name; give words of printable "
                    "letters"
                )
    for title in ("title", "description"):
        if not isinstance(getattr(system, title), str):
            raise DefinitionError(f"{title} = {quote(getattr(system, title))} is no text")


def _require_name(name: str, role: str) -> None:
    """Names are quoted in tables, file names and source: they are words."""
    if not name.strip() or not name.isprintable() or len(name) > LONGEST_NAME:
        raise DefinitionError(
            f"the name '{quote(name)}' ({role}) is no word; give one of printable letters, "
            f"{LONGEST_NAME} at most"
        )


def check_symbols(system: System) -> None:
    """Expressions are made of what is declared."""
    declared = set(system.known_symbols())
    places = [(place, expr, declared) for place, expr in _places(system)]
    claimed = declared | set(system.invariant_symbols)
    claimed |= set(system.frame.claim_names if system.frame is not None else ())
    inputs, pushed = set(system.inputs), declared | set(system.accelerations)
    places += [(p, e, pushed) for p, e in _forces(system)]
    for place, expr, known in (*places, *((p, e, claimed) for p, e in _claims(system))):
        require_known(place, expr, known, inputs)


def check_claims(system: System) -> None:
    """Claims name what there is: variables of one level, parameters, theorems, other claims."""
    for label, holder in _holders(system):
        if not isinstance(holder.integrable, str) or holder.integrable not in ("", *THEOREMS):
            raise DefinitionError(
                f"{label}integrable is '{quote(holder.integrable)}'; known theorems: "
                f"{', '.join(THEOREMS)}"
            )
        for measure in _both(holder.measure):
            _check_variables(system, measure)
    known = {*system.coordinates, *system.velocities, *system.invariant_symbols}
    for variable in system.essential:
        if variable not in known:
            raise DefinitionError(
                f"essential holds '{quote(variable)}', which is no coordinate, velocity of the "
                "equations or invariant"
            )
    names = {*system.parameter_names, *map(plain_name, system.inputs)}
    for label, case in system.cases.items():
        for key in case.parameters:
            name = plain_name(key)
            if name not in names:
                raise DefinitionError(
                    f"case '{label}' gives a value to '{name}', which is no parameter and no input"
                )
    claimed = {*claim_names(system)} if system.undecided else set()
    for name in system.undecided:
        if name not in claimed:
            raise DefinitionError(
                f"undecided holds '{quote(name)}', which is no claim; claims are "
                f"{', '.join(sorted(claimed)) or 'none'}"
            )


def _holders(system: System) -> Iterator[tuple[str, Any]]:
    """What claims are declared in: the system, and its cases."""
    yield "", system
    for name, case in system.cases.items():
        yield f"case '{name}': ", case


def _both(measure: Any) -> Iterator[Measure]:
    """The right one and the printed one; the measure itself, if there is any."""
    if measure is not None:
        yield right_of(measure)
    if isinstance(measure, Corrected):
        yield measure.printed


def _check_variables(system: System, measure: Measure) -> None:
    given, velocities = {*measure.variables}, {*system.velocities}
    if given <= {*system.coordinates} | velocities:
        return
    if not given <= {*system.invariant_symbols} | velocities:
        raise DefinitionError(
            "the variables of the measure are neither among coordinates and velocities of the "
            "equations nor among invariants and these velocities"
        )
    dots = {velocity(q) for q in system.coordinates} - velocities
    foreign = sorted(map(str, names_in(measure.density) & ({*system.coordinates} | dots)))
    if foreign:
        raise DefinitionError(
            f"the measure in invariants holds '{foreign[0]}'; write its density with invariants too"
        )


def check_charts(system: System) -> None:
    """Charts map variables, to functions of them and of parameters."""
    names = sorted(map(plain_name, (*system.coordinates, *system.velocities)))
    resting = {*system.coordinates, *(p.symbol for p in system.parameters)}
    for name, chart in system.charts.items():
        place = f"chart '{name}'"
        for key in {*chart.state, *chart.back}.union(*chart.double_cover) - {*names}:
            wrong = f"{place} maps '{key}', which is no coordinate or velocity"
            raise DefinitionError(wrong + did_you_mean(key, names))
        maps = (chart.state, chart.back, *chart.double_cover)
        for expr in (e for images in maps for e in images.values()):
            require_known(place, expr, {*system.known_symbols()} - {time})
        for expr in (chart.singular, chart.singular_there):
            require_known(f"{place}: singular", expr, resting)


def check_shapes(system: System) -> None:
    """Shapes are made of parameters, and placed by what is declared."""
    known = {*system.known_symbols(), *system.invariant_symbols}
    resting = {*MESH, *(p.symbol for p in system.parameters)}
    for number, shape in enumerate(system.shapes, 1):
        place = f"shape {shape.title or number}"
        for expr in shape.expressions:
            require_known(place, expr, known)
        for patch in shape.patches:
            for expr in patch.position:
                require_known(f"{place}, its surface,", expr, resting)


def check_bodies(system: System) -> None:
    """Bodies are made of what is declared."""
    known = {*system.known_symbols()}
    for body in system.bodies:
        for expr in body.expressions:
            require_known(f"the body '{quote(body.title)}'", expr, known)


def check_relations(system: System) -> None:
    """Relations bind coordinates, not velocities."""
    dots = {velocity(q) for q in system.coordinates}
    if system.frame is not None:
        dots |= set(system.frame.ambient)
    for i, relation in enumerate(system.fibration.relations):
        names = names_in(relation)
        place = f"relation {i + 1} ({quote(relation)} = 0)"
        moving = sorted(map(plain_name, names & dots))
        if moving:
            raise DefinitionError(
                f"{place} contains the velocity '{moving[0]}'; a relation binds coordinates only: "
                "make it a constraint"
            )
        if not names & set(system.coordinates):
            raise DefinitionError(f"{place} holds no coordinate; correct or drop it")


def check_frame(system: System) -> None:
    """Quasi-velocities are defined by velocities of coordinates, not by one another."""
    if system.frame is None:
        return
    if system.frame.is_group:
        _check_group(system, system.frame)
        return
    if len(system.frame.beside) > len(system.constraints):
        raise DefinitionError(
            f"the frame has {len(system.frame.beside)} velocities beside its own, and the system "
            f"{len(system.constraints)} constraints; leave out those that no constraint gives"
        )
    quasi = set(system.frame.definitions)
    for v, expr in system.frame.definitions.items():
        used = sorted(map(plain_name, names_in(expr) & quasi))
        if used:
            raise DefinitionError(
                f"the definition of '{plain_name(v)}' contains the quasi-velocity '{used[0]}'; "
                "write it with the velocities of the coordinates"
            )


def _check_group(system: System, frame: Frame) -> None:
    """The rates of a group are those of the coordinates, and its brackets are constant."""
    if system.fibration.fibre:
        raise DefinitionError(
            "with Frame.group all coordinates stand in the base; the fibre is that of the frame, "
            "Frame.group(..., fibre=(...))"
        )
    for q in system.coordinates:
        if q not in frame.rates:
            raise DefinitionError(
                f"the frame gives no rate for '{plain_name(q)}'; add it to rates={{...}}"
            )
    for q in frame.rates:
        if q not in system.coordinates:
            raise DefinitionError(
                f"the frame gives a rate for '{quote(q)}', which is not a coordinate; add it to "
                "Fibration(base=(...))"
            )
    constant = {p.symbol for p in system.parameters if isinstance(p.symbol, sp.Symbol)}
    for pair, parts in (frame.brackets or {}).items():
        for value in parts.values():
            moving = sorted(map(str, names_in(value) - constant))
            if moving:
                names = ", ".join(map(plain_name, pair))
                raise DefinitionError(
                    f"the bracket of {names} contains '{moving[0]}'; the brackets of a group hold "
                    "numbers and constant parameters only"
                )


def _roles(system: System) -> Iterator[tuple[sp.Expr, str]]:
    """Every name that a system declares or implies, and what it stands for."""
    for q in system.coordinates:
        yield q, "a coordinate"
    for q in system.coordinates:
        yield velocity(q), "the velocity of a coordinate"
    for v in (*system.frame.ambient, *system.frame.beside) if system.frame is not None else ():
        yield v, "a quasi-velocity"
    for name in system.frame.claim_names if system.frame is not None else ():
        yield name, "a name in the frame"
    for p in system.parameters:
        yield p.symbol, "a parameter"
    constants = {p.symbol for p in system.parameters}
    for u in system.inputs:
        if u not in constants:
            yield u, "an input"
        yield velocity(u), "the rate of an input"
    for g in system.invariant_symbols:
        yield g, "an invariant"
    yield time, "the time"


def _places(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """Every expression of a system, and what a message calls it."""
    yield "the Lagrangian", system.lagrangian
    for i, constraint in enumerate(system.constraints):
        yield f"constraint {i + 1}", constraint
    if system.frame is not None:
        for v, e in system.frame.definitions.items():
            yield f"the definition of '{v}'", e
        for q, e in system.frame.rates.items():
            yield f"the rate of '{q}'", e
    for key, e in system.invariants.items():
        yield f"invariant '{key}'", e
    for i, e in enumerate(system.fibration.relations):
        yield f"relation {i + 1}", e


def _forces(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """The forces, which may hold accelerations besides."""
    for q, force in system.forces.items():
        yield f"the force on '{q}'", force


def _claims(system: System) -> Iterator[tuple[str, sp.Expr]]:
    """Every expression of a claim, in which the invariants may be used by name."""
    for place, holder in _holders(system):
        for claim in declared_claims(holder):
            yield from ((f"{place}{claim.place}", e) for e in expressions_of(claim.value))


def check_meanings(system: System) -> None:
    """Meanings are words; what they explain may be left out of a changed copy."""
    for name, words in system.meanings.items():
        if not isinstance(words, str) or not words.strip() or not words.isprintable():
            raise DefinitionError(
                f"the meaning of '{quote(name)}' is '{quote(words)}'; give words of printable "
                "letters"
            )


def check_motion(system: System) -> None:
    """A motion by quadratures is made of the state, parameters and its own symbols, and gives every
    coordinate and every velocity."""
    if system.motion is None:
        return
    _check_symbols(system, system.motion)
    _check_subjects(system, system.motion)
    for q in system.coordinates:
        if q not in system.motion.known_coordinates:
            raise DefinitionError(f"motion gives no value to the coordinate '{plain_name(q)}'")
    for w in system.velocities:
        dotted = w in {
            velocity(q) for q in system.coordinates if q in system.motion.plain_coordinates
        }
        if w not in system.motion.velocities and not dotted:
            raise DefinitionError(f"motion gives no value to the velocity '{plain_name(w)}'")
    left = [q for q in system.coordinates if q not in system.motion.plain_coordinates]
    for w, value in system.motion.velocities.items():
        for q in left:
            if value.has(q, velocity(q)):
                raise DefinitionError(
                    f"motion: the velocity '{plain_name(w)}' holds '{plain_name(q)}' or its rate, "
                    "a place in space; write it with angles, colatitudes and the variable"
                )


def _check_symbols(system: System, motion: Quadratures) -> None:
    """Its own symbols are new, and its expressions hold none but known ones."""
    fresh = {motion.x, *motion.constants}
    for symbol in fresh:
        meaning = system.invariants.get(plain_name(symbol))
        taken = symbol in system.known_symbols()
        if taken or (meaning is not None and meaning != motion.variable.get(symbol)):
            raise DefinitionError(
                f"motion: the name '{plain_name(symbol)}' is used twice; rename the variable or "
                "constant of the motion"
            )
    state, resting = {*system.known_symbols()} - {time}, {p.symbol for p in system.parameters}
    for what, expr, inside in motion.expressions():
        known = {"state": state, "level": resting | fresh, "both": state | fresh}[inside]
        require_known(f"motion: {what}", expr, known)


def _check_subjects(system: System, motion: Quadratures) -> None:
    """What is given a rate or a value is a coordinate or a velocity."""
    for trace in motion.traces:
        for q, role in ((trace.colatitude, "colatitude"), (trace.longitude, "longitude")):
            if q not in system.coordinates:
                raise DefinitionError(f"motion: the {role} '{q}' of a trace is no coordinate")
        if trace.longitude not in motion.integrals:
            raise DefinitionError(
                f"motion gives no rate to the longitude '{trace.longitude}' of a trace"
            )
    for q in motion.integrals:
        if q not in system.coordinates:
            raise DefinitionError(f"motion gives a rate to '{q}', which is no coordinate")
    for v in motion.velocities:
        if v not in system.velocities:
            raise DefinitionError(
                f"motion gives a value to '{v}', which is no velocity of the equations"
            )


CHECKS = (
    check_possible, check_forces, check_names, check_symbols, check_frame, check_relations,
    check_claims, check_charts, check_motion, check_meanings, check_shapes, check_bodies,
)  # fmt: skip
"""What a system that was read has to meet, in this order."""
