"""Expressions with their slopes as one straight-line program, in doubles or in balls."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import flint
import numpy as np

from voronec.algebra.memo import Memo
from voronec.algebra.tape import Tape, as_ball
from voronec.equations.program import Block, Program, compile_program
from voronec.equations.program.jacobian import joint_block
from voronec.motion.request import number


@dataclass(frozen=True, eq=False)
class JointFunction:
    """The results (m,) of ``rows`` by ``unknowns`` (n,), and their slopes: those of ``joint``
    behind the values, at ``places`` of the Jacobian; the others are zero.  ``values`` are those
    of the ``arguments``, by name; what is compiled is shared by all."""

    time: Any
    unknowns: tuple[Any, ...]
    arguments: tuple[Any, ...]
    rows: Block
    joint: Block
    places: tuple[tuple[int, int], ...]
    values: Mapping[str, Any] = field(default_factory=dict)
    memo: Memo = field(default_factory=Memo, repr=False)

    @classmethod
    def of(
        cls, time: Any, symbols: Sequence[Any], rows: Block, unknowns: Sequence[Any]
    ) -> JointFunction:
        """Of a block in some symbols, of which the unknowns are some."""
        program = Program.of_block(time, symbols, rows)
        arguments = tuple(p for p in symbols if p not in unknowns)
        return cls(time, tuple(unknowns), arguments, rows, *joint_block(program, rows, unknowns))

    def with_values(self, values: Mapping[str, Any]) -> JointFunction:
        """The function where its arguments have values."""
        return replace(self, values=values)

    def _compile(self) -> Callable[[Any, Any, Any], list[Any]]:
        program = Program.of_block(self.time, self.unknowns, self.joint, self.arguments)
        return compile_program(program, scalar=True)[1]

    @cached_property
    def _doubles(self) -> list[float]:
        return [number(self.values[str(p)], f"parameter '{p}'") for p in self.arguments]

    def at(self, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The values (m,) and the Jacobian (m, n) in doubles; not finite where there is none."""
        m, n = len(self.rows.results), len(self.unknowns)
        function = self.memo.once("compiled", self._compile)
        try:
            outputs = np.array(function(0.0, y.tolist(), self._doubles), dtype=float)
        except (ZeroDivisionError, ValueError, OverflowError, TypeError):
            return np.full(m, np.nan), np.full((m, n), np.nan)
        slopes = np.zeros((m, n))
        for place, slope in zip(self.places, outputs[m:], strict=True):
            slopes[place] = slope
        return outputs[:m], slopes

    def _run_in_balls(self, block: Block, y: Sequence[Any], bits: int) -> list[Any]:
        steps, ends = self.memo.once(("tapes", block), lambda: _record(block))
        with flint.ctx.workprec(bits):
            known = {p: as_ball(self.values[str(p)]) for p in self.arguments}
            known |= dict(zip(self.unknowns, map(flint.arb, y), strict=True))
            for name, tape in steps:
                known[name] = tape.run(known, _constant)[0]
            outputs: list[Any] = ends.run(known, _constant)
            return outputs

    def balls(self, y: Sequence[Any], bits: int) -> list[Any]:
        """The values enclosed at balls y.  ``EngineLimit`` where a function has none in balls."""
        return self._run_in_balls(self.rows, y, bits)

    def slopes_in_balls(self, y: Sequence[Any], bits: int) -> Any:
        """The Jacobian enclosed at balls y, an ``arb_mat``."""
        m = len(self.rows.results)
        slopes = flint.arb_mat(m, len(self.unknowns))
        entries = self._run_in_balls(self.joint, y, bits)[m:]
        for place, slope in zip(self.places, entries, strict=True):
            slopes[place] = slope
        return slopes


def _record(block: Block) -> tuple[list[tuple[Any, Tape]], Tape]:
    return [(name, Tape([e])) for name, e in block.assignments], Tape(block.results)


def _constant(c: Any) -> Any:
    return c() if callable(c) else flint.arb(c)
