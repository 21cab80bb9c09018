"""What is looked at along a motion: outputs, integrals, relations; evaluated on the whole grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import symengine as se

from voronec.algebra.symbols import plain_name
from voronec.flow.trajectory import Cost, Trajectory
from voronec.flow.vocabulary import Vocabulary
from voronec.program import Program, compiled

__all__ = ["Watch", "evaluated", "observed", "watched"]

CANCELLED = 1e-6
"""An integral less than this part of its terms counts as starting at zero."""
NOTHING = 1e-9
"""An integral whose terms all stay below this is compared absolutely."""


@dataclass(frozen=True)
class Watch:
    """The quantities to follow, and under which names the program computes them."""

    outputs: tuple[str, ...]
    integrals: Mapping[str, str]
    sizes: Mapping[str, str]
    relations: Mapping[str, str]
    expressions: Mapping[str, Any]


def watched(vocabulary: Vocabulary, outputs: Sequence[Any]) -> Watch:
    """Outputs, every declared integral with the size of its terms, every relation."""
    system = vocabulary.equations.system
    keys = outputs or (*system.coordinates, *system.velocities)
    shown = dict(vocabulary.quantity(key) for key in keys)
    integrals = {name: f"integral {name}" for name in system.integrals}
    sizes = {name: f"size of integral {name}" for name in system.integrals}
    relations = {f"{r} = 0": f"relation {r}" for r in system.fibration.relations}
    expressions = dict(shown)
    for name in system.integrals:
        inside = vocabulary.inward(vocabulary.claims[name])
        expressions[integrals[name]] = inside
        expressions[sizes[name]] = _size(inside)
    for expr, key in zip(system.fibration.relations, relations.values(), strict=True):
        expressions[key] = vocabulary.inward(expr)
    return Watch(tuple(shown), integrals, sizes, relations, expressions)


def _size(expr: Any, done: dict[Any, Any] | None = None) -> Any:
    """The expression with every term of its sums taken positive: what it is without cancelling."""
    known: dict[Any, Any] = {} if done is None else done
    if expr not in known:
        if isinstance(expr, se.Add | se.Mul):
            known[expr] = type(expr)(*[_size(a, known) for a in expr.args])
        elif isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Integer) and expr.args[1] > 0:
            known[expr] = se.Pow(_size(expr.args[0], known), expr.args[1])
        else:
            known[expr] = se.Abs(expr)
    return known[expr]


def evaluated(
    program: Program, t: np.ndarray, states: np.ndarray, values: Sequence[float]
) -> dict[str, np.ndarray]:
    """The program's extra quantities at states (k, n), each an array of shape (k,)."""
    _, extras = compiled(program)
    with np.errstate(all="ignore"):
        results = extras(t, list(states.T), list(values))
    arrays = (np.broadcast_to(np.asarray(r, dtype=float), t.shape).copy() for r in results)
    return dict(zip(program.names, arrays, strict=True))


def observed(
    vocabulary: Vocabulary,
    watch: Watch,
    program: Program,
    t: np.ndarray,
    states: np.ndarray,
    constants: Mapping[str, float],
    cost: Cost,
    interrupted: bool,
) -> Trajectory:
    """The trajectory of states on a grid."""
    system = vocabulary.equations.system
    values = [constants.get(str(p), np.nan) for p in program.parameters]
    series = evaluated(program, t, states, values)
    for array in (t, states, *series.values()):
        array.flags.writeable = False
    drift = {
        name: _drift(series[key], series[watch.sizes[name]])
        for name, key in watch.integrals.items()
    }
    return Trajectory(
        system=system,
        t=t,
        state=states,
        names=tuple(plain_name(s) for s in (*system.coordinates, *system.velocities)),
        outputs=watch.outputs,
        series=MappingProxyType({name: series[name] for name in watch.outputs}),
        integrals=MappingProxyType({n: series[key] for n, key in watch.integrals.items()}),
        parameters=MappingProxyType(dict(constants)),
        drift=MappingProxyType(drift),
        residuals=MappingProxyType(
            {r: float(np.abs(series[key]).max()) for r, key in watch.relations.items()}
        ),
        cost=cost,
        interrupted=interrupted,
    )


def _drift(values: np.ndarray, sizes: np.ndarray) -> float:
    """See ``Trajectory.drift``."""
    start, size = abs(values[0]), sizes.max()
    scale = start if start > CANCELLED * size else size
    scale = scale if size > NOTHING else 1.0
    return float(np.abs(values - values[0]).max() / scale)
