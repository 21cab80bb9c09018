"""Constants of a system, and motions of it to look at: declarations only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from voronec.algebra.symbols import is_symbolic_name, plain_name
from voronec.errors import DefinitionError
from voronec.reading import mapping, real_number, shown

__all__ = ["Parameter", "Scene"]


@dataclass(frozen=True)
class Parameter:
    """A constant of a system: its symbol, a default value, the range it may take.

    ``lower`` and ``upper`` are bounds that a value must not pass; ``positive`` asks for a value
    above zero.  ``meaning`` says in words what the constant is.  An unknown function of the time,
    ``f(t)``, is a parameter too: it is carried along exactly, and has no value.
    """

    symbol: sp.Expr
    value: Any = None
    positive: bool = False
    lower: Any = None
    upper: Any = None
    meaning: str = ""

    def __post_init__(self) -> None:
        if not is_symbolic_name(self.symbol):
            raise DefinitionError(
                f"parameter '{shown(self.symbol)}' is not a symbol; use sympy.Symbol"
            )
        for bound in ("lower", "upper"):
            if getattr(self, bound) is not None:
                real_number(getattr(self, bound), f"parameter '{self.name}': {bound}")
        if self.value is not None:
            self.check(self.value)

    @property
    def name(self) -> str:
        """The parameter's name."""
        return plain_name(self.symbol)

    def check(self, value: Any) -> None:
        """Raise ``DefinitionError`` where ``value`` lies outside the declared range."""
        number = real_number(value, f"parameter '{self.name}'")
        if self.positive and not number > 0:
            raise DefinitionError(f"parameter '{self.name}' = {value} must be positive")
        if self.lower is not None and number < sp.sympify(self.lower):
            raise DefinitionError(f"parameter '{self.name}' = {value} is below {self.lower}")
        if self.upper is not None and number > sp.sympify(self.upper):
            raise DefinitionError(f"parameter '{self.name}' = {value} is above {self.upper}")


@dataclass(frozen=True)
class Scene:
    """One motion to look at: initial data, a time span, and what is wanted from it.

    ``initial`` gives coordinates and velocities (quasi-velocities of the frame, or velocities of
    coordinates, which must agree with the constraints) by symbol or name; what is not named starts
    at zero.  ``parameters`` overrides defaults.  ``times`` is ``(start, end)``; the end may come
    first.

    ``outputs`` are what is wanted, and nothing else need be computed: coordinates, velocities,
    invariants, integrals by name, expressions in the first three, ``configuration`` (all
    coordinates), the title of a contact's trace in the drawing, ``reaction k`` (the multiplier of
    constraint k, from 1).  Empty means all coordinates and velocities.  ``caption`` says in a
    sentence what there is to see.
    """

    initial: Mapping[Any, Any]
    times: tuple[float, float] = (0.0, 10.0)
    parameters: Mapping[Any, Any] = field(default_factory=dict)
    outputs: tuple[Any, ...] = ()
    caption: str = ""

    def __post_init__(self) -> None:
        mapping(self.initial, "initial", "coordinate or velocity: value")
        mapping(self.parameters, "parameters", "parameter: value")
