"""What ``KanesMethod`` or ``LagrangesMethod`` is called with, read into one record."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, velocity
from voronec.errors import DefinitionError, quote

__all__ = ["MechanicsModel", "read_model"]


@dataclass(frozen=True)
class MechanicsModel:
    """Coordinates, speeds, bodies, loads, constraints, all in the user's symbols.

    ``kinematic`` are the kinematic differential equations, ``configuration`` and ``motion`` the
    constraints on coordinates and on velocities, all expressions that vanish; ``later`` are the
    coordinates that the user calls dependent.  ``lagrangian`` is None in a model of Kane's.
    """

    frame: Any
    coordinates: tuple[sp.Expr, ...]
    later: tuple[sp.Expr, ...] = ()
    speeds: tuple[sp.Expr, ...] = ()
    dependent_speeds: tuple[sp.Expr, ...] = ()
    auxiliary: tuple[sp.Expr, ...] = ()
    kinematic: tuple[sp.Expr, ...] = ()
    configuration: tuple[sp.Expr, ...] = ()
    motion: tuple[sp.Expr, ...] = ()
    bodies: tuple[Any, ...] = ()
    loads: tuple[tuple[Any, Any], ...] = ()
    lagrangian: sp.Expr | None = None

    @property
    def all_speeds(self) -> tuple[sp.Expr, ...]:
        """Independent speeds, then dependent ones."""
        return self.speeds + self.dependent_speeds


def read_model(source: Any, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> MechanicsModel:
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
) -> MechanicsModel:
    """Arguments of KanesMethod; accelerations follow from the velocities."""
    later = _names(q_dependent, "q_dependent")
    return MechanicsModel(
        frame=frame,
        coordinates=_names(q_ind, "q_ind") + later,
        later=later,
        speeds=_names(u_ind, "u_ind"),
        dependent_speeds=_names(u_dependent, "u_dependent"),
        auxiliary=_names(u_auxiliary, "u_auxiliary"),
        kinematic=_several(kd_eqs),
        configuration=_several(configuration_constraints),
        motion=_several(velocity_constraints),
        bodies=_bodies(bodies),
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
    """A System of SymPy's."""
    loads = [*(system.loads if forcelist is None else forcelist)]
    loads += [load for actuator in system.actuators for load in actuator.to_loads()]
    return _kane(
        system.frame, system.q_ind, system.u_ind, system.kdes, system.q_dep,
        system.holonomic_constraints, system.u_dep, system.velocity_constraints, None,
        system.u_aux, system.bodies if bodies is None else bodies, loads,
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


def _loads(things: Any) -> tuple[tuple[Any, Any], ...]:
    """Pairs of a point or a frame with a vector."""
    from sympy.physics.mechanics import Point, ReferenceFrame, Vector

    found = []
    for load in _several(things):
        pair = tuple(load) if isinstance(load, Iterable) else ()
        kinds = len(pair) == 2 and isinstance(pair[0], Point | ReferenceFrame)
        if not kinds or not (isinstance(pair[1], Vector) or pair[1] == 0):
            raise DefinitionError(
                f"from_mechanics: the load '{quote(load)}' is no pair of a Point or a "
                "ReferenceFrame with a Vector: it acts along nothing that has a velocity"
            )
        found.append(pair)
    return tuple(p for p in found if p[1] != 0)
