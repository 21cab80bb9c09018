"""Reading a system: from the user's symbols to symengine, with every check on the way.

Constraints are read as C qdot + c = 0 [Theory, eq. (2)], quasi-velocities as v = W qdot + w
[Theory, eq. (3)], both with relations that hold for redundant coordinates.

Constraints have to determine the velocities of the fibre; it is said why where they do not.

A Lagrangian, its momenta, constraints and definitions of velocities may not jump.  Where one does,
velocities jump too, and the equations between the switching surfaces do not say how far.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.conditions import condition
from voronec.algebra.elimination import independent_columns, solve_linear
from voronec.algebra.symbols import is_symbolic_name, names_in, plain_name, time, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.declaration.reading import quote
from voronec.declaration.system import System, require_system
from voronec.equations.connection import AffineForms, FibreSolution, solve_fibre
from voronec.equations.group_frame import GroupFrame, read_group
from voronec.equations.jumps import require_no_jump, require_no_jump_of_lagrangian
from voronec.errors import DefinitionError

Enter = Callable[[sp.Expr, str], Any]
"""From an expression of the user's, and what a message calls it, to the expression inside."""


@dataclass(frozen=True)
class Definition:
    """A system in the engine's symbols: symengine symbols and expressions, constraints solved.

    ``dots`` are the velocities in which Lagrangian and constraints are written: those of the
    coordinates, or of a group's frame; forces act along them: Q = ``forces`` + ``added`` qddot,
    without ``added`` where no force holds an acceleration.
    """

    system: System
    bridge: SymPyBridge
    coordinates: tuple[Any, ...]
    coordinate_velocities: tuple[Any, ...]
    dots: tuple[Any, ...]
    group: GroupFrame | None
    velocities: tuple[Any, ...]
    momenta: tuple[Any, ...]
    determinant: Any
    parameters: tuple[Any, ...]
    time: Any
    lagrangian: Any
    forces: tuple[Any, ...]
    constraints: AffineForms
    frame: AffineForms | None
    relations: tuple[Any, ...]
    differentiated: AffineForms
    fibre: FibreSolution
    near: dict[str, Any]
    added: tuple[tuple[Any, ...], ...] = ()

    @property
    def base(self) -> int:
        """The number of base coordinates; on a group, of independent velocities."""
        return self.system.base_directions

    @property
    def positive(self) -> tuple[Any, ...]:
        """The parameters that are declared to be positive."""
        pairs = zip(self.parameters, self.system.parameters, strict=True)
        return tuple(p for p, declared in pairs if declared.is_positive)

    @cached_property
    def conditions(self) -> tuple[Any, ...]:
        """What is known of parameters, and of whatever SymPy knows the sign: hypotheses beside the
        relations."""
        return _conditions(self.system, self.bridge)

    @property
    def split(self) -> tuple[list[str], list[str]]:
        """What indices over the base and over the fibre count: coordinates, or, on a group,
        velocities of its frame."""
        names = [plain_name(x) for x in self.system.directions]
        return names[: self.base], names[self.base :]

    @property
    def fibre_velocities(self) -> tuple[Any, ...]:
        """The velocities of a group that are not independent; none without a group."""
        return self.dots[self.base :] if self.group is not None else ()

    @property
    def keeps_vertical(self) -> bool:
        """Whether the fibre directions are those of a fibration that the brackets know."""
        return self.group is None or self.group.keeps_vertical(self.base)

    @property
    def inputs(self) -> tuple[Any, ...]:
        """The functions of the time that are given at run time."""
        return tuple(self.bridge.inward_all(self.system.inputs))

    def along_fibre(self, function: Any) -> list[Any]:
        """The derivatives of a function of the coordinates along the fibre directions."""
        if self.group is None:
            return [function.diff(s) for s in self.coordinates[self.base :]]
        pairs = list(zip(self.coordinates, self.group.fields, strict=True))
        size = range(self.base, len(self.dots))
        return [se.Add(*[row[a] * function.diff(q) for q, row in pairs]) for a in size]


