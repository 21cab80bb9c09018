"""The program of a case in the states that its outputs need, on coordinates or on invariants."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import mpmath
import sympy as sp

from voronec.accuracy.hard.case import HardCase
from voronec.algebra.graphs import nodes
from voronec.algebra.symbols import plain_name
from voronec.algebra.text import as_expression
from voronec.equations.derivation import FirstOrderForm
from voronec.equations.motions import Motions
from voronec.equations.program import Block, Program
from voronec.equations.voronec_equations import VoronecEquations
from voronec.errors import DefinitionError
from voronec.motion.request import Vocabulary

__all__ = ["PreciseProblem", "problem"]

DIGITS = 45
"""Digits of the initial data of a reference."""


@dataclass(frozen=True)
class PreciseProblem:
    """An initial-value problem in many digits.

    ``places`` are the positions, in the state of ``program``, of the states that the outputs need;
    ``start`` (all states) and ``values`` (all parameters) are mpmath numbers; ``angles`` are
    the positions of the states that occur under a trigonometric function.
    """

    program: Program
    places: tuple[int, ...]
    angles: frozenset[int]
    start: tuple[Any, ...]
    values: tuple[Any, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The states that are kept."""
        return tuple(str(self.program.state[i]) for i in self.places)


def problem(case: HardCase, equations: VoronecEquations, raw: bool = False) -> PreciseProblem:
    """The closed problem of a case; ``raw`` takes the unsimplified form, an independent program."""
    vocabulary = Vocabulary.of(equations)
    constants = _numbers(case.scene.parameters)
    for parameter in equations.system.parameters:
        if parameter.value is not None:
            constants.setdefault(parameter.name, _number(parameter.value))
    begun = _numbers(case.scene.initial)
    outputs = case.scene.outputs
    if case.level == "invariants":
        form, wanted, meaning = _on_invariants(equations, outputs)
    else:
        form = equations.raw.form if raw else equations.form
        wanted, meaning = dict(vocabulary.quantity(key) for key in outputs), {}
    program = Program.of(form, wanted)
    start = _start(case, program, meaning, begun | constants)
    missing = [str(p) for p in program.parameters if str(p) not in constants]
    values = tuple(constants.get(str(p), mpmath.mpf(0)) for p in program.parameters)
    if missing and {*missing} & {str(s) for s in program.derivative.symbols}:
        raise DefinitionError(f"hard case '{case.name}': no value for {', '.join(missing)}")
    return PreciseProblem(program, _dependencies(program), _angles(program), start, values)


def _on_invariants(
    equations: VoronecEquations, outputs: Iterable[Any]
) -> tuple[FirstOrderForm, dict[str, Any], Mapping[str, Any]]:
    """The reduced form, the outputs on it, and the invariants in terms of the coordinates."""
    motions, vocabulary = Motions.of(equations), Vocabulary.of(equations)
    field, system = motions.on_invariants, equations.system
    alike = {str(m): sp.Symbol(g) for g, m in system.invariants.items()}
    alike |= {str(-m): -sp.Symbol(g) for g, m in system.invariants.items()}
    wanted = {}
    for key in outputs:
        name = key if isinstance(key, str) else vocabulary.quantity(key)[0]
        named = vocabulary.symbols.get(name, vocabulary.claims.get(name))
        own = sp.Symbol(name) if name in system.invariants else named
        wanted[name] = field.read(alike.get(str(key), as_expression(key)) if own is None else own)
    return field.form, wanted, system.invariants


def _start(
    case: HardCase, program: Program, meaning: Mapping[str, Any], known: Mapping[str, Any]
) -> tuple[Any, ...]:
    """The initial state: what nobody names is zero."""
    system_names = {str(s) for s in program.state}
    allowed = system_names if not meaning else None
    stray = [str(k) for k in case.scene.initial if allowed is not None and _plain(k) not in allowed]
    if stray:
        raise DefinitionError(
            f"hard case '{case.name}': '{stray[0]}' is neither a coordinate nor a velocity of the "
            "equations; give those"
        )
    return tuple(_initial(str(s), meaning, known) for s in program.state)


def _initial(name: str, meaning: Mapping[str, Any], known: Mapping[str, Any]) -> Any:
    if name not in meaning:
        return known.get(name, mpmath.mpf(0))
    expr = as_expression(meaning[name])
    digits = {s: sp.Float(known.get(str(s), 0), DIGITS) for s in expr.free_symbols}
    return _number(expr.xreplace(digits))


def _numbers(given: Mapping[Any, Any]) -> dict[str, Any]:
    return {_plain(key): _number(value) for key, value in given.items()}


def _plain(key: Any) -> str:
    return key if isinstance(key, str) else plain_name(key)


def _number(value: Any) -> Any:
    """A real number in many digits; a float is the double that it is."""
    with mpmath.workdps(DIGITS):
        if isinstance(value, float | int):
            return mpmath.mpf(value)
        return mpmath.mpf(sp.Float(as_expression(value).evalf(DIGITS), DIGITS)._mpf_)


def _dependencies(program: Program) -> tuple[int, ...]:
    """The states on which the outputs depend, through however many others."""
    place = {s: i for i, s in enumerate(program.state)}
    rows = _dependence(program.derivative, place)
    found = set().union(*_dependence(program.extras, place))
    while True:
        more = found.union(*(rows[i] for i in found))
        if more == found:
            return tuple(sorted(found))
        found = more


def _dependence(block: Block, place: Mapping[Any, int]) -> list[set[int]]:
    """For every result, the positions of the states that occur in it."""
    reach = _reach(block, place)
    return [set().union(*(reach.get(s, set()) for s in r.free_symbols)) for r in block.results]


def _reach(block: Block, place: Mapping[Any, int]) -> dict[Any, set[int]]:
    """For every name in a program, the positions of what it holds, through whatever others."""
    reach: dict[Any, set[int]] = {s: {i} for s, i in place.items()}
    for name, expr in block.assignments:
        reach[name] = set().union(*(reach.get(s, set()) for s in expr.free_symbols))
    return reach


def _angles(program: Program) -> frozenset[int]:
    """The coordinates that occur, through whatever names, under a sine or a cosine."""
    place = {q: i for i, q in enumerate(program.coordinates)}
    found: set[int] = set()
    for block in (program.derivative, program.extras):
        reach = _reach(block, place)
        for node in nodes(block.expressions):
            if type(node).__name__ in ("sin", "cos", "tan", "cot"):
                found = found.union(*(reach.get(s, set()) for s in node.free_symbols))
    return frozenset(found)
