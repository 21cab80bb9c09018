"""What parameters alone give, computed once instead of at every step.

Compilers of Taylor's method take a quotient of parameters for a moving quantity.  So such
expressions become parameters themselves; the program can still be run with other values, without
being compiled again.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import symengine as se

from voronec.equations.program.python import compile_program
from voronec.equations.program.straight import Block, Program

__all__ = ["HoistedProgram", "hoist"]


@dataclass(frozen=True)
class HoistedProgram:
    """A ``program`` whose further parameters ``constants`` are functions of those of the original.

    ``definitions`` gives them in order; each may use those before it.
    """

    program: Program
    original: Program
    definitions: tuple[tuple[Any, Any], ...]

    def values(self, parameters: Sequence[Any]) -> list[Any]:
        """Values for the parameters of ``program``, from those of the original.

        What cannot be computed (a parameter is missing, a quotient has no value) is nan, as it
        is in the equations.
        """
        given = list(parameters)
        try:
            return [*given, *self._function(0.0, (), given)]
        except (ZeroDivisionError, ValueError, OverflowError):
            return self._one_by_one(given)

    @cached_property
    def _function(self) -> Any:
        names = [name for name, _ in self.definitions]
        return _compile(self.original, self.original.parameters, self.definitions, names)

    def _one_by_one(self, given: list[Any]) -> list[Any]:
        """The same where some have no value."""
        known = list(self.original.parameters)
        for name, expr in self.definitions:
            function = _compile(self.original, known, (), [expr])
            try:
                given += function(0.0, (), given)
            except (ZeroDivisionError, ValueError, OverflowError):
                given.append(float("nan"))
            known.append(name)
        return given


def _compile(
    program: Program, known: Sequence[Any], assignments: Sequence[Any], results: Sequence[Any]
) -> Any:
    """A function of (0, (), parameters)."""
    names = tuple(f"_{i}" for i in range(len(results)))
    block = Block(tuple(assignments), tuple(results))
    return compile_program(
        Program(program.time, (), (), tuple(known), Block((), ()), names, block), scalar=True
    )[1]


@lru_cache(maxsize=32)  # a run looks at the constants before it compiles with them
def hoist(program: Program) -> HoistedProgram:
    """The program with every largest expression of parameters and numbers as one parameter.

    A sum whose terms share such a factor is written as factor times sum.
    """
    lifting = _Lifting(program)
    derivative, extras = lifting.block(program.derivative), lifting.block(program.extras)
    definitions = tuple((name, e) for e, name in lifting.names.items())
    parameters = (*program.parameters, *(name for name, _ in definitions))
    changed = replace(program, parameters=parameters, derivative=derivative, extras=extras)
    return HoistedProgram(changed, program, definitions)


class _Lifting:
    """One walk over a program; ``names`` maps each expression of constants to its name."""

    def __init__(self, program: Program) -> None:
        self.names: dict[Any, Any] = {}
        self._still: set[Any] = set(program.parameters)
        self._memo: dict[Any, Any] = {}
        blocks = (program.derivative, program.extras)
        taken = {*map(str, (*program.state, *program.parameters, program.time))}
        taken |= {str(n) for b in blocks for n, _ in b.assignments}
        self._prefix = next(p for p in ("k", "kk", "kkk", "const_") if not _clash(p, taken))

    def block(self, block: Block) -> Block:
        """The same assignments without those that are constant."""
        kept = []
        self._memo = {}  # each block has names of its own, which may be those of another
        for name, expr in block.assignments:
            changed = self.of(expr)
            if changed.free_symbols <= self._still:  # a name for a constant, or for a number
                self._memo[name] = changed
            else:
                kept.append((name, changed))
        return Block(tuple(kept), tuple(self.of(se.sympify(r)) for r in block.results))

    def of(self, expr: Any) -> Any:
        """An expression with its constants by name."""
        done = self._memo.get(expr)
        if done is None:
            done = self._memo[expr] = self._of(expr)
        return done

    def _of(self, expr: Any) -> Any:
        if not expr.args or expr.is_Number:
            return expr
        args = [self.of(a) for a in expr.args]
        if isinstance(expr, se.Mul):
            return self._product(args)
        if isinstance(expr, se.Add):
            return self._sum(args)
        whole = expr.func(*args)
        return self._name_constant(whole) if whole.free_symbols <= self._still else whole

    def _product(self, args: Iterable[Any]) -> Any:
        """Constant factors together, as one; into a sum whose terms all have constants anyway."""
        still, moving = self._split_constant(se.Mul(*args))
        if still.free_symbols and isinstance(moving, se.Add):
            parts = [self._split_constant(term) for term in moving.args]
            if all(c.free_symbols for c, _ in parts):
                return se.Add(*[self._times(still * c, m) for c, m in parts])
        return self._times(still, moving)

    def _sum(self, args: Iterable[Any]) -> Any:
        """Constant terms together; a factor that all terms share stands before them."""
        total = se.Add(*args)
        if not isinstance(total, se.Add):
            return self.of(total) if total.args else total
        parts = [self._split_constant(term) for term in total.args]
        still = self._name_constant(se.Add(*[c for c, m in parts if m == 1]))
        moving = [(c, m) for c, m in parts if m != 1]
        if not moving:
            return still
        first = moving[0][0]
        ratios = [c / first for c, _ in moving]
        shared = still == 0 and first.free_symbols and all(r.is_Number for r in ratios)
        if len(moving) > 1 and shared:
            inner = se.Add(*[r * m for r, (_, m) in zip(ratios, moving, strict=True)])
            return self._name_constant(first) * inner
        return se.Add(still, *[self._times(c, m) for c, m in moving])

    def _split_constant(self, term: Any) -> tuple[Any, Any]:
        """A term as constant times what moves, the constant in the original's parameters."""
        factors = term.args if isinstance(term, se.Mul) else [term]
        still = [f for f in factors if f.free_symbols <= self._still]
        moving = [f for f in factors if not f.free_symbols <= self._still]
        return se.Mul(*still), se.Mul(*moving)

    def _times(self, still: Any, moving: Any) -> Any:
        if moving == 1:
            return self._name_constant(still)
        return self._name_constant(still) * moving

    def _name_constant(self, expr: Any) -> Any:
        """A constant by its name; numbers and single parameters have theirs."""
        if expr.is_Number or not expr.args:
            return expr
        if expr not in self.names:
            name = se.Symbol(f"{self._prefix}{len(self.names)}")
            self.names[expr] = name
            self._still.add(name)
        return self.names[expr]


def _clash(prefix: str, taken: Iterable[str]) -> bool:
    return any(t.startswith(prefix) and t[len(prefix) :].isdigit() for t in taken)
