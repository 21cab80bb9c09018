"""A model of ``sympy.physics.mechanics`` as a system: energies, constraints, forces, frame.

What ``KanesMethod`` or ``LagrangesMethod`` is called with is read into one record.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import symengine as se
import sympy as sp

from voronec.algebra.elimination import solve_linear
from voronec.algebra.matrices import dot
from voronec.algebra.symbols import is_symbolic_name, plain_name, time, unused_name, velocity
from voronec.algebra.sympy_bridge import SymPyBridge
from voronec.algebra.tape import Tape
from voronec.declaration.bodies import Body
from voronec.declaration.geometry import Fibration, Frame
from voronec.declaration.mechanics.bodies import (
    ZERO,
    Components,
    FreeBody,
    Places,
    Speeds,
    constraint_columns,
    constraint_rows,
    free_body,
    in_one_line,
    solve_speeds,
    vanish,
)
from voronec.declaration.scene import Parameter
from voronec.declaration.system import System
from voronec.errors import DefinitionError, EngineLimit, quote

LONG = 120
"""Constraints whose coefficients have more nodes than this are not tried as redundant ones: what
vanishes where they hold would take seconds to decide."""


def from_mechanics(
    source: Any, *arguments: Any, name: str = "mechanics", parameters: Any = (), **named: Any
) -> System:
    """The system of a model made with ``sympy.physics.mechanics``.

    source
        a ``KanesMethod``, a ``LagrangesMethod`` or a ``System`` of SymPy's; or the first argument
        of such a method, with the others after it, named as there: of ``KanesMethod`` the inertial
        frame, of ``LagrangesMethod`` the Lagrangian.  The call differs by its name alone.
    name, parameters
        of the system; a ``Parameter`` gives a constant its value.  All other constants of the
        model are parameters without one.

    The generalized speeds become the velocities of the equations, dependent ones follow from the
    constraints; auxiliary speeds are zero.  Configuration constraints are relations between
    redundant coordinates.  The base is chosen here: coordinates whose rates determine all others
    at a generic point, those called dependent last.  Where the place of a mass centre is no
    function of the coordinates, as of a disc whose contact point is said to be at rest, its
    coordinates are added to the fibre; a speed that belongs to no coordinate gets one.  Functions
    of the time that are neither coordinates nor speeds are inputs.

    Raises ``DefinitionError`` for frames that nothing connects, points without velocity, loads on
    what has none, and all that ``System`` refuses.
    """
    model = _read_model(source, arguments, named)
    return _Reading.of(model).system(name, parameters)


@dataclass(frozen=True)
class _Reading:
    """A model in the engine's symbols: its coordinates, with those added, and what speeds stand
    for."""

    model: MechanicsModel
    bridge: SymPyBridge
    coordinates: tuple[sp.Expr, ...]
    speeds: Speeds
    read: Components
    places: Places

    @classmethod
    def of(cls, model: MechanicsModel) -> _Reading:
        """Solve the kinematic equations, and give speeds without a coordinate one."""
        bridge = SymPyBridge(
            [*model.coordinates, *map(velocity, model.coordinates), *model.all_speeds]
        )
        taken = {plain_name(x) for x in (*model.coordinates, *model.all_speeds)}
        still = dict.fromkeys(bridge.inward_all(model.still), ZERO)
        equations = [bridge.inward(e).xreplace(still) for e in model.kinematic]
        dots = [bridge.inward(velocity(q)) for q in model.coordinates]
        symbols = bridge.inward_all(model.all_speeds)
        names = [f"integral_{plain_name(u)}" for u in model.all_speeds]
        speeds = solve_speeds(equations, symbols, dots, [se.Symbol(f"{n}dot") for n in names])
        angles = [_function(names[j]) for j in speeds.unplaced]
        coordinates = (*model.coordinates, *angles)
        meaning = dict(zip(symbols, speeds.values, strict=True))
        free = {u: meaning.pop(u) for u in symbols[: len(model.speeds)]}

        def place(body: str, axis: int) -> Any:
            return bridge.admit(velocity(_fresh(f"{body}_{'xyz'[axis]}", taken)))

        places = Places(
            tuple(map(bridge.admit, coordinates)),
            tuple(bridge.admit(velocity(q)) for q in coordinates),
            bridge.inward(time),
            place,
            free,
            bridge.inward_all(model.configuration),
        )
        return cls(model, bridge, coordinates, speeds, Components(bridge, meaning | still), places)

    def system(self, name: str, parameters: Any) -> System:
        """The declaration."""
        model, outward = self.model, self.bridge.outward
        bodies = self._free_bodies()
        energy = self._lagrangian(bodies)
        kinematic, relations, kept = self._bound()
        constraints = kinematic + [symbol - rate for symbol, rate in self.places.rates]
        added = tuple(outward(symbol).expr for symbol, _ in self.places.rates)
        forces = self._forces()
        base, fibre = self._split(kinematic, relations, [energy, *forces.values()])
        quasi = {u: outward(e) for u, e in zip(model.speeds, self.speeds.values, strict=False)}
        fibration = Fibration(base, (*added, *fibre), tuple(map(outward, relations)))
        declared: dict[str, Any] = {
            "lagrangian": outward(energy),
            "constraints": tuple(map(outward, constraints)),
            "forces": {q: outward(f) for q, f in forces.items() if f != 0},
        }
        placed = self._bodies(bodies)
        held = [declared["lagrangian"], *declared["constraints"], *declared["forces"].values()]
        held += [*fibration.relations, *quasi.values(), *(e for b in placed for e in b.expressions)]
        return System(
            name=name,
            fibration=fibration,
            frame=Frame.quasi(quasi) if quasi else None,
            integrals={f"configuration {i + 1}": outward(e) for i, e in enumerate(kept)},
            parameters=_parameters(held, parameters),
            bodies=placed,
            **declared,
        )

    def _free_bodies(self) -> list[FreeBody]:
        """Those of Kane's models, read; of Lagrange's they have gone into the Lagrangian."""
        model = self.model
        bodies = model.bodies if model.lagrangian is None else ()
        return [free_body(body, model.frame, self.read, self.places) for body in bodies]

    def _lagrangian(self, bodies: Sequence[FreeBody]) -> Any:
        given = self.model.lagrangian
        return se.Add(*[b.energy for b in bodies]) if given is None else self.read.read(given)

    def _bodies(self, bodies: Sequence[FreeBody]) -> tuple[Body, ...]:
        """For Newton and Euler: the bodies, and for each load a place without mass, or axes without
        inertia, on which it acts."""

        def outward(values: Iterable[Any]) -> tuple[Any, ...]:
            return tuple(map(self.bridge.outward, values))

        held = [{"force": [ZERO] * 3, "torque": [ZERO] * 3} for _ in bodies]
        places = []
        for where, moved, vector in self._loads() if bodies else ():
            turning = hasattr(where, "ang_vel_in")
            kind = "torque" if turning else "force"
            i = next((i for i, b in enumerate(bodies) if b.bears(where)), None)
            if not any(e != 0 for e in self.read.of(moved, self.model.frame)):
                continue  # a reaction
            axes = self.model.frame if i is None or not turning else bodies[i].axes
            load = self.read.of(vector, axes)
            if i is None:
                named = {"omega" if turning else "velocity": outward(self.read.of(moved, axes))}
                given = {**named, kind: outward(load), "turning": (0, 0, 0)}
                places.append(Body(0, title=str(where), **given))
            else:
                held[i][kind] = [a + b for a, b in zip(held[i][kind], load, strict=True)]
        massive = [
            Body(
                self.bridge.outward(body.mass if any(v != 0 for v in body.velocity) else ZERO),
                outward(body.velocity),
                [list(outward(row)) for row in body.inertia],
                outward(body.omega),
                turning=outward(body.turning),
                title=str(body.model.name),
                **{name: outward(load) for name, load in loads.items()},
            )
            for body, loads in zip(bodies, held, strict=True)
        ]
        return (*massive, *places)

    def _loads(self) -> Iterator[tuple[Any, Any, Any]]:
        """Of each load on what moves: where it acts, the velocity there, and the load."""
        for where, vector in self.model.loads:
            ask = where.ang_vel_in if hasattr(where, "ang_vel_in") else where.vel
            moved = in_one_line(partial(ask, self.model.frame), f"the load on '{where}'")
            if getattr(moved, "args", ()):
                self._refuse_accelerations(where, vector)
                yield where, moved, vector

    def _refuse_accelerations(self, where: Any, vector: Any) -> None:
        """A load is kept with its body, and the methods take forces without accelerations."""
        held = {d for column, _ in vector.args for d in column.atoms(sp.Derivative)}
        for rate in sorted(held, key=str):
            if rate.derivative_count > 1 or rate.expr in self.model.all_speeds:
                raise DefinitionError(
                    f"from_mechanics: the load on '{where}' holds '{rate}', and loads hold no "
                    "accelerations; put a mass that moves along into the bodies, or declare the "
                    "force in vo.System(forces=...)"
                )

    def _forces(self) -> dict[sp.Expr, Any]:
        """Q_a = F . d(velocity of what it acts on)/d(rate of the coordinate a)."""
        forces = dict.fromkeys(self.coordinates, se.Integer(0))
        for _, moved, vector in self._loads():
            axes = vector.args[0][1]
            force = self.read.of(vector, axes)
            rows = [self.places.form(rate) for rate in self.read.of(moved, axes)]
            for q, column in zip(self.coordinates, zip(*rows, strict=True), strict=False):
                forces[q] += dot(force, column)
        return forces

    def _bound(self) -> tuple[list[Any], list[Any], list[Any]]:
        """Constraints on velocities, relations, and configuration constraints as integrals.

        Constraints that are the derivative of a relation are left out.  Where those that are left
        seem to keep a relation, but this is beyond what is decided, the relation is an integral.
        """
        kinematic = [self.read.read(e) for e in self.model.motion] + [*self.speeds.left_over]
        given = [self.read.read(e) for e in self.model.configuration]
        slopes = [self._slope(r) for r in given]
        rows = [self.places.form(c) for c in kinematic]
        short = Tape([e for row in (*rows, *slopes) for e in row]).size <= LONG
        if short:
            new = [not any(_is_parallel(row, s) for s in slopes) for row in rows]
            kinematic = [c for c, kept in zip(kinematic, new, strict=True) if kept]
            rows = [row for row, kept in zip(rows, new, strict=True) if kept]
        kept = self._independent(kinematic, rows, given)
        kinematic, rows = [kinematic[i] for i in kept], [rows[i] for i in kept]
        table = [row[:-1] for row in (*rows, *slopes)]
        if not given or {*range(len(kinematic), len(table))} <= {*constraint_rows(table, given)}:
            return kinematic, given, []
        try:
            if short:
                solve_linear(table, [[] for _ in table], given, len(kinematic))
                return kinematic, given, []
        except EngineLimit:
            pass
        return kinematic, [], given

    def _independent(
        self, own: Sequence[Any], rows: Sequence[Sequence[Any]], relations: Sequence[Any]
    ) -> list[int]:
        """The constraints that the others follow from; the others are named, and left out."""
        kept = constraint_rows([row[:-1] for row in rows], relations)
        if len(kept) < len(rows):
            order = [*kept, *(i for i in range(len(rows)) if i not in kept)]
            left, right = [rows[i][:-1] for i in order], [[rows[i][-1]] for i in order]
            odd = solve_linear(left, right, relations, len(kept)).contradictory
            named = odd or range(len(kept), len(order))
            said = [quote(self.bridge.outward(own[order[k]])) for k in named]
            if odd:
                raise DefinitionError(
                    f"from_mechanics: the constraint '{said[0]}' = 0 contradicts the others; leave "
                    "one of them out"
                )
            warnings.warn(
                "from_mechanics: constraints that follow from the others are left out: "
                + ", ".join(f"{e} = 0" for e in said),
                stacklevel=5,
            )
        return kept

    def _slope(self, relation: Any) -> list[Any]:
        """The coefficients of the rates in the derivative of a relation, and the rest."""
        along = (*self.places.coordinates, self.places.time)
        return [relation.diff(q) for q in along]

    def _split(
        self, own: Sequence[Any], relations: Sequence[Any], held: Sequence[Any]
    ) -> tuple[tuple[sp.Expr, ...], tuple[sp.Expr, ...]]:
        """Base and fibre: the rates of the first determine those of the second."""
        places = self.places
        rows = [*(places.form(c)[:-1] for c in own), *(self._slope(r)[:-1] for r in relations)]
        in_use = set().union(*(e.free_symbols for e in held), *(e.free_symbols for e in relations))
        order = sorted(range(len(self.coordinates)), key=lambda i: self._rank(i, in_use))
        chosen = constraint_columns([[row[i] for i in order] for row in rows], relations)
        dependent = {order[k] for k in chosen}
        pairs = [(q, i in dependent) for i, q in enumerate(self.coordinates)]
        return tuple(q for q, d in pairs if not d), tuple(q for q, d in pairs if d)

    def _rank(self, i: int, in_use: set[Any]) -> int:
        """How early a coordinate goes to the fibre: those of dependent speeds, those called
        dependent, those that nothing depends on, the others."""
        model = self.model
        count = len(model.coordinates)
        if i >= count and self.speeds.unplaced[i - count] >= len(model.speeds):
            return 0
        if self.coordinates[i] in model.later:
            return 1
        return 3 if self.places.coordinates[i] in in_use else 2


def _is_parallel(row: Sequence[Any], other: Sequence[Any]) -> bool:
    """Whether two rows are multiples of one another, which is proved."""
    i = next(i for i, e in enumerate(other) if e != 0)
    return row[i] != 0 and vanish(
        [a * other[i] - b * row[i] for a, b in zip(row, other, strict=True)]
    )


def _fresh(name: str, taken: set[str]) -> sp.Expr:
    """A function of the time by a name that nothing else has."""
    name = unused_name(name, taken)
    taken.add(name)
    return _function(name)


def _function(name: str) -> sp.Expr:
    return sp.Function(name)(time)


def _parameters(exprs: Iterable[sp.Expr], given: Any) -> tuple[Any, ...]:
    """What a model holds besides coordinates, speeds and functions of the time."""
    declared = given if isinstance(given, Iterable) else (given,)
    known = tuple(p if isinstance(p, Parameter) else Parameter(p) for p in declared)
    symbols = set().union(*(e.free_symbols for e in exprs)) - {time}
    rest = sorted(symbols - {p.symbol for p in known}, key=str)
    return (*known, *map(Parameter, rest))


@dataclass(frozen=True)
class MechanicsModel:
    """Coordinates, speeds, bodies, loads, constraints, all in the user's symbols.

    ``kinematic`` are the kinematic differential equations, ``configuration`` and ``motion`` the
    constraints on coordinates and on velocities, all expressions that vanish; ``later`` are the
    coordinates that the user calls dependent, ``still`` the auxiliary speeds that turn a body, by
    which it would have no orientation: they are zero.  ``lagrangian`` is None in a model of Kane's.
    """

    frame: Any
    coordinates: tuple[sp.Expr, ...]
    later: tuple[sp.Expr, ...] = ()
    speeds: tuple[sp.Expr, ...] = ()
    dependent_speeds: tuple[sp.Expr, ...] = ()
    still: tuple[sp.Expr, ...] = ()
    kinematic: tuple[sp.Expr, ...] = ()
    configuration: tuple[sp.Expr, ...] = ()
    motion: tuple[sp.Expr, ...] = ()
    bodies: tuple[Any, ...] = ()
    loads: tuple[tuple[Any, Any], ...] = ()
    lagrangian: sp.Expr | None = None

    @property
    def all_speeds(self) -> tuple[sp.Expr, ...]:
        """Independent speeds, then dependent ones, auxiliary ones last."""
        return self.speeds + self.dependent_speeds


def _read_model(
    source: Any, arguments: tuple[Any, ...], named: Mapping[str, Any]
) -> MechanicsModel:
    """The record of a method of SymPy's, or of the arguments that it is called with."""
    from sympy.physics import mechanics as me

    if isinstance(source, me.KanesMethod | me.LagrangesMethod | me.System):
        if arguments or named.keys() - {"bodies", "forcelist"}:
            raise DefinitionError(
                f"from_mechanics: a {type(source).__name__} holds its coordinates and "
                "constraints; give it alone, or with bodies= and forcelist="
            )
        changes = {k: v for k, v in named.items() if v is not None}
        if isinstance(source, me.KanesMethod):
            return _of_kane(source, **changes)
        if isinstance(source, me.LagrangesMethod):
            return _of_lagrange_method(source, **changes)
        return _of_system(source, **changes)
    reader: Callable[..., MechanicsModel]
    reader = _kane if isinstance(source, me.ReferenceFrame) else _lagrange
    try:
        bound = inspect.signature(reader).bind(source, *arguments, **named)
    except TypeError as error:
        kind = "KanesMethod" if reader is _kane else "LagrangesMethod"
        raise DefinitionError(
            f"from_mechanics: {error}; with '{quote(source)}' first the arguments are those of "
            f"{kind}"
        ) from None
    return reader(*bound.args, **bound.kwargs)


