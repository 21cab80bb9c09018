"""What is looked at along a motion: outputs, integrals, relations; evaluated on the whole grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import mpmath
import numpy as np
import symengine as se

from voronec.algebra.precision import GENERIC
from voronec.equations.program import Program, compile_program
from voronec.equations.program.python import compiled_digits, precision
from voronec.equations.program.straight import prune
from voronec.errors import DefinitionError
from voronec.motion.reactions import Multipliers
from voronec.motion.request import Namespace, OutputTerms


@dataclass(frozen=True)
class AngleBranch:
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
class ObservedQuantities:
    """The quantities to follow, and under which names the program computes them.

    ``outputs`` in order; those in ``reactions``, positions of constraints, come from
    ``multipliers`` and the accelerations, those in ``branches`` are angles read off others; the
    rest are ``expressions`` of their own.  ``relations`` are those of the coordinates, and
    ``vanishing`` those that a model's variables have by their meaning.  ``besides`` are coordinates
    and velocities that nobody asked for and that are known without being integrated; ``forces``
    says whether expressions, or functions of events, hold reactions.
    """

    outputs: tuple[str, ...]
    integrals: Mapping[str, str]
    sizes: Mapping[str, str]
    relations: Mapping[str, str]
    expressions: Mapping[str, Any]
    reactions: Mapping[str, int] = field(default_factory=dict)
    multipliers: Multipliers | None = None
    branches: Mapping[str, AngleBranch] = field(default_factory=dict)
    besides: tuple[str, ...] = ()
    vanishing: Mapping[str, str] = field(default_factory=dict)
    forces: bool = False

    @property
    def known(self) -> tuple[str, ...]:
        """What a trajectory knows by name beside its states: outputs, and what comes with them."""
        return (*self.outputs, *self.besides)

    @cached_property
    def for_conservation(self) -> frozenset[str]:
        """The names under which the program computes integrals, their sizes and relations."""
        parts = (self.integrals, self.sizes, self.relations, self.vanishing)
        return frozenset(key for part in parts for key in part.values())

    @classmethod
    def of(
        cls,
        wanted: OutputTerms,
        terms: Mapping[str, Any],
        integrals: Mapping[str, Any],
        relations: Mapping[str, Any],
        multipliers: Multipliers | None = None,
    ) -> ObservedQuantities:
        """Outputs as ``terms``, and integrals and relations as expressions inside, by name.

        ``multipliers`` are needed where the outputs hold reactions.
        """
        expressions = dict(terms)
        for name, inside in integrals.items():
            expressions[f"integral {name}"] = inside
            expressions[f"size of integral {name}"] = size_of_terms(inside)
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

    def require_reactions(self, held: bool, system: str) -> None:
        """Refuse reactions of a motion that was ``held`` on a switching surface."""
        if held and (self.reactions or self.forces):
            raise DefinitionError(
                f"system '{system}': reactions are not known while friction holds the motion on a "
                "switching surface; leave them out, or end the run before"
            )

    def integrals_to_follow(
        self, smooth: bool, jumping: bool = False
    ) -> dict[str, tuple[str, str]]:
        """The integrals to follow, each with the size of its terms, by the names under which the
        program computes them; where the right side is not smooth, those that do not jump with it,
        or those ``jumping``.
        """
        return {
            name: (key, self.sizes[name])
            for name, key in self.integrals.items()
            if jumping == (not smooth and jumps(self.expressions[key]))
        }


def jumps(expr: Any) -> bool:
    """Whether an expression jumps where signs and floors do, as with dry friction."""
    return bool(expr.atoms(se.sign, se.floor))


def watch_of(namespace: Namespace, outputs: Sequence[Any]) -> ObservedQuantities:
    """Outputs, declared integrals with the size of their terms, every relation."""
    system = namespace.equations.system
    wanted = namespace.read_outputs(outputs)
    return ObservedQuantities.of(
        wanted,
        wanted.expressions,
        {name: namespace.inward(namespace.claims[name]) for name in system.integrals},
        {str(r): namespace.inward(r) for r in system.fibration.relations},
        Multipliers.of(namespace.reaction_definition) if wanted.reactions else None,
    )


ROUNDING = se.Integer(2) ** -52
"""By so much of its terms a sum of doubles is off."""


def size_of_terms(expr: Any, done: dict[Any, Any] | None = None) -> Any:
    """How large the terms are that an expression is made of: its rounding is of that size.

    The terms of sums are taken positive.  A factor beside others, as in a power, counts by its
    terms once, the others by their values and what rounding adds to these: (x - c)^4 is
    (|x| + |c|) |x - c|^3, but where x - c is rounding.
    """

    def value(part: Any) -> Any:
        size = size_of_terms(part, known)
        return size if size == se.Abs(part) else se.Abs(part) + ROUNDING * size

    known: dict[Any, Any] = {} if done is None else done
    if expr not in known:
        if isinstance(expr, se.Add):
            known[expr] = se.Add(*[size_of_terms(a, known) for a in expr.args])
        elif isinstance(expr, se.Mul):
            sizes = {a: size_of_terms(a, known) for a in expr.args}
            loose = [a for a, size in sizes.items() if size != se.Abs(a)]
            products = [sizes[a] * se.Mul(*[value(b) for b in sizes if b != a]) for a in loose]
            known[expr] = se.Add(*products) if loose else se.Abs(expr)
        elif isinstance(expr, se.Pow) and isinstance(expr.args[1], se.Integer) and expr.args[1] > 0:
            base, exponent = expr.args
            known[expr] = size_of_terms(base, known) * value(base) ** (exponent - 1)
        else:
            known[expr] = se.Abs(expr)
    return known[expr]


@lru_cache(maxsize=64)  # it is asked after every run
def shown_program(program: Program, kept: frozenset[str]) -> Program:
    """A program without the extra quantities that are ``kept`` for those who ask for them."""
    return program.only([i for i, name in enumerate(program.names) if name not in kept])


def evaluate_extras(
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
        return _digits_along(program, which, t, states, values)
    with np.errstate(all="ignore"):
        results = compile_program(program)[which](t, list(states.T), list(values))
    return [
        np.array(r, dtype=float) if np.shape(r) == t.shape else np.full(t.shape, r, dtype=float)
        for r in results
    ]


def _digits_along(
    program: Program, which: int, t: np.ndarray, states: np.ndarray, values: Sequence[Any]
) -> list[np.ndarray]:
    """Extra quantities in many digits; not a number where a quantity has no value at an instant."""
    block = program.extras if which else program.derivative
    try:
        return compiled_digits(program)[which](t, list(states.T), list(values))
    except (ZeroDivisionError, ValueError):
        if which and len(block.results) > 1:
            alone = [
                replace(program, names=(name,), extras=prune(block.assignments, (result,)))
                for name, result in zip(program.names, block.results, strict=True)
            ]
            return [_digits_along(each, 1, t, states, values)[0] for each in alone]
        if len(t) < 2:
            return [np.full(t.shape, mpmath.nan, dtype=object)] * len(block.results)
        rows = [
            _digits_along(program, which, t[k : k + 1], states[k : k + 1], values)
            for k in range(len(t))
        ]
        return [np.concatenate(column) for column in zip(*rows, strict=True)]


def evaluate_watch(
    watch: ObservedQuantities,
    program: Program,
    t: np.ndarray,
    states: np.ndarray,
    values: Sequence[float],
) -> dict[str, np.ndarray]:
    """Everything watched at states (k, n), reactions too, by the names of ``watch``."""
    series = evaluate_extras(program, t, states, values)
    if len(t):
        series |= {name: branch.along(series) for name, branch in watch.branches.items()}
    if watch.multipliers is None:
        return series
    multipliers, lost = _multipliers(watch.multipliers, program, t, states, values, series)
    if lost.any():
        exactly = np.frompyfunc(mpmath.mpf, 1, 1)
        with mpmath.workprec(GENERIC), np.errstate(invalid="ignore"):  # constants without value
            there = exactly(states[lost]), list(exactly(np.asarray(values, dtype=float)))
            more = evaluate_extras(program, t[lost], *there)
            precise, _ = _multipliers(watch.multipliers, program, t[lost], *there, more)
        exact = precise.astype(float)
        multipliers[lost] = np.where(np.isfinite(exact), exact, multipliers[lost])
    plain = {name: x for name, x in series.items() if name not in watch.multipliers.entries}
    return plain | {name: multipliers[:, k].copy() for name, k in watch.reactions.items()}


def _multipliers(
    multipliers: Multipliers, program: Program, t: np.ndarray, states: np.ndarray,
    values: Sequence[Any], series: Mapping[str, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """The multipliers, and where digits are lost, from the program's extra quantities."""
    slopes = dict(zip(map(str, program.state), _along(program, 0, t, states, values), strict=True))
    with mpmath.workprec(max(precision(states), mpmath.mp.prec)):
        return multipliers.solve(
            {name: series[name] for name in multipliers.entries},
            [slopes[str(v)] for v in multipliers.velocities],
        )
