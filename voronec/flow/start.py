"""Where a motion starts: parameters, and an initial state on the constraints."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.errors import DefinitionError
from voronec.flow.vocabulary import Vocabulary, number

__all__ = ["initial_state", "named", "parameter_values"]

CONSISTENT = 1e-9
"""How far initial data may lie off the constraints, relative to their size."""

Rates = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Coordinates (n,) and velocities (m, k) to the velocities of all coordinates (n, k)."""


def named(vocabulary: Vocabulary, given: Mapping[Any, Any], role: str) -> dict[str, Any]:
    """Values by plain name; ``role`` is ``parameter`` or ``initial value``."""
    system = vocabulary.equations.system
    if role == "parameter":
        among = [p.name for p in system.parameters]
    else:
        constants = {p.name for p in system.parameters}
        among = [name for name in vocabulary.symbols if name not in constants | {"t"}]
    result: dict[str, Any] = {}
    for key, value in given.items():
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
        parameter.check(value)
    if missing:
        raise DefinitionError(
            f"system '{system.name}': no value for the parameter(s) {', '.join(missing)}; give "
            f"parameters={{'{missing[0]}': ...}}"
        )
    return values


def initial_state(
    vocabulary: Vocabulary,
    scene: Mapping[str, Any],
    given: Mapping[str, Any],
    parameters: Mapping[str, float],
    rates: Rates,
) -> np.ndarray:
    """Coordinates, then velocities v, at the start; what nobody names is zero.

    ``given`` overrides ``scene`` entry by entry.  Velocities of coordinates are conditions on v,
    rates(q, v) = value, that must be consistent and must determine the v they involve.
    """
    system = vocabulary.equations.system
    coordinates = [plain_name(q) for q in system.coordinates]
    velocities = [plain_name(v) for v in system.velocities]
    old, new = (_numbers(vocabulary, part, parameters) for part in (scene, given))
    q = np.array([{**old, **new}.get(name, 0.0) for name in coordinates])
    v = np.zeros(len(velocities))
    for values in (old, new):
        conditions = {k: x for k, x in values.items() if k not in coordinates}
        v = _velocities(vocabulary, q, v, conditions, rates)
    return np.concatenate([q, v])


def _numbers(
    vocabulary: Vocabulary, values: Mapping[str, Any], parameters: Mapping[str, float]
) -> dict[str, float]:
    """Initial values as numbers; they may be expressions in the parameters."""
    symbols = {vocabulary.symbols[name]: x for name, x in parameters.items()}
    result = {}
    for name, value in values.items():
        if isinstance(value, sp.Expr) and not value.is_number:
            value = value.xreplace({s: sp.Float(x, 17) for s, x in symbols.items()})
        result[name] = number(value, f"initial value '{name}'")
        if not np.isfinite(result[name]):
            raise DefinitionError(f"initial value '{name}' = {value} is not finite")
    return result


def _velocities(
    vocabulary: Vocabulary,
    q: np.ndarray,
    v: np.ndarray,
    conditions: Mapping[str, float],
    rates: Rates,
) -> np.ndarray:
    """The velocities that meet the conditions; those that no condition involves stay."""
    if not conditions:
        return v
    system = vocabulary.equations.system
    own = [plain_name(x) for x in system.velocities]
    n = len(own)
    # rates are affine in v: their values at 0 and at the unit vectors tell them
    values = rates(q, np.hstack([np.zeros((n, 1)), np.eye(n)]))
    linear, offset = values[:, 1:] - values[:, :1], values[:, 0]
    if not np.isfinite(values).all():
        raise DefinitionError(
            f"system '{system.name}': the velocities are not defined at the initial point"
        )
    dots = [plain_name(velocity(x)) for x in system.coordinates]
    order = [name for name in (*own, *dots) if name in conditions]
    order = list(dict.fromkeys(order))
    rows = np.array([np.eye(n)[own.index(k)] if k in own else linear[dots.index(k)] for k in order])
    right = np.array([conditions[k] - (0.0 if k in own else offset[dots.index(k)]) for k in order])
    chosen = _independent(rows)
    involved = np.abs(rows).max(axis=0) > CONSISTENT * np.abs(rows).max(initial=0.0)
    if len(chosen) < involved.sum():
        names = [name for name, i in zip(own, involved, strict=True) if i]
        raise DefinitionError(
            f"system '{system.name}': the initial velocities do not determine {', '.join(names)}; "
            "give more velocities, or these themselves"
        )
    result = v.copy()
    result[involved] = np.linalg.solve(rows[chosen][:, involved], right[chosen])
    for name in set(own) & set(order):
        result[own.index(name)] = conditions[name]
    _check_consistent(vocabulary, order, conditions, rows @ result - right)
    return result


def _independent(rows: np.ndarray) -> list[int]:
    """Positions of the first rows that are linearly independent."""
    chosen: list[int] = []
    for i in range(len(rows)):
        scaled = [rows[j] / (np.linalg.norm(rows[j]) or 1.0) for j in (*chosen, i)]
        if np.linalg.matrix_rank(np.array(scaled), tol=CONSISTENT) == len(scaled):
            chosen.append(i)
    return chosen


def _check_consistent(
    vocabulary: Vocabulary, order: list[str], conditions: Mapping[str, float], excess: np.ndarray
) -> None:
    scale = 1.0 + max(map(abs, conditions.values()))
    worst = int(np.argmax(np.abs(excess)))
    if abs(excess[worst]) <= CONSISTENT * scale:
        return
    name = order[worst]
    value = float(conditions[name])
    raise DefinitionError(
        f"system '{vocabulary.equations.system.name}': the initial velocities are off the "
        f"constraints: '{name}' = {value:.12g}, where the others give {value + excess[worst]:.12g} "
        f"(residual {abs(excess[worst]):.3g}); correct '{name}' or leave it out"
    )