def _kane(
    frame: Any,
    q_ind: Any,
    u_ind: Any,
    kd_eqs: Any = None,
    q_dependent: Any = None,
    configuration_constraints: Any = None,
    u_dependent: Any = None,
    velocity_constraints: Any = None,
    acceleration_constraints: Any = None,
    u_auxiliary: Any = None,
    bodies: Any = None,
    forcelist: Any = None,
    explicit_kinematics: Any = True,
    kd_eqs_solver: Any = None,
    constraint_solver: Any = None,
) -> MechanicsModel:
    """Arguments of KanesMethod, those after ``forcelist`` for SymPy alone; accelerations follow
    from the velocities, and auxiliary speeds are dependent ones, bound to vanish."""
    later, bodies = _names(q_dependent, "q_dependent"), _bodies(bodies)
    auxiliary = _names(u_auxiliary, "u_auxiliary")
    still = tuple(u for u in auxiliary if any(_turns(u, body, frame) for body in bodies))
    auxiliary = tuple(u for u in auxiliary if u not in still)
    return MechanicsModel(
        frame=frame,
        coordinates=_names(q_ind, "q_ind") + later,
        later=later,
        speeds=_names(u_ind, "u_ind"),
        dependent_speeds=_names(u_dependent, "u_dependent") + auxiliary,
        still=still,
        kinematic=_several(kd_eqs),
        configuration=_several(configuration_constraints),
        motion=_several(velocity_constraints) + auxiliary,
        bodies=bodies,
        loads=_loads(forcelist),
    )