def read(system: System, near: Mapping[str, Any] | None = None) -> Definition:
    """Translate and check a system; raises ``DefinitionError`` where it makes no sense.

    ``near`` is a point, by names, at which the solved constraints should be defined; by default
    the start of the default scene.
    """
    # long because it is a list: every part of a definition in turn, each from those before it
    require_system(system)
    pushed = set().union(*map(names_in, system.forces.values())) & {*system.accelerations}
    known = (*system.known_symbols(), *sorted(pushed, key=str))
    bridge = SymPyBridge((s for s in known if _is_variable(system, s)), system.inputs)
    coordinates = tuple(bridge.inward(q) for q in system.coordinates)
    coordinate_velocities = tuple(bridge.inward(velocity(q)) for q in system.coordinates)
    group = _group(system, bridge)
    dots = group.velocities if group else coordinate_velocities
    enter = _reader(system, bridge, group, coordinate_velocities)
    relations = tuple(
        enter(r, f"relation {i + 1}") for i, r in enumerate(system.fibration.relations)
    )
    differentiated = AffineForms((), ())
    if group is None:
        differentiated = _differentiate(relations, coordinates, bridge.inward(time))
    frame = _frame(system, enter, dots)
    constraints = _constraints(system, enter, dots)
    _count(system, len(constraints.matrix), differentiated)
    point = _start(system) if near is None else dict(near)
    fibre = _solve_for_fibre(system, constraints, differentiated, relations, point)
    _require_continuity(system, enter, (*coordinates, *dots), dots, _conditions(system, bridge))
    momenta, determinant = _momentum_names(system, bridge)
    forces, added = _read_forces(system, bridge, enter, dots, frame)
    return Definition(
        system=system,
        bridge=bridge,
        coordinates=coordinates,
        coordinate_velocities=coordinate_velocities,
        dots=dots,
        group=group,
        velocities=tuple(bridge.inward(v) for v in system.velocities),
        momenta=momenta,
        determinant=determinant,
        parameters=tuple(bridge.inward(p.symbol) for p in system.parameters),
        time=bridge.inward(time),
        lagrangian=enter(system.lagrangian, "the Lagrangian"),
        forces=forces,
        constraints=constraints,
        frame=frame,
        relations=relations,
        differentiated=differentiated,
        fibre=fibre,
        near=point,
        added=added,
    )


def _differentiate(relations: Sequence[Any], coordinates: Sequence[Any], clock: Any) -> AffineForms:
    """d/dt of relations, as forms in the velocities of the coordinates."""
    slopes = tuple(tuple(r.diff(q) for q in coordinates) for r in relations)
    return AffineForms(slopes, tuple(r.diff(clock) for r in relations))


def _momentum_names(system: System, bridge: SymPyBridge) -> tuple[tuple[Any, ...], Any]:
    """The names of the frame for momenta and for the determinant of the mass, where it has them."""
    if system.frame is None:
        return (), None
    determinant = system.frame.determinant
    return (
        tuple(bridge.inward_all(system.frame.momenta)),
        None if determinant is None else bridge.inward(determinant),
    )


def _conditions(system: System, bridge: SymPyBridge) -> tuple[Any, ...]:
    """What a system declares of its parameters, and what SymPy knows of symbols."""
    declared = [condition(c, bridge.inward) for c in system.conditions]
    return (*declared, *bridge.hypotheses)


