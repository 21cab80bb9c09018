"""Parameters and initial data in any precision: values given exactly are used exactly.

Doubles stay the doubles they are.  The velocities start from those found in doubles, and are moved
until the conditions on them hold to the last digit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from voronec.algebra.symbols import plain_name, velocity
from voronec.algebra.text import as_expression
from voronec.equations.program import Program
from voronec.equations.program.digits import compiled_digits
from voronec.errors import EngineLimit
from voronec.motion.vocabulary import Vocabulary

__all__ = ["Exactly", "exact_number"]

HOLDS = 1e-8
"""A condition that the start in doubles meets this well is one that it was made to meet."""
ROUNDS = 40


def exact_number(value: Any, known: Mapping[Any, Any], bits: int) -> Any:
    """A value as mpmath's number, with ``bits``; ``known`` gives symbols that it may contain."""
    if isinstance(value, mpmath.mpf):
        return value
    if isinstance(value, float | int):
        return mpmath.mpf(value)
    digits = int(bits * 0.302) + 5
    expr = as_expression(value).xreplace({s: sp.Float(x, digits) for s, x in known.items()})
    return mpmath.mp.make_mpf(sp.Float(expr.evalf(digits), digits)._mpf_)


@dataclass(frozen=True)
class Exactly:
    """What was given, and the start in doubles that came of it."""

    vocabulary: Vocabulary
    program: Program
    time: float
    parameters: Mapping[str, Any]
    scene: Mapping[str, Any]
    initial: Mapping[str, Any]
    start: np.ndarray
    projected: bool

    def constants(self, bits: int) -> dict[str, Any]:
        """The parameters by name."""
        result = {}
        for parameter in self.vocabulary.equations.system.parameters:
            value = self.parameters.get(parameter.name, parameter.value)
            if value is not None:
                result[parameter.name] = exact_number(value, {}, bits)
        return result

    def problem(self, bits: int) -> tuple[np.ndarray, list[Any]]:
        """The start (n,), and the values of the program's parameters."""
        with mpmath.workprec(bits):
            constants = self.constants(bits)
            values = [constants.get(str(p), mpmath.nan) for p in self.program.parameters]
            start = np.array([mpmath.mpf(x) for x in self.start], dtype=object)
            if self.projected:
                return start, values
            old, new = (self._numbers(part, constants, bits) for part in (self.scene, self.initial))
            names = [plain_name(q) for q in self.vocabulary.equations.system.coordinates]
            for i, name in enumerate(names):
                start[i] = {**old, **new}.get(name, mpmath.mpf(0))
            conditions = {k: x for k, x in {**old, **new}.items() if k not in names}
            return self._meet_conditions(start, len(names), conditions, values, {*new}), values

    def _numbers(
        self, given: Mapping[str, Any], constants: Mapping[str, Any], bits: int
    ) -> dict[str, Any]:
        known = {self.vocabulary.symbols[name]: x for name, x in constants.items()}
        return {name: exact_number(value, known, bits) for name, value in given.items()}

    def _meet_conditions(
        self,
        start: np.ndarray,
        n: int,
        conditions: Mapping[str, Any],
        values: Any,
        strict: set[str],
    ) -> np.ndarray:
        """The start with velocities that meet all conditions which it meets in doubles."""
        system = self.vocabulary.equations.system
        own = [plain_name(x) for x in system.velocities]
        dots = [plain_name(velocity(q)) for q in system.coordinates]
        rates, _ = compiled_digits(self.program)
        asked = not {*conditions} <= {*own}  # at poles of angles their rates are infinite

        def residuals(state: np.ndarray) -> list[Any]:
            try:
                slopes = rates(self.time, list(state), values)[:n] if asked else ()
            except ZeroDivisionError:
                raise EngineLimit(
                    f"system '{system.name}': velocities of coordinates do not tell the start to "
                    f"many digits at a pole of these; give {', '.join(own)}"
                ) from None
            found = dict(zip(dots, slopes, strict=asked))
            found |= zip(own, state[n:], strict=True)
            return [found[name] for name in conditions]

        wanted = list(conditions.values())
        first = residuals(start)
        scale = 1 + max(map(abs, wanted), default=0)
        held = [
            name in strict or abs(a - b) < HOLDS * scale
            for name, a, b in zip(conditions, first, wanted, strict=True)
        ]
        if not any(held):
            return start
        inverse = np.linalg.pinv(_slopes(residuals, start, n)[held])
        for _ in range(ROUNDS):
            gap = np.array([b - a for a, b in zip(residuals(start), wanted, strict=True)])[held]
            if max(map(abs, gap)) <= scale * mpmath.eps * 8:
                break
            start = start.copy()
            start[n:] += inverse.dot(gap)
        return start


def _slopes(reached: Callable[[np.ndarray], list[Any]], start: np.ndarray, n: int) -> np.ndarray:
    """Slopes of conditions by the velocities, entries from n on; they are affine in these, so unit
    steps tell them."""
    first, columns = reached(start), []
    for j in range(n, len(start)):
        step = start.copy()
        step[j] += 1
        columns.append([a - b for a, b in zip(reached(step), first, strict=True)])
    return np.array(columns, dtype=float).T