def _lagrange(
    Lagrangian: Any,
    qs: Any,
    forcelist: Any = None,
    bodies: Any = None,
    frame: Any = None,
    hol_coneqs: Any = None,
    nonhol_coneqs: Any = None,
) -> MechanicsModel:
    """Arguments of LagrangesMethod; the bodies have gone into the Lagrangian."""
    rows = [
        x for e in _several(Lagrangian) for x in ([*e] if isinstance(e, sp.MatrixBase) else [e])
    ]
    if len(rows) != 1:
        raise DefinitionError(
            f"from_mechanics: '{quote(Lagrangian)}' is neither a ReferenceFrame, a Lagrangian nor "
            "a KanesMethod or LagrangesMethod; give what these methods are called with"
        )
    loads = _loads(forcelist)
    if loads and frame is None:
        raise DefinitionError(
            "from_mechanics: forces are given without an inertial frame; add frame=N"
        )
    return MechanicsModel(
        frame=frame,
        coordinates=_names(qs, "qs"),
        configuration=_several(hol_coneqs),
        motion=_several(nonhol_coneqs),
        loads=loads,
        lagrangian=rows[0],
    )


def _of_kane(kane: Any, bodies: Any = None, forcelist: Any = None) -> MechanicsModel:
    """A KanesMethod, with the bodies and loads that it was given."""
    bodies = kane.bodies if bodies is None else bodies
    if not bodies:
        raise DefinitionError(
            "from_mechanics: the KanesMethod holds no bodies; give bodies= and forcelist="
        )
    speeds = [*kane.u]
    count = len(speeds) - len(kane._udep)
    kinematic: list[sp.Expr] = []
    if kane._k_ku_implicit:
        rates = [*map(velocity, kane.q)]
        table = kane._k_ku_implicit.row_join(kane._k_kqdot_implicit).row_join(kane._f_k_implicit)
        kinematic = _sums(table, [*speeds, *rates, sp.S.One])
    motion = _sums(kane._k_nh.row_join(kane._f_nh), [*speeds, sp.S.One]) if kane._k_nh else []
    return _kane(
        kane._inertial, [*kane.q][: len(kane.q) - len(kane._qdep)], speeds[:count],
        kinematic, kane._qdep, kane._f_h, kane._udep, motion, None, kane._uaux, bodies,
        kane.loads if forcelist is None else forcelist,
    )  # fmt: skip