def _require_continuity(
    system: System,
    enter: Enter,
    variables: Sequence[Any],
    dots: Sequence[Any],
    known: Sequence[Any],
) -> None:
    """Steps are for forces: what velocities depend on may have kinks only."""
    lagrangian = enter(system.lagrangian, "the Lagrangian")
    place = f"system '{system.name}'"
    require_no_jump_of_lagrangian(place, lagrangian, dots, variables, known)
    for i, constraint in enumerate(system.constraints):
        name = partial(_constraint, system, i)  # printed where it is refused: that takes long
        require_no_jump(name, enter(constraint, f"constraint {i + 1}"), known, variables)
    if system.frame is not None and not system.on_group:
        for v, expr in zip(system.frame.velocities, system.frame.expressions, strict=True):
            title = f"{place}: the quasi-velocity '{plain_name(v)}'"
            require_no_jump(partial(str, title), enter(expr, title), known, variables)


def _read_forces(
    system: System,
    bridge: SymPyBridge,
    enter: Enter,
    dots: Sequence[Any],
    frame: AffineForms | None,
) -> tuple[tuple[Any, ...], tuple[tuple[Any, ...], ...]]:
    """The forces along all directions, and their coefficients of the accelerations qddot.

    The rate of a quasi-velocity e_a qdot_a + e is e_a qddot_a and its part at fixed velocities.
    """
    zero = se.Integer(0)
    held = {q: enter(e, f"the force on '{plain_name(q)}'") for q, e in system.forces.items()}
    forces = tuple(held.get(q, zero) for q in system.directions)
    pushed = [a for a in dict.fromkeys(system.accelerations) if a in bridge]
    if not pushed:
        return forces, ()
    linear: AffineForms | int | None = _first_bend(forces, set(bridge.inward_all(pushed)))
    if linear is None:
        linear = AffineForms.of(forces, bridge.inward_all(pushed))
    if isinstance(linear, int):
        raise DefinitionError(
            f"system '{system.name}': the force on '{plain_name(system.directions[linear])}' is "
            "not linear in the accelerations; solve it for them first"
        )
    rates = _rates_of_velocities(system, bridge, dots, frame)
    rows, rests = [], list(linear.offset)
    for k, row in enumerate(linear.matrix):
        total = [zero] * len(dots)
        for a, weight in zip(pushed, row, strict=True):
            slopes, rest = rates[a]
            total = [x + weight * s for x, s in zip(total, slopes, strict=True)]
            rests[k] += weight * rest
        rows.append(tuple(total))
    return tuple(rests), tuple(rows)


def _first_bend(forces: Sequence[Any], accelerations: Set[Any]) -> int | None:
    """The first force with an acceleration under a function or a root, which may have no slope."""
    for k, force in enumerate(forces):
        bends = [p for p in force.atoms(se.Pow) if not p.args[1].is_Integer]
        if any(f.free_symbols & accelerations for f in (*force.atoms(se.Function), *bends)):
            return k
    return None


def _rates_of_velocities(
    system: System, bridge: SymPyBridge, dots: Sequence[Any], frame: AffineForms | None
) -> dict[sp.Expr, tuple[Sequence[Any], Any]]:
    """What an acceleration is: coefficients of qddot, and the part at fixed velocities."""
    zero, size = se.Integer(0), range(len(dots))
    rates: dict[sp.Expr, tuple[Sequence[Any], Any]] = {}
    if frame is not None:
        clock, coordinates = bridge.inward(time), bridge.inward_all(system.coordinates)
        definitions = zip(system.velocities, frame.matrix, frame.expressions(dots), strict=True)
        for v, row, expr in definitions:
            terms = (expr.diff(q) * dot for q, dot in zip(coordinates, dots, strict=True))
            rates[velocity(v)] = row, se.Add(expr.diff(clock), *terms)
    directions = system.directions if system.on_group else map(velocity, system.coordinates)
    for a, w in enumerate(directions):
        rates[velocity(w)] = [se.Integer(int(a == b)) for b in size], zero
    return rates


def _group(system: System, bridge: SymPyBridge) -> GroupFrame | None:
    frame = system.frame
    if frame is None or not frame.is_group:
        return None
    return read_group(frame, system.coordinates, bridge, f"system '{system.name}'")


