"""The names a user may say to the integrator, and what they mean inside."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.algebra.text import as_expression, in_doubles
from voronec.declaration.claims import right_of
from voronec.declaration.reading import expression, quote, quote_number, real_text
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.equations.voronec_equations import VoronecEquations

__all__ = ["OutputTerms", "Vocabulary", "held_name", "label", "number"]

CONFIGURATION = "configuration"
"""The output that stands for all coordinates: what an animation needs."""


def number(value: Any, place: str) -> float:
    """A finite real number as a double, or ``DefinitionError`` naming the place."""
    try:
        found = float(value) if isinstance(value, float | int) else _double(value, place)
    except (TypeError, ValueError, AttributeError):
        found = math.nan
    except OverflowError:
        raise DefinitionError(
            f"{place} = {quote_number(value)} is not a real number that a double holds"
        ) from None
    if math.isfinite(found):
        return found
    raise DefinitionError(
        f"{place} = {quote(value)} is not {'finite' if math.isinf(found) else 'a real number'}"
    )


def _double(value: Any, place: str) -> float:
    try:
        read = real_text(value, place) if isinstance(value, str) else as_expression(value, place)
    except DefinitionError:
        if isinstance(value, str):
            raise
        return math.nan
    in_doubles(read)  # refuses what could not be computed
    exact = read.evalf(25)
    # what is not zero must not pass for it: zeros may be frozen
    return float(exact) or math.copysign(5e-324, exact) if exact != 0 else 0.0


def label(expr: sp.Expr) -> str:
    """What a symbol, a velocity or an expression is called."""
    bare = expr.expr if isinstance(expr, sp.Derivative) else expr
    return plain_name(expr) if is_symbolic_name(bare) else str(expr)


def held_name(key: Any, held: Iterable[str], holder: str) -> str:
    """The name of something that a result holds, asked for by name, symbol or expression.

    ``DefinitionError`` where it is not there; ``holder`` begins the message: "the section holds".
    """
    name = key if isinstance(key, str) else label(as_expression(key, "what is asked for"))
    known = list(held)
    if name not in known:
        raise DefinitionError(
            f"{holder} no '{quote(name)}', ask for it in outputs=(...){did_you_mean(name, known)}"
        )
    return name


@dataclass(frozen=True)
class OutputTerms:
    """Outputs spelled out.

    ``names`` in the order asked for, each once; what each is: ``given``, in the user's symbols,
    those of invariants among them, and ``expressions``, the same inside the door, in coordinates,
    velocities, time and parameters; or ``reactions``, positions of constraints, which need the
    accelerations too (``voronec.motion.reactions.Multipliers``).
    """

    names: tuple[str, ...]
    given: Mapping[str, sp.Expr]
    expressions: Mapping[str, Any]
    reactions: Mapping[str, int]


@dataclass(frozen=True)
class Vocabulary:
    """Names of one system: coordinates, velocities, parameters; what follows from these, such as
    integrals, invariants, and the dependent velocities and momenta of a group."""

    equations: VoronecEquations
    symbols: Mapping[str, sp.Expr]
    claims: Mapping[str, sp.Expr]
    inputs: Mapping[sp.Expr, sp.Expr] = field(default_factory=dict)

    @classmethod
    def of(
        cls, equations: VoronecEquations, inputs: Mapping[sp.Expr, sp.Expr] | None = None
    ) -> Vocabulary:
        """The vocabulary of a system's equations; ``inputs`` are what stands for those that the
        system was declared with, and for their rates."""
        system = equations.system
        dots = [velocity(q) for q in system.coordinates]
        constants = [p.symbol for p in system.parameters]
        things = [*system.coordinates, *system.velocities, *dots, *constants, time]
        symbols = {plain_name(s): s for s in things}
        integrals = {name: right_of(claim) for name, claim in system.integrals.items()}
        frame = system.frame
        others = (*frame.fibre, *frame.momenta) if frame is not None else ()
        named = {plain_name(x): x for x in others}
        claims = {**system.invariants, **named, **integrals}
        return cls(equations, symbols, claims, dict(inputs or {}))

    @property
    def known(self) -> dict[str, sp.Expr]:
        """Everything that has a name, but for reactions and groups."""
        system = self.equations.system
        invariants = dict(zip(system.invariants, system.invariant_symbols, strict=True))
        driven = {plain_name(u): e for u, e in self.inputs.items()}
        return {**self.claims, **invariants, **self.symbols, **driven}

    @property
    def reactions(self) -> dict[str, int]:
        """``reaction k`` is lambda_k of constraint k; positions count from 0.

        It is the multiplier of ``voronec.reaction_forces``: A^T lambda is what the constraints do,
        in units of dL/dq.
        """
        return {f"reaction {k + 1}": k for k in range(len(self.equations.system.constraints))}

    @property
    def groups(self) -> dict[str, tuple[Any, ...]]:
        """Outputs that stand for several: the whole configuration, and each trace of a contact that
        the system draws."""
        system = self.equations.system
        own = system.drawing if isinstance(system.drawing, Mapping) else {}
        traces = {title: tuple(names) for title, names in own.items() if isinstance(title, str)}
        return {CONFIGURATION: system.coordinates, **traces}

    def read_outputs(self, outputs: Iterable[Any]) -> OutputTerms:
        """Outputs spelled out; where there are none, all coordinates and velocities.

        Each is a name, a symbol or an expression; ``reaction k``, ``configuration``, or the title
        of a contact's trace.  A quantity of the system comes before these where names agree.
        """
        system = self.equations.system
        reactions, groups = self.reactions, self.groups
        own = self.known
        keys = tuple(outputs) or (*system.coordinates, *system.velocities)
        spelled: dict[str, sp.Expr | None] = {}
        chosen: dict[str, int] = {}
        for key in keys:
            name = key if isinstance(key, str) and key not in own else ""
            if name in reactions:
                chosen[name] = reactions[name]
                spelled[name] = None
            else:
                spelled |= map(self.read_condition, groups.get(name, (key,)))
        given = {name: e for name, e in spelled.items() if e is not None}
        inside = {name: self.inward(e) for name, e in given.items()}
        return OutputTerms(tuple(spelled), given, inside, chosen)

    def name(self, key: Any, among: Iterable[str], role: str) -> str:
        """The plain name of a symbol or name, which must be among some."""
        name = key if isinstance(key, str) else self._plain(key, role)
        allowed = list(among)
        if name not in allowed:
            raise DefinitionError(
                f"system '{self.equations.system.name}' has no {role} '{quote(name)}'"
                f"{did_you_mean(name, allowed)}"
            )
        return name

    def quantity(self, key: Any) -> tuple[str, Any]:
        """A single output: what it is called, and its expression inside.

        ``key`` is a name, a symbol, or an expression in them.
        """
        name, expr = self.read_condition(key)
        return name, self.inward(expr)

    def read_condition(self, key: Any) -> tuple[str, sp.Expr]:
        """The same with the expression in the user's symbols, those of invariants among them."""
        system, known = self.equations.system, self.known
        if isinstance(key, str):
            name = self.name(key, [*known, *self.reactions, *self.groups], "output")
            if name not in known:
                raise DefinitionError(
                    f"system '{system.name}': '{name}' is no single expression; ask for it as an "
                    "output of its own"
                )
            return name, known[name]
        given = expression(key, f"system '{system.name}': an output")
        if given in self.inputs:
            return plain_name(given), self.inputs[given]
        expr = given.xreplace(self.inputs)
        for symbol in sorted(expr.free_symbols, key=str):
            if str(symbol) not in {*self.symbols, *system.invariants}:
                raise DefinitionError(
                    f"system '{system.name}': the output '{given}' contains '{symbol}'"
                    f"{did_you_mean(str(symbol), [*self.symbols, *system.invariants])}"
                )
        name = label(given)
        if expr not in system.invariant_symbols and (name != str(given) or name in self.symbols):
            name = self.name(name, self.symbols, "output")
            return name, self.symbols[name]
        return name, expr

    def inward(self, expr: Any) -> Any:
        """A user's expression inside the door, its invariants spelled out."""
        system = self.equations.system
        meaning = dict(zip(system.invariant_symbols, system.invariants.values(), strict=True))
        return self.equations.door.inward(as_expression(expr).xreplace(meaning))

    def _plain(self, key: Any, role: str) -> str:
        try:
            return plain_name(as_expression(key, f"the {role}"))
        except DefinitionError:
            raise DefinitionError(
                f"system '{self.equations.system.name}': '{quote(key)}' names no {role}; give a "
                "symbol or its name"
            ) from None
