"""A question on one level of description, as a program: what the peers compute with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import symengine as se
import sympy as sp

from voronec.accuracy.bench.question import BenchMotion
from voronec.algebra.text import as_expression
from voronec.declaration.claims import right_of
from voronec.equations.program import Program, compile_program
from voronec.equations.vector_field import VectorField
from voronec.errors import EngineLimit, VoronecError

__all__ = ["BenchLevel", "level", "lowest"]

DIGITS = 60
"""With how many digits the start on the invariants is computed from the doubles given."""
NOTHING = 1e-9
"""An integral that starts below this is compared absolutely."""


@dataclass(frozen=True, eq=False)
class BenchLevel:
    """The equations of a question on ``coordinates`` or on ``invariants``.

    ``program`` computes the derivative of the state (n,), and as extras the outputs, then the
    integrals that have a meaning here.  ``start`` holds mpmath numbers: on the invariants they
    are functions of the doubles given, and a reference needs them exactly.
    """

    field: VectorField
    program: Program
    start: tuple[Any, ...]
    constants: tuple[float, ...]
    outputs: tuple[str, ...]
    integrals: tuple[str, ...]

    @property
    def name(self) -> str:
        """``coordinates`` or ``invariants``."""
        return self.field.level

    @property
    def state(self) -> np.ndarray:
        """The start as doubles (n,)."""
        return np.array([float(x) for x in self.start])

    def outputs_and_drift(
        self, t: np.ndarray, states: np.ndarray
    ) -> tuple[dict[str, np.ndarray], dict[str, float]]:
        """Outputs, each of shape (k,), and the drift of each integral, at states (k, n)."""
        _, extras = compile_program(self.program)
        with np.errstate(all="ignore"):
            rows = extras(t, list(states.T), list(self.constants))
        arrays = [np.broadcast_to(np.asarray(r, dtype=float), t.shape) for r in rows]
        named = dict(zip(self.program.names, arrays, strict=True))
        drifts = {n: drift(named[f"integral {n}"]) for n in self.integrals}
        return {n: named[n] for n in self.outputs}, drifts


def drift(values: np.ndarray) -> float:
    """The largest change of a constant of the motion, relative to its start where that is not 0."""
    size = abs(values[0]) if abs(values[0]) > NOTHING else 1.0
    return float(np.abs(values - values[0]).max() / size)


def level(question: BenchMotion, name: str) -> BenchLevel:
    """The question on a level; ``EngineLimit`` where it or an output has no meaning there."""
    if name == "invariants" and not question.system.invariants:
        raise EngineLimit(f"system '{question.system.name}' declares no invariants")
    field = question.motions.at(name)
    wanted = {key: _read(field, question.expressions[key]) for key in question.outputs}
    integrals = []
    for key, claim in question.system.integrals.items():
        try:
            wanted[f"integral {key}"] = _read(field, right_of(claim))
        except VoronecError:
            continue
        integrals.append(key)
    program = Program.of(field.form, wanted)
    return BenchLevel(
        field=field,
        program=program,
        start=_start(question, field),
        constants=tuple(question.parameters.get(str(p), np.nan) for p in program.parameters),
        outputs=question.outputs,
        integrals=tuple(integrals),
    )


def lowest(question: BenchMotion) -> BenchLevel:
    """The question on the invariants where that works, else on the coordinates."""
    try:
        return level(question, "invariants")
    except VoronecError:
        return level(question, "coordinates")


def _read(field: VectorField, expr: Any) -> Any:
    return field.read(as_expression(expr))


def _start(question: BenchMotion, field: VectorField) -> tuple[Any, ...]:
    names = {str(s): s for s in field.variables}
    if field.level == "coordinates":
        return tuple(mpmath.mpf(question.initial[name]) for name in names)
    numbers: Mapping[str, float] = {**question.parameters, **question.initial}
    with mpmath.workdps(DIGITS):
        return tuple(_value(question, numbers, name) for name in names)


def _value(question: BenchMotion, numbers: Mapping[str, float], name: str) -> Any:
    """A velocity as given, or an invariant computed from the coordinates."""
    system = question.system
    if name not in system.invariants:
        return mpmath.mpf(numbers[name])
    inside = question.equations.door.inward(system.invariants[name])
    known: Sequence[Any] = sorted(inside.free_symbols, key=str)
    function = sp.lambdify([sp.Symbol(str(s)) for s in known], _plain(inside), "mpmath")
    return mpmath.mpf(function(*(mpmath.mpf(numbers[str(s)]) for s in known)))


def _plain(inside: Any) -> sp.Expr:
    return as_expression(inside.xreplace({s: se.Symbol(str(s)) for s in inside.free_symbols}))
