"""Expressions with their slopes as one straight-line program, in doubles or in balls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flint
import numpy as np
import symengine as se

from voronec.algebra.tape import Tape, as_ball
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.program.jacobian import joint_block
from voronec.motion.request import number


@dataclass(frozen=True, eq=False)
class JointFunction:
    """The results (m,) of ``rows`` by ``unknowns`` (n,), and their slopes: those of ``joint``
    behind the values, at ``places`` of the Jacobian; the others are zero.  ``arguments`` are
    the symbols that have values besides."""

    time: Any
    unknowns: tuple[Any, ...]
    arguments: tuple[Any, ...]
    rows: Block
    joint: Block
    places: tuple[tuple[int, int], ...]

    @classmethod
    def of(
        cls, time: Any, symbols: Sequence[Any], rows: Block, unknowns: Sequence[Any]
    ) -> JointFunction:
        """Of a block in some symbols, of which the unknowns are some."""
        program = Program(time, tuple(symbols), (), (), Block((), ()), (), rows)
        arguments = tuple(p for p in symbols if p not in unknowns)
        return cls(time, tuple(unknowns), arguments, rows, *joint_block(program, rows, unknowns))

    @cached_property
    def _function(self) -> Callable[[Any, Any, Any], list[Any]]:
        blank = Block((), (se.Integer(0),) * len(self.unknowns))
        names = tuple(f"entry {i}" for i in range(len(self.joint.results)))
        program = Program(self.time, self.unknowns, (), self.arguments, blank, names, self.joint)
        return compile_program(program, scalar=True)[1]

    def doubles(self, values: Mapping[str, Any]) -> list[float]:
        """The values of the arguments in doubles."""
        return [number(values[str(p)], f"parameter '{p}'") for p in self.arguments]

    def at(self, y: np.ndarray, given: list[float]) -> tuple[np.ndarray, np.ndarray]:
        """The values (m,) and the Jacobian (m, n), the arguments being those of ``doubles``; not
        finite where there is none."""
        m, n = len(self.rows.results), len(self.unknowns)
        try:
            found = np.array(self._function(0.0, y.tolist(), given), dtype=float)
        except (ZeroDivisionError, ValueError, OverflowError, TypeError):
            return np.full(m, np.nan), np.full((m, n), np.nan)
        slopes = np.zeros((m, n))
        for place, slope in zip(self.places, found[m:], strict=True):
            slopes[place] = slope
        return found[:m], slopes

    @cached_property
    def _tapes(self) -> dict[bool, tuple[list[tuple[Any, Tape]], Tape]]:
        """Of the values alone, and with slopes, as they are first asked for."""
        return {}

    def _run_in_balls(
        self, joint: bool, y: Sequence[Any], values: Mapping[str, Any], bits: int
    ) -> list[Any]:
        if joint not in self._tapes:
            block = self.joint if joint else self.rows
            steps = [(name, Tape([e])) for name, e in block.assignments]
            self._tapes[joint] = steps, Tape(block.results)
        steps, ends = self._tapes[joint]
        with flint.ctx.workprec(bits):
            known = {p: as_ball(values[str(p)]) for p in self.arguments}
            known |= dict(zip(self.unknowns, map(flint.arb, y), strict=True))
            for name, tape in steps:
                known[name] = tape.run(known, _constant)[0]
            found: list[Any] = ends.run(known, _constant)
            return found

    def balls(self, y: Sequence[Any], values: Mapping[str, Any], bits: int) -> list[Any]:
        """The values enclosed at balls y.  ``EngineLimit`` where a function has none in balls."""
        return self._run_in_balls(False, y, values, bits)

    def slopes_in_balls(self, y: Sequence[Any], values: Mapping[str, Any], bits: int) -> Any:
        """The Jacobian enclosed at balls y, an ``arb_mat``."""
        m = len(self.rows.results)
        slopes = flint.arb_mat(m, len(self.unknowns))
        found = self._run_in_balls(True, y, values, bits)[m:]
        for place, slope in zip(self.places, found, strict=True):
            slopes[place] = slope
        return slopes


def _constant(c: Any) -> Any:
    return c() if callable(c) else flint.arb(c)