def _of_lagrange_method(method: Any, bodies: Any = None, forcelist: Any = None) -> MechanicsModel:
    """A LagrangesMethod; its constraints are the derivatives of the holonomic ones first."""
    return _lagrange(
        method._L[0], [*method.q], method.forcelist if forcelist is None else forcelist, bodies,
        method.inertial, [*method._hol_coneqs], [*method.coneqs][len(method._hol_coneqs) :],
    )  # fmt: skip


def _of_system(system: Any, bodies: Any = None, forcelist: Any = None) -> MechanicsModel:
    """A System of SymPy's: one without speeds is for Lagrange's method; the velocity constraints
    of others are derivatives of the holonomic ones first, where they are not given."""
    from sympy.physics.mechanics import Lagrangian

    bodies = system.bodies if bodies is None else bodies
    loads = [*(system.loads if forcelist is None else forcelist)]
    loads += [load for actuator in system.actuators for load in actuator.to_loads()]
    held = system.holonomic_constraints
    if all(isinstance(u, sp.Derivative) for u in system.u):
        energy = Lagrangian(system.frame, *_bodies(bodies))
        rows = system.nonholonomic_constraints
        return _lagrange(energy, system.q, loads, None, system.frame, held, rows)
    derived = len(held) if system._vel_constrs is None else 0
    return _kane(
        system.frame, system.q_ind, system.u_ind, system.kdes, system.q_dep, held, system.u_dep,
        [*system.velocity_constraints][derived:], None, system.u_aux, bodies, loads,
    )  # fmt: skip