def _start(system: System) -> dict[str, Any]:
    """Parameters and coordinates at the start of the default scene, zero where nothing is said.

    Initial values may hold parameters; one that has no number then is left out.
    """
    scene = system.scenes.get("default")
    values = {p.symbol: p.value for p in system.parameters if p.value is not None}
    named = {p.name: p.symbol for p in system.parameters}
    for key, value in (scene.parameters if scene is not None else {}).items():
        values[named.get(plain_name(key), key)] = value
    point = {plain_name(symbol): value for symbol, value in values.items()}
    initial = scene.initial if scene is not None else {}
    point |= {plain_name(k): _with_numbers(v, values) for k, v in initial.items()}
    point = {name: value for name, value in point.items() if not _is_open(value)}
    if not system.fibration.relations:
        point = {plain_name(q): 0 for q in system.coordinates} | point
    return point


def _with_numbers(value: Any, values: Mapping[Any, Any]) -> Any:
    """A value with numbers for the parameters in it, as far as they are known."""
    return value.subs(values) if _is_open(value) else value


def _is_open(value: Any) -> bool:
    """Whether a value holds symbols, so that it is no number."""
    return isinstance(value, sp.Expr) and not value.is_number


def _is_variable(system: System, symbol: sp.Expr) -> bool:
    """Whether a known symbol is a plain variable inside; unknown functions of time are not."""
    driven = {*system.inputs, *map(velocity, system.inputs)}
    return symbol not in driven and (is_symbolic_name(symbol) or isinstance(symbol, sp.Derivative))


def _reader(
    system: System,
    bridge: SymPyBridge,
    group: GroupFrame | None,
    coordinate_velocities: Sequence[Any],
) -> Enter:
    """The way in: quasi-velocities are spelled out, and what the bridge refuses has a place.

    On a group it is the velocities of the coordinates that are spelled out.
    """

    def plain(expr: sp.Expr, place: str) -> Any:
        try:
            return bridge.inward(expr)
        except DefinitionError as error:
            raise DefinitionError(f"system '{system.name}': {place}: {error}") from None

    if system.frame is None:
        return plain
    if group is not None:
        rates = group.coordinate_rates(group.velocities)
        spelled = dict(zip(coordinate_velocities, rates, strict=True))
        return lambda expr, place: plain(expr, place).xreplace(spelled)
    pairs = zip(system.frame.velocities, system.frame.expressions, strict=True)
    meanings = {
        bridge.inward(v): plain(e, f"the definition of '{plain_name(v)}'") for v, e in pairs
    }
    return lambda expr, place: plain(expr, place).xreplace(meanings)


def _constraints(system: System, enter: Enter, dots: Sequence[Any]) -> AffineForms:
    exprs = [enter(c, f"constraint {i + 1}") for i, c in enumerate(system.constraints)]
    forms = AffineForms.of(exprs, dots)
    if isinstance(forms, int):
        raise DefinitionError(
            f"{_constraint(system, forms)} is not affine in the velocities; solve it for a "
            "velocity or differentiate it first"
        )
    for i, row in enumerate(forms.matrix):
        if all(e == 0 for e in row):
            binds = system.constraints[i].has(*system.coordinates)
            mend = "differentiate it with respect to time" if binds else "drop it"
            raise DefinitionError(f"{_constraint(system, i)} holds no velocity; {mend}")
    return forms


def _constraint(system: System, i: int) -> str:
    return f"system '{system.name}': constraint {i + 1} ({quote(system.constraints[i])} = 0)"


def _frame(system: System, enter: Enter, dots: Sequence[Any]) -> AffineForms | None:
    if system.on_group:
        return None
    if system.frame is None:
        fibre, relations = system.fibration.fibre, system.fibration.relations
        if any(not r.has(*fibre) for r in relations):
            raise DefinitionError(
                f"system '{system.name}': the base coordinates are redundant (they satisfy "
                f"{relations[0]} = 0); give independent velocities with frame="
            )
        return None
    pairs = zip(system.frame.velocities, system.frame.expressions, strict=True)
    exprs = [enter(e, f"the definition of '{plain_name(v)}'") for v, e in pairs]
    forms = AffineForms.of(exprs, dots)
    if isinstance(forms, int):
        name = plain_name(system.frame.velocities[forms])
        raise DefinitionError(
            f"system '{system.name}': the quasi-velocity '{name}' is not affine in the velocities; "
            "define it by a combination of them whose coefficients hold none"
        )
    return forms


