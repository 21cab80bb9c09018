"""The names a user may say to the integrator, and what they mean inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name, time, velocity
from voronec.claims import right_of
from voronec.errors import DefinitionError, did_you_mean

if TYPE_CHECKING:
    from voronec.equations import VoronecEquations

__all__ = ["Vocabulary", "label", "number"]


def number(value: Any, place: str) -> float:
    """A real number as a double, or ``DefinitionError`` naming the place."""
    if isinstance(value, float | int):
        return float(value)
    try:
        return float(sp.sympify(value).evalf(25))
    except (TypeError, ValueError, sp.SympifyError, AttributeError):
        raise DefinitionError(f"{place} = {value} is not a real number") from None


def label(expr: sp.Expr) -> str:
    """What a symbol, a velocity or an expression is called."""
    bare = expr.expr if isinstance(expr, sp.Derivative) else expr
    return plain_name(expr) if is_symbolic_name(bare) else str(expr)


@dataclass(frozen=True)
class Vocabulary:
    """Names of one system: coordinates, velocities, parameters; what follows from these, such as
    integrals, invariants, and the dependent velocities and momenta of a group."""

    equations: VoronecEquations
    symbols: Mapping[str, sp.Expr]
    claims: Mapping[str, sp.Expr]

    @classmethod
    def of(cls, equations: VoronecEquations) -> Vocabulary:
        """The vocabulary of a system's equations."""
        system = equations.system
        dots = [velocity(q) for q in system.coordinates]
        constants = [p.symbol for p in system.parameters]
        things = [*system.coordinates, *system.velocities, *dots, *constants, time]
        symbols = {plain_name(s): s for s in things}
        integrals = {name: right_of(claim) for name, claim in system.integrals.items()}
        frame = system.frame
        others = (*frame.fibre, *frame.momenta) if frame is not None else ()
        named = {plain_name(x): x for x in others}
        return cls(equations, symbols, {**system.invariants, **named, **integrals})

    def name(self, key: Any, among: Iterable[str], role: str) -> str:
        """The plain name of a symbol or name, which must be among some."""
        name = key if isinstance(key, str) else self._plain(key, role)
        allowed = list(among)
        if name not in allowed:
            raise DefinitionError(
                f"system '{self.equations.system.name}' has no {role} '{name}'"
                f"{did_you_mean(name, allowed)}"
            )
        return name

    def quantity(self, key: Any) -> tuple[str, Any]:
        """An output: what it is called, and its expression inside.

        ``key`` is a name, a symbol, or an expression in them.
        """
        system = self.equations.system
        if isinstance(key, str):
            name = self.name(key, [*self.symbols, *self.claims], "output")
            return name, self.inward(self.symbols.get(name, self.claims.get(name)))
        expr = sp.sympify(key)
        for symbol in sorted(expr.free_symbols, key=str):
            if str(symbol) not in {*self.symbols, *system.invariants}:
                raise DefinitionError(
                    f"system '{system.name}': the output '{expr}' contains '{symbol}'"
                    f"{did_you_mean(str(symbol), self.symbols)}"
                )
        name = label(expr)
        if expr in system.invariant_symbols:
            return name, self.inward(expr)
        if name != str(expr) or name in self.symbols:
            name = self.name(name, self.symbols, "output")
            return name, self.inward(self.symbols[name])
        return name, self.inward(expr)

    def inward(self, expr: Any) -> Any:
        """A user's expression inside the door, its invariants spelled out."""
        system = self.equations.system
        meaning = dict(zip(system.invariant_symbols, system.invariants.values(), strict=True))
        return self.equations.door.inward(sp.sympify(expr).xreplace(meaning))

    def _plain(self, key: Any, role: str) -> str:
        try:
            return plain_name(sp.sympify(key))
        except (DefinitionError, sp.SympifyError):
            raise DefinitionError(
                f"system '{self.equations.system.name}': '{key}' names no {role}; give a symbol "
                "or its name"
            ) from None