def _sums(table: Any, factors: list[Any]) -> list[sp.Expr]:
    """The rows of a matrix times a column, as they stand: SymPy would look for what cancels."""
    return [
        sp.Add(
            *[sp.Mul(e, x, evaluate=False) for e, x in zip(row, factors, strict=True) if e != 0],
            evaluate=False,
        )
        for row in table.tolist()
    ]


def _several(things: Any) -> tuple[Any, ...]:
    """What SymPy takes for several expressions: None, one, a matrix or any iterable."""
    if things is None:
        return ()
    if isinstance(things, sp.MatrixBase):
        return (*things,)
    return (*things,) if isinstance(things, Iterable) else (things,)


def _names(things: Any, place: str) -> tuple[sp.Expr, ...]:
    """Coordinates or speeds."""
    names = _several(things)
    for name in names:
        if not is_symbolic_name(name):
            raise DefinitionError(
                f"from_mechanics: '{quote(name)}' in {place} is neither a symbol nor a "
                "dynamicsymbol; name it by one"
            )
    return names


def _bodies(things: Any) -> tuple[Any, ...]:
    from sympy.physics.mechanics import Particle, RigidBody

    bodies = _several(things)
    if not bodies:
        raise DefinitionError(
            "from_mechanics: there are no bodies; give bodies=[...], RigidBody or Particle"
        )
    for body in bodies:
        if not isinstance(body, Particle | RigidBody):
            raise DefinitionError(
                f"from_mechanics: '{quote(body)}' among the bodies is neither a RigidBody nor a "
                "Particle"
            )
    return bodies


def _turns(speed: sp.Expr, body: Any, frame: Any) -> bool:
    """Whether a body's angular velocity holds a speed."""
    turn = body.frame.ang_vel_in(frame).args if hasattr(body, "frame") else ()
    return any(column.has(speed) for column, _ in turn)


def _loads(things: Any) -> tuple[tuple[Any, Any], ...]:
    """Pairs of a point or a frame with a vector."""
    from sympy.physics.mechanics import Point, ReferenceFrame, Vector

    pairs = []
    for load in _several(things):
        pair = tuple(load) if isinstance(load, Iterable) else ()
        kinds = len(pair) == 2 and isinstance(pair[0], Point | ReferenceFrame)
        if not kinds or not (isinstance(pair[1], Vector) or pair[1] == 0):
            raise DefinitionError(
                f"from_mechanics: the load '{quote(load)}' is no pair of a Point or a "
                "ReferenceFrame with a Vector: it acts along nothing that has a velocity"
            )
        pairs.append(pair)
    return tuple(p for p in pairs if p[1] != 0)