def _count(system: System, constraints: int, differentiated: AffineForms) -> None:
    """As many conditions as fibre coordinates, relations on the fibre counted."""
    if system.on_group:
        fibre = len(system.directions) - system.base_directions
        if constraints != fibre:
            raise DefinitionError(
                f"system '{system.name}': {constraints} constraint(s) for {fibre} velocities in "
                "the fibre of the frame; name as many there as there are constraints"
            )
        return
    base, fibre = len(system.fibration.base), len(system.fibration.fibre)
    binding = sum(any(e != 0 for e in row[base:]) for row in differentiated.matrix)
    if constraints > fibre:
        raise DefinitionError(
            f"system '{system.name}': {constraints} constraint(s) for {fibre} fibre coordinate(s); "
            f"move {constraints - fibre} more coordinate(s) from the base to the fibre, or drop "
            "a constraint"
        )
    if constraints + binding < fibre:
        raise DefinitionError(
            f"system '{system.name}': {fibre} fibre coordinates but only {constraints} "
            f"constraint(s); move {fibre - constraints - binding} coordinate(s) to the base, or "
            "add what is missing"
        )


def _solve_for_fibre(
    system: System,
    constraints: AffineForms,
    differentiated: AffineForms,
    ideal: Sequence[Any],
    near: Mapping[str, Any],
) -> FibreSolution:
    """The fibre velocities in terms of the others; ``DefinitionError``, with a split that works,
    where the constraints do not determine them."""
    base = system.base_directions
    fibre, solution = solve_fibre(constraints, differentiated, base, ideal, near)
    if solution is None:
        return fibre
    k = len(constraints.matrix)
    left_over = [i for i in (*solution.dependent, *solution.contradictory) if i < k]
    if not solution.free and not left_over:
        return fibre
    _explain_dependence(system, constraints, ideal)
    dependent = system.directions[base:]
    names = [plain_name(dependent[j]) for j in solution.free]
    split = _working_split(system, constraints, ideal)
    raise DefinitionError(
        f"system '{system.name}': the constraints do not determine the velocities of the fibre "
        f"(undetermined: {', '.join(names)}); a split that works: "
        f"base=({', '.join(split[0])}), fibre=({', '.join(split[1])})"
    )


def _explain_dependence(system: System, constraints: AffineForms, ideal: Sequence[Any]) -> None:
    """Raise where the constraints themselves are dependent or contradictory."""
    right = [[-o] for o in constraints.offset]
    whole = solve_linear(constraints.matrix, right, ideal)
    if whole.contradictory:
        raise DefinitionError(
            f"system '{system.name}': the constraints contradict each other (constraint "
            f"{whole.contradictory[0] + 1} is inconsistent with the others); correct or drop it"
        )
    if whole.dependent:
        raise DefinitionError(
            f"system '{system.name}': constraint {whole.dependent[0] + 1} follows from the "
            "others; drop it, and move one coordinate from the fibre to the base"
        )


def _working_split(
    system: System, constraints: AffineForms, ideal: Sequence[Any]
) -> tuple[list[str], list[str]]:
    """A choice of fibre coordinates for which the constraints can be solved, near the given one."""
    velocities, base = system.directions, system.base_directions
    total = len(velocities)
    order = [*range(base, total), *range(base)]
    chosen = independent_columns(constraints.matrix, order, ideal)
    names = [plain_name(q) for q in velocities]
    return [names[i] for i in range(total) if i not in chosen], [names[i] for i in chosen]
