"""Where a motion starts: parameters, and an initial state on the constraints.

Data off the constraints are refused with their residual, or, on request, moved onto them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import names_in, plain_name
from voronec.checks import require_possible
from voronec.errors import DefinitionError
from voronec.flow.conditions import CONSISTENT, Rates, changes, met
from voronec.flow.manifold import Relations
from voronec.flow.vocabulary import Vocabulary, number
from voronec.reading import mapping, shown, texts_read

__all__ = ["Start", "coordinates_of", "named", "numbers_of", "parameter_values", "start_of"]


def named(vocabulary: Vocabulary, given: Mapping[Any, Any], role: str) -> dict[str, Any]:
    """Values by plain name; ``role`` is ``parameter`` or ``initial value``."""
    system = vocabulary.equations.system
    if role == "parameter":
        among = [p.name for p in system.parameters]
    else:
        constants = {p.name for p in system.parameters}
        among = [name for name in vocabulary.symbols if name not in constants | {"t"}]
    result: dict[str, Any] = {}
    argument = "parameters" if role == "parameter" else "initial"
    for key, value in texts_read(mapping(given, argument, "name: value"), role).items():
        name = vocabulary.name(key, among, role)
        if name in result:
            raise DefinitionError(f"system '{system.name}': the {role} '{name}' is given twice")
        result[name] = value
    return result


def parameter_values(
    vocabulary: Vocabulary, given: Mapping[str, Any], needed: set[str]
) -> dict[str, float]:
    """Every parameter's value: as given, else its default; checked against its range.

    One that is not among ``needed`` may lack a value and is left out.
    """
    system = vocabulary.equations.system
    values: dict[str, float] = {}
    missing = []
    for parameter in system.parameters:
        value = given.get(parameter.name, parameter.value)
        if value is None:
            missing += [parameter.name] if parameter.name in needed else []
            continue
        place = f"system '{system.name}': parameter '{parameter.name}'"
        values[parameter.name] = number(value, place)
        try:
            parameter.check(value)
        except DefinitionError as error:
            raise DefinitionError(f"system '{system.name}': {error}") from None
    if missing:
        raise DefinitionError(
            f"system '{system.name}': no value for the parameter(s) {', '.join(missing)}; give "
            f"parameters={{'{missing[0]}': ...}}"
        )
    require_possible(system, given)
    return values


@dataclass(frozen=True)
class Start:
    """Where a motion starts: coordinates, then velocities v.

    ``notes`` say what was moved to meet the constraints, each in one line; nothing is moved unless
    that was asked for.
    """

    state: np.ndarray
    notes: tuple[str, ...] = ()


def start_of(
    vocabulary: Vocabulary,
    scene: Mapping[str, Any],
    given: Mapping[str, Any],
    parameters: Mapping[str, float],
    rates: Rates,
    time: float = 0.0,
    project: bool = False,
) -> Start:
    """Coordinates, then velocities v, at the start; what nobody names is zero.

    ``given`` overrides ``scene`` entry by entry.  Coordinates must satisfy the relations between
    redundant ones.  Velocities of coordinates are conditions on v, rates(q, v) = value, that must
    be consistent and must determine the v they involve.  ``DefinitionError`` with the residual
    where data do not fit; with ``project`` the nearest coordinates on the relations are taken, and
    the v that meet all conditions best (least squares).
    """
    system = vocabulary.equations.system
    coordinates = [plain_name(q) for q in system.coordinates]
    old, new = (numbers_of(vocabulary, part, parameters) for part in (scene, given))
    q, notes = coordinates_of(vocabulary, {**old, **new}, parameters, time, project)
    v = np.zeros(len(system.velocities))
    for values in (old, new):
        conditions = {k: x for k, x in values.items() if k not in coordinates}
        v, moved = met(vocabulary, q, v, conditions, rates, project)
        notes += moved
    return Start(np.concatenate([q, v]), tuple(notes))


def coordinates_of(
    vocabulary: Vocabulary,
    values: Mapping[str, float],
    parameters: Mapping[str, float],
    time: float,
    project: bool,
) -> tuple[np.ndarray, list[str]]:
    """The coordinates, checked; or the nearest on the relations, and how far they were moved."""
    system = vocabulary.equations.system
    q = np.array([values.get(plain_name(x), 0.0) for x in system.coordinates])
    if not system.fibration.relations:
        return q, []
    relations = Relations.of(vocabulary.equations.form, parameters, time)
    off = relations.residuals(q)
    worst = int(np.argmax(np.where(np.isnan(off), np.inf, np.abs(off))))
    if abs(off[worst]) < CONSISTENT:
        return q, []
    problem = (
        f"system '{system.name}': the initial point does not satisfy the relation "
        f"{system.fibration.relations[worst]} = 0 (residual {off[worst]:.3g})"
    )
    if not project:
        raise DefinitionError(f"{problem}; correct the coordinates, or give project=True")
    moved = relations.nearest(q, CONSISTENT)
    if moved is None:
        raise DefinitionError(
            f"{problem}, and no point nearby was found that does; correct the coordinates"
        )
    names = (plain_name(x) for x in system.coordinates)
    return moved, [
        f"the initial coordinates were moved by {np.linalg.norm(moved - q):.3g} onto the relations"
        f" ({changes(names, q, moved)})"
    ]


def numbers_of(
    vocabulary: Vocabulary, values: Mapping[str, Any], parameters: Mapping[str, float]
) -> dict[str, float]:
    """Initial values as numbers; they may be expressions in the parameters."""
    result = {}
    for name, value in values.items():
        if isinstance(value, sp.Expr) and not value.is_number:
            held = {s: plain_name(s) for s in names_in(value)}
            value = value.xreplace(
                {s: sp.Float(parameters[n], 17) for s, n in held.items() if n in parameters}
            )
        place = f"system '{vocabulary.equations.system.name}': initial value '{name}'"
        lacking = sorted(map(str, value.free_symbols)) if isinstance(value, sp.Expr) else []
        if lacking:
            raise DefinitionError(
                f"{place} = {shown(value)} is not a real number, since '{lacking[0]}' has no value"
            )
        result[name] = number(value, place)
    return result
