"""What is looked at along a motion: outputs, integrals, relations; evaluated on the whole grid."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.symbols import plain_name
from voronec.equations.program import Program, compiled
from voronec.equations.program.digits import compiled_digits, precision
from voronec.motion.reactions import Multipliers
from voronec.motion.trajectory import Cost, Trajectory
from voronec.motion.vocabulary import Vocabulary, Wanted

__all__ = ["Branch", "Watch", "assembled", "evaluated", "followed", "observed", "watched"]

CANCELLED = 1e-6
"""An integral less than this part of its terms counts as starting at zero."""
SMALL, ROUNDING, NOTHING = 1e-9, 1e-12, 1e-3
"""Terms of an integral that stay below the first may be rounding: they are, below the third part of
what they are where no state is less than the second."""


@dataclass(frozen=True)
class Branch:
    """An angle read off two quantities: atan2(turn[1] sine, turn[0] cosine) and whole turns.

    At ``start``, its value there, the branch begins; from instant to instant the nearest is taken.
    """

    cosine: str
    sine: str
    turn: tuple[int, int]
    start: float

    def along(self, series: Mapping[str, np.ndarray]) -> np.ndarray:
        """The angle at every instant."""
        a, b = self.turn[0] * series[self.cosine], self.turn[1] * series[self.sine]
        if a.dtype != object:
            angles = np.unwrap(np.arctan2(b, a))
            return angles + 2 * np.pi * np.round((self.start - angles[0]) / (2 * np.pi))
        plain = np.array([mpmath.atan2(y, x) for x, y in zip(a, b, strict=True)], dtype=object)
        rough = plain.astype(float)
        turns = np.round((np.unwrap(rough) - rough) / (2 * np.pi))
        turns += np.round((self.start - rough[0]) / (2 * np.pi)) - turns[0]
        return plain + np.array([2 * mpmath.pi * int(k) for k in turns], dtype=object)


@dataclass(frozen=True)
class Watch:
    """The quantities to follow, and under which names the program computes them.

    ``outputs`` in order; those in ``reactions``, positions of constraints, come from
    ``multipliers`` and the accelerations, those in ``branches`` are angles read off others; the
    rest are ``expressions`` of their own.  ``besides`` are coordinates and velocities that nobody
    asked for and that are known without being integrated.
    """

    outputs: tuple[str, ...]
    integrals: Mapping[str, str]
    sizes: Mapping[str, str]
    relations: Mapping[str, str]
    expressions: Mapping[str, Any]
    reactions: Mapping[str, int] = field(default_factory=dict)
    multipliers: Multipliers | None = None
    branches: Mapping[str, Branch] = field(default_factory=dict)
    besides: tuple[str, ...] = ()

    @classmethod
    def of(
        cls,
        wanted: Wanted,
        integrals: Mapping[str, Any],
        relations: Mapping[str, Any],
        multipliers: Multipliers | None = None,
    ) -> Watch:
        """Outputs spelled out, and integrals and relations as expressions inside, by name.

        ``multipliers`` are needed where the outputs hold reactions.
        """
        expressions = dict(wanted.expressions)
        for name, inside in integrals.items():
            expressions[f"integral {name}"] = inside
            expressions[f"size of integral {name}"] = _size(inside)
        expressions |= {f"relation {name}": inside for name, inside in relations.items()}
        if multipliers is not None:
            expressions |= multipliers.entries
        return cls(
            outputs=wanted.names,
            integrals={name: f"integral {name}" for name in integrals},
            sizes={name: f"size of integral {name}" for name in integrals},
            relations={f"{name} = 0": f"relation {name}" for name in relations},
            expressions=expressions,
            reactions=wanted.reactions,
            multipliers=multipliers,
        )


def watched(
    vocabulary: Vocabulary, outputs: Sequence[Any], integrals: Iterable[str] | None = None
) -> Watch:
    """Outputs, declared integrals with the size of their terms, every relation.

    ``integrals`` names those to follow; without it, all.
    """
    system = vocabulary.equations.system
    wanted = vocabulary.wanted(outputs)
    chosen = system.integrals if integrals is None else tuple(integrals)
    names = [vocabulary.name(name, system.integrals, "integral") for name in chosen]
    return Watch.of(
        wanted,
        {name: vocabulary.inward(vocabulary.claims[name]) for name in names},
        {str(r): vocabulary.inward(r) for r in system.fibration.relations},
        Multipliers.of(vocabulary.equations.definition) if wanted.reactions else None,
    )


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
    """The program's extra quantities at states (k, n), each an array of shape (k,).

    States that are mpmath's numbers give such numbers, of their precision.
    """
    arrays = _along(program, 1, t, states, values)
    return dict(zip(program.names, arrays, strict=True))


def _along(
    program: Program, which: int, t: np.ndarray, states: np.ndarray, values: Sequence[Any]
) -> list[np.ndarray]:
    """Rates (``which`` 0) or extra quantities (1) of a program on a grid."""
    if states.dtype == object:
        results = compiled_digits(program)[which](t, list(states.T), list(values))
        # constants of a program may be integers
        plain = [mpmath.mpf(r) if isinstance(r, int) else r for r in results]
        return [np.broadcast_to(np.asarray(r, dtype=object), t.shape).copy() for r in plain]
    with np.errstate(all="ignore"):
        results = compiled(program)[which](t, list(states.T), list(values))
    return [np.broadcast_to(np.asarray(r, dtype=float), t.shape).copy() for r in results]


def followed(
    watch: Watch, program: Program, t: np.ndarray, states: np.ndarray, values: Sequence[float]
) -> dict[str, np.ndarray]:
    """Everything watched at states (k, n), reactions too, by the names of ``Watch``."""
    series = evaluated(program, t, states, values)
    if len(t):
        series |= {name: branch.along(series) for name, branch in watch.branches.items()}
    if watch.multipliers is None:
        return series
    slopes = dict(zip(map(str, program.state), _along(program, 0, t, states, values), strict=True))
    with mpmath.workprec(precision(states)):
        multipliers = watch.multipliers.solved(
            {name: series.pop(name) for name in watch.multipliers.entries},
            [slopes[str(v)] for v in watch.multipliers.velocities],
        )
    return series | {name: multipliers[:, k].copy() for name, k in watch.reactions.items()}


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
    values = [constants.get(str(p), np.nan) for p in program.parameters]
    series = followed(watch, program, t, states, values)
    names = tuple(map(str, program.state))
    return assembled(
        vocabulary, watch, t, names, states, series, constants, cost, interrupted,
        lambda: _largest(watch, program, t, states, values),
    )  # fmt: skip


def assembled(
    vocabulary: Vocabulary,
    watch: Watch,
    t: np.ndarray,
    names: tuple[str, ...],
    states: np.ndarray,
    series: Mapping[str, np.ndarray],
    constants: Mapping[str, float],
    cost: Cost,
    interrupted: bool = False,
    usual: Callable[[], Mapping[str, float]] = dict,
) -> Trajectory:
    """The trajectory of states (k, n) called ``names`` and of everything watched along them.

    ``usual`` gives the terms of integrals where no state is rounding, as far as that is known.
    """
    system = vocabulary.equations.system
    own = [plain_name(x) for x in (*system.coordinates, *system.velocities)]
    if own != list(names) and set(own) <= set(watch.outputs):
        # what was integrated is another set of variables; these are what the user knows
        names, states = tuple(own), np.stack([series[name] for name in own], axis=-1)
    for array in (t, states, *series.values()):
        array.flags.writeable = False
    still = {n: x for n, x in constants.items() if np.ndim(x) == 0}  # others are inputs
    known = {p.name for p in system.parameters if not mpmath.isnan(still.get(p.name, np.nan))}
    return Trajectory(
        system=system,
        t=t,
        state=states,
        names=names,
        outputs=watch.outputs,
        series=MappingProxyType({n: series[n] for n in (*watch.outputs, *watch.besides)}),
        integrals=MappingProxyType({n: series[key] for n, key in watch.integrals.items()}),
        parameters=MappingProxyType({n: x for n, x in constants.items() if n in known}),
        drift=MappingProxyType(_drifts(watch, series, usual)),
        residuals=MappingProxyType(
            {r: float(np.abs(series[key]).max()) for r, key in watch.relations.items()}
        ),
        cost=cost,
        interrupted=interrupted,
    )


def _drifts(
    watch: Watch, series: Mapping[str, np.ndarray], usual: Callable[[], Mapping[str, float]]
) -> dict[str, float]:
    """See ``Trajectory.drift``; ``usual`` gives integrals' terms where no state is rounding."""
    sizes = {name: series[watch.sizes[name]].max() for name in watch.integrals}
    least = usual() if any(size <= SMALL for size in sizes.values()) else {}
    found = {}
    for name, key in watch.integrals.items():
        values, size = series[key], sizes[name]
        start = abs(values[0])
        scale = start if start > CANCELLED * size else size
        if size <= NOTHING * least.get(name, 0.0) or size == 0:
            scale = least.get(name, 1.0)
        found[name] = float(np.abs(values - values[0]).max() / scale)
    return found


def _largest(
    watch: Watch, program: Program, t: np.ndarray, states: np.ndarray, values: Sequence[Any]
) -> dict[str, float]:
    """The sizes of integrals with every state at its largest, and not below what rounding leaves
    of states of size 1; 1 where that is no number."""
    largest = np.abs(states.astype(float)).max(axis=0, initial=ROUNDING)[None, :]
    plain = [float(x) if np.ndim(x) == 0 else x for x in values]
    found = evaluated(program, t[:1].astype(float), largest, plain)
    sizes = {name: float(found[key][0]) for name, key in watch.sizes.items()}
    return {name: x if np.isfinite(x) and x > 0 else 1.0 for name, x in sizes.items()}
